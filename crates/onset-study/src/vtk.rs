//! Fields of particles and elements in VTK's XML formats, for ParaView and similar programs.
//!
//! Arrays are base64 of little-endian numbers after their length, as readers of VTK accept them for all values; in ASCII arrays they do not accept NaN.
//! The rest of the XML is too short to justify a dependency such as `vtkio`.

use base64::prelude::{BASE64_STANDARD, Engine as _};
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
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n\
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
    let components = format!(" NumberOfComponents=\"{N}\"");
    let numbers = all.iter().flatten().flat_map(|x| x.to_le_bytes());
    array(text, "Float64", name, &components, numbers.collect());
}

fn scalars(text: &mut String, name: &str, all: &[f64]) {
    let numbers = all.iter().flat_map(|x| x.to_le_bytes());
    array(text, "Float64", name, "", numbers.collect());
}

/// Writes whole numbers, as `Int64`, or as `UInt8` if that is their type.
fn numbers(text: &mut String, name: &str, kind: &str, all: &[usize]) {
    let numbers = match kind {
        "UInt8" => all.iter().map(|n| *n as u8).collect(),
        _ => all.iter().flat_map(|n| (*n as i64).to_le_bytes()).collect(),
    };
    array(text, kind, name, "", numbers);
}

/// Writes an array with its length in bytes; `more` are further attributes.
fn array(text: &mut String, kind: &str, name: &str, more: &str, numbers: Vec<u8>) {
    let _ = writeln!(
        text,
        "<DataArray type=\"{kind}\" Name=\"{name}\"{more} format=\"binary\">"
    );
    let mut bytes = (numbers.len() as u64).to_le_bytes().to_vec();
    bytes.extend(numbers);
    BASE64_STANDARD.encode_string(&bytes, text);
    text.push_str("\n</DataArray>\n");
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

#[cfg(test)]
mod tests {
    use super::Grid;
    use onset_frames::{Reading, Series};

    #[test]
    fn all_values_are_read_back_exactly() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("one.vtu");
        let points = [[0.1, -1e-300, 0.0], [1.0 / 3.0, 2e30, 0.0], [0.0; 3]];
        let f = [0, 1, 2].map(|n| std::array::from_fn(|i| f64::from(10 * n + i as i32) / 7.0));
        let density = [1.0, f64::NAN, 3.0];
        let cells = [vec![0, 1, 2]];
        let grid = Grid {
            points: &points,
            matrices: vec![("F", f.to_vec())],
            scalars: vec![("density", &density)],
            elements: Some((2, &cells)),
            ..Grid::default()
        };
        let text = grid.vtu();
        assert!(!text.contains("ascii") && !text.contains("nan"), "{text}");
        std::fs::write(&path, text).expect("a file");
        let mut series = Series::open(&[path], &Reading::default()).expect("a series");
        let frame = series.frame(0).expect("a frame");
        assert_eq!(frame.position, points);
        assert_eq!(frame.gradient, Some(f.to_vec()));
        let read = frame.density.expect("densities");
        assert!(read[1].is_nan() && read[0] == 1.0 && read[2] == 3.0);
        let cells = frame.cells.expect("cells");
        assert_eq!((cells.points(0), cells.shapes[0]), (&[0, 1, 2][..], 5));
    }
}
