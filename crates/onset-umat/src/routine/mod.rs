//! The routine itself; foreign code is called only here.

mod law;
mod mfront;
mod umat;
mod vumat;

use crate::arguments::Arguments;
use crate::conversion::Delivered;
use crate::frame::{Passed, Reply};
use crate::increment::Increment;
use crate::interface::Interface;
use crate::voigt::{VOIGT, stress_like, symmetric};
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset::material::{FourthOrder, Response};
use std::path::Path;

/// `CMNAME`, a name of 80 characters.
const NAME: [u8; 80] = {
    let mut name = [b' '; 80];
    (name[0], name[1], name[2], name[3], name[4]) = (b'O', b'N', b'S', b'E', b'T');
    name
};

/// Strain of the differences that give a tangent, 2^-16: rounding causes errors of about 1e-10 of the tangent.
const DIFFERENCE_STRAIN: f64 = 1.0 / 65_536.0;

/// Largest strain of the differences as a fraction of the strain of the increment, so that differences do not unload a flowing material.
const PART_OF_INCREMENT: f64 = 1.0 / 64.0;

/// Smallest strain of the differences, 2^-26, at which rounding errors reach 1e-7 of the tangent.
const LEAST_STRAIN: f64 = 1.0 / 67_108_864.0;

/// Largest accepted part of a response that violates the balance of angular momentum, relative to the tangent. A stress with single-precision
/// rounding is accepted.
const SKEW_TOLERANCE: f64 = 1e-6;

/// Largest accepted part of a tangent from differences that violates the balance of angular momentum; differences amplify rounding of the stress.
const DIFFERENCE_SKEW_TOLERANCE: f64 = 1e-3;

/// Reason why the routine cannot be loaded.
pub enum LoadError {
    Library(String),
    NoRoutine,
    /// Routine that cannot be used, with the reason.
    Unsuitable(String),
}

/// Index in [`crate::arguments::NAMES`] of an argument that was written beyond its ends.
struct Overrun(usize);

impl Overrun {
    /// Checks the margins of a block after a call.
    fn check(block: &Arguments) -> Result<(), Self> {
        block
            .overrun()
            .map_or(Ok(()), |argument| Err(Self(argument)))
    }
}

/// Routine of a library, by its interface.
enum Entry {
    Umat(umat::Umat),
    Vumat(vumat::Vumat),
    Law(law::Law),
    Mfront(mfront::Behavior),
}

/// Routine of a library with its properties.
pub struct Setup {
    pub interface: Interface,
    /// Name of the behavior of an MFront library, if it is given.
    pub behavior: Option<String>,
    pub properties: Vec<f64>,
    /// Number of state variables, unless the library states it.
    pub variables: usize,
}

/// Properties and sizes, which every call passes.
struct Data {
    properties: Vec<f64>,
    property_count: i32,
    variable_count: i32,
}

/// Loaded routine with its properties.
pub struct Routine {
    entry: Entry,
    data: Data,
    variables: usize,
    /// Keeps the code in memory.
    _library: Library,
}

/// State of a material point between increments.
#[derive(Clone)]
struct Point {
    /// Cauchy stress, in the order of Abaqus/Standard.
    stress: [f64; 6],
    variables: Vec<f64>,
    /// `DDSDDE` by columns, if the routine delivers it.
    ddsdde: Option<[f64; 36]>,
    /// Energies `SSE`, `SPD`, `SCD` per current volume.
    energies: [f64; 3],
    strain: [f64; 6],
    factor: f64,
    /// Antisymmetric part of the Cauchy stress, which violates the balance of angular momentum.
    skew: Matrix3<f64>,
    /// Largest component of the tangent that violates the balance of angular momentum, relative to its tolerance.
    skew_of_tangent: f64,
}

/// Number and duration of an increment.
struct Step {
    /// Number of the increment, from 1.
    number: i32,
    /// Duration as a fraction of the total time, 1.
    duration: f64,
}

/// First symbol of a library with one of the names.
///
/// # Safety
/// The symbol must have the type `T`, a function pointer.
#[allow(unsafe_code)]
unsafe fn found<T: Copy>(library: &Library, names: &[&str]) -> Option<T> {
    names.iter().find_map(|name| {
        // SAFETY: as the caller guarantees.
        unsafe { library.get::<T>(name.as_bytes()) }
            .ok()
            .map(|symbol| *symbol)
    })
}

impl Entry {
    fn find(library: &Library, path: &Path, setup: &Setup) -> Result<Self, LoadError> {
        let found = match setup.interface {
            Interface::Umat => umat::Umat::find(library).map(Self::Umat),
            Interface::Vumat => vumat::Vumat::find(library).map(Self::Vumat),
            Interface::Law => law::Law::find(library).map(Self::Law),
            Interface::Mfront => {
                let (name, count) = (setup.behavior.as_deref(), setup.properties.len());
                let behavior = mfront::Behavior::find(library, path, name, count)?;
                return Ok(Self::Mfront(behavior));
            }
        };
        found.ok_or(LoadError::NoRoutine)
    }
}

impl Routine {
    /// Loads a library and finds its routines.
    #[allow(unsafe_code)]
    pub fn load(path: &Path, setup: Setup) -> Result<Self, LoadError> {
        // All routines that the library needs must be resolved now, and not during a call.
        let flags = RTLD_NOW | RTLD_LOCAL;
        // SAFETY: loading runs the initializers of a library that the user named for this purpose. They may do anything; this process is separate
        // from the caller and holds no other data.
        let library = unsafe { Library::open(Some(path), flags) }
            .map_err(|error| LoadError::Library(error.to_string()))?;
        let entry = Entry::find(&library, path, &setup)?;
        let variables = match &entry {
            Entry::Mfront(behavior) => behavior.variables,
            _ => setup.variables,
        };
        let count = |size: usize| {
            i32::try_from(size).map_err(|_| LoadError::Library("too many numbers".to_owned()))
        };
        Ok(Self {
            entry,
            data: Data {
                property_count: count(setup.properties.len())?,
                properties: setup.properties,
                variable_count: count(variables)?,
            },
            variables,
            _library: library,
        })
    }

    /// Number of state variables.
    pub fn variables(&self) -> usize {
        self.variables
    }

    /// Computes the outcome at the end of a path from the identity.
    pub fn follow(&self, path: &[Matrix3<f64>]) -> Reply {
        let mut point = Point {
            stress: [0.0; 6],
            variables: vec![0.0; self.variables],
            ddsdde: None,
            energies: [0.0; 3],
            strain: [0.0; 6],
            factor: 1.0,
            skew: Matrix3::zeros(),
            skew_of_tangent: 0.0,
        };
        if let Entry::Umat(umat) = &self.entry
            && let Err(argument) = umat.set_up(&self.data, &mut point)
        {
            return point.overrun(argument, 0);
        }
        let mut start = Matrix3::identity();
        let duration = 1.0 / path.len() as f64;
        let mut is_differenced = false;
        for (number, end) in (1_u32..).zip(path) {
            let step = Step {
                number: i32::try_from(number).unwrap_or(i32::MAX),
                duration,
            };
            let Some(increment) = Increment::between(start, *end) else {
                return point.reply(Passed::NoIncrement, number);
            };
            // Only the last increment needs a tangent.
            let before = (number as usize == path.len()).then(|| point.clone());
            if let Err(argument) = self.advance(&mut point, &increment, &step) {
                return point.overrun(argument, number);
            }
            if point.factor < 1.0 {
                return point.reply(Passed::SmallerIncrement, number);
            }
            if let Some(before) = before
                && point.ddsdde.is_none()
            {
                is_differenced = true;
                if let Err(argument) = self.differences(&before, &mut point, &increment, &step) {
                    return point.overrun(argument, number);
                }
            }
            start = *end;
        }
        let count = u32::try_from(path.len()).unwrap_or(u32::MAX);
        let passed = match (point.is_symmetric(), is_differenced) {
            (false, _) => Passed::Skew,
            (true, false) => Passed::Done,
            (true, true) => Passed::Differenced,
        };
        point.reply(passed, count)
    }

    /// Advances a point to the end of an increment.
    fn advance(
        &self,
        point: &mut Point,
        increment: &Increment,
        step: &Step,
    ) -> Result<(), Overrun> {
        match &self.entry {
            Entry::Umat(umat) => umat.advance(&self.data, point, increment, step),
            Entry::Vumat(vumat) => vumat.advance(&self.data, point, increment, step),
            Entry::Law(law) => law.advance(&self.data, point, increment, step),
            Entry::Mfront(behavior) => behavior.advance(&self.data, point, increment, step),
        }
    }

    /// `DDSDDE` by columns from central differences of fourth order: the change of `J sigma` with the end of the increment, without spin, over `J`.
    fn differences(
        &self,
        before: &Point,
        point: &mut Point,
        increment: &Increment,
        step: &Step,
    ) -> Result<(), Overrun> {
        let kirchhoff = |rate: Matrix3<f64>| {
            let end = (Matrix3::identity() + rate) * increment.end;
            let Some(increment) = Increment::between(increment.start, end) else {
                return Ok(Matrix3::from_element(f64::NAN));
            };
            let mut point = before.clone();
            self.advance(&mut point, &increment, step)?;
            Ok((symmetric(&point.stress) + point.skew) * end.determinant())
        };
        let strain = PART_OF_INCREMENT * increment.strain.norm();
        let size = match strain < f64::EPSILON {
            true => DIFFERENCE_STRAIN,
            false => strain.clamp(LEAST_STRAIN, DIFFERENCE_STRAIN),
        };
        let (mut ddsdde, mut skew) = ([0.0; 36], 0.0_f64);
        for (column, (k, l)) in ddsdde.chunks_exact_mut(6).zip(VOIGT) {
            let mut rate = Matrix3::zeros();
            rate[(k, l)] += 0.5 * size;
            rate[(l, k)] += 0.5 * size;
            let near = kirchhoff(rate)? - kirchhoff(-rate)?;
            let far = kirchhoff(2.0 * rate)? - kirchhoff(-2.0 * rate)?;
            let change = (8.0 * near - far) / (12.0 * size * increment.end.determinant());
            let mean = 0.5 * (change + change.transpose());
            skew = skew.max((change - mean).amax());
            column.copy_from_slice(stress_like(&mean).as_slice());
        }
        point.ddsdde = Some(ddsdde);
        point.skew_of_tangent = skew / DIFFERENCE_SKEW_TOLERANCE;
        Ok(())
    }
}

impl Point {
    /// Takes over the first Piola-Kirchhoff stress at the end of an increment, and its derivative if the routine delivers it.
    fn take(&mut self, increment: &Increment, piola: &Matrix3<f64>, tangent: Option<FourthOrder>) {
        let kirchhoff = piola * increment.end.transpose();
        let jacobian = increment.end.determinant();
        let mean = 0.5 * (kirchhoff + kirchhoff.transpose());
        self.stress = stress_like(&(mean / jacobian)).into();
        self.skew = 0.5 * (kirchhoff - kirchhoff.transpose()) / jacobian;
        self.ddsdde = None;
        let Some(tangent) = tangent else { return };
        let f = |i: usize, j: usize| increment.end[(i, j)];
        let components = std::array::from_fn(|i| std::array::from_fn(|j| f(i, j)));
        let Ok(deformation) = DeformationGradient::new(components) else {
            self.ddsdde = Some([f64::NAN; 36]);
            return;
        };
        let response = Response {
            deformation,
            energy: 0.0,
            first_piola: *piola,
            tangent,
        };
        // The tangent of the convected rate has both minor symmetries for an objective law.
        let c = response.truesdell_tangent();
        let indices = (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3));
        let skew = indices
            .map(|(i, j, k, l)| {
                let own = c[(i, j, k, l)];
                (own - c[(j, i, k, l)])
                    .abs()
                    .max((own - c[(i, j, l, k)]).abs())
            })
            .fold(0.0, f64::max);
        self.skew_of_tangent = skew / SKEW_TOLERANCE;
        let ddsdde = Delivered::of_response(&response).ddsdde;
        let mut columns = [0.0; 36];
        columns.copy_from_slice(ddsdde.as_slice());
        self.ddsdde = Some(columns);
    }

    /// Returns true if the parts of the response that violate the balance of angular momentum are rounding errors.
    fn is_symmetric(&self) -> bool {
        let largest = |numbers: &[f64]| numbers.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let tangent = largest(self.ddsdde.as_ref().map_or(&[], |ddsdde| ddsdde));
        // NaN is reported as such.
        !(self.skew.amax() > SKEW_TOLERANCE * (largest(&self.stress) + tangent)
            || self.skew_of_tangent > tangent)
    }

    fn reply(&self, passed: Passed, increment: u32) -> Reply {
        let mut numbers = Vec::with_capacity(crate::frame::FIXED + self.variables.len());
        numbers.extend(self.stress);
        numbers.extend(self.ddsdde.unwrap_or([0.0; 36]));
        numbers.extend(self.energies);
        numbers.push(self.factor);
        numbers.extend(&self.variables);
        Reply {
            passed,
            increment,
            argument: 0,
            numbers,
        }
    }

    fn overrun(&self, Overrun(argument): Overrun, increment: u32) -> Reply {
        Reply {
            argument: u32::try_from(argument).unwrap_or(u32::MAX),
            ..self.reply(Passed::Overrun, increment)
        }
    }
}
