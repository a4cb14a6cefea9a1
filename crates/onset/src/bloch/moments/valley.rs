//! Methods with weakly controlled modes: valleys of nearly zero energy, whatever the state, with several bottoms at one
//! level. Extreme points do not tell these apart, so the weakest points of a grid are all kept, and those that lie apart
//! are descended from.

use super::contraction::Coefficients;
use super::parts;
use crate::algebra::sort_by_value;
use crate::lattice::{BravaisLattice, BrillouinZone, WaveGrid};
use nalgebra::SVector;

/// A method has a valley where moments are below this fraction of the largest one; a state, where its minimum is.
const WEAK: f64 = 1e-4;
/// This part of a grid is kept.
const PART: usize = 16;
/// Points this fraction above the best bottom are descended from too.
const RIVAL: f64 = 0.05;
/// Descents at most.
const DESCENTS: usize = 6;
/// Points are apart where the lattice Laplacian of the difference, times the square of the spacing, is larger: wells usually
/// are narrower.
const APART: f64 = 0.3;

/// The weakest points of the zone.
#[derive(Clone, Debug)]
pub(super) struct Valley<const D: usize> {
    wave_vectors: Vec<SVector<f64, D>>,
    moments: Vec<[f64; 3]>,
    lattice: BravaisLattice<D>,
    /// The largest moment.
    scale: f64,
}

impl<const D: usize> Valley<D> {
    /// Of half of a grid with moments that are scaled already, apart from zero; `None` of a method that is stiff throughout.
    pub(super) fn new(
        lattice: &BravaisLattice<D>,
        grid: &WaveGrid<D>,
        moments: &[[f64; 3]],
    ) -> Option<Self> {
        let trace = |n: &usize| moments[*n][0] + moments[*n][2];
        let mut points: Vec<usize> = (1..moments.len())
            .filter(|n| trace(n).is_finite())
            .collect();
        sort_by_value(&mut points, trace);
        let (weakest, strongest) = (points.first().map(trace)?, points.last().map(trace)?);
        if weakest > WEAK * strongest {
            return None;
        }
        let zone = BrillouinZone::new(*lattice);
        points.truncate(moments.len() / PART);
        Some(Self {
            wave_vectors: points
                .iter()
                .map(|n| zone.folded(&grid.wave_vector(*n)))
                .collect(),
            moments: points.iter().map(|n| moments[*n]).collect(),
            lattice: *lattice,
            scale: strongest,
        })
    }

    /// Whether a minimum lies in the valley, for a tangent of given magnitude.
    pub(super) fn holds(&self, minimum: f64, magnitude: f64) -> bool {
        minimum.abs() <= WEAK * self.scale * magnitude
    }

    /// The lowest bottom that a descent reaches from the points that lie apart, each the weakest of its surroundings.
    pub(super) fn bottom(
        &self,
        row: &Coefficients,
        magnitude: f64,
        descent: impl Fn(&SVector<f64, D>) -> (f64, SVector<f64, D>),
    ) -> (f64, SVector<f64, D>) {
        let values: Vec<f64> = self.moments.iter().map(|h| smaller(row, *h)).collect();
        let soft = WEAK * self.scale * magnitude;
        let mut best = (f64::INFINITY, SVector::zeros());
        let mut tried: Vec<(f64, SVector<f64, D>)> = Vec::with_capacity(DESCENTS);
        while tried.len() < DESCENTS {
            let limit = best.0 + RIVAL * best.0.abs() + soft;
            let is_new = |value: f64, k: &SVector<f64, D>| {
                // Equal values belong to images under the symmetry of the lattice and the state.
                tried.iter().all(|(other, from)| {
                    (value - other).abs() > 1e-9 * value.abs() && self.are_apart(k, from)
                })
            };
            let start = values
                .iter()
                .zip(&self.wave_vectors)
                .filter(|(value, k)| **value < limit && is_new(**value, k))
                .min_by(|a, b| a.0.total_cmp(b.0));
            let Some((value, k)) = start else { break };
            tried.push((*value, *k));
            let bottom = descent(k);
            if bottom.0 < best.0 {
                best = bottom;
            }
        }
        best
    }

    /// Whether two wave vectors, and their opposites, are further apart than wells usually are wide.
    fn are_apart(&self, k: &SVector<f64, D>, other: &SVector<f64, D>) -> bool {
        let lattice = &self.lattice;
        let apart = |difference: SVector<f64, D>| {
            // The lattice Laplacian is periodic.
            lattice.laplacian(&difference) * lattice.vectors().column(0).norm_squared() > APART
        };
        apart(k - other) && apart(k + other)
    }
}

/// The smaller eigenvalue.
fn smaller(row: &Coefficients, h: [f64; 3]) -> f64 {
    let [mean, half, mixed] = parts(row, h);
    mean - (half * half + mixed * mixed).sqrt()
}
