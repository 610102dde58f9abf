//! The worked example of the definitions of `response`: 28 readings in m/s², two runs, no direction column.

#![allow(
    clippy::unwrap_used,
    clippy::excessive_precision,
    reason = "a test of printed digits"
)]

use sagnac_calibrate::response::{Options, Reading, respond};

const REFERENCE: [f64; 14] = [
    -20.0, -10.0, -0.2, 0.0, 0.2, 10.0, 20.0, 20.0, 10.0, 0.2, 0.0, -0.2, -10.0, -20.0,
];
const OUTPUT: [[f64; 14]; 2] = [
    [
        -19.71, -9.80, 0.11, 0.12, 0.13, 10.07, 20.05, 20.05, 10.13, 0.20, 0.20, 0.19, -9.73,
        -19.71,
    ],
    [
        -19.69, -9.82, 0.15, 0.14, 0.15, 10.05, 20.07, 20.07, 10.15, 0.19, 0.18, 0.17, -9.75,
        -19.69,
    ],
];

fn close(got: f64, want: f64) {
    // The printed digits end at 1e-13; sums of 28 terms of 20 keep 1e-12 of that.
    assert!(
        (got - want).abs() <= 2e-12 * want.abs().max(1e-3),
        "{got} is not {want}"
    );
}

#[test]
fn every_printed_digit() {
    let readings: Vec<Reading> = OUTPUT
        .iter()
        .flat_map(|run| REFERENCE.iter().zip(run).map(|(&x, &y)| Reading::new(x, y)))
        .collect();
    let options = Options {
        nominal_sensitivity: Some(1.0),
        ..Options::default()
    };
    let r = respond(&readings, &options).unwrap();
    close(r.sensitivity.value, 0.993_872_990_160_787_3);
    close(r.sensitivity.lower, 0.990_254_912_897_451);
    close(r.sensitivity.upper, 0.997_491_067_424_123_6);
    close(r.sensitivity.sigma, 0.001_760_168_059_536_5);
    close(r.offset, 0.166_785_714_285_714_3);
    close(r.full_scale, 20.0);
    let linearity = r.linearity.unwrap();
    close(linearity.least_squares, 0.198_060_312_317_871_8);
    close(linearity.minimax, 0.190_829_207_920_792_1);
    let accuracy = r.accuracy.unwrap();
    close(accuracy.mean, 0.166_785_714_285_714_2);
    close(accuracy.max_abs, 0.39);
    close(accuracy.single_reading[0], -0.109_424_322_261_8);
    close(accuracy.single_reading[1], 0.442_995_750_833_2);
    let precision = r.precision.unwrap();
    close(precision.value, 0.014_414_498_873_626_3);
    close(precision.lower, 0.010_648_060_339_987_4);
    close(precision.upper, 0.022_309_193_386_561_6);
    assert_eq!(precision.dof, 15);
    close(r.resolution.unwrap().value, 0.079_674_394_727_899_8);
    close(r.lsb.unwrap(), 0.01);
    let hysteresis = r.hysteresis.unwrap();
    close(hysteresis.value, 0.08);
    close(hysteresis.at, 10.0);
    let threshold = r.threshold.unwrap();
    close(threshold.positive, 10.0);
    close(threshold.negative, 10.0);
    close(threshold.dead_band, 0.4);
    let asymmetry = r.asymmetry.unwrap();
    close(asymmetry.value, 0.001_851_518_475_473);
    close(asymmetry.sigma, 0.005_206_703_959_421_7);
    close(asymmetry.lower, -0.008_871_889_061_729_1);
    close(asymmetry.upper, 0.012_574_926_012_675_2);
}

#[test]
fn what_a_record_cannot_give_has_its_reason() {
    let readings: Vec<Reading> = [(1.0, 10.0), (2.0, 20.5), (3.0, 30.0)]
        .map(|(x, y)| Reading::new(x, y))
        .into();
    let r = respond(&readings, &Options::default()).unwrap();
    assert!(r.linearity.is_ok());
    assert!(r.accuracy.unwrap_err().contains("nominal sensitivity"));
    assert!(r.precision.unwrap_err().contains("twice"));
    assert!(r.resolution.unwrap_err().contains("precision"));
    assert!(r.hysteresis.unwrap_err().contains("up"));
    assert!(r.threshold.unwrap_err().contains("zero"));
    assert!(r.asymmetry.unwrap_err().contains("one side"));
}

#[test]
fn a_record_that_gives_nothing_is_refused() {
    let row = |x, y| Reading::new(x, y);
    let refuse = |rows: &[Reading]| respond(rows, &Options::default()).unwrap_err().to_string();
    assert!(refuse(&[row(0.0, 1.0), row(1.0, 2.0)]).contains("at least 3"));
    assert!(refuse(&[row(1.0, 1.0), row(1.0, 2.0), row(1.0, 3.0)]).contains("one reference"));
    assert!(refuse(&[row(0.0, 1.0), row(1.0, f64::NAN), row(2.0, 3.0)]).contains("reading 2"));
    assert!(refuse(&[row(0.0, 1.0), row(1.0, 1.0), row(2.0, 1.0)]).contains("stuck"));
    assert!(
        respond(
            &[row(0.0, 1.0), row(1.0, 2.0), row(2.0, 3.0)],
            &Options {
                full_scale: Some(0.0),
                ..Options::default()
            }
        )
        .is_err()
    );
}
