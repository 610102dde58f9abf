//! What is to be said of another tool's file beside its numbers: keys that its tool needs, and what is not read here.

use super::flat::Flat;
use crate::export::Format;
use std::collections::BTreeSet;

/// The remarks on a file, a sentence each.
pub(super) fn of(format: Format, flat: &Flat) -> Vec<String> {
    let mut notes = Vec::new();
    let top = match format {
        Format::Kalibr => Some(""),
        Format::KalibrResult => Some("imu0."),
        _ => None,
    };
    if let Some(top) = top {
        let mut lacks = Vec::new();
        for key in [
            "rostopic",
            "update_rate",
            "accelerometer_noise_density",
            "accelerometer_random_walk",
            "gyroscope_noise_density",
            "gyroscope_random_walk",
        ] {
            if !flat.has(&format!("{top}{key}")) {
                lacks.push(key);
            }
        }
        if !lacks.is_empty() {
            notes.push(format!(
                "Kalibr stops at this file: it needs {}",
                lacks.join(", ")
            ));
        }
    }
    if matches!(format, Format::KalibrResult | Format::OpenVins) {
        let others = first_parts(flat, |part| {
            let number = part.strip_prefix("imu")?;
            number.parse::<u32>().ok().filter(|number| *number > 0)?;
            Some(part.to_string())
        });
        say_unread(&mut notes, &others, "imu0");
    }
    if matches!(format, Format::Px4 | Format::ArduPilot) {
        let others = first_parts(flat, |key| {
            let starts = [
                "CAL_ACC", "CAL_GYRO", "TC_A", "TC_G", "INS_TCAL", "INS_ACC", "INS_GYR",
            ];
            let (start, rest) = starts
                .iter()
                .find_map(|start| Some((start, key.strip_prefix(start)?)))?;
            let number: u32 = rest.get(..1)?.parse().ok()?;
            let first = u32::from(format == Format::ArduPilot);
            (number > first).then(|| format!("{start}{number}…"))
        });
        say_unread(&mut notes, &others, "the first IMU");
    }
    if format == Format::Kimera && flat.has("imu_bias_init_sigma") {
        notes.push(
            "imu_bias_init_sigma was not read: one number for both sensors, in two units".into(),
        );
    }
    notes
}

/// What a function makes of the first part of each key.
fn first_parts(flat: &Flat, of: impl Fn(&str) -> Option<String>) -> BTreeSet<String> {
    flat.items
        .iter()
        .filter_map(|item| of(item.key.split('.').next().unwrap_or_default()))
        .collect()
}

fn say_unread(notes: &mut Vec<String>, names: &BTreeSet<String>, read: &str) {
    if !names.is_empty() {
        let names: Vec<String> = names
            .iter()
            .take(8)
            .map(|name| crate::units::clip(name))
            .collect();
        notes.push(format!("only {read} was read, not {}", names.join(", ")));
    }
}
