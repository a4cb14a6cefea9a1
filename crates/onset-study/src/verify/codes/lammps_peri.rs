//! Peridynamics of LAMMPS' package PERI: bonds (`pair_style peri/pmb`) and the linear peridynamic solid (`pair_style peri/lps`).
//!
//! Its contact forces measure reference distances across a periodic boundary without wrapping them. A deformed periodic box therefore has spurious
//! contact at the boundary, and decks are limited to the reference configuration.
//!
//! Source: Parks, Lehoucq, Plimpton, Silling, Comput. Phys. Commun. 179 (2008) 777; `pair_peri_pmb.cpp`, `pair_peri_lps.cpp`.

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

/// Model of the package.
pub(super) struct Peri {
    name: &'static str,
    title: &'static str,
    /// Last word of the pair style.
    style: &'static str,
    dialect: &'static [Settled],
    /// Whether the model has bulk and shear modulus; otherwise it has a micromodulus.
    is_solid: bool,
}

const METHOD: Settled = Settled::exactly("discretization.method", "peridynamics");
const LATTICE: Settled = Settled::exactly("discretization.lattice", "simple-cubic");

/// Bond-based peridynamics, `peri/pmb`.
pub(super) const BONDS: Peri = Peri {
    name: "lammps-peri",
    title: "bond-based peridynamics of LAMMPS' package PERI, peri/pmb",
    style: "pmb",
    dialect: &[
        METHOD,
        LATTICE,
        Settled::exactly("discretization.bonds", "bond-based"),
        Settled::exactly("discretization.calibration", "continuum"),
        Settled::exactly("discretization.influence", "constant"),
        Settled::deviating(
            "discretization.partial-volumes",
            "inside",
            "particles beyond the horizon do not count although part of their volume is within it: the bulk modulus is 14 to 10 % low with horizons of 3 to 5 spacings",
        ),
    ],
    is_solid: false,
};

/// The linear peridynamic solid, `peri/lps`.
pub(super) const SOLID: Peri = Peri {
    name: "lammps-peri-lps",
    title: "the linear peridynamic solid of LAMMPS' package PERI, peri/lps",
    style: "lps",
    dialect: &[
        METHOD,
        LATTICE,
        Settled::exactly("discretization.bonds", "ordinary"),
        Settled::exactly("discretization.influence", "inverse"),
        Settled::exactly("discretization.partial-volumes", "inside"),
    ],
    is_solid: true,
};

/// Relative excess of the code's horizon over the horizon of the study, so that particles at the horizon belong to the family.
const RIM: f64 = 1e-12;

/// Horizon of a study; length.
fn horizon(problem: &Problem) -> f64 {
    problem.settings.method.horizon * problem.settings.discretization.spacing
}

fn particles(name: &str, deck: &Deck<'_>) -> String {
    let case = deck.case;
    let [volume, density] = [case.block.volume(), case.density].map(number);
    let mut data = format!(
        "{name}, onset case {}\n\n{} atoms\n1 atom types\n\n{}\nAtoms # peri\n\n",
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

impl Peri {
    fn input(&self, deck: &Deck<'_>) -> Result<String, VerifyError> {
        let case = deck.case;
        let response = deck
            .problem
            .material
            .response(&DeformationGradient::identity());
        let tangent = response.map_err(MethodError::from)?.tangent;
        let pairs = || (0..9).map(|n| (n / 3, n % 3));
        let trace: f64 = pairs().map(|(i, j)| tangent[(i, i, j, j)]).sum();
        let across: f64 = pairs().map(|(i, j)| tangent[(i, j, i, j)]).sum();
        let (bulk, shear) = (trace / 9.0, (across - trace / 3.0) / 10.0);
        let horizon = horizon(deck.problem);
        let moduli = match self.is_solid {
            true => format!("{} {}", number(bulk), number(shear)),
            false => number(18.0 * bulk / (PI * horizon.powi(4))),
        };
        Ok(format!(
            "# {}, onset case {}: run with `lmp -in in.lammps`, read with `onset verify read`\n\
             units si\nboundary p p p\natom_style peri\natom_modify map array sort 0 0\nneighbor {} bin\n\
             # The size of a particle, near the horizon.\nlattice sc {}\nread_data particles.data\n\
             pair_style peri/{}\npair_coeff * * {moduli} {} 1e10 0.0\nfix integrate all nve\ntimestep {}\nthermo 1000\n{}run {}\n",
            self.name,
            case.id,
            number(0.3 * case.spacing()),
            number(case.spacing()),
            self.style,
            number(horizon * (1.0 + RIM)),
            number(case.time_step),
            lammps::dump(case, "all"),
            case.steps
        ))
    }
}

impl Code for Peri {
    fn name(&self) -> &'static str {
        self.name
    }

    fn title(&self) -> &'static str {
        self.title
    }

    fn dialect(&self) -> &'static [Settled] {
        self.dialect
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
            return Err(VerifyError::Refused {
                code: self.name,
                what: "a deformed periodic box has spurious contact at its boundary".to_owned(),
                hint: "verify the reference configuration, --stretch 1,1,1".to_owned(),
            });
        }
        Ok(Stepping::VelocityVerlet)
    }

    fn deck(&self, deck: &Deck<'_>) -> Result<Files, VerifyError> {
        Ok(vec![
            text("in.lammps", self.input(deck)?),
            text("particles.data", particles(self.name, deck)),
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
