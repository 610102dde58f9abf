//! Which samples have a flag: saturation, temperature, the convergence bound, numbers that are not.

use crate::{
    Bound, Compensation, Measurement, Real, flags,
    vector::{self, put, take, take_from},
};

use super::{Lanes, Part, Work};

/// Inside these limits a sample has no flag: what nearly all samples are is told quickly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plain<T> {
    /// |y| below which an axis is not saturated (infinite without a range), gyro and accelerometer.
    output: [[T; 3]; 2],
    /// U of gyro and accelerometer.
    limit: [T; 2],
    /// Where all temperature terms hold, °C; `None` where the temperature does not matter.
    temperature_c: Option<[T; 2]>,
}

impl<T: Real> Plain<T> {
    /// `None` where every sample has a flag, or where a limit is not finite.
    pub(super) fn new(
        forward: &Measurement<T>,
        bound: &Bound<T>,
        saturated: &[[T; 3]; 2],
        model_range_c: Option<[T; 2]>,
    ) -> Option<Self> {
        // `force` bounds the size effect: within finite limits no result leaves the numbers.
        let limits = [bound.limit[0], bound.limit[1], bound.force];
        if !(bound.is_inside() && limits.iter().all(|limit| limit.is_finite())) {
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
    pub(super) fn holds<const N: usize>(&self, input: &Lanes<'_, T, N>, work: &Work<T, N>) -> bool {
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

impl<T: Real> Compensation<T> {
    /// The flags of each sample; results that are not finite, or of which a needed value is not, become NaN.
    #[inline(always)]
    pub(super) fn flag<const N: usize>(&self, input: &Lanes<'_, T, N>, work: &mut Work<T, N>) {
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
            // Far outside, the rounds may run off to infinity from values that are all finite.
            let (gyro_ok, accel_ok) = (gyro_ok & finite(w), accel_ok & finite(f));
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
