//! Standard normal numbers: Box and Muller's pair from one 64-bit word (`[BoxMuller1958]`).
//!
//! u = (40 bits + ½)/2⁴⁰, φ = (π/2)((22 bits + ½)/2²² − ½), and two random signs:
//! x₁ = ±√(−ln u)(cos φ + sin φ), x₂ = ±√(−ln u)(cos φ − sin φ), for
//! cos φ ± sin φ = √2 sin(π/4 ± φ). The logarithm, sine and cosine are minimax polynomials in plain
//! multiplications and additions (relative error below 1e-13), so that every processor gives the
//! same bits; the largest possible |x| is 7.5.

use crate::dispatch::dispatch;
use crate::stream::{BLOCK, Stream};

/// Normals made at a time: two for every word.
pub(crate) const NORMALS: usize = 2 * BLOCK;

/// A stream of independent standard normal numbers.
///
/// The sequence does not depend on the lengths in which it is read.
#[derive(Debug, Clone)]
pub struct Normals {
    stream: Stream,
    buffer: [f64; NORMALS],
    used: usize,
}

impl Normals {
    /// The normals of a stream, from its start.
    pub fn new(stream: Stream) -> Self {
        Self {
            stream,
            buffer: [0.0; NORMALS],
            used: NORMALS,
        }
    }

    /// Fills `out` with the next numbers.
    pub fn fill(&mut self, out: &mut [f64]) {
        let ready = (NORMALS - self.used).min(out.len());
        let (head, rest) = out.split_at_mut(ready);
        head.copy_from_slice(&self.buffer[self.used..self.used + ready]);
        self.used += ready;
        let mut words = [0; BLOCK];
        let mut blocks = rest.chunks_exact_mut(NORMALS);
        for block in &mut blocks {
            self.stream.next_block(&mut words);
            if let Ok(block) = block.try_into() {
                transform(&words, block);
            }
        }
        let tail = blocks.into_remainder();
        if !tail.is_empty() {
            self.stream.next_block(&mut words);
            transform(&words, &mut self.buffer);
            tail.copy_from_slice(&self.buffer[..tail.len()]);
            self.used = tail.len();
        }
    }
}

/// 2 artanh(s)/s in s², |s| ≤ (√2 − 1)/(√2 + 1).
const ARTANH: [f64; 6] = [
    1.9999999999999467,
    0.6666666667965807,
    0.39999994870087646,
    0.2857216824441647,
    0.22174167281844037,
    0.19609233946904506,
];
/// sin(πt/2)/t in t², |t| ≤ ½.
const SIN: [f64; 6] = [
    1.5707963267948895,
    -0.6459640975042396,
    0.07969262615353433,
    -0.004681752566775006,
    0.0001604291525078031,
    -3.5562065741239182e-06,
];
/// cos(πt/2) in t², |t| ≤ ½.
const COS: [f64; 6] = [
    0.9999999999999445,
    -1.233700550120178,
    0.25366950715430725,
    -0.02086346800899668,
    0.0009191617678183619,
    -2.4851012738303088e-05,
];

#[inline(always)]
fn polynomial(c: &[f64; 6], x: f64) -> f64 {
    let x2 = x * x;
    (c[0] + c[1] * x) + x2 * ((c[2] + c[3] * x) + x2 * (c[4] + c[5] * x))
}

#[cfg(feature = "std")]
#[inline(always)]
fn square_root(x: f64) -> f64 {
    x.sqrt()
}

/// Both roots are correctly rounded, hence equal.
#[cfg(not(feature = "std"))]
#[inline(always)]
fn square_root(x: f64) -> f64 {
    libm::sqrt(x)
}

const ONE: u64 = 0x3ff0_0000_0000_0000;

/// −ln u with u from bits 24…63 of the word, never 0 or 1.
#[inline(always)]
fn minus_ln_u(word: u64) -> f64 {
    const EXPONENT: u64 = 0xfff0_0000_0000_0000;
    const ROOT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    const TWO_52: f64 = 4_503_599_627_370_496.0;
    let u = 2.0 - f64::from_bits((word >> 12) & 0x000f_ffff_ffff_f000 | ONE | 0x800);
    // u = z·2^−halvings, √½ ≤ z < √2.
    let distance = (ROOT_HALF + !EXPONENT).wrapping_sub(u.to_bits());
    let z = f64::from_bits(u.to_bits().wrapping_add(distance & EXPONENT));
    let halvings = f64::from_bits(distance >> 52 | TWO_52.to_bits()) - TWO_52;
    let s = (z - 1.0) / (z + 1.0);
    halvings * core::f64::consts::LN_2 - s * polynomial(&ARTANH, s * s)
}

/// The pair of normals of squared radius 2·`half_square`; angle from bits 0…21, signs from 22, 23.
#[inline(always)]
fn pair(word: u64, half_square: f64) -> (f64, f64) {
    const SIGN: u64 = 1 << 63;
    let radius = square_root(half_square);
    let t = f64::from_bits((word << 30) & 0x000f_ffff_c000_0000 | ONE | 0x2000_0000) - 1.5;
    let t2 = t * t;
    let sin = t * polynomial(&SIN, t2);
    let cos = polynomial(&COS, t2);
    let first = radius * (cos + sin);
    let second = radius * (cos - sin);
    (
        f64::from_bits(first.to_bits() ^ (word << 41) & SIGN),
        f64::from_bits(second.to_bits() ^ (word << 40) & SIGN),
    )
}

#[inline(always)]
fn transform_body(words: &[u64; BLOCK], normals: &mut [f64; NORMALS]) {
    // Two short loops: more of them fit into the processor's window than of one long loop.
    let (first, second) = normals.split_at_mut(BLOCK);
    for (square, word) in first.iter_mut().zip(words) {
        *square = minus_ln_u(*word);
    }
    for ((first, second), word) in first.iter_mut().zip(second).zip(words) {
        (*first, *second) = pair(*word, *first);
    }
}

dispatch! {
    pub(crate) fn transform(words: &[u64; BLOCK], normals: &mut [f64; NORMALS]) = transform_body;
}
