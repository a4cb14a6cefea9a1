//! The dynamical matrix of one particle in a cell, as a sum of plane-wave phases.

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

/// Dynamical matrix `D(k) = sum_R Phi(R) exp(i k.R)` of one particle in a cell.
///
/// `Phi(R)` are the force constants, divided by the mass, between a particle and the point displaced from it by the reference vector `R`. Shape `D x
/// D`, unit 1/time^2. Hermitian for Lagrangian kernels; real for sets of points with an inversion center.
#[derive(Clone, Debug)]
pub struct DynamicalMatrix<const D: usize> {
    terms: Vec<Term<D>>,
    /// Primitive vectors of the reference lattice, as columns.
    vectors: SMatrix<f64, D, D>,
    /// End points of the vectors in their cell: first the lattice point, then the stress points that move with the plane wave.
    sites: Vec<SVector<f64, D>>,
    /// Largest lattice coordinate of a vector, in magnitude.
    reach: usize,
    /// `D(0) = sum_R Phi(R)`; zero if a translation costs no energy.
    rigid: SMatrix<f64, D, D>,
    /// True if `Phi(-R) = Phi(R)`; then `D` is real.
    centrosymmetric: bool,
    /// True if `Phi(-R) = Phi(R)^T`; then `D` is Hermitian.
    hermitian: bool,
    /// Force constants by rows if `D` is planar and real; computed when first needed.
    rows: OnceLock<Option<PlanarRows>>,
    /// Rounding error of an entry.
    noise: f64,
}

/// Force constants of `R` and `-R` together.
#[derive(Clone, Debug)]
pub(super) struct Term<const D: usize> {
    /// Vector `R` in the reference state.
    vector: SVector<f64, D>,
    /// Cell of the vector, `R = cell + site` in lattice coordinates.
    pub(super) cell: [i32; D],
    /// Position in the cell, an index into `sites`.
    pub(super) site: usize,
    /// Even part `Phi(R) + Phi(-R)` of the force constants.
    pub(super) even: SMatrix<f64, D, D>,
    /// Odd part `Phi(R) - Phi(-R)` of the force constants.
    odd: SMatrix<f64, D, D>,
}

/// `D(k)` with its derivatives with respect to the components of the wave vector; real numbers if `D` is real.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expansion<T, const D: usize> {
    /// Value `D(k)` at the wave vector.
    pub value: SMatrix<T, D, D>,
    /// First derivatives with respect to the components of the wave vector.
    pub gradient: [SMatrix<T, D, D>; D],
    /// Second derivatives with respect to the components of the wave vector.
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

    /// Adds `block` times a function of `k.R`, given with its first two derivatives. Second derivatives only if `ORDER` is two.
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

    /// Copies the summed half of the symmetric second derivatives to the other half.
    fn finished(mut self) -> Self {
        for a in 0..D {
            for b in 0..a {
                self.hessian[b][a] = self.hessian[a][b];
            }
        }
        self
    }
}

/// Joins real and imaginary part to a complex matrix.
fn joined<const D: usize>(
    real: &SMatrix<f64, D, D>,
    imaginary: &SMatrix<f64, D, D>,
) -> SMatrix<Complex, D, D> {
    real.zip_map(imaginary, Complex::new)
}

/// Matrix of force constants, by rows.
pub(super) type Block<const D: usize> = [[f64; D]; D];

/// Collects force constants by lattice vector.
pub(super) struct ForceConstants<const D: usize> {
    /// Basis for the coordinates of the blocks.
    basis: Reduced<D>,
    /// Largest lattice coordinate in this basis, in magnitude.
    reach: i32,
    /// Index steps in the array of blocks for the vectors of the given basis.
    steps: [i64; D],
    /// Dense blocks for lattice vectors with coordinates from `-reach` to `reach` in this basis.
    blocks: Vec<Block<D>>,
    /// Blocks at other vectors (plane-wave stress points), by rounded lattice coordinates.
    loose: BTreeMap<Vec<i64>, (SVector<f64, D>, SMatrix<f64, D, D>)>,
}

/// Largest sum of force constants that vanishes except for rounding, relative to the sum of their magnitudes.
const VANISHING_SUM_RATIO: f64 = 1e-10;
/// Largest fraction of the second derivatives of `D(k)` that the effective range neglects. A heuristic value; it determines the density of grids.
pub(super) const NEGLECTED_CURVATURE: f64 = 0.02;
/// Largest difference of force constants that are symmetric images, as a multiple of the rounding error of the matrix.
const IMAGE_ROUNDING_FACTOR: f64 = 64.0;
/// Inverse of the distance at which lattice coordinates of loose vectors are distinguished.
const LOOSE_RESOLUTION: f64 = 1e6;

impl<const D: usize> ForceConstants<D> {
    /// Creates a collection for lattice vectors with coordinates up to `reach` in a short basis.
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

    /// Indices of lattice vectors relative to the zero vector. The index of a difference of vectors is the difference of their indices.
    pub(super) fn places(&self, cells: &[[i32; D]]) -> Vec<usize> {
        let mut places = Vec::with_capacity(cells.len());
        for cell in cells {
            // Negative indices wrap around, as do sums and differences of indices.
            let mut place = 0_i64;
            for i in 0..D {
                place += i64::from(cell[i]) * self.steps[i];
            }
            places.push(place as usize);
        }
        places
    }

    /// Index of the zero vector.
    pub(super) fn middle(&self) -> usize {
        self.blocks.len() / 2
    }

    /// Blocks of force constants by index.
    pub(super) fn blocks_mut(&mut self) -> &mut [Block<D>] {
        &mut self.blocks
    }

    /// Adds to the force constant of the lattice vector with a relative index.
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

    /// Builds the matrix, with `R` and `-R` taken together.
    ///
    /// With `is_inverted`, only one point of each pair that the inversion exchanges was added, with the weight of both points; then the odd parts
    /// cancel.
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

    /// Next cell in the order of the blocks, with the last coordinate varying fastest.
    fn advance(&self, cell: &mut [i32; D]) {
        for coordinate in cell.iter_mut().rev() {
            if *coordinate < self.reach {
                *coordinate += 1;
                return;
            }
            *coordinate = -self.reach;
        }
    }

    /// Converts a lattice vector from the short basis to the given basis.
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
    /// Sum `sum_R Phi(R)` over all vectors.
    rigid: SMatrix<f64, D, D>,
    /// Sum of the largest entries of the force constants.
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
        // Symmetry makes sums vanish up to the rounding error of the shape functions, which can be much larger than the rounding error of the sums.
        let zero = VANISHING_SUM_RATIO * magnitude;
        if largest(&rigid) <= zero {
            rigid.fill(0.0);
        }
        // `D(k) = rigid + sum (cos - 1) even + i sin odd` is Hermitian if even parts are symmetric and odd parts antisymmetric.
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

/// Builds a matrix from its rows.
pub(super) fn matrix_of<const D: usize>(block: &Block<D>) -> SMatrix<f64, D, D> {
    let mut matrix = SMatrix::zeros();
    for i in 0..D {
        for k in 0..D {
            matrix[(i, k)] = block[i][k];
        }
    }
    matrix
}

/// Largest magnitude of an entry; NaN if an entry is NaN.
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
    /// It is evaluated as `D(0) + sum (cos - 1) even + i sin odd`, so that long waves keep their relative accuracy.
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

    /// Derivatives of `D(k)` with respect to the components of the wave vector.
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

    /// Real and imaginary part of `D(k)` with derivatives up to `ORDER`.
    #[inline(always)]
    fn sums<const ORDER: usize>(&self, k: &SVector<f64, D>) -> [Expansion<f64, D>; 2] {
        let mut real = Expansion::starting_at(self.rigid);
        let mut imaginary = Expansion::starting_at(SMatrix::zeros());
        let phases = HalfPhases::new(self, k);
        for term in &self.terms {
            let half = phases.of(term);
            let (versine, sine) = (2.0 * half.im * half.im, 2.0 * half.im * half.re);
            // `(cos k.R - 1) even + i sin(k.R) odd`, differentiated.
            let derivatives = [-versine, -sine, versine - 1.0];
            real.add::<ORDER>(&term.even, derivatives, &term.vector);
            if !self.centrosymmetric {
                let derivatives = [sine, 1.0 - versine, -sine];
                imaginary.add::<ORDER>(&term.odd, derivatives, &term.vector);
            }
        }
        [real, imaginary]
    }

    /// `D(k)` in real numbers with derivatives up to `ORDER`, zero beyond; `None` if `D(k)` is complex.
    pub(super) fn real_expansion_at<const ORDER: usize>(
        &self,
        k: &SVector<f64, D>,
    ) -> Option<Expansion<f64, D>> {
        if !self.centrosymmetric {
            return None;
        }
        Some(Arch::new().dispatch(RealSums::<ORDER, D>(self, k)))
    }

    /// Eigenvalues `omega^2` at a reference wave vector, by increasing real part.
    pub fn omega_squared(&self, k: &SVector<f64, D>) -> [Complex; D] {
        eigenvalues(&self.at(k), self.noise)
    }

    /// Stiffness per density `T` of the long-wave limit `D(k) -> T_iJkL k_J k_L`. Length^2/time^2.
    ///
    /// `T = -1/2 sum_R Phi(R) R (x) R`.
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

    /// `D(0)`: zero, unless the shape functions are not a partition of unity and a translation strains the body.
    pub fn rigid_translation(&self) -> &SMatrix<f64, D, D> {
        &self.rigid
    }

    /// Returns true if `D(k)` is real for every wave vector.
    pub fn is_centrosymmetric(&self) -> bool {
        self.centrosymmetric
    }

    /// Returns true if `D(k)` is Hermitian for every wave vector, as the second derivative of an energy is.
    pub fn is_hermitian(&self) -> bool {
        self.hermitian
    }

    /// Returns true if all entries are finite.
    pub fn is_finite(&self) -> bool {
        self.noise.is_finite()
    }

    /// Rounding error of an entry of `D(k)`. 1/time^2.
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// Force constants by rows; `None` unless `D` is planar and real.
    pub(super) fn planar_rows(&self) -> Option<&PlanarRows> {
        self.rows
            .get_or_init(|| {
                self.centrosymmetric
                    .then(|| PlanarRows::new(&self.terms, &self.sites, &self.vectors, &self.rigid))
                    .flatten()
            })
            .as_ref()
    }

    /// Force constants of pairs of opposite vectors.
    pub(super) fn terms(&self) -> &[Term<D>] {
        &self.terms
    }

    /// Sums along a mirror line; `None` unless `D` is planar, real, periodic and has one of the mirrors, and translations are free.
    pub(super) fn mirror_sums(&self, mirrors: &[Mirror]) -> Option<MirrorSums> {
        let is_free = self.rigid.amax() == 0.0;
        (is_free && self.centrosymmetric)
            .then(|| MirrorSums::new(&self.terms, mirrors))
            .flatten()
    }

    /// Symmetries of the lattice that the real part of `D` has, as bits.
    ///
    /// If `Phi(Q R) = Q Phi(R) Q^T`, including `R = 0`, the matrices at `k` and `Q k` have the same eigenvalues. No bits are set if some vectors are
    /// not lattice vectors.
    pub(super) fn symmetries(&self, all: &[Symmetry<D>]) -> u64 {
        if self.sites.len() > 1 {
            return 0;
        }
        let both = |term| [(term, 1), (term, -1)];
        let mut known: Vec<([i32; D], &SMatrix<f64, D, D>)> = (self.terms.iter().flat_map(both))
            .map(|(term, sign)| (term.cell.each(|n| sign * n), &term.even))
            .collect();
        known.sort_unstable_by_key(|(cell, _)| *cell);
        let equal = IMAGE_ROUNDING_FACTOR * self.noise;
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

    /// Nonzero force constants `Phi(R)` of all lattice vectors, including `R = 0`; `None` if some vectors are not lattice vectors.
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

    /// Coordinates in which the forces have the same range in all directions, if the reference lattice is too oblique for them; `None` if some
    /// vectors are not lattice vectors.
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

    /// Returns the matrix in the coordinates of `range`, with the lattice there: `D'(k') = D(map^T k')`.
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

    /// Unit in which the entries have moderate magnitudes.
    pub(super) fn moderate_unit(&self) -> f64 {
        moderate_unit(self.noise / f64::EPSILON)
    }

    /// Returns the matrix divided by a unit.
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

    /// End points of the vectors in their cell, in lattice coordinates.
    pub(super) fn sites(&self) -> &[SVector<f64, D>] {
        &self.sites
    }

    /// Primitive vectors of the reference lattice, as columns.
    pub(super) fn vectors(&self) -> &SMatrix<f64, D, D> {
        &self.vectors
    }

    /// Rounding error of `D(k) / |k|^2` for long waves. Length^2/time^2.
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

    /// Largest lattice coordinate of a force constant, in magnitude.
    pub(super) fn reach(&self) -> usize {
        self.reach
    }

    /// Largest lattice coordinate that matters to second derivatives with respect to the wave vector: it determines how fast `D(k)` varies over the
    /// zone.
    ///
    /// Larger coordinates contribute only a small part of the second derivatives. Kernels decay so smoothly at the rim that the largest coordinate
    /// overestimates the variation.
    pub(super) fn effective_reach(&self) -> usize {
        let mut by_reach = vec![0.0; self.reach + 1];
        for term in &self.terms {
            let reach = term.cell.map(i32::unsigned_abs).into_iter().max();
            by_reach[reach.unwrap_or(0) as usize] +=
                (term.even.amax() + term.odd.amax()) * term.vector.norm_squared();
        }
        let allowed = NEGLECTED_CURVATURE * by_reach.iter().sum::<f64>();
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

/// Vectorized summation for the instruction set of the machine. It is a struct because a closure would not be inlined.
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

/// Phases `exp(i k.R / 2)` of all vectors. They need one sine and cosine for each primitive vector and site, and one product for each vector.
struct HalfPhases<const D: usize> {
    /// Powers `exp(i n k.a_d / 2)` of the primitive vectors.
    powers: Powers<D>,
    /// Phases `exp(i k.site / 2)` of the sites.
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
