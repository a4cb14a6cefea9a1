//! The largest boxes of principal stretches.

use super::{NeoHooke, assert_close, zero};
use onset::material::{BlatzKo, Law};
use onset::notions::{Range, safe_box, widest_safe_box};

#[test]
fn blatz_ko_is_elliptic_in_boxes_whose_ends_have_the_ratio_2_plus_sqrt_3() {
    let law = BlatzKo::default();
    let ratio = 2.0 + 3.0_f64.sqrt();
    for skew in [0.3, 1.0, 2.5] {
        let safe = safe_box(&law, skew, &Range::default()).expect("elliptic in the reference");
        assert_close(safe.high / safe.low, ratio, 1e-10);
        assert_close(safe.low.ln(), -skew * safe.high.ln(), 1e-12);
    }
    let widest = widest_safe_box(&law, &Range::default()).expect("elliptic in the reference");
    assert_close(widest.high / widest.low, ratio, 1e-10);
}

/// Elliptic while `mu + g(J)/(smallest stretch)^2 > 0`, `g = mu + lambda (1 - ln J)`. At the largest volume of a box all stretches are `h`; with
/// one stretch smaller the volume is less and the factor larger: the worst of `h^2 x` over the smallest stretch `x` ends the box.
#[test]
fn the_box_of_neo_hooke_is_that_of_its_closed_form() {
    let (mu, lambda) = (1.0, 3.0);
    let law = NeoHooke { mu, lambda };
    let safe = safe_box(&law, 1.0, &Range::default()).expect("elliptic in the reference");
    let worst = |h: f64| {
        (0..=100_000)
            .map(|n| (-h.ln() + 2.0 * h.ln() * n as f64 / 1e5).exp())
            .map(|x| mu + (mu + lambda * (1.0 - (h * h * x).ln())) / (x * x))
            .fold(f64::INFINITY, f64::min)
    };
    let expected = zero(worst, 1.0, 5.0);
    assert_close(safe.high, expected, 1e-8);
}

#[test]
fn a_box_without_a_loss_is_as_large_as_the_range() {
    let law = NeoHooke {
        mu: 1.0,
        lambda: 0.1,
    };
    let range = Range::new(0.5, 2.0).expect("a range");
    let safe = safe_box(&law, 1.0, &range).expect("elliptic in the reference");
    assert_close(safe.high, 2.0, 1e-14);
    assert!(safe.critical.is_none());
}

/// Bruhns, Xiao and Meyers (2001): for all Lamé constants that are not negative, elliptic for stretches from 0.21162 to 1.39561. The bounds are
/// those of the two extreme laws: lambda = 0, where a ratio of two stretches ends the box, and an incompressible one, where equal
/// stretches do, at `exp(1/3)`.
#[test]
fn hencky_is_elliptic_in_the_box_of_bruhns_xiao_and_meyers_and_in_no_larger_one() {
    let (low, high) = (0.21162_f64, 1.39561_f64);
    let skew = -low.ln() / high.ln();
    let hencky = |kappa: f64| {
        let law = Law::named("hencky").expect("a law of the library");
        law.build(&[("mu", 1.0), ("kappa", kappa)])
            .expect("admissible")
    };
    let of = |kappa: f64| {
        safe_box(&*hencky(kappa), skew, &Range::default()).expect("elliptic in the reference")
    };
    let without_lambda = of(2.0 / 3.0);
    assert_close(without_lambda.low, low, 1e-6);
    assert_close(without_lambda.high, high, 1e-6);
    let between = of(4.0);
    assert!(between.low < low - 0.02 && between.high > high + 0.02);
    let nearly_incompressible = of(1e6);
    assert_close(nearly_incompressible.high, (1.0_f64 / 3.0).exp(), 1e-6);
}
