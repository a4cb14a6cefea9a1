//! Stable part of the compressive square for Eulerian kernels, material (5): the claim that figure 6 illustrates.

use crate::reference::{lagrangian, material, method, stretched, with_frame};
use onset::bloch::Stability;
use onset::verdict::judge;

/// Number of divergent states, `Re omega^2 < 0`, among 64 compressive states.
fn diverging(quadrature: &str, support: f64, geometry: &str, linearization: &str) -> usize {
    let discretization = with_frame(
        lagrangian("hex", quadrature, support),
        "euler",
        geometry,
        linearization,
    );
    let (method, material) = (method(discretization), material("mooney"));
    let stretch = |n: usize| 0.25 + 0.73 * n as f64 / 7.0;
    (0..64)
        .filter(|index| {
            let f = stretched(stretch(index % 8), stretch(index / 8));
            let (_, stability) = judge(&method, &*material, &f).expect("enough neighbors");
            stability == Stability::Divergence
        })
        .count()
}

#[test]
fn on_the_regular_lattice_compression_is_stable_for_some_supports() {
    for support in [1.6, 1.9, 2.3] {
        assert_eq!(
            diverging("sp", support, "regular", "paper"),
            0,
            "paper, D_mx {support}"
        );
    }
    for support in [1.3, 1.9, 2.3] {
        assert_eq!(
            diverging("sp", support, "regular", "exact"),
            0,
            "exact, D_mx {support}"
        );
    }
    assert_eq!(diverging("sp", 1.9, "elliptic-stretched", "exact"), 0);
    for support in [1.6, 2.0] {
        assert_eq!(
            diverging("nodal", support, "regular", "paper"),
            0,
            "nodal, D_mx {support}"
        );
    }
}

#[test]
fn most_compressed_states_are_unstable_with_fixed_support_on_the_convected_lattice() {
    for (quadrature, support, linearization) in [
        ("nodal", 1.9, "paper"),
        ("sp", 1.1, "paper"),
        ("sp", 1.6, "paper"),
        ("sp", 2.0, "paper"),
        ("sp", 2.5, "paper"),
        ("sp", 1.6, "exact"),
        ("sp", 2.0, "exact"),
        ("sp", 2.5, "exact"),
    ] {
        let found = diverging(quadrature, support, "fixed-stretched", linearization);
        assert!(
            found > 15,
            "{quadrature} {support} {linearization}: {found} of 64"
        );
    }
}
