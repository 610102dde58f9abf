//! Quantiles of the 95 % intervals and the χ² test that widens them.
//!
//! value ± q σ, q = 1.960, or Student's t where σ comes from the scatter. `[GUM]`.

use statrs::distribution::{ChiSquared, ContinuousCDF as _, StudentsT};

/// The 97.5 % point of the normal distribution.
pub(crate) const NORMAL_975: f64 = 1.959_963_984_540_054;

/// The 97.5 % point of Student's t with `dof` degrees of freedom; the normal one without end.
pub(crate) fn student_975(dof: f64) -> f64 {
    if dof > 1e6 {
        return NORMAL_975;
    }
    StudentsT::new(0.0, 1.0, dof).map_or(f64::INFINITY, |d| d.inverse_cdf(0.975))
}

/// The probability of a larger χ².
pub(crate) fn chi2_p(chi2: f64, dof: usize) -> Option<f64> {
    ChiSquared::new(dof as f64).ok().map(|d| d.sf(chi2))
}

/// A χ² test: its probability and the factor on the covariance (χ²/dof where p < 0.01, else 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scatter {
    pub(crate) p: Option<f64>,
    pub(crate) factor: f64,
    /// Quantile of the interval.
    pub(crate) quantile: f64,
    pub(crate) scaled: bool,
}

impl Scatter {
    pub(crate) fn of(chi2: f64, dof: usize) -> Self {
        let p = chi2_p(chi2, dof);
        if p.is_some_and(|p| p < 0.01) {
            let dof = dof as f64;
            return Self {
                p,
                factor: chi2 / dof,
                quantile: student_975(dof),
                scaled: true,
            };
        }
        Self {
            p,
            factor: 1.0,
            quantile: NORMAL_975,
            scaled: false,
        }
    }
}

/// Root mean square.
pub(crate) fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len().max(1) as f64;
    (values.map(|v| v * v).sum::<f64>() / n).sqrt()
}

/// The middle of unsorted values; none of none.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        return None;
    }
    Some(if n % 2 == 1 {
        values[n / 2]
    } else {
        f64::midpoint(values[n / 2 - 1], values[n / 2])
    })
}
