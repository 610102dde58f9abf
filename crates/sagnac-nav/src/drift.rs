//! Position drift by error covariance: P = Σ P_i over the independent sources, with its budget (navigation.md §3.1, §3.2).

mod doubt;

pub use doubt::Doubt;

use crate::Error;
use crate::covariance::{Kind, Propagator, REPORTS, Response, Spread, Timeline};
use crate::ellipse::Horizontal;
use crate::sensor::{Calibration, SensorErrors, Source};
use crate::strapdown::Vertical;
use crate::trajectory::Trajectory;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// Knowledge of the attitude at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Alignment {
    /// No error.
    #[default]
    Perfect,
    /// From the sensor itself, at rest for 600 s before the start.
    SelfAligned,
    /// Independent 1σ rotations about forward, right (both horizontal) and down, rad.
    Given {
        /// About forward.
        roll_rad: f64,
        /// About right.
        pitch_rad: f64,
        /// About down.
        heading_rad: f64,
    },
}

/// How the drift is asked for, without the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Length, s.
    pub duration_s: f64,
    /// Sampling interval, s.
    pub dt_s: f64,
    /// Vertical channel.
    pub vertical: Vertical,
    /// Start attitude.
    pub alignment: Alignment,
    /// What is removed.
    pub calibration: Calibration,
}

/// One line of the budget.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Parameter path without axis, or `alignment`.
    pub term: String,
    /// Axis.
    pub axis: &'static str,
    /// Part of P_NN + P_EE at the end.
    pub share: f64,
    /// Its own spread at the report times.
    pub spread: Vec<Spread>,
}

/// The answer by covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct CovarianceDrift {
    /// Report times, s.
    pub time_s: Vec<f64>,
    /// All sources together, with the mean of `--calibration none`.
    pub total: Vec<Spread>,
    /// Mean errors (position, velocity, attitude in NED), zero unless nothing is corrected.
    pub mean: Vec<[f64; 9]>,
    /// By term and axis, largest share at the end first.
    pub budget: Vec<Entry>,
}

impl CovarianceDrift {
    /// CEP at each report time, m.
    pub fn cep_m(&self) -> Vec<f64> {
        self.total
            .iter()
            .map(|s| s.horizontal.radius_m(0.5))
            .collect()
    }

    /// R95 at each report time, m.
    pub fn r95_m(&self) -> Vec<f64> {
        self.total
            .iter()
            .map(|s| s.horizontal.radius_m(0.95))
            .collect()
    }

    /// RMS at each report time, m.
    pub fn rms_m(&self) -> Vec<f64> {
        self.total.iter().map(|s| s.horizontal.rms_m()).collect()
    }

    /// RMS of component `i` (north, east, down; velocities; ε) at each time.
    pub fn rms_of(&self, i: usize) -> Vec<f64> {
        self.total
            .iter()
            .zip(&self.mean)
            .map(|(s, m)| (s.variance[i].max(0.0) + m[i] * m[i]).sqrt())
            .collect()
    }

    /// Horizontal spread at the end.
    pub fn end(&self) -> Horizontal {
        self.total.last().map(|s| s.horizontal).unwrap_or_default()
    }

    /// Whether linear errors are good numbers: RMS attitude up to 0.1 rad and RMS position up to 100 km, always.
    pub fn is_valid(&self) -> bool {
        (0..self.total.len()).all(|i| {
            let (s, m) = (&self.total[i], &self.mean[i]);
            let attitude: f64 = (6..9).map(|k| s.variance[k] + m[k] * m[k]).sum();
            attitude.sqrt() <= 0.1 && s.horizontal.rms_m() <= 1e5
        })
    }

    /// Terms with axes together: (term, share, spread at the end), largest first.
    pub fn terms(&self) -> Vec<(String, f64, Horizontal)> {
        let mut out: Vec<(String, f64, Horizontal)> = Vec::new();
        for e in &self.budget {
            let h = e.spread.last().map(|s| s.horizontal).unwrap_or_default();
            match out.iter_mut().find(|(t, ..)| *t == e.term) {
                Some((_, share, sum)) => {
                    *share += e.share;
                    *sum = sum.plus(&h, 1.0);
                }
                None => out.push((e.term.clone(), e.share, h)),
            }
        }
        out.sort_by(|a, b| b.1.total_cmp(&a.1));
        out
    }

    /// Share of each of the given terms, axes together, at each time.
    pub fn shares_in_time(&self, term: &str) -> Vec<f64> {
        (0..self.total.len())
            .map(|i| {
                let power = |h: &Horizontal| h.north_north + h.east_east;
                let part: f64 = self
                    .budget
                    .iter()
                    .filter(|e| e.term == term)
                    .map(|e| power(&e.spread[i].horizontal))
                    .sum();
                let all: f64 = self
                    .budget
                    .iter()
                    .map(|e| power(&e.spread[i].horizontal))
                    .sum();
                if all > 0.0 { part / all } else { 0.0 }
            })
            .collect()
    }

    /// CEP at the end with one term scaled by `factor` (½: "if halved"), m.
    pub fn cep_with_m(&self, term: &str, factor: f64) -> f64 {
        let mut h = Horizontal {
            mean: self.end().mean,
            ..Horizontal::default()
        };
        for e in &self.budget {
            let own = e.spread.last().map(|s| s.horizontal).unwrap_or_default();
            h = h.plus(&own, if e.term == term { factor * factor } else { 1.0 });
        }
        h.radius_m(0.5)
    }
}

/// A run cut up once, with the unit responses found so far: what several sensors on one trajectory share.
#[derive(Debug)]
pub struct Scene {
    timeline: Timeline,
    setting: Setting,
    start_temperature_c: f64,
    /// Unit responses of a sensor whose correction changes nothing, by kind.
    cache: std::sync::Mutex<HashMap<String, Arc<Response>>>,
}

impl Scene {
    /// Prepares a trajectory. `temperature` is T(t), °C.
    ///
    /// # Errors
    /// A duration that is not positive or beyond the path's end, a rate that is not positive.
    pub fn new(
        trajectory: &Trajectory,
        setting: Setting,
        temperature: &dyn Fn(f64) -> f64,
    ) -> Result<Self, Error> {
        trajectory.check_duration(setting.duration_s)?;
        if setting.dt_s.is_nan() || setting.dt_s <= 0.0 {
            return Err(Error::OutOfRange {
                quantity: "sampling interval",
                value: format!("{} s", setting.dt_s),
                expected: "more than zero",
            });
        }
        if setting.dt_s > setting.duration_s {
            return Err(Error::TooShort {
                duration_s: setting.duration_s,
                dt_s: setting.dt_s,
            });
        }
        Ok(Self {
            timeline: Timeline::new(
                trajectory,
                setting.duration_s,
                setting.dt_s,
                setting.vertical,
                temperature,
            ),
            setting,
            start_temperature_c: temperature(0.0),
            cache: std::sync::Mutex::new(HashMap::new()),
        })
    }

    /// Report times, s.
    pub fn time_s(&self) -> &[f64] {
        &self.timeline.times_s
    }

    /// What was asked for.
    pub fn setting(&self) -> &Setting {
        &self.setting
    }

    /// The unit response of a kind for a sensor without deterministic errors.
    pub fn unit(&self, kind: Kind) -> Arc<Response> {
        let sensor = SensorErrors::default();
        let sensitivity = sensor.sensitivity(Calibration::Perfect, self.start_temperature_c);
        let key = format!("{kind:?}");
        if let Ok(cache) = self.cache.lock()
            && let Some(found) = cache.get(&key)
        {
            return Arc::clone(found);
        }
        let propagator = Propagator::new(
            &self.timeline,
            &sensitivity,
            self.setting.alignment == Alignment::SelfAligned,
            self.start_temperature_c,
        );
        let response = Arc::new(propagator.respond(kind));
        if let Ok(mut cache) = self.cache.lock() {
            cache.insert(key, Arc::clone(&response));
        }
        response
    }

    /// The drift of a sensor by covariance.
    ///
    /// # Errors
    /// A self-alignment that cannot find a heading: σ(ε_D) above 10°, latitude beyond 85°, or an Earth that does not turn.
    pub fn covariance(&self, sensor: &SensorErrors) -> Result<CovarianceDrift, Error> {
        self.covariance_at(sensor, self.setting.dt_s)
    }

    /// The same for a sensor that samples at another interval, on this scene's report times.
    ///
    /// # Errors
    /// As [`Self::covariance`].
    pub fn covariance_at(
        &self,
        sensor: &SensorErrors,
        dt_s: f64,
    ) -> Result<CovarianceDrift, Error> {
        let sensitivity = sensor.sensitivity(self.setting.calibration, self.start_temperature_c);
        let self_aligned = self.setting.alignment == Alignment::SelfAligned;
        let propagator = Propagator::new(
            &self.timeline,
            &sensitivity,
            self_aligned,
            self.start_temperature_c,
        );
        let mut sources = sensor.sources(dt_s, self.setting.calibration);
        if let Alignment::Given {
            roll_rad,
            pitch_rad,
            heading_rad,
        } = self.setting.alignment
        {
            for (i, (axis, sigma)) in [
                ("roll", roll_rad),
                ("pitch", pitch_rad),
                ("heading", heading_rad),
            ]
            .into_iter()
            .enumerate()
            {
                if sigma != 0.0 {
                    sources.push(Source {
                        term: "alignment".to_owned(),
                        axis,
                        kind: Kind::Alignment(i as u8),
                        sigma: sigma.abs(),
                    });
                }
            }
        }
        let correlated: &[_] = if self.setting.calibration == Calibration::Perfect {
            &[]
        } else {
            &sensor.correlated
        };
        if self_aligned {
            let mut joint = 0.0;
            for block in correlated {
                let n = block.parameters.len();
                let e: Vec<f64> = block
                    .parameters
                    .iter()
                    .map(|(_, p)| propagator.heading_of(*p))
                    .collect();
                for i in 0..n {
                    for j in 0..n {
                        joint += e[i] * block.covariance[i * n + j] * e[j];
                    }
                }
            }
            let variance: f64 = joint
                + sources
                    .iter()
                    .map(|s| s.sigma * s.sigma * propagator.heading_variance(s.kind))
                    .sum::<f64>();
            self.check_self_alignment(variance.sqrt())?;
        }
        let plain = is_plain(&sensitivity);
        let responses: Vec<Arc<Response>> = sources
            .par_iter()
            .map(|s| {
                if plain && is_shareable(&s.kind) {
                    self.unit(s.kind)
                } else {
                    Arc::new(propagator.respond(s.kind))
                }
            })
            .collect();
        let mut budget: Vec<Entry> = Vec::new();
        for (source, response) in sources.iter().zip(&responses) {
            let power = source.sigma * source.sigma;
            add_entry(&mut budget, &source.term, source.axis, |i| {
                scaled(&response.spread[i], power)
            });
        }
        for block in correlated {
            let n = block.parameters.len();
            let vectors: Vec<Vec<[f64; 9]>> = block
                .parameters
                .iter()
                .filter_map(|(_, p)| propagator.respond(Kind::Constant(*p)).vector)
                .collect();
            for (p, (term, parameter)) in block.parameters.iter().enumerate() {
                // A parameter's part of the joint variance: its response times Σ_q Cov(p, q) of the others'.
                add_entry(&mut budget, term, parameter.axis().key(), |i| {
                    let x = vectors[p][i];
                    let mut y = [0.0; 9];
                    for q in 0..n {
                        for k in 0..9 {
                            y[k] += block.covariance[p * n + q] * vectors[q][i][k];
                        }
                    }
                    Spread {
                        horizontal: Horizontal {
                            north_north: x[0] * y[0],
                            north_east: 0.5 * (x[0] * y[1] + x[1] * y[0]),
                            east_east: x[1] * y[1],
                            mean: [0.0; 2],
                        },
                        variance: std::array::from_fn(|k| x[k] * y[k]),
                    }
                });
            }
        }
        let mean = if self.setting.calibration == Calibration::None {
            propagator
                .respond(Kind::Mean)
                .vector
                .unwrap_or_else(|| vec![[0.0; 9]; REPORTS])
        } else {
            vec![[0.0; 9]; REPORTS]
        };
        let mut total = vec![Spread::default(); REPORTS];
        for (i, sum) in total.iter_mut().enumerate() {
            for e in &budget {
                sum.horizontal = sum.horizontal.plus(&e.spread[i].horizontal, 1.0);
                for k in 0..9 {
                    sum.variance[k] += e.spread[i].variance[k];
                }
            }
            sum.horizontal.mean = [mean[i][0], mean[i][1]];
        }
        let power = |e: &Entry| {
            e.spread
                .last()
                .map_or(0.0, |s| s.horizontal.north_north + s.horizontal.east_east)
        };
        let all: f64 = budget.iter().map(power).sum();
        for e in &mut budget {
            e.share = if all > 0.0 { power(e) / all } else { 0.0 };
        }
        budget.sort_by(|a, b| b.share.total_cmp(&a.share));
        Ok(CovarianceDrift {
            time_s: self.timeline.times_s.clone(),
            total,
            mean,
            budget,
        })
    }

    /// Whether a start can be found with this σ(ε_D), rad.
    fn check_self_alignment(&self, heading_sigma_rad: f64) -> Result<(), Error> {
        let (latitude_rad, rate_rad_s) = self.timeline.place();
        check_heading(heading_sigma_rad, latitude_rad, rate_rad_s)
    }
}

/// The limits of navigation.md §3.4.
pub(crate) fn check_heading(
    sigma_rad: f64,
    latitude_rad: f64,
    rate_rad_s: f64,
) -> Result<(), Error> {
    let horizontal = rate_rad_s * latitude_rad.cos();
    let deg_h = |w: f64| w.to_degrees() * 3600.0;
    if rate_rad_s == 0.0 {
        return Err(Error::Alignment {
            what: "self-alignment needs an Earth that turns; this one (--earth sphere) does not"
                .to_owned(),
        });
    }
    if latitude_rad.abs() > 85f64.to_radians() {
        return Err(Error::Alignment {
            what: format!(
                "at latitude {:.1} deg the Earth's rate is level by only {:.1} deg/h: no heading by self-alignment beyond 85 deg",
                latitude_rad.to_degrees(),
                deg_h(horizontal)
            ),
        });
    }
    if sigma_rad.is_nan() || sigma_rad > 10f64.to_radians() {
        return Err(Error::Alignment {
            what: format!(
                "this sensor's {:.1} deg/h hides the {:.1} deg/h of earth rate: a self-aligned heading would be off by {:.0} deg",
                deg_h(sigma_rad * horizontal),
                deg_h(horizontal),
                sigma_rad.to_degrees()
            ),
        });
    }
    Ok(())
}

fn is_plain(s: &crate::covariance::Sensitivity) -> bool {
    s.gyro == crate::attitude::IDENTITY
        && s.accel == crate::attitude::IDENTITY
        && s.coupling == [[0.0; 3]; 3]
}

/// Responses that are the same for every sensor whose correction is the identity.
fn is_shareable(kind: &Kind) -> bool {
    use crate::covariance::Parameter as P;
    match kind {
        Kind::Constant(P::Bias { power, .. }) => *power == 0,
        Kind::Constant(P::GSensitivity { .. } | P::G2Sensitivity { .. }) => true,
        // The input of an accelerometer holds the sensor's own size effect.
        Kind::Constant(P::ScaleFactor { sensor, power, .. }) => {
            *power == 0 && *sensor == sagnac_core::Sensor::Gyro
        }
        Kind::Constant(P::OffDiagonal { sensor, .. }) => *sensor == sagnac_core::Sensor::Gyro,
        Kind::Constant(_) | Kind::Mean => false,
        _ => true,
    }
}

fn scaled(s: &Spread, power: f64) -> Spread {
    Spread {
        horizontal: Horizontal::default().plus(&s.horizontal, power),
        variance: s.variance.map(|v| v * power),
    }
}

fn add_entry(
    budget: &mut Vec<Entry>,
    term: &str,
    axis: &'static str,
    part: impl Fn(usize) -> Spread,
) {
    let at = budget
        .iter()
        .position(|e| e.term == term && e.axis == axis)
        .unwrap_or_else(|| {
            budget.push(Entry {
                term: term.to_owned(),
                axis,
                share: 0.0,
                spread: vec![Spread::default(); REPORTS],
            });
            budget.len() - 1
        });
    for (i, spread) in budget[at].spread.iter_mut().enumerate() {
        let p = part(i);
        spread.horizontal = spread.horizontal.plus(&p.horizontal, 1.0);
        for k in 0..9 {
            spread.variance[k] += p.variance[k];
        }
    }
}
