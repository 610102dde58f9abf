//! Logs that are still being written: what is there is taken, a table is recognized by its first rows.

use std::io::{self, Read};

/// Lines that a growing table is recognized by: a header and the 64 samples below which there are no parameters.
const LINES: usize = 65;

/// Fills `buffer` up to `most` bytes, as far as the reader has them; returns whether it ended before.
///
/// A live reader is asked no further than [`LINES`] lines of text: the rest may be long in coming.
pub(crate) fn fill(
    reader: &mut dyn Read,
    buffer: &mut Vec<u8>,
    most: usize,
    is_live: bool,
) -> io::Result<bool> {
    if !is_live {
        let want = most.saturating_sub(buffer.len());
        let got = reader.take(want as u64).read_to_end(buffer)?;
        return Ok(got < want);
    }
    let mut lines = memchr::memchr_iter(b'\n', buffer).count();
    while buffer.len() < most && !(lines >= LINES && is_text(buffer)) {
        let got = read_some(reader, buffer, most)?;
        if got == 0 {
            return Ok(true);
        }
        let new = buffer.len() - got;
        lines += memchr::memchr_iter(b'\n', &buffer[new..]).count();
    }
    Ok(false)
}

/// One read that adds what is there, up to `most` bytes in all; 0 at the end.
pub(crate) fn read_some(
    reader: &mut dyn Read,
    buffer: &mut Vec<u8>,
    most: usize,
) -> io::Result<usize> {
    let old = buffer.len();
    buffer.resize(most.max(old), 0);
    loop {
        match reader.read(&mut buffer[old..]) {
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            result => {
                buffer.truncate(old + *result.as_ref().unwrap_or(&0));
                return result;
            }
        }
    }
}

fn is_text(bytes: &[u8]) -> bool {
    !bytes.iter().any(|&c| c < 9 || (c > 13 && c < 32))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use std::sync::mpsc::{Receiver, channel};

    use crate::{Block, ReadOptions, Source, open};

    /// Hands out what was sent, and waits where nothing was.
    struct Sent(Receiver<String>, Vec<u8>);

    impl std::io::Read for Sent {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            while self.1.is_empty() {
                match self.0.recv() {
                    Ok(text) => self.1 = text.into_bytes(),
                    Err(_) => return Ok(0),
                }
            }
            let n = self.1.len().min(buffer.len());
            buffer[..n].copy_from_slice(&self.1[..n]);
            self.1.drain(..n);
            Ok(n)
        }
    }

    #[test]
    fn rows_of_a_growing_table_come_as_they_are_written() {
        for threads in [1, 2] {
            let (sender, sent) = channel();
            let rows = |from: usize, to: usize| -> String {
                (from..to).map(|k| format!("{k}.5,{k}\n")).collect()
            };
            sender
                .send(format!("time [s],gyro_x [rad/s]\n{}", rows(0, 64)))
                .unwrap();
            let options = ReadOptions {
                is_live: true,
                threads,
                ..ReadOptions::default()
            };
            // None of these waits for what has not been sent yet.
            let mut reader =
                open(Source::stream("pipe", Sent(sent, Vec::new())), &options).unwrap();
            let mut block = Block::default();
            assert!(reader.read_block(&mut block).unwrap());
            assert_eq!(block.rows, 64);
            // A line that is not whole yet is kept for later.
            sender.send(rows(64, 66) + "66.").unwrap();
            assert!(reader.read_block(&mut block).unwrap());
            assert_eq!(block.columns[0], [64.0, 65.0]);
            sender.send("5,66\n".to_owned()).unwrap();
            assert!(reader.read_block(&mut block).unwrap());
            assert_eq!((block.rows, block.columns[0][0]), (1, 66.0));
            drop(sender);
            assert!(!reader.read_block(&mut block).unwrap());
        }
    }
}
