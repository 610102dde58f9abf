//! What the tests of `calibrate` share: place, texts of the certificate, outputs, hash of what was read.

use std::path::{Path, PathBuf};

use sagnac::Error;
use sagnac::model::units::Dimension;
use sha2::{Digest as _, Sha256};

use crate::inputs::hexadecimal;
use crate::outputs::Output;
use crate::quantities::optional;

/// Where the test was done.
#[derive(clap::Args)]
pub(super) struct Place {
    /// Latitude of the laboratory, for gravity and the Earth's rate
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true)]
    latitude: Option<String>,
    /// Height of the laboratory, for gravity
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    height: Option<String>,
    /// Local gravity; wins over latitude and height [default: 9.80665 m/s^2]
    #[arg(long, value_name = "ACCELERATION")]
    gravity: Option<String>,
}

impl Place {
    /// \[rad\]
    pub(super) fn latitude_rad(&self) -> Result<Option<f64>, Error> {
        optional("--latitude", self.latitude.as_deref(), Dimension::ANGLE)
    }

    /// \[m\]
    pub(super) fn height_m(&self) -> Result<Option<f64>, Error> {
        optional("--height", self.height.as_deref(), Dimension::LENGTH)
    }

    /// \[m/s²\]
    pub(super) fn gravity_m_s2(&self) -> Result<Option<f64>, Error> {
        optional(
            "--gravity",
            self.gravity.as_deref(),
            Dimension::ACCELERATION,
        )
    }
}

/// Texts of the certificate page.
#[derive(clap::Args)]
pub(super) struct Texts {
    /// Item, for the certificate
    #[arg(long, value_name = "TEXT", default_value = "")]
    item: String,
    /// Customer, for the certificate
    #[arg(long, value_name = "TEXT", default_value = "")]
    customer: String,
    /// Number of the certificate
    #[arg(long, value_name = "TEXT", default_value = "")]
    certificate: String,
}

impl Texts {
    /// As the library takes them.
    pub(super) fn to_texts(&self) -> sagnac::calibrate::CertificateTexts {
        sagnac::calibrate::CertificateTexts {
            item: self.item.clone(),
            customer: self.customer.clone(),
            certificate: self.certificate.clone(),
        }
    }
}

/// Files to write.
#[derive(clap::Args)]
pub(super) struct Files {
    /// Write the model
    #[arg(short, long, value_name = "MODEL.toml")]
    pub(super) output: Option<PathBuf>,
    /// Write the report
    #[arg(long, value_name = "F.html")]
    pub(super) report: Option<PathBuf>,
    /// Overwrite outputs that exist
    #[arg(long)]
    pub(super) force: bool,
}

impl Files {
    /// Claims the model and the report before any work is done.
    pub(super) fn claim(&self) -> Result<(Option<Output>, Option<Output>), Error> {
        let model = self.output.as_deref();
        let model = model.map(|p| Output::claim_model(p, "-o", self.force, "--report F.html"));
        let page = self.report.as_deref();
        let page = page.map(|p| Output::claim_page(p, self.force));
        Ok((model.transpose()?, page.transpose()?))
    }

    /// The name of the model: that of its file, else that of what was read.
    pub(super) fn model_name(&self, read: &Path) -> String {
        self.output
            .as_deref()
            .or(Some(read))
            .and_then(Path::file_stem)
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned())
    }
}

/// `NAME sha256:…`, the `source` of a `[[calibration]]` block.
pub(super) fn source(path: &Path, hash: &str) -> String {
    let name = path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    );
    format!("{name} sha256:{hash}")
}

/// SHA-256 of bytes in hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

impl Place {
    /// As the library takes it.
    pub(super) fn to_place(&self) -> Result<sagnac::calibrate::Place, Error> {
        Ok(sagnac::calibrate::Place {
            latitude_rad: self.latitude_rad()?,
            height_m: self.height_m()?,
            gravity_m_s2: self.gravity_m_s2()?,
        })
    }
}

/// SHA-256 of a file, read in pieces; none of a pipe or a folder.
pub(super) fn hash_of(path: &Path) -> Result<Option<String>, Error> {
    if !path.is_file() {
        return Ok(None);
    }
    let cannot = |error| crate::outputs::cannot(path, &error);
    let mut file = std::fs::File::open(path).map_err(cannot)?;
    let mut hash = Sha256::new();
    std::io::copy(&mut file, &mut hash).map_err(cannot)?;
    Ok(Some(hexadecimal(&hash.finalize())))
}
