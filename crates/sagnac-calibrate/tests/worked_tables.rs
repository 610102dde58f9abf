//! What eleven kinds of table determine: counts worked out by hand from rank and null space.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac_calibrate::stations::{Asked, Options, Station, calibrate};
use sagnac_core::Sensor;

const G: f64 = 9.80665;

fn station(f: [f64; 3], w: [f64; 3], wdot: [f64; 3], temperature_c: Option<f64>) -> Station {
    Station {
        accel: Some(f),
        accel_se: Some([5e-4; 3]),
        gyro: Some(w),
        gyro_se: Some([2e-5; 3]),
        f,
        w,
        wdot,
        temperature_c,
        ..Station::new("1")
    }
}

fn unit(k: usize, size: f64) -> [f64; 3] {
    let mut out = [0.0; 3];
    out[k] = size;
    out
}

fn faces(temperature_c: Option<f64>) -> Vec<Station> {
    (0..6)
        .map(|i| {
            let sign = if i % 2 == 0 { G } else { -G };
            station(unit(i / 2, sign), [0.0; 3], [0.0; 3], temperature_c)
        })
        .collect()
}

fn tumble() -> Vec<Station> {
    let mut out = Vec::new();
    for k in 0..3 {
        for step in 0..8 {
            let (s, c) = (f64::from(step) * std::f64::consts::FRAC_PI_4).sin_cos();
            let mut f = unit((k + 1) % 3, G * c);
            f[(k + 2) % 3] = G * s;
            out.push(station(
                f.map(|v| if v.abs() < 1e-9 { 0.0 } else { v }),
                [0.0; 3],
                [0.0; 3],
                None,
            ));
        }
    }
    out
}

fn rate_table() -> Vec<Station> {
    let r = 200f64.to_radians();
    let mut out = Vec::new();
    for k in 0..3 {
        for x in [-1.0, -0.5, -0.25, -0.125, 0.0, 0.125, 0.25, 0.5, 1.0] {
            out.push(station(unit(k, G), unit(k, r * x), [0.0; 3], None));
        }
    }
    out
}

/// Estimated, available, unobservable of accelerometer and gyro.
fn counts(rows: &[Station], options: &Options) -> [[usize; 3]; 2] {
    let found = calibrate(rows, options).unwrap();
    [Sensor::Accel, Sensor::Gyro].map(|sensor| {
        let of = |name: &str| name.starts_with(sensor.key());
        [
            found.parameters.iter().filter(|p| of(&p.name)).count(),
            found.available.iter().filter(|a| of(&a.name)).count(),
            found.held.iter().filter(|h| of(&h.name)).count(),
        ]
    })
}

#[test]
fn eleven_tables() {
    let usual = Options::default();
    let bias = Options {
        asked: Asked::Only(vec!["bias"]),
        ..Options::default()
    };
    let still = |f: [f64; 3]| station(f, [0.0; 3], [0.0; 3], None);
    let one_face: Vec<Station> = (0..6).map(|_| still(unit(2, -G))).collect();
    let three_faces = vec![
        still(unit(2, -G)),
        still(unit(2, -G)),
        still(unit(0, G)),
        still(unit(1, -G)),
    ];
    let one_axis: Vec<Station> = [-100.0, -50.0, -20.0, 0.0, 20.0, 50.0, 100.0]
        .map(|w: f64| station(unit(2, G), unit(2, w.to_radians()), [0.0; 3], None))
        .into();
    let mut centrifuge = Vec::new();
    for k in 0..3 {
        for sign in [1.0, -1.0] {
            for a in [2.0, 5.0, 10.0] {
                let i = (k + 1) % 3;
                let mut f = unit(k, sign * a * G);
                f[i] = G;
                centrifuge.push(station(f, unit(i, (a * G).sqrt()), [0.0; 3], None));
            }
        }
    }
    let chamber: Vec<Station> = [-20.0, 0.0, 20.0, 40.0, 60.0]
        .into_iter()
        .flat_map(|t| faces(Some(t)))
        .collect();
    let mut spins = faces(None);
    for k in 0..3 {
        for s in [1.0, -1.0] {
            spins.push(station(
                unit(k, G),
                unit(k, s * 300f64.to_radians()),
                [0.0; 3],
                None,
            ));
            spins.push(station(unit(k, G), [0.0; 3], unit(k, s * 40.0), None));
        }
    }
    let both: Vec<Station> = tumble().into_iter().chain(rate_table()).collect();
    let tumble_x: Vec<Station> = tumble().into_iter().take(8).collect();
    for (name, rows, options, want) in [
        (
            "six positions",
            faces(None),
            &usual,
            [[12, 3, 21], [12, 0, 42]],
        ),
        ("one face", one_face, &bias, [[3, 0, 33], [3, 0, 51]]),
        ("three faces", three_faces, &usual, [[6, 0, 30], [3, 0, 51]]),
        ("x level", tumble_x, &usual, [[9, 6, 21], [9, 3, 42]]),
        ("tumble24", tumble(), &usual, [[12, 9, 15], [12, 9, 33]]),
        (
            "one-axis rate table",
            one_axis,
            &usual,
            [[5, 0, 31], [6, 3, 45]],
        ),
        (
            "rate-table",
            rate_table(),
            &usual,
            [[9, 0, 27], [12, 9, 33]],
        ),
        (
            "centrifuge",
            centrifuge,
            &usual,
            [[15, 9, 12], [21, 12, 21]],
        ),
        ("chamber", chamber, &usual, [[18, 3, 15], [15, 0, 39]]),
        ("faces and spins", spins, &usual, [[21, 3, 12], [21, 3, 30]]),
        (
            "tumble24 + rate-table",
            both,
            &usual,
            [[15, 9, 12], [21, 18, 15]],
        ),
    ] {
        assert_eq!(counts(&rows, options), want, "{name}");
    }
}

#[test]
fn aliases_of_six_positions() {
    let found = calibrate(&faces(None), &Options::default()).unwrap();
    let cubic = found
        .held
        .iter()
        .find(|h| h.name == "accel.scale_factor.cubic.x")
        .unwrap();
    assert_eq!(cubic.aliases.len(), 1);
    assert_eq!(cubic.aliases[0].0, "accel.scale_factor.x");
    assert!((cubic.aliases[0].1 - G * G).abs() < 1e-9 * G * G);
}

#[test]
fn every_term_asked_for_has_stations_to_add_where_rate_and_temperature_must_meet() {
    let mut chamber = Vec::new();
    for t in [-20.0, 0.0, 20.0, 40.0, 60.0] {
        chamber.extend(faces(Some(t)));
    }
    let found = calibrate(&chamber, &Options::default()).unwrap();
    assert_eq!(found.hopeless, Vec::<String>::new());
    let mut rows = chamber;
    for addition in &found.additions {
        for bundle in &addition.bundles {
            rows.extend(
                bundle
                    .stations
                    .iter()
                    .map(|s| station(s.f, s.w, s.wdot, s.temperature_c.or(Some(20.0)))),
            );
        }
    }
    // Followed, the advice determines what was missing.
    let after = calibrate(&rows, &Options::default()).unwrap();
    for held in found.held.iter().filter(|h| h.asked) {
        assert!(after.parameter(&held.name).is_some(), "{}", held.name);
    }
    assert!(
        found
            .held
            .iter()
            .any(|h| h.name == "gyro.scale_factor.temperature.1.x")
    );
}
