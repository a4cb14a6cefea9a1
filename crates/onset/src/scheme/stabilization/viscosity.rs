//! Artificial viscosity.

use super::super::layout::MovingWeight;
use super::super::{Interaction, Motion};
use super::assert_coefficients;
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;

/// When the viscosity acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ViscositySwitch {
    /// Always, on particles that come nearer and on those that part.
    Always,
    /// With half its strength: the mean of the original, which acts only on particles that come nearer and has no derivative
    /// at rest, over the two halves of an oscillation.
    Averaged,
}

/// Monaghan's artificial viscosity: the force `-m_I m_J Pi_IJ grad W_IJ` on particle `I` with
/// `Pi = (-alpha c mu + beta |mu| mu_-) / rho`, `mu = h v_IJ.x_IJ / (|x_IJ|^2 + 0.01 h^2)`. `rho` is the mean density of the two in the
/// homogeneous state, `c` the largest speed of sound of the undeformed material, `h` half the support radius.
///
/// Near rest the quadratic term vanishes; what remains is the damping of a linear dashpot along each bond.
///
/// Source: Monaghan and Gingold, J. Comput. Phys. 52 (1983) 374.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct ArtificialViscosity {
    /// `alpha`, the linear coefficient.
    pub alpha: f64,
    /// `beta`, the quadratic coefficient: in forces of moving particles, not in plane waves.
    pub beta: f64,
    /// When it acts.
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
    /// Refuses negative coefficients.
    pub(in super::super) fn assert_admissible(&self) -> Result<(), MethodError> {
        assert_coefficients(&[("viscosity", self.alpha), ("viscosity.beta", self.beta)])
    }
}

/// The gradient of the kernel along a bond.
#[derive(Clone, Copy, Debug)]
pub(in super::super) enum Slope<const D: usize> {
    /// Of a kernel of current coordinates.
    Moving(MovingWeight<D>),
    /// `dW/dR` of a kernel of material coordinates, along the current bond.
    Fixed(f64),
}

impl<const D: usize> Slope<D> {
    /// The gradient with respect to the end of a bond `x`.
    fn at<R: Real>(&self, x: &[R; D], squared: R) -> [R; D] {
        match self {
            Self::Moving(weight) => weight.at(x).gradient,
            Self::Fixed(slope) => {
                let over_length = squared.sqrt().recip() * *slope;
                x.map(|component| component * over_length)
            }
        }
    }
}

/// One of the two halves of the viscous force between two particles.
pub(in super::super) struct ViscousBond<const D: usize> {
    particles: [Particle<D>; 2],
    /// `x_J - x_I` in the homogeneous state.
    vector: [f64; D],
    slope: Slope<D>,
    /// `m_I m_J / (2 rho)`, halved again where the viscosity acts half of the time.
    factor: f64,
    /// `alpha c`.
    linear: f64,
    /// `beta`.
    quadratic: f64,
    /// `h`.
    length: f64,
}

impl<const D: usize> Interaction<D> for ViscousBond<D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let difference = |values: &[[R; D]], i: usize| values[1][i] - values[0][i];
        let x: [R; D] =
            std::array::from_fn(|i| difference(motion.displacements, i) + self.vector[i]);
        let zero = R::constant(0.0);
        let squared = x.iter().fold(zero, |sum, x| sum + *x * *x);
        let rate = (0..D).fold(zero, |sum, i| sum + x[i] * difference(motion.velocities, i));
        let mu = rate * self.length / (squared + 0.01 * self.length * self.length);
        let size = mu.switch(0.0, || -mu, || mu);
        let pressure = -mu * (size * self.quadratic + self.linear) * self.factor;
        // grad W_IJ with respect to I is minus that with respect to J.
        let on_first = self.slope.at(&x, squared).map(|slope| slope * pressure);
        vec![on_first, on_first.map(|force| -force)]
    }

    fn is_viscous(&self) -> bool {
        true
    }
}

/// The viscous bonds of all pairs, each pair given from both of its ends: with its vector in the homogeneous state and its
/// kernel. Masses and densities are those of the sites; the scales are the reference density and the support radius.
pub(in super::super) fn viscous_bonds<const D: usize>(
    viscosity: &ArtificialViscosity,
    material: &dyn Hyperelastic,
    (reference_density, radius): (f64, f64),
    masses: &[f64],
    densities: &[f64],
    pairs: impl Iterator<Item = ([Particle<D>; 2], [f64; D], Slope<D>)>,
) -> Result<Vec<ViscousBond<D>>, MethodError> {
    let undeformed = Stiffness::<D>::at(material, &DeformationGradient::identity())?;
    let speed = (undeformed.maximum_eigenvalue() / reference_density).sqrt();
    let share = match viscosity.switch {
        ViscositySwitch::Always => 1.0,
        ViscositySwitch::Averaged => 0.5,
    };
    let bond = |(particles, vector, slope): ([Particle<D>; 2], _, _)| {
        let of = |values: &[f64], end: usize| values[particles[end].site];
        let density = 0.5 * (of(densities, 0) + of(densities, 1));
        ViscousBond {
            particles,
            vector,
            slope,
            factor: share * 0.5 * of(masses, 0) * of(masses, 1) / density,
            linear: viscosity.alpha * speed,
            quadratic: viscosity.beta,
            length: 0.5 * radius,
        }
    };
    Ok(pairs.map(bond).collect())
}
