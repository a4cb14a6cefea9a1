//! Stability boundaries in a figure: traced curves, or the edges of cells.

use super::stored::{Slice, StoredMap};
use super::{Lines, PlotError, is_elliptic};
use crate::boundary::{Boundaries, Tracing, Watch};
use crate::domain::Class;
use crate::figure::{Line, palette};
use crate::settings::Study;
use onset::cancel::unless;
use onset::verdict::boundary::Boundary;
use std::time::{Duration, Instant};

/// Time limit for tracing the boundaries of a figure if the edges of cells are an alternative.
const PATIENCE: Duration = Duration::from_secs(10);
const MATERIAL: &str = "boundary of the material";
const PARTICLES: &str = "boundary of the discretization";

/// All curves of a stability boundary as one line, with breaks between them.
pub(super) fn joined(boundary: &Boundary) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for curve in boundary.of_stability() {
        if !points.is_empty() {
            points.push((f64::NAN, f64::NAN));
        }
        points.extend(curve.points().map(|[x, y]| (x, y)));
    }
    points
}

/// Name in the legend. It mentions gaps if a curve of the boundary was not traced to its ends.
pub(super) fn honest(name: &str, boundary: &Boundary) -> String {
    match boundary.is_complete() {
        true => name.to_owned(),
        false => format!("{name} (with gaps; --no-trace avoids them)"),
    }
}

/// Line of the material boundary. It is wide enough to be visible under a coinciding line of the discretization.
fn of_material(points: Vec<(f64, f64)>, name: String) -> Option<Line> {
    (!points.is_empty()).then(|| Line::new(points).width(6.0).named(name))
}

/// Traced boundary of the material.
pub(super) fn material(boundary: &Boundary) -> Option<Line> {
    of_material(joined(boundary), honest(MATERIAL, boundary))
}

fn of_particles(points: Vec<(f64, f64)>, name: String) -> Option<Line> {
    (!points.is_empty()).then(|| {
        Line::new(points)
            .color(palette::VERMILION)
            .width(2.0)
            .named(name)
    })
}

/// Traces the boundaries of all studies, or returns `None` if cells should be used. Within one figure all boundaries are traced or none, so that they
/// can be compared.
pub(super) fn boundaries<'a>(
    studies: impl Iterator<Item = &'a Study> + Clone,
    lines: Lines,
    watch: &dyn Watch,
) -> Result<Option<Vec<Boundaries>>, PlotError> {
    let is_endless = match lines {
        Lines::OfCells => return Ok(None),
        Lines::Best if studies.clone().any(Study::varies_settings) => return Ok(None),
        Lines::Best => false,
        Lines::Traced => true,
    };
    let is_whole = |boundaries: &Boundaries| {
        boundaries.material.is_complete() && boundaries.discretization.is_complete()
    };
    let of_each = || -> Result<Option<Vec<Boundaries>>, PlotError> {
        let mut all = Vec::new();
        for study in studies {
            let traced = Boundaries::of(study, Tracing::default(), watch)?;
            if !(is_endless || is_whole(&traced)) {
                return Ok(None);
            }
            all.push(traced);
        }
        Ok(Some(all))
    };
    let end = Instant::now() + PATIENCE;
    unless(move || !is_endless && Instant::now() >= end, of_each).unwrap_or(Ok(None))
}

/// Lines of both traced boundaries.
pub(super) fn traced(boundaries: &Boundaries) -> Vec<Line> {
    let lines = [
        material(&boundaries.material),
        of_particles(
            joined(&boundaries.discretization),
            honest(PARTICLES, &boundaries.discretization),
        ),
    ];
    lines.into_iter().flatten().collect()
}

/// Both boundaries as edges of cells.
pub(super) fn of_cells(map: &StoredMap, slice: &Slice) -> Result<Vec<Line>, PlotError> {
    let (cells, classes) = map.classes(slice)?;
    let stable = stable_for_particles(&classes);
    let [first, second] = slice.study.plane();
    let points = edges(&stable, cells, first.range, second.range);
    let lines = [
        material_of_cells(map, slice)?,
        of_particles(points, PARTICLES.to_owned()),
    ];
    Ok(lines.into_iter().flatten().collect())
}

/// Boundary of the material as edges of cells.
pub(super) fn material_of_cells(map: &StoredMap, slice: &Slice) -> Result<Option<Line>, PlotError> {
    let (cells, classes) = map.classes(slice)?;
    let acoustic = match map.holds("acoustic_minimum") {
        true => map.numbers(slice, "acoustic_minimum")?.1,
        false => vec![f64::NAN; classes.len()],
    };
    let elliptic: Vec<Option<bool>> = classes
        .iter()
        .zip(&acoustic)
        .map(|(class, minimum)| {
            // The verdict accounts for flutter, which the smallest real part does not show.
            let decided = match class {
                Some(Class::Verdict(verdict)) => is_elliptic(*verdict),
                Some(Class::Flutter | Class::Undefined) | None => None,
            };
            decided.or_else(|| minimum.is_finite().then_some(*minimum >= 0.0))
        })
        .collect();
    let [first, second] = slice.study.plane();
    let points = edges(&elliptic, cells, first.range, second.range);
    Ok(of_material(points, MATERIAL.to_owned()))
}

/// Stability of the discretization in each cell; `None` where it is undefined or not yet computed.
pub(super) fn stable_for_particles(classes: &[Option<Class>]) -> Vec<Option<bool>> {
    let stable = |class: &Option<Class>| {
        let defined = class.filter(|class| *class != Class::Undefined)?;
        Some(defined.is_stable_for_particles())
    };
    classes.iter().map(stable).collect()
}

/// Edges between cells of different flags, with breaks between separate curves.
pub(super) fn edges(
    flags: &[Option<bool>],
    (columns, rows): (usize, usize),
    x: (f64, f64),
    y: (f64, f64),
) -> Vec<(f64, f64)> {
    let at = |(low, high): (f64, f64), n: usize, count: usize| {
        low + (high - low) * n as f64 / count as f64
    };
    let differ = |a: usize, b: usize| matches!((flags[a], flags[b]), (Some(a), Some(b)) if a != b);
    let mut points = Vec::new();
    let mut add = |from: (f64, f64), to: (f64, f64)| {
        // A new curve begins unless this edge continues the last one.
        if points.last() != Some(&from) {
            if !points.is_empty() {
                points.push((f64::NAN, f64::NAN));
            }
            points.push(from);
        }
        points.push(to);
    };
    for row in 1..rows {
        for column in 0..columns {
            if differ((row - 1) * columns + column, row * columns + column) {
                let height = at(y, row, rows);
                add(
                    (at(x, column, columns), height),
                    (at(x, column + 1, columns), height),
                );
            }
        }
    }
    for column in 1..columns {
        for row in 0..rows {
            if differ(row * columns + column - 1, row * columns + column) {
                let place = at(x, column, columns);
                add((place, at(y, row, rows)), (place, at(y, row + 1, rows)));
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::{Lines, boundaries, edges, honest};
    use crate::settings::Study;
    use onset::verdict::boundary::Boundary;

    #[test]
    fn edges_separate_cells_with_different_known_flags() {
        let flags = [
            Some(true),
            Some(false),
            None,
            Some(false),
            Some(false),
            Some(true),
        ];
        let points = edges(&flags, (3, 2), (0.0, 3.0), (0.0, 2.0));
        let known: Vec<(f64, f64)> = points.into_iter().filter(|p| p.0.is_finite()).collect();
        let expected = [
            (0.0, 1.0),
            (1.0, 1.0),
            (1.0, 0.0),
            (1.0, 1.0),
            (2.0, 1.0),
            (2.0, 2.0),
        ];
        assert_eq!(known, expected);
    }

    #[test]
    fn a_figure_shows_traced_boundaries_only_if_all_are_traced() {
        let axis = |quantity: &str| {
            format!("[[axes]]\nquantity = '{quantity}'\nrange = [1.0, 2.0]\nstates = 4\n")
        };
        let study = |second: &str| {
            let text = format!("title = 'a'\n{}{}", axis("stretch-1"), axis(second));
            Study::parse("study.toml", &text).expect("a study")
        };
        let (plain, varying) = (study("stretch-2"), study("discretization.support"));
        let asked = |studies: &[&Study], lines: Lines| {
            let found = boundaries(studies.iter().copied(), lines, &());
            found.expect("no error").map(|found| found.len())
        };
        assert_eq!(asked(&[&plain, &plain], Lines::Traced), Some(2));
        assert_eq!(asked(&[&plain, &varying], Lines::Best), None);
    }

    #[test]
    fn the_legend_mentions_gaps_of_a_boundary() {
        let whole = Boundary::default();
        assert_eq!(honest("a", &whole), "a");
        let broken = Boundary {
            unresolved: vec![[0.5, 0.5]],
            ..Boundary::default()
        };
        assert!(honest("a", &broken).contains("with gaps"));
    }
}
