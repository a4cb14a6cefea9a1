//! Modes that move, in a page that needs nothing else.

use super::{ModesAnswer, ShownMode};
use crate::html::escaped;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Positions of a particle in a period.
const FRAMES: usize = 24;
/// Width of a picture, in pixels.
const WIDTH: f64 = 320.0;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#111}\
main{display:flex;flex-wrap:wrap;gap:1.5rem}figure{margin:0}figcaption{max-width:320px}";

impl ModesAnswer {
    /// A page on which every mode moves: each particle along its ellipse, all in one period. The displacements are those of the
    /// exported fields.
    pub fn page(&self) -> String {
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
             <title>Spurious modes</title>\n<style>{STYLE}</style></head><body>\n<h1>Spurious modes</h1>\n\
             <p>Waves of the undeformed body that the method does not resist, or too little. Wave vectors in units of the reciprocal \
             vectors.</p>\n<main>\n"
        );
        for mode in &self.modes {
            let _ = writeln!(
                page,
                "<figure>{}<figcaption>k = {}: {}</figcaption></figure>",
                self.moving(mode),
                escaped(&mode.place()),
                escaped(&mode.kind())
            );
        }
        page.push_str("</main></body></html>\n");
        page
    }

    fn moving(&self, mode: &ShownMode) -> String {
        let margin = self.spacing;
        let shown = self.shown(mode);
        let seen = |all: &[[f64; 3]]| -> Vec<[f64; 2]> {
            shown.iter().map(|n| self.seen(&all[*n]).into()).collect()
        };
        let (positions, now, later) = (
            seen(&mode.positions),
            seen(&mode.displacements),
            seen(&mode.quarter),
        );
        let ends = |axis: usize| {
            let all = positions.iter().map(move |x| x[axis]);
            let low = all.clone().fold(f64::INFINITY, f64::min);
            let high = all.fold(f64::NEG_INFINITY, f64::max);
            (low - margin, high + margin)
        };
        let ((left, right), (bottom, top)) = (ends(0), ends(1));
        let scale = WIDTH / (right - left);
        let height = (top - bottom) * scale;
        let radius = (0.16 * self.spacing * scale).max(1.5);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {WIDTH:.0} {height:.0}\" \
             role=\"img\" aria-label=\"moving particles\">"
        );
        for ((x, u), quarter) in positions.iter().zip(&now).zip(&later) {
            let along = |axis: usize| {
                let at = |frame: usize| {
                    let (sine, cosine) = (TAU * frame as f64 / FRAMES as f64).sin_cos();
                    let moved = x[axis] + u[axis] * cosine + quarter[axis] * sine;
                    if axis == 0 {
                        (moved - left) * scale
                    } else {
                        (top - moved) * scale
                    }
                };
                let all: Vec<String> = (0..=FRAMES)
                    .map(|frame| format!("{:.2}", at(frame)))
                    .collect();
                (format!("{:.2}", at(0)), all.join(";"))
            };
            let ((cx, xs), (cy, ys)) = (along(0), along(1));
            let _ = write!(
                svg,
                "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{radius:.2}\" fill=\"#0072b2\">\
                 <animate attributeName=\"cx\" values=\"{xs}\" dur=\"2s\" repeatCount=\"indefinite\"/>\
                 <animate attributeName=\"cy\" values=\"{ys}\" dur=\"2s\" repeatCount=\"indefinite\"/></circle>"
            );
        }
        svg.push_str("</svg>");
        svg
    }
}
