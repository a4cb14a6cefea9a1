//! Artificial stress against the tensile instability of SPH.

use crate::algebra::{MAXIMUM_ITERATIONS, array_of};
use crate::method::MethodError;
use crate::real::Real;
use nalgebra::DMatrix;

use super::super::layout::assert_positive;
use super::assert_coefficients;

/// Artificial stress of Gray, Monaghan and Swift, an added pair repulsion in tension.
///
/// The stress of each particle of a pair changes by `-epsilon (W_IJ / W(spacing))^n` times its tensile part,
/// `[sigma]_+ = sum_a max(sigma_a, 0) n_a (x) n_a` in principal stresses.
/// A principal stress that is zero to rounding is not tensile: the linearization takes the compressive side.
///
/// Source: Gray, Monaghan, Swift, Comput. Methods Appl. Mech. Engrg. 190 (2001) 6641, with `epsilon = 0.3`, `n = 4`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct ArtificialStress {
    /// Coefficient `epsilon`; dimensionless, zero for no artificial stress.
    pub epsilon: f64,
    /// Exponent `n` of the kernel ratio.
    pub exponent: f64,
    /// Distance at which the kernel ratio is one, usually the neighbor distance in the reference configuration; length.
    pub spacing: f64,
}

impl Default for ArtificialStress {
    fn default() -> Self {
        Self {
            epsilon: 0.3,
            exponent: 4.0,
            spacing: 1.0,
        }
    }
}

impl ArtificialStress {
    /// Rejects coefficients that are out of range.
    pub(in super::super) fn assert_admissible(&self) -> Result<(), MethodError> {
        assert_coefficients(&[
            ("artificial-stress", self.epsilon),
            ("artificial-stress-exponent", self.exponent),
        ])?;
        assert_positive(&[("artificial-stress.spacing", self.spacing)])
    }
}

/// Artificial stress of the particles of a state.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Repulsion {
    pub(in super::super) epsilon: f64,
    pub(in super::super) exponent: f64,
    /// Kernel value `W(spacing)`; 1/length^D.
    pub(in super::super) weight_at_spacing: f64,
    /// Principal stresses below this threshold count as zero.
    pub(in super::super) threshold: f64,
}

impl Repulsion {
    /// Factor `epsilon (W / W(spacing))^n` of the tensile part; zero outside of the support.
    pub(in super::super) fn factor<R: Real>(&self, weight: R) -> R {
        let within = || (weight / self.weight_at_spacing).powf(self.exponent) * self.epsilon;
        weight.switch(f64::MIN_POSITIVE, || R::constant(0.0), within)
    }

    /// Tensile part `[sigma]_+` of a stress.
    ///
    /// In the directions of principal stresses `a`, `b` the derivative is the derivative of `[.]_+` if they are equal, and otherwise its difference
    /// quotient (Daleckii and Krein).
    pub(in super::super) fn tensile_part<R: Real, const D: usize>(
        &self,
        stress: &[[R; D]; D],
    ) -> [[R; D]; D] {
        let not_a_number = [[R::constant(f64::NAN); D]; D];
        let value = DMatrix::from_fn(D, D, |i, j| {
            0.5 * (stress[i][j].value() + stress[j][i].value())
        });
        if value.iter().any(|entry| !entry.is_finite()) {
            return not_a_number;
        }
        let Some(eigen) = value.try_symmetric_eigen(f64::EPSILON, MAXIMUM_ITERATIONS) else {
            return not_a_number;
        };
        let (principal, axes) = (eigen.eigenvalues, eigen.eigenvectors);
        let tension = |a: usize| {
            if principal[a] > self.threshold {
                principal[a]
            } else {
                0.0
            }
        };
        let slope = |a: usize, b: usize| {
            let apart = principal[a] - principal[b];
            if apart.abs() > self.threshold {
                (tension(a) - tension(b)) / apart
            } else {
                f64::from(u8::from(principal[a] > self.threshold))
            }
        };
        // The change has the value zero and carries the derivatives, here along the principal axes.
        let rotated = |a: usize, b: usize| {
            let mut sum = R::constant(if a == b { tension(a) } else { 0.0 });
            for (i, row) in stress.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    let factor = axes[(i, a)] * axes[(j, b)] * slope(a, b);
                    sum = sum + (*entry - entry.value()) * factor;
                }
            }
            sum
        };
        let along: [[R; D]; D] = array_of(|a| array_of(|b| rotated(a, b)));
        array_of(|i| {
            array_of(|j| {
                let mut sum = R::constant(0.0);
                for (a, row) in along.iter().enumerate() {
                    for (b, entry) in row.iter().enumerate() {
                        sum = sum + *entry * (axes[(i, a)] * axes[(j, b)]);
                    }
                }
                sum
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Repulsion;
    use crate::real::Dual;

    #[test]
    fn the_tensile_part_and_its_derivative_follow_from_principal_stresses() {
        let repulsion = Repulsion {
            epsilon: 1.0,
            exponent: 4.0,
            weight_at_spacing: 1.0,
            threshold: 1e-12,
        };
        let at = |[a, b, c]: [f64; 3]| repulsion.tensile_part(&[[a, c], [c, b]]);
        let state = [1.3, -0.4, 0.6];
        let dual = {
            let [a, b, c] = Dual::<3>::variables(state);
            repulsion.tensile_part(&[[a, c], [c, b]])
        };
        let part = at(state);
        // The tensile and the compressive part add up to the stress and do not overlap.
        let opposite = at(state.map(|x| -x));
        assert!((part[0][1] - opposite[0][1] - 0.6).abs() < 1e-14);
        let product = part[0][0] * opposite[0][0] + part[0][1] * opposite[0][1];
        assert!(product.abs() < 1e-14);
        for n in 0..3 {
            let shifted = |h: f64| {
                let mut moved = state;
                moved[n] += h;
                at(moved)
            };
            let (plus, minus) = (shifted(1e-6), shifted(-1e-6));
            for i in 0..2 {
                for j in 0..2 {
                    let slope = (plus[i][j] - minus[i][j]) / 2e-6;
                    assert!((dual[i][j].gradient[n] - slope).abs() < 1e-9);
                }
            }
        }
    }
}
