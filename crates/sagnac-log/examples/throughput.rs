//! Reads a log to its end and says how fast and in how much memory: `throughput FILE [--columns LIST] [--rate HZ]`, `-` for a
//! pipe.
#![allow(clippy::print_stdout, reason = "an example that prints")]

use std::fs::File;
use std::time::Instant;

use sagnac_log::{Block, LogReader as _, ReadOptions, Source, open};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let name = words.first().map_or("-", String::as_str);
    let value = |key: &str| words.iter().skip_while(|w| *w != key).nth(1).cloned();
    let options = ReadOptions {
        columns: value("--columns"),
        rate_hz: value("--rate").map(|r| r.parse()).transpose()?,
        any_topic: true,
        threads: 1,
        ..ReadOptions::default()
    };
    let source = if name == "-" {
        Source::stream("standard input", std::io::stdin())
    } else {
        Source::file(name, File::open(name)?)
    };
    let start = Instant::now();
    let mut log = open(source, &options)?;
    let mut block = Block::default();
    let (mut rows, mut sum) = (0, 0.0);
    while log.read_block(&mut block)? {
        rows += block.rows;
        sum += block.columns.iter().filter_map(|c| c.last()).sum::<f64>();
    }
    let seconds = start.elapsed().as_secs_f64();
    // Linux: the most memory that was resident.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status
        .lines()
        .find_map(|l| l.strip_prefix("VmHWM:"))
        .map_or("?", str::trim);
    println!(
        "{{\"rows\": {rows}, \"seconds\": {seconds:.3}, \"rows_per_s\": {:.4e}, \"peak\": \"{peak}\", \"sum\": {sum}, \"notes\": {}}}",
        rows as f64 / seconds,
        log.layout().notes.len()
    );
    Ok(())
}
