//! Equations of plane waves by linearization of discrete forces.

use super::{Interaction, Motion};
use crate::bloch::{BlochBlocks, BlochSum, Mass, WaveSystem};
use crate::cancel::checkpoint;
use crate::lattice::Crystal;
use crate::method::MethodError;
use crate::real::{Dual, Real};
use nalgebra::SMatrix;

/// Number of derivatives computed in one pass.
const LANES: usize = 8;

/// Linearized forces of a discretization: negative derivatives of the forces with respect to the motion of the particles.
#[derive(Clone, Debug)]
pub struct Forced<const D: usize> {
    /// Stiffness: negative derivatives with respect to the displacements.
    pub stiffness: BlochBlocks<D>,
    /// Damping: negative derivatives with respect to the velocities.
    pub damping: BlochBlocks<D>,
    /// Whether a force depends on velocities.
    pub is_viscous: bool,
}

impl<const D: usize> Default for Forced<D> {
    fn default() -> Self {
        Self {
            stiffness: BlochBlocks::new(),
            damping: BlochBlocks::new(),
            is_viscous: false,
        }
    }
}

impl<const D: usize> From<BlochBlocks<D>> for Forced<D> {
    /// Linearized forces of a given stiffness.
    fn from(stiffness: BlochBlocks<D>) -> Self {
        Self {
            stiffness,
            ..Self::default()
        }
    }
}

impl<const D: usize> Forced<D> {
    /// Adds the linearized forces of an interaction.
    pub fn add<I: Interaction<D>>(&mut self, interaction: &I) {
        checkpoint();
        interaction.add_stiffness(&mut self.stiffness);
        if interaction.is_viscous() {
            self.is_viscous = true;
            differentiated(interaction, true, &mut self.damping);
        }
    }

    /// Returns the equations of motion for plane waves.
    ///
    /// # Errors
    /// [`MethodError::NotFinite`] if a derivative is not a finite number.
    pub fn waves(self, crystal: &Crystal<D>, mass: Mass<D>) -> Result<WaveSystem<D>, MethodError> {
        let sum = |blocks: BlochBlocks<D>| -> BlochSum<D> { blocks.sum(crystal) };
        let damping = self.is_viscous.then(|| sum(self.damping));
        let system = WaveSystem::new(crystal.clone(), sum(self.stiffness), mass);
        let is_damping_finite = damping
            .as_ref()
            .is_none_or(|damping| damping.magnitude().is_finite());
        if !(system.is_finite() && is_damping_finite) {
            return Err(MethodError::NotFinite);
        }
        Ok(match damping {
            Some(damping) => system.with_damping(damping),
            None => system,
        })
    }
}

/// Returns the equations of plane waves for a sum of interactions. Each interaction is given once and is repeated by the lattice.
///
/// # Errors
/// [`MethodError::NotFinite`] if a derivative is not a finite number.
pub fn linearized<'i, I: Interaction<D> + 'i, const D: usize>(
    crystal: &Crystal<D>,
    mass: Mass<D>,
    interactions: impl IntoIterator<Item = &'i I>,
) -> Result<WaveSystem<D>, MethodError> {
    let mut forced = Forced::default();
    for interaction in interactions {
        forced.add(interaction);
    }
    forced.waves(crystal, mass)
}

/// Adds the negative derivatives of the forces of an interaction with respect to displacements or velocities.
pub(super) fn differentiated<I: Interaction<D> + ?Sized, const D: usize>(
    interaction: &I,
    by_velocity: bool,
    blocks: &mut BlochBlocks<D>,
) {
    let mut sums = blocks.between(interaction.particles());
    let at_rest = vec![[0.0; D]; interaction.particles().len()];
    derivatives(
        interaction,
        &at_rest,
        by_velocity,
        &mut |from, to, block| {
            sums.add(from, to, block);
        },
    );
    sums.finish();
}

/// Calls `take` with the negative derivative of the force on each particle of an interaction with respect to the displacement or velocity of each
/// particle.
///
/// The particles have the displacements `at` and no velocities. The arguments are the numbers of both particles and the block.
pub(super) fn derivatives<I: Interaction<D> + ?Sized, const D: usize>(
    interaction: &I,
    at: &[[f64; D]],
    by_velocity: bool,
    take: &mut dyn FnMut(usize, usize, &SMatrix<f64, D, D>),
) {
    type Number = Dual<LANES>;
    let particles = interaction.particles();
    let still = vec![[Number::constant(0.0); D]; particles.len()];
    let displaced: Vec<[Number; D]> = at.iter().map(|u| u.map(Number::constant)).collect();
    let unknowns = D * particles.len();
    // Columns of one particle, collected until the block is complete.
    let mut columns = vec![SMatrix::<f64, D, D>::zeros(); particles.len()];
    for start in (0..unknowns).step_by(LANES) {
        let mut varied = if by_velocity { &still } else { &displaced }.clone();
        let lanes = start..(start + LANES).min(unknowns);
        for (lane, unknown) in lanes.clone().enumerate() {
            let own = &mut varied[unknown / D][unknown % D];
            *own = Number::variable(own.value(), lane);
        }
        let motion = if by_velocity {
            Motion {
                displacements: &displaced,
                velocities: &varied,
            }
        } else {
            Motion {
                displacements: &varied,
                velocities: &still,
            }
        };
        let forces = interaction.forces(motion);
        for (lane, unknown) in lanes.enumerate() {
            let (to, column) = (unknown / D, unknown % D);
            for (block, force) in columns.iter_mut().zip(&forces) {
                for i in 0..D {
                    // An undefined force is a constant without derivatives.
                    block[(i, column)] = match force[i].value().is_finite() {
                        true => -force[i].gradient[lane],
                        false => f64::NAN,
                    };
                }
            }
            if column == D - 1 {
                for (from, block) in columns.iter().enumerate() {
                    take(from, to, block);
                }
            }
        }
    }
}
