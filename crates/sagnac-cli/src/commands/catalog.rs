//! `sagnac catalog`: real sensors with sources.

use std::path::PathBuf;

use clap::Subcommand;
use sagnac::Error;
use sagnac::catalog::{self, ListRequest};

use sagnac::budget::Figure;
use sagnac::grade::cost_page;
use sagnac::model::units::Dimension;

use crate::commands::characterize::command_line;
use crate::commands::drift::put_svg;
use crate::context::Context;
use crate::models::CatalogOption;
use crate::outputs::{Output, publish_all};
use crate::quantities::positive;

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
    Search(Box<Search>),
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
    /// Write the page: cost against performance, with the evidence of every price class
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
    /// Draw cost against performance
    #[arg(short, long, value_name = "F.svg|F.png")]
    output: Option<PathBuf>,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
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

/// Which sensors meet a drift requirement?
#[derive(clap::Args)]
#[command(
    after_help = "Example\n  sagnac catalog search --drift '1 km after 10 min' --trajectory drive"
)]
struct Search {
    /// CEP and time: '1 km after 10 min'
    #[arg(long, value_name = "LENGTH after TIME")]
    drift: String,
    #[command(flatten)]
    common: crate::commands::budget::Common,
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
            let report = list.report.as_deref();
            let report = report.map(|p| Output::claim_page(p, list.force));
            let picture = list.output.as_deref();
            let picture = picture.map(|p| Output::claim_picture(p, list.force));
            let (report, picture) = (report.transpose()?, picture.transpose()?);
            let catalogue = list.catalog.open(context)?;
            let outcome = catalog::list(&catalogue, &request)?;
            context.show(|| outcome.document(), || outcome.to_json())?;
            let mut outputs = Vec::new();
            if report.is_some() || picture.is_some() {
                let names: Vec<String> =
                    outcome.models.iter().map(|m| m.name().to_owned()).collect();
                let page = cost_page(
                    &catalogue,
                    Some(&names),
                    &command_line(),
                    env!("CARGO_PKG_VERSION"),
                )?;
                if let (Some(mut out), Some(chart)) = (picture, page.charts.first()) {
                    put_svg(&mut out, &chart.draw(860.0, "wide"))?;
                    outputs.push(out);
                }
                if let Some(mut out) = report {
                    out.put(page.html().as_bytes())?;
                    outputs.push(out);
                }
            }
            context.wrote(&publish_all(outputs)?)
        }
        Action::Search(search) => {
            let (limit, time) = search.drift.split_once(" after ").ok_or_else(|| {
                Error::usage(format!("\"{}\" is no drift requirement", search.drift))
                    .at("--drift")
                    .advise("write for instance --drift '1 km after 10 min'")
            })?;
            let limit_m = positive("--drift", limit.trim(), Dimension::LENGTH)?;
            let after_s = positive("--drift", time.trim(), Dimension::TIME)?;
            let outcome = search
                .common
                .ask(None, Figure::Cep, limit_m, after_s, false, context)?;
            for warning in outcome.warnings() {
                context.warn(&warning);
            }
            context.show(|| outcome.document(), || outcome.to_json())
        }
        Action::Show(show) => {
            let outcome = catalog::show(&show.catalog.open(context)?, &show.name)?;
            context.show(|| outcome.document(), || outcome.to_json())
        }
        Action::Compare(compare) => {
            let outcome = catalog::compare(&compare.catalog.open(context)?, &compare.names)?;
            context.show(|| outcome.document(), || outcome.to_json())
        }
    }
}

fn option_error(option: &str, error: sagnac::model::Error) -> Error {
    let mut error = Error::from(error);
    error.kind = sagnac::Kind::Usage;
    error.at(option)
}
