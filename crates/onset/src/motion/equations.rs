//! Equations of motion of a periodic patch.

use crate::algebra::array_of;
use crate::bloch::{BlochSum, Mass, WaveSystem};
use crate::lattice::Particle;
use crate::scheme::{NoForce, PatchForces, PeriodicPatch};
use nalgebra::SVector;

/// Points and weights of Gauss's five-point rule on the interval from 0 to 1, exact up to degree nine.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];
/// Relative residual for the solution with a consistent mass matrix.
const RESIDUAL_TOLERANCE: f64 = 1e-15;
/// Largest number of iterations of this solution. Mass matrices of elements need about thirty.
const ITERATIONS: usize = 200;

/// Vector field on a patch.
pub(super) type Field<const D: usize> = Vec<SVector<f64, D>>;

/// Components of a field, vector by vector.
pub(super) fn flat<const D: usize>(field: &[SVector<f64, D>]) -> Vec<f64> {
    field.iter().flatten().copied().collect()
}

/// Field of `count` vectors from their components, with zeros for missing vectors.
pub(super) fn field_of<const D: usize>(flat: &[f64], count: usize) -> Field<D> {
    let own = flat.chunks_exact(D).map(SVector::from_column_slice);
    let mut field: Field<D> = own.collect();
    field.resize(count, SVector::zeros());
    field
}

/// Vectors of a field, extended to three components.
pub(super) fn in_space<const D: usize>(field: &[SVector<f64, D>]) -> Vec<[f64; 3]> {
    let own = |x: &SVector<f64, D>| array_of(|i| x.get(i).copied().unwrap_or(0.0));
    field.iter().map(own).collect()
}

/// Sum over the neighbors of every particle of a patch: pairs of numbers and factors.
struct Rows<const D: usize> {
    rows: Vec<Vec<(usize, nalgebra::SMatrix<f64, D, D>)>>,
}

impl<const D: usize> Rows<D> {
    fn new(patch: &PeriodicPatch<D>, sum: &BlochSum<D>) -> Self {
        let mut rows = vec![Vec::new(); patch.len()];
        for origin in patch.origins() {
            for (site, to, block) in sum.blocks() {
                let from = patch.number(&Particle { site, cell: origin });
                rows[from].push((patch.number(&to.moved(&origin)), *block));
            }
        }
        Self { rows }
    }

    fn times(&self, field: &[SVector<f64, D>]) -> Field<D> {
        let row = |terms: &Vec<(usize, nalgebra::SMatrix<f64, D, D>)>| {
            terms.iter().map(|(to, block)| block * field[*to]).sum()
        };
        self.rows.iter().map(row).collect()
    }
}

enum Inertia<const D: usize> {
    Lumped(Vec<f64>),
    Consistent(Rows<D>),
}

/// Equations of motion `M dv/dt = f(u, v) - f(0, 0)`, `du/dt = T v`.
pub(super) struct Equations<'a, const D: usize> {
    forces: &'a dyn PatchForces<D>,
    /// Forces `f(0, 0)` of the homogeneous state.
    dead: Field<D>,
    inertia: Inertia<D>,
    drift: Option<Rows<D>>,
}

fn dot<const D: usize>(a: &[SVector<f64, D>], b: &[SVector<f64, D>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

impl<'a, const D: usize> Equations<'a, D> {
    /// Builds the equations with the masses and the smoothing of the waves.
    pub(super) fn new(
        patch: &PeriodicPatch<D>,
        system: &WaveSystem<D>,
        forces: &'a dyn PatchForces<D>,
    ) -> Result<Self, NoForce> {
        let at_rest = vec![SVector::zeros(); patch.len()];
        let inertia = match system.mass() {
            Mass::Lumped(masses) => {
                let particles = patch.particles();
                Inertia::Lumped(particles.iter().map(|own| masses[own.site]).collect())
            }
            Mass::Consistent(sum) => Inertia::Consistent(Rows::new(patch, sum)),
        };
        Ok(Self {
            dead: forces.at(&at_rest, &at_rest)?,
            forces,
            inertia,
            drift: system.drift().map(|sum| Rows::new(patch, sum)),
        })
    }

    /// Forces `f(u, v) - f(0, 0)` on the particles.
    fn force(&self, u: &[SVector<f64, D>], v: &[SVector<f64, D>]) -> Result<Field<D>, NoForce> {
        let mut force = self.forces.at(u, v)?;
        force.iter_mut().zip(&self.dead).for_each(|(f, d)| *f -= d);
        Ok(force)
    }

    /// Accelerations `dv/dt` of the particles.
    pub(super) fn acceleration(
        &self,
        u: &[SVector<f64, D>],
        v: &[SVector<f64, D>],
    ) -> Result<Field<D>, NoForce> {
        let mut force = self.force(u, v)?;
        match &self.inertia {
            Inertia::Lumped(masses) => {
                force.iter_mut().zip(masses).for_each(|(f, m)| *f /= *m);
                Ok(force)
            }
            Inertia::Consistent(mass) => Ok(solved(mass, &force)),
        }
    }

    /// Rates `du/dt` of the displacements.
    pub(super) fn drift(&self, v: &[SVector<f64, D>]) -> Field<D> {
        match &self.drift {
            Some(rows) => rows.times(v),
            None => v.to_vec(),
        }
    }

    /// Momenta `M v` of the particles.
    fn momenta(&self, v: &[SVector<f64, D>]) -> Field<D> {
        match &self.inertia {
            Inertia::Lumped(masses) => v.iter().zip(masses).map(|(v, m)| v * *m).collect(),
            Inertia::Consistent(mass) => mass.times(v),
        }
    }

    /// Kinetic energy `T v.M v / 2`. With smoothed velocities `T v` this product with the momenta is the conserved quantity.
    pub(super) fn kinetic_energy(&self, v: &[SVector<f64, D>]) -> f64 {
        0.5 * dot(&self.momenta(v), &self.drift(v))
    }

    /// Total momentum, the sum of `M v`.
    pub(super) fn momentum(&self, v: &[SVector<f64, D>]) -> SVector<f64, D> {
        self.momenta(v).iter().sum()
    }

    /// Work against the forces at zero velocity along the straight path from the homogeneous state to the given displacements. It is the potential
    /// energy if the forces have a potential.
    pub(super) fn work(&self, u: &[SVector<f64, D>]) -> Result<f64, NoForce> {
        let at_rest = vec![SVector::zeros(); u.len()];
        let mut work = 0.0;
        for (place, weight) in GAUSS {
            let part: Field<D> = u.iter().map(|u| u * place).collect();
            work -= weight * dot(&self.force(&part, &at_rest)?, u);
        }
        Ok(work)
    }
}

/// Solves `M^-1 f` by conjugate gradients.
fn solved<const D: usize>(mass: &Rows<D>, force: &[SVector<f64, D>]) -> Field<D> {
    let mut solution = vec![SVector::zeros(); force.len()];
    let mut left = force.to_vec();
    let mut direction = left.clone();
    let mut size = dot(&left, &left);
    let enough = size * RESIDUAL_TOLERANCE * RESIDUAL_TOLERANCE;
    for _ in 0..ITERATIONS {
        if size <= enough || size.is_nan() {
            break;
        }
        let image = mass.times(&direction);
        let along = size / dot(&direction, &image);
        for (own, d) in solution.iter_mut().zip(&direction) {
            *own += d * along;
        }
        for (own, d) in left.iter_mut().zip(&image) {
            *own -= d * along;
        }
        let next = dot(&left, &left);
        let kept = next / size;
        for (d, own) in direction.iter_mut().zip(&left) {
            *d = own + *d * kept;
        }
        size = next;
    }
    solution
}
