//! The first bytes of a source, by which its format is known, and decompression.

use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};

use crate::live::fill;
use crate::source::ReadSeek;
use crate::{Error, Source, SourceBytes};

/// Bytes by which formats are told apart.
const HEAD: usize = 4096;

/// A source whose first bytes were looked at.
pub(crate) struct Input {
    pub(crate) head: Vec<u8>,
    pub(crate) bytes: InputBytes,
    /// What was taken off: ", gzip".
    pub(crate) packed: &'static str,
}

pub(crate) enum InputBytes {
    /// Can be read once, from the beginning.
    Stream(Box<dyn Read + Send>),
    /// Stands at its beginning.
    File(Box<dyn ReadSeek>),
}

impl InputBytes {
    pub(crate) fn into_stream(self) -> Box<dyn Read + Send> {
        match self {
            Self::Stream(r) => r,
            Self::File(r) => Box::new(r),
        }
    }
}

impl Input {
    /// Looks at the first bytes and takes gzip or zstd off.
    pub(crate) fn open(source: Source, is_live: bool) -> Result<Self, Error> {
        let input = match source.bytes {
            SourceBytes::Stream(mut reader) => {
                let head = head_of(&mut reader, is_live)?;
                let bytes = InputBytes::Stream(Box::new(Cursor::new(head.clone()).chain(reader)));
                Self {
                    head,
                    bytes,
                    packed: "",
                }
            }
            SourceBytes::File(mut reader) => {
                let head = head_of(&mut reader, is_live)?;
                reader.seek(SeekFrom::Start(0)).map_err(Error::read)?;
                Self {
                    head,
                    bytes: InputBytes::File(reader),
                    packed: "",
                }
            }
            SourceBytes::Folder(_) => return Err(Error::data("the log is a folder, not a file")),
        };
        input.unpack(is_live)
    }

    fn unpack(self, is_live: bool) -> Result<Self, Error> {
        if self.head.starts_with(&[0x1F, 0x8B]) {
            let inner = flate2::read::MultiGzDecoder::new(BufReader::with_capacity(
                1 << 16,
                self.bytes.into_stream(),
            ));
            return Self::packed(
                Box::new(Unpacked {
                    inner,
                    kind: "gzip",
                }),
                ", gzip",
                is_live,
            );
        }
        if self.head.starts_with(&[0x28, 0xB5, 0x2F, 0xFD]) {
            let mut inner = zstd::Decoder::new(self.bytes.into_stream()).map_err(Error::read)?;
            // 128 MiB: what the format's own tool allows without being told otherwise.
            inner.window_log_max(27).map_err(Error::read)?;
            return Self::packed(
                Box::new(Unpacked {
                    inner,
                    kind: "zstd",
                }),
                ", zstd",
                is_live,
            );
        }
        Ok(self)
    }

    fn packed(
        mut reader: Box<dyn Read + Send>,
        packed: &'static str,
        is_live: bool,
    ) -> Result<Self, Error> {
        let head = head_of(&mut reader, is_live)?;
        let bytes = InputBytes::Stream(Box::new(Cursor::new(head.clone()).chain(reader)));
        Ok(Self {
            head,
            bytes,
            packed,
        })
    }
}

fn head_of(reader: &mut dyn Read, is_live: bool) -> Result<Vec<u8>, Error> {
    let mut head = Vec::with_capacity(HEAD);
    fill(reader, &mut head, HEAD, is_live).map_err(Error::read)?;
    Ok(head)
}

/// A decompressor whose errors say so.
struct Unpacked<R> {
    inner: R,
    kind: &'static str,
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.inner.read(buffer).map_err(|e| {
            let text = match e.kind() {
                std::io::ErrorKind::UnexpectedEof => format!("the {} stream is cut off", self.kind),
                std::io::ErrorKind::InvalidInput
                | std::io::ErrorKind::InvalidData
                | std::io::ErrorKind::Other => {
                    format!("the {} stream is damaged", self.kind)
                }
                _ => return e,
            };
            std::io::Error::new(std::io::ErrorKind::InvalidData, text)
        })
    }
}

/// Length of a file from here to its end; the position is kept.
pub(crate) fn remaining(file: &mut dyn ReadSeek) -> std::io::Result<u64> {
    let here = file.stream_position()?;
    let end = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(here))?;
    Ok(end.saturating_sub(here))
}
