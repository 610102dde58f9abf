//! What the joint estimate takes and gives: data in segments, estimates with intervals and status, regressors, findings.
//!
//! Everything is SI: a gyro axis in rad/s, an accelerometer axis in m/s²; densities are two-sided.

use std::ops::Range;

/// A stretch of samples of one axis without a gap, each the mean over one step.
#[derive(Debug, Clone, Copy)]
pub struct Segment<'a> {
    /// Start of the first sample's interval, in seconds from the log's first sample.
    pub start_s: f64,
    /// The samples [unit of the axis], equally spaced.
    pub samples: &'a [f64],
    /// Runs of samples that were lost and filled by the line between their neighbors, ascending and apart, each with a
    /// sample on both sides; empty where none was.
    pub filled: &'a [Range<usize>],
}

/// One log of one axis, as the joint estimate takes it.
#[derive(Debug, Clone, Copy)]
pub struct AxisData<'a> {
    /// The segments in order of time; samples lost between them only cost their own information.
    pub segments: &'a [Segment<'a>],
    /// Temperature [°C] of the same samples: the same segments, with the same lengths.
    pub temperature: Option<&'a [Segment<'a>]>,
    /// Step between samples \[s\].
    pub step_s: f64,
    /// Step of the values' grid [unit of the axis] (the size of one count), where there is one.
    pub lsb: Option<f64>,
}

/// A term of the joint estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Term {
    /// Quantization noise Q.
    Quantization,
    /// White noise N (angle or velocity random walk).
    White,
    /// Flicker noise B (bias instability).
    Flicker,
    /// Random walk K (rate or acceleration random walk).
    RandomWalk,
    /// Ramp R.
    Ramp,
    /// Gauss–Markov process, σ and T_c.
    GaussMarkov,
    /// Spectral line.
    Sinusoid,
}

impl Term {
    /// The letter or name used where rows are short: `Q`, `N`, `B`, `K`, `R`, `GM`, `line`.
    pub fn symbol(self) -> &'static str {
        match self {
            Term::Quantization => "Q",
            Term::White => "N",
            Term::Flicker => "B",
            Term::RandomWalk => "K",
            Term::Ramp => "R",
            Term::GaussMarkov => "GM",
            Term::Sinusoid => "line",
        }
    }
}

/// Which terms the estimate looks for; a term left out is reported as absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "a set of terms, each in or out"
)]
pub struct Candidates {
    /// Quantization noise.
    pub quantization: bool,
    /// White noise.
    pub white: bool,
    /// Flicker noise.
    pub flicker: bool,
    /// Random walk.
    pub random_walk: bool,
    /// Ramp.
    pub ramp: bool,
    /// Largest number of Gauss–Markov terms, at most 2.
    pub gauss_markov: usize,
    /// Spectral lines.
    pub sinusoids: bool,
}

impl Default for Candidates {
    fn default() -> Self {
        Self {
            quantization: true,
            white: true,
            flicker: true,
            random_walk: true,
            ramp: true,
            gauss_markov: 2,
            sinusoids: true,
        }
    }
}

impl Candidates {
    /// Q, N, B and K.
    pub(super) fn singles(&self) -> [bool; 4] {
        [
            self.quantization,
            self.white,
            self.flicker,
            self.random_walk,
        ]
    }

    /// No term at all, to be filled term by term.
    pub fn none() -> Self {
        Self {
            quantization: false,
            white: false,
            flicker: false,
            random_walk: false,
            ramp: false,
            gauss_markov: 0,
            sinusoids: false,
        }
    }

    /// Switches a term on.
    pub fn allow(&mut self, term: Term) {
        match term {
            Term::Quantization => self.quantization = true,
            Term::White => self.white = true,
            Term::Flicker => self.flicker = true,
            Term::RandomWalk => self.random_walk = true,
            Term::Ramp => self.ramp = true,
            Term::GaussMarkov => self.gauss_markov = 2,
            Term::Sinusoid => self.sinusoids = true,
        }
    }
}

/// What is looked for and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FitOptions {
    /// The terms looked for.
    pub candidates: Candidates,
    /// Whether steps, warm-up, a filter and changing scatter are looked for.
    pub data_checks: bool,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            candidates: Candidates::default(),
            data_checks: true,
        }
    }
}

/// What is known of a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The likelihood ratio against the best fit without it reached its threshold.
    Detected,
    /// Looked for and not detected: only `upper` holds.
    UpperLimit,
    /// Not looked for in this log.
    Absent,
}

/// An estimate with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// What is known.
    pub status: Status,
    /// Best value, of a detected term.
    pub value: Option<f64>,
    /// Lower end of the 95 % interval.
    pub lower: Option<f64>,
    /// Upper end of the 95 % interval, or the 95 % upper limit.
    pub upper: Option<f64>,
    /// Standard deviation from the information matrix.
    pub sigma: Option<f64>,
}

impl Estimate {
    /// Nothing was looked for.
    pub const ABSENT: Self = Self {
        status: Status::Absent,
        value: None,
        lower: None,
        upper: None,
        sigma: None,
    };

    /// A 95 % upper limit.
    pub fn limit(upper: f64) -> Self {
        Self {
            status: Status::UpperLimit,
            upper: Some(upper),
            ..Self::ABSENT
        }
    }

    /// A value with its interval and standard deviation.
    pub fn detected(value: f64, lower: f64, upper: f64, sigma: f64) -> Self {
        Self {
            status: Status::Detected,
            value: Some(value),
            lower: Some(lower),
            upper: Some(upper),
            sigma: Some(sigma),
        }
    }

    /// Whether the term was detected.
    pub fn is_detected(&self) -> bool {
        self.status == Status::Detected
    }
}

/// A Gauss–Markov process: σ [unit of the axis] and T_c \[s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussMarkovEstimate {
    /// Standard deviation of the process.
    pub sigma: Estimate,
    /// Correlation time.
    pub correlation_time_s: Estimate,
}

impl GaussMarkovEstimate {
    /// Not looked for.
    pub const ABSENT: Self = Self {
        sigma: Estimate::ABSENT,
        correlation_time_s: Estimate::ABSENT,
    };
}

/// A spectral line: amplitude [unit of the axis] and frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SinusoidEstimate {
    /// Amplitude of the sine before it is averaged over a sample.
    pub amplitude: Estimate,
    /// Frequency as it appears in the log.
    pub frequency_hz: Estimate,
    /// Height of the periodogram over the fitted spectrum.
    pub height: f64,
    /// Share of the sample's white variance that the line adds.
    pub share_of_white: f64,
    /// Whether amplitude and frequency stay the same: what it leaves around itself is noise. Else it is the strongest of
    /// several that one line which wanders was taken for, and its interval reaches over them.
    pub is_steady: bool,
    /// Whether it stands above a filter's corner: the amplitude is what the filter has left of it.
    pub is_filtered: bool,
}

/// What kind of deterministic column was fitted beside the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RegressorKind {
    /// Coefficient of (T − T0)^power [unit of the axis / K^power].
    Temperature {
        /// The power, 1 or 2.
        power: usize,
    },
    /// Exponential from the start; its amplitude at the log's start.
    WarmUp {
        /// Time constant \[s\].
        time_constant_s: f64,
    },
    /// Lasting change of the mean; its height.
    Step {
        /// Time of the change \[s\].
        time_s: f64,
    },
}

/// A regressor with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regressor {
    /// Which column.
    pub kind: RegressorKind,
    /// Best value [unit of the axis, or per K^power].
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub lower: f64,
    /// Upper end of the 95 % interval.
    pub upper: f64,
}

/// The mean between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Start [s from the log's first sample].
    pub start_s: f64,
    /// End \[s\].
    pub end_s: f64,
    /// Mean of the samples there; `sigma` is its standard error given the fitted noise.
    pub mean: Estimate,
}

/// Kinds of findings that need a fit (statistics of the log's quality).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FindingKind {
    /// A lasting change of the mean.
    Step,
    /// An exponential from the start.
    WarmUp,
    /// The scatter changes along the log.
    NonStationary,
    /// Averaged, low-passed or interpolated data.
    Filtered,
    /// Coarse rounding against the noise.
    Quantization,
    /// The bias was taken out before.
    BiasRemoved,
    /// A spectral line.
    Line,
    /// Too short for some terms.
    Short,
    /// The model does not explain the spectrum (p < 0.001).
    Misfit,
}

impl FindingKind {
    /// The name used in JSON.
    pub fn name(self) -> &'static str {
        match self {
            FindingKind::Step => "step",
            FindingKind::WarmUp => "warm_up",
            FindingKind::NonStationary => "non_stationary",
            FindingKind::Filtered => "filtered",
            FindingKind::Quantization => "quantization",
            FindingKind::BiasRemoved => "bias_removed",
            FindingKind::Line => "line",
            FindingKind::Short => "short",
            FindingKind::Misfit => "misfit",
        }
    }
}

/// Something about the data that the numbers depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What it is.
    pub kind: FindingKind,
    /// Start of the span [s from the log's first sample].
    pub start_s: f64,
    /// End of the span \[s\].
    pub end_s: f64,
    /// Samples concerned.
    pub count: usize,
    /// A frequency, height or size that belongs to it \[SI\], for texts in users' units.
    pub size: Option<f64>,
    /// One sentence, in SI.
    pub text: String,
}

/// One bin of the measured spectrum beside the fit, two-sided densities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrumBin {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Measured mean density, regressors and lines taken out [unit²/Hz].
    pub measured: f64,
    /// Fitted density [unit²/Hz].
    pub fitted: f64,
    /// Number of coefficients in the bin.
    pub count: f64,
    /// Whether the bin took part in the fit.
    pub used: bool,
}

/// The random terms of a fit as plain numbers (0: not there), for curves and models.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NoiseTerms {
    /// Q [unit·s].
    pub quantization: f64,
    /// N [unit·√s].
    pub white: f64,
    /// B, the coefficient [unit].
    pub flicker: f64,
    /// K [unit/√s].
    pub random_walk: f64,
    /// R [unit/s].
    pub ramp: f64,
    /// (σ [unit], T_c \[s\]) of each Gauss–Markov process.
    pub gauss_markov: Vec<(f64, f64)>,
    /// (amplitude [unit], frequency \[Hz\]) of each line.
    pub sinusoids: Vec<(f64, f64)>,
}

/// Covariance of the detected terms, in the order of `names`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Covariance {
    /// Names: `Q`, `N`, `B`, `K`, `sigma1`, `Tc1`, `sigma2`, `Tc2`.
    pub names: Vec<String>,
    /// Row-major matrix of covariances [products of the terms' units].
    pub matrix: Vec<f64>,
}

impl Covariance {
    /// Correlation coefficients, row-major.
    pub fn correlations(&self) -> Vec<f64> {
        let n = self.names.len();
        let mut out = self.matrix.clone();
        for i in 0..n {
            for j in 0..n {
                out[i * n + j] /= (self.matrix[i * n + i] * self.matrix[j * n + j]).sqrt();
            }
        }
        out
    }
}

/// Everything the joint estimate says about one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisEstimate {
    /// Samples used.
    pub samples: usize,
    /// Step \[s\].
    pub step_s: f64,
    /// Samples × step \[s\].
    pub duration_s: f64,
    /// Mean of the samples; `sigma` is its standard error given the fitted noise. Where there are steps no mean holds for
    /// the whole log: see `levels`.
    pub mean: Estimate,
    /// Q [unit·s].
    pub quantization: Estimate,
    /// N [unit·√s].
    pub white: Estimate,
    /// B, the coefficient [unit].
    pub flicker: Estimate,
    /// K [unit/√s].
    pub random_walk: Estimate,
    /// R [unit/s].
    pub ramp: Estimate,
    /// The detected Gauss–Markov terms, slowest last; where none was: one entry with an upper limit of σ.
    pub gauss_markov: Vec<GaussMarkovEstimate>,
    /// The detected lines, by frequency.
    pub sinusoids: Vec<SinusoidEstimate>,
    /// Pairs of terms that this log cannot tell apart.
    pub confused: Vec<(Term, Term)>,
    /// Deterministic columns fitted beside the noise.
    pub regressors: Vec<Regressor>,
    /// The means before, between and after the steps; empty where there is no step.
    pub levels: Vec<Level>,
    /// Goodness of fit, from 0 to 1; none where nothing was fitted.
    pub p_value: Option<f64>,
    /// What the numbers depend on.
    pub findings: Vec<Finding>,
    /// The terms of the fit (detected ones, and both of a confused pair).
    pub fitted: NoiseTerms,
    /// Covariance of the detected terms.
    pub covariance: Covariance,
    /// The measured spectrum and the fit.
    pub spectrum: Vec<SpectrumBin>,
    /// Twice the log likelihood ratio of each of Q, N, B, K, R against the best fit without it.
    pub likelihood_ratios: [Option<f64>; 5],
}

impl AxisEstimate {
    /// Whether the steps of its values hide its noise, so that terms and mean are known to a step only.
    pub fn is_coarse(&self) -> bool {
        self.findings.iter().any(|f| {
            f.kind == FindingKind::Quantization && f.size.is_some_and(super::coarse::is_coarse)
        })
    }

    /// The estimate of one of the single terms (not of Gauss–Markov terms and lines).
    pub fn term(&self, term: Term) -> Option<&Estimate> {
        match term {
            Term::Quantization => Some(&self.quantization),
            Term::White => Some(&self.white),
            Term::Flicker => Some(&self.flicker),
            Term::RandomWalk => Some(&self.random_walk),
            Term::Ramp => Some(&self.ramp),
            Term::GaussMarkov | Term::Sinusoid => None,
        }
    }
}
