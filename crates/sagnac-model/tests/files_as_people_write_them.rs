//! Files of other tools as people write them: common idioms are read right, what cannot be read is refused by name and line,
//! and what is written for a tool is true of each axis.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac_model::export::{Format, export};
use sagnac_model::foreign::{Audit, Mistake, Verdict, audit, import};
use sagnac_model::{Entry, Error, Model};

const G: f64 = 9.80665;

fn model(text: &str) -> Model {
    Model::parse(text, "model.toml").unwrap()
}

fn exported(model: &Model, format: Format) -> String {
    String::from_utf8(export(model, format, 1.0).unwrap().bytes).unwrap()
}

fn imported(text: &str) -> Model {
    import(text.as_bytes(), "file.yaml", None, None)
        .unwrap()
        .model
}

fn near(model: &Model, path: &str, wanted: f64) {
    let found = model.largest(path.parse().unwrap());
    let found = found.unwrap_or_else(|| panic!("{path} is missing"));
    assert!((found / wanted - 1.0).abs() < 1e-12, "{path}: {found:e}");
}

fn refusal(text: &str) -> (String, String) {
    let error = import(text.as_bytes(), "file.yaml", None, None).unwrap_err();
    assert!(audit(text.as_bytes(), "file.yaml", None, Some(100.0), None).is_err());
    (error.to_string(), error.place().unwrap_or_default())
}

#[test]
fn gtsam_covariances_are_read_as_covariances() {
    let code = "import gtsam, numpy as np\ngyro_sigma = 1.6968e-4\n\
        params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.81)\n\
        params.setGyroscopeCovariance(gyro_sigma**2 * np.identity(3))\n\
        params.setAccelerometerCovariance(np.diag([4e-6, 4e-6, 4e-6]))\n\
        params.setBiasAccCovariance(np.eye(3)*9e-6)\nparams.setBiasOmegaCovariance(3.76e-10*np.eye(3))\n";
    let back = imported(code);
    near(&back, "gyro.noise.angle_random_walk", 1.6968e-4);
    near(&back, "accel.noise.velocity_random_walk", 2e-3);
    near(&back, "accel.noise.acceleration_random_walk", 3e-3);
    near(&back, "gyro.noise.rate_random_walk", 3.76e-10_f64.sqrt());
    let judged = audit(code.as_bytes(), "g.py", None, None, None).unwrap();
    assert!(
        judged
            .entries
            .iter()
            .all(|entry| entry.verdict != Verdict::Wrong)
    );
    // A name that the file gives no number is no 3 of identity(3).
    let (what, place) = refusal(&code.replace("gyro_sigma = 1.6968e-4", ""));
    assert!(
        what.contains("setGyroscopeCovariance") && what.contains("`gyro_sigma`"),
        "{what}"
    );
    assert_eq!(place, "file.yaml:4");
    // Corrected, the file reads back as the reference.
    let mut reference = Model::new("r");
    let path = "gyro.noise.angle_random_walk";
    let path: sagnac_model::ParameterPath = path.parse().unwrap();
    reference
        .set_at(path, Entry::of(3e-4, path.dimension()))
        .unwrap();
    let judged = audit(code.as_bytes(), "g.py", None, None, Some(&reference)).unwrap();
    let corrected = judged.corrected.unwrap();
    assert!(
        corrected.contains("np.eye(3) * 0.0003 ** 2)  # was gyro_sigma**2 * np.identity(3)\n"),
        "{corrected}"
    );
    near(&imported(&corrected), "gyro.noise.angle_random_walk", 3e-4);
}

const AXES: &str = r#"
name = "axes"
sample_rate = "100 Hz"
[gyro.noise]
angle_random_walk = ["0.3 deg/sqrt(h)", "0.4 deg/sqrt(h)", "0.2 deg/sqrt(h)"]
rate_random_walk = "60 deg/h/sqrt(h)"
[accel.noise]
velocity_random_walk = "0.04 m/s/sqrt(h)"
acceleration_random_walk = "1 mg/sqrt(h)"
"#;

#[test]
fn imu_utils_keeps_axes_and_its_stated_convention() {
    let wanted = model(AXES);
    let text = exported(&wanted, Format::ImuUtils);
    let back = imported(&text);
    let [x, y, z] = back.triad("gyro.noise.angle_random_walk").unwrap();
    let [a, b, c] = wanted.triad("gyro.noise.angle_random_walk").unwrap();
    for (got, want) in [(x, a), (y, b), (z, c)] {
        assert!((got / want - 1.0).abs() < 1e-14);
    }
    near(
        &back,
        "accel.noise.acceleration_random_walk",
        1e-3 * G / 60.0,
    );
    assert!(back.get("accel.bias.instability.allan_minimum").is_none());
    let judge = |text: &str| audit(text.as_bytes(), "u.yaml", None, None, Some(&wanted)).unwrap();
    let right = judge(&text);
    assert!(
        right
            .entries
            .iter()
            .all(|entry| entry.verdict == Verdict::Consistent)
    );
    // Every axis of a wrong file is corrected, the accelerometer's too.
    let larger = model(
        &AXES
            .replace("\"1 mg/sqrt(h)\"", "\"20 mg/sqrt(h)\"")
            .replace("\"60 deg", "\"3 deg"),
    );
    let corrected = judge(&exported(&larger, Format::ImuUtils))
        .corrected
        .unwrap();
    assert!(
        judge(&corrected)
            .entries
            .iter()
            .all(|entry| entry.verdict == Verdict::Consistent)
    );
    // Files of the original do not say it: the minimum of the Allan deviation.
    let original = text.replace("/sqrt(Hz)", "");
    assert!(
        imported(&original)
            .get("accel.bias.instability.allan_minimum.x")
            .is_some()
    );
}

#[test]
fn matlab_single_sided_density_is_larger_by_the_root_of_two() {
    let text = exported(&model(AXES), Format::Matlab);
    let double = imported(&text)
        .triad("gyro.noise.angle_random_walk")
        .unwrap();
    let single = imported(&text.replace("'double-sided'", "'single-sided'"));
    let single = single.triad("gyro.noise.angle_random_walk").unwrap();
    for axis in 0..3 {
        assert!((double[axis] / single[axis] - 2.0_f64.sqrt()).abs() < 1e-12);
    }
}

#[test]
fn comments_and_transposes_are_no_part_of_a_value() {
    let text = "accel = accelparams;\naccel.NoiseDensity = [1e-3 1e-3 2e-3]' % m/s^2/sqrt(Hz)\n\
        gyro = gyroparams;\ngyro.NoiseDensity = 1e-4 % (rad/s)/sqrt(Hz)\ngyro.RandomWalk = [1e-6; 1e-6; 1e-6];\n";
    let back = imported(text);
    near(&back, "accel.noise.velocity_random_walk", 2e-3);
    near(&back, "gyro.noise.angle_random_walk", 1e-4);
    near(&back, "gyro.noise.rate_random_walk", 1e-6);
    let text = "imu_err = {'gyro_arw': np.array([0.25, 0.25, 0.25]),  # deg/sqrt(h)\n'accel_vrw': np.array([0.03, 0.03, 0.03])}\n";
    near(
        &imported(text),
        "accel.noise.velocity_random_walk",
        0.03 / 60.0,
    );
}

#[test]
fn matlab_temperature_terms_are_about_25_degrees() {
    let warm = model(&format!(
        "{AXES}[gyro.g_sensitivity]\nmatrix = [[\"10 deg/h/g\", \"0 deg/h/g\", \"0 deg/h/g\"], [\"0 deg/h/g\", \"5 deg/h/g\", \"0 deg/h/g\"], [\"0 deg/h/g\", \"0 deg/h/g\", \"1 deg/h/g\"]]\n[gyro.bias]\nfixed = \"1 deg/s\"\n\
         temperature = [[\"0.1 deg/s/K\", \"0.1 deg/s/K\", \"0.1 deg/s/K\"]]\n\
         [gyro.scale_factor]\nfixed = \"1000 ppm\"\ntemperature = [[\"10 ppm/K\", \"10 ppm/K\", \"10 ppm/K\"]]\n"
    )
    .replace("name = \"axes\"", "name = \"axes\"\nreference_temperature = \"40 degC\""));
    let back = imported(&exported(&warm, Format::Matlab));
    let [had, has] = [&warm, &back].map(|model| model.to_core().unwrap());
    assert_eq!(has.reference_temperature_c, 25.0);
    // At 40 degC the tool must give the 1 deg/s of the model: 1 - 1.5 + 15 * 0.1.
    let at_40 = |fixed: f64, slope: f64| fixed + 15.0 * slope;
    for axis in 0..3 {
        let bias = at_40(
            has.gyro.bias.fixed[axis],
            has.gyro.bias.temperature.polynomial[0][axis],
        );
        assert!((bias - had.gyro.bias.fixed[axis]).abs() < 1e-15);
        let scale = at_40(
            has.gyro.scale_factor.fixed[axis],
            has.gyro.scale_factor.temperature.polynomial[0][axis],
        );
        assert!((scale - 1e-3).abs() < 1e-15);
        let [a, b] = [&had, &has].map(|core| core.gyro_g_sensitivity.matrix[axis][axis]);
        assert!((a / b - 1.0).abs() < 1e-12);
    }
}

fn kalibr(key: &str, value: &str) -> String {
    let mut text = String::from("rostopic: /imu\nupdate_rate: 200\n");
    for (name, number) in [
        ("accelerometer_noise_density", "0.01"),
        ("accelerometer_random_walk", "1.0e-4"),
        ("gyroscope_noise_density", "1.0e-4"),
        ("gyroscope_random_walk", "1.0e-6"),
    ] {
        let number = if name == key { value } else { number };
        text.push_str(&format!("{name}: {number}\n"));
    }
    text
}

#[test]
fn bad_values_are_refused_by_name_and_line() {
    let key = "accelerometer_noise_density";
    for value in [
        "abc",
        ".nan",
        "[0.1, 2]",
        "[0.1, 0.1, 0.1]",
        "0.01 m/s^2",
        "",
    ] {
        let (what, place) = refusal(&kalibr(key, value));
        assert!(what.contains(key), "{value}: {what}");
        assert_eq!(place, "file.yaml:3", "{value}: {what}");
    }
    let (what, place) = refusal(&kalibr("", "").replace("update_rate: 200", "update_rate: fast"));
    assert!(what.contains("`update_rate` is `fast`"), "{what}");
    assert_eq!(place, "file.yaml:2");
    let twice = kalibr("", "") + "accelerometer_noise_density: 0.02\n";
    let (what, place) = refusal(&twice);
    assert!(what.contains("stands twice"), "{what}");
    assert_eq!(place, "file.yaml:7");
    for (format, from, to) in [
        (Format::Px4, "CAL_ACC0_YOFF\t", "CAL_ACC0_YOFF\tx"),
        (
            Format::Basalt,
            "\"gyro_noise_std\": [",
            "\"gyro_noise_std\": [NaN, ",
        ),
        (Format::Pyins, "bias_sd=[", "bias_sd=[deg * "),
        (Format::Gazebo, "<stddev>", "<stddev>about "),
        (
            Format::Matlab,
            "gyro.NoiseDensity = [",
            "gyro.NoiseDensity = deg2rad(1) * [",
        ),
    ] {
        let whole = model(&format!("{AXES}[accel.bias]\nfixed = \"1 mg\"\n"));
        let text = exported(&whole, format);
        assert!(text.contains(from), "{}", format.name());
        let bad = text.replacen(from, to, 1);
        assert!(
            matches!(
                import(bad.as_bytes(), "f", Some(format), None),
                Err(Error::File { .. })
            ),
            "{}",
            format.name()
        );
    }
}

#[test]
fn what_kalibr_needs_and_what_is_not_read_is_said() {
    let short =
        "accelerometer_noise_density: 0.01\ngyroscope_noise_density: 1.0e-4\nupdate_rate: 200\n";
    let notes = import(short.as_bytes(), "k.yaml", None, None)
        .unwrap()
        .notes
        .join("; ");
    for key in [
        "rostopic",
        "accelerometer_random_walk",
        "gyroscope_random_walk",
    ] {
        assert!(notes.contains(key), "{notes}");
    }
    assert_eq!(
        audit(short.as_bytes(), "k.yaml", None, None, None)
            .unwrap()
            .notes
            .len(),
        1
    );
    assert!(
        audit(kalibr("", "").as_bytes(), "k", None, None, None)
            .unwrap()
            .notes
            .is_empty()
    );
    let block = kalibr("", "").replace('\n', "\n  ");
    let two = format!("imu0:\n  {block}\nimu1:\n  {block}\n");
    let notes = import(two.as_bytes(), "k.yaml", None, None).unwrap().notes;
    assert!(notes.iter().any(|note| note.contains("imu1")), "{notes:?}");
}

/// A model whose numbers have intervals of 0.15 %.
fn measured(gyro_n: f64, accel_n: f64, rate_hz: f64) -> Model {
    let mut model = Model::new("measured");
    model.set_sample_rate_hz(rate_hz).unwrap();
    for (path, value) in [
        ("gyro.noise.angle_random_walk", gyro_n),
        ("gyro.noise.rate_random_walk", 1e-6),
        ("accel.noise.velocity_random_walk", accel_n),
        ("accel.noise.acceleration_random_walk", 5e-5),
    ] {
        let path: sagnac_model::ParameterPath = path.parse().unwrap();
        let interval = [0.9985 * value, 1.0015 * value];
        let entry = Entry::estimate(value, 7.5e-4 * value, interval, path.dimension());
        model.set_at(path, entry).unwrap();
    }
    model
}

fn judged(values: [f64; 4], rate_hz: f64, reference: &Model) -> Audit {
    let [gyro_n, gyro_k, accel_n, accel_k] = values;
    let text = format!(
        "rostopic: /i\nupdate_rate: {rate_hz}\naccelerometer_noise_density: {accel_n:e}\naccelerometer_random_walk: {accel_k:e}\n\
         gyroscope_noise_density: {gyro_n:e}\ngyroscope_random_walk: {gyro_k:e}\n"
    );
    audit(text.as_bytes(), "k.yaml", None, None, Some(reference)).unwrap()
}

#[test]
fn the_ratio_tells_g_from_the_root_of_the_rate() {
    for rate_hz in [100.0, 200.0] {
        let n = 0.04 / 60.0;
        let reference = measured(1e-4, n, rate_hz);
        let entries = judged([1e-4, 1e-6, n / G, 5e-5], rate_hz, &reference).entries;
        let accel = entries
            .iter()
            .find(|e| e.key == "accelerometer_noise_density")
            .unwrap();
        assert_eq!(
            accel.likely_mistake,
            Some(Mistake::G),
            "{rate_hz} Hz: {}",
            accel.text
        );
        assert_eq!(accel.verdict, Verdict::Wrong);
    }
    // Neither is held: both are named, the first of the table leads.
    let reference = measured(1e-4, 2e-3, 100.0);
    let entries = judged([1e-4, 1e-6, 2e-3 * 0.106, 5e-5], 100.0, &reference).entries;
    let accel = entries
        .iter()
        .find(|e| e.key == "accelerometer_noise_density")
        .unwrap();
    assert_eq!(accel.likely_mistake, Some(Mistake::SqrtRate));
    assert!(
        accel.text.contains("root of the rate, or g and m/s^2"),
        "{}",
        accel.text
    );
}

#[test]
fn what_no_sensor_has_stays_wrong_with_a_reference() {
    let reference = measured(1e-4, 2e-3, 200.0);
    for entry in judged([-1e-4, 0.0, 67.98, 5e-5], 200.0, &reference).entries {
        let right = entry.key == "accelerometer_random_walk";
        let wanted = if right {
            Verdict::Consistent
        } else {
            Verdict::Wrong
        };
        assert_eq!(entry.verdict, wanted, "{}: {}", entry.key, entry.text);
        assert!(
            right || entry.text.contains("no sensor has that"),
            "{}",
            entry.text
        );
    }
}

#[test]
fn stabilities_are_read_back() {
    let wanted = model(&format!(
        "{AXES}[gyro.scale_factor]\nstability = \"100 ppm\"\n[accel.scale_factor]\nstability = \"200 ppm\"\n[accel.misalignment]\nstability = \"0.05 mrad\"\n"
    ));
    for format in [Format::KfGins, Format::Pyins] {
        let back = imported(&exported(&wanted, format));
        near(&back, "gyro.scale_factor.stability", 100e-6);
        near(&back, "accel.scale_factor.stability", 200e-6);
        if format == Format::Pyins {
            near(&back, "accel.misalignment.stability", 5e-5);
        }
    }
}

#[test]
fn autopilot_files_leave_out_what_the_model_lacks() {
    let gyro = model("name = \"g\"\n[gyro.bias]\nfixed = \"0.1 deg/s\"\n");
    for (format, accel) in [(Format::Px4, "CAL_ACC0_"), (Format::ArduPilot, "INS_ACC")] {
        let text = exported(&gyro, format);
        let lines = |start: &str| {
            text.lines()
                .filter(|line| !line.starts_with('#') && line.contains(start))
                .count()
        };
        assert_eq!(lines(accel), 0, "{text}");
        assert_eq!(lines("OFF"), 3, "{text}");
        assert!(
            text.contains("accelerometer: the model has no calibration"),
            "{text}"
        );
    }
    let scaled =
        model("name = \"s\"\n[accel.scale_factor]\nfixed = [\"50 %\", \"0 %\", \"0 %\"]\n");
    let remarks = export(&scaled, Format::ArduPilot, 1.0).unwrap().remarks;
    assert!(
        remarks.len() == 1 && remarks[0].starts_with("INS_ACCSCAL_X is 0.6667, outside 0.8 to 1.2"),
        "{remarks:?}"
    );
    let rows = model(
        "name = \"r\"\n[gyro.bias]\nfixed = \"1 deg/h\"\n[gyro.g_sensitivity]\nmatrix = [[\"10 deg/h/g\", \"1 deg/h/g\", \"2 deg/h/g\"], [\"3 deg/h/g\", \"10 deg/h/g\", \"4 deg/h/g\"], [\"5 deg/h/g\", \"6 deg/h/g\", \"10 deg/h/g\"]]\n\
         [accel.misalignment]\nfixed = { xy = \"1 mrad\", xz = \"-2 mrad\", yx = \"3 mrad\", yz = \"4 mrad\", zx = \"-5 mrad\", zy = \"6 mrad\" }\n",
    );
    // Row norms: sqrt(5^2 + 6^2) mrad at 1 g, sqrt(5^2 + 6^2 + 10^2) deg/h.
    let text = exported(&rows, Format::Px4);
    assert!(
        text.contains("left out: misalignment; the largest error that leaves at 1 g is 7.81 mg"),
        "{text}"
    );
    assert!(
        text.contains(
            "left out: g-sensitivity; the largest error that leaves at 1 g at rest is 12.69 deg/h"
        ),
        "{text}"
    );
}

#[test]
fn comments_are_true_of_each_axis() {
    let mixed = model(
        &AXES.replace(
            "rate_random_walk = \"60 deg/h/sqrt(h)\"\n",
            "gauss_markov = [{ sigma = [\"3 deg/h\", \"2 deg/h\", \"0 deg/h\"], correlation_time = \"300 s\" }]\n",
        ),
    );
    let text = exported(&mixed, Format::KfGins);
    assert!(
        text.contains("x, y: the Gauss-Markov term; z: not in the model"),
        "{text}"
    );
    let text = exported(&mixed, Format::Kalibr);
    assert!(
        text.contains("x, y: from the Gauss-Markov term, sigma sqrt(2/T_c); z: not in the model"),
        "{text}"
    );
}

#[test]
fn a_corrected_file_tells_what_it_said_before() {
    let wanted = model(AXES);
    let doubled = export(&wanted, Format::KfGins, 3.0).unwrap().bytes;
    let corrected = audit(&doubled, "kf.yaml", None, None, Some(&wanted))
        .unwrap()
        .corrected
        .unwrap();
    let line = corrected
        .lines()
        .find(|line| line.trim_start().starts_with("arw:"))
        .unwrap();
    assert!(
        line.contains("]  # was [0.9") && line.contains("of which the comment above speaks"),
        "{line}"
    );
    near(
        &imported(&corrected),
        "gyro.noise.angle_random_walk",
        0.4_f64.to_radians() / 60.0,
    );
}

#[test]
fn gtsam_of_any_version_runs_the_file() {
    let text = exported(&model(AXES), Format::Gtsam);
    let line = text
        .lines()
        .position(|line| line.contains("params.setBiasAccOmegaInit("))
        .unwrap();
    let guard = text.lines().nth(line - 1).unwrap();
    assert_eq!(guard.trim(), "if hasattr(params, \"setBiasAccOmegaInit\"):");
}
