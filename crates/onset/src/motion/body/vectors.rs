//! Fields of consecutive particles, padded to whole groups of the width of a vector register.

use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::real::{LANES, Lanes};
use pulp::Simd;

/// One component of a field, padded with zeros to whole groups.
pub(super) type Component = Vec<f64>;
/// Vector field of all particles.
pub(super) type Field<const D: usize> = [Component; D];
/// Tensor field of all particles.
pub(super) type Tensors<const D: usize> = [[Component; D]; D];

/// Zero vector field for `count` particles.
pub(super) fn zeros<const D: usize>(count: usize) -> Field<D> {
    std::array::from_fn(|_| vec![0.0; count.next_multiple_of(LANES)])
}

/// Zero tensor field for `count` particles.
pub(super) fn zero_tensors<const D: usize>(count: usize) -> Tensors<D> {
    std::array::from_fn(|_| zeros(count))
}

/// Vector of a particle.
pub(super) fn vector_of<const D: usize>(field: &Field<D>, particle: usize) -> [f64; D] {
    array_of(|i| field[i][particle])
}

/// Sets the vector of a particle.
pub(super) fn put<const D: usize>(field: &mut Field<D>, particle: usize, vector: &[f64; D]) {
    for (component, x) in field.iter_mut().zip(vector) {
        component[particle] = *x;
    }
}

/// Returns true if all numbers are finite. Without early exit, so that the loop compiles to vector instructions.
pub(super) fn are_finite(numbers: &[f64]) -> bool {
    numbers.iter().fold(true, |all, x| all & x.is_finite())
}

/// Vectors of the first `count` particles, vector by vector.
pub(super) fn flat<const D: usize>(field: &Field<D>, count: usize) -> Vec<f64> {
    (0..count).flat_map(|n| vector_of(field, n)).collect()
}

/// Returns a negated vector.
pub(super) fn negative(mut vector: Vec<f64>) -> Vec<f64> {
    vector.iter_mut().for_each(|x| *x = -*x);
    vector
}

/// Copies consecutive vectors into a field.
pub(super) fn fill<const D: usize>(field: &mut Field<D>, flat: &[f64]) {
    for (particle, x) in flat.chunks_exact(D).enumerate() {
        put(field, particle, &array_of(|i| x[i]));
    }
}

pub(super) fn slices<const D: usize>(tensors: &Tensors<D>) -> [[&[f64]; D]; D] {
    tensors
        .each_ref()
        .each(|row| row.each_ref().map(Vec::as_slice))
}

/// Deformation gradients of the group that begins at an index.
pub(super) fn states<const D: usize>(
    transverse: &DeformationGradient,
    f: &[[&[f64]; D]; D],
    place: usize,
) -> DeformationGradient<Lanes> {
    let fixed = transverse.components();
    DeformationGradient::from_components(array_of(|i| {
        array_of(|j| match i < D && j < D {
            true => Lanes::of(&f[i][j][place..]),
            false => Lanes([fixed[i][j]; LANES]),
        })
    }))
}

/// Masks of a group for each bit pattern: one for particles whose bit is set, zero for all others.
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

/// Values of consecutive particles at an offset from a particle, padded with zeros.
#[inline(always)]
pub(super) fn load<S: Simd>(from: &[f64], own: usize, offset: i32) -> S::f64s {
    let place = own.wrapping_add_signed(offset as isize);
    match from.get(place..place.wrapping_add(S::F64_LANES)) {
        Some(numbers) => S::as_simd_f64s(numbers).0[0],
        None => S::as_simd_f64s(&beyond(from, place)).0[0],
    }
}

/// Values of consecutive particles, with zeros before the first and after the last particle.
#[cold]
fn beyond(from: &[f64], place: usize) -> [f64; LANES] {
    let one = |lane| from.get(place.wrapping_add(lane)).copied();
    array_of(|lane| one(lane).unwrap_or(0.0))
}

/// Values of a group, starting at one of its particles.
#[inline(always)]
pub(super) fn part<S: Simd>(group: &[f64], from: usize) -> S::f64s {
    S::as_simd_f64s(&group[from..from + S::F64_LANES]).0[0]
}

/// Stores the lanes of a vector register.
#[inline(always)]
pub(super) fn store<S: Simd>(to: &mut [f64], numbers: S::f64s) {
    S::as_mut_simd_f64s(to).0[0] = numbers;
}
