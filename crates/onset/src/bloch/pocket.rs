//! Pockets of complex `omega^2` between the points at which spectra are known.

use super::growth_rate;
use super::system::MatrixExpansion;
use crate::algebra::{Complex, Decomposition, sort_by_value};
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
/// How often steps are halved around points from which branches that may meet are not seen well enough.
const HALVINGS: usize = 4;
/// They are seen well enough where second order changes their difference by less than this part of what first order does.
const RESOLVED: f64 = 0.5;
/// Points between halved steps, at most.
const FINER: usize = 256;
/// Growth rates that differ by less, relative to them, are those of images of one pocket under the symmetry of the lattice.
const SAME: f64 = 1e-9;
/// Wave vectors that agree to this part of a step are in one pocket.
const APART: f64 = 0.25;
/// Eigenvectors on both sides whose sizes have such a product are nearly dependent, and tell nothing of the neighborhood.
const DEPENDENT: f64 = 1e6;

/// A wave vector in a pocket that is foreseen.
#[derive(Clone, Copy)]
struct Candidate<const D: usize> {
    growth: f64,
    wave_vector: SVector<f64, D>,
    /// The steps within which it is foreseen, as a part of those of the grid.
    share: f64,
}

/// What the spectrum at a wave vector tells of its neighborhood.
struct Outlook<const D: usize> {
    foreseen: Option<Candidate<D>>,
    /// What second order changes over what first order does, of branches that may meet; zero where they are seen well enough.
    unresolved: f64,
}

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

/// What is looked for, where.
pub(super) struct Pockets<'a, const D: usize> {
    /// `D(k)` with its derivatives; `None` where a wave vector is not looked at.
    pub(super) expansion: &'a dyn Fn(&SVector<f64, D>) -> Option<MatrixExpansion<D>>,
    /// Steps between the points of the grid, as columns.
    pub(super) steps: SMatrix<f64, D, D>,
    /// Growth rates below are not flutter.
    pub(super) threshold: f64,
    /// How many are looked at again.
    pub(super) most: usize,
}

impl<const D: usize> Pockets<'_, D> {
    /// Wave vectors in pockets of complex `omega^2`, foreseen from points of a grid and from finer ones where these do not tell,
    /// and looked at again from where they are foreseen; the fastest growing first.
    pub(super) fn around(
        &self,
        points: impl Iterator<Item = SVector<f64, D>>,
    ) -> Vec<SVector<f64, D>> {
        let mut all = self.foreseen(points);
        let mut most = self.most;
        for _ in 0..CLOSER {
            self.leave_fastest(&mut all, most);
            most /= 2;
            let again =
                |own: &Candidate<D>| self.outlook(&own.wave_vector, NEARER * own.share)?.foreseen;
            all = all.iter().filter_map(again).collect();
        }
        self.leave_fastest(&mut all, most / 2);
        all.into_iter().map(|own| own.wave_vector).collect()
    }

    /// Pockets that are foreseen from points of the grid; and, where second order changes the difference of branches that may meet
    /// as much as first order does, from points between them. So it is around `k = 0`, and where soft branches bend much within a step.
    fn foreseen(&self, points: impl Iterator<Item = SVector<f64, D>>) -> Vec<Candidate<D>> {
        let mut all = Vec::new();
        let (mut points, mut share) = (points.collect::<Vec<_>>(), 1.0);
        // Of k and -k one is enough.
        let mut between = self.between(&SVector::zeros(), share);
        between.truncate(1 << (D - 1));
        for _ in 0..=HALVINGS {
            let mut unresolved = Vec::new();
            for k in &points {
                if let Some(outlook) = self.outlook(k, share) {
                    all.extend(outlook.foreseen);
                    if outlook.unresolved > 0.0 {
                        unresolved.push((outlook.unresolved, *k));
                    }
                }
            }
            sort_by_value(&mut unresolved, |item| -item.0);
            unresolved.truncate(FINER >> D);
            for (_, k) in unresolved {
                between.extend(self.between(&k, share));
            }
            points = std::mem::take(&mut between);
            share *= 0.5;
        }
        all
    }

    /// The points around a wave vector between which steps are half as long.
    fn between(&self, k: &SVector<f64, D>, share: f64) -> Vec<SVector<f64, D>> {
        let at = |corner: usize| {
            let side = grid_coordinates::<D>(corner, 2).map(|n| n as f64 - 0.5);
            k + self.steps * SVector::from(side) * (0.5 * share)
        };
        (0..1 << D).map(at).collect()
    }

    /// What the spectrum at a wave vector with its derivatives tells of its neighborhood. `None` where it is not looked at, or its
    /// eigenvectors are nearly dependent.
    fn outlook(&self, k: &SVector<f64, D>, share: f64) -> Option<Outlook<D>> {
        let expansion = (self.expansion)(k)?;
        let steps = self.steps * share;
        let all = Decomposition::new(expansion.value.clone())?;
        if all.left.norm() * all.right.norm() > DEPENDENT {
            return None;
        }
        let turned = |matrix: DMatrix<Complex>| &all.left * matrix * &all.right;
        let along = |a: usize| steps.column(a).into_owned();
        let near = Neighborhood {
            values: &all.values,
            first: std::array::from_fn(|a| turned(expansion.slope(&along(a)))),
            second: std::array::from_fn(|a| turned(expansion.curvature(&along(a)))),
        };
        let (mut fastest, mut unresolved) = ((0.0, [0.0; D]), 0.0_f64);
        for j in 1..all.values.len() {
            for i in 0..j {
                let own = near.pair(i, j).fastest();
                if own.0 > fastest.0 {
                    fastest = own;
                }
                unresolved = unresolved.max(near.unresolved(i, j));
            }
        }
        let (growth, place) = fastest;
        let foreseen = (growth > self.threshold).then(|| Candidate {
            growth,
            wave_vector: k + steps * SVector::from(place),
            share,
        });
        Some(Outlook {
            foreseen,
            unresolved,
        })
    }

    /// Leaves the fastest growing pockets: one of those that are images of each other, and of those that are foreseen from several
    /// points.
    fn leave_fastest(&self, all: &mut Vec<Candidate<D>>, most: usize) {
        sort_by_value(all, |mode| -mode.growth);
        all.dedup_by(|b, a| (a.growth - b.growth).abs() <= SAME * a.growth);
        let Some(to_steps) = self.steps.try_inverse() else {
            return;
        };
        let mut taken = HashSet::new();
        all.retain(|own| {
            let place = to_steps * own.wave_vector / (APART * own.share);
            taken.insert((place.map(|x| x.round() as i64), own.share.to_bits()))
        });
        all.truncate(most);
    }
}

/// The matrix around a wave vector, of whose eigenvectors it is diagonal there.
struct Neighborhood<'a, const D: usize> {
    values: &'a [Complex],
    /// How it changes with a step along each axis, to first order.
    first: [DMatrix<Complex>; D],
    /// Its second derivatives by steps.
    second: [DMatrix<Complex>; D],
}

impl<const D: usize> Neighborhood<'_, D> {
    fn pair(&self, i: usize, j: usize) -> Pair<D> {
        let entry = |i: usize, j: usize| std::array::from_fn(|a| self.first[a][(i, j)]);
        Pair {
            values: [self.values[i], self.values[j]],
            slopes: [entry(i, i), entry(j, j)],
            couplings: [entry(i, j), entry(j, i)],
        }
    }

    /// What second order changes of the difference of two branches within reach, over what first order does; zero where they cannot
    /// meet or second order is small.
    fn unresolved(&self, i: usize, j: usize) -> f64 {
        let change = |matrix: &DMatrix<Complex>| {
            let coupling = (matrix[(i, j)] * matrix[(j, i)]).norm().sqrt();
            (matrix[(i, i)] - matrix[(j, j)]).norm() + 2.0 * coupling
        };
        let first: f64 = self.first.iter().map(|m| REACH * change(m)).sum();
        let bent: f64 = self
            .second
            .iter()
            .map(|m| 0.5 * REACH * REACH * change(m))
            .sum();
        let second = bent + self.repulsion(i, j) + self.repulsion(j, i);
        let may_meet = (self.values[i] - self.values[j]).norm() <= first + second;
        match may_meet && second > RESOLVED * first {
            true => second / first,
            false => 0.0,
        }
    }

    /// How far the other branches push one of a pair within reach, to second order; no farther than they are coupled.
    fn repulsion(&self, own: usize, partner: usize) -> f64 {
        let others = (0..self.values.len()).filter(|m| *m != own && *m != partner);
        let push = |m: usize| {
            let apart = (self.values[own] - self.values[m]).norm();
            let coupling = |matrix: &DMatrix<Complex>| {
                let coupling = REACH * (matrix[(own, m)] * matrix[(m, own)]).norm().sqrt();
                coupling * (coupling / apart).min(1.0)
            };
            self.first.iter().map(coupling).sum::<f64>()
        };
        others.map(push).sum()
    }
}
