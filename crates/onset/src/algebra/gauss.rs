//! Gaussian quadrature on the unit interval.

/// Points and weights of the Gauss-Legendre rule on the unit interval, by Newton's method for the roots of the Legendre polynomial.
pub(crate) fn unit_interval(count: usize) -> Vec<(f64, f64)> {
    let point = |number: usize| {
        let angle = std::f64::consts::PI * (number as f64 + 0.75) / (count as f64 + 0.5);
        let mut x = angle.cos();
        // Newton's method converges quadratically from this start; more steps change nothing.
        for _ in 0..8 {
            let (value, slope) = legendre(count, x);
            x -= value / slope;
        }
        let (_, slope) = legendre(count, x);
        (0.5 - 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(point).collect()
}

/// Legendre polynomial of degree one or more, with its slope.
fn legendre(degree: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for n in 2..=degree {
        let n = n as f64;
        (before, value) = (
            value,
            ((2.0 * n - 1.0) * x * value - (n - 1.0) * before) / n,
        );
    }
    let slope = degree as f64 * (before - x * value) / (1.0 - x * x);
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::unit_interval;

    #[test]
    fn gauss_points_integrate_powers_up_to_twice_their_number() {
        for count in 1..9 {
            for power in 0..2 * count {
                let points = unit_interval(count).into_iter();
                let found: f64 = points.map(|(x, w)| w * x.powi(power as i32)).sum();
                assert!((found - 1.0 / (power + 1) as f64).abs() < 1e-14);
            }
        }
    }
}
