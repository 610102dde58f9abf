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
    AxisOffset, G2Sensitivity, GSensitivity, Reading, Real, Sensor, SensorModel, Thermal, Triad,
    Truth,
    compensation::Lanes,
    vector::{Matrix, Vector, add, apply, put, take, take_from},
};

/// N_k(u) = k2_k u_k² + k3_k u_k³ + ½ a_k |u_k|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonlinearPart<T> {
    polynomial: crate::Nonlinearity<T>,
    asymmetry: crate::Asymmetry<T>,
}

impl<T: Real> NonlinearPart<T> {
    /// N(u).
    #[inline(always)]
    pub fn part(&self, u: Vector<T>) -> Vector<T> {
        let n = &self.polynomial;
        add(
            add(n.quadratic_part(u), n.cubic_part(u)),
            self.asymmetry.part(u),
        )
    }
}

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

    /// Whether every number is finite (ranges and cut-offs apart).
    pub(crate) fn is_finite(&self) -> bool {
        let n = &self.triad.nonlinearity;
        let all = |v: &[T]| v.iter().all(|x| x.is_finite());
        let thermal = |t: &Thermal<T>| {
            t.polynomial().iter().all(|row| all(row))
                && t.spline().is_none_or(|s| {
                    s.segments()
                        .iter()
                        .all(|piece| piece.coefficients.iter().all(|row| all(row)))
                })
        };
        all(&self.triad.bias.fixed)
            && self.gain.iter().all(|row| all(row))
            && all(&n.quadratic)
            && all(&n.cubic)
            && all(&self.triad.asymmetry.difference)
            && thermal(&self.bias_thermal)
            && thermal(&self.scale_thermal)
    }

    /// Whether bias or scale factor depend on temperature.
    #[inline(always)]
    pub(crate) fn depends_on_temperature(&self) -> bool {
        self.bias_thermal.is_present() || self.scale_thermal.is_present()
    }

    /// b at a temperature.
    #[inline]
    pub fn bias(&self, temperature_c: T) -> Vector<T> {
        add(self.triad.bias.fixed, self.bias_thermal.at(temperature_c))
    }

    /// A temperature held at the ends of the range in which the bias's temperature terms hold, °C.
    pub fn bias_temperature_c(&self, temperature_c: T) -> T {
        self.bias_thermal.held(temperature_c)
    }

    /// A temperature held at the ends of the range in which the scale factor's temperature terms hold, °C.
    pub fn scale_factor_temperature_c(&self, temperature_c: T) -> T {
        self.scale_thermal.held(temperature_c)
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

    /// N, a copy.
    #[inline(always)]
    pub fn nonlinearity(&self) -> NonlinearPart<T> {
        NonlinearPart {
            polynomial: self.triad.nonlinearity,
            asymmetry: self.triad.asymmetry,
        }
    }

    /// b + (I + M) u + N(u) of N samples.
    #[inline(always)]
    fn output<const N: usize>(&self, u: [&[T; N]; 3], temperature_c: &[T; N], y: &mut [[T; N]; 3]) {
        let (fixed, at_reference) = (self.triad.bias.fixed, self.gain);
        if self.depends_on_temperature() {
            let mut bias = [[fixed[0]; N], [fixed[1]; N], [fixed[2]; N]];
            self.bias_thermal.add_to(temperature_c, &mut bias);
            let mut scale = [[T::ZERO; N]; 3];
            self.scale_thermal.add_to(temperature_c, &mut scale);
            for i in 0..N {
                let mut gain = at_reference;
                for k in 0..3 {
                    gain[k][k] += scale[k][i];
                }
                put(y, i, add(take(&bias, i), apply(&gain, take_from(u, i))));
            }
        } else {
            for i in 0..N {
                put(y, i, add(fixed, apply(&at_reference, take_from(u, i))));
            }
        }
        if self.is_nonlinear {
            let n = self.nonlinearity();
            for i in 0..N {
                put(y, i, add(take(y, i), n.part(take_from(u, i))));
            }
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
    pub(crate) reference_c: T,
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
            reference_c: t0,
        }
    }

    /// The errors of one triad.
    pub const fn errors(&self, sensor: Sensor) -> &TriadErrors<T> {
        match sensor {
            Sensor::Gyro => &self.gyro,
            Sensor::Accel => &self.accel,
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
    #[inline]
    pub fn corrupt(&self, truth: &Truth<T>) -> Reading<T> {
        let one = |v: [T; 3]| v.map(|x| [x]);
        let (f, w) = (one(truth.specific_force), one(truth.angular_rate));
        let (wdot, temperature) = (one(truth.angular_acceleration), [truth.temperature_c]);
        let (mut gyro, mut accel) = ([[T::ZERO]; 3], [[T::ZERO]; 3]);
        let lanes = Lanes {
            gyro: [&w[0], &w[1], &w[2]],
            accel: [&f[0], &f[1], &f[2]],
            gyro_rate: [&wdot[0], &wdot[1], &wdot[2]],
            temperature_c: &temperature,
        };
        self.corrupt_lanes(&lanes, &mut gyro, &mut accel);
        Reading {
            gyro: take(&gyro, 0),
            accel: take(&accel, 0),
            gyro_rate: truth.angular_acceleration,
            temperature_c: truth.temperature_c,
        }
    }

    /// N samples of the truth at once: the physics in its order.
    #[inline(always)]
    pub(crate) fn corrupt_lanes<const N: usize>(
        &self,
        truth: &Lanes<'_, T, N>,
        gyro: &mut [[T; N]; 3],
        accel: &mut [[T; N]; 3],
    ) {
        let (f, w, wdot) = (truth.accel, truth.gyro, truth.gyro_rate);
        // 1. Size effect: what each accelerometer feels where it sits.
        // 2. Bias, scale factor, misalignment, cross-axis response, nonlinearity, asymmetry.
        if let Some(offset) = self.axis_offset {
            let mut sensed = [[T::ZERO; N]; 3];
            for i in 0..N {
                let effect = add(
                    offset.centripetal(take_from(w, i)),
                    offset.tangential(take_from(wdot, i)),
                );
                put(&mut sensed, i, add(take_from(f, i), effect));
            }
            let [x, y, z] = &sensed;
            self.accel.output([x, y, z], truth.temperature_c, accel);
        } else {
            self.accel.output(f, truth.temperature_c, accel);
        }
        self.gyro.output(w, truth.temperature_c, gyro);
        // 3. What specific force does to the gyroscopes.
        if let Some(g) = self.g_sensitivity {
            for i in 0..N {
                put(gyro, i, add(take(gyro, i), g.part(take_from(f, i))));
            }
        }
        if let Some(h) = self.g2_sensitivity {
            for i in 0..N {
                put(gyro, i, add(take(gyro, i), h.part(take_from(f, i))));
            }
        }
    }
}
