//! One pair of axes and what is drawn on it.

use core::fmt::Write as _;

use super::label::{Ask, Placer, Rect};
use super::metrics::text_width;
use super::scale::Scale;
use super::{Svg, escape, number};

/// Height of a line of text over the font size.
const LINE: f64 = 1.22;

/// Edges of the plotting area and the size of the drawing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub width: f64,
    pub height: f64,
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

impl Frame {
    /// The usual margins around a panel of this size.
    pub(crate) fn panel(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            left: 42.0,
            right: 10.0,
            top: 24.0,
            bottom: 38.0,
        }
    }

    pub(crate) fn area(self) -> Rect {
        Rect::new(
            self.left,
            self.top,
            self.width - self.left - self.right,
            self.height - self.top - self.bottom,
        )
    }
}

/// How a curve looks: a class of the style sheet, a color for `currentColor`, marks for readers of the page.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ink<'a> {
    pub class: &'a str,
    pub color: &'a str,
    pub series: &'a str,
    pub term: &'a str,
    pub extra: &'a str,
}

impl<'a> Ink<'a> {
    pub(crate) fn class(class: &'a str) -> Self {
        Self {
            class,
            ..Self::default()
        }
    }

    pub(crate) fn series(mut self, series: &'a str) -> Self {
        self.series = series;
        self
    }

    pub(crate) fn term(mut self, term: &'a str) -> Self {
        self.term = term;
        self
    }

    pub(crate) fn color(mut self, color: &'a str) -> Self {
        self.color = color;
        self
    }

    pub(crate) fn extra(mut self, extra: &'a str) -> Self {
        self.extra = extra;
        self
    }

    fn attributes(&self) -> String {
        let mut out = format!("class=\"{}\"", self.class);
        if !self.color.is_empty() {
            let _ = write!(out, " style=\"color:var({})\"", self.color);
        }
        if !self.series.is_empty() {
            let _ = write!(out, " data-series=\"{}\"", escape(self.series));
        }
        if !self.term.is_empty() {
            let _ = write!(out, " data-term=\"{}\"", escape(self.term));
        }
        if !self.extra.is_empty() {
            out.push(' ');
            out.push_str(self.extra);
        }
        out
    }
}

/// How a label looks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TextStyle<'a> {
    pub class: &'a str,
    pub color: &'a str,
    pub size: f64,
    pub bold: bool,
}

impl Default for TextStyle<'_> {
    fn default() -> Self {
        Self {
            class: "l h",
            color: "",
            size: Svg::FONT_SIZE,
            bold: true,
        }
    }
}

/// A drawing under way.
#[derive(Debug, Clone)]
pub(crate) struct Plot {
    pub frame: Frame,
    pub x: Scale,
    pub y: Scale,
    pub placer: Placer,
    font: f64,
    under: String,
    curves: String,
    over: String,
    clip: String,
}

impl Plot {
    /// A plot with its scales on its frame; `id` makes the clip path's name unique on the page.
    pub(crate) fn new(frame: Frame, x: Scale, y: Scale, id: &str) -> Self {
        let area = frame.area();
        let clip = format!("c-{}", sanitize(id));
        let mut under = String::new();
        let _ = write!(
            under,
            "<clipPath id=\"{clip}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>",
            number(area.x),
            number(area.y - 1.0),
            number(area.w + 1.0),
            number(area.h + 2.0)
        );
        Self {
            frame,
            x: x.onto(area.x, area.x + area.w),
            y: y.onto(area.y + area.h, area.y),
            placer: Placer::new(Rect::new(
                area.x + 2.0,
                area.y - 4.0,
                frame.width - area.x - 4.0,
                area.h + 2.0,
            )),
            font: Svg::FONT_SIZE,
            under,
            curves: String::new(),
            over: String::new(),
            clip,
        }
    }

    /// Another font size for ticks and units.
    pub(crate) fn with_font(mut self, size: f64) -> Self {
        self.font = size;
        self
    }

    pub(crate) fn font(&self) -> f64 {
        self.font
    }

    pub(crate) fn at(&self, p: (f64, f64)) -> (f64, f64) {
        (self.x.at(p.0), self.y.at(p.1))
    }

    /// Grid, tick labels, base line and the names of both axes.
    pub(crate) fn axes(&mut self, x_title: &str, y_title: &str) -> &mut Self {
        self.x_axis(x_title);
        self.y_axis(y_title)
    }

    pub(crate) fn x_axis(&mut self, title: &str) -> &mut Self {
        self.x_axis_with(title, 7)
    }

    /// The axis with at most so many ticks.
    pub(crate) fn x_axis_with(&mut self, title: &str, most: usize) -> &mut Self {
        let ticks = self.x.ticks(most);
        self.x_axis_at(title, &ticks, true)
    }

    /// The axis with given ticks, with or without their lines.
    pub(crate) fn x_axis_at(
        &mut self,
        title: &str,
        ticks: &[(f64, String)],
        lines: bool,
    ) -> &mut Self {
        let area = self.frame.area();
        let base = area.y + area.h;
        let font = self.font;
        let mut last_end = f64::NEG_INFINITY;
        for (value, label) in ticks {
            let x = self.x.at(*value);
            if lines {
                let _ = write!(
                    self.under,
                    "<path class=\"g\" d=\"M{0} {1}V{2}\"/>",
                    number(x),
                    number(area.y),
                    number(base)
                );
            }
            let half = 0.5 * text_width(label, font, false);
            // At the edges of a drawing a label moves inwards; between neighbours it is left out.
            let center = x.clamp(half + 1.0, self.frame.width - half - 1.0);
            if center - half < last_end + 4.0 {
                continue;
            }
            last_end = center + half;
            self.fixed_text((center, base + font + 3.5), "middle", "t", label, "");
        }
        let _ = write!(
            self.under,
            "<path class=\"a\" d=\"M{} {}H{}\"/>",
            number(area.x),
            number(base),
            number(area.x + area.w)
        );
        if !title.is_empty() {
            self.fixed_text(
                (area.x + area.w, base + 2.0 * font + 8.5),
                "end",
                "u",
                title,
                "data-unit=\"x\"",
            );
        }
        self
    }

    pub(crate) fn y_axis(&mut self, title: &str) -> &mut Self {
        self.y_axis_with(title, 7)
    }

    /// The axis with at most so many ticks.
    pub(crate) fn y_axis_with(&mut self, title: &str, most: usize) -> &mut Self {
        let area = self.frame.area();
        let font = self.font;
        let most = most.min(Self::y_ticks(area.h, font));
        for (value, label) in self.y.ticks(most) {
            let y = self.y.at(value);
            let _ = write!(
                self.under,
                "<path class=\"g\" d=\"M{} {}H{}\"/>",
                number(area.x),
                number(y),
                number(area.x + area.w)
            );
            let at = (area.x - 6.0, y + 0.35 * font);
            let w = text_width(&label, font, false);
            // In the corner the label of the other axis was first.
            let rect = Rect::new(at.0 - w, at.1 - font, w, font * LINE);
            if self.placer.is_free(rect) {
                self.fixed_text(at, "end", "t", &label, "");
            }
        }
        if !title.is_empty() {
            self.fixed_text((2.0, font), "start", "u", title, "data-unit=\"y\"");
        }
        self
    }

    fn y_ticks(height: f64, font: f64) -> usize {
        ((height / (font * 1.5)).floor() as usize).clamp(2, 7)
    }

    /// Room that the tick labels of a y scale need left of the axis.
    pub(crate) fn left_room(y: Scale, height: f64, font: f64) -> f64 {
        y.ticks(Self::y_ticks(height, font))
            .iter()
            .map(|(_, label)| text_width(label, font, false))
            .fold(20.0, f64::max)
            + 9.0
    }

    /// A text at a fixed place that no label may touch.
    pub(crate) fn fixed_text(
        &mut self,
        at: (f64, f64),
        anchor: &str,
        class: &str,
        text: &str,
        extra: &str,
    ) {
        let bold = class.split(' ').any(|c| c == "l");
        let size = self.font;
        let w = text_width(text, size, bold);
        let x = match anchor {
            "middle" => at.0 - 0.5 * w,
            "end" => at.0 - w,
            _ => at.0,
        };
        self.placer.take(Rect::new(x, at.1 - size, w, size * LINE));
        let extra = if extra.is_empty() {
            String::new()
        } else {
            format!(" {extra}")
        };
        let size_attribute = if (size - Svg::FONT_SIZE).abs() < 1e-9 {
            String::new()
        } else {
            format!(" font-size=\"{}\"", number(size))
        };
        let anchor = if anchor == "start" {
            String::new()
        } else {
            format!(" text-anchor=\"{anchor}\"")
        };
        let _ = write!(
            self.over,
            "<text class=\"{class}\" x=\"{}\" y=\"{}\"{anchor}{size_attribute}{extra}>{}</text>",
            number(at.0),
            number(at.1),
            escape(text)
        );
    }

    fn points(&self, x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
        x.iter()
            .zip(y)
            .filter(|(x, y)| {
                x.is_finite()
                    && y.is_finite()
                    && (!self.x.is_log() || **x > 0.0)
                    && (!self.y.is_log() || **y > 0.0)
            })
            .map(|(&x, &y)| self.at((x, y)))
            .collect()
    }

    /// A curve through points in data units; what is not finite is left out.
    pub(crate) fn curve(&mut self, x: &[f64], y: &[f64], ink: Ink<'_>) -> &mut Self {
        let points = thin(&self.points(x, y), 700);
        if points.is_empty() {
            return self;
        }
        self.placer.line(&points);
        let _ = write!(
            self.curves,
            "<path {} clip-path=\"url(#{})\" d=\"{}\"/>",
            ink.attributes(),
            self.clip,
            path(&points)
        );
        self
    }

    /// The area between two curves over the same x.
    pub(crate) fn band(&mut self, x: &[f64], low: &[f64], high: &[f64], ink: Ink<'_>) -> &mut Self {
        let ok = |v: f64| v.is_finite() && (!self.y.is_log() || v > 0.0);
        let rows: Vec<(f64, f64, f64)> = x
            .iter()
            .zip(low)
            .zip(high)
            .filter(|((x, l), h)| {
                x.is_finite() && (!self.x.is_log() || **x > 0.0) && ok(**l) && ok(**h)
            })
            .map(|((&x, &l), &h)| (x, l, h))
            .collect();
        if rows.len() < 2 {
            return self;
        }
        let mut points: Vec<(f64, f64)> = rows.iter().map(|r| self.at((r.0, r.2))).collect();
        points.extend(rows.iter().rev().map(|r| self.at((r.0, r.1))));
        let _ = write!(
            self.under,
            "<path {} clip-path=\"url(#{})\" d=\"{}Z\"/>",
            ink.attributes(),
            self.clip,
            path(&points)
        );
        self
    }

    /// A straight line between two points of the data.
    pub(crate) fn line(&mut self, a: (f64, f64), b: (f64, f64), ink: Ink<'_>) -> &mut Self {
        self.curve(&[a.0, b.0], &[a.1, b.1], ink)
    }

    /// Raw elements above the curves (markers, boxes), in drawing units.
    pub(crate) fn raw(&mut self, markup: &str) -> &mut Self {
        self.curves.push_str(markup);
        self
    }

    /// Raw elements under everything.
    pub(crate) fn raw_under(&mut self, markup: &str) -> &mut Self {
        self.under.push_str(markup);
        self
    }

    /// A circle at a point of the data.
    pub(crate) fn circle(&mut self, p: (f64, f64), radius: f64, ink: Ink<'_>) -> &mut Self {
        let (x, y) = self.at(p);
        self.placer.dot((x, y));
        let _ = write!(
            self.curves,
            "<circle {} cx=\"{}\" cy=\"{}\" r=\"{}\"/>",
            ink.attributes(),
            number(x),
            number(y),
            number(radius)
        );
        self
    }

    /// A label for a point in drawing units; `false` where no room was found.
    pub(crate) fn label(
        &mut self,
        text: &str,
        point: (f64, f64),
        direction: Option<f64>,
        gap: f64,
        reach: f64,
        style: TextStyle<'_>,
    ) -> bool {
        let w = text_width(text, style.size, style.bold);
        let h = style.size * LINE;
        let Some(place) = self.placer.place(Ask {
            point,
            size: (w, h),
            direction,
            gap,
            reach,
        }) else {
            return false;
        };
        if let Some((a, b)) = place.leader {
            let _ = write!(
                self.over,
                "<path class=\"k\" d=\"M{} {}L{} {}\"/>",
                number(a.0),
                number(a.1),
                number(b.0),
                number(b.1)
            );
        }
        // A font narrower than the measure leaves room on the side away from the point.
        let r = place.rect;
        let (anchor, x) = if point.0 <= r.x {
            ("start", r.x)
        } else if point.0 >= r.x + r.w {
            ("end", r.x + r.w)
        } else {
            ("middle", r.x + 0.5 * r.w)
        };
        self.over.push_str(&halo_text(
            (x, r.y + style.size * 0.95),
            anchor,
            text,
            style,
        ));
        true
    }

    /// The finished drawing.
    pub(crate) fn finish(self, title: &str, description: &str) -> Svg {
        Svg {
            width: self.frame.width,
            height: self.frame.height,
            title: title.to_owned(),
            description: description.to_owned(),
            body: format!("{}{}{}", self.under, self.curves, self.over),
        }
    }
}

/// A text with a halo.
pub(crate) fn halo_text(at: (f64, f64), anchor: &str, text: &str, style: TextStyle<'_>) -> String {
    let mut attributes = String::new();
    if !style.color.is_empty() {
        let _ = write!(attributes, " style=\"fill:var({})\"", style.color);
    }
    if (style.size - Svg::FONT_SIZE).abs() > 1e-9 {
        let _ = write!(attributes, " font-size=\"{}\"", number(style.size));
    }
    if anchor != "start" {
        let _ = write!(attributes, " text-anchor=\"{anchor}\"");
    }
    format!(
        "<text class=\"{}\" x=\"{}\" y=\"{}\"{attributes}>{}</text>",
        style.class,
        number(at.0),
        number(at.1),
        escape(text)
    )
}

fn path(points: &[(f64, f64)]) -> String {
    let mut out = String::with_capacity(12 * points.len());
    for (i, p) in points.iter().enumerate() {
        let _ = write!(
            out,
            "{}{} {}",
            if i == 0 { 'M' } else { 'L' },
            number(p.0),
            number(p.1)
        );
    }
    out
}

fn sanitize(id: &str) -> String {
    id.chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect()
}

/// A curve of at most about `most` points: the lowest and the highest of each piece are kept.
pub(crate) fn thin(points: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    if points.len() <= most {
        return points.to_vec();
    }
    let left = points.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let right = points.iter().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
    let pieces = (most / 2).max(1);
    let piece_of = |x: f64| {
        let share = (x - left) / (right - left).max(1e-9);
        ((share * pieces as f64) as usize).min(pieces - 1)
    };
    let mut out: Vec<(f64, f64)> = Vec::with_capacity(most + 2);
    let mut start = 0;
    while start < points.len() {
        let piece = piece_of(points[start].0);
        let mut end = start;
        let (mut low, mut high) = (start, start);
        while end < points.len() && piece_of(points[end].0) == piece {
            if points[end].1 < points[low].1 {
                low = end;
            }
            if points[end].1 > points[high].1 {
                high = end;
            }
            end += 1;
        }
        for i in [low.min(high), low.max(high)] {
            if out.last() != Some(&points[i]) {
                out.push(points[i]);
            }
        }
        start = end.max(start + 1);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_peaks() {
        let mut points: Vec<(f64, f64)> =
            (0..100_000).map(|i| (f64::from(i) * 0.003, 0.0)).collect();
        points[54_321].1 = 7.0;
        let thinned = thin(&points, 600);
        assert!(thinned.len() <= 602);
        assert!(thinned.iter().any(|p| p.1 == 7.0));
    }
}
