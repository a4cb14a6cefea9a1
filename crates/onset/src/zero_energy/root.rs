//! Neighborhood of a root of the strain operator.

use crate::algebra::{Complex, sort_by_value};
use crate::scheme::{Singular, StrainRows};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::f64::consts::PI;

/// Largest slope of a direction in which roots may continue, as a fraction of the largest slope.
const FLAT_SLOPE: f64 = 1e-5;
/// Number of bisections of an interval that contains a distance. Its lower end is used.
const HALVINGS: usize = 40;
/// Largest number of alternating minimizations for a stationary direction, and the relative decrease at which they stop.
const MAX_ALTERNATIONS: usize = 60;
const STATIONARY_DECREASE: f64 = 1e-6;
/// Number of sampled directions, by dimension. Opposite directions are equivalent.
const DIRECTION_COUNTS: [usize; 3] = [1, 90, 240];

/// Wave vector at which the strain operator `R` has a kernel.
#[derive(Clone, Debug)]
pub(super) struct Root<const D: usize> {
    pub(super) wave_vector: SVector<f64, D>,
    /// Orthonormal basis of the kernel, in columns.
    pub(super) kernel: DMatrix<Complex>,
    /// Radius of a neighborhood without other roots; 1/length.
    pub(super) alone_within: f64,
    /// Unit directions of zero slope, in which the roots may continue.
    pub(super) flat: Vec<SVector<f64, D>>,
}

impl<const D: usize> StrainRows<D> {
    /// Returns the root at a wave vector, with its neighborhood; `None` if `R` has no kernel there.
    pub(super) fn root(&self, k: &SVector<f64, D>) -> Option<Root<D>> {
        let singular = Singular::of(self.at(k))?;
        let count = singular.nullity();
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
        let flat_square = (FLAT_SLOPE * self.slope).powi(2);
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
            // The factor allows for the sampling of directions.
            alone_within: surroundings.alone_within(0.9 * least, self.curvature),
            flat: flat.map(|(_, direction)| direction).collect(),
        })
    }
}

/// Bounds on the change of `R` around a root, for any unit direction `n`.
///
/// At the distance `d` from the root, `R = R_0 + d S + E`, with `S = n.dR` and `|E| <= e = M d^2 / 2`. `M` bounds the second derivative. The kernel
/// is `U`, an orthonormal basis of the range of `R_0` is `Q`, and of its complement `W`. With `R_0 O = Q`, any vector is `U a + O y`. If it lies in
/// the kernel of `R`,
///
/// `y + Q* (d S + E) (U a + O y) = 0` and `W* (d S + E) (U a + O y) = 0`;
///
/// The first equation gives `|y| <= (b d + e) |a| / (1 - h d - e |O|)`. The second then gives
///
/// `s d <= e + (c d + e |O|) (b d + e) / (1 - h d - e |O|)`,
///
/// where `s` is the smallest value of `|W* S U a|` over unit `n` and `a`.
struct Surroundings {
    /// Bound `b` on `|Q* S U|`.
    answer: f64,
    /// Bound `h` on the Hermitian part of `Q* S O`.
    relative: f64,
    /// Bound `c` on `|W* S O|`.
    turned: f64,
    /// Norm `|O|`, the inverse of the smallest nonzero singular value.
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
        // The norm of a sum weighted by the components of a unit vector is at most the root of the sum of squares.
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

    /// Distance within which no other root exists, for given `s` and `M`. The bound on `s d`, divided by `d`, increases with the distance.
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

fn norm(matrix: &DMatrix<Complex>) -> f64 {
    matrix.singular_values().max()
}

/// Smallest `|n.T a|^2` over unit `a` as a function of the direction `n`: its stationary directions, lowest value first.
///
/// `products` are the matrices `T_i* T_j`.
fn directional<const D: usize>(
    products: &[Vec<DMatrix<Complex>>],
    count: usize,
) -> Vec<(f64, SVector<f64, D>)> {
    if count == 1 {
        let real = SMatrix::<f64, D, D>::from_fn(|i, j| products[i][j][(0, 0)].re);
        return eigen(&real);
    }
    let square = |n: &SVector<f64, D>| along(products, n).symmetric_eigenvalues().min();
    let mut sampled: Vec<(f64, SVector<f64, D>)> = directions::<D>()
        .into_iter()
        .map(|n| (square(&n), n))
        .collect();
    sort_by_value(&mut sampled, |item| item.0);
    // The lowest samples are refined, one of each group of neighbors.
    let mut found: Vec<(f64, SVector<f64, D>)> = Vec::new();
    let apart = 4.0 / (DIRECTION_COUNTS[D - 1] as f64).powf(1.0 / (D.max(2) - 1) as f64);
    for (value, n) in sampled {
        let is_new = found
            .iter()
            .all(|(_, other)| (n - other).norm().min((n + other).norm()) > apart);
        if is_new && found.len() < 8 {
            found.push(refined(products, (value, n)));
        }
    }
    sort_by_value(&mut found, |item| item.0);
    found
}

/// Descends from a direction to a stationary direction by alternating minimization.
///
/// For a vector `a` of the kernel the best direction is an eigenvector of `a* T_i* T_j a`. For a direction the best vector is an eigenvector of `sum
/// n_i n_j T_i* T_j`.
fn refined<const D: usize>(
    products: &[Vec<DMatrix<Complex>>],
    (mut value, mut n): (f64, SVector<f64, D>),
) -> (f64, SVector<f64, D>) {
    for _ in 0..MAX_ALTERNATIONS {
        let soft = along(products, &n).symmetric_eigen();
        let a = soft
            .eigenvectors
            .column(soft.eigenvalues.imin())
            .into_owned();
        let form = SMatrix::<f64, D, D>::from_fn(|i, j| a.dotc(&(&products[i][j] * &a)).re);
        let Some((lower, better)) = eigen(&form).into_iter().next() else {
            break;
        };
        let has_settled = lower >= value * (1.0 - STATIONARY_DECREASE);
        if lower < value {
            (value, n) = (lower, better);
        }
        if has_settled {
            break;
        }
    }
    (value, n)
}

/// Returns the matrix `sum n_i n_j T_i* T_j`.
fn along<const D: usize>(
    products: &[Vec<DMatrix<Complex>>],
    n: &SVector<f64, D>,
) -> DMatrix<Complex> {
    let mut sum = &products[0][0] * Complex::from(n[0] * n[0]);
    for i in 0..D {
        for j in 0..D {
            if i + j > 0 {
                sum += &products[i][j] * Complex::from(n[i] * n[j]);
            }
        }
    }
    sum
}

/// Directions distributed evenly over the half sphere.
fn directions<const D: usize>() -> Vec<SVector<f64, D>> {
    let count = DIRECTION_COUNTS[D - 1];
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

/// Eigenvalues and eigenvectors of a symmetric matrix, lowest first.
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

    /// Checks that all sampled waves within the stated distance of a root have strain, and that the nearest other root is farther away.
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
    fn each_neighborhood_contains_a_single_root() {
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
