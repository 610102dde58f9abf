//! GTSAM code read, never run: the covariances that a Python or C++ file sets, from the expressions people write.
//!
//! Known are numbers, names assigned before, `+ - * / **`, powers and roots, and the ways to write an identity or a
//! diagonal matrix: `v * I_3x3`, `v**2 * np.eye(3)`, `Matrix3::Identity() * pow(v, 2)`, `np.diag([a, b, c])`. Anything else
//! is refused by name and line, since a covariance half read is a wrong one.

use super::flat::Flat;
use std::collections::HashMap;

/// Deeper expressions are no configuration.
const DEEPEST: usize = 40;
/// Longer lists are no covariance.
const LONGEST_LIST: usize = 64;

/// What the setters and the members of the parameters end with, and how many numbers their diagonal has.
const TARGETS: [(&str, usize); 11] = [
    ("setGyroscopeCovariance", 3),
    ("setAccelerometerCovariance", 3),
    ("setBiasOmegaCovariance", 3),
    ("setBiasAccCovariance", 3),
    ("setBiasAccOmegaInit", 6),
    ("gyroscopeCovariance", 3),
    ("accelerometerCovariance", 3),
    ("biasOmegaCovariance", 3),
    ("biasAccCovariance", 3),
    ("biasAccOmegaInt", 6),
    ("biasAccOmegaInit", 6),
];

#[derive(Debug, Clone, PartialEq)]
enum Value {
    Number(f64),
    /// A list of Python: times a whole number it repeats.
    List(Vec<Value>),
    /// An array: arithmetic goes element by element.
    Array(Vec<Value>),
    Diagonal(Vec<f64>),
}

impl Value {
    /// How many numbers it holds: lists of lists would grow by powers.
    fn count(&self) -> usize {
        match self {
            Self::Number(_) => 1,
            Self::List(values) | Self::Array(values) => {
                1 + values.iter().map(Self::count).sum::<usize>()
            }
            Self::Diagonal(values) => values.len(),
        }
    }
}

/// The covariances that a file sets, as diagonals (one number where all are equal).
pub(crate) fn gtsam(text: &str) -> Flat {
    let cpp = ["::", "->", "#include"]
        .iter()
        .any(|mark| text.contains(mark));
    let code = masked(text, cpp);
    let mut flat = Flat::default();
    let mut names: HashMap<String, Result<Value, String>> = HashMap::new();
    for (start, statement) in statements(&code, cpp) {
        if let Some((key, from, argument, length)) = covariance(statement) {
            let place = start + from;
            let diagonal = evaluate(argument, &names).and_then(|value| diagonal(value, length));
            match diagonal {
                Ok(values) => flat.put(&key, values, place..place + argument.len(), argument),
                Err(why) => flat.problem(
                    place,
                    format!("`{key}` cannot be read: {why}, in `{}`", shown(argument)),
                ),
            }
        } else if let Some((name, expression)) = assignment(statement) {
            names.insert(name, evaluate(expression, &names));
        }
    }
    flat
}

fn shown(argument: &str) -> String {
    crate::units::clip(&argument.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The text with comments and the insides of strings as spaces, byte for byte.
fn masked(text: &str, cpp: bool) -> String {
    let bytes = text.as_bytes();
    let mut out = bytes.to_vec();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        let end = if !cpp && rest[0] == b'#' || cpp && rest.starts_with(b"//") {
            rest.iter().position(|byte| *byte == b'\n')
        } else if cpp && rest.starts_with(b"/*") {
            text.get(at + 2..).and_then(|t| t.find("*/")).map(|p| p + 4)
        } else if !cpp && (rest.starts_with(b"\"\"\"") || rest.starts_with(b"'''")) {
            let mark = if rest[0] == b'"' { "\"\"\"" } else { "'''" };
            text.get(at + 3..).and_then(|t| t.find(mark)).map(|p| p + 6)
        } else if rest[0] == b'"' || rest[0] == b'\'' {
            rest[1..]
                .iter()
                .position(|byte| *byte == rest[0] || *byte == b'\n')
                .map(|p| p + 2)
        } else {
            at += 1;
            continue;
        };
        let end = at + end.unwrap_or(rest.len());
        for byte in &mut out[at..end] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
        at = end;
    }
    String::from_utf8(out).unwrap_or_default()
}

/// Statements with their places: to the line's end in Python, to `;` or a brace in C++; brackets hold lines together.
fn statements(code: &str, cpp: bool) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let (mut start, mut depth) = (0, 0_i32);
    for (at, c) in code.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            _ => {}
        }
        let ends = match c {
            ';' => depth <= 0,
            '\n' => !cpp && depth <= 0,
            '{' | '}' => cpp,
            _ => false,
        };
        if ends {
            found.push((start, &code[start..at]));
            start = at + 1;
            depth = 0;
        }
    }
    found.push((start, code.get(start..).unwrap_or_default()));
    found
}

/// A statement that sets a covariance: its key, and the place, text and size of what is set.
fn covariance(statement: &str) -> Option<(String, usize, &str, usize)> {
    let name_end = |end: usize| {
        statement[..end]
            .rfind(|c: char| !(c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | '>')))
            .map_or(0, |at| {
                at + statement[at..].chars().next().map_or(1, char::len_utf8)
            })
    };
    for (target, length) in TARGETS {
        let Some(at) = statement.find(target) else {
            continue;
        };
        let end = at + target.len();
        let before = statement[..at].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let key = statement[name_end(at)..end].to_string();
        let rest = &statement[end..];
        let inner = end + (rest.len() - rest.trim_start().len()) + 1;
        let trimmed = rest.trim_start();
        let argument = if target.starts_with("set") && trimmed.starts_with('(') {
            let close = closing(statement.get(inner..)?)?;
            &statement[inner..inner + close]
        } else if !target.starts_with("set")
            && trimmed.starts_with('=')
            && !trimmed.starts_with("==")
        {
            statement.get(inner..)?
        } else {
            continue;
        };
        let from = inner + (argument.len() - argument.trim_start().len());
        return Some((key, from, argument.trim(), length));
    }
    None
}

/// Where the bracket that is open at the begin closes.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0_i32;
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' if depth == 0 => return Some(at),
            ')' | ']' => depth -= 1,
            _ => {}
        }
    }
    None
}

/// `name = expression`, with a type before the name or without.
fn assignment(statement: &str) -> Option<(String, &str)> {
    let mut depth = 0_i32;
    let at = statement.char_indices().find_map(|(at, c)| {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            _ => {}
        }
        (c == '=' && depth == 0).then_some(at)
    })?;
    let rest = &statement[at + 1..];
    let left = statement[..at].trim_end();
    if rest.starts_with('=') || left.ends_with(['=', '!', '<', '>']) {
        return None;
    }
    // `v *= 2` makes a name that is not known any more.
    let changed = left.ends_with(['+', '-', '*', '/']);
    let left = left.trim_end_matches(['+', '-', '*', '/', ' ']);
    // Python may state a type behind the name.
    let left = left.split(": ").next().unwrap_or(left);
    let name = left
        .split_whitespace()
        .last()?
        .trim_start_matches(['&', '*']);
    let plain = name
        .chars()
        .all(|c| c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | '>'));
    plain.then(|| (name.to_string(), if changed { "" } else { rest.trim() }))
}

fn diagonal(value: Value, length: usize) -> Result<Vec<f64>, String> {
    let values = match value {
        Value::Diagonal(values) => values,
        Value::Array(rows) | Value::List(rows) => of_rows(&rows)?,
        Value::Number(_) => return Err("a number stands where a matrix is wanted".into()),
    };
    if values.len() != length {
        return Err(format!(
            "a matrix of {0} x {0} is wanted, not {1} x {1}",
            length,
            values.len()
        ));
    }
    if !values.iter().all(|value| value.is_finite()) {
        return Err("a number is not finite".into());
    }
    Ok(
        if length == 3 && values.iter().all(|value| *value == values[0]) {
            vec![values[0]]
        } else {
            values
        },
    )
}

/// The diagonal of a matrix that is written out.
fn of_rows(rows: &[Value]) -> Result<Vec<f64>, String> {
    let mut values = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let (Value::List(cells) | Value::Array(cells)) = row else {
            return Err("a list stands where a matrix is wanted".into());
        };
        if cells.len() != rows.len() {
            return Err("the matrix is not square".into());
        }
        for (j, cell) in cells.iter().enumerate() {
            match cell {
                Value::Number(value) if i == j => values.push(*value),
                Value::Number(value) if *value == 0.0 => {}
                Value::Number(_) => return Err("the matrix has terms off its diagonal".into()),
                _ => return Err("the matrix is not one of numbers".into()),
            }
        }
    }
    Ok(values)
}

fn evaluate(text: &str, names: &HashMap<String, Result<Value, String>>) -> Result<Value, String> {
    let mut parser = Parser {
        rest: text.trim(),
        names,
        depth: 0,
    };
    let value = parser.sum()?;
    if parser.rest.is_empty() {
        Ok(value)
    } else {
        Err(format!("`{}` is not understood", word(parser.rest)))
    }
}

/// The first word or sign of a text.
fn word(text: &str) -> String {
    let end = text
        .find(|c: char| !(c.is_alphanumeric() || matches!(c, '_' | '.' | ':')))
        .unwrap_or(text.len());
    let end = if end == 0 {
        text.chars().next().map_or(0, char::len_utf8)
    } else {
        end
    };
    crate::units::clip(&text[..end])
}

struct Parser<'a> {
    rest: &'a str,
    names: &'a HashMap<String, Result<Value, String>>,
    depth: usize,
}

impl Parser<'_> {
    fn take(&mut self, sign: &str) -> bool {
        let found = self.rest.strip_prefix(sign);
        if let Some(rest) = found {
            self.rest = rest.trim_start();
        }
        found.is_some()
    }

    fn sum(&mut self) -> Result<Value, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err("brackets are nested too deep".into());
        }
        let mut value = self.term()?;
        loop {
            if self.take("+") {
                value = added(value, self.term()?)?;
            } else if self.take("-") {
                let right = multiplied(Value::Number(-1.0), self.term()?)?;
                value = added(value, right)?;
            } else {
                self.depth -= 1;
                return Ok(value);
            }
        }
    }

    fn term(&mut self) -> Result<Value, String> {
        let mut value = self.power()?;
        loop {
            if self.rest.starts_with("//") {
                return Err("`//` is not understood".into());
            }
            if self.take("*") || self.take("@") {
                value = multiplied(value, self.power()?)?;
            } else if self.take("/") {
                let Value::Number(by) = self.power()? else {
                    return Err("a division by a matrix is not understood".into());
                };
                value = each(value, &|v| v / by);
            } else {
                return Ok(value);
            }
        }
    }

    fn power(&mut self) -> Result<Value, String> {
        // -2 ** 2 is -4.
        if self.take("-") {
            self.depth += 1;
            if self.depth > DEEPEST {
                return Err("signs are nested too deep".into());
            }
            let value = multiplied(Value::Number(-1.0), self.power()?);
            self.depth -= 1;
            return value;
        }
        let base = self.primary()?;
        if self.take("**") {
            self.depth += 1;
            if self.depth > DEEPEST {
                return Err("powers are nested too deep".into());
            }
            let Value::Number(power) = self.power()? else {
                return Err("a power is no number".into());
            };
            self.depth -= 1;
            return Ok(each(base, &|v| raised(v, power)));
        }
        Ok(base)
    }

    fn primary(&mut self) -> Result<Value, String> {
        let mut value = self.atom()?;
        // Methods of a value: .asDiagonal(), .finished().
        while self.rest.starts_with('.') {
            let name = word(&self.rest[1..]);
            let after = self.rest.get(1 + name.len()..).unwrap_or_default();
            if !after.starts_with("()") {
                return Err(format!("`.{name}` is not understood"));
            }
            self.rest = after[2..].trim_start();
            value = match name.as_str() {
                "asDiagonal" => make_diagonal(value)?,
                "finished" | "eval" | "matrix" | "copy" | "toDenseMatrix" => value,
                _ => return Err(format!("`.{name}()` is not understood")),
            };
        }
        Ok(value)
    }

    fn atom(&mut self) -> Result<Value, String> {
        if self.take("(") {
            let value = self.sum()?;
            return if self.take(")") {
                Ok(value)
            } else {
                Err("a bracket is not closed".into())
            };
        }
        if self.take("[") {
            return Ok(Value::List(self.arguments("]")?));
        }
        if let Some(length) = crate::units::number_length(self.rest) {
            let value = self.rest[..length].parse().unwrap_or(f64::NAN);
            let rest = &self.rest[length..];
            // 1e-3f of C++.
            let rest = rest
                .strip_prefix('f')
                .filter(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
                .unwrap_or(rest);
            if rest.starts_with(|c: char| c.is_alphanumeric() || c == '_') {
                return Err(format!("`{}` is no number", word(self.rest)));
            }
            self.rest = rest.trim_start();
            return Ok(Value::Number(value));
        }
        let mut end = 0;
        let is_name = |c: char| c.is_alphanumeric() || c == '_';
        while let Some(c) = self.rest[end..].chars().next() {
            let tail = &self.rest[end..];
            if is_name(c) {
                end += c.len_utf8();
            } else if end > 0 && c == '.' && tail[1..].starts_with(is_name) {
                end += 1;
            } else if end > 0
                && (tail.starts_with("::") || tail.starts_with("->"))
                && tail[2..].starts_with(is_name)
            {
                end += 2;
            } else {
                break;
            }
        }
        if end == 0 {
            return Err(if self.rest.is_empty() {
                "something is missing".into()
            } else {
                format!("`{}` is not understood", word(self.rest))
            });
        }
        let name = &self.rest[..end];
        self.rest = self.rest[end..].trim_start();
        if self.take("(") {
            let arguments = self.arguments(")")?;
            return call(name, arguments);
        }
        self.named(name)
    }

    fn arguments(&mut self, close: &str) -> Result<Vec<Value>, String> {
        let mut values = Vec::new();
        let mut count = 0;
        while !self.take(close) {
            let value = self.sum()?;
            count += value.count();
            if count > LONGEST_LIST {
                return Err("a list is too long".into());
            }
            values.push(value);
            if !self.take(",") && !self.rest.starts_with(close) {
                return Err(if self.rest.is_empty() {
                    "a bracket is not closed".into()
                } else {
                    format!("`{}` is not understood", word(self.rest))
                });
            }
        }
        Ok(values)
    }

    fn named(&self, name: &str) -> Result<Value, String> {
        if let Some(known) = self.names.get(name) {
            // The first names tell enough, and a long chain of them would grow without end.
            return known.clone().map_err(|why| match why.len() {
                ..200 => format!("{why} (in `{}`)", crate::units::clip(name)),
                _ => why,
            });
        }
        let last = name.rsplit(['.', ':', '>']).next().unwrap_or(name);
        match last {
            "I_3x3" => Ok(Value::Diagonal(vec![1.0; 3])),
            "I_6x6" => Ok(Value::Diagonal(vec![1.0; 6])),
            "Z_3x3" => Ok(Value::Diagonal(vec![0.0; 3])),
            "pi" | "M_PI" => Ok(Value::Number(std::f64::consts::PI)),
            _ => Err(format!(
                "the file does not say what `{}` is",
                crate::units::clip(name)
            )),
        }
    }
}

/// The functions people build covariances with, by the last part of their name.
fn call(name: &str, arguments: Vec<Value>) -> Result<Value, String> {
    let last = name.rsplit(['.', ':', '>']).next().unwrap_or(name);
    let unknown = || {
        Err(format!(
            "`{}(…)` is not understood",
            crate::units::clip(name)
        ))
    };
    let size = |value: Option<&Value>| match value {
        Some(Value::Number(n)) if *n >= 1.0 && *n <= LONGEST_LIST as f64 && n.fract() == 0.0 => {
            Ok(*n as usize)
        }
        _ => Err(format!(
            "the size in `{}(…)` is not understood",
            crate::units::clip(name)
        )),
    };
    let pair = |arguments: &[Value]| match arguments {
        [value, Value::Number(by)] => Some((value.clone(), *by)),
        _ => None,
    };
    match (last, arguments.as_slice()) {
        ("eye" | "identity", [n]) | ("Identity", [n, _]) => {
            Ok(Value::Diagonal(vec![1.0; size(Some(n))?]))
        }
        ("Identity", []) => Ok(Value::Diagonal(vec![
            1.0;
            if name.contains('6') { 6 } else { 3 }
        ])),
        ("diag" | "diagflat", [one]) => make_diagonal(one.clone()),
        ("array" | "asarray", [Value::List(values)]) => Ok(Value::Array(values.clone())),
        ("Vector3" | "Vector3d" | "Point3", [_, _, _]) | ("Vector6", [_, _, _, _, _, _]) => {
            Ok(Value::Array(arguments))
        }
        ("Constant", [value]) => Ok(Value::Array(vec![
            value.clone();
            if name.contains('6') { 6 } else { 3 }
        ])),
        ("ones", [n]) => Ok(Value::Array(vec![Value::Number(1.0); size(Some(n))?])),
        ("full" | "repeat", [first, second]) => {
            let (n, value) = if last == "full" {
                (first, second)
            } else {
                (second, first)
            };
            Ok(Value::Array(vec![value.clone(); size(Some(n))?]))
        }
        ("pow" | "power", both) => match pair(both) {
            Some((base, power)) => Ok(each(base, &|v| raised(v, power))),
            None => unknown(),
        },
        ("square", [one]) => Ok(each(one.clone(), &|v| v * v)),
        ("sqrt", [one]) => Ok(each(one.clone(), &f64::sqrt)),
        ("deg2rad" | "radians", [one]) => Ok(each(one.clone(), &f64::to_radians)),
        ("float" | "double" | "float64", [one]) => Ok(one.clone()),
        ("block_diag", blocks) => {
            let mut values = Vec::new();
            for block in blocks {
                let Value::Diagonal(part) = block else {
                    return unknown();
                };
                values.extend(part);
            }
            Ok(Value::Diagonal(values))
        }
        _ => unknown(),
    }
}

/// Squares exactly as a product.
fn raised(value: f64, power: f64) -> f64 {
    if power == 2.0 {
        value * value
    } else {
        value.powf(power)
    }
}

fn make_diagonal(value: Value) -> Result<Value, String> {
    let (Value::List(values) | Value::Array(values)) = value else {
        return Err("a diagonal needs a list".into());
    };
    let numbers = values.into_iter().map(|value| match value {
        Value::Number(value) => Ok(value),
        _ => Err("a diagonal needs a list of numbers".to_string()),
    });
    Ok(Value::Diagonal(numbers.collect::<Result<_, _>>()?))
}

/// A function of each number.
fn each(value: Value, by: &dyn Fn(f64) -> f64) -> Value {
    match value {
        Value::Number(value) => Value::Number(by(value)),
        Value::List(values) | Value::Array(values) => {
            Value::Array(values.into_iter().map(|value| each(value, by)).collect())
        }
        // Off the diagonal stays zero: true of the powers and factors that are asked for.
        Value::Diagonal(values) => Value::Diagonal(values.into_iter().map(by).collect()),
    }
}

fn added(left: Value, right: Value) -> Result<Value, String> {
    match (left, right) {
        (Value::Number(a), Value::Number(b)) => Ok(Value::Number(a + b)),
        (Value::Diagonal(a), Value::Diagonal(b)) if a.len() == b.len() => Ok(Value::Diagonal(
            a.into_iter().zip(b).map(|(a, b)| a + b).collect(),
        )),
        (Value::List(mut a), Value::List(b)) if a.len() + b.len() <= LONGEST_LIST => {
            a.extend(b);
            Ok(Value::List(a))
        }
        _ => Err("a sum of unlike things is not understood".into()),
    }
}

fn multiplied(left: Value, right: Value) -> Result<Value, String> {
    match (left, right) {
        (Value::Number(a), Value::Number(b)) => Ok(Value::Number(a * b)),
        (Value::List(values), Value::Number(times))
        | (Value::Number(times), Value::List(values)) => {
            if !(0.0..=6.0).contains(&times) || times.fract() != 0.0 {
                return Err("a list times a number that is not whole is not understood".into());
            }
            let repeated = vec![values; times as usize].concat();
            if repeated.len() > LONGEST_LIST {
                return Err("a list is too long".into());
            }
            Ok(Value::List(repeated))
        }
        (value, Value::Number(by)) | (Value::Number(by), value) => Ok(each(value, &|v| v * by)),
        (Value::Diagonal(a), Value::Diagonal(b)) if a.len() == b.len() => Ok(Value::Diagonal(
            a.into_iter().zip(b).map(|(a, b)| a * b).collect(),
        )),
        _ => Err("a product of unlike things is not understood".into()),
    }
}

#[cfg(test)]
mod tests;
