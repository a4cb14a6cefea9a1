//! Fields of a patch in VTK's XML formats, for ParaView and similar programs.
//!
//! Forty lines of XML do not justify a dependency such as `vtkio`.

use onset::motion::PatchState;
use std::fmt::Write;

/// File name of a field.
pub(super) fn name(number: usize) -> String {
    format!("field-{number:04}.vtu")
}

/// Particles at their current positions, with vectors `displacement` and `velocity` and named scalars.
///
/// Displacements are relative to `places`.
pub(super) fn vtu(
    dimension: usize,
    places: &[[f64; 3]],
    state: &PatchState,
    scalars: &[(&str, Vec<f64>)],
) -> String {
    let count = places.len();
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{count}\" NumberOfCells=\"{count}\">\n<Points>\n"
    );
    let vectors = |text: &mut String, name: &str, all: &dyn Fn(usize) -> [f64; 3]| {
        let _ = writeln!(
            text,
            "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"ascii\">"
        );
        for n in 0..count {
            let [x, y, z] = all(n);
            let _ = writeln!(text, "{x:e} {y:e} {z:e}");
        }
        text.push_str("</DataArray>\n");
    };
    let of = |flat: &[f64], n: usize| -> [f64; 3] {
        std::array::from_fn(|i| {
            if i < dimension {
                flat[dimension * n + i]
            } else {
                0.0
            }
        })
    };
    let moved = |n: usize| -> [f64; 3] {
        let u = of(&state.displacements, n);
        std::array::from_fn(|i| places[n][i] + u[i])
    };
    vectors(&mut text, "position", &moved);
    text.push_str("</Points>\n<PointData Vectors=\"displacement\">\n");
    vectors(&mut text, "displacement", &|n| of(&state.displacements, n));
    vectors(&mut text, "velocity", &|n| of(&state.velocities, n));
    for (name, all) in scalars {
        let _ = writeln!(
            text,
            "<DataArray type=\"Float64\" Name=\"{name}\" format=\"ascii\">"
        );
        for own in all {
            let _ = writeln!(text, "{own:e}");
        }
        text.push_str("</DataArray>\n");
    }
    text.push_str("</PointData>\n<Cells>\n");
    let mut numbers = |name: &str, kind: &str, of: &dyn Fn(usize) -> usize| {
        let all: Vec<String> = (0..count).map(|n| of(n).to_string()).collect();
        let _ = writeln!(
            text,
            "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">\n{}\n</DataArray>",
            all.join(" ")
        );
    };
    numbers("connectivity", "Int64", &|n| n);
    numbers("offsets", "Int64", &|n| n + 1);
    // Type 1 is a vertex.
    numbers("types", "UInt8", &|_| 1);
    text.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    text
}

/// Collection of the fields with their times.
pub(super) fn pvd(times: &[f64]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n",
    );
    for (number, time) in times.iter().enumerate() {
        let _ = writeln!(
            text,
            "<DataSet timestep=\"{time:e}\" part=\"0\" file=\"{}\"/>",
            name(number)
        );
    }
    text + "</Collection>\n</VTKFile>\n"
}
