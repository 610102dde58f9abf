//! `--axes 'x=-y, y=x, z=z'`: remounting, a signed permutation of the axes of every triad.

use super::columns::{AXES, clip};
use crate::Error;

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

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
