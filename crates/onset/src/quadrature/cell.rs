//! Quadrature points by their places in the primitive cell: Gauss rules, and user-defined lists.

use super::{QuadratureError, QuadraturePoint};
use crate::algebra::sort_by_value;
use crate::lattice::BravaisLattice;
use nalgebra::SVector;

/// What a quadrature needs to know beside its name.
#[derive(Clone, Debug, PartialEq)]
pub struct CellRule {
    /// The fraction of the cell's volume at the stress points, in place of Voronoi volumes.
    pub stress_point_weight: Option<f64>,
    /// Gauss points per direction.
    pub gauss_points: u32,
    /// For each user-defined point its lattice coordinates and its fraction of the cell's volume, one after the other.
    pub points: Vec<f64>,
}

impl Default for CellRule {
    fn default() -> Self {
        Self {
            stress_point_weight: None,
            gauss_points: 2,
            points: Vec::new(),
        }
    }
}

/// Tolerance of the sum of the fractions of a list.
const SUM: f64 = 1e-9;
/// Distance from a particle, in lattice coordinates, below which a point is the particle.
const SAME_PLACE: f64 = 1e-12;

/// Distances from the middle of the unit interval and weights of the Gauss-Legendre rules, one of each pair of opposite
/// points.
fn rule(points: u32) -> Option<Vec<(f64, f64)>> {
    let root = |x: f64| 0.5 * x.sqrt();
    Some(match points {
        1 => vec![(0.0, 1.0)],
        2 => vec![(root(1.0 / 3.0), 0.5)],
        3 => vec![(0.0, 4.0 / 9.0), (root(0.6), 5.0 / 18.0)],
        4 => {
            let (inner, outer) = (
                3.0 / 7.0 - 1.2_f64.sqrt() * 2.0 / 7.0,
                3.0 / 7.0 + 1.2_f64.sqrt() * 2.0 / 7.0,
            );
            let share = 30.0_f64.sqrt() / 72.0;
            vec![(root(inner), 0.25 + share), (root(outer), 0.25 - share)]
        }
        _ => return None,
    })
}

/// Places and weights of a Gauss-Legendre rule on the unit interval, by increasing place; `None` for other numbers than 1 to 4.
pub(crate) fn gauss_line(points: u32) -> Option<Vec<(f64, f64)>> {
    // Opposite points are exactly opposite: the smaller coordinate is what is left of the larger one.
    let pair = |&(distance, weight): &(f64, f64)| {
        let right = 0.5 + distance;
        [(1.0 - right, weight), (right, weight)]
    };
    let mut line: Vec<(f64, f64)> = rule(points)?.iter().flat_map(pair).collect();
    line.dedup_by_key(|(place, _)| *place);
    sort_by_value(&mut line, |item| item.0);
    Some(line)
}

/// The largest number of Gauss points per direction.
const MOST: u32 = 4;

/// Gauss points of the parallelepiped that the primitive vectors span, with the particles at its corners: `points` in each
/// direction, exact for polynomials up to the degree `2 points - 1` in each lattice coordinate.
///
/// ```
/// use onset::lattice::LatticeKind;
/// use onset::quadrature::gauss_points;
/// let points = gauss_points(&LatticeKind::Chain.lattice::<1>(1.0)?, 2)?;
/// assert!((points[0].place[0] - 0.211_324_865).abs() < 1e-9 && points[1].volume == 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`QuadratureError::GaussPoints`] for other numbers than 1 to 4.
pub fn gauss_points<const D: usize>(
    lattice: &BravaisLattice<D>,
    points: u32,
) -> Result<Vec<QuadraturePoint<D>>, QuadratureError> {
    let line = gauss_line(points).ok_or(QuadratureError::GaussPoints {
        value: points,
        most: MOST,
    })?;
    let side = line.len();
    let point = |n: usize| {
        let along = |i: usize| line[n / side.pow(i as u32) % side];
        let weight: f64 = (0..D).map(|i| along(i).1).product();
        let place = SVector::from_fn(|i, _| along(i).0);
        QuadraturePoint::new(place, weight * lattice.cell_volume())
    };
    Ok((0..side.pow(D as u32)).map(point).collect())
}

/// User-defined points: for each its lattice coordinates and its fraction of the cell's volume. A point at a particle is the
/// particle, and moves as such.
///
/// ```
/// use onset::lattice::LatticeKind;
/// use onset::quadrature::own_points;
/// let lattice = LatticeKind::Square.lattice::<2>(2.0)?;
/// let points = own_points(&lattice, &[1.0, 0.0, 0.25, 0.5, -0.5, 0.75])?;
/// assert!(points[0].is_node && points[0].volume == 1.0);
/// assert_eq!(points[1].place.as_slice(), [0.5, 0.5]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`QuadratureError`] when the list is empty or ends within a point, a weight is not positive, or the weights do not add up
/// to one.
pub fn own_points<const D: usize>(
    lattice: &BravaisLattice<D>,
    list: &[f64],
) -> Result<Vec<QuadraturePoint<D>>, QuadratureError> {
    let each = D + 1;
    if list.is_empty() || !list.len().is_multiple_of(each) {
        return Err(QuadratureError::PointsLength {
            length: list.len(),
            each,
            dimension: D,
        });
    }
    for (n, &value) in list.iter().enumerate() {
        let is_weight = n % each == D;
        if !value.is_finite() || (is_weight && value <= 0.0) {
            return Err(QuadratureError::PointsValue {
                number: n / each + 1,
                what: if is_weight { "weight" } else { "coordinate" },
                value,
            });
        }
    }
    let sum: f64 = list.chunks_exact(each).map(|point| point[D]).sum();
    if (sum - 1.0).abs() > SUM {
        return Err(QuadratureError::PointsSum { sum });
    }
    let point = |numbers: &[f64]| {
        let place = SVector::<f64, D>::from_fn(|i, _| numbers[i] - numbers[i].floor());
        let is_particle = place.map(|x| x - x.round()).amax() <= SAME_PLACE;
        let place = if is_particle { SVector::zeros() } else { place };
        // What rounding left of the sum is shared by all, so that volumes add up to that of the cell.
        QuadraturePoint::new(place, numbers[D] / sum * lattice.cell_volume())
    };
    Ok(list.chunks_exact(each).map(point).collect())
}
