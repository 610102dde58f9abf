//! Number, mean and scatter of values, which join those of others exactly.
//!
//! n = n₁ + n₂, mean = mean₁ + δ·n₂/n, spread² = (n₁·spread₁² + n₂·spread₂²)/n + δ²·n₁·n₂/n², δ = mean₂ − mean₁.

/// Moments of values, the root mean square about the mean as spread.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Moments {
    pub(crate) count: u64,
    pub(crate) mean: f64,
    pub(crate) spread: f64,
}

/// Larger ones have no squares.
const LARGEST: f64 = 1e140;

impl Moments {
    /// Those of the finite ones among the values.
    pub(crate) fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let finite = values.filter(|v| v.is_finite());
        let Some(first) = finite.clone().next() else {
            return Self::default();
        };
        // The first number is taken out: a large mean costs no digits.
        let (mut count, mut sum, mut largest) = (0_u64, 0.0, 0.0_f64);
        for v in finite.clone() {
            count += 1;
            sum += v - first;
            largest = largest.max(v.abs());
        }
        let unit = (largest / LARGEST).max(1.0);
        let (n, mut mean) = (count as f64, first + sum / count as f64);
        if !mean.is_finite() {
            mean = finite.clone().map(|v| v / n).sum();
        }
        let squares: f64 = finite.map(|v| ((v - mean) / unit).powi(2)).sum();
        Self {
            count,
            mean,
            spread: (squares / n).sqrt() * unit,
        }
    }

    /// The mean; `None` of no values.
    pub(crate) fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// Adds those of other values.
    pub(crate) fn join(&mut self, other: &Self) {
        if self.count == 0 || other.count == 0 {
            if other.count > 0 {
                *self = *other;
            }
            return;
        }
        let count = self.count + other.count;
        let (a, b) = (
            self.count as f64 / count as f64,
            other.count as f64 / count as f64,
        );
        let apart = other.mean - self.mean;
        // Squares in the unit of the largest have a place in an f64.
        let unit = self.spread.max(other.spread).max(apart.abs());
        if unit > 0.0 {
            let square = |v: f64| (v / unit).powi(2);
            let sum = a * square(self.spread) + b * square(other.spread) + a * b * square(apart);
            self.spread = unit * sum.sqrt();
        }
        self.mean += b * apart;
        self.count = count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_join_to_the_whole() {
        for scale in [1.0, 1e-9, 1e200] {
            let values: Vec<f64> = (0..1000)
                .map(|k| scale * (10.0 + f64::from(k * 7919 % 101)))
                .collect();
            let whole = Moments::of(values.iter().copied());
            let mut parts = Moments::default();
            for part in [
                &values[..10],
                &[],
                &[f64::NAN],
                &values[10..700],
                &values[700..],
            ] {
                parts.join(&Moments::of(part.iter().copied()));
            }
            assert_eq!(parts.count, 1000);
            assert!((parts.mean / whole.mean - 1.0).abs() < 1e-14, "{scale}");
            assert!((parts.spread / whole.spread - 1.0).abs() < 1e-13, "{scale}");
            assert!(whole.spread > 29.0 * scale && whole.spread < 30.0 * scale);
        }
    }
}
