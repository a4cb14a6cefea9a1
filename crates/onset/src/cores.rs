//! Parallel work on all cores.

use std::sync::{Mutex, PoisonError};

/// Applies `work` to each item, in parallel if available, and returns the results in order.
pub(crate) fn of_each<T: Send, R: Send>(things: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let place = |thing| Mutex::new((Some(thing), None));
    let places: Vec<_> = things.into_iter().map(place).collect();
    // Each lock is taken once, so there is no waiting. A panic of the work ends the call before results are read.
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

/// Like [`of_each`] if each item takes long enough to justify a thread, otherwise sequential.
pub(crate) fn of_each_long<T: Send, R: Send>(
    is_long: bool,
    things: Vec<T>,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    match is_long {
        true => of_each(things, work),
        false => things.into_iter().map(work).collect(),
    }
}

/// Calls `work` for each number below a count. It is compiled once for all kinds of work; a generic version would be about ten thousand lines of
/// intermediate code for each kind.
fn on_all_cores(count: usize, work: &(dyn Fn(usize) + Sync)) {
    #[cfg(feature = "rayon")]
    // A single item would only wait for another thread.
    if count > 1 {
        use rayon::prelude::*;
        let scope = crate::cancel::Scope::current();
        (0..count)
            .into_par_iter()
            .for_each(|n| scope.run(|| work(n)));
        return;
    }
    (0..count).for_each(work);
}
