//! A law linearized about one of its states.

use super::{FourthOrder, Hyperelastic, MaterialError, Response};
use crate::kinematics::DeformationGradient;
use nalgebra::Matrix3;

/// Largest relative difference of equal laws: turning a state rounds its tangent.
const EQUAL_TOLERANCE: f64 = 1e-9;

/// Hill's linear comparison solid, `P = P_0 + A (F - F_0)`, about a state `F_0` of a law.
///
/// Bodies are run with the stress alone. A law whose tangent is not the derivative of its stress is represented near a state by this law, and a law that
/// is a function of another program is evaluated only twice. The reference state keeps its exact response, which scales penalties and viscosities.
pub struct Linearized {
    base: Response,
    undeformed: Response,
    integrated: Option<FourthOrder>,
    dimension: usize,
    is_path_dependent: bool,
}

impl Linearized {
    /// Linearizes a law about a state.
    ///
    /// # Errors
    /// [`MaterialError`] under the conditions of [`Hyperelastic::response`].
    pub fn about(law: &dyn Hyperelastic, f: &DeformationGradient) -> Result<Self, MaterialError> {
        Ok(Self {
            base: law.response(f)?,
            undeformed: law.undeformed()?,
            integrated: law.integrated_tangent(f)?,
            dimension: law.dimension(),
            is_path_dependent: law.is_path_dependent(),
        })
    }

    /// Law about the rotated state `R F_0`, given as `state`.
    pub(crate) fn rotated(self, rotation: &Matrix3<f64>, state: &DeformationGradient) -> Self {
        let base = Response {
            deformation: *state,
            energy: self.base.energy,
            first_piola: rotation * self.base.first_piola,
            tangent: self.base.tangent.with_spatial_indices(rotation),
        };
        let integrated = self.integrated;
        let integrated = integrated.map(|own| own.with_spatial_indices(rotation));
        Self {
            base,
            integrated,
            ..self
        }
    }
}

impl Linearized {
    /// Law of the material turned by an orthogonal map `Q`, about the state `Q F_0 Q^T`.
    pub(crate) fn turned(&self, map: &Matrix3<f64>) -> Self {
        let of = |response: &Response| {
            let f = map * response.deformation.matrix() * map.transpose();
            Response {
                deformation: response.deformation.with_leading(&f),
                energy: response.energy,
                first_piola: map * response.first_piola * map.transpose(),
                tangent: response.tangent.transformed(map),
            }
        };
        Self {
            base: of(&self.base),
            undeformed: of(&self.undeformed),
            integrated: self.integrated.as_ref().map(|own| own.transformed(map)),
            ..*self
        }
    }

    /// Returns true if two laws differ by rounding errors alone.
    pub(crate) fn equals(&self, other: &Self) -> bool {
        let (a, b) = (&self.base, &other.base);
        let indices = || (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3));
        let size = indices().map(|at| a.tangent[at].abs()).fold(0.0, f64::max);
        let apart = indices().map(|at| (a.tangent[at] - b.tangent[at]).abs());
        let stress = (a.first_piola - b.first_piola).amax();
        let apart = apart.fold(stress, f64::max);
        let f = (a.deformation.matrix() - b.deformation.matrix()).amax();
        f <= EQUAL_TOLERANCE && apart <= EQUAL_TOLERANCE * size
    }

    /// State about which the law is linearized.
    pub(crate) fn state(&self) -> &DeformationGradient {
        &self.base.deformation
    }
}

impl Hyperelastic for Linearized {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let rest = DeformationGradient::identity();
        if *f == rest && self.base.deformation != rest {
            return Ok(self.undeformed.clone());
        }
        let (energy, first_piola) = self.energy_and_stress(f)?;
        Response {
            deformation: *f,
            energy,
            first_piola,
            ..self.base.clone()
        }
        .finite()
    }

    fn energy_and_stress(
        &self,
        f: &DeformationGradient,
    ) -> Result<(f64, Matrix3<f64>), MaterialError> {
        let n = self.dimension;
        let (own, base) = (f.components(), self.base.deformation.components());
        let mut stress = self.base.first_piola;
        let mut energy = self.base.energy;
        for k in 0..n {
            for l in 0..n {
                let change = own[k][l] - base[k][l];
                if change == 0.0 {
                    continue;
                }
                energy += self.base.first_piola[(k, l)] * change;
                for i in 0..n {
                    for j in 0..n {
                        stress[(i, j)] += self.base.tangent[(i, j, k, l)] * change;
                    }
                }
            }
        }
        let work = |i: usize, j: usize| {
            let change = own[i][j] - base[i][j];
            0.5 * (stress[(i, j)] - self.base.first_piola[(i, j)]) * change
        };
        energy += (0..n)
            .flat_map(|i| (0..n).map(move |j| (i, j)))
            .map(|(i, j)| work(i, j))
            .sum::<f64>();
        Ok((energy, stress))
    }

    fn dimension(&self) -> usize {
        self.dimension
    }

    fn is_path_dependent(&self) -> bool {
        self.is_path_dependent
    }

    fn undeformed(&self) -> Result<Response, MaterialError> {
        Ok(self.undeformed.clone())
    }

    fn integrated_tangent(
        &self,
        _f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        Ok(self.integrated.clone())
    }
}
