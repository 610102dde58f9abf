//! Threshold and dead band: the smallest input that is answered by half of what the slope promises.

use super::Point;

/// Threshold and dead band, in the unit of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// The larger side.
    pub value: f64,
    /// The side of positive inputs.
    pub positive: f64,
    /// The side of negative inputs.
    pub negative: f64,
    /// Width between the largest inputs that are not answered; a lower bound as fine as the points.
    pub dead_band: f64,
}

pub(super) fn threshold(
    points: &[Point],
    slope: f64,
    tolerance: f64,
) -> Result<Threshold, &'static str> {
    let zero = points
        .iter()
        .find(|p| p.reference.abs() <= tolerance)
        .ok_or("no reading was taken at an input of zero")?;
    let side = |sign: f64| {
        let mut inputs: Vec<(f64, f64)> = points
            .iter()
            .filter(|p| p.reference * sign > tolerance)
            .map(|p| {
                (
                    p.reference.abs(),
                    (p.mean - zero.mean) * (slope * p.reference).signum(),
                )
            })
            .collect();
        inputs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let answered = inputs.iter().find(|(x, y)| *y >= 0.5 * slope.abs() * x)?.0;
        let silent = inputs
            .iter()
            .map(|i| i.0)
            .take_while(|x| *x < answered)
            .last()
            .unwrap_or(0.0);
        Some((answered, silent))
    };
    let (positive, silent_plus) =
        side(1.0).ok_or("no positive input is answered by half the slope or more")?;
    let (negative, silent_minus) =
        side(-1.0).ok_or("no negative input is answered by half the slope or more")?;
    Ok(Threshold {
        value: positive.max(negative),
        positive,
        negative,
        dead_band: silent_plus + silent_minus,
    })
}
