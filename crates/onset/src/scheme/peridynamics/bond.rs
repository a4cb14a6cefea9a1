//! Bonds of the prototype microelastic material (Silling 2000).

use super::family::ReferenceBond;
use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::real::Real;
use crate::scheme::{Interaction, Motion};
use nalgebra::SVector;

/// Bond in a homogeneous state, with the energy `1/2 c w s^2 r V_I V_J`.
#[derive(Clone, Debug)]
pub(super) struct Bond<const D: usize> {
    particles: [Particle<D>; 2],
    /// Deformed bond `F X_IJ`; length.
    deformed: SVector<f64, D>,
    /// Length `r` of the bond in the reference configuration.
    length: f64,
    /// Strength of the bond, `c w V_I V_J`; force.
    strength: f64,
}

impl<const D: usize> Bond<D> {
    pub(super) fn new(bond: ReferenceBond<D>, modulus: f64, f: &DeformationGradient) -> Self {
        Self {
            particles: bond.particles,
            deformed: f.leading::<D>() * bond.vector,
            length: bond.vector.norm(),
            strength: modulus * bond.weight,
        }
    }
}

impl<const D: usize> Interaction<D> for Bond<D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let [a, b] = [motion.displacements[0], motion.displacements[1]];
        let y: [R; D] = array_of(|i| b[i] - a[i] + self.deformed[i]);
        let squares = y.iter().fold(R::constant(0.0), |sum, x| sum + *x * *x);
        let length = squares.sqrt();
        // The tension is c w s e = c w (1/r - 1/|y|) y.
        let tension = (-length.recip() + self.length.recip()) * self.strength;
        let pull = y.each(|x| x * tension);
        vec![pull, pull.each(|x| -x)]
    }
}
