//! `sagnac catalog`: real sensors with sources.

use clap::Subcommand;
use sagnac::Error;
use sagnac::catalog::{self, ListRequest};

use crate::context::Context;
use crate::models::CatalogOption;

/// Real sensors, every number with its source
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac catalog list --where 'gyro.noise.angle_random_walk < 0.1 deg/sqrt(h)'"
)]
pub(crate) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    List(List),
    Show(Show),
    Compare(Compare),
}

/// Which sensors meet a condition?
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac catalog list --where 'technology = FOG and gyro.bias.stability < 5 deg/h'"
)]
struct List {
    /// A condition: PATH < QUANTITY, or name, manufacturer, technology, quality, price_class = ~ TEXT
    #[arg(long = "where", value_name = "CONDITION")]
    filter: Option<String>,
    /// The parameter to sort by, ascending [default: the name]
    #[arg(long, value_name = "PATH")]
    sort: Option<String>,
    #[command(flatten)]
    catalog: CatalogOption,
}

/// What is known of one sensor?
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac catalog show ADIS16470")]
struct Show {
    /// The sensor's name, in any spelling
    #[arg(value_name = "NAME")]
    name: String,
    #[command(flatten)]
    catalog: CatalogOption,
}

/// Sensors side by side
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac catalog compare STIM300 LN-200 HG9900")]
struct Compare {
    /// The sensors' names
    #[arg(value_name = "NAME", required = true, num_args = 1..)]
    names: Vec<String>,
    #[command(flatten)]
    catalog: CatalogOption,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    match &args.action {
        Action::List(list) => {
            let texts = [list.filter.as_deref(), list.sort.as_deref()];
            let about = |sensor: &str| {
                texts
                    .into_iter()
                    .flatten()
                    .any(|text| text.contains(sensor))
            };
            let request = ListRequest {
                filter: list
                    .filter
                    .as_deref()
                    .map(str::parse)
                    .transpose()
                    .map_err(|error| option_error("--where", error))?,
                sort: list
                    .sort
                    .as_deref()
                    .map(str::parse)
                    .transpose()
                    .map_err(|error| option_error("--sort", error))?,
                accelerometers: about("accel.") && !about("gyro."),
            };
            let outcome = catalog::list(&list.catalog.open()?, &request)?;
            context.show(|| outcome.document(), || outcome.to_json())
        }
        Action::Show(show) => {
            let outcome = catalog::show(&show.catalog.open()?, &show.name)?;
            context.show(|| outcome.document(), || outcome.to_json())
        }
        Action::Compare(compare) => {
            let outcome = catalog::compare(&compare.catalog.open()?, &compare.names)?;
            context.show(|| outcome.document(), || outcome.to_json())
        }
    }
}

fn option_error(option: &str, error: sagnac::model::Error) -> Error {
    let mut error = Error::from(error);
    error.kind = sagnac::Kind::Usage;
    error.at(option)
}
