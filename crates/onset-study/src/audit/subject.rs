//! What is audited: something that answers with stress, energy and a tangent.

use super::convention::{Convention, StressChange};
use super::reading::Delivery;
use nalgebra::Matrix3;
use onset::kinematics::{DeformationGradient, KinematicsError};
use onset::material::{FourthOrder, Hyperelastic, MaterialError};
use onset_umat::Umat;

/// A material to audit.
pub enum Subject<'a> {
    /// A law of ours, of which the tangent is taken as delivered in a convention.
    Law(&'a dyn Hyperelastic, Convention),
    /// A user material, which delivers `DDSDDE`.
    User(&'a Umat),
}

/// What a material says at a state.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The state.
    pub deformation: DeformationGradient,
    /// The Cauchy stress.
    pub cauchy: Matrix3<f64>,
    /// The energy per reference volume.
    pub energy: f64,
    /// The tangent as delivered.
    pub delivery: Delivery,
}

/// A deformation gradient from a matrix.
pub fn deformation(matrix: &Matrix3<f64>) -> Result<DeformationGradient, KinematicsError> {
    DeformationGradient::new(std::array::from_fn(|i| {
        std::array::from_fn(|j| matrix[(i, j)])
    }))
}

impl Subject<'_> {
    /// The convention that its tangent should be in.
    pub fn convention(&self) -> Convention {
        match self {
            Self::Law(_, convention) => *convention,
            Self::User(_) => Convention::JaumannKirchhoff,
        }
    }

    /// What it says at states that are reached each on its own.
    ///
    /// # Errors
    /// [`MaterialError`] when it fails at one of them.
    pub fn samples(&self, states: &[DeformationGradient]) -> Result<Vec<Sample>, MaterialError> {
        match self {
            Self::Law(law, convention) => states
                .iter()
                .map(|f| of_law(*law, *convention, f))
                .collect(),
            Self::User(umat) => {
                let paths = states
                    .iter()
                    .map(|f| umat.path(f))
                    .collect::<Result<Vec<_>, _>>()?;
                of_user(umat, states, &paths)
            }
        }
    }

    /// What it says at states near one: a material with a history reaches them in its last increment, so that its tangent, which
    /// is that of an increment, can be held against them.
    ///
    /// # Errors
    /// [`MaterialError`] when it fails at one of them.
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
    /// The last increment by which a state is reached: all of it for a law without a history.
    ///
    /// # Errors
    /// [`MaterialError`] where there is no path to the state.
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

    /// What it says at states that are reached each by way of the state before, the first one by way of the last.
    ///
    /// # Errors
    /// [`MaterialError`] when it fails at one of them.
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

fn of_law(
    law: &dyn Hyperelastic,
    convention: Convention,
    f: &DeformationGradient,
) -> Result<Sample, MaterialError> {
    let response = law.response(f)?;
    let reference = match convention {
        Convention::Reference => law.response(&DeformationGradient::identity())?.tangent,
        _ => FourthOrder::from_fn(|_, _, _, _| 0.0),
    };
    let change = StressChange::of_response(&response);
    Ok(Sample {
        deformation: *f,
        cauchy: change.cauchy,
        energy: response.energy,
        delivery: Delivery::Tensor(Box::new(convention.tangent(&change, &reference))),
    })
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
                delivery: Delivery::Matrix(Box::new(delivered.ddsdde)),
            }
        })
        .collect())
}
