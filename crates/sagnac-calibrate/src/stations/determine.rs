//! What a table determines: admission of groups of columns by rank, null space and standard errors.
//!
//! R = (I − QQᵀ)X for a group of unit columns X beside the admitted basis Q; null singular values of R mark
//! aliases, (RᵀR)⁻¹ gives the standard errors.

use nalgebra::{DMatrix, DVector};

/// Why a term is estimated or held at zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It can be estimated.
    Admitted,
    /// Its column is zero.
    NoInput,
    /// Its column is a combination of others.
    Aliased,
    /// The test says less than is known beforehand.
    Weak,
}

impl Status {
    /// As scripts know the reason.
    pub fn key(self) -> &'static str {
        match self {
            Self::Admitted => "admitted",
            Self::NoInput => "no_input",
            Self::Aliased => "aliased",
            Self::Weak => "weak",
        }
    }
}

/// A member of a group as admission sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// Its place among the columns.
    pub(crate) column: usize,
    /// Plausible size.
    pub(crate) plausible: f64,
    /// Weak whatever its standard error is (no rate that tells).
    pub(crate) weak: bool,
}

/// Admits groups in order; `design` holds weighted columns (or their triangular factor, which has the same
/// inner products). Standard errors count only where `has_errors`.
pub(crate) fn admit(
    design: &DMatrix<f64>,
    groups: &[Vec<Candidate>],
    has_errors: bool,
) -> Vec<Status> {
    let mut status = vec![Status::NoInput; design.ncols()];
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for group in groups {
        let mut members = Vec::new();
        let mut rest: Vec<DVector<f64>> = Vec::new();
        for candidate in group {
            let column = design.column(candidate.column);
            let norm = column.norm();
            if norm == 0.0 || !norm.is_finite() {
                continue;
            }
            let mut r = column / norm;
            // Twice, so that what is left is orthogonal to rounding.
            for _ in 0..2 {
                for q in &basis {
                    let along = q.dot(&r);
                    r.axpy(-along, q, 1.0);
                }
            }
            members.push((*candidate, norm));
            rest.push(r);
        }
        if members.is_empty() {
            continue;
        }
        let aliased = aliased(&rest);
        let mut kept: Vec<usize> = Vec::new();
        for (i, (candidate, _)) in members.iter().enumerate() {
            if aliased[i] {
                status[candidate.column] = Status::Aliased;
            } else {
                kept.push(i);
            }
        }
        if kept.is_empty() {
            continue;
        }
        let sigmas = standard_errors(&kept.iter().map(|i| rest[*i].clone()).collect::<Vec<_>>());
        for (place, i) in kept.into_iter().enumerate() {
            let (candidate, norm) = members[i];
            let weak = if has_errors {
                sigmas[place] / norm > candidate.plausible / 3.0
            } else {
                candidate.weak
            };
            if weak {
                status[candidate.column] = Status::Weak;
                continue;
            }
            status[candidate.column] = Status::Admitted;
            let mut q = rest[i].clone();
            for _ in 0..2 {
                for other in &basis {
                    let along = other.dot(&q);
                    q.axpy(-along, other, 1.0);
                }
            }
            let norm = q.norm();
            if norm > 1e-12 {
                basis.push(q / norm);
            }
        }
    }
    status
}

/// Which columns take part in a null combination.
fn aliased(columns: &[DVector<f64>]) -> Vec<bool> {
    let (n, q) = (columns[0].len().max(columns.len()), columns.len());
    let mut r = DMatrix::zeros(n, q);
    for (j, column) in columns.iter().enumerate() {
        r.view_mut((0, j), (column.len(), 1)).copy_from(column);
    }
    let svd = r.svd(false, true);
    let Some(v_t) = svd.v_t else {
        return vec![true; q];
    };
    (0..q)
        .map(|j| {
            let squared: f64 = svd
                .singular_values
                .iter()
                .enumerate()
                .filter(|(_, s)| **s < 1e-6)
                .map(|(i, _)| v_t[(i, j)] * v_t[(i, j)])
                .sum();
            squared.sqrt() > 1e-4
        })
        .collect()
}

fn standard_errors(columns: &[DVector<f64>]) -> Vec<f64> {
    let q = columns.len();
    let gram = DMatrix::from_fn(q, q, |i, j| columns[i].dot(&columns[j]));
    match gram.try_inverse() {
        Some(inverse) => (0..q).map(|i| inverse[(i, i)].max(0.0).sqrt()).collect(),
        None => vec![f64::INFINITY; q],
    }
}

/// The triangular factor of a matrix, padded with zero rows to be at least square.
pub(super) fn triangle(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let (n, p) = matrix.shape();
    if n <= p {
        return matrix.resize_vertically(p, 0.0);
    }
    matrix.qr().unpack_r()
}
