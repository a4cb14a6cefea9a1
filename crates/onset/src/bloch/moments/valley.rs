//! Valleys of `omega^2(k)` with nearly zero energy, in methods with weakly controlled modes.
//!
//! A valley has several minima of similar depth, and the state determines the lowest of them. All of the lowest grid points are therefore kept, and
//! descents start from well separated points.

use super::contraction::Coefficients;
use super::parts;
use crate::algebra::sort_by_value;
use crate::lattice::{BravaisLattice, BrillouinZone, WaveGrid};
use nalgebra::SVector;

/// Largest ratio of the smallest to the largest moment of a method with a valley, and of the minimum to the largest value of a state in it.
const VALLEY_RATIO: f64 = 1e-4;
/// Inverse of the fraction of grid points that are kept.
const KEPT_PART_DIVISOR: usize = 16;
/// Largest relative height above the best bottom of points that start a descent.
const RIVAL_HEIGHT: f64 = 0.05;
/// Maximum number of descents.
const MAXIMUM_DESCENTS: usize = 6;
/// Smallest separation of starts: the lattice Laplacian of the difference of two wave vectors, times the squared spacing. Wells are usually narrower.
const START_SEPARATION: f64 = 0.3;

/// Weakest points of the zone.
#[derive(Clone, Debug)]
pub(super) struct Valley<const D: usize> {
    wave_vectors: Vec<SVector<f64, D>>,
    moments: Vec<[f64; 3]>,
    lattice: BravaisLattice<D>,
    /// Largest moment of all points.
    scale: f64,
}

impl<const D: usize> Valley<D> {
    /// Selects the weakest points from the scaled moments at half of a grid, except `k = 0`; `None` if the method has no weakly controlled modes.
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
        if weakest > VALLEY_RATIO * strongest {
            return None;
        }
        let zone = BrillouinZone::new(*lattice);
        points.truncate(moments.len() / KEPT_PART_DIVISOR);
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

    /// Returns true if a minimum lies in the valley, for a tangent of the given magnitude.
    pub(super) fn holds(&self, minimum: f64, magnitude: f64) -> bool {
        minimum.abs() <= VALLEY_RATIO * self.scale * magnitude
    }

    /// Lowest bottom of the descents from well separated points, each the weakest point in its surroundings.
    pub(super) fn bottom(
        &self,
        row: &Coefficients,
        magnitude: f64,
        descent: impl Fn(&SVector<f64, D>) -> (f64, SVector<f64, D>),
    ) -> (f64, SVector<f64, D>) {
        let values: Vec<f64> = self.moments.iter().map(|h| smaller(row, *h)).collect();
        let soft = VALLEY_RATIO * self.scale * magnitude;
        let mut best = (f64::INFINITY, SVector::zeros());
        let mut tried: Vec<(f64, SVector<f64, D>)> = Vec::with_capacity(MAXIMUM_DESCENTS);
        while tried.len() < MAXIMUM_DESCENTS {
            let limit = best.0 + RIVAL_HEIGHT * best.0.abs() + soft;
            let is_new = |value: f64, k: &SVector<f64, D>| {
                // Equal values belong to symmetric images.
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

    /// Returns true if two wave vectors, also up to sign, are separated by more than the usual width of a well.
    fn are_apart(&self, k: &SVector<f64, D>, other: &SVector<f64, D>) -> bool {
        let lattice = &self.lattice;
        let apart = |difference: SVector<f64, D>| {
            // The lattice Laplacian is periodic.
            lattice.laplacian(&difference) * lattice.vectors().column(0).norm_squared()
                > START_SEPARATION
        };
        apart(k - other) && apart(k + other)
    }
}

/// Smaller eigenvalue of `D`.
fn smaller(row: &Coefficients, h: [f64; 3]) -> f64 {
    let [mean, half, mixed] = parts(row, h);
    mean - (half * half + mixed * mixed).sqrt()
}
