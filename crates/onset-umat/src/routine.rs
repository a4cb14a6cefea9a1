//! The routine itself: the only place where foreign code is called.

use crate::frame::{Passed, Reply};
use crate::increment::Increment;
use crate::voigt::{strain, strain_like, stress_like, symmetric};
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use nalgebra::Matrix3;
use std::path::Path;

/// Numbers behind the end of `STATEV` and `PROPS` that belong to nobody, to notice who goes there.
const MARGIN: usize = 64;

/// What stands in the margins: a NaN that no computation makes.
const NOBODY: f64 = f64::from_bits(0x7ff8_0a11_0000_b0d1);

/// `SUBROUTINE UMAT` as Fortran compilers lay it out: every argument by reference, the length of `CMNAME` by value at the end.
type UmatRoutine = unsafe extern "C" fn(
    stress: *mut f64,
    statev: *mut f64,
    ddsdde: *mut f64,
    sse: *mut f64,
    spd: *mut f64,
    scd: *mut f64,
    rpl: *mut f64,
    ddsddt: *mut f64,
    drplde: *mut f64,
    drpldt: *mut f64,
    stran: *const f64,
    dstran: *const f64,
    time: *const f64,
    dtime: *const f64,
    temp: *const f64,
    dtemp: *const f64,
    predef: *const f64,
    dpred: *const f64,
    cmname: *const u8,
    ndi: *const i32,
    nshr: *const i32,
    ntens: *const i32,
    nstatv: *const i32,
    props: *const f64,
    nprops: *const i32,
    coords: *const f64,
    drot: *const f64,
    pnewdt: *mut f64,
    celent: *const f64,
    dfgrd0: *const f64,
    dfgrd1: *const f64,
    noel: *const i32,
    npt: *const i32,
    layer: *const i32,
    kspt: *const i32,
    jstep: *const i32,
    kinc: *const i32,
    cmname_length: usize,
);

/// `SUBROUTINE SDVINI`, which sets the first state variables.
type SdviniRoutine = unsafe extern "C" fn(
    statev: *mut f64,
    coords: *const f64,
    nstatv: *const i32,
    ncrds: *const i32,
    noel: *const i32,
    npt: *const i32,
    layer: *const i32,
    kspt: *const i32,
);

/// `CMNAME`: a name of 80 letters.
const NAME: [u8; 80] = {
    let mut name = [b' '; 80];
    (name[0], name[1], name[2], name[3], name[4]) = (b'O', b'N', b'S', b'E', b'T');
    name
};

/// Why there is no routine.
pub enum LoadError {
    Library(String),
    NoRoutine,
}

/// A loaded UMAT with its properties.
pub struct Routine {
    umat: UmatRoutine,
    sdvini: Option<SdviniRoutine>,
    properties: Vec<f64>,
    property_count: i32,
    variables: usize,
    variable_count: i32,
    /// Keeps the code in memory.
    _library: Library,
}

/// A material point between increments.
struct Point {
    stress: [f64; 6],
    variables: Vec<f64>,
    ddsdde: [f64; 36],
    /// `SSE`, `SPD`, `SCD`.
    energies: [f64; 3],
    strain: [f64; 6],
    factor: f64,
}

/// Which increment of how many.
struct Step {
    /// Counted from 1.
    number: i32,
    /// The part of the whole time, 1, that it takes.
    duration: f64,
}

impl Routine {
    /// Loads a library.
    #[allow(unsafe_code)]
    pub fn load(path: &Path, properties: &[f64], variables: usize) -> Result<Self, LoadError> {
        // Every routine that the library needs must be there now, not in the middle of a call.
        let flags = RTLD_NOW | RTLD_LOCAL;
        // SAFETY: loading runs the initializers of a library that the user named in order to run it; they may do anything, which
        // is why this happens in a process that has nothing to lose.
        let library = unsafe { Library::open(Some(path), flags) }
            .map_err(|error| LoadError::Library(error.to_string()))?;
        let umat = ["umat_", "umat", "UMAT"].iter().find_map(|name| {
            // SAFETY: a symbol of this name is Abaqus's UMAT by the user's word; its signature is fixed by Abaqus's manual.
            unsafe { library.get::<UmatRoutine>(name.as_bytes()) }
                .ok()
                .map(|symbol| *symbol)
        });
        let sdvini = ["sdvini_", "sdvini", "SDVINI"].iter().find_map(|name| {
            // SAFETY: likewise for SDVINI.
            unsafe { library.get::<SdviniRoutine>(name.as_bytes()) }
                .ok()
                .map(|symbol| *symbol)
        });
        let mut padded = properties.to_vec();
        padded.extend([NOBODY; MARGIN]);
        let count = |size: usize| {
            i32::try_from(size).map_err(|_| LoadError::Library("too many numbers".to_owned()))
        };
        Ok(Self {
            umat: umat.ok_or(LoadError::NoRoutine)?,
            sdvini,
            property_count: count(properties.len())?,
            properties: padded,
            variables,
            variable_count: count(variables)?,
            _library: library,
        })
    }

    /// The outcome at the end of a path from the identity.
    pub fn follow(&self, path: &[Matrix3<f64>]) -> Reply {
        let mut point = self.fresh();
        let mut start = Matrix3::identity();
        let duration = 1.0 / path.len() as f64;
        for (number, end) in (1_u32..).zip(path) {
            let step = Step {
                number: i32::try_from(number).unwrap_or(i32::MAX),
                duration,
            };
            let Some(increment) = Increment::between(start, *end) else {
                return point.reply(Passed::NoIncrement, number, self.variables);
            };
            self.call(&mut point, &increment, &step);
            if point.variables[self.variables..]
                .iter()
                .any(|value| value.to_bits() != NOBODY.to_bits())
            {
                return point.reply(Passed::Overrun, number, self.variables);
            }
            if point.factor < 1.0 {
                return point.reply(Passed::SmallerIncrement, number, self.variables);
            }
            start = *end;
        }
        let count = u32::try_from(path.len()).unwrap_or(u32::MAX);
        point.reply(Passed::Done, count, self.variables)
    }

    /// A point without history.
    #[allow(unsafe_code)]
    fn fresh(&self) -> Point {
        let mut variables = vec![0.0; self.variables];
        variables.extend([NOBODY; MARGIN]);
        if let Some(sdvini) = self.sdvini {
            let (three, one) = (3, 1);
            // SAFETY: every pointer is to a live value or array of at least the size that SDVINI is told; `statev` is ours alone
            // and has a margin.
            unsafe {
                sdvini(
                    variables.as_mut_ptr(),
                    [0.0; 3].as_ptr(),
                    &self.variable_count,
                    &three,
                    &one,
                    &one,
                    &one,
                    &one,
                );
            }
        }
        Point {
            stress: [0.0; 6],
            variables,
            ddsdde: [0.0; 36],
            energies: [0.0; 3],
            strain: [0.0; 6],
            factor: 1.0,
        }
    }

    /// One call.
    #[allow(unsafe_code)]
    fn call(&self, point: &mut Point, increment: &Increment, step: &Step) {
        // Abaqus turns stress and strain along with the material before the call.
        let turn =
            |tensor: Matrix3<f64>| increment.rotation * tensor * increment.rotation.transpose();
        if step.number > 1 {
            point.stress = stress_like(&turn(symmetric(&point.stress))).into();
            point.strain = strain_like(&turn(strain(&point.strain))).into();
        }
        point.ddsdde = [0.0; 36];
        // More than 1 means that there is no wish.
        point.factor = 1.0;
        let strain_increment = strain_like(&increment.strain);
        let start = f64::from(step.number - 1) * step.duration;
        let time = [start, start];
        let [sse, spd, scd] = &mut point.energies;
        let (mut heat, mut heat_by_temperature) = (0.0, 0.0);
        let (mut stress_by_temperature, mut heat_by_strain) = ([0.0; 6], [0.0; 6]);
        // Step 1, a static procedure, with large deformations, not a perturbation.
        let procedure = [1, 1, 1, 0];
        let (zero, one, three, six) = (0.0, 1, 3, 6);
        let (fields, origin, length) = ([0.0; 1], [0.0; 3], 1.0);
        // SAFETY: every pointer is to a live value or array of at least the size that Abaqus's manual gives for it; those that
        // UMAT writes to are exclusively ours, STATEV and PROPS have margins, and matrices are stored by columns, as Fortran's. A
        // UMAT that goes further can spoil this process, which holds nothing but this material.
        unsafe {
            (self.umat)(
                point.stress.as_mut_ptr(),
                point.variables.as_mut_ptr(),
                point.ddsdde.as_mut_ptr(),
                sse,
                spd,
                scd,
                &mut heat,
                stress_by_temperature.as_mut_ptr(),
                heat_by_strain.as_mut_ptr(),
                &mut heat_by_temperature,
                point.strain.as_ptr(),
                strain_increment.as_ptr(),
                time.as_ptr(),
                &step.duration,
                &zero,
                &zero,
                fields.as_ptr(),
                fields.as_ptr(),
                NAME.as_ptr(),
                &three,
                &three,
                &six,
                &self.variable_count,
                self.properties.as_ptr(),
                &self.property_count,
                origin.as_ptr(),
                increment.rotation.as_ptr(),
                &mut point.factor,
                &length,
                increment.start.as_ptr(),
                increment.end.as_ptr(),
                &one,
                &one,
                &one,
                &one,
                procedure.as_ptr(),
                &step.number,
                NAME.len(),
            );
        }
        for (sum, part) in point.strain.iter_mut().zip(strain_increment.iter()) {
            *sum += part;
        }
    }
}

impl Point {
    fn reply(&self, passed: Passed, increment: u32, variables: usize) -> Reply {
        let mut numbers = Vec::with_capacity(crate::frame::FIXED + variables);
        numbers.extend(self.stress);
        numbers.extend(self.ddsdde);
        numbers.extend(self.energies);
        numbers.push(self.factor);
        numbers.extend(&self.variables[..variables]);
        Reply {
            passed,
            increment,
            numbers,
        }
    }
}
