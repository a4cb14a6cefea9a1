//! Ranges of notions as horizontal bars, a panel for each loading.

use super::{LoadingAnswer, NotionAnswer, NotionsAnswer};
use crate::figure::{Axis, Color, Figure, Line, Panel, Rule, palette};
use onset::notions::Notion;

/// Width of a bar, in pixels.
const BAR: f64 = 8.0;

impl NotionsAnswer {
    /// The ranges in which notions hold, as bars.
    pub fn figure(&self) -> Figure {
        let figure = Figure::new(format!(
            "Where notions of stability hold: {}",
            super::sentence::heading(&self.material)
        ))
        .caption(
            "Bars: stretches at which the notion holds. Grey: it does not. Nothing: there is no state, or the notion is not \
             defined for the law.",
        );
        self.loadings
            .iter()
            .fold(figure, |figure, loading| figure.with(self.panel(loading)))
    }

    fn panel(&self, loading: &LoadingAnswer) -> Panel {
        let [low, high] = self.range;
        let rows = loading.notions.len() as f64;
        let names = loading
            .notions
            .iter()
            .enumerate()
            .map(|(n, answer)| (rows - n as f64, answer.notion.name()));
        let mut panel = Panel::new(
            loading.title,
            stretches(low, high),
            Axis::linear("", (0.4, rows + 0.6)).ticks(names),
        );
        panel = panel.with(Rule::vertical(1.0));
        for (n, answer) in loading.notions.iter().enumerate() {
            if !answer.defined {
                continue;
            }
            let y = rows - n as f64;
            let ends = [loading.compression_end.stretch, loading.tension_end.stretch];
            let all = Line::new(vec![(ends[0], y), (ends[1], y)]);
            panel = panel.with(all.width(2.0).color(Color::hex(0xbbbbbb)));
            let (color, kind) = kind(answer.notion);
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
    Axis::log("stretch λ (−)", (low, high)).ticks(shown.map(|x| (x, format!("{x}"))))
}

/// Color and word of what a notion perturbs with.
fn kind(notion: Notion) -> (Color, &'static str) {
    match notion {
        Notion::StrongEllipticity | Notion::PlaneEllipticity | Notion::BakerEricksen => {
            (palette::BLUE, "waves")
        }
        Notion::RankOneConvexity => (palette::SKY, "finite jumps"),
        Notion::Hill | Notion::PureStrain => (palette::ORANGE, "rates under dead loads"),
        Notion::Drucker | Notion::PrincipalDrucker => {
            (palette::GREEN, "stress work in logarithmic strain")
        }
        Notion::LoadMaximum => (palette::VERMILION, "the loading itself"),
    }
}

/// The stretches at which a notion holds, between the ends of a path.
pub(super) fn held(answer: &NotionAnswer, [low, high]: [f64; 2]) -> Vec<(f64, f64)> {
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
