//! Small curves in a terminal: both axes logarithmic, a letter a curve, plain ASCII.

use super::number::general;

/// A curve and the letter that it is drawn with.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The letter.
    pub mark: char,
    /// Points; those that are not positive are left out.
    pub points: Vec<(f64, f64)>,
}

/// Curves below a title, in lines of at most `columns`: `rows` of the field and one of the horizontal axis.
///
/// The ends of both axes are the extremes of the points. Where two curves meet stands `*`. Empty where there is
/// nothing to draw.
///
/// ```
/// use sagnac_report::text::{Curve, curves};
/// let falling = Curve { mark: 'x', points: vec![(1.0, 100.0), (10.0, 10.0), (100.0, 1.0)] };
/// assert_eq!(
///     curves("gyro, deg/h", &[falling], 15, 3),
///     ["gyro, deg/h", "100 |x", "    |     x", "  1 |         x", "     1      100"]
/// );
/// ```
pub fn curves(title: &str, curves: &[Curve], columns: usize, rows: usize) -> Vec<String> {
    let points = || {
        let all = curves.iter().flat_map(|c| &c.points);
        all.filter(|(x, y)| x.min(*y) > 0.0 && x.is_finite() && y.is_finite())
    };
    let span = |pick: fn(&(f64, f64)) -> f64| {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        points()
            .map(pick)
            .fold(ends, |e, v| (e.0.min(v), e.1.max(v)))
    };
    let (left, right) = span(|p| p.0);
    let (bottom, top) = span(|p| p.1);
    if points().next().is_none() || rows < 2 {
        return Vec::new();
    }
    let labels = [general(top, 3), general(bottom, 3)];
    let margin = labels.iter().map(String::len).max().unwrap_or(0);
    let wide = columns.saturating_sub(margin + 2).max(2);
    let place = |v: f64, (low, high): (f64, f64), cells: usize| {
        let share = if high > low {
            (v / low).ln() / (high / low).ln()
        } else {
            0.0
        };
        (share * (cells - 1) as f64).round() as usize
    };
    let mut field = vec![vec![' '; wide]; rows];
    for curve in curves {
        for &(x, y) in &curve.points {
            if !(x.min(y) > 0.0 && x.is_finite() && y.is_finite()) {
                continue;
            }
            let row = rows - 1 - place(y, (bottom, top), rows);
            let cell = &mut field[row][place(x, (left, right), wide)];
            *cell = match *cell {
                ' ' => curve.mark,
                own if own == curve.mark => own,
                _ => '*',
            };
        }
    }
    let mut lines = vec![title.to_owned()];
    for (k, row) in field.iter().enumerate() {
        let label = match k {
            0 => &labels[0],
            k if k == rows - 1 => &labels[1],
            _ => "",
        };
        let row: String = row.iter().collect();
        lines.push(format!("{label:>margin$} |{}", row.trim_end()));
    }
    let (first, last) = (general(left, 3), general(right, 3));
    let gap = wide.saturating_sub(first.len() + last.len()).max(1);
    lines.push(format!(
        "{}{first}{}{last}",
        " ".repeat(margin + 2),
        " ".repeat(gap)
    ));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_that_meet_are_starred_and_lines_stay_short() {
        let of = |mark, points: &[(f64, f64)]| Curve {
            mark,
            points: points.to_vec(),
        };
        let lines = curves(
            "t",
            &[
                of('x', &[(0.01, 1145.0), (1.0, 145.6), (100.0, 32.4)]),
                of('y', &[(0.01, 1145.0), (100.0, 33.8), (1000.0, 0.0)]),
            ],
            40,
            8,
        );
        assert_eq!(lines.len(), 10);
        assert!(lines.iter().all(|l| l.len() <= 40), "{lines:?}");
        assert_eq!(lines[1], "1150 |*");
        assert!(lines[8].starts_with("32.4 |") && lines[8].ends_with('*'));
        assert!(curves("t", &[of('x', &[(1.0, f64::NAN)])], 40, 8).is_empty());
    }
}
