//! The bias from run to run: its scatter beyond in-run noise, and its polynomial in the runs' temperatures.
//!
//! Bias stability s is the scatter of the runs' means beyond their in-run variances v_i: Q(s²) = Σ (m_i − b(T_i))²/(s² + v_i)
//! is χ²_{n−p}; its interval inverts that, the value is the restricted likelihood's. Source: [Viechtbauer2007]. Where slopes
//! inside the runs share in b(T), n less the means' leverages stands for n − p. An upper
//! limit is at least the median one of runs without such scatter, v̄·(χ²_{0.5}/χ²_{0.05} − 1), v̄ the harmonic mean of v_i.
//! The slope with temperature inside a run is an observation of b'(T) with its own variance, free of the scatter s.
//! A power of the temperature is kept where its likelihood ratio passes 5 %: with few runs of unknown scatter, where
//! its coefficient is beyond Student's t with the degrees of freedom that are left.

use super::linear::{cholesky, inverse};
use super::types::Estimate;
use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Temperatures nearer than this [K] are one.
const APART_K: f64 = 2.0;

/// What the means of several runs say.
#[derive(Debug, Clone, PartialEq)]
pub struct RunToRun {
    /// Standard deviation of the mean from run to run [unit].
    pub stability: Estimate,
    /// Coefficients of (T − T0), (T − T0)² of the runs' means [unit/K, unit/K²] where they show: value, lower, upper.
    pub temperature: Vec<(f64, f64, f64)>,
    /// T0 [°C], the mean of the runs' temperatures; none where temperature shows nothing.
    pub reference_c: Option<f64>,
    /// Degrees of freedom that the stability rests on: the runs less one, less one a power of the temperature.
    pub freedom: usize,
}

impl RunToRun {
    /// Upper over lower end of the stability's interval where in-run noise plays no part.
    pub fn factor(&self) -> Option<f64> {
        let law = ChiSquared::new(self.freedom as f64).ok()?;
        Some((law.inverse_cdf(0.975) / law.inverse_cdf(0.025)).sqrt())
    }
}

/// Slope with temperature inside a run, at the run's mean temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Mean temperature of the run [°C].
    pub temperature_c: f64,
    /// The slope [unit/K].
    pub value: f64,
    /// Its variance [unit²/K²].
    pub variance: f64,
}

/// Scatter of run means (mean, in-run variance) beyond their own variances, with a 95 % interval.
///
/// A slope with temperature asks for four runs and temperatures more than 2 K apart, a square for five and three such
/// temperatures; a slope inside a run stands for a run and a temperature.
pub fn run_to_run(
    means: &[(f64, f64)],
    temperatures: Option<&[f64]>,
    slopes: &[Slope],
) -> RunToRun {
    let mut out = RunToRun {
        stability: Estimate::ABSENT,
        temperature: Vec::new(),
        reference_c: None,
        freedom: means.len().saturating_sub(1),
    };
    if means.len() < 2 {
        return out;
    }
    let mut runs = Runs::new(means, &[], &[], 0);
    // Degrees of freedom of all observations together.
    let mut all = out.freedom;
    if let Some(t) = temperatures.filter(|t| t.len() == means.len())
        && let Some((degree, with)) = polynomial(means, t, slopes)
    {
        all = all + slopes.len() - degree;
        out.freedom -= degree.saturating_sub(slopes.len());
        out.reference_c = Some(with.center);
        let s2 = with.likeliest();
        let wide = student(all);
        if let Some(fit) = with.solve(s2) {
            for power in 1..=degree {
                let unit = with.width.powi(power as i32);
                let (value, sigma) = (fit.value(power) / unit, fit.sigma(power) / unit);
                let half = wide * sigma;
                out.temperature.push((value, value - half, value + half));
            }
        }
        runs = with;
    }
    out.stability = runs.stability();
    out
}

/// The degree of the polynomial in temperature that the runs show, and their fit with it.
fn polynomial<'a>(
    means: &'a [(f64, f64)],
    t: &[f64],
    slopes: &[Slope],
) -> Option<(usize, Runs<'a>)> {
    let mut sorted = t.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut groups = 1;
    let mut first = *sorted.first()?;
    for &t in &sorted {
        if t - first > APART_K {
            groups += 1;
            first = t;
        }
    }
    [2_usize, 1].into_iter().find_map(|degree| {
        let known = means.len() + slopes.len();
        if known < degree + 3 || groups + slopes.len().min(1) < degree + 1 {
            return None;
        }
        let runs = Runs::new(means, t, slopes, degree);
        let fit = runs.solve(runs.likeliest())?;
        let shows = fit.value(degree).abs() > student(known - 1 - degree) * fit.sigma(degree);
        shows.then_some((degree, runs))
    })
}

/// 97.5 % point of Student's t.
fn student(freedom: usize) -> f64 {
    StudentsT::new(0.0, 1.0, freedom as f64).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

struct Runs<'a> {
    means: &'a [(f64, f64)],
    /// T0, and what stands for 1 in the powers of the temperature [°C, K].
    center: f64,
    width: f64,
    /// Powers 0, 1 … of the temperature, by run.
    rows: Vec<Vec<f64>>,
    /// Their derivatives, value and variance, by slope.
    slopes: Vec<(Vec<f64>, f64, f64)>,
}

/// Weighted least squares at one s².
struct Fit {
    coefficients: Vec<f64>,
    covariance: Vec<f64>,
    /// ln|Σ w a aᵀ|.
    log_determinant: f64,
    /// Σ w r².
    rest: f64,
    /// Its part of the run means, and what is expected of it: n less the means' leverages.
    of_means: f64,
    freedom: f64,
}

impl Fit {
    fn value(&self, power: usize) -> f64 {
        self.coefficients[power]
    }

    fn sigma(&self, power: usize) -> f64 {
        self.covariance[power * self.coefficients.len() + power].sqrt()
    }
}

impl<'a> Runs<'a> {
    fn new(means: &'a [(f64, f64)], t: &[f64], slopes: &[Slope], degree: usize) -> Self {
        let center = t.iter().sum::<f64>() / t.len().max(1) as f64;
        let width = t.iter().map(|t| (t - center).abs()).fold(0.0, f64::max);
        let width = if width > 0.0 { width } else { 1.0 };
        let rows = (0..means.len())
            .map(|i| {
                let x = t.get(i).map_or(0.0, |t| (t - center) / width);
                (0..=degree).map(|power| x.powi(power as i32)).collect()
            })
            .collect();
        let slopes = slopes
            .iter()
            .map(|slope| {
                let x = (slope.temperature_c - center) / width;
                let derivative = |power: usize| match power {
                    0 => 0.0,
                    _ => power as f64 * x.powi(power as i32 - 1) / width,
                };
                let row = (0..=degree).map(derivative).collect();
                (row, slope.value, slope.variance)
            })
            .collect();
        Self {
            means,
            center,
            width,
            rows,
            slopes,
        }
    }

    fn solve(&self, s2: f64) -> Option<Fit> {
        let p = self.rows.first()?.len();
        // The mean of all is taken out before squaring, for the digits.
        let base = self.means.iter().map(|m| m.0).sum::<f64>() / self.means.len() as f64;
        let (mut m, mut h) = (vec![0.0; p * p], vec![0.0; p]);
        let weight = |v: f64| 1.0 / (s2 + v).max(1e-300);
        // Row, value and weight of every observation: run means, then slopes, which do not scatter from run to run.
        let own = |v: f64| 1.0 / v.max(1e-300);
        let observed = || {
            let means = self.means.iter().zip(&self.rows);
            let means = means.map(|(mean, row)| (row, mean.0 - base, weight(mean.1)));
            let slopes = self
                .slopes
                .iter()
                .map(|(row, value, v)| (row, *value, own(*v)));
            means.chain(slopes)
        };
        let scale = observed().map(|o| o.2).fold(0.0, f64::max);
        for (row, value, w) in observed() {
            let w = w / scale;
            for i in 0..p {
                h[i] += w * row[i] * value;
                for j in 0..p {
                    m[i * p + j] += w * row[i] * row[j];
                }
            }
        }
        let mut covariance = inverse(&m, p)?;
        let coefficients: Vec<f64> = (0..p)
            .map(|i| (0..p).map(|j| covariance[i * p + j] * h[j]).sum())
            .collect();
        let n = self.means.len();
        let (mut rest, mut of_means, mut freedom) = (0.0, 0.0, n as f64);
        for (k, (row, value, w)) in observed().enumerate() {
            let fit: f64 = row.iter().zip(&coefficients).map(|(a, c)| a * c).sum();
            rest += w * (value - fit).powi(2);
            if k < n {
                of_means = rest;
                for i in 0..p {
                    for j in 0..p {
                        freedom -= w / scale * row[i] * row[j] * covariance[i * p + j];
                    }
                }
            }
        }
        for c in &mut covariance {
            *c /= scale;
        }
        let factor = cholesky(&m, p)?;
        let log_determinant = (0..p)
            .map(|i| 2.0 * factor[i * p + i].ln() + scale.ln())
            .sum();
        Some(Fit {
            coefficients,
            covariance,
            log_determinant,
            rest,
            of_means,
            freedom,
        })
    }

    fn scatter(&self, s2: f64) -> f64 {
        self.solve(s2).map_or(0.0, |fit| fit.of_means)
    }

    fn stability(&self) -> Estimate {
        let freedom = self.solve(self.likeliest()).map_or(0.0, |fit| fit.freedom);
        let Ok(law) = ChiSquared::new(freedom) else {
            return Estimate::ABSENT;
        };
        let (low, high) = (law.inverse_cdf(0.025), law.inverse_cdf(0.975));
        if self.scatter(0.0) <= law.inverse_cdf(0.95) {
            // Runs closer than their own noise allows would give any limit, even zero: it is not told below the one that
            // half of the sets of such runs without run-to-run scatter give.
            let own = self.means.len() as f64
                / self
                    .means
                    .iter()
                    .map(|m| 1.0 / m.1.max(1e-300))
                    .sum::<f64>();
            let usual = own * (law.inverse_cdf(0.5) / law.inverse_cdf(0.05) - 1.0);
            let least = law.inverse_cdf(0.05);
            return Estimate::limit(self.variance_where(least).max(usual).sqrt());
        }
        let lower = self.variance_where(high).sqrt();
        let upper = self.variance_where(low).sqrt();
        let value = self.likeliest().sqrt().clamp(lower, upper);
        Estimate::detected(value, lower, upper, value / (2.0 * freedom).sqrt())
    }

    /// s² at which the scatter falls to `level`.
    fn variance_where(&self, level: f64) -> f64 {
        if self.scatter(0.0) <= level {
            return 0.0;
        }
        let mut high = self.means.iter().map(|m| m.1).fold(1e-290, f64::max);
        while self.scatter(high) > level && high < 1e290 {
            high *= 4.0;
        }
        let mut low = 0.0;
        for _ in 0..200 {
            let middle = if low == 0.0 {
                high * 0.25
            } else {
                (low * high).sqrt()
            };
            if self.scatter(middle) > level {
                low = middle;
            } else {
                high = middle;
            }
            if low > 0.0 && high / low < 1.0 + 1e-10 {
                break;
            }
        }
        high
    }

    /// s² of the restricted likelihood, on a logarithmic grid refined.
    fn likeliest(&self) -> f64 {
        let objective = |s2: f64| {
            let Some(fit) = self.solve(s2) else {
                return f64::INFINITY;
            };
            let own = self.means.iter().map(|m| (s2 + m.1).max(1e-300).ln());
            own.sum::<f64>() + fit.rest + fit.log_determinant
        };
        let n = self.means.len() as f64;
        let center = self.means.iter().map(|m| m.0).sum::<f64>() / n;
        let total = self
            .means
            .iter()
            .map(|m| (m.0 - center).powi(2))
            .sum::<f64>()
            / (n - 1.0);
        let mut best = (objective(0.0), 0.0);
        let mut at = total;
        let mut width = 1e4_f64;
        while width > 1.0 + 1e-9 {
            let mut moved = at;
            for i in -10..=10 {
                let s2 = at * width.powf(f64::from(i) / 10.0);
                let value = objective(s2);
                if value < best.0 {
                    best = (value, s2);
                    moved = s2;
                }
            }
            at = moved;
            width = width.powf(0.3);
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn three_exact_runs_span_a_factor_twelve() {
        let RunToRun { stability: e, .. } =
            run_to_run(&[(1.0, 1e-12), (2.0, 1e-12), (4.0, 1e-12)], None, &[]);
        let ratio = e.upper.unwrap() / e.lower.unwrap();
        assert!((ratio / 12.07 - 1.0).abs() < 0.01, "{ratio}");
        // Restricted likelihood of equal tiny variances: the sample's standard deviation.
        assert!((e.value.unwrap() / (7.0_f64 / 3.0).sqrt() - 1.0).abs() < 1e-4);
    }

    #[test]
    fn scatter_that_in_run_noise_explains_is_a_limit() {
        let RunToRun { stability: e, .. } =
            run_to_run(&[(0.9, 1.0), (1.1, 1.0), (0.2, 1.0), (2.0, 1.0)], None, &[]);
        assert!(!e.is_detected() && e.upper.unwrap() > 0.0);
    }

    #[test]
    fn a_limit_is_never_below_what_such_runs_usually_give() {
        let RunToRun { stability: e, .. } =
            run_to_run(&[(1.0, 4.0), (1.0, 4.0), (1.0, 4.0)], None, &[]);
        // Two degrees of freedom: 1.386/0.1026 − 1 = 12.51 times the variance.
        assert!((e.upper.unwrap() / (4.0_f64 * 12.514).sqrt() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_temperature_slope_is_taken_out() {
        let t = [10.0, 20.0, 30.0, 40.0, 50.0];
        let wobble = [0.1, -0.1, 0.05, -0.12, 0.07];
        let means: Vec<(f64, f64)> = t
            .iter()
            .zip(wobble)
            .map(|(t, w)| (0.5 * t + w, 1e-6))
            .collect();
        let found = run_to_run(&means, Some(&t), &[]);
        let [(value, lower, upper)] = found.temperature[..] else {
            panic!("{:?}", found.temperature)
        };
        assert!(lower < 0.5 && 0.5 < upper && (value - 0.5).abs() < 0.02);
        assert!(found.stability.value.unwrap() < 0.3);
        assert_eq!((found.reference_c, found.freedom), (Some(30.0), 3));
        assert!((found.factor().unwrap() / 6.58 - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_square_of_temperature_is_taken_out_and_costs_a_degree_of_freedom() {
        let t = [10.0, 25.0, 40.0, 55.0, 70.0];
        let wobble = [0.1, -0.1, 0.05, -0.12, 0.07];
        let means: Vec<(f64, f64)> = t
            .iter()
            .zip(wobble)
            .map(|(t, w)| (0.2 * (t - 40.0) + 0.004 * (t - 40.0_f64).powi(2) + w, 1e-6))
            .collect();
        let found = run_to_run(&means, Some(&t), &[]);
        assert_eq!((found.temperature.len(), found.freedom), (2, 2));
        for ((_, lower, upper), truth) in found.temperature.iter().zip([0.2, 0.004]) {
            assert!(*lower < truth && truth < *upper, "{lower} {upper}");
        }
        assert!(found.stability.value.unwrap() < 0.4);
        // Two temperatures know no square.
        let two = run_to_run(&means, Some(&[10.0, 10.5, 70.0, 70.5, 70.2]), &[]);
        assert!(two.temperature.len() < 2);
    }

    #[test]
    fn slopes_inside_runs_tell_the_temperature_where_means_scatter() {
        // Means that scatter by 1 hide 0.5 a kelvin over 2 K each; five slopes known to 0.05 do not.
        let means = [0.7, -0.4, 1.9, 1.2, 4.8].map(|m| (m, 1e-4));
        let t = [20.0, 22.0, 24.0, 26.0, 28.0];
        let slopes: Vec<Slope> = t
            .iter()
            .zip([0.55, 0.47, 0.5, 0.44, 0.53])
            .map(|(&temperature_c, value)| Slope {
                temperature_c,
                value,
                variance: 0.0025,
            })
            .collect();
        let found = run_to_run(&means, Some(&t), &slopes);
        assert_eq!(found.temperature.len(), 1, "{found:?}");
        let (value, lower, upper) = found.temperature[0];
        assert!(
            (value - 0.5).abs() < 0.02 && lower > 0.43 && upper < 0.57,
            "{found:?}"
        );
        assert_eq!(found.freedom, 4);
        let without = run_to_run(&means, Some(&t), &[]);
        assert!(without.temperature.is_empty(), "{without:?}");
        assert!(found.stability.value < without.stability.value);
        // One temperature alone: the slopes tell all of it.
        let still = run_to_run(&means, Some(&[25.0; 5]), &slopes);
        assert_eq!(still.temperature.len(), 1);
    }
}
