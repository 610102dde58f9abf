//! Opening sensor models: a file or `catalog:NAME`, with a folder of the user's own.

use std::path::{Path, PathBuf};

use sagnac::Error;
use sagnac::model::catalogue::{PREFIX, Replaced};
use sagnac::model::{Catalogue, Model};

use crate::context::Context;
use crate::inputs;

/// Where the user's own sensors are.
#[derive(clap::Args, Clone, Default)]
pub(crate) struct CatalogOption {
    /// A folder of model files that join the catalogue
    #[arg(long, value_name = "DIR")]
    pub(crate) catalog: Option<PathBuf>,
}

impl CatalogOption {
    /// The embedded catalogue and the files of the folder; a name that stands twice is told.
    pub(crate) fn open(&self, context: &Context) -> Result<Catalogue, Error> {
        let mut catalogue = Catalogue::embedded();
        let Some(folder) = &self.catalog else {
            return Ok(catalogue);
        };
        let unreadable = |error: std::io::Error| {
            Error::data(format!(
                "{} cannot be read: {}",
                folder.display(),
                crate::context::plain(&error)
            ))
            .advise("name a folder of model files (*.toml)")
        };
        let mut paths: Vec<PathBuf> = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(unreadable)? {
            let path = entry.map_err(unreadable)?.path();
            if path
                .extension()
                .is_some_and(|extension| extension == "toml")
            {
                paths.push(path);
            }
        }
        paths.sort();
        for path in paths {
            let text = inputs::text(&path)?;
            let file = path.display().to_string();
            match catalogue.add(text.as_bytes(), &file)? {
                Some(Replaced::Own { name, label }) => context.warn(&format!(
                    "{label} and {file} are both called `{name}`: {file} counts, the other is left out"
                )),
                Some(Replaced::Embedded { name }) => context.note(&format!(
                    "{file} takes the place of {name} of the catalogue"
                )),
                None => {}
            }
        }
        Ok(catalogue)
    }
}

/// A model by its argument: `catalog:NAME`, a file, or `-` for standard input.
pub(crate) fn load(argument: &str) -> Result<Model, Error> {
    let catalogue = Catalogue::embedded();
    if argument.starts_with(PREFIX) {
        return Ok(catalogue.find(argument)?);
    }
    let path = Path::new(argument);
    if !path.exists() && argument != "-" && catalogue.find(argument).is_ok() {
        return Err(Error::data(format!("there is no file {argument}"))
            .advise(format!("the sensor of the catalogue is {PREFIX}{argument}")));
    }
    let label = if argument == "-" {
        "standard input".to_owned()
    } else {
        argument.to_owned()
    };
    Ok(Model::parse(&inputs::text(path)?, &label)?)
}
