//! Verdicts that end a command with exit code 3, for continuous integration.

use crate::printing::tell;
use onset_study::Verdict;
use onset_study::settings::{did_you_mean, verdict_named};
use std::process::ExitCode;

/// Exit code for a verdict in `--fail-on`.
pub const CODE: u8 = 3;

/// Name of states where the method cannot be evaluated.
const UNDEFINED: &str = "undefined";

/// Names of groups of verdicts.
const GROUPS: [(&str, &[Verdict]); 3] = [
    ("unstable", &[Verdict::Physical, Verdict::Numerical]),
    (
        "unfaithful",
        &[Verdict::ZeroEnergy, Verdict::Numerical, Verdict::Suppressed],
    ),
    (
        "any",
        &[
            Verdict::Physical,
            Verdict::ZeroEnergy,
            Verdict::Numerical,
            Verdict::Suppressed,
        ],
    ),
];

/// Names of verdicts and groups.
pub fn names() -> impl Iterator<Item = &'static str> {
    let groups = GROUPS.iter().map(|(name, _)| *name);
    Verdict::ALL
        .into_iter()
        .map(Verdict::name)
        .chain([UNDEFINED])
        .chain(groups)
}

/// Verdicts for which a command fails.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FailOn(Vec<&'static str>);

impl FailOn {
    /// Parses names of verdicts and groups, separated by commas.
    ///
    /// # Errors
    /// The expected names, for an unknown one.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut names = Vec::new();
        for word in text.split(',').map(|word| verdict_named(word.trim())) {
            let verdict = Verdict::ALL
                .into_iter()
                .find(|verdict| verdict.name() == word);
            let group = GROUPS.iter().find(|(name, _)| *name == word);
            match (verdict, group) {
                (Some(verdict), _) => names.push(verdict.name()),
                (None, Some((_, verdicts))) => names.extend(verdicts.iter().map(|own| own.name())),
                (None, None) if word == UNDEFINED => names.push(UNDEFINED),
                (None, None) => {
                    let verdicts = Verdict::ALL.map(Verdict::name);
                    let groups: Vec<&str> = GROUPS.iter().map(|(name, _)| *name).collect();
                    let known = verdicts.iter().chain(&groups).copied();
                    let meant = did_you_mean(word, known.chain([UNDEFINED]));
                    return Err(format!(
                        "`{word}` is not a verdict; expected some of {}, {UNDEFINED}, or {}, separated by commas{meant}",
                        verdicts.join(", "),
                        groups.join(", ")
                    ));
                }
            }
        }
        Ok(Self(names))
    }

    /// Returns true if the list includes states where the method cannot be evaluated.
    pub fn has_undefined(&self) -> bool {
        self.0.contains(&UNDEFINED)
    }

    /// Exit code for the given verdicts with their numbers of states; states without a name are undefined.
    pub fn code<'v>(&self, found: impl IntoIterator<Item = (Option<&'v str>, u64)>) -> ExitCode {
        let mut counts: Vec<(&str, u64)> = Vec::new();
        for (name, states) in found {
            let name = name.unwrap_or(UNDEFINED);
            match counts.iter_mut().find(|(known, _)| *known == name) {
                Some((_, count)) => *count += states,
                None => counts.push((name, states)),
            }
        }
        let hit = counts
            .into_iter()
            .find(|(name, states)| *states > 0 && self.0.contains(name));
        match hit {
            Some((name, states)) => {
                tell(format_args!(
                    "fails by --fail-on: {states} state{} {name} (exit code {CODE})",
                    if states == 1 { " is" } else { "s are" }
                ));
                ExitCode::from(CODE)
            }
            None => ExitCode::SUCCESS,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::FailOn;

    #[test]
    fn groups_expand_to_verdicts_and_unknown_names_are_refused() {
        assert_eq!(
            FailOn::parse("numerical, suppressed"),
            Ok(FailOn(vec!["numerical", "suppressed"]))
        );
        assert_eq!(
            FailOn::parse("unstable"),
            Ok(FailOn(vec!["physical", "numerical"]))
        );
        assert_eq!(
            FailOn::parse("zero-energy,undefined"),
            Ok(FailOn(vec!["zero-energy", "undefined"]))
        );
        assert!(FailOn::parse("broken").is_err_and(|told| told.contains("zero-energy")));
        assert!(FailOn::parse("").is_err());
        assert!(
            FailOn::parse("numeric").is_err_and(|told| told.ends_with("did you mean `numerical`?"))
        );
    }
}
