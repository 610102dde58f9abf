//! Time stamps that lose nothing: whole nanoseconds where the source has them, `f64` seconds otherwise.

/// A column of time stamps.
///
/// Decimal stamps of at most nine decimals are kept as whole nanoseconds; anything finer (a period of 1/3 s written
/// with sixteen digits) is kept as the `f64` that it reads as. Both print back to what was read.
#[derive(Debug, Clone, PartialEq)]
pub enum Stamps {
    /// Whole nanoseconds since the source's own zero (1970 for dates).
    Nanoseconds(Vec<i64>),
    /// Seconds since the source's own zero.
    Seconds(Vec<f64>),
}

impl Default for Stamps {
    fn default() -> Self {
        Self::Nanoseconds(Vec::new())
    }
}

/// One time stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stamp {
    /// Whole nanoseconds.
    Nanoseconds(i64),
    /// Seconds.
    Seconds(f64),
}

impl Stamp {
    /// The stamp of row `k`, counted from 1, of a log without time: its interval of 1/rate ends k/rate after the start.
    ///
    /// ```
    /// use sagnac_log::Stamp;
    /// assert_eq!(Stamp::of_row(1, 100.0), Stamp::Nanoseconds(10_000_000));
    /// assert_eq!(Stamp::of_row(2, 3.0), Stamp::Seconds(2.0 / 3.0));
    /// ```
    pub fn of_row(k: u64, rate_hz: f64) -> Self {
        let period_ns = 1e9 / rate_hz;
        if period_ns.fract() == 0.0 && period_ns < 1e12 {
            Self::Nanoseconds((k as i64).saturating_mul(period_ns as i64))
        } else {
            Self::Seconds(k as f64 / rate_hz)
        }
    }

    /// The stamp in seconds, rounded to the nearest `f64` (an ulp is 0.24 µs for dates of today).
    pub fn seconds(self) -> f64 {
        match self {
            Self::Nanoseconds(ns) => ns_to_s(ns),
            Self::Seconds(s) => s,
        }
    }

    /// Seconds from `origin` to this stamp; exact to half a nanosecond or better where both are nanoseconds.
    pub fn since(self, origin: Self) -> f64 {
        match (self, origin) {
            (Self::Nanoseconds(a), Self::Nanoseconds(b)) => match a.checked_sub(b) {
                Some(d) => ns_to_s(d),
                None => a as f64 * 1e-9 - b as f64 * 1e-9,
            },
            (a, b) => a.seconds() - b.seconds(),
        }
    }
}

/// Nanoseconds to seconds; correctly rounded up to 2^53 ns, else to one ulp.
pub(crate) fn ns_to_s(ns: i64) -> f64 {
    if ns.unsigned_abs() <= 1 << 53 {
        ns as f64 / 1e9
    } else {
        let whole = ns / 1_000_000_000;
        whole as f64 + (ns % 1_000_000_000) as f64 / 1e9
    }
}

impl Stamps {
    /// Number of stamps.
    pub fn len(&self) -> usize {
        match self {
            Self::Nanoseconds(v) => v.len(),
            Self::Seconds(v) => v.len(),
        }
    }

    /// True where there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Stamp `i`, if there is one.
    pub fn get(&self, i: usize) -> Option<Stamp> {
        match self {
            Self::Nanoseconds(v) => v.get(i).map(|&ns| Stamp::Nanoseconds(ns)),
            Self::Seconds(v) => v.get(i).map(|&s| Stamp::Seconds(s)),
        }
    }

    /// Seconds of every stamp since `origin`.
    pub fn since(&self, origin: Stamp) -> Vec<f64> {
        match self {
            Self::Nanoseconds(v) => v
                .iter()
                .map(|&ns| Stamp::Nanoseconds(ns).since(origin))
                .collect(),
            Self::Seconds(v) => v.iter().map(|&s| Stamp::Seconds(s).since(origin)).collect(),
        }
    }

    /// Empties the column, keeping its memory.
    pub fn clear(&mut self) {
        match self {
            Self::Nanoseconds(v) => v.clear(),
            Self::Seconds(v) => v.clear(),
        }
    }

    /// Adds one stamp; a column of nanoseconds turns into seconds when a stamp in seconds comes.
    pub fn push(&mut self, stamp: Stamp) {
        match (&mut *self, stamp) {
            (Self::Nanoseconds(v), Stamp::Nanoseconds(ns)) => v.push(ns),
            (Self::Seconds(v), s) => v.push(s.seconds()),
            (Self::Nanoseconds(v), Stamp::Seconds(s)) if v.is_empty() => {
                *self = Self::Seconds(vec![s]);
            }
            (Self::Nanoseconds(_), Stamp::Seconds(s)) => {
                self.make_seconds();
                self.push(Stamp::Seconds(s));
            }
        }
    }

    /// Adds the stamps of `other`.
    pub fn append(&mut self, other: &Self) {
        if self.is_empty() {
            self.clone_from(other);
            return;
        }
        match (&mut *self, other) {
            (Self::Nanoseconds(a), Self::Nanoseconds(b)) => a.extend_from_slice(b),
            (Self::Seconds(a), Self::Seconds(b)) => a.extend_from_slice(b),
            (Self::Seconds(a), Self::Nanoseconds(b)) => a.extend(b.iter().map(|&ns| ns_to_s(ns))),
            (Self::Nanoseconds(_), Self::Seconds(_)) => {
                self.make_seconds();
                self.append(other);
            }
        }
    }

    /// Keeps stamps `range` alone.
    pub fn keep(&mut self, range: std::ops::Range<usize>) {
        match self {
            Self::Nanoseconds(v) => {
                v.truncate(range.end);
                v.drain(..range.start.min(v.len()));
            }
            Self::Seconds(v) => {
                v.truncate(range.end);
                v.drain(..range.start.min(v.len()));
            }
        }
    }

    fn make_seconds(&mut self) {
        if let Self::Nanoseconds(v) = self {
            *self = Self::Seconds(v.iter().map(|&ns| ns_to_s(ns)).collect());
        }
    }
}
