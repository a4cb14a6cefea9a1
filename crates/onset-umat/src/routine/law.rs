//! The function `onset_law` of `include/onset_law.h`.

use super::{Data, Overrun, Point, SKEW_TOLERANCE, Step, found};
use crate::arguments::Arguments;
use crate::conversion::Delivered;
use crate::increment::Increment;
use crate::interface::Interface;
use crate::voigt::stress_like;
use libloading::os::unix::Library;
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset::material::{FourthOrder, Response};

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
        let kirchhoff = piola * increment.end.transpose();
        let jacobian = increment.end.determinant();
        let mean = 0.5 * (kirchhoff + kirchhoff.transpose());
        point.stress = stress_like(&(mean / jacobian)).into();
        point.skew = 0.5 * (kirchhoff - kirchhoff.transpose()) / jacobian;
        point.energies[0] = block.values("W")[0] / jacobian;
        let numbers = block.values("A");
        point.ddsdde = None;
        if !numbers.iter().all(|number| number.is_nan()) {
            let f = |i: usize, j: usize| increment.end[(i, j)];
            let components = std::array::from_fn(|i| std::array::from_fn(|j| f(i, j)));
            let Ok(deformation) = DeformationGradient::new(components) else {
                point.ddsdde = Some([f64::NAN; 36]);
                return Overrun::check(&block);
            };
            let response = Response {
                deformation,
                energy: 0.0,
                first_piola: piola,
                tangent: FourthOrder::from_fn(|i, j, k, l| numbers[27 * i + 9 * j + 3 * k + l]),
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
            point.skew_of_tangent = skew / SKEW_TOLERANCE;
            let ddsdde = Delivered::of_response(&response).ddsdde;
            let mut columns = [0.0; 36];
            columns.copy_from_slice(ddsdde.as_slice());
            point.ddsdde = Some(columns);
        }
        Overrun::check(&block)
    }
}
