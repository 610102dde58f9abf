//! Files that appear whole or not at all.
//!
//! A command claims every output before it works (what exists is refused without `--force`), writes to
//! temporary files beside them, and names them all at the end.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use sagnac::Error;
use tempfile::NamedTempFile;

use crate::context::plain;

/// Temporary files to remove when the program is interrupted.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes temporary files on Ctrl-C, then ends with the shell's code for it.
pub(crate) fn remove_unfinished_when_interrupted() {
    // Without the handler an interrupt leaves a hidden temporary file; the program works all the same.
    let _ = ctrlc::set_handler(|| {
        if INTERRUPT_ENDS_INPUT.load(std::sync::atomic::Ordering::SeqCst) {
            INTERRUPTED.store(true, std::sync::atomic::Ordering::SeqCst);
            return;
        }
        if let Ok(paths) = UNFINISHED.lock() {
            for path in paths.iter() {
                let _ = fs::remove_file(path);
            }
        }
        std::process::exit(130);
    });
}

/// Set by a command (`characterize --follow`) for which an interrupt means: that was the end of the input.
pub(crate) static INTERRUPT_ENDS_INPUT: std::sync::atomic::AtomicBool =
    std::sync::atomic::AtomicBool::new(false);
/// Whether such an interrupt came.
pub(crate) static INTERRUPTED: std::sync::atomic::AtomicBool =
    std::sync::atomic::AtomicBool::new(false);

/// Files that this command has claimed, by folder and name.
static CLAIMED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Notes a file as claimed; two outputs of one name would lose the first.
fn once(folder: &Path, path: &Path) -> Result<(), String> {
    let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    let file = folder.join(path.file_name().unwrap_or_default());
    let mut claimed = CLAIMED.lock().unwrap_or_else(PoisonError::into_inner);
    if claimed.insert(file) {
        Ok(())
    } else {
        Err(format!("{} is the name of another output", path.display()))
    }
}

/// Files that this command has read, and claimed ones that exist already, by their true paths: a
/// run must not replace what it reads, whichever of the two comes first.
static READ: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
static REPLACED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The path without links, of a regular file that exists: a device can be read and written.
fn true_path(path: &Path) -> Option<PathBuf> {
    fs::canonicalize(path).ok().filter(|path| path.is_file())
}

fn same_file(path: &Path) -> Error {
    Error::usage(format!("{} is an input of this run", path.display()))
        .advise("write to a file of another name: an input is never replaced")
}

/// Notes that `path` is read.
///
/// # Errors
/// It is an output of this run.
pub(crate) fn reads(path: &Path) -> Result<(), Error> {
    let Some(file) = true_path(path) else {
        return Ok(());
    };
    let replaced = REPLACED.lock().unwrap_or_else(PoisonError::into_inner);
    if replaced.contains(&file) {
        return Err(same_file(path));
    }
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    read.insert(file);
    Ok(())
}

/// Notes that `path` will be replaced, where it exists.
fn replaces(path: &Path) -> Result<(), Error> {
    let Some(file) = true_path(path) else {
        return Ok(());
    };
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    if read.contains(&file) {
        return Err(same_file(path));
    }
    drop(read);
    let mut replaced = REPLACED.lock().unwrap_or_else(PoisonError::into_inner);
    replaced.insert(file);
    Ok(())
}

/// The ending of a name where it has one, in small letters, that is none of `known`; what is no file may have any name, and a
/// number after a dot is a part of the name.
fn wrong_ending(path: &Path, known: &[&str]) -> Option<String> {
    let ending = path.extension()?.to_string_lossy().to_ascii_lowercase();
    let is_file = fs::metadata(path).map_or(true, |m| m.is_file());
    let is_ending = ending.chars().any(|c| c.is_ascii_alphabetic());
    (is_file && is_ending && !known.contains(&ending.as_str())).then_some(ending)
}

/// One claimed output.
pub(crate) struct Output {
    path: PathBuf,
    target: Target,
}

enum Target {
    /// A new or replaced regular file, still under its temporary name.
    Temporary(BufWriter<NamedTempFile>),
    /// A device, pipe or terminal that cannot be replaced.
    Direct(BufWriter<File>),
}

impl Target {
    fn writer(&mut self) -> &mut dyn Write {
        match self {
            Self::Temporary(writer) => writer,
            Self::Direct(writer) => writer,
        }
    }
}

impl Output {
    /// An error of a stream into this file, with the name that was asked for instead of the temporary one.
    fn named(&self, error: &io::Error) -> io::Error {
        io::Error::new(
            error.kind(),
            format!("{}: {}", self.path.display(), plain(error)),
        )
    }

    /// Claims `path`; `option` is named where it is refused.
    pub(crate) fn claim(path: &Path, option: &str, force: bool) -> Result<Self, Error> {
        let name = path.display();
        let refuse = |what: String| Error::usage(what).at(option.to_owned());
        let metadata = fs::metadata(path).ok();
        if metadata.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(refuse(format!("{name} is a folder")).advise(format!(
                "name a file in it, for instance {}",
                path.join("out").display()
            )));
        }
        if metadata.as_ref().is_some_and(|m| !m.is_file()) {
            let file = File::options()
                .write(true)
                .open(path)
                .map_err(|e| cannot(path, &e))?;
            return Ok(Self {
                path: path.to_owned(),
                target: Target::Direct(BufWriter::with_capacity(1 << 20, file)),
            });
        }
        replaces(path).map_err(|error| error.at(option.to_owned()))?;
        if metadata.is_some() && !force {
            return Err(
                refuse(format!("{name} exists")).advise("choose another name or add --force")
            );
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(refuse(format!("the folder of {name} does not exist"))
                .advise(format!("make it: mkdir -p {}", folder.display())));
        }
        once(folder, path).map_err(|what| refuse(what).advise("give each output its own name"))?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(".sagnac-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder).map_err(|e| cannot(path, &e))?;
        if let Ok(mut paths) = UNFINISHED.lock() {
            paths.push(file.path().to_owned());
        }
        Ok(Self {
            path: path.to_owned(),
            target: Target::Temporary(BufWriter::with_capacity(1 << 20, file)),
        })
    }

    /// Claims a model, whose name ends in .toml or has no ending; `pictures` says what writes one instead.
    pub(crate) fn claim_model(
        path: &Path,
        option: &str,
        force: bool,
        pictures: &str,
    ) -> Result<Self, Error> {
        if let Some(ending) = wrong_ending(path, &["toml"]) {
            let model = path.with_extension("toml");
            let advice = match ending.as_str() {
                "svg" | "png" if !pictures.is_empty() => format!(
                    "name the model {}; for a picture: {pictures}",
                    model.display()
                ),
                _ => format!("name it {}", model.display()),
            };
            let what = format!("a model cannot be written as {}", path.display());
            return Err(Error::usage(what).at(option.to_owned()).advise(advice));
        }
        Self::claim(path, option, force)
    }

    /// Claims the page of `--report`, whose name ends in .html or has no ending.
    pub(crate) fn claim_page(path: &Path, force: bool) -> Result<Self, Error> {
        if let Some(ending) = wrong_ending(path, &["html", "htm"]) {
            let page = path.with_extension("html");
            let advice = match ending.as_str() {
                "svg" | "png" => format!("name it {}: it has every plot", page.display()),
                _ => format!("name it {}", page.display()),
            };
            let what = format!("a page cannot be written as {}", path.display());
            return Err(Error::usage(what).at("--report").advise(advice));
        }
        Self::claim(path, "--report", force)
    }

    /// Claims a drawing, whose name must say how it is drawn: F.svg or F.png.
    pub(crate) fn claim_picture(path: &Path, force: bool) -> Result<Self, Error> {
        let extension = path.extension().and_then(|e| e.to_str());
        let known = |e: &str| ["svg", "png"].iter().any(|k| e.eq_ignore_ascii_case(k));
        if !extension.is_some_and(known) {
            return Err(
                Error::usage(format!("a picture cannot be written as {}", path.display()))
                    .at("-o")
                    .advise("name it F.svg or F.png"),
            );
        }
        Self::claim(path, "-o", force)
    }

    /// The name as it will be printed.
    pub(crate) fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// The path that was claimed.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes all of `bytes` through to the disk's file: where it is full, nothing has been shown yet.
    pub(crate) fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let target = self.target.writer();
        target
            .write_all(bytes)
            .and_then(|()| target.flush())
            .map_err(|e| cannot(&self.path, &e))
    }

    /// Gives the file its name. Call for all outputs only when all are complete.
    pub(crate) fn publish(self) -> Result<String, Error> {
        let Self { path, target } = self;
        match target {
            Target::Temporary(writer) => {
                let file = writer.into_inner().map_err(|e| cannot(&path, e.error()))?;
                let temporary = file.path().to_owned();
                file.persist(&path).map_err(|e| cannot(&path, &e.error))?;
                if let Ok(mut paths) = UNFINISHED.lock() {
                    paths.retain(|other| *other != temporary);
                }
            }
            Target::Direct(mut writer) => writer.flush().map_err(|e| cannot(&path, &e))?,
        }
        Ok(path.display().to_string())
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = self.target.writer().write(bytes);
        result.map_err(|e| self.named(&e))
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = self.target.writer().flush();
        result.map_err(|e| self.named(&e))
    }
}

impl Seek for Output {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        // What is buffered is written before: this fails on a full disk as well.
        let result = match &mut self.target {
            Target::Temporary(writer) => writer.seek(to),
            Target::Direct(writer) => writer.seek(to),
        };
        result.map_err(|e| self.named(&e))
    }
}

/// A folder that goes away again, with those made above it, unless it is kept.
pub(crate) struct NewFolder(Vec<PathBuf>);

impl NewFolder {
    /// Makes `path` and what is missing above it.
    pub(crate) fn make(path: &Path) -> Result<Self, Error> {
        let missing = path
            .ancestors()
            .take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        let made = Self(missing.map(Path::to_owned).collect());
        fs::create_dir_all(path).map_err(|e| cannot(path, &e))?;
        Ok(made)
    }

    /// Keeps it.
    pub(crate) fn keep(mut self) {
        self.0.clear();
    }
}

impl Drop for NewFolder {
    fn drop(&mut self) {
        for folder in &self.0 {
            // One that holds something by now stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// `40.3 MB`.
pub(crate) fn size(bytes: f64) -> String {
    match bytes {
        b if b < 1e3 => format!("{b} B"),
        b if b < 1e6 => format!("{:.1} kB", b / 1e3),
        b if b < 1e9 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.2} GB", b / 1e9),
    }
}

/// Refuses an output of at least `bytes` where the disk has less room.
pub(crate) fn refuse_without_room(path: &Path, bytes: f64) -> Result<(), Error> {
    #[cfg(unix)]
    {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let is_file = fs::metadata(path).map_or(true, |m| m.is_file());
        if let Some(disk) = rustix::fs::statvfs(folder).ok().filter(|_| is_file) {
            let free = disk.f_bavail as f64 * disk.f_frsize as f64;
            if bytes > free {
                return Err(Error::data(format!(
                    "{} needs at least {}, and the disk has {} free",
                    path.display(),
                    size(bytes),
                    size(free)
                ))
                .advise("shorten the run, lower --rate or choose another disk"));
            }
        }
    }
    #[cfg(not(unix))]
    let _ = (path, bytes);
    Ok(())
}

/// Names all outputs at once, after flushing every one, so that a full disk leaves none behind.
pub(crate) fn publish_all(outputs: Vec<Output>) -> Result<Vec<String>, Error> {
    let mut outputs = outputs;
    for output in &mut outputs {
        output
            .target
            .writer()
            .flush()
            .map_err(|e| cannot(&output.path, &e))?;
    }
    outputs.into_iter().map(Output::publish).collect()
}

/// The error of a file that cannot be written.
pub(crate) fn cannot(path: &Path, error: &io::Error) -> Error {
    Error::data(format!(
        "{} cannot be written: {}",
        path.display(),
        plain(error)
    ))
    .advise("nothing was written; choose another place or free some room")
}
