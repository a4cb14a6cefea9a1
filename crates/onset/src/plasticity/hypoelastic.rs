//! Hypoelastic laws: the stress is integrated in time from an objective rate, without an energy.
//!
//! The stress is `sigma = -p 1 + s` with the pressure `p = kappa/n (J^(-n) - 1)`, which for `n = 0` is `-kappa ln J` and thus has a rate form too,
//! and the deviator
//!
//! `s' = 2 mu dev D + Omega s - s Omega`,
//!
//! where `D` and `W` are the symmetric and the skew part of `L = F' F^-1`. The Jaumann rate uses `Omega = W`, the Green-Naghdi rate `Omega = R' R^T`
//! of `F = V R`. In the principal axes of `V`, with its stretches `v_a`,
//!
//! `W_ab - Omega_ab = D_ab (v_a - v_b)/(v_a + v_b)`.
//!
//! A state `F = R U` is reached along `R U^t`, `0 <= t <= 1`, where neither rate rotates the axes of the stress: both give `s = 2 mu dev ln V`.
//!
//! **Tangent.** The rates above are linear in `L`, `sigma'_ij = g_ijkl L_kl`, and
//!
//! `A_iJkL = J F^-1_Jj F^-1_Ll (g_ijkl + sigma_ij delta_kl - sigma_il delta_jk)`.
//!
//! In a stressed state it has no major symmetry, since it does not derive from an energy: waves can flutter.
//!
//! Sources: C. Truesdell, *J. Rational Mech. Anal.* 4 (1955) 83; J. K. Dienes, *Acta Mech.* 32 (1979) 217; W. Prager, *Q. Appl. Math.* 18 (1961) 403.

use super::spectral::Spectral;
use crate::algebra::unit_interval;
use crate::kinematics::DeformationGradient;
use crate::material::{
    Admitted, FourthOrder, Hyperelastic, Law, Made, MaterialError, Parameter, Response, Symmetry,
    hooke,
};
use nalgebra::Matrix3;

/// Number of Gauss points for the work along the path to a state.
const POINTS: usize = 16;

const MU: Parameter = Parameter::new("mu", "stress", 1.0, Admitted::Positive, "shear modulus");
const KAPPA: Parameter = Parameter::new(
    "kappa",
    "stress",
    2.0,
    Admitted::Positive,
    "bulk modulus at J = 1",
);
const N: Parameter = Parameter::new(
    "n",
    "1",
    0.0,
    Admitted::NotNegative,
    "derivative of the bulk modulus with respect to the pressure: 0 for a pressure in rate form, 1 for a pressure linear in the density, 7 for water",
);
const SPIN: Parameter = Parameter::new(
    "spin",
    "1",
    1.0,
    Admitted::Any,
    "factor of the spin that rotates the stress: 1 for the Jaumann rate, -1 for a code with a sign error, whose stress rotates against the material",
);

pub(super) const JAUMANN: Law = Law {
    name: "hypoelastic-jaumann",
    formula: "sigma = -p 1 + s, p = kappa/n (J^(-n) - 1) (-kappa ln J if n = 0), s' = 2 mu dev D + spin (W s - s W)",
    parameters: &[MU, KAPPA, N, SPIN],
    domain: "all J > 0; small elastic strains, as in codes that integrate the stress; states are reached along R U^t; not from an energy: the tangent has no major \
             symmetry at stressed states",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "Jaumann's rate of the deviator; in smoothed particle hydrodynamics Gray, Monaghan and Swift, Comput. Methods Appl. Mech. Engrg. 190 \
             (2001) 6641; defaults: Poisson's ratio 2/7, any unit of stress",
    stiffness: |p| hooke(p[0], p[1]),
    make: |p| made(p, Rate::Jaumann { spin: p[3] }),
};

pub(super) const GREEN_NAGHDI: Law = Law {
    name: "hypoelastic-green-naghdi",
    formula: "sigma = -p 1 + s, p = kappa/n (J^(-n) - 1) (-kappa ln J if n = 0), s' = 2 mu dev D + Omega s - s Omega, Omega = R' R^T",
    parameters: &[MU, KAPPA, N],
    source: "the rate of Green and Naghdi, Arch. Ration. Mech. Anal. 18 (1965) 251, used by codes that integrate the stress in unrotated axes (Flanagan and Taylor, \
             Comput. Methods Appl. Mech. Engrg. 62 (1987) 305); defaults: Poisson's ratio 2/7, any unit of stress",
    make: |p| made(p, Rate::GreenNaghdi),
    ..JAUMANN
};

/// Objective rate of the stress.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rate {
    /// Jaumann rate with the spin `W`, multiplied by a factor that is one unless a code implements it incorrectly.
    Jaumann { spin: f64 },
    /// Green-Naghdi rate with the spin `R' R^T`.
    GreenNaghdi,
}

/// Hypoelastic law with its parameters.
struct Hypoelastic {
    mu: f64,
    kappa: f64,
    n: f64,
    rate: Rate,
}

fn made(p: &[f64], rate: Rate) -> Made {
    Ok(Box::new(Hypoelastic {
        mu: p[0],
        kappa: p[1],
        n: p[2],
        rate,
    }))
}

/// Kronecker delta `delta_ij` as a number.
fn delta(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

/// State with the stress that results from the path to it.
struct Stressed<'a> {
    law: &'a Hypoelastic,
    /// Logarithmic strain `ln V` of the state.
    logarithm: Spectral,
    /// Logarithm of the volume ratio, `tr ln V = ln J`.
    volume: f64,
    /// Deviator `s` of the stress.
    deviator: Matrix3<f64>,
}

impl Hypoelastic {
    fn at<'a>(&'a self, f: &DeformationGradient) -> Result<Stressed<'a>, MaterialError> {
        let matrix = f.matrix();
        let logarithm = Spectral::half_logarithm(&(matrix * matrix.transpose()));
        let logarithm = logarithm.ok_or_else(|| MaterialError::NotFinite {
            jacobian: f.jacobian(),
        })?;
        let mean = logarithm.values.mean();
        Ok(Stressed {
            law: self,
            volume: 3.0 * mean,
            deviator: logarithm.map(|value| 2.0 * self.mu * (value - mean)),
            logarithm,
        })
    }

    /// Mean stress `-p` at a logarithm of `J`.
    fn tension(&self, volume: f64) -> f64 {
        match self.n == 0.0 {
            true => self.kappa * volume,
            false => -self.kappa * (-self.n * volume).exp_m1() / self.n,
        }
    }
}

impl Stressed<'_> {
    /// Cauchy stress `sigma` of the state.
    fn cauchy(&self) -> Matrix3<f64> {
        self.deviator + Matrix3::identity() * self.law.tension(self.volume)
    }

    /// Work of the stress along the path per reference volume, `int J sigma : ln V dt`.
    fn work(&self) -> f64 {
        let law = self.law;
        let deviator = self.deviator.norm_squared() / (2.0 * law.mu);
        let power = |t: f64| {
            let volume = t * self.volume;
            volume.exp() * (deviator * t + law.tension(volume) * self.volume)
        };
        let points = unit_interval(POINTS);
        points.iter().map(|(t, weight)| weight * power(*t)).sum()
    }

    /// Spin `Omega` for the velocity gradient `e_k (x) e_l`.
    fn spin(&self, k: usize, l: usize) -> Matrix3<f64> {
        let mut gradient = Matrix3::zeros();
        gradient[(k, l)] = 1.0;
        let spin = (gradient - gradient.transpose()) * 0.5;
        if let Rate::Jaumann { spin: factor } = self.law.rate {
            return spin * factor;
        }
        let axes = &self.logarithm.axes;
        let strain = axes.transpose() * (gradient + gradient.transpose()) * axes * 0.5;
        // The quotient (v_a - v_b)/(v_a + v_b) is a hyperbolic tangent of the logarithms.
        let values = &self.logarithm.values;
        let share = |a: usize, b: usize| (0.5 * (values[a] - values[b])).tanh();
        spin - self
            .logarithm
            .turned(&Matrix3::from_fn(|a, b| strain[(a, b)] * share(a, b)))
    }

    /// Rotational terms `Omega s - s Omega` for all velocity gradients `e_k (x) e_l`, stored at `3 k + l`.
    fn turned(&self) -> Vec<Matrix3<f64>> {
        let of = |n: usize| {
            let spin = self.spin(n / 3, n % 3);
            spin * self.deviator - self.deviator * spin
        };
        (0..9).map(of).collect()
    }

    /// Component of `kappa_J tr D 1 + 2 mu dev D` for a velocity gradient, with a given bulk modulus.
    fn stiffness(&self, bulk: f64, [i, j, k, l]: [usize; 4]) -> f64 {
        let shear = delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k);
        self.law.mu * shear + (bulk - self.law.mu / 1.5) * delta(i, j) * delta(k, l)
    }

    /// Bulk modulus `d(-p)/d ln J` of the state.
    fn bulk(&self) -> f64 {
        self.law.kappa * (-self.law.n * self.volume).exp()
    }
}

impl Hyperelastic for Hypoelastic {
    fn is_path_dependent(&self) -> bool {
        true
    }

    /// Response of the law. Its energy is the work along the path; stress and tangent have no potential.
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let state = self.at(f)?;
        let (sigma, turned, bulk) = (state.cauchy(), state.turned(), state.bulk());
        let spatial = FourthOrder::from_fn(|i, j, k, l| {
            state.stiffness(bulk, [i, j, k, l])
                + turned[3 * k + l][(i, j)]
                + sigma[(i, j)] * delta(k, l)
                - sigma[(i, l)] * delta(j, k)
        });
        let jacobian = f.jacobian();
        let inverse = f.matrix().try_inverse();
        let inverse = inverse.ok_or(MaterialError::NotFinite { jacobian })?;
        Response {
            deformation: *f,
            energy: state.work(),
            first_piola: sigma * inverse.transpose() * jacobian,
            tangent: spatial.pulled_back(f),
        }
        .finite()
    }

    /// Tangent that is integrated in time. Stress in unrotated axes follows the positions, whereas the Jaumann rate integrates the rotation in time.
    /// A pressure that is a function of the volume is not integrated.
    fn integrated_tangent(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        let state = self.at(f)?;
        let bulk = if self.n == 0.0 { self.kappa } else { 0.0 };
        let turned = match self.rate {
            Rate::Jaumann { .. } => state.turned(),
            Rate::GreenNaghdi => vec![Matrix3::zeros(); 9],
        };
        let spatial = FourthOrder::from_fn(|i, j, k, l| {
            state.stiffness(bulk, [i, j, k, l]) + turned[3 * k + l][(i, j)]
        });
        Ok(Some(spatial.pulled_back(f)))
    }
}
