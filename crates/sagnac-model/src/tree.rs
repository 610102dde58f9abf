//! A TOML document as a plain tree whose every node and key knows its line.

use crate::error::Error;
use crate::units::clip;
use std::ops::Range;
use toml_edit::{Document, Item, TableLike, Value};

/// No model file is longer; the catalogue's longest is under 20 kB, a covariance of 300 parameters about 1 MB.
const LONGEST_FILE: usize = 8 << 20;

#[derive(Debug)]
pub(crate) enum Content {
    Text(String),
    Number(f64),
    List(Vec<Node>),
    Table(Vec<Member>),
    Other(&'static str),
}

#[derive(Debug)]
pub(crate) struct Node {
    pub(crate) line: usize,
    pub(crate) content: Content,
}

#[derive(Debug)]
pub(crate) struct Member {
    pub(crate) key: String,
    pub(crate) line: usize,
    pub(crate) node: Node,
}

impl Node {
    /// What it is, with its article.
    pub(crate) fn kind(&self) -> &'static str {
        match &self.content {
            Content::Text(_) => "a text",
            Content::Number(_) => "a number",
            Content::List(_) => "a list",
            Content::Table(_) => "a table",
            Content::Other(kind) => kind,
        }
    }

    pub(crate) fn table(&self) -> Option<&[Member]> {
        match &self.content {
            Content::Table(members) => Some(members),
            _ => None,
        }
    }

    pub(crate) fn list(&self) -> Option<&[Node]> {
        match &self.content {
            Content::List(items) => Some(items),
            _ => None,
        }
    }

    pub(crate) fn text(&self) -> Option<&str> {
        match &self.content {
            Content::Text(text) => Some(text),
            _ => None,
        }
    }
}

/// Line numbers of byte offsets.
struct Lines(Vec<usize>);

impl Lines {
    fn new(text: &str) -> Self {
        Self(
            text.bytes()
                .enumerate()
                .filter(|(_, byte)| *byte == b'\n')
                .map(|(at, _)| at)
                .collect(),
        )
    }

    fn of(&self, span: Option<Range<usize>>) -> usize {
        span.map_or(1, |span| {
            self.0.partition_point(|end| *end < span.start) + 1
        })
    }
}

/// Parses a text; `label` names it in errors.
pub(crate) fn parse<'a>(text: &'a str, label: &str) -> Result<(Document<&'a str>, Node), Error> {
    if text.len() > LONGEST_FILE {
        return Err(Error::File {
            what: format!("a file of {} MB is no model file", text.len() >> 20),
            place: label.to_string(),
            advice: None,
        });
    }
    let lines = Lines::new(text);
    let document = Document::parse(text).map_err(|error| {
        let message = error
            .message()
            .lines()
            .next()
            .unwrap_or("it is no TOML")
            .to_string();
        Error::File {
            what: format!("the file cannot be read as TOML, {}", clip(&message)),
            place: format!("{label}, line {}", lines.of(error.span())),
            advice: Some(
                "text values stand in quotes, for instance range = \"450 deg/s\"".to_string(),
            ),
        }
    })?;
    let root = Node {
        line: 1,
        content: Content::Table(members(document.as_table(), &lines)),
    };
    Ok((document, root))
}

fn members(table: &dyn TableLike, lines: &Lines) -> Vec<Member> {
    let mut found: Vec<Member> = table
        .iter()
        .filter(|(_, item)| !item.is_none())
        .map(|(key, item)| {
            let node = item_node(item, lines);
            let line = table
                .key(key)
                .and_then(toml_edit::Key::span)
                .map_or(node.line, |span| lines.of(Some(span)));
            Member {
                key: key.to_string(),
                line,
                node,
            }
        })
        .collect();
    // Errors are found in the order of the file.
    found.sort_by_key(|member| member.line);
    found
}

fn item_node(item: &Item, lines: &Lines) -> Node {
    let line = lines.of(item.span());
    let content = match item {
        Item::Value(value) => return value_node(value, lines),
        Item::Table(table) => Content::Table(members(table, lines)),
        Item::ArrayOfTables(tables) => Content::List(
            tables
                .iter()
                .map(|table| Node {
                    line: lines.of(table.span()),
                    content: Content::Table(members(table, lines)),
                })
                .collect(),
        ),
        Item::None => Content::Other("nothing"),
    };
    Node { line, content }
}

fn value_node(value: &Value, lines: &Lines) -> Node {
    let content = match value {
        Value::String(text) => Content::Text(text.value().clone()),
        Value::Integer(number) => Content::Number(*number.value() as f64),
        Value::Float(number) => Content::Number(*number.value()),
        Value::Array(array) => {
            Content::List(array.iter().map(|value| value_node(value, lines)).collect())
        }
        Value::InlineTable(table) => Content::Table(members(table, lines)),
        Value::Boolean(_) => Content::Other("true or false"),
        Value::Datetime(_) => Content::Other("a date"),
    };
    Node {
        line: lines.of(value.span()),
        content,
    }
}
