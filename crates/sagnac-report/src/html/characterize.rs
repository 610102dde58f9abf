//! The page of `characterize`: parameters with intervals, findings, curves, limits, method.

use core::fmt::Write as _;

use super::results::unit_switch;
use super::{Block, Page, Rich, Section, facts_html};
use crate::plots::{
    AllanPanel, IssueTimeline, SeriesPanel, SpectrumPanel, allan_panels, series_panels,
    spectrum_panels,
};
use crate::svg::{escape, page_number};
use crate::text::{Estimate, Sensor, Unit, significant, term_name, term_symbol};

/// A cell of the table of parameters.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum ParameterCell {
    /// An estimate in SI.
    Estimate(Estimate),
    /// A number in SI with a remark below it (the step of rounding).
    Number {
        /// The number in SI.
        value: f64,
        /// The remark.
        note: String,
    },
    /// A word with a remark below it (does the fit explain the curve?).
    Word {
        /// The word.
        word: String,
        /// Its class: `good`, `warn`, `bad` or nothing.
        class: &'static str,
        /// The remark.
        note: String,
    },
    /// The channel is not in the log.
    #[default]
    Absent,
}

/// A row of the table of parameters: one term, axes x, y, z.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterRow {
    /// Gyro or accelerometer.
    pub sensor: Sensor,
    /// JSON name of the term: `angle_random_walk`, `mean`, `lsb`, `fit`, `gauss_markov`, …
    pub term: String,
    /// Name shown; empty: the term's full name.
    pub name: String,
    /// Unit in the first choice of units; `None`: that of the term, or none for words.
    pub unit: Option<Unit>,
    /// What follows every choice of units: `/K` for a coefficient of the temperature, else nothing.
    pub per: &'static str,
    /// x, y, z.
    pub cells: [ParameterCell; 3],
}

impl ParameterRow {
    /// A row of estimates in SI.
    pub fn estimates(sensor: Sensor, term: &str, cells: [Estimate; 3]) -> Self {
        Self {
            sensor,
            term: term.to_owned(),
            name: String::new(),
            unit: Some(Unit::of_term(sensor, term)),
            per: "",
            cells: cells.map(ParameterCell::Estimate),
        }
    }
}

/// What is told about one log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LogReport {
    /// Its name.
    pub name: String,
    /// Verdict on this log; used where the page has several.
    pub verdict: Rich,
    /// Facts of this log; used where the page has several.
    pub facts: Vec<(String, String)>,
    /// Parameters in the order in which they are shown, gyro first.
    pub parameters: Vec<ParameterRow>,
    /// Findings.
    pub timeline: IssueTimeline,
    /// Allan deviations, one list a sensor.
    pub allan: Vec<Vec<AllanPanel>>,
    /// What the measured curves hold and the fitted ones do not; empty where there is nothing.
    pub allan_note: Rich,
    /// Spectra, one list a sensor.
    pub spectrum: Vec<Vec<SpectrumPanel>>,
    /// Time series, one list a sensor.
    pub series: Vec<Vec<SeriesPanel>>,
    /// What the log could not tell: a bold subject and a sentence each.
    pub limits: Vec<Rich>,
}

/// An input file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Input {
    /// Its name.
    pub name: String,
    /// SHA-256 of its bytes in hexadecimal.
    pub sha256: String,
}

impl Input {
    /// The inputs of a page from their names and hashes.
    pub fn all(of: &[(String, String)]) -> Vec<Self> {
        of.iter()
            .map(|(name, sha256)| Self {
                name: name.clone(),
                sha256: sha256.clone(),
            })
            .collect()
    }
}

/// The table that opens a page about several logs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Overview {
    /// Heading and lead.
    pub lead: String,
    /// The table.
    pub table: super::HtmlTable,
}

/// The page of `characterize`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CharacterizePage {
    /// Name of what was looked at: the log's name, or the name given.
    pub name: String,
    /// Line below it: sensor, at rest, length and rate.
    pub subtitle: String,
    /// The verdict in one to three sentences.
    pub verdict: Rich,
    /// Facts of the log.
    pub facts: Vec<(String, String)>,
    /// One log, or several.
    pub logs: Vec<LogReport>,
    /// Table that opens a page about several logs.
    pub overview: Option<Overview>,
    /// How it was computed, in sentences.
    pub method: Rich,
    /// The command as it was typed.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Inputs with their hashes.
    pub inputs: Vec<Input>,
    /// What other tasks say of the same sensor; stands before the method.
    pub more: Vec<Section>,
}

impl CharacterizePage {
    /// The page as one file of HTML.
    pub fn html(&self) -> String {
        let page = Page {
            title: format!("{}: characterisation — sagnac", self.name),
            command: "characterize".to_owned(),
            version: self.version.clone(),
            heading: self.name.clone(),
            subtitle: self.subtitle.clone(),
            verdict: self.verdict.clone(),
            facts: self.facts.clone(),
            sections: Vec::new(),
            footer: String::new(),
        };
        let mut out = String::with_capacity(400_000);
        page.open(&mut out);
        if self.logs.len() == 1 {
            for log in &self.logs {
                write_log(log, "", true, &mut out);
            }
        } else {
            self.write_overview(&mut out);
            for (i, log) in self.logs.iter().enumerate() {
                let suffix = if i == 0 {
                    String::new()
                } else {
                    format!("-{}", i + 1)
                };
                let mut part = String::new();
                let _ = write!(
                    part,
                    "<section data-log=\"{0}\"><p class=\"logname\">{0}</p>",
                    escape(&log.name)
                );
                if !log.verdict.is_empty() {
                    let _ = write!(part, "<p>{}</p>", log.verdict.html());
                }
                facts_html(&log.facts, &mut part);
                write_log(log, &suffix, false, &mut part);
                part.push_str("</section>\n");
                // Clip paths of equal panels of different logs have different names.
                out.push_str(
                    &part
                        .replace("id=\"c-", &format!("id=\"c{i}-"))
                        .replace("url(#c-", &format!("url(#c{i}-")),
                );
            }
        }
        for section in &self.more {
            section.write(&mut out);
        }
        self.method_section().write(&mut out);
        page.close(&mut out);
        out
    }

    fn write_overview(&self, out: &mut String) {
        let mut section = Section::new("overview", "Overview", "");
        if let Some(overview) = &self.overview {
            section.lead.clone_from(&overview.lead);
            section = section.with(Block::Table(overview.table.clone()));
        }
        section.with(Block::Raw(switch())).write(out);
    }

    fn method_section(&self) -> Section {
        let mut section = Section::new("method", "How it was computed, and how to cite it", "")
            .with(Block::Small(self.method.clone()))
            .with(Block::Code(self.command.clone()));
        for input in &self.inputs {
            section = section
                .with(Block::Small(
                    Rich::new().plain(format!("Input {}, SHA-256", input.name)),
                ))
                .with(Block::Hash(input.sha256.clone()));
        }
        let hash = self
            .inputs
            .first()
            .map(|i| {
                let short: String = i.sha256.chars().take(12).collect();
                format!(" (SHA-256 {short}…)")
            })
            .unwrap_or_default();
        section.with(Block::Small(Rich::new().plain(format!(
            "Cite as: sagnac {}, characterisation of {}{hash}, with the command above.",
            self.version, self.name
        ))))
    }
}

fn write_log(log: &LogReport, suffix: &str, with_switch: bool, out: &mut String) {
    let id = |name: &str| format!("{name}{suffix}");
    let mut parameters = Section::new(&id("parameters"), "Parameters", "");
    if with_switch {
        parameters = parameters.with(Block::Raw(switch()));
    }
    parameters
        .with(Block::Raw(parameter_table(&log.parameters)))
        .with(Block::Small(
            "± is half the 95 % interval; a range is given where it is not symmetric. “<” is a 95 % upper \
             limit: the term was looked for and not seen. N is two-sided. B is the coefficient; the floor of \
             the Allan curve is 0.664 B."
                .into(),
        ))
        .write(out);

    let mut issues = Section::new(&id("issues"), "What happened during the recording", "");
    if log.timeline.is_empty() {
        issues = issues.with(Block::Paragraph(
            "Nothing was found: no gap, no step, no saturation, no disturbance.".into(),
        ));
    }
    let (figure, wide_cuts, narrow_cuts) = log.timeline.figure_and_cuts();
    issues = issues
        .with(Block::Wide(figure))
        .with(Block::Raw(cut_list("on-wide", &wide_cuts)))
        .with(Block::Raw(cut_list("on-narrow", &narrow_cuts)));
    issues.write(out);

    let mut allan = Section::new(
        &id("allan"),
        "Allan deviation",
        "Solid blue: measured, with its 95 % band. Orange: the sum of the fitted terms. Dotted: each term \
         alone. Circle: N at τ = 1 s. Dashed: the upper limit of a term that was not seen.",
    );
    if !log.allan_note.is_empty() {
        allan = allan.with(Block::Paragraph(log.allan_note.clone()));
    }
    for panels in &log.allan {
        allan = allan.with(Block::Panels(allan_panels(panels)));
    }
    allan.write(out);

    let mut spectrum = Section::new(
        &id("spectrum"),
        "Spectrum",
        "Blue: measured, averaged over bands. Orange: the sum of the fitted terms. One-sided: white noise shows √2 N.",
    );
    for panels in &log.spectrum {
        spectrum = spectrum.with(Block::Panels(spectrum_panels(panels)));
    }
    spectrum.write(out);

    let pieces = log
        .series
        .iter()
        .flatten()
        .map(SeriesPanel::pieces)
        .max()
        .unwrap_or(0);
    let mut series = Section::new(
        &id("series"),
        "The recording",
        &format!(
            "Line: mean of each 1/{pieces} of the log. Shade: its smallest and largest sample. Yellow: a \
             finding."
        ),
    );
    for panels in &log.series {
        series = series.with(Block::Panels(series_panels(panels)));
    }
    series.write(out);

    Section::new(&id("limits"), "What this log could not tell", "")
        .with(Block::List(log.limits.clone()))
        .write(out);
}

/// Sentences in full where a drawing was too narrow for them.
fn cut_list(class: &str, sentences: &[String]) -> String {
    if sentences.is_empty() {
        return String::new();
    }
    let mut out = format!("<ul class=\"says small {class}\">");
    for sentence in sentences {
        let _ = write!(out, "<li>{}</li>", escape(sentence));
    }
    out.push_str("</ul>");
    out
}

fn switch() -> String {
    unit_switch(&[
        ("field", "pick-field", "u-field", "°/h, µg"),
        ("s-mg", "pick-b", "u-b", "°/s, mg"),
        ("si", "pick-si", "u-si", "SI"),
    ])
}

fn parameter_table(rows: &[ParameterRow]) -> String {
    let mut out = String::from(
        "<table class=\"blocks\" data-table=\"parameters\"><thead><tr><th scope=\"col\">Term</th>\
         <th scope=\"col\">x</th><th scope=\"col\">y</th><th scope=\"col\">z</th></tr></thead><tbody>",
    );
    let mut sensor = None;
    for row in rows {
        if sensor != Some(row.sensor) {
            sensor = Some(row.sensor);
            let _ = write!(
                out,
                "<tr class=\"group\"><th colspan=\"4\" scope=\"colgroup\">{}</th></tr>",
                row.sensor.title()
            );
        }
        write_row(row, &mut out);
    }
    out.push_str("</tbody></table>");
    out
}

/// The three choices of units of a row: spelling and factor from SI.
fn choices(row: &ParameterRow, field: Unit) -> [(String, f64); 3] {
    let deg = Unit::DEG_PER_S.per_si;
    let mg = Unit::MILLI_G.per_si;
    let second: (&str, f64) = match (row.sensor, row.term.as_str()) {
        (Sensor::Gyro, "quantization") => ("°", deg),
        (Sensor::Gyro, "angle_random_walk") => ("°/√s", deg),
        (Sensor::Gyro, "rate_random_walk") => ("°/s/√s", deg),
        (Sensor::Gyro, "rate_ramp") => ("°/s²", deg),
        (Sensor::Gyro, _) => ("°/s", deg),
        (Sensor::Accel, "quantization") => ("mg·s", mg),
        (Sensor::Accel, "velocity_random_walk") => ("mg/√Hz", mg),
        (Sensor::Accel, "acceleration_random_walk") => ("mg/√s", mg),
        (Sensor::Accel, "acceleration_ramp") => ("mg/s", mg),
        (Sensor::Accel, _) => ("mg", mg),
    };
    let si = Unit::si_of_term(row.sensor, &row.term);
    let same = matches!(field.text, "s" | "Hz" | "degC");
    if same {
        let unit = (field.page.to_owned(), field.per_si);
        return [unit.clone(), unit.clone(), unit];
    }
    [
        (field.page.to_owned(), field.per_si),
        (second.0.to_owned(), second.1),
        (si.to_owned(), 1.0),
    ]
}

const CLASSES: [&str; 3] = ["u-field", "u-b", "u-si"];

fn write_row(row: &ParameterRow, out: &mut String) {
    let name = if row.name.is_empty() {
        match row.term.as_str() {
            "bias_instability" => "Bias instability B (coefficient)".to_owned(),
            term => term_name(term).to_owned(),
        }
    } else {
        row.name.clone()
    };
    let _ = write!(
        out,
        "<tr data-sensor=\"{}\" data-term=\"{}\"><th scope=\"row\">{}",
        row.sensor.key(),
        escape(&row.term),
        escape(&name)
    );
    if let Some(symbol) = term_symbol(&row.term) {
        let _ = write!(out, " <i>{symbol}</i>");
    }
    let units = row.unit.map(|u| choices(row, u));
    if let Some(units) = &units {
        out.push_str(" <span class=\"unit\">");
        for ((unit, _), class) in units.iter().zip(CLASSES) {
            let _ = write!(
                out,
                "<span class=\"{class}\">{}{}</span>",
                escape(unit),
                row.per
            );
        }
        out.push_str("</span>");
    }
    out.push_str("</th>");
    let factors = units.map_or([1.0; 3], |u| u.map(|(_, factor)| factor));
    for (cell, axis) in row.cells.iter().zip(["x", "y", "z"]) {
        write_cell(cell, axis, &factors, out);
    }
    out.push_str("</tr>");
}

fn write_cell(cell: &ParameterCell, axis: &str, factors: &[f64; 3], out: &mut String) {
    let status = match cell {
        ParameterCell::Estimate(e) => e.status(),
        ParameterCell::Number { .. } | ParameterCell::Word { .. } => "detected",
        ParameterCell::Absent => "absent",
    };
    let _ = write!(out, "<td data-axis=\"{axis}\" data-status=\"{status}\">");
    match cell {
        ParameterCell::Absent | ParameterCell::Estimate(Estimate::Absent) => out.push('—'),
        ParameterCell::Estimate(estimate) => {
            for (factor, class) in factors.iter().zip(CLASSES) {
                let (value, interval) = figures(estimate.scaled(*factor));
                let _ = write!(out, "<span class=\"{class}\"><b>{value}</b>");
                if status == "upper_limit" {
                    out.push_str("<span class=\"i\">not seen: limit</span>");
                } else if !interval.is_empty() {
                    let _ = write!(out, "<span class=\"i\">{interval}</span>");
                }
                out.push_str("</span>");
            }
        }
        ParameterCell::Number { value, note } => {
            for (factor, class) in factors.iter().zip(CLASSES) {
                let (value, _) = figures(Estimate::Value(value * factor));
                let value = if value.contains('·') || !value.contains('.') {
                    value
                } else {
                    value.trim_end_matches('0').trim_end_matches('.').to_owned()
                };
                let _ = write!(out, "<span class=\"{class}\"><b>{value}</b></span>");
            }
            if !note.is_empty() {
                let _ = write!(out, "<span class=\"i\">{}</span>", escape(note));
            }
        }
        ParameterCell::Word { word, class, note } => {
            let class = if class.is_empty() {
                String::new()
            } else {
                format!(" class=\"{class}\"")
            };
            let _ = write!(out, "<span{class}>{}</span>", escape(word));
            if !note.is_empty() {
                let _ = write!(out, "<span class=\"i\">{}</span>", escape(note));
            }
        }
    }
    out.push_str("</td>");
}

/// Value and interval as markup; small and large numbers share a power of ten.
pub(super) fn figures(estimate: Estimate) -> (String, String) {
    let size = match estimate {
        Estimate::Detected {
            value,
            lower,
            upper,
        } => value.abs().max(0.5 * (upper - lower)),
        Estimate::Value(v) | Estimate::UpperLimit(v) => v.abs(),
        Estimate::Absent => 1.0,
    };
    let exponent = if size > 0.0 && size.is_finite() && !(1e-3..1e5).contains(&size) {
        size.log10().floor() as i32
    } else {
        0
    };
    let scaled = estimate.scaled(10f64.powi(-exponent));
    let text = scaled.text();
    let power = if exponent == 0 {
        String::new()
    } else {
        // The power of ten as page numbers show it: 1e-4 gives 1·10⁻⁴.
        page_number(&format!("1e{exponent}"))
            .trim_start_matches('1')
            .to_owned()
    };
    let value = match scaled {
        Estimate::Value(v) => significant(v, 3),
        _ => text.value,
    };
    let value = escape(&format!("{}{power}", page_number(&value)));
    let interval = if text.interval.is_empty() {
        String::new()
    } else {
        escape(&format!("{}{power}", page_number(&text.interval)))
    };
    (value, interval)
}
