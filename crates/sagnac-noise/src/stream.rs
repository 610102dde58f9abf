//! Streams of random numbers: one for every (seed, run, sensor, axis, term, place in its list).
//!
//! Eight interleaved xoshiro256++ generators (`[Blackman2021]`), each started from a hash of the
//! whole key, so that a stream depends on nothing but its key: not on threads, blocks or on which
//! other streams are read.

use crate::dispatch::dispatch;

/// Generators side by side in a stream.
pub(crate) const LANES: usize = 8;

/// Words made at a time.
pub(crate) const BLOCK: usize = 16 * LANES;

/// What a stream is for; the number is part of its key and never changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
#[non_exhaustive]
pub enum Purpose {
    /// White noise.
    White = 1,
    /// Quantisation noise.
    Quantization = 2,
    /// Flicker noise of `bias.instability`.
    Flicker = 3,
    /// Random walk: place 0 of `noise`, place 1 of `bias.instability`.
    RandomWalk = 4,
    /// Gauss–Markov: place 0 of `bias.instability`, from 1 the list of `noise`.
    GaussMarkov = 5,
    /// Resonances, from place 1.
    Resonance = 6,
    /// Sinusoids, from place 1.
    Sinusoid = 7,
    /// Run-to-run bias.
    BiasDraw = 8,
    /// Run-to-run scale factor error.
    ScaleFactorDraw = 9,
    /// Run-to-run misalignment; place 0 … 2 is the column, the axis the row.
    MisalignmentDraw = 10,
    /// A draw of the caller's own (a calibration error, an alignment error), by place.
    Other = 11,
}

/// Whose stream: seed, run, sensor and axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StreamKey {
    /// The user's seed.
    pub seed: u64,
    /// Run, from 1; run 1 is the run made without `--runs`.
    pub run: u32,
    /// 0 gyro, 1 accelerometer.
    pub sensor: u8,
    /// 0 x, 1 y, 2 z.
    pub axis: u8,
}

impl StreamKey {
    /// The stream of 64-bit words for `purpose` and `place`.
    pub fn stream(&self, purpose: Purpose, place: u32) -> Stream {
        Stream::new(*self, purpose, place)
    }

    /// One standard normal number: the run-to-run draws.
    pub fn draw(&self, purpose: Purpose, place: u32) -> f64 {
        let mut value = [0.0];
        crate::Normals::new(self.stream(purpose, place)).fill(&mut value);
        value[0]
    }
}

/// Finaliser with full avalanche (the constants of SplitMix64's variant 13, `[Stafford2011]`).
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A stream of independent 64-bit words.
#[derive(Debug, Clone, PartialEq)]
pub struct Stream {
    state: [[u64; LANES]; 4],
}

impl Stream {
    fn new(key: StreamKey, purpose: Purpose, place: u32) -> Self {
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        const SILVER: u64 = 0xd1b5_4a32_d192_ed03;
        let identity = u64::from(key.sensor) << 56
            | u64::from(key.axis) << 48
            | u64::from(purpose as u8) << 40
            | u64::from(place & 0xff_ffff) << 8
            | u64::from(place >> 24);
        // Two chains of 64 bits: keys meet with probability 2⁻¹²⁸.
        let (mut first, mut second) = (GOLDEN, SILVER);
        for word in [key.seed, u64::from(key.run), identity] {
            first = mix(first.wrapping_add(GOLDEN) ^ word);
            second = mix(second.wrapping_add(SILVER).rotate_left(32) ^ word.rotate_left(17));
        }
        let mut state = [[0; LANES]; 4];
        let mut count = 0_u64;
        for row in &mut state {
            for word in row {
                count += 1;
                *word = mix(first.wrapping_add(count.wrapping_mul(GOLDEN)))
                    ^ mix(second ^ count.wrapping_mul(SILVER)).rotate_left(32);
            }
        }
        Self { state }
    }

    /// The next [`BLOCK`] words.
    pub(crate) fn next_block(&mut self, words: &mut [u64; BLOCK]) {
        advance(&mut self.state, words);
    }
}

type Row = [u64; LANES];

/// One operation on all lanes: a loop of its own, so that it becomes one vector instruction.
#[inline(always)]
fn lanes(a: Row, b: Row, operation: impl Fn(u64, u64) -> u64) -> Row {
    core::array::from_fn(|lane| operation(a[lane], b[lane]))
}

#[inline(always)]
fn advance_body(state: &mut [Row; 4], words: &mut [u64; BLOCK]) {
    let [mut s0, mut s1, mut s2, mut s3] = *state;
    for out in words.as_chunks_mut::<LANES>().0 {
        *out = lanes(s0, s3, |a, b| {
            a.wrapping_add(b).rotate_left(23).wrapping_add(a)
        });
        let shifted = lanes(s1, s1, |a, _| a << 17);
        s2 = lanes(s2, s0, |a, b| a ^ b);
        s3 = lanes(s3, s1, |a, b| a ^ b);
        s1 = lanes(s1, s2, |a, b| a ^ b);
        s0 = lanes(s0, s3, |a, b| a ^ b);
        s2 = lanes(s2, shifted, |a, b| a ^ b);
        s3 = lanes(s3, s3, |a, _| a.rotate_left(45));
    }
    *state = [s0, s1, s2, s3];
}

dispatch! {
    fn advance(state: &mut [[u64; LANES]; 4], words: &mut [u64; BLOCK]) = advance_body;
}
