//! Safe range card of a law: the stretches at which it is strongly elliptic, on one page.

use super::figure::{Bar, DEFAULT_CRITERIA, MEANING, Row, charts, held};
use super::sentence::{opening, title, witness};
use super::{
    CriteriaError, CriterionAnswer, EndAnswer, KinkAnswer, Lateral, LawAnswer, LoadingAnswer, Mode,
    Question, SideAnswer, kink, nominal_strain, sides,
};
use crate::answers::Evidence;
use crate::csv::Table;
use crate::figure::{Figure, palette};
use crate::json;
use crate::number::{told, told_above, told_below};
use crate::output::{Files, picture, text};
use crate::settings::Units;
use onset::cancel::Scope;
use onset::criteria::{BoxEnd, Criterion, SafeBox, Witness, safe_box, widest_safe_box};
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::{Display, Formatter};

/// Ranges of stretch in which a law is strongly elliptic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CardAnswer {
    /// Law with its parameters.
    pub material: LawAnswer,
    /// Smallest and largest stretch of the search; in simple shear, of the larger principal stretch, which is below 1 for a negative amount of shear.
    pub range: [f64; 2],
    /// Description of the search for limits.
    pub method: &'static str,
    /// Evidence for the limits: `searched`.
    pub evidence: Evidence,
    /// Largest box `[1/b, b]^3` of principal stretches; `null` if the law is not elliptic in the reference configuration or its response is
    /// incompressible.
    pub symmetric_box: Option<BoxAnswer>,
    /// Box `[a, b]^3` with the largest `b/a`; `null` under the conditions of `symmetric_box`.
    pub widest_box: Option<BoxAnswer>,
    /// Limits of each loading.
    pub loadings: Vec<Limits>,
}

/// A box of principal stretches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoxAnswer {
    /// Smallest principal stretch in the box.
    pub low: f64,
    /// Largest principal stretch in the box.
    pub high: f64,
    /// Reason why the box cannot extend to smaller stretches.
    pub low_end: BoxEnd,
    /// Reason why the box cannot extend to larger stretches.
    pub high_end: BoxEnd,
    /// Principal stretches of the critical state on the surface of the box; `null` if only the range limits the box.
    pub critical_stretches: Option<[f64; 3]>,
    /// Critical wave in the critical state; `null` if the law is not defined beyond the box.
    pub witness: Option<Witness>,
}

/// Limits of ellipticity for one loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Deformation mode that is imposed.
    pub mode: Mode,
    /// Condition on the lateral directions.
    pub lateral: Lateral,
    /// Short name of the loading.
    pub title: &'static str,
    /// Imposed stretch, in simple shear the amount of shear, at which ellipticity is lost in compression or negative shear; `null` if it is kept.
    pub compression: Option<f64>,
    /// Imposed stretch, in simple shear the amount of shear, at which ellipticity is lost in tension or positive shear; `null` if it is kept.
    pub tension: Option<f64>,
    /// Critical wave at the limit in compression; `null` if the criterion is kept.
    pub compression_witness: Option<Witness>,
    /// Critical wave at the limit in tension; `null` if the criterion is kept.
    pub tension_witness: Option<Witness>,
    /// Kind of end of the path in compression.
    pub compression_end: EndAnswer,
    /// Kind of end of the path in tension.
    pub tension_end: EndAnswer,
    /// Limits of ellipticity, of Drucker's and Hill's criteria and of the load, each with nominal strain and stress.
    pub criteria: Vec<CriterionLimits>,
    /// Places at which energy, stress or tangent jump.
    pub kinks: Vec<KinkAnswer>,
}

/// Limits of one criterion for one loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CriterionLimits {
    /// Name of the criterion.
    pub criterion: Criterion,
    /// Whether the criterion is defined for this law.
    pub defined: bool,
    /// Whether the criterion holds in the reference configuration.
    pub holds_in_reference: bool,
    /// State at which the criterion is violated in compression; `null` if it is satisfied throughout.
    pub compression: Option<LimitPoint>,
    /// State at which the criterion is violated in tension; `null` if it is satisfied throughout.
    pub tension: Option<LimitPoint>,
    /// Intervals of the imposed stretch, in simple shear of the amount of shear, in which the criterion holds.
    pub holds: Vec<(f64, f64)>,
}

/// State at which a criterion is violated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimitPoint {
    /// Imposed stretch at the limit; in simple shear the amount of shear.
    pub imposed: f64,
    /// Nominal strain `lambda - 1`; in simple shear the amount of shear.
    pub nominal_strain: f64,
    /// Nominal stress `P_11`, in simple shear `P_12`. Units of stress.
    pub nominal_stress: f64,
}

/// Criteria listed on a card. Drucker's check is the one used by programs that fit laws to tests.
const CARD_CRITERIA: [Criterion; 5] = [
    Criterion::StrongEllipticity,
    Criterion::DruckerAbaqus,
    Criterion::Hill,
    Criterion::HillRotationFree,
    Criterion::LoadMaximum,
];

const METHOD: &str = "dense search from the reference configuration with local improvement; no proof. Limits in loadings: every sign change between \
                      states along the path and dips between them, refined to rounding";

impl Question {
    /// Computes the safe range card.
    ///
    /// # Errors
    /// [`CriteriaError`] when the law cannot be evaluated in the reference configuration.
    pub fn card(&self) -> Result<CardAnswer, CriteriaError> {
        let scope = Scope::current();
        let loadings: Vec<Limits> = self
            .loadings
            .par_iter()
            .map(|loading| {
                let answer = scope.run(|| self.along(*loading, &CARD_CRITERIA))?;
                Ok(Limits::of(&answer))
            })
            .collect::<Result<_, CriteriaError>>()?;
        let is_asked = self.law.has_boxes();
        let (symmetric, widest) = rayon::join(
            || match is_asked {
                true => scope.run(|| safe_box(&*self.material, 1.0, &self.range)),
                false => None,
            },
            || match is_asked && self.law.isotropic {
                true => scope.run(|| widest_safe_box(&*self.material, &self.range)),
                false => None,
            },
        );
        Ok(CardAnswer {
            material: self.law.clone(),
            range: [self.range.low(), self.range.high()],
            method: METHOD,
            evidence: Evidence::Searched,
            symmetric_box: symmetric.map(BoxAnswer::of),
            widest_box: widest.map(BoxAnswer::of),
            loadings,
        })
    }
}

impl BoxAnswer {
    fn of(found: SafeBox) -> Self {
        Self {
            low: found.low,
            high: found.high,
            low_end: found.low_end,
            high_end: found.high_end,
            critical_stretches: found.critical.map(|critical| critical.stretches),
            witness: found.critical.and_then(|critical| critical.witness),
        }
    }

    pub(super) fn ends(&self) -> String {
        let [low, high] = [self.low_end, self.high_end].map(|end| self.end(end));
        match low == high {
            true => format!("both ends: {low}"),
            false => format!("lower end: {low}; upper end: {high}"),
        }
    }

    fn end(&self, end: BoxEnd) -> String {
        let state = || {
            let stretches = self.critical_stretches.unwrap_or([f64::NAN; 3]);
            stretches.map(told).join(", ")
        };
        match (end, &self.witness) {
            (BoxEnd::Range, _) => "end of the search range".to_owned(),
            (BoxEnd::Shape, _) => "set by the other end and the shape of the box".to_owned(),
            (BoxEnd::Critical, Some(wave)) => {
                format!("ellipticity is lost at ({}), {}", state(), witness(wave))
            }
            (BoxEnd::Critical, None) => format!("the law is not defined beyond ({})", state()),
        }
    }
}

impl Limits {
    fn of(answer: &LoadingAnswer) -> Self {
        let own = answer.criteria.first();
        let [compression, tension] = [
            own.map(|own| own.compression.clone()).unwrap_or_default(),
            own.map(|own| own.tension.clone()).unwrap_or_default(),
        ];
        let of = |own: &CriterionAnswer| CriterionLimits::of(answer, own);
        Self {
            mode: answer.mode,
            lateral: answer.lateral,
            title: answer.title,
            compression: compression.limit,
            tension: tension.limit,
            compression_witness: compression.changes.first().map(|change| change.witness),
            tension_witness: tension.changes.first().map(|change| change.witness),
            compression_end: answer.compression_end.clone(),
            tension_end: answer.tension_end.clone(),
            criteria: answer.criteria.iter().map(of).collect(),
            kinks: answer.kinks.clone(),
        }
    }

    /// One line for each fold of the path.
    pub(super) fn folds(&self) -> Vec<String> {
        let ends = [&self.compression_end, &self.tension_end];
        let folds = sides(self.mode).into_iter().zip(ends);
        folds
            .filter(|(_, end)| end.fold)
            .filter_map(|(side, end)| end.line(self.mode, side))
            .collect()
    }

    /// Limits of ellipticity on both sides of the reference configuration, each with its name.
    pub(super) fn cells(&self) -> [(&'static str, String); 2] {
        let [below, above] = sides(self.mode);
        let cell = |limit: Option<f64>, end: &EndAnswer, toward: &str| match (limit, &end.reason) {
            (Some(limit), _) => told(limit),
            (None, None) => format!("none {toward} {}", told(end.imposed)),
            (None, Some(_)) => {
                format!("none {toward} {}, where the path ends", told(end.imposed))
            }
        };
        [
            (
                below,
                cell(self.compression, &self.compression_end, "down to"),
            ),
            (above, cell(self.tension, &self.tension_end, "up to")),
        ]
    }

    /// Row of the figure.
    fn row(&self) -> Row<'_> {
        let drawn = self.criteria.iter().filter(|own| own.defined);
        let bars = DEFAULT_CRITERIA
            .into_iter()
            .enumerate()
            .filter_map(|(n, criterion)| {
                let own = drawn.clone().find(|own| own.criterion == criterion)?;
                Some(Bar::of(n, criterion, own.holds.clone()))
            });
        Row {
            name: self.title,
            ends: Some([self.compression_end.imposed, self.tension_end.imposed]),
            bars: bars.collect(),
            kinks: &self.kinks,
        }
    }
}

impl CriterionLimits {
    fn of(loading: &LoadingAnswer, answer: &CriterionAnswer) -> Self {
        let point = |side: &SideAnswer| {
            let imposed = side.limit?;
            let first = side.changes.first();
            let reached = first.filter(|change| change.imposed == imposed);
            Some(LimitPoint {
                imposed,
                nominal_strain: nominal_strain(loading.mode, imposed),
                nominal_stress: reached.map_or(0.0, |change| change.nominal_stress),
            })
        };
        Self {
            criterion: answer.criterion,
            defined: answer.defined,
            holds_in_reference: answer.holds_in_reference,
            compression: point(&answer.compression),
            tension: point(&answer.tension),
            holds: match answer.defined {
                true => held(loading, answer),
                false => Vec::new(),
            },
        }
    }

    pub(super) fn cells(&self, mode: Mode, limit: Option<LimitPoint>) -> [String; 3] {
        let none = || String::from("-");
        match limit {
            _ if !self.defined => ["not defined".to_owned(), none(), none()],
            None => ["never".to_owned(), none(), none()],
            Some(_) if !self.holds_in_reference => ["at F = 1".to_owned(), none(), none()],
            Some(limit) if limit.imposed == super::imposed(mode, 1.0) => {
                ["at once".to_owned(), none(), none()]
            }
            Some(limit) => [
                told(limit.imposed),
                told(limit.nominal_strain),
                told(limit.nominal_stress),
            ],
        }
    }
}

impl CardAnswer {
    /// Unit of stress for a table heading; empty if the parameters have no units.
    pub(super) fn unit_of_stress(&self) -> &'static str {
        match self.material.units() {
            Units::Si => " in Pa",
            Units::Own => "",
        }
    }

    /// The boxes that were found, with their names.
    pub(super) fn boxes(&self) -> Vec<(&'static str, &BoxAnswer)> {
        let named = [
            ("largest box [1/b, b]", &self.symmetric_box),
            ("widest box [a, b]", &self.widest_box),
        ];
        let boxes = named.into_iter();
        boxes
            .filter_map(|(name, found)| Some((name, found.as_ref()?)))
            .collect()
    }

    /// The limits as CSV, one row for each loading: for each criterion the imposed stretch, in simple shear the amount of shear, and the nominal
    /// stress at the loss in compression and in tension.
    pub fn csv(&self) -> String {
        let mut table = Table::new(&self.loadings, self.material.units())
            .with("mode", "1", |own| own.mode.name())
            .with("lateral", "1", |own| own.lateral.name())
            .with("loading", "1", |own| own.title);
        type Side = (&'static str, fn(&CriterionLimits) -> Option<LimitPoint>);
        let sides: [Side; 2] = [
            ("compression", |own| own.compression),
            ("tension", |own| own.tension),
        ];
        for criterion in CARD_CRITERIA {
            for (name, side) in sides {
                let name = format!("{}_{name}", criterion.name().replace('-', "_"));
                let point = move |own: &Limits| {
                    let mut criteria = own.criteria.iter();
                    side(criteria.find(|own| own.criterion == criterion)?)
                };
                table = table
                    .with(&name, "1", |own| Some(point(own)?.imposed))
                    .with(format!("{name}_stress"), "stress", |own| {
                        Some(point(own)?.nominal_stress)
                    });
            }
        }
        table
            .with("compression_end", "1", |own| own.compression_end.imposed)
            .with("tension_end", "1", |own| own.tension_end.imposed)
            .to_string()
    }

    /// Draws the ranges as horizontal bars.
    pub fn figure(&self) -> Figure {
        let boxes = self.boxes();
        let boxes = boxes.iter().map(|(name, found)| {
            let bar = Bar {
                name: "box of principal stretches, strongly elliptic",
                color: palette::GREEN,
                holds: vec![(found.low, found.high)],
            };
            let row = Row {
                name,
                ends: None,
                bars: vec![bar],
                kinks: &[],
            };
            (None, row)
        });
        let loadings = self.loadings.iter();
        let loadings = loadings.map(|limits| (Some(limits.mode), limits.row()));
        let figure = Figure::new(format!("Safe range: {}", title(&self.material)))
            .columns(1)
            .caption(format!("{MEANING} Strong ellipticity: all wave speeds are real. Boxes: all principal stretches between their ends."));
        charts(figure, boxes.chain(loadings).collect(), self.range)
    }

    /// Returns the figure `card`, and the files `card.json` and `card.html`.
    ///
    /// # Errors
    /// [`serde_json::Error`] if the answer cannot be written as JSON.
    pub fn files(&self) -> Result<Files, serde_json::Error> {
        Ok(vec![
            picture("card", self.figure()),
            text("card.json", json::document(self)?),
            text("card.html", self.html()),
        ])
    }
}

impl Display for CardAnswer {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        writeln!(formatter, "{}", opening(&self.material))?;
        let [low, high] = self.range;
        writeln!(
            formatter,
            "Strongly elliptic, for stretches from {low} to {high}:\n"
        )?;
        if self.material.incompressible {
            writeln!(
                formatter,
                "(An incompressible law has no boxes: three independent stretches would change the volume.)"
            )?;
        } else if self.material.in_plane {
            writeln!(
                formatter,
                "(A two-dimensional law has no boxes of three stretches.)"
            )?;
        } else if self.symmetric_box.is_none() {
            writeln!(
                formatter,
                "The law is not elliptic in the reference configuration."
            )?;
        }
        for (name, found) in self.boxes() {
            writeln!(
                formatter,
                "{name:<30} {} to {}",
                told_above(found.low),
                told_below(found.high)
            )?;
            writeln!(formatter, "{:<30} {}", "", found.ends())?;
        }
        if !self.material.isotropic && !self.material.in_plane {
            writeln!(
                formatter,
                "(The law is not isotropic: principal axes along the coordinates only.)"
            )?;
        }
        writeln!(formatter)?;
        let cells: Vec<_> = self.loadings.iter().map(Limits::cells).collect();
        let widths = cells.iter().map(|[(_, below), _]| below.len());
        let width = widths.max().unwrap_or(0);
        for (limits, [(below, smaller), (above, larger)]) in self.loadings.iter().zip(&cells) {
            writeln!(
                formatter,
                "{:<30} {below:<11} {smaller:<width$}   {above} {larger}",
                limits.title
            )?;
        }
        writeln!(
            formatter,
            "\nLimits: imposed stretch (in simple shear the amount of shear gamma), nominal strain, nominal stress{}",
            self.unit_of_stress()
        )?;
        for limits in &self.loadings {
            writeln!(formatter, "\n{}", limits.title)?;
            let [below, above] = sides(limits.mode);
            writeln!(
                formatter,
                "  {:<20} {below:>16} {:>10} {:>13}   {above:>16} {:>10} {:>13}",
                "", "strain", "stress", "strain", "stress"
            )?;
            for own in &limits.criteria {
                let [place, strain, stress] = own.cells(limits.mode, own.compression);
                let [other, its_strain, its_stress] = own.cells(limits.mode, own.tension);
                writeln!(
                    formatter,
                    "  {:<20} {place:>16} {strain:>10} {stress:>13}   {other:>16} {its_strain:>10} {its_stress:>13}",
                    own.criterion.name()
                )?;
            }
            for line in limits.folds() {
                writeln!(formatter, "  {line}")?;
            }
            for found in &limits.kinks {
                writeln!(formatter, "  {}", kink(found, limits.mode))?;
            }
        }
        writeln!(formatter, "\nFound by: {}.\n{}", self.method, self.evidence)
    }
}
