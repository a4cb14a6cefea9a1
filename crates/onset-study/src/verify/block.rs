//! Block of particles on a lattice with orthogonal primitive vectors.

use serde::{Deserialize, Serialize};

/// Block of particles, numbered along the first axis first. In fewer than three dimensions the other coordinates are zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Block {
    /// Number of particles along each axis.
    pub counts: Vec<usize>,
    /// Particle spacing along each axis in the reference configuration; length.
    pub sides: Vec<f64>,
    /// Range of measured particles along each axis: index of the first measured particle, and index after the last.
    pub measured: Vec<[usize; 2]>,
}

impl Block {
    /// Number of space dimensions.
    pub fn dimension(&self) -> usize {
        self.counts.len()
    }

    /// Number of particles in the block.
    pub fn particles(&self) -> usize {
        self.counts.iter().product()
    }

    /// Volume of a particle in the reference configuration.
    pub fn volume(&self) -> f64 {
        self.sides.iter().product()
    }

    /// Integer coordinates of a particle along the axes, in units of the sides.
    pub fn place(&self, index: usize) -> Vec<usize> {
        let mut rest = index;
        let along = |count: &usize| {
            let place = rest % count;
            rest /= count;
            place
        };
        self.counts.iter().map(along).collect()
    }

    /// Reference position of a particle; length.
    pub fn reference(&self, index: usize) -> [f64; 3] {
        let mut position = [0.0; 3];
        for (axis, place) in self.place(index).into_iter().enumerate() {
            position[axis] = place as f64 * self.sides[axis];
        }
        position
    }

    /// Returns true if the particle is measured.
    pub fn is_measured(&self, index: usize) -> bool {
        let mut places = self.place(index).into_iter().zip(&self.measured);
        places.all(|(place, [first, end])| (*first..*end).contains(&place))
    }

    /// Number of measured particles.
    pub fn measured_particles(&self) -> usize {
        self.measured
            .iter()
            .map(|[first, end]| end - first)
            .product()
    }
}

#[cfg(test)]
mod tests {
    use super::Block;

    #[test]
    fn particles_are_numbered_along_the_first_axis_first() {
        let block = Block {
            counts: vec![3, 2],
            sides: vec![1.0, 0.5],
            measured: vec![[1, 3], [0, 1]],
        };
        assert_eq!((block.particles(), block.measured_particles()), (6, 2));
        assert_eq!(block.place(4), [1, 1]);
        assert_eq!(block.reference(4), [1.0, 0.5, 0.0]);
        let measured: Vec<usize> = (0..6).filter(|n| block.is_measured(*n)).collect();
        assert_eq!(measured, [1, 2]);
    }
}
