//! Values of a setting over a range.

/// Ratio of the smallest positive value to the largest value, for ranges that begin at zero.
const SMALLEST_RATIO: f64 = 1e-4;

/// Distributes values from `low` to `high`.
///
/// The spacing is logarithmic if `low` is positive. If `low` is zero, zero is followed by logarithmically spaced values; if it is negative, the
/// spacing is linear.
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
        let positive = (0..count).map(powers(SMALLEST_RATIO * high));
        std::iter::once(0.0).chain(positive).collect()
    };
    // The ends of the range are exactly the requested ones.
    if let [first, .., end] = &mut values[..] {
        (*first, *end) = (low, high);
    }
    values
}

/// Returns the midpoint of two values, geometric if both are positive.
pub fn middle(low: f64, high: f64) -> f64 {
    match low > 0.0 && high > 0.0 {
        true => low.sqrt() * high.sqrt(),
        false => 0.5 * (low + high),
    }
}
