//! Second-order resonance: ẍ + 2ζωẋ + ω²x = white, S(f) = σ²·4ζω³/[(ω² − Ω²)² + (2ζωΩ)²], Ω = 2πf.
//!
//! Its covariance is Re{σ²(1 − iκ)e^−λt} with λ = ω(ζ − i√(1 − ζ²)), κ = ζ/√(1 − ζ²): a
//! Gauss–Markov process of complex correlation time.

use core::f64::consts::PI;

use crate::frame::{Frame, Generator, Scratch};
use crate::math::{Complex, sin2_pi};
use crate::stream::{Purpose, Stream, StreamKey};

/// Resonance of standard deviation σ (rad/s, or m/s²), natural frequency f_r and damping ζ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Resonance {
    /// σ, standard deviation of the process.
    pub sigma: f64,
    /// f_r, natural frequency, Hz; positive where σ is not 0.
    pub frequency_hz: f64,
    /// ζ, damping ratio, 0 < ζ < 1.
    pub damping: f64,
}

impl Resonance {
    /// λ and 1 − iκ.
    pub(crate) fn poles(&self) -> (Complex, Complex) {
        let omega = 2.0 * PI * self.frequency_hz;
        let root = libm::sqrt((1.0 - self.damping) * (1.0 + self.damping));
        (
            Complex {
                re: omega * self.damping,
                im: -omega * root,
            },
            Complex {
                re: 1.0,
                im: -self.damping / root,
            },
        )
    }

    /// Two-sided PSD of interval means at `frequency_hz`, averaging and aliasing included.
    pub fn psd(&self, frequency_hz: f64, dt_s: f64) -> f64 {
        if self.sigma == 0.0 {
            return 0.0;
        }
        let (lambda, weight) = self.poles();
        let h = lambda.scale(dt_s);
        let phi = h.scale(-1.0).exp();
        let decay = h.mean_decay();
        let one_minus_phi = decay * h;
        let s2 = sin2_pi(frequency_hz * dt_s);
        let s2 = Complex { re: s2, im: 0.0 };
        let c0 = h.mean_of_mean_decay().scale(2.0);
        let c1 = decay * decay;
        let shape = c0
            + c1.scale(2.0)
                * (one_minus_phi - s2.scale(2.0))
                * (one_minus_phi * one_minus_phi + phi.scale(4.0) * s2).recip();
        self.sigma * self.sigma * dt_s * (weight * shape).re
    }

    /// PSD σ²·4ζω³/[(ω² − (2πf)²)² + (2ζω·2πf)²] of the process before averaging.
    pub fn process_psd(&self, frequency_hz: f64) -> f64 {
        let omega = 2.0 * PI * self.frequency_hz;
        let x = frequency_hz / self.frequency_hz;
        let d = 1.0 - x * x;
        let e = 2.0 * self.damping * x;
        4.0 * self.sigma * self.sigma * self.damping / (omega * (d * d + e * e))
    }

    /// Allan variance [4V(τ) − V(2τ)]/(2τ²), exact for interval means at every τ = m·dt.
    pub fn allan_variance(&self, tau_s: f64) -> f64 {
        if self.sigma == 0.0 {
            return 0.0;
        }
        let (lambda, weight) = self.poles();
        self.sigma * self.sigma * (weight * lambda.scale(tau_s).bridged_variance()).re
    }
}

/// Resonance samples: interval means from the exact joint law of (x, ẋ, ∫x), started stationary.
///
/// With the state s = (x, ẋ/ω), s_k = A s_{k−1} + e and y_k = C s_{k−1} + e_y, the Kalman filter of
/// its own output gives the innovations form y_k = C ŝ + √v_k n_k, ŝ ← A ŝ + g_k n_k: the same law
/// with one normal number a sample.
#[derive(Debug, Clone)]
pub struct ResonanceGenerator {
    stream: Stream,
    transition: [[f64; 2]; 2],
    output: [f64; 2],
    noise: Noise,
    covariance: [[f64; 2]; 2],
    state: [f64; 2],
    sigma: f64,
    gain: Gain,
    settled: bool,
}

/// Covariance of e, of (e, e_y) and variance of e_y, for σ = 1.
#[derive(Debug, Clone, Copy, Default)]
struct Noise {
    state: [[f64; 2]; 2],
    both: [f64; 2],
    output: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Gain {
    output: f64,
    state: [f64; 2],
}

/// Nodes and weights of Gauss and Legendre's rule of ten points on (−1, 1), positive half.
const LEGENDRE: [(f64, f64); 5] = [
    (0.148_874_338_981_631_2, 0.295_524_224_714_752_9),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

impl ResonanceGenerator {
    /// Resonance at sampling interval `dt_s`; `place` counts the list of `noise` from 1.
    pub fn new(term: Resonance, dt_s: f64, key: StreamKey, place: u32) -> Self {
        let zeta = term.damping;
        let root = libm::sqrt((1.0 - zeta) * (1.0 + zeta));
        let span = 2.0 * PI * term.frequency_hz * dt_s;
        let pole = Complex {
            re: zeta,
            im: -root,
        };
        // Impulse response g, its slope g', and its integral divided by the time.
        let response = |t: f64| {
            let e = pole.scale(-t).exp();
            let mean = pole.scale(t).mean_decay();
            (e.im / root, e.re - zeta / root * e.im, mean.im / root)
        };
        let (g, slope, mean) = response(span);
        let transition = [[slope + 2.0 * zeta * g, g], [-g, slope]];
        let output = [pole.scale(span).mean_decay().re + zeta * mean, mean];
        let mut noise = Noise::default();
        if span < 1.0 {
            for (node, weight) in LEGENDRE {
                for node in [node, -node] {
                    let t = 0.5 * span * (1.0 + node);
                    let (g, slope, mean) = response(t);
                    let e = [g, slope, mean * t / span];
                    let w = 4.0 * zeta * 0.5 * span * weight;
                    for i in 0..2 {
                        for j in 0..2 {
                            noise.state[i][j] += w * e[i] * e[j];
                        }
                        noise.both[i] += w * e[i] * e[2];
                    }
                    noise.output += w * e[2] * e[2];
                }
            }
        } else {
            let (lambda, weight) = term.poles();
            let mean_square = (weight * lambda.scale(dt_s).mean_of_mean_decay()).re * 2.0;
            for i in 0..2 {
                for j in 0..2 {
                    let kept =
                        transition[i][0] * transition[j][0] + transition[i][1] * transition[j][1];
                    noise.state[i][j] = f64::from(u8::from(i == j)) - kept;
                }
                let kept = transition[i][0] * output[0] + transition[i][1] * output[1];
                noise.both[i] = [output[0], -output[1]][i] - kept;
            }
            noise.output = mean_square - output[0] * output[0] - output[1] * output[1];
        }
        Self {
            stream: key.stream(Purpose::Resonance, place),
            transition,
            output,
            noise,
            covariance: [[1.0, 0.0], [0.0, 1.0]],
            state: [0.0; 2],
            sigma: term.sigma,
            gain: Gain::default(),
            settled: false,
        }
    }

    /// One step of the Riccati recursion: the gain of this sample, the covariance of the next.
    fn settle(&mut self) {
        let (a, c, p) = (self.transition, self.output, self.covariance);
        let pc = [
            p[0][0] * c[0] + p[0][1] * c[1],
            p[1][0] * c[0] + p[1][1] * c[1],
        ];
        let variance = c[0] * pc[0] + c[1] * pc[1] + self.noise.output;
        let deviation = libm::sqrt(variance.max(0.0));
        let mut gain = Gain {
            output: deviation,
            state: [0.0; 2],
        };
        for i in 0..2 {
            let both = a[i][0] * pc[0] + a[i][1] * pc[1] + self.noise.both[i];
            gain.state[i] = if deviation > 0.0 {
                both / deviation
            } else {
                0.0
            };
        }
        let ap = |i: usize, j: usize| a[i][0] * p[0][j] + a[i][1] * p[1][j];
        for i in 0..2 {
            for j in 0..2 {
                self.covariance[i][j] =
                    ap(i, 0) * a[j][0] + ap(i, 1) * a[j][1] + self.noise.state[i][j]
                        - gain.state[i] * gain.state[j];
            }
        }
        let shared = 0.5 * (self.covariance[0][1] + self.covariance[1][0]);
        self.covariance[0][1] = shared;
        self.covariance[1][0] = shared;
        let change = libm::fabs(gain.output - self.gain.output)
            + libm::fabs(gain.state[0] - self.gain.state[0])
            + libm::fabs(gain.state[1] - self.gain.state[1]);
        self.settled = change <= 4.0 * f64::EPSILON * gain.output;
        self.gain = gain;
    }
}

impl Generator for ResonanceGenerator {
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch) {
        scratch.next_normals(&mut self.stream);
        for (sample, normal) in frame.iter_mut().zip(&scratch.normals) {
            if !self.settled {
                self.settle();
            }
            let (a, s) = (self.transition, self.state);
            *sample += self.sigma
                * (self.output[0] * s[0] + self.output[1] * s[1] + self.gain.output * normal);
            for i in 0..2 {
                self.state[i] = a[i][0] * s[0] + a[i][1] * s[1] + self.gain.state[i] * normal;
            }
        }
    }
}
