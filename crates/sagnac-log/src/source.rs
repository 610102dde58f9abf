//! Where a log comes from: bytes with a label. Opening files by name is the shell's business.

use std::io::{Cursor, Read, Seek};

/// A reader that can seek and move to another thread.
pub trait ReadSeek: Read + Seek + Send {}
impl<T: Read + Seek + Send> ReadSeek for T {}

/// A folder of files, for formats that are folders (KITTI oxts, ROS 2 recordings).
pub trait Folder: Send {
    /// Names of the files below, with `/` between parts, sorted.
    ///
    /// # Errors
    /// What the operating system says.
    fn names(&self) -> std::io::Result<Vec<String>>;
    /// Opens one of them.
    ///
    /// # Errors
    /// What the operating system says.
    fn open(&self, name: &str) -> std::io::Result<Box<dyn ReadSeek>>;
}

/// The bytes of a log and the label that errors name it by.
pub struct Source {
    /// What the user called it: a file's name, "standard input".
    pub label: String,
    /// The bytes.
    pub bytes: SourceBytes,
}

/// The ways in which bytes come.
pub enum SourceBytes {
    /// A pipe: read once.
    Stream(Box<dyn Read + Send>),
    /// A file.
    File(Box<dyn ReadSeek>),
    /// A folder.
    Folder(Box<dyn Folder>),
}

impl Source {
    /// A pipe.
    pub fn stream(label: impl Into<String>, reader: impl Read + Send + 'static) -> Self {
        Self {
            label: label.into(),
            bytes: SourceBytes::Stream(Box::new(reader)),
        }
    }

    /// A file.
    pub fn file(label: impl Into<String>, reader: impl Read + Seek + Send + 'static) -> Self {
        Self {
            label: label.into(),
            bytes: SourceBytes::File(Box::new(reader)),
        }
    }

    /// A folder.
    pub fn folder(label: impl Into<String>, folder: impl Folder + 'static) -> Self {
        Self {
            label: label.into(),
            bytes: SourceBytes::Folder(Box::new(folder)),
        }
    }

    /// Bytes in memory.
    pub fn memory(label: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self::file(label, Cursor::new(bytes))
    }
}
