//! The numbers that formats ask for, by rules that are the same for all.
//!
//! K in quadrature with the walk of the instability; else K = σ√(2/T_c) of a Gauss–Markov term; else the walk that meets
//! the flicker floor where white noise does, K = √3·(0.6643 B)²/N. σ_b = 0.6643 B/0.6174: the highest Allan deviation of
//! a Gauss–Markov process is 0.6174 σ. [IEEE952]

use super::Format;
use super::matrix::{IDENTITY, Matrix};
use crate::entry::Entry;
use crate::error::Error;
use crate::model::{Model, Process};
use crate::random::FLICKER_FLOOR;
use crate::units::{Dimension, Unit};
use sagnac_core::{Sensor, SensorModel};

/// Correlation time where a model has none [s]: a convention.
pub(crate) const CONVENTION_S: f64 = 3600.0;
/// Highest Allan deviation of a Gauss–Markov process over its σ.
const GAUSS_MARKOV_PEAK: f64 = 0.6174;

/// A number for the three axes, and what to say about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// x, y, z in SI, inflated where that was asked for.
    pub axes: [f64; 3],
    /// What it is, in the units people use, its interval or source.
    pub comment: String,
}

impl Number {
    /// The largest of the axes.
    pub fn largest(&self) -> f64 {
        self.axes.iter().fold(0.0, |most: f64, value| {
            if value.abs() > most.abs() {
                *value
            } else {
                most
            }
        })
    }
}

/// A model, the format it is written for, and by how much its noise is inflated.
pub struct Source<'a> {
    /// The model.
    pub model: &'a Model,
    /// The deterministic terms.
    pub core: SensorModel<f64>,
    format: Format,
    inflate: f64,
}

/// Where a K comes from.
enum Walk {
    Stated(f64),
    GaussMarkov(f64),
    Flicker(f64),
}

impl<'a> Source<'a> {
    pub(crate) fn new(model: &'a Model, format: Format, inflate: f64) -> Result<Self, Error> {
        Ok(Self {
            model,
            core: model.to_core()?,
            format,
            inflate,
        })
    }

    /// The first lines of a file.
    pub(crate) fn head(&self) -> String {
        let mut text = format!(
            "{}, for {}",
            self.model.name().replace(['\n', '\r'], " "),
            self.format.name()
        );
        if self.inflate != 1.0 {
            text.push_str(&format!(
                "; N, K and bias sigmas inflated by {}",
                self.inflate
            ));
        }
        text
    }

    /// The sampling rate [Hz].
    pub(crate) fn rate_hz(&self) -> Result<f64, Error> {
        let advice = Some(
            "add --rate, for instance --rate 200Hz, or to the model sample_rate = \"200 Hz\""
                .to_string(),
        );
        self.model.sample_rate_hz().ok_or_else(|| {
            self.model.missing(
                &format!("sample rate, which {} needs", self.format.name()),
                advice,
            )
        })
    }

    /// N, two-sided.
    pub fn white(&self, sensor: Sensor) -> Result<Number, Error> {
        let key = Model::white_key(sensor);
        let entries = [0, 1, 2].map(|axis| {
            self.model
                .white_noise(sensor, axis)
                .filter(|entry| entry.value.is_some())
        });
        if entries.iter().all(Option::is_none) {
            let advice = format!(
                "add to [{}.noise] for instance {key} = \"{}\"",
                sensor.key(),
                white_dimension(sensor).example()
            );
            return Err(self.model.missing(
                &format!(
                    "{}.noise.{key}, which {} needs",
                    sensor.key(),
                    self.format.name()
                ),
                Some(advice),
            ));
        }
        let axes = entries
            .each_ref()
            .map(|entry| entry.as_ref().map_or(0.0, Entry::simulated));
        let name = format!("{} N, two-sided", key.replace('_', " "));
        Ok(self.number(&name, axes, &entries, white_dimension(sensor), ""))
    }

    /// K; zero axes where nothing of the model gives one.
    pub fn walk(&self, sensor: Sensor) -> Number {
        let key = Model::walk_key(sensor);
        let found = [0, 1, 2].map(|axis| self.axis_walk(sensor, axis));
        let axes = found.each_ref().map(|walk| match walk {
            Some(Walk::Stated(value) | Walk::GaussMarkov(value) | Walk::Flicker(value)) => *value,
            None => 0.0,
        });
        let from = by_axis(found.each_ref().map(|walk| match walk {
            None => "not in the model",
            Some(Walk::Stated(_)) => "",
            Some(Walk::GaussMarkov(_)) => "from the Gauss-Markov term, sigma sqrt(2/T_c)",
            Some(Walk::Flicker(_)) => "from flicker: sqrt(3) (0.664 B)^2 / N",
        }));
        let entries = [0, 1, 2].map(|axis| {
            self.model
                .under(sensor, &format!("noise.{key}"), axis)
                .filter(|entry| entry.value.is_some())
                .cloned()
        });
        self.number(
            &format!("{} K", key.replace('_', " ")),
            axes,
            &entries,
            walk_dimension(sensor),
            &from,
        )
    }

    /// K where the format needs one above zero.
    pub fn needed_walk(&self, sensor: Sensor) -> Result<Number, Error> {
        let walk = self.walk(sensor);
        if walk.largest() > 0.0 {
            return Ok(walk);
        }
        let key = Model::walk_key(sensor);
        let advice = format!(
            "add to [{}.noise] for instance {key} = \"{}\"",
            sensor.key(),
            walk_dimension(sensor).example()
        );
        let what = format!(
            "{}.noise.{key} and nothing to take it from, which {} needs",
            sensor.key(),
            self.format.name()
        );
        Err(self.model.missing(&what, Some(advice)))
    }

    fn axis_walk(&self, sensor: Sensor, axis: usize) -> Option<Walk> {
        let noise = self.model.axis_noise(sensor, axis);
        let stated = noise
            .random_walk
            .coefficient
            .hypot(noise.instability_random_walk.coefficient);
        if stated > 0.0 {
            return Some(Walk::Stated(stated));
        }
        let first = noise
            .gauss_markov
            .iter()
            .chain([&noise.instability_gauss_markov])
            .find(|term| term.sigma > 0.0);
        if let Some(term) = first.filter(|term| term.correlation_time_s > 0.0) {
            return Some(Walk::GaussMarkov(
                term.sigma * (2.0 / term.correlation_time_s).sqrt(),
            ));
        }
        let floor = FLICKER_FLOOR * noise.flicker.coefficient;
        (floor > 0.0 && noise.white.density > 0.0)
            .then(|| Walk::Flicker(3.0_f64.sqrt() * floor * floor / noise.white.density))
    }

    /// σ_b and T_c of a Gauss–Markov bias, an axis each.
    pub fn correlated_bias(&self, sensor: Sensor) -> (Number, [f64; 3]) {
        let mut sigmas = [0.0; 3];
        let mut times = [CONVENTION_S; 3];
        let mut from = ["not in the model; T_c 3600 s is a convention"; 3];
        for axis in 0..3 {
            let noise = self.model.axis_noise(sensor, axis);
            let largest = noise
                .gauss_markov
                .iter()
                .chain([&noise.instability_gauss_markov])
                .filter(|term| term.sigma > 0.0 && term.correlation_time_s > 0.0)
                .max_by(|a, b| a.sigma.total_cmp(&b.sigma));
            let walk = noise
                .random_walk
                .coefficient
                .hypot(noise.instability_random_walk.coefficient);
            if let Some(term) = largest {
                sigmas[axis] = term.sigma;
                times[axis] = term.correlation_time_s;
                from[axis] = "the Gauss-Markov term";
            } else if noise.flicker.coefficient > 0.0 {
                sigmas[axis] = FLICKER_FLOOR * noise.flicker.coefficient / GAUSS_MARKOV_PEAK;
                from[axis] = "from flicker, 1.076 B; T_c 3600 s is a convention";
            } else if walk > 0.0 {
                sigmas[axis] = walk * (CONVENTION_S / 2.0).sqrt();
                from[axis] = "from K, K sqrt(T_c/2); T_c 3600 s is a convention";
            }
        }
        (
            self.number(
                "in-run bias sigma",
                sigmas,
                &[None, None, None],
                output_dimension(sensor),
                &by_axis(from),
            ),
            times,
        )
    }

    /// 1σ of the run-to-run bias; zero axes and false where the model has none.
    pub fn run_to_run(&self, sensor: Sensor) -> (Number, bool) {
        let entries = [0, 1, 2].map(|axis| {
            self.model
                .under(sensor, "bias.stability", axis)
                .filter(|entry| entry.value.is_some())
                .cloned()
        });
        let known = entries.iter().any(Option::is_some);
        let axes = self.model.stability(sensor).bias;
        let from = if known { "" } else { "not in the model" };
        (
            self.plain(
                "run-to-run bias, 1 sigma",
                axes,
                &entries,
                output_dimension(sensor),
                from,
            ),
            known,
        )
    }

    /// The fixed bias at T0.
    pub fn fixed_bias(&self, sensor: Sensor) -> Number {
        let entries = [0, 1, 2].map(|axis| {
            self.model
                .under(sensor, "bias", axis)
                .filter(|entry| entry.value.is_some())
                .cloned()
        });
        let from = if entries.iter().any(Option::is_some) {
            "at the reference temperature"
        } else {
            "not in the model"
        };
        self.plain(
            "fixed bias",
            self.core.triad(sensor).bias.fixed,
            &entries,
            output_dimension(sensor),
            from,
        )
    }

    /// I + M: scale factor, misalignment and cross-axis.
    pub fn matrix(&self, sensor: Sensor) -> Matrix {
        let triad = self.core.triad(sensor);
        let misalignment = triad.misalignment.elements.to_array();
        let cross_axis = triad.cross_axis.elements.to_array();
        let mut matrix = IDENTITY;
        let places = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)];
        for (element, (row, column)) in places.into_iter().enumerate() {
            matrix[row][column] = misalignment[element] + cross_axis[element];
        }
        for (axis, row) in matrix.iter_mut().enumerate() {
            row[axis] += triad.scale_factor.fixed[axis];
        }
        matrix
    }

    /// L and Q of A = L·Q, or why not.
    #[allow(clippy::unused_self, reason = "reads as one of the source's questions")]
    pub(crate) fn lower(&self, matrix: &Matrix, sensor: Sensor) -> Result<(Matrix, Matrix), Error> {
        super::matrix::lower_and_rotation(matrix).ok_or_else(|| Error::BadValue {
            path: sensor.key().to_string(),
            problem: "has a matrix of scale factor and misalignment that is no sensor's: it is singular or mirrors".into(),
        })
    }

    /// B, zero where absent.
    pub fn flicker(&self, sensor: Sensor) -> Number {
        let entries = [0, 1, 2].map(|axis| {
            self.model
                .flicker(sensor, axis)
                .filter(|entry| entry.value.is_some())
        });
        let axes = entries
            .each_ref()
            .map(|entry| entry.as_ref().map_or(0.0, Entry::simulated));
        let from =
            if self.model.process(sensor) == Process::Flicker && axes.iter().any(|b| *b > 0.0) {
                ""
            } else {
                "not in the model"
            };
        self.plain(
            "bias instability, coefficient B",
            axes,
            &entries,
            output_dimension(sensor),
            from,
        )
    }

    /// 1σ of the run-to-run scale factor.
    pub fn scale_stability(&self, sensor: Sensor) -> Number {
        let axes = self.model.stability(sensor).scale_factor;
        self.plain(
            "run-to-run scale factor, 1 sigma",
            axes,
            &[None, None, None],
            Dimension::RATIO,
            "",
        )
    }

    /// The fixed scale factor error.
    pub fn fixed_scale(&self, sensor: Sensor) -> Number {
        self.plain(
            "fixed scale factor error",
            self.core.triad(sensor).scale_factor.fixed,
            &[None, None, None],
            Dimension::RATIO,
            "",
        )
    }

    fn number(
        &self,
        name: &str,
        axes: [f64; 3],
        entries: &[Option<Entry>; 3],
        dimension: Dimension,
        from: &str,
    ) -> Number {
        let mut number = self.plain(name, axes, entries, dimension, from);
        if self.inflate != 1.0 {
            let before = number.largest();
            number.axes = axes.map(|value| value * self.inflate);
            let after = number.largest();
            number.comment.push_str(&format!(
                "; inflated by {} from {} to {}",
                self.inflate,
                short(before, dimension),
                short(after, dimension)
            ));
        }
        number
    }

    #[allow(clippy::unused_self, reason = "reads as one of the source's questions")]
    fn plain(
        &self,
        name: &str,
        axes: [f64; 3],
        entries: &[Option<Entry>; 3],
        dimension: Dimension,
        from: &str,
    ) -> Number {
        let mut comment = name.to_string();
        let largest = (0..3)
            .max_by(|a, b| axes[*a].abs().total_cmp(&axes[*b].abs()))
            .unwrap_or(0);
        comment.push_str(&format!(", {}", short(axes[largest], dimension)));
        if axes.iter().any(|value| *value != axes[0]) {
            let [x, y, z] = axes.map(|value| short_number(value, dimension));
            comment.push_str(&format!(" (x {x}, y {y}, z {z})"));
        }
        if !from.is_empty() {
            comment.push_str(&format!("; {from}"));
        }
        if let Some(entry) = &entries[largest] {
            if let (Some(lower), Some(upper)) = (entry.lower, entry.upper) {
                comment.push_str(&format!(
                    "; 95 % {} to {}",
                    short(lower, dimension),
                    short(upper, dimension)
                ));
            } else if let Some(sigma) = entry.sigma {
                comment.push_str(&format!("; 95 % +/- {}", short(1.96 * sigma, dimension)));
            }
            if let Some(source) = &entry.source {
                comment.push_str(&format!("; {}", source.replace(['\n', '\r'], " ")));
            }
        }
        Number { axes, comment }
    }
}

/// One reason where it is that of all axes, else each with the axes it is of.
fn by_axis(reasons: [&str; 3]) -> String {
    if reasons.iter().all(|reason| *reason == reasons[0]) {
        return reasons[0].to_string();
    }
    let mut parts: Vec<String> = Vec::new();
    for (axis, reason) in reasons.iter().enumerate() {
        if reasons[..axis].contains(reason) {
            continue;
        }
        let axes: Vec<&str> = (axis..3)
            .filter(|other| reasons[*other] == *reason)
            .map(|other| ["x", "y", "z"][other])
            .collect();
        let reason = if reason.is_empty() {
            "as stated"
        } else {
            *reason
        };
        parts.push(format!("{}: {reason}", axes.join(", ")));
    }
    parts.join("; ")
}

pub(crate) fn white_dimension(sensor: Sensor) -> Dimension {
    match sensor {
        Sensor::Gyro => Dimension::ANGLE_RANDOM_WALK,
        Sensor::Accel => Dimension::VELOCITY_RANDOM_WALK,
    }
}

pub(crate) fn walk_dimension(sensor: Sensor) -> Dimension {
    match sensor {
        Sensor::Gyro => Dimension::RATE_RANDOM_WALK,
        Sensor::Accel => Dimension::ACCELERATION_RANDOM_WALK,
    }
}

pub(crate) fn output_dimension(sensor: Sensor) -> Dimension {
    match sensor {
        Sensor::Gyro => Dimension::ANGULAR_RATE,
        Sensor::Accel => Dimension::ACCELERATION,
    }
}

/// Four digits in the field's unit.
fn short_number(value: f64, dimension: Dimension) -> String {
    let scaled = value / Unit::field(dimension).factor();
    let rounded: f64 = format!("{scaled:.3e}").parse().unwrap_or(scaled);
    crate::units::format_number(rounded)
}

/// The same with its unit.
pub(crate) fn short(value: f64, dimension: Dimension) -> String {
    format!(
        "{} {}",
        short_number(value, dimension),
        dimension.field_unit()
    )
}
