//! Directions in the plane: everything is algebraic.
//!
//! With `N = (cos t/2, sin t/2)` the acoustic tensor is `Q = Q0 + Qc cos t + Qs sin t`, of first
//! order in the doubled angle `t`. Its smallest eigenvalue is `h - sqrt(d)`, where
//! `h = tr Q / 2` is of first and `d = ((Q11 - Q22)/2)^2 + Q12 Q21` of second order. Its stationary
//! points obey `4 d h'^2 = d'^2`, a polynomial of fourth order with at most eight zeros; where
//! `d < 0` (possible without major symmetry) the real part is `h`, stationary where `h' = 0`.

use super::Stiffness;
use crate::algebra::TrigonometricPolynomial;
use nalgebra::{SMatrix, SVector};

/// Entries of `Q(t)` as polynomials of first order in `t`.
struct Entries {
    q11: TrigonometricPolynomial,
    q12: TrigonometricPolynomial,
    q21: TrigonometricPolynomial,
    q22: TrigonometricPolynomial,
}

impl Entries {
    fn of<const D: usize>(stiffness: &Stiffness<D>) -> Self {
        let blocks: [[&SMatrix<f64, D, D>; 2]; 2] = [
            [&stiffness.0[0][0], &stiffness.0[0][1]],
            [&stiffness.0[1][0], &stiffness.0[1][1]],
        ];
        let entry = |i: usize, k: usize| {
            let [[xx, xy], [yx, yy]] = blocks.map(|row| row.map(|block| block[(i, k)]));
            TrigonometricPolynomial::first_order(0.5 * (xx + yy), 0.5 * (xx - yy), 0.5 * (xy + yx))
        };
        Self {
            q11: entry(0, 0),
            q12: entry(0, 1),
            q21: entry(1, 0),
            q22: entry(1, 1),
        }
    }

    fn half_trace(&self) -> TrigonometricPolynomial {
        self.q11.combine(0.5, &self.q22, 0.5)
    }

    fn discriminant(&self) -> TrigonometricPolynomial {
        let half = self.q11.combine(0.5, &self.q22, -0.5);
        half.times(&half)
            .combine(1.0, &self.q12.times(&self.q21), 1.0)
    }

    fn determinant(&self) -> TrigonometricPolynomial {
        self.q11
            .times(&self.q22)
            .combine(1.0, &self.q12.times(&self.q21), -1.0)
    }
}

pub(super) fn is_strongly_elliptic<const D: usize>(stiffness: &Stiffness<D>) -> bool {
    let entries = Entries::of(stiffness);
    // Of a stiffness of magnitude one. The rounding error of a sum or product of components is a few units of
    // their last place.
    let half_trace = entries.half_trace().minimum().1;
    half_trace > -f64::EPSILON
        && entries.determinant().minimum().1 > -4.0 * f64::EPSILON * half_trace.abs()
}

pub(super) fn minimizing_direction<const D: usize>(stiffness: &Stiffness<D>) -> SVector<f64, D> {
    let entries = Entries::of(stiffness);
    let (h, d) = (entries.half_trace(), entries.discriminant());
    let (slope, d_slope) = (h.derivative(), d.derivative());
    let stationary = d
        .times(&slope.times(&slope))
        .combine(4.0, &d_slope.times(&d_slope), -1.0);

    let eigenvalue = |t: f64| h.at(t) - d.at(t).max(0.0).sqrt();
    // The axes are added for the isotropic case, in which every direction is stationary.
    let mut candidates = vec![0.0, std::f64::consts::FRAC_PI_2, std::f64::consts::PI];
    // Where one eigenvalue is the same in all directions the polynomial vanishes identically, and the other
    // one is stationary with the trace.
    let expected = d.magnitude() * slope.magnitude().powi(2) + d_slope.magnitude().powi(2);
    if stationary.magnitude() > 1e-13 * expected {
        candidates.extend(stationary.zero_candidates());
    }
    candidates.extend(slope.zero_candidates());
    let mut best = (candidates[0], eigenvalue(candidates[0]));
    for t in candidates {
        let refined = polished(t, &h, &d);
        let value = eigenvalue(refined);
        // A later candidate must be better than rounding, so that ties go to the axes.
        if value < best.1 - 4.0 * f64::EPSILON * best.1.abs() {
            best = (refined, value);
        }
    }
    let half_angle = 0.5 * best.0;
    SVector::from_fn(|i, _| {
        if i == 0 {
            half_angle.cos()
        } else {
            half_angle.sin()
        }
    })
}

/// Newton's method on the derivative of `h - sqrt(d)`, kept only while the eigenvalue falls: removes
/// the loss of accuracy of (nearly) multiple zeros.
fn polished(start: f64, h: &TrigonometricPolynomial, d: &TrigonometricPolynomial) -> f64 {
    let (h1, d1) = (h.derivative(), d.derivative());
    let (h2, d2) = (h1.derivative(), d1.derivative());
    let mut t = start;
    for _ in 0..20 {
        let square = d.at(t);
        if square <= 0.0 {
            break;
        }
        let root = square.sqrt();
        let first = h1.at(t) - d1.at(t) / (2.0 * root);
        let second = h2.at(t) - d2.at(t) / (2.0 * root) + d1.at(t).powi(2) / (4.0 * root * square);
        let next = t - first / second;
        let falls = h.at(next) - d.at(next).max(0.0).sqrt() <= h.at(t) - root;
        if second <= 0.0 || !next.is_finite() || !falls || next == t {
            break;
        }
        t = next;
    }
    t
}
