//! `--axes 'x=-y, y=x, z=z'`: remounting, a signed permutation of the axes of every triad.

use super::columns::{AXES, clip};
use crate::{Channel, Error, Layout, Quantity};

/// New axis k is `sign[k]` times old axis `from[k]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisMap {
    pub(crate) from: [usize; 3],
    pub(crate) sign: [f64; 3],
}

impl AxisMap {
    /// Reads `x=-y, y=x, z=z`; axes left out stay as they are.
    pub(crate) fn parse(text: &str) -> Result<Self, Error> {
        let fail = |what: String| {
            Error::usage(what)
                .at(format!("--axes '{}'", clip(text)))
                .advise("write for instance --axes 'x=-y, y=x, z=z'")
        };
        let axis = |name: &str| AXES.iter().position(|a| *a == name.trim());
        let mut map = Self {
            from: [0, 1, 2],
            sign: [1.0; 3],
        };
        let mut seen = [false; 3];
        for part in text.split(',') {
            let (new, old) = part
                .split_once('=')
                .ok_or_else(|| fail(format!("`{}` is no `axis=axis`", clip(part.trim()))))?;
            let old = old.trim();
            let (sign, name) = match old.strip_prefix('-') {
                Some(name) => (-1.0, name),
                None => (1.0, old.strip_prefix('+').unwrap_or(old)),
            };
            let (Some(k), Some(j)) = (axis(new), axis(name)) else {
                return Err(fail(format!("`{}`: axes are x, y, z", clip(part.trim()))));
            };
            if seen[k] {
                return Err(fail(format!("axis {} is named twice", AXES[k])));
            }
            seen[k] = true;
            map.from[k] = j;
            map.sign[k] = sign;
        }
        let mut sorted = map.from;
        sorted.sort_unstable();
        if sorted != [0, 1, 2] {
            return Err(fail("every old axis has to be used once".to_owned()));
        }
        Ok(map)
    }

    /// True where the map turns a right-handed triad into a left-handed one.
    pub(crate) fn is_mirror(&self) -> bool {
        let [a, b, c] = self.from;
        let even = (a, b, c) == (0, 1, 2) || (a, b, c) == (1, 2, 0) || (a, b, c) == (2, 0, 1);
        let sign: f64 = self.sign.iter().product();
        (sign > 0.0) != even
    }

    /// The map in words: "x = -y, y = x, z = z".
    pub(crate) fn words(&self) -> String {
        let part = |k: usize| {
            format!(
                "{} = {}{}",
                AXES[k],
                if self.sign[k] < 0.0 { "-" } else { "" },
                AXES[self.from[k] % 3]
            )
        };
        format!("{}, {}, {}", part(0), part(1), part(2))
    }
}

/// Applies `--axes` to every triad.
pub(super) fn remount(map: &AxisMap, layout: &mut Layout) -> Result<Vec<(usize, f64)>, Error> {
    let mut mount: Vec<(usize, f64)> = (0..layout.channels.len()).map(|k| (k, 1.0)).collect();
    let mut turned = Vec::new();
    let old = layout.channels.clone();
    for word in ["gyro", "accel", "gyro_rate"] {
        let index: Vec<Option<usize>> = AXES
            .iter()
            .map(|a| layout.index(&format!("{word}_{a}")))
            .collect();
        if index.iter().all(Option::is_none) {
            continue;
        }
        for k in 0..3 {
            match (index[k], index[map.from[k]]) {
                (Some(new), Some(from)) => {
                    mount[new] = (from, map.sign[k]);
                    let name = layout.channels[new].name.clone();
                    layout.channels[new] = Channel {
                        name,
                        ..old[from].clone()
                    };
                }
                (None, None) => {}
                _ => {
                    return Err(Error::data(format!("--axes needs all axes of {word}"))
                        .advise("the log holds only some of them; leave --axes out"));
                }
            }
        }
        turned.push(word);
    }
    if turned.is_empty() {
        return Err(Error::data(
            "--axes has nothing to turn: the log has no triad",
        ));
    }
    let mirror = if map.is_mirror() {
        "; this mirrors the axes (left-handed)"
    } else {
        ""
    };
    if let Some(all) = &mut layout.covariances {
        *all = all.map(|c| turned_covariance(map, &c));
    }
    layout
        .notes
        .push(format!("axes turned: {}{mirror}", map.words()));
    debug_assert!(
        layout
            .channels
            .iter()
            .all(|c| c.quantity == Quantity::of(&c.name))
    );
    Ok(mount)
}

/// A covariance [xx xy xz yx …] in the new axes.
fn turned_covariance(map: &AxisMap, old: &[f64; 9]) -> [f64; 9] {
    std::array::from_fn(|k| {
        let (i, j) = (k / 3, k % 3);
        map.sign[i] * map.sign[j] * old[3 * map.from[i] + map.from[j]]
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn covariances_turn_with_the_axes() {
        let map = AxisMap::parse("x=-y, y=x").unwrap();
        let old = [1.0, 2.0, 3.0, 2.0, 4.0, 5.0, 3.0, 5.0, 6.0];
        // R C Rᵀ with R = [0 −1 0; 1 0 0; 0 0 1].
        let new = [4.0, -2.0, -5.0, -2.0, 1.0, 3.0, -5.0, 3.0, 6.0];
        assert_eq!(turned_covariance(&map, &old), new);
    }

    #[test]
    fn maps_are_read_and_checked() {
        let m = AxisMap::parse("x=-y, y=x, z=z").unwrap();
        assert_eq!((m.from, m.sign), ([1, 0, 2], [-1.0, 1.0, 1.0]));
        assert!(!m.is_mirror());
        assert!(AxisMap::parse("x=-x").unwrap().is_mirror());
        assert!(!AxisMap::parse("x=y,y=z,z=x").unwrap().is_mirror());
        for bad in ["", "x", "x=y", "x=x,x=y", "x=w", "a=x", "x=y,y=y,z=z"] {
            assert!(AxisMap::parse(bad).unwrap_err().is_usage(), "{bad}");
        }
    }
}
