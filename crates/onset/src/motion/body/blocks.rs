//! Critical time steps of free blocks cut out of a lattice, which represent all finite bodies.

use super::{BodyParticles, Shape, Start, with_body};
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::scheme::Discretization;

/// Particles across the thinnest blocks. With two rows, gradients are far stiffer than with three, and such bodies are rarely intended.
const THINNEST: usize = 3;
/// Largest number of particles along the sides of a block, in one to three dimensions.
const MAXIMUM_SIDE: [usize; 3] = [16, 12, 8];

/// Safety factor of the smallest step: waves along faces of other lengths than in these blocks are faster by up to half a percent.
const MARGIN: f64 = 0.98;

/// Returns the smallest critical time step of free blocks in a homogeneous state, less two percent; time. `None` for methods without bodies.
///
/// The blocks are from three particles thick to wider than the range of the forces and include corners, edges and faces. The step is computed, not
/// proved: a particle that protrudes from a corner may need a smaller step.
pub(crate) fn step_of_free_blocks<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Option<f64> {
    let ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI][D - 1];
    let reach = (discretization.neighbors() / ball).powf(1.0 / D as f64);
    let widest = (2 * reach.ceil() as usize + 2).clamp(THINNEST, MAXIMUM_SIDE[D - 1]);
    let cubes = (THINNEST..=widest).filter(|n| D < 3 || *n <= THINNEST + 1 || *n == widest);
    let mut blocks: Vec<[usize; D]> = cubes.map(|n| [n; D]).collect();
    // Strips, plates and bars.
    blocks.extend((1..D).map(|thin| {
        let side = |i| if i < thin { THINNEST } else { widest };
        std::array::from_fn(side)
    }));
    let start = Start {
        f: *f,
        noise: 0.0,
        seed: 1,
    };
    let spacing = discretization.crystal().spacing();
    let mut least: Option<f64> = None;
    for block in blocks {
        let particles = BodyParticles::Cut(Shape::Block {
            size: block.iter().map(|n| *n as f64 * spacing).collect(),
            hole: None,
            notch: None,
        });
        let mut found = None;
        let made = with_body(
            discretization,
            material,
            &particles,
            &[],
            None,
            &mut |body| {
                let step = body
                    .start(&start, 0.0)
                    .and_then(|()| body.critical_time_step());
                found = step.ok();
            },
        );
        // Blocks without a state are skipped: they have too few neighbors, or the law is not defined.
        if let (Ok(()), Some(step)) = (made, found) {
            least = Some(least.map_or(step, |least| least.min(step)));
        }
    }
    least.map(|least| MARGIN * least)
}
