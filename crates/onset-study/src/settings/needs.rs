//! Under which other choices a key is read.
//!
//! A key has cases; it is read where all needs of one of them are met, and always where it has none. A need is about another key,
//! which must itself be read. So a method is a choice with keys of its own, and each key says in one place who reads it.

use super::{Key, Value};

/// What a key needs of another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// The other key.
    pub key: &'static str,
    /// The values that are meant, as they are written.
    pub values: &'static [&'static str],
    /// Whether the value must be one of them; otherwise none of them.
    pub one_of: bool,
}

/// Alternatives, each with all its needs; none for a key that is always read.
pub type Cases = &'static [&'static [Need]];

/// That another key is one of some values.
pub(super) const fn is(key: &'static str, values: &'static [&'static str]) -> Need {
    Need {
        key,
        values,
        one_of: true,
    }
}

/// That another key is none of some values.
pub(super) const fn is_not(key: &'static str, values: &'static [&'static str]) -> Need {
    Need {
        key,
        values,
        one_of: false,
    }
}

/// A need that is not met.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    /// What is needed.
    pub need: Need,
    /// What is set.
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
    /// Why the key is not read; `None` where it is. `value` tells what other keys are; one that it does not tell is open, as on an
    /// axis, and meets every need.
    pub fn unmet(&self, value: &impl Fn(&str) -> Option<Value>) -> Option<Unmet> {
        let of_need = |need: &Need| {
            let deeper = Self::named(need.key).and_then(|key| key.unmet(value));
            deeper.or_else(|| {
                let value = value(need.key)?;
                (!need.is_met(&value)).then_some(Unmet { need: *need, value })
            })
        };
        // What is told is what the nearest case lacks.
        let lacks = |case: &&'static [Need]| case.iter().filter_map(of_need).collect::<Vec<_>>();
        let nearest = self.read_with.iter().map(lacks);
        nearest.min_by_key(Vec::len)?.into_iter().next()
    }

    /// What must be chosen otherwise for the key to be read while another key, `held`, stays as it is: nothing where it is read, `None`
    /// where that alone forbids it.
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

    /// Who reads the key, in words; empty where it is always read.
    pub fn readers(&self) -> String {
        let cases: Vec<String> = self.all_needs().iter().map(|case| told(case)).collect();
        cases.join(", or ")
    }

    /// The cases with the needs of the keys that they name.
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
