//! JSON Schema of a study, from the tables of keys.

use super::key::smoothing_length;
use super::moduli::MODULI;
use super::study::STATES;
use super::{
    BODY_KEYS, COMPARISON_KEYS, GRIP_KEYS, KEYS, Key, Kind, Model, Need, Quantity, study_keys,
};
use onset::material::{Admitted, Parameter};
use serde_json::{Map, Value, json};

/// Returns the JSON Schema (draft 2020-12) of a study.
///
/// It cannot express conditions on several parts together (a key that is also an axis, a rotation without effect); [`super::Study::parse`] checks
/// these. Other names of words are accepted in studies but not listed in the schema.
pub fn schema() -> Value {
    let mut sections = Map::new();
    for section in ["material", "discretization", "time", "state", "map"] {
        if section == "map" {
            sections.insert("axes".to_owned(), axes());
        }
        sections.insert(section.to_owned(), table(section));
    }
    sections.insert("compare".to_owned(), table_of(COMPARISON_KEYS));
    sections.insert("methods".to_owned(), methods());
    sections.insert("body".to_owned(), table_of(BODY_KEYS));
    let grips = json!({
        "type": "array",
        "description": "particles of the body with a prescribed motion",
        "items": table_of(GRIP_KEYS)
    });
    sections.insert("grips".to_owned(), grips);
    let title = json!({ "type": "string", "description": "what the study shows" });
    let mut properties = Map::from_iter([("title".to_owned(), title)]);
    properties.extend(sections);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A study of onset",
        "description": "Material, discretization, fixed and varied quantities, and settings of the map",
        "type": "object",
        "properties": properties,
        "anyOf": [{ "required": ["axes"] }, { "required": ["body"] }],
        "additionalProperties": false
    })
}

/// Schema of a section of keys.
fn table(section: &str) -> Value {
    let keys = || {
        study_keys()
            .chain([smoothing_length()])
            .filter(|key| key.parts().0 == section)
    };
    let properties: Map<String, Value> = keys()
        .map(|key| (key.parts().1.to_owned(), property(key)))
        .collect();
    let mut table = json!({
        "type": "object",
        "properties": properties,
        "additionalProperties": false
    });
    let conditions: Vec<Value> = keys().filter_map(readers).collect();
    if !conditions.is_empty() {
        table["allOf"] = conditions.into();
    }
    if section == "material" {
        // The user names the parameters of a user-defined model.
        table["additionalProperties"] = json!({ "anyOf": [{ "type": "number" }, measure()] });
        table["allOf"] = Model::all().map(keys_of).collect();
    }
    table
}

/// Condition under which a key is allowed. Keys that an axis may vary are unknown here, and not required.
fn readers(key: &Key) -> Option<Value> {
    let cases: Vec<Value> = key
        .all_needs()
        .iter()
        .map(|case| {
            let needs: Vec<Value> = case.iter().filter_map(demand).collect();
            json!({ "allOf": needs })
        })
        .collect();
    // A case without conditions is always met.
    let is_open = cases.iter().any(|case| case["allOf"] == json!([]));
    let condition = json!({ "required": [key.parts().1] });
    (!cases.is_empty() && !is_open).then(|| json!({ "if": condition, "then": { "anyOf": cases } }))
}

/// Returns the schema that a section satisfies if a need is met.
fn demand(need: &Need) -> Option<Value> {
    let key = Key::named(need.key).filter(|key| !key.is_varied())?;
    let value = |written: &&str| serde_json::from_str(written).unwrap_or_else(|_| json!(written));
    let values: Vec<Value> = need.values.iter().map(value).collect();
    let is_met_by_default = values.contains(&key.default_json()) == need.one_of;
    let (name, listed) = (key.parts().1, json!({ "enum": values }));
    let mut demand = match need.one_of {
        true => json!({ "properties": { name: listed } }),
        false => json!({ "properties": { name: { "not": listed } } }),
    };
    if !is_met_by_default {
        demand["required"] = json!([name]);
    }
    Some(demand)
}

/// Restricts a material to the keys of its model, and numbers to the values that its law admits.
fn keys_of(model: Model) -> Value {
    let mut condition = json!({ "properties": { "model": { "const": model.name() } } });
    // Without a model the default applies.
    if model != Model::default() {
        condition["required"] = json!(["model"]);
    }
    let parameters: Map<String, Value> = model
        .parameters()
        .iter()
        .map(|parameter| (parameter.name.to_owned(), number(parameter)))
        .collect();
    let is_isotropic = model.is_isotropic();
    let moduli = MODULI
        .into_iter()
        .filter(|_| is_isotropic)
        .map(|(name, ..)| name);
    let names: Vec<&str> = ["model", "plane"]
        .into_iter()
        .chain(model.names())
        .chain(moduli)
        .collect();
    let mut consequence = json!({ "properties": parameters });
    if !model.takes_any_parameter() {
        consequence["propertyNames"] = json!({ "enum": names });
    }
    if let Model::Own(own) = model {
        consequence["required"] = json!(own.required);
    }
    json!({ "if": condition, "then": consequence })
}

/// Schema of a parameter of a law.
fn number(parameter: &Parameter) -> Value {
    let mut number = limits(parameter.admitted, parameter.unit);
    number["description"] = described(parameter.meaning, Some(parameter.unit));
    number["default"] = parameter.default.into();
    number
}

/// Range of a number.
fn limits(admitted: Admitted, unit: &str) -> Value {
    let [low, high] = admitted.limits(unit);
    match admitted {
        Admitted::Between(..) => json!({ "exclusiveMinimum": low, "exclusiveMaximum": high }),
        _ => json!({ "minimum": low, "maximum": high }),
    }
}

/// Description with its unit.
fn described(meaning: &str, unit: Option<&str>) -> Value {
    match unit {
        None | Some("1") => meaning.into(),
        Some(unit) => format!("{meaning} ({unit})").into(),
    }
}

/// Schema of a number with a unit.
fn measure() -> Value {
    json!({ "type": "string", "pattern": "^[-+]?[0-9.]+([eE][-+]?[0-9]+)? *[A-Za-zµ°].*$" })
}

/// Schema of the value of a key.
fn property(key: &Key) -> Value {
    let mut property = match key.kind {
        Kind::Number(unit, admitted) => {
            // The law limits its parameters.
            let mut number = match key.is_parameter() {
                true => json!({}),
                false => limits(admitted, unit),
            };
            number["type"] = "number".into();
            match unit {
                "1" => number,
                _ => json!({ "anyOf": [number, measure()] }),
            }
        }
        Kind::Words(words) => json!({ "enum": words }),
        Kind::WordsOr(words, other) => {
            json!({ "anyOf": [{ "enum": words }, { "type": "string", "title": other }] })
        }
        Kind::Whole(least, most) => {
            json!({ "type": "integer", "minimum": least, "maximum": most })
        }
        Kind::PowerOfTwo(least, most) => {
            let powers = (0..32).map(|power| 1 << power);
            let admitted: Vec<u32> = powers.filter(|n| (least..=most).contains(n)).collect();
            json!({ "enum": admitted })
        }
        Kind::Switch => json!({ "type": "boolean" }),
        Kind::Text => json!({ "type": "string" }),
        Kind::Subset(words) => {
            json!({ "type": "array", "items": { "enum": words }, "uniqueItems": true })
        }
        Kind::Numbers(unit, admitted) => {
            let mut number = limits(admitted, unit);
            number["type"] = "number".into();
            json!({ "type": "array", "items": number })
        }
    };
    property["description"] = described(key.meaning, key.unit());
    if let default @ (Value::Bool(_) | Value::Number(_) | Value::String(_)) = key.default_json() {
        property["default"] = default;
    }
    property
}

/// Schema of a table whose keys are used by a single command.
fn table_of(keys: &[Key]) -> Value {
    let properties: Map<String, Value> = keys
        .iter()
        .map(|key| (key.parts().1.to_owned(), property(key)))
        .collect();
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

/// Schema of methods for comparison: keys of the discretization with a name.
fn methods() -> Value {
    let own = KEYS.iter().chain([smoothing_length()]);
    let own = own.filter(|key| key.parts().0 == "discretization");
    let mut properties: Map<String, Value> = own
        .map(|key| (key.parts().1.to_owned(), property(key)))
        .collect();
    let name = json!({ "type": "string", "description": "name of the method in tables and figures; if omitted, its family and what differs" });
    properties.insert("name".to_owned(), name);
    json!({
        "type": "array",
        "description": "methods to compare: settings of each in addition to [discretization]",
        "items": {
            "type": "object",
            "properties": properties,
            "additionalProperties": false
        }
    })
}

fn axes() -> Value {
    let all = || Quantity::all().chain([Quantity::Setting(smoothing_length())]);
    let names: Vec<&str> = all().map(Quantity::name).collect();
    let mut by_limits: Vec<([f64; 2], Vec<&str>)> = Vec::new();
    for quantity in all() {
        let Some(limits) = quantity.limits() else {
            continue;
        };
        match by_limits.iter_mut().find(|(own, _)| *own == limits) {
            Some((_, names)) => names.push(quantity.name()),
            None => by_limits.push((limits, vec![quantity.name()])),
        }
    }
    let limited: Vec<Value> = by_limits
        .into_iter()
        .map(|([low, high], names)| {
            let ends = json!({ "minimum": low, "maximum": high });
            json!({
                "if": { "properties": { "quantity": { "enum": names } } },
                "then": { "properties": { "range": { "items": ends } } }
            })
        })
        .collect();
    let (least, most) = STATES;
    json!({
        "type": "array",
        "description": "quantity that is varied; the first axis varies fastest",
        "minItems": 2,
        "maxItems": 3,
        "items": {
            "type": "object",
            "properties": {
                "quantity": {
                    "type": "string",
                    "anyOf": [{ "enum": names }, { "pattern": "^material\\.[A-Za-z][A-Za-z0-9_]*$" }],
                    "description": "what the axis varies"
                },
                "range": {
                    "type": "array",
                    "description": "lower and upper end; the states are the centers of equal cells between them",
                    "items": { "anyOf": [{ "type": "number" }, measure()] },
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
            "allOf": limited
        }
    })
}
