//! Particles of a body: cut out of a lattice, or given individually.

use super::BodyError;
use crate::algebra::{Each, array_of};
use crate::lattice::{Crystal, Particle, cells_between};
use nalgebra::SVector;

/// Largest number of particles of a body.
const PARTICLES: usize = 20_000_000;
/// Largest distance from a shape, as a fraction of a spacing, at which particles count as inside.
const RIM: f64 = 1e-9;
/// Largest number of a cell.
const MAX_CELL_NUMBER: f64 = 1e9;
/// Largest number of cells in the box around a body. Thin, long or separated pieces can have many more cells than particles.
const CELLS: f64 = 1e8;

/// Notch from an edge of a block, at the middle of its first side, starting from below along the second side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Notch {
    /// Depth along the second side; length.
    pub depth: f64,
    /// Width along the first side; length.
    pub width: f64,
}

/// Shape that is cut out of a lattice. Blocks have a corner at the origin; disks and rings are centered there.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A bar, a plate or any other block.
    Block {
        /// Sides of the block; length.
        size: Vec<f64>,
        /// Radius of a round hole through the center, along the third axis; length.
        hole: Option<f64>,
        /// Notch of the block, if any.
        notch: Option<Notch>,
    },
    /// A disk or a ring; in three dimensions a cylinder along the third axis, starting at zero.
    Ring {
        /// Outer radius of the ring; length.
        radius: f64,
        /// Inner radius, zero for a disk; length.
        inner: f64,
        /// Height of a cylinder; length.
        height: Option<f64>,
    },
    /// Two copies of a shape.
    Twice {
        /// Shape of both copies.
        shape: Box<Shape>,
        /// Offset of the second copy; length.
        offset: Vec<f64>,
    },
}

/// Particle with a given position and volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedParticle {
    /// Position in the reference configuration; length.
    pub position: [f64; 3],
    /// Reference volume; length^D.
    pub volume: f64,
}

/// Particles of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyParticles {
    /// Particles of the method's lattice inside a shape. If the sides of a block along the axes are multiples of the spacing, its faces are half a
    /// spacing from its outermost particles.
    Cut(Shape),
    /// Particles at given positions.
    Given(Vec<PlacedParticle>),
}

/// Positions and volumes of the particles of a body.
pub(super) struct Placed<const D: usize> {
    pub(super) positions: Vec<[f64; D]>,
    pub(super) volumes: Vec<f64>,
    /// Sites of the particles in the lattice, in the order of rows along its first vector; `None` for given particles.
    pub(super) places: Option<Vec<Particle<D>>>,
}

fn positive(what: &str, value: f64) -> Result<f64, BodyError> {
    match value > 0.0 && value.is_finite() {
        true => Ok(value),
        false => Err(BodyError::Number {
            what: what.to_owned(),
            value,
            expected: "a positive number",
        }),
    }
}

impl Shape {
    /// Lower and upper corner of a box around the shape.
    fn corners<const D: usize>(&self) -> Result<[[f64; D]; 2], BodyError> {
        match self {
            Self::Block { size, hole, notch } => {
                let mut high = [0.0; D];
                for i in 0..D {
                    let side = size.get(i).copied().unwrap_or(f64::NAN);
                    high[i] = positive(&format!("side {} of the body", i + 1), side)?;
                }
                if let Some(radius) = hole {
                    positive("the radius of the hole", *radius)?;
                }
                if let Some(notch) = notch {
                    positive("the depth of the notch", notch.depth)?;
                    positive("the width of the notch", notch.width)?;
                }
                Ok([[0.0; D], high])
            }
            Self::Ring {
                radius,
                inner,
                height,
            } => {
                positive("the radius of the body", *radius)?;
                if !(0.0..*radius).contains(inner) {
                    return Err(BodyError::Number {
                        what: "the inner radius of the body".to_owned(),
                        value: *inner,
                        expected: "a number from 0 to below the outer radius",
                    });
                }
                let (mut low, mut high) = ([-radius; D], [*radius; D]);
                if D == 3 {
                    low[2] = 0.0;
                    high[2] = positive("the height of the body", height.unwrap_or(f64::NAN))?;
                }
                Ok([low, high])
            }
            Self::Twice { shape, .. } => shape.corners(),
        }
    }

    /// Pieces of the shape with their offsets.
    fn pieces<const D: usize>(&self) -> Result<Vec<(&Self, [f64; D])>, BodyError> {
        let Self::Twice { shape, offset } = self else {
            return Ok(vec![(self, [0.0; D])]);
        };
        let mut moved = [0.0; D];
        for (i, moved) in moved.iter_mut().enumerate() {
            *moved = offset.get(i).copied().unwrap_or(f64::NAN);
            if !moved.is_finite() {
                return Err(BodyError::Number {
                    what: format!("component {} of the offset of the body", i + 1),
                    value: *moved,
                    expected: "a finite number",
                });
            }
        }
        let mut pieces = shape.pieces::<D>()?;
        let again: Vec<_> = pieces
            .iter()
            .map(|(piece, at)| (*piece, array_of(|i| at[i] + moved[i])))
            .collect();
        pieces.extend(again);
        Ok(pieces)
    }

    /// Returns true if a point in the box lies inside the shape.
    fn holds<const D: usize>(&self, x: &[f64; D], rim: f64) -> bool {
        let across = |x: f64, y: f64| x.hypot(y);
        match self {
            Self::Block { size, hole, notch } => {
                let second = x.get(1).copied().unwrap_or(0.0);
                let from_middle = |i: usize| x.get(i).map_or(0.0, |x| x - 0.5 * size[i]);
                let is_in_hole = hole
                    .is_some_and(|radius| across(from_middle(0), from_middle(1)) < radius - rim);
                let is_in_notch = notch.is_some_and(|notch| {
                    from_middle(0).abs() < 0.5 * notch.width - rim && second < notch.depth - rim
                });
                !is_in_hole && !is_in_notch
            }
            Self::Ring { radius, inner, .. } => {
                let distance = across(x[0], x.get(1).copied().unwrap_or(0.0));
                (inner - rim..=radius + rim).contains(&distance)
            }
            Self::Twice { shape, .. } => shape.holds(x, rim),
        }
    }
}

/// Places the particles of a body.
pub(super) fn placed<const D: usize>(
    crystal: &Crystal<D>,
    particles: &BodyParticles,
) -> Result<Placed<D>, BodyError> {
    let placed = match particles {
        BodyParticles::Cut(shape) => cut(crystal, shape)?,
        BodyParticles::Given(given) => given_ones(given)?,
    };
    match placed.positions.is_empty() {
        true => Err(BodyError::Empty),
        false => Ok(placed),
    }
}

fn cut<const D: usize>(crystal: &Crystal<D>, shape: &Shape) -> Result<Placed<D>, BodyError> {
    let mut found = Vec::new();
    for (piece, at) in shape.pieces()? {
        found.extend(cut_piece(crystal, piece, &at)?);
        if found.len() > PARTICLES {
            return Err(BodyError::TooMany {
                particles: found.len(),
                limit: PARTICLES,
            });
        }
    }
    // The table of neighbors covers the box around all pieces.
    let (mut first, mut last) = ([i32::MAX; D], [i32::MIN; D]);
    for (particle, _) in &found {
        for i in 0..D {
            first[i] = first[i].min(particle.cell[i]);
            last[i] = last[i].max(particle.cell[i]);
        }
    }
    check_cells(&first.map(f64::from), &last.map(f64::from))?;
    // Rows along the first vector, of one site each.
    found.sort_by_key(|(particle, _)| {
        let mut key = [0; 4];
        for i in 1..D {
            key[D - 1 - i] = particle.cell[i];
        }
        key[2] = particle.site as i32;
        key[3] = particle.cell[0];
        key
    });
    // A particle in the overlap of two pieces is found twice.
    found.dedup_by_key(|(particle, _)| *particle);
    Ok(Placed {
        volumes: found
            .iter()
            .map(|(particle, _)| crystal.volumes()[particle.site])
            .collect(),
        positions: found.iter().map(|(_, x)| *x).collect(),
        places: Some(found.into_iter().map(|(particle, _)| particle).collect()),
    })
}

fn given_ones<const D: usize>(given: &[PlacedParticle]) -> Result<Placed<D>, BodyError> {
    if given.len() > PARTICLES {
        return Err(BodyError::TooMany {
            particles: given.len(),
            limit: PARTICLES,
        });
    }
    let mut positions = Vec::with_capacity(given.len());
    for (number, particle) in given.iter().enumerate() {
        positive(&format!("the volume of particle {number}"), particle.volume)?;
        let position: [f64; D] = array_of(|i| particle.position[i]);
        if let Some(value) = position.iter().find(|x| !x.is_finite()) {
            return Err(BodyError::Number {
                what: format!("a coordinate of particle {number}"),
                value: *value,
                expected: "a finite number",
            });
        }
        positions.push(position);
    }
    Ok(Placed {
        positions,
        volumes: given.iter().map(|particle| particle.volume).collect(),
        places: None,
    })
}
/// Particles of a lattice in a piece of a shape with an offset.
fn cut_piece<const D: usize>(
    crystal: &Crystal<D>,
    piece: &Shape,
    at: &[f64; D],
) -> Result<Vec<(Particle<D>, [f64; D])>, BodyError> {
    let [low, high] = piece.corners::<D>()?;
    let half = 0.5 * crystal.spacing();
    let rim = RIM * crystal.spacing();
    let volume: f64 = (0..D).map(|i| high[i] - low[i]).product();
    let cell: f64 = crystal.volumes().iter().sum();
    let expected = volume / cell * crystal.volumes().len() as f64;
    if expected > PARTICLES as f64 {
        return Err(BodyError::TooMany {
            particles: expected as usize,
            limit: PARTICLES,
        });
    }
    let [first, last] = cells_of_box(crystal, &[low, high], at)?;
    let mut found = Vec::new();
    for cell in cells_between(&first, &last) {
        for site in 0..crystal.sites().len() {
            let particle = Particle { site, cell };
            let x: [f64; D] = crystal.position(&particle).add_scalar(half).into();
            let own: [f64; D] = array_of(|i| x[i] - at[i]);
            let is_in_box = (0..D).all(|i| (low[i] - rim..=high[i] + rim).contains(&own[i]));
            if is_in_box && piece.holds(&own, rim) {
                found.push((particle, x));
            }
        }
    }
    Ok(found)
}

/// Checks that the box between two cells does not contain too many cells.
fn check_cells<const D: usize>(first: &[f64; D], last: &[f64; D]) -> Result<(), BodyError> {
    let cells: f64 = (0..D)
        .map(|i| (last[i] - first[i] + 1.0).max(0.0))
        .product();
    match cells > CELLS {
        true => Err(BodyError::Number {
            what: "the number of cells of the lattice in the box around the body".to_owned(),
            value: cells,
            expected: "at most 1e8: a smaller body, or pieces closer together",
        }),
        false => Ok(()),
    }
}

/// First and last cell of a lattice that intersect a box with an offset. Lattice coordinates are linear, so that their extremes are at the corners of
/// the box.
fn cells_of_box<const D: usize>(
    crystal: &Crystal<D>,
    [low, high]: &[[f64; D]; 2],
    at: &[f64; D],
) -> Result<[[i32; D]; 2], BodyError> {
    let half = 0.5 * crystal.spacing();
    let inverse = crystal.lattice().vectors().try_inverse();
    let inverse = inverse.ok_or(crate::method::MethodError::NotFinite)?;
    let (mut first, mut last) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for corner in 0..1 << D {
        let x = SVector::<f64, D>::from_fn(|i, _| {
            let side = if corner >> i & 1 == 0 { low } else { high };
            side[i] + at[i] - half
        });
        let fractional = inverse * x;
        for i in 0..D {
            first[i] = first[i].min(fractional[i].floor() - 1.0);
            last[i] = last[i].max(fractional[i].ceil() + 1.0);
        }
    }
    let farthest = first
        .iter()
        .chain(&last)
        .fold(0.0, |far: f64, n| far.max(n.abs()));
    if farthest > MAX_CELL_NUMBER {
        return Err(BodyError::Number {
            what: "the distance of the body from the origin, in cells of the lattice,".to_owned(),
            value: farthest,
            expected: "at most 1e9",
        });
    }
    check_cells(&first, &last)?;
    Ok([first, last].each(|own| own.each(|n| n as i32)))
}
