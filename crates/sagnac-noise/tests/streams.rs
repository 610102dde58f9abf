//! No sample of a term depends on other terms, axes, sensors, runs or seeds.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac_noise::{
    AxisGenerator, AxisNoise, Flicker, GaussMarkov, Quantization, Ramp, RandomWalk, Resonance,
    Sinusoid, StreamKey, TermSet, White,
};

const DT: f64 = 0.01;
const SAMPLES: usize = 1 << 14;

/// Every random term, two of each kind that can stand twice.
fn all() -> AxisNoise {
    let gauss_markov = |sigma, correlation_time_s| GaussMarkov {
        sigma,
        correlation_time_s,
    };
    AxisNoise {
        quantization: Quantization { coefficient: 0.02 },
        white: White { density: 0.1 },
        flicker: Flicker { coefficient: 0.3 },
        random_walk: RandomWalk { coefficient: 0.1 },
        instability_random_walk: RandomWalk { coefficient: 0.07 },
        ramp: Ramp { slope: 0.001 },
        gauss_markov: vec![gauss_markov(0.5, 2.0), gauss_markov(0.4, 0.2)],
        instability_gauss_markov: gauss_markov(0.3, 9.0),
        resonance: vec![Resonance {
            sigma: 0.2,
            frequency_hz: 7.0,
            damping: 0.1,
        }],
        sinusoid: vec![Sinusoid {
            amplitude: 0.2,
            frequency_hz: 3.1,
        }],
    }
}

fn key(seed: u64, run: u32, sensor: u8, axis: u8) -> StreamKey {
    StreamKey {
        seed,
        run,
        sensor,
        axis,
    }
}

fn samples(noise: &AxisNoise, terms: TermSet, key: StreamKey) -> Vec<f64> {
    let mut out = vec![0.0; SAMPLES];
    AxisGenerator::new(noise, terms, DT, SAMPLES as f64 * DT, key)
        .unwrap()
        .fill(&mut out, None);
    out
}

/// The names that make samples (`stability` makes draws).
fn names() -> impl Iterator<Item = &'static str> {
    TermSet::NAMES
        .into_iter()
        .filter(|name| *name != "stability")
}

fn set(names: impl Iterator<Item = &'static str>) -> TermSet {
    names.fold(TermSet::NONE, |set, name| set.with(name).unwrap())
}

#[test]
fn switching_one_term_off_leaves_every_other_bit_identical() {
    let (noise, key) = (all(), key(5, 1, 1, 2));
    // Added in the order in which the generator adds them: drift first.
    let order = [
        "flicker",
        "random_walk",
        "gauss_markov",
        "ramp",
        "white",
        "quantization",
        "resonance",
        "sinusoid",
    ];
    // Terms with one process: their sum has one way of rounding only.
    let mut single = noise.clone();
    single.instability_random_walk = RandomWalk::default();
    single.instability_gauss_markov = GaussMarkov::default();
    single.gauss_markov.truncate(1);
    let alone = order.map(|name| samples(&single, set([name].into_iter()), key));
    for off in [None].into_iter().chain(order.map(Some)) {
        let on = order.iter().copied().filter(|name| Some(*name) != off);
        let together = samples(&single, set(on), key);
        for (k, sum) in together.iter().enumerate() {
            let mut want = 0.0;
            for (name, samples) in order.iter().zip(&alone) {
                if Some(*name) != off {
                    want += samples[k];
                }
            }
            assert_eq!(sum.to_bits(), want.to_bits(), "{off:?} off, sample {k}");
        }
    }
    // A zero in a list keeps the places of the others.
    let mut second_alone = noise;
    let whole = samples(&second_alone, set(["gauss_markov"].into_iter()), key);
    second_alone.gauss_markov[0].sigma = 0.0;
    let rest = samples(&second_alone, set(["gauss_markov"].into_iter()), key);
    let mut first_alone = all();
    first_alone.instability_gauss_markov = GaussMarkov::default();
    first_alone.gauss_markov[1].sigma = 0.0;
    let first = samples(&first_alone, set(["gauss_markov"].into_iter()), key);
    for k in 0..SAMPLES {
        assert!((rest[k] + first[k] - whole[k]).abs() < 1e-14);
    }
}

/// Differences, so that slow terms have many independent values.
fn differences(x: &[f64]) -> Vec<f64> {
    x.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

/// Variance of the correlation of independent series: (1 + 2 Σ ρ₁ρ₂)/n by Bartlett's formula.
fn limit(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = 1.0;
    for lag in 1..200 {
        sum += 2.0 * correlation(&a[lag..], a) * correlation(&b[lag..], b);
    }
    5.0 * (sum.max(1.0) / a.len() as f64).sqrt()
}

#[test]
fn terms_axes_sensors_runs_and_seeds_are_independent() {
    let noise = all();
    // A ramp and a sinusoid have no random samples.
    let random = names().filter(|name| !["ramp", "sinusoid"].contains(name));
    let keys = [
        key(1, 1, 0, 0),
        key(1, 1, 0, 1),
        key(1, 1, 0, 2),
        key(1, 1, 1, 0),
        key(1, 2, 0, 0),
        key(2, 1, 0, 0),
    ];
    let mut series = Vec::new();
    for name in random {
        for (i, key) in keys.iter().enumerate() {
            let x = samples(&noise, set([name].into_iter()), *key);
            series.push((name, i, differences(&x)));
        }
    }
    for (i, (name, key, x)) in series.iter().enumerate() {
        for (other, other_key, y) in &series[..i] {
            let got = correlation(x, y).abs();
            if got > 4.0 / (SAMPLES as f64).sqrt() {
                assert!(
                    got < limit(x, y),
                    "{name} {key} and {other} {other_key}: {got}"
                );
            }
        }
    }
}

#[test]
fn blocks_of_any_length_give_the_same_samples() {
    let (noise, key) = (all(), key(3, 1, 0, 1));
    let whole = samples(&noise, TermSet::ALL, key);
    for block in [1, 7, 255, 256, 257, 1000, SAMPLES] {
        let mut generator =
            AxisGenerator::new(&noise, TermSet::ALL, DT, SAMPLES as f64 * DT, key).unwrap();
        let mut out = vec![0.0; SAMPLES];
        for part in out.chunks_mut(block) {
            generator.fill(part, None);
        }
        assert!(out == whole, "blocks of {block}");
    }
}
