//! What is left of a plane wave once the terms that cancel in sums over a lattice are taken out.

use crate::algebra::{Complex, array_of};

/// `f_m(t, p) = p^m phi_m(t p)` with its derivatives, where `phi_0(x) = exp(i x)` and `phi_m(x)` is what remains of `exp(i x)` beyond
/// its first `m` Taylor terms, divided by `x^m`: `f_m = (exp(i t p) - 1 - ... ) / t^m`, smooth at `t = 0`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Phase {
    pub(super) value: Complex,
    /// By `t` and by `p`.
    pub(super) slope: [Complex; 2],
    /// By `t t`, `t p` and `p p`.
    pub(super) bend: [Complex; 3],
}

/// `|x|` below which the moments are summed up as a power series.
const SMALL: f64 = 1.5;
/// Terms of that series, the last of which is below rounding.
const TERMS: usize = 18;

/// `int_0^1 u^n exp(i u x) du` for `n = 0 .. 4`.
fn moments(x: f64) -> [Complex; 4] {
    let i = Complex::i();
    let (sine, cosine) = x.sin_cos();
    let end = Complex::new(cosine, sine);
    let mut moments = [Complex::default(); 4];
    if x.abs() < SMALL {
        let mut power = Complex::new(1.0, 0.0);
        for j in 0..TERMS {
            moments[3] += power / (j + 4) as f64;
            power *= i * (x / (j + 1) as f64);
        }
        for n in (1..4).rev() {
            moments[n - 1] = (end - i * x * moments[n]) / n as f64;
        }
    } else {
        moments[0] = (end - 1.0) / (i * x);
        for n in 1..4 {
            moments[n] = (end - moments[n - 1] * n as f64) / (i * x);
        }
    }
    moments
}

/// `f_0`, `f_1` and `f_2`.
pub(super) fn phases(t: f64, p: f64) -> [Phase; 3] {
    let x = t * p;
    let (sine, cosine) = x.sin_cos();
    let (end, i) = (Complex::new(cosine, sine), Complex::i());
    let e = moments(x);
    // phi_m and its first two derivatives: phi_m = i^m int w_m(u) exp(i u x) du with weights delta(u - 1), 1 and 1 - u.
    let functions = [
        [end, i * end, -end],
        [i * e[0], -e[1], -i * e[2]],
        [e[1] - e[0], i * (e[2] - e[1]), e[2] - e[3]],
    ];
    array_of(|m| {
        let [value, first, second] = functions[m];
        let own = p.powi(m as i32);
        let order = m as f64;
        let below = |n: i32| match m as i32 - n {
            rest if rest < 0 => 0.0,
            rest => p.powi(rest),
        };
        Phase {
            value: value * own,
            slope: [
                first * own * p,
                value * (order * below(1)) + first * (own * t),
            ],
            bend: [
                second * own * p * p,
                first * ((order + 1.0) * own) + second * (own * x),
                value * (order * (order - 1.0) * below(2))
                    + first * (2.0 * order * t * below(1))
                    + second * (own * t * t),
            ],
        }
    })
}

/// Bounds of the derivatives of `f_m` where `|t|` and `|p|` are at most so large: the second ones by `t t` and `p p`, and the third
/// ones by `t t t`, `t t p`, `t p p`, `p p p`.
pub(super) fn derivative_bounds(order: usize, t: f64, p: f64) -> ([f64; 2], [f64; 4]) {
    let m = order as f64;
    // int w_m(u) u^n du.
    let w = |n: usize| match order {
        0 => 1.0,
        1 => 1.0 / (n + 1) as f64,
        _ => 1.0 / ((n + 1) * (n + 2)) as f64,
    };
    let power = |n: i32| match order as i32 + n {
        rest if rest < 0 => 0.0,
        rest => p.powi(rest),
    };
    let second = [
        w(2) * power(2),
        m * (m - 1.0) * power(-2) * w(0) + 2.0 * m * power(-1) * w(1) * t + power(0) * w(2) * t * t,
    ];
    let third = [
        w(3) * power(3),
        w(2) * (m + 2.0) * power(1) + w(3) * t * power(2),
        w(1) * (m + 1.0) * m * power(-1)
            + 2.0 * (m + 1.0) * w(2) * t * power(0)
            + w(3) * t * t * power(1),
        3.0 * m * (m - 1.0) * power(-2) * w(1) * t
            + 3.0 * m * power(-1) * w(2) * t * t
            + power(0) * w(3) * t.powi(3),
    ];
    (second, third)
}

#[cfg(test)]
mod tests {
    use super::{derivative_bounds, phases};
    use crate::algebra::Complex;

    /// `f_m` from its definition, for arguments at which it does not cancel.
    fn direct(order: usize, t: f64, p: f64) -> Complex {
        let x = Complex::new(0.0, t * p);
        let rest = match order {
            0 => x.exp(),
            1 => x.exp() - 1.0,
            _ => x.exp() - 1.0 - x,
        };
        rest / t.powi(order as i32)
    }

    #[test]
    fn values_and_derivatives_are_those_of_the_definition() {
        for (t, p) in [(0.4, 3.0), (0.5, -9.0), (0.3, 21.0), (0.45, 2.1)] {
            for order in 0..3 {
                let own = phases(t, p)[order];
                let scale = 1.0 + p.abs().powi(order as i32 + 2);
                assert!((own.value - direct(order, t, p)).norm() < 1e-13 * scale);
                let h = 1e-4;
                let [tp, tm] = [h, -h].map(|h| phases(t + h, p)[order]);
                let [pp, pm] = [h, -h].map(|h| phases(t, p + h)[order]);
                let difference = |a: Complex, b: Complex| (a - b) / (2.0 * h);
                let tolerance = 1e-5 * scale * (1.0 + p.abs());
                let close = |a: Complex, b: Complex| assert!((a - b).norm() < tolerance, "{a} {b}");
                close(own.slope[0], difference(tp.value, tm.value));
                close(own.slope[1], difference(pp.value, pm.value));
                close(own.bend[0], difference(tp.slope[0], tm.slope[0]));
                close(own.bend[1], difference(pp.slope[0], pm.slope[0]));
                close(own.bend[2], difference(pp.slope[1], pm.slope[1]));
            }
        }
    }

    #[test]
    fn third_derivatives_stay_below_their_bounds() {
        for order in 0..3 {
            for n in 0..400 {
                let (t, p) = (0.5 * (n % 20) as f64 / 19.0, (n / 20) as f64 - 9.5);
                let (second, third) = derivative_bounds(order, t, p.abs());
                let own = phases(t, p)[order];
                assert!(own.bend[0].norm() <= second[0] * (1.0 + 1e-12));
                assert!(own.bend[2].norm() <= second[1] * (1.0 + 1e-12));
                let h = 1e-4;
                let [tp, tm] = [h, -h].map(|h| phases(t + h, p)[order]);
                let [pp, pm] = [h, -h].map(|h| phases(t, p + h)[order]);
                let by = |a: Complex, b: Complex| (a - b).norm() / (2.0 * h);
                let slack = 1e-4 * (1.0 + p.abs().powi(order as i32 + 3));
                assert!(by(tp.bend[0], tm.bend[0]) <= third[0] + slack);
                assert!(by(tp.bend[1], tm.bend[1]) <= third[1] + slack);
                assert!(by(tp.bend[2], tm.bend[2]) <= third[2] + slack);
                assert!(by(pp.bend[2], pm.bend[2]) <= third[3] + slack);
            }
        }
    }

    #[test]
    fn small_arguments_do_not_cancel() {
        // f_2 -> -p^2 / 2 and f_1 -> i p.
        let own = phases(1e-9, 3.0);
        assert!((own[2].value - Complex::new(-4.5, 0.0)).norm() < 1e-8);
        assert!((own[1].value - Complex::new(0.0, 3.0)).norm() < 1e-8);
    }
}
