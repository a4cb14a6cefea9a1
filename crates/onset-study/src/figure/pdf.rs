//! Output of a picture as a PDF: one page of its size, with text in a subset of the font that contains only the letters used.

use super::scene::{Paint, RIM, Scene, Shape, Words};
use super::{Color, Dash, Theme, font, palette};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{
    CidFontType, FontFlags, LineJoinStyle, SystemInfo, TextRenderingMode, UnicodeCmap,
};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use std::collections::BTreeMap;
use std::io::Write;
use tiny_skia::{Path, PathSegment, Point, Transform};
use ttf_parser::GlyphId;

/// Points per pixel: an inch has 72 points and 96 pixels.
const POINTS: f32 = 0.75;
/// Longest side of a page that PDF readers accept, in points.
const LONGEST: f32 = 14_400.0;
/// Overlap of neighboring cells of a map, in pixels; without it PDF readers show seams between adjacent areas.
const OVERLAP: f64 = 0.3;

/// Name of the font in the page.
const LETTERS: Name = Name(b"F");
/// Name of the embedded font; its prefix marks a subset.
const FONT_NAME: &str = "ONSETF+DejaVuSans";

impl Scene {
    pub(super) fn to_pdf(&self) -> Vec<u8> {
        let [catalog, pages, page, content, info, font] = [1, 2, 3, 4, 5, 6].map(Ref::new);
        let points = POINTS * self.scale as f32;
        let scale = points.min(LONGEST / self.width.max(self.height) as f32);
        let size = [self.width, self.height].map(|pixels| pixels as f32 * scale);
        let used = self.letters();
        let (program, number) = font::subset(used.keys().copied());
        let mut pdf = Pdf::new();
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        let mut only = pdf.page(page);
        only.media_box(Rect::new(0.0, 0.0, size[0], size[1]))
            .parent(pages)
            .contents(content);
        only.resources().fonts().pair(LETTERS, font);
        only.finish();
        pdf.document_info(info)
            .title(TextStr(&self.title))
            .subject(TextStr(&self.description))
            .producer(TextStr(concat!("onset ", env!("CARGO_PKG_VERSION"))));
        embed(&mut pdf, font, &program, &used, &number);
        let drawn = self.content([scale, 0.0, 0.0, -scale, 0.0, size[1]], &number);
        write_stream(&mut pdf, content, &drawn);
        pdf.finish()
    }

    /// Glyphs of the text of the picture, each with a character that it represents.
    fn letters(&self) -> BTreeMap<GlyphId, char> {
        let words = self.shapes.iter().filter_map(|shape| match shape {
            Shape::Words(words) => Some(words),
            _ => None,
        });
        words
            .flat_map(|words| font::glyphs(&words.text).zip(words.text.chars()))
            .map(|((glyph, _), letter)| (glyph, letter))
            .collect()
    }

    /// Drawing operators of the shapes. `upright` moves the origin of the page to the upper left corner, the origin of pictures.
    fn content(&self, upright: [f32; 6], number: &impl Fn(GlyphId) -> u16) -> Vec<u8> {
        let mut out = Content::new();
        let background = self.theme.of(palette::WHITE);
        if background != palette::WHITE {
            out.save_state();
            set_fill(&mut out, background);
            let (width, height) = (self.width as f32, self.height as f32);
            out.transform(upright);
            out.rect(0.0, 0.0, width, height).fill_nonzero();
            out.restore_state();
        }
        out.transform(upright);
        out.set_line_join(LineJoinStyle::RoundJoin);
        for shape in &self.shapes {
            match shape {
                Shape::Outline {
                    outline,
                    paint,
                    window,
                } => {
                    if let Some([left, top, width, height]) = window {
                        out.save_state();
                        out.rect(*left, *top, *width, *height);
                        out.clip_nonzero().end_path();
                    }
                    paint_path(&mut out, outline.clone(), &self.theme.paint(paint));
                    if window.is_some() {
                        out.restore_state();
                    }
                }
                Shape::Stamps { outline, at, paint } => {
                    // One by one, because they may overlap.
                    let paint = self.theme.paint(paint);
                    for &(x, y) in at {
                        let place = Transform::from_translate(x as f32, y as f32);
                        if let Some(outline) = outline.clone().transform(place) {
                            paint_path(&mut out, outline, &paint);
                        }
                    }
                }
                Shape::Words(words) => write_words(&mut out, words, self.theme, number),
            }
        }
        out.finish().into_vec()
    }
}

fn compressed(data: &[u8]) -> Option<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(data).ok()?;
    encoder.finish().ok()
}

/// Writes a compressed stream.
fn write_stream(pdf: &mut Pdf, place: Ref, data: &[u8]) {
    match compressed(data) {
        Some(data) => {
            pdf.stream(place, &data).filter(Filter::FlateDecode);
        }
        None => drop(pdf.stream(place, data)),
    }
}

/// Embeds a font whose letters are identified by glyph index, with the character that each glyph represents.
fn embed(
    pdf: &mut Pdf,
    font: Ref,
    program: &[u8],
    used: &BTreeMap<GlyphId, char>,
    number: &impl Fn(GlyphId) -> u16,
) {
    let [descendant, descriptor, characters, file] = [7, 8, 9, 10].map(Ref::new);
    let name = Name(FONT_NAME.as_bytes());
    let system = SystemInfo {
        registry: Str(b"Adobe"),
        ordering: Str(b"Identity"),
        supplement: 0,
    };
    pdf.type0_font(font)
        .base_font(name)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(descendant)
        .to_unicode(characters);
    let mut own = pdf.cid_font(descendant);
    own.subtype(CidFontType::Type2)
        .base_font(name)
        .system_info(system)
        .font_descriptor(descriptor)
        .cid_to_gid_map_predefined(Name(b"Identity"));
    let mut widths = own.widths();
    for &glyph in used.keys() {
        widths.consecutive(number(glyph), [font::advance(glyph)]);
    }
    widths.finish();
    own.finish();
    let measures = font::measures();
    let [left, lower, right, upper] = measures.bounds;
    pdf.font_descriptor(descriptor)
        .name(name)
        .flags(FontFlags::SYMBOLIC)
        .bbox(Rect::new(left, lower, right, upper))
        .italic_angle(0.0)
        .ascent(measures.ascent)
        .descent(measures.descent)
        .cap_height(measures.capital)
        .stem_v(80.0)
        .font_file2(file);
    let mut map = UnicodeCmap::new(Name(b"Letters"), system);
    for (&glyph, &letter) in used {
        map.pair(number(glyph), letter);
    }
    write_stream(pdf, characters, &map.finish());
    write_stream(pdf, file, program);
}

/// Writes a line of text over the white rim of its letters.
fn write_words(out: &mut Content, words: &Words, theme: Theme, number: &impl Fn(GlyphId) -> u16) {
    let place = words.transform();
    // Scales from font units to the size of the font.
    let units = font::units();
    let [a, b, c, d] = [place.sx, place.ky, place.kx, place.sy].map(|part| part * units);
    let letters: Vec<u8> = font::glyphs(&words.text)
        .flat_map(|(glyph, _)| number(glyph).to_be_bytes())
        .collect();
    out.begin_text();
    out.set_font(LETTERS, 1.0);
    out.set_text_matrix([a, b, c, d, place.tx, place.ty]);
    if words.rim {
        set_stroke(out, theme.of(palette::WHITE));
        out.set_line_width(RIM as f32);
        out.set_dash_pattern([], 0.0);
        out.set_text_rendering_mode(TextRenderingMode::Stroke);
        out.show(Str(&letters));
        out.set_text_rendering_mode(TextRenderingMode::Fill);
        out.set_text_matrix([a, b, c, d, place.tx, place.ty]);
    }
    set_fill(out, theme.of(words.color));
    out.show(Str(&letters));
    out.end_text();
}

fn parts(color: Color) -> [f32; 3] {
    [color.red, color.green, color.blue].map(|part| f32::from(part) / 255.0)
}

fn set_fill(out: &mut Content, color: Color) {
    let [r, g, b] = parts(color);
    out.set_fill_rgb(r, g, b);
}

fn set_stroke(out: &mut Content, color: Color) {
    let [r, g, b] = parts(color);
    out.set_stroke_rgb(r, g, b);
}

/// Writes the operators that fill and stroke an outline.
fn paint_path(out: &mut Content, outline: Path, paint: &Paint) {
    let stroke = match (paint.crisp, paint.fill) {
        (true, Some(color)) => Paint::stroke(color, OVERLAP, Dash::Solid).stroke,
        _ => paint.stroke,
    };
    if let Some(color) = paint.fill {
        set_fill(out, color);
    }
    if let Some(stroke) = stroke {
        set_stroke(out, stroke.color);
        out.set_line_width(stroke.width.max(0.0) as f32);
        let pattern = stroke.pattern();
        out.set_dash_pattern(pattern.iter().map(|own| *own as f32), 0.0);
    }
    write_path(out, &outline);
    match (paint.fill.is_some(), stroke.is_some()) {
        (true, true) => out.fill_nonzero_and_stroke(),
        (true, false) => out.fill_nonzero(),
        (false, _) => out.stroke(),
    };
}

fn write_path(out: &mut Content, outline: &Path) {
    let mut last = Point::zero();
    for segment in outline.segments() {
        match segment {
            PathSegment::MoveTo(p) => {
                out.move_to(p.x, p.y);
                last = p;
            }
            PathSegment::LineTo(p) => {
                out.line_to(p.x, p.y);
                last = p;
            }
            PathSegment::QuadTo(c, p) => {
                // PDF has only cubic curves.
                let toward = |end: Point| {
                    (
                        end.x + 2.0 / 3.0 * (c.x - end.x),
                        end.y + 2.0 / 3.0 * (c.y - end.y),
                    )
                };
                let (first, second) = (toward(last), toward(p));
                out.cubic_to(first.0, first.1, second.0, second.1, p.x, p.y);
                last = p;
            }
            PathSegment::CubicTo(c, d, p) => {
                out.cubic_to(c.x, c.y, d.x, d.y, p.x, p.y);
                last = p;
            }
            PathSegment::Close => {
                out.close_path();
            }
        }
    }
}
