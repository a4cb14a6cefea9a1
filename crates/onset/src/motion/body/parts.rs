//! Division of fields into blocks of particles, which are distributed over the cores.

use super::vectors::{Component, Field, Tensors};
use crate::cores::of_each;

/// Divides a field into blocks of `block` particles.
pub(super) fn field_parts<const D: usize>(
    field: &mut Field<D>,
    block: usize,
) -> Vec<[&mut [f64]; D]> {
    let count = parts_of(field, block);
    let mut parts = field.each_mut().map(|own| own.chunks_mut(block));
    let next = |_| parts.each_mut().map(|own| own.next().unwrap_or_default());
    (0..count).map(next).collect()
}

/// Divides tensors into blocks of `block` particles.
pub(super) fn tensor_parts<const D: usize>(
    tensors: &mut Tensors<D>,
    block: usize,
) -> Vec<[[&mut [f64]; D]; D]> {
    let count = parts_of(&tensors[0], block);
    let mut rows = tensors
        .each_mut()
        .map(|row| field_parts(row, block).into_iter());
    let none = || std::array::from_fn(|_| Default::default());
    let next = |_| rows.each_mut().map(|row| row.next().unwrap_or_else(none));
    (0..count).map(next).collect()
}

fn parts_of<const D: usize>(field: &Field<D>, block: usize) -> usize {
    field[0].len().div_ceil(block)
}

/// Advances a field, `u += dt v`.
pub(super) fn drift<const D: usize>(u: &mut Field<D>, v: &Field<D>, dt: f64) {
    let parts = u.iter_mut().zip(v).collect();
    of_each(parts, |(u, v): (&mut Component, &Component)| {
        for (u, v) in u.iter_mut().zip(v) {
            *u += v * dt;
        }
    });
}
