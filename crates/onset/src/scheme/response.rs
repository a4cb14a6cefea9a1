//! Stress of a material near a homogeneous state, in plain or dual numbers.

use crate::algebra::array_of;
use crate::bloch::Local;
use crate::kinematics::DeformationGradient;
use crate::material::{FourthOrder, Hyperelastic, MaterialError, Response};
use crate::real::Real;

/// Law in rate form reduced to a part of its tangent: the part of the stress that is integrated in time, or the remaining part.
pub(super) struct PartOf<'a> {
    pub(super) law: &'a dyn Hyperelastic,
    pub(super) is_integrated: bool,
}

impl Hyperelastic for PartOf<'_> {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let response = self.law.response(f)?;
        let Some(integrated) = self.law.integrated_tangent(f)? else {
            return Ok(response);
        };
        let tangent = match self.is_integrated {
            true => integrated,
            false => FourthOrder::from_fn(|i, j, k, l| {
                response.tangent[(i, j, k, l)] - integrated[(i, j, k, l)]
            }),
        };
        Ok(Response {
            tangent,
            ..response
        })
    }

    fn dimension(&self) -> usize {
        self.law.dimension()
    }

    fn is_path_dependent(&self) -> bool {
        true
    }
}

/// Law reduced to its mean stress, in the dimensions of the law.
pub(super) struct MeanStress<'a>(pub(super) &'a dyn Hyperelastic);

impl Hyperelastic for MeanStress<'_> {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        self.0.response(f)?.of_mean_stress(self.0.dimension())
    }

    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn is_path_dependent(&self) -> bool {
        self.0.is_path_dependent()
    }
}

/// Law whose stress and tangent are evaluated at each deformation, even if the law is path-dependent, without a linear comparison solid.
pub(crate) struct Afresh<'a>(pub(crate) &'a dyn Hyperelastic);

impl Hyperelastic for Afresh<'_> {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        self.0.response(f)
    }

    fn dimension(&self) -> usize {
        self.0.dimension()
    }
}

/// Response of a material at a quadrature point: the stress at deformations near a homogeneous state.
///
/// Plain numbers give the stress of the law at any deformation. Dual numbers use the value and the tangent of the law at the value of the
/// deformation, so that first derivatives are exact.
/// On a lattice of fewer than three dimensions only the leading block of the deformation gradient varies; the stretches beyond it are constant.
///
/// A path-dependent law provides the state and the tangent of continued loading. Near the state it is replaced by Hill's linear comparison solid,
/// `P = P_0 + A (F - F_0)`.
#[derive(Clone, Copy)]
pub struct PointResponse<'a, const D: usize> {
    material: &'a dyn Hyperelastic,
    base: DeformationGradient,
    local: Local<D>,
    is_path_dependent: bool,
}

impl<'a, const D: usize> PointResponse<'a, D> {
    /// Evaluates the response in a homogeneous state.
    ///
    /// # Errors
    /// [`MaterialError`] if the material cannot be evaluated there.
    pub fn new(
        material: &'a dyn Hyperelastic,
        base: &DeformationGradient,
    ) -> Result<Self, MaterialError> {
        Ok(Self {
            material,
            base: *base,
            local: Local::new(material, base)?,
            is_path_dependent: material.is_path_dependent(),
        })
    }

    /// Deformation gradient of the homogeneous state.
    pub fn base(&self) -> &DeformationGradient {
        &self.base
    }

    /// Leading block of the deformation gradient of the homogeneous state.
    pub fn leading<R: Real>(&self) -> [[R; D]; D] {
        let f = self.base.components();
        array_of(|i| array_of(|j| R::constant(f[i][j])))
    }

    /// Product of the stretches in the directions beyond the lattice.
    pub fn transverse(&self) -> f64 {
        let f = self.base.components();
        (D..3).map(|i| f[i][i]).product()
    }

    /// Returns the first Piola-Kirchhoff stress `P_iJ` at a deformation gradient; NaN if the law is not defined there.
    pub fn first_piola<R: Real>(&self, f: &[[R; D]; D]) -> [[R; D]; D] {
        let base = self.base.components();
        let is_base = (0..D).all(|i| (0..D).all(|j| f[i][j].value() == base[i][j]));
        let is_from_base = is_base || self.is_path_dependent;
        let local = if is_from_base {
            Some(self.local)
        } else {
            let values = nalgebra::SMatrix::from_fn(|i, j| f[i][j].value());
            Local::new(self.material, &self.base.with_leading::<D>(&values)).ok()
        };
        let Some(local) = local else {
            return [[R::constant(f64::NAN); D]; D];
        };
        let (stress, tangent) = (local.first_piola(), local.tangent());
        // Change from the deformation at which the response was evaluated. If this is the value of `f`, the change is zero and carries the
        // derivatives.
        let change: [[R; D]; D] = array_of(|k| {
            array_of(|l| {
                let origin = if is_from_base {
                    base[k][l]
                } else {
                    f[k][l].value()
                };
                f[k][l] - origin
            })
        });
        array_of(|i| {
            array_of(|j| {
                let mut sum = R::constant(stress[i][j]);
                for k in 0..D {
                    for l in 0..D {
                        sum = sum + change[k][l] * tangent[i][j][k][l];
                    }
                }
                sum
            })
        })
    }

    /// Returns the energy density `W` at a deformation gradient; energy/volume, NaN if the law is not defined there.
    ///
    /// For a path-dependent law this is the work along the straight path from the homogeneous state.
    pub fn energy(&self, f: &[[f64; D]; D]) -> f64 {
        if self.is_path_dependent {
            let base = self.base.components();
            let (first, last) = (self.local.first_piola(), self.first_piola(f));
            let entries = (0..D).flat_map(|i| (0..D).map(move |j| (i, j)));
            return entries
                .map(|(i, j)| 0.5 * (first[i][j] + last[i][j]) * (f[i][j] - base[i][j]))
                .sum();
        }
        let own = nalgebra::SMatrix::from_fn(|i, j| f[i][j]);
        let response = self.material.response(&self.base.with_leading::<D>(&own));
        response.map_or(f64::NAN, |response| response.energy)
    }

    /// Returns the Cauchy stress `sigma_ij = P_iJ F_jJ / J`.
    pub fn cauchy<R: Real>(&self, f: &[[R; D]; D]) -> [[R; D]; D] {
        let stress = self.first_piola(f);
        let jacobian = determinant(f) * self.transverse();
        array_of(|i| {
            array_of(|j| {
                let mut sum = R::constant(0.0);
                for m in 0..D {
                    sum = sum + stress[i][m] * f[j][m];
                }
                sum / jacobian
            })
        })
    }

    /// First Piola-Kirchhoff stress `P_iJ` of the homogeneous state.
    pub fn base_stress(&self) -> &[[f64; D]; D] {
        self.local.first_piola()
    }

    /// Tangent `A_iJkL` of the homogeneous state, indexed `[i][J][k][L]`.
    pub fn base_tangent(&self) -> &[[[[f64; D]; D]; D]; D] {
        self.local.tangent()
    }
}

/// Determinant of a square matrix with at most three rows.
pub(crate) fn determinant<R: Real, const D: usize>(m: &[[R; D]; D]) -> R {
    match D {
        1 => m[0][0],
        2 => m[0][0] * m[1][1] - m[0][1] * m[1][0],
        _ => {
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
                + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        }
    }
}

/// Inverse of a square matrix with at most three rows.
pub(crate) fn inverse<R: Real, const D: usize>(m: &[[R; D]; D]) -> [[R; D]; D] {
    let scale = determinant(m).recip();
    let cofactor = |i: usize, j: usize| match D {
        1 => R::constant(1.0),
        2 => {
            let sign = if i == j { 1.0 } else { -1.0 };
            m[1 - i][1 - j] * sign
        }
        _ => {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1]
        }
    };
    array_of(|i| array_of(|j| cofactor(j, i) * scale))
}
