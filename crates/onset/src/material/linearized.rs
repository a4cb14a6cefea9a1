//! A law linearized about one of its states.

use super::{FourthOrder, Hyperelastic, MaterialError, Response};
use crate::kinematics::DeformationGradient;
use nalgebra::Matrix3;

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
