//! Accelerometer and gyro from a log turned by hand between still poses; no equipment.
//!
//! |f̂| = g in every pose gives the accelerometer; the directions of gravity before and after each turn give the
//! gyro that was integrated between them. Idea `[TEDALDI2014]`; here with weights, covariance and bias drift. Frame:
//! body x is the accelerometer's x axis, y lies in the plane of its x and y (m_xy = m_xz = m_yz = 0).
//!
//! ```
//! use sagnac_calibrate::multi_position::{Error, Options, Recording, calibrate};
//! // Still all the time: one pose is no calibration, and this is said.
//! let still = [vec![0.0; 1000], vec![0.0; 1000], vec![9.8; 1000]];
//! let recording = Recording { dt_s: 0.01, stamps_s: None, accel: [&still[0], &still[1], &still[2]], gyro: None };
//! let refused = calibrate(&recording, &Options::default());
//! assert!(matches!(refused, Err(Error::FewPoses { distinct: 1, .. })));
//! ```

mod accel;
mod add;
mod drift;
mod error;
mod frame;
mod gyro;
mod rests;
mod tell;
mod turns;

pub use error::Error;
pub use frame::into_fixture;

use nalgebra::{DMatrix, Vector3};
use sagnac_core::Sensor;

use crate::interval::{Scatter, median, rms};
use crate::stations::{Asked, AxisFit, Group, Held, Parameter, Status};

/// A hand-turned log, SI, a slice an axis.
#[derive(Clone, Copy, Debug)]
pub struct Recording<'a> {
    /// Sampling interval \[s\].
    pub dt_s: f64,
    /// Time stamps \[s\], ends of the samples' intervals; without them sample k = 1, 2, … ends at k dt.
    pub stamps_s: Option<&'a [f64]>,
    /// Accelerometer outputs \[m/s²\].
    pub accel: [&'a [f64]; 3],
    /// Gyro outputs \[rad/s\].
    pub gyro: Option<[&'a [f64]; 3]>,
}

impl Recording<'_> {
    fn samples(&self) -> usize {
        let gyro = self.gyro.iter().flatten().map(|a| a.len());
        self.accel
            .iter()
            .map(|a| a.len())
            .chain(gyro)
            .min()
            .unwrap_or(0)
    }

    /// Samples before which time jumps.
    fn gaps(&self) -> Vec<usize> {
        let Some(stamps) = self.stamps_s else {
            return Vec::new();
        };
        let limit = (5.0 * self.dt_s).max(0.3);
        (1..stamps.len())
            .filter(|k| {
                let step = stamps[*k] - stamps[*k - 1];
                step.is_nan() || step.abs() >= limit
            })
            .collect()
    }

    /// Times at which the samples `first..end` begin and end.
    fn span_s(&self, first: usize, end: usize) -> [f64; 2] {
        match self.stamps_s {
            Some(stamps) if end > 0 && end <= stamps.len() => {
                let from = if first == 0 {
                    stamps[0] - self.dt_s
                } else {
                    stamps[first - 1]
                };
                [from, stamps[end - 1]]
            }
            _ => [first as f64 * self.dt_s, end as f64 * self.dt_s],
        }
    }
}

/// What is known besides the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Size of gravity \[m/s²\].
    pub gravity_m_s2: f64,
    /// Latitude \[rad\], for the size of the Earth's rate as an error of the rests.
    pub latitude_rad: Option<f64>,
    /// Groups asked for: bias, `scale_factor`, misalignment, `g_sensitivity`.
    pub asked: Asked,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            gravity_m_s2: 9.80665,
            latitude_rad: None,
            asked: Asked::Default,
        }
    }
}

/// A still pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// The samples used: start < t ≤ end \[s\].
    pub start_s: f64,
    /// End \[s\].
    pub end_s: f64,
    /// Unit vector along the specific force, body axes.
    pub direction: [f64; 3],
    /// |f̂| − g \[m/s²\].
    pub residual: f64,
    /// Its standard deviation by the sensor's noise \[m/s²\].
    pub sigma: f64,
    /// |mean output| − g \[m/s²\].
    pub before: f64,
    /// Huber's weight: below 1 the pose does not fit the others.
    pub weight: f64,
    /// Mean gyro output less bias and g-sensitivity \[rad/s\].
    pub gyro_residual: Option<[f64; 3]>,
    /// Mean gyro output \[rad/s\].
    pub gyro_mean: Option<[f64; 3]>,
}

/// A turn between two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnError {
    /// Start \[s\].
    pub start_s: f64,
    /// End \[s\].
    pub end_s: f64,
    /// Angle between the direction of gravity and the one that the gyro leads to \[rad\].
    pub error_rad: f64,
    /// Its two components across gravity \[rad\].
    pub components_rad: [f64; 2],
    /// Their standard deviations by what is known of noise, drift and the Earth's rate \[rad\].
    pub sigma_rad: [f64; 2],
    /// Weight: below 1 the turn does not fit the others.
    pub weight: f64,
}

/// A pose to add.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseToAdd {
    /// Body direction to point up.
    pub up: [f64; 3],
    /// In words: `+x+z`.
    pub words: String,
    /// The term it helps most.
    pub improves: String,
    /// σ of that term now, at most its plausible size.
    pub sigma_before: f64,
    /// σ with the pose.
    pub sigma_after: f64,
}

/// A turn to add: a quarter turn about a level axis.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnToAdd {
    /// Body axis to turn about.
    pub axis: [f64; 3],
    /// In words.
    pub words: String,
    /// The term it helps most.
    pub improves: String,
    /// σ of that term now, at most its plausible size.
    pub sigma_before: f64,
    /// σ with the turn.
    pub sigma_after: f64,
}

/// A stretch between rests that is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Broken {
    /// Start and end \[s\].
    pub span_s: [f64; 2],
    /// Time jumps in it; otherwise a sample is no number.
    pub is_gap: bool,
}

/// Drift of the gyro bias during the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroDrift {
    /// Random walk \[rad/s/√s\], 0 where none is seen: where chance alone would show one in one log of forty.
    pub rate_random_walk: [f64; 3],
    /// Its 95 % interval by the profile of the likelihood, `[0, 0]` where none is seen.
    pub interval: [[f64; 2]; 3],
    /// Largest change of the bias from one rest to the next \[rad/s\].
    pub largest: [f64; 3],
    /// Whether the Earth's rate was counted as an error of the rests: not where they scatter less than that.
    pub has_earth: bool,
}

/// What a hand-turned log gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Estimated terms.
    pub parameters: Vec<Parameter>,
    /// Covariance of all of them, in their order.
    pub covariance: Vec<Vec<f64>>,
    /// Terms held at zero.
    pub held: Vec<Held>,
    /// Terms determined and not asked for.
    pub available: Vec<String>,
    /// Pairs with |correlation| > 0.95, strongest first.
    pub confused: Vec<(String, String, f64)>,
    /// Goodness of fit of the accelerometer and of the gyro.
    pub fits: Vec<AxisFit>,
    /// The poses.
    pub poses: Vec<Pose>,
    /// The turns.
    pub turns: Vec<TurnError>,
    /// Poses to add, best first.
    pub add_poses: Vec<PoseToAdd>,
    /// Turns to add, best first.
    pub add_turns: Vec<TurnToAdd>,
    /// Root mean square of |f̂| − g \[m/s²\].
    pub accel_rms: f64,
    /// The same with no correction.
    pub before_rms: f64,
    /// Root mean square turn error \[rad\]; none without gyro.
    pub gyro_rms: Option<f64>,
    /// Standard deviation of an accelerometer axis over 0.3 s above which the sensor counts as moving \[m/s²\].
    pub threshold_m_s2: f64,
    /// Share of all directions within 30° of a pose.
    pub covered: f64,
    /// Drift of the gyro; none without gyro.
    pub gyro_drift: Option<GyroDrift>,
    /// Why there is no gyro estimate although the log has a gyro.
    pub gyro_refused: Option<Error>,
    /// Turns left out because the gyro saturates in them: start and end \[s\].
    pub saturated: Vec<[f64; 2]>,
    /// Stretches between rests that are left out, for time jumps in them or a sample is no number.
    pub broken: Vec<Broken>,
    /// Steady stretches that turn all the while, and so are no rests: start and end \[s\].
    pub turning: Vec<[f64; 2]>,
    /// Standard deviation of a sample, accelerometer and gyro.
    pub noise: [Option<[f64; 3]>; 2],
}

impl Outcome {
    /// The parameter of a path.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|p| p.name == name)
    }
}

/// Rests closer than this have no turn between them.
const SHORTEST_TURN_S: f64 = 0.35;
/// 0.15 s that are cut at both ends of the two rests beside a turn.
const CUTS_S: f64 = 0.3;

/// Estimates accelerometer and gyro from a hand-turned log.
///
/// # Errors
/// See [`Error`].
pub fn calibrate(recording: &Recording, options: &Options) -> Result<Outcome, Error> {
    let found = rests::find(recording);
    error::check(recording, &found, options)?;
    let rests = &found.rests;
    let means: Vec<Vector3<f64>> = rests.iter().map(|r| Vector3::from(r.accel)).collect();
    let directions: Vec<Vector3<f64>> = means.iter().map(Vector3::normalize).collect();
    error::few(rests, &directions)?;
    let accel_sigma = rests::noise(&recording.accel, rests, recording.dt_s);
    let se: Vec<[f64; 3]> = rests
        .iter()
        .map(|r| accel_sigma.map(|s| s / r.samples().sqrt()))
        .collect();
    let usual = |sigma: [f64; 3]| {
        let samples = median(rests.iter().map(rests::Rest::samples).collect()).unwrap_or(1.0);
        sigma.map(|s| s / samples.sqrt())
    };
    let asked = accel::TERMS.map(|(_, term)| options.asked.has(term.group, false));
    let fit = match accel::fit(&means, &se, &asked, options) {
        Err(Error::Diverged) => {
            return Err(error::ran_away(&asked, &directions, usual(accel_sigma)));
        }
        other => other?,
    };
    error::enough(&fit, &asked, &directions, usual(accel_sigma))?;
    let mut out = Outcome {
        parameters: Vec::new(),
        covariance: Vec::new(),
        held: Vec::new(),
        available: Vec::new(),
        confused: Vec::new(),
        fits: vec![fit_of("accel", fit.chi2, fit.dof, &fit.scatter)],
        poses: poses(recording, rests, &fit, options.gravity_m_s2),
        turns: Vec::new(),
        add_poses: Vec::new(),
        add_turns: Vec::new(),
        accel_rms: rms(fit.residuals.iter().copied()),
        before_rms: rms(means.iter().map(|m| m.norm() - options.gravity_m_s2)),
        gyro_rms: None,
        threshold_m_s2: found.threshold_m_s2,
        covered: add::covered(&directions),
        gyro_drift: None,
        gyro_refused: None,
        saturated: Vec::new(),
        broken: broken(recording, &found),
        turning: found
            .turning
            .iter()
            .map(|r| recording.span_s(r.first, r.end))
            .collect(),
        noise: [Some(accel_sigma), None],
    };
    out.add_poses = add::poses(&fit, &asked, usual(accel_sigma), options.gravity_m_s2);
    tell::accel(&fit, &asked, &mut out);
    tell::rest(Sensor::Accel, &options.asked, &mut out);
    if let Some(gyro) = &recording.gyro {
        match turn(
            recording,
            gyro,
            &found,
            &fit,
            accel_sigma,
            options,
            &mut out,
        ) {
            Ok(()) => {}
            Err(error) => out.gyro_refused = Some(error),
        }
        tell::rest(Sensor::Gyro, &options.asked, &mut out);
    }
    out.confused.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
    Ok(out)
}

fn fit_of(axis: &str, chi2: f64, dof: usize, scatter: &Scatter) -> AxisFit {
    AxisFit {
        axis: axis.to_owned(),
        chi2,
        dof,
        p: if dof > 0 { scatter.p } else { None },
        scaled: scatter.scaled,
    }
}

fn poses(recording: &Recording, rests: &[rests::Rest], fit: &accel::Fit, g: f64) -> Vec<Pose> {
    rests
        .iter()
        .enumerate()
        .map(|(i, rest)| {
            let [start_s, end_s] = recording.span_s(rest.first, rest.end);
            Pose {
                start_s,
                end_s,
                direction: fit.forces[i].normalize().into(),
                residual: fit.residuals[i],
                sigma: fit.sigmas[i],
                before: Vector3::from(rest.accel).norm() - g,
                weight: fit.weights[i],
                gyro_residual: None,
                gyro_mean: rest.gyro,
            }
        })
        .collect()
}

/// The largest size each axis of the gyro has in the log.
fn largest(gyro: &[&[f64]; 3]) -> [f64; 3] {
    gyro.map(|axis| {
        axis.iter()
            .filter(|v| v.is_finite())
            .fold(0.0, |m: f64, v| m.max(v.abs()))
    })
}

/// Whether an axis stays at its largest size for three samples, as a gyro beyond its range does.
fn saturates(gyro: &[&[f64]; 3], largest: [f64; 3], turn: turns::Turn) -> bool {
    gyro.iter().zip(largest).any(|(axis, largest)| {
        let at = |v: &f64| v.abs() >= largest * (1.0 - 1e-6);
        largest > 0.5
            && axis[turn.first..turn.end]
                .windows(3)
                .any(|w| w.iter().all(at))
    })
}

/// The stretch between each rest and the next.
fn between(found: &rests::Found) -> impl Iterator<Item = turns::Turn> + '_ {
    found
        .rests
        .windows(2)
        .enumerate()
        .map(|(rest, pair)| turns::Turn {
            rest,
            first: pair[0].end,
            end: pair[1].first,
        })
}

/// The stretches between rests that have a gap or a sample that is no number.
fn broken(recording: &Recording, found: &rests::Found) -> Vec<Broken> {
    between(found)
        .filter_map(|turn| {
            let is_gap = has_gap(found, turn);
            (is_gap || !is_finite(recording, turn)).then(|| Broken {
                span_s: recording.span_s(turn.first, turn.end),
                is_gap,
            })
        })
        .collect()
}

fn has_gap(found: &rests::Found, turn: turns::Turn) -> bool {
    found.gaps.iter().any(|g| *g > turn.first && *g <= turn.end)
}

fn is_finite(recording: &Recording, turn: turns::Turn) -> bool {
    recording
        .gyro
        .iter()
        .flatten()
        .chain(&recording.accel)
        .all(|axis| axis[turn.first..turn.end].iter().all(|v| v.is_finite()))
}

/// The stretches between rests that are turns: no gap in them, nothing that is not a number, not a mere knock.
fn turns_between(
    recording: &Recording,
    gyro: &[&[f64]; 3],
    found: &rests::Found,
    largest: [f64; 3],
) -> Vec<turns::Turn> {
    let shortest = ((SHORTEST_TURN_S + CUTS_S) / recording.dt_s).round() as usize;
    between(found)
        .filter(|turn| {
            turn.end - turn.first >= shortest
                && !has_gap(found, *turn)
                && !saturates(gyro, largest, *turn)
                && is_finite(recording, *turn)
        })
        .collect()
}

fn turn(
    recording: &Recording,
    gyro: &[&[f64]; 3],
    found: &rests::Found,
    accel: &accel::Fit,
    accel_sigma: [f64; 3],
    options: &Options,
    out: &mut Outcome,
) -> Result<(), Error> {
    let rests = &found.rests;
    let largest = largest(gyro);
    let turns = turns_between(recording, gyro, found, largest);
    out.saturated = between(found)
        .filter(|turn| saturates(gyro, largest, *turn))
        .map(|turn| recording.span_s(turn.first, turn.end))
        .collect();
    let gyro_sigma = rests::noise(gyro, rests, recording.dt_s);
    out.noise[1] = Some(gyro_sigma);
    if turns.is_empty() {
        return Err(Error::NoTurns);
    }
    let asked = gyro::TERMS.map(|(_, term)| options.asked.has(term.group, false));
    let input = gyro::Input {
        recording,
        gyro,
        rests,
        turns: &turns,
        accel,
        accel_sigma,
        gyro_sigma,
        asked: &asked,
        latitude_rad: options.latitude_rad,
    };
    let fit = gyro::fit(&input)?;
    let errors = fit.errors.clone();
    error::turns_agree(median(errors.clone()).unwrap_or(0.0))?;
    for (i, turn) in turns.iter().enumerate() {
        let [start_s, end_s] = recording.span_s(turn.first, turn.end);
        out.turns.push(TurnError {
            start_s,
            end_s,
            error_rad: errors[i],
            components_rad: fit.components[i],
            sigma_rad: fit.component_sigmas[i],
            weight: fit.weights[i],
        });
    }
    for (pose, residual) in out.poses.iter_mut().zip(&fit.rest_residuals) {
        pose.gyro_residual = Some(*residual);
    }
    out.gyro_rms = Some(rms(errors.iter().copied()));
    out.gyro_drift = Some(GyroDrift {
        rate_random_walk: [0, 1, 2].map(|k| {
            if fit.drift.seen[k] {
                fit.drift.rate[k]
            } else {
                0.0
            }
        }),
        interval: [0, 1, 2].map(|k| {
            if fit.drift.seen[k] {
                fit.drift.interval[k]
            } else {
                [0.0; 2]
            }
        }),
        largest: fit.largest_change,
        has_earth: fit.drift.has_earth,
    });
    out.fits
        .push(fit_of("gyro", fit.chi2, fit.dof, &fit.scatter));
    let lengths = turns
        .iter()
        .map(|t| (t.end - t.first) as f64 * recording.dt_s)
        .collect();
    let samples = median(rests.iter().map(rests::Rest::samples).collect()).unwrap_or(1.0);
    let across = accel_sigma.iter().map(|s| s * s).sum::<f64>() / 3.0 / samples;
    out.add_turns = add::turns(
        &fit,
        &asked,
        &turns::Correction {
            bias: Vector3::zeros(),
            inverse: nalgebra::Matrix3::identity(),
            g: nalgebra::Matrix3::zeros(),
            sigma: gyro_sigma,
        },
        median(lengths).unwrap_or(1.0),
        across.sqrt() / options.gravity_m_s2,
        options.gravity_m_s2,
    );
    tell::gyro(&fit, &asked, out);
    Ok(())
}

/// A square block appended to the diagonal, with the covariance to what is there.
fn append(covariance: &mut Vec<Vec<f64>>, block: &DMatrix<f64>, with: Option<&DMatrix<f64>>) {
    let (first, q) = (covariance.len(), block.nrows());
    for (i, row) in covariance.iter_mut().enumerate() {
        row.extend((0..q).map(|j| with.map_or(0.0, |w| w[(j, i)])));
    }
    for j in 0..q {
        let mut row: Vec<f64> = (0..first)
            .map(|i| with.map_or(0.0, |w| w[(j, i)]))
            .collect();
        row.extend((0..q).map(|i| block[(j, i)]));
        covariance.push(row);
    }
}

/// What [`tell`] needs of an estimate.
struct Told<'a> {
    sensor: Sensor,
    terms: &'a [(usize, crate::stations::Term)],
    values: &'a [f64],
    plausible: &'a dyn Fn(usize) -> f64,
    status: &'a [Status],
    estimated: &'a [usize],
    asked: &'a [bool],
    design: &'a DMatrix<f64>,
    covariance: &'a DMatrix<f64>,
    quantile: f64,
}

/// The name of a group as `--terms` knows it.
pub const GROUPS: [Group; 4] = [
    Group::Bias,
    Group::ScaleFactor,
    Group::Misalignment,
    Group::GSensitivity,
];
