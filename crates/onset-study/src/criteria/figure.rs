//! Ranges of criteria as horizontal bars, a panel for each loading.

use super::{CriteriaAnswer, CriterionAnswer, LoadingAnswer};
use crate::figure::{Axis, Color, Figure, Line, Panel, Rule, palette};
use onset::criteria::Criterion;

/// Width of a bar, in pixels.
const BAR: f64 = 8.0;

impl CriteriaAnswer {
    /// The ranges in which criteria hold, as bars.
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
            stretches(low, high),
            Axis::linear("", (0.4, rows + 0.6)).ticks(names),
        );
        panel = panel.with(Rule::vertical(1.0));
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

/// The axis of stretches, with ticks at round numbers.
pub(super) fn stretches(low: f64, high: f64) -> Axis {
    let round = [
        0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0,
        10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0,
    ];
    let wide = high / low > 30.0;
    let shown = round
        .into_iter()
        .filter(|x| (low..=high).contains(x))
        .filter(|x| !wide || ![0.3, 0.7, 1.5, 3.0].contains(x));
    Axis::log("imposed stretch λ (−)", (low, high)).ticks(shown.map(|x| (x, format!("{x}"))))
}

/// Color and word of what a criterion perturbs with.
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
        Criterion::Drucker
        | Criterion::DruckerAbaqus
        | Criterion::DruckerIncompressible
        | Criterion::TrueStressMonotonicity => {
            (palette::GREEN, "stress work in logarithmic strain")
        }
        Criterion::LoadMaximum => (palette::VERMILION, "maximum of the load"),
    }
}

/// The stretches at which a criterion holds, between the ends of a path.
pub(super) fn held(answer: &CriterionAnswer, [low, high]: [f64; 2]) -> Vec<(f64, f64)> {
    let mut intervals = Vec::new();
    for (side, end) in [(&answer.compression, low), (&answer.tension, high)] {
        let mut from = answer.holds_in_reference.then_some(1.0);
        for change in &side.changes {
            match from.take() {
                Some(start) => intervals.push((start, change.stretch)),
                None => from = Some(change.stretch),
            }
        }
        if let Some(start) = from {
            intervals.push((start, end));
        }
    }
    intervals
}
