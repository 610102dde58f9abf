//! Allan deviation and its relatives, at chosen averaging times, with χ² intervals.
//!
//! y_1…y_N are interval means at the step dt, x_0 = 0, x_k = x_{k−1} + y_k·dt their phase
//! (N + 1 points), τ = m·dt. Each relative is one file below; sums of squares of all segments
//! are pooled over their number of terms `[SP1065]`.

pub(crate) mod adev;
pub mod dynamic;
pub(crate) mod hdev;
pub(crate) mod kernel;
pub(crate) mod mdev;
pub(crate) mod oadev;
pub(crate) mod phase;
pub(crate) mod theo1;
mod theo1_table;
pub(crate) mod totdev;

use crate::confidence::{Interval, chi_squared_interval, equivalent_degrees};
use crate::error::Error;
use crate::noise_type::noise_types;
use crate::tau_grid::TauGrid;

/// Which deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Deviation {
    /// Allan deviation of adjacent averages that do not overlap.
    Adev,
    /// Overlapping Allan deviation: when in doubt, this one.
    #[default]
    Oadev,
    /// Modified Allan deviation: tells white from flicker phase noise.
    Mdev,
    /// Time deviation, τ/√3 times the modified Allan deviation, in the unit of the phase.
    Tdev,
    /// Overlapping Hadamard deviation: blind to a line in the rate (drift).
    Hdev,
    /// Total deviation, raw: the record reflected at its ends, more certain at long τ.
    Totdev,
    /// Thêo1, raw: up to 0.75 of the record; unbiased for white noise of the rate.
    Theo1,
}

impl Deviation {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Oadev,
        Self::Adev,
        Self::Mdev,
        Self::Hdev,
        Self::Totdev,
        Self::Tdev,
        Self::Theo1,
    ];

    /// Short name, as in options and JSON: `oadev`, `adev`, `mdev`, `hdev`, `totdev`, `tdev`,
    /// `theo1`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Adev => "adev",
            Self::Oadev => "oadev",
            Self::Mdev => "mdev",
            Self::Tdev => "tdev",
            Self::Hdev => "hdev",
            Self::Totdev => "totdev",
            Self::Theo1 => "theo1",
        }
    }

    /// Name in words: `overlapping Allan deviation`.
    pub fn full_name(self) -> &'static str {
        match self {
            Self::Adev => "Allan deviation",
            Self::Oadev => "overlapping Allan deviation",
            Self::Mdev => "modified Allan deviation",
            Self::Tdev => "time deviation",
            Self::Hdev => "overlapping Hadamard deviation",
            Self::Totdev => "total deviation",
            Self::Theo1 => "Thêo1 deviation",
        }
    }

    /// Name on the axis of a plot, where the heading says which estimate it is.
    pub fn plot_name(self) -> &'static str {
        match self {
            Self::Oadev => "Allan deviation",
            Self::Hdev => "Hadamard deviation",
            other => other.full_name(),
        }
    }

    /// The deviation of a short name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// τ/(m·dt): 0.75 for Thêo1, else 1.
    pub fn tau_per_factor(self) -> f64 {
        if self == Self::Theo1 { 0.75 } else { 1.0 }
    }

    /// Least number of samples in a row for the factor m.
    pub fn least_samples(self, m: usize) -> usize {
        match self {
            Self::Adev | Self::Oadev => m.saturating_mul(2),
            Self::Mdev | Self::Tdev => m.saturating_mul(3).saturating_sub(1),
            Self::Hdev => m.saturating_mul(3),
            Self::Totdev => m.saturating_add(1),
            Self::Theo1 => m,
        }
    }

    /// Number of squares that the estimate at factor m averages over `samples` in a row.
    pub fn terms(self, samples: usize, m: usize) -> u64 {
        if m == 0 || samples < self.least_samples(m) {
            return 0;
        }
        let terms = match self {
            Self::Adev => samples / m - 1,
            Self::Oadev => samples - 2 * m + 1,
            Self::Mdev | Self::Tdev => samples + 2 - 3 * m,
            Self::Hdev => samples - 3 * m + 1,
            Self::Totdev => samples - 1,
            Self::Theo1 => (m / 2) * (samples + 1 - m),
        };
        terms as u64
    }

    /// Largest factor that `samples` in a row can estimate at all, 0 if none.
    pub fn largest_factor(self, samples: usize) -> usize {
        match self {
            Self::Adev | Self::Oadev => samples / 2,
            Self::Mdev | Self::Tdev => samples.saturating_add(1) / 3,
            Self::Hdev => samples / 3,
            Self::Totdev => samples.saturating_sub(1),
            Self::Theo1 if samples >= theo1::LEAST_FACTOR => samples / 2 * 2,
            Self::Theo1 => 0,
        }
    }

    /// Largest factor of the named grids: ⌊N/2⌋, ⌊N/3⌋, Thêo1 N.
    pub fn largest_grid_factor(self, samples: usize) -> usize {
        let usual = match self {
            Self::Adev | Self::Oadev | Self::Totdev => samples / 2,
            Self::Mdev | Self::Tdev | Self::Hdev => samples / 3,
            Self::Theo1 => samples,
        };
        usual.min(self.largest_factor(samples))
    }

    /// The possible factor nearest to a wanted one.
    pub(crate) fn nearest_factor(self, wanted: f64, largest: usize) -> Option<usize> {
        if self == Self::Theo1 {
            let m = (wanted / 2.0).round().clamp(0.0, 1e15) as usize * 2;
            (largest >= theo1::LEAST_FACTOR).then(|| m.clamp(theo1::LEAST_FACTOR, largest / 2 * 2))
        } else {
            let m = wanted.round().clamp(0.0, 1e15) as usize;
            (largest >= 1).then(|| m.clamp(1, largest))
        }
    }

    /// Whether the differences are averaged over m starts before they are squared.
    pub(crate) fn is_modified(self) -> bool {
        matches!(self, Self::Mdev | Self::Tdev)
    }

    /// What the mean square of the phase's differences is divided by, at dt = 1: the variance
    /// in the unit of the rate.
    fn divisor(self, m: usize) -> f64 {
        let factor = m as f64;
        match self {
            Self::Adev | Self::Oadev | Self::Totdev => 2.0 * factor * factor,
            // The kernel sums over the average's m points and leaves its division to here.
            Self::Mdev => 2.0 * factor.powi(4),
            // τ²/3 times the variance above, with τ = m.
            Self::Tdev => 6.0 * factor.powi(2),
            Self::Hdev => 6.0 * factor * factor,
            // Terms count (m/2)(N + 1 − m), the definition divides by N + 1 − m.
            Self::Theo1 => 1.5 * factor,
        }
    }
}

/// How the squares were chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Estimate {
    /// Every start.
    #[default]
    Exact,
    /// Starts at least every τ/32, in bounded memory.
    Strided,
}

impl Estimate {
    /// Name in JSON: `exact`, `strided`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Strided => "strided",
        }
    }
}

/// A deviation over averaging times: lists of one length, ascending in τ.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Which deviation.
    pub kind: Deviation,
    /// Exact, or strided by the streaming form.
    pub estimate: Estimate,
    /// Averaging factor m.
    pub factor: Vec<usize>,
    /// Averaging time in seconds: m·dt, Thêo1 0.75·m·dt.
    pub tau_s: Vec<f64>,
    /// The estimate, in the unit of the samples (tdev: times seconds).
    pub deviation: Vec<f64>,
    /// Lower 95 % limit, for the noise type `alpha`; none where no edf is known.
    pub lower: Vec<Option<f64>>,
    /// Upper 95 % limit.
    pub upper: Vec<Option<f64>>,
    /// Noise type: S ∝ f^α of the rate.
    pub alpha: Vec<i8>,
    /// Whether `alpha` was told from this τ (else from the largest τ that could, or assumed 0).
    pub alpha_measured: Vec<bool>,
    /// Equivalent degrees of freedom.
    pub edf: Vec<Option<f64>>,
    /// Number of squares averaged.
    pub samples_used: Vec<u64>,
    /// Corrected for the bias of totdev or Thêo1 (`TheoBR`) under the noise type; none for the
    /// other deviations and where it is not known.
    pub deviation_unbiased: Option<Vec<Option<f64>>>,
}

impl Curve {
    /// Number of averaging times.
    pub fn len(&self) -> usize {
        self.tau_s.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.tau_s.is_empty()
    }
}

/// Sum of squared differences of the phase and their number, at one averaging factor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Sum {
    pub(crate) squares: f64,
    pub(crate) terms: u64,
}

/// A deviation of one axis with its 95 % intervals.
///
/// `segments` are stretches of samples without gaps, each sample the mean over a step `dt_s`,
/// all in one unit; the result has that unit (tdev: times seconds). Squares of all segments are
/// pooled; the grid is that of the longest segment, and shorter ones add what they have.
///
/// # Errors
/// [`Error::NotPositive`] for a step that is not; [`Error::NotFinite`] for NaN or infinity;
/// [`Error::TooShort`] where no averaging time of the grid can be estimated.
///
/// # Accuracy
/// 1e-9 relative to allantools 2024.6 and every printed digit of SP 1065 and Stable32
/// (`tests/`), for any number of threads the same bits.
///
/// # Example
/// ```
/// use sagnac_analysis::{Deviation, TauGrid, deviations};
///
/// let samples: Vec<f64> = (0..1000).map(|k| f64::from(k * 7919 % 1000)).collect();
/// let curve = deviations(&[&samples], 0.01, Deviation::Oadev, &TauGrid::Octave)?;
/// assert_eq!(curve.tau_s[..3], [0.01, 0.02, 0.04]);
/// assert_eq!(curve.samples_used[0], 999);
/// assert!(deviations(&[&samples[..1]], 0.01, Deviation::Oadev, &TauGrid::Octave).is_err());
/// # Ok::<(), sagnac_analysis::Error>(())
/// ```
pub fn deviations(
    segments: &[&[f64]],
    dt_s: f64,
    kind: Deviation,
    grid: &TauGrid,
) -> Result<Curve, Error> {
    let lengths: Vec<usize> = segments.iter().map(|segment| segment.len()).collect();
    let factors = factors_for(&lengths, dt_s, kind, grid)?;
    let phases = phase::phases(segments)?;
    let borrowed: Vec<&[f64]> = phases.iter().map(Vec::as_slice).collect();
    let sums = pooled_sums(&borrowed, kind, &factors);
    let types = noise_types(
        &borrowed,
        &factors,
        if kind == Deviation::Hdev { 3 } else { 2 },
    );
    let mut curve = assemble(
        kind,
        Estimate::Exact,
        dt_s,
        &lengths,
        &factors,
        &sums,
        &types,
    );
    curve.deviation_unbiased = match kind {
        Deviation::Totdev => Some(totdev::unbiased(&curve, &lengths)),
        Deviation::Theo1 => Some(theo1::unbiased(&curve, &borrowed)),
        _ => None,
    };
    Ok(curve)
}

/// The deviation alone, without noise types and intervals: what allantools computes.
///
/// # Errors
/// As [`deviations`].
pub fn deviations_alone(
    segments: &[&[f64]],
    dt_s: f64,
    kind: Deviation,
    factors: &[usize],
) -> Result<Vec<f64>, Error> {
    let phases = phase::phases(segments)?;
    let borrowed: Vec<&[f64]> = phases.iter().map(Vec::as_slice).collect();
    let unit = if kind == Deviation::Tdev { dt_s } else { 1.0 };
    Ok(pooled_sums(&borrowed, kind, factors)
        .iter()
        .zip(factors)
        .map(|(sum, &m)| unit * variance(kind, m, *sum).sqrt())
        .collect())
}

/// The factors of the grid for the longest segment, or the error that says why there are none.
pub(crate) fn factors_for(
    lengths: &[usize],
    dt_s: f64,
    kind: Deviation,
    grid: &TauGrid,
) -> Result<Vec<usize>, Error> {
    if !(dt_s.is_finite() && dt_s > 0.0) {
        return Err(Error::NotPositive {
            name: "the sampling step",
            value_s: dt_s,
        });
    }
    let longest = lengths.iter().copied().max().unwrap_or(0);
    let factors = grid.factors(kind, longest, dt_s);
    if factors.is_empty() {
        let least = if kind == Deviation::Theo1 {
            theo1::LEAST_FACTOR
        } else {
            1
        };
        // A grid may end before what the deviation itself could give.
        let least = kind.least_samples(least).max(2);
        return Err(Error::TooShort {
            kind: kind.full_name(),
            needed: (least..2 * least)
                .find(|&n| !grid.factors(kind, n, dt_s).is_empty())
                .unwrap_or(least),
            found: longest,
        });
    }
    Ok(factors)
}

/// Sums over all segments.
pub(crate) fn pooled_sums(phases: &[&[f64]], kind: Deviation, factors: &[usize]) -> Vec<Sum> {
    let mut pooled = vec![Sum::default(); factors.len()];
    for phase in phases {
        let samples = phase.len() - 1;
        // Factors ascend: those that this segment can estimate come first.
        let possible = factors.partition_point(|&m| kind.terms(samples, m) > 0);
        let factors = &factors[..possible];
        let squares = match kind {
            Deviation::Adev => adev::sums_of_squares(phase, factors),
            Deviation::Oadev => oadev::sums_of_squares(phase, factors),
            Deviation::Mdev | Deviation::Tdev => mdev::sums_of_squares(phase, factors),
            Deviation::Hdev => hdev::sums_of_squares(phase, factors),
            Deviation::Totdev => totdev::sums_of_squares(phase, factors),
            Deviation::Theo1 => theo1::sums_of_squares(phase, factors),
        };
        for ((total, squares), &m) in pooled.iter_mut().zip(squares).zip(factors) {
            total.squares += squares;
            total.terms += kind.terms(samples, m);
        }
    }
    pooled
}

/// The variance at dt = 1.
fn variance(kind: Deviation, m: usize, sum: Sum) -> f64 {
    sum.squares / (sum.terms as f64) / kind.divisor(m)
}

/// Puts sums, noise types and intervals together.
pub(crate) fn assemble(
    kind: Deviation,
    estimate: Estimate,
    dt_s: f64,
    lengths: &[usize],
    factors: &[usize],
    sums: &[Sum],
    types: &[crate::noise_type::NoiseType],
) -> Curve {
    let unit = if kind == Deviation::Tdev { dt_s } else { 1.0 };
    let deviation: Vec<f64> = sums
        .iter()
        .zip(factors)
        .map(|(sum, &m)| unit * variance(kind, m, *sum).sqrt())
        .collect();
    let edf: Vec<Option<f64>> = factors
        .iter()
        .zip(types)
        .map(|(&m, noise)| pooled_degrees(kind, noise.alpha, m, lengths))
        .collect();
    let intervals: Vec<Option<Interval>> = deviation
        .iter()
        .zip(&edf)
        .map(|(&value, edf)| edf.map(|edf| chi_squared_interval(value, edf)))
        .collect();
    Curve {
        kind,
        estimate,
        factor: factors.to_vec(),
        tau_s: factors
            .iter()
            .map(|&m| kind.tau_per_factor() * m as f64 * dt_s)
            .collect(),
        deviation,
        lower: intervals.iter().map(|i| i.map(|i| i.lower)).collect(),
        upper: intervals.iter().map(|i| i.map(|i| i.upper)).collect(),
        alpha: types.iter().map(|noise| noise.alpha).collect(),
        alpha_measured: types.iter().map(|noise| noise.measured).collect(),
        edf,
        samples_used: sums.iter().map(|sum| sum.terms).collect(),
        deviation_unbiased: None,
    }
}

/// edf of the pooled estimate of independent segments: 1/edf = Σ (n_i/n)²/edf_i.
fn pooled_degrees(kind: Deviation, alpha: i8, m: usize, lengths: &[usize]) -> Option<f64> {
    let total: u64 = lengths.iter().map(|&n| kind.terms(n, m)).sum();
    let mut inverse = 0.0;
    for &samples in lengths {
        let terms = kind.terms(samples, m);
        if terms > 0 {
            let share = terms as f64 / total as f64;
            inverse += share * share / equivalent_degrees(kind, alpha, m, samples)?;
        }
    }
    Some(1.0 / inverse)
}
