//! `SUBROUTINE UMAT` of Abaqus/Standard.

use super::{Data, NAME, Overrun, Point, Step, found};
use crate::arguments::Arguments;
use crate::increment::Increment;
use crate::interface::Interface;
use crate::voigt::{strain, strain_like, stress_like, symmetric};
use libloading::os::unix::Library;
use nalgebra::Matrix3;

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

/// UMAT and, if the library contains it, SDVINI.
pub(super) struct Umat {
    umat: UmatRoutine,
    sdvini: Option<SdviniRoutine>,
}

impl Umat {
    /// Finds the routines in a library.
    #[allow(unsafe_code)]
    pub(super) fn find(library: &Library) -> Option<Self> {
        // SAFETY: the user declares that these symbols are subroutines of Abaqus; their signatures are fixed by its manual.
        unsafe {
            Some(Self {
                umat: found(library, Interface::Umat.symbols())?,
                sdvini: found(library, &["sdvini_", "sdvini", "SDVINI"]),
            })
        }
    }

    /// Calls SDVINI to set the state variables of a point without history.
    #[allow(unsafe_code)]
    pub(super) fn set_up(&self, data: &Data, point: &mut Point) -> Result<(), Overrun> {
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
                &data.variable_count,
                &three,
                &one,
                &one,
                &one,
                &one,
            );
        }
        point.variables.copy_from_slice(block.values("STATEV"));
        Overrun::check(&block)
    }

    /// Calls the UMAT once.
    #[allow(unsafe_code)]
    pub(super) fn advance(
        &self,
        data: &Data,
        point: &mut Point,
        increment: &Increment,
        step: &Step,
    ) -> Result<(), Overrun> {
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
            ("PROPS", &data.properties),
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
                &data.variable_count,
                at("PROPS"),
                &data.property_count,
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
        let mut ddsdde = [0.0; 36];
        ddsdde.copy_from_slice(block.values("DDSDDE"));
        point.ddsdde = Some(ddsdde);
        point.factor = block.values("PNEWDT")[0];
        for (energy, name) in point.energies.iter_mut().zip(["SSE", "SPD", "SCD"]) {
            *energy = block.values(name)[0];
        }
        for (sum, part) in point.strain.iter_mut().zip(strain_increment.iter()) {
            *sum += part;
        }
        Overrun::check(&block)
    }
}
