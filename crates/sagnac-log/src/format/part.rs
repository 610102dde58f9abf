//! Parts of one file, read at the same time, each from its own place.

use std::io::{Cursor, Read, Seek, SeekFrom};
use std::sync::{Arc, Mutex};

use crate::input::InputBytes;
use crate::{Error, ReadSeek};

/// A file that several parts read.
#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<Box<dyn ReadSeek>>>);

impl Shared {
    pub(crate) fn new(file: Box<dyn ReadSeek>) -> Self {
        Self(Arc::new(Mutex::new(file)))
    }

    /// The bytes from `at` on, `length` of them at most.
    pub(crate) fn part(&self, at: u64, length: u64) -> Part {
        Part {
            file: self.clone(),
            at,
            end: at.saturating_add(length),
        }
    }

    /// Everything from `at` on.
    pub(crate) fn from(&self, at: u64) -> Part {
        self.part(at, u64::MAX)
    }

    /// Length of the file.
    pub(crate) fn length(&self) -> std::io::Result<u64> {
        self.locked(|file| file.seek(SeekFrom::End(0)))
    }

    fn locked<T>(
        &self,
        act: impl FnOnce(&mut Box<dyn ReadSeek>) -> std::io::Result<T>,
    ) -> std::io::Result<T> {
        match self.0.lock() {
            Ok(mut file) => act(&mut file),
            Err(_) => Err(std::io::Error::other("the file is in use")),
        }
    }
}

/// Some bytes of a file.
pub(crate) struct Part {
    file: Shared,
    at: u64,
    end: u64,
}

impl Read for Part {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let left = usize::try_from(self.end.saturating_sub(self.at)).unwrap_or(usize::MAX);
        let n = buffer.len().min(left);
        if n == 0 {
            return Ok(0);
        }
        let at = self.at;
        let got = self.file.locked(|file| {
            file.seek(SeekFrom::Start(at))?;
            file.read(&mut buffer[..n])
        })?;
        self.at += got as u64;
        Ok(got)
    }
}

/// A source twice: its first bytes to look at, the whole to read; and whether the first bytes are all.
pub(super) struct Peeked {
    pub(super) look: Box<dyn Read + Send>,
    pub(super) reader: Box<dyn Read + Send>,
    pub(super) is_whole: bool,
}

/// Takes up to `most` bytes to look at, of a file without copying them.
pub(super) fn peek(bytes: InputBytes, most: u64) -> Result<Peeked, Error> {
    match bytes {
        InputBytes::Stream(mut reader) => {
            let mut head = Vec::new();
            reader
                .by_ref()
                .take(most)
                .read_to_end(&mut head)
                .map_err(Error::read)?;
            Ok(Peeked {
                is_whole: (head.len() as u64) < most,
                look: Box::new(Cursor::new(head.clone())),
                reader: Box::new(Cursor::new(head).chain(reader)),
            })
        }
        InputBytes::File(file) => {
            let file = Shared::new(file);
            Ok(Peeked {
                is_whole: file.length().map_err(Error::read)? <= most,
                look: Box::new(file.part(0, most)),
                reader: Box::new(file.from(0)),
            })
        }
    }
}
