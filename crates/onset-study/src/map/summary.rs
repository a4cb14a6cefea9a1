//! Summary of a run, as text and numbers.

use super::fields::verdicts;
use super::proved::Proofs;
pub use super::proved::Proved;
use super::record::{Outcomes, Proof};
use crate::answers::{Evidence, note_on_mapped_body};
use crate::csv::Table;
use crate::number::counted;
use crate::settings::{Study, Units};
use onset::verdict::Verdict;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Add;
use std::time::Duration;

/// Counts of states and tiles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    verdicts: [u64; Verdict::ALL.len() + 1],
    evaluated: u64,
    /// Counts of proved states.
    pub(super) proofs: Proofs,
    /// Number of states computed by this run.
    fresh: u64,
    /// Number of tiles that were already finished.
    pub(super) found: usize,
    /// Number of tiles computed by this run.
    pub(super) computed: usize,
}

impl Tally {
    /// Counts of a tile computed by this run.
    pub(super) fn computed(outcomes: &Outcomes) -> Self {
        let Outcomes { findings, computed } = outcomes;
        let states = computed.len() as u64;
        let mut tally = Self {
            computed: 1,
            evaluated: states,
            fresh: states,
            ..Self::default()
        };
        for run in findings.chunk_by(PartialEq::eq) {
            let verdict = run[0].verdict;
            let number = Verdict::ALL.iter().position(|v| Some(*v) == verdict);
            // The last counter is for undefined states.
            tally.verdicts[number.unwrap_or(Verdict::ALL.len())] += run.len() as u64;
        }
        for (_, record) in computed {
            tally.proofs.count(&record.proof, 1);
        }
        let others = findings.len() as u64 - states;
        tally.proofs.count(&Proof::NONE, others);
        tally
    }

    pub(super) fn count_verdicts(&mut self, flags: &[i8]) {
        for flag in flags {
            if let Some(count) = usize::try_from(*flag)
                .ok()
                .and_then(|index| self.verdicts.get_mut(index))
            {
                *count += 1;
            }
        }
    }

    pub(super) fn count_evaluated(&mut self, flags: &[i8]) {
        self.evaluated += flags.iter().filter(|flag| **flag == 1).count() as u64;
    }
}

impl Add for Tally {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            verdicts: std::array::from_fn(|i| self.verdicts[i] + other.verdicts[i]),
            evaluated: self.evaluated + other.evaluated,
            proofs: self.proofs + other.proofs,
            fresh: self.fresh + other.fresh,
            found: self.found + other.found,
            computed: self.computed + other.computed,
        }
    }
}

/// Number and fraction of the states with one verdict.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Number of states with this verdict.
    pub states: u64,
    /// Fraction of all states of the run.
    pub share: f64,
}

/// Results of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Title of the study.
    pub title: String,
    /// Number of states in the finished tiles of this run.
    pub states: u64,
    /// Number of states computed by this run or earlier; the verdicts of all other states are filled in from neighboring states.
    pub evaluated: u64,
    /// Number of states by verdict, over the tiles of this run.
    pub verdicts: BTreeMap<&'static str, Share>,
    /// Proved states; `null` if no proofs were requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proofs: Option<Proved>,
    /// Number of states by evidence: `proved` if certified, `searched` otherwise.
    pub evidence: BTreeMap<&'static str, Share>,
    /// Number of tiles computed by this run.
    pub tiles_computed: usize,
    /// Number of tiles that were finished before, or by another process during the run.
    pub tiles_found: usize,
    /// Number of finished tiles in the store.
    pub tiles_done: usize,
    /// Number of all tiles of the store.
    pub tiles: usize,
    /// Duration of the run; seconds.
    pub seconds: f64,
    /// States computed by this run per second.
    pub states_per_second: f64,
    /// Notes on the map.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

impl Summary {
    /// The verdicts as CSV, one row for each.
    pub fn csv(&self) -> String {
        let verdicts: Vec<_> = self.verdicts.iter().collect();
        Table::new(&verdicts, Units::Own)
            .with("verdict", "1", |(name, _)| **name)
            .with("states", "1", |(_, own)| own.states)
            .with("share", "1", |(_, own)| own.share)
            .to_string()
    }

    pub(super) fn new(
        study: &Study,
        tally: Tally,
        tiles_done: usize,
        tiles: usize,
        elapsed: Duration,
    ) -> Self {
        let states: u64 = tally.verdicts.iter().sum();
        let share = |count: u64| Share {
            states: count,
            share: count as f64 / states.max(1) as f64,
        };
        let seconds = elapsed.as_secs_f64();
        let proved = match study.map.certify {
            true => tally.proofs.decided().min(states),
            false => 0,
        };
        let evidence = [
            (Evidence::Proved, proved),
            (Evidence::Searched, states - proved),
        ];
        Self {
            title: study.title.clone(),
            states,
            evaluated: tally.evaluated,
            verdicts: verdicts()
                .into_iter()
                .zip(tally.verdicts.map(share))
                .collect(),
            proofs: study.map.certify.then(|| tally.proofs.shares(states)),
            evidence: evidence
                .into_iter()
                .filter(|(_, states)| *states > 0)
                .map(|(evidence, states)| (evidence.name(), share(states)))
                .collect(),
            tiles_computed: tally.computed,
            tiles_found: tally.found,
            tiles_done,
            tiles,
            seconds,
            states_per_second: tally.fresh as f64 / seconds.max(f64::MIN_POSITIVE),
            notes: note_on_mapped_body(study).into_iter().collect(),
        }
    }

    /// Returns true if all tiles of the store are finished.
    pub fn is_complete(&self) -> bool {
        self.tiles_done == self.tiles
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.title.is_empty() {
            writeln!(formatter, "{}", self.title)?;
        }
        for name in verdicts() {
            if let Some(Share { states, share }) = self.verdicts.get(name)
                && *states > 0
            {
                writeln!(
                    formatter,
                    "  {name:<14} {states:>10}  {:5.1} %",
                    100.0 * share
                )?;
            }
        }
        writeln!(
            formatter,
            "{} states{}, {} of them computed ({:.1} %)",
            self.states,
            if self.is_complete() {
                ""
            } else {
                " in the completed tiles"
            },
            self.evaluated,
            100.0 * self.evaluated as f64 / self.states.max(1) as f64
        )?;
        let evidence = self.evidence.iter();
        let evidence = evidence.map(|(name, share)| format!("{name} {}", share.states));
        writeln!(
            formatter,
            "{:<24}{}",
            "evidence",
            evidence.collect::<Vec<_>>().join(", ")
        )?;
        if let Some(proofs) = &self.proofs {
            write!(formatter, "{proofs}")?;
        }
        let found = match self.tiles_found {
            0 => String::new(),
            count => format!("; {count} were done already"),
        };
        if self.tiles_computed == 0 {
            write!(formatter, "nothing to compute{found}")?;
        } else {
            write!(
                formatter,
                "{} in {:.1} s, {:.0} states/s{found}",
                counted(self.tiles_computed, "tile"),
                self.seconds,
                self.states_per_second
            )?;
        }
        if !self.is_complete() {
            let left = self.tiles - self.tiles_done;
            write!(
                formatter,
                "\n{left} of {} tiles remain to be computed",
                self.tiles
            )?;
        }
        self.notes
            .iter()
            .try_for_each(|note| write!(formatter, "\nnote: {note}"))
    }
}
