//! Pockets of complex `omega^2` between the points at which spectra are known.

use super::growth_rate;
use crate::algebra::{Complex, Decomposition};
use crate::lattice::grid_coordinates;
use nalgebra::{DMatrix, SMatrix, SVector};
use std::collections::HashSet;

/// How far from its point a model is used, in steps: a little beyond the middle between two points.
const REACH: f64 = 0.6;
/// Places along each axis at which two branches are followed to where they meet.
const PLACES: usize = 7;
/// How often a pocket that is foreseen is looked at again from nearer, each time with the steps shortened by this factor.
const CLOSER: usize = 3;
const NEARER: f64 = 0.3;
/// Distances from k = 0, in steps, from which its neighborhood is looked at.
const SHARES: [f64; 3] = [0.5, 0.2, 0.08];
/// Growth rates that differ by less, relative to them, are those of images of one pocket under the symmetry of the lattice.
const SAME: f64 = 1e-9;
/// Wave vectors that agree to this part of a step are in one pocket.
const APART: f64 = 0.25;
/// Eigenvectors on both sides whose sizes have such a product are nearly dependent, and tell nothing of the neighborhood.
const DEPENDENT: f64 = 1e6;

/// A wave vector with the growth rate foreseen there.
type Candidate<const D: usize> = (f64, SVector<f64, D>);

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

    /// The real part of the product of the couplings at `u`: where branches cross, `omega^2` is complex if it is negative.
    fn product(&self, u: &[f64; D]) -> f64 {
        let [there, back] = [0, 1].map(|n| -> Complex {
            let coupling = self.couplings[n].iter();
            coupling.zip(u).map(|(slope, u)| slope * u).sum()
        });
        (there * back).re
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
        let steepest = (0..D).fold(0, |most, a| {
            if closing[a].abs() > closing[most].abs() {
                a
            } else {
                most
            }
        });
        // The place with given coordinates along the other axes at which the branches would cross.
        let crossing = |mut u: [f64; D]| {
            u[steepest] = 0.0;
            let gap = distance
                + closing
                    .iter()
                    .zip(&u)
                    .map(|(slope, u)| slope * u)
                    .sum::<f64>();
            u[steepest] = -gap / closing[steepest];
            u
        };
        let mut look_at = |u: [f64; D]| {
            let u = crossing(u);
            if u[steepest].abs() <= 2.0 * REACH {
                look(u.map(|x| x.clamp(-REACH, REACH)));
            }
        };
        for place in 0..PLACES.pow(D as u32 - 1) {
            let (mut u, mut rest) = ([0.0; D], place);
            for a in (0..D).filter(|a| *a != steepest) {
                u[a] = REACH * (2.0 * (rest % PLACES) as f64 / (PLACES - 1) as f64 - 1.0);
                rest /= PLACES;
            }
            look_at(u);
            // Along each axis the product of the couplings is quadratic, and can be negative between two places only.
            for a in (0..D).filter(|a| *a != steepest) {
                let at = |x: f64| {
                    let mut u = u;
                    u[a] = x;
                    self.product(&crossing(u))
                };
                let [behind, middle, ahead] = [-REACH, 0.0, REACH].map(at);
                let (slope, curvature) = (0.5 * (ahead - behind), ahead - 2.0 * middle + behind);
                if curvature > 0.0 {
                    u[a] = (-slope / curvature * REACH).clamp(-REACH, REACH);
                    look_at(u);
                }
            }
        }
        fastest
    }
}

/// `D(k)` and its derivatives by the components of the wave vector.
pub(super) type Slopes<const D: usize> = (DMatrix<Complex>, [DMatrix<Complex>; D]);

/// What is looked for, where.
pub(super) struct Pockets<'a, const D: usize> {
    /// `D(k)` with its slopes; `None` where a wave vector is not looked at.
    pub(super) slopes: &'a dyn Fn(&SVector<f64, D>) -> Option<Slopes<D>>,
    /// Growth rates below are not flutter.
    pub(super) threshold: f64,
    /// How many are looked at again.
    pub(super) most: usize,
}

impl<const D: usize> Pockets<'_, D> {
    /// Wave vectors in pockets of complex `omega^2`, foreseen from points with given steps between them (as columns) and around `k = 0`,
    /// and looked at again from where they are foreseen; the fastest growing first.
    pub(super) fn around(
        &self,
        points: impl Iterator<Item = SVector<f64, D>>,
        steps: &SMatrix<f64, D, D>,
    ) -> Vec<SVector<f64, D>> {
        let mut all: Vec<Candidate<D>> = points.filter_map(|k| self.foreseen(&k, steps)).collect();
        // Around k = 0, where branches meet that change with the direction, points are as near to each other as to it.
        for share in SHARES {
            let nearer = steps * share;
            let around = 3_usize.pow(D as u32) / 2 + 1..3_usize.pow(D as u32);
            all.extend(around.filter_map(|place| {
                let side = grid_coordinates::<D>(place, 3).map(|n| n as f64 - 1.0);
                self.foreseen(&(nearer * SVector::from(side)), &(nearer * 0.7))
            }));
        }
        let (mut narrower, mut most) = (*steps, self.most);
        for _ in 0..CLOSER {
            fastest(&mut all, most, &narrower);
            narrower *= NEARER;
            most /= 2;
            let again = |(_, k): &Candidate<D>| self.foreseen(k, &narrower);
            all = all.iter().filter_map(again).collect();
        }
        fastest(&mut all, most / 2, &narrower);
        all.into_iter().map(|(_, k)| k).collect()
    }

    /// The fastest growth with complex `omega^2` that the spectrum at a wave vector, with its slopes, foresees around it, and where.
    /// `None` where there is none, or the eigenvectors are nearly dependent.
    fn foreseen(&self, k: &SVector<f64, D>, steps: &SMatrix<f64, D, D>) -> Option<Candidate<D>> {
        let (value, slopes) = (self.slopes)(k)?;
        let all = Decomposition::new(value)?;
        if all.left.norm() * all.right.norm() > DEPENDENT {
            return None;
        }
        let turned: Vec<DMatrix<Complex>> = steps
            .column_iter()
            .map(|step| {
                let along = slopes.iter().zip(step.iter());
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
        let (growth, place) = fastest;
        (growth > self.threshold).then(|| (growth, k + steps * SVector::from(place)))
    }
}

/// Leaves the fastest growing pockets: one of those that are images of each other, and of those that are foreseen from several points.
fn fastest<const D: usize>(all: &mut Vec<Candidate<D>>, most: usize, steps: &SMatrix<f64, D, D>) {
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.dedup_by(|b, a| (a.0 - b.0).abs() <= SAME * a.0);
    let Some(to_steps) = steps.try_inverse() else {
        return;
    };
    let mut taken = HashSet::new();
    all.retain(|own| {
        let place = to_steps * own.1 / APART;
        taken.insert(place.map(|x| x.round() as i64))
    });
    all.truncate(most);
}
