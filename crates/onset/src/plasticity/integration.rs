//! Integration of ordinary differential equations of loading paths, with error control.

use nalgebra::SVector;

/// Shorter steps, relative to the end of the interval, are accepted regardless of their error.
const SHORTEST_STEP: f64 = 1e-12;

/// Largest number of steps of an integration.
const MOST_STEPS: usize = 20_000;
/// Number of steps after which their length is compared with the remaining interval, so that an integration whose steps become ever shorter is
/// abandoned early.
const BLOCK: usize = 500;

/// Reason why an integration did not reach its end, and the last state `y(x)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stopped<const N: usize, E> {
    pub(super) why: Stop<E>,
    pub(super) y: SVector<f64, N>,
    pub(super) x: f64,
}

/// Reason why an integration did not reach its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Stop<E> {
    /// The rates are undefined even for the shortest step.
    Rates(E),
    /// The steps are too short to reach the end.
    TooManySteps,
}

/// Integrates `dy/dx = rates(y, x)` forward in `x` (J. R. Dormand and P. J. Prince, *J. Comput. Appl. Math.* 6 (1980) 19).
///
/// The error of a step is at most `accuracy` in units of the `size` of the state where it begins.
pub(super) fn integrate<const N: usize, E>(
    start: &SVector<f64, N>,
    [from, to]: [f64; 2],
    size: impl Fn(&SVector<f64, N>) -> SVector<f64, N>,
    accuracy: f64,
    rates: impl Fn(&SVector<f64, N>, f64) -> Result<SVector<f64, N>, E>,
) -> Result<SVector<f64, N>, Stopped<N, E>> {
    let (mut y, mut x) = (*start, from);
    if x >= to {
        return Ok(y);
    }
    let mut step = to - from;
    let mut first = None;
    let mut block_start = x;
    for count in 0..MOST_STEPS {
        if count % BLOCK == 0 && count > 0 {
            if (to - x) * BLOCK as f64 > (x - block_start) * MOST_STEPS as f64 {
                break;
            }
            block_start = x;
        }
        let last = x + step >= to;
        let length = if last { to - x } else { step };
        let shortest = length <= SHORTEST_STEP * to;
        // The last rates of a step are the first of the next one.
        let begun = first.map_or_else(|| rates(&y, x), Ok);
        let reached = begun.and_then(|begun| {
            first = Some(begun);
            dormand_prince(&y, &begun, x, length, &rates)
        });
        let [next, difference, ended] = match reached {
            Ok(reached) => reached,
            Err(end) if shortest => {
                let why = Stop::Rates(end);
                return Err(Stopped { why, y, x });
            }
            // A step that is too long may leave the path. Only failure of short steps means that the path ends.
            Err(_) => {
                step = 0.1 * length;
                continue;
            }
        };
        let error = difference.component_div(&size(&y)).amax();
        let factor = 0.9 * (accuracy / error.max(1e-30)).powf(0.2);
        if error <= accuracy || shortest {
            (y, first) = (next, Some(ended));
            x = if last { to } else { x + length };
        }
        if x >= to {
            return Ok(y);
        }
        step = length * factor.clamp(0.1, 4.0);
    }
    let why = Stop::TooManySteps;
    Err(Stopped { why, y, x })
}

/// Performs one step from a state with known rates. Returns the new state, an estimate of its error, and the new rates.
fn dormand_prince<const N: usize, E>(
    y: &SVector<f64, N>,
    begun: &SVector<f64, N>,
    x: f64,
    step: f64,
    rates: &impl Fn(&SVector<f64, N>, f64) -> Result<SVector<f64, N>, E>,
) -> Result<[SVector<f64, N>; 3], E> {
    const NODES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
    const WEIGHTS: [&[f64]; 7] = [
        &[],
        &[0.2],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[
            19372.0 / 6561.0,
            -25360.0 / 2187.0,
            64448.0 / 6561.0,
            -212.0 / 729.0,
        ],
        &[
            9017.0 / 3168.0,
            -355.0 / 33.0,
            46732.0 / 5247.0,
            49.0 / 176.0,
            -5103.0 / 18656.0,
        ],
        &[
            35.0 / 384.0,
            0.0,
            500.0 / 1113.0,
            125.0 / 192.0,
            -2187.0 / 6784.0,
            11.0 / 84.0,
        ],
    ];
    // Fifth-order minus fourth-order weights.
    const ERROR: [f64; 7] = [
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ];
    let mut stages = [SVector::<f64, N>::zeros(); 7];
    stages[0] = *begun;
    let mut next = *y;
    for stage in 1..7 {
        next = *y;
        for (weight, rate) in WEIGHTS[stage].iter().zip(&stages) {
            next += rate * (weight * step);
        }
        stages[stage] = rates(&next, x + NODES[stage] * step)?;
    }
    let error = ERROR
        .iter()
        .zip(&stages)
        .map(|(weight, rate)| rate * (weight * step))
        .sum();
    Ok([next, error, stages[6]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    fn ended<const N: usize>(
        start: [f64; N],
        to: f64,
        rates: impl Fn(&SVector<f64, N>, f64) -> Result<SVector<f64, N>, &'static str>,
    ) -> Result<SVector<f64, N>, Stopped<N, &'static str>> {
        let size = |_: &SVector<f64, N>| SVector::repeat(1.0);
        integrate(&SVector::from(start), [0.0, to], size, 1e-10, rates)
    }

    #[test]
    fn the_integration_of_a_pendulum_returns_to_the_initial_state() {
        let rates = |y: &SVector<f64, 2>, _: f64| Ok(SVector::from([y[1], -y[0]]));
        let end = ended([0.0, 1.0], 2.0 * std::f64::consts::PI, rates);
        let end = end.unwrap_or_else(|_| panic!("the end is reached"));
        assert!((end - SVector::from([0.0, 1.0])).amax() < 1e-8, "{end}");
    }

    #[test]
    fn a_path_ends_where_its_rates_end() {
        // `y = sqrt(1 - x)`.
        let rates = |y: &SVector<f64, 1>, _: f64| match y[0] > 1e-3 {
            true => Ok(SVector::from([-0.5 / y[0]])),
            false => Err("no rates"),
        };
        let Err(stopped) = ended([1.0], 2.0, rates) else {
            panic!("the path ends");
        };
        assert_eq!(stopped.why, Stop::Rates("no rates"));
        assert!((stopped.x - 1.0).abs() < 2e-6, "{}", stopped.x);
    }

    /// Steps become shorter like `exp(-x)`: the end is out of reach long before the largest number of steps.
    #[test]
    fn an_integration_with_ever_shorter_steps_is_abandoned_early() {
        let count = Cell::new(0);
        let rates = |y: &SVector<f64, 1>, x: f64| {
            count.set(count.get() + 1);
            Ok(SVector::from([-x.exp() * (y[0] - x.cos())]))
        };
        let Err(stopped) = ended([1.0], 30.0, rates) else {
            panic!("the end is out of reach");
        };
        assert_eq!(stopped.why, Stop::TooManySteps);
        assert!(count.get() < MOST_STEPS, "{} evaluations", count.get());
    }
}
