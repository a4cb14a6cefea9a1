//! What lies next to a root of the strain operator.

use crate::algebra::{Complex, sort_by_value};
use crate::scheme::{Singular, StrainRows};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::f64::consts::PI;

/// Slopes below this fraction of the largest leave a direction in which a root may go on.
const FLAT: f64 = 1e-5;
/// Halvings of an interval in which a distance is sought, which is a lower bound.
const HALVINGS: usize = 40;
/// Turns in which a stationary direction is sought, and the part by which one must be lower than that before.
const TURNS: usize = 60;
const SETTLED: f64 = 1e-6;
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
}

impl<const D: usize> StrainRows<D> {
    /// What is known of the neighborhood of a root; `None` where there is no kernel.
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
        let flat_square = (FLAT * self.slope).powi(2);
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
    let square = |n: &SVector<f64, D>| along(products, n).symmetric_eigenvalues().min();
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
            found.push(refined(products, (value, n)));
        }
    }
    sort_by_value(&mut found, |item| item.0);
    found
}

/// A stationary direction downhill from one: for a vector `a` of the kernel the best direction is an eigenvector of the `a* T_i* T_j a`, and for a
/// direction the best vector one of `sum n_i n_j T_i* T_j`, in turns.
fn refined<const D: usize>(
    products: &[Vec<DMatrix<Complex>>],
    (mut value, mut n): (f64, SVector<f64, D>),
) -> (f64, SVector<f64, D>) {
    for _ in 0..TURNS {
        let soft = along(products, &n).symmetric_eigen();
        let a = soft
            .eigenvectors
            .column(soft.eigenvalues.imin())
            .into_owned();
        let form = SMatrix::<f64, D, D>::from_fn(|i, j| a.dotc(&(&products[i][j] * &a)).re);
        let Some((lower, better)) = eigen(&form).into_iter().next() else {
            break;
        };
        let has_settled = lower >= value * (1.0 - SETTLED);
        if lower < value {
            (value, n) = (lower, better);
        }
        if has_settled {
            break;
        }
    }
    (value, n)
}

/// `sum n_i n_j T_i* T_j`.
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
