//! The shared legend: words outside the panels.

use super::{Color, Dash, Direction, Layer, Marker, Panel};

/// A symbol and what it means.
#[derive(Debug, Clone, PartialEq)]
pub struct LegendEntry {
    /// What it means.
    pub name: String,
    /// How it is drawn.
    pub symbol: Symbol,
}

/// How a layer looks in the legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Symbol {
    /// A patch of a map.
    Patch(Color),
    /// A piece of a line.
    Line {
        /// Color.
        color: Color,
        /// Width in pixels.
        width: f64,
        /// Dashes.
        dash: Dash,
        /// Upright for a vertical line, lying for all others.
        direction: Direction,
    },
    /// A marker.
    Marker {
        /// Color.
        color: Color,
        /// Shape.
        marker: Marker,
        /// Filled or open.
        filled: bool,
    },
    /// An arrow.
    Arrow(Color),
}

/// What the layers name, each once; maps first, so that they read as one block.
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

    // Every key in its own order, however its classes are spread over the panels.
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
            Layer::Regions(_) | Layer::Field(_) | Layer::Label(_) => continue,
        };
        if let Some(name) = name {
            add(name, symbol);
        }
    }
    entries
}
