//! Limits known in closed form or published.

use super::{NeoHooke, assert_close, limit, path, track, zero};
use onset::criteria::{
    Change, Criterion, Knowledge, Lateral, Loading, LoadingPath, Mode, Range, Witness,
    follow_jumps, is_isotropic, polyconvexity,
};
use onset::material::{BlatzKo, Law, ModifiedMooneyRivlin, library};

const ELLIPTIC: Criterion = Criterion::StrongEllipticity;

/// Knowles and Sternberg (1975): elliptic while all ratios of principal stretches are below `2 + sqrt 3`.
#[test]
fn blatz_ko_loses_ellipticity_at_the_knowles_sternberg_ratio_in_every_loading() {
    let law = BlatzKo::default();
    let ratio = 2.0 + 3.0_f64.sqrt();
    // The lateral stretches are lambda^(-1/4) with two free faces, lambda^(-1/3) and lambda^(-2/3) with one.
    let free = [
        (Mode::Uniaxial, Lateral::Held, 1.0),
        (Mode::Uniaxial, Lateral::Free, 1.25),
        (Mode::Uniaxial, Lateral::PlaneStrain, 4.0 / 3.0),
        (Mode::Equibiaxial, Lateral::PlaneStrain, 1.0),
        (Mode::Equibiaxial, Lateral::PlaneStress, 5.0 / 3.0),
        (Mode::Planar, Lateral::PlaneStress, 4.0 / 3.0),
        (Mode::Planar, Lateral::PlaneStrain, 2.0),
        (Mode::SimpleShear, Lateral::PlaneStrain, 2.0),
        (Mode::SimpleShear, Lateral::PlaneStress, 2.0),
    ];
    for (mode, lateral, power) in free {
        let path = path(&law, mode, lateral);
        let expected = ratio.powf(1.0 / power);
        let tension = limit(&path, ELLIPTIC, true).expect("lost in tension");
        assert_close(tension, expected, 1e-12);
        let compression = limit(&path, ELLIPTIC, false).expect("lost in compression");
        assert_close(compression, 1.0 / expected, 1e-12);
    }
    let hydrostatic = path(&law, Mode::Hydrostatic, Lateral::Held);
    assert_eq!(limit(&hydrostatic, ELLIPTIC, true), None);
    assert_eq!(limit(&hydrostatic, ELLIPTIC, false), None);
}

/// `(tau_i - tau_j)/(lambda_i^2 - lambda_j^2) = mu / (lambda_i lambda_j)^2`, and `dtau_i / dln lambda_j = mu (2 lambda_i^-2 d_ij + J)`.
#[test]
fn blatz_ko_satisfies_baker_ericksen_and_drucker_everywhere_although_it_loses_ellipticity() {
    let law = BlatzKo::default();
    for (mode, lateral) in [
        (Mode::Uniaxial, Lateral::Free),
        (Mode::Equibiaxial, Lateral::PlaneStress),
        (Mode::SimpleShear, Lateral::PlaneStrain),
    ] {
        let path = path(&law, mode, lateral);
        for criterion in [
            Criterion::BakerEricksen,
            Criterion::Drucker,
            Criterion::DruckerAbaqus,
        ] {
            for tension in [true, false] {
                let track = track(&path, criterion, tension);
                assert!(
                    track.holds_at_start && track.events.is_empty(),
                    "{criterion:?}"
                );
            }
        }
    }
}

/// With `W = mu/2 |F|^2 + g(J)` the law is elliptic while `mu + g''(J) J^2 / (smallest stretch)^2 > 0`, with `g'' J^2 = mu + lambda (1 - ln J)`. In
/// uniaxial strain the smallest stretch is 1, so the limit is `exp(1 + 2 mu/lambda)`, for waves across the load.
#[test]
fn neo_hooke_in_uniaxial_strain_is_elliptic_up_to_exp_1_plus_2_mu_over_lambda() {
    for (mu, lambda) in [(1.0, 2.0), (0.3, 1.0), (1.0, 50.0), (2.0, 2.0)] {
        let law = NeoHooke { mu, lambda };
        let held = path(&law, Mode::Uniaxial, Lateral::Held);
        let track = track(&held, ELLIPTIC, true);
        let expected = (1.0 + 2.0 * mu / lambda).exp();
        if expected < 10.0 {
            assert_close(track.limit().expect("lost"), expected, 1e-12);
            let Some(Witness::Wave {
                direction,
                polarization,
            }) = track.witness()
            else {
                panic!("a wave is the witness");
            };
            assert!(direction[0].abs() < 1e-6 && polarization[0].abs() < 1e-6);
        } else {
            assert_eq!(track.limit(), None);
        }
        assert_eq!(limit(&held, ELLIPTIC, false), None);
    }
}

#[test]
fn ellipticity_of_neo_hooke_in_equibiaxial_and_equitriaxial_stretch_agrees_with_closed_forms() {
    let (mu, lambda) = (1.0, 10.0);
    let law = NeoHooke { mu, lambda };
    let g = |j: f64| mu + lambda * (1.0 - j.ln());
    let hydrostatic = path(&law, Mode::Hydrostatic, Lateral::Held);
    let expected = zero(|l| mu + g(l * l * l) / (l * l), 1.0, 5.0);
    assert_close(
        limit(&hydrostatic, ELLIPTIC, true).expect("lost"),
        expected,
        1e-12,
    );
    // In plane strain the softest wave is out of plane; in-plane waves keep real speeds longer.
    let plane = path(&law, Mode::Equibiaxial, Lateral::PlaneStrain);
    let all = (0.5 * (1.0 + 2.0 * mu / lambda)).exp();
    assert_close(limit(&plane, ELLIPTIC, true).expect("lost"), all, 1e-12);
    let within = zero(|l| mu + g(l * l) / (l * l), 1.0, 5.0);
    let found = limit(&plane, Criterion::PlaneEllipticity, true).expect("lost");
    assert_close(found, within, 1e-12);
    assert!(within > all + 0.01);
}

#[test]
fn equation_5_loses_planar_ellipticity_at_the_limit_of_paths() {
    let law = ModifiedMooneyRivlin::default();
    let equal = path(&law, Mode::Equibiaxial, Lateral::PlaneStrain);
    let found = limit(&equal, Criterion::PlaneEllipticity, true).expect("lost");
    assert_close(found, 1.669770460567, 1e-11);
    let uniaxial = path(&law, Mode::Uniaxial, Lateral::Held);
    let found = limit(&uniaxial, Criterion::PlaneEllipticity, true).expect("lost");
    assert_close(found, 2.754613297216, 1e-11);
}

/// In plane strain `W = (c1 + c2)/2 |F|^2 + g(J)`, which is elliptic again at large `J`.
#[test]
fn equation_5_regains_ellipticity_at_large_volumes() {
    let law = ModifiedMooneyRivlin::default();
    let equal = path(&law, Mode::Equibiaxial, Lateral::PlaneStrain);
    let changes: Vec<Change> = track(&equal, Criterion::PlaneEllipticity, true)
        .events
        .iter()
        .map(|event| event.change)
        .collect();
    assert_eq!(changes, [Change::Lost, Change::Regained]);
}

/// With free faces the load `P = mu (lambda^(-1/2) - lambda^-3)` is largest at `6^(2/5)`. Wave speeds are real up to `(2 + sqrt 3)^(4/5)`.
#[test]
fn a_bar_of_blatz_ko_reaches_its_largest_load_before_it_loses_ellipticity() {
    let law = BlatzKo::default();
    let bar = path(&law, Mode::Uniaxial, Lateral::Free);
    let load = limit(&bar, Criterion::LoadMaximum, true).expect("a largest load");
    assert_close(load, 6.0_f64.powf(0.4), 1e-12);
    assert_eq!(limit(&bar, Criterion::LoadMaximum, false), None);
}

#[test]
fn loads_of_blatz_ko_that_rise_in_closed_form_have_no_maximum() {
    let law = BlatzKo::default();
    // P = mu (lambda^2 - lambda^-3) always rises.
    let all = path(&law, Mode::Hydrostatic, Lateral::Held);
    assert_eq!(limit(&all, Criterion::LoadMaximum, true), None);
    // With held lateral faces P = mu (1 - lambda^-3) always rises.
    let held = path(&law, Mode::Uniaxial, Lateral::Held);
    assert_eq!(limit(&held, Criterion::LoadMaximum, true), None);
}

/// The energy is a positive definite quadratic form of the logarithms.
#[test]
fn hencky_satisfies_drucker_everywhere_and_loses_ellipticity_in_a_bar() {
    let law = Law::named("hencky")
        .expect("a law of the library")
        .build(&[("mu", 1.0), ("kappa", 5.0)])
        .expect("admissible");
    let bar = path(&*law, Mode::Uniaxial, Lateral::Free);
    for criterion in [
        Criterion::DruckerAbaqus,
        Criterion::Drucker,
        Criterion::BakerEricksen,
    ] {
        for tension in [true, false] {
            assert_eq!(limit(&bar, criterion, tension), None, "{criterion:?}");
        }
    }
    // With free faces tau = E ln(lambda), so the load tau / lambda is largest at e.
    let load = limit(&bar, Criterion::LoadMaximum, true).expect("a largest load");
    assert_close(load, std::f64::consts::E, 1e-12);
    assert!(limit(&bar, ELLIPTIC, true).expect("lost") > load);
}

/// Polyconvexity implies rank-one convexity and therefore ellipticity at all states, including states at the boundary of the domain or with enormous
/// numbers.
#[test]
fn polyconvex_laws_lose_neither_ellipticity_nor_rank_one_convexity() {
    let mut asked = 0;
    for law in library() {
        let defaults = law.parameters.iter();
        let parameters: Vec<(&str, f64)> = defaults
            .map(|parameter| (parameter.name, parameter.default))
            .collect();
        if polyconvexity(law.name, &parameters).knowledge != Knowledge::Polyconvex {
            continue;
        }
        asked += 1;
        let material = law.build(&[]).expect("admissible");
        let loading = Loading {
            mode: Mode::Planar,
            lateral: Lateral::PlaneStrain,
        };
        let isotropic = is_isotropic(&*material);
        let path = LoadingPath::new(&*material, isotropic, loading, &Range::default())
            .expect("a state in the reference configuration");
        for tension in [true, false] {
            let elliptic = track(&path, ELLIPTIC, tension);
            assert!(
                elliptic.holds_at_start && elliptic.events.is_empty(),
                "{}",
                law.name
            );
            let jumps = follow_jumps(&path, &elliptic, 10.0, tension);
            assert_eq!(jumps.limit(), None, "{}", law.name);
        }
    }
    assert!(asked >= 6, "{asked}");
}
