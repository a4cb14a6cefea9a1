//! The linear peridynamic solid, an ordinary state-based model (Silling and others 2007).

use super::family::Family;
use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::real::Real;
use crate::scheme::moduli::Moduli;
use crate::scheme::{Interaction, Motion};
use nalgebra::SVector;

/// Family of a particle in a homogeneous state, with the energy `V_I (kappa theta^2 / 2 + D (D + 2) mu / (2 m) sum w V e_d^2)`.
///
/// Here `e = |y| - r` is the elongation of a bond, `m = sum w r^2 V`, `theta = D/m sum w r e V` the dilatation and `e_d = e - theta r / D`.
#[derive(Clone, Debug)]
pub(super) struct Solid<'a, const D: usize> {
    family: &'a Family<D>,
    /// Deformed bonds `F X_IJ`; length.
    deformed: Vec<SVector<f64, D>>,
    moduli: Moduli,
}

impl<'a, const D: usize> Solid<'a, D> {
    pub(super) fn new(family: &'a Family<D>, moduli: Moduli, f: &DeformationGradient) -> Self {
        let f = f.leading::<D>();
        Self {
            deformed: family.neighbors.iter().map(|n| f * n.vector).collect(),
            family,
            moduli,
        }
    }
}

impl<const D: usize> Interaction<D> for Solid<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.family.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let own = motion.displacements[0];
        let d = D as f64;
        let weighted_volume = self.family.shape.trace();
        let bonds: Vec<([R; D], R)> = motion.displacements[1..]
            .iter()
            .zip(&self.deformed)
            .map(|(u, deformed)| {
                let y: [R; D] = array_of(|i| u[i] - own[i] + deformed[i]);
                let squares = y.iter().fold(R::constant(0.0), |sum, x| sum + *x * *x);
                (y, squares.sqrt())
            })
            .collect();
        let mut dilatation = R::constant(0.0);
        for ((_, length), n) in bonds.iter().zip(&self.family.neighbors) {
            let r = n.vector.norm();
            dilatation =
                dilatation + (*length - r) * (d / weighted_volume * n.influence * n.volume * r);
        }
        let mut forces = vec![[R::constant(0.0); D]; bonds.len() + 1];
        for (number, ((y, length), n)) in bonds.iter().zip(&self.family.neighbors).enumerate() {
            let r = n.vector.norm();
            let deviatoric = *length - r - dilatation * (r / d);
            let tension = dilatation * (d * self.moduli.bulk * r)
                + deviatoric * (d * (d + 2.0) * self.moduli.shear);
            let scale = self.family.volume * n.volume * n.influence / weighted_volume;
            let pull = y.each(|x| x * tension / *length * scale);
            forces[number + 1] = pull.each(|x| -x);
            forces[0] = array_of(|i| forces[0][i] + pull[i]);
        }
        forces
    }
}
