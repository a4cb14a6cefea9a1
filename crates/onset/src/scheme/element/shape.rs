//! Shape functions of linear and quadratic elements in one, two and three dimensions.

use crate::algebra::Each;
use crate::quadrature::gauss_line;
use nalgebra::{DMatrix, SMatrix, SVector};

/// Shape of an element, simplex or parallelepiped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementShape {
    /// `D + 1` nodes with linear functions: a bar, a triangle or a tetrahedron.
    Simplex,
    /// `2^D` nodes with products of linear functions: a bar, a quadrilateral or a brick. Node `n` has the reference coordinate `+1` along axis `i` if
    /// bit `i` of `n` is set, otherwise `-1`.
    Multilinear,
    /// The nodes of a simplex and the middles of its edges, with quadratic functions: a bar of 3, a triangle of 6 or a tetrahedron of 10 nodes.
    QuadraticSimplex,
    /// The nodes of a multilinear element and the middles of its edges, with the functions of the serendipity family: a bar of 3, a quadrilateral of 8 or
    /// a brick of 20 nodes.
    Serendipity,
}

/// An integration point of an element.
#[derive(Clone, Debug)]
pub(super) struct Sample<const D: usize> {
    /// Shape functions `N_a` at the point.
    pub(super) values: Vec<f64>,
    /// Gradients `dN_a/dX` at the point; 1/length.
    pub(super) gradients: Vec<SVector<f64, D>>,
    /// Part of the element's volume, negative if the element is inverted; length^D.
    pub(super) volume: f64,
}

impl ElementShape {
    /// Number of nodes of an element in `D` dimensions.
    pub fn nodes<const D: usize>(self) -> usize {
        match self {
            Self::Simplex => D + 1,
            Self::Multilinear => 1 << D,
            Self::QuadraticSimplex => (D + 1) * (D + 2) / 2,
            Self::Serendipity => (1 << D) + (D << (D - 1)),
        }
    }

    /// Edges of the shape, by the numbers of their corners; the nodes in the middles have this order.
    pub(super) fn edges<const D: usize>(self) -> Vec<[usize; 2]> {
        match self {
            Self::Simplex | Self::QuadraticSimplex => {
                let from = |a: usize| (a + 1..=D).map(move |b| [a, b]);
                (0..=D).flat_map(from).collect()
            }
            Self::Multilinear | Self::Serendipity => {
                let along = |axis: usize| {
                    let starts = (0..1_usize << D).filter(move |n| n >> axis & 1 == 0);
                    starts.map(move |n| [n, n | 1 << axis])
                };
                (0..D).flat_map(along).collect()
            }
        }
    }

    /// Points of full integration: the centroid of a simplex, or a rule of the second degree for quadratic simplices. Gauss's rule has two points along
    /// each axis of a multilinear element and three along each axis of a serendipity element. `None` if the element has no volume.
    pub(super) fn samples<const D: usize>(
        self,
        nodes: &[SVector<f64, D>],
    ) -> Option<Vec<Sample<D>>> {
        match self {
            Self::Simplex => {
                let factorial: f64 = (1..=D).map(|n| n as f64).product();
                let value = 1.0 / (D + 1) as f64;
                // Barycentric coordinates. The coordinate of node 0 is one minus the sum of the others.
                let slopes = (0..=D).map(|a| SVector::from_fn(|i, _| slope(a, i)));
                let slopes: Vec<SVector<f64, D>> = slopes.collect();
                let sample = mapped(nodes, vec![value; D + 1], &slopes, 1.0 / factorial)?;
                Some(vec![sample])
            }
            Self::Multilinear => {
                let place = 1.0 / 3.0_f64.sqrt();
                let point = |n: usize| SVector::<f64, D>::from_fn(|i, _| place * sign(n, i));
                (0..1 << D).map(|n| multilinear(nodes, &point(n))).collect()
            }
            Self::QuadraticSimplex => {
                let count = (D + 1) as f64;
                let other = (count + 1.0 - (count + 1.0).sqrt()) / (count * (count + 1.0));
                let point = |n: usize| {
                    let own = 1.0 - D as f64 * other;
                    SVector::from_fn(|i, _| if n == i + 1 { own } else { other })
                };
                let factorial: f64 = (1..=D).map(|n| n as f64).product();
                let weight = 1.0 / (factorial * count);
                (0..=D)
                    .map(|n| quadratic_simplex(nodes, &point(n), weight))
                    .collect()
            }
            Self::Serendipity => {
                let points = gauss_cube::<D>(3).into_iter();
                points
                    .map(|(place, weight)| serendipity(nodes, &place, weight))
                    .collect()
            }
        }
    }

    /// Integrals `int N_a N_b dV` over an element with the given points of full integration; length^D.
    pub(super) fn products<const D: usize>(
        self,
        nodes: &[SVector<f64, D>],
        samples: &[Sample<D>],
    ) -> DMatrix<f64> {
        // Products of quadratic functions have the fourth degree, beyond the points of full integration of a simplex.
        let finer = match self {
            Self::QuadraticSimplex => collapsed(nodes),
            _ => None,
        };
        let samples = finer.as_deref().unwrap_or(samples);
        let nodes = self.nodes::<D>();
        let volume: f64 = samples.iter().map(|sample| sample.volume.abs()).sum();
        match self {
            Self::Simplex => DMatrix::from_fn(nodes, nodes, |a, b| {
                let times = if a == b { 2.0 } else { 1.0 };
                times * volume / ((D + 1) * (D + 2)) as f64
            }),
            _ => DMatrix::from_fn(nodes, nodes, |a, b| {
                let product = |s: &Sample<D>| s.values[a] * s.values[b] * s.volume.abs();
                samples.iter().map(product).sum()
            }),
        }
    }
}

/// Derivative of barycentric coordinate `a` along axis `i`.
fn slope(a: usize, i: usize) -> f64 {
    match a {
        0 => -1.0,
        _ => f64::from(u8::from(a == i + 1)),
    }
}

/// Reference coordinate of node `n` along axis `i`.
pub(super) fn sign(n: usize, i: usize) -> f64 {
    if n >> i & 1 == 1 { 1.0 } else { -1.0 }
}

/// Evaluates `N_n = prod_i (1 + xi_i sign_i) / 2` at a point of the reference cube, with the weight 1 of the volume `2^D`.
fn multilinear<const D: usize>(
    nodes: &[SVector<f64, D>],
    point: &SVector<f64, D>,
) -> Option<Sample<D>> {
    let factor = |n: usize, i: usize| 0.5 * (1.0 + point[i] * sign(n, i));
    let others = |n: usize, but: usize| -> f64 {
        let along = (0..D).filter(|i| *i != but);
        along.map(|i| factor(n, i)).product()
    };
    let values = (0..nodes.len()).map(|n| others(n, D)).collect();
    let slope = |n: usize| SVector::from_fn(|i, _| 0.5 * sign(n, i) * others(n, i));
    let slopes: Vec<SVector<f64, D>> = (0..nodes.len()).map(slope).collect();
    mapped(nodes, values, &slopes, 1.0)
}

/// Gauss points of the reference cube from -1 to 1, with weights that add up to its volume.
fn gauss_cube<const D: usize>(points: u32) -> Vec<(SVector<f64, D>, f64)> {
    let line = gauss_line(points).unwrap_or_default();
    let place = |n: usize| {
        let along: [(f64, f64); D] =
            std::array::from_fn(|i| line[n / line.len().pow(i as u32) % line.len()]);
        let weight = along.iter().map(|(_, weight)| 2.0 * weight).product();
        (SVector::from(along.each(|(x, _)| 2.0 * x - 1.0)), weight)
    };
    (0..line.len().pow(D as u32)).map(place).collect()
}

/// Points of a quadratic simplex at which polynomials of the fourth degree are integrated exactly: Gauss points of a cube that collapses to a simplex.
fn collapsed<const D: usize>(nodes: &[SVector<f64, D>]) -> Option<Vec<Sample<D>>> {
    let point = |(place, weight): (SVector<f64, D>, f64)| {
        let (mut left, mut weight) = (1.0, weight / f64::from(1 << D));
        let place = place.map(|x| {
            let own = left * 0.5 * (1.0 + x);
            weight *= left;
            left -= own;
            own
        });
        quadratic_simplex(nodes, &place, weight)
    };
    gauss_cube::<D>(4).into_iter().map(point).collect()
}

/// Evaluates the functions of a quadratic simplex at a point given by its barycentric coordinates except the first coordinate.
fn quadratic_simplex<const D: usize>(
    nodes: &[SVector<f64, D>],
    point: &SVector<f64, D>,
    weight: f64,
) -> Option<Sample<D>> {
    let coordinate = |a: usize| match a {
        0 => 1.0 - point.sum(),
        _ => point[a - 1],
    };
    let gradient = |a: usize| SVector::<f64, D>::from_fn(|i, _| slope(a, i));
    let corner = |a: usize| {
        let own = coordinate(a);
        (own * (2.0 * own - 1.0), gradient(a) * (4.0 * own - 1.0))
    };
    let middle = |[a, b]: [usize; 2]| {
        let (own, other) = (coordinate(a), coordinate(b));
        (
            4.0 * own * other,
            (gradient(a) * other + gradient(b) * own) * 4.0,
        )
    };
    let middles = ElementShape::QuadraticSimplex.edges::<D>().into_iter();
    let (values, slopes): (Vec<f64>, Vec<_>) =
        (0..=D).map(corner).chain(middles.map(middle)).unzip();
    mapped(nodes, values, &slopes, weight)
}

/// Evaluates the functions of a serendipity element at a point of the reference cube: `2^-D prod_i (1 + s_i xi_i) (sum_i s_i xi_i + 1 - D)` at the
/// corners and `2^(1-D) (1 - xi_a^2) prod_(i != a) (1 + s_i xi_i)` in the middles of the edges along the axis `a`.
fn serendipity<const D: usize>(
    nodes: &[SVector<f64, D>],
    point: &SVector<f64, D>,
    weight: f64,
) -> Option<Sample<D>> {
    let factor = |n: usize, i: usize| 0.5 * (1.0 + point[i] * sign(n, i));
    let others = |n: usize, but: [usize; 2]| -> f64 {
        let along = (0..D).filter(|i| !but.contains(i));
        along.map(|i| factor(n, i)).product()
    };
    let corner = |n: usize| {
        let all = others(n, [D, D]);
        let sum = (0..D).fold(1.0 - D as f64, |sum, i| sum + point[i] * sign(n, i));
        let slope = SVector::from_fn(|i, _| sign(n, i) * (0.5 * others(n, [i, D]) * sum + all));
        (all * sum, slope)
    };
    let middle = |[n, end]: [usize; 2]| {
        let axis = (n ^ end).trailing_zeros() as usize;
        let bubble = 1.0 - point[axis] * point[axis];
        let slope = SVector::from_fn(|i, _| match i == axis {
            true => -2.0 * point[axis] * others(n, [axis, D]),
            false => bubble * 0.5 * sign(n, i) * others(n, [axis, i]),
        });
        (bubble * others(n, [axis, D]), slope)
    };
    let middles = ElementShape::Serendipity.edges::<D>().into_iter();
    let (values, slopes): (Vec<f64>, Vec<_>) =
        (0..1 << D).map(corner).chain(middles.map(middle)).unzip();
    mapped(nodes, values, &slopes, weight)
}

/// Maps functions, slopes and weight from reference coordinates to the element.
fn mapped<const D: usize>(
    nodes: &[SVector<f64, D>],
    values: Vec<f64>,
    slopes: &[SVector<f64, D>],
    weight: f64,
) -> Option<Sample<D>> {
    let jacobian: SMatrix<f64, D, D> = nodes
        .iter()
        .zip(slopes)
        .map(|(x, slope)| x * slope.transpose())
        .sum();
    let jacobian = DMatrix::from_fn(D, D, |i, j| jacobian[(i, j)]);
    let volume = weight * jacobian.determinant();
    let inverse = jacobian.try_inverse()?;
    // By the chain rule dN/dX_j = dN/dxi_i dxi_i/dX_j.
    let gradient = |slope: &SVector<f64, D>| {
        SVector::from_fn(|j, _| (0..D).map(|i| slope[i] * inverse[(i, j)]).sum())
    };
    Some(Sample {
        values,
        gradients: slopes.iter().map(gradient).collect(),
        volume,
    })
}
