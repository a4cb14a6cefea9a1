//! The forces that the stress of one particle exerts on itself and on its neighbors, with kernels that move.

use super::super::products::{displacement_gradient, times_transpose, transported};
use super::super::response::{determinant, inverse};
use super::super::{Interaction, Motion, PointResponse};
use super::current::CurrentPairs;
use crate::algebra::{Each, array_of};
use crate::lattice::Particle;
use crate::real::Real;

/// What the particles of a state have in common.
pub(super) struct Surroundings<'a, const D: usize> {
    pub(super) response: &'a PointResponse<'a, D>,
    pub(super) pairs: &'a CurrentPairs<D>,
    /// Whether positions stay where they are, so that only what particles carry along follows a displacement.
    pub(super) holds_positions: bool,
}

/// What a particle sees of the others of its interaction, by their numbers in it: itself first.
pub(super) struct Circle<const D: usize> {
    pub(super) members: Vec<usize>,
    /// Of the discrete displacement gradient; 1/length.
    pub(super) gradients: Vec<[f64; D]>,
}

/// The part of the forces that is linear in the stress `s_I` of a particle `I`:
///
/// `f_I = +- sum_J c_IJ s_I grad W_IJ`, `f_J = -c_IJ s_I grad W_IJ`; the sums of these over all `I` are the pairwise forms.
/// `s = P F^T / det F` within the dimensions of the lattice, times `K_I^-T` where forces are corrected.
pub(super) struct StressOf<'a, const D: usize> {
    pub(super) surroundings: &'a Surroundings<'a, D>,
    /// The particle, its neighbors, and those that only the densities of its neighbors see.
    pub(super) particles: Vec<Particle<D>>,
    /// Positions in the homogeneous state relative to the particle; length.
    pub(super) positions: Vec<[f64; D]>,
    pub(super) masses: Vec<f64>,
    /// Of the particle, and of its neighbors too where their densities count.
    pub(super) circles: Vec<Circle<D>>,
    /// Where positions follow smoothed velocities and nothing else does: of each particle whose position counts, by their numbers,
    /// its neighbors with their shares.
    pub(super) smoothing: Vec<Vec<(usize, f64)>>,
}

/// Displacements, and the positions that come of them.
struct Moved<'a, R, const D: usize> {
    displacements: &'a [[R; D]],
    positions: Vec<[R; D]>,
}

impl<const D: usize> StressOf<'_, D> {
    /// How far the position of the particle with a number has moved: `u_I + sum_J s_IJ (u_J - u_I)`.
    fn shift<R: Real>(&self, number: usize, displacements: &[[R; D]]) -> [R; D] {
        let own = displacements[number];
        let shares = self.smoothing.get(number).into_iter().flatten();
        shares.fold(own, |sum, (other, share)| {
            let apart = between(&own, &displacements[*other]);
            array_of(|i| sum[i] + apart[i] * *share)
        })
    }

    /// The deformation gradient that a particle carries, `(1 + sum_J u_J (x) g_J) F`.
    fn deformation<R: Real>(&self, displacements: &[[R; D]], circle: &Circle<D>) -> [[R; D]; D] {
        let seen: Vec<[R; D]> = circle.members.iter().map(|n| displacements[*n]).collect();
        let step = displacement_gradient(&seen, &circle.gradients);
        transported(&step, &self.surroundings.response.leading())
    }

    /// The density of the particle with a number.
    fn density<R: Real>(&self, number: usize, moved: &Moved<'_, R, D>) -> R {
        let circle = &self.circles[number];
        let pairs = self.surroundings.pairs;
        if pairs.sums_densities() {
            let members = circle.members.iter();
            return members.fold(R::constant(0.0), |sum, member| {
                let x = between(&moved.positions[number], &moved.positions[*member]);
                sum + pairs.weigh(&x).value * self.masses[*member]
            });
        }
        let f = self.deformation(moved.displacements, circle);
        determinant(&f).recip() * pairs.reference_density()
    }

    /// `K_I^-1`, `K_I = sum_J m_J/rho_J x_IJ (x) grad W_IJ`.
    fn correction<R: Real>(&self, moved: &Moved<'_, R, D>) -> [[R; D]; D] {
        let pairs = self.surroundings.pairs;
        let mut moment = [[R::constant(0.0); D]; D];
        for &other in &self.circles[0].members[1..] {
            let x = between(&moved.positions[0], &moved.positions[other]);
            let [slope, _] = pairs.slopes(&pairs.weigh(&x));
            let volume = self.density(other, moved).recip() * self.masses[other];
            for i in 0..D {
                for j in 0..D {
                    moment[i][j] = moment[i][j] + x[i] * slope[j] * volume;
                }
            }
        }
        inverse(&moment)
    }
}

impl<const D: usize> Interaction<D> for StressOf<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let surroundings = self.surroundings;
        let position = |(number, x): (usize, &[f64; D])| -> [R; D] {
            if surroundings.holds_positions {
                return x.map(R::constant);
            }
            let shift = self.shift(number, motion.displacements);
            array_of(|i| shift[i] + x[i])
        };
        let moved = Moved {
            displacements: motion.displacements,
            positions: self.positions.iter().enumerate().map(position).collect(),
        };
        let circle = &self.circles[0];
        let f = self.deformation(motion.displacements, circle);
        let stress = over(
            &times_transpose(&surroundings.response.first_piola(&f), &f),
            determinant(&f),
        );
        let pairs = surroundings.pairs;
        let masses = self.masses.iter().copied().map(R::constant);
        let masses: Vec<R> = masses.collect();
        let density = self.density(0, &moved);
        let along = match pairs.corrects_forces() {
            false => stress,
            true => times_transpose(&stress, &self.correction(&moved)),
        };
        let own = pairs.laden(masses[0], density, &along, pairs.tensile(&stress));
        let mut forces = vec![[R::constant(0.0); D]; self.particles.len()];
        for &other in &circle.members[1..] {
            let x = between(&moved.positions[0], &moved.positions[other]);
            let other_density = match pairs.takes_both_densities() {
                false => density,
                true => self.density(other, &moved),
            };
            let reach = pairs.reach(masses[other], other_density);
            let traction = own.traction(&pairs.slopes(&pairs.weigh(&x)));
            let traction = traction.each(|own| own * reach);
            let taken = pairs.taken(traction);
            for i in 0..D {
                forces[other][i] = forces[other][i] - traction[i];
                forces[0][i] = forces[0][i] + taken[i];
            }
        }
        forces
    }
}

fn between<R: Real, const D: usize>(from: &[R; D], to: &[R; D]) -> [R; D] {
    array_of(|i| to[i] - from[i])
}

fn over<R: Real, const D: usize>(matrix: &[[R; D]; D], divisor: R) -> [[R; D]; D] {
    let factor = divisor.recip();
    matrix.each(|row| row.each(|entry| entry * factor))
}
