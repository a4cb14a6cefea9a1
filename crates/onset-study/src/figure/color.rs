//! Colors and continuous color maps.

use serde::{Serialize, Serializer};

/// An opaque sRGB color.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Color {
    /// Red, 0 to 255.
    pub red: u8,
    /// Green, 0 to 255.
    pub green: u8,
    /// Blue, 0 to 255.
    pub blue: u8,
}

impl Color {
    /// The color `0xRRGGBB`, as in HTML.
    ///
    /// ```
    /// use onset_study::figure::Color;
    /// assert_eq!(Color::hex(0x0072B2).to_string(), "#0072b2");
    /// ```
    pub const fn hex(rgb: u32) -> Self {
        Self {
            red: (rgb >> 16) as u8,
            green: (rgb >> 8) as u8,
            blue: rgb as u8,
        }
    }

    /// Mixes the colors componentwise: a fraction `t` of the way to `other`.
    pub fn toward(self, other: Self, t: f64) -> Self {
        let mix = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * t).round() as u8;
        Self {
            red: mix(self.red, other.red),
            green: mix(self.green, other.green),
            blue: mix(self.blue, other.blue),
        }
    }
}

impl Serialize for Color {
    /// Serializes the color as text, as in HTML.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl std::fmt::Display for Color {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.red, self.green, self.blue)
    }
}

/// Color map of a [`Field`](super::Field). All maps are safe for color-blind readers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorMap {
    /// Dark to light, for quantities with an order but no special value.
    #[default]
    Viridis,
    /// Dark blue to yellow; appears the same with and without color blindness.
    Cividis,
    /// White to black, for prints without color.
    Grey,
    /// Red below zero, white at zero, blue above it: for quantities whose sign matters.
    #[serde(rename = "red-blue")]
    Diverging,
}

/// Samples of matplotlib's Viridis (CC0) at equal distances.
const VIRIDIS: [u32; 10] = [
    0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b,
    0xfde725,
];

/// Samples of Cividis by J. R. Nunez et al., PLoS ONE 13 (2018) e0199239, as in matplotlib, at equal distances.
const CIVIDIS: [u32; 10] = [
    0x00224e, 0x15396d, 0x434e6c, 0x61646f, 0x7d7c78, 0x9b9477, 0xbbae6f, 0xdac95f, 0xf4e45a,
    0xfee838,
];

/// Grey levels from light to dark, excluding white and black.
const GREY: [u32; 2] = [0xf2f2f2, 0x111111];

/// Samples of RdBu of ColorBrewer (Apache-2.0), which its authors list as color-blind safe.
const RED_BLUE: [u32; 11] = [
    0x67001f, 0xb2182b, 0xd6604d, 0xf4a582, 0xfddbc7, 0xf7f7f7, 0xd1e5f0, 0x92c5de, 0x4393c3,
    0x2166ac, 0x053061,
];

impl ColorMap {
    /// All color maps, in the order of the help.
    pub const ALL: [Self; 4] = [Self::Viridis, Self::Cividis, Self::Grey, Self::Diverging];

    /// The word used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Cividis => "cividis",
            Self::Grey => "grey",
            Self::Diverging => "red-blue",
        }
    }

    /// Color of `value` in a map over `range`; values outside the range have the end colors.
    ///
    /// ```
    /// use onset_study::figure::{Color, ColorMap};
    /// // Zero is white however lopsided the range is.
    /// assert_eq!(ColorMap::Diverging.color(0.0, (-1.0, 9.0)), Color::hex(0xf7f7f7));
    /// ```
    pub fn color(self, value: f64, range: (f64, f64)) -> Color {
        let (anchors, t): (&[u32], f64) = match self {
            Self::Viridis => (&VIRIDIS, (value - range.0) / (range.1 - range.0)),
            Self::Cividis => (&CIVIDIS, (value - range.0) / (range.1 - range.0)),
            Self::Grey => (&GREY, (value - range.0) / (range.1 - range.0)),
            Self::Diverging => {
                let reach = range.0.abs().max(range.1.abs());
                (&RED_BLUE, 0.5 + 0.5 * value / reach)
            }
        };
        let t = if t.is_nan() { 0.5 } else { t.clamp(0.0, 1.0) };
        let place = t * (anchors.len() - 1) as f64;
        let below = (place as usize).min(anchors.len() - 2);
        Color::hex(anchors[below]).toward(Color::hex(anchors[below + 1]), place - below as f64)
    }
}
