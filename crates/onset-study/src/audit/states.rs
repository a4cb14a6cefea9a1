//! Default states of an audit, used unless the user gives others.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, Vector3};
use onset::kinematics::{DeformationGradient, KinematicsError};
use serde::Serialize;

/// State with a description of its principal stretches and axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct State {
    /// The deformation gradient, by rows.
    pub deformation_gradient: [[f64; 3]; 3],
    /// Description of equal stretches, and of axes that coincide with the coordinate axes.
    pub position: String,
}

/// Largest relative difference of stretches and components that are considered equal.
const STATE_TOLERANCE: f64 = 1e-9;

impl State {
    /// Describes the state of a deformation gradient.
    pub fn new(f: &DeformationGradient) -> Self {
        let f = f.matrix();
        Self {
            deformation_gradient: std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)])),
            position: position(&f),
        }
    }

    /// Description with the components of `F`.
    pub fn sentence(&self) -> String {
        let rows = self.deformation_gradient.map(|row| row.map(told).join(","));
        format!("{} (F = {})", self.position, rows.join(","))
    }
}

/// A component to six decimal places, without trailing zeros.
fn told(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    format!("{}", rounded + 0.0)
}

fn position(f: &Matrix3<f64>) -> String {
    let left = f * f.transpose();
    let is_small = |value: f64| value.abs() <= STATE_TOLERANCE * left.norm();
    let mut squares = SymmetricEigen::new(left).eigenvalues;
    squares.as_mut_slice().sort_by(f64::total_cmp);
    let gaps = [squares[1] - squares[0], squares[2] - squares[1]];
    let equal = gaps.into_iter().filter(|gap| is_small(*gap)).count();
    let turned = [left[(0, 1)], left[(0, 2)], left[(1, 2)]];
    let turned = turned.into_iter().filter(|value| !is_small(*value)).count();
    let is_turned = (f - f.transpose()).norm() > STATE_TOLERANCE * f.norm();
    let is_isochoric = (f.determinant() - 1.0).abs() <= STATE_TOLERANCE;
    let mut words = vec![match (equal, is_isochoric) {
        (2, true) => "undeformed",
        (2, false) => "pure dilation",
        (1, _) => "two equal stretches",
        _ => "three different stretches",
    }];
    if equal < 2 {
        words.push(match turned {
            0 => "along the axes",
            1 => "one of them along an axis",
            _ => "in turned axes",
        });
        words.extend(is_isochoric.then_some("J = 1"));
    }
    words.extend(is_turned.then_some("rotated"));
    words.join(", ")
}

/// Default states of an audit, with strains of about the given amount.
///
/// Routines branch where stretches are equal and where principal axes coincide with the coordinate axes. The states include each of these cases: the
/// reference configuration, dilations, and two equal or three different stretches, with axes along the coordinate axes, with one axis rotated and
/// with all axes rotated. Each case also occurs with an additional rotation, and at volumes that are smaller, larger and exactly unchanged. The
/// general states are neither aligned nor symmetric nor isochoric, so that no two conventions agree.
///
/// # Errors
/// [`KinematicsError`] when the strain is so large that matter is turned inside out.
///
/// ```
/// let states = onset_study::audit::states(0.2)?;
/// assert_eq!(states[0], onset::kinematics::DeformationGradient::identity());
/// assert!((states[1].jacobian() - 1.2_f64.powi(3)).abs() < 1e-15);
/// # Ok::<(), onset::kinematics::KinematicsError>(())
/// ```
pub fn states(strain: f64) -> Result<Vec<DeformationGradient>, KinematicsError> {
    let one: Matrix3<f64> = Matrix3::identity();
    let along =
        |a: f64, b: f64, c: f64| one + strain * Matrix3::from_diagonal(&Vector3::new(a, b, c));
    let shear = |i: usize, j: usize| {
        let mut sheared = one;
        sheared[(i, j)] = strain;
        sheared
    };
    let general = Matrix3::new(0.9, 0.6, -0.3, 0.2, -0.7, 0.5, 0.1, -0.2, 0.4);
    let volume = Matrix3::new(0.5, 0.0, 0.0, 0.0, 0.4, 0.8, 0.0, 0.0, 0.6);
    let rotation = *Rotation3::from_euler_angles(0.7, -0.4, 1.1).matrix();
    let axes = *Rotation3::from_euler_angles(-0.5, 0.8, 0.3).matrix();
    let quarter = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let turned = |stretch: Matrix3<f64>| axes * stretch * axes.transpose();
    let isochoric = |f: Matrix3<f64>| f / f.determinant().cbrt();
    // Reciprocals instead of a scaling: the product of these stretches is one to the last bit.
    let longer = 1.0 + strain;
    let shorter = 1.0 / longer;
    let general_isochoric = isochoric(one + strain * general);
    let unit = |i: usize| Vector3::from_fn(|j, _| f64::from(u8::from(i == j)));
    let uniaxial = |i: usize| one + strain * Matrix3::from_diagonal(&unit(i));
    let about = |i: usize, stretch: Matrix3<f64>| {
        let turn = Rotation3::new(0.4 * unit(i)).into_inner();
        turn * stretch * turn.transpose()
    };
    let mut all = vec![
        one,
        along(1.0, 1.0, 1.0),
        along(-1.0, -1.0, -1.0),
        rotation,
        rotation * along(1.0, 1.0, 1.0),
        along(1.0, 0.3, -0.6),
        along(-0.5, 0.4, 1.0),
        along(-0.2, -1.0, -0.6),
        Matrix3::from_diagonal(&Vector3::new(longer, shorter, 1.0)),
        Matrix3::from_diagonal(&Vector3::new(shorter * shorter, longer, longer)),
        quarter * along(1.0, 0.3, -0.6),
        rotation * along(1.0, 0.0, 0.0),
        one + strain * volume,
        turned(along(1.0, 0.0, 0.0)),
        turned(along(1.0, 1.0, 0.0)),
        rotation * turned(along(0.4, -0.6, -0.6)),
        turned(along(1.0, 0.3, -0.6)),
        one + strain * general,
        rotation * (one - strain * general),
        general_isochoric,
    ];
    for i in 0..3 {
        let other = (i + 1) % 3;
        all.extend([
            uniaxial(i),
            2.0 * one - uniaxial(i),
            along(1.0, 1.0, 1.0) + one - uniaxial(i),
            shear(i.min(other), i.max(other)),
            about(i, uniaxial(other)),
            about(i, along(1.0, 0.3, -0.6)),
        ]);
    }
    all.iter().map(super::subject::deformation).collect()
}

#[cfg(test)]
mod tests {
    use super::states;

    #[test]
    fn each_axis_is_stretched_alone_and_turned_about_with_equal_stretches() {
        let all = states(0.1).expect("states");
        let small = |x: f64| x.abs() < 1e-12;
        for axis in 0..3 {
            let others = [(axis + 1) % 3, (axis + 2) % 3];
            let is_alone = |f: &[[f64; 3]; 3]| {
                let off = (0..9).filter(|n| n / 3 != n % 3);
                off.clone().all(|n| small(f[n / 3][n % 3]))
                    && others.iter().all(|i| small(f[*i][*i] - 1.0))
                    && f[axis][axis] > 1.0
            };
            let is_turned_about = |f: &[[f64; 3]; 3]| {
                let [j, k] = others;
                let along = [f[axis][j], f[axis][k], f[j][axis], f[k][axis]];
                along.into_iter().all(small) && !small(f[j][k]) && small(f[j][k] - f[k][j])
            };
            let has = |is: &dyn Fn(&[[f64; 3]; 3]) -> bool| all.iter().any(|f| is(f.components()));
            assert!(has(&is_alone), "axis {axis}");
            let equal = |f: &[[f64; 3]; 3]| is_turned_about(f) && small(f[axis][axis] - 1.0);
            assert!(has(&equal), "axis {axis}");
        }
    }
}
