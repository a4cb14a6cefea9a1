//! The dynamical matrix as a sum of plane-wave phases.

use super::mirror::MirrorSums;
use super::planar::PlanarRows;
use super::powers::Powers;
use super::short_range::ShortRange;
use crate::algebra::{Complex, Each, array_of, eigenvalues, moderate_unit};
use crate::continuum::Stiffness;
use crate::lattice::{BravaisLattice, Mirror, Reduced, Symmetry};
use nalgebra::{SMatrix, SVector};
use pulp::{Arch, NullaryFnOnce};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// `D(k) = sum_R Phi(R) exp(i k.R)`: force constants per mass between a particle and what is displaced
/// from it by the reference vector `R`.
///
/// `D x D`, units 1/time^2. Hermitian for Lagrangian kernels; real for sets with an inversion center.
#[derive(Clone, Debug)]
pub struct DynamicalMatrix<const D: usize> {
    terms: Vec<Term<D>>,
    /// Primitive vectors of the reference lattice, as columns.
    vectors: SMatrix<f64, D, D>,
    /// Where in its cell a vector ends: the lattice points first, then the places of plane-wave stress points.
    sites: Vec<SVector<f64, D>>,
    /// Largest lattice coordinate of a vector.
    reach: usize,
    /// `D(0) = sum_R Phi(R)`; zero where a translation costs no energy.
    rigid: SMatrix<f64, D, D>,
    /// Whether `Phi(-R) = Phi(R)`, which makes `D` real.
    centrosymmetric: bool,
    /// Whether `Phi(-R) = Phi(R)^T`, which makes `D` Hermitian.
    hermitian: bool,
    /// The force constants by rows, where `D` is planar and real; made when they are first asked for.
    rows: OnceLock<Option<PlanarRows>>,
    /// Rounding error to expect in an entry.
    noise: f64,
}

/// The force constants of `R` and `-R` together.
#[derive(Clone, Debug)]
pub(super) struct Term<const D: usize> {
    /// `R`, in the reference state.
    vector: SVector<f64, D>,
    /// Its cell, `R = cell + site` in lattice coordinates.
    pub(super) cell: [i32; D],
    /// Its place in the cell, an index of `sites`.
    pub(super) site: usize,
    /// `Phi(R) + Phi(-R)`.
    pub(super) even: SMatrix<f64, D, D>,
    /// `Phi(R) - Phi(-R)`.
    odd: SMatrix<f64, D, D>,
}

/// `D(k)` with its derivatives with respect to the components of the wave vector; in real numbers where `D` is real.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expansion<T, const D: usize> {
    /// `D(k)`.
    pub value: SMatrix<T, D, D>,
    /// First derivatives.
    pub gradient: [SMatrix<T, D, D>; D],
    /// Second derivatives.
    pub hessian: [[SMatrix<T, D, D>; D]; D],
}

impl<const D: usize> Expansion<f64, D> {
    fn starting_at(value: SMatrix<f64, D, D>) -> Self {
        Self {
            value,
            gradient: [SMatrix::zeros(); D],
            hessian: [[SMatrix::zeros(); D]; D],
        }
    }

    /// Adds `block` times a function of `k.R`, given with its first two derivatives; second derivatives where the order is two.
    #[inline(always)]
    fn add<const ORDER: usize>(
        &mut self,
        block: &SMatrix<f64, D, D>,
        [value, first, second]: [f64; 3],
        vector: &SVector<f64, D>,
    ) {
        self.value += block * value;
        for a in 0..D {
            self.gradient[a] += block * (first * vector[a]);
            if ORDER < 2 {
                continue;
            }
            for b in 0..=a {
                self.hessian[a][b] += block * (second * vector[a] * vector[b]);
            }
        }
    }

    /// Copies the half of the symmetric second derivatives that is summed to the other one.
    fn finished(mut self) -> Self {
        for a in 0..D {
            for b in 0..a {
                self.hessian[b][a] = self.hessian[a][b];
            }
        }
        self
    }
}

/// A complex matrix from its parts.
fn joined<const D: usize>(
    real: &SMatrix<f64, D, D>,
    imaginary: &SMatrix<f64, D, D>,
) -> SMatrix<Complex, D, D> {
    real.zip_map(imaginary, Complex::new)
}

/// A matrix of force constants, by rows.
pub(super) type Block<const D: usize> = [[f64; D]; D];

/// Collects force constants by lattice vector.
pub(super) struct ForceConstants<const D: usize> {
    /// The basis in whose coordinates the blocks lie.
    basis: Reduced<D>,
    /// Largest lattice coordinate in that basis.
    reach: i32,
    /// What a step along a vector of the given basis is in the array of blocks.
    steps: [i64; D],
    /// Dense blocks for lattice vectors, coordinates in that basis from `-reach` to `reach`.
    blocks: Vec<Block<D>>,
    /// Blocks at other vectors (plane-wave stress points), by rounded lattice coordinates.
    loose: BTreeMap<Vec<i64>, (SVector<f64, D>, SMatrix<f64, D, D>)>,
}

/// Sums of force constants below this fraction of their absolute sum vanish but for rounding.
const ZERO: f64 = 1e-10;
/// Force constants that differ by this multiple of the rounding error of the matrix are images of each other under a symmetry.
const EQUAL: f64 = 64.0;
/// Resolution with which lattice coordinates of loose vectors are told apart.
const LOOSE_RESOLUTION: f64 = 1e6;

impl<const D: usize> ForceConstants<D> {
    /// For lattice vectors with coordinates up to `reach` in a short basis.
    pub(super) fn new(basis: Reduced<D>, reach: i32) -> Self {
        let side = (2 * reach + 1) as usize;
        let own = SVector::<f64, D>::from_fn(|i, _| (side as f64).powi((D - 1 - i) as i32));
        let steps = basis.inverse.transpose() * own;
        Self {
            basis,
            reach,
            steps: array_of(|i| steps[i] as i64),
            blocks: vec![[[0.0; D]; D]; side.pow(D as u32)],
            loose: BTreeMap::new(),
        }
    }

    /// The places of lattice vectors relative to that of zero; places of differences are differences of places.
    pub(super) fn places(&self, cells: &[[i32; D]]) -> Vec<usize> {
        let mut places = Vec::with_capacity(cells.len());
        for cell in cells {
            // Wrapped around below zero, as are sums and differences of places.
            let mut place = 0_i64;
            for i in 0..D {
                place += i64::from(cell[i]) * self.steps[i];
            }
            places.push(place as usize);
        }
        places
    }

    /// The place of the vector zero.
    pub(super) fn middle(&self) -> usize {
        self.blocks.len() / 2
    }

    /// The blocks by place.
    pub(super) fn blocks_mut(&mut self) -> &mut [Block<D>] {
        &mut self.blocks
    }

    /// Adds to the force constant of the lattice vector at a place.
    pub(super) fn add(&mut self, place: usize, block: &Block<D>) {
        let place = self.middle().wrapping_add(place);
        let own = &mut self.blocks[place];
        for i in 0..D {
            for k in 0..D {
                own[i][k] += block[i][k];
            }
        }
    }

    /// Adds to the force constant of a lattice vector.
    pub(super) fn add_to(&mut self, cell: &[i32; D], matrix: &SMatrix<f64, D, D>) {
        let place = self.places(std::slice::from_ref(cell))[0];
        let mut block = [[0.0; D]; D];
        for i in 0..D {
            for k in 0..D {
                block[i][k] = matrix[(i, k)];
            }
        }
        self.add(place, &block);
    }

    /// Adds to the force constant of a vector given by its lattice coordinates.
    pub(super) fn add_loose(&mut self, fractional: SVector<f64, D>, block: &SMatrix<f64, D, D>) {
        let entry = self
            .loose
            .entry(rounded(&fractional))
            .or_insert((fractional, SMatrix::zeros()));
        entry.1 += block;
    }

    /// The sum over all vectors, with `R` and `-R` taken together. Where one of each pair of points that inversion exchanges
    /// has been added, with the weight of both, the odd parts cancel.
    pub(super) fn finish(
        mut self,
        lattice: &BravaisLattice<D>,
        is_inverted: bool,
    ) -> DynamicalMatrix<D> {
        let mut sites = vec![SVector::zeros()];
        let middle = self.blocks.len() / 2;
        let mut sum = PairSum {
            terms: Vec::with_capacity(middle + self.loose.len()),
            rigid: matrix_of(&self.blocks[middle]),
            magnitude: largest(&matrix_of(&self.blocks[middle])),
            is_inverted,
        };
        let mut cell = [0; D];
        for index in middle + 1..self.blocks.len() {
            self.advance(&mut cell);
            let (forward, backward) = (
                &self.blocks[index],
                &self.blocks[self.blocks.len() - 1 - index],
            );
            let is_zero = |block: &Block<D>| block.as_flattened().iter().all(|x| *x == 0.0);
            if is_zero(forward) && is_zero(backward) {
                continue;
            }
            let given = self.given(&cell);
            let vector = lattice.vector_to(&given);
            let blocks = [matrix_of(forward), matrix_of(backward)];
            sum.add(given, 0, vector, blocks);
        }
        while let Some((_, (fractional, forward))) = self.loose.pop_first() {
            let backward = self
                .loose
                .remove(&rounded(&-fractional))
                .map_or(SMatrix::zeros(), |b| b.1);
            let cell = array_of(|i| (fractional[i] + 0.5 / LOOSE_RESOLUTION).floor() as i32);
            let place = fractional - SVector::from(cell.map(f64::from));
            let known = sites
                .iter()
                .position(|site| (site - place).amax() < 1.0 / LOOSE_RESOLUTION);
            let site = known.unwrap_or_else(|| {
                sites.push(place);
                sites.len() - 1
            });
            let vector = lattice.vectors() * (SVector::from(cell.map(f64::from)) + sites[site]);
            sum.add(cell, site, vector, [forward, backward]);
        }
        sum.finish(sites, *lattice.vectors())
    }

    /// The next cell in the order of the blocks, the last coordinate fastest.
    fn advance(&self, cell: &mut [i32; D]) {
        for coordinate in cell.iter_mut().rev() {
            if *coordinate < self.reach {
                *coordinate += 1;
                return;
            }
            *coordinate = -self.reach;
        }
    }

    /// A lattice vector of the short basis in the given one.
    fn given(&self, cell: &[i32; D]) -> [i32; D] {
        if self.basis.is_given() {
            return *cell;
        }
        let given = self.basis.change * SVector::from(cell.map(f64::from));
        array_of(|i| given[i] as i32)
    }
}

/// Pairs of opposite vectors with the sums over all of them.
struct PairSum<const D: usize> {
    terms: Vec<Term<D>>,
    /// `sum_R Phi(R)`.
    rigid: SMatrix<f64, D, D>,
    /// The sum of the largest entries.
    magnitude: f64,
    is_inverted: bool,
}

impl<const D: usize> PairSum<D> {
    fn add(
        &mut self,
        cell: [i32; D],
        site: usize,
        vector: SVector<f64, D>,
        [forward, backward]: [SMatrix<f64, D, D>; 2],
    ) {
        self.magnitude += largest(&forward) + largest(&backward);
        let even = forward + backward;
        let odd = if self.is_inverted {
            SMatrix::zeros()
        } else {
            forward - backward
        };
        self.rigid += even;
        if largest(&even) > 0.0 || largest(&odd) > 0.0 {
            self.terms.push(Term {
                vector,
                cell,
                site,
                even,
                odd,
            });
        }
    }

    fn finish(
        self,
        sites: Vec<SVector<f64, D>>,
        vectors: SMatrix<f64, D, D>,
    ) -> DynamicalMatrix<D> {
        let Self {
            terms,
            mut rigid,
            magnitude,
            ..
        } = self;
        // What symmetry makes vanish does so to the rounding error of the shape functions, which can be many times
        // that of the sums.
        let zero = ZERO * magnitude;
        if largest(&rigid) <= zero {
            rigid.fill(0.0);
        }
        // D(k) = rigid + sum (cos - 1) even + i sin odd: Hermitian for symmetric even, antisymmetric odd parts.
        let asymmetry = |term: &Term<D>| {
            let (mut even, mut odd) = (0.0_f64, 0.0_f64);
            for i in 0..D {
                for k in 0..=i {
                    even = even.max((term.even[(i, k)] - term.even[(k, i)]).abs());
                    odd = odd.max((term.odd[(i, k)] + term.odd[(k, i)]).abs());
                }
            }
            even + odd
        };
        let coordinates = terms.iter().flat_map(|term| term.cell);
        DynamicalMatrix {
            centrosymmetric: terms.iter().all(|term| largest(&term.odd) <= zero),
            hermitian: terms.iter().all(|term| asymmetry(term) <= zero),
            reach: coordinates.map(i32::unsigned_abs).max().unwrap_or(0) as usize,
            terms,
            vectors,
            sites,
            rigid,
            rows: OnceLock::new(),
            noise: f64::EPSILON * magnitude,
        }
    }
}

/// A matrix from its rows.
pub(super) fn matrix_of<const D: usize>(block: &Block<D>) -> SMatrix<f64, D, D> {
    let mut matrix = SMatrix::zeros();
    for i in 0..D {
        for k in 0..D {
            matrix[(i, k)] = block[i][k];
        }
    }
    matrix
}

/// The largest magnitude of an entry; NaN where one is.
#[inline]
fn largest<const D: usize>(matrix: &SMatrix<f64, D, D>) -> f64 {
    let mut largest = 0.0_f64;
    for entry in matrix.as_slice() {
        if entry.abs() > largest || entry.is_nan() {
            largest = entry.abs();
        }
        if largest.is_nan() {
            break;
        }
    }
    largest
}

fn rounded<const D: usize>(fractional: &SVector<f64, D>) -> Vec<i64> {
    fractional
        .iter()
        .map(|x| (x * LOOSE_RESOLUTION).round() as i64)
        .collect()
}

impl<const D: usize> DynamicalMatrix<D> {
    /// `D(k)` at a reference wave vector.
    ///
    /// Evaluated as `D(0) + sum (cos - 1) even + i sin odd`, so that long waves keep their relative accuracy.
    pub fn at(&self, k: &SVector<f64, D>) -> SMatrix<Complex, D, D> {
        let (mut real, mut imaginary) = (self.rigid, SMatrix::<f64, D, D>::zeros());
        let phases = HalfPhases::new(self, k);
        for term in &self.terms {
            let half = phases.of(term);
            real -= term.even * (2.0 * half.im * half.im);
            if !self.centrosymmetric {
                imaginary += term.odd * (2.0 * half.im * half.re);
            }
        }
        joined(&real, &imaginary)
    }

    /// The derivatives of `D(k)` with respect to the components of the wave vector.
    pub fn gradient_at(&self, k: &SVector<f64, D>) -> [SMatrix<Complex, D, D>; D] {
        let [real, imaginary] = self.sums::<1>(k);
        array_of(|a| joined(&real.gradient[a], &imaginary.gradient[a]))
    }

    /// `D(k)` with its first and second derivatives with respect to the wave vector.
    pub fn expansion_at(&self, k: &SVector<f64, D>) -> Expansion<Complex, D> {
        let [real, imaginary] = self.sums::<2>(k).map(Expansion::finished);
        Expansion {
            value: joined(&real.value, &imaginary.value),
            gradient: array_of(|a| joined(&real.gradient[a], &imaginary.gradient[a])),
            hessian: array_of(|a| {
                array_of(|b| joined(&real.hessian[a][b], &imaginary.hessian[a][b]))
            }),
        }
    }

    /// The real and the imaginary part of `D(k)` with derivatives up to an order.
    #[inline(always)]
    fn sums<const ORDER: usize>(&self, k: &SVector<f64, D>) -> [Expansion<f64, D>; 2] {
        let mut real = Expansion::starting_at(self.rigid);
        let mut imaginary = Expansion::starting_at(SMatrix::zeros());
        let phases = HalfPhases::new(self, k);
        for term in &self.terms {
            let half = phases.of(term);
            let (versine, sine) = (2.0 * half.im * half.im, 2.0 * half.im * half.re);
            // (cos k.R - 1) even + i sin(k.R) odd, differentiated.
            let derivatives = [-versine, -sine, versine - 1.0];
            real.add::<ORDER>(&term.even, derivatives, &term.vector);
            if !self.centrosymmetric {
                let derivatives = [sine, 1.0 - versine, -sine];
                imaginary.add::<ORDER>(&term.odd, derivatives, &term.vector);
            }
        }
        [real, imaginary]
    }

    /// The same in real numbers, where `D(k)` is real, with derivatives up to an order; others are zero.
    pub(super) fn real_expansion_at<const ORDER: usize>(
        &self,
        k: &SVector<f64, D>,
    ) -> Option<Expansion<f64, D>> {
        if !self.centrosymmetric {
            return None;
        }
        Some(Arch::new().dispatch(RealSums::<ORDER, D>(self, k)))
    }

    /// The eigenvalues `omega^2` at a reference wave vector, by increasing real part.
    pub fn omega_squared(&self, k: &SVector<f64, D>) -> [Complex; D] {
        eigenvalues(&self.at(k), self.noise)
    }

    /// The long-wave limit: the stiffness per density `T` with `D(k) -> T_iJkL k_J k_L`,
    /// `T = -1/2 sum_R Phi(R) R (x) R`. Units length^2/time^2.
    pub fn long_wave_stiffness(&self) -> Stiffness<D> {
        let mut sums = [[[[0.0; D]; D]; D]; D];
        for term in &self.terms {
            for j in 0..D {
                for l in 0..=j {
                    let moment = -0.5 * term.vector[j] * term.vector[l];
                    for i in 0..D {
                        for k in 0..D {
                            sums[j][l][i][k] += term.even[(i, k)] * moment;
                        }
                    }
                }
            }
        }
        Stiffness::from_fn(|i, j, k, l| sums[j.max(l)][j.min(l)][i][k])
    }

    /// `D(0)`: zero, unless the shape functions are no partition of unity, so that a rigid
    /// translation strains the body.
    pub fn rigid_translation(&self) -> &SMatrix<f64, D, D> {
        &self.rigid
    }

    /// Whether `D(k)` is real for every wave vector.
    pub fn is_centrosymmetric(&self) -> bool {
        self.centrosymmetric
    }

    /// Whether `D(k)` is Hermitian for every wave vector, as the second derivative of an energy is.
    pub fn is_hermitian(&self) -> bool {
        self.hermitian
    }

    /// Whether all entries are finite.
    pub fn is_finite(&self) -> bool {
        self.noise.is_finite()
    }

    /// Rounding error to expect in an entry of `D(k)`. 1/time^2.
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// The force constants by rows, where `D` is planar and real.
    pub(super) fn planar_rows(&self) -> Option<&PlanarRows> {
        self.rows
            .get_or_init(|| {
                self.centrosymmetric
                    .then(|| PlanarRows::new(&self.terms, &self.sites, &self.vectors, &self.rigid))
                    .flatten()
            })
            .as_ref()
    }

    /// The force constants of pairs of opposite vectors.
    pub(super) fn terms(&self) -> &[Term<D>] {
        &self.terms
    }

    /// The sums along a mirror line, where `D` is planar, real, periodic and has one of the mirrors, and a translation is
    /// free.
    pub(super) fn mirror_sums(&self, mirrors: &[Mirror]) -> Option<MirrorSums> {
        let is_free = self.rigid.amax() == 0.0;
        (is_free && self.centrosymmetric)
            .then(|| MirrorSums::new(&self.terms, mirrors))
            .flatten()
    }

    /// Which of the symmetries of the lattice its real part has, as bits: with `Phi(Q R) = Q Phi(R) Q^T`, also of `R = 0`, the matrices at `k` and
    /// `Q k` have the same eigenvalues. None where some vectors are none of the lattice.
    pub(super) fn symmetries(&self, all: &[Symmetry<D>]) -> u64 {
        if self.sites.len() > 1 {
            return 0;
        }
        let both = |term| [(term, 1), (term, -1)];
        let mut known: Vec<([i32; D], &SMatrix<f64, D, D>)> = (self.terms.iter().flat_map(both))
            .map(|(term, sign)| (term.cell.each(|n| sign * n), &term.even))
            .collect();
        known.sort_unstable_by_key(|(cell, _)| *cell);
        let equal = EQUAL * self.noise;
        let has = |symmetry: &Symmetry<D>| {
            let turned =
                |block: &SMatrix<f64, D, D>| symmetry.map * block * symmetry.map.transpose();
            let is_kept = |term: &Term<D>| {
                let cell = symmetry.of_cell(&term.cell);
                match known.binary_search_by_key(&cell, |(cell, _)| *cell) {
                    Ok(place) => (known[place].1 - turned(&term.even)).amax() <= equal,
                    Err(_) => term.even.amax() <= equal,
                }
            };
            (self.rigid - turned(&self.rigid)).amax() <= equal && self.terms.iter().all(is_kept)
        };
        let bit = |(n, symmetry)| u64::from(has(symmetry)) << n;
        all.iter().enumerate().map(bit).sum()
    }

    /// The force constants `Phi(R)` of all lattice vectors that have some, zero included; `None` where some belong to vectors
    /// that are none of the lattice.
    pub(crate) fn force_constants(&self) -> Option<Vec<([i32; D], SMatrix<f64, D, D>)>> {
        let mut own = self.rigid;
        let mut constants = Vec::with_capacity(2 * self.terms.len() + 1);
        for term in &self.terms {
            if term.site != 0 {
                return None;
            }
            own -= term.even;
            constants.push((term.cell, (term.even + term.odd) * 0.5));
            constants.push((term.cell.each(|n| -n), (term.even - term.odd) * 0.5));
        }
        constants.push(([0; D], own));
        Some(constants)
    }

    /// Coordinates in which the forces reach equally far in all directions, where the reference lattice is too oblique for
    /// them; none with vectors that are none of the lattice.
    pub(super) fn short_range(&self, lattice: &BravaisLattice<D>) -> Option<ShortRange<D>> {
        if self.sites.len() > 1 {
            return None;
        }
        let force = |term: &Term<D>| {
            let size = term.even.amax() + term.odd.amax();
            (SVector::from(term.cell.map(f64::from)), size)
        };
        let forces: Vec<(SVector<f64, D>, f64)> = self.terms.iter().map(force).collect();
        ShortRange::of(lattice, &forces)
    }

    /// The same in other coordinates, with the lattice there: `D'(k') = D(map^T k')`.
    pub(super) fn in_short_range(
        &self,
        range: &ShortRange<D>,
        lattice: &BravaisLattice<D>,
    ) -> Self {
        let mut moved = self.clone();
        moved.vectors = *lattice.vectors();
        for term in &mut moved.terms {
            let own = (range.inverse * SVector::from(term.cell.map(f64::from))).map(f64::round);
            term.vector = moved.vectors * own;
            term.cell = array_of(|i| own[i] as i32);
        }
        let coordinates = moved.terms.iter().flat_map(|term| term.cell);
        moved.reach = coordinates.map(i32::unsigned_abs).max().unwrap_or(0) as usize;
        moved.rows = OnceLock::new();
        moved
    }

    /// A unit in which its entries are neither very large nor very small.
    pub(super) fn moderate_unit(&self) -> f64 {
        moderate_unit(self.noise / f64::EPSILON)
    }

    /// The same divided by a unit.
    pub(super) fn over(&self, unit: f64) -> Self {
        let mut scaled = self.clone();
        for term in &mut scaled.terms {
            term.even /= unit;
            term.odd /= unit;
        }
        scaled.rigid /= unit;
        scaled.noise /= unit;
        scaled.rows = OnceLock::new();
        scaled
    }

    /// Where in its cell a vector ends.
    pub(super) fn sites(&self) -> &[SVector<f64, D>] {
        &self.sites
    }

    /// Primitive vectors of the reference lattice, as columns.
    pub(super) fn vectors(&self) -> &SMatrix<f64, D, D> {
        &self.vectors
    }

    /// Rounding error to expect in `D(k) / |k|^2` for long waves. Length^2/time^2.
    pub(super) fn long_wave_noise(&self) -> f64 {
        let mut sum = 0.0;
        for term in &self.terms {
            let mut square = 0.0;
            for x in term.vector.as_slice() {
                square += x * x;
            }
            sum += largest(&term.even) * square;
        }
        0.5 * f64::EPSILON * sum
    }

    /// Largest lattice coordinate of a force constant.
    pub(super) fn reach(&self) -> usize {
        self.reach
    }

    /// The lattice coordinate up to which force constants matter to second derivatives by the wave vector, all but a
    /// fiftieth: how fast `D(k)` varies over the zone. Kernels end so smoothly that the largest coordinate says too much.
    pub(super) fn effective_reach(&self) -> usize {
        let mut by_reach = vec![0.0; self.reach + 1];
        for term in &self.terms {
            let reach = term.cell.map(i32::unsigned_abs).into_iter().max();
            by_reach[reach.unwrap_or(0) as usize] +=
                (term.even.amax() + term.odd.amax()) * term.vector.norm_squared();
        }
        let allowed = 0.02 * by_reach.iter().sum::<f64>();
        let mut beyond = 0.0;
        while let Some(last) = by_reach.pop() {
            beyond += last;
            if beyond > allowed {
                break;
            }
        }
        by_reach.len().max(1)
    }
}

/// Work for the widest vectors of the machine. (A closure would not be inlined there.)
struct RealSums<'a, const ORDER: usize, const D: usize>(
    &'a DynamicalMatrix<D>,
    &'a SVector<f64, D>,
);

impl<const ORDER: usize, const D: usize> NullaryFnOnce for RealSums<'_, ORDER, D> {
    type Output = Expansion<f64, D>;

    #[inline(always)]
    fn call(self) -> Expansion<f64, D> {
        let [real, _] = self.0.sums::<ORDER>(self.1);
        real.finished()
    }
}

/// The phases `exp(i k.R / 2)` of all vectors from those of the primitive vectors: a sine and cosine for each
/// primitive vector and site, a product for each vector.
struct HalfPhases<const D: usize> {
    /// `exp(i n k.a_d / 2)`.
    powers: Powers<D>,
    /// `exp(i k.site / 2)`.
    sites: Vec<Complex>,
}

impl<const D: usize> HalfPhases<D> {
    fn new(matrix: &DynamicalMatrix<D>, k: &SVector<f64, D>) -> Self {
        let half_phase = |vector: SVector<f64, D>| {
            let (sine, cosine) = (0.5 * k.dot(&vector)).sin_cos();
            Complex::new(cosine, sine)
        };
        let steps: [Complex; D] = array_of(|d| half_phase(matrix.vectors.column(d).into_owned()));
        let sites = matrix
            .sites
            .iter()
            .skip(1)
            .map(|site| half_phase(matrix.vectors * site))
            .collect();
        Self {
            powers: Powers::new(steps, matrix.reach),
            sites,
        }
    }

    fn of(&self, term: &Term<D>) -> Complex {
        let site = match term.site {
            0 => Complex::new(1.0, 0.0),
            own => self.sites[own - 1],
        };
        self.powers.turned(site, &term.cell)
    }
}
