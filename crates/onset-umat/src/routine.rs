//! The routine itself; foreign code is called only here.

use crate::arguments::Arguments;
use crate::frame::{Passed, Reply};
use crate::increment::Increment;
use crate::voigt::{strain, strain_like, stress_like, symmetric};
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use nalgebra::Matrix3;
use std::path::Path;

/// `SUBROUTINE UMAT` as compiled Fortran: every argument by reference, the length of `CMNAME` by value at the end.
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

/// `SUBROUTINE SDVINI`, which sets the initial state variables.
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

/// `CMNAME`, a name of 80 characters.
const NAME: [u8; 80] = {
    let mut name = [b' '; 80];
    (name[0], name[1], name[2], name[3], name[4]) = (b'O', b'N', b'S', b'E', b'T');
    name
};

/// Reason why the routine cannot be loaded.
pub enum LoadError {
    Library(String),
    NoRoutine,
}

/// Loaded UMAT with its properties.
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

/// State of a material point between increments.
struct Point {
    stress: [f64; 6],
    variables: Vec<f64>,
    ddsdde: [f64; 36],
    /// Energies `SSE`, `SPD`, `SCD` per volume.
    energies: [f64; 3],
    strain: [f64; 6],
    factor: f64,
}

/// Number and duration of an increment.
struct Step {
    /// Number of the increment, from 1.
    number: i32,
    /// Duration as a fraction of the total time, 1.
    duration: f64,
}

impl Routine {
    /// Loads a library and finds its routines.
    #[allow(unsafe_code)]
    pub fn load(path: &Path, properties: &[f64], variables: usize) -> Result<Self, LoadError> {
        // All routines that the library needs must be resolved now, and not during a call.
        let flags = RTLD_NOW | RTLD_LOCAL;
        // SAFETY: loading runs the initializers of a library that the user named for this purpose. They may do anything; this process is separate
        // from the caller and holds no other data.
        let library = unsafe { Library::open(Some(path), flags) }
            .map_err(|error| LoadError::Library(error.to_string()))?;
        let umat = ["umat_", "umat", "UMAT"].iter().find_map(|name| {
            // SAFETY: the user declares that this symbol is a UMAT of Abaqus; its signature is fixed by the Abaqus manual.
            unsafe { library.get::<UmatRoutine>(name.as_bytes()) }
                .ok()
                .map(|symbol| *symbol)
        });
        let sdvini = ["sdvini_", "sdvini", "SDVINI"].iter().find_map(|name| {
            // SAFETY: as above, for SDVINI.
            unsafe { library.get::<SdviniRoutine>(name.as_bytes()) }
                .ok()
                .map(|symbol| *symbol)
        });
        let count = |size: usize| {
            i32::try_from(size).map_err(|_| LoadError::Library("too many numbers".to_owned()))
        };
        Ok(Self {
            umat: umat.ok_or(LoadError::NoRoutine)?,
            sdvini,
            property_count: count(properties.len())?,
            properties: properties.to_vec(),
            variables,
            variable_count: count(variables)?,
            _library: library,
        })
    }

    /// Computes the outcome at the end of a path from the identity.
    pub fn follow(&self, path: &[Matrix3<f64>]) -> Reply {
        let mut point = Point {
            stress: [0.0; 6],
            variables: vec![0.0; self.variables],
            ddsdde: [0.0; 36],
            energies: [0.0; 3],
            strain: [0.0; 6],
            factor: 1.0,
        };
        if let Err(argument) = self.set_up(&mut point) {
            return point.overrun(argument, 0);
        }
        let mut start = Matrix3::identity();
        let duration = 1.0 / path.len() as f64;
        for (number, end) in (1_u32..).zip(path) {
            let step = Step {
                number: i32::try_from(number).unwrap_or(i32::MAX),
                duration,
            };
            let Some(increment) = Increment::between(start, *end) else {
                return point.reply(Passed::NoIncrement, number);
            };
            if let Err(argument) = self.call(&mut point, &increment, &step) {
                return point.overrun(argument, number);
            }
            if point.factor < 1.0 {
                return point.reply(Passed::SmallerIncrement, number);
            }
            start = *end;
        }
        let count = u32::try_from(path.len()).unwrap_or(u32::MAX);
        point.reply(Passed::Done, count)
    }

    /// Calls SDVINI to set the state variables of a point without history. The error is the index of an argument that was overrun.
    #[allow(unsafe_code)]
    fn set_up(&self, point: &mut Point) -> Result<(), usize> {
        let Some(sdvini) = self.sdvini else {
            return Ok(());
        };
        let mut block = Arguments::of(&[("STATEV", &point.variables), ("COORDS", &[0.0; 3])]);
        let start = block.start();
        let at = |name: &str| start.wrapping_add(block.offset(name));
        let (three, one) = (3, 1);
        // SAFETY: every pointer refers to a live value or array of at least the size passed to SDVINI. Pointers to numbers refer to a block that is
        // used only here, with margins.
        unsafe {
            sdvini(
                at("STATEV"),
                at("COORDS"),
                &self.variable_count,
                &three,
                &one,
                &one,
                &one,
                &one,
            );
        }
        point.variables.copy_from_slice(block.values("STATEV"));
        block.overrun().map_or(Ok(()), Err)
    }

    /// Calls the UMAT once. The error is the index of an argument that was overrun.
    #[allow(unsafe_code)]
    fn call(&self, point: &mut Point, increment: &Increment, step: &Step) -> Result<(), usize> {
        // Abaqus rotates stress and strain with the material before the call.
        let turn =
            |tensor: Matrix3<f64>| increment.rotation * tensor * increment.rotation.transpose();
        if step.number > 1 {
            point.stress = stress_like(&turn(symmetric(&point.stress))).into();
            point.strain = strain_like(&turn(strain(&point.strain))).into();
        }
        let strain_increment = strain_like(&increment.strain);
        let start = f64::from(step.number - 1) * step.duration;
        let [sse, spd, scd] = point.energies;
        // Matrices are stored by columns, as in Fortran. A PNEWDT above 1 means no request. The block is refilled for every call, so that changes
        // of input arguments by the routine do not persist.
        let mut block = Arguments::of(&[
            ("STRESS", &point.stress),
            ("STATEV", &point.variables),
            ("DDSDDE", &[0.0; 36]),
            ("SSE", &[sse]),
            ("SPD", &[spd]),
            ("SCD", &[scd]),
            ("RPL", &[0.0]),
            ("DDSDDT", &[0.0; 6]),
            ("DRPLDE", &[0.0; 6]),
            ("DRPLDT", &[0.0]),
            ("PNEWDT", &[1.0]),
            ("STRAN", &point.strain),
            ("DSTRAN", strain_increment.as_slice()),
            ("TIME", &[start, start]),
            ("DTIME", &[step.duration]),
            ("TEMP", &[0.0]),
            ("DTEMP", &[0.0]),
            ("PREDEF", &[0.0]),
            ("DPRED", &[0.0]),
            ("PROPS", &self.properties),
            ("COORDS", &[0.0; 3]),
            ("DROT", increment.rotation.as_slice()),
            ("CELENT", &[1.0]),
            ("DFGRD0", increment.start.as_slice()),
            ("DFGRD1", increment.end.as_slice()),
        ]);
        let first = block.start();
        let at = |name: &str| first.wrapping_add(block.offset(name));
        // Step 1, a static procedure, with large deformations, not a perturbation.
        let procedure = [1, 1, 1, 0];
        let (one, three, six) = (1, 3, 6);
        // SAFETY: every pointer refers to a live value or array of at least the size that the Abaqus manual specifies. Pointers to numbers refer to a
        // block that is used only here, with margins. A UMAT that writes beyond the margins can corrupt only this process, which holds only
        // this material.
        unsafe {
            (self.umat)(
                at("STRESS"),
                at("STATEV"),
                at("DDSDDE"),
                at("SSE"),
                at("SPD"),
                at("SCD"),
                at("RPL"),
                at("DDSDDT"),
                at("DRPLDE"),
                at("DRPLDT"),
                at("STRAN"),
                at("DSTRAN"),
                at("TIME"),
                at("DTIME"),
                at("TEMP"),
                at("DTEMP"),
                at("PREDEF"),
                at("DPRED"),
                NAME.as_ptr(),
                &three,
                &three,
                &six,
                &self.variable_count,
                at("PROPS"),
                &self.property_count,
                at("COORDS"),
                at("DROT"),
                at("PNEWDT"),
                at("CELENT"),
                at("DFGRD0"),
                at("DFGRD1"),
                &one,
                &one,
                &one,
                &one,
                procedure.as_ptr(),
                &step.number,
                NAME.len(),
            );
        }
        point.stress.copy_from_slice(block.values("STRESS"));
        point.variables.copy_from_slice(block.values("STATEV"));
        point.ddsdde.copy_from_slice(block.values("DDSDDE"));
        point.factor = block.values("PNEWDT")[0];
        for (energy, name) in point.energies.iter_mut().zip(["SSE", "SPD", "SCD"]) {
            *energy = block.values(name)[0];
        }
        for (sum, part) in point.strain.iter_mut().zip(strain_increment.iter()) {
            *sum += part;
        }
        block.overrun().map_or(Ok(()), Err)
    }
}

impl Point {
    fn reply(&self, passed: Passed, increment: u32) -> Reply {
        let mut numbers = Vec::with_capacity(crate::frame::FIXED + self.variables.len());
        numbers.extend(self.stress);
        numbers.extend(self.ddsdde);
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

    fn overrun(&self, argument: usize, increment: u32) -> Reply {
        Reply {
            argument: u32::try_from(argument).unwrap_or(u32::MAX),
            ..self.reply(Passed::Overrun, increment)
        }
    }
}
