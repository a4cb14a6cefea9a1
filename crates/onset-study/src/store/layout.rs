//! What a store holds, and the Zarr metadata that say so. The same layout gives the same bytes, always.

use super::Tiling;
use serde_json::{Map, Value, json};

/// A dimension: an axis of the study with its coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Dimension {
    /// Its name, and that of its coordinates.
    pub name: String,
    /// The name for people.
    pub long_name: String,
    /// The unit of the coordinates.
    pub unit: String,
    /// One coordinate a state.
    pub coordinates: Vec<f64>,
}

/// What the values of a field are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Small whole numbers with meanings, counted from zero; -1 where nothing has been computed.
    Flags(Vec<&'static str>),
    /// Numbers of double precision with a unit; NaN where there is none.
    Numbers(&'static str),
}

/// A field: one value, or one vector, a state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// The name for people.
    pub long_name: &'static str,
    /// What its values are.
    pub kind: Kind,
    /// Whether it is a vector.
    pub is_vector: bool,
}

impl Field {
    /// The same with its unit in place of a dimension.
    pub fn in_units(mut self, unit: impl Fn(&'static str) -> &'static str) -> Self {
        if let Kind::Numbers(own) = &mut self.kind {
            *own = unit(own);
        }
        self
    }
}

/// All that a store holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Attributes of the whole.
    pub attributes: Map<String, Value>,
    /// What the numbers are of: each chunk says it, so that one of another map is noticed.
    pub identity: String,
    /// The dimensions, slowest first.
    pub dimensions: Vec<Dimension>,
    /// States of a tile along each dimension.
    pub tile: Vec<usize>,
    /// Components of a vector.
    pub components: usize,
    /// The fields. The first is written last, and says that a tile is done.
    pub fields: Vec<Field>,
}

/// The dimension of the components of vectors.
const COMPONENT: &str = "component";
/// The attribute by which a store of ours is known; its value is the version of this layout of files.
pub(super) const FORMAT: &str = "onset_format";
pub(super) const FORMAT_VERSION: u32 = 3;
/// The attribute that tells what the numbers are of.
pub(super) const IDENTITY: &str = "onset_identity";
/// What it means that an attribute is another one.
pub(super) const MEANINGS: [(&str, &str); 4] = [
    (
        LIBRARY,
        "the library of its material is another one, by its SHA-256; was it compiled anew?",
    ),
    ("onset_version", "it was begun by another version of onset"),
    (
        "onset_build",
        "it was begun by another build of onset, whose numbers may differ",
    ),
    (
        "onset_lanes",
        "it was begun on a processor with other vectors, whose numbers differ in their last digits",
    ),
];
/// The attribute with the SHA-256 of the library that the study loads.
pub(crate) const LIBRARY: &str = "material_library_sha256";
/// Compression of chunks: the fastest; higher levels gain a few percent on measured numbers and cost several times more.
pub(super) const GZIP_LEVEL: u32 = 1;

impl Layout {
    /// How the states are cut into tiles.
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

    /// The metadata of every array, by name: coordinates, then fields.
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

    /// The metadata of the whole, with those of every array in it, so that one file tells everything.
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

    /// The values of the coordinates, by the name of their array.
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

/// Dimensions, where the units are those of the study.
const DIMENSIONS: [&str; 4] = ["stress", "length", "time", "mass"];

/// The attributes of numbers. Of a study without units the program computes in whatever consistent units its input is, so that of a
/// stress, a time or a length only the dimension is known, which CF has no units for: `units` is what UDUNITS reads, `dimension` what is
/// measured.
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

/// The metadata of an array. The checksum comes last, and so covers the bytes as they lie on the disk.
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
