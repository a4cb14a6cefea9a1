//! Shared legend outside the panels.

use super::pen::{CAPITAL, NUMBERS, Pen, marker, pixels, polygon, rectangle, segment};
use super::scene::{Anchor, Paint};
use super::{Color, Dash, Direction, Layer, Marker, Panel, font, palette};
use serde::Serialize;
use tiny_skia::PathBuilder;

/// Gaps after a symbol, after a name, and between rows.
const SYMBOL_GAP: f64 = 7.0;
const ENTRY_GAP: f64 = 24.0;
const LEGEND_ROW: f64 = 21.0;
/// Distance between the lines of a long name.
const LINE: f64 = 15.0;

/// Symbol with its meaning.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LegendEntry {
    /// Name next to the symbol.
    pub name: String,
    /// Symbol of the layer or class.
    pub symbol: Symbol,
}

/// Symbol of a layer in the legend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Symbol {
    /// Patch in the color of a class.
    Patch(Color),
    /// Short piece of a line.
    Line {
        /// Color of the line.
        color: Color,
        /// Width of the line in pixels.
        width: f64,
        /// Dash pattern of the line.
        dash: Dash,
        /// Vertical for a vertical line, horizontal for all others.
        direction: Direction,
    },
    /// Marker as in the panel.
    Marker {
        /// Color of the marker.
        color: Color,
        /// Shape of the marker.
        marker: Marker,
        /// Whether the marker is filled.
        filled: bool,
    },
    /// Arrow in the given color.
    Arrow(Color),
}

/// Collects the named layers and classes without duplicates; maps come first and form one block.
pub(super) fn collect(panels: &[Panel]) -> Vec<LegendEntry> {
    let layers = || panels.iter().flat_map(|panel| &panel.layers);
    let mut entries: Vec<LegendEntry> = Vec::new();
    let mut add = |name: &str, symbol: Symbol| {
        let is_new = !entries.iter().any(|e| e.name == name && e.symbol == symbol);
        if is_new && !name.is_empty() {
            let name = name.to_string();
            entries.push(LegendEntry { name, symbol });
        }
    };

    // The classes of a key keep their order, independent of how they are spread over the panels.
    let maps = || {
        layers().filter_map(|layer| match layer {
            Layer::Regions(regions) => Some(regions),
            _ => None,
        })
    };
    for map in maps() {
        let mut occurs = [false; 256];
        for same in maps().filter(|other| other.key == map.key) {
            let cells = same.columns.saturating_mul(same.rows);
            for &class in same.classes.iter().take(cells) {
                occurs[usize::from(class)] = true;
            }
        }
        for ((name, color), _) in map.key.iter().zip(occurs).filter(|(_, occurs)| *occurs) {
            add(name, Symbol::Patch(*color));
        }
    }

    for layer in layers() {
        let (name, symbol) = match layer {
            Layer::Line(line) => (
                &line.name,
                Symbol::Line {
                    color: line.color,
                    width: line.width,
                    dash: line.dash,
                    direction: Direction::Horizontal,
                },
            ),
            Layer::Rule(rule) => (
                &rule.name,
                Symbol::Line {
                    color: rule.color,
                    width: 1.0,
                    dash: rule.dash,
                    direction: rule.direction,
                },
            ),
            Layer::Points(points) => (
                &points.name,
                Symbol::Marker {
                    color: points.color,
                    marker: points.marker,
                    filled: points.filled,
                },
            ),
            Layer::Arrows(arrows) => (&arrows.name, Symbol::Arrow(arrows.color)),
            Layer::Balls(balls) => {
                if let Some(name) = &balls.arrow_name {
                    add(name, Symbol::Arrow(balls.arrow_color));
                }
                let symbol = Symbol::Marker {
                    color: balls.color,
                    marker: Marker::Circle,
                    filled: true,
                };
                (&balls.name, symbol)
            }
            Layer::Regions(_) | Layer::Field(_) | Layer::Label(_) => continue,
        };
        if let Some(name) = name {
            add(name, symbol);
        }
    }
    entries
}

fn symbol_width(symbol: Symbol) -> f64 {
    match symbol {
        Symbol::Patch(_) => 20.0,
        Symbol::Line {
            direction: Direction::Vertical,
            ..
        } => 6.0,
        Symbol::Marker {
            marker: Marker::Left | Marker::Right,
            ..
        } => 16.0,
        Symbol::Marker { .. } => 10.0,
        Symbol::Line { .. } | Symbol::Arrow(_) => 26.0,
    }
}

pub(super) fn entry_width(entry: &LegendEntry) -> f64 {
    let lines = entry.name.lines().map(|line| font::width(line, NUMBERS));
    symbol_width(entry.symbol) + SYMBOL_GAP + lines.fold(0.0, f64::max)
}

/// Divides names that are wider than `available` into lines.
pub(super) fn wrapped(mut entries: Vec<LegendEntry>, available: f64) -> Vec<LegendEntry> {
    for entry in &mut entries {
        if entry_width(entry) > available {
            let room = available - symbol_width(entry.symbol) - SYMBOL_GAP;
            entry.name = font::wrap(&entry.name, NUMBERS, room).join("\n");
        }
    }
    entries
}

/// Distributes entries over rows no wider than `available`; returns them with the width of each row.
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

/// Draws the entries in rows that begin at one place, centered between left and right, and returns the lower end of the legend.
pub(super) fn draw(
    pen: &mut Pen,
    entries: &[LegendEntry],
    (left, right): (f64, f64),
    top: f64,
) -> f64 {
    let mut available = right - left;
    let mut rows = legend_rows(entries, available);
    // The width is reduced while the number of rows stays the same, which balances the lengths of the rows.
    while available > 0.0 {
        available -= 8.0;
        let narrower = legend_rows(entries, available);
        if narrower.len() > rows.len() {
            break;
        }
        rows = narrower;
    }
    let widest = rows.iter().map(|(used, _)| *used).fold(0.0, f64::max);
    let mut y = top;
    for (_, row) in rows {
        let lines = row.iter().map(|entry| entry.name.lines().count());
        let more = lines.max().unwrap_or(1).saturating_sub(1);
        let mut x = (left + right - widest) / 2.0;
        let middle = (y + LEGEND_ROW / 2.0).round() + 0.5;
        for entry in row {
            draw_symbol(pen, entry.symbol, x, middle);
            let start = x + symbol_width(entry.symbol) + SYMBOL_GAP;
            for (n, line) in entry.name.lines().enumerate() {
                let base = middle + 0.5 * CAPITAL * NUMBERS + n as f64 * LINE;
                pen.words(line.to_owned(), (start, base), Anchor::Start, NUMBERS);
            }
            x += entry_width(entry) + ENTRY_GAP;
        }
        y += LEGEND_ROW + more as f64 * LINE;
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
