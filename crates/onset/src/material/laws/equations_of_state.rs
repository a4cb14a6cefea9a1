//! Equations of state with a deviator: a pressure that depends on the volume alone, and a shear stiffness.
//!
//! `W = mu/2 (J^(-2/3) I1 - 3) + e(J)`, with the pressure `p = -e'(J)` and the bulk modulus `kappa = e''(1)`. With `mu = 0` the law is a fluid: shear
//! has no energy, so transverse waves have no stiffness and the law is nowhere strongly elliptic.
//!
//! - Murnaghan: a bulk modulus that is linear in the pressure, `kappa + n p`.
//! - Tait: a compression that is logarithmic in the pressure, `1 - J = c ln(1 + p/(kappa c))`.
//! - Mie and Grueneisen: the isentrope through the reference state of a solid with `U_s = c0 + s u_p` and `Gamma rho = Gamma_0 rho_0`, derived at
//!   `MieGrueneisen`.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, MaterialError, given_by_invariants};
use super::volumetric::isochoric_first;
use crate::algebra::unit_interval;
use crate::kinematics::Invariants;
use crate::real::Real;

const fn bulk(default: f64) -> Parameter {
    Parameter::new(
        "kappa",
        "stress",
        default,
        Admitted::Positive,
        "bulk modulus, rho c0^2 with the bulk speed of sound c0",
    )
}

const fn shear(default: f64) -> Parameter {
    Parameter::new(
        "mu",
        "stress",
        default,
        Admitted::NotNegative,
        "shear modulus; 0 for a fluid",
    )
}

pub(in super::super) const MURNAGHAN: Law = Law {
    name: "murnaghan",
    formula: "W = mu/2 (J^(-2/3) I1 - 3) + kappa/n ((J^(1-n) - 1)/(n - 1) + J - 1), pressure kappa/n (J^(-n) - 1)",
    parameters: &[
        shear(1.0),
        bulk(100.0),
        Parameter::new(
            "n",
            "1",
            7.0,
            Admitted::Between(1.0, 1000.0),
            "derivative of the bulk modulus with respect to the pressure",
        ),
    ],
    domain: "all J > 0; liquids and solids under pressures up to the size of kappa; polyconvex; with mu = 0 a fluid, not strongly elliptic",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "Murnaghan, Proc. Natl. Acad. Sci. USA 30 (1944) 244; with n = 7 for water Cole, Underwater Explosions (1948), and the equation that codes of \
             smoothed particle hydrodynamics call Tait's (Monaghan, J. Comput. Phys. 110 (1994) 399); defaults: kappa = 100 mu, any unit of stress",
    stiffness: |p| hooke(p[0], p[1]),
    make: |p| {
        let volume = Murnaghan {
            kappa: p[1],
            n: p[2],
        };
        boxed(Ok(WithDeviator { mu: p[0], volume }))
    },
};

pub(in super::super) const TAIT: Law = Law {
    name: "tait",
    formula: "W = mu/2 (J^(-2/3) I1 - 3) + kappa tait-c (tait-c (exp((1 - J)/tait-c) - 1) - (1 - J)), pressure kappa tait-c (exp((1 - J)/tait-c) - 1)",
    parameters: &[
        shear(1.0),
        bulk(100.0),
        Parameter::new(
            "tait-c",
            "1",
            0.137,
            Admitted::Positive,
            "increase of the compression 1 - J that multiplies kappa tait-c + p by e",
        ),
    ],
    domain: "all J > 0; liquids and polymers, mostly at J < 1; polyconvex; with mu = 0 a fluid, not strongly elliptic",
    source: "Tait, Challenger Reports, Physics and Chemistry 2 (1888), in Tammann's form (Dymond and Malhotra, Int. J. Thermophys. 9 (1988) 941); for \
             water tait-c = 0.315 / ln 10 (Li, J. Geophys. Res. 72 (1967) 2665); the equation that codes of smoothed particle hydrodynamics call Tait's is `murnaghan`; \
             defaults: kappa = 100 mu, any unit of stress",
    make: |p| {
        let volume = Tait {
            kappa: p[1],
            c: p[2],
        };
        boxed(Ok(WithDeviator { mu: p[0], volume }))
    },
    ..MURNAGHAN
};

pub(in super::super) const MIE_GRUENEISEN: Law = Law {
    name: "mie-grueneisen",
    formula: "W = mu/2 (J^(-2/3) I1 - 3) + e(1 - J), e'(x) = h(x) + gamma0 (e(x) - h(x) x/2), e(0) = 0, h(x) = kappa x/(1 - s x)^2",
    parameters: &[
        shear(69.0),
        bulk(194.0),
        Parameter::new(
            "s",
            "1",
            1.2,
            Admitted::Positive,
            "slope of the shock speed, U_s = c0 + s u_p",
        ),
        Parameter::new(
            "gamma0",
            "1",
            1.67,
            Admitted::Any,
            "Grueneisen's parameter in the reference configuration",
        ),
    ],
    domain: "J > 1 - 1/s, the limit of an infinitely strong shock; solids under strong compression, without heat conduction; in tension the \
             pressure is lowest near J = 1 + 1/s; with mu = 0 a fluid, not strongly elliptic",
    source: "the isentrope through the reference configuration, Davison, Fundamentals of Shock Wave Propagation in Solids (2008), of the Hugoniot of \
             Rice, McQueen and Walsh, Solid State Physics 6 (1958) 1, with Gamma rho constant; kappa = rho0 c0^2; defaults: typical of tantalum, GPa \
             (measured constants: Marsh, LASL Shock Hugoniot Data, 1980)",
    make: |p| {
        let volume = MieGrueneisen::new(p[1], p[2], p[3]);
        boxed(Ok(WithDeviator { mu: p[0], volume }))
    },
    ..MURNAGHAN
};

/// Volumetric energy, whose derivative is the negative pressure.
trait Volumetric {
    /// Energy `e(J)` per reference volume, with zero value and slope at `J = 1`.
    fn energy<R: Real>(&self, jacobian: R) -> R;

    /// Checks that a pressure exists at a volume.
    fn admits(&self, _jacobian: f64) -> Result<(), MaterialError> {
        Ok(())
    }
}

/// Law with a pressure and a neo-Hookean resistance to changes of shape.
struct WithDeviator<Volume> {
    mu: f64,
    volume: Volume,
}

impl<Volume: Volumetric> InvariantEnergy for WithDeviator<Volume> {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        (isochoric_first(i) - 3.0) * (0.5 * self.mu) + self.volume.energy(i.jacobian)
    }

    fn admits_invariants(&self, i: &Invariants<f64>) -> Result<(), MaterialError> {
        self.volume.admits(i.jacobian)
    }
}

given_by_invariants!(
    WithDeviator<Murnaghan>,
    WithDeviator<Tait>,
    WithDeviator<MieGrueneisen>
);

struct Murnaghan {
    kappa: f64,
    n: f64,
}

impl Volumetric for Murnaghan {
    fn energy<R: Real>(&self, jacobian: R) -> R {
        let power = (jacobian.powf(1.0 - self.n) - 1.0) * (1.0 / (self.n - 1.0));
        (power + jacobian - 1.0) * (self.kappa / self.n)
    }
}

struct Tait {
    kappa: f64,
    c: f64,
}

impl Volumetric for Tait {
    fn energy<R: Real>(&self, jacobian: R) -> R {
        let compression = (jacobian - 1.0) * (-1.0 / self.c);
        (compression.exp() - 1.0 - compression) * (self.kappa * self.c * self.c)
    }
}

/// Number of points of the rule that integrates the entropy of shocks. The integrand has no singularity, and the error is below rounding for volumes
/// from compressions near the pole to tenfold expansions.
const POINTS: usize = 16;

/// Isentrope of the Mie-Grueneisen equation through the reference configuration.
///
/// With `x = 1 - J`, the Hugoniot pressure `h = kappa x/(1 - s x)^2` and its energy `h x/2`, the equations `p = h + Gamma_0 (e - h x/2)` and
/// `p = de/dx` on an isentrope combine to a linear equation for `e`. Its solution is the energy of the shock minus the heat of the shock,
///
/// `e = h x/2 - kappa s int_0^x exp(Gamma_0 (x - t)) t^2/(1 - s t)^3 dt`.
///
/// The heat is of third order in `x`: Hugoniot and isentrope have equal slope and curvature of the pressure at `x = 0`. With `1 - s t = exp(-l u)`,
/// `l = -ln(1 - s x)`, the integrand is entire: `kappa l/s^2 int_0^1 exp(Gamma_0 (x - t)) (exp(l u) - 1)^2 du`.
struct MieGrueneisen {
    kappa: f64,
    s: f64,
    gamma: f64,
    rule: Vec<(f64, f64)>,
}

impl MieGrueneisen {
    fn new(kappa: f64, s: f64, gamma: f64) -> Self {
        Self {
            kappa,
            s,
            gamma,
            rule: unit_interval(POINTS),
        }
    }
}

impl Volumetric for MieGrueneisen {
    fn energy<R: Real>(&self, jacobian: R) -> R {
        let x = -(jacobian - 1.0);
        let rest = x * -self.s + 1.0;
        let shock = x * x / (rest * rest) * (0.5 * self.kappa);
        let logarithm = -rest.ln();
        let heat = self.rule.iter().fold(R::constant(0.0), |sum, (u, weight)| {
            let grown = (logarithm * *u).exp();
            let rise = grown - 1.0;
            let t = rise / grown * (1.0 / self.s);
            sum + ((x - t) * self.gamma).exp() * rise * rise * *weight
        });
        shock - heat * logarithm * (self.kappa / (self.s * self.s))
    }

    fn admits(&self, jacobian: f64) -> Result<(), MaterialError> {
        let least = 1.0 - 1.0 / self.s;
        // The comparison also fails for NaN.
        if jacobian > least {
            return Ok(());
        }
        Err(MaterialError::OutsideDomain {
            what: "J",
            value: jacobian,
            expected: format!("the Hugoniot of mie-grueneisen has its pole at 1 - 1/s = {least:?}"),
        })
    }
}
