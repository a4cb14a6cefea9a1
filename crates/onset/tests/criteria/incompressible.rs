//! Incompressible response: published limits, and independent computations of the forms.

use super::{assert_close, limit, path, zero};
use nalgebra::{Matrix2, Matrix3, Vector3};
use onset::criteria::{
    Criterion, Lateral, Loading, LoadingError, LoadingPath, Mode, Range, Witness, follow,
    follow_jumps,
};
use onset::material::{Hyperelastic, Law};

const UNIAXIAL: Loading = Loading::INCOMPRESSIBLE[0];
const EQUIBIAXIAL: Loading = Loading::INCOMPRESSIBLE[1];
const PLANAR: Loading = Loading::INCOMPRESSIBLE[2];
const SHEAR: Loading = Loading::INCOMPRESSIBLE[3];

fn law(name: &str, parameters: &[(&str, f64)]) -> Box<dyn Hyperelastic> {
    Law::named(name)
        .expect("a law")
        .build(parameters)
        .expect("admissible")
}

fn kept<'a>(law: &'a dyn Hyperelastic, loading: Loading) -> LoadingPath<'a> {
    LoadingPath::incompressible(law, loading, &Range::default()).expect("a reference")
}

/// Limit of Biot (1963): `eta^3 + eta^2 + 3 eta = 1` with the ratio `eta` of the stretch along the surface to the stretch across it; lambda = 0.444,
/// 0.666 and 0.544. The volumetric part has no effect.
#[test]
fn neo_hooke_wrinkles_at_biots_limit() {
    let eta = zero(|x| x * x * x + x * x + 3.0 * x - 1.0, 0.1, 0.9);
    assert_close(eta, 0.295_597_742, 1e-8);
    for (name, parameters) in [
        ("neo-hooke", [("mu", 2.0), ("lambda", 0.3)]),
        ("neo-hooke-quadratic", [("mu", 0.4), ("lambda", 70.0)]),
        ("neo-hooke-isochoric", [("mu", 1.0), ("kappa", 1e4)]),
    ] {
        let law = law(name, &parameters);
        for (loading, power, published) in [
            (UNIAXIAL, 1.5, 0.444),
            (EQUIBIAXIAL, 3.0, 0.666),
            (PLANAR, 2.0, 0.544),
        ] {
            let found = limit(&kept(&*law, loading), Criterion::Surface, false).expect("lost");
            assert_close(found, eta.powf(1.0 / power), 1e-9);
            assert_close(found, published, 6e-4);
        }
        // In tension the surface is stretched along both of its axes.
        assert_eq!(limit(&kept(&*law, PLANAR), Criterion::Surface, true), None);
    }
}

/// In plane deformations an incompressible isotropic law is strongly elliptic if the energy `w(k)` of simple shear has `w'(k)/k > 0` and `w''(k) > 0`
/// (Abeyaratne, J. Elasticity 10 (1980) 255). Yeoh: `w = c10 k^2 + c20 k^4 + c30 k^6`.
#[test]
fn simple_shear_loses_ellipticity_where_its_curve_has_its_maximum() {
    let (c10, c20, c30) = (0.5, -0.1, 0.01);
    let law = law(
        "yeoh",
        &[("c10", c10), ("c20", c20), ("c30", c30), ("kappa", 50.0)],
    );
    let second = |k: f64| 2.0 * c10 + 12.0 * c20 * k.powi(2) + 30.0 * c30 * k.powi(4);
    let k = zero(second, 0.5, 1.3);
    let shear = kept(&*law, SHEAR);
    let found = limit(&shear, Criterion::PlaneEllipticity, true).expect("lost");
    assert_close(found - 1.0 / found, k, 1e-9);
    let all = limit(&shear, Criterion::StrongEllipticity, true).expect("lost");
    assert!(all <= found * (1.0 + 1e-9), "{all} {found}");
    // Layers of two shears preserve the volume and lower the energy earlier.
    let track = follow(&shear, Criterion::StrongEllipticity, true).expect("defined");
    let jumps = follow_jumps(&shear, &track, 10.0, true);
    let own = jumps.limit().expect("lost");
    assert!(own < all * (1.0 - 1e-3), "{own} {all}");
    let Some(Witness::Jump {
        amplitude,
        direction,
        ..
    }) = jumps.witness()
    else {
        panic!("a jump is the witness");
    };
    let f = shear
        .at(own.ln())
        .expect("a state")
        .response
        .deformation
        .matrix();
    let jumped = f + Vector3::from(*amplitude) * Vector3::from(*direction).transpose();
    assert_close(jumped.determinant(), 1.0, 1e-9);
}

/// Slowest wave over a grid of directions `N`, with polarizations that satisfy `g . F^-T N = 0`, from the tangent of the compressible law.
#[test]
fn ellipticity_covers_all_volume_preserving_waves() {
    for (name, parameters) in [
        ("yeoh", vec![("c10", 0.5), ("c20", -0.1), ("c30", 0.01)]),
        ("ogden", vec![("mu1", 1.0), ("alpha1", 0.4)]),
        ("mooney-rivlin-isochoric", vec![("c10", 0.5), ("c01", -0.2)]),
        ("hencky", vec![]),
    ] {
        let law = law(name, &parameters);
        for loading in Loading::INCOMPRESSIBLE {
            let path = kept(&*law, loading);
            for s in [-1.4, -0.7, -0.3, 0.2, 0.5, 0.9, 1.5] {
                let Some(state) = path.at(s) else { continue };
                let measure = Criterion::StrongEllipticity
                    .measure(&path.ask(&state))
                    .expect("defined");
                let response = law.response(&state.response.deformation).expect("finite");
                let slowest = slowest(&response);
                let scale = state.response.tangent[(0, 0, 0, 0)].abs().max(1.0);
                if slowest.abs() < 2e-3 * scale {
                    continue;
                }
                assert_eq!(
                    measure.value > 0.0,
                    slowest > 0.0,
                    "{name} {loading:?} {s}: {} {slowest}",
                    measure.value
                );
            }
        }
    }
}

/// Smallest `g . Q(N) g` over a grid of unit vectors `N` and `g` with `g . F^-T N = 0`.
fn slowest(response: &onset::material::Response) -> f64 {
    let f = response.deformation.matrix();
    let inverse = f.try_inverse().expect("invertible").transpose();
    let mut lowest = f64::INFINITY;
    let count = 60;
    for (a, b) in (0..=count).flat_map(|a| (0..2 * count).map(move |b| (a, b))) {
        let theta = std::f64::consts::PI * f64::from(a) / f64::from(count);
        let phi = std::f64::consts::PI * f64::from(b) / f64::from(count);
        let n = Vector3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        );
        let q = Matrix3::from_fn(|i, k| {
            (0..9)
                .map(|m| response.tangent[(i, m / 3, k, m % 3)] * n[m / 3] * n[m % 3])
                .sum()
        });
        let normal = (inverse * n).normalize();
        let first = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
        let second = normal.cross(&first);
        let q = Matrix2::new(
            first.dot(&(q * first)),
            first.dot(&(q * second)),
            first.dot(&(q * second)),
            second.dot(&(q * second)),
        );
        lowest = lowest.min(q.symmetric_eigenvalues().min());
    }
    lowest
}

/// Abaqus eliminates the third strain: its matrix contains the second derivatives of `W(e^a, e^b, e^(-a-b))`.
#[test]
fn the_drucker_check_is_the_hessian_of_the_energy_in_two_strains() {
    for (name, parameters) in [
        ("mooney-rivlin-isochoric", vec![("c10", 0.5), ("c01", -0.1)]),
        ("yeoh", vec![("c10", 0.5), ("c20", -0.1), ("c30", 0.01)]),
        ("ogden", vec![]),
    ] {
        let law = law(name, &parameters);
        for loading in [UNIAXIAL, EQUIBIAXIAL, PLANAR] {
            let path = kept(&*law, loading);
            for s in [-0.9, -0.4, -0.1, 0.2, 0.5, 0.8, 1.2] {
                let state = path.at(s).expect("a state");
                let stretches = state.response.deformation.matrix().diagonal();
                let energy = |a: f64, b: f64| {
                    let x = [
                        stretches[0] * a.exp(),
                        stretches[1] * b.exp(),
                        stretches[2] * (-a - b).exp(),
                    ];
                    let f = onset::kinematics::DeformationGradient::from_stretches(x)
                        .expect("stretches");
                    law.response(&f).expect("finite").energy
                };
                let h = 1e-4;
                let aa = (energy(h, 0.0) - 2.0 * energy(0.0, 0.0) + energy(-h, 0.0)) / (h * h);
                let bb = (energy(0.0, h) - 2.0 * energy(0.0, 0.0) + energy(0.0, -h)) / (h * h);
                let ab =
                    (energy(h, h) - energy(h, -h) - energy(-h, h) + energy(-h, -h)) / (4.0 * h * h);
                // Second derivatives in the orthonormal basis of increments (1, 0, -1)/sqrt 2 and (-1, 2, -1)/sqrt 6.
                let u = |x: [f64; 2], y: [f64; 2]| {
                    x[0] * y[0] * aa + (x[0] * y[1] + x[1] * y[0]) * ab + x[1] * y[1] * bb
                };
                let (first, second) = (
                    [0.5_f64.sqrt(), 0.0],
                    [-(6.0_f64.recip().sqrt()), 2.0 / 6.0_f64.sqrt()],
                );
                let form = Matrix2::new(
                    u(first, first),
                    u(first, second),
                    u(first, second),
                    u(second, second),
                );
                let expected = form.symmetric_eigenvalues().min();
                let found = Criterion::DruckerAbaqus
                    .measure(&path.ask(&state))
                    .expect("defined")
                    .value;
                assert!(
                    (found - expected).abs() < 1e-4 * aa.abs().max(1.0),
                    "{name} {loading:?} {s}: {found} {expected}"
                );
            }
        }
    }
}

/// Treloar's rubber with three Ogden terms: Abaqus finds the fit stable at all strains. With a bulk modulus of 100 the compressible form fails in
/// equibiaxial compression by a pure dilation, which is not an incompressible increment.
#[test]
fn treloars_fit_is_stable_throughout() {
    let law = law("ogden", &[]);
    for loading in [UNIAXIAL, EQUIBIAXIAL, PLANAR] {
        let path = kept(&*law, loading);
        for tension in [true, false] {
            assert_eq!(
                limit(&path, Criterion::DruckerAbaqus, tension),
                None,
                "{loading:?}"
            );
        }
    }
    let compressible = path(&*law, Mode::Equibiaxial, Lateral::PlaneStress);
    let lost = limit(&compressible, Criterion::DruckerAbaqus, false).expect("lost");
    assert_close(lost, 0.2887, 5e-4);
    let track = follow(&compressible, Criterion::DruckerAbaqus, false).expect("defined");
    let Some(Witness::StrainRate { rate }) = track.witness() else {
        panic!("a rate");
    };
    assert!(
        rate[0][0] * rate[1][1] > 0.0 && rate[0][0] * rate[2][2] > 0.0,
        "{rate:?}"
    );
}

#[test]
fn the_free_face_is_traction_free_at_constant_volume() {
    let law = law("gent", &[]);
    for loading in Loading::INCOMPRESSIBLE {
        let path = kept(&*law, loading);
        for state in [path.at(0.4), path.at(-0.6)].into_iter().flatten() {
            let response = &state.response;
            assert!(response.first_piola[(2, 2)].abs() < 1e-12);
            assert_close(response.deformation.jacobian(), 1.0, 1e-13);
            let inverse = response
                .deformation
                .matrix()
                .try_inverse()
                .expect("invertible");
            assert!((inverse * state.rate).trace().abs() < 1e-12);
        }
    }
    let swelling = Loading {
        mode: Mode::Hydrostatic,
        lateral: Lateral::Held,
    };
    let refused = LoadingPath::incompressible(&*law, swelling, &Range::default());
    assert_eq!(refused.err(), Some(LoadingError::ChangesVolume));
}

/// The load `P = 3 mu ln(lambda) / lambda` of a bar of a Hencky material is largest at the stretch e, and under pressure rotations lower the energy immediately.
/// For any large bulk modulus every loading with free faces has the limits of the incompressible law, and equally many limits with `kappa = 1e9`.
#[test]
fn a_huge_bulk_modulus_is_a_regular_limit() {
    let stiff =
        [1e9, 1e10, 1e11, 1e12].map(|kappa| law("hencky", &[("mu", 1.0), ("kappa", kappa)]));
    for own in &stiff {
        let bar = path(&**own, Mode::Uniaxial, Lateral::Free);
        let load = follow(&bar, Criterion::LoadMaximum, true).expect("defined");
        assert_eq!(load.events.len(), 1, "{:?}", load.events);
        assert_close(load.events[0].stretch, std::f64::consts::E, 1e-9);
        assert_eq!(limit(&bar, Criterion::Hill, false), Some(1.0));
    }
    let free = [
        (Mode::Uniaxial, Lateral::Free),
        (Mode::Uniaxial, Lateral::PlaneStrain),
        (Mode::Equibiaxial, Lateral::PlaneStress),
        (Mode::Planar, Lateral::PlaneStress),
        (Mode::Planar, Lateral::PlaneStrain),
        (Mode::SimpleShear, Lateral::Free),
        (Mode::SimpleShear, Lateral::PlaneStrain),
    ];
    let soft = law("hencky", &[("mu", 1.0), ("kappa", 1e6)]);
    for (mode, lateral) in free {
        let paths = stiff.each_ref().map(|own| path(&**own, mode, lateral));
        let soft = path(&*soft, mode, lateral);
        for criterion in [
            Criterion::StrongEllipticity,
            Criterion::DruckerAbaqus,
            Criterion::HillRotationFree,
            Criterion::OrderedForces,
            Criterion::LoadMaximum,
        ] {
            for tension in [true, false] {
                let events = |path: &LoadingPath<'_>| -> Vec<f64> {
                    let track = follow(path, criterion, tension).expect("defined");
                    track.events.iter().map(|event| event.stretch).collect()
                };
                let expected = events(&soft);
                for path in &paths {
                    let own = events(path);
                    let what = format!("{mode:?} {lateral:?} {criterion:?}: {own:?} {expected:?}");
                    assert_eq!(own.len(), expected.len(), "{what}");
                    for (own, expected) in own.iter().zip(&expected) {
                        // At a bulk modulus of 1e6 the forces of large shears still change the volume; at 1e12 rounding leaves three digits there.
                        assert!((own / expected - 1.0).abs() < 2e-3, "{what}");
                    }
                }
            }
        }
    }
}

/// Bulk moduli from 1e4 to 1e12 in steps of the root of ten, for shear moduli of 1.
fn bulk_moduli() -> impl Iterator<Item = f64> {
    (8..=24).map(|n| 10.0_f64.powf(0.5 * f64::from(n)))
}

/// The neo-Hookean Kirchhoff stress grows with the logarithmic strain in every direction that preserves the volume. In the flat state of equibiaxial
/// compression to a tenth its stiffness is a millionth of the stress.
#[test]
fn a_nearly_incompressible_neo_hookean_solid_is_stable_in_druckers_sense_at_any_bulk_modulus() {
    for kappa in bulk_moduli() {
        let own = law("neo-hooke-isochoric", &[("mu", 1.0), ("kappa", kappa)]);
        let path = path(&*own, Mode::Equibiaxial, Lateral::PlaneStress);
        for criterion in [
            Criterion::Drucker,
            Criterion::DruckerAbaqus,
            Criterion::TrueStressMonotonicity,
        ] {
            let found = follow(&path, criterion, false).expect("defined").events;
            assert!(found.is_empty(), "{kappa:e} {criterion:?}: {found:?}");
        }
    }
}

/// In uniaxial tension of a Mooney-Rivlin solid with `c01 < 0` the two lateral stretches bifurcate where `c10 + c01 lambda^2 = 0`. Up to there Hill's
/// criterion is neutral, since the bar may turn about its axis.
#[test]
fn lateral_stretches_of_a_mooney_rivlin_bar_bifurcate_at_one_stretch_for_any_bulk_modulus() {
    for kappa in bulk_moduli() {
        let given = [("c10", 0.6), ("c01", -0.1), ("kappa", kappa)];
        let own = law("mooney-rivlin-isochoric", &given);
        let bar = path(&*own, Mode::Uniaxial, Lateral::Free);
        for criterion in [
            Criterion::Hill,
            Criterion::BakerEricksen,
            Criterion::OrderedForces,
        ] {
            let found = limit(&bar, criterion, true).expect("lost");
            let error = (found / 6.0_f64.sqrt() - 1.0).abs();
            assert!(
                error < 1e-5 + 10.0 / kappa,
                "{kappa:e} {criterion:?}: {found}"
            );
        }
    }
}

/// In shear one stress is a pressure, and rotations lower the energy of dead loads immediately. The rounding of a stiff law does not change this
/// limit.
#[test]
fn a_limit_at_the_reference_configuration_stays_there_at_any_bulk_modulus() {
    for kappa in [1.0, 1e3, 1e5, 1e6, 1e7, 1e8] {
        let own = law("hencky", &[("mu", 1.0), ("kappa", kappa)]);
        for mode in [Mode::SimpleShear, Mode::Planar] {
            let path = path(&*own, mode, Lateral::PlaneStrain);
            for tension in [true, false] {
                let hill = limit(&path, Criterion::Hill, tension);
                assert_eq!(hill, Some(1.0), "{kappa}: {mode:?} {tension}");
            }
        }
    }
}

/// In uniaxial strain the energy of a jump is a small difference of volumetric energies. The tolerance of the limit contains their rounding.
#[test]
fn the_tolerance_of_a_limit_of_finite_jumps_contains_the_rounding_of_the_volumetric_energy() {
    let event = |kappa: f64, mode: Mode| {
        let own = law("hencky", &[("mu", 1.0), ("kappa", kappa)]);
        let path = path(&*own, mode, Lateral::Held);
        let elliptic = follow(&path, Criterion::StrongEllipticity, false).expect("defined");
        let track = follow_jumps(&path, &elliptic, 10.0, false);
        *track.events.first().expect("a limit")
    };
    for mode in [Mode::Uniaxial, Mode::Equibiaxial] {
        let exact = event(1e7, mode).stretch;
        for kappa in [1e9, 1e10, 1e11, 1e12] {
            let own = event(kappa, mode);
            let distance = (own.stretch / exact).ln().abs();
            assert!(
                distance < own.tolerance + 1e-4,
                "{mode:?} {kappa:e}: {distance} {own:?}"
            );
        }
    }
}

/// Limits of finite jumps differ from the limits of the incompressible law by `mu/kappa`: the valleys of the energy among volume-preserving jumps become narrow, and
/// are followed.
#[test]
fn finite_jumps_of_nearly_incompressible_laws_tend_to_the_incompressible_limit() {
    let jumps = |path: &LoadingPath<'_>, tension: bool| {
        let elliptic = follow(path, Criterion::StrongEllipticity, tension).expect("defined");
        follow_jumps(path, &elliptic, 10.0, tension).limit()
    };
    for (kept_loading, mode, lateral) in [
        (UNIAXIAL, Mode::Uniaxial, Lateral::Free),
        (PLANAR, Mode::Planar, Lateral::PlaneStress),
    ] {
        let soft = law("hencky", &[("mu", 1.0), ("kappa", 1.0)]);
        let incompressible = kept(&*soft, kept_loading);
        for kappa in [1e3, 1e6] {
            let own = law("hencky", &[("mu", 1.0), ("kappa", kappa)]);
            let own = path(&*own, mode, lateral);
            for tension in [true, false] {
                let expected = jumps(&incompressible, tension).expect("a limit");
                let limit = jumps(&own, tension).expect("a limit");
                let off = (limit / expected - 1.0).abs();
                assert!(off < 3.0 / kappa, "{mode:?} {kappa:e}: {limit} {expected}");
            }
        }
    }
}

/// Compares the part of the tangent on volume-preserving increments with a law whose bulk modulus is so small that all digits are retained.
#[test]
fn rounding_of_volume_changes_does_not_affect_isochoric_increments() {
    let state = onset::kinematics::DeformationGradient::new([
        [1.1, 0.3, 0.0],
        [-0.2, 0.9, 0.1],
        [0.0, 0.4, 1.0],
    ])
    .expect("admissible");
    let size = state.determinant().cbrt().recip();
    let state = state.components().map(|row| row.map(|x| x * size));
    let state = onset::kinematics::DeformationGradient::new(state).expect("isochoric");
    for (name, bulk) in [
        ("hencky", "kappa"),
        ("neo-hooke", "lambda"),
        ("ogden", "kappa"),
        ("neo-hooke-isochoric", "kappa"),
    ] {
        let [soft, stiff] = [1.0, 1e12].map(|size| law(name, &[(bulk, size)]));
        let [soft, stiff] = [&soft, &stiff].map(|law| law.isochoric_response(&state));
        let [soft, stiff] = [soft.expect("finite"), stiff.expect("finite")];
        let mut error: f64 = 0.0;
        for n in 0..81 {
            let at = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
            error = error.max((soft.tangent[at] - stiff.tangent[at]).abs());
        }
        // The pressure due to the rounding of ln J is in both tangents, and 1e12 times as large in one of them.
        assert!(error < 3e-3, "{name}: {error}");
        let deviator = |response: &onset::material::Response| {
            let tau = response.first_piola * state.matrix().transpose();
            tau - Matrix3::from_diagonal_element(tau.trace() / 3.0)
        };
        assert!(
            (deviator(&soft) - deviator(&stiff)).amax() < 1e-12,
            "{name}"
        );
    }
}

/// With `J^(-2/3) I1` and `J^(-4/3) I2`, the shear stiffness between two axes vanishes at `c10 + c01 lambda_k^2 J^(-2/3) = 0` for the stretch `lambda_k` of
/// the third axis, at any bulk modulus. The pressure of imposed volumes grows with the bulk modulus.
#[test]
fn losses_at_imposed_volumes_do_not_depend_on_the_bulk_modulus() {
    let stretched = |title: &str| {
        let mut all = Loading::ALL.into_iter();
        all.find(|loading| loading.title() == title)
            .expect("a loading")
    };
    for (title, c01, power) in [
        ("uniaxial strain", -0.1, 0.75),
        ("uniaxial strain", -0.2, 0.75),
        ("equibiaxial, plane strain", -0.2, 1.5),
    ] {
        let expected = f64::powf(-0.5 / c01, power);
        for decade in 3..=12 {
            let kappa = 10.0_f64.powi(decade);
            let law = law(
                "mooney-rivlin-isochoric",
                &[("c10", 0.5), ("c01", c01), ("kappa", kappa)],
            );
            let loading = stretched(title);
            let path = LoadingPath::new(&*law, true, loading, &Range::default()).expect("a path");
            let found = |criterion| limit(&path, criterion, true).expect("lost");
            assert_close(found(Criterion::BakerEricksen), expected, 1e-9);
            let elliptic = found(Criterion::StrongEllipticity);
            assert!(
                elliptic <= expected * (1.0 + 1e-9),
                "{title} {kappa} {elliptic}"
            );
            if decade >= 6 {
                assert_close(elliptic, expected, 2e-6);
            }
        }
    }
}
