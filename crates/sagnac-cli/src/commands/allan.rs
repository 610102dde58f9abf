//! `sagnac allan LOG`: deviations or the spectrum of every axis.

use std::path::{Path, PathBuf};

use sagnac::Error;
use sagnac::allan::{AllanOutcome, AllanRequest, allan};
use sagnac::analysis::{Deviation, Estimate, TauGrid};
use sagnac::log::{Block, Layout, LogReader};
use sagnac::model::units::Dimension;

use crate::context::Context;
use crate::inputs::{LogOptions, Meter};
use crate::outputs::{Output, publish_all};
use crate::progress::Progress;
use crate::quantities::positive;

/// Allan deviation and its relatives of every axis, with intervals; or the spectrum
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac allan static.csv --taus '0.01 s, 1 s, 100 s' -o curve.svg"
)]
pub(crate) struct Args {
    /// The log; - is CSV from standard input
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// oadev, adev, mdev, hdev, totdev, tdev or theo1
    #[arg(long, value_name = "NAME", default_value = "oadev", value_parser = deviation)]
    deviation: Deviation,
    /// decade, octave, all or times: '0.01 s, 1 s, 100 s' [default: 100 steps]
    #[arg(long, value_name = "LIST")]
    taus: Option<String>,
    /// exact or strided [default: exact up to 1e8 values]
    #[arg(long, value_name = "NAME", value_parser = estimate)]
    estimate: Option<Estimate>,
    /// Welch's one-sided power spectral density instead
    #[arg(long, conflicts_with_all = ["deviation", "taus", "dynamic"])]
    spectrum: bool,
    /// Besides, on windows of this length every quarter of it
    #[arg(long, value_name = "WINDOW")]
    dynamic: Option<String>,
    /// Write F.csv, F.svg or F.png; may be given again
    #[arg(short, long, value_name = "F")]
    output: Vec<PathBuf>,
    /// Replace outputs that exist
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    reading: LogOptions,
}

fn deviation(name: &str) -> Result<Deviation, String> {
    Deviation::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = Deviation::ALL.iter().map(|kind| kind.name()).collect();
        format!("one of {}", names.join(", "))
    })
}

fn estimate(name: &str) -> Result<Estimate, String> {
    match name {
        "exact" => Ok(Estimate::Exact),
        "strided" => Ok(Estimate::Strided),
        _ => Err("one of exact, strided".to_owned()),
    }
}

fn taus(text: Option<&str>) -> Result<TauGrid, Error> {
    match text.map(str::trim) {
        None => Ok(TauGrid::Default),
        Some("decade") => Ok(TauGrid::Decade),
        Some("octave") => Ok(TauGrid::Octave),
        Some("all") => Ok(TauGrid::All),
        Some(list) => list
            .split(',')
            .map(|time| positive("--taus", time.trim(), Dimension::TIME))
            .collect::<Result<_, _>>()
            .map(TauGrid::Times),
    }
}

/// What an output's extension asks for.
#[derive(Clone, Copy)]
enum Sort {
    Csv,
    Svg,
    Png,
}

fn sort(path: &Path) -> Result<Sort, Error> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("csv") => Ok(Sort::Csv),
        Some("svg") => Ok(Sort::Svg),
        Some("png") => Ok(Sort::Png),
        _ => Err(
            Error::usage(format!("{} is neither .csv, .svg nor .png", path.display()))
                .at("-o")
                .advise("write for instance -o curve.csv or -o curve.svg"),
        ),
    }
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let request = AllanRequest {
        deviation: args.deviation,
        taus: taus(args.taus.as_deref())?,
        estimate: args.estimate,
        spectrum: args.spectrum,
        dynamic_s: args
            .dynamic
            .as_deref()
            .map(|time| positive("--dynamic", time, Dimension::TIME))
            .transpose()?,
        label: args.log.display().to_string(),
    };
    let mut outputs = Vec::new();
    for path in &args.output {
        let sort = sort(path)?;
        outputs.push((sort, Output::claim(path, "-o", args.force)?));
    }
    let (mut reader, meter) = args.reading.open(&args.log)?;
    let outcome = {
        let mut reader = Watched {
            inner: &mut *reader,
            meter: &meter,
            progress: &mut context.progress("reading", meter.size),
            work: if args.deviation == Deviation::Theo1 && !args.spectrum {
                "estimating  theo1, exact: time grows with the square of the log's length"
            } else {
                "estimating"
            },
        };
        allan(&mut reader, &request)?
    };
    let mut written = Vec::new();
    for (sort, mut output) in outputs {
        output.put(&bytes(sort, &outcome)?)?;
        written.push(output);
    }
    context.show(|| outcome.document(), || outcome.to_json())?;
    let names = publish_all(written)?;
    context.wrote(&names)
}

fn bytes(sort: Sort, outcome: &AllanOutcome) -> Result<Vec<u8>, Error> {
    match sort {
        Sort::Csv => Ok(outcome.to_csv().into_bytes()),
        Sort::Svg => Ok(outcome.to_svg().standalone().into_bytes()),
        Sort::Png => outcome
            .to_svg()
            .to_png()
            .map_err(|what| Error::data(format!("the picture cannot be drawn: {what}"))),
    }
}

/// A log whose reading is shown.
struct Watched<'a> {
    inner: &'a mut dyn LogReader,
    meter: &'a Meter,
    progress: &'a mut Progress,
    /// What goes on when all is read.
    work: &'static str,
}

impl LogReader for Watched<'_> {
    fn layout(&self) -> &Layout {
        self.inner.layout()
    }

    fn read_block(&mut self, block: &mut Block) -> Result<bool, sagnac::log::Error> {
        self.progress.set(self.meter.bytes());
        let more = self.inner.read_block(block)?;
        if !more {
            self.progress.work(self.work);
        }
        Ok(more)
    }
}
