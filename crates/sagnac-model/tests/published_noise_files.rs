//! Noise files as published with data sets and tools, and files made from models: exported, read back, judged.
#![allow(
    clippy::large_stack_arrays,
    clippy::approx_constant,
    reason = "tables of published digits"
)]
#![allow(clippy::unwrap_used, reason = "tests")]

use proptest::prelude::*;
use sagnac_model::export::{Format, export};
use sagnac_model::foreign::{Mistake, Verdict, audit, import};
use sagnac_model::{Catalogue, Entry, Model};

const EXAMPLE: &str = r#"
name = "Unit 7"
sample_rate = "200 Hz"
reference_temperature = "25 degC"
temperature_range = ["-20 degC", "70 degC"]
[gyro]
range = "450 deg/s"
resolution = "0.01 deg/s"
[gyro.bias]
fixed = ["12 deg/h", "-5 deg/h", "3 deg/h"]
temperature = [["0.4 deg/h/K", "-0.2 deg/h/K", "0.1 deg/h/K"], ["0.01 deg/h/K^2", "0 deg/h/K^2", "0 deg/h/K^2"]]
stability = "20 deg/h"
[gyro.scale_factor]
fixed = ["300 ppm", "-150 ppm", "80 ppm"]
stability = "100 ppm"
[gyro.misalignment]
fixed = { xy = "0.5 mrad", xz = "-0.3 mrad", yx = "0.2 mrad", yz = "0.1 mrad", zx = "-0.4 mrad", zy = "0.6 mrad" }
[gyro.g_sensitivity]
matrix = [["10 deg/h/g", "1 deg/h/g", "0 deg/h/g"], ["0 deg/h/g", "12 deg/h/g", "0 deg/h/g"], ["0 deg/h/g", "0 deg/h/g", "8 deg/h/g"]]
[gyro.noise]
angle_random_walk = ["0.3 deg/sqrt(h)", "0.31 deg/sqrt(h)", "0.29 deg/sqrt(h)"]
rate_random_walk = "1.5 deg/h/sqrt(h)"
gauss_markov = [{ sigma = "3 deg/h", correlation_time = "300 s" }]
[accel.bias]
fixed = ["1 mg", "2 mg", "-3 mg"]
stability = "0.5 mg"
[accel.scale_factor]
fixed = ["1000 ppm", "-500 ppm", "200 ppm"]
[accel.misalignment]
fixed = { xy = "1 mrad", xz = "-0.7 mrad", yx = "0.4 mrad", yz = "0.2 mrad", zx = "-0.9 mrad", zy = "0.3 mrad" }
[accel.noise]
velocity_random_walk = "0.03 m/s/sqrt(h)"
acceleration_random_walk = "0.5 mg/sqrt(h)"
gauss_markov = [{ sigma = "20 ug", correlation_time = "500 s" }]
"#;

fn example() -> Model {
    Model::parse(EXAMPLE, "unit7.toml").unwrap()
}

fn largest(model: &Model, path: &str) -> Option<f64> {
    model.largest(path.parse().unwrap())
}

fn text(format: Format) -> String {
    String::from_utf8(export(&example(), format, 1.0).unwrap().bytes).unwrap()
}

#[test]
fn every_format_reads_back_what_it_holds() {
    let model = example();
    for format in Format::ALL {
        let exported = export(&model, format, 1.0).unwrap();
        let back = import(&exported.bytes, "file", None, Some(200.0))
            .unwrap_or_else(|error| panic!("{}: {error}", format.name()));
        // OpenVINS, Kalibr's result and the others are known by their keys alone.
        assert_eq!(back.format, format);
        let noiseless = matches!(format, Format::Px4 | Format::ArduPilot);
        for (path, holds) in [
            ("gyro.noise.angle_random_walk", !noiseless),
            ("accel.noise.velocity_random_walk", !noiseless),
            ("gyro.noise.rate_random_walk", !noiseless),
        ] {
            let Some(found) = largest(&back.model, path) else {
                let without = matches!(
                    format,
                    Format::RosImu | Format::Gazebo | Format::GnssInsSim | Format::KfGins
                );
                assert!(!holds || without, "{} lacks {path}", format.name());
                continue;
            };
            let wanted = largest(&model, path).unwrap();
            // Written with 17 digits, two products.
            assert!(
                (found / wanted - 1.0).abs() < 1e-14,
                "{} {path}: {found:e} {wanted:e}",
                format.name()
            );
        }
    }
}

#[test]
fn deterministic_terms_come_back() {
    let model = example();
    let wanted = model.to_core().unwrap();
    for format in [Format::Px4, Format::ArduPilot] {
        let back = import(
            &export(&model, format, 1.0).unwrap().bytes,
            "p",
            None,
            Some(200.0),
        )
        .unwrap()
        .model
        .to_core()
        .unwrap();
        for axis in 0..3 {
            assert!((back.accel.bias.fixed[axis] - wanted.accel.bias.fixed[axis]).abs() < 1e-15);
            assert!(
                (back.accel.scale_factor.fixed[axis] - wanted.accel.scale_factor.fixed[axis]).abs()
                    < 1e-15
            );
            for power in 0..2 {
                let [a, b] =
                    [&back, &wanted].map(|core| core.gyro.bias.temperature.polynomial[power][axis]);
                assert!(
                    (a - b).abs() < 1e-18,
                    "{} {power} {axis}: {a:e} {b:e}",
                    format.name()
                );
            }
        }
    }
    for format in [Format::Matlab, Format::Pyins] {
        let back = import(
            &export(&model, format, 1.0).unwrap().bytes,
            "p",
            None,
            Some(200.0),
        )
        .unwrap()
        .model
        .to_core()
        .unwrap();
        assert!((back.gyro.misalignment.elements.to_array()[5] - 0.6e-3).abs() < 1e-15);
        assert!((back.accel.scale_factor.fixed[1] + 500e-6).abs() < 1e-15);
    }
    // In the tool's frame: the same |M f| for every f, since the frames differ by a rotation.
    for format in [Format::KalibrResult, Format::OpenVins, Format::Basalt] {
        let back = import(
            &export(&model, format, 1.0).unwrap().bytes,
            "p",
            None,
            Some(200.0),
        )
        .unwrap()
        .model;
        let elements = back
            .to_core()
            .unwrap()
            .accel
            .misalignment
            .elements
            .to_array();
        assert!(
            elements[0].abs() < 1e-15 && elements[1].abs() < 1e-15 && elements[3].abs() < 1e-15,
            "{elements:?}"
        );
        let volume = |model: &Model| {
            let core = model.to_core().unwrap();
            let m = core.gyro.misalignment.elements.to_array();
            let s = core.gyro.scale_factor.fixed.map(|s| 1.0 + s);
            s[0] * (s[1] * s[2] - m[3] * m[5]) - m[0] * (m[2] * s[2] - m[3] * m[4])
                + m[1] * (m[2] * m[5] - s[1] * m[4])
        };
        assert!((volume(&back) / volume(&model) - 1.0).abs() < 1e-14);
    }
}

#[test]
fn exports_are_as_they_were() {
    for format in [
        Format::Kalibr,
        Format::OpenVins,
        Format::Gazebo,
        Format::Px4,
        Format::Gtsam,
        Format::Pyins,
        Format::Matlab,
    ] {
        insta::assert_snapshot!(format.name(), text(format));
    }
}

#[test]
fn inflation_multiplies_noise_only_and_is_said() {
    let plain = import(
        &export(&example(), Format::Basalt, 1.0).unwrap().bytes,
        "a",
        None,
        None,
    )
    .unwrap()
    .model;
    let exported = export(&example(), Format::Basalt, 5.0).unwrap();
    let inflated = import(&exported.bytes, "a", None, Some(200.0))
        .unwrap()
        .model;
    let ratio = |path: &str| largest(&inflated, path).unwrap() / largest(&plain, path).unwrap();
    assert!((ratio("gyro.noise.angle_random_walk") - 5.0).abs() < 1e-12);
    assert!((ratio("accel.noise.acceleration_random_walk") - 5.0).abs() < 1e-12);
    assert!((ratio("accel.bias.x") - 1.0).abs() < 1e-12);
    assert!(
        exported
            .remarks
            .iter()
            .any(|remark| remark.contains("inflated by 5 from"))
    );
    assert!(export(&example(), Format::Kalibr, 0.0).is_err());
}

#[test]
fn what_a_format_needs_is_named() {
    let bare = Model::parse(
        "name = \"A\"\n[gyro.noise]\nangle_random_walk = \"0.3 deg/sqrt(h)\"",
        "a.toml",
    )
    .unwrap();
    let error = export(&bare, Format::Kalibr, 1.0).unwrap_err();
    assert!(
        error.to_string().contains("sample rate")
            || error.to_string().contains("velocity_random_walk"),
        "{error}"
    );
    let mut walkless = example();
    for sensor in ["gyro.noise.rate", "accel.noise.acceleration"] {
        walkless.remove(format!("{sensor}_random_walk").parse().unwrap());
    }
    // From the Gauss–Markov term: K = σ√(2/T_c).
    let back = import(
        &export(&walkless, Format::Kalibr, 1.0).unwrap().bytes,
        "k",
        None,
        Some(200.0),
    )
    .unwrap()
    .model;
    let sigma = largest(&walkless, "gyro.noise.gauss_markov.1.sigma").unwrap();
    assert!(
        (largest(&back, "gyro.noise.rate_random_walk").unwrap()
            / (sigma * (2.0_f64 / 300.0).sqrt())
            - 1.0)
            .abs()
            < 1e-14
    );
    // From flicker: the catalogue's ADIS16470 has no K.
    let sheet = Catalogue::embedded().find("ADIS16470").unwrap();
    let back = import(
        &export(&sheet, Format::OrbSlam3, 1.0).unwrap().bytes,
        "o",
        None,
        Some(200.0),
    )
    .unwrap()
    .model;
    let (n, floor) = (
        largest(&sheet, "gyro.noise.angle_random_walk").unwrap(),
        largest(&sheet, "gyro.bias.instability.allan_minimum").unwrap(),
    );
    assert!(
        (largest(&back, "gyro.noise.rate_random_walk").unwrap()
            / (3.0_f64.sqrt() * floor * floor / n)
            - 1.0)
            .abs()
            < 1e-12
    );
}

fn kalibr(gyro: [f64; 2], accel: [f64; 2]) -> String {
    format!(
        "accelerometer_noise_density: {:e}\naccelerometer_random_walk: {:e}\ngyroscope_noise_density: {:e}\ngyroscope_random_walk: {:e}\nupdate_rate: 200.0\nrostopic: /imu0\n",
        accel[0], accel[1], gyro[0], gyro[1]
    )
}

/// Verdict and mistake in the order gyro N, gyro K, accel N, accel K.
fn verdicts(text: &str, rate_hz: Option<f64>) -> Vec<(Verdict, Option<Mistake>)> {
    let judged = audit(text.as_bytes(), "imu.yaml", None, rate_hz, None).unwrap();
    let mut entries = judged.entries;
    entries.sort_by_key(|entry| (entry.sensor, entry.quantity.key() == "random_walk"));
    entries
        .iter()
        .map(|entry| (entry.verdict, entry.likely_mistake))
        .collect()
}

#[test]
fn published_files_get_their_verdicts() {
    use Verdict::{Consistent, Suspicious, Wrong};
    let fine = (Consistent, None);
    let copied = (Suspicious, Some(Mistake::InstabilityAsWalk));
    let inflated = (Suspicious, Some(Mistake::Inflated));
    let wrong = (Wrong, None);
    let cases = [
        (
            "EuRoC",
            [1.6968e-4, 1.9393e-5],
            [2.0e-3, 3.0e-3],
            [fine, copied, fine, inflated],
        ),
        (
            "EuRoC Kimera",
            [1.6968e-4, 1.9393e-5],
            [2.0e-3, 3.0e-2],
            [fine, copied, fine, wrong],
        ),
        (
            "TUM-VI",
            [1.6e-4, 2.2e-5],
            [2.8e-3, 8.6e-4],
            [fine, fine, fine, inflated],
        ),
        (
            "KAIST urban",
            [1.7453e-4, 1e-5],
            [5.886e-3, 1e-4],
            [fine, fine, fine, fine],
        ),
        (
            "D455 measured",
            [1.0272e-4, 1.1106e-6],
            [1.0382e-3, 4.1328e-5],
            [fine, fine, fine, fine],
        ),
        (
            "D455 Kimera",
            [0.187, 0.0266],
            [0.186, 0.0433],
            [wrong, wrong, wrong, wrong],
        ),
        (
            "UZH-FPV",
            [0.05, 4.0e-5],
            [0.1, 2e-3],
            [wrong, fine, wrong, fine],
        ),
        (
            "ironsides",
            [1.1187e-4, 8.9975e-7],
            [2.7053e-3, 1.3055e-4],
            [fine, fine, fine, fine],
        ),
    ];
    for (name, gyro, accel, wanted) in cases {
        assert_eq!(verdicts(&kalibr(gyro, accel), None), wanted, "{name}");
    }
    let vins = "%YAML:1.0\nacc_n: 0.1\ngyr_n: 0.01\nacc_w: 0.001\ngyr_w: 0.0001\ng_norm: 9.81\n";
    assert_eq!(verdicts(vins, Some(200.0)), [fine; 4]);
    let judged = audit(vins.as_bytes(), "v.yaml", None, Some(200.0), None).unwrap();
    let meaning = |key: &str| {
        judged
            .entries
            .iter()
            .find(|entry| entry.key == key)
            .unwrap()
            .meaning
            .unwrap()
    };
    assert!(
        (meaning("gyr_n") - 5.0e-4).abs() < 1e-12 && (meaning("gyr_w") - 7.071e-6).abs() < 1e-9
    );
    let rateless = audit(vins.as_bytes(), "v.yaml", None, None, None).unwrap();
    assert!(
        rateless
            .entries
            .iter()
            .all(|entry| entry.verdict == Verdict::Unknown && entry.meaning.is_none())
    );
}

/// A model as a log gives it: 1 % intervals.
fn measured() -> Model {
    let mut model = Model::new("measured");
    model.set_sample_rate_hz(200.0).unwrap();
    for (path, value) in [
        ("gyro.noise.angle_random_walk", 2.0e-4),
        ("gyro.noise.rate_random_walk", 1.0e-6),
        ("gyro.bias.instability.coefficient", 3.0e-5),
        ("accel.noise.velocity_random_walk", 1.9e-3),
        ("accel.noise.acceleration_random_walk", 5.0e-5),
    ] {
        let path: sagnac_model::ParameterPath = path.parse().unwrap();
        model
            .set_at(
                path,
                Entry::estimate(
                    value,
                    value / 200.0,
                    [0.99 * value, 1.01 * value],
                    path.dimension(),
                ),
            )
            .unwrap();
    }
    model
}

#[test]
fn planted_mistakes_are_named_and_right_files_are_not() {
    let model = measured();
    let right = ([2.0e-4, 1.0e-6], [1.9e-3, 5.0e-5]);
    let judge = |gyro: [f64; 2], accel: [f64; 2]| {
        let judged = audit(
            kalibr(gyro, accel).as_bytes(),
            "imu.yaml",
            None,
            None,
            Some(&model),
        )
        .unwrap();
        judged
            .entries
            .into_iter()
            .map(|entry| (entry.key, entry.likely_mistake, entry.verdict))
            .collect::<Vec<_>>()
    };
    assert!(
        judge(right.0, right.1)
            .iter()
            .all(|(_, mistake, verdict)| mistake.is_none() && *verdict == Verdict::Consistent)
    );
    let root = 200.0_f64.sqrt();
    let gyro_n = |value: f64| judge([value, 1.0e-6], right.1)[0].1;
    let gyro_k = |value: f64| judge([2.0e-4, value], right.1)[1].1;
    let accel_n = |value: f64| judge(right.0, [value, 5.0e-5])[2].1;
    assert_eq!(gyro_n(2.0e-4 * root), Some(Mistake::PerSample));
    assert_eq!(gyro_n(2.0e-4 / root), Some(Mistake::SqrtRate));
    assert_eq!(gyro_n(2.0e-4 * 57.2958), Some(Mistake::Degrees));
    assert_eq!(gyro_n(2.0e-4 * 1.4142), Some(Mistake::Sqrt2));
    assert_eq!(gyro_n(4.0e-8), Some(Mistake::Variance));
    assert_eq!(gyro_n(2.0e-4 * 5.0), Some(Mistake::Inflated));
    assert_eq!(gyro_k(3.0e-5), Some(Mistake::InstabilityAsWalk));
    assert_eq!(gyro_k(3.0e-5 * 0.664), Some(Mistake::InstabilityAsWalk));
    assert_eq!(gyro_k(1.0e-6 * root), Some(Mistake::PerSample));
    assert_eq!(accel_n(1.9e-3 / 9.80665), Some(Mistake::G));
    let wrong = kalibr([2.8e-3, 1.0e-6], right.1);
    let judged = audit(wrong.as_bytes(), "imu.yaml", None, None, Some(&model)).unwrap();
    let corrected = judged.corrected.unwrap();
    assert!(
        corrected.contains("rostopic: /imu0")
            && corrected.contains("gyroscope_noise_density: 0.0002  # was 2.8e-3\n"),
        "{corrected}"
    );
    let again = audit(corrected.as_bytes(), "imu.yaml", None, None, Some(&model)).unwrap();
    assert!(
        again
            .entries
            .iter()
            .all(|entry| entry.verdict == Verdict::Consistent)
    );
}

#[test]
fn imu_utils_is_read_both_ways() {
    let model = measured();
    let file = |n: f64| {
        format!(
            "%YAML:1.0\n---\ntype: IMU\nGyr:\n   unit: \" rad/s\"\n   avg-axis:\n      gyr_n: {n:e}\n      gyr_w: 1.99e-05\n"
        )
    };
    for n in [2.0e-4, 2.0e-4 * 200.0_f64.sqrt()] {
        let judged = audit(file(n).as_bytes(), "imu.yaml", None, None, Some(&model)).unwrap();
        assert_eq!(judged.format, Format::ImuUtils);
        assert!(
            judged
                .entries
                .iter()
                .all(|entry| entry.verdict == Verdict::Consistent),
            "{judged:?}"
        );
    }
}

#[test]
fn hostile_files_are_refused() {
    for bytes in [
        &b""[..],
        b"{",
        b"\xff\xfe\x00",
        b"<imu><",
        &[b'['; 100_000],
        &[b' '; 100_000],
        b"gyro_arw = [nan]",
        b"acc_n: 1e999",
    ] {
        assert!(import(bytes, "x", None, None).is_err());
        for format in Format::ALL {
            let _ = import(bytes, "x", Some(format), None);
            let _ = audit(bytes, "x", Some(format), Some(100.0), None);
        }
    }
    let nested: String = (0..5000)
        .map(|depth| format!("{}a:\n", " ".repeat(depth.min(300))))
        .collect();
    assert!(import(nested.as_bytes(), "x", None, None).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Mutated files are read or refused, never more.
    #[test]
    fn mutated_files_never_panic(which in 0..Format::ALL.len(), at in any::<prop::sample::Index>(), with in any::<u8>(), cut in any::<prop::sample::Index>()) {
        let format = Format::ALL[which];
        let mut bytes = export(&example(), format, 2.0).unwrap().bytes;
        let place = at.index(bytes.len());
        bytes[place] = with;
        let _ = import(&bytes, "x", None, None);
        let _ = audit(&bytes, "x", Some(format), None, Some(&measured()));
        bytes.truncate(cut.index(bytes.len()));
        let _ = import(&bytes, "x", Some(format), None);
    }
}
