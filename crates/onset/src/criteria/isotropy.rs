//! Isotropic laws: a numerical test of isotropy, and the tangent in principal axes.

use super::{Witness, oriented, wave};
use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::material::{
    FourthOrder, Hyperelastic, MaterialError, Response, bulk_modulus_above, cofactor,
};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Largest difference, relative to their magnitude, of stresses that count as equal after a rotation of the reference configuration.
const TOLERANCE: f64 = 1e-9;

/// Relative rounding error of a deformation gradient that is multiplied by a rotation, and of the invariants computed from it.
const ROTATION_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Returns true if a law is isotropic: `P(F Q) = P(F) Q` to rounding.
///
/// The condition is tested at deformations without symmetry, with rotations about axes without symmetry. Half of the deformations preserve the
/// volume, since the stress of a nearly incompressible law overflows at most others. Rounding of `F` enters the comparison through the tangent.
///
/// ```
/// use onset::material::BlatzKo;
/// assert!(onset::criteria::is_isotropic(&BlatzKo::default()));
/// ```
pub fn is_isotropic(material: &dyn Hyperelastic) -> bool {
    let axes = [
        Vector3::new(0.36, 0.48, 0.8),
        Vector3::new(-0.6, 0.64, 0.48),
        Vector3::new(0.2, -0.3, 0.5),
        Vector3::new(0.9, 0.1, -0.4),
    ];
    let mut answered = false;
    // A law may be defined near the reference configuration only.
    for size in [0.2, 0.05] {
        let stretches = [
            Vector3::new(1.0 + size, 1.0 + 0.3 * size, 1.0 - 0.5 * size),
            Vector3::new(1.0 - size, 1.0 + 0.6 * size, 1.0 + 0.1 * size),
            Vector3::new(1.0 + 0.9 * size, 1.0 + 0.5 * size, 1.0 + 0.2 * size),
            Vector3::new(1.0 - 0.9 * size, 1.0 - 0.4 * size, 1.0 - 0.2 * size),
        ];
        let isochoric = stretches.map(|stretch: Vector3<f64>| stretch / stretch.product().cbrt());
        let states = stretches.iter().chain(&isochoric);
        for (stretch, turned) in states.zip(axes.iter().cycle()) {
            let f = Matrix3::from_diagonal(stretch);
            let Ok(straight) = respond(material, &f) else {
                continue;
            };
            let rounding = ROTATION_ROUNDING * straight.tangent.largest() * stretch.amax();
            for axis in &axes {
                let rotation = Rotation3::from_scaled_axis((axis + turned) * 0.9).into_inner();
                let other = match respond(material, &(f * rotation)) {
                    Ok(other) => other,
                    Err(MaterialError::NotFinite { .. }) => continue,
                    Err(_) => return false,
                };
                let expected = straight.first_piola * rotation;
                let size = other.first_piola.amax() + expected.amax();
                if (other.first_piola - expected).amax() > TOLERANCE * size + rounding {
                    return false;
                }
                answered = true;
            }
        }
    }
    answered
}

/// Returns true if the energy of a law is consistent with its stress: along a stretch and a shear the energy rises by the work of the stress.
///
/// For nearly incompressible laws, whose stress may vary by orders of magnitude along this path, the same path at constant volume is sufficient. User
/// subroutines often provide no energy.
pub fn has_energy(material: &dyn Hyperelastic) -> bool {
    let step = Matrix3::new(0.06, 0.03, 0.0, -0.01, -0.02, 0.02, 0.0, 0.01, 0.03);
    // Deformation gradient at `t` with its derivative.
    let place = |t: f64, preserves_volume: bool| {
        let f = Matrix3::identity() + step * t;
        if !preserves_volume {
            return (f, step);
        }
        let inverse = cofactor(&f).transpose() / f.determinant();
        let size = f.determinant().cbrt();
        (
            f / size,
            (step - f * ((inverse * step).trace() / 3.0)) / size,
        )
    };
    let is_consistent = |preserves_volume: bool| {
        let at = |t: f64| {
            let (f, rate) = place(t, preserves_volume);
            let response = respond(material, &f)?;
            Ok::<(f64, f64), MaterialError>((response.energy, response.first_piola.dot(&rate)))
        };
        let ((start, first), (_, second), (end, third)) = (at(0.5)?, at(0.75)?, at(1.0)?);
        // Simpson's rule; its error is of fifth order in the step.
        let work = (first + 4.0 * second + third) * 0.5 / 6.0;
        Ok::<bool, MaterialError>((end - start - work).abs() <= 1e-2 * work.abs())
    };
    is_consistent(false).unwrap_or(false)
        || bulk_modulus_above(material, STIFF).is_some() && is_consistent(true).unwrap_or(false)
}

fn respond(material: &dyn Hyperelastic, f: &Matrix3<f64>) -> Result<Response, MaterialError> {
    let components = array_of(|i| array_of(|j| f[(i, j)]));
    material.response(&DeformationGradient::from_components(components))
}

/// Smallest ratio of bulk to shear modulus of a nearly incompressible law, whose stress may vary too much with the volume for a comparison of work
/// and energy.
const STIFF: f64 = 30.0;

/// Relative tolerance for the symmetry of a tangent. Tangents of laws that are integrated in time, or of user subroutines, are less accurate than
/// rounding.
const SYMMETRIC: f64 = 1e-6;

/// Tangent of an isotropic law in principal axes. All components not listed vanish.
#[derive(Clone, Debug)]
pub(super) struct PrincipalTangent {
    /// Normal components `A_iijj = d^2 W / dlambda_i dlambda_j` of the tangent.
    normal: Matrix3<f64>,
    /// Off-diagonal components `A_ijij`.
    shear: Matrix3<f64>,
    /// Off-diagonal components `A_ijji`.
    cross: Matrix3<f64>,
    left: Matrix3<f64>,
    right: Matrix3<f64>,
}

impl PrincipalTangent {
    pub(super) fn of(tangent: &FourthOrder, left: &Matrix3<f64>, right: &Matrix3<f64>) -> Self {
        let aligned = *left == Matrix3::identity() && *right == Matrix3::identity();
        let component = |i: usize, j: usize, k: usize, l: usize| {
            if aligned {
                return tangent[(i, j, k, l)];
            }
            let mut sum = 0.0;
            for (a, b) in (0..9).map(|n| (n / 3, n % 3)) {
                let first = left[(a, i)] * right[(b, j)];
                for (c, d) in (0..9).map(|n| (n / 3, n % 3)) {
                    sum += first * left[(c, k)] * right[(d, l)] * tangent[(a, b, c, d)];
                }
            }
            sum
        };
        Self {
            normal: Matrix3::from_fn(|i, j| component(i, i, j, j)),
            shear: Matrix3::from_fn(|i, j| component(i, j, i, j)),
            cross: Matrix3::from_fn(|i, j| component(i, j, j, i)),
            left: *left,
            right: *right,
        }
    }

    /// Returns true if `A_iijj = A_jjii` and `A_ijij = A_jiji` within the tolerance, as for every law with an energy.
    pub(super) fn has_major_symmetry(&self) -> bool {
        let asymmetry = |part: &Matrix3<f64>| (part - part.transpose()).amax();
        let largest = self.normal.amax().max(self.shear.amax());
        asymmetry(&self.normal).max(asymmetry(&self.shear)) <= SYMMETRIC * largest
    }

    /// Smallest `A_ijij`, `i != j`, with its wave.
    pub(super) fn softest_shear(&self) -> (f64, Witness) {
        let pairs = (0..9).map(|n| (n / 3, n % 3)).filter(|(i, j)| i != j);
        let (i, j) = pairs.fold((0, 1), |best, pair| {
            if self.shear[pair] < self.shear[best] {
                pair
            } else {
                best
            }
        });
        let witness = self.wave(&Vector3::ith(j, 1.0), &Vector3::ith(i, 1.0));
        (self.shear[(i, j)], witness)
    }

    /// Smallest `(T_i - T_j) / (lambda_i - lambda_j) = A_ijij + A_ijji`, with its shear.
    pub(super) fn softest_force(&self) -> (f64, Witness) {
        let value = |(i, j): (usize, usize)| self.shear[(i, j)] + self.cross[(i, j)];
        let pairs = [(0, 1), (0, 2), (1, 2)];
        let (i, j) = pairs.into_iter().fold((0, 1), |best, pair| {
            if value(pair) < value(best) {
                pair
            } else {
                best
            }
        });
        let witness = self.wave(&Vector3::ith(j, 1.0), &Vector3::ith(i, 1.0));
        (value((i, j)), witness)
    }

    /// Smallest value of the strong ellipticity form, with its wave.
    ///
    /// With `x_i = g_i N_i` the form is `sum W_ij x_i x_j + sum_{i != j} (A_ijij g_i^2 N_j^2 + A_ijji x_i x_j)`, and
    /// `g_i^2 N_j^2 + g_j^2 N_i^2 >= 2 |x_i x_j|` holds with equality for `|g_i| = |N_i|`. The form is therefore positive for all waves if and only
    /// if the shear stiffnesses are positive and, for all signs of the `x_i`, a quadratic form is positive on the simplex of the `|x_i|`.
    pub(super) fn softest_wave(&self) -> (f64, Witness) {
        let mut lowest = self.softest_shear();
        for signs in [
            Vector3::new(1.0, 1.0, 1.0),
            Vector3::new(1.0, 1.0, -1.0),
            Vector3::new(1.0, -1.0, 1.0),
            Vector3::new(-1.0, 1.0, 1.0),
        ] {
            let matrix = Matrix3::from_fn(|i, j| {
                if i == j {
                    self.normal[(i, i)]
                } else {
                    let shear = 0.5 * (self.shear[(i, j)] + self.shear[(j, i)]);
                    signs[i] * signs[j] * (self.normal[(i, j)] + self.cross[(i, j)]) + shear
                }
            });
            let (value, x) = minimum_on_simplex(&matrix);
            if value < lowest.0 {
                let direction = x.map(f64::sqrt);
                let polarization = direction.component_mul(&signs);
                lowest = (value, self.wave(&direction, &polarization));
            }
        }
        lowest
    }

    /// Smallest value of the strong ellipticity form over volume-preserving waves, with its wave.
    ///
    /// These waves satisfy `g . F^-T N = sum x_i / lambda_i = 0`. Shears with `g` and `N` along different axes satisfy it. For the other waves the
    /// splitting of [`PrincipalTangent::softest_wave`] leaves the signs for which the sum can vanish. On the simplex this is a segment, where the
    /// form is a quadratic function of one variable. These are the conditions of Zee and Sternberg, Arch. Ration. Mech. Anal. 83 (1983) 53.
    pub(super) fn softest_isochoric_wave(&self, stretches: &Vector3<f64>) -> (f64, Witness) {
        let mut lowest = self.softest_shear();
        for odd in 0..3 {
            let ends = [(odd + 1) % 3, (odd + 2) % 3]
                .each(|other| Self::isochoric_vertex(stretches, other, odd));
            let (value, wave) = self.lowest_between(&ends);
            if value < lowest.0 {
                lowest = (value, wave);
            }
        }
        lowest
    }

    /// Smallest value of the strong ellipticity form over volume-preserving waves in the plane of the two principal axes other than the third
    /// coordinate axis.
    pub(super) fn softest_isochoric_wave_in_plane(
        &self,
        stretches: &Vector3<f64>,
    ) -> (f64, Witness) {
        let out = self.right.row(2).map(f64::abs).transpose().imax();
        let (i, j) = ((out + 1) % 3, (out + 2) % 3);
        let shears = [(i, j), (j, i)];
        let softest = if self.shear[shears[0]] <= self.shear[shears[1]] {
            shears[0]
        } else {
            shears[1]
        };
        let shear = self.wave(&Vector3::ith(softest.1, 1.0), &Vector3::ith(softest.0, 1.0));
        let vertex = Self::isochoric_vertex(stretches, i, j);
        let (value, wave) = self.lowest_between(&[vertex, vertex]);
        match value < self.shear[softest] {
            true => (value, wave),
            false => (self.shear[softest], shear),
        }
    }

    /// Vertex `x` with positive `x_i`, negative `x_j` and zero otherwise that satisfies `sum x_i / lambda_i = 0` and `sum |x_i| = 1`.
    fn isochoric_vertex(stretches: &Vector3<f64>, i: usize, j: usize) -> Vector3<f64> {
        let sum = stretches[i] + stretches[j];
        let mut x = Vector3::zeros();
        x[i] = stretches[i] / sum;
        x[j] = -stretches[j] / sum;
        x
    }

    /// Smallest value of the form on the segment between two `x` whose components have equal signs, with its wave.
    fn lowest_between(&self, ends: &[Vector3<f64>; 2]) -> (f64, Witness) {
        let signs = (ends[0] + ends[1]).map(|x| if x < 0.0 { -1.0 } else { 1.0 });
        let matrix = Matrix3::from_fn(|i, j| {
            if i == j {
                return self.normal[(i, i)];
            }
            let shear = 0.5 * (self.shear[(i, j)] + self.shear[(j, i)]);
            (self.normal[(i, j)] + self.cross[(i, j)]) + signs[i] * signs[j] * shear
        });
        let along = ends[1] - ends[0];
        let curvature = along.dot(&(matrix * along));
        let slope = along.dot(&(matrix * ends[0]));
        let inside = (curvature > 0.0).then(|| (-slope / curvature).clamp(0.0, 1.0));
        let places = [Some(0.0), Some(1.0), inside].into_iter().flatten();
        let at = |t: f64| ends[0] + along * t;
        let (value, x) = places.map(at).map(|x| (x.dot(&(matrix * x)), x)).fold(
            (f64::INFINITY, ends[0]),
            |best, next| {
                if next.0 < best.0 { next } else { best }
            },
        );
        let direction = x.map(|x| x.abs().sqrt());
        (
            value,
            self.wave(&direction, &direction.component_mul(&signs)),
        )
    }

    /// Smallest measure of [`Criterion::Surface`](super::Criterion::Surface) over waves along principal axes at faces normal to the coordinate axes
    /// `faces`. Faces whose normal is not a principal axis are ignored; `None` if no face remains.
    pub(super) fn softest_surface_wave(
        &self,
        stretches: &Vector3<f64>,
        faces: &[usize],
    ) -> Option<(f64, Witness)> {
        let is_along =
            |axis: usize, face: usize| (self.right[(face, axis)].abs() - 1.0).abs() < 1e-9;
        let of_face = |face: usize| (0..3).find(|axis| is_along(*axis, face));
        let mut lowest: Option<(f64, Witness)> = None;
        for j in faces.iter().filter_map(|face| of_face(*face)) {
            for i in [(j + 1) % 3, (j + 2) % 3] {
                let (a, b) = (stretches[i], stretches[j]);
                // Moduli pushed forward along the axes, with J = 1.
                let alpha = a * a * self.shear[(j, i)];
                let gamma = b * b * self.shear[(i, j)];
                let twice_beta = a * a * self.normal[(i, i)] + b * b * self.normal[(j, j)]
                    - 2.0 * a * b * (self.normal[(i, j)] + self.cross[(i, j)]);
                let value = (a / b) * (twice_beta + 2.0 * gamma) + alpha - gamma;
                if lowest.is_none_or(|lowest| value < lowest.0) {
                    let axis = |n: usize| oriented(&self.right.column(n).into_owned());
                    let (normal, direction) = (axis(j), axis(i));
                    lowest = Some((value, Witness::SurfaceWave { normal, direction }));
                }
            }
        }
        lowest
    }

    /// Wave with the given components in principal axes.
    fn wave(&self, direction: &Vector3<f64>, polarization: &Vector3<f64>) -> Witness {
        wave(&(self.right * direction), &(self.left * polarization))
    }
}

/// Smallest `x . M x` over `x_i >= 0`, `sum x_i = 1`, with the minimizing `x`. `M` is symmetric.
fn minimum_on_simplex(m: &Matrix3<f64>) -> (f64, Vector3<f64>) {
    let corner = |i: usize| Vector3::ith(i, 1.0);
    // Along an edge and within the simplex the form is stationary where M x is equal in all nonzero components of x.
    let edge = |i: usize, j: usize| {
        let t = (m[(j, j)] - m[(i, j)]) / (m[(i, i)] + m[(j, j)] - 2.0 * m[(i, j)]);
        corner(i) * t + corner(j) * (1.0 - t)
    };
    let minor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[(a, c)] * m[(b, d)] - m[(a, d)] * m[(b, c)]
    };
    let within = Vector3::from_fn(|i, _| minor(i, 0) + minor(i, 1) + minor(i, 2));
    let candidates = [
        corner(0),
        corner(1),
        corner(2),
        edge(0, 1),
        edge(0, 2),
        edge(1, 2),
        within / within.sum(),
    ];
    candidates
        .into_iter()
        .filter(|x| x.iter().all(|x| *x >= 0.0))
        .map(|x| (x.dot(&(m * x)), x))
        .fold((f64::INFINITY, corner(0)), |best, next| {
            if next.0 < best.0 { next } else { best }
        })
}
