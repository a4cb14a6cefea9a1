//! Updated SPH of solids in PySPH: the equations of Gray, Monaghan and Swift with their artificial stress.
//!
//! Pressures depend on the density, and deviatoric stresses follow the Jaumann rate. The particles of a deck start with the deviatoric stress of the
//! state.
//!
//! Source: Ramachandran and others, ACM Trans. Math. Softw. 47 (2021) 34; `pysph/sph/integrator.py`, `pysph/sph/solid_mech/basic.py`.

use super::super::law::JaumannRates;
use super::super::{Code, Deck, Program, Projector, Record, Settled, VerifyError};
use super::plain;
use crate::answers::Problem;
use crate::output::{Files, text};
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use onset::time_step::Stepping;
use std::path::Path;

pub(super) struct PySph;

const NAME: &str = "pysph";

/// Script that reads the particles of the deck; the numbers of the case are written before it.
const SCRIPT: &str = include_str!("pysph_wave.py");

fn refused(what: impl Into<String>, hint: &str) -> VerifyError {
    VerifyError::Refused {
        code: NAME,
        what: what.into(),
        hint: hint.to_owned(),
    }
}

/// Pressure, deviator and shear modulus of the law at the state, if its stress rate is the rate of the code.
fn rates(problem: &Problem, f: &DeformationGradient) -> Result<JaumannRates, VerifyError> {
    if problem.dimension() != 2 || f.components()[2][2] != 1.0 {
        return Err(refused(
            "decks are planar, with an out-of-plane stretch of 1",
            "set discretization.lattice=square, and omit the third stretch",
        ));
    }
    let own = JaumannRates::of(&*problem.material, f, 1.0).map_err(MethodError::from)?;
    let own = own.ok_or_else(|| {
        refused(
            "decks have a pressure that depends on the density alone, and a deviator with Jaumann's rate",
            "choose --set material.model=hypoelastic-jaumann --set material.n=1, or a purely volumetric law, such as --energy \"K*(J-ln(J))\" --set material.K=1",
        )
    })?;
    if own.volumetric.slope <= 0.0 {
        return Err(refused(
            "the pressure of the law decreases with the density at this state",
            "choose another state",
        ));
    }
    Ok(own)
}

fn script(deck: &Deck<'_>) -> Result<String, VerifyError> {
    let case = deck.case;
    let settings = &deck.problem.settings;
    let own = rates(deck.problem, deck.f)?;
    let [s00, s11, s22] = own.deviator;
    // p = p0 + c^2 (rho - rho0), the tangent of the law at the state.
    let square = own.volumetric.slope / case.density;
    let change = case.density / deck.f.jacobian() - case.density;
    let numbers = [
        ("DENSITY", case.density),
        ("SOUND", square.sqrt()),
        ("PRESSURE", own.volumetric.pressure - square * change),
        ("SHEAR", own.shear),
        ("DEVIATOR_X", s00),
        ("DEVIATOR_Y", s11),
        ("DEVIATOR_Z", s22),
        (
            "SMOOTHING",
            0.5 * settings.discretization.support * settings.discretization.spacing,
        ),
        ("SPACING", settings.discretization.spacing),
        ("ARTIFICIAL_STRESS", settings.method.artificial_stress),
        ("EXPONENT", settings.method.artificial_stress_exponent),
        ("TIME_STEP", case.time_step),
        ("LENGTH_X", case.lengths()[0]),
        ("LENGTH_Y", case.lengths()[1]),
    ];
    let numbers = numbers.map(|(name, value)| format!("{name} = {value:.17e}\n"));
    Ok(format!(
        "# {NAME}, onset case {id}: run with `python wave.py`, read with `onset verify read`\n\
         CASE = \"{id}\"\nSTEPS = {}\nEVERY = {}\n{}{SCRIPT}",
        case.steps,
        case.every,
        numbers.concat(),
        id = case.id,
    ))
}

impl Code for PySph {
    fn name(&self) -> &'static str {
        NAME
    }

    fn title(&self) -> &'static str {
        "updated SPH of solids in PySPH, with the artificial stress of Gray, Monaghan and Swift"
    }

    fn dialect(&self) -> &'static [Settled] {
        const {
            &[
                Settled::exactly("discretization.method", "updated-sph"),
                Settled::exactly("discretization.lattice", "square"),
                Settled::exactly("discretization.kernel", "cubic-spline"),
                Settled::exactly("discretization.momentum", "symmetric"),
                Settled::exactly("discretization.density-evolution", "continuity"),
                Settled::exactly("discretization.corrected", "false"),
                Settled::exactly("discretization.support-size", "fixed"),
                Settled::exactly("discretization.viscosity", "0"),
                Settled::exactly("discretization.velocity-smoothing", "0"),
            ]
        }
    }

    fn remarks(&self) -> &'static [&'static str] {
        &[
            "PECIntegrator predicts with the accelerations of the step before: a two-step method of Adams and Bashforth",
        ]
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn tolerance(&self) -> f64 {
        1e-4
    }

    fn stepping(
        &self,
        problem: &Problem,
        f: &DeformationGradient,
    ) -> Result<Stepping, VerifyError> {
        rates(problem, f).map(|_| Stepping::LateAcceleration)
    }

    fn deck(&self, deck: &Deck<'_>) -> Result<Files, VerifyError> {
        Ok(vec![
            text("wave.py", script(deck)?),
            text("particles.csv", plain::particles(deck)),
        ])
    }

    fn program(&self) -> Option<Program> {
        Some(Program {
            name: "python3",
            arguments: &["wave.py", "--disable-output"],
            install: "`pip install pysph` installs it, with a C++ compiler; name the interpreter of its environment with --program",
        })
    }

    fn output(&self) -> &'static str {
        "wave.csv"
    }

    fn read(&self, _: &Path, text: &str, projector: Projector<'_>) -> Result<Record, VerifyError> {
        plain::read_csv(text, projector)
    }
}
