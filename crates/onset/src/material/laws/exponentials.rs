//! Exponentials without cancellation, for laws with powers of stretches.

use crate::real::{Real, Side};

/// Largest argument for which the series is used; the error after ten terms is below rounding.
const SERIES_LIMIT: f64 = 0.1;
const TERMS: u32 = 10;

/// Function `exp(x) - 1 - x`, also accurate for small `x`, where it is `x^2 / 2`.
///
/// ```text
/// x^2/2 (1 + x/3 (1 + x/4 (1 + ...)))
/// ```
pub(super) fn beyond_linear<R: Real>(x: R) -> R {
    let direct = || x.exp() - 1.0 - x;
    let series = || {
        let last = R::constant(1.0);
        let bracket = (3..3 + TERMS)
            .rev()
            .fold(last, |rest, n| rest * x / f64::from(n) + 1.0);
        x * x * bracket * 0.5
    };
    if x.side(-SERIES_LIMIT) == Some(Side::Below) {
        return direct();
    }
    x.switch(-SERIES_LIMIT, direct, || {
        x.switch(SERIES_LIMIT, series, direct)
    })
}

#[cfg(test)]
mod tests {
    use super::beyond_linear;
    use crate::real::{Interval, Jet};

    #[test]
    fn small_arguments_keep_their_digits() {
        for (x, expected) in [
            (1e-12, 5.000_000_000_001_666e-25),
            (-1e-5, 4.999_983_333_375_001e-11),
            (0.099, 0.005_066_299_558_881_902),
            (0.101, 0.005_276_641_763_421_957),
            (-0.0999, 0.004_827_906_302_101_07),
            (1.0, std::f64::consts::E - 2.0),
        ] {
            let found: f64 = beyond_linear(x);
            assert!((found / expected - 1.0).abs() < 1e-12, "{x}: {found:e}");
        }
    }

    #[test]
    fn derivatives_are_continuous_where_the_series_ends() {
        for end in [-0.1, 0.1_f64] {
            let [below] = Jet::variables([end.next_down()]);
            let [above] = Jet::variables([end.next_up()]);
            let (a, b) = (beyond_linear(below), beyond_linear(above));
            assert!((a.gradient[0] / b.gradient[0] - 1.0).abs() < 1e-13);
            assert!((a.hessian[0][0] / b.hessian[0][0] - 1.0).abs() < 1e-13);
        }
        let across = beyond_linear(Interval::new(0.05, 0.2));
        assert!(across.contains(beyond_linear(0.05)) && across.contains(beyond_linear(0.2)));
    }
}
