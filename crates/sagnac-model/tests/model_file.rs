//! The model file of the contract: read, written without loss, refused where it is wrong.
#![allow(clippy::unwrap_used, reason = "tests")]

use proptest::prelude::*;
use sagnac_core::Sensor;
use sagnac_model::units::Dimension;
use sagnac_model::{Calibration, Entry, FLICKER_FLOOR, Model, ParameterPath, Process, ThermalTerm};

const EXAMPLE: &str = include_str!("data/example.toml");

fn example() -> Model {
    Model::parse(EXAMPLE, "imu.toml").unwrap()
}

#[test]
fn the_example_of_the_contract_reads() {
    let model = example();
    assert_eq!(model.name(), "Example MEMS IMU");
    assert_eq!(model.sample_rate_hz(), Some(200.0));
    let deg_h = std::f64::consts::PI / 180.0 / 3600.0;
    let bias = model.triad("gyro.bias").unwrap();
    // One rounding in the reader, two here.
    assert!((bias[1] + 5.0 * deg_h).abs() < 1e-15 * bias[1].abs() * 4.0);
    assert_eq!(
        model.get("gyro.misalignment.xz").unwrap().value,
        Some(-0.3e-3)
    );
    assert_eq!(model.get("accel.axis_offset.zz").unwrap().value, Some(0.01));
    assert_eq!(model.get("accel.axis_offset.xz").unwrap().value, Some(0.0));
    assert!(
        model
            .get("gyro.g2_sensitivity.y.yz")
            .unwrap()
            .value
            .unwrap()
            > 0.0
    );
    assert_eq!(
        model
            .get("gyro.noise.gauss_markov.1.correlation_time.z")
            .unwrap()
            .value,
        Some(300.0)
    );
    assert_eq!(
        model
            .get("accel.noise.resonances.1.frequency.y")
            .unwrap()
            .value,
        Some(70.0)
    );
    assert_eq!(
        model
            .get("accel.scale_factor.temperature.2.z")
            .unwrap()
            .value,
        Some(2e-9)
    );
    assert_eq!(
        model
            .get("accel.bias.temperature_spline.1.x")
            .unwrap()
            .value,
        Some(9.80665e-3)
    );
    assert_eq!(
        model.knots_c(Sensor::Accel, ThermalTerm::Bias),
        Some(&[-18.0, 5.0, 25.0][..])
    );
    assert!(model.get("accel.bias.y").unwrap().is_limit());
    assert!(model.get("accel.bias.z").is_none());
    assert_eq!(model.get("accel.scale_factor.y").unwrap().sigma, Some(2e-6));
    assert_eq!(
        model.get("accel.misalignment.yx").unwrap().value,
        Some(1e-4)
    );
    assert!(model.get("accel.misalignment.zx").is_none());
    assert_eq!(model.get("accel.cross_axis.zy").unwrap().sigma, Some(1e-3));
    assert_eq!(model.process(Sensor::Accel), Process::GaussMarkov);
    assert_eq!(model.calibrations()[0].covariance_of(1, 2), Some(0.0));
    assert_eq!(model.get("accel.resolution.x").unwrap().value, Some(1e-4));
    assert_eq!(model.catalog().unwrap().conflicts[0].others[0].value, "0.4");
}

#[test]
fn conversions_hold_what_the_file_says() {
    let model = example();
    let core = model.to_core().unwrap();
    assert_eq!(core.accel.range.limit[2], 196.133);
    assert_eq!(
        core.gyro_g2_sensitivity.matrix[1][5],
        model
            .get("gyro.g2_sensitivity.y.yz")
            .unwrap()
            .value
            .unwrap()
    );
    assert_eq!(core.accel.bias.temperature.range_c, Some([-18.0, 74.0]));
    assert_eq!(core.accel.bias.temperature.spline.unwrap().at(5.0)[0], 0.0);
    assert_eq!(core.gyro.misalignment.elements.to_array()[1], -0.3e-3);
    let noise = model.noise();
    let [gyro, accel] = &noise;
    // 100 ug/√Hz one-sided.
    assert!((accel[0].white.density - 9.80665e-4 / 2.0_f64.sqrt()).abs() < 1e-18);
    assert_eq!(accel[0].random_walk.coefficient, 0.0);
    assert_eq!(accel[1].instability_gauss_markov.correlation_time_s, 500.0);
    assert_eq!(accel[1].flicker.coefficient, 0.0);
    assert_eq!(accel[2].resonance[0].damping, 0.1);
    assert_eq!(gyro[0].gauss_markov.len(), 1);
    assert!(gyro[2].flicker.coefficient > 0.0);
    assert_eq!(model.stability(Sensor::Gyro).misalignment, [0.05e-3; 6]);
    assert_eq!(model.limits().len(), 4);
}

#[test]
fn the_allan_minimum_is_two_thirds_of_the_coefficient() {
    let text = "name = \"A\"\n[gyro.bias.instability]\nallan_minimum = \"5.3 deg/h\"";
    let model = Model::parse(text, "a.toml").unwrap();
    let b = model.flicker(Sensor::Gyro, 1).unwrap().value.unwrap();
    let minimum = model
        .get("gyro.bias.instability.allan_minimum")
        .unwrap()
        .value
        .unwrap();
    assert!((b * FLICKER_FLOOR - minimum).abs() < 1e-15 * minimum);
    assert!((FLICKER_FLOOR - (2.0 * 2.0_f64.ln() / std::f64::consts::PI).sqrt()).abs() < 1e-16);
    assert!((model.instability_floor(Sensor::Gyro, 0).unwrap() - minimum).abs() < 1e-15 * minimum);
}

#[test]
fn what_was_read_is_written_to_the_letter() {
    assert_eq!(example().to_toml(), EXAMPLE);
}

#[test]
fn every_number_set_again_reads_back_to_the_same_bits() {
    let model = example();
    let mut copy = Model::new("copy");
    copy.set_output(Sensor::Accel, model.output(Sensor::Accel));
    copy.set_process(Sensor::Accel, model.process(Sensor::Accel));
    let knots = model.knots_c(Sensor::Accel, ThermalTerm::Bias).unwrap();
    copy.set_spline(Sensor::Accel, ThermalTerm::Bias, knots, &[[0.0; 3]; 3])
        .unwrap();
    for (path, entry) in model.parameters() {
        copy.set_at(path, entry.clone()).unwrap();
    }
    let again = Model::parse(&copy.to_toml(), "copy.toml")
        .unwrap_or_else(|error| panic!("{error} {:?}\n{}", error.place(), copy.to_toml()));
    let all = |model: &Model| {
        model
            .parameters()
            .map(|(path, entry)| (path, entry.clone()))
            .collect::<Vec<_>>()
    };
    for (a, b) in all(&model).iter().zip(&all(&again)) {
        assert_eq!(a, b);
    }
    assert_eq!(all(&model), all(&again));
    insta::assert_snapshot!(copy.to_toml());
}

#[test]
fn a_change_leaves_the_rest_of_the_file() {
    let mut model = example();
    model
        .set(
            "gyro.bias.stability",
            Entry::of(1e-4, Dimension::ANGULAR_RATE),
        )
        .unwrap();
    model
        .set("gyro.bias.y", Entry::of(0.0, Dimension::ANGULAR_RATE))
        .unwrap();
    model.remove("gyro.noise.sinusoids.1.amplitude".parse().unwrap());
    model.remove("gyro.noise.sinusoids.1.frequency".parse().unwrap());
    model.push_calibration(Calibration {
        method: "thermal".into(),
        names: vec!["gyro.bias.x".into()],
        covariance: Some(vec![vec![1.25e-13]]),
        ..Calibration::default()
    });
    let text = model.to_toml();
    let changed: Vec<&str> = text
        .lines()
        .filter(|line| !EXAMPLE.contains(line))
        .collect();
    insta::assert_snapshot!(changed.join("\n"));
    let again = Model::parse(&text, "imu.toml").unwrap();
    assert_eq!(again.calibrations()[1].covariance_of(0, 0), Some(1.25e-13));
    assert_eq!(again.triad("gyro.bias").unwrap()[1], 0.0);
}

fn refusal(body: &str) -> String {
    let error = Model::parse(body, "imu.toml").unwrap_err();
    let mut text = format!("error: {error}\n  {}", error.place().unwrap_or_default());
    if let Some(advice) = error.advice() {
        text.push_str("\n  ");
        text.push_str(&advice);
    }
    text
}

#[test]
fn refusals_name_line_and_key() {
    let named = |body: &str| refusal(&format!("name = \"A\"\n{body}"));
    let cases = [
        refusal(""),
        refusal("name = \"\""),
        refusal("name = 3"),
        refusal("schema = 2\nname = \"A\""),
        refusal("name = "),
        refusal("name = \"A\"\nname = \"B\""),
        named("rate = \"3 Hz\""),
        named("sample_rate = 200"),
        named("sample_rate = \"0 Hz\""),
        named("sample_rate = [\"1 Hz\"]"),
        named("temperature_range = [\"70 degC\", \"-20 degC\"]"),
        named("reference_temperature = \"-300 degC\""),
        named("[gyro.noise]\nangel_random_walk = \"0.3 deg/sqrt(h)\""),
        named("[gyro.noise]\nangle_random_walk = \"0.3 deg/h\""),
        named("[gyro.noise]\nangle_random_walk = \"-0.3 deg/sqrt(h)\""),
        named("[gyro.noise]\nangle_random_walk = 0.3"),
        named("[gyro.noise]\nangle_random_walk = nan"),
        named("[gyro.noise]\nangle_random_walk = true"),
        named("[gyro.noise]\nangle_random_walk = [\"0.3 deg/sqrt(h)\", \"0.3 deg/sqrt(h)\"]"),
        named(
            "[gyro.noise]\nangle_random_walk = { value = \"0.3 deg/sqrt(h)\", sgma = \"0.1 deg/sqrt(h)\" }",
        ),
        named(
            "[gyro.noise]\nangle_random_walk = { value = \"0.3 deg/sqrt(h)\", upper_limit = \"0.1 deg/sqrt(h)\" }",
        ),
        named("[gyro.noise]\nangle_random_walk = { sigma = \"0.3 deg/sqrt(h)\" }"),
        named(
            "[gyro.noise]\nangle_random_walk = \"0.3 deg/sqrt(h)\"\nnoise_density_one_sided = \"0.007 deg/s/sqrt(Hz)\"",
        ),
        named("[gyro.noise]\nvelocity_random_walk = \"0.3 m/s/sqrt(h)\""),
        named("[gyro.bias.instability]\ncoefficient = \"8 deg/h\"\nallan_minimum = \"5.3 deg/h\""),
        named("[gyro.bias.instability]\ncoefficient = 8"),
        named("[gyro.bias]\ninstability = \"8 deg/h\""),
        named("[gyro.bias.instability]\nsigma = \"8 deg/h\""),
        named("[gyro.bias.instability]\nprocess = \"gauss_markov\"\nsigma = \"8 deg/h\""),
        named("[gyro.bias.instability]\nprocess = \"pink\""),
        named("[gyro]\noutput = \"increment\"\nresolution = \"0.1 deg/s\""),
        named("[gyro.bias]\ntemperature = \"0.4 deg/h/K\""),
        named("[gyro.bias]\ntemperature = [\"0.4 deg/h\"]"),
        named(
            "[gyro.bias]\ntemperature = [\"0.4 deg/h/K\"]\n[gyro.bias.temperature_spline]\nknots = [\"0 degC\", \"1 degC\"]\nvalues = [\"0 deg/h\", \"1 deg/h\"]",
        ),
        named(
            "[gyro.bias.temperature_spline]\nknots = [\"0 degC\", \"1 degC\"]\nvalues = [\"0 deg/h\"]",
        ),
        named("[gyro.misalignment]\nfixed = { xx = \"1 mrad\" }"),
        named("[gyro.misalignment]\nfixed = { xy = \"1 %\" }"),
        named("[gyro.g_sensitivity]\nmatrix = [[\"10 deg/h/g\"]]"),
        named("[gyro.noise]\ngauss_markov = [{ sigma = \"3 deg/h\" }]"),
        named("[gyro.noise]\ngauss_markov = { sigma = \"3 deg/h\" }"),
        named(
            "[gyro.noise]\nresonances = [{ sigma = \"3 deg/h\", frequency = \"3 Hz\", damping = 1.5 }]",
        ),
        named("[accel.axis_offset]\nx = \"1 mm\""),
        named("[accel]\ngyro = 3"),
        named("gyro = 3"),
        named("[[calibration]]\nmethod = \"stations\"\nnames = [\"gyro.bais.x\"]"),
        named(
            "[[calibration]]\nmethod = \"stations\"\nnames = [\"gyro.bias.x\"]\ncovariance = [[1], [1, 2]]",
        ),
    ];
    insta::assert_snapshot!(cases.join("\n\n"));
}

#[test]
fn hostile_files_are_refused() {
    let deep = format!("name = {}{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(Model::parse(&deep, "x").is_err());
    let dotted = format!("name = \"a\"\n{} = 1", vec!["a"; 50_000].join("."));
    assert!(Model::parse(&dotted, "x").is_err());
    let list = format!(
        "name = \"a\"\n[gyro.noise]\ngauss_markov = [{}]",
        "{ sigma = \"1 deg/h\", correlation_time = \"1 s\" },".repeat(10_000)
    );
    assert!(Model::parse(&list, "x").is_err());
    let wide = format!(
        "name = \"a\"\n[gyro.bias]\nfixed = [{}]",
        "\"1 deg/h\",".repeat(200_000)
    );
    assert!(Model::parse(&wide, "x").is_err());
    assert!(Model::from_bytes(&[0xff, 0xfe, 0, 1], "x").is_err());
    assert!(Model::from_bytes(b"\xef\xbb\xbfname = \"bom\"", "x").is_ok());
}

#[test]
fn every_path_reads_back() {
    for path in ParameterPath::all() {
        for element in path.elements() {
            let text = element.to_string();
            assert_eq!(text.parse::<ParameterPath>().unwrap(), element, "{text}");
        }
        assert_eq!(
            path.to_string().parse::<ParameterPath>().unwrap(),
            path,
            "{path}"
        );
    }
    for bad in [
        "",
        "gyro",
        "gyro.",
        "gyro.bias.w",
        "gyro.noise.gauss_markov.0.sigma.x",
        "gyro.axis_offset.xx",
        "accel.g_sensitivity.xx",
        "gyro.bias.temperature.9.x",
        "accel.axis_offset.xyz",
    ] {
        assert!(bad.parse::<ParameterPath>().is_err(), "{bad}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Any number set is written so that it reads back to the same bits, with its uncertainty.
    #[test]
    fn any_number_survives(which in any::<prop::sample::Index>(), value in 1e-12_f64..1e3, sigma in 1e-12_f64..1.0, element in any::<prop::sample::Index>()) {
        let paths: Vec<ParameterPath> = ParameterPath::all().filter(|path| {
            let text = path.to_string();
            !text.contains("damping") && !text.contains("spline") && !text.contains("instability")
        }).collect();
        let path = paths[which.index(paths.len())];
        let elements = path.elements();
        let path = elements[element.index(elements.len())];
        let mut model = Model::new("m");
        let entry = Entry { sigma: Some(sigma), ..Entry::of(value, path.dimension()) };
        // A list's entry needs its other keys.
        if path.to_string().contains("gauss_markov") || path.to_string().contains("sinusoids") || path.to_string().contains("resonances") {
            return Ok(());
        }
        model.set_at(path, entry.clone()).unwrap();
        let again = Model::parse(&model.to_toml(), "m").map_err(|error| TestCaseError::fail(format!("{error}: {}", model.to_toml())))?;
        prop_assert_eq!(again.at(path).unwrap(), &entry);
    }

    /// A file with some characters changed is read or refused, never more.
    #[test]
    fn mutated_files_never_panic(at in any::<prop::sample::Index>(), with in any::<u8>(), cut in any::<prop::sample::Index>()) {
        let mut bytes = EXAMPLE.as_bytes().to_vec();
        let place = at.index(bytes.len());
        bytes[place] = with;
        let _ = Model::from_bytes(&bytes, "m").map(|model| (model.to_core().is_ok(), model.noise()));
        bytes.truncate(cut.index(bytes.len()));
        let _ = Model::from_bytes(&bytes, "m");
    }
}
