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

/// A vector as a weight sees it: `q^2 = x . C x` is the squared distance over that of the rim, and the gradient of the weight is along `C x`, with
/// `C = metric^T metric / radius^2`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured<R, const D: usize> {
    /// `C x`; 1/length.
    pub(crate) slant: [R; D],
    /// `q^2`.
    pub(crate) squared: R,
}

/// `C` of [`Measured`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure<const D: usize> {
    components: [[f64; D]; D],
    /// Of a round support `C` is a number.
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
    /// By what the weight measures distances.
    pub(super) fn measure(&self) -> Measure<D> {
        let metric = self.metric / self.radius;
        Measure {
            components: (metric.transpose() * metric).into(),
            is_round: self.metric == SMatrix::<f64, D, D>::identity(),
        }
    }

    /// The weight of what has been measured, without derivatives of another kind: of one vector or of several at once.
    #[inline(always)]
    pub(super) fn weigh<R: Real>(&self, own: &Measured<R, D>) -> Weighed<R, D> {
        let profile = self.kernel.profile_anywhere::<D, R>(own.squared.sqrt());
        let slope = profile.slope_over_q * self.factor;
        Weighed {
            value: profile.value * self.factor,
            gradient: own.slant.each(|along| along * slope),
        }
    }

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

#[cfg(test)]
mod tests {
    use super::MovingWeight;
    use crate::algebra::array_of;
    use crate::kernel::{FormulaKernel, Kernel};
    use crate::real::{LANES, Lanes};
    use nalgebra::SMatrix;

    /// Several vectors from near the center to beyond the rim, of which some are on each side of all the thresholds of the kernels, or all on one.
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
    fn several_weights_at_once_are_those_of_one_at_a_time() {
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
