//! Pairs of moving particles within a distance of each other.

use crate::algebra::{Each, array_of};
use std::collections::HashMap;

/// Extra search distance, relative to the distance needed. Particles may move by half of it before the next search.
pub(super) const SKIN: f64 = 0.2;
/// Largest number of a cell; cells beyond it are not distinguished.
const MAX_CELL_NUMBER: f64 = 1e15;

/// Pairs of particles that may be within a distance of each other, updated when a particle has moved too far.
pub(super) struct Neighbors<const D: usize> {
    distance: f64,
    /// Positions of the particles at the last search.
    found_at: Vec<[f64; D]>,
    pairs: Vec<[u32; 2]>,
}

/// Squared distance of two points.
pub(super) fn squared<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

impl<const D: usize> Neighbors<D> {
    pub(super) fn new(distance: f64) -> Self {
        Self {
            distance,
            found_at: Vec::new(),
            pairs: Vec::new(),
        }
    }

    /// Pairs with the smaller number first, in increasing order. They include all pairs within the distance, so that sums over such pairs do not
    /// depend on the time of the search.
    pub(super) fn near(&mut self, places: &[[f64; D]]) -> &[[u32; 2]] {
        self.near_of(places, &|_, _| true)
    }

    /// Pairs selected by a function, which must return the same value for a pair in every call.
    pub(super) fn near_of(
        &mut self,
        places: &[[f64; D]],
        is_asked: &impl Fn(u32, u32) -> bool,
    ) -> &[[u32; 2]] {
        let allowed = 0.5 * SKIN * self.distance;
        let is_found = self.found_at.len() == places.len() && {
            let mut both = self.found_at.iter().zip(places);
            both.all(|(a, b)| squared(a, b) < allowed * allowed)
        };
        if !is_found {
            self.find(places, is_asked);
        }
        &self.pairs
    }

    /// Memory of the pairs; bytes.
    pub(super) fn bytes(&self) -> usize {
        self.pairs.len() * size_of::<[u32; 2]>() + self.found_at.len() * size_of::<[f64; D]>()
    }

    fn find(&mut self, places: &[[f64; D]], is_asked: &impl Fn(u32, u32) -> bool) {
        let cells = Cells::new(places, self.distance);
        self.pairs.clear();
        for (number, x) in (0_u32..).zip(places) {
            let first = self.pairs.len();
            cells.near(x, |other| {
                if other > number && is_asked(number, other) {
                    self.pairs.push([number, other]);
                }
            });
            self.pairs[first..].sort_unstable();
        }
        self.found_at.clear();
        self.found_at.extend_from_slice(places);
    }
}

/// Particles sorted into the cells of a grid. The cell size is the search distance.
pub(super) struct Cells<'p, const D: usize> {
    places: &'p [[f64; D]],
    reach: f64,
    /// Cells of all particles with their numbers, cell by cell.
    order: Vec<([i64; D], u32)>,
    /// Range of the particles of each cell in this order.
    cells: HashMap<[i64; D], [usize; 2]>,
}

impl<'p, const D: usize> Cells<'p, D> {
    /// Sorts particles for searches within a distance, extended by the skin.
    pub(super) fn new(places: &'p [[f64; D]], distance: f64) -> Self {
        let reach = (1.0 + SKIN) * distance;
        let numbered = (0_u32..).zip(places);
        let mut order: Vec<_> = numbered
            .map(|(number, x)| (Self::cell(x, reach), number))
            .collect();
        order.sort_unstable();
        let mut cells: HashMap<[i64; D], [usize; 2]> = HashMap::new();
        for (place, (own, _)) in order.iter().enumerate() {
            cells.entry(*own).or_insert([place, place])[1] = place + 1;
        }
        Self {
            places,
            reach,
            order,
            cells,
        }
    }

    fn cell(x: &[f64; D], reach: f64) -> [i64; D] {
        x.each(|x| (x / reach).floor().clamp(-MAX_CELL_NUMBER, MAX_CELL_NUMBER) as i64)
    }

    /// Calls a function with the number of every particle near a point, in no particular order, including a particle at the point.
    pub(super) fn near(&self, x: &[f64; D], mut tell: impl FnMut(u32)) {
        let home = Self::cell(x, self.reach);
        for code in 0..3_usize.pow(D as u32) {
            let beside: [i64; D] =
                array_of(|i| home[i] + (code / 3_usize.pow(i as u32) % 3) as i64 - 1);
            let Some([begin, end]) = self.cells.get(&beside) else {
                continue;
            };
            for (_, other) in &self.order[*begin..*end] {
                if squared(x, &self.places[*other as usize]) < self.reach * self.reach {
                    tell(*other);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Neighbors, squared};
    use crate::algebra::uniform;

    fn every_pair<const D: usize>(places: &[[f64; D]], distance: f64) -> Vec<[u32; 2]> {
        let mut all = Vec::new();
        for i in 0..places.len() {
            for j in i + 1..places.len() {
                if squared(&places[i], &places[j]) < distance * distance {
                    all.push([i as u32, j as u32]);
                }
            }
        }
        all
    }

    fn assert_found<const D: usize>(count: usize) {
        let mut random = 3;
        let mut number = || 2.0 * uniform(&mut random) - 1.0;
        let mut places: Vec<[f64; D]> = (0..count)
            .map(|_| std::array::from_fn(|_| 4.0 * number()))
            .collect();
        let mut neighbors = Neighbors::new(1.3);
        let (mut kept, mut changed) = (0, 0);
        let mut before = Vec::new();
        for _ in 0..60 {
            let near: Vec<[u32; 2]> = neighbors.near(&places).to_vec();
            let within = |pair: &&[u32; 2]| {
                let [a, b] = pair.map(|own| places[own as usize]);
                squared(&a, &b) < 1.3 * 1.3
            };
            let found: Vec<[u32; 2]> = near.iter().filter(within).copied().collect();
            assert_eq!(found, every_pair(&places, 1.3));
            kept += usize::from(near == before);
            changed += usize::from(near != before);
            before = near;
            for x in &mut places {
                x.iter_mut().for_each(|x| *x += 0.03 * number());
            }
        }
        assert!(kept > 10 && changed > 3, "{kept} {changed}");
    }

    #[test]
    fn pairs_of_moving_particles_equal_a_brute_force_search() {
        assert_found::<1>(40);
        assert_found::<2>(150);
        assert_found::<3>(300);
    }

    #[test]
    fn particles_at_huge_coordinates_pair_only_with_near_particles() {
        let mut places = vec![[0.0, 0.0], [0.5, 0.0], [1e300, 0.0], [-1e300, 1e12]];
        let mut neighbors = Neighbors::new(1.0);
        assert_eq!(neighbors.near(&places), [[0, 1]]);
        places[1] = [1e300, 0.3];
        assert_eq!(neighbors.near(&places), [[1, 2]]);
    }
}
