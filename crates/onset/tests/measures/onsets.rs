//! Onsets along loadings, which must equal those along paths.

use crate::{method, nodal};
use onset::kinematics::StraightPath;
use onset::lattice::LatticeKind;
use onset::material::ModifiedMooneyRivlin;
use onset::measures::{Load, OnsetPair, StretchOnset, onset};
use onset::method::{Frame, KernelMethodChoices};
use onset::quadrature::Quadrature;
use onset::verdict::{PathScan, Survey, scan_discretization, scan_material};

/// First loss of stability along a scanned path from stretch 1 to `end`.
fn first(scan: &PathScan, end: f64) -> Option<f64> {
    scan.crossings
        .first()
        .map(|crossing| 1.0 + (end - 1.0) * crossing.parameter())
}

#[track_caller]
fn assert_same(found: StretchOnset, expected: Option<f64>) {
    match (found, expected) {
        (StretchOnset::At(stretch), Some(expected)) => {
            assert!(
                (stretch - expected).abs() < 1e-9,
                "{stretch} for {expected}"
            );
        }
        (StretchOnset::NotBefore(_), None) => {}
        other => panic!("{other:?}"),
    }
}

#[test]
fn onsets_agree_with_a_scan_of_the_path() {
    let material = ModifiedMooneyRivlin::default();
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        let method = method::<2>(KernelMethodChoices {
            frame,
            quadrature: Quadrature::StressPoints,
            ..nodal(LatticeKind::Hexagonal)
        });
        let survey = Survey::new(&method, &material).expect("a survey");
        for (load, end) in [
            (Load::UniaxialStrainTension, 3.0),
            (Load::EquibiaxialStrainTension, 2.0),
        ] {
            let found = onset(&survey, load, end).expect("onsets");
            let ends = [1.0, end].map(|stretch| load.at(stretch).expect("a state"));
            let path = StraightPath::new(ends[0], ends[1]).expect("a path");
            let of_material = scan_material::<2>(&material, &path).expect("a scan");
            let of_method = scan_discretization(&survey, &path).expect("a scan");
            assert_same(found.material, first(&of_material, end));
            assert_same(found.method, first(&of_method, end));
        }
    }
}

#[test]
fn onsets_of_a_faithful_method_and_its_material_have_the_ratio_one() {
    let material = ModifiedMooneyRivlin::default();
    let method = method::<2>(KernelMethodChoices {
        quadrature: Quadrature::StressPoints,
        ..nodal(LatticeKind::Hexagonal)
    });
    let survey = Survey::new(&method, &material).expect("a survey");
    for load in Load::ALL {
        let end = if load.is_tension() { 3.0 } else { 0.4 };
        let found = onset(&survey, load, end).expect("onsets");
        assert!((found.ratio() - 1.0).abs() < 1e-6, "{found:?}");
    }
}

#[test]
fn the_ratio_of_onsets_without_strain_is_one_or_unknown() {
    let pair = |material, method| OnsetPair {
        load: Load::UniaxialStrainTension,
        material,
        method,
    };
    let at = StretchOnset::At;
    assert_eq!(pair(at(1.0), at(1.0)).ratio(), 1.0);
    assert_eq!(
        pair(StretchOnset::AtRest, StretchOnset::AtRest).ratio(),
        1.0
    );
    assert!(pair(at(1.0), at(1.2)).ratio().is_nan());
    assert_eq!(pair(at(1.2), at(1.0)).ratio(), 0.0);
}
