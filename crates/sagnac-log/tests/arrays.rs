//! MATLAB, HDF5, Parquet and Arrow: one log in every layout (testdata/arrays, made by tools/make_arrays.py with SciPy, h5py
//! and pyarrow), and real recordings against the numbers of their data set.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "tests")]

use std::path::{Path, PathBuf};

use sagnac_log::{Log, ReadOptions, Source, Stamp, read};

fn file(path: &Path) -> Source {
    let bytes = std::fs::read(path).unwrap();
    Source::memory(path.display().to_string(), bytes)
}

fn options(columns: &str, rate_hz: Option<f64>) -> ReadOptions {
    ReadOptions {
        columns: Some(columns.to_owned()),
        rate_hz,
        ..ReadOptions::default()
    }
}

fn small(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../testdata/arrays")
        .join(name)
}

/// The log of tools/make_arrays.py.
fn check(log: &Log, name: &str) {
    assert_eq!(log.rows, 60, "{name}");
    for k in 0..60 {
        for (j, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let gyro = (k as f64 + 1000.0 * j as f64) / 8.0;
            let accel = k as f64 - 30.0 * j as f64;
            assert_eq!(
                log.channel(&format!("gyro_{axis}")).unwrap()[k],
                gyro,
                "{name}"
            );
            assert_eq!(
                log.channel(&format!("accel_{axis}")).unwrap()[k],
                accel,
                "{name}"
            );
        }
    }
}

fn in_every_layout(names: &[&str], seconds: &str, nanoseconds: &str) {
    for name in names {
        let log = read(file(&small(name)), &options(seconds, None))
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        check(&log, name);
        assert_eq!(log.time_s(59), 0.59, "{name}");
        let log = read(file(&small(name)), &options(nanoseconds, None)).unwrap();
        assert_eq!(
            log.stamps.get(59),
            Some(Stamp::Nanoseconds(
                1_520_530_308_181_901_469 + 59 * 5_000_000
            )),
            "{name}"
        );
    }
}

#[test]
fn matlab_files_are_read_in_every_layout() {
    in_every_layout(
        &["plain.mat", "packed.mat", "big.mat"],
        "time=t:s, gyro=gyr:rad/s, accel=acc:m/s^2",
        "time=stamp:ns, gyro=gyr:rad/s, accel=acc:m/s^2",
    );
    in_every_layout(
        &["struct.mat", "struct_packed.mat"],
        "time=imu.t:s, gyro=imu.raw.gyr:rad/s, accel=imu.raw.acc:m/s^2",
        "time=imu.stamp:ns, gyro=imu.raw.gyr:rad/s, accel=imu.raw.acc:m/s^2",
    );
}

#[test]
fn hdf5_files_are_read_in_every_layout() {
    in_every_layout(
        &[
            "contiguous.h5",
            "filters.h5",
            "version108.h5",
            "latest.h5",
            "odd_chunks.h5",
            "many_links.h5",
        ],
        "time=t:s, gyro=imu/gyr:rad/s, accel=imu/acc:m/s^2",
        "time=imu/stamp:ns, gyro=imu/gyr:rad/s, accel=imu/acc:m/s^2",
    );
}

#[cfg(feature = "parquet")]
#[test]
fn parquet_files_are_read_in_every_layout() {
    in_every_layout(
        &["snappy.parquet", "zstd.parquet", "gzip_v2.parquet"],
        "time=t:s, gyro=gyr:rad/s, accel=acc:m/s^2",
        "time=stamp, gyro=gyr:rad/s, accel=acc:m/s^2",
    );
}

#[test]
fn arrow_files_are_read_in_every_layout() {
    in_every_layout(
        &["plain.arrow", "lz4.arrow", "zstd.arrows"],
        "time=t:s, gyro=gyr:rad/s, accel=acc:m/s^2",
        "time=stamp, gyro=gyr:rad/s, accel=acc:m/s^2",
    );
}

#[test]
fn nulls_of_arrow_columns_are_no_numbers() {
    let columns = "time=t:s, gyro=imu.gyr_x,imu.gyr_y,imu.gyr_z:rad/s";
    let log = read(file(&small("nested.arrow")), &options(columns, None)).unwrap();
    assert_eq!(log.rows, 60);
    for k in 0..60 {
        // Null by itself, or with all that it is nested with.
        let (own, whole) = (k % 7 == 3, k % 11 == 5);
        let values = ["gyro_x", "gyro_y"].map(|c| log.channel(c).unwrap()[k]);
        assert_eq!(values.map(f64::is_nan), [own || whole, whole], "{k}");
        if !whole {
            assert_eq!(values[1], (k as f64 + 1000.0) / 8.0);
        }
    }
}

#[test]
fn a_cut_arrow_file_gives_its_whole_batches() {
    let bytes = std::fs::read(small("lz4.arrow")).unwrap();
    let columns = "time=t:s, gyro=gyr:rad/s";
    let read_cut = |length: usize| {
        let source = Source::memory("cut.arrow", bytes[..length].to_vec());
        read(source, &options(columns, None))
    };
    let log = read_cut(bytes.len() * 6 / 10).unwrap();
    assert!(log.rows > 0 && log.rows < 60 && log.rows % 17 == 0);
    assert!(log.layout.notes.iter().any(|n| n.contains("cut off")));
    assert!(read_cut(900).is_err());
}

/// Means and rows of real recordings, as their READMEs give them.
#[test]
fn real_recordings_agree() {
    let root = std::env::var_os("SAGNAC_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let still = "mpu6050-orientations/set-2/unmoved-with-x-pointing-forward-10min/mpu6050_";
    for (name, columns, rate, rows, channel, mean) in [
        (
            format!("{still}accelerometer.mat"),
            "time=accelBuffer[0]:s, accel=accelBuffer[1],accelBuffer[2],accelBuffer[3]:m/s^2",
            None,
            65067,
            "accel_z",
            -1.03408,
        ),
        (
            format!("{still}gyroscope.mat"),
            "time=gyroBuffer[0]:s, gyro=gyroBuffer[1],gyroBuffer[2],gyroBuffer[3]:rad/s",
            None,
            65067,
            "gyro_x",
            4.53532,
        ),
        (
            "broad-orientation/01_undisturbed_slow_rotation_A.mat".to_owned(),
            "gyro=imu_gyr:rad/s, accel=imu_acc:m/s^2",
            Some(2000.0 / 7.0),
            56940,
            "accel_z",
            f64::NAN,
        ),
        (
            "broad-orientation/11_undisturbed_slow_translation_B.hdf5".to_owned(),
            "gyro=imu_gyr:rad/s, accel=imu_acc:m/s^2",
            Some(2000.0 / 7.0),
            54214,
            "accel_z",
            f64::NAN,
        ),
    ] {
        let path = root.join(&name);
        if !path.exists() {
            eprintln!("skipped: {} is not there", path.display());
            continue;
        }
        let log = read(file(&path), &options(columns, rate)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(log.rows, rows, "{name}");
        let values = log.channel(channel).unwrap();
        let got = values.iter().sum::<f64>() / rows as f64;
        assert!(
            mean.is_nan() || (got / mean - 1.0).abs() < 2e-5,
            "{name}: {got}"
        );
    }
}

#[test]
fn numbers_of_two_bytes_and_lists_of_fixed_length_are_read() {
    let columns = "time=time:s, gyro=gyr:rad/s, accel=gyr_x,gyr_y,gyr_z:m/s^2";
    let log = read(file(&small("lists.arrow")), &options(columns, None)).unwrap();
    assert_eq!(log.rows, 60);
    for k in 0..60 {
        for (j, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let wanted = (k as f64 + 1000.0 * j as f64) / 8.0;
            let value = log.channel(&format!("gyro_{axis}")).unwrap()[k];
            if k == 9 || 3 * k + j == 13 {
                assert!(value.is_nan(), "{k} {axis}");
            } else {
                assert_eq!(value, wanted);
            }
            let half = log.channel(&format!("accel_{axis}")).unwrap()[k];
            assert!((half - wanted / 8.0).abs() <= 1.0 / 64.0, "{half}");
        }
    }
}

#[cfg(feature = "parquet")]
#[test]
fn lists_of_parquet_are_told_with_their_names() {
    let columns = "time=time:s, accel=gyr_x,gyr_y,gyr_z:m/s^2";
    let log = read(file(&small("lists.parquet")), &options(columns, None)).unwrap();
    assert_eq!(log.channel("accel_z").unwrap()[59], 32.1875);
    let notes = log.layout.notes.join("; ");
    assert!(
        notes.contains("lists are not read, and were left out: `gyr`;"),
        "{notes}"
    );
    let columns = options("time=time:s, gyro_x=gyr:rad/s", None);
    let error = read(file(&small("lists.parquet")), &columns).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no column `gyr`: lists are not read"),
        "{error}"
    );
}

#[cfg(feature = "parquet")]
#[test]
fn the_unit_of_the_formats_own_stamps_counts() {
    let unit = |unit: &str| {
        let columns = format!("time=stamp{unit}, gyro_x=gyr_x:rad/s");
        read(file(&small("snappy.parquet")), &options(&columns, None))
    };
    for own in ["", ":ns", ":iso"] {
        let log = unit(own).unwrap();
        let last = Stamp::Nanoseconds(1_520_530_308_181_901_469 + 59 * 5_000_000);
        assert_eq!(log.stamps.get(59), Some(last), "{own}");
    }
    let error = unit(":s").unwrap_err();
    assert!(
        error
            .to_string()
            .contains("holds time stamps in ns by the file's own word, not in s"),
        "{error}"
    );
    assert!(error.advice().unwrap().contains(":ns"));
}

#[test]
fn an_array_of_another_length_is_told_where_it_is_asked_for() {
    let error = read(
        file(&small("plain.mat")),
        &options("time=t:s, gyro_x=rate:rad/s", None),
    )
    .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no column `rate`: array `rate` has 1 row, not 60"),
        "{error}"
    );
}
