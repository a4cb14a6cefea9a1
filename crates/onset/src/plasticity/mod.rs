//! Rate-independent plasticity and its localization.
//!
//! The law of Drucker and Prager is given in the notation of J. W. Rudnicki and J. R. Rice, *J. Mech. Phys. Solids* 23 (1975) 371; von Mises (J2) is
//! the case without friction and dilatancy. With the deviator `s`, `tau = sqrt(s:s/2)` and the mean stress `sigma_m`,
//!
//! `f = tau + mu sigma_m - k(gamma) <= 0`, `P = s/(2 tau) + beta/3 1`, `Q = s/(2 tau) + mu/3 1`, `h = dk/dgamma`,
//!
//! plastic strain rate `P gamma'`, normal `Q` to the yield surface, plastic shear strain `gamma` (the *slip*), plastic modulus `h`. A tension test
//! has the yield stress `sqrt(3) k` and the plastic modulus `3 h` if `mu = beta = 0`.
//!
//! - Small strain: [`DruckerPrager::update`], [`DruckerPrager::continuum_tangent`].
//! - Finite strain, `F = F_e F_p`, Hencky elasticity, this law for the Kirchhoff stress: [`DruckerPrager::finite_update`].
//! - [`RateModuli`]: the acoustic tensor of a state and the critical hardening moduli, for two criteria that differ if `mu != beta`: [`Criterion`].
//! - [`library`]: laws of flow and damage as materials of a discretization, with the continuum tangent at the end of a proportional path, and
//!   hypoelastic laws, which are in rate form too.
//! - [`FlowLaw`]: other laws along fixed axes, each defined by its elasticity `C`, direction of flow `P`, normal `Q` and plastic modulus `h`:
//!   [`MohrCoulomb`], [`CamClay`], [`EllipticCap`], [`HillOrthotropic`], [`Gurson`], [`Kinematic`], [`DeformationTheory`], [`ScalarDamage`].
//! - [`follow`]: a loading path of any of them, and the first slip at which `h` falls to the critical modulus.
//! - [`follow_increments`]: a loading path of a law that is known only by its response to increments, [`IncrementalLaw`].
//!
//! Two tangents must be distinguished. The *continuum* tangent relates the rates of stress and strain during flow. Waves, bands and every condition
//! of localization are statements on rates and use it. The *consistent* tangent is the derivative of the stress after a finite step of the return
//! mapping. Newton's method needs it, and it depends on the size of the step. The two agree in the limit of small steps.

mod coaxial;
mod cubic;
mod finite;
mod flow;
mod hardening;
mod hypoelastic;
mod increments;
mod integration;
mod law;
mod laws;
mod localization;
mod metal;
mod moduli;
mod path;
mod return_mapping;
mod search;
mod spectral;
mod walk;

pub use finite::{FiniteState, FiniteUpdate};
pub use flow::{Elasticity, Flow, FlowLaw};
pub use hardening::{FlowStress, Hardening};
pub use increments::{IncrementalLaw, follow_increments};
pub use law::DruckerPrager;
pub use laws::{
    CamClay, DeformationTheory, EllipticCap, Gurson, HillOrthotropic, Kinematic, MohrCoulomb,
    ScalarDamage,
};
pub use localization::{Band, BandKind, Criterion, Critical};
pub use moduli::RateModuli;
pub use path::{Bands, End, Load, Loading, LoadingPath, Localization, PathPoint, Strains, follow};
pub use return_mapping::{Branch, State, Update};

use crate::kinematics::DeformationGradient;
use crate::material::{FourthOrder, Hyperelastic, Law, MaterialError, Response};
use crate::real::plain;
use std::sync::Arc;
use thiserror::Error;

/// Named laws in rate form: laws with plastic flow or damage, and hypoelastic laws.
///
/// The stress belongs to the end of the path `R U^t`, `0 <= t <= 1`, to a state `F = R U`, and the tangent to loading that continues from there.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::plasticity::library;
/// let steel = library()[0].build(&[("mu", 80.0), ("yield-stress", 0.4), ("hardening-modulus", 0.0), ("saturation-stress", 0.0)])?;
/// // An isochoric stretch beyond yield: the difference of principal Kirchhoff stresses is 2/sqrt(3) of the flow stress.
/// let state = DeformationGradient::from_stretches([1.1, 1.0 / 1.1, 1.0])?;
/// let cauchy = steel.response(&state)?.cauchy();
/// assert!((cauchy[(0, 0)] - cauchy[(1, 1)] - 0.4 * 2.0 / 3.0_f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn library() -> &'static [Law] {
    LIBRARY
}

/// Named laws that yield: the tangent for loading that continues differs from the tangent for unloading.
pub fn yielding() -> &'static [Law] {
    &LIBRARY[..FLOWS.len()]
}

/// Flow along the axes of a path of a named law that yields, from some parameters given by name, with defaults for the others; `None` for other
/// laws.
///
/// ```
/// use onset::plasticity::{flow_law, yielding};
/// let steel = flow_law(&yielding()[0], &[("yield-stress", 0.3)]).ok_or("no flow")??;
/// // The strength is the yield stress in shear.
/// assert!((steel.strength() - 0.3 / 3.0_f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PlasticityError`] if a parameter is unknown or not admissible.
pub fn flow_law(
    law: &Law,
    given: &[(&str, f64)],
) -> Option<Result<Box<dyn FlowLaw>, PlasticityError>> {
    let at = yielding().iter().position(|own| own == law)?;
    let checked = law.checked(given).map_err(PlasticityError::from);
    Some(checked.and_then(|parameters| FLOWS[at](&parameters)))
}

/// Constructor of a law that flows from all parameters.
type MakeFlow = fn(&[f64]) -> Result<Box<dyn FlowLaw>, PlasticityError>;

fn boxed<L: FlowLaw + 'static>(
    law: Result<L, PlasticityError>,
) -> Result<Box<dyn FlowLaw>, PlasticityError> {
    law.map(|law| -> Box<dyn FlowLaw> { Box::new(law) })
}

/// Flow of each law that yields, in the order of the library.
const FLOWS: [MakeFlow; 10] = [
    |p| boxed(metal::j2(p)),
    |p| boxed(metal::hill(p)),
    |p| boxed(law::drucker_prager(p)),
    |p| boxed(laws::mohr_coulomb(p)),
    |p| boxed(laws::cap(p)),
    |p| boxed(laws::cam_clay(p)),
    |p| boxed(laws::gurson(p)),
    |p| boxed(laws::kinematic(p)),
    |p| boxed(laws::damage(p)),
    |p| boxed(laws::deformation_theory(p)),
];

/// Laws that yield come first.
const LIBRARY: &[Law] = &[
    metal::J2,
    metal::HILL,
    law::DRUCKER_PRAGER,
    laws::MOHR_COULOMB,
    laws::CAP,
    laws::CAM_CLAY,
    laws::GURSON,
    laws::KINEMATIC,
    laws::DAMAGE,
    laws::DEFORMATION_THEORY,
    hypoelastic::JAUMANN,
    hypoelastic::GREEN_NAGHDI,
];

/// Law for increments that unload: its stress, and the tangent of unloading if the law flows.
///
/// A disturbance of a flowing state loads in some regions and unloads in others. The tangents of loading and unloading bound its response.
pub struct Unloading(pub Arc<dyn Hyperelastic>);

impl Hyperelastic for Unloading {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let response = self.0.response(f)?;
        Ok(match self.0.unloading_tangent(f)? {
            None => response,
            Some(tangent) => Response {
                tangent,
                ..response
            },
        })
    }

    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn is_path_dependent(&self) -> bool {
        self.0.is_path_dependent()
    }

    fn integrated_tangent(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        self.0.integrated_tangent(f)
    }
}

/// Error of a plastic law or of one of its states.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlasticityError {
    /// A parameter is outside its admissible range.
    #[error("parameter {name} is {}; expected {expected}", plain(*value))]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Description of the admissible range.
        expected: &'static str,
    },
    /// The law softens so fast that the strain does not determine the stress.
    #[error(
        "the law softens too fast: its plastic modulus falls to {modulus:.4e}, but must stay above {least:.4e} = -Q:C:P, \
         below which a strain does not determine the stress"
    )]
    SnapBack {
        /// Smallest plastic modulus of the law.
        modulus: f64,
        /// Lower limit of the plastic modulus.
        least: f64,
    },
    /// The strength has fallen to zero.
    #[error("the strength is exhausted: it has fallen to zero at the plastic shear strain {slip}")]
    Exhausted {
        /// Slip at which the strength vanishes.
        slip: f64,
    },
    /// The stress is beyond the apex of the cone, and no plastic flow leads back.
    #[error(
        "the mean stress is beyond the apex of the yield cone, and without dilatancy no plastic flow relaxes it"
    )]
    Apex,
    /// The stress deviator vanishes, so neither flow nor normal has a direction.
    #[error("the stress has no deviator; the directions of flow and yield are undefined there")]
    NoDeviator,
    /// Another face of the yield surface is reached.
    #[error(
        "the intermediate principal stress reaches the largest or the smallest one: a corner of the yield surface"
    )]
    Corner,
    /// The elastic part alone is not strongly elliptic.
    #[error(
        "the elastic part of the law has itself lost strong ellipticity (elastic strains are too large)"
    )]
    ElasticNotElliptic,
    /// Stress or strain over- or underflow.
    #[error("the stress is not finite at this strain")]
    NotFinite,
    /// The initial stress is at or beyond the yield surface.
    #[error(
        "the material yields under the confinement {confinement} alone; expected a pressure within the yield surface"
    )]
    Confinement {
        /// Confining pressure of the loading.
        confinement: f64,
    },
    /// The material does not yield along a path.
    #[error("the material stays elastic on this path up to a strain of {strain}")]
    NeverYields {
        /// Largest strain that was tried.
        strain: f64,
    },
    /// Bands in a sheet need a stress-free surface.
    #[error(
        "bands in a sheet need a path that keeps the third stress zero: uniaxial-stress or sheet-stretch without confinement"
    )]
    NotASheet,
    /// An incremental law fails.
    #[error(transparent)]
    Law(#[from] MaterialError),
    /// The tangent couples shear with normal strains along the axes of the path.
    #[error(
        "the tangent couples shears with strains along the axes of the path; expected a law that is isotropic, or orthotropic along these axes"
    )]
    NotAlongAxes,
    /// The reduction of the elastic tangent by flow is not of rank one.
    #[error(
        "plastic flow reduces the elastic tangent by a part that is not of rank one: several mechanisms flow together; expected a law with one, away from corners of its \
         yield surface"
    )]
    SeveralMechanisms,
    /// Loading and unloading have the same tangent.
    #[error("the law does not flow: its loading and unloading tangents are the same")]
    Unloads,
    /// The law already flows in the first small increment.
    #[error(
        "the law flows plastically from the first increment; expected an elastic range with an unloading tangent"
    )]
    NoElasticRange,
    /// The lateral stresses cannot be kept constant.
    #[error("no lateral strains were found that keep the lateral stresses constant")]
    NoBalance,
}

impl PlasticityError {
    fn require(
        holds: bool,
        name: &'static str,
        value: f64,
        expected: &'static str,
    ) -> Result<(), Self> {
        if holds && value.is_finite() {
            Ok(())
        } else {
            Err(Self::Parameter {
                name,
                value,
                expected,
            })
        }
    }
}
