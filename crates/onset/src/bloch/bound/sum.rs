//! Sums over pairs of particles with the phases of waves, on boxes of wave vectors.

use super::cell::Cell;
use super::jet::{Jet, MatrixJet, bend, parts, slope};
use super::squares::pairs;
use crate::algebra::{Complex, Each, array_of};
use crate::bloch::powers::Powers;
use crate::bloch::{BlochSum, DynamicalMatrix};
use crate::lattice::{Crystal, Particle};
use nalgebra::{DMatrix, SMatrix};
use pulp::{Arch, NullaryFnOnce};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f64::consts::TAU;

/// The block of a pair of particles, half of it where that is one particle.
#[derive(Clone, Debug)]
struct Bond<const D: usize> {
    from: usize,
    to: usize,
    cell: [i32; D],
    /// `b_i . R` for the reciprocal vectors.
    along: [f64; D],
    block: SMatrix<f64, D, D>,
}

/// Derivatives up to the third order in three variables.
const MOST: usize = 20;

/// How many different entries a block has with its adjoint: real ones, and imaginary ones.
const fn entry_count<const D: usize>(is_of_one_site: bool) -> usize {
    if is_of_one_site { D * D } else { 2 * D * D }
}

impl<const D: usize> Bond<D> {
    fn times(&self, factor: f64) -> Self {
        Self {
            block: self.block * factor,
            ..self.clone()
        }
    }

    /// The way back.
    fn adjoint(&self) -> Self {
        Self {
            from: self.to,
            to: self.from,
            cell: self.cell.each(|n| -n),
            along: self.along.each(|x| -x),
            block: self.block.transpose(),
        }
    }

    fn norm(&self) -> f64 {
        self.block.norm()
    }

    fn is_of_one_site(&self) -> bool {
        self.from == self.to
    }

    /// How many of the entries are multiplied with the cosine of the phase.
    fn with_cosine(&self) -> usize {
        match self.is_of_one_site() {
            true => D * (D + 1) / 2,
            false => D * D,
        }
    }

    /// What is multiplied with the cosine of the phase, and with the sine: of one site `B exp(i x) + B^T exp(-i x)`, with a
    /// symmetric real and an antisymmetric imaginary part, of two sites `B exp(i x)`.
    fn separated(&self) -> Vec<f64> {
        let block = &self.block;
        if !self.is_of_one_site() {
            return block.iter().chain(block.iter()).copied().collect();
        }
        let sums = pairs::<D>().map(|[i, j]| block[(i, j)] + block[(j, i)]);
        let differences = pairs::<D>().map(|[i, j]| block[(i, j)] - block[(j, i)]);
        let diagonal = (0..D).map(|i| 2.0 * block[(i, i)]);
        diagonal.chain(sums).chain(differences).collect()
    }
}

/// The Hermitian part of a sum of blocks with phases `exp(i k.R)`.
#[derive(Clone, Debug)]
pub(super) struct PhaseSum<const D: usize> {
    /// One of each two that are each other's adjoints.
    bonds: Vec<Bond<D>>,
    /// The norms of their blocks.
    norms: Vec<f64>,
    sites: usize,
    /// Of each pair the powers up to the third order of the components of its vector, which are derivatives of its phase.
    powers: Vec<f64>,
    /// Of each pair what is multiplied with the cosine of its phase, and with the sine.
    entries: Vec<f64>,
    /// The farthest cell.
    reach: usize,
    /// `b_i . r` from one site to another.
    offsets: Vec<[f64; D]>,
    /// How much the second derivatives by each component may do.
    bends: [f64; D],
}

/// The components of derivatives of the third order, with the number of their arrangements.
fn thirds<const D: usize>() -> impl Iterator<Item = ([usize; 3], f64)> {
    let ordered = |a: usize, b: usize, c: usize| match (a == b, b == c) {
        (true, true) => 1.0,
        (false, false) => 6.0,
        _ => 3.0,
    };
    (0..D).flat_map(move |a| {
        (0..=a).flat_map(move |b| (0..=b).map(move |c| ([a, b, c], ordered(a, b, c))))
    })
}

/// Derivatives up to the third order.
const fn derivatives<const D: usize>() -> usize {
    parts::<D>() + D * (D + 1) * (D + 2) / 6
}

/// The order of a derivative.
const fn order<const D: usize>(derivative: usize) -> usize {
    match derivative {
        0 => 0,
        first if first <= D => 1,
        second if second < parts::<D>() => 2,
        _ => 3,
    }
}

impl<const D: usize> PhaseSum<D> {
    /// Of the blocks of a sum, over the square roots of masses, in a unit.
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

    /// Of the force constants of a periodic matrix, in a unit.
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

    /// The Hermitian part of a sum: of each two blocks that would be each other's adjoints their mean.
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
        let [mut powers, mut entries] = [Vec::new(), Vec::new()];
        let (mut bends, mut offsets) = ([0.0; D], vec![[0.0; D]; sites * sites]);
        for bond in &bonds {
            let r = bond.along;
            powers.push(1.0);
            powers.extend(r);
            powers.extend((0..D).flat_map(|a| (0..=a).map(move |b| r[a] * r[b])));
            powers.extend(thirds::<D>().map(|([a, b, c], _)| r[a] * r[b] * r[c]));
            entries.extend(bond.separated());
            (0..D).for_each(|a| bends[a] += bond.norm() * r[a] * r[a]);
            offsets[bond.from * sites + bond.to] =
                array_of(|a| r[a] - TAU * f64::from(bond.cell[a]));
        }
        let cells = bonds.iter().flat_map(|bond| bond.cell);
        let reach = cells.map(|n| n.unsigned_abs() as usize).max().unwrap_or(0);
        Self {
            norms: bonds.iter().map(Bond::norm).collect(),
            bonds,
            sites,
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

    /// The sum at `k = 0` and its derivatives there, over `i`, by the components of the wave vector, with the sizes of their terms.
    pub(super) fn moments(&self) -> (DMatrix<f64>, Vec<DMatrix<f64>>, [f64; 2]) {
        let n = D * self.sites;
        let mut sum = DMatrix::<f64>::zeros(n, n);
        let mut moments = vec![sum.clone(); D];
        let mut sizes = [0.0; 2];
        for bond in &self.bonds {
            let add = |matrix: &mut DMatrix<f64>, factor: f64, back: f64| {
                for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                    let (row, column) = (D * bond.from + i, D * bond.to + j);
                    matrix[(row, column)] += factor * bond.block[(i, j)];
                    matrix[(column, row)] += back * bond.block[(i, j)];
                }
            };
            add(&mut sum, 1.0, 1.0);
            sizes[0] += 2.0 * bond.norm();
            for (moment, along) in moments.iter_mut().zip(bond.along) {
                add(moment, along, -along);
                sizes[1] += 2.0 * bond.norm() * along.abs();
            }
        }
        (sum, moments, sizes)
    }

    /// On a box of the zone. What is left of it is below the sizes of the derivatives of the third order in the middle and of
    /// the terms of the fourth.
    pub(super) fn in_zone(&self, cell: &Cell<D>, bends: &mut [f64; D]) -> MatrixJet<D> {
        let sums = Arch::new().dispatch(InZone(self, cell));
        let mut fourth = vec![0.0; self.sites];
        for (bond, norm) in self.bonds.iter().zip(&self.norms) {
            let spread: f64 = (0..D).map(|a| cell.half[a] * bond.along[a].abs()).sum();
            let most = norm * (spread * spread) * (spread * spread);
            fourth[bond.from] += most;
            fourth[bond.to] += most;
        }
        let third: f64 = thirds::<D>()
            .enumerate()
            .map(|(number, (abc, count))| {
                let size = norm_bound(&self.assembled(&sums, parts::<D>() + number));
                count * size * abc.iter().map(|a| cell.half[*a]).product::<f64>()
            })
            .sum();
        for a in 0..D {
            bends[a] += 0.5 * self.bends[a] * cell.half[a] * cell.half[a];
        }
        MatrixJet {
            parts: (0..parts::<D>())
                .map(|part| self.assembled(&sums, part))
                .collect(),
            rest: third / 6.0 + fourth.into_iter().fold(0.0, f64::max) / 24.0,
        }
    }

    /// The derivatives in the middle of a box, of one entry after the other, for each pair of sites as many as of different ones.
    #[inline(always)]
    fn derivatives_at(&self, cell: &Cell<D>) -> Vec<f64> {
        let each = derivatives::<D>();
        let turn = |angle: f64| {
            let (sine, cosine) = angle.sin_cos();
            Complex::new(cosine, sine)
        };
        let powers = Powers::new(cell.middle.each(|x| turn(TAU * x)), self.reach);
        let angle = |r: &[f64; D]| (0..D).map(|a| cell.middle[a] * r[a]).sum();
        let starts: Vec<Complex> = self.offsets.iter().map(|r| turn(angle(r))).collect();
        let mut sums = vec![0.0; self.sites * self.sites * entry_count::<D>(false) * each];
        let mut coefficients = &self.entries[..];
        for (bond, factors) in self.bonds.iter().zip(self.powers.chunks_exact(each)) {
            let pair = bond.from * self.sites + bond.to;
            let Complex { re, im } = powers.turned(starts[pair], &bond.cell);
            let [mut cosine, mut sine] = [[0.0; MOST]; 2];
            for n in 0..each {
                let order = order::<D>(n);
                cosine[n] = factors[n] * [re, -im, -re, im][order];
                sine[n] = factors[n] * [im, re, -im, -re][order];
            }
            let own = &mut sums[pair * entry_count::<D>(false) * each..];
            let count = entry_count::<D>(bond.is_of_one_site());
            for entry in 0..count {
                let phase = match entry < bond.with_cosine() {
                    true => &cosine,
                    false => &sine,
                };
                let sum = &mut own[entry * each..(entry + 1) * each];
                for n in 0..each {
                    sum[n] += coefficients[entry] * phase[n];
                }
            }
            coefficients = &coefficients[count..];
        }
        sums
    }

    /// The Hermitian matrix of a derivative.
    fn assembled(&self, sums: &[f64], derivative: usize) -> DMatrix<Complex> {
        let n = D * self.sites;
        let mut matrix = DMatrix::zeros(n, n);
        let value = |from: usize, to: usize, entry: usize| {
            let pair = from * self.sites + to;
            sums[(pair * entry_count::<D>(false) + entry) * derivatives::<D>() + derivative]
        };
        for site in 0..self.sites {
            let real = |entry| Complex::new(value(site, site, entry), 0.0);
            (0..D).for_each(|i| matrix[(D * site + i, D * site + i)] = real(i));
            for (number, [i, j]) in pairs::<D>().enumerate() {
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
        matrix
    }

    /// On a box of a cone, as far as they are wanted with what remains of the phases beyond their first `m` terms, over `t^m`.
    pub(super) fn in_cone(
        &self,
        cell: &Cell<D>,
        cone: usize,
        wanted: [bool; 3],
        bends: &mut [f64; D],
    ) -> [MatrixJet<D>; 3] {
        let n = D * self.sites;
        let mut sums = wanted.map(|is_wanted| {
            let size = if is_wanted { n } else { 0 };
            MatrixJet::<D>::zeros(size, size)
        });
        let mut rests = vec![[0.0; 3]; self.sites];
        for (bond, norm) in self.bonds.iter().zip(&self.norms) {
            let jets = cell.cone_jets(cone, &bond.along, wanted);
            let place = (D * bond.from, D * bond.to);
            for (order, sum) in sums
                .iter_mut()
                .enumerate()
                .filter(|(order, _)| wanted[*order])
            {
                let (jet, rest, bent) = &jets[order];
                sum.add(place, &bond.block, jet);
                rests[bond.from][order] += norm * rest;
                rests[bond.to][order] += norm * rest;
                (0..D).for_each(|a| bends[a] += norm * bent[a]);
            }
        }
        for (order, sum) in sums.iter_mut().enumerate() {
            sum.symmetrize();
            // Of Hermitian matrices the sums over the rows bound the norm.
            sum.rest = rests.iter().map(|rest| rest[order]).fold(0.0, f64::max);
        }
        sums
    }
}

/// Work for the widest vectors of the machine. (A closure would not be inlined there.)
struct InZone<'a, const D: usize>(&'a PhaseSum<D>, &'a Cell<D>);

impl<const D: usize> NullaryFnOnce for InZone<'_, D> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        self.0.derivatives_at(self.1)
    }
}

/// The lattice Laplacian: reciprocal components and weights of its vectors.
#[derive(Clone, Debug)]
pub(super) struct Laplacian<const D: usize>(pub(super) Vec<([f64; D], f64)>);

impl<const D: usize> Laplacian<D> {
    /// `|k|_h^2` on a box of the zone.
    pub(super) fn in_zone(&self, cell: &Cell<D>) -> Jet<D> {
        let mut jet = Jet::ZERO;
        for (along, weight) in &self.0 {
            let (mut phase, mut spread) = (0.0, 0.0);
            for a in 0..D {
                phase += cell.middle[a] * along[a];
                spread += cell.half[a] * along[a].abs();
            }
            // 2 w (1 - cos(k.a)).
            let (sine, cosine) = phase.sin_cos();
            let twice = 2.0 * weight;
            jet.parts[0] += twice * (1.0 - cosine);
            for a in 0..D {
                jet.parts[slope(a)] += twice * sine * along[a];
                for b in 0..=a {
                    jet.parts[bend::<D>(a, b)] += twice * cosine * along[a] * along[b];
                }
            }
            jet.rest += twice * (sine.abs() / 6.0 + spread / 24.0) * spread.powi(3);
        }
        jet
    }

    /// `|k|_h^2` over `t^2`, `t` and one on a box of a cone.
    pub(super) fn in_cone(&self, cell: &Cell<D>, cone: usize) -> [Jet<D>; 3] {
        let mut over_square = Jet::ZERO;
        for (along, weight) in &self.0 {
            // 2 (1 - cos t p) / t^2.
            let [_, _, (jet, rest, _)] = cell.cone_jets(cone, along, [false, false, true]);
            for (part, own) in over_square.parts.iter_mut().zip(jet) {
                *part -= 2.0 * weight * own.re;
            }
            over_square.rest += 2.0 * weight * rest;
        }
        let t = Jet::variable(0, cell.middle[0]);
        let once = over_square.times(&t, &cell.half);
        [over_square, once, once.times(&t, &cell.half)]
    }
}

/// A bound of the norm of a Hermitian matrix.
fn norm_bound(matrix: &DMatrix<Complex>) -> f64 {
    let rows = matrix
        .row_iter()
        .map(|row| row.iter().map(|x| x.norm()).sum());
    matrix.norm().min(rows.fold(0.0, f64::max))
}

/// One of each two blocks that are each other's adjoints; half of those that are their own.
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
    use crate::bloch::bound::jet::{Jet, MatrixJet, bend, slope};
    use nalgebra::{DMatrix, SMatrix};
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// The Hermitian part.
    fn at<const D: usize>(bonds: &[Bond<D>], sites: usize, x: &[f64; D]) -> DMatrix<Complex> {
        let mut sum = DMatrix::zeros(D * sites, D * sites);
        for bond in bonds {
            let phase: f64 = (0..D).map(|a| x[a] * bond.along[a]).sum();
            let phase = Complex::new(0.0, phase).exp();
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

    /// The polynomial of a box at a point of it.
    fn polynomial<const D: usize>(parts: impl Fn(usize) -> Complex, u: &[f64; D]) -> Complex {
        let mut sum = parts(0);
        for a in 0..D {
            sum += parts(slope(a)) * u[a];
            for b in 0..D {
                sum += parts(bend::<D>(a, b)) * (0.5 * u[a] * u[b]);
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn sums_stay_within_their_rest(
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
                // The phase of a cell times that of an offset, which all pairs of two sites share.
                let offset = if from == to { [0.0; 2] } else { [0.3, -0.7] };
                let cell = [0, 1].map(|a| ((along[a] - offset[a]) / TAU).round() as i32);
                let along = [0, 1].map(|a| offset[a] + TAU * f64::from(cell[a]));
                Bond { from, to, cell, along, block }
            }).collect();
            let sum = PhaseSum::new(bonds.clone().into_iter(), 2);
            let cell = Cell { chart: Chart::Zone, middle, half };
            let MatrixJet { parts, rest } = sum.in_zone(&cell, &mut [0.0; 2]);
            let u = [place[0] * half[0], place[1] * half[1]];
            let exact = at(&bonds, 2, &[middle[0] + u[0], middle[1] + u[1]]);
            let difference = DMatrix::from_fn(4, 4, |i, j| {
                exact[(i, j)] - polynomial(|n| parts[n][(i, j)], &u)
            });
            prop_assert!(difference.norm() <= 2.0 * rest + 1e-12, "{} {rest}", difference.norm());
            let largest = difference.singular_values().max();
            prop_assert!(largest <= rest + 1e-12, "{largest} {rest}");

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
