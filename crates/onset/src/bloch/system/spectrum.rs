//! Frequencies and modes at a wave vector.

use super::{Mass, WaveSystem};
use crate::algebra::{
    Complex, MAXIMUM_ITERATIONS, any_eigenvalues, cholesky_factor, hermitian_eigen,
    hermitian_eigenvalues, sort_by_value, without_rounding,
};
use nalgebra::{DMatrix, DVector, SVector};

impl<const D: usize> WaveSystem<D> {
    /// Eigenvalues `omega^2` of `D(k)` by increasing real part, without damping. 1/time^2.
    ///
    /// NaN if the eigenvalue iteration does not converge, which happens only if entries are not finite.
    pub fn omega_squared(&self, k: &SVector<f64, D>) -> Vec<Complex> {
        if let Some((system, unit)) = self.in_moderate_units() {
            let values = system.omega_squared(k).into_iter();
            return values.map(|value| value * unit).collect();
        }
        let mut values = match self.hermitian_matrix(k) {
            Some(matrix) => hermitian_eigenvalues(matrix),
            None => general_eigenvalues(self.dynamical_matrix_at(k), self.noise()),
        };
        values.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        values
    }

    /// Eigenvalues of `D(0)`, without the zeros that belong to free translations. 1/time^2.
    ///
    /// If a translation costs no force, its zeros are removed. Their rounding error, which can be large if `D(0)` is not Hermitian, would otherwise
    /// be taken for growth.
    pub(super) fn omega_squared_at_gamma(&self) -> Vec<Complex> {
        let zero = SVector::zeros();
        if self.rigid_translation().amax() > 0.0 {
            return self.omega_squared(&zero);
        }
        if let Some(values) = self.hermitian_at_gamma() {
            return values;
        }
        // `R L^T` with `L^T R = 1` moves the zeros to `s` and leaves the other eigenvalues unchanged.
        let matrix = self.dynamical_matrix_at(&zero);
        let far = 4.0 * matrix.norm() + f64::MIN_POSITIVE;
        let share = Complex::new(far / self.sites() as f64, 0.0);
        let moved = DMatrix::from_fn(self.size(), self.size(), |i, j| {
            let is_translation = i % D == j % D;
            matrix[(i, j)]
                + if is_translation {
                    share
                } else {
                    Complex::default()
                }
        });
        self.without_largest(general_eigenvalues(moved, self.noise()))
    }

    /// Eigenvalues of `D(0)` of a Hermitian system. Adding `s M R R^T M / (R^T M R)` to the stiffness moves the zeros of the translations.
    fn hermitian_at_gamma(&self) -> Option<Vec<Complex>> {
        let zero = SVector::zeros();
        let mut stiffness = self.is_hermitian.then(|| self.stiffness.at(&zero))?;
        let own = self.symmetrized(&zero, stiffness.clone())?;
        let far = 4.0 * own.norm() + f64::MIN_POSITIVE;
        let masses = self.particle_masses();
        let share = far / self.cell_mass();
        for j in 0..self.size() {
            for i in (j % D..self.size()).step_by(D) {
                stiffness[(i, j)] += Complex::from(share * masses[i / D] * masses[j / D]);
            }
        }
        let moved = self.symmetrized(&zero, stiffness)?;
        Some(self.without_largest(hermitian_eigenvalues(moved)))
    }

    /// Removes the largest `D` eigenvalues, which belong to the translations and have been moved upward.
    fn without_largest(&self, mut values: Vec<Complex>) -> Vec<Complex> {
        values.sort_by(|a, b| b.re.total_cmp(&a.re));
        values.split_off(D.min(values.len()))
    }

    /// All undamped modes at a wave vector: `omega^2` with the unit displacements `g` of the particles of a cell, by increasing real part.
    ///
    /// The wave is `u_K = g_K exp(i k.X_K)`.
    pub fn modes(&self, k: &SVector<f64, D>) -> Vec<(Complex, DVector<Complex>)> {
        self.modes_of(k, |values| (0..values.len()).collect())
    }

    /// Undamped modes at a wave vector whose numbers `chosen` selects from the values of `omega^2`.
    pub(crate) fn modes_of(
        &self,
        k: &SVector<f64, D>,
        chosen: impl Fn(&[Complex]) -> Vec<usize>,
    ) -> Vec<(Complex, DVector<Complex>)> {
        if let Some((system, unit)) = self.in_moderate_units() {
            let modes = system.modes_of(k, chosen).into_iter();
            return modes.map(|(value, mode)| (value * unit, mode)).collect();
        }
        if let Some(modes) = self.hermitian_modes(k) {
            let values: Vec<Complex> = modes.iter().map(|mode| mode.0).collect();
            let numbers = chosen(&values).into_iter();
            return numbers.map(|n| modes[n].clone()).collect();
        }
        let matrix = self.dynamical_matrix_at(k);
        let values = self.omega_squared(k);
        // Equal eigenvalues share an eigenspace: the n-th of them takes its n-th vector.
        let scale = matrix.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let nth = |index: usize| {
            let before = values[..index].iter();
            before
                .filter(|value| (**value - values[index]).norm() <= 1e-9 * scale)
                .count()
        };
        let shown = |index: usize| {
            let vector = null_vector(&matrix, values[index], nth(index));
            (values[index], self.displaced(k, vector))
        };
        chosen(&values).into_iter().map(shown).collect()
    }

    /// Unit displacements of the particles of a cell in the mode with the given `omega^2`.
    pub(super) fn mode_of(&self, k: &SVector<f64, D>, omega_squared: Complex) -> DVector<Complex> {
        let vector = null_vector(&self.dynamical_matrix_at(k), omega_squared, 0);
        self.displaced(k, vector)
    }

    /// Frequencies with damping, largest growth rate first. 1/time.
    ///
    /// The roots `omega` of `det(omega^2 M + i omega C - K T) = 0`, two for each degree of freedom.
    pub fn frequencies(&self, k: &SVector<f64, D>) -> Vec<Complex> {
        if let Some((system, unit)) = self.in_moderate_units() {
            let values = system.frequencies(k).into_iter();
            return values.map(|value| value * unit.sqrt()).collect();
        }
        // `d/dt (u, v) = ((0, T), (-M^-1 K, -M^-1 C)) (u, v)`; with `exp(-i omega t)`, `omega` is `i` times the eigenvalue. Velocities are scaled by
        // a typical frequency, which balances the matrix.
        let n = self.size();
        let stiffness = self.divided_by_mass(k, self.stiffness.at(k));
        let norm = stiffness.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let unit = if norm > 0.0 { norm.sqrt() } else { 1.0 };
        let scale = Complex::new(unit, 0.0);
        let mut companion = DMatrix::zeros(2 * n, 2 * n);
        let drift = match &self.drift {
            Some(drift) => drift.at(k),
            None => DMatrix::identity(n, n),
        };
        companion
            .view_mut((0, n), (n, n))
            .copy_from(&(drift * scale));
        companion
            .view_mut((n, 0), (n, n))
            .copy_from(&(-stiffness / scale));
        if let Some(damping) = &self.damping {
            let damping = self.divided_by_mass(k, damping.at(k));
            companion.view_mut((n, n), (n, n)).copy_from(&-damping);
        }
        let mut values: Vec<Complex> = general_eigenvalues(companion, 0.0)
            .into_iter()
            .map(|rate| rate * Complex::i())
            .collect();
        values.sort_by(|a, b| b.im.total_cmp(&a.im).then(a.re.total_cmp(&b.re)));
        values
    }

    /// Rounding error of an entry of `D(k)`. 1/time^2.
    pub fn noise(&self) -> f64 {
        f64::EPSILON * self.stiffness.magnitude() / self.lightest_mass()
    }

    /// Smallest mass of a particle.
    fn lightest_mass(&self) -> f64 {
        let masses = self.particle_masses();
        masses.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Hermitian matrix with the eigenvalues of `D(k)`; `None` if the system is not Hermitian.
    fn hermitian_matrix(&self, k: &SVector<f64, D>) -> Option<DMatrix<Complex>> {
        match self.is_hermitian {
            true => self.symmetrized(k, self.stiffness.at(k)),
            false => None,
        }
    }

    /// Hermitian matrix `L^-1 K L^-*` with `M = L L*`; it has the eigenvalues of `M^-1 K`.
    fn symmetrized(
        &self,
        k: &SVector<f64, D>,
        mut stiffness: DMatrix<Complex>,
    ) -> Option<DMatrix<Complex>> {
        let symmetrized = match &self.mass {
            Mass::Lumped(masses) => {
                let roots: Vec<f64> = masses.iter().map(|mass| mass.sqrt()).collect();
                for (j, mut column) in stiffness.column_iter_mut().enumerate() {
                    for (i, entry) in column.iter_mut().enumerate() {
                        *entry /= roots[i / D] * roots[j / D];
                    }
                }
                stiffness
            }
            Mass::Consistent(mass) => {
                let lower = cholesky_factor(mass.at(k))?;
                let half = lower.solve_lower_triangular(&stiffness)?;
                lower.solve_lower_triangular(&half.adjoint())?
            }
        };
        Some(hermitian(symmetrized))
    }

    /// Modes of a Hermitian system by increasing `omega^2`; `None` if the system is not Hermitian.
    fn hermitian_modes(&self, k: &SVector<f64, D>) -> Option<Vec<(Complex, DVector<Complex>)>> {
        let eigen = hermitian_eigen(self.hermitian_matrix(k)?)?;
        let back = |vector: DVector<Complex>| match &self.mass {
            Mass::Lumped(masses) => Some(DVector::from_fn(vector.len(), |i, _| {
                vector[i] / masses[i / D].sqrt()
            })),
            Mass::Consistent(mass) => cholesky_factor(mass.at(k))?
                .adjoint()
                .solve_upper_triangular(&vector),
        };
        let mut modes = (0..self.size())
            .map(|n| {
                let value = Complex::new(eigen.eigenvalues[n], 0.0);
                let vector = back(eigen.eigenvectors.column(n).into_owned())?;
                Some((value, oriented(vector)))
            })
            .collect::<Option<Vec<_>>>()?;
        sort_by_value(&mut modes, |mode| mode.0.re);
        Some(modes)
    }

    /// Displacements `T v` that belong to the velocities `v` of an eigenvector of `M^-1 K T`.
    fn displaced(&self, k: &SVector<f64, D>, velocities: DVector<Complex>) -> DVector<Complex> {
        match &self.drift {
            Some(drift) => oriented(drift.at(k) * velocities),
            None => oriented(velocities),
        }
    }
}

/// Scales a vector to unit length and turns its phase so that its largest component is real and positive.
fn oriented(vector: DVector<Complex>) -> DVector<Complex> {
    let largest = vector
        .iter()
        .copied()
        .fold(Complex::new(0.0, 0.0), |best: Complex, z| {
            // The first of several components that are equal to rounding.
            if z.norm() > best.norm() * (1.0 + 1e-9) {
                z
            } else {
                best
            }
        });
    let norm = vector.norm();
    if largest.norm() == 0.0 || norm == 0.0 {
        return vector;
    }
    let turn = largest.conj() / largest.norm() / norm;
    vector.map(|z| z * turn)
}

/// Hermitian part of a matrix that is Hermitian except for rounding.
fn hermitian(matrix: DMatrix<Complex>) -> DMatrix<Complex> {
    (&matrix + matrix.adjoint()) * Complex::new(0.5, 0.0)
}

/// Eigenvalues of any complex matrix. Imaginary parts that the noise of the entries explains are set to zero.
pub(super) fn general_eigenvalues(matrix: DMatrix<Complex>, noise: f64) -> Vec<Complex> {
    let norm = matrix.norm();
    let Some(mut values) = any_eigenvalues(&matrix) else {
        return vec![Complex::new(f64::NAN, f64::NAN); matrix.nrows()];
    };
    if noise > 0.0 {
        without_rounding(&mut values, norm, noise);
    }
    values
}

/// Unit vector of an eigenspace: the `nth` right singular vector of `D - lambda`, counted from the smallest singular value.
fn null_vector(matrix: &DMatrix<Complex>, eigenvalue: Complex, nth: usize) -> DVector<Complex> {
    let size = matrix.nrows();
    let shifted = matrix - DMatrix::identity(size, size) * eigenvalue;
    let svd = shifted.try_svd(false, true, f64::EPSILON, MAXIMUM_ITERATIONS * size);
    let Some((values, adjoint)) = svd.and_then(|svd| Some((svd.singular_values, svd.v_t?))) else {
        return DVector::repeat(size, Complex::new(f64::NAN, f64::NAN));
    };
    let mut order: Vec<usize> = (0..size).collect();
    sort_by_value(&mut order, |own| values[*own]);
    adjoint.row(order[nth.min(size - 1)]).adjoint()
}
