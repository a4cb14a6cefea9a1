//! Values of a setting over a range.

/// The smallest positive value over the largest, where a range begins at zero.
const SMALLEST: f64 = 1e-4;

/// So many values from `low` to `high`: evenly in the logarithm, with zero before them where the range begins there; evenly where it begins below.
///
/// ```
/// use onset_study::range::spread;
/// assert_eq!(spread([1.0, 100.0], 3), [1.0, 10.0, 100.0]);
/// assert_eq!(spread([-1.0, 1.0], 3), [-1.0, 0.0, 1.0]);
/// assert_eq!(spread([0.0, 1.0], 2), [0.0, 1e-4, 1.0]);
/// ```
pub fn spread([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    let last = (count - 1) as f64;
    let even = |low: f64, high: f64| move |n: usize| low + (high - low) * n as f64 / last;
    let powers = |low: f64| move |n: usize| low * (high / low).powf(n as f64 / last);
    let mut values: Vec<f64> = if low < 0.0 {
        (0..count).map(even(low, high)).collect()
    } else if low > 0.0 {
        (0..count).map(powers(low)).collect()
    } else {
        let positive = (0..count).map(powers(SMALLEST * high));
        std::iter::once(0.0).chain(positive).collect()
    };
    // The ends of the range are what was asked for, to the last digit.
    if let [first, .., end] = &mut values[..] {
        (*first, *end) = (low, high);
    }
    values
}

/// The value in the middle: of positive ones that of their logarithms.
pub fn middle(low: f64, high: f64) -> f64 {
    match low > 0.0 && high > 0.0 {
        true => low.sqrt() * high.sqrt(),
        false => 0.5 * (low + high),
    }
}
