//! From a figure to a scene: measure the panels, line them up, draw them.

use super::axis::{Scale, Tick};
use super::scene::{Anchor, Paint, Scene, Shape, Stroke, Words};
use super::{
    Axis, Color, ColorMap, Dash, Direction, Field, Figure, Layer, LegendEntry, Line, Marker, Panel,
    Regions, Symbol, font, grid, palette,
};
use tiny_skia::{Path, PathBuilder};

/// Ink of axes and words.
const INK: Color = Color::hex(0x222222);
/// Sizes of type, in pixels.
const TITLE: f64 = 16.0;
const WORDS: f64 = 13.0;
const NUMBERS: f64 = 12.0;
/// Baseline to baseline, in sizes of type.
const LEADING: f64 = 1.3;
/// Height of figures and capitals, in sizes of type.
const CAPITAL: f64 = 0.73;
/// White around the figure, and between its parts.
const PADDING: f64 = 14.0;
const GAP: f64 = 18.0;
/// Length of a tick, and the white to its label.
const TICK: f64 = 5.0;
const TICK_GAP: f64 = 4.0;
/// White between the tick labels and the label of the axis.
const LABEL_GAP: f64 = 8.0;
/// The color bar: white before it, and its width.
const BAR_GAP: f64 = 12.0;
const BAR: f64 = 13.0;
/// Colors in a color bar and in its map.
const LEVELS: u8 = 128;
/// The legend: white after a symbol and after a name, distance of rows.
const SYMBOL_GAP: f64 = 7.0;
const ENTRY_GAP: f64 = 24.0;
const LEGEND_ROW: f64 = 21.0;

/// Draw the whole figure.
pub(super) fn scene(figure: &Figure) -> Scene {
    let columns = figure.columns.clamp(1, figure.panels.len().max(1));
    let box_width = if columns == 1 { 420.0 } else { 300.0 };
    let panels: Vec<Measured> = figure
        .panels
        .iter()
        .map(|panel| Measured::new(panel, box_width))
        .collect();

    let column = |index: usize, size: fn(&Measured) -> f64| {
        let members = panels.iter().skip(index).step_by(columns);
        members.map(size).fold(0.0, f64::max)
    };
    let row = |index: usize, size: fn(&Measured) -> f64| {
        let members = panels.iter().skip(index * columns).take(columns);
        members.map(size).fold(0.0, f64::max)
    };
    let widths: Vec<[f64; 3]> = (0..columns)
        .map(|i| {
            [
                column(i, |p| p.left),
                column(i, |p| p.width),
                column(i, |p| p.right),
            ]
        })
        .collect();
    let gaps = GAP * (columns - 1) as f64;
    let content = widths.iter().flatten().sum::<f64>() + gaps;

    let entries = figure.legend_entries();
    let widest = entries.iter().map(entry_width).fold(260.0, f64::max);
    let width = (content.max(widest) + 2.0 * PADDING).ceil();

    let mut pen = Pen::default();
    let mut y = PADDING;
    for line in font::wrap(&figure.title, TITLE, width - 2.0 * PADDING) {
        y += TITLE * LEADING;
        pen.words(line, (width / 2.0, y - 0.3 * TITLE), Anchor::Middle, TITLE);
    }
    if !figure.title.trim().is_empty() {
        y += 4.0;
    }
    for index in 0..panels.len().div_ceil(columns) {
        if index > 0 {
            y += GAP;
        }
        // Half pixels, so that thin lines fill whole device pixels.
        let top = (y + row(index, |p| p.top)).round() + 0.5;
        let mut x = (width - content) / 2.0;
        for (panel, [left, slot, right]) in panels.iter().skip(index * columns).zip(&widths) {
            let start = (x + left + (slot - panel.width) / 2.0).round() + 0.5;
            panel.draw(&mut pen, start, top);
            x += left + slot + right + GAP;
        }
        y = top + row(index, |p| p.height) + row(index, |p| p.bottom);
    }
    if !entries.is_empty() {
        y = draw_legend(&mut pen, &entries, width, y + 10.0);
    }
    let caption = font::wrap(&figure.caption, NUMBERS, width - 2.0 * PADDING);
    if !caption.is_empty() {
        y += 6.0;
    }
    for line in caption {
        y += NUMBERS * LEADING;
        pen.words(line, (PADDING, y - 0.3 * NUMBERS), Anchor::Start, NUMBERS);
    }
    Scene {
        width,
        height: (y + PADDING).ceil(),
        title: figure.title.clone(),
        description: figure.caption.clone(),
        shapes: pen.shapes,
    }
}

/// A panel and the sizes of its parts.
struct Measured<'a> {
    panel: &'a Panel,
    /// Size of the box between the axes.
    width: f64,
    height: f64,
    /// What sticks out of the box.
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    title: Vec<String>,
    x_label: Vec<String>,
    y_label: Vec<String>,
    x_marks: Vec<Tick>,
    y_marks: Vec<Tick>,
    bars: Vec<Bar<'a>>,
}

/// A color bar.
struct Bar<'a> {
    field: &'a Field,
    axis: Axis,
    marks: Vec<Tick>,
    label: Vec<String>,
    width: f64,
}

impl<'a> Measured<'a> {
    fn new(panel: &'a Panel, box_width: f64) -> Self {
        let (width, height) = box_size(panel, box_width);
        let title = font::wrap(&panel.title, WORDS, width + 50.0);
        let x_label = font::wrap(&panel.x.label, WORDS, width + 50.0);
        let y_label = font::wrap(&panel.y.label, WORDS, height + 10.0);
        let x_marks = spaced_marks(&panel.x, width);
        let y_marks = panel.y.marks(match panel.y.scale {
            Scale::Linear => mark_target(height, 42.0),
            // Every decade, while there is room.
            Scale::Log10 => mark_target(height, 22.0),
        });
        let bars: Vec<Bar> = panel
            .layers
            .iter()
            .filter_map(|layer| match layer {
                Layer::Field(field) => Some(Bar::new(field, height)),
                _ => None,
            })
            .collect();

        let lines = |lines: &[String]| lines.len() as f64 * WORDS * LEADING;
        let gap = |lines: &[String]| if lines.is_empty() { 0.0 } else { LABEL_GAP };
        // Words centered on the box may be wider than it.
        let overhang = title
            .iter()
            .chain(&x_label)
            .map(|line| font::width(line, WORDS));
        let overhang = overhang
            .map(|words| (words - width) / 2.0)
            .fold(0.0, f64::max);
        let mark_overhang = |tick: &Tick, at_end: bool| {
            let place = width * panel.x.fraction(tick.at).unwrap_or(0.5);
            let half = font::width(&tick.label, NUMBERS) / 2.0;
            if at_end {
                place + half - width
            } else {
                half - place
            }
        };
        let end = x_marks
            .iter()
            .map(|t| mark_overhang(t, true))
            .fold(0.0, f64::max);
        let start = x_marks
            .iter()
            .map(|t| mark_overhang(t, false))
            .fold(0.0, f64::max);
        let axis = TICK + TICK_GAP + widest(&y_marks) + gap(&y_label) + lines(&y_label);
        let top = if title.is_empty() {
            8.0
        } else {
            lines(&title) + 6.0
        };
        Self {
            panel,
            width,
            height,
            left: axis.max(start).max(overhang),
            right: bars
                .iter()
                .map(|bar| bar.width)
                .sum::<f64>()
                .max(end)
                .max(overhang)
                .max(6.0),
            top,
            bottom: TICK + TICK_GAP + NUMBERS + gap(&x_label) / 2.0 + lines(&x_label),
            title,
            x_label,
            y_label,
            x_marks,
            y_marks,
            bars,
        }
    }

    fn draw(&self, pen: &mut Pen, left: f64, top: f64) {
        let frame = Frame {
            panel: self.panel,
            left,
            top,
            width: self.width,
            height: self.height,
        };
        for layer in &self.panel.layers {
            frame.draw(pen, layer);
            pen.rims |= matches!(layer, Layer::Regions(_) | Layer::Field(_));
        }
        pen.rims = false;
        let (right, bottom) = (left + self.width, top + self.height);
        let mut axes = PathBuilder::new();
        rectangle(&mut axes, (left, top), (right, bottom));
        for mark in &self.x_marks {
            let Some(x) = frame.x(mark.at) else { continue };
            let length = if mark.minor { 0.6 * TICK } else { TICK };
            segment(&mut axes, (x, bottom), (x, bottom + length));
            let place = (x, bottom + TICK + TICK_GAP + CAPITAL * NUMBERS);
            pen.words(mark.label.clone(), place, Anchor::Middle, NUMBERS);
        }
        for mark in &self.y_marks {
            let Some(y) = frame.y(mark.at) else { continue };
            let length = if mark.minor { 0.6 * TICK } else { TICK };
            segment(&mut axes, (left - length, y), (left, y));
            let place = (left - TICK - TICK_GAP, y + 0.5 * CAPITAL * NUMBERS);
            pen.words(mark.label.clone(), place, Anchor::End, NUMBERS);
        }
        pen.outline(axes, Paint::stroke(INK, 1.0, Dash::Solid));

        let line = WORDS * LEADING;
        let center = left + self.width / 2.0;
        for (i, words) in self.title.iter().rev().enumerate() {
            let place = (center, top - 9.0 - i as f64 * line);
            pen.words(words.clone(), place, Anchor::Middle, WORDS);
        }
        let below = bottom + TICK + TICK_GAP + NUMBERS + LABEL_GAP / 2.0;
        for (i, words) in self.x_label.iter().enumerate() {
            let place = (center, below + (i as f64 + 0.78) * line);
            pen.words(words.clone(), place, Anchor::Middle, WORDS);
        }
        let before = left - TICK - TICK_GAP - widest(&self.y_marks) - LABEL_GAP;
        for (i, words) in self.y_label.iter().rev().enumerate() {
            let place = (before - (i as f64 + 0.22) * line, top + self.height / 2.0);
            pen.words_upward(words.clone(), place, WORDS);
        }
        let mut start = right;
        for bar in &self.bars {
            bar.draw(pen, (start + BAR_GAP).round() + 0.5, top, self.height);
            start += bar.width;
        }
    }
}

/// The size of the box between the axes.
fn box_size(panel: &Panel, width: f64) -> (f64, f64) {
    let length = |axis: &Axis| {
        let (start, end) = axis.limits();
        (end - start).abs()
    };
    if !panel.equal_aspect || panel.x.scale != panel.y.scale {
        return (width, (0.75 * width).round());
    }
    // Beyond a shape of 1 to 8 a panel is a line; there the longer side is cut rather than the figure.
    let ratio = (length(&panel.y) / length(&panel.x)).clamp(0.125, 8.0);
    let highest = 1.2 * width;
    if ratio * width <= highest {
        (width, ratio * width)
    } else {
        (highest / ratio, highest)
    }
}

fn mark_target(length: f64, spacing: f64) -> usize {
    (length / spacing).floor().clamp(1.0, 9.0) as usize
}

/// Marks of a horizontal axis whose labels do not touch.
fn spaced_marks(axis: &Axis, width: f64) -> Vec<Tick> {
    let clear = |marks: &[Tick]| {
        let mut ends: Vec<(f64, f64)> = marks
            .iter()
            .filter(|mark| !mark.label.is_empty())
            .filter_map(|mark| {
                let half = font::width(&mark.label, NUMBERS) / 2.0;
                let place = width * axis.fraction(mark.at)?;
                Some((place - half, place + half))
            })
            .collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends.windows(2).all(|pair| pair[0].1 + 6.0 <= pair[1].0)
    };
    let mut target = mark_target(width, 48.0);
    let mut marks = axis.marks(target);
    while target > 1 && !clear(&marks) {
        target -= 1;
        marks = axis.marks(target);
    }
    // Named marks cannot be thinned by asking for fewer: keep the tick, drop the label that touches.
    for i in 1..=marks.len() {
        if !clear(&marks[..i]) {
            marks[i - 1].label.clear();
        }
    }
    marks
}

fn widest(marks: &[Tick]) -> f64 {
    let widths = marks.iter().map(|mark| font::width(&mark.label, NUMBERS));
    widths.fold(0.0, f64::max)
}

impl<'a> Bar<'a> {
    fn new(field: &'a Field, height: f64) -> Self {
        let axis = Axis::linear(field.label.clone(), field_range(field));
        let marks = axis.marks(mark_target(height, 42.0));
        let label = font::wrap(&field.label, WORDS, height + 10.0);
        let lines = label.len() as f64 * WORDS * LEADING;
        let width = BAR_GAP + BAR + TICK + TICK_GAP + widest(&marks) + LABEL_GAP + lines;
        Self {
            field,
            axis,
            marks,
            label,
            width,
        }
    }

    fn draw(&self, pen: &mut Pen, left: f64, top: f64, height: f64) {
        let range = self.axis.limits();
        let (right, bottom) = (left + BAR, top + height);
        let colors = (0..LEVELS).map(|level| level_color(self.field.map, level, range));
        for (level, color) in colors.enumerate() {
            let edge = |level: usize| bottom - height * level as f64 / f64::from(LEVELS);
            let mut patch = PathBuilder::new();
            rectangle(&mut patch, (left, edge(level)), (right, edge(level + 1)));
            pen.outline(patch, crisp(color));
        }
        let mut frame = PathBuilder::new();
        rectangle(&mut frame, (left, top), (right, bottom));
        for mark in &self.marks {
            let Some(fraction) = self.axis.fraction(mark.at) else {
                continue;
            };
            let y = bottom - height * fraction;
            segment(&mut frame, (right, y), (right + TICK, y));
            let place = (right + TICK + TICK_GAP, y + 0.5 * CAPITAL * NUMBERS);
            pen.words(mark.label.clone(), place, Anchor::Start, NUMBERS);
        }
        pen.outline(frame, Paint::stroke(INK, 1.0, Dash::Solid));
        // Points at the ends say that the map holds numbers beyond them.
        let shown = shown_values(self.field);
        let (low, high) = (range.0.min(range.1), range.0.max(range.1));
        let ends = [
            (shown.clone().any(|v| v > high), top, -9.0, high),
            (shown.clone().any(|v| v < low), bottom, 9.0, low),
        ];
        for (beyond, base, rise, end) in ends {
            if beyond {
                let mut point = PathBuilder::new();
                let corners = [(left, base), (left + BAR / 2.0, base + rise), (right, base)];
                polygon(&mut point, &corners);
                let mut paint = Paint::stroke(INK, 1.0, Dash::Solid);
                paint.fill = Some(self.field.map.color(end, range));
                pen.outline(point, paint);
            }
        }
        let line = WORDS * LEADING;
        let after = right + TICK + TICK_GAP + widest(&self.marks) + LABEL_GAP;
        for (i, words) in self.label.iter().enumerate() {
            let place = (after + (i as f64 + 0.78) * line, top + height / 2.0);
            pen.words_upward(words.clone(), place, WORDS);
        }
    }
}

/// The values of a field that have a cell.
fn shown_values(field: &Field) -> impl Iterator<Item = f64> + Clone {
    let cells = field.columns.saturating_mul(field.rows);
    field.values.iter().take(cells).copied()
}

/// The ends of the color bar, made finite and distinct.
fn field_range(field: &Field) -> (f64, f64) {
    let of_data = || {
        let finite = shown_values(field).filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        match field.map {
            ColorMap::Viridis => (low, high),
            ColorMap::Diverging => {
                let reach = low.abs().max(high.abs());
                (-reach, reach)
            }
        }
    };
    let (start, end) = field.range.unwrap_or_else(of_data);
    Axis::linear("", (start.min(end), start.max(end))).limits()
}

fn level_color(map: ColorMap, level: u8, range: (f64, f64)) -> Color {
    let t = (f64::from(level) + 0.5) / f64::from(LEVELS);
    map.color(range.0 + t * (range.1 - range.0), range)
}

/// The box of a panel in the picture.
struct Frame<'a> {
    panel: &'a Panel,
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

impl Frame<'_> {
    fn x(&self, number: f64) -> Option<f64> {
        Some(self.left + self.width * self.panel.x.fraction(number)?)
    }

    fn y(&self, number: f64) -> Option<f64> {
        Some(self.top + self.height * (1.0 - self.panel.y.fraction(number)?))
    }

    fn at(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        Some((self.x(x)?, self.y(y)?))
    }

    /// Whether a place is in the box, its edge included.
    fn holds(&self, (x, y): (f64, f64)) -> bool {
        let slack = 1e-6;
        (self.left - slack..=self.left + self.width + slack).contains(&x)
            && (self.top - slack..=self.top + self.height + slack).contains(&y)
    }

    fn draw(&self, pen: &mut Pen, layer: &Layer) {
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
                let (outline, paint) =
                    marker(points.marker, points.size, points.color, points.filled);
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

    /// A map of classes: one outline a color.
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
        for &point in &line.points {
            let place = self.at(point);
            if let (Some(from), Some(to)) = (last, place) {
                if let Some((from, to)) = self.clip(from, to) {
                    if drawn_to != Some(from) {
                        outline.move_to(from.0 as f32, from.1 as f32);
                    }
                    outline.line_to(to.0 as f32, to.1 as f32);
                    drawn_to = Some(to);
                }
            } else {
                drawn_to = None;
            }
            last = place;
        }
        pen.outline(
            outline,
            Paint::stroke(line.color, pixels(line.width), line.dash),
        );
    }

    /// The part of a segment inside the box (Liang and Barsky).
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

    /// An arrow as one filled outline; the part of its shaft in the box, and its head if the tip is there.
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

/// The level of a value; [`u8::MAX`] for none.
fn level(value: f64, (low, high): (f64, f64)) -> u8 {
    if value.is_nan() {
        return u8::MAX;
    }
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    ((t * f64::from(LEVELS)) as u8).min(LEVELS - 1)
}

fn crisp(color: Color) -> Paint {
    Paint {
        crisp: true,
        ..Paint::fill(color)
    }
}

/// A width or size as the caller wrote it, made drawable.
fn pixels(size: f64) -> f64 {
    if size.is_finite() {
        size.clamp(0.0, 100.0)
    } else {
        1.0
    }
}

/// A marker around the origin.
fn marker(marker: Marker, size: f64, color: Color, filled: bool) -> (PathBuilder, Paint) {
    let r = pixels(size) / 2.0;
    let mut outline = PathBuilder::new();
    match marker {
        Marker::Circle => {
            let (r, k) = (r as f32, (r * 0.552_284_75) as f32);
            outline.move_to(r, 0.0);
            outline.cubic_to(r, k, k, r, 0.0, r);
            outline.cubic_to(-k, r, -r, k, -r, 0.0);
            outline.cubic_to(-r, -k, -k, -r, 0.0, -r);
            outline.cubic_to(k, -r, r, -k, r, 0.0);
            outline.close();
        }
        // Centered on the centroid, so that the data point is where the eye puts it.
        Marker::Triangle => {
            let r = 1.2 * r;
            polygon(
                &mut outline,
                &[(0.0, -r), (0.866 * r, 0.5 * r), (-0.866 * r, 0.5 * r)],
            );
        }
        Marker::Square => rectangle(&mut outline, (-0.9 * r, -0.9 * r), (0.9 * r, 0.9 * r)),
        Marker::Cross => {
            segment(&mut outline, (-r, -r), (r, r));
            segment(&mut outline, (-r, r), (r, -r));
        }
    }
    let paint = match (marker, filled) {
        (Marker::Cross, _) => Paint::stroke(color, 1.6, Dash::Solid),
        (_, true) => Paint::fill(color),
        (_, false) => Paint {
            fill: Some(palette::WHITE),
            ..Paint::stroke(color, 1.3, Dash::Solid)
        },
    };
    (outline, paint)
}

fn symbol_width(symbol: Symbol) -> f64 {
    match symbol {
        Symbol::Patch(_) => 20.0,
        Symbol::Line {
            direction: Direction::Vertical,
            ..
        } => 6.0,
        Symbol::Marker { .. } => 10.0,
        Symbol::Line { .. } | Symbol::Arrow(_) => 26.0,
    }
}

fn entry_width(entry: &LegendEntry) -> f64 {
    symbol_width(entry.symbol) + SYMBOL_GAP + font::width(&entry.name, NUMBERS)
}

/// Entries in rows no wider than `available`, with the width of each row.
fn legend_rows(entries: &[LegendEntry], available: f64) -> Vec<(f64, Vec<&LegendEntry>)> {
    let mut rows: Vec<(f64, Vec<&LegendEntry>)> = Vec::new();
    for entry in entries {
        let more = ENTRY_GAP + entry_width(entry);
        match rows.last_mut() {
            Some((used, row)) if *used + more <= available => {
                *used += more;
                row.push(entry);
            }
            _ => rows.push((entry_width(entry), vec![entry])),
        }
    }
    rows
}

/// Entries in centered rows; returns where the legend ends.
fn draw_legend(pen: &mut Pen, entries: &[LegendEntry], width: f64, top: f64) -> f64 {
    let mut available = width - 2.0 * PADDING;
    let mut rows = legend_rows(entries, available);
    // As narrow as it goes without one row more, so that the rows are about equal.
    while available > 0.0 {
        available -= 8.0;
        let narrower = legend_rows(entries, available);
        if narrower.len() > rows.len() {
            break;
        }
        rows = narrower;
    }
    let mut y = top;
    for (used, row) in rows {
        let mut x = (width - used) / 2.0;
        let middle = (y + LEGEND_ROW / 2.0).round() + 0.5;
        for entry in row {
            draw_symbol(pen, entry.symbol, x, middle);
            let place = (
                x + symbol_width(entry.symbol) + SYMBOL_GAP,
                middle + 0.5 * CAPITAL * NUMBERS,
            );
            pen.words(entry.name.clone(), place, Anchor::Start, NUMBERS);
            x += entry_width(entry) + ENTRY_GAP;
        }
        y += LEGEND_ROW;
    }
    y
}

fn draw_symbol(pen: &mut Pen, symbol: Symbol, left: f64, middle: f64) {
    let width = symbol_width(symbol);
    let (right, center) = (left + width, left + width / 2.0);
    let mut outline = PathBuilder::new();
    match symbol {
        Symbol::Patch(color) => {
            let left = left.round() + 0.5;
            rectangle(
                &mut outline,
                (left, middle - 7.0),
                (left + width, middle + 7.0),
            );
            let mut paint = Paint::stroke(palette::GREY, 0.75, Dash::Solid);
            paint.fill = Some(color);
            pen.outline(outline, paint);
        }
        Symbol::Line {
            color,
            width,
            dash,
            direction,
        } => {
            match direction {
                Direction::Horizontal => segment(&mut outline, (left, middle), (right, middle)),
                Direction::Vertical => {
                    segment(&mut outline, (center, middle - 8.0), (center, middle + 8.0));
                }
            }
            let width = pixels(width).min(8.0);
            pen.outline(outline, Paint::stroke(color, width, dash));
        }
        Symbol::Marker {
            color,
            marker: shape,
            filled,
        } => {
            let (outline, paint) = marker(shape, 8.0, color, filled);
            pen.stamps(outline, vec![(center, middle)], paint);
        }
        Symbol::Arrow(color) => {
            let (neck, inner, half) = (right - 8.0, right - 6.4, 2.9);
            let corners = [
                (right, middle),
                (neck, middle + half),
                (inner, middle + 0.65),
                (left, middle + 0.65),
                (left, middle - 0.65),
                (inner, middle - 0.65),
                (neck, middle - half),
            ];
            polygon(&mut outline, &corners);
            pen.outline(outline, Paint::fill(color));
        }
    }
}

/// Collects the shapes of a scene; what has no extent is left out.
#[derive(Default)]
struct Pen {
    shapes: Vec<Shape>,
    /// Put a white rim around what is drawn, so that it shows on any color.
    rims: bool,
}

impl Pen {
    fn outline(&mut self, outline: PathBuilder, paint: Paint) {
        if let Some(outline) = finish(outline, &paint) {
            let rim = self.rim(&paint).map(|paint| Shape::Outline {
                outline: outline.clone(),
                paint,
            });
            self.shapes.extend(rim);
            self.shapes.push(Shape::Outline { outline, paint });
        }
    }

    fn stamps(&mut self, outline: PathBuilder, at: Vec<(f64, f64)>, paint: Paint) {
        if let Some(outline) = finish(outline, &paint) {
            let rim = self.rim(&paint).map(|paint| Shape::Stamps {
                outline: outline.clone(),
                at: at.clone(),
                paint,
            });
            self.shapes.extend(rim);
            self.shapes.push(Shape::Stamps { outline, at, paint });
        }
    }

    fn rim(&self, paint: &Paint) -> Option<Paint> {
        let width = paint.stroke.map_or(0.0, |stroke| stroke.width) + 2.0;
        (self.rims && !paint.crisp).then(|| Paint::stroke(palette::WHITE, width, Dash::Solid))
    }

    fn words(&mut self, text: String, at: (f64, f64), anchor: Anchor, size: f64) {
        if !text.is_empty() {
            self.shapes.push(Shape::Words(Words {
                text,
                at,
                anchor,
                upward: false,
                size,
                color: INK,
                rim: false,
            }));
        }
    }

    fn words_upward(&mut self, text: String, at: (f64, f64), size: f64) {
        self.words(text, at, Anchor::Middle, size);
        if let Some(Shape::Words(words)) = self.shapes.last_mut() {
            words.upward = true;
        }
    }
}

fn finish(outline: PathBuilder, paint: &Paint) -> Option<Path> {
    let is_visible = |stroke: Stroke| stroke.width > 0.0;
    (paint.fill.is_some() || paint.stroke.is_some_and(is_visible)).then(|| outline.finish())?
}

fn segment(outline: &mut PathBuilder, from: (f64, f64), to: (f64, f64)) {
    outline.move_to(from.0 as f32, from.1 as f32);
    outline.line_to(to.0 as f32, to.1 as f32);
}

fn polygon(outline: &mut PathBuilder, corners: &[(f64, f64)]) {
    for (i, &(x, y)) in corners.iter().enumerate() {
        if i == 0 {
            outline.move_to(x as f32, y as f32);
        } else {
            outline.line_to(x as f32, y as f32);
        }
    }
    outline.close();
}

fn rectangle(outline: &mut PathBuilder, from: (f64, f64), to: (f64, f64)) {
    polygon(outline, &[from, (to.0, from.1), to, (from.0, to.1)]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_aspect_is_truly_equal() {
        for (x, y) in [
            ((0.0, 1.0), (0.0, 1.0)),
            ((0.0, 1.0), (0.0, 5.0)),
            ((2.0, -2.0), (0.0, 1.0)),
        ] {
            let panel = Panel::new("", Axis::linear("", x), Axis::linear("", y)).equal_aspect();
            let (width, height) = box_size(&panel, 300.0);
            let (in_x, in_y) = (width / (x.1 - x.0).abs(), height / (y.1 - y.0).abs());
            assert!(
                (in_x - in_y).abs() < 1e-9,
                "{in_x} and {in_y} pixels a unit"
            );
            assert!(width <= 300.0 && height <= 360.0 + 1e-9);
        }
    }

    #[test]
    fn labels_of_a_horizontal_axis_do_not_touch() {
        for range in [(0.0, 1e6), (-1e-7, 1e-7), (1000.001, 1000.009), (-0.5, 2.5)] {
            for width in [60.0, 150.0, 300.0] {
                let axis = Axis::linear("", range);
                let marks = spaced_marks(&axis, width);
                let mut end = f64::NEG_INFINITY;
                for mark in marks.iter().filter(|mark| !mark.label.is_empty()) {
                    let half = font::width(&mark.label, NUMBERS) / 2.0;
                    let place = axis.fraction(mark.at).unwrap() * width;
                    assert!(place - half > end, "{marks:?} at {width}");
                    end = place + half;
                }
            }
        }
    }

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
