//! Material under audit, which returns stress, energy and a tangent.

use super::convention::{Convention, StressChange};
use super::reading::Delivery;
use nalgebra::Matrix3;
use onset::kinematics::{DeformationGradient, KinematicsError};
use onset::material::{FourthOrder, Hyperelastic, MaterialError, Response};
use onset_umat::{Interface, Umat};

/// Material under audit: a law or a user material.
pub enum Subject<'a> {
    /// Built-in law, with its tangent in the given convention.
    Law(&'a dyn Hyperelastic, Convention),
    /// User material, which delivers `DDSDDE` as a UMAT, otherwise `dP/dF`.
    User(&'a Umat),
}

/// Response of a material at a state.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Deformation gradient of the state.
    pub deformation: DeformationGradient,
    /// Cauchy stress. Units of stress.
    pub cauchy: Matrix3<f64>,
    /// Energy per reference volume. Units of stress.
    pub energy: f64,
    /// Tangent as the material delivers it.
    pub delivery: Delivery,
}

/// Validates a matrix as a deformation gradient.
pub fn deformation(matrix: &Matrix3<f64>) -> Result<DeformationGradient, KinematicsError> {
    DeformationGradient::new(std::array::from_fn(|i| {
        std::array::from_fn(|j| matrix[(i, j)])
    }))
}

impl Subject<'_> {
    /// Expected convention of the tangent.
    pub fn convention(&self) -> Convention {
        match self {
            Self::Law(_, convention) => *convention,
            Self::User(_) if self.is_umat() => Convention::JaumannKirchhoff,
            Self::User(_) => Convention::FirstPiola,
        }
    }

    /// Returns true for a UMAT, whose tangent is `DDSDDE` and whose energy is `SSE`.
    pub fn is_umat(&self) -> bool {
        matches!(self, Self::User(umat) if delivers_ddsdde(umat))
    }

    /// Name of the tangent that the material delivers.
    pub fn tangent_name(&self) -> &'static str {
        match self {
            Self::User(umat) => match umat.settings().interface {
                Interface::Umat => "DDSDDE",
                Interface::Mfront => "K",
                _ if umat.is_differenced() => "The tangent, from differences of the stress,",
                _ => "A",
            },
            Self::Law(..) => "The tangent",
        }
    }

    /// Evaluates the material at each state, along separate paths from the reference configuration.
    ///
    /// # Errors
    /// [`MaterialError`] when the material fails at a state.
    pub fn samples(&self, states: &[DeformationGradient]) -> Result<Vec<Sample>, MaterialError> {
        match self {
            Self::Law(law, convention) => of_law(*law, *convention, states),
            Self::User(umat) => {
                let paths = states
                    .iter()
                    .map(|f| umat.path(f))
                    .collect::<Result<Vec<_>, _>>()?;
                of_user(umat, states, &paths)
            }
        }
    }

    /// Evaluates the material at states near `f`.
    ///
    /// A material with a history reaches these states in its last increment, so that they can be compared with its tangent, which belongs to this
    /// increment.
    ///
    /// # Errors
    /// [`MaterialError`] when the material fails at a state.
    pub fn samples_near(
        &self,
        f: &DeformationGradient,
        states: &[DeformationGradient],
    ) -> Result<Vec<Sample>, MaterialError> {
        let Self::User(umat) = self else {
            return self.samples(states);
        };
        let path = umat.path(f)?;
        let paths: Vec<Vec<Matrix3<f64>>> = states
            .iter()
            .map(|state| {
                let mut near = path.clone();
                near.pop();
                near.push(state.matrix());
                near
            })
            .collect();
        of_user(umat, states, &paths)
    }
}

impl Subject<'_> {
    /// Relative deformation gradient `F F_(n-1)^-1` of the last increment of the path to `f`; `f` itself for a law without history.
    ///
    /// # Errors
    /// [`MaterialError`] when no path leads to the state.
    pub fn last_increment(&self, f: &DeformationGradient) -> Result<Matrix3<f64>, MaterialError> {
        let Self::User(umat) = self else {
            return Ok(f.matrix());
        };
        let path = umat.path(f)?;
        let start = path
            .len()
            .checked_sub(2)
            .and_then(|last| path[last].try_inverse());
        Ok(start.map_or(f.matrix(), |start| f.matrix() * start))
    }

    /// Evaluates the material at each state after visiting the preceding state (for the first state, the last state).
    ///
    /// # Errors
    /// [`MaterialError`] when the material fails at a state.
    pub fn samples_by_way_of_others(
        &self,
        states: &[DeformationGradient],
    ) -> Result<Vec<Sample>, MaterialError> {
        let Self::User(umat) = self else {
            return self.samples(states);
        };
        let before = states.iter().cycle().skip(states.len().saturating_sub(1));
        let paths: Vec<Vec<Matrix3<f64>>> = before
            .zip(states)
            .map(|(before, f)| vec![before.matrix(), f.matrix()])
            .collect();
        of_user(umat, states, &paths)
    }
}

fn delivers_ddsdde(umat: &Umat) -> bool {
    umat.settings().interface == Interface::Umat
}

fn of_law(
    law: &dyn Hyperelastic,
    convention: Convention,
    states: &[DeformationGradient],
) -> Result<Vec<Sample>, MaterialError> {
    let reference = match convention {
        Convention::Reference => law.response(&DeformationGradient::identity())?.tangent,
        _ => FourthOrder::from_fn(|_, _, _, _| 0.0),
    };
    let sample = |(f, response): (&DeformationGradient, Result<Response, MaterialError>)| {
        let response = response?;
        let change = StressChange::of_response(&response);
        Ok(Sample {
            deformation: *f,
            cauchy: change.cauchy,
            energy: response.energy,
            delivery: Delivery::Tensor(Box::new(convention.tangent(&change, &reference))),
        })
    };
    let responses = law.responses(states);
    states.iter().zip(responses).map(sample).collect()
}

fn of_user(
    umat: &Umat,
    states: &[DeformationGradient],
    paths: &[Vec<Matrix3<f64>>],
) -> Result<Vec<Sample>, MaterialError> {
    let samples = states.iter().zip(umat.along_every(paths)?);
    Ok(samples
        .map(|(f, outcome)| {
            let delivered = outcome.delivered;
            Sample {
                deformation: *f,
                cauchy: delivered.cauchy(),
                energy: delivered.energy(f),
                delivery: match delivers_ddsdde(umat) {
                    true => Delivery::Matrix(Box::new(delivered.ddsdde)),
                    false => Delivery::Tensor(Box::new(delivered.response(f).tangent)),
                },
            }
        })
        .collect())
}
