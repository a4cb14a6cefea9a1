//! Proofs about a state, as text and numbers.

use super::state::list;
use crate::number::{told, vector};
use onset::certificate::{Certainty, Certificate, Reason, SpaceCertificate, Witness};
use serde::Serialize;
use std::fmt;

/// Proofs about material and discretization.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CertificateAnswer {
    /// Distance from zero within which an undecided measure is reported as near zero.
    pub tolerance: f64,
    /// Whether the verdict differs from the verdict of the search.
    pub corrects_the_search: bool,
    /// Proof of strong ellipticity; the measures are acoustic eigenvalues divided by `rho0 c^2`.
    pub material: ProofAnswer,
    /// Proof of strong ellipticity in 3D; the measures are acoustic eigenvalues divided by the largest acoustic eigenvalue of the reference configuration. `None` for a
    /// sheet or bar in plane stress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material_3d: Option<ProofAnswer>,
    /// Proof for the waves of the discretization; the measures are `Re omega^2 / (c^2 |k|_h^2)`.
    pub discretization: ProofAnswer,
}

/// Result of a proof: stable, unstable or undecided, with the evidence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProofAnswer {
    /// `proved-stable`, `proved-zero-energy`, `proved-unstable` or `undecided`.
    pub certainty: &'static str,
    /// If stable: lower bound of the measure for all directions or wave vectors.
    pub bound: Option<f64>,
    /// If unstable: a growing wave.
    pub witness: Option<WitnessAnswer>,
    /// If the method has zero-energy modes: reference wave vector of one such mode; 1/length.
    pub zero_energy_wave_vector: Option<Vec<f64>>,
    /// If undecided: the reason.
    pub reason: Option<&'static str>,
    /// If undecided: the smallest measure that was found.
    pub smallest_seen: Option<f64>,
}

/// Wave that is proved to grow.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WitnessAnswer {
    /// Reference wave vector, 1/length; for the material, the unit vector of the direction.
    pub wave_vector: Vec<f64>,
    /// Lower and upper bound of the measure.
    pub measure: [f64; 2],
    /// Polarization that confirms the direction in 3D; `null` in one and two dimensions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polarization: Option<Vec<f64>>,
    /// Lower bound of the growth rate, in units of sound speed over spacing; for the material, in units of sound speed times wave number.
    pub growth_rate: f64,
}

impl CertificateAnswer {
    /// Vectors are cut to `dimension` components.
    pub(super) fn new(
        dimension: usize,
        certificate: &Certificate<3>,
        in_3d: Option<&SpaceCertificate>,
        tolerance: f64,
        corrects_the_search: bool,
    ) -> Self {
        Self {
            tolerance,
            corrects_the_search,
            material: ProofAnswer::new(dimension, &certificate.material),
            material_3d: in_3d.map(ProofAnswer::in_3d),
            discretization: ProofAnswer::new(dimension, &certificate.discretization),
        }
    }
}

impl CertificateAnswer {
    /// Returns true if neither of the two proofs is undecided.
    pub(super) fn decides(&self) -> bool {
        [&self.material, &self.discretization]
            .iter()
            .all(|proof| proof.reason.is_none())
    }
}

impl ProofAnswer {
    fn new(dimension: usize, certainty: &Certainty<3>) -> Self {
        let nothing = Self {
            certainty: certainty.name(),
            bound: None,
            witness: None,
            zero_energy_wave_vector: None,
            reason: None,
            smallest_seen: None,
        };
        match certainty {
            Certainty::Stable { bound } => Self {
                bound: Some(*bound),
                ..nothing
            },
            Certainty::ZeroEnergy { wave_vector } => Self {
                zero_energy_wave_vector: Some(list(dimension, wave_vector)),
                ..nothing
            },
            Certainty::Unstable { witness } => Self {
                witness: Some(WitnessAnswer::new(dimension, witness)),
                ..nothing
            },
            Certainty::Undecided { measure, reason } => Self {
                reason: Some(reason.name()),
                smallest_seen: Some(*measure).filter(|measure| measure.is_finite()),
                ..nothing
            },
        }
    }

    fn in_3d(certificate: &SpaceCertificate) -> Self {
        let mut answer = Self::new(3, &certificate.certainty);
        if let Some(witness) = &mut answer.witness {
            witness.polarization = certificate.polarization.map(|g| list(3, &g));
        }
        answer
    }

    fn line(&self, wave: &str, rate: &str) -> String {
        let certainty = self.certainty;
        if let Some(bound) = self.bound {
            let bound = told(bound);
            format!("{certainty}: the measure is at least {bound} for every {wave}")
        } else if let Some(witness) = &self.witness {
            let [low, high] = witness.measure.map(told);
            format!(
                "{certainty}: the {wave} {} grows at a rate of at least {} {rate}; its measure is in [{low}, {high}]",
                vector(&witness.wave_vector),
                told(witness.growth_rate)
            )
        } else if let Some(wave_vector) = &self.zero_energy_wave_vector {
            format!(
                "{certainty}: all omega^2 >= 0; the {wave} {} is a zero-energy mode",
                vector(wave_vector)
            )
        } else {
            let reason = self.reason.unwrap_or("no reason");
            if reason == Reason::Method.name() {
                return format!(
                    "{certainty} ({reason}): the waves of this method are searched, without a proof"
                );
            }
            match self.smallest_seen {
                Some(seen) => {
                    format!(
                        "{certainty} ({reason}); the smallest measure found is {}",
                        told(seen)
                    )
                }
                None => format!("{certainty} ({reason})"),
            }
        }
    }
}

impl WitnessAnswer {
    fn new(dimension: usize, witness: &Witness<3>) -> Self {
        Self {
            wave_vector: list(dimension, &witness.wave_vector),
            measure: [witness.measure.low, witness.measure.high],
            polarization: None,
            growth_rate: witness.growth_rate,
        }
    }
}

impl CertificateAnswer {
    /// Proofs for the material, for the material in 3D and for the discretization.
    fn lines(&self) -> impl Iterator<Item = (&'static str, String)> {
        let rows = [
            ("material", Some(&self.material), ["direction", "c |k|"]),
            (
                "material in 3D",
                self.material_3d.as_ref(),
                ["direction", "c |k|"],
            ),
            (
                "discretization",
                Some(&self.discretization),
                ["wave vector", "c/h"],
            ),
        ];
        rows.into_iter()
            .filter_map(|(name, proved, [wave, rate])| Some((name, proved?.line(wave, rate))))
    }

    /// Rows of the short answer.
    pub(super) fn short(&self) -> impl Iterator<Item = (&'static str, String)> {
        self.lines().enumerate().map(|(n, (name, line))| {
            let row = if n == 0 { "proofs" } else { "" };
            (row, format!("{name} {line}"))
        })
    }
}

impl fmt::Display for CertificateAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "proofs")?;
        for (name, line) in self.lines() {
            write!(formatter, "\n  {name:<22}{line}")?;
        }
        Ok(())
    }
}
