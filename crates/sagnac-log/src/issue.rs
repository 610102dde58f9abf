//! A finding about the quality of a log: kind, channel, span, count and a sentence.

/// The kinds of finding, named as in the JSON output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(
    missing_docs,
    reason = "the names are the documentation; `IssueKind::name` gives the text"
)]
pub enum IssueKind {
    Gap,
    Duplicate,
    Backwards,
    Jitter,
    Nan,
    Saturation,
    Stuck,
    Units,
    Motion,
    Step,
    WarmUp,
    NonStationary,
    Filtered,
    Quantization,
    BiasRemoved,
    Line,
    Short,
    EarthRate,
}

impl IssueKind {
    /// The kind's name in JSON and text.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gap => "gap",
            Self::Duplicate => "duplicate",
            Self::Backwards => "backwards",
            Self::Jitter => "jitter",
            Self::Nan => "nan",
            Self::Saturation => "saturation",
            Self::Stuck => "stuck",
            Self::Units => "units",
            Self::Motion => "motion",
            Self::Step => "step",
            Self::WarmUp => "warm_up",
            Self::NonStationary => "non_stationary",
            Self::Filtered => "filtered",
            Self::Quantization => "quantization",
            Self::BiasRemoved => "bias_removed",
            Self::Line => "line",
            Self::Short => "short",
            Self::EarthRate => "earth_rate",
        }
    }

    /// True for the kinds that are told as notes, not as warnings.
    pub const fn is_note(self) -> bool {
        matches!(
            self,
            Self::Quantization | Self::Line | Self::Filtered | Self::EarthRate
        )
    }

    /// True for the kinds that `--strict` turns into an error.
    pub const fn is_strict_error(self) -> bool {
        !matches!(self, Self::Quantization | Self::Line | Self::EarthRate)
    }
}

/// One finding about a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Issue {
    /// What was found.
    pub kind: IssueKind,
    /// `time`, a channel's name, or `None` for the whole log.
    pub channel: Option<String>,
    /// Start, in seconds of the log's `time` (of the sample grid where there is none).
    pub start_s: f64,
    /// End, same clock.
    pub end_s: f64,
    /// Samples concerned (for `gap`: samples lost).
    pub count: u64,
    /// The sentence, without full stop.
    pub text: String,
}
