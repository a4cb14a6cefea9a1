//! Updated-Lagrangian SPH of LAMMPS' package SMD (`pair_style smd/ulsph`) with the density that continuity integrates.
//!
//! Source: `pair_smd_ulsph.cpp`, `fix_smd_integrate_ulsph.cpp`: velocity gradients are those of velocities extrapolated from the step before, and
//! the volume that they integrate is used one step later.

use super::super::law::Volumetric;
use super::super::{Code, Deck, Program, Projector, Record, Settled, VerifyError};
use super::lammps::{self, number};
use crate::answers::Problem;
use crate::output::{Files, text};
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use onset::time_step::Stepping;
use std::fmt::Write;
use std::path::Path;

/// The adapter.
pub(super) struct UpdatedSmd;

const NAME: &str = "lammps-smd-ulsph";

fn refused(what: impl Into<String>, hint: &str) -> VerifyError {
    VerifyError::Refused {
        code: NAME,
        what: what.into(),
        hint: hint.to_owned(),
    }
}

/// Pressure of the law at the state; that it is one of density alone.
fn pressure(problem: &Problem, f: &DeformationGradient) -> Result<Volumetric, VerifyError> {
    if problem.dimension() != 2 || f.components()[2][2] != 1.0 {
        return Err(refused(
            "decks are planar, with the stretch 1 out of the plane",
            "leave out the third stretch",
        ));
    }
    let own = Volumetric::of(&*problem.material, f).map_err(MethodError::from)?;
    let own = own.ok_or_else(|| {
        refused(
            "the equations of state of the code are functions of the density alone",
            "choose a law of the volume alone, such as --energy \"K*(J-ln(J))\" --set material.K=1",
        )
    })?;
    if own.slope <= 0.0 {
        return Err(refused(
            "the pressure of the law falls with the density at this state, which Tait's equation cannot",
            "choose another state",
        ));
    }
    Ok(own)
}

fn particles(deck: &Deck<'_>) -> String {
    let case = deck.case;
    let choices = &deck.problem.settings.discretization;
    let volume = case.block.volume();
    let [current, mass] = [volume * deck.f.jacobian(), volume * case.density].map(number);
    let radius = number(0.5 * choices.support * choices.spacing);
    let mut data = format!(
        "{NAME}, onset case {}\n\n{} atoms\n1 atom types\n\n{}\nAtoms # smd\n\n",
        case.id,
        case.block.particles(),
        lammps::bounds(case)
    );
    for index in 0..case.block.particles() {
        let [x, y, z] = case.place(index).map(number);
        let _ = writeln!(
            data,
            "{} 1 1 {current} {mass} {radius} {radius} {x} {y} {z} {x} {y} {z}",
            index + 1
        );
    }
    data + &lammps::velocities(case)
}

fn input(deck: &Deck<'_>) -> Result<String, VerifyError> {
    let case = deck.case;
    let own = pressure(deck.problem, deck.f)?;
    // Tait's equation with the exponent 1, p = c^2 (rho - rho_p), is the tangent of the law at the state.
    let square = own.slope / case.density;
    let free = case.density / deck.f.jacobian() - own.pressure / square;
    Ok(format!(
        "# {NAME}, onset case {}: run with `lmp -in in.lammps`, read with `onset verify read`\n\
         dimension 2\nunits si\nboundary p p p\natom_style smd\natom_modify map array sort 0 0\n\
         comm_modify vel yes\nneigh_modify every 10 delay 0 check yes\nnewton off\nread_data particles.data\n\
         group ulsph type 1\nneighbor {} bin\n\
         pair_style smd/ulsph *DENSITY_CONTINUITY *VELOCITY_GRADIENT *NO_GRADIENT_CORRECTION\n\
         pair_coeff 1 1 *COMMON {} {} 0.0 1.0 0.0 *EOS_TAIT 1.0 *END\n\
         fix integrate all smd/integrate_ulsph\ntimestep {}\nthermo 1000\n{}run {}\n",
        case.id,
        number(0.5 * case.spacing()),
        number(free),
        number(square.sqrt()),
        number(case.time_step),
        lammps::dump(case, "all"),
        case.steps
    ))
}

impl Code for UpdatedSmd {
    fn name(&self) -> &'static str {
        NAME
    }

    fn title(&self) -> &'static str {
        "updated-Lagrangian SPH of LAMMPS' package SMD, smd/ulsph *DENSITY_CONTINUITY *NO_GRADIENT_CORRECTION"
    }

    fn dialect(&self) -> &'static [Settled] {
        const {
            &[
                Settled::exactly("discretization.method", "updated-sph"),
                Settled::exactly("discretization.lattice", "square"),
                Settled::deviating(
                    "discretization.kernel",
                    "(1-q)^3",
                    "the spiky kernel of Desbrun and Gascuel (1996)",
                ),
                Settled::exactly("discretization.momentum", "mean"),
                Settled::exactly("discretization.density-evolution", "continuity"),
                Settled::deviating(
                    "discretization.corrected",
                    "false",
                    "*GRADIENT_CORRECTION, which is left out, would multiply the stress by the correction as well as the velocity gradient",
                ),
                Settled::exactly("discretization.support-size", "fixed"),
                Settled::exactly("discretization.artificial-stress", "0"),
                Settled::exactly("discretization.viscosity", "0"),
                Settled::exactly("discretization.velocity-smoothing", "0"),
            ]
        }
    }

    fn remarks(&self) -> &'static [&'static str] {
        &[
            "density is integrated half a step late, which amplifies waves of sound at the rate omega^2 dt/4",
        ]
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn tolerance(&self) -> f64 {
        1e-6
    }

    fn stepping(
        &self,
        problem: &Problem,
        f: &DeformationGradient,
    ) -> Result<Stepping, VerifyError> {
        pressure(problem, f).map(|_| Stepping::LateDensity)
    }

    fn deck(&self, deck: &Deck<'_>) -> Result<Files, VerifyError> {
        Ok(vec![
            text("in.lammps", input(deck)?),
            text("particles.data", particles(deck)),
        ])
    }

    fn program(&self) -> Option<Program> {
        Some(lammps::LAMMPS)
    }

    fn output(&self) -> &'static str {
        lammps::DUMP
    }

    fn read(&self, _: &Path, text: &str, projector: Projector<'_>) -> Result<Record, VerifyError> {
        lammps::read(text, projector)
    }
}
