//! Earlier names of keys, words, commands and topics. They are still read, with a note on the new name.

use super::notes::note;
use super::{Key, Value};

/// Keys: earlier name, present name.
const KEYS: &[(&str, &str)] = &[
    ("discretization.arrangement", "discretization.lattice"),
    ("map.integrator", "time.integrator"),
    ("compare.integrator", "time.integrator"),
];

/// Words of a key whose earlier name now belongs to another key: `lattice` used to set the particle positions in the current configuration.
const WORDS: &[(&str, &[&str], &str)] = &[(
    "discretization.lattice",
    &["convected", "regular"],
    "discretization.current-lattice",
)];

/// Commands: earlier name, present name.
const COMMANDS: &[(&str, &str)] = &[("notions", "criteria")];

/// Verdicts: earlier name, present name.
const VERDICTS: &[(&str, &str)] = &[
    ("material", "physical"),
    ("kernel", "numerical"),
    ("rank-deficient", "zero-energy"),
    ("missed", "suppressed"),
];

/// Topics of `onset list`: earlier name, present name.
const TOPICS: &[(&str, &str)] = &[("arrangements", "lattices")];

/// Present name of a key.
pub(super) fn key(name: &str) -> &str {
    match KEYS.iter().find(|(earlier, _)| *earlier == name) {
        Some((_, now)) => {
            note(format!("`{name}` is now called `{now}`"));
            now
        }
        None => name,
    }
}

/// Key for a word; a different key if an earlier key of the same name accepted the word.
pub(super) fn of_word(key: &'static Key, value: &Value) -> &'static Key {
    let Value::Word(word) = value else {
        return key;
    };
    let is_earlier = |(name, words, _): &&(&str, &[&str], &str)| {
        *name == key.name && words.contains(&word.as_str())
    };
    let now = WORDS.iter().find(is_earlier);
    match now.and_then(|(_, _, now)| Key::named(now)) {
        Some(now) => {
            note(format!(
                "`{} = {word}` is now written `{} = {word}`; `{}` is {}",
                key.name, now.name, key.name, key.meaning
            ));
            now
        }
        None => key,
    }
}

/// Returns the present name of a verdict.
pub fn verdict(name: &str) -> &str {
    match VERDICTS.iter().find(|(earlier, _)| *earlier == name) {
        Some((_, now)) => {
            note(format!("the verdict `{name}` is now called `{now}`"));
            now
        }
        None => name,
    }
}

/// Returns the present name of a command, or `None` if the name is not an earlier name.
pub fn renamed_command(name: &str) -> Option<&'static str> {
    let (_, now) = COMMANDS.iter().find(|(earlier, _)| *earlier == name)?;
    note(format!("`onset {name}` is now called `onset {now}`"));
    Some(now)
}

/// Present name of a topic of `onset list`.
pub(crate) fn topic(name: &str) -> &str {
    match TOPICS.iter().find(|(earlier, _)| *earlier == name) {
        Some((_, now)) => {
            note(format!("the topic `{name}` is now called `{now}`"));
            now
        }
        None => name,
    }
}

#[cfg(test)]
mod tests {
    use super::{KEYS, TOPICS, WORDS};
    use crate::settings::{Key, Settings, Study, study_keys};

    fn is_key(name: &str) -> bool {
        study_keys().any(|key| key.name == name)
    }

    #[test]
    fn former_names_are_not_in_use_and_their_replacements_exist() {
        for (earlier, now) in KEYS {
            assert!(!is_key(earlier) && is_key(now), "{earlier}, {now}");
        }
        for (earlier, words, now) in WORDS {
            let (here, there) = [earlier, now]
                .map(|name| Key::named(name).expect("a key").words())
                .into();
            assert!(words.iter().all(|word| !here.contains(word)), "{earlier}");
            assert!(words.iter().all(|word| there.contains(word)), "{now}");
        }
        for (earlier, now) in TOPICS {
            let is_topic = |name| {
                crate::catalog::topics()
                    .iter()
                    .any(|topic| topic.name == name)
            };
            assert!(!is_topic(*earlier) && is_topic(*now), "{earlier}, {now}");
        }
    }

    #[test]
    fn a_study_with_former_names_equals_the_study_with_present_names() {
        let axes = "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 2.0]\nstates = 4\n\
                    [[axes]]\nquantity = \"stretch-2\"\nrange = [0.5, 2.0]\nstates = 4\n";
        let earlier = format!(
            "[discretization]\nframe = \"eulerian\"\narrangement = \"square\"\nlattice = \"regular\"\n{axes}"
        );
        let now = format!(
            "[discretization]\nframe = \"eulerian\"\nlattice = \"square\"\ncurrent-lattice = \"regular\"\n{axes}"
        );
        let [earlier, now] = [earlier, now].map(|text| Study::parse("s.toml", &text));
        let (earlier, now) = (earlier.expect("a study"), now.expect("a study"));
        assert_eq!(earlier.document(), now.document());
        let set = [
            "discretization.arrangement=chain",
            "discretization.frame=eulerian",
            "discretization.lattice=regular",
        ];
        let now = [
            "discretization.lattice=chain",
            "discretization.frame=eulerian",
            "discretization.current-lattice=regular",
        ];
        let [set, now] =
            [set, now].map(|words| Settings::from_assignments(&words).expect("settings"));
        assert_eq!(set.discretization, now.discretization);
    }
}
