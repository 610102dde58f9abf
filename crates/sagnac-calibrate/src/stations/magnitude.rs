//! |f| before and after a calibration, and the specific force that a mean output stands for.

use sagnac_core::Sensor;

use super::fit::{State, dot};
use super::outcome::{Decided, Outcome};
use super::terms::{Group, Inputs, omega_row};
use super::{Options, Station};

impl Outcome {
    /// The specific force behind a mean accelerometer output at the rate and temperature of `at`; a fixed point of
    /// the forward model, whose errors are small beside the input.
    pub fn specific_force(&self, output: [f64; 3], at: &Station, options: &Options) -> [f64; 3] {
        let of = || {
            self.parameters
                .iter()
                .filter(|p| p.sensor == Sensor::Accel)
                .filter_map(|p| Some((p.axis, p.term?, p.value)))
        };
        let mut offsets = [[0.0; 3]; 3];
        for (k, term, value) in of().filter(|(_, term, _)| term.group == Group::AxisOffset) {
            offsets[k][term.component] = value;
        }
        let warmth_k = at
            .temperature_c
            .map_or(0.0, |t| t - options.reference_temperature_c);
        let mut f = output;
        for _ in 0..60 {
            let u = std::array::from_fn(|k| f[k] + dot(omega_row(k, at.w, at.wdot), offsets[k]));
            let inputs = Inputs {
                u,
                f,
                omega_row: [0.0; 3],
                slope: 1.0,
                warmth_k,
                run: 0,
            };
            let mut miss: [f64; 3] = std::array::from_fn(|k| output[k] - u[k]);
            for (k, term, value) in of() {
                miss[k] -= term.column(k, &inputs) * value;
            }
            for (f, miss) in f.iter_mut().zip(miss) {
                *f += miss;
            }
            let step = miss.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            if step < 1e-13 || !step.is_finite() {
                break;
            }
        }
        f
    }
}

/// |f̂| − |f| before and after the correction; rows where the IMU spins are left out before.
pub(super) fn magnitudes(
    stations: &[Station],
    axes: &[Decided],
    state: &State,
    offsets: &[[f64; 3]; 3],
    outcome: &mut Outcome,
) {
    for (place, row) in axes[0].problem.rows.iter().enumerate() {
        let station = &stations[*row];
        let Some(output) = station.accel else {
            continue;
        };
        let size = |v: [f64; 3]| dot(v, v).sqrt();
        let run = axes[0].problem.runs[place];
        // Newton's fixed point on the forward model: the errors are small beside the input.
        let mut guess = Station {
            f: output,
            ..station.clone()
        };
        for _ in 0..60 {
            let mut step = 0.0_f64;
            let mut next = guess.f;
            for (k, axis) in axes.iter().enumerate() {
                let at = axis.problem.inputs(&guess, run, state, offsets);
                let fit: f64 = axis
                    .problem
                    .terms
                    .iter()
                    .zip(&state[k])
                    .filter(|(t, _)| t.group != Group::AxisOffset)
                    .map(|(t, v)| t.column(k, &at) * v)
                    .sum();
                let miss = output[k] - at.u[k] - fit;
                next[k] += miss;
                step = step.max(miss.abs());
            }
            guess.f = next;
            if step < 1e-13 || !step.is_finite() {
                break;
            }
        }
        let truth = size(station.f);
        if size(guess.f).is_finite() {
            outcome.before_m_s2.push(size(output) - truth);
            outcome.after_m_s2.push(size(guess.f) - truth);
        }
    }
}
