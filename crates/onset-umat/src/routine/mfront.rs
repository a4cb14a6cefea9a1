//! Behaviors of MFront with its generic interface, for three dimensions and finite strain.
//!
//! The headers `MFront/GenericBehaviour/BehaviourData.h` and `State.h` of TFEL define the structures, and MFrontGenericInterfaceSupport reads the symbols
//! (T. Helfer and others, *J. Open Source Softw.* 5 (2020) 2003). Unsymmetric tensors are stored as 11, 22, 33, 12, 21, 13, 31, 23, 32.

use super::{Data, LoadError, Overrun, Point, Step};
use crate::arguments::Arguments;
use crate::increment::Increment;
use crate::voigt::symmetric;
use libloading::os::unix::Library;
use nalgebra::Matrix3;
use onset::material::FourthOrder;
use std::ffi::{CStr, c_char, c_int};
use std::path::Path;

/// End of the symbol with the name of a behavior.
const ENTRY_POINT: &[u8] = b"_mfront_ept";
/// Hypothesis of the function that is called.
const HYPOTHESIS: &str = "Tridimensional";
/// Temperature that every behavior receives; kelvin.
const TEMPERATURE: f64 = 293.15;
/// Reserved size of the error message, which MFront limits to 512 characters.
const MESSAGE_SIZE: usize = 1024;

/// Index pairs of unsymmetric tensors.
const TENSOR: [(usize, usize); 9] = [
    (0, 0),
    (1, 1),
    (2, 2),
    (0, 1),
    (1, 0),
    (0, 2),
    (2, 0),
    (1, 2),
    (2, 1),
];

/// State at the start or the end of an increment, `mfront_gb_InitialState` or `mfront_gb_State`.
#[repr(C)]
struct StateView {
    gradients: *const f64,
    thermodynamic_forces: *mut f64,
    mass_density: *const f64,
    material_properties: *const f64,
    internal_state_variables: *mut f64,
    stored_energy: *mut f64,
    dissipated_energy: *mut f64,
    external_state_variables: *const f64,
}

/// Arguments of an integration, `mfront_gb_BehaviourData`.
#[repr(C)]
struct BehaviorData {
    error_message: *mut c_char,
    dt: f64,
    stiffness: *mut f64,
    rdt: *mut f64,
    speed_of_sound: *mut f64,
    start: StateView,
    end: StateView,
}

type BehaviorFunction = unsafe extern "C" fn(data: *mut BehaviorData) -> c_int;

pub(super) struct Behavior {
    function: BehaviorFunction,
    /// Number of scalars in its internal state variables.
    pub(super) variables: usize,
    external: Vec<f64>,
}

/// Metadata of a behavior in a library.
struct Symbols<'l> {
    library: &'l Library,
    behavior: &'l str,
}

impl Symbols<'_> {
    /// Address of a symbol of the hypothesis, or else of all hypotheses; `None` without either.
    #[allow(unsafe_code)]
    fn address(&self, name: &str) -> Option<*const ()> {
        let own = format!("{}_{HYPOTHESIS}_{name}", self.behavior);
        let common = format!("{}_{name}", self.behavior);
        [own, common].iter().find_map(|symbol| {
            // SAFETY: only the address of the symbol is taken here.
            let found = unsafe { self.library.get::<*const ()>(symbol.as_bytes()) }.ok()?;
            Some(found.into_raw().cast_const().cast())
        })
    }

    #[allow(unsafe_code)]
    fn number(&self, name: &str) -> Option<u16> {
        // SAFETY: the generic interface exports these numbers as `unsigned short`.
        self.address(name).map(|at| unsafe { *at.cast::<u16>() })
    }

    #[allow(unsafe_code)]
    fn text(&self, name: &str) -> Option<String> {
        // SAFETY: the generic interface exports these texts as `const char*`.
        self.address(name)
            .map(|at| unsafe { told(*at.cast::<*const c_char>()) })
    }

    /// Array of a kind of variables, with one element for each variable.
    ///
    /// # Safety
    /// The library must export the array with elements of the type `T`.
    #[allow(unsafe_code)]
    unsafe fn array<T: Copy>(&self, kind: &str, name: &str) -> Vec<T> {
        let count = usize::from(self.number(&format!("n{kind}")).unwrap_or(0));
        let first = self.address(name).filter(|_| count > 0);
        // SAFETY: the generic interface also exports the number of elements, and the caller guarantees their type.
        first.map_or_else(Vec::new, |at| unsafe {
            std::slice::from_raw_parts(at.cast::<T>(), count).to_vec()
        })
    }

    /// Names of variables of a kind.
    #[allow(unsafe_code)]
    fn names(&self, kind: &str) -> Vec<String> {
        // SAFETY: the generic interface exports the names as texts that end with zero.
        unsafe {
            let all = self.array::<*const c_char>(kind, kind).into_iter();
            all.map(|text| told(text)).collect()
        }
    }

    /// Codes of the types of the internal state variables.
    #[allow(unsafe_code)]
    fn types(&self) -> Vec<c_int> {
        // SAFETY: the generic interface exports these codes as `int`.
        unsafe { self.array("InternalStateVariables", "InternalStateVariablesTypes") }
    }
}

/// Text at an address.
#[allow(unsafe_code)]
unsafe fn told(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: the caller passes a text that ends with zero.
    unsafe { CStr::from_ptr(text) }
        .to_string_lossy()
        .into_owned()
}

/// Number of scalars of a variable in three dimensions, from the code of its type, which is read from its lowest bits.
fn size(code: &mut u32) -> Option<usize> {
    let mut take = |bits: u32| {
        let part = *code & ((1 << bits) - 1);
        *code >>= bits;
        part
    };
    Some(match take(3) {
        0 => 1,
        1 => [6, 3, 4, 6][take(2) as usize],
        2 => [3, 1, 2, 3][take(2) as usize],
        3 => [9, 3, 5, 9][take(2) as usize],
        4 => size(code)? * size(code)?,
        5 => {
            let dimensions = take(3);
            let count: usize = (0..dimensions).map(|_| take(7) as usize).product();
            (dimensions > 0 && count > 0).then_some(count)? * size(code)?
        }
        _ => return None,
    })
}

/// Names of the behaviors in the file of a library.
fn behaviors(path: &Path) -> Vec<String> {
    let bytes = std::fs::read(path).unwrap_or_default();
    let mut names: Vec<String> = bytes
        .split(|byte| *byte == 0)
        .filter_map(|word| word.strip_suffix(ENTRY_POINT))
        .filter_map(|name| String::from_utf8(name.to_vec()).ok())
        .filter(|name| !name.is_empty())
        .collect();
    names.sort();
    names.dedup();
    names
}

impl Behavior {
    /// Finds a behavior in a library: the one with a name, or the only one.
    #[allow(unsafe_code)]
    pub(super) fn find(
        library: &Library,
        path: &Path,
        name: Option<&str>,
        properties: usize,
    ) -> Result<Self, LoadError> {
        let known = behaviors(path);
        let refused = |message: String| Err(LoadError::Unsuitable(message));
        let listed = known.join(", ");
        let behavior = match (name, known.as_slice()) {
            (_, []) => return Err(LoadError::NoRoutine),
            (Some(name), _) if known.iter().any(|own| own == name) => name,
            (Some(name), _) => {
                return refused(format!(
                    "it has no behavior `{name}`\n  hint: set material.behavior to one of: {listed}"
                ));
            }
            (None, [one]) => one,
            (None, _) => {
                return refused(format!(
                    "it has several behaviors\n  hint: set material.behavior to one of: {listed}"
                ));
            }
        };
        let symbols = Symbols { library, behavior };
        match symbols.text("mfront_interface") {
            Some(own) if own == "Generic" => {}
            own => {
                return refused(format!(
                    "{behavior} has the interface {}, not the generic one\n  hint: compile it with: mfront --obuild --interface=generic FILE.mfront",
                    own.as_deref().unwrap_or("of an unknown program")
                ));
            }
        }
        if [
            symbols.number("BehaviourType"),
            symbols.number("BehaviourKinematic"),
        ] != [Some(2), Some(3)]
        {
            return refused(format!(
                "{behavior} is not a law of finite strain\n  hint: `@StrainMeasure Hencky` or `@StrainMeasure GreenLagrange` turns a law of small strains into one"
            ));
        }
        let names = symbols.names("MaterialProperties");
        if names.len() != properties {
            return refused(format!(
                "{behavior} has {} material properties, and {properties} are given\n  hint: material.properties lists, in this order: {}",
                names.len(),
                if names.is_empty() {
                    "nothing".to_owned()
                } else {
                    names.join(", ")
                }
            ));
        }
        let sizes: Option<usize> = symbols
            .types()
            .iter()
            .map(|code| size(&mut code.cast_unsigned()))
            .sum();
        let Some(variables) = sizes else {
            return refused(format!(
                "the types of the internal state variables of {behavior} are unknown"
            ));
        };
        let mut external = symbols.names("ExternalStateVariables");
        if symbols.number("TemperatureRemovedFromExternalStateVariables") != Some(0) {
            external.insert(0, "Temperature".to_owned());
        }
        if let Some(other) = external.iter().find(|name| *name != "Temperature") {
            return refused(format!(
                "{behavior} needs the external state variable `{other}`; only the temperature is passed, {TEMPERATURE} K"
            ));
        }
        let symbol = format!("{behavior}_{HYPOTHESIS}");
        // SAFETY: the metadata name this symbol as a function of the generic interface.
        let function = unsafe { library.get::<BehaviorFunction>(symbol.as_bytes()) };
        match function {
            Ok(function) => Ok(Self {
                function: *function,
                variables,
                external: vec![TEMPERATURE; external.len()],
            }),
            Err(_) => refused(format!(
                "{behavior} does not support the hypothesis {HYPOTHESIS}\n  hint: add `@ModellingHypothesis {HYPOTHESIS};`"
            )),
        }
    }

    /// Integrates one increment. If the behavior fails with a message, this process ends.
    #[allow(unsafe_code)]
    pub(super) fn advance(
        &self,
        data: &Data,
        point: &mut Point,
        increment: &Increment,
        step: &Step,
    ) -> Result<(), Overrun> {
        let numbers = |tensor: &Matrix3<f64>| TENSOR.map(|at| tensor[at]);
        let jacobian = increment.start.determinant();
        let Some(inverse) = increment.start.try_inverse() else {
            point.stress = [f64::NAN; 6];
            return Ok(());
        };
        let piola = symmetric(&point.stress) * inverse.transpose() * jacobian;
        // The consistent tangent (4), with the first Piola-Kirchhoff stress (2) and its derivative (2).
        let mut stiffness = [f64::NAN; 81];
        stiffness[..3].copy_from_slice(&[4.0, 2.0, 2.0]);
        let [stored, dissipated, _] = point.energies.map(|energy| energy * jacobian);
        let mut block = Arguments::of(&[
            ("s0.gradients", &numbers(&increment.start)),
            ("s1.gradients", &numbers(&increment.end)),
            ("s0.thermodynamic_forces", &numbers(&piola)),
            ("s1.thermodynamic_forces", &numbers(&piola)),
            ("mass_density", &[1.0]),
            ("material_properties", &data.properties),
            ("s0.internal_state_variables", &point.variables),
            ("s1.internal_state_variables", &point.variables),
            ("external_state_variables", &self.external),
            ("s0.energies", &[stored, dissipated]),
            ("s1.energies", &[stored, dissipated]),
            ("K", &stiffness),
            ("rdt", &[1.0]),
            ("speed_of_sound", &[0.0]),
        ]);
        let first = block.start();
        let at = |name: &str| first.wrapping_add(block.offset(name));
        let state = |end: &str| StateView {
            gradients: at(&format!("{end}.gradients")),
            thermodynamic_forces: at(&format!("{end}.thermodynamic_forces")),
            mass_density: at("mass_density"),
            material_properties: at("material_properties"),
            internal_state_variables: at(&format!("{end}.internal_state_variables")),
            stored_energy: at(&format!("{end}.energies")),
            dissipated_energy: at(&format!("{end}.energies")).wrapping_add(1),
            external_state_variables: at("external_state_variables"),
        };
        let mut message = [0; MESSAGE_SIZE];
        let mut arguments = BehaviorData {
            error_message: message.as_mut_ptr(),
            dt: step.duration,
            stiffness: at("K"),
            rdt: at("rdt"),
            speed_of_sound: at("speed_of_sound"),
            start: state("s0"),
            end: state("s1"),
        };
        // SAFETY: every pointer refers to an array of the size that the metadata of the behavior state, in a block that is used only here, with
        // margins. A behavior that writes beyond the margins can corrupt only this process, which holds only this material.
        let code = unsafe { (self.function)(&mut arguments) };
        message[MESSAGE_SIZE - 1] = 0;
        // SAFETY: the message ends with zero at the latest at its last character.
        let message = unsafe { told(message.as_ptr()) };
        if code < 0 && !message.trim().is_empty() {
            eprintln!("{message}");
            std::process::exit(1);
        }
        point.factor = match code {
            0.. => 1.0,
            _ => block.values("rdt")[0].min(0.5),
        };
        let values = block.values("s1.internal_state_variables");
        point.variables.copy_from_slice(values);
        let mut piola = Matrix3::zeros();
        for (at, value) in TENSOR.iter().zip(block.values("s1.thermodynamic_forces")) {
            piola[*at] = *value;
        }
        let place = |i: usize, j: usize| TENSOR.iter().position(|at| *at == (i, j)).unwrap_or(0);
        let values = block.values("K");
        let tangent = FourthOrder::from_fn(|i, j, k, l| values[9 * place(i, j) + place(k, l)]);
        point.take(increment, &piola, Some(tangent));
        let volume = increment.end.determinant();
        let energies = block.values("s1.energies");
        point.energies = [energies[0] / volume, energies[1] / volume, 0.0];
        Overrun::check(&block)
    }
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn the_size_of_a_variable_follows_from_the_code_of_its_type() {
        // Scalar, symmetric tensor, vector, tensor, vector of two, derivative with two symmetric tensors, array of four symmetric tensors.
        let array = 5 | 1 << 3 | 4 << 6 | 1 << 13;
        for (code, expected) in [
            (0, 1),
            (1, 6),
            (2, 3),
            (3, 9),
            (2 | 2 << 3, 2),
            (4 | 1 << 3 | 1 << 8, 36),
            (array, 24),
        ] {
            assert_eq!(size(&mut { code }), Some(expected), "{code}");
        }
        assert_eq!(size(&mut 7), None);
    }
}
