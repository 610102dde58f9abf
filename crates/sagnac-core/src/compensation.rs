//! The inverse of the measurement: f and ω from raw output, by a fixed number of rounds.
//!
//! One round:
//! f' ← (I+M_a)⁻¹ (y_a − b_a − N_a(f')),
//! f ← f' − size effect(ω, ω̇),
//! ω ← (I+M_g)⁻¹ (y_g − b_g − G_g f − H_g q(f) − N_g(ω)),
//! from f' = (I+M_a)⁻¹(y_a − b_a), ω = (I+M_g)⁻¹(y_g − b_g). The bias is taken off before the
//! inverse matrix, which is (I+M)⁻¹ and not I − M. [`Bound`] says when this converges.
//!
//! Not undone: draws, random terms, low-pass, rounding, saturation. No heap, no panics, a
//! fixed number of operations; one sample and a block of samples give the same bits.
#![allow(
    clippy::needless_bitwise_bool,
    reason = "conditions without jumps, so that loops over samples become vector code"
)]

use crate::{
    Bound, CompensationError, Corrected, Measurement, Reading, Real, Sensor, SensorModel,
    TriadErrors,
    bound::BoundTerms,
    flags,
    vector::{self, put, take, take_matrix},
};

/// A model's inverse, ready for use.
///
/// ```
/// use sagnac_core::{Compensation, Measurement, SensorModel, Truth, flags};
///
/// let mut model = SensorModel::<f64>::default();
/// model.gyro.bias.fixed = [0.01, -0.02, 0.0];
/// model.gyro.range.limit = [8.0; 3];
/// model.gyro_g_sensitivity.matrix[0][2] = 1e-4;
/// model.accel.scale_factor.fixed = [0.0, 0.0, 2e-3];
/// model.accel.range.limit = [160.0; 3];
/// model.accel_axis_offset.position[0] = [0.02, 0.0, 0.0];
///
/// let truth = Truth {
///     specific_force: [1.0, 0.0, -9.8],
///     angular_rate: [0.3, -0.2, 2.0],
///     ..Truth::default()
/// };
/// let inverse = Compensation::new(&model, 0.01)?;
/// let mut raw = Measurement::new(&model).corrupt(&truth);
/// let corrected = inverse.correct(&raw);
/// assert!((corrected.accel[0] - 1.0).abs() < 1e-12 && corrected.flags == 0);
///
/// raw.gyro[2] = 8.0; // at the end of the range
/// assert_eq!(inverse.correct(&raw).flags & flags::GYRO_SATURATED, 1);
/// # Ok::<(), sagnac_core::CompensationError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensation<T: Real> {
    forward: Measurement<T>,
    terms: BoundTerms<T>,
    bound: Option<Bound<T>>,
    range: [Option<T>; 2],
    rounds: u32,
    inverse: [vector::Matrix<T>; 2],
    saturated: [[T; 3]; 2],
    temperature_range_c: Option<[T; 2]>,
    shape: Shape,
}

/// Which terms a model has: what is absent costs nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "five terms that are there or not, known to the compiler one by one"
)]
struct Shape {
    gyro_nonlinear: bool,
    accel_nonlinear: bool,
    g: bool,
    h: bool,
    offset: bool,
}

/// N readings, a slice of N numbers a channel.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<'a, T, const N: usize> {
    pub(crate) gyro: [&'a [T; N]; 3],
    pub(crate) accel: [&'a [T; N]; 3],
    pub(crate) gyro_rate: [&'a [T; N]; 3],
    pub(crate) temperature_c: &'a [T; N],
}

/// N results.
#[derive(Clone, Copy)]
pub(crate) struct Results<T, const N: usize> {
    pub(crate) gyro: [[T; N]; 3],
    pub(crate) accel: [[T; N]; 3],
    pub(crate) flags: [u32; N],
}

impl<T: Real, const N: usize> Results<T, N> {
    pub(crate) fn zero() -> Self {
        Self {
            gyro: [[T::ZERO; N]; 3],
            accel: [[T::ZERO; N]; 3],
            flags: [0; N],
        }
    }
}

/// What a triad needs in every round.
struct Prepared<T, const N: usize> {
    /// y − b.
    centered: [[T; N]; 3],
    /// (I + M)⁻¹.
    inverse: [[[T; N]; 3]; 3],
    /// f' or ω.
    solution: [[T; N]; 3],
}

impl<T: Real> Compensation<T> {
    /// The inverse of a model for samples `dt_s` apart (which only says where an increment
    /// output saturates).
    ///
    /// # Errors
    /// [`CompensationError`]: I + M is singular, μ + ν ≥ 1, a parameter is not finite, or
    /// `dt_s` is not positive. A model between the bound and that is taken, and every sample
    /// gets [`flags::OUTSIDE_VALIDITY`].
    pub fn new(model: &SensorModel<T>, dt_s: T) -> Result<Self, CompensationError> {
        if !(dt_s > T::ZERO && dt_s.is_finite()) {
            return Err(CompensationError::Interval {
                dt_s: dt_s.to_f64(),
            });
        }
        let forward = Measurement::new(model);
        let terms = BoundTerms::new(&forward);
        let range = [model.gyro.range.largest(), model.accel.range.largest()];
        let bound = match range {
            [Some(gyro), Some(accel)] => Some(terms.at([gyro, accel])),
            _ => None,
        };
        let least = terms.at([range[0].unwrap_or(T::ZERO), range[1].unwrap_or(T::ZERO)]);
        for sensor in Sensor::ALL {
            let (errors, s) = (forward.errors(sensor), sensor.index());
            let determinant = vector::inverse(&errors.gain).1;
            if !(determinant.is_finite() && errors.is_finite()) {
                return Err(CompensationError::NotFinite { sensor });
            }
            if determinant == T::ZERO {
                return Err(CompensationError::Singular { sensor });
            }
            let sum = least.mu[s] + least.nu[s];
            if sum.is_finite() && sum >= T::ONE {
                return Err(CompensationError::TooLarge {
                    sensor,
                    mu_plus_nu: sum.to_f64(),
                });
            }
            if !sum.is_finite() {
                return Err(CompensationError::NotFinite { sensor });
            }
        }
        if !(least.gamma.is_finite() && least.lever.is_finite()) {
            return Err(CompensationError::NotFinite {
                sensor: Sensor::Gyro,
            });
        }
        let threshold = |sensor: Sensor| {
            let triad = model.triad(sensor);
            let mut of = [T::NAN; 3];
            for (axis, to) in of.iter_mut().enumerate() {
                let limit = triad.range.limit[axis];
                if limit.is_finite() {
                    let largest = triad.resolution.largest_output(axis, limit, dt_s);
                    *to = T::from_f64(largest.to_f64() * (1.0 - 1e-9));
                }
            }
            of
        };
        Ok(Self {
            forward,
            terms,
            bound,
            range,
            rounds: terms.rounds(range),
            inverse: [
                vector::inverse(&forward.gyro.gain).0,
                vector::inverse(&forward.accel.gain).0,
            ],
            saturated: [threshold(Sensor::Gyro), threshold(Sensor::Accel)],
            temperature_range_c: model.temperature_range_c,
            shape: Shape {
                gyro_nonlinear: forward.gyro.is_nonlinear,
                accel_nonlinear: forward.accel.is_nonlinear,
                g: forward.g_sensitivity.is_some(),
                h: forward.g2_sensitivity.is_some(),
                offset: forward.axis_offset.is_some(),
            },
        })
    }

    /// n, the rounds of every sample.
    pub fn rounds(&self) -> u32 {
        self.rounds
    }

    /// The convergence bound, where both triads have a range; else it is that of the sample.
    pub fn bound(&self) -> Option<&Bound<T>> {
        self.bound.as_ref()
    }

    /// The bound for outputs that reach `gyro` (rad/s) and `accel` (m/s²).
    pub fn bound_at(&self, gyro: T, accel: T) -> Bound<T> {
        self.terms.at([gyro, accel])
    }

    /// The largest finite range of a triad.
    pub fn range(&self, sensor: Sensor) -> Option<T> {
        match sensor {
            Sensor::Gyro => self.range[0],
            Sensor::Accel => self.range[1],
        }
    }

    /// From which |y| on an axis counts as saturated, x, y, z; NaN where there is no range.
    pub fn saturation(&self, sensor: Sensor) -> [T; 3] {
        match sensor {
            Sensor::Gyro => self.saturated[0],
            Sensor::Accel => self.saturated[1],
        }
    }

    /// The forward model that this undoes.
    pub fn measurement(&self) -> &Measurement<T> {
        &self.forward
    }

    /// The corrected reading and its [`flags`].
    ///
    /// Inside the bound ‖result − truth‖∞ ≤ 1e-12·s in `f64` and 2⁻¹⁸·s in `f32`, s the largest
    /// of truth, output and bias of the triad (`tests/round_trip.rs`).
    #[inline]
    pub fn correct(&self, raw: &Reading<T>) -> Corrected<T> {
        let one = |v: &[T; 3]| [[v[0]], [v[1]], [v[2]]];
        let (gyro, accel, rate) = (one(&raw.gyro), one(&raw.accel), one(&raw.gyro_rate));
        let temperature = [raw.temperature_c];
        let lanes = Lanes {
            gyro: [&gyro[0], &gyro[1], &gyro[2]],
            accel: [&accel[0], &accel[1], &accel[2]],
            gyro_rate: [&rate[0], &rate[1], &rate[2]],
            temperature_c: &temperature,
        };
        let mut results = Results::<T, 1>::zero();
        self.correct_lanes(&lanes, &mut results);
        let (g, a) = (&results.gyro, &results.accel);
        Corrected {
            gyro: [g[0][0], g[1][0], g[2][0]],
            accel: [a[0][0], a[1][0], a[2][0]],
            flags: results.flags[0],
        }
    }

    /// N samples at once; the operations on each are the same for every N.
    #[inline(always)]
    pub(crate) fn correct_lanes<const N: usize>(
        &self,
        input: &Lanes<'_, T, N>,
        output: &mut Results<T, N>,
    ) {
        let shape = self.shape;
        let t = input.temperature_c;
        let mut gyro = prepare(&self.forward.gyro, &self.inverse[0], &input.gyro, t);
        let mut accel = prepare(&self.forward.accel, &self.inverse[1], &input.accel, t);
        let mut tangential = [[T::ZERO; N]; 3];
        if let Some(offset) = &self.forward.axis_offset {
            for i in 0..N {
                let wdot = input.gyro_rate.map(|channel| channel[i]);
                put(&mut tangential, i, offset.tangential(wdot));
            }
        }
        let force = &mut output.accel;
        // Where all shapes were left to the run time the loops would not become vector code.
        let shape_of = |[gyro_nonlinear, accel_nonlinear, g, h, offset]: [bool; 5]| Shape {
            gyro_nonlinear,
            accel_nonlinear,
            g,
            h,
            offset,
        };
        macro_rules! rounds {
            ($($known:expr),*) => {
                match shape {
                    $(_ if N > 1 && shape == shape_of($known) => {
                        self.run_rounds(&mut gyro, &mut accel, &tangential, force, shape_of($known));
                    })*
                    _ => self.run_rounds(&mut gyro, &mut accel, &tangential, force, shape),
                }
            };
        }
        rounds!(
            [false, false, false, false, false],
            [false, false, true, false, false],
            [false, false, false, false, true],
            [false, false, true, false, true],
            [false, false, true, true, true],
            [true, true, true, false, true],
            [true, true, true, true, true]
        );
        output.gyro = gyro.solution;
        self.flag(input, &accel.solution, &tangential, output);
    }

    /// The rounds themselves; `shape` says which terms there are.
    #[inline(always)]
    fn run_rounds<const N: usize>(
        &self,
        gyro: &mut Prepared<T, N>,
        accel: &mut Prepared<T, N>,
        tangential: &[[T; N]; 3],
        force: &mut [[T; N]; 3],
        shape: Shape,
    ) {
        let zero_g = crate::GSensitivity::default();
        let zero_h = crate::G2Sensitivity::default();
        let zero_r = crate::AxisOffset::default();
        let g = self.forward.g_sensitivity.as_ref().unwrap_or(&zero_g);
        let h = self.forward.g2_sensitivity.as_ref().unwrap_or(&zero_h);
        let r = self.forward.axis_offset.as_ref().unwrap_or(&zero_r);
        for _ in 0..self.rounds {
            for i in 0..N {
                let w = take(&gyro.solution, i);
                let mut f = take(&accel.solution, i);
                if shape.accel_nonlinear {
                    let rest =
                        vector::sub(take(&accel.centered, i), self.forward.accel.nonlinear(f));
                    f = vector::apply(&take_matrix(&accel.inverse, i), rest);
                    put(&mut accel.solution, i, f);
                }
                if shape.offset {
                    let effect = vector::add(r.centripetal(w), take(tangential, i));
                    f = vector::sub(f, effect);
                }
                put(force, i, f);
                if shape.g || shape.h || shape.gyro_nonlinear {
                    let mut rest = take(&gyro.centered, i);
                    if shape.g {
                        rest = vector::sub(rest, g.part(f));
                    }
                    if shape.h {
                        rest = vector::sub(rest, h.part(f));
                    }
                    if shape.gyro_nonlinear {
                        rest = vector::sub(rest, self.forward.gyro.nonlinear(w));
                    }
                    let w = vector::apply(&take_matrix(&gyro.inverse, i), rest);
                    put(&mut gyro.solution, i, w);
                }
            }
        }
    }

    /// The flags of each sample; results of which a needed value is not finite become NaN.
    #[inline(always)]
    fn flag<const N: usize>(
        &self,
        input: &Lanes<'_, T, N>,
        sensed: &[[T; N]; 3],
        tangential: &[[T; N]; 3],
        output: &mut Results<T, N>,
    ) {
        let mut limit = [[T::ZERO; N]; 2];
        let mut outside = [0_u32; N];
        match &self.bound {
            Some(bound) => {
                limit = bound.limit.map(|u| [u; N]);
                if !bound.is_inside() {
                    outside = [flags::OUTSIDE_VALIDITY; N];
                }
            }
            None => {
                for i in 0..N {
                    let size = |y: &[&[T; N]; 3]| vector::norm_inf(y.map(|channel| channel[i]));
                    let bound = self.terms.at([
                        self.range[0].unwrap_or(size(&input.gyro)),
                        self.range[1].unwrap_or(size(&input.accel)),
                    ]);
                    limit[0][i] = bound.limit[0];
                    limit[1][i] = bound.limit[1];
                    if !bound.is_inside() {
                        outside[i] = flags::OUTSIDE_VALIDITY;
                    }
                }
            }
        }
        let shape = self.shape;
        let couples = shape.g || shape.h;
        let thermal = [
            (
                &self.forward.gyro.bias_thermal,
                &self.forward.gyro.scale_thermal,
            ),
            (
                &self.forward.accel.bias_thermal,
                &self.forward.accel.scale_thermal,
            ),
        ];
        let depends = thermal.map(|(bias, scale)| bias.is_present() || scale.is_present());
        for i in 0..N {
            let t = input.temperature_c[i];
            let y = [
                input.gyro.map(|channel| channel[i]),
                input.accel.map(|channel| channel[i]),
            ];
            let finite = |v: [T; 3]| v[0].is_finite() & v[1].is_finite() & v[2].is_finite();
            let t_finite = t.is_finite();
            let gyro_alone = finite(y[0]) & (t_finite | !depends[0]);
            let accel_alone = finite(y[1]) & (t_finite | !depends[1]);
            let moved = finite(take(tangential, i));
            let accel_ok = accel_alone & (!shape.offset | (gyro_alone & moved));
            let gyro_ok = gyro_alone & (!couples | accel_ok);

            let w = take(&output.gyro, i);
            let f = take(&output.accel, i);
            let sensed = take(sensed, i);
            let within =
                |v: [T; 3], u: T| (v[0].abs() <= u) & (v[1].abs() <= u) & (v[2].abs() <= u);
            let in_box = (!gyro_ok | within(w, limit[0][i]))
                & (!accel_ok
                    | (within(sensed, limit[1][i]) & within(take(tangential, i), limit[1][i])));
            let full = |v: [T; 3], edge: [T; 3]| {
                (v[0].abs() >= edge[0]) | (v[1].abs() >= edge[1]) | (v[2].abs() >= edge[2])
            };
            let bit = |condition: bool, bit: u32| if condition { bit } else { 0 };
            output.flags[i] = outside[i]
                | bit(full(y[0], self.saturated[0]), flags::GYRO_SATURATED)
                | bit(full(y[1], self.saturated[1]), flags::ACCEL_SATURATED)
                | bit(!in_box, flags::OUTSIDE_VALIDITY)
                | bit(!(gyro_ok & accel_ok), flags::NOT_FINITE);
            let or_nan = |ok: bool, x: T| if ok { x } else { T::NAN };
            put(&mut output.gyro, i, w.map(|x| or_nan(gyro_ok, x)));
            put(&mut output.accel, i, f.map(|x| or_nan(accel_ok, x)));
        }
        if depends[0] || depends[1] {
            for (bias, scale) in thermal {
                for part in [bias, scale] {
                    part.flag(input.temperature_c, &mut output.flags);
                }
            }
        } else if let Some([low, high]) = self.temperature_range_c {
            for i in 0..N {
                let t = input.temperature_c[i];
                if t < low || t > high {
                    output.flags[i] |= flags::TEMPERATURE;
                }
            }
        }
    }
}

/// b taken off, the inverse matrix of each sample, and the start of the rounds.
#[inline(always)]
fn prepare<T: Real, const N: usize>(
    errors: &TriadErrors<T>,
    inverse: &vector::Matrix<T>,
    y: &[&[T; N]; 3],
    temperature_c: &[T; N],
) -> Prepared<T, N> {
    let mut bias = errors.triad.bias.fixed.map(|b| [b; N]);
    errors.bias_thermal.add_to(temperature_c, &mut bias);
    let mut inverses = inverse.map(|row| row.map(|x| [x; N]));
    if errors.scale_thermal.is_present() {
        let mut scale = [[T::ZERO; N]; 3];
        errors.scale_thermal.add_to(temperature_c, &mut scale);
        for i in 0..N {
            let mut gain = errors.gain;
            for k in 0..3 {
                gain[k][k] += scale[k][i];
            }
            let (of_sample, _) = vector::inverse(&gain);
            for j in 0..3 {
                for k in 0..3 {
                    inverses[j][k][i] = of_sample[j][k];
                }
            }
        }
    }
    let mut prepared = Prepared {
        centered: [[T::ZERO; N]; 3],
        inverse: inverses,
        solution: [[T::ZERO; N]; 3],
    };
    for i in 0..N {
        let centered = vector::sub(y.map(|channel| channel[i]), take(&bias, i));
        let start = vector::apply(&take_matrix(&prepared.inverse, i), centered);
        put(&mut prepared.centered, i, centered);
        put(&mut prepared.solution, i, start);
    }
    prepared
}
