//! Ranking of methods for a material, by rules that are printed.

use super::thresholds::{RECOMMENDATION_LIMITS, Thresholds, percent};
use super::{Measured, Table};
use crate::csv;
use crate::number::counted;
use crate::settings::Units;
use serde::Serialize;
use std::fmt;

/// Rules, in the order of their application.
pub fn rules(limits: &Thresholds) -> [String; 6] {
    let (wrong, weak) = (percent(limits.wrong), percent(limits.weak));
    [
        format!(
            "1. A method is excluded if it cannot be evaluated in the reference state, is unstable there, or has too few neighbors on more than \
             {wrong} of the window of states;"
        ),
        format!(
            "2. if it has zero-energy modes, which any disturbance excites, or waves slower than {weak} of the material's slowest wave, which \
             behave almost like them;"
        ),
        format!(
            "3. if it is unstable where the material is elliptic, on more than {wrong} of the window of states: a numerical instability;"
        ),
        format!(
            "4. if it is stable where the material is not elliptic, on more than {wrong} of the window: it suppresses a physical instability;"
        ),
        format!(
            "5. if its long-wavelength moduli are wrong by more than {}: it is not consistent, and does not converge to the material.",
            percent(limits.long_waves)
        ),
        format!(
            "6. The score of the other methods is the error of the frequencies at {} points per wavelength times the cost (neighbors divided by the \
             Courant number), the smallest first: for a method of second order, half the spacing means a quarter of the error.",
            limits.wavelength
        ),
    ]
}

/// Verdict on a method that no rule excludes.
pub(super) const RECOMMENDED: &str = "recommended";

/// Verdicts on the methods that rules 1 to 5 exclude, with short descriptions.
pub(super) const EXCLUSIONS: [(&str, &str); 5] = [
    (
        "not usable",
        "not usable in the reference state or on the window",
    ),
    ("zero-energy", "zero-energy or weakly controlled modes"),
    ("numerical", "unstable where the material is elliptic"),
    ("suppressed", "stable where the material is not elliptic"),
    ("inconsistent", "inconsistent long-wavelength moduli"),
];

/// Method in a ranking: reason for exclusion, score and cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// Name of the method.
    pub name: String,
    /// Number of the excluding rule, counted from 1, and the reason; `None` if the method is recommended.
    pub excluded: Option<(usize, String)>,
    /// Score of rule 6, smaller is better.
    ///
    /// Infinite if some waves of the material have zero frequency, such as transverse waves of a fluid.
    pub score: f64,
    /// Cost: number of neighbors divided by the Courant number.
    pub cost: f64,
}

/// Recommended methods of a table, with the reasons.
#[derive(Clone, Debug, Serialize)]
pub struct Recommendation {
    /// Rules of the ranking.
    pub rules: [String; 6],
    /// Methods by rank: recommended ones first, best first.
    pub ranking: Vec<Ranked>,
    /// Changes for other limits.
    pub dependence: Vec<Dependence>,
    /// Table of the measures of all methods.
    pub table: Table,
}

/// Change of the recommendation for a limit that is halved or doubled.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dependence {
    /// Name of the limit.
    pub threshold: &'static str,
    /// Changed value of the limit.
    pub value: f64,
    /// Best method with the changed limit; `null` if no method can be recommended.
    pub best: Option<String>,
    /// Methods that would become recommended.
    pub more: Vec<String>,
    /// Methods that would no longer be recommended.
    pub less: Vec<String>,
}

impl Ranked {
    /// Verdict on the method in a word.
    pub(super) fn verdict(&self) -> &'static str {
        let excluded = self.excluded.as_ref();
        excluded.map_or(RECOMMENDED, |(rule, _)| EXCLUSIONS[rule - 1].0)
    }

    /// Score with the given number of digits, or the cost if the score is infinite.
    pub(super) fn measure(&self, digits: usize) -> String {
        match self.score.is_infinite() {
            true => format!("cost {:.digits$}", self.cost),
            false => format!("score {:.digits$}", self.score),
        }
    }
}

/// Heading of the recommended methods, with their order.
fn recommended_by(good: &[&Ranked]) -> &'static str {
    match good.iter().all(|ranked| ranked.score.is_infinite()) {
        true => {
            "recommended, cheapest first: the material has waves without a frequency, such as transverse waves of a fluid, so that errors of frequencies (rule 6) are \
             undefined"
        }
        false => "recommended, best first",
    }
}

impl Recommendation {
    /// Ranks the methods of a table.
    pub fn new(table: Table) -> Self {
        let limits = table.thresholds;
        let ranking = recommended(&table);
        let names = |ranking: &[Ranked]| -> Vec<String> {
            let good = ranking.iter().filter(|ranked| ranked.excluded.is_none());
            good.map(|ranked| ranked.name.clone()).collect()
        };
        let own = names(&ranking);
        let dependence = limits
            .varied(&RECOMMENDATION_LIMITS)
            .into_iter()
            .map(|(threshold, value, limits)| {
                let then = names(&ranked(&table, &limits));
                let without = |these: &[String], others: &[String]| -> Vec<String> {
                    let only = these.iter().filter(|name| !others.contains(name));
                    only.cloned().collect()
                };
                Dependence {
                    threshold,
                    value,
                    best: then.first().cloned(),
                    more: without(&then, &own),
                    less: without(&own, &then),
                }
            })
            .collect();
        Self {
            rules: rules(&limits),
            ranking,
            dependence,
            table,
        }
    }

    /// Ranking as a CSV table.
    pub fn csv(&self) -> String {
        let ranking: Vec<_> = self.ranking.iter().enumerate().collect();
        csv::Table::new(&ranking, Units::Own)
            .with("place", "1", |(n, own)| {
                own.excluded.is_none().then_some(n + 1)
            })
            .with("method", "1", |(_, own)| own.name.as_str())
            .with("score", "1", |(_, own)| {
                own.score.is_finite().then_some(own.score)
            })
            .with("cost", "1", |(_, own)| own.cost)
            .with("rule", "1", |(_, own)| {
                own.excluded.as_ref().map(|(rule, _)| *rule)
            })
            .with("why", "1", |(_, own)| {
                own.excluded.as_ref().map(|(_, why)| why.as_str())
            })
            .to_string()
    }

    /// Changes for other limits, as sentences.
    fn told_dependence(&self) -> Vec<String> {
        let good = self.ranking.iter().find(|ranked| ranked.excluded.is_none());
        let best = good.map(|ranked| ranked.name.as_str());
        let told = |one: &Dependence| {
            let mut changes = Vec::new();
            if !one.more.is_empty() {
                changes.push(format!("also recommended: {}", one.more.join("; ")));
            }
            if !one.less.is_empty() {
                changes.push(format!("not recommended any more: {}", one.less.join("; ")));
            }
            if let Some(first) = one.best.as_deref().filter(|first| Some(*first) != best) {
                changes.push(format!("first: {first}"));
            }
            if changes.is_empty() {
                changes.push("the same methods".to_owned());
            }
            format!(
                "--{} {}: {}",
                one.threshold,
                crate::number::told(one.value),
                changes.join("; ")
            )
        };
        self.dependence.iter().map(told).collect()
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
        for rule in &self.rules {
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
                recommended_by(&good)
            }
        )?;
        for (n, ranked) in good.iter().enumerate() {
            let (name, measure) = (&ranked.name, ranked.measure(4));
            writeln!(formatter, "  {:>2}  {name:width$}  {measure}", n + 1)?;
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
        writeln!(formatter, "\nwith other limits")?;
        for line in self.told_dependence() {
            writeln!(formatter, "      {line}")?;
        }
        Ok(())
    }
}

/// Methods of a table by rank.
///
/// Recommended methods come first, the best first. The other methods are ordered by the rule that excludes them, the last rule first.
pub fn recommended(table: &Table) -> Vec<Ranked> {
    ranked(table, &table.thresholds)
}

fn ranked(table: &Table, limits: &Thresholds) -> Vec<Ranked> {
    let mut ranked: Vec<Ranked> = table
        .rows
        .iter()
        .map(|row| match &row.measured {
            Err(why) => Ranked {
                name: row.name.clone(),
                excluded: Some((1, why.lines().next().unwrap_or_default().to_owned())),
                score: f64::NAN,
                cost: f64::NAN,
            },
            Ok(measured) => Ranked {
                name: row.name.clone(),
                excluded: excluded(measured, limits),
                score: measured.dispersion_at(limits.wavelength) * measured.cost(),
                cost: measured.cost(),
            },
        })
        .collect();
    let place = |ranked: &Ranked| {
        ranked
            .excluded
            .as_ref()
            .map_or(usize::MAX, |(rule, _)| *rule)
    };
    ranked.sort_by(|a, b| {
        let by_score = a.score.total_cmp(&b.score);
        let by_cost = a.cost.total_cmp(&b.cost);
        place(b).cmp(&place(a)).then(by_score).then(by_cost)
    });
    ranked
}

/// First rule that excludes a method.
fn excluded(measured: &Measured, limits: &Thresholds) -> Option<(usize, String)> {
    let share_of = |share: f64| format!("{:.2} %", 100.0 * share);
    let fidelity = &measured.fidelity;
    let at_rest = measured
        .onsets
        .iter()
        .any(|pair| pair.method == onset::measures::StretchOnset::AtRest);
    if at_rest && measured.zero_modes == 0 {
        return Some((1, "unstable in the reference state".to_owned()));
    }
    if fidelity.undefined > limits.wrong {
        return Some((
            1,
            format!(
                "not defined on {} of the window",
                share_of(fidelity.undefined)
            ),
        ));
    }
    if measured.zero_modes > 0 {
        let number = measured.zero_modes;
        return Some((
            2,
            format!("zero-energy modes at {}", counted(number, "wave vector")),
        ));
    }
    if measured.is_weak(limits.weak) {
        let share = share_of(measured.weakest);
        return Some((
            2,
            format!("a wave with {share} of the material's frequency"),
        ));
    }
    if fidelity.false_instability > limits.wrong {
        return Some((
            3,
            format!("{} of the window", share_of(fidelity.false_instability)),
        ));
    }
    if fidelity.suppressed_instability > limits.wrong {
        return Some((
            4,
            format!(
                "{} of the window",
                share_of(fidelity.suppressed_instability)
            ),
        ));
    }
    (measured.long_wave_error > limits.long_waves).then(|| {
        (
            5,
            format!("wrong by {}", share_of(measured.long_wave_error)),
        )
    })
}
