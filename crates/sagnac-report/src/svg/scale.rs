//! Scales: numbers to positions, at most seven ticks, labels of decades.

use crate::text::general;

/// A linear or logarithmic scale from numbers to units of a drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    log: bool,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
    plain: bool,
}

impl Scale {
    /// A linear scale over `[low, high]`; an empty or broken range is widened to something drawable.
    pub fn linear(low: f64, high: f64) -> Self {
        let (mut low, mut high) = (finite(low), finite(high));
        if high < low {
            (low, high) = (high, low);
        }
        if high - low <= 1e-12 * low.abs().max(high.abs()) {
            let room = if low == 0.0 { 1.0 } else { 0.5 * low.abs() };
            low -= room;
            high += room;
        }
        Self {
            log: false,
            low,
            high,
            from: 0.0,
            to: 1.0,
            plain: false,
        }
    }

    /// A logarithmic scale over `[low, high]`, both positive; else one decade around 1 is taken.
    pub fn log(low: f64, high: f64) -> Self {
        let ok = |x: f64| x.is_finite() && x > 1e-290 && x < 1e290;
        let (low, high) = match (ok(low), ok(high)) {
            (true, true) if low < high => (low, high),
            (true, true) if high < low => (high, low),
            (true, _) => (low / 3.0, low * 3.0),
            (_, true) => (high / 3.0, high * 3.0),
            _ => (0.3, 3.0),
        };
        Self {
            log: true,
            low,
            high,
            from: 0.0,
            to: 1.0,
            plain: false,
        }
    }

    /// The same scale whose tick labels are plain numbers (`10 000`, not `10⁴`).
    #[must_use]
    pub fn plain(mut self) -> Self {
        self.plain = true;
        self
    }

    /// A scale around all finite (for `log`: positive) values, with a margin of `margin` of its length.
    pub fn around(values: impl IntoIterator<Item = f64>, log: bool, margin: f64) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for v in values {
            if v.is_finite() && (!log || v > 0.0) {
                low = low.min(v);
                high = high.max(v);
            }
        }
        if log {
            let scale = Self::log(low, high);
            let room = (scale.high / scale.low).powf(margin);
            Self::log(scale.low / room, scale.high * room)
        } else {
            let scale = Self::linear(low, high);
            let room = margin * (scale.high - scale.low);
            Self::linear(scale.low - room, scale.high + room)
        }
    }

    /// The same scale widened to at least `decades` decades (log only), downwards and upwards alike.
    #[must_use]
    pub fn at_least_decades(mut self, decades: f64) -> Self {
        if self.log {
            let have = (self.high / self.low).log10();
            if have < decades {
                let room = 10f64.powf(0.5 * (decades - have));
                self.low /= room;
                self.high *= room;
            }
        }
        self
    }

    /// The same scale drawn from one position to another.
    #[must_use]
    pub(crate) fn onto(mut self, from: f64, to: f64) -> Self {
        self.from = from;
        self.to = to;
        self
    }

    /// Whether it is logarithmic.
    pub fn is_log(self) -> bool {
        self.log
    }

    /// Lower end.
    pub fn low(self) -> f64 {
        self.low
    }

    /// Upper end.
    pub fn high(self) -> f64 {
        self.high
    }

    /// Position of a number; what has none (zero on a log scale) lies far below the lower end.
    pub fn at(self, value: f64) -> f64 {
        let share = if self.log {
            if value > 0.0 {
                (value / self.low).ln() / (self.high / self.low).ln()
            } else {
                -10.0
            }
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.from + share.clamp(-10.0, 11.0) * (self.to - self.from)
    }

    /// Whether a number lies on the scale, with a little room for rounding.
    pub fn holds(self, value: f64) -> bool {
        if self.log {
            value >= self.low * (1.0 - 1e-9) && value <= self.high * (1.0 + 1e-9)
        } else {
            let room = 1e-9 * (self.high - self.low);
            value >= self.low - room && value <= self.high + room
        }
    }

    /// Ticks with their labels, at most `most` (seven by the rules of the look).
    pub fn ticks(self, most: usize) -> Vec<(f64, String)> {
        let most = most.clamp(2, 7);
        if self.log {
            self.log_ticks(most)
        } else {
            self.linear_ticks(most)
        }
    }

    fn linear_ticks(self, most: usize) -> Vec<(f64, String)> {
        let length = self.high - self.low;
        let raw = length / most as f64;
        let exponent = raw.log10().floor() as i32;
        for e in [exponent, exponent + 1, exponent + 2] {
            for m in [1.0, 2.0, 2.5, 5.0] {
                let step = m * 10f64.powi(e);
                let first = (self.low / step - 1e-9).ceil();
                let last = (self.high / step + 1e-9).floor();
                let count = last - first + 1.0;
                if count <= most as f64 && count >= 1.0 {
                    let decimals = usize::try_from(-(e - i32::from(m == 2.5))).unwrap_or(0);
                    return (0..count as usize)
                        .map(|i| {
                            let value = (first + i as f64) * step;
                            (value, linear_label(value, decimals))
                        })
                        .collect();
                }
            }
        }
        Vec::new()
    }

    fn log_ticks(self, most: usize) -> Vec<(f64, String)> {
        let first = (self.low.log10() - 1e-9).ceil() as i32;
        let last = (self.high.log10() + 1e-9).floor() as i32;
        let count = last - first + 1;
        if count >= 2 {
            let stride = (count as usize).div_ceil(most) as i32;
            // Ticks at multiples of the stride, so that 1 is one of them.
            return (first..=last)
                .filter(|e| e.rem_euclid(stride) == 0)
                .map(|e| {
                    let value = 10f64.powi(e);
                    let label = if self.plain {
                        page_number(&general(value, 3))
                    } else {
                        decade_label(e)
                    };
                    (value, label)
                })
                .collect();
        }
        // Less than a decade of decades: 1, 2, 5.
        let mut ticks = Vec::new();
        for e in first - 1..=last {
            for m in [1.0, 2.0, 5.0] {
                let value = m * 10f64.powi(e);
                if self.holds(value) {
                    ticks.push((value, page_number(&general(value, 3))));
                }
            }
        }
        if ticks.len() < 2 {
            let inner = Self { log: false, ..self };
            return inner.linear_ticks(most.min(4));
        }
        ticks
    }
}

fn finite(x: f64) -> f64 {
    if x.is_finite() {
        x.clamp(-1e290, 1e290)
    } else {
        0.0
    }
}

fn linear_label(value: f64, decimals: usize) -> String {
    if decimals > 5 || value.abs() >= 1e7 {
        return page_number(&general(value, 4));
    }
    let text = crate::text::fixed(value, decimals);
    page_number(if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    })
}

/// Label of a power of ten: `10⁻²`, `1`, `10`, `10³`.
///
/// ```
/// use sagnac_report::svg::decade_label;
/// assert_eq!(decade_label(-2), "10⁻²");
/// assert_eq!(decade_label(0), "1");
/// ```
pub fn decade_label(exponent: i32) -> String {
    match exponent {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        e => format!("10{}", superscript(e)),
    }
}

fn superscript(n: i32) -> String {
    n.to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '0' => '⁰',
            c => char::from_u32(0x2070 + (c as u32 - '0' as u32)).unwrap_or(c),
        })
        .collect()
}

/// A number of the terminal as pages show it: `-` becomes `−`, `1.5e-9` becomes `1.5·10⁻⁹`, thousands are
/// parted by a narrow no-break space.
///
/// ```
/// assert_eq!(sagnac_report::svg::page_number("-1.5e-9"), "−1.5·10⁻⁹");
/// ```
pub fn page_number(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars().peekable();
    let mut after_digit = false;
    while let Some(c) = chars.next() {
        match c {
            '-' if chars.peek().is_some_and(char::is_ascii_digit) && !after_digit => out.push('−'),
            'e' if after_digit
                && chars
                    .peek()
                    .is_some_and(|n| *n == '-' || n.is_ascii_digit()) =>
            {
                let mut exponent = String::new();
                while let Some(n) = chars.next_if(|n| *n == '-' || n.is_ascii_digit()) {
                    exponent.push(n);
                }
                out.push_str("·10");
                out.push_str(&superscript(exponent.parse().unwrap_or(0)));
            }
            ' ' if after_digit && chars.peek().is_some_and(char::is_ascii_digit) => {
                out.push('\u{202f}');
            }
            c => out.push(c),
        }
        after_digit = c.is_ascii_digit();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn never_more_than_seven_ticks() {
        for (low, high) in [
            (0.0, 1.0),
            (-1.3, 1.7),
            (0.0, 166.7),
            (1e-9, 3e-9),
            (-5e6, 7e6),
            (999.0, 1001.0),
        ] {
            let n = Scale::linear(low, high).ticks(7).len();
            assert!((2..=7).contains(&n), "{low} {high}: {n}");
        }
        for (low, high) in [
            (1e-3, 1e3),
            (0.9, 2.1),
            (1e-12, 1e12),
            (3.0, 3.2),
            (1.5, 15.0),
        ] {
            let n = Scale::log(low, high).ticks(7).len();
            assert!((2..=7).contains(&n), "{low} {high}: {n}");
        }
    }

    #[test]
    fn broken_ranges_can_be_drawn() {
        for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
            for scale in [
                Scale::log(bad, bad),
                Scale::linear(bad, bad),
                Scale::around([bad], true, 0.1),
            ] {
                assert!(scale.at(1.0).is_finite());
                assert!(scale.ticks(7).len() <= 7);
            }
        }
    }

    #[test]
    fn positions() {
        let s = Scale::log(0.1, 1000.0).onto(0.0, 400.0);
        assert!((s.at(1.0) - 100.0).abs() < 1e-9);
        let s = Scale::linear(-1.0, 1.0).onto(100.0, 0.0);
        assert!((s.at(0.0) - 50.0).abs() < 1e-9);
        assert!(s.at(f64::NEG_INFINITY).is_finite());
    }

    #[test]
    fn labels_of_ticks() {
        let labels: Vec<String> = Scale::linear(0.0, 166.7)
            .ticks(7)
            .into_iter()
            .map(|t| t.1)
            .collect();
        assert_eq!(labels, ["0", "25", "50", "75", "100", "125", "150"]);
        let labels: Vec<String> = Scale::linear(-1.2, 2.1)
            .ticks(7)
            .into_iter()
            .map(|t| t.1)
            .collect();
        assert_eq!(labels, ["−1", "−0.5", "0", "0.5", "1", "1.5", "2"]);
    }
}
