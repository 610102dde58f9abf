//! Exact two-sided spectra of interval means, per sample, against u = f·dt, and what the ends of a finite log change.
//!
//! A shape φ(u) is S(f)/dt divided by the term's variance parameter:
//! Q²/dt²: 4s², N²/dt: 1, B²: (s²/2π³)[ζ(3,u) + ζ(3,1−u)], K²·dt: 1/(4s²) − 1/6, σ²: the Gauss–Markov sum, s = sin πu.
//! Coefficients of the DCT-II have these expectations but for closed forms at the lowest j. Sources: [IEEE952],
//! [NIST-DLMF] 25.11 for the Hurwitz zeta function.

use std::f64::consts::PI;

/// ζ(3, q), the Hurwitz zeta function, for q > 0; relative error below 1e-14 (Euler–Maclaurin from q + 12 on).
pub(crate) fn hurwitz_zeta_3(q: f64) -> f64 {
    let mut sum = 0.0;
    for k in 0..12 {
        let x = q + f64::from(k);
        sum += 1.0 / (x * x * x);
    }
    let x = q + 12.0;
    let r2 = 1.0 / (x * x);
    // ∫ + half term + Bernoulli terms of x⁻³.
    sum + 0.5 * r2
        + 0.5 * r2 / x
        + r2 * r2 * (0.25 - r2 * (1.0 / 12.0 - r2 * (1.0 / 12.0 - r2 * (0.15 - r2 * (5.0 / 12.0)))))
}

/// Quantization noise: 4 sin²(πu).
pub(crate) fn quantization(u: f64) -> f64 {
    let s = (PI * u).sin();
    4.0 * s * s
}

/// Flicker noise: (s²/2π³)[ζ(3,u) + ζ(3,1−u)], 1/(2πu) at low u.
pub(crate) fn flicker(u: f64) -> f64 {
    let s = (PI * u).sin();
    s * s / (2.0 * PI * PI * PI) * (hurwitz_zeta_3(u) + hurwitz_zeta_3(1.0 - u))
}

/// Random walk: 1/(4s²) − 1/6.
pub(crate) fn random_walk(u: f64) -> f64 {
    let s = (PI * u).sin();
    0.25 / (s * s) - 1.0 / 6.0
}

/// The constants of a Gauss–Markov process' spectrum for h = dt/T_c.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GaussMarkovShape {
    h: f64,
    phi: f64,
    c0: f64,
    c1: f64,
}

impl GaussMarkovShape {
    pub(crate) fn new(h: f64) -> Self {
        let phi = (-h).exp();
        // h − 1 + φ and 1 − φ cancel for small h.
        let one_minus = -(-h).exp_m1();
        let c0 = if h < 1e-3 {
            1.0 - h / 3.0 + h * h / 12.0
        } else {
            2.0 * (h - one_minus) / (h * h)
        };
        let r = one_minus / h;
        Self {
            h,
            phi,
            c0,
            c1: r * r,
        }
    }

    /// Half the mean square of the difference of two means `s` steps apart.
    pub(crate) fn variogram(&self, s: usize) -> f64 {
        match s {
            0 => 0.0,
            _ => self.c0 - self.c1 * (-self.h * (s - 1) as f64).exp(),
        }
    }

    /// The shape at u, given 4 sin²(πu).
    pub(crate) fn at(&self, four_s2: f64) -> f64 {
        let d = -(-self.h).exp_m1();
        let denominator = d * d + self.phi * four_s2;
        // cos 2πu − φ = (1 − φ) − 2 sin²(πu)
        self.c0 + 2.0 * self.c1 * (d - 0.5 * four_s2) / denominator
    }
}

/// Expected flicker coefficient j of the DCT-II over its spectrum: (2/π)[Si(πj) − (1 − (−1)^j)/(πj)].
pub(crate) fn flicker_end_factor(j: f64) -> f64 {
    if j > 400.0 {
        return 1.0 - 2.0 / (PI * PI * j);
    }
    if j.fract() != 0.0 {
        // Between whole numbers the asymptote is good to 1e-3 from j = 3 on.
        return 1.0 - 2.0 / (PI * PI * j);
    }
    let sign = if (j as i64) % 2 == 0 { 1.0 } else { -1.0 };
    2.0 / PI * (sine_integral_at_pi_multiple(j) - (1.0 - sign) / (PI * j))
}

/// Si(πj) for whole j ≥ 1: the auxiliary function f from its asymptote for j > 6, else stored.
fn sine_integral_at_pi_multiple(j: f64) -> f64 {
    const FIRST: [f64; 6] = [
        1.851_937_051_982_466,
        1.418_151_576_132_628_4,
        1.674_761_798_979_961_2,
        1.492_161_225_584_46,
        1.633_964_846_102_835,
        1.518_033_961_467_180_5,
    ];
    let index = j as usize;
    if index <= FIRST.len() {
        return FIRST[index - 1];
    }
    let x = PI * j;
    let r2 = 1.0 / (x * x);
    // Si(x) = π/2 − f(x) cos x − g(x) sin x, sin πj = 0.
    let f = (1.0 - r2 * (2.0 - r2 * (24.0 - r2 * (720.0 - r2 * 40320.0)))) / x;
    let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    PI / 2.0 - sign * f
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn assert_rel(got: f64, want: f64, tolerance: f64) {
        assert!((got / want - 1.0).abs() < tolerance, "{got} {want}");
    }

    #[test]
    fn hurwitz_zeta_has_its_known_values() {
        // ζ(3, 1) is Apéry's constant, ζ(3, 1/2) = 7 ζ(3).
        let apery = 1.202_056_903_159_594_2;
        assert_rel(hurwitz_zeta_3(1.0), apery, 1e-13);
        assert_rel(hurwitz_zeta_3(0.5), 7.0 * apery, 1e-13);
    }

    #[test]
    fn flicker_is_one_over_f_below_and_sinks_at_nyquist() {
        assert_rel(flicker(1e-4), 1.0 / (2.0 * PI * 1e-4), 1e-6);
        // 0.69 dB under B²/(2πf) at Nyquist.
        assert_rel(10.0 * (flicker(0.5) * PI).log10(), -0.69, 0.01);
    }

    #[test]
    fn spectra_integrate_to_the_allan_variance_of_one_sample() {
        // σ²(dt) = 4 ∫₀^½ φ sin²(πu) du (per sample, m = 1).
        let integrate = |shape: &dyn Fn(f64) -> f64| {
            let n = 200_000;
            (0..n)
                .map(|i| {
                    let u = (f64::from(i) + 0.5) / f64::from(n) * 0.5;
                    let s = (PI * u).sin();
                    4.0 * shape(u) * s * s * 0.5 / f64::from(n)
                })
                .sum::<f64>()
        };
        assert_rel(integrate(&quantization), 3.0, 1e-9);
        assert_rel(integrate(&flicker), 2.0 * 2f64.ln() / PI, 1e-8);
        assert_rel(integrate(&random_walk), 1.0 / 3.0, 1e-9);
        let h = 0.05;
        let shape = GaussMarkovShape::new(h);
        let want = 2.0 / h * (1.0 - 0.5 / h * (3.0 - 4.0 * (-h).exp() + (-2.0 * h).exp()));
        assert_rel(integrate(&|u| shape.at(quantization(u))), want, 1e-7);
    }

    #[test]
    fn gauss_markov_spectrum_is_smooth_across_its_series() {
        let a = GaussMarkovShape::new(0.999e-3);
        let b = GaussMarkovShape::new(1.001e-3);
        let u = quantization(0.01);
        assert_rel(a.at(u) / 0.999e-3, b.at(u) / 1.001e-3, 1e-4);
    }

    #[test]
    fn end_factors_match_the_published_figures() {
        for (j, want) in [(1.0, 0.774), (2.0, 0.903), (3.0, 0.931), (4.0, 0.950)] {
            assert!((flicker_end_factor(j) - want).abs() < 6e-4);
        }
        assert_rel(flicker_end_factor(400.0), flicker_end_factor(401.0), 1e-5);
    }
}
