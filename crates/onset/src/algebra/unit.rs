//! Units that keep computed numbers away from over- and underflow.

/// Range of magnitudes that are not rescaled: their sixth powers neither over- nor underflow.
const MODERATE: std::ops::Range<f64> = 1e-30..1e30;

/// Unit for numbers of a given magnitude: one, unless they are very large or small; otherwise the nearest smaller power of four.
///
/// Division by it is exact, and so is division of square roots by its root. Results therefore agree to the last digit in all units.
pub(crate) fn moderate_unit(size: f64) -> f64 {
    if !size.is_normal() || MODERATE.contains(&size.abs()) {
        return 1.0;
    }
    let exponent = (size.abs().to_bits() >> 52) as i64 - 1023;
    // The inverse of the unit must be normal too.
    let even = (2 * exponent.div_euclid(2)).clamp(-1020, 1020);
    f64::from_bits(((even + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::moderate_unit;

    #[test]
    fn units_are_powers_of_four_near_the_magnitude() {
        for exponent in -300..300 {
            let size = 3.7 * 10_f64.powi(exponent);
            let unit = moderate_unit(size);
            assert_eq!(unit.sqrt() * unit.sqrt(), unit);
            assert_eq!(unit.recip().recip(), unit);
            assert!((1e-30..1e30).contains(&(size / unit)), "{size:e} {unit:e}");
            let root = unit.sqrt().to_bits() & ((1 << 52) - 1);
            assert_eq!(root, 0, "{unit:e}");
        }
        assert_eq!(moderate_unit(32.0), 1.0);
        assert_eq!(moderate_unit(0.0), 1.0);
        assert_eq!(moderate_unit(f64::NAN), 1.0);
    }
}
