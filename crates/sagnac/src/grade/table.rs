//! The tables of grades: the lecture's, Groves's and El-Sheimy and Youssef's ([GROVES13], [ELSHEIMY20]).

use super::NMI_M;

/// What a row allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// At most this.
    AtMost(f64),
    /// Strictly less.
    Below(f64),
    /// Anything: the cell is blank.
    Blank,
}

impl Limit {
    /// Whether a value is within it. Values that came through text are allowed the last bit.
    pub fn is_met(self, value: f64) -> bool {
        match self {
            Self::AtMost(limit) => value <= limit * (1.0 + 1e-12),
            Self::Below(limit) => value < limit * (1.0 - 1e-12),
            Self::Blank => true,
        }
    }

    /// The number, if it limits.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::AtMost(v) | Self::Below(v) => Some(v),
            Self::Blank => None,
        }
    }
}

/// A row, best first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Name as scripts know it.
    pub name: &'static str,
    /// Largest bias of gyro (rad/s) and accelerometer (m/s²).
    pub bias: [Limit; 2],
    /// Hours, and largest CEP after them, m; `None`: no position figure.
    pub position: Option<(f64, Limit)>,
}

/// A table of grades.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum GradeTable {
    /// Strategic, navigation, tactical, AHRS, control system.
    #[default]
    Lecture,
    /// Marine, aviation, intermediate, tactical, consumer.
    Groves,
    /// Strategic, navigation, tactical, commercial.
    ElSheimy,
}

const DEG_H: f64 = std::f64::consts::PI / 180.0 / 3600.0;
const UG: f64 = 9.806_65e-6;

impl GradeTable {
    /// All.
    pub const ALL: [Self; 3] = [Self::Lecture, Self::Groves, Self::ElSheimy];

    /// The word of `--table`.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Lecture => "lecture",
            Self::Groves => "groves",
            Self::ElSheimy => "el-sheimy",
        }
    }

    /// By its word.
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.key() == text)
    }

    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::Lecture => "the lecture's table",
            Self::Groves => "Groves's table",
            Self::ElSheimy => "El-Sheimy and Youssef's table",
        }
    }

    /// Its rows, best first.
    pub fn rows(self) -> Vec<Row> {
        use Limit::{AtMost, Below, Blank};
        let row = |name, gyro: Limit, accel: Limit, position| {
            let scale = |l: Limit, k: f64| match l {
                AtMost(v) => AtMost(v * k),
                Below(v) => Below(v * k),
                Blank => Blank,
            };
            Row {
                name,
                bias: [scale(gyro, DEG_H), scale(accel, UG)],
                position,
            }
        };
        let nmi = |n: f64| AtMost(n * NMI_M);
        match self {
            Self::Lecture => vec![
                row(
                    "strategic",
                    Below(0.005),
                    Below(30.0),
                    Some((24.0, nmi(1.0))),
                ),
                row(
                    "navigation",
                    AtMost(0.01),
                    AtMost(50.0),
                    Some((1.0, nmi(1.0))),
                ),
                row(
                    "tactical",
                    AtMost(1.0),
                    AtMost(1000.0),
                    Some((1.0, nmi(100.0))),
                ),
                row("ahrs", AtMost(10.0), AtMost(1000.0), None),
                row("control_system", AtMost(1000.0), AtMost(10_000.0), None),
            ],
            Self::Groves => vec![
                row("marine", AtMost(0.001), AtMost(10.0), None),
                row("aviation", AtMost(0.01), AtMost(100.0), None),
                row("intermediate", AtMost(0.1), AtMost(1000.0), None),
                row("tactical", AtMost(100.0), AtMost(10_000.0), None),
                row("consumer", Blank, Blank, None),
            ],
            Self::ElSheimy => vec![
                row(
                    "strategic",
                    AtMost(0.001),
                    AtMost(1.0),
                    Some((1.0, AtMost(100.0))),
                ),
                row(
                    "navigation",
                    Below(0.01),
                    Below(100.0),
                    Some((1.0, nmi(1.0))),
                ),
                row(
                    "tactical",
                    AtMost(10.0),
                    AtMost(5000.0),
                    Some((1.0, nmi(20.0))),
                ),
                row("commercial", AtMost(360.0), Blank, Some((1.0, Blank))),
            ],
        }
    }
}
