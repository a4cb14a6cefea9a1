//! Enclosures of functions on a box by quadratic polynomials with a bounded remainder.

use super::waves::Entries;
use crate::algebra::Each;

/// Rounding error of one operation on patches, in units of the magnitudes of its operands: at most 30 roundings.
const PATCH_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Enclosure `value + slope . x + x . curvature x + rest`, `x` in `[-1, 1]^2`, `|rest| <= rest`.
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

    /// Bound of the absolute value on the box.
    fn magnitude(&self) -> f64 {
        self.value.abs() + self.slopes() + self.curvatures() + self.rest
    }

    /// Linear combination `a self + b other` of patches.
    pub(super) fn combined(&self, a: f64, other: &Self, b: f64) -> Self {
        let mix = |x: f64, y: f64| a * x + b * y;
        let rest = a.abs() * self.rest + b.abs() * other.rest;
        Self {
            value: mix(self.value, other.value),
            slope: [0, 1].each(|i| mix(self.slope[i], other.slope[i])),
            curvature: [0, 1, 2].each(|i| mix(self.curvature[i], other.curvature[i])),
            rest: rest
                + PATCH_ROUNDING * (a.abs() * self.magnitude() + b.abs() * other.magnitude()),
        }
    }

    /// Product of two patches. Terms of third and fourth order are added to the remainder.
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
            slope: [0, 1].each(|i| a.value * b.slope[i] + b.value * a.slope[i]),
            curvature: [
                a.value * b.curvature[0] + b.value * a.curvature[0] + a.slope[0] * b.slope[0],
                a.value * b.curvature[1]
                    + b.value * a.curvature[1]
                    + a.slope[0] * b.slope[1]
                    + a.slope[1] * b.slope[0],
                a.value * b.curvature[2] + b.value * a.curvature[2] + a.slope[1] * b.slope[1],
            ],
            rest: rest + PATCH_ROUNDING * (a_size * b_size + rest),
        }
    }

    /// Lower bound on the box.
    pub(super) fn lower(&self) -> f64 {
        // Along one axis: the vertex of the parabola if it lies inside, otherwise an end.
        let along = |slope: f64, curvature: f64| {
            let slope = slope.abs();
            if slope < 2.0 * curvature {
                -0.25 * slope * slope / curvature
            } else {
                curvature - slope
            }
        };
        let apart = along(self.slope[0], self.curvature[0]).min(0.0)
            + along(self.slope[1], self.curvature[2]).min(0.0)
            - self.curvature[1].abs();
        self.value - self.rest + apart.max(self.vertex()) - PATCH_ROUNDING * self.magnitude()
    }

    /// Minimum of the quadratic part over the whole plane. Where two branches cross in a cone, the discriminant has zero as its minimum, and only
    /// this estimate proves that it is not negative.
    fn vertex(&self) -> f64 {
        let ([a, b, c], [p, q]) = (self.curvature, self.slope);
        let determinant = 4.0 * a * c - b * b;
        // Require a nearly isotropic minimum, so that rounding of the quotient is small.
        if a > 0.0 && determinant > 1e-3 * a * c {
            -(c * p * p - b * p * q + a * q * q) / determinant * (1.0 + 1e-9)
        } else {
            f64::NEG_INFINITY
        }
    }
}

/// Matrix-valued patch with the entries `11, 12, 21, 22`.
pub(super) type MatrixPatch = [Patch; 4];

/// Returns true if both eigenvalues have positive real parts on the box, and oscillations grow no faster than tolerated.
///
/// The real parts are positive if and only if trace and determinant are. `growth` is `None` for symmetric matrices. Otherwise, with `(a, b)`, the
/// discriminant `((m11 - m22)/2)^2 + m12 m21` must exceed `-(a + b trace)`.
pub(super) fn is_positive(matrix: &MatrixPatch, growth: Option<(f64, f64)>) -> bool {
    let [m11, m12, m21, m22] = matrix;
    let trace = m11.combined(1.0, m22, 1.0);
    // Comparisons with NaN are false, so NaN is not a proof.
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

/// Smaller eigenvalue of a real matrix, by real part.
pub(super) fn smallest(m: &Entries) -> f64 {
    let half = 0.5 * (m[0] - m[3]);
    let discriminant = half * half + m[1] * m[2];
    0.5 * (m[0] + m[3]) - discriminant.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::Patch;

    #[test]
    fn lower_bounds_are_below_every_value_and_near_the_minimum() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut tight = 0;
        for _ in 0..2000 {
            let patch = Patch {
                value: random(),
                slope: [random(), random()],
                curvature: [random(), random(), random()],
                rest: 0.0,
            };
            let mut least = f64::INFINITY;
            for i in 0..=40 {
                for j in 0..=40 {
                    let [x, y] = [i, j].map(|n| f64::from(n) / 20.0 - 1.0);
                    let [a, b, c] = patch.curvature;
                    let value = patch.value + patch.slope[0] * x + patch.slope[1] * y;
                    least = least.min(value + a * x * x + b * x * y + c * y * y);
                }
            }
            assert!(patch.lower() <= least, "{patch:?}");
            tight += usize::from(patch.lower() > least - 0.1);
        }
        assert!(tight > 500, "{tight} of the bounds are tight");
    }

    #[test]
    fn a_minimum_that_touches_zero_is_bounded_by_zero() {
        // The function (x + y)^2 + x^2 resembles a discriminant at a crossing.
        let well = Patch {
            value: 1e-12,
            slope: [0.0; 2],
            curvature: [2.0, 2.0, 1.0],
            rest: 0.0,
        };
        assert!(well.lower() > 0.0 - 1e-12);
    }
}
