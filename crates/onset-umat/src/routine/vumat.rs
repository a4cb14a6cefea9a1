//! `SUBROUTINE VUMAT` of Abaqus/Explicit, compiled in double precision, called for one point at a time.

use super::{Data, NAME, Overrun, Point, Step, found};
use crate::arguments::Arguments;
use crate::increment::{Increment, polar, rotation_vector};
use crate::interface::Interface;
use crate::voigt::{stress_like, symmetric};
use libloading::os::unix::Library;
use nalgebra::Matrix3;

/// `SUBROUTINE VUMAT` as compiled Fortran: every argument by reference, the length of `cmname` by value at the end.
type VumatRoutine = unsafe extern "C" fn(
    nblock: *const i32,
    ndir: *const i32,
    nshr: *const i32,
    nstatev: *const i32,
    nfieldv: *const i32,
    nprops: *const i32,
    lanneal: *const i32,
    step_time: *const f64,
    total_time: *const f64,
    dt: *const f64,
    cmname: *const u8,
    coord_mp: *const f64,
    char_length: *const f64,
    props: *const f64,
    density: *const f64,
    strain_inc: *const f64,
    rel_spin_inc: *const f64,
    temp_old: *const f64,
    stretch_old: *const f64,
    defgrad_old: *const f64,
    field_old: *const f64,
    stress_old: *const f64,
    state_old: *const f64,
    ener_intern_old: *const f64,
    ener_inelas_old: *const f64,
    temp_new: *const f64,
    stretch_new: *const f64,
    defgrad_new: *const f64,
    field_new: *const f64,
    stress_new: *mut f64,
    state_new: *mut f64,
    ener_intern_new: *mut f64,
    ener_inelas_new: *mut f64,
    cmname_length: usize,
);

/// Index pairs of symmetric tensors in the order of Abaqus/Explicit: 11, 22, 33, 12, 23, 31.
const SYMMETRIC: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
/// Index pairs of other tensors: the symmetric ones, then 21, 32, 13.
const GENERAL: [(usize, usize); 9] = [
    (0, 0),
    (1, 1),
    (2, 2),
    (0, 1),
    (1, 2),
    (2, 0),
    (1, 0),
    (2, 1),
    (0, 2),
];

pub(super) struct Vumat(VumatRoutine);

impl Vumat {
    #[allow(unsafe_code)]
    pub(super) fn find(library: &Library) -> Option<Self> {
        // SAFETY: the user declares that this symbol is a VUMAT of Abaqus; its signature is fixed by the Abaqus manual.
        unsafe { found(library, Interface::Vumat.symbols()) }.map(Self)
    }

    /// Calls the VUMAT once.
    ///
    /// The axes of its tensors rotate with `R` of `F = R U`: the stress is `R^T sigma R`.
    #[allow(unsafe_code)]
    pub(super) fn advance(
        &self,
        data: &Data,
        point: &mut Point,
        increment: &Increment,
        step: &Step,
    ) -> Result<(), Overrun> {
        let (Some((turn_old, stretch_old)), Some((turn_new, stretch_new))) =
            (polar(&increment.start), polar(&increment.end))
        else {
            point.stress = [f64::NAN; 6];
            return Ok(());
        };
        let symmetric_of = |tensor: &Matrix3<f64>| SYMMETRIC.map(|at| tensor[at]);
        let general_of = |tensor: &Matrix3<f64>| GENERAL.map(|at| tensor[at]);
        let stress_old = turn_old.transpose() * symmetric(&point.stress) * turn_old;
        let strain = turn_new.transpose() * increment.strain * turn_new;
        let spin = rotation_vector(&(turn_new.transpose() * increment.rotation * turn_old));
        let volumes = [&increment.start, &increment.end].map(Matrix3::determinant);
        // A material of density 1 in the reference configuration, so that energies per mass are energies per reference volume.
        let density = 2.0 / (volumes[0] + volumes[1]);
        // The internal energy of Abaqus/Explicit includes the dissipated energy.
        let [stored, dissipation, _] = point.energies.map(|energy| energy * volumes[0]);
        let internal = stored + dissipation;
        let end = f64::from(step.number) * step.duration;
        let mut block = Arguments::of(&[
            ("stepTime", &[end]),
            ("totalTime", &[end]),
            ("dt", &[step.duration]),
            ("coordMp", &[0.0; 3]),
            ("charLength", &[1.0]),
            ("props", &data.properties),
            ("density", &[density]),
            ("strainInc", &symmetric_of(&strain)),
            ("relSpinInc", &spin),
            ("tempOld", &[0.0]),
            ("stretchOld", &symmetric_of(&stretch_old)),
            ("defgradOld", &general_of(&increment.start)),
            ("fieldOld", &[0.0]),
            ("stressOld", &symmetric_of(&stress_old)),
            ("stateOld", &point.variables),
            ("enerInternOld", &[internal]),
            ("enerInelasOld", &[dissipation]),
            ("tempNew", &[0.0]),
            ("stretchNew", &symmetric_of(&stretch_new)),
            ("defgradNew", &general_of(&increment.end)),
            ("fieldNew", &[0.0]),
            ("stressNew", &[f64::NAN; 6]),
            ("stateNew", &point.variables),
            ("enerInternNew", &[internal]),
            ("enerInelasNew", &[dissipation]),
        ]);
        let first = block.start();
        let at = |name: &str| first.wrapping_add(block.offset(name));
        let (zero, three) = (0, 3);
        // With `jblock(*)`: the number of points, then the numbers of integration point, layer, section point and element.
        let block_numbers = [1; 5];
        // SAFETY: every pointer refers to a live value or array of at least the size that the Abaqus manual specifies for one point. Pointers to
        // numbers refer to a block that is used only here, with margins. A VUMAT that writes beyond the margins can corrupt only this process,
        // which holds only this material.
        unsafe {
            (self.0)(
                block_numbers.as_ptr(),
                &three,
                &three,
                &data.variable_count,
                &zero,
                &data.property_count,
                &zero,
                at("stepTime"),
                at("totalTime"),
                at("dt"),
                NAME.as_ptr(),
                at("coordMp"),
                at("charLength"),
                at("props"),
                at("density"),
                at("strainInc"),
                at("relSpinInc"),
                at("tempOld"),
                at("stretchOld"),
                at("defgradOld"),
                at("fieldOld"),
                at("stressOld"),
                at("stateOld"),
                at("enerInternOld"),
                at("enerInelasOld"),
                at("tempNew"),
                at("stretchNew"),
                at("defgradNew"),
                at("fieldNew"),
                at("stressNew"),
                at("stateNew"),
                at("enerInternNew"),
                at("enerInelasNew"),
                NAME.len(),
            );
        }
        let mut stress = Matrix3::zeros();
        for ((i, j), component) in SYMMETRIC.into_iter().zip(block.values("stressNew")) {
            stress[(i, j)] = *component;
            stress[(j, i)] = *component;
        }
        point.stress = stress_like(&(turn_new * stress * turn_new.transpose())).into();
        point.variables.copy_from_slice(block.values("stateNew"));
        let [internal, dissipation] =
            ["enerInternNew", "enerInelasNew"].map(|name| block.values(name)[0] / volumes[1]);
        point.energies = [internal - dissipation, dissipation, 0.0];
        Overrun::check(&block)
    }
}
