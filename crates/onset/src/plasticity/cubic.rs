//! Homogeneous cubic polynomials on a triangle, with bounds.

use crate::real::Real;
use nalgebra::Vector3;

/// Sum of products of three linear forms in `(x1, x2, x3)`, stored as its symmetric trilinear form.
///
/// The value at `x` is the form at `(x, x, x)`. The values at triples of corners of a simplex are the Bernstein coefficients on the simplex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cubic {
    /// Form at the unit vectors `(e_i, e_j, e_k)`.
    form: [[[f64; 3]; 3]; 3],
}

impl Cubic {
    /// Adds the product of three linear forms.
    pub(super) fn add(&mut self, factors: [Vector3<f64>; 3]) {
        const ORDERS: [[usize; 3]; 6] = [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ];
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    self.form[i][j][k] += ORDERS
                        .iter()
                        .map(|[a, b, c]| factors[*a][i] * factors[*b][j] * factors[*c][k])
                        .sum::<f64>()
                        / 6.0;
                }
            }
        }
    }

    /// Value of the polynomial at a point.
    pub(super) fn at<R: Real>(&self, x: &[R; 3]) -> R {
        let mut sum = R::constant(0.0);
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    sum = sum + x[i] * x[j] * x[k] * self.form[i][j][k];
                }
            }
        }
        sum
    }

    /// Value of the trilinear form at three points.
    fn polar(&self, u: &Vector3<f64>, v: &Vector3<f64>, w: &Vector3<f64>) -> f64 {
        let mut sum = 0.0;
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    sum += self.form[i][j][k] * u[i] * v[j] * w[k];
                }
            }
        }
        sum
    }

    /// Bernstein coefficients on the simplex with the given corners. The values on it lie between the smallest and the largest coefficient.
    pub(super) fn coefficients(&self, corners: &[Vector3<f64>]) -> Vec<f64> {
        let count = corners.len();
        let mut coefficients = Vec::with_capacity(10);
        for i in 0..count {
            for j in i..count {
                for k in j..count {
                    coefficients.push(self.polar(&corners[i], &corners[j], &corners[k]));
                }
            }
        }
        coefficients
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_enclose_the_product_on_every_part_of_the_triangle() {
        let factors = [
            Vector3::new(1.0, -2.0, 0.5),
            Vector3::new(0.3, 0.7, -1.1),
            Vector3::new(2.0, 0.1, 0.4),
        ];
        let mut cubic = Cubic::default();
        cubic.add(factors);
        let corners = [
            Vector3::new(0.5, 0.3, 0.2),
            Vector3::new(0.1, 0.8, 0.1),
            Vector3::new(0.0, 0.25, 0.75),
        ];
        let coefficients = cubic.coefficients(&corners);
        let (low, high) = coefficients
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| {
                (low.min(*c), high.max(*c))
            });
        for a in 0..=10 {
            for b in 0..=10 - a {
                let (a, b) = (f64::from(a) / 10.0, f64::from(b) / 10.0);
                let x = corners[0] * a + corners[1] * b + corners[2] * (1.0 - a - b);
                let product: f64 = factors.iter().map(|factor| factor.dot(&x)).product();
                assert!((cubic.at(&[x[0], x[1], x[2]]) - product).abs() < 1e-15);
                assert!(product >= low - 1e-15 && product <= high + 1e-15);
            }
        }
    }
}
