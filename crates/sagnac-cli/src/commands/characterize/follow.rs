//! `--follow`: reads a growing log, says the state on standard error, ends at a precision, the end, or an interrupt.

use std::fs::File;
use std::io::{self, Read};
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
use crate::context::Context;
use crate::outputs::{INTERRUPT_ENDS_INPUT, INTERRUPTED};
use crate::progress::Redrawn;

/// How often the state is said.
const SECOND: Duration = Duration::from_secs(1);

/// Waits at the end of a file for more of it; an interrupt is its end, in a text an early one: its last line is not whole.
struct Tail {
    file: File,
    is_text: Option<bool>,
}

impl Read for Tail {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            if INTERRUPTED.load(Ordering::SeqCst) {
                return match self.is_text {
                    Some(true) => Err(io::Error::other("interrupted")),
                    _ => Ok(0),
                };
            }
            let n = self.file.read(buffer)?;
            if n > 0 || buffer.is_empty() {
                let is_byte_of_text = |c: &u8| *c > 31 || (9..14).contains(c);
                self.is_text
                    .get_or_insert_with(|| buffer[..n].iter().all(is_byte_of_text));
                return Ok(n);
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

pub(super) fn follow(args: &Args, request: &Request, context: &Context) -> Result<Outcome, Error> {
    let wanted = args.until.as_deref().map(wanted_precisions).transpose()?;
    if let Some(wanted) = &wanted {
        check(wanted, &Sensor::ALL, &request.candidates)?;
    }
    let path = args.logs.first().map_or(Path::new("-"), |p| p.as_path());
    INTERRUPT_ENDS_INPUT.store(true, Ordering::SeqCst);
    let source = if path.is_file() {
        crate::outputs::reads(path)?;
        let file = File::open(path).map_err(|e| {
            Error::data(format!(
                "{} cannot be read: {}",
                path.display(),
                crate::context::plain(&e)
            ))
        })?;
        Source::stream(
            path.display().to_string(),
            Tail {
                file,
                is_text: None,
            },
        )
    } else {
        crate::inputs::source(path)?.0
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
    std::thread::spawn(move || read(source, &options, &sender));
    let mut live = Live {
        named: NamedLog {
            name,
            log: Log::default(),
        },
        request,
        wanted: wanted.as_deref(),
        next_look: LEAST_SAMPLES,
        outcome: None,
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

/// Rows with what is known of the log, or why there are no more.
type Part = Result<(Block, Layout), Error>;

fn read(source: Source, options: &ReadOptions, parts: &SyncSender<Part>) {
    let mut reader = match sagnac::log::open(source, options) {
        Ok(reader) => reader,
        Err(e) => {
            let _ = parts.send(Err(e.into()));
            return;
        }
    };
    loop {
        let mut block = Block::with_columns(reader.layout().channels.len());
        let part = match reader.read_block(&mut block) {
            Ok(true) => Ok((block, reader.layout().clone())),
            Ok(false) => return,
            Err(e) => Err(e.into()),
        };
        let is_last = part.is_err();
        // Where nobody listens any more, nothing is to be read.
        if parts.send(part).is_err() || is_last {
            return;
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
                Ok(Ok((block, layout))) => self.take(block, layout)?,
                // What ends the recording may cut its last line.
                Ok(Err(_)) if INTERRUPTED.load(Ordering::SeqCst) => true,
                Ok(Err(e)) => return Err(e),
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
            && let Ok(Ok((block, layout))) = parts.recv_timeout(SECOND)
        {
            self.begin(layout)?;
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

    /// Adds rows; with a wanted precision looks as often as its growth asks for, at whatever speed it comes.
    fn take(&mut self, mut block: Block, layout: Layout) -> Result<bool, Error> {
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

    /// The result of all that was read.
    fn end(mut self) -> Result<Outcome, Error> {
        self.screen = None;
        let rows = self.named.log.rows;
        if rows == 0 {
            return Err(Error::data(format!(
                "fewer than {LEAST_SAMPLES} samples were there when it ended"
            ))
            .at(self.named.name)
            .advise("let it run on, or look at what records it"));
        }
        match self.outcome.take() {
            Some((of, outcome)) if of == rows => Ok(outcome),
            _ => characterized(&self.named, self.request),
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
