//! Verdict on a state: is it stable, and if not, is the instability physical or numerical?

use super::certificate::CertificateAnswer;
use super::discrete_time::{DiscreteTimeAnswer, note};
use super::evidence::Evidence;
use super::finite_body::{BodyStepAnswer, FiniteBodyAnswer, LATTICE_NOTE, reach_of};
use super::implicit::ImplicitAnswer;
use super::mode::{critical_mode, finite_wave_vector};
use super::mode_name;
use super::next::next;
use super::notes::{buckling, note_on_upwinding, notes, softening};
use super::problem::{Problem, ProblemError, Strain};
use super::run_step::RunStepAnswer;
use super::sentence;
use super::stiffer::{RelaxationAnswer, StifferAnswer, WIDTH_OF_BANDS, localizes};
use crate::compare::percent;
use crate::csv::Table;
use crate::methods::reduced;
use crate::number::{counted, told, told_of, vector};
use crate::settings::{Effective, Family, TimeIntegrator, Value};
use nalgebra::{SMatrix, SVector};
use onset::algebra::Complex;
use onset::analysis::{FiniteBodyOscillations, ReducedCell};
use onset::bloch::SpectrumSummary;
use onset::certificate::certify_3d;
use onset::continuum::{AcousticMinimum, Ellipticity};
use onset::kinematics::DeformationGradient;
use onset::material::Response;
use onset::method::MethodError;
use onset::time_step::Integrator;
use onset::verdict::{
    Assessment, MaterialAssessment, Mechanism, SurveyedState, Verdict, WEAK_WAVE_RATIO, WeakestMode,
};
use serde::Serialize;
use std::collections::BTreeMap;

/// Largest distance of a bound below a small scaled minimum for which the bound is reported.
const REPORTED_BOUND_DISTANCE: f64 = 1e-3;

/// Complex number as a pair of real and imaginary part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ComplexNumber {
    /// Real part of the number.
    pub re: f64,
    /// Imaginary part of the number.
    pub im: f64,
}

impl From<Complex> for ComplexNumber {
    fn from(value: Complex) -> Self {
        Self {
            re: value.re,
            im: value.im,
        }
    }
}

/// Answer of `onset state` for one state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StateAnswer {
    /// The origin of the first instability.
    pub verdict: Verdict,
    /// The mechanism of a numerical instability; `null` for other verdicts.
    pub mechanism: Option<Mechanism>,
    /// Evidence for the verdict: `proved`, `bounded` or `searched`.
    pub evidence: Evidence,
    /// The verdict in plain English.
    pub sentence: String,
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// Suggested commands after the verdict.
    pub next: Vec<String>,
    /// All settings in effect.
    pub settings: Effective,
    /// `F_iJ`; in plane stress with the computed components across the sheet.
    pub deformation_gradient: [[f64; 3]; 3],
    /// The continuum, as computed in floating point.
    pub material: MaterialAnswer,
    /// The continuum for waves in all directions of 3D space, also out of the plane of a 2D lattice. `None` for a sheet or bar in plane stress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material_3d: Option<SpaceAnswer>,
    /// The discretization, as searched in floating point.
    pub discretization: DiscretizationAnswer,
    /// The discretization for disturbances that unload a state that flows; `null` for other states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unloading: Option<StifferAnswer>,
    /// The state of a viscoelastic law before and while it relaxes; `null` for other laws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relaxation: Option<RelaxationAnswer>,
    /// The time step of a run with another code, compared with its limits; `null` without `time.step`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run_step: Option<RunStepAnswer>,
    /// Proofs; `null` if they were not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certificate: Option<CertificateAnswer>,
}

/// The continuum at a state. Stresses in units of the material's parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialAnswer {
    /// Name of the law.
    pub model: &'static str,
    /// Parameters of the law.
    pub parameters: BTreeMap<&'static str, Value>,
    /// Cauchy stress `sigma_ij`. Units of stress.
    pub cauchy: [[f64; 3]; 3],
    /// First Piola-Kirchhoff stress `P_iJ`, first index spatial.
    pub first_piola: [[f64; 3]; 3],
    /// Tangent `A_iJkL = dP_iJ/dF_kL`, nested in the order of its indices.
    pub tangent: Vec<Vec<Vec<Vec<f64>>>>,
    /// Largest component of the tangent, the scale of rounding errors in stresses and eigenvalues.
    #[serde(skip)]
    stiffness: f64,
    /// Whether the state is strongly elliptic for waves in the dimensions of the lattice: `g . Q(N) g > 0`, beyond rounding. With major symmetry of
    /// the tangent this is the sign of the smallest eigenvalue. Without it, strong ellipticity can be lost before waves grow.
    pub elliptic: bool,
    /// Strong ellipticity in three values: `undecided` if the smallest value is zero to rounding, as for a fluid.
    pub ellipticity: Ellipticity,
    /// Waves of the material that oscillate and grow, or `None`; only tangents without major symmetry have them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flutter: Option<FlutterAnswer>,
    /// Whether the state is strongly elliptic for waves in all directions of 3D space: condition (60) of the paper instead of (62). `null` if the state has no three-dimensional waves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elliptic_3d: Option<bool>,
    /// Smallest eigenvalue of the acoustic tensor over all directions of 3D space. Units of stress; `null` if the state has no three-dimensional waves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimum_acoustic_eigenvalue_3d: Option<f64>,
    /// Smallest eigenvalue of the acoustic tensor over all directions in the dimensions of the lattice; zero if it is within rounding of zero. Units of stress.
    pub minimum_acoustic_eigenvalue: f64,
    /// Rounding error of the smallest eigenvalue; stress.
    pub rounding: f64,
    /// Reference direction of the slowest wave.
    pub direction: Vec<f64>,
    /// Polarization of the slowest wave.
    pub polarization: Vec<f64>,
}

/// Complex eigenvalue of an acoustic tensor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlutterAnswer {
    /// Complex eigenvalue with the largest imaginary part that was found; stress.
    pub eigenvalue: ComplexNumber,
    /// Reference direction of the wave.
    pub direction: Vec<f64>,
}

impl FlutterAnswer {
    fn of(minimum: &AcousticMinimum<3>, dimension: usize) -> Option<Self> {
        minimum.flutter.as_ref().map(|flutter| Self {
            eigenvalue: ComplexNumber::from(flutter.eigenvalue),
            direction: list(dimension, &flutter.direction),
        })
    }
}

/// Slowest plane wave of the continuum in 3D. A state of plane strain can lose ellipticity for out-of-plane perturbations first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpaceAnswer {
    /// Whether the state is strongly elliptic.
    pub elliptic: bool,
    /// Strong ellipticity: it holds, is lost, or is undecided.
    pub ellipticity: Ellipticity,
    /// Waves that oscillate and grow, or `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flutter: Option<FlutterAnswer>,
    /// Smallest eigenvalue of the acoustic tensor over all directions; zero if it is within rounding of zero. Units of stress.
    pub minimum_acoustic_eigenvalue: f64,
    /// Sign of the smallest eigenvalue.
    #[serde(skip)]
    pub growth: Ellipticity,
    /// Rounding error of the smallest eigenvalue; stress.
    pub rounding: f64,
    /// Lower bound of the eigenvalues over all directions, in floating point. The certificate contains proofs in interval arithmetic. Units of stress.
    pub bound: f64,
    /// Reference direction `N` of the wave.
    pub direction: [f64; 3],
    /// Polarization of the wave.
    pub polarization: [f64; 3],
}

impl SpaceAnswer {
    fn new(response: &Response) -> Self {
        let material = MaterialAssessment::<3>::of(response.clone());
        let minimum = &material.minimum;
        // Adding zero turns a negative zero into a positive one.
        let components = |v: SVector<f64, 3>| std::array::from_fn(|i| v[i] + 0.0);
        Self {
            elliptic: material.ellipticity.is_elliptic(),
            ellipticity: material.ellipticity,
            flutter: FlutterAnswer::of(minimum, 3),
            minimum_acoustic_eigenvalue: minimum.significant(),
            growth: minimum.ellipticity(),
            rounding: minimum.rounding,
            bound: minimum.bound,
            direction: components(minimum.direction),
            polarization: components(minimum.polarization),
        }
    }
}

/// Stability of the discretization at a state, with its fastest growing or softest mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiscretizationAnswer {
    /// Whether no mode grows.
    pub stable: bool,
    /// Description of the fastest growing mode, or of the softest one if stable.
    pub mode: String,
    /// `omega^2` of smallest real part over the whole Brillouin zone; zero (the translation) when stable. 1/time^2.
    pub minimum_omega_squared: ComplexNumber,
    /// `min Re omega^2 / (c^2 |k|_h^2)` over the zone and the long-wave limit. If a mode grows at `k = 0`, this quotient has no minimum; the value is
    /// then the lowest `Re omega^2` divided by the largest `c^2 |k|_h^2`.
    pub minimum_scaled: f64,
    /// Reference wave vector of the fastest growing mode, or of the softest mode if stable; 1/length. Zero in the limit of long waves.
    pub wave_vector: Vec<f64>,
    /// Wave vector `F^-T k` of the mode of `wave_vector` in the deformed lattice; 1/length.
    pub spatial_wave_vector: Vec<f64>,
    /// Polarization of the mode of `wave_vector`, real part.
    pub polarization: Vec<f64>,
    /// Polarization of the mode of `wave_vector`, imaginary part.
    pub polarization_imaginary: Vec<f64>,
    /// Growth rate of the fastest growing mode, `max(-Im omega)`; zero when stable. 1/time.
    pub growth_rate: f64,
    /// Whether modes grow with a complex `omega^2`.
    pub flutter: bool,
    /// Largest frequency over the zone; rad/time.
    pub maximum_omega: f64,
    /// Critical time step of `integrator` without damping, `2 / maximum_omega` for the default integrator; for methods that define their time step, its
    /// largest stable value. Zero if no step is stable; `null` if no mode oscillates, and for implicit integrators.
    pub critical_time_step: Option<f64>,
    /// Integrator of `critical_time_step`, `finite_bodies` and `body`; `null` for methods that define their time step, and for implicit integrators.
    pub integrator: Option<&'static str>,
    /// Kind of body for which `critical_time_step` holds.
    pub critical_time_step_of: &'static str,
    /// Time step for finite bodies; `null` if it is unknown.
    pub finite_bodies: Option<FiniteBodyAnswer>,
    /// Time step for the body of the study; `null` if the study has no body, or if the step of `integrator` is unknown because of damping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyStepAnswer>,
    /// Side of a grid cell of material points; length. `null` for other methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid_cell: Option<f64>,
    /// Mean spacing of material points along a side of a grid cell; length. `null` for other methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point_spacing: Option<f64>,
    /// Waves in discrete time, for methods that define their time step; `null` for other methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub discrete_time: Option<DiscreteTimeAnswer>,
    /// Critical time steps of integrators with damping, by their names; zero if no step is stable.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub damped_time_steps: BTreeMap<&'static str, f64>,
    /// Waves considered in `damped_time_steps`: all waves, or in an unstable state the waves that do not grow. `null` without such steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damped_time_steps_of: Option<&'static str>,
    /// Tangent and steps of implicit and static solvers; `null` for methods that define their time step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub implicit: Option<ImplicitAnswer>,
    /// Lower bound of the scaled measure of all waves.
    ///
    /// `null` without a bound, or if its distance from `minimum_scaled` exceeds both 0.001 and the size of `minimum_scaled`. For forces without an
    /// energy it is the bound of the Hermitian part.
    pub minimum_scaled_bound: Option<f64>,
    /// Reference wave vector at which `minimum_scaled` is attained; zero in the limit of long waves.
    pub minimum_scaled_wave_vector: Vec<f64>,
    /// Smallest scaled measure of the long-wave limit.
    pub long_wave_minimum_scaled: f64,
    /// Reference direction of the softest long wave.
    pub long_wave_direction: Vec<f64>,
    /// Squared norm of the discrete gradient of the softest mode relative to the exact gradient; zero for a zero-energy mode. `None` if the
    /// discretization has no such gradient.
    pub gradient_norm: Option<f64>,
    /// Weakest wave of the reference configuration; `onset modes` finds the same mode. `null` if it is not defined.
    pub weakest_mode: Option<WeakestModeAnswer>,
    /// Numbers of particles of the cell of the settings and of its smaller primitive cell; `null` if the cell of the settings is primitive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reduced_cell: Option<ReducedCell>,
}

/// Mode of the reference configuration, compared with the material wave that it approximates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WeakestModeAnswer {
    /// Reference wave vector of the material wave; 1/length.
    pub wave_vector: Vec<f64>,
    /// Frequency relative to the slowest wave of the material.
    pub relative_frequency: f64,
    /// Largest relative frequency of a weakly controlled wave.
    pub weak: f64,
    #[serde(skip)]
    pub(super) mode: WeakestMode<3>,
}

impl WeakestModeAnswer {
    fn new(dimension: usize, mode: &WeakestMode<3>, weak: f64) -> Self {
        Self {
            wave_vector: list(dimension, &mode.wave_vector),
            relative_frequency: mode.relative_frequency(),
            weak,
            mode: *mode,
        }
    }
}

/// Options for the assessment of one state, as in `onset state`.
#[derive(Clone, Copy, Debug)]
pub struct StateQuestion {
    /// Tolerance of the proof, if a proof is requested. A smaller undecided measure counts as near zero.
    pub certified: Option<f64>,
    /// Largest frequency of a weakly controlled wave, relative to the slowest wave of the material.
    pub weak: f64,
}

impl Default for StateQuestion {
    fn default() -> Self {
        Self {
            certified: None,
            weak: WEAK_WAVE_RATIO,
        }
    }
}

impl StateAnswer {
    /// The state as CSV, in one row.
    pub fn csv(&self) -> String {
        let dimension = self.discretization.wave_vector.len();
        Table::new(std::slice::from_ref(self), self.settings.units())
            .with("verdict", "1", |own| own.verdict.name())
            .with("mechanism", "1", |own| own.mechanism.map(Mechanism::name))
            .with("evidence", "1", |own| own.evidence.name())
            .tensor("F", "1", |own| &own.deformation_gradient)
            .with("minimum_scaled", "1", |own| {
                own.discretization.minimum_scaled
            })
            .with("minimum_omega_squared", "1/time^2", |own| {
                own.discretization.minimum_omega_squared.re
            })
            .with("growth_rate", "1/time", |own| {
                own.discretization.growth_rate
            })
            .each("wave_vector", dimension, "1/length", |own, n| {
                own.discretization.wave_vector[n]
            })
            .with("weakest_relative_frequency", "1", |own| {
                let weakest = own.discretization.weakest_mode.as_ref();
                weakest.map(|mode| mode.relative_frequency)
            })
            .with("maximum_omega", "1/time", |own| {
                own.discretization.maximum_omega
            })
            .with("critical_time_step", "time", |own| {
                own.discretization.critical_time_step
            })
            .with("finite_body_time_step", "time", |own| {
                let bodies = own.discretization.finite_bodies.as_ref();
                bodies.map(|bodies| bodies.time_step)
            })
            .with("elliptic", "1", |own| own.material.elliptic)
            .with("minimum_acoustic_eigenvalue", "stress", |own| {
                own.material.minimum_acoustic_eigenvalue
            })
            .with("s11", "stress", |own| own.material.cauchy[0][0])
            .with("s22", "stress", |own| own.material.cauchy[1][1])
            .with("s33", "stress", |own| own.material.cauchy[2][2])
            .with("s12", "stress", |own| own.material.cauchy[0][1])
            .to_string()
    }

    /// Assesses a state and returns the answer.
    ///
    /// # Errors
    /// [`ProblemError`] when the method or the material cannot be evaluated there.
    pub fn new(problem: &Problem, strain: &Strain) -> Result<Self, ProblemError> {
        Self::asked(problem, strain, &StateQuestion::default())
    }

    /// Answers for one state with the options of `question`.
    ///
    /// # Errors
    /// [`ProblemError`] when the method or the material cannot be evaluated there.
    pub fn asked(
        problem: &Problem,
        strain: &Strain,
        question: &StateQuestion,
    ) -> Result<Self, ProblemError> {
        let assessment = problem.analysis.assess(&strain.0)?;
        answer(problem, strain, &assessment, question)
    }

    /// Creates the answer for an assessed state.
    ///
    /// # Errors
    /// Fails like [`StateAnswer::new`].
    pub fn of(
        problem: &Problem,
        strain: &Strain,
        assessment: &Assessment<3>,
    ) -> Result<Self, ProblemError> {
        answer(problem, strain, assessment, &StateQuestion::default())
    }
}

fn answer(
    problem: &Problem,
    strain: &Strain,
    assessment: &Assessment<3>,
    question: &StateQuestion,
) -> Result<StateAnswer, ProblemError> {
    let f = &strain.0;
    let analysis = &*problem.analysis;
    let searched = (assessment.verdict, assessment.spectrum.stability());
    let (mut verdict, mut mechanism) = (searched.0, assessment.mechanism());
    let mut certificate = None;
    let is_of_space = problem.material.dimension() == 3;
    let response = &assessment.material.response;
    let in_3d = is_of_space.then(|| SpaceAnswer::new(response));
    let weakest = analysis
        .weakest()?
        .map(|mode| WeakestModeAnswer::new(analysis.dimension(), &mode, question.weak));
    let mut sentence = sentence::of(
        problem,
        assessment,
        in_3d.as_ref(),
        weakest.as_ref(),
        f,
        problem.settings.units(),
    );
    if let Some(tolerance) = question.certified {
        let proved = analysis.certify(f, tolerance)?;
        let proved_3d = is_of_space.then(|| certify_3d(&*problem.material, f, tolerance));
        let proved_3d = proved_3d.transpose().map_err(MethodError::from)?;
        let corrected = proved.corrected(&SurveyedState::from(assessment));
        verdict = corrected.0;
        if corrected != searched {
            // The proof gives no wave, so that the mechanism follows from the mean stress.
            mechanism = (verdict == Verdict::Numerical)
                .then(|| Mechanism::of(corrected.1, false, assessment.material.mean_stress));
            sentence = sentence::of_correction(searched, corrected);
        }
        certificate = Some(CertificateAnswer::new(
            analysis.dimension(),
            &proved,
            proved_3d.as_ref(),
            tolerance,
            corrected != searched,
        ));
    }
    let stiffer = problem.stiffer_at(f)?;
    let stiffer = match &stiffer {
        Some(stiffer) => Some((stiffer, stiffer.analysis.assess(f)?)),
        None => None,
    };
    let limiting = Limiting::new(problem, stiffer.as_ref(), assessment, f)?;
    let discretization = discretization_answer(problem, &limiting, assessment, weakest, f)?;
    let disturbed = stiffer
        .as_ref()
        .map(|(stiffer, own)| StifferAnswer::new(stiffer, own, limiting.bodies.as_ref()));
    let relaxation = RelaxationAnswer::new(problem, disturbed.as_ref(), f)?;
    let run_step = limiting.run_step(f)?;
    if let Some(told) = run_step.and_then(|own| own.sentence(problem.settings.units(), &sentence)) {
        sentence = told;
    }
    let mut notes = notes(&problem.settings, &*problem.material);
    // The cause of an instability is the first note.
    if localizes(problem, assessment) {
        notes.insert(0, WIDTH_OF_BANDS.to_owned());
    }
    notes.extend(waves_in_the_plane(problem, strain));
    notes.extend(note_on_upwinding(
        &problem.settings,
        problem.analysis.sites(),
    ));
    notes.extend(softening(
        &problem.settings.material,
        response,
        problem.settings.units(),
    ));
    notes.extend(buckling(
        &*problem.material,
        response,
        problem.settings.units(),
    ));
    let discrete_time = discretization.discrete_time.as_ref();
    notes.extend(
        discrete_time.and_then(|own| note(own, discretization.stable, problem.settings.units())),
    );
    Ok(StateAnswer {
        verdict,
        mechanism,
        evidence: Evidence::of(
            certificate.as_ref().is_some_and(CertificateAnswer::decides),
            discretization.minimum_scaled_bound.is_some(),
        ),
        sentence,
        notes,
        next: next(&problem.settings, verdict, problem.analysis.sites() == 1),
        settings: problem.settings.effective(),
        certificate,
        deformation_gradient: *response.deformation.components(),
        material: material_answer(problem, assessment, in_3d.as_ref()),
        material_3d: in_3d,
        discretization,
        unloading: disturbed.filter(|_| relaxation.is_none()),
        relaxation,
        run_step,
    })
}

/// Waves and bodies that limit the time steps at a state. If the state has stiffer increments, their waves limit the steps.
struct Limiting<'a> {
    problem: &'a Problem,
    /// Problem of the stiffer increments.
    stiffer: Option<&'a Problem>,
    spectrum: SpectrumSummary<3>,
    /// `None` if no time step of the answer depends on them.
    bodies: Option<FiniteBodyOscillations>,
}

impl<'a> Limiting<'a> {
    fn new(
        problem: &'a Problem,
        stiffer: Option<&'a (&'a Problem, Assessment<3>)>,
        assessment: &Assessment<3>,
        f: &DeformationGradient,
    ) -> Result<Self, ProblemError> {
        let settings = &problem.settings;
        let is_implicit = matches!(
            settings.chosen_integrator(),
            Some(TimeIntegrator::Implicit(_))
        );
        let is_asked = !is_implicit || settings.run.step != 0.0 || stiffer.is_some();
        let limiting = stiffer.map_or(problem, |(stiffer, _)| stiffer);
        let bodies = is_asked.then(|| limiting.analysis.finite_bodies(f));
        Ok(Self {
            problem: limiting,
            stiffer: stiffer.map(|(stiffer, _)| *stiffer),
            spectrum: stiffer.map_or(assessment, |(_, own)| own).spectrum,
            bodies: bodies.transpose()?,
        })
    }

    fn lattice_step(&self) -> Option<f64> {
        Some(self.spectrum.critical_time_step()).filter(|step| step.is_finite())
    }

    fn finite_bodies(&self, integrator: Integrator, step: Option<f64>) -> Option<FiniteBodyAnswer> {
        FiniteBodyAnswer::new(self.problem, self.bodies.as_ref()?, integrator, step)
    }

    /// Time step of a run, compared with its limits at a state.
    fn run_step(&self, f: &DeformationGradient) -> Result<Option<RunStepAnswer>, ProblemError> {
        let bodies = self.finite_bodies(Integrator::CentralDifferences, self.lattice_step());
        RunStepAnswer::new(self.problem, f, &self.spectrum, bodies.as_ref())
    }
}

/// Note for a third stretch given in 2D.
fn waves_in_the_plane(problem: &Problem, strain: &Strain) -> Option<String> {
    let is_plane_strain = problem.dimension() == 2 && problem.material.dimension() == 3;
    (is_plane_strain && strain.is_of_space()).then(|| {
        let setting = match problem.settings.method.method {
            Family::FiniteElements => "mesh=bricks",
            Family::MaterialPoints => "lattice=simple-cubic",
            _ => "lattice=face-centered-cubic",
        };
        format!("plane strain, in-plane waves; for 3D: --set discretization.{setting}")
    })
}

fn material_answer(
    problem: &Problem,
    assessment: &Assessment<3>,
    in_3d: Option<&SpaceAnswer>,
) -> MaterialAnswer {
    let (settings, dimension) = (&problem.settings, problem.dimension());
    let continuum = &assessment.material;
    let response = &continuum.response;
    let tangent = |i, j, k| (0..3).map(|l| response.tangent[(i, j, k, l)]).collect();
    MaterialAnswer {
        model: settings.material.model.name(),
        parameters: settings.material.entries().into_iter().collect(),
        cauchy: rows(&response.cauchy()),
        first_piola: rows(&response.first_piola),
        tangent: (0..3)
            .map(|i| {
                (0..3)
                    .map(|j| (0..3).map(|k| tangent(i, j, k)).collect())
                    .collect()
            })
            .collect(),
        stiffness: response.tangent.largest(),
        elliptic: continuum.ellipticity.is_elliptic(),
        ellipticity: continuum.ellipticity,
        flutter: FlutterAnswer::of(&continuum.minimum, dimension),
        elliptic_3d: in_3d.map(|in_3d| in_3d.elliptic),
        minimum_acoustic_eigenvalue_3d: in_3d.map(|in_3d| in_3d.minimum_acoustic_eigenvalue),
        minimum_acoustic_eigenvalue: continuum.minimum.significant(),
        rounding: continuum.minimum.rounding,
        direction: list(dimension, &continuum.minimum.direction),
        polarization: list(dimension, &continuum.minimum.polarization),
    }
}

/// Answer for the particles.
fn discretization_answer(
    problem: &Problem,
    limiting: &Limiting<'_>,
    assessment: &Assessment<3>,
    weakest_mode: Option<WeakestModeAnswer>,
    f: &DeformationGradient,
) -> Result<DiscretizationAnswer, ProblemError> {
    let analysis = &*problem.analysis;
    let list = |vector: &SVector<f64, 3>| list(analysis.dimension(), vector);
    let stiffer = limiting.stiffer;
    let discrete_time = DiscreteTimeAnswer::new(problem, f)?.map(|own| match stiffer {
        Some(stiffer) => own.limited_by(DiscreteTimeAnswer::new(stiffer, f)),
        None => Ok(own),
    });
    let discrete_time = discrete_time.transpose()?;
    let chosen = problem.settings.chosen_integrator();
    let explicit = chosen.and_then(TimeIntegrator::explicit);
    let implicit = match chosen {
        Some(TimeIntegrator::Implicit(own)) => Some(own),
        _ => None,
    };
    let mut steps = match implicit {
        Some(_) => Vec::new(),
        None => analysis.damped_time_steps(f)?,
    };
    if let Some(stiffer) = stiffer {
        let own = stiffer.analysis.damped_time_steps(f)?;
        for (step, (_, other)) in steps.iter_mut().zip(own) {
            step.1 = step.1.min(other);
        }
    }
    steps.retain(|(own, _)| explicit.is_none_or(|only| only == *own));
    let spectrum = &assessment.spectrum;
    // A bound far below the minimum carries no information.
    let minimum = spectrum.softest.scaled;
    let bound = Some(spectrum.bound)
        .filter(|bound| minimum - bound <= minimum.abs().max(REPORTED_BOUND_DISTANCE));
    let mode = critical_mode(assessment);
    let wave_vector = finite_wave_vector(mode);
    let spatial = analysis.spatial(f, &mode.wave_vector);
    let method = &problem.settings.method;
    let has_grid = method.method == Family::MaterialPoints;
    let grid_cell = has_grid.then_some(problem.settings.discretization.spacing);
    let critical_time_step = match &discrete_time {
        Some(own) => own.largest_time_step,
        None => {
            let step = spectrum.critical_time_step();
            let step = step.min(limiting.spectrum.critical_time_step());
            Some(step).filter(|step| step.is_finite())
        }
    };
    let named = mode_name::name(problem, mode, &spatial, spectrum.maximum_omega);
    let is_stepped = discrete_time.is_none() && implicit.is_none();
    let default = TimeIntegrator::default().explicit();
    let integrator = explicit.or(default).filter(|_| is_stepped);
    let scheme = integrator.unwrap_or(Integrator::CentralDifferences);
    let critical_time_step = critical_time_step
        .filter(|_| implicit.is_none())
        .map(|step| step * reach_of(scheme));
    let (finite_bodies, body) = match implicit {
        Some(_) => (None, None),
        None => (
            limiting.finite_bodies(scheme, critical_time_step),
            BodyStepAnswer::new(limiting.problem, f, scheme)?,
        ),
    };
    Ok(DiscretizationAnswer {
        stable: spectrum.is_stable(),
        mode: named,
        minimum_omega_squared: spectrum.lowest.omega_squared.into(),
        minimum_scaled: minimum,
        wave_vector: list(&wave_vector),
        spatial_wave_vector: list(&analysis.spatial(f, &wave_vector)),
        polarization: list(&mode.polarization.map(|component| component.re)),
        polarization_imaginary: list(&mode.polarization.map(|component| component.im)),
        growth_rate: spectrum.growth_rate(),
        flutter: spectrum.flutters,
        maximum_omega: spectrum.maximum_omega,
        critical_time_step,
        critical_time_step_of: LATTICE_NOTE,
        grid_cell,
        point_spacing: grid_cell.map(|side| side / f64::from(method.points_per_side)),
        integrator: integrator.map(Integrator::name),
        finite_bodies,
        body,
        implicit: (discrete_time.is_none() && explicit.is_none())
            .then(|| ImplicitAnswer::new(spectrum, analysis.dimension(), implicit)),
        discrete_time,
        damped_time_steps_of: (!steps.is_empty()).then(|| {
            if spectrum.is_stable() {
                "all waves"
            } else {
                "waves that do not grow"
            }
        }),
        damped_time_steps: steps
            .into_iter()
            .map(|(integrator, step)| (integrator.name(), step))
            .collect(),
        minimum_scaled_bound: bound,
        minimum_scaled_wave_vector: list(&finite_wave_vector(&spectrum.softest)),
        long_wave_minimum_scaled: spectrum.long_wave.scaled,
        long_wave_direction: list(&spectrum.long_wave.wave_vector),
        gradient_norm: assessment.gradient_norm,
        weakest_mode,
        reduced_cell: reduced(&problem.settings),
    })
}

/// Returns the first `dimension` components of a vector.
pub(super) fn list(dimension: usize, vector: &SVector<f64, 3>) -> Vec<f64> {
    // Adding zero turns a negative zero into a positive one.
    let components = vector.iter().take(dimension);
    components.map(|component| component + 0.0).collect()
}

pub(super) fn rows(matrix: &SMatrix<f64, 3, 3>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

impl DiscretizationAnswer {
    /// Reason why an answer with a critical time step has no step for finite bodies.
    fn unknown_of_finite_bodies(&self) -> Option<String> {
        let integrator = self.integrator?;
        self.critical_time_step.filter(|step| *step > 0.0)?;
        Some(match self.damped_time_steps.is_empty() {
            false => format!("it is computed without damping for {integrator}"),
            true => "the forces of the method on the particles of free blocks are not defined"
                .to_owned(),
        })
    }

    /// Name of the integrator of the critical time step.
    pub(super) fn integrator_words(&self) -> &'static str {
        self.integrator.unwrap_or_default()
    }
}

impl StateAnswer {
    /// Describes whether the state is strongly elliptic.
    pub(super) fn ellipticity(&self) -> String {
        let material = &self.material;
        match (material.ellipticity, &self.material_3d) {
            (Ellipticity::Undecided, _) => format!(
                "undecided: the smallest eigenvalue is zero to rounding ({:.1e})",
                material.rounding
            ),
            (Ellipticity::Lost, _) if material.minimum_acoustic_eigenvalue > 0.0 => {
                "no: g . Q(N) g < 0 for some g and N, though no acoustic eigenvalue is negative"
                    .to_owned()
            }
            (Ellipticity::Lost, _) => "no".to_owned(),
            (Ellipticity::Elliptic, None) => "yes".to_owned(),
            (Ellipticity::Elliptic, Some(in_3d)) => match in_3d.ellipticity {
                Ellipticity::Elliptic => "yes".to_owned(),
                Ellipticity::Lost => {
                    "for in-plane perturbations, not for out-of-plane ones".to_owned()
                }
                Ellipticity::Undecided => format!(
                    "for in-plane perturbations; undecided for out-of-plane ones, zero to rounding ({:.1e})",
                    in_3d.rounding
                ),
            },
        }
    }

    /// Components computed across a sheet or bar with traction-free faces, with their name.
    pub(super) fn found_across(&self) -> Option<(&'static str, String)> {
        let is_membrane =
            self.material.parameters.get("plane") == Some(&Value::Word("membrane".to_owned()));
        if self.material_3d.is_some() || is_membrane {
            return None;
        }
        let f = &self.deformation_gradient;
        let is_bar = self.discretization.wave_vector.len() == 1;
        let (name, places): (_, &[(usize, usize)]) = match is_bar {
            true => (
                "lateral stretches",
                &[(1, 1), (2, 2), (0, 1), (0, 2), (1, 2)],
            ),
            false => ("thickness stretch", &[(2, 2), (0, 2), (1, 2)]),
        };
        // Shears are printed only if they are not zero.
        let shown = places
            .iter()
            .filter(|(i, j)| i == j || told_of(f[*i][*j], 1.0) != "0");
        let one = |(i, j): &(usize, usize)| format!("F{}{} {}", i + 1, j + 1, told(f[*i][*j]));
        let found: Vec<String> = shown.map(one).collect();
        let why = if is_bar {
            "uniaxial stress"
        } else {
            "plane stress"
        };
        Some((
            name,
            format!("{} ({why}: no traction on the faces)", found.join(", ")),
        ))
    }

    /// An eigenvalue of the acoustic tensor with its unit; zero if it is smaller than its rounding error.
    ///
    /// The stiffness against changes of volume is not a measure of this error: it may be larger by any factor.
    pub(super) fn eigenvalue(&self, value: f64, rounding: f64) -> String {
        let significant = if value.abs() <= rounding { 0.0 } else { value };
        self.settings.units().of(told(significant), "Pa")
    }

    /// The verdict with its mechanism.
    pub(super) fn named_verdict(&self) -> String {
        named(self.verdict, self.mechanism)
    }
}

/// A verdict with its mechanism.
pub(super) fn named(verdict: Verdict, mechanism: Option<Mechanism>) -> String {
    let verdict = verdict.title();
    match mechanism {
        Some(mechanism) => format!("{verdict} ({})", mechanism.name()),
        None => verdict.to_owned(),
    }
}

impl std::fmt::Display for StateAnswer {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (material, d) = (&self.material, &self.discretization);
        writeln!(formatter, "{}\n", self.sentence)?;
        for note in &self.notes {
            writeln!(formatter, "note: {note}\n")?;
        }
        writeln!(formatter, "{:<24}{}", "verdict", self.named_verdict())?;
        writeln!(formatter, "{}", self.evidence)?;
        let mut line = |name: &str, text: String| writeln!(formatter, "{name:<24}{text}");
        let of = |name: &str| format!("  {name}");
        let (chosen, defaults) = crate::caption::law(&self.settings);
        line("material", chosen)?;
        if !defaults.is_empty() {
            line(&of("by default"), defaults)?;
        }
        let units = self.settings.units();
        line(&of("Cauchy stress"), units.of(material.stresses(), "(Pa)"))?;
        if let Some((name, found)) = self.found_across() {
            line(&of(name), found)?;
        }
        line(&of("strongly elliptic"), self.ellipticity())?;
        let stiffness = material.stiffness;
        let eigenvalue = |value, rounding| self.eigenvalue(value, rounding);
        line(
            &of("smallest eigenvalue"),
            format!(
                "{} along N = {}",
                eigenvalue(material.minimum_acoustic_eigenvalue, material.rounding),
                vector(&material.direction)
            ),
        )?;
        let fluttering = |flutter: &FlutterAnswer| {
            let FlutterAnswer {
                eigenvalue,
                direction,
            } = flutter;
            let [re, im] = [eigenvalue.re, eigenvalue.im].map(|part| told_of(part, stiffness));
            format!(
                "{} along N = {}",
                units.of(format!("{re} +- {im} i"), "Pa"),
                vector(direction)
            )
        };
        if let Some(flutter) = &material.flutter {
            line(&of("flutter"), fluttering(flutter))?;
        }
        if let Some(in_3d) = &self.material_3d {
            if let Some(flutter) = in_3d
                .flutter
                .as_ref()
                .filter(|_| material.flutter.is_none())
            {
                line(&of("flutter in 3D"), fluttering(flutter))?;
            }
            line(
                &of("in 3D"),
                format!(
                    "{} along N = {}, polarized along {}; nowhere below {}",
                    eigenvalue(in_3d.minimum_acoustic_eigenvalue, in_3d.rounding),
                    vector(&in_3d.direction),
                    vector(&in_3d.polarization),
                    eigenvalue(in_3d.bound, in_3d.rounding)
                ),
            )?;
        }
        let (chosen, defaults) = self.settings.discretization();
        line("discretization", chosen)?;
        line(&of("by default"), defaults)?;
        if let Some((side, apart)) = d.grid_cell.zip(d.point_spacing) {
            let [side, apart] = [side, apart].map(|length| units.of(told(length), "m"));
            let text = format!("grid cells of {side}, points {apart} apart");
            line(&of("spacing"), text)?;
        }
        // Squared frequencies within rounding of the largest squared frequency are zero.
        let fastest = d.maximum_omega * d.maximum_omega;
        let real = told_of(d.minimum_omega_squared.re, fastest);
        let omega_squared = match told_of(d.minimum_omega_squared.im, fastest).as_str() {
            "0" => real,
            imaginary => match imaginary.strip_prefix('-') {
                Some(size) => format!("{real} - {size} i"),
                None => format!("{real} + {imaginary} i"),
            },
        };
        line(&of("smallest omega^2"), units.of(omega_squared, "1/s^2"))?;
        let bound = match d.minimum_scaled_bound {
            Some(bound) => format!("no wave below {}", told_of(bound, 1.0)),
            None => "no bound".to_owned(),
        };
        let minimum = told_of(d.minimum_scaled, 1.0);
        line(&of("scaled minimum"), format!("{minimum} ({bound})"))?;
        line(
            &of(if d.stable {
                "softest mode"
            } else {
                "critical mode"
            }),
            d.mode.clone(),
        )?;
        line(
            &of(if d.stable {
                "softest wave vector"
            } else {
                "critical wave vector"
            }),
            format!(
                "{} (reference), {} (deformed)",
                units.of(vector(&d.wave_vector), "1/m"),
                units.of(vector(&d.spatial_wave_vector), "1/m")
            ),
        )?;
        line(&of("polarization"), vector(&d.polarization))?;
        let during = match &self.relaxation {
            Some(_) if d.growth_rate > 0.0 => " without the delay by relaxation",
            _ => "",
        };
        line(
            &of("growth rate"),
            format!("{}{during}", units.of(told(d.growth_rate), "1/s")),
        )?;
        let without = match d.damped_time_steps.is_empty() {
            true => "",
            false => "without damping ",
        };
        let of_integrators = d.critical_time_step.filter(|_| d.discrete_time.is_none());
        let step = of_integrators.map_or_else(String::new, |step| {
            format!(
                "; {} {without}{}",
                d.integrator_words(),
                match step {
                    0.0 => "is unstable for every time step".to_owned(),
                    step => format!(
                        "needs a time step below {} ({LATTICE_NOTE})",
                        units.of(told(step), "s")
                    ),
                }
            )
        });
        line(
            &of("largest frequency"),
            format!("{}{step}", units.of(told(d.maximum_omega), "1/s")),
        )?;
        if let Some(mode) = &d.weakest_mode {
            line(
                &of("weakest wave"),
                format!(
                    "{} of the frequency of the material's slowest wave, at {} (reference configuration); weakly controlled below {}",
                    percent(mode.relative_frequency),
                    units.of(vector(&mode.wave_vector), "1/m"),
                    percent(mode.weak)
                ),
            )?;
        }
        for (name, text) in d.discrete_time.iter().flat_map(|own| own.lines(units)) {
            line(&of(name), text)?;
        }
        if let Some(finite) = &d.finite_bodies {
            line(&of("finite bodies"), finite.words(units))?;
        } else if let Some(reason) = d.unknown_of_finite_bodies() {
            line(&of("finite bodies"), format!("no step is known: {reason}"))?;
        }
        if let Some(body) = &d.body {
            let particles = counted(body.particles, "particle");
            let step = body.told(units);
            line(&of("this body"), format!("{particles}: {step}"))?;
        }
        for (integrator, step) in &d.damped_time_steps {
            let whose = if d.stable {
                ""
            } else {
                " for the waves that do not grow"
            };
            let text = match *step {
                0.0 => format!(
                    "{integrator} is unstable for every time step: some waves have no damping"
                ),
                step => format!(
                    "{integrator} needs a time step below {}{whose}",
                    units.of(told(step), "s")
                ),
            };
            line(&of("with damping"), text)?;
        }
        for (name, text) in d.implicit.iter().flat_map(|own| own.lines(units)) {
            line(&of(name), text)?;
        }
        if let Some(run_step) = &self.run_step {
            line("step of the run", run_step.words(units))?;
        }
        if let Some(relaxation) = &self.relaxation {
            line("relaxation", relaxation.words(units))?;
        }
        if let Some(unloading) = &self.unloading {
            line("unloading", unloading.words(units))?;
        }
        if let Some(certificate) = &self.certificate {
            writeln!(formatter, "{certificate}")?;
        }
        for (number, command) in self.next.iter().enumerate() {
            let name = if number == 0 { "next" } else { "" };
            writeln!(formatter, "{name:<24}{command}")?;
        }
        Ok(())
    }
}

impl MaterialAnswer {
    /// The Cauchy stress, with out-of-plane shears if they are not zero.
    pub(super) fn stresses(&self) -> String {
        let stiffness = self.stiffness;
        let plane = [(0, 0), (1, 1), (0, 1), (2, 2)];
        let out = [(0, 2), (1, 2)].into_iter();
        let out = out.filter(|(i, j)| told_of(self.cauchy[*i][*j], stiffness) != "0");
        let one = |(i, j): (usize, usize)| {
            let value = told_of(self.cauchy[i][j], stiffness);
            format!("s{}{} {value}", i + 1, j + 1)
        };
        let all: Vec<String> = plane.into_iter().chain(out).map(one).collect();
        all.join(", ")
    }
}
