//! Reading a model file: every key is known or refused, with a suggestion, its line and its table.

mod checks;
mod leaf;
mod tables;

pub(crate) use leaf::problem_of;

use crate::error::Error;
use crate::model::Model;
use crate::suggest::suggest;
use crate::tree::{self, Content, Member, Node};
use crate::units::{Dimension, Unit, clip, format_number, parse_with_unit};

/// Reads a whole file.
pub(crate) fn model(text: &str, label: &str) -> Result<Model, Error> {
    let (document, root) = tree::parse(text, label)?;
    let reader = Reader { label };
    let mut model = Model::new("");
    model.label = label.to_string();
    tables::root(&reader, &root, &mut model)?;
    checks::all(&reader, &root, &model)?;
    model.document = document.into_mut();
    Ok(model)
}

/// Makes errors that know the file.
pub(crate) struct Reader<'a> {
    label: &'a str,
}

impl Reader<'_> {
    /// An error at a value: `imu.toml, line 14: gyro.noise.angle_random_walk`.
    fn at_value(&self, line: usize, path: &str, what: String, advice: Option<String>) -> Error {
        Error::File {
            what,
            place: format!("{}, line {line}: {path}", self.label),
            advice,
        }
    }

    /// An error about keys: `imu.toml, line 14, in [gyro.noise]`.
    fn in_table(&self, line: usize, table: &str, what: String, advice: Option<String>) -> Error {
        let within = if table.is_empty() {
            String::new()
        } else {
            format!(", in [{table}]")
        };
        Error::File {
            what,
            place: format!("{}, line {line}{within}", self.label),
            advice,
        }
    }

    fn unknown_key(&self, member: &Member, table: &str, known: &[&str]) -> Error {
        let key = clip(&member.key);
        let suggestion = suggest(&member.key, known.iter().copied());
        let advice = suggestion.map_or_else(
            || format!("the keys here are {}", known.join(", ")),
            |name| format!("did you mean `{name}`?"),
        );
        self.in_table(
            member.line,
            table,
            format!("unknown key `{key}`"),
            Some(advice),
        )
    }

    fn expected(&self, node: &Node, path: &str, expected: &str, example: &str) -> Error {
        self.at_value(
            node.line,
            path,
            format!("expected {expected}, got {}", node.kind()),
            Some(format!("write for instance {example}")),
        )
    }

    fn text(&self, node: &Node, path: &str) -> Result<String, Error> {
        // A text may stand in a table that says more about it.
        if let Some(members) = node.table() {
            for member in members {
                if !matches!(member.key.as_str(), "value" | "source" | "note") {
                    return Err(self.unknown_key(member, path, &["value", "source", "note"]));
                }
            }
            if let Some(value) = members.iter().find(|member| member.key == "value") {
                return self.text(&value.node, path);
            }
        }
        node.text()
            .map(str::to_string)
            .ok_or_else(|| self.expected(node, path, "a text", "\"MEMS\""))
    }

    /// The model's name, which every command prints: a control character in it would rule the terminal.
    fn name(&self, node: &Node) -> Result<String, Error> {
        let name = self.text(node, "name")?;
        match name.chars().find(|c| c.is_control()) {
            Some(c) => Err(self.at_value(
                node.line,
                "name",
                format!("the name holds a control character, U+{:04X}", u32::from(c)),
                Some("write the name as plain text of one line".to_owned()),
            )),
            None => Ok(name),
        }
    }

    fn table<'n>(&self, node: &'n Node, path: &str) -> Result<&'n [Member], Error> {
        node.table()
            .ok_or_else(|| self.expected(node, path, "a table", &format!("[{path}]")))
    }

    fn list<'n>(&self, node: &'n Node, path: &str, example: &str) -> Result<&'n [Node], Error> {
        node.list()
            .ok_or_else(|| self.expected(node, path, "a list", example))
    }

    /// A quantity: a text with a unit, or a bare number where there is no dimension.
    fn quantity(
        &self,
        node: &Node,
        path: &str,
        dimension: Dimension,
    ) -> Result<(f64, Unit), Error> {
        match &node.content {
            Content::Text(text) => parse_with_unit(text, dimension)
                .map_err(|error| self.at_value(node.line, path, error.to_string(), error.advice())),
            Content::Number(number) if dimension.is_plain() && number.is_finite() => {
                Ok((*number, Unit::plain()))
            }
            Content::Number(number) if number.is_finite() => {
                let what = format!(
                    "expected {} with its unit, got a bare number: {}",
                    dimension.words(),
                    format_number(*number)
                );
                Err(self.at_value(
                    node.line,
                    path,
                    what,
                    Some(format!("write for instance \"{}\"", dimension.example())),
                ))
            }
            Content::Number(_) => Err(self.at_value(
                node.line,
                path,
                "the number is not finite".to_string(),
                None,
            )),
            _ => Err(self.expected(
                node,
                path,
                &format!("{} as text", dimension.words()),
                &format!("\"{}\"", dimension.example()),
            )),
        }
    }

    fn number(&self, node: &Node, path: &str) -> Result<f64, Error> {
        match &node.content {
            Content::Number(number) if number.is_finite() => Ok(*number),
            _ => Err(self.expected(node, path, "a finite number", "20")),
        }
    }
}
