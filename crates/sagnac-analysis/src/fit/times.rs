//! The correlation times that a fit may take: T_c = 10 dt … T/4 are reported, faster ones fitted where one may be there.
//!
//! A process near the lower end scatters about it, and one below it would be taken for white noise or, by its fall towards
//! Nyquist, for a filter. So where the best fit comes near 10 dt the range is opened to 1 dt.

use super::likelihood::{FIRST_GM, Free, N, Parameters, Problem, Solution};
use super::spectra::GaussMarkovShape;

/// Highest u from which the band is that of the whole log.
const WHOLE: f64 = 0.45;
/// Correlation times (in samples) from which a process is reported: below, its fall passes for that of a filter.
const SHORTEST: f64 = 10.0;
/// Shortest correlation time (in samples) of the opened range: shorter ones are white but for a few per cent.
const FASTEST: f64 = 1.0;
/// How near (in ln T_c) to ten samples a process opens the range: several standard deviations of a clear one.
const NEAR: f64 = 0.4;
/// How near (in ln T_c) to an end of the range a correlation time is that end.
const EDGE: f64 = 0.02;
/// Rise of −2 ln L (three standard deviations) from which a process is surely faster than ten samples.
const SURELY: f64 = 9.0;
/// White noise beside a fast process, over what a first-order low-pass leaves at Nyquist, up to which it is that low-pass.
const OF_LOW_PASS: f64 = 2.0;
/// Its power over that of white noise beside it from which a fast process is a low-pass.
const BELOW: f64 = 8.0;

impl Problem {
    fn is_whole(&self) -> bool {
        self.u.iter().copied().fold(0.0, f64::max) >= WHOLE
    }

    /// Sets the range for logs of which the longest segment and the highest frequency, in steps of the parameters, are
    /// these; `fast`: with processes faster than ten samples.
    pub(super) fn bound_times(&mut self, (longest, top): (f64, f64), fast: bool) {
        // Below a filter's corner the samples are those of a slower log, beside a faster one of that: ten of its steps.
        let slower = if top > 0.0 && !(WHOLE..=0.5).contains(&top) {
            0.5 / top
        } else {
            1.0
        };
        self.shortest = (SHORTEST * slower).ln();
        self.log_time.0 = if fast && self.is_whole() {
            FASTEST.ln()
        } else {
            self.shortest
        };
        self.log_time.1 = (longest / 4.0).ln().max(self.shortest);
    }

    /// The same with processes faster than ten samples, where a process of this fit may be one.
    ///
    /// None below a filter's corner: what falls there may be the filter.
    pub(crate) fn with_faster(&self, parameters: &Parameters) -> Option<Self> {
        let is_open = self.log_time.0 < self.shortest;
        (!is_open && self.is_fast(parameters)).then(|| {
            let mut out = self.clone();
            out.log_time.0 = FASTEST.ln();
            out
        })
    }

    /// Whether a process that is there is faster than ten samples, or nearly.
    pub(crate) fn is_fast(&self, parameters: &Parameters) -> bool {
        self.is_whole() && processes(parameters).any(|at| parameters[at + 1] < self.shortest + NEAR)
    }

    /// Whether ln(T_c/dt) stands at an end of the range searched: the process it stands for lies outside.
    pub(crate) fn time_at_edge(&self, log_time: f64) -> bool {
        let (low, high) = self.log_time;
        log_time < low + EDGE || log_time > high - EDGE
    }

    /// Whether a Gauss–Markov term that is there has its correlation time at an end of the range.
    pub(crate) fn at_edge(&self, parameters: &Parameters) -> bool {
        processes(parameters).any(|at| self.time_at_edge(parameters[at + 1]))
    }

    /// Places of the processes that are surely faster than ten samples.
    pub(crate) fn surely_fast(&self, solution: &Solution, free: &Free) -> Vec<usize> {
        let is_fast = |&at: &usize| {
            if solution.parameters[at + 1] >= self.shortest {
                return false;
            }
            let mut held = *free;
            held[at + 1] = false;
            let mut start = solution.parameters;
            start[at + 1] = self.shortest;
            self.fit(&start, &held).objective - solution.objective > SURELY
        };
        processes(&solution.parameters).filter(is_fast).collect()
    }

    /// Whether a process surely faster than ten samples has so little white noise beside it that a low-pass is likelier:
    /// 9 dB under its own level, or what a first-order low-pass of white noise, a process with a little white noise, leaves.
    ///
    /// With φ = e^{−h}, h = dt/T_c, the low-pass y_k = φ y_{k−1} + (1 − φ) x_k has N²/dt = σ² [((1 − φ)/h)²/φ − 2(h − 1 + φ)/h²].
    pub(crate) fn is_low_pass(&self, solution: &Solution, free: &Free) -> bool {
        let Some(&at) = self.surely_fast(solution, free).first() else {
            return false;
        };
        let h = (-solution.parameters[at + 1]).exp();
        let fall = -(-h).exp_m1();
        let left = (fall / h).powi(2) * h.exp() - 2.0 * (h - fall) / (h * h);
        let level = GaussMarkovShape::new(h).at(0.0);
        solution.parameters[N] < solution.parameters[at] * (OF_LOW_PASS * left).max(level / BELOW)
    }
}

/// Places of the processes that are there.
fn processes(parameters: &Parameters) -> impl Iterator<Item = usize> + '_ {
    (0..2)
        .map(|g| FIRST_GM + 2 * g)
        .filter(|&at| parameters[at] > 0.0)
}
