//! Saint-Venant-Kirchhoff law: quadratic in Green's strain.
//!
//! `W = lambda/2 (tr E)^2 + mu tr E^2`. It is intended for large rotations and small strains: in compression it softens, and uniaxial strain loses
//! strong ellipticity at the stretch `1/sqrt 3` or before.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{MaterialError, StrainEnergy};
use crate::kinematics::DeformationGradient;
use crate::real::Real;

pub(in super::super) const LAW: Law = Law {
    name: "saint-venant-kirchhoff",
    formula: "W = lambda/2 (tr E)^2 + mu tr E^2, E = (C - 1)/2",
    parameters: &[
        Parameter::new(
            "lambda",
            "stress",
            1.0,
            Admitted::Any,
            "Lame's first constant",
        ),
        Parameter::new("mu", "stress", 1.0, Admitted::Positive, "shear modulus"),
    ],
    domain: "all states; accurate for large rotations and small strains; lambda > -2/3 mu",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "Lame's constants lambda and mu",
    source: "Kirchhoff, Sitzungsber. Akad. Wiss. Wien 9 (1852) 762; defaults: Poisson's ratio 1/4, any unit of stress",
    stiffness: |p| hooke(p[1], p[0] + p[1] / 1.5),
    make: |p| {
        MaterialError::positive("lambda + 2/3 mu", p[0] + p[1] / 1.5)?;
        boxed(Ok(SaintVenantKirchhoff {
            lambda: p[0],
            mu: p[1],
        }))
    },
};

struct SaintVenantKirchhoff {
    lambda: f64,
    mu: f64,
}

impl StrainEnergy for SaintVenantKirchhoff {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let c = f.right_cauchy_green();
        let e = |i: usize| (c[i][i] - 1.0) * 0.5;
        let trace = e(0) + e(1) + e(2);
        let squares = e(0) * e(0)
            + e(1) * e(1)
            + e(2) * e(2)
            + (c[0][1] * c[0][1] + c[0][2] * c[0][2] + c[1][2] * c[1][2]) * 0.5;
        trace * trace * (0.5 * self.lambda) + squares * self.mu
    }
}
