//! Vector instructions used for sums.

use pulp::{Arch, Simd, WithSimd};

struct Name;

impl WithSimd for Name {
    type Output = &'static str;

    fn with_simd<S: Simd>(self, _: S) -> &'static str {
        std::any::type_name::<S>()
    }
}

/// Name of the vector instructions of this processor that sums use, for example `V3` (AVX2) or `V4` (AVX-512).
///
/// Results on processors with different vectors differ in their last digits, because the order of summation differs.
///
/// ```
/// assert!(["Scalar", "V3", "V4", "Neon"].contains(&onset::lanes()));
/// ```
pub fn lanes() -> &'static str {
    let name = Arch::new().dispatch(Name);
    name.rsplit("::").next().unwrap_or(name)
}
