//! A user material as a material of `onset`.

use crate::arguments::NAMES;
use crate::conversion::Delivered;
use crate::error::UmatError;
use crate::frame::{FIXED, Passed, Reply};
use crate::increment::proportional_path;
use crate::voigt::VOIGT;
use nalgebra::{Matrix3, Matrix6};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, MaterialError, Response};
use onset::plasticity::IncrementalLaw;
use std::path::PathBuf;
use std::time::Duration;

/// What a user material is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct UmatSettings {
    /// The shared library that holds `umat_`. A copy of it is loaded: libraries beside it are found by absolute paths or
    /// `LD_LIBRARY_PATH`, not by `$ORIGIN`.
    pub library: PathBuf,
    /// `PROPS`, in the routine's own units.
    pub properties: Vec<f64>,
    /// `NSTATV`: state variables, which are zero at first unless the library holds `sdvini_`.
    pub state_variables: usize,
    /// Increments in which a state is reached from the identity.
    pub increments: u32,
    /// How long a state may take, all its increments together.
    pub time_limit: Duration,
    /// How much memory the process of the routine may take, in bytes: its address space, which libraries that it loads share.
    pub memory_limit: u64,
    /// The SHA-256 that the library must have (see [`fingerprint`](crate::fingerprint())); the one that it has at first when none is
    /// named.
    pub fingerprint: Option<String>,
    /// The program whose `main` begins with [`serve_if_asked`](crate::serve_if_asked), to run the routine in. When none is named:
    /// the one in the variable `ONSET_UMAT_HOST`, the running one, or `onset` beside it or on the path.
    pub host: Option<PathBuf>,
}

impl UmatSettings {
    /// A library with properties, without state variables, in one increment, at most 10 s a state and 4 GiB.
    pub fn new(library: impl Into<PathBuf>, properties: &[f64]) -> Self {
        Self {
            library: library.into(),
            properties: properties.to_vec(),
            state_variables: 0,
            increments: 1,
            time_limit: Duration::from_secs(10),
            memory_limit: 4 << 30,
            fingerprint: None,
            host: None,
        }
    }
}

/// What a UMAT says at the end of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Stress, tangent and strain energy.
    pub delivered: Delivered,
    /// `SPD`, plastic dissipation.
    pub plastic_dissipation: f64,
    /// `SCD`, creep dissipation.
    pub creep_dissipation: f64,
    /// `STATEV`.
    pub state_variables: Vec<f64>,
}

/// A user material. Each thread that asks at the same time has a process of its own, since a routine may keep things in
/// variables that threads would share.
pub struct Umat {
    settings: UmatSettings,
    #[cfg(unix)]
    idle: std::sync::Mutex<Vec<crate::process::Process>>,
}

/// Paths that are handed over at once; small enough for the answers to fit into what the system buffers.
#[cfg(unix)]
const BATCH: usize = 64;

impl Umat {
    /// Loads a library.
    ///
    /// # Errors
    /// [`UmatError`] when there is no such library, it cannot be loaded, or it holds no UMAT.
    #[cfg(unix)]
    pub fn new(settings: UmatSettings) -> Result<Self, UmatError> {
        if !settings.library.is_file() {
            return Err(UmatError::NoLibrary {
                path: settings.library,
            });
        }
        if settings.increments == 0 {
            return Err(UmatError::Increments { increments: 0 });
        }
        let first = crate::process::Process::start(&settings)?;
        // Every other process must run the same library.
        let settings = UmatSettings {
            fingerprint: Some(first.fingerprint().to_owned()),
            ..settings
        };
        Ok(Self {
            settings,
            idle: std::sync::Mutex::new(vec![first]),
        })
    }

    /// Not on this system.
    ///
    /// # Errors
    /// [`UmatError::Platform`], always.
    #[cfg(not(unix))]
    pub fn new(_settings: UmatSettings) -> Result<Self, UmatError> {
        Err(UmatError::Platform)
    }

    /// What it is made of.
    pub fn settings(&self) -> &UmatSettings {
        &self.settings
    }

    /// The path on which it reaches a state.
    ///
    /// # Errors
    /// [`UmatError::Increments`] when the state has no logarithmic strain.
    pub fn path(&self, f: &DeformationGradient) -> Result<Vec<Matrix3<f64>>, UmatError> {
        proportional_path(f, self.settings.increments)
    }

    /// The outcome at the end of a path of deformation gradients that starts, one increment before its first one, from the
    /// identity.
    ///
    /// # Errors
    /// [`UmatError`] when the routine or its process fails.
    pub fn along(&self, path: Vec<Matrix3<f64>>) -> Result<Outcome, UmatError> {
        self.along_all(&[path])
            .pop()
            .unwrap_or(Err(UmatError::Increments { increments: 0 }))
    }

    /// The outcomes at the ends of paths of equal length, several times faster than one by one.
    ///
    /// # Errors
    /// For each path as for [`Umat::along`]; a path on which the process ends does not keep the others from being followed.
    #[cfg(unix)]
    pub fn along_all(&self, paths: &[Vec<Matrix3<f64>>]) -> Vec<Result<Outcome, UmatError>> {
        let mut outcomes = Vec::with_capacity(paths.len());
        while outcomes.len() < paths.len() {
            outcomes.extend(self.batch(&paths[outcomes.len()..]));
        }
        outcomes
    }

    /// The outcomes at the ends of paths of equal length when all are needed: after a failure nothing more is asked, so that an
    /// endless loop in the routine costs its time limit once.
    ///
    /// # Errors
    /// The first that [`Umat::along_all`] has.
    #[cfg(unix)]
    pub fn along_every(&self, paths: &[Vec<Matrix3<f64>>]) -> Result<Vec<Outcome>, UmatError> {
        let mut outcomes = Vec::with_capacity(paths.len());
        while outcomes.len() < paths.len() {
            for outcome in self.batch(&paths[outcomes.len()..]) {
                outcomes.push(outcome?);
            }
        }
        Ok(outcomes)
    }

    /// Outcomes on the first of some paths, up to a failure of the process; one at least.
    #[cfg(unix)]
    fn batch(&self, paths: &[Vec<Matrix3<f64>>]) -> Vec<Result<Outcome, UmatError>> {
        let batch = &paths[..paths.len().min(BATCH)];
        let mut replies = Vec::with_capacity(batch.len());
        let failure = self.ask(batch, &mut replies).err();
        let answered = batch.iter().zip(replies);
        answered
            .map(|(path, reply)| self.outcome(path, reply))
            .chain(failure.map(Err))
            .collect()
    }

    /// Not on this system.
    ///
    /// # Errors
    /// [`UmatError::Platform`], always.
    #[cfg(not(unix))]
    pub fn along_every(&self, _paths: &[Vec<Matrix3<f64>>]) -> Result<Vec<Outcome>, UmatError> {
        Err(UmatError::Platform)
    }

    /// Not on this system.
    #[cfg(not(unix))]
    pub fn along_all(&self, paths: &[Vec<Matrix3<f64>>]) -> Vec<Result<Outcome, UmatError>> {
        paths.iter().map(|_| Err(UmatError::Platform)).collect()
    }

    /// Asks an idle process, or a new one; one that has failed is not asked again.
    #[cfg(unix)]
    fn ask(&self, paths: &[Vec<Matrix3<f64>>], replies: &mut Vec<Reply>) -> Result<(), UmatError> {
        let idle = || {
            self.idle
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner)
        };
        let waiting = {
            let mut idle = idle();
            idle.retain(crate::process::Process::is_ours);
            idle.pop()
        };
        let mut process = match waiting {
            Some(process) => process,
            None => crate::process::Process::start(&self.settings)?,
        };
        process.follow(paths, replies)?;
        // One that has written where it should not may have spoiled more.
        if replies.iter().all(|reply| reply.passed != Passed::Overrun) {
            idle().push(process);
        }
        Ok(())
    }

    fn outcome(&self, path: &[Matrix3<f64>], reply: Reply) -> Result<Outcome, UmatError> {
        let state = match path.last() {
            Some(state) => Box::new(*state),
            None => return Err(UmatError::Increments { increments: 0 }),
        };
        let numbers = reply.numbers;
        let increment = reply.increment;
        match reply.passed {
            Passed::Done => {}
            Passed::SmallerIncrement => {
                return Err(UmatError::SmallerIncrement {
                    factor: numbers[FIXED - 1],
                    increment,
                    increments: self.settings.increments,
                    state,
                });
            }
            Passed::Overrun => {
                let argument = NAMES.get(reply.argument as usize).copied();
                return Err(UmatError::Overrun {
                    argument: argument.unwrap_or("an argument"),
                    variables: self.settings.state_variables,
                    state,
                });
            }
            Passed::NoIncrement => return Err(UmatError::Increment { increment, state }),
        }
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(UmatError::NotFinite {
                what: place(at),
                value: numbers[at],
                properties: self.settings.properties.len(),
                state,
            });
        }
        Ok(Outcome {
            delivered: Delivered {
                stress: std::array::from_fn(|n| numbers[n]),
                ddsdde: Matrix6::from_column_slice(&numbers[6..42]),
                sse: numbers[42],
            },
            plastic_dissipation: numbers[43],
            creep_dissipation: numbers[44],
            state_variables: numbers[FIXED..].to_vec(),
        })
    }
}

/// The array and the index of a number in a reply.
fn place(at: usize) -> String {
    match at {
        0..6 => {
            let (i, j) = VOIGT[at];
            format!("STRESS({}) (sigma_{}{})", at + 1, i + 1, j + 1)
        }
        6..42 => format!("DDSDDE({},{})", (at - 6) % 6 + 1, (at - 6) / 6 + 1),
        42 => "SSE".to_owned(),
        43 => "SPD".to_owned(),
        44 => "SCD".to_owned(),
        45 => "PNEWDT".to_owned(),
        _ => format!("STATEV({})", at - FIXED + 1),
    }
}

impl Hyperelastic for Umat {
    /// What a routine delivers is the tangent of its last increment, of flow that goes on or of a step of the algorithm: neither is the derivative of the stress by
    /// the end of the path, on which a routine that flows depends.
    fn is_path_dependent(&self) -> bool {
        true
    }

    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let outcome = self.along(self.path(f)?)?;
        outcome.delivered.response(f).finite()
    }
}

impl IncrementalLaw for Umat {
    fn after(&self, history: &[DeformationGradient]) -> Result<Response, MaterialError> {
        let path = history.iter().map(DeformationGradient::matrix).collect();
        let end = history.last().copied();
        let end = end.unwrap_or_else(DeformationGradient::identity);
        self.along(path)?.delivered.response(&end).finite()
    }
}
