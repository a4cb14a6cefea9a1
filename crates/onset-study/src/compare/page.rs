//! Table of a comparison as a self-contained page.

use super::Table;
use super::rank::{recommended, rules};
use crate::html::{embedded, escaped};
use crate::number::counted;
use onset::measures::{Load, StretchOnset};

/// Style sheet: column heads may wrap, and narrow pages scroll the table while the names of the methods stay visible.
const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;margin:2rem auto;padding:0 1rem;max-width:100rem;color:#111}\
p,dl,ol,ul{max-width:76rem}h1{font-size:1.4rem}h2{font-size:1.1rem;margin-top:1.6rem}.wide{overflow-x:auto;max-width:100%}\
table{border-collapse:collapse;font-size:13px}\
th,td{text-align:right;padding:.2rem .45rem;border-bottom:1px solid #ccc;vertical-align:bottom;font-variant-numeric:tabular-nums}\
td{white-space:nowrap}th{font-weight:600;max-width:5.5rem}th:first-child,td:first-child{text-align:left;position:sticky;left:0;\
background:#fff;white-space:normal;min-width:9rem;max-width:16rem}td.why{text-align:left;white-space:normal;max-width:60rem}\
svg{max-width:100%;height:auto}small{color:#444}dl{display:grid;grid-template-columns:auto 1fr;gap:.1rem 1rem}\
dt{font-weight:600}dd{margin:0}@media print{.wide{overflow:visible}table{font-size:8px}}";

impl Table {
    /// Page with the table, the figure and the ranking.
    pub fn html(&self) -> String {
        let title = if self.title.is_empty() {
            "Methods side by side"
        } else {
            &self.title
        };
        let title = escaped(title);
        let columns = self.columns();
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
             <title>{title}</title>\n<style>{STYLE}</style></head><body>\n<h1>{title}</h1>\n\
             <p>Material {}, {}.{}</p>\n\
             <div class=\"wide\"><table><tr><th>method</th>",
            escaped(&self.material),
            counted(self.dimension, "dimension"),
            self.material_onsets()
        );
        for column in &columns {
            page.push_str(&format!("<th>{}</th>", escaped(&column.head)));
        }
        page.push_str("</tr>\n");
        for row in &self.rows {
            page.push_str(&format!("<tr><td>{}</td>", escaped(&row.name)));
            match &row.measured {
                Ok(measured) => {
                    for column in &columns {
                        let cell = escaped(&(column.cell)(measured));
                        page.push_str(&format!("<td>{cell}</td>"));
                    }
                }
                Err(why) => page.push_str(&format!(
                    "<td class=\"why\" colspan=\"{}\">{}</td>",
                    columns.len(),
                    escaped(why)
                )),
            }
            page.push_str("</tr>\n");
        }
        page.push_str("</table></div>\n<dl>");
        for (head, meaning) in self.legend() {
            page.push_str(&format!(
                "<dt>{}</dt><dd>{}</dd>",
                escaped(&head),
                escaped(&meaning)
            ));
        }
        page.push_str("</dl>\n");
        for note in self.all_notes() {
            page.push_str(&format!("<p>Note: {}.</p>\n", escaped(&note)));
        }
        page.push_str("<figure>");
        page.push_str(&embedded(&self.figure().to_svg()));
        page.push_str("</figure>\n<h2>Recommended</h2>\n<ol>\n");
        let ranking = recommended(self);
        for ranked in ranking.iter().filter(|ranked| ranked.excluded.is_none()) {
            page.push_str(&format!(
                "<li>{} ({})</li>\n",
                escaped(&ranked.name),
                ranked.measure(3)
            ));
        }
        page.push_str("</ol>\n<h2>Not recommended</h2>\n<ul>\n");
        for ranked in &ranking {
            if let Some((rule, why)) = &ranked.excluded {
                page.push_str(&format!(
                    "<li>{}: rule {rule}, {}</li>\n",
                    escaped(&ranked.name),
                    escaped(why)
                ));
            }
        }
        page.push_str("</ul>\n<h2>Settings</h2>\n<ul>\n");
        if let Some(first) = self.rows.first() {
            page.push_str(&format!(
                "<li>material: {}</li>\n",
                escaped(&first.settings.law())
            ));
        }
        for row in &self.rows {
            let (name, settings) = (escaped(&row.name), escaped(&row.settings.method()));
            page.push_str(&format!("<li>{name}: {settings}</li>\n"));
        }
        page.push_str("</ul>\n<h2>Rules</h2>\n");
        for rule in rules(&self.thresholds) {
            page.push_str(&format!("<p>{}</p>\n", escaped(&rule)));
        }
        page.push_str(&format!(
            "<p><small>onset {}</small></p>\n</body></html>\n",
            env!("CARGO_PKG_VERSION")
        ));
        page
    }

    /// Sentences on the loadings under which the material loses ellipticity, and on the other loadings.
    fn material_onsets(&self) -> String {
        let loads = Load::ALL.into_iter();
        let told: Vec<(String, bool)> = loads
            .filter(|load| load.is_possible(self.dimension))
            .filter_map(|load| {
                let (place, is_lost) = match self.material_onset_of(load)? {
                    StretchOnset::AtRest => ("at F = 1".to_owned(), true),
                    StretchOnset::At(stretch) => (format!("at {stretch:.4}"), true),
                    StretchOnset::NotBefore(end) => (format!("up to {end}"), false),
                    StretchOnset::Undefined(stretch) => (
                        format!("up to {stretch:.4}, the end of the domain of the law,"),
                        false,
                    ),
                };
                Some((
                    format!("{place} in {}", load.title(self.dimension)),
                    is_lost,
                ))
            })
            .collect();
        let of = |kind: bool| {
            let matching = told.iter().filter(|(_, is_lost)| *is_lost == kind);
            matching
                .map(|(place, _)| place.as_str())
                .collect::<Vec<_>>()
                .join(", ")
        };
        let sentence = |start: &str, places: String| match places.as_str() {
            "" => String::new(),
            places => format!(" The material itself {start} {places}."),
        };
        [
            sentence("loses ellipticity", of(true)),
            sentence("stays elliptic", of(false)),
        ]
        .concat()
    }
}
