//! Total-Lagrangian SPH of LAMMPS' package SMD (`pair_style smd/tlsph`).
//!
//! Periodic boxes cannot be used: the code does not wrap relative positions, and freezes particles at a periodic boundary. The block therefore has a
//! held rim, and its core is measured before waves from the rim arrive. In the reference configuration the linear elasticity of the code represents
//! any isotropic law; at a stretched state it is a hypoelastic law with the Green-Naghdi rate. The polynomial equation of state represents a
//! purely volumetric law. Affine velocities with all forces switched off bring the particles to the state.
//!
//! Source: Ganzenmueller, "Smooth Mach Dynamics package for LAMMPS" (manual); `pair_smd_tlsph.cpp`, `fix_smd_integrate_tlsph.cpp`.

use super::super::law::{Isotropic, Volumetric, integrates_pressure, is_in_rate_form};
use super::super::{Case, Code, Deck, Program, Projector, Record, Settled, VerifyError};
use super::lammps::{self, number};
use crate::answers::Problem;
use crate::output::{Files, text};
use crate::settings::Plane;
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use onset::time_step::Stepping;
use std::fmt::Write;
use std::path::Path;

pub(super) struct TotalSmd;

const NAME: &str = "lammps-smd-tlsph";

/// Rate form of the law that the code integrates.
const RATE: &str = "hypoelastic-green-naghdi";
/// Number of steps in the first of the two runs that lead to a state.
const RAMP_STEPS: usize = 20;
/// Number of iterations for the stretch at the end of the first run; each iteration reduces the error to about a tenth.
const STRETCH_ITERATIONS: usize = 40;
/// Range of stretches that the two runs can reach.
const STRETCH_RANGE: [f64; 2] = [0.4, 2.0];
/// Range of volume ratios that the code accepts; it deletes particles outside this range.
const VOLUME_RATIO_RANGE: [f64; 2] = [0.2, 2.0];

/// Constitutive model that a deck selects.
enum Elasticity {
    /// Linear elasticity, integrated from strain rates.
    Linear(Isotropic),
    /// Equation of state as a function of the volume.
    Pressure(Volumetric),
}

fn refused(what: impl Into<String>, hint: &str) -> VerifyError {
    VerifyError::Refused {
        code: NAME,
        what: what.into(),
        hint: hint.to_owned(),
    }
}

fn elasticity(problem: &Problem, f: &DeformationGradient) -> Result<Elasticity, VerifyError> {
    if problem.dimension() != 2 {
        return Err(refused("decks are planar", "omit discretization.lattice"));
    }
    if f.components()[2][2] != 1.0 {
        return Err(refused(
            "planar decks have an out-of-plane stretch of 1",
            "omit the third stretch",
        ));
    }
    if problem.settings.material.plane() != Plane::Strain {
        return Err(refused(
            "planar decks are in plane strain",
            "omit material.plane",
        ));
    }
    let jacobian = f.jacobian();
    if !(VOLUME_RATIO_RANGE[0] < jacobian && jacobian < VOLUME_RATIO_RANGE[1]) {
        return Err(refused(
            format!(
                "the code deletes particles with the volume ratio {jacobian}: outside the range from {} to {}",
                VOLUME_RATIO_RANGE[0], VOLUME_RATIO_RANGE[1]
            ),
            "choose another state",
        ));
    }
    let law = &*problem.material;
    if let Some(own) = Volumetric::of(law, f).map_err(MethodError::from)? {
        if problem.settings.method.penalty != 0.0 {
            return Err(refused(
                "the penalty is scaled with Young's modulus, which a purely volumetric law (equation of state) does not have",
                "set discretization.penalty=0",
            ));
        }
        return Ok(Elasticity::Pressure(own));
    }
    let is_far =
        |i: &usize| !(STRETCH_RANGE[0]..=STRETCH_RANGE[1]).contains(&f.components()[*i][*i]);
    if let Some(i) = (0..2).find(is_far) {
        return Err(refused(
            format!("decks cannot reach the stretch {}", f.components()[i][i]),
            "choose stretches from 0.4 to 2",
        ));
    }
    // The code integrates the whole stress; the law must integrate its pressure too.
    if integrates_pressure(law, f).map_err(MethodError::from)? == Some(false) {
        return Err(refused(
            "the code integrates the pressure, which this law has as a function of the volume",
            "set material.n=0",
        ));
    }
    let is_rest = *f == DeformationGradient::identity();
    if !is_rest && !is_in_rate_form(law, RATE, 0.0, f).map_err(MethodError::from)? {
        return Err(refused(
            format!(
                "at a stretched state the elasticity of the code is a law in rate form, which {} is not",
                problem.settings.material.model.name()
            ),
            "choose --set material.model=hypoelastic-green-naghdi (with n = 0), a purely volumetric law such as --energy \"K*(J-ln(J))\", or the reference configuration \
             (--stretch 1,1)",
        ));
    }
    let own = Isotropic::of(law).map_err(MethodError::from)?;
    own.map(Elasticity::Linear).ok_or_else(|| {
        refused(
            "the law is anisotropic, or stressed in the reference configuration",
            "choose an isotropic law",
        )
    })
}

/// Stretch at the end of the first of the two runs that lead to `stretch`.
///
/// Each step adds the strain increment `dF/F` with `F` at its end, and every `run` repeats the last increment before it. With [`RAMP_STEPS`] equal steps
/// to the stretch `a`, and one step from `a` to the stretch `s`, the strain is `sum_n d/(1 + n d) + d/a + 2 (s - a)/s` with `d = (a - 1)/RAMP_STEPS`. This
/// strain must equal `ln s`.
fn turning_point(stretch: f64) -> f64 {
    let mut a = stretch;
    for _ in 0..STRETCH_ITERATIONS {
        let d = (a - 1.0) / RAMP_STEPS as f64;
        let steps: f64 = (1..=RAMP_STEPS).map(|n| d / (1.0 + n as f64 * d)).sum();
        let strain = steps + d / a + 2.0 * (stretch - a) / stretch;
        a += stretch * (strain - stretch.ln());
    }
    a
}

/// Coefficients of the pair style.
fn coefficients(deck: &Deck<'_>) -> Result<String, VerifyError> {
    let density = number(deck.case.density);
    let hourglass = number(deck.problem.settings.method.penalty);
    Ok(match elasticity(deck.problem, deck.f)? {
        Elasticity::Linear(own) => format!(
            "*COMMON {density} {} {} 0.0 0.0 {hourglass} 1.0 *STRENGTH_LINEAR *EOS_LINEAR",
            number(own.young()),
            number(own.poisson())
        ),
        Elasticity::Pressure(own) => {
            // p = C0 + C1 (rho/rho0 - 1), the tangent of the law at the state.
            let constant = own.pressure - own.slope * (deck.f.jacobian().recip() - 1.0);
            let size = number(own.slope.abs());
            format!(
                "*COMMON {density} {size} 0.3 0.0 0.0 0.0 1.0 *EOS_POLYNOMIAL {} {} 0 0 0 0 0",
                number(constant),
                number(own.slope)
            )
        }
    })
}

fn particles(deck: &Deck<'_>) -> String {
    let case = deck.case;
    let volume = case.block.volume();
    let [volume, mass] = [volume, volume * case.density].map(number);
    let radius = number(0.5 * support(deck));
    let mut reference = case.clone();
    reference.stretches = [1.0; 3];
    let mut data = format!(
        "{NAME}, onset case {}\n\n{} atoms\n1 atom types\n\n{}\nAtoms # smd\n\n",
        case.id,
        case.block.particles(),
        lammps::bounds(&reference)
    );
    for index in 0..case.block.particles() {
        let [x, y, z] = case.block.reference(index).map(number);
        let _ = writeln!(
            data,
            "{} 1 1 {volume} {mass} {radius} {radius} {x} {y} {z} {x} {y} {z}",
            index + 1
        );
    }
    data
}

/// Support radius of the kernel; length.
fn support(deck: &Deck<'_>) -> f64 {
    let choices = &deck.problem.settings.discretization;
    choices.support * choices.spacing
}

/// Commands of the two runs to the state.
fn ramp(case: &Case) -> String {
    let turning = case.stretches.map(turning_point);
    let legs = [
        ([1.0; 3], turning, RAMP_STEPS),
        (turning, case.stretches, 1),
    ];
    lammps::strained(&legs.map(|(from, to, steps)| {
        let time = steps as f64 * case.time_step;
        ([0, 1].map(|i| (to[i] / from[i] - 1.0) / time), steps)
    }))
}

fn input(deck: &Deck<'_>) -> Result<String, VerifyError> {
    let case = deck.case;
    let mut text = format!(
        "# {NAME}, onset case {}: run with `lmp -in in.lammps`, read with `onset verify read`\n\
         dimension 2\nunits si\nboundary sm sm p\natom_style smd\natom_modify map array sort 0 0\n\
         comm_modify vel yes\nneigh_modify every 10 delay 0 check yes\nnewton off\nread_data particles.data\n\
         group tlsph type 1\nneighbor {} bin\npair_style smd/tlsph\npair_coeff 1 1 {} *END\n\
         fix integrate all smd/integrate_tlsph\ntimestep {}\nthermo 1000\n{}",
        case.id,
        number(support(deck)),
        coefficients(deck)?,
        number(case.time_step),
        lammps::regions(case, case.reach, [1.0; 3]),
    );
    if case.stretches != [1.0; 3] {
        text += &ramp(case);
    }
    let _ = write!(
        text,
        "{}fix hold rim setforce 0 0 0\n{}run {}\n",
        lammps::seed(case),
        lammps::dump(case, "core"),
        case.steps
    );
    Ok(text)
}

impl Code for TotalSmd {
    fn name(&self) -> &'static str {
        NAME
    }

    fn title(&self) -> &'static str {
        "total-Lagrangian SPH of LAMMPS' package SMD, smd/tlsph"
    }

    fn dialect(&self) -> &'static [Settled] {
        const {
            &[
                Settled::exactly("discretization.method", "total-lagrangian-sph"),
                Settled::exactly("discretization.lattice", "square"),
                Settled::deviating(
                    "discretization.kernel",
                    "(1-q)^3",
                    "the spiky kernel of Desbrun and Gascuel (1996)",
                ),
                Settled::exactly("discretization.corrected", "true"),
                Settled::deviating(
                    "discretization.penalty-form",
                    "smd",
                    "discretization.penalty is the hourglass amplitude hg; denominators are regularized, alpha(r) = hg/2 R^2/(R^2 + 0.01 h^2) r/(r + 0.1 h) r/(r + 0.01 h)",
                ),
                Settled::exactly("discretization.viscosity", "0"),
                Settled::exactly("discretization.velocity-smoothing", "0"),
            ]
        }
    }

    fn remarks(&self) -> &'static [&'static str] {
        &[
            "stress is integrated from extrapolated velocities, which damps waves at the rate omega^2 dt/4; every `run` adds one increment with the velocities before it",
            "smd/adjust_dt ignores the stiffness of the hourglass forces",
            "particles at a periodic boundary do not move: decks have a held rim",
        ]
    }

    fn is_periodic(&self) -> bool {
        false
    }

    fn tolerance(&self) -> f64 {
        1e-6
    }

    fn stepping(
        &self,
        problem: &Problem,
        f: &DeformationGradient,
    ) -> Result<Stepping, VerifyError> {
        Ok(match elasticity(problem, f)? {
            Elasticity::Linear(_) => Stepping::ExtrapolatedStress,
            Elasticity::Pressure(_) => Stepping::VelocityVerlet,
        })
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
