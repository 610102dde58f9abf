//! Which keys of each format are which quantities, in which convention.

use super::convention::{Quantity, Reading, Rule, factor};
use super::flat::Flat;
use crate::export::Format;
use Quantity::{AllanMinimum, BiasSigma, Coefficient, FixedBias, RunToRun, Walk, White};
use sagnac_core::Sensor::{self, Accel, Gyro};

struct Reader<'a> {
    flat: &'a Flat,
    found: Vec<Reading>,
}

impl Reader<'_> {
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
        let Some(place) = self
            .flat
            .items
            .iter()
            .position(|item| item.key == key && !item.numbers.is_empty())
        else {
            return;
        };
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
            .flat
            .items
            .iter()
            .position(|item| item.key.ends_with(key) && item.numbers.len() > part)
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

const SI: Rule = Rule::Times(1.0);
const DENSITY: &str = "continuous-time density, two-sided N";
const WALK: &str = "continuous-time random walk K";

/// The numbers of a file.
pub(super) fn of(format: Format, flat: &Flat) -> Vec<Reading> {
    let mut reader = Reader {
        flat,
        found: Vec::new(),
    };
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
            // In the shape that is exported: np.eye(3) * sigma ** 2.
            let sigma = "covariance N^2 I, written as sigma ** 2";
            reader.add_part("setGyroscopeCovariance", 1, None, Gyro, White, SI, sigma);
            reader.add_part(
                "setAccelerometerCovariance",
                1,
                None,
                Accel,
                White,
                SI,
                sigma,
            );
            let sigma = "covariance K^2 I, written as sigma ** 2";
            reader.add_part("setBiasOmegaCovariance", 1, None, Gyro, Walk, SI, sigma);
            reader.add_part("setBiasAccCovariance", 1, None, Accel, Walk, SI, sigma);
            reader.add_part(
                "setBiasAccOmegaInit",
                3,
                None,
                Gyro,
                RunToRun,
                SI,
                "covariance of the bias, written as sigma ** 2",
            );
            reader.add_part(
                "setBiasAccOmegaInit",
                0,
                None,
                Accel,
                RunToRun,
                SI,
                "covariance of the bias, written as sigma ** 2",
            );
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
                reader.add(
                    &format!("{name}.NoiseDensity"),
                    sensor,
                    White,
                    SI,
                    "density, double-sided unless NoiseType says otherwise",
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
        Format::Px4 | Format::ArduPilot => {}
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
    reader.found
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

/// `_w` is an Allan minimum unless it is below a hundredth of `_n`.
fn imu_utils(reader: &mut Reader) {
    for (sensor, top, letters) in [(Gyro, "Gyr", "gyr"), (Accel, "Acc", "acc")] {
        {
            let block = "avg-axis";
            let [n, w] = ["n", "w"].map(|kind| format!("{top}.{block}.{letters}_{kind}"));
            reader.add(
                &n,
                sensor,
                White,
                SI,
                "N, or sqrt(f) N of the last version of the original",
            );
            let walk = reader
                .flat
                .one(&w)
                .zip(reader.flat.one(&n))
                .is_some_and(|(w, n)| w < n / 100.0);
            if walk {
                reader.add(&w, sensor, Walk, SI, WALK);
            } else {
                reader.add(
                    &w,
                    sensor,
                    AllanMinimum,
                    SI,
                    "the minimum of the Allan deviation",
                );
            }
        }
    }
}
