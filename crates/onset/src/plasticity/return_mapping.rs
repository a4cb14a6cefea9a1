//! Small strain: the stress after a finite step of strain.

use super::law::{deviator, equivalent_shear, mean};
use super::walk::bisect;
use super::{DruckerPrager, Hardening, PlasticityError};
use crate::material::FourthOrder;
use nalgebra::Matrix3;

/// State of a material point at small strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Plastic strain, a symmetric tensor.
    pub plastic_strain: Matrix3<f64>,
    /// Plastic shear strain `gamma`.
    pub slip: f64,
}

/// Kind of a step of the return mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// Elastic step without flow.
    Elastic,
    /// Flow on the smooth cone.
    Cone,
    /// Flow at the apex of the cone.
    Apex,
}

/// Stress and state after a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Update {
    /// Cauchy stress at the end of the step.
    pub stress: Matrix3<f64>,
    /// State at the end of the step.
    pub state: State,
    /// Kind of the step.
    pub branch: Branch,
    /// Consistent tangent `d stress / d strain` of the step (with minor symmetries, without major symmetry if `mu != beta`). Units of stress.
    pub consistent_tangent: FourthOrder,
}

/// Trial elastic strain returned to the yield surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Return {
    pub(super) stress: Matrix3<f64>,
    pub(super) slip: f64,
    pub(super) branch: Branch,
    /// Ratio of the deviator to the trial deviator.
    pub(super) theta: f64,
    pub(super) tangent: FourthOrder,
}

impl DruckerPrager {
    /// Computes the stress at a total strain by an implicit (backward Euler) step from a state.
    ///
    /// The step is `tau = tau_trial - G d`, `sigma_m = sigma_m,trial - K beta d`, with the increment of slip `d` such that `f = 0`. It has a closed
    /// form for linear hardening and is one scalar equation otherwise.
    ///
    /// # Errors
    /// - [`PlasticityError::Exhausted`] if the strength falls to zero
    /// - [`PlasticityError::Apex`] if no flow leads back to the yield surface
    /// - [`PlasticityError::NotFinite`] if a number over- or underflows
    pub fn update(&self, strain: &Matrix3<f64>, state: &State) -> Result<Update, PlasticityError> {
        let total = (strain + strain.transpose()) * 0.5;
        let back = self.map_back(&(total - state.plastic_strain), state.slip)?;
        let plastic_strain = match back.branch {
            Branch::Elastic => state.plastic_strain,
            _ => total - self.elastic_strain(&back.stress),
        };
        Ok(Update {
            stress: back.stress,
            state: State {
                plastic_strain,
                slip: back.slip,
            },
            branch: back.branch,
            consistent_tangent: back.tangent,
        })
    }

    /// Returns a trial elastic strain to the yield surface.
    pub(super) fn map_back(
        &self,
        trial: &Matrix3<f64>,
        slip: f64,
    ) -> Result<Return, PlasticityError> {
        let (shear, bulk) = (self.shear_modulus(), self.bulk_modulus());
        let stress = self.elastic_stress(trial);
        if !stress.iter().all(|value| value.is_finite()) {
            return Err(PlasticityError::NotFinite);
        }
        let excess = self.yield_function(&stress, slip);
        if excess <= 0.0 {
            return Ok(Return {
                stress,
                slip,
                branch: Branch::Elastic,
                theta: 1.0,
                tangent: self.tangent(1.0, bulk, |_, _, _, _| 0.0),
            });
        }
        let deviator = deviator(&stress);
        let trial_shear = equivalent_shear(&deviator);
        let (increment, theta, pressure) =
            self.step_on_cone(excess, trial_shear, mean(&stress), slip);
        if theta.is_nan() || (theta < 0.0 && self.friction() > 0.0) {
            return self.map_back_to_apex(mean(&stress), slip);
        }
        let new_slip = slip + increment;
        self.hardening().not_exhausted(new_slip)?;
        let one = Matrix3::identity();
        let unit = deviator / trial_shear;
        let a = unit * shear + one * (bulk * self.dilatancy());
        let b = unit * shear + one * (bulk * self.friction());
        let stiffness = self.hardening().modulus(new_slip) + self.flow_stiffness();
        let turning = shear * shear * increment / trial_shear;
        Ok(Return {
            stress: deviator * theta + one * pressure,
            slip: new_slip,
            branch: Branch::Cone,
            theta,
            tangent: self.tangent(theta, bulk, |i, j, k, l| {
                turning * unit[(i, j)] * unit[(k, l)] - a[(i, j)] * b[(k, l)] / stiffness
            }),
        })
    }

    /// Implicit step from a trial stress onto the cone: the increment of slip, the ratio of the deviator to its trial value, and the mean stress.
    pub(super) fn step_on_cone(
        &self,
        excess: f64,
        trial_shear: f64,
        trial_mean: f64,
        slip: f64,
    ) -> (f64, f64, f64) {
        let hardening = self.hardening();
        let increment = hardening.increment(excess, self.flow_stiffness(), slip);
        let theta = 1.0 - self.shear_modulus() * increment / trial_shear;
        let mean = trial_mean - self.bulk_modulus() * self.dilatancy() * increment;
        (increment, theta, mean)
    }

    /// Returns a trial mean stress to the apex, where the flow dilates by `beta` per unit of slip.
    fn map_back_to_apex(&self, trial_mean: f64, slip: f64) -> Result<Return, PlasticityError> {
        let (bulk, friction, dilatancy) = (self.bulk_modulus(), self.friction(), self.dilatancy());
        let excess = friction * trial_mean - self.hardening().strength(slip);
        let relaxation = friction * dilatancy * bulk;
        // If this condition fails, the increment of slip is not determined.
        if !(dilatancy > 0.0 && relaxation + self.hardening().lowest_modulus() > 0.0) {
            return Err(PlasticityError::Apex);
        }
        let increment = self.hardening().increment(excess, relaxation, slip);
        let new_slip = slip + increment;
        self.hardening().not_exhausted(new_slip)?;
        let modulus = self.hardening().modulus(new_slip);
        let remaining = modulus * bulk / (relaxation + modulus);
        Ok(Return {
            stress: Matrix3::identity() * (trial_mean - bulk * dilatancy * increment),
            slip: new_slip,
            branch: Branch::Apex,
            theta: 0.0,
            tangent: self.tangent(0.0, remaining, |_, _, _, _| 0.0),
        })
    }
}

impl Hardening {
    /// Solution `d > 0` of `excess - relaxation d - (k(slip + d) - k(slip)) = 0`, whose left-hand side decreases.
    fn increment(&self, excess: f64, relaxation: f64, slip: f64) -> f64 {
        let strength = self.strength(slip);
        let rest = |d: f64| excess - relaxation * d - (self.strength(slip + d) - strength);
        let (mut low, mut high) = (0.0, excess / (relaxation + self.lowest_modulus()));
        let mut d = (excess / (relaxation + self.modulus(slip))).clamp(low, high);
        // Newton's method, kept in a bracket that shrinks.
        for _ in 0..100 {
            let value = rest(d);
            if value > 0.0 {
                low = d;
            } else {
                high = d;
            }
            let newton = d + value / (relaxation + self.modulus(slip + d));
            let next = if newton > low && newton < high {
                newton
            } else if (newton - d).abs() <= 4.0 * f64::EPSILON * d {
                return d;
            } else {
                0.5 * (low + high)
            };
            if (next - d).abs() <= 2.0 * f64::EPSILON * d {
                return next;
            }
            d = next;
        }
        d
    }

    pub(super) fn not_exhausted(&self, slip: f64) -> Result<(), PlasticityError> {
        if self.strength(slip) > 0.0 {
            return Ok(());
        }
        let slip = bisect(0.0, slip, |slip| self.strength(slip) > 0.0);
        Err(PlasticityError::Exhausted { slip })
    }
}
