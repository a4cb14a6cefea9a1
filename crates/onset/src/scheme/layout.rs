//! Weights of particles that move, and how they lie at a homogeneous state.

use crate::algebra::{Each, array_of};
use crate::kernel::Kernel;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Fractional, Particle, determinant};
use crate::method::{MethodError, SupportSize};
use crate::real::Real;
use nalgebra::{DMatrix, SMatrix, SVector};

/// A weight function `factor W(|metric x| / radius)` whose argument may carry derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovingWeight<const D: usize> {
    kernel: Kernel,
    radius: f64,
    metric: SMatrix<f64, D, D>,
    factor: f64,
}

/// A weight with its gradient.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weighed<R, const D: usize> {
    /// `W`.
    pub(crate) value: R,
    /// `W_,j` with respect to the vector from the center to the particle.
    pub(crate) gradient: [R; D],
}

impl<const D: usize> MovingWeight<D> {
    /// The same, multiplied with a number.
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            factor: factor * self.factor,
            ..self
        }
    }

    /// The integral of the weight over space, length^D.
    pub(super) fn integral(&self) -> f64 {
        self.factor * self.kernel.integral::<D>(self.radius) / determinant(&self.metric).abs()
    }

    /// The same with the integral one: a density of probability, 1/length^D.
    pub(super) fn normalized(self) -> Self {
        self.times(self.integral().recip())
    }

    /// The support radius; length.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// A vector as the weight measures it; its support is a ball of these.
    pub(super) fn measured(&self, x: &[f64; D]) -> [f64; D] {
        (self.metric * SVector::from(*x)).into()
    }

    /// The weight at a vector from the center to the particle, and its gradient; zero outside of the support.
    ///
    /// Dual numbers get the value and the first derivatives, the gradient by way of the second derivatives of the weight.
    pub(super) fn at<R: Real>(&self, x: &[R; D]) -> Weighed<R, D> {
        let values = SVector::from(x.map(Real::value));
        let zero = R::constant(0.0);
        let Some(weight) = self.kernel.weight(&values, self.radius, &self.metric) else {
            return Weighed {
                value: zero,
                gradient: [zero; D],
            };
        };
        // The change has the value zero, and derivatives.
        let change = x.each(|component| component - component.value());
        let along = |value: f64, slope: &dyn Fn(usize) -> f64| {
            (0..D).fold(R::constant(value), |sum, j| sum + change[j] * slope(j)) * self.factor
        };
        Weighed {
            value: along(weight.value, &|j| weight.gradient[j]),
            gradient: array_of(|i| along(weight.gradient[i], &|j| weight.hessian[(i, j)])),
        }
    }
}

/// How kernels lie at a homogeneous state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout<const D: usize> {
    /// From reference positions to those between which the kernels measure.
    map: SMatrix<f64, D, D>,
    weight: MovingWeight<D>,
}

impl<const D: usize> Layout<D> {
    /// Kernels of material coordinates.
    pub(super) fn reference(kernel: Kernel, radius: f64) -> Self {
        Self {
            map: SMatrix::identity(),
            weight: MovingWeight {
                kernel,
                radius,
                metric: SMatrix::identity(),
                factor: 1.0,
            },
        }
    }

    /// Kernels of current coordinates, with particles at `F X`.
    ///
    /// # Errors
    /// [`MethodError::NotPlanar`] when `F` is not of the dimension.
    pub(super) fn current(
        kernel: Kernel,
        radius: f64,
        size: SupportSize,
        f: &DeformationGradient,
    ) -> Result<Self, MethodError> {
        assert_planar::<D>(f)?;
        let map = f.leading::<D>();
        let (radius, metric) = match size {
            SupportSize::Fixed => (radius, SMatrix::identity()),
            SupportSize::Scaled => {
                let mean_stretch = determinant(&map).powf(1.0 / D as f64);
                (radius * mean_stretch, SMatrix::identity())
            }
            SupportSize::Convected => (radius, inverted(&map)),
        };
        Ok(Self {
            map,
            weight: MovingWeight {
                kernel,
                radius,
                metric,
                factor: 1.0,
            },
        })
    }

    /// The weight.
    pub(super) fn weight(&self) -> &MovingWeight<D> {
        &self.weight
    }

    /// Volumes here over reference volumes.
    pub(super) fn jacobian(&self) -> f64 {
        determinant(&self.map)
    }

    /// The vector from a place to a particle, both in lattice coordinates, as the kernels see it; length.
    pub(super) fn vector(
        &self,
        crystal: &Crystal<D>,
        place: &Fractional<D>,
        particle: &Particle<D>,
    ) -> [f64; D] {
        let vector = self.map * crystal.lattice().vectors() * (crystal.place(particle) - place);
        vector.into()
    }

    /// The particles in the support about a place, nearest first.
    ///
    /// # Errors
    /// [`MethodError::SupportTooLarge`], or [`MethodError::SupportTooSmall`] when there are fewer than needed.
    pub(super) fn neighbors(
        &self,
        crystal: &Crystal<D>,
        place: &Fractional<D>,
        point: &'static str,
        needed: usize,
    ) -> Result<Vec<Particle<D>>, MethodError> {
        let metric = self.weight.metric * self.map;
        let radius = self.weight.radius;
        let ball = crystal.ball(radius, &metric)?;
        MethodError::assert_few(&ball, radius, crystal.sites().len())?;
        let particles = crystal.within_ball(place, radius, &metric, &ball);
        MethodError::assert_not_crowded(particles.len(), radius)?;
        if particles.len() < needed {
            return Err(MethodError::SupportTooSmall {
                point,
                radius,
                neighbors: particles.len(),
                needed,
                dimension: D,
            });
        }
        Ok(particles)
    }
}

/// Refuses a deformation that couples directions that a discretization has with those that it has not.
pub(super) fn assert_planar<const D: usize>(f: &DeformationGradient) -> Result<(), MethodError> {
    if f.is_block_diagonal::<D>() {
        Ok(())
    } else {
        Err(MethodError::NotPlanar { dimension: D })
    }
}

/// Refuses settings that are not positive and finite.
pub(super) fn assert_positive(settings: &[(&'static str, f64)]) -> Result<(), MethodError> {
    settings
        .iter()
        .try_for_each(|(name, value)| MethodError::positive(name, *value))
}

/// The inverse; not a number where the matrix is singular, which the check of the wave system reports.
fn inverted<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    match DMatrix::from_fn(D, D, |i, j| m[(i, j)]).try_inverse() {
        Some(inverse) => SMatrix::from_fn(|i, j| inverse[(i, j)]),
        None => SMatrix::repeat(f64::NAN),
    }
}
