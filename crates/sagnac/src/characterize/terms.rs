//! Names and dimensions of the terms in JSON, model files and options.

use crate::Error;
use sagnac_analysis::fit::{Candidates, Term};
use sagnac_core::Sensor;
use sagnac_model::Model;
use sagnac_model::units::Dimension;

/// A term by its place in results.
pub type TermKey = Term;

/// The JSON name of a term, e.g. `angle_random_walk`.
pub fn key_of(sensor: Sensor, term: TermKey) -> &'static str {
    match term {
        Term::Quantization => "quantization",
        Term::White => Model::white_key(sensor),
        Term::Flicker => "bias_instability",
        Term::RandomWalk => Model::walk_key(sensor),
        Term::Ramp => Model::ramp_key(sensor),
        Term::GaussMarkov => "gauss_markov",
        Term::Sinusoid => "sinusoids",
    }
}

/// What a term measures (σ of Gauss–Markov terms and amplitudes: the sensor's output).
pub fn dimension_of(sensor: Sensor, term: TermKey) -> Dimension {
    match (sensor, term) {
        (Sensor::Gyro, Term::Quantization) => Dimension::ANGLE,
        (Sensor::Gyro, Term::White) => Dimension::ANGLE_RANDOM_WALK,
        (Sensor::Gyro, Term::RandomWalk) => Dimension::RATE_RANDOM_WALK,
        (Sensor::Gyro, Term::Ramp) => Dimension::RATE_RAMP,
        (Sensor::Gyro, _) => Dimension::ANGULAR_RATE,
        (Sensor::Accel, Term::Quantization) => Dimension::SPEED,
        (Sensor::Accel, Term::White) => Dimension::VELOCITY_RANDOM_WALK,
        (Sensor::Accel, Term::RandomWalk) => Dimension::ACCELERATION_RANDOM_WALK,
        (Sensor::Accel, Term::Ramp) => Dimension::ACCELERATION_RAMP,
        (Sensor::Accel, _) => Dimension::ACCELERATION,
    }
}

/// The terms of a list like `angle_random_walk, bias_instability`.
///
/// # Errors
/// A name that is no term, with the nearest one.
pub fn candidates(list: &str) -> Result<Candidates, Error> {
    const ALL: [Term; 7] = [
        Term::Quantization,
        Term::White,
        Term::Flicker,
        Term::RandomWalk,
        Term::Ramp,
        Term::GaussMarkov,
        Term::Sinusoid,
    ];
    let mut out = Candidates::none();
    let mut names: Vec<&'static str> = Vec::new();
    for sensor in Sensor::ALL {
        for term in ALL {
            let name = key_of(sensor, term);
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    for name in list.split(',').map(str::trim).filter(|n| !n.is_empty()) {
        if name == "all" {
            return Ok(Candidates::default());
        }
        let found = Sensor::ALL
            .iter()
            .flat_map(|&s| ALL.iter().map(move |&t| (s, t)))
            .find(|&(s, t)| key_of(s, t) == name);
        let Some((_, term)) = found else {
            let error =
                Error::usage(format!("unknown term `{name}`")).at(format!("--terms {list}"));
            return Err(
                error.advise(match sagnac_model::suggest(name, names.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("terms are {}", names.join(", ")),
                }),
            );
        };
        out.allow(term);
    }
    if out == Candidates::none() {
        return Err(Error::usage("the list of terms is empty")
            .at("--terms")
            .advise("for instance --terms angle_random_walk,bias_instability"));
    }
    Ok(out)
}
