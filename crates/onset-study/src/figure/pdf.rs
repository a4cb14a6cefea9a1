//! Output of a picture as a PDF: one page of its size, with all outlines and letters as paths.

use super::pen::INK;
use super::scene::{Paint, Scene, Shape, Words};
use super::{Color, Dash, font, palette};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::LineJoinStyle;
use pdf_writer::{Content, Filter, Finish, Pdf, Rect, Ref, TextStr};
use std::io::Write;
use tiny_skia::{Path, PathSegment, Point, Transform};

/// Points per pixel: an inch has 72 points and 96 pixels.
const POINTS: f32 = 0.75;
/// Longest side of a page that PDF readers accept, in points.
const LONGEST: f32 = 14_400.0;
/// Overlap of neighboring cells of a map, in pixels; without it PDF readers show seams between adjacent areas.
const OVERLAP: f64 = 0.3;

impl Scene {
    pub(super) fn to_pdf(&self) -> Vec<u8> {
        let [catalog, pages, page, content, info] = [1, 2, 3, 4, 5].map(Ref::new);
        let scale = POINTS.min(LONGEST / self.width.max(self.height) as f32);
        let size = [self.width, self.height].map(|pixels| pixels as f32 * scale);
        let mut pdf = Pdf::new();
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        pdf.page(page)
            .media_box(Rect::new(0.0, 0.0, size[0], size[1]))
            .parent(pages)
            .contents(content)
            .finish();
        pdf.document_info(info)
            .title(TextStr(&self.title))
            .subject(TextStr(&self.description))
            .producer(TextStr(concat!("onset ", env!("CARGO_PKG_VERSION"))));
        let drawn = self.content([scale, 0.0, 0.0, -scale, 0.0, size[1]]);
        match compressed(&drawn) {
            Some(data) => {
                let mut stream = pdf.stream(content, &data);
                stream.filter(Filter::FlateDecode);
            }
            None => drop(pdf.stream(content, &drawn)),
        }
        pdf.finish()
    }

    /// Drawing operators of the shapes. `upright` moves the origin of the page to the upper left corner, where pictures have it.
    fn content(&self, upright: [f32; 6]) -> Vec<u8> {
        let mut out = Content::new();
        out.transform(upright);
        out.set_line_join(LineJoinStyle::RoundJoin);
        for shape in &self.shapes {
            match shape {
                Shape::Outline { outline, paint } => {
                    paint_path(&mut out, std::iter::once(outline.clone()), paint);
                }
                Shape::Stamps { outline, at, paint } => {
                    // One by one, because they may overlap.
                    for &(x, y) in at {
                        let place = Transform::from_translate(x as f32, y as f32);
                        paint_path(&mut out, outline.clone().transform(place), paint);
                    }
                }
                Shape::Words(words) => write_words(&mut out, words),
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

fn write_words(out: &mut Content, words: &Words) {
    let place = words.transform();
    let letters = || {
        font::glyphs(&words.text).filter_map(move |(glyph, x)| {
            let outline = font::outline(glyph)?;
            outline.transform(place.pre_translate(x, 0.0))
        })
    };
    if words.rim {
        let width = f64::from(words.rim_width() * place.sx.abs().max(place.kx.abs()));
        let rim = Paint::stroke(palette::WHITE, width, Dash::Solid);
        paint_path(out, letters(), &rim);
    }
    paint_path(out, letters(), &Paint::fill(words.color));
}

/// Paints several outlines as one path.
fn paint_path(out: &mut Content, outlines: impl IntoIterator<Item = Path>, paint: &Paint) {
    let stroke = match (paint.crisp, paint.fill) {
        (true, Some(color)) => Paint::stroke(color, OVERLAP, Dash::Solid).stroke,
        _ => paint.stroke,
    };
    let rgb = |color: Color| [color.red, color.green, color.blue].map(|c| f32::from(c) / 255.0);
    let [r, g, b] = rgb(paint.fill.unwrap_or(INK));
    out.set_fill_rgb(r, g, b);
    if let Some(stroke) = stroke {
        let [r, g, b] = rgb(stroke.color);
        out.set_stroke_rgb(r, g, b);
        out.set_line_width(stroke.width.max(0.0) as f32);
        let pattern = stroke
            .pattern()
            .map(|pattern| pattern.map(|length| length as f32));
        out.set_dash_pattern(pattern.into_iter().flatten(), 0.0);
    }
    let mut is_empty = true;
    for outline in outlines {
        is_empty = false;
        write_path(out, &outline);
    }
    if is_empty {
        return;
    }
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
