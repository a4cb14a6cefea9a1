//! Pen: primitives that add shapes to a scene.

use super::scene::{Anchor, Paint, Shape, Stroke, Words};
use super::{Color, Dash, Marker, palette};
use tiny_skia::{Path, PathBuilder};

/// Color of axes and words.
pub(super) const INK: Color = Color::hex(0x222222);
/// Font size of numbers, legends and captions, in pixels.
pub(super) const NUMBERS: f64 = 12.0;
/// Height of digits and capitals, in font sizes.
pub(super) const CAPITAL: f64 = 0.73;

/// Collects the shapes of a scene; shapes without extent are skipped.
#[derive(Default)]
pub(super) struct Pen {
    pub(super) shapes: Vec<Shape>,
    /// Whether shapes get a white rim, so that they stand out from any color.
    pub(super) rims: bool,
}

impl Pen {
    pub(super) fn outline(&mut self, outline: PathBuilder, paint: Paint) {
        self.outline_within(outline, paint, None);
    }

    /// Adds an outline. A window, given by left, top, width and height, limits the painted area.
    pub(super) fn outline_within(
        &mut self,
        outline: PathBuilder,
        paint: Paint,
        window: Option<[f64; 4]>,
    ) {
        if let Some(outline) = finish(outline, &paint) {
            let window = window.map(|window| window.map(|own| own as f32));
            let rim = self.rim(&paint).map(|paint| Shape::Outline {
                outline: outline.clone(),
                paint,
                window,
            });
            self.shapes.extend(rim);
            self.shapes.push(Shape::Outline {
                outline,
                paint,
                window,
            });
        }
    }

    pub(super) fn stamps(&mut self, outline: PathBuilder, at: Vec<(f64, f64)>, paint: Paint) {
        if let Some(outline) = finish(outline, &paint) {
            let rim = self.rim(&paint).map(|paint| Shape::Stamps {
                outline: outline.clone(),
                at: at.clone(),
                paint,
            });
            self.shapes.extend(rim);
            self.shapes.push(Shape::Stamps { outline, at, paint });
        }
    }

    fn rim(&self, paint: &Paint) -> Option<Paint> {
        let width = paint.stroke.map_or(0.0, |stroke| stroke.width) + 2.0;
        (self.rims && !paint.crisp).then(|| Paint::stroke(palette::WHITE, width, Dash::Solid))
    }

    pub(super) fn words(&mut self, text: String, at: (f64, f64), anchor: Anchor, size: f64) {
        if !text.is_empty() {
            self.shapes.push(Shape::Words(Words {
                text,
                at,
                anchor,
                upward: false,
                size,
                color: INK,
                rim: false,
            }));
        }
    }

    pub(super) fn words_upward(&mut self, text: String, at: (f64, f64), size: f64) {
        self.words(text, at, Anchor::Middle, size);
        if let Some(Shape::Words(words)) = self.shapes.last_mut() {
            words.upward = true;
        }
    }
}

fn finish(outline: PathBuilder, paint: &Paint) -> Option<Path> {
    let is_visible = |stroke: Stroke| stroke.width > 0.0;
    (paint.fill.is_some() || paint.stroke.is_some_and(is_visible)).then(|| outline.finish())?
}

pub(super) fn segment(outline: &mut PathBuilder, from: (f64, f64), to: (f64, f64)) {
    outline.move_to(from.0 as f32, from.1 as f32);
    outline.line_to(to.0 as f32, to.1 as f32);
}

pub(super) fn polygon(outline: &mut PathBuilder, corners: &[(f64, f64)]) {
    for (i, &(x, y)) in corners.iter().enumerate() {
        if i == 0 {
            outline.move_to(x as f32, y as f32);
        } else {
            outline.line_to(x as f32, y as f32);
        }
    }
    outline.close();
}

pub(super) fn rectangle(outline: &mut PathBuilder, from: (f64, f64), to: (f64, f64)) {
    polygon(outline, &[from, (to.0, from.1), to, (from.0, to.1)]);
}

pub(super) fn crisp(color: Color) -> Paint {
    Paint {
        crisp: true,
        ..Paint::fill(color)
    }
}

/// Clips a width or size to a drawable value: finite and between 0 and 100 pixels.
pub(super) fn pixels(size: f64) -> f64 {
    if size.is_finite() {
        size.clamp(0.0, 100.0)
    } else {
        1.0
    }
}

/// Outline of a marker around the origin.
pub(super) fn marker(
    marker: Marker,
    size: f64,
    color: Color,
    filled: bool,
) -> (PathBuilder, Paint) {
    let r = pixels(size) / 2.0;
    let mut outline = PathBuilder::new();
    match marker {
        Marker::Circle => {
            let (r, k) = (r as f32, (r * 0.552_284_75) as f32);
            outline.move_to(r, 0.0);
            outline.cubic_to(r, k, k, r, 0.0, r);
            outline.cubic_to(-k, r, -r, k, -r, 0.0);
            outline.cubic_to(-r, -k, -k, -r, 0.0, -r);
            outline.cubic_to(k, -r, r, -k, r, 0.0);
            outline.close();
        }
        // Centered on the centroid, where the eye expects the data point.
        Marker::Triangle => {
            let r = 1.2 * r;
            polygon(
                &mut outline,
                &[(0.0, -r), (0.866 * r, 0.5 * r), (-0.866 * r, 0.5 * r)],
            );
        }
        Marker::Square => rectangle(&mut outline, (-0.9 * r, -0.9 * r), (0.9 * r, 0.9 * r)),
        Marker::Cross => {
            segment(&mut outline, (-r, -r), (r, r));
            segment(&mut outline, (-r, r), (r, -r));
        }
        Marker::Left | Marker::Right => {
            let along = if marker == Marker::Left { -r } else { r };
            let (tip, neck, inner) = (1.8 * along, -0.2 * along, 0.2 * along);
            let corners = [
                (tip, 0.0),
                (neck, 0.75 * r),
                (inner, 0.2 * r),
                (-tip, 0.2 * r),
                (-tip, -0.2 * r),
                (inner, -0.2 * r),
                (neck, -0.75 * r),
            ];
            polygon(&mut outline, &corners);
        }
    }
    let paint = match (marker, filled) {
        (Marker::Cross, _) => Paint::stroke(color, 1.6, Dash::Solid),
        (Marker::Left | Marker::Right, _) | (_, true) => Paint::fill(color),
        (_, false) => Paint {
            fill: Some(palette::WHITE),
            ..Paint::stroke(color, 1.3, Dash::Solid)
        },
    };
    (outline, paint)
}
