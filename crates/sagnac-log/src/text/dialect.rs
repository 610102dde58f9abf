//! How a text table is written: separator, comments, preamble, header. Found from its first lines.
//!
//! The separator is the one that gives the most numbers in equally wide rows; the table's width is the commonest
//! number of cells; leading lines of another width are the preamble.

use super::number::whole_f64;
use crate::Error;
use crate::map::columns::{Role, clip};
use crate::map::raw::{Cells, RawColumn};

/// How cells are parted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Separator {
    Byte(u8),
    /// Runs of spaces and tabs.
    Spaces,
}

/// What the first lines say.
#[derive(Debug, Clone)]
pub(crate) struct Dialect {
    pub(crate) separator: Separator,
    /// Cells in a row.
    pub(crate) width: usize,
    pub(crate) columns: Vec<RawColumn>,
    pub(crate) has_header: bool,
    /// Line of the header, from 1.
    pub(crate) header_line: Option<u64>,
    /// Lines before the table that belong to nothing.
    pub(crate) preamble: u64,
    /// Byte at which the data begin, and how many lines stand before.
    pub(crate) body_start: usize,
    pub(crate) body_line: u64,
}

struct Line<'a> {
    text: &'a [u8],
    number: u64,
    start: usize,
    end: usize,
    is_comment: bool,
}

/// Rows looked at for text columns and hints.
const PREVIEW_ROWS: usize = 500;

pub(crate) fn is_comment(line: &[u8]) -> bool {
    matches!(line.trim_ascii_start().first(), Some(b'#' | b'%'))
}

/// Where the quoted cell that `text` begins with is closed; a quote within is written twice.
pub(crate) fn closing_quote(text: &[u8]) -> Option<usize> {
    let mut at = 1;
    loop {
        at += memchr::memchr(b'"', text.get(at..)?)?;
        if text.get(at + 1) != Some(&b'"') {
            return Some(at);
        }
        at += 2;
    }
}

/// Cells of a line as they stand there, quotes and all.
pub(crate) fn raw_cells(line: &[u8], separator: Separator) -> Vec<&[u8]> {
    let mut out = Vec::new();
    let mut rest = line;
    if separator == Separator::Spaces {
        rest = rest.trim_ascii();
    }
    loop {
        let quoted = rest.trim_ascii_start();
        let from = if quoted.first() == Some(&b'"') {
            let body = closing_quote(quoted).map_or(quoted.len(), |end| end + 1);
            rest.len() - quoted.len() + body
        } else {
            0
        };
        let is_end = |c: &u8| match separator {
            Separator::Byte(b) => *c == b,
            Separator::Spaces => *c == b' ' || *c == b'\t',
        };
        let Some(end) = rest[from..].iter().position(is_end) else {
            out.push(rest);
            return out;
        };
        out.push(&rest[..from + end]);
        rest = &rest[from + end + 1..];
        if separator == Separator::Spaces {
            rest = rest.trim_ascii_start();
        }
    }
}

/// A cell without its quotes and the spaces around it.
pub(crate) fn unquoted(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    if cell.first() != Some(&b'"') {
        return cell;
    }
    cell[1..closing_quote(cell).unwrap_or(cell.len())].trim_ascii()
}

/// Cells of a line, unquoted and trimmed.
pub(crate) fn cells(line: &[u8], separator: Separator) -> Vec<&[u8]> {
    let mut out = raw_cells(line, separator);
    for cell in &mut out {
        *cell = unquoted(cell);
    }
    out
}

fn is_number(cell: &[u8]) -> bool {
    whole_f64(cell).is_some()
}

/// `-1,5`, `0,25e3`: a decimal comma.
fn is_comma_number(cell: &[u8]) -> bool {
    if memchr::memchr_iter(b',', cell).count() != 1 {
        return false;
    }
    let point: Vec<u8> = cell
        .iter()
        .map(|&c| if c == b',' { b'.' } else { c })
        .collect();
    is_number(&point)
}

/// Numbers per row times the share of cells that are numbers, and the commonest width.
fn score(lines: &[&Line<'_>], separator: Separator) -> (f64, usize) {
    let rows: Vec<Vec<&[u8]>> = lines.iter().map(|l| cells(l.text, separator)).collect();
    let width = common_width(rows.iter().map(Vec::len));
    if width < 2 {
        return (0.0, width);
    }
    let (mut numbers, mut filled, mut n) = (0, 0, 0);
    let tail = rows.len().saturating_sub(50);
    for row in rows[tail..].iter().filter(|r| r.len() == width) {
        n += 1;
        filled += row.iter().filter(|c| !c.is_empty()).count();
        numbers += row
            .iter()
            .filter(|c| is_number(c) || (separator != Separator::Byte(b',') && is_comma_number(c)))
            .count();
    }
    if n == 0 || filled == 0 {
        return (0.0, width);
    }
    let rows_of_width = rows.iter().filter(|r| r.len() == width).count() as f64 / rows.len() as f64;
    (
        numbers as f64 / f64::from(n) * (numbers as f64 / filled as f64) * rows_of_width,
        width,
    )
}

fn common_width(widths: impl Iterator<Item = usize>) -> usize {
    let mut counts: Vec<(usize, usize)> = Vec::new();
    for w in widths {
        match counts.iter_mut().find(|c| c.0 == w) {
            Some(c) => c.1 += 1,
            None => counts.push((w, 1)),
        }
    }
    counts
        .into_iter()
        .max_by_key(|&(w, n)| (n, w))
        .map_or(0, |c| c.0)
}

/// True for a header of our own: channel names with or without units.
fn is_own_header(row: &[&[u8]]) -> bool {
    let known = row.iter().filter(|c| {
        let text = String::from_utf8_lossy(c);
        let name = text.split('[').next().unwrap_or("").trim();
        Role::parse(name).is_some_and(|(r, a)| {
            a.is_some() == r.has_axes()
                && !matches!(r, Role::Angle | Role::Speed)
                && !r.is_of_path()
        })
    });
    known.count() > 0 && row.iter().all(|c| !is_number(c))
}

/// True where the row names columns: at least half of its cells are words.
fn looks_like_header(row: &[&[u8]]) -> bool {
    let filled = row.iter().filter(|c| !c.is_empty()).count();
    let words = row
        .iter()
        .filter(|c| {
            !c.is_empty() && !is_number(c) && super::iso::parse(c).is_none() && !is_comma_number(c)
        })
        .count();
    words > 0 && 2 * words >= filled
}

/// Finds the dialect of the text that begins with `sample`; `is_whole` where that is all of it.
pub(crate) fn sniff(sample: &[u8], is_whole: bool) -> Result<Dialect, Error> {
    let skip = if sample.starts_with(b"\xEF\xBB\xBF") {
        3
    } else {
        0
    };
    let lines = split(sample, skip, is_whole);
    let content: Vec<&Line<'_>> = lines
        .iter()
        .filter(|l| !l.is_comment && !l.text.trim_ascii().is_empty())
        .collect();
    if content.is_empty() {
        if lines.is_empty() && !is_whole {
            return Err(Error::data(
                "the first line does not end: this is no table of numbers",
            ));
        }
        return Err(Error::data(if lines.iter().any(|l| l.is_comment) {
            "the log holds comments only, no rows"
        } else {
            "the log is empty"
        })
        .advise("look at what recorded it, or copy it again"));
    }
    let mut best = (0.0, Separator::Byte(b','), 1);
    for separator in [
        Separator::Byte(b'\t'),
        Separator::Byte(b';'),
        Separator::Byte(b','),
        Separator::Spaces,
    ] {
        let (s, width) = score(&content, separator);
        if s > best.0 {
            best = (s, separator, width);
        }
    }
    let (points, mut separator, mut width) = best;
    if points == 0.0 {
        // No numbers: a header alone, or words. The separator is what the first line is parted by.
        for s in [b'\t', b';', b','] {
            let n = cells(content[0].text, Separator::Byte(s)).len();
            if n > 1 {
                (separator, width) = (Separator::Byte(s), n);
                break;
            }
        }
    }
    let rows: Vec<Vec<&[u8]>> = content.iter().map(|l| cells(l.text, separator)).collect();
    let own = rows.iter().take(3).position(|r| is_own_header(r));
    let first = own
        .or_else(|| rows.iter().position(|r| r.len() == width))
        .unwrap_or(0);
    if own.is_some() {
        width = rows[first].len();
    }
    refuse_decimal_comma(&rows, &content, separator)?;
    let mut has_header = own.is_some() || looks_like_header(&rows[first]);
    if has_header && own.is_none() {
        // A row of words above rows of words of the same kind is data (a label column), not a header.
        if let Some(next) = rows.get(first + 1).filter(|r| r.len() == width) {
            let gained = rows[first]
                .iter()
                .zip(next)
                .any(|(a, b)| !is_number(a) && (is_number(b) || b.is_empty()));
            has_header = gained || !rows[first].iter().any(|c| is_number(c));
        }
    }
    let mut header_line = has_header.then_some(content[first].number);
    let mut names: Vec<String> = vec![String::new(); width];
    if has_header {
        names = rows[first]
            .iter()
            .map(|c| String::from_utf8_lossy(c).trim().to_owned())
            .collect();
    } else if let Some(line) = commented_header(&lines, content[first].number, separator, width) {
        let text = line.text.trim_ascii_start().trim_ascii_start();
        let text = text.get(1..).unwrap_or(b"");
        names = cells(text, separator)
            .iter()
            .map(|c| String::from_utf8_lossy(c).trim().to_owned())
            .collect();
        header_line = Some(line.number);
    }
    let above = (!has_header && header_line.is_none())
        .then(|| short_header(&rows, first, width))
        .flatten();
    if let Some(row) = above {
        names = row
            .iter()
            .map(|c| String::from_utf8_lossy(c).trim().to_owned())
            .collect();
        names.resize(width, String::new());
        header_line = Some(content[first - 1].number);
    }
    let body = if has_header {
        content[first].end
    } else {
        content[first].start
    };
    let body_line = if has_header {
        content[first].number
    } else {
        content[first].number - 1
    };
    let data = &rows[(first + usize::from(has_header)).min(rows.len())..];
    let columns = columns_of(names, data, width);
    let mut preamble = first as u64;
    if above.is_some() {
        preamble -= 1;
    } else if !has_header && header_line.is_some() {
        preamble = 0;
    }
    Ok(Dialect {
        separator,
        width,
        columns,
        has_header: header_line.is_some(),
        header_line,
        preamble,
        body_start: body,
        body_line,
    })
}

fn split(sample: &[u8], skip: usize, is_whole: bool) -> Vec<Line<'_>> {
    let mut lines = Vec::new();
    let mut start = skip;
    let mut number = 0;
    while start < sample.len() && lines.len() < 20_000 {
        number += 1;
        let end = memchr::memchr(b'\n', &sample[start..]).map(|i| start + i);
        if end.is_none() && !is_whole {
            break;
        }
        let stop = end.unwrap_or(sample.len());
        let text = sample[start..stop]
            .strip_suffix(b"\r")
            .unwrap_or(&sample[start..stop]);
        let next = end.map_or(sample.len(), |e| e + 1);
        lines.push(Line {
            text,
            number,
            start,
            end: next,
            is_comment: is_comment(text),
        });
        start = next;
    }
    lines
}

/// The row above a table whose rows all end by a separator: its header, without one.
fn short_header<'a>(
    rows: &'a [Vec<&'a [u8]>],
    first: usize,
    width: usize,
) -> Option<&'a [&'a [u8]]> {
    let above = rows.get(first.checked_sub(1)?)?;
    let ends_empty =
        |row: &Vec<&[u8]>| row.len() == width && row.last().is_some_and(|c| c.is_empty());
    let is_one = above.len() + 1 == width
        && width > 2
        && above.iter().all(|c| !c.is_empty() && !is_number(c))
        && rows[first..]
            .iter()
            .take(PREVIEW_ROWS)
            .filter(|r| r.len() == width)
            .all(ends_empty);
    is_one.then_some(above.as_slice())
}

/// The last comment before the table that has as many words as the table has columns.
fn commented_header<'a, 'b>(
    lines: &'b [Line<'a>],
    first: u64,
    separator: Separator,
    width: usize,
) -> Option<&'b Line<'a>> {
    lines
        .iter()
        .take_while(|l| l.number < first)
        .filter(|l| l.is_comment)
        .filter(|l| {
            let text = l.text.trim_ascii_start();
            let row = cells(text.get(1..).unwrap_or(b""), separator);
            row.len() == width && row.iter().all(|c| !c.is_empty() && !is_number(c))
        })
        .last()
}

fn refuse_decimal_comma(
    rows: &[Vec<&[u8]>],
    content: &[&Line<'_>],
    separator: Separator,
) -> Result<(), Error> {
    let quoted = |line: &Line<'_>| separator != Separator::Byte(b',') || line.text.contains(&b'"');
    for (row, line) in rows.iter().zip(content) {
        if let Some(cell) = row
            .iter()
            .find(|c| is_comma_number(c))
            .filter(|_| quoted(line))
        {
            let cell = String::from_utf8_lossy(cell).into_owned();
            return Err(Error::data(format!(
                "numbers are written with a decimal comma: {}",
                clip(&cell)
            ))
            .at(format!("line {}", line.number))
            .advise("write them with a point, as 0.5"));
        }
    }
    Ok(())
}

fn columns_of(names: Vec<String>, data: &[Vec<&[u8]>], width: usize) -> Vec<RawColumn> {
    let data: Vec<&Vec<&[u8]>> = data
        .iter()
        .filter(|r| r.len() == width)
        .take(PREVIEW_ROWS)
        .collect();
    names
        .into_iter()
        .enumerate()
        .map(|(k, text)| {
            let values: Vec<f64> = data
                .iter()
                .map(|r| whole_f64(r[k]).unwrap_or(f64::NAN))
                .collect();
            let words = data
                .iter()
                .filter(|r| !r[k].is_empty() && !is_number(r[k]))
                .count();
            let filled = data.iter().filter(|r| !r[k].is_empty()).count();
            let first = data.iter().map(|r| r[k]).find(|c| !c.is_empty());
            let cells = if filled > 0 && 2 * words > filled {
                let is_date = first.is_some_and(|c| super::iso::parse(c).is_some());
                if is_date { Cells::Dates } else { Cells::Text }
            } else if k + 1 == width && text.is_empty() && filled == 0 && !data.is_empty() {
                Cells::Nothing
            } else {
                Cells::Numbers
            };
            let (name, unit) = name_and_unit(&text);
            RawColumn {
                name,
                unit,
                is_own_unit: false,
                channel: None,
                preview: values,
                cells,
                header: text,
            }
        })
        .collect()
}

/// `gyro_x [rad/s]` as name and unit.
pub(crate) fn name_and_unit(text: &str) -> (String, Option<String>) {
    if let Some((name, unit)) = text.strip_suffix(']').and_then(|b| b.rsplit_once('[')) {
        return (name.trim().to_owned(), Some(unit.trim().to_owned()));
    }
    (text.to_owned(), None)
}
