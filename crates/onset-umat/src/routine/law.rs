//! The function `onset_law` of `include/onset_law.h`.

use super::{Data, Overrun, Point, Step, found};
use crate::arguments::Arguments;
use crate::increment::Increment;
use crate::interface::Interface;
use libloading::os::unix::Library;
use nalgebra::Matrix3;
use onset::material::FourthOrder;

type LawFunction = unsafe extern "C" fn(
    start: *const f64,
    end: *const f64,
    time: f64,
    duration: f64,
    properties: *const f64,
    property_count: i32,
    state: *mut f64,
    state_count: i32,
    energy: *mut f64,
    stress: *mut f64,
    tangent: *mut f64,
) -> i32;

pub(super) struct Law(LawFunction);

impl Law {
    #[allow(unsafe_code)]
    pub(super) fn find(library: &Library) -> Option<Self> {
        // SAFETY: the user declares that this symbol is the function of the header.
        unsafe { found(library, Interface::Law.symbols()) }.map(Self)
    }

    /// Calls the function once. If it returns an error, this process ends with that exit code.
    #[allow(unsafe_code)]
    pub(super) fn advance(
        &self,
        data: &Data,
        point: &mut Point,
        increment: &Increment,
        step: &Step,
    ) -> Result<(), Overrun> {
        let (start, end) = (increment.start.transpose(), increment.end.transpose());
        let mut block = Arguments::of(&[
            ("F_start", start.as_slice()),
            ("F", end.as_slice()),
            ("properties", &data.properties),
            ("state", &point.variables),
            ("W", &[0.0]),
            ("P", &[f64::NAN; 9]),
            ("A", &[f64::NAN; 81]),
        ]);
        let first = block.start();
        let at = |name: &str| first.wrapping_add(block.offset(name));
        let time = f64::from(step.number) * step.duration;
        // SAFETY: every pointer refers to an array of the size that the header states, in a block that is used only here, with margins. A function
        // that writes beyond the margins can corrupt only this process, which holds only this material.
        let code = unsafe {
            (self.0)(
                at("F_start"),
                at("F"),
                time,
                step.duration,
                at("properties"),
                data.property_count,
                at("state"),
                data.variable_count,
                at("W"),
                at("P"),
                at("A"),
            )
        };
        if code != 0 {
            // Exit codes have eight bits, and 0 is success.
            eprintln!("onset_law returned {code}");
            std::process::exit(code.clamp(1, 255));
        }
        point.variables.copy_from_slice(block.values("state"));
        let piola = Matrix3::from_row_slice(block.values("P"));
        let numbers = block.values("A");
        let is_set = !numbers.iter().all(|number| number.is_nan());
        let tangent =
            is_set.then(|| FourthOrder::from_fn(|i, j, k, l| numbers[27 * i + 9 * j + 3 * k + l]));
        point.take(increment, &piola, tangent);
        point.energies[0] = block.values("W")[0] / increment.end.determinant();
        Overrun::check(&block)
    }
}
