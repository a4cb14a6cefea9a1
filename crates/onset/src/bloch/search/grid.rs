//! The spectrum on a grid over the zone, and its wells.

use super::{Candidate, Objective, ZoneSearch};
use crate::algebra::{Complex, eigenvalues};
use crate::bloch::DynamicalMatrix;
use crate::bloch::dynamical_matrix::grid_coordinates;
use crate::bloch::growth_rate;
use nalgebra::SVector;

/// The objectives on a periodic grid over the zone.
pub(super) struct Grid<const D: usize> {
    pub(super) resolution: usize,
    pub(super) points: Vec<GridPoint<D>>,
}

#[derive(Clone, Copy)]
pub(super) struct GridPoint<const D: usize> {
    /// Reference wave vector.
    pub(super) k: SVector<f64, D>,
    pub(super) scaled: f64,
    pub(super) lowest: f64,
    pub(super) highest: f64,
    pub(super) discriminant: f64,
    /// Fastest growth of a mode with complex `omega^2`.
    pub(super) growth: f64,
}

impl<const D: usize> ZoneSearch<D> {
    pub(super) fn grid(&self, matrix: &DynamicalMatrix<D>, points_per_period: usize) -> Grid<D> {
        let resolution = points_per_period * matrix.reach().clamp(4, 32);
        // A multiple of six has M, X and K among its points.
        let resolution = resolution.next_multiple_of(6);
        let resolution = if D == 3 {
            resolution.min(48)
        } else {
            resolution
        };
        let total = resolution.pow(D as u32);
        let matrices = if self.is_periodic {
            matrix.on_grid(resolution, true)
        } else {
            None
        };
        let mut points = Vec::with_capacity(total);
        // D(-k) = conj D(k), and index `total - n` (in each coordinate) is -k: half of the grid is enough.
        for index in 0..total {
            let opposite = opposite_index::<D>(index, resolution);
            if opposite < index {
                let GridPoint { k, .. }: GridPoint<D> = points[opposite];
                points.push(GridPoint {
                    k: -k,
                    ..points[opposite]
                });
                continue;
            }
            let centered = |j: usize| {
                if 2 * j > resolution {
                    j as f64 - resolution as f64
                } else {
                    j as f64
                }
            };
            let fractional =
                grid_coordinates::<D>(index, resolution).map(|j| centered(j) / resolution as f64);
            let mut k = self.reference.reciprocal() * SVector::from(fractional);
            if !self.is_periodic {
                k = self.folded(&k);
            }
            let d = match matrices.as_ref().and_then(|matrices| matrices.get(index)) {
                Some(d) => *d,
                None => matrix.at(&k),
            };
            let omega_squared = eigenvalues(&d, matrix.noise());
            let value = |objective| self.value(objective, &k, &d, &omega_squared);
            points.push(GridPoint {
                k,
                scaled: if index == 0 {
                    f64::INFINITY
                } else {
                    value(Objective::Scaled)
                },
                lowest: value(Objective::Lowest),
                highest: value(Objective::Highest),
                discriminant: value(Objective::Discriminant),
                growth: complex_growth(&omega_squared),
            });
        }
        Grid { resolution, points }
    }
}

impl<const D: usize> Grid<D> {
    /// The distinct local minima of the grid, deepest first.
    pub(super) fn wells(&self, objective: Objective) -> Vec<Candidate<D>> {
        let value = |index: usize| {
            let point = &self.points[index];
            match objective {
                Objective::Scaled => point.scaled,
                Objective::Lowest => point.lowest,
                Objective::Highest => point.highest,
                Objective::Discriminant => point.discriminant,
            }
        };
        let mut wells: Vec<Candidate<D>> = Vec::new();
        for index in 1..self.points.len() {
            let own = value(index);
            // Of k and -k only the first is taken.
            let first = opposite_index::<D>(index, self.resolution) >= index;
            if first && own.is_finite() && self.neighbors(index).all(|other| value(other) >= own) {
                wells.push((own, self.points[index].k));
            }
        }
        wells.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Wells of the same depth are images of each other under the symmetry of the lattice.
        wells.dedup_by(|b, a| (b.0 - a.0).abs() <= 1e-10 * a.0.abs());
        wells
    }

    fn neighbors(&self, index: usize) -> impl Iterator<Item = usize> {
        let n = self.resolution;
        let center = grid_coordinates::<D>(index, n);
        (0..3_usize.pow(D as u32))
            .filter(move |&shift| shift != 3_usize.pow(D as u32) / 2)
            .map(move |shift| {
                let offsets = grid_coordinates::<D>(shift, 3);
                (0..D).fold(0, |sum, i| sum * n + (center[i] + offsets[i] + n - 1) % n)
            })
    }
}

/// The fastest growth among complex eigenvalues.
pub(super) fn complex_growth(omega_squared: &[Complex]) -> f64 {
    omega_squared
        .iter()
        .filter(|value| value.im != 0.0)
        .map(|value| growth_rate(*value))
        .fold(0.0, f64::max)
}

fn opposite_index<const D: usize>(index: usize, resolution: usize) -> usize {
    grid_coordinates::<D>(index, resolution)
        .into_iter()
        .fold(0, |sum, j| sum * resolution + (resolution - j) % resolution)
}
