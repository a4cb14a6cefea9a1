//! Criteria as text: the table of the console, and the sentences on disagreements.

use super::{CriteriaAnswer, CriterionAnswer, LoadingAnswer, SideAnswer, told};
use crate::number;
use crate::settings::is_of_an_absent_term;
use onset::criteria::{Change, Criterion, Knowledge, Witness};
use std::fmt::{Display, Formatter, Result};

/// Largest relative difference of two limits that are considered equal.
const LIMIT_TOLERANCE: f64 = 1e-6;

impl Display for CriteriaAnswer {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        writeln!(formatter, "{}", opening(&self.material))?;
        let [low, high] = self.range;
        let shear = self
            .range_of_shear()
            .map_or_else(String::new, |[low, high]| {
                format!(" In simple shear, gamma = F12 from {low} to {high}.")
            });
        writeln!(formatter, "Stretches from {low} to {high}.{shear}")?;
        writeln!(formatter, "{}", polyconvexity(&self.polyconvexity))?;
        for loading in &self.loadings {
            writeln!(formatter, "\n{}", loading.title)?;
            let names = loading.criteria.iter();
            let names = names.map(|answer| answer.criterion.name().len());
            let width = names.max().unwrap_or(0);
            let [below, above] = super::sides(loading.mode);
            writeln!(
                formatter,
                "  {:<width$} {below:>16} {above:>16}   at the loss",
                ""
            )?;
            for answer in &loading.criteria {
                writeln!(
                    formatter,
                    "  {:<width$} {:>16} {:>16}   {}",
                    answer.criterion.name(),
                    cell(loading, answer, Side::Below, number::DIGITS),
                    cell(loading, answer, Side::Above, number::DIGITS),
                    witnesses(loading, answer)
                )?;
            }
            for kink in &loading.kinks {
                writeln!(formatter, "  {}", super::kink(kink, loading.mode))?;
            }
            for (name, end) in [
                (below, &loading.compression_end),
                (above, &loading.tension_end),
            ] {
                if let Some(line) = end.line(loading.mode, name) {
                    writeln!(formatter, "  {line}")?;
                }
            }
            if let Some(other) = loading.other_states.first() {
                let f = &other.deformation_gradient;
                writeln!(
                    formatter,
                    "  not the only state: at {} the faces are also free of traction with F = diag({}, {}, {})",
                    super::told_place(loading.mode, other.imposed),
                    number::told(f[0][0]),
                    number::told(f[1][1]),
                    number::told(f[2][2])
                )?;
            }
        }
        writeln!(formatter, "\n{}", self.evidence)?;
        for definition in &self.criteria {
            let limits = self.loadings.iter().flat_map(|loading| &loading.criteria);
            let mut own = limits.filter(|answer| answer.criterion == definition.criterion);
            if let Some(note) = definition.note
                && own.any(|answer| answer.has_limit())
            {
                writeln!(formatter, "\n{}: {note}.", definition.criterion.name())?;
            }
        }
        if !self.disagreements.is_empty() {
            writeln!(formatter, "\nWhere criteria disagree")?;
        }
        for sentence in &self.disagreements {
            writeln!(formatter, "- {sentence}")?;
        }
        Ok(())
    }
}

/// Maximum length of a user-defined energy in a title, in characters.
const LETTERS: usize = 60;

/// Name and parameters of the law, in one line.
pub(super) fn heading(law: &super::LawAnswer) -> String {
    in_a_line(law, usize::MAX)
}

/// Name and parameters of the law, with a long energy abbreviated.
pub(super) fn title(law: &super::LawAnswer) -> String {
    in_a_line(law, LETTERS)
}

fn in_a_line(law: &super::LawAnswer, letters: usize) -> String {
    // A custom name replaces the energy or table.
    let told = |(name, _): &&(String, serde_json::Value)| {
        let is_named = law.name.is_some() && ["energy", "table"].contains(&name.as_str());
        let number = |own: &str| {
            let mut known = law.parameters.iter().filter(|(other, _)| other == own);
            known.next()?.1.as_f64()
        };
        !is_named && !is_of_an_absent_term(name, number)
    };
    let parameters: Vec<String> = law
        .parameters
        .iter()
        .filter(told)
        .map(|(name, value)| match value.as_f64() {
            Some(value) => match law.units.get(name) {
                Some(unit) => format!("{name} = {} {unit}", number::told(value)),
                None => format!("{name} = {}", number::told(value)),
            },
            None => match value.as_str() {
                Some(text) if text.chars().count() > letters => {
                    let begin: String = text.chars().take(letters).collect();
                    format!("{name} = \"{} ...\"", begin.trim_end())
                }
                _ => format!("{name} = {value}"),
            },
        })
        .collect();
    let symmetry = match (law.isotropic, law.incompressible) {
        (true, true) => {
            "isotropic, incompressible: the pressure follows from a traction-free face; the volumetric part has no influence"
        }
        _ if law.in_plane => "a two-dimensional law: increments are in-plane",
        (true, false) => "isotropic",
        (false, _) => "not isotropic",
    };
    let name = law.name.as_ref().unwrap_or(&law.model);
    format!("{name} ({}), {symmetry}", parameters.join(", "))
}

/// Heading of the answer, with moduli and notes.
pub(super) fn opening(law: &super::LawAnswer) -> String {
    let moduli = moduli(law).map_or(String::new(), |moduli| {
        format!("\nAt small strains: {moduli}.")
    });
    format!("{}.{moduli}{}", heading(law), told(&law.notes))
}

/// Moduli at small strains; `None` if the law is not isotropic or has stress at `F = 1`.
pub(super) fn moduli(law: &super::LawAnswer) -> Option<String> {
    let pascal = law.units.values().find(|unit| **unit == "Pa");
    let unit = pascal.map_or(String::new(), |unit| format!(" {unit}"));
    let [shear, bulk] = law.moduli?.map(|modulus| number::told(modulus) + &unit);
    Some(match law.incompressible {
        true => format!("shear modulus {shear}"),
        false => format!("shear modulus {shear}, bulk modulus {bulk}"),
    })
}

/// Statement on polyconvexity, in one line.
pub(super) fn polyconvexity(known: &super::PolyconvexityAnswer) -> String {
    let word = match known.knowledge {
        Knowledge::Polyconvex => "yes",
        Knowledge::NotPolyconvex => "no",
        Knowledge::Unknown => "unknown",
    };
    match known.source.is_empty() {
        true => format!("Polyconvex: {word} ({}).", known.reason),
        false => format!("Polyconvex: {word} ({}; {}).", known.reason, known.source),
    }
}

/// Side of the reference configuration along a loading.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Side {
    /// Smaller imposed values: compression, or negative shear.
    Below,
    /// Larger imposed values: tension, or positive shear.
    Above,
}

impl Side {
    pub(super) fn of(self, answer: &CriterionAnswer) -> &SideAnswer {
        match self {
            Self::Below => &answer.compression,
            Self::Above => &answer.tension,
        }
    }
}

pub(super) fn cell(
    loading: &LoadingAnswer,
    answer: &CriterionAnswer,
    side: Side,
    digits: usize,
) -> String {
    let (at, side) = (side, side.of(answer));
    match side.limit {
        _ if !answer.defined => "not defined".to_owned(),
        None => "never".to_owned(),
        Some(_) if !answer.holds_in_reference => "at F = 1".to_owned(),
        Some(limit) if limit == loading.reference() => "at once".to_owned(),
        Some(limit) => {
            let again = side
                .changes
                .iter()
                .any(|change| change.change == Change::Regained);
            let bound = match (side.upper_bound, at) {
                (false, _) => "",
                (true, Side::Below) => "≥ ",
                (true, Side::Above) => "≤ ",
            };
            format!(
                "{bound}{}{}",
                number::told_with(limit, digits),
                if again { "*" } else { "" }
            )
        }
    }
}

/// Perturbation at the loss in tension, or in compression if there is no loss in tension.
fn witnesses(loading: &LoadingAnswer, answer: &CriterionAnswer) -> String {
    let first = |side: &SideAnswer| side.changes.first().map(|change| witness(&change.witness));
    let mut text = first(&answer.tension)
        .or_else(|| first(&answer.compression))
        .unwrap_or_default();
    let of_sides = super::sides(loading.mode)
        .into_iter()
        .zip([&answer.compression, &answer.tension]);
    for (name, side) in of_sides {
        for change in &side.changes {
            if change.change == Change::Regained {
                let place = number::told(change.imposed);
                text.push_str(&format!("; *again in {name} at {place}"));
            }
        }
    }
    text
}

/// Describes a perturbation in a few words.
pub(super) fn witness(witness: &Witness) -> String {
    match witness {
        Witness::Wave {
            direction,
            polarization,
        } => format!("N = {}, g = {}", vector(direction), vector(polarization)),
        Witness::DeformationRate { rate } => format!("Fdot = {}", matrix(rate)),
        Witness::StrainRate { rate } => format!("D = {}", matrix(rate)),
        Witness::SurfaceWave { normal, direction } => {
            format!("face {}, wave along {}", vector(normal), vector(direction))
        }
        Witness::Jump {
            amplitude,
            direction,
            at_edge,
            collapses,
            verified,
        } => {
            let edge = match (at_edge, collapses) {
                (true, _) => "; ends at the largest stretch of the range",
                (false, true) => "; ends at the limit of zero volume",
                (false, false) => "",
            };
            let sure = if *verified {
                "lowers the energy, verified in interval arithmetic"
            } else {
                "lowers the energy in floating point; not verified in interval arithmetic"
            };
            format!(
                "a = {}, N = {} ({sure}{edge})",
                vector(amplitude),
                vector(direction)
            )
        }
    }
}

fn vector(components: &[f64; 3]) -> String {
    format!("({})", components.map(|x| component(x, 4)).join(", "))
}

fn matrix(rows: &[[f64; 3]; 3]) -> String {
    format!(
        "[{}]",
        rows.map(|row| row.map(|x| component(x, 2)).join(" "))
            .join("; ")
    )
}

fn component(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    match text.trim_start_matches(['-', '0', '.']).is_empty() {
        true => "0".to_owned(),
        false => text,
    }
}

/// Sentences on how each criterion disagrees with strong ellipticity.
pub(super) fn disagreements(loadings: &[LoadingAnswer]) -> Vec<String> {
    let mut sentences = Vec::new();
    for criterion in Criterion::ALL {
        let (mut sooner, mut later) = (Vec::new(), Vec::new());
        for loading in loadings {
            for tension in [true, false] {
                match comparison(loading, criterion, tension) {
                    Some(Comparison::Sooner(text)) => sooner.push(text),
                    Some(Comparison::Later(text)) => later.push(text),
                    None => {}
                }
            }
        }
        let title = capitalized(criterion.title());
        if !sooner.is_empty() {
            let list = sooner.join("; ");
            sentences.push(match criterion {
                Criterion::LoadMaximum => {
                    format!("The load falls while strong ellipticity holds: {list}.")
                }
                Criterion::RankOneConvexity => {
                    format!("Finite jumps lower the energy while strong ellipticity holds: {list}.")
                }
                _ => format!("{title} is lost while strong ellipticity holds: {list}."),
            });
        }
        // A criterion implied by strong ellipticity necessarily outlasts it; this is not a disagreement.
        let is_implied = criterion == Criterion::BakerEricksen;
        if !later.is_empty() && !is_implied {
            let list = later.join("; ");
            sentences.push(match criterion {
                Criterion::PlaneEllipticity => {
                    format!("Ellipticity is lost for out-of-plane perturbations before in-plane ones: {list}.")
                }
                Criterion::LoadMaximum => {
                    format!("The load still rises where ellipticity is lost: {list}.")
                }
                _ => format!("{title} still holds where ellipticity is lost: {list}."),
            });
        }
    }
    let hill = |loading: &&LoadingAnswer| {
        let found = loading
            .criteria
            .iter()
            .find(|answer| answer.criterion == Criterion::Hill);
        found.is_some_and(|hill| hill.compression.limit == Some(loading.reference()))
    };
    if loadings.iter().any(|loading| hill(&loading)) {
        sentences.push(
            "Hill's criterion for dead loads is lost with the first compression: under dead pressure, rotations of the body \
             lower the energy for any law. For increments without rotation the line `hill-rotation-free` counts."
                .to_owned(),
        );
    }
    sentences
}

/// Outcome of comparing a criterion with strong ellipticity in a loading, as the text to print.
enum Comparison {
    Sooner(String),
    Later(String),
}

fn comparison(loading: &LoadingAnswer, criterion: Criterion, tension: bool) -> Option<Comparison> {
    let side = |criterion: Criterion| {
        let found = loading
            .criteria
            .iter()
            .find(|answer| answer.criterion == criterion && answer.defined)?;
        Some(match tension {
            true => &found.tension,
            false => &found.compression,
        })
    };
    let (side, waves) = (side(criterion)?, side(Criterion::StrongEllipticity)?.limit);
    let own = side.limit;
    let distance =
        |limit: Option<f64>| limit.map_or(f64::INFINITY, |limit| loading.distance(limit));
    let (near, far) = (distance(own), distance(waves));
    let what = format!(
        "{}, {}",
        loading.title,
        super::sides(loading.mode)[usize::from(tension)]
    );
    let until = |limit: Option<f64>| {
        limit.map_or("throughout".to_owned(), |limit| {
            format!("to {}", number::told(limit))
        })
    };
    match own {
        Some(own) if criterion == Criterion::Hill && own == loading.reference() => None,
        Some(own) if near < far * (1.0 - LIMIT_TOLERANCE) => Some(Comparison::Sooner(format!(
            "{what} from {} (waves {})",
            number::told(own),
            until(waves)
        ))),
        // An upper bound: the criterion may be lost earlier.
        Some(_) if side.upper_bound => None,
        _ => {
            let waves = waves.filter(|_| near > far * (1.0 + LIMIT_TOLERANCE))?;
            Some(Comparison::Later(format!(
                "{what} from {} ({})",
                number::told(waves),
                match own {
                    Some(own) => format!("lost at {}", number::told(own)),
                    None => "never lost".to_owned(),
                }
            )))
        }
    }
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}
