//! `sagnac strapdown LOG --reference F -o NAV`: position, velocity and attitude from a log.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use sagnac::Error;
use sagnac::log::{Log, WriteFormat, create};
use sagnac::strapdown::{StrapdownRequest, layout, strapdown};

use crate::context::Context;
use crate::inputs::LogOptions;
use crate::motion::{ReferenceOptions, Sculling, StartOptions, Vertical};
use crate::outputs::{Output, publish_all};

/// Position, velocity and attitude from a log, beginning at a reference's first row
#[derive(clap::Args)]
#[command(
    override_usage = "sagnac strapdown LOG --reference F [OPTIONS] -o NAV",
    after_help = "Example\n  sagnac strapdown drive.csv --reference truth.csv -o nav.csv"
)]
pub(crate) struct Args {
    /// Gyro and accelerometer
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// A truth log, or a path with attitude
    #[arg(long = "reference", id = "reference_file", value_name = "F")]
    reference: PathBuf,
    /// What holds the height
    #[arg(long, value_enum, default_value_t = Vertical::Free, value_name = "free|fixed|baro", hide_possible_values = true)]
    vertical: Vertical,
    /// Samples in the coning and sculling terms
    #[arg(long, value_enum, default_value_t = Sculling::Five, value_name = "two|five", hide_possible_values = true)]
    sculling: Sculling,
    /// Where position, velocity and attitude go: .csv, .npy …
    #[arg(short, long, value_name = "NAV")]
    output: PathBuf,
    /// Overwrite an output that exists
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    at: StartOptions,
    #[command(flatten)]
    reference_options: ReferenceOptions,
    #[command(flatten)]
    reading: LogOptions,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let format = WriteFormat::of_name(&args.output.display().to_string())?;
    let output = Shared(Arc::new(Mutex::new(Some(Output::claim(
        &args.output,
        "-o",
        args.force,
    )?))));
    let (mut reader, _) = args.reading.open(&args.log)?;
    let log = Log::read(&mut reader)?;
    let reference = args.reference_options.read(&args.reference)?;
    let mut writer = create(format, Box::new(output.clone()), &layout(&log))?;
    let mut outcome = strapdown(
        &StrapdownRequest {
            log: &log,
            log_label: &args.log.display().to_string(),
            reference: &reference,
            reference_label: &args.reference.display().to_string(),
            start: args.at.start()?,
            earth: args.at.earth(),
            vertical: args.vertical.into(),
            sculling: args.sculling.into(),
        },
        writer.as_mut(),
    )?;
    for note in writer.finish()? {
        context.note(&note);
    }
    if let Some(sentence) = &outcome.left_out {
        context.warn(sentence);
    }
    if outcome.gaps > 0 {
        context.warn(&format!(
            "{} gaps were bridged with the sample after them",
            outcome.gaps
        ));
    }
    let names = publish_all(output.take().into_iter().collect())?;
    outcome.files.clone_from(&names);
    context.show(|| outcome.document(), || outcome.to_json())?;
    context.wrote(&names)
}

/// An output that both the writer of the format and the end of the command hold.
#[derive(Clone)]
struct Shared(Arc<Mutex<Option<Output>>>);

impl Shared {
    fn take(&self) -> Option<Output> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .as_mut()
            .map_or(Ok(0), |o| o.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .as_mut()
            .map_or(Ok(()), Write::flush)
    }
}

impl Seek for Shared {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .as_mut()
            .map_or(Ok(0), |o| o.seek(to))
    }
}
