//! `[[calibration]]`: what a calibration estimated together, its covariance, and what it held at zero.

/// One calibration that went into a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Calibration {
    /// `stations`, `multi-position`, `thermal`, `merge` or `characterize`.
    pub method: String,
    /// The data: name and hash, `table.csv sha256:…`.
    pub source: Option<String>,
    /// `fixture`, or `accelerometer` after multi-position; none after thermal and characterize.
    pub frame: Option<String>,
    /// Parameter paths in the order of the covariance.
    pub names: Vec<String>,
    /// The lower triangle, row by row, SI; row i has i + 1 numbers.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Degrees of freedom.
    pub dof: Option<f64>,
    /// Parameter paths admitted by no test, taken as zero.
    pub held: Vec<String>,
    /// Anything else about it.
    pub note: Option<String>,
}

impl Calibration {
    /// The covariance of two of its parameters, by their places in `names`; none without a covariance.
    pub fn covariance_of(&self, i: usize, j: usize) -> Option<f64> {
        let (row, column) = if i >= j { (i, j) } else { (j, i) };
        self.covariance.as_ref()?.get(row)?.get(column).copied()
    }
}
