//! Reuse of memory for arrays of zeros.

use std::cell::RefCell;
use std::ops::{Deref, DerefMut};

/// Largest number of arrays that a thread keeps.
const KEPT: usize = 24;

thread_local! {
    static KEPT_ARRAYS: RefCell<Vec<Vec<f64>>> = const { RefCell::new(Vec::new()) };
}

/// Array of zeros whose memory is reused by the next array of the thread.
///
/// The system reclaims large freed blocks and supplies them again page by page, which would take a third of the time of three-dimensional maps.
#[derive(Debug, Default)]
pub(crate) struct Zeros(Vec<f64>);

impl Zeros {
    pub(crate) fn new(count: usize) -> Self {
        let mut own = KEPT_ARRAYS.with_borrow_mut(|kept| {
            let fits = (0..kept.len()).filter(|n| kept[*n].capacity() >= count);
            let closest = fits.min_by_key(|n| kept[*n].capacity());
            closest.map(|n| kept.swap_remove(n)).unwrap_or_default()
        });
        own.clear();
        own.resize(count, 0.0);
        Self(own)
    }
}

impl Drop for Zeros {
    fn drop(&mut self) {
        let own = std::mem::take(&mut self.0);
        if own.capacity() == 0 {
            return;
        }
        // A thread that ends keeps nothing.
        let _ = KEPT_ARRAYS.try_with(|kept| {
            let mut kept = kept.borrow_mut();
            kept.push(own);
            if kept.len() > KEPT {
                let smallest = (0..kept.len()).min_by_key(|n| kept[*n].capacity());
                smallest.map(|n| kept.swap_remove(n));
            }
        });
    }
}

impl Deref for Zeros {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl DerefMut for Zeros {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

#[cfg(test)]
mod tests {
    use super::Zeros;

    #[test]
    fn reused_arrays_are_zero() {
        for count in [5, 3, 0, 8, 8, 2] {
            let mut arrays = [0, 1].map(|_| Zeros::new(count));
            for array in &mut arrays {
                assert_eq!(**array, vec![0.0; count]);
                array.fill(7.0);
            }
        }
    }
}
