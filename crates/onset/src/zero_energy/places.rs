//! Wave vectors sorted into the cells of a grid, for neighbor search.

use crate::algebra::array_of;
use crate::lattice::BravaisLattice;
use nalgebra::SVector;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Number of grid cells along each reciprocal vector.
const CELLS: i32 = 64;

/// Set of wave vectors that are distinguished up to sign and reciprocal vectors.
pub(super) struct Places<const D: usize> {
    lattice: BravaisLattice<D>,
    cells: HashMap<[i32; D], Vec<SVector<f64, D>>>,
    count: usize,
}

impl<const D: usize> Places<D> {
    pub(super) fn new(lattice: &BravaisLattice<D>) -> Self {
        Self {
            lattice: *lattice,
            cells: HashMap::new(),
            count: 0,
        }
    }

    pub(super) fn add(&mut self, k: &SVector<f64, D>) {
        for place in [self.lattice.fractional(k), self.lattice.fractional(&-k)] {
            let cell = array_of(|i| cell_of(place[i]));
            self.cells.entry(cell).or_default().push(place);
        }
        self.count += 1;
    }

    /// Returns true if the distance of a wave vector from the set is at most `radius`.
    pub(super) fn has_within(&self, radius: f64, k: &SVector<f64, D>) -> bool {
        let place = self.lattice.fractional(k);
        let is_near = |other: &SVector<f64, D>| {
            let way = (other - place).map(|x| x - x.round());
            (self.lattice.reciprocal() * way).norm() <= radius
        };
        let extents: [i32; D] = array_of(|i| {
            let extent = radius * self.lattice.vectors().column(i).norm() / TAU;
            (extent * f64::from(CELLS)).ceil().min(f64::from(CELLS)) as i32
        });
        let around: usize = extents.iter().map(|n| (2 * n + 1) as usize).product();
        if around > self.cells.len() {
            return self.cells.values().flatten().any(is_near);
        }
        let middle: [i32; D] = array_of(|i| cell_of(place[i]));
        (0..around).any(|number| {
            let mut rest = number;
            let cell = array_of(|i| {
                let width = (2 * extents[i] + 1) as usize;
                let step = (rest % width) as i32 - extents[i];
                rest /= width;
                (middle[i] + step).rem_euclid(CELLS)
            });
            self.cells
                .get(&cell)
                .is_some_and(|own| own.iter().any(is_near))
        })
    }
}

fn cell_of(place: f64) -> i32 {
    ((place - place.floor()) * f64::from(CELLS)) as i32 % CELLS
}

#[cfg(test)]
mod tests {
    use super::Places;
    use crate::lattice::BravaisLattice;
    use nalgebra::{Matrix2, SVector, Vector2};

    #[test]
    fn neighbors_across_the_zone_boundary_are_found() {
        let lattice = BravaisLattice::<2>::new(Matrix2::new(1.0, 0.5, 0.0, 0.75_f64.sqrt()))
            .expect("a lattice");
        let reciprocal = *lattice.reciprocal();
        let mut places = Places::new(&lattice);
        let known: Vec<SVector<f64, 2>> = (0..40)
            .map(|n| reciprocal * Vector2::new(0.618 * n as f64, 0.377 * (n * n) as f64))
            .collect();
        known.iter().for_each(|k| places.add(k));
        let nearest = |k: &SVector<f64, 2>| {
            let ways = known.iter().flat_map(|own| {
                (0..18).map(move |n| {
                    let sign = if n < 9 { 1.0 } else { -1.0 };
                    let place = lattice.fractional(&(own * sign - k));
                    let place = place.map(|x| x - x.round());
                    let side = Vector2::new((n % 3) as f64 - 1.0, (n / 3 % 3) as f64 - 1.0);
                    (reciprocal * (place + side)).norm()
                })
            });
            ways.fold(f64::INFINITY, f64::min)
        };
        for n in 0..200 {
            let k = reciprocal * Vector2::new(0.013 * n as f64, -0.029 * n as f64);
            let distance = nearest(&k);
            assert!(places.has_within(distance * 1.001 + 1e-12, &k), "{n}");
            assert!(!places.has_within(distance * 0.999 - 1e-12, &k), "{n}");
        }
    }
}
