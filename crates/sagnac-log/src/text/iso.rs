//! Dates as ISO 8601 writes them, to nanoseconds since 1970-01-01 UTC.
//!
//! Days of the civil calendar by the era formula (400 years are 146097 days). Without a zone the date is read as UTC.

/// `YYYY-MM-DD`, then `T` or spaces, `hh:mm`, seconds with decimals, zone: the last parts optional.
pub(crate) fn parse(text: &[u8]) -> Option<i64> {
    let text = text.trim_ascii();
    let mut p = Cursor { text, at: 0 };
    let year = p.number(4)?;
    p.expect(b'-')?;
    let month = p.number(2)?;
    p.expect(b'-')?;
    let day = p.number(2)?;
    if !(1..=12).contains(&month) || day < 1 || day > days_of(year, month) {
        return None;
    }
    let mut ns: i64 = 0;
    let mut seconds = days_since_1970(year, month, day) * 86_400;
    if !p.is_done() {
        if p.expect(b'T').or_else(|| p.expect(b't')).is_none() {
            p.expect(b' ')?;
            while p.expect(b' ').is_some() {}
        }
        let hour = p.number(2)?;
        p.expect(b':')?;
        let minute = p.number(2)?;
        let mut second = 0;
        if p.expect(b':').is_some() {
            second = p.number(2)?;
            if p.expect(b'.').is_some() {
                ns = p.decimals()?;
            }
        }
        if hour > 24 || minute > 59 || second > 60 {
            return None;
        }
        seconds += hour * 3600 + minute * 60 + second;
        while p.expect(b' ').is_some() {}
        if let Some(sign) = p.zone_sign() {
            let h = p.number(2)?;
            let _ = p.expect(b':');
            let m = if p.is_done() { 0 } else { p.number(2)? };
            if h > 23 || m > 59 {
                return None;
            }
            seconds -= sign * (h * 3600 + m * 60);
        } else if p.expect(b'Z').is_none() {
            let _ = p.expect(b'z');
        }
    }
    p.is_done().then_some(())?;
    seconds.checked_mul(1_000_000_000)?.checked_add(ns)
}

fn days_of(year: i64, month: i64) -> i64 {
    match month {
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    // Years that begin in March put the leap day last.
    let y = if month <= 2 { year - 1 } else { year };
    let era = y.div_euclid(400);
    let year_of_era = y.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

struct Cursor<'a> {
    text: &'a [u8],
    at: usize,
}

impl Cursor<'_> {
    fn is_done(&self) -> bool {
        self.at == self.text.len()
    }

    fn expect(&mut self, byte: u8) -> Option<()> {
        (self.text.get(self.at) == Some(&byte)).then(|| self.at += 1)
    }

    fn number(&mut self, digits: usize) -> Option<i64> {
        let part = self.text.get(self.at..self.at + digits)?;
        let mut v = 0;
        for &c in part {
            v = v * 10 + i64::from(c.is_ascii_digit().then(|| c - b'0')?);
        }
        self.at += digits;
        Some(v)
    }

    /// Decimals of a second as nanoseconds; further digits are cut.
    fn decimals(&mut self) -> Option<i64> {
        let (mut v, mut n) = (0_i64, 0);
        while let Some(d) = self.text.get(self.at).filter(|c| c.is_ascii_digit()) {
            if n < 9 {
                v = v * 10 + i64::from(d - b'0');
            }
            n += 1;
            self.at += 1;
        }
        (n > 0).then_some(())?;
        for _ in n..9 {
            v *= 10;
        }
        Some(v)
    }

    fn zone_sign(&mut self) -> Option<i64> {
        let sign = match self.text.get(self.at)? {
            b'+' => 1,
            b'-' => -1,
            _ => return None,
        };
        self.at += 1;
        Some(sign)
    }
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn dates_become_nanoseconds() {
        // date -u -d '2025-06-14 21:17:02' +%s
        assert_eq!(
            parse(b"2025-06-14 21:17:02+00:00"),
            Some(1_749_935_822_000_000_000)
        );
        assert_eq!(
            parse(b"2025-06-14T23:17:02.000000001+02:00"),
            Some(1_749_935_822_000_000_001)
        );
        assert_eq!(
            parse(b"2025-06-14T21:17:02.5Z"),
            Some(1_749_935_822_500_000_000)
        );
        assert_eq!(parse(b"1970-01-01"), Some(0));
        assert_eq!(parse(b"1969-12-31T23:59:59"), Some(-1_000_000_000));
        assert_eq!(parse(b"2000-02-29T00:00"), Some(951_782_400_000_000_000));
        for bad in [
            "2025-02-29",
            "2025-13-01",
            "14.06.2025",
            "2025-06-14 25:00",
            "2025-06-14x",
            "",
            "12",
        ] {
            assert_eq!(parse(bad.as_bytes()), None, "{bad}");
        }
    }
}
