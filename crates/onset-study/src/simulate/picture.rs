//! Picture of a body: particles at their current positions, colored by stretch.

use crate::caption;
use crate::figure::{Axis, Figure, Panel};
use crate::number::told;
use crate::settings::Units;
use onset::motion::BodyMotion;

/// Largest number of particles in a picture.
pub(super) const MAX_DRAWN_PARTICLES: usize = 50_000;
/// Width of the picture; pixels.
const WIDTH: f64 = 760.0;

/// Largest principal stretch in the plane.
fn stretch(f: &[[f64; 3]; 3]) -> f64 {
    let c = |a: usize, b: usize| (0..2).map(|i| f[i][a] * f[i][b]).sum::<f64>();
    let (mean, half) = (0.5 * (c(0, 0) + c(1, 1)), 0.5 * (c(0, 0) - c(1, 1)));
    (mean + half.hypot(c(0, 1))).sqrt()
}

/// Figure of a plane body, with the particles at the last evaluation of its forces.
pub(super) fn figure(body: &dyn BodyMotion, time: f64, units: Units) -> Figure {
    let state = body.state();
    let places: Vec<(f64, f64)> = body
        .positions()
        .iter()
        .zip(state.displacements.chunks_exact(2))
        .map(|(x, u)| (x[0] + u[0], x[1] + u[1]))
        .collect();
    let stretches: Vec<f64> = body.deformations().iter().map(stretch).collect();
    let low = stretches.iter().copied().fold(f64::INFINITY, f64::min);
    let high = stretches
        .iter()
        .copied()
        .fold(0.0, f64::max)
        .max(low * (1.0 + 1e-9));
    let [x, y] =
        ["x₁", "x₂"].map(|what| Axis::linear(caption::label(units, what, "length"), (0.0, 1.0)));
    let x = x.covering(places.iter().map(|place| place.0));
    let y = y.covering(places.iter().map(|place| place.1));
    let panel = Panel::new("", x, y).equal_aspect();
    let panel = panel.with_particles(&places, &stretches, (low, high), "largest stretch");
    let [width, height] = [&panel.x, &panel.y].map(|axis| axis.range.1 - axis.range.0);
    let mut figure = Figure::new(format!(
        "Largest stretch of the particles at time {}",
        told(time)
    ))
    .with(panel);
    figure.panel_size = Some((WIDTH, (WIDTH * height / width).clamp(160.0, 900.0)));
    figure
}
