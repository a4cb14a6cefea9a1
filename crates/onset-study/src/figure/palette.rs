//! Named colors, safe for color-blind readers, and the fixed colors of the verdicts.
//!
//! The named colors follow M. Okabe and K. Ito, *Color universal design* (2008).

use super::Color;

/// Black, for curves and words.
pub const BLACK: Color = Color::hex(0x000000);
/// White, for rims and backgrounds.
pub const WHITE: Color = Color::hex(0xffffff);
/// Mid grey, for auxiliary lines.
pub const GREY: Color = Color::hex(0x777777);
/// Orange of Okabe and Ito.
pub const ORANGE: Color = Color::hex(0xe69f00);
/// Sky blue of Okabe and Ito.
pub const SKY: Color = Color::hex(0x56b4e9);
/// Bluish green of Okabe and Ito.
pub const GREEN: Color = Color::hex(0x009e73);
/// Yellow; too pale for thin lines on white.
pub const YELLOW: Color = Color::hex(0xf0e442);
/// Blue of Okabe and Ito.
pub const BLUE: Color = Color::hex(0x0072b2);
/// Vermilion of Okabe and Ito.
pub const VERMILION: Color = Color::hex(0xd55e00);
/// Reddish purple of Okabe and Ito.
pub const PURPLE: Color = Color::hex(0xcc79a7);

/// Colors of the curves of a panel, in order.
pub const SERIES: [Color; 7] = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK];

/// Colors of bars that lie close together, in order; the first four differ in lightness, so that they can be distinguished in greyscale.
pub const BARS: [Color; 7] = [BLUE, ORANGE, BLACK, GREEN, PURPLE, VERMILION, SKY];

/// Colors of uniaxial tension, uniaxial compression, equibiaxial tension and equibiaxial compression; the lighter of the two blues is equibiaxial.
pub const LOADS: [Color; 4] = [BLUE, ORANGE, SKY, BLACK];

/// The verdicts and their colors, from harmless to dangerous.
///
/// Any two differ in lightness, so that they can be distinguished in greyscale and by color-blind readers.
pub const VERDICTS: [(&str, Color); 6] = [
    ("stable", Color::hex(0xe4f1f7)),
    ("physical", Color::hex(0x17548f)),
    ("numerical", Color::hex(0xe69500)),
    ("zero-energy", Color::hex(0xb4648f)),
    ("suppressed", Color::hex(0x2a0f26)),
    ("undefined", Color::hex(0xc4c4c4)),
];

/// Returns the color of a verdict, or `None` for any other word.
///
/// ```
/// use onset_study::figure::palette;
/// assert!(palette::verdict("zero-energy").is_some());
/// assert_eq!(palette::verdict("splendid"), None);
/// ```
pub fn verdict(word: &str) -> Option<Color> {
    VERDICTS
        .iter()
        .find(|(name, _)| *name == word)
        .map(|&(_, color)| color)
}

/// Color of a proof result: light if stability is proved, grey if no proof was attempted, yellow if the proof is undecided.
pub fn certainty(word: &str) -> Color {
    match word {
        "proved-stable" => Color::hex(0xe4f1f7),
        "proved-unstable" => BLUE,
        "proved-zero-energy" => PURPLE,
        "undecided" => YELLOW,
        _ => Color::hex(0xc4c4c4),
    }
}

#[cfg(test)]
pub(crate) use tests::lightness;

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(color: Color) -> [f64; 3] {
        [color.red, color.green, color.blue].map(|byte| {
            let s = f64::from(byte) / 255.0;
            if s <= 0.04045 {
                s / 12.92
            } else {
                ((s + 0.055) / 1.055).powf(2.4)
            }
        })
    }

    /// CIE L*a*b* (D65) of linear sRGB.
    fn lab(rgb: [f64; 3]) -> [f64; 3] {
        let [r, g, b] = rgb.map(|c| c.clamp(0.0, 1.0));
        let f = |t: f64| {
            if t > 0.008856 {
                t.cbrt()
            } else {
                7.787 * t + 16.0 / 116.0
            }
        };
        let x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047);
        let y = f(0.2126 * r + 0.7152 * g + 0.0722 * b);
        let z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// Full dichromacy, G. M. Machado et al., IEEE TVCG 15 (2009): protanopia, deuteranopia, tritanopia.
    const DICHROMATS: [[[f64; 3]; 3]; 3] = [
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ],
    ];

    fn pairs() -> impl Iterator<Item = ((&'static str, Color), (&'static str, Color))> {
        (0..VERDICTS.len()).flat_map(|i| (0..i).map(move |j| (VERDICTS[i], VERDICTS[j])))
    }

    /// Lightness L* of a color, from 0 (black) to 100 (white).
    pub(crate) fn lightness(color: Color) -> f64 {
        lab(linear(color))[0]
    }

    #[test]
    fn verdicts_and_bars_differ_in_greyscale() {
        let names = ["first bar", "second bar", "third bar", "fourth bar"];
        let bar = |n: usize| (names[n], BARS[n]);
        let bars = (0..4).flat_map(|i| (0..i).map(move |j| (bar(i), bar(j))));
        for ((a, first), (b, second)) in pairs().chain(bars) {
            let difference = (lightness(first) - lightness(second)).abs();
            assert!(
                difference > 8.0,
                "{a} and {b} differ by {difference:.1} in L*"
            );
        }
    }

    #[test]
    fn verdict_colors_differ_for_color_blind_readers() {
        differ_for_color_blind_readers(pairs());
    }

    #[test]
    fn loads_differ_for_color_blind_readers() {
        let names = [
            "tension",
            "compression",
            "equibiaxial tension",
            "equibiaxial compression",
        ];
        let named = |n: usize| (names[n], LOADS[n]);
        differ_for_color_blind_readers(
            (0..4)
                .flat_map(|i| (0..i).map(move |j| (i, j)))
                .map(|(i, j)| (named(i), named(j))),
        );
    }

    fn differ_for_color_blind_readers(
        pairs: impl Iterator<Item = ((&'static str, Color), (&'static str, Color))>,
    ) {
        for ((a, first), (b, second)) in pairs {
            for matrix in DICHROMATS {
                let seen = |color| {
                    let rgb = linear(color);
                    lab(matrix.map(|row| (0..3).map(|i| row[i] * rgb[i]).sum()))
                };
                let (p, q) = (seen(first), seen(second));
                let distance = (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
                assert!(distance > 15.0, "{a} and {b} are only {distance:.1} apart");
            }
        }
    }
}
