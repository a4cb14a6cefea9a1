//! Updated-Lagrangian SPH of LAMMPS' package SMD (`pair_style smd/ulsph`) with strength, and a density integrated by continuity.
//!
//! Particles can obtain a deviatoric stress only by motion. The deck therefore starts with one step at affine velocities, with all forces switched
//! off and a shear modulus so large that the displacements are negligible. Affine velocities do not fit a periodic box, and at a free face the code
//! does not reproduce their gradient: the block of such a state has a held rim.
//!
//! Source: `pair_smd_ulsph.cpp`, `fix_smd_integrate_ulsph.cpp`: velocity gradients are computed from velocities extrapolated from the last step. The
//! volume integrated from them is used one step later, the deviator in the same step. The deviator is rotated against the spin: `s' = 2 mu dev D - W
//! s + s W`.

use super::super::law::{JaumannRates, integrates_pressure};
use super::super::{Code, Deck, Program, Projector, Record, Settled, VerifyError};
use super::lammps::{self, number};
use crate::answers::Problem;
use crate::output::{Files, text};
use nalgebra::{Matrix2, Vector2};
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use onset::time_step::Stepping;
use std::fmt::Write;
use std::path::Path;

pub(super) struct UpdatedSmd {
    name: &'static str,
    title: &'static str,
    /// Whether gradients, and therefore the stress, are corrected.
    is_corrected: bool,
}

pub(super) const PLAIN: UpdatedSmd = UpdatedSmd {
    name: "lammps-smd-ulsph",
    title: "updated-Lagrangian SPH of LAMMPS' package SMD, smd/ulsph *DENSITY_CONTINUITY *NO_GRADIENT_CORRECTION",
    is_corrected: false,
};
pub(super) const CORRECTED: UpdatedSmd = UpdatedSmd {
    name: "lammps-smd-ulsph-corrected",
    title: "updated-Lagrangian SPH of LAMMPS' package SMD, smd/ulsph *DENSITY_CONTINUITY *GRADIENT_CORRECTION",
    is_corrected: true,
};

/// Factors of the spin in the stress rate: in the code, and in the Jaumann rate.
const SPIN_FACTORS: [f64; 2] = [-1.0, 1.0];
/// Factor on the shear modulus in the step that sets the deviator; displacements scale with its reciprocal.
const PRESTRESS_STIFFNESS_FACTOR: f64 = 1e10;
/// Width of the held rim, in interaction ranges: particles within one range of a face have a wrong gradient, and act on particles within the next
/// range.
const RIM_INTERACTION_RANGES: f64 = 2.0;

/// Pressure, deviator and shear modulus of the law at the state, if its stress rate is a Jaumann rate.
///
/// The spin may have the sign of the code or the correct sign.
fn rates(
    code: &UpdatedSmd,
    problem: &Problem,
    f: &DeformationGradient,
) -> Result<JaumannRates, VerifyError> {
    let refused = |what: &str, hint: &str| VerifyError::Refused {
        code: code.name,
        what: what.to_owned(),
        hint: hint.to_owned(),
    };
    if problem.dimension() != 2 || f.components()[2][2] != 1.0 {
        return Err(refused(
            "decks are planar, with an out-of-plane stretch of 1",
            "omit the third stretch",
        ));
    }
    let law = &*problem.material;
    let mut own = None;
    for spin in SPIN_FACTORS {
        let rates = JaumannRates::of(law, f, spin).map_err(MethodError::from)?;
        own = own.or(rates);
    }
    // The code integrates the deviator, but not the pressure.
    let integrated = integrates_pressure(law, f).map_err(MethodError::from)?;
    let own = own.filter(|own| integrated == Some(false) || own.shear == 0.0);
    let own = own.ok_or_else(|| {
        refused(
            "the code has a pressure that depends on the density alone, and a deviator that is integrated with the spin",
            "choose --set material.model=hypoelastic-jaumann --set material.n=1, with material.spin=-1 as in the code, or a purely volumetric law, such as --energy \"K*(J-ln(J))\" --set material.K=1",
        )
    })?;
    if own.volumetric.slope <= 0.0 {
        return Err(refused(
            "the pressure of the law decreases with the density at this state, which Tait's equation cannot represent",
            "choose another state",
        ));
    }
    Ok(own)
}

/// Returns true if particles start with a deviatoric stress.
fn is_prestressed(own: &JaumannRates) -> bool {
    own.deviator != [0.0; 3]
}

fn particles(deck: &Deck<'_>) -> String {
    let case = deck.case;
    let name = &case.code;
    let choices = &deck.problem.settings.discretization;
    let volume = case.block.volume();
    let [current, mass] = [volume * deck.f.jacobian(), volume * case.density].map(number);
    let radius = number(0.5 * choices.support * choices.spacing);
    let mut data = format!(
        "{name}, onset case {}\n\n{} atoms\n1 atom types\n\n{}\nAtoms # smd\n\n",
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
    match case.is_periodic {
        true => data + &lammps::velocities(case),
        false => data,
    }
}

/// Gradient that the code computes for a unit velocity gradient along an axis without correction: `sum_J V_J (-W'/r) x_I^2`.
fn seen(deck: &Deck<'_>, axis: usize) -> f64 {
    let choices = &deck.problem.settings.discretization;
    let radius = choices.support * choices.spacing;
    let sides = [0, 1].map(|i| deck.case.block.sides[i] * deck.case.stretches[i]);
    let most = sides.map(|side| (radius / side).ceil() as i32);
    let mut sum = 0.0;
    for x in -most[0]..=most[0] {
        for y in -most[1]..=most[1] {
            let apart = Vector2::new(f64::from(x) * sides[0], f64::from(y) * sides[1]);
            let weight = choices.kernel.weight(&apart, radius, &Matrix2::identity());
            sum -= weight.map_or(0.0, |weight| weight.gradient[axis] * apart[axis]);
        }
    }
    let kernel = choices.kernel.normalization::<2>(radius);
    kernel * sum * deck.case.block.volume() * deck.f.jacobian()
}

/// Coefficients of the pair style for a given shear modulus.
fn coefficients(deck: &Deck<'_>, own: &JaumannRates, shear: f64) -> String {
    let case = deck.case;
    // Tait's equation with the exponent 1, p = c^2 (rho - rho_p), is the tangent of the law at the state.
    let square = own.volumetric.slope / case.density;
    let free = case.density / deck.f.jacobian() - own.volumetric.pressure / square;
    let strength = match shear == 0.0 {
        true => String::new(),
        false => format!("*STRENGTH_LINEAR {} ", number(shear)),
    };
    format!(
        "pair_coeff 1 1 *COMMON {} {} 0.0 1.0 0.0 *EOS_TAIT 1.0 {strength}*END\n",
        number(free),
        number(square.sqrt())
    )
}

/// Commands of the step that sets the deviator, and of the seed.
fn prestressed(code: &UpdatedSmd, deck: &Deck<'_>, own: &JaumannRates) -> String {
    let case = deck.case;
    let stiff = PRESTRESS_STIFFNESS_FACTOR * own.shear;
    // In plane strain 2 mu dev(e) = s has e_i = (s_i - s_3)/(2 mu).
    let rate = |i: usize| {
        let strain = (own.deviator[i] - own.deviator[2]) / (2.0 * stiff);
        let seen = if code.is_corrected {
            1.0
        } else {
            seen(deck, i)
        };
        strain / seen / case.time_step
    };
    format!(
        "{}{}{}{}{}fix hold rim setforce 0 0 0\n",
        coefficients(deck, own, stiff),
        lammps::strained(&[([0, 1].map(rate), 1)]),
        coefficients(deck, own, own.shear),
        lammps::regions(case, RIM_INTERACTION_RANGES * case.reach, case.stretches),
        lammps::seed(case),
    )
}

fn input(code: &UpdatedSmd, deck: &Deck<'_>) -> Result<String, VerifyError> {
    let case = deck.case;
    let own = rates(code, deck.problem, deck.f)?;
    let (boundary, group, before) = match case.is_periodic {
        true => ("p p p", "all", String::new()),
        false => ("sm sm p", "core", prestressed(code, deck, &own)),
    };
    let correction = match code.is_corrected {
        true => "*GRADIENT_CORRECTION",
        false => "*NO_GRADIENT_CORRECTION",
    };
    let pair = format!("pair_style smd/ulsph *DENSITY_CONTINUITY *VELOCITY_GRADIENT {correction}");
    Ok(format!(
        "# {}, onset case {}: run with `lmp -in in.lammps`, read with `onset verify read`\n\
         dimension 2\nunits si\nboundary {boundary}\natom_style smd\natom_modify map array sort 0 0\n\
         comm_modify vel yes\nneigh_modify every 10 delay 0 check yes\nnewton off\nread_data particles.data\n\
         group ulsph type 1\nneighbor {} bin\n{pair}\n{}fix integrate all smd/integrate_ulsph\ntimestep {}\nthermo 1000\n{}{}run {}\n",
        code.name,
        case.id,
        number(0.5 * case.spacing()),
        coefficients(deck, &own, own.shear),
        number(case.time_step),
        before,
        lammps::dump(case, group),
        case.steps
    ))
}

/// Remarks on both variants; the last remark applies only to the corrected variant.
const REMARKS: [&str; 3] = [
    "density is integrated half a step late, which amplifies waves of sound at the rate omega^2 dt/4",
    "the deviator is rotated against the spin, s' = 2 mu dev D - W s + s W: it does not rotate with the material (material.spin=-1)",
    "a correction is limited to the factor 2, which particles of a block do not reach",
];

/// Choices of either variant.
const fn dialect(is_corrected: bool) -> [Settled; 11] {
    let (value, deviation) = match is_corrected {
        true => (
            "true",
            "*GRADIENT_CORRECTION multiplies both the stress and the velocity gradient by the correction",
        ),
        false => ("false", ""),
    };
    [
        Settled::exactly("discretization.method", "updated-sph"),
        Settled::exactly("discretization.lattice", "square"),
        Settled::deviating(
            "discretization.kernel",
            "(1-q)^3",
            "the spiky kernel of Desbrun and Gascuel (1996)",
        ),
        Settled::exactly("discretization.momentum", "mean"),
        Settled::exactly("discretization.density-evolution", "continuity"),
        Settled::exactly("discretization.corrected", value),
        Settled::deviating("discretization.corrected-forces", value, deviation),
        Settled::exactly("discretization.support-size", "fixed"),
        Settled::exactly("discretization.artificial-stress", "0"),
        Settled::exactly("discretization.viscosity", "0"),
        Settled::exactly("discretization.velocity-smoothing", "0"),
    ]
}

impl Code for UpdatedSmd {
    fn name(&self) -> &'static str {
        self.name
    }

    fn title(&self) -> &'static str {
        self.title
    }

    fn dialect(&self) -> &'static [Settled] {
        match self.is_corrected {
            false => const { &dialect(false) },
            true => const { &dialect(true) },
        }
    }

    fn remarks(&self) -> &'static [&'static str] {
        match self.is_corrected {
            false => &REMARKS[..2],
            true => &REMARKS,
        }
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn rim(&self, problem: &Problem, f: &DeformationGradient) -> Result<Option<f64>, VerifyError> {
        Ok(is_prestressed(&rates(self, problem, f)?).then_some(RIM_INTERACTION_RANGES))
    }

    fn tolerance(&self) -> f64 {
        1e-6
    }

    fn stepping(
        &self,
        problem: &Problem,
        f: &DeformationGradient,
    ) -> Result<Stepping, VerifyError> {
        rates(self, problem, f).map(|_| Stepping::LateDensity)
    }

    fn deck(&self, deck: &Deck<'_>) -> Result<Files, VerifyError> {
        Ok(vec![
            text("in.lammps", input(self, deck)?),
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
