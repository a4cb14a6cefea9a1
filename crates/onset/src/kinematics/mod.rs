//! Deformation gradient, its invariants, and straight loading paths.

use crate::algebra::Each;
use crate::real::{Real, plain};
use nalgebra::{Matrix3, SMatrix};
use thiserror::Error;

/// Deformation gradient `F_iJ = dx_i / dX_J`, always three-dimensional.
///
/// Plane strain is `F = [[F2, 0], [0, lambda3]]`, uniaxial strain `diag(lambda, 1, 1)`. Shape 3 x 3, dimensionless, first index spatial, second index
/// material.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// let f = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
/// assert!((f.jacobian() - 1.08).abs() < 1e-15);
/// # Ok::<(), onset::kinematics::KinematicsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeformationGradient<R = f64>([[R; 3]; 3]);

/// Smallest and largest admissible principal stretch.
pub const STRETCHES: (f64, f64) = (1e-6, 1e6);

/// Error of a deformation that is not admissible.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum KinematicsError {
    /// A component is not a finite number.
    #[error("the deformation gradient contains {value}, which is not a finite number")]
    NotFinite {
        /// Component that is not finite.
        value: f64,
    },
    /// A principal stretch is not positive.
    #[error("stretch {index} is {}; a stretch is a ratio of lengths and must be positive", plain(*value))]
    StretchNotPositive {
        /// Index of the stretch, counted from 1.
        index: usize,
        /// Value of the stretch.
        value: f64,
    },
    /// The determinant is not positive, which would invert the orientation of the material.
    #[error("det F = {jacobian}; it must be positive (a volume ratio)")]
    JacobianNotPositive {
        /// Determinant of the deformation gradient.
        jacobian: f64,
    },
    /// A principal stretch is too extreme for double precision to distinguish a stiffness from rounding.
    #[error(
        "the deformation is too extreme for double precision: principal stretches from {smallest:.1e} to {largest:.1e}, \
         admitted: {:e} to {:e}",
        STRETCHES.0,
        STRETCHES.1
    )]
    Extreme {
        /// Smallest principal stretch of the deformation.
        smallest: f64,
        /// Largest principal stretch of the deformation.
        largest: f64,
    },
    /// Start and end of a path are equal.
    #[error("the start and the end of the path are equal")]
    EmptyPath,
    /// A loading has no state with free faces on the branch that begins at the reference configuration.
    #[error("at the stretch {stretch} the loading has no state on its branch")]
    NoState {
        /// Imposed stretch of the missing state.
        stretch: f64,
    },
}

impl<R: Real> DeformationGradient<R> {
    /// Creates a deformation gradient from its components `F_iJ` without a check; for generic numbers.
    pub fn from_components(components: [[R; 3]; 3]) -> Self {
        Self(components)
    }

    /// Components `F_iJ` of the deformation gradient.
    pub fn components(&self) -> &[[R; 3]; 3] {
        &self.0
    }

    /// Right Cauchy-Green tensor `C_IJ = F_kI F_kJ`.
    #[inline(always)]
    pub fn right_cauchy_green(&self) -> [[R; 3]; 3] {
        let f = &self.0;
        let product =
            |i: usize, j: usize| f[0][i] * f[0][j] + f[1][i] * f[1][j] + f[2][i] * f[2][j];
        let (c01, c02, c12) = (product(0, 1), product(0, 2), product(1, 2));
        [
            [product(0, 0), c01, c02],
            [c01, product(1, 1), c12],
            [c02, c12, product(2, 2)],
        ]
    }

    /// Determinant `J = det F` of the deformation gradient.
    #[inline(always)]
    pub fn determinant(&self) -> R {
        determinant(&self.0)
    }

    /// Principal invariants of `C`.
    #[inline(always)]
    pub fn invariants(&self) -> Invariants<R> {
        let c = self.right_cauchy_green();
        let minor = |i: usize, j: usize| c[i][i] * c[j][j] - c[i][j] * c[i][j];
        // I3 = J^2 retains full accuracy where det C would cancel.
        let j = self.determinant();
        Invariants {
            first: c[0][0] + c[1][1] + c[2][2],
            second: minor(0, 1) + minor(0, 2) + minor(1, 2),
            third: j * j,
            jacobian: j,
        }
    }
}

#[inline(always)]
fn determinant<R: Real>(f: &[[R; 3]; 3]) -> R {
    f[0][0] * (f[1][1] * f[2][2] - f[1][2] * f[2][1])
        - f[0][1] * (f[1][0] * f[2][2] - f[1][2] * f[2][0])
        + f[0][2] * (f[1][0] * f[2][1] - f[1][1] * f[2][0])
}

/// Principal invariants of `C = F^T F`, and `J`.
#[derive(Clone, Copy, Debug)]
pub struct Invariants<R> {
    /// First principal invariant `I1 = tr C`.
    pub first: R,
    /// Second principal invariant `I2 = (tr(C)^2 - tr(C^2)) / 2`.
    pub second: R,
    /// Third principal invariant `I3 = det C`.
    pub third: R,
    /// Ratio of volumes `J = det F`.
    pub jacobian: R,
}

impl DeformationGradient {
    /// Returns the reference state, `F = 1`.
    pub fn identity() -> Self {
        Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    }

    /// Creates a deformation gradient from its components, with a check.
    ///
    /// # Errors
    /// [`KinematicsError`] if a component is not finite or `det F` is not a positive normal number.
    pub fn new(components: [[f64; 3]; 3]) -> Result<Self, KinematicsError> {
        if let Some(&value) = components.iter().flatten().find(|value| !value.is_finite()) {
            return Err(KinematicsError::NotFinite { value });
        }
        let f = Self(components);
        let jacobian = f.jacobian();
        if jacobian <= 0.0 && jacobian.is_finite() && !f.underflows() {
            return Err(KinematicsError::JacobianNotPositive { jacobian });
        }
        let [largest, _, smallest] = f.principal_stretches();
        if !(smallest >= STRETCHES.0 && largest <= STRETCHES.1) {
            return Err(KinematicsError::Extreme { smallest, largest });
        }
        Ok(f)
    }

    /// Creates the deformation gradient `F = diag(stretches)`.
    ///
    /// # Errors
    /// [`KinematicsError`] if a stretch is not positive and finite.
    pub fn from_stretches(stretches: [f64; 3]) -> Result<Self, KinematicsError> {
        for (index, &value) in stretches.iter().enumerate() {
            if !value.is_finite() {
                return Err(KinematicsError::NotFinite { value });
            }
            if value <= 0.0 {
                return Err(KinematicsError::StretchNotPositive {
                    index: index + 1,
                    value,
                });
            }
        }
        let mut components = [[0.0; 3]; 3];
        for i in 0..3 {
            components[i][i] = stretches[i];
        }
        Self::new(components)
    }

    /// Creates a plane-strain state from the in-plane part `[[F11, F12], [F21, F22]]` and the out-of-plane stretch.
    ///
    /// # Errors
    /// [`KinematicsError`] under the conditions of [`DeformationGradient::new`].
    pub fn plane_strain(f: [[f64; 2]; 2], out_of_plane: f64) -> Result<Self, KinematicsError> {
        Self::new([
            [f[0][0], f[0][1], 0.0],
            [f[1][0], f[1][1], 0.0],
            [0.0, 0.0, out_of_plane],
        ])
    }

    /// Ratio of volumes `J = det F`.
    pub fn jacobian(&self) -> f64 {
        self.determinant()
    }

    /// Principal stretches, largest first: the singular values of `F`.
    pub fn principal_stretches(&self) -> [f64; 3] {
        if self.is_diagonal() {
            let mut stretches = [0, 1, 2].each(|i| self.0[i][i].abs());
            stretches.sort_by(|a, b| b.total_cmp(a));
            return stretches;
        }
        // Scaled so that no square over- or underflows.
        let scale = self.matrix().amax();
        let svd = (self.matrix() / scale).try_svd(false, false, f64::EPSILON, 200);
        let mut stretches = svd.map_or([f64::NAN; 3], |svd| {
            [0, 1, 2].each(|i| svd.singular_values[i] * scale)
        });
        stretches.sort_by(|a, b| b.total_cmp(a));
        stretches
    }

    /// Returns true if a vanishing determinant can be an underflow.
    fn underflows(&self) -> bool {
        self.jacobian() == 0.0
            && self
                .0
                .iter()
                .all(|row| row.iter().any(|value| *value != 0.0))
            && self
                .0
                .iter()
                .flatten()
                .any(|value| *value != 0.0 && value.abs() < 1e-100)
    }

    /// Components as a matrix, `F_iJ` in row `i`, column `J`.
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.0[i][j])
    }

    /// Leading `D x D` block: the part of `F` that a `D`-dimensional discretization uses.
    pub fn leading<const D: usize>(&self) -> SMatrix<f64, D, D> {
        SMatrix::from_fn(|i, j| self.0[i][j])
    }

    /// Returns true if the directions beyond the `D`-th are decoupled from the first `D`, as plane strain (`D = 2`) and uniaxial strain (`D = 1`)
    /// require.
    pub fn is_block_diagonal<const D: usize>(&self) -> bool {
        (0..3).all(|i| (0..3).all(|j| (i < D) == (j < D) || self.0[i][j] == 0.0))
    }

    /// State for a law in `dimension` dimensions: the leading block, with the identity in the other directions.
    ///
    /// ```
    /// use onset::kinematics::DeformationGradient;
    /// let f = DeformationGradient::from_stretches([1.2, 0.9, 0.8])?;
    /// assert_eq!(f.given_in(2), DeformationGradient::from_stretches([1.2, 0.9, 1.0])?);
    /// # Ok::<(), onset::kinematics::KinematicsError>(())
    /// ```
    pub fn given_in(&self, dimension: usize) -> Self {
        let mut f = Self::identity();
        for i in 0..dimension.min(3) {
            f.0[i][..dimension.min(3)].copy_from_slice(&self.0[i][..dimension.min(3)]);
        }
        f
    }

    /// Returns true if all off-diagonal components are zero.
    pub fn is_diagonal(&self) -> bool {
        (0..3).all(|i| (0..3).all(|j| i == j || self.0[i][j] == 0.0))
    }

    /// Replaces the leading `D x D` block of `F`.
    pub fn with_leading<const D: usize>(&self, block: &SMatrix<f64, D, D>) -> Self {
        let mut f = *self;
        for i in 0..D {
            for j in 0..D {
                f.0[i][j] = block[(i, j)];
            }
        }
        f
    }
}

/// Path of deformation gradients over a parameter from 0 to 1.
pub trait DeformationPath {
    /// Returns the state at the path parameter `s`.
    ///
    /// # Errors
    /// [`KinematicsError`] if the path has no admissible state there.
    fn at(&self, s: f64) -> Result<DeformationGradient, KinematicsError>;
}

impl DeformationPath for StraightPath {
    fn at(&self, s: f64) -> Result<DeformationGradient, KinematicsError> {
        Self::at(self, s)
    }
}

/// Straight path of deformation gradients, `F(s) = (1 - s) F_from + s F_to`, `0 <= s <= 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightPath {
    from: DeformationGradient,
    to: DeformationGradient,
}

impl StraightPath {
    /// Creates the straight path between two states.
    ///
    /// # Errors
    /// [`KinematicsError::EmptyPath`] if both are equal.
    pub fn new(
        from: DeformationGradient,
        to: DeformationGradient,
    ) -> Result<Self, KinematicsError> {
        if from == to {
            Err(KinematicsError::EmptyPath)
        } else {
            Ok(Self { from, to })
        }
    }

    /// Returns the state at the path parameter `s`.
    ///
    /// # Errors
    /// [`KinematicsError`] if the path leaves `det F > 0`, which a straight path between two admissible states can do when they are not both
    /// diagonal.
    pub fn at(&self, s: f64) -> Result<DeformationGradient, KinematicsError> {
        // The end points are exact, not only to rounding.
        if s == 0.0 {
            return Ok(self.from);
        }
        if s == 1.0 {
            return Ok(self.to);
        }
        let mut components = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                components[i][j] = (1.0 - s) * self.from.0[i][j] + s * self.to.0[i][j];
            }
        }
        DeformationGradient::new(components)
    }
}
