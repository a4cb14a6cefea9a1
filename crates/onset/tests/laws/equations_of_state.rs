//! Equations of state, compared with integrals and derivatives to 50 digits, and with their relations for the bulk modulus.

use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, Law, MaterialError};

fn law(name: &str, given: &[(&str, f64)]) -> Box<dyn Hyperelastic> {
    let law = Law::named(name).expect("a law");
    law.build(given).expect("admissible")
}

fn stretched(stretches: [f64; 3]) -> DeformationGradient {
    DeformationGradient::from_stretches(stretches).expect("a state")
}

/// Values of a law at three stretches: energy, `P11`, `P33`, `A1111` and `A1122`.
type Row = (&'static str, [f64; 3], [f64; 5]);

/// Computed by mpmath: the pressure integrated from the reference configuration (for Mie-Grueneisen the differential equation of the isentrope with its integrating
/// factor, not the form used in the program), derivatives by differences of the integrals.
#[rustfmt::skip]
const WITH_50_DIGITS: [Row; 9] = [
    ("mie-grueneisen", [0.8, 0.9, 1.05], [11.491020026183508, -107.14092921540691, -45.00792431340826, 724.663194927594, 364.1991973792091]),
    ("mie-grueneisen", [0.6, 0.7, 1.0], [127.99046453008928, -629.7245489665042, -299.0945854228622, 3446.079697871579, 1817.877552558761]),
    ("mie-grueneisen", [1.1, 1.2, 0.95], [6.191424928131881, 33.20794803197043, 19.245220241104533, 143.47966634070298, 43.5213159130828]),
    ("murnaghan", [0.8, 0.9, 1.05], [6.9244314950012855, -82.46673528134193, -62.30102642769949, 839.1984841766769, 651.9926126095747]),
    ("murnaghan", [0.6, 0.7, 1.0], [423.2481286078735, -4328.4173583659, -2595.9092535129166, 50610.466551666126, 37193.521915709425]),
    ("murnaghan", [1.1, 1.2, 0.95], [1.8873897656797978, 12.966082203676743, 14.735009239556776, 22.369436421419067, 29.633935924255532]),
    ("tait", [0.8, 0.9, 1.05], [5.959302454727815, -64.22044477734148, -48.399090805603905, 532.3606842453871, 399.5215576750954]),
    ("tait", [0.6, 0.7, 1.0], [119.7639327714874, -652.532233236334, -390.3781784351766, 3383.705195366097, 1964.7052176373513]),
    ("tait", [1.1, 1.2, 0.95], [1.9243050126640828, 13.192304511768356, 14.996950859452328, 21.468657842259482, 28.996740816768924]),
];

#[test]
fn equations_of_state_agree_with_integrated_pressures() {
    for (name, stretches, expected) in WITH_50_DIGITS {
        let response = law(name, &[])
            .response(&stretched(stretches))
            .expect("finite");
        let found = [
            response.energy,
            response.first_piola[(0, 0)],
            response.first_piola[(2, 2)],
            response.tangent[(0, 0, 0, 0)],
            response.tangent[(0, 0, 1, 1)],
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{name} at {stretches:?}: {found} is not {expected}"
            );
        }
    }
}

/// Pressure and bulk modulus `-J dp/dJ` for equitriaxial stretch, without deviator.
fn pressure_and_modulus(law: &dyn Hyperelastic, jacobian: f64) -> (f64, f64) {
    let stretch = jacobian.cbrt();
    let response = law.response(&stretched([stretch; 3])).expect("finite");
    let sum: f64 = (0..3).map(|j| response.tangent[(0, 0, j, j)]).sum();
    let pressure = -response.first_piola[(0, 0)] / (stretch * stretch);
    // P = -p J^(2/3), d/d(stretch): sum_j A11jj = -2 p stretch - stretch^2 dp/d(stretch), and J d/dJ = stretch/3 d/d(stretch).
    (pressure, (sum / stretch + 2.0 * pressure) / 3.0)
}

#[test]
fn the_bulk_modulus_of_murnaghan_is_linear_in_the_pressure_and_tait_compression_logarithmic() {
    let fluid = law("murnaghan", &[("mu", 0.0), ("kappa", 2.2), ("n", 7.15)]);
    let tait = law("tait", &[("mu", 0.0), ("kappa", 2.2), ("tait-c", 0.137)]);
    for jacobian in [0.7, 0.9, 0.99, 1.02] {
        let (pressure, modulus) = pressure_and_modulus(&*fluid, jacobian);
        assert!((modulus - (2.2 + 7.15 * pressure)).abs() < 1e-11 * modulus);
        let (pressure, modulus) = pressure_and_modulus(&*tait, jacobian);
        assert!((1.0 - jacobian - 0.137 * (1.0 + pressure / (2.2 * 0.137)).ln()).abs() < 1e-13);
        assert!((modulus - jacobian * (2.2 + pressure / 0.137)).abs() < 1e-11 * modulus);
    }
}

/// Isentrope and Hugoniot have equal slope and curvature: `dK/dp = 4 s - 1` in the reference configuration (Ruoff, J. Appl. Phys. 38 (1967) 4976).
/// Under compression the pressure of the shock is higher because of heating.
#[test]
fn the_isentrope_of_mie_and_grueneisen_touches_the_hugoniot_to_second_order_and_lies_below_it() {
    let (kappa, s) = (138.6, 1.489);
    let copper = law(
        "mie-grueneisen",
        &[("mu", 0.0), ("kappa", kappa), ("s", s), ("gamma0", 2.02)],
    );
    let difference = |jacobian: f64| {
        let x = 1.0 - jacobian;
        let shock = kappa * x / (1.0 - s * x).powi(2);
        shock - pressure_and_modulus(&*copper, jacobian).0
    };
    // Gamma_0 (h x/2 - e) = Gamma_0 kappa s x^3/3 to third order.
    for x in [1e-2, 1e-3_f64] {
        let third = difference(1.0 - x) / x.powi(3);
        let expected = 2.02 * kappa * s / 3.0;
        assert!(
            (third / expected - 1.0).abs() < 6.0 * x,
            "{third} {expected}"
        );
    }
    assert!(difference(0.7) > 0.0);
    let slope = {
        let [below, above] = [1.0 - 1e-4, 1.0 + 1e-4].map(|j| pressure_and_modulus(&*copper, j));
        (above.1 - below.1) / (above.0 - below.0)
    };
    assert!((slope - (4.0 * s - 1.0)).abs() < 1e-5, "{slope}");
    let pole = 1.0 - 1.0 / s;
    assert!(copper.response(&stretched([pole + 1e-3, 1.0, 1.0])).is_ok());
    let refused = copper.response(&stretched([pole - 1e-3, 1.0, 1.0]));
    assert!(matches!(
        refused,
        Err(MaterialError::OutsideDomain { what: "J", .. })
    ));
}

#[test]
fn a_fluid_has_no_stiffness_against_shear_at_any_state() {
    for (name, _, _) in WITH_50_DIGITS.into_iter().step_by(3) {
        let fluid = law(name, &[("mu", 0.0)]);
        for stretches in [[1.0; 3], [0.9, 1.05, 0.98]] {
            let response = fluid.response(&stretched(stretches)).expect("finite");
            let direction = nalgebra::Vector3::new(0.48, 0.6, 0.64);
            let acoustic = Stiffness::<3>::of(&response).acoustic_tensor(&direction);
            let mut values: Vec<f64> = acoustic.symmetric_eigenvalues().iter().copied().collect();
            values.sort_by(f64::total_cmp);
            assert!(
                values[1].abs() < 1e-13 * values[2] && values[2] > 0.0,
                "{name}: {values:?}"
            );
        }
    }
}
