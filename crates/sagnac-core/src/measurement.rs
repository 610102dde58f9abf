//! The measurement, in the order the physics happens: lecture equations (1) and (2), slides 10–11.
//!
//! f'_k = f_k + [ω × (ω × r_k) + ω̇ × r_k]_k
//! f~ = b_a + (I + M_a) f' + N_a(f')
//! ω~ = b_g + (I + M_g) ω + N_g(ω) + G_g f + H_g q(f)
//!
//! N_k(u) = k2_k u_k² + k3_k u_k³ + ½ a_k |u_k|. All errors are in output units and add; N
//! acts on the true component along the body axis, before M; G and H take the true f at the
//! IMU centre. The formulas are applied to interval means. Low-pass, saturation and rounding
//! come after the random terms: [`OutputStage`](crate::OutputStage).

use crate::{
    AxisOffset, G2Sensitivity, GSensitivity, Reading, Real, SensorModel, Thermal, Triad, Truth,
    vector::{Matrix, Vector, add, apply},
};

/// b(T), M(T) and N of a triad, ready for use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriadErrors<T: Real> {
    pub(crate) triad: Triad<T>,
    pub(crate) bias_thermal: Thermal<T>,
    pub(crate) scale_thermal: Thermal<T>,
    /// I + M at T0.
    pub(crate) gain: Matrix<T>,
    pub(crate) is_nonlinear: bool,
}

impl<T: Real> TriadErrors<T> {
    pub(crate) fn new(triad: &Triad<T>, reference_c: T, range_c: Option<[T; 2]>) -> Self {
        let s = triad.scale_factor.fixed;
        let m = triad.misalignment.elements.plus(&triad.cross_axis.elements);
        let one = T::ONE;
        Self {
            triad: *triad,
            bias_thermal: Thermal::new(&triad.bias.temperature, reference_c, range_c),
            scale_thermal: Thermal::new(&triad.scale_factor.temperature, reference_c, range_c),
            gain: [
                [one + s[0], m.xy, m.xz],
                [m.yx, one + s[1], m.yz],
                [m.zx, m.zy, one + s[2]],
            ],
            is_nonlinear: triad.nonlinearity.is_present() || triad.asymmetry.is_present(),
        }
    }

    /// b at a temperature.
    #[inline]
    pub fn bias(&self, temperature_c: T) -> Vector<T> {
        add(self.triad.bias.fixed, self.bias_thermal.at(temperature_c))
    }

    /// I + M at a temperature.
    #[inline]
    pub fn gain(&self, temperature_c: T) -> Matrix<T> {
        let mut gain = self.gain;
        if self.scale_thermal.is_present() {
            let s = self.scale_thermal.at(temperature_c);
            gain[0][0] += s[0];
            gain[1][1] += s[1];
            gain[2][2] += s[2];
        }
        gain
    }

    /// N(u), zero for a linear triad.
    #[inline(always)]
    pub fn nonlinear(&self, u: Vector<T>) -> Vector<T> {
        let n = &self.triad.nonlinearity;
        add(
            add(n.quadratic_part(u), n.cubic_part(u)),
            self.triad.asymmetry.part(u),
        )
    }

    /// b + (I + M) u + N(u).
    #[inline(always)]
    fn output(&self, u: Vector<T>, temperature_c: T) -> Vector<T> {
        let linear = add(
            self.bias(temperature_c),
            apply(&self.gain(temperature_c), u),
        );
        if self.is_nonlinear {
            add(linear, self.nonlinear(u))
        } else {
            linear
        }
    }
}

/// The forward model, ready for use.
///
/// ```
/// use sagnac_core::{Measurement, SensorModel, Truth};
///
/// let mut model = SensorModel::<f64>::default();
/// model.accel.bias.fixed = [0.02, 0.0, 0.0];
/// let level_at_rest = Truth { specific_force: [0.0, 0.0, -9.80665], ..Truth::default() };
/// let reading = Measurement::new(&model).corrupt(&level_at_rest);
/// assert_eq!(reading.accel, [0.02, 0.0, -9.80665]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement<T: Real> {
    pub(crate) gyro: TriadErrors<T>,
    pub(crate) accel: TriadErrors<T>,
    pub(crate) g_sensitivity: Option<GSensitivity<T>>,
    pub(crate) g2_sensitivity: Option<G2Sensitivity<T>>,
    pub(crate) axis_offset: Option<AxisOffset<T>>,
}

impl<T: Real> Measurement<T> {
    /// The forward model of a sensor.
    pub fn new(model: &SensorModel<T>) -> Self {
        let (t0, range) = (model.reference_temperature_c, model.temperature_range_c);
        let (g, h, r) = (
            model.gyro_g_sensitivity,
            model.gyro_g2_sensitivity,
            model.accel_axis_offset,
        );
        Self {
            gyro: TriadErrors::new(&model.gyro, t0, range),
            accel: TriadErrors::new(&model.accel, t0, range),
            g_sensitivity: g.is_present().then_some(g),
            g2_sensitivity: h.is_present().then_some(h),
            axis_offset: r.is_present().then_some(r),
        }
    }

    /// f': the specific force where each accelerometer sits.
    #[inline(always)]
    pub fn at_accelerometers(&self, truth: &Truth<T>) -> Vector<T> {
        match &self.axis_offset {
            Some(offset) => add(
                truth.specific_force,
                add(
                    offset.centripetal(truth.angular_rate),
                    offset.tangential(truth.angular_acceleration),
                ),
            ),
            None => truth.specific_force,
        }
    }

    /// The output without random terms, low-pass, saturation and rounding.
    ///
    /// Relative to the largest input, output or bias it is within 1e-12 of a 50-digit
    /// computation (`tests/model_reference.rs`). Input that is not finite gives output that
    /// is not.
    #[inline(always)]
    pub fn corrupt(&self, truth: &Truth<T>) -> Reading<T> {
        let t = truth.temperature_c;
        let f_sensed = self.at_accelerometers(truth);
        let accel = self.accel.output(f_sensed, t);
        let mut gyro = self.gyro.output(truth.angular_rate, t);
        if let Some(g) = &self.g_sensitivity {
            gyro = add(gyro, g.part(truth.specific_force));
        }
        if let Some(h) = &self.g2_sensitivity {
            gyro = add(gyro, h.part(truth.specific_force));
        }
        Reading {
            gyro,
            accel,
            gyro_rate: truth.angular_acceleration,
            temperature_c: t,
        }
    }
}
