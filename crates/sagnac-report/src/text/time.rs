//! Times and durations as text: `33:40`, `2:40:00`, `2 h 46 min 40 s`.

use super::number::{fixed, general};

/// A time since the start of a log: `33:40` (min:s), from one hour on `2:40:00` (h:min:s).
///
/// Seconds are rounded; a time that is not finite gives `-`.
///
/// ```
/// assert_eq!(sagnac_report::text::clock(2020.0), "33:40");
/// assert_eq!(sagnac_report::text::clock(9600.0), "2:40:00");
/// ```
pub fn clock(time_s: f64) -> String {
    if !time_s.is_finite() || time_s.abs() > 1e14 {
        return "-".to_owned();
    }
    let sign = if time_s <= -0.5 { "-" } else { "" };
    let total = time_s.abs().round() as u64;
    let (hours, minutes, seconds) = (total / 3600, total / 60 % 60, total % 60);
    if hours > 0 {
        format!("{sign}{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{sign}{minutes}:{seconds:02}")
    }
}

/// A time span: `0:00 - 1:10`; one time where both ends show alike.
///
/// ```
/// assert_eq!(sagnac_report::text::clock_span(0.0, 70.0), "0:00 - 1:10");
/// assert_eq!(sagnac_report::text::clock_span(2020.0, 2020.3), "33:40");
/// ```
pub fn clock_span(start_s: f64, end_s: f64) -> String {
    let (start, end) = (clock(start_s), clock(end_s));
    if start == end {
        start
    } else {
        format!("{start} - {end}")
    }
}

/// A duration in words: `2 h 46 min 40 s`, `10 min`, `0.25 s`, `3 days 2 h`.
///
/// Parts that are zero are left out. Below one minute three digits, below a second in `ms`, `us`.
///
/// ```
/// use sagnac_report::text::duration;
/// assert_eq!(duration(10_000.0), "2 h 46 min 40 s");
/// assert_eq!(duration(7200.0), "2 h");
/// assert_eq!(duration(3.21), "3.21 s");
/// ```
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds.abs() > 1e14 {
        return "-".to_owned();
    }
    if seconds < 0.0 {
        return format!("-{}", duration(-seconds));
    }
    if seconds == 0.0 {
        return "0 s".to_owned();
    }
    if seconds < 1e-3 {
        return format!("{} us", general(seconds * 1e6, 3));
    }
    if seconds < 1.0 {
        return format!("{} ms", general(seconds * 1e3, 3));
    }
    if seconds < 59.95 {
        return format!("{} s", general(seconds, 3));
    }
    let total = seconds.round() as u64;
    let days = total / 86_400;
    let parts = [
        (days, if days == 1 { "day" } else { "days" }),
        (total / 3600 % 24, "h"),
        (total / 60 % 60, "min"),
        (total % 60, "s"),
    ];
    let shown: Vec<String> = parts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, unit)| format!("{count} {unit}"))
        .collect();
    shown.join(" ")
}

/// Seconds with their thousands parted: `10 000 s`.
///
/// ```
/// assert_eq!(sagnac_report::text::seconds(10_000.0), "10 000 s");
/// assert_eq!(sagnac_report::text::seconds(19.995), "20.0 s");
/// ```
pub fn seconds(seconds: f64) -> String {
    let decimals = usize::from(seconds.abs() < 100.0 && seconds.fract() != 0.0);
    format!("{} s", fixed(seconds, decimals))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations() {
        assert_eq!(duration(600.0), "10 min");
        assert_eq!(duration(59.97), "1 min");
        assert_eq!(duration(0.005), "5 ms");
        assert_eq!(duration(90_000.0), "1 day 1 h");
        assert_eq!(duration(f64::NAN), "-");
        assert_eq!(duration(1e-9), "0.001 us");
    }

    #[test]
    fn clocks() {
        assert_eq!(clock(0.0), "0:00");
        assert_eq!(clock(59.6), "1:00");
        assert_eq!(clock(-30.0), "-0:30");
        assert_eq!(clock_span(9600.0, 9640.0), "2:40:00 - 2:40:40");
    }
}
