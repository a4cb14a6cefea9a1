//! Sums over pairs of particles with the phases of waves, on boxes of wave vectors.

use super::cell::Cell;
use super::jet::{
    FILLED, Jet, MatrixJet, bend, derivatives, filled, mixed, monomials, norm_of, parts, products,
    seconds, slope, third, thirds,
};
use crate::algebra::{Complex, Each, array_of};
use crate::bloch::powers::Powers;
use crate::bloch::{BlochSum, DynamicalMatrix};
use crate::lattice::{Crystal, Fractional, Particle, Symmetry};
use nalgebra::{DMatrix, DMatrixViewMut, SMatrix, SVector};
use pulp::{Arch, NullaryFnOnce};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f64::consts::TAU;

/// Block of a pair of particles; half of the block if both particles coincide.
#[derive(Clone, Debug)]
struct Bond<const D: usize> {
    from: usize,
    to: usize,
    cell: [i32; D],
    /// Products `b_i . R` for the reciprocal vectors.
    along: [f64; D],
    block: SMatrix<f64, D, D>,
}

/// Maximum number of different entries of a block and its adjoint: real and imaginary ones.
const fn most_entries<const D: usize>() -> usize {
    2 * D * D
}

/// Rounding error of the blocks, relative to the sum of their norms. Smaller violations of a symmetry are ignored.
const BLOCK_ROUNDING: f64 = 1e-13;

impl<const D: usize> Bond<D> {
    fn times(&self, factor: f64) -> Self {
        Self {
            block: self.block * factor,
            ..self.clone()
        }
    }

    /// Block of the reversed pair.
    fn adjoint(&self) -> Self {
        Self {
            from: self.to,
            to: self.from,
            cell: self.cell.each(|n| -n),
            along: self.along.each(|x| -x),
            block: self.block.transpose(),
        }
    }

    fn is_of_one_site(&self) -> bool {
        self.from == self.to
    }

    /// Number of different entries of the block and its adjoint, given this number for a block of one site.
    fn entries(&self, of_one_site: usize) -> usize {
        match self.is_of_one_site() {
            true => of_one_site,
            false => most_entries::<D>(),
        }
    }

    /// Number of entries that are multiplied by the cosine of the phase.
    fn with_cosine(&self) -> usize {
        match self.is_of_one_site() {
            true => D * (D + 1) / 2,
            false => D * D,
        }
    }

    /// Factors of the cosine and of the sine of the phase.
    ///
    /// For one site, `B exp(i x) + B^T exp(-i x)` has a symmetric real and an antisymmetric imaginary part. For two sites, it is `B exp(i x)`.
    fn separated(&self) -> Vec<f64> {
        let block = &self.block;
        if !self.is_of_one_site() {
            return block.iter().chain(block.iter()).copied().collect();
        }
        let sums = mixed::<D>().map(|[i, j]| block[(i, j)] + block[(j, i)]);
        let diagonal = (0..D).map(|i| 2.0 * block[(i, i)]);
        diagonal.chain(sums).chain(self.skew()).collect()
    }

    /// Twice the antisymmetric part.
    fn skew(&self) -> impl Iterator<Item = f64> {
        mixed::<D>().map(|[i, j]| self.block[(i, j)] - self.block[(j, i)])
    }
}

/// Hermitian part of a sum of blocks with phases `exp(i k.R)`.
#[derive(Clone, Debug)]
pub(super) struct PhaseSum<const D: usize> {
    /// One block of each adjoint pair, sorted by sites and cell.
    bonds: Vec<Bond<D>>,
    /// Norms of the blocks.
    norms: Vec<f64>,
    sites: usize,
    /// Number of entries of a block of one site; without imaginary entries if all such blocks are symmetric.
    entries_of_one_site: usize,
    /// Powers of the components of the vector of each pair, up to the fourth order: derivatives of its phase.
    powers: Vec<f64>,
    /// Factors of the cosine and of the sine of the phase of each pair.
    entries: Vec<f64>,
    /// Largest lattice coordinate of a cell.
    reach: usize,
    /// Products `b_i . r` for the vectors from one site to another.
    offsets: Vec<[f64; D]>,
    /// Bounds of the second derivatives with respect to each component.
    bends: [f64; D],
}

/// Signs of the derivatives of `exp(i x)`, relative to powers of `i`: real parts of even orders, imaginary parts of odd orders.
const fn signs<const D: usize>() -> [[f64; FILLED]; 2] {
    let mut signs = [[0.0; FILLED]; 2];
    let derivatives = derivatives::<D>();
    let mut n = 0;
    while n < FILLED {
        let order = derivatives[n].order;
        let sign = if order == 1 || order == 2 { -1.0 } else { 1.0 };
        signs[order % 2][n] = sign;
        n += 1;
    }
    signs
}

impl<const D: usize> PhaseSum<D> {
    /// Builds the sum of a system: its blocks divided by the square roots of the masses and by `unit`.
    pub(super) fn of_system(
        sum: &BlochSum<D>,
        crystal: &Crystal<D>,
        masses: &[f64],
        unit: f64,
    ) -> Self {
        let reciprocal = crystal.lattice().reciprocal();
        let bond = |(from, to, block): (usize, &Particle<D>, &SMatrix<f64, D, D>)| {
            let vector = crystal.position(to) - crystal.position(&Particle::home(from));
            let block = block / (unit * (masses[from] * masses[to.site]).sqrt());
            Bond {
                from,
                to: to.site,
                cell: to.cell,
                along: array_of(|i| reciprocal.column(i).dot(&vector)),
                block,
            }
        };
        Self::new(sum.blocks().map(bond), masses.len())
    }

    /// Builds the sum from the force constants of a periodic matrix, divided by `unit`.
    pub(super) fn of_matrix(matrix: &DynamicalMatrix<D>, unit: f64) -> Option<Self> {
        let constants = matrix.force_constants()?;
        let bonds = constants.iter().map(|(cell, block)| {
            let block = block / unit;
            Bond {
                from: 0,
                to: 0,
                cell: *cell,
                along: cell.each(|n| TAU * f64::from(n)),
                block,
            }
        });
        Some(Self::new(bonds, 1))
    }

    /// Builds the Hermitian part: the mean of each block and the adjoint of its counterpart.
    fn new(bonds: impl Iterator<Item = Bond<D>>, sites: usize) -> Self {
        let mut means: BTreeMap<_, Bond<D>> = BTreeMap::new();
        for bond in bonds {
            for own in [bond.times(0.5), bond.adjoint().times(0.5)] {
                match means.entry((own.from, own.to, own.cell)) {
                    Entry::Occupied(mut entry) => entry.get_mut().block += own.block,
                    Entry::Vacant(entry) => {
                        entry.insert(own);
                    }
                }
            }
        }
        let bonds: Vec<Bond<D>> = means.into_values().filter_map(halved).collect();
        let norms: Vec<f64> = bonds.iter().map(|bond| bond.block.norm()).collect();
        let of_one_site = || bonds.iter().filter(|bond| bond.is_of_one_site());
        let skew: f64 = of_one_site().flat_map(Bond::skew).map(f64::abs).sum();
        let entries_of_one_site = match skew <= BLOCK_ROUNDING * norms.iter().sum::<f64>() {
            true => D * (D + 1) / 2,
            false => D * D,
        };
        let [mut powers, mut entries] = [Vec::new(), Vec::new()];
        let (mut bends, mut offsets) = ([0.0; D], vec![[0.0; D]; sites * sites]);
        for (bond, norm) in bonds.iter().zip(&norms) {
            let r = bond.along;
            powers.extend_from_slice(&products(&r)[..filled::<D>()]);
            let count = bond.entries(entries_of_one_site);
            entries.extend(bond.separated().into_iter().take(count));
            (0..D).for_each(|a| bends[a] += norm * r[a] * r[a]);
            offsets[bond.from * sites + bond.to] =
                array_of(|a| r[a] - TAU * f64::from(bond.cell[a]));
        }
        let cells = bonds.iter().flat_map(|bond| bond.cell);
        let reach = cells.map(|n| n.unsigned_abs() as usize).max().unwrap_or(0);
        Self {
            norms,
            bonds,
            sites,
            entries_of_one_site,
            powers,
            entries,
            reach,
            offsets,
            bends,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.bonds.len()
    }

    /// Returns true if a symmetry of the lattice, with a permutation of the sites, leaves all blocks unchanged: `B(R r) = R B(r) R^T`.
    pub(super) fn has(
        &self,
        symmetry: &Symmetry<D>,
        places: &[Fractional<D>],
        exchanged: &[usize],
    ) -> bool {
        let equal = BLOCK_ROUNDING * self.norms.iter().sum::<f64>();
        self.bonds.iter().zip(&self.norms).all(|(bond, norm)| {
            let [from, to] = [bond.from, bond.to].each(|site| exchanged[site]);
            let vector = symmetry.of_place(&(SVector::from(bond.along) / TAU));
            let cell = vector - (places[to] - places[from]);
            let turned = symmetry.map * bond.block * symmetry.map.transpose();
            match self.block(from, to, &array_of(|a| cell[a].round() as i32)) {
                Some(block) => (block - turned).norm() <= equal,
                None => *norm <= equal,
            }
        })
    }

    /// Block from one site to another in a cell, which may be stored as its adjoint.
    fn block(&self, from: usize, to: usize, cell: &[i32; D]) -> Option<SMatrix<f64, D, D>> {
        let kept = |from: usize, to: usize, cell: [i32; D]| {
            let key = (from, to, cell);
            let place = self
                .bonds
                .binary_search_by_key(&key, |bond| (bond.from, bond.to, bond.cell));
            place.ok().map(|place| self.bonds[place].block)
        };
        let back = || kept(to, from, cell.each(|n| -n)).map(|block| block.transpose());
        kept(from, to, *cell).or_else(back)
    }

    /// The sum at `k = 0`, its first derivatives there divided by `i`, and the sizes of their terms.
    pub(super) fn moments(&self) -> (DMatrix<f64>, Vec<DMatrix<f64>>, [f64; 2]) {
        let n = D * self.sites;
        let mut sum = DMatrix::<f64>::zeros(n, n);
        let mut moments = vec![sum.clone(); D];
        let mut sizes = [0.0; 2];
        for (bond, norm) in self.bonds.iter().zip(&self.norms) {
            let add = |matrix: &mut DMatrix<f64>, factor: f64, back: f64| {
                for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                    let (row, column) = (D * bond.from + i, D * bond.to + j);
                    matrix[(row, column)] += factor * bond.block[(i, j)];
                    matrix[(column, row)] += back * bond.block[(i, j)];
                }
            };
            add(&mut sum, 1.0, 1.0);
            sizes[0] += 2.0 * norm;
            for (moment, along) in moments.iter_mut().zip(bond.along) {
                add(moment, along, -along);
                sizes[1] += 2.0 * norm * along.abs();
            }
        }
        (sum, moments, sizes)
    }

    /// Polynomial of the sum on a box of the zone.
    pub(super) fn in_zone(&self, cell: &Cell<D>, bends: &mut [f64; D]) -> MatrixJet<D> {
        let sums = Arch::new().dispatch(InZone(self, cell));
        for a in 0..D {
            bends[a] += 0.5 * self.bends[a] * cell.half[a] * cell.half[a];
        }
        self.jet(&sums, &cell.half, |bond, _| {
            let spread: f64 = (0..D).map(|a| cell.half[a] * bond.along[a].abs()).sum();
            spread.powi(5) / 120.0
        })
    }

    /// Polynomial of the sum on a box of a cone, with the phases without their first `m` terms, divided by `t^m`.
    pub(super) fn in_cone(
        &self,
        cell: &Cell<D>,
        cone: usize,
        m: usize,
        bends: &mut [f64; D],
    ) -> MatrixJet<D> {
        let sums = Arch::new().dispatch(InCone(self, cell, cone, m));
        // Sums for different `m` are added: only the variable with the largest contribution matters.
        self.jet(&sums, &cell.half, |bond, norm| {
            let (rest, own) = cell.cone_rest(cone, m, &bond.along);
            (0..D).for_each(|a| bends[a] += norm * own[a]);
            rest
        })
    }

    /// Taylor polynomial about the center of a box. Its remainder is bounded by the norms of the fourth derivatives and by the remainders of the
    /// phases beyond them.
    fn jet(
        &self,
        sums: &[f64],
        half: &[f64; D],
        mut beyond: impl FnMut(&Bond<D>, f64) -> f64,
    ) -> MatrixJet<D> {
        let n = D * self.sites;
        let mut jet = MatrixJet::zeros(n, n);
        for part in 0..parts::<D>() {
            self.assemble(sums, part, &mut jet.parts.part_mut(part));
        }
        let mut scratch = DMatrix::zeros(n, n);
        let monomials = monomials(half).into_iter().enumerate().take(filled::<D>());
        for (derivative, monomial) in monomials.skip(parts::<D>()) {
            if monomial > 0.0 {
                self.assemble(sums, derivative, &mut scratch.as_view_mut());
                jet.rest += monomial * norm_of(&scratch.as_view());
            }
        }
        let mut rests = vec![0.0; self.sites];
        for (bond, norm) in self.bonds.iter().zip(&self.norms) {
            let most = norm * beyond(bond, *norm);
            rests[bond.from] += most;
            rests[bond.to] += most;
        }
        // The largest row sum bounds the norm of a Hermitian matrix.
        jet.rest += rests.into_iter().fold(0.0, f64::max);
        jet
    }

    /// Derivatives at the center of a box of the zone.
    #[inline(always)]
    fn derivatives_in_zone(&self, cell: &Cell<D>) -> Vec<f64> {
        let [even, odd] = const { signs::<D>() };
        let turn = |angle: f64| {
            let (sine, cosine) = angle.sin_cos();
            Complex::new(cosine, sine)
        };
        let powers = Powers::new(cell.middle.each(|x| turn(TAU * x)), self.reach);
        let angle = |r: &[f64; D]| (0..D).map(|a| cell.middle[a] * r[a]).sum();
        let starts: Vec<Complex> = self.offsets.iter().map(|r| turn(angle(r))).collect();
        self.summed(|bond, products| {
            let Complex { re, im } = powers.turned(starts[self.pair(bond)], &bond.cell);
            let mut phase = [[0.0; FILLED]; 2];
            for n in 0..filled::<D>() {
                phase[0][n] = products[n] * (even[n] * re + odd[n] * im);
                phase[1][n] = products[n] * (even[n] * im - odd[n] * re);
            }
            phase
        })
    }

    /// Derivatives at the center of a box of a cone.
    #[inline(always)]
    fn derivatives_in_cone(&self, cell: &Cell<D>, cone: usize, m: usize) -> Vec<f64> {
        self.summed(|bond, _| {
            let own = cell.cone_derivatives(cone, m, &bond.along);
            [array_of(|n| own[n].re), array_of(|n| own[n].im)]
        })
    }

    fn pair(&self, bond: &Bond<D>) -> usize {
        bond.from * self.sites + bond.to
    }

    /// Sums over all pairs of their entries times the derivatives of the real and imaginary parts of a phase, for each pair of sites. The function
    /// `phase` also receives the products of the components of the vector.
    #[inline(always)]
    fn summed(&self, phase: impl Fn(&Bond<D>, &[f64]) -> [[f64; FILLED]; 2]) -> Vec<f64> {
        let each = filled::<D>();
        let mut sums = vec![0.0; self.sites * self.sites * most_entries::<D>() * each];
        let mut coefficients = &self.entries[..];
        for (bond, products) in self.bonds.iter().zip(self.powers.chunks_exact(each)) {
            let phase = phase(bond, products);
            let own = &mut sums[self.pair(bond) * most_entries::<D>() * each..];
            let count = bond.entries(self.entries_of_one_site);
            for entry in 0..count {
                let phase = &phase[usize::from(entry >= bond.with_cosine())];
                let sum = &mut own[entry * each..(entry + 1) * each];
                for n in 0..each {
                    sum[n] += coefficients[entry] * phase[n];
                }
            }
            coefficients = &coefficients[count..];
        }
        sums
    }

    /// Hermitian matrix of one derivative.
    fn assemble(&self, sums: &[f64], derivative: usize, matrix: &mut DMatrixViewMut<'_, Complex>) {
        let value = |from: usize, to: usize, entry: usize| {
            let pair = from * self.sites + to;
            sums[(pair * most_entries::<D>() + entry) * filled::<D>() + derivative]
        };
        for site in 0..self.sites {
            let real = |entry| Complex::new(value(site, site, entry), 0.0);
            (0..D).for_each(|i| matrix[(D * site + i, D * site + i)] = real(i));
            for (number, [i, j]) in mixed::<D>().enumerate() {
                let imaginary = value(site, site, D * (D + 1) / 2 + number);
                let place = (D * site + i, D * site + j);
                matrix[place] = real(D + number) + Complex::new(0.0, imaginary);
                matrix[(place.1, place.0)] = matrix[place].conj();
            }
            for to in site + 1..self.sites {
                for entry in 0..D * D {
                    let place = (D * site + entry % D, D * to + entry / D);
                    let imaginary = value(site, to, D * D + entry);
                    matrix[place] = Complex::new(value(site, to, entry), imaginary);
                    matrix[(place.1, place.0)] = matrix[place].conj();
                }
            }
        }
    }
}

/// Vectorized evaluation in the zone for the instruction set of the machine. It is a struct because a closure would not be inlined.
struct InZone<'a, const D: usize>(&'a PhaseSum<D>, &'a Cell<D>);

impl<const D: usize> NullaryFnOnce for InZone<'_, D> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        self.0.derivatives_in_zone(self.1)
    }
}

/// Vectorized evaluation in a cone for the instruction set of the machine.
struct InCone<'a, const D: usize>(&'a PhaseSum<D>, &'a Cell<D>, usize, usize);

impl<const D: usize> NullaryFnOnce for InCone<'_, D> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        self.0.derivatives_in_cone(self.1, self.2, self.3)
    }
}

/// The lattice Laplacian: components of its vectors along the reciprocal vectors, and their weights.
#[derive(Clone, Debug)]
pub(super) struct Laplacian<const D: usize>(pub(super) Vec<([f64; D], f64)>);

impl<const D: usize> Laplacian<D> {
    /// Returns true if a symmetry of the lattice leaves it unchanged.
    pub(super) fn has(&self, symmetry: &Symmetry<D>) -> bool {
        self.0.iter().all(|(along, weight)| {
            let moved = symmetry.of_place(&SVector::from(*along));
            self.0.iter().any(|(other, own)| {
                let other = SVector::from(*other);
                let apart = (moved - other).amax().min((moved + other).amax());
                apart <= BLOCK_ROUNDING * other.amax()
                    && (own - weight).abs() <= BLOCK_ROUNDING * weight
            })
        })
    }

    /// Polynomial of `|k|_h^2` on a box of the zone.
    pub(super) fn in_zone(&self, cell: &Cell<D>) -> Jet<D> {
        let mut jet = Jet::ZERO;
        for (along, weight) in &self.0 {
            let (mut phase, mut spread) = (0.0, 0.0);
            for a in 0..D {
                phase += cell.middle[a] * along[a];
                spread += cell.half[a] * along[a].abs();
            }
            // Term `2 w (1 - cos(k.a))` of a vector `a`.
            let (sine, cosine) = phase.sin_cos();
            let twice = 2.0 * weight;
            jet.parts[0] += twice * (1.0 - cosine);
            for a in 0..D {
                jet.parts[slope(a)] += twice * sine * along[a];
            }
            for [a, b] in seconds::<D>() {
                jet.parts[bend::<D>(a, b)] += twice * cosine * along[a] * along[b];
            }
            for [a, b, c] in thirds::<D>() {
                jet.parts[third::<D>(a, b, c)] -= twice * sine * along[a] * along[b] * along[c];
            }
            jet.rest += twice * spread.powi(4) / 24.0;
        }
        jet
    }

    /// Polynomials of `|k|_h^2` over `t^2`, over `t`, and itself, on a box of a cone.
    pub(super) fn in_cone(&self, cell: &Cell<D>, cone: usize) -> [Jet<D>; 3] {
        let (mut over_square, monomials) = (Jet::ZERO, monomials(&cell.half));
        for (along, weight) in &self.0 {
            // Term `2 (1 - cos t p) / t^2`, with the weight of the vector.
            let own = cell.cone_derivatives(cone, 2, along);
            for n in 0..parts::<D>() {
                over_square.parts[n] -= 2.0 * weight * own[n].re;
            }
            let fourth: f64 = (parts::<D>()..filled::<D>())
                .map(|n| monomials[n] * own[n].re.abs())
                .sum();
            let (beyond, _) = cell.cone_rest(cone, 2, along);
            over_square.rest += 2.0 * weight * (fourth + beyond);
        }
        let t = Jet::variable(0, cell.middle[0]);
        let once = over_square.times(&t, &cell.half);
        [over_square, once, once.times(&t, &cell.half)]
    }
}

/// One block of each adjoint pair; half of a self-adjoint block.
fn halved<const D: usize>(bond: Bond<D>) -> Option<Bond<D>> {
    let leading = bond.along.iter().find(|x| x.abs() > 1e-6);
    let side = match bond.from.cmp(&bond.to) {
        std::cmp::Ordering::Equal => leading.map_or(0.0, |x| x.signum()),
        std::cmp::Ordering::Less => 1.0,
        std::cmp::Ordering::Greater => -1.0,
    };
    match side {
        0.0 => Some(bond.times(0.5)),
        side => (side > 0.0).then_some(bond),
    }
}

#[cfg(test)]
mod tests {
    use super::{Bond, Laplacian, PhaseSum};
    use crate::algebra::Complex;
    use crate::bloch::bound::cell::{Cell, Chart};
    use crate::bloch::bound::jet::{Jet, MatrixJet, bend, slope, third};
    use nalgebra::{DMatrix, SMatrix};
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// Hermitian part at a wave vector, with the phases without their first terms.
    fn at<const D: usize>(
        bonds: &[Bond<D>],
        sites: usize,
        x: &[f64; D],
        terms: usize,
    ) -> DMatrix<Complex> {
        let mut sum = DMatrix::zeros(D * sites, D * sites);
        for bond in bonds {
            let phase: f64 = (0..D).map(|a| x[a] * bond.along[a]).sum();
            let phase = Complex::new(0.0, phase);
            let taken = [Complex::default(), 1.0.into(), phase + 1.0][terms];
            let phase = phase.exp() - taken;
            for i in 0..D {
                for j in 0..D {
                    let value = phase * (0.5 * bond.block[(i, j)]);
                    let place = (D * bond.from + i, D * bond.to + j);
                    sum[place] += value;
                    sum[(place.1, place.0)] += value.conj();
                }
            }
        }
        sum
    }

    /// Polynomial of a box at one of its points.
    fn polynomial<const D: usize>(parts: impl Fn(usize) -> Complex, u: &[f64; D]) -> Complex {
        let mut sum = parts(0);
        for a in 0..D {
            sum += parts(slope(a)) * u[a];
            for b in 0..D {
                sum += parts(bend::<D>(a, b)) * (0.5 * u[a] * u[b]);
                for c in 0..D {
                    sum += parts(third::<D>(a, b, c)) * (u[a] * u[b] * u[c] / 6.0);
                }
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn remainders_of_the_sums_stay_below_their_bounds(
            entries in proptest::collection::vec(-1.0..1.0f64, 6 * 4),
            along in proptest::collection::vec(-12.0..12.0f64, 6 * 2),
            middle in proptest::array::uniform2(-0.5..0.5f64),
            half in proptest::array::uniform2(1e-3..0.06f64),
            place in proptest::array::uniform2(-1.0..1.0f64),
        ) {
            let bonds: Vec<Bond<2>> = (0..6).map(|n| {
                let block = SMatrix::<f64, 2, 2>::from_column_slice(&entries[4 * n..4 * n + 4]);
                let along = [along[2 * n], along[2 * n + 1]];
                let (from, to) = [(0, 0), (1, 1), (0, 1)][n % 3];
                // The phase of a cell times the phase of an offset, which all pairs of two sites share.
                let offset = if from == to { [0.0; 2] } else { [0.3, -0.7] };
                let cell = [0, 1].map(|a| ((along[a] - offset[a]) / TAU).round() as i32);
                let along = [0, 1].map(|a| offset[a] + TAU * f64::from(cell[a]));
                Bond { from, to, cell, along, block }
            }).collect();
            let sum = PhaseSum::new(bonds.clone().into_iter(), 2);
            let cell = Cell { chart: Chart::Zone, middle, half };
            let MatrixJet { parts, rest } = sum.in_zone(&cell, &mut [0.0; 2]);
            let u = [place[0] * half[0], place[1] * half[1]];
            let exact = at(&bonds, 2, &[middle[0] + u[0], middle[1] + u[1]], 0);
            let difference = DMatrix::from_fn(4, 4, |i, j| {
                exact[(i, j)] - polynomial(|n| parts.part(n)[(i, j)], &u)
            });
            prop_assert!(difference.norm() <= 2.0 * rest + 1e-12, "{} {rest}", difference.norm());
            let largest = difference.singular_values().max();
            prop_assert!(largest <= rest + 1e-12, "{largest} {rest}");

            for (cone, terms) in [(0, 0), (1, 1), (0, 2), (1, 2)] {
                let middle = [middle[0].abs().max(0.07), middle[1]];
                let cell = Cell { chart: Chart::Cone(cone), middle, half };
                let MatrixJet { parts, rest } = sum.in_cone(&cell, cone, terms, &mut [0.0; 2]);
                let (t, s) = (middle[0] + u[0], middle[1] + u[1]);
                let x = if cone == 0 { [t, t * s] } else { [t * s, t] };
                let exact = at(&bonds, 2, &x, terms) / Complex::new(t.powi(terms as i32), 0.0);
                let difference = DMatrix::from_fn(4, 4, |i, j| {
                    exact[(i, j)] - polynomial(|n| parts.part(n)[(i, j)], &u)
                });
                let largest = difference.singular_values().max();
                prop_assert!(largest <= rest + 1e-11, "{cone} {terms}: {largest} {rest}");
            }

            let own = Laplacian(vec![([6.0, 1.0], 0.7), ([-2.0, 5.0], 1.3)]);
            let Jet { parts, rest } = own.in_zone(&cell);
            let square = |x: [f64; 2]| -> f64 {
                let terms = own.0.iter().map(|(a, w)| 4.0 * w * (0.5 * (x[0] * a[0] + x[1] * a[1])).sin().powi(2));
                terms.sum()
            };
            let exact = square([middle[0] + u[0], middle[1] + u[1]]);
            let expanded = polynomial(|n| Complex::new(parts[n], 0.0), &u).re;
            prop_assert!((exact - expanded).abs() <= rest + 1e-12);
        }
    }
}
