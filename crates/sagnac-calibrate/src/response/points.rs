//! Readings of equal reference as one point, and the direction in which each was reached.

use super::Reading;

/// The direction in which an input was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The input grew.
    Up,
    /// The input fell.
    Down,
}

/// All readings at one reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Reference X.
    pub reference: f64,
    /// Mean output of all readings.
    pub mean: f64,
    /// Mean output going up.
    pub up: Option<f64>,
    /// Mean output going down.
    pub down: Option<f64>,
    /// Mean less the least-squares line.
    pub residual: f64,
    /// Number of readings.
    pub count: usize,
}

/// The direction of every reading: as given, or where none is given the sign of the change of reference. Equal
/// references keep the direction; those before the first change take that of the change.
pub(super) fn directions(readings: &[Reading], tolerance: f64) -> Vec<Option<Direction>> {
    if readings.iter().any(|r| r.direction.is_some()) {
        return readings.iter().map(|r| r.direction).collect();
    }
    let mut out = vec![None; readings.len()];
    for i in 1..readings.len() {
        let change = readings[i].reference - readings[i - 1].reference;
        out[i] = if change > tolerance {
            Some(Direction::Up)
        } else if change < -tolerance {
            Some(Direction::Down)
        } else {
            out[i - 1]
        };
    }
    let first = out.iter().flatten().next().copied();
    for direction in &mut out {
        if direction.is_some() {
            break;
        }
        *direction = first;
    }
    out
}

/// Points of equal reference, ascending; residuals are left at 0.
pub(super) fn gather(
    readings: &[Reading],
    directions: &[Option<Direction>],
    tolerance: f64,
) -> Vec<Point> {
    let mut order: Vec<usize> = (0..readings.len()).collect();
    order.sort_by(|&a, &b| readings[a].reference.total_cmp(&readings[b].reference));
    let mut points: Vec<Point> = Vec::new();
    let mut start = 0;
    while start < order.len() {
        let x = readings[order[start]].reference;
        let end = start
            + order[start..]
                .iter()
                .take_while(|&&i| readings[i].reference - x <= tolerance)
                .count();
        let group = &order[start..end];
        let mean_of = |wanted: Option<Direction>| {
            let values: Vec<f64> = group
                .iter()
                .filter(|&&i| wanted.is_none() || directions[i] == wanted)
                .map(|&i| readings[i].output)
                .collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        points.push(Point {
            reference: x,
            mean: mean_of(None).unwrap_or(f64::NAN),
            up: mean_of(Some(Direction::Up)),
            down: mean_of(Some(Direction::Down)),
            residual: 0.0,
            count: group.len(),
        });
        start = end;
    }
    points
}

/// Index of the point that a reading belongs to.
pub(super) fn index_of(points: &[Point], reference: f64, tolerance: f64) -> usize {
    points
        .partition_point(|p| p.reference + tolerance < reference)
        .min(points.len().saturating_sub(1))
}
