//! Pockets of complex `omega^2` between the points at which spectra are known.

use super::WaveSystem;
use crate::algebra::{Complex, Decomposition};
use crate::bloch::growth_rate;
use nalgebra::{DMatrix, SMatrix, SVector};

/// How far from its point a model is used, in steps: a little beyond the middle between two points.
const REACH: f64 = 0.6;
/// Places along each axis at which two branches are followed to where they meet.
const PLACES: usize = 7;
/// Eigenvectors on both sides whose sizes have such a product are nearly dependent, and tell nothing of the neighborhood.
const DEPENDENT: f64 = 1e6;

/// Two branches near a point, to first order in the eigenvectors there: the matrix `((l + a.u, b.u), (c.u, m + e.u))`, whose
/// eigenvalues are complex in a pocket around where the branches would cross.
struct Pair<const D: usize> {
    values: [Complex; 2],
    slopes: [[Complex; D]; 2],
    /// `b` and `c`.
    couplings: [[Complex; D]; 2],
}

impl<const D: usize> Pair<D> {
    /// The eigenvalues at `u`.
    fn at(&self, u: &[f64; D]) -> [Complex; 2] {
        let along = |slope: &[Complex; D]| -> Complex {
            slope.iter().zip(u).map(|(slope, u)| slope * u).sum()
        };
        let [first, second] = [0, 1].map(|n| self.values[n] + along(&self.slopes[n]));
        let [there, back] = [0, 1].map(|n| along(&self.couplings[n]));
        let (mean, half) = ((first + second) * 0.5, (first - second) * 0.5);
        let root = (half * half + there * back).sqrt();
        [mean + root, mean - root]
    }

    /// The fastest growth within reach, and where: looked for along the line or surface on which the branches would cross.
    fn fastest(&self) -> (f64, [f64; D]) {
        let mut fastest = (0.0, [0.0; D]);
        let mut look = |u: [f64; D]| {
            let growth = self.at(&u).map(growth_rate).into_iter().fold(0.0, f64::max);
            if growth > fastest.0 {
                fastest = (growth, u);
            }
        };
        look([0.0; D]);
        let distance = (self.values[0] - self.values[1]).re;
        let closing: [f64; D] = std::array::from_fn(|a| (self.slopes[0][a] - self.slopes[1][a]).re);
        let mut steepest = 0;
        for a in 1..D {
            if closing[a].abs() > closing[steepest].abs() {
                steepest = a;
            }
        }
        for place in 0..PLACES.pow(D as u32 - 1) {
            let (mut u, mut rest, mut gap) = ([0.0; D], place, distance);
            for a in (0..D).filter(|a| *a != steepest) {
                u[a] = REACH * (2.0 * (rest % PLACES) as f64 / (PLACES - 1) as f64 - 1.0);
                gap += closing[a] * u[a];
                rest /= PLACES;
            }
            let crossing = -gap / closing[steepest];
            if crossing.abs() <= 2.0 * REACH {
                u[steepest] = crossing.clamp(-REACH, REACH);
                look(u);
            }
        }
        fastest
    }
}

impl<const D: usize> WaveSystem<D> {
    /// The fastest growth with complex `omega^2` that the spectrum at a wave vector, with its slopes, foresees around it, and where;
    /// `steps` are the distances to the next points, as columns. `None` where the eigenvectors are nearly dependent.
    pub(super) fn foreseen_growth(
        &self,
        k: &SVector<f64, D>,
        steps: &SMatrix<f64, D, D>,
    ) -> Option<(f64, SVector<f64, D>)> {
        let expansion = self.slopes_at(k);
        let all = Decomposition::new(expansion.0)?;
        if all.left.norm() * all.right.norm() > DEPENDENT {
            return None;
        }
        let turned: Vec<DMatrix<Complex>> = steps
            .column_iter()
            .map(|step| {
                let along = expansion.1.iter().zip(step.iter());
                let size = all.values.len();
                let slope = along.fold(DMatrix::zeros(size, size), |sum, (slope, step)| {
                    sum + slope * Complex::new(*step, 0.0)
                });
                &all.left * slope * &all.right
            })
            .collect();
        let entry = |i: usize, j: usize| std::array::from_fn(|a| turned[a][(i, j)]);
        let mut fastest = (0.0, [0.0; D]);
        for j in 1..all.values.len() {
            for i in 0..j {
                let pair = Pair {
                    values: [all.values[i], all.values[j]],
                    slopes: [entry(i, i), entry(j, j)],
                    couplings: [entry(i, j), entry(j, i)],
                };
                let own = pair.fastest();
                if own.0 > fastest.0 {
                    fastest = own;
                }
            }
        }
        Some((fastest.0, k + steps * SVector::from(fastest.1)))
    }
}
