//! The font of all figures, embedded: DejaVu Sans, free under the terms in `DejaVu-LICENSE.txt` in this folder.
//!
//! The subset contains the characters that need no shaping: Latin, Greek, Cyrillic, punctuation, arrows and mathematics, a quarter of the font. It
//! was generated from release 2.37 with fonttools 4.68: `pyftsubset DejaVuSans.ttf
//! --unicodes=U+0020-024F,U+0300-052F,U+1D2C-1D6A,U+1E00-1EFF,U+2000-22FF,U+25A0-25FF --retain-gids --no-hinting --layout-features=
//! --drop-tables+=GPOS,GSUB,GDEF,MATH,kern,FFTM,post,gasp,OS/2 --notdef-outline --no-glyph-names`.

use std::sync::OnceLock;
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

const FONT: &[u8] = include_bytes!("DejaVuSans-subset.ttf");

fn face() -> &'static Face<'static> {
    static FACE: OnceLock<Face<'static>> = OnceLock::new();
    FACE.get_or_init(|| Face::parse(FONT, 0).expect("the embedded font is whole"))
}

/// The embedded font reduced to some of its glyphs, with their new numbers; the whole font if it cannot be reduced.
pub(super) fn subset(
    glyphs: impl IntoIterator<Item = GlyphId>,
) -> (Vec<u8>, impl Fn(GlyphId) -> u16) {
    let remapper = subsetter::GlyphRemapper::new_from_glyphs_sorted(
        &glyphs.into_iter().map(|glyph| glyph.0).collect::<Vec<_>>(),
    );
    let cut = subsetter::subset(FONT, 0, &remapper).ok();
    let is_cut = cut.is_some();
    let number = move |glyph: GlyphId| match is_cut {
        true => remapper.get(glyph.0).unwrap_or(0),
        false => glyph.0,
    };
    (cut.unwrap_or_else(|| FONT.to_vec()), number)
}

/// Measures of the font and of a glyph, in thousandths of its size.
pub(super) struct Measures {
    /// Extent of all letters: left, lower, right and upper edge.
    pub(super) bounds: [f32; 4],
    pub(super) ascent: f32,
    pub(super) descent: f32,
    pub(super) capital: f32,
}

pub(super) fn measures() -> Measures {
    let own = |length: i16| f32::from(length) * 1000.0 / units();
    let bounds = face().global_bounding_box();
    Measures {
        bounds: [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max].map(own),
        ascent: own(face().ascender()),
        descent: own(face().descender()),
        capital: 1000.0 * super::pen::CAPITAL as f32,
    }
}

/// Width of a glyph in thousandths of the size of the font.
pub(super) fn advance(glyph: GlyphId) -> f32 {
    f32::from(face().glyph_hor_advance(glyph).unwrap_or(0)) * 1000.0 / units()
}

/// Font units per em.
pub(super) fn units() -> f32 {
    f32::from(face().units_per_em())
}

/// Glyphs of a line of text with their starting positions, in font units.
pub(super) fn glyphs(text: &str) -> impl Iterator<Item = (GlyphId, f32)> {
    let mut pen = 0.0;
    text.chars().map(move |c| {
        let c = if c.is_control() { ' ' } else { c };
        let glyph = face().glyph_index(c).unwrap_or_default();
        let start = pen;
        pen += f32::from(face().glyph_hor_advance(glyph).unwrap_or(0));
        (glyph, start)
    })
}

/// Width of a line of text, in the units of the font size.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let last = glyphs(text).last().map_or(0.0, |(glyph, start)| {
        start + f32::from(face().glyph_hor_advance(glyph).unwrap_or(0))
    });
    f64::from(last / units()) * size
}

/// Outline of a glyph in font units, y upward; `None` for a space.
pub(super) fn outline(glyph: GlyphId) -> Option<Path> {
    let mut pen = Pen(PathBuilder::new());
    face().outline_glyph(glyph, &mut pen)?;
    pen.0.finish()
}

/// Breaks a text at spaces into lines no wider than `available`, unless a single word is wider.
pub(super) fn wrap(text: &str, size: f64, available: f64) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in text.lines().filter(|line| !line.trim().is_empty()) {
        let mut line = String::new();
        let is_gap = |c: char| c.is_whitespace() && c != '\u{a0}';
        for word in paragraph.split(is_gap).filter(|word| !word.is_empty()) {
            if line.is_empty() {
                line = word.to_string();
            } else if width(&line, size) + width(" ", size) + width(word, size) <= available {
                line.push(' ');
                line.push_str(word);
            } else {
                lines.push(std::mem::replace(&mut line, word.to_string()));
            }
        }
        lines.push(line);
    }
    lines
}

struct Pen(PathBuilder);

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.0.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_the_letters_of_mechanics() {
        let mechanics = "λω²μσ₁₂₃θπ×−·ρ⁴ΓκνεΔ∂∇≤≥≈∞°±→⁻⁰¹³⁵⁶⁷⁸⁹½′∂ᵢᵀ‖⊗∈∫∑√";
        let titles = "Élasticité Größe Ångström Łódź Çağ tensión Ελαστικότητα Упругость “…”–—";
        for c in [mechanics, titles].concat().chars() {
            let (glyph, _) = glyphs(c.encode_utf8(&mut [0; 4])).next().unwrap();
            assert_ne!(glyph, GlyphId(0), "{c} is missing");
        }
    }

    #[test]
    fn wrapping_keeps_every_word_and_the_line_width() {
        let text = "the first instability is physical or numerical";
        let lines = wrap(text, 12.0, 110.0);
        assert!(lines.len() > 2);
        assert!(lines.iter().all(|line| width(line, 12.0) <= 110.0));
        assert_eq!(lines.join(" "), text);
    }
}
