//! The sensor catalogue: real sensors as model files, every number with its source, parsed only when asked for.
//!
//! Names ignore case and take every run of other characters than letters and digits as one `-`: `catalog:openrtk330-300za`.

mod embedded;
mod filter;
mod price;

pub use filter::{Filter, SortKey};
pub use price::{PriceClass, price_class};

use crate::error::Error;
use crate::model::Model;
use crate::suggest::suggest;
use sagnac_core::Sensor;

/// The embedded sensors, and those of a folder of the user's own.
///
/// ```
/// use sagnac_model::Catalogue;
/// let catalogue = Catalogue::embedded();
/// let model = catalogue.find("adis16470")?;
/// assert_eq!(model.manufacturer(), Some("Analog Devices"));
/// let error = catalogue.find("adis16740").unwrap_err();
/// assert_eq!(error.advice().as_deref(), Some("did you mean catalog:ADIS16470?"));
/// # Ok::<(), sagnac_model::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Catalogue {
    own: Vec<(String, Model)>,
}

/// A sensor whose place a file of the user's own took.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Replaced {
    /// Another file of the user's own.
    Own {
        /// The name of both.
        name: String,
        /// Where the first came from.
        label: String,
    },
    /// A sensor of the embedded catalogue.
    Embedded {
        /// Its name as printed.
        name: String,
    },
}

/// What comes before a name: `catalog:ADIS16470`.
pub const PREFIX: &str = "catalog:";

impl Catalogue {
    /// The embedded sensors.
    pub fn embedded() -> Self {
        Self::default()
    }

    /// Adds a model file of the user's own; it takes the place of a sensor of the same name, which is told.
    ///
    /// # Errors
    /// A file that is no model.
    pub fn add(&mut self, text: &[u8], label: &str) -> Result<Option<Replaced>, Error> {
        let model = Model::from_bytes(text, label)?;
        let key = key_of(model.name());
        let own = self.own.iter().position(|(name, _)| *name == key);
        let replaced = match own {
            Some(place) => Some(Replaced::Own {
                name: model.name().to_string(),
                label: self.own.remove(place).1.label().to_string(),
            }),
            None => embedded::FILES
                .iter()
                .find(|(name, _)| key_of(name) == key)
                .map(|(name, _)| Replaced::Embedded {
                    name: (*name).to_string(),
                }),
        };
        self.own.push((key, model));
        Ok(replaced)
    }

    /// All names as printed, in alphabetical order.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self
            .own
            .iter()
            .map(|(_, model)| model.name().to_string())
            .collect();
        names.extend(
            embedded::FILES
                .iter()
                .filter(|(name, _)| !self.is_own(name))
                .map(|(name, _)| (*name).to_string()),
        );
        names.sort_by_key(|name| key_of(name));
        names
    }

    fn is_own(&self, name: &str) -> bool {
        let key = key_of(name);
        self.own.iter().any(|(own, _)| *own == key)
    }

    /// One sensor by its name, with or without `catalog:`.
    ///
    /// # Errors
    /// No such name; the advice suggests the nearest.
    pub fn find(&self, name: &str) -> Result<Model, Error> {
        let bare = name.strip_prefix(PREFIX).unwrap_or(name);
        let key = key_of(bare);
        if let Some((_, model)) = self.own.iter().find(|(own, _)| *own == key) {
            return Ok(model.clone());
        }
        if let Some((name, text)) = embedded::FILES.iter().find(|(name, _)| key_of(name) == key) {
            return Model::parse(text, &format!("{PREFIX}{name}"));
        }
        let names = self.names();
        let keys: Vec<String> = names.iter().map(|name| key_of(name)).collect();
        // A beginning is a better guess than a slip of the pen.
        let begins = keys
            .iter()
            .position(|candidate| !key.is_empty() && candidate.starts_with(&key));
        let place = begins.or_else(|| {
            let nearest = suggest(&key, keys.iter().map(String::as_str))?.to_string();
            keys.iter().position(|candidate| *candidate == nearest)
        });
        Err(Error::UnknownSensor {
            name: crate::units::clip(bare),
            suggestion: place.map(|place| names[place].clone()),
        })
    }

    /// Every sensor, by name.
    ///
    /// # Errors
    /// None for the embedded ones, which a test reads.
    pub fn models(&self) -> Result<Vec<Model>, Error> {
        self.names().iter().map(|name| self.find(name)).collect()
    }

    /// The sensors that a filter keeps, sorted.
    pub fn select(
        &self,
        filter: Option<&Filter>,
        sort: Option<&SortKey>,
    ) -> Result<Vec<Model>, Error> {
        let mut models = self.models()?;
        if let Some(filter) = filter {
            models.retain(|model| filter.keeps(model));
        }
        if let Some(sort) = sort {
            sort.sort(&mut models);
        }
        Ok(models)
    }
}

/// The form of a name in which names are compared.
pub fn key_of(name: &str) -> String {
    let mut key = String::with_capacity(name.len());
    for c in name.chars() {
        if c.is_alphanumeric() {
            key.extend(c.to_lowercase());
        } else if !key.ends_with('-') {
            key.push('-');
        }
    }
    key.trim_matches('-').to_string()
}

/// The technology of a sensor: that of its gyroscopes, else of its accelerometers.
pub fn technology(model: &Model) -> Option<&str> {
    Sensor::ALL
        .into_iter()
        .find_map(|sensor| model.technology(sensor))
}

/// The quality letter: as stated, else the worst letter that the sources of its numbers begin with (`D:`, `M:`, `S:`).
pub fn quality(model: &Model) -> Option<String> {
    if let Some(quality) = model.catalog().and_then(|table| table.quality.clone()) {
        return Some(quality);
    }
    let letter = |source: &str| {
        ["D:", "M:", "S:"]
            .iter()
            .position(|letter| source.starts_with(letter))
    };
    let worst = model
        .parameters()
        .filter_map(|(_, entry)| letter(entry.source.as_deref()?))
        .max()?;
    Some(["D", "M", "S"][worst].to_string())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::{Catalogue, Replaced, key_of};
    use crate::model::Process;
    use sagnac_core::Sensor;

    #[test]
    fn every_embedded_file_reads_and_converts() {
        let models = Catalogue::embedded().models().unwrap();
        assert_eq!(models.len(), 73);
        let mut complete = 0;
        for model in &models {
            assert!(model.to_core().is_ok());
            for (path, entry) in model.parameters() {
                let off_diagonal = path.to_string().contains("g_sensitivity");
                assert!(
                    off_diagonal || entry.source.is_some(),
                    "{} {path}",
                    model.name()
                );
            }
            let noise = |sensor| (0..3).any(|axis| model.white_noise(sensor, axis).is_some());
            let bias = |sensor: Sensor| {
                (0..3).any(|axis| {
                    model.under(sensor, "bias.stability", axis).is_some()
                        || model.instability_floor(sensor, axis).is_some()
                })
            };
            assert_eq!(model.process(Sensor::Gyro), Process::Flicker);
            complete += usize::from(
                Sensor::ALL
                    .into_iter()
                    .all(|sensor| noise(sensor) && bias(sensor)),
            );
        }
        // Counted by hand from the table: 25 sensors have all four kinds that drift needs.
        assert_eq!(complete, 25);
    }

    #[test]
    fn names_are_found_however_spelled() {
        let catalogue = Catalogue::embedded();
        for name in [
            "OpenRTK330 / 300ZA",
            "openrtk330-300za",
            "catalog:OPENRTK330_300ZA",
        ] {
            assert_eq!(catalogue.find(name).unwrap().name(), "OpenRTK330 / 300ZA");
        }
        assert!(catalogue.find("").is_err());
        assert!(catalogue.find(&"x".repeat(100_000)).is_err());
        assert_eq!(key_of("  A -- b/C "), "a-b-c");
    }

    #[test]
    fn an_own_file_joins_and_wins() {
        let mut catalogue = Catalogue::embedded();
        let text = b"name = \"stim300\"\n[gyro]\nrange = \"1 deg/s\"";
        let replaced = catalogue.add(text, "mine.toml").unwrap();
        let name = "STIM300".to_string();
        assert_eq!(replaced, Some(Replaced::Embedded { name }));
        assert_eq!(catalogue.find("STIM300").unwrap().label(), "mine.toml");
        assert_eq!(catalogue.names().len(), 73);
        let replaced = catalogue.add(b"name = \"STIM 300\"", "b.toml").unwrap();
        assert_eq!(replaced, None, "another name: STIM-300");
        let replaced = catalogue.add(b"name = \"STIM300\"", "b.toml").unwrap();
        let label = "mine.toml".to_string();
        let name = "STIM300".to_string();
        assert_eq!(replaced, Some(Replaced::Own { name, label }));
    }
}
