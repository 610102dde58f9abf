//! Recordings of real sensors: residual |f| − g at or below what their authors published, and what they cannot tell.
//!
//! The marks stand in CALIBRATION.md; each recording has its source in its own README.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "tests")]

use std::path::PathBuf;

use sagnac::calibrate::{
    MultiPositionOutcome, MultiPositionRequest, Place, ThermalRequest, multi_position, thermal,
};
use sagnac::characterize::NamedLog;
use sagnac::log::{Log, ReadOptions, Source, open};

/// A recording as bytes; none where the data is absent.
fn bytes(name: &str) -> Option<Vec<u8>> {
    let folder = std::env::var_os("SAGNAC_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let found = std::fs::read(folder.join(name)).ok();
    if found.is_none() {
        eprintln!("skipped: {name} is not there (set SAGNAC_DATA)");
    }
    found
}

fn log(
    name: &str,
    columns: Option<&str>,
    rate_hz: Option<f64>,
    topic: Option<&str>,
) -> Option<Log> {
    let options = ReadOptions {
        columns: columns.map(str::to_owned),
        rate_hz,
        topic: topic.map(str::to_owned),
        ..ReadOptions::default()
    };
    let mut reader = open(Source::memory(name, bytes(name)?), &options).unwrap();
    Some(Log::read(&mut *reader).unwrap())
}

fn turned(log: &Log, gravity_m_s2: f64) -> MultiPositionOutcome {
    let request = MultiPositionRequest {
        label: "log".to_owned(),
        place: Place {
            gravity_m_s2: Some(gravity_m_s2),
            ..Place::default()
        },
        ..MultiPositionRequest::default()
    };
    multi_position(log, &request).unwrap()
}

fn value(outcome: &MultiPositionOutcome, name: &str) -> (f64, f64) {
    let p = outcome.found.parameter(name).unwrap();
    (p.value, p.sigma)
}

#[test]
fn mpu9150_is_as_published() {
    let columns = "accel=0,1,2:m/s^2, gyro=3,4,5:rad/s";
    // s and b of the published table (in %, m/s²); its misalignment is upper triangular, another frame.
    for (name, scale, bias) in [
        ("imu0.log", [0.363, 0.315, 0.647], [0.103, 0.097, 0.344]),
        ("imu1.log", [0.471, 0.482, 0.932], [0.09, 0.07, 0.338]),
    ] {
        let path = format!("mpu9150-multiposition/{name}");
        let Some(log) = log(&path, Some(columns), Some(100.0), None) else {
            return;
        };
        let outcome = turned(&log, 9.81);
        assert!(
            outcome.found.accel_rms <= 0.0028,
            "{name}: {}",
            outcome.found.accel_rms
        );
        assert!(outcome.found.poses.len() >= 20);
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let (s, sigma) = value(&outcome, &format!("accel.scale_factor.{axis}"));
            // The table has three decimals of a per cent; 3 σ leaves one of 12 outside once in 30 tests.
            assert!(
                (s - scale[k] / 100.0).abs() < 3.0 * sigma + 5e-6,
                "{name} s_{axis} {s}"
            );
            let (b, sigma) = value(&outcome, &format!("accel.bias.{axis}"));
            assert!(
                (b - bias[k]).abs() < 3.0 * sigma + 5e-4,
                "{name} b_{axis} {b}"
            );
        }
        assert!(outcome.found.gyro_rms.unwrap() < 0.01);
    }
}

#[test]
fn mpu6050_has_ten_poses_and_says_what_they_do_not_tell() {
    let columns = "accel=0,1,2:598.550415e-6 m/s^2, gyro=3,4,5:7.63358779e-3 deg/s";
    let Some(log) = log(
        "mpu6050-multiposition/calibration.csv",
        Some(columns),
        Some(100.0),
        None,
    ) else {
        return;
    };
    let outcome = turned(&log, 9.80665);
    // Published: 0.0042 m/s² on its own intervals.
    assert!(
        outcome.found.accel_rms < 0.0042,
        "{}",
        outcome.found.accel_rms
    );
    assert!(!outcome.found.held.is_empty());
    assert!(
        !outcome.to_json()["unobservable"]
            .as_array()
            .unwrap()
            .is_empty()
    );
}

#[test]
fn mimu4444_meets_gravity_in_all_eight() {
    let marks = [
        0.0020, 0.0018, 0.0026, 0.0047, 0.0015, 0.0024, 0.0017, 0.0019,
    ];
    for (i, mark) in marks.into_iter().enumerate() {
        let number = (i + 1).to_string();
        let Some(log) = log("mimu4444-array/exp_1_data.bin", None, None, Some(&number)) else {
            return;
        };
        let outcome = turned(&log, 9.80665);
        // The marks are printed with two digits.
        assert!(
            outcome.found.accel_rms < mark + 0.6e-4,
            "IMU {number}: {}",
            outcome.found.accel_rms
        );
        assert!(outcome.found.gyro_rms.unwrap() < 0.02, "IMU {number}");
    }
}

#[test]
fn a_temperature_sweep_with_hysteresis() {
    let columns = "time=0:us, gyro=1,2,3:rad/s, accel=4,5,6:m/s^2, temperature=8:degC";
    let Some(log) = log("thermal-sweep/imu_raw_data.tsv", Some(columns), None, None) else {
        return;
    };
    let outcome = thermal(
        &[NamedLog {
            name: "sweep".to_owned(),
            log,
        }],
        &ThermalRequest {
            form: Some("polynomial".to_owned()),
            ..ThermalRequest::default()
        },
    )
    .unwrap();
    // Reference: rms of all samples by b + ½ s h, and the cubic of the recording's README for b alone.
    let marks = [
        (0.00246, 0.004_148_3),
        (0.00067, 0.000_951_6),
        (0.00137, 0.001_398_2),
        (0.0038, 0.006_404_2),
        (0.0062, 0.017_312),
        (0.0136, 0.044_298),
    ];
    for (curve, (with, cubic)) in outcome.found.curves.iter().zip(marks) {
        let name = format!("{:?} {}", curve.sensor, curve.axis);
        assert!(
            curve.residual_rms < 1.02 * with,
            "{name}: {}",
            curve.residual_rms
        );
        assert!(
            curve.residual_rms_single < 1.03 * cubic,
            "{name}: {}",
            curve.residual_rms_single
        );
    }
    assert!(
        outcome
            .found
            .notes
            .iter()
            .any(|n| n.contains("tilt of the fixture"))
    );
}

#[test]
fn three_faces_are_refused_with_what_to_add() {
    let zero = vec![0.0; 3000];
    let mut axes = [zero.clone(), zero.clone(), zero];
    for (k, axis) in axes.iter_mut().enumerate() {
        for (i, v) in axis.iter_mut().enumerate() {
            let noise = ((i * 7919 + k * 104_729) % 1009) as f64 * 4e-5;
            *v = noise + if i / 1000 == k { 9.8 } else { 0.0 };
        }
    }
    let text: String = (0..3000)
        .map(|i| {
            // A turn between the faces: the sensor shakes.
            let shake = if i % 1000 < 150 {
                f64::sin(i as f64 * 1.3) * 3.0
            } else {
                0.0
            };
            format!("{},{},{}\n", axes[0][i] + shake, axes[1][i], axes[2][i])
        })
        .collect();
    let options = ReadOptions {
        columns: Some("accel=0,1,2:m/s^2".to_owned()),
        rate_hz: Some(100.0),
        ..ReadOptions::default()
    };
    let mut reader = open(Source::memory("faces.csv", text.into_bytes()), &options).unwrap();
    let log = Log::read(&mut *reader).unwrap();
    let error = multi_position(&log, &MultiPositionRequest::default()).unwrap_err();
    assert!(error.what.contains("3 of them distinct"), "{}", error.what);
    assert!(error.advice.unwrap().contains("up so far"));
}
