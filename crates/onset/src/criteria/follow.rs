//! Where along a loading a criterion is lost, and regained.

use super::root::{bracket_zero, dip};
use super::{
    Criterion, Jump, JumpSearch, LARGEST_RATIO, LoadingPath, Measure, PathState, Witness, kinks,
    ratio_of_stretches,
};
use crate::algebra::{Each, sort_by_value};
use nalgebra::Vector3;

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
    /// Half of the width of the bracket of `ln lambda`, or how far rounding of the measure or of the free stretches can move it, if that is more.
    pub tolerance: f64,
    /// Whether the criterion may be lost nearer to the reference: what was found there proves the loss, and nothing proves that it holds before.
    pub is_upper_bound: bool,
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

impl Event {
    /// The same as an upper bound of the distance from the reference.
    fn upper_bound(self) -> Self {
        Self {
            is_upper_bound: true,
            ..self
        }
    }
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
/// The step, in `ln lambda`, of the slope of a measure.
const SLOPE_STEP: f64 = 1e-5;
/// How near to the bottom of a dip is sought, in parts of the interval.
const DIP: f64 = 2e-11;

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
        } else if n + 1 == values.len()
            && path.ends_in_fold(tension)
            && values[n] <= measures[n].rounding
        {
            // What vanishes at a fold has changed its sign on the branch that leads back.
            knots.push((parameter(n), values[n].min(0.0)));
        } else if measures[n].value.abs() > measures[n].rounding {
            knots.push((parameter(n), values[n]));
        }
        if n == 0 || n + 1 >= values.len() {
            continue;
        }
        let signs = [n - 1, n, n + 1].each(|n| values[n] > 0.0);
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
            let mut around = [n - 1, n, n + 1].each(parameter);
            around.sort_by(f64::total_cmp);
            let tolerance = DIP * (around[2] - around[0]);
            let found = dip(&mut upright, around, own * values[n], tolerance);
            // What is lost must be told from rounding there.
            let told = found.filter(|(s, found)| {
                let there = path.state(*s).and_then(|state| criterion.measure(&state));
                there.is_some_and(|measure| found.abs() > measure.rounding)
            });
            knots.extend(told.map(|(s, found)| (s, own * found)));
        }
    }
    sort_by_value(&mut knots, |item| item.0.abs());
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
        let mut found = event(lost, before, behind, criterion.measure(&state)?.witness);
        found.tolerance = found
            .tolerance
            .max(undetermined(path, criterion, place, &mut value));
        events.push(found);
    }
    Some(Track {
        holds_at_start,
        events,
    })
}

/// How far rounding can move a change of sign at `s`, in `ln lambda`: what counts as zero of the measure, or how much it changes with the free stretches that
/// rounding leaves open, by the slope of the measure along the path.
fn undetermined(
    path: &LoadingPath<'_>,
    criterion: Criterion,
    s: f64,
    value: &mut impl FnMut(f64) -> Option<f64>,
) -> f64 {
    let Some(state) = path.at(s) else { return 0.0 };
    let own = match criterion.measure(&path.ask(&state)) {
        Some(measure) => measure,
        None => return 0.0,
    };
    let off = path.undetermined(&state);
    let changes = off.iter().filter_map(|state| criterion.measure(state));
    let noise = changes
        .map(|measure| (measure.signed() - own.signed()).abs())
        .fold(own.zero.max(own.neutral), f64::max);
    // The slope from within, where the criterion is sure to be asked.
    let step = SLOPE_STEP.min(0.5 * s.abs());
    let slope =
        value(s - step.copysign(s)).map_or(0.0, |before| (own.signed() - before).abs() / step);
    match noise > 0.0 && slope > 0.0 {
        true => (noise / slope).min(s.abs()),
        false => 0.0,
    }
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
        is_upper_bound: false,
        witness,
    }
}

/// Every how many states of a path finite jumps are looked for.
const STRIDE: usize = 8;
/// Parts of the way before the loss of ellipticity at which they are looked for too.
const BEFORE_LOSS: [f64; 4] = [0.02, 5e-3, 1e-3, 1e-5];
/// How often another family of jumps is looked for where the one that was followed gains nothing any more.
const FAMILIES: usize = 6;
/// Parts of a parameter by which the state is moved outward until intervals prove the gain.
const OUTWARD: i32 = 22;

/// Rank-one convexity along one side of a path: finite jumps are looked for at every eighth state up to the `elliptic` limit, where
/// infinitesimal ones gain energy, closely before it, and on both sides of jumps and kinks of the law ([`kinks`](super::kinks())): where the stress jumps back in the
/// sense of the stretch, jumps across gain energy before, and behind a step up of the energy those back. The first one found is followed back to where it breaks even, where others are looked
/// for in turn. Beyond the limit nothing is looked for.
///
/// Whether there are other jumps nearer to the reference is not proved: the limit is an upper bound of the distance from the reference up to
/// which the law is rank-one convex ([`Event::is_upper_bound`]); its tolerance is that of the jump which is named. At the limit the gain is proved in
/// intervals where the law knows them ([`JumpSearch::proves`]). Where the best jump leads to the edge of the reach, its largest stretch, the limit depends on
/// the reach.
pub fn follow_jumps(path: &LoadingPath<'_>, elliptic: &Track, reach: f64, tension: bool) -> Track {
    let jumps = Jumps {
        path,
        search: match path.is_incompressible() {
            true => JumpSearch::new(path.material(), reach).incompressible(),
            false => JumpSearch::new(path.material(), reach),
        },
        wave: elliptic.witness().and_then(|witness| match witness {
            Witness::Wave {
                direction,
                polarization,
            } => Some(((*direction).into(), (*polarization).into())),
            _ => None,
        }),
        beside_kinks: kinks(path).iter().flat_map(|kink| kink.sides).collect(),
    };
    let places = jumps.places(elliptic, tension);
    for (n, place) in places.iter().enumerate() {
        let Some(jump) = jumps.gaining(*place) else {
            continue;
        };
        if *place == 0.0 {
            let verified = path
                .at(0.0)
                .is_some_and(|state| jumps.search.proves(&state.response, &jump));
            return Track {
                holds_at_start: false,
                events: vec![event(true, 0.0, 0.0, jump.witness(verified)).upper_bound()],
            };
        }
        return jumps.break_even(&places[..n], (*place, jump));
    }
    // Up to the limit of ellipticity no finite jump gains energy; there, small ones do. What is regained is ellipticity alone.
    let first = elliptic.events.first().copied();
    Track {
        holds_at_start: elliptic.holds_at_start,
        events: first
            .filter(|event| event.change == Change::Lost)
            .map(Event::upper_bound)
            .into_iter()
            .collect(),
    }
}

/// Finite jumps along a path.
struct Jumps<'p, 'a> {
    path: &'p LoadingPath<'a>,
    search: JumpSearch<'a>,
    /// Direction and polarization of the wave at the loss of ellipticity.
    wave: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Parameters of the states closely beside jumps and kinks of the law.
    beside_kinks: Vec<f64>,
}

impl Jumps<'_, '_> {
    /// Parameters at which jumps are looked for, the reference first.
    fn places(&self, elliptic: &Track, tension: bool) -> Vec<f64> {
        let limit = elliptic.limit().map(f64::ln);
        let within = |s: f64| limit.is_none_or(|limit| s.abs() < limit.abs());
        let along = side(self.path, tension)
            .iter()
            .step_by(STRIDE)
            .filter(|state| ratio_of_stretches(&state.response) <= LARGEST_RATIO)
            .map(|state| state.parameter);
        let before = limit.into_iter().flat_map(|limit| {
            BEFORE_LOSS
                .into_iter()
                .map(move |part| limit * (1.0 - part))
        });
        let kinks = self.beside_kinks.iter().copied();
        let kinks = kinks.filter(|s| (*s > 0.0) == tension);
        let places = along.chain(before).chain(kinks);
        let mut places: Vec<f64> = places.filter(|s| within(*s)).collect();
        sort_by_value(&mut places, |place| place.abs());
        places.dedup();
        places
    }

    /// A jump that gains energy at a place, as far as the search tells.
    fn gaining(&self, s: f64) -> Option<Jump> {
        let state = self.path.at(s)?;
        let found = self.search.lowest_beside(&state.response, self.wave);
        let is_beside = self.beside_kinks.contains(&s);
        found.filter(Jump::gains).or_else(|| {
            let longest = is_beside.then(|| self.search.longest(&state.response));
            longest.flatten()
        })
    }

    /// The same in the valley of another jump.
    fn followed(&self, s: f64, jump: &Jump) -> Option<Jump> {
        let state = self.path.at(s)?;
        let found = self.search.descend(&state.response, jump);
        found.filter(Jump::gains)
    }

    /// From a place at which a jump gains energy back to where none does that is found; `places` lie before it.
    fn break_even(&self, places: &[f64], (mut behind, mut jump): (f64, Jump)) -> Track {
        let mut before = 0.0;
        for _ in 0..FAMILIES {
            before = 0.0;
            for place in places.iter().rev() {
                if place.abs() >= behind.abs() {
                    continue;
                }
                match self.followed(*place, &jump) {
                    Some(found) => (behind, jump) = (*place, found),
                    None => {
                        before = *place;
                        break;
                    }
                }
            }
            for _ in 0..60 {
                let middle = 0.5 * (before + behind);
                if (behind - before).abs() <= RESOLUTION || middle == before || middle == behind {
                    break;
                }
                match self.followed(middle, &jump) {
                    Some(found) => (behind, jump) = (middle, found),
                    None => before = middle,
                }
            }
            let Some(other) = Some(before)
                .filter(|s| *s != 0.0)
                .and_then(|s| self.gaining(s))
            else {
                break;
            };
            (behind, jump) = (before, other);
        }
        let (place, jump, verified) = self.proved(behind, jump);
        Track {
            holds_at_start: behind != 0.0,
            events: vec![Event {
                tolerance: (place - before).abs().max(self.undetermined(place, &jump)),
                is_upper_bound: true,
                ..event(true, place, place, jump.witness(verified))
            }],
        }
    }

    /// How far rounding of the gain of a jump can move its limit, by the slope of the gain along the path.
    fn undetermined(&self, s: f64, jump: &Jump) -> f64 {
        let step = SLOPE_STEP.min(0.5 * s.abs());
        let beside = self.path.at(s - step.copysign(s));
        let beside = beside.and_then(|state| self.search.descend(&state.response, jump));
        let slope = beside.map_or(0.0, |beside| (beside.excess - jump.excess) / step);
        match slope > 0.0 {
            true => (jump.rounding / slope).min(s.abs()),
            false => 0.0,
        }
    }

    /// The jump at the nearest place, a little further out if need be, at which intervals prove its gain; where they do not, the jump as it is.
    fn proved(&self, s: f64, jump: Jump) -> (f64, Jump, bool) {
        let mut last = jump;
        for n in 0..OUTWARD {
            let place = if n == 0 {
                s
            } else {
                s * (1.0 + 1e-14 * 2.0_f64.powi(n))
            };
            let Some(state) = self.path.at(place) else {
                break;
            };
            let Some(found) = self.search.descend(&state.response, &last) else {
                break;
            };
            if self.search.proves(&state.response, &found) {
                return (place, found, true);
            }
            last = found;
        }
        (s, jump, false)
    }
}
