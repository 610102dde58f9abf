//! Samples are made in frames of 256, so that no sample depends on how a caller cuts its blocks.
//!
//! Also the first-order recursion y_k = φ y_{k−1} + u_k, in groups of four: the chain of dependent
//! operations is four times shorter, the result the same on every processor.

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

/// Room that generators work in; nothing in it outlives a call, one serves any number of them. Its vectors begin with the
/// lines of the cache.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Scratch {
    pub(crate) words: [u64; BLOCK],
    pub(crate) normals: Frame,
}

impl Default for Scratch {
    fn default() -> Self {
        Self {
            words: [0; BLOCK],
            normals: [0.0; FRAME],
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

/// An ARMA(1, 1) process started at its first sample: y_k = φ y_{k−1} + u_k where u has the
/// variance V (v₁ for the first) and the covariance c between neighbours. By the innovations
/// recursion (`[BrockwellDavis]` 5.2) u_k = √v_k e_k + (c/√v_{k−1}) e_{k−1}, v_k = V − c²/v_{k−1}:
/// one normal number a sample, and the joint law is right from the first sample on.
#[derive(Debug, Clone)]
pub(crate) struct OneNormal {
    stream: Stream,
    phi: f64,
    first_variance: f64,
    variance: f64,
    covariance: f64,
    /// The recursion with the v that v_k tends to, from the second frame on.
    settled: Option<Settled>,
}

/// The recursion in groups: y_j = φ^(j+1) y₋₁ + Σ_m c_mj e_{j−m}, so that what a group waits for
/// is one multiplication and one addition. The numbers do not depend on the processor.
#[derive(Debug, Clone, Copy)]
struct Settled {
    /// c_mj: lag m, place j in the group; 0 where e_{j−m} belongs to a group further back.
    lags: [[f64; GROUP]; GROUP + 1],
    /// φ, φ² … of the places.
    powers: [f64; GROUP],
    /// y and e of the sample before.
    last: f64,
    last_normal: f64,
}

const GROUP: usize = 4;

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
            phi,
            first_variance,
            variance,
            covariance,
            settled: None,
        }
    }

    /// The first frame, sample by sample: within it v_k converges, its error shrinks by more than
    /// ten a sample.
    fn first_frame(&self, normals: &Frame, out: &mut Frame) -> Settled {
        let (mut gain, mut carry) = (libm::sqrt(self.first_variance), 0.0);
        let (mut last, mut last_normal) = (0.0, 0.0);
        for (out, normal) in out.iter_mut().zip(normals) {
            last = self.phi * last + (gain * normal + carry * last_normal);
            *out += last;
            last_normal = *normal;
            // A process too fast to leave anything in its means has neither.
            carry = if gain == 0.0 {
                0.0
            } else {
                self.covariance / gain
            };
            gain = libm::sqrt(self.variance - carry * carry);
        }
        let mut powers = [self.phi; GROUP];
        for k in 1..GROUP {
            powers[k] = powers[k - 1] * self.phi;
        }
        let mut lags = [[0.0; GROUP]; GROUP + 1];
        for (m, lag) in lags.iter_mut().enumerate() {
            for (j, c) in lag.iter_mut().enumerate() {
                // φ^m √v + φ^(m−1) c/√v; of e₋₁, m = j + 1, the second part alone.
                let own = if m == 0 { 1.0 } else { powers[m - 1] } * gain;
                let next = match m {
                    0 => 0.0,
                    1 => carry,
                    _ => powers[m - 2] * carry,
                };
                *c = match m.cmp(&(j + 1)) {
                    core::cmp::Ordering::Less => own + next,
                    core::cmp::Ordering::Equal => next,
                    core::cmp::Ordering::Greater => 0.0,
                };
            }
        }
        Settled {
            lags,
            powers,
            last,
            last_normal,
        }
    }
}

impl Generator for OneNormal {
    fn add_frame(&mut self, frame: &mut Frame, scratch: &mut Scratch) {
        scratch.next_normals(&mut self.stream);
        match &mut self.settled {
            Some(settled) => {
                add_recursion(settled, &scratch.normals, frame);
            }
            None => self.settled = Some(self.first_frame(&scratch.normals, frame)),
        }
    }
}

#[inline(always)]
fn add_recursion_body(filter: &mut Settled, normals: &Frame, out: &mut Frame) {
    let Settled { lags, powers, .. } = *filter;
    let mut last = filter.last;
    let mut back = [filter.last_normal; GROUP];
    for (e, out) in normals
        .as_chunks::<GROUP>()
        .0
        .iter()
        .zip(out.as_chunks_mut::<GROUP>().0)
    {
        // e₋₄ … e₃
        let line: [f64; 2 * GROUP] =
            core::array::from_fn(|k| if k < GROUP { back[k] } else { e[k - GROUP] });
        let mut sum = [0.0; GROUP];
        for j in 0..GROUP {
            let of = |m: usize| lags[m][j] * line[GROUP + j - m];
            sum[j] = ((of(0) + of(1)) + (of(2) + of(3))) + of(4);
        }
        for j in 0..GROUP {
            out[j] += sum[j] + powers[j] * last;
        }
        last = sum[GROUP - 1] + powers[GROUP - 1] * last;
        back = *e;
    }
    filter.last = last;
    filter.last_normal = normals[FRAME - 1];
}

dispatch! {
    fn add_recursion(filter: &mut Settled, normals: &Frame, out: &mut Frame)
        = add_recursion_body;
}
