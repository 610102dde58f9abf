//! Deviations of the crates `allan` and `allan-tools` of axes from standard input (little-endian f64, LENGTH an axis).
//!
//! usage: `peers allan|allan-tools STEP_S LENGTH`; a line an axis: `τ:deviation …`. `tools/peers.py` feeds it.

use std::io::{Read, Write};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, which, step, length] = arguments.as_slice() else {
        return Err("usage: peers allan|allan-tools STEP_S LENGTH".into());
    };
    let (step, length): (f64, usize) = (step.parse()?, length.parse()?);
    let (mut input, mut output) = (std::io::stdin().lock(), std::io::stdout().lock());
    let mut bytes = vec![0_u8; 8 * length];
    while input.read_exact(&mut bytes).is_ok() {
        let y: Vec<f64> = bytes
            .chunks_exact(8)
            .map(|c| f64::from_le_bytes(c.try_into().unwrap_or_default()))
            .collect();
        let octaves: Vec<usize> = (0..)
            .map(|k| 1 << k)
            .take_while(|m| 8 * m < length)
            .collect();
        let curve: Vec<(f64, f64)> = if which == "allan" {
            // Samples are rates: what the crate calls frequency data.
            let mut allan = allan::Allan::builder()
                .style(allan::Style::DecadeDeci)
                .max_tau(length / 8)
                .data_type(allan::DataType::Frequency)
                .build_allan();
            y.iter().for_each(|&v| allan.record(v));
            allan
                .iter()
                .filter_map(|t| Some((f64::from(t.tau()) * step, t.deviation()?)))
                .collect()
        } else {
            // Its averaging times count samples, whatever its rate.
            let taus: Vec<f64> = octaves.iter().map(|&m| m as f64).collect();
            match allan_tools::deviation(&y, &taus, allan_tools::Deviation::Allan, 1.0, true, true) {
                Ok((deviation, _)) => taus.into_iter().map(|m| m * step).zip(deviation).collect(),
                Err(error) => return Err(format!("{error}").into()),
            }
        };
        let line: Vec<String> = curve.iter().map(|(t, d)| format!("{t:e}:{d:e}")).collect();
        writeln!(output, "{}", line.join(" "))?;
        output.flush()?;
    }
    Ok(())
}
