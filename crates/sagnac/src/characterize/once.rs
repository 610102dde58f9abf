//! A log counts once: the same samples twice would make every interval too narrow by √2.

use super::NamedLog;
use crate::Error;
use sagnac_log::Log;

/// Refuses a log that is given twice: its intervals would be too narrow.
///
/// # Errors
/// Two logs that hold the same samples, by whatever name.
pub(crate) fn once(logs: &[NamedLog]) -> Result<(), Error> {
    let same = |a: &Log, b: &Log| {
        let equal = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits())
        };
        a.columns.len() == b.columns.len()
            && a.columns.iter().zip(&b.columns).all(|(a, b)| equal(a, b))
    };
    for (i, log) in logs.iter().enumerate() {
        if let Some(other) = logs[..i].iter().find(|other| same(&log.log, &other.log)) {
            let what = if log.name == other.name {
                format!("{} is given twice: it would count twice", log.name)
            } else {
                format!(
                    "{} and {} hold the same samples: they would count twice",
                    other.name, log.name
                )
            };
            return Err(Error::data(what)
                .at(log.name.clone())
                .advise("name each log once"));
        }
    }
    Ok(())
}
