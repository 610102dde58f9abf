//! The one report of `demo`: the characterization, the truth beside it, grade, drift and budget.

use sagnac_model::Catalogue;
use sagnac_report::html::{Block, CharacterizePage, HtmlCell, HtmlTable, Opening, Rich, Section};
use sagnac_report::text::{Unit, significant};

use super::{Check, DemoOutcome, distance};
use crate::Error;
use crate::characterize::PageFacts;
use crate::grade::{area_charts, grade_page};

impl DemoOutcome {
    /// The whole loop on one page.
    ///
    /// # Errors
    /// A catalogue that cannot be read.
    pub fn page(
        &self,
        catalogue: &Catalogue,
        facts: &PageFacts,
    ) -> Result<CharacterizePage, Error> {
        let mut page = self.characterized.to_page(facts);
        page.verdict = page.verdict.plain(format!(
            " Simulated from the catalogue's {}: {} of {} intervals hold the number they were simulated from (95 % would be {:.1}).",
            self.model.name(),
            self.covered(),
            self.checks.len(),
            0.95 * self.checks.len() as f64
        ));
        page.more.push(self.truth_section());
        page.more.extend(self.grade_sections(catalogue)?);
        page.more.extend(self.drift_sections());
        page.more.push(self.budget_section());
        Ok(page)
    }

    fn truth_section(&self) -> Section {
        let mut table = HtmlTable::new(
            "truth",
            &[
                "Term",
                "Simulated",
                "Estimated",
                "95 % interval",
                "Holds the truth",
            ],
            &[1, 2, 3],
        );
        for check in &self.checks {
            let (name, unit) = words(check);
            let number = |x: f64| significant(unit.from_si(x), 3);
            let [value, lower, upper] = check.found;
            let interval = match (lower, upper) {
                (Some(low), Some(high)) => format!("{} … {}", number(low), number(high)),
                (None, Some(high)) => format!("< {}", number(high)),
                _ => "–".to_owned(),
            };
            let mut held = HtmlCell::from(if check.is_held { "yes" } else { "no" }.to_owned());
            held.class = if check.is_held { "good" } else { "warn" };
            table.row(vec![
                name.into(),
                HtmlCell::number(format!("{} {}", number(check.truth), unit.page)),
                HtmlCell::number(value.map_or("–".to_owned(), number)),
                HtmlCell::number(interval),
                held,
            ]);
        }
        Section::new(
            "truth",
            "Compared with the truth",
            "What was simulated, beside what the log alone says.",
        )
        .with(Block::Table(table))
    }

    fn grade_sections(&self, catalogue: &Catalogue) -> Result<Vec<Section>, Error> {
        let charts = area_charts(catalogue, std::slice::from_ref(&self.model), None)?;
        let page = grade_page(catalogue, std::slice::from_ref(&self.grade), charts, "", "")?;
        let mut first = Section::new("grade", "Grade and application area", "")
            .with(Block::Paragraph(page.opening.verdict.clone()));
        for section in page.sections() {
            if !section.heading.is_empty() {
                first.blocks.push(Block::Heading(section.heading));
            }
            first.blocks.extend(section.blocks);
        }
        Ok(vec![first])
    }

    fn drift_sections(&self) -> Vec<Section> {
        let page = self.drift.page(Opening::default());
        let mut first = Section::new("drift", "Drift at rest", "")
            .with(Block::Paragraph(page.opening.verdict.clone()));
        let mut out = Vec::new();
        for section in page.sections() {
            match section.id.as_str() {
                "growth" => first.blocks.extend(section.blocks),
                _ => out.push(Section {
                    id: format!("drift-{}", section.id),
                    ..section
                }),
            }
        }
        out.insert(0, first);
        out
    }

    fn budget_section(&self) -> Section {
        let budget = &self.budget;
        let mut table = HtmlTable::new(
            "requirement",
            &["Sensor", "CEP", "R95", "Price class, USD", "Meets it"],
            &[1, 2],
        );
        let rows = budget
            .met_by
            .iter()
            .map(|c| (c, true))
            .chain(budget.nearest.iter().map(|c| (c, false)));
        for (candidate, meets) in rows {
            let price = candidate.price.as_ref().map_or("–", |p| p.0);
            table.row(vec![
                candidate.sensor.clone().into(),
                HtmlCell::number(distance(candidate.cep_m)),
                HtmlCell::number(distance(candidate.r95_m)),
                price.to_owned().into(),
                if meets { "yes" } else { "no" }.to_owned().into(),
            ]);
        }
        Section::new(
            "requirement",
            "What would keep 1 km after 10 min in a drive?",
            "",
        )
        .with(Block::Paragraph(Rich::new().plain(format!(
            "{} sensors of the catalogue do, the cheapest first, then the three nearest. {} were left out: their sheets lack a number the question needs.",
            budget.met_by.len(),
            budget.skipped
        ))))
        .with(Block::Table(table))
    }
}

/// A checked term in words, and the unit of its field.
fn words(check: &Check) -> (String, Unit) {
    let (sensor, axis) = check.axis.split_once('_').unwrap_or(("", &check.axis));
    let gyro = sensor == "gyro";
    let (term, unit) = match (check.term, gyro) {
        ("bias_instability", true) => ("bias instability B", Unit::DEG_PER_H),
        ("bias_instability", false) => ("bias instability B", Unit::MICRO_G),
        (_, true) => ("angle random walk", Unit::DEG_PER_SQRT_H),
        (_, false) => ("velocity random walk", Unit::M_PER_S_PER_SQRT_H),
    };
    let name = if gyro { "Gyro" } else { "Accel" };
    (format!("{name} {axis}, {term}"), unit)
}
