//! NaveGo's struct `imu` in the vendor's units, as a MAT file: arw deg/√h, gb_sta deg/s, ab_sta mg, …

use super::{Exported, Source};
use crate::error::Error;
use crate::units::Unit;
use sagnac_core::Sensor;

pub(super) fn write(source: &Source) -> Result<Exported, Error> {
    let factor = |unit: &str| Unit::parse(unit).map_or(1.0, |unit| unit.factor());
    let mut fields: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut remarks = vec![source.head()];
    for (sensor, keys, white_unit, walk_unit, bias_unit) in [
        (
            Sensor::Gyro,
            ["arw", "arrw", "gb_sta", "gb_dyn", "gb_corr"],
            "deg/sqrt(h)",
            "deg/sqrt(h)/s",
            "deg/s",
        ),
        (
            Sensor::Accel,
            ["vrw", "vrrw", "ab_sta", "ab_dyn", "ab_corr"],
            "m/s/sqrt(h)",
            "m/s/sqrt(h)/s",
            "mg",
        ),
    ] {
        let (sigma, times_s) = source.correlated_bias(sensor);
        let numbers = [
            (source.white(sensor)?, white_unit),
            (source.walk(sensor), walk_unit),
            (source.run_to_run(sensor).0, bias_unit),
            (sigma, bias_unit),
        ];
        for (key, (number, unit)) in keys.iter().zip(numbers) {
            let scale = factor(unit);
            fields.push((key, number.axes.map(|value| value / scale).to_vec()));
            remarks.push(format!("{key} [{unit}]: {}", number.comment));
        }
        fields.push((keys[4], times_s.to_vec()));
    }
    fields.push(("freq", vec![source.rate_hz()?]));
    remarks.push("freq [Hz]: the sample rate of the model".into());
    Ok(Exported {
        bytes: super::mat5::write("imu", &fields),
        remarks,
    })
}
