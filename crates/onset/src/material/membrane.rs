//! Two-dimensional laws: membranes and cloth without thickness.

use super::{FourthOrder, Hyperelastic, MaterialError, Response, ResponseEnclosure};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::real::Interval;
use nalgebra::Matrix3;
use std::sync::Arc;

/// Two-dimensional law: an energy of the 2 x 2 deformation gradient, without an out-of-plane direction.
///
/// The energy is the energy of a three-dimensional law at `F_33 = 1` without out-of-plane shears, or a formula in the invariants of the 2 x 2 tensor
/// ([`Formula::parse_in_plane`](crate::formula::Formula::parse_in_plane)). Increments stay in the plane: out-of-plane stress and tangent are zero.
///
/// ```
/// use onset::formula::Formula;
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, Membrane};
/// let cloth = Formula::parse_in_plane("(I1 - 2)/2 - ln(J) + (J - 1)^2")?.with(&[])?;
/// let cloth = Membrane::new(std::sync::Arc::new(cloth));
/// let response = cloth.response(&DeformationGradient::from_stretches([1.2, 1.0, 1.0])?)?;
/// // P_11 = F_11 - 1/F_11 + 2 (J - 1) F_22
/// assert!((response.first_piola[(0, 0)] - (1.2 - 1.0 / 1.2 + 0.4)).abs() < 1e-14);
/// assert!(response.first_piola[(2, 2)] == 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Membrane {
    law: Arc<dyn Hyperelastic>,
}

impl Membrane {
    /// Creates the two-dimensional law from a three-dimensional one.
    pub fn new(law: Arc<dyn Hyperelastic>) -> Self {
        Self { law }
    }
}

/// Returns true for indices within the plane.
fn is_within(indices: &[usize]) -> bool {
    indices.iter().all(|index| *index < 2)
}

impl Hyperelastic for Membrane {
    fn dimension(&self) -> usize {
        2
    }

    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let response = self.law.response(&f.given_in(2))?;
        Ok(Response {
            first_piola: Matrix3::from_fn(|i, j| match is_within(&[i, j]) {
                true => response.first_piola[(i, j)],
                false => 0.0,
            }),
            tangent: FourthOrder::from_fn(|i, j, k, l| match is_within(&[i, j, k, l]) {
                true => response.tangent[(i, j, k, l)],
                false => 0.0,
            }),
            ..response
        })
    }

    fn enclosure(&self, f: &DeformationGradient<Interval>) -> ResponseEnclosure {
        let within = DeformationGradient::from_components(array_of(|i| {
            array_of(|j| match is_within(&[i, j]) {
                true => f.components()[i][j],
                false => Interval::point(f64::from(u8::from(i == j))),
            })
        }));
        let space = self.law.enclosure(&within);
        let kept = |indices: &[usize], value: Interval| match is_within(indices) {
            true => value,
            false => Interval::ZERO,
        };
        ResponseEnclosure {
            energy: space.energy,
            first_piola: array_of(|i| array_of(|j| kept(&[i, j], space.first_piola[i][j]))),
            tangent: array_of(|i| {
                array_of(|j| {
                    array_of(|k| array_of(|l| kept(&[i, j, k, l], space.tangent[i][j][k][l])))
                })
            }),
        }
    }
}
