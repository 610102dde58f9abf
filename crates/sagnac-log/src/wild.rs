//! Single stamps that are wrong: a value far from those of its neighbors, in a clock that otherwise goes on.

use crate::Stamps;
use crate::clock::usual;

/// Rows in a row that may be wrong; more of them are a clock that was set.
const MOST_IN_A_ROW: usize = 8;
/// Intervals by which a stamp has to be off.
const FAR: f64 = 5.0;

/// Rows whose stamp is wrong, ascending; `steps` are those between the stamps.
pub(crate) fn rows(stamps: &Stamps, steps: &[f64]) -> Vec<usize> {
    let Some(dt) = usual(steps).filter(|_| steps.len() > 10) else {
        return Vec::new();
    };
    let far = FAR * dt;
    if steps.iter().all(|s| s.abs() <= far) {
        return Vec::new();
    }
    let mut out = Vec::new();
    let last = steps.len();
    let between = |from: usize, to: usize| match (stamps.get(from), stamps.get(to)) {
        (Some(a), Some(b)) => b.since(a),
        _ => f64::NAN,
    };
    // At an end there is a neighbor on one side alone: such a gap would be a hundred times as long as the log.
    let is_out = |step: f64, rest: f64| step < -far || step > (100.0 * rest.abs()).max(far);
    if is_out(steps[0], between(1, last)) && steps[1].abs() <= far {
        out.push(0);
    }
    let mut k = 1;
    while k < last {
        let step = steps[k - 1];
        if out.last() == Some(&(k - 1)) || !(step.is_finite() && (step < -far || step > far)) {
            k += 1;
            continue;
        }
        let back = (k + 1..=last.min(k + MOST_IN_A_ROW)).find(|&j| {
            let span = between(k - 1, j);
            // Time goes back on the way there or on the way back.
            steps[if step < 0.0 { k - 1 } else { j - 1 }] < 0.0
                && (0.0..=((j - k) as f64 + 4.0) * dt).contains(&span)
        });
        match back {
            Some(j) => {
                out.extend(k..j);
                k = j + 1;
            }
            None => k += 1,
        }
    }
    if is_out(steps[last - 1], between(0, last - 1))
        && steps[last - 2].abs() <= far
        && out.last() != Some(&(last - 1))
    {
        out.push(last);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::steps;

    fn of(change: impl Fn(&mut Vec<f64>)) -> Vec<usize> {
        let mut t: Vec<f64> = (0..1000).map(|k| f64::from(k) / 100.0).collect();
        change(&mut t);
        let stamps = Stamps::Seconds(t);
        rows(&stamps, &steps(&stamps))
    }

    #[test]
    fn a_wrong_stamp_is_found_wherever_it_stands() {
        for value in [1e9, -5.0, 0.0, 1e300, -1e300] {
            assert_eq!(of(|t| t[500] = value), [500], "{value}");
        }
        assert_eq!(of(|t| t[0] = 1e9), [0]);
        assert_eq!(of(|t| t[0] = -1e9), [0]);
        assert_eq!(of(|t| t[999] = 1e9), [999]);
        assert_eq!(of(|t| t[999] = -1e9), [999]);
        assert_eq!(of(|t| t[500..503].fill(7e9)), [500, 501, 502]);
    }

    #[test]
    fn gaps_and_clocks_that_are_set_are_no_wrong_stamps() {
        let none: [usize; 0] = [];
        assert_eq!(of(|_| ()), none);
        assert_eq!(of(|t| t[500..].iter_mut().for_each(|t| *t += 40.0)), none);
        assert_eq!(of(|t| t[500..].iter_mut().for_each(|t| *t -= 3.0)), none);
        assert_eq!(of(|t| t[500] = t[499]), none);
        assert_eq!(of(|t| t[500] = f64::INFINITY), none);
    }
}
