//! The generators against the Allan variances and joint laws of the random terms' definitions.
//!
//! Allan variances are averaged over declared seeds; limits are five standard errors of that mean
//! as the scatter over the seeds gives it. Traps 3 and 4 of the model have a test of their name.
#![allow(clippy::unwrap_used, reason = "tests")]

use sagnac_noise::{
    AxisGenerator, AxisNoise, Flicker, GaussMarkov, Normals, Purpose, Quantization, Ramp,
    RandomWalk, Resonance, Sinusoid, StreamKey, TermSet, White,
};

const DT: f64 = 0.01;
const SAMPLES: usize = 1 << 14;
const SEEDS: u64 = 60;

fn samples(noise: &AxisNoise, terms: TermSet, seed: u64, axis: u8) -> Vec<f64> {
    let key = StreamKey {
        seed,
        run: 1,
        sensor: 0,
        axis,
    };
    let mut out = vec![0.0; SAMPLES];
    AxisGenerator::new(noise, terms, DT, SAMPLES as f64 * DT, key)
        .unwrap()
        .fill(&mut out, None);
    out
}

/// Non-overlapping Allan variance at m samples.
fn allan(x: &[f64], m: usize) -> f64 {
    let means: Vec<f64> = x
        .chunks_exact(m)
        .map(|c| c.iter().sum::<f64>() / m as f64)
        .collect();
    let squares = means.windows(2).map(|w| (w[1] - w[0]).powi(2));
    squares.sum::<f64>() / (2.0 * (means.len() - 1) as f64)
}

fn agrees(noise: &AxisNoise, allowance: f64) {
    for m in [1, 2, 5, 16, 64, 256, 1024, SAMPLES / 4] {
        let values: Vec<f64> = (1..=SEEDS)
            .map(|seed| allan(&samples(noise, TermSet::ALL, seed, 0), m))
            .collect();
        let mean = values.iter().sum::<f64>() / SEEDS as f64;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
        let error = (variance / SEEDS as f64).sqrt();
        let want = noise.allan_variance(m as f64 * DT);
        assert!(
            (mean - want).abs() <= 5.0 * error + allowance * want,
            "m = {m}: {mean:e} ± {error:e}, expected {want:e}"
        );
    }
}

fn all() -> AxisNoise {
    AxisNoise {
        quantization: Quantization { coefficient: 0.02 },
        white: White { density: 0.1 },
        flicker: Flicker { coefficient: 0.3 },
        random_walk: RandomWalk { coefficient: 0.1 },
        ramp: Ramp { slope: 0.001 },
        gauss_markov: vec![GaussMarkov {
            sigma: 0.5,
            correlation_time_s: 2.0,
        }],
        resonance: vec![Resonance {
            sigma: 0.2,
            frequency_hz: 7.0,
            damping: 0.1,
        }],
        sinusoid: vec![Sinusoid {
            amplitude: 0.2,
            frequency_hz: 3.1,
        }],
        ..AxisNoise::default()
    }
}

#[test]
fn trap_3_white_noise_sample_sigma_is_density_over_root_dt() {
    let noise = AxisNoise {
        white: White { density: 0.1 },
        ..AxisNoise::default()
    };
    let x = samples(&noise, TermSet::ALL, 1, 0);
    let variance = x.iter().map(|v| v * v).sum::<f64>() / SAMPLES as f64;
    // Standard error of the variance: √(2/n) = 1.1 %.
    assert!((variance / (0.01 / DT) - 1.0).abs() < 0.055);
    agrees(&noise, 1e-9);
}

#[test]
fn trap_4_quantization_falls_with_slope_minus_one() {
    agrees(
        &AxisNoise {
            quantization: Quantization { coefficient: 0.02 },
            ..AxisNoise::default()
        },
        1e-9,
    );
}

#[test]
fn flicker_has_its_floor_to_a_quarter_of_the_run() {
    // 13 % at the slow end, as the definition allows.
    agrees(
        &AxisNoise {
            flicker: Flicker { coefficient: 0.3 },
            ..AxisNoise::default()
        },
        0.13,
    );
}

#[test]
fn random_walk_and_gauss_markov_are_interval_means() {
    agrees(
        &AxisNoise {
            random_walk: RandomWalk { coefficient: 0.1 },
            ..AxisNoise::default()
        },
        1e-9,
    );
    for correlation_time_s in [0.003, 0.1, 20.0] {
        agrees(
            &AxisNoise {
                gauss_markov: vec![GaussMarkov {
                    sigma: 0.5,
                    correlation_time_s,
                }],
                ..AxisNoise::default()
            },
            1e-9,
        );
    }
}

#[test]
fn resonance_and_the_sum_of_all() {
    agrees(
        &AxisNoise {
            resonance: vec![Resonance {
                sigma: 0.2,
                frequency_hz: 7.0,
                damping: 0.1,
            }],
            ..AxisNoise::default()
        },
        1e-9,
    );
    agrees(&all(), 0.13);
}

#[test]
fn a_term_does_not_depend_on_the_others_or_on_blocks() {
    let set = |name| TermSet::NONE.with(name).unwrap();
    let noise = all();
    let both = set("flicker").with("white").unwrap();
    let key = StreamKey {
        seed: 5,
        run: 1,
        sensor: 1,
        axis: 2,
    };
    let run = 100.0;
    let whole = |terms| {
        let mut out = vec![0.0; 5000];
        let mut generator = AxisGenerator::new(&noise, terms, DT, run, key).unwrap();
        generator.fill(&mut out, None);
        out
    };
    let (white, flicker) = (whole(set("white")), whole(set("flicker")));
    for ((sum, white), flicker) in whole(both).iter().zip(&white).zip(&flicker) {
        assert_eq!(*sum, flicker + white);
    }
    let expected = whole(TermSet::ALL);
    for block in [1, 7, 255, 256, 1000] {
        let mut generator = AxisGenerator::new(&noise, TermSet::ALL, DT, run, key).unwrap();
        let mut out = vec![0.0; 5000];
        for part in out.chunks_mut(block) {
            generator.fill(part, None);
        }
        assert_eq!(out, expected, "blocks of {block}");
    }
}

#[test]
fn axes_and_seeds_are_independent() {
    let noise = AxisNoise {
        white: White { density: 0.1 },
        ..AxisNoise::default()
    };
    let correlation = |a: &[f64], b: &[f64]| {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
    };
    let limit = 5.0 / (SAMPLES as f64).sqrt();
    let first = samples(&noise, TermSet::ALL, 1, 0);
    for (seed, axis) in [(1, 1), (1, 2), (2, 0), (3, 0)] {
        let other = samples(&noise, TermSet::ALL, seed, axis);
        assert!(
            correlation(&first, &other).abs() < limit,
            "seed {seed}, axis {axis}"
        );
    }
}

#[test]
fn normals_have_the_moments_and_tails_of_a_normal() {
    const N: usize = 1 << 20;
    let key = StreamKey {
        seed: 1,
        run: 1,
        sensor: 0,
        axis: 0,
    };
    let mut x = vec![0.0; N];
    Normals::new(key.stream(Purpose::Other, 0)).fill(&mut x);
    let moment = |power: i32| x.iter().map(|v| v.powi(power)).sum::<f64>() / N as f64;
    let root = (N as f64).sqrt();
    // Standard errors of the raw moments: √(μ_2p − μ_p²)/√n.
    for (power, want, sigma) in [
        (1, 0.0, 1.0),
        (2, 1.0, 2.0_f64.sqrt()),
        (3, 0.0, 15.0_f64.sqrt()),
        (4, 3.0, 96.0_f64.sqrt()),
        (6, 15.0, (10_395.0_f64 - 225.0).sqrt()),
    ] {
        let got = moment(power);
        assert!(
            (got - want).abs() < 5.0 * sigma / root,
            "moment {power}: {got}"
        );
    }
    let far = x.iter().filter(|v| v.abs() > 4.0).count() as f64;
    let expected = 6.334e-5 * N as f64;
    assert!(
        (far - expected).abs() < 5.0 * expected.sqrt(),
        "{far} beyond 4 sigma"
    );
}
