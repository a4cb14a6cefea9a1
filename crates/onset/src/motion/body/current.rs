//! Densities, stresses, accelerations and velocity gradients of particles with changing neighbors.
//!
//! Each particle sums over its neighbors in the order of their numbers. Eight consecutive particles are computed together, and blocks of them in
//! parallel on all cores. Contributions of particles beyond the support are exactly zero. The results are therefore bitwise independent of the time
//! of the neighbor search and of the number of cores.

use super::neighborhoods::{Look, Neighborhoods, PADDING_COORDINATE, Seen, number, tensor, vector};
use super::parts::{field_parts, tensor_parts};
use super::vectors::{
    Component, Field, Tensors, are_finite, slices, states, vector_of, zero_tensors,
};
use crate::algebra::{Each, array_of};
use crate::approximation::SingularMoment;
use crate::cores::of_each;
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::{LANES, Lanes, Real, Work};
use crate::scheme::sph::{CurrentPairs, Laden, correction};
use crate::scheme::{NoForce, determinant, inverse};
use std::marker::PhantomData;

/// Number of particles that one core computes at a time.
const BLOCK: usize = 16 * LANES;

type Vector<const D: usize> = [Lanes; D];
type Tensor<const D: usize> = [[Lanes; D]; D];

/// State of the particles for forces and velocity gradients. The last group of particles is padded.
pub(super) struct CurrentEngine<'a, const D: usize> {
    pub(super) material: &'a dyn Hyperelastic,
    /// Pair forces with the kernels of the initial state of the body.
    law: Result<CurrentPairs<D>, MethodError>,
    /// Deformation gradient of this initial state.
    pub(super) base: DeformationGradient,
    density: f64,
    /// Reference volumes; length^D.
    volumes: Component,
    /// Deformation gradients `F_I` of the particles.
    pub(super) deformations: Tensors<D>,
    /// Positions in the reference configuration; length.
    pub(super) positions: Field<D>,
    /// Current positions of the particles; length.
    pub(super) places: Field<D>,
    neighborhoods: Neighborhoods<D>,
    densities: Component,
    /// Current volumes `m / rho`, and a buffer for their next values.
    spreads: Component,
    later: Component,
    /// Contributions of the particles to pair forces, as in [`Laden`].
    reaches: Component,
    tensions: Tensors<D>,
    /// Tensile parts, if there is an artificial stress.
    tensile: Option<Tensors<D>>,
    /// `K_I^-1`, if forces are corrected.
    corrections: Option<Tensors<D>>,
    pub(super) count: usize,
}

fn lost(particle: usize) -> NoForce {
    NoForce {
        particle,
        source: None,
    }
}

#[inline(always)]
fn times<const D: usize>(a: &Tensor<D>, b: &Tensor<D>) -> Tensor<D> {
    let mut product = [[Lanes::constant(0.0); D]; D];
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                product[i][j] = product[i][j] + a[i][k] * b[k][j];
            }
        }
    }
    product
}

/// Adds a dyadic product, `S + a (x) b`.
#[inline(always)]
fn add_product<const D: usize>(sum: &mut Tensor<D>, a: &Vector<D>, b: &Vector<D>) {
    for i in 0..D {
        for j in 0..D {
            sum[i][j] = sum[i][j] + a[i] * b[j];
        }
    }
}

/// Returns `V_J grad W_IJ` with respect to `x_I`, the negative of the gradient along `x_J - x_I`.
#[inline(always)]
fn spread_slope<const D: usize>(spreads: &[f64], other: &Seen<D>) -> Vector<D> {
    let spread = -number(spreads, other.place);
    other.weight.gradient.each(|slope| slope * spread)
}

/// Returns the tensor `1 + factor L`.
#[inline(always)]
fn stepped<const D: usize>(l: &Tensor<D>, factor: f64) -> Tensor<D> {
    array_of(|i| array_of(|j| l[i][j] * factor + if i == j { 1.0 } else { 0.0 }))
}

/// Group of consecutive particles. The last group may have fewer.
#[derive(Clone, Copy)]
struct Group {
    /// Number of the first particle.
    own: usize,
    /// Position of the group in the block.
    place: usize,
    /// Number of particles in the group.
    len: usize,
}

impl Group {
    /// Writes numbers into a block, padded with the number `beyond`.
    #[inline(always)]
    fn put(&self, block: &mut [f64], numbers: Lanes, beyond: f64) {
        let own = &mut block[self.place..self.place + LANES];
        own.copy_from_slice(&numbers.0);
        own[self.len..].fill(beyond);
    }

    #[inline(always)]
    fn put_vector<const D: usize>(&self, block: &mut [&mut [f64]; D], vector: &Vector<D>) {
        for (block, own) in block.iter_mut().zip(vector) {
            self.put(block, *own, 0.0);
        }
    }

    #[inline(always)]
    fn put_tensor<const D: usize>(&self, block: &mut [[&mut [f64]; D]; D], tensor: &Tensor<D>) {
        for (block, own) in block.iter_mut().zip(tensor) {
            self.put_vector(block, own);
        }
    }
}

/// Groups of a block, given the number of the block and the number of all particles.
fn groups(number: usize, count: usize) -> impl Iterator<Item = Group> {
    let first = number * BLOCK;
    let all = (first..count.min(first + BLOCK)).step_by(LANES);
    all.map(move |own| Group {
        own,
        place: own - first,
        len: LANES.min(count - own),
    })
}

/// Sums over the neighbors of all particles. Trait methods are used instead of closures, so that they compile to vector instructions.
trait Sums<const D: usize>: Sync {
    /// Sum for one group of particles.
    type Sum;
    /// Storage for the sums of a block.
    type Block: Send;

    fn begin(&self, own: usize) -> Self::Sum;
    fn add(&self, sum: &mut Self::Sum, other: &Seen<D>);
    fn leave(&self, sum: Self::Sum, group: &Group, block: &mut Self::Block) -> Result<(), NoForce>;
}

/// Sum over the neighbors of one group.
struct OfGroup<'s, S: Sums<D>, const D: usize> {
    sums: &'s S,
    group: Group,
    seen: &'s [Seen<D>],
    block: &'s mut S::Block,
}

impl<S: Sums<D>, const D: usize> Work for OfGroup<'_, S, D> {
    type Output = Result<(), NoForce>;

    #[inline(always)]
    fn done(self) -> Self::Output {
        let mut sum = self.sums.begin(self.group.own);
        for other in self.seen {
            self.sums.add(&mut sum, other);
        }
        self.sums.leave(sum, &self.group, self.block)
    }
}

/// Particles at their positions, with their neighbors.
#[derive(Clone, Copy)]
struct Around<'s, const D: usize> {
    law: &'s CurrentPairs<D>,
    neighborhoods: &'s Neighborhoods<D>,
    places: [&'s [f64]; D],
    count: usize,
}

impl<const D: usize> Around<'_, D> {
    /// Computes the sums over the neighbors of all particles and stores the results in blocks. The error belongs to the first particle without a
    /// result.
    fn sum<S: Sums<D>>(&self, sums: &S, blocks: Vec<S::Block>) -> Result<(), NoForce> {
        let measure = self.law.measure();
        let blocks = blocks.into_iter().enumerate().collect();
        let done = of_each(blocks, |(number, mut block)| {
            let mut seen = Vec::new();
            groups(number, self.count).try_for_each(|group| {
                Lanes::vectorized(Look {
                    law: self.law,
                    measure: &measure,
                    neighborhoods: self.neighborhoods,
                    places: &self.places,
                    own: group.own,
                    seen: &mut seen,
                });
                Lanes::vectorized(OfGroup {
                    sums,
                    group,
                    seen: &seen,
                    block: &mut block,
                })
            })
        });
        done.into_iter().collect()
    }

    /// Correction matrices `K_I^-1` of a group.
    fn corrections(&self, group: &Group, moment: &Tensor<D>) -> Result<Tensor<D>, NoForce> {
        let mut all = [[Lanes::constant(0.0); D]; D];
        for lane in 0..group.len {
            let own = moment.each(|row| row.each(|entry| entry.0[lane]));
            let inverse = correction(&own).map_err(|condition| NoForce {
                particle: group.own + lane,
                source: Some(MethodError::SingularMoment {
                    point: "particle",
                    neighbors: self.neighbors(group.own + lane),
                    source: SingularMoment { condition },
                }),
            })?;
            for i in 0..D {
                for j in 0..D {
                    all[i][j].0[lane] = inverse[i][j];
                }
            }
        }
        Ok(all)
    }

    /// Number of neighbors of a particle.
    fn neighbors(&self, particle: usize) -> usize {
        let measure = self.law.measure();
        let apart = |other| array_of(|i| self.places[i][other] - self.places[i][particle]);
        let is_seen = |n: &usize| *n != particle && measure.of(&apart(*n)).squared < 1.0;
        (0..self.count).filter(is_seen).count()
    }
}

/// Densities `sum_J m_J W_IJ` of the particles.
struct Densities<'s> {
    volumes: &'s [f64],
    density: f64,
    /// Weight `W` at zero distance.
    at_itself: f64,
}

impl Densities<'_> {
    #[inline(always)]
    fn mass(&self, place: usize) -> Lanes {
        number(self.volumes, place) * self.density
    }
}

impl<'s, const D: usize> Sums<D> for Densities<'s> {
    type Sum = Lanes;
    type Block = &'s mut [f64];

    #[inline(always)]
    fn begin(&self, own: usize) -> Lanes {
        self.mass(own) * self.at_itself
    }

    #[inline(always)]
    fn add(&self, sum: &mut Lanes, other: &Seen<D>) {
        *sum = *sum + other.weight.value * self.mass(other.place);
    }

    #[inline(always)]
    fn leave(&self, sum: Lanes, group: &Group, block: &mut Self::Block) -> Result<(), NoForce> {
        group.put(block, sum, 1.0);
        Ok(())
    }
}

/// Velocity gradients `L_I = sum_J V_J (w_J - w_I) (x) grad W_IJ K_I^-1`, and the quantity that is stored for each particle.
struct Gradients<'s, L, const D: usize, const CORRECTED: bool> {
    around: Around<'s, D>,
    /// Current volumes `V` of the particles.
    spreads: &'s [f64],
    w: [&'s [f64]; D],
    left: L,
}

/// Sum for `L_I`, and `K_I = sum_J V_J x_IJ (x) grad W_IJ` if gradients are corrected.
struct Gradient<const D: usize> {
    /// Velocities `w_I` of the group.
    own: Vector<D>,
    sum: Tensor<D>,
    moment: Tensor<D>,
}

/// Quantity computed from a velocity gradient and stored.
trait Left<const D: usize>: Sync {
    type Block: Send;

    fn leave(&self, l: &Tensor<D>, group: &Group, block: &mut Self::Block);
}

impl<L: Left<D>, const D: usize, const CORRECTED: bool> Sums<D> for Gradients<'_, L, D, CORRECTED> {
    type Sum = Gradient<D>;
    type Block = L::Block;

    #[inline(always)]
    fn begin(&self, own: usize) -> Gradient<D> {
        let zero = [[Lanes::constant(0.0); D]; D];
        Gradient {
            own: vector(&self.w, own),
            sum: zero,
            moment: zero,
        }
    }

    #[inline(always)]
    fn add(&self, sum: &mut Gradient<D>, other: &Seen<D>) {
        let along = spread_slope(self.spreads, other);
        let mut apart = vector(&self.w, other.place);
        for i in 0..D {
            apart[i] = apart[i] - sum.own[i];
        }
        add_product(&mut sum.sum, &apart, &along);
        if CORRECTED {
            add_product(&mut sum.moment, &other.x, &along);
        }
    }

    #[inline(always)]
    fn leave(&self, sum: Gradient<D>, group: &Group, block: &mut L::Block) -> Result<(), NoForce> {
        let l = match CORRECTED {
            false => sum.sum,
            true => times(&sum.sum, &self.around.corrections(group, &sum.moment)?),
        };
        self.left.leave(&l, group, block);
        Ok(())
    }
}

/// Correction matrices `K_I^-1` of the forces.
struct Corrections<'s, const D: usize> {
    around: Around<'s, D>,
    /// Current volumes `V` of the particles.
    spreads: &'s [f64],
}

impl<'s, const D: usize> Sums<D> for Corrections<'s, D> {
    type Sum = Tensor<D>;
    type Block = [[&'s mut [f64]; D]; D];

    #[inline(always)]
    fn begin(&self, _: usize) -> Tensor<D> {
        [[Lanes::constant(0.0); D]; D]
    }

    #[inline(always)]
    fn add(&self, moment: &mut Tensor<D>, other: &Seen<D>) {
        add_product(moment, &other.x, &spread_slope(self.spreads, other));
    }

    #[inline(always)]
    fn leave(
        &self,
        moment: Tensor<D>,
        group: &Group,
        block: &mut Self::Block,
    ) -> Result<(), NoForce> {
        group.put_tensor(block, &self.around.corrections(group, &moment)?);
        Ok(())
    }
}

/// Volumes after a time, `V exp(dt tr L)`.
struct Grown<'s> {
    spreads: &'s [f64],
    time: f64,
}

impl<'s, const D: usize> Left<D> for Grown<'s> {
    type Block = &'s mut [f64];

    #[inline(always)]
    fn leave(&self, l: &Tensor<D>, group: &Group, block: &mut Self::Block) {
        let mut rate = l[0][0];
        for (i, row) in l.iter().enumerate().skip(1) {
            rate = rate + row[i];
        }
        let grown = number(self.spreads, group.own) * (rate * self.time).exp();
        group.put(block, grown, 0.0);
    }
}

/// Deformation gradients after a step, `F' = (1 - b L)^-1 (1 + a L) F`.
struct Carried<'s> {
    forth: f64,
    back: f64,
    blocks: PhantomData<&'s mut [f64]>,
}

impl<'s, const D: usize> Left<D> for Carried<'s> {
    type Block = [[&'s mut [f64]; D]; D];

    #[inline(always)]
    fn leave(&self, l: &Tensor<D>, group: &Group, block: &mut Self::Block) {
        let mut f = *l;
        for i in 0..D {
            for j in 0..D {
                f[i][j] = number(block[i][j], group.place);
            }
        }
        let half = times(&stepped(l, self.forth), &f);
        let next = times(&inverse(&stepped(l, -self.back)), &half);
        for i in 0..D {
            for j in 0..D {
                // The padding keeps its values.
                let block = &mut block[i][j][group.place..group.place + group.len];
                block.copy_from_slice(&next[i][j].0[..group.len]);
            }
        }
    }
}

/// Current data of all particles.
#[derive(Clone, Copy)]
struct Fields<'s, const D: usize> {
    law: &'s CurrentPairs<D>,
    density: f64,
    volumes: &'s [f64],
    densities: &'s [f64],
    reaches: &'s [f64],
    tensions: [[&'s [f64]; D]; D],
    tensile: Option<[[&'s [f64]; D]; D]>,
    v: [&'s [f64]; D],
}

impl<const D: usize> Fields<'_, D> {
    #[inline(always)]
    fn mass(&self, place: usize) -> Lanes {
        number(self.volumes, place) * self.density
    }

    #[inline(always)]
    fn laden(&self, place: usize) -> Laden<Lanes, D> {
        Laden {
            reach: number(self.reaches, place),
            tension: tensor(&self.tensions, place),
            tensile: self.tensile.as_ref().map(|own| tensor(own, place)),
        }
    }
}

/// Accelerations `f_I / m_I` of the particles.
struct Accelerations<'s, const D: usize>(Fields<'s, D>);

/// Sums `sum_J r_J grad W_IJ` and `sum_J T_J grad W_IJ` of the stresses, and the viscous force.
struct Force<const D: usize> {
    mass: Lanes,
    density: Lanes,
    v: Vector<D>,
    slopes: [Vector<D>; 2],
    traction: Vector<D>,
    viscous: Vector<D>,
}

impl<'s, const D: usize> Sums<D> for Accelerations<'s, D> {
    type Sum = Force<D>;
    type Block = [&'s mut [f64]; D];

    #[inline(always)]
    fn begin(&self, own: usize) -> Force<D> {
        let zero = [Lanes::constant(0.0); D];
        Force {
            mass: self.0.mass(own),
            density: number(self.0.densities, own),
            v: vector(&self.0.v, own),
            slopes: [zero; 2],
            traction: zero,
            viscous: zero,
        }
    }

    #[inline(always)]
    fn add(&self, sum: &mut Force<D>, other: &Seen<D>) {
        let Fields { law, .. } = self.0;
        let laden = self.0.laden(other.place);
        let slopes = law.slopes(&other.weight);
        let traction = laden.traction(&slopes);
        for i in 0..D {
            sum.slopes[0][i] = sum.slopes[0][i] + slopes[0][i] * laden.reach;
            sum.traction[i] = sum.traction[i] + traction[i];
        }
        if law.is_tensile() {
            for i in 0..D {
                sum.slopes[1][i] = sum.slopes[1][i] + slopes[1][i] * laden.reach;
            }
        }
        if law.is_viscous() {
            let mut apart = vector(&self.0.v, other.place);
            for i in 0..D {
                apart[i] = apart[i] - sum.v[i];
            }
            let masses = [sum.mass, self.0.mass(other.place)];
            let densities = [sum.density, number(self.0.densities, other.place)];
            let viscous = law.viscous_force(&other.x, &apart, &other.weight, masses, densities);
            for i in 0..D {
                sum.viscous[i] = sum.viscous[i] + viscous[i];
            }
        }
    }

    #[inline(always)]
    fn leave(&self, sum: Force<D>, group: &Group, block: &mut Self::Block) -> Result<(), NoForce> {
        let laden = self.0.laden(group.own);
        let mut a = self.0.law.taken(laden.traction(&sum.slopes));
        for i in 0..D {
            a[i] = (a[i] + sum.traction[i] * laden.reach + sum.viscous[i]) / sum.mass;
        }
        group.put_vector(block, &a);
        Ok(())
    }
}

/// Smoothed velocities of the particles, `v_I + sum_J epsilon m_J / rho_IJ W_IJ (v_J - v_I)`.
struct Smoothed<'s, const D: usize>(Fields<'s, D>);

/// Partial sum of the smoothed velocities of a group.
struct Smoothing<const D: usize> {
    density: Lanes,
    v: Vector<D>,
    sum: Vector<D>,
}

impl<'s, const D: usize> Sums<D> for Smoothed<'s, D> {
    type Sum = Smoothing<D>;
    type Block = [&'s mut [f64]; D];

    #[inline(always)]
    fn begin(&self, own: usize) -> Smoothing<D> {
        let v = vector(&self.0.v, own);
        Smoothing {
            density: number(self.0.densities, own),
            v,
            sum: v,
        }
    }

    #[inline(always)]
    fn add(&self, sum: &mut Smoothing<D>, other: &Seen<D>) {
        let Fields { law, .. } = self.0;
        let densities = [sum.density, number(self.0.densities, other.place)];
        let mass = self.0.mass(other.place);
        let share = law.smoothing_share(mass, densities, other.weight.value);
        let v = vector(&self.0.v, other.place);
        for i in 0..D {
            sum.sum[i] = sum.sum[i] + (v[i] - sum.v[i]) * share;
        }
    }

    #[inline(always)]
    fn leave(
        &self,
        sum: Smoothing<D>,
        group: &Group,
        block: &mut Self::Block,
    ) -> Result<(), NoForce> {
        group.put_vector(block, &sum.sum);
        Ok(())
    }
}

impl<'a, const D: usize> CurrentEngine<'a, D> {
    pub(super) fn new(
        material: &'a dyn Hyperelastic,
        law: CurrentPairs<D>,
        density: f64,
        positions: &[[f64; D]],
        mut volumes: Vec<f64>,
    ) -> Self {
        let count = volumes.len();
        volumes.resize(count.next_multiple_of(LANES), 0.0);
        let mut all: Field<D> = std::array::from_fn(|_| vec![PADDING_COORDINATE; volumes.len()]);
        for (n, x) in positions.iter().enumerate() {
            (0..D).for_each(|i| all[i][n] = x[i]);
        }
        let mut engine = Self {
            material,
            law: Ok(law),
            base: DeformationGradient::identity(),
            density,
            deformations: zero_tensors(count),
            places: all.clone(),
            positions: all,
            neighborhoods: Neighborhoods::new(),
            densities: vec![1.0; volumes.len()],
            spreads: vec![0.0; volumes.len()],
            later: vec![0.0; volumes.len()],
            reaches: vec![0.0; volumes.len()],
            tensions: zero_tensors(count),
            tensile: None,
            corrections: None,
            volumes,
            count,
        };
        engine.deform(&DeformationGradient::identity());
        engine
    }

    pub(super) fn law(&self) -> Result<&CurrentPairs<D>, NoForce> {
        self.law.as_ref().map_err(|source| NoForce {
            particle: 0,
            source: Some(source.clone()),
        })
    }

    /// Replaces the kernels, or stores the error if they cannot be computed.
    pub(super) fn settle(&mut self, law: Result<CurrentPairs<D>, MethodError>) {
        self.law = law;
        self.neighborhoods = Neighborhoods::new();
    }

    /// Sets the deformation gradient of all particles.
    pub(super) fn deform(&mut self, f: &DeformationGradient) {
        self.base = *f;
        let f = f.components();
        for i in 0..D {
            for j in 0..D {
                self.deformations[i][j].fill(f[i][j]);
            }
        }
    }

    pub(super) fn mass(&self, particle: usize) -> f64 {
        self.density * self.volumes[particle]
    }

    /// Deformation gradient `F_I` of a particle.
    pub(super) fn deformation(&self, particle: usize) -> [[f64; D]; D] {
        array_of(|i| vector_of(&self.deformations[i], particle))
    }

    fn around(&self) -> Result<Around<'_, D>, NoForce> {
        Ok(Around {
            law: self.law()?,
            neighborhoods: &self.neighborhoods,
            places: self.places.each_ref().map(Vec::as_slice),
            count: self.count,
        })
    }

    fn fields<'s>(&'s self, v: &'s Field<D>) -> Result<Fields<'s, D>, NoForce> {
        Ok(Fields {
            law: self.law()?,
            density: self.density,
            volumes: &self.volumes,
            densities: &self.densities,
            reaches: &self.reaches,
            tensions: slices(&self.tensions),
            tensile: self.tensile.as_ref().map(slices),
            v: v.each_ref().map(Vec::as_slice),
        })
    }

    /// Moves the particles to their displaced positions and updates neighbors and densities.
    pub(super) fn place(&mut self, u: &Field<D>) -> Result<(), NoForce> {
        for (place, (x, u)) in self.places.iter_mut().zip(self.positions.iter().zip(u)) {
            for (place, (x, u)) in place.iter_mut().zip(x.iter().zip(u)) {
                *place = x + u;
            }
        }
        self.look()
    }

    /// Updates neighbors and densities at the current positions.
    pub(super) fn look(&mut self) -> Result<(), NoForce> {
        if !self.places.iter().all(|x| are_finite(x)) {
            let is_lost = |n: &usize| !are_finite(&vector_of(&self.places, *n));
            let particle = (0..self.count).find(is_lost).unwrap_or_default();
            return Err(lost(particle));
        }
        let law = self.law()?.clone();
        self.neighborhoods.find(&law, &self.places, self.count);
        let mut densities = std::mem::take(&mut self.densities);
        let found = self.measure(&mut densities);
        self.densities = densities;
        found?;
        let both = self.volumes.iter().zip(&self.densities);
        for (spread, (volume, density)) in self.spreads.iter_mut().zip(both) {
            *spread = volume * self.density / density;
        }
        Ok(())
    }

    fn measure(&self, densities: &mut [f64]) -> Result<(), NoForce> {
        let law = self.law()?;
        if !law.sums_densities() {
            let f = slices(&self.deformations);
            for (place, own) in densities.chunks_mut(LANES).enumerate() {
                let volume = determinant(&tensor(&f, place * LANES));
                own.copy_from_slice(&(volume.recip() * law.reference_density()).0);
            }
            return Ok(());
        }
        let sums = Densities {
            volumes: &self.volumes,
            density: self.density,
            at_itself: law.weigh(&[0.0; D]).value,
        };
        let blocks = densities.chunks_mut(BLOCK).collect();
        self.around()?.sum(&sums, blocks)
    }

    /// Computes the stresses and their contributions to pair forces.
    pub(super) fn stress(&mut self) -> Result<(), NoForce> {
        let law = self.law()?.clone();
        let count = self.count;
        if law.is_tensile() {
            self.tensile.get_or_insert_with(|| zero_tensors(count));
        }
        self.correct()?;
        let Self {
            material,
            base,
            deformations,
            densities,
            volumes,
            density,
            reaches,
            tensions,
            tensile,
            corrections,
            ..
        } = self;
        let f = slices(deformations);
        let corrections = corrections.as_ref().map(slices);
        let mut tensile = tensile
            .as_mut()
            .map(|own| tensor_parts(own, BLOCK).into_iter());
        let blocks: Vec<_> = tensor_parts(tensions, BLOCK)
            .into_iter()
            .zip(reaches.chunks_mut(BLOCK))
            .map(|own| (own, tensile.as_mut().and_then(Iterator::next)))
            .enumerate()
            .collect();
        let stressed = of_each(blocks, |(block, ((mut tensions, reaches), mut tensile))| {
            groups(block, count).try_for_each(|group| {
                let response = material.lane_stress(&states(base, &f, group.own), D);
                let f = tensor(&f, group.own);
                let volume = determinant(&f);
                let is_lost = |lane: &usize| !(response.is_known(*lane) && volume.0[*lane] > 0.0);
                if let Some(lane) = (0..group.len).find(is_lost) {
                    return Err(lost(group.own + lane));
                }
                let p: Tensor<D> = array_of(|i| array_of(|j| response.first_piola[i][j]));
                let transposed: Tensor<D> = array_of(|i| array_of(|j| f[j][i]));
                let stress = times(&p, &transposed);
                let stress = stress.each(|row| row.each(|entry| entry / volume));
                let mass = number(volumes, group.own) * *density;
                let density = number(densities, group.own);
                let tensile_part = law.tensile_of_each(&stress);
                let along = match &corrections {
                    None => stress,
                    Some(corrections) => {
                        let own = tensor(corrections, group.own);
                        times(&stress, &array_of(|i| array_of(|j| own[j][i])))
                    }
                };
                let laden = law.laden(mass, density, &along, tensile_part);
                group.put(reaches, laden.reach, 0.0);
                group.put_tensor(&mut tensions, &laden.tension);
                if let (Some(block), Some(own)) = (&mut tensile, &laden.tensile) {
                    group.put_tensor(block, own);
                }
                Ok(())
            })
        });
        stressed.into_iter().collect()
    }

    /// Computes the correction of the forces, if they are corrected.
    fn correct(&mut self) -> Result<(), NoForce> {
        if !self.law()?.corrects_forces() {
            return Ok(());
        }
        let mut corrections = self.corrections.take();
        let count = self.count;
        let all = corrections.get_or_insert_with(|| zero_tensors(count));
        let around = self.around()?;
        let sums = Corrections {
            around,
            spreads: &self.spreads,
        };
        let done = around.sum(&sums, tensor_parts(all, BLOCK));
        self.corrections = corrections;
        done
    }

    /// Accelerations from the current stresses and from viscosity.
    pub(super) fn accelerations(&self, v: &Field<D>, a: &mut Field<D>) -> Result<(), NoForce> {
        let sums = Accelerations(self.fields(v)?);
        self.around()?.sum(&sums, field_parts(a, BLOCK))
    }

    /// Smoothed velocities of XSPH.
    pub(super) fn smooth(&self, v: &Field<D>, smoothed: &mut Field<D>) -> Result<(), NoForce> {
        let sums = Smoothed(self.fields(v)?);
        self.around()?.sum(&sums, field_parts(smoothed, BLOCK))
    }

    /// Updates the deformation gradients after a small displacement: `F' = (1 + factor L) F`.
    pub(super) fn strain(&mut self, w: &Field<D>, factor: f64) -> Result<(), NoForce> {
        self.carry(w, factor, 0.0)
    }

    /// Updates the deformation gradients after a step, from the positions at its midpoint: `F' = (1 - dt/2 L)^-1 (1 + dt/2 L) F`.
    pub(super) fn advance(&mut self, w: &Field<D>, step: f64) -> Result<(), NoForce> {
        if !self.law()?.sums_densities() {
            // Volumes from deformation gradients belong to the start of the step and are advanced by half a step.
            let mut later = std::mem::take(&mut self.later);
            let grown = Grown {
                spreads: &self.spreads,
                time: 0.5 * step,
            };
            let done = self.gradients(w, grown, later.chunks_mut(BLOCK).collect());
            self.later = std::mem::replace(&mut self.spreads, later);
            done?;
        }
        self.carry(w, 0.5 * step, 0.5 * step)
    }

    /// Updates the deformation gradients: `F' = (1 - back L)^-1 (1 + forth L) F`.
    fn carry(&mut self, w: &Field<D>, forth: f64, back: f64) -> Result<(), NoForce> {
        let mut f = std::mem::replace(&mut self.deformations, zero_tensors(0));
        let carried = Carried {
            forth,
            back,
            blocks: PhantomData,
        };
        let done = self.gradients(w, carried, tensor_parts(&mut f, BLOCK));
        self.deformations = f;
        done
    }

    fn gradients<L: Left<D>>(
        &self,
        w: &Field<D>,
        left: L,
        blocks: Vec<L::Block>,
    ) -> Result<(), NoForce> {
        match self.law()?.is_corrected() {
            true => self.gradients_as::<L, true>(w, left, blocks),
            false => self.gradients_as::<L, false>(w, left, blocks),
        }
    }

    fn gradients_as<L: Left<D>, const CORRECTED: bool>(
        &self,
        w: &Field<D>,
        left: L,
        blocks: Vec<L::Block>,
    ) -> Result<(), NoForce> {
        let around = self.around()?;
        let sums = Gradients::<_, D, CORRECTED> {
            around,
            spreads: &self.spreads,
            w: w.each_ref().map(Vec::as_slice),
            left,
        };
        around.sum(&sums, blocks)
    }

    /// Strain energy `sum_I V_I W(F_I)` of the body.
    pub(super) fn energy(&self) -> f64 {
        let f = slices(&self.deformations);
        let mut sum = 0.0;
        for (group, volumes) in self.volumes[..self.count].chunks(LANES).enumerate() {
            let states = states(&self.base, &f, group * LANES);
            let energies = self.material.lane_stress(&states, D).energy;
            let both = volumes.iter().zip(&energies.0);
            sum += both.map(|(volume, energy)| volume * energy).sum::<f64>();
        }
        sum
    }

    /// Memory of the engine in use; bytes.
    pub(super) fn bytes(&self) -> usize {
        let kept = [&self.tensile, &self.corrections];
        let tensors = 2 + kept.into_iter().flatten().count();
        let numbers = tensors * D * D + 2 * D + 5;
        numbers * size_of_val(&*self.volumes) + self.neighborhoods.bytes()
    }
}
