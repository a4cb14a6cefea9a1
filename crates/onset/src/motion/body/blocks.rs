//! Fastest oscillations of free blocks cut out of a lattice, which represent all finite bodies.

use super::stability::largest_eigenvalue;
use super::{BodyError, BodyMotion, BodyParticles, PlacedParticle, Shape, Start, with_body};
use crate::algebra::array_of;
use crate::bloch::BlochSum;
use crate::cores::of_each;
use crate::kinematics::DeformationGradient;
use crate::lattice::{BravaisLattice, Crystal, Fractional, Particle, Reduced, cells_between};
use crate::material::{Hyperelastic, Linearized};
use crate::scheme::Discretization;
use crate::time_step::Oscillation;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use std::cmp::Reverse;
use std::sync::{Arc, Mutex, PoisonError};

/// Number of particles across the thinnest blocks. With two rows, gradients are far stiffer than with three, and such bodies are rarely intended.
const THINNEST: usize = 3;
/// Largest number of particles along the sides of a block, in one to three dimensions.
const MAXIMUM_SIDE: [usize; 3] = [16, 12, 8];
/// Largest number of cells along the sides of a block, for methods without a moving body, whose stiffness matrix is assembled.
const MAXIMUM_CELLS: [usize; 3] = [16, 12, 5];

/// Safety factor of steps: waves along faces whose lengths differ from these blocks are faster by up to half a percent.
const MARGIN: f64 = 0.98;

/// Returns the largest eigenvalues of stiffness and damping of free blocks in a homogeneous state, enlarged so that steps are two percent smaller. `None`
/// for methods whose forces are not defined for finite bodies.
///
/// The sizes of the blocks range from three particles to more than the range of the forces, and include corners, edges and faces. A block is also
/// tried in every position in which a symmetry of the crystal puts it, so that mirror images of a state have the same step. Blocks of a crystal with
/// several particles a cell begin at each of them: the step does not depend on the basis and the origin that describe the crystal. The step is
/// computed, not proved: a particle that protrudes from a corner may need a smaller step.
pub(crate) fn oscillation_of_free_blocks<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Option<Oscillation> {
    let ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI][D - 1];
    let reach = (discretization.neighbors() / ball).powf(1.0 / D as f64);
    // A rotation changes no frequency. Raw gradients are not exact at faces, where a rotation would strain the particles.
    let upright = &right_stretch::<D>(f);
    let rotation = upright.matrix() * f.matrix().try_inverse()?;
    let solid = Linearized::about(material, f)
        .ok()?
        .rotated(&rotation, upright);
    let crystal = &discretization.crystal().reduced(&SVector::zeros()).ok()?;
    let axes = axes(crystal.lattice());
    let of_rows = crystal.origins();
    let is_cut = with_body(
        discretization,
        &solid,
        &turned_block(crystal, &axes, &[THINNEST; D], &SVector::zeros()),
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
    let cubes: Vec<[usize; D]> = cubes.map(|n| [n; D]).collect();
    // Strips, plates and bars.
    let thin = (1..(1 << D) - 1).map(|thin| {
        let side = |i| if thin >> i & 1 == 1 { THINNEST } else { widest };
        std::array::from_fn(side)
    });
    let thin: Vec<[usize; D]> = thin.filter(|_| widest > THINNEST).collect();
    let rows = crystal.lattice().vectors();
    let mut blocks = Vec::new();
    if has_bodies {
        blocks.extend(cubes.iter().chain(&thin).map(|sides| (false, *sides)));
    }
    if !has_bodies || !is_diagonal(&(axes.transpose() * rows)) {
        // Oblique plates and bars in space are left out: they would take longer than all other blocks.
        let of_rows = cubes
            .iter()
            .chain(thin.iter().filter(|_| D < 3 || !has_bodies));
        blocks.extend(of_rows.map(|sides| (true, *sides)));
    }
    let maps: Vec<_> = crystal
        .maps()
        .into_iter()
        .map(|map| {
            (
                map,
                DeformationGradient::identity().with_leading(&map).matrix(),
            )
        })
        .collect();
    let same: Vec<_> = maps
        .iter()
        .filter(|(_, map)| solid.turned(map).equals(&solid))
        .collect();
    let mut known: Vec<(bool, SMatrix<f64, D, D>)> = Vec::new();
    let mut cuts = Vec::new();
    for (is_of_rows, sides) in blocks {
        let sides = match is_of_rows {
            true => array_of(|i| sides[i].div_ceil(particles_along(crystal, i))),
            false => sides,
        };
        let edges = if is_of_rows { rows } else { &axes };
        let edges = edges * SMatrix::from_diagonal(&SVector::from_fn(|i, _| sides[i] as f64));
        for (map, in_space) in &maps {
            let turned = map * edges;
            let is_image = |(kind, other): &(bool, SMatrix<f64, D, D>)| {
                *kind == is_of_rows
                    && same
                        .iter()
                        .any(|(own, _)| are_alike(&(own * other), &turned))
            };
            if known.iter().any(is_image) {
                continue;
            }
            known.push((is_of_rows, turned));
            // The turned block in this state is the block in the state turned back.
            let solid = Arc::new(solid.turned(&in_space.transpose()));
            let origins = match is_of_rows {
                true => &of_rows,
                false => crystal.sites(),
            };
            cuts.extend(origins.iter().map(|origin| Cut {
                is_of_rows,
                sides,
                solid: Arc::clone(&solid),
                origin: *origin,
            }));
        }
    }
    // A large block has corners, edges and faces, so that most smaller ones have no smaller step.
    cuts.sort_by_key(|cut: &Cut<D>| Reverse(cut.sides.iter().product::<usize>()));
    // Blocks without a state are skipped: they have too few neighbors, or the law is not defined.
    let oscillation = |cut: &Cut<D>, known: Oscillation| {
        let state = cut.solid.state();
        match (has_bodies, cut.is_of_rows) {
            (true, false) => {
                let block = turned_block(crystal, &axes, &cut.sides, &cut.origin);
                of_body(discretization, &*cut.solid, state, &block, known)
            }
            (true, true) => {
                let block = block_of_rows(&crystal.reduced(&cut.origin).ok()?, &cut.sides);
                of_body(discretization, &*cut.solid, state, &block, known)
            }
            (false, _) => {
                let block = discretization.on_block(cut.sides, &cut.origin);
                of_cells(&*block.ok().flatten()?, &*cut.solid, state, known)
            }
        }
    };
    let fastest = Mutex::new(Oscillation::NONE);
    let known = || *fastest.lock().unwrap_or_else(PoisonError::into_inner);
    of_each(cuts, |cut| {
        if let Some(own) = oscillation(&cut, known()) {
            let mut fastest = fastest.lock().unwrap_or_else(PoisonError::into_inner);
            *fastest = fastest.or(own);
        }
    });
    let Oscillation { squared, damping } = known();
    (squared > f64::NEG_INFINITY).then(|| Oscillation {
        squared: squared / MARGIN.powi(2),
        damping: damping / MARGIN,
    })
}

/// Block that is cut out of a crystal.
struct Cut<const D: usize> {
    /// True for faces along the rows of the lattice, false for faces normal to its axes.
    is_of_rows: bool,
    sides: [usize; D],
    /// Linearized law in the position of the block.
    solid: Arc<Linearized>,
    origin: Fractional<D>,
}

/// Orthogonal axes of a lattice, in columns: axes of rotation by half a turn that the most symmetries exchange, the shortest of equally symmetric ones;
/// without them, its shortest row and the perpendicular directions.
fn axes<const D: usize>(lattice: &BravaisLattice<D>) -> SMatrix<f64, D, D> {
    let vectors = lattice.vectors();
    let short = Reduced::canonical(vectors).map_or(*vectors, |reduced| reduced.vectors);
    let maps = lattice.holohedry();
    let mut found: Vec<SVector<f64, D>> = Vec::new();
    for map in maps.iter().filter(|_| D == 3) {
        // Half a turn about `e` is `2 e (x) e - 1`.
        let twice = map + SMatrix::identity();
        let is_half_turn =
            (map.trace() + 1.0).abs() < 1e-9 && (map * map - SMatrix::identity()).amax() < 1e-9;
        let column = (0..D).max_by(|i, j| twice[(*i, *i)].total_cmp(&twice[(*j, *j)]));
        found.extend(
            column
                .filter(|_| is_half_turn)
                .map(|i| twice.column(i).normalize()),
        );
    }
    let is_right = |a: &SVector<f64, D>, b: &SVector<f64, D>| a.dot(b).abs() < 1e-9;
    let mut best: Option<(usize, SMatrix<f64, D, D>)> = None;
    for (n, a) in found.iter().enumerate() {
        for (m, b) in found
            .iter()
            .enumerate()
            .take(n)
            .filter(|(_, b)| is_right(a, b))
        {
            for c in found
                .iter()
                .take(m)
                .filter(|c| is_right(a, c) && is_right(b, c))
            {
                let own = [c, b, a];
                let triad = SMatrix::from_fn(|i, j| own[j][i]);
                let kept = maps
                    .iter()
                    .filter(|map| are_alike(&(*map * triad), &triad))
                    .count();
                if best.is_none_or(|(most, _)| kept > most) {
                    best = Some((kept, triad));
                }
            }
        }
    }
    let axes = best.map_or(short, |(_, triad)| triad);
    // Gram and Schmidt: unit vectors for a triad and for other lattices.
    let mut own = axes;
    for i in 0..D {
        let mut along: SVector<f64, D> = own.column(i).into_owned();
        for j in 0..i {
            let earlier: SVector<f64, D> = own.column(j).into_owned();
            along -= earlier * earlier.dot(&along);
        }
        own.set_column(i, &along.normalize());
    }
    // The order of the axes is arbitrary.
    match is_diagonal(&own) {
        true => SMatrix::identity(),
        false => own,
    }
}

/// Returns true if two sets of vectors in columns are equal up to order and signs.
fn are_alike<const D: usize>(a: &SMatrix<f64, D, D>, b: &SMatrix<f64, D, D>) -> bool {
    let size = a.amax();
    a.column_iter().all(|own| {
        let mut others = b.column_iter();
        others.any(|other| {
            let apart = (own - other).amax().min((own + other).amax());
            apart <= 1e-9 * size
        })
    })
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

/// Number of particles along a vector of a lattice, at least one.
fn particles_along<const D: usize>(crystal: &Crystal<D>, i: usize) -> usize {
    let length = crystal.lattice().vectors().column(i).norm() / crystal.spacing();
    (length * (1.0 + 1e-9)).clamp(1.0, crystal.sites().len() as f64) as usize
}

/// Block with a number of particles along each of the axes, which begins half a spacing before an origin.
fn turned_block<const D: usize>(
    crystal: &Crystal<D>,
    axes: &SMatrix<f64, D, D>,
    sides: &[usize; D],
    origin: &Fractional<D>,
) -> BodyParticles {
    let spacing = crystal.spacing();
    if crystal.sites().len() == 1 && *axes == SMatrix::<f64, D, D>::identity() {
        return BodyParticles::Cut(Shape::Block {
            size: sides.iter().map(|n| *n as f64 * spacing).collect(),
            hole: None,
            notch: None,
        });
    }
    let size = SVector::<f64, D>::from_fn(|i, _| sides[i] as f64 * spacing);
    let back = axes.transpose();
    let corner = crystal.lattice().vectors() * origin;
    let inside = crystal.within(origin, size.norm() + spacing, &SMatrix::identity());
    let placed = inside.into_iter().filter_map(|particle| {
        let own = (back * (crystal.position(&particle) - corner)).add_scalar(0.5 * spacing);
        let rim = 1e-9 * spacing;
        let is_in = own
            .iter()
            .zip(size.iter())
            .all(|(x, side)| (-rim..=side + rim).contains(x));
        is_in.then(|| given(crystal, &particle))
    });
    BodyParticles::Given(placed.collect())
}

/// Body with faces along the rows of the lattice, which meet at the sharp corners of an oblique lattice.
fn block_of_rows<const D: usize>(crystal: &Crystal<D>, sides: &[usize; D]) -> BodyParticles {
    let cells = cells_between(&[0; D], &array_of(|i| sides[i] as i32 - 1));
    let sites = 0..crystal.sites().len();
    let all = cells
        .into_iter()
        .flat_map(|cell| sites.clone().map(move |site| Particle { site, cell }));
    BodyParticles::Given(all.map(|particle| given(crystal, &particle)).collect())
}

fn given<const D: usize>(crystal: &Crystal<D>, particle: &Particle<D>) -> PlacedParticle {
    let position = crystal.position(particle);
    PlacedParticle {
        position: std::array::from_fn(|i| position.get(i).copied().unwrap_or(0.0)),
        volume: crystal.volumes()[particle.site],
    }
}

/// Returns true if each row of a matrix has one entry that is not zero.
fn is_diagonal<const D: usize>(vectors: &SMatrix<f64, D, D>) -> bool {
    let largest = vectors.amax();
    let is_entry = |x: &&f64| x.abs() > 1e-9 * largest;
    let mut rows = vectors.row_iter();
    rows.all(|row| row.iter().filter(is_entry).count() == 1)
}

/// Largest eigenvalues of a body in motion; estimates where they lie below `known`.
fn of_body<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    particles: &BodyParticles,
    known: Oscillation,
) -> Option<Oscillation> {
    let start = Start {
        f: *f,
        noise: 0.0,
        seed: 1,
    };
    let mut found = None;
    let mut work = |body: &mut dyn BodyMotion| {
        let started = body.start(&start, 0.0);
        found = started.and_then(|()| body.fastest_oscillation(known)).ok();
    };
    with_body(discretization, material, particles, &[], None, &mut work).ok()?;
    found
}

/// Largest eigenvalues of a method on the particles of a block, which form a single cell; estimates where they lie below `known`.
fn of_cells<const D: usize>(
    block: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    known: Oscillation,
) -> Option<Oscillation> {
    let system = block.waves(material, f).ok()?;
    if system.drift().is_some() {
        return None;
    }
    let masses = system.particle_masses();
    let largest = |sum: &BlochSum<D>, known: f64| {
        let matrix = sum.at(&SVector::zeros());
        let size = matrix.nrows();
        let over_mass = DMatrix::from_fn(size, size, |i, j| matrix[(i, j)].re / masses[i / D]);
        let image = |own: &[f64], _| {
            let product = &over_mass * DVector::from_column_slice(own);
            Ok(product.as_slice().to_vec())
        };
        largest_eigenvalue(size, &mut { image }, known).ok()
    };
    let squared = largest(system.stiffness(), known.squared)?;
    let damping = system.damping();
    let damping = damping.map_or(Some(0.0), |sum| largest(sum, known.damping))?;
    (squared > 0.0 && squared.is_finite() && damping.is_finite())
        .then_some(Oscillation { squared, damping })
}

#[cfg(test)]
mod tests {
    use super::{Linearized, Oscillation, Start, turned_block, with_body};
    use crate::kinematics::DeformationGradient;
    use crate::lattice::{Crystal, LatticeKind};
    use crate::material::ModifiedMooneyRivlin;
    use crate::motion::BodyMotion;
    use crate::scheme::sph::{MomentumForm, UpdatedSph, UpdatedSphChoices};
    use nalgebra::SMatrix;

    /// With the difference form of the momentum equation the stiffness is not symmetric.
    #[test]
    fn eigenvalues_above_a_known_one_are_exact_and_no_other_is_estimated_above_it() {
        let crystal = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
        let law = ModifiedMooneyRivlin::default();
        let f = [[1.06, 0.02, 0.0], [-0.083, 1.109, 0.0], [0.0, 0.0, 1.0]];
        let f = DeformationGradient::new(f).expect("a state");
        let solid = Linearized::about(&law, &f).expect("a finite response");
        for momentum in [MomentumForm::Difference, MomentumForm::Symmetric] {
            let choices = UpdatedSphChoices {
                radius: 2.2,
                momentum,
                ..UpdatedSphChoices::default()
            };
            let method = UpdatedSph::new(crystal.clone(), choices).expect("a method");
            for side in [3, 5, 7] {
                let axes = SMatrix::identity();
                let block = turned_block(&crystal, &axes, &[side; 2], &crystal.sites()[0]);
                let mut work = |body: &mut dyn BodyMotion| {
                    let start = Start {
                        f,
                        noise: 0.0,
                        seed: 1,
                    };
                    body.start(&start, 0.0).expect("a start");
                    let whole = body.fastest_oscillation(Oscillation::NONE);
                    let whole = whole.expect("an eigenvalue").squared;
                    let mut below = |known: f64| {
                        let known = Oscillation {
                            squared: known,
                            ..Oscillation::NONE
                        };
                        body.fastest_oscillation(known)
                            .expect("an eigenvalue")
                            .squared
                    };
                    for factor in [1.0002, 1.01, 1.1, 1.5, 4.0] {
                        let known = factor * whole;
                        let squared = below(known);
                        let is_estimated = (0.999 * whole..known).contains(&squared);
                        assert!(is_estimated, "{side} {factor} {squared} {whole}");
                    }
                    assert_eq!(below(0.9999 * whole), whole, "{side}");
                };
                with_body(&method, &solid, &block, &[], None, &mut work).expect("a body");
            }
        }
    }
}
