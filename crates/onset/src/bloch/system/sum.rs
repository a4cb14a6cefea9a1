//! Lattice sums with plane-wave phases, for several particles in a cell.

use super::expansion::MatrixExpansion;
use crate::algebra::{Complex, Each, array_of};
use crate::bloch::powers::Powers;
use crate::cancel::checkpoint;
use crate::lattice::{Crystal, Particle};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::collections::BTreeMap;

/// Lattice sum `S(k) = sum_R S(R) exp(i k.(X_to - X_from))`: a matrix between the displacements of the particles of a cell.
///
/// It consists of blocks between pairs of particles; the row belongs to a particle `from` of the cell at the origin. Shape `(D n) x (D n)` with `n`
/// particles in a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct BlochSum<const D: usize> {
    /// Positions of the particles of a cell, relative to the first particle.
    sites: Vec<SVector<f64, D>>,
    /// Cells that contain column particles: lattice coordinates and position. Stored once, so that their phases are computed once for all pairs.
    cells: Vec<([i32; D], SVector<f64, D>)>,
    primitive: [SVector<f64, D>; D],
    /// Largest lattice coordinate of a cell, in magnitude.
    reach: usize,
    /// Sum over the blocks of the largest entry of each.
    magnitude: f64,
    terms: Vec<Term<D>>,
}

/// Block of one pair of particles.
#[derive(Clone, Debug, PartialEq)]
struct Term<const D: usize> {
    from: usize,
    to: Particle<D>,
    /// Index of the cell of `to` in `cells`.
    cell: usize,
    /// `X_to - X_from` in the reference state.
    vector: SVector<f64, D>,
    block: SMatrix<f64, D, D>,
}

/// Phases `exp(i k.X)` of the particles of the cell at the origin and of the cells.
struct Phases {
    sites: Vec<Complex>,
    cells: Vec<Complex>,
}

impl Phases {
    #[inline]
    fn of<const D: usize>(&self, term: &Term<D>) -> Complex {
        let cell = self.cells[term.cell];
        match term.from == term.to.site {
            true => cell,
            false => self.sites[term.from].conj() * self.sites[term.to.site] * cell,
        }
    }
}

/// Collects the blocks of a [`BlochSum`].
#[derive(Clone, Debug, Default)]
pub struct BlochBlocks<const D: usize> {
    blocks: BTreeMap<(usize, Particle<D>), SMatrix<f64, D, D>>,
}

impl<const D: usize> BlochBlocks<D> {
    /// Creates an empty collection.
    pub fn new() -> Self {
        Self {
            blocks: BTreeMap::new(),
        }
    }

    /// Adds to the block between two particles; it depends only on their sites and the difference of their cells.
    pub fn add(&mut self, from: &Particle<D>, to: &Particle<D>, block: &SMatrix<f64, D, D>) {
        let back = from.cell.each(|n| -n);
        let entry = self.blocks.entry((from.site, to.moved(&back)));
        *entry.or_insert_with(SMatrix::zeros) += block;
    }

    /// Returns the collection with each block replaced.
    pub(crate) fn each(
        &self,
        replaced: impl Fn(&SMatrix<f64, D, D>) -> SMatrix<f64, D, D>,
    ) -> Self {
        let blocks = self.blocks.iter();
        Self {
            blocks: blocks
                .map(|(pair, block)| (*pair, replaced(block)))
                .collect(),
        }
    }

    /// Collects blocks between the given particles, addressed by their indices.
    pub(crate) fn between<'a>(&'a mut self, particles: &'a [Particle<D>]) -> Between<'a, D> {
        Between {
            table: Table::of(particles),
            particles,
            blocks: self,
        }
    }

    /// Returns the sum. Blocks that are zero to rounding are omitted.
    pub fn sum(self, crystal: &Crystal<D>) -> BlochSum<D> {
        let largest = self.blocks.values().map(|b| b.amax()).fold(0.0, f64::max);
        let is_zero = |entry: &f64| entry.abs() <= 1e-15 * largest;
        let blocks = self.blocks.into_iter();
        BlochSum::of_blocks(
            crystal,
            blocks
                .filter(|(_, block)| !block.iter().all(is_zero))
                .map(|((from, to), block)| (from, to, block)),
        )
    }
}

/// Blocks between all pairs of some particles.
///
/// Many pairs have the same difference of cells. Their sums are collected in a table of differences if it is not much larger than the number of
/// pairs.
pub(crate) struct Between<'a, const D: usize> {
    particles: &'a [Particle<D>],
    table: Option<Table<D>>,
    blocks: &'a mut BlochBlocks<D>,
}

impl<const D: usize> Between<'_, D> {
    /// Adds to the block between two of the particles.
    pub(crate) fn add(&mut self, from: usize, to: usize, block: &SMatrix<f64, D, D>) {
        match &mut self.table {
            Some(table) => table.sums[table.rows[from] + table.columns[to]] += block,
            None if block.iter().all(|entry| *entry == 0.0) => {}
            None => {
                let [from, to] = [from, to].each(|n| &self.particles[n]);
                self.blocks.add(from, to, block);
            }
        }
    }

    /// Adds the collected blocks to the sum.
    pub(crate) fn finish(mut self) {
        let Some(table) = self.table.take() else {
            return;
        };
        let sums = table.sums.iter().enumerate();
        let blocks = sums.filter(|(_, block)| block.iter().any(|entry| *entry != 0.0));
        if self.blocks.blocks.is_empty() {
            // The table has the order of the collection: no search for each block is needed.
            let pair = |(n, block): (usize, &SMatrix<f64, D, D>)| {
                let (from, to) = table.pair(n);
                ((from.site, to), *block)
            };
            self.blocks.blocks = blocks.map(pair).collect();
            return;
        }
        for (n, block) in blocks {
            let (from, to) = table.pair(n);
            self.blocks.add(&from, &to, block);
        }
    }
}

/// Sums of blocks, indexed by the sites of two particles and the difference of their cells.
struct Table<const D: usize> {
    sums: Vec<SMatrix<f64, D, D>>,
    /// Contribution of a particle to the index of a sum, as first (`rows`) and as second particle (`columns`).
    rows: Vec<usize>,
    columns: Vec<usize>,
    sites: usize,
    /// Largest difference of cells along each axis.
    span: [i32; D],
}

/// Maximum number of table entries per pair of particles; it limits the memory of a table.
const TABLE_ENTRIES_PER_PAIR: usize = 4;

impl<const D: usize> Table<D> {
    /// Creates the table; `None` if it would be much larger than the number of pairs.
    fn of(particles: &[Particle<D>]) -> Option<Self> {
        let along = |axis: usize| particles.iter().map(move |particle| particle.cell[axis]);
        let [low, high] = [i32::min, i32::max]
            .map(|of| -> [i32; D] { array_of(|axis| along(axis).reduce(of).unwrap_or(0)) });
        let span: [i32; D] = array_of(|axis| high[axis] - low[axis]);
        let sites = particles.iter().map(|p| p.site + 1).max().unwrap_or(0);
        let widths = span.map(|span| 2 * span as usize + 1);
        let size = widths
            .iter()
            .try_fold(sites * sites, |size, width| size.checked_mul(*width));
        let size = size.filter(|size| *size <= TABLE_ENTRIES_PER_PAIR * particles.len().pow(2))?;
        // Index by the site of the first particle, the site of the second, and the difference of cells counted from the lowest.
        let number = |site: usize, place: [usize; D]| {
            let places = place.iter().zip(&widths);
            places.fold(site, |number, (n, width)| number * width + n)
        };
        let row =
            |p: &Particle<D>| number(p.site * sites, array_of(|i| (high[i] - p.cell[i]) as usize));
        let column = |p: &Particle<D>| number(p.site, array_of(|i| (p.cell[i] - low[i]) as usize));
        Some(Self {
            sums: vec![SMatrix::zeros(); size],
            rows: particles.iter().map(row).collect(),
            columns: particles.iter().map(column).collect(),
            sites,
            span,
        })
    }

    /// Returns the particles of a sum, the first in the cell at the origin.
    fn pair(&self, number: usize) -> (Particle<D>, Particle<D>) {
        let mut rest = number;
        let mut cell = [0; D];
        for axis in (0..D).rev() {
            let width = 2 * self.span[axis] as usize + 1;
            cell[axis] = (rest % width) as i32 - self.span[axis];
            rest /= width;
        }
        let from = Particle::home(rest / self.sites);
        let to = Particle {
            site: rest % self.sites,
            cell,
        };
        (from, to)
    }
}

impl<const D: usize> Term<D> {
    /// Writes the phase and its derivatives with respect to the wave vector, up to the length of `room`.
    ///
    /// The order is: phase, first derivatives, second derivatives with respect to `a` and `b <= a`.
    fn derivatives(&self, phase: Complex, room: &mut [Complex]) {
        let first = (0..D).map(|a| phase * Complex::new(0.0, self.vector[a]));
        let second = (0..D)
            .flat_map(|a| (0..=a).map(move |b| (a, b)))
            .map(|(a, b)| phase * (-self.vector[a] * self.vector[b]));
        let all = std::iter::once(phase).chain(first).chain(second);
        room.iter_mut().zip(all).for_each(|(own, x)| *own = x);
    }
}

impl<const D: usize> BlochSum<D> {
    fn of_blocks(
        crystal: &Crystal<D>,
        blocks: impl Iterator<Item = (usize, Particle<D>, SMatrix<f64, D, D>)>,
    ) -> Self {
        let position = |particle: &Particle<D>| crystal.position(particle);
        let blocks: Vec<_> = blocks.collect();
        let mut numbers: Vec<[i32; D]> = blocks.iter().map(|(_, to, _)| to.cell).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let home = Particle::home(0);
        let origin = position(&home);
        let cells = numbers.iter();
        let cells = cells.map(|cell| (*cell, position(&home.moved(cell)) - origin));
        let cells: Vec<_> = cells.collect();
        let terms = blocks.into_iter().map(|(from, to, block)| Term {
            from,
            to,
            cell: numbers.partition_point(|cell| *cell < to.cell),
            vector: position(&to) - position(&Particle::home(from)),
            block,
        });
        let terms: Vec<Term<D>> = terms.collect();
        let home = |site: usize| position(&Particle::home(site));
        let primitive = array_of(|axis| {
            let step = array_of(|i| i32::from(i == axis));
            position(&Particle::home(0).moved(&step)) - home(0)
        });
        let coordinates = cells.iter().flat_map(|(cell, _)| cell);
        let reach = coordinates.map(|n| n.unsigned_abs()).max().unwrap_or(0) as usize;
        let count = crystal.sites().len();
        Self {
            sites: (0..count).map(|n| home(n) - home(0)).collect(),
            cells,
            primitive,
            reach,
            magnitude: magnitude(&terms),
            terms,
        }
    }

    /// Primitive vectors of the lattice.
    pub(super) fn primitive(&self) -> &[SVector<f64, D>; D] {
        &self.primitive
    }

    /// Number of rows, `D n`.
    pub fn size(&self) -> usize {
        D * self.sites.len()
    }

    fn phases(&self, k: &SVector<f64, D>) -> Phases {
        let phase = |vector: &SVector<f64, D>| {
            let (sine, cosine) = k.dot(vector).sin_cos();
            Complex::new(cosine, sine)
        };
        Phases {
            sites: self.sites.iter().map(phase).collect(),
            cells: self.cell_phases(phase),
        }
    }

    /// Phases of the cells, as products of powers unless the basis is so oblique that the powers outnumber the cells.
    fn cell_phases(&self, phase: impl Fn(&SVector<f64, D>) -> Complex) -> Vec<Complex> {
        let cells = self.cells.iter();
        if D * self.reach > self.cells.len() {
            return cells.map(|(_, vector)| phase(vector)).collect();
        }
        let powers = Powers::new(self.primitive.each_ref().map(&phase), self.reach);
        let one = Complex::new(1.0, 0.0);
        cells.map(|(cell, _)| powers.turned(one, cell)).collect()
    }

    /// Iterates over the blocks: the site of the row, the particle of the column, and the block.
    pub fn blocks(&self) -> impl Iterator<Item = (usize, &Particle<D>, &SMatrix<f64, D, D>)> {
        self.terms
            .iter()
            .map(|term| (term.from, &term.to, &term.block))
    }

    /// Returns the sum divided by a number.
    pub(super) fn over(&self, unit: f64) -> Self {
        let mut scaled = self.clone();
        for term in &mut scaled.terms {
            term.block /= unit;
        }
        scaled.magnitude = magnitude(&scaled.terms);
        scaled
    }

    /// Returns the sum in lattice coordinates of another basis. `inverse` maps the present lattice coordinates to the new coordinates and has integer
    /// entries.
    pub(super) fn relabeled(&self, inverse: &SMatrix<f64, D, D>, crystal: &Crystal<D>) -> Self {
        let blocks = self.terms.iter().map(|term| {
            let cell = inverse * SVector::from(term.to.cell.map(f64::from));
            let to = Particle {
                site: term.to.site,
                cell: array_of(|i| cell[i].round() as i32),
            };
            (term.from, to, term.block)
        });
        Self::of_blocks(crystal, blocks)
    }

    /// Evaluates the sum `S(k)` at a wave vector.
    pub fn at(&self, k: &SVector<f64, D>) -> DMatrix<Complex> {
        let phases = self.phases(k);
        self.summed(|term| phases.of(term))
    }

    /// Taylor coefficient of order `p` of `S(t n)` in `t` at zero: `sum S(R) (i n.R)^p / p!`, for `p` up to two.
    pub(super) fn taylor(&self, direction: &SVector<f64, D>, order: usize) -> DMatrix<Complex> {
        self.summed(|term| {
            let phase = Complex::new(0.0, direction.dot(&term.vector));
            match order {
                0 => Complex::new(1.0, 0.0),
                1 => phase,
                _ => phase * phase * 0.5,
            }
        })
    }

    /// `S(k)` with its derivatives with respect to the components of the wave vector.
    pub(super) fn expansion_at(&self, k: &SVector<f64, D>) -> MatrixExpansion<D> {
        let parts = 1 + D + D * (D + 1) / 2;
        let phases = self.phases(k);
        let mut sums = self.sums(parts, |term, factors| {
            term.derivatives(phases.of(term), factors);
        });
        MatrixExpansion::from_parts(|indices| {
            std::mem::take(match *indices {
                [] => &mut sums[0],
                [a] => &mut sums[1 + a],
                [a, b, ..] => &mut sums[1 + D + a * (a + 1) / 2 + b],
            })
        })
    }

    fn summed(&self, factor: impl Fn(&Term<D>) -> Complex) -> DMatrix<Complex> {
        checkpoint();
        let mut sum = DMatrix::<Complex>::zeros(self.size(), self.size());
        for term in &self.terms {
            let factor = factor(term);
            let mut entries = sum.fixed_view_mut::<D, D>(D * term.from, D * term.to.site);
            entries.zip_apply(&term.block, |entry, x| *entry += factor * x);
        }
        sum
    }

    /// Sums of the blocks multiplied by each of `count` factors.
    fn sums(
        &self,
        count: usize,
        set_factors: impl Fn(&Term<D>, &mut [Complex]),
    ) -> Vec<DMatrix<Complex>> {
        checkpoint();
        let size = self.size();
        let mut sums = vec![DMatrix::<Complex>::zeros(size, size); count];
        let mut factors = vec![Complex::default(); count];
        for term in &self.terms {
            set_factors(term, &mut factors);
            for (sum, factor) in sums.iter_mut().zip(&factors) {
                for j in 0..D {
                    let start = (D * term.to.site + j) * size + D * term.from;
                    let entries = &mut sum.as_mut_slice()[start..start + D];
                    for (entry, x) in entries.iter_mut().zip(term.block.column(j).iter()) {
                        *entry += factor * x;
                    }
                }
            }
        }
        sums
    }

    /// Returns true if `S(k)` is Hermitian for every wave vector, to rounding.
    pub fn is_hermitian(&self) -> bool {
        let tolerance = 1e-10 * self.magnitude();
        let zero = SMatrix::zeros();
        let mut blocks: Vec<&Term<D>> = self.terms.iter().collect();
        blocks.sort_unstable_by_key(|term| (term.from, term.to));
        self.terms.iter().all(|term| {
            let opposite = Particle {
                site: term.from,
                cell: term.to.cell.each(|n| -n),
            };
            let place =
                blocks.binary_search_by_key(&(term.to.site, opposite), |own| (own.from, own.to));
            let other = place.map_or(&zero, |place| &blocks[place].block);
            (term.block - other.transpose()).amax() <= tolerance
        })
    }

    /// Largest lattice coordinate of a vector, in magnitude.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// Sum over the blocks of the largest entry of each; rounding errors are a few [`f64::EPSILON`] of it.
    pub fn magnitude(&self) -> f64 {
        self.magnitude
    }

    /// Sums over the particles of the columns, one for each site of the rows: `S(0)` applied to a rigid translation.
    pub fn row_sums(&self) -> Vec<SMatrix<f64, D, D>> {
        let mut sums = vec![SMatrix::zeros(); self.sites.len()];
        for term in &self.terms {
            sums[term.from] += term.block;
        }
        sums
    }
}

fn magnitude<const D: usize>(terms: &[Term<D>]) -> f64 {
    terms.iter().map(|term| term.block.amax()).sum()
}
