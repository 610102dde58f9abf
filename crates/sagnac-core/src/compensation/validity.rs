//! Which samples have a flag: saturation, temperature, the convergence bound, numbers that are not.

use crate::{
    Bound, Compensation, Measurement, Real,
    bound::BoundTerms,
    flags,
    vector::{self, put, take, take_from},
};

use super::{Lanes, Part, Work};

/// Inside these limits a sample has no flag: what nearly all samples are is told quickly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plain<T> {
    /// |y| below which an axis is not saturated (infinite without a range), gyro and accelerometer.
    output: [[T; 3]; 2],
    /// U of gyro and accelerometer.
    limit: Limit<T>,
    /// Where all temperature terms hold, °C; `None` where the temperature does not matter.
    temperature_c: Option<[T; 2]>,
}

/// U = 1.5 (R + ‖b‖).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Limit<T> {
    /// Both triads have a range.
    Fixed([T; 2]),
    /// R is the sample's own size where a triad has no range; up to `reach` the sample is inside the bound.
    Sample {
        range: [Option<T>; 2],
        bias: [T; 2],
        reach: [T; 2],
    },
}

impl<T: Real> Limit<T> {
    /// `None` where samples inside the bound cannot be told by their size.
    fn new(terms: &BoundTerms<T>, bound: Option<&Bound<T>>, range: [Option<T>; 2]) -> Option<Self> {
        if let Some(bound) = bound {
            // `force` bounds the size effect: within finite limits no result leaves the numbers.
            let limits = [bound.limit[0], bound.limit[1], bound.force];
            let plain = bound.is_inside() && limits.iter().all(|limit| limit.is_finite());
            return plain.then_some(Self::Fixed(bound.limit));
        }
        // What f does to the gyro is judged by the gyro's size: then neither size decides alone.
        if terms.g > T::ZERO || terms.h > T::ZERO {
            return None;
        }
        let mut reach = [range[0].unwrap_or(T::ZERO), range[1].unwrap_or(T::ZERO)];
        for s in 0..2 {
            if range[s].is_some() {
                continue;
            }
            let mut size = T::from_f64(1e-6);
            // The slope of the nonlinearity grows with the size, hence what is inside at a size is inside below it.
            while size <= T::from_f64(1e9) {
                let mut of = reach;
                of[s] = size;
                let bound = terms.at(of);
                if !(bound.is_inside() && bound.force.is_finite()) {
                    break;
                }
                reach[s] = size;
                size = size * T::from_f64(1.5);
            }
        }
        terms.at(reach).is_inside().then_some(Self::Sample {
            range,
            bias: terms.bias,
            reach,
        })
    }
}

impl<T: Real> Plain<T> {
    /// `None` where every sample has a flag, or where a limit is not finite.
    pub(super) fn new(
        forward: &Measurement<T>,
        terms: &BoundTerms<T>,
        bound: Option<&Bound<T>>,
        range: [Option<T>; 2],
        saturated: &[[T; 3]; 2],
        model_range_c: Option<[T; 2]>,
    ) -> Option<Self> {
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
            limit: Limit::new(terms, bound, range)?,
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
        let output = self.output;
        let below = |v: [T; 3], edge: [T; 3]| {
            (v[0].abs() < edge[0]) & (v[1].abs() < edge[1]) & (v[2].abs() < edge[2])
        };
        let within = |v: [T; 3], u: T| (v[0].abs() <= u) & (v[1].abs() <= u) & (v[2].abs() <= u);
        let mut outside = 0_u32;
        match self.limit {
            Limit::Fixed(limit) => {
                for i in 0..N {
                    let holds = below(take_from(input.gyro, i), output[0])
                        & below(take_from(input.accel, i), output[1])
                        & within(take(&work.gyro.solution, i), limit[0])
                        & within(take(&work.accel.solution, i), limit[1])
                        & within(take(&work.tangential, i), limit[1]);
                    outside |= u32::from(!holds);
                }
            }
            Limit::Sample { range, bias, reach } => {
                for i in 0..N {
                    let (w, f) = (take_from(input.gyro, i), take_from(input.accel, i));
                    let gyro = range[0].unwrap_or(vector::norm_inf(w));
                    let accel = range[1].unwrap_or(vector::norm_inf(f));
                    let limit = [
                        T::from_f64(1.5) * (gyro + bias[0]),
                        T::from_f64(1.5) * (accel + bias[1]),
                    ];
                    let holds = below(w, output[0])
                        & below(f, output[1])
                        & (gyro <= reach[0])
                        & (accel <= reach[1])
                        & within(take(&work.gyro.solution, i), limit[0])
                        & within(take(&work.accel.solution, i), limit[1])
                        & within(take(&work.tangential, i), limit[1]);
                    outside |= u32::from(!holds);
                }
            }
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

#[cfg(test)]
mod tests {
    use crate::{Compensation, Reading, SensorModel};

    #[test]
    fn the_quick_answer_without_ranges_is_the_slow_one() {
        let mut linear = SensorModel::<f64>::default();
        linear.gyro.bias.fixed = [0.01, -0.02, 0.0];
        linear.accel.scale_factor.fixed = [0.2, -0.1, 0.05];
        linear.accel.misalignment.elements.xy = 0.1;
        let mut bent = linear;
        bent.accel.nonlinearity.quadratic = [1e-3, 0.0, 2e-3];
        bent.gyro.nonlinearity.cubic = [0.0, 1e-4, 0.0];
        bent.accel_axis_offset.position[0] = [0.02, 0.01, 0.0];
        let mut half = bent;
        half.gyro.range.limit = [5.0; 3];
        half.temperature_range_c = Some([-20.0, 60.0]);
        let mut quick = 0;
        for model in [&linear, &bent, &half] {
            let with = Compensation::new(model, 0.01).expect("a model inside the bound");
            let mut without = with;
            without.plain = None;
            assert!(with.plain.is_some());
            for i in 0..4000_u32 {
                // Sizes from 1e-8 to 1e12, now and then a value that is not finite.
                let size = libm::pow(10.0, f64::from(i % 200) / 10.0 - 8.0);
                let wave = |k: f64| size * libm::sin(f64::from(i) * k);
                let mut raw = Reading {
                    gyro: [wave(0.3), wave(1.7), wave(2.9)],
                    accel: [wave(0.7), wave(1.1), 3.0 * wave(0.2)],
                    gyro_rate: [wave(0.1), 0.0, wave(0.9)],
                    temperature_c: 25.0 + f64::from(i % 9) * 10.0,
                };
                match i % 97 {
                    0 => raw.gyro[1] = f64::NAN,
                    1 => raw.accel[2] = f64::INFINITY,
                    2 => raw.gyro = [1e300; 3],
                    _ => {}
                }
                let (a, b) = (with.correct(&raw), without.correct(&raw));
                assert_eq!(a.flags, b.flags, "{raw:?}");
                let bits = |v: [f64; 3]| v.map(f64::to_bits);
                assert_eq!(bits(a.gyro), bits(b.gyro));
                assert_eq!(bits(a.accel), bits(b.accel));
                quick += u32::from(a.flags == 0);
            }
        }
        assert!(quick > 1000, "{quick}");
    }
}
