//! The JSON Schema of a study, from the tables of keys.

use super::study::STATES;
use super::{Key, Kind, Model, Quantity, study_keys};
use serde_json::{Map, Value, json};

/// The JSON Schema (draft 2020-12) of a study. What concerns several parts at once (a key that is also an axis, a
/// rotation that turns nothing) it cannot say; [`super::Study::parse`] does.
pub fn schema() -> Value {
    let mut sections = Map::new();
    for section in ["material", "discretization", "state", "map"] {
        if section == "map" {
            sections.insert("axes".to_owned(), axes());
        }
        sections.insert(section.to_owned(), table(section));
    }
    let title = json!({ "type": "string", "description": "what the study shows" });
    let mut properties = Map::from_iter([("title".to_owned(), title)]);
    properties.extend(sections);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A study of onset",
        "description": "Material, discretization, what is held fixed, what is varied, and how the map is made",
        "type": "object",
        "properties": properties,
        "required": ["axes"],
        "additionalProperties": false
    })
}

/// A section of keys.
fn table(section: &str) -> Value {
    let keys = study_keys().filter(|key| key.parts().0 == section);
    let properties: Map<String, Value> = keys
        .map(|key| (key.parts().1.to_owned(), property(key)))
        .collect();
    let mut table = json!({
        "type": "object",
        "properties": properties,
        "additionalProperties": false
    });
    if section == "material" {
        table["allOf"] = Model::ALL.map(parameters_of).to_vec().into();
    }
    table
}

/// That a material has its own parameters only.
fn parameters_of(model: Model) -> Value {
    let names = model.parameters().iter().map(|(name, _)| *name);
    let names: Vec<&str> = std::iter::once("model").chain(names).collect();
    let mut condition = json!({ "properties": { "model": { "const": model.name() } } });
    // Where no model is given the default holds.
    if model != Model::default() {
        condition["required"] = json!(["model"]);
    }
    json!({ "if": condition, "then": { "propertyNames": { "enum": names } } })
}

/// What a key takes.
fn property(key: &Key) -> Value {
    let mut property = match key.kind {
        Kind::Words(words) => json!({ "enum": words }),
        Kind::Number(_) => json!({ "type": "number" }),
        Kind::Positive(_) => json!({ "type": "number", "exclusiveMinimum": 0 }),
        Kind::Whole(least, most) => {
            json!({ "type": "integer", "minimum": least, "maximum": most })
        }
        Kind::PowerOfTwo(least, most) => {
            let powers = (0..32).map(|power| 1 << power);
            let admitted: Vec<u32> = powers.filter(|n| (least..=most).contains(n)).collect();
            json!({ "enum": admitted })
        }
        Kind::Switch => json!({ "type": "boolean" }),
    };
    property["description"] = match key.unit() {
        None | Some("1") => key.meaning.into(),
        Some(unit) => format!("{} ({unit})", key.meaning).into(),
    };
    property["default"] = key.default_json();
    property
}

fn axes() -> Value {
    let names: Vec<&str> = Quantity::all().map(Quantity::name).collect();
    let positive: Vec<&str> = Quantity::all()
        .filter(|quantity| !quantity.admits(0.0))
        .map(Quantity::name)
        .collect();
    let (least, most) = STATES;
    json!({
        "type": "array",
        "description": "what is varied; the first axis runs fastest",
        "minItems": 2,
        "maxItems": 3,
        "items": {
            "type": "object",
            "properties": {
                "quantity": { "enum": names, "description": "what the axis varies" },
                "range": {
                    "type": "array",
                    "description": "its ends, the lower one first; the states lie in the middle of equal cells between them",
                    "items": { "type": "number" },
                    "minItems": 2,
                    "maxItems": 2
                },
                "states": {
                    "type": "integer",
                    "description": "number of states",
                    "minimum": least,
                    "maximum": most
                }
            },
            "required": ["quantity", "range", "states"],
            "additionalProperties": false,
            "allOf": [
                {
                    "if": { "properties": { "quantity": { "enum": positive } } },
                    "then": { "properties": { "range": { "items": { "exclusiveMinimum": 0 } } } }
                },
                {
                    "if": { "properties": { "quantity": { "const": Quantity::Rotation.name() } } },
                    "then": {
                        "properties": {
                            "range": {
                                "items": { "minimum": -std::f64::consts::TAU, "maximum": std::f64::consts::TAU }
                            }
                        }
                    }
                }
            ]
        }
    })
}
