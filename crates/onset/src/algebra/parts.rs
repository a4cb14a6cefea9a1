//! Products of complex matrices from their real and imaginary parts.

use super::Complex;
use nalgebra::DMatrix;

/// Complex matrix stored as its real and imaginary part. Products of real matrices are vectorized, products of complex matrices are not.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    real: DMatrix<f64>,
    imaginary: DMatrix<f64>,
}

impl Parts {
    pub(crate) fn of(matrix: DMatrix<Complex>) -> Self {
        Self {
            real: matrix.map(|z| z.re),
            imaginary: matrix.map(|z| z.im),
        }
    }

    /// Product of two matrices.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let (x, y) = (self, other);
        Self {
            real: &x.real * &y.real - &x.imaginary * &y.imaginary,
            imaginary: &x.real * &y.imaginary + &x.imaginary * &y.real,
        }
    }

    pub(crate) fn joined(&self) -> DMatrix<Complex> {
        self.real.zip_map(&self.imaginary, Complex::new)
    }
}

#[cfg(test)]
mod tests {
    use super::Parts;
    use crate::algebra::{Complex, uniform};
    use nalgebra::DMatrix;

    #[test]
    fn products_of_real_and_imaginary_parts_give_the_complex_product() {
        let mut random = 3;
        let mut matrix = |rows, columns| {
            let mut number = || 2.0 * uniform(&mut random) - 1.0;
            DMatrix::from_fn(rows, columns, |_, _| Complex::new(number(), number()))
        };
        let (x, y) = (matrix(5, 7), matrix(7, 4));
        let product = Parts::of(x.clone()).times(&Parts::of(y.clone())).joined();
        assert!((product - x * y).norm() < 1e-13);
    }
}
