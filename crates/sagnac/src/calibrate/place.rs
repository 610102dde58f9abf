//! Where a calibration was made: gravity given, from latitude and height, or standard.

use crate::Error;

/// Where the log was made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Latitude \[rad\].
    pub latitude_rad: Option<f64>,
    /// Height \[m\].
    pub height_m: Option<f64>,
    /// Gravity \[m/s²\]; wins over latitude and height.
    pub gravity_m_s2: Option<f64>,
}

impl Place {
    /// Whether nothing was said of it.
    pub(super) fn is_default(&self) -> bool {
        self.gravity_m_s2.is_none() && self.latitude_rad.is_none()
    }

    /// Gravity with where it is from.
    pub(super) fn words(&self, gravity_m_s2: f64) -> String {
        let from = match (self.gravity_m_s2, self.latitude_rad) {
            (Some(_), _) => "as given",
            (None, Some(_)) => "from latitude and height",
            (None, None) => "(standard gravity: no place was given)",
        };
        format!("{gravity_m_s2:.5} m/s^2 {from}")
    }
}

/// Gravity at a place.
pub(super) fn place_gravity(place: &Place) -> Result<f64, Error> {
    super::gravity(place.gravity_m_s2, place.latitude_rad, place.height_m)
}
