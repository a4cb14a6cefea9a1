//! Animated modes in a self-contained HTML page.

use super::view::View;
use super::{ModesAnswer, ShownMode};
use crate::figure::palette;
use crate::html::escaped;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Number of positions of a particle in a period.
const FRAMES: usize = 24;
/// Width of a picture, in pixels.
const WIDTH: f64 = 320.0;

/// Style sheet of pages with animated pictures.
pub(crate) const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#111}\
main{display:flex;flex-wrap:wrap;gap:1.5rem}figure{margin:0}figcaption{max-width:320px}";

impl ModesAnswer {
    /// Writes a page that animates every mode. Each particle moves along its ellipse, all with the same period; the amplitudes equal the amplitudes
    /// of the exported fields.
    pub fn page(&self) -> String {
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
             <title>Spurious modes</title>\n<style>{STYLE}</style></head><body>\n<h1>Spurious modes</h1>\n\
             <p>Zero-energy and weakly controlled modes of the method in the reference configuration. Wave vectors in units of the reciprocal \
             vectors.</p>\n<main>\n"
        );
        for mode in &self.modes {
            let _ = writeln!(
                page,
                "<figure>{}<figcaption>k = {}: {}</figcaption></figure>",
                self.moving(mode),
                escaped(&mode.place()),
                escaped(&mode.description())
            );
        }
        page.push_str("</main></body></html>\n");
        page
    }

    fn moving(&self, mode: &ShownMode) -> String {
        let shown = self.shown(mode);
        let places: Vec<[f64; 3]> = shown.iter().map(|n| mode.positions[*n]).collect();
        let path = |n: &usize| -> Vec<[f64; 3]> {
            let (x, u, quarter) = (
                &mode.positions[*n],
                &mode.displacements[*n],
                &mode.quarter[*n],
            );
            let turned = (0..=FRAMES).map(|frame| (TAU * frame as f64 / FRAMES as f64).sin_cos());
            let moved = turned.map(|(sine, cosine)| {
                std::array::from_fn(|i| x[i] + u[i] * cosine + quarter[i] * sine)
            });
            moved.collect()
        };
        let paths: Vec<Vec<[f64; 3]>> = shown.iter().map(path).collect();
        moving_particles(&places, &paths, self.dimension, self.spacing, 2)
    }
}

/// Draws particles that move periodically along their paths, which all have the same number of points. `places` are the reference positions, which
/// determine the frame. All lengths have the same unit.
pub(crate) fn moving_particles(
    places: &[[f64; 3]],
    paths: &[Vec<[f64; 3]>],
    dimension: usize,
    spacing: f64,
    seconds: u32,
) -> String {
    let view = View::of(places, dimension);
    // The farthest particles are drawn first.
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| {
        let farness = |n: &usize| view.seen(&places[*n]).farness;
        farness(b).total_cmp(&farness(a))
    });
    let ends = |axis: fn((f64, f64)) -> f64| {
        let all = places.iter().map(|x| axis(view.seen(x).at));
        let low = all.clone().fold(f64::INFINITY, f64::min);
        let high = all.fold(f64::NEG_INFINITY, f64::max);
        (low - spacing, high + spacing)
    };
    let ((left, right), (bottom, top)) = (ends(|at| at.0), ends(|at| at.1));
    let scale = WIDTH / (right - left);
    let height = (top - bottom) * scale;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {WIDTH:.0} {height:.0}\" \
         role=\"img\" aria-label=\"moving particles\">"
    );
    for n in order {
        let rest = view.seen(&places[n]);
        let radius = (0.16 * spacing * scale * rest.scale).max(1.5);
        let frames: Vec<(f64, f64)> = paths[n]
            .iter()
            .map(|moved| {
                let at = view.seen(moved).at;
                ((at.0 - left) * scale, (top - at.1) * scale)
            })
            .collect();
        let along = |axis: fn(&(f64, f64)) -> f64| {
            let all: Vec<String> = frames.iter().map(|at| format!("{:.2}", axis(at))).collect();
            (all.first().cloned().unwrap_or_default(), all.join(";"))
        };
        let ((cx, xs), (cy, ys)) = (along(|at| at.0), along(|at| at.1));
        let color = match dimension {
            3 => palette::BLUE.toward(palette::WHITE, 0.75 * rest.farness),
            _ => palette::BLUE,
        };
        let _ = write!(
            svg,
            "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{radius:.2}\" fill=\"{color}\" stroke=\"#ffffff\" stroke-width=\"0.7\">\
             <animate attributeName=\"cx\" values=\"{xs}\" dur=\"{seconds}s\" repeatCount=\"indefinite\"/>\
             <animate attributeName=\"cy\" values=\"{ys}\" dur=\"{seconds}s\" repeatCount=\"indefinite\"/></circle>"
        );
    }
    svg.push_str("</svg>");
    svg
}
