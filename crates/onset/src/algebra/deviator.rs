//! Eigenvalues of real 3 x 3 matrices in closed form, from trace and deviator.
//!
//! With `K = D - mean` they are `mean + x`, `x^3 - 3 a x - 2 h = 0`, where `a = tr K^2 / 6` and `h = det K / 2`. Two of them are complex if the
//! discriminant `a^3 - h^2` is negative.

use std::f64::consts::TAU;

/// Real eigenvalues are well separated if the ratio of the discriminant to `a^3` exceeds this value.
const SEPARATION: f64 = 1e-2;
/// Ratio of `tr K^2` to the squared norm of `K`, which is one for a symmetric `K`. For smaller ratios the matrix is far from normal, and trace and
/// determinant cancel.
const NORMALITY: f64 = 0.5;

/// A third of the trace, and `a` and `h` of the deviator.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deviator {
    pub(crate) mean: f64,
    pub(crate) a: f64,
    pub(crate) h: f64,
}

impl Deviator {
    /// Computes the deviator from the entries of a matrix, by rows.
    #[inline(always)]
    pub(crate) fn of(d: &[f64; 9]) -> Self {
        let mean = (d[0] + d[4] + d[8]) / 3.0;
        let [x, y, z] = [d[0] - mean, d[4] - mean, d[8] - mean];
        let square = x * x + y * y + z * z + 2.0 * (d[1] * d[3] + d[2] * d[6] + d[5] * d[7]);
        let determinant = x * (y * z - d[5] * d[7]) - d[1] * (d[3] * z - d[5] * d[6])
            + d[2] * (d[3] * d[7] - y * d[6]);
        Self {
            mean,
            a: square / 6.0,
            h: 0.5 * determinant,
        }
    }

    /// Discriminant `a^3 - h^2` of the characteristic polynomial.
    #[inline(always)]
    pub(crate) fn discriminant(&self) -> f64 {
        self.a * self.a * self.a - self.h * self.h
    }

    /// Smallest and largest eigenvalue if all are real. If two are nearly equal, the error is the square root of rounding.
    #[inline(always)]
    pub(crate) fn outer(&self) -> [f64; 2] {
        let root = self.a.max(0.0).sqrt();
        let cube = self.a * root;
        let cosine = if cube > 0.0 {
            (self.h / cube).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        let angle = cosine.acos() / 3.0;
        [angle + TAU / 3.0, angle].map(|angle| self.mean + 2.0 * root * angle.cos())
    }

    /// All eigenvalues in increasing order if they are real.
    pub(crate) fn all(&self) -> [f64; 3] {
        let [lowest, highest] = self.outer();
        [lowest, 3.0 * self.mean - lowest - highest, highest]
    }

    /// Returns true if all eigenvalues are real and so well separated that the closed form is accurate to about ten times the rounding error `noise`
    /// of an entry.
    pub(crate) fn is_apart(&self, d: &[f64; 9], noise: f64) -> bool {
        let told = self.discriminant() > SEPARATION * self.a * self.a * self.a;
        let entry = |e: usize| match e {
            0 | 4 | 8 => d[e] - self.mean,
            _ => d[e],
        };
        let squares: f64 = (0..9).map(|e| entry(e) * entry(e)).sum();
        told && 6.0 * self.a > NORMALITY * squares && self.a.sqrt() * SEPARATION > noise
    }
}

#[cfg(test)]
mod tests {
    use super::Deviator;
    use crate::algebra::uniform;
    use nalgebra::{Matrix3, Vector3};

    /// Matrices with known eigenvalues, in increasingly oblique axes.
    #[test]
    fn separated_eigenvalues_are_accurate_to_rounding_and_others_are_rejected() {
        let (mut state, mut taken) = (5, [0; 4]);
        let mut random = || 2.0 * uniform(&mut state) - 1.0;
        for _ in 0..400 {
            for (n, oblique) in [0.0, 0.3, 3.0, 1e4].into_iter().enumerate() {
                let mut values = [random(), random(), random()];
                values.sort_by(f64::total_cmp);
                let axes = Matrix3::from_fn(|_, _| random()).qr().q();
                let slant = Matrix3::from_fn(|i, j| match i < j {
                    true => oblique * random(),
                    false => f64::from(u8::from(i == j)),
                });
                let slanted = axes * slant;
                let inverse = slanted.try_inverse().expect("unit triangles have inverses");
                let matrix = slanted * Matrix3::from_diagonal(&Vector3::from(values)) * inverse;
                let entries: [f64; 9] = std::array::from_fn(|e| matrix[(e / 3, e % 3)]);
                let deviator = Deviator::of(&entries);
                if !deviator.is_apart(&entries, 1e-15) {
                    continue;
                }
                taken[n] += 1;
                for (own, exact) in deviator.all().into_iter().zip(values) {
                    let error = (own - exact).abs();
                    assert!(
                        error < 1e-14 * (1.0 + oblique).powi(2),
                        "{oblique} {error:e}"
                    );
                }
            }
        }
        assert!(
            taken[0] > 300 && taken[1] > 100 && taken[3] == 0,
            "{taken:?}"
        );
    }
}
