//! Contact of pieces whose neighbors stay: particles of different pieces repel each other.
//!
//! Particles that see each other, themselves or through others, are one piece. Two of different pieces nearer than the spacing `h` push each other apart along the line
//! between them, by `c A_1111 h^(D-1) (1 - r/h)`: with `c = 1` two rows face to face are as stiff as the material between its rows. The force has the potential
//! `c A_1111 h^D (1 - r/h)^2 / 2`, and takes neither momentum nor angular momentum. Nothing is lost where pieces slide, but rows of particles are not smooth: out of step
//! they meet at `0.87 h` in the plane, and push each other along. Parts of one piece do not feel each other. A pair nearer than `h/2` ends the motion, before pieces pass through
//! each other.

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

/// Contact of bodies whose neighbors stay: particles of pieces that do not see each other repel each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// How stiff it is, over the material: particles nearer than the spacing `h` push each other by `stiffness A_1111 h^(D-1) (1 - r/h)`, with the tangent
    /// of the law at `F = 1`.
    pub stiffness: f64,
}

/// The pieces of a body, and who touches whom.
pub(super) struct Pieces<const D: usize> {
    /// `c A_1111 h^(D-1)`; force.
    force: f64,
    /// `h`; length.
    spacing: f64,
    /// Of each particle.
    piece: Vec<u32>,
    neighbors: Neighbors<D>,
    /// In the reference state; length.
    positions: Vec<[f64; D]>,
    /// Where they are; length.
    places: Vec<[f64; D]>,
    touching: Vec<Touch<D>>,
}

/// Two particles that touch.
struct Touch<const D: usize> {
    ends: [u32; 2],
    /// The force on the first, and the reverse on the second.
    force: [f64; D],
}

impl<const D: usize> Pieces<D> {
    /// Of a body with a contact.
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
                "its stiffness is measured by A_1111 of the material at F = 1, which is not positive",
            ));
        }
        let piece = pieces(links, positions.len());
        if piece.iter().all(|own| *own == 0) {
            return Err(BodyError::NoContact(
                "the particles are one piece, which all see each other directly or through others",
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

    /// Finds who touches whom at displacements; tells a particle that is about to pass through another one.
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

    /// `v += dt f / m`, of which [`Self::meet`] was called.
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

    /// `sum c A_1111 h^D (1 - r/h)^2 / 2`, of which [`Self::meet`] was called.
    pub(super) fn energy(&self) -> f64 {
        let own = |touch: &Touch<D>| {
            let squared = touch.force.iter().map(|x| x * x).sum::<f64>();
            0.5 * squared * self.spacing / self.force
        };
        self.touching.iter().map(own).sum()
    }

    /// What contacts add to `omega^2`, estimated from above: a particle of a row is pushed by those of a row of another piece that are nearer than the spacing, of which
    /// there are 1, 3 and 5 in one, two and three dimensions where rows are not compressed, and moves against them; 1/time^2.
    pub(super) fn stiffest(&self, lightest: f64) -> f64 {
        let touching = (2 * D - 1) as f64;
        2.0 * touching * self.force / (self.spacing * lightest)
    }

    /// What is kept; bytes.
    pub(super) fn bytes(&self) -> usize {
        self.neighbors.bytes()
            + self.piece.len() * size_of::<u32>()
            + (self.positions.len() + self.places.len()) * size_of::<[f64; D]>()
            + self.touching.len() * size_of::<Touch<D>>()
    }
}

/// The piece of each particle: those that see each other have the same number, the first has 0.
fn pieces<const D: usize>(links: &Links<D>, count: usize) -> Vec<u32> {
    fn root(parents: &mut [u32], mut own: u32) -> u32 {
        while parents[own as usize] != own {
            // Halves the way for those who come after.
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
