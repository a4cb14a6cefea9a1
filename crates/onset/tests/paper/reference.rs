//! Reference numbers of `validation/anchors.json`, and the methods named by their keys.

use onset::approximation::Approximation;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{
    CurrentLattice, Frame, KernelMethodChoices, Linearization, Method, SupportSize,
};
use onset::quadrature::Quadrature;
use serde_json::Value;

/// Reference numbers by name.
pub fn anchors() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/anchors.json");
    let text = std::fs::read_to_string(path).expect("the reference numbers can be read");
    serde_json::from_str(&text).expect("the reference numbers are JSON")
}

/// Asserts that a number agrees within a relative tolerance, or an absolute one if the reference is zero. References below 1e-13 are the rounding
/// errors of zeros.
#[track_caller]
pub fn assert_meets(what: &str, computed: f64, reference: f64, tolerance: f64) {
    let error = (computed - reference).abs();
    let scale = if reference.abs() < 1e-13 {
        1.0
    } else {
        reference.abs()
    };
    assert!(
        error <= tolerance * scale,
        "{what}: computed {computed:e}, reference {reference:e}"
    );
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .expect("a list")
        .iter()
        .map(|x| x.as_f64().expect("a number"))
        .collect()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Material with the name `mooney`, `blatzko1` or `blatzko32`.
pub fn material(name: &str) -> Box<dyn Hyperelastic> {
    match name {
        "mooney" => Box::new(ModifiedMooneyRivlin::default()),
        "blatzko1" => Box::new(BlatzKo::new(1.0).expect("a positive modulus")),
        "blatzko32" => Box::new(BlatzKo::new(32.0).expect("a positive modulus")),
        _ => panic!("unknown material {name}"),
    }
}

/// Lagrangian discretization from the words `hex` or `square`, `nodal` or `sp`.
pub fn lagrangian(kind: &str, quadrature: &str, support: f64) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: match kind {
            "hex" => LatticeKind::Hexagonal,
            "square" => LatticeKind::Square,
            _ => panic!("unknown lattice {kind}"),
        },
        quadrature: match quadrature {
            "nodal" => Quadrature::Nodal,
            "sp" => Quadrature::StressPoints,
            _ => panic!("unknown quadrature {quadrature}"),
        },
        support,
        ..KernelMethodChoices::default()
    }
}

/// Discretization from the words `lagrange`, `lagrange_mls`, or `euler` with geometry (`fixed-stretched`, ...) and linearization.
pub fn with_frame(
    base: KernelMethodChoices,
    frame: &str,
    geometry: &str,
    linearization: &str,
) -> KernelMethodChoices {
    match frame {
        "lagrange" => base,
        "lagrange_mls" => KernelMethodChoices {
            approximation: Approximation::Mls,
            ..base
        },
        "euler" => {
            let (support_size, lattice) = match geometry {
                "fixed-stretched" | "stretched" => (SupportSize::Fixed, CurrentLattice::Convected),
                "sqrtJ-stretched" => (SupportSize::Scaled, CurrentLattice::Convected),
                "elliptic-stretched" => (SupportSize::Convected, CurrentLattice::Convected),
                "fixed-regular" | "regular" => (SupportSize::Fixed, CurrentLattice::Regular),
                _ => panic!("unknown geometry {geometry}"),
            };
            let linearization = match linearization {
                "paper" => Linearization::Paper,
                "exact" => Linearization::Exact,
                "paper_interp" => Linearization::PaperInterpolated,
                "exact_pw" => Linearization::ExactPlaneWave,
                "frozenS" => Linearization::FrozenNormalization,
                _ => panic!("unknown linearization {linearization}"),
            };
            KernelMethodChoices {
                frame: Frame::Eulerian,
                support_size,
                current_lattice: lattice,
                linearization,
                ..base
            }
        }
        _ => panic!("unknown frame {frame}"),
    }
}

pub fn method(discretization: KernelMethodChoices) -> Method<2> {
    Method::new(discretization).expect("an admissible method")
}

pub fn stretched(l1: f64, l2: f64) -> DeformationGradient {
    DeformationGradient::from_stretches([l1, l2, 1.0]).expect("positive stretches")
}
