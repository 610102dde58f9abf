//! Tables of text: names left, numbers right or aligned on `±`, one heading line, no frames.
//!
//! A table that is wider than a line is parted by columns: the first column (names) and the last (units)
//! are repeated, the columns between go to as many tables as are needed.

use super::number::{Estimate, EstimateText};
use super::style::{Role, Style, width};

const GAP: usize = 2;

/// How the cells of a column stand below one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Align {
    /// Names and units.
    #[default]
    Left,
    /// Numbers.
    Right,
    /// Numbers on their decimal point.
    Point,
    /// Estimates on their `±`: the value ends there, the interval begins.
    PlusMinus,
}

/// A cell: a text, or a value with its interval.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cell {
    value: String,
    interval: String,
    role: Role,
}

impl Cell {
    /// The same cell in the color of a role.
    #[must_use]
    pub fn with_role(mut self, role: Role) -> Self {
        self.role = role;
        self
    }

    fn encoded(&self, style: Style) -> Self {
        Self {
            value: style.encode(&self.value),
            interval: style.encode(&self.interval),
            role: self.role,
        }
    }

    /// Width left of the alignment line and right of it.
    fn parts(&self, align: Align) -> (usize, usize) {
        let interval = if self.interval.is_empty() {
            0
        } else {
            self.joint() + width(&self.interval)
        };
        match align {
            Align::Left => (0, width(&self.value) + interval),
            Align::Right => (width(&self.value) + interval, 0),
            Align::PlusMinus => (width(&self.value), interval),
            Align::Point => {
                let at = self.point();
                (
                    width(&self.value[..at]),
                    width(&self.value[at..]) + interval,
                )
            }
        }
    }

    /// Byte where the fraction begins: the first point, else the end of the last digit.
    fn point(&self) -> usize {
        self.value.find('.').unwrap_or_else(|| {
            self.value
                .rfind(|c: char| c.is_ascii_digit())
                .map_or(self.value.len(), |at| at + 1)
        })
    }

    fn joint(&self) -> usize {
        if self.interval.starts_with('±') || self.interval.starts_with("+/-") {
            1
        } else {
            2
        }
    }

    fn painted(&self, style: Style) -> String {
        let value = style.paint(self.role, &self.value);
        if self.interval.is_empty() {
            return value;
        }
        let interval = style.paint(Role::Dim, &self.interval);
        format!("{value}{}{interval}", " ".repeat(self.joint()))
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self {
            value: text.to_owned(),
            ..Self::default()
        }
    }
}

impl From<String> for Cell {
    fn from(value: String) -> Self {
        Self {
            value,
            ..Self::default()
        }
    }
}

impl From<&String> for Cell {
    fn from(text: &String) -> Self {
        Self::from(text.as_str())
    }
}

impl From<EstimateText> for Cell {
    fn from(text: EstimateText) -> Self {
        Self {
            value: text.value,
            interval: text.interval,
            role: Role::Plain,
        }
    }
}

impl From<Estimate> for Cell {
    fn from(estimate: Estimate) -> Self {
        estimate.text().into()
    }
}

/// A table with one heading line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    heading: Vec<String>,
    aligns: Vec<Align>,
    rows: Vec<Vec<Cell>>,
    unit_column: bool,
}

impl Table {
    /// A table with these headings and alignments; missing alignments are `Right`, the first is `Left`.
    pub fn new(heading: &[&str], aligns: &[Align]) -> Self {
        let aligns = (0..heading.len())
            .map(|i| {
                aligns
                    .get(i)
                    .copied()
                    .unwrap_or(if i == 0 { Align::Left } else { Align::Right })
            })
            .collect();
        Self {
            heading: heading.iter().map(|&h| h.to_owned()).collect(),
            aligns,
            rows: Vec::new(),
            unit_column: false,
        }
    }

    /// A table of estimates: names first, units last, between them columns aligned on `±`.
    pub fn estimates(heading: &[&str]) -> Self {
        let last = heading.len().saturating_sub(1);
        let aligns: Vec<Align> = (0..heading.len())
            .map(|i| {
                if i == 0 || i == last {
                    Align::Left
                } else {
                    Align::PlusMinus
                }
            })
            .collect();
        let mut table = Self::new(heading, &aligns);
        table.unit_column = true;
        table
    }

    /// Says that the last column is repeated where the table is parted (units, remarks).
    #[must_use]
    pub fn keep_last_column(mut self) -> Self {
        self.unit_column = true;
        self
    }

    /// Adds a row; missing cells are empty, surplus ones are dropped.
    pub fn row<I, C>(&mut self, cells: I) -> &mut Self
    where
        I: IntoIterator<Item = C>,
        C: Into<Cell>,
    {
        let mut row: Vec<Cell> = cells.into_iter().map(Into::into).collect();
        row.resize(self.heading.len(), Cell::default());
        self.rows.push(row);
        self
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Whether no more than `columns` columns are needed for the whole table.
    pub fn fits(&self, columns: usize) -> bool {
        let wide: usize = (0..self.heading.len())
            .map(|i| Measure::of(self.aligns[i], &self.heading[i], &self.rows, i).width())
            .sum();
        wide + GAP * self.heading.len().saturating_sub(1) <= columns
    }

    /// The table as lines of at most `columns` columns, without trailing spaces.
    pub fn render(&self, style: Style, columns: usize) -> Vec<String> {
        let heading: Vec<String> = self.heading.iter().map(|h| style.encode(h)).collect();
        let rows: Vec<Vec<Cell>> = self
            .rows
            .iter()
            .map(|row| row.iter().map(|c| c.encoded(style)).collect())
            .collect();
        let measures: Vec<Measure> = (0..heading.len())
            .map(|i| Measure::of(self.aligns[i], &heading[i], &rows, i))
            .collect();
        let groups = self.groups(&measures, columns);
        let layout = Layout {
            measures: &measures,
            heading: &heading,
            rows: &rows,
            style,
            columns,
        };
        let mut lines = Vec::new();
        for (g, group) in groups.iter().enumerate() {
            if g > 0 {
                lines.push(String::new());
            }
            layout.group(group, &mut lines);
        }
        lines
    }

    fn groups(&self, measures: &[Measure], columns: usize) -> Vec<Vec<usize>> {
        let all: Vec<usize> = (0..measures.len()).collect();
        let total = |group: &[usize]| -> usize {
            group.iter().map(|&i| measures[i].width()).sum::<usize>()
                + GAP * group.len().saturating_sub(1)
        };
        if total(&all) <= columns || measures.len() < 3 {
            return vec![all];
        }
        let last = self.unit_column.then(|| measures.len() - 1);
        let middle = 1..last.unwrap_or(measures.len());
        let mut groups = Vec::new();
        let mut group = vec![0];
        for i in middle {
            let mut wider = group.clone();
            wider.push(i);
            wider.extend(last);
            if group.len() > 1 && total(&wider) > columns {
                group.extend(last);
                groups.push(core::mem::replace(&mut group, vec![0]));
            }
            group.push(i);
        }
        group.extend(last);
        groups.push(group);
        groups
    }
}

/// What one rendering shares between the parts of a table.
struct Layout<'a> {
    measures: &'a [Measure],
    heading: &'a [String],
    rows: &'a [Vec<Cell>],
    style: Style,
    columns: usize,
}

impl Layout<'_> {
    fn group(&self, group: &[usize], lines: &mut Vec<String>) {
        let Self {
            measures,
            heading,
            rows,
            style,
            columns,
        } = *self;
        // What is too wide still is taken from the names, whose cells are cut.
        let total: usize = group.iter().map(|&i| measures[i].width()).sum::<usize>()
            + GAP * group.len().saturating_sub(1);
        let spare = total.saturating_sub(columns);
        let name_width = measures[group[0]].width().saturating_sub(spare).max(4);

        if heading.iter().any(|h| !h.is_empty()) {
            let mut line = Line::default();
            for (k, &i) in group.iter().enumerate() {
                let m = &measures[i];
                let column = if k == 0 { name_width } else { m.width() };
                let text = style.cut(&heading[i], column);
                let pad = match m.align {
                    Align::Right | Align::Point => column - width(&text),
                    Align::Left | Align::PlusMinus => 0,
                };
                line.start_column(k);
                line.spaces(pad);
                line.push(&style.paint(Role::Heading, &text), width(&text));
                line.fill_to(column - pad - width(&text));
            }
            lines.push(line.text);
        }
        for row in rows {
            let mut line = Line::default();
            for (k, &i) in group.iter().enumerate() {
                let m = &measures[i];
                let column = if k == 0 { name_width } else { m.width() };
                let mut cell = row[i].clone();
                if k == 0 && width(&cell.value) > column {
                    cell.value = style.cut(&cell.value, column);
                }
                let (left, right) = cell.parts(m.align);
                let before = match m.align {
                    Align::Left => 0,
                    Align::Right => column - left.min(column),
                    Align::PlusMinus => m.left - left,
                    Align::Point => column - (m.left + m.right).min(column) + m.left - left,
                };
                line.start_column(k);
                line.spaces(before);
                line.push(&cell.painted(style), left + right);
                line.fill_to(column.saturating_sub(before + left + right));
            }
            lines.push(line.text);
        }
    }
}

/// A line under way: spaces are written only when text follows.
#[derive(Default)]
struct Line {
    text: String,
    pending: usize,
}

impl Line {
    fn start_column(&mut self, index: usize) {
        if index > 0 {
            self.pending += GAP;
        }
    }

    fn spaces(&mut self, count: usize) {
        self.pending += count;
    }

    fn push(&mut self, painted: &str, columns: usize) {
        if columns == 0 {
            return;
        }
        self.text.extend(core::iter::repeat_n(' ', self.pending));
        self.pending = 0;
        self.text.push_str(painted);
    }

    fn fill_to(&mut self, count: usize) {
        self.pending += count;
    }
}

struct Measure {
    align: Align,
    left: usize,
    right: usize,
    heading: usize,
}

impl Measure {
    fn of(align: Align, heading: &str, rows: &[Vec<Cell>], column: usize) -> Self {
        let (mut left, mut right) = (0, 0);
        for row in rows {
            let (l, r) = row[column].parts(align);
            left = left.max(l);
            right = right.max(r);
        }
        Self {
            align,
            left,
            right,
            heading: width(heading),
        }
    }

    fn width(&self) -> usize {
        (self.left + self.right).max(self.heading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn characterize_table() -> Table {
        let mut table = Table::estimates(&["Gyro", "x", "y", "z", ""]);
        table.row([
            Cell::from("Angle random walk"),
            Estimate::plus_minus(2.414, 0.021).into(),
            Estimate::plus_minus(2.544, 0.022).into(),
            Estimate::plus_minus(2.267, 0.019).into(),
            "deg/√h".into(),
        ]);
        table.row([
            Cell::from("Bias instability"),
            Estimate::detected(24.0, 12.0, 32.0).into(),
            Estimate::plus_minus(36.0, 8.0).into(),
            Estimate::detected(26.0, 17.0, 32.0).into(),
            "deg/h".into(),
        ]);
        table.row([
            Cell::from("Fit"),
            "0.05".into(),
            "0.86".into(),
            "0.26".into(),
            "p".into(),
        ]);
        table
    }

    #[test]
    fn estimates_stand_on_their_plus_minus() {
        let got = characterize_table().render(Style::PLAIN, 80).join("\n");
        let want = "\
Gyro               x               y              z
Angle random walk  2.414 ± 0.021   2.544 ± 0.022  2.267 ± 0.019   deg/√h
Bias instability      24  12 … 32     36 ± 8         26  17 … 32  deg/h
Fit                 0.05            0.86           0.26           p";
        assert_eq!(got, want);
    }

    #[test]
    fn limits_end_where_values_end() {
        let mut table = Table::estimates(&["Gyro", "x", "y", ""]);
        table.row([
            Cell::from("Bias instability"),
            Estimate::plus_minus(21.0, 7.0).into(),
            Estimate::upper_limit(11.2).into(),
            "deg/h".into(),
        ]);
        table.row([
            Cell::from("Rate random walk"),
            Estimate::upper_limit(310.0).into(),
            Estimate::Absent.into(),
            "deg/h/√h".into(),
        ]);
        let got = table.render(Style::PLAIN, 80).join("\n");
        let want = "\
Gyro              x          y
Bias instability     21 ± 7  < 11  deg/h
Rate random walk  < 310         -  deg/h/√h";
        assert_eq!(got, want);
    }

    #[test]
    fn a_wide_table_is_parted_and_repeats_names_and_units() {
        let lines = characterize_table().render(Style::PLAIN, 50);
        assert!(lines.iter().all(|l| width(l) <= 50));
        assert_eq!(
            lines
                .iter()
                .filter(|l| l.starts_with("Angle random walk") && l.ends_with("deg/√h"))
                .count(),
            3
        );
        let ascii = characterize_table().render(Style::ASCII, 80);
        assert!(ascii.iter().all(|l| l.is_ascii() && l.len() <= 80));
    }

    #[test]
    fn points_stand_below_one_another_and_no_line_ends_in_a_space() {
        let mut table = Table::new(
            &["time", "CEP, m", "95 %"],
            &[Align::Right, Align::Point, Align::Left],
        );
        table.row(["30 s", "12.6", "11.8 … 13.5"]);
        table.row(["120 s", "373", ""]);
        let got = table.render(Style::PLAIN, 80);
        assert_eq!(got[0], " time  CEP, m  95 %");
        assert_eq!(got[1], " 30 s    12.6  11.8 … 13.5");
        assert_eq!(got[2], "120 s   373");
    }

    #[test]
    fn color_does_not_move_columns() {
        let plain = characterize_table().render(Style::PLAIN, 80).join("\n");
        let colored = characterize_table().render(Style::COLOR, 80).join("\n");
        let mut bare = String::new();
        let mut rest = colored.as_str();
        while let Some(at) = rest.find('\x1b') {
            bare.push_str(&rest[..at]);
            let end = rest[at..].find('m').map_or(rest.len(), |e| at + e + 1);
            rest = &rest[end..];
        }
        bare.push_str(rest);
        assert_eq!(bare, plain);
    }

    #[test]
    fn long_names_are_cut() {
        let mut table = Table::new(&["name", "value"], &[]);
        table.row(["n".repeat(100), "1".to_owned()]);
        let lines = table.render(Style::PLAIN, 80);
        assert!(lines.iter().all(|l| width(l) <= 80), "{lines:?}");
        assert!(lines[1].contains('…'));
    }
}
