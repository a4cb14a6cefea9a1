//! Fields of particles and elements in VTK's XML formats, for ParaView and similar programs.
//!
//! The XML output is too short to justify a dependency such as `vtkio`.

use std::fmt::Write;

/// Points with fields, and elements between them.
#[derive(Default)]
pub(crate) struct Grid<'g> {
    /// Positions of the points; length.
    pub points: &'g [[f64; 3]],
    /// Vectors of the points.
    pub vectors: Vec<(&'g str, Vec<[f64; 3]>)>,
    /// Matrices of the points, row by row.
    pub matrices: Vec<(&'g str, Vec<[f64; 9]>)>,
    /// Scalars of the points.
    pub scalars: Vec<(&'g str, &'g [f64])>,
    /// Number of dimensions, and points of each element. Without elements each point is a cell.
    pub elements: Option<(usize, &'g [Vec<usize>])>,
    /// Scalars of the elements.
    pub of_elements: Vec<(&'g str, &'g [f64])>,
}

/// Type of a cell in the numbering of VTK, by its dimensions and its number of points.
fn shape(dimension: usize, points: usize) -> usize {
    match (dimension, points) {
        (1, 2) => 3,
        (1, 3) => 21,
        (2, 3) => 5,
        (2, 4) => 9,
        (2, 6) => 22,
        (2, 8) => 23,
        (2, 9) => 28,
        (2, _) => 7,
        (3, 4) => 10,
        (3, 5) => 14,
        (3, 6) => 13,
        (3, 8) => 12,
        (3, 10) => 24,
        (3, 20) => 25,
        (3, 27) => 29,
        // Points without faces.
        _ => 2,
    }
}

impl Grid<'_> {
    /// Text of a VTU file.
    pub(crate) fn vtu(&self) -> String {
        let count = self.points.len();
        let cells = self.elements.map_or(count, |(_, cells)| cells.len());
        let mut text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"{count}\" NumberOfCells=\"{cells}\">\n<Points>\n"
        );
        vectors(&mut text, "position", self.points);
        text.push_str("</Points>\n<PointData");
        if let Some((name, _)) = self.vectors.first() {
            let _ = write!(text, " Vectors=\"{name}\"");
        }
        text.push_str(">\n");
        for (name, all) in &self.vectors {
            vectors(&mut text, name, all);
        }
        for (name, all) in &self.matrices {
            vectors(&mut text, name, all);
        }
        for (name, all) in &self.scalars {
            scalars(&mut text, name, all);
        }
        text.push_str("</PointData>\n");
        if !self.of_elements.is_empty() {
            text.push_str("<CellData>\n");
            for (name, all) in &self.of_elements {
                scalars(&mut text, name, all);
            }
            text.push_str("</CellData>\n");
        }
        text.push_str("<Cells>\n");
        let (mut connectivity, mut ends, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
        match self.elements {
            Some((dimension, elements)) => {
                for element in elements {
                    connectivity.extend(element);
                    ends.push(connectivity.len());
                    shapes.push(shape(dimension, element.len()));
                }
            }
            None => {
                connectivity.extend(0..count);
                ends.extend(1..=count);
                // Type 1 is a vertex.
                shapes.resize(count, 1);
            }
        }
        numbers(&mut text, "connectivity", "Int64", &connectivity);
        numbers(&mut text, "offsets", "Int64", &ends);
        numbers(&mut text, "types", "UInt8", &shapes);
        text.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
        text
    }
}

fn vectors<const N: usize>(text: &mut String, name: &str, all: &[[f64; N]]) {
    let _ = writeln!(
        text,
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{N}\" format=\"ascii\">"
    );
    for own in all {
        let own = own.map(|x| format!("{x:e}"));
        let _ = writeln!(text, "{}", own.join(" "));
    }
    text.push_str("</DataArray>\n");
}

fn scalars(text: &mut String, name: &str, all: &[f64]) {
    let _ = writeln!(
        text,
        "<DataArray type=\"Float64\" Name=\"{name}\" format=\"ascii\">"
    );
    for own in all {
        // VTK reads `nan`, not `NaN`, in texts.
        let _ = match own.is_nan() {
            true => writeln!(text, "nan"),
            false => writeln!(text, "{own:e}"),
        };
    }
    text.push_str("</DataArray>\n");
}

fn numbers(text: &mut String, name: &str, kind: &str, all: &[usize]) {
    let all: Vec<String> = all.iter().map(ToString::to_string).collect();
    let _ = writeln!(
        text,
        "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">\n{}\n</DataArray>",
        all.join(" ")
    );
}

/// Collection of the files of a series with their times.
pub(crate) fn pvd<'f>(files: impl IntoIterator<Item = (f64, &'f str)>) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n",
    );
    for (time, file) in files {
        let _ = writeln!(
            text,
            "<DataSet timestep=\"{time:e}\" part=\"0\" file=\"{file}\"/>"
        );
    }
    text + "</Collection>\n</VTKFile>\n"
}
