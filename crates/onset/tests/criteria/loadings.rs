//! Loadings: traction-free faces are solved for, and paths end where they must.

use super::{NeoHooke, assert_close, limit, path, track, zero};
use onset::criteria::{Criterion, Lateral, Loading, LoadingPath, Mode, PathEnd, Range};
use onset::kinematics::DeformationGradient;
use onset::material::{
    BlatzKo, Hyperelastic, Law, ModifiedMooneyRivlin, PlaneStress, StrainEnergy,
};
use onset::real::Real;

#[test]
fn free_faces_carry_no_traction() {
    let law = ModifiedMooneyRivlin::default();
    for loading in Loading::ALL {
        let path = LoadingPath::new(&law, true, loading, &Range::default()).expect("a path");
        let free: &[usize] = match loading.lateral {
            Lateral::Free => &[1, 2],
            Lateral::PlaneStress => &[2],
            Lateral::PlaneStrain if loading.mode == Mode::Uniaxial => &[1],
            _ => &[],
        };
        for state in path.tension.iter().chain(&path.compression) {
            let (p, f) = (&state.response.first_piola, &state.response.deformation);
            for axis in free {
                let bound = 1e-12 * 20.0 / f.components()[*axis][*axis];
                assert!(p[(*axis, *axis)].abs() < bound, "{}", loading.title());
            }
        }
        assert!(path.tension_end == PathEnd::Range && path.compression_end == PathEnd::Range);
        assert_close(
            path.tension.last().expect("states").parameter.exp(),
            10.0,
            1e-12,
        );
    }
}

#[test]
fn a_blatz_ko_bar_contracts_with_a_poisson_ratio_of_one_quarter() {
    let law = BlatzKo::default();
    let bar = path(&law, Mode::Uniaxial, Lateral::Free);
    for stretch in [0.2, 0.77, 1.0, 1.5, 6.0_f64] {
        let state = bar.at(stretch.ln()).expect("a state");
        let f = state.response.deformation.components();
        assert_close(f[1][1], stretch.powf(-0.25), 1e-13);
        assert_close(f[2][2], stretch.powf(-0.25), 1e-13);
        let load = 32.0 * (stretch.powf(-0.5) - stretch.powi(-3));
        assert_close(state.response.first_piola[(0, 0)], load, 1e-12);
    }
}

#[test]
fn nearly_incompressible_bars_approach_incompressible_bars() {
    for (lambda, tolerance) in [(1e3, 2e-2), (1e5, 2e-4), (1e7, 2e-6)] {
        let law = NeoHooke { mu: 1.0, lambda };
        let bar = path(&law, Mode::Uniaxial, Lateral::Free);
        for stretch in [0.5, 2.0, 4.0_f64] {
            let state = bar.at(stretch.ln()).expect("a state");
            let load = stretch - stretch.powi(-2);
            assert_close(state.response.first_piola[(0, 0)], load, tolerance);
            let jacobian = state.response.deformation.jacobian();
            assert_close(jacobian, 1.0, tolerance);
        }
        // The incompressible neo-Hookean law is elliptic at all these states.
        assert_eq!(limit(&bar, Criterion::StrongEllipticity, true), None);
        assert_eq!(limit(&bar, Criterion::Drucker, true), None);
    }
}

/// The load along a path is differentiated numerically: its maximum is at `Pdot : Fdot = 0`.
#[test]
fn the_load_maximum_is_where_the_load_is_largest() {
    let law = ModifiedMooneyRivlin::default();
    for (mode, lateral) in [
        (Mode::Uniaxial, Lateral::Held),
        (Mode::Equibiaxial, Lateral::PlaneStrain),
        (Mode::Hydrostatic, Lateral::Held),
    ] {
        let path = path(&law, mode, lateral);
        let found = limit(&path, Criterion::LoadMaximum, true).expect("a largest load");
        let load = |s: f64| path.at(s).expect("a state").response.first_piola[(0, 0)];
        let slope = |s: f64| {
            let h = 1e-3;
            (8.0 * (load(s + h) - load(s - h)) - (load(s + 2.0 * h) - load(s - 2.0 * h)))
                / (12.0 * h)
        };
        let expected = zero(slope, found.ln() - 0.1, found.ln() + 0.1);
        assert_close(found.ln(), expected, 1e-8);
    }
}

/// The tangent of a metal belongs to continued flow and is not the derivative of the stress with respect to the state. The free faces are
/// nevertheless found, and the branch continues beyond yield to the end.
#[test]
fn free_faces_of_a_metal_beyond_yield_carry_no_traction() {
    let mut metals = onset::plasticity::library().iter();
    let sheet = metals.find(|law| law.name == "hill-1948");
    let sheet = sheet.expect("a law").build(&[]).expect("admissible");
    let range = Range::new(0.8, 1.3).expect("a range");
    for (mode, lateral) in [
        (Mode::Uniaxial, Lateral::Free),
        (Mode::Uniaxial, Lateral::PlaneStrain),
        (Mode::Planar, Lateral::PlaneStress),
    ] {
        let loading = Loading { mode, lateral };
        let path = LoadingPath::new(&*sheet, false, loading, &range).expect("a path");
        assert_eq!(
            [&path.tension_end, &path.compression_end],
            [&PathEnd::Range, &PathEnd::Range],
            "{}",
            loading.title()
        );
        for state in path.tension.iter().chain(&path.compression) {
            let p = &state.response.first_piola;
            let free: &[usize] = match (mode, lateral) {
                (Mode::Planar, _) => &[2],
                (_, Lateral::Free) => &[1, 2],
                _ => &[1],
            };
            for axis in free {
                // The moduli are about 200.
                assert!(p[(*axis, *axis)].abs() < 1e-9, "{}", loading.title());
            }
        }
    }
    // Lankford's ratio r0 = 1.8 of width to thickness strain, at large plastic strain.
    let loading = Loading {
        mode: Mode::Uniaxial,
        lateral: Lateral::Free,
    };
    let bar = LoadingPath::new(&*sheet, false, loading, &range).expect("a path");
    let end = bar.tension.last().expect("states").response.deformation;
    let strains = [1, 2].map(|axis: usize| end.components()[axis][axis].ln());
    assert_close(strains[0] / strains[1], 1.8, 1e-2);
}

/// With `P33 = sin(x - 1) - (lambda - 1)` and the free stretch `x` no state exists beyond `lambda = 2`.
struct Folding;

impl StrainEnergy for Folding {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let f = f.components();
        let x = f[2][2] - 1.0;
        -x.cos() - (f[0][0] - 1.0) * x + f[0][0] * f[0][0] + f[1][1] * f[1][1]
    }
}

#[test]
fn a_path_ends_where_free_faces_lose_equilibrium_and_other_states_are_found() {
    let loading = Loading {
        mode: Mode::Planar,
        lateral: Lateral::PlaneStress,
    };
    let path = LoadingPath::new(&Folding, false, loading, &Range::default()).expect("a state at 1");
    let PathEnd::Fold { stretch } = path.tension_end else {
        panic!("the path has a fold: {:?}", path.tension_end);
    };
    assert_close(stretch, 2.0, 1e-14);
    // The equilibrium sin y = 1/2 holds at y = pi/6, on the branch of the path, and at y = 5 pi/6.
    let s = 1.5_f64.ln();
    let own = path.at(s).expect("a state").response.deformation;
    let sixth = std::f64::consts::PI / 6.0;
    assert_close(own.components()[2][2], 1.0 + sixth, 1e-12);
    let others = path.other_states(s);
    let second = others
        .iter()
        .map(|f| f.components()[2][2])
        .find(|x| (x - 1.0 - 5.0 * sixth).abs() < 1e-9);
    assert!(second.is_some(), "{others:?}");
}

/// The energy `W = (I1 - 3)/2 - ln J + k w^2/2 (1 - exp(-((J - 1)/w)^2))` has a softening dilation, `k = 10`, `w = 0.1`.
struct Softening;

impl StrainEnergy for Softening {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let i = f.invariants();
        let x = (i.jacobian - 1.0) * 10.0;
        (i.first - 3.0) * 0.5 - i.jacobian.ln() - ((-(x * x)).exp() - 1.0) * 0.05
    }
}

/// Stretch, free stretch and volume of the limit points, by arc-length continuation of the closed form of the traction on the free faces.
const FOLDS: [(Mode, Lateral, bool, [f64; 3]); 6] = [
    (
        Mode::Equibiaxial,
        Lateral::PlaneStress,
        true,
        [1.20989, 0.73711, 1.07900],
    ),
    (
        Mode::Equibiaxial,
        Lateral::PlaneStress,
        false,
        [0.88265, 1.16686, 0.90906],
    ),
    (
        Mode::Uniaxial,
        Lateral::Free,
        true,
        [1.98875, 0.73562, 1.07620],
    ),
    (
        Mode::Uniaxial,
        Lateral::Free,
        false,
        [0.66265, 1.17956, 0.92198],
    ),
    (
        Mode::Planar,
        Lateral::PlaneStress,
        true,
        [1.46383, 0.73720, 1.07914],
    ),
    (
        Mode::Planar,
        Lateral::PlaneStress,
        false,
        [0.77907, 1.16684, 0.90905],
    ),
];

#[test]
fn a_path_ends_at_the_fold_of_its_free_faces_for_any_range() {
    for (mode, lateral, tension, [stretch, free, volume]) in FOLDS {
        let loading = Loading { mode, lateral };
        for (low, high) in [(0.3, 3.0), (0.6, 2.2), (0.1, 10.0)] {
            let range = Range::new(low, high).expect("a range");
            let path = LoadingPath::new(&Softening, true, loading, &range).expect("a path");
            let (end, states) = match tension {
                true => (&path.tension_end, &path.tension),
                false => (&path.compression_end, &path.compression),
            };
            let PathEnd::Fold { stretch: found } = end else {
                panic!("{} has a fold: {end:?}", loading.title());
            };
            assert_close(*found, stretch, 1e-4);
            let last = &states.last().expect("a state").response;
            assert_close(last.deformation.components()[2][2], free, 5e-4);
            assert_close(last.deformation.jacobian(), volume, 5e-4);
            // Stiffness of the free faces, against a common change of both if there are two.
            let stiffness = match lateral {
                Lateral::Free => last.tangent[(2, 2, 2, 2)] + last.tangent[(2, 2, 1, 1)],
                _ => last.tangent[(2, 2, 2, 2)],
            };
            assert!(stiffness.abs() < 1e-12, "{stiffness}");
            // The path has states up to the fold, and no state of another branch before the fold.
            let mut before: f64 = 1.0;
            for n in 1..=2000 {
                let state = path
                    .at(found.ln() * f64::from(n) / 2000.0)
                    .expect("a state");
                let t = state.response.deformation.components()[2][2];
                assert!((t - before).abs() < 0.01, "{t} after {before}");
                before = t;
            }
            for distance in [1e-6, 1e-9, 1e-12, 1e-15] {
                let near = path.at(found.ln() * (1.0 - distance)).expect("a state");
                let t = near.response.deformation.components()[2][2];
                assert!((t - last.deformation.components()[2][2]).abs() < 3.0 * distance.sqrt());
            }
            assert!(path.at(found.ln() * 1.001).is_none());
        }
    }
}

#[test]
fn a_single_free_face_loses_strong_ellipticity_at_its_fold() {
    for (mode, lateral, tension, [stretch, ..]) in FOLDS {
        let path = path(&Softening, mode, lateral);
        let found = track(&path, Criterion::StrongEllipticity, tension).limit();
        match (lateral, tension) {
            // At this fold a common change of both faces has no stiffness, but every wave has.
            (Lateral::Free, _) => assert_eq!(found, None),
            (_, true) => assert_close(found.expect("lost at the fold"), stretch, 1e-4),
            // Ellipticity is lost shortly before the fold, for waves in the compressed plane.
            (_, false) => {
                let found = found.expect("lost");
                assert!(found > stretch && found < stretch + 1e-3, "{found}");
            }
        }
        let load = track(&path, Criterion::LoadMaximum, tension).limit();
        let before = (load.expect("a largest load").ln() / stretch.ln()).abs();
        assert!(before < 1.0 + 1e-4 && before > 0.97, "{before}");
    }
}

#[test]
fn a_sheet_ends_where_its_thickness_has_a_fold() {
    let sheet = PlaneStress::new(std::sync::Arc::new(Softening), 2).expect("a sheet");
    for (mode, lateral, tension, [stretch, ..]) in FOLDS {
        let loading = Loading { mode, lateral };
        let path = LoadingPath::new(&sheet, false, loading, &Range::default()).expect("a path");
        let end = match tension {
            true => &path.tension_end,
            false => &path.compression_end,
        };
        let PathEnd::Fold { stretch: found } = end else {
            panic!("{} has a fold: {end:?}", loading.title());
        };
        assert_close(*found, stretch, 1e-4);
    }
    // A single state beyond the fold is not a state of another branch.
    let beyond = DeformationGradient::from_stretches([1.2125, 1.2125, 1.0]).expect("a state");
    assert!(sheet.response(&beyond).is_err());
}

/// Gent's law has no energy beyond `I1 = 3 + jm`.
struct Limited;

impl StrainEnergy for Limited {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let i = f.invariants();
        let log = i.jacobian.ln();
        ((i.first - 3.0) * -0.1 + 1.0).ln() * -5.0 - log + log * log
    }
}

#[test]
fn a_path_ends_at_the_edge_of_the_domain_of_the_law() {
    let held = path(&Limited, Mode::Uniaxial, Lateral::Held);
    let PathEnd::Law { stretch, .. } = held.tension_end else {
        panic!("the law has an end: {:?}", held.tension_end);
    };
    // The domain of the law ends at lambda^2 - 1 = 10.
    assert_close(stretch, 11.0_f64.sqrt(), 1e-9);
    assert!(track(&held, Criterion::StrongEllipticity, true).holds_at_start);
}

#[test]
fn ranges_without_1_are_rejected() {
    assert!(Range::new(0.5, 3.0).is_ok());
    for (low, high) in [
        (1.1, 2.0),
        (0.5, 0.9),
        (2.0, 0.5),
        (0.0, 2.0),
        (0.5, f64::NAN),
    ] {
        let error = Range::new(low, high).expect_err("no range").to_string();
        assert!(error.contains("for example 0.1,10"), "{error}");
    }
}

/// The law is a hyperfoam with `beta = 0` and exponent 8. A state exists at every amount of shear, since the energy is unbounded toward both ends of
/// the free stretch, but stiffnesses differ by many orders of magnitude.
#[test]
fn a_path_continues_where_tractions_cancel_large_terms() {
    let law = Law::named("hyperfoam")
        .expect("a law of the library")
        .build(&[])
        .expect("admissible");
    let path = path(&*law, Mode::SimpleShear, Lateral::Free);
    assert!(path.tension_end == PathEnd::Range && path.compression_end == PathEnd::Range);
}
