//! The emitted C and Rust, compiled and run against the library: 20 models, both precisions,
//! the flags of C, thousands of random readings.
//!
//! `SAGNAC_EMIT_READINGS=1000000` runs a million readings a model in place of 20 000.
//! Skipped where there is no gcc (rustc).
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    clippy::field_reassign_with_default,
    reason = "tests"
)]

#[path = "../../sagnac-core/tests/common/mod.rs"]
mod common;

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use common::models;
use common::random::{Rng, inside, random_model, truth_within};
use sagnac_core::{Compensation, Measurement, Output, Real, SensorModel, TemperatureSpline};
use sagnac_model::emit::{self, EmitRequest, EmittedFile, Precision};

const FLAGS: [&str; 6] = [
    "-std=c99",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-O2",
];

fn has(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok();
    if !found {
        eprintln!("skipped: no {program} here");
    }
    found
}

fn write(folder: &Path, files: &[EmittedFile]) {
    for file in files {
        fs::write(folder.join(&file.name), &file.text).unwrap();
    }
}

fn run(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{command:?}\n{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn request(model: &SensorModel<f64>, precision: Precision) -> EmitRequest<'_> {
    EmitRequest {
        name: "a */ model ??/",
        model,
        dt_s: 0.01,
        precision,
        held: &[],
    }
}

/// Twenty models: the example, the consumer part, q near 0.3, polynomial, spline, no range,
/// increments, linear, perfect, and random ones.
fn models_of_all_kinds() -> Vec<SensorModel<f64>> {
    let mut all = vec![
        models::example(),
        models::consumer(),
        SensorModel::default(),
    ];
    let mut near = models::consumer();
    let bound = |m: &SensorModel<f64>| *Compensation::new(m, 0.01).unwrap().bound().unwrap();
    while bound(&near).q < 0.29 {
        for triad in [&mut near.gyro, &mut near.accel] {
            triad.nonlinearity.cubic = triad.nonlinearity.cubic.map(|k| k * 1.02);
            triad.scale_factor.fixed = [0.0; 3];
            triad.misalignment.elements = sagnac_core::OffDiagonal::default();
            triad.cross_axis.elements = sagnac_core::OffDiagonal::default();
        }
    }
    assert!(bound(&near).is_inside());
    all.push(near);
    let mut spline = models::example();
    spline.temperature_range_c = None;
    for (triad, unit) in [(&mut spline.gyro, 1e-3), (&mut spline.accel, 1e-2)] {
        let knots = [-18.0, 5.0, 30.0, 74.0];
        let values = [
            [1.0, 0.0, 2.0],
            [0.0, -1.0, 1.0],
            [0.5, 0.0, 0.0],
            [2.0, 1.0, -1.0],
        ];
        for of in [
            &mut triad.bias.temperature,
            &mut triad.scale_factor.temperature,
        ] {
            of.polynomial = [[0.0; 3]; 8];
            of.spline = TemperatureSpline::new(&knots, &values.map(|v| v.map(|x| x * unit))).ok();
        }
    }
    all.push(spline);
    let mut unstated = models::example();
    unstated.temperature_range_c = None;
    all.push(unstated);
    let mut unranged = models::consumer();
    unranged.gyro.range.limit = [f64::INFINITY; 3];
    unranged.accel.range.limit = [f64::INFINITY; 3];
    all.push(unranged);
    let mut increments = models::example();
    increments.gyro.resolution.lsb = [1e-6; 3];
    increments.gyro.resolution.output = Output::Increment;
    all.push(increments);
    let mut linear = SensorModel::default();
    linear.gyro = models::consumer().gyro;
    linear.gyro.nonlinearity = sagnac_core::Nonlinearity::default();
    linear.gyro.asymmetry = sagnac_core::Asymmetry::default();
    linear.temperature_range_c = Some([-10.0, 50.0]);
    all.push(linear);
    let mut rng = Rng::new(6);
    while all.len() < 20 {
        let model = random_model(&mut rng);
        if inside(&model) {
            all.push(model);
        }
    }
    all
}

/// A program that corrects readings from standard input: ten numbers in, six and the flags out.
fn driver(p: &str) -> String {
    let real = if p == "f32" { "float" } else { "double" };
    format!(
        "#include \"sagnac_correct_{p}.h\"
#include <stdio.h>
int main(void)
{{
    {real} v[10];
    while (fread(v, sizeof v, 1, stdin) == 1) {{
        sagnac_raw_{p} raw;
        sagnac_corrected_{p} out;
        int k;
        for (k = 0; k < 3; k++) {{
            raw.gyro[k] = v[k];
            raw.accel[k] = v[3 + k];
            raw.gyro_rate[k] = v[6 + k];
        }}
        raw.temperature = v[9];
        sagnac_correct_{p}(&raw, &out);
        fwrite(out.gyro, sizeof out.gyro, 1, stdout);
        fwrite(out.accel, sizeof out.accel, 1, stdout);
        fwrite(&out.flags, sizeof out.flags, 1, stdout);
    }}
    return 0;
}}
"
    )
}

fn bytes<T: Real>(x: T) -> Vec<u8> {
    if size_of::<T>() == 4 {
        (x.to_f64() as f32).to_ne_bytes().to_vec()
    } else {
        x.to_f64().to_ne_bytes().to_vec()
    }
}

fn value(bytes: &[u8]) -> f64 {
    match bytes.len() {
        4 => f64::from(f32::from_ne_bytes(bytes.try_into().unwrap())),
        _ => f64::from_ne_bytes(bytes.try_into().unwrap()),
    }
}

fn compare<T: Real>(folder: &Path, model: &SensorModel<f64>, p: &str, seed: u64, allowed: f64) {
    let readings: usize = std::env::var("SAGNAC_EMIT_READINGS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(20_000);
    let converted = model.convert::<T>();
    let inverse = Compensation::new(&converted, T::from_f64(0.01)).unwrap();
    let forward = Measurement::new(&converted);
    // Far outside, the rounds of some models run off to infinity.
    let huge = T::from_f64(if size_of::<T>() == 4 { 1e30 } else { 1e200 });
    let mut rng = Rng::new(seed);
    let (mut raws, mut input) = (Vec::new(), Vec::new());
    for i in 0..readings {
        let truth = truth_within(&mut rng, model);
        let v = |v: [f64; 3]| v.map(T::from_f64);
        let mut raw = forward.corrupt(&sagnac_core::Truth {
            specific_force: v(truth.specific_force),
            angular_rate: v(truth.angular_rate),
            angular_acceleration: v(truth.angular_acceleration),
            temperature_c: T::from_f64(truth.temperature_c),
        });
        match i % 50 {
            1 => raw.gyro[i % 3] = T::NAN,
            2 => raw.accel[i % 3] = T::INFINITY,
            3 => raw.temperature_c = T::NAN,
            4 => raw.temperature_c = T::from_f64(rng.uniform(-100.0, 200.0)),
            5 => raw.gyro = raw.gyro.map(|x| x * T::from_f64(3.0)),
            6 => raw.accel[0] = T::from_f64(rng.uniform(-1000.0, 1000.0)),
            7 => raw.gyro_rate[1] = T::NAN,
            8 => raw.gyro[i % 3] = huge,
            9 => raw.accel[i % 3] = -huge,
            _ => {}
        }
        for x in raw.gyro.iter().chain(&raw.accel).chain(&raw.gyro_rate) {
            input.extend(bytes(*x));
        }
        input.extend(bytes(raw.temperature_c));
        raws.push((raw, truth, !(1..=9).contains(&(i % 50))));
    }
    let mut child = Command::new(folder.join(format!("driver_{p}")))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let feed = std::thread::spawn(move || stdin.write_all(&input).unwrap());
    let output = child.wait_with_output().unwrap().stdout;
    feed.join().unwrap();
    let width = size_of::<T>();
    assert_eq!(output.len(), readings * (6 * width + 4));
    for ((raw, truth, is_whole), out) in raws.iter().zip(output.chunks_exact(6 * width + 4)) {
        let want = inverse.correct(raw);
        let flags = u32::from_ne_bytes(out[6 * width..].try_into().unwrap());
        assert_eq!(flags, want.flags, "{raw:?}");
        for k in 0..6 {
            let got = value(&out[k * width..(k + 1) * width]);
            let (want, truth, y) = if k < 3 {
                (want.gyro[k], truth.angular_rate, raw.gyro)
            } else {
                (want.accel[k - 3], truth.specific_force, raw.accel)
            };
            if want.to_f64().is_nan() {
                assert!(got.is_nan());
                assert_ne!(flags & sagnac_core::flags::NOT_FINITE, 0, "{raw:?}");
                continue;
            }
            assert!(want.to_f64().is_finite(), "{raw:?}");
            let s = truth
                .iter()
                .copied()
                .chain(y.map(Real::to_f64))
                .fold(want.to_f64().abs(), |m, x| m.max(x.abs()));
            assert!(
                (got - want.to_f64()).abs() <= allowed * s,
                "seed {seed} {p} k {k} flags {flags}: {got} {want:?} {raw:?}"
            );
            if flags == 0 && *is_whole {
                let truth = T::from_f64(truth[k % 3]).to_f64();
                assert!((got - truth).abs() <= allowed * s, "{got} {truth} {raw:?}");
            }
        }
    }
}

#[test]
fn emitted_c_equals_the_library_for_twenty_models() {
    if !has("gcc") {
        return;
    }
    for (i, model) in models_of_all_kinds().iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        for (p, precision) in [("f64", Precision::F64), ("f32", Precision::F32)] {
            let files = emit::c(&request(model, precision)).unwrap();
            assert_eq!(files.len(), 4);
            write(at, &files);
            fs::write(at.join("driver.c"), driver(p)).unwrap();
            let promotion: &[&str] = if p == "f32" {
                &["-Wdouble-promotion"]
            } else {
                &[]
            };
            for main in [
                format!("sagnac_correct_{p}_test.c"),
                format!("sagnac_correct_{p}_example.c"),
                "driver.c".to_owned(),
            ] {
                let program = at.join(
                    main.replace(".c", "")
                        .replace("driver", &format!("driver_{p}")),
                );
                run(Command::new("gcc")
                    .args(FLAGS)
                    .args(promotion)
                    .arg("-o")
                    .arg(&program)
                    .arg(at.join(&main))
                    .arg(at.join(format!("sagnac_correct_{p}.c"))));
                if main != "driver.c" {
                    run(&mut Command::new(&program));
                }
            }
        }
        compare::<f64>(at, model, "f64", 100 + i as u64, 1e-12);
        compare::<f32>(at, model, "f32", 200 + i as u64, 2.0_f64.powi(-18));
        // Both precisions in one program.
        fs::write(
            at.join("both.c"),
            "#include \"sagnac_correct_f32.h\"\n#include \"sagnac_correct_f64.h\"\nint main(void)\n{\n    sagnac_raw_f32 a = {{0}, {0}, {0}, 25.0f};\n    sagnac_raw_f64 b = {{0}, {0}, {0}, 25.0};\n    sagnac_corrected_f32 c;\n    sagnac_corrected_f64 d;\n    sagnac_correct_f32(&a, &c);\n    sagnac_correct_f64(&b, &d);\n    return (c.flags | d.flags) > 31u;\n}\n",
        )
        .unwrap();
        let both = at.join("both");
        run(Command::new("gcc").args(FLAGS).arg("-o").arg(&both).args(
            ["both.c", "sagnac_correct_f32.c", "sagnac_correct_f64.c"].map(|name| at.join(name)),
        ));
        run(&mut Command::new(&both));
    }
}

#[test]
fn emitted_rust_compiles_without_a_warning_and_passes_its_cases() {
    if !has("rustc") {
        return;
    }
    for model in models_of_all_kinds().iter().take(10) {
        for precision in [Precision::F64, Precision::F32] {
            let folder = tempfile::tempdir().unwrap();
            let at = folder.path();
            write(at, &emit::rust(&request(model, precision)).unwrap());
            let rustc = || {
                let mut command = Command::new("rustc");
                command
                    .current_dir(at)
                    .args(["--edition", "2021", "-D", "warnings", "-O"]);
                command
            };
            run(rustc().args(["--crate-type", "lib", "sagnac_correct.rs"]));
            run(rustc().args([
                "sagnac_correct_example.rs",
                "--extern",
                "sagnac_correct=libsagnac_correct.rlib",
            ]));
            run(&mut Command::new(at.join("sagnac_correct_example")));
            run(rustc().args(["--test", "sagnac_correct.rs", "-o", "cases"]));
            run(&mut Command::new(at.join("cases")));
        }
    }
}

#[test]
fn outside_the_bound_nothing_is_emitted() {
    let mut model = models::consumer();
    model.gyro.nonlinearity.cubic = model.gyro.nonlinearity.cubic.map(|k| k * 10.0);
    assert!(emit::c(&request(&model, Precision::F64)).is_err());
    model.gyro.scale_factor.fixed = [-1.0; 3];
    assert!(emit::rust(&request(&model, Precision::F32)).is_err());
}

#[test]
fn terms_held_at_zero_are_named_in_the_comments() {
    let model = models::example();
    let held = [
        "gyro.scale_factor.x".to_owned(),
        "accel.axis_offset.xy".to_owned(),
    ];
    let request = EmitRequest {
        held: &held,
        ..request(&model, Precision::F64)
    };
    for files in [emit::c(&request).unwrap(), emit::rust(&request).unwrap()] {
        let text = &files[0].text;
        assert!(text.contains("held at zero in the calibration"), "{text}");
        assert!(
            text.contains("gyro.scale_factor.x, accel.axis_offset.xy"),
            "{text}"
        );
    }
}
