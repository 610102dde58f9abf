//! Which stations to add so that a term becomes determined: greedy, by the fall of the remaining variances.

use nalgebra::{DMatrix, DVector};
use sagnac_core::Sensor;

use super::determine::{Status, triangle};
use super::fit::dot;
use super::outcome::Decided;
use super::terms::{Inputs, omega_row};
use super::{Options, Station};

/// Stations that are added together, e.g. a spin in both senses.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// In words: `rest, +x+z up`.
    pub words: String,
    /// Their inputs.
    pub stations: Vec<Station>,
}

/// Stations which, added to the table, make terms determined.
#[derive(Clone, Debug, PartialEq)]
pub struct Addition {
    /// The terms.
    pub resolves: Vec<String>,
    /// What to add.
    pub bundles: Vec<Bundle>,
}

/// The 26 directions of faces, edges and corners.
pub(crate) fn directions() -> Vec<([f64; 3], String)> {
    let mut out = Vec::new();
    for wanted in 1..=3 {
        for code in 0..27 {
            let v = [code % 3, code / 3 % 3, code / 9].map(|d| f64::from(d - 1));
            let count = v.iter().filter(|x| **x != 0.0).count();
            if count == wanted {
                let name = ["x", "y", "z"]
                    .iter()
                    .zip(v)
                    .filter(|(_, x)| *x != 0.0)
                    .map(|(n, x)| format!("{}{n}", if x > 0.0 { '+' } else { '-' }))
                    .collect();
                out.push((v.map(|x| x / (count as f64).sqrt()), name));
            }
        }
    }
    out
}

/// Every station that may be proposed.
pub(crate) fn bundles(
    options: &Options,
    fastest_rad_s: f64,
    temperature_c: Option<f64>,
) -> Vec<Bundle> {
    let g = options.gravity_m_s2;
    let blank = || {
        let mut station = Station::new("");
        station.temperature_c = temperature_c;
        station
    };
    let mut out = Vec::new();
    let all = directions();
    for (d, name) in &all {
        out.push(Bundle {
            words: format!("rest, {name} up"),
            stations: vec![Station {
                f: d.map(|v| g * v),
                ..blank()
            }],
        });
    }
    let spin = fastest_rad_s.max(100f64.to_radians());
    let spins = |up: [f64; 3], temperature_c: Option<f64>| -> Vec<Station> {
        let both = [1.0, -1.0].map(|sense| Station {
            f: up.map(|v| g * v),
            w: up.map(|v| sense * spin * v),
            temperature_c,
            ..blank()
        });
        both.into()
    };
    for (d, name) in all.iter().take(18) {
        // Both senses of an axis are one bundle; its mirror adds no other rate.
        out.push(Bundle {
            words: format!(
                "spins of {:.0} deg/s both ways about {name}, that axis up",
                spin.to_degrees()
            ),
            stations: spins(*d, None),
        });
    }
    for (d, name) in all.iter().take(6).filter(|(_, n)| n.starts_with('+')) {
        let mut up = [0.0; 3];
        up.copy_from_slice(d);
        out.push(Bundle {
            words: format!("angular accelerations of 10 rad/s^2 both ways about {name}"),
            stations: [10.0, -10.0]
                .map(|a| Station {
                    f: up.map(|v| g * v),
                    wdot: d.map(|v| a * v),
                    ..blank()
                })
                .into(),
        });
    }
    for (d, name) in &all {
        out.push(Bundle {
            words: format!("5 g along {name} (centrifuge)"),
            stations: vec![Station {
                f: d.map(|v| 5.0 * 9.80665 * v),
                ..blank()
            }],
        });
    }
    for change in [20.0, -20.0] {
        let t = options.reference_temperature_c + change;
        // A scale factor changes with temperature where there is a rate and a temperature at once.
        for (d, name) in all.iter().take(6).filter(|(_, n)| n.starts_with('+')) {
            out.push(Bundle {
                words: format!(
                    "at {t:.0} degC spins of {:.0} deg/s both ways about {name}, that axis up",
                    spin.to_degrees()
                ),
                stations: spins(*d, Some(t)),
            });
        }
        out.push(Bundle {
            words: format!("the six faces at {t:.0} degC"),
            stations: all
                .iter()
                .take(6)
                .map(|(d, _)| Station {
                    f: d.map(|v| g * v),
                    temperature_c: Some(t),
                    ..blank()
                })
                .collect(),
        });
    }
    out
}

/// Prior information and rows of an axis, in columns scaled by plausible sizes.
pub(crate) struct Belief<'a> {
    axis: &'a Decided,
    scales: Vec<f64>,
    covariance: DMatrix<f64>,
    sigma: f64,
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The median standard error of an axis, or a usual one.
fn usual_error(stations: &[Station], axis: &Decided) -> f64 {
    let (sensor, k) = (axis.problem.sensor, axis.problem.k);
    let given = stations
        .iter()
        .filter_map(|s| s.output_se(sensor).map(|se| se[k]))
        .collect();
    median(given).unwrap_or(match sensor {
        Sensor::Accel => 1e-3,
        Sensor::Gyro => 1e-4,
    })
}

impl<'a> Belief<'a> {
    pub(crate) fn new(axis: &'a Decided, stations: &[Station]) -> Self {
        let sigma = usual_error(stations, axis);
        let p = axis.problem.terms.len();
        let reach = axis.reach.max(match axis.problem.sensor {
            Sensor::Accel => 9.80665,
            Sensor::Gyro => 100f64.to_radians(),
        });
        let scales: Vec<f64> = axis
            .problem
            .terms
            .iter()
            .map(|t| {
                let size = t.plausible(axis.problem.sensor, reach, axis.warmth_k.max(20.0));
                if size.is_finite() { size } else { 10.0 }
            })
            .collect();
        let weight = if axis.problem.has_errors {
            1.0
        } else {
            1.0 / sigma
        };
        let x = DMatrix::from_fn(axis.factor.nrows(), p, |i, j| {
            axis.factor[(i, j)] * scales[j] * weight
        });
        let information = x.transpose() * &x + DMatrix::identity(p, p);
        Self {
            covariance: information
                .try_inverse()
                .unwrap_or_else(|| DMatrix::identity(p, p)),
            axis,
            scales,
            sigma,
        }
    }

    fn row(&self, station: &Station, reference_c: f64) -> DVector<f64> {
        let problem = &self.axis.problem;
        let at = inputs(station, problem.sensor, problem.k, reference_c);
        DVector::from_iterator(
            self.scales.len(),
            problem
                .terms
                .iter()
                .zip(&self.scales)
                .map(|(t, s)| t.column(problem.k, &at) * s / self.sigma),
        )
    }

    /// Standard deviation of a term, with what was plausible before.
    pub(crate) fn sigma(&self, term: usize) -> f64 {
        self.covariance[(term, term)].max(0.0).sqrt() * self.scales[term]
    }

    /// By how much stations lower Σ (σ/wanted)² over terms.
    pub(crate) fn fall(&self, bundle: &Bundle, wanted: &[(usize, f64)], options: &Options) -> f64 {
        self.lowered(bundle, options).map_or(0.0, |lowered| {
            wanted
                .iter()
                .map(|(t, sigma)| lowered[*t] * (self.scales[*t] / sigma).powi(2))
                .sum()
        })
    }

    /// By how much stations lower the variance of each term, in columns scaled by plausible sizes.
    fn lowered(&self, bundle: &Bundle, options: &Options) -> Option<Vec<f64>> {
        let rows: Vec<DVector<f64>> = bundle
            .stations
            .iter()
            .map(|s| self.row(s, options.reference_temperature_c))
            .collect();
        let x = DMatrix::from_columns(&rows);
        let gain = &self.covariance * &x;
        let inverse =
            (x.transpose() * &gain + DMatrix::identity(rows.len(), rows.len())).try_inverse()?;
        let lowered = &gain * inverse;
        Some(
            (0..self.scales.len())
                .map(|t| {
                    (0..rows.len())
                        .map(|j| lowered[(t, j)] * gain[(t, j)])
                        .sum()
                })
                .collect(),
        )
    }

    /// Takes stations as measured.
    pub(crate) fn take(&mut self, bundle: &Bundle, options: &Options) {
        for station in &bundle.stations {
            let row = self.row(station, options.reference_temperature_c);
            self.update(&row);
        }
    }

    fn update(&mut self, row: &DVector<f64>) {
        let gain = &self.covariance * row;
        let whole = 1.0 + row.dot(&gain);
        self.covariance -= &gain * gain.transpose() / whole;
    }
}

fn inputs(station: &Station, sensor: Sensor, k: usize, reference_c: f64) -> Inputs {
    Inputs {
        u: station.input(sensor),
        f: station.f,
        omega_row: omega_row(k, station.w, station.wdot),
        slope: 1.0,
        warmth_k: station.temperature_c.map_or(0.0, |t| t - reference_c),
        run: 0,
    }
}

/// Entries that resolve what was asked for and is not determined, and the names that nothing resolves.
pub(super) fn additions(
    stations: &[Station],
    options: &Options,
    decided: &[Decided],
) -> (Vec<Addition>, Vec<String>) {
    let mut open: Vec<(usize, usize)> = Vec::new();
    for (d, axis) in decided.iter().enumerate() {
        for (t, status) in axis.status.iter().enumerate() {
            if axis.asked[t] && *status != Status::Admitted {
                open.push((d, t));
            }
        }
    }
    let fastest = stations
        .iter()
        .map(|s| dot(s.w, s.w).sqrt())
        .fold(0.0, f64::max);
    let temperature = median(stations.iter().filter_map(|s| s.temperature_c).collect());
    let candidates = bundles(options, fastest, temperature);
    let mut out: Vec<Addition> = Vec::new();
    while !open.is_empty() && out.len() < 24 {
        let Some(entry) = one(stations, options, decided, &candidates, &open) else {
            break;
        };
        open.retain(|(d, t)| !entry.resolves.contains(&decided[*d].name(*t)));
        out.push(entry);
    }
    let mut hopeless: Vec<String> = open.iter().map(|(d, t)| decided[*d].name(*t)).collect();
    hopeless.dedup();
    (out, hopeless)
}

/// The first set of bundles that resolves something.
fn one(
    stations: &[Station],
    options: &Options,
    decided: &[Decided],
    candidates: &[Bundle],
    open: &[(usize, usize)],
) -> Option<Addition> {
    let mut beliefs: Vec<Option<Belief>> = decided
        .iter()
        .enumerate()
        .map(|(d, axis)| {
            open.iter()
                .any(|(o, _)| *o == d)
                .then(|| Belief::new(axis, stations))
        })
        .collect();
    let mut chosen: Vec<Bundle> = Vec::new();
    for _ in 0..16 {
        let best = candidates
            .iter()
            .map(|bundle| (score(bundle, &beliefs, open, options), bundle))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, bundle)| bundle)?;
        for belief in beliefs.iter_mut().flatten() {
            belief.take(best, options);
        }
        chosen.push(best.clone());
        let resolved = resolved(stations, options, decided, &chosen, open);
        if !resolved.is_empty() {
            return Some(Addition {
                resolves: resolved,
                bundles: chosen,
            });
        }
    }
    None
}

/// How much a bundle lowers the logarithms of the open terms' variances, per station.
fn score(
    bundle: &Bundle,
    beliefs: &[Option<Belief>],
    open: &[(usize, usize)],
    options: &Options,
) -> f64 {
    let mut sum = 0.0;
    for (d, belief) in beliefs.iter().enumerate() {
        let Some(belief) = belief else { continue };
        let Some(lowered) = belief.lowered(bundle, options) else {
            continue;
        };
        for (_, t) in open.iter().filter(|(o, _)| *o == d) {
            let before = belief.covariance[(*t, *t)];
            sum += (before / (before - lowered[*t]).max(1e-300)).ln();
        }
    }
    sum / bundle.stations.len().max(1) as f64
}

/// The open terms that the table with these bundles determines.
fn resolved(
    stations: &[Station],
    options: &Options,
    decided: &[Decided],
    chosen: &[Bundle],
    open: &[(usize, usize)],
) -> Vec<String> {
    let mut out = Vec::new();
    for (d, axis) in decided.iter().enumerate() {
        if !open.iter().any(|(o, _)| *o == d) {
            continue;
        }
        let (sensor, k) = (axis.problem.sensor, axis.problem.k);
        let p = axis.problem.terms.len();
        let weight = if axis.problem.has_errors {
            1.0 / usual_error(stations, axis)
        } else {
            1.0
        };
        let rows: Vec<&Station> = chosen.iter().flat_map(|b| &b.stations).collect();
        let mut all = axis.factor.columns(0, p).into_owned();
        let first = all.nrows();
        all = all.resize_vertically(first + rows.len(), 0.0);
        let (mut reach, mut warmth, mut slow) = (axis.reach, axis.warmth_k, axis.slow);
        for (i, station) in rows.iter().enumerate() {
            let at = inputs(station, sensor, k, options.reference_temperature_c);
            for (j, term) in axis.problem.terms.iter().enumerate() {
                all[(first + i, j)] = term.column(k, &at) * weight;
            }
            reach = reach.max(at.u[k].abs());
            warmth = warmth.max(at.warmth_k.abs());
            slow &= dot(station.w, station.w).sqrt() < 1e-3;
        }
        let status = axis.decide(&triangle(all), reach, warmth, slow);
        for (_, t) in open.iter().filter(|(o, _)| *o == d) {
            let name = axis.name(*t);
            if status[*t] == Status::Admitted && !out.contains(&name) {
                out.push(name);
            }
        }
    }
    out
}
