//! Flicker samples: the ladder of Gauss–Markov processes as one filter of one white sequence.
//!
//! σ = B√(ln ρ/π), T_i = 8·(run length)·ρ^−(i+½): the sum of the interval means' spectra is
//! rational in w = 4 sin²(πf dt), S(w) = G² Π(w + q_j)/Π(w + p_i) up to constants. Its poles are the
//! ladder's, p = (1 − φ)²/φ; a zero lies between each two, found by bisection, and one beyond w = 4.
//! Split into partial fractions it is y_k = G e_k + Σ r_i s_i, s_i ← φ_i s_i + e_k: exactly the
//! spectrum of the ladder with one normal number a sample. The states start from their stationary
//! covariance 1/(1 − φ_iφ_j).

use core::f64::consts::PI;

use crate::dispatch::dispatch;
use crate::flicker::Flicker;
use crate::frame::{Frame, Generator, Scratch};
use crate::math::{mean_decay, mean_of_mean_decay};
use crate::stream::{Purpose, Stream, StreamKey};

/// Most states of the filter; a multiple of the lanes.
const MOST: usize = 16;
const LANES: usize = 4;

/// One process of the ladder, in the interval means' spectrum c₀ + c₁(2(1−φ) − w)/((1−φ)² + φw).
#[derive(Debug, Clone, Copy, Default)]
struct Rung {
    h: f64,
    phi: f64,
    one_minus_phi: f64,
    c0: f64,
    c1: f64,
}

impl Rung {
    fn new(h: f64) -> Self {
        let decay = mean_decay(h);
        Self {
            h,
            phi: libm::exp(-h),
            one_minus_phi: -libm::expm1(-h),
            c0: 2.0 * mean_of_mean_decay(h),
            c1: decay * decay,
        }
    }

    fn spectrum(&self, w: f64) -> f64 {
        self.c0
            + self.c1 * (2.0 * self.one_minus_phi - w)
                / (self.one_minus_phi * self.one_minus_phi + self.phi * w)
    }

    fn pole(&self) -> f64 {
        self.one_minus_phi * self.one_minus_phi / self.phi
    }
}

/// The ladder: how many processes, and each one's h = dt/T_i.
#[derive(Debug, Clone)]
struct Ladder {
    count: usize,
    ratio: f64,
    rungs: [Rung; MOST],
}

impl Ladder {
    /// The slow end is fixed by the run's length, the last T is dt/16, so that ρ follows. The last
    /// process, nearly white, also stands for all that are faster: it is weighted so that the
    /// spectrum is ideal flicker's at half the sampling rate.
    fn new(dt_s: f64, run_length_s: f64) -> Self {
        const FINEST: f64 = 16.0;
        let span = libm::log(8.0 * FINEST * (run_length_s / dt_s).max(1.0));
        // ρ ≤ 6.6 errs by 0.1 dB at most.
        let mut count = LANES;
        while count < MOST && span / (count as f64 - 0.5) > 1.89 {
            count += LANES;
        }
        let log_ratio = span / (count as f64 - 0.5);
        let mut rungs = [Rung::default(); MOST];
        for (i, rung) in rungs[..count].iter_mut().enumerate() {
            let slower = (count - 1 - i) as f64;
            *rung = Rung::new(FINEST * libm::exp(-log_ratio * slower));
        }
        let ideal = Flicker { coefficient: 1.0 }.psd(0.5, 1.0) * PI / log_ratio;
        let slower: f64 = rungs[..count - 1]
            .iter()
            .map(|rung| rung.spectrum(4.0))
            .sum();
        let last = &mut rungs[count - 1];
        let weight = (ideal - slower) / last.spectrum(4.0);
        last.c0 *= weight;
        last.c1 *= weight;
        Self {
            count,
            ratio: libm::exp(log_ratio),
            rungs,
        }
    }

    fn rungs(&self) -> &[Rung] {
        &self.rungs[..self.count]
    }

    fn spectrum(&self, w: f64) -> f64 {
        self.rungs().iter().map(|rung| rung.spectrum(w)).sum()
    }

    /// 1 − θ of every zero (1 − θ/z) of the filter.
    fn zeros(&self) -> [f64; MOST] {
        let mut zeros = [0.0; MOST];
        for (zero, pair) in zeros.iter_mut().zip(self.rungs().windows(2)) {
            // ln q between the poles; S falls from +∞ at −p_i … to −∞ at −p_{i+1} as q grows.
            let (mut low, mut high) = (libm::log(pair[0].pole()), libm::log(pair[1].pole()));
            for _ in 0..90 {
                let middle = 0.5 * (low + high);
                // Just beyond pole i (q > p_i) its own term is negative.
                if self.spectrum(-libm::exp(middle)) < 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let q = libm::exp(0.5 * (low + high));
            *zero = 2.0 * q / (q + libm::sqrt(q * q + 4.0 * q));
        }
        // S falls through 0 beyond w = 4: a zero θ = −η, η + 1/η = w − 2.
        let (mut low, mut high) = (4.0, 8.0);
        while self.spectrum(high) > 0.0 && high < 1e300 {
            high *= 2.0;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if self.spectrum(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let sum = low - 2.0;
        zeros[self.count - 1] = 1.0 + 2.0 / (sum + libm::sqrt((sum - 2.0) * (sum + 2.0)));
        zeros
    }
}

/// Flicker samples, stationary from the first on, in memory that does not grow.
///
/// The PSD of the samples is within 0.25 dB of ideal flicker's ([`Flicker::psd`]) from
/// 1/(4·run length) to 1/(2dt); lower down it levels off.
#[derive(Debug, Clone)]
pub struct FlickerGenerator {
    stream: Stream,
    filter: Filter,
    ladder: Ladder,
    scale: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct Filter {
    blocks: usize,
    direct: f64,
    phi: [[f64; LANES]; MOST / LANES],
    residue: [[f64; LANES]; MOST / LANES],
    state: [[f64; LANES]; MOST / LANES],
}

impl FlickerGenerator {
    /// Flicker at sampling interval `dt_s` for a run of `run_length_s`.
    pub fn new(term: Flicker, dt_s: f64, run_length_s: f64, key: StreamKey) -> Self {
        let ladder = Ladder::new(dt_s, run_length_s);
        let scale = term.coefficient * libm::sqrt(libm::log(ladder.ratio) / PI);
        let zeros = ladder.zeros();
        let zeros = &zeros[..ladder.count];
        let rungs = ladder.rungs();
        // G² from the spectrum at w = 2, a quarter of the sampling rate.
        let mut power = ladder.spectrum(2.0);
        for (rung, zero) in rungs.iter().zip(zeros) {
            power *= (rung.one_minus_phi * rung.one_minus_phi + 2.0 * rung.phi)
                / (zero * zero + 2.0 * (1.0 - zero));
        }
        let direct = libm::sqrt(power);
        let mut filter = Filter {
            blocks: ladder.count / LANES,
            direct: direct * scale,
            phi: [[0.0; LANES]; MOST / LANES],
            residue: [[0.0; LANES]; MOST / LANES],
            state: [[0.0; LANES]; MOST / LANES],
        };
        let mut scratch = Scratch::default();
        scratch.next_normals(&mut key.stream(Purpose::Flicker, 1));
        let cholesky = stationary(rungs);
        for (i, rung) in rungs.iter().enumerate() {
            let mut residue = direct;
            for (j, (other, zero)) in rungs.iter().zip(zeros).enumerate() {
                // φ_i − θ_j and φ_i − φ_j from the distances to 1: no digit is lost.
                residue *= zero - rung.one_minus_phi;
                if i != j {
                    residue /= other.one_minus_phi - rung.one_minus_phi;
                }
            }
            filter.phi[i / LANES][i % LANES] = rung.phi;
            filter.residue[i / LANES][i % LANES] = residue * scale;
            filter.state[i / LANES][i % LANES] = cholesky[i]
                .iter()
                .zip(&scratch.normals)
                .map(|(l, normal)| l * normal)
                .sum();
        }
        Self {
            stream: key.stream(Purpose::Flicker, 0),
            filter,
            ladder,
            scale,
        }
    }

    /// Two-sided PSD of the samples that this generator makes, at `turns` = f·dt.
    pub fn psd(&self, turns: f64, dt_s: f64) -> f64 {
        self.scale * self.scale * dt_s * self.ladder.spectrum(4.0 * crate::math::sin2_pi(turns))
    }
}

/// Lower triangle L with LLᵀ = 1/(1 − φ_iφ_j).
fn stationary(rungs: &[Rung]) -> [[f64; MOST]; MOST] {
    let mut l = [[0.0; MOST]; MOST];
    for i in 0..rungs.len() {
        for j in 0..=i {
            let mut sum = -1.0 / libm::expm1(-(rungs[i].h + rungs[j].h));
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            l[i][j] = if i == j {
                libm::sqrt(sum.max(0.0))
            } else {
                sum / l[j][j]
            };
        }
    }
    l
}

impl Generator for FlickerGenerator {
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch) {
        scratch.next_normals(&mut self.stream);
        run(&mut self.filter, &scratch.normals, frame);
    }
}

#[inline(always)]
fn run_body(filter: &mut Filter, normals: &Frame, out: &mut Frame) {
    match filter.blocks {
        1 => run_blocks::<1>(filter, normals, out),
        2 => run_blocks::<2>(filter, normals, out),
        3 => run_blocks::<3>(filter, normals, out),
        _ => run_blocks::<4>(filter, normals, out),
    }
}

#[inline(always)]
fn run_blocks<const BLOCKS: usize>(filter: &mut Filter, normals: &Frame, out: &mut Frame) {
    let mut state: [[f64; LANES]; BLOCKS] = core::array::from_fn(|b| filter.state[b]);
    // φ … φ⁴ and r … rφ³ of every state.
    let mut phi = [[[0.0; LANES]; BLOCKS]; LANES];
    let mut residue = [[[0.0; LANES]; LANES]; BLOCKS];
    phi[0] = core::array::from_fn(|b| filter.phi[b]);
    for b in 0..BLOCKS {
        for lane in 0..LANES {
            residue[b][lane][0] = filter.residue[b][lane];
            for k in 1..LANES {
                phi[k][b][lane] = phi[k - 1][b][lane] * filter.phi[b][lane];
                residue[b][lane][k] = residue[b][lane][k - 1] * filter.phi[b][lane];
            }
        }
    }
    // What the last m samples of a group add to a place in it: G, Σr, Σrφ, Σrφ².
    let lags: [[f64; LANES]; LANES] = core::array::from_fn(|m| {
        let value = match m {
            0 => filter.direct,
            _ => residue.as_flattened().iter().map(|of| of[m - 1]).sum(),
        };
        core::array::from_fn(|k| if k >= m { value } else { 0.0 })
    });
    let mut back = [0.0; LANES];
    let groups = normals.as_chunks::<LANES>().0;
    for (e, out) in groups.iter().zip(out.as_chunks_mut::<LANES>().0) {
        let line: [f64; 2 * LANES] =
            core::array::from_fn(|k| if k < LANES { back[k] } else { e[k - LANES] });
        let mut sums = [[0.0; LANES]; 2];
        for m in 0..LANES {
            for k in 0..LANES {
                sums[m % 2][k] += lags[m][k] * line[LANES + k - m];
            }
        }
        for i in 0..LANES * BLOCKS {
            let (b, lane) = (i / LANES, i % LANES);
            for k in 0..LANES {
                sums[i % 2][k] += residue[b][lane][k] * state[b][lane];
            }
        }
        for b in 0..BLOCKS {
            // s ← φ⁴s + φ³e₀ + φ²e₁ + φe₂ + e₃: one step of waiting for four samples.
            for lane in 0..LANES {
                let driven = (phi[2][b][lane] * e[0] + phi[1][b][lane] * e[1])
                    + (phi[0][b][lane] * e[2] + e[3]);
                state[b][lane] = phi[3][b][lane] * state[b][lane] + driven;
            }
        }
        for k in 0..LANES {
            out[k] += sums[0][k] + sums[1][k];
        }
        back = *e;
    }
    filter.state[..BLOCKS].copy_from_slice(&state);
}

dispatch! {
    fn run(filter: &mut Filter, normals: &Frame, out: &mut Frame) = run_body;
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: StreamKey = StreamKey {
        seed: 1,
        run: 1,
        sensor: 0,
        axis: 0,
    };

    /// |H|²·dt of the filter as it stands.
    fn transfer(filter: &Filter, turns: f64, dt_s: f64) -> f64 {
        let (cos, sin) = (libm::cos(2.0 * PI * turns), libm::sin(2.0 * PI * turns));
        let (mut re, mut im) = (filter.direct, 0.0);
        for (phi, residue) in filter
            .phi
            .as_flattened()
            .iter()
            .zip(filter.residue.as_flattened())
        {
            // residue/(z − φ), 1 − cos without cancellation.
            let (x, y) = (1.0 - phi - 2.0 * crate::math::sin2_pi(turns), sin);
            assert!((x - (cos - phi)).abs() < 1e-14);
            let norm = x * x + y * y;
            re += residue * x / norm;
            im -= residue * y / norm;
        }
        (re * re + im * im) * dt_s
    }

    #[test]
    fn filter_has_the_spectrum_of_the_ladder() {
        for (dt, run) in [
            (0.01, 7200.0),
            (0.01, 36000.0),
            (0.001, 86400.0),
            (0.005, 10.0),
            (0.1, 0.1),
        ] {
            let term = Flicker { coefficient: 2.0 };
            let made = FlickerGenerator::new(term, dt, run, KEY);
            let mut turns = (dt / (100.0 * run)).min(0.01);
            while turns < 0.5 {
                let (got, want) = (transfer(&made.filter, turns, dt), made.psd(turns, dt));
                // Residues are differences of nearly equal numbers in the slow states.
                assert!(
                    (got / want - 1.0).abs() < 1e-7,
                    "{dt} {run} {turns}: {got:e} {want:e}"
                );
                turns *= 1.3;
            }
        }
    }

    #[test]
    fn ladder_is_flicker_within_half_a_decibel() {
        for (dt, run) in [
            (0.01, 7200.0),
            (0.01, 36000.0),
            (0.001, 86400.0),
            (0.0025, 43200.0),
            (0.005, 10.0),
        ] {
            let term = Flicker { coefficient: 2.0 };
            let made = FlickerGenerator::new(term, dt, run, KEY);
            let mut turns = dt / (4.0 * run);
            let mut worst: f64 = 0.0;
            let mut middle: f64 = 0.0;
            while turns <= 0.5 {
                let db = 10.0 * libm::log10(made.psd(turns, dt) / term.psd(turns / dt, dt));
                worst = worst.max(db.abs());
                if turns > 4.0 * dt / run {
                    middle = middle.max(db.abs());
                }
                turns *= 1.01;
            }
            assert!(worst < 0.24, "{dt} {run}: {worst} dB");
            assert!(middle < 0.12, "{dt} {run}: {middle} dB in the middle");
        }
    }

    #[test]
    fn states_start_stationary() {
        let ladder = Ladder::new(0.01, 7200.0);
        let l = stationary(ladder.rungs());
        for i in 0..ladder.count {
            for j in 0..=i {
                let got: f64 = (0..ladder.count).map(|k| l[i][k] * l[j][k]).sum();
                let want = -1.0 / libm::expm1(-(ladder.rungs[i].h + ladder.rungs[j].h));
                assert!((got / want - 1.0).abs() < 1e-12);
            }
        }
    }
}
