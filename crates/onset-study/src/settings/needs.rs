//! Conditions under which a key has an effect.
//!
//! A key has cases. It has an effect if all needs of one case are met, or if it has no cases. A need refers to another key, which must itself have an
//! effect. A method is thus a choice that enables its keys, and each key states its conditions in one place.

use super::{Key, Value};

/// Condition on the value of another key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Name of the other key.
    pub key: &'static str,
    /// Values in the condition, as they are written.
    pub values: &'static [&'static str],
    /// Whether the value must be in `values`; otherwise it must differ from all `values`.
    pub one_of: bool,
}

/// Alternative conditions, each with all its needs; empty for a key that always has an effect.
pub type Cases = &'static [&'static [Need]];

/// Condition that another key has one of some values.
pub(super) const fn is(key: &'static str, values: &'static [&'static str]) -> Need {
    Need {
        key,
        values,
        one_of: true,
    }
}

/// Condition that another key differs from some values.
pub(super) const fn is_not(key: &'static str, values: &'static [&'static str]) -> Need {
    Need {
        key,
        values,
        one_of: false,
    }
}

/// Unmet condition of a key.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    /// Condition that is violated.
    pub need: Need,
    /// Value of the other key.
    pub value: Value,
}

impl Need {
    fn is_met(&self, value: &Value) -> bool {
        let is = |written: &&str| match (value, written.parse::<f64>()) {
            (Value::Number(number), Ok(written)) => *number == written,
            (Value::Word(word), _) => word == written,
            (other, _) => other.to_string() == **written,
        };
        self.values.iter().any(is) == self.one_of
    }
}

impl std::fmt::Display for Need {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let values = self.values.join(" or ");
        match self.one_of {
            true => write!(formatter, "{} = {values}", self.key),
            false => write!(formatter, "{} other than {values}", self.key),
        }
    }
}

impl Key {
    /// Returns a condition that the key violates, or `None` if it has an effect. `value` returns the values of other keys; `None` is an open value,
    /// as on an axis, and meets every need.
    pub fn unmet(&self, value: &impl Fn(&str) -> Option<Value>) -> Option<Unmet> {
        let of_need = |need: &Need| {
            let deeper = Self::named(need.key).and_then(|key| key.unmet(value));
            deeper.or_else(|| {
                let value = value(need.key)?;
                (!need.is_met(&value)).then_some(Unmet { need: *need, value })
            })
        };
        // The nearest case is the one with the fewest violated needs.
        let lacks = |case: &&'static [Need]| case.iter().filter_map(of_need).collect::<Vec<_>>();
        let nearest = self.read_with.iter().map(lacks);
        nearest.min_by_key(Vec::len)?.into_iter().next()
    }

    /// Conditions that must still be met for the key to have an effect, while another key, `held`, keeps its value. Empty if it has an effect, `None`
    /// if the value of `held` rules it out.
    pub fn lacking(&self, held: &str, value: &impl Fn(&str) -> Option<Value>) -> Option<Vec<Need>> {
        let cases = self.all_needs();
        if cases.is_empty() {
            return Some(Vec::new());
        }
        let is_unmet = |need: &Need| value(need.key).is_some_and(|value| !need.is_met(&value));
        let lacking =
            |case: Vec<Need>| -> Vec<Need> { case.into_iter().filter(is_unmet).collect() };
        let possible = |lacking: &Vec<Need>| lacking.iter().all(|need| need.key != held);
        cases
            .into_iter()
            .map(lacking)
            .filter(possible)
            .min_by_key(Vec::len)
    }

    /// Description of the conditions of the key; empty if it always has an effect.
    pub fn readers(&self) -> String {
        let cases: Vec<String> = self.all_needs().iter().map(|case| told(case)).collect();
        cases.join(", or ")
    }

    /// Cases of the key, including the needs of the keys that they refer to.
    pub(super) fn all_needs(&self) -> Vec<Vec<Need>> {
        let whole = |case: &&'static [Need]| {
            case.iter().fold(vec![Vec::new()], |found, need| {
                let deeper = Self::named(need.key).map_or_else(Vec::new, Self::all_needs);
                let deeper = if deeper.is_empty() {
                    vec![Vec::new()]
                } else {
                    deeper
                };
                let joined = found.iter().flat_map(|before: &Vec<Need>| {
                    deeper.iter().map(|own| {
                        let mut all = before.clone();
                        for need in own.iter().chain([need]) {
                            if !all.contains(need) {
                                all.push(*need);
                            }
                        }
                        all
                    })
                });
                joined.collect()
            })
        };
        self.read_with.iter().flat_map(whole).collect()
    }
}

fn told(case: &[Need]) -> String {
    let needs: Vec<String> = case.iter().map(ToString::to_string).collect();
    needs.join(" and ")
}
