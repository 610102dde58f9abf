//! `--follow`: reads a growing log, says the state on standard error, ends at a precision, the end, or an interrupt.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use sagnac::Error;
use sagnac::characterize::{NamedLog, Outcome, Request, characterize};
use sagnac::core::Sensor;
use sagnac::follow::{LEAST_SAMPLES, State, check};
use sagnac::log::{Block, Layout, Log, ReadOptions, Source};
use sagnac::plan::wanted_precisions;

use super::Args;
use super::growing::Growing;
use crate::context::Context;
use crate::outputs::{INTERRUPT_ENDS_INPUT, INTERRUPTED};
use crate::progress::Redrawn;

/// How often the state is said.
const SECOND: Duration = Duration::from_secs(1);

/// The result of all that was read, and what ended the reading where that is an error.
pub(super) type Followed = (Outcome, Option<Error>);

pub(super) fn follow(args: &Args, request: &Request, context: &Context) -> Result<Followed, Error> {
    let wanted = args.until.as_deref().map(wanted_precisions).transpose()?;
    if let Some(wanted) = &wanted {
        check(wanted, &Sensor::ALL, &request.candidates)?;
    }
    let path = args.logs.first().map_or(Path::new("-"), |p| p.as_path());
    INTERRUPT_ENDS_INPUT.store(true, Ordering::SeqCst);
    let source = if path.is_file() {
        crate::outputs::reads(path)?;
        Input::Growing(Growing::open(path)?)
    } else {
        Input::Once(crate::inputs::source(path)?.0)
    };
    let name = if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    };
    let options = ReadOptions {
        is_live: true,
        ..args.log.read_options()?
    };
    let (sender, parts) = sync_channel(4);
    // It waits for input that may never come: the process does not wait for it.
    std::thread::spawn(move || match source {
        Input::Once(source) => {
            let _ = read(source, &options, &sender);
        }
        Input::Growing(file) => read_again_and_again(&file, &options, &sender),
    });
    let mut live = Live {
        named: NamedLog {
            name,
            log: Log::default(),
        },
        request,
        wanted: wanted.as_deref(),
        next_look: LEAST_SAMPLES,
        outcome: None,
        anew: None,
        error: None,
        reached: 0,
        said: None,
        pause: Duration::ZERO,
        context,
        screen: context.redrawn(),
    };
    live.run(&parts)?;
    INTERRUPT_ENDS_INPUT.store(false, Ordering::SeqCst);
    live.end()
}

/// What is read.
enum Input {
    /// A pipe or device, to its end.
    Once(Source),
    /// A file that grows, and may begin anew.
    Growing(Growing),
}

/// What reading gives.
enum Part {
    /// Rows with what is known of the log.
    Rows(Block, Box<Layout>),
    /// The rows that follow are those of a file that begins anew, and why.
    Anew(&'static str),
    /// Something to be told.
    Said(&'static str),
    /// Why there are no more.
    Error(Error),
}

/// Hands on what a source gives; its error, where it ends by one, or where nobody listens any more.
fn read(source: Source, options: &ReadOptions, parts: &SyncSender<Part>) -> Result<(), ()> {
    let failed = |e: Error| parts.send(Part::Error(e)).map_err(|_| ());
    let mut reader = match sagnac::log::open(source, options) {
        Ok(reader) => reader,
        Err(e) => return failed(e.into()),
    };
    loop {
        let mut block = Block::with_columns(reader.layout().channels.len());
        match reader.read_block(&mut block) {
            Ok(true) => {
                let layout = reader.layout().clone();
                parts
                    .send(Part::Rows(block, Box::new(layout)))
                    .map_err(|_| ())?;
            }
            Ok(false) => return Ok(()),
            Err(e) => return failed(e.into()),
        }
    }
}

/// Reads a growing file, and again from its start where it was cut or another took its place.
fn read_again_and_again(file: &Growing, options: &ReadOptions, parts: &SyncSender<Part>) {
    loop {
        // What a cut leaves of the last row is no row: its error is not told.
        let (inner, held) = sync_channel(4);
        let said = parts.clone();
        let source = file.source(move |what| {
            let _ = said.send(Part::Said(what));
        });
        std::thread::scope(|scope| {
            scope.spawn(move || read(source, options, &inner));
            for part in held {
                let is_cut = matches!(part, Part::Error(_)) && file.begins_anew().is_some();
                if !is_cut && parts.send(part).is_err() {
                    return;
                }
            }
        });
        match file.take_anew() {
            Some(why) if parts.send(Part::Anew(why)).is_ok() => {}
            _ => return,
        }
    }
}

/// A log that grows, and what was last said of it.
struct Live<'a> {
    named: NamedLog,
    request: &'a Request,
    wanted: Option<&'a [(String, f64)]>,
    /// Rows at which a wanted precision is looked for again.
    next_look: usize,
    /// The last look and its rows.
    outcome: Option<(usize, Outcome)>,
    /// The file begins anew with the next rows, and why.
    anew: Option<&'static str>,
    /// What ended the reading, if it was no end.
    error: Option<Error>,
    /// Precisions that were reached when the state was last said.
    reached: usize,
    said: Option<Instant>,
    /// What a look takes, twice: looks leave half of the time to reading.
    pause: Duration,
    context: &'a Context,
    screen: Option<Redrawn>,
}

impl Live<'_> {
    /// Takes parts until there are no more, the wanted precision is reached, or an interrupt says that it is over.
    fn run(&mut self, parts: &Receiver<Part>) -> Result<(), Error> {
        while !INTERRUPTED.load(Ordering::SeqCst) {
            let wait = Duration::from_millis(100);
            let over = match parts.recv_timeout(wait) {
                Ok(Part::Rows(block, layout)) => self.take(block, *layout)?,
                Ok(Part::Anew(why)) => {
                    self.anew = Some(why);
                    false
                }
                Ok(Part::Said(what)) => {
                    self.context.note(&format!("{} {what}", self.named.name));
                    false
                }
                // What ends the recording may cut its last line.
                Ok(Part::Error(_)) if INTERRUPTED.load(Ordering::SeqCst) => true,
                Ok(Part::Error(e)) => {
                    self.error = Some(e);
                    true
                }
                Err(RecvTimeoutError::Timeout) => false,
                Err(RecvTimeoutError::Disconnected) => true,
            };
            if over {
                return Ok(());
            }
            let due = self
                .said
                .is_none_or(|at| at.elapsed() >= SECOND.max(self.pause));
            if due && self.look() {
                return Ok(());
            }
        }
        self.rest(parts)
    }

    /// What was on its way when the interrupt came; the other end may go on or be silent.
    fn rest(&mut self, parts: &Receiver<Part>) -> Result<(), Error> {
        let until = Instant::now() + 2 * SECOND;
        while Instant::now() < until
            && let Ok(Part::Rows(block, layout)) = parts.recv_timeout(SECOND)
        {
            self.begin(*layout)?;
            append(&mut self.named.log, &block);
        }
        Ok(())
    }

    /// Keeps what is known of the log; refuses at its first rows what it can never tell.
    fn begin(&mut self, layout: Layout) -> Result<(), Error> {
        let log = &mut self.named.log;
        if log.rows == 0 {
            if let Some(wanted) = self.wanted {
                let has = |s: &Sensor| {
                    let mut names = layout.channels.iter().map(|c| c.name.as_str());
                    names.any(|n| {
                        ["x", "y", "z"]
                            .iter()
                            .any(|a| n == format!("{}_{a}", s.key()))
                    })
                };
                let sensors: Vec<Sensor> = Sensor::ALL.into_iter().filter(has).collect();
                check(wanted, &sensors, &self.request.candidates)
                    .map_err(|e| e.at(self.named.name.clone()))?;
            }
            log.columns = vec![Vec::new(); layout.channels.len()];
        }
        log.layout = layout;
        Ok(())
    }

    /// A file that begins anew goes on with what was read where its times do; else it is another recording, or the same
    /// once more. False where it holds other channels: what was read is all.
    fn begin_anew(&mut self, why: &str, block: &Block, layout: &Layout) -> bool {
        let name = self.named.name.clone();
        let old = &self.named.log;
        if old.rows > 0 && old.layout.channels != layout.channels {
            self.error = Some(
                Error::data(format!("the file {why}, with other channels"))
                    .at(name)
                    .advise(
                        "the result is that of what was read before; start again for the new file",
                    ),
            );
            return false;
        }
        let last = old
            .stamps
            .len()
            .checked_sub(1)
            .and_then(|k| old.stamps.get(k));
        let goes_on = matches!((last, block.stamps.get(0)), (Some(a), Some(b)) if b.since(a) > 0.0);
        let then = if goes_on {
            "its times go on, what was read before counts as well"
        } else {
            "its times begin again, what was read before is left out"
        };
        if !goes_on {
            // What is known is said before it is left.
            self.said = None;
            self.look();
            self.named.log = Log::default();
            (self.outcome, self.next_look, self.reached) = (None, LEAST_SAMPLES, 0);
        }
        self.context
            .note(&format!("{name} {why}, read from its start: {then}"));
        true
    }

    /// Adds rows; with a wanted precision looks as often as its growth asks for, at whatever speed it comes.
    fn take(&mut self, mut block: Block, layout: Layout) -> Result<bool, Error> {
        if let Some(why) = self.anew.take()
            && !self.begin_anew(why, &block, &layout)
        {
            return Ok(true);
        }
        self.begin(layout)?;
        while block.rows > 0 {
            let log = &mut self.named.log;
            let room = if self.wanted.is_some() {
                self.next_look.saturating_sub(log.rows).max(1)
            } else {
                block.rows
            };
            if room >= block.rows {
                append(log, &block);
                block.rows = 0;
            } else {
                let mut part = block.clone();
                part.keep(0..room);
                append(log, &part);
                block.keep(room..block.rows);
            }
            if self.wanted.is_some() && self.named.log.rows >= self.next_look && self.look() {
                return Ok(true);
            }
            if INTERRUPTED.load(Ordering::SeqCst) {
                append(&mut self.named.log, &block);
                break;
            }
        }
        Ok(false)
    }

    /// Characterizes what is there and says it where it is time; whether the wanted precision is reached.
    fn look(&mut self) -> bool {
        let rows = self.named.log.rows;
        if rows < LEAST_SAMPLES || self.outcome.as_ref().is_some_and(|o| o.0 == rows) {
            return false;
        }
        let began = Instant::now();
        // A tenth more each time: all looks together cost ten times the last one.
        self.next_look = rows + (rows / 10).max(8);
        let Ok(outcome) = characterized(&self.named, self.request) else {
            return false;
        };
        let mut is_reached = false;
        if let Some(log) = outcome.logs.first() {
            let state = State::of(log, self.wanted);
            is_reached = state.is_reached();
            if let Some(needed) = state.needed_samples() {
                self.next_look = self.next_look.min(needed.max(rows + (rows / 100).max(1)));
            }
            self.pause = 2 * began.elapsed();
            let reached = state.reached();
            let is_time = self
                .said
                .is_none_or(|at| at.elapsed() >= SECOND.max(self.pause));
            if is_time || reached > self.reached || is_reached {
                match &self.screen {
                    Some(screen) => screen.draw(&state.document()),
                    None => self.context.note(&state.line()),
                }
                self.said = Some(Instant::now());
                self.reached = reached;
            }
        }
        self.outcome = Some((rows, outcome));
        is_reached
    }

    /// The result of all that was read, with the error that ended it; that alone where nothing was read.
    fn end(mut self) -> Result<Followed, Error> {
        self.screen = None;
        let rows = self.named.log.rows;
        let error = self.error.take();
        if rows == 0 {
            return Err(error.unwrap_or_else(|| {
                Error::data(format!(
                    "fewer than {LEAST_SAMPLES} samples were there when it ended"
                ))
                .at(self.named.name)
                .advise("let it run on, or look at what records it")
            }));
        }
        let outcome = match self.outcome.take() {
            Some((of, outcome)) if of == rows => Ok(outcome),
            _ => characterized(&self.named, self.request),
        };
        match (outcome, error) {
            (Ok(outcome), error) => Ok((outcome, error)),
            (Err(_), Some(error)) | (Err(error), None) => Err(error),
        }
    }
}

fn append(log: &mut Log, block: &Block) {
    log.stamps.append(&block.stamps);
    for (all, part) in log.columns.iter_mut().zip(&block.columns) {
        all.extend_from_slice(part);
    }
    log.rows += block.rows;
}

/// Characterizes what is there so far.
fn characterized(named: &NamedLog, request: &Request) -> Result<Outcome, Error> {
    if !named.log.layout.channels.iter().any(|c| c.is_increment) {
        return characterize(std::slice::from_ref(named), request);
    }
    let mut named = named.clone();
    let log = &mut named.log;
    let dt = log.dt_s()?;
    for (channel, column) in log.layout.channels.iter_mut().zip(&mut log.columns) {
        if channel.is_increment {
            for v in column.iter_mut() {
                *v /= dt;
            }
            channel.is_increment = false;
        }
    }
    characterize(&[named], request)
}
