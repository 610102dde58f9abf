//! The page of `calibrate`: the certificate that a laboratory files, with an annex.

use core::fmt::Write as _;

use super::results::{ResultTable, switch};
use super::{Block, HtmlCell, HtmlTable, Input, Rich, Section};
use crate::plots::{CorrelationMap, Figure, Histogram, PoseSphere, StationResiduals};
use crate::svg::{PLOT_CSS, TOKENS, escape};

const CERTIFICATE_CSS: &str = include_str!("../../assets/certificate.css");

/// A quantity to which the result is referred.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Reference {
    /// Quantity: `Direction of gravity`.
    pub quantity: String,
    /// Standard: `dividing head, certificate 1234`.
    pub standard: String,
    /// Standard uncertainty.
    pub uncertainty: String,
    /// What it makes in the result.
    pub in_result: String,
}

/// The certificate: one A4 sheet, expanded uncertainty with k = 2.
///
/// What is empty stays as a line to fill in.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CertificatePage {
    /// What was calibrated: `Accelerometer triad`.
    pub title: String,
    /// Number of the certificate.
    pub number: String,
    /// Date of issue.
    pub issued: String,
    /// Item: name and serial number.
    pub item: String,
    /// Customer.
    pub customer: String,
    /// Temperature with its uncertainty.
    pub temperature: String,
    /// Date of the calibration.
    pub calibrated: String,
    /// Place.
    pub place: String,
    /// Local gravity and where it is from.
    pub gravity: String,
    /// The result in one sentence.
    pub verdict: Rich,
    /// Method, in sentences.
    pub method: Rich,
    /// References.
    pub references: Vec<Reference>,
    /// Results, one table a sensor; intervals are ± 2 standard uncertainties.
    pub results: Vec<ResultTable>,
    /// What ± is, what it covers, goodness of fit.
    pub result_note: Rich,
    /// Residuals of every station, one a sensor.
    pub residuals: Vec<StationResiduals>,
    /// Histograms before and after.
    pub before_after: Vec<Histogram>,
    /// What was not determined.
    pub not_determined: Rich,
    /// Statement of uncertainty; empty: the usual one.
    pub statement: Rich,
    /// On a second sheet: goodness of fit by axis, axis, χ², degrees of freedom, p.
    pub fits: Vec<[String; 4]>,
    /// On a second sheet: coefficients of the model.
    pub coefficients: Vec<ResultTable>,
    /// Heading of the panels on the second sheet: `output against temperature`; empty: further residuals.
    pub heading: String,
    /// On a second sheet: curves and further residuals, each as wide as the page.
    pub wide: Vec<StationResiduals>,
    /// On a second sheet: curves and histograms, each a panel.
    pub panels: Vec<Figure>,
    /// On a second sheet: poses on the sphere.
    pub poses: Option<PoseSphere>,
    /// On a second sheet: correlations.
    pub correlation: Option<CorrelationMap>,
    /// On a second sheet: estimates that depend on terms held at zero, and what to add.
    pub hints: Vec<Rich>,
    /// The command as it was typed.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Inputs with their hashes.
    pub inputs: Vec<Input>,
}

impl CertificatePage {
    /// The certificate as one file of HTML.
    pub fn html(&self) -> String {
        let mut out = String::with_capacity(150_000);
        let _ = write!(
            out,
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta name=\"generator\" content=\"sagnac {0}\">\n\
             <link rel=\"icon\" href=\"data:,\">\n\
             <title>{1}: calibration certificate — sagnac</title>\n\
             <style>\n{TOKENS}{2}{PLOT_CSS}{CERTIFICATE_CSS}</style>\n</head>\n<body>\n",
            escape(&self.version),
            escape(if self.item.is_empty() {
                &self.title
            } else {
                &self.item
            }),
            super::PAGE_CSS,
        );
        let blank = |text: &str| -> String {
            if text.is_empty() {
                "____________".to_owned()
            } else {
                escape(text)
            }
        };
        let _ = write!(
            out,
            "<header><div><p class=\"kind\">Calibration certificate</p><h1>{}</h1></div>\
             <p class=\"number\"><b>No. {}</b> {}<br>Issued {}</p></header>\n<main>",
            escape(&self.title),
            blank(&self.number),
            if self.has_annex() {
                "Certificate and annex"
            } else {
                "Page 1 of 1"
            },
            blank(&self.issued)
        );
        self.write_item(&mut out);
        let _ = write!(out, "<p class=\"verdict\">{}</p>", self.verdict.html());
        for section in self.sections() {
            section.write(&mut out);
        }
        out.push_str(
            "<div class=\"signs\"><p>Calibrated by</p><p>Approved by</p><p>Date</p></div>\n",
        );
        if self.has_annex() {
            out.push_str("<div class=\"annex\">");
            for section in self.annex() {
                section.write(&mut out);
            }
            out.push_str("</div>");
        }
        out.push_str("</main>\n");
        let mut foot = format!("sagnac {} · {}", self.version, self.command);
        for input in &self.inputs {
            let _ = write!(foot, " · {} SHA-256 {}", input.name, input.sha256);
        }
        let _ = write!(
            out,
            "<footer>{}</footer>\n</body>\n</html>\n",
            escape(&foot)
        );
        out
    }

    fn write_item(&self, out: &mut String) {
        out.push_str("<dl class=\"item\">");
        for (name, value) in [
            ("Item", &self.item),
            ("Calibrated", &self.calibrated),
            ("Customer", &self.customer),
            ("Place", &self.place),
            ("Temperature", &self.temperature),
            ("Local gravity", &self.gravity),
        ] {
            let _ = write!(out, "<div><dt>{name}</dt><dd>{}</dd></div>", escape(value));
        }
        out.push_str("</dl>");
    }

    fn has_annex(&self) -> bool {
        !self.is_one_sheet()
            || self.correlation.is_some()
            || self.poses.is_some()
            || !self.fits.is_empty()
            || !self.hints.is_empty()
            || !self.wide.is_empty()
            || !self.panels.is_empty()
            || !self.coefficients.is_empty()
    }

    fn panels_heading(&self) -> String {
        if self.heading.is_empty() {
            "Annex: further residuals".to_owned()
        } else {
            format!("Annex: {}", self.heading)
        }
    }

    /// Whether the residuals find room on the sheet that is signed: those of one sensor do.
    fn is_one_sheet(&self) -> bool {
        self.results.len() < 2
    }

    /// Residuals, before and after; none where there are none.
    fn residual_section(&self, heading: &str) -> Option<Section> {
        if self.residuals.is_empty() && self.before_after.is_empty() {
            return None;
        }
        let mut section = Section::new("residuals", heading, "");
        for r in &self.residuals {
            section = section.with(Block::Wide(r.figure()));
        }
        let histograms: Vec<Figure> = self.before_after.iter().map(Histogram::figure).collect();
        Some(section.with(Block::Panels(histograms)))
    }

    /// The second sheet.
    fn annex(&self) -> Vec<Section> {
        let mut sections = Vec::new();
        if !self.is_one_sheet() {
            sections.extend(self.residual_section("Annex: residuals"));
        }
        if !self.fits.is_empty() {
            let mut table = HtmlTable::new(
                "fit",
                &["Axis", "χ²", "Degrees of freedom", "p"],
                &[1, 2, 3],
            );
            for row in &self.fits {
                let mut cells: Vec<HtmlCell> = vec![row[0].clone().into()];
                cells.extend(row[1..].iter().map(|text| HtmlCell::number(text.clone())));
                table.row(cells);
            }
            sections
                .push(Section::new("fit", "Annex: goodness of fit", "").with(Block::Table(table)));
        }
        if !self.coefficients.is_empty() {
            let mut section = Section::new("coefficients", "Annex: coefficients of the model", "");
            for table in &self.coefficients {
                section = section.with(Block::Raw(table.html("coefficients")));
            }
            sections.push(section);
        }
        if !self.wide.is_empty() || !self.panels.is_empty() {
            let mut section = Section::new("curves", &self.panels_heading(), "");
            for r in &self.wide {
                section = section.with(Block::Wide(r.figure()));
            }
            sections.push(section.with(Block::Panels(self.panels.clone())));
        }
        if let Some(poses) = &self.poses {
            sections.push(
                Section::new("poses", "Annex: poses", "").with(Block::Panels(vec![poses.figure()])),
            );
        }
        if let Some(map) = &self.correlation {
            sections.push(
                Section::new("correlation", "Annex: what is tied to what", "")
                    .with(Block::Plots(vec![(super::Breadth::Middle, map.figure())])),
            );
        }
        if !self.hints.is_empty() {
            sections.push(
                Section::new(
                    "hints",
                    "Annex: what the result assumes, and what to add",
                    "",
                )
                .with(Block::List(self.hints.clone())),
            );
        }
        sections
    }

    fn sections(&self) -> Vec<Section> {
        let mut sections =
            vec![Section::new("method", "Method", "").with(Block::Paragraph(self.method.clone()))];
        if !self.references.is_empty() {
            let mut table = HtmlTable::new(
                "references",
                &[
                    "Quantity",
                    "Standard",
                    "Standard uncertainty",
                    "In the result",
                ],
                &[],
            );
            for r in &self.references {
                table.row(vec![
                    r.quantity.clone().into(),
                    r.standard.clone().into(),
                    r.uncertainty.clone().into(),
                    r.in_result.clone().into(),
                ]);
            }
            sections.push(Section::new("references", "References", "").with(Block::Table(table)));
        }
        let mut result = Section::new("parameters", "Result", "");
        result = result.with(Block::Raw(switch(&self.results)));
        for table in &self.results {
            result = result.with(Block::Raw(table.html("parameters")));
        }
        sections.push(result.with(Block::Paragraph(self.result_note.clone())));
        if self.is_one_sheet() {
            sections.extend(self.residual_section("Residuals"));
        }
        sections.push(
            Section::new("limits", "Not determined by this test", "")
                .with(Block::Paragraph(self.not_determined.clone())),
        );
        let statement = if self.statement.is_empty() {
            "Uncertainties are evaluated by the law of propagation from the standard uncertainties above and \
             are stated as expanded uncertainty with coverage factor k = 2. They hold for the conditions above \
             at the time of calibration and say nothing of long-term stability."
                .into()
        } else {
            self.statement.clone()
        };
        sections.push(
            Section::new("statement", "Statement of uncertainty", "")
                .with(Block::Paragraph(statement)),
        );
        sections
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_certificate_is_a_form_to_fill_in() {
        let html = CertificatePage::default().html();
        assert!(html.contains("<dt>Customer</dt><dd></dd>"));
        assert!(html.contains("k = 2"));
    }

    #[test]
    fn residuals_of_two_sensors_follow_the_signatures() {
        let page = |sensors: usize| {
            let page = CertificatePage {
                results: vec![ResultTable::default(); sensors],
                before_after: vec![Histogram::default()],
                ..CertificatePage::default()
            };
            let html = page.html();
            let at = |part: &str| html.find(part).unwrap_or(0);
            at("id=\"residuals\"") > at("class=\"signs\"")
        };
        assert!(!page(1) && page(2));
    }
}
