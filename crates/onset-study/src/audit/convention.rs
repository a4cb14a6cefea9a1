//! Conventions for the tangent of a material, all computed from one measured quantity: the derivative of the Cauchy stress.

use nalgebra::{Matrix3, SymmetricEigen};
use onset::kinematics::DeformationGradient;
use onset::material::{FourthOrder, Response};
use serde::Serialize;

/// Convention of a tangent. Rates are per rate of deformation `D`; all in units of stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Convention {
    /// `(J sigma)' - W J sigma + J sigma W = J c : D`: the `DDSDDE` of Abaqus.
    JaumannKirchhoff,
    /// `sigma' - W sigma + sigma W = c : D`: Jaumann rate of the Cauchy stress, without the term `sigma_ij delta_kl`.
    JaumannCauchy,
    /// Truesdell rate `sigma' - L sigma - sigma L^T + tr(D) sigma = c : D`, so that `c = F F dS/dE F F / J`.
    Truesdell,
    /// Green-Naghdi rate of the Kirchhoff stress, `(J sigma)' - Omega J sigma + J sigma Omega = J c : D` with `Omega = R' R^T`.
    GreenNaghdiKirchhoff,
    /// Green-Naghdi rate of the Cauchy stress, `sigma' - Omega sigma + sigma Omega = c : D`.
    GreenNaghdiCauchy,
    /// `d sigma / d ln V` of the last increment at constant rotation: the small-strain tangent of a corotational update.
    LogarithmicStrain,
    /// `d sigma / d epsilon` with the small strain `epsilon = sym(F) - 1`.
    SmallStrain,
    /// `dS/dE` in the reference configuration (material axes).
    SecondPiola,
    /// First elasticity tensor, the derivative of the nominal stress: `A_iJkL = dP_iJ/dF_kL`.
    FirstPiola,
    /// `dN_Ji/d(F^T)_Lk` with the nominal stress `N = P^T`: `A` with both pairs of indices exchanged.
    Nominal,
    /// Derivative `dN_Ji/dF_kL` of the nominal stress.
    NominalGradient,
    /// Elasticity of the reference configuration, used at every state.
    Reference,
}

fn delta(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

/// Derivative of the Cauchy stress at a state.
#[derive(Clone, Debug)]
pub struct StressChange {
    /// Deformation gradient of the state.
    pub deformation: DeformationGradient,
    /// Last increment on the way to the state; the whole deformation for a law without history.
    pub increment: Matrix3<f64>,
    /// Cauchy stress `sigma`. Units of stress.
    pub cauchy: Matrix3<f64>,
    /// Derivative `g_ijkl = d sigma_ij / d l_kl` for `F' = (1 + l) F`.
    pub gradient: FourthOrder,
}

impl Convention {
    /// All conventions, first the convention of Abaqus.
    pub const ALL: [Self; 12] = [
        Self::JaumannKirchhoff,
        Self::JaumannCauchy,
        Self::Truesdell,
        Self::GreenNaghdiKirchhoff,
        Self::GreenNaghdiCauchy,
        Self::LogarithmicStrain,
        Self::SmallStrain,
        Self::SecondPiola,
        Self::FirstPiola,
        Self::Nominal,
        Self::NominalGradient,
        Self::Reference,
    ];

    /// Name on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::JaumannKirchhoff => "jaumann-kirchhoff",
            Self::JaumannCauchy => "jaumann-cauchy",
            Self::Truesdell => "truesdell",
            Self::GreenNaghdiKirchhoff => "green-naghdi-kirchhoff",
            Self::GreenNaghdiCauchy => "green-naghdi-cauchy",
            Self::LogarithmicStrain => "logarithmic-strain",
            Self::SmallStrain => "small-strain",
            Self::SecondPiola => "second-piola",
            Self::FirstPiola => "first-piola",
            Self::Nominal => "nominal",
            Self::NominalGradient => "nominal-gradient",
            Self::Reference => "reference",
        }
    }

    /// Description of the convention.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::JaumannKirchhoff => "the Jaumann rate of the Kirchhoff stress divided by J",
            Self::JaumannCauchy => "the Jaumann rate of the Cauchy stress",
            Self::Truesdell => "the Truesdell rate of the Cauchy stress",
            Self::GreenNaghdiKirchhoff => {
                "the Green-Naghdi rate of the Kirchhoff stress divided by J"
            }
            Self::GreenNaghdiCauchy => "the Green-Naghdi rate of the Cauchy stress",
            Self::LogarithmicStrain => {
                "the Cauchy stress per increment of logarithmic strain at fixed rotation"
            }
            Self::SmallStrain => "the Cauchy stress per small strain sym(F) - 1",
            Self::SecondPiola => "dS/dE, second Piola-Kirchhoff stress per Green strain",
            Self::FirstPiola => "dP/dF, first Piola-Kirchhoff stress per deformation gradient",
            Self::Nominal => "dP/dF with the indices of P and of F exchanged (nominal stress)",
            Self::NominalGradient => "d(P^T)/dF, nominal stress per deformation gradient",
            Self::Reference => "the elasticity of the reference configuration",
        }
    }

    /// Returns the convention with this name, or `None`.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|convention| convention.name() == name)
    }

    /// Computes the tangent in this convention; `reference` is the tangent of the reference configuration.
    pub fn tangent(self, change: &StressChange, reference: &FourthOrder) -> FourthOrder {
        match self {
            Self::JaumannKirchhoff => change.jaumann(1.0),
            Self::JaumannCauchy => change.jaumann(0.0),
            Self::Truesdell => change.truesdell(),
            Self::GreenNaghdiKirchhoff => change.green_naghdi(1.0),
            Self::GreenNaghdiCauchy => change.green_naghdi(0.0),
            Self::LogarithmicStrain => change.logarithmic(),
            Self::SmallStrain => change.small_strain(),
            Self::SecondPiola => change.second_piola(),
            Self::FirstPiola => change.first_piola(),
            Self::Nominal => exchanged(&change.first_piola(), true),
            Self::NominalGradient => exchanged(&change.first_piola(), false),
            Self::Reference => reference.clone(),
        }
    }
}

/// `T_abcd = A_badc`, or with only the first pair exchanged.
fn exchanged(tensor: &FourthOrder, both: bool) -> FourthOrder {
    FourthOrder::from_fn(|a, b, c, d| match both {
        true => tensor[(b, a, d, c)],
        false => tensor[(b, a, c, d)],
    })
}

/// Transforms the second pair of indices, `T_ijmn m_mn(k, l)`.
fn composed(
    tensor: &FourthOrder,
    velocity_gradient: impl Fn(usize, usize) -> Matrix3<f64>,
) -> FourthOrder {
    let gradients: Vec<Matrix3<f64>> = (0..9).map(|n| velocity_gradient(n / 3, n % 3)).collect();
    FourthOrder::from_fn(|i, j, k, l| {
        let gradient = &gradients[3 * k + l];
        (0..9)
            .map(|n| tensor[(i, j, n / 3, n % 3)] * gradient[(n / 3, n % 3)])
            .sum()
    })
}

/// Symmetric tensor of the unit strain `kl`: `(e_k e_l + e_l e_k) / 2`.
fn unit_strain(k: usize, l: usize) -> Matrix3<f64> {
    let mut unit = Matrix3::zeros();
    unit[(k, l)] += 0.5;
    unit[(l, k)] += 0.5;
    unit
}

impl StressChange {
    /// Takes the derivative from the effective tangent of a response, (50).
    pub fn of_response(response: &Response) -> Self {
        Self {
            deformation: response.deformation,
            increment: response.deformation.matrix(),
            cauchy: response.cauchy(),
            gradient: response.effective_cauchy_tangent(),
        }
    }

    fn inverse(&self) -> Matrix3<f64> {
        // The determinant of a validated deformation gradient is positive.
        self.deformation
            .matrix()
            .try_inverse()
            .unwrap_or_else(Matrix3::zeros)
    }

    /// Jaumann rate from the measured derivative. Without spin, the derivative is the Jaumann rate of the Cauchy stress; the rate of the Kirchhoff stress over `J` adds `tr(D) sigma`.
    fn jaumann(&self, kirchhoff: f64) -> FourthOrder {
        let gradient = &self.gradient;
        FourthOrder::from_fn(|i, j, k, l| {
            0.5 * (gradient[(i, j, k, l)] + gradient[(i, j, l, k)])
                + kirchhoff * self.cauchy[(i, j)] * delta(k, l)
        })
    }

    /// Jaumann rate of the Kirchhoff stress over `J`, less `D sigma + sigma D`.
    fn truesdell(&self) -> FourthOrder {
        let jaumann = self.jaumann(1.0);
        let products: Vec<Matrix3<f64>> = (0..9)
            .map(|n| {
                let d = unit_strain(n / 3, n % 3);
                d * self.cauchy + self.cauchy * d
            })
            .collect();
        FourthOrder::from_fn(|i, j, k, l| jaumann[(i, j, k, l)] - products[3 * k + l][(i, j)])
    }

    /// Principal stretches and axes of `V`, of the state or of its last increment.
    fn principal(f: &Matrix3<f64>) -> (nalgebra::Vector3<f64>, Matrix3<f64>) {
        let left = SymmetricEigen::try_new(f * f.transpose(), f64::EPSILON, 500);
        left.map_or(
            (nalgebra::Vector3::repeat(f64::NAN), Matrix3::zeros()),
            |left| (left.eigenvalues.map(f64::sqrt), left.eigenvectors),
        )
    }

    /// Green-Naghdi rate. With `W - Omega = M`, `M_ab = D_ab (v_a - v_b) / (v_a + v_b)` in the principal axes of `V`, the rate is the Jaumann rate plus `M sigma - sigma
    /// M`.
    fn green_naghdi(&self, kirchhoff: f64) -> FourthOrder {
        let jaumann = self.jaumann(kirchhoff);
        let (stretches, axes) = Self::principal(&self.deformation.matrix());
        let products: Vec<Matrix3<f64>> = (0..9)
            .map(|n| {
                let d = axes.transpose() * unit_strain(n / 3, n % 3) * axes;
                let m = Matrix3::from_fn(|a, b| {
                    d[(a, b)] * (stretches[a] - stretches[b]) / (stretches[a] + stretches[b])
                });
                let m = axes * m * axes.transpose();
                m * self.cauchy - self.cauchy * m
            })
            .collect();
        FourthOrder::from_fn(|i, j, k, l| jaumann[(i, j, k, l)] + products[3 * k + l][(i, j)])
    }

    /// Tangent for a rate `h` of `ln V`, where `V` belongs to the last increment.
    ///
    /// In principal axes `V'_ab = h_ab (v_a - v_b) / (ln v_a - ln v_b)`.
    /// At constant rotation `L = V' V^-1`, so that `L_ab = h_ab (e^x - 1) / x` with `x = ln(v_a / v_b)`.
    fn logarithmic(&self) -> FourthOrder {
        let (stretches, axes) = Self::principal(&self.increment);
        composed(&self.gradient, |k, l| {
            let h = axes.transpose() * unit_strain(k, l) * axes;
            let velocity = Matrix3::from_fn(|a, b| {
                h[(a, b)] * difference_quotient((stretches[a] / stretches[b]).ln())
            });
            axes * velocity * axes.transpose()
        })
    }

    /// Tangent per small strain: `F' = epsilon'`, `L = F' F^-1`.
    fn small_strain(&self) -> FourthOrder {
        let inverse = self.inverse();
        composed(&self.gradient, |k, l| unit_strain(k, l) * inverse)
    }

    /// Truesdell tangent, pulled back: `J F^-1 F^-1 c F^-T F^-T`.
    fn second_piola(&self) -> FourthOrder {
        let inverse = self.inverse();
        let jacobian = self.deformation.jacobian();
        // The increment of Green's strain is `dE = F^T D F`.
        let per_strain = composed(&self.truesdell(), |k, l| {
            inverse.transpose() * unit_strain(k, l) * inverse
        });
        FourthOrder::from_fn(|a, b, k, l| {
            let sum: f64 = (0..9)
                .map(|n| {
                    inverse[(a, n / 3)] * inverse[(b, n % 3)] * per_strain[(n / 3, n % 3, k, l)]
                })
                .sum();
            jacobian * sum
        })
    }

    /// First elasticity from `a_ijkl = g_ijkl + sigma_ij delta_kl - sigma_il delta_jk` and `A_iJkL = J F^-1_Jj F^-1_Ll a_ijkl`.
    fn first_piola(&self) -> FourthOrder {
        let sigma = &self.cauchy;
        let spatial = FourthOrder::from_fn(|i, j, k, l| {
            self.gradient[(i, j, k, l)] + sigma[(i, j)] * delta(k, l) - sigma[(i, l)] * delta(j, k)
        });
        spatial.pulled_back(&self.deformation)
    }
}

/// `(e^x - 1) / x`, with the limit 1 at zero.
fn difference_quotient(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.exp_m1() / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use onset::material::{Hyperelastic, ModifiedMooneyRivlin};

    fn response() -> Response {
        let f = DeformationGradient::new([[1.2, 0.3, -0.1], [-0.2, 0.9, 0.15], [0.05, -0.25, 1.1]]);
        let law = ModifiedMooneyRivlin::default();
        law.response(&f.expect("admissible")).expect("finite")
    }

    fn largest_difference(a: &FourthOrder, b: &FourthOrder) -> f64 {
        (0..81)
            .map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
            .map(|at| (a[at] - b[at]).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn conventions_agree_with_the_tangents_of_the_core() {
        let response = response();
        let change = StressChange::of_response(&response);
        let none = FourthOrder::from_fn(|_, _, _, _| 0.0);
        for (convention, known) in [
            (Convention::FirstPiola, response.tangent.clone()),
            (Convention::SecondPiola, response.second_elasticity()),
            (Convention::Truesdell, response.truesdell_tangent()),
            (Convention::NominalGradient, response.effective_tangent()),
            (
                Convention::JaumannKirchhoff,
                onset_umat::jaumann_kirchhoff(&response),
            ),
        ] {
            let tangent = convention.tangent(&change, &none);
            let error = largest_difference(&tangent, &known);
            assert!(error < 1e-12, "{convention:?}: {error:e}");
        }
    }

    #[test]
    fn every_convention_is_found_by_its_name() {
        for convention in Convention::ALL {
            assert_eq!(Convention::of_name(convention.name()), Some(convention));
            let serialized = serde_json::to_value(convention).expect("a word");
            assert_eq!(serialized, convention.name());
        }
    }
}
