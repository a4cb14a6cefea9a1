//! Standard reinforcing model: one family of fibers in a neo-Hookean matrix.
//!
//! `W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 + mu gamma/2 (I4 - 1)^2`, `I4 = a . C a`, `a = (cos angle, sin angle, 0)`. Strong ellipticity is
//! lost under compression along stiff fibers.

use super::super::law::{Admitted, Law, Parameter, SmallStrainStiffness, Symmetry, boxed, hooke};
use super::super::{MaterialError, StrainEnergy};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::real::Real;

pub(in super::super) const LAW: Law = Law {
    name: "standard-reinforcing",
    formula: "W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 + mu gamma/2 (I4 - 1)^2, I4 = a . C a, a = (cos angle, sin angle, 0)",
    parameters: &[
        Parameter::new(
            "mu",
            "stress",
            1.0,
            Admitted::Positive,
            "shear modulus of the matrix",
        ),
        Parameter::new(
            "lambda",
            "stress",
            1.0,
            Admitted::Any,
            "Lame's first constant of the matrix",
        ),
        Parameter::new(
            "gamma",
            "1",
            5.0,
            Admitted::NotNegative,
            "strength of the fibers",
        ),
        Parameter::new(
            "angle",
            "deg",
            0.0,
            Admitted::Any,
            "angle from axis 1 to the fibers, about axis 3",
        ),
    ],
    domain: "all J > 0; rubber and tissue with one family of fibers; lambda > -2/3 mu",
    symmetry: Symmetry::TransverselyIsotropic,
    stressed_reference: None,
    small_strains: "Lame's constants lambda and mu of the matrix, and 4 mu gamma a a a a of the fibers",
    source: "Qiu and Pence, J. Elasticity 49 (1997) 1; Merodio and Ogden, Int. J. Solids Struct. 40 (2003) 4707; defaults: round \
             numbers",
    stiffness,
    make: |p| {
        MaterialError::positive("lambda + 2/3 mu", p[1] + p[0] / 1.5)?;
        boxed(Ok(StandardReinforcing::new(p)))
    },
};

struct StandardReinforcing {
    mu: f64,
    lambda: f64,
    gamma: f64,
    /// Cosine and sine of twice the angle.
    double_angle: (f64, f64),
}

impl StandardReinforcing {
    fn new(p: &[f64]) -> Self {
        let (sine, cosine) = (2.0 * p[3]).to_radians().sin_cos();
        Self {
            mu: p[0],
            lambda: p[1],
            gamma: p[2],
            double_angle: (cosine, sine),
        }
    }
}

impl StrainEnergy for StandardReinforcing {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let i = f.invariants();
        let log = i.jacobian.ln();
        let c = f.right_cauchy_green();
        let (cosine, sine) = self.double_angle;
        let stretch =
            (c[0][0] + c[1][1]) * 0.5 + (c[0][0] - c[1][1]) * (0.5 * cosine) + c[0][1] * sine - 1.0;
        ((i.first - 3.0) * 0.5 - log + stretch * stretch * (0.5 * self.gamma)) * self.mu
            + log * log * (0.5 * self.lambda)
    }
}

fn stiffness(p: &[f64]) -> SmallStrainStiffness {
    let matrix = hooke(p[0], p[1] + p[0] / 1.5);
    let (sine, cosine) = p[3].to_radians().sin_cos();
    let fiber = [cosine * cosine, sine * sine, 0.0, 0.0, 0.0, sine * cosine];
    array_of(|a| array_of(|b| matrix[a][b] + 4.0 * p[0] * p[2] * fiber[a] * fiber[b]))
}
