//! Work on all cores: fields cut into blocks of particles, of which each core takes one after the other.

use super::vectors::{Component, Field, Tensors};
use std::sync::{Mutex, PoisonError};

/// Work on each of some things, on all cores where there are any; results in their order.
pub(super) fn of_each<T: Send, R: Send>(things: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let place = |thing| Mutex::new((Some(thing), None));
    let places: Vec<_> = things.into_iter().map(place).collect();
    // Each lock is taken once, so that none is waited for; a panic of the work ends the call before results are read.
    on_all_cores(places.len(), &|n| {
        let mut place = places[n].lock().unwrap_or_else(PoisonError::into_inner);
        let thing = place.0.take();
        place.1 = thing.map(&work);
    });
    let result = |place: Mutex<(Option<T>, Option<R>)>| {
        let place = place.into_inner();
        place.unwrap_or_else(PoisonError::into_inner).1
    };
    places.into_iter().filter_map(result).collect()
}

/// Calls for each number below a count. It is compiled once for all kinds of work: for each kind it would be some ten thousand lines of
/// intermediate code.
fn on_all_cores(count: usize, work: &(dyn Fn(usize) + Sync)) {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().for_each(work);
    }
    #[cfg(not(feature = "rayon"))]
    (0..count).for_each(work);
}

/// A field cut into blocks of so many particles.
pub(super) fn field_parts<const D: usize>(
    field: &mut Field<D>,
    block: usize,
) -> Vec<[&mut [f64]; D]> {
    let count = parts_of(field, block);
    let mut parts = field.each_mut().map(|own| own.chunks_mut(block));
    let next = |_| parts.each_mut().map(|own| own.next().unwrap_or_default());
    (0..count).map(next).collect()
}

/// Tensors cut into blocks of so many particles.
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

/// `u += dt v`.
pub(super) fn drift<const D: usize>(u: &mut Field<D>, v: &Field<D>, dt: f64) {
    let parts = u.iter_mut().zip(v).collect();
    of_each(parts, |(u, v): (&mut Component, &Component)| {
        for (u, v) in u.iter_mut().zip(v) {
            *u += v * dt;
        }
    });
}
