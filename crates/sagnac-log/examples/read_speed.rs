//! Reads a log to its end and prints rows, first and last row, and rows and bytes per second of processor time.
//!
//! `cargo run --release -p sagnac-log --example read_speed -- FILE [TOPIC [THREADS]]`; an empty topic is none
#![allow(clippy::print_stdout, reason = "a program")]

use std::time::Instant;

use sagnac_log::{Block, ReadOptions, Source, open};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let name = args.next().ok_or("name a file")?;
    let options = ReadOptions {
        topic: args.next().filter(|topic| !topic.is_empty()),
        any_topic: true,
        threads: args.next().map_or(Ok(0), |n| n.parse())?,
        ..ReadOptions::default()
    };
    let file = std::fs::File::open(&name)?;
    let bytes = file.metadata()?.len();
    let start = Instant::now();
    let mut reader = open(Source::file(name, file), &options)?;
    let mut block = Block::default();
    let (mut rows, mut first, mut last) = (0, None, None);
    while reader.read_block(&mut block)? {
        let row = |k: usize| {
            let values: Vec<f64> = block.columns.iter().map(|c| c[k]).collect();
            (block.stamps.get(k), values)
        };
        first.get_or_insert_with(|| row(0));
        last = Some(row(block.rows - 1));
        rows += block.rows;
    }
    let s = start.elapsed().as_secs_f64();
    println!("{:#?}", reader.layout());
    println!("{first:?}\n{last:?}");
    println!(
        "{rows} rows in {s:.3} s: {:.2} M rows/s, {:.0} MB/s",
        rows as f64 / s / 1e6,
        bytes as f64 / s / 1e6
    );
    Ok(())
}
