//! Symmetric functions of the stretches, the arguments of energies, with derivatives without cancellation.
//!
//! With `h = ln lambda` and `e = exp(2 h)` all are sums `s = f(h_1) + f(h_2) + f(h_3)`. The moduli of a law need the slopes `a = f'`, the curvatures `f''` and the
//! quotients `(a_i - a_j)/(e_i - e_j)`, which are 0/0 where two stretches are equal. They have closed forms: for a sum of powers, with `t = h_i - h_j`,
//!
//! `(e_i^p - e_j^p)/(e_i - e_j) = exp((p - 1)(h_i + h_j)) sinh(p t)/sinh(t)`,
//!
//! whose last factor is even and smooth in `t`.

use onset::real::{Dual, Interval, Real};

/// Number type that encloses the remainder of a series.
pub(crate) trait Enclosed: Real {
    /// Number between 0 and 1: the whole interval in an enclosure, any value otherwise.
    fn share() -> Self;
}

impl Enclosed for f64 {
    fn share() -> Self {
        0.5
    }
}

impl Enclosed for Interval {
    fn share() -> Self {
        Self::new(0.0, 1.0)
    }
}

impl<const N: usize, R: Enclosed> Enclosed for Dual<N, R> {
    fn share() -> Self {
        Self {
            value: R::share(),
            gradient: [R::constant(0.0); N],
        }
    }
}

/// State of a specimen by its principal stretches.
pub(crate) struct State<R> {
    /// Logarithms of the stretches.
    pub logs: [R; 3],
    /// Squares of the stretches.
    pub squares: [R; 3],
}

impl<R: Real> State<R> {
    pub fn new(logs: [R; 3]) -> Self {
        let squares = logs.map(|log| (log * 2.0).exp());
        Self { logs, squares }
    }

    /// Differences of the squared stretches: entry `k` is `lambda_i^2 - lambda_j^2` of the other two indices `i < j`.
    pub fn differences(&self) -> [R; 3] {
        let of = |i: usize, j: usize| {
            let (sum, difference) = (self.logs[i] + self.logs[j], self.logs[i] - self.logs[j]);
            sum.exp() * difference.sinh() * 2.0
        };
        [of(1, 2), of(0, 2), of(0, 1)]
    }
}

/// Symmetric function of the stretches.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sum<R> {
    /// First invariant less 3, `e_1 + e_2 + e_3 - 3`.
    First,
    /// Second invariant less 3 at constant volume, `1/e_1 + 1/e_2 + 1/e_3 - 3`.
    Second,
    /// Powers of the stretches less 3, `lambda_1^alpha + lambda_2^alpha + lambda_3^alpha - 3`.
    Powers(R),
    /// Squares of the logarithms, `h_1^2 + h_2^2 + h_3^2`.
    Squares,
    /// Logarithm of the volume, `h_1 + h_2 + h_3`.
    Volume,
}

/// Second derivatives of a sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curvatures<R> {
    /// Curvatures `f''` at the three stretches.
    pub own: [R; 3],
    /// Quotients `(a_i - a_j)/(e_i - e_j)`; entry `k` is for the other two indices.
    pub quotients: [R; 3],
    /// Parts `f''_i - k_ij - k_ik + k_jk` with `k_ij = (e_i + e_j)/2` times the quotient.
    pub parts: [R; 3],
    /// Sums of two parts, `f''_i + f''_j - 2 k_ij`; entry `k` is for the other two indices.
    pub pairs: [R; 3],
}

impl<R: Real> Curvatures<R> {
    pub fn zero() -> Self {
        let zero = [R::constant(0.0); 3];
        Self {
            own: zero,
            quotients: zero,
            parts: zero,
            pairs: zero,
        }
    }
}

impl<R: Enclosed> Sum<R> {
    /// Returns the value of the sum and its slopes `f'`.
    pub fn slopes(&self, state: &State<R>) -> (R, [R; 3]) {
        let State { logs, squares } = state;
        let total = |[a, b, c]: [R; 3]| a + b + c;
        match *self {
            Self::First => (total(*squares) - 3.0, squares.map(|own| own * 2.0)),
            Self::Second => {
                let inverse = squares.map(R::recip);
                (total(inverse) - 3.0, inverse.map(|own| own * -2.0))
            }
            Self::Powers(alpha) => {
                let powers = logs.map(|log| (log * alpha).exp());
                (total(powers) - 3.0, powers.map(|own| own * alpha))
            }
            Self::Squares => (total(logs.map(|log| log * log)), logs.map(|log| log * 2.0)),
            Self::Volume => (total(*logs), [R::constant(1.0); 3]),
        }
    }

    /// Second derivatives of the sum: curvatures, quotients, and the parts in which the slopes cancel.
    pub fn curvatures(&self, state: &State<R>) -> Curvatures<R> {
        let State { logs, squares } = state;
        let pairs = |of: &dyn Fn(usize, usize) -> R| [of(1, 2), of(0, 2), of(0, 1)];
        match *self {
            Self::First => halved(*squares, [R::constant(2.0); 3]),
            Self::Second => {
                let inverse = squares.map(R::recip);
                let quotient = |i: usize, j: usize| inverse[i] * inverse[j] * 2.0;
                halved(inverse, pairs(&quotient))
            }
            Self::Powers(alpha) => {
                let quotient = |i: usize, j: usize| {
                    let (sum, difference) = (logs[i] + logs[j], logs[i] - logs[j]);
                    let power = (sum * (alpha * 0.5 - 1.0)).exp();
                    alpha * power * ratio_of_sines(alpha * 0.5, difference)
                };
                let curvature = |log: R| alpha * alpha * (log * alpha).exp();
                reduced(state, logs.map(curvature), pairs(&quotient))
            }
            Self::Squares => {
                let quotient = |i: usize, j: usize| {
                    let (sum, difference) = (logs[i] + logs[j], logs[i] - logs[j]);
                    (-sum).exp() / sine_quotient(difference)
                };
                reduced(state, [R::constant(2.0); 3], pairs(&quotient))
            }
            Self::Volume => Curvatures::zero(),
        }
    }
}

/// Second derivatives of a sum whose curvatures are `4 x` and whose parts are half the curvatures.
fn halved<R: Real>(x: [R; 3], quotients: [R; 3]) -> Curvatures<R> {
    let [a, b, c] = x;
    Curvatures {
        own: x.map(|own| own * 4.0),
        quotients,
        parts: x.map(|own| own * 2.0),
        pairs: [b + c, a + c, a + b].map(|own| own * 2.0),
    }
}

/// Second derivatives with parts in which the slopes of the largest stretch (the first) cancel: `k_12 - k_13 = (a_3 - a_2)/2 + q_12 e_2 - q_13 e_3`.
fn reduced<R: Real>(state: &State<R>, own: [R; 3], quotients: [R; 3]) -> Curvatures<R> {
    let e = state.squares;
    let [near, far, first] = quotients;
    let twice = [
        near * (e[1] + e[2]),
        far * (e[0] + e[2]),
        first * (e[0] + e[1]),
    ];
    let across = first * e[1] - far * e[2];
    Curvatures {
        own,
        quotients,
        parts: [
            own[0] + (twice[0] - twice[1] - twice[2]) * 0.5,
            own[1] - near * e[2] - across,
            own[2] - near * e[1] + across,
        ],
        pairs: [
            own[1] + own[2] - twice[0],
            own[0] + own[2] - twice[1],
            own[0] + own[1] - twice[2],
        ],
    }
}

/// Number of terms of the series of `sinh(x)/x`.
const SERIES: i32 = 9;

/// Hyperbolic sine divided by its argument, `sinh(x)/x`.
///
/// The remainder of the series after the term of degree `2 n - 2` is `x^2n/(2 n + 1)!` times a mean of `cosh(x u)` over `u` between 0 and 1.
fn sine_quotient<R: Enclosed>(x: R) -> R {
    if is_beyond(x, 1.0) {
        return x.sinh() / x;
    }
    let square = x * x;
    let rest = (x * R::share()).cosh();
    let factor = |n: i32| f64::from(2 * n) * f64::from(2 * n + 1);
    (1..=SERIES)
        .rev()
        .fold(rest, |sum, n| sum * square / factor(n) + 1.0)
}

/// Ratio `sinh(q t)/sinh(t)` of hyperbolic sines.
fn ratio_of_sines<R: Enclosed>(q: R, t: R) -> R {
    if !is_beyond(t, 1.0) {
        return q * sine_quotient(q * t) / sine_quotient(t);
    }
    // The ratio is even in t and odd in q.
    let t = if t.value() < 0.0 { -t } else { t };
    let (size, sign) = match q.value() < 0.0 {
        true => (-q, -1.0),
        false => (q, 1.0),
    };
    let part = |factor: R| -((factor * t * -2.0).exp()) + 1.0;
    ((size - 1.0) * t).exp() * part(size) / part(R::constant(1.0)) * sign
}

/// Returns true if all numbers of an enclosure are larger than a limit in magnitude.
fn is_beyond<R: Real>(x: R, limit: f64) -> bool {
    use onset::real::Side::{Above, Below};
    x.side(limit) == Some(Above) || x.side(-limit) == Some(Below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_and_curvatures_are_the_derivatives() {
        let logs = [0.3, 0.1, -0.5];
        for sum in [
            Sum::First,
            Sum::Second,
            Sum::Powers(3.3),
            Sum::Powers(-2.4),
            Sum::Squares,
            Sum::Volume,
        ] {
            let state = State::new(logs);
            let (_, slopes) = sum.slopes(&state);
            let Curvatures {
                own: curvatures,
                quotients,
                parts,
                pairs,
            } = sum.curvatures(&state);
            let e = state.squares;
            let mean = |i: usize, j: usize| 0.5 * quotients[3 - i - j] * (e[i] + e[j]);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let part = curvatures[i] - mean(i, j) - mean(i, k) + mean(j, k);
                assert!((parts[i] - part).abs() < 1e-12, "{sum:?}");
                assert!((pairs[i] - parts[j] - parts[k]).abs() < 1e-12, "{sum:?}");
            }
            let step = 1e-5;
            for i in 0..3 {
                let at = |by: f64| {
                    let mut own = logs;
                    own[i] += by;
                    sum.slopes(&State::new(own))
                };
                let (above, below) = (at(step), at(-step));
                let slope = (above.0 - below.0) / (2.0 * step);
                assert!((slope - slopes[i]).abs() < 1e-8, "{sum:?}");
                let curvature = (above.1[i] - below.1[i]) / (2.0 * step);
                assert!((curvature - curvatures[i]).abs() < 1e-8, "{sum:?}");
            }
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let difference = state.squares[i] - state.squares[j];
                let expected = (slopes[i] - slopes[j]) / difference;
                assert!((quotients[3 - i - j] - expected).abs() < 1e-12, "{sum:?}");
                assert!((state.differences()[3 - i - j] - difference).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn enclosures_contain_the_quotients_on_both_sides_of_equal_stretches() {
        for q in [-7.5, -1.0, -0.3, 0.2, 1.0, 2.5, 9.0] {
            for [low, high] in [
                [-0.3, 0.2],
                [0.0, 0.1],
                [0.6, 1.4],
                [1.1, 1.2],
                [-2.5, -2.4],
            ] {
                let t = Dual::<1, Interval>::variable(Interval::new(low, high), 0);
                let enclosed = ratio_of_sines(Dual::constant(q), t);
                for n in 0..=20 {
                    let at: f64 = low + (high - low) * f64::from(n) / 20.0;
                    if at.abs() < 1e-3 {
                        continue;
                    }
                    let exact = (q * at).sinh() / at.sinh();
                    let slope = exact * (q / (q * at).tanh() - at.tanh().recip());
                    assert!(enclosed.value.contains(exact), "{q} {at}");
                    assert!(enclosed.gradient[0].contains(slope), "{q} {at}");
                }
                assert!(enclosed.value.is_finite() && enclosed.gradient[0].is_finite());
            }
        }
    }
}
