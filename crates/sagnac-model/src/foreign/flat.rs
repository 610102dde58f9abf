//! Other tools' files as a flat list of keys with their numbers, each with its place in the text.

use std::ops::Range;

/// No configuration is longer.
pub(crate) const LONGEST: usize = 4 << 20;
/// More numbers than any configuration has.
const MOST_NUMBERS: usize = 20_000;

/// A key and the numbers under it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Item {
    /// Keys of nested tables joined by dots.
    pub(crate) key: String,
    pub(crate) numbers: Vec<f64>,
    /// Where each number stands in the text; empty for binary files.
    pub(crate) spans: Vec<Range<usize>>,
    /// The value as written; empty for binary files.
    pub(crate) raw: String,
    /// Where the key's line, or its value, begins.
    pub(crate) start: usize,
}

impl Item {
    /// Whether the value is one number, or a list of numbers, and nothing else.
    pub(crate) fn is_plain(&self) -> bool {
        let mut pieces = self
            .raw
            .split(|c: char| c.is_whitespace() || "[],;(){}".contains(c))
            .map(|piece| piece.trim_matches(['"', '\'']))
            .filter(|piece| !matches!(*piece, "" | "-" | "..." | "np.array" | "numpy.array"))
            .peekable();
        pieces.peek().is_some()
            && pieces.all(|piece| piece.parse::<f64>().is_ok_and(f64::is_finite))
    }
}

/// What cannot be read, and where in the text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Problem {
    pub(crate) start: usize,
    pub(crate) what: String,
    pub(crate) advice: &'static str,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Flat {
    pub(crate) items: Vec<Item>,
    /// What the parser could not read of a key that counts.
    pub(crate) problems: Vec<Problem>,
    count: usize,
}

impl Flat {
    pub(crate) fn get(&self, key: &str) -> Option<&[f64]> {
        self.items
            .iter()
            .find(|item| item.key == key && !item.numbers.is_empty())
            .map(|item| item.numbers.as_slice())
    }

    pub(crate) fn one(&self, key: &str) -> Option<f64> {
        self.get(key)?.first().copied()
    }

    pub(crate) fn has(&self, key: &str) -> bool {
        self.items.iter().any(|item| item.key == key)
    }

    /// Adds a key with its numbers, which all stand at one place.
    pub(crate) fn put(&mut self, key: &str, numbers: Vec<f64>, span: Range<usize>, raw: &str) {
        if self.count >= MOST_NUMBERS {
            return;
        }
        self.count += numbers.len();
        self.items.push(Item {
            key: key.to_string(),
            spans: vec![span.clone(); numbers.len()],
            numbers,
            raw: raw.to_string(),
            start: span.start,
        });
    }

    pub(crate) fn problem(&mut self, start: usize, what: String) {
        let advice = "write it with numbers, or with names that the file gives a number";
        self.problems.push(Problem {
            start,
            what,
            advice,
        });
    }

    fn add(&mut self, key: &str, value: f64, span: Range<usize>) {
        if self.count >= MOST_NUMBERS {
            return;
        }
        self.count += 1;
        match self.items.last_mut() {
            Some(last) if last.key == key => {
                last.numbers.push(value);
                last.spans.push(span);
            }
            _ => self.items.push(Item {
                key: key.to_string(),
                numbers: vec![value],
                start: span.start,
                spans: vec![span],
                raw: String::new(),
            }),
        }
    }

    fn open(&mut self, key: &str, raw: &str, start: usize) {
        if self.count < MOST_NUMBERS {
            self.count += 1;
            self.items.push(Item {
                key: key.to_string(),
                numbers: Vec::new(),
                spans: Vec::new(),
                raw: raw.trim().to_string(),
                start,
            });
        }
    }

    /// More of the value of the last key.
    fn go_on(&mut self, key: &str, raw: &str) {
        if let Some(last) = self.items.last_mut().filter(|last| last.key == key) {
            last.raw.push(' ');
            last.raw.push_str(raw);
        }
    }
}

/// The length of a number that may begin here: a decimal that is not part of a word.
fn number_at(text: &str) -> Option<usize> {
    let length = crate::units::number_length(text)?;
    let next = text[length..].chars().next();
    next.is_none_or(|c| !(c.is_alphanumeric() || c == '_'))
        .then_some(length)
}

/// The numbers of a piece of a line.
fn scan(flat: &mut Flat, key: &str, text: &str, offset: usize) {
    let mut at = 0;
    let mut boundary = true;
    while let Some(c) = text[at..].chars().next() {
        if boundary && let Some(length) = number_at(&text[at..]) {
            if let Ok(value) = text[at..at + length].parse::<f64>()
                && value.is_finite()
            {
                flat.add(key, value, offset + at..offset + at + length);
            }
            at += length;
            boundary = false;
            continue;
        }
        boundary = !(c.is_alphanumeric() || matches!(c, '_' | '.'));
        at += c.len_utf8();
    }
}

/// A line without its comment.
fn uncommented(line: &str, marks: &[char]) -> usize {
    let mut quote = None;
    for (at, c) in line.char_indices() {
        match quote {
            Some(open) if c == open => quote = None,
            None if c == '"' => quote = Some(c),
            None if marks.contains(&c) => return at,
            _ => {}
        }
    }
    line.len()
}

/// YAML as these tools write it: nested keys by indentation, scalars, flow lists, block lists of rows.
pub(crate) fn yaml(text: &str) -> Flat {
    let mut flat = Flat::default();
    let mut stack: Vec<(usize, String)> = Vec::new();
    let mut key = String::new();
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let start = offset;
        offset += line.len();
        let body = &line[..uncommented(line, &['#'])];
        let trimmed = body.trim();
        if trimmed.is_empty() || trimmed.starts_with('%') || trimmed == "---" || trimmed == "..." {
            continue;
        }
        let indent = body.len() - body.trim_start().len();
        let colon = trimmed.find(':').filter(|at| {
            let name = trimmed[..*at].trim();
            let after = trimmed[at + 1..].chars().next();
            !name.is_empty()
                && !name.starts_with(['-', '[', '{'])
                && name.len() < 100
                && after.is_none_or(char::is_whitespace)
        });
        let Some(colon) = colon else {
            flat.go_on(&key, trimmed);
            scan(&mut flat, &key, body, start);
            continue;
        };
        while stack.last().is_some_and(|(depth, _)| *depth >= indent) {
            stack.pop();
        }
        if stack.len() > 32 {
            continue;
        }
        stack.push((
            indent,
            trimmed[..colon]
                .trim()
                .trim_matches(['"', '\''])
                .to_string(),
        ));
        key = stack
            .iter()
            .map(|(_, name)| name.as_str())
            .collect::<Vec<_>>()
            .join(".");
        let value_at = indent + colon + 1;
        flat.open(&key, &body[value_at..], start + indent);
        scan(&mut flat, &key, &body[value_at..], start + value_at);
    }
    flat
}

/// The value behind the sign at `from`: to the end of the line, a comma or the bracket around it.
fn value_text(text: &str, from: usize, marks: &[char]) -> String {
    let mut value = String::new();
    let mut depth = 0_usize;
    let (mut quote, mut skip) = (None, false);
    for c in text
        .get(from..)
        .unwrap_or_default()
        .chars()
        .skip(1)
        .take(2048)
    {
        skip &= c != '\n';
        if skip {
            continue;
        }
        if quote.is_some() {
            if quote == Some(c) {
                quote = None;
            }
            value.push(c);
            continue;
        }
        match c {
            // Behind a bracket ' transposes.
            '"' | '\'' if !value.ends_with([']', ')']) => quote = Some(c),
            '\'' => continue,
            _ if marks.contains(&c) => {
                skip = true;
                continue;
            }
            '[' | '(' | '{' => depth += 1,
            ']' | ')' | '}' | ',' | ';' if depth == 0 => break,
            ']' | ')' | '}' => depth -= 1,
            '\n' if depth == 0 && !value.trim().is_empty() => break,
            _ => {}
        }
        value.push(c);
    }
    value
}

/// JSON, Python and MATLAB as assignments of literals: a key before `:` or `=`, the numbers up to the next key.
pub(crate) fn assignments(text: &str, marks: &[char]) -> Flat {
    let mut flat = Flat::default();
    let mut key = String::new();
    let mut scope = String::new();
    let mut depth = 0_usize;
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let start = offset;
        offset += line.len();
        let body = &line[..uncommented(line, marks)];
        let mut at = 0;
        while let Some(c) = body[at..].chars().next() {
            let rest = &body[at..];
            let (word, after) = if matches!(c, '"' | '\'') {
                let Some(end) = rest[1..].find(c) else { break };
                (&rest[1..=end], &rest[end + 2..])
            } else if c.is_alphabetic() || c == '_' {
                let end = rest
                    .find(|c: char| !(c.is_alphanumeric() || matches!(c, '_' | '.')))
                    .unwrap_or(rest.len());
                (&rest[..end], &rest[end..])
            } else {
                if let Some(length) = number_at(rest) {
                    scan(&mut flat, &key, &rest[..length], start + at);
                    at += length;
                    continue;
                }
                match c {
                    '(' => depth += 1,
                    ')' => depth = depth.saturating_sub(1),
                    _ => {}
                }
                if depth == 0 && c == ')' {
                    scope.clear();
                }
                at += c.len_utf8();
                continue;
            };
            let next = after.trim_start();
            let quoted = matches!(c, '"' | '\'');
            let assigned =
                next.starts_with(':') || (next.starts_with('=') && !next.starts_with("=="));
            let named = quoted && next.starts_with(',') && marks.contains(&'%');
            if assigned || named {
                if depth == 0 && next.starts_with('=') && next.trim_end().ends_with('(') {
                    scope = word.to_string();
                }
                key = if scope.is_empty() || word == scope {
                    word.to_string()
                } else {
                    format!("{scope}.{word}")
                };
                let value_at = start + body.len() - next.len();
                if flat.count < MOST_NUMBERS {
                    flat.open(&key, &value_text(text, value_at, marks), value_at);
                }
            }
            at = body.len() - after.len();
        }
    }
    flat
}

/// XML: the numbers in elements, by the names of the elements around them.
pub(crate) fn xml(text: &str) -> Flat {
    let mut flat = Flat::default();
    let mut stack: Vec<&str> = Vec::new();
    let mut at = 0;
    while let Some(open) = text[at..].find('<') {
        let begin = at + open;
        let content = &text[at..begin];
        if !content.trim().is_empty() && stack.len() > 1 {
            let from = at + (content.len() - content.trim_start().len());
            let key = stack.join(".");
            flat.open(&key, content, from);
            if let Some(length) = number_at(&text[from..])
                && length == content.trim().len()
                && let Ok(value) = text[from..from + length].parse::<f64>()
                && value.is_finite()
            {
                flat.add(&key, value, from..from + length);
            }
        }
        let rest = &text[begin..];
        if rest.starts_with("<!--") {
            let Some(end) = rest.find("-->") else { break };
            at = begin + end + 3;
            continue;
        }
        let Some(end) = rest.find('>') else { break };
        let tag = &rest[1..end];
        at = begin + end + 1;
        if let Some(name) = tag.strip_prefix('/') {
            if let Some(place) = stack.iter().rposition(|open| *open == name.trim()) {
                stack.truncate(place);
            }
        } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) && stack.len() < 64 {
            stack.push(tag.split_whitespace().next().unwrap_or(""));
        }
    }
    flat
}

/// Parameter lists: `1 1 NAME VALUE TYPE`, or `NAME,VALUE`.
pub(crate) fn parameters(text: &str) -> Flat {
    let mut flat = Flat::default();
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let start = offset;
        offset += line.len();
        let body = &line[..uncommented(line, &['#'])];
        let cells: Vec<&str> = body
            .split(|c: char| c.is_whitespace() || c == ',')
            .filter(|cell| !cell.is_empty())
            .collect();
        let Some(place) = cells
            .iter()
            .position(|cell| cell.starts_with(|c: char| c.is_ascii_uppercase()))
        else {
            continue;
        };
        let Some(value) = cells.get(place + 1) else {
            continue;
        };
        // The value's place: cells are parts of this line.
        let from = start + (value.as_ptr() as usize - line.as_ptr() as usize);
        flat.open(cells[place], value, from);
        if let Ok(number) = value.parse::<f64>()
            && number.is_finite()
        {
            flat.add(cells[place], number, from..from + value.len());
        }
    }
    flat
}

/// The fields of a struct in a MAT file.
pub(crate) fn fields(fields: Vec<(String, Vec<f64>)>) -> Flat {
    let items = fields
        .into_iter()
        .map(|(key, numbers)| Item {
            key,
            numbers,
            spans: Vec::new(),
            raw: String::new(),
            start: 0,
        })
        .collect();
    Flat {
        items,
        ..Flat::default()
    }
}
