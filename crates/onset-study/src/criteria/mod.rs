//! Stability criteria of a law side by side: along which loading is which one lost, and where do they disagree?

mod card;
mod figure;
mod html;
mod sentence;

pub use card::{BoxAnswer, CardAnswer, CardError, Limits};
pub use onset::criteria::{Lateral, Mode, Range};

use crate::answers::{Evidence, moduli, notes_on_law};
use crate::number;
use crate::settings::{MaterialSettings, Value};
use onset::criteria::{
    Change, Criterion, Discontinuity, Event, Kink, Knowledge, Loading, LoadingError, LoadingPath,
    PathEnd, PathState, Track, Witness, follow, follow_jumps, has_energy, is_isotropic, kinks,
    polyconvexity,
};
use onset::material::{Hyperelastic, MaterialError, Membrane};
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use thiserror::Error;

/// Why a law cannot be asked.
#[derive(Debug, Error)]
pub enum CriteriaError {
    /// The law.
    #[error("{0}")]
    Material(#[from] MaterialError),
    /// A law whose incompressible response is not known.
    #[error(
        "{law} is not isotropic; expected an isotropic law beside --incompressible\n  hint: leave --incompressible out, a large bulk modulus comes near to it"
    )]
    NotIsotropic {
        /// Its name.
        law: String,
    },
    /// A law without an energy, of which no volumetric part can be told.
    #[error(
        "{law} has no energy, so that its incompressible response is not known; expected a law with one beside --incompressible\n  hint: leave --incompressible out, a large bulk \
         modulus comes near to it"
    )]
    NoEnergy {
        /// Its name.
        law: String,
    },
    /// No loading that keeps the volume.
    #[error(
        "an incompressible material keeps its volume; expected --mode uniaxial, equibiaxial, planar or simple-shear"
    )]
    ChangesVolume,
    /// A metal whose own axes the loadings are not along.
    #[error(
        "{law} {how}: each of some ten thousand states would be integrated along a path of its own, for minutes; expected loadings along the \
         axes of the metal, material.angle = 0 or 90, without simple shear\n  hint: `onset path --mode uniaxial` follows a single loading at any angle"
    )]
    Turned {
        /// Its name.
        law: &'static str,
        /// What turns.
        how: String,
    },
    /// A loading of it.
    #[error("{title}: {source}{}{}", hint(source), told(notes))]
    Loading {
        /// Which one.
        title: &'static str,
        /// What is wrong.
        source: LoadingError,
        /// What is known of the law that may be why.
        notes: Vec<String>,
    },
}

/// What to do where a law has no numbers.
fn hint(error: &LoadingError) -> &'static str {
    match error {
        LoadingError::Law(_) => {
            "\n  hint: choose constants of the law, or a --range, with which it has numbers"
        }
        LoadingError::NoReference | LoadingError::ChangesVolume => "",
    }
}

/// Notes as they follow a text.
fn told(notes: &[String]) -> String {
    let lines = notes.iter().map(|note| format!("\n  note: {note}"));
    lines.collect()
}

/// A law as asked for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawAnswer {
    /// Its name.
    pub model: String,
    /// What it is called where its energy is a table's, too long to be told in a title.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its parameters, and what else it is made of, in the order of its documentation.
    #[serde(serialize_with = "as_map")]
    pub parameters: Vec<(String, serde_json::Value)>,
    /// The units of those that have one.
    pub units: BTreeMap<String, &'static str>,
    /// Whether it is isotropic, found out by turning the reference.
    pub isotropic: bool,
    /// Whether its incompressible response is asked.
    pub incompressible: bool,
    /// Whether it is a law of the plane, of two dimensions.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub in_plane: bool,
    /// Shear and bulk modulus at small strains; `null` of a law that is not isotropic or has stress at `F = 1`.
    pub moduli: Option<[f64; 2]>,
    /// What a reader must know of it.
    pub notes: Vec<String>,
}

/// What is known about polyconvexity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PolyconvexityAnswer {
    /// What is known.
    pub knowledge: Knowledge,
    /// Why.
    pub reason: String,
    /// Where it is proved.
    pub source: String,
}

/// A criterion as asked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Definition {
    /// Its name.
    pub criterion: Criterion,
    /// What it demands.
    pub definition: &'static str,
    /// Where it is from.
    pub source: &'static str,
    /// What its limits are where they are not exact.
    pub note: Option<&'static str>,
}

/// What a limit of rank-one convexity is.
const UPPER_BOUND: &str = "a limit is an upper bound of the distance from the reference: jumps that gain energy earlier may exist and not have been \
                           found (so the signs ≤ and ≥); at the limit the jump that is named gains energy";

/// The answer: every criterion along every loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CriteriaAnswer {
    /// The law.
    pub material: LawAnswer,
    /// The smallest and the largest stretch looked at.
    pub range: [f64; 2],
    /// What is known about polyconvexity.
    pub polyconvexity: PolyconvexityAnswer,
    /// What the criteria demand.
    pub criteria: Vec<Definition>,
    /// The loadings.
    pub loadings: Vec<LoadingAnswer>,
    /// How sure the limits are: `searched`.
    pub evidence: Evidence,
    /// Where criteria disagree, in words.
    pub disagreements: Vec<String>,
}

/// Every criterion along a loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoadingAnswer {
    /// What is imposed.
    pub mode: Mode,
    /// What holds the other directions.
    pub lateral: Lateral,
    /// In a few words.
    pub title: &'static str,
    /// Where the path ends in compression, and why.
    pub compression_end: EndAnswer,
    /// Where the path ends in tension, and why.
    pub tension_end: EndAnswer,
    /// States with the same imposed stretch and other free stretches, where some were met.
    pub other_states: Vec<OtherState>,
    /// Stretches at which energy, stress or tangent jump, nearest to the reference first.
    pub kinks: Vec<KinkAnswer>,
    /// The criteria.
    pub criteria: Vec<CriterionAnswer>,
}

/// A jump of energy, stress or tangent, counted from the smaller stretch to the larger one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct KinkAnswer {
    /// The imposed stretch.
    pub stretch: f64,
    /// The first of energy, stress and tangent that jumps.
    pub kind: Discontinuity,
    /// The size of that jump by that of the tangent.
    pub jump: f64,
    /// The jump of the energy. Units of stress.
    pub energy: f64,
    /// The largest component of the jump of the Cauchy stress. Units of stress.
    pub largest_stress: f64,
    /// The jump of the mean Cauchy stress. Units of stress.
    pub mean_stress: f64,
    /// The jump of the second derivative of the energy by `J` at a constant shape. Units of stress.
    pub bulk_tangent: f64,
}

impl KinkAnswer {
    fn of(kink: &Kink) -> Self {
        let &Kink {
            stretch,
            kind,
            jump,
            energy,
            largest_stress,
            mean_stress,
            bulk_tangent,
            ..
        } = kink;
        Self {
            stretch,
            kind,
            jump,
            energy,
            largest_stress,
            mean_stress,
            bulk_tangent,
        }
    }
}

/// The end of a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EndAnswer {
    /// The last stretch.
    pub stretch: f64,
    /// Whether it is a fold, the limit point of the equilibrium of the free faces.
    pub fold: bool,
    /// Why the path leads no further; `null` at the end of the range.
    pub reason: Option<String>,
}

/// What ends a path at a fold.
const FOLD: &str =
    "a fold (limit point): beyond it the free faces have no equilibrium nearby (dynamic jump)";

/// A second state with free faces.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OtherState {
    /// The imposed stretch.
    pub stretch: f64,
    /// `F_iJ`.
    pub deformation_gradient: [[f64; 3]; 3],
}

/// A criterion along a loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CriterionAnswer {
    /// Which one.
    pub criterion: Criterion,
    /// Whether it is defined for this law.
    pub defined: bool,
    /// Whether it holds in the reference.
    pub holds_in_reference: bool,
    /// Below stretch 1.
    pub compression: SideAnswer,
    /// Above stretch 1.
    pub tension: SideAnswer,
}

/// A criterion on one side of the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SideAnswer {
    /// The stretch at which it is lost, counted from the reference; `null` when it is not.
    pub limit: Option<f64>,
    /// Whether it may be lost nearer to the reference: the loss at the limit is shown, and nothing shows that it holds before.
    pub upper_bound: bool,
    /// All changes, nearest to the reference first.
    pub changes: Vec<ChangeAnswer>,
}

/// A change of a criterion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChangeAnswer {
    /// Lost or regained.
    pub change: Change,
    /// The imposed stretch.
    pub stretch: f64,
    /// Half of the width of its bracket, relative, or how far rounding can move it; of an upper bound that of the perturbation which is named.
    pub tolerance: f64,
    /// The nominal strain there: `lambda - 1`, in simple shear the amount of shear.
    pub nominal_strain: f64,
    /// The nominal stress there, force by reference area: `P_11`, in simple shear `P_12`. Units of stress.
    pub nominal_stress: f64,
    /// The perturbation that tells.
    pub witness: Witness,
    /// `F_iJ` there.
    pub deformation_gradient: [[f64; 3]; 3],
}

/// Why simple shear is not among the loadings of a metal unless it is asked for.
const SHEAR_LEFT_OUT: &str = "simple shear is left out: its principal axes turn, so that the proportional path to a state is not the loading itself, and each state \
                              takes long; --mode simple-shear asks for it";
/// Why it never is of a metal that has axes of its own.
const SHEAR_OF_AXES: &str = "simple shear is left out: its principal axes turn against those of the metal, so that each state is integrated along a path of its \
                             own, which takes minutes";

/// Refuses loadings that turn a metal's principal axes against its own.
fn along_axes(settings: &MaterialSettings, modes: &[Mode]) -> Result<(), CriteriaError> {
    let refused = |how: String| CriteriaError::Turned {
        law: settings.model.name(),
        how,
    };
    let values = settings.values();
    let angle = values.iter().find(|(name, _)| *name == "angle");
    match angle {
        Some((_, angle)) if angle.rem_euclid(90.0) != 0.0 => Err(refused(format!(
            "with its axes at {} deg",
            number::told(*angle)
        ))),
        _ if modes.contains(&Mode::SimpleShear) => Err(refused("in simple shear".to_owned())),
        _ => Ok(()),
    }
}

/// A law with what is to be asked.
pub struct Question {
    law: LawAnswer,
    material: Box<dyn Hyperelastic>,
    /// Whether its stress follows from the energy that it gives; what a metal stores elastically is none once it flows.
    has_energy: bool,
    range: Range,
    loadings: Vec<Loading>,
}

impl Question {
    /// A law over a range of stretches, in some modes; all of them when none is named.
    ///
    /// # Errors
    /// [`CriteriaError`] when a parameter is out of range.
    pub fn new(
        settings: &MaterialSettings,
        range: Range,
        modes: &[Mode],
    ) -> Result<Self, CriteriaError> {
        let in_plane = settings.is_membrane();
        let material: Box<dyn Hyperelastic> = match in_plane {
            true => Box::new(Membrane::new(settings.build()?.into())),
            false => settings.build()?,
        };
        let parameters = settings.entries().into_iter();
        let has_unit = |name: &str| Some((name.to_owned(), settings.unit(name)?));
        let units = settings.entries().into_iter();
        let turns = material.is_path_dependent() && !settings.is_library();
        // A metal may be isotropic where it does not flow yet.
        let has_axes = turns && !settings.model.is_isotropic();
        if has_axes {
            along_axes(settings, modes)?;
        }
        let isotropic = !in_plane && !has_axes && is_isotropic(&*material);
        let has = |mode: Mode| match modes.is_empty() {
            true => !(turns && mode == Mode::SimpleShear),
            false => modes.contains(&mode),
        };
        let asked = |loading: &Loading| {
            let is_told_twice =
                isotropic && loading.is_planar_tension_of_axis_2() && has(Mode::Planar);
            has(loading.mode) && !is_told_twice
        };
        let mut notes = notes_on_law(settings, &*material);
        if turns && modes.is_empty() {
            let why = if has_axes {
                SHEAR_OF_AXES
            } else {
                SHEAR_LEFT_OUT
            };
            notes.push(why.to_owned());
        }
        Ok(Self {
            law: LawAnswer {
                model: settings.model.name().to_owned(),
                name: None,
                parameters: parameters
                    .map(|(name, value)| (name.to_owned(), document(value)))
                    .collect(),
                units: units.filter_map(|(name, _)| has_unit(name)).collect(),
                isotropic,
                incompressible: false,
                in_plane,
                moduli: moduli(&*material),
                notes,
            },
            has_energy: !turns && has_energy(&*material),
            material,
            range,
            loadings: match in_plane {
                true => Loading::IN_PLANE.into_iter().filter(asked).collect(),
                false => Loading::ALL.into_iter().filter(asked).collect(),
            },
        })
    }

    /// With a name of its own for the law.
    pub fn with_name(mut self, name: Option<String>) -> Self {
        self.law.name = name;
        self
    }

    /// With more that a reader must know of the law.
    pub fn with_notes(mut self, notes: Vec<String>) -> Self {
        self.law.notes.extend(notes);
        self
    }

    /// The same question of the incompressible response of the law: its volumetric part does not count, the pressure follows from a free face.
    ///
    /// # Errors
    /// [`CriteriaError::NotIsotropic`] of a law that is not isotropic, [`CriteriaError::NoEnergy`] of one whose stress depends on the path, [`CriteriaError::ChangesVolume`] when none of the modes keeps the volume.
    pub fn incompressible(mut self) -> Result<Self, CriteriaError> {
        if !self.law.isotropic {
            return Err(CriteriaError::NotIsotropic {
                law: self.law.model,
            });
        }
        if self.material.is_path_dependent() {
            return Err(CriteriaError::NoEnergy {
                law: self.law.model,
            });
        }
        let asked = |loading: &Loading| self.loadings.iter().any(|own| own.mode == loading.mode);
        self.loadings = Loading::INCOMPRESSIBLE.into_iter().filter(asked).collect();
        if self.loadings.is_empty() {
            return Err(CriteriaError::ChangesVolume);
        }
        self.law.incompressible = true;
        Ok(self)
    }

    /// Returns true for a law of the plane.
    fn is_in_plane(&self) -> bool {
        self.material.dimension() == 2
    }

    fn title(&self, loading: Loading) -> &'static str {
        match self.is_in_plane() {
            true => loading.title_in_plane(),
            false => loading.title(),
        }
    }

    /// The criteria with an answer: true stress and Kirchhoff stress are one in incompressible response, whose surfaces have a criterion.
    fn criteria(&self) -> Vec<Criterion> {
        let left_out: &[Criterion] = match self.law.incompressible {
            true => &[Criterion::TrueStressMonotonicity],
            false if self.is_in_plane() => &[
                Criterion::Surface,
                Criterion::PlaneEllipticity,
                Criterion::BakerEricksen,
                Criterion::OrderedForces,
            ],
            false => &[Criterion::Surface],
        };
        let mut criteria = Criterion::ALL.to_vec();
        criteria.retain(|criterion| !left_out.contains(criterion));
        criteria
    }

    /// Every criterion along every loading.
    ///
    /// # Errors
    /// [`CriteriaError`] when the law has no state in the reference.
    pub fn answer(&self) -> Result<CriteriaAnswer, CriteriaError> {
        let criteria = self.criteria();
        let loadings: Vec<LoadingAnswer> = self
            .loadings
            .par_iter()
            .map(|loading| self.along(*loading, &criteria))
            .collect::<Result<_, _>>()?;
        let definition = |criterion: Criterion| Definition {
            criterion,
            definition: criterion.definition(),
            source: criterion.source(),
            note: (criterion == Criterion::RankOneConvexity).then_some(UPPER_BOUND),
        };
        Ok(CriteriaAnswer {
            material: self.law.clone(),
            range: [self.range.low(), self.range.high()],
            polyconvexity: self.polyconvexity(&loadings),
            criteria: criteria.into_iter().map(definition).collect(),
            evidence: Evidence::Searched,
            disagreements: sentence::disagreements(&loadings),
            loadings,
        })
    }

    fn polyconvexity(&self, loadings: &[LoadingAnswer]) -> PolyconvexityAnswer {
        let parameters: Vec<(&str, f64)> = self
            .law
            .parameters
            .iter()
            .filter_map(|(name, value)| Some((name.as_str(), value.as_f64()?)))
            .collect();
        let known = polyconvexity(&self.law.model, &parameters);
        let refuted = loadings
            .iter()
            .find_map(|loading| Some((loading.title, loading.refutes_polyconvexity()?)));
        // What refutes it may be the volumetric part.
        let is_of_volume = self.law.incompressible && known.knowledge == Knowledge::NotPolyconvex;
        let knowledge = match is_of_volume {
            true => Knowledge::Unknown,
            false => known.knowledge,
        };
        match (knowledge, refuted) {
            (Knowledge::Unknown, Some((title, stretch))) => PolyconvexityAnswer {
                knowledge: Knowledge::NotPolyconvex,
                reason: format!(
                    "it is not rank-one convex: {title}, stretch {}",
                    number::told(stretch)
                ),
                source: "computed".to_owned(),
            },
            _ if is_of_volume => PolyconvexityAnswer {
                knowledge,
                reason: "what is recorded is about the compressible law".to_owned(),
                source: String::new(),
            },
            _ => PolyconvexityAnswer {
                knowledge,
                reason: known.reason.to_owned(),
                source: known.source.to_owned(),
            },
        }
    }

    fn along(
        &self,
        loading: Loading,
        criteria: &[Criterion],
    ) -> Result<LoadingAnswer, CriteriaError> {
        let path = match self.law.incompressible {
            true => LoadingPath::incompressible(&*self.material, loading, &self.range),
            false => LoadingPath::new(&*self.material, self.law.isotropic, loading, &self.range),
        };
        let path = path.map_err(|source| CriteriaError::Loading {
            title: self.title(loading),
            source,
            notes: self.law.notes.clone(),
        })?;
        let reach = self.range.high();
        let tracks = |tension: bool| -> Vec<Option<Track>> {
            let of = |criterion: &Criterion| match criterion {
                Criterion::RankOneConvexity if !self.has_energy => None,
                Criterion::RankOneConvexity => follow(&path, Criterion::StrongEllipticity, tension)
                    .map(|elliptic| follow_jumps(&path, &elliptic, reach, tension)),
                other => follow(&path, *other, tension),
            };
            criteria.iter().map(of).collect()
        };
        let (compression, tension) = (tracks(false), tracks(true));
        let criteria = criteria
            .iter()
            .zip(compression.iter().zip(&tension))
            .map(|(criterion, (compression, tension))| CriterionAnswer {
                criterion: *criterion,
                defined: tension.is_some(),
                holds_in_reference: tension.as_ref().is_some_and(|track| track.holds_at_start),
                compression: side(&path, loading, compression.as_ref()),
                tension: side(&path, loading, tension.as_ref()),
            })
            .collect();
        let limits = [self.range.low(), self.range.high()];
        Ok(LoadingAnswer {
            mode: loading.mode,
            lateral: loading.lateral,
            title: self.title(loading),
            compression_end: EndAnswer::of(&path.compression_end, limits[0]),
            tension_end: EndAnswer::of(&path.tension_end, limits[1]),
            other_states: other_states(&path),
            kinks: kinks(&path).iter().map(KinkAnswer::of).collect(),
            criteria,
        })
    }
}

impl CriterionAnswer {
    /// Whether it is lost somewhere.
    fn has_limit(&self) -> bool {
        self.compression.limit.is_some() || self.tension.limit.is_some()
    }
}

impl LoadingAnswer {
    /// A stretch at which the law is not rank-one convex.
    fn refutes_polyconvexity(&self) -> Option<f64> {
        let lost = |criterion: Criterion| {
            let found = self
                .criteria
                .iter()
                .find(|answer| answer.criterion == criterion)?;
            found.tension.limit.or(found.compression.limit)
        };
        lost(Criterion::StrongEllipticity).or_else(|| lost(Criterion::RankOneConvexity))
    }
}

impl EndAnswer {
    /// Why the path leads no further, in a line; `None` at the end of the range.
    fn line(&self, side: &str) -> Option<String> {
        let reason = self.reason.as_ref()?;
        Some(format!(
            "{side} ends at stretch {}: {reason}",
            number::told(self.stretch)
        ))
    }

    /// The end of a path whose range ends at `limit`.
    pub(crate) fn of(end: &PathEnd, limit: f64) -> Self {
        let (stretch, reason) = match end {
            PathEnd::Range => (limit, None),
            PathEnd::Law { stretch, source } => {
                (*stretch, Some(format!("the law ends there: {source}")))
            }
            PathEnd::GivenUp { stretch, trials } => (
                *stretch,
                Some(format!(
                    "given up after {trials} steps: the law changes too fast with the stretch there"
                )),
            ),
            PathEnd::Fold { stretch } => (*stretch, Some(FOLD.to_owned())),
            PathEnd::NoState { stretch } => (
                *stretch,
                Some("no state with traction-free faces is found beyond it".to_owned()),
            ),
        };
        Self {
            stretch,
            fold: matches!(end, PathEnd::Fold { .. }),
            reason,
        }
    }
}

/// Pairs as a map in their order.
fn as_map<S: Serializer>(
    pairs: &[(String, serde_json::Value)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(name, value)| (name, value)))
}

/// A setting as it is written in JSON.
fn document(value: Value) -> serde_json::Value {
    match value {
        Value::Number(number) => number.into(),
        Value::Word(word) => word.into(),
        other => other.to_string().into(),
    }
}

/// Parts of the way to the ends at which second states are looked for.
const OTHERS: [f64; 3] = [0.25, 0.5, 1.0];

fn other_states(path: &LoadingPath<'_>) -> Vec<OtherState> {
    let last = |states: &[PathState]| states.last().map_or(0.0, |state| state.parameter);
    let ends = [last(&path.compression), last(&path.tension)];
    let places = ends
        .into_iter()
        .flat_map(|end| OTHERS.map(|part| part * end));
    places
        .flat_map(|s| path.other_states(s).into_iter().map(move |f| (s, f)))
        .map(|(s, f)| OtherState {
            stretch: s.exp(),
            deformation_gradient: *f.components(),
        })
        .collect()
}

/// A jump of energy, stress or tangent in words.
fn kink(kink: &KinkAnswer) -> String {
    let place = number::told(kink.stretch);
    let [energy, stress, mean, bulk] = [
        kink.energy,
        kink.largest_stress,
        kink.mean_stress,
        kink.bulk_tangent,
    ]
    .map(number::told);
    match kink.kind {
        Discontinuity::StepOfEnergy => format!(
            "step of the energy at stretch {place}: the energy jumps by {energy}, so that the law has no stress there"
        ),
        Discontinuity::JumpOfStress => format!(
            "jump of the stress at stretch {place} (kink of the energy): the Cauchy stress jumps by up to {stress}, its mean by {mean}"
        ),
        Discontinuity::KinkOfStress => format!(
            "kink of the stress at stretch {place}: the tangent jumps by {:.2} %, d2W/dJ2 by {bulk}; a limit there is that of one side",
            100.0 * kink.jump
        ),
    }
}

/// The nominal strain at a stretch.
fn nominal_strain(loading: Loading, stretch: f64) -> f64 {
    match loading.mode {
        Mode::SimpleShear => loading.mode.imposed(stretch.ln()),
        _ => stretch - 1.0,
    }
}

/// The nominal stress of a state.
fn nominal_stress(loading: Loading, state: &PathState) -> f64 {
    let stress = &state.response.first_piola;
    match loading.mode {
        Mode::SimpleShear => stress[(0, 1)],
        _ => stress[(0, 0)],
    }
}

/// How far before a change its state is taken, in shares of `ln lambda`, where it has none of its own.
const BEFORE: [f64; 4] = [1e-12, 1e-11, 1e-9, 1e-7];

fn side(path: &LoadingPath<'_>, loading: Loading, track: Option<&Track>) -> SideAnswer {
    let Some(track) = track else {
        return SideAnswer::default();
    };
    let change = |event: &Event| {
        let s = event.stretch.ln();
        // Where the free faces branch, the path has no state at the change, and one close before it.
        let state = path
            .at(s)
            .or_else(|| BEFORE.iter().find_map(|share| path.at(s * (1.0 - share))));
        ChangeAnswer {
            change: event.change,
            stretch: event.stretch,
            tolerance: event.tolerance,
            nominal_strain: nominal_strain(loading, event.stretch),
            nominal_stress: state
                .as_ref()
                .map_or(f64::NAN, |state| nominal_stress(loading, state)),
            witness: event.witness,
            deformation_gradient: state.map_or([[f64::NAN; 3]; 3], |state| {
                *state.response.deformation.components()
            }),
        }
    };
    SideAnswer {
        limit: track.limit(),
        upper_bound: track
            .events
            .first()
            .is_some_and(|event| event.is_upper_bound),
        changes: track.events.iter().map(change).collect(),
    }
}
