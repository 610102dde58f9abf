//! What was estimated, as a model file: detected terms with value and interval, the others as upper limits.

use super::text::shown_sensor;
use super::{AxisOutcome, Outcome, dimension_of, key_of};
use crate::Error;
use sagnac_analysis::fit::{Estimate, GaussMarkovEstimate, RegressorKind, Status, Term};
use sagnac_core::{Output, Sensor};
use sagnac_model::units::{Dimension, Unit};
use sagnac_model::{Entry, Model, Process};
use sagnac_report::text::Unit as ShownUnit;

const AXES: [&str; 3] = ["x", "y", "z"];

/// The estimate in the unit that the text shows the term in.
fn term_entry(e: &Estimate, sensor: Sensor, term: Term) -> Option<Entry> {
    let mut entry = entry(e, dimension_of(sensor, term))?;
    entry.unit = term_unit(sensor, term);
    Some(entry)
}

/// The unit of the text, spelled as in a model file.
fn term_unit(sensor: Sensor, term: Term) -> Unit {
    let shown = ShownUnit::of_term(shown_sensor(sensor), key_of(sensor, term));
    Unit::parse(&shown.text.replace("√h", "sqrt(h)"))
        .unwrap_or_else(|_| Unit::field(dimension_of(sensor, term)))
}

/// What an axis without a listed term has: zero.
fn none_of(sensor: Sensor, term: Term) -> Entry {
    let mut entry = Entry::of(0.0, dimension_of(sensor, term));
    entry.unit = term_unit(sensor, term);
    entry
}

fn entry(e: &Estimate, dimension: Dimension) -> Option<Entry> {
    match e.status {
        Status::Detected => {
            let value = e.value?;
            Some(Entry::estimate(
                value,
                e.sigma.unwrap_or(0.0),
                [e.lower.unwrap_or(value), e.upper.unwrap_or(value)],
                dimension,
            ))
        }
        Status::UpperLimit => e.upper.map(|u| Entry::limit(u, dimension)),
        Status::Absent => None,
    }
}

fn stem(name: &str) -> String {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let mut stem = file;
    for ending in [
        ".gz", ".zst", ".csv", ".npy", ".npz", ".txt", ".bag", ".mcap", ".db3", ".ulg", ".mat",
        ".h5", ".hdf5", ".parquet",
    ] {
        stem = stem.strip_suffix(ending).unwrap_or(stem);
    }
    if stem.is_empty() {
        file.to_owned()
    } else {
        stem.to_owned()
    }
}

pub(super) fn model(outcome: &Outcome) -> Result<Model, Error> {
    let Some(first) = outcome.logs.first() else {
        return Err(Error::data("nothing was characterized")
            .advise("give a log with at least 64 samples of a gyro or accelerometer axis"));
    };
    let mut model = Model::new(&stem(&first.name));
    model.set_sample_rate_hz(first.rate_hz)?;
    let thermal = Thermal::of(outcome);
    if let Some((mean, low, high)) = thermal.range_c {
        model.set_reference_temperature_c(mean);
        if high > low {
            model.set_temperature_range_c([low, high]);
        }
    }
    for axis in &first.axes {
        single(&mut model, axis)?;
        for (power, value, lower, upper) in thermal.of_axis(outcome, &axis.axis) {
            temperature(&mut model, axis, power, [value, lower, upper])?;
        }
    }
    for sensor in Sensor::ALL {
        let lists: Vec<(usize, Vec<GaussMarkovEstimate>)> = first
            .axes
            .iter()
            .filter(|a| a.sensor == sensor)
            .map(|axis| {
                let pooled = outcome.sensor.as_ref().and_then(|axes| {
                    let found = axes.iter().find(|s| s.axis == axis.axis)?;
                    Some(found.pooled.gauss_markov.clone())
                });
                let own = axis.estimate.as_ref().map(|e| e.gauss_markov.clone());
                (axis.index, pooled.or(own).unwrap_or_default())
            })
            .collect();
        markov(&mut model, sensor, &lists)?;
        lines(&mut model, sensor, &first.axes)?;
    }
    for axis in outcome.sensor.iter().flatten() {
        let p = &axis.pooled;
        for (term, e) in [
            (Term::Quantization, &p.quantization),
            (Term::White, &p.white),
            (Term::Flicker, &p.flicker),
            (Term::RandomWalk, &p.random_walk),
        ] {
            put(&mut model, axis.sensor, axis.index, term, e)?;
        }
        let output = dimension_of(axis.sensor, Term::Flicker);
        if let Some(entry) = entry(&p.run_to_run.stability, output) {
            let path = format!("{}.bias.stability.{}", axis.sensor.key(), AXES[axis.index]);
            model.set(&path, entry)?;
        }
    }
    Ok(model)
}

fn put(
    model: &mut Model,
    sensor: Sensor,
    index: usize,
    term: Term,
    e: &Estimate,
) -> Result<(), Error> {
    let key = match term {
        Term::Flicker => "bias.instability.coefficient".to_owned(),
        _ => format!("noise.{}", key_of(sensor, term)),
    };
    if term == Term::Flicker {
        model.set_process(sensor, Process::Flicker);
    }
    if let Some(entry) = term_entry(e, sensor, term) {
        model.set(&format!("{}.{key}.{}", sensor.key(), AXES[index]), entry)?;
    }
    Ok(())
}

fn single(model: &mut Model, axis: &AxisOutcome) -> Result<(), Error> {
    let sensor = axis.sensor;
    if let Some(lsb) = axis.lsb.filter(|l| *l > 0.0) {
        let (output, dimension, value) = if axis.from_increments {
            let step = axis.estimate.as_ref().map_or(1.0, |e| e.step_s);
            let dimension = match sensor {
                Sensor::Gyro => Dimension::ANGLE,
                Sensor::Accel => Dimension::SPEED,
            };
            (Output::Increment, dimension, lsb * step)
        } else {
            (Output::Rate, dimension_of(sensor, Term::Flicker), lsb)
        };
        model.set_output(sensor, output);
        let path = format!("{}.resolution.{}", sensor.key(), AXES[axis.index]);
        model.set(&path, Entry::of(value, dimension))?;
    }
    let Some(e) = &axis.estimate else {
        return Ok(());
    };
    for term in [
        Term::Quantization,
        Term::White,
        Term::Flicker,
        Term::RandomWalk,
        Term::Ramp,
    ] {
        if let Some(estimate) = e.term(term) {
            put(model, sensor, axis.index, term, estimate)?;
        }
    }
    Ok(())
}

/// Where b(T) comes from: the runs' means and the slopes inside them, where temperature shows, else the log that went through most of it.
struct Thermal {
    /// The temperature that coefficients count from, and the range [°C].
    range_c: Option<(f64, f64, f64)>,
    pooled: bool,
    log: usize,
}

impl Thermal {
    fn of(outcome: &Outcome) -> Self {
        let mut sensor = outcome.sensor.iter().flatten();
        let reference = sensor.find_map(|a| a.pooled.run_to_run.reference_c);
        let all = || {
            outcome
                .logs
                .iter()
                .enumerate()
                .filter_map(|(i, l)| Some((i, l.temperature_c?)))
        };
        if let Some(reference) = reference {
            let ends = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, t)| {
                (a.min(t.1), b.max(t.2))
            });
            return Self {
                range_c: Some((reference, ends.0, ends.1)),
                pooled: true,
                log: 0,
            };
        }
        let of_one = outcome.sensor.is_some();
        let widest = all()
            .filter(|(i, _)| of_one || *i == 0)
            .max_by(|a, b| (a.1.2 - a.1.1).total_cmp(&(b.1.2 - b.1.1)));
        Self {
            range_c: widest.map(|w| w.1),
            pooled: false,
            log: widest.map_or(0, |w| w.0),
        }
    }

    /// Power, value, lower, upper of the coefficients of an axis.
    fn of_axis(&self, outcome: &Outcome, axis: &str) -> Vec<(usize, f64, f64, f64)> {
        if self.pooled {
            let found = outcome.sensor.iter().flatten().find(|a| a.axis == axis);
            let list = found.map_or(&[][..], |a| &a.pooled.run_to_run.temperature);
            return list
                .iter()
                .zip(1..)
                .map(|(&(value, lower, upper), power)| (power, value, lower, upper))
                .collect();
        }
        let own = outcome.logs.get(self.log).into_iter().flat_map(|l| &l.axes);
        own.filter(|a| a.axis == axis)
            .flat_map(|a| a.estimate.iter().flat_map(|e| &e.regressors))
            .filter_map(|r| match r.kind {
                RegressorKind::Temperature { power } => Some((power, r.value, r.lower, r.upper)),
                _ => None,
            })
            .collect()
    }
}

fn temperature(
    model: &mut Model,
    axis: &AxisOutcome,
    power: usize,
    [value, lower, upper]: [f64; 3],
) -> Result<(), Error> {
    let output = dimension_of(axis.sensor, Term::Flicker);
    let path = format!(
        "{}.bias.temperature.{power}.{}",
        axis.sensor.key(),
        AXES[axis.index]
    );
    let sigma = (upper - lower) / 3.92;
    let entry = Entry::estimate(value, sigma, [lower, upper], output.per_kelvin(power as u8));
    model.set(&path, entry)?;
    Ok(())
}

/// The list of Gauss–Markov processes: an entry a process; an axis where it was not seen has the limit, or σ = 0.
fn markov(
    model: &mut Model,
    sensor: Sensor,
    lists: &[(usize, Vec<GaussMarkovEstimate>)],
) -> Result<(), Error> {
    let most = lists
        .iter()
        .map(|(_, l)| l.iter().filter(|g| g.sigma.is_detected()).count())
        .max()
        .unwrap_or(0);
    for place in 0..most {
        let found: Vec<(usize, Option<&GaussMarkovEstimate>)> = lists
            .iter()
            .map(|(axis, list)| {
                (
                    *axis,
                    list.iter().filter(|g| g.sigma.is_detected()).nth(place),
                )
            })
            .collect();
        // An axis without the process still needs a time: that of the first that has it.
        let time = found
            .iter()
            .find_map(|(_, g)| g.and_then(|g| g.correlation_time_s.value))
            .unwrap_or(1.0);
        for axis in 0..3 {
            let own = found.iter().find(|(a, _)| *a == axis).and_then(|(_, g)| *g);
            let prefix = format!("{}.noise.gauss_markov.{}", sensor.key(), place + 1);
            // The limit is the largest over all times: it stands for one process.
            let limits = lists.iter().filter(|(a, _)| *a == axis && place == 0);
            let limit = limits.flat_map(|(_, list)| list).next();
            let sigma = own
                .or(limit)
                .and_then(|g| term_entry(&g.sigma, sensor, Term::GaussMarkov))
                .unwrap_or_else(|| none_of(sensor, Term::GaussMarkov));
            let correlation = own
                .and_then(|g| entry(&g.correlation_time_s, Dimension::TIME))
                .unwrap_or_else(|| Entry::of(time, Dimension::TIME));
            model.set(&format!("{prefix}.sigma.{}", AXES[axis]), sigma)?;
            model.set(
                &format!("{prefix}.correlation_time.{}", AXES[axis]),
                correlation,
            )?;
        }
    }
    Ok(())
}

/// The lines of all axes, each an entry that the other axes have at zero.
fn lines(model: &mut Model, sensor: Sensor, axes: &[AxisOutcome]) -> Result<(), Error> {
    // Lines of one frequency on several axes are one entry.
    let mut list: Vec<(f64, [Option<Entry>; 3])> = Vec::new();
    for axis in axes.iter().filter(|a| a.sensor == sensor) {
        for line in axis.estimate.iter().flat_map(|e| &e.sinusoids) {
            let (Some(f), Some(spread)) = (line.frequency_hz.value, line.frequency_hz.sigma) else {
                continue;
            };
            let amplitude = term_entry(&line.amplitude, sensor, Term::Sinusoid);
            let near = (6.0 * spread).max(1e-4 * f);
            if let Some((_, amplitudes)) = list
                .iter_mut()
                .find(|(other, a)| (other - f).abs() < near && a[axis.index].is_none())
            {
                amplitudes[axis.index] = amplitude;
            } else {
                let mut amplitudes = [None, None, None];
                amplitudes[axis.index] = amplitude;
                list.push((f, amplitudes));
            }
        }
    }
    for (place, (frequency, amplitudes)) in list.into_iter().enumerate() {
        let prefix = format!("{}.noise.sinusoids.{}", sensor.key(), place + 1);
        for (axis, amplitude) in amplitudes.into_iter().enumerate() {
            let amplitude = amplitude.unwrap_or_else(|| none_of(sensor, Term::Sinusoid));
            model.set(&format!("{prefix}.amplitude.{}", AXES[axis]), amplitude)?;
            model.set(
                &format!("{prefix}.frequency.{}", AXES[axis]),
                Entry::of(frequency, Dimension::FREQUENCY),
            )?;
        }
    }
    Ok(())
}
