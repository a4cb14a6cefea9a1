//! Drawing of the layers of a panel into its box.

use super::pen::{CAPITAL, NUMBERS, Pen, crisp, marker, pixels, polygon, rectangle, segment};
use super::scene::{Anchor, Paint, Shape, Words};
use super::{
    Axis, Balls, Color, ColorMap, Direction, Field, Layer, Line, Marker, Panel, Regions, font,
    grid, palette,
};
use tiny_skia::PathBuilder;

/// Number of colors in a map of numbers and in its color bar.
pub(super) const LEVELS: u8 = 128;

/// Discs of a shaded ball: radius and shift to the upper left, both relative to the radius of the ball, and lightness.
const SHADES: [(f64, f64, f64); 5] = [
    (1.0, 0.0, -0.45),
    (0.93, 0.0, 0.0),
    (0.70, 0.18, 0.18),
    (0.45, 0.30, 0.42),
    (0.20, 0.38, 0.80),
];

/// Values of a field that belong to a cell.
pub(super) fn shown_values(field: &Field) -> impl Iterator<Item = f64> + Clone {
    let cells = field.columns.saturating_mul(field.rows);
    field.values.iter().take(cells).copied()
}

/// Ends of the color bar, made finite and distinct.
pub(super) fn field_range(field: &Field) -> (f64, f64) {
    let of_data = || {
        let finite = shown_values(field).filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        match field.map {
            ColorMap::Viridis | ColorMap::Cividis | ColorMap::Grey => (low, high),
            ColorMap::Diverging => {
                let reach = low.abs().max(high.abs());
                (-reach, reach)
            }
        }
    };
    let (start, end) = field.range.unwrap_or_else(of_data);
    Axis::linear("", (start.min(end), start.max(end))).limits()
}

pub(super) fn level_color(map: ColorMap, level: u8, range: (f64, f64)) -> Color {
    let t = (f64::from(level) + 0.5) / f64::from(LEVELS);
    map.color(range.0 + t * (range.1 - range.0), range)
}

/// Box of a panel in the picture.
pub(super) struct Frame<'a> {
    pub(super) panel: &'a Panel,
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Frame<'_> {
    pub(super) fn x(&self, number: f64) -> Option<f64> {
        Some(self.left + self.width * self.panel.x.fraction(number)?)
    }

    pub(super) fn y(&self, number: f64) -> Option<f64> {
        Some(self.top + self.height * (1.0 - self.panel.y.fraction(number)?))
    }

    fn at(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        Some((self.x(x)?, self.y(y)?))
    }

    /// Returns true if a point lies in the box or on its edge.
    fn holds(&self, (x, y): (f64, f64)) -> bool {
        let slack = 1e-6;
        (self.left - slack..=self.left + self.width + slack).contains(&x)
            && (self.top - slack..=self.top + self.height + slack).contains(&y)
    }

    pub(super) fn draw(&self, pen: &mut Pen, layer: &Layer) {
        match layer {
            Layer::Regions(Regions {
                x,
                y,
                columns,
                rows,
                classes,
                key,
            }) => {
                let cells = columns.saturating_mul(*rows).min(classes.len());
                let color = |class: u8| key.get(usize::from(class)).map(|&(_, color)| color);
                self.map(pen, (*x, *y), (*columns, *rows), &classes[..cells], color);
            }
            Layer::Field(field) => {
                let range = field_range(field);
                let levels: Vec<u8> = shown_values(field).map(|v| level(v, range)).collect();
                let color = |class| (class < LEVELS).then(|| level_color(field.map, class, range));
                let size = (field.columns, field.rows);
                self.map(pen, (field.x, field.y), size, &levels, color);
            }
            Layer::Line(line) => self.line(pen, line),
            Layer::Points(points) => {
                let places = points.points.iter().filter_map(|&point| self.at(point));
                let places = places.filter(|&place| self.holds(place)).collect();
                let (start, end) = self.panel.x.limits();
                let unit = self.width / (end - start).abs();
                let size = points.extent.map_or(points.size, |extent| extent * unit);
                let (outline, paint) = marker(points.marker, size, points.color, points.filled);
                pen.stamps(outline, places, paint);
            }
            Layer::Arrows(arrows) => {
                let mut outline = PathBuilder::new();
                for (&from, &to) in arrows.from.iter().zip(&arrows.to) {
                    if let (Some(tail), Some(tip)) = (self.at(from), self.at(to)) {
                        self.arrow(&mut outline, tail, tip, pixels(arrows.width));
                    }
                }
                pen.outline(outline, Paint::fill(arrows.color));
            }
            Layer::Balls(balls) => self.balls(pen, balls),
            Layer::Label(label) => {
                let Some(place) = self.at(label.at).filter(|&place| self.holds(place)) else {
                    return;
                };
                let reach = font::width(&label.text, NUMBERS) / 2.0 + 4.0;
                let keep = |at: f64, low: f64, high: f64| {
                    if low < high {
                        at.clamp(low, high)
                    } else {
                        (low + high) / 2.0
                    }
                };
                let x = keep(place.0, self.left + reach, self.left + self.width - reach);
                let (low, high) = (self.top + 8.0, self.top + self.height - 8.0);
                let y = keep(place.1, low, high) + 0.5 * CAPITAL * NUMBERS;
                pen.shapes.push(Shape::Words(Words {
                    text: label.text.clone(),
                    at: (x, y),
                    anchor: Anchor::Middle,
                    upward: false,
                    size: NUMBERS,
                    color: label.color,
                    rim: true,
                }));
            }
            Layer::Rule(rule) => {
                let mut outline = PathBuilder::new();
                let (right, bottom) = (self.left + self.width, self.top + self.height);
                let ends = match rule.direction {
                    Direction::Vertical => self.x(rule.at).map(|x| ((x, self.top), (x, bottom))),
                    Direction::Horizontal => self.y(rule.at).map(|y| ((self.left, y), (right, y))),
                };
                if let Some((from, to)) = ends.filter(|&(from, _)| self.holds(from)) {
                    segment(&mut outline, from, to);
                    pen.outline(outline, Paint::stroke(rule.color, 1.0, rule.dash));
                }
            }
        }
    }

    /// Categorical map, drawn as one outline for each color.
    fn map(
        &self,
        pen: &mut Pen,
        (x, y): ((f64, f64), (f64, f64)),
        (columns, rows): (usize, usize),
        classes: &[u8],
        color: impl Fn(u8) -> Option<Color>,
    ) {
        let (Some(start), Some(end)) = (self.at((x.0, y.0)), self.at((x.1, y.1))) else {
            return;
        };
        let clip_x = |x: f64| x.clamp(self.left, self.left + self.width);
        let clip_y = |y: f64| y.clamp(self.top, self.top + self.height);
        let edge = |from: f64, to: f64, index: usize, count: usize| {
            from + (to - from) * index as f64 / count as f64
        };
        let mut outlines: Vec<PathBuilder> = vec![PathBuilder::new(); 256];
        for block in grid::blocks(columns, classes) {
            let column = |index| clip_x(edge(start.0, end.0, index, columns));
            let row = |index| clip_y(edge(start.1, end.1, index, rows));
            let from = (column(block.columns.0), row(block.rows.0));
            let to = (column(block.columns.1), row(block.rows.1));
            if from.0 != to.0 && from.1 != to.1 {
                rectangle(&mut outlines[usize::from(block.class)], from, to);
            }
        }
        for (class, outline) in (0..=u8::MAX).zip(outlines) {
            if let Some(color) = color(class) {
                pen.outline(outline, crisp(color));
            }
        }
    }

    fn line(&self, pen: &mut Pen, line: &Line) {
        let mut outline = PathBuilder::new();
        let mut last: Option<(f64, f64)> = None;
        let mut drawn_to: Option<(f64, f64)> = None;
        let width = pixels(line.width);
        let window = [self.left, self.top, self.width, self.height];
        // A wide line that ends at an edge of the box would cross it.
        let crosses = |(x, y): (f64, f64)| {
            let near = |at: f64, start: f64, length: f64| {
                (at - start).abs().min((at - start - length).abs()) < 0.5 * width
            };
            width > 3.0 && (near(x, self.left, self.width) || near(y, self.top, self.height))
        };
        let mut is_clipped = false;
        for &point in &line.points {
            let place = self.at(point);
            if let (Some(from), Some(to)) = (last, place) {
                if let Some((from, to)) = self.clip(from, to) {
                    if drawn_to != Some(from) {
                        outline.move_to(from.0 as f32, from.1 as f32);
                    }
                    outline.line_to(to.0 as f32, to.1 as f32);
                    is_clipped |= crosses(from) || crosses(to);
                    drawn_to = Some(to);
                }
            } else {
                drawn_to = None;
            }
            last = place;
        }
        let paint = Paint::stroke(line.color, width, line.dash);
        pen.outline_within(outline, paint, is_clipped.then_some(window));
    }

    /// Part of a segment inside the box (Liang and Barsky).
    fn clip(&self, from: (f64, f64), to: (f64, f64)) -> Option<((f64, f64), (f64, f64))> {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (slope, distance) in [
            (-dx, from.0 - self.left),
            (dx, self.left + self.width - from.0),
            (-dy, from.1 - self.top),
            (dy, self.top + self.height - from.1),
        ] {
            if slope == 0.0 {
                if distance < 0.0 {
                    return None;
                }
            } else if slope < 0.0 {
                enter = enter.max(distance / slope);
            } else {
                leave = leave.min(distance / slope);
            }
        }
        if enter > leave || !(dx.is_finite() && dy.is_finite()) {
            return None;
        }
        let along = |t: f64| match t {
            0.0 => from,
            1.0 => to,
            t => (from.0 + t * dx, from.1 + t * dy),
        };
        Some((along(enter), along(leave)))
    }

    /// Balls from back to front, each with its arrow. Nested discs, lighter toward the upper left, give the shading.
    fn balls(&self, pen: &mut Pen, balls: &Balls) {
        for ball in &balls.balls {
            let edge = (ball.at.0 + ball.radius, ball.at.1);
            let (Some(place), Some(edge)) = (self.at(ball.at), self.at(edge)) else {
                continue;
            };
            if !self.holds(place) {
                continue;
            }
            let radius = (edge.0 - place.0).abs();
            let faded =
                |color: Color| color.toward(palette::WHITE, 0.75 * ball.fade.clamp(0.0, 1.0));
            for (size, shift, light) in SHADES {
                let color = if light < 0.0 {
                    balls.color.toward(palette::BLACK, -light)
                } else {
                    balls.color.toward(palette::WHITE, light)
                };
                let diameter = 2.0 * size * radius;
                let (outline, paint) = marker(Marker::Circle, diameter, faded(color), true);
                let at = (place.0 - shift * radius, place.1 - shift * radius);
                pen.stamps(outline, vec![at], paint);
            }
            if let Some(tip) = ball.tip.and_then(|tip| self.at(tip)) {
                let mut rim = PathBuilder::new();
                self.arrow(&mut rim, place, tip, pixels(balls.arrow_width) + 2.0);
                pen.outline(rim, Paint::fill(palette::WHITE));
                let mut outline = PathBuilder::new();
                self.arrow(&mut outline, place, tip, pixels(balls.arrow_width));
                pen.outline(outline, Paint::fill(faded(balls.arrow_color)));
            }
        }
    }

    /// Arrow as one filled outline: the part of its shaft in the box, and its head if the tip is there.
    fn arrow(&self, outline: &mut PathBuilder, tail: (f64, f64), tip: (f64, f64), width: f64) {
        let (dx, dy) = (tip.0 - tail.0, tip.1 - tail.1);
        let length = dx.hypot(dy);
        if !(length.is_finite() && length > 0.1) {
            return;
        }
        let (ux, uy) = (dx / length, dy / length);
        let beside = |place: (f64, f64), by: f64| (place.0 - by * uy, place.1 + by * ux);
        let head = (4.0 + 3.0 * width).min(0.6 * length);
        let behind = |by: f64| (tip.0 - by * ux, tip.1 - by * uy);
        let (neck, inner) = (behind(head), behind(0.8 * head));
        if self.holds(tip) {
            let half = 0.36 * head;
            polygon(
                outline,
                &[tip, beside(neck, half), inner, beside(neck, -half)],
            );
        }
        if let Some((from, to)) = self.clip(tail, inner) {
            let half = width / 2.0;
            let sides = [(to, -half), (to, half), (from, half), (from, -half)];
            polygon(outline, &sides.map(|(place, by)| beside(place, by)));
        }
    }
}

/// Color level of a value; [`u8::MAX`] for NaN.
fn level(value: f64, (low, high): (f64, f64)) -> u8 {
    if value.is_nan() {
        return u8::MAX;
    }
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    ((t * f64::from(LEVELS)) as u8).min(LEVELS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipped_segments_stay_in_the_box() {
        let panel = Panel::new(
            "",
            Axis::linear("", (0.0, 1.0)),
            Axis::linear("", (0.0, 1.0)),
        );
        let frame = Frame {
            panel: &panel,
            left: 10.0,
            top: 20.0,
            width: 100.0,
            height: 50.0,
        };
        let inside = ((30.0, 30.0), (70.0, 60.0));
        assert_eq!(frame.clip(inside.0, inside.1), Some(inside));
        assert_eq!(
            frame.clip((-90.0, 45.0), (310.0, 45.0)),
            Some(((10.0, 45.0), (110.0, 45.0)))
        );
        assert_eq!(frame.clip((0.0, 0.0), (200.0, 10.0)), None);
        assert_eq!(frame.clip((0.0, 25.0), (25.0, 0.0)), None);
    }
}
