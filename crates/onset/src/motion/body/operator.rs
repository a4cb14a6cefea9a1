//! Linearized forces of a free body as a sparse matrix, for methods whose particles can have any positions.
//!
//! The body is a crystal of one cell without neighbors. The method then gives its equations, the parts
//! that codes integrate and its damping as for any crystal, at the wave vector zero.

use super::stability::largest_mode;
use super::{BodyError, PlacedParticle};
use crate::algebra::{Complex, array_of};
use crate::bloch::{BlochSum, WaveSystem};
use crate::kinematics::DeformationGradient;
use crate::lattice::{BravaisLattice, Crystal};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::scheme::{Discretization, MethodChoices};
use crate::time_step::{Stepping, WaveParts};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::collections::{BTreeMap, HashSet};

/// Largest number of particles in an assembled operator. Larger bodies are divided into boxes.
const MAX_OPERATOR_PARTICLES: usize = 1500;

/// Oscillation of a body that limits the time step of a scheme.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMode {
    /// Largest eigenvalue of the parts with the [weights](Stepping::weights) of the scheme; 1/time^2.
    pub squared: f64,
    /// Particle with the largest displacement.
    pub particle: usize,
    /// Rayleigh quotients of the parts of the equations, as matrices of one entry.
    pub parts: WaveParts,
}

impl BodyMode {
    /// Largest stable time step of the scheme; time.
    pub fn critical_time_step(&self, stepping: Stepping) -> f64 {
        stepping.critical_step(self.squared, self.parts.damping[(0, 0)].re)
    }

    /// Growth rate of the mode in steps of a scheme; 1/time. It is zero or negative if the mode does not grow.
    pub fn growth(&self, stepping: Stepping, step: f64) -> f64 {
        let rates = stepping.rates(&self.parts, step).into_iter();
        rates.map(|s| s.re).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Returns the mode of a free body in a homogeneous state that limits the time step of a scheme.
///
/// The result is `None` for methods whose particles have no forces at arbitrary positions: finite elements, conforming integration, material points,
/// and quadrature points other than the particles.
///
/// Particles marked in `held` have no displacement. Bodies of more than 1500 particles are divided into overlapping boxes; the mode then vanishes
/// outside one box. The fastest modes are so localized that the difference is negligible.
///
/// # Errors
/// [`BodyError`] if the method or the material cannot be evaluated for these particles.
pub(crate) fn fastest_mode<const D: usize>(
    choices: &MethodChoices,
    material: &dyn Hyperelastic,
    particles: &[PlacedParticle],
    held: &[bool],
    f: &DeformationGradient,
    stepping: Stepping,
) -> Result<Option<BodyMode>, BodyError> {
    if particles.is_empty() {
        return Err(BodyError::Empty);
    }
    let regular = choices.discretization::<D>()?;
    let ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI][D - 1];
    let neighbors = (regular.neighbors() / ball).powf(1.0 / D as f64);
    let spacing = regular.crystal().spacing();
    // Compression brings more particles into the support of a kernel in current coordinates.
    let leading = f.leading::<D>();
    let singular = DMatrix::from_fn(D, D, |i, j| leading[(i, j)]).singular_values();
    let shortest = singular.min().clamp(f64::MIN_POSITIVE, 1.0);
    let reach = (neighbors.ceil() + 1.0) * spacing / shortest;
    let mut fastest: Option<BodyMode> = None;
    let mut known = HashSet::new();
    for part in parts::<D>(particles, reach, spacing) {
        let own: Vec<PlacedParticle> = part.all.iter().map(|n| particles[*n]).collect();
        let is_free = |n: usize| part.is_free[n] && !held[part.all[n]];
        let free: Vec<bool> = (0..own.len()).map(is_free).collect();
        // Boxes inside a regular body are equal.
        if !known.insert(pattern::<D>(&own, &free, spacing)) {
            continue;
        }
        let crystal = isolated::<D>(&own, 3.0 * reach, spacing)?;
        let Some(discretization) = choices.of_particles(crystal)? else {
            return Ok(None);
        };
        let operator = Operator::new(&*discretization, material, f)?;
        let Some(mode) = operator.fastest(&free, stepping) else {
            continue;
        };
        if fastest
            .as_ref()
            .is_none_or(|own| mode.squared > own.squared)
        {
            fastest = Some(BodyMode {
                particle: part.all[mode.particle],
                ..mode
            });
        }
    }
    Ok(fastest)
}

/// Part of a body: the particles of a box, with all particles that interact with them.
struct Part {
    all: Vec<usize>,
    /// Whether a particle belongs to the box or its overlap, so that all of its forces are known.
    is_free: Vec<bool>,
}

/// Positions relative to the first particle in small fractions of the spacing, with the volumes and the particles that can move.
fn pattern<const D: usize>(
    particles: &[PlacedParticle],
    free: &[bool],
    spacing: f64,
) -> Vec<([i64; D], u64, bool)> {
    let Some(first) = particles.first() else {
        return Vec::new();
    };
    let whole = |x: f64| (x / (1e-6 * spacing)).round() as i64;
    let place = |own: &PlacedParticle| array_of(|i| whole(own.position[i] - first.position[i]));
    let all = particles.iter().zip(free);
    all.map(|(own, free)| (place(own), own.volume.to_bits(), *free))
        .collect()
}

/// Divides a body into overlapping boxes of a limited number of particles each.
fn parts<const D: usize>(particles: &[PlacedParticle], reach: f64, spacing: f64) -> Vec<Part> {
    if particles.len() <= 2 * MAX_OPERATOR_PARTICLES {
        return vec![Part {
            all: (0..particles.len()).collect(),
            is_free: vec![true; particles.len()],
        }];
    }
    let volume: f64 = particles.iter().map(|own| own.volume).sum();
    let side =
        (volume / particles.len() as f64 * MAX_OPERATOR_PARTICLES as f64).powf(1.0 / D as f64);
    // Sides of whole spacings, with faces between the particles, make the boxes of a regular body equal.
    let side = (side / spacing).round().max(1.0) * spacing;
    let along = |i: usize| particles.iter().map(move |own| own.position[i]);
    let low: [f64; D] = array_of(|i| along(i).fold(f64::INFINITY, f64::min) - 0.5 * spacing);
    let mut boxes: BTreeMap<[i64; D], Vec<usize>> = BTreeMap::new();
    for (n, own) in particles.iter().enumerate() {
        let at = array_of(|i| ((own.position[i] - low[i]) / side).floor() as i64);
        boxes.entry(at).or_default().push(n);
    }
    // Forces on a particle reach twice the support: they depend on the gradients of its neighbors.
    let halo = 3.0 * reach;
    let near = (halo / side).ceil() as i64;
    let part = |at: &[i64; D]| {
        let outside = |n: usize| -> f64 {
            let over = (0..D).map(|i| {
                let x = particles[n].position[i] - low[i] - at[i] as f64 * side;
                (-x).max(x - side).max(0.0)
            });
            over.fold(0.0, f64::max)
        };
        let mut all = Vec::new();
        let range = |i: usize| at[i] - near..=at[i] + near;
        for (place, own) in &boxes {
            if (0..D).all(|i| range(i).contains(&place[i])) {
                all.extend(own.iter().copied().filter(|n| outside(*n) <= halo));
            }
        }
        all.sort_unstable();
        let is_free = all.iter().map(|n| outside(*n) <= reach).collect();
        Part { all, is_free }
    };
    boxes.keys().map(part).collect()
}

/// Crystal whose only cell holds the particles, without neighbors in other cells.
pub(super) fn isolated<const D: usize>(
    particles: &[PlacedParticle],
    gap: f64,
    spacing: f64,
) -> Result<Crystal<D>, BodyError> {
    let along = |i: usize| particles.iter().map(move |own| own.position[i]);
    let low: [f64; D] = array_of(|i| along(i).fold(f64::INFINITY, f64::min));
    let high: [f64; D] = array_of(|i| along(i).fold(f64::NEG_INFINITY, f64::max));
    // Equal sides: lattices of very different sides are refused as too elongated.
    let side = (0..D).map(|i| high[i] - low[i]).fold(0.0, f64::max) + gap;
    let lattice = BravaisLattice::new(SMatrix::identity() * side);
    let lattice = lattice.ok_or(BodyError::Empty)?;
    let place = |own: &PlacedParticle| SVector::from_fn(|i, _| (own.position[i] - low[i]) / side);
    let places = particles.iter().map(place).collect();
    let volumes = particles.iter().map(|own| own.volume).collect();
    let crystal = Crystal::with_volumes(lattice, places, volumes).map_err(MethodError::from)?;
    Ok(crystal.with_spacing(spacing).isolated())
}

/// Rows of a sparse matrix of blocks, divided by the masses.
struct Sparse<const D: usize> {
    /// First entry of each row, and the total number of entries.
    starts: Vec<usize>,
    entries: Vec<(u32, SMatrix<f64, D, D>)>,
}

impl<const D: usize> Sparse<D> {
    fn new(sum: &BlochSum<D>, masses: &[f64]) -> Self {
        let mut rows: Vec<Vec<(u32, SMatrix<f64, D, D>)>> = vec![Vec::new(); masses.len()];
        for (from, to, block) in sum.blocks() {
            rows[from].push((to.site as u32, block / masses[from]));
        }
        let mut starts = vec![0];
        let mut entries = Vec::new();
        for row in rows {
            entries.extend(row);
            starts.push(entries.len());
        }
        Self { starts, entries }
    }

    fn add_to(&self, image: &mut [f64], vector: &[f64], weight: f64) {
        for row in 0..self.starts.len() - 1 {
            let mut sum = SVector::<f64, D>::zeros();
            for (to, block) in &self.entries[self.starts[row]..self.starts[row + 1]] {
                let at = D * *to as usize;
                sum += block * SVector::<f64, D>::from_column_slice(&vector[at..at + D]);
            }
            for i in 0..D {
                image[D * row + i] += weight * sum[i];
            }
        }
    }
}

/// Part of the equations: a stiffness, which acts on smoothed velocities if the method smooths them.
struct Stiffness<const D: usize> {
    stiffness: Sparse<D>,
    drift: Option<Sparse<D>>,
}

impl<const D: usize> Stiffness<D> {
    fn new(system: &WaveSystem<D>) -> Self {
        let masses = system.particle_masses();
        let ones = vec![1.0; masses.len()];
        Self {
            stiffness: Sparse::new(system.stiffness(), &masses),
            drift: system.drift().map(|drift| Sparse::new(drift, &ones)),
        }
    }

    fn add_to(&self, image: &mut [f64], vector: &[f64], weight: f64) {
        match &self.drift {
            None => self.stiffness.add_to(image, vector, weight),
            Some(drift) => {
                let mut moved = vec![0.0; vector.len()];
                drift.add_to(&mut moved, vector, 1.0);
                self.stiffness.add_to(image, &moved, weight);
            }
        }
    }
}

/// Equations of motion `dv/dt = -(X + S + R) u - C v` of a body.
struct Operator<const D: usize> {
    whole: Stiffness<D>,
    /// Sum `S + R`, and `R` alone.
    carried: Option<(Stiffness<D>, Option<Stiffness<D>>)>,
    damping: Option<Sparse<D>>,
    unknowns: usize,
}

impl<const D: usize> Operator<D> {
    fn new(
        discretization: &dyn Discretization<D>,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Self, MethodError> {
        let system = discretization.waves(material, f)?;
        let carried = discretization.carried(material, f)?;
        let masses = system.particle_masses();
        Ok(Self {
            unknowns: D * masses.len(),
            damping: system.damping().map(|sum| Sparse::new(sum, &masses)),
            carried: carried.map(|carried| {
                let density = carried.density.as_ref().map(Stiffness::new);
                (Stiffness::new(&carried.all), density)
            }),
            whole: Stiffness::new(&system),
        })
    }

    /// Image of a vector under `a X + b S + c R`.
    fn image(&self, vector: &[f64], [of_x, of_s, of_r]: [f64; 3]) -> Vec<f64> {
        let mut image = vec![0.0; vector.len()];
        self.whole.add_to(&mut image, vector, of_x);
        if let Some((all, density)) = &self.carried {
            if of_s != of_x {
                all.add_to(&mut image, vector, of_s - of_x);
            }
            if let Some(density) = density.as_ref().filter(|_| of_r != of_s) {
                density.add_to(&mut image, vector, of_r - of_s);
            }
        }
        image
    }

    /// Fastest mode in which only free particles move.
    fn fastest(&self, free: &[bool], stepping: Stepping) -> Option<BodyMode> {
        let hold = |vector: &mut [f64]| {
            for (n, x) in vector.iter_mut().enumerate() {
                if !free[n / D] {
                    *x = 0.0;
                }
            }
        };
        let weights = stepping.weights();
        let found = largest_mode(
            self.unknowns,
            &mut |vector: &[f64], _| {
                crate::cancel::checkpoint();
                let mut vector = vector.to_vec();
                hold(&mut vector);
                let mut image = self.image(&vector, weights);
                hold(&mut image);
                Ok(image)
            },
            f64::NEG_INFINITY,
        );
        let (squared, mut mode) = found.ok().flatten()?;
        hold(&mut mode);
        let norm: f64 = mode.iter().map(|x| x * x).sum();
        let quotient = |image: &[f64]| {
            let sum: f64 = image.iter().zip(&mode).map(|(a, b)| a * b).sum();
            DMatrix::from_element(1, 1, Complex::new(sum / norm, 0.0))
        };
        let part = |weights| quotient(&self.image(&mode, weights));
        let damping = self.damping.as_ref().map(|damping| {
            let mut image = vec![0.0; mode.len()];
            damping.add_to(&mut image, &mode, 1.0);
            quotient(&image)
        });
        let size = |n: usize| -> f64 { mode[D * n..D * n + D].iter().map(|x| x * x).sum() };
        let particle = (0..free.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
        Some(BodyMode {
            squared,
            particle,
            parts: WaveParts {
                positions: part([1.0, 0.0, 0.0]),
                stress: part([0.0, 1.0, 0.0]),
                density: part([0.0, 0.0, 1.0]),
                damping: damping.unwrap_or_else(|| DMatrix::zeros(1, 1)),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_OPERATOR_PARTICLES, PlacedParticle, fastest_mode};
    use crate::kinematics::DeformationGradient;
    use crate::material::ModifiedMooneyRivlin;
    use crate::method::KernelMethodChoices;
    use crate::motion::{BodyParticles, Start, with_body};
    use crate::scheme::MethodChoices;
    use crate::scheme::sph::TotalLagrangianChoices;
    use crate::time_step::Stepping;

    fn block(columns: usize, rows: usize) -> Vec<PlacedParticle> {
        let at = |n: usize| PlacedParticle {
            position: [(n % columns) as f64, (n / columns) as f64, 0.0],
            volume: 1.0,
        };
        (0..columns * rows).map(at).collect()
    }

    fn total_lagrangian() -> MethodChoices {
        let particles = KernelMethodChoices {
            support: 2.01,
            ..KernelMethodChoices::default()
        };
        let choices = TotalLagrangianChoices {
            penalty: 0.3,
            ..TotalLagrangianChoices::default()
        };
        MethodChoices::TotalLagrangianSph(Box::new(particles), choices)
    }

    #[test]
    fn the_step_of_a_block_agrees_with_the_engine_of_bodies() {
        let (choices, law) = (total_lagrangian(), ModifiedMooneyRivlin::default());
        let f = DeformationGradient::from_stretches([1.1, 0.97, 1.0]).expect("stretches");
        let particles = block(7, 5);
        let stepping = Stepping::VelocityVerlet;
        let mode = fastest_mode::<2>(&choices, &law, &particles, &[false; 35], &f, stepping);
        let own = mode
            .expect("a method")
            .expect("a mode")
            .critical_time_step(stepping);
        let discretization = choices.discretization::<2>().expect("a discretization");
        let given = BodyParticles::Given(particles);
        let mut of_engine = 0.0;
        let start = Start {
            f,
            noise: 0.0,
            seed: 1,
        };
        with_body(&*discretization, &law, &given, &[], None, &mut |body| {
            body.start(&start, 0.0).expect("forces");
            of_engine = body.critical_time_step().expect("a step");
        })
        .expect("a body");
        assert!((own / of_engine - 1.0).abs() < 1e-5, "{own} {of_engine}");
    }

    #[test]
    fn dividing_a_body_does_not_change_its_time_step() {
        let (choices, law) = (total_lagrangian(), ModifiedMooneyRivlin::default());
        let f = DeformationGradient::identity();
        let stepping = Stepping::ExtrapolatedStress;
        let step = |columns: usize, rows: usize| {
            let particles = block(columns, rows);
            let held = vec![false; particles.len()];
            let mode = fastest_mode::<2>(&choices, &law, &particles, &held, &f, stepping);
            mode.expect("a method")
                .expect("a mode")
                .critical_time_step(stepping)
        };
        let (small, large) = (step(20, 20), step(2 * MAX_OPERATOR_PARTICLES / 60 + 20, 62));
        assert!((small / large - 1.0).abs() < 1e-3, "{small} {large}");
    }
}
