//! A window over a stream: records are looked at in place, and no length that a file promises is ever allocated.

use std::io::Read;

use crate::Error;

/// Bytes asked of the stream at once; small enough to stay in the second-level cache.
const READ: usize = 1 << 18;
/// The largest record that is looked at as a whole.
pub(crate) const LARGEST: usize = 1 << 22;

/// A stream with a window that grows to the record at hand.
pub(crate) struct Scan {
    reader: Box<dyn Read + Send>,
    buffer: Vec<u8>,
    at: usize,
    end: usize,
    /// Bytes before the window's start.
    before: u64,
    is_done: bool,
}

impl Scan {
    pub(crate) fn new(reader: Box<dyn Read + Send>) -> Self {
        Self {
            reader,
            buffer: vec![0; READ],
            at: 0,
            end: 0,
            before: 0,
            is_done: false,
        }
    }

    /// Bytes consumed so far.
    pub(crate) fn offset(&self) -> u64 {
        self.before + self.at as u64
    }

    /// Everything in the window that was not consumed.
    #[inline]
    pub(crate) fn window(&self) -> &[u8] {
        self.buffer.get(self.at..self.end).unwrap_or(&[])
    }

    /// Makes the window at least `n` bytes long; `false` where the stream ends before, or `n` is beyond [`LARGEST`].
    #[inline]
    pub(crate) fn need(&mut self, n: usize) -> Result<bool, Error> {
        if self.end - self.at >= n {
            return Ok(true);
        }
        self.fill(n)
    }

    #[cold]
    fn fill(&mut self, n: usize) -> Result<bool, Error> {
        if n > LARGEST {
            return Ok(false);
        }
        self.grow(n)
    }

    /// As [`Scan::need`], beyond [`LARGEST`] as well: the window grows as bytes arrive, not by what was promised.
    pub(crate) fn hold(&mut self, n: usize) -> Result<bool, Error> {
        if self.end - self.at >= n {
            return Ok(true);
        }
        self.grow(n)
    }

    fn grow(&mut self, n: usize) -> Result<bool, Error> {
        self.buffer.copy_within(self.at..self.end, 0);
        self.before += self.at as u64;
        self.end -= self.at;
        self.at = 0;
        while self.end < n && !self.is_done {
            let wanted = n + READ;
            if self.buffer.len() < n + READ / 2 && self.buffer.len() - self.end < READ {
                self.buffer.resize(wanted.min(2 * self.buffer.len()), 0);
            }
            match self.reader.read(&mut self.buffer[self.end..]) {
                Ok(0) => self.is_done = true,
                Ok(k) => self.end += k,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(Error::read(e)),
            }
        }
        Ok(self.end >= n)
    }

    /// Consumes bytes of the window.
    #[inline]
    pub(crate) fn consume(&mut self, n: usize) {
        self.at = (self.at + n).min(self.end);
    }

    /// Consumes `n` bytes, however many; returns how many there were.
    pub(crate) fn skip(&mut self, n: u64) -> Result<u64, Error> {
        let mut left = n;
        loop {
            let have = (self.end - self.at) as u64;
            if left <= have {
                self.at += left as usize;
                return Ok(n);
            }
            left -= have;
            self.at = self.end;
            if !self.need(1)? {
                return Ok(n - left);
            }
        }
    }

    /// Takes up to `n` bytes out, no more than the stream has.
    pub(crate) fn take(&mut self, n: u64) -> Result<Vec<u8>, Error> {
        let mut out = Vec::new();
        while (out.len() as u64) < n && self.need(1)? {
            let left = n - out.len() as u64;
            let have = self
                .window()
                .len()
                .min(usize::try_from(left).unwrap_or(usize::MAX));
            out.extend_from_slice(&self.window()[..have]);
            self.consume(have);
        }
        Ok(out)
    }
}

/// Little-endian numbers at an offset, where there are enough bytes.
pub(crate) fn u16_at(b: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(
        b.get(at..at.checked_add(2)?)?.try_into().ok()?,
    ))
}
/// As [`u16_at`].
pub(crate) fn u32_at(b: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(
        b.get(at..at.checked_add(4)?)?.try_into().ok()?,
    ))
}
/// As [`u16_at`].
pub(crate) fn u64_at(b: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(
        b.get(at..at.checked_add(8)?)?.try_into().ok()?,
    ))
}
/// As [`u16_at`].
pub(crate) fn f32_at(b: &[u8], at: usize) -> Option<f64> {
    u32_at(b, at).map(|v| f64::from(f32::from_bits(v)))
}
