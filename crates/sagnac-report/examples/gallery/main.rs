//! Writes every plot and page, with made-up numbers, into a folder: `cargo run --example gallery -- DIR`.
#![allow(clippy::print_stdout, reason = "an example")]

mod characterize;
mod figures;
mod pages;

use std::path::Path;

use characterize::{characterize, chart, gyro, issues};
use figures::others;
use pages::pages;
use sagnac_report::plots::allan_panels;
use sagnac_report::svg::Svg;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let dir = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "gallery".to_owned());
    let dir = Path::new(&dir);
    std::fs::create_dir_all(dir)?;
    let figures = allan_panels(&gyro());
    let sheet = Svg::sheet(
        "Allan deviation",
        &[figures
            .iter()
            .map(|f| f.svg.captioned(&f.caption, &f.caption_rest))
            .collect()],
    );
    put(dir, "allan-panels", &sheet)?;
    let issues = issues().figure();
    put(dir, "issues", &issues.svg)?;
    if let Some(narrow) = &issues.narrow {
        put(dir, "issues-narrow", narrow)?;
    }
    let charts = Svg::sheet(
        "example: overlapping Allan deviation, 95 % band",
        &[vec![chart("gyro"), chart("accelerometer")]],
    );
    put(dir, "allan-chart", &charts)?;
    std::fs::write(dir.join("characterize.html"), characterize().html())?;
    for (name, html) in pages() {
        std::fs::write(dir.join(name), html)?;
    }
    for figure in others() {
        put(dir, &figure.plot, &figure.svg)?;
        if let Some(narrow) = &figure.narrow {
            put(dir, &format!("{}-narrow", figure.plot), narrow)?;
        }
    }
    Ok(())
}

fn put(dir: &Path, name: &str, svg: &Svg) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::write(dir.join(format!("{name}.svg")), svg.standalone())?;
    std::fs::write(dir.join(format!("{name}.png")), svg.to_png()?)?;
    println!("{name}");
    Ok(())
}
