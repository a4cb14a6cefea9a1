//! Counts of proved states in a map.

use super::record::{Certainty, Proof};
use super::summary::Share;
use crate::number::counted;
use onset::certificate::Reason;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Add;

/// Counts of states by certainty, reason and correction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Proofs {
    certainties: [u64; Certainty::ALL.len()],
    reasons: [u64; Reason::ALL.len()],
    corrected: u64,
}

impl Proofs {
    /// Adds a number of states with the given proof.
    pub(super) fn count(&mut self, proof: &Proof, states: u64) {
        let add = |counts: &mut [u64], place: Option<usize>| {
            if let Some(count) = place.and_then(|place| counts.get_mut(place)) {
                *count += states;
            }
        };
        let certainty = |other: &Certainty| *other == proof.particles;
        add(
            &mut self.certainties,
            Certainty::ALL.iter().position(certainty),
        );
        let reason = |other: &Reason| Some(*other) == proof.reason;
        add(&mut self.reasons, Reason::ALL.iter().position(reason));
        self.corrected += states * u64::from(proof.corrects);
    }

    /// Number of states whose verdict on the particles is proved.
    pub(super) fn decided(&self) -> u64 {
        let own = Certainty::ALL.iter().zip(self.certainties);
        let decided = own.filter(|(certainty, _)| certainty.name().starts_with("proved"));
        decided.map(|(_, states)| states).sum()
    }

    pub(super) fn count_certainties(&mut self, flags: &[i8]) {
        count(&mut self.certainties, flags, 0);
    }

    /// Counts reasons; flag 0 means that no reason applies.
    pub(super) fn count_reasons(&mut self, flags: &[i8]) {
        count(&mut self.reasons, flags, 1);
    }

    pub(super) fn count_corrected(&mut self, flags: &[i8]) {
        self.corrected += flags.iter().filter(|flag| **flag == 1).count() as u64;
    }

    pub(super) fn shares(&self, states: u64) -> Proved {
        let share = |count: &u64| Share {
            states: *count,
            share: *count as f64 / states.max(1) as f64,
        };
        Proved {
            certainty: Certainty::ALL
                .map(Certainty::name)
                .into_iter()
                .zip(self.certainties.iter().map(share))
                .collect(),
            undecided: Reason::ALL
                .map(Reason::name)
                .into_iter()
                .zip(self.reasons.iter().map(share))
                .filter(|(_, share)| share.states > 0)
                .collect(),
            corrected: self.corrected,
        }
    }
}

/// Counts flags; flags below `first` are ignored.
fn count(counts: &mut [u64], flags: &[i8], first: i8) {
    for flag in flags {
        let place = usize::try_from(i16::from(*flag) - i16::from(first));
        if let Some(count) = place.ok().and_then(|place| counts.get_mut(place)) {
            *count += 1;
        }
    }
}

impl Add for Proofs {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            certainties: std::array::from_fn(|i| self.certainties[i] + other.certainties[i]),
            reasons: std::array::from_fn(|i| self.reasons[i] + other.reasons[i]),
            corrected: self.corrected + other.corrected,
        }
    }
}

/// Numbers of proved states in the tiles of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Proved {
    /// Share of the states with each certainty about the waves of the particles, by the name of the certainty.
    pub certainty: BTreeMap<&'static str, Share>,
    /// Share of the states undecided for each reason, by the name of the reason.
    pub undecided: BTreeMap<&'static str, Share>,
    /// Number of states where the proof corrects the verdict or the stability found by the search.
    pub corrected: u64,
}

impl fmt::Display for Proved {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "proofs")?;
        let shown = |share: &&Share| share.states > 0;
        for name in Certainty::ALL.map(Certainty::name) {
            if let Some(Share { states, share }) = self.certainty.get(name).filter(shown) {
                let percent = 100.0 * share;
                writeln!(formatter, "  {name:<22} {states:>10}  {percent:6.2} %")?;
            }
        }
        for (reason, Share { states, share }) in &self.undecided {
            let percent = 100.0 * share;
            writeln!(formatter, "    {reason:<20} {states:>10}  {percent:6.2} %")?;
        }
        if self.corrected > 0 {
            writeln!(
                formatter,
                "  the proof has corrected the result of the search at {}",
                counted(self.corrected as usize, "state")
            )?;
        }
        Ok(())
    }
}
