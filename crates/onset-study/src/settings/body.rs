//! Bodies with grips, read from TOML, which `onset simulate` runs instead of a periodic patch.

use super::key::key;
use super::needs::is;
use super::toml::{File, described, in_order, typed};
use super::{Key, Kind, Origin, SettingError, Units, Value, units, unknown_key};
use crate::input;
use crate::number::counted;
use onset::material::Admitted::{Any, NotNegative, Positive};
use onset::motion::{BodyParticles, Contact, Grip, Notch, PlacedParticle, Shape};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

const BLOCKS: &[&str] = &["bar", "block", "plate"];
const ROUND: &[&str] = &["disk", "ring"];
const SHAPES: &[&str] = &["bar", "block", "plate", "disk", "ring"];

/// The keys of a body. Lengths are in units of `discretization.spacing`.
pub const BODY_KEYS: &[Key] = &[
    key(
        "body.shape",
        Kind::Words(&["bar", "block", "plate", "disk", "ring", "file"]),
        "shape that is cut out of the lattice, or a file of particles",
    ),
    key(
        "body.size",
        Kind::Numbers("1", Any),
        "side lengths in spacings, from the origin: length and width of a bar; one for each dimension of a block or a plate",
    )
    .only_with(&[&[is("body.shape", BLOCKS)]]),
    key(
        "body.hole",
        Kind::Number("1", Positive),
        "radius in spacings of a round hole in the middle of a plate",
    )
    .only_with(&[&[is("body.shape", &["plate"])]]),
    key(
        "body.notch",
        Kind::Numbers("1", Any),
        "depth and width in spacings of a notch that enters a plate from below, at the middle of its first side",
    )
    .only_with(&[&[is("body.shape", &["plate"])]]),
    key(
        "body.radius",
        Kind::Number("1", Positive),
        "outer radius in spacings; the center is at the origin",
    )
    .only_with(&[&[is("body.shape", ROUND)]]),
    key(
        "body.inner-radius",
        Kind::Number("1", Positive),
        "inner radius of a ring in spacings",
    )
    .only_with(&[&[is("body.shape", &["ring"])]]),
    key(
        "body.height",
        Kind::Number("1", Positive),
        "3D: height of a disk or a ring, 0 <= x3 <= height; particle spacings",
    )
    .only_with(&[&[is("body.shape", ROUND)]]),
    key(
        "body.second",
        Kind::Numbers("1", Any),
        "shift of a second copy of the shape, a vector in spacings with a number for each dimension",
    )
    .only_with(&[&[is("body.shape", SHAPES)]]),
    key(
        "body.contact",
        Kind::Number("1", Positive),
        "stiffness of the contact between pieces of total-Lagrangian particles, relative to the material; no contact by default",
    ),
    key(
        "body.file",
        Kind::Text,
        "CSV table with the columns x, y, z (one for each dimension) and volume, a line for each particle; length, length^D",
    )
    .only_with(&[&[is("body.shape", &["file"])]]),
];

/// Extension of a grip beyond its corners, in spacings, which allows for rounding errors of particle positions.
const RIM: f64 = 1e-9;

/// The keys of a grip. A study can have several grips.
pub const GRIP_KEYS: &[Key] = &[
    key(
        "grips.from",
        Kind::Numbers("1", Any),
        "lower corner of the box that contains the gripped particles in the reference configuration, in spacings",
    ),
    key(
        "grips.to",
        Kind::Numbers("1", Any),
        "upper corner of the box, in spacings",
    ),
    key(
        "grips.velocity",
        Kind::Numbers("length/time", Any),
        "prescribed velocity of the particles, a number for each dimension (length/time)",
    ),
    key(
        "grips.ramp",
        Kind::Number("time", NotNegative),
        "rise time of the velocity, which starts smoothly from zero; by default 0, no rise",
    ),
    key(
        "grips.until",
        Kind::Number("time", NotNegative),
        "time at which the grip releases its particles, which keep their velocity (0: initial velocity only; never by default)",
    ),
];

/// Values of keys, with the place at which each was set.
type Values = BTreeMap<&'static str, (Value, Origin)>;

/// First key with a unit, with its place.
type Measured = Option<(&'static str, Origin)>;

/// Body with its grips, as a study describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySettings {
    values: Values,
    grips: Vec<(Values, Origin)>,
    /// First key with a unit.
    measured: Measured,
    /// Place of the body in the file.
    origin: Origin,
    /// Folder of the study. File names are relative to it.
    folder: PathBuf,
}

/// Reads the keys of a table, each with its kind of value.
fn read(
    file: &File<'_>,
    section: &str,
    keys: &'static [Key],
    table: &DeTable<'_>,
    measured: &mut Measured,
) -> Result<Values, SettingError> {
    let mut values = BTreeMap::new();
    for (key, value) in in_order(table) {
        let name = format!("{section}.{}", key.get_ref());
        let Some(known) = keys.iter().find(|key| key.name == name) else {
            return Err(unknown_key(
                &name,
                keys.iter().map(|key| key.name),
                file.of(key),
            ));
        };
        let mut read = typed(known, value, file)?;
        if let Some(own) = units::converted(known, &read, &file.of(value))? {
            read = own;
            measured.get_or_insert_with(|| (known.name, file.of(value)));
        }
        if !known.kind.accepts(&read) {
            let message = format!("`{name}` cannot be {}", read.brief());
            return Err(SettingError::new(file.of(value), message)
                .hint(format!("expected {} ({})", known.expects(), known.meaning))
                .nearest_word(known.name, &read, known.words()));
        }
        values.insert(known.name, (read, file.of(value)));
    }
    Ok(values)
}

fn numbers<'v>(
    values: &'v Values,
    name: &str,
    count: usize,
    whole: &Origin,
) -> Result<&'v [f64], SettingError> {
    let Some((value, origin)) = values.get(name) else {
        return Err(missing(name, whole));
    };
    match value {
        Value::Numbers(numbers) if numbers.len() == count => Ok(numbers),
        other => {
            let given = match other {
                Value::Numbers(numbers) => numbers.len(),
                _ => 0,
            };
            let message = format!(
                "`{name}` has {}; expected {count}",
                counted(given, "number")
            );
            Err(SettingError::new(origin.clone(), message).hint(meaning(name)))
        }
    }
}

fn meaning(name: &str) -> &'static str {
    let mut keys = BODY_KEYS.iter().chain(GRIP_KEYS);
    keys.find(|key| key.name == name)
        .map_or("", |key| key.meaning)
}

fn missing(name: &str, whole: &Origin) -> SettingError {
    SettingError::new(whole.clone(), format!("there is no `{name}`")).hint(meaning(name))
}

impl BodySettings {
    /// Reads the body of a study, if it has one. Files are relative to the folder of the study `name`.
    ///
    /// # Errors
    /// [`SettingError`] with file, line and column of the error.
    pub fn of_file(name: &str, text: &str) -> Result<Option<Self>, SettingError> {
        let file = File::new(name, text);
        Self::of_table(&file, file.table()?.get_ref())
    }

    /// Reads the body from a table.
    pub(super) fn of_table(
        file: &File<'_>,
        table: &DeTable<'_>,
    ) -> Result<Option<Self>, SettingError> {
        let (mut body, mut grips) = (None, None);
        for (key, value) in in_order(table) {
            match key.get_ref().as_ref() {
                "body" => body = Some((key, value)),
                "grips" => grips = Some((key, value)),
                _ => {}
            }
        }
        let Some((key, value)) = body else {
            return match grips {
                Some((key, _)) => Err(SettingError::new(
                    file.of(key),
                    "`grips` have no effect without a body",
                )
                .hint("expected [body] with its keys below")),
                None => Ok(None),
            };
        };
        let DeValue::Table(table) = value.get_ref() else {
            let message = format!("`body` cannot be {}", described(value.get_ref()));
            return Err(SettingError::new(file.of(key), message)
                .hint("expected a table: [body] with its keys below"));
        };
        let mut measured = None;
        let own = Self {
            values: read(file, "body", BODY_KEYS, table, &mut measured)?,
            grips: match grips {
                Some((_, value)) => Self::read_grips(file, value, &mut measured)?,
                None => Vec::new(),
            },
            measured,
            origin: file.of(key),
            folder: Path::new(file.name)
                .parent()
                .map(Path::to_owned)
                .unwrap_or_default(),
        };
        own.check_keys_are_read()?;
        Ok(Some(own))
    }

    fn read_grips(
        file: &File<'_>,
        value: &Spanned<DeValue<'_>>,
        measured: &mut Measured,
    ) -> Result<Vec<(Values, Origin)>, SettingError> {
        let wrong = |value: &Spanned<DeValue<'_>>| {
            let message = format!("`grips` cannot be {}", described(value.get_ref()));
            SettingError::new(file.of(value), message)
                .hint("expected [[grips]] with from, to, velocity, ramp and until below")
        };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(wrong(value));
        };
        let grip = |item: &Spanned<DeValue<'_>>| match item.get_ref() {
            DeValue::Table(table) => Ok((
                read(file, "grips", GRIP_KEYS, table, measured)?,
                file.of(item),
            )),
            _ => Err(wrong(item)),
        };
        items.iter().map(grip).collect()
    }

    fn value(&self, name: &str) -> Option<&Value> {
        self.values.get(name).map(|(value, _)| value)
    }

    fn check_keys_are_read(&self) -> Result<(), SettingError> {
        for key in BODY_KEYS {
            let Some((_, origin)) = self.values.get(key.name) else {
                continue;
            };
            if let Some(unmet) = key.unmet(&|name| self.value(name).cloned()) {
                return Err(SettingError::unread(key, &unmet, origin.clone()));
            }
        }
        Ok(())
    }

    fn number(&self, name: &str) -> Option<f64> {
        self.value(name).and_then(Value::number)
    }

    fn shape(&self) -> Result<&str, SettingError> {
        match self.value("body.shape") {
            Some(Value::Word(word)) => Ok(word),
            _ => Err(missing("body.shape", &self.origin)),
        }
    }

    /// Places the particles of the body, in lengths, for a lattice of the given dimension and spacing.
    ///
    /// # Errors
    /// [`SettingError`] when a key is missing or has a wrong number of components, or a file cannot be read.
    pub fn particles(&self, dimension: usize, spacing: f64) -> Result<BodyParticles, SettingError> {
        if self.shape()? == "file" {
            return self.placed(dimension).map(BodyParticles::Given);
        }
        let shape = self.cut(dimension, spacing)?;
        if !self.values.contains_key("body.second") {
            return Ok(BodyParticles::Cut(shape));
        }
        let offset = numbers(&self.values, "body.second", dimension, &self.origin)?;
        if offset.iter().all(|own| *own == 0.0) {
            let origin = self.values.get("body.second").map(|(_, origin)| origin);
            let origin = origin.unwrap_or(&self.origin).clone();
            return Err(SettingError::new(
                origin,
                "`body.second` is zero: the two copies of the shape coincide",
            )
            .hint("expected the vector from the first copy of the shape to the second, in particle spacings, for example [10, 0]"));
        }
        Ok(BodyParticles::Cut(Shape::Twice {
            shape: Box::new(shape),
            offset: offset.iter().map(|own| own * spacing).collect(),
        }))
    }

    /// Refuses values with units in a problem without units.
    ///
    /// # Errors
    /// [`SettingError`] when a value has a unit.
    pub fn check_units(&self, units: Units) -> Result<(), SettingError> {
        match &self.measured {
            Some((name, origin)) if !units.are_si() => Err(SettingError::new(
                origin.clone(),
                format!("`{name}` has a unit, but material and discretization have no units"),
            )
            .hint("give units to all values with dimensions, or to none")),
            _ => Ok(()),
        }
    }

    /// Returns the contact between pieces of the body, if there is contact.
    pub fn contact(&self) -> Option<Contact> {
        self.number("body.contact")
            .map(|stiffness| Contact { stiffness })
    }

    /// Shape that is cut out of the lattice.
    fn cut(&self, dimension: usize, spacing: f64) -> Result<Shape, SettingError> {
        let length = |name: &str| self.number(name).map(|own| own * spacing);
        let needed = |name: &str| length(name).ok_or_else(|| missing(name, &self.origin));
        match self.shape()? {
            "disk" | "ring" if dimension == 1 => Err(self.refused("is not one-dimensional")),
            shape @ ("disk" | "ring") => {
                if let (Some((_, origin)), true) = (self.values.get("body.height"), dimension < 3) {
                    return Err(SettingError::new(
                        origin.clone(),
                        "`body.height` has no effect in two dimensions",
                    )
                    .hint("omit body.height"));
                }
                Ok(Shape::Ring {
                    radius: needed("body.radius")?,
                    inner: match shape {
                        "ring" => needed("body.inner-radius")?,
                        _ => 0.0,
                    },
                    height: match dimension {
                        3 => Some(needed("body.height")?),
                        _ => None,
                    },
                })
            }
            shape => {
                if shape == "plate" && dimension == 1 {
                    return Err(self.refused("is not one-dimensional"));
                }
                let sides = match shape {
                    "bar" => dimension.min(2),
                    _ => dimension,
                };
                let given = numbers(&self.values, "body.size", sides, &self.origin)?;
                let last = given[given.len() - 1];
                let sides = (0..dimension).map(|i| spacing * given.get(i).copied().unwrap_or(last));
                let notch = match self.values.get("body.notch") {
                    None => None,
                    Some(_) => {
                        let own = numbers(&self.values, "body.notch", 2, &self.origin)?;
                        Some(Notch {
                            depth: own[0] * spacing,
                            width: own[1] * spacing,
                        })
                    }
                };
                Ok(Shape::Block {
                    size: sides.collect(),
                    hole: length("body.hole"),
                    notch,
                })
            }
        }
    }

    fn refused(&self, why: &str) -> SettingError {
        let origin = self.values.get("body.shape").map(|(_, origin)| origin);
        let shape = self.shape().unwrap_or("");
        SettingError::new(
            origin.unwrap_or(&self.origin).clone(),
            format!("a {shape} {why}"),
        )
        .hint("choose bar, or a lattice of more dimensions")
    }

    /// Returns the grips, with the corners of their boxes converted from spacings to lengths.
    ///
    /// # Errors
    /// [`SettingError`] when a key is missing or has a wrong number of components.
    pub fn grips(&self, dimension: usize, spacing: f64) -> Result<Vec<Grip>, SettingError> {
        let grip = |(values, whole): &(Values, Origin)| {
            let list = |name: &str| numbers(values, name, dimension, whole).map(<[f64]>::to_vec);
            // Particles on a face are held despite rounding errors of their positions.
            let scaled = |own: Vec<f64>, beyond: f64| {
                own.into_iter().map(|x| (x + beyond) * spacing).collect()
            };
            let time = |name: &str, left_out: f64| match values.get(name) {
                None => Ok(left_out),
                Some((value, origin)) => match value.number() {
                    Some(time) if time >= 0.0 => Ok(time),
                    _ => Err(SettingError::new(
                        origin.clone(),
                        format!("`{name}` cannot be {}", value.brief()),
                    )
                    .hint("expected a time that is not negative")),
                },
            };
            let (ramp, until) = (
                time("grips.ramp", 0.0)?,
                time("grips.until", f64::INFINITY)?,
            );
            if let (Some((_, origin)), true) =
                (values.get("grips.ramp"), ramp > 0.0 && until == 0.0)
            {
                let message = "`grips.ramp` has no effect with `grips.until = 0`: the grip releases its particles before the ramp begins";
                return Err(
                    SettingError::new(origin.clone(), message).hint("leave one of them out")
                );
            }
            Ok(Grip {
                low: scaled(list("grips.from")?, -RIM),
                high: scaled(list("grips.to")?, RIM),
                velocity: list("grips.velocity")?,
                ramp,
                until,
            })
        };
        self.grips.iter().map(grip).collect()
    }

    /// Reads the particles from the file.
    fn placed(&self, dimension: usize) -> Result<Vec<PlacedParticle>, SettingError> {
        let Some((Value::Word(name), origin)) = self.values.get("body.file") else {
            return Err(missing("body.file", &self.origin));
        };
        let path = self.folder.join(name);
        let wrong = |line: usize, what: String| {
            SettingError::new(
                origin.clone(),
                format!("{}, line {line}: {what}", path.display()),
            )
            .hint(format!(
                "expected the line {} followed by lines of finite numbers with positive volumes",
                header(dimension)
            ))
        };
        let text = input::text(&path, input::MOST_TEXT).map_err(|error| {
            SettingError::new(
                origin.clone(),
                format!("cannot read {}: {error}", path.display()),
            )
            .hint("file names are relative to the folder of the study")
        })?;
        let mut lines = text.lines().enumerate();
        let named = |cell: &str| cell.trim().to_owned();
        let first: Vec<String> = lines
            .next()
            .map_or_else(Vec::new, |(_, line)| line.split(',').map(named).collect());
        if first.join(",") != header(dimension) {
            return Err(wrong(1, "the columns are others".to_owned()));
        }
        let mut particles = Vec::new();
        for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            if cells.len() != dimension + 1 {
                return Err(wrong(number + 1, counted(cells.len(), "cell")));
            }
            let mut read = [0.0; 4];
            for (own, cell) in read.iter_mut().zip(cells) {
                *own = cell
                    .parse()
                    .ok()
                    .filter(|value: &f64| value.is_finite())
                    .ok_or_else(|| wrong(number + 1, "a cell is not a finite number".to_owned()))?;
            }
            let volume = read[dimension];
            if volume <= 0.0 {
                return Err(wrong(number + 1, format!("the volume is {volume}")));
            }
            let mut position = [0.0; 3];
            position[..dimension].copy_from_slice(&read[..dimension]);
            particles.push(PlacedParticle { position, volume });
        }
        Ok(particles)
    }
}

/// Header of a file of particles.
fn header(dimension: usize) -> String {
    let axes = ["x", "y", "z"].into_iter().take(dimension);
    axes.chain(["volume"]).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::BodySettings;
    use onset::motion::{BodyParticles, Shape};

    fn refused(text: &str) -> String {
        let read = BodySettings::of_file("study.toml", text);
        let refused = read.and_then(|body| {
            let body = body.expect("a body");
            body.particles(2, 1.0)?;
            body.grips(2, 1.0).map(drop)
        });
        refused.expect_err("refused").to_string()
    }

    #[test]
    fn a_body_is_converted_from_spacings_to_lengths() {
        let text = "[body]\nshape = 'bar'\nsize = [40, 6]\n[[grips]]\nfrom = [0, 0]\nto = [2, 6]\nvelocity = [0.1, 0]\nramp = 2";
        let body = BodySettings::of_file("study.toml", text)
            .expect("read")
            .expect("a body");
        let BodyParticles::Cut(Shape::Block { size, hole, notch }) =
            body.particles(3, 0.5).expect("particles")
        else {
            panic!("a block");
        };
        assert_eq!((size, hole, notch), (vec![20.0, 3.0, 3.0], None, None));
        let twice = text.replace("size = [40, 6]", "size = [40, 6]\nsecond = [0, 9]");
        let twice = BodySettings::of_file("study.toml", &twice)
            .expect("read")
            .expect("a body");
        let BodyParticles::Cut(Shape::Twice { shape, offset }) =
            twice.particles(2, 0.5).expect("particles")
        else {
            panic!("two blocks");
        };
        assert_eq!(offset, [0.0, 4.5]);
        assert!(matches!(*shape, Shape::Block { .. }));
        let grips = body.grips(2, 0.5).expect("grips");
        assert_eq!(grips[0].ramp, 2.0);
        // Faces are held despite rounding errors of positions on them.
        for (place, is_held) in [
            ([1.0, 3.0], true),
            ([1.0 + 1e-15, 0.0], true),
            ([1.1, 3.0], false),
        ] {
            let sides = place.iter().zip(grips[0].low.iter().zip(&grips[0].high));
            let holds = sides
                .into_iter()
                .all(|(x, (low, high))| low <= x && x <= high);
            assert_eq!(holds, is_held, "{place:?}");
        }
        assert_eq!(
            BodySettings::of_file("study.toml", "title = 'none'"),
            Ok(None)
        );
    }

    #[test]
    fn keys_without_effect_are_refused_with_their_position() {
        let told = refused("[body]\nshape = 'bar'\nsize = [40, 6]\nhole = 3");
        assert!(
            told.contains("study.toml:4") && told.contains("body.hole"),
            "{told}"
        );
        assert!(refused("[[grips]]\nfrom = [0]").contains("without a body"));
        assert!(refused("[body]\nshape = 'bar'\nsize = [40]").contains("expected 2"));
        assert!(refused("[body]\nshape = 'cube'").contains("cannot be"));
        assert!(refused("[body]\nsize = [1, 2]").contains("body.shape"));
        assert!(refused("[body]\nshape = 'disk'\nradius = 4\nheight = 1").contains("no effect"));
        assert!(refused("[body]\nshape = 'disk'\nradius = -4").contains("positive"));
        assert!(refused("[body]\nshape = 'bar'\nsise = [40, 2]").contains("size"));
        let grip = "[body]\nshape = 'disk'\nradius = 9\n[[grips]]\nfrom = [0, 0]\nto = [1, 1]\n";
        assert!(refused(grip).contains("grips.velocity"));
        let told = refused(&format!("{grip}velocity = [1, 0]\nramp = 2\nuntil = 0"));
        assert!(told.contains("`grips.ramp` has no effect"), "{told}");
        let told = refused("[body]\nshape = 'bar'\nsize = [40, 6]\nsecond = [0, 0]");
        assert!(told.contains("`body.second` is zero"), "{told}");
        for key in ["ramp", "until"] {
            let told = refused(&format!("{grip}velocity = [1, 0]\n{key} = -1"));
            assert!(told.contains(key) && told.contains("from 0 to"), "{told}");
        }
    }
}
