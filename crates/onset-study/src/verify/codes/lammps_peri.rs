//! Bond-based peridynamics of LAMMPS' package PERI (`pair_style peri/pmb`).
//!
//! The contact forces of the code use distances across a periodic boundary without wrapping. A deformed periodic box therefore has spurious contact
//! at the boundary, and decks are limited to the reference configuration.
//!
//! Source: Parks, Lehoucq, Plimpton, Silling, Comput. Phys. Commun. 179 (2008) 777; `pair_peri_pmb.cpp`.

use super::super::{Code, Deck, Program, Projector, Record, Settled, VerifyError};
use super::lammps::{self, number};
use crate::answers::Problem;
use crate::output::{Files, text};
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use onset::time_step::Stepping;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

pub(super) struct Peri;

const NAME: &str = "lammps-peri";

/// Relative excess of the code's horizon over the horizon of the study, so that particles at the horizon belong to the family.
const RIM: f64 = 1e-12;

fn refused(what: impl Into<String>, hint: &str) -> VerifyError {
    VerifyError::Refused {
        code: NAME,
        what: what.into(),
        hint: hint.to_owned(),
    }
}

/// Horizon of a study; length.
fn horizon(problem: &Problem) -> f64 {
    problem.settings.method.horizon * problem.settings.discretization.spacing
}

fn particles(deck: &Deck<'_>) -> String {
    let case = deck.case;
    let [volume, density] = [case.block.volume(), case.density].map(number);
    let mut data = format!(
        "{NAME}, onset case {}\n\n{} atoms\n1 atom types\n\n{}\nAtoms # peri\n\n",
        case.id,
        case.block.particles(),
        lammps::bounds(case)
    );
    for index in 0..case.block.particles() {
        let [x, y, z] = case.place(index).map(number);
        let _ = writeln!(data, "{} 1 {volume} {density} {x} {y} {z}", index + 1);
    }
    data + &lammps::velocities(case)
}

fn input(deck: &Deck<'_>) -> Result<String, VerifyError> {
    let case = deck.case;
    let response = deck
        .problem
        .material
        .response(&DeformationGradient::identity());
    let tangent = response.map_err(MethodError::from)?.tangent;
    let entries = (0..9).map(|n| tangent[(n / 3, n / 3, n % 3, n % 3)]);
    let bulk = entries.sum::<f64>() / 9.0;
    let horizon = horizon(deck.problem);
    Ok(format!(
        "# {NAME}, onset case {}: run with `lmp -in in.lammps`, read with `onset verify read`\n\
         units si\nboundary p p p\natom_style peri\natom_modify map array sort 0 0\nneighbor {} bin\n\
         # The size of a particle, near the horizon.\nlattice sc {}\nread_data particles.data\n\
         pair_style peri/pmb\npair_coeff * * {} {} 1e10 0.0\nfix integrate all nve\ntimestep {}\nthermo 1000\n{}run {}\n",
        case.id,
        number(0.3 * case.spacing()),
        number(case.spacing()),
        number(18.0 * bulk / (PI * horizon.powi(4))),
        number(horizon * (1.0 + RIM)),
        number(case.time_step),
        lammps::dump(case, "all"),
        case.steps
    ))
}

impl Code for Peri {
    fn name(&self) -> &'static str {
        NAME
    }

    fn title(&self) -> &'static str {
        "bond-based peridynamics of LAMMPS' package PERI, peri/pmb"
    }

    fn dialect(&self) -> &'static [Settled] {
        const {
            &[
                Settled::exactly("discretization.method", "peridynamics"),
                Settled::exactly("discretization.lattice", "simple-cubic"),
                Settled::exactly("discretization.bonds", "bond-based"),
                Settled::exactly("discretization.calibration", "continuum"),
                Settled::exactly("discretization.influence", "constant"),
                Settled::deviating(
                    "discretization.partial-volumes",
                    "inside",
                    "particles beyond the horizon do not count although part of their volume is within it: the bulk modulus is 14 to 10 % low with horizons of 3 to 5 spacings",
                ),
            ]
        }
    }

    fn remarks(&self) -> &'static [&'static str] {
        &[
            "contact across the boundary of a deformed periodic box is spurious: decks are of the reference configuration",
        ]
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn tolerance(&self) -> f64 {
        1e-8
    }

    fn stepping(&self, _: &Problem, f: &DeformationGradient) -> Result<Stepping, VerifyError> {
        if *f != DeformationGradient::identity() {
            return Err(refused(
                "a deformed periodic box has spurious contact at its boundary",
                "verify the reference configuration, --stretch 1,1,1",
            ));
        }
        Ok(Stepping::VelocityVerlet)
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
