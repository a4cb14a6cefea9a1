//! Interval enclosures of quadrature points, neighbors and shape functions.
//!
//! The definitions of [`crate::method`] and [`crate::approximation`] are implemented here independently, so that a proof does not rely on the
//! floating-point code.

use super::Reason;
use crate::algebra::{Each, array_of};
use crate::approximation::Approximation;
use crate::kinematics::DeformationGradient;
use crate::method::{Background, CurrentLattice, Frame, MAXIMUM_NEIGHBORS, Method, SupportSize};
use crate::real::{Interval, Real};

/// Error of the positions of quadrature points and primitive vectors, in units in the last place.
const PLACE_ULPS: u32 = 4;
/// Error of Voronoi volumes, in units in the last place.
const VOLUME_ULPS: u32 = 64;
/// Largest difference of lattice coordinates of positions that count as equal.
const PLACE_TOLERANCE: f64 = 2e-16;

/// Distance from the edge of the support, in support radii, within which [`Kernel::weight`](crate::kernel::Kernel::weight) ignores a neighbor.
const RIM_DISTANCE: f64 = 1e-12;

/// Up to three coefficients or basis functions; unused entries are zero.
type Basis = [Interval; 3];
type BasisMatrix = [Basis; 3];
type Square<const D: usize> = [[Interval; D]; D];

/// Quadrature point, which also represents its mirror image.
pub(super) struct Point<const D: usize> {
    /// Factor `V_q / (rho V0)` of the point and its image together.
    pub(super) factor: Interval,
    pub(super) is_node: bool,
    pub(super) place: [f64; D],
    pub(super) neighbors: Vec<Neighbor<D>>,
    pub(super) deformation: DeformationGradient<Interval>,
    /// Number of basis functions.
    pub(super) basis: usize,
    /// Whether `sum_K grad phi_K` vanishes by symmetry or because the functions are a partition of unity.
    pub(super) has_balanced_gradients: bool,
}

/// Particle in the support of a quadrature point, with its shape function and all derivatives of the function.
pub(super) struct Neighbor<const D: usize> {
    /// Lattice coordinates relative to the cell of the point.
    pub(super) cell: [i32; D],
    pub(super) value: Interval,
    pub(super) gradient: [Interval; D],
    pub(super) hessian: Square<D>,
    pub(super) frozen_hessian: Square<D>,
    /// Weighted basis `a = p W` and its derivatives with respect to the position.
    pub(super) a: Basis,
    pub(super) a1: [Basis; D],
    /// Derivative `d alpha / d x_K,t` and its derivative with respect to the evaluation point, `[j][t]`.
    pub(super) shift: [Basis; D],
    pub(super) shift1: [[Basis; D]; D],
}

/// Weight of a particle with its position in the basis.
struct Term<const D: usize> {
    cell: [i32; D],
    position: [Interval; D],
    basis: Basis,
    /// Gradient of the basis.
    basis1: [Basis; D],
    a: Basis,
    a1: [Basis; D],
    a2: [[Basis; D]; D],
}

/// Support and metric of the kernels at a state.
struct Layout<const D: usize> {
    vectors: Square<D>,
    metric: Square<D>,
    radius: Interval,
}

/// Returns the quadrature points of one cell, one of each pair that inversion maps to each other.
///
/// # Errors
/// [`Reason::Method`] for approximations and quadratures that are not implemented here. [`Reason::NoInversionCenter`] if inversion does not map the
/// set onto itself. [`Reason::NotFinite`] if the deformed lattice is so thin that intervals do not distinguish it from a degenerate one.
pub(super) fn points<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
) -> Result<Vec<Point<D>>, Reason> {
    let is_covered = matches!(
        method.choices().approximation,
        Approximation::Raw | Approximation::Shepard | Approximation::Mls
    );
    if !is_covered || method.is_naturally_stabilized() {
        return Err(Reason::Method);
    }
    let layout = layout(method, f);
    let all = method.quadrature_points();
    let mut points = Vec::new();
    for (index, point) in all.iter().enumerate() {
        let image = |other: &crate::quadrature::QuadraturePoint<D>| {
            (0..D).all(|i| {
                let sum = point.place[i] + other.place[i];
                (sum - sum.round()).abs() <= PLACE_TOLERANCE
            }) && (point.volume - other.volume).abs() <= 1e-14 * point.volume
        };
        let partner = all
            .iter()
            .position(image)
            .ok_or(Reason::NoInversionCenter)?;
        if partner < index {
            continue;
        }
        let volume = Interval::around(point.volume, VOLUME_ULPS);
        let share = volume / Interval::around(method.lattice().cell_volume(), VOLUME_ULPS);
        let multiplicity = if partner == index { 1.0 } else { 2.0 };
        let factor = share * multiplicity / method.choices().density;
        let place = array_of(|i| point.place[i]);
        let is_center = partner == index;
        let point = enclosed(method, f, &layout, place, point.is_node, is_center, factor);
        points.push(point.ok_or(Reason::NotFinite)?);
    }
    Ok(points)
}

fn layout<const D: usize>(method: &Method<D>, f: &DeformationGradient) -> Layout<D> {
    let discretization = method.choices();
    let leading: Square<D> = array_of(|i| array_of(|j| Interval::point(f.components()[i][j])));
    let is_convected = discretization.frame == Frame::Eulerian
        && discretization.current_lattice == CurrentLattice::Convected;
    let home = if is_convected { leading } else { identity() };
    let reference: Square<D> = array_of(|i| {
        array_of(|j| Interval::around(method.lattice().vectors()[(i, j)], PLACE_ULPS))
    });
    let radius = Interval::point(method.support_radius());
    let support_size = if discretization.frame == Frame::Eulerian {
        discretization.support_size
    } else {
        SupportSize::Fixed
    };
    let (radius, metric) = match support_size {
        SupportSize::Fixed => (radius, identity()),
        SupportSize::Scaled => {
            let volume = determinant(&leading);
            let mean = if D == 1 { volume } else { volume.sqrt() };
            (radius * mean, identity())
        }
        SupportSize::Convected => (radius, inverse(&home)),
    };
    Layout {
        vectors: product(&home, &reference),
        metric,
        radius,
    }
}

fn enclosed<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
    layout: &Layout<D>,
    place: [f64; D],
    is_node: bool,
    is_center: bool,
    factor: Interval,
) -> Option<Point<D>> {
    let discretization = method.choices();
    let approximation = discretization.approximation;
    let basis = if approximation == Approximation::Mls {
        D + 1
    } else {
        1
    };
    let fractional = place.each(|x| Interval::around(x, PLACE_ULPS));
    let map = inverse(&product(&layout.metric, &layout.vectors));
    let reach = map.each(|row| (norm(&row) * layout.radius).high);
    let mut terms = Vec::new();
    for cell in cells(&fractional, &reach)? {
        let offset: [Interval; D] = array_of(|i| -fractional[i] + f64::from(cell[i]));
        let position = image(&layout.vectors, &offset);
        terms.extend(term(method, layout, cell, position, basis));
    }
    let raw = (approximation == Approximation::Raw).then(|| raw_factor(method, layout));
    // Three triangles meet in each centroid of the hexagonal reference lattice, as two axes do in a center. A vector that is invariant under this
    // symmetry is zero.
    let is_regular = discretization.frame == Frame::Lagrangian
        || discretization.current_lattice == CurrentLattice::Regular;
    let is_centroid = is_regular
        && discretization.lattice == crate::lattice::LatticeKind::Hexagonal
        && (place[0] - place[1]).abs() <= PLACE_TOLERANCE
        && (3.0 * place[0] - (3.0 * place[0]).round()).abs() <= 3.0 * PLACE_TOLERANCE;
    let neighbors = shape_functions(&terms, basis, raw);
    let deformation = carried(method, f, &terms, &neighbors);
    Some(Point {
        factor,
        is_node,
        place,
        neighbors,
        deformation,
        basis,
        has_balanced_gradients: raw.is_none() || is_center || is_centroid,
    })
}

/// Weight of a particle, or `None` if it is certainly outside the support. In doubtful cases the intervals include zero, so they contain the weight
/// on both sides of the edge even if the kernel is not smooth there.
fn term<const D: usize>(
    method: &Method<D>,
    layout: &Layout<D>,
    cell: [i32; D],
    position: [Interval; D],
    basis: usize,
) -> Option<Term<D>> {
    let inverse_radius = layout.radius.recip();
    let y = image(&layout.metric, &position).each(|x| x * inverse_radius);
    let q = norm(&y);
    if q.low > 1.0 {
        return None;
    }
    let mut profile = method.choices().kernel.profile::<D, _>(q);
    if q.high >= 1.0 - RIM_DISTANCE {
        profile.value = profile.value.hull(Interval::ZERO);
        profile.slope_over_q = profile.slope_over_q.hull(Interval::ZERO);
        profile.curvature_over_q = profile.curvature_over_q.hull(Interval::ZERO);
    }
    let in_unit: Square<D> = array_of(|j| {
        array_of(|t| {
            // |y_j y_t / q| <= q also holds at the center.
            let ratio = if q.low > 0.0 {
                y[j] * y[t] / q
            } else {
                Interval::new(-q.high, q.high)
            };
            let diagonal = if j == t {
                profile.slope_over_q
            } else {
                Interval::ZERO
            };
            diagonal + ratio * profile.curvature_over_q
        })
    });
    let map = layout.metric.each(|row| row.each(|x| x * inverse_radius));
    let gradient: [Interval; D] =
        array_of(|j| sum((0..D).map(|a| map[a][j] * y[a])) * profile.slope_over_q);
    let half = product(&in_unit, &map);
    let hessian: Square<D> =
        array_of(|j| array_of(|t| sum((0..D).map(|a| map[a][j] * half[a][t]))));

    let p: Basis = array_of(|b| match b {
        0 => Interval::point(1.0),
        _ if b < basis => position[b - 1] * inverse_radius,
        _ => Interval::ZERO,
    });
    let p1: [Basis; D] = array_of(|j| {
        array_of(|b| {
            if b < basis && b == j + 1 {
                inverse_radius
            } else {
                Interval::ZERO
            }
        })
    });
    let entries = |entry: &dyn Fn(usize) -> Interval| -> Basis {
        array_of(|b| if b < basis { entry(b) } else { Interval::ZERO })
    };
    Some(Term {
        cell,
        position,
        a: entries(&|b| p[b] * profile.value),
        a1: array_of(|j| entries(&|b| p1[j][b] * profile.value + p[b] * gradient[j])),
        a2: array_of(|j| {
            array_of(|t| {
                entries(&|b| p1[j][b] * gradient[t] + p1[t][b] * gradient[j] + p[b] * hessian[j][t])
            })
        }),
        basis: p,
        basis1: p1,
    })
}

/// Particle volume divided by the integral of the weight.
fn raw_factor<const D: usize>(method: &Method<D>, layout: &Layout<D>) -> Interval {
    let unit = method.choices().kernel.enclosed_integral::<D>();
    let integral = unit * layout.radius.powi(D as i32) / determinant(&layout.metric).abs();
    determinant(&layout.vectors).abs() / integral
}

/// Shape functions `alpha . p W` with `M alpha = e_0`, or with a constant `alpha` for raw weights.
fn shape_functions<const D: usize>(
    terms: &[Term<D>],
    basis: usize,
    raw: Option<Interval>,
) -> Vec<Neighbor<D>> {
    let zero = [Interval::ZERO; 3];
    let mut inverted = [zero; 3];
    let mut alpha = zero;
    let mut alpha1 = [zero; D];
    let mut alpha2 = [[zero; D]; D];
    let mut moment1 = [[zero; 3]; D];
    if let Some(factor) = raw {
        alpha[0] = factor;
    } else {
        let mut moment = [zero; 3];
        for term in terms {
            add_outer(&mut moment, &term.basis, &term.a, basis);
            for j in 0..D {
                add_outer(&mut moment1[j], &term.basis1[j], &term.a, basis);
                add_outer(&mut moment1[j], &term.basis, &term.a1[j], basis);
            }
        }
        inverted = inverse_of_basis(&moment, basis);
        alpha = array_of(|b| inverted[b][0]);
        alpha1 = array_of(|j| apply(&inverted, &apply(&moment1[j], &alpha)));
        for j in 0..D {
            for t in 0..D {
                let mut right = add(
                    &apply(&moment1[j], &alpha1[t]),
                    &apply(&moment1[t], &alpha1[j]),
                );
                for term in terms {
                    right = add(&right, &negative(&second_moment(term, j, t, &alpha)));
                }
                alpha2[j][t] = apply(&inverted, &right);
            }
        }
    }
    let neighbor = |term: &Term<D>| {
        let frozen: Square<D> = array_of(|j| array_of(|t| dot(&alpha, &term.a2[j][t])));
        let shift: [Basis; D] =
            array_of(|t| negative(&apply(&inverted, &first_moment(term, t, &alpha))));
        Neighbor {
            cell: term.cell,
            value: dot(&alpha, &term.a),
            gradient: array_of(|j| dot(&alpha1[j], &term.a) - dot(&alpha, &term.a1[j])),
            hessian: array_of(|j| {
                array_of(|t| {
                    dot(&alpha2[j][t], &term.a)
                        - dot(&alpha1[j], &term.a1[t])
                        - dot(&alpha1[t], &term.a1[j])
                        + frozen[j][t]
                })
            }),
            frozen_hessian: frozen,
            a: term.a,
            a1: term.a1,
            shift,
            shift1: array_of(|j| {
                array_of(|t| {
                    let right = add(
                        &add(
                            &second_moment(term, j, t, &alpha),
                            &apply(&moment1[j], &shift[t]),
                        ),
                        &negative(&first_moment(term, t, &alpha1[j])),
                    );
                    apply(&inverted, &right)
                })
            }),
        }
    };
    terms.iter().map(neighbor).collect()
}

/// First-derivative moment `(p_,j (x) a + p (x) a_,j) v`.
fn first_moment<const D: usize>(term: &Term<D>, j: usize, v: &Basis) -> Basis {
    let (along, across) = (dot(&term.a, v), dot(&term.a1[j], v));
    array_of(|b| term.basis1[j][b] * along + term.basis[b] * across)
}

/// Second-derivative moment `(p_,j (x) a_,t + p_,t (x) a_,j + p (x) a_,jt) v`.
fn second_moment<const D: usize>(term: &Term<D>, j: usize, t: usize, v: &Basis) -> Basis {
    let (own, other) = (dot(&term.a1[j], v), dot(&term.a1[t], v));
    let both = dot(&term.a2[j][t], v);
    array_of(|b| term.basis1[j][b] * other + term.basis1[t][b] * own + term.basis[b] * both)
}

/// Deformation gradient stored at a quadrature point.
fn carried<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
    terms: &[Term<D>],
    neighbors: &[Neighbor<D>],
) -> DeformationGradient<Interval> {
    let mut components = f.components().each(|row| row.map(Interval::point));
    let discretization = method.choices();
    if discretization.background == Background::Interpolated {
        let moment: Square<D> = array_of(|i| {
            array_of(|j| {
                sum(terms
                    .iter()
                    .zip(neighbors)
                    .map(|(term, neighbor)| term.position[i] * neighbor.gradient[j]))
            })
        });
        let leading: Square<D> = array_of(|i| array_of(|j| components[i][j]));
        let one = identity::<D>();
        let seen = match discretization.frame {
            Frame::Lagrangian => combined(
                &one,
                &product(&combined(&leading, &one, -1.0), &moment),
                1.0,
            ),
            Frame::Eulerian => {
                let change = combined(&one, &inverse(&leading), -1.0);
                inverse(&combined(&one, &product(&change, &moment), -1.0))
            }
        };
        for i in 0..D {
            components[i][..D].copy_from_slice(&seen[i]);
        }
    }
    DeformationGradient::from_components(components)
}

/// Cells with lattice coordinates within `reach` of a position; `None` if there are too many.
fn cells<const D: usize>(place: &[Interval; D], reach: &[f64; D]) -> Option<Vec<[i32; D]>> {
    let boxes: f64 = reach.iter().map(|r| 2.0 * r + 3.0).product();
    if boxes.is_nan() || boxes > 1e4 * MAXIMUM_NEIGHBORS as f64 {
        return None;
    }
    let low: [i32; D] = array_of(|i| (place[i].low - reach[i]).floor() as i32);
    let high: [i32; D] = array_of(|i| (place[i].high + reach[i]).ceil() as i32);
    let mut cells = Vec::new();
    let mut cell = low;
    loop {
        cells.push(cell);
        let Some(axis) = (0..D).find(|&i| cell[i] < high[i]) else {
            return Some(cells);
        };
        cell[..axis].copy_from_slice(&low[..axis]);
        cell[axis] += 1;
    }
}

fn sum(items: impl Iterator<Item = Interval>) -> Interval {
    items.fold(Interval::ZERO, |sum, item| sum + item)
}

fn norm<const D: usize>(v: &[Interval; D]) -> Interval {
    sum(v.iter().map(|x| x.square())).sqrt()
}

fn identity<const D: usize>() -> Square<D> {
    array_of(|i| array_of(|j| Interval::point(f64::from(u8::from(i == j)))))
}

fn product<const D: usize>(a: &Square<D>, b: &Square<D>) -> Square<D> {
    array_of(|i| array_of(|j| sum((0..D).map(|m| a[i][m] * b[m][j]))))
}

fn combined<const D: usize>(a: &Square<D>, b: &Square<D>, factor: f64) -> Square<D> {
    array_of(|i| array_of(|j| a[i][j] + b[i][j] * factor))
}

fn image<const D: usize>(m: &Square<D>, v: &[Interval; D]) -> [Interval; D] {
    array_of(|i| sum((0..D).map(|j| m[i][j] * v[j])))
}

/// Determinant in one and two dimensions; an unbounded interval in other dimensions.
fn determinant<const D: usize>(m: &Square<D>) -> Interval {
    match D {
        1 => m[0][0],
        2 => m[0][0] * m[1][1] - m[0][1] * m[1][0],
        _ => Interval::ENTIRE,
    }
}

/// Inverse in one and two dimensions; unbounded intervals in other dimensions.
fn inverse<const D: usize>(m: &Square<D>) -> Square<D> {
    let determinant = determinant(m);
    array_of(|i| {
        array_of(|j| match D {
            1 => determinant.recip(),
            2 if i == j => m[1 - i][1 - j] / determinant,
            2 => -m[i][j] / determinant,
            _ => Interval::ENTIRE,
        })
    })
}

fn dot(a: &Basis, b: &Basis) -> Interval {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn add(a: &Basis, b: &Basis) -> Basis {
    array_of(|i| a[i] + b[i])
}

fn negative(a: &Basis) -> Basis {
    a.each(|x| -x)
}

fn apply(m: &BasisMatrix, v: &Basis) -> Basis {
    array_of(|i| dot(&m[i], v))
}

fn add_outer(m: &mut BasisMatrix, a: &Basis, b: &Basis, basis: usize) {
    for i in 0..basis {
        for j in 0..basis {
            m[i][j] = m[i][j] + a[i] * b[j];
        }
    }
}

/// Inverse of the leading block, by cofactors.
fn inverse_of_basis(m: &BasisMatrix, basis: usize) -> BasisMatrix {
    let mut result = [[Interval::ZERO; 3]; 3];
    // Padded with ones on the diagonal, so that one formula holds for all sizes.
    let mut padded = *m;
    for b in basis..3 {
        padded[b][b] = Interval::point(1.0);
    }
    let minor = |i: usize, j: usize| {
        let (a, b) = ((i + 1) % 3, (i + 2) % 3);
        let (c, d) = ((j + 1) % 3, (j + 2) % 3);
        padded[a][c] * padded[b][d] - padded[a][d] * padded[b][c]
    };
    let determinant = sum((0..3).map(|j| padded[0][j] * minor(0, j)));
    for i in 0..basis {
        for j in 0..basis {
            result[i][j] = minor(j, i) / determinant;
        }
    }
    result
}
