//! Reading of studies from TOML.

use super::super::toml::{File, described, in_order, list, read_keys, scalar};
use super::super::{
    Axis, BodySettings, Kind, MapSettings, Origin, Quantity, SettingError, Settings, StateSettings,
    Value, error::nearest, listed, study_keys, units, unknown_key,
};
use super::{AxisOrigin, Origins, Study};
use crate::number::counted;
use std::borrow::Cow;
use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

const SECTIONS: [&str; 6] = ["material", "discretization", "time", "state", "axes", "map"];

const AXIS_KEYS: [&str; 3] = ["axes.quantity", "axes.range", "axes.states"];

/// Admissible numbers of states of an axis.
pub(in crate::settings) const STATES: (u32, u32) = (2, 65536);

/// Example of axes for messages.
const EXAMPLE: &str = "for example\n\n    [[axes]]\n    quantity = \"stretch-1\"\n    range = [0.5, 2.0]\n    states = 64\n\n    \
                       [[axes]]\n    quantity = \"stretch-2\"\n    range = [0.5, 2.0]\n    states = 64\n";

/// Reads a study without checking that it has axes and that its parts fit together. Methods to compare, which a study may also have, are read by
/// [`Comparison`](super::super::Comparison).
pub(in crate::settings) fn read(name: &str, text: &str) -> Result<Study, SettingError> {
    let file = File::new(name, text);
    let table = file.table()?;
    let mut study = Study {
        title: String::new(),
        settings: Settings::default(),
        state: StateSettings::default(),
        axes: Vec::new(),
        map: MapSettings::default(),
        text: text.to_owned(),
        has_methods: false,
        origins: Origins {
            file: file.at(0),
            keys: BTreeMap::new(),
            axes: Vec::new(),
        },
    };
    for (key, value) in in_order(table.get_ref()) {
        match (key.get_ref().as_ref(), value.get_ref()) {
            ("title", DeValue::String(title)) => study.title = title.to_string(),
            ("title", other) => {
                let message = format!("`title` cannot be {}", described(other));
                return Err(
                    SettingError::new(file.of(value), message).hint("expected a string in quotes")
                );
            }
            ("axes", value) => read_axes(&mut study, &file, key, value)?,
            (section, DeValue::Table(inner)) if SECTIONS.contains(&section) => {
                let names = study_keys().map(|key| key.name);
                read_keys(&file, section, inner, names, |key, value, origin| {
                    study.put(key, value, origin)
                })?;
            }
            (section, other) if SECTIONS.contains(&section) => {
                let message = format!("`{section}` cannot be {}", described(other));
                return Err(SettingError::new(file.of(key), message)
                    .hint(format!("expected a table: [{section}] with its keys below")));
            }
            // These sections are read as a whole below.
            ("body", DeValue::Table(_)) | ("grips", DeValue::Array(_)) => {}
            ("compare", DeValue::Table(_)) | ("methods", DeValue::Array(_)) => {
                study.has_methods = true;
            }
            (other, _) => {
                let known = SECTIONS
                    .into_iter()
                    .chain(["title", "compare", "methods", "body", "grips"]);
                return Err(unknown_key(other, known, file.of(key)));
            }
        }
    }
    study.settings.body = BodySettings::of_table(&file, table.get_ref())?;
    Ok(study)
}

impl Study {
    /// Checks that the study has axes, which maps need.
    pub(super) fn require_axes(&self) -> Result<(), SettingError> {
        match self.axes.is_empty() {
            true => Err(SettingError::new(
                self.origins.file.clone(),
                "the study has no axes; expected two or three",
            )
            .hint(match self.settings.body.is_some() {
                true => "a [body] is run by `onset simulate STUDY`",
                false => EXAMPLE,
            })),
            false => Ok(()),
        }
    }
}

fn read_axes(
    study: &mut Study,
    file: &File<'_>,
    key: &Spanned<Cow<'_, str>>,
    value: &DeValue<'_>,
) -> Result<(), SettingError> {
    let not_axes = |other: &DeValue<'_>, origin: Origin| {
        let message = format!("`axes` cannot be {}", described(other));
        SettingError::new(origin, message).hint(format!("expected [[axes]], {EXAMPLE}"))
    };
    let DeValue::Array(items) = value else {
        return Err(not_axes(value, file.of(key)));
    };
    for item in items.iter() {
        let DeValue::Table(table) = item.get_ref() else {
            return Err(not_axes(item.get_ref(), file.of(item)));
        };
        let (axis, has_units, origin) = read_axis(file, file.of(item), table)?;
        if let (Quantity::Setting(key), true) = (axis.quantity, has_units) {
            study.settings.measure(key);
        }
        study.axes.push(axis);
        study.origins.axes.push(origin);
    }
    if !(2..=3).contains(&study.axes.len()) {
        let message = format!(
            "the study has {}; expected two or three axes",
            match study.axes.len() {
                1 => "1 axis".to_owned(),
                count => format!("{count} axes"),
            }
        );
        return Err(SettingError::new(file.of(key), message).hint(EXAMPLE));
    }
    Ok(())
}

fn read_axis(
    file: &File<'_>,
    whole: Origin,
    table: &DeTable<'_>,
) -> Result<(Axis, bool, AxisOrigin), SettingError> {
    for (key, _) in in_order(table) {
        let name = format!("axes.{}", key.get_ref());
        if !AXIS_KEYS.contains(&name.as_str()) {
            return Err(unknown_key(&name, AXIS_KEYS.into_iter(), file.of(key)));
        }
    }
    let field = |name: &str, expected: &str| {
        table.get(name).ok_or_else(|| {
            SettingError::new(whole.clone(), format!("the axis has no `{name}`"))
                .hint(format!("expected {name} = {expected}"))
        })
    };
    let place = field("quantity", "\"stretch-1\" or another quantity")?;
    let quantity = quantity(place.get_ref(), file.of(place))?;
    let of_quantity = AxisOrigin {
        quantity: file.of(place),
        range: file.of(field("range", "[lowest, highest]")?),
    };
    let (range, has_units) = range(
        quantity,
        file,
        field("range", "[lowest, highest]")?,
        &of_quantity.range,
    )?;
    let place = field("states", "64")?;
    let count = scalar(place.get_ref())
        .and_then(|value| value.number())
        .filter(|count| Kind::Whole(STATES.0, STATES.1).accepts(&Value::Number(*count)))
        .ok_or_else(|| {
            let message = format!("`axes.states` cannot be {}", described(place.get_ref()));
            let hint = format!("expected {}", Kind::Whole(STATES.0, STATES.1).expects());
            SettingError::new(file.of(place), message).hint(hint)
        })?;
    let axis = Axis {
        quantity,
        range,
        count: count as usize,
    };
    Ok((axis, has_units, of_quantity))
}

/// A list of texts with units; `None` for anything else.
fn measured_range(
    quantity: Quantity,
    file: &File<'_>,
    value: &Spanned<DeValue<'_>>,
) -> Result<Option<Vec<f64>>, SettingError> {
    let (DeValue::Array(items), Quantity::Setting(key)) = (value.get_ref(), quantity) else {
        return Ok(None);
    };
    let mut ends = Vec::new();
    for item in items.iter() {
        let Some(end) = scalar(item.get_ref()) else {
            return Ok(None);
        };
        match units::converted(key, &end, &file.of(item))? {
            Some(Value::Number(number)) => ends.push(number),
            _ => return Ok(None),
        }
    }
    Ok(Some(ends))
}

fn quantity(value: &DeValue<'_>, origin: Origin) -> Result<Quantity, SettingError> {
    let names = Quantity::all().map(Quantity::name);
    let known = || format!("expected one of {}", listed(names.clone()));
    let DeValue::String(name) = value else {
        let message = format!("`axes.quantity` cannot be {}", described(value));
        return Err(SettingError::new(origin, message).hint(known()));
    };
    Quantity::of_name(name).ok_or_else(|| {
        let message = match study_keys().find(|key| key.name == name) {
            Some(_) => {
                format!("`{name}` cannot be an axis, because it does not take a range of numbers")
            }
            None => format!("there is no quantity `{}`", onset_frames::cut(name)),
        };
        let completed = names
            .clone()
            .find(|known| known.rsplit('.').next() == Some(name));
        let error = SettingError::new(origin, message);
        match completed.or_else(|| nearest(name, names.clone())) {
            Some(nearest) => error.hint(format!("did you mean `{nearest}`? {}", known())),
            None => error.hint(known()),
        }
    })
}

/// Ends of a range, and whether they have units.
fn range(
    quantity: Quantity,
    file: &File<'_>,
    value: &Spanned<DeValue<'_>>,
    origin: &Origin,
) -> Result<((f64, f64), bool), SettingError> {
    let wrong = |message: String| {
        SettingError::new(origin.clone(), message).hint(format!(
            "expected [lowest, highest] of {}: {}",
            quantity.name(),
            quantity.expects()
        ))
    };
    let described = described(value.get_ref());
    let measured = measured_range(quantity, file, value)?;
    let has_units = measured.is_some();
    match measured.or_else(|| list(value.get_ref())).as_deref() {
        Some([low, high]) => match [low, high].into_iter().find(|end| !quantity.admits(**end)) {
            Some(end) => {
                let end = Value::Number(*end);
                Err(wrong(format!("{} cannot be {end}", quantity.name())))
            }
            None if low >= high => Err(wrong(format!(
                "the range of {} leads from {low} to {high}; the first number must be smaller",
                quantity.name()
            ))),
            None => Ok(((*low, *high), has_units)),
        },
        Some(numbers) => Err(wrong(format!(
            "the range of {} has {}; expected 2",
            quantity.name(),
            counted(numbers.len(), "number")
        ))),
        None => Err(wrong(format!(
            "the range of {} cannot be {described}",
            quantity.name()
        ))),
    }
}
