//! What a panel shows: maps, curves, points, arrows, words.

use super::{Color, ColorMap, palette};

/// One thing drawn in a [`Panel`](super::Panel), over the layers before it.
///
/// Numbers that are not finite are never drawn. Everything is clipped to the panel. What lies over a map gets a white rim, so that it
/// shows on every color.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// A categorical map.
    Regions(Regions),
    /// A map of numbers, with a color bar.
    Field(Field),
    /// A curve.
    Line(Line),
    /// Markers.
    Points(Points),
    /// Arrows.
    Arrows(Arrows),
    /// Shaded balls with arrows.
    Balls(Balls),
    /// A word in the plane.
    Label(Label),
    /// A straight line across the whole panel.
    Rule(Rule),
}

/// A categorical map on a grid that divides the rectangle evenly, as the axes measure it (evenly in the logarithm on a
/// logarithmic axis); each class is one cell wide around its sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Regions {
    /// Left and right edge of the grid.
    pub x: (f64, f64),
    /// Lower and upper edge of the grid.
    pub y: (f64, f64),
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// Index into `key` of each cell, row after row from the smallest y; an index beyond the key leaves a blank.
    pub classes: Vec<u8>,
    /// Name and color of each class.
    pub key: Vec<(String, Color)>,
}

/// A map of numbers on a grid as in [`Regions`], with a color bar.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Field {
    /// Left and right edge of the grid.
    pub x: (f64, f64),
    /// Lower and upper edge of the grid.
    pub y: (f64, f64),
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// Value of each cell, row after row from the smallest y; NaN leaves a blank, infinities take the end colors.
    pub values: Vec<f64>,
    /// What is measured, with its unit.
    pub label: String,
    /// How numbers become colors.
    pub map: ColorMap,
    /// The numbers at the ends of the color bar; those of the data if `None`.
    pub range: Option<(f64, f64)>,
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The vertices; a NaN breaks the curve.
    pub points: Vec<(f64, f64)>,
    /// Name in the legend.
    pub name: Option<String>,
    /// Color.
    pub color: Color,
    /// Width in pixels.
    pub width: f64,
    /// Dashes.
    pub dash: Dash,
}

/// The dashes of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Dash {
    /// Drawn through.
    #[default]
    Solid,
    /// Long dashes.
    Dashed,
    /// Dots.
    Dotted,
}

/// Markers at points.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    /// Where the markers are.
    pub points: Vec<(f64, f64)>,
    /// Name in the legend.
    pub name: Option<String>,
    /// Color.
    pub color: Color,
    /// Diameter in pixels.
    pub size: f64,
    /// Shape.
    pub marker: Marker,
    /// Filled, or only an outline around white.
    pub filled: bool,
}

/// The shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Marker {
    /// A disc.
    #[default]
    Circle,
    /// A triangle that stands on its base.
    Triangle,
    /// A square.
    Square,
    /// Two crossing strokes; filled or not is the same.
    Cross,
}

/// Arrows from points to points.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrows {
    /// The tails.
    pub from: Vec<(f64, f64)>,
    /// The tips, one a tail.
    pub to: Vec<(f64, f64)>,
    /// Name in the legend.
    pub name: Option<String>,
    /// Color.
    pub color: Color,
    /// Width of the shaft in pixels.
    pub width: f64,
}

/// Balls in space as they are seen, each with an arrow from its center; drawn in the order of the list, the farthest first.
#[derive(Debug, Clone, PartialEq)]
pub struct Balls {
    /// The balls.
    pub balls: Vec<Ball>,
    /// Name of the balls in the legend.
    pub name: Option<String>,
    /// Color of the balls.
    pub color: Color,
    /// Name of the arrows in the legend.
    pub arrow_name: Option<String>,
    /// Color of the arrows.
    pub arrow_color: Color,
    /// Width of the shafts in pixels.
    pub arrow_width: f64,
}

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Its center.
    pub at: (f64, f64),
    /// Its radius, measured along the horizontal axis.
    pub radius: f64,
    /// How pale it is, from 0 (near) to 1 (far).
    pub fade: f64,
    /// The tip of its arrow.
    pub tip: Option<(f64, f64)>,
}

/// A word in the plane, centered at a point but kept inside the panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// Where the word is.
    pub at: (f64, f64),
    /// The word.
    pub text: String,
    /// Color; a white rim keeps the word legible on any map.
    pub color: Color,
}

/// A straight line across the whole panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Direction of the line.
    pub direction: Direction,
    /// Its x if it is vertical, its y if it is horizontal.
    pub at: f64,
    /// Name in the legend.
    pub name: Option<String>,
    /// Color.
    pub color: Color,
    /// Dashes.
    pub dash: Dash,
}

/// The direction of a [`Rule`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// At a constant y.
    Horizontal,
    /// At a constant x.
    Vertical,
}

impl Regions {
    /// A map of classes whose names and colors are in `key`.
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

    /// A map of words, row after row: verdicts take their fixed colors, other words those of [`palette::SERIES`] in turn.
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
    /// A map of numbers in [`ColorMap::Viridis`] over the range of the data.
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

    /// Show the sign: [`ColorMap::Diverging`].
    pub fn diverging(mut self) -> Self {
        self.map = ColorMap::Diverging;
        self
    }

    /// Fix the numbers at the ends of the color bar.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }
}

impl Line {
    /// A solid black curve.
    pub fn new(points: Vec<(f64, f64)>) -> Self {
        Self {
            points,
            name: None,
            color: palette::BLACK,
            width: 1.6,
            dash: Dash::Solid,
        }
    }

    /// Set the width in pixels.
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
    }
}

impl Points {
    /// Filled black discs.
    pub fn new(points: Vec<(f64, f64)>) -> Self {
        Self {
            points,
            name: None,
            color: palette::BLACK,
            size: 6.0,
            marker: Marker::Circle,
            filled: true,
        }
    }

    /// Set the shape.
    pub fn marker(mut self, marker: Marker) -> Self {
        self.marker = marker;
        self
    }

    /// Set the diameter in pixels.
    pub fn size(mut self, size: f64) -> Self {
        self.size = size;
        self
    }

    /// Draw only the outline, around white.
    pub fn open(mut self) -> Self {
        self.filled = false;
        self
    }
}

impl Arrows {
    /// Black arrows from each point of `from` to the same point of `to`.
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
    /// Blue balls with vermilion arrows.
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

    /// Give the arrows a name in the legend.
    pub fn arrows_named(mut self, name: impl Into<String>) -> Self {
        self.arrow_name = Some(name.into());
        self
    }
}

impl Label {
    /// A black word centered at a point.
    pub fn new(at: (f64, f64), text: impl Into<String>) -> Self {
        Self {
            at,
            text: text.into(),
            color: palette::BLACK,
        }
    }

    /// Set the color.
    pub fn color(mut self, color: Color) -> Self {
        self.color = color;
        self
    }
}

impl Rule {
    /// A thin grey line at `x = at`.
    pub fn vertical(at: f64) -> Self {
        Self {
            direction: Direction::Vertical,
            at,
            name: None,
            color: palette::GREY,
            dash: Dash::Solid,
        }
    }

    /// A thin grey line at `y = at`.
    pub fn horizontal(at: f64) -> Self {
        Self {
            direction: Direction::Horizontal,
            ..Self::vertical(at)
        }
    }
}

/// `named` and `color` for layers that stand in the legend.
macro_rules! named {
    ($($layer:ident),*) => {$(
        impl $layer {
            /// Give it a name in the legend.
            pub fn named(mut self, name: impl Into<String>) -> Self {
                self.name = Some(name.into());
                self
            }

            /// Set the color.
            pub fn color(mut self, color: Color) -> Self {
                self.color = color;
                self
            }
        }
    )*};
}
named!(Line, Points, Arrows, Balls, Rule);

/// `dashed` and `dotted` for layers that are lines.
macro_rules! dashed {
    ($($layer:ident),*) => {$(
        impl $layer {
            /// Draw it in dashes.
            pub fn dashed(mut self) -> Self {
                self.dash = Dash::Dashed;
                self
            }

            /// Draw it in dots.
            pub fn dotted(mut self) -> Self {
                self.dash = Dash::Dotted;
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
