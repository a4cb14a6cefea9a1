//! The long-wave limit of a discretization: the continuum that it actually represents.

use super::{Mass, WaveSystem};
use crate::algebra::{Complex, MAXIMUM_ITERATIONS};
use crate::continuum::Stiffness;
use crate::lattice::Particle;
use nalgebra::{DMatrix, SMatrix, SVector};

/// Largest stiffness of a free internal displacement, relative to the largest entry of `D(0)`. It is well above the rounding error of sums.
const FREE_STIFFNESS_FRACTION: f64 = 1e-10;

/// Rounding error of a lattice sum, in units of `f64::EPSILON` times its largest terms. A heuristic value.
const SUM_ROUNDING_FACTOR: f64 = 1024.0;

/// Inverse of a matrix, or its pseudoinverse if some displacements are free of energy. Free displacements cause no force and do not contribute to the
/// relaxation.
fn inverse(matrix: DMatrix<Complex>) -> DMatrix<Complex> {
    let largest = |matrix: &DMatrix<Complex>| matrix.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let scale = largest(&matrix);
    // Elimination for any size: cofactors lose nearly free displacements, because the determinant contains the product of their stiffnesses.
    let regular = matrix.clone().lu().try_inverse();
    if let Some(regular) =
        regular.filter(|inverse| largest(inverse) * scale < FREE_STIFFNESS_FRACTION.recip())
    {
        return regular;
    }
    let size = matrix.nrows();
    let svd = matrix.try_svd(true, true, f64::EPSILON, MAXIMUM_ITERATIONS * size);
    let pseudo = svd.and_then(|svd| svd.pseudo_inverse(FREE_STIFFNESS_FRACTION * scale).ok());
    pseudo.unwrap_or_else(|| DMatrix::repeat(size, size, Complex::new(f64::NAN, 0.0)))
}

/// Relaxation of the particles of a cell: the part that does not depend on the direction of the wave.
struct Relaxation {
    /// Dynamical matrix `D(0)` at `k = 0`.
    d0: DMatrix<Complex>,
    /// Rigid translations `R`, as columns.
    translations: DMatrix<Complex>,
    /// Duals `Y` of the translations, as rows: `Y^T D0 = 0`, `Y^T R = 1`.
    duals: DMatrix<Complex>,
    /// Inverse of `D0` on the internal displacements, defined by `Y^T u = 0`.
    internal: DMatrix<Complex>,
}

impl Relaxation {
    /// Computes the relaxation from `D0`, the magnitude of the terms of its sum, the translations and `L`. `L^T u` with `L^T R = 1` is the mean
    /// displacement, weighted with the masses.
    fn new(
        d0: DMatrix<Complex>,
        magnitude: f64,
        translations: DMatrix<Complex>,
        mean: &DMatrix<Complex>,
    ) -> Self {
        let mean = mean.transpose();
        // Stiffness that replaces the zero stiffness of translations, of the magnitude of `D0`.
        let size = d0.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let unit = Complex::from(if size > 0.0 { size } else { 1.0 });
        // If the forces add up to zero, `Y = L`. In general, `S = D0 + s R L^T` satisfies `Y^T S = s L^T`.
        let duals = if (&mean * &d0).norm() <= FREE_STIFFNESS_FRACTION * magnitude {
            mean
        } else {
            let moved = &translations * &mean * unit;
            &mean * inverse(&d0 + moved) * unit
        };
        let projector = &translations * &duals;
        // On the internal displacements this matrix is `D0`, on the translations `s`.
        let internal = inverse(&d0 + &projector * unit) - projector / unit;
        Self {
            d0,
            translations,
            duals,
            internal,
        }
    }
}

impl<const D: usize> WaveSystem<D> {
    /// Long-wavelength stiffness per density `T`, with `D(k) -> T_iJkL k_J k_L` on the acoustic branches. Length^2/time^2.
    ///
    /// It includes the relaxation of the particles of a cell. With the translations `R` and their duals `Y`, `Y^T D0 = 0`, second-order perturbation
    /// theory gives `T = Y^T (D2 - D1 G D1) R`, where `G` is the inverse of `D0` on the internal displacements. If the forces do not add up to zero,
    /// the term `Y^T D1 R`, linear in the wave number, need not vanish. Such waves grow at any length, and the search finds them at finite lengths.
    pub fn long_wave_stiffness(&self) -> Stiffness<D> {
        self.relaxed_stiffness(&self.relaxation())
    }

    /// Long-wave stiffness with two estimates of its rounding error.
    ///
    /// The first estimate covers the sums, in which the forces of relaxing particles cancel others. The second estimate adds the error of `D0`, which
    /// `G = D0^-1` changes to `G dD0 G`.
    pub(super) fn long_waves(&self) -> (Stiffness<D>, [f64; 2]) {
        let relaxation = self.relaxation();
        (
            self.relaxed_stiffness(&relaxation),
            self.relaxation_noise(&relaxation),
        )
    }

    fn relaxed_stiffness(&self, relaxation: &Relaxation) -> Stiffness<D> {
        let unit = |i: usize| SVector::<f64, D>::from_fn(|j, _| f64::from(u8::from(i == j)));
        let along = |direction: &SVector<f64, D>| self.acoustic(relaxation, direction);
        let squares: Vec<SMatrix<f64, D, D>> = (0..D).map(|j| along(&unit(j))).collect();
        // `T(n)` is a quadratic form in `n`: its mixed terms follow from the values along diagonals.
        let mixed: Vec<Vec<SMatrix<f64, D, D>>> = (0..D)
            .map(|j| {
                (0..D)
                    .map(|l| {
                        if j == l {
                            squares[j]
                        } else {
                            let sum = along(&(unit(j) + unit(l)));
                            (sum - squares[j] - squares[l]) * 0.5
                        }
                    })
                    .collect()
            })
            .collect();
        Stiffness::from_fn(|i, j, k, l| mixed[j][l][(i, k)])
    }

    /// Acoustic tensor `T_iJkL n_J n_L`.
    fn acoustic(&self, relaxation: &Relaxation, direction: &SVector<f64, D>) -> SMatrix<f64, D, D> {
        let Relaxation {
            translations,
            duals,
            internal,
            ..
        } = relaxation;
        let [d1, d2] = self.orders(relaxation, direction);
        let relaxed = internal * (&d1 * translations);
        let limit = duals * (d2 * translations - d1 * relaxed);
        SMatrix::from_fn(|i, k| limit[(i, k)].re)
    }

    fn relaxation_noise(&self, relaxation: &Relaxation) -> [f64; 2] {
        let origin = |site: usize| self.crystal.position(&Particle::home(site));
        let moment = |(from, to, block): (usize, &Particle<D>, &SMatrix<f64, D, D>)| {
            block.amax() * (self.crystal.position(to) - origin(from)).norm_squared()
        };
        let direct = self.stiffness.blocks().map(moment).sum::<f64>() / self.cell_mass();
        let flexibility = relaxation.internal.norm();
        let relaxed = (0..D).map(|j| {
            let along = SVector::from_fn(|i, _| f64::from(u8::from(i == j)));
            let [d1, _] = self.orders(relaxation, &along);
            let (from, to) = (&d1 * &relaxation.translations, &relaxation.duals * &d1);
            let relaxed = from.norm() * flexibility * to.norm();
            [relaxed, relaxed * flexibility * self.size_of_sums()]
        });
        let [relaxed, conditioned] = relaxed
            .filter(|x| x.iter().all(|x| x.is_finite()))
            .fold([0.0_f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let sums = SUM_ROUNDING_FACTOR * f64::EPSILON * (direct + relaxed);
        [
            sums,
            sums + SUM_ROUNDING_FACTOR * f64::EPSILON * conditioned,
        ]
    }

    /// `D(0)` on the rigid translations: zero unless a translation strains the body. 1/time^2.
    pub fn rigid_translation(&self) -> SMatrix<f64, D, D> {
        let rows = self.stiffness.row_sums();
        let total = self.cell_mass();
        let sum: SMatrix<f64, D, D> = rows.into_iter().sum();
        let sum = sum / total;
        let zero = 1e-10 * self.stiffness.magnitude() / total;
        if sum.amax() <= zero {
            SMatrix::zeros()
        } else {
            sum
        }
    }

    /// Mass of a cell.
    pub fn cell_mass(&self) -> f64 {
        self.particle_masses().iter().sum()
    }

    /// Magnitude of the terms that add up to `D(k)`. 1/time^2.
    fn size_of_sums(&self) -> f64 {
        self.noise() / f64::EPSILON
    }

    fn relaxation(&self) -> Relaxation {
        let zero = SVector::zeros();
        let translations = DMatrix::from_fn(self.size(), D, |row, i| {
            Complex::new(f64::from(u8::from(row % D == i)), 0.0)
        });
        let weighted = self.mass_at(&zero).transpose() * &translations;
        let mean = weighted / Complex::new(self.cell_mass(), 0.0);
        let d0 = self.dynamical_matrix_at(&zero);
        Relaxation::new(d0, self.size_of_sums(), translations, &mean)
    }

    /// Coefficients `D1` and `D2` of `D(t n) = D0 + t D1 + t^2 D2 + ...` along a direction.
    fn orders(
        &self,
        relaxation: &Relaxation,
        direction: &SVector<f64, D>,
    ) -> [DMatrix<Complex>; 2] {
        let (size, zero) = (self.size(), SVector::zeros());
        let moved = |order: usize| -> DMatrix<Complex> {
            let stiffness = |n: usize| self.stiffness.taylor(direction, n);
            match &self.drift {
                None => stiffness(order),
                Some(drift) => (0..=order)
                    .map(|n| stiffness(n) * drift.taylor(direction, order - n))
                    .fold(DMatrix::zeros(size, size), |sum, term| sum + term),
            }
        };
        let [k1, k2] = [moved(1), moved(2)];
        // `M(t n) D(t n) = K T` order by order, because a consistent mass matrix depends on the wave vector too.
        match &self.mass {
            Mass::Lumped(_) => [k1, k2].map(|matrix| self.divided_by_mass(&zero, matrix)),
            Mass::Consistent(mass) => {
                let (m1, m2) = (mass.taylor(direction, 1), mass.taylor(direction, 2));
                let d1 = self.divided_by_mass(&zero, k1 - &m1 * &relaxation.d0);
                let d2 = self.divided_by_mass(&zero, k2 - &m1 * &d1 - &m2 * &relaxation.d0);
                [d1, d2]
            }
        }
    }
}
