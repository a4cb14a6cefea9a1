//! Orthotropic Saint-Venant law: quadratic in Green's strain, in engineering constants.
//!
//! `W = 1/2 E : C : E` with `C^-1` from Young's moduli, Poisson's ratios and shear moduli along material axes, which are rotated by an angle about
//! the third axis.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed};
use super::super::{MaterialError, SmallStrainStiffness, StrainEnergy};
use super::quadratic::{QuadraticForm, is_positive, orthotropic, turned};
use crate::algebra::Each;
use crate::kinematics::DeformationGradient;
use crate::real::Real;

const fn young(name: &'static str, default: f64, meaning: &'static str) -> Parameter {
    Parameter::new(name, "stress", default, Admitted::Positive, meaning)
}

const fn poisson(name: &'static str, default: f64, meaning: &'static str) -> Parameter {
    Parameter::new(name, "1", default, Admitted::Any, meaning)
}

pub(in super::super) const LAW: Law = Law {
    name: "saint-venant-orthotropic",
    formula: "W = 1/2 E : C : E, E = (C - 1)/2, C from young1, nu12 = -E22/E11 under tension along axis 1, ..., shear12, ...",
    parameters: &[
        young("young1", 140.0, "Young's modulus along material axis 1"),
        young("young2", 10.0, "Young's modulus along material axis 2"),
        young("young3", 10.0, "Young's modulus along material axis 3"),
        poisson(
            "nu12",
            0.3,
            "contraction along axis 2 under tension along axis 1",
        ),
        poisson(
            "nu13",
            0.3,
            "contraction along axis 3 under tension along axis 1",
        ),
        poisson(
            "nu23",
            0.4,
            "contraction along axis 3 under tension along axis 2",
        ),
        young("shear12", 5.0, "shear modulus in the plane of axes 1 and 2"),
        young("shear13", 5.0, "shear modulus in the plane of axes 1 and 3"),
        young("shear23", 3.5, "shear modulus in the plane of axes 2 and 3"),
        Parameter::new(
            "angle",
            "deg",
            0.0,
            Admitted::Any,
            "angle from axis 1 to the material's axis 1, about axis 3",
        ),
    ],
    domain: "all states; accurate for large rotations and small strains, with a positive definite stiffness",
    symmetry: Symmetry::Orthotropic,
    stressed_reference: None,
    small_strains: "the engineering constants",
    source: "Lekhnitskii, Theory of Elasticity of an Anisotropic Elastic Body (1963); defaults: round numbers for a carbon fiber \
             lamina, GPa",
    stiffness: |p| turned(&stiffness(p), p[9]),
    make: |p| {
        let stiffness = stiffness(p);
        if !is_positive(&stiffness) {
            return Err(MaterialError::Parameter {
                name: "the smallest of young1 / nu12^2, young1 / nu13^2 and young2 / nu23^2",
                value: (p[0] / (p[3] * p[3])).min(p[0] / (p[4] * p[4])).min(p[1] / (p[5] * p[5])),
                expected: "moduli and contractions with a positive definite stiffness, so that every strain has positive energy".to_owned(),
            });
        }
        boxed(Ok(Quadratic(QuadraticForm::new(stiffness, p[9]))))
    },
};

/// Stiffness along the material axes: the inverse of the compliance.
fn stiffness(p: &[f64]) -> SmallStrainStiffness {
    let (s11, s22, s33) = (p[0].recip(), p[1].recip(), p[2].recip());
    let (s12, s13, s23) = (-p[3] * s11, -p[4] * s11, -p[5] * s22);
    let determinant = s11 * (s22 * s33 - s23 * s23) - s12 * (s12 * s33 - s23 * s13)
        + s13 * (s12 * s23 - s22 * s13);
    let normal = [
        s22 * s33 - s23 * s23,
        s11 * s33 - s13 * s13,
        s11 * s22 - s12 * s12,
        s12 * s13 - s11 * s23,
        s12 * s23 - s22 * s13,
        s13 * s23 - s33 * s12,
    ];
    orthotropic(
        &normal.each(|minor| minor / determinant),
        &[p[8], p[7], p[6]],
    )
}

struct Quadratic(QuadraticForm);

impl StrainEnergy for Quadratic {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        self.0.of(f)
    }
}
