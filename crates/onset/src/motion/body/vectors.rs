//! Numbers of particles that follow each other, as many as a vector of the machine holds.

use crate::algebra::array_of;
use crate::real::LANES;
use pulp::Simd;

/// A component of all particles, filled up with zeros to whole groups.
pub(super) type Component = Vec<f64>;
/// A vector of all particles.
pub(super) type Field<const D: usize> = [Component; D];
/// A tensor of all particles.
pub(super) type Tensors<const D: usize> = [[Component; D]; D];

/// A vector of zeros for so many particles.
pub(super) fn zeros<const D: usize>(count: usize) -> Field<D> {
    std::array::from_fn(|_| vec![0.0; count.next_multiple_of(LANES)])
}

/// For each of some particles of a group one where it is among those that bits tell, and zero where not.
pub(super) const MASKS: [[f64; LANES]; 1 << LANES] = masks();

const fn masks() -> [[f64; LANES]; 1 << LANES] {
    let mut masks = [[0.0; LANES]; 1 << LANES];
    let mut bits = 0;
    while bits < masks.len() {
        let mut lane = 0;
        while lane < LANES {
            if bits >> lane & 1 == 1 {
                masks[bits][lane] = 1.0;
            }
            lane += 1;
        }
        bits += 1;
    }
    masks
}

/// Those of the particles that are so far away from some, zeros where there are none.
#[inline(always)]
pub(super) fn load<S: Simd>(from: &[f64], own: usize, offset: i32) -> S::f64s {
    let place = own.wrapping_add_signed(offset as isize);
    match from.get(place..place.wrapping_add(S::F64_LANES)) {
        Some(numbers) => S::as_simd_f64s(numbers).0[0],
        None => S::as_simd_f64s(&beyond(from, place)).0[0],
    }
}

/// Of particles of which some are beyond the first or the last one.
#[cold]
fn beyond(from: &[f64], place: usize) -> [f64; LANES] {
    let one = |lane| from.get(place.wrapping_add(lane)).copied();
    array_of(|lane| one(lane).unwrap_or(0.0))
}

/// Those of a group from one of its particles on.
#[inline(always)]
pub(super) fn part<S: Simd>(group: &[f64], from: usize) -> S::f64s {
    S::as_simd_f64s(&group[from..from + S::F64_LANES]).0[0]
}

/// Stores as many as there are.
#[inline(always)]
pub(super) fn store<S: Simd>(to: &mut [f64], numbers: S::f64s) {
    S::as_mut_simd_f64s(to).0[0] = numbers;
}
