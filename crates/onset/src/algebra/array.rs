//! Arrays of numbers.

/// The values of a function of the index, of which there is at least one: what `std::array::from_fn` is, for values that need no care where a
/// later one panics. That care is most of what the compiler has to do for the standard function, and keeps it from being inlined.
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

/// The images of what an array has, as `map` gives them; likewise for values that can be copied.
pub(crate) trait Each<T, const N: usize> {
    fn each<U: Copy>(self, image: impl FnMut(T) -> U) -> [U; N];
}

impl<T: Copy, const N: usize> Each<T, N> for [T; N] {
    #[inline(always)]
    fn each<U: Copy>(self, mut image: impl FnMut(T) -> U) -> [U; N] {
        array_of(|n| image(self[n]))
    }
}
