//! Phases of lattice vectors as products of the phases of the primitive vectors.

use crate::algebra::{Complex, array_of};

/// Number of powers stored on the stack; more are stored on the heap.
const STACK_POWERS: usize = 16;

/// Powers of the phases of the primitive vectors, `exp(i n k.a_d)`, by multiplication, which is cheaper than sines.
pub(super) struct Powers<const D: usize> {
    /// Power `n` of direction `d` at `[n][d]`; higher powers are on the heap.
    near: [[Complex; D]; STACK_POWERS],
    far: Vec<[Complex; D]>,
}

impl<const D: usize> Powers<D> {
    /// Computes the powers of the given phases up to the exponent `reach`.
    pub(super) fn new(steps: [Complex; D], reach: usize) -> Self {
        let one = [Complex::new(1.0, 0.0); D];
        let turned = |power: &[Complex; D]| -> [Complex; D] { array_of(|d| power[d] * steps[d]) };
        let mut near = [one; STACK_POWERS];
        for n in 1..STACK_POWERS.min(reach + 1) {
            near[n] = turned(&near[n - 1]);
        }
        let mut far = Vec::new();
        let mut last = near[STACK_POWERS - 1];
        for _ in STACK_POWERS..reach + 1 {
            last = turned(&last);
            far.push(last);
        }
        Self { near, far }
    }

    /// Returns `phase` multiplied by the phase of the vector to `cell`.
    pub(super) fn turned(&self, mut phase: Complex, cell: &[i32; D]) -> Complex {
        for d in 0..D {
            let n = cell[d].unsigned_abs() as usize;
            let power = if n < STACK_POWERS {
                self.near[n][d]
            } else {
                self.far[n - STACK_POWERS][d]
            };
            phase *= if cell[d] < 0 { power.conj() } else { power };
        }
        phase
    }
}
