//! Arrays computed element by element.

/// Array of the values of a function of the index, with at least one element.
///
/// Unlike `std::array::from_fn` it needs no cleanup if a later value panics, because the values are `Copy`. This cleanup accounts for most of the
/// compiled code of the standard function and prevents inlining.
#[inline(always)]
pub(crate) fn array_of<T: Copy, const N: usize>(mut value: impl FnMut(usize) -> T) -> [T; N] {
    let mut all = [value(0); N];
    let mut n = 1;
    while n < N {
        all[n] = value(n);
        n += 1;
    }
    all
}

/// Elementwise `map` of an array for `Copy` values, with the advantages of [`array_of`].
pub(crate) trait Each<T, const N: usize> {
    fn each<U: Copy>(self, image: impl FnMut(T) -> U) -> [U; N];
}

impl<T: Copy, const N: usize> Each<T, N> for [T; N] {
    #[inline(always)]
    fn each<U: Copy>(self, mut image: impl FnMut(T) -> U) -> [U; N] {
        array_of(|n| image(self[n]))
    }
}
