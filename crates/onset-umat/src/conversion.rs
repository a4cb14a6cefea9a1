//! Conversion between the output of a UMAT and `P`, `dP/dF`.

use crate::voigt::{symmetric, tensor_of_voigt, voigt_of_tensor};
use nalgebra::{Matrix3, Matrix6};
use onset::kinematics::DeformationGradient;
use onset::material::{FourthOrder, Response};

/// Stress, tangent and energy in the conventions of a UMAT.
#[derive(Clone, Debug, PartialEq)]
pub struct Delivered {
    /// `STRESS`: the Cauchy stress, in the order 11, 22, 33, 12, 13, 23. Units of stress.
    pub stress: [f64; 6],
    /// `DDSDDE` in mathematical row order, per engineering strain. Units of stress.
    pub ddsdde: Matrix6<f64>,
    /// `SSE`: the strain energy per current volume, `W / J`. Units of stress.
    pub sse: f64,
}

/// Kronecker delta `delta_ij` as a number.
fn delta(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

/// Components `M_ijkl` of `(sigma D + D sigma)_ij = M_ijkl D_kl` for symmetric `D`: the difference between Jaumann and convected rate.
fn symmetric_product(sigma: &Matrix3<f64>, i: usize, j: usize, k: usize, l: usize) -> f64 {
    0.5 * (delta(i, k) * sigma[(l, j)]
        + delta(i, l) * sigma[(k, j)]
        + sigma[(i, k)] * delta(l, j)
        + sigma[(i, l)] * delta(k, j))
}

/// Tangent `A_iJkL = dP_iJ/dF_kL` from `c_ijkl`, the Jaumann rate of the Kirchhoff stress over `J`.
///
/// `tau = J sigma` satisfies `tau' - W tau + tau W = J c : D`. Its convected rate is `tau' - L tau - tau L^T`, smaller than the Jaumann rate by
/// `D tau + tau D`. The Truesdell tangent is therefore
/// `c^T_ijkl = c_ijkl - (delta_ik sigma_lj + delta_il sigma_kj + sigma_ik delta_lj + sigma_il delta_kj) / 2`, the spatial tangent is
/// `a_ijkl = c^T_ijkl + delta_ik sigma_jl`, and `A_iJkL = J F^-1_Jj F^-1_Ll a_ijkl`. Major symmetry is neither required nor enforced.
/// Units of stress.
pub fn tangent_from_jaumann_kirchhoff(
    f: &DeformationGradient,
    cauchy: &Matrix3<f64>,
    c: &FourthOrder,
) -> FourthOrder {
    let spatial = FourthOrder::from_fn(|i, j, k, l| {
        c[(i, j, k, l)] - symmetric_product(cauchy, i, j, k, l) + delta(i, k) * cauchy[(j, l)]
    });
    spatial.pulled_back(f)
}

/// Jaumann rate of the Kirchhoff stress over `J`, the required content of `DDSDDE`. Spatial indices, units of stress.
pub fn jaumann_kirchhoff(response: &Response) -> FourthOrder {
    let truesdell = response.truesdell_tangent();
    let sigma = response.cauchy();
    FourthOrder::from_fn(|i, j, k, l| {
        truesdell[(i, j, k, l)] + symmetric_product(&sigma, i, j, k, l)
    })
}

/// Inverse of a deformation gradient.
fn inverse(f: &DeformationGradient) -> Matrix3<f64> {
    // The determinant of a checked deformation gradient is positive.
    f.matrix().try_inverse().unwrap_or_else(Matrix3::zeros)
}

impl Delivered {
    /// Output required from the UMAT of a law with the given response.
    pub fn of_response(response: &Response) -> Self {
        let cauchy = response.cauchy();
        let stress = crate::voigt::stress_like(&cauchy);
        Self {
            stress: stress.into(),
            ddsdde: voigt_of_tensor(&jaumann_kirchhoff(response)),
            sse: response.energy / response.deformation.jacobian(),
        }
    }

    /// Cauchy stress as a tensor. Spatial indices, units of stress.
    pub fn cauchy(&self) -> Matrix3<f64> {
        symmetric(&self.stress)
    }

    /// Strain energy `W = J SSE` per reference volume at the state `f`. Units of stress.
    pub fn energy(&self, f: &DeformationGradient) -> f64 {
        f.jacobian() * self.sse
    }

    /// Energy, `P = J sigma F^-T`, and `A` from [`tangent_from_jaumann_kirchhoff`], at the state `f`.
    pub fn response(&self, f: &DeformationGradient) -> Response {
        let cauchy = self.cauchy();
        let c = tensor_of_voigt(&self.ddsdde);
        Response {
            deformation: *f,
            energy: self.energy(f),
            first_piola: f.jacobian() * cauchy * inverse(f).transpose(),
            tangent: tangent_from_jaumann_kirchhoff(f, &cauchy, &c),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};

    fn states() -> Vec<DeformationGradient> {
        [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[1.3, 0.2, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.1]],
            [[0.9, 0.4, -0.1], [-0.5, 1.2, 0.2], [0.1, -0.3, 1.0]],
        ]
        .map(|f| DeformationGradient::new(f).expect("admissible"))
        .to_vec()
    }

    fn largest(of: impl Fn(usize, usize, usize, usize) -> f64) -> f64 {
        (0..81)
            .map(|n| of(n / 27, n / 9 % 3, n / 3 % 3, n % 3).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_response_survives_conversion_to_a_umat_and_back() {
        let laws: [&dyn Hyperelastic; 2] = [&BlatzKo::default(), &ModifiedMooneyRivlin::default()];
        for law in laws {
            for f in states() {
                let response = law.response(&f).expect("finite");
                let back = Delivered::of_response(&response).response(&f);
                let (a, b) = (&response.tangent, &back.tangent);
                let scale = largest(|i, j, k, l| a[(i, j, k, l)]);
                let error = largest(|i, j, k, l| a[(i, j, k, l)] - b[(i, j, k, l)]);
                assert!(error < 1e-13 * scale, "{error:e} of {scale}");
                assert!((response.first_piola - back.first_piola).amax() < 1e-13 * scale);
                assert!((response.energy - back.energy).abs() < 1e-15 * scale);
            }
        }
    }

    /// Independent check: the derivative of `tau = J sigma` along `F' = D F` (no spin) is the Jaumann rate itself.
    #[test]
    fn ddsdde_is_the_change_of_kirchhoff_stress_without_spin_over_the_volume_ratio() {
        let law = ModifiedMooneyRivlin::default();
        for f in states() {
            let c = jaumann_kirchhoff(&law.response(&f).expect("finite"));
            let scale = largest(|i, j, k, l| c[(i, j, k, l)]);
            for (k, l) in crate::VOIGT {
                let mut rate = Matrix3::zeros();
                rate[(k, l)] += 0.5;
                rate[(l, k)] += 0.5;
                let kirchhoff = |step: f64| {
                    let moved = (Matrix3::identity() + step * rate) * f.matrix();
                    let components =
                        std::array::from_fn(|i| std::array::from_fn(|j| moved[(i, j)]));
                    let moved = DeformationGradient::new(components).expect("admissible");
                    law.response(&moved).expect("finite").cauchy() * moved.jacobian()
                };
                let h = 1e-3;
                // Fourth-order central differences.
                let difference = ((kirchhoff(h) - kirchhoff(-h)) * 8.0
                    - (kirchhoff(2.0 * h) - kirchhoff(-2.0 * h)))
                    / (12.0 * h * f.jacobian());
                let exact = Matrix3::from_fn(|i, j| c[(i, j, k, l)]);
                let error = (difference - exact).amax();
                assert!(error < 1e-9 * scale, "{error:e} of {scale}");
            }
        }
    }
}
