//! Stress measures and elasticity tensors derived from `P` and `A`.

use super::{MaterialError, PlaneTangent, Response};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use nalgebra::Matrix3;
use std::ops::{Index, IndexMut};

/// Fourth-order tensor in three dimensions, indexed as `tensor[(i, j, k, l)]`.
#[derive(Clone, Debug, PartialEq)]
pub struct FourthOrder([[[[f64; 3]; 3]; 3]; 3]);

impl FourthOrder {
    /// Creates the tensor with components `component(i, j, k, l)`.
    pub fn from_fn(component: impl Fn(usize, usize, usize, usize) -> f64) -> Self {
        let mut tensor = Self([[[[0.0; 3]; 3]; 3]; 3]);
        for (i, j, k, l) in indices() {
            tensor[(i, j, k, l)] = component(i, j, k, l);
        }
        tensor
    }

    /// Returns true if every component is a finite number.
    pub fn is_finite(&self) -> bool {
        self.0
            .as_flattened()
            .as_flattened()
            .as_flattened()
            .iter()
            .all(|value| value.is_finite())
    }

    /// Largest component in magnitude.
    ///
    /// ```
    /// use onset::material::FourthOrder;
    /// let tensor = FourthOrder::from_fn(|i, j, k, l| if (i, j, k, l) == (0, 1, 2, 0) { -3.0 } else { 1.0 });
    /// assert_eq!(tensor.largest(), 3.0);
    /// ```
    pub fn largest(&self) -> f64 {
        let components = self.0.as_flattened().as_flattened().as_flattened().iter();
        components.fold(0.0, |largest: f64, value| largest.max(value.abs()))
    }

    /// Pull-back `A_iJkL = J F^-1_Jj F^-1_Ll a_ijkl` of a spatial tangent `a_ijkl`, the inverse of [`Response::spatial_tangent`].
    ///
    /// ```
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
    /// let f = DeformationGradient::from_stretches([1.2, 0.8, 1.1])?;
    /// let response = ModifiedMooneyRivlin::default().response(&f)?;
    /// let back = response.spatial_tangent().pulled_back(&f);
    /// assert!((back[(0, 1, 1, 0)] - response.tangent[(0, 1, 1, 0)]).abs() < 1e-13 * response.tangent.largest());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pulled_back(&self, f: &DeformationGradient) -> Self {
        // The determinant of a checked deformation gradient is positive.
        let inverse = f.matrix().try_inverse().unwrap_or_else(Matrix3::zeros);
        let (jacobian, own) = (f.jacobian(), self.with_material_indices(&inverse));
        Self::from_fn(|i, m, k, n| jacobian * own[(i, m, k, n)])
    }

    /// Double contraction `T_ijkl X_kl` with a matrix.
    pub(crate) fn contracted(&self, x: &Matrix3<f64>) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| {
            (0..9)
                .map(|n| self[(i, j, n / 3, n % 3)] * x[(n / 3, n % 3)])
                .sum()
        })
    }

    /// Part with indices 0 and 1 only, `T_iJkL` at `[2 i + J][2 k + L]`.
    pub fn in_plane(&self) -> PlaneTangent {
        array_of(|a| array_of(|b| self[(a / 2, a % 2, b / 2, b % 2)]))
    }

    /// Transforms the second and the fourth index by a matrix: `m_Jj m_Ll T_ijkl`.
    pub(crate) fn with_material_indices(&self, m: &Matrix3<f64>) -> Self {
        let half = Self::from_fn(|i, a, k, l| (0..3).map(|j| m[(a, j)] * self[(i, j, k, l)]).sum());
        Self::from_fn(|i, a, k, b| (0..3).map(|l| m[(b, l)] * half[(i, a, k, l)]).sum())
    }

    /// Transforms the first and the third index by a matrix: `m_iI m_kK T_IjKl`.
    pub(super) fn with_spatial_indices(&self, m: &Matrix3<f64>) -> Self {
        let half = Self::from_fn(|a, j, k, l| (0..3).map(|i| m[(a, i)] * self[(i, j, k, l)]).sum());
        Self::from_fn(|a, j, b, l| (0..3).map(|k| m[(b, k)] * half[(a, j, k, l)]).sum())
    }

    /// Transforms all four indices by a matrix: `m_iI m_jJ m_kK m_lL T_IJKL`.
    pub(crate) fn transformed(&self, m: &Matrix3<f64>) -> Self {
        // One index at a time: 4 x 3^5 products instead of 3^8.
        let first =
            Self::from_fn(|i, j, k, l| (0..3).map(|a| m[(i, a)] * self[(a, j, k, l)]).sum());
        let second =
            Self::from_fn(|i, j, k, l| (0..3).map(|a| m[(j, a)] * first[(i, a, k, l)]).sum());
        let third =
            Self::from_fn(|i, j, k, l| (0..3).map(|a| m[(k, a)] * second[(i, j, a, l)]).sum());
        Self::from_fn(|i, j, k, l| (0..3).map(|a| m[(l, a)] * third[(i, j, k, a)]).sum())
    }
}

impl Index<(usize, usize, usize, usize)> for FourthOrder {
    type Output = f64;
    fn index(&self, (i, j, k, l): (usize, usize, usize, usize)) -> &f64 {
        &self.0[i][j][k][l]
    }
}

impl IndexMut<(usize, usize, usize, usize)> for FourthOrder {
    fn index_mut(&mut self, (i, j, k, l): (usize, usize, usize, usize)) -> &mut f64 {
        &mut self.0[i][j][k][l]
    }
}

fn indices() -> impl Iterator<Item = (usize, usize, usize, usize)> {
    (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
}

fn delta(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

impl Response {
    /// Mean Cauchy stress in the first `n` dimensions, positive in tension. Units of stress.
    pub fn mean_stress(&self, n: usize) -> f64 {
        let cauchy = self.cauchy();
        (0..n).map(|i| cauchy[(i, i)]).sum::<f64>() / n as f64
    }

    /// Part of the response from the mean stress, `P = (P : F)/n F^-T`, in the first `n` dimensions.
    ///
    /// # Errors
    /// [`MaterialError::NotFinite`] if it over- or underflows.
    pub(crate) fn of_mean_stress(self, n: usize) -> Result<Self, MaterialError> {
        let jacobian = self.deformation.jacobian();
        let inverse = self.deformation.matrix().try_inverse();
        let inverse = inverse.ok_or(MaterialError::NotFinite { jacobian })?;
        let is_within = |indices: &[usize]| indices.iter().all(|index| *index < n);
        let (f, stress) = (self.deformation.matrix(), &self.first_piola);
        let entries = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let mean = entries().map(|own| stress[own] * f[own]).sum::<f64>() / n as f64;
        let change = Matrix3::from_fn(|k, l| {
            let tangent = entries().map(|(i, j)| self.tangent[(i, j, k, l)] * f[(i, j)]);
            (tangent.sum::<f64>() + stress[(k, l)]) / n as f64
        });
        Self {
            first_piola: Matrix3::from_fn(|i, j| match is_within(&[i, j]) {
                true => mean * inverse[(j, i)],
                false => 0.0,
            }),
            tangent: FourthOrder::from_fn(|i, j, k, l| match is_within(&[i, j, k, l]) {
                true => change[(k, l)] * inverse[(j, i)] - mean * inverse[(j, k)] * inverse[(l, i)],
                false => 0.0,
            }),
            ..self
        }
        .finite()
    }

    /// Returns the response if energy, stress and tangent neither over- nor underflow.
    ///
    /// # Errors
    /// [`MaterialError::NotFinite`] with the Jacobian of the state.
    pub fn finite(self) -> Result<Self, MaterialError> {
        let is_finite = self.energy.is_finite()
            && self.first_piola.iter().all(|value| value.is_finite())
            && self.tangent.is_finite();
        if is_finite {
            Ok(self)
        } else {
            Err(MaterialError::NotFinite {
                jacobian: self.deformation.jacobian(),
            })
        }
    }

    /// Second Piola-Kirchhoff stress `S = F^-1 P`. Material indices, units of stress.
    pub fn second_piola(&self) -> Matrix3<f64> {
        self.inverse_deformation() * self.first_piola
    }

    /// Cauchy stress `sigma = P F^T / J`, equation (13). Spatial indices, units of stress.
    pub fn cauchy(&self) -> Matrix3<f64> {
        self.first_piola * self.deformation.matrix().transpose() / self.deformation.jacobian()
    }

    /// Second elasticity tensor `C^SE_IJKL = dS_IJ/dE_KL`, equation (8), from `A_iJkL = F_iR F_kP C^SE_RJPL + delta_ik S_JL`. Material indices, units
    /// of stress.
    pub fn second_elasticity(&self) -> FourthOrder {
        let g = self.inverse_deformation();
        let s = self.second_piola();
        let geometric_free =
            FourthOrder::from_fn(|i, j, k, l| self.tangent[(i, j, k, l)] - delta(i, k) * s[(j, l)]);
        let first = FourthOrder::from_fn(|r, j, k, l| {
            (0..3)
                .map(|i| g[(r, i)] * geometric_free[(i, j, k, l)])
                .sum()
        });
        FourthOrder::from_fn(|r, j, p, l| (0..3).map(|k| g[(p, k)] * first[(r, j, k, l)]).sum())
    }

    /// Fourth elasticity tensor `C^tau_ijkl = F_im F_jn F_kp F_lq C^SE_mnpq`, equation (10): the convected rate of Kirchhoff stress per rate of
    /// deformation. Spatial indices, units of stress.
    pub fn fourth_elasticity(&self) -> FourthOrder {
        self.second_elasticity()
            .transformed(&self.deformation.matrix())
    }

    /// Truesdell tangent `C^sigmaT = C^tau / J`, equation (11). Spatial indices, units of stress.
    pub fn truesdell_tangent(&self) -> FourthOrder {
        let tau = self.fourth_elasticity();
        let jacobian = self.deformation.jacobian();
        FourthOrder::from_fn(|i, j, k, l| tau[(i, j, k, l)] / jacobian)
    }

    /// Effective tangent (22) of the paper: nominal stress per deformation gradient. With the nominal stress `P^T` (first index material) its
    /// components are `C_jikl = A_iJkL`.
    pub fn effective_tangent(&self) -> FourthOrder {
        FourthOrder::from_fn(|j, i, k, l| self.tangent[(i, j, k, l)])
    }

    /// Spatial tangent `a_ijkl = F_jJ F_lL A_iJkL / J = C^sigmaT_ijkl + delta_ik sigma_jl`. The acoustic tensor of a spatial direction `n` is
    /// `a_ijkl n_j n_l`. Units of stress.
    pub fn spatial_tangent(&self) -> FourthOrder {
        let f = self.deformation.matrix();
        let jacobian = self.deformation.jacobian();
        let pushed = FourthOrder::from_fn(|i, j, k, l| {
            (0..3).map(|m| f[(j, m)] * self.tangent[(i, m, k, l)]).sum()
        });
        FourthOrder::from_fn(|i, j, k, l| {
            (0..3)
                .map(|m| f[(l, m)] * pushed[(i, j, k, m)])
                .sum::<f64>()
                / jacobian
        })
    }

    /// Effective tangent (50): the Cauchy stress per displacement gradient, `d sigma_ij / d u_k,l = a_ijkl - sigma_ij delta_kl + sigma_il delta_jk`.
    /// Spatial indices, units of stress.
    pub fn effective_cauchy_tangent(&self) -> FourthOrder {
        let a = self.spatial_tangent();
        let sigma = self.cauchy();
        FourthOrder::from_fn(|i, j, k, l| {
            a[(i, j, k, l)] - sigma[(i, j)] * delta(k, l) + sigma[(i, l)] * delta(j, k)
        })
    }

    fn inverse_deformation(&self) -> Matrix3<f64> {
        // The determinant of a checked deformation gradient is positive.
        self.deformation
            .matrix()
            .try_inverse()
            .unwrap_or_else(Matrix3::zeros)
    }
}
