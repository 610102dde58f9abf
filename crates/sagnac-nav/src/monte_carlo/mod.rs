//! Drift by Monte Carlo: the whole nonlinear sensor (draws, random terms, range, rounding), its correction and the
//! strapdown at full rate, eight runs to a vector (navigation.md §3.1).
//!
//! Run r uses the streams of run r of `simulate --runs`; the result does not depend on threads.

mod stage;
mod start;
#[cfg(test)]
mod tests;
mod truth;
mod unit;

use crate::Error;
use crate::attitude::{mul, mul_vec_t, sub, to_rotation_vector, transpose};
use crate::covariance::report_times_s;
use crate::drift::Setting;
use crate::ellipse::{Sampled, quantile, rms};
use crate::sensor::{Calibration, SensorErrors};
use crate::strapdown::{Sculling, State, Strapdown};
use crate::trajectory::Trajectory;
use rayon::prelude::*;
use sagnac_core::Compensation;
use start::aligned;
use truth::{Channels, segment};
use unit::{BLOCK, EMPTY, Rows, Scratch, Unit, cholesky};

/// Runs stepped together.
const LANES: usize = 8;
/// Samples of truth held at once: few enough for the cache that the groups of runs share.
const SEGMENT: usize = 1 << 14;

/// What a Monte Carlo is asked.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The motion.
    pub trajectory: &'a Trajectory,
    /// Length, rate, alignment …
    pub setting: Setting,
    /// Form of the strapdown.
    pub sculling: Sculling,
    /// The sensor.
    pub sensor: &'a SensorErrors,
    /// Runs.
    pub runs: u32,
    /// Seed.
    pub seed: u64,
}

/// Errors of every run at the report times.
#[derive(Debug, Clone, PartialEq)]
pub struct MonteCarloDrift {
    /// Report times, s.
    pub time_s: Vec<f64>,
    /// `errors[time][run]`: position, velocity, attitude in north, east, down.
    pub errors: Vec<Vec<[f64; 9]>>,
    /// Samples that a range cut off, all runs and axes.
    pub clipped: u64,
    /// Samples outside the validity of the correction.
    pub outside_validity: u64,
}

impl MonteCarloDrift {
    fn radii(&self, time: usize) -> Vec<f64> {
        let mut out: Vec<f64> = self.errors[time].iter().map(|e| e[0].hypot(e[1])).collect();
        out.sort_by(f64::total_cmp);
        out
    }

    /// CEP (the median) at each time; `tail` in each tail of the interval, 0.025 for 95 %.
    pub fn cep(&self, tail: f64) -> Vec<Sampled> {
        (0..self.time_s.len())
            .map(|i| quantile(&self.radii(i), 0.5, tail))
            .collect()
    }

    /// R95 at each time.
    pub fn r95(&self, tail: f64) -> Vec<Sampled> {
        (0..self.time_s.len())
            .map(|i| quantile(&self.radii(i), 0.95, tail))
            .collect()
    }

    /// RMS of the horizontal error at each time; `z` = 1.96 for 95 %.
    pub fn rms(&self, z: f64) -> Vec<Sampled> {
        (0..self.time_s.len())
            .map(|i| rms(&self.radii(i), z))
            .collect()
    }

    /// RMS of component `i` (north, east, down; velocities; ε) at each time.
    pub fn rms_of(&self, i: usize) -> Vec<f64> {
        self.errors
            .iter()
            .map(|e| (e.iter().map(|x| x[i] * x[i]).sum::<f64>() / e.len() as f64).sqrt())
            .collect()
    }

    /// Whether the errors were small enough for linear numbers: RMS attitude up to 0.1 rad, RMS position up to 100 km.
    pub fn is_linear(&self) -> bool {
        let attitude: Vec<Vec<f64>> = (6..9).map(|i| self.rms_of(i)).collect();
        (0..self.time_s.len()).all(|t| {
            let a =
                (attitude[0][t].powi(2) + attitude[1][t].powi(2) + attitude[2][t].powi(2)).sqrt();
            a <= 0.1 && self.rms(1.96)[t].value_m <= 1e5
        })
    }
}

/// Corrected output of a lane, its vectors beginning with the lines of the cache.
#[derive(Clone)]
#[repr(align(64))]
struct LaneRows(Rows);

struct Group {
    units: Vec<Unit>,
    nav: Strapdown<LANES>,
    found: Vec<[State; LANES]>,
    clipped: u64,
    invalid: u64,
    scratch: Box<Scratch>,
    /// Corrected output of every lane.
    rows: Vec<LaneRows>,
    /// Lanes that are runs of the request.
    used: usize,
}

impl Group {
    /// Steps all lanes over a segment of the truth.
    fn run(
        &mut self,
        truth: &Channels,
        count: usize,
        correct: Option<&Compensation<f64>>,
        dt_s: f64,
        last: bool,
        steps: &[u64],
    ) {
        let mut from = 0;
        while from < count {
            let n = BLOCK.min(count - from);
            let lanes = self.units.iter_mut().zip(self.rows.iter_mut());
            for (lane, (unit, rows)) in lanes.enumerate() {
                let (clipped, invalid) = unit.block(
                    truth,
                    from,
                    n,
                    correct,
                    dt_s,
                    false,
                    &mut self.scratch,
                    &mut rows.0,
                );
                if lane < self.used {
                    self.clipped += clipped;
                    self.invalid += invalid;
                }
            }
            let vertical = &truth.vertical[from..from + n];
            let rows = std::array::from_fn(|lane| &self.rows[lane].0);
            self.nav.feed_rows(dt_s, rows, vertical);
            from += n;
            let found = &mut self.found;
            follow(&mut self.nav, steps, last && from == count, &mut |nav| {
                found.push(std::array::from_fn(|l| nav.state(l)));
            });
        }
    }
}

/// Runs the Monte Carlo; `progress` hears how many of how many samples of the trajectory are done.
///
/// # Errors
/// No runs, a duration or rate that is not possible, a model that cannot be inverted, a self-alignment that cannot find
/// a heading.
pub fn monte_carlo(
    request: &Request<'_>,
    temperature: &(dyn Fn(f64) -> f64 + Sync),
    progress: &mut dyn FnMut(u64, u64),
) -> Result<MonteCarloDrift, Error> {
    let setting = request.setting;
    if request.runs == 0 {
        return Err(Error::Request {
            what: "0 runs tell nothing".to_owned(),
            advice: "use --runs 200, or --method covariance".to_owned(),
        });
    }
    request.trajectory.check_duration(setting.duration_s)?;
    let earth = request.trajectory.earth();
    let dt = setting.dt_s;
    let total = (setting.duration_s / dt).round().max(1.0) as u64;
    if total.saturating_mul(u64::from(request.runs)) > 200_000_000_000 {
        return Err(Error::Request {
            what: format!("{} runs of {total} samples would take days", request.runs),
            advice: "use fewer runs, a shorter duration or --method covariance".to_owned(),
        });
    }
    let correct = match setting.calibration {
        Calibration::None => None,
        _ => Some(
            Compensation::new(&request.sensor.model, dt).map_err(|e| Error::Request {
                what: e.to_string(),
                advice: String::new(),
            })?,
        ),
    };
    let start = request.trajectory.at(0.0);
    let truth_state: State = start.into();
    let factors: Vec<Vec<f64>> = request.sensor.correlated.iter().map(cholesky).collect();
    let groups_count = (request.runs as usize).div_ceil(LANES);
    let mut groups: Vec<Group> = (0..groups_count)
        .into_par_iter()
        .map(|g| {
            let mut scratch = Scratch::new();
            let (mut units, mut flicker) = (Vec::new(), None);
            let mut initial = [truth_state; LANES];
            for lane in 0..LANES {
                let run = (g * LANES + lane) as u32 + 1;
                // Lanes beyond the last run are idle copies of it: their results are not read.
                let run = run.min(request.runs);
                let mut unit = Unit::new(request, run, &factors, &mut flicker)?;
                initial[lane].e_from_b = aligned(
                    request,
                    run,
                    &mut unit,
                    &truth_state,
                    correct.as_ref(),
                    temperature(0.0),
                    &mut scratch,
                );
                units.push(unit);
            }
            Ok(Group {
                used: (request.runs as usize - g * LANES).min(LANES),
                units,
                nav: Strapdown::new(earth, request.sculling, setting.vertical, initial),
                found: Vec::new(),
                clipped: 0,
                invalid: 0,
                scratch,
                rows: vec![LaneRows(EMPTY); LANES],
            })
        })
        .collect::<Result<_, Error>>()?;
    let mut reference =
        Strapdown::<1>::new(earth, request.sculling, setting.vertical, [truth_state]);
    let time_s = report_times_s(setting.duration_s, dt);
    let steps: Vec<u64> = time_s.iter().map(|t| (t / dt).round() as u64).collect();
    let mut reference_found: Vec<State> = Vec::new();

    let mut done = 0u64;
    let part = |done: u64| (total - done).min(SEGMENT as u64) as usize;
    let mut truth = segment(request.trajectory, dt, 0, part(0), temperature);
    while done < total {
        let count = part(done);
        done += count as u64;
        let last = done == total;
        // Beside the groups of this segment: the run without errors, and the truth of the next.
        let ((), next) = rayon::join(
            || {
                groups.par_iter_mut().with_max_len(1).for_each(|group| {
                    group.run(&truth, count, correct.as_ref(), dt, last, &steps);
                });
            },
            || {
                for i in 0..count {
                    reference.feed(
                        dt,
                        &std::array::from_fn(|c| {
                            [if c < 3 {
                                truth.rate[c][i]
                            } else {
                                truth.force[c - 3][i]
                            }]
                        }),
                        truth.vertical[i],
                    );
                }
                follow(&mut reference, &steps, last, &mut |nav| {
                    reference_found.push(nav.state(0));
                });
                segment(request.trajectory, dt, done, part(done), temperature)
            },
        );
        truth = next;
        progress(done, total);
    }
    let errors = (0..steps.len())
        .map(|i| {
            let truth = request.trajectory.at(time_s[i]);
            let e_from_n = truth.place.e_from_n();
            (0..request.runs as usize)
                .map(|run| {
                    let (state, clean) = (
                        &groups[run / LANES].found[i][run % LANES],
                        &reference_found[i],
                    );
                    let r = mul_vec_t(&e_from_n, sub(state.position_e, clean.position_e));
                    let v = mul_vec_t(&e_from_n, sub(state.velocity_e, clean.velocity_e));
                    let e = mul_vec_t(
                        &e_from_n,
                        to_rotation_vector(&mul(&state.e_from_b, &transpose(&clean.e_from_b))),
                    );
                    [r[0], r[1], r[2], v[0], v[1], v[2], e[0], e[1], e[2]]
                })
                .collect()
        })
        .collect();
    Ok(MonteCarloDrift {
        time_s,
        errors,
        clipped: groups.iter().map(|g| g.clipped).sum(),
        outside_validity: groups.iter().map(|g| g.invalid).sum(),
    })
}

/// Steps as far as possible, stopping at each report.
fn follow<const L: usize>(
    nav: &mut Strapdown<L>,
    steps: &[u64],
    last: bool,
    found: &mut dyn FnMut(&Strapdown<L>),
) {
    if last {
        nav.close();
    }
    let mut next = steps.partition_point(|s| *s <= nav.steps_done());
    loop {
        let before = nav.steps_done();
        nav.run_to(steps.get(next).copied().unwrap_or(u64::MAX));
        // Reports of a run with fewer samples than reports share a step.
        while next < steps.len() && steps[next] == nav.steps_done() {
            found(nav);
            next += 1;
        }
        if nav.steps_done() == before {
            break;
        }
    }
}
