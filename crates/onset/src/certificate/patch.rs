//! Functions on a box as quadratic polynomials with a bounded rest.

use super::waves::Entries;

/// Rounding of one operation on patches, in units of the magnitudes of its operands: at most 30 roundings.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// `value + slope . x + x . curvature x + rest`, `x` in `[-1, 1]^2`, `|rest| <= rest`.
///
/// The curvature is stored as the coefficients of `x1^2`, `x1 x2`, `x2^2`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    pub(super) value: f64,
    pub(super) slope: [f64; 2],
    pub(super) curvature: [f64; 3],
    pub(super) rest: f64,
}

impl Patch {
    fn slopes(&self) -> f64 {
        self.slope[0].abs() + self.slope[1].abs()
    }

    fn curvatures(&self) -> f64 {
        self.curvature.iter().map(|x| x.abs()).sum()
    }

    /// A bound of the absolute value on the box.
    fn magnitude(&self) -> f64 {
        self.value.abs() + self.slopes() + self.curvatures() + self.rest
    }

    /// `a self + b other`.
    pub(super) fn combined(&self, a: f64, other: &Self, b: f64) -> Self {
        let mix = |x: f64, y: f64| a * x + b * y;
        let rest = a.abs() * self.rest + b.abs() * other.rest;
        Self {
            value: mix(self.value, other.value),
            slope: [0, 1].map(|i| mix(self.slope[i], other.slope[i])),
            curvature: [0, 1, 2].map(|i| mix(self.curvature[i], other.curvature[i])),
            rest: rest + ROUNDING * (a.abs() * self.magnitude() + b.abs() * other.magnitude()),
        }
    }

    /// The product; what is of third and fourth order goes to the rest.
    pub(super) fn times(&self, other: &Self) -> Self {
        let (a, b) = (self, other);
        let (a_size, b_size) = (a.magnitude(), b.magnitude());
        let (a_plain, b_plain) = (a_size - a.rest, b_size - b.rest);
        let high = a.slopes() * b.curvatures()
            + a.curvatures() * b.slopes()
            + a.curvatures() * b.curvatures();
        let rest = high + a.rest * b_plain + b.rest * a_plain + a.rest * b.rest;
        Self {
            value: a.value * b.value,
            slope: [0, 1].map(|i| a.value * b.slope[i] + b.value * a.slope[i]),
            curvature: [
                a.value * b.curvature[0] + b.value * a.curvature[0] + a.slope[0] * b.slope[0],
                a.value * b.curvature[1]
                    + b.value * a.curvature[1]
                    + a.slope[0] * b.slope[1]
                    + a.slope[1] * b.slope[0],
                a.value * b.curvature[2] + b.value * a.curvature[2] + a.slope[1] * b.slope[1],
            ],
            rest: rest + ROUNDING * (a_size * b_size + rest),
        }
    }

    /// A lower bound on the box.
    pub(super) fn lower(&self) -> f64 {
        // Along one axis: the vertex of the parabola where that lies inside, an end otherwise.
        let along = |slope: f64, curvature: f64| {
            let slope = slope.abs();
            if slope < 2.0 * curvature {
                -0.25 * slope * slope / curvature
            } else {
                curvature - slope
            }
        };
        self.value - self.rest - self.curvature[1].abs()
            + along(self.slope[0], self.curvature[0]).min(0.0)
            + along(self.slope[1], self.curvature[2]).min(0.0)
            - ROUNDING * self.magnitude()
    }
}

/// A matrix on a box, entries `11, 12, 21, 22`.
pub(super) type MatrixPatch = [Patch; 4];

/// Whether both eigenvalues have a positive real part on the box, and no oscillation grows noticeably.
///
/// The real parts are positive if and only if trace and determinant are. `growth` is `None` for symmetric matrices;
/// otherwise `(a, b)`: the discriminant `((m11 - m22)/2)^2 + m12 m21` must exceed `-(a + b trace)`.
pub(super) fn is_positive(matrix: &MatrixPatch, growth: Option<(f64, f64)>) -> bool {
    let [m11, m12, m21, m22] = matrix;
    let trace = m11.combined(1.0, m22, 1.0);
    // NaN exceeds nothing: it is no proof.
    let is_above_zero = |patch: &Patch| patch.lower() > 0.0;
    if !is_above_zero(&trace) {
        return false;
    }
    let coupling = m12.times(m21);
    let determinant = m11.times(m22).combined(1.0, &coupling, -1.0);
    if !is_above_zero(&determinant) {
        return false;
    }
    let Some((constant, factor)) = growth else {
        return true;
    };
    let half = m11.combined(0.5, m22, -0.5);
    let discriminant = half.times(&half).combined(1.0, &coupling, 1.0);
    discriminant.combined(1.0, &trace, factor).lower() + constant > 0.0
}

/// The smaller eigenvalue of a real matrix, by real part.
pub(super) fn smallest(m: &Entries) -> f64 {
    let half = 0.5 * (m[0] - m[3]);
    let discriminant = half * half + m[1] * m[2];
    0.5 * (m[0] + m[3]) - discriminant.max(0.0).sqrt()
}
