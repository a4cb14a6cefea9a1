//! Drucker-Prager law, with von Mises as its special case.

use super::coaxial::{
    CONFINEMENT, KAPPA, MODULUS, MU, RESIDUAL, SLIP, STRENGTH, coaxial, elasticity, hardening,
};
use super::{Hardening, PlasticityError};
use crate::material::{Admitted, FourthOrder, Law, Parameter, Symmetry, hooke};
use nalgebra::Matrix3;

pub(super) const DRUCKER_PRAGER: Law = Law {
    name: "drucker-prager",
    formula: "Hencky's law with mu, kappa for the Kirchhoff stress T; tau + friction tr(T)/3 = k(g), tau = sqrt(s:s/2), s = dev T; flow along s/(2 tau) + dilatancy/3 1; \
              k = residual + (strength - residual + hardening-modulus g) exp(-g/reference-slip)",
    parameters: &[
        MU,
        KAPPA,
        Parameter::new(
            "friction",
            "1",
            0.6,
            Admitted::NotNegative,
            "pressure coefficient of the yield surface",
        ),
        Parameter::new(
            "dilatancy",
            "1",
            0.2,
            Admitted::Any,
            "dilatancy of the flow; equal to the friction for associated flow",
        ),
        STRENGTH,
        RESIDUAL,
        MODULUS,
        SLIP,
        CONFINEMENT,
    ],
    domain: "all J > 0, on monotonic, proportional paths from F = 1; tangent of continued flow",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "Drucker and Prager, Q. Appl. Math. 10 (1952) 157, in the notation of Rudnicki and Rice, J. Mech. Phys. Solids 23 (1975) 371; defaults: typical of a \
             soft rock, MPa",
    stiffness: |p| hooke(p[0], p[1]),
    make: |p| coaxial(drucker_prager(p), p[8]),
};

/// The law from its parameters.
pub(super) fn drucker_prager(p: &[f64]) -> Result<DruckerPrager, PlasticityError> {
    let own = elasticity(p);
    let (poisson, strength) = (own.poisson_ratio(), hardening(&p[4..]));
    DruckerPrager::new(own.shear, poisson, p[2], p[3], strength)
}

/// Isotropic elasticity with the yield surface and flow rule of Drucker and Prager.
///
/// `f = tau + mu sigma_m - k(gamma)`, `P = s/(2 tau) + beta/3 1`, `Q = s/(2 tau) + mu/3 1`; tension is positive. Source: J. W. Rudnicki and J. R.
/// Rice, *J. Mech. Phys. Solids* 23 (1975) 371, without their vertex.
///
/// ```
/// use onset::plasticity::{DruckerPrager, Hardening};
/// let strength = Hardening::linear(1.0, -2.0);
/// let sandstone = DruckerPrager::new(300.0, 0.25, 0.6, 0.3, strength)?;
/// assert_eq!(sandstone.bulk_modulus(), 500.0);
/// // Q : C : P = G + mu beta K
/// assert_eq!(sandstone.flow_stiffness(), 300.0 + 0.6 * 0.3 * 500.0);
/// # Ok::<(), onset::plasticity::PlasticityError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DruckerPrager {
    shear_modulus: f64,
    poisson_ratio: f64,
    friction: f64,
    dilatancy: f64,
    hardening: Hardening,
}

impl DruckerPrager {
    /// Creates the law from shear modulus `G`, Poisson's ratio, pressure coefficient `mu`, dilatancy `beta`, and strength.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] unless `G > 0`, `-1 < nu < 1/2`, `mu >= 0`; [`PlasticityError::SnapBack`] unless `h > -(G + mu beta K)` at
    /// every slip.
    pub fn new(
        shear_modulus: f64,
        poisson_ratio: f64,
        friction: f64,
        dilatancy: f64,
        hardening: Hardening,
    ) -> Result<Self, PlasticityError> {
        let require = PlasticityError::require;
        require(
            shear_modulus > 0.0,
            "shear-modulus",
            shear_modulus,
            "a positive finite number",
        )?;
        require(
            poisson_ratio > -1.0 && poisson_ratio < 0.5,
            "poisson-ratio",
            poisson_ratio,
            "a number above -1 and below 0.5",
        )?;
        require(
            friction >= 0.0,
            "friction",
            friction,
            "zero or a positive finite number",
        )?;
        require(true, "dilatancy", dilatancy, "a finite number")?;
        hardening.check()?;
        let law = Self {
            shear_modulus,
            poisson_ratio,
            friction,
            dilatancy,
            hardening,
        };
        let (modulus, least) = (hardening.lowest_modulus(), -law.flow_stiffness());
        if modulus > least {
            Ok(law)
        } else {
            Err(PlasticityError::SnapBack { modulus, least })
        }
    }

    /// Creates the von Mises (J2) law, `mu = beta = 0`.
    ///
    /// # Errors
    /// [`PlasticityError`] under the conditions of [`DruckerPrager::new`].
    pub fn von_mises(
        shear_modulus: f64,
        poisson_ratio: f64,
        hardening: Hardening,
    ) -> Result<Self, PlasticityError> {
        Self::new(shear_modulus, poisson_ratio, 0.0, 0.0, hardening)
    }

    /// Shear modulus `G`. Units of stress.
    pub fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    /// Bulk modulus `K = 2 G (1 + nu) / (3 (1 - 2 nu))`. Units of stress.
    pub fn bulk_modulus(&self) -> f64 {
        let nu = self.poisson_ratio;
        2.0 * self.shear_modulus * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
    }

    /// Pressure coefficient `mu` of the yield function.
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Dilatancy `beta` of the flow rule.
    pub fn dilatancy(&self) -> f64 {
        self.dilatancy
    }

    /// Strength as a function of slip.
    pub fn hardening(&self) -> &Hardening {
        &self.hardening
    }

    /// Rate `Q : C : P = G + mu beta K` at which plastic flow at constant strain relaxes `tau + mu sigma_m`. Units of stress.
    pub fn flow_stiffness(&self) -> f64 {
        self.shear_modulus + self.friction * self.dilatancy * self.bulk_modulus()
    }

    /// Value `f` of the yield function; plastic flow keeps it at zero. Units of stress.
    pub fn yield_function(&self, stress: &Matrix3<f64>, slip: f64) -> f64 {
        equivalent_shear(&deviator(stress)) + self.friction * mean(stress)
            - self.hardening.strength(slip)
    }

    /// Stress `2 G dev e + K tr(e) 1` of an elastic strain.
    pub fn elastic_stress(&self, strain: &Matrix3<f64>) -> Matrix3<f64> {
        deviator(strain) * (2.0 * self.shear_modulus)
            + Matrix3::identity() * (self.bulk_modulus() * strain.trace())
    }

    /// Elastic strain `dev(sigma)/(2 G) + sigma_m/(3 K) 1` of a stress.
    pub fn elastic_strain(&self, stress: &Matrix3<f64>) -> Matrix3<f64> {
        deviator(stress) / (2.0 * self.shear_modulus)
            + Matrix3::identity() * (mean(stress) / (3.0 * self.bulk_modulus()))
    }

    /// Direction of plastic strain `P` and normal of the yield surface `Q` at a stress, symmetric and dimensionless.
    ///
    /// # Errors
    /// [`PlasticityError::NoDeviator`] if they are undefined.
    pub fn directions(
        &self,
        stress: &Matrix3<f64>,
    ) -> Result<(Matrix3<f64>, Matrix3<f64>), PlasticityError> {
        let deviator = deviator(stress);
        let shear = equivalent_shear(&deviator);
        if shear <= 1e-14 * stress.amax() {
            return Err(PlasticityError::NoDeviator);
        }
        let unit = deviator / (2.0 * shear);
        let spherical = Matrix3::identity() / 3.0;
        Ok((
            unit + spherical * self.dilatancy,
            unit + spherical * self.friction,
        ))
    }

    /// Continuum tangent `C - (C:P)(Q:C) / (h + Q:C:P)`: rate of stress by rate of strain during flow. Units of stress.
    ///
    /// # Errors
    /// [`PlasticityError::NoDeviator`] at the apex.
    pub fn continuum_tangent(
        &self,
        stress: &Matrix3<f64>,
        slip: f64,
    ) -> Result<FourthOrder, PlasticityError> {
        let (flow, normal) = self.directions(stress)?;
        let (a, b) = (self.elastic_stress(&flow), self.elastic_stress(&normal));
        let stiffness = self.hardening.modulus(slip) + self.flow_stiffness();
        Ok(self.tangent(1.0, self.bulk_modulus(), |i, j, k, l| {
            -a[(i, j)] * b[(k, l)] / stiffness
        }))
    }

    /// Tensor `2 G theta I_dev + K 1 1` plus another part.
    pub(super) fn tangent(
        &self,
        theta: f64,
        bulk: f64,
        other: impl Fn(usize, usize, usize, usize) -> f64,
    ) -> FourthOrder {
        let delta = |i: usize, j: usize| f64::from(u8::from(i == j));
        let shear = theta * self.shear_modulus;
        FourthOrder::from_fn(|i, j, k, l| {
            shear * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k))
                + (bulk - 2.0 / 3.0 * shear) * delta(i, j) * delta(k, l)
                + other(i, j, k, l)
        })
    }
}

/// Mean value: a third of the trace.
pub(super) fn mean(tensor: &Matrix3<f64>) -> f64 {
    tensor.trace() / 3.0
}

/// Traceless part of a tensor.
pub(super) fn deviator(tensor: &Matrix3<f64>) -> Matrix3<f64> {
    tensor - Matrix3::identity() * mean(tensor)
}

/// Equivalent shear `sqrt(s:s/2)` of a deviator.
pub(super) fn equivalent_shear(deviator: &Matrix3<f64>) -> f64 {
    (0.5 * deviator.norm_squared()).sqrt()
}
