//! Which particles see which: runs of particles that see the same.

use super::BodyError;
use super::shape::Placed;
use crate::lattice::{Crystal, Particle};
use crate::scheme::sph::correction;
use crate::scheme::{Bond, PairLaw};
use nalgebra::SMatrix;
use std::collections::HashMap;

/// The most particles of a run.
const RUN: u32 = 512;
/// The most particles of a block, which one core works on.
const BLOCK: usize = 1024;
/// Particles nearer to each other than this share of the support are at one place.
const SAME_PLACE: f64 = 1e-9;
/// No particle.
const NONE: u32 = u32::MAX;

/// What pairs with the same vector and volume share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind<const D: usize> {
    /// `a_IJ = V_J grad W_IJ`; 1/length.
    pub(super) a: [f64; D],
    /// `X_IJ`; length.
    pub(super) x: [f64; D],
    /// The stiffness of the penalty over `V_I`; force/length^(D+1).
    pub(super) stiffness: f64,
}

/// A pair of the first particle of a run. Those that follow have the same, one particle further on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// The number of the other particle.
    pub(super) other: u32,
    /// The number of the kind.
    pub(super) kind: u32,
}

/// Particles that follow each other and see the same neighbors, each one particle further on.
#[derive(Clone, Debug)]
pub(super) struct Run<const D: usize> {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Its pairs, from one to before another.
    pub(super) pairs: [u32; 2],
    /// `K^-1`.
    pub(super) correction: [[f64; D]; D],
}

/// Runs that one core works on: from one to before another, and their particles likewise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) runs: [usize; 2],
    pub(super) particles: [usize; 2],
}

/// Who sees whom in a body.
pub(super) struct Links<const D: usize> {
    pub(super) kinds: Vec<Kind<D>>,
    pub(super) pairs: Vec<Pair>,
    pub(super) runs: Vec<Run<D>>,
    pub(super) blocks: Vec<Block>,
}

impl<const D: usize> Links<D> {
    /// Of the particles of a body.
    pub(super) fn new(
        crystal: &Crystal<D>,
        placed: &Placed<D>,
        law: &dyn PairLaw<D>,
    ) -> Result<Self, BodyError> {
        let mut links = Self {
            kinds: Vec::new(),
            pairs: Vec::new(),
            runs: Vec::new(),
            blocks: Vec::new(),
        };
        match &placed.places {
            Some(places) => links.regular(crystal, placed, places, law)?,
            None => links.irregular(placed, law)?,
        }
        links.pairs.shrink_to_fit();
        links.runs.shrink_to_fit();
        links.blocks = blocks(&links.runs);
        Ok(links)
    }

    fn kind(&mut self, law: &dyn PairLaw<D>, x: [f64; D], volume: f64) -> u32 {
        let Bond {
            gradient,
            stiffness,
        } = law.bond(&x);
        self.kinds.push(Kind {
            a: gradient.map(|slope| slope * volume),
            x,
            stiffness: stiffness * volume,
        });
        self.kinds.len() as u32 - 1
    }

    /// Particles of a lattice: the pairs of a site are those of all its particles, as far as there is somebody.
    fn regular(
        &mut self,
        crystal: &Crystal<D>,
        placed: &Placed<D>,
        places: &[Particle<D>],
        law: &dyn PairLaw<D>,
    ) -> Result<(), BodyError> {
        let mut stencils = Vec::new();
        for (site, place) in crystal.sites().iter().enumerate() {
            let home = Particle::home(site);
            let seen = crystal.within(place, law.radius(), &SMatrix::identity());
            let others = seen.into_iter().filter(|other| *other != home);
            let stencil: Vec<(u32, Particle<D>)> = others
                .map(|other| {
                    let x = crystal.position(&other) - crystal.position(&home);
                    let volume = crystal.volumes()[other.site];
                    (self.kind(law, x.into(), volume), other)
                })
                .collect();
            stencils.push(stencil);
        }
        let numbers = Numbers::new(places, crystal.sites().len());
        let (mut before, mut own): (Vec<Pair>, Vec<Pair>) = Default::default();
        for (number, place) in places.iter().enumerate() {
            own.clear();
            for (kind, other) in &stencils[place.site] {
                let other = numbers.of(&other.moved(&place.cell));
                if other != NONE {
                    own.push(Pair { other, kind: *kind });
                }
            }
            let goes_on = self.runs.last().is_some_and(|run| {
                let shifted = |(a, b): (&Pair, &Pair)| a.kind == b.kind && a.other + 1 == b.other;
                run.count < RUN
                    && before.len() == own.len()
                    && places[number - 1].site == place.site
                    && before.iter().zip(&own).all(shifted)
            });
            match self.runs.last_mut().filter(|_| goes_on) {
                Some(run) => run.count += 1,
                None => self.begin(number, &own, placed, law)?,
            }
            std::mem::swap(&mut before, &mut own);
        }
        Ok(())
    }

    /// Particles anywhere, each a run of its own.
    fn irregular(&mut self, placed: &Placed<D>, law: &dyn PairLaw<D>) -> Result<(), BodyError> {
        let radius = law.radius();
        let cell = |x: &[f64; D]| x.map(|x| (x / radius).floor() as i64);
        let mut cells: HashMap<[i64; D], Vec<u32>> = HashMap::new();
        for (number, x) in placed.positions.iter().enumerate() {
            cells.entry(cell(x)).or_default().push(number as u32);
        }
        let mut own = Vec::new();
        for (number, x) in placed.positions.iter().enumerate() {
            own.clear();
            let home = cell(x);
            for step in 0..3_usize.pow(D as u32) {
                let mut rest = step;
                let near = home.map(|n| {
                    let moved = n + (rest % 3) as i64 - 1;
                    rest /= 3;
                    moved
                });
                own.extend(cells.get(&near).into_iter().flatten().copied());
            }
            own.sort_unstable();
            let mut pairs = Vec::new();
            for other in own
                .iter()
                .copied()
                .filter(|other| *other as usize != number)
            {
                let there = placed.positions[other as usize];
                let apart: [f64; D] = std::array::from_fn(|i| there[i] - x[i]);
                let distance = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
                if distance < SAME_PLACE * radius {
                    return Err(BodyError::Coincident {
                        first: number.min(other as usize),
                        second: number.max(other as usize),
                        position: x.to_vec(),
                    });
                }
                // As in lattices: the rim does not count.
                if distance < radius * (1.0 - 1e-12) {
                    let kind = self.kind(law, apart, placed.volumes[other as usize]);
                    pairs.push(Pair { other, kind });
                }
            }
            self.begin(number, &pairs, placed, law)?;
        }
        Ok(())
    }

    /// Begins a run with a particle.
    fn begin(
        &mut self,
        number: usize,
        pairs: &[Pair],
        placed: &Placed<D>,
        law: &dyn PairLaw<D>,
    ) -> Result<(), BodyError> {
        let lonely = || BodyError::Lonely {
            particle: number,
            position: placed.positions[number].to_vec(),
            neighbors: pairs.len(),
        };
        if pairs.len() < D {
            return Err(lonely());
        }
        let correction = match law.is_corrected() {
            true => {
                let mut moment = [[0.0; D]; D];
                for pair in pairs {
                    let kind = &self.kinds[pair.kind as usize];
                    for i in 0..D {
                        for j in 0..D {
                            moment[i][j] += kind.x[i] * kind.a[j];
                        }
                    }
                }
                correction(&moment).map_err(|_| lonely())?
            }
            false => std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j))),
        };
        let first = self.pairs.len() as u32;
        self.pairs.extend_from_slice(pairs);
        self.runs.push(Run {
            first: number as u32,
            count: 1,
            pairs: [first, self.pairs.len() as u32],
            correction,
        });
        Ok(())
    }
}

/// The numbers of the particles of a lattice, by their places.
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
        let sides: [usize; D] = std::array::from_fn(|i| (high[i] - low[i]) as usize + 1);
        let mut all = Self {
            low,
            sides,
            sites,
            numbers: vec![NONE; sites * sides.iter().product::<usize>()],
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
            .map_or(NONE, |place| self.numbers[place])
    }
}

fn blocks<const D: usize>(runs: &[Run<D>]) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for (number, run) in runs.iter().enumerate() {
        let end = (run.first + run.count) as usize;
        match blocks.last_mut() {
            Some(block) if end - block.particles[0] <= BLOCK => {
                block.runs[1] = number + 1;
                block.particles[1] = end;
            }
            _ => blocks.push(Block {
                runs: [number, number + 1],
                particles: [run.first as usize, end],
            }),
        }
    }
    blocks
}
