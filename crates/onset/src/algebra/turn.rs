//! Sines and cosines of several numbers in parallel.

/// The number `pi / 2` in two parts; the first part is so short that small multiples of it are exact.
const QUARTER: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
/// Number whose addition to a much smaller number leaves the nearest integer in the last digits.
const ROUND_TO_INTEGER: f64 = 6_755_399_441_055_744.0;
/// Coefficients of `(sin x - x) / x^3` and `(cos x - 1 + x^2 / 2) / x^4` in powers of `x^2`, for `|x| < pi / 4` (approximations of FDLIBM).
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Sines and cosines, with absolute errors of the order of the rounding error of one for arguments up to a few thousand.
///
/// There are no branches, so that it is vectorized when inlined.
#[inline(always)]
pub(crate) fn sines_and_cosines<const N: usize>(angles: &[f64; N]) -> ([f64; N], [f64; N]) {
    let (mut sines, mut cosines) = ([0.0; N], [0.0; N]);
    for l in 0..N {
        let shifted = angles[l] * std::f64::consts::FRAC_2_PI + ROUND_TO_INTEGER;
        let quarters = shifted - ROUND_TO_INTEGER;
        let x = (angles[l] - quarters * QUARTER[0]) - quarters * QUARTER[1];
        let square = x * x;
        let (mut sine, mut cosine) = (SINE[5], COSINE[5]);
        for n in (0..5).rev() {
            sine = sine * square + SINE[n];
            cosine = cosine * square + COSINE[n];
        }
        let sine = x + x * square * sine;
        let cosine = 1.0 - 0.5 * square + square * square * cosine;
        // A quarter turn exchanges sine and cosine, and changes a sign.
        let turns = shifted.to_bits();
        let is_odd = turns & 1 == 1;
        let (a, b) = if is_odd {
            (cosine, sine)
        } else {
            (sine, cosine)
        };
        let sign = |turns: u64| (turns & 2) << 62;
        sines[l] = f64::from_bits(a.to_bits() ^ sign(turns));
        cosines[l] = f64::from_bits(b.to_bits() ^ sign(turns.wrapping_add(1)));
    }
    (sines, cosines)
}

#[cfg(test)]
mod tests {
    use super::sines_and_cosines;

    #[test]
    fn sines_and_cosines_agree_with_the_standard_library() {
        for n in -4000..4000 {
            let angles = [0.0, 0.25, 0.5, 0.75].map(|part| (f64::from(n) + part) * 0.037);
            let (sines, cosines) = sines_and_cosines(&angles);
            for l in 0..4 {
                let (sine, cosine) = angles[l].sin_cos();
                assert!((sines[l] - sine).abs() <= 2.3e-16, "{}", angles[l]);
                assert!((cosines[l] - cosine).abs() <= 2.3e-16, "{}", angles[l]);
            }
        }
    }
}
