//! Which terms are there: likelihood-ratio tests of each term with all other candidates free.
//!
//! 2 Δ ln L against 12 (Q), 3.84 (N, B, K), 12 (a Gauss–Markov term, its T_c searched); on the boundary the ratio is
//! ½χ²_0 + ½χ²_1 [Chernoff1954]. Nothing is dropped before a test: a chain of eliminations takes K for B in weak logs.

use super::likelihood::{B, FIRST_GM, Free, K, N, PARAMETERS, Problem, Q, Solution, is_time};
use super::types::{Candidates, Term};

/// Thresholds of Q, N, B, K. A false Q puts N off by 6 to 8 of its bounds: at 9.5 two or three in 1000 axes with a
/// Gauss–Markov process were named.
pub(crate) const THRESHOLDS: [f64; 4] = [12.0, 3.84, 3.84, 3.84];
/// Threshold of a Gauss–Markov term.
pub(crate) const GAUSS_MARKOV_THRESHOLD: f64 = 12.0;
/// Threshold of the line in time.
pub(crate) const RAMP_THRESHOLD: f64 = 12.0;
/// B and K pass together, each alone failing: ¼χ²_0 + ½χ²_1 + ¼χ²_2 leaves 2.5 %.
const PAIR_THRESHOLD: f64 = 5.2;

/// Ratio of B from which no Gauss–Markov term is tried in its place (speed: none has been seen to do as well).
const RIVAL_RATIO_OF_B: f64 = 200.0;

/// By how much (2 Δ ln L) a B that passes with ratio `ratio` has to beat one more Gauss–Markov term in its place to be
/// named; negative where the process may be the likelier.
///
/// Both make a plateau of the Allan curve; which of them is there shows only in a few coefficients. A clear B stays named
/// in 95 % of axes although the process, with one parameter more, is likelier by chance; a weak one has to be the likelier
/// itself, else weak processes are called flicker in up to 70 % of axes. Beside a process already found more is asked (a
/// second process has two parameters against its one). The constants are those of 2200 axes with flicker at a clearness of
/// 6.6 (95.5 % named), 1200 with a weak Gauss–Markov process of T/180 (4.5 % named) and 1000 with two processes (3.1 %).
fn margin_of_flicker(ratio: f64, beside_another: bool) -> f64 {
    let more = if beside_another { 1.75 } else { 0.0 };
    0.5 + more - 0.3 * (ratio.clamp(20.0, 50.0) - 20.0)
}

/// The same for K. A process with T_c above a tenth of the log cannot be told from a walk and is called one. Of 150 axes each
/// with T/20 (σ = 0.5, 2, 5 beside N = 1, 1 h) 36, 37 and 32 % are; a margin that goes on to −8.75 names 40 to 60 %, one that
/// ends at −4 12 to 20 %, but K itself in 92.8 % of axes with a clearness of 6.7.
fn margin_of_walk(ratio: f64) -> f64 {
    -2.5 - 0.125 * ratio.min(28.0)
}

/// By how much (2 Δ ln L) a process must lead to stay in the fit instead of the term that it rivals: for its parameters.
const RIVAL_PARAMETERS: f64 = 3.0;

/// Ratio from which a flicker that is not named stays in the fit for the values of the others.
///
/// Set to zero it leaves its power to N, kept without need it costs N its precision: where flicker makes N known 1.5
/// times worse (a strong slow process beside it), N stays within 1.15 of its bound with and without flicker at 2 alone.
const STAYS: f64 = 2.4;
/// Gain of both rivals over the better one from which both stay in the fit.
const BOTH_STAY: f64 = 4.0;

/// What stays in the fit of a term and one more Gauss–Markov term that does as well in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stays {
    Term,
    Process,
    /// Together they are better than either.
    Both,
}

#[derive(Debug, Clone)]
struct Rivals {
    term: Solution,
    process: Solution,
}

/// What the tests found.
#[derive(Debug, Clone)]
pub(crate) struct Tests {
    /// Best fit with every candidate and the Gauss–Markov terms found.
    pub full: Solution,
    /// Its free parameters.
    pub full_free: Free,
    /// Number of Gauss–Markov terms found.
    pub gauss_markov: usize,
    /// Ratios of Q, N, B, K.
    pub ratios: [f64; 4],
    /// Whether each passes.
    pub passed: [bool; 4],
    /// B and K fail alone and pass together.
    pub confused: bool,
    /// Q, N, B, K that pass, but one more Gauss–Markov term in the place of B or K does nearly as well or better: neither
    /// is named.
    pub rivaled: [bool; 4],
    /// Which of the two stays in the fit.
    pub stays: Stays,
    /// The fits with one of the two alone, every other candidate free.
    rivals: Option<Rivals>,
    /// Q and N fail alone (one of them is there).
    pub top_confused: bool,
}

/// The single terms of the candidates as free parameters.
pub(crate) fn free_singles(candidates: &Candidates) -> Free {
    let mut free = [false; PARAMETERS];
    free[..4].copy_from_slice(&candidates.singles());
    if !free[..4].iter().any(|&f| f) {
        // A likelihood needs one term that has power everywhere.
        free[N] = true;
    }
    free
}

/// Frees Gauss–Markov term `g`.
pub(crate) fn with_gauss_markov(free: &Free, g: usize) -> Free {
    let mut out = *free;
    out[FIRST_GM + 2 * g] = true;
    out[FIRST_GM + 2 * g + 1] = true;
    out
}

/// Best fit with one more Gauss–Markov term, its correlation time searched over the whole range.
pub(crate) fn add_gauss_markov(
    problem: &Problem,
    base: &Solution,
    free: &Free,
    g: usize,
    points_per_factor_10: f64,
) -> Solution {
    let (low, high) = problem.log_time;
    let steps = ((high - low) / 10f64.ln() * points_per_factor_10)
        .ceil()
        .max(1.0) as usize;
    let mut held = *free;
    let at = FIRST_GM + 2 * g;
    held[at] = true;
    held[at + 1] = false;
    // Two steps from every start tell the few worth following.
    let mut tried: Vec<Solution> = (0..=steps)
        .map(|i| {
            let mut start = base.parameters;
            start[at] = 0.0;
            start[at + 1] = low + (high - low) * i as f64 / steps as f64;
            problem.fit_limited(&start, &held, 2)
        })
        .collect();
    tried.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    let best = tried
        .iter()
        .take(FOLLOWED)
        .map(|t| problem.fit_limited(&t.parameters, &held, 6))
        .min_by(|a, b| a.objective.total_cmp(&b.objective));
    let Some(best) = best else {
        return base.clone();
    };
    if best.objective > base.objective - 0.5 {
        return best;
    }
    problem.fit(&best.parameters, &with_gauss_markov(&held, g))
}

/// Starts of a correlation time that are followed beyond two steps.
const FOLLOWED: usize = 3;

/// Best fit of the single candidates with as many Gauss–Markov terms as pass.
pub(crate) fn grow(problem: &Problem, candidates: &Candidates) -> (Solution, Free, usize) {
    let mut free = free_singles(candidates);
    let mut solution = problem.fit(&problem.start(&free), &free);
    let mut count = 0;
    let mut faster: Option<Problem> = None;
    while count < candidates.gauss_markov.min(2) {
        let here = faster.as_ref().unwrap_or(problem);
        let mut with = add_gauss_markov(here, &solution, &free, count, 6.0);
        let more = with_gauss_markov(&free, count);
        if let Some(open) = here.with_faster(&with.parameters) {
            with = open.fit(&with.parameters, &more);
            faster = Some(open);
        }
        if solution.objective - with.objective < GAUSS_MARKOV_THRESHOLD
            || faster.as_ref().unwrap_or(problem).at_edge(&with.parameters)
        {
            break;
        }
        free = more;
        solution = with;
        count += 1;
    }
    (solution, free, count)
}

/// Best fit with parameter `without` at zero, from a fit that has it.
pub(crate) fn refit_without(
    problem: &Problem,
    full: &Solution,
    full_free: &Free,
    without: &[usize],
) -> Solution {
    let mut free = *full_free;
    let mut start = full.parameters;
    for &k in without {
        free[k] = false;
        start[k] = 0.0;
    }
    let mut best = problem.fit(&start, &free);
    // Correlation times may have to move far: search them again.
    for g in 0..2 {
        let at = FIRST_GM + 2 * g;
        if !free[at] {
            continue;
        }
        let mut rest = free;
        rest[at] = false;
        rest[at + 1] = false;
        let mut base = best.clone();
        base.parameters[at] = 0.0;
        let base = problem.fit_limited(&base.parameters, &rest, 8);
        let tried = add_gauss_markov(problem, &base, &rest, g, 3.0);
        if tried.objective < best.objective {
            best = tried;
        }
    }
    best
}

/// Best fit without Gauss–Markov term `g`, which must be the last.
pub(crate) fn refit_without_gauss_markov(
    problem: &Problem,
    full: &Solution,
    full_free: &Free,
    g: usize,
) -> Solution {
    let at = FIRST_GM + 2 * g;
    let mut free = *full_free;
    free[at] = false;
    free[at + 1] = false;
    let mut start = full.parameters;
    start[at] = 0.0;
    problem.fit(&start, &free)
}

/// Tests every single candidate with all others and the Gauss–Markov terms found free.
pub(crate) fn test(
    problem: &Problem,
    candidates: &Candidates,
    grown: (Solution, Free, usize),
) -> Tests {
    let (mut full, full_free, gauss_markov) = grown;
    let tested = candidates.singles();
    let mut reduced: [Option<Solution>; 4] = [None, None, None, None];
    for k in 0..4 {
        if !tested[k] {
            continue;
        }
        let fit = if full.parameters[k] <= 0.0 && gauss_markov == 0 {
            full.clone()
        } else {
            refit_without(problem, &full, &full_free, &[k])
        };
        if fit.objective < full.objective - 1e-3 {
            // The larger model starts from a better place.
            let again = problem.fit(&fit.parameters, &full_free);
            if again.objective < full.objective {
                full = again;
            }
        }
        reduced[k] = Some(fit);
    }
    let mut ratios = [0.0; 4];
    let mut passed = [false; 4];
    for k in 0..4 {
        if let Some(fit) = &reduced[k] {
            ratios[k] = (fit.objective - full.objective).max(0.0);
            passed[k] = ratios[k] >= THRESHOLDS[k];
        }
    }
    let pair = |a: usize, b: usize| {
        tested[a]
            && tested[b]
            && !passed[a]
            && !passed[b]
            && (full.parameters[a] > 0.0 || full.parameters[b] > 0.0)
            && refit_without(problem, &full, &full_free, &[a, b]).objective - full.objective
                >= PAIR_THRESHOLD
    };
    let confused = pair(B, K);
    let top_confused = pair(Q, N);
    let mut tests = Tests {
        full,
        full_free,
        gauss_markov,
        ratios,
        passed,
        confused,
        rivaled: [false; 4],
        stays: Stays::Term,
        rivals: None,
        top_confused,
    };
    if gauss_markov < candidates.gauss_markov.min(2) {
        tests.look_for_rivals(problem, candidates, &tested, &reduced);
    }
    tests
}

fn keep_better(best: &mut Option<Solution>, tried: Solution) {
    if best.as_ref().is_none_or(|b| tried.objective < b.objective) {
        *best = Some(tried);
    }
}

/// Puts that of two Gauss–Markov terms first whose ln T_c is nearer to `found`: the other is the rival.
fn put_first(fit: &mut Solution, found: f64) {
    let p = &mut fit.parameters;
    let (first, second) = (FIRST_GM, FIRST_GM + 2);
    if (p[second + 1] - found).abs() < (p[first + 1] - found).abs() {
        p.swap(first, second);
        p.swap(first + 1, second + 1);
    }
}

impl Tests {
    /// Tries one more Gauss–Markov term in the place of B or K, each from the fit without it.
    fn look_for_rivals(
        &mut self,
        problem: &Problem,
        candidates: &Candidates,
        tested: &[bool; 4],
        reduced: &[Option<Solution>; 4],
    ) {
        let g = self.gauss_markov;
        let mut process: Option<Solution> = None;
        let mut both: Option<Solution> = None;
        for k in [B, K] {
            if !self.passed[k] || k == B && self.ratios[k] >= RIVAL_RATIO_OF_B {
                continue;
            }
            let margin = if k == B {
                margin_of_flicker(self.ratios[k], g > 0)
            } else {
                margin_of_walk(self.ratios[k])
            };
            let Some(without) = &reduced[k] else { continue };
            let mut free = self.full_free;
            free[k] = false;
            let rival = add_gauss_markov(problem, without, &free, g, 6.0);
            let lead = rival.objective - self.full.objective;
            if problem.at_edge(&rival.parameters) || lead >= margin {
                continue;
            }
            self.rivaled[k] = true;
            let with = problem.fit(&rival.parameters, &with_gauss_markov(&self.full_free, g));
            keep_better(&mut both, with);
            keep_better(&mut process, rival);
        }
        let (Some(mut process), Some(mut both)) = (process, both) else {
            return;
        };
        // Beside the term the process may be another than in its place.
        let beside = add_gauss_markov(problem, &self.full, &self.full_free, g, 6.0);
        if beside.objective < both.objective && !problem.at_edge(&beside.parameters) {
            both = beside;
        }
        if g > 0 {
            let found = self.full.parameters[FIRST_GM + 1];
            put_first(&mut process, found);
            put_first(&mut both, found);
        }
        let term = std::mem::replace(&mut self.full, both);
        self.full_free = with_gauss_markov(&self.full_free, g);
        self.gauss_markov += 1;
        self.rivals = Some(Rivals { term, process });
        // What is not named leaves the fit: which of the two stays is decided without it.
        let objective = |stays| self.fit_with(problem, candidates, stays).0.objective;
        let (term, process) = (objective(Stays::Term), objective(Stays::Process));
        self.stays = if term.min(process) - objective(Stays::Both) >= BOTH_STAY {
            Stays::Both
        } else if process - term < -RIVAL_PARAMETERS {
            Stays::Process
        } else {
            Stays::Term
        };
        // What stood in for the process may have been what made the top of the spectrum fail. White noise below Q is
        // such a process itself: it is tested beside one only where one stays in the fit.
        for k in [Q, N] {
            if tested[k] && self.passed[k] && !(self.stays == Stays::Term && k == N) {
                let fit = refit_without(problem, &self.full, &self.full_free, &[k]);
                self.ratios[k] = (fit.objective - self.full.objective).max(0.0);
                self.passed[k] = self.ratios[k] >= THRESHOLDS[k];
            }
        }
    }

    /// Whether the last Gauss–Markov term stands beside a term that it cannot be told apart from.
    pub(crate) fn last_is_rival(&self) -> bool {
        self.rivaled.iter().any(|&r| r)
    }

    /// The free parameters without the Gauss–Markov term that rivals another.
    pub(crate) fn without_rival(&self, free: &Free) -> Free {
        let mut out = *free;
        if self.last_is_rival() && self.gauss_markov > 0 {
            let at = FIRST_GM + 2 * (self.gauss_markov - 1);
            out[at] = false;
            out[at + 1] = false;
        }
        out
    }

    /// The parameter that is the correlation time of a rival.
    pub(crate) fn time_of_rival(&self) -> Option<usize> {
        (self.last_is_rival() && self.gauss_markov > 0)
            .then_some(FIRST_GM + 2 * self.gauss_markov - 1)
    }

    /// 2 Δ ln L of flicker, random walk and processes together.
    pub(crate) fn ratio_of_slow(&self, problem: &Problem) -> f64 {
        let mut fast = self.full_free;
        fast[B..].fill(false);
        final_fit(problem, &self.full, &fast).objective - self.full.objective
    }

    /// Whether flicker that is not named is likely enough to stay in the fit.
    fn flicker_stays(&self) -> bool {
        self.full.parameters[B] > 0.0 && self.ratios[B] >= STAYS
    }

    /// The free parameters `free` with flicker, where flicker is possible but too unlikely to stay in the fit.
    pub(crate) fn with_possible_flicker(&self, free: &Free) -> Option<Free> {
        let is_open = !free[B] && self.full_free[B] && !self.rivaled[B];
        let possible = is_open && self.full.parameters[B] > 0.0;
        possible.then(|| {
            let mut out = *free;
            out[B] = true;
            out
        })
    }

    /// Whether term `k` is not told apart from another.
    pub(crate) fn is_confused(&self, k: usize) -> bool {
        self.rivaled[k] || self.confused && (k == B || k == K)
    }

    /// The pairs of terms that the log cannot tell apart.
    pub(crate) fn pairs(&self) -> Vec<(Term, Term)> {
        [
            (self.confused, Term::Flicker, Term::RandomWalk),
            (self.rivaled[B], Term::Flicker, Term::GaussMarkov),
            (self.rivaled[K], Term::RandomWalk, Term::GaussMarkov),
            (self.top_confused, Term::Quantization, Term::White),
        ]
        .into_iter()
        .filter(|p| p.0)
        .map(|p| (p.1, p.2))
        .collect()
    }

    /// The final fit: what passed, both of B and K where they pass together, N where nothing else holds the top.
    pub(crate) fn final_fit(&self, problem: &Problem, candidates: &Candidates) -> (Solution, Free) {
        self.fit_with(problem, candidates, self.stays)
    }

    /// The fit with the other of two rivals; none where there are none.
    pub(crate) fn alternative(
        &self,
        problem: &Problem,
        candidates: &Candidates,
    ) -> Option<(Solution, Free)> {
        let other = match self.stays {
            Stays::Term => Stays::Process,
            Stays::Process => Stays::Term,
            Stays::Both => return None,
        };
        self.last_is_rival()
            .then(|| self.fit_with(problem, candidates, other))
    }

    fn fit_with(
        &self,
        problem: &Problem,
        candidates: &Candidates,
        stays: Stays,
    ) -> (Solution, Free) {
        let free = self.kept_with(candidates, stays);
        let start = match (&self.rivals, stays) {
            (Some(rivals), Stays::Term) => &rivals.term,
            (Some(rivals), Stays::Process) => &rivals.process,
            _ => &self.full,
        };
        (final_fit(problem, start, &free), free)
    }

    fn kept_with(&self, candidates: &Candidates, stays: Stays) -> Free {
        let mut free = self.full_free;
        free[..4].copy_from_slice(&self.passed);
        free[B] |= self.flicker_stays();
        match stays {
            _ if !self.last_is_rival() => {}
            Stays::Both => {}
            Stays::Process => {
                for k in 0..4 {
                    free[k] &= !self.rivaled[k];
                }
            }
            Stays::Term => free = self.without_rival(&free),
        }
        if self.confused {
            free[B] = true;
            free[K] = true;
        }
        if self.top_confused {
            free[N] = true;
        }
        if !free[..4].iter().any(|&f| f) && !free[FIRST_GM] {
            free[if candidates.white {
                N
            } else {
                strongest(&self.ratios)
            }] = true;
        }
        free
    }
}

fn strongest(ratios: &[f64; 4]) -> usize {
    (0..4)
        .max_by(|&a, &b| ratios[a].total_cmp(&ratios[b]))
        .unwrap_or(N)
}

/// The fit of the kept parameters, the others at zero.
pub(crate) fn final_fit(problem: &Problem, full: &Solution, free: &Free) -> Solution {
    let mut start = full.parameters;
    for k in 0..PARAMETERS {
        if !free[k] && !is_time(k) {
            start[k] = 0.0;
        }
    }
    // A kept variance that stood at zero needs power to start from.
    problem.fit(&start, free)
}
