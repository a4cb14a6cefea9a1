//! Deformation gradients, stresses and accelerations of the particles of total-Lagrangian bodies.
//!
//! All loops run over groups of particles of the width of a vector register. Sums use fused multiply-add on all machines, and each particle has a
//! separate sum. The results are therefore bitwise independent of the vector width and of the number of cores.

use super::contact::Pieces;
use super::error::Lost;
use super::links::{Kind, Links, Pair, Stencil};
use super::parts::{field_parts, tensor_parts};
use super::vectors::{Field, MASKS, Tensors, load, part, slices, states, store, zeros};
use crate::algebra::Each;
use crate::cores::of_each;
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::real::LANES;
use pulp::{Arch, Simd, WithSimd};

/// Number of groups that one core computes at a time.
const BLOCK: usize = 128;

/// State of the particles for forces, with the results of the last evaluation.
pub(super) struct Engine<'a, const D: usize> {
    pub(super) material: &'a dyn Hyperelastic,
    pub(super) links: Links<D>,
    /// Stretches beyond the dimensions of the body.
    pub(super) transverse: DeformationGradient,
    /// Offsets of the penalty as in [`PairLaw::penalty_offsets`](crate::scheme::PairLaw::penalty_offsets).
    pub(super) offsets: Option<[f64; 2]>,
    pub(super) density: f64,
    pub(super) volumes: Vec<f64>,
    /// Deformation gradients `F_I` of the particles.
    pub(super) deformations: Tensors<D>,
    /// Stresses `T_I` of the particles.
    stresses: Tensors<D>,
    /// Pieces of the body, if there is a contact between them.
    pieces: Option<Pieces<D>>,
}

impl<'a, const D: usize> Engine<'a, D> {
    pub(super) fn new(
        material: &'a dyn Hyperelastic,
        links: Links<D>,
        offsets: Option<[f64; 2]>,
        density: f64,
        volumes: Vec<f64>,
        pieces: Option<Pieces<D>>,
    ) -> Self {
        let count = volumes.len();
        Self {
            material,
            links,
            transverse: DeformationGradient::identity(),
            offsets,
            density,
            volumes,
            deformations: std::array::from_fn(|_| zeros(count)),
            stresses: std::array::from_fn(|_| zeros(count)),
            pieces,
        }
    }

    /// Computes `F_I` and `T_I` at the given displacements, and the particles in contact.
    pub(super) fn deform(&mut self, u: &Field<D>) -> Result<(), Lost> {
        if let Some(pieces) = &mut self.pieces {
            pieces.meet(u)?;
        }
        let Self {
            material,
            links,
            transverse,
            deformations,
            stresses,
            volumes,
            ..
        } = self;
        let parts = tensor_parts(deformations, BLOCK * LANES)
            .into_iter()
            .zip(tensor_parts(stresses, BLOCK * LANES))
            .zip(links.groups.chunks(BLOCK))
            .enumerate()
            .collect();
        let u = u.each_ref().map(Vec::as_slice);
        let (links, count) = (&*links, volumes.len());
        let stressed = Stressed {
            material: *material,
            transverse,
            links,
        };
        let lost = of_each(parts, |(number, ((mut f, mut t), groups))| {
            let first = number * BLOCK * LANES;
            Arch::new().dispatch(Strained {
                links,
                groups,
                first,
                u: &u,
                f: &mut f,
            });
            let lost = stressed.block(groups, &f, &mut t, count - first);
            lost.map(|own| Lost::Strained(first + own))
        });
        lost.into_iter().flatten().min().map_or(Ok(()), Err)
    }

    /// Adds `dt f / m` to the velocities. [`Self::deform`] must have been called for these displacements.
    pub(super) fn kick(&self, u: &Field<D>, v: &mut Field<D>, dt: f64) {
        let parts = field_parts(v, BLOCK * LANES)
            .into_iter()
            .zip(self.links.groups.chunks(BLOCK))
            .enumerate()
            .collect();
        let u = u.each_ref().map(Vec::as_slice);
        let f = slices(&self.deformations);
        let t = slices(&self.stresses);
        let factor = dt / self.density;
        of_each(parts, |(number, (mut v, groups))| {
            let kicked = Kicked {
                links: &self.links,
                groups,
                first: number * BLOCK * LANES,
                u: &u,
                f: &f,
                t: &t,
                offsets: self.offsets.unwrap_or_default(),
                factor,
                v: &mut v,
            };
            match self.offsets {
                None => Arch::new().dispatch(Under::<D, NO_PENALTY>(kicked)),
                Some([0.0, 0.0]) => Arch::new().dispatch(Under::<D, PUBLISHED_PENALTY>(kicked)),
                Some(_) => Arch::new().dispatch(Under::<D, OFFSET_PENALTY>(kicked)),
            }
        });
        if let Some(pieces) = &self.pieces {
            pieces.kick(v, dt, |particle| self.density * self.volumes[particle]);
        }
    }

    /// Upper bound of the contribution of contacts to the largest `omega^2`; 1/time^2.
    pub(super) fn stiffest_contact(&self) -> f64 {
        let lightest = self.volumes.iter().copied().fold(f64::INFINITY, f64::min);
        let own = |pieces: &Pieces<D>| pieces.stiffest(self.density * lightest);
        self.pieces.as_ref().map_or(0.0, own)
    }

    /// Strain energy `sum_I V_I W(F_I)` plus the potential of the contacts. [`Self::deform`] must have been called for the current displacements.
    pub(super) fn energy(&self) -> f64 {
        let f = slices(&self.deformations);
        let parts = self.volumes.chunks(BLOCK * LANES).enumerate().collect();
        let energies = of_each(parts, |(number, volumes): (usize, &[f64])| {
            let mut sum = 0.0;
            for (group, volumes) in volumes.chunks(LANES).enumerate() {
                let place = (number * BLOCK + group) * LANES;
                let states = states(&self.transverse, &f, place);
                let energies = self.material.lane_stress(&states, D).energy;
                let both = volumes.iter().zip(&energies.0);
                sum += both.map(|(volume, energy)| volume * energy).sum::<f64>();
            }
            sum
        });
        let contact = self.pieces.as_ref().map_or(0.0, Pieces::energy);
        energies.iter().sum::<f64>() + contact
    }

    /// Memory of the engine in use; bytes.
    pub(super) fn bytes(&self) -> usize {
        let tensors = 2 * D * D * self.volumes.len().next_multiple_of(LANES);
        let links = &self.links;
        (tensors + self.volumes.len()) * size_of::<f64>()
            + links.kinds.len() * size_of::<Kind<D>>()
            + links.pairs.len() * size_of::<Pair>()
            + links.stencils.len() * size_of::<Stencil<D>>()
            + links.groups.len() * size_of::<u32>()
            + self.pieces.as_ref().map_or(0, Pieces::bytes)
    }
}

/// Stresses `T_I = P(F_I) K_I^-T` of the particles.
struct Stressed<'s, const D: usize> {
    material: &'s dyn Hyperelastic,
    transverse: &'s DeformationGradient,
    links: &'s Links<D>,
}

impl<const D: usize> Stressed<'_, D> {
    /// Computes the stresses of a block of `count` particles. Returns the first particle without a stress.
    fn block(
        &self,
        groups: &[u32],
        f: &[[&mut [f64]; D]; D],
        t: &mut [[&mut [f64]; D]; D],
        count: usize,
    ) -> Option<usize> {
        let f = f.each_ref().each(|row| row.each_ref().each(|own| &**own));
        let mut lost = None;
        for (group, stencil) in groups.iter().enumerate() {
            let place = group * LANES;
            let states = states(self.transverse, &f, place);
            let response = self.material.lane_stress(&states, D);
            let own = LANES.min(count - place);
            lost = lost.or_else(|| (place..place + own).find(|n| !response.is_known(n - place)));
            let correction = &self.links.stencils[*stencil as usize].correction;
            for i in 0..D {
                for j in 0..D {
                    let mut sum = [0.0; LANES];
                    for k in 0..D {
                        let (p, k) = (&response.first_piola[i][k].0, &correction[j][k]);
                        for lane in 0..LANES {
                            sum[lane] += p[lane] * k[lane];
                        }
                    }
                    // The padding has zero stress, even if the law is undefined there.
                    sum[own..].fill(0.0);
                    t[i][j][place..place + LANES].copy_from_slice(&sum);
                }
            }
        }
        lost
    }
}

/// Deformation gradients `F_I` of the particles of a block.
struct Strained<'s, 'f, const D: usize> {
    links: &'s Links<D>,
    groups: &'s [u32],
    /// Number of the first particle of the block.
    first: usize,
    u: &'s [&'s [f64]; D],
    f: &'s mut [[&'f mut [f64]; D]; D],
}

impl<const D: usize> WithSimd for Strained<'_, '_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for (group, stencil) in self.groups.iter().enumerate() {
            let stencil = &self.links.stencils[*stencil as usize];
            for from in (0..LANES).step_by(S::F64_LANES) {
                self.strain(simd, stencil, group * LANES, from);
            }
        }
    }
}

// Closures would not compile to vector instructions here, therefore explicit loops.
impl<const D: usize> Strained<'_, '_, D> {
    /// Computes the deformation gradients of a group in the block, starting at one of its particles.
    #[inline(always)]
    fn strain<S: Simd>(&mut self, simd: S, stencil: &Stencil<D>, place: usize, from: usize) {
        let links = self.links;
        let own = self.first + place + from;
        let zero = simd.splat_f64s(0.0);
        let mut u = [zero; D];
        for i in 0..D {
            u[i] = load::<S>(self.u[i], own, 0);
        }
        let mut sum = [[zero; D]; D];
        for pair in &links.pairs[stencil.pairs[0] as usize..stencil.pairs[1] as usize] {
            let kind = &links.kinds[pair.kind as usize];
            let is_there = part::<S>(&MASKS[pair.of as usize], from);
            let mut a = [zero; D];
            for j in 0..D {
                a[j] = simd.mul_f64s(is_there, simd.splat_f64s(kind.a[j]));
            }
            for i in 0..D {
                let apart = simd.sub_f64s(load::<S>(self.u[i], own, pair.offset), u[i]);
                for j in 0..D {
                    sum[i][j] = simd.mul_add_f64s(apart, a[j], sum[i][j]);
                }
            }
        }
        let place = place + from;
        for i in 0..D {
            for j in 0..D {
                let mut f = simd.splat_f64s(if i == j { 1.0 } else { 0.0 });
                for k in 0..D {
                    f = simd.mul_add_f64s(sum[i][k], part::<S>(&stencil.correction[k][j], from), f);
                }
                store::<S>(&mut self.f[i][j][place..place + S::F64_LANES], f);
            }
        }
    }
}

/// Updated velocities of the particles of a block.
struct Kicked<'s, 'f, const D: usize> {
    links: &'s Links<D>,
    groups: &'s [u32],
    /// Number of the first particle of the block.
    first: usize,
    u: &'s [&'s [f64]; D],
    f: &'s [[&'s [f64]; D]; D],
    t: &'s [[&'s [f64]; D]; D],
    offsets: [f64; 2],
    /// Factor `dt / rho0` of the forces.
    factor: f64,
    v: &'s mut [&'f mut [f64]; D],
}

/// Option of no penalty against zero-energy modes.
const NO_PENALTY: u8 = 0;
/// Published form of the penalty.
const PUBLISHED_PENALTY: u8 = 1;
/// Penalty with offsets in its denominators.
const OFFSET_PENALTY: u8 = 2;

/// Velocity update for one form of the penalty, known at compile time.
struct Under<'s, 'f, const D: usize, const FORM: u8>(Kicked<'s, 'f, D>);

impl<const D: usize, const FORM: u8> WithSimd for Under<'_, '_, D, FORM> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let kicked = &mut self.0;
        for (group, stencil) in kicked.groups.iter().enumerate() {
            let stencil = &kicked.links.stencils[*stencil as usize];
            for from in (0..LANES).step_by(S::F64_LANES) {
                kicked.kick::<S, FORM>(simd, stencil, group * LANES, from);
            }
        }
    }
}

impl<const D: usize> Kicked<'_, '_, D> {
    /// Updates the velocities of a group in the block, starting at one of its particles.
    #[inline(always)]
    fn kick<S: Simd, const FORM: u8>(
        &mut self,
        simd: S,
        stencil: &Stencil<D>,
        place: usize,
        from: usize,
    ) {
        let links = self.links;
        let own = self.first + place + from;
        let zero = simd.splat_f64s(0.0);
        let one = simd.splat_f64s(1.0);
        let minus_two = simd.splat_f64s(-2.0);
        let lengths = simd.splat_f64s(self.offsets[0] + self.offsets[1]);
        let area = simd.splat_f64s(self.offsets[0] * self.offsets[1]);
        let mut f = [[zero; D]; D];
        let mut u = [zero; D];
        let mut sum = [zero; D];
        for i in 0..D {
            u[i] = load::<S>(self.u[i], own, 0);
            for j in 0..D {
                let t = load::<S>(self.t[i][j], own, 0);
                sum[i] = simd.mul_add_f64s(t, part::<S>(&stencil.total[j], from), sum[i]);
                if FORM != NO_PENALTY {
                    f[i][j] = load::<S>(self.f[i][j], own, 0);
                }
            }
        }
        for pair in &links.pairs[stencil.pairs[0] as usize..stencil.pairs[1] as usize] {
            let kind = &links.kinds[pair.kind as usize];
            let is_there = part::<S>(&MASKS[pair.of as usize], from);
            for j in 0..D {
                let a = simd.mul_f64s(is_there, simd.splat_f64s(kind.a[j]));
                for i in 0..D {
                    let t = load::<S>(self.t[i][j], own, pair.offset);
                    sum[i] = simd.mul_add_f64s(t, a, sum[i]);
                }
            }
            if FORM == NO_PENALTY {
                continue;
            }
            // The vector x_IJ, and the component of (F_I + F_J) X_IJ - 2 x_IJ along x_IJ.
            let mut x = [zero; D];
            let mut squared = zero;
            let mut along = zero;
            for i in 0..D {
                let apart = simd.sub_f64s(load::<S>(self.u[i], own, pair.offset), u[i]);
                x[i] = simd.add_f64s(apart, simd.splat_f64s(kind.x[i]));
                squared = simd.mul_add_f64s(x[i], x[i], squared);
                let mut missed = simd.mul_f64s(x[i], minus_two);
                for j in 0..D {
                    let both = simd.add_f64s(f[i][j], load::<S>(self.f[i][j], own, pair.offset));
                    missed = simd.mul_add_f64s(both, simd.splat_f64s(kind.x[j]), missed);
                }
                along = simd.mul_add_f64s(missed, x[i], along);
            }
            if FORM == OFFSET_PENALTY {
                let length = simd.sqrt_f64s(squared);
                squared = simd.mul_add_f64s(length, lengths, simd.add_f64s(squared, area));
            }
            // Prevents 0/0 for particles without such a pair.
            squared = simd.add_f64s(squared, simd.sub_f64s(one, is_there));
            let stiffness = simd.mul_f64s(is_there, simd.splat_f64s(-kind.stiffness));
            let along = simd.div_f64s(simd.mul_f64s(along, stiffness), squared);
            for i in 0..D {
                sum[i] = simd.mul_add_f64s(x[i], along, sum[i]);
            }
        }
        let place = place + from;
        let factor = simd.splat_f64s(self.factor);
        for i in 0..D {
            let v = &mut self.v[i][place..place + S::F64_LANES];
            let kicked = simd.mul_add_f64s(sum[i], factor, part::<S>(v, 0));
            store::<S>(v, kicked);
        }
    }
}
