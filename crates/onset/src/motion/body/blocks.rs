//! Free blocks cut out of a lattice, which stand for all its finite bodies.

use super::{BodyParticles, Shape, Start, with_body};
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::scheme::Discretization;

/// Particles across the thinnest blocks: gradients of two rows are far stiffer than of three, and hardly anybody means them.
const THINNEST: usize = 3;
/// Particles along the sides of the widest blocks, at most, in one to three dimensions.
const WIDEST: [usize; 3] = [16, 12, 8];

/// Share of the smallest step: waves along faces of other lengths than those of these blocks are faster by up to half a percent.
const MARGIN: f64 = 0.98;

/// The smallest critical step of free blocks at a homogeneous state, from three particles thick to wider than forces reach, less two percent: of their corners, edges
/// and faces. `None` of methods without bodies. Found, not proved: a particle that sticks out of a corner may need less. Time.
pub(crate) fn step_of_free_blocks<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Option<f64> {
    let ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI][D - 1];
    let reach = (discretization.neighbors() / ball).powf(1.0 / D as f64);
    let widest = (2 * reach.ceil() as usize + 2).clamp(THINNEST, WIDEST[D - 1]);
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
        // Blocks without a state are skipped: too few neighbors, or a law that is not defined.
        if let (Ok(()), Some(step)) = (made, found) {
            least = Some(least.map_or(step, |least| least.min(step)));
        }
    }
    least.map(|least| MARGIN * least)
}
