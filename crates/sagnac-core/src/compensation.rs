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

mod prepared;
mod validity;

use crate::{
    Bound, CompensationError, Corrected, Measurement, Reading, Real, Sensor, SensorModel,
    TriadErrors,
    bound::BoundTerms,
    vector::{self, put, take, take_from, take_matrix},
};
use prepared::Prepared;
use validity::Plain;

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
    plain: Option<Plain<T>>,
    shape: Shape,
}

/// How much of a matrix is there: what is absent costs nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    None,
    Diagonal,
    Full,
}

impl Part {
    const fn of(is_present: bool, is_diagonal: bool) -> Self {
        if !is_present {
            Self::None
        } else if is_diagonal {
            Self::Diagonal
        } else {
            Self::Full
        }
    }
}

/// Which terms a model has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "terms that are there or not, known to the compiler one by one"
)]
struct Shape {
    gyro_nonlinear: bool,
    accel_nonlinear: bool,
    g: Part,
    squares: bool,
    products: bool,
    offset: Part,
}

impl Shape {
    #[inline(always)]
    fn couples(self) -> bool {
        self.g != Part::None || self.squares || self.products
    }
}

/// N readings, a slice of N numbers a channel.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<'a, T, const N: usize> {
    pub(crate) gyro: [&'a [T; N]; 3],
    pub(crate) accel: [&'a [T; N]; 3],
    pub(crate) gyro_rate: [&'a [T; N]; 3],
    pub(crate) temperature_c: &'a [T; N],
}

/// Where N samples are worked; its `gyro.solution`, `force` and `flags` are the results. Its vectors
/// begin with the lines of the cache.
#[repr(align(64))]
pub(crate) struct Work<T, const N: usize> {
    gyro: Prepared<T, N>,
    accel: Prepared<T, N>,
    tangential: [[T; N]; 3],
    force: [[T; N]; 3],
    flags: [u32; N],
}

impl<T: Real, const N: usize> Work<T, N> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self {
            gyro: Prepared::zero(),
            accel: Prepared::zero(),
            tangential: [[T::ZERO; N]; 3],
            force: [[T::ZERO; N]; 3],
            flags: [0; N],
        }
    }

    pub(crate) fn gyro(&self) -> &[[T; N]; 3] {
        &self.gyro.solution
    }

    pub(crate) fn accel(&self) -> &[[T; N]; 3] {
        &self.force
    }

    pub(crate) fn flags(&self) -> &[u32; N] {
        &self.flags
    }
}

impl<T: Real> Compensation<T> {
    /// The inverse of a model for samples `dt_s` apart (which only says where an increment
    /// output saturates).
    ///
    /// # Errors
    /// [`CompensationError`]: I + M is singular, μ + ν ≥ 1, a parameter or a sum of them is not finite, or
    /// `dt_s` is not positive. A model between the bound and that is taken, and every sample
    /// gets [`flags::OUTSIDE_VALIDITY`](crate::flags::OUTSIDE_VALIDITY).
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
        let saturated = [threshold(Sensor::Gyro), threshold(Sensor::Accel)];
        let temperature_range_c = model.temperature_range_c;
        Ok(Self {
            plain: Plain::new(
                &forward,
                &terms,
                bound.as_ref(),
                range,
                &saturated,
                temperature_range_c,
            ),
            forward,
            terms,
            bound,
            range,
            rounds: terms.rounds(range),
            inverse: [
                vector::inverse(&forward.gyro.gain).0,
                vector::inverse(&forward.accel.gain).0,
            ],
            saturated,
            temperature_range_c,
            shape: Shape {
                gyro_nonlinear: forward.gyro.is_nonlinear,
                accel_nonlinear: forward.accel.is_nonlinear,
                g: Part::of(
                    model.gyro_g_sensitivity.is_present(),
                    model.gyro_g_sensitivity.is_diagonal(),
                ),
                squares: model.gyro_g2_sensitivity.has_squares(),
                products: model.gyro_g2_sensitivity.has_products(),
                offset: Part::of(
                    model.accel_axis_offset.is_present(),
                    model.accel_axis_offset.is_own(),
                ),
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

    /// What the bound needs of the model.
    pub fn bound_terms(&self) -> &BoundTerms<T> {
        &self.terms
    }

    /// (I + M)⁻¹ at T0.
    pub fn inverse(&self, sensor: Sensor) -> vector::Matrix<T> {
        match sensor {
            Sensor::Gyro => self.inverse[0],
            Sensor::Accel => self.inverse[1],
        }
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

    /// The corrected reading and its [`flags`](crate::flags).
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
        let mut work = Work::<T, 1>::new();
        self.correct_lanes(&lanes, &mut work);
        Corrected {
            gyro: take(work.gyro(), 0),
            accel: take(work.accel(), 0),
            flags: work.flags()[0],
        }
    }

    /// N samples at once; the operations on each are the same for every N.
    #[inline(always)]
    pub(crate) fn correct_lanes<const N: usize>(
        &self,
        input: &Lanes<'_, T, N>,
        work: &mut Work<T, N>,
    ) {
        use Part::{Diagonal, Full, None};
        let shape = self.shape;
        let t = input.temperature_c;
        let common = common(t);
        let reference_c = self.forward.reference_c;
        let temperature = |errors: &TriadErrors<T>| {
            if errors.depends_on_temperature() {
                common
            } else {
                Some(reference_c)
            }
        };
        let (gyro, accel) = (&self.forward.gyro, &self.forward.accel);
        work.gyro.fill(gyro, input.gyro, t, temperature(gyro));
        work.accel.fill(accel, input.accel, t, temperature(accel));
        if let Some(offset) = self.forward.axis_offset {
            for i in 0..N {
                let wdot = take_from(input.gyro_rate, i);
                put(&mut work.tangential, i, offset.tangential(wdot));
            }
        }
        // The rounds are compiled for the usual sets of terms, in which the loops become
        // vector code, and once for any set.
        macro_rules! rounds {
            ($(($n_g:tt, $n_a:tt, $g:tt, $squares:tt, $products:tt, $offset:tt)),*) => {
                match shape {
                    $(Shape {
                        gyro_nonlinear: $n_g,
                        accel_nonlinear: $n_a,
                        g: $g,
                        squares: $squares,
                        products: $products,
                        offset: $offset,
                    } if N > 1 => self.run_rounds(work, Shape {
                        gyro_nonlinear: $n_g,
                        accel_nonlinear: $n_a,
                        g: $g,
                        squares: $squares,
                        products: $products,
                        offset: $offset,
                    }),)*
                    _ => self.run_rounds(work, shape),
                }
            };
        }
        rounds!(
            (false, false, None, false, false, None),
            (false, false, Full, false, false, None),
            (false, false, None, false, false, Full),
            (false, false, Full, false, false, Full),
            (false, false, Diagonal, false, false, Diagonal),
            (false, false, Diagonal, false, true, Diagonal),
            (true, true, Diagonal, false, false, Diagonal),
            (true, true, Diagonal, false, true, Diagonal),
            (false, false, Full, true, true, Full),
            (true, true, Full, false, false, Full),
            (true, true, Full, true, true, Full)
        );
        self.flag(input, work);
    }

    /// The rounds themselves; `shape` says which terms there are.
    #[inline(always)]
    fn run_rounds<const N: usize>(&self, work: &mut Work<T, N>, shape: Shape) {
        // Copies, so that the loops hold their numbers in registers.
        let g = self.forward.g_sensitivity.unwrap_or_default();
        let h = self.forward.g2_sensitivity.unwrap_or_default();
        let r = self.forward.axis_offset.unwrap_or_default();
        let n_a = self.forward.accel.nonlinearity();
        let n_g = self.forward.gyro.nonlinearity();
        let (gyro, accel) = (&mut work.gyro, &mut work.accel);
        for _ in 0..self.rounds {
            for i in 0..N {
                let w = take(&gyro.solution, i);
                let mut f = take(&accel.solution, i);
                if shape.accel_nonlinear {
                    let rest = vector::sub(take(&accel.centered, i), n_a.part(f));
                    f = vector::apply(&take_matrix(&accel.inverse, i), rest);
                    put(&mut accel.solution, i, f);
                }
                match shape.offset {
                    Part::None => {}
                    // ω̇ × r_k has no component along r_k.
                    Part::Diagonal => f = vector::add(f, r.centrifugal_own(w)),
                    Part::Full => {
                        let effect = vector::add(r.centripetal(w), take(&work.tangential, i));
                        f = vector::sub(f, effect);
                    }
                }
                put(&mut work.force, i, f);
                if shape.couples() || shape.gyro_nonlinear {
                    let mut rest = take(&gyro.centered, i);
                    match shape.g {
                        Part::None => {}
                        Part::Diagonal => rest = vector::sub(rest, g.diagonal_part(f)),
                        Part::Full => rest = vector::sub(rest, g.part(f)),
                    }
                    if shape.squares {
                        rest = vector::sub(rest, h.square_part(f));
                    }
                    if shape.products {
                        rest = vector::sub(rest, h.product_part(f));
                    }
                    if shape.gyro_nonlinear {
                        rest = vector::sub(rest, n_g.part(w));
                    }
                    let w = vector::apply(&take_matrix(&gyro.inverse, i), rest);
                    put(&mut gyro.solution, i, w);
                }
            }
        }
    }
}

/// The temperature of all samples, where it is one.
#[inline(always)]
fn common<T: Real, const N: usize>(temperature_c: &[T; N]) -> Option<T> {
    let first = temperature_c[0];
    let mut differs = 0_u32;
    for i in 0..N {
        differs |= u32::from(temperature_c[i] != first);
    }
    (differs == 0).then_some(first)
}
