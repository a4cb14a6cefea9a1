//! What a material is: a strain energy, from which everything else follows.
//!
//! A law implements [`StrainEnergy`], one generic function; stress and tangent come from evaluating
//! it with second-order jets, so a law cannot have a stress that does not belong to its energy. The
//! rest of the program sees only the object-safe [`Hyperelastic`]. A material knows nothing of
//! particles.

mod law;
mod laws;
mod principal;
mod tensors;

pub use law::{Admitted, Law, Parameter, SmallStrainStiffness, Symmetry, library};
pub use laws::{BlatzKo, ModifiedMooneyRivlin};
pub use principal::{PrincipalEnergy, energy_of_stretches};
pub use tensors::FourthOrder;

use crate::kinematics::DeformationGradient;
use crate::real::{Interval, Jet, Real};
use nalgebra::Matrix3;
use thiserror::Error;

/// What can be wrong with a material or its response.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MaterialError {
    /// A parameter is outside of what the law admits.
    #[error("material parameter {name} is {value:?}; expected {expected}")]
    Parameter {
        /// The parameter's name, as in a study file.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What the law admits, in words.
        expected: String,
    },
    /// The law has no parameter of this name.
    #[error("{law} has no parameter `{name}`")]
    UnknownParameter {
        /// The law's name.
        law: &'static str,
        /// The parameter's name as given.
        name: String,
    },
    /// The state is outside of those at which the law is defined.
    #[error("the law is not defined at this deformation: {what} is {value:?}; {expected}")]
    OutsideDomain {
        /// The quantity that is out of bounds.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What the law demands of it, with the number.
        expected: String,
    },
    /// A material that is not of the library cannot be made or asked.
    #[error("{message}")]
    External {
        /// Why, and what to do.
        message: String,
    },
    /// The undeformed material carries no waves, so that nothing can be measured by their speed.
    #[error(
        "the undeformed material carries no waves: its largest acoustic eigenvalue is {eigenvalue:e}; expected a positive number"
    )]
    NoWaves {
        /// The largest acoustic eigenvalue.
        eigenvalue: f64,
    },
    /// Energy, stress or tangent over- or underflow at this state.
    #[error(
        "the energy or its derivatives are not finite at this deformation (det F = {jacobian:e})"
    )]
    NotFinite {
        /// The volume ratio of the state.
        jacobian: f64,
    },
}

impl MaterialError {
    /// Checks that a combination of parameters, named by its formula, is positive and finite.
    fn positive(name: &'static str, value: f64) -> Result<f64, Self> {
        if Admitted::Positive.holds(value) {
            Ok(value)
        } else {
            Err(Self::Parameter {
                name,
                value,
                expected: Admitted::Positive.to_string(),
            })
        }
    }
}

/// A hyperelastic law, given by its energy alone.
pub trait StrainEnergy {
    /// The strain energy `W(F)` per reference volume; units of stress. Its derivatives are the stress and the tangent, so it
    /// must be written with operations of [`Real`] only.
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R;

    /// Whether the law is defined at a state; all with `J > 0`, unless it says otherwise.
    ///
    /// # Errors
    /// [`MaterialError::OutsideDomain`] with the quantity that is out of bounds.
    fn admits(&self, _f: &DeformationGradient) -> Result<(), MaterialError> {
        Ok(())
    }
}

/// The tangent within the plane, `A_iJkL` at `[2 i + J][2 k + L]`.
pub type PlaneTangent = [[f64; 4]; 4];

/// The parts of stress and tangent that act within the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneResponse {
    /// `P_iJ` at `[2 i + J]`.
    pub first_piola: [f64; 4],
    /// `A_iJkL`.
    pub tangent: PlaneTangent,
}

/// A material as the rest of the program sees it.
pub trait Hyperelastic: Send + Sync {
    /// Energy, stress and tangent at a state.
    ///
    /// # Errors
    /// [`MaterialError::NotFinite`] when one of them over- or underflows, [`MaterialError::OutsideDomain`] where the law is
    /// not defined.
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError>;

    /// The part of the tangent that acts within the plane, `A_iJkL` at `[2 i + J][2 k + L]` with indices 0 and 1: what
    /// waves in the plane need, several times cheaper than all. Units of stress.
    ///
    /// # Errors
    /// [`MaterialError::NotFinite`] when it over- or underflows.
    fn plane_tangent(&self, f: &DeformationGradient) -> Result<PlaneTangent, MaterialError> {
        let tangent = self.response(f)?.tangent;
        Ok(std::array::from_fn(|a| {
            std::array::from_fn(|b| tangent[(a / 2, a % 2, b / 2, b % 2)])
        }))
    }

    /// The parts of stress and tangent that act within the plane. Units of stress.
    ///
    /// # Errors
    /// [`MaterialError::NotFinite`] when they over- or underflow.
    fn plane_response(&self, f: &DeformationGradient) -> Result<PlaneResponse, MaterialError> {
        let response = self.response(f)?;
        let tangent = &response.tangent;
        Ok(PlaneResponse {
            first_piola: std::array::from_fn(|a| response.first_piola[(a / 2, a % 2)]),
            tangent: std::array::from_fn(|a| {
                std::array::from_fn(|b| tangent[(a / 2, a % 2, b / 2, b % 2)])
            }),
        })
    }

    /// Bounds of energy, stress and tangent over all states with components in the given intervals.
    ///
    /// A law that is not given by a [`StrainEnergy`] knows none, unless it says so.
    fn enclosure(&self, _f: &DeformationGradient<Interval>) -> ResponseEnclosure {
        ResponseEnclosure {
            energy: Interval::ENTIRE,
            first_piola: [[Interval::ENTIRE; 3]; 3],
            tangent: [[[[Interval::ENTIRE; 3]; 3]; 3]; 3],
        }
    }
}

/// Bounds of energy, first Piola-Kirchhoff stress and tangent. Indices as in [`Response`], units of stress.
///
/// They hold the response of the law with its constants as the program computes them, in exact arithmetic.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseEnclosure {
    /// `W`, per reference volume.
    pub energy: Interval,
    /// `P_iJ`.
    pub first_piola: [[Interval; 3]; 3],
    /// `A_iJkL`, indexed `[i][J][k][L]`.
    pub tangent: [[[[Interval; 3]; 3]; 3]; 3],
}

/// Energy `W`, first Piola-Kirchhoff stress and tangent at one state.
///
/// Equations: `P_iJ = dW/dF_iJ`, `A_iJkL = dP_iJ/dF_kL` (the paper's nominal stress is the transpose
/// of `P`; its effective tangent (22) is [`Response::effective_tangent`]). Shapes 3 x 3 and 3 x 3 x 3 x 3, units of stress.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
/// let f = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
/// let response = ModifiedMooneyRivlin::default().response(&f)?;
/// assert!((response.cauchy()[(0, 0)] - 1.4910116952).abs() < 1e-10);
/// assert!((response.effective_tangent()[(0, 0, 0, 0)] - 13.1431557983).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// The state.
    pub deformation: DeformationGradient,
    /// `W`, per reference volume.
    pub energy: f64,
    /// `P_iJ`, first index spatial.
    pub first_piola: Matrix3<f64>,
    /// `A_iJkL`, all 81 components.
    pub tangent: FourthOrder,
}

/// The energy with its derivatives by the nine components of `F`.
fn energy_jet<R: Real>(law: &impl StrainEnergy, f: &DeformationGradient<R>) -> Jet<9, R> {
    let components = f.components();
    let variables = Jet::variables(std::array::from_fn(|n| components[n / 3][n % 3]));
    let jets = std::array::from_fn(|i| std::array::from_fn(|j| variables[3 * i + j]));
    law.energy(&DeformationGradient::from_components(jets))
}

impl<Law: StrainEnergy + Send + Sync> Hyperelastic for Law {
    fn enclosure(&self, f: &DeformationGradient<Interval>) -> ResponseEnclosure {
        let energy = energy_jet(self, f);
        let hessian = |i: usize, j: usize, k: usize, l: usize| energy.hessian[3 * i + j][3 * k + l];
        ResponseEnclosure {
            energy: energy.value,
            first_piola: std::array::from_fn(|i| {
                std::array::from_fn(|j| energy.gradient[3 * i + j])
            }),
            tangent: std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    std::array::from_fn(|k| std::array::from_fn(|l| hessian(i, j, k, l)))
                })
            }),
        }
    }

    fn plane_tangent(&self, f: &DeformationGradient) -> Result<PlaneTangent, MaterialError> {
        Ok(self.plane_response(f)?.tangent)
    }

    fn plane_response(&self, f: &DeformationGradient) -> Result<PlaneResponse, MaterialError> {
        self.admits(f)?;
        // The other components are constants: four variables instead of nine.
        let components = f.components();
        let variables = Jet::<4>::variables(std::array::from_fn(|n| components[n / 2][n % 2]));
        let jets = std::array::from_fn(|i| {
            std::array::from_fn(|j| match (i, j) {
                (0 | 1, 0 | 1) => variables[2 * i + j],
                _ => Jet::constant(components[i][j]),
            })
        });
        let energy = self.energy(&DeformationGradient::from_components(jets));
        let mut values = energy
            .gradient
            .iter()
            .chain(energy.hessian.iter().flatten());
        if values.all(|value| value.is_finite()) {
            Ok(PlaneResponse {
                first_piola: energy.gradient,
                tangent: energy.hessian,
            })
        } else {
            Err(MaterialError::NotFinite {
                jacobian: f.jacobian(),
            })
        }
    }

    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        self.admits(f)?;
        let energy = energy_jet(self, f);
        let response = Response {
            deformation: *f,
            energy: energy.value,
            first_piola: Matrix3::from_fn(|i, j| energy.gradient[3 * i + j]),
            tangent: FourthOrder::from_fn(|i, j, k, l| energy.hessian[3 * i + j][3 * k + l]),
        };
        let finite = response.energy.is_finite()
            && response.first_piola.iter().all(|value| value.is_finite())
            && response.tangent.is_finite();
        if finite {
            Ok(response)
        } else {
            Err(MaterialError::NotFinite {
                jacobian: f.jacobian(),
            })
        }
    }
}
