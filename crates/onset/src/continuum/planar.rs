//! Extremes over directions in the plane, by algebra.
//!
//! With `N = (cos t/2, sin t/2)` the acoustic tensor is `Q = Q0 + Qc cos t + Qs sin t`, of first order in the doubled angle `t`. Its smallest
//! eigenvalue is `h - sqrt(d)`, where `h = tr Q / 2` is of first and `d = ((Q11 - Q22)/2)^2 + Q12 Q21` of second order. Its stationary points satisfy
//! `4 d h'^2 = d'^2`, a trigonometric polynomial of fourth order with at most eight zeros. Where `d < 0` (possible without major symmetry) the real
//! part is `h`, stationary at `h' = 0`.

use super::{ACOUSTIC_ROUNDING, AcousticMinimum, Stiffness};
use crate::algebra::{Complex, Each, TrigonometricPolynomial, array_of};
use crate::material::PlaneTangent;
use nalgebra::{SMatrix, SVector};

/// Entries of `Q(t)` as trigonometric polynomials of first order.
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
            let [[xx, xy], [yx, yy]] = blocks.each(|row| row.each(|block| block[(i, k)]));
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
}

/// Stiffness whose mirror axes are the coordinate axes, as for an isotropic law in its principal axes. With `x = cos t`, `Q11 = a0 + a1 x` and
/// `Q22 = b0 + b1 x` are linear and `Q12 Q21 = c (1 - x^2)`, so the discriminant is quadratic.
struct Orthotropic {
    a: [f64; 2],
    b: [f64; 2],
    c: f64,
    /// Coefficient of the product in `Q12 = mixed N1 N2`.
    mixed: f64,
}

impl Orthotropic {
    fn of<const D: usize>(stiffness: &Stiffness<D>) -> Option<Self> {
        let entry = |i: usize, k: usize| {
            let blocks = [(0, 0), (0, 1), (1, 0), (1, 1)];
            blocks.each(|(j, l)| stiffness.0[j][l][(i, k)])
        };
        let [q11, q12, q21, q22] = [entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)];
        let even = |q: [f64; 4]| q[1] + q[2] == 0.0;
        let odd = |q: [f64; 4]| q[0] == 0.0 && q[3] == 0.0;
        let linear = |q: [f64; 4]| [0.5 * (q[0] + q[3]), 0.5 * (q[0] - q[3])];
        (even(q11) && even(q22) && odd(q12) && odd(q21)).then(|| Self {
            a: linear(q11),
            b: linear(q22),
            c: 0.25 * (q12[1] + q12[2]) * (q21[1] + q21[2]),
            mixed: q12[1] + q12[2],
        })
    }

    /// Normalized stiffness of an in-plane tangent; `None` without this symmetry.
    fn of_plane(tangent: &PlaneTangent, scale: f64) -> Option<Self> {
        let t = |i: usize, j: usize, k: usize, l: usize| tangent[2 * i + j][2 * k + l] / scale;
        let even = |i: usize| t(i, 0, i, 1) + t(i, 1, i, 0) == 0.0;
        let odd = |i: usize, k: usize| t(i, 0, k, 0) == 0.0 && t(i, 1, k, 1) == 0.0;
        let linear = |i: usize| {
            let (xx, yy) = (t(i, 0, i, 0), t(i, 1, i, 1));
            [0.5 * (xx + yy), 0.5 * (xx - yy)]
        };
        let mixed = |i: usize, k: usize| t(i, 0, k, 1) + t(i, 1, k, 0);
        (even(0) && even(1) && odd(0, 1) && odd(1, 0)).then(|| Self {
            a: linear(0),
            b: linear(1),
            c: 0.25 * mixed(0, 1) * mixed(1, 0),
            mixed: mixed(0, 1),
        })
    }

    fn half_trace(&self, x: f64) -> f64 {
        0.5 * (self.a[0] + self.b[0] + (self.a[1] + self.b[1]) * x)
    }

    /// Coefficients of `((Q11 - Q22) / 2)^2 + Q12 Q21` in powers of `x`.
    fn discriminant(&self) -> [f64; 3] {
        let (d0, d1) = (0.5 * (self.a[0] - self.b[0]), 0.5 * (self.a[1] - self.b[1]));
        [d0 * d0 + self.c, 2.0 * d0 * d1, d1 * d1 - self.c]
    }

    fn eigenvalue(&self, x: f64) -> f64 {
        let [d0, d1, d2] = self.discriminant();
        self.half_trace(x) - (d0 + x * (d1 + x * d2)).max(0.0).sqrt()
    }

    /// Cosine of the angle `t` of the smallest eigenvalue: an end of the interval, or a solution of `4 d h'^2 = d'^2`.
    fn minimizing_cosine(&self) -> f64 {
        let [d0, d1, d2] = self.discriminant();
        // The factor `4 h'^2` of the condition `4 d h'^2 = d'^2`.
        let square = (self.a[1] + self.b[1]).powi(2);
        let stationary = quadratic_zeros(
            square * d2 - 4.0 * d2 * d2,
            square * d1 - 4.0 * d1 * d2,
            square * d0 - d1 * d1,
        );
        let mut best = (1.0, self.eigenvalue(1.0));
        // Ties are resolved in favor of the axes, then of the directions between them.
        for x in [0.0, -1.0].into_iter().chain(stationary) {
            let value = self.eigenvalue(x);
            if x.abs() <= 1.0 && value < best.1 - 4.0 * f64::EPSILON * best.1.abs() {
                best = (x, value);
            }
        }
        best.0
    }

    /// Smallest eigenvalue over all directions, with direction and polarization, by square roots alone.
    fn minimum<const D: usize>(&self) -> AcousticMinimum<D> {
        let x = self.minimizing_cosine();
        let normal = [(0.5 * (1.0 + x)).sqrt(), (0.5 * (1.0 - x)).sqrt()];
        let (q11, q22) = (self.a[0] + self.a[1] * x, self.b[0] + self.b[1] * x);
        let half = 0.5 * (q11 - q22);
        let square = half * half + self.c * (1.0 - x * x);
        let root = square.max(0.0).sqrt();
        // Use the form of the eigenvector without cancellation.
        let q12 = self.mixed * normal[0] * normal[1];
        let g = if half > 0.0 {
            [-q12, half + root]
        } else {
            [half - root, q12]
        };
        let length = (g[0] * g[0] + g[1] * g[1]).sqrt();
        let polarization = if length > 0.0 {
            g.each(|component| component / length)
        } else {
            [1.0, 0.0]
        };
        let eigenvalue = 0.5 * (q11 + q22) - root;
        AcousticMinimum {
            bound: eigenvalue - ACOUSTIC_ROUNDING,
            rounding: ACOUSTIC_ROUNDING,
            flutter: None,
            eigenvalue: Complex::new(eigenvalue, 0.0),
            direction: SVector::from_fn(|i, _| normal[i]),
            polarization: SVector::from_fn(|i, _| polarization[i]),
        }
    }
}

/// Real zeros of `a x^2 + b x + c` without cancellation; empty if it vanishes identically.
fn quadratic_zeros(a: f64, b: f64, c: f64) -> impl Iterator<Item = f64> {
    let q = -0.5 * (b + (b * b - 4.0 * a * c).max(0.0).sqrt().copysign(b));
    [q / a, c / q].into_iter().filter(|x| x.is_finite())
}

/// Smallest eigenvalue of an in-plane tangent whose mirror axes are the coordinate axes; `None` otherwise.
pub(super) fn mirrored_minimum<const D: usize>(
    tangent: &PlaneTangent,
) -> Option<AcousticMinimum<D>> {
    let entries = tangent.as_flattened().iter();
    let scale = entries.fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
    let unit = Orthotropic::of_plane(tangent, scale).filter(|_| scale.is_normal())?;
    Some(unit.minimum().scaled(scale))
}

pub(super) fn minimizing_direction<const D: usize>(stiffness: &Stiffness<D>) -> SVector<f64, D> {
    if let Some(orthotropic) = Orthotropic::of(stiffness) {
        return direction(orthotropic.minimizing_cosine().acos());
    }
    let entries = Entries::of(stiffness);
    let (h, d) = (entries.half_trace(), entries.discriminant());
    let (slope, d_slope) = (h.derivative(), d.derivative());
    let stationary = d
        .times(&slope.times(&slope))
        .combine(4.0, &d_slope.times(&d_slope), -1.0);

    let eigenvalue = |t: f64| h.at(t) - d.at(t).max(0.0).sqrt();
    // The axes are added for the isotropic case, where every direction is stationary.
    let mut candidates = vec![0.0, std::f64::consts::FRAC_PI_2, std::f64::consts::PI];
    // If one eigenvalue is constant over all directions, the polynomial vanishes identically, and the other eigenvalue is stationary with the trace.
    let expected = d.magnitude() * slope.magnitude().powi(2) + d_slope.magnitude().powi(2);
    if stationary.magnitude() > 1e-13 * expected {
        candidates.extend(stationary.zero_candidates());
    }
    candidates.extend(slope.zero_candidates());
    let mut best = (candidates[0], eigenvalue(candidates[0]));
    for t in candidates {
        let refined = polished(t, &h, &d);
        let value = eigenvalue(refined);
        // A later candidate must be lower by more than rounding, so that ties are resolved in favor of the axes.
        if value < best.1 - 4.0 * f64::EPSILON * best.1.abs() {
            best = (refined, value);
        }
    }
    direction(best.0)
}

/// Direction of the smallest discriminant. If it is negative, the imaginary part is largest there.
pub(super) fn fluttering_direction<const D: usize>(stiffness: &Stiffness<D>) -> SVector<f64, D> {
    direction(Entries::of(stiffness).discriminant().minimum().0)
}

/// Number of doubled angles that are tried as starts of the minimization.
const RAYS: usize = 64;
/// Largest distance of a stationary direction from a start of Newton's method, as a fraction of the distance of two starts.
const STATIONARY: f64 = 1e-6;
/// Shortest step that is halved further, an angle. Shorter steps fail because of rounding.
const SHORTEST_STEP: f64 = 1e-5;
/// Largest number of Newton steps to the minimum.
const NEWTON_STEPS: usize = 16;

/// Direction of the smallest eigenvalue by Newton's method from the lowest of equally spaced directions. Several times faster than the algebraic
/// method, with equal results unless two minima lie between neighboring directions.
pub(super) fn descended_direction<const D: usize>(stiffness: &Stiffness<D>) -> SVector<f64, D> {
    let entry = |i: usize, k: usize| {
        let [xx, xy, yx, yy] =
            [(0, 0), (0, 1), (1, 0), (1, 1)].each(|(j, l)| stiffness.0[j][l][(i, k)]);
        [0.5 * (xx + yy), 0.5 * (xx - yy), 0.5 * (xy + yx)]
    };
    let entries = [entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)];
    let rays = RAY_TABLE
        .get_or_init(|| array_of(|n| (n as f64 * std::f64::consts::TAU / RAYS as f64).sin_cos()));
    let sampled: [f64; RAYS] = array_of(|n| {
        let (sine, cosine) = rays[n];
        let [a, b, c, d] = entries.each(|e| e[0] + e[1] * cosine + e[2] * sine);
        let half = 0.5 * (a - d);
        0.5 * (a + d) - (half * half + b * c).max(0.0).sqrt()
    });
    let mut best = (0.0, f64::INFINITY);
    for n in 0..RAYS {
        let beside = [sampled[(n + RAYS - 1) % RAYS], sampled[(n + 1) % RAYS]];
        if beside.iter().all(|other| sampled[n] <= *other) {
            let (t, value) = turned(&entries, n as f64 * std::f64::consts::TAU / RAYS as f64);
            // Ties are resolved in favor of the first direction.
            if value < best.1 - 4.0 * f64::EPSILON * value.abs() {
                best = (t, value);
            }
        }
    }
    direction(best.0)
}

/// Sines and cosines of the doubled angles that are tried as starts.
static RAY_TABLE: std::sync::OnceLock<[(f64, f64); RAYS]> = std::sync::OnceLock::new();

/// Applies Newton's method to the eigenvalue `h - sqrt(p)` while it decreases.
fn turned(entries: &[[f64; 3]; 4], start: f64) -> (f64, f64) {
    // An entry `e0 + e1 cos t + e2 sin t` and its derivatives.
    let at = |t: f64| {
        let (sine, cosine) = t.sin_cos();
        let jets = entries.each(|e| {
            let varying = e[1] * cosine + e[2] * sine;
            [e[0] + varying, e[2] * cosine - e[1] * sine, -varying]
        });
        let [a, b, c, d] = jets;
        let mean = [0, 1, 2].each(|n| 0.5 * (a[n] + d[n]));
        let half = [0, 1, 2].each(|n| 0.5 * (a[n] - d[n]));
        let p = half[0] * half[0] + b[0] * c[0];
        if p <= 0.0 {
            return mean;
        }
        let p1 = 2.0 * half[0] * half[1] + b[1] * c[0] + b[0] * c[1];
        let p2 =
            2.0 * (half[1] * half[1] + half[0] * half[2] + b[1] * c[1]) + b[2] * c[0] + b[0] * c[2];
        let root = p.sqrt();
        [
            mean[0] - root,
            mean[1] - 0.5 * p1 / root,
            mean[2] - 0.5 * (p2 - 0.5 * p1 * p1 / p) / root,
        ]
    };
    let (mut t, mut here) = (start, at(start));
    let limit = std::f64::consts::TAU / RAYS as f64;
    // An axis of symmetry can be a maximum between two close minima. Newton's method would stay there.
    let [_, slope, curvature] = here;
    let is_maximum = curvature < 0.0 && slope.abs() <= STATIONARY * curvature.abs() * limit;
    let on_axis = (t, here[0]);
    if is_maximum {
        t += 0.125 * limit;
        here = at(t);
    }
    for _ in 0..NEWTON_STEPS {
        let [_, slope, curvature] = here;
        let mut step = (-slope / curvature.abs()).clamp(-limit, limit);
        let mut next = t + step;
        if !step.is_finite() || next == t {
            break;
        }
        let mut there = at(next);
        // Near an inflection the step is too long.
        while there[0] > here[0] && step.abs() > SHORTEST_STEP {
            step *= 0.5;
            next = t + step;
            there = at(next);
        }
        if there[0].is_nan() || there[0] > here[0] {
            break;
        }
        (t, here) = (next, there);
        if step.abs() < 1e-9 {
            break;
        }
    }
    match is_maximum && on_axis.1 <= here[0] {
        true => on_axis,
        false => (t, here[0]),
    }
}

/// Direction `N = (cos t/2, sin t/2)` at the doubled angle `t`.
pub(crate) fn direction<const D: usize>(t: f64) -> SVector<f64, D> {
    SVector::from_fn(|i, _| {
        if i == 0 {
            (0.5 * t).cos()
        } else {
            (0.5 * t).sin()
        }
    })
}

/// Applies Newton's method to the derivative of `h - sqrt(d)`; a step is accepted only if the eigenvalue decreases. It recovers the accuracy lost at
/// (nearly) multiple zeros.
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
