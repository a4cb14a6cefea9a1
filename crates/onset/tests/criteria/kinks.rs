//! Kinks of laws along loadings.

use super::{path, track, zero};
use nalgebra::{Matrix3, Vector3};
use onset::criteria::{
    Change, Criterion, Discontinuity, Lateral, Loading, LoadingPath, Mode, PathEnd, Range, Witness,
    follow, follow_jumps, is_isotropic, kinks,
};
use onset::formula::Formula;
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, Law};

fn found(name: &str, mode: Mode, lateral: Lateral) -> Vec<f64> {
    let law = Law::named(name)
        .expect("a law")
        .build(&[])
        .expect("defaults");
    let range = Range::new(0.5, 2.0).expect("a range");
    let loading = Loading { mode, lateral };
    let path = LoadingPath::new(&*law, is_isotropic(&*law), loading, &range).expect("a path");
    kinks(&path).iter().map(|kink| kink.stretch).collect()
}

#[test]
fn smooth_laws_have_no_kinks() {
    for name in [
        "blatz-ko",
        "ogden",
        "holzapfel-gasser-ogden",
        "gent",
        "hencky",
        "cubic-crystal",
    ] {
        for (mode, lateral) in [
            (Mode::Uniaxial, Lateral::Held),
            (Mode::Equibiaxial, Lateral::PlaneStrain),
            (Mode::Hydrostatic, Lateral::Held),
        ] {
            assert_eq!(found(name, mode, lateral), [], "{name} {mode:?}");
        }
    }
}

/// Tension-only fibers become active where their isochoric stretch is 1: in the reference configuration, and in uniaxial strain where `J^(-2/3)
/// (lambda^2 cos^2 + sin^2) = 1` is satisfied a second time, if the angle permits.
#[test]
fn tension_only_fibers_have_kinks_where_they_become_active() {
    let stretches = found(
        "holzapfel-gasser-ogden-switch",
        Mode::Uniaxial,
        Lateral::Held,
    );
    assert!(stretches.contains(&1.0), "{stretches:?}");
    let cosine = 29.0_f64.to_radians().cos().powi(2);
    for l in stretches {
        let strain = l.powf(-2.0 / 3.0) * (l * l * cosine + 1.0 - cosine) - 1.0;
        assert!(strain.abs() < 1e-9, "{l}: {strain}");
    }
}

/// Rubber whose stress drops where `I1` exceeds 3.5, and the law beyond the drop.
fn softening() -> [Formula; 2] {
    let law = "10*(I1-3-2*ln(J)) + 20*(J-1)^2";
    [
        format!("{law} - 0.3*macaulay(I1-3.5)"),
        format!("{law} - 0.3*(I1-3.5)"),
    ]
    .map(|text| Formula::parse(&text).expect("a formula"))
}

/// Loadings of the softening law that reach the drop of the stress.
const LOADINGS: [(Mode, Lateral); 5] = [
    (Mode::Uniaxial, Lateral::Free),
    (Mode::Uniaxial, Lateral::Held),
    (Mode::Equibiaxial, Lateral::PlaneStress),
    (Mode::Planar, Lateral::PlaneStrain),
    (Mode::SimpleShear, Lateral::Free),
];

fn with_path<T>(
    law: &dyn Hyperelastic,
    (mode, lateral): (Mode, Lateral),
    ask: impl FnOnce(&LoadingPath<'_>) -> T,
) -> T {
    let range = Range::new(0.5, 2.0).expect("a range");
    let loading = Loading { mode, lateral };
    ask(&LoadingPath::new(law, true, loading, &range).expect("a path"))
}

/// At a concave kink the stress drops along the loading: increments across it do negative work in every measure that admits them.
#[test]
fn every_criterion_on_increments_is_lost_at_a_concave_kink() {
    let [law, _] = softening();
    let law = law.with(&[]).expect("no parameters");
    with_path(&law, (Mode::Uniaxial, Lateral::Held), |path| {
        let drop = 1.5_f64.sqrt();
        for criterion in [
            Criterion::StrongEllipticity,
            Criterion::PlaneEllipticity,
            Criterion::HillRotationFree,
            Criterion::Drucker,
            Criterion::DruckerAbaqus,
            Criterion::TrueStressMonotonicity,
            Criterion::LoadMaximum,
        ] {
            let track = follow(path, criterion, true).expect("defined");
            let [lost, regained, ..] = track.events[..] else {
                panic!("{criterion:?}: {track:?}");
            };
            assert_eq!(
                (lost.change, regained.change),
                (Change::Lost, Change::Regained)
            );
            for event in [lost, regained] {
                assert!(
                    (event.stretch - drop).abs() < 1e-9,
                    "{criterion:?}: {event:?}"
                );
            }
        }
        for criterion in [Criterion::BakerEricksen, Criterion::StrongEllipticity] {
            let track = follow(path, criterion, false).expect("defined");
            assert!(track.events.is_empty(), "{criterion:?}: {track:?}");
        }
        let Some(Witness::Wave { direction, .. }) =
            follow(path, Criterion::StrongEllipticity, true)
                .and_then(|track| track.witness().copied())
        else {
            panic!("a wave");
        };
        assert!((direction[0] - 1.0).abs() < 1e-5, "{direction:?}");
    });
    let stiffening = Formula::parse("10*(I1-3-2*ln(J)) + 20*(J-1)^2 + 0.3*macaulay(I1-3.5)")
        .and_then(|law| law.with(&[]))
        .expect("a law");
    with_path(&stiffening, (Mode::Uniaxial, Lateral::Held), |path| {
        assert!(kinks(path).iter().all(|kink| !kink.is_concave));
        let track = follow(path, Criterion::StrongEllipticity, true).expect("defined");
        assert!(track.events.is_empty(), "{track:?}");
    });
}

/// With free faces the branch ends at the drop, on both sides of the reference configuration.
#[test]
fn a_drop_of_the_stress_in_shear_with_free_faces_is_not_a_step_of_the_energy() {
    let [law, _] = softening();
    let law = law.with(&[]).expect("no parameters");
    for lateral in [Lateral::Free, Lateral::PlaneStress] {
        with_path(&law, (Mode::SimpleShear, lateral), |path| {
            let found = kinks(path);
            assert_eq!(found.len(), 2, "{lateral:?}: {found:?}");
            for kink in found {
                assert_eq!(
                    kink.kind,
                    Discontinuity::JumpOfStress,
                    "{lateral:?}: {kink:?}"
                );
                assert!(kink.is_concave, "{lateral:?}: {kink:?}");
            }
        });
    }
}

/// Lowest energy gain of a jump across the drop, by Newton's method for the amplitude on the far side and a search over the normals.
fn lowest_gain(laws: [&dyn Hyperelastic; 2], f: &DeformationGradient) -> f64 {
    let [law, far] = laws;
    let here = law.response(f).expect("finite");
    let behind = |a: &Vector3<f64>, n: &Vector3<f64>| {
        let there = f.matrix() + a * n.transpose();
        let components = std::array::from_fn(|i| std::array::from_fn(|j| there[(i, j)]));
        far.response(&DeformationGradient::new(components).ok()?)
            .ok()
    };
    let gain = |n: &Vector3<f64>| {
        let mut a = Vector3::zeros();
        for _ in 0..7 {
            let response = behind(&a, n)?;
            let stiffness = Matrix3::from_fn(|i, k| {
                (0..9)
                    .map(|m| response.tangent[(i, m / 3, k, m % 3)] * n[m / 3] * n[m % 3])
                    .sum::<f64>()
            });
            let off = (response.first_piola - here.first_piola) * n;
            a -= stiffness.try_inverse()? * off;
        }
        let after = behind(&a, n)?;
        Some(after.energy - here.energy - a.dot(&(here.first_piola * n)))
    };
    let mut best = (f64::INFINITY, Vector3::x());
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    for m in 0..60 {
        let height = (f64::from(m) + 0.5) / 60.0;
        let radius = (1.0 - height * height).sqrt();
        let (sine, cosine) = (golden * f64::from(m)).sin_cos();
        let n = Vector3::new(radius * cosine, radius * sine, height);
        best = gain(&n)
            .filter(|gain| *gain < best.0)
            .map_or(best, |gain| (gain, n));
    }
    let mut size = 0.05;
    while size > 1e-7 {
        let before = best.0;
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            for step in [axis * size, axis * -size] {
                let n = (best.1 + step).normalize();
                best = gain(&n)
                    .filter(|gain| *gain < best.0)
                    .map_or(best, |gain| (gain, n));
            }
        }
        if best.0 == before {
            size *= 0.5;
        }
    }
    best.0
}

/// On the far side the law is smooth, so that Newton's method finds the best jump for each normal, without the descent of the search.
#[test]
fn jumps_across_a_drop_of_the_stress_are_found_as_soon_as_they_lower_the_energy() {
    let [law, far] = softening().map(|law| law.with(&[]).expect("no parameters"));
    for loading in LOADINGS {
        with_path(&law, loading, |path| {
            for tension in [true, false] {
                let elliptic =
                    follow(path, Criterion::StrongEllipticity, tension).expect("defined");
                let Some(limit) = follow_jumps(path, &elliptic, 2.0, tension).limit() else {
                    assert!(elliptic.limit().is_none(), "{loading:?}");
                    continue;
                };
                let drop = elliptic.limit().expect("a drop").ln();
                let gains = |s: f64| {
                    let state = path.at(s).expect("a state");
                    lowest_gain([&law, &far], &state.response.deformation) < 0.0
                };
                // Bisection for the first state from which a jump lowers the energy.
                let (mut low, mut high) = (0.9 * drop, drop - 1e-7 * drop.signum());
                assert!(!gains(low) && gains(high), "{loading:?}");
                for _ in 0..14 {
                    let middle = 0.5 * (low + high);
                    if gains(middle) {
                        high = middle
                    } else {
                        low = middle
                    }
                }
                let off = limit.ln() - high;
                assert!(off.abs() < 1e-5, "{loading:?} {tension}: {limit} {off:e}");
            }
        });
    }
}

fn changes(text: &str, loading: (Mode, Lateral), criterion: Criterion) -> Vec<(Change, f64)> {
    let law = Formula::parse(text)
        .and_then(|law| law.with(&[]))
        .expect("a law");
    with_path(&law, loading, |path| {
        let track = follow(path, criterion, true).expect("defined");
        let events = track.events.iter();
        events.map(|event| (event.change, event.stretch)).collect()
    })
}

/// Beyond the kink the criterion may fail for other reasons, and a second kink may lie where it already fails.
#[test]
fn a_criterion_is_regained_beyond_a_concave_kink_only_if_it_holds_there() {
    let smooth = "10*(I1-3-2*ln(J)) + 20*(J-1)^2";
    let held = (Mode::Uniaxial, Lateral::Held);
    let kinks = [1.5_f64.sqrt(), 3.0_f64.sqrt()];
    let twice = format!("{smooth} - 0.3*macaulay(I1-3.5) - 0.3*macaulay(I1-5)");
    let found = changes(&twice, held, Criterion::StrongEllipticity);
    let expected = [
        (Change::Lost, kinks[0]),
        (Change::Regained, kinks[0]),
        (Change::Lost, kinks[1]),
        (Change::Regained, kinks[1]),
    ];
    assert_eq!(found.len(), 4, "{found:?}");
    for ((change, stretch), (expected, place)) in found.iter().zip(expected) {
        assert_eq!(*change, expected, "{found:?}");
        assert!((stretch - place).abs() < 1e-9, "{found:?}");
    }
    // Between the kinks the criterion fails by itself, and is not regained at the second one.
    let found = changes(&twice, held, Criterion::HillRotationFree);
    let lost: Vec<Change> = found.iter().map(|(change, _)| *change).collect();
    assert_eq!(
        lost,
        [Change::Lost, Change::Regained, Change::Lost],
        "{found:?}"
    );
    let softer = format!("{smooth} - 0.3*macaulay(I1-3.5) - 20*macaulay(I1-3.5)^2");
    let found = changes(&softer, held, Criterion::StrongEllipticity);
    assert_eq!(found[0].0, Change::Lost, "{found:?}");
    assert!(
        found.len() == 1 || found[1].1 > kinks[0] + 1e-6,
        "{found:?}"
    );
}

/// The states of a sheared incompressible sheet are known on both sides of the kink.
#[test]
fn incompressible_shear_passes_a_concave_kink() {
    let [law, _] = softening();
    let law = law.with(&[]).expect("no parameters");
    let loading = Loading {
        mode: Mode::SimpleShear,
        lateral: Lateral::PlaneStress,
    };
    let range = Range::new(0.5, 2.0).expect("a range");
    let path = LoadingPath::incompressible(&law, loading, &range).expect("a path");
    assert_eq!(path.tension_end, PathEnd::Range);
    let found = kinks(&path);
    assert!(
        found.len() == 2 && found.iter().all(|kink| kink.is_concave),
        "{found:?}"
    );
    let track = follow(&path, Criterion::StrongEllipticity, true).expect("defined");
    // I1 = 3 + gamma^2.
    let gamma = Mode::SimpleShear.imposed(track.limit().expect("a limit").ln());
    assert!((gamma - 0.5_f64.sqrt()).abs() < 1e-9, "{gamma}");
}

/// `P_33 = mu (t - 1/t) + kappa ln(J)/t - 2 b macaulay(I1 - 4) t`: the stress is continuous at `I1 = l^2 + 2 t^2 = 4`, and its slope drops there, so that the
/// free stretch `t` continues only with smaller `l`.
#[test]
fn a_path_turns_back_at_a_kink_of_the_stress() {
    let energy = "(I1 - 3 - 2*ln(J))/2 + ln(J)^2/2 - b*macaulay(I1 - 4)^2/2";
    let loading = Loading {
        mode: Mode::Uniaxial,
        lateral: Lateral::Free,
    };
    for b in [1.0, 2.0, 5.0, 20.0] {
        let law = Formula::parse(energy).expect("a formula");
        let law = law.with(&[("b", b)]).expect("a law");
        let path = LoadingPath::new(&law, true, loading, &Range::default()).expect("a path");
        let PathEnd::Fold { stretch } = path.tension_end else {
            panic!("{b}: {:?}", path.tension_end);
        };
        let last = path.tension.last().expect("a state").response.deformation;
        let i1 = last.invariants().first;
        assert!((i1 - 4.0).abs() < 1e-9, "{b}: {i1}");
        let found = kinks(&path);
        let here = found
            .iter()
            .find(|kink| (kink.stretch - stretch).abs() < 1e-9);
        let here = here.expect("a kink");
        assert_eq!(here.kind, Discontinuity::KinkOfStress);
        assert!(
            !here.is_concave && here.largest_stress.abs() < 1e-6,
            "{here:?}"
        );
        let load = follow(&path, Criterion::LoadMaximum, true).expect("defined");
        assert_eq!(load.limit(), None, "the load rises up to the fold");
    }
}

/// In uniaxial strain a jump `(0.8 - x) e_1 (x) e_1` crosses the step at `J = 0.8` and gains 0.3. With the energy `w(x)` without the step it lowers the
/// energy from the largest `x` with `w(0.8) - 0.3 < w(x) + w'(x) (0.8 - x)`; other jumps may lower it earlier.
#[test]
fn a_jump_across_a_step_of_the_energy_is_found_before_the_step() {
    let law = Formula::parse("10*(I1-3-2*ln(J)) + 20*(J-1)^2 - 0.3*(1-heaviside(J-0.8))");
    let law = law.and_then(|law| law.with(&[])).expect("a law");
    let held = path(&law, Mode::Uniaxial, Lateral::Held);
    let elliptic = track(&held, Criterion::StrongEllipticity, false);
    let limit = follow_jumps(&held, &elliptic, 10.0, false).limit();
    let w = |x: f64| 10.0 * (x * x - 1.0 - 2.0 * x.ln()) + 20.0 * (x - 1.0).powi(2);
    let slope = |x: f64| 20.0 * (x - 1.0 / x) + 40.0 * (x - 1.0);
    let gained = |x: f64| w(0.8) - 0.3 - w(x) - slope(x) * (0.8 - x);
    let along_one_axis = zero(gained, 0.81, 0.99);
    assert!((along_one_axis - 0.8829).abs() < 1e-4, "{along_one_axis}");
    let limit = limit.expect("lost");
    assert!((0.87..1.0).contains(&limit), "{limit}");
}
