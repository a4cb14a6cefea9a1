//! Critical time steps of free blocks cut out of a lattice, which represent all finite bodies.

use super::stability::largest_eigenvalue;
use super::{BodyError, BodyMotion, BodyParticles, Shape, Start, with_body};
use crate::bloch::BlochSum;
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError, Response};
use crate::scheme::Discretization;
use crate::time_step::Stepping;
use nalgebra::{DMatrix, DVector, SVector};

/// Number of particles across the thinnest blocks. With two rows, gradients are far stiffer than with three, and such bodies are rarely intended.
const THINNEST: usize = 3;
/// Largest number of particles along the sides of a block, in one to three dimensions.
const MAXIMUM_SIDE: [usize; 3] = [16, 12, 8];
/// Largest number of cells along the sides of a block, for methods without a moving body, whose stiffness matrix is assembled.
const MAXIMUM_CELLS: [usize; 3] = [16, 12, 5];

/// Safety factor of the smallest step: waves along faces whose lengths differ from these blocks are faster by up to half a percent.
const MARGIN: f64 = 0.98;

/// Returns the smallest critical time step of free blocks in a homogeneous state, less two percent; time. `None` for methods whose forces are not
/// defined for finite bodies.
///
/// The sizes of the blocks range from three particles to more than the range of the forces, and include corners, edges and faces. The step is
/// computed, not proved: a particle that protrudes from a corner may need a smaller step.
pub(crate) fn step_of_free_blocks<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Option<f64> {
    let ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI][D - 1];
    let reach = (discretization.neighbors() / ball).powf(1.0 / D as f64);
    let solid = LinearSolid::new(material, f).ok()?;
    let is_cut = with_body(
        discretization,
        &solid,
        &block::<D>(&[THINNEST; D], discretization.crystal().spacing()),
        &[],
        None,
        &mut |_| (),
    );
    let has_bodies = !matches!(is_cut, Err(BodyError::NoBodies));
    let most = if has_bodies {
        MAXIMUM_SIDE
    } else {
        MAXIMUM_CELLS
    };
    let widest = (2 * reach.ceil() as usize + 2).clamp(THINNEST, most[D - 1]);
    let cubes = (THINNEST..=widest).filter(|n| D < 3 || *n <= THINNEST + 1 || *n == widest);
    let mut blocks: Vec<[usize; D]> = cubes.map(|n| [n; D]).collect();
    // Strips, plates and bars.
    blocks.extend((1..D).map(|thin| {
        let side = |i| if i < thin { THINNEST } else { widest };
        std::array::from_fn(side)
    }));
    // Blocks without a state are skipped: they have too few neighbors, or the law is not defined.
    let steps = blocks.iter().filter_map(|sides| match has_bodies {
        true => step_of_body(discretization, &solid, f, sides),
        false => step_of_cells(&*discretization.on_block(*sides).ok()??, material, f),
    });
    steps.reduce(f64::min).map(|least| MARGIN * least)
}

/// Block with a number of particles along each side.
fn block<const D: usize>(sides: &[usize; D], spacing: f64) -> BodyParticles {
    BodyParticles::Cut(Shape::Block {
        size: sides.iter().map(|n| *n as f64 * spacing).collect(),
        hole: None,
        notch: None,
    })
}

/// Critical step of a body in motion.
fn step_of_body<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    sides: &[usize; D],
) -> Option<f64> {
    let particles = block(sides, discretization.crystal().spacing());
    let start = Start {
        f: *f,
        noise: 0.0,
        seed: 1,
    };
    let mut found = None;
    let mut work = |body: &mut dyn BodyMotion| {
        let started = body.start(&start, 0.0);
        found = started.and_then(|()| body.critical_time_step()).ok();
    };
    with_body(discretization, material, &particles, &[], None, &mut work).ok()?;
    found
}

/// Critical step of a method on the particles of a block, which form a single cell.
fn step_of_cells<const D: usize>(
    block: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Option<f64> {
    let system = block.waves(material, f).ok()?;
    if system.drift().is_some() {
        return None;
    }
    let masses = system.particle_masses();
    let largest = |sum: &BlochSum<D>| {
        let matrix = sum.at(&SVector::zeros());
        let size = matrix.nrows();
        let over_mass = DMatrix::from_fn(size, size, |i, j| matrix[(i, j)].re / masses[i / D]);
        let image = |own: &[f64], _| {
            let product = &over_mass * DVector::from_column_slice(own);
            Ok(product.as_slice().to_vec())
        };
        largest_eigenvalue(size, &mut { image }).ok()
    };
    let squared = largest(system.stiffness())?;
    let damping = system.damping().map_or(Some(0.0), largest)?;
    let step = Stepping::VelocityVerlet.critical_step(squared, damping);
    (step > 0.0 && step.is_finite()).then_some(step)
}

/// Law with the tangent of one state, `P = P_0 + A (F - F_0)`. A law that is a function of another program is then evaluated only twice, not once for
/// each particle and each product of the iteration. The reference state keeps its exact response, which scales penalties and viscosities.
struct LinearSolid<'a> {
    material: &'a dyn Hyperelastic,
    state: Response,
    undeformed: Result<Response, MaterialError>,
}

impl<'a> LinearSolid<'a> {
    fn new(material: &'a dyn Hyperelastic, f: &DeformationGradient) -> Result<Self, MaterialError> {
        Ok(Self {
            material,
            state: Response {
                deformation: *f,
                ..material.response(f)?
            },
            undeformed: material.undeformed(),
        })
    }
}

impl Hyperelastic for LinearSolid<'_> {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        if *f == DeformationGradient::identity() {
            return self.undeformed.clone();
        }
        let Response {
            deformation: base,
            energy,
            first_piola,
            tangent,
        } = &self.state;
        let (own, base) = (f.components(), base.components());
        let (mut stress, mut energy) = (*first_piola, *energy);
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    for l in 0..3 {
                        stress[(i, j)] += tangent[(i, j, k, l)] * (own[k][l] - base[k][l]);
                    }
                }
                let mean = 0.5 * (first_piola[(i, j)] + stress[(i, j)]);
                energy += mean * (own[i][j] - base[i][j]);
            }
        }
        Ok(Response {
            deformation: *f,
            energy,
            first_piola: stress,
            tangent: tangent.clone(),
        })
    }

    fn dimension(&self) -> usize {
        self.material.dimension()
    }

    fn undeformed(&self) -> Result<Response, MaterialError> {
        self.undeformed.clone()
    }

    fn is_path_dependent(&self) -> bool {
        self.material.is_path_dependent()
    }
}
