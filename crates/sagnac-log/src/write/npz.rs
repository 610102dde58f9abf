//! A numpy archive of one structured array, `log`, stored: a zip whose sizes and checksum are completed at the end.

use std::io::{Seek, SeekFrom, Write};

use flate2::Crc;

use super::WriteSeek;
use super::npy::Rows;
use crate::{Block, Error, Layout, LogWriter};

const NAME: &[u8] = b"log.npy";
/// 1980-01-01, the first date of the format: the same log gives the same bytes.
const DATE: [u8; 4] = [0, 0, 0x21, 0];

/// Writes `.npz`.
pub(crate) struct NpzWriter {
    output: Box<dyn WriteSeek>,
    rows: Rows,
    sum: Crc,
}

/// What both headers of the entry say: versions, method, date, checksum, sizes in the 64-bit extra field.
fn common(sum: u32) -> Vec<u8> {
    let mut out = vec![45, 0, 0, 0, 0, 0];
    out.extend(DATE);
    out.extend(sum.to_le_bytes());
    out.extend([0xFF; 8]);
    out.extend((NAME.len() as u16).to_le_bytes());
    out
}

fn local(sum: u32, size: u64) -> Vec<u8> {
    let mut out = b"PK\x03\x04".to_vec();
    out.extend(common(sum));
    out.extend(20_u16.to_le_bytes());
    out.extend(NAME);
    out.extend([1, 0, 16, 0]);
    out.extend([size, size].map(u64::to_le_bytes).concat());
    out
}

fn directory(sum: u32, size: u64, at: u64) -> Vec<u8> {
    let mut out = b"PK\x01\x02\x2D\x00".to_vec();
    out.extend(common(sum));
    out.extend(20_u16.to_le_bytes());
    out.extend([0; 2 + 2 + 2 + 4 + 4]);
    out.extend(NAME);
    out.extend([1, 0, 16, 0]);
    out.extend([size, size].map(u64::to_le_bytes).concat());
    let length = out.len() as u64;
    // The end of the directory in 64 bits, its locator, and the end in 32 bits.
    let mut end = b"PK\x06\x06".to_vec();
    end.extend(44_u64.to_le_bytes());
    end.extend([45, 0, 45, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    end.extend([1, 1, length, at].map(u64::to_le_bytes).concat());
    end.extend(b"PK\x06\x07\0\0\0\0");
    end.extend((at + length).to_le_bytes());
    end.extend(1_u32.to_le_bytes());
    end.extend(b"PK\x05\x06\0\0\0\0\x01\0\x01\0");
    end.extend((length as u32).to_le_bytes());
    end.extend(u32::try_from(at).unwrap_or(u32::MAX).to_le_bytes());
    end.extend([0, 0]);
    out.extend(end);
    out
}

impl NpzWriter {
    pub(crate) fn new(mut output: Box<dyn WriteSeek>, layout: &Layout) -> Result<Self, Error> {
        let rows = Rows::new(layout);
        output
            .write_all(&[local(0, 0), rows.header()].concat())
            .map_err(Error::write)?;
        Ok(Self {
            output,
            rows,
            sum: Crc::new(),
        })
    }
}

impl LogWriter for NpzWriter {
    fn write_block(&mut self, block: &Block) -> Result<(), Error> {
        let bytes = self.rows.bytes(block);
        self.sum.update(bytes);
        self.output.write_all(bytes).map_err(Error::write)
    }

    fn finish(mut self: Box<Self>) -> Result<Vec<String>, Error> {
        let head = self.rows.header();
        let size = head.len() as u64 + self.rows.size();
        let mut sum = Crc::new();
        sum.update(&head);
        sum.combine(&self.sum);
        let local = local(sum.sum(), size);
        let at = local.len() as u64 + size;
        let end = directory(sum.sum(), size, at);
        self.output.write_all(&end).map_err(Error::write)?;
        self.output.seek(SeekFrom::Start(0)).map_err(Error::write)?;
        self.output
            .write_all(&[local, head].concat())
            .map_err(Error::write)?;
        self.output.seek(SeekFrom::End(0)).map_err(Error::write)?;
        self.output.flush().map_err(Error::write)?;
        Ok(self.rows.notes())
    }
}
