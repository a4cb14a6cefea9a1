//! Layout of a store, and its Zarr metadata, which are a deterministic function of the layout.

use super::Tiling;
use serde_json::{Map, Value, json};

/// Dimension of a map: an axis of the study with its coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Dimension {
    /// Name of the dimension, and of its coordinate array.
    pub name: String,
    /// Descriptive name for plots and tables.
    pub long_name: String,
    /// Unit of the coordinates.
    pub unit: String,
    /// Coordinates, one for each state along the dimension.
    pub coordinates: Vec<f64>,
}

/// Type of the values of a field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Flags: small whole numbers with names, counted from zero; -1 if nothing has been computed.
    Flags(Vec<&'static str>),
    /// Numbers in double precision with a unit; NaN for missing values.
    Numbers(&'static str),
}

/// Field of a map: one value, or one vector, per state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name of the array.
    pub name: &'static str,
    /// Descriptive name for plots and tables.
    pub long_name: &'static str,
    /// Type of the values.
    pub kind: Kind,
    /// Whether the values are vectors.
    pub is_vector: bool,
}

impl Field {
    /// Returns the field with its dimension replaced by a unit.
    pub fn in_units(mut self, unit: impl Fn(&'static str) -> &'static str) -> Self {
        if let Kind::Numbers(own) = &mut self.kind {
            *own = unit(own);
        }
        self
    }
}

/// Complete description of a store.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Attributes of the store.
    pub attributes: Map<String, Value>,
    /// Identity of the map, recorded in each chunk so that a chunk of another map is detected.
    pub identity: String,
    /// Dimensions of the map, slowest first.
    pub dimensions: Vec<Dimension>,
    /// Number of states of a tile along each dimension.
    pub tile: Vec<usize>,
    /// Number of components of a vector.
    pub components: usize,
    /// Fields of the store. The first field is written last, and marks a tile as finished.
    pub fields: Vec<Field>,
}

/// Name of the dimension of vector components.
const COMPONENT: &str = "component";
/// Attribute that identifies a store of onset; its value is the version of the format.
pub(super) const FORMAT: &str = "onset_format";
pub(super) const FORMAT_VERSION: u32 = 3;
/// Attribute with the identity of the map.
pub(super) const IDENTITY: &str = "onset_identity";
/// Explanations of differing attributes.
pub(super) const MEANINGS: [(&str, &str); 4] = [
    (
        LIBRARY,
        "the library of its material has another SHA-256 sum; was it recompiled?",
    ),
    ("onset_version", "it was begun by another version of onset"),
    (
        "onset_build",
        "it was begun by another build of onset, whose numbers may differ",
    ),
    (
        "onset_lanes",
        "it was begun on a processor with another vector width, whose numbers differ in the last digits",
    ),
];
/// Attribute with the SHA-256 sum of the library that the study loads.
pub(crate) const LIBRARY: &str = "material_library_sha256";
/// Fastest compression of chunks; higher levels save a few percent on measured data, at several times the cost.
pub(super) const GZIP_LEVEL: u32 = 1;

impl Layout {
    /// Division of the states into tiles.
    pub fn tiling(&self) -> Tiling {
        Tiling {
            shape: self
                .dimensions
                .iter()
                .map(|dimension| dimension.coordinates.len())
                .collect(),
            tile: self.tile.clone(),
        }
    }

    /// Metadata of every array, by name: coordinates, then fields.
    pub(super) fn arrays(&self) -> Vec<(String, Value)> {
        let coordinates = self
            .dimensions
            .iter()
            .map(|dimension| (dimension.name.clone(), coordinates(dimension)));
        let component = (
            COMPONENT.to_owned(),
            array(
                &[self.components],
                &[self.components],
                &[COMPONENT],
                "int8",
                json!(0),
                json!({"long_name": "component of a vector in the reference configuration"}),
            ),
        );
        let fields = self
            .fields
            .iter()
            .map(|field| (field.name.to_owned(), self.field(field)));
        coordinates.chain([component]).chain(fields).collect()
    }

    /// Metadata of the store, including the metadata of every array, so that a single file describes everything.
    pub(super) fn group(&self) -> Value {
        let arrays: Map<String, Value> = self.arrays().into_iter().collect();
        let mut attributes = Map::from_iter([(FORMAT.to_owned(), json!(FORMAT_VERSION))]);
        attributes.extend(self.attributes.clone());
        attributes.insert(IDENTITY.to_owned(), json!(self.identity));
        json!({
            "zarr_format": 3,
            "node_type": "group",
            "attributes": attributes,
            "consolidated_metadata": {"kind": "inline", "must_understand": false, "metadata": arrays},
        })
    }

    /// Coordinate values, by the name of their array.
    pub(super) fn coordinates(&self) -> Vec<(String, super::Column)> {
        let numbers = |dimension: &Dimension| {
            (
                dimension.name.clone(),
                super::Column::Numbers(dimension.coordinates.clone()),
            )
        };
        let components = (1..=self.components as i8).collect();
        self.dimensions
            .iter()
            .map(numbers)
            .chain([(COMPONENT.to_owned(), super::Column::Flags(components))])
            .collect()
    }

    fn field(&self, field: &Field) -> Value {
        let tiling = self.tiling();
        let (mut shape, mut chunk) = (tiling.shape, tiling.tile);
        let mut names: Vec<&str> = self
            .dimensions
            .iter()
            .map(|dimension| dimension.name.as_str())
            .collect();
        if field.is_vector {
            shape.push(self.components);
            chunk.push(self.components);
            names.push(COMPONENT);
        }
        let (data_type, fill, attributes) = match &field.kind {
            Kind::Flags(meanings) => (
                "int8",
                json!(-1),
                json!({
                    "long_name": field.long_name,
                    "flag_values": (0..meanings.len()).collect::<Vec<_>>(),
                    "flag_meanings": meanings.join(" "),
                    "comment": "-1 where not computed yet",
                }),
            ),
            Kind::Numbers(unit) => ("float64", json!("NaN"), measured(field.long_name, unit)),
        };
        array(&shape, &chunk, &names, data_type, fill, attributes)
    }
}

fn coordinates(dimension: &Dimension) -> Value {
    let states = dimension.coordinates.len();
    array(
        &[states],
        &[states],
        &[&dimension.name],
        "float64",
        json!("NaN"),
        measured(&dimension.long_name, &dimension.unit),
    )
}

/// Dimensions of quantities whose units are the units of the study.
const DIMENSIONS: [&str; 4] = ["stress", "length", "time", "mass"];

/// Attributes of an array of numbers.
///
/// Without units in the study, stresses, times and lengths are in the consistent units of its input. Only their dimension is known, which CF units
/// cannot express: `units` then satisfies UDUNITS, and `dimension` gives the dimension.
fn measured(long_name: &str, unit: &str) -> Value {
    match DIMENSIONS.iter().any(|dimension| unit.contains(dimension)) {
        false => json!({"long_name": long_name, "units": unit}),
        true => json!({
            "long_name": format!("{long_name} ({unit})"),
            "units": "1",
            "dimension": unit,
            "comment": "in the consistent units of the study",
        }),
    }
}

/// Metadata of an array. The checksum is the last codec, so that it covers the compressed bytes.
pub(super) fn array(
    shape: &[usize],
    chunk: &[usize],
    names: &[&str],
    data_type: &str,
    fill: Value,
    attributes: Value,
) -> Value {
    let bytes = match data_type {
        "int8" => json!({"name": "bytes"}),
        _ => json!({"name": "bytes", "configuration": {"endian": "little"}}),
    };
    json!({
        "zarr_format": 3,
        "node_type": "array",
        "shape": shape,
        "data_type": data_type,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
        "fill_value": fill,
        "codecs": [bytes, {"name": "gzip", "configuration": {"level": GZIP_LEVEL}}, {"name": "crc32c"}],
        "dimension_names": names,
        "attributes": attributes,
    })
}
