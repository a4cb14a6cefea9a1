//! Notions in words: a table for people, and where notions disagree.

use super::{LoadingAnswer, NotionAnswer, NotionsAnswer, SideAnswer};
use onset::notions::{Change, Knowledge, Notion, Witness};
use std::fmt::{Display, Formatter, Result};

/// Limits closer than this, relative, count as the same.
const SAME: f64 = 1e-6;

impl Display for NotionsAnswer {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        writeln!(formatter, "{}", heading(&self.material))?;
        let [low, high] = self.range;
        writeln!(formatter, "Stretches from {low} to {high}.")?;
        writeln!(formatter, "{}", polyconvexity(&self.polyconvexity))?;
        for loading in &self.loadings {
            writeln!(formatter, "\n{}", loading.title)?;
            writeln!(
                formatter,
                "  {:<20} {:>16} {:>16}   at the loss",
                "", "compression", "tension"
            )?;
            for answer in &loading.notions {
                writeln!(
                    formatter,
                    "  {:<20} {:>16} {:>16}   {}",
                    answer.notion.name(),
                    cell(answer, &answer.compression),
                    cell(answer, &answer.tension),
                    witnesses(answer)
                )?;
            }
            for (name, end) in [
                ("compression", &loading.compression_end),
                ("tension", &loading.tension_end),
            ] {
                if let Some(reason) = &end.reason {
                    writeln!(
                        formatter,
                        "  {name} ends at stretch {:.9}: {reason}",
                        end.stretch
                    )?;
                }
            }
            if let Some(other) = loading.other_states.first() {
                let f = &other.deformation_gradient;
                writeln!(
                    formatter,
                    "  not the only state: at stretch {:.6} the faces are also free of traction with F = diag({:.6}, {:.6}, {:.6})",
                    other.stretch, f[0][0], f[1][1], f[2][2]
                )?;
            }
        }
        if !self.disagreements.is_empty() {
            writeln!(formatter, "\nWhere notions disagree")?;
        }
        for sentence in &self.disagreements {
            writeln!(formatter, "- {sentence}")?;
        }
        Ok(())
    }
}

/// The law in a line.
pub(super) fn heading(law: &super::LawAnswer) -> String {
    let parameters: Vec<String> = law
        .parameters
        .iter()
        .map(|(name, value)| format!("{name} = {value}"))
        .collect();
    let symmetry = match law.isotropic {
        true => "isotropic",
        false => "not isotropic",
    };
    format!("{} ({}), {symmetry}.", law.model, parameters.join(", "))
}

/// What is known about polyconvexity, in a line.
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

fn cell(answer: &NotionAnswer, side: &SideAnswer) -> String {
    match side.limit {
        _ if !answer.defined => "not defined".to_owned(),
        None => "never".to_owned(),
        Some(_) if !answer.holds_in_reference => "in the reference".to_owned(),
        Some(1.0) => "at once".to_owned(),
        Some(limit) => {
            let again = side
                .changes
                .iter()
                .any(|change| change.change == Change::Regained);
            format!("{limit:.10}{}", if again { "*" } else { "" })
        }
    }
}

/// The perturbation at the loss in tension, or else in compression.
fn witnesses(answer: &NotionAnswer) -> String {
    let first = |side: &SideAnswer| side.changes.first().map(|change| witness(&change.witness));
    let mut text = first(&answer.tension)
        .or_else(|| first(&answer.compression))
        .unwrap_or_default();
    for (name, side) in [
        ("compression", &answer.compression),
        ("tension", &answer.tension),
    ] {
        for change in &side.changes {
            if change.change == Change::Regained {
                text.push_str(&format!("; *again in {name} at {:.10}", change.stretch));
            }
        }
    }
    text
}

/// A perturbation in a few words.
pub(super) fn witness(witness: &Witness) -> String {
    match witness {
        Witness::Wave {
            direction,
            polarization,
        } => format!("N = {}, g = {}", vector(direction), vector(polarization)),
        Witness::DeformationRate { rate } => format!("Fdot = {}", matrix(rate)),
        Witness::StrainRate { rate } => format!("D = {}", matrix(rate)),
        Witness::Jump {
            amplitude,
            direction,
        } => format!("a = {}, N = {}", vector(amplitude), vector(direction)),
    }
}

fn vector(components: &[f64; 3]) -> String {
    format!("({})", components.map(|x| number(x, 4)).join(", "))
}

fn matrix(rows: &[[f64; 3]; 3]) -> String {
    format!(
        "[{}]",
        rows.map(|row| row.map(|x| number(x, 2)).join(" "))
            .join("; ")
    )
}

fn number(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    match text.trim_start_matches(['-', '0', '.']).is_empty() {
        true => "0".to_owned(),
        false => text,
    }
}

/// Where the notions disagree with strong ellipticity, a sentence or two for each loading and side.
pub(super) fn disagreements(loadings: &[LoadingAnswer]) -> Vec<String> {
    let mut sentences = Vec::new();
    let mut at_once: Vec<&str> = Vec::new();
    for loading in loadings {
        for tension in [false, true] {
            sentences.extend(disagreement(loading, tension));
        }
        let hill = loading
            .notions
            .iter()
            .find(|answer| answer.notion == Notion::Hill);
        if hill.is_some_and(|hill| hill.compression.limit == Some(1.0)) {
            at_once.push(loading.title);
        }
    }
    if !at_once.is_empty() {
        sentences.push(format!(
            "Hill's condition for dead loads is lost with the first compression ({}): a body under dead pressure gains energy by a \
             rotation, whatever its law. With rotations held it is the line `pure-strain` that counts.",
            at_once.join("; ")
        ));
    }
    sentences
}

fn disagreement(loading: &LoadingAnswer, tension: bool) -> Vec<String> {
    let of = |answer: &NotionAnswer| {
        let side = if tension {
            &answer.tension
        } else {
            &answer.compression
        };
        side.limit.map(|limit| limit.ln().abs())
    };
    let Some(elliptic) = loading
        .notions
        .iter()
        .find(|answer| answer.notion == Notion::StrongEllipticity)
    else {
        return Vec::new();
    };
    let waves = of(elliptic);
    let end = if tension {
        &loading.tension_end
    } else {
        &loading.compression_end
    };
    let what = if tension { "tension" } else { "compression" };
    let (mut sooner, mut later) = (Vec::new(), Vec::new());
    for answer in &loading.notions {
        if answer.notion == Notion::StrongEllipticity || !answer.defined {
            continue;
        }
        let own = of(answer);
        let stretch = |s: f64| if tension { s.exp() } else { (-s).exp() };
        match (own, waves) {
            // What is lost in the reference or at once needs no comparison of stretches; see the closing sentence on Hill.
            (Some(own), _) if own == 0.0 && answer.notion == Notion::Hill => {}
            (Some(own), Some(waves)) if own < waves * (1.0 - SAME) => {
                sooner.push(format!(
                    "{} from {:.6}",
                    answer.notion.title(),
                    stretch(own)
                ));
            }
            (Some(own), None) => {
                sooner.push(format!(
                    "{} from {:.6}",
                    answer.notion.title(),
                    stretch(own)
                ));
            }
            (Some(own), Some(waves)) if own > waves * (1.0 + SAME) => {
                later.push(format!(
                    "{} up to {:.6}",
                    answer.notion.title(),
                    stretch(own)
                ));
            }
            (None, Some(_)) => later.push(format!("{} throughout", answer.notion.title())),
            _ => {}
        }
    }
    let travel = match waves {
        Some(waves) => format!(
            "waves travel up to {:.6}",
            if tension { waves.exp() } else { (-waves).exp() }
        ),
        None => format!("waves travel throughout, to {:.6}", end.stretch),
    };
    let mut sentences = Vec::new();
    if !sooner.is_empty() {
        sentences.push(format!(
            "{}: {what} counts as unstable for {}, although {travel}.",
            loading.title,
            sooner.join(", for ")
        ));
    }
    if !later.is_empty() {
        let limit = waves.map_or(
            1.0,
            |waves| if tension { waves.exp() } else { (-waves).exp() },
        );
        sentences.push(format!(
            "{}: in {what} waves stop at {limit:.6}, and these do not see it: {}.",
            loading.title,
            later.join(", ")
        ));
    }
    sentences
}
