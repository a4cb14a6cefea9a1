//! Laws that flow along loadings.

use onset::criteria::{
    Discontinuity, Lateral, Loading, LoadingPath, Mode, PathState, Range, kinks,
};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, MaterialError, Response};
use onset::plasticity::library;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Law that counts its responses.
struct Counting {
    law: Box<dyn Hyperelastic>,
    count: AtomicUsize,
}

impl Hyperelastic for Counting {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        self.count.fetch_add(1, Ordering::Relaxed);
        self.law.response(f)
    }

    fn is_path_dependent(&self) -> bool {
        self.law.is_path_dependent()
    }
}

fn counting(name: &str) -> Counting {
    let law = library().iter().find(|law| law.name == name);
    let law = law.expect("a law").build(&[]).expect("defaults");
    Counting {
        law,
        count: AtomicUsize::new(0),
    }
}

fn followed<'a>(
    law: &'a Counting,
    mode: Mode,
    lateral: Lateral,
    (low, high): (f64, f64),
) -> LoadingPath<'a> {
    let range = Range::new(low, high).expect("a range");
    LoadingPath::new(law, true, Loading { mode, lateral }, &range).expect("a path")
}

fn states<'p>(path: &'p LoadingPath<'_>) -> impl Iterator<Item = &'p PathState> {
    path.compression.iter().chain(&path.tension)
}

/// A bar yields at the stress `T` with `(T/q0)^2 + 2 q1 f cosh(T/(2 q0)) = 1 + (q1 f)^2`, `q1 f = 0.015`. Its softening ends in a fold, where the
/// errors of integration are largest in units of the stress that is left, and where the tangent varies as the root of the distance.
#[test]
fn a_porous_bar_has_kinks_of_the_stress_where_it_yields_and_nowhere_else() {
    let law = counting("gurson");
    let path = followed(&law, Mode::Uniaxial, Lateral::Free, (0.9, 7.0));
    assert!(path.ends_in_fold(true), "{:?}", path.tension_end);
    let found = kinks(&path);
    assert_eq!(found.len(), 2, "{found:?}");
    let (mu, kappa) = (80_000.0, 170_000.0);
    let young = 9.0 * mu * kappa / (3.0 * kappa + mu);
    for kink in found {
        assert_eq!(kink.kind, Discontinuity::KinkOfStress);
        let part = young * kink.stretch.ln() / 400.0;
        let excess = part * part + 0.03 * (0.5 * part).cosh() - 1.0 - 0.015 * 0.015;
        assert!(excess.abs() < 1e-7, "{kink:?}: {excess:e}");
    }
}

/// Each response integrates a path from the reference configuration. Two or three solve for the free stretches of the next state, and one for each
/// direction gives the derivatives.
#[test]
fn a_law_that_flows_is_followed_with_few_responses() {
    let law = counting("drucker-prager");
    let path = followed(&law, Mode::Planar, Lateral::PlaneStress, (0.8, 1.25));
    let states = states(&path).count();
    let responses = law.count.load(Ordering::Relaxed);
    assert!(states > 300, "{states} states");
    assert!(responses < 6 * states, "{responses} for {states} states");
}

/// A difference between equal faces would be rounding, and costs the integration of an isotropic law ten times the number of steps.
#[test]
fn equal_free_faces_of_a_law_that_flows_have_equal_stretches() {
    let law = counting("drucker-prager");
    let path = followed(&law, Mode::Uniaxial, Lateral::Free, (0.8, 1.25));
    for state in states(&path) {
        let f = state.response.deformation.components();
        assert_eq!(f[1][1], f[2][2], "{}", state.parameter);
    }
}
