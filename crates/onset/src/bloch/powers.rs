//! Phases of lattice vectors from those of the primitive vectors.

use crate::algebra::{Complex, array_of};

/// Powers that fit on the stack.
const NEAR: usize = 16;

/// Powers of the phases of the primitive vectors, such as `exp(i n k.a_d)`: products, which are cheaper than sines.
pub(super) struct Powers<const D: usize> {
    /// At `[n][d]`; those that are many are on the heap.
    near: [[Complex; D]; NEAR],
    far: Vec<[Complex; D]>,
}

impl<const D: usize> Powers<D> {
    /// Of the phase of each primitive vector, up to a power.
    pub(super) fn new(steps: [Complex; D], reach: usize) -> Self {
        let one = [Complex::new(1.0, 0.0); D];
        let turned = |power: &[Complex; D]| -> [Complex; D] { array_of(|d| power[d] * steps[d]) };
        let mut near = [one; NEAR];
        for n in 1..NEAR.min(reach + 1) {
            near[n] = turned(&near[n - 1]);
        }
        let mut far = Vec::new();
        let mut last = near[NEAR - 1];
        for _ in NEAR..reach + 1 {
            last = turned(&last);
            far.push(last);
        }
        Self { near, far }
    }

    /// A phase times that of the vector to a cell.
    pub(super) fn turned(&self, mut phase: Complex, cell: &[i32; D]) -> Complex {
        for d in 0..D {
            let n = cell[d].unsigned_abs() as usize;
            let power = if n < NEAR {
                self.near[n][d]
            } else {
                self.far[n - NEAR][d]
            };
            phase *= if cell[d] < 0 { power.conj() } else { power };
        }
        phase
    }
}
