//! Checksums that files carry: what does not match them is left out and counted, or refused.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;

use sagnac_log::{
    Block, Channel, Error, Layout, Log, ReadOptions, Source, Stamp, Stamps, WriteFormat, create,
    read,
};

const CHANNELS: [&str; 6] = [
    "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z",
];

/// A log whose every value is the number of its row, as a file of that format.
fn written(format: WriteFormat, rows: u32) -> Vec<u8> {
    let layout = Layout {
        channels: CHANNELS.map(Channel::named).to_vec(),
        has_time: true,
        ..Layout::default()
    };
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut writer = create(format, Box::new(file.reopen().unwrap()), &layout).unwrap();
    let mut stamps = Stamps::default();
    (0..rows).for_each(|k| {
        stamps.push(Stamp::Nanoseconds(
            1_700_000_000_000_000_000 + 5_000_000 * i64::from(k),
        ));
    });
    let block = Block {
        rows: rows as usize,
        stamps,
        columns: vec![(0..rows).map(f64::from).collect(); 6],
        ..Block::default()
    };
    writer.write_block(&block).unwrap();
    writer.finish().unwrap();
    std::fs::read(file.path()).unwrap()
}

fn array(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/arrays");
    std::fs::read(folder.join(name)).unwrap()
}

fn with_columns(bytes: Vec<u8>, columns: &str) -> Result<Log, Error> {
    let options = ReadOptions {
        columns: Some(columns.to_owned()),
        ..ReadOptions::default()
    };
    read(Source::memory("input", bytes), &options)
}

/// Kind and place of the records of an MCAP file.
fn records(bytes: &[u8]) -> Vec<(u8, usize)> {
    let (mut at, mut out) = (8, Vec::new());
    while at + 9 < bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        out.push((bytes[at], at));
        at += 9 + length as usize;
    }
    out
}

#[test]
fn a_chunk_that_does_not_match_its_checksum_is_left_out_and_counted() {
    let whole = written(WriteFormat::Mcap, 9000);
    let all = ReadOptions::default();
    assert_eq!(
        read(Source::memory("a", whole.clone()), &all).unwrap().rows,
        9000
    );
    let chunks: Vec<usize> = records(&whole)
        .into_iter()
        .filter(|r| r.0 == 6)
        .map(|r| r.1)
        .collect();
    assert!(chunks.len() >= 3, "{}", chunks.len());
    for pipe in [false, true] {
        // One bit of a value in the middle of the second chunk.
        let mut bytes = whole.clone();
        bytes[usize::midpoint(chunks[1], chunks[2])] ^= 1;
        let source = if pipe {
            Source::stream("a", std::io::Cursor::new(bytes))
        } else {
            Source::memory("a", bytes)
        };
        let log = read(source, &all).unwrap();
        assert!(log.rows > 5000 && log.rows < 7000, "{}", log.rows);
        let notes = log.layout.notes.join("; ");
        let lost = format!("{} messages stood in them", 9000 - log.rows);
        assert!(
            notes.contains(&format!(
                "the chunk at byte {} does not match its checksum and is left out",
                sagnac_grouped(chunks[1] as u64 + 49)
            )) && notes.contains(&lost),
            "{notes}"
        );
        for k in 0..log.rows {
            let row = log.channel("accel_z").unwrap()[k];
            let ns = 1_700_000_000_000_000_000 + 5_000_000 * row as i64;
            assert_eq!(log.stamps.get(k), Some(Stamp::Nanoseconds(ns)));
        }
    }
    // A checksum of 0 is none.
    let mut bytes = whole.clone();
    bytes[chunks[1] + 33..chunks[1] + 37].fill(0);
    assert_eq!(read(Source::memory("a", bytes), &all).unwrap().rows, 9000);
    // A summary may be left out: the footer's place of it is 0, and nothing is damaged.
    let all_records = records(&whole);
    let data_ends = all_records.iter().find(|r| r.0 == 15).unwrap().1;
    let footer = all_records.iter().find(|r| r.0 == 2).unwrap().1;
    let mut bytes = [&whole[..data_ends + 13], &whole[footer..]].concat();
    let at = data_ends + 13 + 9;
    bytes[at..at + 16].fill(0);
    let log = read(Source::memory("a", bytes.clone()), &all).unwrap();
    assert_eq!((log.rows, log.layout.notes.len()), (9000, 0));
    bytes.truncate(bytes.len() - 20);
    let log = read(Source::memory("a", bytes), &all).unwrap();
    assert!(log.layout.notes[0].contains("index is missing"));
}

/// A number as the notes group it.
fn sagnac_grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (k, c) in digits.chars().enumerate() {
        if k > 0 && digits.len() > 4 && (digits.len() - k).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(c);
    }
    out
}

#[test]
fn arrays_that_do_not_match_their_checksum_are_refused() {
    let refuse = |bytes: Vec<u8>, columns: &str, what: &str| {
        let error = with_columns(bytes, columns).unwrap_err();
        assert!(
            error.to_string().contains("checksum") && error.advice().is_some(),
            "{what}: {error}"
        );
    };
    // The last bit of each, so that all before it was delivered.
    let own = ReadOptions::default();
    let mut bytes = written(WriteFormat::Npz, 3000);
    assert_eq!(
        read(Source::memory("a", bytes.clone()), &own).unwrap().rows,
        3000
    );
    let directory = memchr::memmem::find(&bytes, b"PK\x01\x02").unwrap();
    let data = bytes[..directory]
        .windows(8)
        .rposition(|w| w == 2999.0_f64.to_le_bytes())
        .unwrap();
    bytes[data + 6] ^= 1;
    let error = read(Source::memory("a", bytes), &own).unwrap_err();
    assert!(error.to_string().contains("checksum"), "{error}");

    let seconds = "time=t:s, gyro=gyr:rad/s, accel=acc:m/s^2";
    let mut bytes = array("packed.mat");
    assert!(with_columns(bytes.clone(), seconds).is_ok());
    // Adler-32 of the second element, `gyr`.
    let element = |at: usize, b: &[u8]| {
        at + 8 + u32::from_le_bytes(b[at + 4..at + 8].try_into().unwrap()) as usize
    };
    let second = element(element(128, &bytes), &bytes);
    bytes[second - 1] ^= 1;
    refuse(bytes.clone(), seconds, "packed.mat");
    refuse(bytes, "time=t:s, gyro_x=gyr[0]:rad/s", "packed.mat");

    let in_group = "time=t:s, gyro=imu/gyr:rad/s, accel=imu/acc:m/s^2";
    let mut bytes = array("fletcher.h5");
    assert_eq!(with_columns(bytes.clone(), in_group).unwrap().rows, 60);
    let value = ((59.0 + 2000.0) / 8.0_f32).to_le_bytes();
    let data = bytes.windows(4).rposition(|w| w == value).unwrap();
    bytes[data] ^= 1;
    refuse(bytes, in_group, "fletcher.h5");
}

#[test]
fn a_cut_hdf5_file_is_told_to_be_cut() {
    let bytes = array("contiguous.h5");
    let error =
        with_columns(bytes[..bytes.len() * 3 / 4].to_vec(), "gyro=imu/gyr:rad/s").unwrap_err();
    assert!(error.to_string().contains("is cut off"), "{error}");
    assert!(error.advice().is_some());
}

#[cfg(feature = "parquet")]
#[test]
fn a_page_of_parquet_that_does_not_match_its_checksum_is_refused() {
    let columns = "time=t:s, gyro=gyr_x,gyr_y,gyr_z:rad/s";
    let mut bytes = array("checked.parquet");
    assert_eq!(with_columns(bytes.clone(), columns).unwrap().rows, 60);
    // Two values in a row: the largest alone stands in the page's description as well.
    let values = [58.0, 59.0].map(|k| (k / 8.0_f32).to_le_bytes()).concat();
    let data = bytes.windows(8).position(|w| w == values).unwrap();
    bytes[data] ^= 1;
    let error = with_columns(bytes, columns).unwrap_err();
    assert!(
        error.to_string().contains("CRC") && error.advice().is_some(),
        "{error}"
    );
    let error = with_columns(array("brotli.parquet"), columns).unwrap_err();
    assert!(
        error.to_string().contains("packed by Brotli") && error.advice().is_some(),
        "{error}"
    );
}
