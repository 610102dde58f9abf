//! Horizontal error of two Gaussian components: F(r) = 1 − (1/2π) ∫₀^{2π} exp(−r²/(2(λ₁ cos²u + λ₂ sin²u))) du,
//! CEP: F = 0.5, R95: F = 0.95; and the order statistics of a sample with their 95 % intervals (navigation.md §3.2).

use std::f64::consts::PI;

/// A 2×2 covariance of (north, east) and a mean, m² and m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Horizontal {
    /// Variance of the north error.
    pub north_north: f64,
    /// Covariance.
    pub north_east: f64,
    /// Variance of the east error.
    pub east_east: f64,
    /// Mean error (north, east); zero but with `--calibration none`.
    pub mean: [f64; 2],
}

impl Horizontal {
    /// Eigenvalues λ₁ ≥ λ₂ ≥ 0 and the direction of the first, rad from north to east.
    pub fn eigen(&self) -> (f64, f64, f64) {
        let half = 0.5 * (self.north_north + self.east_east);
        let d = 0.5 * (self.north_north - self.east_east);
        let root = d.hypot(self.north_east);
        (
            half + root,
            (half - root).max(0.0),
            0.5 * self.north_east.atan2(d),
        )
    }

    /// RMS of the horizontal error, m: √(λ₁ + λ₂ + |μ|²).
    pub fn rms_m(&self) -> f64 {
        (self.north_north
            + self.east_east
            + self.mean[0] * self.mean[0]
            + self.mean[1] * self.mean[1])
            .max(0.0)
            .sqrt()
    }

    /// Radius of the circle about the truth that holds the given part of all errors, m; within 1e-10 of itself.
    pub fn radius_m(&self, part: f64) -> f64 {
        let (l1, l2, angle) = self.eigen();
        let (c, s) = (angle.cos(), angle.sin());
        let mean = [
            c * self.mean[0] + s * self.mean[1],
            -s * self.mean[0] + c * self.mean[1],
        ];
        let distance = mean[0].hypot(mean[1]);
        let scale = (l1 + distance * distance).sqrt();
        if scale == 0.0 || !scale.is_finite() {
            return scale;
        }
        if l1 <= 1e-24 * distance * distance {
            return distance;
        }
        let inside = |r: f64| {
            if distance == 0.0 {
                centered(r, l1, l2)
            } else {
                shifted(r, l1, l2, mean)
            }
        };
        let (mut low, mut high) = (0.0, 3.0 * scale);
        while inside(high) < part {
            high *= 2.0;
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if inside(middle) < part {
                low = middle;
            } else {
                high = middle;
            }
            if high - low <= 1e-12 * high {
                break;
            }
        }
        0.5 * (low + high)
    }

    /// The sum of independent errors.
    #[must_use]
    pub fn plus(&self, other: &Self, factor: f64) -> Self {
        Self {
            north_north: self.north_north + factor * other.north_north,
            north_east: self.north_east + factor * other.north_east,
            east_east: self.east_east + factor * other.east_east,
            mean: self.mean,
        }
    }
}

/// Error function to 1e-15 by series and continued fraction.
fn erf(x: f64) -> f64 {
    let a = x.abs();
    let value = if a < 2.5 {
        let (mut term, mut sum) = (a, a);
        for n in 1..120 {
            term *= -a * a / f64::from(n);
            let part = term / f64::from(2 * n + 1);
            sum += part;
            if part.abs() < 1e-17 * sum.abs() {
                break;
            }
        }
        sum * 2.0 / PI.sqrt()
    } else if a > 6.0 {
        1.0
    } else {
        let mut fraction = 0.0;
        for n in (1..80).rev() {
            fraction = 0.5 * f64::from(n) / (a + fraction);
        }
        1.0 - (-a * a).exp() / (PI.sqrt() * (a + fraction))
    };
    value.copysign(x)
}

/// F(r) about the mean. The integrand is periodic, so the trapezoidal rule converges fast but for flat ellipses, where the
/// one-dimensional integral over the long axis is used instead.
fn centered(r: f64, l1: f64, l2: f64) -> f64 {
    if l2 < 1e-2 * l1 {
        return shifted(r, l1, l2, [0.0; 2]);
    }
    let n = 256;
    let mut sum = 0.0;
    for i in 0..n {
        let u = PI * (f64::from(i) + 0.5) / f64::from(n);
        let (s, c) = u.sin_cos();
        sum += (-r * r / (2.0 * (l1 * c * c + l2 * s * s))).exp();
    }
    1.0 - sum / f64::from(n)
}

/// Probability that a Gaussian with variances l1 ≥ l2 about `mean` lies within r of the origin: ∫ over the long axis of
/// the normal density times the erf of the chord, x = r sin u against the square root at the ends.
fn shifted(r: f64, l1: f64, l2: f64, mean: [f64; 2]) -> f64 {
    let (s1, s2) = (l1.sqrt(), l2.sqrt().max(1e-12 * l1.sqrt()));
    let n = 512;
    // Gauss points are where the density is: x in mean ± 9σ, cut to the circle.
    let (low, high) = ((mean[0] - 9.0 * s1).max(-r), (mean[0] + 9.0 * s1).min(r));
    if low >= high {
        return 0.0;
    }
    let (u0, u1) = (
        (low / r).clamp(-1.0, 1.0).asin(),
        (high / r).clamp(-1.0, 1.0).asin(),
    );
    let mut sum = 0.0;
    for i in 0..=n {
        let u = u0 + (u1 - u0) * f64::from(i) / f64::from(n);
        let x = r * u.sin();
        let chord = r * u.cos();
        let z = (x - mean[0]) / s1;
        let k = std::f64::consts::FRAC_1_SQRT_2 / s2;
        let inner = 0.5 * (erf((chord - mean[1]) * k) + erf((chord + mean[1]) * k));
        let weight = if i == 0 || i == n {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        };
        sum += weight * (-0.5 * z * z).exp() * inner * chord;
    }
    sum * (u1 - u0) / (3.0 * f64::from(n)) / (s1 * (2.0 * PI).sqrt())
}

/// What a sample of radial errors says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled {
    /// The quantile, m (linear interpolation between order statistics).
    pub value_m: f64,
    /// Its interval by order statistics; an end is `None` where the sample has none.
    pub interval_m: [Option<f64>; 2],
}

/// The quantile `p` of ascending values with its two-sided interval, `tail` in each tail: [x_(l), x_(u)], l the largest and u
/// the smallest rank with P(Bin(n, p) < l) ≤ tail and P(Bin(n, p) ≥ u) ≤ tail.
pub fn quantile(sorted: &[f64], p: f64, tail: f64) -> Sampled {
    let n = sorted.len();
    if n == 0 {
        return Sampled {
            value_m: f64::NAN,
            interval_m: [None, None],
        };
    }
    let place = p * (n - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(n - 1);
    let value_m = sorted[below] + (place - below as f64) * (sorted[above] - sorted[below]);
    // Binomial probabilities in logarithms, by recurrence from k = 0.
    let (lp, lq) = (p.ln(), (1.0 - p).ln());
    let mut log_pmf = n as f64 * lq;
    let (mut lower, mut upper) = (0usize, None);
    let mut cumulative = vec![0.0; n + 2];
    for k in 0..=n {
        cumulative[k + 1] = cumulative[k] + log_pmf.exp();
        log_pmf += lp - lq + (((n - k) as f64) / ((k + 1) as f64)).ln();
    }
    // P(Bin < l) = cumulative[l].
    for l in 1..=n {
        if cumulative[l] <= tail {
            lower = l;
        }
    }
    for u in (1..=n).rev() {
        if 1.0 - cumulative[u] <= tail {
            upper = Some(u);
        } else {
            break;
        }
    }
    Sampled {
        value_m,
        interval_m: [
            (lower > 0).then(|| sorted[lower - 1]),
            upper.map(|u| sorted[u - 1]),
        ],
    }
}

/// RMS of radial errors and its interval √(m₂ ± z s/√n), m₂ and s mean and standard deviation of |e|².
pub fn rms(radii: &[f64], z: f64) -> Sampled {
    let n = radii.len() as f64;
    let m2 = radii.iter().map(|r| r * r).sum::<f64>() / n;
    if radii.len() < 2 {
        return Sampled {
            value_m: m2.sqrt(),
            interval_m: [None, None],
        };
    }
    let s = (radii.iter().map(|r| (r * r - m2).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let half = z * s / n.sqrt();
    Sampled {
        value_m: m2.sqrt(),
        interval_m: [Some((m2 - half).max(0.0).sqrt()), Some((m2 + half).sqrt())],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ellipse(l1: f64, l2: f64) -> Horizontal {
        Horizontal {
            north_north: l1,
            north_east: 0.0,
            east_east: l2,
            mean: [0.0; 2],
        }
    }

    #[test]
    fn circle_and_line_of_the_contract() {
        // navigation.md §3.2, to all digits given.
        let (circle, line) = (ellipse(4.0, 4.0), ellipse(0.0, 9.0));
        for (got, want) in [
            (circle.radius_m(0.5) / 2.0, 1.17741),
            (circle.radius_m(0.95) / 2.0, 2.44775),
            (line.radius_m(0.5) / 3.0, 0.67449),
            (line.radius_m(0.95) / 3.0, 1.95996),
        ] {
            assert!((got - want).abs() < 6e-6, "{got} {want}");
        }
    }

    #[test]
    fn the_two_integrals_agree() {
        for ratio in [0.02, 0.3, 1.0] {
            for r in [0.3, 1.0, 2.7] {
                assert!(
                    (centered(r, 1.0, ratio) - shifted(r, 1.0, ratio, [0.0; 2])).abs() < 1e-8,
                    "{ratio} {r}"
                );
            }
        }
    }

    #[test]
    fn a_mean_moves_the_circle() {
        // Rice: σ = 1, distance 3: the median of the radius is 3.165245788 (scipy.stats.rice(3).median()).
        let h = Horizontal {
            mean: [0.0, 3.0],
            ..ellipse(1.0, 1.0)
        };
        assert!(
            (h.radius_m(0.5) - 3.165_245_788).abs() < 1e-8,
            "{}",
            h.radius_m(0.5)
        );
        assert!((h.rms_m() - 11f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn ranks_of_the_binomial() {
        let sorted: Vec<f64> = (1..=200).map(f64::from).collect();
        let median = quantile(&sorted, 0.5, 0.025);
        assert_eq!(median.value_m, 100.5);
        // P(Bin(200, ½) < 86) = 0.0200, < 87 0.0280: l = 86; symmetric u = 115.
        assert_eq!(median.interval_m, [Some(86.0), Some(115.0)]);
        let short: Vec<f64> = (1..=71).map(f64::from).collect();
        assert_eq!(quantile(&short, 0.95, 0.025).interval_m[1], None);
        let enough: Vec<f64> = (1..=72).map(f64::from).collect();
        assert_eq!(quantile(&enough, 0.95, 0.025).interval_m[1], Some(72.0));
    }
}
