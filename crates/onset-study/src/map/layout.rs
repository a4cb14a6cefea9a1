//! Layout of the store of a map.

use super::fields::fields;
use crate::settings::{Axis, MapSettings, Study, Units};
use crate::store::{Dimension, LIBRARY, Layout, Tiling};
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

/// Edge of a tile in states: smaller with three axes than with two, so that a tile needs the same memory.
pub(crate) fn edge(tile: usize, axes: usize) -> usize {
    let edge = (tile as f64).powf(2.0 / axes as f64).round() as usize;
    edge.max(1)
}

/// Layout of the store of a study, as computed by this program.
pub(super) fn layout(study: &Study) -> Layout {
    of_attributes(study, attributes(study))
}

/// Layout of a store whose attributes record the program that computed it.
pub(crate) fn stored_layout(study: &Study, stored: &Map<String, Value>) -> Layout {
    of_attributes(study, stored.clone())
}

/// Division of the states of a study into tiles.
pub(crate) fn tiling(study: &Study) -> Tiling {
    let edge = edge(study.map.tile, study.axes.len());
    let shape: Vec<usize> = study.axes.iter().rev().map(|axis| axis.count).collect();
    Tiling {
        tile: shape.iter().map(|states| edge.min(*states)).collect(),
        shape,
    }
}

fn of_attributes(study: &Study, attributes: Map<String, Value>) -> Layout {
    let units = study.settings.units();
    let axes = study.axes.iter().rev();
    let dimensions: Vec<Dimension> = axes.map(|axis| dimension(axis, units)).collect();
    Layout {
        identity: identity(study, &attributes),
        attributes,
        tile: tiling(study).tile,
        dimensions,
        components: study.settings.dimension(),
        fields: fields(&study.map)
            .into_iter()
            .map(|field| field.in_units(|unit| units.unit(unit)))
            .collect(),
    }
}

fn dimension(axis: &Axis, units: Units) -> Dimension {
    Dimension {
        name: axis.name().to_owned(),
        long_name: axis.title().to_owned(),
        unit: units.unit(axis.unit()).to_owned(),
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
        ("study", json!(study.document())),
        ("settings", json!(study.effective())),
        ("tolerance", json!(study.map.tolerance)),
        ("onset_version", json!(env!("CARGO_PKG_VERSION"))),
        ("onset_build", json!(env!("ONSET_BUILD"))),
        ("onset_lanes", json!(onset::lanes())),
    ];
    let library = study.settings.material.fingerprint();
    pairs
        .into_iter()
        .chain(library.map(|sum| (LIBRARY, json!(sum))))
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}

/// Checksum of everything that determines the numbers of a map: the study without its title and stored outputs, and the program.
fn identity(study: &Study, attributes: &Map<String, Value>) -> String {
    let mut same = study.clone();
    same.title.clear();
    same.map.outputs = MapSettings::default().outputs;
    let mut hash = Sha256::new();
    hash.update(same.document());
    for name in [
        "tolerance",
        "onset_version",
        "onset_build",
        "onset_lanes",
        LIBRARY,
    ] {
        let value = attributes.get(name).unwrap_or(&Value::Null);
        hash.update(format!("\n{name} = {value}"));
    }
    format!("{:x}", hash.finalize())[..32].to_owned()
}

#[cfg(test)]
mod tests {
    use super::edge;

    #[test]
    fn tiles_hold_similar_numbers_of_states_with_two_and_three_axes() {
        assert_eq!((edge(64, 2), edge(64, 3)), (64, 16));
        assert_eq!((edge(1, 2), edge(1, 3)), (1, 1));
    }
}
