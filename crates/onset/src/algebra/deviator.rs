//! Eigenvalues of real matrices of three rows in closed form, by trace and deviator.
//!
//! With `K = D - mean` they are `mean + x`, `x^3 - 3 a x - 2 h = 0`, where `a = tr K^2 / 6` and `h = det K / 2`; two of them are complex where the
//! discriminant `a^3 - h^2` is negative.

use std::f64::consts::TAU;

/// Real eigenvalues are well apart where the discriminant is more than this fraction of `a^3`: what rounding changes of them is then no more than ten times
/// what it changes of the matrix.
const APART: f64 = 1e-2;

/// A third of the trace, and `a` and `h` of the deviator.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deviator {
    pub(crate) mean: f64,
    pub(crate) a: f64,
    pub(crate) h: f64,
}

impl Deviator {
    /// Of the entries of a matrix, by rows.
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

    /// `a^3 - h^2`.
    #[inline(always)]
    pub(crate) fn discriminant(&self) -> f64 {
        self.a * self.a * self.a - self.h * self.h
    }

    /// The smallest and the largest eigenvalue where all are real; where two are nearly equal, to the square root of rounding.
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

    /// All eigenvalues by size where they are real.
    pub(crate) fn all(&self) -> [f64; 3] {
        let [lowest, highest] = self.outer();
        [lowest, 3.0 * self.mean - lowest - highest, highest]
    }

    /// Whether all eigenvalues are real and so far from each other that the closed form tells them to rounding, given the rounding error of an entry.
    pub(crate) fn is_apart(&self, noise: f64) -> bool {
        let told = self.discriminant() > APART * self.a * self.a * self.a;
        told && self.a.sqrt() * APART > noise
    }
}
