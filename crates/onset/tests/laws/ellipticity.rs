//! Domains of strong ellipticity that are known in closed form.

use crate::table::{C1, C2, LAMBDA, Random, laws};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;

/// Derivative `g''(J)` of the law (5) in plane strain, `W = (c1 + c2)/2 |F|^2 + g(J)`.
fn second_derivative_by_volume(j: f64) -> f64 {
    C2 + C1 / 3.0 * j.powf(-4.0 / 3.0) - 2.0 / 3.0 * C2 * j.powf(-2.0 / 3.0)
        + 2.0 * LAMBDA * (1.0 - j.ln()) / (j * j)
}

#[test]
fn the_elliptic_domain_of_equation_5_agrees_with_its_closed_form() {
    let law = &laws()[0].law;
    let mut random = Random::new(31);
    let mut seen = [0, 0];
    for _ in 0..3000 {
        // Stretches up to 12: the elliptic domain ends, and begins again beyond J of about 84.
        let f = random.planar_state(12.0);
        let j = f.jacobian();
        let singular = f.leading::<2>().singular_values();
        let closed = C1 + C2 + second_derivative_by_volume(j) * singular.max().powi(2);
        let stiffness = Stiffness::<2>::of(&law.response(&f).expect("finite"));
        let minimum = stiffness.minimum().eigenvalue.re;
        let scale = stiffness.maximum_eigenvalue().abs();
        assert!(
            (minimum - closed.min(C1 + C2)).abs() < 1e-9 * scale.max(1.0),
            "{minimum}, {closed} at {f:?}"
        );
        if closed.abs() > 1e-9 * scale {
            assert_eq!(stiffness.is_strongly_elliptic(), closed > 0.0, "at {f:?}");
            seen[usize::from(closed > 0.0)] += 1;
        }
    }
    assert!(
        seen[0] > 100 && seen[1] > 100,
        "both sides of the boundary are sampled: {seen:?}"
    );
}

#[test]
fn equation_5_regains_ellipticity_beyond_a_volume_ratio_of_84() {
    let law = &laws()[0].law;
    let elliptic = |l: f64| {
        let f = DeformationGradient::from_stretches([l, l, 1.0]).expect("a state");
        Stiffness::<2>::of(&law.response(&f).expect("finite")).is_strongly_elliptic()
    };
    for (onset, is_loss) in [(1.66977046056740, true), (8.7205856480, false)] {
        assert_eq!(elliptic(onset * (1.0 - 1e-8)), is_loss);
        assert_eq!(elliptic(onset * (1.0 + 1e-8)), !is_loss);
    }
}

const GAMMA: f64 = 0.267_949_192_431_122_7; // 2 - sqrt 3

/// Logarithmic distance of the ratio of two stretches from the limits of `gamma < ratio < 1/gamma`.
fn inside(ratio: f64) -> f64 {
    -GAMMA.ln() - ratio.ln().abs()
}

#[test]
fn the_planar_elliptic_domain_of_blatz_ko_is_inequality_62() {
    let law = &laws()[1].law;
    let mut random = Random::new(32);
    let mut seen = [0, 0];
    for _ in 0..3000 {
        let f = random.planar_state(4.0);
        let singular = f.leading::<2>().singular_values();
        let margin = inside(singular[0] / singular[1]);
        if margin.abs() > 1e-6 {
            let stiffness = Stiffness::<2>::of(&law.response(&f).expect("finite"));
            assert_eq!(stiffness.is_strongly_elliptic(), margin > 0.0, "at {f:?}");
            seen[usize::from(margin > 0.0)] += 1;
        }
    }
    assert!(
        seen[0] > 100 && seen[1] > 100,
        "both sides of the boundary are sampled: {seen:?}"
    );
}

#[test]
fn the_boundary_of_inequality_62_agrees_to_eleven_digits() {
    let law = &laws()[1].law;
    for (scale, sign) in [(0.5, 1.0), (1.0, 1.0), (1.7, -1.0)] {
        for (distance, expected) in [(1e-11, false), (-1e-11, true)] {
            let ratio = (2.0 + 3.0_f64.sqrt()) * (1.0 + distance);
            let f = DeformationGradient::from_stretches([scale, scale * ratio.powf(sign), 1.0])
                .expect("a state");
            let stiffness = Stiffness::<2>::of(&law.response(&f).expect("finite"));
            assert_eq!(
                stiffness.is_strongly_elliptic(),
                expected,
                "ratio off by {distance:e}"
            );
        }
    }
}

#[test]
fn the_three_dimensional_elliptic_domain_of_blatz_ko_is_inequality_60() {
    let law = &laws()[1].law;
    let mut random = Random::new(33);
    let mut seen = [0, 0];
    for _ in 0..200 {
        let (l1, l2) = (random.stretch(5.0), random.stretch(5.0));
        let margin = inside(l1).min(inside(l2)).min(inside(l1 / l2));
        if margin.abs() > 1e-4 {
            let f = DeformationGradient::from_stretches([l1, l2, 1.0]).expect("a state");
            let stiffness = Stiffness::<3>::of(&law.response(&f).expect("finite"));
            assert_eq!(
                stiffness.is_strongly_elliptic(),
                margin > 0.0,
                "at {l1}, {l2}"
            );
            seen[usize::from(margin > 0.0)] += 1;
        }
    }
    assert!(
        seen[0] > 30 && seen[1] > 30,
        "both sides of the boundary are sampled: {seen:?}"
    );
}
