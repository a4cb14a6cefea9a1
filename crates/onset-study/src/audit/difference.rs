//! Derivatives by differences, extrapolated to no step at all.

/// Steps along a direction: the largest, and how many halvings of it.
const LARGEST: f64 = 0.02;
const LEVELS: usize = 10;

/// The steps at which a function must be known, largest first; each also with the other sign.
pub fn steps() -> impl Iterator<Item = f64> {
    (0..LEVELS).map(|level| LARGEST * 0.5_f64.powi(level as i32))
}

/// A value extrapolated to no step, with the extrapolation's own estimate of its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Extrapolated {
    /// A number for each component of the function.
    pub values: Vec<f64>,
    /// The largest error to expect in one of them.
    pub uncertainty: f64,
}

/// The derivative of a function of several components from its values at plus and minus each of the [`steps`], by central differences.
pub fn derivative(plus: &[Vec<f64>], minus: &[Vec<f64>]) -> Extrapolated {
    let central = steps().zip(plus).zip(minus).map(|((step, plus), minus)| {
        let pairs = plus.iter().zip(minus);
        pairs.map(|(p, m)| (p - m) / (2.0 * step)).collect()
    });
    extrapolated(&central.collect::<Vec<_>>())
}

/// The limit of such a function from both sides, its value at no step left out.
pub fn limit(plus: &[Vec<f64>], minus: &[Vec<f64>]) -> Extrapolated {
    let mean = |(plus, minus): (&Vec<f64>, &Vec<f64>)| {
        let pairs = plus.iter().zip(minus);
        pairs.map(|(p, m)| 0.5 * (p + m)).collect()
    };
    extrapolated(&plus.iter().zip(minus).map(mean).collect::<Vec<_>>())
}

/// Richardson's scheme for steps that are halved, and of its table the entry which differs least from its neighbors (Ridders,
/// Adv. Eng. Software 4 (1982) 75). Large steps err by truncation, small ones by rounding, and steps across a kink of the function
/// do not agree with each other: none of them is trusted beforehand. The error has even powers of the step for smooth functions, and all
/// powers where a derivative jumps at the state: both tables are tried.
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
    fn smooth_functions_are_differentiated_nearly_to_rounding_and_the_error_is_known() {
        let derivative = of(|x| vec![(3.0 * (1.0 + x)).exp(), (1.0 + x).powi(-5)]);
        let exact = [3.0 * 3.0_f64.exp(), -5.0];
        for (value, exact) in derivative.values.iter().zip(exact) {
            let error = (value - exact).abs();
            assert!(error < 1e-10 * exact.abs(), "{error:e}");
            assert!(error <= 100.0 * derivative.uncertainty + 1e-13);
        }
    }

    #[test]
    fn a_kink_beyond_the_small_steps_does_no_harm_and_one_at_the_state_is_noticed() {
        let kinked = |at: f64| of(move |x| vec![x.sin() + (x - at).max(0.0)]);
        let beyond = kinked(1e-3);
        assert!((beyond.values[0] - 1.0).abs() < 1e-9);
        // Its central differences agree with each other, but not more than a half is to be had.
        assert!((kinked(0.0).values[0] - 1.5).abs() < 1e-9);
    }
}
