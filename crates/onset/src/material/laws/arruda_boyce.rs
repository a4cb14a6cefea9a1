//! Eight-chain law of Arruda and Boyce with five terms of the series of the inverse Langevin function.
//!
//! `W = mu sum_i a_i / locking^(2i-2) ((J^(-2/3) I1)^i - 3^i) + kappa/2 ((J^2 - 1)/2 - ln J)`, `a = 1/2, 1/20, 11/1050, 19/7000, 519/673750`. The
//! shear modulus at small strains is `2 mu sum_i i a_i 3^(i-1) / locking^(2i-2)`.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, given_by_invariants};
use super::volumetric::{isochoric_first, polyconvex};
use crate::kinematics::Invariants;
use crate::real::Real;

const SERIES: [f64; 5] = [
    0.5,
    1.0 / 20.0,
    11.0 / 1050.0,
    19.0 / 7000.0,
    519.0 / 673_750.0,
];

pub(in super::super) const LAW: Law = Law {
    name: "arruda-boyce",
    formula: "W = mu sum_(i=1..5) a_i / locking^(2i-2) (x^i - 3^i) + kappa/2 ((J^2 - 1)/2 - ln J), x = J^(-2/3) I1, a = 1/2, 1/20, \
              11/1050, 19/7000, 519/673750",
    parameters: &[
        Parameter::new(
            "mu",
            "stress",
            0.27,
            Admitted::Positive,
            "modulus of the chains, n k T",
        ),
        Parameter::new(
            "locking",
            "1",
            5.147_815_070_493_5,
            Admitted::Positive,
            "chain stretch at locking, the square root of the number of links",
        ),
        Parameter::new("kappa", "stress", 100.0, Admitted::Positive, "bulk modulus"),
    ],
    domain: "all J > 0 (a series of five terms); rubber, below the locking of its chains",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu (1 + 3/(5 l^2) + 99/(175 l^4) + 513/(875 l^6) + 42039/(67375 l^8)), l = locking; bulk modulus kappa",
    source: "Arruda and Boyce, J. Mech. Phys. Solids 41 (1993) 389, MPa and sqrt(26.5) links for Treloar's rubber; kappa chosen",
    stiffness: |p| {
        let x = p[1].powi(-2);
        let series = 1.0
            + x * (3.0 / 5.0 + x * (99.0 / 175.0 + x * (513.0 / 875.0 + x * 42039.0 / 67375.0)));
        hooke(p[0] * series, p[2])
    },
    make: |p| {
        boxed(Ok(ArrudaBoyce {
            mu: p[0],
            locking: p[1],
            kappa: p[2],
        }))
    },
};

struct ArrudaBoyce {
    mu: f64,
    locking: f64,
    kappa: f64,
}

impl InvariantEnergy for ArrudaBoyce {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        // With x = 3 + y, x^i - 3^i has the factor y; Horner's scheme in x / locking^2.
        let x = isochoric_first(i);
        let scale = self.locking.powi(-2);
        let chains = (0..5)
            .rev()
            .fold(R::constant(0.0), |sum, n| sum * x * scale + SERIES[n]);
        let reference = SERIES
            .iter()
            .rev()
            .fold(0.0, |sum, a| sum * 3.0 * scale + a);
        (x * chains - 3.0 * reference) * self.mu + polyconvex(i.jacobian) * (0.5 * self.kappa)
    }
}

given_by_invariants!(ArrudaBoyce);
