//! Isotropic laws that flow as materials of a discretization: soils, rocks, porous metals and damage.
//!
//! The laws implement [`super::FlowLaw`]. At finite strain `F = F_e F_p`, with Hencky's law `tau = C : e_e` for the Kirchhoff stress with the
//! logarithmic elastic strain `e_e = 1/2 ln F_e F_e^T`, and a yield function and a direction of flow in the stress `tau` (J. C. Simo, *Comput. Methods
//! Appl. Mech. Engrg.* 99 (1992) 61). Damage reduces `C` instead. The reference configuration may be under an initial pressure `p`; `tau` is then
//! measured per unit of the volume under pressure.
//!
//! A state `F = R U` is reached along `R U^t`, `0 <= t <= 1`. All tensors keep the axes of `U`, and strains add up:
//!
//! `tau' = C : (ln U - P g')`, `Q : tau' = h g'` during flow,
//!
//! integrated with controlled error. Where the material unloads along the path, it is elastic until it yields again.
//!
//! **Tangent.** In the principal axes with the elastic moduli `a_ijkl` of Hencky's law,
//!
//! `F_jJ F_lL A_iJkL = a_ijkl - (C:P)_ij (Q:C)_kl / (h + Q:C:P)`
//!
//! for loading that continues, which has no major symmetry if `P` and `Q` differ (nonassociated flow), and `a_ijkl` for unloading. The response to a
//! perturbation lies between these two tangents. With associated flow the tangent of loading is R. Hill's linear comparison solid (*J. Mech. Phys.
//! Solids* 6 (1958) 236), and a state that is stable for it is stable.

use super::finite::{SpatialModuli, inverse};
use super::flow::{Elasticity, Flow, FlowLaw};
use super::integration::{Stop, Stopped, integrate};
use super::spectral::Spectral;
use super::walk::bisect;
use super::{Hardening, PlasticityError};
use crate::kinematics::DeformationGradient;
use crate::material::{
    Admitted, FourthOrder, Hyperelastic, Made, MaterialError, Parameter, Response,
};
use nalgebra::{Matrix3, SVector, Vector3};
use std::ops::ControlFlow;

/// Relative error of the stress along a path.
const ACCURACY: f64 = 1e-10;
/// Smallest unit of the error of the stress, in units of the strength.
const EXHAUSTED: f64 = 1e-3;
/// Largest excess, in units of the strength, of an elastic state after unloading. It exceeds the error of the integration.
const YIELD_TOLERANCE: f64 = 1e-8;
/// Largest number of times that a path may unload.
const MOST_UNLOADINGS: usize = 100;

pub(super) const MU: Parameter = Parameter::new(
    "mu",
    "stress",
    10_000.0,
    Admitted::Positive,
    "shear modulus",
);
pub(super) const KAPPA: Parameter = Parameter::new(
    "kappa",
    "stress",
    13_000.0,
    Admitted::Positive,
    "bulk modulus",
);
pub(super) const CONFINEMENT: Parameter = Parameter::new(
    "confinement",
    "stress",
    0.0,
    Admitted::NotNegative,
    "pressure at F = 1, from which deformations are measured",
);
pub(super) const STRENGTH: Parameter = Parameter::new(
    "strength",
    "stress",
    20.0,
    Admitted::Positive,
    "yield stress in pure shear at first yield",
);
pub(super) const RESIDUAL: Parameter = Parameter::new(
    "residual",
    "stress",
    10.0,
    Admitted::NotNegative,
    "strength after large slip",
);
pub(super) const MODULUS: Parameter = Parameter::new(
    "hardening-modulus",
    "stress",
    2000.0,
    Admitted::Any,
    "slope of the strength before it decays to the residual strength; negative to soften",
);
pub(super) const SLIP: Parameter = Parameter::new(
    "reference-slip",
    "1",
    0.05,
    Admitted::Positive,
    "plastic shear strain over which the strength decays to the residual strength by the factor 1/e",
);

/// Elasticity of the first two parameters of these laws, `mu` and `kappa`.
pub(super) fn elasticity(p: &[f64]) -> Elasticity {
    Elasticity {
        shear: p[0],
        bulk: p[1],
    }
}

/// Hardening of the parameters `strength`, `residual`, `hardening-modulus` and `reference-slip`.
pub(super) fn hardening(p: &[f64]) -> Hardening {
    Hardening::Peak {
        initial: p[0],
        residual: p[1],
        modulus: p[2],
        reference: p[3],
    }
}

/// Isotropic law that flows, with the pressure in its reference configuration.
struct Coaxial<L> {
    law: L,
    confinement: f64,
}

/// Creates a material from a law and the pressure in its reference configuration.
pub(super) fn coaxial<L: FlowLaw + Send + Sync + 'static>(
    law: Result<L, PlasticityError>,
    confinement: f64,
) -> Made {
    let law = law.map_err(|error| match error {
        PlasticityError::Parameter {
            name,
            value,
            expected,
        } => MaterialError::Parameter {
            name,
            value,
            expected: expected.to_owned(),
        },
        other => MaterialError::External {
            message: format!(
                "{other}\n  hint: a larger material.reference-slip softens more slowly"
            ),
        },
    })?;
    let stress = Vector3::repeat(-confinement);
    if law.excess(&stress, 0.0, &law.start(&stress).0) >= 0.0 {
        return Err(MaterialError::Parameter {
            name: "confinement",
            value: confinement,
            expected: "a pressure at which the material does not yield".to_owned(),
        });
    }
    Ok(Box::new(Coaxial { law, confinement }))
}

/// State at the end of a path, in the axes of the path.
struct Reached {
    stress: Vector3<f64>,
    elasticity: Elasticity,
    /// Continued flow, and the start of a continued integration; `None` if the state is elastic.
    flow: Option<(Flow, Point)>,
}

/// Principal stresses, slip and internal variables.
type Point = SVector<f64, 7>;

fn joined(stress: &Vector3<f64>, slip: f64, internal: &Vector3<f64>) -> Point {
    Point::from_fn(|n, _| match n {
        0..3 => stress[n],
        3 => slip,
        _ => internal[n - 4],
    })
}

fn split(y: &Point) -> (Vector3<f64>, f64, Vector3<f64>) {
    (
        y.fixed_rows::<3>(0).into_owned(),
        y[3],
        y.fixed_rows::<3>(4).into_owned(),
    )
}

/// Reason why the flow cannot be followed along a path.
enum Halt {
    Unloads,
    TurnsBack,
    Law(PlasticityError),
}

impl<L: FlowLaw> Coaxial<L> {
    /// Follows the path to logarithmic strains along its axes, from its beginning or from a flowing state at a fraction of it.
    fn followed(
        &self,
        strain: &Vector3<f64>,
        flowing: Option<(f64, Point)>,
    ) -> Result<Reached, MaterialError> {
        let mut unloaded = None;
        let mut from = flowing;
        for _ in 0..MOST_UNLOADINGS {
            let (at, y) = match from {
                Some(flowing) => flowing,
                None => match self.loaded(strain, unloaded) {
                    ControlFlow::Continue(flowing) => flowing,
                    ControlFlow::Break(elastic) => return Ok(elastic),
                },
            };
            match self.flowed(&y, strain, at) {
                Ok(end) => return self.flowing(end),
                Err(Stopped {
                    why: Stop::Rates(Halt::Unloads),
                    y,
                    x,
                }) => (from, unloaded) = (None, Some((x, y))),
                Err(Stopped {
                    why: Stop::Rates(halt),
                    x,
                    ..
                }) => return Err(outside(x, &halt)),
                Err(Stopped { x, .. }) => return Err(too_many_steps(x)),
            }
        }
        Err(too_many_steps(unloaded.map_or(0.0, |(x, _)| x)))
    }

    /// Follows the elastic part of a path, from its beginning or after unloading, to the yield surface. Returns the path parameter and the state
    /// there, or the state at the end of the path if it is elastic.
    fn loaded(
        &self,
        strain: &Vector3<f64>,
        unloaded: Option<(f64, Point)>,
    ) -> ControlFlow<Reached, (f64, Point)> {
        let law = &self.law;
        let initial = Vector3::repeat(-self.confinement);
        let (reached, y) =
            unloaded.unwrap_or_else(|| (0.0, joined(&initial, 0.0, &law.start(&initial).0)));
        let (begun, slip, internal) = split(&y);
        let elasticity = law.unloading(slip);
        let rate = elasticity.stress(strain);
        let at = |t: f64| begun + rate * (t - reached);
        let admitted = unloaded.map_or(0.0, |_| YIELD_TOLERANCE * law.strength());
        let internal = |stress: &Vector3<f64>| match unloaded {
            None => law.start(stress).0,
            Some(_) => internal,
        };
        // The elastic range is convex, so the path leaves it once.
        let is_elastic = |t: f64| law.excess(&at(t), slip, &internal(&at(t))) <= admitted;
        if is_elastic(1.0) {
            return ControlFlow::Break(Reached {
                stress: at(1.0),
                elasticity,
                flow: None,
            });
        }
        let yielding = bisect(reached, 1.0, is_elastic);
        let stress = at(yielding);
        ControlFlow::Continue((yielding, joined(&stress, slip, &internal(&stress))))
    }

    /// State at the end of a path that flows there.
    fn flowing(&self, end: Point) -> Result<Reached, MaterialError> {
        let (stress, slip, internal) = split(&end);
        let flow = match self.law.faces(&internal) {
            1 => self.law.flow(&stress, slip, &internal),
            _ => Err(PlasticityError::Corner),
        };
        let flow = flow.map_err(|error| outside(1.0, &Halt::Law(error)))?;
        Ok(Reached {
            stress,
            elasticity: flow.elasticity,
            flow: Some((flow, end)),
        })
    }

    /// Integrates the flow from a point on the yield surface to the end of the path.
    fn flowed(
        &self,
        start: &Point,
        strain: &Vector3<f64>,
        from: f64,
    ) -> Result<Point, Stopped<7, Halt>> {
        let law = &self.law;
        let (begun, slip, internal) = split(start);
        let elastic = law.unloading(slip).stress(strain);
        let at = |t: f64| law.flowed_at_once(&(begun + elastic * (t - from)), slip);
        match at(1.0) {
            Some(Ok((stress, slip))) => return Ok(joined(&stress, slip, &internal)),
            Some(Err(error)) => {
                return Err(Stopped {
                    why: Stop::Rates(Halt::Law(error)),
                    y: *start,
                    x: bisect(from, 1.0, |t| at(t).is_none_or(|end| end.is_ok())),
                });
            }
            None => {}
        }
        let rates = |y: &Point, _: f64| {
            let (stress, slip, internal) = split(y);
            let flow = law.flow(&stress, slip, &internal).map_err(Halt::Law)?;
            let stiffness = flow.hardening + flow.per_slip * flow.relaxation();
            if stiffness.is_nan() || stiffness <= 0.0 {
                return Err(Halt::TurnsBack);
            }
            let elastic = flow.elasticity.stress(strain);
            let rate = flow.normal.dot(&elastic) / stiffness;
            if rate < 0.0 {
                return Err(Halt::Unloads);
            }
            let relaxed = flow.elasticity.stress(&flow.direction) * flow.per_slip;
            let change = joined(&(elastic - relaxed * rate), rate, &(flow.internal * rate));
            match change.iter().all(|part| part.is_finite()) {
                true => Ok(change),
                false => Err(Halt::Law(PlasticityError::NotFinite)),
            }
        };
        let strength = law.strength();
        let internal = law.start(&split(start).0).1;
        // The direction of flow follows from the stress, also from the small stress after softening.
        let size = |y: &Point| {
            let stress = split(y).0.amax().clamp(EXHAUSTED * strength, strength);
            let slip = strength / law.elasticity().shear;
            joined(&Vector3::repeat(stress), slip, &internal)
        };
        integrate(start, [from, 1.0], size, ACCURACY, rates)
    }

    /// State at the end of the path to a deformation, with the axes.
    fn at(&self, f: &DeformationGradient) -> Result<(Reached, Matrix3<f64>), MaterialError> {
        let matrix = f.matrix();
        let logarithm = Spectral::half_logarithm(&(matrix * matrix.transpose()));
        let logarithm = logarithm.ok_or_else(|| MaterialError::NotFinite {
            jacobian: f.jacobian(),
        })?;
        Ok((self.followed(&logarithm.values, None)?, logarithm.axes))
    }
}

impl Reached {
    /// Elastic moduli in the principal axes.
    fn moduli(&self) -> SpatialModuli {
        SpatialModuli::new(
            self.elasticity.normal(),
            &self.stress,
            &self.elasticity.strain(&self.stress),
            self.elasticity.shear,
        )
    }

    /// Response for loading that continues. Its energy is the stored elastic energy.
    fn response(
        &self,
        f: &DeformationGradient,
        axes: &Matrix3<f64>,
    ) -> Result<Response, MaterialError> {
        let mut moduli = self.moduli();
        if let Some((flow, _)) = &self.flow {
            let (flowed, loading) = (&flow.direction, &flow.normal);
            let elasticity = &flow.elasticity;
            moduli.normal -= elasticity.stress(flowed) * elasticity.stress(loading).transpose()
                / (flow.modulus() + flow.relaxation());
        }
        let stress = axes * Matrix3::from_diagonal(&self.stress) * axes.transpose();
        Response {
            deformation: *f,
            energy: 0.5 * self.stress.dot(&self.elasticity.strain(&self.stress)),
            first_piola: stress * inverse(f).transpose(),
            tangent: moduli.pulled_back(f, axes),
        }
        .finite()
    }
}

fn outside(reached: f64, halt: &Halt) -> MaterialError {
    MaterialError::OutsideDomain {
        what: "the fraction of the path to the state that can be followed",
        value: reached,
        expected: match halt {
            Halt::Unloads => "beyond it the material unloads".to_owned(),
            Halt::TurnsBack => {
                "beyond it the law softens so fast that the strain does not determine the stress"
                    .to_owned()
            }
            Halt::Law(error) => format!("beyond it {error}"),
        },
    }
}

fn too_many_steps(reached: f64) -> MaterialError {
    MaterialError::OutsideDomain {
        what: "the fraction of the path to the state that can be followed",
        value: reached,
        expected: "too many short steps are needed beyond it".to_owned(),
    }
}

impl<L: FlowLaw + Send + Sync> Hyperelastic for Coaxial<L> {
    fn is_path_dependent(&self) -> bool {
        true
    }

    /// Response of the law. Its energy is the stored elastic energy; stress and tangent of a flowing material have no potential.
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let (reached, axes) = self.at(f)?;
        reached.response(f, &axes)
    }

    /// Responses along a ray, which forms a single path: each state is reached from the nearest preceding flowing state.
    fn along<'a>(&'a self, logarithms: [f64; 3]) -> Box<dyn FnMut(f64) -> Option<Response> + 'a> {
        let direction = Vector3::from(logarithms);
        let mut passed: Vec<(f64, Point)> = Vec::new();
        Box::new(move |t| {
            let strain = direction * t;
            let f = DeformationGradient::from_stretches(strain.map(f64::exp).into()).ok()?;
            let place = passed.partition_point(|(before, _)| *before <= t);
            let flowing = place.checked_sub(1).map(|n| passed[n]);
            let flowing = flowing.map(|(before, y)| (before / t, y));
            let reached = self.followed(&strain, flowing).ok()?;
            if let Some((_, y)) = reached.flow {
                passed.insert(place, (t, y));
            }
            reached.response(&f, &Matrix3::identity()).ok()
        })
    }

    fn unloading_tangent(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        let (reached, axes) = self.at(f)?;
        let flows = reached.flow.is_some() && self.law.unloads();
        Ok(flows.then(|| reached.moduli().pulled_back(f, &axes)))
    }
}
