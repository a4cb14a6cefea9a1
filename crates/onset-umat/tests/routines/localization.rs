//! Routines along loading paths, compared with the same laws in rate form and with closed forms of localization.

use crate::{blatz_ko, settings};
use onset::plasticity::{
    Bands, DruckerPrager, End, Hardening, Load, Loading, LoadingPath, Localization,
    PlasticityError, Strains, follow, follow_increments,
};
use onset_umat::{Umat, UmatSettings};

const SHEAR: f64 = 10e3;
const POISSON: f64 = 0.2;
const BULK: f64 = 2.0 * SHEAR * (1.0 + POISSON) / (3.0 * (1.0 - 2.0 * POISSON));
const STRENGTH: Hardening = Hardening::Peak {
    initial: 20.0,
    residual: 10.0,
    modulus: 2000.0,
    reference: 0.05,
};

fn sandstone(friction: f64, dilatancy: f64) -> (DruckerPrager, Umat) {
    let law = DruckerPrager::new(SHEAR, POISSON, friction, dilatancy, STRENGTH).expect("a law");
    let properties = [SHEAR, BULK, friction, dilatancy, 20.0, 10.0, 2000.0, 0.05];
    let umat = Umat::new(UmatSettings {
        state_variables: 1,
        ..settings(&["fortran/drucker_prager.f90"], &properties)
    });
    (law, umat.expect("a UMAT"))
}

fn loading(path: LoadingPath, load: Load) -> Loading {
    Loading {
        path,
        load,
        strains: Strains::Small,
        bands: Bands::Bulk,
        confinement: 0.0,
        strain_ratio: 0.0,
        slip: 0.1,
    }
}

fn followed(umat: &Umat, loading: &Loading, increments: usize) -> Localization {
    follow_increments(umat, loading, increments).expect("a path")
}

/// Onset and end of a path converge to the rate equations with the number of increments: implicit steps have a first-order error.
#[test]
fn a_routine_localizes_where_its_law_in_rate_form_does() {
    let (law, umat) = sandstone(0.6, 0.2);
    for (path, load, confinement) in [
        (LoadingPath::PlaneStrain, Load::Compression, 0.0),
        (LoadingPath::PlaneStrain, Load::Compression, 15.0),
        (LoadingPath::SheetStretch, Load::Tension, 0.0),
        (LoadingPath::PureShear, Load::Compression, 0.0),
    ] {
        let loading = Loading {
            confinement,
            ..loading(path, load)
        };
        let exact = follow(&law, &loading).expect("a path");
        let [coarse, fine] = [30, 60].map(|count| followed(&umat, &loading, count));
        let first = |found: &Localization| found.points[0];
        for i in 0..3 {
            let (own, other) = (first(&fine), first(&exact));
            assert!(
                (own.stress[i] - other.stress[i]).abs() < 1e-7 * 20.0,
                "{path:?}"
            );
        }
        // At first yield only the extrapolated tangents distinguish plastic flow from elasticity.
        let moduli = |found: &Localization| {
            let point = first(found);
            [
                point.modulus,
                point.ellipticity.modulus,
                point.strong_ellipticity.modulus,
            ]
        };
        for (own, other) in moduli(&fine).into_iter().zip(moduli(&exact)) {
            assert!(
                (own - other).abs() < 1e-5 * SHEAR,
                "{path:?}: {own} for {other}"
            );
        }
        let onset = |found: &Localization| found.onset.expect("a band");
        let error = |found: &Localization| (onset(found).slip - onset(&exact).slip).abs();
        assert!(
            error(&fine) < 0.02 * onset(&exact).slip && error(&fine) < 0.7 * error(&coarse) + 1e-6,
            "{path:?}: {} and {} of {}",
            error(&coarse),
            error(&fine),
            onset(&exact).slip
        );
        let (own, other) = (onset(&fine).ellipticity, onset(&exact).ellipticity);
        assert_eq!(own.band.kind, other.band.kind);
        assert!((own.band.angle_to_major - other.band.angle_to_major).abs() < 0.5);
        assert!((own.modulus - other.modulus).abs() < 0.01 * SHEAR.min(2000.0));
    }
}

/// Rudnicki and Rice (1975), triaxial compression: the stress keeps its direction, so that implicit steps and their tangents are exact.
#[test]
fn a_routine_in_triaxial_compression_has_the_critical_modulus_of_rudnicki_and_rice() {
    let (friction, dilatancy) = (0.9, 0.3);
    let (_, umat) = sandstone(friction, dilatancy);
    let loading = loading(LoadingPath::TriaxialCompression, Load::Compression);
    let found = followed(&umat, &loading, 40);
    let n = 1.0 / 3.0_f64.sqrt();
    let nu = POISSON;
    let sum = friction + dilatancy;
    let formula = SHEAR
        * ((1.0 + nu) / (9.0 * (1.0 - nu)) * (dilatancy - friction).powi(2)
            - 0.5 * (1.0 + nu) * (n + sum / 3.0).powi(2));
    for point in &found.points {
        let own = point.ellipticity.modulus;
        assert!((own - formula).abs() < 1e-5 * SHEAR, "{own} for {formula}");
    }
    // The slip integrated from the tangents agrees with the slip from the strength.
    for point in &found.points {
        let left = point.equivalent_shear() + friction * point.mean_stress();
        let strength = STRENGTH.strength(point.slip);
        assert!(
            (left - strength).abs() < 0.01 * strength,
            "{left} for {strength}"
        );
    }
}

/// Hill's neck in a sheet with linear hardening under tension: the slope of the flow stress is half of the stress, to the order of elastic strains.
#[test]
fn a_sheet_of_a_routine_necks_at_the_criterion_of_hill() {
    let (young, poisson, yield_stress, slope) = (200e3, 0.3, 250.0, 400.0);
    let umat = Umat::new(UmatSettings {
        state_variables: 1,
        ..settings(
            &["fortran/j2_plasticity.f90"],
            &[young, poisson, yield_stress, slope],
        )
    });
    let loading = Loading {
        strains: Strains::Finite,
        bands: Bands::Sheet,
        slip: 2.5,
        ..loading(LoadingPath::UniaxialStress, Load::Tension)
    };
    let found = followed(&umat.expect("a UMAT"), &loading, 40);
    let onset = found.onset.expect("a neck");
    assert!(
        (onset.stress[0] / (2.0 * slope) - 1.0).abs() < 0.01,
        "{}",
        onset.stress[0]
    );
    // The normal of Hill's neck is at atan(1/sqrt(2)) to the tensile axis.
    assert!((onset.ellipticity.band.angle_to_major - 35.264).abs() < 0.3);
    // The slip is the plastic shear strain, sqrt(3) times the plastic strain in tension.
    let plastic = (onset.stress[0] - yield_stress) / slope;
    assert!((onset.slip / (3.0_f64.sqrt() * plastic) - 1.0).abs() < 0.01);
}

#[test]
fn paths_that_cannot_be_followed_are_reported() {
    let pull = loading(LoadingPath::UniaxialStress, Load::Tension);
    let elastic = follow_increments(&blatz_ko(), &pull, 10);
    assert!(matches!(
        elastic,
        Err(PlasticityError::NeverYields { .. } | PlasticityError::NoBalance)
    ));
    let crystal = Umat::new(UmatSettings {
        state_variables: 1,
        ..settings(&["fortran/single_slip.f90"], &[26.0, 50.0, 0.1, 0.0, 35.0])
    });
    let turned = follow_increments(&crystal.expect("a UMAT"), &pull, 10);
    assert_eq!(turned.err(), Some(PlasticityError::NotAlongAxes));
    // Under all-round tension the routine cannot return to the apex of its cone.
    let (_, umat) = sandstone(0.6, 0.2);
    let pulled = loading(LoadingPath::UniaxialStrain, Load::Tension);
    match follow_increments(&umat, &pulled, 20) {
        Ok(found) => assert!(found.end != End::Slip, "{:?}", found.end),
        Err(error) => assert!(
            matches!(
                error,
                PlasticityError::NeverYields { .. }
                    | PlasticityError::NoBalance
                    | PlasticityError::Apex
            ),
            "{error:?}"
        ),
    }
}
