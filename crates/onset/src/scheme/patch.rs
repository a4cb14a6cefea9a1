//! Periodic patches of particles and the forces on them.

use super::linearized::derivatives;
use super::{Interaction, Motion};
use crate::algebra::Each;
use crate::cancel::checkpoint;
use crate::lattice::{Crystal, Particle, cells_between};
use crate::method::MethodError;
use nalgebra::{SMatrix, SVector};

/// Periodic patch of `cells` cells along each primitive vector.
///
/// Its particles are numbered cell by cell, the first coordinate varying fastest, and within each cell in the order of the sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodicPatch<const D: usize> {
    cells: [usize; D],
    sites: usize,
}

impl<const D: usize> PeriodicPatch<D> {
    /// Builds a patch of a crystal, with at least one cell along each vector.
    pub fn new(crystal: &Crystal<D>, cells: [usize; D]) -> Self {
        Self {
            cells: cells.each(|n| n.max(1)),
            sites: crystal.sites().len(),
        }
    }

    /// Numbers of cells along the primitive vectors.
    pub fn cells(&self) -> [usize; D] {
        self.cells
    }

    /// Number of particles in the patch.
    pub fn len(&self) -> usize {
        self.sites * self.cells.iter().product::<usize>()
    }

    /// Returns true if the patch has no particles, which never happens.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Particles in the order of their numbers.
    pub fn particles(&self) -> Vec<Particle<D>> {
        let high = self.cells.each(|n| n as i32 - 1);
        let cells = cells_between(&[0; D], &high).into_iter();
        let of_cell = |cell| (0..self.sites).map(move |site| Particle { site, cell });
        cells.flat_map(of_cell).collect()
    }

    /// Returns the number of a particle, or of the particle in the patch whose periodic image it is.
    pub fn number(&self, particle: &Particle<D>) -> usize {
        let folded = |i: usize| particle.cell[i].rem_euclid(self.cells[i] as i32) as usize;
        let cell = (0..D)
            .rev()
            .fold(0, |sum, i| sum * self.cells[i] + folded(i));
        cell * self.sites + particle.site
    }

    /// Origins of the cells in lattice coordinates.
    pub(crate) fn origins(&self) -> Vec<[i32; D]> {
        let high = self.cells.each(|n| n as i32 - 1);
        cells_between(&[0; D], &high)
    }
}

/// Forces on the particles of a periodic patch near a homogeneous state, prepared for many evaluations.
pub trait PatchForces<const D: usize> {
    /// Returns the force on each particle, in the order of [`PeriodicPatch`]; force (in 2D per unit thickness, in 1D per unit cross-section).
    ///
    /// The arguments are displacements from the homogeneous state (length) and velocities (length/time).
    ///
    /// # Errors
    /// [`NoForce`] if the law or the method is not defined for the motion.
    fn at(
        &self,
        displacements: &[SVector<f64, D>],
        velocities: &[SVector<f64, D>],
    ) -> Result<Vec<SVector<f64, D>>, NoForce>;

    /// Calls `take` with blocks of the tangent at the given displacements, without velocities: the negative derivative of the force on the first
    /// particle with respect to the displacement of the second. The tangent is the sum of all blocks. Returns false if the forces have no
    /// derivatives.
    fn tangent(
        &self,
        _displacements: &[SVector<f64, D>],
        _take: &mut dyn FnMut(usize, usize, &SMatrix<f64, D, D>),
    ) -> bool {
        false
    }

    /// Time step of a method that carries velocities on points and accelerates them on a grid; `None` for methods that integrators step.
    fn transfer(&self) -> Option<&dyn PatchTransfer<D>> {
        None
    }
}

/// State of points in motion, in the order of the cells and of the points in a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct PointsInMotion<const D: usize> {
    /// Displacements from the homogeneous state, in the current configuration; length.
    pub displacements: Vec<SVector<f64, D>>,
    /// Velocities of the points; length/time.
    pub velocities: Vec<SVector<f64, D>>,
    /// Displacement gradients `L` with `F = (1 + L) F0`; dimensionless.
    pub gradients: Vec<SMatrix<f64, D, D>>,
    /// Affine fields: change of the velocity field of a point over one grid cell along each axis; length/time. Zero without affine fields.
    pub affine: Vec<SMatrix<f64, D, D>>,
}

impl<const D: usize> PointsInMotion<D> {
    /// Returns `count` points in the homogeneous state with zero velocity.
    pub fn at_rest(count: usize) -> Self {
        Self {
            displacements: vec![SVector::zeros(); count],
            velocities: vec![SVector::zeros(); count],
            gradients: vec![SMatrix::zeros(); count],
            affine: vec![SMatrix::zeros(); count],
        }
    }
}

/// Time step of a method that carries velocities on points and accelerates them on a grid, on a periodic patch.
pub trait PatchTransfer<const D: usize> {
    /// Positions of the points in the homogeneous state, in lattice coordinates of the grid.
    fn places(&self) -> Vec<SVector<f64, D>>;

    /// Advances the points by one time step.
    ///
    /// # Errors
    /// [`NoForce`] if the law is not defined for the motion, or if a point is lost.
    fn advance(&self, points: &mut PointsInMotion<D>, dt: f64) -> Result<(), NoForce>;

    /// Returns the points after the nodes have displaced them from the homogeneous state, `u_p = sum_i N_ip u_i`, `L_p = sum_i u_i (x) grad N_ip`.
    ///
    /// Their velocities are interpolated from the nodes, with affine fields if the transfer uses them.
    fn carried(
        &self,
        displacements: &[SVector<f64, D>],
        velocities: &[SVector<f64, D>],
    ) -> PointsInMotion<D>;

    /// Kinetic energy `sum_p m_p (|v_p|^2 + tr C_p D_p C_p^T) / 2`; energy.
    fn kinetic_energy(&self, points: &PointsInMotion<D>) -> f64;

    /// Strain energy `sum_p V_p W(F_p)` minus its value in the homogeneous state; energy.
    fn strain_energy(&self, points: &PointsInMotion<D>) -> f64;

    /// Linear momentum `sum_p m_p v_p`; mass length/time.
    fn momentum(&self, points: &PointsInMotion<D>) -> SVector<f64, D>;
}

/// Motion for which forces are undefined: an inverted or locked particle, a support without enough neighbors, or an overflow.
#[derive(Clone, Debug, PartialEq)]
pub struct NoForce {
    /// Number of the particle whose force is undefined.
    pub particle: usize,
    /// Error of the method or the law; `None` if the stress is undefined, a number is not finite, or a particle has moved out of range.
    pub source: Option<MethodError>,
}

/// Forces of interactions, each repeated in every cell of a patch.
pub struct Assembled<'i, I, const D: usize> {
    particles: usize,
    /// Each interaction with the numbers of its particles, cell by cell.
    repeated: Vec<(&'i I, Vec<Vec<usize>>)>,
}

impl<'i, I: Interaction<D>, const D: usize> Assembled<'i, I, D> {
    /// Assembles the interactions of one cell on a patch.
    pub fn new(patch: &PeriodicPatch<D>, interactions: impl IntoIterator<Item = &'i I>) -> Self {
        let origins = patch.origins();
        let numbers = |interaction: &I, origin: &[i32; D]| -> Vec<usize> {
            let particles = interaction.particles().iter();
            particles
                .map(|own| patch.number(&own.moved(origin)))
                .collect()
        };
        let repeated = interactions.into_iter().map(|interaction| {
            let all = origins.iter().map(|origin| numbers(interaction, origin));
            (interaction, all.collect())
        });
        Self {
            particles: patch.len(),
            repeated: repeated.collect(),
        }
    }
}

impl<I: Interaction<D>, const D: usize> PatchForces<D> for Assembled<'_, I, D> {
    fn at(
        &self,
        displacements: &[SVector<f64, D>],
        velocities: &[SVector<f64, D>],
    ) -> Result<Vec<SVector<f64, D>>, NoForce> {
        let mut forces = vec![SVector::zeros(); self.particles];
        let (mut moved, mut moving): (Vec<[f64; D]>, Vec<[f64; D]>) = Default::default();
        for (interaction, repeated) in &self.repeated {
            for numbers in repeated {
                moved.clear();
                moved.extend(numbers.iter().map(|n| <[f64; D]>::from(displacements[*n])));
                moving.clear();
                moving.extend(numbers.iter().map(|n| <[f64; D]>::from(velocities[*n])));
                let motion = Motion {
                    displacements: &moved,
                    velocities: &moving,
                };
                for (number, force) in numbers.iter().zip(interaction.forces(motion)) {
                    if force.iter().any(|component| !component.is_finite()) {
                        return Err(NoForce {
                            particle: numbers[0],
                            source: None,
                        });
                    }
                    forces[*number] += SVector::from(force);
                }
            }
        }
        Ok(forces)
    }

    fn tangent(
        &self,
        displacements: &[SVector<f64, D>],
        take: &mut dyn FnMut(usize, usize, &SMatrix<f64, D, D>),
    ) -> bool {
        for (interaction, repeated) in &self.repeated {
            for numbers in repeated {
                checkpoint();
                let at: Vec<[f64; D]> = numbers.iter().map(|n| displacements[*n].into()).collect();
                derivatives(*interaction, &at, false, &mut |from, to, block| {
                    take(numbers[from], numbers[to], block);
                });
            }
        }
        true
    }
}

/// Sum of two kinds of forces.
pub(super) struct Both<A, B>(pub(super) A, pub(super) B);

impl<A: PatchForces<D>, B: PatchForces<D>, const D: usize> PatchForces<D> for Both<A, B> {
    fn at(
        &self,
        displacements: &[SVector<f64, D>],
        velocities: &[SVector<f64, D>],
    ) -> Result<Vec<SVector<f64, D>>, NoForce> {
        let mut forces = self.0.at(displacements, velocities)?;
        let more = self.1.at(displacements, velocities)?;
        forces.iter_mut().zip(more).for_each(|(own, f)| *own += f);
        Ok(forces)
    }

    fn tangent(
        &self,
        displacements: &[SVector<f64, D>],
        take: &mut dyn FnMut(usize, usize, &SMatrix<f64, D, D>),
    ) -> bool {
        self.0.tangent(displacements, take) && self.1.tangent(displacements, take)
    }
}
