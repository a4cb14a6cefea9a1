//! User material as a material of `onset`.

use crate::arguments::NAMES;
use crate::conversion::Delivered;
use crate::error::UmatError;
use crate::frame::{FIXED, Passed, Reply};
use crate::increment::proportional_path;
use crate::interface::Interface;
use crate::voigt::VOIGT;
use nalgebra::{Matrix3, Matrix6};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, MaterialError, Response};
use onset::plasticity::IncrementalLaw;
use std::path::PathBuf;
use std::time::Duration;

/// Settings of a user material.
#[derive(Clone, Debug, PartialEq)]
pub struct UmatSettings {
    /// Interface of the routine.
    pub interface: Interface,
    /// Name of the behavior in an MFront library; `None` for the only one.
    pub behavior: Option<String>,
    /// Shared library that contains the routine.
    ///
    /// The library is loaded from a copy, which finds other libraries by absolute paths or `LD_LIBRARY_PATH`, not by `$ORIGIN`.
    pub library: PathBuf,
    /// `PROPS`, in the units of the routine.
    pub properties: Vec<f64>,
    /// `NSTATV`, the number of state variables. They start at zero unless the library contains `sdvini_`. Behaviors of MFront state it themselves.
    pub state_variables: usize,
    /// Number of increments from the identity to a state.
    pub increments: u32,
    /// Time limit for a state with all its increments.
    pub time_limit: Duration,
    /// Memory limit for the process of the routine, in bytes of address space, including loaded libraries.
    pub memory_limit: u64,
    /// Required SHA-256 sum of the library, as from [`fingerprint`](crate::fingerprint()); `None` for the library present at the start.
    pub fingerprint: Option<String>,
    /// Program whose `main` begins with [`serve_if_asked`](crate::serve_if_asked), in which the routine runs.
    ///
    /// `None` for the program in the variable `ONSET_UMAT_HOST`, the running program, or `onset` in the same folder or on the path.
    pub host: Option<PathBuf>,
}

impl UmatSettings {
    /// Settings with the given properties, no state variables, one increment, and limits of 10 s per state and 4 GiB.
    pub fn new(library: impl Into<PathBuf>, properties: &[f64]) -> Self {
        Self {
            interface: Interface::default(),
            behavior: None,
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

/// Output of a UMAT at the end of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Stress, tangent and strain energy.
    pub delivered: Delivered,
    /// `SPD`, the plastic dissipation.
    pub plastic_dissipation: f64,
    /// `SCD`, the creep dissipation.
    pub creep_dissipation: f64,
    /// `STATEV`, the state variables.
    pub state_variables: Vec<f64>,
}

/// User material in a shared library.
///
/// Concurrent threads use separate processes, since a routine may store data in variables that threads would share.
pub struct Umat {
    settings: UmatSettings,
    /// Whether a tangent was computed from differences of the stress.
    is_differenced: std::sync::atomic::AtomicBool,
    #[cfg(unix)]
    idle: std::sync::Mutex<Vec<crate::process::Process>>,
}

/// Number of paths sent in one batch; small enough for the replies to fit into the system's buffers.
#[cfg(unix)]
const BATCH_PATHS: usize = 64;

impl Umat {
    /// Loads the library of a user material.
    ///
    /// # Errors
    /// [`UmatError`] if the library does not exist, cannot be loaded, or contains no UMAT.
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
        // Every further process must run the same library.
        let settings = UmatSettings {
            fingerprint: Some(first.fingerprint().to_owned()),
            state_variables: first.variables(),
            ..settings
        };
        Ok(Self {
            settings,
            is_differenced: std::sync::atomic::AtomicBool::new(false),
            idle: std::sync::Mutex::new(vec![first]),
        })
    }

    /// Unsupported on this system.
    ///
    /// # Errors
    /// [`UmatError::Platform`], always.
    #[cfg(not(unix))]
    pub fn new(_settings: UmatSettings) -> Result<Self, UmatError> {
        Err(UmatError::Platform)
    }

    /// Settings of the material.
    pub fn settings(&self) -> &UmatSettings {
        &self.settings
    }

    /// Returns true if the routine has delivered no tangent, so that `onset` computed one from differences of the stress.
    pub fn is_differenced(&self) -> bool {
        self.is_differenced
            .load(std::sync::atomic::Ordering::Relaxed)
    }

    /// Path from the identity to a state.
    ///
    /// # Errors
    /// [`UmatError::Increments`] if the state has no logarithmic strain.
    pub fn path(&self, f: &DeformationGradient) -> Result<Vec<Matrix3<f64>>, UmatError> {
        proportional_path(f, self.settings.increments)
    }

    /// Outcome at the end of a path of deformation gradients, whose first increment starts at the identity.
    ///
    /// # Errors
    /// [`UmatError`] if the routine or its process fails.
    pub fn along(&self, path: Vec<Matrix3<f64>>) -> Result<Outcome, UmatError> {
        self.along_all(&[path])
            .pop()
            .unwrap_or(Err(UmatError::Increments { increments: 0 }))
    }

    /// Outcomes at the ends of paths of equal length, several times faster than single calls.
    ///
    /// # Errors
    /// Fails for each path like [`Umat::along`]; if the process ends on one path, the others are still evaluated.
    #[cfg(unix)]
    pub fn along_all(&self, paths: &[Vec<Matrix3<f64>>]) -> Vec<Result<Outcome, UmatError>> {
        let mut outcomes = Vec::with_capacity(paths.len());
        while outcomes.len() < paths.len() {
            outcomes.extend(self.batch(&paths[outcomes.len()..]));
        }
        outcomes
    }

    /// Outcomes at the ends of paths of equal length, if all of them are needed.
    ///
    /// Stops at the first failure, so that an endless loop in the routine costs its time limit only once.
    ///
    /// # Errors
    /// The first error of [`Umat::along_all`].
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

    /// Outcomes of the first paths, up to a failure of the process; at least one.
    #[cfg(unix)]
    fn batch(&self, paths: &[Vec<Matrix3<f64>>]) -> Vec<Result<Outcome, UmatError>> {
        let batch = &paths[..paths.len().min(BATCH_PATHS)];
        let mut replies = Vec::with_capacity(batch.len());
        let failure = self.ask(batch, &mut replies).err();
        let answered = batch.iter().zip(replies);
        answered
            .map(|(path, reply)| self.outcome(path, reply))
            .chain(failure.map(Err))
            .collect()
    }

    /// Unsupported on this system.
    ///
    /// # Errors
    /// [`UmatError::Platform`], always.
    #[cfg(not(unix))]
    pub fn along_every(&self, _paths: &[Vec<Matrix3<f64>>]) -> Result<Vec<Outcome>, UmatError> {
        Err(UmatError::Platform)
    }

    /// Unsupported on this system.
    #[cfg(not(unix))]
    pub fn along_all(&self, paths: &[Vec<Matrix3<f64>>]) -> Vec<Result<Outcome, UmatError>> {
        paths.iter().map(|_| Err(UmatError::Platform)).collect()
    }

    /// Evaluates paths in an idle or new process; a process that has failed is not used again.
    #[cfg(unix)]
    fn ask(&self, paths: &[Vec<Matrix3<f64>>], replies: &mut Vec<Reply>) -> Result<(), UmatError> {
        onset::cancel::checkpoint();
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
        // A process with an overrun may be corrupted further, and is not used again.
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
            Passed::Differenced => {
                self.is_differenced
                    .store(true, std::sync::atomic::Ordering::Relaxed);
            }
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
            Passed::Skew if numbers.iter().all(|number| number.is_finite()) => {
                return Err(UmatError::Skew { state });
            }
            Passed::Skew => {}
            Passed::NoIncrement => return Err(UmatError::Increment { increment, state }),
        }
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(UmatError::NotFinite {
                what: place(self.settings.interface, at),
                value: numbers[at],
                interface: self.settings.interface,
                properties: self.settings.properties.len(),
                variables: self.settings.state_variables,
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

/// Name of the array, and index, of a number in a reply.
fn place(interface: Interface, at: usize) -> String {
    let is_umat = interface == Interface::Umat;
    match at {
        0..6 => {
            let (i, j) = VOIGT[at];
            let sigma = format!("sigma_{}{}", i + 1, j + 1);
            match interface {
                Interface::Umat => format!("STRESS({}) ({sigma})", at + 1),
                Interface::Vumat => format!("stressNew ({sigma})"),
                Interface::Law | Interface::Mfront => format!("P ({sigma})"),
            }
        }
        6..42 if interface == Interface::Law => "A (is only a part of it set?)".to_owned(),
        6..42 if interface == Interface::Mfront => "K".to_owned(),
        6..42 if !is_umat => "differences of the stress".to_owned(),
        42 if !is_umat => "the energy".to_owned(),
        46.. if !is_umat => format!("state variable {}", at - FIXED + 1),
        6..42 => format!("DDSDDE({},{})", (at - 6) % 6 + 1, (at - 6) / 6 + 1),
        42 => "SSE".to_owned(),
        43 => "SPD".to_owned(),
        44 => "SCD".to_owned(),
        45 => "PNEWDT".to_owned(),
        _ => format!("STATEV({})", at - FIXED + 1),
    }
}

impl Hyperelastic for Umat {
    /// A user material counts as path-dependent.
    ///
    /// `DDSDDE` is the tangent of the last increment, for continued flow or an algorithmic step. The stress of a plastic routine depends on the whole
    /// path, so that this is not the derivative with respect to its end.
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
