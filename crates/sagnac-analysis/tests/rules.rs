//! When a step, a warm-up and too few coefficients are named: clear ones always, chance never, and with their numbers.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use sagnac_analysis::fit::{AxisEstimate, FindingKind, RegressorKind, Segment, Status};

const STEP_S: f64 = 0.02;

/// Sum of twelve uniform numbers: Gaussian enough, variance 1.
fn noise(seed: &mut u64) -> f64 {
    (0..12).fold(-6.0, |sum, _| {
        *seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        sum + (*seed >> 11) as f64 / (1_u64 << 53) as f64
    })
}

fn of(samples: &[f64]) -> AxisEstimate {
    common::estimate_of_samples(samples, STEP_S)
}

/// White noise of variance 1 a sample with `added(time)`.
fn white(seconds: f64, seed: &mut u64, added: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..(seconds / STEP_S) as usize)
        .map(|k| noise(seed) + added(k as f64 * STEP_S))
        .collect()
}

fn kinds(axis: &AxisEstimate) -> Vec<FindingKind> {
    axis.findings.iter().map(|f| f.kind).collect()
}

/// Height of a step in the middle whose likelihood ratio against none is `ratio` on average.
fn height_of(ratio: f64, seconds: f64) -> f64 {
    (ratio / (0.25 * seconds / STEP_S)).sqrt()
}

#[test]
fn a_clear_step_is_named_with_its_time_and_height() {
    let mut seed = 3;
    let height = height_of(2000.0, 600.0);
    for k in 0..6 {
        let axis = of(&white(600.0, &mut seed, |t| {
            if t < 300.0 { 0.0 } else { height }
        }));
        assert_eq!(kinds(&axis), [FindingKind::Step], "axis {k}");
        let finding = &axis.findings[0];
        // Steps of white noise are placed to a few 1/height² samples; a walk that stands in while it is looked for costs more.
        let slack_s = 24.0 * STEP_S / (height * height);
        assert!((finding.start_s - 300.0).abs() < slack_s, "{finding:?}");
        let step = &axis.regressors[0];
        assert!(matches!(step.kind, RegressorKind::Step { time_s } if time_s == finding.start_s));
        assert!((step.value / height - 1.0).abs() < 0.4 && step.lower > 0.0);
        // What is a regressor is neither a walk nor flicker.
        assert_eq!(axis.random_walk.status, Status::UpperLimit);
        assert_eq!(axis.flicker.status, Status::UpperLimit);
    }
}

/// A walk explains a small step nearly as well: where neither is named both are told.
#[test]
fn a_step_that_a_walk_would_explain_is_told() {
    let mut seed = 33;
    let height = height_of(75.0, 600.0);
    let mut told = 0;
    for _ in 0..40 {
        let axis = of(&white(600.0, &mut seed, |t| {
            if t < 300.0 { 0.0 } else { height }
        }));
        told += usize::from(axis.findings.iter().any(|f| {
            f.kind == FindingKind::Step
                || f.kind == FindingKind::Short && f.text.contains("; one step at ")
        }));
    }
    // Of the rest most name a walk or a process.
    assert!(told >= 34, "{told} of 40");
}

/// Segments of the samples without those of a gap.
fn parted(samples: &[f64], gap: std::ops::Range<usize>) -> AxisEstimate {
    let segment = |from: usize, to: usize| Segment {
        start_s: from as f64 * STEP_S,
        samples: &samples[from..to],
        filled: &[],
    };
    common::estimate_of(
        &[segment(0, gap.start), segment(gap.end, samples.len())],
        STEP_S,
    )
}

#[test]
fn a_step_in_a_gap_or_soon_after_it_is_named_with_its_levels() {
    let mut seed = 29;
    let (seconds, height, at_s) = (600.0, 0.5, 300.0);
    for (lost_s, after_s) in [
        (1.0, 0.0),
        (10.0, 0.0),
        (60.0, 0.0),
        (20.0, 1.0),
        (20.0, 4.0),
        (20.0, 20.0),
    ] {
        let samples = white(seconds, &mut seed, |t| if t < at_s { 0.0 } else { height });
        let end = ((at_s - after_s) / STEP_S) as usize;
        let axis = parted(&samples, end - (lost_s / STEP_S) as usize..end);
        let name = format!("{lost_s} s lost, {after_s} s before the step");
        assert_eq!(kinds(&axis), [FindingKind::Step], "{name}");
        let finding = &axis.findings[0];
        // The place is known to some 1/height² samples.
        let slack_s = 60.0 * STEP_S;
        assert!(
            finding.start_s < at_s + slack_s && finding.end_s > at_s - slack_s,
            "{name}: {finding:?}"
        );
        assert!(
            (finding.size.unwrap() - height).abs() < 0.1,
            "{name}: {finding:?}"
        );
        let [before, after] = axis.levels[..] else {
            panic!("{name}: {:?}", axis.levels)
        };
        let sigma = after.mean.sigma.unwrap();
        assert!(
            (after.mean.value.unwrap() - height).abs() < 5.0 * sigma,
            "{name}: {after:?}"
        );
        assert!(
            before.mean.value.unwrap().abs() < 5.0 * sigma,
            "{name}: {before:?}"
        );
        let step = &axis.regressors[0];
        assert!(
            step.lower < height && height < step.upper,
            "{name}: {step:?}"
        );
        assert_eq!(axis.random_walk.status, Status::UpperLimit, "{name}");
    }
}

#[test]
fn a_step_soon_after_a_gap_is_named_beside_a_process() {
    let mut seed = 37;
    let mut named = 0;
    for _ in 0..6 {
        // A process of 5 s, as strong as the white noise of a sample.
        let decay = (-STEP_S / 5.0).exp();
        let mut state = 0.0;
        let samples: Vec<f64> = white(600.0, &mut seed, |t| if t < 300.0 { 0.0 } else { 6.0 })
            .into_iter()
            .map(|y| {
                state = decay * state + (1.0 - decay * decay).sqrt() * noise(&mut seed);
                y + state
            })
            .collect();
        let axis = parted(&samples, 14_000..14_950);
        named += i32::from(kinds(&axis).contains(&FindingKind::Step));
    }
    assert!(named >= 5, "{named}");
}

#[test]
fn a_walk_goes_on_across_a_gap_without_steps() {
    let mut seed = 31;
    let mut walks = 0;
    for _ in 0..10 {
        let mut level = 0.0;
        let samples: Vec<f64> = white(600.0, &mut seed, |_| 0.0)
            .into_iter()
            .map(|y| {
                level += 0.02 * noise(&mut seed);
                y + level
            })
            .collect();
        // A tenth of the log is lost: the levels differ by what the walk makes of it.
        let axis = parted(&samples, 12_000..15_000);
        assert!(
            !kinds(&axis).contains(&FindingKind::Step),
            "{:?}",
            axis.findings
        );
        walks += i32::from(axis.random_walk.is_detected());
    }
    assert!(walks >= 8, "{walks}");
}

#[test]
fn no_step_is_named_in_noise_or_walks() {
    let mut seed = 7;
    for _ in 0..10 {
        assert_eq!(kinds(&of(&white(300.0, &mut seed, |_| 0.0))), []);
    }
    let mut walks = 0;
    for _ in 0..10 {
        let mut level = 0.0;
        let samples: Vec<f64> = white(300.0, &mut seed, |_| 0.0)
            .into_iter()
            .map(|y| {
                level += 0.02 * noise(&mut seed);
                y + level
            })
            .collect();
        let axis = of(&samples);
        assert!(!kinds(&axis).contains(&FindingKind::Step));
        walks += i32::from(axis.random_walk.is_detected());
    }
    assert!(walks >= 8, "{walks}");
}

#[test]
fn a_warm_up_is_named_with_its_time_and_only_where_it_is() {
    let mut seed = 11;
    let (amplitude, time_s) = (0.5, 60.0);
    for _ in 0..4 {
        let axis = of(&white(900.0, &mut seed, |t| {
            amplitude * (-t / time_s).exp()
        }));
        assert_eq!(kinds(&axis), [FindingKind::WarmUp]);
        assert!(
            axis.findings[0]
                .text
                .ends_with("no temperature was recorded")
        );
        let RegressorKind::WarmUp { time_constant_s } = axis.regressors[0].kind else {
            panic!("{:?}", axis.regressors)
        };
        assert!(
            (time_constant_s / time_s - 1.0).abs() < 0.35,
            "{time_constant_s}"
        );
        assert!((axis.regressors[0].value / amplitude - 1.0).abs() < 0.25);
        assert_eq!(axis.random_walk.status, Status::UpperLimit);
    }
    for _ in 0..10 {
        assert_eq!(kinds(&of(&white(900.0, &mut seed, |_| 0.0))), []);
    }
}

#[test]
fn a_walk_with_few_coefficients_below_its_corner_is_bounded_and_told() {
    let mut seed = 19;
    let (seconds, coefficients) = (400.0, 9.0);
    // White noise of 1 a sample and a walk cross at f = k/2π samples: 2·n·f coefficients lie below.
    let step = std::f64::consts::PI * coefficients / (seconds / STEP_S);
    let (mut told, axes) = (0, 24);
    for _ in 0..axes {
        let mut level = 0.0;
        let samples: Vec<f64> = white(seconds, &mut seed, |_| 0.0)
            .into_iter()
            .map(|y| {
                level += step * noise(&mut seed);
                y + level
            })
            .collect();
        let axis = of(&samples);
        let short = axis.findings.iter().find(|f| f.kind == FindingKind::Short);
        if let Some(finding) = short {
            told += 1;
            let text = &finding.text;
            if axis.confused.is_empty() {
                assert!(text.contains("below its corner are too few for"), "{text}");
                assert!(finding.size.unwrap() < 10.0);
                let named = [(2, &axis.flicker), (3, &axis.random_walk)];
                let passed = named.iter().any(|(k, term)| {
                    term.status == Status::UpperLimit && axis.likelihood_ratios[*k].unwrap() >= 3.84
                });
                assert!(passed, "{:?}", axis.likelihood_ratios);
            } else {
                assert!(text.contains("cannot be told apart"), "{text}");
            }
        }
    }
    assert!(told >= 2, "{told}");
}

#[test]
fn under_100_s_slow_terms_are_bounded_and_the_length_is_told() {
    let mut seed = 23;
    let mut level = 0.0;
    let mut walk = |seconds: f64| -> AxisEstimate {
        let samples: Vec<f64> = white(seconds, &mut seed, |_| 0.0)
            .into_iter()
            .map(|y| {
                level += 0.2 * noise(&mut seed);
                y + level
            })
            .collect();
        of(&samples)
    };
    let short = walk(99.0);
    assert_eq!(short.random_walk.status, Status::UpperLimit);
    assert!(kinds(&short).contains(&FindingKind::Short));
    assert!(
        short
            .findings
            .iter()
            .any(|f| f.text.starts_with("99 s are too short"))
    );
    let long = walk(101.0);
    assert!(long.random_walk.is_detected());
    assert!(!kinds(&long).contains(&FindingKind::Short));
}
