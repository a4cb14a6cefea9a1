//! Picture as a list of painted outlines and words, written as SVG or PNG.
//!
//! Both use the same outlines, glyphs included, and appear the same in every viewer.

use super::{Color, Dash, FigureError, font, palette};
use std::collections::BTreeMap;
use std::fmt::Write;
use tiny_skia::{
    FillRule, LineCap, LineJoin, Path, PathSegment, Pixmap, PixmapMut, StrokeDash, Transform,
};
use ttf_parser::GlyphId;

/// Device pixels per pixel in the PNG, along each side.
pub(super) const RESOLUTION: f32 = 2.0;

/// Maximum number of device pixels in a PNG, which limits the memory.
const MAX_PNG_PIXELS: u64 = 1 << 27;

/// The whole picture, in pixels from the upper left corner.
pub(super) struct Scene {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Name of the picture, for screen readers and other programs.
    pub(super) title: String,
    /// Description of the picture, for screen readers and other programs.
    pub(super) description: String,
    pub(super) shapes: Vec<Shape>,
}

pub(super) enum Shape {
    Outline {
        outline: Path,
        paint: Paint,
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
    /// Whether only whole pixels are filled, so that neighbors meet without a seam.
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

/// Part of a line of text that lies at its position.
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
    /// Lengths of dash and gap.
    pub(super) fn pattern(&self) -> Option<[f64; 2]> {
        match self.dash {
            Dash::Solid => None,
            Dash::Dashed => Some([4.0 * self.width, 2.5 * self.width]),
            Dash::Dotted => Some([self.width, 1.6 * self.width]),
        }
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
    pub(super) fn rim_width(&self) -> f32 {
        3.0 / self.size as f32 * font::units()
    }
}

impl Scene {
    pub(super) fn to_svg(&self) -> String {
        let mut body = String::new();
        let mut glyphs: BTreeMap<GlyphId, Path> = BTreeMap::new();
        let mut stamps = 0;
        for shape in &self.shapes {
            match shape {
                Shape::Outline { outline, paint } => {
                    body.push_str("<path");
                    write_paint(&mut body, paint);
                    body.push_str(" d=\"");
                    write_outline(&mut body, outline);
                    body.push_str("\"/>\n");
                }
                Shape::Stamps { outline, at, paint } => {
                    if at.is_empty() {
                        continue;
                    }
                    stamps += 1;
                    let _ = write!(body, "<defs><path id=\"m{stamps}\" d=\"");
                    write_outline(&mut body, outline);
                    body.push_str("\"/></defs>\n<g");
                    write_paint(&mut body, paint);
                    body.push('>');
                    for &(x, y) in at {
                        let _ = write!(body, "<use xlink:href=\"#m{stamps}\" x=\"");
                        write_number(&mut body, x as f32);
                        body.push_str("\" y=\"");
                        write_number(&mut body, y as f32);
                        body.push_str("\"/>");
                    }
                    body.push_str("</g>\n");
                }
                Shape::Words(words) => write_words(&mut body, words, &mut glyphs),
            }
        }

        let mut svg = String::with_capacity(body.len() + 32_768);
        let (width, height) = (self.width, self.height);
        let _ = write!(
            svg,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" \
             xmlns:xlink=\"http://www.w3.org/1999/xlink\" role=\"img\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\">\n"
        );
        for (tag, text) in [("title", &self.title), ("desc", &self.description)] {
            if !text.is_empty() {
                let _ = write!(svg, "<{tag}>");
                write_escaped(&mut svg, text);
                let _ = writeln!(svg, "</{tag}>");
            }
        }
        svg.push_str("<defs>\n");
        for (glyph, outline) in &glyphs {
            let _ = write!(svg, "<path id=\"g{}\" d=\"", glyph.0);
            write_outline(&mut svg, outline);
            svg.push_str("\"/>\n");
        }
        svg.push_str("</defs>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n");
        svg.push_str("<g stroke-linejoin=\"round\">\n");
        svg.push_str(&body);
        svg.push_str("</g>\n</svg>\n");
        svg
    }

    pub(super) fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        let device = |pixels: f64| (pixels * f64::from(RESOLUTION)).ceil() as u32;
        let (width, height) = (device(self.width), device(self.height));
        let mut pixmap = Some((width, height))
            .filter(|_| u64::from(width) * u64::from(height) <= MAX_PNG_PIXELS)
            .and_then(|_| Pixmap::new(width, height))
            .ok_or(FigureError::Size { width, height })?;
        pixmap.fill(tiny_skia::Color::WHITE);
        let mut canvas = pixmap.as_mut();
        let mut glyphs: BTreeMap<GlyphId, Option<Path>> = BTreeMap::new();
        let pixels = Transform::from_scale(RESOLUTION, RESOLUTION);
        for shape in &self.shapes {
            match shape {
                Shape::Outline { outline, paint } => {
                    paint_outline(&mut canvas, outline, paint, pixels);
                }
                Shape::Stamps { outline, at, paint } => {
                    for &(x, y) in at {
                        let place = pixels.pre_translate(x as f32, y as f32);
                        paint_outline(&mut canvas, outline, paint, place);
                    }
                }
                Shape::Words(words) => {
                    let place = pixels.pre_concat(words.transform());
                    let rim = f64::from(words.rim_width());
                    let rim = Paint::stroke(palette::WHITE, rim, Dash::Solid);
                    let paints = words.rim.then_some(rim);
                    for paint in paints.into_iter().chain([Paint::fill(words.color)]) {
                        for (glyph, x) in font::glyphs(&words.text) {
                            let outline =
                                glyphs.entry(glyph).or_insert_with(|| font::outline(glyph));
                            if let Some(outline) = outline {
                                paint_outline(
                                    &mut canvas,
                                    outline,
                                    &paint,
                                    place.pre_translate(x, 0.0),
                                );
                            }
                        }
                    }
                }
            }
        }
        encode(&pixmap)
    }
}

fn paint_outline(canvas: &mut PixmapMut<'_>, outline: &Path, paint: &Paint, place: Transform) {
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
            None,
        );
    }
    if let Some(stroke) = paint.stroke {
        let pattern = stroke
            .pattern()
            .map(|pattern| pattern.map(|length| length as f32).to_vec());
        let style = tiny_skia::Stroke {
            width: stroke.width as f32,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Round,
            dash: pattern.and_then(|pattern| StrokeDash::new(pattern, 0.0)),
            ..tiny_skia::Stroke::default()
        };
        canvas.stroke_path(outline, &source(stroke.color, true), &style, place, None);
    }
}

/// Encodes the opaque pixels as an RGB image that prints at 96 pixels per inch.
fn encode(pixmap: &Pixmap) -> Result<Vec<u8>, FigureError> {
    let failed = |error: png::EncodingError| FigureError::Encode {
        reason: error.to_string(),
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    let per_meter = (f64::from(RESOLUTION) * 96.0 / 0.0254).round() as u32;
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

fn write_words(out: &mut String, words: &Words, glyphs: &mut BTreeMap<GlyphId, Path>) {
    if words.text.trim().is_empty() {
        return;
    }
    let place = words.transform();
    let rims: &[bool] = if words.rim { &[true, false] } else { &[false] };
    for &rim in rims {
        out.push_str("<g");
        if rim {
            let _ = write!(
                out,
                " fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"",
                palette::WHITE,
                words.rim_width()
            );
        } else {
            let _ = write!(out, " fill=\"{}\" aria-label=\"", words.color);
            write_escaped(out, &words.text);
            out.push('"');
        }
        let _ = write!(
            out,
            " transform=\"matrix({} {} {} {} ",
            place.sx, place.ky, place.kx, place.sy
        );
        write_number(out, place.tx);
        out.push(' ');
        write_number(out, place.ty);
        out.push_str(")\">");
        for (glyph, x) in font::glyphs(&words.text) {
            if let std::collections::btree_map::Entry::Vacant(entry) = glyphs.entry(glyph) {
                let Some(outline) = font::outline(glyph) else {
                    continue;
                };
                entry.insert(outline);
            }
            let _ = write!(out, "<use xlink:href=\"#g{}\" x=\"{x}\"/>", glyph.0);
        }
        out.push_str("</g>\n");
    }
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
        if let Some([dash, gap]) = stroke.pattern() {
            let _ = write!(out, " stroke-dasharray=\"{dash} {gap}\"");
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
