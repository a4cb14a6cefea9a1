//! Pockets of complex `omega^2` between the points of a grid.
//!
//! Where two real branches of a matrix that is not Hermitian cross, their coupling can make `omega^2` complex in a region that is smaller than a grid
//! step. Each grid point yields a linear model of every pair of branches, in the eigenvectors at that point. The model predicts the position of the
//! largest growth rate within its range. Each prediction is refined a few times at the predicted position. All results are samples: a pocket that no
//! grid point predicts can be missed. Constants without a stated derivation are heuristic; the tests `hunt` compare random states with a dense
//! search.

use super::branches::Taylor;
use super::system::MatrixExpansion;
use super::{Expansion, growth_rate};
use crate::algebra::{Complex, Decomposition, Deviator, Each, Parts, array_of, sort_by_value};
use crate::cores::of_each_long;
use crate::lattice::grid_coordinates;
use nalgebra::{ComplexField, DMatrix, SMatrix, SVector};
use std::collections::HashSet;
use std::ops::Index;

/// Range of a model around its point, in steps: slightly more than half of the distance of two points.
const MODEL_RANGE_STEPS: f64 = 0.6;
/// Number of positions along each axis at which the crossing of two branches is sampled.
const PLACES_PER_AXIS: usize = 7;
/// Number of refinements of a predicted pocket.
const REFINEMENTS: usize = 3;
/// Factor between the steps of successive refinements.
const REFINEMENT_RATIO: f64 = 0.3;
/// Number of times that steps are halved around points at which the first-order model is not reliable.
const STEP_HALVINGS: usize = 4;
/// Largest ratio of the second-order to the first-order change of a difference of branches for which the first-order model is reliable.
const RESOLVED_CURVATURE_RATIO: f64 = 0.5;
/// Maximum number of points between halved steps.
pub(super) const HALVED_STEP_POINTS: usize = 256;
/// Number of wave vectors that are expanded together.
const EXPANDED_TOGETHER: usize = 64;
/// Relative difference of growth rates of symmetric images of one pocket.
const IMAGE_GROWTH_TOLERANCE: f64 = 1e-9;
/// Distance, in steps, of wave vectors within one pocket.
const POCKET_SEPARATION_STEPS: f64 = 0.25;
/// Largest product of the norms of the left and right eigenvectors. Beyond it the vectors are nearly dependent and the model is inaccurate.
const EIGENVECTOR_CONDITION_LIMIT: f64 = 1e6;
/// Smallest difference of real eigenvalues, relative to the largest entry, for which adjugates give accurate eigenvectors.
const EIGENVALUE_SEPARATION: f64 = 1e-5;

/// Entries of a matrix: real or complex numbers.
trait Scalar: ComplexField<RealField = f64> + Copy {
    /// Magnitude, without the care for the ends of the range of numbers that makes `modulus` slow.
    fn size(self) -> f64;
}

impl Scalar for f64 {
    fn size(self) -> f64 {
        self.abs()
    }
}

impl Scalar for Complex {
    fn size(self) -> f64 {
        self.norm_sqr().sqrt()
    }
}

/// Order of the expansion around a wave vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    First,
    /// Second order, to detect where the first order is not reliable.
    Second,
}

/// `D(k)` with its derivatives; in real numbers if it is real.
pub(super) enum Around<const D: usize> {
    Real(Expansion<f64, D>),
    Complex(MatrixExpansion<D>),
    Turned(Turned<D>),
}

/// Derivatives of `D(k)` in the basis of its eigenvectors at a wave vector.
pub(super) struct Turned<const D: usize> {
    /// Eigenvalues, the diagonal of the value.
    pub(super) values: Vec<Complex>,
    /// Product of the norms of the left and right eigenvectors.
    pub(super) condition: f64,
    /// First derivatives with respect to each component of the wave vector, then second derivatives with respect to `a` and `b <= a`.
    pub(super) parts: Vec<DMatrix<Complex>>,
}

impl<const D: usize> Turned<D> {
    /// Taylor expansion of a branch, by second-order perturbation theory as in [`MatrixExpansion::branch`].
    fn branch(&self, own: usize) -> Taylor<Complex, D> {
        let second = |a: usize, b: usize| {
            let (a, b) = (a.max(b), a.min(b));
            &self.parts[D + a * (a + 1) / 2 + b]
        };
        let curvature = |a: usize, b: usize| {
            let (first, other) = (&self.parts[a], &self.parts[b]);
            let both =
                |m: usize| first[(own, m)] * other[(m, own)] + other[(own, m)] * first[(m, own)];
            let others = (0..self.values.len()).filter(|m| *m != own);
            let others = others.map(|m| both(m) / (self.values[own] - self.values[m]));
            second(a, b)[(own, own)] + others.sum::<Complex>()
        };
        Taylor {
            value: self.values[own],
            gradient: array_of(|a| self.parts[a][(own, own)]),
            hessian: array_of(|a| array_of(|b| curvature(a, b))),
        }
    }
}

impl<const D: usize> Around<D> {
    /// Taylor expansions of the branches with the given numbers in the order of a value of `omega^2`; `None` if there are fewer branches, or if the
    /// eigenvectors cannot be computed.
    pub(super) fn branches(
        self,
        order: &dyn Fn(Complex) -> f64,
        numbers: &[usize],
    ) -> Option<Vec<Taylor<Complex, D>>> {
        let expansion = match self {
            Self::Turned(turned) => {
                return of_numbered(&turned.values, order, numbers, |own| turned.branch(own));
            }
            Self::Complex(expansion) => expansion,
            Self::Real(expansion) => expansion.into(),
        };
        let all = Decomposition::new(expansion.value.clone())?;
        of_numbered(&all.values, order, numbers, |own| {
            expansion.branch(&all, own)
        })
    }
}

/// Results for the eigenvalues with the given numbers in increasing order; `None` if there are fewer eigenvalues.
pub(super) fn of_numbered<T>(
    values: &[Complex],
    order: &dyn Fn(Complex) -> f64,
    numbers: &[usize],
    result: impl Fn(usize) -> T,
) -> Option<Vec<T>> {
    let mut sorted: Vec<usize> = (0..values.len()).collect();
    sort_by_value(&mut sorted, |n| order(values[*n]));
    let chosen = numbers.iter();
    chosen
        .map(|n| sorted.get(*n).map(|own| result(*own)))
        .collect()
}

/// Wave vector in a predicted pocket.
#[derive(Clone, Copy)]
struct Candidate<const D: usize> {
    growth: f64,
    wave_vector: SVector<f64, D>,
    /// Steps within which it was predicted, as a fraction of the grid steps.
    share: f64,
}

/// Prediction for the neighborhood of a wave vector.
struct Outlook<const D: usize> {
    foreseen: Option<Candidate<D>>,
    /// Largest ratio of second-order to first-order changes, for branches that may meet; zero if the model is reliable.
    unresolved: f64,
}

/// Model of two branches near a point, to first order in the eigenvectors there.
///
/// It is the matrix `((l + a.u, b.u), (c.u, m + e.u))`. Its eigenvalues are complex in a pocket around the crossing of the uncoupled branches.
struct Pair<S, const D: usize> {
    values: [S; 2],
    slopes: [[S; D]; 2],
    /// Coupling coefficients `b` and `c`.
    couplings: [[S; D]; 2],
}

/// Value of a linear function at a position.
fn along<S: Scalar, const D: usize>(slope: &[S; D], u: &[f64; D]) -> S {
    let mut sum = S::zero();
    for a in 0..D {
        sum += slope[a].scale(u[a]);
    }
    sum
}

/// Growth rate of the faster of two branches, given their uncoupled values and the product of the couplings; zero if both are real.
fn growth_of<S: Scalar>([first, second]: [S; 2], product: S) -> f64 {
    let (mean, half) = ((first + second).scale(0.5), (first - second).scale(0.5));
    let square = half * half + product;
    if mean.imaginary() == 0.0 && square.imaginary() == 0.0 {
        let (mean, square) = (mean.real(), square.real());
        // Modulus of `mean +- i root(-square)`, as in `growth_rate`.
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

/// Returns true if the growth rate of a wave can exceed `rival`, given `Re omega^2 >= p` and `(Im omega^2)^2 <= q`.
///
/// The growth rate is `sqrt((|omega^2| - Re omega^2) / 2)`.
pub(super) fn can_beat(rival: f64, p: f64, q: f64) -> bool {
    let square = rival * rival;
    q > 4.0 * square * (square + p)
}

impl<S: Scalar, const D: usize> Pair<S, D> {
    /// Growth rate of the faster branch at `u`.
    fn growth(&self, u: &[f64; D]) -> f64 {
        let [first, second] = [0, 1].each(|n| self.values[n] + along(&self.slopes[n], u));
        let product = along(&self.couplings[0], u) * along(&self.couplings[1], u);
        growth_of([first, second], product)
    }

    /// Largest growth rate within range, and its position, sampled on the line or surface of the crossing.
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
            u[crossing.axis] = height.clamp(-MODEL_RANGE_STEPS, MODEL_RANGE_STEPS);
            if height == u[crossing.axis] {
                // At most wave vectors two real branches repel each other.
                if !is_real || crossing.product(&u).real() < 0.0 {
                    look(crossing.growth(&u), u);
                }
            } else if height.abs() <= 2.0 * MODEL_RANGE_STEPS {
                look(self.growth(&u), u);
            }
        };
        let place =
            |n: usize| MODEL_RANGE_STEPS * (2.0 * n as f64 / (PLACES_PER_AXIS - 1) as f64 - 1.0);
        let others = || (0..D).filter(|a| *a != crossing.axis);
        for number in 0..PLACES_PER_AXIS.pow(D as u32 - 1) {
            let (mut places, mut rest) = ([0; D], number);
            for a in others() {
                places[a] = rest % PLACES_PER_AXIS;
                rest /= PLACES_PER_AXIS;
            }
            let mut u = places.each(place);
            look_at(u);
            // Along a line through the positions, the product of the couplings is quadratic and can be negative only between two of them.
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

    /// Line or surface of the crossings of the uncoupled branches, if it passes within range.
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
        let closed: f64 = others.map(|a| MODEL_RANGE_STEPS * closing[a].abs()).sum();
        if distance.abs() > closed + 2.0 * MODEL_RANGE_STEPS * closing[axis].abs() {
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

/// Affine function of a position.
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

/// Two branches on their crossing, as functions of the position along all axes except one.
struct Crossing<S, const D: usize> {
    /// Axis along which the branches approach each other fastest.
    axis: usize,
    /// Coordinate of the crossing along this axis.
    height: Affine<f64, D>,
    values: [Affine<S, D>; 2],
    couplings: [Affine<S, D>; 2],
}

impl<S: Scalar, const D: usize> Crossing<S, D> {
    fn is_real(&self) -> bool {
        let mut all = self.values.iter().chain(&self.couplings);
        all.all(Affine::is_real)
    }

    /// Product of the couplings; if it is real and negative, `omega^2` is complex.
    fn product(&self, u: &[f64; D]) -> S {
        self.couplings[0].at(u) * self.couplings[1].at(u)
    }

    /// Growth rate of the faster branch.
    fn growth(&self, u: &[f64; D]) -> f64 {
        let [first, second] = [0, 1].each(|n| self.values[n].at(u));
        growth_of([first, second], self.product(u))
    }

    /// Coordinate along an axis, within range, at which the product of the couplings is smallest, if it is convex. `u` must be zero along this axis.
    fn lowest_along(&self, axis: usize, u: &[f64; D]) -> Option<f64> {
        let [b, c] = [0, 1].each(|n| self.couplings[n].at(u));
        let [b_slope, c_slope] = [0, 1].each(|n| self.couplings[n].slopes[axis]);
        let (slope, curvature) = (
            (b * c_slope + c * b_slope).real(),
            2.0 * (b_slope * c_slope).real(),
        );
        (curvature > 0.0).then(|| (-slope / curvature).clamp(-MODEL_RANGE_STEPS, MODEL_RANGE_STEPS))
    }
}

/// Function that expands `D(k)` up to an order at several wave vectors.
type Expansions<'a, const D: usize> =
    &'a (dyn Fn(&[SVector<f64, D>], Order) -> Vec<Option<Around<D>>> + Sync);

/// A search for pockets.
pub(super) struct Pockets<'a, const D: usize> {
    /// Expansions of `D(k)` up to an order at several wave vectors; `None` at long waves, which are not searched.
    pub(super) around: Expansions<'a, D>,
    /// True if the matrix is so large that each wave vector occupies one core.
    pub(super) is_large: bool,
    /// Grid steps, as columns.
    pub(super) steps: SMatrix<f64, D, D>,
    /// Smallest growth rate that counts as flutter.
    pub(super) threshold: f64,
    /// Growth rate that a pocket must exceed to matter; zero if all pockets matter.
    pub(super) rival: f64,
    /// Maximum number of refined pockets.
    pub(super) most: usize,
    /// Maximum number of points between halved steps.
    pub(super) finer: usize,
}

impl<const D: usize> Pockets<'_, D> {
    /// Wave vectors in pockets of complex `omega^2`, fastest growing first.
    ///
    /// Pockets are predicted from the given grid points, and from finer points where the model is not reliable. Each prediction is refined at the
    /// predicted position.
    pub(super) fn around(
        &self,
        points: impl Iterator<Item = SVector<f64, D>>,
    ) -> Vec<SVector<f64, D>> {
        let mut all = self.foreseen(points);
        let mut most = self.most;
        for _ in 0..REFINEMENTS {
            self.leave_fastest(&mut all, most);
            most /= 2;
            let places = all.iter();
            let places = places.map(|own| (own.wave_vector, REFINEMENT_RATIO * own.share));
            let outlooks = self.outlooks(&places.collect::<Vec<_>>(), Order::First);
            let foreseen = outlooks.into_iter().flatten().map(|own| own.foreseen);
            all = foreseen.flatten().collect();
        }
        self.leave_fastest(&mut all, most / 2);
        all.into_iter().map(|own| own.wave_vector).collect()
    }

    /// Pockets predicted from the grid points.
    ///
    /// Points between the grid points are used where second-order and first-order changes of the difference of branches are comparable. This happens
    /// around `k = 0`, and where soft branches are strongly curved.
    fn foreseen(&self, points: impl Iterator<Item = SVector<f64, D>>) -> Vec<Candidate<D>> {
        let mut all = Vec::new();
        let (mut points, mut share) = (points.collect::<Vec<_>>(), 1.0);
        // One of `k` and `-k` suffices.
        let mut between = self.between(&SVector::zeros(), share);
        between.truncate(1 << (D - 1));
        for _ in 0..=STEP_HALVINGS {
            let mut unresolved = Vec::new();
            let places: Vec<_> = points.iter().map(|k| (*k, share)).collect();
            let outlooks = self.outlooks(&places, Order::Second);
            for (outlook, k) in outlooks.into_iter().zip(points) {
                let Some(outlook) = outlook else { continue };
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

    /// Corners of a cell of half the side around a wave vector.
    fn between(&self, k: &SVector<f64, D>, share: f64) -> Vec<SVector<f64, D>> {
        let at = |corner: usize| {
            let side = grid_coordinates::<D>(corner, 2).each(|n| n as f64 - 0.5);
            k + self.steps * SVector::from(side) * (0.5 * share)
        };
        (0..1 << D).map(at).collect()
    }

    /// Predictions for the neighborhoods of wave vectors with the given shares of the steps; `None` if a wave vector is not searched, or if its eigenvectors
    /// are nearly dependent.
    fn outlooks(&self, places: &[(SVector<f64, D>, f64)], order: Order) -> Vec<Option<Outlook<D>>> {
        let together = if self.is_large { 1 } else { EXPANDED_TOGETHER };
        let several = |places: &[(SVector<f64, D>, f64)]| -> Vec<Option<Outlook<D>>> {
            let wave_vectors: Vec<_> = places.iter().map(|(k, _)| *k).collect();
            let around = (self.around)(&wave_vectors, order).into_iter();
            let both = around.zip(places);
            both.map(|(around, (k, share))| self.outlook(around?, k, *share, order))
                .collect()
        };
        let parts = places.chunks(together).collect();
        let outlooks = of_each_long(self.is_large, parts, several);
        outlooks.into_iter().flatten().collect()
    }

    fn outlook(
        &self,
        around: Around<D>,
        k: &SVector<f64, D>,
        share: f64,
        order: Order,
    ) -> Option<Outlook<D>> {
        let steps = self.steps * share;
        let any = |expansion: &MatrixExpansion<D>| {
            Some(
                Neighborhood::of_any(expansion, &steps, order)?.outlook(self.threshold, self.rival),
            )
        };
        let mut outlook = match around {
            Around::Complex(expansion) => any(&expansion)?,
            Around::Turned(turned) => {
                Neighborhood::of_turned(turned, &steps, order)?.outlook(self.threshold, self.rival)
            }
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

    /// Keeps the fastest growing pockets, one of each set of symmetric images and one of several predictions of the same pocket.
    fn leave_fastest(&self, all: &mut Vec<Candidate<D>>, most: usize) {
        sort_by_value(all, |mode| -mode.growth);
        all.dedup_by(|b, a| (a.growth - b.growth).abs() <= IMAGE_GROWTH_TOLERANCE * a.growth);
        let Some(to_steps) = self.steps.try_inverse() else {
            return;
        };
        let mut taken = HashSet::new();
        all.retain(|own| {
            let place = to_steps * own.wave_vector / (POCKET_SEPARATION_STEPS * own.share);
            taken.insert((place.map(|x| x.round() as i64), own.share.to_bits()))
        });
        all.truncate(most);
    }
}

/// Expansion of the matrix around a wave vector, in the basis of its eigenvectors there.
struct Neighborhood<V, M, const D: usize> {
    values: V,
    /// First-order change for a step along each axis.
    first: [M; D],
    /// Second derivatives with respect to steps, if requested.
    second: Option<[M; D]>,
}

impl<const D: usize> Neighborhood<Vec<Complex>, DMatrix<Complex>, D> {
    /// Combines derivatives in the basis of the eigenvectors; `None` if these are nearly dependent.
    fn of_turned(turned: Turned<D>, steps: &SMatrix<f64, D, D>, order: Order) -> Option<Self> {
        if turned.condition.is_nan() || turned.condition > EIGENVECTOR_CONDITION_LIMIT {
            return None;
        }
        let n = turned.values.len();
        let parts = &turned.parts;
        let first = |a: usize| {
            let entry = |i, j| (0..D).map(|b| parts[b][(i, j)] * steps[(b, a)]).sum();
            DMatrix::from_fn(n, n, entry)
        };
        let second = |a: usize| {
            let weights: Vec<f64> = (0..D)
                .flat_map(|b| (0..=b).map(move |c| (b, c)))
                .map(|(b, c)| {
                    let times = if b == c { 1.0 } else { 2.0 };
                    times * steps[(b, a)] * steps[(c, a)]
                })
                .collect();
            let entry = |i, j| {
                let both = parts[D..].iter().zip(&weights);
                both.map(|(part, weight)| part[(i, j)] * *weight).sum()
            };
            DMatrix::from_fn(n, n, entry)
        };
        Some(Self {
            first: std::array::from_fn(first),
            second: (order == Order::Second).then(|| std::array::from_fn(second)),
            values: turned.values,
        })
    }

    /// Expands any matrix; `None` if its eigenvectors are nearly dependent.
    fn of_any(
        expansion: &MatrixExpansion<D>,
        steps: &SMatrix<f64, D, D>,
        order: Order,
    ) -> Option<Self> {
        let all = Decomposition::new(expansion.value.clone())?;
        if all.condition() > EIGENVECTOR_CONDITION_LIMIT {
            return None;
        }
        let [right, left] = [all.right, all.left].map(Parts::of);
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
    /// Expands a real matrix with three rows and well separated real eigenvalues; otherwise `None`.
    ///
    /// The eigenvectors are the row and the column of the adjugate of `D - omega^2` through its largest entry.
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
        let apart = EIGENVALUE_SEPARATION * matrix.amax();
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
            // The adjugate, the transpose of the cofactors, is a multiple of `v w`.
            let adjugate = SMatrix::<f64, D, D>::from_fn(|i, j| minor(j, i));
            let (i, j) = adjugate.iamax_full();
            let scale = adjugate.column(j).norm();
            right.set_column(n, &(adjugate.column(j) / scale));
            let own = adjugate.row(i);
            left.set_row(n, &(own / (own * right.column(n))[(0, 0)]));
        }
        let dependent = left.norm() * right.norm();
        if dependent.is_nan() || dependent > EIGENVECTOR_CONDITION_LIMIT {
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
    /// Fastest predicted pocket, in steps from the point, and the reliability of the model. With a `rival`, only pairs that may grow faster are
    /// examined.
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

    /// Returns true if one of two branches can grow faster than `rival` within range. Doubling the known changes allows for mixed derivatives and
    /// other branches.
    fn can_beat(&self, rival: f64, (i, j): (usize, usize)) -> bool {
        let values = self.values.as_ref();
        let is_real = |i: usize, j: usize| {
            let mut all = self.first.iter().map(|m| m[(i, j)]);
            all.all(|x| x.imaginary() == 0.0)
        };
        let within = |of: &dyn Fn(&M) -> f64| {
            let first = self.first.iter().map(|m| MODEL_RANGE_STEPS * of(m));
            let second = self.second.iter().flatten();
            let second = second.map(|m| 0.5 * MODEL_RANGE_STEPS * MODEL_RANGE_STEPS * of(m));
            first.sum::<f64>() + second.sum::<f64>()
        };
        let coupling = within(&|m| m[(i, j)].size()) * within(&|m| m[(j, i)].size());
        let own = [i, j]
            .iter()
            .all(|n| values[*n].imaginary() == 0.0 && is_real(*n, *n));
        if own {
            // Mean of a complex pair, and the square of its imaginary part.
            let mean = 0.5 * (values[i] + values[j]).real();
            let change = 0.5 * within(&|m| (m[(i, i)] + m[(j, j)]).size());
            return can_beat(rival, mean - 2.0 * change, 4.0 * coupling);
        }
        // From `(z - a)(z - d) = b c`, one factor is at most the square root of the product.
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

    /// Ratio of second-order to first-order changes of the difference of two branches within range, including the repulsion by other branches.
    ///
    /// The ratio is zero if the branches cannot meet, or if it is small.
    fn unresolved(&self, second: &[M; D], (i, j): (usize, usize), others: f64) -> f64 {
        let change = |matrix: &M| {
            let coupling = (matrix[(i, j)] * matrix[(j, i)]).size().sqrt();
            (matrix[(i, i)] - matrix[(j, j)]).size() + 2.0 * coupling
        };
        let first: f64 = self
            .first
            .iter()
            .map(|m| MODEL_RANGE_STEPS * change(m))
            .sum();
        let bent: f64 = second
            .iter()
            .map(|m| 0.5 * MODEL_RANGE_STEPS * MODEL_RANGE_STEPS * change(m))
            .sum();
        let second = bent + others.max(0.0);
        let values = self.values.as_ref();
        let may_meet = (values[i] - values[j]).size() <= first + second;
        match may_meet && second > RESOLVED_CURVATURE_RATIO * first {
            true => second / first,
            false => 0.0,
        }
    }

    /// Shift of a branch by all other branches within range, to second order.
    fn repulsion(&self, own: usize) -> f64 {
        let others = (0..self.values.as_ref().len()).filter(|m| *m != own);
        others.map(|m| self.push(own, m)).sum()
    }

    /// Shift of a branch by one other branch; at most their coupling.
    fn push(&self, own: usize, other: usize) -> f64 {
        let values = self.values.as_ref();
        let apart = (values[own] - values[other]).size();
        let coupling = |matrix: &M| {
            let coupling =
                MODEL_RANGE_STEPS * (matrix[(own, other)] * matrix[(other, own)]).size().sqrt();
            coupling * (coupling / apart).min(1.0)
        };
        self.first.iter().map(coupling).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::{MODEL_RANGE_STEPS, PLACES_PER_AXIS, Pair, can_beat, growth_rate};
    use crate::algebra::{Complex, array_of, uniform};

    #[test]
    fn the_comparison_with_a_known_growth_rate_agrees_with_the_computed_rate() {
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

    /// The predicted growth rate on the crossing agrees with the pair at that position. If the crossing determines the growth, no point of a finer
    /// grid within range grows much faster.
    #[test]
    fn the_predicted_growth_at_a_crossing_agrees_with_the_pair_of_branches() {
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
            assert!(place.iter().all(|x| x.abs() <= MODEL_RANGE_STEPS));
            let steps = 4 * PLACES_PER_AXIS;
            let at = |n: usize| MODEL_RANGE_STEPS * (2.0 * n as f64 / steps as f64 - 1.0);
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
