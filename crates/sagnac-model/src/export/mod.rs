//! Models for other tools: each format with the keys, units and conventions of that tool's own code, a comment per number.
//!
//! The rules of which number becomes which are the same for all and stand in `source`; a file an exporter.

mod ardupilot;
mod basalt;
mod gazebo;
mod gnss_ins_sim;
mod gtsam;
mod imu_utils;
mod kalibr;
mod kalibr_result;
mod kf_gins;
mod kimera;
mod mat5;
mod matlab;
pub(crate) mod matrix;
mod navego;
mod openvins;
mod orbslam3;
mod px4;
mod pyins;
mod ros_imu;
mod source;
mod text;
mod vins;

pub(crate) use ardupilot::shifted;
pub(crate) use mat5::read as read_mat;
pub use ros_imu::ros_covariances;
pub use source::{Number, Source};
pub(crate) use text::number as yaml_number;

use crate::error::Error;
use crate::model::Model;
use crate::suggest::suggest;

/// A downstream format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    /// Kalibr's imu.yaml.
    Kalibr,
    /// Kalibr's result file with the sensor's matrices.
    KalibrResult,
    /// OpenVINS kalibr_imu_chain.yaml.
    OpenVins,
    /// VINS-Mono and VINS-Fusion.
    Vins,
    /// ORB-SLAM3.
    OrbSlam3,
    /// A Python file that makes GTSAM's preintegration parameters.
    Gtsam,
    /// Kimera-VIO ImuParams.yaml.
    Kimera,
    /// basalt calibration.json.
    Basalt,
    /// Covariances of ROS sensor_msgs/Imu.
    RosImu,
    /// A Gazebo SDF sensor.
    Gazebo,
    /// MATLAB's imuSensor.
    Matlab,
    /// PX4 parameters.
    Px4,
    /// ArduPilot parameters.
    ArduPilot,
    /// imu_utils result, continuous units.
    ImuUtils,
    /// gnss-ins-sim's error dictionary.
    GnssInsSim,
    /// NaveGo's struct in a MAT file.
    NaveGo,
    /// pyins models.
    Pyins,
    /// KF-GINS yaml.
    KfGins,
}

impl Format {
    /// In the order in which formats are recognized.
    pub const ALL: [Self; 18] = [
        Self::Kalibr,
        Self::KalibrResult,
        Self::OpenVins,
        Self::Vins,
        Self::OrbSlam3,
        Self::Gtsam,
        Self::Kimera,
        Self::Basalt,
        Self::RosImu,
        Self::Gazebo,
        Self::Matlab,
        Self::Px4,
        Self::ArduPilot,
        Self::ImuUtils,
        Self::GnssInsSim,
        Self::NaveGo,
        Self::Pyins,
        Self::KfGins,
    ];

    /// The name in commands.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kalibr => "kalibr",
            Self::KalibrResult => "kalibr-result",
            Self::OpenVins => "openvins",
            Self::Vins => "vins",
            Self::OrbSlam3 => "orbslam3",
            Self::Gtsam => "gtsam",
            Self::Kimera => "kimera",
            Self::Basalt => "basalt",
            Self::RosImu => "ros-imu",
            Self::Gazebo => "gazebo",
            Self::Matlab => "matlab",
            Self::Px4 => "px4",
            Self::ArduPilot => "ardupilot",
            Self::ImuUtils => "imu-utils",
            Self::GnssInsSim => "gnss-ins-sim",
            Self::NaveGo => "navego",
            Self::Pyins => "pyins",
            Self::KfGins => "kf-gins",
        }
    }

    /// What users call it.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Kalibr => "Kalibr IMU file",
            Self::KalibrResult => "Kalibr result file",
            Self::OpenVins => "OpenVINS IMU file",
            Self::Vins => "VINS configuration",
            Self::OrbSlam3 => "ORB-SLAM3 settings",
            Self::Gtsam => "GTSAM parameters",
            Self::Kimera => "Kimera IMU file",
            Self::Basalt => "basalt calibration",
            Self::RosImu => "ROS Imu covariances",
            Self::Gazebo => "Gazebo sensor",
            Self::Matlab => "MATLAB imuSensor",
            Self::Px4 => "PX4 parameters",
            Self::ArduPilot => "ArduPilot parameters",
            Self::ImuUtils => "imu_utils result",
            Self::GnssInsSim => "gnss-ins-sim dictionary",
            Self::NaveGo => "NaveGo struct",
            Self::Pyins => "pyins models",
            Self::KfGins => "KF-GINS configuration",
        }
    }

    /// Whether a file of it is text.
    pub const fn is_text(self) -> bool {
        !matches!(self, Self::NaveGo)
    }
}

impl std::str::FromStr for Format {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        if let Some(format) = Self::ALL.into_iter().find(|format| format.name() == text) {
            return Ok(format);
        }
        let names = Self::ALL.map(Self::name);
        let advice = suggest(text, names).map_or_else(
            || format!("the formats are {}", names.join(", ")),
            |name| format!("did you mean `{name}`?"),
        );
        Err(Error::Usage {
            what: format!("there is no format `{}`", crate::units::clip(text)),
            advice: Some(advice),
        })
    }
}

/// What was exported.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The file.
    pub bytes: Vec<u8>,
    /// What a file without comments cannot say: a line a number.
    pub remarks: Vec<String>,
}

/// Writes a model for another tool; N, K and the bias sigma are multiplied by `inflate`, which every comment says.
///
/// # Errors
/// A number that the format needs and the model lacks, by name; an inflation that is not a positive number.
pub fn export(model: &Model, format: Format, inflate: f64) -> Result<Exported, Error> {
    if !(inflate.is_finite() && inflate > 0.0) {
        return Err(Error::Usage {
            what: "the inflation must be a number above zero".into(),
            advice: Some("write for instance --inflate 5".into()),
        });
    }
    let source = Source::new(model, format, inflate)?;
    let plain = |text: String| Exported {
        bytes: text.into_bytes(),
        remarks: Vec::new(),
    };
    Ok(match format {
        Format::Kalibr => plain(kalibr::write(&source)?),
        Format::KalibrResult => plain(kalibr_result::write(&source)?),
        Format::OpenVins => plain(openvins::write(&source)?),
        Format::Vins => plain(vins::write(&source)?),
        Format::OrbSlam3 => plain(orbslam3::write(&source)?),
        Format::Gtsam => plain(gtsam::write(&source)?),
        Format::Kimera => plain(kimera::write(&source)?),
        Format::Basalt => basalt::write(&source)?,
        Format::RosImu => plain(ros_imu::write(&source)?),
        Format::Gazebo => plain(gazebo::write(&source)?),
        Format::Matlab => plain(matlab::write(&source)?),
        Format::Px4 => px4::write(&source),
        Format::ArduPilot => ardupilot::write(&source),
        Format::ImuUtils => plain(imu_utils::write(&source)?),
        Format::GnssInsSim => plain(gnss_ins_sim::write(&source)?),
        Format::NaveGo => navego::write(&source)?,
        Format::Pyins => plain(pyins::write(&source)?),
        Format::KfGins => plain(kf_gins::write(&source)?),
    })
}
