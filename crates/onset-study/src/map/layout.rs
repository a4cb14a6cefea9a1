//! What the store of a map holds.

use super::fields::fields;
use crate::settings::{Axis, Study};
use crate::store::{Dimension, Layout};
use serde_json::{Map, Value, json};

/// States of a tile along an axis: as many of them in space as in the plane, so that a tile takes the same memory.
fn edge(tile: usize, axes: usize) -> usize {
    let edge = (tile as f64).powf(2.0 / axes as f64).round() as usize;
    edge.max(1)
}

/// The layout of the store of a study.
pub(super) fn layout(study: &Study) -> Layout {
    let dimensions: Vec<Dimension> = study.axes.iter().rev().map(dimension).collect();
    let edge = edge(study.map.tile, study.axes.len());
    Layout {
        attributes: attributes(study),
        tile: dimensions
            .iter()
            .map(|dimension| edge.min(dimension.coordinates.len()))
            .collect(),
        dimensions,
        components: study.settings.dimension(),
        fields: fields(&study.map),
    }
}

fn dimension(axis: &Axis) -> Dimension {
    let label = axis.label();
    // The unit has an attribute of its own.
    let name = label
        .rsplit_once(" (")
        .map_or(label.as_str(), |(name, _)| name);
    Dimension {
        name: axis.name().to_owned(),
        long_name: name.to_owned(),
        unit: axis.unit().to_owned(),
        coordinates: (0..axis.count).map(|i| axis.coordinate(i)).collect(),
    }
}

fn attributes(study: &Study) -> Map<String, Value> {
    let pairs = [
        ("Conventions", json!("CF-1.11")),
        ("title", json!(study.title)),
        (
            "source",
            json!(concat!("onset ", env!("CARGO_PKG_VERSION"))),
        ),
        ("onset_version", json!(env!("CARGO_PKG_VERSION"))),
        ("study", json!(study.document())),
        ("settings", json!(study.effective())),
        ("tolerance", json!(study.map.tolerance)),
    ];
    pairs
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::edge;

    #[test]
    fn tiles_hold_about_as_many_states_in_space_as_in_the_plane() {
        assert_eq!((edge(64, 2), edge(64, 3)), (64, 16));
        assert_eq!((edge(1, 2), edge(1, 3)), (1, 1));
    }
}
