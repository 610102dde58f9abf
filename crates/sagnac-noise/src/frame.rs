//! Samples are made in frames of 256, so that no sample depends on how a caller cuts its blocks.
//!
//! Also the first-order recursion y_k = φ y_{k−1} + u_k, by prefix sums in groups of eight: the
//! chain of dependent operations is eight times shorter, the result the same on every processor.

use crate::dispatch::dispatch;
use crate::gaussian::transform;
use crate::stream::{BLOCK, Stream};

/// Samples in a frame.
pub const FRAME: usize = 2 * BLOCK;

/// A frame of samples.
pub type Frame = [f64; FRAME];

/// A random term that makes its samples frame by frame, in order.
pub trait Generator {
    /// Adds the next [`FRAME`] samples (interval means) to `frame`; `scratch` is room to work in.
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch);
}

/// Room that generators work in; nothing in it outlives a call, one serves any number of them.
#[derive(Debug, Clone)]
pub struct Scratch {
    pub(crate) words: [u64; BLOCK],
    pub(crate) normals: Frame,
    first: [f64; FRAME + MARGIN],
    second: [f64; FRAME + MARGIN],
}

impl Default for Scratch {
    fn default() -> Self {
        Self {
            words: [0; BLOCK],
            normals: [0.0; FRAME],
            first: [0.0; FRAME + MARGIN],
            second: [0.0; FRAME + MARGIN],
        }
    }
}

impl Scratch {
    /// Puts the next frame of standard normal numbers of `stream` into `normals`.
    pub(crate) fn next_normals(&mut self, stream: &mut Stream) {
        stream.next_block(&mut self.words);
        transform(&self.words, &mut self.normals);
    }
}

/// Zeros in front of a frame serve the looks back.
const MARGIN: usize = 4;

const GROUP: usize = 8;

/// The recursion y_k = φ y_{k−1} + u_k.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FirstOrder {
    /// φ, φ², φ⁴ where the sample that far back is in the same group, else 0.
    steps: [[f64; GROUP]; 3],
    /// φ, φ² … φ⁸.
    powers: [f64; GROUP],
    last: f64,
}

impl FirstOrder {
    pub(crate) fn new(phi: f64) -> Self {
        let phi2 = phi * phi;
        let phi4 = phi2 * phi2;
        let step = |back: usize, factor: f64| {
            core::array::from_fn(|k| if k >= back { factor } else { 0.0 })
        };
        let mut powers = [phi; GROUP];
        for k in 1..GROUP {
            powers[k] = powers[k - 1] * phi;
        }
        Self {
            steps: [step(1, phi), step(2, phi2), step(4, phi4)],
            powers,
            last: 0.0,
        }
    }
}

/// Runs the recursion on u, which stands in `first` behind its margin, and adds y to `out`.
#[inline(always)]
fn add_recursion_body(filter: &mut FirstOrder, scratch: &mut Scratch, out: &mut Frame) {
    look_back::<1>(&filter.steps[0], &scratch.first, &mut scratch.second);
    look_back::<2>(&filter.steps[1], &scratch.second, &mut scratch.first);
    look_back::<4>(&filter.steps[2], &scratch.first, &mut scratch.second);
    let mut last = filter.last;
    let groups = scratch.second[MARGIN..].as_chunks::<GROUP>().0;
    for (group, out) in groups.iter().zip(out.as_chunks_mut::<GROUP>().0) {
        for k in 0..GROUP {
            out[k] += group[k] + filter.powers[k] * last;
        }
        last = group[GROUP - 1] + filter.powers[GROUP - 1] * last;
    }
    filter.last = last;
}

#[inline(always)]
fn look_back<const BACK: usize>(
    factors: &[f64; GROUP],
    from: &[f64; FRAME + MARGIN],
    to: &mut [f64; FRAME + MARGIN],
) {
    let mut at = MARGIN;
    while at < FRAME + MARGIN {
        for k in 0..GROUP {
            to[at + k] = from[at + k] + factors[k] * from[at + k - BACK];
        }
        at += GROUP;
    }
}

dispatch! {
    fn add_recursion(filter: &mut FirstOrder, scratch: &mut Scratch, out: &mut Frame)
        = add_recursion_body;
}

/// An ARMA(1, 1) process started at its first sample: y_k = φ y_{k−1} + u_k where u has the
/// variance V (v₁ for the first) and the covariance c between neighbours. By the innovations
/// recursion (`[BrockwellDavis]` 5.2) u_k = √v_k e_k + (c/√v_{k−1}) e_{k−1}, v_k = V − c²/v_{k−1}:
/// one normal number a sample, and the joint law is right from the first sample on.
#[derive(Debug, Clone)]
pub(crate) struct OneNormal {
    stream: Stream,
    filter: FirstOrder,
    variance: f64,
    covariance: f64,
    /// √v_k of the next sample, and c/√v_{k−1}.
    gain: f64,
    carry: f64,
    last_normal: f64,
    settled: bool,
}

impl OneNormal {
    pub(crate) fn new(
        stream: Stream,
        phi: f64,
        first_variance: f64,
        variance: f64,
        covariance: f64,
    ) -> Self {
        Self {
            stream,
            filter: FirstOrder::new(phi),
            variance,
            covariance,
            gain: libm::sqrt(first_variance),
            carry: 0.0,
            last_normal: 0.0,
            settled: false,
        }
    }
}

impl Generator for OneNormal {
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch) {
        scratch.next_normals(&mut self.stream);
        if self.settled {
            moving_average(self.gain, self.carry, self.last_normal, scratch);
        } else {
            // v_k converges within this frame: its error shrinks by more than ten a sample.
            let mut last = 0.0;
            for (driven, normal) in scratch.first[MARGIN..].iter_mut().zip(&scratch.normals) {
                *driven = self.gain * normal + self.carry * last;
                last = *normal;
                self.carry = self.covariance / self.gain;
                self.gain = libm::sqrt(self.variance - self.carry * self.carry);
            }
            self.settled = true;
        }
        self.last_normal = scratch.normals[FRAME - 1];
        add_recursion(&mut self.filter, scratch, frame);
    }
}

#[inline(always)]
fn moving_average_body(gain: f64, carry: f64, before: f64, scratch: &mut Scratch) {
    scratch.first[MARGIN] = gain * scratch.normals[0] + carry * before;
    for (out, pair) in scratch.first[MARGIN + 1..]
        .iter_mut()
        .zip(scratch.normals.windows(2))
    {
        *out = gain * pair[1] + carry * pair[0];
    }
}

dispatch! {
    fn moving_average(gain: f64, carry: f64, before: f64, scratch: &mut Scratch)
        = moving_average_body;
}
