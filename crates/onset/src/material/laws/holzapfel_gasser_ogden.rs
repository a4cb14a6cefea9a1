//! Arterial wall of Holzapfel, Gasser and Ogden: two families of fibers in a neo-Hookean matrix.
//!
//! The fibers lie in the plane of axes 1 and 2, at `+angle` and `-angle` from axis 1.
//! `W = mu/2 (J^(-2/3) I1 - 3) + sum over both k1/(2 k2) (exp(k2 x^2) - 1) + kappa/2 ((J^2 - 1)/2 - ln J)`, `x = J^(-2/3) a . C a - 1`. With the
//! switch, shortened fibers (`x < 0`) carry no load.

use super::super::StrainEnergy;
use super::super::law::{Admitted, Law, Parameter, SmallStrainStiffness, Symmetry, boxed, hooke};
use super::volumetric::{isochoric_first, polyconvex};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::real::Real;

pub(in super::super) const LAW: Law = Law {
    name: "holzapfel-gasser-ogden",
    formula: "W = mu/2 (J^(-2/3) I1 - 3) + sum_(+-) k1/(2 k2) (exp(k2 x^2) - 1) + kappa/2 ((J^2 - 1)/2 - ln J), x = J^(-2/3) a . C a - 1, \
              a = (cos angle, +- sin angle, 0)",
    parameters: &[
        Parameter::new(
            "mu",
            "stress",
            3.0,
            Admitted::Positive,
            "shear modulus of the matrix",
        ),
        Parameter::new(
            "k1",
            "stress",
            2.3632,
            Admitted::NotNegative,
            "modulus of a family of fibers",
        ),
        Parameter::new(
            "k2",
            "1",
            0.8393,
            Admitted::Positive,
            "constant of the exponent of the fibers",
        ),
        Parameter::new("kappa", "stress", 100.0, Admitted::Positive, "bulk modulus"),
        Parameter::new(
            "angle",
            "deg",
            29.0,
            Admitted::Any,
            "angle between axis 1 and the fibers, on both sides",
        ),
    ],
    domain: "all J > 0; arteries; the fibers resist compression as well as tension",
    symmetry: Symmetry::Orthotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu and bulk modulus kappa of the matrix, and 4 k1 (a a - 1/3)(a a - 1/3) of each family",
    source: "Holzapfel, Gasser and Ogden, J. Elasticity 61 (2000) 1: media of a carotid artery of a rabbit, kPa; kappa chosen",
    stiffness,
    make: |p| boxed(Ok(HolzapfelGasserOgden::new(p, false))),
};

pub(in super::super) const SWITCHED: Law = Law {
    name: "holzapfel-gasser-ogden-switch",
    formula: "as holzapfel-gasser-ogden; fibers with x < 0 carry no stress",
    domain: "all J > 0; arteries; the fibers do not resist compression; at x = 0 the tangent equals the limit from x > 0",
    small_strains: "as holzapfel-gasser-ogden for stretched fibers, and in the reference configuration itself; the matrix alone if they \
                    are shortened",
    make: |p| boxed(Ok(HolzapfelGasserOgden::new(p, true))),
    ..LAW
};

struct HolzapfelGasserOgden {
    mu: f64,
    k1: f64,
    k2: f64,
    kappa: f64,
    /// Cosine and sine of twice the angle.
    double_angle: (f64, f64),
    is_switched: bool,
}

impl HolzapfelGasserOgden {
    fn new(p: &[f64], is_switched: bool) -> Self {
        let (sine, cosine) = (2.0 * p[4]).to_radians().sin_cos();
        Self {
            mu: p[0],
            k1: p[1],
            k2: p[2],
            kappa: p[3],
            double_angle: (cosine, sine),
            is_switched,
        }
    }
}

impl StrainEnergy for HolzapfelGasserOgden {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let i = f.invariants();
        let matrix = (isochoric_first(&i) - 3.0) * (0.5 * self.mu);
        let c = f.right_cauchy_green();
        let shape = i.jacobian.powf(-2.0 / 3.0);
        let (cosine, sine) = self.double_angle;
        let fibers = |sign: f64| {
            // In terms of the double angle x is exactly 0 in the reference configuration, so the side of the switch does not depend on rounding.
            let along = (c[0][0] + c[1][1]) * 0.5
                + (c[0][0] - c[1][1]) * (0.5 * cosine)
                + c[0][1] * (sign * sine);
            let x = along * shape - 1.0;
            let stretched = || ((x * x * self.k2).exp() - 1.0) * (0.5 * self.k1 / self.k2);
            match self.is_switched {
                true => x.switch(0.0, || R::constant(0.0), stretched),
                false => stretched(),
            }
        };
        matrix + fibers(1.0) + fibers(-1.0) + polyconvex(i.jacobian) * (0.5 * self.kappa)
    }
}

fn stiffness(p: &[f64]) -> SmallStrainStiffness {
    let matrix = hooke(p[0], p[3]);
    let (sine, cosine) = p[4].to_radians().sin_cos();
    let third = 1.0 / 3.0;
    let direction = |sign: f64| {
        let (one, two) = (cosine * cosine - third, sine * sine - third);
        [one, two, -third, 0.0, 0.0, sign * sine * cosine]
    };
    let (up, down) = (direction(1.0), direction(-1.0));
    array_of(|a| array_of(|b| matrix[a][b] + 4.0 * p[1] * (up[a] * up[b] + down[a] * down[b])))
}
