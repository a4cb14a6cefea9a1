//! Matrices of plane waves at many wave vectors.
//!
//! A search needs spectra at many wave vectors, and one branch with its derivatives at a few wave vectors. [`Sampled`] is the interface through which
//! it evaluates a system. For small cells with lumped masses a [`FlatSum`] computes eight wave vectors at a time, without heap matrices for each of
//! them. All other systems implement the interface themselves.

use super::{BlochSum, Mass, WaveSystem};
use crate::algebra::{
    Complex, Eigenvectors, Pair, ROTATED_ROWS, array_of, diagonalize, times, triangular,
    without_rounding,
};
use crate::bloch::branches::Taylor;
use crate::bloch::pocket::{Around, Turned, of_numbered};
use crate::cancel::checkpoint;
use crate::cores::of_each_long;
use crate::real::{LANES, Lanes, Real, Work};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::collections::BTreeMap;

/// Minimum number of degrees of freedom of a large cell. Each of its eigenvalue problems is solved on a separate core, and fewer descents start.
pub(super) const LARGE_CELL_SIZE: usize = 24;

/// Largest number of rows for which a single spectrum is computed in lanes. For larger matrices the empty lanes are too expensive.
const LONE_ROWS: usize = 4;

/// Matrix of plane waves that is evaluated at many wave vectors.
pub(super) trait Sampled<const D: usize>: Send + Sync {
    /// All `omega^2` at each wave vector by increasing real part.
    fn spectra(&self, wave_vectors: &[SVector<f64, D>]) -> Spectra;

    /// `D(k)` with its derivatives at each wave vector.
    fn around(&self, wave_vectors: &[SVector<f64, D>]) -> Vec<Around<D>>;

    /// Taylor expansion of a branch at each wave vector, given its number in the order of a value of `omega^2`; `None` where eigenvectors cannot be
    /// computed.
    fn branches(
        &self,
        wave_vectors: &[SVector<f64, D>],
        order: &dyn Fn(Complex) -> f64,
        numbers: &[usize],
    ) -> Vec<Option<Taylor<Complex, D>>> {
        let around = self.around(wave_vectors).into_iter().zip(numbers);
        let branch =
            |(around, number): (Around<D>, &usize)| around.branches(order, &[*number])?.pop();
        around.map(branch).collect()
    }
}

/// Values of `omega^2` at several wave vectors.
pub(super) struct Spectra {
    size: usize,
    values: Vec<Complex>,
}

impl Spectra {
    /// Iterates over the spectra.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[Complex]> {
        self.values.chunks_exact(self.size)
    }
}

impl<const D: usize> WaveSystem<D> {
    /// Form of the system in which it is evaluated fastest.
    pub(super) fn sampled(&self) -> Box<dyn Sampled<D> + '_> {
        match FlatSum::of_system(self) {
            Some(sum) => Box::new(sum),
            None => Box::new(self),
        }
    }
}

impl<const D: usize> Sampled<D> for &WaveSystem<D> {
    fn spectra(&self, wave_vectors: &[SVector<f64, D>]) -> Spectra {
        let spectrum = |k: &SVector<f64, D>| self.omega_squared(k);
        let is_large = self.size() >= LARGE_CELL_SIZE;
        let all = of_each_long(is_large, wave_vectors.iter().collect(), spectrum);
        Spectra {
            size: self.size(),
            values: all.into_iter().flatten().collect(),
        }
    }

    fn around(&self, wave_vectors: &[SVector<f64, D>]) -> Vec<Around<D>> {
        let around = |k| Around::Complex(self.expansion_at(k));
        wave_vectors.iter().map(around).collect()
    }

    fn branches(
        &self,
        wave_vectors: &[SVector<f64, D>],
        order: &dyn Fn(Complex) -> f64,
        numbers: &[usize],
    ) -> Vec<Option<Taylor<Complex, D>>> {
        let branch = |(k, number): (&SVector<f64, D>, &usize)| {
            let expansion = self.expansion_at(k);
            let all = self.decomposed(&expansion)?;
            let own = |own| expansion.branch(&all, own);
            of_numbered(&all.values, order, &[*number], own)?.pop()
        };
        wave_vectors.iter().zip(numbers).map(branch).collect()
    }
}

/// Block of a pair of particles, by the first row and column of its entries and the number of its cell.
#[derive(Clone, Copy, Debug)]
struct Bond {
    row: usize,
    column: usize,
    cell: usize,
}

/// Lattice sum of blocks with the phases of their cells, in flat arrays.
///
/// Phases of sites within a cell are omitted: they transform the coordinates and change no eigenvalue. The real part of a block is multiplied by the
/// factor of the cosine, the imaginary part by the factor of the sine. For Hermitian systems only the upper triangle is summed, and a pair of equal
/// sites represents both directions.
struct FlatSum<'a, const D: usize> {
    system: &'a WaveSystem<D>,
    size: usize,
    is_hermitian: bool,
    /// Rounding error of an entry. 1/time^2.
    noise: f64,
    primitive: [SVector<f64, D>; D],
    cells: Vec<([i32; D], SVector<f64, D>)>,
    reach: usize,
    bonds: Vec<Bond>,
    /// Factors of each entry of each bond, by rows.
    factors: Vec<[f64; 2]>,
    /// Smoothing of the velocities, multiplied from the right.
    drift: Option<Box<FlatSum<'a, D>>>,
}

impl<'a, const D: usize> FlatSum<'a, D> {
    /// `D(k)` of a system, or a Hermitian matrix with its eigenvalues; `None` for large cells and consistent masses.
    fn of_system(system: &'a WaveSystem<D>) -> Option<Self> {
        let Mass::Lumped(masses) = system.mass() else {
            return None;
        };
        if system.size() > ROTATED_ROWS {
            return None;
        }
        let is_hermitian = system.is_hermitian();
        let weight = |from: usize, to: usize| match is_hermitian {
            true => (masses[from] * masses[to]).sqrt().recip(),
            false => masses[from].recip(),
        };
        let mut own = Self::of_sum(system, system.stiffness(), is_hermitian, weight);
        own.noise = system.noise();
        own.drift = system
            .drift()
            .map(|drift| Box::new(Self::of_sum(system, drift, false, |_, _| 1.0)));
        Some(own)
    }

    fn of_sum(
        system: &'a WaveSystem<D>,
        sum: &BlochSum<D>,
        is_hermitian: bool,
        weight: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let mut blocks = BTreeMap::<(usize, usize, [i32; D]), SMatrix<f64, D, D>>::new();
        for (from, to, block) in sum.blocks() {
            let block = block * weight(from, to.site);
            let back: [i32; D] = array_of(|a| -to.cell[a]);
            let is_reversed = is_hermitian && (from, back) > (to.site, to.cell);
            let (key, block) = match is_reversed {
                true => ((to.site, from, back), block.transpose()),
                false => ((from, to.site, to.cell), block),
            };
            let share = if is_hermitian { 0.5 } else { 1.0 };
            *blocks.entry(key).or_insert_with(SMatrix::zeros) += block * share;
        }
        let mut own = Self {
            system,
            size: sum.size(),
            is_hermitian,
            noise: 0.0,
            primitive: *sum.primitive(),
            cells: Vec::new(),
            reach: sum.reach(),
            bonds: Vec::new(),
            factors: Vec::new(),
            drift: None,
        };
        let mut numbers = BTreeMap::new();
        for ((from, to, cell), block) in blocks {
            let number = *numbers.entry(cell).or_insert_with(|| {
                let parts = own.primitive.iter().zip(cell);
                let vector = parts.map(|(a, n)| a * f64::from(n)).sum();
                own.cells.push((cell, vector));
                own.cells.len() - 1
            });
            own.bonds.push(Bond {
                row: D * from,
                column: D * to,
                cell: number,
            });
            let both = is_hermitian && from == to;
            own.factors.extend((0..D * D).map(|e| {
                let (x, y) = (block[(e / D, e % D)], block[(e % D, e / D)]);
                if both { [x + y, x - y] } else { [x, x] }
            }));
        }
        own
    }

    /// Sums of the blocks times the phases of the cells.
    #[inline(always)]
    fn summed(&self, phases: &[Pair<Lanes>], matrix: &mut [Pair<Lanes>]) {
        matrix.fill([Lanes::constant(0.0); 2]);
        for (bond, factors) in self.bonds.iter().zip(self.factors.chunks_exact(D * D)) {
            let [cosine, sine] = phases[bond.cell];
            for i in 0..D {
                let place = (bond.row + i) * self.size + bond.column;
                for (entry, [a, b]) in matrix[place..place + D].iter_mut().zip(&factors[D * i..]) {
                    entry[0] = entry[0] + cosine * *a;
                    entry[1] = entry[1] + sine * *b;
                }
            }
        }
    }

    /// Powers of the phases of the primitive vectors at up to eight wave vectors, and from them the phases of the cells.
    fn phases(&self, wave_vectors: &[SVector<f64, D>]) -> Vec<Pair<Lanes>> {
        let phase = |vector: &SVector<f64, D>| {
            let mut own = [Lanes::constant(1.0), Lanes::constant(0.0)];
            for (lane, k) in wave_vectors.iter().enumerate() {
                let (sine, cosine) = k.dot(vector).sin_cos();
                (own[0].0[lane], own[1].0[lane]) = (cosine, sine);
            }
            own
        };
        // With a strongly oblique basis there are more powers of the primitive phases than cells.
        if D * self.reach > self.cells.len() {
            return self.cells.iter().map(|(_, vector)| phase(vector)).collect();
        }
        let steps: [Pair<Lanes>; D] = array_of(|a| phase(&self.primitive[a]));
        Lanes::vectorized(Phases {
            cells: &self.cells,
            steps,
            reach: self.reach,
        })
    }

    /// Eigenvalues at up to eight wave vectors, and the norms of the matrices; `None` if the iteration does not converge.
    fn eigenvalues(&self, wave_vectors: &[SVector<f64, D>]) -> Option<(Vec<Pair<Lanes>>, Lanes)> {
        Lanes::vectorized(Eigenvalues {
            sum: self,
            phases: &self.phases(wave_vectors),
            drift: self.drift_at(wave_vectors),
        })
    }

    /// Sum of the smoothed velocities, with its phases at up to eight wave vectors.
    fn drift_at(&self, wave_vectors: &[SVector<f64, D>]) -> Option<(&Self, Vec<Pair<Lanes>>)> {
        let drift = self.drift.as_deref()?;
        Some((drift, drift.phases(wave_vectors)))
    }

    /// The sum, and its derivatives with respect to the wave vector: first ones, then second ones by `a` and `b <= a`.
    #[inline(always)]
    fn derivatives(&self, phases: &[Pair<Lanes>]) -> Vec<Vec<Pair<Lanes>>> {
        let n = self.size;
        let mut parts = vec![vec![[Lanes::constant(0.0); 2]; n * n]; 1 + D + D * (D + 1) / 2];
        let mut weighted = phases.to_vec();
        for (number, part) in parts.iter_mut().enumerate() {
            for (own, (phase, (_, vector))) in
                weighted.iter_mut().zip(phases.iter().zip(&self.cells))
            {
                let [re, im] = *phase;
                *own = match number {
                    0 => *phase,
                    _ if number <= D => [im * -vector[number - 1], re * vector[number - 1]],
                    _ => {
                        let (a, b) = pair_of(number - 1 - D);
                        let square = -vector[a] * vector[b];
                        [re * square, im * square]
                    }
                };
            }
            self.summed(&weighted, part);
            if self.is_hermitian {
                complete(n, part);
            }
        }
        parts
    }

    /// Eigenvectors at up to eight wave vectors, and the derivatives in their basis; `None` if the eigenvalue iteration does not converge.
    fn turned(&self, wave_vectors: &[SVector<f64, D>]) -> Option<Vec<Turned<D>>> {
        checkpoint();
        let (all, parts) = Lanes::vectorized(TurnedSums {
            sum: self,
            phases: &self.phases(wave_vectors),
            drift: self.drift_at(wave_vectors),
        })?;
        let n = self.size;
        let condition = all.condition();
        let lanes = 0..wave_vectors.len();
        let of_lane = |lane: usize| {
            let at = |z: &Pair<Lanes>| Complex::new(z[0].0[lane], z[1].0[lane]);
            let matrix =
                |part: &Vec<Pair<Lanes>>| DMatrix::from_row_iterator(n, n, part.iter().map(at));
            Turned {
                values: all.values.iter().map(at).collect(),
                condition: condition.0[lane],
                parts: parts.iter().map(matrix).collect(),
            }
        };
        Some(lanes.map(of_lane).collect())
    }
}

/// Phases of cells as products of powers.
struct Phases<'a, const D: usize> {
    cells: &'a [([i32; D], SVector<f64, D>)],
    steps: [Pair<Lanes>; D],
    reach: usize,
}

impl<const D: usize> Work for Phases<'_, D> {
    type Output = Vec<Pair<Lanes>>;

    #[inline(always)]
    fn done(self) -> Vec<Pair<Lanes>> {
        let one = [Lanes::constant(1.0), Lanes::constant(0.0)];
        let mut powers = vec![one; D * (self.reach + 1)];
        for n in D..powers.len() {
            powers[n] = times(powers[n - D], self.steps[n % D]);
        }
        let mut phases = Vec::with_capacity(self.cells.len());
        for (cell, _) in self.cells {
            let mut phase = one;
            for d in 0..D {
                let power = powers[D * cell[d].unsigned_abs() as usize + d];
                let turn = match cell[d] {
                    0 => continue,
                    1.. => power,
                    _ => [power[0], -power[1]],
                };
                phase = times(phase, turn);
            }
            phases.push(phase);
        }
        phases
    }
}

/// Eigenvectors of a system in lanes, and the derivatives of its matrix in their basis: first derivatives, then second ones by `a` and `b <= a`.
struct TurnedSums<'a, const D: usize> {
    sum: &'a FlatSum<'a, D>,
    phases: &'a [Pair<Lanes>],
    drift: Option<(&'a FlatSum<'a, D>, Vec<Pair<Lanes>>)>,
}

impl<const D: usize> Work for TurnedSums<'_, D> {
    type Output = Option<(Eigenvectors<Lanes>, Vec<Vec<Pair<Lanes>>>)>;

    #[inline(always)]
    fn done(self) -> Self::Output {
        let n = self.sum.size;
        let mut parts = self.sum.derivatives(self.phases);
        if let Some((drift, phases)) = &self.drift {
            parts = products::<D>(n, &parts, &drift.derivatives(phases));
        }
        let mut parts = parts.into_iter();
        let mut matrix = parts.next()?;
        let all = match self.sum.is_hermitian {
            true => Eigenvectors::of_hermitian(n, &mut matrix),
            false => Eigenvectors::of(n, &matrix)?,
        };
        let mut half = matrix;
        let turned = parts.map(|mut part| {
            multiply(n, &all.left, &part, &mut half);
            multiply(n, &half, &all.right, &mut part);
            part
        });
        let turned = turned.collect();
        Some((all, turned))
    }
}

/// Product of two matrices with their derivatives, by Leibniz' rule.
#[inline(always)]
fn products<const D: usize>(
    n: usize,
    x: &[Vec<Pair<Lanes>>],
    y: &[Vec<Pair<Lanes>>],
) -> Vec<Vec<Pair<Lanes>>> {
    let zero = [Lanes::constant(0.0); 2];
    let mut term = vec![zero; n * n];
    let mut product = |factors: &[(usize, usize)]| {
        let mut sum = vec![zero; n * n];
        for (i, j) in factors {
            multiply(n, &x[*i], &y[*j], &mut term);
            for (sum, term) in sum.iter_mut().zip(&term) {
                *sum = [sum[0] + term[0], sum[1] + term[1]];
            }
        }
        sum
    };
    let order = |number: usize| match number {
        0 => product(&[(0, 0)]),
        _ if number <= D => product(&[(number, 0), (0, number)]),
        _ => {
            let (a, b) = pair_of(number - 1 - D);
            product(&[(number, 0), (1 + a, 1 + b), (1 + b, 1 + a), (0, number)])
        }
    };
    (0..x.len()).map(order).collect()
}

/// Axes `a` and `b <= a` of the second derivative with a number.
#[inline(always)]
fn pair_of(number: usize) -> (usize, usize) {
    let a = if number == 0 {
        0
    } else if number < 3 {
        1
    } else {
        2
    };
    (a, number - a * (a + 1) / 2)
}

/// Sets the lower triangle of a Hermitian matrix from the upper one.
#[inline(always)]
fn complete(n: usize, matrix: &mut [Pair<Lanes>]) {
    for i in 0..n {
        for j in 0..i {
            let [re, im] = matrix[j * n + i];
            matrix[i * n + j] = [re, -im];
        }
        matrix[i * n + i][1] = Lanes::constant(0.0);
    }
}

/// Product of two matrices by rows.
#[inline(always)]
fn multiply(n: usize, left: &[Pair<Lanes>], right: &[Pair<Lanes>], into: &mut [Pair<Lanes>]) {
    for i in 0..n {
        for j in 0..n {
            let mut entry = [Lanes::constant(0.0); 2];
            for l in 0..n {
                let term = times(left[i * n + l], right[l * n + j]);
                entry = [entry[0] + term[0], entry[1] + term[1]];
            }
            into[i * n + j] = entry;
        }
    }
}

/// Eigenvalues of matrices in lanes, and the norms of the matrices; `None` if the iteration does not converge.
struct Eigenvalues<'a, const D: usize> {
    sum: &'a FlatSum<'a, D>,
    phases: &'a [Pair<Lanes>],
    drift: Option<(&'a FlatSum<'a, D>, Vec<Pair<Lanes>>)>,
}

impl<const D: usize> Work for Eigenvalues<'_, D> {
    type Output = Option<(Vec<Pair<Lanes>>, Lanes)>;

    #[inline(always)]
    fn done(self) -> Self::Output {
        let n = self.sum.size;
        let zero = [Lanes::constant(0.0); 2];
        let mut matrix = vec![zero; n * n];
        self.sum.summed(self.phases, &mut matrix);
        if let Some((drift, phases)) = &self.drift {
            let (mut smoothing, stiffness) = (vec![zero; n * n], matrix.clone());
            drift.summed(phases, &mut smoothing);
            multiply(n, &stiffness, &smoothing, &mut matrix);
        }
        let mut squares = zero[0];
        for z in &matrix {
            squares = squares + z[0] * z[0] + z[1] * z[1];
        }
        let norm = squares.sqrt();
        let is_found = if self.sum.is_hermitian {
            diagonalize(n, &mut matrix, &mut []);
            true
        } else {
            // The rows are taken for columns: the transposed matrix has the same eigenvalues.
            triangular(n, &mut matrix, &mut [])
        };
        is_found.then(|| ((0..n).map(|i| matrix[i * n + i]).collect(), norm))
    }
}

impl<const D: usize> Sampled<D> for FlatSum<'_, D> {
    fn spectra(&self, wave_vectors: &[SVector<f64, D>]) -> Spectra {
        let n = self.size;
        let mut values = Vec::with_capacity(n * wave_vectors.len());
        if let ([k], true) = (wave_vectors, n > LONE_ROWS) {
            let values = self.system.omega_squared(k);
            return Spectra { size: n, values };
        }
        for several in wave_vectors.chunks(LANES) {
            checkpoint();
            let Some((all, norm)) = self.eigenvalues(several) else {
                values.extend(several.iter().flat_map(|k| self.system.omega_squared(k)));
                continue;
            };
            for lane in 0..several.len() {
                let start = values.len();
                if self.is_hermitian {
                    values.extend(all.iter().map(|z| Complex::from(z[0].0[lane])));
                } else {
                    values.extend(all.iter().map(|z| Complex::new(z[0].0[lane], z[1].0[lane])));
                    without_rounding(&mut values[start..], norm.0[lane], self.noise);
                }
                values[start..].sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
            }
        }
        Spectra { size: n, values }
    }

    fn around(&self, wave_vectors: &[SVector<f64, D>]) -> Vec<Around<D>> {
        let of_several = |several: &[SVector<f64, D>]| match self.turned(several) {
            Some(all) => all.into_iter().map(Around::Turned).collect(),
            None => self.system.around(several),
        };
        wave_vectors.chunks(LANES).flat_map(of_several).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{FlatSum, Sampled, WaveSystem};
    use crate::algebra::{Complex, uniform};
    use crate::bloch::branches::Taylor;
    use crate::bloch::{BlochBlocks, Mass};
    use crate::lattice::{BravaisLattice, Crystal, Particle};
    use nalgebra::{SMatrix, SVector};

    /// Random blocks between random neighbors in a random lattice.
    fn random_system<const D: usize>(seed: u64, sites: usize, is_hermitian: bool) -> WaveSystem<D> {
        let mut state = seed;
        let mut number = || 2.0 * uniform(&mut state) - 1.0;
        let vectors =
            SMatrix::<f64, D, D>::from_fn(|i, j| f64::from(u8::from(i == j)) + 0.2 * number());
        let lattice = BravaisLattice::new(vectors).expect("a lattice");
        let places = (0..sites).map(|n| SVector::repeat(n as f64 / sites as f64));
        let crystal = Crystal::new(lattice, places.collect()).expect("a crystal");
        let mut sums = [BlochBlocks::new(), BlochBlocks::new()];
        for sum in &mut sums {
            for _ in 0..12 * sites {
                let site = |x: f64| ((0.5 + 0.49 * x) * sites as f64) as usize;
                let from = Particle::home(site(number()));
                let cell = std::array::from_fn(|_| (2.4 * number()).round() as i32);
                let to = Particle::home(site(number())).moved(&cell);
                let block = SMatrix::<f64, D, D>::from_fn(|_, _| number());
                sum.add(&from, &to, &block);
                if is_hermitian {
                    sum.add(&to, &from, &block.transpose());
                }
            }
        }
        let [stiffness, drift] = sums.map(|sum| sum.sum(&crystal));
        let masses = (0..sites).map(|_| 1.5 + number()).collect();
        let system = WaveSystem::new(crystal, stiffness, Mass::Lumped(masses));
        assert_eq!(system.is_hermitian(), is_hermitian);
        match !is_hermitian && seed.is_multiple_of(2) {
            true => system.with_drift(drift),
            false => system,
        }
    }

    fn assert_alike<const D: usize>(seed: u64, sites: usize, is_hermitian: bool) {
        let system = random_system::<D>(seed, sites, is_hermitian);
        let sum = FlatSum::of_system(&system).expect("a small cell");
        let mut state = seed + 100;
        let waves: Vec<SVector<f64, D>> = (0..11)
            .map(|_| SVector::from_fn(|_, _| 6.0 * uniform(&mut state) - 3.0))
            .collect();
        let spectra = [sum.spectra(&waves), (&system).spectra(&waves)];
        let scale = system.noise() / f64::EPSILON;
        for (own, known) in spectra[0].iter().zip(spectra[1].iter()) {
            for (own, known) in own.iter().zip(known) {
                assert!(
                    (own - known).norm() < 1e-9 * scale,
                    "{D} {seed} {own} {known}"
                );
            }
        }
        for k in &waves[..3] {
            for number in [0, D * sites - 1] {
                let order = |z: Complex| z.re;
                let branch =
                    |of: &dyn Sampled<D>| of.branches(&[*k], &order, &[number]).pop().flatten();
                let own = &branch(&sum).expect("a branch");
                let known = &branch(&&system).expect("a branch");
                let parts = |of: &Taylor<Complex, D>| {
                    let gradient = of.gradient.into_iter();
                    let hessian = of.hessian.as_flattened().to_vec();
                    std::iter::once(of.value).chain(gradient).chain(hessian)
                };
                let size = parts(known).fold(scale, |most, z| most.max(z.norm()));
                for (own, known) in parts(own).zip(parts(known)) {
                    assert!(
                        (own - known).norm() < 1e-7 * size,
                        "{D} {seed} {own} {known}"
                    );
                }
            }
        }
    }

    #[test]
    fn flat_sums_and_their_systems_have_equal_spectra_and_branches() {
        for seed in 1..20 {
            for is_hermitian in [true, false] {
                assert_alike::<1>(seed, 1 + seed as usize % 4, is_hermitian);
                assert_alike::<2>(seed, 1 + seed as usize % 4, is_hermitian);
                assert_alike::<3>(seed, 1 + seed as usize % 3, is_hermitian);
            }
        }
    }
}
