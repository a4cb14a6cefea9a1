//! Where along a loading a criterion is lost, and regained.

use super::root::{bracket_zero, dip};
use super::{
    Criterion, Jump, JumpSearch, LARGEST_RATIO, LoadingPath, Measure, PathState, Witness,
    ratio_of_stretches,
};

/// A change of a criterion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(rename_all = "kebab-case")
)]
pub enum Change {
    /// It holds before, nearer to the reference, and not behind.
    Lost,
    /// It holds behind and not before.
    Regained,
}

/// A change along a loading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Lost or regained.
    pub change: Change,
    /// The stretch `lambda` at which it changes; 1 where it is lost with the first deformation.
    pub stretch: f64,
    /// Half of the width of the bracket of `ln lambda`.
    pub tolerance: f64,
    /// The perturbation on the side where the criterion does not hold.
    pub witness: Witness,
}

/// A criterion on one side of the reference: in tension or in compression.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Whether it holds in the reference.
    pub holds_at_start: bool,
    /// Its changes, nearest to the reference first.
    pub events: Vec<Event>,
}

impl Track {
    /// The stretch up to which the criterion holds from the reference on; `None` when it is not lost.
    pub fn limit(&self) -> Option<f64> {
        match self.holds_at_start {
            true => self.events.first().map(|event| event.stretch),
            false => Some(1.0),
        }
    }

    /// The perturbation at the limit.
    pub fn witness(&self) -> Option<&Witness> {
        self.events.first().map(|event| &event.witness)
    }
}

/// Width of the bracket of a change, in `ln lambda`.
const RESOLUTION: f64 = 1e-14;
/// Changes nearer to the reference, in `ln lambda`, count as in the reference.
const AT_REFERENCE: f64 = 1e-9;
/// Evaluations spent on the bottom of a dip.
const DIP_STEPS: usize = 48;

/// A criterion along one side of a path, in tension or in compression. `None` where it is not defined.
///
/// The states of the path are looked at, dips of the measure between them are followed, and each change of sign is refined to
/// rounding. Where principal stretches differ by a factor above 1e4 nothing is told. A criterion that is lost and regained between two states without a dip that shows is overlooked.
///
/// ```
/// use onset::material::BlatzKo;
/// use onset::criteria::{Lateral, Loading, LoadingPath, Mode, Criterion, Range, follow};
/// let law = BlatzKo::default();
/// let loading = Loading { mode: Mode::Uniaxial, lateral: Lateral::Free };
/// let path = LoadingPath::new(&law, true, loading, &Range::default())?;
/// let load = follow(&path, Criterion::LoadMaximum, true).and_then(|track| track.limit());
/// let waves = follow(&path, Criterion::StrongEllipticity, true).and_then(|track| track.limit());
/// // P = mu (lambda^(-1/2) - lambda^-3) is largest at 6^(2/5); stretches are lambda and lambda^(-1/4), so waves
/// // travel up to (2 + sqrt 3)^(4/5).
/// assert!((load.unwrap_or(0.0) - 6.0_f64.powf(0.4)).abs() < 1e-12);
/// assert!((waves.unwrap_or(0.0) - (2.0 + 3.0_f64.sqrt()).powf(0.8)).abs() < 1e-12);
/// # Ok::<(), onset::criteria::LoadingError>(())
/// ```
pub fn follow(path: &LoadingPath<'_>, criterion: Criterion, tension: bool) -> Option<Track> {
    let states = side(path, tension);
    let measures: Vec<Measure> = states
        .iter()
        .map(|state| criterion.measure(&path.ask(state)))
        .collect::<Option<_>>()?;
    let values: Vec<f64> = measures.iter().map(Measure::signed).collect();
    let mut value = |s: f64| Some(criterion.measure(&path.state(s)?)?.signed());
    let parameter = |n: usize| states[n].parameter;
    let mut knots: Vec<(f64, f64)> = Vec::with_capacity(values.len());
    for n in 0..values.len() {
        // Where the sign can be rounding the criterion counts as before.
        if n == 0 {
            // Zero to rounding is not positive.
            let holds = measures[0].holds();
            knots.push((
                parameter(0),
                if holds { values[0] } else { values[0].min(0.0) },
            ));
        } else if measures[n].value.abs() > measures[n].rounding {
            knots.push((parameter(n), values[n]));
        }
        if n == 0 || n + 1 >= values.len() {
            continue;
        }
        let signs = [n - 1, n, n + 1].map(|n| values[n] > 0.0);
        if signs[0] != signs[1] || signs[1] != signs[2] {
            continue;
        }
        let own = if signs[1] { 1.0 } else { -1.0 };
        let (down, up) = (
            own * (values[n - 1] - values[n]),
            own * (values[n + 1] - values[n]),
        );
        if down >= 0.0 && up >= 0.0 && own * values[n] <= down.max(up) {
            let mut upright = |s: f64| Some(own * value(s)?);
            let found = dip(&mut upright, parameter(n - 1), parameter(n + 1), DIP_STEPS);
            if let Some((s, found)) = found.filter(|found| found.1.abs() > measures[n].rounding) {
                knots.push((s, own * found));
            }
        }
    }
    knots.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let holds_at_start = measures[0].holds();
    let mut events = Vec::new();
    for pair in knots.windows(2) {
        let holds = pair.iter().map(|knot| knot.1 > 0.0).collect::<Vec<_>>();
        if holds[0] == holds[1] {
            continue;
        }
        let (before, behind) = bracket_zero(&mut value, pair[0], pair[1], RESOLUTION);
        let lost = holds[0];
        let (place, knot) = if lost {
            (behind, pair[1].0)
        } else {
            (before, pair[0].0)
        };
        let state = path.state(place).or_else(|| path.state(knot))?;
        events.push(event(
            lost,
            before,
            behind,
            criterion.measure(&state)?.witness,
        ));
    }
    Some(Track {
        holds_at_start,
        events,
    })
}

fn side<'p>(path: &'p LoadingPath<'_>, tension: bool) -> &'p [PathState] {
    if tension {
        &path.tension
    } else {
        &path.compression
    }
}

fn event(lost: bool, before: f64, behind: f64, witness: Witness) -> Event {
    let middle = 0.5 * (before + behind);
    Event {
        change: if lost { Change::Lost } else { Change::Regained },
        stretch: if middle.abs() < AT_REFERENCE {
            1.0
        } else {
            middle.exp()
        },
        tolerance: 0.5 * (behind - before).abs(),
        witness,
    }
}

/// Every how many states of a path finite jumps are looked for.
const STRIDE: usize = 8;

/// Rank-one convexity along one side of a path: finite jumps are looked for at every eighth state up to the `elliptic` limit, where
/// infinitesimal ones gain energy, and the first one found is followed back to where it breaks even. Beyond the limit nothing is looked for.
///
/// Whether there are other jumps nearer to the reference is not proved: the limit is an upper bound. Where the best jump leads to the edge of the
/// reach, the limit depends on the reach, and is good to about 1e-3 only.
pub fn follow_jumps(
    path: &LoadingPath<'_>,
    elliptic: &Track,
    reach: (f64, f64),
    tension: bool,
) -> Track {
    let search = JumpSearch::new(path.material(), reach);
    let states = side(path, tension);
    let limit = elliptic
        .limit()
        .map_or(f64::INFINITY, |limit| limit.ln().abs());
    let inside = states
        .iter()
        .step_by(STRIDE)
        .filter(|state| state.parameter.abs() < limit)
        .filter(|state| ratio_of_stretches(&state.response) <= LARGEST_RATIO);
    let mut before = 0.0;
    for state in inside {
        let found = search.lowest(&state.response).filter(Jump::gains);
        let Some(jump) = found else {
            before = state.parameter;
            continue;
        };
        if state.parameter == 0.0 {
            return Track {
                holds_at_start: false,
                events: vec![event(true, 0.0, 0.0, jump.witness())],
            };
        }
        return Track {
            holds_at_start: true,
            events: vec![break_even(path, &search, before, (state.parameter, jump))],
        };
    }
    // Up to the limit of ellipticity no finite jump gains energy; there, small ones do.
    Track {
        holds_at_start: elliptic.holds_at_start,
        events: elliptic.events.first().copied().into_iter().collect(),
    }
}

/// Where a jump that gains energy at `behind`, and its like nearer to the reference, gains none.
fn break_even(
    path: &LoadingPath<'_>,
    search: &JumpSearch<'_>,
    mut before: f64,
    (mut behind, mut jump): (f64, Jump),
) -> Event {
    for _ in 0..60 {
        let middle = 0.5 * (before + behind);
        if (behind - before).abs() <= RESOLUTION || middle == before || middle == behind {
            break;
        }
        let followed = path
            .at(middle)
            .and_then(|state| search.descend(&state.response, &jump));
        match followed {
            Some(found) if found.gains() => (behind, jump) = (middle, found),
            _ => before = middle,
        }
    }
    event(true, before, behind, jump.witness())
}
