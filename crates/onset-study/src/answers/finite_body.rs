//! Time steps of finite bodies, which differ from the step of the infinite lattice.

use super::problem::{Problem, ProblemError};
use crate::number::{counted, told_below};
use crate::settings::Units;
use onset::analysis::{FiniteBodyGround, FiniteBodyOscillations};
use onset::kinematics::DeformationGradient;
use onset::motion::{BodyError, Start};
use onset::time_step::{Integrator, Oscillation};
use serde::Serialize;

/// Kind of body for which the critical time step of the waves holds.
pub const LATTICE_NOTE: &str = "infinite lattice; free faces and distorted cells need less";

/// Ratio of the largest undamped step of an integrator to the step of central differences.
pub(super) fn reach_of(integrator: Integrator) -> f64 {
    integrator.undamped_reach() / Integrator::CentralDifferences.undamped_reach()
}

/// Time step for finite bodies of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FiniteBodyAnswer {
    /// Time step that is stable for finite bodies, with the integrator of the answer; time.
    pub time_step: f64,
    /// Whether the bound is proved.
    pub proved: bool,
    /// Reason, and the bodies for which it holds.
    pub ground: &'static str,
}

/// Critical time step of the body of a study.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BodyStepAnswer {
    /// Number of particles of the body.
    pub particles: usize,
    /// Critical time step at the state with fixed grips, with the integrator of the answer. Zero if no step is stable; `null` if nothing oscillates. Time.
    pub time_step: Option<f64>,
}

impl FiniteBodyAnswer {
    /// Returns the time step of an integrator for finite bodies with the given oscillations. `lattice` is the critical step of the waves.
    ///
    /// The result is `None` if no step is stable, or if it is unknown, as for damped waves and some integrators. The waves of stiffer increments limit
    /// the step, so their problem is passed if the state has any.
    pub fn new(
        problem: &Problem,
        bodies: &FiniteBodyOscillations,
        integrator: Integrator,
        lattice: Option<f64>,
    ) -> Option<Self> {
        let found = bodies.step(integrator, lattice.unwrap_or(f64::INFINITY));
        found.map(|found| {
            let (proved, ground) = match found.ground {
                FiniteBodyGround::Parts => (
                    true,
                    "any body: bound from its single elements or material points",
                ),
                FiniteBodyGround::Lattice => {
                    (true, "any body: bodies have fewer bonds than the lattice")
                }
                FiniteBodyGround::Blocks if problem.analysis.sites() > 1 => (
                    false,
                    "smallest step of free blocks of whole cells and of the infinite lattice; bodies cut through a cell can need less",
                ),
                FiniteBodyGround::Blocks => (
                    false,
                    "smallest step of free blocks and of the infinite lattice, for bodies three particles thick or more",
                ),
            };
            Self {
                time_step: found.time_step,
                proved,
                ground,
            }
        })
    }

    pub(crate) fn words(&self, units: Units) -> String {
        let how = if self.proved { "proved" } else { "computed" };
        format!(
            "stable below {} ({how}; {})",
            units.of(told_below(self.time_step), "s"),
            self.ground
        )
    }
}

impl BodyStepAnswer {
    /// Returns the critical step of an integrator for the body of the settings at a state; `None` without a body, and if damping changes the limit of the
    /// integrator by an unknown factor. The problem of stiffer increments is passed if the state has any.
    ///
    /// # Errors
    /// [`ProblemError`] when the method cannot run the body.
    pub fn new(
        problem: &Problem,
        f: &DeformationGradient,
        integrator: Integrator,
    ) -> Result<Option<Self>, ProblemError> {
        let Some(settings) = &problem.settings.body else {
            return Ok(None);
        };
        let (dimension, spacing) = (problem.dimension(), problem.analysis.spacing());
        settings.check_units(problem.settings.effective().units())?;
        let particles = settings.particles(dimension, spacing)?;
        let grips = settings.grips(dimension, spacing)?;
        let start = Start {
            f: *f,
            noise: 0.0,
            seed: 1,
        };
        let mut found = None;
        let contact = settings.contact();
        problem
            .analysis
            .with_body(&particles, &grips, contact, &mut |body| {
                let step = body.start(&start, 0.0);
                let fastest = step.and_then(|()| body.fastest_oscillation(Oscillation::NONE));
                found = Some(fastest.map(|fastest| {
                    let step = fastest.critical_time_step(integrator)?;
                    Some(Self {
                        particles: body.positions().len(),
                        time_step: Some(step).filter(|step| step.is_finite()),
                    })
                }));
            })?;
        match found {
            Some(found) => Ok(found?),
            None => Err(BodyError::Empty.into()),
        }
    }

    pub(crate) fn words(&self) -> String {
        format!("body of {}", counted(self.particles, "particle"))
    }

    /// The step in words.
    pub(super) fn told(&self, units: Units) -> String {
        match self.time_step {
            Some(0.0) => "no step is stable".to_owned(),
            Some(step) => format!("stable below {}", units.of(told_below(step), "s")),
            None => "nothing oscillates".to_owned(),
        }
    }
}

/// Hint for a body that cannot be built.
pub(crate) fn hint_on_body(error: &BodyError) -> &'static str {
    match error {
        BodyError::NoContact(_) => "omit body.contact",
        BodyError::NoBodies => {
            "bodies are run with discretization.method = \"updated-sph\" or \"total-lagrangian-sph\", without shear between pairs; the former without a penalty, the latter with discretization.gradient = \"kernel\" and without viscosity and velocity smoothing"
        }
        BodyError::Lonely { .. } => {
            "choose a larger discretization.support, or a body with more rows of particles"
        }
        BodyError::EmptyGrip { .. } => {
            "set grips.from and grips.to to corners of a box that contains particles, in particle spacings of the reference configuration"
        }
        BodyError::NoTangent => {
            "available for finite elements, peridynamics, SPH with a support that does not follow the deformation (updated SPH without shear between pairs), and kernel methods with nodal quadrature and discretization.frame = \"lagrangian\""
        }
        BodyError::NoStress { .. } | BodyError::NotConverged => {
            "choose an earlier time, or check the law and the reference positions"
        }
        BodyError::OtherElement { .. } => "set discretization.mesh to the elements of the run",
        BodyError::TooLarge { .. } => {
            "at most about 50,000 particles fit in 2D and 10,000 in 3D; choose a frame of a coarser run"
        }
        BodyError::HeldTwice { .. } => {
            "move the boxes of the grips apart: no particle may be in two of them"
        }
        BodyError::Method(_)
        | BodyError::Empty
        | BodyError::TooMany { .. }
        | BodyError::Number { .. }
        | BodyError::Coincident { .. } => {
            "give sizes of bodies in particle spacings, and positions in files as lengths"
        }
    }
}
