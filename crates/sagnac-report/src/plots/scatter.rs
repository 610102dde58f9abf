//! Sensors as points between two quantities, with regions: application areas, cost against performance.

use core::fmt::Write as _;

use super::{Color, Figure, PANEL_WIDTH};
use crate::svg::{Frame, Plot, Rect, Scale, Svg, TextStyle, halo_text, number, text_width};

/// Shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marker {
    /// Filled circle.
    #[default]
    Filled,
    /// Open circle.
    Open,
    /// Open triangle.
    Triangle,
    /// Diamond: yours.
    Diamond,
}

/// A sensor.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScatterPoint {
    /// Its name.
    pub name: String,
    /// What its label says after the name: the letters of the evidence.
    pub mark: String,
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Its color: the technology.
    pub color: Color,
    /// Its shape.
    pub marker: Marker,
    /// Range of the abscissa, as a pale bar.
    pub x_range: Option<(f64, f64)>,
}

impl ScatterPoint {
    fn label(&self) -> String {
        format!("{} {}", self.name, self.mark).trim_end().to_owned()
    }
}

/// A region.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// What it is used for, in smaller letters; may be empty.
    pub uses: String,
    /// Range of the abscissa.
    pub x: (f64, f64),
    /// Range of the ordinate.
    pub y: (f64, f64),
}

/// Points and regions on two logarithmic axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScatterChart {
    /// Value of `data-plot`: `application-area` or `cost-performance`.
    pub plot: String,
    /// Value of `data-axis`: `gyro`, `accel` or nothing.
    pub axis: String,
    /// Bold caption.
    pub caption: String,
    /// Rest of the caption.
    pub caption_rest: String,
    /// Quantity and unit of the abscissa.
    pub x_title: String,
    /// Quantity and unit of the ordinate.
    pub y_title: String,
    /// Ticks of the abscissa as plain numbers (prices).
    pub plain_x: bool,
    /// The points.
    pub points: Vec<ScatterPoint>,
    /// The regions.
    pub regions: Vec<Region>,
}

impl ScatterChart {
    /// The figure, drawn at this width beside a narrow drawing.
    pub fn figure(&self, width: f64) -> Figure {
        Figure::new(
            &self.plot,
            &self.axis,
            &self.caption,
            &self.caption_rest,
            self.draw(width, "wide"),
        )
        .with_narrow(self.draw(PANEL_WIDTH, "narrow"))
    }

    /// The drawing.
    pub fn draw(&self, width: f64, id: &str) -> Svg {
        let x = Scale::around(
            self.points
                .iter()
                .flat_map(|p| {
                    [
                        p.x,
                        p.x_range.map_or(p.x, |r| r.0),
                        p.x_range.map_or(p.x, |r| r.1),
                    ]
                })
                .chain(self.regions.iter().flat_map(|r| [r.x.0, r.x.1])),
            true,
            if width < 400.0 { 0.06 } else { 0.04 },
        );
        let x = if self.plain_x { x.plain() } else { x };
        let y = Scale::around(
            self.points
                .iter()
                .map(|p| p.y)
                .chain(self.regions.iter().flat_map(|r| [r.y.0, r.y.1])),
            true,
            0.04,
        );
        let height = if width < 400.0 { 420.0 } else { 520.0 };
        let mut frame = Frame::panel(width, height);
        frame.left = Plot::left_room(y, frame.area().h, Svg::FONT_SIZE).max(34.0);
        let mut plot = Plot::new(frame, x, y, &format!("{}-{}-{id}", self.plot, self.axis))
            .with_font(if width > 800.0 { 11.9 } else { Svg::FONT_SIZE });
        plot.axes(&self.x_title, &self.y_title);
        for region in &self.regions {
            draw_region(&mut plot, region);
        }
        let groups = self.groups(&plot);
        for point in &self.points {
            draw_point(&mut plot, point);
        }
        // Yours first, then those that stand in the thick.
        for group in groups.iter().filter(|g| g.yours) {
            name_group(&mut plot, group);
        }
        let rects: Vec<Rect> = self.regions.iter().map(|r| rect_of(&plot, r)).collect();
        for region in &self.regions {
            name_region(&mut plot, region, &rects);
        }
        for group in groups.iter().filter(|g| !g.yours) {
            name_group(&mut plot, group);
        }
        plot.finish(
            &format!(
                "{}: {} against {}",
                self.caption, self.y_title, self.x_title
            ),
            "",
        )
    }

    /// Points at one place share a label.
    fn groups(&self, plot: &Plot) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for p in &self.points {
            let at = plot.at((p.x, p.y));
            let yours = p.marker == Marker::Diamond;
            let known = groups.iter_mut().find(|g| {
                (g.at.0 - at.0).hypot(g.at.1 - at.1) < 2.5 && g.color == p.color && g.yours == yours
            });
            match known {
                Some(group) => group.names.push(p.label()),
                None => groups.push(Group {
                    names: vec![p.label()],
                    at,
                    color: p.color,
                    yours,
                }),
            }
        }
        groups
    }
}

/// Points at one place.
struct Group {
    names: Vec<String>,
    at: (f64, f64),
    color: Color,
    yours: bool,
}

fn name_group(plot: &mut Plot, group: &Group) {
    let text = match group.names.as_slice() {
        [] => return,
        [one] => one.clone(),
        [one, two] => format!("{one}, {two}"),
        [one, rest @ ..] => format!("{one} and {} more", rest.len()),
    };
    let color = if group.yours {
        "--ink"
    } else {
        group.color.property()
    };
    let style = TextStyle {
        color,
        size: plot.font(),
        ..TextStyle::default()
    };
    let gap = if group.yours { 10.0 } else { 8.0 };
    plot.label(&text, group.at, Some(0.0), gap, 90.0, style);
}

fn rect_of(plot: &Plot, region: &Region) -> Rect {
    let (x0, y0) = plot.at((region.x.0, region.y.1));
    let (x1, y1) = plot.at((region.x.1, region.y.0));
    Rect::new(x0, y0, x1 - x0, y1 - y0)
}

fn draw_region(plot: &mut Plot, region: &Region) {
    let r = rect_of(plot, region);
    plot.raw_under(&format!(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"4\" style=\"fill:var(--w);fill-opacity:.07;stroke:var(--muted);stroke-opacity:.55\"/>",
        number(r.x),
        number(r.y),
        number(r.w),
        number(r.h)
    ));
}

/// Places for a label of a region inside the plot, best first: inside the region, above or below it, beside it, and
/// across its own edge as the last resort.
fn places(r: Rect, w: f64, h: f64, area: Rect) -> Vec<Rect> {
    let tops_inside = [r.y + 4.0, r.y + r.h - h - 4.0, r.y + 0.5 * (r.h - h)];
    let tops_outside = [r.y + r.h + 4.0, r.y - h - 3.0];
    let mut tries: Vec<(f64, f64)> = Vec::new();
    if w + 10.0 <= r.w {
        for top in tops_inside {
            tries.extend([(r.x + 6.0, top), (r.x + r.w - 6.0 - w, top)]);
        }
    }
    for top in tops_outside {
        tries.extend([(r.x + 1.0, top), (r.x + r.w - w, top)]);
    }
    for top in tops_inside {
        tries.extend([(r.x + r.w + 7.0, top), (r.x - 7.0 - w, top)]);
    }
    for top in tops_inside {
        tries.extend([(r.x + 6.0, top), (r.x + r.w - w - 6.0, top)]);
    }
    tries
        .into_iter()
        .filter(|(left, top)| {
            *left >= area.x
                && left + w <= area.x + area.w
                && *top >= area.y
                && top + h <= area.y + area.h
        })
        .map(|(left, top)| Rect::new(left, top, w, h))
        .collect()
}

/// Name and uses of a region, not inside another one; in the thick the name alone.
fn name_region(plot: &mut Plot, region: &Region, others: &[Rect]) {
    let r = rect_of(plot, region);
    let size = plot.font();
    let small = 10.8;
    let area = plot.frame.area();
    let name = text_width(&region.name, size, true);
    let both = name.max(text_width(&region.uses, small, false));
    let mut sizes = vec![(name, 15.0)];
    if !region.uses.is_empty() {
        sizes.insert(0, (both, 29.0));
    }
    let clear = |rect: &Rect| !others.iter().any(|o| *o != r && o.touches(*rect));
    let mut place = None;
    for (w, h) in sizes {
        let tries = places(r, w, h, area);
        let apart: Vec<Rect> = tries.iter().copied().filter(clear).collect();
        place = plot
            .placer
            .first_free(apart.into_iter())
            .or_else(|| plot.placer.first_free(tries.into_iter()))
            .map(|at| (at, h));
        if place.is_some() {
            break;
        }
    }
    let Some((at, h)) = place else {
        return;
    };
    plot.raw(&halo_text(
        (at.x, at.y + size),
        "start",
        &region.name,
        TextStyle {
            size,
            ..TextStyle::default()
        },
    ));
    if h > 15.0 {
        plot.raw(&halo_text(
            (at.x, at.y + size + 14.0),
            "start",
            &region.uses,
            TextStyle {
                class: "u h",
                size: small,
                bold: false,
                ..TextStyle::default()
            },
        ));
    }
}

fn draw_point(plot: &mut Plot, point: &ScatterPoint) {
    let (x, y) = plot.at((point.x, point.y));
    let color = point.color.property();
    let mut out = String::new();
    if let Some((low, high)) = point.x_range {
        let (a, b) = (plot.x.at(low), plot.x.at(high));
        let _ = write!(
            out,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"5\" rx=\"2.5\" style=\"fill:var({color});fill-opacity:.28\"/>",
            number(a),
            number(y - 2.5),
            number((b - a).max(0.0))
        );
    }
    let (xs, ys) = (number(x), number(y));
    let _ = match point.marker {
        Marker::Filled => write!(
            out,
            "<circle cx=\"{xs}\" cy=\"{ys}\" r=\"4.6\" style=\"fill:var({color})\"/>"
        ),
        Marker::Open => write!(
            out,
            "<circle cx=\"{xs}\" cy=\"{ys}\" r=\"4\" style=\"fill:var(--page);stroke:var({color});stroke-width:1.8\"/>"
        ),
        Marker::Triangle => write!(
            out,
            "<path d=\"M{} {}l5 9h-10z\" style=\"fill:var(--page);stroke:var({color});stroke-width:1.6\"/>",
            number(x),
            number(y - 5.5)
        ),
        Marker::Diamond => write!(
            out,
            "<path d=\"M{} {}l7 7l-7 7l-7 -7z\" style=\"fill:var(--ink)\"/>",
            number(x),
            number(y - 7.0)
        ),
    };
    plot.raw(&out);
    plot.placer.take(Rect::new(x - 5.0, y - 5.0, 10.0, 10.0));
    plot.placer.point((x, y));
}
