//! Stretches along a loading at which a criterion begins or ceases to be violated.

use super::root::{bracket_zero, dip};
use super::{
    Criterion, Jump, JumpSearch, Kink, LARGEST_RATIO, LoadingPath, Measure, Witness, kinks,
    ratio_of_stretches,
};
use crate::algebra::{Each, sort_by_value};
use nalgebra::Vector3;

/// Direction in which a criterion changes along a loading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(rename_all = "kebab-case")
)]
pub enum Change {
    /// The criterion holds nearer to the reference configuration and fails beyond the stretch.
    Lost,
    /// The criterion fails nearer to the reference configuration and holds beyond the stretch.
    Regained,
}

/// Stretch along a loading at which a criterion begins or ceases to be violated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Whether the violation of the criterion begins or ends.
    pub change: Change,
    /// Stretch `lambda` of the change; 1 if the criterion is violated from the beginning of the deformation.
    pub stretch: f64,
    /// Half the width of the bracket of `ln lambda`, or the shift that rounding of the measure or of the free stretches can cause, if that is larger.
    pub tolerance: f64,
    /// Whether the criterion may be lost nearer to the reference configuration: the loss is proved at `stretch`, and nothing is proved nearer.
    pub is_upper_bound: bool,
    /// Perturbation on the side where the criterion fails.
    pub witness: Witness,
}

/// Changes of a criterion on one side of the reference configuration, in tension or in compression.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Whether the criterion holds in the reference configuration.
    pub holds_at_start: bool,
    /// Changes along the loading, nearest to the reference configuration first.
    pub events: Vec<Event>,
}

impl Event {
    /// Path parameter `s = ln lambda` of the change.
    fn place(&self) -> f64 {
        self.stretch.ln()
    }

    /// Marks the event as an upper bound of the distance from the reference configuration.
    fn upper_bound(self) -> Self {
        Self {
            is_upper_bound: true,
            ..self
        }
    }
}

impl Track {
    /// Stretch at the first violation of the criterion, counted from the reference configuration; `None` if it is not violated.
    pub fn limit(&self) -> Option<f64> {
        match self.holds_at_start {
            true => self.events.first().map(|event| event.stretch),
            false => Some(1.0),
        }
    }

    /// Perturbation at the first change; `None` if the criterion does not change.
    pub fn witness(&self) -> Option<&Witness> {
        self.events.first().map(|event| &event.witness)
    }
}

/// Width of the bracket of a change, in `ln lambda`.
const RESOLUTION: f64 = 1e-14;
/// Largest distance from the reference configuration, in `ln lambda`, of changes that count as changes at this configuration.
const AT_REFERENCE: f64 = 1e-9;
/// Smallest shift of a change by rounding that may have moved it away from the reference configuration, relative to its distance. A value that grows
/// with the square of the distance reaches a level at twice the ratio of level and slope.
const MOVED_FROM_REFERENCE: f64 = 0.4;
/// Finite-difference step of the slope of a measure, in `ln lambda`.
const SLOPE_STEP: f64 = 1e-5;
/// Largest step of this slope, relative to the distance from the reference configuration.
const RELATIVE_SLOPE_STEP: f64 = 0.1;
/// A slope is computed from changes of the excess of a jump that exceed its rounding by this factor.
const SIGNIFICANT: f64 = 4.0;
/// Distance beyond a kink, in `ln lambda`, at which the law beyond the kink is evaluated.
const BEHIND_KINK: f64 = 1e-10;
/// Tolerance of a local minimum, relative to the interval.
const DIP: f64 = 2e-11;

/// Follows a criterion along one side of a path, in tension or in compression. Returns `None` if the criterion is not defined there.
///
/// The criterion is evaluated at the states of the path, and local minima of the measure between the states are refined. Each change of sign is
/// bracketed to rounding, or to 1e-11 if the law integrates the path to a state. States whose principal stretches differ by a factor above 1e4 are
/// ignored. A criterion that is lost and regained between two states is overlooked unless the states show a local minimum. At a
/// [concave kink](super::Kink::is_concave) of the energy every criterion on increments is lost, and regained at the same stretch if it holds beyond
/// the kink.
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
    let states = path.side(tension);
    let measures: Vec<Measure> = states
        .iter()
        .map(|state| criterion.measure(&path.ask(state)))
        .collect::<Option<_>>()?;
    let values: Vec<f64> = measures.iter().map(Measure::signed).collect();
    let mut value = |s: f64| Some(criterion.measure(&path.state(s)?)?.signed());
    let parameter = |n: usize| states[n].parameter;
    let mut knots: Vec<(f64, f64)> = Vec::with_capacity(values.len());
    for n in 0..values.len() {
        // A sign within rounding does not count: the criterion keeps its previous state.
        if n == 0 {
            // A value that is zero to rounding does not count as positive.
            let holds = measures[0].holds();
            knots.push((
                parameter(0),
                if holds { values[0] } else { values[0].min(0.0) },
            ));
        } else if n + 1 == values.len()
            && path.ends_in_fold(tension)
            && values[n] <= measures[n].rounding
        {
            // A measure that vanishes at a fold has changed its sign on the branch that leads back.
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
            let tolerance = path.flat_to(DIP) * (around[2] - around[0]);
            let found = dip(&mut upright, around, own * values[n], tolerance);
            // A local minimum counts as a violation only if its value exceeds rounding.
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
        let (before, behind) =
            bracket_zero(&mut value, pair[0], pair[1], path.resolved(RESOLUTION));
        let lost = holds[0];
        let (place, knot) = if lost {
            (behind, pair[1].0)
        } else {
            (before, pair[0].0)
        };
        let state = path.state(place).or_else(|| path.state(knot))?;
        let mut found = event(lost, before, behind, criterion.measure(&state)?.witness);
        let undetermined = undetermined(path, criterion, place, &mut value);
        // Rounding that shifts the change this far may have moved it away from the reference configuration, unless the criterion holds between.
        let mut between = states
            .iter()
            .zip(&measures)
            .filter(|(state, _)| state.parameter.abs() < place.abs());
        let holds_between =
            between.any(|(_, measure)| measure.value > measure.rounding.max(measure.zero));
        if undetermined >= MOVED_FROM_REFERENCE * place.abs() && !holds_between {
            found.stretch = 1.0;
        }
        found.tolerance = found.tolerance.max(undetermined);
        events.push(found);
    }
    lose_at_concave_kinks(path, criterion, tension, holds_at_start, &mut events);
    Some(Track {
        holds_at_start,
        events,
    })
}

/// Adds the concave kinks of the energy at which a criterion on increments fails although it holds on both sides, because the stress drops there.
fn lose_at_concave_kinks(
    path: &LoadingPath<'_>,
    criterion: Criterion,
    tension: bool,
    holds_at_start: bool,
    events: &mut Vec<Event>,
) {
    for kink in kinks(path).iter().filter(|kink| kink.is_concave) {
        let place = kink.near_side();
        if (place > 0.0) != tension {
            continue;
        }
        let state = path.state(place);
        let Some(witness) = state.and_then(|state| criterion.across(&state, &kink.first_piola))
        else {
            continue;
        };
        // Changes at the kink itself are replaced by the changes that follow from both sides.
        events.retain(|event| (event.place() - place).abs() > BEHIND_KINK);
        let before = events
            .iter()
            .filter(|event| event.place().abs() < place.abs());
        let last = before.max_by(|a, b| a.place().abs().total_cmp(&b.place().abs()));
        let held = last.map_or(holds_at_start, |last| last.change == Change::Regained);
        let behind = path.state(place + BEHIND_KINK.copysign(place));
        let behind = behind.and_then(|state| criterion.measure(&state));
        let [low, high] = kink.sides;
        let lost = held.then(|| event(true, low, high, witness));
        let regained = behind
            .filter(Measure::holds)
            .map(|_| event(false, low, high, witness));
        events.extend(lost.into_iter().chain(regained));
    }
    // The order of events at the same position is kept.
    sort_by_value(events, |event| event.place().abs());
}

/// Shift of a change of sign at `s`, in `ln lambda`, that rounding can cause.
///
/// It is the value that counts as zero, or the change of the measure within the rounding of the free stretches, divided by the slope of the measure
/// along the path.
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
    // The larger of the slopes on both sides: a neutral criterion is flat before its loss, and the path may end at it.
    let step = SLOPE_STEP.min(RELATIVE_SLOPE_STEP * s.abs());
    let slopes = [-step, step].into_iter().filter_map(|step| {
        value(s + step.copysign(step * s)).map(|there| ((own.signed() - there) / step).abs())
    });
    let slope = slopes.fold(0.0, f64::max);
    match noise > 0.0 && slope > 0.0 {
        true => (noise / slope).min(s.abs()),
        false => 0.0,
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

/// Number of states of a path between two searches for finite jumps.
const STRIDE: usize = 8;
/// Fractions of the way to the loss of ellipticity at which finite jumps are also searched for.
const BEFORE_LOSS: [f64; 4] = [0.02, 5e-3, 1e-3, 1e-5];
/// Additional searches before a drop of the stress, in units of the distance at which the energy gain of a jump across it vanishes for a law that is
/// linear on both sides. Halfway to the drop such a jump usually lowers the energy.
const BEFORE_DROP: [f64; 3] = [0.9, 0.5, 0.1];
/// Amplitudes at which descents across a drop of the stress start, relative to the best amplitude at the distance at which the gain vanishes.
const ACROSS_DROP: [f64; 3] = [1.0, 0.5, 0.2];
/// Largest number of changes to another family of jumps once no jump of the current family lowers the energy.
const FAMILIES: usize = 6;
/// Largest number of growing outward steps to a state at which interval arithmetic proves that the jump lowers the energy.
const OUTWARD: i32 = 22;

/// Follows rank-one convexity along one side of a path. The limit found is an upper bound ([`Event::is_upper_bound`]).
///
/// Finite jumps are searched for at every eighth state up to the `elliptic` limit (infinitesimal jumps lower the energy there), closely before that
/// limit, and on both sides of jumps and kinks of the law ([`kinks`](super::kinks())). Before a drop of the stress along the loading, jumps across
/// the drop lower the energy; the search begins with the best jumps for a law that is linear on both sides of the drop. Beyond an upward step of the
/// energy, backward jumps lower the energy. The first jump found is followed back to its break-even point, where the search is repeated for other
/// families. No search takes place beyond the limit.
///
/// Other jumps may lower the energy nearer to the reference configuration, so the limit is an upper bound of the distance up to which the law is
/// rank-one convex. Its tolerance refers to the reported jump. Interval arithmetic proves that this jump lowers the energy at the limit if the law
/// provides enclosures ([`JumpSearch::proves`]). If the best jump reaches the largest admitted stretch, the limit depends on this stretch.
pub fn follow_jumps(path: &LoadingPath<'_>, elliptic: &Track, reach: f64, tension: bool) -> Track {
    let mut search = JumpSearch::new(path.material(), reach);
    if path.keeps_volume() {
        search = search.incompressible();
    }
    if path.is_isotropic() {
        search = search.isotropic();
    }
    let jumps = Jumps {
        path,
        search,
        wave: elliptic.witness().and_then(|witness| match witness {
            Witness::Wave {
                direction,
                polarization,
            } => Some(((*direction).into(), (*polarization).into())),
            _ => None,
        }),
        beside_kinks: kinks(path).iter().flat_map(|kink| kink.sides).collect(),
        drops: kinks(path)
            .iter()
            .filter_map(|kink| Drop::of(path, kink))
            .collect(),
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
    // No finite jump lowers the energy up to the limit of ellipticity, where infinitesimal jumps do. Beyond it only ellipticity can be regained.
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

/// Search for finite jumps along a path.
struct Jumps<'p, 'a> {
    path: &'p LoadingPath<'a>,
    search: JumpSearch<'a>,
    /// Direction and polarization of the wave at the loss of ellipticity.
    wave: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Parameters of the states on both sides of the jumps and kinks of the law.
    beside_kinks: Vec<f64>,
    /// Drops of the stress along the path.
    drops: Vec<Drop>,
}

/// Drop of the stress at a concave kink, with the jump across it that lowers the energy most if the law is linear on both sides.
///
/// At a distance `d` before the drop the jump `a (x) N` lowers the energy by `-[P] : (a (x) N) - a . Q(N) a / 2 - c d`, where `c d` is the work of
/// the drop over the distance. The best amplitude is `a = -Q(N)^-1 [P] N`, and the gain vanishes at the distance at which `c d` equals half of `-[P]
/// : (a (x) N)`.
struct Drop {
    /// Parameter of the kink.
    place: f64,
    /// Distance in the parameter at which the gain vanishes.
    distance: f64,
    amplitude: Vector3<f64>,
    direction: Vector3<f64>,
}

impl Drop {
    fn of(path: &LoadingPath<'_>, kink: &Kink) -> Option<Self> {
        let place = Some(kink.near_side()).filter(|_| kink.is_concave)?;
        let state = path.at(place)?;
        let (gain, direction, amplitude) = path
            .ask(&state)
            .best_jump_across(&kink.first_piola, false)?;
        let distance = gain * state.pace() / -kink.first_piola.dot(&state.rate);
        (distance > 0.0 && distance.is_finite()).then_some(Self {
            place,
            distance,
            amplitude,
            direction,
        })
    }

    /// Returns true if jumps across the drop may lower the energy at a parameter.
    fn is_near(&self, s: f64) -> bool {
        (s > 0.0) == (self.place > 0.0)
            && s.abs() <= self.place.abs()
            && (s - self.place).abs() < 2.0 * self.distance
    }
}

impl Jumps<'_, '_> {
    /// Parameters at which finite jumps are searched for, starting at the reference configuration.
    fn places(&self, elliptic: &Track, tension: bool) -> Vec<f64> {
        let limit = elliptic.limit().map(f64::ln);
        let within = |s: f64| limit.is_none_or(|limit| s.abs() < limit.abs());
        let along = self
            .path
            .side(tension)
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
        let drops = self.drops.iter();
        let drops = drops.filter(|drop| (drop.place > 0.0) == tension);
        let drops = drops.flat_map(|drop| {
            let toward = drop.distance.copysign(drop.place);
            BEFORE_DROP.map(|part| drop.place - part * toward)
        });
        let drops = drops.filter(|s| (*s > 0.0) == tension);
        let places = along.chain(before).chain(kinks).chain(drops);
        let mut places: Vec<f64> = places.filter(|s| within(*s)).collect();
        sort_by_value(&mut places, |place| place.abs());
        places.dedup();
        places
    }

    /// Returns a jump at `s` that lowers the energy, if the search finds one.
    fn gaining(&self, s: f64) -> Option<Jump> {
        let state = self.path.at(s)?;
        let found = self.search.lowest_beside(&state.response, self.wave);
        let is_beside = self.beside_kinks.contains(&s);
        let drops = self.drops.iter().filter(|drop| drop.is_near(s));
        let across = drops.flat_map(|drop| {
            ACROSS_DROP.map(|part| {
                let amplitude = drop.amplitude * part;
                self.search
                    .descend_from(&state.response, amplitude, &drop.direction)
            })
        });
        let found = found
            .into_iter()
            .chain(across.flatten())
            .min_by(|a, b| a.excess.total_cmp(&b.excess));
        found.filter(|jump| self.gains(&state, jump)).or_else(|| {
            let longest = is_beside.then(|| self.search.longest(&state.response));
            longest.flatten()
        })
    }

    /// Returns the jump at `s` in the valley of another jump, if it lowers the energy.
    fn followed(&self, s: f64, jump: &Jump) -> Option<Jump> {
        let state = self.path.at(s)?;
        let found = self.search.descend(&state.response, jump);
        self.gaining_of(&state, found, jump)
    }

    /// Returns the end of a descent from a jump if it lowers the energy, or else the jump across a step of the energy.
    fn gaining_of(
        &self,
        state: &super::PathState,
        found: Option<Jump>,
        jump: &Jump,
    ) -> Option<Jump> {
        let found = found.filter(|jump| self.gains(state, jump));
        found.or_else(|| {
            let has_step = !self.beside_kinks.is_empty();
            let across = has_step.then(|| self.search.across_step(&state.response, jump));
            across.flatten()
        })
    }

    /// Returns true if a jump lowers the energy by more than rounding, or provably. The estimate of rounding is far above the enclosures of most laws.
    fn gains(&self, state: &super::PathState, jump: &Jump) -> bool {
        jump.gains() || (jump.excess < 0.0 && self.search.proves(&state.response, jump))
    }

    /// Follows a jump that lowers the energy back to the state at which it no longer lowers the energy. The states at `places` are nearer to the
    /// reference configuration.
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
            (before, behind, jump) = self.bracketed(before, (behind, jump));
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

    /// Brackets the break-even point of a jump between a state at which the jump does not lower the energy and a state at which it does: the ends of the bracket, and the
    /// jump at its outer end.
    fn bracketed(&self, before: f64, (behind, jump): (f64, Jump)) -> (f64, f64, Jump) {
        // A gain below the estimate of rounding, which is proved, counts as itself.
        let gain = |jump: &Jump| match jump.excess + jump.rounding {
            loss if loss < 0.0 => loss,
            _ => jump.excess,
        };
        let mut last = (behind, jump);
        let mut value = |s: f64| {
            let state = self.path.at(s)?;
            let found = self.search.descend(&state.response, &last.1);
            // Without a jump that lowers the energy the value is positive. If the descent finds no jump at all, the gain of the given jump replaces the
            // unknown loss.
            let Some(gaining) = self.gaining_of(&state, found, &last.1) else {
                let lost = found.map_or(-gain(&jump), |found| found.excess + found.rounding);
                return Some(lost.max(f64::MIN_POSITIVE));
            };
            last = (s, gaining);
            Some(gain(&gaining))
        };
        let at_start = value(before).filter(|loss| *loss > 0.0);
        let start = (before, at_start.unwrap_or(-gain(&jump)));
        let end = (behind, gain(&jump));
        let (low, _) = bracket_zero(&mut value, start, end, RESOLUTION);
        (low, last.0, last.1)
    }

    /// Shift of the limit, in `ln lambda`, that rounding of the change of energy causes. It is the rounding divided by the slope of this change along the
    /// path, or the distance to the reference configuration if the change nowhere exceeds its rounding.
    fn undetermined(&self, s: f64, jump: &Jump) -> f64 {
        let mut shift = 0.0;
        let mut step = SLOPE_STEP.min(0.5 * s.abs());
        while step > 0.0 && step <= 0.5 * s.abs() {
            for side in [-1.0, 1.0] {
                let state = self.path.at(s + side * step.copysign(s));
                let beside = state.and_then(|own| self.search.descend(&own.response, jump));
                let Some(beside) = beside else { continue };
                let change = side * (jump.excess - beside.excess);
                if change > SIGNIFICANT * jump.rounding {
                    return (jump.rounding * step / change).min(s.abs());
                }
                shift = s.abs();
            }
            step *= 4.0;
        }
        shift
    }

    /// Moves the state outward in small steps until interval arithmetic proves that the jump lowers the energy. Returns the jump unchanged if no proof is found.
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
