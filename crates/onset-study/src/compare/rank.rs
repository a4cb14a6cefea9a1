//! Which method for this material? By rules that are printed.

use super::{Measured, Table};
use serde::Serialize;
use std::fmt;

/// Largest share of the window on which a method may be wrong.
const WRONG: f64 = 0.005;
/// Largest error of the stiffness of long waves.
const LONG_WAVES: f64 = 0.05;
/// The relative frequency below which a mode is too weak.
const WEAK: f64 = 0.1;
/// The wavelength at which frequencies are compared, in spacings of the particles.
const WAVELENGTH: f64 = 8.0;

/// The rules, in the order in which they are applied.
pub const RULES: [&str; 6] = [
    "1. A method that cannot be evaluated in the undeformed state, or is unstable there, is not recommended; nor one that is not defined \
     on more than 0.5 % of the window of states, for want of neighbors.",
    "2. Nor is one with modes without energy, which the slightest disturbance excites, or with waves slower than a tenth of the \
     material's slowest wave, which are nearly such.",
    "3. Nor one that is unstable where the material is elliptic, on more than 0.5 % of the window of states: it shows fracture that \
     is not there.",
    "4. Nor one that is stable where the material is not elliptic, on more than 0.5 % of the window: it hides fracture that is there.",
    "5. Nor one whose long waves feel a stiffness that is wrong by more than 5 %: it does not converge to the material.",
    "6. Among the others the score is the error of the frequencies at 8 particles a wavelength times the cost (neighbors over the Courant \
     number), the smallest first: halving the spacing of a method of second order quarters the error.",
];

/// A method with its place.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Ranked {
    /// How it is called.
    pub name: String,
    /// The rule that excludes it, counted from 1, with the number; `None` when it is recommended.
    pub excluded: Option<(usize, String)>,
    /// The score of rule 6; the smaller the better.
    pub score: f64,
}

/// Which methods of a table to take, and why.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Recommendation {
    /// The rules.
    pub rules: [&'static str; 6],
    /// The methods, the recommended ones first and best first.
    pub ranking: Vec<Ranked>,
    /// What was measured.
    pub table: Table,
}

impl From<Table> for Recommendation {
    fn from(table: Table) -> Self {
        Self {
            rules: RULES,
            ranking: recommended(&table),
            table,
        }
    }
}

impl fmt::Display for Recommendation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.table.options.stretches;
        writeln!(
            formatter,
            "for {} and stretches from {low} to {high}, by these rules:\n",
            self.table.material
        )?;
        for rule in self.rules {
            writeln!(formatter, "  {rule}")?;
        }
        let names = self
            .ranking
            .iter()
            .map(|ranked| ranked.name.chars().count());
        let width = names.max().unwrap_or(0);
        let (good, bad): (Vec<&Ranked>, Vec<&Ranked>) = self
            .ranking
            .iter()
            .partition(|ranked| ranked.excluded.is_none());
        writeln!(
            formatter,
            "\n{}",
            if good.is_empty() {
                "none of the methods can be recommended"
            } else {
                "recommended, best first"
            }
        )?;
        for (n, ranked) in good.iter().enumerate() {
            let (name, score) = (&ranked.name, ranked.score);
            writeln!(formatter, "  {:>2}  {name:width$}  score {score:.4}", n + 1)?;
        }
        if !bad.is_empty() {
            writeln!(formatter, "\nnot recommended")?;
        }
        for ranked in bad {
            if let Some((rule, why)) = &ranked.excluded {
                writeln!(
                    formatter,
                    "      {:width$}  rule {rule}: {why}",
                    ranked.name
                )?;
            }
        }
        Ok(())
    }
}

/// The methods of a table, the recommended ones first and best first; then the others by the rule that excludes them, the last
/// rule first.
pub fn recommended(table: &Table) -> Vec<Ranked> {
    let mut ranked: Vec<Ranked> = table
        .rows
        .iter()
        .map(|row| match &row.measured {
            Err(why) => Ranked {
                name: row.name.clone(),
                excluded: Some((1, why.lines().next().unwrap_or_default().to_owned())),
                score: f64::NAN,
            },
            Ok(measured) => Ranked {
                name: row.name.clone(),
                excluded: excluded(measured),
                score: measured.dispersion_at(WAVELENGTH) * measured.cost(),
            },
        })
        .collect();
    let place = |ranked: &Ranked| {
        ranked
            .excluded
            .as_ref()
            .map_or(usize::MAX, |(rule, _)| *rule)
    };
    ranked.sort_by(|a, b| place(b).cmp(&place(a)).then(a.score.total_cmp(&b.score)));
    ranked
}

/// The first rule that excludes a method.
fn excluded(measured: &Measured) -> Option<(usize, String)> {
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let fidelity = &measured.fidelity;
    let at_rest = measured
        .onsets
        .iter()
        .any(|pair| pair.method == onset::measures::StretchOnset::AtRest);
    if at_rest && measured.zero_modes == 0 {
        return Some((1, "unstable in the undeformed state".to_owned()));
    }
    if fidelity.undefined > WRONG {
        return Some((
            1,
            format!(
                "not defined on {} of the window",
                percent(fidelity.undefined)
            ),
        ));
    }
    if measured.zero_modes > 0 {
        let number = measured.zero_modes;
        return Some((
            2,
            format!("{number} wave vector(s) with modes without energy"),
        ));
    }
    if measured.weakest < WEAK {
        let share = percent(measured.weakest);
        return Some((
            2,
            format!("a wave with {share} of the material's frequency"),
        ));
    }
    if fidelity.false_instability > WRONG {
        return Some((
            3,
            format!("{} of the window", percent(fidelity.false_instability)),
        ));
    }
    if fidelity.missed_instability > WRONG {
        return Some((
            4,
            format!("{} of the window", percent(fidelity.missed_instability)),
        ));
    }
    (measured.long_wave_error > LONG_WAVES)
        .then(|| (5, format!("wrong by {}", percent(measured.long_wave_error))))
}
