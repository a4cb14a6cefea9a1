//! Shape functions of linear elements in one, two and three dimensions.

use nalgebra::{DMatrix, SMatrix, SVector};

/// Shape of an element, simplex or parallelepiped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementShape {
    /// `D + 1` nodes with linear functions: a bar, a triangle or a tetrahedron.
    Simplex,
    /// `2^D` nodes with products of linear functions: a bar, a quadrilateral or a brick. Node `n` has the reference coordinate `+1` along axis `i` if
    /// bit `i` of `n` is set, otherwise `-1`.
    Multilinear,
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
        }
    }

    /// Points of full integration: the centroid of a simplex, Gauss's two-point rule along each axis of a multilinear element. `None` if the element
    /// has no volume.
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
        }
    }

    /// Integrals `int N_a N_b dV` over an element; length^D.
    pub(super) fn products<const D: usize>(self, samples: &[Sample<D>]) -> DMatrix<f64> {
        let nodes = self.nodes::<D>();
        let volume: f64 = samples.iter().map(|sample| sample.volume.abs()).sum();
        match self {
            Self::Simplex => DMatrix::from_fn(nodes, nodes, |a, b| {
                let times = if a == b { 2.0 } else { 1.0 };
                times * volume / ((D + 1) * (D + 2)) as f64
            }),
            Self::Multilinear => DMatrix::from_fn(nodes, nodes, |a, b| {
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
