//! Bodies of total-Lagrangian methods, whose gradients stay with the material.

use super::contact::{Contact, Pieces};
use super::engine::Engine;
use super::error::Lost;
use super::grip::{Grip, held, hold, work_of};
use super::links::Links;
use super::moving::{BodyMotion, Start};
use super::parts::drift;
use super::quantities::in_space;
use super::shape::placed;
use super::stability::{DIFFERENCE_STEP, largest_eigenvalue};
use super::vectors::{Field, fill, flat, negative, vector_of, zeros};
use super::{BodyError, BodyParticles, BodyQuantities};
use crate::algebra::{array_of, uniform};
use crate::kinematics::DeformationGradient;
use crate::lattice::Crystal;
use crate::material::Hyperelastic;
use crate::motion::{Fault, Ground, PatchState};
use crate::scheme::PairLaw;
use crate::time_step::Oscillation;

/// Total-Lagrangian body in motion.
struct LagrangianBody<'a, const D: usize> {
    engine: Engine<'a, D>,
    positions: Vec<[f64; D]>,
    spacing: f64,
    grips: &'a [Grip],
    /// Gripped particles with the numbers of their grips.
    held: Vec<(u32, u32)>,
    u: Field<D>,
    v: Field<D>,
    work: f64,
    count: u64,
}

/// Calls a function with a body of a method whose pair forces are known.
pub(super) fn with_lagrangian_body<const D: usize>(
    law: &dyn PairLaw<D>,
    crystal: &Crystal<D>,
    material: &dyn Hyperelastic,
    particles: &BodyParticles,
    grips: &[Grip],
    contact: Option<Contact>,
    work: &mut dyn FnMut(&mut dyn BodyMotion),
) -> Result<(), BodyError> {
    let placed = placed(crystal, particles)?;
    let links = Links::new(crystal, &placed, law)?;
    let held = held(&placed.positions, grips)?;
    let (count, spacing) = (placed.positions.len(), crystal.spacing());
    let pieces = match contact {
        Some(contact) => Some(Pieces::new(
            contact,
            material,
            &links,
            &placed.positions,
            spacing,
        )?),
        None => None,
    };
    work(&mut LagrangianBody {
        engine: Engine::new(
            material,
            links,
            law.penalty_offsets(),
            law.density(),
            placed.volumes,
            pieces,
        ),
        positions: placed.positions,
        spacing,
        grips,
        held,
        u: zeros(count),
        v: zeros(count),
        work: 0.0,
        count: 0,
    });
    Ok(())
}

impl<const D: usize> LagrangianBody<'_, D> {
    fn len(&self) -> usize {
        self.positions.len()
    }

    fn mass(&self, particle: usize) -> f64 {
        self.engine.density * self.engine.volumes[particle]
    }

    /// Velocity of a grip at a time.
    fn grip_velocity(&self, grip: u32, time: f64) -> [f64; D] {
        self.grips[grip as usize].velocity_at(time)
    }

    fn deform(&mut self, step: f64) -> Result<(), Box<Fault>> {
        self.engine
            .deform(&self.u)
            .map_err(|lost| self.fault(lost, step))
    }

    /// Velocities at the time of the displacements, from forces computed before, and the work of the grips in the preceding half step.
    fn now(&self, step: f64) -> (Field<D>, f64) {
        let mut v = self.v.clone();
        self.engine.kick(&self.u, &mut v, 0.5 * step);
        let mut work = 0.0;
        for (particle, grip) in &self.held {
            let time = (self.count as f64 + 0.5) * step;
            if !self.grips[*grip as usize].is_closed(time) {
                continue;
            }
            let next = self.grip_velocity(*grip, time);
            let particle = *particle as usize;
            let before = vector_of(&self.v, particle);
            let free = array_of(|i| 2.0 * v[i][particle] - before[i]);
            work += 0.5 * work_of(self.mass(particle), &before, &free, &next);
            for i in 0..D {
                v[i][particle] = 0.5 * (before[i] + next[i]);
            }
        }
        (v, work)
    }

    fn deformation(&self, particle: usize) -> [[f64; 3]; 3] {
        let mut f = *self.engine.transverse.components();
        for i in 0..D {
            for j in 0..D {
                f[i][j] = self.engine.deformations[i][j][particle];
            }
        }
        f
    }

    fn fault(&self, lost: Lost, step: f64) -> Box<Fault> {
        let is_lost = |n: usize| {
            let mut numbers = self.u.iter().chain(&self.v).map(|own| own[n]);
            numbers.any(|x| !x.is_finite())
        };
        let never = (0..self.len()).find(|n| is_lost(*n));
        let (Lost::Strained(told) | Lost::Passing(told)) = lost;
        let particle = never.unwrap_or(told);
        let f = self.deformation(particle);
        let ground = match never {
            Some(_) => Ground::NotFinite,
            None if matches!(lost, Lost::Passing(_)) => Ground::Overlapping,
            None => Ground::without_stress(
                self.engine.material,
                &DeformationGradient::from_components(f),
            ),
        };
        let leading = f.iter().take(D).flat_map(|row| row[..D].to_vec());
        Box::new(Fault {
            time: self.count as f64 * step,
            step: self.count,
            particle,
            position: self.positions[particle].to_vec(),
            displacement: vector_of(&self.u, particle).to_vec(),
            velocity: vector_of(&self.v, particle).to_vec(),
            deformation: leading.collect(),
            ground,
        })
    }

    /// Change of the accelerations with displacements along a vector, by central differences.
    fn changed(&mut self, along: &Field<D>, size: f64) -> Result<Field<D>, Box<Fault>> {
        let kept = self.u.clone();
        let mut change = zeros(self.len());
        for sign in [1.0, -1.0] {
            for (u, (kept, w)) in self.u.iter_mut().zip(kept.iter().zip(along)) {
                for (u, (kept, w)) in u.iter_mut().zip(kept.iter().zip(w)) {
                    *u = kept + sign * size * w;
                }
            }
            if let Err(fault) = self.deform(0.0) {
                self.u = kept;
                return Err(fault);
            }
            self.engine.kick(&self.u, &mut change, sign / (2.0 * size));
        }
        self.u = kept;
        Ok(change)
    }
}

impl<const D: usize> BodyMotion for LagrangianBody<'_, D> {
    fn dimension(&self) -> usize {
        D
    }

    fn positions(&self) -> Vec<[f64; 3]> {
        self.positions.iter().map(in_space).collect()
    }

    fn start(&mut self, start: &Start, step: f64) -> Result<(), Box<Fault>> {
        let f = start.f.components();
        let mut random = start.seed;
        for (particle, position) in self.positions.iter().enumerate() {
            for i in 0..D {
                let moved: f64 = (0..D).map(|j| f[i][j] * position[j]).sum();
                let chance = 2.0 * uniform(&mut random) - 1.0;
                self.u[i][particle] = moved - position[i] + start.noise * chance;
            }
        }
        self.engine.transverse = start.f;
        self.v = zeros(self.len());
        self.count = 0;
        self.work = 0.0;
        self.deform(step)?;
        self.engine.kick(&self.u, &mut self.v, -0.5 * step);
        for (particle, grip) in self.held.clone() {
            let is_closed = self.grips[grip as usize].is_closed(0.0);
            let velocity = self.grip_velocity(grip, if is_closed { -0.5 * step } else { 0.0 });
            for i in 0..D {
                // Particles released at the start have the velocity of the grip and are accelerated like all others.
                let kicked = if is_closed {
                    0.0
                } else {
                    self.v[i][particle as usize]
                };
                self.v[i][particle as usize] = kicked + velocity[i];
            }
        }
        // The first kick begins half a step before the start.
        self.work = -self.now(step).1;
        Ok(())
    }

    fn state(&self) -> PatchState {
        PatchState {
            step: self.count,
            displacements: flat(&self.u, self.len()),
            velocities: flat(&self.v, self.len()),
            deformations: Vec::new(),
            work: self.work,
        }
    }

    fn put(&mut self, state: &PatchState, f: &DeformationGradient) {
        fill(&mut self.u, &state.displacements);
        fill(&mut self.v, &state.velocities);
        self.engine.transverse = *f;
        self.count = state.step;
        self.work = state.work;
    }

    fn advance(&mut self, step: f64) -> Result<(), Box<Fault>> {
        self.deform(step)?;
        let held = std::mem::take(&mut self.held);
        let before: Vec<[f64; D]> = held
            .iter()
            .map(|(particle, _)| vector_of(&self.v, *particle as usize))
            .collect();
        self.engine.kick(&self.u, &mut self.v, step);
        for ((particle, grip), before) in held.iter().zip(&before) {
            let time = (self.count as f64 + 0.5) * step;
            if !self.grips[*grip as usize].is_closed(time) {
                continue;
            }
            let next = self.grip_velocity(*grip, time);
            let particle = *particle as usize;
            let free = vector_of(&self.v, particle);
            self.work += work_of(self.mass(particle), before, &free, &next);
            for i in 0..D {
                self.v[i][particle] = next[i];
            }
        }
        self.held = held;
        drift(&mut self.u, &self.v, step);
        self.count += 1;
        // A NaN or infinite component makes the sum NaN or infinite.
        let sum: f64 = self.u.iter().flatten().sum();
        match sum.is_finite() {
            true => Ok(()),
            false => Err(self.fault(Lost::Strained(0), step)),
        }
    }

    fn quantities(&mut self, step: f64) -> Result<BodyQuantities, Box<Fault>> {
        self.deform(step)?;
        let (v, work) = self.now(step);
        let mut own = BodyQuantities::new(self.engine.energy(), self.work + work);
        for particle in 0..self.len() {
            let u = vector_of(&self.u, particle);
            let f = DeformationGradient::from_components(self.deformation(particle));
            own.count(
                self.mass(particle),
                &array_of(|i| self.positions[particle][i] + u[i]),
                &u,
                [&vector_of(&v, particle); 2],
                f.determinant(),
            );
        }
        Ok(own)
    }

    fn deformations(&self) -> Vec<[[f64; 3]; 3]> {
        (0..self.len()).map(|n| self.deformation(n)).collect()
    }

    fn fastest_oscillation(&mut self, known: Oscillation) -> Result<Oscillation, Box<Fault>> {
        let unknowns = D * self.len();
        let mut image = |own: &[f64], highest: f64| {
            let mut along = zeros(self.len());
            fill(&mut along, own);
            hold(&mut along, &self.held, self.grips);
            let mut image = self.changed(&along, DIFFERENCE_STEP * self.spacing / highest)?;
            hold(&mut image, &self.held, self.grips);
            Ok(negative(flat(&image, self.len())))
        };
        let largest = largest_eigenvalue(unknowns, &mut image, known.squared)?;
        self.deform(0.0)?;
        Ok(Oscillation {
            squared: largest + self.engine.stiffest_contact(),
            damping: 0.0,
        })
    }

    fn accelerations(&mut self) -> Result<Vec<f64>, Box<Fault>> {
        self.deform(0.0)?;
        let mut accelerations = zeros(self.len());
        self.engine.kick(&self.u, &mut accelerations, 1.0);
        Ok(flat(&accelerations, self.len()))
    }

    fn bytes_per_particle(&self) -> f64 {
        let own = size_of::<[f64; D]>() * (2 * (self.len() + crate::real::LANES) + self.len());
        (own + self.engine.bytes()) as f64 / self.len() as f64
    }
}
