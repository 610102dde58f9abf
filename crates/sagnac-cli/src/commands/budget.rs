//! `sagnac budget`: which sensors and which parameter values meet a drift requirement.

use sagnac::Error;
use sagnac::budget::{BudgetOutcome, BudgetRequest, Figure, budget};
use sagnac::model::units::Dimension;

use crate::context::Context;
use crate::inputs;
use crate::models::CatalogOption;
use crate::motion::RunOptions;
use crate::quantities::positive;

/// Which sensors meet a drift requirement, and which parameter values would?
#[derive(clap::Args)]
#[command(
    override_usage = "sagnac budget [MODEL] (--cep D | --r95 D) --after TIME [OPTIONS]",
    after_help = "Example\n  sagnac budget --cep '1 km' --after 10min --trajectory drive"
)]
pub(crate) struct Args {
    /// A model whose parameters are asked for: a file, or catalog:NAME
    #[arg(value_name = "MODEL")]
    model: Option<String>,
    #[command(flatten)]
    limit: Limit,
    /// When
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    after: String,
    /// Check the first three by Monte Carlo
    #[arg(long)]
    confirm: bool,
    #[command(flatten)]
    common: Common,
}

/// Exactly one figure.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Limit {
    /// Half of all sensors are within this
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    cep: Option<String>,
    /// 95 % of all sensors are within this
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    r95: Option<String>,
}

/// What `budget` and `catalog search` share.
#[derive(clap::Args, Clone)]
pub(crate) struct Common {
    /// Sampling rate of all sensors [default: each model's, else 100 Hz]
    #[arg(long, value_name = "RATE")]
    rate: Option<String>,
    /// Seed of --confirm
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Runs of --confirm
    #[arg(long, value_name = "N", default_value_t = 200)]
    runs: u32,
    #[command(flatten)]
    run: RunOptions,
    #[command(flatten)]
    catalog: CatalogOption,
}

impl Common {
    /// Asks.
    pub(crate) fn ask(
        &self,
        model: Option<&str>,
        figure: Figure,
        limit_m: f64,
        after_s: f64,
        confirm: bool,
        context: &Context,
    ) -> Result<BudgetOutcome, Error> {
        let catalogue = self.catalog.open(context)?;
        let model = model.map(inputs::model).transpose()?;
        let trajectory = self.run.trajectory(context)?;
        budget(&BudgetRequest {
            model: model.as_ref(),
            rate_hz: self
                .rate
                .as_deref()
                .map(|text| positive("--rate", text, Dimension::FREQUENCY))
                .transpose()?,
            alignment: self.run.alignment()?,
            calibration: self.run.calibration(),
            vertical: self.run.vertical(),
            sculling: self.run.sculling(),
            temperature: self.run.temperature(after_s)?,
            confirm: confirm.then_some((self.runs, self.seed)),
            ..BudgetRequest::new(&catalogue, &trajectory, figure, limit_m, after_s)
        })
        .map_err(at_after)
    }
}

/// An error of the duration, which is here called `--after`.
fn at_after(mut error: Error) -> Error {
    for text in [&mut error.place, &mut error.advice].into_iter().flatten() {
        *text = text.replace("--duration", "--after");
    }
    error
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let (figure, limit_m) = match (&args.limit.cep, &args.limit.r95) {
        (Some(text), _) => (Figure::Cep, positive("--cep", text, Dimension::LENGTH)?),
        (None, Some(text)) => (Figure::R95, positive("--r95", text, Dimension::LENGTH)?),
        (None, None) => {
            return Err(Error::usage("no limit is given").advise("write for instance --cep '1 km'"));
        }
    };
    let after_s = positive("--after", &args.after, Dimension::TIME)?;
    let outcome = args.common.ask(
        args.model.as_deref(),
        figure,
        limit_m,
        after_s,
        args.confirm,
        context,
    )?;
    for warning in outcome.warnings() {
        context.warn(&warning);
    }
    context.show(|| outcome.document(), || outcome.to_json())
}
