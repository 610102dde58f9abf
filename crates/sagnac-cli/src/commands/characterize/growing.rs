//! A file that another program writes: waited on at its end, as `tail -F` does, cut, replaced or removed as it may be.

use std::fs::{File, Metadata};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use sagnac::Error;
use sagnac::log::Source;

use crate::outputs::INTERRUPTED;

/// How often a file that does not grow is looked at.
const WAIT: Duration = Duration::from_millis(50);
/// Bytes before the end of what was read that have to stand there still when it grows.
const KEPT: usize = 64;

/// A file by its name.
pub(super) struct Growing {
    path: PathBuf,
    /// Why it begins anew, once it does.
    anew: Arc<Mutex<Option<&'static str>>>,
}

impl Growing {
    /// The file, which must be there.
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        File::open(path).map_err(|e| {
            Error::data(format!(
                "{} cannot be read: {}",
                path.display(),
                crate::context::plain(&e)
            ))
        })?;
        Ok(Self {
            path: path.to_owned(),
            anew: Arc::default(),
        })
    }

    /// The file from its start; what is to be told goes through `say`.
    pub(super) fn source(&self, say: impl Fn(&'static str) + Send + 'static) -> Source {
        let tail = Tail {
            path: self.path.clone(),
            file: None,
            at: 0,
            before: Vec::new(),
            is_text: None,
            is_gone: false,
            anew: self.anew.clone(),
            say: Box::new(say),
        };
        Source::stream(self.path.display().to_string(), tail)
    }

    /// Why the file begins anew, if it does.
    pub(super) fn begins_anew(&self) -> Option<&'static str> {
        self.anew.lock().map_or(None, |why| *why)
    }

    /// The same, to be asked once.
    pub(super) fn take_anew(&self) -> Option<&'static str> {
        self.anew.lock().map_or(None, |mut why| why.take())
    }
}

/// Waits at the end of a file for more of it; an interrupt is its end, in a text an early one: its last line is not whole.
struct Tail {
    path: PathBuf,
    file: Option<File>,
    /// Bytes read.
    at: u64,
    /// The last of them.
    before: Vec<u8>,
    is_text: Option<bool>,
    is_gone: bool,
    anew: Arc<Mutex<Option<&'static str>>>,
    say: Box<dyn Fn(&'static str) + Send>,
}

impl Tail {
    /// The end of what is read; of a text an early one.
    fn end(&self, why: &str) -> io::Result<usize> {
        match self.is_text {
            Some(true) => Err(io::Error::other(why.to_owned())),
            _ => Ok(0),
        }
    }

    /// Whether the file is no longer the one that was read, and why.
    fn is_another(&mut self, file: &mut File) -> io::Result<Option<&'static str>> {
        let own = file.metadata()?;
        if own.len() < self.at {
            return Ok(Some("was truncated"));
        }
        if own.len() > self.at && !self.is_kept(file)? {
            return Ok(Some("was written anew"));
        }
        match std::fs::metadata(&self.path) {
            Ok(named) if !is_same(&own, &named) => return Ok(Some("was replaced")),
            Ok(_) => self.is_gone = false,
            Err(_) if !self.is_gone => {
                self.is_gone = true;
                (self.say)("was removed; waiting for it to come back");
            }
            Err(_) => {}
        }
        Ok(None)
    }

    /// Whether the bytes before the end of what was read stand there still; leaves the file at that end.
    fn is_kept(&self, file: &mut File) -> io::Result<bool> {
        let mut now = vec![0; self.before.len()];
        file.seek(SeekFrom::Start(self.at - now.len() as u64))?;
        file.read_exact(&mut now)?;
        Ok(now == self.before)
    }

    fn keep(&mut self, new: &[u8]) {
        self.at += new.len() as u64;
        self.before
            .extend_from_slice(&new[new.len().saturating_sub(KEPT)..]);
        let more = self.before.len().saturating_sub(KEPT);
        self.before.drain(..more);
    }
}

impl Read for Tail {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        let mut file = match self.file.take() {
            Some(file) => file,
            None => File::open(&self.path)?,
        };
        let mut has_waited = false;
        loop {
            if INTERRUPTED.load(Ordering::SeqCst) {
                return self.end("interrupted");
            }
            if has_waited && let Some(why) = self.is_another(&mut file)? {
                if let Ok(mut anew) = self.anew.lock() {
                    *anew = Some(why);
                }
                return self.end(why);
            }
            let n = file.read(buffer)?;
            if n > 0 {
                let is_byte_of_text = |c: &u8| *c > 31 || (9..14).contains(c);
                self.is_text
                    .get_or_insert_with(|| buffer[..n].iter().all(is_byte_of_text));
                self.keep(&buffer[..n]);
                self.file = Some(file);
                return Ok(n);
            }
            std::thread::sleep(WAIT);
            has_waited = true;
        }
    }
}

/// Whether two names lead to one file.
#[cfg(unix)]
fn is_same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// Where files have no numbers a replaced one is told by its length and its bytes alone.
#[cfg(not(unix))]
fn is_same(_: &Metadata, _: &Metadata) -> bool {
    true
}
