//! Units in values: `80 GPa`, `1 mm`, `7850 kg/m^3`.
//!
//! Either all values of a problem have units, or none. Without units the numbers are in any consistent units. With units every value is converted to
//! SI when it is read, and answers are in Pa, m, s and kg.

use super::{Key, Origin, SettingError, Value, error::nearest};

/// Units of the dimensions that keys name, with their values in SI (angles: in the unit of the key, degrees or radians).
const UNITS: &[(&str, &[(&str, f64)])] = &[
    (
        "stress",
        &[
            ("Pa", 1.0),
            ("kPa", 1e3),
            ("MPa", 1e6),
            ("GPa", 1e9),
            ("TPa", 1e12),
            ("N/m^2", 1.0),
            ("N/mm^2", 1e6),
            ("bar", 1e5),
            ("kgf/cm^2", 98_066.5),
            ("kgf/mm^2", 9_806_650.0),
            ("psi", 6_894.757_293_168_361),
            ("ksi", 6_894_757.293_168_361),
        ],
    ),
    (
        "length",
        &[
            ("m", 1.0),
            ("cm", 1e-2),
            ("mm", 1e-3),
            ("um", 1e-6),
            ("µm", 1e-6),
            ("nm", 1e-9),
            ("km", 1e3),
            ("in", 0.0254),
        ],
    ),
    (
        "force",
        &[
            ("N", 1.0),
            ("kN", 1e3),
            ("MN", 1e6),
            ("mN", 1e-3),
            ("lbf", 4.448_221_615_260_5),
            ("kgf", 9.806_65),
            ("gf", 9.806_65e-3),
        ],
    ),
    (
        "mass/volume",
        &[
            ("kg/m^3", 1.0),
            ("g/cm^3", 1e3),
            ("kg/l", 1e3),
            ("t/m^3", 1e3),
            ("t/mm^3", 1e12),
            ("lb/in^3", 27_679.904_710_203_12),
        ],
    ),
    (
        "time",
        &[
            ("s", 1.0),
            ("ms", 1e-3),
            ("us", 1e-6),
            ("µs", 1e-6),
            ("ns", 1e-9),
            ("min", 60.0),
            ("h", 3600.0),
        ],
    ),
    (
        "deg",
        &[
            ("deg", 1.0),
            ("°", 1.0),
            ("rad", 180.0 / std::f64::consts::PI),
        ],
    ),
    (
        "rad",
        &[
            ("rad", 1.0),
            ("deg", std::f64::consts::PI / 180.0),
            ("°", std::f64::consts::PI / 180.0),
        ],
    ),
];

/// Units of a dimension with their values in SI; empty for an unknown dimension.
fn of(dimension: &str) -> &'static [(&'static str, f64)] {
    let own = UNITS.iter().find(|(own, _)| *own == dimension);
    own.map_or(&[], |(_, units)| units)
}

/// Value in SI of a unit of a dimension; `None` if it is not a unit of it.
pub(crate) fn value_of(dimension: &str, unit: &str) -> Option<f64> {
    let mut units = of(dimension).iter();
    let found = units.find(|(own, _)| plain(own) == plain(unit));
    found.map(|(_, value)| *value)
}

/// Value of a unit of stress in pascals; `None` if it is not known.
pub fn stress_unit(name: &str) -> Option<f64> {
    value_of("stress", name)
}

/// Names of the units of a dimension, in a list.
pub(crate) fn names_of(dimension: &str) -> String {
    let names: Vec<&str> = of(dimension).iter().map(|(name, _)| *name).collect();
    names.join(", ")
}

/// SI unit of a dimension; `None` for dimensionless quantities, and for angles, whose keys name the unit.
pub(crate) fn si(dimension: &str) -> Option<&'static str> {
    match dimension {
        "stress" => Some("Pa"),
        "length" => Some("m"),
        "1/length" => Some("1/m"),
        "time" => Some("s"),
        "1/time" => Some("1/s"),
        "1/time^2" => Some("1/s^2"),
        "mass/volume" => Some("kg/m^3"),
        _ => None,
    }
}

/// Time in seconds of a text with a unit; `None` without a unit.
///
/// # Errors
/// Description of the error if the unit is not a unit of time.
pub(super) fn time(text: &str) -> Result<Option<f64>, String> {
    let Some((number, unit)) = split(text) else {
        return Ok(None);
    };
    match value_of("time", unit) {
        Some(factor) => Ok(Some(scaled(number, factor))),
        None => Err(format!(
            "`{}` is not a unit of time; units are {}",
            onset_frames::brief(unit),
            names_of("time")
        )),
    }
}

/// Splits a number followed by letters, as typed: `80GPa`, `7850 kg/m^3`.
pub(super) fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let (number, unit) = text.split_at(number_length(text.as_bytes()));
    let (number, unit) = (number.parse::<f64>().ok()?, unit.trim_start());
    let is_unit = unit.starts_with(|first: char| first.is_alphabetic() || first == '°');
    (number.is_finite() && is_unit).then_some((number, unit))
}

/// Length of the longest prefix that is a decimal number: three characters of `1e3m`, a thousand meters.
fn number_length(text: &[u8]) -> usize {
    let digits = |from: usize| {
        text[from..]
            .iter()
            .take_while(|byte| byte.is_ascii_digit())
            .count()
    };
    let signed = |at: usize| at + usize::from(matches!(text.get(at), Some(b'+' | b'-')));
    let start = signed(0);
    let mut end = start + digits(start);
    if text.get(end) == Some(&b'.') {
        end += 1 + digits(end + 1);
    }
    if matches!(text.get(end), Some(b'e' | b'E')) {
        let exponent = signed(end + 1);
        let count = digits(exponent.min(text.len()));
        if count > 0 {
            end = exponent + count;
        }
    }
    end
}

/// Canonical form of a unit for comparison: `kg/m3` and `kg/m³` are `kg/m^3`.
fn plain(unit: &str) -> String {
    unit.replace('³', "3").replace('²', "2").replace('^', "")
}

/// Converts a value with a unit to SI; `None` if the text has no unit.
///
/// # Errors
/// [`SettingError`] for an unknown unit, or a unit of another quantity.
pub(crate) fn converted(
    key: &Key,
    value: &Value,
    origin: &Origin,
) -> Result<Option<Value>, SettingError> {
    let (Value::Word(text), Some(dimension)) = (value, key.unit()) else {
        return Ok(None);
    };
    let Some((number, unit)) = split(text) else {
        return Ok(None);
    };
    let wrong =
        |message: String, hint: String| Err(SettingError::new(origin.clone(), message).hint(hint));
    let is = |known: &str| plain(known) == plain(unit);
    // A parameter of a formula has the dimension that the formula implies.
    let mut own: Box<dyn Iterator<Item = &(&str, f64)>> = match key.is_free() {
        true => Box::new(UNITS.iter().flat_map(|(_, units)| *units)),
        false => Box::new(of(dimension).iter()),
    };
    if let Some((_, factor)) = own.find(|(known, _)| is(known)) {
        return Ok(Some(Value::Number(scaled(number, *factor))));
    }
    let other = UNITS
        .iter()
        .find(|(_, units)| units.iter().any(|(known, _)| is(known)));
    match (of(dimension), other) {
        ([], _) => wrong(
            format!(
                "`{}` has no dimension and accepts no unit such as `{}`",
                key.name,
                onset_frames::brief(unit)
            ),
            format!("give a number without unit ({})", key.meaning),
        ),
        (_, Some((other, _))) => wrong(
            format!(
                "`{}` is {}; `{unit}` is a unit of {}",
                key.name,
                named(dimension),
                named(other)
            ),
            format!("units of {} are {}", named(dimension), names_of(dimension)),
        ),
        (units, None) => {
            let known = || units.iter().map(|(known, _)| *known);
            let same = known().find(|known| known.eq_ignore_ascii_case(unit));
            let nearest = same.or_else(|| nearest(unit, known()));
            let meant =
                nearest.map_or_else(String::new, |known| format!("did you mean `{known}`? "));
            wrong(
                format!("`{}` is not a known unit", onset_frames::brief(unit)),
                format!(
                    "{meant}units of {} are {}",
                    named(dimension),
                    names_of(dimension)
                ),
            )
        }
    }
}

/// A number times a power of ten, rounded as a decimal number: `1 mm` is 0.001 m as a user would type it.
fn scaled(number: f64, factor: f64) -> f64 {
    if factor < 1.0 && factor.recip().fract() == 0.0 {
        return number / factor.recip();
    }
    number * factor
}

/// Name of a dimension with its article, for messages.
fn named(dimension: &str) -> &str {
    match dimension {
        "stress" => "a stress",
        "length" => "a length",
        "force" => "a force",
        "mass/volume" => "a density",
        "deg" | "rad" => "an angle",
        other => other,
    }
}

/// Checks that either all values with dimensions have a unit, or none. A value is `None` for a file of numbers, which has no units.
///
/// # Errors
/// [`SettingError`] that names the values without a unit.
pub(crate) fn check<'a>(
    values: impl Iterator<Item = (Key, Option<f64>, bool, Option<&'a Origin>)>,
) -> Result<bool, SettingError> {
    let (with, without): (Vec<_>, Vec<_>) = values.partition(|(_, _, has_unit, _)| *has_unit);
    let Some((first, ..)) = with.first() else {
        return Ok(false);
    };
    // Zero needs no unit.
    let without: Vec<_> = without
        .into_iter()
        .filter(|(_, value, ..)| *value != Some(0.0))
        .collect();
    let Some((_, _, _, origin)) = without.first() else {
        return Ok(true);
    };
    let told: Vec<String> = without
        .iter()
        .map(|(key, value, _, origin)| match (value, origin) {
            (None, _) => format!("the numbers of {}", key.name),
            (Some(value), Some(_)) => format!("{} = {value}", key.name),
            (Some(value), None) => format!("{} = {value} (the default)", key.name),
        })
        .collect();
    let file = without.iter().find(|(_, value, ..)| value.is_none());
    let example: Vec<String> = without
        .iter()
        .map(|(key, ..)| {
            let example = match key.unit() {
                Some("length") => "1mm",
                Some("mass/volume") => "7850kg/m^3",
                Some(_) => "80GPa",
                None => "\"0.3, 0, 1ms\"",
            };
            format!("--set {}={example}", key.name)
        })
        .collect();
    let message = format!(
        "`{}` has a unit, and {} {} none: give units to all values with dimensions, or to none",
        first.name,
        told.join(", "),
        match (told.len(), file) {
            (1, None) => "has",
            _ => "have",
        }
    );
    let origin = origin.cloned().unwrap_or(Origin::Combination);
    let hint = match file {
        Some((key, ..)) => format!(
            "omit all units, and write values in consistent units with the stresses of {}",
            key.name
        ),
        None => format!("for example {}", example.join(" ")),
    };
    Err(SettingError::new(origin, message).hint(hint))
}

/// The units of the numbers of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum Units {
    /// Any consistent units of the problem.
    #[default]
    #[serde(rename = "own")]
    Own,
    /// Units of the International System.
    #[serde(rename = "SI")]
    Si,
}

impl Units {
    /// A printed number, followed by its SI unit, such as `Pa`, if SI is in use.
    pub fn of(self, number: impl std::fmt::Display, unit: &str) -> String {
        match self {
            Self::Own => number.to_string(),
            Self::Si => format!("{number} {unit}"),
        }
    }

    /// Unit of a dimension; the dimension itself if values have no units.
    ///
    /// ```
    /// use onset_study::settings::Units;
    /// assert_eq!((Units::Si.unit("1/time^2"), Units::Own.unit("1/time^2")), ("1/s^2", "1/time^2"));
    /// assert_eq!((Units::Si.unit("rad"), Units::Own.unit("1")), ("rad", "1"));
    /// ```
    pub fn unit(self, dimension: &'static str) -> &'static str {
        match self {
            Self::Own => dimension,
            Self::Si => si(dimension).unwrap_or(dimension),
        }
    }

    /// Quantity with its unit, as on the axis of a figure.
    ///
    /// ```
    /// use onset_study::settings::Units;
    /// assert_eq!(Units::Si.label("growth rate", "1/time"), "growth rate (1/s)");
    /// assert_eq!(Units::Own.label("min ω²", "1/time^2"), "min ω² (1/time²)");
    /// assert_eq!(Units::Own.label("stretch λ₁", "1"), "stretch λ₁ (−)");
    /// assert_eq!([Units::Si, Units::Own].map(|units| units.label("time", "time")), ["time (s)", "time"]);
    /// ```
    pub fn label(self, what: &str, dimension: &'static str) -> String {
        let unit = match self.unit(dimension) {
            unit if unit == what => return what.to_owned(),
            "1" => "−".to_owned(),
            unit => unit.replace("^2", "²").replace("^3", "³"),
        };
        format!("{what} ({unit})")
    }

    /// Name of a column of a table, with the unit in brackets if it is known.
    ///
    /// ```
    /// use onset_study::settings::Units;
    /// assert_eq!((Units::Si.head("s11", "stress"), Units::Own.head("s11", "stress")), ("s11 [Pa]".into(), "s11".into()));
    /// assert_eq!((Units::Si.head("F11", "1"), Units::Own.head("angle", "deg")), ("F11".into(), "angle [deg]".into()));
    /// ```
    pub fn head(self, name: &str, dimension: &str) -> String {
        let unit = match (dimension, self) {
            ("deg" | "rad", _) => Some(dimension),
            (_, Self::Own) => None,
            (_, Self::Si) => si(dimension),
        };
        unit.map_or_else(|| name.to_owned(), |unit| format!("{name} [{unit}]"))
    }

    /// Returns true if values have units.
    pub fn are_si(&self) -> bool {
        *self == Self::Si
    }
}

#[cfg(test)]
mod tests {
    use super::{converted, split};
    use crate::settings::{Key, Origin, Value};

    fn of(key: &str, text: &str) -> Result<Option<Value>, String> {
        let key = Key::named(key).expect("a key");
        converted(key, &Value::Word(text.to_owned()), &Origin::Combination)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn a_number_is_split_from_its_unit() {
        for (text, expected) in [
            ("80GPa", Some((80.0, "GPa"))),
            (" 1e-3 mm ", Some((1e-3, "mm"))),
            ("7850 kg/m^3", Some((7850.0, "kg/m^3"))),
            ("1e3m", Some((1e3, "m"))),
            ("-2.5MPa", Some((-2.5, "MPa"))),
            ("80", None),
            ("GPa", None),
            ("inf", None),
            ("nan", None),
            ("1,2", None),
        ] {
            assert_eq!(split(text), expected, "{text}");
        }
    }

    #[test]
    fn values_with_units_are_converted_to_si() {
        for (key, text, value) in [
            ("material.mu", "80GPa", 80e9),
            ("material.mu", "3 N/mm^2", 3e6),
            ("material.mu", "3 N/mm2", 3e6),
            ("material.mu", "1 psi", 6_894.757_293_168_361),
            ("discretization.spacing", "1 mm", 1e-3),
            ("discretization.spacing", "7 mm", 7e-3),
            ("discretization.spacing", "3um", 3e-6),
            ("discretization.density", "7850 kg/m^3", 7850.0),
            ("discretization.density", "7.85 g/cm³", 7850.0),
            ("discretization.density", "7850 kg/m3", 7850.0),
            ("material.angle", "0.5rad", 0.5_f64.to_degrees()),
            ("state.rotation", "30 deg", 30.0_f64.to_radians()),
        ] {
            assert_eq!(
                of(key, text),
                Ok(Some(Value::Number(value))),
                "{key} {text}"
            );
        }
        assert_eq!(of("material.mu", "soft"), Ok(None));
    }

    #[test]
    fn unknown_units_and_units_of_another_quantity_are_refused() {
        for (key, text, fact) in [
            (
                "material.mu",
                "1 mm",
                "is a stress; `mm` is a unit of a length",
            ),
            ("material.mu", "80 Gpa", "did you mean `GPa`?"),
            (
                "discretization.spacing",
                "3 parsec",
                "units of a length are m, cm, mm",
            ),
            ("discretization.support", "2 mm", "has no dimension"),
        ] {
            let told = of(key, text).expect_err("refused");
            assert!(told.contains(fact), "{told}");
        }
    }
}
