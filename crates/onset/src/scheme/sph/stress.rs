//! Forces of the stress of one particle on itself and on its neighbors, with moving kernels.

use super::super::products::{displacement_gradient, times_transpose, transported};
use super::super::response::{determinant, inverse};
use super::super::{Interaction, Motion, PointResponse};
use super::current::{CurrentPairs, Laden};
use crate::algebra::{Each, array_of};
use crate::lattice::Particle;
use crate::real::Real;
use std::borrow::Cow;

/// Responses of the law at the particles of a state.
pub(super) enum Responses<'a, const D: usize> {
    /// All particles have the same deformation gradient.
    Equal(PointResponse<'a, D>),
    /// The deformation gradients differ from site to site.
    OfSites(Vec<PointResponse<'a, D>>),
}

impl<'a, const D: usize> Responses<'a, D> {
    pub(super) fn of(&self, site: usize) -> &PointResponse<'a, D> {
        match self {
            Self::Equal(response) => response,
            Self::OfSites(all) => &all[site],
        }
    }
}

/// Common data of the particles of a state.
pub(super) struct Surroundings<'a, const D: usize> {
    pub(super) responses: &'a Responses<'a, D>,
    pub(super) pairs: &'a CurrentPairs<D>,
    /// Whether positions are held, so that a displacement changes only the quantities that particles carry.
    pub(super) holds_positions: bool,
}

/// Neighbors of a particle, numbered within its interaction; the particle itself comes first.
pub(super) struct Circle<const D: usize> {
    pub(super) members: Vec<usize>,
    /// Gradients `g_J` of the discrete displacement gradient; 1/length.
    pub(super) gradients: Vec<[f64; D]>,
}

/// Forces that are linear in the stress `s_I` of a particle `I`.
///
/// They are `f_I = +- sum_J c_IJ s_I grad W_IJ`, `f_J = -c_IJ s_I grad W_IJ`; summed over all `I` they give the pairwise forms.
/// `s = P F^T / det F` within the dimensions of the lattice, times `K_I^-T` if forces are corrected.
pub(super) struct StressOf<'a, const D: usize> {
    pub(super) surroundings: &'a Surroundings<'a, D>,
    /// The particle, its neighbors, and particles that only contribute to the densities of its neighbors.
    pub(super) particles: Vec<Particle<D>>,
    /// Positions in the homogeneous state relative to the particle; length.
    pub(super) positions: Vec<[f64; D]>,
    pub(super) masses: Vec<f64>,
    /// Neighbors of the particle, and also of its neighbors if their densities enter the forces.
    pub(super) circles: Vec<Circle<D>>,
    /// Neighbors with their weights for each particle whose position is needed, by number, if only positions follow smoothed velocities; otherwise
    /// empty.
    pub(super) smoothing: Vec<Vec<(usize, f64)>>,
}

/// Displacements and the resulting positions.
pub(super) struct Moved<'a, R: Clone, const D: usize> {
    displacements: Cow<'a, [[R; D]]>,
    positions: Vec<[R; D]>,
}

impl<const D: usize> StressOf<'_, D> {
    /// Particles whose displacements move the given particle, with their weights: `u_I + sum_J s_IJ (u_J - u_I)`.
    pub(super) fn shares(&self, number: usize) -> impl Iterator<Item = (usize, f64)> {
        let moves = !self.surroundings.holds_positions;
        let smoothing = self.smoothing.get(number).filter(|_| moves);
        let others = smoothing.into_iter().flatten().copied();
        let rest = others.clone().fold(1.0, |rest, (_, share)| rest - share);
        moves.then_some((number, rest)).into_iter().chain(others)
    }

    /// Displacement of the position of a particle.
    fn shift<R: Real>(&self, number: usize, displacements: &[[R; D]]) -> [R; D] {
        let shares = self.shares(number);
        shares.fold([R::constant(0.0); D], |sum, (other, share)| {
            array_of(|i| sum[i] + displacements[other][i] * share)
        })
    }

    /// Vector between two particles in the homogeneous state, by their numbers.
    pub(super) fn vector(&self, from: usize, to: usize) -> [f64; D] {
        between(&self.positions[from], &self.positions[to])
    }

    /// Homogeneous state without displacements.
    pub(super) fn at_rest(&self) -> Moved<'_, f64, D> {
        Moved {
            displacements: Cow::Owned(vec![[0.0; D]; self.particles.len()]),
            positions: self.positions.clone(),
        }
    }

    /// Response of the law at the particle with the given number.
    pub(super) fn response(&self, number: usize) -> &PointResponse<'_, D> {
        self.surroundings.responses.of(self.particles[number].site)
    }

    /// Deformation gradient of the particle with the given number, `(1 + sum_J u_J (x) g_J) F`.
    fn deformation<R: Real>(&self, displacements: &[[R; D]], number: usize) -> [[R; D]; D] {
        let circle = &self.circles[number];
        let seen: Vec<[R; D]> = circle.members.iter().map(|n| displacements[*n]).collect();
        let step = displacement_gradient(&seen, &circle.gradients);
        transported(&step, &self.response(number).leading())
    }

    /// Density of the particle with the given number.
    pub(super) fn density<R: Real>(&self, number: usize, moved: &Moved<'_, R, D>) -> R {
        let circle = &self.circles[number];
        let pairs = self.surroundings.pairs;
        if pairs.sums_densities() {
            let members = circle.members.iter();
            return members.fold(R::constant(0.0), |sum, member| {
                let x = between(&moved.positions[number], &moved.positions[*member]);
                sum + pairs.weigh(&x).value * self.masses[*member]
            });
        }
        let f = self.deformation(&moved.displacements, number);
        determinant(&f).recip() * pairs.reference_density()
    }

    /// Moment `K_I = sum_J m_J/rho_J x_IJ (x) grad W_IJ`, if forces are corrected by its inverse.
    pub(super) fn moment<R: Real>(&self, moved: &Moved<'_, R, D>) -> Option<[[R; D]; D]> {
        if !self.surroundings.pairs.corrects_forces() {
            return None;
        }
        let mut moment = [[R::constant(0.0); D]; D];
        for &other in &self.circles[0].members[1..] {
            let x = between(&moved.positions[0], &moved.positions[other]);
            let part = self.part_of_moment(other, &x, self.density(other, moved));
            for i in 0..D {
                for j in 0..D {
                    moment[i][j] = moment[i][j] + part[i][j];
                }
            }
        }
        Some(moment)
    }

    /// Contribution of another particle to the moment, from its relative position and its density.
    pub(super) fn part_of_moment<R: Real>(
        &self,
        other: usize,
        x: &[R; D],
        density: R,
    ) -> [[R; D]; D] {
        let pairs = self.surroundings.pairs;
        let [slope, _] = pairs.slopes(&pairs.weigh(x));
        let volume = density.recip() * self.masses[other];
        array_of(|i| array_of(|j| x[i] * slope[j] * volume))
    }

    /// Contribution of the particle to pair forces, from its deformation gradient, its density, and the moment of a correction.
    pub(super) fn laden<R: Real>(
        &self,
        f: &[[R; D]; D],
        density: R,
        moment: Option<&[[R; D]; D]>,
    ) -> Laden<R, D> {
        let pairs = self.surroundings.pairs;
        let stress = over(
            &times_transpose(&self.response(0).first_piola(f), f),
            determinant(f),
        );
        let along = match moment {
            None => stress,
            Some(moment) => times_transpose(&stress, &inverse(moment)),
        };
        let mass = R::constant(self.masses[0]);
        pairs.laden(mass, density, &along, pairs.tensile(&stress))
    }

    /// Traction between the particle and a neighbor, from the relative position and the density of the neighbor.
    pub(super) fn traction<R: Real>(
        &self,
        own: &Laden<R, D>,
        other: usize,
        x: &[R; D],
        density: R,
    ) -> [R; D] {
        let pairs = self.surroundings.pairs;
        let reach = pairs.reach(R::constant(self.masses[other]), density);
        let traction = own.traction(&pairs.slopes(&pairs.weigh(x)));
        traction.each(|own| own * reach)
    }
}

impl<const D: usize> Interaction<D> for StressOf<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let position = |(number, x): (usize, &[f64; D])| -> [R; D] {
            let shift = self.shift(number, motion.displacements);
            array_of(|i| shift[i] + x[i])
        };
        let moved = Moved {
            displacements: Cow::Borrowed(motion.displacements),
            positions: self.positions.iter().enumerate().map(position).collect(),
        };
        let circle = &self.circles[0];
        let f = self.deformation(motion.displacements, 0);
        let density = self.density(0, &moved);
        let own = self.laden(&f, density, self.moment(&moved).as_ref());
        let pairs = self.surroundings.pairs;
        let mut forces = vec![[R::constant(0.0); D]; self.particles.len()];
        for &other in &circle.members[1..] {
            let x = between(&moved.positions[0], &moved.positions[other]);
            let other_density = match pairs.takes_both_densities() {
                false => density,
                true => self.density(other, &moved),
            };
            let traction = self.traction(&own, other, &x, other_density);
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
