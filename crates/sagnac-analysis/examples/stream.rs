//! Streams an axis of any length through the strided deviation and prints nanoseconds a sample and peak memory.
//!
//! `cargo run --release -p sagnac-analysis --example stream -- 1000000000 [octave|default]`
#![allow(clippy::print_stdout, reason = "a program")]

use std::time::{Duration, Instant};

use sagnac_analysis::{Deviation, DeviationStream, TauGrid};

/// Samples of white noise drawn before and pushed again and again, each time with another sign and offset.
const BLOCK: usize = 1 << 16;
const BLOCKS: usize = 64;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let samples: usize = args.next().map_or(Ok(1_000_000_000), |text| text.parse())?;
    let grid = match args.next().as_deref() {
        None | Some("default") => TauGrid::Default,
        Some("octave") => TauGrid::Octave,
        Some(other) => return Err(format!("no grid {other}").into()),
    };
    let factors = grid.factors(Deviation::Oadev, samples, 0.01);
    let count = factors.len();
    let mut stream = DeviationStream::new(Deviation::Oadev, factors)?;
    let mut state = 1_u64;
    let mut next = || {
        // splitmix64; the sum of four uniform numbers is near enough to a normal one for a figure of speed.
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        let z = z ^ (z >> 31);
        (0..4)
            .map(|k| ((z >> (16 * k)) & 0xFFFF) as f64)
            .sum::<f64>()
            / 65536.0
            - 2.0
    };
    let pool: Vec<Vec<f64>> = (0..BLOCKS)
        .map(|_| (0..BLOCK).map(|_| next()).collect())
        .collect();
    let mut pushing = Duration::ZERO;
    let mut left = samples;
    let mut block = vec![0.0; BLOCK];
    while left > 0 {
        let n = left.min(BLOCK);
        let draw = (next() * 1e6).abs() as usize;
        let sign = if draw.is_multiple_of(2) { 1.0 } else { -1.0 };
        for (to, from) in block.iter_mut().zip(&pool[draw / 2 % BLOCKS]) {
            *to = sign * from;
        }
        let start = Instant::now();
        stream.push(&block[..n]);
        pushing += start.elapsed();
        left -= n;
    }
    let curve = stream.finish(0.01)?;
    let s = pushing.as_secs_f64();
    println!(
        "{samples} samples, {count} averaging times: {s:.2} s, {:.2} ns a sample, {:.0} M samples/s",
        1e9 * s / samples as f64,
        samples as f64 / s / 1e6
    );
    let last = curve.deviation.len() - 1;
    println!(
        "adev at {} s: {:e}, at {} s: {:e}",
        curve.tau_s[0], curve.deviation[0], curve.tau_s[last], curve.deviation[last]
    );
    Ok(())
}
