//! Roots of the strain operator: Newton's method, and what lies next to a root.

use crate::algebra::{Complex, MAXIMUM_ITERATIONS, sort_by_value};
use crate::scheme::StrainRows;
use nalgebra::{DMatrix, DMatrixView, DVector, SMatrix, SVector};
use std::borrow::Cow;
use std::f64::consts::PI;

/// Singular values below this are zero at a root, to rounding: slopes of `R` are one at most.
const ZERO: f64 = 1e-11;
/// The same of singular values at a root whose place is known to the square root of rounding only.
const KERNEL: f64 = 1e-7;
/// Steps of Newton's method. A double root takes the most: each halves the distance.
const STEPS: usize = 60;
/// Slopes below this fraction of the largest leave a direction in which a root may go on.
const FLAT: f64 = 1e-5;
/// Halvings of an interval in which a distance is sought, which is a lower bound.
const HALVINGS: usize = 40;
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
#[derive(Clone)]
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

    /// An orthonormal basis of the range of the other vectors.
    fn range(&self, count: usize) -> DMatrixView<'_, Complex> {
        self.left.columns(0, self.left.ncols() - count)
    }

    /// What of a matrix is orthogonal to that range: changes of the soft vectors answer the rest.
    fn unanswered(&self, count: usize, matrix: DMatrix<Complex>) -> DMatrix<Complex> {
        let range = self.range(count);
        let answered = range * range.ad_mul(&matrix);
        matrix - answered
    }

    /// What the matrix maps to that basis, a column each: the other right vectors over their singular values.
    fn origins(&self, count: usize) -> DMatrix<Complex> {
        let n = self.right.ncols() - count;
        let mut origins = self.right.columns(0, n).into_owned();
        for (mut column, value) in origins.column_iter_mut().zip(&self.values) {
            column /= Complex::from(*value);
        }
        origins
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
            .find_map(|count| self.followed(start, &first, reach, count))
    }

    fn followed(
        &self,
        start: &SVector<f64, D>,
        first: &Singular,
        reach: f64,
        count: usize,
    ) -> Option<SVector<f64, D>> {
        let (mut k, mut singular) = (*start, Cow::Borrowed(first));
        let mut best = (f64::INFINITY, k);
        let mut idle = 0;
        for _ in 0..STEPS {
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
            singular = Cow::Owned(Singular::of(self.at(&k))?);
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
    pub(super) fn root(&self, k: &SVector<f64, D>) -> Option<Root<D>> {
        let singular = Singular::of(self.at(k))?;
        let count = singular.below(KERNEL * self.slope.max(1.0));
        if count == 0 {
            return None;
        }
        let kernel = singular.softest(count);
        let slopes: Vec<DMatrix<Complex>> = (0..D).map(|i| self.derivative(k, i)).collect();
        let surroundings = Surroundings::of(&singular, &kernel, &slopes);
        let turned: Vec<DMatrix<Complex>> = slopes
            .iter()
            .map(|slope| singular.unanswered(count, slope * &kernel))
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
        let found = directional(&products, count);
        let least = found
            .first()
            .map_or(0.0, |(square, _)| square.max(0.0).sqrt());
        let flat = found
            .into_iter()
            .filter(|(square, _)| *square <= flat_square);
        Some(Root {
            wave_vector: *k,
            kernel,
            // Directions are sampled: a little less.
            alone_within: surroundings.alone_within(0.9 * least, self.curvature),
            flat: flat.map(|(_, direction)| direction).collect(),
            tangents,
        })
    }
}

/// How `R` changes around a root, bounds for any unit direction `n`.
///
/// There `R = R_0 + d S + E` at the distance `d`, with `S = n.dR` and `|E| <= e = M d^2 / 2`, `M` a bound on the second derivative. With the kernel `U`, an
/// orthonormal basis `Q` of the range of `R_0`, its complement `W`, and `R_0 O = Q`, any vector is `U a + O y`. In a kernel at that distance
///
/// `y + Q* (d S + E) (U a + O y) = 0` and `W* (d S + E) (U a + O y) = 0`;
///
/// the first gives `|y| <= (b d + e) |a| / (1 - h d - e |O|)`, and with it the second
///
/// `s d <= e + (c d + e |O|) (b d + e) / (1 - h d - e |O|)`,
///
/// where `s` is the smallest of `|W* S U a|` over unit `n` and `a`.
struct Surroundings {
    /// `b`, of `|Q* S U|`.
    answer: f64,
    /// `h`, of the Hermitian part of `Q* S O`.
    relative: f64,
    /// `c`, of `|W* S O|`.
    turned: f64,
    /// `|O|`, the inverse of the smallest singular value other than zero.
    softness: f64,
}

impl Surroundings {
    fn of(singular: &Singular, kernel: &DMatrix<Complex>, slopes: &[DMatrix<Complex>]) -> Self {
        let count = kernel.ncols();
        let rank = singular.values.len() - count;
        if rank == 0 {
            return Self {
                answer: 0.0,
                relative: 0.0,
                turned: 0.0,
                softness: 0.0,
            };
        }
        let (range, origins) = (singular.range(count), singular.origins(count));
        let relative = |slope: &DMatrix<Complex>| {
            let product = range.ad_mul(&(slope * &origins));
            (&product + product.adjoint()) * Complex::from(0.5)
        };
        // Of a sum over the components of a unit vector the norm is at most the root of the sum of the squares.
        let of_any = |part: &dyn Fn(&DMatrix<Complex>) -> DMatrix<Complex>| -> f64 {
            let squares = slopes.iter().map(|slope| norm(&part(slope)).powi(2));
            squares.sum::<f64>().sqrt()
        };
        Self {
            answer: of_any(&|slope| range.ad_mul(&(slope * kernel))),
            relative: of_any(&relative),
            turned: of_any(&|slope| singular.unanswered(count, slope * &origins)),
            softness: singular.values[rank - 1].recip(),
        }
    }

    /// The distance within which there is no other root, for `s` and `M`: what is left of `s d` grows with the distance.
    fn alone_within(&self, s: f64, curvature: f64) -> f64 {
        let is_alone = |d: f64| {
            let e = 0.5 * curvature * d;
            let soft = e * self.softness;
            let share = 1.0 - (self.relative + soft) * d;
            share > 0.0 && e + (self.turned + soft) * (self.answer + e) * d / share < s
        };
        let (mut least, mut most) = (0.0, 2.0 * s / curvature);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (least + most);
            match is_alone(middle) {
                true => least = middle,
                false => most = middle,
            }
        }
        least
    }
}

/// The spectral norm.
fn norm(matrix: &DMatrix<Complex>) -> f64 {
    matrix.singular_values().max()
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

#[cfg(test)]
mod tests {
    use super::Root;
    use crate::algebra::{array_of, uniform};
    use crate::kernel::Kernel;
    use crate::lattice::{Crystal, LatticeKind};
    use crate::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
    use crate::scheme::{Discretization, StrainRows};
    use nalgebra::SVector;
    use std::f64::consts::PI;

    /// No wave as near to a root as is said is without strain, and no other root is.
    fn assert_alone<const D: usize>(
        kind: LatticeKind,
        (radius, cells, disorder): (f64, [usize; D], f64),
        (root, other): ([f64; D], Option<[f64; D]>),
        least: f64,
    ) {
        let crystal = Crystal::of(kind, 1.0)
            .and_then(|one| one.supercell(cells))
            .and_then(|cell| cell.perturbed(disorder, 7));
        let choices = TotalLagrangianChoices {
            kernel: Kernel::QuarticSpline,
            radius,
            ..TotalLagrangianChoices::default()
        };
        let scheme = TotalLagrangianSph::new(crystal.expect("a crystal"), choices);
        let scheme = scheme.expect("a method");
        let rows = StrainRows::new(scheme.crystal(), &scheme.strain().expect("strains"));
        let root = SVector::from(root);
        let found: Root<D> = rows.root(&root).expect("a root");
        let alone = found.alone_within;
        assert!(alone > least, "{kind:?} {alone}");
        if let Some(other) = other.map(SVector::from) {
            assert!(rows.smallest(&other) < 1e-14);
            assert!((other - root).norm() > alone);
        }
        let mut state = 11;
        for n in 0..200 {
            let direction = SVector::from(array_of::<f64, D>(|_| uniform(&mut state) - 0.5));
            let distance = alone * 10.0_f64.powf(-f64::from(n) / 50.0);
            let k = root + direction.normalize() * distance;
            assert!(rows.smallest(&k) > 1e-4 * distance, "{kind:?} {distance}");
        }
    }

    #[test]
    fn roots_are_alone_in_their_neighborhoods() {
        let rest = [0.0; 2];
        let edge = [0.0, PI];
        for (cells, of) in [
            ([1, 1], ([PI, 0.0], Some([PI, PI]))),
            ([2, 1], (edge, Some(rest))),
            ([2, 1], (rest, Some(edge))),
        ] {
            assert_alone(LatticeKind::Square, (2.0, cells, 0.0), of, 0.05);
        }
        let disordered = (2.2, [3, 3], 0.1);
        assert_alone(LatticeKind::Hexagonal, disordered, (rest, None), 0.03);
        let disordered = (1.9, [2, 2, 2], 0.1);
        assert_alone(LatticeKind::SimpleCubic, disordered, ([0.0; 3], None), 0.01);
    }
}
