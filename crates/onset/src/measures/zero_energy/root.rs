//! Roots of the strain operator: Newton's method, and what lies next to a root.

use crate::algebra::{Complex, MAXIMUM_ITERATIONS, sort_by_value};
use crate::scheme::StrainRows;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use std::f64::consts::PI;

/// Singular values below this are zero at a root, to rounding: slopes of `R` are one at most.
const ZERO: f64 = 1e-11;
/// The same of singular values at a root whose place is known to the square root of rounding only.
const KERNEL: f64 = 1e-7;
/// Steps of Newton's method. A double root takes the most: each halves the distance.
const STEPS: usize = 60;
/// Slopes below this fraction of the largest leave a direction in which a root may go on.
const FLAT: f64 = 1e-5;
/// Directions that are looked at, of which opposite ones are the same.
const DIRECTIONS: [usize; 3] = [1, 90, 240];

/// A wave vector at which `R` has a kernel.
#[derive(Clone, Debug)]
pub(super) struct Root<const D: usize> {
    pub(super) wave_vector: SVector<f64, D>,
    /// The kernel, an orthonormal vector a column.
    pub(super) kernel: DMatrix<Complex>,
    /// No other root is nearer than this; 1/length.
    pub(super) alone_within: f64,
    /// Where no slope resists: unit directions in which a root may go on.
    pub(super) flat: Vec<SVector<f64, D>>,
    /// In how many directions the whole kernel goes on.
    pub(super) tangents: usize,
}

/// A singular value decomposition, largest values first.
struct Singular {
    values: Vec<f64>,
    left: DMatrix<Complex>,
    right: DMatrix<Complex>,
}

impl Singular {
    fn of(matrix: DMatrix<Complex>) -> Option<Self> {
        let bound = MAXIMUM_ITERATIONS * matrix.ncols();
        let svd = matrix.try_svd(true, true, f64::EPSILON, bound)?;
        let (left, adjoint) = (svd.u?, svd.v_t?);
        let mut order: Vec<usize> = (0..svd.singular_values.len()).collect();
        sort_by_value(&mut order, |n| -svd.singular_values[*n]);
        Some(Self {
            values: order.iter().map(|n| svd.singular_values[*n]).collect(),
            left: left.select_columns(&order),
            right: adjoint.adjoint().select_columns(&order),
        })
    }

    fn smallest(&self) -> f64 {
        self.values.last().copied().unwrap_or(0.0)
    }

    fn below(&self, bound: f64) -> usize {
        self.values.iter().filter(|value| **value <= bound).count()
    }

    /// The right vectors of the `count` smallest values.
    fn softest(&self, count: usize) -> DMatrix<Complex> {
        let n = self.right.ncols();
        self.right.columns(n - count, count).into_owned()
    }

    /// What of a matrix is orthogonal to the range of the other vectors: changes of the soft vectors answer the rest.
    fn unanswered(&self, count: usize, matrix: DMatrix<Complex>) -> DMatrix<Complex> {
        let range = self.left.columns(0, self.left.ncols() - count);
        let answered = range * range.ad_mul(&matrix);
        matrix - answered
    }
}

impl<const D: usize> StrainRows<D> {
    /// Newton's method, as far as `reach` from where it starts: a wave vector at which `R` has a kernel.
    pub(super) fn polished(&self, start: &SVector<f64, D>, reach: f64) -> Option<SVector<f64, D>> {
        let first = Singular::of(self.at(start))?;
        // The nullity of the root is not known: all that is small, or one.
        let small = first.below(3.0 * first.smallest() + ZERO);
        let mut counts = vec![small, 1];
        counts.dedup();
        counts
            .into_iter()
            .find_map(|count| self.followed(start, reach, count))
    }

    fn followed(
        &self,
        start: &SVector<f64, D>,
        reach: f64,
        count: usize,
    ) -> Option<SVector<f64, D>> {
        let mut k = *start;
        let mut best = (f64::INFINITY, k);
        let mut idle = 0;
        for _ in 0..STEPS {
            let singular = Singular::of(self.at(&k))?;
            let smallest = singular.smallest();
            if smallest < 0.9 * best.0 {
                idle = 0;
            } else {
                idle += 1;
            }
            if smallest < best.0 {
                best = (smallest, k);
            }
            if idle > 3 || smallest == 0.0 {
                break;
            }
            let step = self.newton_step(&k, &singular, count)?;
            if step.norm() <= 1e-15 * (1.0 + k.norm()) {
                break;
            }
            k += step;
            let has_strayed = (k - start).norm() > reach;
            if has_strayed || !k.iter().all(|x| x.is_finite()) {
                break;
            }
        }
        (best.0 <= ZERO).then_some(best.1)
    }

    /// The least change of `k` with which what is left of `R(k) V` is smallest, `V` the vectors of the smallest singular values.
    fn newton_step(
        &self,
        k: &SVector<f64, D>,
        singular: &Singular,
        count: usize,
    ) -> Option<SVector<f64, D>> {
        let soft = singular.softest(count);
        let stacked = |matrix: DMatrix<Complex>| -> Vec<f64> {
            let left = singular.unanswered(count, matrix);
            left.iter().flat_map(|z| [z.re, z.im]).collect()
        };
        let residual = DVector::from_vec(stacked(self.at(k) * &soft));
        let columns: Vec<DVector<f64>> = (0..D)
            .map(|i| DVector::from_vec(stacked(self.derivative(k, i) * &soft)))
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let svd = jacobian.try_svd(true, true, f64::EPSILON, 10 * MAXIMUM_ITERATIONS)?;
        let step = svd.solve(&-residual, 1e-9 * self.slope).ok()?;
        Some(SVector::from_fn(|i, _| step[i]))
    }

    /// What is known of the neighborhood of a root; `None` where there is no kernel.
    ///
    /// With the kernel `U`, the complement `W` of the range of `R`, its smallest singular value `r` other than zero, and bounds `L`,
    /// `M` on the first and second derivatives, a kernel at the distance `d` needs `s <= d (M/2 + 2 L^2/r)`, if `d <= r/(2 L)`, where
    /// `s` is the smallest of `|W* (n.dR) U a|` over unit `n` and `a`.
    pub(super) fn root(&self, k: &SVector<f64, D>) -> Option<Root<D>> {
        let singular = Singular::of(self.at(k))?;
        let count = singular.below(KERNEL * self.slope.max(1.0));
        if count == 0 {
            return None;
        }
        let kernel = singular.softest(count);
        let turned: Vec<DMatrix<Complex>> = (0..D)
            .map(|i| singular.unanswered(count, self.derivative(k, i) * &kernel))
            .collect();
        let products: Vec<Vec<DMatrix<Complex>>> = turned
            .iter()
            .map(|a| turned.iter().map(|b| a.ad_mul(b)).collect())
            .collect();
        let flat_square = (FLAT * self.slope).powi(2);
        let together = SMatrix::<f64, D, D>::from_fn(|i, j| products[i][j].trace().re);
        let tangents = eigen(&together)
            .into_iter()
            .filter(|(value, _)| *value <= flat_square)
            .count();
        let slopes = directional(&products, count);
        let least = slopes
            .first()
            .map_or(0.0, |(square, _)| square.max(0.0).sqrt());
        let flat = slopes
            .into_iter()
            .filter(|(square, _)| *square <= flat_square);
        let rank = singular.values.len() - count;
        let range = if rank == 0 {
            f64::INFINITY
        } else {
            singular.values[rank - 1]
        };
        let (slope, curvature) = (self.slope, self.curvature);
        let curved = 0.5 * curvature + 2.0 * slope * slope / range;
        // Directions are sampled: a little less.
        let alone_within = (0.5 * range / slope).min(0.9 * least / curved);
        Some(Root {
            wave_vector: *k,
            kernel,
            alone_within,
            flat: flat.map(|(_, direction)| direction).collect(),
            tangents,
        })
    }
}

/// The smallest `|n.T a|^2` over unit `a` for directions `n`, from the products `T_i* T_j`: stationary directions, the least first.
fn directional<const D: usize>(
    products: &[Vec<DMatrix<Complex>>],
    count: usize,
) -> Vec<(f64, SVector<f64, D>)> {
    if count == 1 {
        let real = SMatrix::<f64, D, D>::from_fn(|i, j| products[i][j][(0, 0)].re);
        return eigen(&real);
    }
    let square = |n: &SVector<f64, D>| {
        let mut sum = DMatrix::zeros(count, count);
        for i in 0..D {
            for j in 0..D {
                sum += &products[i][j] * Complex::new(n[i] * n[j], 0.0);
            }
        }
        sum.symmetric_eigenvalues().min()
    };
    let mut sampled: Vec<(f64, SVector<f64, D>)> = directions::<D>()
        .into_iter()
        .map(|n| (square(&n), n))
        .collect();
    sort_by_value(&mut sampled, |item| item.0);
    // The least ones are followed, of neighboring ones one.
    let mut found: Vec<(f64, SVector<f64, D>)> = Vec::new();
    let apart = 4.0 / (DIRECTIONS[D - 1] as f64).powf(1.0 / (D.max(2) - 1) as f64);
    for (value, n) in sampled {
        let is_new = found
            .iter()
            .all(|(_, other)| (n - other).norm().min((n + other).norm()) > apart);
        if is_new && found.len() < 8 {
            found.push(refined(&square, (value, n), apart));
        }
    }
    sort_by_value(&mut found, |item| item.0);
    found
}

/// The bottom of a function of directions near one, by smaller and smaller turns.
fn refined<const D: usize>(
    at: &impl Fn(&SVector<f64, D>) -> f64,
    start: (f64, SVector<f64, D>),
    size: f64,
) -> (f64, SVector<f64, D>) {
    let (mut best, mut size) = (start, 0.5 * size);
    while size > 1e-9 {
        let before = best.0;
        for i in 0..D {
            for sign in [-1.0, 1.0] {
                let mut tried = best.1;
                tried[i] += sign * size;
                let tried = tried.normalize();
                let value = at(&tried);
                if value < best.0 {
                    best = (value, tried);
                }
            }
        }
        if best.0 >= before {
            size *= 0.5;
        }
    }
    best
}

/// Directions all over the half sphere.
fn directions<const D: usize>() -> Vec<SVector<f64, D>> {
    let count = DIRECTIONS[D - 1];
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count)
        .map(|n| {
            let share = (n as f64 + 0.5) / count as f64;
            let components = match D {
                1 => [1.0, 0.0, 0.0],
                2 => [(PI * share).cos(), (PI * share).sin(), 0.0],
                _ => {
                    let (angle, radius) = (golden * n as f64, (1.0 - share * share).sqrt());
                    [radius * angle.cos(), radius * angle.sin(), share]
                }
            };
            SVector::from_fn(|i, _| components[i])
        })
        .collect()
}

/// Eigenvalues of a symmetric matrix with their vectors, the least first.
fn eigen<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Vec<(f64, SVector<f64, D>)> {
    let dynamic = DMatrix::from_fn(D, D, |i, j| matrix[(i, j)]);
    let eigen = dynamic.symmetric_eigen();
    let mut pairs: Vec<(f64, SVector<f64, D>)> = (0..D)
        .map(|n| {
            let vector = eigen.eigenvectors.column(n);
            (eigen.eigenvalues[n], SVector::from_fn(|i, _| vector[i]))
        })
        .collect();
    sort_by_value(&mut pairs, |item| item.0);
    pairs
}
