//! Weights of moving particles, and their layout in a homogeneous state.

use crate::algebra::{Each, array_of};
use crate::kernel::Kernel;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Fractional, Particle, determinant};
use crate::method::{MethodError, SupportSize};
use crate::real::Real;
use nalgebra::{DMatrix, SMatrix, SVector};

/// Weight function `factor W(|metric x| / radius)`, whose argument may carry derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovingWeight<const D: usize> {
    kernel: Kernel,
    radius: f64,
    metric: SMatrix<f64, D, D>,
    factor: f64,
}

/// Value and gradient of a weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weighed<R, const D: usize> {
    /// Value of the weight `W`.
    pub(crate) value: R,
    /// Gradient `W_,j` with respect to the vector from the center to the particle.
    pub(crate) gradient: [R; D],
}

/// Vector in the metric of a weight.
///
/// `q^2 = x . C x` is the squared ratio of the distance to the support radius, and the gradient of the weight is along `C x`, with
/// `C = metric^T metric / radius^2`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured<R, const D: usize> {
    /// Direction of the gradient, `C x`; 1/length.
    pub(crate) slant: [R; D],
    /// Squared distance `q^2`, relative to the squared support radius.
    pub(crate) squared: R,
}

/// Metric tensor `C` of [`Measured`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure<const D: usize> {
    components: [[f64; D]; D],
    /// Whether the support is round, so that `C` is a multiple of the identity.
    is_round: bool,
}

impl<const D: usize> Measure<D> {
    #[inline(always)]
    pub(crate) fn of<R: Real>(&self, x: &[R; D]) -> Measured<R, D> {
        let mut slant = x.each(|x| x * self.components[0][0]);
        if !self.is_round {
            slant = [R::constant(0.0); D];
            for i in 0..D {
                for j in 0..D {
                    slant[i] = slant[i] + x[j] * self.components[i][j];
                }
            }
        }
        let mut squared = x[0] * slant[0];
        for i in 1..D {
            squared = squared + x[i] * slant[i];
        }
        Measured { slant, squared }
    }
}

impl<const D: usize> MovingWeight<D> {
    /// Metric tensor of the weight.
    pub(super) fn measure(&self) -> Measure<D> {
        let metric = self.metric / self.radius;
        Measure {
            components: (metric.transpose() * metric).into(),
            is_round: self.metric == SMatrix::<f64, D, D>::identity(),
        }
    }

    /// Returns the weight of one measured vector or of several in lanes. Derivatives carried by the vectors are ignored.
    #[inline(always)]
    pub(super) fn weigh<R: Real>(&self, own: &Measured<R, D>) -> Weighed<R, D> {
        let profile = self.kernel.profile_anywhere::<D, R>(own.squared.sqrt());
        let slope = profile.slope_over_q * self.factor;
        Weighed {
            value: profile.value * self.factor,
            gradient: own.slant.each(|along| along * slope),
        }
    }

    /// Returns this weight multiplied by a number.
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            factor: factor * self.factor,
            ..self
        }
    }

    /// Integral of the weight over space; length^D.
    pub(super) fn integral(&self) -> f64 {
        self.factor * self.kernel.integral::<D>(self.radius) / determinant(&self.metric).abs()
    }

    /// Returns this weight scaled to unit integral; 1/length^D.
    pub(super) fn normalized(self) -> Self {
        self.times(self.integral().recip())
    }

    /// Support radius of the weight; length.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// Maps a vector to the coordinates of the weight, in which the support is a ball.
    pub(super) fn measured(&self, x: &[f64; D]) -> [f64; D] {
        (self.metric * SVector::from(*x)).into()
    }

    /// Weight and its gradient at the vector from the center to the particle; zero outside of the support.
    ///
    /// Dual numbers carry the value and the first derivatives. The derivatives of the gradient use the second derivatives of the weight.
    pub(super) fn at<R: Real>(&self, x: &[R; D]) -> Weighed<R, D> {
        let values = SVector::from(x.map(Real::value));
        let zero = R::constant(0.0);
        let Some(weight) = self.kernel.weight(&values, self.radius, &self.metric) else {
            return Weighed {
                value: zero,
                gradient: [zero; D],
            };
        };
        // The change has the value zero and carries the derivatives.
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

/// Positions and weights of the kernels in a homogeneous state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout<const D: usize> {
    /// Maps reference positions to the positions in which the kernels measure distances.
    map: SMatrix<f64, D, D>,
    weight: MovingWeight<D>,
}

impl<const D: usize> Layout<D> {
    /// Layout for kernels in material coordinates.
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

    /// Layout for kernels in current coordinates, with particles at `F X`.
    ///
    /// # Errors
    /// [`MethodError::NotPlanar`] if `F` couples the lattice to the remaining directions.
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

    /// Weight function of the layout.
    pub(super) fn weight(&self) -> &MovingWeight<D> {
        &self.weight
    }

    /// Ratio of the volumes in the layout to the reference volumes.
    pub(super) fn jacobian(&self) -> f64 {
        determinant(&self.map)
    }

    /// Vector in the layout from a place to a particle, both in lattice coordinates; length.
    pub(super) fn vector(
        &self,
        crystal: &Crystal<D>,
        place: &Fractional<D>,
        particle: &Particle<D>,
    ) -> [f64; D] {
        let vector = self.map * crystal.lattice().vectors() * (crystal.place(particle) - place);
        vector.into()
    }

    /// Particles in the support around a place, nearest first.
    ///
    /// # Errors
    /// [`MethodError::SupportTooLarge`], or [`MethodError::SupportTooSmall`] if there are fewer particles than needed.
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
        // In a block each site is examined once.
        if !crystal.is_block() {
            MethodError::assert_few(&ball, radius, crystal.sites().len())?;
        }
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

/// Rejects a deformation that couples the directions of the discretization to the remaining directions.
pub(super) fn assert_planar<const D: usize>(f: &DeformationGradient) -> Result<(), MethodError> {
    if f.is_block_diagonal::<D>() {
        Ok(())
    } else {
        Err(MethodError::NotPlanar { dimension: D })
    }
}

/// Rejects settings that are not positive and finite.
pub(super) fn assert_positive(settings: &[(&'static str, f64)]) -> Result<(), MethodError> {
    settings
        .iter()
        .try_for_each(|(name, value)| MethodError::positive(name, *value))
}

/// Inverse of a matrix; NaN if it is singular, which the check of the wave system reports.
fn inverted<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    match DMatrix::from_fn(D, D, |i, j| m[(i, j)]).try_inverse() {
        Some(inverse) => SMatrix::from_fn(|i, j| inverse[(i, j)]),
        None => SMatrix::repeat(f64::NAN),
    }
}

#[cfg(test)]
mod tests {
    use super::MovingWeight;
    use crate::algebra::array_of;
    use crate::kernel::{FormulaKernel, Kernel};
    use crate::real::{LANES, Lanes};
    use nalgebra::SMatrix;

    /// Tests several vectors from the center to beyond the rim, with vectors on both sides of the thresholds of the kernels, or all on one side.
    fn assert_weights<const D: usize>(kernel: Kernel) {
        let mut sheared = SMatrix::<f64, D, D>::identity() * 1.1;
        sheared[(0, D - 1)] += 0.2;
        for metric in [SMatrix::identity(), sheared] {
            let weight = MovingWeight {
                kernel,
                radius: 2.3,
                metric,
                factor: 0.7,
            };
            for (first, apart) in [
                (0.05, 0.33),
                (0.1, 0.01),
                (1.3, 0.1),
                (2.0, 0.1),
                (5.0, 0.5),
            ] {
                let own = |lane: usize| -> [f64; D] {
                    let distance = first + apart * lane as f64;
                    array_of(|i| distance * [0.8, -0.6, 0.3][i])
                };
                let x = array_of(|i| Lanes(array_of(|lane| own(lane)[i])));
                let all = weight.weigh(&weight.measure().of(&x));
                for lane in 0..LANES {
                    let one = weight.at(&own(lane));
                    let near = |a: f64, b: f64| (a - b).abs() < 1e-14;
                    assert!(near(all.value.0[lane], one.value), "{kernel}, {lane}");
                    for (all, one) in all.gradient.iter().zip(one.gradient) {
                        assert!(near(all.0[lane], one), "{kernel}, {lane}");
                    }
                    if own(lane).iter().map(|x| x * x).sum::<f64>() > 9.0 {
                        assert_eq!(all.value.0[lane], 0.0);
                        assert!(all.gradient.iter().all(|own| own.0[lane] == 0.0));
                    }
                }
            }
        }
    }

    #[test]
    fn weights_of_several_vectors_equal_weights_of_single_vectors() {
        let formulas = [
            "(1 - q)^3*(1 + 3*q)",
            "(1 - q)^3",
            "max(1 - 2*q, 0)^3 + (1 - q)^3",
        ];
        let formula = |text| Kernel::Formula(FormulaKernel::parse(text).expect("a kernel"));
        for kernel in Kernel::ALL.into_iter().chain(formulas.map(formula)) {
            assert_weights::<1>(kernel);
            assert_weights::<2>(kernel);
            assert_weights::<3>(kernel);
        }
    }
}
