//! Card as one self-contained HTML file, suitable for printing.

use super::card::CardAnswer;
use super::kink;
use super::sentence::{heading, title, witness};
use crate::html::{embedded, escaped};
use crate::number::{told_above, told_below};
use onset::criteria::Criterion;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:46rem;margin:2rem auto;padding:0 1rem;color:#111}\
h1{font-size:1.4rem}h2{font-size:1.1rem;margin-top:1.6rem}table{border-collapse:collapse;width:100%}\
th,td{text-align:left;padding:.25rem .6rem .25rem 0;border-bottom:1px solid #ccc;vertical-align:top}\
td.n{font-variant-numeric:tabular-nums}table.c{font-size:12px;line-height:1.25}table.c td,table.c th{padding:.1rem .4rem .1rem 0}svg{max-width:100%;height:auto}small{color:#444}\
@media print{body{margin:0;max-width:none}h2{break-after:avoid}tr,figure{break-inside:avoid}}";

impl CardAnswer {
    /// Writes the card as an HTML page.
    pub fn html(&self) -> String {
        let [low, high] = self.range;
        let title = escaped(&title(&self.material));
        let law = escaped(&heading(&self.material));
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
             <title>Safe range: {title}</title>\n<style>{STYLE}</style></head><body>\n\
             <h1>Safe range of a law</h1>\n<p>{law}.</p>\n\
             <p>Within these ranges the law is strongly elliptic: <code>{}</code>. All wave speeds are real, and no band can form \
             because of the law. Stretches from {low} to {high} were searched.</p>\n",
            escaped(Criterion::StrongEllipticity.definition())
        );
        if self.material.incompressible {
            page.push_str(
                "<p>An incompressible law has no boxes: three independent stretches would change the volume.</p>\n",
            );
        } else if self.material.in_plane {
            page.push_str("<p>A two-dimensional law has no boxes of three stretches.</p>\n");
        } else {
            page.push_str(&self.page_of_boxes());
        }
        page.push_str(
            "<h2>Limits in each loading</h2>\n<table><tr><th>loading</th><th>compression, or gamma &lt; 0</th><th>tension, or gamma &gt; 0</th>\
             <th>critical wave</th></tr>\n",
        );
        for limits in &self.loadings {
            let wave = limits.tension_witness.or(limits.compression_witness);
            let [(_, below), (_, above)] = limits.cells();
            page.push_str(&row(&[
                escaped(limits.title),
                below,
                above,
                escaped(&wave.map(|wave| witness(&wave)).unwrap_or_default()),
            ]));
        }
        page.push_str("</table>\n");
        page.push_str(&self.page_of_criteria());
        page.push_str("<figure>\n");
        page.push_str(&embedded(&self.figure().to_svg()));
        page.push_str(&format!(
            "\n</figure>\n<p><small>Limits are imposed stretches, in simple shear the amount of shear &gamma; = F<sub>12</sub>. N is the direction of the wave in the \
             reference, g its polarization. Found by: {}. onset {}.</small></p>\n</body></html>\n",
            escaped(self.method),
            env!("CARGO_PKG_VERSION")
        ));
        page
    }

    fn page_of_boxes(&self) -> String {
        let mut page = String::from("<h2>All principal stretches within a box</h2>\n");
        if self.symmetric_box.is_none() {
            page.push_str(
                "<p>The law is not elliptic in the reference configuration: there is no safe box.</p>\n",
            );
        }
        page.push_str(
            "<table><tr><th>box</th><th>from</th><th>to</th><th>what ends it</th></tr>\n",
        );
        for (name, found) in self.boxes() {
            page.push_str(&row(&[
                escaped(name),
                told_above(found.low),
                told_below(found.high),
                escaped(&found.ends()),
            ]));
        }
        page.push_str("</table>\n");
        if !self.material.isotropic {
            page.push_str(
                "<p><small>The law is not isotropic: the boxes hold for principal axes along the coordinates only.</small></p>\n",
            );
        }
        page
    }

    /// Section with the limits of every criterion, with nominal strain and stress.
    fn page_of_criteria(&self) -> String {
        let mut page = format!(
            "<h2>Criteria, each with nominal strain and stress{}</h2>\n<table class=\"c\"><tr><th></th><th>compression, or gamma &lt; 0</th><th>strain</th>\
             <th>stress</th><th>tension, or gamma &gt; 0</th><th>strain</th><th>stress</th></tr>\n",
            self.unit_of_stress()
        );
        for limits in &self.loadings {
            page.push_str(&format!(
                "<tr><th colspan=\"7\">{}</th></tr>\n",
                escaped(limits.title)
            ));
            for own in &limits.criteria {
                let mut cells = vec![own.criterion.name().to_owned()];
                cells.extend(own.cells(limits.mode, own.compression));
                cells.extend(own.cells(limits.mode, own.tension));
                page.push_str(&row(&cells));
            }
            for line in limits
                .folds()
                .into_iter()
                .chain(limits.kinks.iter().map(|own| kink(own, limits.mode)))
            {
                page.push_str(&format!(
                    "<tr><td colspan=\"7\">{}</td></tr>\n",
                    escaped(&line)
                ));
            }
        }
        page.push_str("</table>\n");
        page
    }
}

fn row(cells: &[String]) -> String {
    let cell = |text: &String| format!("<td class=\"n\">{text}</td>");
    format!("<tr>{}</tr>\n", cells.iter().map(cell).collect::<String>())
}
