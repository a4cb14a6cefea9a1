//! Pair forces between particles whose neighbors are fixed in the reference configuration.

/// Pair of particles, as a bond from one of them to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond<const D: usize> {
    /// Gradient `grad W` of the weight along the vector to the other particle; 1/length^(D+1).
    pub gradient: [f64; D],
    /// Stiffness `alpha/2 E W / (|X|^2 + ...)` of the penalty, to be multiplied by the volumes of both particles; zero without a penalty.
    pub stiffness: f64,
}

/// Pair forces of a method whose bond vectors stay with the material, as needed to compute bodies.
pub trait PairLaw<const D: usize>: Send + Sync {
    /// Largest distance of a pair; length.
    fn radius(&self) -> f64;

    /// Returns the pair with the reference vector `x` to the other particle.
    fn bond(&self, x: &[f64; D]) -> Bond<D>;

    /// Returns true if gradients are corrected to be exact for linear fields.
    fn is_corrected(&self) -> bool;

    /// Offsets in the force of the penalty, added to the current length of a bond in the two factors of its square. `None` without a penalty.
    fn penalty_offsets(&self) -> Option<[f64; 2]>;

    /// Reference density; mass per reference volume.
    fn density(&self) -> f64;
}
