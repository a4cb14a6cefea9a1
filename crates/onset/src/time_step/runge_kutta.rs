//! Explicit Runge-Kutta methods: stages, stability polynomials and their regions of stability.

use crate::algebra::Complex;

/// Largest coefficient of `|P|^2 - 1`, relative to its terms, that is due to rounding of the coefficients of the method.
const COEFFICIENT_ROUNDING: f64 = 1e-12;
/// Spacing of the points along a ray at which `|P|` is evaluated before its first excess is refined.
const RESOLUTION: f64 = 0.02;
/// Upper limit of the search along a ray. No method in use is stable beyond it.
const MAX_RAY_LENGTH: f64 = 100.0;
/// Number of halvings of the interval that contains the loss of stability.
const HALVINGS: usize = 50;

/// Coefficients of a method in the form of its publication.
pub(super) enum Stages {
    /// Rows of the Butcher tableau, followed by the weights.
    Tableau(&'static [&'static [f64]]),
    /// Coefficients `A_i` and `B_i`: `d = A_i d + dt f(y)`, `y = y + B_i d` (Williamson 1980).
    TwoRegisters(&'static [[f64; 2]]),
    /// Coefficients `beta_1`, then `gamma_1i`, `gamma_2i`, `gamma_3i`, `delta_i` and `beta_i`: `s = s + delta_i y`,
    /// `y = gamma_1i y + gamma_2i s + gamma_3i y_0 + beta_i dt f(y)` (Ketcheson 2010).
    ThreeRegisters(f64, &'static [[f64; 5]]),
}

pub(super) const FORWARD_EULER: Stages = Stages::Tableau(&[&[], &[1.0]]);
pub(super) const HEUN: Stages = Stages::Tableau(&[&[], &[1.0], &[0.5, 0.5]]);
pub(super) const RK3: Stages = Stages::Tableau(&[
    &[],
    &[0.5],
    &[-1.0, 2.0],
    &[1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
]);
pub(super) const RK4: Stages = Stages::Tableau(&[
    &[],
    &[0.5],
    &[0.0, 0.5],
    &[0.0, 0.0, 1.0],
    &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
]);
/// Carpenter, Kennedy, NASA TM 109112 (1994), solution 3.
pub(super) const CARPENTER_KENNEDY: Stages = Stages::TwoRegisters(&[
    [0.0, 1_432_997_174_477.0 / 9_575_080_441_755.0],
    [
        -567_301_805_773.0 / 1_357_537_059_087.0,
        5_161_836_677_717.0 / 13_612_068_292_357.0,
    ],
    [
        -2_404_267_990_393.0 / 2_016_746_695_238.0,
        1_720_146_321_549.0 / 2_090_206_949_498.0,
    ],
    [
        -3_550_918_686_646.0 / 2_091_501_179_385.0,
        3_134_564_353_537.0 / 4_481_467_310_338.0,
    ],
    [
        -1_275_806_237_668.0 / 842_570_457_699.0,
        2_277_821_191_437.0 / 14_882_151_754_819.0,
    ],
]);
/// RDPK3SpFSAL35 of Ranocha, Dalcin, Parsani, Ketcheson, Commun. Appl. Math. Comput. 4 (2022) 1191.
pub(super) const RDPK3_35: Stages = Stages::ThreeRegisters(
    0.230_029_862_451_807_62,
    &[
        [
            0.258_777_197_972_573_3,
            0.552_835_490_930_139,
            0.0,
            0.340_765_587_933_452_5,
            0.302_143_416_694_828_88,
        ],
        [
            -0.132_438_036_014_072_34,
            0.673_187_160_820_306_2,
            0.0,
            0.341_438_265_500_338_6,
            0.802_560_618_541_631_1,
        ],
        [
            0.050_560_339_481_908_26,
            0.280_310_396_329_767_24,
            0.275_256_327_330_467_6,
            0.722_927_536_678_798_7,
            0.436_215_894_360_344_1,
        ],
        [
            0.567_053_200_073_931_3,
            0.552_152_544_702_061,
            -0.895_052_617_467_403_4,
            0.0,
            0.112_927_253_045_505_91,
        ],
    ],
);
/// RDPK3SpFSAL49 of Ranocha, Dalcin, Parsani, Ketcheson, Commun. Appl. Math. Comput. 4 (2022) 1191.
pub(super) const RDPK3_49: Stages = Stages::ThreeRegisters(
    0.283_634_300_518_436_5,
    &[
        [
            -4.655_641_447_335_069,
            2.499_262_792_574_495,
            0.0,
            1.262_923_876_648_114_4,
            0.973_650_010_465_474_2,
        ],
        [
            -0.772_026_509_964_587_2,
            0.586_682_037_771_887_5,
            0.0,
            0.757_496_718_968_591_2,
            0.338_235_922_524_251_53,
        ],
        [
            -4.024_436_690_519_806,
            1.205_146_086_523_094_6,
            0.762_100_667_872_131_5,
            0.516_358_945_314_072_8,
            -0.358_494_361_110_618_34,
        ],
        [
            -0.021_296_762_840_185_31,
            0.347_479_372_218_673_2,
            -0.198_118_250_433_940_06,
            -0.027_463_274_218_026_096,
            -0.004_113_944_068_471_528,
        ],
        [
            -2.435_022_509_790_109_5,
            1.321_346_060_965_113,
            -0.622_895_921_869_900_7,
            -0.438_267_317_812_794_41,
            1.427_968_894_048_586_4,
        ],
        [
            0.019_856_272_971_319_87,
            0.311_963_646_469_419_4,
            -0.375_224_838_077_595_64,
            1.273_587_294_602_656_5,
            0.018_084_709_483_943_14,
        ],
        [
            -0.281_079_114_679_103_86,
            0.435_141_953_968_437_9,
            -0.335_543_830_913_516_98,
            -0.629_474_028_392_74,
            0.160_577_064_594_680_2,
        ],
        [
            0.168_943_416_875_485_96,
            0.235_969_813_002_875_36,
            -0.045_609_550_050_311_21,
            0.0,
            0.295_222_701_596_459_16,
        ],
    ],
);

impl Stages {
    /// Rows of the Butcher tableau, followed by the weights.
    pub(super) fn rows(&self) -> Vec<Vec<f64>> {
        let sum = |terms: &[(f64, &Vec<f64>)], count: usize| -> Vec<f64> {
            let entry = |(factor, row): &(f64, &Vec<f64>), n| factor * row.get(n).unwrap_or(&0.0);
            let all = 0..count;
            all.map(|n| terms.iter().map(|term| entry(term, n)).sum())
                .collect()
        };
        let unit =
            |n: usize| -> Vec<f64> { (0..=n).map(|i| f64::from(u8::from(i == n))).collect() };
        let mut rows = vec![Vec::new()];
        match self {
            Self::Tableau(own) => return own.iter().map(|row| row.to_vec()).collect(),
            Self::TwoRegisters(own) => {
                let mut change = Vec::new();
                for (n, [a, b]) in own.iter().enumerate() {
                    change = sum(&[(*a, &change), (1.0, &unit(n))], n + 1);
                    rows.push(sum(&[(1.0, &rows[n]), (*b, &change)], n + 1));
                }
            }
            Self::ThreeRegisters(first, own) => {
                // Only the contributions of the stages are tracked. The value at the start of the step is preserved by both registers together.
                let mut other = Vec::new();
                rows.push(vec![*first]);
                for (n, [a, b, _, delta, beta]) in (1..).zip(own.iter()) {
                    other = sum(&[(1.0, &other), (*delta, &rows[n])], n);
                    let terms = [(*a, &rows[n]), (*b, &other), (*beta, &unit(n))];
                    rows.push(sum(&terms, n + 1));
                }
            }
        }
        rows
    }

    /// Coefficients of the stability polynomial: a step multiplies a solution `exp(lambda t)` by `P(lambda dt)`.
    pub(super) fn polynomial(&self) -> Vec<f64> {
        let rows = self.rows();
        // Each stage as a polynomial of z.
        let mut stages: Vec<Vec<f64>> = Vec::new();
        for row in &rows {
            let mut stage = vec![0.0; rows.len()];
            stage[0] = 1.0;
            for (factor, other) in row.iter().zip(&stages) {
                for (n, coefficient) in other.iter().enumerate().take(rows.len() - 1) {
                    stage[n + 1] += factor * coefficient;
                }
            }
            stages.push(stage);
        }
        stages.pop().unwrap_or_default()
    }
}

/// Value `P(z)` of the polynomial.
pub(super) fn value(polynomial: &[f64], z: Complex) -> Complex {
    let coefficients = polynomial.iter().rev();
    coefficients.fold(Complex::default(), |sum, c| sum * z + c)
}

/// Distance from zero along a ray where `|P|` first exceeds one; zero if it exceeds one immediately. `direction` has unit length.
pub(super) fn reach(polynomial: &[f64], direction: Complex) -> f64 {
    // |P(r e)|^2 - 1 as a polynomial of r.
    let mut excess = vec![0.0; 2 * polynomial.len() - 1];
    let mut terms = excess.clone();
    for (i, first) in polynomial.iter().enumerate() {
        for (j, second) in polynomial.iter().enumerate() {
            let product = first * second;
            let turned = direction.powu(i as u32) * direction.conj().powu(j as u32);
            excess[i + j] += product * turned.re;
            terms[i + j] += product.abs();
        }
    }
    excess[0] = 0.0;
    for (own, all) in excess.iter_mut().zip(&terms) {
        if own.abs() <= COEFFICIENT_ROUNDING * all {
            *own = 0.0;
        }
    }
    let first = excess.iter().position(|own| *own != 0.0);
    let Some(first) = first.filter(|first| excess[*first] < 0.0) else {
        return match first {
            Some(_) => 0.0,
            None => f64::INFINITY,
        };
    };
    let is_lost = |r: f64| {
        let rest = excess[first..].iter().rev();
        rest.fold(0.0, |sum, own| sum * r + own) > 0.0
    };
    let (mut low, mut high) = (0.0, RESOLUTION);
    while !is_lost(high) {
        (low, high) = (high, high + RESOLUTION);
        if high > MAX_RAY_LENGTH {
            return f64::INFINITY;
        }
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match is_lost(middle) {
            true => high = middle,
            false => low = middle,
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: usize) -> f64 {
        (1..=n).map(|m| m as f64).product()
    }

    #[test]
    fn stability_polynomials_match_the_exponential_to_the_order_of_the_method() {
        for (stages, order, count) in [
            (FORWARD_EULER, 1, 1),
            (HEUN, 2, 2),
            (RK3, 3, 3),
            (RK4, 4, 4),
            (CARPENTER_KENNEDY, 4, 5),
            (RDPK3_35, 3, 5),
            (RDPK3_49, 4, 9),
        ] {
            let polynomial = stages.polynomial();
            assert_eq!(polynomial.len(), count + 1);
            for (n, own) in polynomial.iter().enumerate().take(order + 1) {
                assert!((own * factorial(n) - 1.0).abs() < 1e-11, "{count}: {n}");
            }
        }
        // Coefficient of z^5 of Carpenter and Kennedy: 1/200.
        assert!((CARPENTER_KENNEDY.polynomial()[5] - 0.005).abs() < 1e-12);
    }

    #[test]
    fn stability_limits_along_both_axes_have_the_published_values() {
        let reaches = |stages: Stages| {
            let own = stages.polynomial();
            [Complex::new(0.0, 1.0), Complex::new(-1.0, 0.0)].map(|ray| reach(&own, ray))
        };
        // Hairer, Wanner, Solving Ordinary Differential Equations II, IV.2: 2 sqrt 2 and 2.785294, sqrt 3 and 2.512745.
        for (stages, expected) in [
            (FORWARD_EULER, [0.0, 2.0]),
            (HEUN, [0.0, 2.0]),
            (RK3, [3.0_f64.sqrt(), 2.512_745_3]),
            (RK4, [8.0_f64.sqrt(), 2.785_293_6]),
            // |P| on a grid of a million points along each axis.
            (CARPENTER_KENNEDY, [3.340_72, 4.656_8]),
            (RDPK3_35, [2.739_34, 4.928_3]),
            (RDPK3_49, [5.030_34, 9.468_9]),
        ] {
            let found = reaches(stages);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
            }
        }
    }
}
