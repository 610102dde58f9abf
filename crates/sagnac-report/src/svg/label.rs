//! Labels that touch no other label, no edge and, where there is room, no curve.
//!
//! Each label tries positions around its point, near ones first, and takes the cheapest; what finds no
//! room is left out. A thin leader joins a label that stands apart from its point.

/// A rectangle of a drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Left edge.
    pub x: f64,
    /// Top edge.
    pub y: f64,
    /// Width.
    pub w: f64,
    /// Height.
    pub h: f64,
}

impl Rect {
    /// A rectangle from its left top corner and size.
    pub const fn new(x: f64, y: f64, w: f64, h: f64) -> Self {
        Self { x, y, w, h }
    }

    fn grown(self, by: f64) -> Self {
        Self::new(
            self.x - by,
            self.y - by,
            self.w + 2.0 * by,
            self.h + 2.0 * by,
        )
    }

    pub(crate) fn touches(self, other: Self) -> bool {
        self.x < other.x + other.w
            && other.x < self.x + self.w
            && self.y < other.y + other.h
            && other.y < self.y + self.h
    }

    fn inside(self, outer: Self) -> bool {
        self.x >= outer.x
            && self.y >= outer.y
            && self.x + self.w <= outer.x + outer.w
            && self.y + self.h <= outer.y + outer.h
    }

    fn holds(self, p: (f64, f64)) -> bool {
        p.0 >= self.x && p.0 <= self.x + self.w && p.1 >= self.y && p.1 <= self.y + self.h
    }

    fn nearest(self, p: (f64, f64)) -> (f64, f64) {
        (
            p.0.clamp(self.x, self.x + self.w),
            p.1.clamp(self.y, self.y + self.h),
        )
    }
}

/// What a label wants.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ask {
    /// Its point.
    pub point: (f64, f64),
    /// Its size.
    pub size: (f64, f64),
    /// Preferred direction from the point in degrees, 0 right, 90 up; `None`: any.
    pub direction: Option<f64>,
    /// Distance from the point at least.
    pub gap: f64,
    /// Distance from the point at most.
    pub reach: f64,
}

/// Where a label found room.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub rect: Rect,
    /// From the point to the label, where it stands apart.
    pub leader: Option<((f64, f64), (f64, f64))>,
}

/// Finds places for labels.
#[derive(Debug, Clone)]
pub(crate) struct Placer {
    bounds: Rect,
    taken: Vec<Rect>,
    ink: Vec<(f64, f64)>,
    leaders: Vec<((f64, f64), (f64, f64))>,
    points: Vec<(f64, f64)>,
}

impl Placer {
    /// Labels stay inside these bounds.
    pub(crate) fn new(bounds: Rect) -> Self {
        Self {
            bounds,
            taken: Vec::new(),
            ink: Vec::new(),
            leaders: Vec::new(),
            points: Vec::new(),
        }
    }

    /// A point that has a label of its own: others keep nearer to theirs than to it.
    pub(crate) fn point(&mut self, p: (f64, f64)) {
        self.points.push(p);
    }

    /// Whether a label there would be taken for that of another point: it stands beside that one, not beside its own.
    fn misleads(&self, rect: Rect, own: (f64, f64)) -> bool {
        let beside = |p: (f64, f64)| {
            let near = rect.nearest(p);
            p.1 >= rect.y && p.1 <= rect.y + rect.h && (near.0 - p.0).abs() < 26.0
        };
        let is_other = |p: &&(f64, f64)| (p.0 - own.0).hypot(p.1 - own.1) > 2.5;
        !beside(own) && self.points.iter().filter(is_other).any(|p| beside(*p))
    }

    /// No label may touch this rectangle.
    pub(crate) fn take(&mut self, rect: Rect) {
        self.taken.push(rect);
    }

    /// Whether nothing stands in this rectangle yet.
    pub(crate) fn is_free(&self, rect: Rect) -> bool {
        !self.taken.iter().any(|t| rect.touches(*t))
    }

    /// A line that labels should rather not cover.
    pub(crate) fn line(&mut self, points: &[(f64, f64)]) {
        const STEP: f64 = 3.0;
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let length = (b.0 - a.0).hypot(b.1 - a.1);
            if !length.is_finite() || length > 5000.0 {
                continue;
            }
            let steps = (length / STEP).ceil().max(1.0) as usize;
            for i in 0..=steps {
                let t = i as f64 / steps as f64;
                let p = (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
                if self.bounds.grown(4.0).holds(p) {
                    self.ink.push(p);
                }
            }
        }
    }

    /// A dot that labels should rather not cover.
    pub(crate) fn dot(&mut self, p: (f64, f64)) {
        // Several points, so that a dot weighs as much as a piece of a line.
        self.ink.extend([p; 4]);
    }

    /// The free rectangle among these with the least ink under it; it is taken.
    pub(crate) fn first_free(&mut self, tries: impl Iterator<Item = Rect>) -> Option<Rect> {
        let mut best: Option<(usize, Rect)> = None;
        for (order, rect) in tries.enumerate() {
            let padded = rect.grown(1.5);
            if !rect.inside(self.bounds)
                || self.taken.iter().any(|t| padded.touches(*t))
                || self.leaders.iter().any(|l| crosses(*l, padded))
            {
                continue;
            }
            let cost = order + 3 * self.ink.iter().filter(|p| padded.holds(**p)).count();
            if best.as_ref().is_none_or(|(c, _)| cost < *c) {
                best = Some((cost, rect));
            }
        }
        let (_, rect) = best?;
        self.taken.push(rect.grown(1.0));
        Some(rect)
    }

    /// Finds room for a label, takes it, and says where.
    pub(crate) fn place(&mut self, ask: Ask) -> Option<Place> {
        let (w, h) = ask.size;
        let mut best: Option<(f64, Place)> = None;
        let mut distance = ask.gap;
        while distance <= ask.reach {
            for step in 0..24 {
                let angle = f64::from(step) * 15.0;
                let (sin, cos) = angle.to_radians().sin_cos();
                let center = (
                    ask.point.0 + cos * distance + (cos * 1.5).clamp(-1.0, 1.0) * 0.5 * w,
                    ask.point.1 - sin * distance - (sin * 1.5).clamp(-1.0, 1.0) * 0.5 * h,
                );
                let rect = Rect::new(center.0 - 0.5 * w, center.1 - 0.5 * h, w, h);
                if !rect.inside(self.bounds) || self.misleads(rect, ask.point) {
                    continue;
                }
                let padded = rect.grown(2.0);
                if self.taken.iter().any(|t| padded.touches(*t))
                    || self.leaders.iter().any(|l| crosses(*l, padded))
                {
                    continue;
                }
                let near = rect.nearest(ask.point);
                let apart = (near.0 - ask.point.0).hypot(near.1 - ask.point.1);
                let leader = (apart > 11.0).then_some((ask.point, near));
                if leader.is_some_and(|l| self.taken.iter().any(|t| crosses(l, *t))) {
                    continue;
                }
                let covered = self.ink.iter().filter(|p| padded.holds(**p)).count() as f64;
                let turned = ask.direction.map_or(0.0, |d| {
                    let turn = (angle - d).rem_euclid(360.0);
                    turn.min(360.0 - turn)
                });
                let cost = apart + 6.0 * covered + 0.12 * turned;
                if best.as_ref().is_none_or(|(c, _)| cost < *c) {
                    best = Some((cost, Place { rect, leader }));
                }
            }
            distance += 4.0;
        }
        let (_, place) = best?;
        self.taken.push(place.rect.grown(1.0));
        if let Some(leader) = place.leader {
            self.leaders.push(leader);
        }
        Some(place)
    }
}

/// Whether a segment passes through a rectangle (sampled).
fn crosses(segment: ((f64, f64), (f64, f64)), rect: Rect) -> bool {
    let (a, b) = segment;
    let steps = ((b.0 - a.0).hypot(b.1 - a.1) / 2.0).ceil().max(1.0) as usize;
    (0..=steps).any(|i| {
        let t = i as f64 / steps as f64;
        rect.holds((a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_never_touch_and_stay_inside() {
        let bounds = Rect::new(0.0, 0.0, 200.0, 120.0);
        let mut placer = Placer::new(bounds);
        placer.line(&[(0.0, 60.0), (200.0, 60.0)]);
        let mut placed: Vec<Rect> = Vec::new();
        for i in 0..20 {
            let ask = Ask {
                point: (100.0 + f64::from(i), 60.0),
                size: (60.0, 14.0),
                direction: Some(0.0),
                gap: 4.0,
                reach: 100.0,
            };
            if let Some(place) = placer.place(ask) {
                assert!(place.rect.inside(bounds));
                for other in &placed {
                    assert!(!place.rect.touches(*other));
                }
                placed.push(place.rect);
            }
        }
        assert!(placed.len() >= 4);
        assert!(placed.len() < 20, "twenty labels of this size cannot fit");
    }

    #[test]
    fn no_label_stands_beside_the_point_of_another() {
        // Above and left there is no room: what is left is beside the lower point.
        let ask = Ask {
            point: (60.0, 8.0),
            size: (60.0, 14.0),
            direction: Some(0.0),
            gap: 8.0,
            reach: 30.0,
        };
        let place = |points: &[(f64, f64)]| {
            let mut placer = Placer::new(Rect::new(40.0, 0.0, 120.0, 60.0));
            placer.take(Rect::new(66.0, 0.0, 100.0, 16.0));
            for p in points {
                placer.point(*p);
            }
            placer.place(ask)
        };
        assert!(place(&[(60.0, 8.0)]).is_some());
        let lower: Vec<(f64, f64)> = (18..60).map(|y| (45.0, f64::from(y))).collect();
        assert!(place(&lower).is_none());
    }
}
