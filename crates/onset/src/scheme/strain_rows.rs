//! Strain operator at a wave vector: a matrix whose kernel contains the zero-energy modes.

use super::{SeenForm, StrainOperator};
use crate::algebra::{Complex, array_of, cholesky_factor};
use crate::lattice::{Crystal, Particle};
use nalgebra::{DMatrix, SVector};

/// Rounding error of an entry of `R`, relative to the sum of the sizes of its terms.
const ENTRY_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Relative error of `T^-1` for the most nearly singular `R` that is still resolved.
const INVERSE_ERROR_LIMIT: f64 = 1e-6;

/// Matrix `R(k)` of the strain operator for the wave `u_K = g_K exp(i k.X_K)`, acting on the amplitudes `g` of the particles of a cell.
///
/// With one particle per cell `sym(g (x) B)` vanishes only with `B`, for any `g`. If the operator contains only strains, the matrix is therefore the
/// single column of the gradients `B`.
///
/// The phases of a form are relative to its center, and a factor limits its slope to one particle spacing. Neither changes the kernel.
#[derive(Clone, Debug)]
pub(crate) struct StrainRows<const D: usize> {
    sites: usize,
    /// Whether the gradients replace the strains.
    is_gradient: bool,
    points: Vec<Point<D>>,
    /// Distance between nearest particles; length.
    pub(crate) spacing: f64,
    /// Bound of the norm of a derivative of `R` along a unit direction; length.
    pub(crate) slope: f64,
    /// Bound of the norm of a second derivative of `R`; length^2.
    pub(crate) curvature: f64,
}

/// Forms of one quadrature point.
#[derive(Clone, Debug)]
struct Point<const D: usize> {
    sites: Vec<usize>,
    /// Vectors `X_K` from the center of the particles.
    vectors: Vec<SVector<f64, D>>,
    forms: Vec<Form<D>>,
}

#[derive(Clone, Debug)]
struct Form<const D: usize> {
    is_strain: bool,
    vectors: Vec<SVector<f64, D>>,
}

/// Sums of a form over the particles of each site.
#[derive(Clone, Copy)]
struct Sums<const D: usize> {
    value: SVector<Complex, D>,
    /// Change along each edge of a box.
    slopes: [SVector<Complex, D>; D],
    /// Bounds of the remainder of the change anywhere in the box, after first and after second derivatives.
    rests: [f64; 2],
}

impl<const D: usize> Sums<D> {
    fn zero() -> Self {
        Self {
            value: SVector::zeros(),
            slopes: [SVector::zeros(); D],
            rests: [0.0; 2],
        }
    }
}

impl<const D: usize> StrainRows<D> {
    pub(crate) fn new(crystal: &Crystal<D>, strain: &StrainOperator<D>) -> Self {
        let sites = crystal.sites().len();
        let seen = || strain.points().iter().flat_map(|point| &point.forms);
        let is_strain = |form: &SeenForm<D>| matches!(form, SeenForm::Strain(_));
        let strains = seen().filter(|form| is_strain(form)).count();
        let controls = seen().count() - strains;
        let mut rows = Self {
            sites,
            is_gradient: sites == 1 && controls == 0,
            points: Vec::new(),
            spacing: crystal.nearest_distance(),
            slope: 0.0,
            curvature: 0.0,
        };
        for point in strain.points() {
            let position = |particle: &Particle<D>| crystal.position(particle);
            let places: Vec<SVector<f64, D>> = point.particles.iter().map(position).collect();
            let weight = |k: usize| -> f64 {
                let forms = point.forms.iter();
                forms.map(|form| form.vectors()[k].norm()).sum()
            };
            let weights: Vec<f64> = (0..places.len()).map(weight).collect();
            let total: f64 = weights.iter().sum();
            if total == 0.0 {
                continue;
            }
            let both = places.iter().zip(&weights);
            let middle: SVector<f64, D> = both.map(|(x, w)| x * (w / total)).sum();
            let vectors: Vec<SVector<f64, D>> = places.iter().map(|x| x - middle).collect();
            let mut placed = Point {
                sites: point
                    .particles
                    .iter()
                    .map(|particle| particle.site)
                    .collect(),
                vectors,
                forms: Vec::new(),
            };
            for form in &point.forms {
                let count = if is_strain(form) { strains } else { controls };
                let moment = |power: i32, site: Option<usize>| -> f64 {
                    let terms = placed.sites.iter().zip(&placed.vectors);
                    let terms = terms.zip(form.vectors());
                    let terms = terms.filter(|((own, _), _)| site.is_none_or(|site| site == **own));
                    terms
                        .map(|((_, x), b)| b.norm() * x.norm().powi(power))
                        .sum()
                };
                let size = match moment(1, None) {
                    0.0 => moment(0, None) * rows.spacing,
                    size => size,
                };
                if size == 0.0 {
                    continue;
                }
                let factor = rows.spacing / (size * (count as f64).sqrt());
                for site in 0..sites {
                    rows.slope += (factor * moment(1, Some(site))).powi(2);
                    rows.curvature += (factor * moment(2, Some(site))).powi(2);
                }
                placed.forms.push(Form {
                    is_strain: is_strain(form),
                    vectors: form.vectors().iter().map(|b| b * factor).collect(),
                });
            }
            rows.points.push(placed);
        }
        rows.slope = rows.slope.sqrt();
        rows.curvature = rows.curvature.sqrt();
        rows
    }

    /// Number of columns of `R`.
    pub(crate) fn columns(&self) -> usize {
        if self.is_gradient { 1 } else { D * self.sites }
    }

    /// Number of independent modes for each vector of the kernel.
    pub(crate) fn modes_per_column(&self) -> usize {
        if self.is_gradient { D } else { 1 }
    }

    /// Cost of an evaluation, in units of one term of a sum.
    pub(crate) fn cost(&self) -> f64 {
        let terms = |point: &Point<D>| point.vectors.len() * (2 + point.forms.len());
        let sums: usize = self.points.iter().map(terms).sum();
        let columns = self.columns() as f64;
        let rows: usize = self.points.iter().map(|point| self.rows_of(point)).sum();
        sums as f64 + columns * columns * (rows as f64 + 10.0 * columns) * 0.2
    }

    fn rows_of(&self, point: &Point<D>) -> usize {
        let of_form = |form: &Form<D>| match (self.is_gradient, form.is_strain) {
            (true, _) => D,
            (false, true) => D * (D + 1) / 2,
            (false, false) => 1,
        };
        point.forms.iter().map(of_form).sum()
    }

    /// Returns the matrix `R(k)`.
    pub(crate) fn at(&self, k: &SVector<f64, D>) -> DMatrix<Complex> {
        self.summed(|x| phase(k.dot(x)))
    }

    /// Returns true if some wave has strains below a fraction of its size.
    pub(crate) fn misses(&self, k: &SVector<f64, D>, fraction: f64) -> bool {
        self.smallest(k) <= fraction * self.slope * k.norm()
    }

    /// Smallest singular value of `R(k)`.
    pub(crate) fn smallest(&self, k: &SVector<f64, D>) -> f64 {
        self.at(k).singular_values().min()
    }

    /// Returns the derivative `dR/dk_i`.
    pub(crate) fn derivative(&self, k: &SVector<f64, D>, i: usize) -> DMatrix<Complex> {
        self.summed(|x| phase(k.dot(x)) * Complex::new(0.0, x[i]))
    }

    fn summed(&self, factor: impl Fn(&SVector<f64, D>) -> Complex) -> DMatrix<Complex> {
        let mut rows = self.empty();
        for point in &self.points {
            let factors: Vec<Complex> = point.vectors.iter().map(&factor).collect();
            for form in &point.forms {
                let mut sums = vec![SVector::<Complex, D>::zeros(); self.sites];
                let terms = point.sites.iter().zip(&factors).zip(&form.vectors);
                for ((site, factor), b) in terms {
                    sums[*site] += b.map(|component| *factor * component);
                }
                self.push(form, sums.iter(), &mut rows);
            }
        }
        rows.finish()
    }

    fn empty(&self) -> Stack {
        Stack {
            columns: self.columns(),
            entries: Vec::new(),
        }
    }

    /// Adds the rows of a form, from its sums for each site.
    fn push<'s>(
        &self,
        form: &Form<D>,
        sums: impl Iterator<Item = &'s SVector<Complex, D>> + Clone,
        rows: &mut Stack,
    ) {
        if self.is_gradient || !form.is_strain {
            sums.for_each(|b| rows.entries.extend(b.iter()));
            return;
        }
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for i in 0..D {
            for j in i..D {
                for b in sums.clone() {
                    let entry = |column: usize| match (column == i, column == j) {
                        (true, true) => b[i],
                        (true, false) => b[j] * half,
                        (false, true) => b[i] * half,
                        (false, false) => Complex::new(0.0, 0.0),
                    };
                    rows.entries.extend((0..D).map(entry));
                }
            }
        }
    }

    /// Returns true if the box `center + sum t_i edge_i`, `|t_i| <= 1`, is proved to contain no zero-energy mode.
    ///
    /// In the box `R = R_0 + S(t) + E`, with the derivatives `S(t) = sum t_i S_i` at the center and a bound `e` of the remainder, `|E| <= e`. A mode
    /// with `R u = 0` has `|R_0 u|^2 + Re u* R_0* (S + E) u = 0`. With `R_0* R_0 >= T* T` no mode exists if `|H(t)| + e |T^-1| < 1`, where `H` is the
    /// Hermitian part of `T^-* R_0* S T^-1`, because `|Re u* R_0* E u| <= e |T^-1| |R_0 u|^2`. The norm is convex in `t` and largest at a corner.
    /// Strains are measured relative to themselves: a wave with small strains contributes only through the change of these strains, and rotations of
    /// a strain are ignored.
    ///
    /// If this test fails, the second derivatives along the edges are separated from `E` and measured in the same way, which leaves a remainder of
    /// third order. Strains of soft waves also have small second derivatives.
    pub(crate) fn is_regular(
        &self,
        center: &SVector<f64, D>,
        edges: &[SVector<f64, D>; D],
    ) -> bool {
        let mut rows = self.empty();
        let mut slopes: Vec<Stack> = (0..D).map(|_| self.empty()).collect();
        let (mut rests, mut rounding) = ([0.0; 2], 0.0);
        let mut factors: Vec<(Complex, [f64; D], [f64; 2])> = Vec::new();
        let mut sums = vec![Sums::zero(); self.sites];
        for point in &self.points {
            factors.clear();
            factors.extend(point.vectors.iter().map(|x| {
                let along: [f64; D] = array_of(|i| edges[i].dot(x));
                let farthest: f64 = along.iter().map(|a| a.abs()).sum();
                let second = 0.5 * farthest * farthest;
                (
                    phase(center.dot(x)),
                    along,
                    [second, second * farthest / 3.0],
                )
            }));
            for form in &point.forms {
                sums.fill(Sums::zero());
                let terms = point.sites.iter().zip(&factors).zip(&form.vectors);
                for ((site, (phase, along, left)), b) in terms {
                    let own = &mut sums[*site];
                    let term = b.map(|component| *phase * component);
                    own.value += term;
                    for i in 0..D {
                        own.slopes[i] += term * Complex::new(0.0, along[i]);
                    }
                    let size = b.norm();
                    for n in 0..2 {
                        own.rests[n] += size * left[n];
                    }
                    rounding += size;
                }
                for n in 0..2 {
                    rests[n] += sums.iter().map(|own| own.rests[n].powi(2)).sum::<f64>();
                }
                self.push(form, sums.iter().map(|own| &own.value), &mut rows);
                for (i, slopes) in slopes.iter_mut().enumerate() {
                    self.push(form, sums.iter().map(|own| &own.slopes[i]), slopes);
                }
            }
        }
        let Some(resistance) = Resistance::of(rows.finish()) else {
            return false;
        };
        // Entries are known to the rounding of their terms and phases. Most boxes that are too large fail by the remainder alone.
        let softness = largest(&resistance.inverse);
        let [second, third] = rests.map(|rest| {
            1.0 - INVERSE_ERROR_LIMIT - (rest.sqrt() + ENTRY_ROUNDING * rounding) * softness
        });
        if third.is_nan() || third <= 0.0 {
            return false;
        }
        let first = resistance.largest_change(slopes);
        first < second || first < third && first + self.bent(center, edges, &resistance) < third
    }

    /// Bound of the second derivatives along the edges of a box, relative to the strains like the first derivatives.
    fn bent(
        &self,
        center: &SVector<f64, D>,
        edges: &[SVector<f64, D>; D],
        resistance: &Resistance,
    ) -> f64 {
        let pairs = (0..D).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let bend = |(i, j): (usize, usize)| {
            let along = |x: &SVector<f64, D>| edges[i].dot(x) * edges[j].dot(x);
            let second = self.summed(|x| phase(center.dot(x)) * Complex::from(-along(x)));
            let share = if i == j { 0.5 } else { 1.0 };
            share * largest(&resistance.relative(&second))
        };
        pairs.map(bend).sum()
    }
}

/// Matrix `R` of full column rank and `T^-1`, where `T* T = R* R - delta` and `delta` covers rounding.
///
/// Singular values below about 1e-7 of the norm are not resolved, which is sufficient to exclude zeros.
struct Resistance {
    rows: DMatrix<Complex>,
    inverse: DMatrix<Complex>,
}

impl Resistance {
    /// Factorizes a matrix. `None` if some wave has no strain to this accuracy.
    fn of(rows: DMatrix<Complex>) -> Option<Self> {
        let (count, size) = rows.shape();
        let delta = f64::EPSILON * (count + 2 * size) as f64 * rows.norm_squared();
        let mut gram = rows.ad_mul(&rows);
        for i in 0..size {
            gram[(i, i)] -= Complex::from(delta);
        }
        // The lower factor is `T*`.
        let lower = cholesky_factor(gram)?;
        let identity = DMatrix::identity(size, size);
        let inverse = lower.solve_lower_triangular(&identity)?.adjoint();
        Some(Self { rows, inverse })
    }

    /// Hermitian part of `T^-* R* S T^-1`.
    fn relative(&self, change: &DMatrix<Complex>) -> DMatrix<Complex> {
        let product = self.rows.ad_mul(change);
        let hermitian = (&product + product.adjoint()) * Complex::new(0.5, 0.0);
        self.inverse.ad_mul(&(hermitian * &self.inverse))
    }

    /// Bound of the norm of the relative change `sum t_i S_i` for `|t_i| <= 1`.
    fn largest_change(&self, slopes: Vec<Stack>) -> f64 {
        let parts = slopes.into_iter().map(|own| self.relative(&own.finish()));
        let parts: Vec<DMatrix<Complex>> = parts.collect();
        // One corner of each pair of opposite corners.
        let corners = 0..1_usize << (parts.len() - 1);
        let at = |corner: usize| {
            let mut sum = parts[0].clone();
            for (i, part) in parts[1..].iter().enumerate() {
                match corner >> i & 1 {
                    0 => sum += part,
                    _ => sum -= part,
                }
            }
            largest(&sum)
        };
        // A corner with NaN prevents the exclusion of the box.
        corners.map(at).fold(0.0, |most, own| {
            if own > most || own.is_nan() {
                own
            } else {
                most
            }
        })
    }
}

/// Upper bound of the spectral norm: `|M|^8 <= tr (M* M)^4`.
fn largest(matrix: &DMatrix<Complex>) -> f64 {
    let square = matrix.ad_mul(matrix);
    (&square * &square).norm().sqrt().sqrt()
}

/// Rows of a matrix, collected one by one.
struct Stack {
    columns: usize,
    entries: Vec<Complex>,
}

impl Stack {
    /// Returns the matrix, filled with rows of zeros if there are fewer rows than columns.
    fn finish(mut self) -> DMatrix<Complex> {
        let rows = (self.entries.len() / self.columns).max(self.columns);
        self.entries
            .resize(rows * self.columns, Complex::new(0.0, 0.0));
        DMatrix::from_row_slice(rows, self.columns, &self.entries)
    }
}

fn phase(angle: f64) -> Complex {
    let (sine, cosine) = angle.sin_cos();
    Complex::new(cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::StrainRows;
    use crate::algebra::{array_of, uniform};
    use crate::kernel::Kernel;
    use crate::lattice::{Crystal, LatticeKind};
    use crate::scheme::Discretization;
    use crate::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
    use nalgebra::SVector;
    use std::f64::consts::PI;

    fn rows(cells: [usize; 2], disorder: f64) -> StrainRows<2> {
        let crystal = Crystal::of(LatticeKind::Square, 1.0)
            .and_then(|one| one.supercell(cells))
            .and_then(|cell| cell.perturbed(disorder, 7))
            .expect("a crystal");
        let choices = TotalLagrangianChoices {
            kernel: Kernel::QuarticSpline,
            radius: 2.0,
            ..TotalLagrangianChoices::default()
        };
        let scheme = TotalLagrangianSph::new(crystal, choices).expect("a method");
        StrainRows::new(scheme.crystal(), &scheme.strain().expect("strains"))
    }

    /// The wave of alternating particles has no strain on a square lattice, also in cells of two. In a disordered lattice every wave has strain.
    #[test]
    fn boxes_are_excluded_only_where_every_wave_has_strain() {
        let mut state = 3;
        let mut number = || 2.0 * uniform(&mut state) - 1.0;
        let root = SVector::from([0.0, PI]);
        let known = [
            ([1, 1], [PI, 0.0]),
            ([2, 1], [0.0, PI]),
            ([2, 1], [0.0, 0.0]),
        ];
        for (cells, root) in known {
            let rows = rows(cells, 0.0);
            let root = SVector::from(root);
            assert!(rows.smallest(&root) < 1e-14);
            for n in 0..300 {
                let size = 10.0_f64.powf(-f64::from(n) / 25.0);
                let edges = array_of(|_| SVector::from([number(), number()]) * size);
                let center = root + edges[0] * number() + edges[1] * number();
                assert!(
                    !rows.is_regular(&center, &edges),
                    "{cells:?} {center} {edges:?}"
                );
            }
        }
        let rows = rows([3, 2], 0.1);
        let mut excluded = 0;
        for n in 0..300 {
            let size = 0.3 * 10.0_f64.powf(-f64::from(n) / 150.0);
            let edges = array_of(|_| SVector::from([number(), number()]) * size);
            let center = root + SVector::from([number(), number()]);
            if rows.is_regular(&center, &edges) {
                excluded += 1;
                for _ in 0..8 {
                    let k = center + edges[0] * number() + edges[1] * number();
                    assert!(rows.smallest(&k) > 1e-6, "{k}");
                }
            }
        }
        assert!(excluded > 50, "{excluded}");
    }
}
