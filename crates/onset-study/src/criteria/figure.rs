//! Figure of the ranges in which criteria hold: loadings as rows, a horizontal bar for each criterion.

use super::{CriteriaAnswer, CriterionAnswer, KinkAnswer, LoadingAnswer, Mode};
use crate::figure::{Axis, Color, Figure, Line, Panel, Rule, palette};
use onset::criteria::{Change, Criterion, Discontinuity};

/// Criteria that figures show by default: loss of ellipticity, and the stability check of programs that fit laws to tests.
pub const DEFAULT_CRITERIA: [Criterion; 2] =
    [Criterion::StrongEllipticity, Criterion::DruckerAbaqus];
/// Largest number of criteria in a figure, which have different colors.
pub const MAX_CRITERIA: usize = palette::BARS.len();

/// Width of a bar, distance of neighboring bars, and space around the bars of a row, in pixels.
const BAR: f64 = 7.0;
const BAR_PITCH: f64 = 9.0;
const ROW_SPACE: f64 = 9.0;
/// Height of a line of text, in which the height of a panel is given, in pixels.
const LINE: f64 = 17.0;
/// Color of the thin lines over the whole path of a loading.
const PATH: Color = Color::hex(0xbbbbbb);
/// Meaning of bars and lines.
pub(super) const MEANING: &str = "Bars: the criterion holds. Thin lines: it does not. Neither: there is no state, or the criterion is not defined for the law.";

/// Bar of a row: name in the legend, color and intervals.
pub(super) struct Bar {
    pub(super) name: &'static str,
    pub(super) color: Color,
    pub(super) holds: Vec<(f64, f64)>,
}

/// Row of a chart of bars.
pub(super) struct Row<'a> {
    pub(super) name: &'a str,
    /// Ends of the path of a loading; `None` for a row of bars alone.
    pub(super) ends: Option<[f64; 2]>,
    pub(super) bars: Vec<Bar>,
    pub(super) kinks: &'a [KinkAnswer],
}

impl<'a> Row<'a> {
    /// Row of a loading, with a bar for each criterion that is defined.
    pub(super) fn of(loading: &'a LoadingAnswer, drawn: &[Criterion]) -> Self {
        let defined = |criterion: &Criterion| {
            let mut own = loading.criteria.iter();
            own.find(|answer| answer.criterion == *criterion && answer.defined)
        };
        let bars = drawn.iter().enumerate().filter_map(|(n, criterion)| {
            Some(Bar::of(n, *criterion, held(loading, defined(criterion)?)))
        });
        Self {
            name: loading.title,
            ends: Some([loading.compression_end.imposed, loading.tension_end.imposed]),
            bars: bars.collect(),
            kinks: &loading.kinks,
        }
    }
}

impl Bar {
    /// Bar of the `n`-th criterion of a figure.
    pub(super) fn of(n: usize, criterion: Criterion, holds: Vec<(f64, f64)>) -> Self {
        Self {
            name: criterion.title(),
            color: palette::BARS[n % palette::BARS.len()],
            holds,
        }
    }
}

/// Panel with the rows from top to bottom, over an axis of imposed values that are `reference` without deformation.
pub(super) fn chart(rows: &[Row], axis: Axis, reference: f64) -> Panel {
    let count = rows.len() as f64;
    let most = rows
        .iter()
        .map(|row| row.bars.len())
        .max()
        .unwrap_or(0)
        .max(1);
    let height = BAR_PITCH * most as f64 + ROW_SPACE;
    let at = |n: usize| count - n as f64;
    let names = rows.iter().enumerate().map(|(n, row)| (at(n), row.name));
    let mut panel = Panel::new("", axis, Axis::linear("", (0.5, count + 0.5)).ticks(names))
        .lines(count * height / LINE)
        .with(Rule::vertical(reference));
    for (n, row) in rows.iter().enumerate() {
        if n > 0 {
            panel = panel.with(Rule::horizontal(at(n) + 0.5).color(Color::hex(0xdddddd)));
        }
        for (bar, own) in row.bars.iter().enumerate() {
            let middle = (row.bars.len() - 1) as f64 / 2.0;
            let y = at(n) - (bar as f64 - middle) * BAR_PITCH / height;
            if let Some([low, high]) = row.ends {
                let path = Line::new(vec![(low, y), (high, y)]);
                panel = panel.with(path.width(2.0).color(PATH));
            }
            // The entry in the legend also names a criterion that holds nowhere.
            let bars = own
                .holds
                .iter()
                .flat_map(|(from, to)| [(*from, y), (*to, y), (f64::NAN, f64::NAN)]);
            let bars = Line::new(bars.collect()).width(BAR);
            panel = panel.with(bars.color(own.color).named(own.name));
        }
        for (place, name) in row.kinks.iter().map(mark) {
            let mark = Line::new(vec![(place, at(n) - 0.4), (place, at(n) + 0.4)]);
            panel = panel.with(mark.width(2.0).color(palette::BLACK).named(name));
        }
    }
    panel
}

/// Panels of rows with their modes: loadings with an imposed stretch, and simple shear.
pub(super) fn charts<'a>(
    mut figure: Figure,
    rows: Vec<(Option<Mode>, Row<'a>)>,
    [low, high]: [f64; 2],
) -> Figure {
    let is_shear = |mode: &Option<Mode>| *mode == Some(Mode::SimpleShear);
    let (shears, stretched): (Vec<_>, Vec<_>) =
        rows.into_iter().partition(|(mode, _)| is_shear(mode));
    let only = |rows: Vec<(Option<Mode>, Row<'a>)>| -> Vec<Row<'a>> {
        rows.into_iter().map(|(_, row)| row).collect()
    };
    let (shears, stretched) = (only(shears), only(stretched));
    if !stretched.is_empty() {
        let axis = stretches(imposed_label(Mode::Uniaxial), low, high);
        figure = figure.with(chart(&stretched, axis, 1.0));
    }
    if !shears.is_empty() {
        let ends = [low, high].map(|end| super::imposed(Mode::SimpleShear, end));
        let axis = shears_from(ends[0], ends[1]);
        figure = figure.with(chart(&shears, axis, 0.0));
    }
    figure
}

impl CriteriaAnswer {
    /// Draws the intervals in which the given criteria hold as bars, one row for each loading.
    pub fn figure(&self, drawn: &[Criterion]) -> Figure {
        let figure = Figure::new(format!(
            "Where stability criteria hold: {}",
            super::sentence::title(&self.material)
        ))
        .columns(1)
        .caption(MEANING);
        let rows = self.loadings.iter();
        let rows = rows.map(|loading| (Some(loading.mode), Row::of(loading, drawn)));
        charts(figure, rows.collect(), self.range)
    }
}

/// Position and name of the mark for a discontinuity of the law.
pub(super) fn mark(kink: &KinkAnswer) -> (f64, &'static str) {
    let name = match kink.kind {
        Discontinuity::StepOfEnergy => "step of the energy",
        Discontinuity::JumpOfStress => "jump of the stress",
        Discontinuity::KinkOfStress => "kink of the stress",
    };
    (kink.imposed, name)
}

/// Label of the axis of the quantity that a mode imposes.
pub(crate) fn imposed_label(mode: Mode) -> &'static str {
    match mode {
        Mode::SimpleShear => "amount of shear γ (−)",
        _ => "imposed stretch λ (−)",
    }
}

/// Axis of amounts of shear, with few ticks at round numbers.
fn shears_from(low: f64, high: f64) -> Axis {
    let reach = low.abs().max(high.abs());
    let decade = 10f64.powf(reach.log10().floor());
    // At most two ticks on each side.
    let step = [0.5, 1.0, 2.0, 5.0].map(|factor| factor * decade);
    let step = step
        .into_iter()
        .find(|step| reach < 3.0 * step)
        .unwrap_or(5.0 * decade);
    let ticks = (-2..=2).map(|n| f64::from(n) * step).map(|at| {
        let digits = (-step.log10().floor()).max(0.0) as usize;
        (at, format!("{at:.digits$}").replace('-', "−"))
    });
    Axis::linear(imposed_label(Mode::SimpleShear), (low, high)).ticks(ticks)
}

/// Logarithmic axis of stretches, with ticks at round numbers.
pub(crate) fn stretches(label: &str, low: f64, high: f64) -> Axis {
    let round = [
        0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0,
        10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0,
    ];
    let wide = high / low > 30.0;
    let shown = round
        .into_iter()
        .filter(|x| (low..=high).contains(x))
        .filter(|x| !wide || ![0.3, 0.7, 1.5, 3.0].contains(x));
    Axis::log(label, (low, high)).ticks(shown.map(|x| (x, format!("{x}"))))
}

/// Intervals of the imposed stretch or amount of shear in which a criterion holds, between the ends of the path.
pub(super) fn held(loading: &LoadingAnswer, answer: &CriterionAnswer) -> Vec<(f64, f64)> {
    let mut intervals = Vec::new();
    for (side, end) in [
        (&answer.compression, &loading.compression_end),
        (&answer.tension, &loading.tension_end),
    ] {
        let mut from = answer.holds_in_reference.then(|| loading.reference());
        for change in &side.changes {
            match change.change {
                Change::Lost => intervals.extend(from.take().map(|from| (from, change.imposed))),
                Change::Regained => from = Some(change.imposed),
            }
        }
        intervals.extend(from.map(|from| (from, end.imposed)));
    }
    intervals.retain(|(from, to)| from != to);
    let ascending = |(from, to): (f64, f64)| (from.min(to), from.max(to));
    intervals.into_iter().map(ascending).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Mode, Question, Range};
    use super::*;
    use crate::figure::Layer;
    use crate::settings::Settings;
    use onset::criteria::LoadingPath;

    /// Laws that keep all criteria, or lose some in tension, in compression, in the reference configuration, or at the slightest deformation.
    const LAWS: [&[&str]; 4] = [
        &["model=blatz-ko"],
        &[
            "energy=mu/2*(I1-3-2*ln(J))+la/2*(ln(J))^2",
            "mu=1",
            "la=-0.9",
        ],
        &[
            "energy=mu/2*(I1-3-2*ln(J))+la/2*(ln(J))^2",
            "mu=1",
            "la=-2.5",
        ],
        &[
            "energy=mu/2*(I1-3-2*ln(J))+la/2*(ln(J))^2+k*(I1-3)^2",
            "mu=-0.1",
            "la=1",
            "k=0.1",
        ],
    ];

    /// Intervals that the bars of a criterion cover in a figure of one loading.
    fn bars(figure: &Figure, criterion: Criterion) -> Vec<[f64; 2]> {
        let lines = figure.panels[0]
            .layers
            .iter()
            .filter_map(|layer| match layer {
                Layer::Line(line) if line.name.as_deref() == Some(criterion.title()) => {
                    Some(&line.points)
                }
                _ => None,
            });
        lines
            .flat_map(|points| points.chunks(3))
            .map(|ends| [ends[0].0.min(ends[1].0), ends[0].0.max(ends[1].0)])
            .collect()
    }

    fn question(law: &[&str], mode: Mode) -> Question {
        let set = law.iter().map(|own| match own.strip_prefix("energy=") {
            Some(energy) => format!("material.energy={energy}"),
            None => format!("material.{own}"),
        });
        let mut set: Vec<String> = set.collect();
        if law[0].starts_with("energy") {
            set.insert(0, "material.model=formula".to_owned());
        }
        let settings = Settings::from_assignments(&set).expect("a law");
        let range = Range::new(0.1, 10.0).expect("a range");
        Question::new(&settings.material, range, &[mode]).expect("a question")
    }

    #[test]
    fn bars_cover_exactly_the_states_in_which_the_criterion_holds() {
        for law in LAWS {
            let question = question(law, Mode::Hydrostatic);
            let answer = question.answer().expect("an answer");
            let of_card = question.card().expect("a card").figure();
            for loading in &answer.loadings {
                let own = question
                    .loadings
                    .iter()
                    .find(|own| own.title() == loading.title);
                let path = LoadingPath::new(
                    &*question.material,
                    question.law.isotropic,
                    *own.expect("a loading"),
                    &question.range,
                )
                .expect("a path");
                for criterion in &loading.criteria {
                    let bars = bars(&answer.figure(&[criterion.criterion]), criterion.criterion);
                    let is_covered = |x: f64| bars.iter().any(|ends| ends[0] <= x && x <= ends[1]);
                    if DEFAULT_CRITERIA.contains(&criterion.criterion) {
                        let of_card = self::bars(&of_card, criterion.criterion);
                        assert_eq!(of_card, bars, "{law:?} {}", loading.title);
                    }
                    let limits =
                        [&criterion.compression, &criterion.tension].map(|side| side.limit);
                    for stretch in [
                        0.12, 0.31, 0.6, 0.83, 0.97, 1.03, 1.2, 1.7, 2.9, 5.1, 9.3_f64,
                    ] {
                        let Some(state) = path.at(stretch.ln()) else {
                            continue;
                        };
                        let holds = match criterion.criterion {
                            // Finite jumps are searched for only up to the first loss.
                            Criterion::RankOneConvexity => {
                                criterion.defined
                                    && match limits[usize::from(stretch > 1.0)] {
                                        Some(limit) => limit.ln().abs() > stretch.ln().abs(),
                                        None => true,
                                    }
                            }
                            other => other
                                .measure(&path.ask(&state))
                                .is_some_and(|measure| measure.holds()),
                        };
                        assert_eq!(
                            is_covered(stretch),
                            holds,
                            "{law:?} {} {} at {stretch}",
                            loading.title,
                            criterion.criterion.name()
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn one_panel_has_a_row_for_each_loading_and_simple_shear_is_drawn_over_gamma() {
        let law = ["model=blatz-ko"];
        let settings = Settings::from_assignments(&law.map(|own| format!("material.{own}")));
        let range = Range::new(0.1, 10.0).expect("a range");
        let question = Question::new(&settings.expect("a law").material, range, &[]);
        let answer = question.expect("a question").answer().expect("an answer");
        let figure = answer.figure(&DEFAULT_CRITERIA);
        let rows = |n: usize| figure.panels[n].y.ticks.as_ref().expect("rows").len();
        assert_eq!(figure.panels.len(), 2);
        assert_eq!(rows(0) + rows(1), answer.loadings.len());
        let [stretched, shear] = [0, 1].map(|n| figure.panels[n].x.label.as_str());
        assert_eq!(
            [stretched, shear],
            ["imposed stretch λ (−)", "amount of shear γ (−)"]
        );
        let names: Vec<String> = figure
            .legend_entries()
            .into_iter()
            .map(|own| own.name)
            .collect();
        assert_eq!(names, DEFAULT_CRITERIA.map(Criterion::title));
        // Plane strain: ellipticity is lost where gamma^2 = 2, that is at the stretches of the isochoric loading.
        let plane = answer
            .loadings
            .iter()
            .find(|own| own.title == "simple shear, plane strain");
        let plane = plane.expect("simple shear");
        let limit = plane.criteria[0].tension.limit.expect("a limit");
        assert!((limit - 2.0_f64.sqrt()).abs() < 1e-9, "{limit}");
        assert!((plane.tension_end.imposed - 9.9).abs() < 1e-12);
        let told = answer.to_string();
        assert!(
            told.contains("gamma > 0") && told.contains("1.41421"),
            "{told}"
        );
    }

    #[test]
    fn bars_of_a_row_do_not_touch() {
        let question = question(&["model=blatz-ko"], Mode::SimpleShear);
        let answer = question.answer().expect("an answer");
        let panel = &answer.figure(&Criterion::ALL[..MAX_CRITERIA]).panels[0];
        let mut heights: Vec<f64> = Vec::new();
        for layer in &panel.layers {
            if let Layer::Line(Line { points, width, .. }) = layer
                && *width == BAR
            {
                heights.extend(points.first().map(|point| point.1));
            }
        }
        heights.sort_by(f64::total_cmp);
        let pixels = panel.lines.expect("a height") * LINE / answer.loadings.len() as f64;
        for pair in heights.windows(2) {
            assert!((pair[1] - pair[0]) * pixels > BAR, "{heights:?}");
        }
    }
}
