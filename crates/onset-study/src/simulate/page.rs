//! Page with an animation of a run, in a single self-contained file.

use super::SimulateAnswer;
use crate::html::escaped;
use crate::modes::{STYLE, moving_particles};

/// Largest displacement in the animation, in particle spacings.
const DRAWN_AMPLITUDE: f64 = 0.3;
/// Duration of one loop of the animation; seconds.
const SECONDS: u32 = 4;

/// Page with the printed answer and an animation of the fields, with displacements magnified.
///
/// `fields` holds the displacements of all fields, concatenated.
pub(super) fn page(
    answer: &SimulateAnswer,
    places: &[[f64; 3]],
    fields: &[f64],
    spacing: f64,
) -> String {
    let dimension = answer.wave_vector.len();
    let largest = fields.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let magnified = if largest > 0.0 {
        DRAWN_AMPLITUDE * spacing / largest
    } else {
        1.0
    };
    let size = dimension * places.len();
    let path = |n: usize| -> Vec<[f64; 3]> {
        let own = fields
            .chunks_exact(size)
            .map(|field| &field[dimension * n..]);
        let moved = own.map(|u| {
            std::array::from_fn(|i| match i < dimension {
                true => places[n][i] + magnified * u[i],
                false => places[n][i],
            })
        });
        moved.collect()
    };
    let paths: Vec<Vec<[f64; 3]>> = (0..places.len()).map(path).collect();
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>A patch in motion</title>\n<style>{STYLE}</style></head><body>\n<h1>A patch in motion</h1>\n\
         <p>Displacements from the homogeneous state, magnified {magnified:.3e} times.</p>\n<main><figure>{}</figure>\n<pre>{}</pre></main></body></html>\n",
        moving_particles(places, &paths, dimension, spacing, SECONDS),
        escaped(&answer.to_string())
    )
}
