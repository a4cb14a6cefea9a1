//! Study files: settings in TOML, and the window of states that a figure shows.

use super::{Origin, SettingError, Settings, Value, unknown_key};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A study: material, discretization, and a window of principal stretches.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// What it shows.
    pub title: String,
    /// Material and discretization.
    pub settings: Settings,
    /// Range of the first principal stretch.
    pub stretch_1: (f64, f64),
    /// Range of the second principal stretch.
    pub stretch_2: (f64, f64),
    /// States along each axis.
    pub resolution: usize,
}

/// Keys beside those of the settings.
const OWN_KEYS: [&str; 4] = [
    "title",
    "states.stretch-1",
    "states.stretch-2",
    "states.resolution",
];

impl Study {
    /// The principal stretches of a state: the center of its cell in the window, the first stretch running fastest.
    pub fn stretches(&self, index: usize) -> [f64; 2] {
        let center = |(low, high): (f64, f64), n: usize| {
            low + (high - low) * (n as f64 + 0.5) / self.resolution as f64
        };
        let (column, row) = (index % self.resolution, index / self.resolution);
        [center(self.stretch_1, column), center(self.stretch_2, row)]
    }

    /// Reads a study.
    ///
    /// # Errors
    /// [`SettingError`] with the line and column of what cannot be accepted.
    pub fn parse(name: &str, text: &str) -> Result<Self, SettingError> {
        let at = |offset: usize| {
            let before = &text[..offset.min(text.len())];
            let line = before.matches('\n').count() + 1;
            let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
            Origin::File {
                name: name.to_owned(),
                line,
                column,
            }
        };
        let table = DeTable::parse(text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            SettingError::new(at(offset), error.message().to_owned())
        })?;
        let mut study = Self {
            title: String::new(),
            settings: Settings::default(),
            stretch_1: (0.2, 2.0),
            stretch_2: (0.2, 2.0),
            resolution: 48,
        };
        study.read(table.get_ref(), "", &at)?;
        study.settings.material.check()?;
        Ok(study)
    }

    fn read(
        &mut self,
        table: &DeTable<'_>,
        prefix: &str,
        at: &impl Fn(usize) -> Origin,
    ) -> Result<(), SettingError> {
        for (key, value) in table {
            let name = format!("{prefix}{}", key.get_ref());
            match value.get_ref() {
                DeValue::Table(inner) if prefix.is_empty() => {
                    if !["material", "discretization", "states"].contains(&name.as_str()) {
                        let known = ["material", "discretization", "states"].into_iter();
                        return Err(unknown_key(&name, known, at(key.span().start)));
                    }
                    self.read(inner, &format!("{name}."), at)?;
                }
                _ => self.set(&name, key, value, at)?,
            }
        }
        Ok(())
    }

    fn set(
        &mut self,
        name: &str,
        key: &Spanned<std::borrow::Cow<'_, str>>,
        value: &Spanned<DeValue<'_>>,
        at: &impl Fn(usize) -> Origin,
    ) -> Result<(), SettingError> {
        let origin = at(value.span().start);
        let wrong = |expected: &str| {
            SettingError::new(origin.clone(), format!("`{name}` is not {expected}"))
                .hint(format!("expected {expected}"))
        };
        match name {
            "title" => {
                self.title = value
                    .get_ref()
                    .as_str()
                    .ok_or_else(|| wrong("a text in quotes"))?
                    .to_owned();
            }
            "states.stretch-1" => self.stretch_1 = range(value).ok_or_else(|| wrong(RANGE))?,
            "states.stretch-2" => self.stretch_2 = range(value).ok_or_else(|| wrong(RANGE))?,
            "states.resolution" => {
                let states = number(value.get_ref())
                    .filter(|n| n.fract() == 0.0 && (2.0..=4096.0).contains(n));
                self.resolution =
                    states.ok_or_else(|| wrong("a whole number from 2 to 4096"))? as usize;
            }
            _ => {
                let known = super::KEYS.iter().map(|key| key.name);
                if !known.clone().any(|known| known == name) {
                    return Err(unknown_key(
                        name,
                        known.chain(OWN_KEYS),
                        at(key.span().start),
                    ));
                }
                let typed = match value.get_ref() {
                    DeValue::String(word) => Value::Word(word.to_string()),
                    other => Value::Number(
                        number(other).ok_or_else(|| wrong("a number or a word in quotes"))?,
                    ),
                };
                self.settings.set(name, &typed, origin)?;
            }
        }
        Ok(())
    }
}

const RANGE: &str = "a range of positive stretches such as [0.5, 2.0]";

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => integer.as_str().parse().ok(),
        _ => None,
    }
}

fn range(value: &Spanned<DeValue<'_>>) -> Option<(f64, f64)> {
    let DeValue::Array(items) = value.get_ref() else {
        return None;
    };
    let numbers: Option<Vec<f64>> = items.iter().map(|item| number(item.get_ref())).collect();
    match numbers?[..] {
        [low, high] if low > 0.0 && low < high && high.is_finite() => Some((low, high)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::Study;

    #[test]
    fn a_study_is_read_with_all_its_parts() {
        let text = "title = \"t\"\n[material]\nmodel = \"blatz-ko\"\nmu = 1\n[discretization]\nsupport = 1.9\n\
                    [states]\nstretch-1 = [0.5, 2]\nresolution = 10\n";
        let study = Study::parse("s.toml", text).expect("valid");
        assert_eq!((study.stretch_1, study.resolution), ((0.5, 2.0), 10));
        assert_eq!(study.settings.discretization.support, 1.9);
        assert_eq!(study.settings.material.values(), [("mu", 1.0)]);
    }

    #[test]
    fn errors_name_file_line_column_and_a_hint() {
        let error = |text: &str| {
            Study::parse("s.toml", text)
                .expect_err("invalid")
                .to_string()
        };
        let message = error("[discretization]\nsuport = 2\n");
        assert!(
            message.starts_with("s.toml:2:1: unknown key `discretization.suport`"),
            "{message}"
        );
        assert!(
            message.contains("did you mean `discretization.support`?"),
            "{message}"
        );
        assert!(error("[states]\nresolution = 1\n").starts_with("s.toml:2:14: "));
        assert!(error("[states]\nstretch-1 = [2, 1]\n").contains("range of positive stretches"));
        assert!(error("[material\n").starts_with("s.toml:1:"));
        assert!(error("[state]\nx=1\n").contains("did you mean `states`?"));
    }
}
