//! Figure of the ranges in which criteria hold: horizontal bars, one panel for each loading.

use super::{CriteriaAnswer, CriterionAnswer, KinkAnswer, LoadingAnswer};
use crate::figure::{Axis, Color, Figure, Line, Panel, Rule, palette};
use onset::criteria::{Change, Criterion, Discontinuity};

/// Width of a bar, in pixels.
const BAR: f64 = 8.0;

impl CriteriaAnswer {
    /// Draws the intervals in which the criteria hold as bars.
    pub fn figure(&self) -> Figure {
        let figure = Figure::new(format!(
            "Where stability criteria hold: {}",
            super::sentence::title(&self.material)
        ))
        .caption(
            "Bars: stretches at which the criterion holds. Grey lines: it does not. Neither: there is no state, or the criterion is not \
             defined for the law. In simple shear γ = λ − 1/λ.",
        );
        self.loadings
            .iter()
            .fold(figure, |figure, loading| figure.with(self.panel(loading)))
    }

    fn panel(&self, loading: &LoadingAnswer) -> Panel {
        let [low, high] = self.range;
        let rows = loading.criteria.len() as f64;
        let names = loading
            .criteria
            .iter()
            .enumerate()
            .map(|(n, answer)| (rows - n as f64, answer.criterion.name()));
        let mut panel = Panel::new(
            loading.title,
            stretches(IMPOSED, low, high),
            Axis::linear("", (0.4, rows + 0.6)).ticks(names),
        );
        panel = panel.with(Rule::vertical(1.0));
        for (at, name) in loading.kinks.iter().map(mark) {
            let mark = Line::new(vec![(at, 0.4), (at, rows + 0.6)]);
            panel = panel.with(mark.color(palette::VERMILION).named(name));
        }
        for (n, answer) in loading.criteria.iter().enumerate() {
            if !answer.defined {
                continue;
            }
            let y = rows - n as f64;
            let ends = [loading.compression_end.stretch, loading.tension_end.stretch];
            let all = Line::new(vec![(ends[0], y), (ends[1], y)]);
            panel = panel.with(all.width(2.0).color(Color::hex(0xbbbbbb)));
            let (color, kind) = kind(answer.criterion);
            for (from, to) in held(answer, ends) {
                let bar = Line::new(vec![(from, y), (to, y)]);
                panel = panel.with(bar.width(BAR).color(color).named(kind));
            }
        }
        panel
    }
}

/// Position and name of the mark for a discontinuity of the law.
pub(super) fn mark(kink: &KinkAnswer) -> (f64, &'static str) {
    let name = match kink.kind {
        Discontinuity::StepOfEnergy => "step of the energy",
        Discontinuity::JumpOfStress => "jump of the stress",
        Discontinuity::KinkOfStress => "kink of the stress",
    };
    (kink.stretch, name)
}

/// Label of an axis of imposed stretches.
pub(super) const IMPOSED: &str = "imposed stretch λ (−)";

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

/// Color of a criterion's class of perturbations, and its name in the legend.
fn kind(criterion: Criterion) -> (Color, &'static str) {
    match criterion {
        Criterion::StrongEllipticity
        | Criterion::PlaneEllipticity
        | Criterion::BakerEricksen
        | Criterion::OrderedForces => (palette::BLUE, "plane waves"),
        Criterion::RankOneConvexity => (palette::SKY, "finite jumps"),
        Criterion::Hill | Criterion::HillRotationFree => {
            (palette::ORANGE, "incremental work under dead loads")
        }
        Criterion::Surface => (palette::SKY, "waves at free faces"),
        Criterion::Drucker | Criterion::DruckerAbaqus | Criterion::TrueStressMonotonicity => {
            (palette::GREEN, "stress work in logarithmic strain")
        }
        Criterion::LoadMaximum => (palette::VERMILION, "maximum of the load"),
    }
}

/// Intervals of stretch in which a criterion holds, between the ends of the path.
pub(super) fn held(answer: &CriterionAnswer, [low, high]: [f64; 2]) -> Vec<(f64, f64)> {
    let mut intervals = Vec::new();
    for (side, end) in [(&answer.compression, low), (&answer.tension, high)] {
        let mut from = answer.holds_in_reference.then_some(1.0);
        for change in &side.changes {
            match change.change {
                Change::Lost => intervals.extend(from.take().map(|from| (from, change.stretch))),
                Change::Regained => from = Some(change.stretch),
            }
        }
        intervals.extend(from.map(|from| (from, end)));
    }
    intervals.retain(|(from, to)| from != to);
    intervals
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

    /// Thick horizontal lines of a panel, which are its bars: height and ends.
    fn bars(panel: &Panel) -> Vec<(f64, [f64; 2])> {
        let lines = panel.layers.iter().filter_map(|layer| match layer {
            Layer::Line(line) if line.width > 2.0 => Some(&line.points),
            _ => None,
        });
        lines
            .map(|points| {
                (
                    points[0].1,
                    [points[0].0.min(points[1].0), points[0].0.max(points[1].0)],
                )
            })
            .collect()
    }

    fn question(law: &[&str]) -> Question {
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
        Question::new(&settings.material, range, &[Mode::Hydrostatic]).expect("a question")
    }

    #[test]
    fn bars_cover_exactly_the_states_in_which_the_criterion_holds() {
        for law in LAWS {
            let question = question(law);
            let answer = question.answer().expect("an answer");
            let card = question.card().expect("a card");
            for ((loading, panel), limits) in answer
                .loadings
                .iter()
                .zip(answer.figure().panels)
                .zip(&card.loadings)
            {
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
                let bars = bars(&panel);
                for (n, criterion) in loading.criteria.iter().enumerate() {
                    let y = (loading.criteria.len() - n) as f64;
                    let is_covered = |x: f64| {
                        bars.iter()
                            .any(|(height, ends)| *height == y && ends[0] <= x && x <= ends[1])
                    };
                    let of_card = limits.elliptic.iter().map(|(a, b)| [a.min(*b), a.max(*b)]);
                    if criterion.criterion == Criterion::StrongEllipticity {
                        let drawn: Vec<_> = bars
                            .iter()
                            .filter(|(height, _)| *height == y)
                            .map(|(_, ends)| *ends)
                            .collect();
                        assert_eq!(
                            drawn,
                            of_card.collect::<Vec<_>>(),
                            "{law:?} {}",
                            loading.title
                        );
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
                            // Finite jumps are searched up to the first loss only.
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
}
