//! What a law says of its plastic flow: the one interface through which paths and bands see every law.

use super::law::{deviator, equivalent_shear, mean};
use super::{DruckerPrager, PlasticityError};
use nalgebra::{Matrix3, Vector3};

/// Isotropic elasticity, by its moduli. Units of stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elasticity {
    /// The shear modulus `G`.
    pub shear: f64,
    /// The bulk modulus `K`.
    pub bulk: f64,
}

impl Elasticity {
    /// From the shear modulus and Poisson's ratio, `K = 2 G (1 + nu) / (3 (1 - 2 nu))`.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] outside of `G > 0`, `-1 < nu < 1/2`.
    pub fn new(shear: f64, poisson_ratio: f64) -> Result<Self, PlasticityError> {
        PlasticityError::require(
            shear > 0.0,
            "shear-modulus",
            shear,
            "a positive finite number",
        )?;
        PlasticityError::require(
            poisson_ratio > -1.0 && poisson_ratio < 0.5,
            "poisson-ratio",
            poisson_ratio,
            "a number above -1 and below 0.5",
        )?;
        let bulk = 2.0 * shear * (1.0 + poisson_ratio) / (3.0 * (1.0 - 2.0 * poisson_ratio));
        Ok(Self { shear, bulk })
    }

    /// `2 G dev e + K tr(e) 1` of principal strains.
    pub fn stress(&self, strain: &Vector3<f64>) -> Vector3<f64> {
        let volume = strain.sum();
        strain.map(|e| 2.0 * self.shear * (e - volume / 3.0) + self.bulk * volume)
    }

    /// `dev(sigma) / (2 G) + sigma_m / (3 K) 1` of principal stresses.
    pub fn strain(&self, stress: &Vector3<f64>) -> Vector3<f64> {
        let mean = stress.sum() / 3.0;
        stress.map(|s| (s - mean) / (2.0 * self.shear) + mean / (3.0 * self.bulk))
    }

    /// `d sigma_i / d e_j`: `K + 4G/3` and `K - 2G/3`.
    pub(super) fn normal(&self) -> Matrix3<f64> {
        Matrix3::repeat(self.bulk - 2.0 / 3.0 * self.shear)
            + Matrix3::identity() * (2.0 * self.shear)
    }
}

/// The flow of a state, along the axes of the path: `sigma' = C : (e' - P l)` with `Q : sigma' = h l`, so that the tangent is
/// `C - (C:P)(Q:C) / (h + Q:C:P)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// What the state answers with where it does not flow: `C`. It changes with the state where the law loses stiffness.
    pub elasticity: Elasticity,
    /// Direction of inelastic strain `P`.
    pub direction: Vector3<f64>,
    /// Direction `Q` of the stress that drives it.
    pub normal: Vector3<f64>,
    /// `h m`, `m` as below. Units of stress.
    pub hardening: f64,
    /// `m`: how much of `P` is added per slip; 1 where slip measures plastic strain.
    pub per_slip: f64,
    /// Rates of the internal variables per slip.
    pub internal: Vector3<f64>,
}

impl Flow {
    /// Plastic flow along the normal, without internal variables.
    pub fn associated(elasticity: Elasticity, normal: Vector3<f64>, hardening: f64) -> Self {
        Self {
            elasticity,
            direction: normal,
            normal,
            hardening,
            per_slip: 1.0,
            internal: Vector3::zeros(),
        }
    }

    /// The plastic modulus `h`. Units of stress.
    pub fn modulus(&self) -> f64 {
        self.hardening / self.per_slip
    }

    /// `Q : C : P`. Units of stress.
    pub fn relaxation(&self) -> f64 {
        self.normal.dot(&self.elasticity.stress(&self.direction))
    }
}

/// A law that flows along fixed axes: stress, strain and flow are diagonal in them.
///
/// The state is the stress, the slip (the plastic shear strain, the independent variable of a path) and up to three internal variables. At
/// finite strain the stress is Kirchhoff's and strains are logarithmic; all laws here have isotropic elasticity, of which the shear stiffness between two axes
/// follows.
pub trait FlowLaw {
    /// Elasticity before any flow.
    fn elasticity(&self) -> Elasticity;

    /// A stress of the size of the strength at first yield, by which errors are measured. Units of stress.
    fn strength(&self) -> f64;

    /// The internal variables at first yield, and the size by which errors of them are measured.
    fn start(&self, _stress: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        (Vector3::zeros(), Vector3::repeat(1.0))
    }

    /// The yield function; negative within the elastic range, zero while the material flows. Units of stress.
    fn excess(&self, stress: &Vector3<f64>, slip: f64, internal: &Vector3<f64>) -> f64;

    /// The flow of a state on the yield surface.
    ///
    /// # Errors
    /// [`PlasticityError::NoDeviator`] where it has no direction, [`PlasticityError::Exhausted`] where the strength is used up,
    /// [`PlasticityError::Corner`] where another face of the yield surface is reached.
    fn flow(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
        internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError>;
}

/// Mean stress, deviator and `sqrt(s:s/2)` of principal stresses.
pub(super) fn parts(stress: &Vector3<f64>) -> (f64, Vector3<f64>, f64) {
    let tensor = Matrix3::from_diagonal(stress);
    let deviator = deviator(&tensor);
    (
        mean(&tensor),
        deviator.diagonal(),
        equivalent_shear(&deviator),
    )
}

/// `s / (2 tau)`, and `tau`.
///
/// # Errors
/// [`PlasticityError::NoDeviator`] where `tau` vanishes.
pub(super) fn direction(stress: &Vector3<f64>) -> Result<(Vector3<f64>, f64), PlasticityError> {
    let (_, deviator, shear) = parts(stress);
    if shear <= 1e-14 * stress.amax() {
        return Err(PlasticityError::NoDeviator);
    }
    Ok((deviator / (2.0 * shear), shear))
}

impl DruckerPrager {
    /// The flow of a state, whether or not strength is left.
    pub(super) fn flow_unlimited(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
    ) -> Result<Flow, PlasticityError> {
        let (direction, normal) = self.directions(&Matrix3::from_diagonal(stress))?;
        Ok(Flow {
            direction: direction.diagonal(),
            ..Flow::associated(
                FlowLaw::elasticity(self),
                normal.diagonal(),
                self.hardening().modulus(slip),
            )
        })
    }
}

impl FlowLaw for DruckerPrager {
    fn elasticity(&self) -> Elasticity {
        Elasticity {
            shear: self.shear_modulus(),
            bulk: self.bulk_modulus(),
        }
    }

    fn strength(&self) -> f64 {
        self.hardening().strength(0.0)
    }

    fn excess(&self, stress: &Vector3<f64>, slip: f64, _internal: &Vector3<f64>) -> f64 {
        self.yield_function(&Matrix3::from_diagonal(stress), slip)
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
        _internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        self.hardening().not_exhausted(slip)?;
        self.flow_unlimited(stress, slip)
    }
}
