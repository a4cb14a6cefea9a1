//! Neighbor search for moving particles in groups of eight.

use super::neighbors::{Cells, SKIN};
use super::vectors::{Field, vector_of};
use crate::algebra::array_of;
use crate::cores::of_each;
use crate::real::{LANES, Lanes, Real, Side, Work};
use crate::scheme::sph::CurrentPairs;
use crate::scheme::{Measure, Weighed};

/// Coordinate of padding particles, beyond the support of every particle. Their mutual contributions are discarded.
pub(super) const PADDING_COORDINATE: f64 = 1e100;
/// Number of groups in one task of the neighbor search.
const BLOCK: usize = 64;

/// Possible neighbors of each group of consecutive particles, as offsets in the order of particles. They are updated when a particle has moved too
/// far.
///
/// Most neighbors have the same offset in this order from one particle of a group to the next.
pub(super) struct Neighborhoods<const D: usize> {
    /// Positions of the particles at the last search.
    found_at: Field<D>,
    /// End of the offsets of each group.
    ends: Vec<usize>,
    /// Offsets of each group in increasing order.
    offsets: Vec<i32>,
}

/// One neighbor of each particle of a group.
pub(super) struct Seen<const D: usize> {
    /// Index of the neighbor of the first particle.
    pub(super) place: usize,
    /// Vectors from the particles to these neighbors.
    pub(super) x: [Lanes; D],
    /// Weights along these vectors; zero beyond the support and for padding.
    pub(super) weight: Weighed<Lanes, D>,
}

// Closures would not compile to vector instructions, therefore explicit loops.

/// Values of consecutive particles starting at an index, padded with zeros.
#[inline(always)]
pub(super) fn number(of: &[f64], place: usize) -> Lanes {
    Lanes::at(of, place, 0.0)
}

/// Vectors of consecutive particles starting at an index.
#[inline(always)]
pub(super) fn vector<const D: usize>(of: &[&[f64]; D], place: usize) -> [Lanes; D] {
    let mut own = [Lanes([0.0; LANES]); D];
    for i in 0..D {
        own[i] = number(of[i], place);
    }
    own
}

/// Tensors of consecutive particles starting at an index.
#[inline(always)]
pub(super) fn tensor<const D: usize>(of: &[[&[f64]; D]; D], place: usize) -> [[Lanes; D]; D] {
    let mut own = [[Lanes([0.0; LANES]); D]; D];
    for i in 0..D {
        own[i] = vector(&of[i], place);
    }
    own
}

impl<const D: usize> Neighborhoods<D> {
    pub(super) fn new() -> Self {
        Self {
            found_at: std::array::from_fn(|_| Vec::new()),
            ends: Vec::new(),
            offsets: Vec::new(),
        }
    }

    /// Updates the possible neighbors of `count` particles, if the last search is no longer valid.
    pub(super) fn find(&mut self, law: &CurrentPairs<D>, places: &Field<D>, count: usize) {
        let are_known = self.found_at[0].len() == places[0].len();
        if are_known && !self.have_moved(law, places) {
            return;
        }
        let measured: Vec<[f64; D]> = (0..count)
            .map(|n| law.measured(&vector_of(places, n)))
            .collect();
        let cells = Cells::new(&measured, law.radius());
        let blocks = (0..count).step_by(BLOCK * LANES).collect();
        let found = of_each(blocks, |first: usize| {
            let (mut ends, mut offsets) = (Vec::new(), Vec::new());
            for group in (first..count.min(first + BLOCK * LANES)).step_by(LANES) {
                let mut own: Vec<i32> = Vec::new();
                for particle in group..count.min(group + LANES) {
                    let offset = |other: u32| other as i32 - particle as i32;
                    cells.near(&measured[particle], |other| own.push(offset(other)));
                }
                own.sort_unstable();
                own.dedup();
                offsets.extend(own.into_iter().filter(|offset| *offset != 0));
                ends.push(offsets.len());
            }
            (ends, offsets)
        });
        self.ends.clear();
        self.offsets.clear();
        for (ends, offsets) in found {
            let before = self.offsets.len();
            self.ends.extend(ends.into_iter().map(|end| before + end));
            self.offsets.extend(offsets);
        }
        self.found_at.clone_from(places);
    }

    /// Returns true if a particle has moved by half of the skin.
    fn have_moved(&self, law: &CurrentPairs<D>, places: &Field<D>) -> bool {
        let measure = law.measure();
        let now = places.each_ref().map(Vec::as_slice);
        let then = self.found_at.each_ref().map(Vec::as_slice);
        let allowed = 0.25 * SKIN * SKIN;
        (0..places[0].len()).step_by(LANES).any(|place| {
            let (now, then) = (vector(&now, place), vector(&then, place));
            let squared = measure.of(&array_of(|i| now[i] - then[i])).squared;
            squared.side(allowed) != Some(Side::Below)
        })
    }

    /// Offsets of the group that begins with a particle.
    fn of(&self, particle: usize) -> &[i32] {
        let group = particle / LANES;
        let begin = group.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.offsets[begin..self.ends[group]]
    }

    /// Memory in use; bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.offsets) + size_of_val(&*self.ends) + D * size_of_val(&*self.found_at[0])
    }
}

/// Collects the neighbors of the group that begins with a particle: offsets for which at least one pair is within the support.
pub(super) struct Look<'s, const D: usize> {
    pub(super) law: &'s CurrentPairs<D>,
    pub(super) measure: &'s Measure<D>,
    pub(super) neighborhoods: &'s Neighborhoods<D>,
    pub(super) places: &'s [&'s [f64]; D],
    pub(super) own: usize,
    pub(super) seen: &'s mut Vec<Seen<D>>,
}

impl<const D: usize> Work for Look<'_, D> {
    type Output = ();

    #[inline(always)]
    fn done(self) {
        let own = vector(self.places, self.own);
        self.seen.clear();
        for offset in self.neighborhoods.of(self.own) {
            let place = self.own.wrapping_add_signed(*offset as isize);
            let mut x = own;
            for i in 0..D {
                x[i] = Lanes::at(self.places[i], place, PADDING_COORDINATE) - own[i];
            }
            let measured = self.measure.of(&x);
            if measured.squared.side(1.0) == Some(Side::Above) {
                continue;
            }
            let weight = self.law.weigh_measured(&measured);
            self.seen.push(Seen { place, x, weight });
        }
    }
}
