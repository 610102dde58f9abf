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
    vector::{self, put, take, take_from, take_matrix},
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
    plain: Option<Plain<T>>,
    shape: Shape,
}

/// Inside these limits a sample has no flag: what nearly all samples are is told quickly.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plain<T> {
    /// |y| below which an axis is not saturated (infinite without a range), gyro and accelerometer.
    output: [[T; 3]; 2],
    /// U of gyro and accelerometer.
    limit: [T; 2],
    /// Where all temperature terms hold, °C; `None` where the temperature does not matter.
    temperature_c: Option<[T; 2]>,
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

/// Where N samples are worked; its `gyro.solution`, `force` and `flags` are the results.
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

/// What a triad needs in every round.
struct Prepared<T, const N: usize> {
    /// y − b.
    centered: [[T; N]; 3],
    /// (I + M)⁻¹.
    inverse: [[[T; N]; 3]; 3],
    /// f' or ω.
    solution: [[T; N]; 3],
    /// The temperature that all of `inverse`, and `bias` and `matrix`, stand for.
    held_c: Option<T>,
    bias: [T; 3],
    matrix: vector::Matrix<T>,
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
        let saturated = [threshold(Sensor::Gyro), threshold(Sensor::Accel)];
        let temperature_range_c = model.temperature_range_c;
        Ok(Self {
            plain: bound
                .as_ref()
                .and_then(|bound| Plain::new(&forward, bound, &saturated, temperature_range_c)),
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

    /// The flags of each sample; results of which a needed value is not finite become NaN.
    #[inline(always)]
    fn flag<const N: usize>(&self, input: &Lanes<'_, T, N>, work: &mut Work<T, N>) {
        if let Some(plain) = &self.plain
            && plain.holds(input, work)
        {
            work.flags = [0; N];
            return;
        }
        let mut limit = [[T::ZERO; N]; 2];
        let mut outside = [0_u32; N];
        match &self.bound {
            Some(bound) => {
                limit = [[bound.limit[0]; N], [bound.limit[1]; N]];
                if !bound.is_inside() {
                    outside = [flags::OUTSIDE_VALIDITY; N];
                }
            }
            None => {
                for i in 0..N {
                    let size = |y: [&[T; N]; 3]| vector::norm_inf(take_from(y, i));
                    let bound = self.terms.at([
                        self.range[0].unwrap_or(size(input.gyro)),
                        self.range[1].unwrap_or(size(input.accel)),
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
        let (couples, has_offset) = (shape.couples(), shape.offset != Part::None);
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
        let saturated = self.saturated;
        for i in 0..N {
            let t = input.temperature_c[i];
            let y = [take_from(input.gyro, i), take_from(input.accel, i)];
            let finite = |v: [T; 3]| v[0].is_finite() & v[1].is_finite() & v[2].is_finite();
            let t_finite = t.is_finite();
            let gyro_alone = finite(y[0]) & (t_finite | !depends[0]);
            let accel_alone = finite(y[1]) & (t_finite | !depends[1]);
            let tangential = take(&work.tangential, i);
            let moved = finite(tangential);
            let accel_ok = accel_alone & (!has_offset | (gyro_alone & moved));
            let gyro_ok = gyro_alone & (!couples | accel_ok);

            let w = take(&work.gyro.solution, i);
            let f = take(&work.force, i);
            let sensed = take(&work.accel.solution, i);
            let within =
                |v: [T; 3], u: T| (v[0].abs() <= u) & (v[1].abs() <= u) & (v[2].abs() <= u);
            let in_box = (!gyro_ok | within(w, limit[0][i]))
                & (!accel_ok | (within(sensed, limit[1][i]) & within(tangential, limit[1][i])));
            let full = |v: [T; 3], edge: [T; 3]| {
                (v[0].abs() >= edge[0]) | (v[1].abs() >= edge[1]) | (v[2].abs() >= edge[2])
            };
            let bit = |condition: bool, bit: u32| if condition { bit } else { 0 };
            work.flags[i] = outside[i]
                | bit(full(y[0], saturated[0]), flags::GYRO_SATURATED)
                | bit(full(y[1], saturated[1]), flags::ACCEL_SATURATED)
                | bit(!in_box, flags::OUTSIDE_VALIDITY)
                | bit(!(gyro_ok & accel_ok), flags::NOT_FINITE);
            let or_nan = |ok: bool, x: T| if ok { x } else { T::NAN };
            let or_nan_3 =
                |ok: bool, v: [T; 3]| [or_nan(ok, v[0]), or_nan(ok, v[1]), or_nan(ok, v[2])];
            put(&mut work.gyro.solution, i, or_nan_3(gyro_ok, w));
            put(&mut work.force, i, or_nan_3(accel_ok, f));
        }
        if depends[0] || depends[1] {
            for (bias, scale) in thermal {
                for part in [bias, scale] {
                    part.flag(input.temperature_c, &mut work.flags);
                }
            }
        } else if let Some([low, high]) = self.temperature_range_c {
            for i in 0..N {
                let t = input.temperature_c[i];
                if t < low || t > high {
                    work.flags[i] |= flags::TEMPERATURE;
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

impl<T: Real> Plain<T> {
    /// `None` where every sample has a flag, or where a limit is not finite.
    fn new(
        forward: &Measurement<T>,
        bound: &Bound<T>,
        saturated: &[[T; 3]; 2],
        model_range_c: Option<[T; 2]>,
    ) -> Option<Self> {
        if !(bound.is_inside() && bound.limit.iter().all(|limit| limit.is_finite())) {
            return None;
        }
        let mut temperature_c = None;
        let mut depends = false;
        for errors in [&forward.gyro, &forward.accel] {
            for part in [&errors.bias_thermal, &errors.scale_thermal] {
                if part.is_present() {
                    depends = true;
                    let default = crate::DEFAULT_RANGE_C.map(T::from_f64);
                    let [low, high] = part.range_c().unwrap_or(default);
                    let [lowest, highest] = temperature_c.unwrap_or([low, high]);
                    temperature_c = Some([
                        lowest.larger(low),
                        if high < highest { high } else { highest },
                    ]);
                }
            }
        }
        Some(Self {
            output: saturated.map(|of| of.map(|x| if x <= T::INFINITY { x } else { T::INFINITY })),
            limit: bound.limit,
            temperature_c: if depends {
                temperature_c
            } else {
                model_range_c
            },
        })
    }

    /// Whether no sample has a flag; where it says no, some may have none either.
    #[inline(always)]
    fn holds<const N: usize>(&self, input: &Lanes<'_, T, N>, work: &Work<T, N>) -> bool {
        let Self { output, limit, .. } = *self;
        let below = |v: [T; 3], edge: [T; 3]| {
            (v[0].abs() < edge[0]) & (v[1].abs() < edge[1]) & (v[2].abs() < edge[2])
        };
        let within = |v: [T; 3], u: T| (v[0].abs() <= u) & (v[1].abs() <= u) & (v[2].abs() <= u);
        let mut outside = 0_u32;
        for i in 0..N {
            let holds = below(take_from(input.gyro, i), output[0])
                & below(take_from(input.accel, i), output[1])
                & within(take(&work.gyro.solution, i), limit[0])
                & within(take(&work.accel.solution, i), limit[1])
                & within(take(&work.tangential, i), limit[1]);
            outside |= u32::from(!holds);
        }
        if let Some([low, high]) = self.temperature_c {
            for i in 0..N {
                let t = input.temperature_c[i];
                outside |= u32::from(!((t >= low) & (t <= high)));
            }
        }
        outside == 0
    }
}

impl<T: Real, const N: usize> Prepared<T, N> {
    #[inline(always)]
    fn zero() -> Self {
        Self {
            centered: [[T::ZERO; N]; 3],
            inverse: [[[T::ZERO; N]; 3]; 3],
            solution: [[T::ZERO; N]; 3],
            held_c: None,
            bias: [T::ZERO; 3],
            matrix: [[T::ZERO; 3]; 3],
        }
    }

    /// b taken off, the inverse matrix of each sample, and the start of the rounds; `common_c`
    /// is the temperature where all samples have the same, or where it changes nothing.
    #[inline(always)]
    fn fill(
        &mut self,
        errors: &TriadErrors<T>,
        y: [&[T; N]; 3],
        temperature_c: &[T; N],
        common_c: Option<T>,
    ) {
        if let Some(t) = common_c {
            if self.held_c != Some(t) {
                self.held_c = Some(t);
                self.bias = errors.bias(t);
                self.matrix = vector::inverse(&errors.gain(t)).0;
                for j in 0..3 {
                    for k in 0..3 {
                        self.inverse[j][k] = [self.matrix[j][k]; N];
                    }
                }
            }
            let (bias, matrix) = (self.bias, self.matrix);
            for i in 0..N {
                let centered = vector::sub(take_from(y, i), bias);
                put(&mut self.centered, i, centered);
                put(&mut self.solution, i, vector::apply(&matrix, centered));
            }
            return;
        }
        self.held_c = None;
        let fixed = errors.triad.bias.fixed;
        let mut bias = [[fixed[0]; N], [fixed[1]; N], [fixed[2]; N]];
        errors.bias_thermal.add_to(temperature_c, &mut bias);
        if !errors.scale_thermal.is_present() {
            let (matrix, _) = vector::inverse(&errors.gain);
            for i in 0..N {
                for j in 0..3 {
                    put(&mut self.inverse[j], i, matrix[j]);
                }
                let centered = vector::sub(take_from(y, i), take(&bias, i));
                put(&mut self.centered, i, centered);
                put(&mut self.solution, i, vector::apply(&matrix, centered));
            }
            return;
        }
        let mut scale = [[T::ZERO; N]; 3];
        errors.scale_thermal.add_to(temperature_c, &mut scale);
        let at_reference = errors.gain;
        for i in 0..N {
            let mut gain = at_reference;
            for k in 0..3 {
                gain[k][k] += scale[k][i];
            }
            let (of_sample, _) = vector::inverse(&gain);
            for j in 0..3 {
                put(&mut self.inverse[j], i, of_sample[j]);
            }
            let centered = vector::sub(take_from(y, i), take(&bias, i));
            put(&mut self.centered, i, centered);
            put(&mut self.solution, i, vector::apply(&of_sample, centered));
        }
    }
}
