//! Pockets of complex `omega^2` between the points at which spectra are known.

use super::system::MatrixExpansion;
use super::{Expansion, growth_rate};
use crate::algebra::{Complex, Decomposition, Deviator, Each, Parts, array_of, sort_by_value};
use crate::cores::of_each_long;
use crate::lattice::grid_coordinates;
use nalgebra::{ComplexField, DMatrix, SMatrix, SVector};
use std::collections::HashSet;
use std::ops::Index;

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
pub(super) const FINER: usize = 256;
/// Growth rates that differ by less, relative to them, are those of images of one pocket under the symmetry of the lattice.
const SAME: f64 = 1e-9;
/// Wave vectors that agree to this part of a step are in one pocket.
const APART: f64 = 0.25;
/// Eigenvectors on both sides whose sizes have such a product are nearly dependent, and tell nothing of the neighborhood.
const DEPENDENT: f64 = 1e6;
/// Real eigenvalues that differ by less than this part of the largest entry have eigenvectors that adjugates do not tell well.
const CLOSE: f64 = 1e-5;

/// The scalars of a matrix: real or complex ones.
trait Scalar: ComplexField<RealField = f64> + Copy {}

impl Scalar for f64 {}

impl Scalar for Complex {}

/// Up to which order in the distance a neighborhood is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    First,
    /// To see where first order does not tell.
    Second,
}

/// `D(k)` with its derivatives; in real numbers where it is real.
pub(super) enum Around<const D: usize> {
    Real(Expansion<f64, D>),
    Complex(MatrixExpansion<D>),
}

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
struct Pair<S, const D: usize> {
    values: [S; 2],
    slopes: [[S; D]; 2],
    /// `b` and `c`.
    couplings: [[S; D]; 2],
}

/// A linear function of a place.
fn along<S: Scalar, const D: usize>(slope: &[S; D], u: &[f64; D]) -> S {
    let mut sum = S::zero();
    for a in 0..D {
        sum += slope[a].scale(u[a]);
    }
    sum
}

/// How fast the faster of two branches grows, given what they would be without couplings and the product of these; zero where both are real.
fn growth_of<S: Scalar>([first, second]: [S; 2], product: S) -> f64 {
    let (mean, half) = ((first + second).scale(0.5), (first - second).scale(0.5));
    let square = half * half + product;
    if mean.imaginary() == 0.0 && square.imaginary() == 0.0 {
        let (mean, square) = (mean.real(), square.real());
        // The modulus of `mean +- i root(-square)`, as `growth_rate` takes it.
        let growth = |modulus: f64| (0.5 * (modulus - mean)).max(0.0).sqrt();
        return match square < 0.0 {
            true => growth((mean * mean - square).sqrt()),
            false => 0.0,
        };
    }
    let complex = |value: S| Complex::new(value.real(), value.imaginary());
    let (mean, root) = (complex(mean), complex(square).sqrt());
    growth_rate(mean + root).max(growth_rate(mean - root))
}

/// Whether a wave whose `omega^2` has a real part of at least `p` and an imaginary one of at most the root of `q` can grow faster than a rival:
/// the growth rate is `sqrt((|omega^2| - Re omega^2) / 2)`.
pub(super) fn can_beat(rival: f64, p: f64, q: f64) -> bool {
    let square = rival * rival;
    q > 4.0 * square * (square + p)
}

impl<S: Scalar, const D: usize> Pair<S, D> {
    /// How fast the faster of the two grows at `u`.
    fn growth(&self, u: &[f64; D]) -> f64 {
        let [first, second] = [0, 1].each(|n| self.values[n] + along(&self.slopes[n], u));
        let product = along(&self.couplings[0], u) * along(&self.couplings[1], u);
        growth_of([first, second], product)
    }

    /// The fastest growth within reach, and where: looked for along the line or surface on which the branches would cross.
    fn fastest(&self) -> (f64, [f64; D]) {
        let mut fastest = (0.0, [0.0; D]);
        let mut look = |growth: f64, u: [f64; D]| {
            if growth > fastest.0 {
                fastest = (growth, u);
            }
        };
        look(self.growth(&[0.0; D]), [0.0; D]);
        let Some(crossing) = self.crossing() else {
            return fastest;
        };
        let is_real = crossing.is_real();
        let mut look_at = |mut u: [f64; D]| {
            let height = crossing.height.at(&u);
            u[crossing.axis] = height.clamp(-REACH, REACH);
            if height == u[crossing.axis] {
                // Most places: two real branches that push each other apart.
                if !is_real || crossing.product(&u).real() < 0.0 {
                    look(crossing.growth(&u), u);
                }
            } else if height.abs() <= 2.0 * REACH {
                look(self.growth(&u), u);
            }
        };
        let place = |n: usize| REACH * (2.0 * n as f64 / (PLACES - 1) as f64 - 1.0);
        let others = || (0..D).filter(|a| *a != crossing.axis);
        for number in 0..PLACES.pow(D as u32 - 1) {
            let (mut places, mut rest) = ([0; D], number);
            for a in others() {
                places[a] = rest % PLACES;
                rest /= PLACES;
            }
            let mut u = places.each(place);
            look_at(u);
            // Along a line through the places the product of the couplings is quadratic, and can be negative between two of them only.
            for a in others().filter(|a| places[*a] == 0) {
                u[a] = 0.0;
                if let Some(x) = crossing.lowest_along(a, &u) {
                    u[a] = x;
                    look_at(u);
                }
                u[a] = place(0);
            }
        }
        fastest
    }

    /// The line or surface on which the two would cross without their couplings, where it comes within reach.
    fn crossing(&self) -> Option<Crossing<S, D>> {
        let distance = (self.values[0] - self.values[1]).real();
        let closing: [f64; D] = array_of(|a| (self.slopes[0][a] - self.slopes[1][a]).real());
        let axis = (0..D).fold(0, |most, a| {
            if closing[a].abs() > closing[most].abs() {
                a
            } else {
                most
            }
        });
        let others = (0..D).filter(|a| *a != axis);
        let closed: f64 = others.map(|a| REACH * closing[a].abs()).sum();
        if distance.abs() > closed + 2.0 * REACH * closing[axis].abs() {
            return None;
        }
        let height = Affine {
            origin: -distance / closing[axis],
            slopes: array_of(|a| match a == axis {
                true => 0.0,
                false => -closing[a] / closing[axis],
            }),
        };
        let on = |value: S, slopes: &[S; D]| Affine {
            origin: value + slopes[axis].scale(height.origin),
            slopes: array_of(|a| match a == axis {
                true => S::zero(),
                false => slopes[a] + slopes[axis].scale(height.slopes[a]),
            }),
        };
        Some(Crossing {
            axis,
            values: [0, 1].each(|n| on(self.values[n], &self.slopes[n])),
            couplings: [0, 1].each(|n| on(S::zero(), &self.couplings[n])),
            height,
        })
    }
}

/// A linear function of a place and a constant.
#[derive(Clone, Copy)]
struct Affine<S, const D: usize> {
    origin: S,
    slopes: [S; D],
}

impl<S: Scalar, const D: usize> Affine<S, D> {
    fn at(&self, u: &[f64; D]) -> S {
        self.origin + along(&self.slopes, u)
    }

    fn is_real(&self) -> bool {
        let mut all = self.slopes.iter().chain([&self.origin]);
        all.all(|own| own.imaginary() == 0.0)
    }
}

/// Two branches where they would cross, by the places along all axes but one.
struct Crossing<S, const D: usize> {
    /// The axis along which they close most steeply.
    axis: usize,
    /// The place along it.
    height: Affine<f64, D>,
    values: [Affine<S, D>; 2],
    couplings: [Affine<S, D>; 2],
}

impl<S: Scalar, const D: usize> Crossing<S, D> {
    fn is_real(&self) -> bool {
        let mut all = self.values.iter().chain(&self.couplings);
        all.all(Affine::is_real)
    }

    /// The product of the couplings: where it is real and negative, `omega^2` is complex.
    fn product(&self, u: &[f64; D]) -> S {
        self.couplings[0].at(u) * self.couplings[1].at(u)
    }

    /// How fast the faster of the two grows.
    fn growth(&self, u: &[f64; D]) -> f64 {
        let [first, second] = [0, 1].each(|n| self.values[n].at(u));
        growth_of([first, second], self.product(u))
    }

    /// Where along an axis the product of the couplings is smallest, within reach, if it bends upward; given a place at zero of that axis.
    fn lowest_along(&self, axis: usize, u: &[f64; D]) -> Option<f64> {
        let [b, c] = [0, 1].each(|n| self.couplings[n].at(u));
        let [b_slope, c_slope] = [0, 1].each(|n| self.couplings[n].slopes[axis]);
        let (slope, curvature) = (
            (b * c_slope + c * b_slope).real(),
            2.0 * (b_slope * c_slope).real(),
        );
        (curvature > 0.0).then(|| (-slope / curvature).clamp(-REACH, REACH))
    }
}

/// What is looked for, where.
pub(super) struct Pockets<'a, const D: usize> {
    /// `D(k)` with its derivatives up to an order; `None` where a wave vector is not looked at.
    pub(super) around: &'a (dyn Fn(&SVector<f64, D>, Order) -> Option<Around<D>> + Sync),
    /// Whether it is so large that each wave vector is worth a core.
    pub(super) is_large: bool,
    /// Steps between the points of the grid, as columns.
    pub(super) steps: SMatrix<f64, D, D>,
    /// Growth rates below are not flutter.
    pub(super) threshold: f64,
    /// The growth rate of a wave that those sought must beat; zero where all are sought.
    pub(super) rival: f64,
    /// How many are looked at again.
    pub(super) most: usize,
    /// How many points between halved steps are looked at, at most.
    pub(super) finer: usize,
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
            let again = |own: Candidate<D>| {
                self.outlook(&own.wave_vector, NEARER * own.share, Order::First)?
                    .foreseen
            };
            let foreseen = of_each_long(self.is_large, all, again);
            all = foreseen.into_iter().flatten().collect();
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
            let outlook = |k| Some((self.outlook(&k, share, Order::Second)?, k));
            let outlooks = of_each_long(self.is_large, points, outlook);
            for (outlook, k) in outlooks.into_iter().flatten() {
                all.extend(outlook.foreseen);
                if outlook.unresolved > 0.0 {
                    unresolved.push((outlook.unresolved, k));
                }
            }
            sort_by_value(&mut unresolved, |item| -item.0);
            unresolved.truncate(self.finer >> D);
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
            let side = grid_coordinates::<D>(corner, 2).each(|n| n as f64 - 0.5);
            k + self.steps * SVector::from(side) * (0.5 * share)
        };
        (0..1 << D).map(at).collect()
    }

    /// What the spectrum at a wave vector with its derivatives tells of its neighborhood. `None` where it is not looked at, or its
    /// eigenvectors are nearly dependent.
    fn outlook(&self, k: &SVector<f64, D>, share: f64, order: Order) -> Option<Outlook<D>> {
        let steps = self.steps * share;
        let any = |expansion: &MatrixExpansion<D>| {
            Some(
                Neighborhood::of_any(expansion, &steps, order)?.outlook(self.threshold, self.rival),
            )
        };
        let mut outlook = match (self.around)(k, order)? {
            Around::Complex(expansion) => any(&expansion)?,
            Around::Real(expansion) => match Neighborhood::of_real(&expansion, &steps, order) {
                Some(near) => near.outlook(self.threshold, self.rival),
                None => any(&expansion.into())?,
            },
        };
        if let Some(foreseen) = &mut outlook.foreseen {
            foreseen.wave_vector = k + steps * foreseen.wave_vector;
            foreseen.share = share;
        }
        Some(outlook)
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
struct Neighborhood<V, M, const D: usize> {
    values: V,
    /// How it changes with a step along each axis, to first order.
    first: [M; D],
    /// Its second derivatives by steps, where these are looked at.
    second: Option<[M; D]>,
}

impl<const D: usize> Neighborhood<Vec<Complex>, DMatrix<Complex>, D> {
    /// Of any matrix. `None` where its eigenvectors are nearly dependent.
    fn of_any(
        expansion: &MatrixExpansion<D>,
        steps: &SMatrix<f64, D, D>,
        order: Order,
    ) -> Option<Self> {
        let all = Decomposition::new(expansion.value.clone())?;
        let [right, left] = all.vectors();
        if left.norm() * right.norm() > DEPENDENT {
            return None;
        }
        let [right, left] = [right, left].map(Parts::of);
        let turned = |matrix: DMatrix<Complex>| {
            let turned = left.times(&Parts::of(matrix)).times(&right);
            turned.joined()
        };
        let along = |a: usize| steps.column(a).into_owned();
        Some(Self {
            first: std::array::from_fn(|a| turned(expansion.slope(&along(a)))),
            second: (order == Order::Second)
                .then(|| std::array::from_fn(|a| turned(expansion.curvature(&along(a))))),
            values: all.values,
        })
    }
}

impl<const D: usize> Neighborhood<[f64; D], SMatrix<f64, D, D>, D> {
    /// Of a real matrix of three rows whose eigenvalues are real and well apart, with the row and the column of the adjugate of `D - omega^2` through
    /// its largest entry as eigenvectors.
    fn of_real(
        expansion: &Expansion<f64, D>,
        steps: &SMatrix<f64, D, D>,
        order: Order,
    ) -> Option<Self> {
        if D != 3 {
            return None;
        }
        let matrix = &expansion.value;
        let deviator = Deviator::of(&array_of(|e| matrix[(e / 3, e % 3)]));
        let ordered = deviator.all();
        let apart = CLOSE * matrix.amax();
        let is_apart = |pair: &[f64]| pair[1] - pair[0] > apart;
        if deviator.discriminant() <= 0.0 || !ordered.windows(2).all(is_apart) {
            return None;
        }
        let values: [f64; D] = array_of(|n| ordered[n]);
        let mut left = SMatrix::<f64, D, D>::zeros();
        let mut right = left;
        for (n, value) in values.iter().enumerate() {
            let shifted = matrix - SMatrix::<f64, D, D>::identity() * *value;
            let minor = |i: usize, j: usize| {
                let [p, q, r, s] = [(i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3];
                shifted[(p, r)] * shifted[(q, s)] - shifted[(p, s)] * shifted[(q, r)]
            };
            // The transpose of the cofactors is the adjugate, a multiple of `v w`.
            let adjugate = SMatrix::<f64, D, D>::from_fn(|i, j| minor(j, i));
            let (i, j) = adjugate.iamax_full();
            let scale = adjugate.column(j).norm();
            right.set_column(n, &(adjugate.column(j) / scale));
            let own = adjugate.row(i);
            left.set_row(n, &(own / (own * right.column(n))[(0, 0)]));
        }
        let dependent = left.norm() * right.norm();
        if dependent.is_nan() || dependent > DEPENDENT {
            return None;
        }
        let first = |a: usize| {
            let sum = (0..D)
                .map(|b| expansion.gradient[b] * steps[(b, a)])
                .sum::<SMatrix<f64, D, D>>();
            left * sum * right
        };
        let second = |a: usize| {
            let mut sum = SMatrix::<f64, D, D>::zeros();
            for b in 0..D {
                for c in 0..D {
                    sum += expansion.hessian[b][c] * (steps[(b, a)] * steps[(c, a)]);
                }
            }
            left * sum * right
        };
        Some(Self {
            values,
            first: array_of(first),
            second: (order == Order::Second).then(|| array_of(second)),
        })
    }
}

impl<S, V, M, const D: usize> Neighborhood<V, M, D>
where
    S: Scalar,
    V: AsRef<[S]>,
    M: Index<(usize, usize), Output = S>,
{
    /// The fastest pocket that is foreseen, in steps from here, and whether branches that may meet are seen well; of those that may grow faster than
    /// a rival where there is one.
    fn outlook(&self, threshold: f64, rival: f64) -> Outlook<D> {
        let (mut fastest, mut unresolved) = ((0.0, [0.0; D]), 0.0_f64);
        let count = self.values.as_ref().len();
        let repulsion: Vec<f64> = match self.second {
            Some(_) => (0..count).map(|own| self.repulsion(own)).collect(),
            None => Vec::new(),
        };
        for j in 1..count {
            for i in 0..j {
                if rival > 0.0 && !self.can_beat(rival, (i, j)) {
                    continue;
                }
                let own = self.pair(i, j).fastest();
                if own.0 > fastest.0 {
                    fastest = own;
                }
                if let Some(second) = &self.second {
                    let others = repulsion[i] + repulsion[j] - self.push(i, j) - self.push(j, i);
                    unresolved = unresolved.max(self.unresolved(second, (i, j), others));
                }
            }
        }
        let (growth, place) = fastest;
        Outlook {
            foreseen: (growth > threshold).then(|| Candidate {
                growth,
                wave_vector: SVector::from(place),
                share: 1.0,
            }),
            unresolved,
        }
    }

    /// Whether one of two branches can grow faster than a rival within reach. Mixed derivatives and other branches may add as much again as is known.
    fn can_beat(&self, rival: f64, (i, j): (usize, usize)) -> bool {
        let values = self.values.as_ref();
        let is_real = |i: usize, j: usize| {
            let mut all = self.first.iter().map(|m| m[(i, j)]);
            all.all(|x| x.imaginary() == 0.0)
        };
        let within = |of: &dyn Fn(&M) -> f64| {
            let first = self.first.iter().map(|m| REACH * of(m));
            let second = self.second.iter().flatten();
            let second = second.map(|m| 0.5 * REACH * REACH * of(m));
            first.sum::<f64>() + second.sum::<f64>()
        };
        let coupling = within(&|m| m[(i, j)].modulus()) * within(&|m| m[(j, i)].modulus());
        let own = [i, j]
            .iter()
            .all(|n| values[*n].imaginary() == 0.0 && is_real(*n, *n));
        if own {
            // The mean of a complex pair, and the square of its imaginary part.
            let mean = 0.5 * (values[i] + values[j]).real();
            let change = 0.5 * within(&|m| (m[(i, i)] + m[(j, j)]).modulus());
            return can_beat(rival, mean - 2.0 * change, 4.0 * coupling);
        }
        // `(z - a)(z - d) = b c`: one of the factors is no larger than the root of the product.
        let coupling = coupling.sqrt();
        [i, j].iter().any(|n| {
            let real = coupling + within(&|m| m[(*n, *n)].real().abs());
            let imaginary = coupling + within(&|m| m[(*n, *n)].imaginary().abs());
            let height = values[*n].imaginary().abs() + 2.0 * imaginary;
            can_beat(rival, values[*n].real() - 2.0 * real, height * height)
        })
    }

    fn pair(&self, i: usize, j: usize) -> Pair<S, D> {
        let entry = |i: usize, j: usize| array_of(|a| self.first[a][(i, j)]);
        let values = self.values.as_ref();
        Pair {
            values: [values[i], values[j]],
            slopes: [entry(i, i), entry(j, j)],
            couplings: [entry(i, j), entry(j, i)],
        }
    }

    /// What second order changes of the difference of two branches within reach, over what first order does, with what other branches push them; zero where
    /// they cannot meet or second order is small.
    fn unresolved(&self, second: &[M; D], (i, j): (usize, usize), others: f64) -> f64 {
        let change = |matrix: &M| {
            let coupling = (matrix[(i, j)] * matrix[(j, i)]).modulus().sqrt();
            (matrix[(i, i)] - matrix[(j, j)]).modulus() + 2.0 * coupling
        };
        let first: f64 = self.first.iter().map(|m| REACH * change(m)).sum();
        let bent: f64 = second.iter().map(|m| 0.5 * REACH * REACH * change(m)).sum();
        let second = bent + others.max(0.0);
        let values = self.values.as_ref();
        let may_meet = (values[i] - values[j]).modulus() <= first + second;
        match may_meet && second > RESOLVED * first {
            true => second / first,
            false => 0.0,
        }
    }

    /// How far all other branches push one within reach, to second order.
    fn repulsion(&self, own: usize) -> f64 {
        let others = (0..self.values.as_ref().len()).filter(|m| *m != own);
        others.map(|m| self.push(own, m)).sum()
    }

    /// How far a branch pushes another one; no farther than they are coupled.
    fn push(&self, own: usize, other: usize) -> f64 {
        let values = self.values.as_ref();
        let apart = (values[own] - values[other]).modulus();
        let coupling = |matrix: &M| {
            let coupling = REACH
                * (matrix[(own, other)] * matrix[(other, own)])
                    .modulus()
                    .sqrt();
            coupling * (coupling / apart).min(1.0)
        };
        self.first.iter().map(coupling).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::{PLACES, Pair, REACH, can_beat, growth_rate};
    use crate::algebra::{Complex, array_of, uniform};

    #[test]
    fn a_rival_is_beaten_where_the_growth_rate_says_so() {
        let mut state = 5_u64;
        let mut random = || 2.0 * uniform(&mut state) - 1.0;
        for _ in 0..1000 {
            let (p, q, rival) = (random(), random(), 0.5 + 0.5 * random());
            let growth = growth_rate(Complex::new(p, q.abs()));
            if (growth - rival).abs() > 1e-9 {
                assert_eq!(can_beat(rival, p, q * q), growth > rival, "{p} {q} {rival}");
            }
        }
    }

    /// What is found on the crossing, by functions that are linear there, is what the pair has at that place; and no place of a finer grid over all of what
    /// is within reach grows much faster where the crossing is the place to look.
    #[test]
    fn growth_on_a_crossing_is_that_of_the_pair() {
        let (mut foreseen, mut told) = (0, 0);
        let mut state = 5;
        let mut random = || 2.0 * uniform(&mut state) - 1.0;
        for seed in 0..400 {
            let pair: Pair<f64, 3> = Pair {
                values: [10.0 + 0.3 * random(), 10.0 + 0.3 * random()],
                slopes: [array_of(|_| random()), array_of(|_| random())],
                couplings: [array_of(|_| 0.1 * random()), array_of(|_| 0.1 * random())],
            };
            let (growth, place) = pair.fastest();
            assert!((growth - pair.growth(&place)).abs() < 1e-9, "{seed}");
            assert!(place.iter().all(|x| x.abs() <= REACH));
            let steps = 4 * PLACES;
            let at = |n: usize| REACH * (2.0 * n as f64 / steps as f64 - 1.0);
            let mut fastest = 0.0_f64;
            for number in 0..(steps + 1).pow(3) {
                let n = [
                    number % (steps + 1),
                    number / (steps + 1) % (steps + 1),
                    number / (steps + 1).pow(2),
                ];
                fastest = fastest.max(pair.growth(&n.map(at)));
            }
            if growth > 0.0 {
                foreseen += 1;
            }
            if fastest > 1e-3 {
                told += 1;
                assert!(growth > 0.5 * fastest, "{seed}: {growth} of {fastest}");
            }
        }
        assert!(foreseen > 200 && told > 100, "{foreseen} {told}");
    }
}
