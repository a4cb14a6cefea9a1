//! Contact of total-Lagrangian bodies: particles of different pieces repel each other.
//!
//! Particles that are neighbors, directly or through others, form one piece. Two particles of different pieces that are closer than the spacing `h`
//! repel each other along the line between them with the force `c A_1111 h^(D-1) (1 - r/h)`.
//! With `c = 1` two rows face to face are as stiff as the material between its rows. The force has the potential `c A_1111 h^D (1 - r/h)^2 / 2` and
//! conserves momentum and angular momentum.
//!
//! Sliding is free of friction, but rows of particles are not smooth: shifted rows touch at `0.87 h` in the plane and exert tangential forces. There
//! is no contact within a piece. A pair closer than `h/2` ends the motion, before pieces pass through each other.

use super::BodyError;
use super::error::Lost;
use super::links::Links;
use super::neighbors::{Neighbors, squared};
use super::vectors::Field;
use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::LANES;

/// Contact between the pieces of a total-Lagrangian body, whose particles are not neighbors of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Stiffness relative to the material: particles closer than the spacing `h` repel each other with the force
    /// `stiffness A_1111 h^(D-1) (1 - r/h)`, with the tangent of the law at `F = 1`.
    pub stiffness: f64,
}

/// Pieces of a body, with the particles in contact.
pub(super) struct Pieces<const D: usize> {
    /// Contact force `c A_1111 h^(D-1)`; force.
    force: f64,
    /// Spacing `h` of the particles; length.
    spacing: f64,
    /// Number of the piece of each particle.
    piece: Vec<u32>,
    neighbors: Neighbors<D>,
    /// Positions in the reference configuration; length.
    positions: Vec<[f64; D]>,
    /// Current positions of the particles; length.
    places: Vec<[f64; D]>,
    touching: Vec<Touch<D>>,
}

/// Two particles in contact.
struct Touch<const D: usize> {
    ends: [u32; 2],
    /// Force on the first particle; the second has the opposite force.
    force: [f64; D],
}

impl<const D: usize> Pieces<D> {
    /// Determines the pieces of a body with contact.
    pub(super) fn new(
        contact: Contact,
        material: &dyn Hyperelastic,
        links: &Links<D>,
        positions: &[[f64; D]],
        spacing: f64,
    ) -> Result<Self, BodyError> {
        let is_positive = |value: f64| value.is_finite() && value > 0.0;
        if !is_positive(contact.stiffness) {
            return Err(BodyError::Number {
                what: "the stiffness of the contact".to_owned(),
                value: contact.stiffness,
                expected: "a positive number",
            });
        }
        let rest = DeformationGradient::identity();
        let response = material.response(&rest).map_err(MethodError::from)?;
        let modulus = response.tangent[(0, 0, 0, 0)];
        if !is_positive(modulus) {
            return Err(BodyError::NoContact(
                "its stiffness scales with A_1111 of the material at F = 1, which is not positive",
            ));
        }
        let piece = pieces(links, positions.len());
        if piece.iter().all(|own| *own == 0) {
            return Err(BodyError::NoContact(
                "the particles are one piece: all are neighbors, directly or through others",
            ));
        }
        Ok(Self {
            force: contact.stiffness * modulus * spacing.powi(D as i32 - 1),
            spacing,
            piece,
            neighbors: Neighbors::new(spacing),
            positions: positions.to_vec(),
            places: Vec::new(),
            touching: Vec::new(),
        })
    }

    /// Finds the particles in contact at the given displacements. The error is a particle that is about to pass through another.
    pub(super) fn meet(&mut self, u: &Field<D>) -> Result<(), Lost> {
        let Self {
            force,
            spacing,
            piece,
            neighbors,
            positions,
            places,
            touching,
        } = self;
        places.clear();
        let moved = |(n, x): (usize, &[f64; D])| array_of(|i| x[i] + u[i][n]);
        places.extend(positions.iter().enumerate().map(moved));
        touching.clear();
        let mut passing = None;
        for ends in neighbors.near_of(places, &|a, b| piece[a as usize] != piece[b as usize]) {
            let [a, b] = ends.each(|own| places[own as usize]);
            let apart: [f64; D] = array_of(|i| a[i] - b[i]);
            let distance = squared(&a, &b).sqrt();
            if distance < 0.5 * *spacing {
                passing = passing.or(Some(Lost::Passing(ends[0] as usize)));
            } else if distance < *spacing {
                let factor = *force * (distance.recip() - spacing.recip());
                touching.push(Touch {
                    ends: *ends,
                    force: apart.each(|x| x * factor),
                });
            }
        }
        passing.map_or(Ok(()), Err)
    }

    /// Adds `dt f / m` to the velocities. [`Self::meet`] must have been called for the current displacements.
    pub(super) fn kick(&self, v: &mut Field<D>, dt: f64, mass: impl Fn(usize) -> f64) {
        for touch in &self.touching {
            for (sign, end) in [1.0, -1.0].into_iter().zip(touch.ends) {
                let factor = sign * dt / mass(end as usize);
                for (v, force) in v.iter_mut().zip(touch.force) {
                    v[end as usize] += factor * force;
                }
            }
        }
    }

    /// Potential `sum c A_1111 h^D (1 - r/h)^2 / 2`. [`Self::meet`] must have been called for the current displacements.
    pub(super) fn energy(&self) -> f64 {
        let own = |touch: &Touch<D>| {
            let squared = touch.force.iter().map(|x| x * x).sum::<f64>();
            0.5 * squared * self.spacing / self.force
        };
        self.touching.iter().map(own).sum()
    }

    /// Upper estimate of the contribution of contacts to `omega^2`; 1/time^2.
    ///
    /// A particle in a row touches the particles of another row that are closer than the spacing, which are 1, 3 and 5 in one, two and three
    /// dimensions if rows are not compressed. Both rows move against each other.
    pub(super) fn stiffest(&self, lightest: f64) -> f64 {
        let touching = (2 * D - 1) as f64;
        2.0 * touching * self.force / (self.spacing * lightest)
    }

    /// Memory in use; bytes.
    pub(super) fn bytes(&self) -> usize {
        self.neighbors.bytes()
            + self.piece.len() * size_of::<u32>()
            + (self.positions.len() + self.places.len()) * size_of::<[f64; D]>()
            + self.touching.len() * size_of::<Touch<D>>()
    }
}

/// Piece of each particle, numbered from 0. Neighbors belong to the same piece.
fn pieces<const D: usize>(links: &Links<D>, count: usize) -> Vec<u32> {
    fn root(parents: &mut [u32], mut own: u32) -> u32 {
        while parents[own as usize] != own {
            // Shortens the path for later searches.
            parents[own as usize] = parents[parents[own as usize] as usize];
            own = parents[own as usize];
        }
        own
    }
    let mut parents: Vec<u32> = (0..count as u32).collect();
    for (group, stencil) in links.groups.iter().enumerate() {
        let [first, end] = links.stencils[*stencil as usize].pairs;
        for pair in &links.pairs[first as usize..end as usize] {
            for lane in (0..LANES).filter(|lane| pair.of >> lane & 1 == 1) {
                let own = (group * LANES + lane) as i32;
                let [a, b] = [own, own + pair.offset].each(|end| root(&mut parents, end as u32));
                parents[a.max(b) as usize] = a.min(b);
            }
        }
    }
    (0..count as u32)
        .map(|own| root(&mut parents, own))
        .collect()
}
