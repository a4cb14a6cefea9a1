//! Figures: axes, layers and their rendering to SVG, PNG and PDF.
//!
//! A [`Figure`] is plain data: panels, each with two axes and layers of arrays. It is drawn as SVG, PNG or PDF on a [`Sheet`], and other programs can
//! draw its serialized form. Text remains text in SVG and PDF; PNG and PDF use the embedded font.
//!
//! ```
//! use onset_study::figure::{Axis, Figure, Line, Panel, Regions, palette};
//!
//! let words = ["stable", "stable", "numerical", "physical"];
//! let panel = Panel::new(
//!     "Lagrangian kernel",
//!     Axis::linear("stretch λ₁ (−)", (0.5, 1.5)),
//!     Axis::linear("stretch λ₂ (−)", (0.5, 1.5)),
//! )
//! .equal_aspect()
//! .with(Regions::of_words((0.5, 1.5), (0.5, 1.5), (2, 2), words))
//! .with(Line::new(vec![(0.5, 1.0), (1.5, 1.0)]).named("PDE").dashed());
//! let figure = Figure::new("Where the material is stable").with(panel);
//!
//! assert!(figure.to_svg().contains("stretch λ₁ (−)"));
//! let legend = figure.legend_entries();
//! assert_eq!(legend.iter().map(|entry| entry.name.as_str()).collect::<Vec<_>>(),
//!            ["stable", "physical", "numerical", "PDE"]);
//! ```

mod axis;
mod color;
mod draw;
mod font;
mod grid;
mod layer;
mod layout;
mod legend;
pub mod palette;
mod pdf;
mod pen;
mod scatter;
mod scene;
mod sheet;

pub use axis::{Axis, Scale};
pub use color::{Color, ColorMap};
pub use layer::{
    Arrows, Ball, Balls, Dash, Direction, Field, Label, Layer, Line, Marker, Points, Regions, Rule,
};
pub use legend::{LegendEntry, Symbol};
pub use sheet::{Sheet, Size, Theme};

use serde::Serialize;
use std::ffi::{OsStr, OsString};

/// Panels in a grid, with a title above, a shared legend and a caption below.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Figure {
    /// Title above all panels; may be empty.
    pub title: String,
    /// Caption below all panels; may be empty.
    pub caption: String,
    /// The panels, row after row.
    pub panels: Vec<Panel>,
    /// Number of panels in a row; 0 counts as 1.
    pub columns: usize,
    /// Legend below the panels; collected from the layers if empty.
    pub legend: Vec<LegendEntry>,
    /// Width and height of the box of a panel in pixels (1/96 inch); the maximum for an equal aspect. `None` for the usual size.
    pub panel_size: Option<(f64, f64)>,
    /// Whether the page supplies title, caption and margins.
    #[serde(skip)]
    pub is_bare: bool,
}

/// Two axes with the layers between them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Panel {
    /// Title above the panel; may be empty.
    pub title: String,
    /// Horizontal axis, increasing rightward.
    pub x: Axis,
    /// Vertical axis, increasing upward.
    pub y: Axis,
    /// Whether one unit (on logarithmic axes one decade) has the same length in x and y.
    pub equal_aspect: bool,
    /// Width of the box as a multiple of the usual width; ignored with an equal aspect.
    pub width: f64,
    /// Height of the box in lines of text, for rows that need the same height at every width; the usual height if `None`. Ignored with an equal aspect.
    pub lines: Option<f64>,
    /// Layers, from back to front.
    pub layers: Vec<Layer>,
}

/// Reasons why a figure cannot be produced.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The picture has too many pixels.
    #[error("a picture of {width} x {height} pixels is too large")]
    Size {
        /// Width of the picture in pixels.
        width: u32,
        /// Height of the picture in pixels.
        height: u32,
    },
    /// The PNG could not be encoded.
    #[error("the PNG could not be encoded: {reason}")]
    Encode {
        /// Message of the encoder.
        reason: String,
    },
}

impl Figure {
    /// Creates a figure without panels, for three panels in a row.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            columns: 3,
            ..Self::default()
        }
    }

    /// Sets the caption below the panels.
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Sets the number of panels in a row.
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = columns;
        self
    }

    /// Adds a panel after the existing panels.
    pub fn with(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// Legend as it is drawn: `legend`, or if it is empty, the names of the layers of all panels without duplicates. A categorical map names only the
    /// classes that occur, in the order of its key.
    pub fn legend_entries(&self) -> Vec<LegendEntry> {
        if self.legend.is_empty() {
            legend::collect(&self.panels)
        } else {
            self.legend.clone()
        }
    }

    /// Figure in serialized form for other programs, with the limits of all axes and color bars, and with the legend as it is drawn.
    pub fn description(&self) -> Self {
        let mut figure = self.clone();
        figure.legend = self.legend_entries();
        for panel in &mut figure.panels {
            for axis in [&mut panel.x, &mut panel.y] {
                axis.range = axis.shown();
            }
            for layer in &mut panel.layers {
                if let Layer::Field(field) = layer {
                    field.range = Some(draw::field_range(field));
                }
            }
        }
        figure
    }

    /// Returns the picture as an SVG document.
    pub fn to_svg(&self) -> String {
        layout::scene(self, &Sheet::default()).to_svg()
    }

    /// Returns the picture as a PNG with twice the resolution: four device pixels for each pixel.
    ///
    /// # Errors
    /// [`FigureError::Size`] if the panels would need a picture of more than 2^27 device pixels.
    pub fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        layout::scene(self, &Sheet::default()).to_png()
    }

    /// Returns the picture as a PDF with one page. A pixel is 1/96 inch.
    pub fn to_pdf(&self) -> Vec<u8> {
        layout::scene(self, &Sheet::default()).to_pdf()
    }

    /// File name extensions of a figure. The last extension is for the text of a bare picture and is used only with one.
    pub const ENDINGS: [&str; 4] = [".svg", ".png", ".pdf", ".txt"];

    /// Returns the picture on a sheet as files with a base name: SVG, PNG and PDF, and the text of a bare picture.
    ///
    /// # Errors
    /// Fails like [`Figure::to_png`].
    pub fn files(
        &self,
        name: impl AsRef<OsStr>,
        sheet: &Sheet,
    ) -> Result<Vec<(OsString, Vec<u8>)>, FigureError> {
        let scene = layout::scene(self, sheet);
        let words = sheet.words_beside(self, &scene.omitted);
        let words = words.map(String::into_bytes);
        let contents = [
            Some(scene.to_svg().into_bytes()),
            Some(scene.to_png()?),
            Some(scene.to_pdf()),
            words,
        ];
        let named = Self::ENDINGS
            .iter()
            .zip(contents)
            .filter_map(|(ending, content)| {
                let mut name = name.as_ref().to_owned();
                name.push(ending);
                Some((name, content?))
            });
        Ok(named.collect())
    }
}

impl Panel {
    /// Creates an empty panel with two axes.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            equal_aspect: false,
            width: 1.0,
            lines: None,
            layers: Vec::new(),
        }
    }

    /// Gives one unit the same length in x and y.
    pub fn equal_aspect(mut self) -> Self {
        self.equal_aspect = true;
        self
    }

    /// Multiplies the usual width by `width` and keeps the usual height.
    pub fn wider(mut self, width: f64) -> Self {
        self.width = width;
        self
    }

    /// Sets the height of the box to a number of lines of text.
    pub fn lines(mut self, lines: f64) -> Self {
        self.lines = Some(lines);
        self
    }

    /// Adds a layer over the existing layers.
    pub fn with(mut self, layer: impl Into<Layer>) -> Self {
        self.layers.push(layer.into());
        self
    }
}
