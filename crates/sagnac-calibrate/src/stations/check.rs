//! Stations that cannot be as they say: labels against outputs, g taken as m/s², one input only.

use sagnac_core::Sensor;

use super::{Asked, Error, Options, Station, terms::AXES};

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Refuses what no regression can use.
pub(super) fn check(stations: &[Station], options: &Options) -> Result<(), Error> {
    if stations
        .iter()
        .all(|s| s.accel.is_none() && s.gyro.is_none())
    {
        return Err(Error::NoOutputs);
    }
    for station in stations {
        for sensor in Sensor::ALL {
            if let Some(se) = station.output_se(sensor)
                && se.iter().any(|s| s.is_nan() || *s <= 0.0)
            {
                return Err(Error::BadError {
                    station: station.label.clone(),
                    place: station.place.clone(),
                });
            }
        }
        units(station, options)?;
        labels(station, options)?;
    }
    one_input(stations, options)
}

fn units(station: &Station, options: &Options) -> Result<(), Error> {
    let g = options.gravity_m_s2;
    if let Some(accel) = station.accel
        && (norm(station.f) - g).abs() < 0.1 * g
        && norm(station.w) < 0.1
    {
        let size = norm(accel);
        if (0.5..1.5).contains(&size) {
            return Err(Error::LooksLikeG {
                station: station.label.clone(),
                size,
                place: station.place.clone(),
            });
        }
    }
    Ok(())
}

fn labels(station: &Station, options: &Options) -> Result<(), Error> {
    let g = options.gravity_m_s2;
    let wrong = |what: String| Error::Contradiction {
        what: format!(
            "station {} {what}: wrong label, or a mirrored axis",
            station.label
        ),
        place: station.place.clone(),
    };
    if let Some(accel) = station.accel {
        for k in 0..3 {
            let f = station.f[k];
            let sign = if f < 0.0 { '-' } else { '+' };
            if f.abs() > g / 2.0 && accel[k] * f.signum() < -g / 4.0 {
                return Err(wrong(format!(
                    "says {sign}{} up but accel_{} reads {:.1} m/s^2",
                    AXES[k], AXES[k], accel[k]
                )));
            }
            let largest = (0..3)
                .max_by(|a, b| accel[*a].abs().total_cmp(&accel[*b].abs()))
                .unwrap_or(k);
            if f.abs() > 0.9 * norm(station.f) && norm(station.f) > 1e-6 && largest != k {
                return Err(wrong(format!(
                    "says {sign}{} up but accel_{} reads the most, {:.1} m/s^2",
                    AXES[k], AXES[largest], accel[largest]
                )));
            }
        }
    }
    if let Some(gyro) = station.gyro {
        for k in 0..3 {
            let w = station.w[k];
            if w.abs() > 0.1 && gyro[k] * w.signum() < -w.abs() / 4.0 {
                return Err(wrong(format!(
                    "turns at {w:.2} rad/s about {} but gyro_{} reads {:.2} rad/s",
                    AXES[k], AXES[k], gyro[k]
                )));
            }
        }
    }
    Ok(())
}

fn one_input(stations: &[Station], options: &Options) -> Result<(), Error> {
    if options.asked == Asked::Only(vec!["bias"]) {
        return Ok(());
    }
    let Some(first) = stations.first() else {
        return Err(Error::NoOutputs);
    };
    let same = |a: [f64; 3], b: [f64; 3], near: f64| (0..3).all(|i| (a[i] - b[i]).abs() <= near);
    let still = stations.iter().all(|s| {
        same(s.f, first.f, 1e-6)
            && same(s.w, first.w, 1e-9)
            && same(s.wdot, first.wdot, 1e-9)
            && (s.temperature_c.unwrap_or(0.0) - first.temperature_c.unwrap_or(0.0)).abs() < 5.0
    });
    if !still {
        return Ok(());
    }
    let k = (0..3)
        .max_by(|a, b| first.f[*a].abs().total_cmp(&first.f[*b].abs()))
        .unwrap_or(2);
    let sign = if first.f[k] < 0.0 { '-' } else { '+' };
    Err(Error::OneInput {
        what: format!(
            "a one-face table cannot give the scale factor: {} stations, all with {sign}{} up",
            stations.len(),
            AXES[k]
        ),
    })
}
