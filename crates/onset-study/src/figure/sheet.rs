//! Sheet: size, colors, title and caption of a drawn figure.

use super::scene::{Paint, Stroke};
use super::{Color, Figure};
use std::str::FromStr;

/// Number of pixels per millimeter.
pub(super) const MILLIMETER: f64 = 96.0 / 25.4;
/// Smallest and largest width of a picture in print, in millimeters.
const WIDTHS: (f64, f64) = (30.0, 1000.0);

/// Options for drawing a figure: size, title, caption and colors.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sheet {
    /// Size of the picture or of its panels; `None` for the usual size.
    pub size: Option<Size>,
    /// Title that replaces the title of the figure; `None` keeps it.
    pub title: Option<String>,
    /// Whether title and caption are omitted, as in a paper, whose text contains them.
    pub bare: bool,
    /// Colors of background, axes and words.
    pub theme: Theme,
}

/// Size of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Size {
    /// Width of the whole picture in millimeters; letters have 8 pt, or less if the panels need more room.
    Picture(f64),
    /// Width and height of the box of a panel in pixels (1/96 inch); the maximum for an equal aspect.
    Panel(f64, f64),
}

/// Colors of background, axes and words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Theme {
    /// Black axes and words on white.
    #[default]
    Light,
    /// White on black, for slides and dark pages. The colors of layers are unchanged; greys are inverted.
    Dark,
}

impl FromStr for Size {
    type Err = String;

    /// Reads a width with a unit (`84mm`), or width and height of a panel in pixels (`420,315`).
    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|n| n.is_finite());
        if let Some((width, height)) = text.split_once(',') {
            let side = |text| number(text).filter(|side| (40.0..=4000.0).contains(side));
            return match (side(width), side(height)) {
                (Some(width), Some(height)) => Ok(Self::Panel(width, height)),
                _ => Err(
                    "expected width and height in pixels from 40 to 4000, for example 420,315"
                        .to_owned(),
                ),
            };
        }
        const UNITS: [(&str, f64); 4] =
            [("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("pt", 25.4 / 72.0)];
        let (low, high) = WIDTHS;
        UNITS
            .iter()
            .find_map(|(unit, size)| Some(number(text.trim().strip_suffix(unit)?)? * size))
            .filter(|width| (low..=high).contains(width))
            .map(Self::Picture)
            .ok_or_else(|| {
                format!(
                    "expected a width from {low} to {high} mm with its unit (mm, cm, in or pt), for example 84mm, or width and height of a panel in pixels, for example 420,315"
                )
            })
    }
}

impl Theme {
    /// All themes, in the order of the help.
    pub const ALL: [Self; 2] = [Self::Light, Self::Dark];

    /// The word used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Light => "light",
            Self::Dark => "dark",
        }
    }

    /// Color in the current theme for a color of the light theme.
    pub(super) fn of(self, color: Color) -> Color {
        let parts = [color.red, color.green, color.blue];
        let [low, high] =
            [parts.iter().min(), parts.iter().max()].map(|part| part.copied().unwrap_or(0));
        match self {
            Self::Dark if high - low < 0x10 => {
                DARK.toward(BRIGHT, 1.0 - f64::from(color.green) / 255.0)
            }
            _ => color,
        }
    }

    /// Paint in the current theme for a paint of the light theme. The colors of maps remain unchanged, because their lightness has a meaning.
    pub(super) fn paint(self, paint: &Paint) -> Paint {
        if paint.crisp {
            return *paint;
        }
        Paint {
            fill: paint.fill.map(|color| self.of(color)),
            stroke: paint.stroke.map(|stroke| Stroke {
                color: self.of(stroke.color),
                ..stroke
            }),
            crisp: false,
        }
    }
}

/// Background and ink of the dark theme.
const DARK: Color = Color::hex(0x16181c);
const BRIGHT: Color = Color::hex(0xf2f2f2);

impl Sheet {
    /// Figure with the title of the sheet, or without title and caption.
    pub(super) fn dressed(&self, figure: &Figure) -> Figure {
        let mut figure = figure.clone();
        if let Some(title) = &self.title {
            figure.title.clone_from(title);
        }
        if self.bare {
            figure.title.clear();
            figure.caption.clear();
            figure.is_bare = true;
        }
        if let Some(Size::Panel(width, height)) = self.size {
            figure.panel_size = Some((width, height));
        }
        figure
    }

    /// Title of the picture, whether it is drawn or not.
    pub(super) fn title_of<'a>(&'a self, figure: &'a Figure) -> &'a str {
        self.title.as_ref().unwrap_or(&figure.title).trim()
    }

    /// Title, caption and the titles of omitted panels, which are written to a separate file for a bare picture: one paragraph for LaTeX. `None` if
    /// the picture contains them or all are empty.
    pub(super) fn words_beside(&self, figure: &Figure, omitted: &[String]) -> Option<String> {
        let mut words: Vec<String> = [self.title_of(figure), figure.caption.trim()]
            .into_iter()
            .filter(|words| !words.is_empty())
            .map(sentence)
            .collect();
        words.extend(told_omitted(omitted));
        (self.bare && !words.is_empty()).then(|| latex(&words.join(" ")) + "\n")
    }
}

/// Sentence on panels that are omitted at the width of a picture.
pub(super) fn told_omitted(titles: &[String]) -> Option<String> {
    let shown: Vec<&str> = titles.iter().map(String::as_str).collect();
    (!shown.is_empty()).then(|| format!("Not shown at this width: {}.", shown.join(", ")))
}

/// Text with a capital and a full stop. A single letter or `omega` at the beginning is a symbol, and stays as it is.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first: String = letters
        .next()
        .into_iter()
        .flat_map(char::to_uppercase)
        .collect();
    let is_word =
        text.chars().take(2).all(|own| own.is_ascii_lowercase()) && !text.starts_with("omega");
    let text = match is_word {
        true => first + letters.as_str(),
        false => text.to_owned(),
    };
    match text.ends_with(['.', '!', '?', ':']) {
        true => text,
        false => format!("{text}."),
    }
}

/// Letters of the captions that LaTeX reads only as a command of mathematics.
const LATEX: &[(char, &str)] = &[
    ('Γ', "\\Gamma"),
    ('Δ', "\\Delta"),
    ('Λ', "\\Lambda"),
    ('Σ', "\\Sigma"),
    ('Ω', "\\Omega"),
    ('α', "\\alpha"),
    ('β', "\\beta"),
    ('γ', "\\gamma"),
    ('δ', "\\delta"),
    ('ε', "\\varepsilon"),
    ('θ', "\\theta"),
    ('κ', "\\kappa"),
    ('λ', "\\lambda"),
    ('μ', "\\mu"),
    ('ν', "\\nu"),
    ('π', "\\pi"),
    ('ρ', "\\rho"),
    ('σ', "\\sigma"),
    ('τ', "\\tau"),
    ('φ', "\\varphi"),
    ('ω', "\\omega"),
    ('−', "-"),
    ('×', "\\times"),
    ('·', "\\cdot"),
    ('±', "\\pm"),
    ('≤', "\\le"),
    ('≥', "\\ge"),
    ('≈', "\\approx"),
    ('∞', "\\infty"),
    ('√', "\\surd"),
    ('∂', "\\partial"),
    ('°', "^\\circ"),
    ('→', "\\to"),
    ('′', "'"),
    ('|', "|"),
    ('<', "<"),
    ('>', ">"),
];
/// Raised and lowered letters: their number in the tables is the digit.
const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const LOWERED: &str = "₀₁₂₃₄₅₆₇₈₉";
/// Letters with a meaning in LaTeX, and marks of punctuation that old versions of it do not read.
const ESCAPED: &[(char, &str)] = &[
    ('%', "\\%"),
    ('&', "\\&"),
    ('#', "\\#"),
    ('$', "\\$"),
    ('_', "\\_"),
    ('{', "\\{"),
    ('}', "\\}"),
    ('~', "\\textasciitilde{}"),
    ('\\', "\\textbackslash{}"),
    ('–', "--"),
    ('—', "---"),
    ('…', "\\dots{}"),
    ('“', "``"),
    ('”', "''"),
    ('\u{a0}', "~"),
];

/// Text as LaTeX reads it, in one line: mathematical letters, and powers such as `omega^2`, are formulas.
fn latex(text: &str) -> String {
    let words = text.split(|letter: char| letter.is_whitespace() && letter != '\u{a0}');
    let words = words.filter(|word| !word.is_empty()).map(latex_word);
    words.collect::<Vec<_>>().join(" ")
}

/// Text with formulas between dollar signs. Formulas that follow each other are one formula.
#[derive(Default)]
struct Latex {
    text: String,
    is_formula: bool,
}

impl Latex {
    fn push(&mut self, is_formula: bool, text: &str) {
        if self.is_formula != is_formula {
            self.text.push('$');
            self.is_formula = is_formula;
        }
        self.text += text;
    }

    fn done(mut self) -> String {
        self.push(false, "");
        self.text
    }
}

fn latex_word(word: &str) -> String {
    let digit_in = |row: &str, letter: char| row.chars().position(|own| own == letter);
    let raised = |letter: char| match letter {
        '⁻' => Some("-".to_owned()),
        letter => digit_in(RAISED, letter).map(|digit| digit.to_string()),
    };
    let lowered = |letter: char| digit_in(LOWERED, letter).map(|digit| digit.to_string());
    let mut out = Latex::default();
    let mut letters = word.chars().peekable();
    while let Some(letter) = letters.next() {
        let known = LATEX.iter().find(|(own, _)| *own == letter);
        // A run of raised or lowered letters is one exponent or index.
        let run = |first: String,
                   of: &dyn Fn(char) -> Option<String>,
                   letters: &mut std::iter::Peekable<std::str::Chars<'_>>| {
            let mut all = first;
            while let Some(next) = letters.peek().and_then(|next| of(*next)) {
                all += &next;
                letters.next();
            }
            all
        };
        if let Some((_, command)) = known {
            out.push(true, command);
        } else if let Some(first) = raised(letter) {
            let all = run(first, &raised, &mut letters);
            out.push(true, &format!("^{{{all}}}"));
        } else if let Some(first) = lowered(letter) {
            let all = run(first, &lowered, &mut letters);
            out.push(true, &format!("_{{{all}}}"));
        } else if letter == '^' {
            let mut power = String::new();
            while let Some(next) = letters.next_if(|own| own.is_ascii_digit() || *own == '-') {
                power.push(next);
            }
            if power.is_empty() {
                out.push(false, "\\textasciicircum{}");
                continue;
            }
            // The base is a formula too, if it is the name of a letter.
            if !out.is_formula && out.text.ends_with("omega") {
                out.text.truncate(out.text.len() - "omega".len());
                out.push(true, "\\omega");
            }
            out.push(true, &format!("^{{{power}}}"));
        } else if let Some((_, text)) = ESCAPED.iter().find(|(own, _)| *own == letter) {
            out.push(false, text);
        } else {
            out.push(false, letter.encode_utf8(&mut [0; 4]));
        }
    }
    out.done()
}

#[cfg(test)]
mod tests {
    use super::super::palette;
    use super::*;

    #[test]
    fn a_size_is_a_width_with_a_unit_or_a_panel_in_pixels() {
        for (text, size) in [
            ("84mm", Size::Picture(84.0)),
            ("8.4 cm", Size::Picture(84.0)),
            ("2in", Size::Picture(50.8)),
            ("420,315", Size::Panel(420.0, 315.0)),
        ] {
            assert_eq!(text.parse(), Ok(size), "{text}");
        }
        for text in [
            "84", "mm", "-84mm", "1e9mm", "NaNmm", "420,", "420,1", "84px", "",
        ] {
            assert!(text.parse::<Size>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_caption_of_a_bare_picture_is_one_paragraph_for_latex() {
        let figure =
            Figure::new("Waves at λ₁ = 1.2").caption("omega^2 below 0 grows;\n\n50 % of k³ a_b");
        let sheet = Sheet {
            bare: true,
            ..Sheet::default()
        };
        let words = sheet.words_beside(&figure, &["Cost".to_owned()]);
        assert_eq!(
            words.as_deref(),
            Some(
                "Waves at $\\lambda_{1}$ = 1.2. $\\omega^{2}$ below 0 grows; 50 \\% of k$^{3}$ a\\_b. Not shown at this width: Cost.\n"
            )
        );
        for (text, expected) in [
            ("neo-hooke in updated-sph", "Neo-hooke in updated-sph."),
            ("k at the corner", "k at the corner."),
            ("λ₁ = 1.2:", "λ₁ = 1.2:"),
        ] {
            assert_eq!(sentence(text), expected);
        }
        for (text, expected) in [
            ("10⁻³ F₁₂", "10$^{-3}$ F$_{12}$"),
            ("λ⁻⁴", "$\\lambda^{-4}$"),
            ("(1.2,\u{a0}0.9)", "(1.2,~0.9)"),
            ("$ω", "\\$$\\omega$"),
        ] {
            assert_eq!(latex(text), expected);
        }
    }

    #[test]
    fn the_dark_theme_swaps_black_and_white_and_keeps_colors() {
        assert_eq!(Theme::Dark.of(palette::WHITE), DARK);
        assert_eq!(Theme::Dark.of(palette::BLACK), BRIGHT);
        assert_eq!(Theme::Dark.of(palette::BLUE), palette::BLUE);
        assert_eq!(Theme::Light.of(palette::WHITE), palette::WHITE);
    }
}
