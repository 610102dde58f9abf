//! Opening logs and text files by name, with the options that every command that reads a log takes.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use sagnac::Error;
use sagnac::log::{Folder, LogReader, ReadOptions, ReadSeek, Source, WriteFormat};
use sagnac::model::Model;
use sagnac::model::units::Dimension;
use sha2::{Digest as _, Sha256};

use crate::context::plain;
use crate::quantities::{optional, positive};

/// The largest text file (model, table, schedule) that is read whole.
const LARGEST_TEXT: u64 = 64 << 20;

/// How a log is read; the same options for every command.
#[derive(clap::Args, Clone, Default)]
#[command(next_help_heading = "Reading the log")]
pub(crate) struct LogOptions {
    /// What the columns are: 'time=0:us, gyro=4,5,6:deg/s, accel=1,2,3:g'
    #[arg(long, value_name = "LIST")]
    pub(crate) columns: Option<String>,
    /// Sampling rate, for instance 200Hz; overrides the time stamps
    #[arg(long, value_name = "RATE")]
    pub(crate) rate: Option<String>,
    /// ROS topic, ULog or ArduPilot message, or number of the IMU
    #[arg(long, value_name = "NAME")]
    pub(crate) topic: Option<String>,
    /// Leave out what is before, counted from the first sample
    #[arg(long, value_name = "TIME")]
    pub(crate) start: Option<String>,
    /// Leave out this and what is after, counted from the first sample
    #[arg(long, value_name = "TIME")]
    pub(crate) end: Option<String>,
    /// Turn the mounting: 'x=-y, y=x, z=z'
    #[arg(long, value_name = "LIST")]
    pub(crate) axes: Option<String>,
    /// Where the hashes of inputs that can be read only once are kept, if they are wanted.
    #[arg(skip)]
    pub(crate) hashes: Option<Hashes>,
}

/// SHA-256 of pipes, by name, as far as they were read.
#[derive(Clone, Default)]
pub(crate) struct Hashes(Arc<Mutex<Vec<(String, Hash)>>>);

type Hash = Arc<Mutex<Sha256>>;

impl Hashes {
    fn begin(&self, label: &str) -> Hash {
        let hash = Hash::default();
        if let Ok(mut all) = self.0.lock() {
            all.push((label.to_owned(), hash.clone()));
        }
        hash
    }

    /// Names and hashes.
    pub(crate) fn finish(&self) -> Vec<(String, String)> {
        let Ok(all) = self.0.lock() else {
            return Vec::new();
        };
        all.iter()
            .filter_map(|(label, hash)| Some((label.clone(), hash.lock().ok()?.clone())))
            .map(|(label, hash)| (label, hexadecimal(&hash.finalize())))
            .collect()
    }
}

/// Bytes as a hash is written.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

impl LogOptions {
    /// Whether any was given.
    pub(crate) fn is_any(&self) -> bool {
        self.rate.is_some() || self.is_beyond_rate()
    }

    /// Whether any but the rate was given.
    pub(crate) fn is_beyond_rate(&self) -> bool {
        [
            &self.columns,
            &self.topic,
            &self.start,
            &self.end,
            &self.axes,
        ]
        .iter()
        .any(|option| option.is_some())
    }

    /// The options as the library takes them.
    pub(crate) fn read_options(&self) -> Result<ReadOptions, Error> {
        let rate_hz = self
            .rate
            .as_deref()
            .map(|text| positive("--rate", text, Dimension::FREQUENCY))
            .transpose()?;
        Ok(ReadOptions {
            columns: self.columns.clone(),
            rate_hz,
            topic: self.topic.clone(),
            start_s: optional("--start", self.start.as_deref(), Dimension::TIME)?,
            end_s: optional("--end", self.end.as_deref(), Dimension::TIME)?,
            axes: self.axes.clone(),
            any_topic: false,
            keep_others: false,
            keep_text: false,
            is_live: false,
            threads: rayon::current_num_threads(),
        })
    }

    /// Opens a log by name; `-` is standard input.
    pub(crate) fn open(&self, path: &Path) -> Result<(Box<dyn LogReader>, Meter), Error> {
        open_with(path, &self.read_options()?, self.hashes.as_ref())
    }

    /// Opens a log with the columns that are no channels, to be written as `format`: cell by cell
    /// as they are where that holds text, else as numbers.
    pub(crate) fn open_whole(
        &self,
        path: &Path,
        format: WriteFormat,
    ) -> Result<(Box<dyn LogReader>, Meter), Error> {
        let options = ReadOptions {
            keep_others: true,
            keep_text: format.is_text(),
            ..self.read_options()?
        };
        open_with(path, &options, self.hashes.as_ref())
    }

    /// Opens a log for a look at it: of several topics the first.
    pub(crate) fn open_any(&self, path: &Path) -> Result<(Box<dyn LogReader>, Meter), Error> {
        let options = ReadOptions {
            any_topic: true,
            ..self.read_options()?
        };
        open_with(path, &options, self.hashes.as_ref())
    }
}

/// A reader that shows how far it is.
pub(crate) struct Metered {
    reader: Box<dyn LogReader>,
    meter: Meter,
    progress: crate::progress::Progress,
}

/// Opens a log with a progress bar over its bytes.
pub(crate) fn metered(
    path: &Path,
    options: &LogOptions,
    context: &crate::context::Context,
) -> Result<Metered, Error> {
    let name = if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    };
    let (reader, meter) = options.open(path)?;
    Ok(Metered {
        progress: context.progress(&format!("reading  {name}"), meter.size),
        meter,
        reader,
    })
}

impl LogReader for Metered {
    fn layout(&self) -> &sagnac::log::Layout {
        self.reader.layout()
    }

    fn read_block(&mut self, block: &mut sagnac::log::Block) -> Result<bool, sagnac::log::Error> {
        self.progress.set(self.meter.bytes());
        self.reader.read_block(block)
    }
}

fn open_with(
    path: &Path,
    options: &ReadOptions,
    hashes: Option<&Hashes>,
) -> Result<(Box<dyn LogReader>, Meter), Error> {
    let (source, meter) = hashed_source(path, hashes)?;
    Ok((sagnac::log::open(source, options)?, meter))
}

/// How many bytes of an input have been read, for progress.
#[derive(Clone)]
pub(crate) struct Meter {
    read: Arc<AtomicU64>,
    /// Size of the file, where it has one.
    pub(crate) size: Option<u64>,
}

impl Meter {
    /// Bytes read so far.
    pub(crate) fn bytes(&self) -> u64 {
        self.read.load(Ordering::Relaxed)
    }
}

/// The bytes of a log: a file, a folder, a pipe, or `-` for standard input.
pub(crate) fn source(path: &Path) -> Result<(Source, Meter), Error> {
    hashed_source(path, None)
}

fn hashed_source(path: &Path, hashes: Option<&Hashes>) -> Result<(Source, Meter), Error> {
    let mut meter = Meter {
        read: Arc::default(),
        size: None,
    };
    if path == Path::new("-") {
        let input = Counted {
            inner: io::stdin(),
            read: meter.read.clone(),
            hash: hashes.map(|h| h.begin("standard input")),
        };
        return Ok((Source::stream("standard input", input), meter));
    }
    let label = path.display().to_string();
    let metadata = std::fs::metadata(path).map_err(|error| unreadable(path, &error))?;
    if metadata.is_dir() {
        return Ok((Source::folder(label, Directory(path.to_owned())), meter));
    }
    crate::outputs::reads(path)?;
    let file = File::open(path).map_err(|error| unreadable(path, &error))?;
    let counted = Counted {
        inner: file,
        read: meter.read.clone(),
        hash: hashes
            .filter(|_| !metadata.is_file())
            .map(|h| h.begin(&label)),
    };
    if !metadata.is_file() {
        return Ok((Source::stream(label, counted), meter));
    }
    meter.size = Some(metadata.len());
    Ok((Source::file(label, counted), meter))
}

/// A text file read whole (a model, a table, a schedule); `-` is standard input.
pub(crate) fn text(path: &Path) -> Result<String, Error> {
    let label = if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    };
    let mut bytes = Vec::new();
    let read = if path == Path::new("-") {
        io::stdin().take(LARGEST_TEXT + 1).read_to_end(&mut bytes)
    } else {
        if path.is_dir() {
            return Err(Error::data(format!("{label} is a folder")).advise("name the file in it"));
        }
        crate::outputs::reads(path)?;
        File::open(path).and_then(|file| file.take(LARGEST_TEXT + 1).read_to_end(&mut bytes))
    };
    read.map_err(|error| unreadable(path, &error))?;
    if bytes.len() as u64 > LARGEST_TEXT {
        return Err(
            Error::data(format!("{label} is larger than {} MB", LARGEST_TEXT >> 20))
                .advise("is it a log? Then name it where the command takes a log"),
        );
    }
    String::from_utf8(bytes).map_err(|error| {
        let upto = error.utf8_error().valid_up_to();
        let line = error
            .as_bytes()
            .iter()
            .take(upto)
            .filter(|byte| **byte == b'\n')
            .count()
            + 1;
        Error::data("the file is not UTF-8 text")
            .at(format!("{label}, line {line}"))
            .advise("save it as plain UTF-8 text")
    })
}

/// A file of another tool read whole, whatever its bytes.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    if path.is_dir() {
        return Err(
            Error::data(format!("{} is a folder", path.display())).advise("name the file in it")
        );
    }
    let mut bytes = Vec::new();
    let read = if path == Path::new("-") {
        io::stdin().take(LARGEST_TEXT + 1).read_to_end(&mut bytes)
    } else {
        crate::outputs::reads(path)?;
        File::open(path).and_then(|file| file.take(LARGEST_TEXT + 1).read_to_end(&mut bytes))
    };
    read.map_err(|error| unreadable(path, &error))?;
    Ok(bytes)
}

/// A model by file name or as `catalog:NAME`.
pub(crate) fn model(name: &str) -> Result<Model, Error> {
    crate::models::load(name)
}

fn unreadable(path: &Path, error: &io::Error) -> Error {
    Error::data(format!(
        "{} cannot be read: {}",
        path.display(),
        plain(error)
    ))
    .advise("check the name and who may read it")
}

/// Counts what goes through.
struct Counted<R> {
    inner: R,
    read: Arc<AtomicU64>,
    hash: Option<Hash>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.read.fetch_add(n as u64, Ordering::Relaxed);
        if let Some(mut hash) = self.hash.as_ref().and_then(|hash| hash.lock().ok()) {
            hash.update(&buffer[..n]);
        }
        Ok(n)
    }
}

impl<R: Seek> Seek for Counted<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

/// A folder of the file system.
struct Directory(PathBuf);

/// More files than any recording of this kind has: a folder such as `/` is not walked through.
const MOST_FILES: usize = 100_000;

impl Folder for Directory {
    fn names(&self) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        let mut open = vec![(self.0.clone(), String::new(), 0)];
        while let Some((folder, prefix, depth)) = open.pop() {
            for entry in std::fs::read_dir(&folder)? {
                let entry = entry?;
                let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
                // What a link leads to, where it leads to something.
                let kind = match std::fs::metadata(entry.path()) {
                    Ok(there) => there.file_type(),
                    Err(_) => entry.file_type()?,
                };
                if kind.is_dir() && depth < 4 {
                    open.push((entry.path(), format!("{name}/"), depth + 1));
                } else if !kind.is_dir() {
                    names.push(name);
                }
                if names.len() + open.len() > MOST_FILES {
                    return Err(io::Error::other(
                        "the folder holds too many files for a recording",
                    ));
                }
            }
        }
        names.sort();
        Ok(names)
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn ReadSeek>> {
        let path = self.0.join(name);
        crate::outputs::reads(&path).map_err(|error| io::Error::other(error.to_string()))?;
        Ok(Box::new(BufReader::new(File::open(path)?)))
    }
}
