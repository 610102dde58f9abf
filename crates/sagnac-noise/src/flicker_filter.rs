//! Flicker samples: the ladder of Gauss–Markov processes as one filter of one white sequence.
//!
//! σ = B√(ln ρ/π), T_i = 8·(run length)·ρ^−(i+½): the sum of the interval means' spectra is
//! rational in w = 4 sin²(πf dt), S(w) = G² Π(w + q_j)/Π(w + p_i) up to constants. Its poles are the
//! ladder's, p = (1 − φ)²/φ; a zero lies between each two, found by bisection, and one beyond w = 4.
//! Split into partial fractions it is y_k = G e_k + Σ r_i s_i, s_i ← φ_i s_i + e_k: exactly the
//! spectrum of the ladder with one normal number a sample. The states start from their stationary
//! covariance 1/(1 − φ_iφ_j). Samples are made in groups of eight, so that what a group waits for is one
//! multiplication and one addition: y_k = G e_k + Σ_m (Σ_i r_i φ_i^(m−1)) e_{k−m} + Σ_i r_i φ_i^k s_i over the normals
//! of the group before k.

use core::f64::consts::PI;

use crate::dispatch::dispatch;
use crate::flicker::Flicker;
use crate::frame::{Frame, Generator, Scratch};
use crate::math::{mean_decay, mean_of_mean_decay};
use crate::stream::{Purpose, Stream, StreamKey};

/// Most states of the filter; a multiple of the lanes.
const MOST: usize = 16;
const LANES: usize = 4;
/// Samples made together.
const GROUP: usize = 8;

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
    state: [f64; MOST],
    scale: f64,
    filter: Filter,
    ladder: Ladder,
}

/// σ of the processes of the ladder.
fn scale(term: Flicker, ladder: &Ladder) -> f64 {
    term.coefficient * libm::sqrt(libm::log(ladder.ratio) / PI)
}

/// The filter for σ = 1, with what its groups need; it depends on nothing but dt and the run's length.
#[derive(Debug, Clone, PartialEq)]
struct Filter {
    count: usize,
    /// φ¹ … φ⁸ of every state.
    powers: [[f64; MOST]; GROUP],
    /// r … rφ⁷ of every state.
    residue: [[f64; GROUP]; MOST],
    /// What the normal m samples back adds to each place of a group that it is in: G, Σr, Σrφ …; 0 before the group.
    lags: [[f64; GROUP]; GROUP],
    /// L with LLᵀ = 1/(1 − φ_iφ_j), row by row.
    start: [[f64; MOST]; MOST],
}

impl Filter {
    fn new(ladder: &Ladder) -> Self {
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
        let mut filter = Self {
            count: ladder.count,
            powers: [[0.0; MOST]; GROUP],
            residue: [[0.0; GROUP]; MOST],
            lags: [[0.0; GROUP]; GROUP],
            start: stationary(rungs),
        };
        for (i, rung) in rungs.iter().enumerate() {
            let mut residue = direct;
            for (j, (other, zero)) in rungs.iter().zip(zeros).enumerate() {
                // φ_i − θ_j and φ_i − φ_j from the distances to 1: no digit is lost.
                residue *= zero - rung.one_minus_phi;
                if i != j {
                    residue /= other.one_minus_phi - rung.one_minus_phi;
                }
            }
            let mut power = rung.phi;
            for k in 0..GROUP {
                filter.powers[k][i] = power;
                filter.residue[i][k] = residue;
                power *= rung.phi;
                residue *= rung.phi;
            }
        }
        for m in 0..GROUP {
            let value = match m {
                0 => direct,
                _ => filter.residue.iter().map(|of| of[m - 1]).sum(),
            };
            for k in m..GROUP {
                filter.lags[m][k] = value;
            }
        }
        filter
    }

    /// The states at the start: their stationary law.
    fn states(&self, key: StreamKey) -> [f64; MOST] {
        let mut scratch = Scratch::default();
        scratch.next_normals(&mut key.stream(Purpose::Flicker, 1));
        core::array::from_fn(|i| {
            let row = self.start[i].iter().zip(&scratch.normals);
            row.map(|(l, normal)| l * normal).sum()
        })
    }
}

impl FlickerGenerator {
    /// Flicker at sampling interval `dt_s` for a run of `run_length_s`.
    pub fn new(term: Flicker, dt_s: f64, run_length_s: f64, key: StreamKey) -> Self {
        let ladder = Ladder::new(dt_s, run_length_s);
        let filter = Filter::new(&ladder);
        Self {
            stream: key.stream(Purpose::Flicker, 0),
            state: filter.states(key),
            scale: scale(term, &ladder),
            filter,
            ladder,
        }
    }

    /// Another one at the same sampling interval and run length: what [`FlickerGenerator::new`] gives, without working out
    /// the filter again.
    #[must_use]
    pub fn another(&self, term: Flicker, key: StreamKey) -> Self {
        Self {
            stream: key.stream(Purpose::Flicker, 0),
            state: self.filter.states(key),
            scale: scale(term, &self.ladder),
            filter: self.filter.clone(),
            ladder: self.ladder.clone(),
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
        run(
            &self.filter,
            self.scale,
            &mut self.state,
            &scratch.normals,
            frame,
        );
    }
}

#[inline(always)]
fn run_body(
    filter: &Filter,
    scale: f64,
    state: &mut [f64; MOST],
    normals: &Frame,
    out: &mut Frame,
) {
    match filter.count {
        4 => run_count::<4>(filter, scale, state, normals, out),
        8 => run_count::<8>(filter, scale, state, normals, out),
        12 => run_count::<12>(filter, scale, state, normals, out),
        _ => run_count::<MOST>(filter, scale, state, normals, out),
    }
}

#[inline(always)]
fn run_count<const COUNT: usize>(
    filter: &Filter,
    scale: f64,
    kept: &mut [f64; MOST],
    normals: &Frame,
    out: &mut Frame,
) {
    let mut state: [f64; COUNT] = core::array::from_fn(|i| kept[i]);
    let powers: [[f64; COUNT]; GROUP] =
        core::array::from_fn(|k| core::array::from_fn(|i| filter.powers[k][i]));
    // The first group with zeros before it.
    let mut line = [0.0; 2 * GROUP];
    line[GROUP..].copy_from_slice(&normals[..GROUP]);
    let mut groups = out.as_chunks_mut::<GROUP>().0.iter_mut();
    if let Some(out) = groups.next() {
        group(filter, scale, &powers, &mut state, &line, out);
    }
    for (before, out) in normals.as_chunks::<GROUP>().0.windows(2).zip(groups) {
        if let Some(line) = before.as_flattened().first_chunk() {
            group(filter, scale, &powers, &mut state, line, out);
        }
    }
    kept[..COUNT].copy_from_slice(&state);
}

/// Eight samples from the normals of the group before and of their own, `line`.
#[inline(always)]
fn group<const COUNT: usize>(
    filter: &Filter,
    scale: f64,
    powers: &[[f64; COUNT]; GROUP],
    state: &mut [f64; COUNT],
    line: &[f64; 2 * GROUP],
    out: &mut [f64; GROUP],
) {
    let mut sums = [[0.0; GROUP]; 2];
    for m in 0..GROUP {
        for k in 0..GROUP {
            sums[m % 2][k] += filter.lags[m][k] * line[GROUP + k - m];
        }
    }
    for i in 0..COUNT {
        for k in 0..GROUP {
            sums[i % 2][k] += filter.residue[i][k] * state[i];
        }
    }
    // s ← φ⁸s + φ⁷e₀ + … + e₇: one step of waiting for eight samples.
    let e: [f64; GROUP] = core::array::from_fn(|k| line[GROUP + k]);
    let mut driven = [[0.0; COUNT]; 2];
    for i in 0..COUNT {
        driven[0][i] = powers[6][i] * e[0];
        driven[1][i] = powers[5][i] * e[1];
    }
    for k in 2..GROUP - 1 {
        for i in 0..COUNT {
            driven[k % 2][i] += powers[GROUP - 2 - k][i] * e[k];
        }
    }
    for i in 0..COUNT {
        state[i] = powers[GROUP - 1][i] * state[i] + ((driven[0][i] + driven[1][i]) + e[7]);
    }
    for k in 0..GROUP {
        out[k] += scale * (sums[0][k] + sums[1][k]);
    }
}

dispatch! {
    fn run(
        filter: &Filter,
        scale: f64,
        state: &mut [f64; MOST],
        normals: &Frame,
        out: &mut Frame,
    ) = run_body;
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
    fn transfer(made: &FlickerGenerator, turns: f64, dt_s: f64) -> f64 {
        let filter = &made.filter;
        let (cos, sin) = (libm::cos(2.0 * PI * turns), libm::sin(2.0 * PI * turns));
        let (mut re, mut im) = (filter.lags[0][0], 0.0);
        for (phi, residue) in filter.powers[0].iter().zip(&filter.residue) {
            let residue = residue[0];
            // residue/(z − φ), 1 − cos without cancellation.
            let (x, y) = (1.0 - phi - 2.0 * crate::math::sin2_pi(turns), sin);
            assert!((x - (cos - phi)).abs() < 1e-14);
            let norm = x * x + y * y;
            re += residue * x / norm;
            im -= residue * y / norm;
        }
        (re * re + im * im) * made.scale * made.scale * dt_s
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
                let (got, want) = (transfer(&made, turns, dt), made.psd(turns, dt));
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

    #[test]
    fn groups_are_the_recursion_sample_by_sample() {
        for run_length in [0.1, 5.0, 3600.0, 86400.0] {
            let term = Flicker { coefficient: 2.0 };
            let mut made = FlickerGenerator::new(term, 0.01, run_length, KEY);
            let mut state = made.state;
            let mut normals = crate::Normals::new(KEY.stream(Purpose::Flicker, 0));
            let mut scratch = Scratch::default();
            for _ in 0..3 {
                let (mut frame, mut e) = ([0.0; crate::FRAME], [0.0; crate::FRAME]);
                made.add_frame(&mut frame, &mut scratch);
                normals.fill(&mut e);
                for (got, e) in frame.iter().zip(e) {
                    let mut want = made.filter.lags[0][0] * e;
                    for (i, s) in state.iter_mut().enumerate().take(made.filter.count) {
                        want += made.filter.residue[i][0] * *s;
                        *s = made.filter.powers[0][i] * *s + e;
                    }
                    assert!((got - made.scale * want).abs() < 1e-10, "{got} {want}");
                }
            }
        }
    }

    #[test]
    fn another_is_a_new_one() {
        let term = |coefficient| Flicker { coefficient };
        let key = StreamKey { run: 7, ..KEY };
        let mut want = FlickerGenerator::new(term(3.0), 0.01, 60.0, key);
        let mut got = FlickerGenerator::new(term(1.0), 0.01, 60.0, KEY).another(term(3.0), key);
        let (mut a, mut b) = ([0.0; crate::FRAME], [0.0; crate::FRAME]);
        want.add_frame(&mut a, &mut Scratch::default());
        got.add_frame(&mut b, &mut Scratch::default());
        assert_eq!(a, b);
    }
}
