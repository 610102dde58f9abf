//! The page and the pictures of `response`: residuals, hysteresis, output against input, the target.

use sagnac_calibrate::response::{Direction, Point};
use sagnac_report::html::{Input, Opening, ResponsePage, ResponseRow, Rich, page_text};
use sagnac_report::plots::ResponsePlots;
use sagnac_report::svg::Svg;
use sagnac_report::text::significant;

use super::text::{Shown, own};
use super::{RecordUnit, ResponseOutcome};
use crate::calibrate::PageFacts;

/// A unit as pages write it.
fn page_unit(unit: &str) -> String {
    let text = page_text(unit);
    if unit == "deg" { "°".to_owned() } else { text }
}

/// `reference rate, °/s`.
fn title(word: &str, unit: &RecordUnit) -> String {
    let unit = page_unit(&own(unit));
    if unit.is_empty() {
        word.to_owned()
    } else {
        format!("{word}, {unit}")
    }
}

impl ResponseOutcome {
    /// What the plots show, in the units of the record.
    pub fn plots(&self) -> ResponsePlots {
        let r = &self.response;
        let shown = self.shown_small();
        let (to_x, to_y) = (1.0 / self.reference.factor(), 1.0 / self.output.factor());
        let line = |x: f64| r.offset + r.sensitivity.value * x;
        let small = |y: f64, x: f64| (x * to_x, (y - line(x)) * shown.factor);
        let readings = |wanted: Option<Direction>| -> Vec<(f64, f64)> {
            self.readings
                .iter()
                .zip(&r.directions)
                .filter(|(_, d)| **d == wanted)
                .map(|(p, _)| small(p.output, p.reference))
                .collect()
        };
        // Where the direction turns, the loop is closed by the one mean that there is.
        let last = r.points.len().saturating_sub(1);
        let mean = |pick: fn(&Point) -> Option<f64>, other: fn(&Point) -> Option<f64>| {
            r.points
                .iter()
                .enumerate()
                .filter_map(|(i, p)| {
                    let end = i == 0 || i == last;
                    let y = pick(p).or(other(p).filter(|_| end))?;
                    Some((p.reference, y))
                })
                .collect::<Vec<(f64, f64)>>()
        };
        let both =
            r.points.iter().any(|p| p.up.is_some()) && r.points.iter().any(|p| p.down.is_some());
        let (up, down) = if both {
            (mean(|p| p.up, |p| p.down), mean(|p| p.down, |p| p.up))
        } else {
            (mean(|p| p.up, |_| None), mean(|p| p.down, |_| None))
        };
        let scaled = |means: &[(f64, f64)]| -> Vec<(f64, f64)> {
            means.iter().map(|(x, y)| small(*y, *x)).collect()
        };
        let still_mean = if up.is_empty() && down.is_empty() {
            r.points
                .iter()
                .map(|p| small(p.mean, p.reference))
                .collect()
        } else {
            Vec::new()
        };
        let ends = [r.points.first(), r.points.last()].map(|p| p.map_or(0.0, |p| p.reference));
        let hysteresis: Vec<(f64, f64)> = up
            .iter()
            .filter_map(|(x, u)| {
                let (_, d) = down.iter().find(|(other, _)| other == x)?;
                Some((x * to_x, (d - u) * shown.factor))
            })
            .collect();
        let unit = page_unit(&shown.name);
        let (target, target_titles) = self.target(shown.factor);
        ResponsePlots {
            reference_title: title("reference", &self.reference),
            output_title: title("output", &self.output),
            residual_unit: unit,
            up: readings(Some(Direction::Up)),
            down: readings(Some(Direction::Down)),
            still: readings(None),
            up_mean: scaled(&up),
            down_mean: scaled(&down),
            still_mean,
            least_squares: r
                .linearity
                .as_ref()
                .ok()
                .map(|l| l.least_squares * shown.factor),
            minimax: r.linearity.as_ref().ok().map(|l| {
                [-1.0, 1.0].map(|sign| {
                    ends.map(|x| {
                        small(l.minimax_offset + l.minimax_slope * x + sign * l.minimax, x)
                    })
                })
            }),
            points: r
                .points
                .iter()
                .map(|p| (p.reference * to_x, p.mean * to_y))
                .collect(),
            line: Some(ends.map(|x| (x * to_x, line(x) * to_y))),
            line_label: format!("slope {}", page_text(&self.sensitivity_text().0.value)),
            hysteresis: if both && r.hysteresis.is_ok() {
                hysteresis
            } else {
                Vec::new()
            },
            hysteresis_label: r.hysteresis.as_ref().map_or(String::new(), |h| {
                page_text(&format!(
                    "{} at {} {}",
                    significant(h.value * shown.factor, 3),
                    significant(h.at * to_x, 3),
                    own(&self.reference)
                ))
            }),
            target,
            target_titles,
        }
    }

    /// Errors going up against errors going down, or of odd against even readings, one dot a repeat.
    fn target(&self, factor: f64) -> (Vec<(f64, f64)>, (String, String)) {
        let by_direction = ("error going up".to_owned(), "error going down".to_owned());
        let Some(nominal) = self.nominal_sensitivity else {
            return (Vec::new(), by_direction);
        };
        let r = &self.response;
        let near = 1e-9 * r.full_scale;
        let at = |point: &Point, wanted: Option<Direction>| -> Vec<f64> {
            self.readings
                .iter()
                .zip(&r.directions)
                .filter(|(p, d)| **d == wanted && (p.reference - point.reference).abs() <= near)
                .map(|(p, _)| (p.output - nominal * p.reference) * factor)
                .collect()
        };
        let paired: Vec<(f64, f64)> = r
            .points
            .iter()
            .flat_map(|p| {
                at(p, Some(Direction::Up))
                    .into_iter()
                    .zip(at(p, Some(Direction::Down)))
            })
            .collect();
        if !paired.is_empty() {
            return (paired, by_direction);
        }
        let alternating = r
            .points
            .iter()
            .flat_map(|p| {
                let mut all = at(p, None);
                all.extend(at(p, Some(Direction::Up)));
                all.extend(at(p, Some(Direction::Down)));
                all.chunks_exact(2)
                    .map(|pair| (pair[0], pair[1]))
                    .collect::<Vec<_>>()
            })
            .collect();
        (
            alternating,
            (
                "error, odd readings".to_owned(),
                "error, even readings".to_owned(),
            ),
        )
    }

    /// The page.
    pub fn to_page(&self, facts: &PageFacts) -> ResponsePage {
        let r = &self.response;
        let x = Shown::of(&self.reference, r.full_scale);
        let file = self.label.rsplit(['/', '\\']).next().unwrap_or(&self.label);
        let ends = [r.points.first(), r.points.last()].map(|p| p.map_or(0.0, |p| p.reference));
        let mut limits: Vec<Rich> = Vec::new();
        if r.accuracy.is_ok() {
            limits.push(
                Rich::new()
                    .bold("The reference.")
                    .plain(" Accuracy holds only as far as the reference is true."),
            );
        }
        for (name, reason) in self.not_given() {
            limits.push(
                Rich::new()
                    .bold(format!("No {name}."))
                    .plain(format!(" {}.", sentence(reason))),
            );
        }
        ResponsePage {
            opening: Opening {
                name: file.to_owned(),
                subtitle: format!(
                    "{} readings at {} points, {} to {}; full scale {}",
                    self.readings.len(),
                    r.points.len(),
                    page_text(&x.number(ends[0], 4)),
                    page_text(&format!("{} {}", x.number(ends[1], 4), x.name)),
                    page_text(&format!("{} {}", x.number(r.full_scale, 4), x.name)),
                ),
                verdict: self.page_verdict(),
                facts: Vec::new(),
                version: facts.version.clone(),
                command: facts.command.clone(),
                method: "Least-squares line over all readings; repeatability from readings of one point and \
                         direction; intervals are 95 %, Student's t and χ². Terms as in IEEE Std 528."
                    .into(),
                limits,
                inputs: Input::all(&facts.inputs),
            },
            rows: self.page_rows(),
            plots: self.plots(),
        }
    }

    fn page_verdict(&self) -> Rich {
        let text = self.verdict(&self.shown_small());
        let text = page_text(&text);
        let (head, rest) = match text.split_once(": ") {
            Some((head, rest)) => {
                let mut rest = rest.to_owned();
                if let Some(first) = rest.get_mut(..1) {
                    first.make_ascii_uppercase();
                }
                (format!("{head}."), format!(" {rest}"))
            }
            None => (String::new(), text),
        };
        let mut out = Rich::new().bold(head).plain(rest);
        if let Ok(h) = &self.response.hysteresis {
            let y = self.shown_small();
            out = out.plain(page_text(&format!(
                " Offset and slope can be calibrated away; hysteresis, {} {}, cannot.",
                y.number(h.value, 2),
                y.name
            )));
        }
        out
    }

    fn page_rows(&self) -> Vec<ResponseRow> {
        self.rows()
            .into_iter()
            .map(|row| ResponseRow {
                what: match row.name {
                    "Accuracy" => "mean error",
                    "Precision" => "repeatability at equal input and direction, 1σ",
                    "Resolution" => "smallest input step seen with 95 % probability",
                    "Sensitivity" => "slope of the least-squares line",
                    "Linearity" => "largest departure of a point's mean from the line",
                    "Hysteresis" => "largest difference, up to down",
                    "Asymmetry" => "slope above zero less slope below",
                    "Threshold" => "the smallest input that is answered",
                    "Dead band" => "inputs around zero that are not answered",
                    _ => "",
                }
                .to_owned(),
                term: row.name.to_owned(),
                value: page_text(&row.value),
                unit: page_unit(&row.unit.replace("% of FS", "% of full scale")),
                more: page_text(
                    &row.more
                        .replace("mean error; one reading", "a single reading:"),
                ),
            })
            .collect()
    }

    /// The picture: residuals and target, then output against input and hysteresis.
    pub fn svg(&self) -> Svg {
        let plots = self.plots();
        let mut first = vec![plots.residuals()];
        if !plots.target.is_empty() {
            first.push(plots.target());
        }
        let mut second = vec![plots.line()];
        if !plots.hysteresis.is_empty() {
            second.push(plots.hysteresis());
        }
        let row = |figures: Vec<sagnac_report::plots::Figure>| -> Vec<Svg> {
            figures
                .iter()
                .map(|figure| figure.svg.captioned(&figure.caption, &figure.caption_rest))
                .collect()
        };
        Svg::sheet(
            &page_text(&self.verdict(&self.shown_small())),
            &[row(first), row(second)],
        )
    }
}

/// With a capital.
fn sentence(text: &str) -> String {
    let mut out = text.to_owned();
    if let Some(first) = out.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    out
}
