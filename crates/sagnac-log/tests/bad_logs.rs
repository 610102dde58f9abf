//! The small logs of testdata/logs (tools/make_logs.py), whole and hostile: bombs, promises, disorder, wrong topics.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::io::{Cursor, Read as _, Write as _};
use std::path::Path;

use sagnac_log::health::{HealthOptions, check};
use sagnac_log::{Error, IssueKind, Log, ReadOptions, Source, Stamp, read};

fn small(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/logs");
    std::fs::read(folder.join(name)).unwrap()
}

fn open(bytes: Vec<u8>) -> Result<Log, Error> {
    read(Source::memory("input", bytes), &ReadOptions::default())
}

#[test]
fn twenty_messages_come_out_of_every_format() {
    for (name, topic, start_ns) in [
        ("none.bag", None, 1_700_000_000_000_000_000),
        ("bz2.bag", None, 1_700_000_000_000_000_000),
        ("lz4.bag", None, 1_700_000_000_000_000_000),
        ("none.mcap", None, 1_700_000_000_000_000_000),
        // Every second message of these two is big-endian.
        ("zstd.mcap", None, 1_700_000_000_000_000_000),
        ("lz4.mcap", None, 1_700_000_000_000_000_000),
        ("none.db3", None, 1_700_000_000_000_000_000),
        // Every message is packed by itself.
        ("packed.db3", None, 1_700_000_000_000_000_000),
        ("small.ulg", None, 0),
        ("small.bin", Some("IMU[1]"), 0),
        ("small.bin", Some("1"), 0),
        ("small.bin", Some("IMU2"), 0),
    ] {
        let options = ReadOptions {
            topic: topic.map(str::to_owned),
            ..ReadOptions::default()
        };
        let log = read(Source::memory(name, small(name)), &options).unwrap();
        assert_eq!(log.rows, 20, "{name}");
        for k in 0..20 {
            let v = k as f64;
            let ns = start_ns + 5_000_000 * k as i64;
            assert_eq!(log.stamps.get(k), Some(Stamp::Nanoseconds(ns)), "{name}");
            for (channel, wanted) in [
                ("gyro_x", v),
                ("gyro_y", -v),
                ("gyro_z", v / 2.0),
                ("accel_x", v / 4.0),
                ("accel_y", -v),
                ("accel_z", 9.8125),
            ] {
                assert_eq!(log.channel(channel).unwrap()[k], wanted, "{name} {channel}");
            }
        }
    }
}

/// A record of a bag.
fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut head = Vec::new();
    for (name, value) in fields {
        head.extend((name.len() as u32 + 1 + value.len() as u32).to_le_bytes());
        head.extend([name.as_bytes(), b"=", value].concat());
    }
    let mut out = (head.len() as u32).to_le_bytes().to_vec();
    out.extend(head);
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out
}

fn bag_with_chunk(compression: &[u8], size: u32, data: &[u8]) -> Vec<u8> {
    let mut out = small("none.bag");
    // After the sound recording: an index is not needed to find it.
    out.extend(record(
        &[
            ("op", &[5]),
            ("compression", compression),
            ("size", &size.to_le_bytes()),
        ],
        data,
    ));
    out
}

#[test]
fn bombs_cost_neither_memory_nor_the_messages_before() {
    // 100 MB of zeros in some hundred bytes of bz2, then a chunk that claims 4 GiB.
    let zeros = std::io::repeat(0).take(100_000_000);
    let mut packed = Vec::new();
    bzip2::read::BzEncoder::new(zeros, bzip2::Compression::best())
        .read_to_end(&mut packed)
        .unwrap();
    assert!(packed.len() < 1000);
    for bytes in [
        bag_with_chunk(b"bz2", u32::MAX, &packed),
        bag_with_chunk(
            b"lz4",
            u32::MAX,
            &[0x04, 0x22, 0x4D, 0x18, 0x40, 0x40, 0xC0],
        ),
        bag_with_chunk(b"none", u32::MAX, &[0xFF; 4096]),
        bag_with_chunk(b"nothing known", 0, &[1, 2, 3]),
    ] {
        let log = open(bytes).unwrap();
        assert_eq!(log.rows, 20);
    }
    // MCAP: a chunk that promises 2^63 bytes.
    let sound = small("none.mcap");
    let mut bytes = sound[..sound.len() - 8].to_vec();
    let mut body = [0_u64, 0, 1 << 63].map(u64::to_le_bytes).concat();
    body.extend([0; 8]);
    body.extend((1_u64 << 63).to_le_bytes());
    bytes.push(6);
    bytes.extend((1_u64 << 63).to_le_bytes());
    bytes.extend(body);
    assert_eq!(open(bytes).unwrap().rows, 20);
    // gzip of 65 MB of text without a line: refused, in bounded memory.
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    for _ in 0..16_000 {
        encoder.write_all(&[b'a'; 1 << 12]).unwrap();
    }
    assert!(open(encoder.finish().unwrap()).is_err());
}

#[test]
fn a_recording_that_was_not_closed_is_read_and_says_so() {
    let whole = small("none.bag");
    // The index stands behind the chunk: without it the head's place is beyond the end.
    let at = memchr::memmem::find(&whole, b"op=\x04").unwrap();
    let log = open(whole[..at - 8].to_vec()).unwrap();
    assert_eq!(log.rows, 20);
    assert!(
        log.layout.notes.iter().any(|n| n.contains("not closed")),
        "{:?}",
        log.layout.notes
    );
}

#[test]
fn wrong_and_empty_topics_are_one_sentence() {
    let ask = |name: &str, topic: &str| {
        let options = ReadOptions {
            topic: Some(topic.to_owned()),
            ..ReadOptions::default()
        };
        read(Source::memory(name, small(name)), &options)
            .unwrap_err()
            .to_string()
    };
    assert!(ask("none.bag", "/camera").contains("no topic `/camera`"));
    assert!(ask("small.bin", "MSG").contains("not message IMU"));
    // The type's name alone is changed: no inertial topic is left.
    let mut bytes = small("none.mcap");
    while let Some(at) = memchr::memmem::find(&bytes, b"sensor_msgs/msg/Imu") {
        bytes[at..at + 19].copy_from_slice(b"sensor_msgs/msg/Ima");
    }
    let error = open(bytes).unwrap_err().to_string();
    assert!(error.contains("no sensor_msgs/Imu"), "{error}");
    // Connections without a message.
    let whole = small("none.bag");
    let at = memchr::memmem::find(&whole, b"op=\x05").unwrap();
    let mut bytes = whole[..at - 8].to_vec();
    bytes.extend(record(
        &[("op", &[7]), ("conn", &[0; 4]), ("topic", b"/imu")],
        &[[10 + 4, 0, 0, 0].as_slice(), b"topic=/imu"].concat(),
    ));
    assert!(open(bytes).is_err());
}

#[test]
fn time_that_goes_back_and_several_clocks_are_findings() {
    let mut text = "time [s],gyro_x [rad/s]\n".to_owned();
    let mut line = |t: f64| text += &format!("{t},{}\n", (t * 7.0).sin());
    (0..500).for_each(|k| line(f64::from(k) * 0.01));
    // Another clock: seconds since 1970, then the first again.
    (500..800).for_each(|k| line(1.7e9 + f64::from(k) * 0.01));
    (800..1500).for_each(|k| line(f64::from(k) * 0.01));
    let log = open(text.into_bytes()).unwrap();
    assert_eq!(log.rows, 1500);
    let health = check(&log, &HealthOptions::default()).unwrap();
    assert!(
        health.issues.iter().any(|i| i.kind == IssueKind::Backwards),
        "{:?}",
        health.issues
    );
}

#[test]
fn archives_that_promise_too_much_are_refused() {
    let arrays = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/arrays");
    let options = ReadOptions {
        columns: Some("time=t:s, gyro=gyr:rad/s".to_owned()),
        ..ReadOptions::default()
    };
    let mut bytes = std::fs::read(arrays.join("plain.mat")).unwrap();
    // The first array, t: sides 1 × 60 and 480 bytes become 1 × 2^30 and 2^33 modulo 2^32.
    let at = memchr::memmem::find(&bytes, &[1, 0, 0, 0, 60, 0, 0, 0]).unwrap();
    bytes[at + 4..at + 8].copy_from_slice(&(1_u32 << 30).to_le_bytes());
    assert!(read(Source::memory("a.mat", bytes), &options).is_err());
    // A pipe is told what to do instead.
    for name in ["packed.mat", "filters.h5"] {
        let bytes = std::fs::read(arrays.join(name)).unwrap();
        let error = read(Source::stream("-", Cursor::new(bytes)), &options).unwrap_err();
        assert!(error.to_string().contains("pipe"), "{error}");
    }
    // What is packed is no pipe.
    let bytes = std::fs::read(arrays.join("filters.h5")).unwrap();
    let packed = zstd::encode_all(&bytes[..], 3).unwrap();
    let error = read(Source::memory("a.h5.zst", packed), &options).unwrap_err();
    assert!(error.to_string().contains("packed by zstd"), "{error}");
    assert_eq!(
        error.advice().as_deref(),
        Some("unpack it first: zstd -d FILE")
    );
    // Every refusal says what to do.
    for (columns, what) in [
        ("time=0:s, gyro=1,2,9:deg/s", "column 9"),
        ("time=0:s, gyro=1,2,2:deg/s", "used twice"),
        ("time=0:s, gyro=1:deg/s", "takes three columns"),
        ("time=0:s, gyro_x=absent:deg/s", "no column"),
    ] {
        let options = ReadOptions {
            columns: Some(columns.to_owned()),
            ..ReadOptions::default()
        };
        let error = read(
            Source::memory("a.csv", b"0,1,2\n1,2,3\n".to_vec()),
            &options,
        )
        .unwrap_err();
        assert!(
            error.to_string().contains(what) && error.advice().is_some(),
            "{error}"
        );
    }
}
