//! Largest boxes of principal stretches.

use super::{NeoHooke, assert_close, zero};
use onset::criteria::{BoxEnd, Criterion, Range, SafeBox, State, safe_box, widest_safe_box};
use onset::formula::Formula;
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset::material::{BlatzKo, Law};

#[test]
fn blatz_ko_is_elliptic_in_boxes_whose_ends_have_the_ratio_2_plus_sqrt_3() {
    let law = BlatzKo::default();
    let ratio = 2.0 + 3.0_f64.sqrt();
    for skew in [0.3, 1.0, 2.5] {
        let safe = safe_box(&law, skew, &Range::default())
            .expect("elliptic in the reference configuration");
        assert_close(safe.high / safe.low, ratio, 1e-10);
        assert_close(safe.low.ln(), -skew * safe.high.ln(), 1e-12);
    }
    let widest =
        widest_safe_box(&law, &Range::default()).expect("elliptic in the reference configuration");
    assert_close(widest.high / widest.low, ratio, 1e-10);
}

/// The laws are polyconvex. Within the range the stiffness against changes of volume exceeds the shear stiffness by many orders of magnitude, and its
/// rounding error exceeds the smallest acoustic eigenvalue.
#[test]
fn rounding_of_a_huge_bulk_stiffness_limits_no_box() {
    let range = |low, high| Range::new(low, high).expect("a range");
    for (name, given, range) in [
        ("murnaghan", &[][..], Range::default()),
        (
            "hyperfoam",
            &[("alpha1", 2.0), ("beta1", 9.5)][..],
            range(0.2, 5.0),
        ),
        (
            "hyperfoam",
            &[("alpha1", 2.0), ("beta1", 24.5)][..],
            range(0.5, 2.0),
        ),
    ] {
        let law = Law::named(name)
            .expect("a law")
            .build(given)
            .expect("admissible");
        let safe = safe_box(&*law, 1.0, &range).expect("elliptic");
        assert_eq!(
            (safe.low_end, safe.high_end),
            (BoxEnd::Range, BoxEnd::Range),
            "{name}"
        );
        assert_eq!(safe.critical, None, "{name}");
    }
}

/// The neo-Hookean law is elliptic while `mu + g(J)/(smallest stretch)^2 > 0`, `g = mu + lambda (1 - ln J)`. At the largest volume of a box all
/// stretches are `h`. If one stretch is smaller, the volume is smaller and the factor larger: the smallest value of `h^2 x` for the smallest stretch
/// `x` limits the box.
#[test]
fn the_elliptic_box_of_neo_hooke_agrees_with_the_closed_form() {
    let (mu, lambda) = (1.0, 3.0);
    let law = NeoHooke { mu, lambda };
    let safe =
        safe_box(&law, 1.0, &Range::default()).expect("elliptic in the reference configuration");
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
fn a_box_without_loss_of_ellipticity_fills_the_range() {
    let law = NeoHooke {
        mu: 1.0,
        lambda: 0.1,
    };
    let range = Range::new(0.5, 2.0).expect("a range");
    let safe = safe_box(&law, 1.0, &range).expect("elliptic in the reference configuration");
    assert_close(safe.high, 2.0, 1e-14);
    assert!(safe.critical.is_none());
    assert_eq!(
        (safe.low_end, safe.high_end),
        (BoxEnd::Range, BoxEnd::Range)
    );
}

/// A metal is elastic at a dilation and flows at a small distance from it, where it is softest: in a shell thinner than the cells of any grid.
#[test]
fn the_box_of_a_metal_contains_no_state_that_barely_flows_and_has_lost_ellipticity() {
    let mut metals = onset::plasticity::library().iter();
    let law = metals.find(|law| law.name == "j2").expect("a law");
    let metal = law.build(&[]).expect("admissible");
    // A box that reaches far into compression.
    let safe = safe_box(&*metal, 6.0, &Range::default()).expect("elliptic");
    for (n, k) in (0..=60).flat_map(|n| (1..=60).map(move |k| (n, k))) {
        let dilation = safe.high * (safe.low / safe.high).powf(f64::from(n) / 60.0);
        let smaller = dilation * (1.0 - 0.03 * f64::from(k) / 60.0);
        if smaller < safe.low {
            continue;
        }
        let stretches = [smaller, dilation, dilation];
        let f = DeformationGradient::from_stretches(stretches).expect("stretches");
        let state = State::new(&*metal, &f).expect("defined");
        let measure = Criterion::StrongEllipticity.measure(&state);
        let value = measure.expect("defined").value;
        assert!(value > -1e-7, "{safe:?} {stretches:?} {value}");
    }
}

/// Bruhns, Xiao and Meyers (2001): elliptic for stretches from 0.21162 to 1.39561 for all nonnegative Lamé constants. The bounds belong to the two
/// extreme laws: lambda = 0, where a ratio of two stretches limits the box, and an incompressible law, where equibiaxial stretches do, at `exp(1/3)`.
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
        safe_box(&*hencky(kappa), skew, &Range::default())
            .expect("elliptic in the reference configuration")
    };
    let without_lambda = of(2.0 / 3.0);
    assert_close(without_lambda.low, low, 1e-6);
    assert_close(without_lambda.high, high, 1e-6);
    let between = of(4.0);
    assert!(between.low < low - 0.02 && between.high > high + 0.02);
    let nearly_incompressible = of(1e6);
    assert_close(nearly_incompressible.high, (1.0_f64 / 3.0).exp(), 1e-6);
}

/// Checks that random states of a box, including states with stretches at its ends, are elliptic.
#[track_caller]
fn assert_safe(law: &dyn Hyperelastic, safe: &SafeBox, known: &[[f64; 3]]) {
    let (low, high) = (safe.low.ln(), safe.high.ln());
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 33) as f64 / (1_u64 << 31) as f64
    };
    // A third of the stretches lie at an end.
    let mut stretch = || (low + (high - low) * (1.5 * random() - 0.25).clamp(0.0, 1.0)).exp();
    let states = (0..20_000).map(|_| [stretch(), stretch(), stretch()]);
    for stretches in states.chain(known.iter().copied()) {
        let f = DeformationGradient::from_stretches(stretches).expect("a state");
        let response = law.response(&f).expect("a state of the law");
        let measure = Criterion::StrongEllipticity
            .measure(&State::of_response(response, true))
            .expect("defined");
        assert!(
            measure.value > -measure.rounding,
            "{stretches:?}: {measure:?}"
        );
    }
}

/// The law is elliptic for waves along the third axis while `mu + (mu + lambda (1 - ln J)) / lambda3^2 > 0`. For equal largest stretches `b` the
/// worst third stretch is a zero of the derivative of `mu x^2 + mu + lambda (1 - ln(b^2 x))` with respect to `x`: `x^2 = lambda / (2 mu)`, or `b` if
/// it is larger.
#[test]
fn the_widest_box_of_neo_hooke_agrees_with_the_closed_form() {
    for lambda in [1.0, 3.0_f64] {
        let law = NeoHooke { mu: 1.0, lambda };
        let worst = |b: f64| {
            let x = (0.5 * lambda).sqrt().min(b);
            x * x + 1.0 + lambda * (1.0 - (b * b * x).ln())
        };
        let expected = zero(worst, 1.0, 10.0);
        let safe = widest_safe_box(&law, &Range::default())
            .expect("elliptic in the reference configuration");
        assert_close(safe.high, expected, 1e-7);
        assert_close(safe.low, 0.1, 1e-7);
        assert_eq!(
            (safe.low_end, safe.high_end),
            (BoxEnd::Range, BoxEnd::Critical)
        );
        let third = (0.5 * lambda).sqrt().min(safe.high);
        assert_safe(&law, &safe, &[[safe.high, safe.high, third]]);
    }
}

#[test]
fn no_state_within_the_box_of_a_library_law_loses_ellipticity() {
    for name in [
        "hencky",
        "blatz-ko",
        "saint-venant-kirchhoff",
        "mooney-rivlin",
        "neo-hooke",
    ] {
        let law = Law::named(name).expect("a law of the library");
        let law = law.build(&[]).expect("its defaults");
        let safe = safe_box(&*law, 1.0, &Range::default())
            .expect("elliptic in the reference configuration");
        let known = safe.critical.map(|critical| critical.stretches);
        assert_safe(&*law, &safe, known.as_slice());
    }
}

#[test]
fn the_widest_box_of_saint_venant_and_kirchhoff_reaches_the_end_of_the_range() {
    let law = Law::named("saint-venant-kirchhoff").expect("a law of the library");
    let law = law.build(&[]).expect("its defaults");
    let safe =
        widest_safe_box(&*law, &Range::default()).expect("elliptic in the reference configuration");
    assert_close(safe.high, 10.0, 1e-12);
    assert_safe(&*law, &safe, &[]);
    assert_eq!(
        (safe.low_end, safe.high_end),
        (BoxEnd::Critical, BoxEnd::Range)
    );
}

/// Condition `(h^2 + 2/h^2) h^(2/3) = 3 + jm` for one stretch `h` and two stretches `1/h`.
#[test]
fn the_box_of_gent_ends_where_its_chains_lock() {
    let law = Law::named("gent").expect("a law of the library");
    let law = law.build(&[]).expect("its defaults");
    let safe =
        safe_box(&*law, 1.0, &Range::default()).expect("elliptic in the reference configuration");
    let critical = safe.critical.expect("a state at which chains lock");
    assert!(critical.witness.is_none());
    assert_eq!(
        (safe.low_end, safe.high_end),
        (BoxEnd::Critical, BoxEnd::Critical)
    );
}

#[test]
fn the_widest_box_may_end_at_stretch_one() {
    let law = Law::named("hencky").expect("a law of the library");
    let hencky = law.build(&[]).expect("admissible");
    let range = Range::default();
    let widest =
        widest_safe_box(&*hencky, &range).expect("elliptic in the reference configuration");
    // A lower skew raises the upper end and lowers the ratio `high / low`: every box of a finite skew is narrower than the widest one.
    let mut before = f64::INFINITY;
    for skew in [1e4, 300.0, 30.0, 10.0, 4.0] {
        let found =
            safe_box(&*hencky, skew, &range).expect("elliptic in the reference configuration");
        let ratio = found.high / found.low;
        assert!(
            ratio < before && ratio < widest.high / widest.low,
            "{ratio} with skew {skew}"
        );
        before = ratio;
    }
    assert!((widest.high - 1.0).abs() < 1e-14, "{widest:?}");
    // The speed of a wave in the plane of two stretches vanishes at (W11 W22)^(1/2) + A1212 = W12 + A1221.
    let (mu, kappa) = (1.0, 5.0 / 3.0);
    let margin = |x: f64| {
        let log = x.ln();
        let [s1, s2] = [4.0 / 3.0, -2.0 / 3.0].map(|share| (share * mu + kappa) * log);
        let normal = 4.0 / 3.0 * mu + kappa;
        let w11 = (normal - s1) / (x * x);
        let w22 = normal - s2;
        let w12 = (kappa - 2.0 / 3.0 * mu) / x;
        let shear = (s1 - s2) / (x * x - 1.0);
        let cross = (s1 / x - x * s2) / (x * x - 1.0);
        (w11 * w22).max(0.0).sqrt() + shear - (w12 + cross).abs()
    };
    assert_close(widest.low, zero(margin, 0.05, 0.5), 1e-9);
    // In uniaxial strain ellipticity is lost at the lower end.
    let elliptic = |l: f64| {
        let f = DeformationGradient::from_stretches([l, 1.0, 1.0]).expect("a state");
        let state = State::new(&*hencky, &f).expect("finite");
        let measure = Criterion::StrongEllipticity.measure(&state);
        measure.expect("defined").holds()
    };
    assert!(elliptic(widest.low * (1.0 + 1e-9)) && !elliptic(widest.low * (1.0 - 1e-9)));
}

#[test]
fn a_fluid_has_no_box_and_violates_every_wave_criterion() {
    let fluid = Formula::parse("50*(J - 1)^2").expect("a formula");
    let fluid = fluid.with(&[]).expect("a law");
    assert!(safe_box(&fluid, 1.0, &Range::default()).is_none());
    for stretches in [[1.0; 3], [1.2, 0.9, 1.0], [0.7, 1.3, 1.1]] {
        let f = DeformationGradient::from_stretches(stretches).expect("a state");
        let state = State::new(&fluid, &f).expect("finite");
        for criterion in [
            Criterion::StrongEllipticity,
            Criterion::PlaneEllipticity,
            Criterion::BakerEricksen,
        ] {
            let holds = criterion
                .measure(&state)
                .is_some_and(|measure| measure.holds());
            assert!(!holds, "{criterion:?} at {stretches:?}");
        }
    }
}
