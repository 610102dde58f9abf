//! Feeds mutated logs to every reader and watches for panics, hangs and memory.
//!
//!     cargo run --release -p sagnac-fuzz -- [--inputs N] [--reader NAME] [--seed S] [--only K]
//!
//! Input k of a reader depends on the seed and k alone, so that `--only K` repeats it. Runs on the stable toolchain;
//! seeds are the small files of `testdata/`, what the writers write, and the heads of `SAGNAC_DATA`'s files.

#![allow(clippy::print_stdout, reason = "a command for developers")]

mod memory;
mod mutate;
mod seeds;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use sagnac_log::{Block, Error, LogReader, open};

use seeds::Reader;

/// An input that takes longer hangs, on the slowest machine.
const HANG: Duration = Duration::from_secs(20);
/// Bytes that reading a small input may take at once: a packed chunk of 128 MiB is held, twice while it grows.
const MOST_MEMORY: usize = 384 << 20;

/// Seconds since the start at which the input at hand began, and its number; 0: none.
static BEGAN: AtomicU64 = AtomicU64::new(0);
static NUMBER: AtomicU64 = AtomicU64::new(0);

struct Options {
    inputs: u64,
    reader: Option<String>,
    seed: u64,
    only: Option<u64>,
}

fn main() -> ExitCode {
    let Some(options) = arguments() else {
        println!("sagnac-fuzz [--inputs N] [--reader NAME] [--seed S] [--only K]");
        return ExitCode::from(2);
    };
    std::panic::set_hook(Box::new(|_| {}));
    if options.only.is_some() {
        let _ = std::panic::take_hook();
    }
    watch();
    println!(
        "| reader | seeds | inputs | read | read in part | refused | panics | slowest, ms | most memory, MB | time, s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let mut failures = 0;
    for reader in seeds::readers() {
        if options.reader.as_ref().is_none_or(|r| *r == reader.name) {
            failures += run(&reader, &options);
        }
    }
    if failures == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn arguments() -> Option<Options> {
    let mut options = Options {
        inputs: 2000,
        reader: None,
        seed: 20_261_130,
        only: None,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next()?;
        match word.as_str() {
            "--inputs" => options.inputs = value.parse().ok()?,
            "--reader" => options.reader = Some(value),
            "--seed" => options.seed = value.parse().ok()?,
            "--only" => options.only = Some(value.parse().ok()?),
            _ => return None,
        }
    }
    Some(options)
}

/// Ends the program with the input's number where one hangs.
fn watch() {
    let start = Instant::now();
    BEGAN.store(0, Ordering::Relaxed);
    std::thread::spawn(move || {
        let mut last = (u64::MAX, start);
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let now = NUMBER.load(Ordering::Relaxed);
            if BEGAN.load(Ordering::Relaxed) == 0 || last.0 != now {
                last = (now, Instant::now());
            } else if last.1.elapsed() > HANG {
                println!("HANG: input {now}");
                std::process::exit(1);
            }
        }
    });
}

#[derive(Default)]
struct Tally {
    whole: u64,
    part: u64,
    refused: u64,
    panics: u64,
    slowest: Duration,
    most: usize,
}

/// All inputs of a reader; how many of them failed.
fn run(reader: &Reader, options: &Options) -> u64 {
    let start = Instant::now();
    let mut tally = Tally::default();
    let mut failures = 0;
    let numbers = match options.only {
        Some(k) => k..k + 1,
        None => 0..options.inputs,
    };
    let count = numbers.end - numbers.start;
    for k in numbers {
        let input = mutate::input(&reader.seeds, options.seed, k);
        NUMBER.store(k, Ordering::Relaxed);
        BEGAN.store(1, Ordering::Relaxed);
        memory::begin();
        let began = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| read(reader, input)));
        let took = began.elapsed();
        let most = memory::most();
        BEGAN.store(0, Ordering::Relaxed);
        match outcome {
            Ok(Ok(true)) => tally.whole += 1,
            Ok(Ok(false)) => tally.part += 1,
            Ok(Err(error)) => {
                if options.only.is_some() {
                    println!("{error}");
                }
                tally.refused += 1;
            }
            Err(_) => {
                tally.panics += 1;
                println!("PANIC: {} input {k}", reader.name);
            }
        }
        if most > MOST_MEMORY {
            println!("MEMORY: {} input {k}: {} MB", reader.name, most >> 20);
            failures += 1;
        }
        if took > HANG / 10 {
            println!("SLOW: {} input {k}: {} ms", reader.name, took.as_millis());
            failures += 1;
        }
        tally.slowest = tally.slowest.max(took);
        tally.most = tally.most.max(most);
    }
    println!(
        "| {} | {} | {count} | {} | {} | {} | {} | {:.1} | {:.1} | {:.0} |",
        reader.name,
        reader.seeds.len(),
        tally.whole,
        tally.part,
        tally.refused,
        tally.panics,
        tally.slowest.as_secs_f64() * 1e3,
        tally.most as f64 / 1e6,
        start.elapsed().as_secs_f64()
    );
    failures + tally.panics
}

/// Reads a log to its end; whether without a word on losses.
fn read(reader: &Reader, input: Vec<u8>) -> Result<bool, Error> {
    let mut log = open((reader.source)(input), &reader.options)?;
    let notes = log.layout().notes.len();
    let mut block = Block::default();
    while log.read_block(&mut block)? {}
    Ok(log.layout().notes.len() == notes)
}
