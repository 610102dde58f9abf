//! The pages of `explain`, `response`, `drift`, `grade`, `catalog` and `compare`.
//!
//! Each is a struct of what the page shows; numbers come as texts in the words of the field, plots as their
//! own structs.

use super::{Block, Breadth, HtmlCell, HtmlTable, Input, Page, Rich, Section};
use crate::plots::{
    AllanPanel, DriftCloud, DriftGrowth, DriftShare, ExplainPanel, Figure, ResponsePlots,
    ScatterChart, allan_panels, explain_panels,
};

/// What every page opens and closes with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Opening {
    /// The heading: what was looked at.
    pub name: String,
    /// Line below it.
    pub subtitle: String,
    /// The verdict in one to three sentences.
    pub verdict: Rich,
    /// Facts in short.
    pub facts: Vec<(String, String)>,
    /// Version of the program.
    pub version: String,
    /// The command as it was typed.
    pub command: String,
    /// How it was computed, in sentences; empty: only the command.
    pub method: Rich,
    /// What could not be known; empty: the section is left out.
    pub limits: Vec<Rich>,
    /// Inputs with their hashes.
    pub inputs: Vec<Input>,
}

impl Opening {
    fn page(&self, task: &str, what: &str, mut sections: Vec<Section>) -> Page {
        if !self.limits.is_empty() {
            sections.push(
                Section::new("limits", "What could not be known", "")
                    .with(Block::List(self.limits.clone())),
            );
        }
        if !self.command.is_empty() || !self.method.is_empty() {
            sections.push(self.method_section());
        }
        Page {
            title: format!("{}: {what} — sagnac", self.name),
            command: task.to_owned(),
            version: self.version.clone(),
            heading: self.name.clone(),
            subtitle: self.subtitle.clone(),
            verdict: self.verdict.clone(),
            facts: self.facts.clone(),
            sections,
            footer: String::new(),
        }
    }

    fn method_section(&self) -> Section {
        let mut section = Section::new("method", "How it was computed", "");
        if !self.method.is_empty() {
            section = section.with(Block::Small(self.method.clone()));
        }
        if !self.command.is_empty() {
            section = section.with(Block::Code(self.command.clone()));
        }
        for input in &self.inputs {
            section = section
                .with(Block::Small(
                    Rich::new().plain(format!("Input {}, SHA-256", input.name)),
                ))
                .with(Block::Hash(input.sha256.clone()));
        }
        section
    }
}

/// The page of `explain`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExplainPage {
    /// Words and facts.
    pub opening: Opening,
    /// Gyro axes.
    pub gyro: Vec<ExplainPanel>,
    /// Accelerometer axes.
    pub accel: Vec<ExplainPanel>,
    /// Random terms with the sigma of a sample: gyro, then accelerometer.
    pub random: [Vec<RandomRow>; 2],
}

/// A random term on three axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RandomRow {
    /// Its name.
    pub term: String,
    /// Sigma on x, y, z.
    pub sigma: [String; 3],
    /// Their unit, one for all rows of a table.
    pub unit: String,
}

impl ExplainPage {
    /// The page as one file of HTML.
    pub fn html(&self) -> String {
        let mut sections = Vec::new();
        let [gyro, accel] = &self.random;
        for (id, heading, panels, random) in [
            ("gyro", "Gyro", &self.gyro, gyro),
            ("accel", "Accelerometer", &self.accel, accel),
        ] {
            if panels.is_empty() {
                continue;
            }
            let mut section =
                Section::new(id, heading, "").with(Block::Panels(explain_panels(panels)));
            if !random.is_empty() {
                let name = format!("{id}-noise");
                let unit = random.first().map_or("", |row| row.unit.as_str());
                let heading = format!("Noise, 1σ of a sample, {unit}");
                let mut table = HtmlTable::new(&name, &[&heading, "x", "y", "z"], &[1, 2, 3]);
                for row in random {
                    let [x, y, z] = row.sigma.clone().map(HtmlCell::number);
                    table.row(vec![row.term.clone().into(), x, y, z]);
                }
                section = section.with(Block::Table(table));
            }
            sections.push(section);
        }
        if let Some(last) = sections.last_mut() {
            last.blocks.push(Block::Small(
                "Each bar is what one term adds to that axis, largest first; blue adds, orange takes away. \
                 The bars of an axis sum to output less input. Terms that add nothing here are left out."
                    .into(),
            ));
        }
        self.opening
            .page("explain", "what each term adds", sections)
            .html()
    }
}

/// A row of the numbers of `response`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ResponseRow {
    /// Term: `Accuracy`.
    pub term: String,
    /// What it is.
    pub what: String,
    /// Value.
    pub value: String,
    /// Unit.
    pub unit: String,
    /// Interval, and more.
    pub more: String,
}

/// The page of `response`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ResponsePage {
    /// Words and facts.
    pub opening: Opening,
    /// The numbers.
    pub rows: Vec<ResponseRow>,
    /// The plots.
    pub plots: ResponsePlots,
}

impl ResponsePage {
    /// The page as one file of HTML.
    pub fn html(&self) -> String {
        let mut table = HtmlTable::new(
            "response",
            &["Term", "What", "Value", "Unit", "95 % interval, and more"],
            &[2],
        );
        for row in &self.rows {
            table.row(vec![
                row.term.clone().into(),
                row.what.clone().into(),
                HtmlCell::number(Rich::new().bold(row.value.clone())),
                row.unit.clone().into(),
                row.more.clone().into(),
            ]);
        }
        let plots = &self.plots;
        let mut figures = vec![(Breadth::Middle, plots.residuals())];
        if !plots.target.is_empty() {
            figures.push((Breadth::Panel, plots.target()));
        }
        let mut second = vec![(Breadth::Panel, plots.line())];
        if !plots.hysteresis.is_empty() {
            second.push((Breadth::Panel, plots.hysteresis()));
        }
        let sections = vec![
            Section::new("parameters", "Numbers", "").with(Block::Table(table)),
            Section::new("plots", "Plots", "")
                .with(Block::Plots(figures))
                .with(Block::Plots(second)),
        ];
        self.opening.page("response", "response", sections).html()
    }
}

/// A row of the budget of `drift`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BudgetRow {
    /// Term in words.
    pub term: String,
    /// Its value in the model.
    pub in_model: String,
    /// Its share of the variance, 0 … 1.
    pub share: f64,
    /// Share as text: `75.2 %`, `< 0.1 %`.
    pub share_text: String,
    /// CEP of this term alone.
    pub alone: String,
    /// CEP of the whole if this term were half as large.
    pub halved: String,
}

/// The page of `drift`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DriftPage {
    /// Words and facts.
    pub opening: Opening,
    /// Growth in time.
    pub growth: DriftGrowth,
    /// Where the runs end; `None` without a Monte Carlo.
    pub cloud: Option<DriftCloud>,
    /// Which term causes it.
    pub share: DriftShare,
    /// Heading of the budget: `Budget after 2 min`.
    pub budget_heading: String,
    /// The budget.
    pub budget: Vec<BudgetRow>,
    /// Further tables: against time, attitude, velocity; each with its heading.
    pub tables: Vec<(String, HtmlTable)>,
}

impl DriftPage {
    /// The page as one file of HTML.
    pub fn html(&self) -> String {
        self.opening.page("drift", "drift", self.sections()).html()
    }

    /// Growth, cloud, share over time, budget and tables: what other pages may hold as well.
    pub fn sections(&self) -> Vec<Section> {
        let mut figures = vec![(Breadth::Middle, self.growth.figure())];
        if let Some(cloud) = &self.cloud {
            figures.push((Breadth::Panel, cloud.figure()));
        }
        let mut plots = Section::new("growth", "", "").with(Block::Plots(figures));
        if !self.share.terms.is_empty() {
            plots = plots.with(Block::Wide(self.share.figure()));
        }
        let mut budget = HtmlTable::new(
            "budget",
            &[
                "Term",
                "In the model",
                "Share",
                "",
                "CEP alone",
                "CEP if halved",
            ],
            &[1, 2, 4, 5],
        );
        for row in &self.budget {
            budget.row(vec![
                row.term.clone().into(),
                row.in_model.clone().into(),
                HtmlCell::number(Rich::new().bold(row.share_text.clone())),
                HtmlCell::bar(row.share),
                row.alone.clone().into(),
                row.halved.clone().into(),
            ]);
        }
        let heading = if self.budget_heading.is_empty() {
            "Budget"
        } else {
            &self.budget_heading
        };
        let mut sections = vec![plots];
        if !self.budget.is_empty() {
            sections.push(
                Section::new("budget", heading, "")
                    .with(Block::Table(budget))
                    .with(Block::Small(
                        "“If halved” is the CEP of the whole if that term alone were half as large."
                            .into(),
                    )),
            );
        }
        for (i, (heading, table)) in self.tables.iter().enumerate() {
            sections.push(
                Section::new(&format!("table-{}", i + 1), heading, "")
                    .with(Block::Table(table.clone())),
            );
        }
        sections
    }
}

/// The page of `drift` on a recording: curves, and the table of their numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordingPage {
    /// Words and facts.
    pub opening: Opening,
    /// Error over the time since the start.
    pub figure: Figure,
    /// Its numbers.
    pub table: HtmlTable,
}

impl RecordingPage {
    /// The page as one file of HTML.
    pub fn html(&self) -> String {
        let sections = vec![
            Section::new("growth", "", "").with(Block::Wide(self.figure.clone())),
            Section::new("parameters", "Error after each time", "")
                .with(Block::Table(self.table.clone())),
        ];
        self.opening.page("drift", "drift", sections).html()
    }
}

/// The page of `grade`, and of `catalog` where it shows charts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChartPage {
    /// Words and facts.
    pub opening: Opening,
    /// Command: `grade` or `catalog`.
    pub task: String,
    /// The charts: application areas side by side, or cost against performance.
    pub charts: Vec<ScatterChart>,
    /// What the signs mean, and whose regions these are.
    pub key: Rich,
    /// Tables, each with its heading.
    pub tables: Vec<(String, HtmlTable)>,
}

impl ChartPage {
    /// Key of the application areas; the sources of the regions follow.
    pub fn area_key(sources: &str) -> Rich {
        Self::technologies(
            Rich::new()
                .plain("Filled: run-to-run bias. Open: only an in-run figure is published. Triangle: only the tolerance when new. "),
        )
        .plain(". Diamond: your sensor. Regions are ")
        .bold("ours")
        .plain(format!(": {sources}"))
    }

    /// Names of the technologies in their colors.
    pub fn technologies(rich: Rich) -> Rich {
        rich.colored("chip-mems", "MEMS")
            .plain(" · ")
            .colored("chip-fog", "FOG")
            .plain(" · ")
            .colored("chip-rlg", "RLG")
            .plain(" · ")
            .colored("chip-other", "HRG, servo, other")
    }

    /// The page as one file of HTML.
    pub fn html(&self) -> String {
        let what = if self.task == "grade" {
            "grade"
        } else {
            "catalogue"
        };
        self.opening.page(&self.task, what, self.sections()).html()
    }

    /// The charts with their key, and the tables: what other pages may hold as well.
    pub fn sections(&self) -> Vec<Section> {
        let mut charts = Section::new("charts", "", "");
        if let [one] = self.charts.as_slice() {
            charts = charts.with(Block::Wide(one.figure(860.0)));
        } else if !self.charts.is_empty() {
            charts = charts.with(Block::Plots(
                self.charts
                    .iter()
                    .map(|c| (Breadth::Middle, c.figure(500.0)))
                    .collect(),
            ));
        }
        if !self.key.is_empty() {
            charts = charts.with(Block::Small(self.key.clone()));
        }
        let mut sections = vec![charts];
        for (i, (heading, table)) in self.tables.iter().enumerate() {
            sections.push(
                Section::new(&format!("table-{}", i + 1), heading, "")
                    .with(Block::Table(table.clone())),
            );
        }
        sections
    }
}

/// A row of `compare`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CompareRow {
    /// Axis and term: `Gyro x, angle random walk`.
    pub term: String,
    /// Measured value and its interval.
    pub measured: (String, String),
    /// Value of the sheet.
    pub sheet: String,
    /// Unit of both.
    pub unit: String,
    /// Ratio and its interval.
    pub ratio: (String, String),
    /// `within`, `better`, `worse` or `unclear`.
    pub verdict: String,
    /// What else is to be said.
    pub text: String,
}

/// The page of `compare`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparePage {
    /// Words and facts.
    pub opening: Opening,
    /// The rows.
    pub rows: Vec<CompareRow>,
    /// Allan deviations, one list a sensor, with the sheet's curve as the fit.
    pub allan: Vec<Vec<AllanPanel>>,
}

impl ComparePage {
    /// The page as one file of HTML.
    pub fn html(&self) -> String {
        let mut table = HtmlTable::new(
            "compare",
            &["Term", "Measured", "Sheet", "Unit", "Ratio", "Verdict"],
            &[1, 2, 4],
        );
        for row in &self.rows {
            let class = match row.verdict.as_str() {
                "within" | "better" => "good",
                "worse" => "bad",
                _ => "warn",
            };
            let mut verdict = HtmlCell::from(row.verdict.clone()).with_note(row.text.clone());
            verdict.class = class;
            table.row(vec![
                row.term.clone().into(),
                HtmlCell::number(Rich::new().bold(row.measured.0.clone()))
                    .with_note(row.measured.1.clone()),
                HtmlCell::number(row.sheet.clone()),
                row.unit.clone().into(),
                HtmlCell::number(Rich::new().bold(row.ratio.0.clone()))
                    .with_note(row.ratio.1.clone()),
                verdict,
            ]);
        }
        let mut sections =
            vec![Section::new("parameters", "Term by term", "").with(Block::Table(table))];
        if !self.allan.is_empty() {
            let mut section = Section::new(
                "allan",
                "Allan deviation",
                "Blue: measured, with its 95 % band. Orange: what the sheet says.",
            );
            for panels in &self.allan {
                let mut figures = allan_panels(panels);
                for figure in &mut figures {
                    "compare-allan".clone_into(&mut figure.plot);
                }
                section = section.with(Block::Panels(figures));
            }
            sections.push(section);
        }
        self.opening.page("compare", "comparison", sections).html()
    }
}
