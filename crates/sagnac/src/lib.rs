//! Inertial sensors understood: simulate, characterize, calibrate, correct, grade, drift.
//!
//! One plain `Request -> Outcome` function per task, in a module of the task's name. An outcome
//! knows its text ([`terminal`](sagnac_report::text)) and its JSON. Nothing here touches files by name,
//! the clock, the environment or a terminal, and nothing picks a seed: that is the caller's.

pub mod allan;
pub mod audit;
pub mod budget;
pub mod calibrate;
pub mod catalog;
pub mod characterize;
mod clock;
pub mod compare;
pub mod convert;
pub mod correct;
pub mod demo;
pub mod drift;
mod error;
pub mod explain;
pub mod export;
pub mod findings;
pub mod follow;
mod from_crates;
pub mod grade;
pub mod import;
pub mod info;
mod issues;
pub mod motion;
mod noise_terms;
pub mod path;
pub mod plan;
pub mod response;
pub mod simulate;
pub mod strapdown;
pub mod table;

pub use error::{Error, Kind};

pub use sagnac_analysis as analysis;
pub use sagnac_calibrate as calibration;
pub use sagnac_core as core;
pub use sagnac_log as log;
pub use sagnac_model as model;
pub use sagnac_nav as nav;
pub use sagnac_noise as noise;
pub use sagnac_report as report;

/// The examples of the README are run as tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
