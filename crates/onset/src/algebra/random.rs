//! Reproducible pseudo-random numbers.

/// Returns a pseudo-random number in [0, 1) and advances the state: SplitMix64 (Steele, Lea, Flood, 2014).
///
/// It needs only its state and gives equal numbers on all machines.
pub fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
