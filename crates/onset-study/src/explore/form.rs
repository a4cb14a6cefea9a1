//! Form of a question: the keys that its law and its method use, with their values.

use super::{Question, Refusal};
use crate::catalog::KeyEntry;
use crate::settings::{Key, Model, Plane, Settings, Trust, Value, word_of};
use onset::formula::Formula;
use onset::material::{Admitted, Parameter};
use serde::Serialize;

/// Fields of a form.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Form {
    /// Number of space dimensions.
    dimension: usize,
    /// Keys that law and method use, in the order of the documentation.
    fields: Vec<Field>,
    /// Assignments that law and method use.
    set: Vec<String>,
    /// Parameters of a user-defined energy that have no value yet.
    missing: Vec<String>,
}

/// Key with its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Field {
    #[serde(flatten)]
    key: KeyEntry,
    /// Words that the key accepts.
    words: Vec<&'static str>,
    /// Other values that the key accepts: `number`, `whole`, `switch`, `text`, or none.
    takes: Option<&'static str>,
    /// Value of the key.
    value: Value,
    /// Whether the value is the default.
    is_default: bool,
    /// Range of a slider, for numbers.
    slider: Option<[f64; 2]>,
}

/// Form of a question.
///
/// A page keeps its assignments when another law or method is chosen; assignments without effect are omitted.
pub(super) fn form(question: &Question, trust: &Trust) -> Result<Form, Refusal> {
    let set = read(question)?;
    let own = Question {
        set: set.clone(),
        ..Question::default()
    };
    let mut settings = Settings::default();
    for assignment in &own.set {
        settings.assign(assignment)?;
    }
    super::question::permit(&mut settings.material, trust)?;
    let effective = settings.effective();
    // Moduli are shown as they were set, without derived moduli.
    let (moduli, follows) = settings.moduli();
    let moduli = moduli.iter().map(|(name, choice)| (*name, choice));
    let others = effective.choices();
    let others = others.filter(|(name, _)| !follows.iter().any(|own| own == name));
    let (of_material, of_method): (Vec<_>, Vec<_>) =
        others.partition(|(name, _)| name.starts_with("material."));
    let mut fields: Vec<Field> = of_material
        .into_iter()
        .chain(moduli)
        .chain(of_method)
        .filter_map(|(name, choice)| {
            let key = Key::named(name)?;
            Some(field(&settings, key, choice.value.clone(), choice.default))
        })
        .collect();
    let energy = Key::named("material.energy");
    let is_formula = settings.material.model.takes_any_parameter();
    if let Some(key) = energy.filter(|key| is_formula && effective.get(key.name).is_none()) {
        fields.insert(1, field(&settings, key, Value::Word(String::new()), true));
    }
    let plane = Key::named("material.plane").filter(|_| settings.dimension() < 3);
    if let Some(key) = plane.filter(|key| effective.get(key.name).is_none()) {
        fields.insert(
            1,
            field(&settings, key, Value::Word(word_of(&Plane::Strain)), true),
        );
    }
    Ok(Form {
        dimension: settings.dimension(),
        fields,
        missing: missing(&settings),
        set,
    })
}

/// Assignments that are used. Whether an assignment is used may depend on others, so the selection is repeated until nothing changes.
fn read(question: &Question) -> Result<Vec<String>, Refusal> {
    let mut set = question.set.clone();
    loop {
        let mut settings = Settings::default();
        for assignment in &set {
            settings.assign(assignment)?;
        }
        let is_read = |assignment: &String| {
            let name = assignment.split('=').next().unwrap_or_default().trim();
            match name.split_once('.') {
                Some(("material", "model")) => true,
                Some(("material", "plane")) => settings.dimension() < 3,
                Some(("material", own)) => {
                    settings.material.model.takes(own) || settings.material.reads_modulus(own)
                }
                _ => Key::named(name).is_none_or(|key| settings.unmet(key).is_none()),
            }
        };
        let kept: Vec<String> = set.iter().filter(|own| is_read(own)).cloned().collect();
        if kept.len() == set.len() {
            return Ok(kept);
        }
        set = kept;
    }
}

fn field(settings: &Settings, key: &'static Key, value: Value, is_default: bool) -> Field {
    let model = settings.material.model;
    let own = model.parameters().iter();
    let own = own.clone().find(|own| own.name == key.parts().1);
    let of_law = own.filter(|_| key.parts().0 == "material");
    let mut entry = KeyEntry::of(key);
    if let Some(parameter) = of_law {
        entry.meaning = parameter.meaning;
        entry.default = parameter.default.to_string();
        entry.expects = parameter.expected();
    }
    Field {
        key: entry,
        words: key.words().to_vec(),
        takes: key.kind.takes(),
        slider: slider(key, of_law, &value),
        value,
        is_default,
    }
}

/// Range of a slider: a multiple of the default within the limits of the key or law; it includes the value.
fn slider(key: &Key, parameter: Option<&Parameter>, value: &Value) -> Option<[f64; 2]> {
    let limits = match parameter {
        Some(parameter) => parameter.admitted.limits(parameter.unit),
        None => key.kind.limits()?,
    };
    if key.kind.takes() == Some("whole") {
        return Some(limits);
    }
    key.unit()?;
    let value = value.number()?;
    let usual = match parameter {
        Some(parameter) => parameter.default,
        None => key.default_json().as_f64().unwrap_or(value),
    };
    let size = match usual.abs().max(value.abs()) {
        0.0 => 1.0,
        size => size,
    };
    let [least, most] = limits;
    let [low, high] = match parameter.map(|parameter| parameter.admitted) {
        Some(Admitted::Fraction) => limits,
        Some(Admitted::Between(..)) => {
            let margin = 1e-3 * (most - least);
            [least + margin, most - margin]
        }
        Some(Admitted::Positive) => [size / 50.0, 3.0 * size],
        None if least > 0.0 => [size / 5.0, 3.0 * size],
        None if usual == 0.0 => [0.0, 2.0 * size],
        _ => [-3.0 * size, 3.0 * size],
    };
    Some([low.max(least).min(value), high.min(most).max(value)])
}

/// Parameters of a user-defined energy without a value.
fn missing(settings: &Settings) -> Vec<String> {
    let Some(Value::Word(text)) = settings.material.given("energy") else {
        return Vec::new();
    };
    let is_formula = matches!(settings.material.model, Model::Own(own) if own.takes_any_parameter);
    match Formula::parse(text) {
        Ok(formula) if is_formula => formula
            .parameters()
            .filter(|name| settings.material.given(name).is_none())
            .map(str::to_owned)
            .collect(),
        _ => Vec::new(),
    }
}
