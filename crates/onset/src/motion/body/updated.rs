//! Bodies of updated SPH, whose particles have changing neighbors.
//!
//! Each particle carries its deformation gradient, `dF_I/dt = L_I F_I`, with the velocity gradient of the method for the current neighbors,
//! `L_I = sum_J m_J / rho_J (w_J - w_I) (x) grad W_IJ K_I^-1` (`K = 1` for uncorrected gradients). The law gives the stress at `F_I`.
//! The stress depends only on `F_I`, so that a hyperelastic law needs no objective rate.
//!
//! With corrected gradients `L` is a spin for rigid rotations, and `F` rotates with the particles. With uncorrected gradients `L` is this spin times
//! `K`, which is not one at surfaces: rotations cause strains there.
//! For a particle without neighbors `L` is undefined, and `F` does not change.
//!
//! A step updates `F` with the gradient at its midpoint: `F' = (1 - dt/2 L)^-1 (1 + dt/2 L) F`. A spin gives an exact rotation. Particles that move
//! freely along straight lines, `x = (1 + A t) X`, give the exact `1 + A t` if gradients are corrected. The reason is that with `M` at the midpoint
//! `L = A M^-1`, and the factor is `(M + dt/2 A) (M - dt/2 A)^-1`, since `A` and `M` commute. About a homogeneous state without velocities a step
//! changes `F` by `sum_J dt v_J (x) g_J F`, like the forces of a patch: waves obey the linearized equations with their rates in discrete time.
//!
//! With the momentum form `mean`, densities by continuity and uncorrected gradients, the forces conserve the sum of kinetic and strain energy:
//! `d/dt sum_I V_I0 W(F_I) = sum_I V_I s_I : L_I = sum_IJ V_I V_J (v_J - v_I).s_I grad W_IJ = -sum_I f_I.v_I`. Other choices have no potential.

use super::contact::Contact;
use super::current::CurrentEngine;
use super::grip::{Grip, held, hold, work_of};
use super::moving::{BodyMotion, Start};
use super::neighbors::Neighbors;
use super::parts::drift;
use super::quantities::in_space;
use super::shape::placed;
use super::stability::{DIFFERENCE_STEP, largest_eigenvalue};
use super::vectors::{Field, are_finite, fill, flat, negative, put, vector_of, zeros};
use super::{BodyError, BodyParticles, BodyQuantities};
use crate::algebra::{array_of, uniform};
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::motion::{Fault, Ground, PatchState};
use crate::scheme::sph::CurrentPairs;
use crate::scheme::{Discretization, NoForce};
use crate::time_step::Oscillation;
use nalgebra::SMatrix;

/// Distance, as a fraction of the support, within which two particles coincide.
const COINCIDENCE_DISTANCE: f64 = 1e-9;

/// Body of updated SPH in motion.
struct UpdatedBody<'a, const D: usize> {
    discretization: &'a dyn Discretization<D>,
    engine: CurrentEngine<'a, D>,
    grips: &'a [Grip],
    /// Gripped particles with the numbers of their grips.
    held: Vec<(u32, u32)>,
    u: Field<D>,
    v: Field<D>,
    /// Accelerations, then the velocities after the step.
    next: Field<D>,
    /// Smoothed velocities of XSPH.
    smoothed: Field<D>,
    work: f64,
    count: u64,
}

/// Calls a function with a body of updated SPH.
pub(super) fn with_updated_body<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    particles: &BodyParticles,
    grips: &[Grip],
    contact: Option<Contact>,
    work: &mut dyn FnMut(&mut dyn BodyMotion),
) -> Result<(), BodyError> {
    let law = discretization
        .current_pairs(material, &DeformationGradient::identity())?
        .ok_or(BodyError::NoBodies)?;
    if contact.is_some() {
        return Err(BodyError::NoContact(
            "particles of this method already repel all others within their support",
        ));
    }
    let placed = placed(discretization.crystal(), particles)?;
    let held = held(&placed.positions, grips)?;
    check_apart(&placed.positions, COINCIDENCE_DISTANCE * law.radius())?;
    let count = placed.positions.len();
    let density = discretization.density();
    let smoothed = if law.is_smoothed() { count } else { 0 };
    work(&mut UpdatedBody {
        discretization,
        engine: CurrentEngine::new(material, law, density, &placed.positions, placed.volumes),
        grips,
        held,
        u: zeros(count),
        v: zeros(count),
        next: zeros(count),
        smoothed: zeros(smoothed),
        work: 0.0,
        count: 0,
    });
    Ok(())
}

fn check_apart<const D: usize>(positions: &[[f64; D]], distance: f64) -> Result<(), BodyError> {
    let mut neighbors = Neighbors::new(distance);
    match neighbors.near(positions).first() {
        None => Ok(()),
        Some(pair) => Err(BodyError::Coincident {
            first: pair[0] as usize,
            second: pair[1] as usize,
            position: positions[pair[0] as usize].to_vec(),
        }),
    }
}

/// Field `a + factor b` of all particles.
fn moved<const D: usize>(a: &Field<D>, b: &Field<D>, factor: f64) -> Field<D> {
    let mut sum = a.clone();
    drift(&mut sum, b, factor);
    sum
}

/// Velocities that move the particles, and velocities that deform them.
fn followed<'f, const D: usize>(
    law: &CurrentPairs<D>,
    v: &'f Field<D>,
    smoothed: &'f Field<D>,
) -> [&'f Field<D>; 2] {
    let of = |is_smoothed: bool| if is_smoothed { smoothed } else { v };
    [of(law.is_smoothed()), of(law.smooths_everything())]
}

impl<const D: usize> UpdatedBody<'_, D> {
    fn len(&self) -> usize {
        self.engine.count
    }

    fn position(&self, particle: usize) -> [f64; D] {
        vector_of(&self.engine.positions, particle)
    }

    /// Converts vectors to a field that is zero for the particles of permanent grips.
    fn free(&self, flat: &[f64]) -> Field<D> {
        let mut field = zeros(self.len());
        fill(&mut field, flat);
        hold(&mut field, &self.held, self.grips);
        field
    }

    /// Applies a homogeneous state to all particles, with the kernels of this state.
    fn settle(&mut self, base: &DeformationGradient) {
        let law = self.discretization;
        let law = law.current_pairs(self.engine.material, base).transpose();
        // A method that supports bodies in the reference state supports them in every state.
        if let Some(law) = law {
            self.engine.settle(law);
        }
        self.engine.deform(base);
    }

    /// Computes the accelerations at the current displacements and velocities into [`Self::next`].
    fn accelerate(&mut self) -> Result<(), NoForce> {
        self.engine.place(&self.u)?;
        self.engine.stress()?;
        self.engine.accelerations(&self.v, &mut self.next)
    }

    fn present(&mut self, step: f64) -> Result<(), Box<Fault>> {
        self.accelerate().map_err(|none| self.fault(none, step))
    }

    /// Particles of closed grips with their prescribed velocities at the midpoint of the step.
    fn told(&self, step: f64) -> impl Iterator<Item = (usize, [f64; D])> {
        let time = (self.count as f64 + 0.5) * step;
        let own = self.held.iter();
        own.map(|(particle, grip)| (*particle as usize, &self.grips[*grip as usize]))
            .filter(move |(_, grip)| grip.is_closed(time))
            .map(move |(particle, grip)| (particle, grip.velocity_at(time)))
    }

    /// Computes the smoothed velocities. Gripped particles keep their prescribed velocities.
    fn smooth(&mut self, v: &Field<D>, step: f64) -> Result<(), NoForce> {
        if !self.engine.law()?.is_smoothed() {
            return Ok(());
        }
        self.engine.smooth(v, &mut self.smoothed)?;
        let told: Vec<_> = self.told(step).collect();
        for (particle, _) in told {
            put(&mut self.smoothed, particle, &vector_of(v, particle));
        }
        Ok(())
    }

    /// Computes the accelerations after small displacements, as for waves.
    fn displace(&mut self, along: &Field<D>, factor: f64) -> Result<(), NoForce> {
        let Self {
            engine,
            u,
            v,
            next,
            smoothed,
            ..
        } = self;
        engine.place(u)?;
        let law = engine.law()?.clone();
        if law.is_smoothed() {
            engine.smooth(along, smoothed)?;
        }
        let [moving, carrying] = followed(&law, along, smoothed);
        engine.strain(carrying, factor)?;
        drift(&mut engine.places, moving, factor);
        engine.look()?;
        engine.stress()?;
        engine.accelerations(v, next)
    }

    /// Change of the accelerations with displacements along a vector, by central differences.
    fn changed_by_displacements(
        &mut self,
        along: &Field<D>,
        size: f64,
    ) -> Result<Vec<f64>, NoForce> {
        let mut sides = Vec::new();
        for factor in [size, -size] {
            let f = self.engine.deformations.clone();
            let done = self.displace(along, factor);
            self.engine.deformations = f;
            done?;
            sides.push(self.next.clone());
        }
        Ok(self.difference(&sides, size))
    }

    /// Change of the accelerations with velocities along a vector, by central differences.
    fn changed_by_velocities(&mut self, along: &Field<D>, size: f64) -> Result<Vec<f64>, NoForce> {
        self.engine.place(&self.u)?;
        self.engine.stress()?;
        let mut sides = Vec::new();
        for factor in [size, -size] {
            let v = moved(&self.v, along, factor);
            self.engine.accelerations(&v, &mut self.next)?;
            sides.push(self.next.clone());
        }
        Ok(self.difference(&sides, size))
    }

    /// Difference of two fields divided by `2 size`, vector by vector.
    fn difference(&self, sides: &[Field<D>], size: f64) -> Vec<f64> {
        let difference = moved(&sides[0], &sides[1], -1.0);
        let flat = flat(&difference, self.len()).into_iter();
        flat.map(|own| own / (2.0 * size)).collect()
    }

    /// Velocities at the time of the displacements, from accelerations computed before, and the work of the grips in the preceding half step.
    fn now(&self, step: f64) -> (Field<D>, f64) {
        let mut v = moved(&self.v, &self.next, 0.5 * step);
        let mut work = 0.0;
        for (particle, told) in self.told(step) {
            let [before, a] = [&self.v, &self.next].map(|own| vector_of(own, particle));
            let free = array_of(|i| before[i] + step * a[i]);
            work += 0.5 * work_of(self.engine.mass(particle), &before, &free, &told);
            let mean = array_of(|i| 0.5 * (before[i] + told[i]));
            put(&mut v, particle, &mean);
        }
        (v, work)
    }

    /// Advances by one step, from known accelerations.
    fn step(&mut self, step: f64) -> Result<(), NoForce> {
        for (v, next) in self.v.iter().zip(&mut self.next) {
            for (v, next) in v.iter().zip(next) {
                *next = v + step * *next;
            }
        }
        let mut work = 0.0;
        for (particle, told) in self.told(step).collect::<Vec<_>>() {
            let [before, free] = [&self.v, &self.next].map(|own| vector_of(own, particle));
            work += work_of(self.engine.mass(particle), &before, &free, &told);
            put(&mut self.next, particle, &told);
        }
        let next = std::mem::replace(&mut self.next, zeros(0));
        let done = self.smooth(&next, step);
        self.next = next;
        done?;
        let law = self.engine.law()?.clone();
        let [moving, carrying] = followed(&law, &self.next, &self.smoothed);
        drift(&mut self.engine.places, moving, 0.5 * step);
        self.engine.look()?;
        self.engine.advance(carrying, step)?;
        drift(&mut self.u, moving, step);
        std::mem::swap(&mut self.v, &mut self.next);
        self.work += work;
        self.count += 1;
        let f = self.engine.deformations.as_flattened();
        let mut all = self.u.iter().chain(&self.v).chain(f);
        if all.all(|own| are_finite(own)) {
            return Ok(());
        }
        let is_lost = |n: &usize| {
            let mut all = self.u.iter().chain(&self.v).chain(f);
            all.any(|own| !own[*n].is_finite())
        };
        let particle = (0..self.len()).find(is_lost).unwrap_or_default();
        Err(NoForce {
            particle,
            source: None,
        })
    }

    fn deformation(&self, particle: usize) -> DeformationGradient {
        let f = self.engine.deformation(particle);
        let f = SMatrix::from_fn(|i, j| f[i][j]);
        self.engine.base.with_leading::<D>(&f)
    }

    fn fault(&self, none: NoForce, step: f64) -> Box<Fault> {
        let is_lost = |n: &usize| {
            let mut all = self.u.iter().chain(&self.v);
            all.any(|own| !own[*n].is_finite())
        };
        let never = (0..self.len()).find(is_lost);
        let particle = never.unwrap_or(none.particle);
        let ground = match (never, none.source) {
            (Some(_), _) => Ground::NotFinite,
            (None, Some(source)) => Ground::Method(source),
            (None, None) => {
                Ground::without_stress(self.engine.material, &self.deformation(particle))
            }
        };
        let f = self.engine.deformation(particle);
        Box::new(Fault {
            time: self.count as f64 * step,
            step: self.count,
            particle,
            position: self.position(particle).to_vec(),
            displacement: vector_of(&self.u, particle).to_vec(),
            velocity: vector_of(&self.v, particle).to_vec(),
            deformation: f.as_flattened().to_vec(),
            ground,
        })
    }
}

impl<const D: usize> BodyMotion for UpdatedBody<'_, D> {
    fn dimension(&self) -> usize {
        D
    }

    fn positions(&self) -> Vec<[f64; 3]> {
        (0..self.len())
            .map(|n| in_space(&self.position(n)))
            .collect()
    }

    fn start(&mut self, start: &Start, step: f64) -> Result<(), Box<Fault>> {
        self.settle(&start.f);
        let f = start.f.components();
        let mut random = start.seed;
        let mut noise = zeros(self.len());
        for n in 0..self.len() {
            let x = self.position(n);
            for i in 0..D {
                self.u[i][n] = (0..D).map(|j| f[i][j] * x[j]).sum::<f64>() - x[i];
                noise[i][n] = start.noise * (2.0 * uniform(&mut random) - 1.0);
            }
        }
        self.v = zeros(self.len());
        self.count = 0;
        self.work = 0.0;
        if start.noise > 0.0 {
            // The noise displaces particles without smoothing.
            let strained = self.engine.place(&self.u);
            strained
                .and_then(|()| self.engine.strain(&noise, 1.0))
                .map_err(|none| self.fault(none, step))?;
            drift(&mut self.u, &noise, 1.0);
        }
        for (particle, grip) in &self.held {
            let velocity = self.grips[*grip as usize].velocity_at(0.0);
            put(&mut self.v, *particle as usize, &velocity);
        }
        self.present(step)?;
        drift(&mut self.v, &self.next, -0.5 * step);
        for (particle, grip) in &self.held {
            let grip = &self.grips[*grip as usize];
            if grip.is_closed(0.0) {
                let velocity = grip.velocity_at(-0.5 * step);
                put(&mut self.v, *particle as usize, &velocity);
            }
        }
        // The first kick begins half a step before the start.
        self.work = -self.now(step).1;
        Ok(())
    }

    fn state(&self) -> PatchState {
        let own = 0..self.len();
        let deformations = own.map(|n| self.engine.deformation(n));
        PatchState {
            step: self.count,
            displacements: flat(&self.u, self.len()),
            velocities: flat(&self.v, self.len()),
            deformations: deformations
                .flat_map(|f| f.as_flattened().to_vec())
                .collect(),
            work: self.work,
        }
    }

    fn put(&mut self, state: &PatchState, f: &DeformationGradient) {
        // A state without deformation gradients is homogeneous.
        self.settle(f);
        fill(&mut self.u, &state.displacements);
        fill(&mut self.v, &state.velocities);
        for (n, own) in state.deformations.chunks_exact(D * D).enumerate() {
            for (i, row) in self.engine.deformations.iter_mut().enumerate() {
                put(row, n, &array_of(|j| own[D * i + j]));
            }
        }
        self.count = state.step;
        self.work = state.work;
    }

    fn advance(&mut self, step: f64) -> Result<(), Box<Fault>> {
        self.present(step)?;
        self.step(step).map_err(|none| self.fault(none, step))
    }

    fn quantities(&mut self, step: f64) -> Result<BodyQuantities, Box<Fault>> {
        self.present(step)?;
        let (v, work) = self.now(step);
        self.smooth(&v, step)
            .map_err(|none| self.fault(none, step))?;
        let is_smoothed = self
            .engine
            .law()
            .is_ok_and(CurrentPairs::smooths_everything);
        let moving = if is_smoothed { &self.smoothed } else { &v };
        let mut own = BodyQuantities::new(self.engine.energy(), self.work + work);
        for n in 0..self.len() {
            own.count(
                self.engine.mass(n),
                &vector_of(&self.engine.places, n),
                &vector_of(&self.u, n),
                [&vector_of(&v, n), &vector_of(moving, n)],
                self.deformation(n).determinant(),
            );
        }
        Ok(own)
    }

    fn deformations(&self) -> Vec<[[f64; 3]; 3]> {
        (0..self.len())
            .map(|n| *self.deformation(n).components())
            .collect()
    }

    fn fastest_oscillation(&mut self, known: Oscillation) -> Result<Oscillation, Box<Fault>> {
        let unknowns = D * self.len();
        let spacing = self.discretization.crystal().spacing();
        let is_viscous = self.engine.law().is_ok_and(CurrentPairs::is_viscous);
        // The frequency scales the velocities below. An estimate depends on the order in which bodies are computed.
        let known_squared = match is_viscous {
            true => Oscillation::NONE.squared,
            false => known.squared,
        };
        let mut image = |own: &[f64], highest: f64| {
            let along = self.free(own);
            let change = self.changed_by_displacements(&along, DIFFERENCE_STEP * spacing / highest);
            let change = change.map_err(|none| self.fault(none, 0.0))?;
            Ok(negative(flat(&self.free(&change), self.len())))
        };
        let squared = largest_eigenvalue(unknowns, &mut image, known_squared)?;
        if !is_viscous {
            return Ok(Oscillation {
                squared,
                damping: 0.0,
            });
        }
        let speed = DIFFERENCE_STEP * spacing * squared.sqrt().max(f64::MIN_POSITIVE);
        let mut image = |own: &[f64], highest: f64| {
            let along = self.free(own);
            let change = self.changed_by_velocities(&along, speed / highest);
            let change = change.map_err(|none| self.fault(none, 0.0))?;
            Ok(negative(flat(&self.free(&change), self.len())))
        };
        let damping = largest_eigenvalue(unknowns, &mut image, known.damping)?;
        Ok(Oscillation { squared, damping })
    }

    fn accelerations(&mut self) -> Result<Vec<f64>, Box<Fault>> {
        self.present(0.0)?;
        Ok(flat(&self.next, self.len()))
    }

    fn bytes_per_particle(&self) -> f64 {
        let fields = [&self.u, &self.v, &self.next, &self.smoothed];
        let own: usize = fields.map(|own| D * size_of_val(&*own[0])).iter().sum();
        (own + self.engine.bytes()) as f64 / self.len() as f64
    }
}
