//! Which keys of each format are which quantities, in which convention.

use super::convention::{Quantity, Reading, Rule, factor};
use super::flat::{Flat, Item, Problem};
use crate::export::Format;
use crate::units::clip;
use Quantity::{AllanMinimum, BiasSigma, Coefficient, FixedBias, RunToRun, Walk, White};
use sagnac_core::Sensor::{self, Accel, Gyro};

struct Reader<'a> {
    flat: &'a Flat,
    found: Vec<Reading>,
    problems: Vec<Problem>,
    /// Whether the tool reads one number where another takes three.
    scalars: bool,
    /// Whether the numbers came out of expressions.
    computed: bool,
}

impl Reader<'_> {
    /// The place of a key that ends so, once sure that it holds plain numbers and stands once.
    fn place(&mut self, fits: impl Fn(&Item) -> bool) -> Option<usize> {
        let mut places = (0..self.flat.items.len()).filter(|place| fits(&self.flat.items[*place]));
        let place = places.next()?;
        let item = &self.flat.items[place];
        if let Some(again) = places.next() {
            self.problems.push(twice(&self.flat.items[again]));
            return None;
        }
        // Values of a MAT file have no text; those of GTSAM were read as expressions.
        let computed = self.computed || item.raw.is_empty() && !item.numbers.is_empty();
        if !computed && (item.numbers.is_empty() || !item.is_plain()) {
            self.problems.push(not_plain(item));
            return None;
        }
        Some(place)
    }

    /// Looks at a key without a reading of its own.
    fn check(&mut self, key: &str) {
        self.place(|item| item.key == key);
    }

    /// One number, or three where the tool takes three.
    fn has_length(&mut self, place: usize) -> bool {
        let item = &self.flat.items[place];
        let count = item.numbers.len();
        let right = count == 1 || count == 3 && !self.scalars;
        if !right {
            let wanted = if self.scalars { "one" } else { "one or three" };
            self.problems.push(Problem {
                start: item.start,
                what: format!(
                    "`{}` holds {count} numbers, the tool reads {wanted}",
                    clip(&item.key)
                ),
                advice: "write a number without a unit, as the tool reads it",
            });
        }
        right
    }

    /// Adds a key: one number for all axes, or three.
    fn add(
        &mut self,
        key: &str,
        sensor: Sensor,
        quantity: Quantity,
        rule: Rule,
        convention: &'static str,
    ) {
        self.add_timed(key, sensor, quantity, rule, convention, &[]);
    }

    fn add_timed(
        &mut self,
        key: &str,
        sensor: Sensor,
        quantity: Quantity,
        rule: Rule,
        convention: &'static str,
        times_s: &[f64],
    ) {
        let Some(place) = self.place(|item| item.key == key) else {
            return;
        };
        if !self.has_length(place) {
            return;
        }
        let item = &self.flat.items[place];
        let three = item.numbers.len() == 3;
        for (number, value) in item
            .numbers
            .iter()
            .enumerate()
            .take(if three { 3 } else { 1 })
        {
            self.found.push(Reading {
                key: if three {
                    format!("{key}.{}", ["x", "y", "z"][number])
                } else {
                    key.to_string()
                },
                sensor,
                axis: three.then_some(number),
                quantity,
                value: *value,
                rule,
                convention,
                time_s: times_s.get(number).or(times_s.first()).copied(),
                place: (place, number),
            });
        }
    }

    /// Adds the diagonal of a covariance matrix: one number where its parts are equal.
    fn add_covariance(
        &mut self,
        ends: &[&str],
        sensor: Sensor,
        quantity: Quantity,
        convention: &'static str,
        parts: &[usize; 3],
    ) {
        let Some(place) = self.place(|item| ends.iter().any(|end| item.key.ends_with(end))) else {
            return;
        };
        let item = &self.flat.items[place];
        let at = |part: usize| item.numbers.get(part).or(item.numbers.first()).copied();
        let values = parts.map(|part| at(part).unwrap_or(f64::NAN));
        let equal = values.iter().all(|value| *value == values[0]);
        for (axis, value) in values
            .into_iter()
            .enumerate()
            .take(if equal { 1 } else { 3 })
        {
            let letter = ["x", "y", "z"][axis];
            self.found.push(Reading {
                key: if equal {
                    item.key.clone()
                } else {
                    format!("{}.{letter}", item.key)
                },
                sensor,
                axis: (!equal).then_some(axis),
                quantity,
                value,
                rule: Rule::Variance,
                convention,
                time_s: None,
                place: (place, parts[axis].min(item.numbers.len().saturating_sub(1))),
            });
        }
    }

    /// Adds one number of a key that holds several, for an axis or all.
    #[allow(clippy::too_many_arguments, reason = "a row of the tool's own table")]
    fn add_part(
        &mut self,
        key: &str,
        part: usize,
        axis: Option<usize>,
        sensor: Sensor,
        quantity: Quantity,
        rule: Rule,
        convention: &'static str,
    ) {
        let Some(place) = self
            .place(|item| item.key.ends_with(key))
            .filter(|place| self.flat.items[*place].numbers.len() > part)
        else {
            return;
        };
        let item = &self.flat.items[place];
        let name = axis.map_or_else(String::new, |axis| format!(".{}", ["x", "y", "z"][axis]));
        self.found.push(Reading {
            key: format!("{}{name}", item.key),
            sensor,
            axis,
            quantity,
            value: item.numbers[part],
            rule,
            convention,
            time_s: None,
            place: (place, part),
        });
    }
}

fn twice(item: &Item) -> Problem {
    Problem {
        start: item.start,
        what: format!("`{}` stands twice", clip(&item.key)),
        advice: "leave the one that counts",
    }
}

fn not_plain(item: &Item) -> Problem {
    let raw = item.raw.split_whitespace().collect::<Vec<_>>().join(" ");
    Problem {
        start: item.start,
        what: if raw.is_empty() {
            format!("`{}` holds no number", clip(&item.key))
        } else {
            format!("`{}` is `{}`, no plain number", clip(&item.key), clip(&raw))
        },
        advice: "write a number without a unit, as the tool reads it",
    }
}

const SI: Rule = Rule::Times(1.0);
const DENSITY: &str = "continuous-time density, two-sided N";
const WALK: &str = "continuous-time random walk K";

/// The numbers of a file, and what of it cannot be read.
pub(super) fn of(format: Format, flat: &Flat) -> (Vec<Reading>, Vec<Problem>) {
    let mut reader = Reader {
        flat,
        found: Vec::new(),
        problems: flat.problems.clone(),
        computed: format == Format::Gtsam,
        scalars: matches!(
            format,
            Format::Kalibr
                | Format::KalibrResult
                | Format::OpenVins
                | Format::Kimera
                | Format::Vins
                | Format::OrbSlam3
        ),
    };
    for key in super::convention::rate_keys(format) {
        reader.check(key);
    }
    for key in super::import::matrix_keys(format) {
        reader.check(key);
    }
    match format {
        Format::Kalibr | Format::Kimera => kalibr(&mut reader, ""),
        Format::KalibrResult | Format::OpenVins => kalibr(&mut reader, "imu0."),
        Format::Vins => {
            for (sensor, name) in [(Gyro, "gyr"), (Accel, "acc")] {
                reader.add(
                    &format!("{name}_n"),
                    sensor,
                    White,
                    Rule::PerSample(2.0),
                    "sigma of a sample in a midpoint rule: N sqrt(2 f)",
                );
                reader.add(
                    &format!("{name}_w"),
                    sensor,
                    Walk,
                    Rule::PerSample(1.0),
                    "step sigma over dt: K sqrt(f)",
                );
            }
        }
        Format::OrbSlam3 => {
            for (sensor, name) in [(Gyro, "Gyro"), (Accel, "Acc")] {
                reader.add(&format!("IMU.Noise{name}"), sensor, White, SI, DENSITY);
                reader.add(&format!("IMU.{name}Walk"), sensor, Walk, SI, WALK);
            }
        }
        Format::Gtsam => {
            let diagonal = "diagonal of a continuous-time covariance";
            for (sensor, quantity, ends) in [
                (
                    Gyro,
                    White,
                    ["setGyroscopeCovariance", "gyroscopeCovariance"],
                ),
                (
                    Accel,
                    White,
                    ["setAccelerometerCovariance", "accelerometerCovariance"],
                ),
                (
                    Gyro,
                    Walk,
                    ["setBiasOmegaCovariance", "biasOmegaCovariance"],
                ),
                (Accel, Walk, ["setBiasAccCovariance", "biasAccCovariance"]),
            ] {
                reader.add_covariance(&ends, sensor, quantity, diagonal, &[0, 1, 2]);
            }
            let ends = ["setBiasAccOmegaInit", "biasAccOmegaInt", "biasAccOmegaInit"];
            let initial = "diagonal of the covariance of the initial bias";
            reader.add_covariance(&ends, Gyro, RunToRun, initial, &[3, 4, 5]);
            reader.add_covariance(&ends, Accel, RunToRun, initial, &[0, 1, 2]);
        }
        Format::Basalt => {
            for (sensor, name) in [(Gyro, "gyro"), (Accel, "accel")] {
                reader.add(&format!("{name}_noise_std"), sensor, White, SI, DENSITY);
                reader.add(&format!("{name}_bias_std"), sensor, Walk, SI, WALK);
            }
        }
        Format::RosImu => {
            for (sensor, key) in [
                (Gyro, "angular_velocity_covariance"),
                (Accel, "linear_acceleration_covariance"),
            ] {
                let nine = flat.get(key).is_none_or(|numbers| numbers.len() == 9);
                if let Some(place) = reader.place(|item| item.key == key).filter(|_| !nine) {
                    reader.problems.push(Problem {
                        start: flat.items[place].start,
                        what: format!("`{key}` does not hold 9 numbers"),
                        advice: "write the nine numbers of a 3 x 3 matrix, row by row",
                    });
                    continue;
                }
                for axis in 0..3 {
                    reader.add_part(
                        key,
                        4 * axis,
                        Some(axis),
                        sensor,
                        White,
                        Rule::SampleVariance,
                        "variance of a sample, N^2 f",
                    );
                }
            }
        }
        Format::Gazebo => gazebo(&mut reader),
        Format::Matlab => {
            for (sensor, name) in [(Gyro, "gyro"), (Accel, "accel")] {
                let single = flat.items.iter().any(|item| {
                    item.key == format!("{name}.NoiseType")
                        && item.raw.to_lowercase().contains("single")
                });
                let (rule, convention) = if single {
                    let rule = Rule::Times(std::f64::consts::FRAC_1_SQRT_2);
                    (rule, "single-sided density, N sqrt(2)")
                } else {
                    (
                        SI,
                        "double-sided density N, as NoiseType says or by default",
                    )
                };
                reader.add(
                    &format!("{name}.NoiseDensity"),
                    sensor,
                    White,
                    rule,
                    convention,
                );
                reader.add(&format!("{name}.RandomWalk"), sensor, Walk, SI, WALK);
                reader.add(
                    &format!("{name}.BiasInstability"),
                    sensor,
                    Coefficient,
                    SI,
                    "coefficient B",
                );
                reader.add(
                    &format!("{name}.ConstantBias"),
                    sensor,
                    FixedBias,
                    SI,
                    "constant bias",
                );
            }
        }
        Format::Px4 | Format::ArduPilot => {
            let starts = if format == Format::Px4 {
                &["CAL_ACC0_", "CAL_GYRO0_", "TC_A0_", "TC_G0_"][..]
            } else {
                &["INS_ACC", "INS_GYR", "INS_TCAL1_"]
            };
            let mut seen = std::collections::HashSet::new();
            for item in &flat.items {
                if !starts.iter().any(|start| item.key.starts_with(start)) {
                    continue;
                }
                if !seen.insert(item.key.as_str()) {
                    reader.problems.push(twice(item));
                } else if !item.is_plain() {
                    reader.problems.push(not_plain(item));
                }
            }
        }
        Format::ImuUtils => imu_utils(&mut reader),
        Format::GnssInsSim => {
            let times = |key: &str| flat.get(key).map(<[f64]>::to_vec).unwrap_or_default();
            reader.add(
                "gyro_arw",
                Gyro,
                White,
                Rule::Times(factor("deg/sqrt(h)")),
                "deg/sqrt(h)",
            );
            reader.add(
                "accel_vrw",
                Accel,
                White,
                Rule::Times(factor("m/s/sqrt(h)")),
                "m/s/sqrt(h)",
            );
            reader.add_timed(
                "gyro_b_stability",
                Gyro,
                BiasSigma,
                Rule::Times(factor("deg/h")),
                "deg/h, steady-state sigma",
                &times("gyro_b_corr"),
            );
            reader.add_timed(
                "accel_b_stability",
                Accel,
                BiasSigma,
                SI,
                "m/s^2, steady-state sigma",
                &times("accel_b_corr"),
            );
            reader.add(
                "gyro_b",
                Gyro,
                FixedBias,
                Rule::Times(factor("deg/h")),
                "deg/h",
            );
            reader.add("accel_b", Accel, FixedBias, SI, "m/s^2");
        }
        Format::NaveGo => {
            let times = |key: &str| flat.get(key).map(<[f64]>::to_vec).unwrap_or_default();
            reader.add(
                "arw",
                Gyro,
                White,
                Rule::Times(factor("deg/sqrt(h)")),
                "deg/sqrt(h)",
            );
            reader.add(
                "vrw",
                Accel,
                White,
                Rule::Times(factor("m/s/sqrt(h)")),
                "m/s/sqrt(h)",
            );
            reader.add(
                "arrw",
                Gyro,
                Walk,
                Rule::Times(factor("deg/sqrt(h)/s")),
                "deg/sqrt(h)/s",
            );
            reader.add(
                "vrrw",
                Accel,
                Walk,
                Rule::Times(factor("m/s/sqrt(h)/s")),
                "m/s/sqrt(h)/s",
            );
            reader.add(
                "gb_sta",
                Gyro,
                RunToRun,
                Rule::Times(factor("deg/s")),
                "deg/s",
            );
            reader.add("ab_sta", Accel, RunToRun, Rule::Times(factor("mg")), "mg");
            reader.add_timed(
                "gb_dyn",
                Gyro,
                BiasSigma,
                Rule::Times(factor("deg/s")),
                "deg/s",
                &times("gb_corr"),
            );
            reader.add_timed(
                "ab_dyn",
                Accel,
                BiasSigma,
                Rule::Times(factor("mg")),
                "mg",
                &times("ab_corr"),
            );
        }
        Format::Pyins => {
            for (sensor, name) in [(Gyro, "gyro"), (Accel, "accel")] {
                reader.add(&format!("{name}_model.noise"), sensor, White, SI, DENSITY);
                reader.add(&format!("{name}_model.bias_walk"), sensor, Walk, SI, WALK);
                reader.add(
                    &format!("{name}_model.bias_sd"),
                    sensor,
                    RunToRun,
                    SI,
                    "1 sigma of the bias",
                );
                reader.add(
                    &format!("{name}_parameters.bias"),
                    sensor,
                    FixedBias,
                    SI,
                    "bias",
                );
            }
        }
        Format::KfGins => {
            let times: Vec<f64> = flat
                .one("imunoise.corrtime")
                .map(|hours| 3600.0 * hours)
                .into_iter()
                .collect();
            reader.add(
                "imunoise.arw",
                Gyro,
                White,
                Rule::Times(factor("deg/sqrt(h)")),
                "deg/sqrt(h)",
            );
            reader.add(
                "imunoise.vrw",
                Accel,
                White,
                Rule::Times(factor("m/s/sqrt(h)")),
                "m/s/sqrt(h)",
            );
            reader.add_timed(
                "imunoise.gbstd",
                Gyro,
                BiasSigma,
                Rule::Times(factor("deg/h")),
                "deg/h, sigma of the in-run bias",
                &times,
            );
            reader.add_timed(
                "imunoise.abstd",
                Accel,
                BiasSigma,
                Rule::Times(factor("mGal")),
                "mGal, sigma of the in-run bias",
                &times,
            );
            reader.add(
                "initgyrbias",
                Gyro,
                FixedBias,
                Rule::Times(factor("deg/h")),
                "deg/h",
            );
            reader.add(
                "initaccbias",
                Accel,
                FixedBias,
                Rule::Times(factor("mGal")),
                "mGal",
            );
        }
    }
    (reader.found, reader.problems)
}

fn kalibr(reader: &mut Reader, prefix: &str) {
    for (sensor, name) in [(Gyro, "gyroscope"), (Accel, "accelerometer")] {
        reader.add(
            &format!("{prefix}{name}_noise_density"),
            sensor,
            White,
            SI,
            DENSITY,
        );
        reader.add(
            &format!("{prefix}{name}_random_walk"),
            sensor,
            Walk,
            SI,
            WALK,
        );
    }
}

fn gazebo(reader: &mut Reader) {
    let ending = |end: &str| {
        reader
            .flat
            .items
            .iter()
            .find(|item| item.key.ends_with(end))
            .map(|item| item.numbers[0])
    };
    #[allow(clippy::type_complexity, reason = "a table of rows, read once")]
    let mut wanted: Vec<(
        String,
        usize,
        Sensor,
        Quantity,
        Rule,
        &'static str,
        Option<f64>,
    )> = Vec::new();
    for (sensor, name) in [(Gyro, "angular_velocity"), (Accel, "linear_acceleration")] {
        for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
            let at = |key: &str| format!("{name}.{letter}.noise.{key}");
            wanted.push((
                at("stddev"),
                axis,
                sensor,
                White,
                Rule::PerSample(1.0),
                "sigma of a sample, N sqrt(f)",
                None,
            ));
            wanted.push((
                at("bias_mean"),
                axis,
                sensor,
                FixedBias,
                SI,
                "mean bias, its sign is drawn",
                None,
            ));
            wanted.push((
                at("bias_stddev"),
                axis,
                sensor,
                RunToRun,
                SI,
                "turn-on bias, 1 sigma",
                None,
            ));
            if let Some(time_s) = ending(&at("dynamic_bias_correlation_time")) {
                wanted.push((
                    at("dynamic_bias_stddev"),
                    axis,
                    sensor,
                    BiasSigma,
                    Rule::Drive(time_s),
                    "drive sigma_b sqrt(2/T_c)",
                    Some(time_s),
                ));
            }
        }
    }
    for (end, axis, sensor, quantity, rule, convention, time_s) in wanted {
        let before = reader.found.len();
        reader.add_part(&end, 0, Some(axis), sensor, quantity, rule, convention);
        if let Some(added) = reader.found.get_mut(before) {
            added.time_s = time_s;
            added.key.clone_from(&end);
        }
    }
}

/// Whether an imu_utils file says that its numbers are N and K: by the unit of its block.
pub(super) fn says_continuous(flat: &Flat) -> bool {
    flat.items.iter().any(|item| {
        matches!(item.key.as_str(), "Gyr.unit" | "Acc.unit") && item.raw.contains("sqrt(Hz)")
    })
}

/// `_w` is an Allan minimum unless the file says otherwise, or it is below a hundredth of `_n`.
fn imu_utils(reader: &mut Reader) {
    let stated = says_continuous(reader.flat);
    for (sensor, top, letters) in [(Gyro, "Gyr", "gyr"), (Accel, "Acc", "acc")] {
        let key = |block: &str, kind: &str| format!("{top}.{block}.{letters}_{kind}");
        let small = reader
            .flat
            .one(&key("avg-axis", "w"))
            .zip(reader.flat.one(&key("avg-axis", "n")))
            .is_some_and(|(w, n)| w < n / 100.0);
        for (axis, block) in [
            (None, "avg-axis"),
            (Some(0), "x-axis"),
            (Some(1), "y-axis"),
            (Some(2), "z-axis"),
        ] {
            let before = reader.found.len();
            let n = if stated {
                "N, as the unit says"
            } else {
                "N, or sqrt(f) N of the last version of the original"
            };
            reader.add(&key(block, "n"), sensor, White, SI, n);
            if stated || small {
                reader.add(&key(block, "w"), sensor, Walk, SI, WALK);
            } else {
                let minimum = "the minimum of the Allan deviation";
                reader.add(&key(block, "w"), sensor, AllanMinimum, SI, minimum);
            }
            for reading in &mut reader.found[before..] {
                reading.axis = axis;
            }
        }
    }
}
