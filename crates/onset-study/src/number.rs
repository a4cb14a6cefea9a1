//! Printing of numbers: six significant digits for any magnitude, and zero for rounding errors.

/// Number of significant digits in text output; JSON has all digits.
pub(crate) const DIGITS: usize = 6;
/// Largest rounding error relative to the numbers in the computation.
const ROUNDING_FRACTION: f64 = 1e-12;

/// Formats a computed number with six significant digits.
///
/// ```
/// use onset_study::number::told;
/// assert_eq!(told(79999999999.99998), "8e10");
/// assert_eq!(told(0.0000123456789), "1.23457e-5");
/// assert_eq!(told(2.39119876), "2.3912");
/// ```
pub fn told(value: f64) -> String {
    told_with(value, DIGITS)
}

/// Formats a computed number with the given number of significant digits.
pub(crate) fn told_with(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return exact(value + 0.0);
    }
    // Rounded first, because 999999.7 has six digits before the point, but seven after rounding.
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    exact(rounded)
}

/// Rounds a computed number up to six significant digits, for the lower end of a range that must not be printed too wide.
///
/// ```
/// use onset_study::number::{told_above, told_below};
/// assert_eq!([told_above(0.72050839), told_below(1.38790890)], ["0.720509", "1.3879"]);
/// assert_eq!([told_above(0.5), told_below(2.0)], ["0.5", "2"]);
/// ```
pub fn told_above(value: f64) -> String {
    let told_so = told(value);
    let is_below = told_so
        .parse::<f64>()
        .is_ok_and(|rounded| rounded < value - 1e-9 * value.abs());
    if !is_below {
        return told_so;
    }
    let unit = 10_f64.powi(value.abs().log10().floor() as i32 + 1 - DIGITS as i32);
    told(value + unit)
}

/// Rounds a computed number down to six significant digits, for the upper end of a range that must not be printed too wide.
pub fn told_below(value: f64) -> String {
    match told_above(-value) {
        negated if negated == "0" => negated,
        negated => match negated.strip_prefix('-') {
            Some(positive) => positive.to_owned(),
            None => format!("-{negated}"),
        },
    }
}

/// Formats a computed number that results from numbers of magnitude `size`; rounding errors become zero.
///
/// ```
/// use onset_study::number::told_of;
/// assert_eq!(told_of(-3.1e-17, 1.0), "0");
/// assert_eq!(told_of(-3.1e-17, 1e-9), "-3.1e-17");
/// ```
pub fn told_of(value: f64, size: f64) -> String {
    if value.abs() <= ROUNDING_FRACTION * size.abs() {
        return told(0.0);
    }
    told(value)
}

/// Formats a number with the fewest digits that identify it, and with an exponent if it is large or small.
pub fn exact(value: f64) -> String {
    match value.abs() {
        size if size == 0.0 || !size.is_finite() || (1e-4..1e6).contains(&size) => {
            format!("{value}")
        }
        _ => format!("{value:e}"),
    }
}

/// Formats a count with a noun: `1 tile`, `4 tiles`.
///
/// ```
/// use onset_study::number::counted;
/// assert_eq!([counted(1, "tile"), counted(0, "tile")], ["1 tile", "0 tiles"]);
/// ```
pub fn counted(count: usize, name: &str) -> String {
    match count {
        1 => format!("1 {name}"),
        _ => format!("{count} {name}s"),
    }
}

/// Formats a vector; components within rounding of the largest component become zero.
pub fn vector(components: &[f64]) -> String {
    let largest = components
        .iter()
        .fold(0.0_f64, |most, own| most.max(own.abs()));
    let one = |own: &f64| match own.abs() <= 0.5e-6 * largest {
        true => told(0.0),
        false => told(*own),
    };
    format!(
        "({})",
        components.iter().map(one).collect::<Vec<_>>().join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::{told, told_of, vector};

    #[test]
    fn numbers_of_any_magnitude_are_printed_with_six_significant_digits() {
        for exponent in -300..300 {
            let value = 1.234_567_89 * 10.0_f64.powi(exponent);
            let text = told(value);
            let read: f64 = text.parse().expect("a number");
            assert!((read / value - 1.0).abs() < 5e-6, "{text}");
            let digits = text.split('e').next().expect("a mantissa");
            let digits = digits.trim_start_matches(['0', '.']).replace('.', "");
            assert!(digits.len() <= 6, "{text}");
        }
        assert_eq!(told(999_999.7), "1e6");
        assert_eq!(told(-0.0), "0");
    }

    #[test]
    fn rounding_errors_are_printed_as_zero() {
        assert_eq!(told_of(1e-13, 1.0), "0");
        assert_eq!(told_of(1e-13, 1e-3), "1e-13");
        assert_eq!(vector(&[3.6, -1e-9]), "(3.6, 0)");
        assert_eq!(vector(&[0.0, -0.0]), "(0, 0)");
    }
}
