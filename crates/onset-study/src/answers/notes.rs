//! What a reader must know of a law and a method whatever the question.

use crate::number::told_of;
use crate::settings::{Bonds, Family, Settings};
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;

/// Stresses at `F = 1` below this share of the stiffness are rounding.
const UNSTRESSED: f64 = 1e-9;

/// What a reader of an answer must know of the law: that it has stress at `F = 1`, where it has.
pub fn notes_on_law(material: &dyn Hyperelastic) -> Vec<String> {
    // A law without a reference state is told by whoever evaluates it.
    let Ok(response) = material.response(&DeformationGradient::identity()) else {
        return Vec::new();
    };
    let stiffness = response.tangent.largest();
    let cauchy = response.cauchy();
    if cauchy.amax() <= UNSTRESSED * stiffness {
        return Vec::new();
    }
    let components = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let told: Vec<String> = components
        .into_iter()
        .filter(|place| cauchy[*place].abs() > UNSTRESSED * stiffness)
        .map(|(i, j)| {
            format!(
                "s{}{} = {}",
                i + 1,
                j + 1,
                told_of(cauchy[(i, j)], stiffness)
            )
        })
        .collect();
    vec![format!(
        "the law has stress at F = 1 ({}): its reference state is stressed, F = 1 is not an unstressed reference configuration, and stretches are \
         not measured from one",
        told.join(", ")
    )]
}

/// What a reader of an answer must know of law and method.
pub fn notes(settings: &Settings, material: &dyn Hyperelastic) -> Vec<String> {
    let mut notes = notes_on_law(material);
    notes.extend(notes_on_method(settings));
    notes
}

/// What a reader of an answer must know of the method: that bonds take of the law its modulus only.
pub fn notes_on_method(settings: &Settings) -> Vec<String> {
    let method = &settings.method;
    let mut notes = Vec::new();
    if method.method == Family::Peridynamics && method.bonds == Bonds::BondBased {
        notes.push(
            "bond-based peridynamics takes one number of the law, its bulk modulus at F = 1 (in the dimensions of the particles); \
             the bonds are linear springs with Poisson's ratio 1/4, whatever else the law says, and the continuum beside them is the \
             whole law. With discretization.bonds = correspondence the particles follow the law"
                .to_owned(),
        );
    }
    notes
}
