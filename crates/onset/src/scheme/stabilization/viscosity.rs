//! Monaghan's artificial viscosity between pairs of particles.

use super::super::layout::MovingWeight;
use super::super::{Interaction, Motion};
use super::assert_coefficients;
use crate::algebra::{Each, array_of};
use crate::continuum::Stiffness;
use crate::kernel::Kernel;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;

/// Condition under which the viscosity acts, and the lengths that it uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ViscositySwitch {
    /// The viscosity always acts, for approaching and for receding particles.
    Always,
    /// The viscosity always acts, with half of its strength. The original acts only on approaching particles and has no derivative at zero velocity;
    /// half of its strength is the mean over the two halves of an oscillation.
    Averaged,
    /// Form of LAMMPS' SMD: the viscosity always acts, with the whole support radius as `h` and `mu = h v_IJ.x_IJ / (|x_IJ| + 0.1 h)^2`.
    ///
    /// With kernels in material coordinates the bond direction is `x / (|x| + 0.01 h)`, and the quadratic term is repulsive for approaching and
    /// receding particles. With kernels in current coordinates the quadratic term is absent.
    ///
    /// Source: Ganzenmueller, Smooth Mach Dynamics (2015); LAMMPS, `pair_smd_tlsph.cpp` and `pair_smd_ulsph.cpp`.
    Smd,
}

/// Monaghan's artificial viscosity: the force `-m_I m_J Pi_IJ grad W_IJ` on particle `I`.
///
/// `Pi = (-alpha c mu + beta |mu| mu_-) / rho`, `mu = h v_IJ.x_IJ / (|x_IJ|^2 + 0.01 h^2)`. `rho` is the mean density of the two particles in the
/// homogeneous state, `c` the largest speed of sound of the material in the reference state, and `h` the smoothing length of the kernel,
/// [`Kernel::nominal_smoothing_length`].
///
/// At small velocities the quadratic term vanishes, and the damping of a linear dashpot along each bond remains.
///
/// Source: Monaghan and Gingold, J. Comput. Phys. 52 (1983) 374.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct ArtificialViscosity {
    /// Linear coefficient `alpha`; dimensionless.
    pub alpha: f64,
    /// Quadratic coefficient `beta`, dimensionless. It affects the forces on moving particles, not plane waves.
    pub beta: f64,
    /// Condition under which the viscosity acts.
    pub switch: ViscositySwitch,
}

impl Default for ArtificialViscosity {
    fn default() -> Self {
        Self {
            alpha: 1.0,
            beta: 2.0,
            switch: ViscositySwitch::Averaged,
        }
    }
}

impl ArtificialViscosity {
    /// Rejects negative or infinite coefficients.
    pub(in super::super) fn assert_admissible(&self) -> Result<(), MethodError> {
        assert_coefficients(&[("viscosity", self.alpha), ("viscosity.beta", self.beta)])
    }
}

#[derive(Clone, Copy, Debug)]
pub(in super::super) enum Slope<const D: usize> {
    /// Gradient of a kernel in current coordinates.
    Moving(MovingWeight<D>),
    /// Slope `dW/dR` of a kernel in material coordinates, along the current bond.
    Fixed(f64),
}

impl<const D: usize> Slope<D> {
    /// Returns the gradient with respect to the end of a bond `x`.
    fn at<R: Real>(&self, x: &[R; D], squared: R) -> [R; D] {
        match self {
            Self::Moving(weight) => weight.at(x).gradient,
            Self::Fixed(slope) => {
                let over_length = squared.sqrt().recip() * *slope;
                x.each(|component| component * over_length)
            }
        }
    }
}

/// Viscous force between two particles as a function of positions and velocities.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Dashpot {
    /// Fraction of the strength: 1, or 1/2 if the viscosity acts half of the time.
    share: f64,
    /// Linear coefficient `alpha c`; length/time.
    linear: f64,
    /// Quadratic coefficient `beta`; dimensionless.
    quadratic: f64,
    /// Length `h` of the viscosity.
    length: f64,
    is_of_smd: bool,
}

impl Dashpot {
    /// Builds the dashpot for a material.
    /// # Errors
    /// [`MethodError`] if the material has no stiffness in the reference state.
    pub(in super::super) fn new<const D: usize>(
        viscosity: &ArtificialViscosity,
        material: &dyn Hyperelastic,
        scales: &ViscousScales,
    ) -> Result<Self, MethodError> {
        let undeformed = Stiffness::<D>::at(material, &DeformationGradient::identity())?;
        let speed = (undeformed.maximum_eigenvalue() / scales.density).sqrt();
        let (share, length) = match viscosity.switch {
            ViscositySwitch::Always => (1.0, scales.kernel.nominal_smoothing_length(scales.radius)),
            ViscositySwitch::Averaged => {
                (0.5, scales.kernel.nominal_smoothing_length(scales.radius))
            }
            ViscositySwitch::Smd => (1.0, scales.radius),
        };
        Ok(Self {
            share,
            linear: viscosity.alpha * speed,
            quadratic: viscosity.beta,
            length,
            is_of_smd: viscosity.switch == ViscositySwitch::Smd,
        })
    }

    /// Factor `m_I m_J / rho` with the mean density of the two particles, halved if the viscosity acts half of the time.
    pub(in super::super) fn factor<R: Real>(&self, masses: [R; 2], densities: [R; 2]) -> R {
        let density = (densities[0] + densities[1]) * 0.5;
        masses[0] * self.share * masses[1] / density
    }

    /// Returns `rho Pi` from the squared length of the bond and `v.x`.
    fn pressure<R: Real>(&self, squared: R, rate: R, quadratic: f64) -> R {
        let h = self.length;
        if self.is_of_smd {
            let length = squared.sqrt() + 0.1 * h;
            let mu = rate * h / (length * length);
            return mu * (mu * quadratic - self.linear);
        }
        let mu = rate * h / (squared + 0.01 * h * h);
        let size = mu.switch(0.0, || -mu, || mu);
        -mu * (size * quadratic + self.linear)
    }

    /// Returns the force on the first particle divided by `m_I m_J / rho`, from the vector to the other particle and the difference of the
    /// velocities.
    pub(in super::super) fn on_first<R: Real, const D: usize>(
        &self,
        x: &[R; D],
        v: &[R; D],
        slope: &Slope<D>,
    ) -> [R; D] {
        let squared = dot(x, x);
        let gradient = slope.at(x, squared);
        let Slope::Fixed(_) = slope else {
            return self.along(x, v, &gradient);
        };
        let pressure = self.pressure(squared, dot(x, v), self.quadratic);
        if !self.is_of_smd {
            return gradient.each(|slope| slope * pressure);
        }
        // Direction of the gradient in the code.
        let length = squared.sqrt();
        let shorter = length / (length + 0.01 * self.length);
        gradient.each(|slope| slope * shorter * pressure)
    }

    /// Like [`Self::on_first`] for a kernel in current coordinates. `gradient` is taken with respect to the end of the bond; the gradient with
    /// respect to the first particle has the opposite sign.
    #[inline(always)]
    pub(in super::super) fn along<R: Real, const D: usize>(
        &self,
        x: &[R; D],
        v: &[R; D],
        gradient: &[R; D],
    ) -> [R; D] {
        let quadratic = if self.is_of_smd { 0.0 } else { self.quadratic };
        let pressure = self.pressure(dot(x, x), dot(x, v), quadratic);
        gradient.each(|slope| slope * pressure)
    }
}

fn dot<R: Real, const D: usize>(a: &[R; D], b: &[R; D]) -> R {
    let both = a.iter().zip(b);
    both.fold(R::constant(0.0), |sum, (a, b)| sum + *a * *b)
}

/// One of the two halves of the viscous force between two particles.
pub(in super::super) struct ViscousBond<const D: usize> {
    particles: [Particle<D>; 2],
    /// Vector `x_J - x_I` in the homogeneous state.
    vector: [f64; D],
    slope: Slope<D>,
    dashpot: Dashpot,
    /// Half of the factor [`Dashpot::factor`].
    factor: f64,
}

impl<const D: usize> Interaction<D> for ViscousBond<D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let difference = |values: &[[R; D]], i: usize| values[1][i] - values[0][i];
        let x: [R; D] = array_of(|i| difference(motion.displacements, i) + self.vector[i]);
        let v = array_of(|i| difference(motion.velocities, i));
        let on_first = self.dashpot.on_first(&x, &v, &self.slope);
        let on_first = on_first.each(|force| force * self.factor);
        vec![on_first, on_first.each(|force| -force)]
    }

    fn is_viscous(&self) -> bool {
        true
    }
}

/// Density and kernel that scale the viscosity.
pub(in super::super) struct ViscousScales {
    /// Density in the reference state.
    pub(in super::super) density: f64,
    pub(in super::super) kernel: Kernel,
    /// Support radius of the kernel.
    pub(in super::super) radius: f64,
}

/// Viscous bonds of all pairs, each pair given from both of its ends with its vector in the homogeneous state and its kernel. Masses and densities
/// belong to the sites.
pub(in super::super) fn viscous_bonds<const D: usize>(
    dashpot: Dashpot,
    masses: &[f64],
    densities: &[f64],
    pairs: impl Iterator<Item = ([Particle<D>; 2], [f64; D], Slope<D>)>,
) -> Vec<ViscousBond<D>> {
    let bond = |(particles, vector, slope): ([Particle<D>; 2], _, Slope<D>)| {
        let of = |values: &[f64]| particles.each(|own| values[own.site]);
        ViscousBond {
            particles,
            vector,
            slope,
            dashpot,
            factor: 0.5 * dashpot.factor(of(masses), of(densities)),
        }
    };
    pairs.map(bond).collect()
}
