//! Temperature splines in a merge: as many independent numbers as knots.
//!
//! A calibration states `fixed` = value at T0 and rows r_i = value at knot i − value at T0, so that Σ a_i r_i = 0, a the
//! weights of the spline at T0 (Σ a_i = 1): one row follows from the others and has no place in a covariance that is
//! inverted. It is taken out before, and put back after.

use sagnac_calibrate::merge::{Merged, Part};
use sagnac_core::{Sensor, TemperatureSpline};
use sagnac_model::{Model, ThermalTerm};

use crate::Error;

const TERMS: [(ThermalTerm, &str); 2] = [
    (ThermalTerm::Bias, "bias"),
    (ThermalTerm::ScaleFactor, "scale_factor"),
];
const AXES: [&str; 3] = ["x", "y", "z"];

/// Whether a path is a row of a spline.
pub(super) fn is_row(name: &str) -> bool {
    name.contains(".temperature_spline.")
}

/// The temperature splines of all models, each term in one set of knots.
pub(super) struct Splines {
    terms: Vec<Spline>,
}

struct Spline {
    sensor: Sensor,
    term: ThermalTerm,
    key: &'static str,
    knots_c: Vec<f64>,
    /// Weights of the rows at T0 of the result.
    at: Vec<f64>,
    /// The row that follows from the others.
    left_out: usize,
}

impl Spline {
    fn stem(&self) -> String {
        format!("{}.{}", self.sensor.key(), self.key)
    }

    fn row(&self, i: usize, axis: &str) -> String {
        format!("{}.temperature_spline.{}.{axis}", self.stem(), i + 1)
    }

    /// Places of the rows of an axis, where all are there.
    fn places(&self, names: &[String], axis: &str) -> Option<Vec<usize>> {
        (0..self.knots_c.len())
            .map(|i| {
                let name = self.row(i, axis);
                names.iter().position(|n| *n == name)
            })
            .collect()
    }
}

impl Splines {
    /// Finds the splines; `t0_c` is the reference temperature of the result.
    ///
    /// # Errors
    /// Splines of one term on other knots, or beside a polynomial of another model: no curve holds both.
    pub(super) fn of(models: &[Model], t0_c: f64) -> Result<Self, Error> {
        let mut terms = Vec::new();
        for sensor in Sensor::ALL {
            for (term, key) in TERMS {
                let with = |m: &&Model| m.knots_c(sensor, term).is_some();
                let Some(first) = models.iter().find(with) else {
                    continue;
                };
                let knots_c = first.knots_c(sensor, term).unwrap_or_default().to_vec();
                let polynomial = format!("{}.{key}.temperature.", sensor.key());
                for other in models {
                    let refuse = |what: String| {
                        Err(Error::data(what)
                            .at(format!("{}, {}", first.label(), other.label()))
                            .advise(
                                "calibrate both by --form polynomial, or give both logs to one calibrate thermal",
                            ))
                    };
                    match other.knots_c(sensor, term) {
                        Some(knots) if knots != knots_c => {
                            return refuse(format!(
                                "the splines of {}.{key} have other knots: they cannot be weighed against each other",
                                sensor.key()
                            ));
                        }
                        None if other.parameters().any(|(path, entry)| {
                            entry.value.is_some_and(|v| v != 0.0)
                                && path.to_string().starts_with(&polynomial)
                        }) =>
                        {
                            return refuse(format!(
                                "{}.{key} is a spline of temperature in one model and a polynomial in another: no curve holds both",
                                sensor.key()
                            ));
                        }
                        _ => {}
                    }
                }
                let at = weights(&knots_c, t0_c)?;
                let left_out = (0..at.len())
                    .max_by(|a, b| at[*a].abs().total_cmp(&at[*b].abs()))
                    .unwrap_or(0);
                terms.push(Spline {
                    sensor,
                    term,
                    key,
                    knots_c,
                    at,
                    left_out,
                });
            }
        }
        Ok(Self { terms })
    }

    /// States a model's splines about T0 of the result, and takes the row out that follows from the others.
    pub(super) fn reduce(&self, part: &mut Part) {
        for spline in &self.terms {
            for axis in AXES {
                let Some(rows) = spline.places(&part.names, axis) else {
                    continue;
                };
                let fixed = format!("{}.{axis}", spline.stem());
                let fixed = part.names.iter().position(|n| *n == fixed);
                let n = part.names.len();
                let mut whole: Vec<Vec<f64>> = (0..n)
                    .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
                    .collect();
                for (row, a) in rows.iter().zip(&spline.at) {
                    for to in &rows {
                        whole[*to][*row] -= a;
                    }
                    if let Some(fixed) = fixed {
                        whole[fixed][*row] += a;
                    }
                }
                apply(part, &whole);
                let gone = rows[spline.left_out];
                part.names.remove(gone);
                part.values.remove(gone);
                part.covariance.remove(gone);
                for row in &mut part.covariance {
                    row.remove(gone);
                }
            }
        }
    }

    /// Puts the rows back that were taken out.
    pub(super) fn restore(&self, merged: &mut Merged) {
        for spline in &self.terms {
            for axis in AXES {
                let others: Option<Vec<(usize, f64)>> = (0..spline.at.len())
                    .filter(|i| *i != spline.left_out)
                    .map(|i| {
                        let name = spline.row(i, axis);
                        let at = merged.names.iter().position(|n| *n == name)?;
                        Some((at, -spline.at[i] / spline.at[spline.left_out]))
                    })
                    .collect();
                let Some(others) = others else { continue };
                let along = |row: &[f64]| others.iter().map(|(j, a)| a * row[*j]).sum::<f64>();
                let value = along(&merged.values);
                let mut last: Vec<f64> = merged.covariance.iter().map(|row| along(row)).collect();
                last.push(along(&last));
                for (row, c) in merged.covariance.iter_mut().zip(&last) {
                    row.push(*c);
                }
                merged.covariance.push(last);
                merged.values.push(value);
                merged.names.push(spline.row(spline.left_out, axis));
            }
        }
    }

    /// Writes the splines that were merged.
    pub(super) fn write(&self, merged: &Merged, out: &mut Model) -> Result<(), Error> {
        for spline in &self.terms {
            let mut values = vec![[0.0; 3]; spline.knots_c.len()];
            let mut is_any = false;
            for (k, axis) in AXES.into_iter().enumerate() {
                if let Some(rows) = spline.places(&merged.names, axis) {
                    is_any = true;
                    for (value, row) in values.iter_mut().zip(rows) {
                        value[k] = merged.values[row];
                    }
                }
            }
            if is_any {
                out.set_spline(spline.sensor, spline.term, &spline.knots_c, &values)?;
            }
        }
        Ok(())
    }
}

/// Weights of the values at the knots in the spline's value at a temperature; held outside.
fn weights(knots_c: &[f64], at_c: f64) -> Result<Vec<f64>, Error> {
    (0..knots_c.len())
        .map(|j| {
            let mut unit = vec![[0.0; 3]; knots_c.len()];
            unit[j] = [1.0; 3];
            TemperatureSpline::new(knots_c, &unit)
                .map(|spline| spline.at(at_c)[0])
                .map_err(|error| Error::data(format!("a temperature spline is none: {error}")))
        })
        .collect()
}

/// x ← S x, C ← S C Sᵀ.
pub(super) fn apply(part: &mut Part, whole: &[Vec<f64>]) {
    let n = part.names.len();
    let times = |a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<Vec<f64>> {
        (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| (0..n).map(|k| a[i][k] * b[k][j]).sum())
                    .collect()
            })
            .collect()
    };
    let transposed: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| whole[j][i]).collect())
        .collect();
    part.values = whole
        .iter()
        .map(|row| row.iter().zip(&part.values).map(|(a, b)| a * b).sum())
        .collect();
    part.covariance = times(&times(whole, &part.covariance), &transposed);
}
