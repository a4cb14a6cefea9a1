//! Trigonometric polynomials in one angle, and all their real zeros.

use super::Complex;

/// Real trigonometric polynomial `sum_m c_m exp(i m t)`, `|m| <= order`, `c_-m = conj(c_m)`.
#[derive(Clone, Debug, PartialEq)]
pub struct TrigonometricPolynomial {
    /// Coefficients `c_0, c_1, ..., c_order` of the sum.
    coefficients: Vec<Complex>,
}

impl TrigonometricPolynomial {
    /// Creates the polynomial `constant + cosine cos t + sine sin t`.
    pub fn first_order(constant: f64, cosine: f64, sine: f64) -> Self {
        Self {
            coefficients: vec![
                Complex::new(constant, 0.0),
                Complex::new(0.5 * cosine, -0.5 * sine),
            ],
        }
    }

    /// Largest coefficient in magnitude.
    pub fn magnitude(&self) -> f64 {
        self.coefficients
            .iter()
            .map(|c| c.norm())
            .fold(0.0, f64::max)
    }

    fn order(&self) -> usize {
        self.coefficients.len() - 1
    }

    fn coefficient(&self, m: isize) -> Complex {
        match self.coefficients.get(m.unsigned_abs()) {
            Some(c) if m >= 0 => *c,
            Some(c) => c.conj(),
            None => Complex::new(0.0, 0.0),
        }
    }

    /// Value at the angle `t`.
    pub fn at(&self, t: f64) -> f64 {
        let step = Complex::new(t.cos(), t.sin());
        let mut phase = step;
        let mut sum = self.coefficients[0].re;
        for c in &self.coefficients[1..] {
            sum += 2.0 * (c * phase).re;
            phase *= step;
        }
        sum
    }

    /// Derivative with respect to the angle.
    pub fn derivative(&self) -> Self {
        let differentiate = |(m, c): (usize, &Complex)| Complex::new(0.0, m as f64) * c;
        Self {
            coefficients: self
                .coefficients
                .iter()
                .enumerate()
                .map(differentiate)
                .collect(),
        }
    }

    /// Linear combination `a self + b other` of polynomials.
    pub fn combine(&self, a: f64, other: &Self, b: f64) -> Self {
        let order = self.order().max(other.order()) as isize;
        let sum = |m| self.coefficient(m) * a + other.coefficient(m) * b;
        Self {
            coefficients: (0..=order).map(sum).collect(),
        }
    }

    /// Product with another polynomial.
    pub fn times(&self, other: &Self) -> Self {
        let (own, foreign) = (self.order() as isize, other.order() as isize);
        let convolve = |m: isize| {
            (-own..=own)
                .map(|n| self.coefficient(n) * other.coefficient(m - n))
                .sum::<Complex>()
        };
        Self {
            coefficients: (0..=own + foreign).map(convolve).collect(),
        }
    }

    /// Returns angles that include all real zeros, to rounding; they may include others.
    ///
    /// With `z = exp(i t)` the polynomial becomes `z^-order` times an algebraic polynomial of degree `2 order`, whose zeros on the unit circle are
    /// needed. All its zeros are computed together (Aberth, Math. Comp. 27 (1973) 339) and the angle of each zero is returned, because a multiple
    /// zero is less accurate, possibly off the circle, and must not be lost. Callers minimize over the angles, so a spurious angle has no effect.
    pub fn zero_candidates(&self) -> Vec<f64> {
        let scale = self.magnitude();
        let mut order = self.order();
        while order > 0 && self.coefficients[order].norm() <= 1e-15 * scale {
            order -= 1;
        }
        let order = order as isize;
        let ascending: Vec<Complex> = (-order..=order).map(|m| self.coefficient(m)).collect();
        aberth(&ascending)
            .into_iter()
            .map(|z| z.im.atan2(z.re))
            .collect()
    }

    /// Returns the global minimum over the angle: `(angle, value)`.
    pub fn minimum(&self) -> (f64, f64) {
        let mut best = (0.0, self.at(0.0));
        for t in self.derivative().zero_candidates() {
            let value = self.at(t);
            if value < best.1 {
                best = (t, value);
            }
        }
        best
    }
}

/// All zeros of a polynomial with ascending coefficients by simultaneous iteration.
fn aberth(ascending: &[Complex]) -> Vec<Complex> {
    let degree = ascending.len() - 1;
    let mut zeros: Vec<Complex> = (0..degree)
        // Asymmetric start: no symmetry of the zeros may be a fixed point of the iteration.
        .map(|n| Complex::from_polar(1.1, 0.4 + std::f64::consts::TAU * n as f64 / degree as f64))
        .collect();
    // Simple zeros converge cubically in a few sweeps. Multiple zeros converge linearly, to at best the square root of rounding, and need a few more
    // sweeps.
    for _ in 0..24 {
        let mut largest_step = 0.0_f64;
        for n in 0..degree {
            let z = zeros[n];
            let (mut value, mut slope) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
            for c in ascending.iter().rev() {
                slope = slope * z + value;
                value = value * z + c;
            }
            if value.norm_sqr() == 0.0 {
                continue;
            }
            let newton = slope / value;
            let repulsion: Complex = (0..degree)
                .filter(|&other| other != n && zeros[other] != z)
                .map(|other| (z - zeros[other]).inv())
                .sum();
            let step = (newton - repulsion).inv();
            if step.is_finite() {
                zeros[n] -= step;
                largest_step = largest_step.max(step.norm_sqr() / zeros[n].norm_sqr().max(1.0));
            }
        }
        if largest_step < 1e-30 {
            break;
        }
    }
    zeros
}

#[cfg(test)]
mod tests {
    use super::TrigonometricPolynomial;

    #[test]
    fn a_minimum_between_samples_is_found() {
        // A narrow minimum: (1 - cos(t - 0.123456))^1 plus a slope, squared.
        let shifted =
            TrigonometricPolynomial::first_order(1.0, -(0.123456_f64).cos(), -(0.123456_f64).sin());
        let quartic = shifted.times(&shifted);
        let (angle, value) = quartic.minimum();
        assert!((angle - 0.123456).abs() < 1e-4, "{angle}");
        assert!(value.abs() < 1e-15);
        assert!((quartic.at(1.0) - (1.0 - (1.0_f64 - 0.123456).cos()).powi(2)).abs() < 1e-15);
    }

    #[test]
    fn zeros_of_a_product_are_the_zeros_of_its_factors() {
        let a = TrigonometricPolynomial::first_order(0.2, 1.0, 0.5);
        let b = TrigonometricPolynomial::first_order(-0.1, 0.3, -1.0);
        let product = a.times(&b);
        for factor in [&a, &b] {
            for zero in factor.zero_candidates() {
                let nearest = product
                    .zero_candidates()
                    .into_iter()
                    .map(|t| (t - zero).sin().abs())
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-12, "{zero} is lost");
            }
        }
    }
}
