//! What a pair of particles of a body has in common.

/// A pair of particles, seen from one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond<const D: usize> {
    /// `grad W`, the weight's gradient along the vector to the other particle; 1/length^(D+1).
    pub gradient: [f64; D],
    /// `alpha/2 E W / (|X|^2 + ...)` of the penalty, to be multiplied with the volumes of both; zero without.
    pub stiffness: f64,
}

/// How the particles of a method act on each other in pairs whose vectors stay with the material: what the engine of bodies needs to know.
pub trait PairLaw<const D: usize>: Send + Sync {
    /// The distance beyond which there are no pairs; length.
    fn radius(&self) -> f64;

    /// The pair with the reference vector `x` to the other particle.
    fn bond(&self, x: &[f64; D]) -> Bond<D>;

    /// Whether gradients are corrected to be exact for linear fields.
    fn is_corrected(&self) -> bool;

    /// What is added to the current length of a bond, in either factor of its square, under the force of the penalty; length. None without a penalty.
    fn penalty_offsets(&self) -> Option<[f64; 2]>;

    /// The reference density.
    fn density(&self) -> f64;
}
