//! Finite differences, extrapolated to zero step size.

/// Largest step in each direction, and the number of halvings.
const LARGEST_STEP: f64 = 0.02;
const LEVELS: usize = 10;

/// Steps at which a function must be evaluated, largest first; each is also used with negative sign.
pub fn steps() -> impl Iterator<Item = f64> {
    (0..LEVELS).map(|level| LARGEST_STEP * 0.5_f64.powi(level as i32))
}

/// Value extrapolated to zero step size, with the error estimate of the extrapolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Extrapolated {
    /// One value for each component of the function.
    pub values: Vec<f64>,
    /// Largest expected error of a component.
    pub uncertainty: f64,
}

/// Derivative of a vector-valued function by central differences, from its values at plus and minus each of the [`steps`].
pub fn derivative(plus: &[Vec<f64>], minus: &[Vec<f64>]) -> Extrapolated {
    let central = steps().zip(plus).zip(minus).map(|((step, plus), minus)| {
        let pairs = plus.iter().zip(minus);
        pairs.map(|(p, m)| (p - m) / (2.0 * step)).collect()
    });
    extrapolated(&central.collect::<Vec<_>>())
}

/// Limit of a vector-valued function from both sides, without its value at the point itself.
pub fn limit(plus: &[Vec<f64>], minus: &[Vec<f64>]) -> Extrapolated {
    let mean = |(plus, minus): (&Vec<f64>, &Vec<f64>)| {
        let pairs = plus.iter().zip(minus);
        pairs.map(|(p, m)| 0.5 * (p + m)).collect()
    };
    extrapolated(&plus.iter().zip(minus).map(mean).collect::<Vec<_>>())
}

/// Richardson extrapolation with halved steps.
///
/// The result is the entry of the table that differs least from its neighbors (Ridders, Adv. Eng. Software 4 (1982) 75). Large steps suffer from
/// truncation and small steps from rounding, and steps across a kink disagree with each other, so no step is trusted beforehand. The error has even
/// powers of the step for smooth functions, and all powers if a derivative jumps at the state: both tables are tried.
fn extrapolated(levels: &[Vec<f64>]) -> Extrapolated {
    let mut best = Extrapolated {
        values: levels.first().cloned().unwrap_or_default(),
        uncertainty: f64::INFINITY,
    };
    for factor in [4.0, 2.0] {
        let mut above: Vec<Vec<f64>> = Vec::new();
        for level in levels {
            let mut row = vec![level.clone()];
            let mut weight = 1.0;
            for previous in &above {
                weight *= factor;
                let last = &row[row.len() - 1];
                let next: Vec<f64> = last
                    .iter()
                    .zip(previous)
                    .map(|(fine, coarse)| (weight * fine - coarse) / (weight - 1.0))
                    .collect();
                let uncertainty = distance(&next, last).max(distance(&next, previous));
                if uncertainty < best.uncertainty {
                    best = Extrapolated {
                        values: next.clone(),
                        uncertainty,
                    };
                }
                row.push(next);
            }
            above = row;
        }
    }
    best
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(function: impl Fn(f64) -> Vec<f64>) -> Extrapolated {
        let plus: Vec<Vec<f64>> = steps().map(&function).collect();
        let minus: Vec<Vec<f64>> = steps().map(|step| function(-step)).collect();
        derivative(&plus, &minus)
    }

    #[test]
    fn derivatives_of_smooth_functions_are_accurate_and_their_error_estimate_holds() {
        let derivative = of(|x| vec![(3.0 * (1.0 + x)).exp(), (1.0 + x).powi(-5)]);
        let exact = [3.0 * 3.0_f64.exp(), -5.0];
        for (value, exact) in derivative.values.iter().zip(exact) {
            let error = (value - exact).abs();
            assert!(error < 1e-10 * exact.abs(), "{error:e}");
            assert!(error <= 100.0 * derivative.uncertainty + 1e-13);
        }
    }

    #[test]
    fn a_distant_kink_is_harmless_and_a_kink_at_the_state_is_detected() {
        let kinked = |at: f64| of(move |x| vec![x.sin() + (x - at).max(0.0)]);
        let beyond = kinked(1e-3);
        assert!((beyond.values[0] - 1.0).abs() < 1e-9);
        // The central differences agree with each other, but converge only to the mean of both sides.
        assert!((kinked(0.0).values[0] - 1.5).abs() < 1e-9);
    }
}
