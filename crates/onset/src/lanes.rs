//! The kind of vectors that sums run in.

use pulp::{Arch, Simd, WithSimd};

struct Name;

impl WithSimd for Name {
    type Output = &'static str;

    fn with_simd<S: Simd>(self, _: S) -> &'static str {
        std::any::type_name::<S>()
    }
}

/// The kind of vectors that this processor has and sums run in, for example `V3` (AVX2) or `V4` (AVX-512).
///
/// Numbers of processors with different vectors differ in their last digits, because sums are taken in another order.
///
/// ```
/// assert!(["Scalar", "V3", "V4", "Neon"].contains(&onset::lanes()));
/// ```
pub fn lanes() -> &'static str {
    let name = Arch::new().dispatch(Name);
    name.rsplit("::").next().unwrap_or(name)
}
