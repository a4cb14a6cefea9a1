//! Softening of rubber by previous loading (Mullins effect) after Ogden and Roxburgh.
//!
//! The energy of a hyperelastic law is the sum of a part `U` that softens and a part that does not. With the largest value `U_m` of `U` in the history
//! of the material, the stress of the first part is multiplied by
//!
//! `eta = 1 - erf((U_m - U)/(m + beta U_m))/r`,
//!
//! so that `P = P_0 - (1 - eta) P_U` with the stress `P_0` of the law and `P_U = dU/dF`. `U` is the deviatoric energy `W(F) - W(J^(1/3) 1)` if the mean
//! stress of the law depends on the volume ratio alone, and the whole energy otherwise, as for foams.
//!
//! - Primary loading, `U = U_m`: `eta = 1`, and the tangent of continued loading is the tangent `A_0` of the law.
//! - Unloading and reloading, `U <= U_m`: the tangent is `A_0 - (1 - eta) A_U + eta' P_U x P_U` with `eta' = d eta/dU > 0`. It is stiffer than `A_0` at
//!   the beginning of unloading.
//!
//! For constant `U_m` the stress derives from the energy `W + (s/r) (x erf(x) + (exp(-x^2) - 1)/sqrt(pi))`, `x = (U_m - U)/s`, `s = m + beta U_m`, which
//! continues the energy of primary loading and contains the dissipated part. Sources: R. W. Ogden and D. G. Roxburgh, *Proc. R. Soc. London A* 455 (1999)
//! 2861, with the constant `beta` of the Abaqus Theory Guide.

use super::viscoelastic::has_own_mean_stress;
use super::{
    Admitted, FourthOrder, Hyperelastic, LaneStress, MaterialError, Parameter, PlaneTangent,
    Response, ResponseEnclosure,
};
use crate::kinematics::DeformationGradient;
use crate::real::{Interval, Lanes};
use nalgebra::Matrix3;
use std::f64::consts::FRAC_2_SQRT_PI;
use std::sync::Arc;

/// Constants `r`, `m` and `beta` of the softening, and the largest energy `U_m`.
pub const MULLINS: [Parameter; 4] = [
    Parameter::new(
        "mullins-r",
        "1",
        2.0,
        Admitted::Between(1.0, 1e6),
        "Mullins effect (softening of any hyperelastic law by previous loading): constant r; at most the fraction 1/r of the stress is lost",
    ),
    Parameter::new(
        "mullins-m",
        "stress",
        0.0,
        Admitted::NotNegative,
        "Mullins effect: constant m, an energy per volume [default: 0]",
    ),
    Parameter::new(
        "mullins-beta",
        "1",
        0.0,
        Admitted::NotNegative,
        "Mullins effect: constant beta, the fraction of the largest energy that is added to m [default: 0]",
    ),
    Parameter::new(
        "mullins-energy",
        "stress",
        0.0,
        Admitted::NotNegative,
        "Mullins effect: largest energy per volume in the history of the material; if it is not set, every state is reached by primary loading",
    ),
];

/// Hyperelastic law that softens by previous loading.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, OgdenRoxburgh, library};
/// use std::sync::Arc;
/// let rubber = library().iter().find(|law| law.name == "neo-hooke-isochoric").expect("a law");
/// let rubber: Arc<dyn Hyperelastic> = Arc::from(rubber.build(&[])?);
/// let state = DeformationGradient::from_stretches([1.2, 1.0, 1.0 / 1.2])?;
/// let virgin = rubber.response(&state)?;
/// // The material has had a much larger energy, so that the shear stress falls by the fraction 1/r.
/// let softened = OgdenRoxburgh::new(rubber, [2.0, 1e-3, 0.0], Some(10.0))?.response(&state)?;
/// assert!((softened.cauchy()[(0, 0)] / virgin.cauchy()[(0, 0)] - 0.5).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct OgdenRoxburgh {
    law: Arc<dyn Hyperelastic>,
    r: f64,
    m: f64,
    beta: f64,
    /// Largest energy of the softening part; `None` if every state is reached by primary loading.
    largest: Option<f64>,
    /// Whether only the deviatoric stress softens.
    is_deviatoric: bool,
    /// Energy of the law at `F = 1`.
    at_rest: f64,
}

impl OgdenRoxburgh {
    /// Adds the softening with the constants `[r, m, beta]` to a law; `largest` is the largest energy of the softening part, `None` if every state is
    /// reached by primary loading.
    ///
    /// # Errors
    /// [`MaterialError::Parameter`] for constants that are not admissible, [`MaterialError::External`] for a law in rate form.
    pub fn new(
        law: Arc<dyn Hyperelastic>,
        constants: [f64; 3],
        largest: Option<f64>,
    ) -> Result<Self, MaterialError> {
        let given = constants.into_iter().chain(largest);
        if let Some((parameter, value)) = MULLINS.iter().zip(given).find(|own| !own.0.holds(own.1))
        {
            return Err(MaterialError::Parameter {
                name: parameter.name,
                value,
                expected: parameter.expected(),
            });
        }
        let [r, m, beta] = constants;
        MaterialError::positive("mullins-m + mullins-beta", m + beta)?;
        if law.is_path_dependent() {
            return Err(MaterialError::External {
                message: "the Mullins effect softens a law by its strain energy, and this law is not hyperelastic".to_owned(),
            });
        }
        let (at_rest, _) = law.energy_and_stress(&DeformationGradient::identity())?;
        Ok(Self {
            is_deviatoric: has_own_mean_stress(&*law),
            law,
            r,
            m,
            beta,
            largest,
            at_rest,
        })
    }

    /// Energy `U` of the softening part at a state. Units of stress.
    ///
    /// # Errors
    /// [`MaterialError`] under the conditions of [`Hyperelastic::response`].
    pub fn softening_energy(&self, f: &DeformationGradient) -> Result<f64, MaterialError> {
        let (energy, _) = self.law.energy_and_stress(f)?;
        self.part_of(energy, f)
    }

    /// Factor `eta` of the softening part of the stress at a state; 1 for primary loading.
    ///
    /// # Errors
    /// [`MaterialError`] under the conditions of [`Hyperelastic::response`].
    pub fn factor(&self, f: &DeformationGradient) -> Result<f64, MaterialError> {
        let energy = self.softening_energy(f)?;
        Ok(self.below(energy).map_or(1.0, |largest| {
            1.0 - error_function((largest - energy) / self.width(largest)) / self.r
        }))
    }

    /// Largest energy, if it exceeds the energy of a state.
    fn below(&self, energy: f64) -> Option<f64> {
        // Without any previous energy the softening has no width if m = 0.
        self.largest
            .filter(|largest| energy < *largest && *largest > 0.0)
    }

    /// Width `m + beta U_m` of the softening.
    fn width(&self, largest: f64) -> f64 {
        self.m + self.beta * largest
    }

    /// Softening part of an energy of the law.
    fn part_of(&self, energy: f64, f: &DeformationGradient) -> Result<f64, MaterialError> {
        if !self.is_deviatoric {
            return Ok(energy - self.at_rest);
        }
        let side = f.jacobian().cbrt();
        let dilation = DeformationGradient::from_stretches([side; 3]).map_err(|_| {
            MaterialError::NotFinite {
                jacobian: f.jacobian(),
            }
        })?;
        Ok(energy - self.law.energy_and_stress(&dilation)?.0)
    }

    /// Returns the law if every state is reached by primary loading, so that its response is the response of the law.
    fn primary(&self) -> Option<&dyn Hyperelastic> {
        match self.largest {
            None => Some(&*self.law),
            Some(_) => None,
        }
    }

    /// Response to increments of a state with the energy `energy` below the largest energy.
    fn softened(
        &self,
        whole: &Response,
        energy: f64,
        largest: f64,
    ) -> Result<Response, MaterialError> {
        let width = self.width(largest);
        let x = (largest - energy) / width;
        let lost = error_function(x) / self.r;
        let decay = (-x * x).exp();
        let slope = FRAC_2_SQRT_PI * decay / (self.r * width);
        let (mut stress, mut tangent) = (whole.first_piola, whole.tangent.clone());
        if self.is_deviatoric {
            let mean = whole.clone().of_mean_stress(3)?;
            stress -= mean.first_piola;
            tangent = FourthOrder::from_fn(|i, j, k, l| {
                tangent[(i, j, k, l)] - mean.tangent[(i, j, k, l)]
            });
        }
        Response {
            deformation: whole.deformation,
            energy: whole.energy
                + width * (x * lost + FRAC_2_SQRT_PI * 0.5 * (decay - 1.0) / self.r),
            first_piola: whole.first_piola - stress * lost,
            tangent: FourthOrder::from_fn(|i, j, k, l| {
                whole.tangent[(i, j, k, l)] - lost * tangent[(i, j, k, l)]
                    + slope * stress[(i, j)] * stress[(k, l)]
            }),
        }
        .finite()
    }
}

/// Error function of a number that is not negative, from its series of positive terms.
fn error_function(x: f64) -> f64 {
    // 1 - erf(6) = 2e-17 is below rounding.
    if x >= 6.0 {
        return 1.0;
    }
    let (mut term, mut sum, mut n) = (x, x, 1.0);
    while term > f64::EPSILON * 0.125 * sum {
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        sum += term;
        n += 1.0;
    }
    (FRAC_2_SQRT_PI * (-x * x).exp() * sum).min(1.0)
}

impl Hyperelastic for OgdenRoxburgh {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let whole = self.law.response(f)?;
        if self.largest.is_none() {
            return Ok(whole);
        }
        let energy = self.part_of(whole.energy, f)?;
        match self.below(energy) {
            Some(largest) => self.softened(&whole, energy, largest),
            None => Ok(whole),
        }
    }

    fn unloading_tangent(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        let whole = self.law.response(f)?;
        let energy = self.part_of(whole.energy, f)?;
        match energy > 0.0 && self.below(energy).is_none() {
            true => Ok(Some(self.softened(&whole, energy, energy)?.tangent)),
            false => Ok(None),
        }
    }

    fn isochoric_response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        match self.primary() {
            Some(law) => law.isochoric_response(f),
            None => self.response(f),
        }
    }

    fn energy_and_stress(
        &self,
        f: &DeformationGradient,
    ) -> Result<(f64, Matrix3<f64>), MaterialError> {
        if let Some(law) = self.primary() {
            return law.energy_and_stress(f);
        }
        let response = self.response(f)?;
        Ok((response.energy, response.first_piola))
    }

    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress {
        match self.primary() {
            Some(law) => law.lane_stress(states, dimension),
            None => LaneStress::of_each(states, dimension, |f| self.energy_and_stress(f).ok()),
        }
    }

    fn plane_tangent(&self, f: &DeformationGradient) -> Result<PlaneTangent, MaterialError> {
        if let Some(law) = self.primary() {
            return law.plane_tangent(f);
        }
        Ok(self.response(f)?.tangent.in_plane())
    }

    fn plane_tangents(
        &self,
        states: &[DeformationGradient],
    ) -> Vec<Result<PlaneTangent, MaterialError>> {
        match self.primary() {
            Some(law) => law.plane_tangents(states),
            None => states.iter().map(|f| self.plane_tangent(f)).collect(),
        }
    }

    fn enclosure(&self, f: &DeformationGradient<Interval>) -> ResponseEnclosure {
        self.primary()
            .map_or(ResponseEnclosure::ENTIRE, |law| law.enclosure(f))
    }
}
