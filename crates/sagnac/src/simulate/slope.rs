//! Angular acceleration from the rate: the slope at t_k of the parabola through samples k−1, k, k+1.
//!
//! At the ends of a stretch without gaps the first or last three; two samples: their difference;
//! one: 0 (model.md §2). Rows more than 1.5 dt apart are not joined; those that are count as dt apart, because the scatter
//! of stamps is that of their clock, not of the sampling.

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
        out.push(match (before, after) {
            (true, true) => (rate[k + 1] - rate[k - 1]) / (2.0 * dt_s),
            (false, true) if joined(k + 1) => {
                (4.0 * (rate[k + 1] - rate[k]) - (rate[k + 2] - rate[k])) / (2.0 * dt_s)
            }
            (false, true) => (rate[k + 1] - rate[k]) / dt_s,
            (true, false) if k > 1 && joined(k - 2) => {
                (4.0 * (rate[k] - rate[k - 1]) - (rate[k] - rate[k - 2])) / (2.0 * dt_s)
            }
            (true, false) => (rate[k] - rate[k - 1]) / dt_s,
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
