//! Crystals: the elastic constants of small strains applied to Green's strain, so that rotations have no energy.
//!
//! `W = 1/2 E : C : E`, with constants along crystal axes that are rotated by an angle about the third axis. To first order in the strain it is the
//! linear elasticity of the crystal; third-order constants are not included.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed};
use super::super::{MaterialError, SmallStrainStiffness, StrainEnergy};
use super::quadratic::{QuadraticForm, is_positive, orthotropic, turned};
use crate::kinematics::DeformationGradient;
use crate::real::Real;

const MEANING: &str = "elastic constant along the crystal's axes";

const fn constant(name: &'static str, default: f64) -> Parameter {
    Parameter::new(name, "stress", default, Admitted::Any, MEANING)
}

const ANGLE: Parameter = Parameter::new(
    "angle",
    "deg",
    0.0,
    Admitted::Any,
    "angle from axis 1 to the crystal's axis 1, about axis 3",
);

pub(in super::super) const CUBIC: Law = Law {
    name: "cubic-crystal",
    formula: "W = c11/2 (E11^2 + E22^2 + E33^2) + c12 (E11 E22 + E11 E33 + E22 E33) + 2 c44 (E12^2 + E13^2 + E23^2), E = (C - 1)/2",
    parameters: &[
        constant("c11", 168.4),
        constant("c12", 121.4),
        constant("c44", 75.4),
        ANGLE,
    ],
    domain: "all states; accurate for large rotations and small strains; c11 > |c12|, c11 + 2 c12 > 0, c44 > 0",
    symmetry: Symmetry::Cubic,
    stressed_reference: None,
    small_strains: "elastic constants c11, c12 and c44",
    source: "Nye, Physical Properties of Crystals (1957); copper, GPa: Overton and Gaffney, Phys. Rev. 98 (1955) 969",
    stiffness: |p| turned(&cubic(p), p[3]),
    make: |p| {
        MaterialError::positive("c44", p[2])?;
        MaterialError::positive("c11 - c12", p[0] - p[1])?;
        MaterialError::positive("c11 + 2 c12", p[0] + 2.0 * p[1])?;
        boxed(Ok(Crystal(QuadraticForm::new(cubic(p), p[3]))))
    },
};

pub(in super::super) const ORTHOTROPIC: Law = Law {
    name: "orthotropic-crystal",
    formula: "W = 1/2 (c11 E11^2 + c22 E22^2 + c33 E33^2) + c12 E11 E22 + c13 E11 E33 + c23 E22 E33 + 2 (c44 E23^2 + c55 E13^2 + c66 E12^2), \
              E = (C - 1)/2",
    parameters: &[
        constant("c11", 214.74),
        constant("c22", 198.57),
        constant("c33", 267.11),
        constant("c23", 107.91),
        constant("c13", 21.77),
        constant("c12", 46.49),
        constant("c44", 124.44),
        constant("c55", 73.42),
        constant("c66", 74.33),
        ANGLE,
    ],
    domain: "all states; accurate for large rotations and small strains, with positive definite constants",
    symmetry: Symmetry::Orthotropic,
    stressed_reference: None,
    small_strains: "elastic constants c11, c22, ..., c66",
    source: "Nye, Physical Properties of Crystals (1957); alpha uranium, GPa: Fisher and McSkimin, J. Appl. Phys. 29 (1958) 1473",
    stiffness: |p| turned(&general(p), p[9]),
    make: |p| {
        let constants = general(p);
        if !is_positive(&constants) {
            return Err(MaterialError::Parameter {
                name: "c11",
                value: p[0],
                expected: "elastic constants that form a positive definite stiffness, so that every strain has positive energy".to_owned(),
            });
        }
        boxed(Ok(Crystal(QuadraticForm::new(constants, p[9]))))
    },
};

fn cubic(p: &[f64]) -> SmallStrainStiffness {
    orthotropic(&[p[0], p[0], p[0], p[1], p[1], p[1]], &[p[2]; 3])
}

fn general(p: &[f64]) -> SmallStrainStiffness {
    orthotropic(&[p[0], p[1], p[2], p[3], p[4], p[5]], &[p[6], p[7], p[8]])
}

struct Crystal(QuadraticForm);

impl StrainEnergy for Crystal {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        self.0.of(f)
    }
}
