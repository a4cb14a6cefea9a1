//! Symmetric functions of the stretches of which energies are functions, with derivatives without cancellation.
//!
//! The moduli of a law need quotients `(s_i - s_j)/(e_i - e_j)` of the derivatives `s_i = ds/de_i` by the squares of the stretches, which are 0/0 where two
//! stretches are equal. With `h = ln lambda`, `t = h_i - h_j` and `e = exp(2 h)` they have closed forms: for a sum of powers
//!
//! `(e_i^q - e_j^q)/(e_i - e_j) = exp((q - 1)(h_i + h_j)) sinh(q t)/sinh(t)`,
//!
//! whose last factor is even and smooth in `t`.

use onset::real::{Dual, Interval, Real};

/// Number that encloses the rest of a series.
pub(crate) trait Enclosed: Real {
    /// Number between 0 and 1: each of them in an enclosure, any of them else.
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

    /// Sum and difference of the logarithms of two stretches.
    fn pair(&self, i: usize, j: usize) -> [R; 2] {
        [self.logs[i] + self.logs[j], self.logs[i] - self.logs[j]]
    }
}

/// Symmetric function of the stretches.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sum<R> {
    /// First invariant less 3, `e_1 + e_2 + e_3 - 3`.
    First,
    /// Second invariant less 3, `e_1 e_2 + e_2 e_3 + e_3 e_1 - 3`.
    Second,
    /// Powers of the stretches less 3, `lambda_1^alpha + lambda_2^alpha + lambda_3^alpha - 3`.
    Powers(R),
    /// Squares of the logarithms, `h_1^2 + h_2^2 + h_3^2`.
    Squares,
    /// Logarithm of the volume, `h_1 + h_2 + h_3`.
    Volume,
}

/// Second derivatives by the squares of the stretches, and the quotients `(s_i - s_j)/(e_i - e_j)` by the third index.
pub(crate) type Curvatures<R> = ([[R; 3]; 3], [R; 3]);

impl<R: Enclosed> Sum<R> {
    /// Value, and derivatives by the squares of the stretches.
    pub fn slopes(&self, state: &State<R>) -> (R, [R; 3]) {
        let State { logs, squares } = state;
        let [a, b, c] = *squares;
        let total = |[a, b, c]: [R; 3]| a + b + c;
        match *self {
            Self::First => (a + b + c - 3.0, [R::constant(1.0); 3]),
            Self::Second => (a * b + b * c + c * a - 3.0, [b + c, c + a, a + b]),
            Self::Powers(alpha) => {
                let powers = logs.map(|log| (log * alpha).exp());
                let slope = |i: usize| alpha * 0.5 * (logs[i] * (alpha - 2.0)).exp();
                (total(powers) - 3.0, std::array::from_fn(slope))
            }
            Self::Squares => {
                let slope = |i: usize| logs[i] / squares[i];
                (
                    total(logs.map(|log| log * log)),
                    std::array::from_fn(slope),
                )
            }
            Self::Volume => (total(*logs), squares.map(|own| own.recip() * 0.5)),
        }
    }

    /// Second derivatives and quotients.
    pub fn curvatures(&self, state: &State<R>) -> Curvatures<R> {
        let State { logs, squares } = state;
        let zero = R::constant(0.0);
        let diagonal = |of: &dyn Fn(usize) -> R| {
            let mut second = [[zero; 3]; 3];
            for (i, row) in second.iter_mut().enumerate() {
                row[i] = of(i);
            }
            second
        };
        let pairs = |of: &dyn Fn(usize, usize) -> R| [of(1, 2), of(0, 2), of(0, 1)];
        match *self {
            Self::First => ([[zero; 3]; 3], [zero; 3]),
            Self::Second => {
                let mut second = [[R::constant(1.0); 3]; 3];
                for (i, row) in second.iter_mut().enumerate() {
                    row[i] = zero;
                }
                (second, [R::constant(-1.0); 3])
            }
            Self::Powers(alpha) => {
                let factor = alpha * 0.5;
                let second = |i: usize| {
                    factor * (alpha * 0.5 - 1.0) * (logs[i] * (alpha - 4.0)).exp()
                };
                let quotient = |i: usize, j: usize| {
                    let [sum, difference] = state.pair(i, j);
                    let power = (sum * (alpha * 0.5 - 2.0)).exp();
                    factor * power * ratio_of_sines(alpha * 0.5 - 1.0, difference)
                };
                (diagonal(&second), pairs(&quotient))
            }
            Self::Squares => {
                let inverse = squares.map(R::recip);
                let second = |i: usize| (-logs[i] + 0.5) * inverse[i] * inverse[i];
                let quotient = |i: usize, j: usize| {
                    let [sum, difference] = state.pair(i, j);
                    let tangent = difference.cosh() / sine_quotient(difference);
                    (tangent - sum) * 0.5 * inverse[i] * inverse[j]
                };
                (diagonal(&second), pairs(&quotient))
            }
            Self::Volume => {
                let inverse = squares.map(R::recip);
                let second = |i: usize| inverse[i] * inverse[i] * -0.5;
                let quotient = |i: usize, j: usize| inverse[i] * inverse[j] * -0.5;
                (diagonal(&second), pairs(&quotient))
            }
        }
    }
}

/// Terms of the series of `sinh(x)/x`.
const SERIES: i32 = 9;

/// Hyperbolic sine over its argument, `sinh(x)/x`.
///
/// The rest of the series after the term of degree `2 n - 2` is `x^2n/(2 n + 1)!` times a mean of `cosh(x u)` over `u` between 0 and 1.
fn sine_quotient<R: Enclosed>(x: R) -> R {
    if is_beyond(x, 1.0) {
        return x.sinh() / x;
    }
    let square = x * x;
    let rest = (x * R::share()).cosh();
    let factor = |n: i32| f64::from(2 * n) * f64::from(2 * n + 1);
    (1..=SERIES).rev().fold(rest, |sum, n| sum * square / factor(n) + 1.0)
}

/// Ratio `sinh(q t)/sinh(t)`.
fn ratio_of_sines<R: Enclosed>(q: R, t: R) -> R {
    if !is_beyond(t, 1.0) {
        return q * sine_quotient(q * t) / sine_quotient(t);
    }
    // Both are even in t, and the ratio is odd in q.
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

    /// Function of the squares, evaluated naively.
    fn value(sum: &Sum<f64>, squares: [f64; 3]) -> f64 {
        sum.slopes(&State::new(squares.map(|own| 0.5 * own.ln()))).0
    }

    #[test]
    fn slopes_and_curvatures_are_the_derivatives() {
        let squares = [1.7, 1.2, 0.4];
        let state = State::new(squares.map(|own| 0.5 * own.ln()));
        for sum in [
            Sum::First,
            Sum::Second,
            Sum::Powers(3.3),
            Sum::Powers(-2.4),
            Sum::Squares,
            Sum::Volume,
        ] {
            let (_, slopes) = sum.slopes(&state);
            let (second, quotients) = sum.curvatures(&state);
            let step = 1e-4;
            let moved = |i: usize, by: f64| {
                let mut own = squares;
                own[i] += by;
                own
            };
            for i in 0..3 {
                let difference = value(&sum, moved(i, step)) - value(&sum, moved(i, -step));
                assert!((difference / (2.0 * step) - slopes[i]).abs() < 1e-6, "{sum:?}");
                for j in 0..3 {
                    let slope = |by: f64| {
                        let own = moved(j, by).map(|own| 0.5 * own.ln());
                        sum.slopes(&State::new(own)).1[i]
                    };
                    let difference = (slope(step) - slope(-step)) / (2.0 * step);
                    assert!((difference - second[i][j]).abs() < 1e-5, "{sum:?} {i} {j}");
                }
            }
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let expected = (slopes[i] - slopes[j]) / (squares[i] - squares[j]);
                assert!((quotients[3 - i - j] - expected).abs() < 1e-12, "{sum:?}");
            }
        }
    }

    #[test]
    fn enclosures_contain_the_quotients_on_both_sides_of_equal_stretches() {
        for q in [-7.5, -1.0, -0.3, 0.2, 1.0, 2.5, 9.0] {
            for [low, high] in [[-0.3, 0.2], [0.0, 0.1], [0.6, 1.4], [1.1, 1.2], [-2.5, -2.4]] {
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
                let width = enclosed.value.width();
                let least = (q * low).sinh() / low.sinh();
                assert!(low == 0.0 || width < 40.0 * q.abs().max(1.0) * least.abs() * (high - low));
            }
        }
    }
}
