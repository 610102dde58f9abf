//! Steps at a cut of the log or near one: judged between the segments, where the likelihood gives each its own mean.
//!
//! Block means over the whole log have the covariance C of `blocks`; −2 ln L = ln|C| + ln 1ᵀC⁻¹1 + rᵀC⁻¹r, the mean and the
//! regressors of the fit profiled out. A step betters it by (xᵀPy)²/xᵀPx, both sides with as much more random walk, flicker or
//! a Gauss–Markov process as each likes best: what the fit of the segments did not see may go on across a gap. Averaged over
//! the cuts and the samples near them, half of the weight on the cuts, it must reach a bound as `columns` has one.

use super::blocks::Blocks;
use super::estimate::{Active, ActiveKind, Work};
use super::likelihood::Parameters;
use super::linear::{cholesky, inverse};
use super::select::RAMP_THRESHOLD;
use super::steps::{self, Place, Step};
use super::types::Segment;
use std::ops::Range;

/// 2 ln of the average likelihood from which a step is named: χ²_1 passes it, with the choice between cut and surroundings,
/// in 0.03 % of axes a cut; more than a step within a segment needs, for a log may have many cuts.
const EVIDENCE: f64 = 12.0;
/// Most steps of this kind.
const MOST: usize = 12;
/// Least share of the log on either side of a step.
const LEAST_SIDE: f64 = 0.02;
/// Variances tried of a process beside those of the fit, and correlation times as shares of the log.
const TRIED: usize = 14;
const TIMES: [f64; 3] = [1.0 / 40.0, 1.0 / 12.0, 0.25];
/// 2 Δ ln L by which another place must be better than the one where a step stands.
const ELSEWHERE: f64 = 4.0;
/// 2 Δ ln L below which a step of a segment is none of the log.
const LEAST_GAIN: f64 = 9.0;

/// The columns that are in, and what else is tried.
struct Search<'a> {
    blocks: &'a Blocks,
    y: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

/// Whitened columns made orthonormal, the whitened rest of y, ln|C| + ln 1ᵀC⁻¹1.
struct Whitened {
    factor: Vec<f64>,
    basis: Vec<Vec<f64>>,
    rest: Vec<f64>,
    log: f64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// L⁻¹x.
fn whiten(factor: &[f64], x: &[f64]) -> Vec<f64> {
    let m = x.len();
    let mut out = vec![0.0; m];
    for i in 0..m {
        let row = &factor[i * m..i * m + i];
        out[i] = (x[i] - dot(row, &out[..i])) / factor[i * m + i];
    }
    out
}

impl Whitened {
    fn new(search: &Search<'_>, covariance: &[f64]) -> Option<Self> {
        let m = search.y.len();
        let factor = cholesky(covariance, m)?;
        let mut log: f64 = (0..m).map(|i| 2.0 * factor[i * m + i].ln()).sum();
        let mut out = Self {
            basis: Vec::with_capacity(search.columns.len()),
            rest: Vec::new(),
            log: 0.0,
            factor,
        };
        for (i, column) in search.columns.iter().enumerate() {
            let (mut own, square) = out.apart(column);
            let left = dot(&own, &own);
            if i == 0 {
                log += left.ln();
            }
            // A column that the others hold adds nothing.
            if left > 1e-9 * square {
                let unit = 1.0 / left.sqrt();
                for v in &mut own {
                    *v *= unit;
                }
                out.basis.push(own);
            }
        }
        out.rest = out.apart(&search.y).0;
        out.log = log;
        Some(out)
    }

    /// What the columns leave of a whitened vector, and its square before.
    fn apart(&self, x: &[f64]) -> (Vec<f64>, f64) {
        let mut own = whiten(&self.factor, x);
        let square = dot(&own, &own);
        for q in &self.basis {
            let share = dot(q, &own);
            own.iter_mut().zip(q).for_each(|(v, q)| *v -= share * q);
        }
        (own, square)
    }

    fn objective(&self) -> f64 {
        self.log + dot(&self.rest, &self.rest)
    }

    /// What a further column takes off the objective.
    fn gain(&self, column: &[f64]) -> f64 {
        let (own, square) = self.apart(column);
        let left = dot(&own, &own);
        if left > 1e-9 * square {
            dot(&own, &self.rest).powi(2) / left
        } else {
            0.0
        }
    }
}

/// What was found.
pub(super) struct Found {
    /// All steps of the log, in order of time.
    pub steps: Vec<Step>,
    /// Those that lie inside a segment and are not among its regressors, with the blocks around: first sample, end.
    pub inside: Vec<(Place, Range<usize>)>,
    /// Whether the regressors have a step that is none.
    pub is_fewer: bool,
}

/// Steps of a log in several segments: those that its regressors have, moved where they stand better, and those at or near
/// its cuts; none where the covariance cannot be factored.
pub(super) fn find(
    work: &Work,
    segments: &[Segment<'_>],
    temperature: Option<&[Segment<'_>]>,
    active: &[Active],
    parameters: &Parameters,
) -> Option<Found> {
    let known = steps::places(active);
    let blocks = Blocks::new(work, segments, &known);
    let covariance = blocks.covariance(parameters);
    let mut search = Search {
        blocks: &blocks,
        y: blocks.all.iter().map(|b| b.mean).collect(),
        columns: columns(&blocks, temperature, active),
    };
    let places = Places::new(work, &blocks);
    // Borders of the steps, those of the regressors first.
    let mut borders: Vec<usize> = known.iter().filter_map(|&p| blocks.border(p)).collect();
    for k in 0..borders.len() {
        if let Some(better) = search.moved(&covariance, &places, &borders, k) {
            borders[k] = better;
        }
    }
    borders.sort_unstable();
    borders.dedup();
    search.drop_idle(&covariance, &mut borders)?;
    let own = borders.len();
    let fixed = search.columns.len();
    search
        .columns
        .extend(borders.iter().map(|&b| blocks.step(b)));
    let mut line = false;
    while borders.len() < own + MOST {
        let Some((border, ratio, evidence)) = search.likeliest(&covariance, &places) else {
            break;
        };
        let slope: Vec<f64> = (0..blocks.all.len()).map(|i| blocks.middle(i)).collect();
        if evidence < EVIDENCE {
            break;
        }
        // A drift that no segment shows by itself makes no steps.
        if !line && search.ratio(&covariance, &slope)? - RAMP_THRESHOLD > ratio - EVIDENCE {
            line = true;
            search.columns.insert(fixed, slope);
            continue;
        }
        borders.push(border);
        search.columns.push(blocks.step(border));
    }
    let heights = search.heights(&covariance, borders.len())?;
    let mut found = Found {
        steps: Vec::new(),
        inside: Vec::new(),
        is_fewer: false,
    };
    for (&border, height) in borders.iter().zip(heights) {
        let block = &blocks.all[border];
        let place = (block.segment, block.from);
        found.steps.push(Step {
            place,
            height: Some(height),
        });
        if block.from > 0 && !known.contains(&place) {
            let before = &blocks.all[border - 1];
            found
                .inside
                .push((place, before.from..block.from + block.samples));
        }
    }
    found.steps.sort_by_key(|s| s.place);
    let stays = |p: &Place| found.steps.iter().any(|s| s.place == *p);
    found.is_fewer = !known.iter().all(stays);
    Some(found)
}

/// Constant and regressors as block means; a temperature that was recorded takes part whether or not a segment shows it.
fn columns(
    blocks: &Blocks,
    temperature: Option<&[Segment<'_>]>,
    active: &[Active],
) -> Vec<Vec<f64>> {
    let m = blocks.all.len();
    let mut out = vec![vec![1.0; m]];
    for a in active {
        match a.kind {
            ActiveKind::Ramp => out.push((0..m).map(|i| blocks.middle(i)).collect()),
            ActiveKind::WarmUp(tau) => {
                out.push((0..m).map(|i| (-blocks.middle(i) / tau).exp()).collect());
            }
            ActiveKind::Temperature(_) | ActiveKind::Step(..) => {}
        }
    }
    if let Some(temperature) = temperature {
        let square = active.iter().any(|a| a.kind == ActiveKind::Temperature(2));
        let means: Vec<f64> = blocks
            .all
            .iter()
            .map(|b| {
                let own = &temperature[b.segment].samples;
                let part = &own[b.from..(b.from + b.samples).min(own.len())];
                part.iter().sum::<f64>() / part.len() as f64
            })
            .collect();
        let center = means.iter().sum::<f64>() / m as f64;
        for power in 1..=1 + i32::from(square) {
            out.push(means.iter().map(|t| (t - center).powi(power)).collect());
        }
    }
    out
}

/// Borders between blocks where a step may lie that no segment is asked about, with their weights (sum 1).
struct Places(Vec<(usize, f64)>);

impl Places {
    fn new(work: &Work, blocks: &Blocks) -> Self {
        let total = blocks.samples as f64;
        let least = LEAST_SIDE * total;
        let edge = least.max(10.0);
        let (mut cuts, mut near) = (Vec::new(), Vec::new());
        let mut before = 0.0;
        for (i, block) in blocks.all.iter().enumerate() {
            if i > 0 && before >= least && total - before >= least {
                let n = work.segments[block.segment].n as f64;
                let from = block.from as f64;
                if block.is_cut {
                    cuts.push((i, 1.0));
                } else if from.min(n - from) <= edge || n < 2.0 * edge + 128.0 {
                    near.push((i, block.samples as f64));
                }
            }
            before += block.samples as f64;
        }
        let mut out = Vec::with_capacity(cuts.len() + near.len());
        for group in [cuts, near] {
            let sum: f64 = group.iter().map(|p| p.1).sum();
            out.extend(group.iter().map(|p| (p.0, 0.5 * p.1 / sum)));
        }
        Self(out)
    }
}

impl Blocks {
    /// The border that begins with this sample of a segment.
    fn border(&self, place: Place) -> Option<usize> {
        let mut all = self.all.iter();
        all.position(|b| (b.segment, b.from) == place)
    }
}

impl Search<'_> {
    /// The search as it is without step `k`, and how much that step betters it.
    fn without(&self, covariance: &[f64], borders: &[usize], k: usize) -> Option<(Whitened, f64)> {
        let mut columns = self.columns.clone();
        let others = borders.iter().enumerate().filter(|(i, _)| *i != k);
        columns.extend(others.map(|(_, &b)| self.blocks.step(b)));
        let search = Search {
            blocks: self.blocks,
            y: self.y.clone(),
            columns,
        };
        let white = Whitened::new(&search, covariance)?;
        let gain = white.gain(&self.blocks.step(borders[k]));
        Some((white, gain))
    }

    /// Drops steps of the regressors that tell nothing beside the others, once levels hold across the cuts.
    fn drop_idle(&self, covariance: &[f64], borders: &mut Vec<usize>) -> Option<()> {
        while !borders.is_empty() {
            let mut least = (f64::INFINITY, 0);
            for k in 0..borders.len() {
                let (_, gain) = self.without(covariance, borders, k)?;
                if gain < least.0 {
                    least = (gain, k);
                }
            }
            if least.0 >= LEAST_GAIN {
                break;
            }
            borders.remove(least.1);
        }
        Some(())
    }

    /// A place near a cut where step `k` stands better, the others as they are.
    fn moved(
        &self,
        covariance: &[f64],
        places: &Places,
        borders: &[usize],
        k: usize,
    ) -> Option<usize> {
        let (white, own) = self.without(covariance, borders, k)?;
        let near = 2.0 * LEAST_SIDE * self.blocks.span();
        let here = self.blocks.middle(borders[k]);
        places
            .0
            .iter()
            .filter(|p| (self.blocks.middle(p.0) - here).abs() < near)
            .map(|p| (p.0, white.gain(&self.blocks.step(p.0))))
            .filter(|p| p.1 > own + ELSEWHERE)
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|p| p.0)
    }

    /// The likeliest place of one more step, its ratio, and the evidence averaged over the places.
    fn likeliest(&self, covariance: &[f64], places: &Places) -> Option<(usize, f64, f64)> {
        let white = Whitened::new(self, covariance)?;
        let scores: Vec<(usize, f64, f64)> = places
            .0
            .iter()
            .map(|&(i, weight)| (i, weight, white.gain(&self.blocks.step(i))))
            .collect();
        let (best, _, largest) = *scores.iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
        let average: f64 = scores
            .iter()
            .map(|(_, weight, score)| weight * (0.5 * (score - largest)).exp())
            .sum();
        let choice = 2.0 * average.ln();
        if largest + choice < EVIDENCE {
            return None;
        }
        let ratio = self.ratio(covariance, &self.blocks.step(best))?;
        // A cut is where it is by itself; beside it the noise chooses.
        let cut = scores
            .iter()
            .filter(|s| self.blocks.all[s.0].is_cut && s.2 > largest - ELSEWHERE)
            .max_by(|a, b| a.2.total_cmp(&b.2));
        Some((cut.map_or(best, |c| c.0), ratio, ratio + choice))
    }

    /// 2 Δ ln L of a column, with and without it as much more of one process as betters the fit most.
    fn ratio(&self, covariance: &[f64], column: &[f64]) -> Option<f64> {
        let (without, with) = self.best(covariance, column)?;
        Some(without.0 - with.0)
    }

    /// The lowest objective without and with a column, each with the covariance that gives it.
    #[allow(clippy::type_complexity, reason = "twice the same pair")]
    fn best(
        &self,
        covariance: &[f64],
        column: &[f64],
    ) -> Option<((f64, Vec<f64>), (f64, Vec<f64>))> {
        let judge = |c: &[f64]| {
            let white = Whitened::new(self, c)?;
            let objective = white.objective();
            Some([objective, objective - white.gain(column)])
        };
        let mut best = judge(covariance)?.map(|o| (o, covariance.to_vec()));
        let span = self.blocks.span();
        let mut units = vec![self.blocks.walk(), self.blocks.flicker()];
        units.extend(TIMES.map(|share| self.blocks.markov((share * span).ln())));
        let size = self.y.iter().fold(0.0_f64, |a, y| a.max(y.abs()));
        for unit in units {
            let m = self.y.len();
            // From what changes nothing to all that there is, by what it adds between the ends of the log.
            let whole = (unit[0] + unit[m * m - 1] - 2.0 * unit[m - 1]).max(1e-300);
            let least = covariance[0].min(covariance[m * m - 1]).min(size * size) / m as f64;
            let (low, high) = (
                (0.01 * least / whole).ln(),
                (4.0 * size * size / whole).ln(),
            );
            let mixed = |x: f64| -> Vec<f64> {
                let v = x.exp();
                covariance
                    .iter()
                    .zip(&unit)
                    .map(|(c, u)| c + v * u)
                    .collect()
            };
            let grid: Vec<(f64, [f64; 2])> = (0..TRIED)
                .map(|i| low + (high - low) * i as f64 / (TRIED - 1) as f64)
                .filter_map(|x| Some((x, judge(&mixed(x))?)))
                .collect();
            for (which, best) in best.iter_mut().enumerate() {
                let mut x = grid
                    .iter()
                    .min_by(|a, b| a.1[which].total_cmp(&b.1[which]))?
                    .0;
                let mut width = (high - low) / (TRIED - 1) as f64;
                let mut value = judge(&mixed(x))?[which];
                for _ in 0..3 {
                    width *= 0.5;
                    for near in [x - width, x + width] {
                        let own = judge(&mixed(near))?[which];
                        if own < value {
                            (x, value) = (near, own);
                        }
                    }
                }
                if value < best.0 {
                    *best = (value, mixed(x));
                }
            }
        }
        let [without, with] = best;
        Some((without, with))
    }

    /// Heights of the last `count` columns and their standard deviations, with the noise that fits best.
    fn heights(&self, covariance: &[f64], count: usize) -> Option<Vec<(f64, f64)>> {
        if count == 0 {
            return Some(Vec::new());
        }
        let ((_, best), _) = self.best(covariance, &self.columns[0])?;
        let m = self.y.len();
        let factor = cholesky(&best, m)?;
        let white: Vec<Vec<f64>> = self.columns.iter().map(|c| whiten(&factor, c)).collect();
        let y = whiten(&factor, &self.y);
        let p = white.len();
        let mut normal = vec![0.0; p * p];
        for i in 0..p {
            for j in 0..p {
                normal[i * p + j] = dot(&white[i], &white[j]);
            }
        }
        let spread = inverse(&normal, p)?;
        let right: Vec<f64> = white.iter().map(|w| dot(w, &y)).collect();
        let heights = (p - count..p).map(|i| {
            let height = dot(&spread[i * p..(i + 1) * p], &right);
            (height, spread[i * p + i].sqrt())
        });
        Some(heights.collect())
    }
}
