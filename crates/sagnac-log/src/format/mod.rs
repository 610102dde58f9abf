//! Formats are recognized by their first bytes, never by a name alone.

mod arrays;
mod arrow;
mod bag;
mod chunked;
mod dataflash;
mod db3;
mod hdf5;
mod mat;
mod mcap;
mod mimu;
mod npz;
mod oxts;
#[cfg(feature = "parquet")]
mod parquet;
mod part;
mod ros;
mod scan;
mod table;
mod ulog;

use chunked::Chunked;

use crate::input::{Input, InputBytes};
use crate::map::raw::RawReader;
use crate::npy::Npy;
use crate::text::TextTable;
use crate::{Error, Folder, ReadOptions, Source, SourceBytes};

/// The raw reader of whatever the source holds.
pub(crate) fn open(source: Source, options: &ReadOptions) -> Result<Box<dyn RawReader>, Error> {
    if let SourceBytes::Folder(folder) = source.bytes {
        if let Some(name) = recording(&*folder, &source.label)? {
            let file = folder
                .open(&name)
                .map_err(|e| Error::read(e).at(name.clone()))?;
            let label = format!("{}/{name}", source.label.trim_end_matches('/'));
            return open(Source::file(label, file), options);
        }
        if options.topic.is_some() {
            return Err(Error::usage("this format has no topics")
                .at("--topic")
                .advise("leave --topic out"));
        }
        return Ok(Box::new(oxts::Oxts::open(folder)?));
    }
    let input = Input::open(source, options.is_live)?;
    let packed = input.packed;
    let raw: Box<dyn RawReader> = if input.head.starts_with(b"\x93NUMPY") {
        Box::new(Npy::open(input.bytes, packed)?)
    } else if input.head.starts_with(bag::MAGIC) {
        Box::new(Chunked::<bag::Bag>::open(input.bytes, packed, options)?)
    } else if input.head.starts_with(mcap::MAGIC) {
        Box::new(Chunked::<mcap::Mcap>::open(input.bytes, packed, options)?)
    } else if input.head.starts_with(ulog::MAGIC) {
        Box::new(ulog::Ulog::open(input.bytes, packed, options)?)
    } else if input.head.starts_with(dataflash::MAGIC) {
        Box::new(dataflash::Dataflash::open(input.bytes, packed, options)?)
    } else if input.head.starts_with(db3::MAGIC) {
        Box::new(db3::Db3::open(input.bytes, packed, options)?)
    } else if input.head.starts_with(npz::MAGIC) {
        Box::new(npz::open(input.bytes, packed)?)
    } else if input.head.starts_with(b"PAR1") {
        parquet_file(input.bytes, packed)?
    } else if input.head.starts_with(arrow::MAGIC) || arrow::is_stream(&input.head) {
        Box::new(arrow::Arrow::open(input.bytes, &input.head, packed)?)
    } else if input.head.starts_with(arrow::FEATHER_1) {
        return Err(Error::data("Feather version 1 is not read")
            .advise("write the file again as version 2, which is Arrow's own"));
    } else if let Some(at) = hdf5::recognize(&input.head) {
        Box::new(hdf5::open(input.bytes, &input.head, at, packed)?)
    } else if mat::recognize(&input.head) {
        Box::new(mat::open(input.bytes, &input.head, packed)?)
    } else if mimu::recognize(&input.head) {
        Box::new(mimu::Mimu::open(input.bytes, packed, options)?)
    } else {
        Box::new(TextTable::open(
            input.bytes.into_stream(),
            options.threads,
            options.is_live,
            packed,
        )?)
    };
    if options.topic.is_some() && raw.raw().topics.is_empty() {
        return Err(Error::usage("this format has no topics")
            .at("--topic")
            .advise("leave --topic out"));
    }
    Ok(raw)
}

/// The one file of messages in the folder of a ROS 2 recording; `None` for other folders.
fn recording(folder: &dyn Folder, label: &str) -> Result<Option<String>, Error> {
    let names = folder.names().map_err(Error::read)?;
    let is_storage = |name: &&String| {
        [".db3", ".mcap", ".db3.zstd", ".mcap.zstd"]
            .iter()
            .any(|end| name.ends_with(end))
    };
    let files: Vec<&String> = names.iter().filter(is_storage).collect();
    let has_metadata = names.iter().any(|name| name == "metadata.yaml");
    match files.as_slice() {
        [one] => Ok(Some((*one).clone())),
        [] if has_metadata => Err(Error::data(
            "the folder of a ROS 2 recording holds no .db3 or .mcap file",
        )
        .advise("look for the file that its metadata.yaml names")),
        [] => Ok(None),
        [first, ..] => {
            let list: Vec<&str> = files.iter().take(20).map(|name| name.as_str()).collect();
            let more = if files.len() > 20 { ", …" } else { "" };
            Err(Error::data(format!(
                "the folder holds {} recordings: {}{more}",
                files.len(),
                list.join(", ")
            ))
            .advise(format!(
                "name one of them, for instance {}/{first}",
                label.trim_end_matches('/')
            )))
        }
    }
}

#[cfg(feature = "parquet")]
fn parquet_file(bytes: InputBytes, packed: &str) -> Result<Box<dyn RawReader>, Error> {
    Ok(Box::new(parquet::Parquet::open(bytes, packed)?))
}

#[cfg(not(feature = "parquet"))]
fn parquet_file(_: InputBytes, _: &str) -> Result<Box<dyn RawReader>, Error> {
    Err(Error::data("this build does not read Parquet files")
        .advise("build with the feature `parquet`"))
}
