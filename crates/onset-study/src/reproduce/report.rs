//! Report of a reproduction, as text for the terminal, as a page, and as a table.

use super::claims::{Claim, ClaimVerdict};
use crate::csv::Table;
use crate::settings::Units;
use serde::Serialize;

/// Verified claims, and the figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Claims, one row each.
    pub claims: Vec<Claim>,
    /// File name, title and caption of each figure.
    #[serde(serialize_with = "figure_names")]
    pub figures: Vec<(String, String, String)>,
}

fn figure_names<S: serde::Serializer>(
    figures: &[(String, String, String)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(figures.iter().map(|(name, _, _)| name))
}

impl Report {
    /// Returns true if every verdict agrees with the recorded one.
    pub fn is_as_recorded(&self) -> bool {
        self.claims.iter().all(Claim::is_as_recorded)
    }

    /// Counts of the verdicts, with the claims that do not hold without condition, and the agreement with the recorded verdicts.
    pub fn summary(&self) -> String {
        let of = |is_meant: &dyn Fn(&Claim) -> bool| -> Vec<&str> {
            let meant = self.claims.iter().filter(|claim| is_meant(claim));
            meant.map(|claim| claim.id).collect()
        };
        let counted = |ids: &[&str], what: &str| match ids {
            [] => format!("none {what}"),
            _ => format!("{} {what} ({})", ids.len(), ids.join(", ")),
        };
        let reproduced = of(&|claim| claim.verdict == ClaimVerdict::Reproduced);
        let only = of(&|claim| matches!(claim.verdict, ClaimVerdict::ReproducedOnlyFor(_)));
        let contradicted = of(&|claim| claim.verdict == ClaimVerdict::Contradicted);
        let unlike = of(&|claim| !claim.is_as_recorded());
        format!(
            "{} reproduced, {}, {}; {}",
            reproduced.len(),
            counted(&only, "only for some choices"),
            counted(&contradicted, "contradicted"),
            match unlike.as_slice() {
                [] => "as recorded".to_owned(),
                unlike => counted(unlike, "not as recorded"),
            }
        )
    }

    /// Claims as a CSV table.
    pub fn csv(&self) -> String {
        Table::new(&self.claims, Units::Own)
            .with("id", "1", |claim| claim.id)
            .with("place", "1", |claim| claim.place)
            .with("paper", "1", |claim| claim.paper)
            .with("computed", "1", |claim| claim.computed.as_str())
            .with("choices", "1", |claim| claim.choices)
            .with("verdict", "1", |claim| claim.verdict.to_string())
            .with("number", "1", |claim| claim.number)
            .with("recorded", "1", |claim| claim.recorded)
            .to_string()
    }

    /// Report as a page that needs no files except the figures in the same folder.
    pub fn html(&self) -> String {
        let rows: String = self.claims.iter().map(row).collect();
        let figures: String = self
            .figures
            .iter()
            .map(|(name, title, caption)| {
                format!(
                    "<figure id=\"{name}\"><img src=\"{name}.svg\" alt=\"{}\"><figcaption><a href=\"{name}.png\">PNG</a> \
                     {}</figcaption></figure>\n",
                    escaped(title),
                    escaped(caption)
                )
            })
            .collect();
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>Material stability analysis of particle methods, reproduced</title>\n<style>{STYLE}</style></head><body>\n\
             <h1>Material stability analysis of particle methods, reproduced</h1>\n\
             <p>Figures 2 and 4 to 10 (1 and 3 are sketches) and the claims of S. P. Xiao and T. Belytschko, <i>Material stability analysis of particle methods</i>, \
             Advances in Computational Mathematics 23 (2005) 171–190, computed by onset {}. Lengths in particle spacings, density 1, \
             stresses in MPa for the material of equation (5) and in psi for Blatz-Ko.</p>\n\
             <h2>Claims</h2>\n<p>{}.</p>\n<table><thead><tr><th></th><th>The paper says</th><th>Computed</th><th>Under these choices</th>\
             <th>Number</th><th>Verdict</th></tr></thead><tbody>\n{rows}</tbody></table>\n<h2>Figures</h2>\n{figures}</body></html>\n",
            env!("CARGO_PKG_VERSION"),
            self.summary()
        )
    }
}

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:1180px;margin:2em auto;padding:0 1em;color:#111}\
h1{font-size:1.5em}table{border-collapse:collapse;width:100%}th,td{border-top:1px solid #ccc;padding:.5em .6em;text-align:left;\
vertical-align:top}th{border-top:0}td:first-child{white-space:nowrap;font-weight:600}td small{color:#555;font-weight:400}\
.reproduced{color:#00614a}.only{color:#8a5200}.contradicted{color:#a13800}.number{white-space:nowrap}td:last-child{font-weight:600;min-width:9em}\
figure{margin:2em 0}img{max-width:100%;height:auto}figcaption{color:#333}@media(max-width:700px){table,tbody,tr,td{display:block}\
thead{display:none}}";

fn row(claim: &Claim) -> String {
    let class = match claim.verdict.word() {
        "reproduced only for" => "only",
        word => word,
    };
    let remark = if claim.is_as_recorded() {
        String::new()
    } else {
        format!(" <b>(on record: {})</b>", escaped(claim.recorded))
    };
    format!(
        "<tr><td>{}<br><small>{}</small></td><td>{}</td><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"{class}\">{}{remark}</td></tr>\n",
        claim.id,
        escaped(claim.place),
        escaped(claim.paper),
        escaped(&claim.computed),
        escaped(claim.choices),
        shown(claim.number),
        escaped(&claim.verdict.to_string())
    )
}

/// Formats a number for a table.
fn shown(number: f64) -> String {
    if number == 0.0 || number.fract() == 0.0 && number.abs() < 1e6 {
        format!("{number:.0}")
    } else if (1e-3..1e6).contains(&number.abs()) {
        format!("{number:.6}")
    } else {
        format!("{number:.1e}")
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

impl std::fmt::Display for Report {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for claim in &self.claims {
            writeln!(formatter, "{:<4} {}", claim.id, claim.verdict)?;
            writeln!(
                formatter,
                "     paper     {} ({})",
                claim.paper, claim.place
            )?;
            writeln!(formatter, "     computed  {}", claim.computed)?;
            writeln!(formatter, "     choices   {}", claim.choices)?;
            writeln!(formatter, "     number    {:.10e}", claim.number)?;
            if !claim.is_as_recorded() {
                writeln!(formatter, "     NOT AS RECORDED: {}", claim.recorded)?;
            }
        }
        write!(
            formatter,
            "\n{}\n{} figures: 2 and 4 to 10 of the paper (1 and 3 are sketches)",
            self.summary(),
            self.figures.len()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(id: &'static str, verdict: ClaimVerdict, recorded: &'static str) -> Claim {
        Claim {
            id,
            place: "",
            paper: "",
            computed: String::new(),
            choices: "",
            verdict,
            number: 0.0,
            recorded,
        }
    }

    #[test]
    fn the_last_line_counts_verdicts_and_names_failing_claims() {
        let mut report = Report {
            claims: vec![
                claim("C1", ClaimVerdict::Reproduced, "reproduced"),
                claim("C2", ClaimVerdict::Reproduced, "reproduced"),
                claim(
                    "C3",
                    ClaimVerdict::ReproducedOnlyFor("one reading".to_owned()),
                    "reproduced only for",
                ),
                claim("C4", ClaimVerdict::Contradicted, "contradicted"),
            ],
            figures: Vec::new(),
        };
        assert_eq!(
            report.summary(),
            "2 reproduced, 1 only for some choices (C3), 1 contradicted (C4); as recorded"
        );
        report.claims[1].recorded = "contradicted";
        assert!(report.summary().ends_with("; 1 not as recorded (C2)"));
        assert!(report.to_string().contains("1 contradicted (C4); 1 not"));
        assert!(report.html().contains("1 contradicted (C4); 1 not"));
    }
}
