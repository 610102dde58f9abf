//! Several calibrations of one sensor as one, weighted by their covariances.
//!
//! x̂ = C Σ_i P_iᵀ C_i⁻¹ x_i, C = (Σ_i P_iᵀ C_i⁻¹ P_i)⁻¹ over the union of parameters. A calibration in the frame of the
//! accelerometer has m_xy = m_xz = m_yz = 0 there, so it is turned from the fixture by δ with [δ×]_ij = M_ij of these
//! three: m_ij = M_ij − [δ×]_ij for both sensors, to first order in small angles.
//!
//! ```
//! use sagnac_calibrate::merge::{Part, merge};
//! let part = |value, sigma: f64| Part {
//!     label: "one".into(), names: vec!["accel.scale_factor.x".into()], values: vec![value],
//!     covariance: vec![vec![sigma * sigma]], own_frame: false,
//! };
//! let found = merge(&[part(1e-3, 1e-5), part(1.1e-3, 1e-4)], true)?;
//! assert!((found.values[0] - (1e-3 + 1e-4 / 101.0)).abs() < 1e-12);
//! # Ok::<(), sagnac_calibrate::merge::Error>(())
//! ```

use nalgebra::{DMatrix, DVector};

/// What one calibration found.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// What it is called.
    pub label: String,
    /// Parameter paths.
    pub names: Vec<String>,
    /// Values, SI.
    pub values: Vec<f64>,
    /// Covariance, whole.
    pub covariance: Vec<Vec<f64>>,
    /// Whether its frame is that of the accelerometer's sense axes, not of a fixture.
    pub own_frame: bool,
}

/// Two calibrations that differ by more than three standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    /// The parameter.
    pub name: String,
    /// Places of the two parts.
    pub parts: [usize; 2],
    /// Their values.
    pub values: [f64; 2],
    /// Their standard errors.
    pub sigmas: [f64; 2],
    /// |difference| over its standard error.
    pub z: f64,
}

/// One calibration of all.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// Parameter paths.
    pub names: Vec<String>,
    /// Values.
    pub values: Vec<f64>,
    /// Covariance, whole.
    pub covariance: Vec<Vec<f64>>,
    /// Differences beyond three standard deviations.
    pub conflicts: Vec<Conflict>,
    /// Whether frames were turned into that of a fixture.
    pub turned: bool,
}

/// Why calibrations cannot be merged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A covariance that is none.
    #[error("the covariance of {label} is not positive definite")]
    Covariance {
        /// Whose.
        label: String,
    },
    /// Nothing to merge.
    #[error("no calibration has parameters with standard errors")]
    Nothing,
    /// A combination of parameters of which nothing is known.
    #[error("the covariances leave a combination of the parameters undetermined")]
    Singular,
}

impl Error {
    /// What to do.
    pub fn advice(&self) -> String {
        match self {
            Self::Covariance { .. } => {
                "repair its [[calibration]] block, or leave out `covariance` so that its sigmas count".to_owned()
            }
            Self::Singular => "name the model that determines it as well, or write the covariance of independent parameters".to_owned(),
            Self::Nothing => "name models that sagnac calibrate or characterize wrote".to_owned(),
        }
    }
}

/// The part of a misalignment that the turn of the frame makes: name of the accelerometer's element, and its sign.
fn turn(name: &str) -> Option<(&'static str, f64)> {
    let (_, element) = name.split_once(".misalignment.")?;
    Some(match element {
        "xy" => ("accel.misalignment.xy", -1.0),
        "yx" => ("accel.misalignment.xy", 1.0),
        "xz" => ("accel.misalignment.xz", -1.0),
        "zx" => ("accel.misalignment.xz", 1.0),
        "yz" => ("accel.misalignment.yz", -1.0),
        "zy" => ("accel.misalignment.yz", 1.0),
        _ => return None,
    })
}

const ZERO_IN_OWN_FRAME: [&str; 3] = [
    "accel.misalignment.xy",
    "accel.misalignment.xz",
    "accel.misalignment.yz",
];

/// The parameters that a row of a part is a sum of.
fn row_of(part: &Part, i: usize, turned: bool) -> Vec<(String, f64)> {
    let name = &part.names[i];
    let mut out = vec![(name.clone(), 1.0)];
    if turned
        && part.own_frame
        && let Some((of, sign)) = turn(name)
    {
        out.push((of.to_owned(), sign));
    }
    out
}

/// Rows of a part that say something: the three elements that are zero by its frame do not.
fn rows(part: &Part) -> Vec<usize> {
    (0..part.names.len())
        .filter(|i| !(part.own_frame && ZERO_IN_OWN_FRAME.contains(&part.names[*i].as_str())))
        .collect()
}

/// Merges calibrations; with `to_fixture` those in the accelerometer's frame are turned into the fixture's where that
/// can be told.
///
/// # Errors
/// A covariance that is not positive definite; no parameters at all.
pub fn merge(parts: &[Part], to_fixture: bool) -> Result<Merged, Error> {
    let wants =
        to_fixture && parts.iter().any(|p| p.own_frame) && parts.iter().any(|p| !p.own_frame);
    if wants && let Some(found) = attempt(parts, true)? {
        return Ok(found);
    }
    attempt(parts, false)?.ok_or_else(|| {
        if parts.iter().all(|p| rows(p).is_empty()) {
            Error::Nothing
        } else {
            Error::Singular
        }
    })
}

fn attempt(parts: &[Part], turned: bool) -> Result<Option<Merged>, Error> {
    let mut names: Vec<String> = Vec::new();
    for part in parts {
        for i in rows(part) {
            for (name, _) in row_of(part, i, turned) {
                if !names.contains(&name) {
                    names.push(name);
                }
            }
        }
    }
    let n = names.len();
    let place = |name: &str| names.iter().position(|other| other == name).unwrap_or(0);
    let mut information = DMatrix::<f64>::zeros(n, n);
    let mut side = DVector::<f64>::zeros(n);
    for part in parts {
        let used = rows(part);
        if used.is_empty() {
            continue;
        }
        // In units of the standard errors, so that parameters of any size are alike.
        let sigmas: Vec<f64> = used
            .iter()
            .map(|i| part.covariance[*i][*i].sqrt())
            .collect();
        let correlation = DMatrix::from_fn(used.len(), used.len(), |a, b| {
            part.covariance[used[a]][used[b]] / sigmas[a] / sigmas[b]
        });
        let bad = || Error::Covariance {
            label: part.label.clone(),
        };
        if sigmas.iter().any(|s| s.is_nan() || *s <= 0.0) {
            return Err(bad());
        }
        let weight = correlation.cholesky().ok_or_else(bad)?.inverse();
        let mut picks = DMatrix::<f64>::zeros(used.len(), n);
        let mut value = DVector::<f64>::zeros(used.len());
        for (a, i) in used.iter().enumerate() {
            for (name, sign) in row_of(part, *i, turned) {
                picks[(a, place(&name))] += sign / sigmas[a];
            }
            value[a] = part.values[*i] / sigmas[a];
        }
        information += picks.transpose() * &weight * &picks;
        side += picks.transpose() * &weight * &value;
    }
    if n == 0 {
        return Ok(None);
    }
    // Scaled to a unit diagonal, so that what is not determined shows.
    let scale: Vec<f64> = (0..n).map(|i| information[(i, i)].sqrt()).collect();
    let unit = DMatrix::from_fn(n, n, |i, j| information[(i, j)] / scale[i] / scale[j]);
    let smallest = unit.clone().symmetric_eigenvalues().min();
    if smallest.is_nan() || smallest < 1e-12 {
        return Ok(None);
    }
    let Some(inverse) = unit.cholesky().map(|c| c.inverse()) else {
        return Ok(None);
    };
    let mut covariance = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / scale[i] / scale[j]);
    let solved = &covariance * side;
    let mut out = Merged {
        values: solved.iter().copied().collect(),
        covariance: Vec::new(),
        conflicts: Vec::new(),
        turned,
        names,
    };
    for (p, name) in out.names.iter().enumerate() {
        // Values of each part in the frame of the result.
        let seen: Vec<(usize, f64, f64)> = parts
            .iter()
            .enumerate()
            .filter_map(|(number, part)| {
                let i = rows(part).into_iter().find(|i| part.names[*i] == *name)?;
                let moved: f64 = row_of(part, i, turned)
                    .iter()
                    .skip(1)
                    .map(|(of, sign)| {
                        let at = out.names.iter().position(|other| other == of);
                        at.map_or(0.0, |at| sign * out.values[at])
                    })
                    .sum();
                Some((number, part.values[i] - moved, part.covariance[i][i].sqrt()))
            })
            .collect();
        let before = out.conflicts.len();
        for (n, a) in seen.iter().enumerate() {
            for b in &seen[n + 1..] {
                let z = (a.1 - b.1).abs() / a.2.hypot(b.2);
                if z > 3.0 {
                    out.conflicts.push(Conflict {
                        name: name.clone(),
                        parts: [a.0, b.0],
                        values: [a.1, b.1],
                        sigmas: [a.2, b.2],
                        z,
                    });
                }
            }
        }
        if out.conflicts.len() > before {
            let chi2: f64 = seen
                .iter()
                .map(|(_, x, sigma)| ((x - out.values[p]) / sigma).powi(2))
                .sum();
            let factor = (chi2 / (seen.len() - 1) as f64).sqrt().max(1.0);
            covariance.row_mut(p).scale_mut(factor);
            covariance.column_mut(p).scale_mut(factor);
        }
    }
    out.covariance = (0..n)
        .map(|i| covariance.row(i).iter().copied().collect())
        .collect();
    Ok(Some(out))
}

/// Coefficients of a polynomial in T − a as one in T − b, with `shift` = b − a: a matrix for (c0, c1, …).
pub fn shift_matrix(order: usize, shift: f64) -> Vec<Vec<f64>> {
    let mut out = vec![vec![0.0; order + 1]; order + 1];
    for i in 0..=order {
        let mut binomial = 1.0;
        for j in (0..=i).rev() {
            out[j][i] = binomial * shift.powi((i - j) as i32);
            binomial *= j as f64 / (i - j + 1) as f64;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn part(names: &[&str], values: &[f64], sigma: f64, own_frame: bool) -> Part {
        let n = names.len();
        Part {
            label: "part".to_owned(),
            names: names.iter().map(|n| (*n).to_owned()).collect(),
            values: values.to_vec(),
            covariance: (0..n)
                .map(|i| {
                    (0..n)
                        .map(|j| {
                            if i == j {
                                sigma * sigma
                            } else {
                                0.3 * sigma * sigma
                            }
                        })
                        .collect()
                })
                .collect(),
            own_frame,
        }
    }

    #[test]
    fn polynomial_shift() {
        // 1 + 2 D + 3 D² with D = E + 4 is 57 + 26 E + 3 E².
        let m = shift_matrix(2, 4.0);
        let of = |j: usize| m[j][0] + 2.0 * m[j][1] + 3.0 * m[j][2];
        assert_eq!([of(0), of(1), of(2)], [57.0, 26.0, 3.0]);
    }

    #[test]
    fn conflict_widens() {
        let a = part(&["accel.scale_factor.x"], &[0.0], 1.0, false);
        let b = part(&["accel.scale_factor.x"], &[10.0], 1.0, false);
        let found = merge(&[a, b], true).unwrap();
        assert_eq!(found.conflicts.len(), 1);
        assert!((found.conflicts[0].z - 50f64.sqrt()).abs() < 1e-12);
        assert!((found.values[0] - 5.0).abs() < 1e-12);
        // σ = 1/√2 times √50.
        assert!((found.covariance[0][0] - 25.0).abs() < 1e-9);
    }

    /// A calibration in the accelerometer's frame is turned into that of the fixture.
    #[test]
    fn frames() {
        let elements = ["xy", "xz", "yx", "yz", "zx", "zy"];
        let accel: Vec<String> = elements
            .iter()
            .map(|e| format!("accel.misalignment.{e}"))
            .collect();
        let gyro: Vec<String> = elements
            .iter()
            .map(|e| format!("gyro.misalignment.{e}"))
            .collect();
        let truth_a = [1e-3, -2e-3, 0.5e-3, 3e-3, -1e-3, 0.2e-3];
        let truth_g = [2e-3, 1e-3, -0.5e-3, 0.3e-3, 0.7e-3, -1.2e-3];
        let all: Vec<&str> = accel.iter().chain(&gyro).map(String::as_str).collect();
        let values: Vec<f64> = truth_a.iter().chain(&truth_g).copied().collect();
        let fixture = part(&all, &values, 1e-5, false);
        // δ from the accelerometer's three elements: [δ×]_xy = M_xy and so on.
        let turned = |m: [f64; 6]| {
            let d = [truth_a[0], truth_a[1], truth_a[3]];
            [
                m[0] - d[0],
                m[1] - d[1],
                m[2] + d[0],
                m[3] - d[2],
                m[4] + d[1],
                m[5] + d[2],
            ]
        };
        let own_a = turned(truth_a);
        assert!(own_a[0] == 0.0 && own_a[1] == 0.0 && own_a[3] == 0.0);
        let mut own: Vec<f64> = vec![own_a[2], own_a[4], own_a[5]];
        own.extend(turned(truth_g));
        let mut names: Vec<&str> = vec![all[2], all[4], all[5]];
        names.extend(&all[6..]);
        let by_hand = part(&names, &own, 1e-6, true);
        let found = merge(&[fixture, by_hand], true).unwrap();
        assert!(found.turned && found.conflicts.is_empty());
        for (name, want) in all.iter().zip(&values) {
            let at = found.names.iter().position(|n| n == name).unwrap();
            assert!((found.values[at] - want).abs() < 1e-12, "{name}");
        }
    }
}
