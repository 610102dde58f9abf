//! `sagnac grade MODEL…`: which grade, and what holds it back.

use std::path::PathBuf;

use clap::ValueEnum;
use sagnac::Error;
use sagnac::grade::{Bias, GradeRequest, GradeTable, area_charts, grade, grade_page};
use sagnac::report::text::Document;

use crate::commands::characterize::command_line;
use crate::commands::drift::put_svg;
use crate::context::Context;
use crate::inputs;
use crate::models::CatalogOption;
use crate::outputs::{Output, publish_all};

/// Which grade is a sensor, and what holds it back?
#[derive(clap::Args)]
#[command(after_help = "Example\n  sagnac grade catalog:STIM300 --report grade.html")]
pub(crate) struct Args {
    /// Model files, or catalog:NAME
    #[arg(value_name = "MODEL", required = true, num_args = 1..)]
    models: Vec<String>,
    /// Whose table
    #[arg(
        long,
        default_value = "lecture",
        value_name = "lecture|groves|el-sheimy"
    )]
    table: String,
    /// Which bias counts [default: run-to-run where both sensors state it]
    #[arg(
        long,
        value_enum,
        value_name = "in-run|run-to-run",
        hide_possible_values = true
    )]
    bias: Option<BiasOption>,
    /// Write the page with the charts of the application areas
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
    /// Draw the gyro's chart
    #[arg(short, long, value_name = "F.svg|F.png")]
    output: Option<PathBuf>,
    /// Overwrite outputs that exist
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    catalog: CatalogOption,
}

/// `--bias`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BiasOption {
    /// The Allan floor.
    InRun,
    /// The draw of a run.
    RunToRun,
}

pub(crate) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let table = GradeTable::parse(&args.table).ok_or_else(|| {
        Error::usage(format!("there is no table `{}`", args.table))
            .at(format!("--table {}", args.table))
            .advise("choose lecture, groves or el-sheimy")
    })?;
    let bias = args.bias.map(|b| match b {
        BiasOption::InRun => Bias::InRun,
        BiasOption::RunToRun => Bias::RunToRun,
    });
    let report = args
        .report
        .as_deref()
        .map(|p| Output::claim_page(p, args.force))
        .transpose()?;
    let picture = args
        .output
        .as_deref()
        .map(|p| Output::claim_picture(p, args.force))
        .transpose()?;
    let catalogue = args.catalog.open(context)?;
    let models = args
        .models
        .iter()
        .map(|name| {
            if name.starts_with("catalog:") {
                Ok(catalogue.find(name)?)
            } else {
                inputs::model(name)
            }
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let outcomes = models
        .iter()
        .map(|model| grade(&GradeRequest { model, table, bias }))
        .collect::<Result<Vec<_>, Error>>()?;
    context.show(
        || {
            let mut doc = Document::new();
            for outcome in &outcomes {
                if outcomes.len() > 1 {
                    doc.heading(outcome.sensor.clone());
                }
                doc.append(outcome.document());
                doc.blank();
            }
            doc
        },
        || match outcomes.as_slice() {
            [one] => one.to_json(),
            all => all
                .iter()
                .map(sagnac::grade::GradeOutcome::to_json)
                .collect(),
        },
    )?;
    let mut outputs = Vec::new();
    if report.is_some() || picture.is_some() {
        let charts = area_charts(&catalogue, &models, bias)?;
        if let Some(mut out) = picture {
            put_svg(&mut out, &charts[0].draw(860.0, "wide"))?;
            outputs.push(out);
        }
        if let Some(mut out) = report {
            let version = env!("CARGO_PKG_VERSION");
            let page = grade_page(&catalogue, &outcomes, charts, &command_line(), version)?;
            out.put(page.html().as_bytes())?;
            outputs.push(out);
        }
    }
    context.wrote(&publish_all(outputs)?)
}
