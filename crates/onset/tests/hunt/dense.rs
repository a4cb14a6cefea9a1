//! Spectrum computed from its definition, and a dense search over the zone.

use nalgebra::{Complex, DMatrix, SMatrix, SVector, Schur};
use onset::bloch::{BlochSum, DynamicalMatrix, Mass, WaveSystem};
use onset::lattice::{BravaisLattice, Crystal, Particle};

/// Rounding error of `omega^2`, relative to its scale; it also determines the error of the difference of two equal values.
const SPECTRUM_ROUNDING: f64 = 1e-12;
/// Smallest `omega^2` of a wave without mass, relative to the scale. Such values are quotients of rounding errors: the wave vanishes at the
/// quadrature points.
const MASSLESS_RATIO: f64 = 1e8;

/// Dynamical matrix as a function of the wave vector.
type MatrixAt<const D: usize> = dyn Fn(&SVector<f64, D>) -> DMatrix<Complex<f64>>;

/// The spectrum `omega^2` as a function of the wave vector.
pub struct Waves<const D: usize> {
    pub lattice: BravaisLattice<D>,
    matrix: Box<MatrixAt<D>>,
    pub is_hermitian: bool,
    pub scale: f64,
}

/// Result of a dense search.
#[derive(Clone, Debug)]
pub struct Found<const D: usize> {
    /// Largest growth rate.
    pub growth: (f64, SVector<f64, D>),
    /// Smallest `Re omega^2`.
    pub lowest: (f64, SVector<f64, D>),
    /// Smallest `Re omega^2 / |k|_h^2`, without waves longer than a hundred cells.
    pub scaled: (f64, SVector<f64, D>),
    /// Negative of the largest `Re omega^2`.
    pub highest: (f64, SVector<f64, D>),
}

/// Growth rate of `exp(-i omega t)`.
pub fn growth(omega_squared: Complex<f64>) -> f64 {
    omega_squared.sqrt().im.abs()
}

fn summed<const D: usize>(
    crystal: &Crystal<D>,
    sum: &BlochSum<D>,
    k: &SVector<f64, D>,
) -> DMatrix<Complex<f64>> {
    let size = D * crystal.sites().len();
    let mut matrix = DMatrix::zeros(size, size);
    for (from, to, block) in sum.blocks() {
        let vector = crystal.position(to) - crystal.position(&Particle::home(from));
        let phase = Complex::new(0.0, k.dot(&vector)).exp();
        for i in 0..D {
            for j in 0..D {
                matrix[(D * from + i, D * to.site + j)] += phase * block[(i, j)];
            }
        }
    }
    matrix
}

impl<const D: usize> Waves<D> {
    /// Builds the waves from the blocks of a system: eigenvalues of `M^-1 K T`.
    pub fn of_system(system: &WaveSystem<D>) -> Self {
        let (crystal, own) = (system.crystal().clone(), system.clone());
        let matrix = move |k: &SVector<f64, D>| {
            let mut matrix = summed(&crystal, own.stiffness(), k);
            if let Some(drift) = own.drift() {
                matrix *= summed(&crystal, drift, k);
            }
            match own.mass() {
                Mass::Lumped(masses) => {
                    for (i, mut row) in matrix.row_iter_mut().enumerate() {
                        row /= Complex::new(masses[i / D], 0.0);
                    }
                    matrix
                }
                Mass::Consistent(mass) => {
                    let solved = summed(&crystal, mass, k).lu().solve(&matrix);
                    solved.unwrap_or_else(|| matrix.map(|_| Complex::new(f64::NAN, 0.0)))
                }
            }
        };
        Self::new(*system.crystal().lattice(), system.is_hermitian(), matrix)
    }

    /// Builds the waves from the force constants of one particle.
    pub fn of_matrix(lattice: BravaisLattice<D>, matrix: DynamicalMatrix<D>) -> Self {
        let is_hermitian = matrix.is_hermitian();
        let at = move |k: &SVector<f64, D>| {
            let d: SMatrix<Complex<f64>, D, D> = matrix.at(k);
            DMatrix::from_fn(D, D, |i, j| d[(i, j)])
        };
        Self::new(lattice, is_hermitian, at)
    }

    fn new(
        lattice: BravaisLattice<D>,
        is_hermitian: bool,
        matrix: impl Fn(&SVector<f64, D>) -> DMatrix<Complex<f64>> + 'static,
    ) -> Self {
        let irregular = SVector::from_fn(|i, _| [0.37, 0.21, 0.44][i]);
        let scale = matrix(&(lattice.reciprocal() * irregular)).norm();
        Self {
            lattice,
            matrix: Box::new(matrix),
            is_hermitian,
            scale,
        }
    }

    /// Eigenvalues as computed, with rounding; empty for waves without mass.
    fn eigenvalues(&self, k: &SVector<f64, D>) -> Vec<Complex<f64>> {
        let matrix = (self.matrix)(k);
        if matrix.norm() > MASSLESS_RATIO * self.scale {
            return Vec::new();
        }
        let values = Schur::try_new(matrix, f64::EPSILON, 10_000).and_then(|s| s.eigenvalues());
        values.map_or_else(Vec::new, |values| values.iter().copied().collect())
    }

    /// All `omega^2`. Imaginary parts that can be the rounding of a double eigenvalue are removed.
    pub fn omega_squared(&self, k: &SVector<f64, D>) -> Vec<Complex<f64>> {
        let values = self.eigenvalues(k);
        let explained = |n: usize| {
            let others = (0..values.len()).filter(|m| *m != n);
            let distance = others
                .map(|m| (values[m] - values[n]).norm())
                .fold(f64::INFINITY, f64::min);
            let noise = SPECTRUM_ROUNDING * self.scale;
            (noise + noise * self.scale / distance).min(1e-6 * self.scale)
        };
        let without_rounding = |n: usize| match values[n] {
            _ if self.is_hermitian => Complex::new(values[n].re, 0.0),
            value if value.norm() <= explained(n) => Complex::new(0.0, 0.0),
            value if value.im.abs() <= explained(n) => Complex::new(value.re, 0.0),
            value => value,
        };
        (0..values.len()).map(without_rounding).collect()
    }

    /// Largest growth rate at a wave vector, including possible rounding of equal eigenvalues.
    pub fn growth_with_rounding(&self, k: &SVector<f64, D>) -> f64 {
        let values = self.eigenvalues(k).into_iter();
        values.map(growth).fold(0.0, f64::max)
    }

    /// Largest growth rate at a wave vector.
    pub fn growth(&self, k: &SVector<f64, D>) -> f64 {
        let values = self.omega_squared(k).into_iter();
        values.map(growth).fold(0.0, f64::max)
    }

    fn lowest(&self, k: &SVector<f64, D>) -> f64 {
        let values = self.omega_squared(k).into_iter();
        values.map(|z| z.re).fold(f64::INFINITY, f64::min)
    }

    fn scaled(&self, k: &SVector<f64, D>) -> f64 {
        self.over_laplacian(&self.omega_squared(k), k)
    }

    fn over_laplacian(&self, values: &[Complex<f64>], k: &SVector<f64, D>) -> f64 {
        let laplacian = self.lattice.laplacian(k);
        let reciprocal = self.lattice.reciprocal().column(0).norm();
        if laplacian < (1e-2 * reciprocal).powi(2) {
            return f64::INFINITY;
        }
        // Values that may be rounding have no reliable sign, and over a small Laplacian any magnitude.
        let values = values.iter().map(|z| z.re);
        let told = values.filter(|x| self.is_hermitian || *x != 0.0);
        told.fold(f64::INFINITY, f64::min) / laplacian
    }

    fn highest(&self, k: &SVector<f64, D>) -> f64 {
        let values = self.omega_squared(k).into_iter();
        -values.map(|z| z.re).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Samples `points` wave vectors along each reciprocal vector and descends from the best `starts`.
    pub fn searched(&self, points: usize, starts: usize) -> Found<D> {
        let count = points.pow(D as u32);
        let half = (points / 2 + 1) * count / points;
        let place = |index: usize| {
            let mut rest = index;
            let mut fractional = SVector::<f64, D>::zeros();
            for i in (0..D).rev() {
                fractional[i] = (rest % points) as f64 / points as f64;
                rest /= points;
            }
            self.lattice.reciprocal() * fractional
        };
        let mut grids: [Vec<(f64, SVector<f64, D>)>; 4] = Default::default();
        for index in 1..half {
            let k = place(index);
            let values = self.omega_squared(&k);
            let lowest = values.iter().map(|z| z.re).fold(f64::INFINITY, f64::min);
            let highest = values
                .iter()
                .map(|z| z.re)
                .fold(f64::NEG_INFINITY, f64::max);
            let fastest = values.iter().map(|z| growth(*z)).fold(0.0, f64::max);
            grids[0].push((-fastest, k));
            grids[1].push((lowest, k));
            grids[2].push((self.over_laplacian(&values, &k), k));
            grids[3].push((-highest, k));
        }
        let step = self.lattice.reciprocal() / points as f64;
        let bottom = |grid: &mut Vec<(f64, SVector<f64, D>)>,
                      at: &dyn Fn(&SVector<f64, D>) -> f64| {
            grid.sort_by(|a, b| a.0.total_cmp(&b.0));
            let ends = grid
                .iter()
                .take(starts)
                .map(|start| descended(at, *start, &step));
            let best = ends.min_by(|a, b| a.0.total_cmp(&b.0));
            best.unwrap_or((f64::NAN, SVector::zeros()))
        };
        let [growing, low, scaled, high] = &mut grids;
        let (rate, k) = bottom(growing, &|k| -self.growth(k));
        Found {
            growth: (-rate, k),
            lowest: bottom(low, &|k| self.lowest(k)),
            scaled: bottom(scaled, &|k| self.scaled(k)),
            highest: bottom(high, &|k| self.highest(k)),
        }
    }
}

/// Descends along the reciprocal vectors with shrinking steps.
fn descended<const D: usize>(
    at: &dyn Fn(&SVector<f64, D>) -> f64,
    start: (f64, SVector<f64, D>),
    steps: &SMatrix<f64, D, D>,
) -> (f64, SVector<f64, D>) {
    let mut best = start;
    let mut size = 0.5;
    for _ in 0..100 {
        if size < 1e-3 {
            break;
        }
        let from = best;
        for direction in 0..2 * D {
            let sign = if direction < D { 1.0 } else { -1.0 };
            let k = from.1 + steps.column(direction % D) * (sign * size);
            let value = at(&k);
            if value < best.0 {
                best = (value, k);
            }
        }
        if best.0 >= from.0 {
            size *= 0.3;
        }
    }
    best
}
