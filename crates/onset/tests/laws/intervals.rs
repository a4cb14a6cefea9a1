//! Intervals compared with arbitrary precision (`dashu`): they contain the true value and are tight.

use crate::table::laws;
use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;
use onset::kinematics::DeformationGradient;
use onset::real::{Interval, Jet, Real, Side};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

type Exact = FBig<HalfEven, 2>;

/// Number of bits that represents sums and products of any two doubles exactly.
const EXACT: usize = 2300;
/// Number of bits that distinguishes elementary functions from any double, except exact values.
const PRECISE: usize = 400;

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(23),
        ..ProptestConfig::default()
    }
}

fn exact(x: f64, precision: usize) -> Exact {
    Exact::try_from(x)
        .expect("finite")
        .with_precision(precision)
        .value()
}

fn holds(interval: Interval, truth: &Exact) -> bool {
    let below = interval.low == f64::NEG_INFINITY || exact(interval.low, EXACT) <= *truth;
    let above = interval.high == f64::INFINITY || exact(interval.high, EXACT) >= *truth;
    below && above
}

/// Number of doubles from the lower to the upper bound.
fn steps(interval: Interval) -> i64 {
    let rank = |x: f64| {
        let bits = x.to_bits() as i64;
        if bits < 0 {
            i64::MIN.wrapping_sub(bits)
        } else {
            bits
        }
    };
    rank(interval.high).saturating_sub(rank(interval.low))
}

/// Any finite double; very large, very small and moderate values are equally likely.
fn any_double() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>().prop_filter("finite", |x| x.is_finite()),
        -10.0..10.0_f64,
        prop::sample::select(vec![
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.5,
            3.0,
            f64::MAX,
            f64::MIN,
            f64::MIN_POSITIVE,
            5e-324,
            -5e-324,
            1e-310,
            1e16,
        ]),
    ]
}

/// Interval with one of its members.
fn any_interval() -> impl Strategy<Value = (Interval, f64)> {
    (any_double(), any_double(), any_double()).prop_map(|(a, b, c)| {
        let mut sorted = [a, b, c];
        sorted.sort_by(f64::total_cmp);
        (Interval::new(sorted[0], sorted[2]), sorted[1])
    })
}

proptest! {
    #![proptest_config(config(4000))]

    #[test]
    fn intervals_of_basic_operations_contain_the_exact_result((a, x) in any_interval(), (b, y) in any_interval()) {
        let [p, q] = [x, y].map(|x| exact(x, EXACT));
        prop_assert!(holds(a + b, &(&p + &q)), "{a:?} + {b:?}");
        prop_assert!(holds(a - b, &(&p - &q)), "{a:?} - {b:?}");
        prop_assert!(holds(a * b, &(&p * &q)), "{a:?} * {b:?}");
        prop_assert!(holds(a.square(), &(&p * &p)), "{a:?}^2");
        prop_assert!(holds(a.powi(3), &(&p * &p * &p)), "{a:?}^3");
        prop_assert!(holds(a.abs(), &exact(x.abs(), EXACT)), "|{:?}|", a);
        prop_assert!(holds(a.hull(b), &p) && holds(a.hull(b), &q));
        if y != 0.0 {
            prop_assert!(holds(a / b, &(&p / &q)), "{a:?} / {b:?}");
            prop_assert!(holds(b.recip(), &(exact(1.0, EXACT) / &q)), "1 / {b:?}");
        }
        if x >= 0.0 {
            prop_assert!(holds(a.sqrt(), &p.sqrt()), "sqrt {a:?}");
        }
        // NaN does not occur, and bounds are ordered.
        for result in [a + b, a - b, a * b, a / b, a.sqrt(), a.ln(), a.exp(), a.sin(), a.cos(), a.sinh(), a.cosh(), a.tanh(), a.powi(-2),
            a.powi(7), a.powf(-0.3), b.recip(), -a] {
            prop_assert!(result.low <= result.high, "{result:?} of {a:?} and {b:?}");
        }
    }

    #[test]
    fn intervals_of_elementary_functions_contain_the_exact_result(
        (a, x) in any_interval(), small in -745.0..709.0_f64, wide in 0.0..3.0_f64, exponent in -9.0..9.0_f64,
    ) {
        let precise = |x: f64| exact(x, PRECISE);
        if x > 0.0 {
            prop_assert!(holds(a.ln(), &precise(x).ln()), "ln {a:?}");
            let power = a.powf(exponent);
            // The reference arithmetic has unbounded exponents.
            if (x.ln() * exponent).abs() < 700.0 {
                prop_assert!(holds(power, &precise(x).powf(&precise(exponent))), "{a:?}^{exponent}");
            }
        }
        let b = Interval::new(small, small + wide);
        let inside = small + 0.3 * wide;
        prop_assert!(holds(b.exp(), &precise(inside).exp()), "exp {b:?}");
        // Hyperbolic functions are computed from one exponential function; in this range both exp(x) and exp(-x) matter.
        let (c, middle) = (Interval::new(small / 40.0, small / 40.0 + wide), small / 40.0 + 0.3 * wide);
        let (power, inverse) = (precise(middle).exp(), precise(-middle).exp());
        let (difference, sum) = (&power - &inverse, &power + &inverse);
        prop_assert!(holds(c.sinh() * 2.0, &difference), "sinh {c:?}");
        prop_assert!(holds(c.cosh() * 2.0, &sum), "cosh {c:?}");
        prop_assert!(holds(c.tanh(), &(&difference / &sum)), "tanh {c:?}");
        for scale in [1e-3, 1.0, 1e6] {
            let b = Interval::new(small * scale, small * scale + wide);
            let inside = small * scale + 0.3 * wide;
            prop_assert!(holds(b.sin(), &precise(inside).sin()), "sin {b:?}");
            prop_assert!(holds(b.cos(), &precise(inside).cos()), "cos {b:?}");
        }
    }

    #[test]
    fn intervals_of_point_arguments_are_a_few_units_in_the_last_place_wide(
        x in -700.0..700.0_f64, y in -700.0..700.0_f64, positive in 1e-300..1e300_f64, exponent in -0.9..0.9_f64,
    ) {
        let [a, b, c] = [x, y, positive].map(Interval::point);
        for basic in [a + b, a - b, a * b, a / b, a.recip(), c.sqrt(), a.square()] {
            prop_assert!(steps(basic) <= 2, "{basic:?}");
        }
        for elementary in [a.exp(), c.ln(), a.sin(), a.cos(), a.sinh(), a.cosh(), a.tanh(), c.powf(exponent)] {
            prop_assert!(steps(elementary) <= 8, "{elementary:?}");
        }
    }

    #[test]
    fn enclosures_of_a_law_contain_its_response(
        stretches in prop::array::uniform3(0.3..2.5_f64), shear in -1.0..1.0_f64, spread in 0.0..1e-3_f64,
    ) {
        let state = [[stretches[0], shear, 0.0], [0.0, stretches[1], 0.0], [0.0, 0.0, stretches[2]]];
        let f = DeformationGradient::new(state).expect("a state");
        for entry in laws() {
            let law = entry.law;
            let response = law.response(&f).expect("finite");
            for width in [0.0, spread] {
                let wide = state.map(|row| row.map(|x| Interval::new(x - width, x + 2.0 * width)));
                let enclosure = law.enclosure(&DeformationGradient::from_components(wide));
                // The floating-point response differs by rounding.
                let near = |interval: Interval, value: f64, scale: f64| {
                    interval.low <= value + 1e-10 * scale && value - 1e-10 * scale <= interval.high
                };
                let scale = response.tangent[(0, 0, 0, 0)].abs() + 1.0;
                prop_assert!(near(enclosure.energy, response.energy, scale));
                for i in 0..3 {
                    for j in 0..3 {
                        prop_assert!(near(enclosure.first_piola[i][j], response.first_piola[(i, j)], scale));
                        for k in 0..3 {
                            for l in 0..3 {
                                let entry = enclosure.tangent[i][j][k][l];
                                prop_assert!(near(entry, response.tangent[(i, j, k, l)], scale));
                                prop_assert!(width > 0.0 || entry.width() < 1e-9 * scale, "{entry:?} is too wide");
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn intervals_include_interior_extremes_of_functions() {
    use std::f64::consts::PI;
    for turn in -4..5 {
        let center = f64::from(turn) * PI;
        let around = |x: f64| Interval::new(x - 0.01, x + 0.01);
        let sign = if turn % 2 == 0 { 1.0 } else { -1.0 };
        assert!(around(center).cos().contains(sign), "cosine at {turn} pi");
        assert!(
            around(center + 0.5 * PI).sin().contains(sign),
            "sine at {turn} pi + pi/2"
        );
        assert!(around(center).cos().width() < 1e-4);
    }
    assert_eq!(Interval::new(0.0, 7.0).cos(), Interval::new(-1.0, 1.0));
    assert_eq!(
        Interval::new(1e300, 1.1e300).sin(),
        Interval::new(-1.0, 1.0)
    );
}

#[test]
fn a_partially_undefined_operation_returns_the_entire_line() {
    let straddles = Interval::new(-1.0, 2.0);
    let results = [
        Interval::point(1.0) / straddles,
        Interval::point(1.0) / Interval::ZERO,
        straddles.recip(),
        straddles.sqrt(),
        straddles.ln(),
        straddles.powf(0.5),
        straddles.powi(-1),
        Interval::point(f64::NAN),
        Interval::new(f64::NAN, 1.0),
    ];
    for result in results {
        assert_eq!(result, Interval::ENTIRE);
    }
    assert_eq!(
        Interval::ENTIRE * 0.0,
        Interval::ZERO,
        "zero times any real number is zero"
    );
    assert_eq!(Interval::ENTIRE - 1.0, Interval::ENTIRE);
    assert_eq!(Interval::new(0.0, 1.0).ln().low, f64::NEG_INFINITY);
}

#[test]
fn a_switch_on_an_undecided_interval_takes_both_branches() {
    // W = x^2 in tension, 3 x^2 in compression: the second derivative is 2 or 6.
    let [x] = Jet::variables([Interval::new(-0.1, 0.2)]);
    let energy = x.switch(0.0, || x * x * 3.0, || x * x);
    let curvature = energy.hessian[0][0];
    assert!(curvature.contains(2.0) && curvature.contains(6.0));
    let [tension] = Jet::variables([Interval::new(0.1, 0.2)]);
    let energy = tension.switch(0.0, || tension * tension * 3.0, || tension * tension);
    assert!(
        !energy.hessian[0][0].contains(6.0),
        "a decided switch takes one branch"
    );
    assert_eq!(1.0_f64.side(1.0), Some(Side::Above));
    assert_eq!(0.5_f64.switch(1.0, || 7.0, || 8.0), 7.0);
}
