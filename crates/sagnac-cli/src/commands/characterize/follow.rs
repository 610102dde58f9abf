//! `--follow`: reads a growing log, says the state on standard error, ends at a precision, the end, or an interrupt.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sagnac::Error;
use sagnac::characterize::{NamedLog, Outcome, Request, characterize};
use sagnac::log::{Block, Log, LogReader, Source};
use sagnac::plan::{planned, wanted_precisions};

use super::Args;
use crate::context::Context;
use crate::outputs::{INTERRUPT_ENDS_INPUT, INTERRUPTED};

/// Reads on at the end of a file until an interrupt says that it is over.
struct Tail(File);

impl Read for Tail {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let n = self.0.read(buffer)?;
            if n > 0 || INTERRUPTED.load(Ordering::SeqCst) {
                return Ok(n);
            }
            if let Some(end) = IDLE_END.get()
                && Instant::now() > *end
            {
                return Ok(0);
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }
}

/// Set once the wanted precision is reached, so that a waiting reader ends.
static IDLE_END: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();

pub(super) fn follow(args: &Args, request: &Request, context: &Context) -> Result<Outcome, Error> {
    let wanted = args.until.as_deref().map(wanted_precisions).transpose()?;
    let path = args.logs.first().map_or(Path::new("-"), |p| p.as_path());
    INTERRUPT_ENDS_INPUT.store(true, Ordering::SeqCst);
    let mut reader: Box<dyn LogReader> = if path.is_file() {
        crate::outputs::reads(path)?;
        let file = File::open(path).map_err(|e| {
            Error::data(format!(
                "{} cannot be read: {}",
                path.display(),
                crate::context::plain(&e)
            ))
        })?;
        sagnac::log::open(
            Source::stream(path.display().to_string(), Tail(file)),
            &args.log.read_options()?,
        )?
    } else {
        args.log.open(path)?.0
    };
    let name = if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    };
    let n = reader.layout().channels.len();
    let mut log = Log {
        columns: vec![Vec::new(); n],
        ..Log::default()
    };
    let mut block = Block::with_columns(n);
    let mut next_rows = 512;
    let mut last_look = Instant::now();
    while !INTERRUPTED.load(Ordering::SeqCst) && reader.read_block(&mut block)? {
        log.stamps.append(&block.stamps);
        for (all, part) in log.columns.iter_mut().zip(&block.columns) {
            all.extend_from_slice(part);
        }
        log.rows += block.rows;
        log.layout = reader.layout().clone();
        // Looks cost as the log grows: at most every second, and every tenth more.
        if log.rows < next_rows
            || (last_look.elapsed() < Duration::from_secs(1) && wanted.is_none())
        {
            continue;
        }
        next_rows = log.rows + (log.rows / 10).max(512);
        last_look = Instant::now();
        let Ok(outcome) = look(&name, &log, request) else {
            continue;
        };
        say(&outcome, wanted.as_deref(), context);
        if let Some(wanted) = &wanted
            && reached(&outcome, wanted)
        {
            let _ = IDLE_END.set(Instant::now());
            break;
        }
    }
    INTERRUPT_ENDS_INPUT.store(false, Ordering::SeqCst);
    if log.rows == 0 {
        return Err(Error::data("the log has no samples").at(name));
    }
    look(&name, &log, request)
}

/// Characterizes what is there so far.
fn look(name: &str, log: &Log, request: &Request) -> Result<Outcome, Error> {
    let mut log = log.clone();
    if log.layout.channels.iter().any(|c| c.is_increment) {
        let dt = log.dt_s()?;
        for (channel, column) in log.layout.channels.iter_mut().zip(&mut log.columns) {
            if channel.is_increment {
                for v in column.iter_mut() {
                    *v /= dt;
                }
                channel.is_increment = false;
            }
        }
    }
    characterize(
        &[NamedLog {
            name: name.to_owned(),
            log,
        }],
        request,
    )
}

/// Relative standard deviation of a term on an axis: none where it is not detected.
fn relative(axis: &sagnac::characterize::AxisOutcome, name: &str) -> Option<f64> {
    use sagnac::analysis::fit::Term;
    let e = axis.estimate.as_ref()?;
    for term in [
        Term::Quantization,
        Term::White,
        Term::Flicker,
        Term::RandomWalk,
        Term::Ramp,
    ] {
        if sagnac::characterize::key_of(axis.sensor, term) == name {
            let e = e.term(term)?;
            return Some(e.sigma? / e.value?.abs());
        }
    }
    let g = e.gauss_markov.first()?;
    let e = if name == "correlation_time" {
        &g.correlation_time_s
    } else {
        &g.sigma
    };
    Some(e.sigma? / e.value?)
}

/// Whether every axis that has a wanted term knows it well enough, and some axis has each.
fn reached(outcome: &Outcome, wanted: &[(String, f64)]) -> bool {
    let axes = || outcome.logs.iter().flat_map(|l| &l.axes);
    wanted.iter().all(|(name, limit)| {
        let known: Vec<f64> = axes().filter_map(|a| relative(a, name)).collect();
        !known.is_empty() && known.iter().all(|r| r <= limit)
    })
}

fn say(outcome: &Outcome, wanted: Option<&[(String, f64)]>, context: &Context) {
    let Some(log) = outcome.logs.first() else {
        return;
    };
    let mut parts = Vec::new();
    let list: Vec<(String, f64)> = wanted.map_or_else(
        || {
            [
                "angle_random_walk",
                "velocity_random_walk",
                "bias_instability",
            ]
            .map(|n| (n.to_owned(), 0.05))
            .to_vec()
        },
        <[_]>::to_vec,
    );
    for (name, limit) in &list {
        let worst = log
            .axes
            .iter()
            .filter_map(|a| relative(a, name))
            .fold(f64::NAN, f64::max);
        if worst.is_nan() {
            continue;
        }
        let mut text = format!("{} {:.1} %", name.replace('_', " "), 100.0 * worst);
        // What the same terms would need, by the bound.
        let need = log
            .axes
            .iter()
            .filter_map(|a| {
                let terms = &a.estimate.as_ref()?.fitted;
                let term = *planned(name, a.sensor, terms).first()?;
                sagnac::analysis::plan::duration_for(terms, 1.0 / log.rate_hz, &[(term, *limit)])
            })
            .fold(0.0, f64::max);
        if worst > *limit && need > log.duration_s {
            let left = sagnac::report::text::duration((need - log.duration_s).ceil());
            let _ = write!(text, " (± {:.0} % in {left})", 100.0 * limit);
        }
        parts.push(text);
    }
    context.note(&format!(
        "{} read; {}",
        sagnac::report::text::duration(log.duration_s.round()),
        if parts.is_empty() {
            "nothing is known yet".to_owned()
        } else {
            parts.join(", ")
        }
    ));
}
