//! The interactions of SPH as a single type.

use super::super::lagrangian::Stressed;
use super::super::stabilization::{BondPenalty, RiemannPairs, ViscousBond};
use super::super::{Interaction, Motion};
use super::chain::Chain;
use super::pairwise::PairwiseShear;
use super::springs::PairSprings;
use super::stress::StressOf;
use crate::bloch::BlochBlocks;
use crate::lattice::Particle;
use crate::real::Real;

pub(super) enum SphInteraction<'a, const D: usize> {
    /// Stress of a particle with neighbors fixed in the reference configuration.
    Fixed(Stressed<'a, D>),
    /// Stress of a particle with shear forces between pairs.
    Pairwise(PairwiseShear<'a, D>),
    /// Stress of a particle with moving neighbors.
    Moving(StressOf<'a, D>),
    Penalty(BondPenalty<'a, D>),
    /// Accumulated forces of a particle along its pairs.
    Springs(PairSprings<D>),
    Viscous(ViscousBond<D>),
    Riemann(RiemannPairs<'a, D>),
}

impl<const D: usize> Interaction<D> for SphInteraction<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        match self {
            Self::Fixed(point) => point.particles(),
            Self::Pairwise(point) => point.particles(),
            Self::Moving(stress) => stress.particles(),
            Self::Penalty(penalty) => penalty.particles(),
            Self::Springs(springs) => springs.particles(),
            Self::Viscous(bond) => bond.particles(),
            Self::Riemann(pairs) => pairs.particles(),
        }
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        match self {
            Self::Fixed(point) => point.forces(motion),
            Self::Pairwise(point) => point.forces(motion),
            Self::Moving(stress) => stress.forces(motion),
            Self::Penalty(penalty) => penalty.forces(motion),
            Self::Springs(springs) => springs.forces(motion),
            Self::Viscous(bond) => bond.forces(motion),
            Self::Riemann(pairs) => pairs.forces(motion),
        }
    }

    fn is_viscous(&self) -> bool {
        matches!(self, Self::Viscous(_) | Self::Riemann(_))
    }

    fn add_stiffness(&self, blocks: &mut BlochBlocks<D>) {
        match self {
            Self::Fixed(point) => point.add_stiffness(blocks),
            Self::Pairwise(point) => point.add_stiffness(blocks),
            Self::Moving(stress) => Chain::new(stress).add_stiffness(blocks),
            Self::Penalty(penalty) => penalty.add_stiffness(blocks),
            Self::Springs(springs) => springs.add_stiffness(blocks),
            Self::Viscous(bond) => bond.add_stiffness(blocks),
            Self::Riemann(pairs) => pairs.add_stiffness(blocks),
        }
    }
}
