//! Models that the tests and benchmarks share.
#![allow(
    dead_code,
    clippy::field_reassign_with_default,
    reason = "each test uses its part; a model is written term by term"
)]

use sagnac_core::{AxisOffset, G2Sensitivity, GSensitivity, OffDiagonal, SensorModel};

/// Standard gravity, m/s².
pub(crate) const G: f64 = 9.80665;
/// rad/s a deg/h.
pub(crate) const DEG_H: f64 = core::f64::consts::PI / 180.0 / 3600.0;
/// rad/s a deg/s.
pub(crate) const DEG_S: f64 = core::f64::consts::PI / 180.0;

/// The example of the model file's documentation: a small MEMS unit with every term small,
/// levers of 10 mm, temperature terms of first order in bias and scale factor.
pub(crate) fn example() -> SensorModel<f64> {
    let mut m = SensorModel::default();
    m.temperature_range_c = Some([-20.0, 70.0]);
    let g = &mut m.gyro;
    g.range.limit = [450.0 * DEG_S; 3];
    g.bias.fixed = [12.0 * DEG_H, -5.0 * DEG_H, 3.0 * DEG_H];
    g.bias.temperature.polynomial[0] = [0.4 * DEG_H, -0.2 * DEG_H, 0.1 * DEG_H];
    g.scale_factor.fixed = [300e-6, -150e-6, 80e-6];
    g.scale_factor.temperature.polynomial[0] = [10e-6; 3];
    let lean = OffDiagonal::from_array([0.5e-3, -0.3e-3, 0.2e-3, 0.1e-3, -0.4e-3, 0.6e-3]);
    let mut cross = OffDiagonal::default();
    cross.xy = 1e-3;
    g.misalignment.elements = lean;
    g.cross_axis.elements = cross;
    m.gyro_g_sensitivity = GSensitivity {
        matrix: [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]]
            .map(|row: [f64; 3]| row.map(|x| x * DEG_H / G)),
    };
    let mut h = [[0.0; 6]; 3];
    h[0][3] = 0.5 * DEG_H / (G * G);
    m.gyro_g2_sensitivity = G2Sensitivity { matrix: h };
    let a = &mut m.accel;
    a.range.limit = [10.0 * G; 3];
    a.bias.fixed = [1.2e-3 * G, -0.8e-3 * G, 2.1e-3 * G];
    a.bias.temperature.polynomial[0] = [0.05e-3 * G, 0.02e-3 * G, -0.08e-3 * G];
    a.scale_factor.fixed = [400e-6, -200e-6, 350e-6];
    a.scale_factor.temperature.polynomial[0] = [5e-6; 3];
    a.misalignment.elements = lean;
    a.cross_axis.elements = cross;
    m.accel_axis_offset = AxisOffset {
        position: [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]],
    };
    m
}

/// A consumer part with every element at its worst: 2000 deg/s, 16 g, 2.5 % scale factor,
/// 15 mrad, 1 % cross-axis response, k2 and k3 of 1 % of full scale, 1 % asymmetry,
/// 0.1 deg/s/g, 25 mm levers, no bias. q = 0.12.
pub(crate) fn consumer() -> SensorModel<f64> {
    let mut m = SensorModel::default();
    let (rate, force) = (2000.0 * DEG_S, 16.0 * G);
    for (triad, range) in [(&mut m.gyro, rate), (&mut m.accel, force)] {
        triad.range.limit = [range; 3];
        triad.scale_factor.fixed = [0.025; 3];
        triad.misalignment.elements = OffDiagonal::from_array([15e-3; 6]);
        triad.cross_axis.elements = OffDiagonal::from_array([0.01; 6]);
        triad.nonlinearity.quadratic = [0.01 / range; 3];
        triad.nonlinearity.cubic = [0.01 / (range * range); 3];
        triad.asymmetry.difference = [0.01; 3];
    }
    m.gyro_g_sensitivity.matrix = [[0.1 * DEG_S / G; 3]; 3];
    m.accel_axis_offset.position = [[0.025; 3]; 3];
    m
}
