//! Quadrature points by their positions in the primitive cell: Gauss rules and user-defined lists.

use super::{QuadratureError, QuadraturePoint};
use crate::algebra::sort_by_value;
use crate::lattice::BravaisLattice;
use nalgebra::SVector;

/// Parameters of the quadrature rules.
#[derive(Clone, Debug, PartialEq)]
pub struct CellRule {
    /// Fraction of the cell's volume at the stress points, in place of Voronoi volumes; `None` for Voronoi volumes.
    pub stress_point_weight: Option<f64>,
    /// Number of Gauss points per direction.
    pub gauss_points: u32,
    /// User-defined points: for each point, its lattice coordinates and its fraction of the cell's volume.
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

/// Tolerance of the sum of the fractions in a list.
const SUM: f64 = 1e-9;
/// Distance in lattice coordinates within which a point coincides with a particle.
const PARTICLE_TOLERANCE: f64 = 1e-12;

/// Gauss-Legendre rules on the unit interval: distances from the center and weights, one of each pair of opposite points.
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

/// Points and weights of a Gauss-Legendre rule on the unit interval, by increasing position; `None` for numbers other than 1 to 4.
pub(crate) fn gauss_line(points: u32) -> Option<Vec<(f64, f64)>> {
    // Opposite points are exactly opposite: the smaller coordinate is one minus the larger one.
    let pair = |&(distance, weight): &(f64, f64)| {
        let right = 0.5 + distance;
        [(1.0 - right, weight), (right, weight)]
    };
    let mut line: Vec<(f64, f64)> = rule(points)?.iter().flat_map(pair).collect();
    line.dedup_by_key(|(place, _)| *place);
    sort_by_value(&mut line, |item| item.0);
    Some(line)
}

/// Largest number of Gauss points per direction.
const MAXIMUM_GAUSS_POINTS: u32 = 4;

/// Returns the Gauss points of the parallelepiped spanned by the primitive vectors, with the particles at its corners.
///
/// With `points` in each direction the rule is exact for polynomials up to the degree `2 points - 1` in each lattice coordinate.
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
/// [`QuadratureError::GaussPoints`] for numbers other than 1 to 4.
pub fn gauss_points<const D: usize>(
    lattice: &BravaisLattice<D>,
    points: u32,
) -> Result<Vec<QuadraturePoint<D>>, QuadratureError> {
    let line = gauss_line(points).ok_or(QuadratureError::GaussPoints {
        value: points,
        most: MAXIMUM_GAUSS_POINTS,
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

/// Returns user-defined points from a list of their lattice coordinates and fractions of the cell's volume. A point at a particle is identified with
/// the particle and moves with it.
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
/// [`QuadratureError`] if the list is empty or ends within a point, if a weight is not positive, or if the weights do not add up to one.
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
        let is_particle = place.map(|x| x - x.round()).amax() <= PARTICLE_TOLERANCE;
        let place = if is_particle { SVector::zeros() } else { place };
        // The rounding error of the sum is distributed over all points, so that their volumes add up to the cell volume.
        QuadraturePoint::new(place, numbers[D] / sum * lattice.cell_volume())
    };
    Ok(list.chunks_exact(each).map(point).collect())
}
