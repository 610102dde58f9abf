//! The answer of `budget` as JSON and as text.

use sagnac_report::text::{Align, Cell, Document, Style, Table, duration, significant};
use serde_json::{Value, json};

use super::{BudgetOutcome, Candidate, Figure};

impl BudgetOutcome {
    /// `{"met_by", "nearest", "needed", "skipped", …}` of interfaces.md §4.
    pub fn to_json(&self) -> Value {
        let list = |of: &[Candidate]| -> Vec<Value> {
            of.iter()
                .map(|c| {
                    let mut v = json!({
                        "sensor": c.sensor,
                        "cep_m": c.cep_m,
                        "invalid_because": c.doubts,
                        "r95_m": c.r95_m,
                        "price_class": c.price.as_ref().map(|p| p.0),
                        "price_evidence": c.price.as_ref().map(|p| p.1.as_str()),
                    });
                    if let Some((value, interval)) = &c.confirmed {
                        let name = if self.figure == Figure::Cep { "cep" } else { "r95" };
                        v["monte_carlo"] = json!({ format!("{name}_m"): value, format!("{name}_ci_m"): interval, "within": *value <= self.limit_m });
                    }
                    v
                })
                .collect()
        };
        json!({
            "figure": if self.figure == Figure::Cep { "cep" } else { "r95" },
            "limit_m": self.limit_m,
            "after_s": self.after_s,
            "trajectory": self.trajectory,
            "met_by": list(&self.met_by),
            "nearest": list(&self.nearest),
            "needed": self.needed.iter().map(|n| json!({ "parameter": n.parameter, "value": n.value, "unit": n.unit })).collect::<Vec<_>>(),
            "scale_all": self.scale_all,
            "own": self.own.as_ref().map(|(name, cep, r95)| json!({ "sensor": name, "cep_m": cep, "r95_m": r95 })),
            "missing": self.missing,
            "skipped": self.skipped,
        })
    }

    /// Warnings for standard error.
    pub fn warnings(&self) -> Vec<String> {
        let mut out: Vec<String> = crate::drift::warning_of_missing(&self.missing)
            .into_iter()
            .collect();
        let shown = self.met_by.iter().chain(&self.nearest);
        out.extend(shown.flat_map(|c| c.doubts.iter().map(move |d| format!("{}: {d}", c.sensor))));
        out
    }

    fn kilometres(&self, value_m: f64) -> String {
        if self.limit_m >= 500.0 {
            format!("{} km", significant(value_m / 1000.0, 2))
        } else {
            format!("{} m", significant(value_m, 2))
        }
    }

    /// The result as people read it.
    pub fn document(&self) -> Document {
        let mut doc = Document::new();
        let limit = crate::drift::length_text(self.limit_m);
        let time = duration(self.after_s);
        let figure = self.figure.words();
        let total = self.asked;
        if let Some((name, cep, r95)) = &self.own {
            let own = if self.figure == Figure::Cep {
                *cep
            } else {
                *r95
            };
            let scale = self.scale_all.unwrap_or(f64::INFINITY);
            if own == 0.0 {
                doc.paragraph(format!(
                    "{name} has no error that moves the position after {time} in `{}`: the model states none.",
                    self.trajectory
                ));
            } else if own <= self.limit_m {
                doc.paragraph(format!("{name} keeps a {figure} of {limit} after {time} in `{}`: {}. All its errors could be {} times as large.", self.trajectory, self.kilometres(own), significant(scale, 2)));
            } else {
                doc.paragraph(format!("{name} does not keep a {figure} of {limit} after {time} in `{}`: {}. All its errors would have to be {} times smaller.", self.trajectory, self.kilometres(own), significant(1.0 / scale, 2)));
            }
            doc.blank();
        }
        if self.met_by.is_empty() {
            doc.paragraph(format!(
                "None of the catalogue's sensors keeps a {figure} of {limit} after {time} in `{}`.",
                self.trajectory
            ));
        } else {
            let verb = if self.met_by.len() == 1 {
                "keeps"
            } else {
                "keep"
            };
            doc.paragraph(format!("{} of {total} sensors {verb} a {figure} of {limit} after {time} in `{}`, the cheapest first:", self.met_by.len(), self.trajectory)).blank();
            let confirmed = self.met_by.iter().any(|c| c.confirmed.is_some());
            let mut heading = vec!["sensor", "CEP", "R95", "price class", "evidence"];
            let mut aligns = vec![
                Align::Left,
                Align::Right,
                Align::Right,
                Align::Left,
                Align::Left,
            ];
            if confirmed {
                heading.insert(3, "Monte Carlo");
                aligns.insert(3, Align::Left);
            }
            let mut table = Table::new(&heading, &aligns);
            for c in &self.met_by {
                let (class, evidence) = c
                    .price
                    .as_ref()
                    .map_or(("-", "-"), |(class, evidence)| (*class, evidence.as_str()));
                let mut cells = vec![
                    Cell::from(sagnac_report::text::cut(&c.sensor, 16)),
                    Cell::from(self.kilometres(c.cep_m)),
                    Cell::from(self.kilometres(c.r95_m)),
                    Cell::from(class),
                    Cell::from(sagnac_report::text::cut(evidence, 25)),
                ];
                if confirmed {
                    cells.insert(
                        3,
                        Cell::from(
                            c.confirmed
                                .as_ref()
                                .map_or("-".to_owned(), |(v, _)| self.kilometres(*v)),
                        ),
                    );
                }
                table.row(cells);
            }
            doc.table(table);
        }
        doc.blank();
        if !self.nearest.is_empty() {
            let names: Vec<String> = self
                .nearest
                .iter()
                .map(|c| {
                    format!(
                        "{} {}",
                        c.sensor,
                        self.kilometres(if self.figure == Figure::Cep {
                            c.cep_m
                        } else {
                            c.r95_m
                        })
                    )
                })
                .collect();
            doc.paragraph(format!("nearest that do not: {}", names.join(", ")));
        }
        doc.line(if self.own.is_some() {
            "each of these could be as large as this, the others as they are:"
        } else {
            "alone, each of these would use up the whole limit:"
        });
        let mut table = Table::new(&["", ""], &[Align::Left, Align::Left]);
        for n in &self.needed {
            let value = n.value.map_or_else(
                || {
                    if self.own.is_some() {
                        "the others alone exceed the limit".to_owned()
                    } else {
                        "no effect here".to_owned()
                    }
                },
                |v| value_in_field(&n.parameter, v),
            );
            table.row([Cell::from(n.parameter.clone()), Cell::from(value)]);
        }
        doc.table(table);
        if self.own.is_none() {
            doc.line("If m of them act together, each may have 1/√m of its value.");
        }
        if self.skipped > 0 {
            doc.paragraph(format!(
                "{} sensors were left out: they lack a number the question needs.",
                self.skipped
            ));
        }
        doc
    }

    /// The result as text of at most 80 columns.
    pub fn to_text(&self) -> String {
        self.document().render(Style::PLAIN)
    }
}

fn value_in_field(path: &str, value_si: f64) -> String {
    use sagnac_report::text::Unit;
    let unit = match path {
        "gyro.bias.stability" | "gyro.bias.instability.coefficient" => Unit::DEG_PER_H,
        "gyro.noise.angle_random_walk" => Unit::DEG_PER_SQRT_H,
        "accel.bias.stability" | "accel.bias.instability.coefficient" if value_si >= 9.8e-3 => {
            Unit::MILLI_G
        }
        "accel.bias.stability" | "accel.bias.instability.coefficient" => Unit::MICRO_G,
        "accel.noise.velocity_random_walk" => Unit::M_PER_S_PER_SQRT_H,
        "gyro.misalignment.stability" | "accel.misalignment.stability" => Unit::MILLI_RAD,
        _ => Unit::PPM,
    };
    format!("{} {}", significant(unit.from_si(value_si), 2), unit.text)
}
