//! Increments of deformation as Abaqus passes them to a UMAT, and the path that leads to a state.

use crate::error::UmatError;
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};
use onset::kinematics::DeformationGradient;

/// Increment from one deformation gradient to the next, `dF = F_end F_start^-1 = dV dR`.
#[derive(Clone, Debug, PartialEq)]
pub struct Increment {
    /// `DFGRD0`, the deformation gradient at the start.
    pub start: Matrix3<f64>,
    /// `DFGRD1`, the deformation gradient at the end.
    pub end: Matrix3<f64>,
    /// `DROT`, the rotation `dR`.
    pub rotation: Matrix3<f64>,
    /// `DSTRAN`, the logarithmic strain `ln dV` in the axes at the end of the increment; a tensor, without factor 2 on shear.
    pub strain: Matrix3<f64>,
}

impl Increment {
    /// Increment between two deformation gradients; `None` if they are not invertible.
    pub fn between(start: Matrix3<f64>, end: Matrix3<f64>) -> Option<Self> {
        let relative = end * start.try_inverse()?;
        let left = spectral(&(relative * relative.transpose()))?;
        let stretch = left.map(|square| square.sqrt());
        Some(Self {
            start,
            end,
            rotation: stretch.try_inverse()? * relative,
            strain: left.map(|square| 0.5 * square.ln()),
        })
    }
}

/// Rotation and right stretch of `F = R U`; `None` if `F` is not invertible.
pub(crate) fn polar(f: &Matrix3<f64>) -> Option<(Matrix3<f64>, Matrix3<f64>)> {
    let right = spectral(&(f.transpose() * f))?;
    let inverse = right.map(|square| 1.0 / square.sqrt());
    Some((f * inverse, right.map(f64::sqrt)))
}

/// Axis of a rotation times its angle.
pub(crate) fn rotation_vector(rotation: &Matrix3<f64>) -> [f64; 3] {
    let rotation = Rotation3::from_matrix_unchecked(*rotation);
    UnitQuaternion::from_rotation_matrix(&rotation)
        .scaled_axis()
        .into()
}

/// Symmetric tensor in its principal axes.
struct Spectral(SymmetricEigen<f64, nalgebra::U3>);

fn spectral(tensor: &Matrix3<f64>) -> Option<Spectral> {
    SymmetricEigen::try_new(*tensor, f64::EPSILON, 500).map(Spectral)
}

impl Spectral {
    /// Tensor with a function applied to the principal values.
    fn map(&self, function: impl Fn(f64) -> f64) -> Matrix3<f64> {
        let values = self.0.eigenvalues.map(function);
        let axes = &self.0.eigenvectors;
        axes * Matrix3::from_diagonal(&values) * axes.transpose()
    }
}

/// Proportional path from the identity to `F = R U`, with `F(t) = R^t U^t` at `t = 1/n, 2/n, ..., 1`.
///
/// Stretch and rotation grow in proportion: the logarithmic strain is `t ln U`. The last state is exactly `F`.
///
/// # Errors
/// [`UmatError::Increments`] if `n` is zero.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// let f = DeformationGradient::from_stretches([1.44, 0.81, 1.0])?;
/// let path = onset_umat::proportional_path(&f, 2)?;
/// assert!((path[0][(0, 0)] - 1.2).abs() < 1e-14 && (path[0][(1, 1)] - 0.9).abs() < 1e-14);
/// assert_eq!(path[1], f.matrix());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn proportional_path(
    f: &DeformationGradient,
    increments: u32,
) -> Result<Vec<Matrix3<f64>>, UmatError> {
    let end = f.matrix();
    let mut path = Vec::with_capacity(increments as usize);
    if increments > 1 {
        let not_invertible = || UmatError::Increments { increments };
        let right = spectral(&(end.transpose() * end)).ok_or_else(not_invertible)?;
        let (rotation, _) = polar(&end).ok_or_else(not_invertible)?;
        let rotation = Rotation3::from_matrix_unchecked(rotation);
        let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
        for step in 1..increments {
            let part = f64::from(step) / f64::from(increments);
            let turned = rotation.powf(part).to_rotation_matrix();
            path.push(turned.matrix() * right.map(|square| square.powf(0.5 * part)));
        }
    }
    if increments == 0 {
        return Err(UmatError::Increments { increments });
    }
    path.push(end);
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> DeformationGradient {
        DeformationGradient::new([[1.2, 0.3, -0.1], [-0.2, 0.9, 0.15], [0.05, -0.25, 1.1]])
            .expect("admissible")
    }

    #[test]
    fn rotation_and_logarithmic_strain_of_an_increment_compose_the_deformation() {
        let start = Matrix3::new(1.1, 0.2, 0.0, -0.1, 0.9, 0.1, 0.0, 0.0, 1.0);
        let increment = Increment::between(start, state().matrix()).expect("invertible");
        let rotation = increment.rotation;
        assert!((rotation * rotation.transpose() - Matrix3::identity()).amax() < 1e-14);
        // The stretch of the increment, exp(strain), as a power series.
        let (mut stretch, mut term): (Matrix3<f64>, Matrix3<f64>) =
            (Matrix3::identity(), Matrix3::identity());
        for n in 1..30 {
            term = term * increment.strain / f64::from(n);
            stretch += term;
        }
        assert!((stretch * rotation * start - state().matrix()).amax() < 1e-14);
    }

    #[test]
    fn all_increments_of_a_proportional_path_have_equal_strain_and_rotation() {
        let path = proportional_path(&state(), 7).expect("a path");
        assert_eq!(path.len(), 7);
        assert_eq!(path[6], state().matrix());
        let mut start = Matrix3::identity();
        let whole = Increment::between(start, path[6]).expect("invertible");
        let mut sum: Matrix3<f64> = Matrix3::zeros();
        let mut turned: Matrix3<f64> = Matrix3::identity();
        for end in path {
            let increment = Increment::between(start, end).expect("invertible");
            // Abaqus rotates the strain before it adds the increment.
            sum = increment.rotation * sum * increment.rotation.transpose() + increment.strain;
            turned = increment.rotation * turned;
            start = end;
        }
        assert!((sum - whole.strain).amax() < 1e-13);
        assert!((turned - whole.rotation).amax() < 1e-13);
    }
}
