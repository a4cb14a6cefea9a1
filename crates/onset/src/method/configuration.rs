//! Quadrature points, neighbors and shape functions in a homogeneous state.

use super::{Background, Frame, Method, MethodError, SupportSize};
use crate::approximation::{Approximation, Order, ShapeFunctions};
use crate::kinematics::DeformationGradient;
use crate::lattice::{Ball, Reduced, determinant, inverse_of};
use crate::quadrature::QuadraturePoint;
use nalgebra::{SMatrix, SVector};

/// Quadrature point in a homogeneous state, with its neighbors, its shape functions and its deformation gradient.
#[derive(Clone, Debug)]
pub struct ConfiguredPoint<const D: usize> {
    /// Reference volume `V_q`; length^D.
    pub volume: f64,
    /// Whether the point is a particle.
    pub is_node: bool,
    /// Second moments of the cell of the point, if strain is expanded over it.
    pub second_moments: Option<SMatrix<f64, D, D>>,
    /// Lattice coordinates of the neighbors, relative to the cell of the point.
    pub cells: Vec<[i32; D]>,
    /// Lattice coordinates of the point in its cell.
    pub place: SVector<f64, D>,
    /// Shape functions of the neighbors. Derivatives are in the coordinates of the kernel: material for Lagrangian, spatial for Eulerian kernels.
    pub shape: ShapeFunctions<D>,
    /// Deformation gradient that the point carries.
    pub deformation: DeformationGradient,
}

/// All quadrature points of one cell in a homogeneous state.
#[derive(Clone, Debug)]
pub struct Configuration<const D: usize> {
    /// Quadrature points of the cell.
    pub points: Vec<ConfiguredPoint<D>>,
    /// Short basis of the lattice in the coordinates of the kernels.
    pub(crate) basis: Reduced<D>,
}

/// Lattice and support in the coordinates of the kernels.
pub(crate) struct Layout<const D: usize> {
    /// Primitive vectors of the lattice in the coordinates of the kernels, as columns.
    pub(crate) vectors: SMatrix<f64, D, D>,
    pub(crate) radius: f64,
    /// Metric of the support: distances are `|metric x|`.
    pub(crate) metric: SMatrix<f64, D, D>,
}

impl<const D: usize> Layout<D> {
    /// Returns this layout with a larger support.
    pub(crate) fn enlarged(&self, factor: f64) -> Self {
        Self {
            radius: factor * self.radius,
            ..*self
        }
    }
}

impl<const D: usize> Method<D> {
    /// Returns the quadrature points with their neighbors and shape functions in a state.
    ///
    /// # Errors
    /// [`MethodError`] if the support is too small or too large, if `F` does not have the dimension of the discretization, or if the interpolated
    /// background is not admissible.
    pub fn configuration(
        &self,
        f: &DeformationGradient,
        order: Order,
    ) -> Result<Configuration<D>, MethodError> {
        if !f.is_block_diagonal::<D>() {
            return Err(MethodError::NotPlanar { dimension: D });
        }
        let layout = self.layout(f);
        let support = support(&layout)?;
        let points = self
            .points
            .iter()
            .map(|point| self.configured(point, &layout, &support, f, order));
        Ok(Configuration {
            points: points.collect::<Result<_, _>>()?,
            basis: *support.basis(),
        })
    }

    /// Returns the configuration with one of each pair of points that inversion exchanges, with the volume of both points.
    ///
    /// If a point has no opposite, all points are returned. The second value is true if only halves are returned.
    pub(crate) fn configuration_of_halves(
        &self,
        f: &DeformationGradient,
        order: Order,
    ) -> Result<(Configuration<D>, bool), MethodError> {
        let Some(halves) = &self.halves else {
            return Ok((self.configuration(f, order)?, false));
        };
        if !f.is_block_diagonal::<D>() {
            return Err(MethodError::NotPlanar { dimension: D });
        }
        let layout = self.layout(f);
        let support = support(&layout)?;
        let points = halves
            .iter()
            .map(|point| self.configured(point, &layout, &support, f, order));
        let configuration = Configuration {
            points: points.collect::<Result<_, _>>()?,
            basis: *support.basis(),
        };
        Ok((configuration, true))
    }

    pub(crate) fn layout(&self, f: &DeformationGradient) -> Layout<D> {
        let radius = self.support_radius();
        let eulerian = self.choices.frame == Frame::Eulerian;
        let support_size = if eulerian {
            self.choices.support_size
        } else {
            SupportSize::Fixed
        };
        let home = self.home_map(f);
        let (radius, metric) = match support_size {
            SupportSize::Fixed => (radius, SMatrix::identity()),
            // The mean stretch within the dimensions of the lattice.
            SupportSize::Scaled => (
                radius * determinant(&f.leading::<D>()).powf(1.0 / D as f64),
                SMatrix::identity(),
            ),
            // Convected with the particles, which do not move on the regular lattice.
            SupportSize::Convected => (radius, inverted(&home)),
        };
        Layout {
            vectors: home * self.lattice().vectors(),
            radius,
            metric,
        }
    }

    fn configured(
        &self,
        point: &QuadraturePoint<D>,
        layout: &Layout<D>,
        support: &Ball<D>,
        f: &DeformationGradient,
        order: Order,
    ) -> Result<ConfiguredPoint<D>, MethodError> {
        let kind = if point.is_node {
            "particle"
        } else {
            "stress point"
        };
        let cells = support.cells(&point.place);
        let mut seen = Vec::with_capacity(cells.len());
        let mut positions = Vec::with_capacity(cells.len());
        let mut weights = Vec::with_capacity(cells.len());
        for cell in cells {
            let fractional = SVector::<f64, D>::from_fn(|i, _| f64::from(cell[i])) - point.place;
            let position = layout.vectors * fractional;
            let kernel = self.choices.kernel;
            if let Some(weight) = kernel.weight(&position, layout.radius, &layout.metric) {
                seen.push(cell);
                positions.push(position);
                weights.push(weight);
            }
        }
        let needed = self.choices.approximation.neighbors_needed(D);
        MethodError::assert_not_crowded(seen.len(), layout.radius)?;
        if seen.len() < needed {
            return Err(MethodError::SupportTooSmall {
                point: kind,
                radius: layout.radius,
                neighbors: seen.len(),
                needed,
                dimension: D,
            });
        }
        let particle_volume = determinant(&layout.vectors).abs();
        let kernel_integral =
            self.choices.kernel.integral::<D>(layout.radius) / determinant(&layout.metric).abs();
        let approximation: Approximation = self.choices.approximation;
        let shape = approximation
            .shape_functions(
                &positions,
                &weights,
                particle_volume / kernel_integral,
                layout.radius,
                order,
            )
            .map_err(|source| MethodError::SingularMoment {
                point: kind,
                neighbors: seen.len(),
                source,
            })?;
        let deformation = self.carried_deformation(f, &positions, &shape)?;
        Ok(ConfiguredPoint {
            volume: point.volume,
            is_node: point.is_node,
            second_moments: point.second_moments,
            cells: seen,
            place: point.place,
            shape,
            deformation,
        })
    }

    /// Deformation gradient that a quadrature point carries.
    fn carried_deformation(
        &self,
        f: &DeformationGradient,
        positions: &[SVector<f64, D>],
        shape: &ShapeFunctions<D>,
    ) -> Result<DeformationGradient, MethodError> {
        if self.choices.background == Background::Imposed {
            return Ok(*f);
        }
        // sum_K y_K (x) grad phi_K is the identity for linearly complete functions.
        let moment: SMatrix<f64, D, D> = positions
            .iter()
            .zip(&shape.gradients)
            .map(|(y, gradient)| y * gradient.transpose())
            .sum();
        let (leading, one) = (f.leading::<D>(), SMatrix::<f64, D, D>::identity());
        let seen = match self.choices.frame {
            Frame::Lagrangian => one + (leading - one) * moment,
            Frame::Eulerian => inverted(&(one - (one - inverted(&leading)) * moment)),
        };
        let seen = *f.with_leading(&seen).components();
        DeformationGradient::new(seen).map_err(MethodError::Background)
    }
}

/// Inverse of a matrix with at most three rows. It is NaN if the matrix is singular, which the checks of deformation gradients and dynamical matrices
/// report.
fn inverted<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    inverse_of(m).unwrap_or_else(|| SMatrix::repeat(f64::NAN))
}

/// Ball of the support in the lattice, in the coordinates of the kernels.
pub(crate) fn support<const D: usize>(layout: &Layout<D>) -> Result<Ball<D>, MethodError> {
    let ball = Ball::new(&(layout.metric * layout.vectors), layout.radius)?;
    MethodError::assert_few(&ball, layout.radius, 1)?;
    Ok(ball)
}
