//! Notes on law and method that every answer carries.

use crate::methods::reduced;
use crate::number::{counted, told, told_of};
use crate::settings::{
    Bonds, Family, MaterialSettings, Model, Settings, Shear, Study, Units, Unknowns, Velocities,
};
use nalgebra::Matrix3;
use onset::analysis::ReducedCell;
use onset::continuum::ACOUSTIC_ROUNDING;
use onset::criteria::is_isotropic;
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, Response};
use onset::scheme::stabilization::Upwinding;
use onset::scheme::{GridFunctions, PointLayout};

/// Stresses at `F = 1` below this fraction of the stiffness are rounding errors.
const STRESS_ROUNDING: f64 = 1e-9;
/// State with different stretches. A law without shear stiffness only at `F = 1` has shear stiffness at this state.
const PROBE_STRETCHES: [f64; 3] = [1.1, 1.0, 0.95];

/// Notes on a law: stress at `F = 1`, no shear stiffness, a negative Poisson's ratio, a path-dependent tangent, and the block of another program that
/// was read.
pub fn notes_on_law(settings: &MaterialSettings, material: &dyn Hyperelastic) -> Vec<String> {
    // The pressure of the reference configuration is a parameter of these laws.
    let mut parameters = settings.model.parameters().iter();
    let is_confined = parameters.any(|own| own.name == "confinement");
    let notes = [
        stress_at_rest(material).filter(|_| !is_confined),
        fluid(material),
        auxetic(settings, material),
        note_on_path(settings.model),
        note_on_softening(settings),
    ];
    let read = settings.notes().iter().cloned();
    read.chain(notes.into_iter().flatten()).collect()
}

fn is_stressed(material: &dyn Hyperelastic) -> bool {
    stress_at_rest(material).is_some()
}

/// Returns true if the law has no stress at a state, to rounding.
pub(super) fn is_unstressed(material: &dyn Hyperelastic, f: &DeformationGradient) -> bool {
    let response = material.response(f);
    response.is_ok_and(|response| {
        response.cauchy().amax() <= STRESS_ROUNDING * response.tangent.largest()
    })
}

/// Note on buckling of a sheet or bar with a compressive principal Cauchy stress, which waves within it do not show. `material` is the law of the
/// sheet or bar; other bodies get no note.
pub(super) fn buckling(
    material: &dyn Hyperelastic,
    response: &Response,
    units: Units,
) -> Option<String> {
    let cauchy = response.cauchy();
    let (what, least) = match material.dimension() {
        2 => {
            let mean = 0.5 * (cauchy[(0, 0)] + cauchy[(1, 1)]);
            let difference = 0.5 * (cauchy[(0, 0)] - cauchy[(1, 1)]);
            ("sheet", mean - difference.hypot(cauchy[(0, 1)]))
        }
        1 => ("bar", cauchy[(0, 0)]),
        _ => return None,
    };
    let is_compressed = least < -STRESS_ROUNDING * response.tangent.largest();
    is_compressed.then(|| {
        format!(
            "the {what} is compressed (smallest principal Cauchy stress {}), and buckles laterally if it is thin. Waves within it do not show this",
            units.of(told(least), "Pa")
        )
    })
}

/// Returns true for a fluid: the law has no shear stiffness, either at `F = 1` or under stretches, but resists volume changes.
pub(super) fn is_fluid(material: &dyn Hyperelastic) -> bool {
    let yields = |f: DeformationGradient| {
        let response = material.response(&f).ok()?;
        let stiffness = response.tangent.largest();
        let mut shears = [(0, 1), (0, 2), (1, 2)].into_iter();
        let are_free = shears
            .all(|(i, j)| response.tangent[(i, j, i, j)].abs() <= ACOUSTIC_ROUNDING * stiffness);
        Some(stiffness > 0.0 && are_free)
    };
    // A fluid has no plane stress, and a bar in uniaxial stress has no shear.
    if material.dimension() < 3 {
        return false;
    }
    // A fluid has no stiffness for shears along the axes of the stretches; a law whose shear stiffness grows from zero has some.
    let stretched = DeformationGradient::from_stretches(PROBE_STRETCHES).ok();
    yields(DeformationGradient::identity()) == Some(true)
        && stretched.and_then(yields) != Some(false)
}

/// Note on laws that are fluids.
fn fluid(material: &dyn Hyperelastic) -> Option<String> {
    is_fluid(material).then(|| {
        "the law has no stiffness against shear: a fluid. It is not strongly elliptic at any state, its transverse waves have omega = 0, and \
         motions of the particles that keep all volumes cost nothing"
            .to_owned()
    })
}

/// Shear and bulk modulus of an isotropic law without stress at `F = 1`.
pub fn moduli(material: &dyn Hyperelastic) -> Option<[f64; 2]> {
    let response = material.undeformed().ok()?;
    let shear = response.tangent[(0, 1, 0, 1)];
    let bulk = response.tangent[(0, 0, 0, 0)] - shear * (4.0 / 3.0);
    let is_told = material.dimension() == 3 && is_isotropic(material) && !is_stressed(material);
    is_told.then_some([shear, bulk])
}

/// Note on a negative Poisson's ratio of an isotropic law at `F = 1`.
fn auxetic(settings: &MaterialSettings, material: &dyn Hyperelastic) -> Option<String> {
    if material.dimension() == 1 {
        // The modulus of a bar does not determine its width.
        return auxetic(settings, &*settings.build().ok()?);
    }
    let response = material.undeformed().ok()?;
    let stiffness = |k: usize| response.tangent[(0, 0, k, k)];
    let ratio = match material.dimension() {
        2 => stiffness(1) / stiffness(0),
        _ => stiffness(1) / (stiffness(0) + stiffness(1)),
    };
    // At -1 the bulk modulus is zero.
    let is_auxetic = ratio > -1.0 && ratio < -STRESS_ROUNDING;
    let shear = is_auxetic.then(|| match material.dimension() {
        2 => shear_of_plane(&response),
        _ => moduli(material).map(|[shear, _]| shear),
    });
    (shear.flatten()? > 0.0).then(|| {
        format!(
            "auxetic: Poisson's ratio at F = 1 is {}. The material widens when it is stretched, and narrows when it is compressed",
            told(ratio)
        )
    })
}

/// Shear modulus of the response of a sheet or membrane at `F = 1` that is isotropic in its plane and unstressed.
fn shear_of_plane(response: &Response) -> Option<f64> {
    let c = |i: usize, j: usize, k: usize, l: usize| response.tangent[(i, j, k, l)];
    let shear = c(0, 1, 0, 1);
    let largest = response.tangent.largest();
    let vanish = [
        c(0, 0, 0, 0) - c(1, 1, 1, 1),
        c(0, 0, 0, 1),
        c(1, 1, 0, 1),
        c(0, 0, 0, 0) - c(0, 0, 1, 1) - 2.0 * shear,
        response.cauchy().amax(),
    ];
    vanish
        .iter()
        .all(|part| part.abs() <= STRESS_ROUNDING * largest)
        .then_some(shear)
}

/// Note on laws whose tangent depends on the path.
fn note_on_path(model: Model) -> Option<String> {
    model.is_in_rate_form().then(|| match model.yields() {
        false => format!(
            "{} is hypoelastic: states are reached by proportional logarithmic strain. The path is R U^t, 0 <= t <= 1, and waves follow from the tangent at its \
             end. At a stressed state the tangent has no major symmetry, so waves can flutter even where the law is strongly elliptic. A state of \
             simple shear has another stress, and loses ellipticity elsewhere, if it is reached by shearing",
            model.name()
        ),
        true => format!(
            "{} {}: beyond yield, waves follow from the tangent of continued loading. The state is reached along R U^t, 0 <= t <= 1 (proportional \
             logarithmic strain), and the tangent is that of Hill's linear comparison solid. If flow is associated and this solid is stable, so is the material; if it is \
             unstable, the instability requires that loading continues",
            model.name(),
            match model.name() {
                "damage" => "loses stiffness",
                _ => "is elastic-plastic",
            }
        )
    })
}

/// Note on laws that soften by previous loading.
fn note_on_softening(settings: &MaterialSettings) -> Option<String> {
    settings.softens().then(|| match settings.is_primary() {
        true => "the law softens by previous loading (Mullins effect): without material.mullins-energy, the largest energy of the past, every state is reached by \
                 primary loading, and waves follow from the tangent of continued loading, which is the tangent of the law without softening. Unloading is stiffer at \
                 first"
            .to_owned(),
        false => "the law softens by previous loading (Mullins effect): states with less energy than material.mullins-energy are unloaded or reloaded, with one \
                  tangent for both; states with more energy are reached by primary loading"
            .to_owned(),
    })
}

/// Note on the energy of a state of a law that softens by previous loading, and on the factor of its stress.
pub(super) fn softening(
    settings: &MaterialSettings,
    response: &Response,
    units: Units,
) -> Option<String> {
    let law = settings.softening().ok()??;
    let f = &response.deformation;
    let (energy, factor) = (law.softening_energy(f).ok()?, law.factor(f).ok()?);
    Some(format!(
        "the energy of the softening part is {} at this state, and the factor of its stress is eta = {}",
        units.of(told(energy), "Pa"),
        told(factor)
    ))
}

/// Note on laws with stress at `F = 1`.
fn stress_at_rest(material: &dyn Hyperelastic) -> Option<String> {
    // The evaluation itself reports laws without a reference state.
    let response = material.response(&DeformationGradient::identity()).ok()?;
    let stiffness = response.tangent.largest();
    let cauchy = response.cauchy();
    if cauchy.amax() <= STRESS_ROUNDING * stiffness {
        return None;
    }
    let components = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let told: Vec<String> = components
        .into_iter()
        .filter(|place| cauchy[*place].abs() > STRESS_ROUNDING * stiffness)
        .map(|(i, j)| {
            format!(
                "s{}{} = {}",
                i + 1,
                j + 1,
                told_of(cauchy[(i, j)], stiffness)
            )
        })
        .collect();
    let pressure = cauchy.trace() / 3.0;
    let is_pressure =
        (cauchy - Matrix3::from_diagonal_element(pressure)).amax() <= STRESS_ROUNDING * stiffness;
    // `ln J` has the stress 1 at `F = 1`.
    let remedy = match is_pressure {
        true => {
            let (sign, size) = if pressure > 0.0 {
                ("-", pressure)
            } else {
                ("+", -pressure)
            };
            let size = told_of(size, stiffness);
            format!(". The term {sign} {size} ln J in the energy would remove it")
        }
        false => String::new(),
    };
    Some(format!(
        "the law has stress at F = 1 ({}): stretches are not measured from an unstressed configuration{remedy}",
        told.join(", ")
    ))
}

/// Note on a cell that was reduced to its primitive cell.
fn note_on_cell(cell: ReducedCell) -> String {
    let ReducedCell {
        described,
        primitive,
    } = cell;
    format!(
        "the cell of {} is not primitive: it repeats a cell of {}. The answer is computed in the smaller cell, and wave vectors refer to its zone",
        counted(described, "particle"),
        counted(primitive, "particle")
    )
}

/// Notes on law and method.
pub fn notes(settings: &Settings, material: &dyn Hyperelastic) -> Vec<String> {
    let mut notes = notes_on_law(&settings.material, material);
    notes.extend(notes_on_method(settings));
    notes
}

/// Note that zero-energy modes count as stable, for commands that consider only growing waves.
pub(crate) fn zero_energy(who_has: &str, place: &str) -> String {
    format!(
        "{who_has} zero-energy modes, which do not grow and count as stable {place}. Their verdict is zero-energy, and `onset modes` shows them"
    )
}

/// Notes on the method: whether the cell was reduced, and whether bonds use only the modulus of the law.
pub fn notes_on_method(settings: &Settings) -> Vec<String> {
    let reduced = reduced(settings).map(note_on_cell);
    reduced
        .into_iter()
        .chain(notes_on_bonds(settings))
        .chain(note_on_pairs(settings))
        .chain(note_on_knots(settings))
        .chain(note_on_transfer(settings))
        .collect()
}

/// Note on a penalty in addition to shear forces between pairs, which leave no zero-energy modes.
fn note_on_pairs(settings: &Settings) -> Option<String> {
    let method = &settings.method;
    let is_needless = method.method == Family::TotalLagrangianSph
        && method.shear_forces == Shear::Pairs
        && method.penalty > 0.0;
    is_needless.then(|| {
        "shear forces between pairs leave no zero-energy modes. The penalty adds to their stiffness, and has nothing to control".to_owned()
    })
}

/// Note on material points at knots of the functions of the grid, where forces have no derivative.
fn note_on_knots(settings: &Settings) -> Option<String> {
    let method = &settings.method;
    if method.method != Family::MaterialPoints || method.unknowns == Unknowns::TotalLagrangian {
        return None;
    }
    let sides = method.points_per_side;
    // Distances from a node to the knots, apart from whole cells.
    let half = 0.5 / f64::from(sides);
    let knots: &[f64] = match method.grid_functions {
        GridFunctions::Gimp | GridFunctions::Cpdi => &[half, -half],
        GridFunctions::QuadraticSpline => &[0.5],
        GridFunctions::Linear | GridFunctions::CubicSpline => &[],
    };
    // Only the middle one of several Gauss points can lie at a knot.
    let sides = match method.layout {
        PointLayout::Gauss if sides.is_multiple_of(2) => return None,
        PointLayout::Gauss => 1,
        PointLayout::Uniform => sides,
    };
    let places = (0..sides).map(|n| (f64::from(n) + 0.5) / f64::from(sides));
    let is_at = |x: f64| {
        knots
            .iter()
            .any(|knot| (x - knot - (x - knot).round()).abs() < 1e-9)
    };
    let is_at_knots = places.map(|x| x + method.offset).any(is_at);
    is_at_knots.then(|| {
        "material points lie at knots of the grid functions, and can be unstable earlier elsewhere. At knots forces have no derivative, and the mean of the \
         two sides is used: try discretization.offset = 0.05"
            .to_owned()
    })
}

/// Note on upwinding between particles with different neighborhoods, in a cell with the given number of particles.
pub(super) fn note_on_upwinding(settings: &Settings, sites: usize) -> Option<String> {
    let method = &settings.method;
    let is_upwinded =
        method.method == Family::TotalLagrangianSph && method.upwinding != Upwinding::None;
    (is_upwinded && sites > 1).then(|| {
        "in the upwinding the two particles of a pair have different areas, each from its neighbors. Codes with a single area for a pair have other damping"
            .to_owned()
    })
}

/// Note on frequencies of transfers with an approximation of the full mass matrix.
fn note_on_transfer(settings: &Settings) -> Option<String> {
    let method = &settings.method;
    let is_changed = method.method == Family::MaterialPoints
        && method.unknowns == Unknowns::Particles
        && matches!(method.transfer, Velocities::Xpic | Velocities::Fmpm);
    is_changed.then(|| {
        format!(
            "frequencies belong to lumped masses in continuous time, for every order of {}. The transfer changes the frequencies of a run, its damping \
             and its largest stable step: growth rates and `onset simulate` take it into account",
            method.transfer.name()
        )
    })
}

/// Note on the time steps of a map whose study has a body.
pub(crate) fn note_on_mapped_body(study: &Study) -> Option<String> {
    let has_steps = !study.axes.is_empty() && study.map.outputs.hold("critical_time_step");
    (has_steps && study.settings.body.is_some()).then(|| {
        "the time steps of the map are those of the infinite lattice. The body of the study has free faces and can need a smaller one, which `onset state` \
         and `onset limit` compute"
            .to_owned()
    })
}

/// Notes for the simulation of a patch, which keeps the cells of the settings.
pub(crate) fn notes_on_patch(settings: &Settings, material: &dyn Hyperelastic) -> Vec<String> {
    let mut notes = notes_on_law(&settings.material, material);
    notes.extend(notes_on_bonds(settings));
    notes
}

/// Note that bonds use only moduli of the law.
fn notes_on_bonds(settings: &Settings) -> Option<String> {
    let method = &settings.method;
    if method.method == Family::Peridynamics && method.bonds == Bonds::BondBased {
        let ratio = match (settings.dimension(), settings.material.is_plane_stress()) {
            (1, _) => "",
            (_, true) => " with Poisson's ratio 1/3",
            (_, false) => " with Poisson's ratio 1/4",
        };
        return Some(format!(
            "bonds use only the bulk modulus of the law at F = 1. They are linear springs{ratio}, and the modulus is that in the dimensions of the \
             particles. The results for the material use the whole law. With discretization.bonds = correspondence the particles follow the law"
        ));
    }
    if method.method == Family::Peridynamics && method.bonds == Bonds::Ordinary {
        return Some(
            "the linear peridynamic solid uses only the bulk and the shear modulus of the law at F = 1. The forces are linear in the elongations of \
             bonds. The results for the material use the whole law. With \
             discretization.bonds = correspondence the particles follow the law"
                .to_owned(),
        );
    }
    None
}
