//! Comparison of stability criteria of a material law: the stretch at which each criterion is lost in each loading, and its disagreements with strong
//! ellipticity.

mod card;
mod figure;
pub(crate) use figure::{imposed_label, stretches as stretch_axis};
mod html;
mod sentence;
mod short;

pub use card::{BoxAnswer, CardAnswer, Limits};
pub use figure::{DEFAULT_CRITERIA, MAX_CRITERIA};
pub use onset::criteria::{Criterion, Lateral, Mode, Range};

use crate::answers::{Evidence, moduli, notes_on_law};
use crate::csv::Table;
use crate::number;
use crate::settings::{MaterialSettings, Units, Value};
use onset::cancel::Scope;
use onset::criteria::{
    Change, Discontinuity, Event, Kink, Knowledge, Loading, LoadingError, LoadingPath, PathEnd,
    PathState, Track, Witness, follow, follow_jumps, has_energy, is_isotropic, kinks,
    polyconvexity,
};
use onset::material::{Hyperelastic, MaterialError, Membrane};
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// Other names of criteria: `hill` is the definiteness of the Hessian that graphics and implicit solvers test for each element.
pub const OTHER_NAMES: [(&str, Criterion); 1] = [("indefinite-hessian", Criterion::Hill)];

/// Criterion with a name, or with another name for it.
pub fn criterion_named(name: &str) -> Option<Criterion> {
    let own = Criterion::ALL.into_iter().find(|own| own.name() == name);
    let other = OTHER_NAMES.iter().find(|(other, _)| *other == name);
    own.or(other.map(|(_, criterion)| *criterion))
}

/// Reasons why the criteria of a law cannot be evaluated.
#[derive(Debug, Error)]
pub enum CriteriaError {
    /// The law itself is invalid.
    #[error("{0}")]
    Material(#[from] MaterialError),
    /// The incompressible response is known only for isotropic laws.
    #[error(
        "{law} is not isotropic; expected an isotropic law with --incompressible\n  hint: omit --incompressible; a large bulk modulus is a good approximation"
    )]
    NotIsotropic {
        /// Name of the law.
        law: String,
    },
    /// The incompressible response needs a law with an energy, which can be split into an isochoric and a volumetric part.
    #[error(
        "{law} has no energy, so that its incompressible response is not known; expected a law with an energy for --incompressible\n  hint: omit --incompressible; a large bulk \
         modulus is a good approximation"
    )]
    NoEnergy {
        /// Name of the law.
        law: String,
    },
    /// No requested loading preserves the volume and has a traction-free face.
    #[error(
        "the incompressible response needs a traction-free face, which determines the pressure; expected --mode uniaxial, equibiaxial, planar or simple-shear"
    )]
    ChangesVolume,
    /// The loading directions do not coincide with the material axes of an anisotropic metal.
    #[error(
        "{law} {how}: about ten thousand states would each be integrated along a separate path, which takes minutes; expected loadings along the \
         axes of the metal, material.angle = 0 or 90, without simple shear\n  hint: `onset path --mode uniaxial` follows a single loading at any angle"
    )]
    Turned {
        /// Name of the law.
        law: &'static str,
        /// Orientation or loading that is refused, for example `in simple shear`.
        how: String,
    },
    /// A criterion that the figure should show does not apply to the law.
    #[error(
        "`{}` does not apply to {law}; expected one of {}\n  hint: surface applies with --incompressible only", asked.name(), names(known)
    )]
    NotApplicable {
        /// Criterion without a meaning for the law.
        asked: Criterion,
        /// Name of the law.
        law: String,
        /// Criteria of this law.
        known: Vec<Criterion>,
    },
    /// A figure cannot show these criteria in different colors.
    #[error(
        "{given} criteria are given, expected at most {MAX_CRITERIA}, each once\n  hint: draw several figures"
    )]
    TooMany {
        /// Number of requested criteria.
        given: usize,
    },
    /// The path of a loading failed.
    #[error("{title}: {source}{}{}", hint(source), told(notes))]
    Loading {
        /// Name of the loading.
        title: &'static str,
        /// Cause of the failure.
        source: LoadingError,
        /// Notes on the law that may explain the failure.
        notes: Vec<String>,
    },
}

/// Names of criteria, in a list.
fn names(criteria: &[Criterion]) -> String {
    let names: Vec<&str> = criteria.iter().map(|own| own.name()).collect();
    names.join(", ")
}

/// Hint for laws that cannot be evaluated.
fn hint(error: &LoadingError) -> &'static str {
    match error {
        LoadingError::Law(_) => {
            "\n  hint: choose constants of the law, or a --range, for which it can be evaluated"
        }
        LoadingError::NoReference | LoadingError::ChangesVolume => "",
    }
}

/// Appends notes to a message, one per line.
fn told(notes: &[String]) -> String {
    let lines = notes.iter().map(|note| format!("\n  note: {note}"));
    lines.collect()
}

/// Law under study as reported: name, parameters with units, symmetry, small-strain moduli and remarks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawAnswer {
    /// Name of the law as in `onset list materials`.
    pub model: String,
    /// Custom title, for laws whose energy or table is too long for a title; `null` for other laws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Parameters of the law and its other inputs, in the order of the documentation.
    #[serde(serialize_with = "as_map")]
    pub parameters: Vec<(String, serde_json::Value)>,
    /// Units of the parameters that have a dimension.
    pub units: BTreeMap<String, &'static str>,
    /// Whether the law is isotropic, found by rotating the reference configuration.
    pub isotropic: bool,
    /// Whether the incompressible response is evaluated.
    pub incompressible: bool,
    /// Whether the law is two-dimensional.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub in_plane: bool,
    /// Shear and bulk modulus at small strains; `null` if the law is anisotropic or has a stress at `F = 1`.
    pub moduli: Option<[f64; 2]>,
    /// Remarks on the law for the reader.
    pub notes: Vec<String>,
}

/// Statement on the polyconvexity of the law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PolyconvexityAnswer {
    /// Whether the law is known to be polyconvex.
    pub knowledge: Knowledge,
    /// Argument for or against polyconvexity.
    pub reason: String,
    /// Source of the proof.
    pub source: String,
}

/// Definition of a criterion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Definition {
    /// Name of the criterion.
    pub criterion: Criterion,
    /// Requirement of the criterion, as a formula or a description.
    pub definition: &'static str,
    /// Source of the criterion.
    pub source: &'static str,
    /// Explanation of limits that are not exact; `null` if all limits are exact.
    pub note: Option<&'static str>,
}

/// Meaning of a limit of rank-one convexity.
const UPPER_BOUND: &str = "a limit is an upper bound of the distance from the reference configuration (hence the signs ≤ and ≥): the named jump lowers the energy \
                           at the limit, and jumps that were not found may lower it earlier";

/// Answer of `onset criteria`: every criterion for every loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CriteriaAnswer {
    /// Law with its parameters.
    pub material: LawAnswer,
    /// Smallest and largest stretch of the search; in simple shear, of the larger principal stretch, which is below 1 for a negative amount of shear.
    pub range: [f64; 2],
    /// Statement on the polyconvexity of the law.
    pub polyconvexity: PolyconvexityAnswer,
    /// Definitions of the criteria.
    pub criteria: Vec<Definition>,
    /// Results for each loading.
    pub loadings: Vec<LoadingAnswer>,
    /// Evidence for the limits: `searched`.
    pub evidence: Evidence,
    /// Sentences on the disagreements between the criteria and strong ellipticity.
    pub disagreements: Vec<String>,
}

impl LawAnswer {
    /// Returns true if boxes of stretches exist for the law: three independent principal stretches include states that an incompressible or a planar
    /// material cannot reach.
    fn has_boxes(&self) -> bool {
        !self.incompressible && !self.in_plane
    }

    /// Units of the parameters.
    fn units(&self) -> Units {
        match self.units.values().any(|unit| *unit == "Pa") {
            true => Units::Si,
            false => Units::Own,
        }
    }
}

impl CriteriaAnswer {
    /// The limits as CSV, one row for each loading and criterion, with the first loss and the first return on both sides of the reference
    /// configuration: imposed stretches, in simple shear the amount of shear.
    pub fn csv(&self) -> String {
        let rows: Vec<_> = self
            .loadings
            .iter()
            .flat_map(|loading| loading.criteria.iter().map(move |own| (loading, own)))
            .collect();
        let mut table = Table::new(&rows, self.material.units())
            .with("mode", "1", |(loading, _)| loading.mode.name())
            .with("lateral", "1", |(loading, _)| loading.lateral.name())
            .with("loading", "1", |(loading, _)| loading.title)
            .with("criterion", "1", |(_, own)| own.criterion.name())
            .with("defined", "1", |(_, own)| own.defined)
            .with("holds_in_reference", "1", |(_, own)| own.holds_in_reference);
        type Side = (
            &'static str,
            fn(&LoadingAnswer) -> &EndAnswer,
            fn(&CriterionAnswer) -> &SideAnswer,
        );
        let sides: [Side; 2] = [
            (
                "compression",
                |loading| &loading.compression_end,
                |own| &own.compression,
            ),
            (
                "tension",
                |loading| &loading.tension_end,
                |own| &own.tension,
            ),
        ];
        for (name, end, side) in sides {
            let first = |own: &CriterionAnswer, kind: Change| {
                let mut changes = side(own).changes.iter();
                changes.find(|change| change.change == kind).cloned()
            };
            table = table
                .with(format!("{name}_lost"), "1", |(_, own)| side(own).limit)
                .with(format!("{name}_lost_stress"), "stress", |(_, own)| {
                    Some(first(own, Change::Lost)?.nominal_stress)
                })
                .with(format!("{name}_upper_bound"), "1", |(_, own)| {
                    side(own).limit.is_some().then(|| side(own).upper_bound)
                })
                .with(format!("{name}_regained"), "1", |(_, own)| {
                    Some(first(own, Change::Regained)?.imposed)
                })
                .with(format!("{name}_end"), "1", |(loading, _)| {
                    end(loading).imposed
                });
        }
        table.to_string()
    }
}

/// Results of every criterion for one loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoadingAnswer {
    /// Deformation mode that is imposed.
    pub mode: Mode,
    /// Condition on the lateral directions.
    pub lateral: Lateral,
    /// Short name of the loading.
    pub title: &'static str,
    /// End of the path in compression, with its cause.
    pub compression_end: EndAnswer,
    /// End of the path in tension, with its cause.
    pub tension_end: EndAnswer,
    /// Other equilibria with the same imposed stretch or amount of shear and different free stretches, if any were found.
    pub other_states: Vec<OtherState>,
    /// States at which the energy, the stress or the tangent jumps, nearest to the reference configuration first.
    pub kinks: Vec<KinkAnswer>,
    /// Results for each criterion.
    pub criteria: Vec<CriterionAnswer>,
}

/// Jump of energy, stress or tangent, taken from the smaller to the larger stretch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct KinkAnswer {
    /// Imposed stretch at the jump; in simple shear the amount of shear.
    pub imposed: f64,
    /// Lowest derivative that jumps: energy, stress or tangent.
    pub kind: Discontinuity,
    /// Norm of the jump of this derivative over all components, relative to the tangent.
    pub jump: f64,
    /// Jump of the energy. Units of stress.
    pub energy: f64,
    /// Largest component of the jump of the Cauchy stress. Units of stress.
    pub largest_stress: f64,
    /// Jump of the mean Cauchy stress. Units of stress.
    pub mean_stress: f64,
    /// Jump of the second derivative of the energy with respect to `J` at constant isochoric deformation. Units of stress.
    pub bulk_tangent: f64,
    /// Whether the stress drops along the loading, so that increments across the kink are unstable.
    pub is_concave: bool,
}

impl KinkAnswer {
    fn of(kink: &Kink, mode: Mode) -> Self {
        let &Kink {
            stretch,
            kind,
            jump,
            energy,
            largest_stress,
            mean_stress,
            bulk_tangent,
            is_concave,
            ..
        } = kink;
        Self {
            imposed: imposed(mode, stretch),
            kind,
            jump,
            energy,
            largest_stress,
            mean_stress,
            bulk_tangent,
            is_concave,
        }
    }
}

/// End of a loading path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EndAnswer {
    /// Last imposed stretch of the path; in simple shear the last amount of shear.
    pub imposed: f64,
    /// Whether the end is a fold, where the equilibrium of the free faces turns back.
    pub fold: bool,
    /// Reason why the path ends; `null` at the end of the range.
    pub reason: Option<String>,
}

/// Largest distance between a fold and a kink at the same place, in `ln lambda`.
const AT_KINK: f64 = 1e-6;

/// Another equilibrium of the free faces at a given imposed stretch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OtherState {
    /// Imposed stretch of the state; in simple shear the amount of shear.
    pub imposed: f64,
    /// Deformation gradient `F_iJ`, by rows.
    pub deformation_gradient: [[f64; 3]; 3],
}

/// Result for one criterion and one loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CriterionAnswer {
    /// Name of the criterion.
    pub criterion: Criterion,
    /// Whether the criterion is defined for this law.
    pub defined: bool,
    /// Whether the criterion holds in the reference configuration.
    pub holds_in_reference: bool,
    /// Result for stretches below 1, or negative amounts of shear.
    pub compression: SideAnswer,
    /// Result for stretches above 1, or positive amounts of shear.
    pub tension: SideAnswer,
}

/// Result for a criterion on one side of the reference configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SideAnswer {
    /// First imposed stretch, in simple shear the first amount of shear, at which the criterion is violated, counted from the reference configuration;
    /// `null` if it is satisfied throughout.
    pub limit: Option<f64>,
    /// Whether the limit is only an upper bound: the criterion is violated there, but it may be violated nearer to the reference configuration.
    pub upper_bound: bool,
    /// All losses and recoveries, nearest to the reference configuration first.
    pub changes: Vec<ChangeAnswer>,
}

/// Loss or recovery of a criterion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChangeAnswer {
    /// Direction of the change: lost or regained.
    pub change: Change,
    /// Imposed stretch at the change; in simple shear the amount of shear.
    pub imposed: f64,
    /// Relative half width of the bracket of the stretch, or the shift that rounding can cause if it is larger; for an upper bound, the tolerance of
    /// the named witness.
    pub tolerance: f64,
    /// Nominal strain at the change: `lambda - 1`, in simple shear the amount of shear.
    pub nominal_strain: f64,
    /// Nominal stress at the change, force by reference area: `P_11`, in simple shear `P_12`. Units of stress.
    pub nominal_stress: f64,
    /// Perturbation that proves the change.
    pub witness: Witness,
    /// Deformation gradient `F_iJ` at the change, by rows.
    pub deformation_gradient: [[f64; 3]; 3],
}

const SHEAR_LEFT_OUT: &str = "simple shear is omitted: its principal axes rotate, so that the proportional path to a state is not the loading itself, and each state \
                              takes long; select it with --mode simple-shear";
const SHEAR_OF_AXES: &str = "simple shear is omitted: its principal axes rotate relative to the axes of the metal, so that each state is integrated along a \
                             separate path, which takes minutes";

/// Refuses loadings whose principal axes do not coincide with the material axes of the metal.
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

/// Stability criteria of a law for a range of stretches and some loadings.
pub struct Question {
    law: LawAnswer,
    material: Arc<dyn Hyperelastic>,
    /// Whether the stress is the derivative of an energy; the elastic energy of a metal in plastic flow is not a potential of its stress.
    has_energy: bool,
    range: Range,
    loadings: Vec<Loading>,
}

impl Question {
    /// Prepares the criteria of a law over a range of stretches for the given modes, or for all modes if `modes` is empty.
    ///
    /// # Errors
    /// [`CriteriaError`] when a parameter is out of range, or when a loading is not possible for this law.
    pub fn new(
        settings: &MaterialSettings,
        range: Range,
        modes: &[Mode],
    ) -> Result<Self, CriteriaError> {
        let in_plane = settings.is_membrane();
        let material: Arc<dyn Hyperelastic> = match in_plane {
            true => Arc::new(Membrane::new(settings.build()?)),
            false => settings.build()?,
        };
        let parameters = settings.entries().into_iter();
        let has_unit = |name: &str| Some((name.to_owned(), settings.unit(name)?));
        let units = settings.entries().into_iter();
        let turns = material.is_path_dependent() && !settings.is_library();
        // A metal with an anisotropic yield surface may be isotropic before it yields.
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
        // The notes on a deck say so.
        if settings.is_relaxed() && !notes.iter().any(|own| own.contains("long-term moduli")) {
            let slow = "the law is that of slow loading, with the long-term moduli; material.loading = fast has the instantaneous moduli";
            notes.push(slow.to_owned());
        }
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
                name: settings.title().map(str::to_owned),
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

    /// Evaluates the incompressible response of the law: the volumetric part is dropped, and the pressure follows from a traction-free face.
    ///
    /// # Errors
    /// [`CriteriaError::NotIsotropic`] if the law is anisotropic, [`CriteriaError::NoEnergy`] if its stress depends on the path,
    /// [`CriteriaError::ChangesVolume`] if no mode preserves the volume and has a traction-free face.
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

    /// Returns true for a two-dimensional law.
    fn is_in_plane(&self) -> bool {
        self.material.dimension() == 2
    }

    fn title(&self, loading: Loading) -> &'static str {
        match self.is_in_plane() {
            true => loading.title_in_plane(),
            false => loading.title(),
        }
    }

    /// Criteria of this law. True stress and Kirchhoff stress coincide for incompressible response, so only one of the two monotonicity criteria
    /// remains.
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

    /// Checks that a figure can show criteria.
    ///
    /// # Errors
    /// [`CriteriaError::NotApplicable`] for a criterion that does not apply to the law, [`CriteriaError::TooMany`] for more criteria than a figure has
    /// colors, or for repeated ones.
    pub fn check_drawn(&self, drawn: &[Criterion]) -> Result<(), CriteriaError> {
        let is_repeated = (1..drawn.len()).any(|n| drawn[..n].contains(&drawn[n]));
        if is_repeated || drawn.len() > MAX_CRITERIA {
            return Err(CriteriaError::TooMany { given: drawn.len() });
        }
        let known = self.criteria();
        match drawn.iter().find(|own| !known.contains(own)) {
            Some(asked) => Err(CriteriaError::NotApplicable {
                asked: *asked,
                law: self.law.model.clone(),
                known,
            }),
            None => Ok(()),
        }
    }

    /// Evaluates every criterion for every loading.
    ///
    /// # Errors
    /// [`CriteriaError`] when the law cannot be evaluated in the reference configuration.
    pub fn answer(&self) -> Result<CriteriaAnswer, CriteriaError> {
        let criteria = self.criteria();
        let scope = Scope::current();
        let loadings: Vec<LoadingAnswer> = self
            .loadings
            .par_iter()
            .map(|loading| scope.run(|| self.along(*loading, &criteria)))
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
        let refuted = loadings.iter().find_map(|loading| {
            let refuted = loading.refutes_polyconvexity()?;
            Some((loading.title, told_place(loading.mode, refuted)))
        });
        // The proof against polyconvexity may rest on the volumetric part, which the incompressible response lacks.
        let is_of_volume = self.law.incompressible && known.knowledge == Knowledge::NotPolyconvex;
        let knowledge = match is_of_volume {
            true => Knowledge::Unknown,
            false => known.knowledge,
        };
        match (knowledge, refuted) {
            (Knowledge::Unknown, Some((title, place))) => PolyconvexityAnswer {
                knowledge: Knowledge::NotPolyconvex,
                reason: format!("it is not rank-one convex: {title}, {place}"),
                source: "computed".to_owned(),
            },
            _ if is_of_volume => PolyconvexityAnswer {
                knowledge,
                reason: "the known result holds for the compressible law only".to_owned(),
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
            compression_end: EndAnswer::of(&path, false, limits[0]),
            tension_end: EndAnswer::of(&path, true, limits[1]),
            other_states: other_states(&path),
            kinks: kinks(&path)
                .iter()
                .map(|kink| KinkAnswer::of(kink, loading.mode))
                .collect(),
            criteria,
        })
    }
}

impl CriterionAnswer {
    fn has_limit(&self) -> bool {
        self.compression.limit.is_some() || self.tension.limit.is_some()
    }
}

impl LoadingAnswer {
    /// Imposed quantity in the reference configuration: the stretch 1, in simple shear no shear.
    fn reference(&self) -> f64 {
        imposed(self.mode, 1.0)
    }

    /// Distance of a state from the reference configuration along the loading.
    fn distance(&self, place: f64) -> f64 {
        self.mode.parameter(place).abs()
    }

    /// Returns a state at which the law is not rank-one convex, and hence not polyconvex.
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
    /// Reason why the path ends, in one line; `None` at the end of the range.
    fn line(&self, mode: Mode, side: &str) -> Option<String> {
        let reason = self.reason.as_ref()?;
        let place = told_place(mode, self.imposed);
        Some(format!("{side} ends at {place}: {reason}"))
    }

    /// End of a path, in tension or in compression, whose search ends at the stretch `limit`.
    pub(crate) fn of(path: &LoadingPath<'_>, tension: bool, limit: f64) -> Self {
        let mode = path.loading.mode;
        let end = match tension {
            true => &path.tension_end,
            false => &path.compression_end,
        };
        let (stretch, reason) = match end {
            PathEnd::Range => (limit, None),
            PathEnd::Law { stretch, source } => {
                let told = source.to_string();
                let first = told.lines().next().unwrap_or_default();
                let what = match source {
                    MaterialError::External { .. } => "the law fails there",
                    _ => "the law ends there",
                };
                (*stretch, Some(format!("{what}: {first}")))
            }
            PathEnd::GivenUp { stretch, trials } => (
                *stretch,
                Some(format!(
                    "the search was stopped after {trials} steps: the law changes too fast with the stretch there"
                )),
            ),
            PathEnd::Fold { stretch } => {
                let is_here = |kink: &Kink| (kink.stretch.ln() - stretch.ln()).abs() < AT_KINK;
                let kind = match kinks(path).iter().any(is_here) {
                    true => "where the tangent jumps",
                    false => "(limit point)",
                };
                let reason = format!(
                    "a fold {kind}: beyond it the free faces have no equilibrium nearby (dynamic jump)"
                );
                (*stretch, Some(reason))
            }
            PathEnd::NoState { stretch } => (
                *stretch,
                Some("no state with traction-free faces is found beyond it".to_owned()),
            ),
        };
        Self {
            imposed: imposed(mode, stretch),
            fold: matches!(end, PathEnd::Fold { .. }),
            reason,
        }
    }
}

/// Serializes pairs as a map, in the given order.
fn as_map<S: Serializer>(
    pairs: &[(String, serde_json::Value)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(name, value)| (name, value)))
}

fn document(value: Value) -> serde_json::Value {
    match value {
        Value::Number(number) => number.into(),
        Value::Word(word) => word.into(),
        other => other.to_string().into(),
    }
}

/// Fractions of the distance to each end of the path at which other equilibria are searched for.
const EQUILIBRIUM_SEARCH_FRACTIONS: [f64; 3] = [0.25, 0.5, 1.0];

fn other_states(path: &LoadingPath<'_>) -> Vec<OtherState> {
    let last = |states: &[PathState]| states.last().map_or(0.0, |state| state.parameter);
    let ends = [last(&path.compression), last(&path.tension)];
    let places = ends
        .into_iter()
        .flat_map(|end| EQUILIBRIUM_SEARCH_FRACTIONS.map(|part| part * end));
    places
        .flat_map(|s| path.other_states(s).into_iter().map(move |f| (s, f)))
        .map(|(s, f)| OtherState {
            imposed: path.loading.mode.imposed(s),
            deformation_gradient: *f.components(),
        })
        .collect()
}

/// Describes a jump of energy, stress or tangent.
fn kink(kink: &KinkAnswer, mode: Mode) -> String {
    let place = told_place(mode, kink.imposed);
    let [energy, stress, mean, bulk] = [
        kink.energy,
        kink.largest_stress,
        kink.mean_stress,
        kink.bulk_tangent,
    ]
    .map(number::told);
    match kink.kind {
        Discontinuity::StepOfEnergy => format!(
            "step of the energy at {place}: the energy jumps by {energy}, so that the law has no stress there"
        ),
        Discontinuity::JumpOfStress => format!(
            "jump of the stress at {place} (kink of the energy): the Cauchy stress jumps by up to {stress}, its mean by {mean}{}",
            match kink.is_concave {
                true => "; it drops along the loading, so that increments across it are unstable",
                false => "",
            }
        ),
        Discontinuity::KinkOfStress => format!(
            "kink of the stress at {place}: the tangent jumps by {:.2} %, d2W/dJ2 by {bulk}; a limit there is one-sided",
            100.0 * kink.jump
        ),
    }
}

/// Imposed quantity of a mode at a stretch of the search: the stretch itself, in simple shear the amount of shear.
fn imposed(mode: Mode, stretch: f64) -> f64 {
    match mode {
        Mode::SimpleShear => mode.imposed(stretch.ln()),
        _ => stretch,
    }
}

/// Description of a state along a loading: `stretch 1.2`, in simple shear `gamma = 0.4`.
fn told_place(mode: Mode, place: f64) -> String {
    match mode {
        Mode::SimpleShear => format!("gamma = {}", number::told(place)),
        _ => format!("stretch {}", number::told(place)),
    }
}

/// Names of the two sides of the reference configuration, first for smaller, then for larger imposed values.
fn sides(mode: Mode) -> [&'static str; 2] {
    match mode {
        Mode::SimpleShear => ["gamma < 0", "gamma > 0"],
        _ => ["compression", "tension"],
    }
}

/// Nominal strain at an imposed stretch or amount of shear.
fn nominal_strain(mode: Mode, place: f64) -> f64 {
    place - imposed(mode, 1.0)
}

fn nominal_stress(loading: Loading, state: &PathState) -> f64 {
    let stress = &state.response.first_piola;
    match loading.mode {
        Mode::SimpleShear => stress[(0, 1)],
        _ => stress[(0, 0)],
    }
}

/// Relative offsets in `ln lambda` before a change, tried in order if the path has no state at the change itself.
const CHANGE_OFFSETS: [f64; 4] = [1e-12, 1e-11, 1e-9, 1e-7];

fn side(path: &LoadingPath<'_>, loading: Loading, track: Option<&Track>) -> SideAnswer {
    let Some(track) = track else {
        return SideAnswer::default();
    };
    let change = |event: &Event| {
        let s = event.stretch.ln();
        let place = imposed(loading.mode, event.stretch);
        // If the equilibrium of the free faces branches at the change, the path has no state there; the state just before it is reported.
        let state = path.at(s).or_else(|| {
            CHANGE_OFFSETS
                .iter()
                .find_map(|share| path.at(s * (1.0 - share)))
        });
        ChangeAnswer {
            change: event.change,
            imposed: place,
            tolerance: event.tolerance,
            nominal_strain: nominal_strain(loading.mode, place),
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
        limit: track.limit().map(|limit| imposed(loading.mode, limit)),
        upper_bound: track
            .events
            .first()
            .is_some_and(|event| event.is_upper_bound),
        changes: track.events.iter().map(change).collect(),
    }
}
