//! Averaging factors m (τ = m·dt) at which a deviation is estimated.
//!
//! The default grid is ⌈2^{pk/99}⌉, k = 0…99, with 2^p the largest power of two ≤ N/2, taken
//! exactly: the smallest whole m with m^99 ≥ 2^{pk}.

use crate::deviation::Deviation;

/// Which averaging times to estimate.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum TauGrid {
    /// The distinct ⌈2^{pk/99}⌉, k = 0…99: about 4.5 an octave for 10⁷ samples.
    #[default]
    Default,
    /// m = 1, 2, 4, 8…
    Octave,
    /// m = 1, 2, 4, 10, 20, 40, 100…
    Decade,
    /// Every m.
    All,
    /// Times in seconds, each taken to the nearest possible m, ascending, once.
    Times(Vec<f64>),
}

impl TauGrid {
    /// The averaging factors for `samples` samples in a row at the step `dt_s`, ascending, each
    /// once.
    ///
    /// The named grids end at [`Deviation::largest_grid_factor`]; of listed times each goes to
    /// the nearest m that can be estimated at all ([`Deviation::largest_factor`]). Empty when
    /// none can. Thêo1 averages over 0.75·m·dt and takes even m ≥ 10 only.
    pub fn factors(&self, kind: Deviation, samples: usize, dt_s: f64) -> Vec<usize> {
        let last = kind.largest_grid_factor(samples);
        let wanted: Vec<usize> = match self {
            Self::Default => default_factors(samples),
            Self::Octave => (0..usize::BITS).map(|p| 1_usize << p).collect(),
            Self::Decade => decade_factors(last),
            Self::All => (1..=last).collect(),
            Self::Times(times_s) => {
                let unit_s = kind.tau_per_factor() * dt_s;
                let possible = kind.largest_factor(samples);
                let mut factors: Vec<usize> = times_s
                    .iter()
                    .filter(|tau_s| tau_s.is_finite())
                    .filter_map(|tau_s| kind.nearest_factor(tau_s / unit_s, possible))
                    .collect();
                factors.sort_unstable();
                factors.dedup();
                return factors;
            }
        };
        let mut factors: Vec<usize> = wanted
            .into_iter()
            .take_while(|&m| m <= last)
            .filter_map(|m| kind.nearest_factor(m as f64, last))
            .collect();
        factors.dedup();
        factors
    }
}

impl TauGrid {
    /// Factors that hold those of [`Self::factors`] for a log whose length shows at its end.
    ///
    /// `samples`: the number where it is known; then exactly those of that length and of any
    /// shorter one that gaps may leave. `None` for [`Self::All`], whose number has no bound.
    pub fn factors_of_unknown_length(
        &self,
        kind: Deviation,
        samples: Option<usize>,
        dt_s: f64,
    ) -> Option<Vec<usize>> {
        // 2^40 samples are 35 years at 1 kHz.
        let longest = samples.unwrap_or(1 << 40);
        match self {
            Self::All => None,
            Self::Default => {
                let top = longest.max(2).ilog2();
                let mut factors: Vec<usize> = (4..=top)
                    .flat_map(|p| self.factors(kind, (1 << p).min(longest), dt_s))
                    .collect();
                factors.sort_unstable();
                factors.dedup();
                Some(factors)
            }
            _ => Some(self.factors(kind, longest, dt_s)),
        }
    }
}

/// The distinct ⌈2^{pk/99}⌉, k = 0…99.
fn default_factors(samples: usize) -> Vec<usize> {
    if samples < 2 {
        return Vec::new();
    }
    let p = (samples / 2).ilog2();
    let mut factors: Vec<usize> = (0..=99).map(|k| ceil_power_of_two(p * k, 99)).collect();
    factors.dedup();
    factors
}

/// The smallest whole m with m^root ≥ 2^exponent.
fn ceil_power_of_two(exponent: u32, root: u32) -> usize {
    if exponent.is_multiple_of(root) {
        return 1 << (exponent / root);
    }
    // The power is irrational here, so it lies strictly between whole numbers; the rounded
    // value is off by less than one and the exact comparison settles it.
    let about = (f64::from(exponent) / f64::from(root)).exp2().round() as usize;
    (about.saturating_sub(1).max(1)..=about + 1)
        .find(|&m| power_reaches(m as u64, root, exponent))
        .unwrap_or(about + 2)
}

/// Whether base^power ≥ 2^exponent, in whole numbers of any length.
fn power_reaches(base: u64, power: u32, exponent: u32) -> bool {
    let mut digits = vec![1_u64];
    for _ in 0..power {
        let mut carry = 0_u128;
        for digit in &mut digits {
            let product = u128::from(*digit) * u128::from(base) + carry;
            *digit = product as u64;
            carry = product >> 64;
        }
        if carry > 0 {
            digits.push(carry as u64);
        }
    }
    let top = digits.last().map_or(0, |digit| 64 - digit.leading_zeros());
    let bits = (digits.len() as u32 - 1) * 64 + top;
    bits > exponent
}

/// m = 1, 2, 4, 10, 20, 40, 100… up to `last`.
fn decade_factors(last: usize) -> Vec<usize> {
    let mut factors = Vec::new();
    let mut decade = 1_usize;
    while decade <= last {
        factors.extend([decade, 2 * decade, 4 * decade]);
        let Some(next) = decade.checked_mul(10) else {
            break;
        };
        decade = next;
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_grid_has_the_94_factors_of_ten_million_samples() {
        let factors = TauGrid::Default.factors(Deviation::Oadev, 10_000_000, 0.01);
        assert_eq!(factors.len(), 94);
        assert_eq!(factors[..6], [1, 2, 3, 4, 5, 6]);
        assert_eq!(factors.last(), Some(&(1 << 22)));
    }

    #[test]
    fn default_grid_is_exact_at_powers_of_two() {
        // 2^{22·27/99} = 2^6: rounding makes 65 of it.
        let factors = TauGrid::Default.factors(Deviation::Oadev, 10_000_000, 0.01);
        assert!(factors.contains(&64));
        assert!(!factors.contains(&65));
    }

    #[test]
    fn exact_comparison_agrees_with_small_powers() {
        assert!(power_reaches(2, 99, 99));
        assert!(!power_reaches(2, 99, 100));
        assert!(power_reaches(3, 2, 3));
        assert!(!power_reaches(3, 2, 4));
        assert_eq!(ceil_power_of_two(1, 99), 2);
        assert_eq!(ceil_power_of_two(99 * 40, 99), 1 << 40);
        assert_eq!(ceil_power_of_two(3, 2), 3);
    }

    #[test]
    fn grids_end_at_the_limit_of_the_deviation() {
        let octave = |kind| TauGrid::Octave.factors(kind, 100, 1.0);
        assert_eq!(octave(Deviation::Adev), [1, 2, 4, 8, 16, 32]);
        assert_eq!(octave(Deviation::Hdev), [1, 2, 4, 8, 16, 32]);
        assert_eq!(octave(Deviation::Theo1), [10, 16, 32, 64]);
        assert_eq!(TauGrid::All.factors(Deviation::Mdev, 10, 1.0), [1, 2, 3]);
        assert_eq!(
            TauGrid::Decade.factors(Deviation::Oadev, 100, 1.0),
            [1, 2, 4, 10, 20, 40]
        );
        assert!(
            TauGrid::Default
                .factors(Deviation::Oadev, 1, 1.0)
                .is_empty()
        );
    }

    #[test]
    fn listed_times_go_to_the_nearest_possible_factor() {
        let grid = TauGrid::Times(vec![1.0, 0.004, 0.012, 0.013, 99.0]);
        assert_eq!(grid.factors(Deviation::Oadev, 1000, 0.01), [1, 100, 500]);
        assert_eq!(
            TauGrid::Times(vec![0.75, 7.5, 9.1]).factors(Deviation::Theo1, 100, 1.0),
            [10, 12]
        );
    }
}
