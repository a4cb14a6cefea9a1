//! Critical time steps of free blocks cut out of a lattice, which represent all finite bodies.

use super::stability::largest_eigenvalue;
use super::{BodyError, BodyMotion, BodyParticles, PlacedParticle, Shape, Start, with_body};
use crate::bloch::BlochSum;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::{Hyperelastic, Linearized};
use crate::scheme::Discretization;
use crate::time_step::Stepping;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

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
    // A rotation changes no frequency. Raw gradients are not exact at faces, where a rotation would strain the particles.
    let upright = &right_stretch::<D>(f);
    let rotation = upright.matrix() * f.matrix().try_inverse()?;
    let solid = Linearized::about(material, f)
        .ok()?
        .rotated(&rotation, upright);
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
    let spacing = discretization.crystal().spacing();
    let vectors = discretization.crystal().lattice().vectors();
    let is_oblique = !is_diagonal(vectors);
    // Blocks without a state are skipped: they have too few neighbors, or the law is not defined.
    let steps = blocks.iter().filter_map(|sides| match has_bodies {
        true => {
            let along_axes = step_of_body(discretization, &solid, upright, &block(sides, spacing));
            let along_rows = is_oblique.then(|| rows(discretization, sides));
            let along_rows =
                along_rows.and_then(|body| step_of_body(discretization, &solid, upright, &body));
            along_axes.into_iter().chain(along_rows).reduce(f64::min)
        }
        false => step_of_cells(&*discretization.on_block(*sides).ok()??, material, f),
    });
    steps.reduce(f64::min).map(|least| MARGIN * least)
}

/// Right stretch `U` of a deformation gradient `F = R U`.
fn right_stretch<const D: usize>(f: &DeformationGradient) -> DeformationGradient {
    let leading = f.leading::<D>();
    let squared = leading.transpose() * leading;
    let squared = DMatrix::from_fn(D, D, |i, j| squared[(i, j)]).symmetric_eigen();
    let axes = &squared.eigenvectors;
    let stretches = DMatrix::from_diagonal(&squared.eigenvalues.map(f64::sqrt));
    let stretch = axes * stretches * axes.transpose();
    f.with_leading(&SMatrix::<f64, D, D>::from_fn(|i, j| stretch[(i, j)]))
}

/// Block with a number of particles along each side.
fn block<const D: usize>(sides: &[usize; D], spacing: f64) -> BodyParticles {
    BodyParticles::Cut(Shape::Block {
        size: sides.iter().map(|n| *n as f64 * spacing).collect(),
        hole: None,
        notch: None,
    })
}

/// Body with faces along the rows of the lattice, which meet at the sharp corners of an oblique lattice.
fn rows<const D: usize>(
    discretization: &dyn Discretization<D>,
    sides: &[usize; D],
) -> BodyParticles {
    let crystal = discretization.crystal();
    let count = sides.iter().product::<usize>();
    let cell = |mut n: usize| -> [i32; D] {
        std::array::from_fn(|i| {
            let own = n % sides[i];
            n /= sides[i];
            own as i32
        })
    };
    let sites = 0..crystal.sites().len();
    let all = (0..count).flat_map(|n| sites.clone().map(move |site| (site, n)));
    let placed = all.map(|(site, n)| {
        let position = crystal.position(&Particle {
            site,
            cell: cell(n),
        });
        PlacedParticle {
            position: std::array::from_fn(|i| position.get(i).copied().unwrap_or(0.0)),
            volume: crystal.volumes()[site],
        }
    });
    BodyParticles::Given(placed.collect())
}

/// Returns true if each row of a matrix has one entry that is not zero.
fn is_diagonal<const D: usize>(vectors: &SMatrix<f64, D, D>) -> bool {
    let largest = vectors.amax();
    let is_entry = |x: &&f64| x.abs() > 1e-9 * largest;
    let mut rows = vectors.row_iter();
    rows.all(|row| row.iter().filter(is_entry).count() == 1)
}

/// Critical step of a body in motion.
fn step_of_body<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    particles: &BodyParticles,
) -> Option<f64> {
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
    with_body(discretization, material, particles, &[], None, &mut work).ok()?;
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
