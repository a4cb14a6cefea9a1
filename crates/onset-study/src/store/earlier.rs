//! Stores of the previous format, whose flags have other names: they can be read, but not written to.

use super::layout::FORMAT;
use serde_json::{Value, json};

/// Version of the previous format.
pub(super) const VERSION: u32 = 2;

/// Names of flags in the previous format, and in this format.
const WORDS: [(&str, &str); 5] = [
    ("material", "physical"),
    ("kernel", "numerical"),
    ("rank-deficient", "zero-energy"),
    ("missed", "suppressed"),
    ("proved-rank-deficient", "proved-zero-energy"),
];

/// Returns true if the metadata of a store have the previous format.
pub(super) fn is_of(group: &Value) -> bool {
    group["attributes"][FORMAT] == VERSION
}

/// Metadata of the arrays of a store, for comparison with a layout: flags with the names of this format, without long names.
pub(super) fn arrays(group: &Value) -> Value {
    let mut arrays = group["consolidated_metadata"].clone();
    let metadata = arrays.get_mut("metadata").and_then(Value::as_object_mut);
    for array in metadata.into_iter().flat_map(|arrays| arrays.values_mut()) {
        let Some(attributes) = array.get_mut("attributes").and_then(Value::as_object_mut) else {
            continue;
        };
        attributes.remove("long_name");
        if let Some(words) = attributes.get_mut("flag_meanings") {
            *words = json!(in_words(words.as_str().unwrap_or_default()));
        }
    }
    arrays
}

fn in_words(meanings: &str) -> String {
    let now = |word: &str| {
        let mut words = WORDS.iter();
        let found = words.find(|(earlier, _)| *earlier == word);
        found.map_or(word.to_owned(), |(_, now)| (*now).to_owned())
    };
    meanings.split(' ').map(now).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn former_flags_are_read_under_present_names() {
        let earlier = "stable material rank-deficient kernel missed undefined";
        let now = "stable physical zero-energy numerical suppressed undefined";
        assert_eq!(in_words(earlier), now);
        assert_eq!(in_words(now), now);
    }
}
