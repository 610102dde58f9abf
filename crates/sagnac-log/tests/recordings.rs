//! Real recordings of other tools against the numbers of independent readers (rosbags, mcap, pyulog, pymavlink), and
//! the same recordings cut, unindexed and damaged.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "tests")]

use std::path::PathBuf;

use sagnac_log::{Log, ReadOptions, Source, Stamp, read};

fn data(name: &str) -> Option<Vec<u8>> {
    let root = std::env::var_os("SAGNAC_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = root.join("formats").join(name);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        eprintln!("skipped: {} is not there", path.display());
    }
    bytes
}

fn topic(name: &str) -> ReadOptions {
    ReadOptions {
        topic: (!name.is_empty()).then(|| name.to_owned()),
        any_topic: true,
        ..ReadOptions::default()
    }
}

/// File, topic, rows, first and last stamp [ns], first and last gyro and accelerometer.
type Known = (&'static str, &'static str, usize, [i64; 2], [[f64; 6]; 2]);

const PHIDGETS_FIRST: [f64; 6] = [
    0.0,
    0.000351509311,
    0.00445041506,
    -0.202086009,
    -0.105555605,
    -9.86974332,
];
const PHIDGETS_20S: [f64; 6] = [
    -0.000703018623,
    0.00492147942,
    -0.0168647675,
    -0.0913311039,
    -0.0336483014,
    -9.71327382,
];
const PHIDGETS_LAST: [f64; 6] = [
    0.0,
    0.0042184608,
    0.0037477455,
    -0.172165507,
    -0.0965304041,
    -9.85551882,
];

fn known() -> Vec<Known> {
    let whole = [1360242236211312933, 1360242292450791812];
    let part = [1360242236211312933, 1360242256207197098];
    vec![
        (
            "ros1/phidgets_imu_upside_down.bag",
            "/imu/data_raw",
            13964,
            whole,
            [PHIDGETS_FIRST, PHIDGETS_LAST],
        ),
        (
            "ros1/phidgets_imu_upside_down_lz4.bag",
            "",
            13964,
            whole,
            [PHIDGETS_FIRST, PHIDGETS_LAST],
        ),
        (
            "ros1/husky_test1.bag",
            "",
            11865,
            [1432235497988949113, 1432235893280979189],
            [
                [
                    0.025469467,
                    -0.0107689407,
                    -0.0150536997,
                    0.542761564,
                    9.60821943,
                    0.205931044,
                ],
                [
                    0.0254526138,
                    0.000667540357,
                    0.000611707568,
                    -0.263928456,
                    9.79111867,
                    0.119584374,
                ],
            ],
        ),
        (
            "ros2/phidgets_20s_mcap/phidgets_20s_mcap.mcap",
            "imu/data_raw",
            4990,
            part,
            [PHIDGETS_FIRST, PHIDGETS_20S],
        ),
        (
            "ros2/phidgets_20s_zstd.mcap",
            "",
            4990,
            part,
            [PHIDGETS_FIRST, PHIDGETS_20S],
        ),
        (
            "ros2/phidgets_20s_db3/phidgets_20s_db3.db3",
            "",
            4990,
            part,
            [PHIDGETS_FIRST, PHIDGETS_20S],
        ),
        (
            "ros2/constant_imu/rosbag2_test_0.db3",
            "",
            1565,
            [1588512872784906481, 1588512935344918786],
            [[131.0, 132.0, 133.0, 151.0, 152.0, 153.0]; 2],
        ),
        (
            "ulog/sample.ulg",
            "",
            17070,
            [112614307000, 181493506000],
            [
                [
                    -0.00192494364,
                    -0.00331021356,
                    -0.00323856669,
                    1.10714173,
                    -0.486477524,
                    -9.63039494,
                ],
                [
                    -0.00137469545,
                    -0.0025773237,
                    -0.0037138944,
                    1.14002633,
                    -0.441030651,
                    -9.63232517,
                ],
            ],
        ),
        (
            "ulog/fmu_v6c_6s.ulg",
            "sensor_combined",
            1297,
            [27329869000, 33819668000],
            [
                [
                    -0.129735902,
                    -0.0335161202,
                    -0.619448483,
                    1.82698596,
                    0.153717801,
                    -8.96640205,
                ],
                [
                    0.120034009,
                    -0.110248834,
                    -0.0876195133,
                    2.20771551,
                    1.25987971,
                    -9.03518009,
                ],
            ],
        ),
    ]
}

fn check(log: &Log, row: usize, ns: i64, values: &[f64; 6], name: &str) {
    assert_eq!(log.stamps.get(row), Some(Stamp::Nanoseconds(ns)), "{name}");
    for (column, want) in log.columns.iter().zip(values) {
        // The README gives nine digits.
        assert!(
            (column[row] - want).abs() <= 6e-9 * want.abs(),
            "{name}: {} {want}",
            column[row]
        );
    }
}

#[test]
fn counts_and_messages_are_those_of_the_independent_readers() {
    for (name, wanted, rows, ns, values) in known() {
        let Some(bytes) = data(name) else { continue };
        let file = read(Source::memory(name, bytes.clone()), &topic(wanted)).unwrap();
        assert_eq!(file.rows, rows, "{name}");
        check(&file, 0, ns[0], &values[0], name);
        check(&file, rows - 1, ns[1], &values[1], name);
        if name.ends_with("db3") {
            continue;
        }
        let pipe = Source::stream(name, std::io::Cursor::new(bytes));
        let pipe = read(pipe, &topic(wanted)).unwrap();
        assert_eq!(pipe.columns, file.columns, "{name} from a pipe");
        assert_eq!(pipe.stamps, file.stamps, "{name} from a pipe");
    }
}

#[test]
fn instances_of_ardupilot_are_topics() {
    let Some(bytes) = data("ardupilot/plane_px4v4.BIN") else {
        return;
    };
    let source = || Source::memory("plane.BIN", bytes.clone());
    let several = read(source(), &ReadOptions::default()).unwrap_err();
    assert!(several.to_string().contains("IMU, IMU2"), "{several}");
    let log = read(source(), &topic("IMU2")).unwrap();
    assert_eq!(log.rows, 45);
    let first = [
        -0.110923037,
        0.009959599,
        -0.00143114047,
        0.387851,
        0.522071958,
        -9.67627525,
    ];
    check(&log, 0, 81794643000, &first, "IMU2");
    assert!((log.channel("temperature").unwrap()[0] - 39.9230).abs() < 5e-5);
    assert!(log.layout.frame.unwrap().contains("FRD"));
}

#[derive(Clone, Default)]
struct Shared(std::sync::Arc<std::sync::Mutex<std::io::Cursor<Vec<u8>>>>);

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl std::io::Seek for Shared {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.0.lock().unwrap().seek(to)
    }
}

#[test]
fn what_is_written_reads_back() {
    let mut text = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n".to_owned();
    for k in 1..=7000 {
        let v = f64::from(k) / 3.0;
        text += &format!(
            "{k},{v},{},{},{},{},{}\n",
            v + 1.0,
            -v,
            v * 2.0,
            v * 3.0,
            v * 4.0
        );
    }
    let log = read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap();
    for name in ["a.mcap", "a.bag", "a.npz", "a.parquet"] {
        let format = sagnac_log::WriteFormat::of_name(name).unwrap();
        let out = Shared::default();
        let mut writer = sagnac_log::create(format, Box::new(out.clone()), &log.layout).unwrap();
        for block in log.blocks() {
            writer.write_block(&block).unwrap();
        }
        writer.finish().unwrap();
        let bytes = out.0.lock().unwrap().get_ref().clone();
        let back = read(Source::memory(name, bytes), &ReadOptions::default()).unwrap();
        assert_eq!(back.columns, log.columns, "{name}");
        assert_eq!(back.rows, 7000, "{name}");
        assert_eq!(back.stamps.get(6999).unwrap().seconds(), 7000.0, "{name}");
        if let Some(folder) = std::env::var_os("SAGNAC_KEEP") {
            let bytes = out.0.lock().unwrap().get_ref().clone();
            std::fs::write(PathBuf::from(folder).join(name), bytes).unwrap();
        }
    }
}

#[test]
fn covariances_are_kept_and_turned() {
    let text = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]\n1,1,2,3,4,5,6\n2,1,2,3,4,5,6\n";
    let log = read(
        Source::memory("a.csv", text.into()),
        &ReadOptions::default(),
    )
    .unwrap();
    let mut layout = log.layout.clone();
    let gyro = [1.0, 0.5, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0, 3.0];
    let accel = [4.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 6.0];
    layout.covariances = Some([gyro, accel]);
    for name in ["a.mcap", "a.bag"] {
        let format = sagnac_log::WriteFormat::of_name(name).unwrap();
        let out = Shared::default();
        let mut writer = sagnac_log::create(format, Box::new(out.clone()), &layout).unwrap();
        for block in log.blocks() {
            writer.write_block(&block).unwrap();
        }
        writer.finish().unwrap();
        let bytes = out.0.lock().unwrap().get_ref().clone();
        let mut options = ReadOptions::default();
        let back = read(Source::memory(name, bytes.clone()), &options).unwrap();
        assert_eq!(back.layout.covariances, layout.covariances, "{name}");
        options.axes = Some("x=-y, y=x".to_owned());
        let back = read(Source::memory(name, bytes), &options).unwrap();
        let turned = [2.0, -0.5, 0.0, -0.5, 1.0, 0.0, 0.0, 0.0, 3.0];
        assert_eq!(back.layout.covariances.unwrap()[0], turned, "{name}");
    }
}

#[test]
fn arrays_are_sources_by_name() {
    let Some(bytes) = data("npz/imu_data.npz") else {
        return;
    };
    let options = ReadOptions {
        columns: Some("gyro=gyr:rad/s, accel=acc:m/s^2".to_owned()),
        rate_hz: Some(2000.0 / 7.0),
        ..ReadOptions::default()
    };
    let log = read(Source::memory("imu.npz", bytes), &options).unwrap();
    assert_eq!(log.rows, 13500);
}

#[test]
fn cut_recordings_are_salvaged_and_say_so() {
    for (name, wanted, rows, ns, values) in known() {
        let Some(bytes) = data(name) else { continue };
        let cut = bytes[..bytes.len() * 7 / 10].to_vec();
        let log = read(Source::memory(name, cut), &topic(wanted)).unwrap();
        assert!(
            log.rows > rows / 2 && log.rows < rows,
            "{name}: {}",
            log.rows
        );
        check(&log, 0, ns[0], &values[0], name);
        let notes = log.layout.notes.join("; ");
        assert!(
            notes.contains("cut off") || notes.contains("damaged"),
            "{name}: {notes}"
        );
    }
}

/// A declared generator for damage: splitmix64.
fn damage(bytes: &mut Vec<u8>, seed: u64) {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (state ^ state >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    };
    for _ in 0..=next() % 8 {
        let n = bytes.len() as u64;
        // Half of the damage hits the first kilobytes, where the structure stands.
        let reach = if next() % 2 == 0 { n.min(4096) } else { n };
        let at = (next() % reach.max(1)) as usize;
        match next() % 4 {
            0 => bytes[at] = next() as u8,
            1 => bytes[at] ^= 1 << (next() % 8),
            2 => {
                let end = (at + 8).min(bytes.len());
                bytes[at..end].fill(if next() % 2 == 0 { 0xFF } else { 0 });
            }
            _ => bytes.truncate(at.max(16)),
        }
    }
}

#[test]
fn damaged_recordings_never_panic() {
    for (name, wanted, rows, ..) in known() {
        let Some(bytes) = data(name) else { continue };
        let small = &bytes[..bytes.len().min(60_000)];
        for seed in 0..400 {
            let mut bad = small.to_vec();
            damage(&mut bad, seed);
            if let Ok(log) = read(Source::memory(name, bad), &topic(wanted)) {
                assert!(log.rows <= rows, "{name}, seed {seed}");
            }
        }
    }
}
