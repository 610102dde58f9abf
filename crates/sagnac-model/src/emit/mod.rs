//! C and Rust source of a model's inverse, complete in itself, for a microcontroller.
//!
//! The operations are those of `sagnac_core::Compensation`, in its order, with the model's
//! numbers in them; every file carries stored cases that it is tested with.

mod c;
mod cases;
mod rust;

use core::fmt::Write as _;

use sagnac_core::{
    Compensation, CompensationError, Real, Sensor, SensorModel, TemperatureDependence, vector,
};

/// The number type of the emitted source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// `double`, `f64`.
    #[default]
    F64,
    /// `float`, `f32`.
    F32,
}

/// One emitted file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmittedFile {
    /// Its name, as `sagnac_correct_f64.c`.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// What is emitted.
#[derive(Debug, Clone, Copy)]
pub struct EmitRequest<'a> {
    /// The model's name, for comments.
    pub name: &'a str,
    /// The model.
    pub model: &'a SensorModel<f64>,
    /// The sampling interval, which says where an increment output saturates.
    pub dt_s: f64,
    /// The number type.
    pub precision: Precision,
    /// Terms that the calibration held at zero: named in the comments, for they are not corrected.
    pub held: &'a [String],
}

/// Why no source is emitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EmitError {
    /// The model has no inverse.
    #[error("{0}")]
    NoInverse(CompensationError),
    /// Outside the convergence bound.
    #[error(
        "the model is outside the convergence bound: mu + nu is {gyro:.3} (gyro, with g) and {accel:.3} (accelerometer), q = {q:.3}"
    )]
    OutsideBound {
        /// μ + ν + δ of the gyro.
        gyro: f64,
        /// μ + ν of the accelerometer.
        accel: f64,
        /// The contraction a round.
        q: f64,
    },
}

impl EmitError {
    /// Where it is wrong.
    pub fn place(&self) -> Option<String> {
        None
    }

    /// What to do.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::NoInverse(_) => Some(
                "look for a wrong unit: scale_factor, asymmetry, misalignment and cross_axis are fractions, quadratic and cubic count at the end of the range".to_owned(),
            ),
            Self::OutsideBound { .. } => Some(
                "the bound is mu + nu at most 1/3 and q at most 1/2; `sagnac correct MODEL LOG` works and flags every sample".to_owned(),
            ),
        }
    }
}

/// `sagnac_correct_P.h`, `.c`, `_test.c` and `_example.c`.
///
/// # Errors
/// A model that has no inverse, or is outside the convergence bound.
pub fn c(request: &EmitRequest<'_>) -> Result<Vec<EmittedFile>, EmitError> {
    match request.precision {
        Precision::F64 => Plan::<f64>::new(request).map(|plan| c::files(&plan)),
        Precision::F32 => Plan::<f32>::new(request).map(|plan| c::files(&plan)),
    }
}

/// `sagnac_correct.rs` and `sagnac_correct_example.rs`.
///
/// # Errors
/// A model that has no inverse, or is outside the convergence bound.
pub fn rust(request: &EmitRequest<'_>) -> Result<Vec<EmittedFile>, EmitError> {
    match request.precision {
        Precision::F64 => Plan::<f64>::new(request).map(|plan| rust::files(&plan)),
        Precision::F32 => Plan::<f32>::new(request).map(|plan| rust::files(&plan)),
    }
}

/// A table that depends on temperature, as it is written out.
struct Table<T> {
    /// `gyro_bias`, `accel_scale` …
    name: String,
    unit: &'static str,
    polynomial: Vec<[T; 3]>,
    /// start, c0[3], c1[3], c2[3], c3[3] a piece; and the last knot.
    spline: Option<(Vec<Vec<T>>, T)>,
    range: Option<[T; 2]>,
}

/// What both languages write.
struct Plan<T: Real> {
    name: String,
    held: Vec<String>,
    /// `f64` or `f32`.
    precision: &'static str,
    inverse: Compensation<T>,
    model: SensorModel<T>,
    /// Bias and scale factor tables of gyro and accelerometer.
    tables: [[Option<Table<T>>; 2]; 2],
    cases: Vec<cases::Case<T>>,
    /// Relative to the scale of a triad.
    allowed: f64,
}

impl<T: Real> Plan<T> {
    fn new(request: &EmitRequest<'_>) -> Result<Self, EmitError> {
        let model = request.model.convert::<T>();
        let inverse =
            Compensation::new(&model, T::from_f64(request.dt_s)).map_err(EmitError::NoInverse)?;
        let range = |sensor| inverse.range(sensor);
        let is_ranged = range(Sensor::Gyro).is_some() && range(Sensor::Accel).is_some();
        let bound = inverse.bound_at(
            range(Sensor::Gyro).unwrap_or(T::ZERO),
            range(Sensor::Accel).unwrap_or(T::ZERO),
        );
        let third = T::ONE / T::from_f64(3.0);
        let is_inside = if is_ranged {
            bound.is_inside()
        } else {
            bound.mu[0] + bound.nu[0] <= third && bound.mu[1] + bound.nu[1] <= third
        };
        if !is_inside {
            return Err(EmitError::OutsideBound {
                gyro: (bound.mu[0] + bound.nu[0] + bound.delta).to_f64(),
                accel: (bound.mu[1] + bound.nu[1]).to_f64(),
                q: bound.q.to_f64(),
            });
        }
        let table = |sensor: Sensor, of: &TemperatureDependence<T>, kind: &str, unit| {
            of.is_present().then(|| Table {
                name: format!("{}_{kind}", sensor.key()),
                unit,
                polynomial: of.polynomial[..of.order()].to_vec(),
                spline: of.spline.map(|spline| {
                    let rows = spline.segments().iter().map(|piece| {
                        let mut row = vec![piece.start_c];
                        row.extend(piece.coefficients.iter().flatten());
                        row
                    });
                    (rows.collect(), spline.range_c()[1])
                }),
                range: of.effective_range_c(model.temperature_range_c),
            })
        };
        let of = |sensor: Sensor, unit| {
            let triad = model.triad(sensor);
            [
                table(sensor, &triad.bias.temperature, "bias", unit),
                table(sensor, &triad.scale_factor.temperature, "scale", "1"),
            ]
        };
        let (precision, allowed) = match request.precision {
            Precision::F64 => ("f64", 1e-12),
            Precision::F32 => ("f32", 1.0 / 262_144.0),
        };
        Ok(Self {
            name: safe(request.name),
            held: request.held.iter().map(|name| safe(name)).collect(),
            precision,
            tables: [of(Sensor::Gyro, "rad/s"), of(Sensor::Accel, "m/s^2")],
            cases: cases::cases(&model, &inverse),
            inverse,
            model,
            allowed,
        })
    }

    fn table(&self, sensor: Sensor, kind: usize) -> Option<&Table<T>> {
        self.tables.get(sensor.index())?.get(kind)?.as_ref()
    }

    fn all_tables(&self) -> impl Iterator<Item = &Table<T>> {
        self.tables.iter().flatten().flatten()
    }

    fn has_polynomial(&self) -> bool {
        self.all_tables().any(|table| !table.polynomial.is_empty())
    }

    fn has_spline(&self) -> bool {
        self.all_tables().any(|table| table.spline.is_some())
    }

    fn has_scale_table(&self, sensor: Sensor) -> bool {
        self.table(sensor, 1).is_some()
    }

    fn depends_on_temperature(&self, sensor: Sensor) -> bool {
        self.table(sensor, 0).is_some() || self.has_scale_table(sensor)
    }

    fn is_nonlinear(&self, sensor: Sensor) -> bool {
        let triad = self.model.triad(sensor);
        triad.nonlinearity.is_present() || triad.asymmetry.is_present()
    }

    fn has_g(&self) -> bool {
        self.model.gyro_g_sensitivity.is_present()
    }

    fn has_h(&self) -> bool {
        self.model.gyro_g2_sensitivity.is_present()
    }

    /// H q(f), the same in both languages; as in the library a part that is absent is left out,
    /// since 0 times an infinite square is no number.
    fn g2_terms(&self, indent: &str) -> String {
        let rows = &self.model.gyro_g2_sensitivity.matrix;
        let any = |from: usize| {
            let part = rows.iter().flat_map(|row| row.iter().skip(from).take(3));
            part.into_iter().any(|h| *h != T::ZERO)
        };
        let mut out = String::new();
        if any(0) {
            let _ = writeln!(
                out,
                "{indent}rest[k] -= h[0] * (f[0] * f[0]) + h[1] * (f[1] * f[1]) + h[2] * (f[2] * f[2]);"
            );
        }
        if any(3) {
            let _ = writeln!(
                out,
                "{indent}rest[k] -= h[3] * (f[0] * f[1]) + h[4] * (f[0] * f[2]) + h[5] * (f[1] * f[2]);"
            );
        }
        out
    }

    fn has_offset(&self) -> bool {
        self.model.accel_axis_offset.is_present()
    }

    fn couples(&self) -> bool {
        self.has_g() || self.has_h()
    }

    /// I + M at T0.
    fn gain(&self, sensor: Sensor) -> vector::Matrix<T> {
        let triad = self.model.triad(sensor);
        let (s, m) = (
            triad.scale_factor.fixed,
            triad.misalignment.elements.plus(&triad.cross_axis.elements),
        );
        let one = T::ONE;
        [
            [one + s[0], m.xy, m.xz],
            [m.yx, one + s[1], m.yz],
            [m.zx, m.zy, one + s[2]],
        ]
    }

    /// The comment at the head of a file: what it is and where its numbers come from.
    fn head(&self) -> Vec<String> {
        let bound = self.inverse.bound();
        let mut lines = vec![
            format!("Compensation of an inertial sensor: {}", self.name),
            format!(
                "Written by sagnac {} in {}; {} rounds.",
                env!("CARGO_PKG_VERSION"),
                self.precision,
                self.inverse.rounds()
            ),
        ];
        lines.push(match bound {
            Some(bound) => format!(
                "Inside the convergence bound: mu + nu = {:.4} (gyro), {:.4} (accelerometer), q = {:.2e}.",
                (bound.mu[0] + bound.nu[0]).to_f64(),
                (bound.mu[1] + bound.nu[1]).to_f64(),
                bound.q.to_f64()
            ),
            None => "Without a range the convergence bound is judged for each sample.".to_owned(),
        });
        lines.push(
            "Not undone: noise, run-to-run draws, low-pass, rounding, saturation.".to_owned(),
        );
        if !self.held.is_empty() {
            lines.push("Not corrected, held at zero in the calibration:".to_owned());
            lines.extend(
                self.held
                    .chunks(3)
                    .map(|names| format!("  {}", names.join(", "))),
            );
        }
        lines
    }
}

/// A number that reads back to the same bits.
fn number<T: Real>(x: T, precision: &str) -> String {
    if precision == "f32" {
        format!("{:e}", x.to_f64() as f32)
    } else {
        format!("{:e}", x.to_f64())
    }
}

/// A name that cannot end a comment or a line of it.
fn safe(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars().take(120) {
        match c {
            '*' | '/' | '\\' | '?' => {
                let _ = write!(out, "_");
            }
            // Control characters, and those that turn the direction of a line or break it unseen.
            c if c.is_control()
                || matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}') =>
            {
                out.push(' ');
            }
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_can_neither_end_a_comment_nor_turn_its_direction() {
        assert_eq!(
            safe("a*/b\n\u{202e}c\u{2066}d\u{2028}e\u{200f}"),
            "a__b  c d e "
        );
        assert_eq!(safe("µ-IMU «7»"), "µ-IMU «7»");
    }
}
