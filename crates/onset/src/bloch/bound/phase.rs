//! Phases of plane waves without the Taylor terms that cancel in lattice sums.
//!
//! The function is `f_m(t, p) = p^m phi_m(t p)`, where `phi_0(x) = exp(i x)`, and `phi_m(x)` is the remainder of `exp(i x)` after its first `m`
//! Taylor terms, divided by `x^m`. Thus `f_m = (exp(i t p) - 1 - ...) / t^m` is smooth at `t = 0`. Since `phi_m = i^m int_0^1 w_m(u) exp(i u x) du`
//! with the weights `delta(u - 1)`, 1 and `1 - u`, its derivatives are moments of these weights.

use crate::algebra::Complex;

/// Highest order of the computed derivatives: third-order polynomials, and the fourth order for their remainder.
pub(super) const HIGHEST_DERIVATIVE: usize = 4;

/// Largest `|x|` for the power series of the moments; the recursion would cancel there.
const SERIES_ARGUMENT: f64 = 1.5;
/// Number of terms of the power series; the last term is below rounding.
const SERIES_TERMS: usize = 18;

/// Moments `int_0^1 u^n exp(i u x) du` of a phase.
fn moments(x: f64) -> [Complex; HIGHEST_DERIVATIVE + 2] {
    const LAST_MOMENT: usize = HIGHEST_DERIVATIVE + 1;
    let (sine, cosine) = x.sin_cos();
    let mut moments = [Complex::default(); LAST_MOMENT + 1];
    if x.abs() < SERIES_ARGUMENT {
        // The terms `(i x)^j / j! / (j + n + 1)` alternate between real and imaginary.
        let (mut power, mut sums) = (1.0, [0.0; 4]);
        for j in 0..SERIES_TERMS {
            sums[j % 4] += power * (1.0 / (j + LAST_MOMENT + 1) as f64);
            power *= x * (1.0 / (j + 1) as f64);
        }
        moments[LAST_MOMENT] = Complex::new(sums[0] - sums[2], sums[1] - sums[3]);
        for n in (1..=LAST_MOMENT).rev() {
            let (after, share) = (moments[n], 1.0 / n as f64);
            let own = Complex::new(cosine + x * after.im, sine - x * after.re);
            moments[n - 1] = own * share;
        }
    } else {
        let over = x.recip();
        moments[0] = Complex::new(sine * over, (1.0 - cosine) * over);
        for n in 1..=LAST_MOMENT {
            let before = moments[n - 1] * n as f64;
            moments[n] = Complex::new((sine - before.im) * over, (before.re - cosine) * over);
        }
    }
    moments
}

/// Powers `1, x, x^2, ...` of a number.
fn powers(x: f64) -> [f64; HIGHEST_DERIVATIVE + 3] {
    let mut powers = [1.0; HIGHEST_DERIVATIVE + 3];
    for n in 1..powers.len() {
        powers[n] = powers[n - 1] * x;
    }
    powers
}

/// Coefficients `(b over j) (m + a)! / (m + a - j)!` for each `m`, `a`, `b` and `j`.
const COUNTS: [[[[f64; HIGHEST_DERIVATIVE + 1]; HIGHEST_DERIVATIVE + 1]; HIGHEST_DERIVATIVE + 1];
    3] = {
    let mut counts =
        [[[[0.0; HIGHEST_DERIVATIVE + 1]; HIGHEST_DERIVATIVE + 1]; HIGHEST_DERIVATIVE + 1]; 3];
    let mut number = 0;
    while number < 3 * (HIGHEST_DERIVATIVE + 1) * (HIGHEST_DERIVATIVE + 1) {
        let (m, a, b) = (
            number % 3,
            number / 3 % (HIGHEST_DERIVATIVE + 1),
            number / 3 / (HIGHEST_DERIVATIVE + 1),
        );
        let (mut count, mut j) = (1, 0);
        while j <= b && j <= m + a {
            counts[m][a][b][j] = count as f64;
            count = count * (b - j) / (j + 1) * (m + a - j);
            j += 1;
        }
        number += 1;
    }
    counts
};

/// Derivatives of a function of `t` and `p`, with the order in each as index.
pub(super) type Derivatives = [[Complex; HIGHEST_DERIVATIVE + 1]; HIGHEST_DERIVATIVE + 1];

/// Derivatives of `f_m` of order `a` in `t` and `b` in `p`.
///
/// They are `sum_j (b over j) (m + a)! / (m + a - j)! p^(m + a - j) t^(b - j) phi^(a + b - j)`.
pub(super) fn derivatives(m: usize, t: f64, p: f64) -> Derivatives {
    let (x, i) = (t * p, Complex::i());
    let moments = moments(x);
    let mut phi = [Complex::default(); HIGHEST_DERIVATIVE + 1];
    let mut turn = [Complex::new(1.0, 0.0), i, -Complex::new(1.0, 0.0)][m];
    for n in 0..=HIGHEST_DERIVATIVE {
        let moment = match m {
            // The function is `exp(i x)` itself.
            0 => i * x * moments[0] + 1.0,
            1 => moments[n],
            _ => moments[n] - moments[n + 1],
        };
        phi[n] = turn * moment;
        turn *= i;
    }
    let (t, p) = (powers(t), powers(p));
    let mut derivatives = [[Complex::default(); HIGHEST_DERIVATIVE + 1]; HIGHEST_DERIVATIVE + 1];
    for a in 0..=HIGHEST_DERIVATIVE {
        for b in 0..=HIGHEST_DERIVATIVE - a {
            for j in 0..=b.min(m + a) {
                let factor = COUNTS[m][a][b][j] * p[m + a - j] * t[b - j];
                derivatives[a][b] += phi[a + b - j] * factor;
            }
        }
    }
    derivatives
}

/// Integral `int w_m(u) u^n du`, which bounds the `n`-th derivative of `phi_m`.
fn weight(m: usize, n: usize) -> f64 {
    match m {
        0 => 1.0,
        1 => 1.0 / (n + 1) as f64,
        _ => 1.0 / ((n + 1) * (n + 2)) as f64,
    }
}

/// Bound of the remainder of a Taylor polynomial of fourth order of `f_m` within distances `h` and `g` of its center.
///
/// The arguments `t` and `p` are bounds of `|t|` and `|p|`. The result is the bound of the fifth derivative along `(h, g)`, divided by `5!`.
pub(super) fn beyond(m: usize, [t, h]: [f64; 2], [p, g]: [f64; 2]) -> f64 {
    let w = |n: usize| weight(m, n);
    // `(t + e h)(p + e g) = x + e y + e^2 z`; the terms of `phi` in `e^3`, `e^4` and `e^5`.
    let (y, z) = (t * g + p * h, h * g);
    let (y2, z2) = (y * y, z * z);
    let third = w(3) * y2 * y / 6.0 + w(2) * y * z;
    let fourth = w(4) * y2 * y2 / 24.0 + w(3) * y2 * z / 2.0 + w(2) * z2 / 2.0;
    let fifth = w(5) * y2 * y2 * y / 120.0 + w(4) * y2 * y * z / 6.0 + w(3) * y * z2 / 2.0;
    match m {
        0 => fifth,
        1 => p * fifth + g * fourth,
        _ => p * p * fifth + 2.0 * p * g * fourth + g * g * third,
    }
}

/// Bounds of the second derivatives of `f_m` with respect to `t` and `p`.
pub(super) fn bends(m: usize, t: f64, p: f64) -> [f64; 2] {
    let w = |n: usize| weight(m, n);
    match m {
        0 => [w(2) * p * p, w(2) * t * t],
        1 => [w(2) * p.powi(3), 2.0 * w(1) * t + w(2) * t * t * p],
        _ => [
            w(2) * p.powi(4),
            2.0 * w(0) + 4.0 * w(1) * t * p + w(2) * (t * p).powi(2),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::{Derivatives, HIGHEST_DERIVATIVE, bends, beyond, derivatives};
    use crate::algebra::Complex;

    /// Function `f_m` from its definition, for arguments without cancellation.
    fn direct(m: usize, t: f64, p: f64) -> Complex {
        let x = Complex::new(0.0, t * p);
        let rest = match m {
            0 => x.exp(),
            1 => x.exp() - 1.0,
            _ => x.exp() - 1.0 - x,
        };
        rest / t.powi(m as i32)
    }

    #[test]
    fn derivatives_agree_with_the_definition() {
        for (t, p) in [(0.4, 3.0), (0.5, -9.0), (0.3, 21.0), (0.45, 2.1)] {
            for m in 0..3 {
                let own = derivatives(m, t, p);
                let scale = 1.0 + p.abs().powi(m as i32 + 2);
                assert!((own[0][0] - direct(m, t, p)).norm() < 1e-13 * scale);
                let h = 1e-4;
                let difference = |[plus, minus]: [Derivatives; 2], a: usize, b: usize| {
                    (plus[a][b] - minus[a][b]) / (2.0 * h)
                };
                let by_t = [h, -h].map(|h| derivatives(m, t + h, p));
                let by_p = [h, -h].map(|h| derivatives(m, t, p + h));
                for (a, b) in (0..HIGHEST_DERIVATIVE)
                    .flat_map(|a| (0..HIGHEST_DERIVATIVE - a).map(move |b| (a, b)))
                {
                    let tolerance = 1e-5 * (1.0 + p.abs()).powi((m + a + 3) as i32);
                    let close = |x: Complex, y: Complex| {
                        assert!((x - y).norm() < tolerance, "{m} {a} {b}: {x} {y}")
                    };
                    close(own[a + 1][b], difference(by_t, a, b));
                    close(own[a][b + 1], difference(by_p, a, b));
                }
            }
        }
    }

    #[test]
    fn second_derivatives_stay_below_their_bounds() {
        for m in 0..3 {
            for n in 0..400 {
                let (t, p) = (0.5 * (n % 20) as f64 / 19.0, (n / 20) as f64 - 9.5);
                let (own, [by_t, by_p]) = (derivatives(m, t, p), bends(m, t, p.abs()));
                assert!(own[2][0].norm() <= by_t * (1.0 + 1e-12));
                assert!(own[0][2].norm() <= by_p * (1.0 + 1e-12) + 1e-12);
            }
        }
    }

    #[test]
    fn the_remainder_of_a_fourth_order_polynomial_stays_below_its_bound() {
        let factorial = |n: usize| (1..=n).product::<usize>() as f64;
        for m in 0..3 {
            for n in 0..200 {
                let (t, p) = (0.05 + 0.4 * (n % 10) as f64 / 9.0, (n / 10) as f64 - 9.5);
                let (h, g) = (0.04 * (1.0 - 0.01 * n as f64), 0.4 * (n as f64).sin());
                let own = derivatives(m, t, p);
                let mut sum = Complex::default();
                for (a, b) in (0..=HIGHEST_DERIVATIVE)
                    .flat_map(|a| (0..=HIGHEST_DERIVATIVE - a).map(move |b| (a, b)))
                {
                    let monomial = h.powi(a as i32) * g.powi(b as i32);
                    sum += own[a][b] * (monomial / (factorial(a) * factorial(b)));
                }
                let bound = beyond(m, [t + h.abs(), h.abs()], [p.abs() + g.abs(), g.abs()]);
                let left = (direct(m, t + h, p + g) - sum).norm();
                assert!(left <= bound + 1e-10, "{m} {t} {p}: {left} {bound}");
            }
        }
    }

    #[test]
    fn small_arguments_cause_no_cancellation() {
        // The limits for `t -> 0` are `-p^2 / 2` of `f_2` and `i p` of `f_1`.
        let [first, second] = [1, 2].map(|m| derivatives(m, 1e-9, 3.0)[0][0]);
        assert!((second - Complex::new(-4.5, 0.0)).norm() < 1e-8);
        assert!((first - Complex::new(0.0, 3.0)).norm() < 1e-8);
    }
}
