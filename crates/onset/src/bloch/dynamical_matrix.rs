//! The dynamical matrix as a sum of plane-wave phases.

use crate::algebra::{Complex, eigenvalues};
use crate::continuum::Stiffness;
use crate::lattice::BravaisLattice;
use nalgebra::{SMatrix, SVector};
use std::collections::BTreeMap;

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
    /// Rounding error to expect in an entry.
    noise: f64,
}

/// The force constants of `R` and `-R` together.
#[derive(Clone, Debug)]
struct Term<const D: usize> {
    /// `R`, in the reference state.
    vector: SVector<f64, D>,
    /// Its cell, `R = cell + site` in lattice coordinates.
    cell: [i32; D],
    /// Its place in the cell, an index of `sites`.
    site: usize,
    /// `Phi(R) + Phi(-R)`.
    even: SMatrix<f64, D, D>,
    /// `Phi(R) - Phi(-R)`.
    odd: SMatrix<f64, D, D>,
}

/// Collects force constants by lattice vector.
pub(super) struct ForceConstants<const D: usize> {
    /// Largest lattice coordinate.
    reach: i32,
    /// Dense blocks for lattice vectors, coordinates from `-reach` to `reach`.
    blocks: Vec<SMatrix<f64, D, D>>,
    /// Blocks at other vectors (plane-wave stress points), by rounded lattice coordinates.
    loose: BTreeMap<Vec<i64>, (SVector<f64, D>, SMatrix<f64, D, D>)>,
}

/// Sums of force constants below this fraction of their absolute sum vanish but for rounding.
const ZERO: f64 = 1e-10;
/// Resolution with which lattice coordinates of loose vectors are told apart.
const LOOSE_RESOLUTION: f64 = 1e6;

impl<const D: usize> ForceConstants<D> {
    pub(super) fn new(reach: i32) -> Self {
        let side = (2 * reach + 1) as usize;
        Self {
            reach,
            blocks: vec![SMatrix::zeros(); side.pow(D as u32)],
            loose: BTreeMap::new(),
        }
    }

    /// Adds to the force constant of the lattice vector `to - from`.
    pub(super) fn add(&mut self, from: &[i32; D], to: &[i32; D], block: &SMatrix<f64, D, D>) {
        let side = 2 * self.reach + 1;
        let index = (0..D).fold(0, |index, i| index * side + (to[i] - from[i] + self.reach));
        self.blocks[index as usize] += block;
    }

    /// Adds to the force constant of a vector given by its lattice coordinates.
    pub(super) fn add_loose(&mut self, fractional: SVector<f64, D>, block: &SMatrix<f64, D, D>) {
        let entry = self
            .loose
            .entry(rounded(&fractional))
            .or_insert((fractional, SMatrix::zeros()));
        entry.1 += block;
    }

    /// The sum over all vectors, with `R` and `-R` taken together.
    pub(super) fn finish(mut self, lattice: &BravaisLattice<D>) -> DynamicalMatrix<D> {
        let side = (2 * self.reach + 1) as usize;
        let mut sites = vec![SVector::zeros()];
        let mut pairs = Vec::new();
        let middle = self.blocks.len() / 2;
        let mut rigid = self.blocks[middle];
        for index in middle + 1..self.blocks.len() {
            let opposite = self.blocks.len() - 1 - index;
            let mut rest = index;
            let mut cell = [0; D];
            for i in (0..D).rev() {
                cell[i] = (rest % side) as i32 - self.reach;
                rest /= side;
            }
            pairs.push((cell, 0, self.blocks[index], self.blocks[opposite]));
        }
        while let Some((_, (fractional, forward))) = self.loose.pop_first() {
            let backward = self
                .loose
                .remove(&rounded(&-fractional))
                .map_or(SMatrix::zeros(), |b| b.1);
            let cell =
                std::array::from_fn(|i| (fractional[i] + 0.5 / LOOSE_RESOLUTION).floor() as i32);
            let place = fractional - SVector::from(cell.map(f64::from));
            let known = sites
                .iter()
                .position(|site| (site - place).amax() < 1.0 / LOOSE_RESOLUTION);
            let site = known.unwrap_or_else(|| {
                sites.push(place);
                sites.len() - 1
            });
            pairs.push((cell, site, forward, backward));
        }
        let magnitude = pairs
            .iter()
            .map(|(_, _, f, b)| f.amax() + b.amax())
            .sum::<f64>()
            + rigid.amax();
        let noise = f64::EPSILON * magnitude;
        // What symmetry makes vanish does so to the rounding error of the shape functions, which can be many times
        // that of the sums.
        let zero = ZERO * magnitude;
        let mut terms = Vec::new();
        for (cell, site, forward, backward) in pairs {
            let (even, odd) = (forward + backward, forward - backward);
            rigid += even;
            if even.amax() > 0.0 || odd.amax() > 0.0 {
                let vector = lattice.vectors() * (SVector::from(cell.map(f64::from)) + sites[site]);
                terms.push(Term {
                    vector,
                    cell,
                    site,
                    even,
                    odd,
                });
            }
        }
        if rigid.amax() <= zero {
            rigid.fill(0.0);
        }
        let centrosymmetric = terms.iter().all(|term| term.odd.amax() <= zero);
        // D(k) = rigid + sum (cos - 1) even + i sin odd: Hermitian for symmetric even, antisymmetric odd parts.
        let asymmetry = |term: &Term<D>| {
            (term.even - term.even.transpose()).amax() + (term.odd + term.odd.transpose()).amax()
        };
        let hermitian = terms.iter().all(|term| asymmetry(term) <= zero);
        let coordinates = terms.iter().flat_map(|term| term.cell);
        let reach = coordinates.map(i32::unsigned_abs).max().unwrap_or(0) as usize;
        let vectors = *lattice.vectors();
        DynamicalMatrix {
            terms,
            vectors,
            sites,
            reach,
            rigid,
            centrosymmetric,
            hermitian,
            noise,
        }
    }
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
        real.zip_map(&imaginary, Complex::new)
    }

    /// The derivatives of `D(k)` with respect to the components of the wave vector.
    pub fn gradient_at(&self, k: &SVector<f64, D>) -> [SMatrix<Complex, D, D>; D] {
        let mut real = [SMatrix::<f64, D, D>::zeros(); D];
        let mut imaginary = real;
        let phases = HalfPhases::new(self, k);
        for term in &self.terms {
            let half = phases.of(term);
            let (sine, cosine) = (2.0 * half.im * half.re, 1.0 - 2.0 * half.im * half.im);
            for a in 0..D {
                real[a] -= term.even * (sine * term.vector[a]);
                if !self.centrosymmetric {
                    imaginary[a] += term.odd * (cosine * term.vector[a]);
                }
            }
        }
        std::array::from_fn(|a| real[a].zip_map(&imaginary[a], Complex::new))
    }

    /// `D(k)` at all points `k = sum_i (j_i / resolution) b_i`, `j_i = 0 .. resolution`, first index
    /// slowest, from tabulated phases. `None` when `D` is not periodic.
    pub(super) fn on_grid(
        &self,
        resolution: usize,
        half: bool,
    ) -> Option<Vec<SMatrix<Complex, D, D>>> {
        let n = resolution as i64;
        let phases: Vec<(f64, f64)> = (0..n)
            .map(|m| {
                let (sine, cosine) = (std::f64::consts::PI * m as f64 / n as f64).sin_cos();
                (-2.0 * sine * sine, 2.0 * sine * cosine)
            })
            .collect();
        if self.sites.len() > 1 {
            return None;
        }
        let cells: Vec<[i64; D]> = self
            .terms
            .iter()
            .map(|term| term.cell.map(i64::from))
            .collect();
        let total = resolution.pow(D as u32);
        let count = if half { total / 2 + 1 } else { total };
        let mut grid = Vec::with_capacity(count);
        for index in 0..count {
            let coordinates = grid_coordinates::<D>(index, resolution);
            let (mut real, mut imaginary) = (self.rigid, SMatrix::<f64, D, D>::zeros());
            for (term, cell) in self.terms.iter().zip(&cells) {
                let turns: i64 = (0..D).map(|i| cell[i] * coordinates[i] as i64).sum();
                let (cosine_less_one, sine) = phases[turns.rem_euclid(n) as usize];
                real += term.even * cosine_less_one;
                if !self.centrosymmetric {
                    imaginary += term.odd * sine;
                }
            }
            grid.push(real.zip_map(&imaginary, Complex::new));
        }
        Some(grid)
    }

    /// The eigenvalues `omega^2` at a reference wave vector, by increasing real part.
    pub fn omega_squared(&self, k: &SVector<f64, D>) -> [Complex; D] {
        eigenvalues(&self.at(k), self.noise)
    }

    /// The long-wave limit: the stiffness per density `T` with `D(k) -> T_iJkL k_J k_L`,
    /// `T = -1/2 sum_R Phi(R) R (x) R`. Units length^2/time^2.
    pub fn long_wave_stiffness(&self) -> Stiffness<D> {
        Stiffness::from_fn(|i, j, k, l| {
            let sum: f64 = self
                .terms
                .iter()
                .map(|term| term.even[(i, k)] * (term.vector[j] * term.vector[l]))
                .sum();
            -0.5 * sum
        })
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

    /// Rounding error to expect in `D(k) / |k|^2` for long waves. Length^2/time^2.
    pub(super) fn long_wave_noise(&self) -> f64 {
        let sum: f64 = self
            .terms
            .iter()
            .map(|term| term.even.amax() * term.vector.norm_squared())
            .sum();
        0.5 * f64::EPSILON * sum
    }

    /// Largest lattice coordinate of a force constant: how fast `D(k)` can vary over the zone.
    pub(super) fn reach(&self) -> usize {
        self.reach.max(1)
    }
}

/// The phases `exp(i k.R / 2)` of all vectors from those of the primitive vectors: a sine and cosine for each
/// primitive vector and site, a product for each vector.
struct HalfPhases<const D: usize> {
    /// `exp(i n k.a_d / 2)` at `[n][d]`, `n = 0 ..= reach`.
    powers: Vec<[Complex; D]>,
    /// `exp(i k.site / 2)`.
    sites: Vec<Complex>,
}

impl<const D: usize> HalfPhases<D> {
    fn new(matrix: &DynamicalMatrix<D>, k: &SVector<f64, D>) -> Self {
        let half_phase = |vector: SVector<f64, D>| {
            let (sine, cosine) = (0.5 * k.dot(&vector)).sin_cos();
            Complex::new(cosine, sine)
        };
        let steps: [Complex; D] =
            std::array::from_fn(|d| half_phase(matrix.vectors.column(d).into_owned()));
        let mut powers = Vec::with_capacity(matrix.reach + 1);
        powers.push([Complex::new(1.0, 0.0); D]);
        for n in 0..matrix.reach {
            powers.push(std::array::from_fn(|d: usize| -> Complex {
                powers[n][d] * steps[d]
            }));
        }
        let sites = matrix
            .sites
            .iter()
            .skip(1)
            .map(|site| half_phase(matrix.vectors * site))
            .collect();
        Self { powers, sites }
    }

    fn of(&self, term: &Term<D>) -> Complex {
        let mut phase = if term.site == 0 {
            Complex::new(1.0, 0.0)
        } else {
            self.sites[term.site - 1]
        };
        for d in 0..D {
            let power = self.powers[term.cell[d].unsigned_abs() as usize][d];
            phase *= if term.cell[d] < 0 {
                power.conj()
            } else {
                power
            };
        }
        phase
    }
}

/// The coordinates of a grid point, first slowest.
pub(super) fn grid_coordinates<const D: usize>(index: usize, resolution: usize) -> [usize; D] {
    let mut rest = index;
    let mut coordinates = [0; D];
    for i in (0..D).rev() {
        coordinates[i] = rest % resolution;
        rest /= resolution;
    }
    coordinates
}
