//! Interface of plastic laws: flow at a state, as used by paths and localization bands.

use super::{DruckerPrager, PlasticityError};
use nalgebra::{Matrix3, Vector3};

/// Isotropic elasticity, given by its moduli. Units of stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elasticity {
    /// Shear modulus `G` in units of stress.
    pub shear: f64,
    /// Bulk modulus `K` in units of stress.
    pub bulk: f64,
}

impl Elasticity {
    /// Creates the elasticity from the shear modulus and Poisson's ratio, `K = 2 G (1 + nu) / (3 (1 - 2 nu))`.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] unless `G > 0`, `-1 < nu < 1/2`.
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

    /// Poisson's ratio `(3 K - 2 G) / (2 (3 K + G))`.
    pub fn poisson_ratio(&self) -> f64 {
        (3.0 * self.bulk - 2.0 * self.shear) / (2.0 * (3.0 * self.bulk + self.shear))
    }

    /// Principal stresses `2 G dev e + K tr(e) 1` of principal strains.
    pub fn stress(&self, strain: &Vector3<f64>) -> Vector3<f64> {
        let volume = strain.sum();
        strain.map(|e| 2.0 * self.shear * (e - volume / 3.0) + self.bulk * volume)
    }

    /// Principal strains `dev(sigma) / (2 G) + sigma_m / (3 K) 1` of principal stresses.
    pub fn strain(&self, stress: &Vector3<f64>) -> Vector3<f64> {
        let mean = stress.sum() / 3.0;
        stress.map(|s| (s - mean) / (2.0 * self.shear) + mean / (3.0 * self.bulk))
    }

    /// Derivatives `d sigma_i / d e_j`: `K + 4G/3` and `K - 2G/3`.
    pub(super) fn normal(&self) -> Matrix3<f64> {
        Matrix3::repeat(self.bulk - 2.0 / 3.0 * self.shear)
            + Matrix3::identity() * (2.0 * self.shear)
    }
}

/// Flow of a state along the axes of the path: `sigma' = C : (e' - P l)` with `Q : sigma' = h l`.
///
/// The tangent is `C - (C:P)(Q:C) / (h + Q:C:P)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Elasticity `C` of the state without flow. It changes with the state if the law loses stiffness.
    pub elasticity: Elasticity,
    /// Direction of inelastic strain `P`.
    pub direction: Vector3<f64>,
    /// Direction `Q` of the stress that drives the flow.
    pub normal: Vector3<f64>,
    /// Product `h m` of the plastic modulus and `per_slip`. Units of stress.
    pub hardening: f64,
    /// Multiple `m` of `P` that is added per unit of slip; 1 if slip measures plastic strain.
    pub per_slip: f64,
    /// Rates of the internal variables per unit of slip.
    pub internal: Vector3<f64>,
}

impl Flow {
    /// Associated plastic flow along the normal, without internal variables.
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

    /// Plastic modulus `h`. Units of stress.
    pub fn modulus(&self) -> f64 {
        self.hardening / self.per_slip
    }

    /// Relaxation `Q : C : P`. Units of stress.
    pub fn relaxation(&self) -> f64 {
        self.normal.dot(&self.elasticity.stress(&self.direction))
    }
}

/// Law that flows along fixed axes: stress, strain and flow are diagonal in them.
///
/// The state consists of the stress, the slip (the plastic shear strain, the independent variable of a path) and up to three internal variables. At
/// finite strain the stress is the Kirchhoff stress, and strains are logarithmic. All laws here have isotropic elasticity, which determines the shear
/// stiffness between two axes.
pub trait FlowLaw {
    /// Elasticity before any flow.
    fn elasticity(&self) -> Elasticity;

    /// Elasticity of a state that unloads after a slip. It differs from the initial elasticity if the law loses stiffness.
    fn unloading(&self, _slip: f64) -> Elasticity {
        self.elasticity()
    }

    /// Returns true if unloading differs from reversed loading. A law without this difference is elastic.
    fn unloads(&self) -> bool {
        true
    }

    /// Stress of the order of the strength at first yield, which scales errors. Units of stress.
    fn strength(&self) -> f64;

    /// Internal variables at first yield, and the magnitudes that scale their errors.
    fn start(&self, _stress: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        (Vector3::zeros(), Vector3::repeat(1.0))
    }

    /// Number of faces of the yield surface that flow simultaneously. It exceeds one at a corner, where the response to a perturbation is not linear.
    fn faces(&self, _internal: &Vector3<f64>) -> usize {
        1
    }

    /// Yield function: negative in the elastic range, zero during flow. Units of stress.
    fn excess(&self, stress: &Vector3<f64>, slip: f64, internal: &Vector3<f64>) -> f64;

    /// Stress and slip at the end of a path of constant strain rate along which the material flows; `None` without a closed form.
    ///
    /// The arguments are the elastic stress at its end and the slip at its beginning.
    ///
    /// # Errors
    /// The reason why the path cannot be followed to its end.
    fn flowed_at_once(
        &self,
        _elastic: &Vector3<f64>,
        _slip: f64,
    ) -> Option<Result<(Vector3<f64>, f64), PlasticityError>> {
        None
    }

    /// Returns the flow of a state on the yield surface.
    ///
    /// # Errors
    /// - [`PlasticityError::NoDeviator`] if the direction of flow is undefined
    /// - [`PlasticityError::Exhausted`] if the strength is exhausted
    /// - [`PlasticityError::Corner`] if another face of the yield surface is reached
    fn flow(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
        internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError>;
}

/// Mean stress, deviator and `sqrt(s:s/2)` of principal stresses.
pub(super) fn parts(stress: &Vector3<f64>) -> (f64, Vector3<f64>, f64) {
    let mean = stress.sum() / 3.0;
    let deviator = stress.add_scalar(-mean);
    (mean, deviator, (0.5 * deviator.norm_squared()).sqrt())
}

/// Direction `s / (2 tau)`, and `tau`.
///
/// # Errors
/// [`PlasticityError::NoDeviator`] if `tau` vanishes.
pub(super) fn direction(stress: &Vector3<f64>) -> Result<(Vector3<f64>, f64), PlasticityError> {
    let (_, deviator, shear) = parts(stress);
    if shear <= 1e-14 * stress.amax() {
        return Err(PlasticityError::NoDeviator);
    }
    Ok((deviator / (2.0 * shear), shear))
}

impl DruckerPrager {
    /// Flow of a state, even if no strength is left.
    pub(super) fn flow_unlimited(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
    ) -> Result<Flow, PlasticityError> {
        let (unit, _) = direction(stress)?;
        let with = |volume: f64| unit.add_scalar(volume / 3.0);
        Ok(Flow {
            direction: with(self.dilatancy()),
            ..Flow::associated(
                FlowLaw::elasticity(self),
                with(self.friction()),
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

    /// The directions of flow do not change along the path, so that one implicit step is exact.
    fn flowed_at_once(
        &self,
        elastic: &Vector3<f64>,
        slip: f64,
    ) -> Option<Result<(Vector3<f64>, f64), PlasticityError>> {
        let excess = self.excess(elastic, slip, &Vector3::zeros());
        if excess.is_nan() || excess < 0.0 {
            return None;
        }
        let (mean, deviator, shear) = parts(elastic);
        let (increment, left, mean) = self.step_on_cone(excess, shear, mean, slip);
        let end = slip + increment;
        let strong = self.hardening().not_exhausted(end);
        Some(strong.and_then(|()| match left > 0.0 {
            true => Ok(((deviator * left).add_scalar(mean), end)),
            false => Err(PlasticityError::NoDeviator),
        }))
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
