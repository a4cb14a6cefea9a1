//! Layers of a panel: maps, curves, points, arrows and labels.

use super::{Color, ColorMap, palette};
use serde::Serialize;

/// A layer of a [`Panel`](super::Panel), drawn over the layers before it.
///
/// Numbers that are not finite are never drawn. Everything is clipped to the panel. Layers over a map get a white rim, so that they are visible on
/// every color.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layer {
    /// Categorical map on a grid.
    Regions(Regions),
    /// Map of numbers, with a color bar.
    Field(Field),
    /// Curve through a list of vertices.
    Line(Line),
    /// Markers at a list of points.
    Points(Points),
    /// Arrows between pairs of points, as displacements.
    Arrows(Arrows),
    /// Shaded balls with arrows.
    Balls(Balls),
    /// Short text at a point.
    Label(Label),
    /// Straight line across the whole panel.
    Rule(Rule),
}

/// Categorical map on a uniform grid.
///
/// The grid divides the rectangle evenly in the scale of the axes (in the logarithm on a logarithmic axis); each sample lies in the middle of
/// its cell.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Regions {
    /// Left and right edge of the grid.
    pub x: (f64, f64),
    /// Lower and upper edge of the grid.
    pub y: (f64, f64),
    /// Number of cells along x.
    pub columns: usize,
    /// Number of cells along y.
    pub rows: usize,
    /// Index into `key` for each cell, row after row from the smallest y; an index beyond the key leaves a blank.
    pub classes: Vec<u8>,
    /// Name and color of each class.
    pub key: Vec<(String, Color)>,
}

/// Map of numbers on a grid, as in [`Regions`], with a color bar.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Field {
    /// Left and right edge of the grid.
    pub x: (f64, f64),
    /// Lower and upper edge of the grid.
    pub y: (f64, f64),
    /// Number of cells along x.
    pub columns: usize,
    /// Number of cells along y.
    pub rows: usize,
    /// Value of each cell, row after row from the smallest y; NaN leaves a blank, infinite values get the end colors.
    pub values: Vec<f64>,
    /// Quantity shown, with its unit.
    pub label: String,
    /// Color map of the numbers.
    pub map: ColorMap,
    /// Numbers at the ends of the color bar; the range of the data if `None`.
    pub range: Option<(f64, f64)>,
}

/// Curve through a list of vertices.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Line {
    /// Vertices; a NaN interrupts the curve.
    pub points: Vec<(f64, f64)>,
    /// Name in the legend; `None` for no entry.
    pub name: Option<String>,
    /// Color of the curve.
    pub color: Color,
    /// Width of the curve in pixels.
    pub width: f64,
    /// Dash pattern of the curve.
    pub dash: Dash,
}

/// Dash pattern of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Dash {
    /// One continuous stroke without gaps.
    #[default]
    Solid,
    /// A line of long dashes.
    Dashed,
    /// A line of dots.
    Dotted,
    /// Dashes and dots by turns.
    Dashdot,
}

/// Markers at a list of points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Points {
    /// Positions of the markers.
    pub points: Vec<(f64, f64)>,
    /// Name in the legend; `None` for no entry.
    pub name: Option<String>,
    /// Color of the markers.
    pub color: Color,
    /// Diameter of the markers in pixels.
    pub size: f64,
    /// Diameter in units of the horizontal axis, which replaces `size`.
    pub extent: Option<f64>,
    /// Shape of the markers.
    pub marker: Marker,
    /// Whether the markers are filled; otherwise they are white with an outline.
    pub filled: bool,
}

/// Shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Marker {
    /// Disk centered at the point.
    #[default]
    Circle,
    /// Triangle with a horizontal base.
    Triangle,
    /// Square centered at the point.
    Square,
    /// Two crossing strokes, which ignore `filled`.
    Cross,
    /// Arrow to the left, wider than the other markers; it ignores `filled`.
    Left,
    /// Arrow to the right, wider than the other markers; it ignores `filled`.
    Right,
}

/// Arrows between pairs of points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Arrows {
    /// Tails of the arrows.
    pub from: Vec<(f64, f64)>,
    /// Tips of the arrows, one for each tail.
    pub to: Vec<(f64, f64)>,
    /// Name in the legend; `None` for no entry.
    pub name: Option<String>,
    /// Color of the arrows.
    pub color: Color,
    /// Width of the shaft in pixels.
    pub width: f64,
}

/// Projected balls, each with an arrow from its center; drawn in the order of the list, the farthest first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Balls {
    /// Balls, the farthest first.
    pub balls: Vec<Ball>,
    /// Name of the balls in the legend; `None` for no entry.
    pub name: Option<String>,
    /// Color of the balls.
    pub color: Color,
    /// Name of the arrows in the legend; `None` for no entry.
    pub arrow_name: Option<String>,
    /// Color of the arrows.
    pub arrow_color: Color,
    /// Width of the shafts in pixels.
    pub arrow_width: f64,
}

/// Projection of a ball with its arrow.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ball {
    /// Center of the ball.
    pub at: (f64, f64),
    /// Radius, measured along the horizontal axis.
    pub radius: f64,
    /// Paleness, from 0 (near) to 1 (far).
    pub fade: f64,
    /// Tip of the arrow; `None` for no arrow.
    pub tip: Option<(f64, f64)>,
}

/// Word centered at a point but kept inside the panel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Label {
    /// Center of the word.
    pub at: (f64, f64),
    /// Text of the label.
    pub text: String,
    /// Color of the word; a white rim keeps it legible on any map.
    pub color: Color,
}

/// Straight line across the whole panel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rule {
    /// Direction of the line.
    pub direction: Direction,
    /// The x of a vertical line, the y of a horizontal one.
    pub at: f64,
    /// Name in the legend; `None` for no entry.
    pub name: Option<String>,
    /// Color of the line.
    pub color: Color,
    /// Dash pattern of the line.
    pub dash: Dash,
}

/// The direction of a [`Rule`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Line at a constant y.
    Horizontal,
    /// Line at a constant x.
    Vertical,
}

impl Regions {
    /// Creates a map of classes whose names and colors are in `key`.
    pub fn new<S: Into<String>>(
        x: (f64, f64),
        y: (f64, f64),
        (columns, rows): (usize, usize),
        classes: Vec<u8>,
        key: impl IntoIterator<Item = (S, Color)>,
    ) -> Self {
        let key = key.into_iter().map(|(name, color)| (name.into(), color));
        Self {
            x,
            y,
            columns,
            rows,
            classes,
            key: key.collect(),
        }
    }

    /// Creates a map of words, row after row. Verdicts have their fixed colors; other words get the colors of [`palette::SERIES`] in order.
    ///
    /// ```
    /// use onset_study::figure::{Regions, palette};
    /// let map = Regions::of_words((0.0, 1.0), (0.0, 1.0), (2, 1), ["numerical", "stable"]);
    /// let (name, color) = &map.key[usize::from(map.classes[0])];
    /// assert_eq!((name.as_str(), Some(*color)), ("numerical", palette::verdict("numerical")));
    /// ```
    pub fn of_words<S: AsRef<str>>(
        x: (f64, f64),
        y: (f64, f64),
        (columns, rows): (usize, usize),
        words: impl IntoIterator<Item = S>,
    ) -> Self {
        let mut key = palette::VERDICTS
            .map(|(name, color)| (name.to_string(), color))
            .to_vec();
        let mut classes = Vec::with_capacity(columns.saturating_mul(rows).min(1 << 24));
        for word in words {
            let word = word.as_ref();
            let class = key.iter().position(|(name, _)| name == word);
            classes.push(class.unwrap_or_else(|| {
                let turn = (key.len() - palette::VERDICTS.len()) % palette::SERIES.len();
                key.push((word.to_string(), palette::SERIES[turn]));
                key.len() - 1
            }));
        }
        let classes = classes
            .into_iter()
            .map(|class| u8::try_from(class).unwrap_or(u8::MAX));
        Self::new(x, y, (columns, rows), classes.collect(), key)
    }
}

impl Field {
    /// Creates a map of numbers in [`ColorMap::Viridis`] over the range of the data.
    pub fn new(
        x: (f64, f64),
        y: (f64, f64),
        (columns, rows): (usize, usize),
        values: Vec<f64>,
        label: impl Into<String>,
    ) -> Self {
        Self {
            x,
            y,
            columns,
            rows,
            values,
            label: label.into(),
            map: ColorMap::Viridis,
            range: None,
        }
    }

    /// Uses the color map [`ColorMap::Diverging`], which shows the sign.
    pub fn diverging(mut self) -> Self {
        self.map = ColorMap::Diverging;
        self
    }

    /// Sets the values at the ends of the color bar.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }
}

impl Line {
    /// Creates a solid black curve.
    pub fn new(points: Vec<(f64, f64)>) -> Self {
        Self {
            points,
            name: None,
            color: palette::BLACK,
            width: 1.6,
            dash: Dash::Solid,
        }
    }

    /// Sets the width in pixels.
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
    }
}

impl Points {
    /// Creates filled black discs at the points.
    pub fn new(points: Vec<(f64, f64)>) -> Self {
        Self {
            points,
            name: None,
            color: palette::BLACK,
            size: 6.0,
            extent: None,
            marker: Marker::Circle,
            filled: true,
        }
    }

    /// Sets the shape of the markers.
    pub fn marker(mut self, marker: Marker) -> Self {
        self.marker = marker;
        self
    }

    /// Sets the diameter in pixels.
    pub fn size(mut self, size: f64) -> Self {
        self.size = size;
        self
    }

    /// Sets the diameter in units of the horizontal axis.
    pub fn extent(mut self, extent: f64) -> Self {
        self.extent = Some(extent);
        self
    }

    /// Draws the markers white with an outline.
    pub fn open(mut self) -> Self {
        self.filled = false;
        self
    }
}

impl Arrows {
    /// Creates black arrows from each point of `from` to the corresponding point of `to`.
    pub fn new(from: Vec<(f64, f64)>, to: Vec<(f64, f64)>) -> Self {
        Self {
            from,
            to,
            name: None,
            color: palette::BLACK,
            width: 1.3,
        }
    }
}

impl Balls {
    /// Creates blue balls with vermilion arrows.
    pub fn new(balls: Vec<Ball>) -> Self {
        Self {
            balls,
            name: None,
            color: palette::BLUE,
            arrow_name: None,
            arrow_color: palette::VERMILION,
            arrow_width: 1.8,
        }
    }

    /// Sets the name of the arrows in the legend.
    pub fn arrows_named(mut self, name: impl Into<String>) -> Self {
        self.arrow_name = Some(name.into());
        self
    }
}

impl Label {
    /// Creates a black word centered at a point.
    pub fn new(at: (f64, f64), text: impl Into<String>) -> Self {
        Self {
            at,
            text: text.into(),
            color: palette::BLACK,
        }
    }

    /// Sets the color of the word.
    pub fn color(mut self, color: Color) -> Self {
        self.color = color;
        self
    }
}

impl Rule {
    /// Creates a thin grey line at `x = at`.
    pub fn vertical(at: f64) -> Self {
        Self {
            direction: Direction::Vertical,
            at,
            name: None,
            color: palette::GREY,
            dash: Dash::Solid,
        }
    }

    /// Creates a thin grey line at `y = at`.
    pub fn horizontal(at: f64) -> Self {
        Self {
            direction: Direction::Horizontal,
            ..Self::vertical(at)
        }
    }
}

/// Defines `named` and `color` for layers with an entry in the legend.
macro_rules! named {
    ($($layer:ident),*) => {$(
        impl $layer {
            /// Sets the name in the legend.
            pub fn named(mut self, name: impl Into<String>) -> Self {
                self.name = Some(name.into());
                self
            }

            /// Sets the color of the layer.
            pub fn color(mut self, color: Color) -> Self {
                self.color = color;
                self
            }
        }
    )*};
}
named!(Line, Points, Arrows, Balls, Rule);

/// Defines `dash`, `dashed` and `dotted` for layers of lines.
macro_rules! dashed {
    ($($layer:ident),*) => {$(
        impl $layer {
            /// Draws the line in dashes.
            pub fn dashed(self) -> Self {
                self.dash(Dash::Dashed)
            }

            /// Draws the line in dots.
            pub fn dotted(self) -> Self {
                self.dash(Dash::Dotted)
            }

            /// Sets the dash pattern.
            pub fn dash(mut self, dash: Dash) -> Self {
                self.dash = dash;
                self
            }
        }
    )*};
}
dashed!(Line, Rule);

macro_rules! into_layer {
    ($($layer:ident),*) => {$(
        impl From<$layer> for Layer {
            fn from(layer: $layer) -> Self {
                Self::$layer(layer)
            }
        }
    )*};
}
into_layer!(Regions, Field, Line, Points, Arrows, Balls, Label, Rule);
