//! Blocks of samples, a slice a channel: the fast way through the model and its inverse.
//!
//! The same operations as on one sample, on 32 samples at a time, so that they become vector
//! instructions; the results have the same bits (`tests/block.rs`).

use crate::{
    Compensation, Measurement, Real,
    compensation::{Lanes, Work},
    simd::{Kernel, dispatch},
};

/// Samples worked at once: their intermediate results stay in the nearest cache.
const LANES: usize = 32;

/// Raw output, a slice a channel.
#[derive(Clone, Copy, Debug)]
pub struct ReadingBlock<'a, T> {
    /// y_g: x, y, z, rad/s.
    pub gyro: [&'a [T]; 3],
    /// y_a: x, y, z, m/s².
    pub accel: [&'a [T]; 3],
    /// ω̇: x, y, z, rad/s²; without it the tangential part of the size effect is left out.
    pub gyro_rate: Option<[&'a [T]; 3]>,
    /// T, °C; without it T0.
    pub temperature_c: Option<&'a [T]>,
}

/// Where corrected samples go.
#[derive(Debug)]
pub struct CorrectedBlock<'a, T> {
    /// ω: x, y, z, rad/s.
    pub gyro: [&'a mut [T]; 3],
    /// f: x, y, z, m/s².
    pub accel: [&'a mut [T]; 3],
    /// The [`flags`](crate::flags) of each sample.
    pub flags: &'a mut [u32],
}

/// Truth, a slice a channel.
#[derive(Clone, Copy, Debug)]
pub struct TruthBlock<'a, T> {
    /// f: x, y, z, m/s².
    pub specific_force: [&'a [T]; 3],
    /// ω: x, y, z, rad/s.
    pub angular_rate: [&'a [T]; 3],
    /// ω̇: x, y, z, rad/s²; zero where it is not given.
    pub angular_acceleration: Option<[&'a [T]; 3]>,
    /// T, °C; T0 where it is not given.
    pub temperature_c: Option<&'a [T]>,
}

/// Where the output of the forward model goes.
#[derive(Debug)]
pub struct OutputBlock<'a, T> {
    /// Gyro: x, y, z, rad/s.
    pub gyro: [&'a mut [T]; 3],
    /// Accelerometer: x, y, z, m/s².
    pub accel: [&'a mut [T]; 3],
}

/// 32 numbers from `at` on where they lie, or copied to `spare` where fewer are left.
#[inline(always)]
fn lanes<'s, T: Real>(from: &'s [T], at: usize, spare: &'s mut [T; LANES]) -> &'s [T; LANES] {
    let rest = from.get(at..).unwrap_or(&[]);
    if let Some(whole) = rest.first_chunk::<LANES>() {
        return whole;
    }
    *spare = [T::ZERO; LANES];
    for (to, from) in spare.iter_mut().zip(rest) {
        *to = *from;
    }
    spare
}

#[inline(always)]
fn lanes_three<'s, T: Real>(
    [x, y, z]: [&'s [T]; 3],
    at: usize,
    [sx, sy, sz]: [&'s mut [T; LANES]; 3],
) -> [&'s [T; LANES]; 3] {
    [lanes(x, at, sx), lanes(y, at, sy), lanes(z, at, sz)]
}

#[inline(always)]
fn store<T: Copy>(lanes: &[T; LANES], to: &mut [T], at: usize) {
    if let Some(rest) = to.get_mut(at..) {
        if let Some(whole) = rest.first_chunk_mut::<LANES>() {
            *whole = *lanes;
        } else {
            for (to, from) in rest.iter_mut().zip(lanes) {
                *to = *from;
            }
        }
    }
}

fn shortest<T>(start: usize, channels: &[&[T]]) -> usize {
    channels
        .iter()
        .fold(start, |n, channel| n.min(channel.len()))
}

struct CorrectKernel<'k, 'a, T: Real> {
    inverse: &'k Compensation<T>,
    input: &'k ReadingBlock<'a, T>,
    output: &'k mut CorrectedBlock<'a, T>,
    count: usize,
}

impl<T: Real> Kernel for CorrectKernel<'_, '_, T> {
    #[inline(always)]
    fn run(self) {
        let t0 = [self.inverse.measurement().reference_c; LANES];
        let zero = [T::ZERO; LANES];
        let none = [&zero; 3];
        let mut work = Work::<T, LANES>::new();
        // Where the last, short piece is copied to.
        let mut spare = [zero; 10];
        let mut at = 0;
        while at < self.count {
            let [s0, s1, s2, s3, s4, s5, s6, s7, s8, s9] = &mut spare;
            let lanes = Lanes {
                gyro: lanes_three(self.input.gyro, at, [s0, s1, s2]),
                accel: lanes_three(self.input.accel, at, [s3, s4, s5]),
                gyro_rate: match self.input.gyro_rate {
                    Some(rate) => lanes_three(rate, at, [s6, s7, s8]),
                    None => none,
                },
                temperature_c: match self.input.temperature_c {
                    Some(temperature) => lanes(temperature, at, s9),
                    None => &t0,
                },
            };
            self.inverse.correct_lanes(&lanes, &mut work);
            for (lanes, to) in work.gyro().iter().zip(&mut self.output.gyro) {
                store(lanes, to, at);
            }
            for (lanes, to) in work.accel().iter().zip(&mut self.output.accel) {
                store(lanes, to, at);
            }
            store(work.flags(), self.output.flags, at);
            at += LANES;
        }
    }
}

impl<T: Real> Compensation<T> {
    /// Corrects a block and returns the number of samples: the length of the shortest channel.
    ///
    /// Bit for bit what [`Compensation::correct`] gives one by one.
    ///
    /// ```
    /// use sagnac_core::{Compensation, CorrectedBlock, ReadingBlock, SensorModel};
    ///
    /// let mut model = SensorModel::<f64>::default();
    /// model.gyro.bias.fixed = [0.1, 0.0, 0.0];
    /// let raw = [1.0; 100];
    /// let (mut w, mut f, mut flags) = ([[0.0; 100]; 3], [[0.0; 100]; 3], [0; 100]);
    /// let ([wx, wy, wz], [fx, fy, fz]) = (&mut w, &mut f);
    /// let n = Compensation::new(&model, 0.01)?.correct_block(
    ///     &ReadingBlock { gyro: [&raw; 3], accel: [&raw; 3], gyro_rate: None, temperature_c: None },
    ///     &mut CorrectedBlock { gyro: [wx, wy, wz], accel: [fx, fy, fz], flags: &mut flags },
    /// );
    /// assert_eq!((n, w[0][99]), (100, 0.9));
    /// # Ok::<(), sagnac_core::CompensationError>(())
    /// ```
    pub fn correct_block<'a>(
        &self,
        input: &ReadingBlock<'a, T>,
        output: &mut CorrectedBlock<'a, T>,
    ) -> usize {
        let mut count = shortest(output.flags.len(), &input.gyro);
        count = shortest(count, &input.accel);
        if let Some(rate) = &input.gyro_rate {
            count = shortest(count, rate);
        }
        if let Some(temperature) = input.temperature_c {
            count = count.min(temperature.len());
        }
        for channel in output.gyro.iter_mut().chain(&mut output.accel) {
            count = count.min(channel.len());
        }
        // Channels are cut to one length, so that nothing is written beyond it.
        let mut cut = CorrectedBlock {
            gyro: cut_three(&mut output.gyro, count),
            accel: cut_three(&mut output.accel, count),
            flags: output.flags.get_mut(..count).unwrap_or(&mut []),
        };
        dispatch(CorrectKernel {
            inverse: self,
            input: &ReadingBlock { ..*input },
            output: &mut cut,
            count,
        });
        count
    }
}

fn cut_three<'s, T>(channels: &'s mut [&mut [T]; 3], count: usize) -> [&'s mut [T]; 3] {
    let [x, y, z] = channels;
    [
        x.get_mut(..count).unwrap_or(&mut []),
        y.get_mut(..count).unwrap_or(&mut []),
        z.get_mut(..count).unwrap_or(&mut []),
    ]
}

struct CorruptKernel<'k, 'a, 'b, T: Real> {
    forward: &'k Measurement<T>,
    input: &'k TruthBlock<'a, T>,
    output: &'k mut OutputBlock<'b, T>,
    count: usize,
}

impl<T: Real> Kernel for CorruptKernel<'_, '_, '_, T> {
    #[inline(always)]
    fn run(self) {
        let mut gyro = [[T::ZERO; LANES]; 3];
        let mut accel = [[T::ZERO; LANES]; 3];
        let t0 = [self.forward.reference_c; LANES];
        let zero = [T::ZERO; LANES];
        // Where the last, short piece is copied to.
        let mut spare = [zero; 10];
        let mut at = 0;
        while at < self.count {
            let [s0, s1, s2, s3, s4, s5, s6, s7, s8, s9] = &mut spare;
            let truth = Lanes {
                gyro: lanes_three(self.input.angular_rate, at, [s0, s1, s2]),
                accel: lanes_three(self.input.specific_force, at, [s3, s4, s5]),
                gyro_rate: match self.input.angular_acceleration {
                    Some(wdot) => lanes_three(wdot, at, [s6, s7, s8]),
                    None => [&zero; 3],
                },
                temperature_c: match self.input.temperature_c {
                    Some(temperature) => lanes(temperature, at, s9),
                    None => &t0,
                },
            };
            self.forward.corrupt_lanes(&truth, &mut gyro, &mut accel);
            for (lanes, to) in gyro.iter().zip(&mut self.output.gyro) {
                store(lanes, to, at);
            }
            for (lanes, to) in accel.iter().zip(&mut self.output.accel) {
                store(lanes, to, at);
            }
            at += LANES;
        }
    }
}

impl<T: Real> Measurement<T> {
    /// The forward model on a block; returns the number of samples: the length of the
    /// shortest channel. Bit for bit what [`Measurement::corrupt`] gives one by one.
    pub fn corrupt_block(
        &self,
        input: &TruthBlock<'_, T>,
        output: &mut OutputBlock<'_, T>,
    ) -> usize {
        let mut count = shortest(usize::MAX, &input.specific_force);
        count = shortest(count, &input.angular_rate);
        if let Some(wdot) = &input.angular_acceleration {
            count = shortest(count, wdot);
        }
        if let Some(temperature) = input.temperature_c {
            count = count.min(temperature.len());
        }
        for channel in output.gyro.iter_mut().chain(&mut output.accel) {
            count = count.min(channel.len());
        }
        let mut cut = OutputBlock {
            gyro: cut_three(&mut output.gyro, count),
            accel: cut_three(&mut output.accel, count),
        };
        dispatch(CorruptKernel {
            forward: self,
            input,
            output: &mut cut,
            count,
        });
        count
    }
}
