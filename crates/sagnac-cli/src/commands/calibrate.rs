//! `sagnac calibrate`: deterministic errors; one file per test under `calibrate/`.

mod common;
mod merge;
mod multi_position;
mod plan;
mod stations;
mod thermal;

pub(crate) use common::sha256;

use clap::Subcommand;
use sagnac::Error;

use crate::context::Context;

/// Bias, scale factor, misalignment and every other deterministic error, with covariance
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac calibrate stations faces.csv -o imu.toml")]
pub(crate) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    Stations(Box<stations::Args>),
    Plan(Box<plan::Args>),
    Merge(merge::Args),
    MultiPosition(Box<multi_position::Args>),
    Thermal(Box<thermal::Args>),
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    match &args.action {
        Action::Stations(args) => stations::run(args, context),
        Action::Plan(args) => plan::run(args, context),
        Action::Merge(args) => merge::run(args, context),
        Action::MultiPosition(args) => multi_position::run(args, context),
        Action::Thermal(args) => thermal::run(args, context),
    }
}
