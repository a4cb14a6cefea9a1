//! Local minimum of a function between two arguments.

/// Fraction of an interval at which golden section places its point.
const GOLDEN: f64 = 0.381_966_011_250_105_1;
/// Largest number of parabolic and golden-section steps.
const BRENT_STEPS: usize = 60;

/// Returns a local minimum of a function between two arguments, to `tolerance` in the argument.
///
/// The caller must give an argument between them at which the function is no higher than at the ends, with its value. The method combines parabolas
/// through the lowest points with golden section (R. P. Brent, Algorithms for Minimization without Derivatives, 1973, ch. 5).
///
/// # Errors
/// The error of the function at a point. A function can also use it to end the search early with a result.
pub(crate) fn lowest_between<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    [mut low, middle, mut high]: [f64; 3],
    value: f64,
    tolerance: f64,
) -> Result<(f64, f64), E> {
    // Lowest point, second lowest point, and the previous second lowest point.
    let (mut best, mut second, mut third) = ((middle, value), (middle, value), (middle, value));
    let (mut step, mut before): (f64, f64) = (0.0, high - low);
    for _ in 0..BRENT_STEPS {
        let x = best.0;
        if (x - low).max(high - x) <= 2.0 * tolerance {
            break;
        }
        let parabolic = vertex(best, second, third).filter(|to| {
            let is_shrinking = (to - x).abs() < 0.5 * before.abs();
            is_shrinking && low < *to && *to < high
        });
        before = step;
        step = match parabolic {
            // Keep a distance from an end, or the opposite end of the bracket would not move.
            Some(to) if (to - low).min(high - to) < 2.0 * tolerance => {
                tolerance.copysign(low.midpoint(high) - x)
            }
            Some(to) => to - x,
            None => {
                before = if high - x > x - low {
                    high - x
                } else {
                    low - x
                };
                GOLDEN * before
            }
        };
        if step.abs() < tolerance {
            step = tolerance.copysign(step);
        }
        let there = (x + step, f(x + step)?);
        if there.1 <= best.1 {
            *(if there.0 < x { &mut high } else { &mut low }) = x;
            (third, second, best) = (second, best, there);
        } else {
            *(if there.0 < x { &mut low } else { &mut high }) = there.0;
            if there.1 <= second.1 || second.0 == x {
                (third, second) = (second, there);
            } else if there.1 <= third.1 || third.0 == x || third.0 == second.0 {
                third = there;
            }
        }
    }
    Ok(best)
}

/// Vertex of the parabola through three points; `None` if they do not define a parabola.
fn vertex(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Option<f64> {
    let (to_b, to_c) = (a.0 - b.0, a.0 - c.0);
    let (r, q) = (to_b * (a.1 - c.1), to_c * (a.1 - b.1));
    let vertex = a.0 - 0.5 * (to_b * r - to_c * q) / (r - q);
    vertex.is_finite().then_some(vertex)
}

#[cfg(test)]
mod tests {
    use super::lowest_between;
    use std::cell::Cell;
    use std::convert::Infallible;

    fn sought(f: impl Fn(f64) -> f64, place: f64) -> (f64, usize) {
        let asked = Cell::new(0);
        let counted = |x: f64| {
            asked.set(asked.get() + 1);
            Ok::<f64, Infallible>(f(x))
        };
        let Ok((x, value)) = lowest_between(counted, [-1.0, place, 2.0], f(place), 1e-7);
        assert_eq!(value, f(x));
        assert!(value <= f(place));
        (x, asked.get())
    }

    #[test]
    fn smooth_minima_are_found_with_few_evaluations_and_kinks_with_more() {
        let (x, asked) = sought(|x| (x - 0.3).cosh(), 0.5);
        assert!((x - 0.3).abs() < 1e-6, "{x}");
        assert!(asked < 15, "{asked}");
        let (x, asked) = sought(|x| (x - 0.3).abs() + 0.2 * x, 0.5);
        assert!((x - 0.3).abs() < 1e-6, "{x}");
        assert!(asked < 60, "{asked}");
        // Functions that are not smooth on one side, flat, or infinite beyond a point.
        let (x, _) = sought(|x| if x < 0.3 { 1.0 } else { (x - 0.3).sqrt() }, 0.5);
        assert!((x - 0.3).abs() < 1e-6, "{x}");
        let (x, _) = sought(|_| 1.0, 0.5);
        assert!((-1.0..=2.0).contains(&x), "{x}");
        let (x, _) = sought(|x| if x > 0.6 { f64::INFINITY } else { -x }, 0.5);
        assert!((x - 0.6).abs() < 1e-6, "{x}");
    }

    #[test]
    fn minima_in_the_middle_and_near_an_end_are_found() {
        for place in [-0.999, 0.3, 1.9999] {
            let (x, _) = sought(|x| (x - place).powi(4) + (x - place).powi(2), 0.5);
            assert!((x - place).abs() < 1e-5, "{x} {place}");
        }
        let (x, _) = sought(|x| (x - 0.5) * (x - 0.5), 0.5);
        assert!((x - 0.5).abs() < 1e-6, "{x}");
    }

    #[test]
    fn an_error_of_the_function_ends_the_search() {
        let crossing = |x: f64| match x < 0.4 {
            true => Err(x),
            false => Ok(x),
        };
        let met = lowest_between(crossing, [0.0, 0.5, 1.0], 0.5, 1e-7).expect_err("it falls there");
        assert!((0.0..0.4).contains(&met), "{met}");
    }
}
