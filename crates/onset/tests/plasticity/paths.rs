//! Loading paths compared with the return mapping, closed forms and the prescribed equations.

use crate::{STRENGTHS, law};
use nalgebra::{Matrix3, Vector3};
use onset::kinematics::DeformationGradient;
use onset::plasticity::{
    BandKind, Bands, DruckerPrager, End, FiniteState, Hardening, Load, Loading, LoadingPath,
    Localization, PlasticityError, State, Strains, follow,
};

const PEAK: Hardening = STRENGTHS[5];

fn loading(path: LoadingPath) -> Loading {
    Loading {
        path,
        load: Load::Compression,
        strains: Strains::Small,
        bands: Bands::Bulk,
        confinement: 0.0,
        strain_ratio: 0.0,
        slip: 0.1,
    }
}

fn followed(law: &DruckerPrager, loading: &Loading) -> Localization {
    follow(law, loading).expect("a path")
}

#[test]
fn return_mapping_converges_to_the_path_as_its_steps_shrink() {
    // Strain paths: the final strain in equal steps from first yield on, with the return mapping.
    for (path, friction, dilatancy) in [
        (LoadingPath::PureShear, 0.6, 0.2),
        (LoadingPath::UniaxialStrain, 0.3, 0.1),
    ] {
        for strains in [Strains::Small, Strains::Finite] {
            let law = law(friction, dilatancy, STRENGTHS[2]);
            let loading = Loading {
                strains,
                slip: 0.03,
                ..loading(path)
            };
            let found = followed(&law, &loading);
            let end = found.points.last().expect("an end");
            assert_eq!(found.end, End::Slip);
            let stepped = |count: u32| {
                let (mut small, mut finite) = (State::default(), FiniteState::default());
                let mut stress = Matrix3::zeros();
                for n in 1..=count {
                    let strain = Vector3::from(end.strain) * f64::from(n) / f64::from(count);
                    if strains == Strains::Small {
                        let update = law.update(&Matrix3::from_diagonal(&strain), &small);
                        let update = update.expect("a stress");
                        (stress, small) = (update.stress, update.state);
                    } else {
                        let f = DeformationGradient::from_stretches(strain.map(f64::exp).into());
                        let update = law.finite_update(&f.expect("a deformation"), &finite);
                        let update = update.expect("a stress");
                        (stress, finite) = (update.cauchy(), update.state);
                    }
                }
                stress.diagonal() - Vector3::from(end.stress)
            };
            let (coarse, fine) = (stepped(500), stepped(1000));
            assert!(fine.norm() < 2e-3, "{path:?} {strains:?}: {fine}");
            assert!(
                (fine * 2.0 - coarse).norm() < 0.05 * coarse.norm() + 1e-9,
                "{path:?} {strains:?}: {coarse} {fine}"
            );
        }
    }
}

#[test]
fn every_state_of_a_path_satisfies_its_prescription_and_the_yield_condition() {
    for path in [
        LoadingPath::UniaxialStress,
        LoadingPath::UniaxialStrain,
        LoadingPath::PlaneStrain,
        LoadingPath::PureShear,
        LoadingPath::TriaxialCompression,
        LoadingPath::SheetStretch,
    ] {
        for strains in [Strains::Small, Strains::Finite] {
            for confinement in [0.0, 0.8] {
                let law = law(0.3, 0.2, PEAK);
                let loading = Loading {
                    strains,
                    confinement,
                    strain_ratio: 0.4,
                    ..loading(path)
                };
                for point in followed(&law, &loading).points {
                    let [e1, e2, e3] = point.strain;
                    let [_, s2, s3] = point.stress;
                    let constant = |stress: f64| (stress + confinement).abs() < 1e-9;
                    let none = |strain: f64| strain.abs() < 1e-12;
                    assert!(e1 < 0.0);
                    assert!(match path {
                        LoadingPath::UniaxialStress | LoadingPath::TriaxialCompression =>
                            constant(s2) && constant(s3),
                        LoadingPath::UniaxialStrain => none(e2) && none(e3),
                        LoadingPath::PlaneStrain => constant(s2) && none(e3),
                        LoadingPath::PureShear => none(e1 + e2) && none(e3),
                        LoadingPath::SheetStretch => none(e2 - 0.4 * e1) && constant(s3),
                    });
                    let initial = if confinement > 0.0 {
                        3.0 * initial(&law, &loading)
                    } else {
                        0.0
                    };
                    let volume = match strains {
                        Strains::Small => 1.0,
                        Strains::Finite => (e1 + e2 + e3 + initial).exp(),
                    };
                    let stress = Matrix3::from_diagonal(&Vector3::from(point.stress)) * volume;
                    assert!(law.yield_function(&stress, point.slip).abs() < 1e-9);
                }
            }
        }
    }
}

/// Strain of the confined state along an axis.
fn initial(law: &DruckerPrager, loading: &Loading) -> f64 {
    let bulk = 3.0 * law.bulk_modulus();
    let mut strain = 0.0_f64;
    for _ in 0..200 {
        strain = -loading.confinement * (3.0 * strain).exp() / bulk;
    }
    strain
}

#[test]
fn von_mises_in_pure_shear_localizes_where_hardening_ends() {
    let metal = law(0.0, 0.0, PEAK);
    let found = followed(&metal, &loading(LoadingPath::PureShear));
    let onset = found.onset.expect("an onset");
    // h = (m - (k0 - kr + m g)/r) exp(-g/r) vanishes at g = r - (k0 - kr)/m.
    assert!(
        (onset.slip - (0.02 - 0.5 / 60.0)).abs() < 1e-10,
        "{}",
        onset.slip
    );
    assert_eq!(onset.ellipticity.band.kind, BandKind::ShearBand);
    assert!((onset.ellipticity.band.angle_to_major - 45.0).abs() < 1e-6);
    let strong = found.strong_ellipticity_lost.expect("an onset");
    assert!((strong.slip - onset.slip).abs() < 1e-10);
}

#[test]
fn von_mises_in_plane_strain_approaches_the_state_of_shear_where_the_critical_modulus_is_zero() {
    let metal = law(0.0, 0.0, STRENGTHS[2]);
    let long = Loading {
        slip: 0.5,
        ..loading(LoadingPath::PlaneStrain)
    };
    let found = followed(&metal, &long);
    let (first, last) = (found.points[0], found.points[200]);
    assert!(first.ellipticity.modulus < -1.0);
    assert!(
        last.ellipticity.modulus.abs() < 1e-6,
        "{}",
        last.ellipticity.modulus
    );
    assert!(found.onset.is_none());
}

#[test]
fn triaxial_compression_localizes_at_the_modulus_of_rudnicki_and_rice() {
    // The direction of stress is constant, so the critical modulus is one number: N = 1/sqrt(3).
    for (mu, beta) in [(0.6_f64, 0.2_f64), (0.4, 0.4), (0.7, -0.1)] {
        let rock = law(mu, beta, PEAK);
        let loading = Loading {
            confinement: 0.5,
            ..loading(LoadingPath::TriaxialCompression)
        };
        let found = followed(&rock, &loading);
        let (nu, n) = (0.25_f64, 1.0 / 3.0_f64.sqrt());
        let critical = (1.0 + nu) / (9.0 * (1.0 - nu)) * (beta - mu).powi(2)
            - 0.5 * (1.0 + nu) * (n + (beta + mu) / 3.0).powi(2);
        for point in &found.points {
            assert!((point.ellipticity.modulus / 100.0 - critical).abs() < 1e-11);
        }
        let lowest = PEAK.lowest_modulus();
        assert_eq!(found.onset.is_some(), lowest < 100.0 * critical);
    }
}

#[test]
fn non_associated_flow_localizes_while_the_material_still_hardens() {
    let slow = Hardening::Peak {
        initial: 1.0,
        residual: 0.5,
        modulus: 20.0,
        reference: 0.2,
    };
    let long = Loading {
        slip: 0.5,
        ..loading(LoadingPath::PlaneStrain)
    };
    let found = followed(&law(0.7, 0.1, slow), &long);
    let onset = found.onset.expect("an onset");
    assert!(onset.modulus > 0.0, "{}", onset.modulus);
    assert!((onset.modulus - onset.ellipticity.modulus).abs() < 1e-9);
    let strong = found.strong_ellipticity_lost.expect("an onset");
    assert!(strong.slip < onset.slip);
}

#[test]
fn the_onset_at_finite_strain_tends_to_the_small_strain_onset_for_low_strength() {
    let onset = |size: f64, strains: Strains| {
        let strength = Hardening::Peak {
            initial: size,
            residual: 0.5 * size,
            modulus: 40.0,
            reference: 0.02 * size,
        };
        let loading = Loading {
            strains,
            slip: 0.1 * size,
            ..loading(LoadingPath::PlaneStrain)
        };
        let onset = followed(&law(0.7, 0.1, strength), &loading).onset;
        onset.expect("an onset").slip / size
    };
    let gap = |size| (onset(size, Strains::Finite) - onset(size, Strains::Small)).abs();
    assert!(gap(0.1) < 2e-4, "{}", gap(0.1));
    assert!(
        (gap(0.1) / gap(0.01) - 10.0).abs() < 1.0,
        "{} {}",
        gap(0.1),
        gap(0.01)
    );
}

#[test]
fn a_sheet_in_tension_necks_at_zero_hardening_and_in_hills_direction() {
    let metal = law(0.0, 0.0, PEAK);
    let loading = Loading {
        load: Load::Tension,
        bands: Bands::Sheet,
        ..loading(LoadingPath::UniaxialStress)
    };
    let onset = followed(&metal, &loading).onset.expect("a neck");
    assert!((onset.slip - (0.02 - 0.5 / 60.0)).abs() < 1e-10);
    let inclination = 90.0 - onset.ellipticity.band.angle_to_major;
    assert!(
        (inclination - 54.735610317245346).abs() < 1e-5,
        "{inclination}"
    );
    // At finite strain the stress itself thins the neck while the material still hardens.
    let finite = Loading {
        strains: Strains::Finite,
        ..loading
    };
    let onset = followed(&metal, &finite).onset.expect("a neck");
    assert!(onset.modulus > 0.1, "{}", onset.modulus);
}

#[test]
fn the_onset_of_a_stiff_material_is_independent_of_the_length_of_the_path() {
    let onset = |slip: f64| {
        let rock = DruckerPrager::new(1e4, 0.25, 0.7, 0.1, PEAK).expect("a law");
        let loading = Loading {
            slip,
            ..loading(LoadingPath::PlaneStrain)
        };
        let found = followed(&rock, &loading);
        (found.onset.expect("an onset").slip, found.end)
    };
    let (short, long) = (onset(0.02), onset(2.0));
    assert!((short.0 - long.0).abs() < 1e-9, "{short:?} {long:?}");
    assert_eq!((short.1, long.1), (End::Slip, End::Slip));
}

#[test]
fn paths_that_cannot_be_followed_report_the_reason() {
    let rock = law(0.6, 0.2, PEAK);
    let plane_strain = loading(LoadingPath::PlaneStrain);
    let sheet = Loading {
        bands: Bands::Sheet,
        ..plane_strain
    };
    assert_eq!(follow(&rock, &sheet), Err(PlasticityError::NotASheet));
    let steep = law(1.8, 0.2, PEAK);
    assert!(matches!(
        follow(&steep, &loading(LoadingPath::UniaxialStrain)),
        Err(PlasticityError::NeverYields { .. })
    ));
    let soft = DruckerPrager::new(1e12, 0.25, 0.6, 0.2, PEAK).expect("a law");
    assert!(matches!(
        follow(&soft, &plane_strain),
        Err(PlasticityError::Parameter {
            name: "strength",
            ..
        })
    ));
    let negative = Loading {
        confinement: -3.0,
        ..plane_strain
    };
    assert!(matches!(
        follow(&rock, &negative),
        Err(PlasticityError::Parameter { .. })
    ));
    let softening = law(0.0, 0.0, STRENGTHS[1]);
    let far = Loading {
        slip: 1.0,
        ..loading(LoadingPath::PureShear)
    };
    let found = followed(&softening, &far);
    assert_eq!(found.end, End::Exhausted);
    assert!(found.points.iter().all(|point| point.slip < 0.2));
}
