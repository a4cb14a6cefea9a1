//! A body of particles whose neighbors are found again as they move.
//!
//! Each particle carries its deformation gradient: `dF_I/dt = L_I F_I` with the velocity gradient that the method sees at the present neighbors,
//! `L_I = sum_J m_J / rho_J (w_J - w_I) (x) grad W_IJ K_I^-1` (`K = 1` where gradients are not corrected), and its stress is that of the law there. It is a function
//! of `F_I` alone, so a hyperelastic law needs no objective rate. With corrected gradients `L` is a spin where particles turn rigidly, and `F` turns with them; without,
//! `L` is that spin times `K`, which is not one at surfaces: turning strains there. Where a
//! particle has lost its neighbors there is no `L`, and `F` stays.
//!
//! From `F` at one time to the next the gradient is that in the middle of the step: `F' = (1 - dt/2 L)^-1 (1 + dt/2 L) F`. A spin gives a rotation to the last digit,
//! and particles that move freely along straight lines, `x = (1 + A t) X`, the exact `1 + A t`, if gradients are corrected: with `M` in the middle `L = A M^-1`,
//! and the fraction is `(M + dt/2 A) (M - dt/2 A)^-1`, since `A` and `M` commute. About a homogeneous state at rest a step changes `F` by `sum_J dt v_J (x) g_J F`, as the
//! forces of a patch have it: waves are those of the linearized equations with their rates in discrete time.
//!
//! With the momentum form `mean`, densities by continuity and gradients that are not corrected, the energy of the strains is what the forces take:
//! `d/dt sum_I V_I0 W(F_I) = sum_I V_I s_I : L_I = sum_IJ V_I V_J (v_J - v_I).s_I grad W_IJ = -sum_I f_I.v_I`. Other choices have no potential.

use super::contact::Contact;
use super::grip::{Grip, held, work_of};
use super::moving::{BodyMotion, Start};
use super::neighbors::Neighbors;
use super::quantities::in_space;
use super::shape::placed;
use super::stability::{DIFFERENCE, critical_step, largest_factor};
use super::{BodyError, BodyParticles, BodyQuantities};
use crate::algebra::{Each, array_of, uniform};
use crate::approximation::SingularMoment;
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::motion::{Fault, Ground, PatchState};
use crate::real::{LANES, Lanes};
use crate::scheme::sph::{CurrentPairs, Laden, correction};
use crate::scheme::{Discretization, NoForce, Weighed, determinant, inverse};
use nalgebra::SMatrix;

/// Particles nearer to each other than this share of the support are at one place.
const SAME_PLACE: f64 = 1e-9;

type Vectors<const D: usize> = Vec<[f64; D]>;
type Tensor<const D: usize> = [[f64; D]; D];

/// Two particles that see each other.
struct Pair<const D: usize> {
    ends: [usize; 2],
    /// From the first to the second; length.
    x: [f64; D],
    /// Along it.
    weight: Weighed<f64, D>,
}

impl<const D: usize> Pair<D> {
    /// `grad W_IJ` with respect to the first particle, and the reverse with respect to the second.
    fn gradients(&self) -> [[f64; D]; 2] {
        [
            self.weight.gradient.each(|slope| -slope),
            self.weight.gradient,
        ]
    }
}

/// A body of `D` dimensions in motion.
struct UpdatedBody<'a, const D: usize> {
    discretization: &'a dyn Discretization<D>,
    material: &'a dyn Hyperelastic,
    /// With the kernels of the state that the body started from.
    law: Result<CurrentPairs<D>, MethodError>,
    base: DeformationGradient,
    neighbors: Neighbors<D>,
    positions: Vectors<D>,
    volumes: Vec<f64>,
    grips: &'a [Grip],
    /// Gripped particles with their grips.
    held: Vec<(u32, u32)>,
    u: Vectors<D>,
    v: Vectors<D>,
    f: Vec<Tensor<D>>,
    work: f64,
    count: u64,
}

/// Does something with a body whose neighbors are found again.
pub(super) fn with_updated_body<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    particles: &BodyParticles,
    grips: &[Grip],
    contact: Option<Contact>,
    work: &mut dyn FnMut(&mut dyn BodyMotion),
) -> Result<(), BodyError> {
    let base = DeformationGradient::identity();
    let law = discretization
        .current_pairs(material, &base)?
        .ok_or(BodyError::NoBodies)?;
    if contact.is_some() {
        return Err(BodyError::NoContact(
            "particles of this method repel all that come near",
        ));
    }
    let placed = placed(discretization.crystal(), particles)?;
    let held = held(&placed.positions, grips)?;
    check_apart(&placed.positions, SAME_PLACE * law.radius())?;
    let count = placed.positions.len();
    work(&mut UpdatedBody {
        discretization,
        material,
        neighbors: Neighbors::new(law.radius()),
        law: Ok(law),
        base,
        positions: placed.positions,
        volumes: placed.volumes,
        grips,
        held,
        u: vec![[0.0; D]; count],
        v: vec![[0.0; D]; count],
        f: vec![identity(); count],
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

fn identity<const D: usize>() -> Tensor<D> {
    array_of(|i| array_of(|j| if i == j { 1.0 } else { 0.0 }))
}

fn leading<const D: usize>(f: &DeformationGradient) -> Tensor<D> {
    let f = f.components();
    array_of(|i| array_of(|j| f[i][j]))
}

fn times<const D: usize>(a: &Tensor<D>, b: &Tensor<D>) -> Tensor<D> {
    array_of(|i| array_of(|j| (0..D).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `1 + factor L`.
fn stepped<const D: usize>(l: &Tensor<D>, factor: f64) -> Tensor<D> {
    let mut sum = identity();
    for (row, own) in sum.iter_mut().zip(l) {
        for (entry, own) in row.iter_mut().zip(own) {
            *entry += factor * own;
        }
    }
    sum
}

/// `a + factor b`, of all particles.
fn moved<const D: usize>(a: &[[f64; D]], b: &[[f64; D]], factor: f64) -> Vectors<D> {
    let both = a.iter().zip(b);
    both.map(|(a, b)| array_of(|i| a[i] + factor * b[i]))
        .collect()
}

fn vectors<const D: usize>(flat: &[f64]) -> Vectors<D> {
    let own = flat.chunks_exact(D);
    own.map(|own| array_of(|i| own[i])).collect()
}

fn is_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

/// What all particles have at a moment.
struct Moment<const D: usize> {
    pairs: Vec<Pair<D>>,
    laden: Vec<Laden<f64, D>>,
    /// `W(F_I)`.
    energies: Vec<f64>,
}

impl<const D: usize> UpdatedBody<'_, D> {
    fn law(&self) -> Result<&CurrentPairs<D>, NoForce> {
        self.law.as_ref().map_err(|source| NoForce {
            particle: 0,
            source: Some(source.clone()),
        })
    }

    /// Takes the kernels of a homogeneous state.
    fn settle(&mut self, base: &DeformationGradient) {
        self.base = *base;
        match self.discretization.current_pairs(self.material, base) {
            Ok(Some(law)) => {
                self.neighbors = Neighbors::new(law.radius());
                self.law = Ok(law);
            }
            // A method that has bodies in the reference state has them everywhere.
            Ok(None) => {}
            Err(error) => self.law = Err(error),
        }
    }

    /// Where the particles are.
    fn places(&self) -> Vectors<D> {
        moved(&self.positions, &self.u, 1.0)
    }

    fn mass(&self, particle: usize) -> f64 {
        self.discretization.density() * self.volumes[particle]
    }

    /// The pairs of particles at some places, in the order of their numbers.
    fn pairs(&mut self, places: &[[f64; D]]) -> Result<Vec<Pair<D>>, NoForce> {
        if let Some(particle) = places.iter().position(|x| !is_finite(x)) {
            return Err(NoForce {
                particle,
                source: None,
            });
        }
        let law = self.law()?.clone();
        let measured: Vectors<D> = places.iter().map(|x| law.measured(x)).collect();
        let radius = law.radius();
        let pair = |ends: &[u32; 2]| {
            let ends = ends.each(|end| end as usize);
            let [a, b] = ends.each(|end| measured[end]);
            let squared: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum();
            if squared >= radius * radius {
                return None;
            }
            let x = array_of(|i| places[ends[1]][i] - places[ends[0]][i]);
            Some(Pair {
                ends,
                x,
                weight: law.weigh(&x),
            })
        };
        Ok(self
            .neighbors
            .near(&measured)
            .iter()
            .filter_map(pair)
            .collect())
    }

    /// The densities of all particles.
    fn densities(&self, pairs: &[Pair<D>], f: &[Tensor<D>]) -> Result<Vec<f64>, NoForce> {
        let law = self.law()?;
        if !law.sums_densities() {
            let density = law.reference_density();
            return Ok(f.iter().map(|f| determinant(f).recip() * density).collect());
        }
        let own = law.weigh(&[0.0; D]).value;
        let mut densities: Vec<f64> = (0..f.len()).map(|n| self.mass(n) * own).collect();
        for pair in pairs {
            let [a, b] = pair.ends;
            densities[a] += self.mass(b) * pair.weight.value;
            densities[b] += self.mass(a) * pair.weight.value;
        }
        Ok(densities)
    }

    /// Deformation gradients of several particles; what fills up is the reference state.
    fn states(&self, f: &[Tensor<D>]) -> DeformationGradient<Lanes> {
        let base = self.base.components();
        DeformationGradient::from_components(array_of(|i| {
            array_of(|j| {
                if i >= D || j >= D {
                    return Lanes([base[i][j]; LANES]);
                }
                let rest = if i == j { 1.0 } else { 0.0 };
                Lanes(array_of(|lane| f.get(lane).map_or(rest, |f| f[i][j])))
            })
        }))
    }

    /// Stresses and all else that forces take, of particles at some places with deformation gradients.
    fn moment(&mut self, places: &[[f64; D]], f: &[Tensor<D>]) -> Result<Moment<D>, NoForce> {
        let pairs = self.pairs(places)?;
        let densities = self.densities(&pairs, f)?;
        let law = self.law()?;
        let mut moment = Moment {
            pairs,
            laden: Vec::with_capacity(f.len()),
            energies: Vec::with_capacity(f.len()),
        };
        for some in f.chunks(LANES) {
            let response = self.material.lane_stress(&self.states(some), D);
            for (lane, f) in some.iter().enumerate() {
                let particle = moment.laden.len();
                let p: Tensor<D> = array_of(|i| array_of(|j| response.first_piola[i][j].0[lane]));
                let (energy, volume) = (response.energy.0[lane], determinant(f));
                let has_stress = energy.is_finite() && is_finite(p.as_flattened()) && volume > 0.0;
                if !has_stress {
                    return Err(NoForce {
                        particle,
                        source: None,
                    });
                }
                let stress: Tensor<D> = array_of(|i| {
                    array_of(|j| (0..D).map(|k| p[i][k] * f[j][k]).sum::<f64>() * volume.recip())
                });
                moment.energies.push(energy);
                moment.laden.push(Laden {
                    mass: self.mass(particle),
                    density: densities[particle],
                    tensile: law.tensile(&stress),
                    stress,
                });
            }
        }
        Ok(moment)
    }

    /// Accelerations by the forces of a moment.
    fn accelerations_of(&self, moment: &Moment<D>, v: &[[f64; D]]) -> Result<Vectors<D>, NoForce> {
        let law = self.law()?;
        let mut forces = vec![[0.0; D]; v.len()];
        for pair in &moment.pairs {
            let [a, b] = pair.ends;
            let (first, second) = (&moment.laden[a], &moment.laden[b]);
            let forth = law.traction(first, (second.mass, second.density), &pair.weight);
            let reverse = Weighed {
                value: pair.weight.value,
                gradient: pair.gradients()[0],
            };
            let back = law.traction(second, (first.mass, first.density), &reverse);
            let (own, other) = (law.taken(forth), law.taken(back));
            for i in 0..D {
                forces[a][i] += own[i] - back[i];
                forces[b][i] += other[i] - forth[i];
            }
            if law.is_viscous() {
                let apart = array_of(|i| v[b][i] - v[a][i]);
                let masses = [first.mass, second.mass];
                let densities = [first.density, second.density];
                let viscous = law.viscous_force(&pair.x, &apart, masses, densities);
                for i in 0..D {
                    forces[a][i] += viscous[i];
                    forces[b][i] -= viscous[i];
                }
            }
        }
        let all = forces.into_iter().enumerate();
        Ok(all
            .map(|(n, force)| force.each(|own| own / self.mass(n)))
            .collect())
    }

    /// The velocities that move the particles: smoothed ones with XSPH. Grips move their particles themselves.
    fn smoothed(
        &self,
        pairs: &[Pair<D>],
        densities: impl Fn(usize) -> f64,
        v: &[[f64; D]],
        time: f64,
    ) -> Result<Vectors<D>, NoForce> {
        let law = self.law()?;
        let mut smoothed = v.to_vec();
        if !law.is_smoothed() {
            return Ok(smoothed);
        }
        for pair in pairs {
            let [a, b] = pair.ends;
            let between = pair.ends.map(&densities);
            let share = |of: usize| law.smoothing_share(self.mass(of), between, pair.weight.value);
            for i in 0..D {
                let apart = v[b][i] - v[a][i];
                smoothed[a][i] += share(b) * apart;
                smoothed[b][i] -= share(a) * apart;
            }
        }
        for (particle, grip) in &self.held {
            if self.grips[*grip as usize].is_closed(time) {
                smoothed[*particle as usize] = v[*particle as usize];
            }
        }
        Ok(smoothed)
    }

    /// `L_I` of all particles, the velocity gradients that the method sees.
    fn gradients(
        &self,
        pairs: &[Pair<D>],
        densities: &[f64],
        w: &[[f64; D]],
    ) -> Result<Vec<Tensor<D>>, NoForce> {
        let is_corrected = self.law()?.is_corrected();
        let mut gradients = vec![[[0.0; D]; D]; w.len()];
        let mut moments = vec![[[0.0; D]; D]; if is_corrected { w.len() } else { 0 }];
        for pair in pairs {
            let [a, b] = pair.ends;
            let ends = [(a, b, 1.0), (b, a, -1.0)];
            for ((own, other, sign), slope) in ends.into_iter().zip(pair.gradients()) {
                let volume = self.mass(other) / densities[other];
                for i in 0..D {
                    let apart = w[other][i] - w[own][i];
                    for j in 0..D {
                        gradients[own][i][j] += apart * slope[j] * volume;
                    }
                    if is_corrected {
                        for j in 0..D {
                            moments[own][i][j] += sign * pair.x[i] * slope[j] * volume;
                        }
                    }
                }
            }
        }
        for (particle, (own, moment)) in gradients.iter_mut().zip(&moments).enumerate() {
            let inverse = correction(moment).map_err(|condition| NoForce {
                particle,
                source: Some(MethodError::SingularMoment {
                    point: "particle",
                    neighbors: pairs
                        .iter()
                        .filter(|own| own.ends.contains(&particle))
                        .count(),
                    source: SingularMoment { condition },
                }),
            })?;
            *own = times(own, &inverse);
        }
        Ok(gradients)
    }

    /// The deformation gradients after a step in which particles move with velocities; `carrying` are those that deformations follow.
    fn carried(
        &mut self,
        places: &[[f64; D]],
        moving: &[[f64; D]],
        carrying: &[[f64; D]],
        step: f64,
    ) -> Result<Vec<Tensor<D>>, NoForce> {
        let middle = moved(places, moving, 0.5 * step);
        let pairs = self.pairs(&middle)?;
        let mut densities = self.densities(&pairs, &self.f)?;
        let mut gradients = self.gradients(&pairs, &densities, carrying)?;
        if !self.law()?.sums_densities() {
            // Those of deformation gradients are of the beginning of the step: half a step further on.
            for (density, l) in densities.iter_mut().zip(&gradients) {
                let rate: f64 = (0..D).map(|i| l[i][i]).sum();
                *density *= (-0.5 * step * rate).exp();
            }
            gradients = self.gradients(&pairs, &densities, carrying)?;
        }
        let next = |(f, l): (&Tensor<D>, &Tensor<D>)| {
            let half = stepped(l, 0.5 * step);
            times(&inverse(&stepped(l, -0.5 * step)), &times(&half, f))
        };
        Ok(self.f.iter().zip(&gradients).map(next).collect())
    }

    /// Deformation gradients with small displacements at the present places.
    fn strained(
        &self,
        pairs: &[Pair<D>],
        densities: &[f64],
        along: &[[f64; D]],
        factor: f64,
    ) -> Result<Vec<Tensor<D>>, NoForce> {
        let gradients = self.gradients(pairs, densities, along)?;
        let both = gradients.iter().zip(&self.f);
        Ok(both.map(|(l, f)| times(&stepped(l, factor), f)).collect())
    }

    /// Deformation gradients with the noise of the start, which displaces without being smoothed.
    fn noisy(&mut self, noise: &[[f64; D]]) -> Result<Vec<Tensor<D>>, NoForce> {
        let pairs = self.pairs(&self.places())?;
        let densities = self.densities(&pairs, &self.f)?;
        self.strained(&pairs, &densities, noise, 1.0)
    }

    /// Places and deformation gradients with small displacements, as waves have them.
    fn displaced(
        &mut self,
        along: &[[f64; D]],
        factor: f64,
    ) -> Result<(Vectors<D>, Vec<Tensor<D>>), NoForce> {
        let places = self.places();
        let pairs = self.pairs(&places)?;
        let densities = self.densities(&pairs, &self.f)?;
        let moving = self.smoothed(&pairs, |n| densities[n], along, f64::INFINITY)?;
        let is_smoothed = self.law()?.smooths_everything();
        let carrying = if is_smoothed { &moving } else { along };
        let f = self.strained(&pairs, &densities, carrying, factor)?;
        Ok((moved(&places, &moving, factor), f))
    }

    /// The change of the accelerations with displacements along a vector, by central differences.
    fn changed_by_displacements(
        &mut self,
        along: &[[f64; D]],
        size: f64,
    ) -> Result<Vec<f64>, NoForce> {
        let mut sides = Vec::new();
        for factor in [size, -size] {
            let (places, f) = self.displaced(along, factor)?;
            let moment = self.moment(&places, &f)?;
            sides.push(self.accelerations_of(&moment, &self.v)?);
        }
        Ok(difference(&sides, size))
    }

    /// The same with velocities along a vector.
    fn changed_by_velocities(
        &mut self,
        along: &[[f64; D]],
        size: f64,
    ) -> Result<Vec<f64>, NoForce> {
        let places = self.places();
        let f = self.f.clone();
        let moment = self.moment(&places, &f)?;
        let mut sides = Vec::new();
        for factor in [size, -size] {
            let v = moved(&self.v, along, factor);
            sides.push(self.accelerations_of(&moment, &v)?);
        }
        Ok(difference(&sides, size))
    }

    /// The velocities at the time of the displacements, and the work of the grips in the half step before it.
    fn now(&self, accelerations: &[[f64; D]], step: f64) -> (Vectors<D>, f64) {
        let mut v = moved(&self.v, accelerations, 0.5 * step);
        let mut work = 0.0;
        let time = (self.count as f64 + 0.5) * step;
        for (particle, grip) in &self.held {
            let (particle, grip) = (*particle as usize, &self.grips[*grip as usize]);
            if !grip.is_closed(time) {
                continue;
            }
            let next: [f64; D] = grip.velocity_at(time);
            let before = self.v[particle];
            let free = array_of(|i| before[i] + step * accelerations[particle][i]);
            work += 0.5 * work_of(self.mass(particle), &before, &free, &next);
            v[particle] = array_of(|i| 0.5 * (before[i] + next[i]));
        }
        (v, work)
    }

    fn present(&mut self, step: f64) -> Result<(Moment<D>, Vectors<D>), Box<Fault>> {
        let places = self.places();
        let f = self.f.clone();
        let both = self.moment(&places, &f).and_then(|moment| {
            let accelerations = self.accelerations_of(&moment, &self.v)?;
            Ok((moment, accelerations))
        });
        both.map_err(|none| self.fault(none, step))
    }

    /// One step from accelerations.
    fn step(
        &mut self,
        moment: &Moment<D>,
        accelerations: &[[f64; D]],
        step: f64,
    ) -> Result<(), NoForce> {
        let time = (self.count as f64 + 0.5) * step;
        let mut v = moved(&self.v, accelerations, step);
        let mut work = 0.0;
        for (particle, grip) in &self.held {
            let (particle, grip) = (*particle as usize, &self.grips[*grip as usize]);
            if !grip.is_closed(time) {
                continue;
            }
            let next = grip.velocity_at(time);
            work += work_of(self.mass(particle), &self.v[particle], &v[particle], &next);
            v[particle] = next;
        }
        let moving = self.smoothed(&moment.pairs, |n| moment.laden[n].density, &v, time)?;
        let is_smoothed = self.law()?.smooths_everything();
        let carrying = if is_smoothed { &moving } else { &v };
        self.f = self.carried(&self.places(), &moving, carrying, step)?;
        self.u = moved(&self.u, &moving, step);
        self.v = v;
        self.work += work;
        self.count += 1;
        let lost = (0..self.u.len()).find(|n| {
            let own = [&self.u[*n][..], &self.v[*n][..], self.f[*n].as_flattened()];
            !own.into_iter().all(is_finite)
        });
        match lost {
            None => Ok(()),
            Some(particle) => Err(NoForce {
                particle,
                source: None,
            }),
        }
    }

    fn fault(&self, none: NoForce, step: f64) -> Box<Fault> {
        let is_lost = |n: &usize| !is_finite(&self.u[*n]) || !is_finite(&self.v[*n]);
        let never = (0..self.u.len()).find(is_lost);
        let particle = never.unwrap_or(none.particle);
        let f = &self.f[particle];
        let ground = match (never, none.source) {
            (Some(_), _) => Ground::NotFinite,
            (None, Some(source)) => Ground::Method(source),
            (None, None) => {
                let own = SMatrix::from_fn(|i, j| f[i][j]);
                Ground::without_stress(self.material, &self.base.with_leading::<D>(&own))
            }
        };
        Box::new(Fault {
            time: self.count as f64 * step,
            step: self.count,
            particle,
            position: self.positions[particle].to_vec(),
            displacement: self.u[particle].to_vec(),
            velocity: self.v[particle].to_vec(),
            deformation: f.as_flattened().to_vec(),
            ground,
        })
    }
}

/// The difference of two sides over `2 size`, one vector after the other.
fn difference<const D: usize>(sides: &[Vectors<D>], size: f64) -> Vec<f64> {
    let both = sides[0].as_flattened().iter().zip(sides[1].as_flattened());
    both.map(|(a, b)| (a - b) / (2.0 * size)).collect()
}

impl<const D: usize> BodyMotion for UpdatedBody<'_, D> {
    fn dimension(&self) -> usize {
        D
    }

    fn positions(&self) -> Vec<[f64; 3]> {
        self.positions.iter().map(in_space).collect()
    }

    fn start(&mut self, start: &Start, step: f64) -> Result<(), Box<Fault>> {
        self.settle(&start.f);
        let f: Tensor<D> = leading(&start.f);
        let mut random = start.seed;
        let mut noise = Vec::with_capacity(self.u.len());
        for (u, x) in self.u.iter_mut().zip(&self.positions) {
            *u = array_of(|i| (0..D).map(|j| f[i][j] * x[j]).sum::<f64>() - x[i]);
            noise.push(array_of(|_| {
                start.noise * (2.0 * uniform(&mut random) - 1.0)
            }));
        }
        let count = self.u.len();
        self.f = vec![f; count];
        self.v = vec![[0.0; D]; count];
        self.count = 0;
        self.work = 0.0;
        if start.noise > 0.0 {
            let strained = self.noisy(&noise);
            self.f = strained.map_err(|none| self.fault(none, step))?;
            self.u = moved(&self.u, &noise, 1.0);
        }
        for (particle, grip) in &self.held {
            let grip = &self.grips[*grip as usize];
            self.v[*particle as usize] = grip.velocity_at(0.0);
        }
        let (_, accelerations) = self.present(step)?;
        self.v = moved(&self.v, &accelerations, -0.5 * step);
        for (particle, grip) in &self.held {
            let grip = &self.grips[*grip as usize];
            if grip.is_closed(0.0) {
                self.v[*particle as usize] = grip.velocity_at(-0.5 * step);
            }
        }
        // The first kick begins half a step before the start.
        self.work = -self.now(&accelerations, step).1;
        Ok(())
    }

    fn state(&self) -> PatchState {
        PatchState {
            step: self.count,
            displacements: self.u.as_flattened().to_vec(),
            velocities: self.v.as_flattened().to_vec(),
            deformations: self.f.as_flattened().as_flattened().to_vec(),
            work: self.work,
        }
    }

    fn put(&mut self, state: &PatchState, f: &DeformationGradient) {
        self.settle(f);
        self.u = vectors(&state.displacements);
        self.v = vectors(&state.velocities);
        let rows = vectors::<D>(&state.deformations);
        let own = rows.chunks_exact(D);
        self.f = own.map(|own| array_of(|i| own[i])).collect();
        // A state without them is homogeneous.
        self.f.resize(self.positions.len(), leading(f));
        self.count = state.step;
        self.work = state.work;
    }

    fn advance(&mut self, step: f64) -> Result<(), Box<Fault>> {
        let (moment, accelerations) = self.present(step)?;
        let done = self.step(&moment, &accelerations, step);
        done.map_err(|none| self.fault(none, step))
    }

    fn quantities(&mut self, step: f64) -> Result<BodyQuantities, Box<Fault>> {
        let (moment, accelerations) = self.present(step)?;
        let (v, work) = self.now(&accelerations, step);
        let time = (self.count as f64 + 0.5) * step;
        let smoothed = self
            .smoothed(&moment.pairs, |n| moment.laden[n].density, &v, time)
            .map_err(|none| self.fault(none, step))?;
        let is_smoothed = self.law().is_ok_and(CurrentPairs::smooths_everything);
        let moving = if is_smoothed { &smoothed } else { &v };
        let energies = moment.energies.iter().zip(&self.volumes);
        let strain = energies.map(|(energy, volume)| energy * volume).sum();
        let mut own = BodyQuantities::new(strain, self.work + work);
        for (n, x) in self.places().iter().enumerate() {
            let f = DeformationGradient::from_components(self.deformations_of(n));
            let velocities = [&v[n], &moving[n]];
            own.count(self.mass(n), x, &self.u[n], velocities, f.determinant());
        }
        Ok(own)
    }

    fn deformations(&self) -> Vec<[[f64; 3]; 3]> {
        (0..self.f.len()).map(|n| self.deformations_of(n)).collect()
    }

    fn critical_time_step(&mut self) -> Result<f64, Box<Fault>> {
        let unknowns = D * self.u.len();
        let spacing = self.discretization.crystal().spacing();
        let squared = largest_factor(unknowns, &mut |flat: &[f64], highest: f64| {
            self.changed_by_displacements(&vectors(flat), DIFFERENCE * spacing / highest)
                .map_err(|none| self.fault(none, 0.0))
        })?;
        if !self.law().is_ok_and(CurrentPairs::is_viscous) {
            return Ok(critical_step(squared, 0.0));
        }
        let speed = DIFFERENCE * spacing * squared.sqrt().max(f64::MIN_POSITIVE);
        let damping = largest_factor(unknowns, &mut |flat: &[f64], highest: f64| {
            self.changed_by_velocities(&vectors(flat), speed / highest)
                .map_err(|none| self.fault(none, 0.0))
        })?;
        Ok(critical_step(squared, damping))
    }

    fn accelerations(&mut self) -> Result<Vec<f64>, Box<Fault>> {
        Ok(self.present(0.0)?.1.into_flattened())
    }

    fn bytes_per_particle(&self) -> f64 {
        let own = size_of::<[f64; D]>() * 3 + size_of::<Tensor<D>>() + size_of::<f64>();
        let pairs = self.neighbors.len() * size_of::<Pair<D>>() + self.neighbors.bytes();
        let laden = size_of::<Laden<f64, D>>() + size_of::<f64>();
        (own + laden) as f64 + pairs as f64 / self.u.len() as f64
    }
}

impl<const D: usize> UpdatedBody<'_, D> {
    fn deformations_of(&self, particle: usize) -> [[f64; 3]; 3] {
        let mut f = *self.base.components();
        for (row, own) in f.iter_mut().zip(&self.f[particle]) {
            row[..D].copy_from_slice(own);
        }
        f
    }
}
