//! Recorded results on polyconvexity compared with the definitions.

use onset::criteria::{Knowledge, polyconvexity};
use onset::material::library;

#[test]
fn polyconvexity_records_concern_library_laws_and_have_sources() {
    let mut known = 0;
    for law in library() {
        let parameters: Vec<(&str, f64)> = law
            .parameters
            .iter()
            .map(|parameter| (parameter.name, parameter.default))
            .collect();
        let found = polyconvexity(law.name, &parameters);
        if found.knowledge != Knowledge::Unknown {
            assert!(!found.source.is_empty() && !found.reason.is_empty());
            known += 1;
        }
    }
    assert!(known >= 12, "{known}");
}

#[test]
fn equation_5_is_polyconvex_if_its_function_of_the_volume_is_convex() {
    // h = -3/2 c1 J^(2/3) - 3/2 c2 J^(4/3) + lambda ln^2 J, sampled densely.
    let is_convex = |c1: f64, c2: f64, lambda: f64| {
        (-4000..4000).all(|n| {
            let j = (f64::from(n) * 0.005).exp();
            let second = c1 / 3.0 * j.powf(-4.0 / 3.0) - 2.0 / 3.0 * c2 * j.powf(-2.0 / 3.0)
                + 2.0 * lambda * (1.0 - j.ln()) / (j * j);
            second >= 0.0
        })
    };
    for (c1, c2) in [(1.0, 0.0), (0.1256, 0.0), (1.0, 0.5), (1e-3, 1e-3)] {
        for lambda in [0.01, 0.1, 0.5, 0.588, 0.5885, 0.59, 1.0, 10.0] {
            let lambda = lambda * c1;
            let parameters = [("c1", c1), ("c2", c2), ("lambda", lambda)];
            let found = polyconvexity("modified-mooney-rivlin", &parameters).knowledge;
            let expected = match is_convex(c1, c2, lambda) {
                true => Knowledge::Polyconvex,
                false => Knowledge::NotPolyconvex,
            };
            assert_eq!(found, expected, "{parameters:?}");
        }
    }
}

#[test]
fn polyconvexity_depends_on_the_parameters() {
    let of = |lambda: f64| polyconvexity("neo-hooke", &[("mu", 1.0), ("lambda", lambda)]);
    assert_eq!(of(0.0).knowledge, Knowledge::Polyconvex);
    assert_eq!(of(2.0).knowledge, Knowledge::NotPolyconvex);
    assert_eq!(of(-1.0).knowledge, Knowledge::Unknown);
}
