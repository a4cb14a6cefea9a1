//! Picture as a list of painted outlines and words, written as SVG or PNG.
//!
//! Text in the SVG remains text, which can be searched, edited and typeset in the font of a paper. Its position is computed with the embedded font;
//! the PNG is drawn with this font.

use super::{Color, Dash, FigureError, Theme, font, palette};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use tiny_skia::{
    FillRule, LineCap, LineJoin, Mask, Path, PathBuilder, PathSegment, Pixmap, PixmapMut, Rect,
    StrokeDash, Transform,
};
use ttf_parser::GlyphId;

/// Device pixels per pixel of the PNG along each side, for pictures on a screen.
const RESOLUTION: f64 = 2.0;
/// Device pixels per pixel of the PNG along each side, for pictures with a print size: 300 per inch.
const PRINTED_RESOLUTION: f64 = 300.0 / 96.0;
/// Fonts for text in the SVG: the embedded font, its predecessor with equal widths, and common fonts of operating systems.
const FONTS: &str = "DejaVu Sans, Bitstream Vera Sans, Verdana, Helvetica, Arial, sans-serif";

/// Width of the rim of words on a map, in units of the shapes.
pub(super) const RIM: f64 = 3.0;

/// Maximum number of device pixels in a PNG, which limits the memory.
const MAX_PNG_PIXELS: u64 = 1 << 27;

/// The whole picture, in pixels from the upper left corner.
pub(super) struct Scene {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Title of the picture, for screen readers and other programs.
    pub(super) title: String,
    /// Description of the picture, for screen readers and other programs.
    pub(super) description: String,
    pub(super) shapes: Vec<Shape>,
    /// Pixels of 1/96 inch per unit of the shapes: 1, or less for a picture with a width in print.
    pub(super) scale: f64,
    /// Whether the picture has a size in print.
    pub(super) is_printed: bool,
    pub(super) theme: Theme,
    /// Titles of panels that are omitted because the picture would be higher than a page.
    pub(super) omitted: Vec<String>,
}

pub(super) enum Shape {
    Outline {
        outline: Path,
        paint: Paint,
        /// Left, top, width and height of the window in which the outline is painted; `None` for the whole picture.
        window: Option<[f32; 4]>,
    },
    /// One outline repeated at many positions.
    Stamps {
        outline: Path,
        at: Vec<(f64, f64)>,
        paint: Paint,
    },
    Words(Words),
}

#[derive(Clone, Copy, Default)]
pub(super) struct Paint {
    pub(super) fill: Option<Color>,
    pub(super) stroke: Option<Stroke>,
    /// Whether only whole pixels are filled, so that neighbors touch without a seam.
    pub(super) crisp: bool,
}

#[derive(Clone, Copy)]
pub(super) struct Stroke {
    pub(super) color: Color,
    pub(super) width: f64,
    pub(super) dash: Dash,
}

/// A line of text; `at` lies on its baseline.
pub(super) struct Words {
    pub(super) text: String,
    pub(super) at: (f64, f64),
    pub(super) anchor: Anchor,
    /// Whether the text runs upward instead of rightward.
    pub(super) upward: bool,
    pub(super) size: f64,
    pub(super) color: Color,
    /// Whether the letters have a white rim.
    pub(super) rim: bool,
}

/// Point of a line of text that is placed at its position.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Paint {
    pub(super) fn fill(color: Color) -> Self {
        Self {
            fill: Some(color),
            ..Self::default()
        }
    }

    pub(super) fn stroke(color: Color, width: f64, dash: Dash) -> Self {
        Self {
            stroke: Some(Stroke { color, width, dash }),
            ..Self::default()
        }
    }
}

impl Stroke {
    /// Lengths of dashes and gaps by turns; empty for a solid line.
    pub(super) fn pattern(&self) -> Vec<f64> {
        let widths: &[f64] = match self.dash {
            Dash::Solid => &[],
            Dash::Dashed => &[4.0, 2.5],
            Dash::Dotted => &[1.0, 1.6],
            Dash::Dashdot => &[5.0, 1.8, 1.2, 1.8],
        };
        widths.iter().map(|own| own * self.width).collect()
    }
}

impl Words {
    /// Transform from font units to pixels.
    pub(super) fn transform(&self) -> Transform {
        let scale = self.size as f32 / font::units();
        let shift = match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * font::width(&self.text, self.size),
            Anchor::End => -font::width(&self.text, self.size),
        };
        let (x, y) = self.at;
        if self.upward {
            let origin = (x as f32, (y - shift) as f32);
            Transform::from_row(0.0, -scale, -scale, 0.0, origin.0, origin.1)
        } else {
            let origin = ((x + shift) as f32, y as f32);
            Transform::from_row(scale, 0.0, 0.0, -scale, origin.0, origin.1)
        }
    }

    /// Width of the rim in font units.
    fn rim_width(&self) -> f32 {
        RIM as f32 / self.size as f32 * font::units()
    }
}

impl Scene {
    pub(super) fn to_svg(&self) -> String {
        let mut svg = String::with_capacity(32_768);
        let (width, height) = (self.width, self.height);
        let size = match self.is_printed {
            true => [width, height]
                .map(|own| format!("{}mm", (own * self.scale * 2540.0 / 96.0).round() / 100.0)),
            false => [width, height].map(|own| own.to_string()),
        };
        let _ = write!(
            svg,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" \
             xmlns:xlink=\"http://www.w3.org/1999/xlink\" role=\"img\" width=\"{}\" height=\"{}\" \
             viewBox=\"0 0 {width} {height}\">\n",
            size[0], size[1]
        );
        for (tag, text) in [("title", &self.title), ("desc", &self.description)] {
            if !text.is_empty() {
                let _ = write!(svg, "<{tag}>");
                write_escaped(&mut svg, text);
                let _ = writeln!(svg, "</{tag}>");
            }
        }
        let background = self.theme.of(palette::WHITE);
        let _ = writeln!(
            svg,
            "<rect width=\"100%\" height=\"100%\" fill=\"{background}\"/>"
        );
        let _ = writeln!(svg, "<g stroke-linejoin=\"round\" font-family=\"{FONTS}\">");
        let (mut stamps, mut windows) = (0, BTreeSet::new());
        for shape in &self.shapes {
            match shape {
                Shape::Outline {
                    outline,
                    paint,
                    window,
                } => {
                    let clip = window.map(|[left, top, width, height]| {
                        // The identifier contains the window, so that pictures in one page share only equal windows.
                        let id = format!("w{left}-{top}-{width}-{height}");
                        let clip = format!(" clip-path=\"url(#{id})\"");
                        if windows.insert(id.clone()) {
                            let _ = writeln!(
                                svg,
                                "<clipPath id=\"{id}\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/></clipPath>"
                            );
                        }
                        clip
                    });
                    svg.push_str("<path");
                    svg.push_str(&clip.unwrap_or_default());
                    write_paint(&mut svg, &self.theme.paint(paint));
                    svg.push_str(" d=\"");
                    write_outline(&mut svg, outline);
                    svg.push_str("\"/>\n");
                }
                Shape::Stamps { outline, at, paint } => {
                    if at.is_empty() {
                        continue;
                    }
                    stamps += 1;
                    let _ = write!(svg, "<defs><path id=\"m{stamps}\" d=\"");
                    write_outline(&mut svg, outline);
                    svg.push_str("\"/></defs>\n<g");
                    write_paint(&mut svg, &self.theme.paint(paint));
                    svg.push('>');
                    for &(x, y) in at {
                        let _ = write!(svg, "<use xlink:href=\"#m{stamps}\" x=\"");
                        write_number(&mut svg, x as f32);
                        svg.push_str("\" y=\"");
                        write_number(&mut svg, y as f32);
                        svg.push_str("\"/>");
                    }
                    svg.push_str("</g>\n");
                }
                Shape::Words(words) => write_words(&mut svg, words, self.theme),
            }
        }
        svg.push_str("</g>\n</svg>\n");
        svg
    }

    pub(super) fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        let per_pixel = match self.is_printed {
            true => PRINTED_RESOLUTION,
            false => RESOLUTION,
        };
        let resolution = self.scale * per_pixel;
        let device = |length: f64| (length * resolution).ceil() as u32;
        let (width, height) = (device(self.width), device(self.height));
        let mut pixmap = Some((width, height))
            .filter(|_| u64::from(width) * u64::from(height) <= MAX_PNG_PIXELS)
            .and_then(|_| Pixmap::new(width, height))
            .ok_or(FigureError::Size { width, height })?;
        let Color { red, green, blue } = self.theme.of(palette::WHITE);
        pixmap.fill(tiny_skia::Color::from_rgba8(red, green, blue, 255));
        let mut canvas = pixmap.as_mut();
        let mut glyphs: BTreeMap<GlyphId, Option<Path>> = BTreeMap::new();
        let pixels = Transform::from_scale(resolution as f32, resolution as f32);
        for shape in &self.shapes {
            match shape {
                Shape::Outline {
                    outline,
                    paint,
                    window,
                } => {
                    let window = window.and_then(|[x, y, w, h]| Rect::from_xywh(x, y, w, h));
                    let mask = window.and_then(|window| {
                        let mut mask = Mask::new(width, height)?;
                        let window = PathBuilder::from_rect(window);
                        mask.fill_path(&window, FillRule::Winding, true, pixels);
                        Some(mask)
                    });
                    let paint = self.theme.paint(paint);
                    paint_outline(&mut canvas, outline, &paint, pixels, mask.as_ref());
                }
                Shape::Stamps { outline, at, paint } => {
                    let paint = self.theme.paint(paint);
                    for &(x, y) in at {
                        let place = pixels.pre_translate(x as f32, y as f32);
                        paint_outline(&mut canvas, outline, &paint, place, None);
                    }
                }
                Shape::Words(words) => {
                    let place = pixels.pre_concat(words.transform());
                    let rim = f64::from(words.rim_width());
                    let rim = Paint::stroke(palette::WHITE, rim, Dash::Solid);
                    let paints = words.rim.then_some(rim);
                    for paint in paints.into_iter().chain([Paint::fill(words.color)]) {
                        let paint = self.theme.paint(&paint);
                        for (glyph, x) in font::glyphs(&words.text) {
                            let outline =
                                glyphs.entry(glyph).or_insert_with(|| font::outline(glyph));
                            if let Some(outline) = outline {
                                paint_outline(
                                    &mut canvas,
                                    outline,
                                    &paint,
                                    place.pre_translate(x, 0.0),
                                    None,
                                );
                            }
                        }
                    }
                }
            }
        }
        encode(&pixmap, per_pixel)
    }
}

fn paint_outline(
    canvas: &mut PixmapMut<'_>,
    outline: &Path,
    paint: &Paint,
    place: Transform,
    mask: Option<&Mask>,
) {
    let source = |color: Color, smooth: bool| {
        let mut source = tiny_skia::Paint::default();
        source.set_color_rgba8(color.red, color.green, color.blue, 255);
        source.anti_alias = smooth;
        source
    };
    if let Some(color) = paint.fill {
        canvas.fill_path(
            outline,
            &source(color, !paint.crisp),
            FillRule::Winding,
            place,
            mask,
        );
    }
    if let Some(stroke) = paint.stroke {
        let pattern = stroke.pattern().iter().map(|own| *own as f32).collect();
        let style = tiny_skia::Stroke {
            width: stroke.width as f32,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Round,
            dash: StrokeDash::new(pattern, 0.0),
            ..tiny_skia::Stroke::default()
        };
        canvas.stroke_path(outline, &source(stroke.color, true), &style, place, mask);
    }
}

/// Encodes the opaque pixels as an RGB image, with `per_pixel` device pixels in 1/96 inch.
fn encode(pixmap: &Pixmap, per_pixel: f64) -> Result<Vec<u8>, FigureError> {
    let failed = |error: png::EncodingError| FigureError::Encode {
        reason: error.to_string(),
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    let per_meter = (per_pixel * 96.0 / 0.0254).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: per_meter,
        yppu: per_meter,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header().map_err(failed)?;
    let opaque = pixmap
        .data()
        .chunks_exact(4)
        .flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]);
    writer
        .write_image_data(&opaque.collect::<Vec<u8>>())
        .map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

/// Writes a line of text as text. A rim is painted below the letters.
fn write_words(out: &mut String, words: &Words, theme: Theme) {
    if words.text.trim().is_empty() {
        return;
    }
    let (x, y) = (words.at.0 as f32, words.at.1 as f32);
    out.push_str("<text");
    if words.upward {
        out.push_str(" transform=\"translate(");
        write_number(out, x);
        out.push(' ');
        write_number(out, y);
        out.push_str(") rotate(-90)\"");
    } else {
        out.push_str(" x=\"");
        write_number(out, x);
        out.push_str("\" y=\"");
        write_number(out, y);
        out.push('"');
    }
    let anchor = match words.anchor {
        Anchor::Start => "",
        Anchor::Middle => " text-anchor=\"middle\"",
        Anchor::End => " text-anchor=\"end\"",
    };
    let (size, color) = (words.size, theme.of(words.color));
    let _ = write!(out, "{anchor} font-size=\"{size}\" fill=\"{color}\"");
    if words.rim {
        let rim = theme.of(palette::WHITE);
        let _ = write!(
            out,
            " stroke=\"{rim}\" stroke-width=\"{RIM}\" paint-order=\"stroke\""
        );
    }
    out.push('>');
    write_escaped(out, &words.text);
    out.push_str("</text>\n");
}

fn write_paint(out: &mut String, paint: &Paint) {
    match paint.fill {
        Some(color) => write!(out, " fill=\"{color}\""),
        None => write!(out, " fill=\"none\""),
    }
    .unwrap_or_default();
    if let Some(stroke) = paint.stroke {
        let _ = write!(
            out,
            " stroke=\"{}\" stroke-width=\"{}\"",
            stroke.color, stroke.width
        );
        let pattern: Vec<String> = stroke.pattern().iter().map(f64::to_string).collect();
        if !pattern.is_empty() {
            let _ = write!(out, " stroke-dasharray=\"{}\"", pattern.join(" "));
        }
    }
    if paint.crisp {
        out.push_str(" shape-rendering=\"crispEdges\"");
    }
}

fn write_outline(out: &mut String, outline: &Path) {
    fn write_points(out: &mut String, letter: char, points: &[tiny_skia::Point]) {
        out.push(letter);
        for (i, point) in points.iter().enumerate() {
            if i > 0 {
                out.push(' ');
            }
            write_number(out, point.x);
            out.push(' ');
            write_number(out, point.y);
        }
    }
    let mut last = tiny_skia::Point::zero();
    for segment in outline.segments() {
        match segment {
            PathSegment::MoveTo(p) => write_points(out, 'M', &[p]),
            PathSegment::LineTo(p) if p.y == last.y => {
                out.push('H');
                write_number(out, p.x);
            }
            PathSegment::LineTo(p) if p.x == last.x => {
                out.push('V');
                write_number(out, p.y);
            }
            PathSegment::LineTo(p) => write_points(out, 'L', &[p]),
            PathSegment::QuadTo(p, q) => write_points(out, 'Q', &[p, q]),
            PathSegment::CubicTo(p, q, r) => write_points(out, 'C', &[p, q, r]),
            PathSegment::Close => out.push('Z'),
        }
        // A closed contour is always followed by a move, so the last point need not return to the start.
        if let PathSegment::MoveTo(p)
        | PathSegment::LineTo(p)
        | PathSegment::QuadTo(_, p)
        | PathSegment::CubicTo(_, _, p) = segment
        {
            last = p;
        }
    }
}

/// Writes a number to two decimals, without trailing zeros.
fn write_number(out: &mut String, number: f32) {
    let hundredths = (f64::from(number) * 100.0).round() as i64;
    if hundredths < 0 {
        out.push('-');
    }
    let (whole, rest) = (
        hundredths.unsigned_abs() / 100,
        hundredths.unsigned_abs() % 100,
    );
    let _ = match (rest / 10, rest % 10) {
        (0, 0) => write!(out, "{whole}"),
        (tenth, 0) => write!(out, "{whole}.{tenth}"),
        (tenth, hundredth) => write!(out, "{whole}.{tenth}{hundredth}"),
    };
}

/// Writes a text with the special and forbidden characters of XML replaced.
fn write_escaped(out: &mut String, text: &str) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\t' | '\r' => out.push(' '),
            c if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
}
