//! What a table cannot tell: held terms with their aliases, what estimates assume of them, who is confused with whom.

use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF as _, FisherSnedecor};

use super::determine::Status;
use super::fit::solve;
use super::outcome::{Available, Decided, Held, Outcome};
use super::terms::Group;

/// What the table cannot tell of an axis, and which estimates depend on it.
pub(super) fn tell(axis: &Decided, runs: usize, outcome: &mut Outcome) {
    let factor = &axis.factor;
    let terms = &axis.problem.terms;
    let estimated = axis.estimated();
    let admitted: Vec<usize> = (0..terms.len())
        .filter(|i| axis.status[*i] == Status::Admitted)
        .collect();
    // Held columns by a set of others, least squares.
    let project = |held: usize, by: &[usize]| -> Vec<(usize, f64)> {
        let mut columns: Vec<usize> = by.to_vec();
        columns.push(held);
        let design = DMatrix::from_fn(factor.nrows(), columns.len(), |i, j| {
            factor[(i, columns[j])]
        });
        match (by.is_empty(), design.column(by.len()).norm() > 0.0) {
            (false, true) => {
                solve(design).map_or(Vec::new(), |s| by.iter().copied().zip(s.values).collect())
            }
            _ => Vec::new(),
        }
    };
    let mut assumes: Vec<(usize, usize)> = Vec::new();
    for (i, status) in axis.status.iter().enumerate() {
        if estimated.contains(&i) || terms[i].group == Group::Bias && runs > 1 {
            continue;
        }
        let shifts = project(i, &estimated);
        let p = axis.plausible(i);
        for (t, coefficient) in &shifts {
            let name = axis.name(*t);
            let sigma = outcome.parameter(&name).map_or(f64::INFINITY, |q| q.sigma);
            if p.is_finite() && (coefficient * p).abs() > sigma {
                assumes.push((*t, i));
            }
        }
        if *status == Status::Admitted {
            outcome.available.push(Available {
                name: axis.name(i),
                group: terms[i].group,
                p: fall(axis, &estimated, i),
            });
            continue;
        }
        let by = project(i, &admitted);
        let effect = |(t, c): &(usize, f64)| (c * factor.column(*t).norm()).abs();
        let largest = by.iter().map(effect).fold(0.0, f64::max);
        outcome.held.push(Held {
            name: axis.name(i),
            group: terms[i].group,
            status: *status,
            aliases: by
                .iter()
                .filter(|entry| effect(entry) > 1e-6 * largest)
                .map(|(t, c)| (axis.name(*t), *c))
                .collect(),
            asked: axis.asked[i],
        });
    }
    for (t, held) in assumes {
        let (name, of) = (axis.name(t), axis.name(held));
        if let Some(parameter) = outcome.parameters.iter_mut().find(|q| q.name == name)
            && !parameter.assumes.contains(&of)
        {
            parameter.assumes.push(of);
        }
    }
    let names: Vec<String> = outcome.covariance_names.clone();
    let own: Vec<usize> = (0..names.len())
        .filter(|i| {
            outcome
                .parameter(&names[*i])
                .is_some_and(|p| p.sensor == axis.problem.sensor && p.axis == axis.problem.k)
        })
        .collect();
    for (n, i) in own.iter().enumerate() {
        for j in &own[..n] {
            let c = &outcome.covariance;
            let r = c[*i][*j] / (c[*i][*i] * c[*j][*j]).sqrt();
            if r.abs() > 0.95 {
                outcome
                    .confused
                    .push((names[*j].clone(), names[*i].clone(), r));
            }
        }
    }
}

/// The probability of the fall of χ² that one more column brings, by Fisher's F.
fn fall(axis: &Decided, estimated: &[usize], more: usize) -> Option<f64> {
    let side = axis.factor.ncols() - 1;
    let chi2 = |with: &[usize]| -> Option<f64> {
        let mut columns = with.to_vec();
        columns.push(side);
        let design = DMatrix::from_fn(axis.factor.nrows(), columns.len(), |i, j| {
            axis.factor[(i, columns[j])]
        });
        solve(design).map(|s| s.chi2)
    };
    let rows = axis.problem.rows.len();
    let dof = rows.checked_sub(estimated.len() + 1).filter(|d| *d > 0)? as f64;
    let mut wider = estimated.to_vec();
    wider.push(more);
    let (old, new) = (chi2(estimated)?, chi2(&wider)?);
    let f = (old - new).max(0.0) / (new / dof);
    let distribution = FisherSnedecor::new(1.0, dof).ok()?;
    f.is_finite().then(|| distribution.sf(f))
}
