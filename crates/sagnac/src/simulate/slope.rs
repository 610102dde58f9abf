//! Angular acceleration from the rate: the slope at t_k of the parabola through samples k−1, k, k+1.
//!
//! At the ends of a stretch without gaps the first or last three; two samples: their difference;
//! one: 0 (model.md §2). Rows more than 1.5 dt apart are not joined.

/// Slope at `t` of the parabola through three points.
fn parabola(t: [f64; 3], w: [f64; 3], at: f64) -> f64 {
    let first = (w[1] - w[0]) / (t[1] - t[0]);
    let second = (w[2] - w[1]) / (t[2] - t[1]);
    first + (second - first) / (t[2] - t[0]) * ((at - t[0]) + (at - t[1]))
}

/// Slopes of `rate` at rows `rows` of the rows at hand; two rows on either side must be at hand,
/// where the log has them.
pub fn slopes(
    time_s: &[f64],
    rate: &[f64],
    dt_s: f64,
    rows: std::ops::Range<usize>,
    out: &mut Vec<f64>,
) {
    let joined = |k: usize| {
        // Whether rows k and k + 1 belong together.
        time_s.get(k + 1).is_some_and(|next| {
            let step = next - time_s[k];
            step > 0.0 && step <= 1.5 * dt_s
        })
    };
    for k in rows {
        let before = k > 0 && joined(k - 1);
        let after = joined(k);
        let three = |first: usize| {
            let part = |x: &[f64]| [x[first], x[first + 1], x[first + 2]];
            parabola(part(time_s), part(rate), time_s[k])
        };
        let two =
            |first: usize| (rate[first + 1] - rate[first]) / (time_s[first + 1] - time_s[first]);
        out.push(match (before, after) {
            (true, true) => three(k - 1),
            (false, true) if joined(k + 1) => three(k),
            (false, true) => two(k),
            (true, false) if k > 1 && joined(k - 2) => three(k - 2),
            (true, false) => two(k - 1),
            (false, false) => 0.0,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_exact_also_at_ends_and_beside_gaps() {
        let dt = 0.01;
        let mut time: Vec<f64> = (1..=20).map(|k| f64::from(k) * dt).collect();
        for t in &mut time[12..] {
            *t += 1.0;
        }
        let rate: Vec<f64> = time.iter().map(|t| 1.0 + 2.0 * t + 3.0 * t * t).collect();
        let mut out = Vec::new();
        slopes(&time, &rate, dt, 0..20, &mut out);
        for (slope, t) in out.iter().zip(&time) {
            assert!((slope - (2.0 + 6.0 * t)).abs() < 1e-10, "{t}: {slope}");
        }
    }

    #[test]
    fn short_stretches() {
        let mut out = Vec::new();
        slopes(&[0.01], &[5.0], 0.01, 0..1, &mut out);
        slopes(&[0.01, 0.02], &[5.0, 6.0], 0.01, 0..2, &mut out);
        assert_eq!(out[0], 0.0);
        assert!((out[1] - 100.0).abs() < 1e-9 && (out[2] - 100.0).abs() < 1e-9);
    }
}
