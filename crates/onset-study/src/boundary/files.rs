//! Boundaries as files: GeoJSON curves in the coordinates of the axes, and a table of vertices.

use super::{Boundaries, CurveSummary, Owner};
use crate::csv::Table;
use crate::json;
use crate::output::{Files, text};
use onset::verdict::boundary::{Curve, End};
use serde_json::{Value, json};

/// Name of an end of a curve.
pub(super) fn word(end: End) -> &'static str {
    match end {
        End::Edge => "edge",
        End::Phase(_) => "phase",
        End::Meets => "meets",
        End::Lost => "lost",
        End::Budget => "budget",
    }
}

/// Boundaries as a FeatureCollection in the coordinates of the two axes.
///
/// Open curves are LineStrings, closed curves are Polygons with one ring. A ring has its more stable side on the left.
pub fn geojson(boundaries: &Boundaries) -> Value {
    let study = &boundaries.study;
    let feature = |(of, curve): (Owner, &Curve)| {
        let points: Vec<[f64; 2]> = curve.points().collect();
        let geometry = if curve.is_closed() {
            json!({"type": "Polygon", "coordinates": [points]})
        } else {
            json!({"type": "LineString", "coordinates": points})
        };
        json!({"type": "Feature", "properties": CurveSummary::new(of, curve), "geometry": geometry})
    };
    let features: Vec<Value> = boundaries.curves().map(feature).collect();
    let axes: Vec<Value> = study
        .plane()
        .iter()
        .map(|axis| {
            let (low, high) = axis.range;
            let unit = study.settings.units().unit(axis.unit());
            json!({"name": axis.name(), "unit": unit, "range": [low, high]})
        })
        .collect();
    let summary = boundaries.summary();
    json!({
        "type": "FeatureCollection",
        "title": study.title,
        "axes": axes,
        "is_complete": summary.is_complete,
        "unresolved": summary.unresolved,
        "fidelity": summary.fidelity,
        "study": study.document(),
        "settings": study.effective(),
        "onset_version": env!("CARGO_PKG_VERSION"),
        "features": features,
    })
}

/// Vertices as a table, curve by curve; the last row of a closed curve repeats the first.
pub fn csv(boundaries: &Boundaries) -> String {
    let [first, second] = boundaries.study.plane();
    let column = |name: &str| name.replace(['-', '.'], "_");
    let vertices: Vec<_> = boundaries
        .curves()
        .enumerate()
        .flat_map(|(number, (of, curve))| {
            let vertices = curve.vertices.iter();
            vertices.map(move |vertex| (number, of, curve, vertex))
        })
        .collect();
    Table::new(&vertices, boundaries.study.settings.units())
        .with("curve", "1", |own| own.0)
        .with("of", "1", |own| own.1.name())
        .with("left", "1", |own| own.2.left.name())
        .with("right", "1", |own| own.2.right.name())
        .with(column(first.name()), first.unit(), |own| own.3.point[0])
        .with(column(second.name()), second.unit(), |own| own.3.point[1])
        .with("accuracy", "1", |own| own.3.accuracy)
        .with("corner", "1", |own| own.3.is_corner)
        .to_string()
}

/// Boundaries as `boundary.geojson` and `boundary.csv`.
///
/// # Errors
/// [`serde_json::Error`] if a value cannot be written as JSON.
pub fn files(boundaries: &Boundaries) -> Result<Files, serde_json::Error> {
    Ok(vec![
        text("boundary.geojson", json::document(&geojson(boundaries))?),
        text("boundary.csv", csv(boundaries)),
    ])
}
