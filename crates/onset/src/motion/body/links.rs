//! Neighbors in total-Lagrangian bodies, stored for groups of consecutive particles.

use super::BodyError;
use super::shape::Placed;
use crate::algebra::{Each, array_of};
use crate::lattice::{Crystal, Particle};
use crate::real::LANES;
use crate::scheme::sph::correction;
use crate::scheme::{Bond, PairLaw};
use nalgebra::SMatrix;
use std::collections::HashMap;

/// Distance, as a fraction of the support, within which two particles coincide.
const COINCIDENCE_DISTANCE: f64 = 1e-9;
/// Largest number of a cell.
const MAX_CELL_NUMBER: f64 = 1e15;
/// Number that marks a missing particle.
const MISSING: u32 = u32::MAX;

/// Data shared by all pairs with the same vector and volume.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind<const D: usize> {
    /// Gradient vector `a_IJ = V_J grad W_IJ`; 1/length.
    pub(super) a: [f64; D],
    /// Reference vector `X_IJ`; length.
    pub(super) x: [f64; D],
    /// Stiffness of the penalty over `V_I`; force/length^(D+1).
    pub(super) stiffness: f64,
}

/// Pairs of one kind between particles of a group and others at the same offset in the order of particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Pair {
    /// Number of the other particle minus the number of the particle itself.
    pub(super) offset: i32,
    /// Number of the kind.
    pub(super) kind: u32,
    /// Particles of the group that have such a pair, one bit each; the lowest bit is the first particle.
    pub(super) of: u8,
}

/// Neighbors of the particles of a group. Groups with the same neighbors share one stencil.
#[derive(Clone, Debug)]
pub(super) struct Stencil<const D: usize> {
    /// Range of its pairs, first to one past the last.
    pub(super) pairs: [u32; 2],
    /// Correction `K^-1` of each particle.
    pub(super) correction: [[[f64; LANES]; D]; D],
    /// Sum `sum_J a_IJ` for each particle.
    pub(super) total: [[f64; LANES]; D],
}

/// Neighbors of all particles of a body.
pub(super) struct Links<const D: usize> {
    pub(super) kinds: Vec<Kind<D>>,
    pub(super) pairs: Vec<Pair>,
    pub(super) stencils: Vec<Stencil<D>>,
    /// Number of the stencil of each group of particles, with the width of a vector register.
    pub(super) groups: Vec<u32>,
}

impl<const D: usize> Links<D> {
    /// Finds the neighbors of the particles of a body.
    pub(super) fn new(
        crystal: &Crystal<D>,
        placed: &Placed<D>,
        law: &dyn PairLaw<D>,
    ) -> Result<Self, BodyError> {
        let mut links = Self {
            kinds: Vec::new(),
            pairs: Vec::new(),
            stencils: Vec::new(),
            groups: Vec::new(),
        };
        match &placed.places {
            Some(places) => links.regular(crystal, placed, places, law)?,
            None => links.irregular(placed, law)?,
        }
        links.pairs.shrink_to_fit();
        links.stencils.shrink_to_fit();
        Ok(links)
    }

    fn kind(&mut self, law: &dyn PairLaw<D>, x: [f64; D], volume: f64) -> u32 {
        let Bond {
            gradient,
            stiffness,
        } = law.bond(&x);
        self.kinds.push(Kind {
            a: gradient.each(|slope| slope * volume),
            x,
            stiffness: stiffness * volume,
        });
        self.kinds.len() as u32 - 1
    }

    /// Adds the particles of a lattice. All particles of a site have the same pairs, except for particles missing at the surface.
    fn regular(
        &mut self,
        crystal: &Crystal<D>,
        placed: &Placed<D>,
        places: &[Particle<D>],
        law: &dyn PairLaw<D>,
    ) -> Result<(), BodyError> {
        let mut neighbors = Vec::new();
        for (site, place) in crystal.sites().iter().enumerate() {
            let home = Particle::home(site);
            let seen = crystal.within(place, law.radius(), &SMatrix::identity());
            let others = seen.into_iter().filter(|other| *other != home);
            let own: Vec<(u32, Particle<D>)> = others
                .map(|other| {
                    let x = crystal.position(&other) - crystal.position(&home);
                    let volume = crystal.volumes()[other.site];
                    (self.kind(law, x.into(), volume), other)
                })
                .collect();
            neighbors.push(own);
        }
        let numbers = Numbers::new(places, crystal.sites().len());
        let mut groups = Groups::new(self, placed, law);
        for place in places {
            let seen = neighbors[place.site]
                .iter()
                .map(|(kind, other)| (*kind, numbers.of(&other.moved(&place.cell))));
            groups.next(seen.filter(|(_, other)| *other != MISSING))?;
        }
        groups.end()
    }

    /// Adds particles at arbitrary positions, with a separate kind for each pair.
    fn irregular(&mut self, placed: &Placed<D>, law: &dyn PairLaw<D>) -> Result<(), BodyError> {
        let radius = law.radius();
        // Cells beyond this number are not distinguished.
        let cell = |x: &[f64; D]| {
            x.each(|x| {
                (x / radius)
                    .floor()
                    .clamp(-MAX_CELL_NUMBER, MAX_CELL_NUMBER) as i64
            })
        };
        let mut cells: HashMap<[i64; D], Vec<u32>> = HashMap::new();
        for (number, x) in placed.positions.iter().enumerate() {
            cells.entry(cell(x)).or_default().push(number as u32);
        }
        let mut groups = Groups::new(self, placed, law);
        let mut near = Vec::new();
        for (number, x) in placed.positions.iter().enumerate() {
            near.clear();
            let home = cell(x);
            for step in 0..3_usize.pow(D as u32) {
                let mut rest = step;
                let beside = home.each(|n| {
                    let moved = n + (rest % 3) as i64 - 1;
                    rest /= 3;
                    moved
                });
                near.extend(cells.get(&beside).into_iter().flatten().copied());
            }
            near.retain(|other| *other as usize != number);
            near.sort_unstable();
            let mut pairs = Vec::new();
            for other in near.iter().copied() {
                let there = placed.positions[other as usize];
                let apart: [f64; D] = array_of(|i| there[i] - x[i]);
                let distance = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
                if distance < COINCIDENCE_DISTANCE * radius {
                    return Err(BodyError::Coincident {
                        first: number.min(other as usize),
                        second: number.max(other as usize),
                        position: x.to_vec(),
                    });
                }
                // Particles on the rim do not count, as in lattices.
                if distance < radius * (1.0 - 1e-12) {
                    let volume = placed.volumes[other as usize];
                    pairs.push((groups.links.kind(law, apart, volume), other));
                }
            }
            groups.next(pairs)?;
        }
        groups.end()
    }
}

/// Assembles consecutive particles into groups with the width of a vector register.
struct Groups<'a, const D: usize> {
    links: &'a mut Links<D>,
    placed: &'a Placed<D>,
    is_corrected: bool,
    /// Known stencils, by the number of particles and their pairs.
    known: HashMap<(usize, Vec<Pair>), u32>,
    /// Pairs of the current group.
    pairs: Vec<Pair>,
    /// Number of particles added.
    count: usize,
}

impl<'a, const D: usize> Groups<'a, D> {
    fn new(links: &'a mut Links<D>, placed: &'a Placed<D>, law: &dyn PairLaw<D>) -> Self {
        Self {
            links,
            placed,
            is_corrected: law.is_corrected(),
            known: HashMap::new(),
            pairs: Vec::new(),
            count: 0,
        }
    }

    /// Adds the next particle with its neighbors, given by kinds and numbers.
    fn next(&mut self, seen: impl IntoIterator<Item = (u32, u32)>) -> Result<(), BodyError> {
        let own = 1 << (self.count % LANES);
        for (place, (kind, other)) in seen.into_iter().enumerate() {
            let offset = other as i32 - self.count as i32;
            let is_it = |pair: &Pair| pair.kind == kind && pair.offset == offset;
            // Most particles have the same neighbors as the particle before.
            let known = match self.pairs.get(place).is_some_and(is_it) {
                true => Some(place),
                false => self.pairs.iter().position(is_it),
            };
            match known {
                Some(known) => self.pairs[known].of |= own,
                None => self.pairs.push(Pair {
                    offset,
                    kind,
                    of: own,
                }),
            }
        }
        self.count += 1;
        match self.count.is_multiple_of(LANES) {
            true => self.close(LANES),
            false => Ok(()),
        }
    }

    /// Ends the last group, which may be incomplete.
    fn end(mut self) -> Result<(), BodyError> {
        match self.count % LANES {
            0 => Ok(()),
            count => self.close(count),
        }
    }

    /// Ends the current group.
    fn close(&mut self, count: usize) -> Result<(), BodyError> {
        let key = (count, std::mem::take(&mut self.pairs));
        let stencil = match self.known.get(&key) {
            Some(known) => *known,
            None => {
                let number = self.links.stencils.len() as u32;
                self.begin(&key.1, count)?;
                self.known.insert(key, number);
                number
            }
        };
        self.links.groups.push(stencil);
        Ok(())
    }

    /// Computes and stores a new stencil.
    fn begin(&mut self, pairs: &[Pair], count: usize) -> Result<(), BodyError> {
        let mut stencil = Stencil {
            pairs: [0; 2],
            correction: [[[0.0; LANES]; D]; D],
            total: [[0.0; LANES]; D],
        };
        for lane in 0..count {
            let own = || pairs.iter().filter(|pair| pair.of >> lane & 1 == 1);
            let particle = self.count - count + lane;
            let lonely = || BodyError::Lonely {
                particle,
                position: self.placed.positions[particle].to_vec(),
                neighbors: own().count(),
            };
            if own().count() < D {
                return Err(lonely());
            }
            let mut moment = [[0.0; D]; D];
            for pair in own() {
                let kind = &self.links.kinds[pair.kind as usize];
                for i in 0..D {
                    stencil.total[i][lane] += kind.a[i];
                    for j in 0..D {
                        moment[i][j] += kind.x[i] * kind.a[j];
                    }
                }
            }
            let correction = match self.is_corrected {
                true => correction(&moment).map_err(|_| lonely())?,
                false => array_of(|i| array_of(|j| f64::from(i == j))),
            };
            for i in 0..D {
                for j in 0..D {
                    stencil.correction[i][j][lane] = correction[i][j];
                }
            }
        }
        let first = self.links.pairs.len() as u32;
        self.links.pairs.extend_from_slice(pairs);
        stencil.pairs = [first, self.links.pairs.len() as u32];
        self.links.stencils.push(stencil);
        Ok(())
    }
}

/// Indices of the particles of a lattice, by their sites and cells.
struct Numbers<const D: usize> {
    low: [i32; D],
    sides: [usize; D],
    sites: usize,
    numbers: Vec<u32>,
}

impl<const D: usize> Numbers<D> {
    fn new(places: &[Particle<D>], sites: usize) -> Self {
        let (mut low, mut high) = ([i32::MAX; D], [i32::MIN; D]);
        for place in places {
            for i in 0..D {
                low[i] = low[i].min(place.cell[i]);
                high[i] = high[i].max(place.cell[i]);
            }
        }
        let sides: [usize; D] = array_of(|i| (high[i] - low[i]) as usize + 1);
        let mut all = Self {
            low,
            sides,
            sites,
            numbers: vec![MISSING; sites * sides.iter().product::<usize>()],
        };
        for (number, place) in places.iter().enumerate() {
            if let Some(entry) = all.place(place) {
                all.numbers[entry] = number as u32;
            }
        }
        all
    }

    fn place(&self, particle: &Particle<D>) -> Option<usize> {
        let mut place = 0;
        for i in (0..D).rev() {
            let along = usize::try_from(particle.cell[i] - self.low[i]).ok()?;
            if along >= self.sides[i] {
                return None;
            }
            place = place * self.sides[i] + along;
        }
        Some(place * self.sites + particle.site)
    }

    fn of(&self, particle: &Particle<D>) -> u32 {
        self.place(particle)
            .map_or(MISSING, |place| self.numbers[place])
    }
}
