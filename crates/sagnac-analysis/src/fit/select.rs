//! Which terms are there: likelihood-ratio tests of each term with all other candidates free.
//!
//! 2 Δ ln L against 9.5 (Q), 3.84 (N, B, K), 12 (a Gauss–Markov term, its T_c searched); on the boundary the ratio is
//! ½χ²_0 + ½χ²_1 [Chernoff1954]. Nothing is dropped before a test: a chain of eliminations takes K for B in weak logs.

use super::likelihood::{B, FIRST_GM, Free, K, N, PARAMETERS, Problem, Q, Solution, is_time};
use super::types::Candidates;

/// Thresholds of Q, N, B, K.
pub(crate) const THRESHOLDS: [f64; 4] = [9.5, 3.84, 3.84, 3.84];
/// Threshold of a Gauss–Markov term.
pub(crate) const GAUSS_MARKOV_THRESHOLD: f64 = 12.0;
/// Threshold of the line in time.
pub(crate) const RAMP_THRESHOLD: f64 = 12.0;
/// B and K pass together, each alone failing: ¼χ²_0 + ½χ²_1 + ¼χ²_2 leaves 2.5 %.
const PAIR_THRESHOLD: f64 = 5.2;

/// Ratio of B from which no Gauss–Markov term is tried in its place (speed: none has been seen to do as well).
const RIVAL_RATIO: f64 = 200.0;

/// By how much (2 Δ ln L) a Gauss–Markov term in flicker's place must be the likelier for flicker not to be named: at 0
/// clear flicker goes unnamed in 16 % of axes.
const RIVAL_MARGIN: f64 = 6.0;

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
    /// B passes, but one more Gauss–Markov term in its place is clearly the likelier: both are in the fit, neither is named.
    pub flicker_confused: bool,
    /// Q and N fail alone (one of them is there).
    pub top_confused: bool,
}

/// The single terms of the candidates as free parameters.
pub(crate) fn free_singles(candidates: &Candidates) -> Free {
    let mut free = [false; PARAMETERS];
    free[Q] = candidates.quantization;
    free[N] = candidates.white;
    free[B] = candidates.flicker;
    free[K] = candidates.random_walk;
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
    let mut best: Option<Solution> = None;
    for i in 0..=steps {
        let mut start = base.parameters;
        start[at] = 0.0;
        start[at + 1] = low + (high - low) * i as f64 / steps as f64;
        let tried = problem.fit_limited(&start, &held, 5);
        if best.as_ref().is_none_or(|b| tried.objective < b.objective) {
            best = Some(tried);
        }
    }
    let Some(best) = best else {
        return base.clone();
    };
    if best.objective > base.objective - 0.5 {
        return best;
    }
    problem.fit(&best.parameters, &with_gauss_markov(&held, g))
}

/// Best fit of the single candidates with as many Gauss–Markov terms as pass.
pub(crate) fn grow(problem: &Problem, candidates: &Candidates) -> (Solution, Free, usize) {
    let mut free = free_singles(candidates);
    let mut solution = problem.fit(&problem.start(&free), &free);
    let mut count = 0;
    while count < candidates.gauss_markov.min(2) {
        let with = add_gauss_markov(problem, &solution, &free, count, 6.0);
        if solution.objective - with.objective < GAUSS_MARKOV_THRESHOLD
            || problem.at_edge(&with.parameters)
        {
            break;
        }
        free = with_gauss_markov(&free, count);
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
    let tested = [
        candidates.quantization,
        candidates.white,
        candidates.flicker,
        candidates.random_walk,
    ];
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
    let (mut full_free, mut gauss_markov) = (full_free, gauss_markov);
    let mut flicker_confused = false;
    if passed[B]
        && ratios[B] < RIVAL_RATIO
        && gauss_markov < candidates.gauss_markov.min(2)
        && let Some(both) = gauss_markov_for_flicker(
            problem,
            &full,
            &full_free,
            gauss_markov,
            reduced[B].as_ref(),
        )
    {
        full_free = with_gauss_markov(&full_free, gauss_markov);
        full = both;
        gauss_markov += 1;
        flicker_confused = true;
    }
    Tests {
        full,
        full_free,
        gauss_markov,
        ratios,
        passed,
        confused,
        flicker_confused,
        top_confused,
    }
}

/// The fit with flicker noise and one more Gauss–Markov term, where the latter alone is clearly the likelier.
fn gauss_markov_for_flicker(
    problem: &Problem,
    full: &Solution,
    full_free: &Free,
    count: usize,
    without: Option<&Solution>,
) -> Option<Solution> {
    let mut free = *full_free;
    free[B] = false;
    let rival = add_gauss_markov(problem, without?, &free, count, 6.0);
    if rival.objective > full.objective - RIVAL_MARGIN || problem.at_edge(&rival.parameters) {
        return None;
    }
    Some(problem.fit(&rival.parameters, &with_gauss_markov(full_free, count)))
}

impl Tests {
    /// The parameters that stay in the final fit: what passed, both of B and K where they pass together, N where
    /// nothing else holds the top.
    pub(crate) fn kept(&self, candidates: &Candidates) -> Free {
        let mut free = self.full_free;
        free[..4].copy_from_slice(&self.passed);
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
