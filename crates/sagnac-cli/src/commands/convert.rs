//! `sagnac convert LOG -o LOG`: a log in another format.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use sagnac::Error;
use sagnac::convert::{ConvertRequest, convert};
use sagnac::log::WriteFormat;
use sagnac::model::units::Dimension;

use crate::context::Context;
use crate::inputs::LogOptions;
use crate::outputs::Output;
use crate::quantities::positive;

/// A log in another format, cut, turned, resampled only when asked
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac convert flight.bag -o flight.csv.gz --topic /imu/data --start 30s"
)]
pub(crate) struct Args {
    /// A log in any known format; - reads CSV from standard input
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// The log to write; its extension says the format
    #[arg(short, long, value_name = "LOG")]
    output: PathBuf,
    /// Another rate, with an anti-alias filter
    #[arg(long, value_name = "RATE")]
    resample: Option<String>,
    /// The sensor's model: its white noise gives the covariances of ROS messages
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Overwrite the output
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    options: LogOptions,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let format = WriteFormat::of_name(&args.output.to_string_lossy())?;
    let resample_hz = args
        .resample
        .as_deref()
        .map(|text| positive("--resample", text, Dimension::FREQUENCY))
        .transpose()?;
    let output = SharedOutput::new(Output::claim(&args.output, "-o", args.force)?);
    let (mut reader, _meter) = match resample_hz {
        // Between samples there are numbers alone.
        Some(_) => args.options.open_whole(&args.log, WriteFormat::Npy)?,
        None => args.options.open_whole(&args.log, format)?,
    };
    let request = ConvertRequest {
        format,
        resample_hz,
        model: args
            .model
            .as_deref()
            .map(crate::inputs::model)
            .transpose()?,
    };
    let outcome = convert(&mut *reader, Box::new(output.clone()), &request)?;
    let name = output.into_output()?.publish()?;
    let files = [name];
    context.show(|| outcome.document(), || outcome.to_json(&files))?;
    context.wrote(&files)
}

/// An output that a writer fills while its owner keeps the right to name it.
#[derive(Clone)]
pub(crate) struct SharedOutput(Arc<Mutex<Output>>);

impl SharedOutput {
    pub(crate) fn new(output: Output) -> Self {
        Self(Arc::new(Mutex::new(output)))
    }

    /// The output, once the writer is gone.
    pub(crate) fn into_output(self) -> Result<Output, Error> {
        Arc::try_unwrap(self.0)
            .map(|m| m.into_inner().unwrap_or_else(PoisonError::into_inner))
            .map_err(|_| Error::data("the output is still being written"))
    }
}

impl Write for SharedOutput {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .flush()
    }
}

impl Seek for SharedOutput {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .seek(to)
    }
}
