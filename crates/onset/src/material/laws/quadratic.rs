//! Quadratic form in Green's strain `E = (C - 1)/2` along material axes that are rotated about the third axis.

use super::super::SmallStrainStiffness;
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::real::Real;

/// Quadratic form `1/2 E : C : E` along material axes.
pub(super) struct QuadraticForm {
    stiffness: SmallStrainStiffness,
    /// Cosine and sine of the angle from the first axis to the first material axis.
    axes: (f64, f64),
}

impl QuadraticForm {
    /// Creates the form from a stiffness along material axes that are rotated by an angle in degrees.
    pub(super) fn new(stiffness: SmallStrainStiffness, degrees: f64) -> Self {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        Self {
            stiffness,
            axes: (cosine, sine),
        }
    }

    /// Energy `1/2 E : C : E` at a deformation gradient.
    pub(super) fn of<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let strain = self.strain(f);
        let along = |a: usize| {
            let row = &self.stiffness[a];
            (0..6)
                .filter(|b| row[*b] != 0.0)
                .fold(R::constant(0.0), |sum, b| sum + strain[b] * row[b])
        };
        (0..6).fold(R::constant(0.0), |sum, a| sum + strain[a] * along(a)) * 0.5
    }

    /// Green's strain along the material axes, `[E11, E22, E33, 2 E23, 2 E13, 2 E12]`.
    fn strain<R: Real>(&self, f: &DeformationGradient<R>) -> [R; 6] {
        let c = f.right_cauchy_green();
        let (cosine, sine) = self.axes;
        let (mean, half) = ((c[0][0] + c[1][1]) * 0.5, (c[0][0] - c[1][1]) * 0.5);
        // In terms of the double angle the strain is exact where C is the unit tensor.
        let (double_cosine, double_sine) = (cosine * cosine - sine * sine, 2.0 * sine * cosine);
        let turned = half * double_cosine + c[0][1] * double_sine;
        [
            (mean + turned - 1.0) * 0.5,
            (mean - turned - 1.0) * 0.5,
            (c[2][2] - 1.0) * 0.5,
            c[1][2] * cosine - c[0][2] * sine,
            c[0][2] * cosine + c[1][2] * sine,
            c[0][1] * double_cosine - half * double_sine,
        ]
    }
}

/// Transforms a stiffness from material axes, rotated by an angle in degrees, to the coordinate axes.
pub(super) fn turned(stiffness: &SmallStrainStiffness, degrees: f64) -> SmallStrainStiffness {
    let (s, c) = degrees.to_radians().sin_cos();
    // Strain along the material axes from strain along the coordinate axes (Bond's matrix for strain).
    let bond = [
        [c * c, s * s, 0.0, 0.0, 0.0, s * c],
        [s * s, c * c, 0.0, 0.0, 0.0, -s * c],
        [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, c, -s, 0.0],
        [0.0, 0.0, 0.0, s, c, 0.0],
        [-2.0 * s * c, 2.0 * s * c, 0.0, 0.0, 0.0, c * c - s * s],
    ];
    let entry = |a: usize, b: usize| {
        let term = |m: usize, n: usize| bond[m][a] * stiffness[m][n] * bond[n][b];
        (0..36).map(|n| term(n / 6, n % 6)).sum()
    };
    array_of(|a| array_of(|b| entry(a, b)))
}

/// Stiffness with three planes of symmetry from `[c11, c22, c33, c23, c13, c12]` and the shear moduli `[c44, c55, c66]`.
pub(super) fn orthotropic(normal: &[f64; 6], shear: &[f64; 3]) -> SmallStrainStiffness {
    let [c11, c22, c33, c23, c13, c12] = *normal;
    let [c44, c55, c66] = *shear;
    [
        [c11, c12, c13, 0.0, 0.0, 0.0],
        [c12, c22, c23, 0.0, 0.0, 0.0],
        [c13, c23, c33, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, c44, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, c55, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, c66],
    ]
}

/// Returns true if a stiffness is positive definite: every strain has positive energy.
pub(super) fn is_positive(stiffness: &SmallStrainStiffness) -> bool {
    let matrix = nalgebra::SMatrix::<f64, 6, 6>::from_fn(|a, b| stiffness[a][b]);
    nalgebra::Cholesky::new(matrix).is_some()
}
