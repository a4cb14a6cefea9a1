//! Softening by previous loading compared with differences of the update, and with closed forms.

use crate::random::Random;
use nalgebra::{Matrix3, Vector3};
use onset::kinematics::DeformationGradient;
use onset::material::{
    FourthOrder, Hyperelastic, MaterialError, OgdenRoxburgh, PlaneStress, library,
};
use std::sync::Arc;

/// Values of the error function (Abramowitz and Stegun, table 7.1, with more digits).
const ERROR_FUNCTION: [(f64, f64); 6] = [
    (0.1, 0.112_462_916_018_284_9),
    (0.5, 0.520_499_877_813_046_5),
    (1.0, 0.842_700_792_949_714_9),
    (2.0, 0.995_322_265_018_952_7),
    (3.0, 0.999_977_909_503_001_4),
    (5.0, 0.999_999_999_998_462_5),
];

/// Laws whose deviatoric stress softens, and laws whose whole stress softens.
const LAWS: [(&str, bool); 6] = [
    ("neo-hooke-isochoric", true),
    ("mooney-rivlin-isochoric", true),
    ("yeoh", true),
    ("ogden", true),
    ("hyperfoam", false),
    ("neo-hooke", false),
];

fn law(name: &str) -> Arc<dyn Hyperelastic> {
    let found = library().iter().find(|law| law.name == name);
    Arc::from(found.expect("a law").build(&[]).expect("defaults"))
}

fn state(matrix: &Matrix3<f64>) -> DeformationGradient {
    let rows = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    DeformationGradient::new(rows).expect("a state")
}

fn stress(law: &dyn Hyperelastic, f: &Matrix3<f64>) -> Matrix3<f64> {
    law.energy_and_stress(&state(f)).expect("a stress").1
}

fn times(tangent: &FourthOrder, h: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| {
        let terms = (0..9).map(|n| tangent[(i, j, n / 3, n % 3)] * h[(n / 3, n % 3)]);
        terms.sum()
    })
}

/// Derivative of the stress along `h` at `f`, of fourth order, from states on one side or on both.
fn slope(
    law: &dyn Hyperelastic,
    f: &Matrix3<f64>,
    h: &Matrix3<f64>,
    one_sided: bool,
) -> Matrix3<f64> {
    let (step, weights): (f64, &[(f64, f64)]) = match one_sided {
        true => (
            4e-4,
            &[
                (0.0, -25.0),
                (1.0, 48.0),
                (2.0, -36.0),
                (3.0, 16.0),
                (4.0, -3.0),
            ],
        ),
        false => (1e-3, &[(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)]),
    };
    let terms = weights
        .iter()
        .map(|(place, weight)| stress(law, &(f + h * (place * step))) * *weight);
    terms.sum::<Matrix3<f64>>() / (12.0 * step)
}

/// Gradient of the energy that softens.
fn gradient(law: &OgdenRoxburgh, f: &Matrix3<f64>) -> Matrix3<f64> {
    let at = |i: usize, j: usize, step: f64| {
        let mut f = *f;
        f[(i, j)] += step;
        law.softening_energy(&state(&f)).expect("an energy")
    };
    Matrix3::from_fn(|i, j| (at(i, j, 1e-6) - at(i, j, -1e-6)) / 2e-6)
}

/// Random state, direction and constants.
struct Case {
    f: Matrix3<f64>,
    h: Matrix3<f64>,
    constants: [f64; 3],
}

impl Case {
    fn new(random: &mut Random) -> Self {
        let mut matrix = |size: f64| Matrix3::from_fn(|_, _| size * random.number());
        let (f, h) = (Matrix3::identity() + matrix(0.2), matrix(1.0));
        let mut between = |low: f64, high: f64| low + (high - low) * random.number().abs();
        let constants = [between(1.1, 4.0), between(0.1, 1.0), between(0.0, 1.0)];
        Self { f, h, constants }
    }

    fn material(&self, law: &Arc<dyn Hyperelastic>, largest: Option<f64>) -> OgdenRoxburgh {
        OgdenRoxburgh::new(Arc::clone(law), self.constants, largest).expect("constants")
    }
}

/// 10,000 states; the largest error relative to the largest component of the tangent.
#[test]
fn the_tangents_of_all_increments_are_derivatives_of_the_update() {
    let mut random = Random::new(55);
    let mut worst = 0.0_f64;
    let mut check = |law: &dyn Hyperelastic, tangent: &FourthOrder, case: &Case, one_sided| {
        let found = slope(law, &case.f, &case.h, one_sided);
        let error = (found - times(tangent, &case.h)).amax() / tangent.largest();
        worst = worst.max(error);
    };
    for n in 0..10_000 {
        let law = law(LAWS[n % LAWS.len()].0);
        let mut case = Case::new(&mut random);
        let f = state(&case.f);
        let primary = case.material(&law, None);
        let energy = primary.softening_energy(&f).expect("an energy");
        // Reloading of a state that has had a larger energy.
        let largest = energy + 0.02 + 2.0 * random.number().abs();
        let reloaded = case.material(&law, Some(largest));
        let tangent = reloaded.response(&f).expect("a response").tangent;
        check(&reloaded, &tangent, &case, false);
        assert_eq!(reloaded.unloading_tangent(&f).expect("a tangent"), None);
        // Unloading from primary loading: the energy decreases along the direction.
        let unloading = primary.unloading_tangent(&f).expect("a tangent");
        let held = case.material(&law, Some(energy));
        let uphill = gradient(&primary, &case.f).normalize();
        case.h = case.h.normalize() * 0.6 - uphill;
        check(&held, &unloading.expect("primary loading"), &case, true);
    }
    println!("largest error {worst:e}");
    assert!(worst < 1e-8, "{worst:e}");
}

#[test]
fn primary_loading_has_the_response_of_the_law() {
    let mut random = Random::new(7);
    for (name, _) in LAWS {
        let law = law(name);
        let case = Case::new(&mut random);
        let f = state(&case.f);
        let virgin = law.response(&f).expect("a response");
        let primary = case.material(&law, None);
        let energy = primary.softening_energy(&f).expect("an energy");
        assert_eq!(primary.response(&f).expect("a response"), virgin);
        // A state whose energy is the largest, or exceeds it, is loaded for the first time.
        for largest in [0.0, 0.5 * energy, energy] {
            let own = case.material(&law, Some(largest));
            assert_eq!(own.response(&f).expect("a response"), virgin, "{name}");
            let tangent = own.unloading_tangent(&f).expect("a tangent");
            assert_eq!(tangent, primary.unloading_tangent(&f).expect("a tangent"));
        }
        // eta = 1 at the largest energy: energy and stress are continuous.
        let below = case.material(&law, Some(energy * (1.0 + 1e-12)));
        let below = below.response(&f).expect("a response");
        assert!(
            (below.first_piola - virgin.first_piola).amax() < 1e-11 * virgin.first_piola.amax()
        );
        assert!((below.energy - virgin.energy).abs() < 1e-11 * virgin.energy);
    }
}

/// Along an isochoric uniaxial path of a neo-Hookean law, `sigma_1 - sigma_2 = eta mu (l^2 - 1/l)` and `U = mu/2 (l^2 + 2/l - 3)`.
#[test]
fn uniaxial_unloading_follows_the_closed_form() {
    let law = law("neo-hooke-isochoric");
    let energy = |stretch: f64| 0.5 * (stretch * stretch + 2.0 / stretch - 3.0);
    let (reached, r) = (2.0, 1.7);
    for stretch in [0.8, 1.1, 1.5, 1.9] {
        for (x, value) in ERROR_FUNCTION {
            let f = state(&Matrix3::from_diagonal(&Vector3::new(
                stretch,
                1.0 / stretch.sqrt(),
                1.0 / stretch.sqrt(),
            )));
            let (own, largest) = (energy(stretch), energy(reached));
            // Both constants contribute half of the width.
            let width = (largest - own) / x;
            let constants = [r, 0.5 * width, 0.5 * width / largest];
            let softened = OgdenRoxburgh::new(Arc::clone(&law), constants, Some(largest));
            let softened = softened.expect("constants");
            assert!((softened.softening_energy(&f).expect("an energy") - own).abs() < 1e-14);
            let cauchy = softened.response(&f).expect("a response").cauchy();
            let factor = softened.factor(&f).expect("a factor");
            assert!((factor - (1.0 - value / r)).abs() < 1e-15, "{x}: {factor}");
            let expected = (1.0 - value / r) * (stretch * stretch - 1.0 / stretch);
            let found = cauchy[(0, 0)] - cauchy[(1, 1)];
            assert!(
                (found - expected).abs() < 1e-13,
                "{stretch} {x}: {found} {expected}"
            );
        }
    }
}

/// `a Q(N) a` is the second derivative of the energy along `a x N`, and the acoustic tensor of unloading adds `eta' (P_U N) x (P_U N)`.
#[test]
fn the_acoustic_tensor_follows_from_the_energy() {
    let mut random = Random::new(3);
    for (name, _) in LAWS {
        for _ in 0..20 {
            let law = law(name);
            let case = Case::new(&mut random);
            let (n, a) = (case.h.column(0).normalize(), case.h.column(1).normalize());
            let wave = a * n.transpose();
            let f = state(&case.f);
            let primary = case.material(&law, None);
            let energy = primary.softening_energy(&f).expect("an energy");
            let reloaded = case.material(&law, Some(energy + 0.1 + random.number().abs()));
            let tangent = reloaded.response(&f).expect("a response").tangent;
            let step = 2e-3;
            let at = |place: f64| {
                let f = state(&(case.f + wave * (place * step)));
                reloaded.energy_and_stress(&f).expect("an energy").0
            };
            let weights = [
                (-2.0, -1.0),
                (-1.0, 16.0),
                (0.0, -30.0),
                (1.0, 16.0),
                (2.0, -1.0),
            ];
            let second: f64 = weights.iter().map(|(at_, weight)| weight * at(*at_)).sum();
            let second = second / (12.0 * step * step);
            let expected = times(&tangent, &wave).dot(&wave);
            assert!(
                (second - expected).abs() < 1e-7 * tangent.largest(),
                "{name}: {second} {expected}"
            );
            // Unloading is stiffer than continued loading in every wave.
            let virgin = law.response(&f).expect("a response").tangent;
            let unloading = primary.unloading_tangent(&f).expect("a tangent");
            let unloading = unloading.expect("primary loading");
            let gain = (times(&unloading, &wave) - times(&virgin, &wave)).dot(&wave);
            assert!(gain >= -1e-13 * virgin.largest(), "{name}: {gain}");
        }
    }
}

/// The volumetric part of a split law does not soften; the stress of other laws softens as a whole.
#[test]
fn the_mean_stress_softens_only_where_it_depends_on_distortions() {
    let mut random = Random::new(11);
    for (name, is_deviatoric) in LAWS {
        let law = law(name);
        let case = Case::new(&mut random);
        let f = state(&case.f);
        let virgin = law.response(&f).expect("a response").cauchy();
        let softened = OgdenRoxburgh::new(Arc::clone(&law), [2.0, 1e-3, 0.0], Some(1e3));
        let softened = softened.expect("constants").response(&f);
        let softened = softened.expect("a response").cauchy();
        let expected = match is_deviatoric {
            true => (virgin + Matrix3::identity() * (virgin.trace() / 3.0)) * 0.5,
            false => virgin * 0.5,
        };
        assert!(
            (softened - expected).amax() < 1e-12 * virgin.amax(),
            "{name}: {softened} {expected}"
        );
    }
}

#[test]
fn a_sheet_that_unloads_keeps_its_faces_free() {
    let law = law("yeoh");
    let constants = [1.5, 0.2, 0.1];
    let primary: Arc<dyn Hyperelastic> =
        Arc::new(OgdenRoxburgh::new(Arc::clone(&law), constants, None).expect("constants"));
    let sheet = PlaneStress::new(Arc::clone(&primary), 2).expect("a sheet");
    let f = Matrix3::new(1.5, 0.1, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0, 1.0);
    let unloading = sheet.unloading_tangent(&state(&f)).expect("a tangent");
    let unloading = unloading.expect("primary loading");
    let whole = sheet.response(&state(&f)).expect("a response").deformation;
    let own = OgdenRoxburgh::new(Arc::clone(&law), constants, None).expect("constants");
    let largest = own.softening_energy(&whole).expect("an energy");
    let held = OgdenRoxburgh::new(law, constants, Some(largest)).expect("constants");
    let held = PlaneStress::new(Arc::new(held), 2).expect("a sheet");
    // The stretch decreases.
    let h = Matrix3::new(-1.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0);
    let found = slope(&held, &f, &h, true);
    let expected = times(&unloading, &h);
    assert!(
        (found - expected).amax() < 1e-8 * unloading.largest(),
        "{found} {expected}"
    );
}

#[test]
fn constants_without_meaning_and_laws_in_rate_form_are_refused() {
    let made = |constants: [f64; 3], largest: Option<f64>| {
        OgdenRoxburgh::new(law("yeoh"), constants, largest).err()
    };
    let named = |error: Option<MaterialError>| match error {
        Some(MaterialError::Parameter { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(named(made([1.0, 0.1, 0.1], None)), "mullins-r");
    assert_eq!(named(made([f64::NAN, 0.1, 0.1], None)), "mullins-r");
    assert_eq!(named(made([2.0, -0.1, 0.1], None)), "mullins-m");
    assert_eq!(named(made([2.0, 0.1, -0.1], None)), "mullins-beta");
    assert_eq!(named(made([2.0, 0.1, 0.1], Some(-1.0))), "mullins-energy");
    assert_eq!(
        named(made([2.0, 0.0, 0.0], None)),
        "mullins-m + mullins-beta"
    );
    let rates = onset::plasticity::library().iter();
    for own in rates {
        let law = Arc::from(own.build(&[]).expect("defaults"));
        let refused = OgdenRoxburgh::new(law, [2.0, 0.1, 0.1], None).err();
        assert!(
            matches!(refused, Some(MaterialError::External { .. })),
            "{}",
            own.name
        );
    }
}
