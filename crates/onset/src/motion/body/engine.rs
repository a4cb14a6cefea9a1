//! Deformation gradients, stresses and accelerations of all particles.

use super::links::{Block, Kind, Links, Pair, Run};
use super::vectors::{Single, Vectors, Wide};
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::real::{LANES, Lanes};
use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};

/// A component of all particles, with room for vectors that end behind the last one.
pub(super) type Component = Vec<f64>;
/// A vector of all particles.
pub(super) type Field<const D: usize> = [Component; D];
/// A tensor of all particles.
pub(super) type Tensors<const D: usize> = [[Component; D]; D];

/// A vector of zeros for so many particles.
pub(super) fn zeros<const D: usize>(count: usize) -> Field<D> {
    std::array::from_fn(|_| vec![0.0; count + LANES])
}

/// The particle about which there is no stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Lost(pub(super) usize);

/// What forces need, and what they leave.
pub(super) struct Engine<'a, const D: usize> {
    pub(super) material: &'a dyn Hyperelastic,
    pub(super) links: Links<D>,
    /// Stretches beyond the dimensions of the body.
    pub(super) transverse: DeformationGradient,
    /// Under the penalty; see [`PairLaw::penalty_offsets`](crate::scheme::PairLaw::penalty_offsets).
    pub(super) offsets: Option<[f64; 2]>,
    pub(super) density: f64,
    pub(super) volumes: Vec<f64>,
    /// `F_I`.
    pub(super) deformations: Tensors<D>,
    /// `T_I`.
    stresses: Tensors<D>,
}

impl<'a, const D: usize> Engine<'a, D> {
    pub(super) fn new(
        material: &'a dyn Hyperelastic,
        links: Links<D>,
        offsets: Option<[f64; 2]>,
        density: f64,
        volumes: Vec<f64>,
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
        }
    }

    /// `F_I` and `T_I` at displacements.
    pub(super) fn deform(&mut self, u: &Field<D>) -> Result<(), Lost> {
        let Self {
            material,
            links,
            transverse,
            deformations,
            stresses,
            ..
        } = self;
        let blocks = &links.blocks;
        let parts = tensor_parts(deformations, blocks)
            .into_iter()
            .zip(tensor_parts(stresses, blocks))
            .zip(blocks)
            .collect();
        let u = u.each_ref().map(Vec::as_slice);
        let (material, links, transverse) = (*material, &*links, &*transverse);
        let lost = of_each(parts, |((mut f, mut t), block)| {
            Arch::new().dispatch(Strained {
                links,
                block,
                u: &u,
                f: &mut f,
            });
            let lost = stress(material, transverse, &f, &mut t);
            Arch::new().dispatch(Corrected {
                links,
                block,
                t: &mut t,
            });
            lost.map(|own| Lost(block.particles[0] + own))
        });
        lost.into_iter().flatten().min().map_or(Ok(()), Err)
    }

    /// `v += dt f / m` with the forces at displacements, of which [`Self::deform`] was called.
    pub(super) fn kick(&self, u: &Field<D>, v: &mut Field<D>, dt: f64) {
        let blocks = &self.links.blocks;
        let parts = field_parts(v, blocks).into_iter().zip(blocks).collect();
        let u = u.each_ref().map(Vec::as_slice);
        let f = slices(&self.deformations);
        let t = slices(&self.stresses);
        let factor = dt / self.density;
        of_each(parts, |(mut v, block)| {
            let kicked = Kicked {
                links: &self.links,
                block,
                u: &u,
                f: &f,
                t: &t,
                offsets: self.offsets.unwrap_or_default(),
                factor,
                v: &mut v,
            };
            match self.offsets {
                None => Arch::new().dispatch(Under::<D, WITHOUT>(kicked)),
                Some([0.0, 0.0]) => Arch::new().dispatch(Under::<D, PUBLISHED>(kicked)),
                Some(_) => Arch::new().dispatch(Under::<D, OFFSET>(kicked)),
            }
        });
    }

    /// `u += dt v`.
    pub(super) fn drift(&self, u: &mut Field<D>, v: &Field<D>, dt: f64) {
        let blocks = &self.links.blocks;
        let parts = field_parts(u, blocks).into_iter().zip(blocks).collect();
        of_each(parts, |(u, block)| {
            let [first, end] = block.particles;
            for (u, v) in u.into_iter().zip(v) {
                for (u, v) in u.iter_mut().zip(&v[first..end]) {
                    *u += v * dt;
                }
            }
        });
    }

    /// `sum_I V_I W(F_I)`, of which [`Self::deform`] was called.
    pub(super) fn energy(&self) -> f64 {
        let parts = self.links.blocks.iter().collect();
        let f = slices(&self.deformations);
        let energies = of_each(parts, |block: &Block| {
            let [first, end] = block.particles;
            let mut sum = 0.0;
            for place in (first..end).step_by(LANES) {
                let count = LANES.min(end - place);
                let states = states(&self.transverse, &f, place, count);
                let energies = self.material.lane_stress(&states, D).energy;
                let volumes = &self.volumes[place..place + count];
                let both = volumes.iter().zip(&energies.0);
                sum += both.map(|(volume, energy)| volume * energy).sum::<f64>();
            }
            sum
        });
        energies.iter().sum()
    }

    /// What the engine keeps for a particle; bytes.
    pub(super) fn bytes(&self) -> usize {
        let tensors = 2 * D * D * (self.volumes.len() + LANES);
        let links = &self.links;
        (tensors + self.volumes.len()) * size_of::<f64>()
            + links.kinds.len() * size_of::<Kind<D>>()
            + links.pairs.len() * size_of::<Pair>()
            + links.runs.len() * size_of::<Run<D>>()
            + links.blocks.len() * size_of::<Block>()
    }
}

fn slices<const D: usize>(tensors: &Tensors<D>) -> [[&[f64]; D]; D] {
    tensors
        .each_ref()
        .map(|row| row.each_ref().map(Vec::as_slice))
}

/// Work on each of some things, on all cores where there are any; results in their order.
#[cfg(feature = "rayon")]
fn of_each<T: Send, R: Send>(things: Vec<T>, work: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    use rayon::prelude::*;
    things.into_par_iter().map(work).collect()
}

/// Work on each of some things; results in their order.
#[cfg(not(feature = "rayon"))]
fn of_each<T, R>(things: Vec<T>, work: impl Fn(T) -> R) -> Vec<R> {
    things.into_iter().map(work).collect()
}

/// A field cut into what blocks write.
fn field_parts<'f, const D: usize>(
    field: &'f mut Field<D>,
    blocks: &[Block],
) -> Vec<[&'f mut [f64]; D]> {
    let mut rest = field.each_mut().map(Vec::as_mut_slice);
    let part = |block: &Block| {
        let count = block.particles[1] - block.particles[0];
        rest.each_mut().map(|rest| {
            let (part, left) = std::mem::take(rest).split_at_mut(count);
            *rest = left;
            part
        })
    };
    blocks.iter().map(part).collect()
}

/// Tensors cut into what blocks write.
fn tensor_parts<'f, const D: usize>(
    tensors: &'f mut Tensors<D>,
    blocks: &[Block],
) -> Vec<[[&'f mut [f64]; D]; D]> {
    let mut rest = tensors
        .each_mut()
        .map(|row| row.each_mut().map(Vec::as_mut_slice));
    let part = |block: &Block| {
        let count = block.particles[1] - block.particles[0];
        rest.each_mut().map(|row| {
            row.each_mut().map(|rest| {
                let (part, left) = std::mem::take(rest).split_at_mut(count);
                *rest = left;
                part
            })
        })
    };
    blocks.iter().map(part).collect()
}

/// The deformation gradients of up to so many particles as vectors hold; what fills up is the reference state.
fn states<const D: usize>(
    transverse: &DeformationGradient,
    f: &[[&[f64]; D]; D],
    place: usize,
    count: usize,
) -> DeformationGradient<Lanes> {
    let fixed = transverse.components();
    DeformationGradient::from_components(std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if i >= D || j >= D {
                return Lanes([fixed[i][j]; LANES]);
            }
            let mut lanes = [if i == j { 1.0 } else { 0.0 }; LANES];
            lanes[..count].copy_from_slice(&f[i][j][place..place + count]);
            Lanes(lanes)
        })
    }))
}

/// `P(F_I)` of the particles of a block; tells the first one without.
fn stress<const D: usize>(
    material: &dyn Hyperelastic,
    transverse: &DeformationGradient,
    f: &[[&mut [f64]; D]; D],
    t: &mut [[&mut [f64]; D]; D],
) -> Option<usize> {
    let f = f.each_ref().map(|row| row.each_ref().map(|own| &**own));
    let total = f[0][0].len();
    let mut lost = None;
    for place in (0..total).step_by(LANES) {
        let count = LANES.min(total - place);
        let response = material.lane_stress(&states(transverse, &f, place, count), D);
        for i in 0..D {
            for j in 0..D {
                t[i][j][place..place + count]
                    .copy_from_slice(&response.first_piola[i][j].0[..count]);
            }
        }
        let is_lost = |lane: &usize| {
            let stresses = response.first_piola.as_flattened().iter();
            !stresses
                .chain([&response.energy])
                .all(|own| own.0[*lane].is_finite())
        };
        lost = lost.or_else(|| (0..count).find(is_lost).map(|lane| place + lane));
    }
    lost
}

/// `F_I` of the particles of a block.
struct Strained<'s, 'f, const D: usize> {
    links: &'s Links<D>,
    block: &'s Block,
    u: &'s [&'s [f64]; D],
    f: &'s mut [[&'f mut [f64]; D]; D],
}

impl<const D: usize> WithSimd for Strained<'_, '_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for run in &self.links.runs[self.block.runs[0]..self.block.runs[1]] {
            let count = run.count as usize;
            let mut offset = 0;
            while offset < count {
                offset += match is_wide(count - offset) {
                    true => self.strain(Wide(simd), run, offset),
                    false => self.strain(Single, run, offset),
                };
            }
        }
    }
}

/// Whether so many particles are worth a vector.
#[inline(always)]
fn is_wide(left: usize) -> bool {
    left > 2
}

// Closures would not be compiled for the vectors of the machine here: loops it is.
impl<const D: usize> Strained<'_, '_, D> {
    #[inline(always)]
    fn strain<V: Vectors>(&mut self, v: V, run: &Run<D>, offset: usize) -> usize {
        let links = self.links;
        let place = run.first as usize + offset;
        let zero = v.splat(0.0);
        let mut own = [zero; D];
        for i in 0..D {
            own[i] = v.load(self.u[i], place);
        }
        let mut sum = [[zero; D]; D];
        for pair in &links.pairs[run.pairs[0] as usize..run.pairs[1] as usize] {
            let kind = &links.kinds[pair.kind as usize];
            let other = pair.other as usize + offset;
            for i in 0..D {
                let apart = v.sub(v.load(self.u[i], other), own[i]);
                for j in 0..D {
                    sum[i][j] = v.add(sum[i][j], v.mul(apart, v.splat(kind.a[j])));
                }
            }
        }
        let first = place - self.block.particles[0];
        let end = first + V::WIDTH.min(run.count as usize - offset);
        for i in 0..D {
            for j in 0..D {
                let mut f = v.splat(if i == j { 1.0 } else { 0.0 });
                for k in 0..D {
                    f = v.add(f, v.mul(sum[i][k], v.splat(run.correction[k][j])));
                }
                v.store(f, &mut self.f[i][j][first..end]);
            }
        }
        V::WIDTH
    }
}

/// `T_I = P_I K_I^-T` in the place of `P_I`.
struct Corrected<'s, 'f, const D: usize> {
    links: &'s Links<D>,
    block: &'s Block,
    t: &'s mut [[&'f mut [f64]; D]; D],
}

impl<const D: usize> NullaryFnOnce for Corrected<'_, '_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for run in &self.links.runs[self.block.runs[0]..self.block.runs[1]] {
            let first = run.first as usize - self.block.particles[0];
            for place in first..first + run.count as usize {
                for row in self.t.iter_mut() {
                    let mut p = [0.0; D];
                    for k in 0..D {
                        p[k] = row[k][place];
                    }
                    for j in 0..D {
                        let mut t = 0.0;
                        for k in 0..D {
                            t += p[k] * run.correction[j][k];
                        }
                        row[j][place] = t;
                    }
                }
            }
        }
    }
}

/// The velocities of the particles of a block, kicked.
struct Kicked<'s, 'f, const D: usize> {
    links: &'s Links<D>,
    block: &'s Block,
    u: &'s [&'s [f64]; D],
    f: &'s [[&'s [f64]; D]; D],
    t: &'s [[&'s [f64]; D]; D],
    offsets: [f64; 2],
    /// `dt / rho0`.
    factor: f64,
    v: &'s mut [&'f mut [f64]; D],
}

/// Without a penalty.
const WITHOUT: u8 = 0;
/// The penalty as it was published.
const PUBLISHED: u8 = 1;
/// With lengths added in its denominators.
const OFFSET: u8 = 2;

/// The same under one form of the penalty.
struct Under<'s, 'f, const D: usize, const FORM: u8>(Kicked<'s, 'f, D>);

impl<const D: usize, const FORM: u8> WithSimd for Under<'_, '_, D, FORM> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let own = &mut self.0;
        for run in &own.links.runs[own.block.runs[0]..own.block.runs[1]] {
            let count = run.count as usize;
            let mut offset = 0;
            while offset < count {
                offset += match is_wide(count - offset) {
                    true => own.kick::<_, FORM>(Wide(simd), run, offset),
                    false => own.kick::<_, FORM>(Single, run, offset),
                };
            }
        }
    }
}

impl<const D: usize> Kicked<'_, '_, D> {
    #[inline(always)]
    fn kick<V: Vectors, const FORM: u8>(&mut self, v: V, run: &Run<D>, offset: usize) -> usize {
        let links = self.links;
        let place = run.first as usize + offset;
        let zero = v.splat(0.0);
        let mut t = [[zero; D]; D];
        let mut f = [[zero; D]; D];
        let mut u = [zero; D];
        for i in 0..D {
            u[i] = v.load(self.u[i], place);
            for j in 0..D {
                t[i][j] = v.load(self.t[i][j], place);
                if FORM != WITHOUT {
                    f[i][j] = v.load(self.f[i][j], place);
                }
            }
        }
        let mut sum = [zero; D];
        for pair in &links.pairs[run.pairs[0] as usize..run.pairs[1] as usize] {
            let kind = &links.kinds[pair.kind as usize];
            let other = pair.other as usize + offset;
            for i in 0..D {
                for j in 0..D {
                    let both = v.add(t[i][j], v.load(self.t[i][j], other));
                    sum[i] = v.add(sum[i], v.mul(both, v.splat(kind.a[j])));
                }
            }
            if FORM == WITHOUT {
                continue;
            }
            // x_IJ, and (F_I + F_J) X_IJ - 2 x_IJ.
            let mut x = [zero; D];
            let mut missed = [zero; D];
            for i in 0..D {
                let apart = v.sub(v.load(self.u[i], other), u[i]);
                x[i] = v.add(apart, v.splat(kind.x[i]));
                missed[i] = v.mul(x[i], v.splat(-2.0));
                for j in 0..D {
                    let both = v.add(f[i][j], v.load(self.f[i][j], other));
                    missed[i] = v.add(missed[i], v.mul(both, v.splat(kind.x[j])));
                }
            }
            let mut squared = zero;
            let mut along = zero;
            for i in 0..D {
                squared = v.add(squared, v.mul(x[i], x[i]));
                along = v.add(along, v.mul(missed[i], x[i]));
            }
            if FORM == OFFSET {
                let length = v.sqrt(squared);
                let (first, second) = (v.splat(self.offsets[0]), v.splat(self.offsets[1]));
                squared = v.mul(v.add(length, first), v.add(length, second));
            }
            let along = v.mul(v.div(along, squared), v.splat(kind.stiffness));
            for i in 0..D {
                sum[i] = v.sub(sum[i], v.mul(x[i], along));
            }
        }
        let first = place - self.block.particles[0];
        let end = first + V::WIDTH.min(run.count as usize - offset);
        for i in 0..D {
            let mut more = [0.0; LANES];
            v.store(v.mul(sum[i], v.splat(self.factor)), &mut more[..V::WIDTH]);
            for (to, more) in self.v[i][first..end].iter_mut().zip(more) {
                *to += more;
            }
        }
        V::WIDTH
    }
}
