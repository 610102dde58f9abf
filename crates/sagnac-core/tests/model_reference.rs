//! The forward model against `tools/model_reference.py` (mpmath, 50 digits): every term
//! alone and all together, to 1e-12 of the largest of input, output and bias.

#![allow(clippy::unnecessary_to_owned, reason = "reads closest to its equation")]
#![allow(
    clippy::field_reassign_with_default,
    reason = "reads closest to its equation"
)]
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac_core::{Measurement, OffDiagonal, SensorModel, Truth};

const CASES: &str = include_str!("../../../testdata/reference/measurement.csv");

struct Row<'a>(std::vec::IntoIter<&'a str>);

impl Row<'_> {
    fn take<const N: usize>(&mut self) -> [f64; N] {
        [0; N].map(|_| self.0.next().unwrap().parse().unwrap())
    }
    fn rows<const R: usize, const N: usize>(&mut self) -> [[f64; N]; R] {
        [0; R].map(|_| self.take())
    }
}

#[test]
fn every_term_alone_and_all_together() {
    let mut count = 0;
    for line in CASES.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let case = cells[0];
        let mut row = Row(cells[1..].to_vec().into_iter());
        let mut m = SensorModel::<f64>::default();
        let r = &mut row;
        (m.gyro.bias.fixed, m.accel.bias.fixed) = (r.take(), r.take());
        m.gyro.bias.temperature.polynomial = r.rows();
        m.accel.bias.temperature.polynomial = r.rows();
        (m.gyro.scale_factor.fixed, m.accel.scale_factor.fixed) = (r.take(), r.take());
        m.gyro.scale_factor.temperature.polynomial = r.rows();
        m.accel.scale_factor.temperature.polynomial = r.rows();
        m.gyro.nonlinearity.quadratic = r.take();
        m.accel.nonlinearity.quadratic = r.take();
        (m.gyro.nonlinearity.cubic, m.accel.nonlinearity.cubic) = (r.take(), r.take());
        (m.gyro.asymmetry.difference, m.accel.asymmetry.difference) = (r.take(), r.take());
        m.gyro.misalignment.elements = OffDiagonal::from_array(r.take());
        m.accel.misalignment.elements = OffDiagonal::from_array(r.take());
        m.gyro.cross_axis.elements = OffDiagonal::from_array(r.take());
        m.accel.cross_axis.elements = OffDiagonal::from_array(r.take());
        m.gyro_g_sensitivity.matrix = r.rows();
        m.gyro_g2_sensitivity.matrix = r.rows();
        m.accel_axis_offset.position = r.rows();
        let truth = Truth {
            specific_force: r.take(),
            angular_rate: r.take(),
            angular_acceleration: r.take(),
            temperature_c: 25.0 + r.take::<1>()[0],
        };
        let (gyro, accel): ([f64; 3], [f64; 3]) = (r.take(), r.take());
        let forward = Measurement::new(&m);
        let got = forward.corrupt(&truth);
        for (got, want, u) in [
            (got.gyro, gyro, truth.angular_rate),
            (got.accel, accel, truth.specific_force),
        ] {
            let s = want
                .iter()
                .chain(&u)
                .fold(0.0_f64, |max, x| max.max(x.abs()));
            for k in 0..3 {
                assert!(
                    (got[k] - want[k]).abs() <= 1e-12 * s,
                    "{case}: {got:?} {want:?}"
                );
            }
        }
        count += 1;
    }
    assert!(count >= 80);
}

/// Trap 7: the polynomial is about T0, not about 0 °C.
#[test]
fn trap_7_temperature_polynomial_is_about_the_reference_temperature() {
    let mut m = SensorModel::<f64>::default();
    m.reference_temperature_c = 30.0;
    m.gyro.bias.fixed = [0.5; 3];
    m.gyro.bias.temperature.polynomial[0] = [0.1; 3];
    let at = |t: f64| {
        let truth = Truth {
            temperature_c: t,
            ..Truth::default()
        };
        Measurement::new(&m).corrupt(&truth).gyro[0]
    };
    assert_eq!(at(30.0), 0.5);
    assert!((at(40.0) - 1.5).abs() < 1e-15);
}

/// Trap 9: (I+M)⁻¹ after the bias is off, not I − M.
#[test]
fn trap_9_compensation_takes_the_bias_off_and_inverts_the_matrix() {
    let mut m = SensorModel::<f64>::default();
    m.gyro.bias.fixed = [0.3, 0.0, 0.0];
    m.gyro.scale_factor.fixed = [0.1, 0.0, 0.0];
    let inverse = sagnac_core::Compensation::new(&m, 0.01).unwrap();
    let raw = sagnac_core::Reading {
        gyro: [1.4, 0.0, 0.0],
        ..Default::default()
    };
    // (1.4 − 0.3)/1.1 = 1; I − M would give 0.99, the inverse before the bias 0.97.
    assert!((inverse.correct(&raw).gyro[0] - 1.0).abs() < 1e-15);
}

/// Trap 4: rounding a rate is white, rounding an increment with its residue is not.
#[test]
fn trap_4_rounded_increments_keep_their_angle() {
    use sagnac_core::{Output, OutputStage, Triad};
    let mut triad = Triad::<f64>::default();
    triad.resolution.lsb = [0.01; 3];
    let sum = |triad: &Triad<f64>| -> f64 {
        let mut stage = OutputStage::new(triad, 1.0, [0.0; 3]);
        (0..1000)
            .map(|_| stage.next_sample([0.0123, 0.0, 0.0])[0])
            .sum()
    };
    assert!(
        (sum(&triad) - 10.0).abs() < 1e-9,
        "a steady rate loses 0.0023 a sample"
    );
    triad.resolution.output = Output::Increment;
    assert!(
        (sum(&triad) - 12.3).abs() <= 0.005 + 1e-9,
        "an angle does not"
    );
}
