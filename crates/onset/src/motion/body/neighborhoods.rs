//! Whom particles that move see, eight of them at once.

use super::neighbors::{Cells, SKIN};
use super::vectors::{Field, vector_of};
use crate::algebra::array_of;
use crate::cores::of_each;
use crate::real::{LANES, Lanes, Real, Side, Work};
use crate::scheme::sph::CurrentPairs;
use crate::scheme::{Measure, Weighed};

/// Where there is no particle: so far away that no particle sees it. What fills up the last group is there together, and what it sees of itself is thrown away.
pub(super) const NOWHERE: f64 = 1e100;
/// Groups whose neighbors one core looks for at a time.
const BLOCK: usize = 64;

/// For each group of particles that follow each other how far away, in their order, are those that they see or may see soon; found again when a particle has moved
/// too far. Neighbors in space are mostly as far away in that order from one particle of a group as from the next.
pub(super) struct Neighborhoods<const D: usize> {
    /// Where the particles were then.
    found_at: Field<D>,
    /// Where those of each group end.
    ends: Vec<usize>,
    /// In increasing order.
    offsets: Vec<i32>,
}

/// A neighbor of each particle of a group.
pub(super) struct Seen<const D: usize> {
    /// The number of that of the first one.
    pub(super) place: usize,
    /// The vectors to them.
    pub(super) x: [Lanes; D],
    /// Along these; zero beyond the support, and where there is no particle.
    pub(super) weight: Weighed<Lanes, D>,
}

// Closures would not be compiled for the vectors of the machine: loops it is.

/// The numbers of the particles from a place on; zeros where there is none.
#[inline(always)]
pub(super) fn number(of: &[f64], place: usize) -> Lanes {
    Lanes::at(of, place, 0.0)
}

/// The vectors of the particles from a place on.
#[inline(always)]
pub(super) fn vector<const D: usize>(of: &[&[f64]; D], place: usize) -> [Lanes; D] {
    let mut own = [Lanes([0.0; LANES]); D];
    for i in 0..D {
        own[i] = number(of[i], place);
    }
    own
}

/// The tensors of the particles from a place on.
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

    /// Finds those of so many particles at places, if what was found does not hold any more.
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

    /// Whether a particle has moved by half of the skin.
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

    /// Of the group that begins with a particle.
    fn of(&self, particle: usize) -> &[i32] {
        let group = particle / LANES;
        let begin = group.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.offsets[begin..self.ends[group]]
    }

    /// What is kept; bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.offsets) + size_of_val(&*self.ends) + D * size_of_val(&*self.found_at[0])
    }
}

/// Looks for the neighbors of the group that begins with a particle: those of which at least one is within the support.
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
                x[i] = Lanes::at(self.places[i], place, NOWHERE) - own[i];
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
