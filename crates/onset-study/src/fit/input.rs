//! Test data: tables in CSV with a header, in decks of Abaqus and Ansys, and arrays.
//!
//! Inconsistent data, and data that contradict a header, are refused, because even a misread table can be fitted.

use super::list;
use crate::input::{self, MOST_TEXT};
use crate::number::{counted, told, told_with};
use crate::settings::units::{names_of, value_of};
use crate::settings::{fields_of_keyword, stress_unit};
use onset_fit::{Family, Mode, Options, Point, Test, Weights, fit};
use std::ops::RangeBounds;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Reason why a table of test data cannot be used.
#[derive(Debug, Error)]
pub enum TableError {
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A line of a file, or a point of an array, that cannot be used.
    #[error("{}, {row} {line}: {message}\n  hint: {hint}", path.display())]
    Line {
        /// Path of the file, or name of the array.
        path: PathBuf,
        /// Counted unit: `line` or `point`.
        row: &'static str,
        /// Line from 1, or point from 0.
        line: usize,
        /// Description of the finding and the expectation.
        message: String,
        /// Advice for the user.
        hint: String,
    },
    /// A file or an array that cannot be used as a whole.
    #[error("{}: {message}\n  hint: {hint}", path.display())]
    File {
        /// Path of the file, or name of the array.
        path: PathBuf,
        /// Description of the finding and the expectation.
        message: String,
        /// Advice for the user.
        hint: String,
    },
    /// Tests that contradict each other.
    #[error("{message}\n  hint: {hint}")]
    Tests {
        /// Description of the contradiction between the tests.
        message: String,
        /// Advice for the user.
        hint: String,
    },
}

/// Test data as given by the user.
#[derive(Clone, Debug)]
pub enum Source {
    /// Table in a file, and its loading if the user named it; `None` if a comment or the file name gives it. A file `NAME.toml` lists tests.
    File(PathBuf, Option<Mode>),
    /// Arrays of the same length.
    Arrays(Arrays),
    /// Table of columns with the names and units of a file.
    Columns(Columns),
}

/// Test as a table: columns of cells with their names, which can have units.
#[derive(Clone, Debug)]
pub struct Columns {
    /// Name of the test in messages.
    pub name: String,
    /// Loading of the specimen.
    pub mode: Mode,
    /// Name of each column, with its cells.
    pub cells: Vec<(String, Vec<String>)>,
}

/// Test as arrays: stretches (amounts of shear in simple shear, ratios of volumes in a volumetric test) and nominal stresses (pressures).
#[derive(Clone, Debug)]
pub struct Arrays {
    /// Name of the test in messages about its points.
    pub name: String,
    /// Loading of the specimen.
    pub mode: Mode,
    /// Imposed stretches of the points, dimensionless.
    pub stretch: Vec<f64>,
    /// Measured nominal stresses of the points.
    pub stress: Vec<f64>,
    /// Lateral stretches; `None` if they were not measured.
    pub lateral: Option<Vec<f64>>,
}

/// Table whose text is known, or arrays with an empty text.
pub(super) struct Opened<'a> {
    /// Path of the file, or name of the table in messages.
    pub path: PathBuf,
    pub text: String,
    /// Loading that the user named.
    pub mode: Option<Mode>,
    /// Whether the text is the text of a file, so that its lines can be named.
    pub is_file: bool,
    pub arrays: Option<&'a Arrays>,
    /// Weight of the test in a list of tests.
    pub weight: Option<f64>,
}

/// Origin of a test.
struct Origin {
    path: PathBuf,
    /// Meaning of its column of stresses; `None` without a header.
    stress: Option<Column>,
}

impl Origin {
    /// Returns true if true stresses were converted to nominal stresses.
    fn is_true(&self) -> bool {
        self.stress == Some(Column::TrueStress)
    }
}

impl<'a> Opened<'a> {
    /// Tables of a source; several if it is a list of tests.
    fn all(source: &'a Source) -> Result<Vec<Self>, TableError> {
        Ok(match source {
            Source::Arrays(arrays) => vec![Self {
                path: PathBuf::from(&arrays.name),
                text: String::new(),
                mode: None,
                is_file: false,
                arrays: Some(arrays),
                weight: None,
            }],
            Source::Columns(own) => vec![Self {
                path: PathBuf::from(&own.name),
                text: list::joined(&own.cells).map_err(|message| TableError::File {
                    path: PathBuf::from(&own.name),
                    message,
                    hint: "give a number in each column for each point".to_owned(),
                })?,
                mode: Some(own.mode),
                is_file: false,
                arrays: None,
                weight: None,
            }],
            Source::File(path, None) if list::is_list(path) => {
                list::tests(path, &Self::file(path, None)?.text)?
            }
            Source::File(path, mode) => vec![Self::file(path, *mode)?],
        })
    }

    pub(super) fn file(path: &Path, mode: Option<Mode>) -> Result<Self, TableError> {
        let mut text = input::text(path, MOST_TEXT).map_err(|source| TableError::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        if !text.contains('\n') {
            text = text.replace('\r', "\n");
        }
        Ok(Self {
            path: path.to_owned(),
            text,
            mode,
            is_file: true,
            arrays: None,
            weight: None,
        })
    }
}

/// Options for reading tables.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Unit of stress for tables that state no unit; `None` if it is unknown.
    pub unit: Option<String>,
    /// Area of the undeformed cross-section, used to convert forces to nominal stresses; `None` for tables of stresses.
    pub area: Option<f64>,
    /// Smallest and largest stretch of the points to use; `None` for all points.
    pub range: Option<[f64; 2]>,
    /// Material whose tests are read from decks with several materials; `None` for decks with one material.
    pub material: Option<String>,
    /// Weights of the squared errors of tests, by their loadings or by their names in answers.
    pub weights: Vec<(String, f64)>,
}

/// Tests with remarks on their tables.
#[derive(Clone, Debug, Default)]
pub struct Tests {
    /// Tests in the order of the files.
    pub tests: Vec<Test>,
    /// Unit of all stresses; `None` if the tables state no unit.
    pub unit: Option<String>,
    /// Questions on stresses that contradict the other tests.
    pub questions: Vec<String>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
}

/// Largest ratio of the secant moduli of neighboring rows of one test.
const LARGEST_JUMP: f64 = 100.0;

/// Smallest number of points of a test.
const LEAST_POINTS: usize = 3;
/// Largest stretch of rubber; larger numbers are read as percentages.
const LARGEST: f64 = 20.0;
/// Largest amount of shear; larger numbers are read as percentages.
const LARGEST_SHEAR: f64 = 5.0;
/// Hint for arrays that appear to contain strains.
const STRETCHES: &str = "a stretch is 1 plus the strain, and 100 % is a strain of 1";
/// Smallest and largest admissible value of the largest stress of a test.
const STRESSES: [f64; 2] = [1e-20, 1e20];
/// Smallest admissible value of the largest strain of a test.
const LEAST_STRAIN: f64 = 1e-4;
/// Largest difference between the stretches that two columns give for one row.
const STRETCH_TOLERANCE: f64 = 0.01;
/// Strains at which the stress is nearly linear, and part of the first stress that is an offset if it remains without strain.
const SMALL_STRAIN: f64 = 0.12;
const OFFSET_PART: f64 = 0.6;
/// Volume ratios of a volumetric test that are all smaller are changes of volume.
const LEAST_VOLUME: f64 = 0.5;
/// Largest change of volume for which laws of constant volume are fitted without a note.
const CONSTANT_VOLUME: f64 = 0.1;
/// Largest ratios of the initial shear moduli of two tests: the ratio at which tests of one material contradict each other, and the ratio without a
/// note.
const CONTRADICTION: f64 = 10.0;
const DISAGREEMENT: f64 = 2.5;
/// Law that is fitted with stresses per undeformed and per deformed area.
const COMPARED_LAW: &str = "james-green-simpson";
/// A question needs this ratio of the errors of both fits, and a smaller error of the better fit than the second number.
const OTHER_STRESS: f64 = 2.0;
const FITTING_STRESS: f64 = 0.12;
/// Least number of points, and largest number of tests, for which both are fitted.
const LEAST_COMPARED: usize = 12;
const MOST_COMPARED: usize = 6;

impl Tests {
    /// Reads files and arrays, in the given order.
    ///
    /// # Errors
    /// [`TableError`] with the line if a table cannot be used, or if the tests contradict each other.
    pub fn read(sources: &[Source], reading: &Reading) -> Result<Self, TableError> {
        let mut all = Self::default();
        let mut units: Vec<(String, Option<String>)> = Vec::new();
        let mut used_material = false;
        let mut origins: Vec<Origin> = Vec::new();
        let mut given = Vec::new();
        for own in sources {
            given.extend(Opened::all(own)?);
        }
        for own in &given {
            let (path, text) = (own.path.clone(), own.text.as_str());
            let is_deck = own.is_file && is_deck(text);
            let table = Table {
                path: &path,
                row: match own.is_file {
                    true => "line",
                    false => "point",
                },
                // The first row below the header has the number 0, as in arrays.
                before: match own.is_file || own.arrays.is_some() {
                    true => 0,
                    false => 2,
                },
                text,
                columns: is_deck.then_some(ABAQUS),
                reading,
            };
            let mut stress = None;
            let found = match own.arrays {
                Some(arrays) => vec![(table.arrays(arrays)?, None)],
                None if is_deck => {
                    used_material = true;
                    table.of_material(table.deck()?)?
                }
                None if own.is_file && is_ansys(text) => {
                    used_material = true;
                    table.of_material(table.ansys()?)?
                }
                None => {
                    let (test, unit, column) = table.csv(own.mode, &mut all.notes)?;
                    stress = Some(column);
                    vec![(test, unit)]
                }
            };
            for (mut test, unit) in found {
                // The range of stretches does not restrict volumetric tests.
                let range = reading.range.filter(|_| test.mode != Mode::Volumetric);
                if let Some([low, high]) = range {
                    let mode = test.mode;
                    let largest = |own: &Point| match mode {
                        Mode::SimpleShear => mode.logs(own.stretch)[0].exp(),
                        _ => own.stretch,
                    };
                    test.points
                        .retain(|own| (low..=high).contains(&largest(own)));
                }
                let mut distinct: Vec<f64> = test.points.iter().map(|own| own.stretch).collect();
                distinct.sort_by(f64::total_cmp);
                distinct.dedup();
                if distinct.len() < LEAST_POINTS {
                    return Err(table.refused(
                        format!(
                            "the {} test has points at {}{}; expected at least {LEAST_POINTS}",
                            test.mode.name(),
                            counted(distinct.len(), "strain"),
                            match range {
                                Some(_) => " in the range that is used",
                                None => " other than the reference configuration",
                            },
                        ),
                        match range {
                            Some(_) => "widen the range, or add points",
                            None => "add points of the test",
                        },
                    ));
                }
                let is_same = |own: &&Test| own.mode == test.mode && own.points == test.points;
                if let Some(other) = all.tests.iter().find(is_same) {
                    return Err(table.refused(
                        format!(
                            "the {} test has the same points as {}",
                            test.mode.name(),
                            match all.tests.iter().filter(|own| own.mode == test.mode).count() {
                                1 => format!("the {} test before it", other.name),
                                _ => format!("one of the {} tests before it", other.name),
                            }
                        ),
                        "give each test once; it would count twice",
                    ));
                }
                test.weight = own.weight.unwrap_or(1.0);
                all.notes.extend(table.repeated(&test));
                all.notes.extend(table.decreasing(&test));
                all.questions.extend(table.compressed(&test));
                all.notes.extend(table.offset(&test));
                units.push((test.name.clone(), unit.or_else(|| reading.unit.clone())));
                all.tests.push(test);
                let path = path.clone();
                origins.push(Origin { path, stress });
            }
        }
        let is_force = |own: &Origin| own.stress == Some(Column::Force);
        if reading.area.is_some() && !origins.iter().any(is_force) {
            all.notes
                .push("the area is not used: no table has a column of forces".to_owned());
        }
        if reading.material.is_some() && !used_material {
            let text = "the name of the material is not used: no file is a deck";
            all.notes.push(text.to_owned());
        }
        if all.tests.iter().all(|test| test.mode == Mode::Volumetric) && !all.tests.is_empty() {
            return Err(TableError::Tests {
                message: "volumetric tests alone determine only the bulk modulus".to_owned(),
                hint: "add a uniaxial, equibiaxial, planar or simple shear test".to_owned(),
            });
        }
        all.convert(&units)?;
        all.compare()?;
        all.number();
        all.weigh(&reading.weights)?;
        all.questions.extend(all.other_stress(&origins));
        Ok(all)
    }

    /// Converts all stresses to the unit of the first test.
    fn convert(&mut self, units: &[(String, Option<String>)]) -> Result<(), TableError> {
        let Some((first, unit)) = units.first() else {
            return Ok(());
        };
        for ((name, own), test) in units.iter().zip(&mut self.tests) {
            let (Some(unit), Some(own)) = (unit, own) else {
                if unit.is_none() && own.is_none() {
                    continue;
                }
                return Err(TableError::Tests {
                    message: format!("one of the tests {first} and {name} names a unit of stress, and the other does not"),
                    hint: "write the unit into each header, for example nominal_stress [MPa], or name the unit of all tests".to_owned(),
                });
            };
            let factor = stress_unit(own)
                .zip(stress_unit(unit))
                .map(|(own, unit)| own / unit);
            let Some(factor) = factor else {
                let unknown = if stress_unit(own).is_none() {
                    own
                } else {
                    unit
                };
                return Err(TableError::Tests {
                    message: format!("the unit of stress `{unknown}` is not known"),
                    hint: format!("expected {}", names_of("stress")),
                });
            };
            if factor != 1.0 {
                self.notes.push(format!(
                    "stresses of {name} are converted from {own} to {unit}"
                ));
                test.points
                    .iter_mut()
                    .for_each(|point| point.stress *= factor);
            }
        }
        self.unit.clone_from(unit);
        Ok(())
    }

    /// Compares the initial shear moduli of the tests.
    fn compare(&mut self) -> Result<(), TableError> {
        let moduli: Vec<(String, f64)> = self
            .tests
            .iter()
            .filter_map(|test| Some((test.name.clone(), initial_modulus(test)?)))
            .collect();
        let by = |a: &&(String, f64), b: &&(String, f64)| a.1.total_cmp(&b.1);
        let (Some(least), Some(most)) = (moduli.iter().min_by(by), moduli.iter().max_by(by)) else {
            return Ok(());
        };
        let text = format!(
            "the tests give different shear moduli at small strains: {} from {} and {} from {}",
            told(least.1),
            least.0,
            told(most.1),
            most.0
        );
        if most.1 > CONTRADICTION * least.1 {
            return Err(TableError::Tests {
                message: text,
                hint: "check the units of stress, percentages taken as strains, and the loading of each file".to_owned(),
            });
        }
        if most.1 > DISAGREEMENT * least.1 {
            self.notes.push(format!(
                "{text}; check whether a true stress is given as nominal stress, and the loading of each file"
            ));
        }
        Ok(())
    }

    /// Sets weights by loadings, or by names of tests.
    fn weigh(&mut self, weights: &[(String, f64)]) -> Result<(), TableError> {
        for (name, weight) in weights {
            let wrong = |message: String, hint: String| TableError::Tests { message, hint };
            if !(*weight > 0.0 && weight.is_finite()) {
                return Err(wrong(
                    format!("the weight of {name} is {weight}"),
                    "expected a positive number; to ignore a test, omit its table".to_owned(),
                ));
            }
            let names: Vec<String> = self.tests.iter().map(|test| test.name.clone()).collect();
            let own = self.tests.iter_mut();
            let mut own = own
                .filter(|test| test.name == *name || test.mode.name() == name)
                .peekable();
            match own.peek() {
                None => {
                    return Err(wrong(
                        format!("a weight is given for {name}, but there is no such test"),
                        format!("the tests are {}", names.join(", ")),
                    ));
                }
                Some(test) if test.mode == Mode::Volumetric => {
                    return Err(wrong(
                        "a weight is given for the volumetric test, which alone determines the bulk modulus".to_owned(),
                        "omit the weight".to_owned(),
                    ));
                }
                Some(_) => own.for_each(|test| test.weight = *weight),
            }
        }
        Ok(())
    }

    /// Question whether stresses refer to the other area, the deformed or the undeformed one, if a law fits all tests much better then.
    fn other_stress(&self, origins: &[Origin]) -> Option<String> {
        let used: Vec<usize> = (0..self.tests.len())
            .filter(|n| Mode::LOADINGS.contains(&self.tests[*n].mode))
            .collect();
        let points: usize = used.iter().map(|n| self.tests[*n].points.len()).sum();
        let is_one_mode = |mode: Mode| used.iter().all(|n| self.tests[*n].mode == mode);
        if Mode::LOADINGS.into_iter().any(is_one_mode)
            || used.len() > MOST_COMPARED
            || points < LEAST_COMPARED
            || self.volume_change().is_some()
        {
            return None;
        }
        let family = Family::named(COMPARED_LAW)?;
        let options = Options {
            weights: Weights::Relative(super::TEST_FLOOR),
            range: None,
            criteria: Vec::new(),
            ..Options::default()
        };
        // Bits of the number of a reading are set for the tests whose stresses refer to the other area.
        let error = |reading: usize| {
            let read = used.iter().enumerate().map(|(bit, n)| {
                let mut test = self.tests[*n].clone();
                test.weight = 1.0;
                if reading >> bit & 1 == 1 {
                    for point in &mut test.points {
                        point.stress *= match origins[*n].is_true() {
                            true => point.stretch,
                            false => point.stretch.recip(),
                        };
                    }
                }
                test
            });
            let tests: Vec<Test> = read.collect();
            let found = fit(&tests, &family, &options).ok()?;
            Some(found.free.relative)
        };
        let given = error(0)?;
        // The reading that changes the smallest number of tests is the most likely.
        let others =
            (1..1_usize << used.len()).filter_map(|reading| Some((reading, error(reading)?)));
        let fits = others.filter(|(_, own)| *own < FITTING_STRESS && OTHER_STRESS * own <= given);
        let (reading, best) = fits.min_by(|(a, x), (b, y)| {
            let tests = a.count_ones().cmp(&b.count_ones());
            tests.then(x.total_cmp(y))
        })?;
        let read = used.iter().enumerate();
        let read: Vec<usize> = read
            .filter(|(bit, _)| reading >> bit & 1 == 1)
            .map(|(_, n)| *n)
            .collect();
        let names = read
            .iter()
            .map(|n| format!("{} ({})", self.tests[*n].name, origins[*n].path.display()));
        let (area, column) = match read.iter().all(|n| origins[*n].is_true()) {
            true => ("undeformed", "nominal_stress"),
            false => ("deformed", "true_stress"),
        };
        Some(format!(
            "{}: do the stresses refer to the {area} area? {COMPARED_LAW} fits all tests within {} % then, and within {} % as given; if so, name the column {column}",
            names.collect::<Vec<_>>().join(", "),
            told_with(100.0 * best, 3),
            told_with(100.0 * given, 3)
        ))
    }

    /// Test with the largest change of volume by its lateral stretches, and this change; `None` if the volume is nearly constant.
    pub(super) fn volume_change(&self) -> Option<(&Test, f64)> {
        let changes = self.tests.iter().flat_map(|test| {
            let points = test.points.iter();
            points.filter_map(move |own| {
                let lateral = own.lateral?;
                let volume = match test.mode {
                    Mode::Uniaxial => own.stretch * lateral * lateral,
                    Mode::Equibiaxial => own.stretch * own.stretch * lateral,
                    Mode::Planar => own.stretch * lateral,
                    Mode::SimpleShear | Mode::Volumetric => return None,
                };
                Some((test, volume - 1.0))
            })
        });
        let most = changes.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        most.filter(|(_, change)| change.abs() > CONSTANT_VOLUME)
    }

    /// Returns true if the volume changes, and all points of stretched specimens have lateral stretches, so that laws of foam can be fitted.
    pub(super) fn is_foam(&self) -> bool {
        let mut stretched = self
            .tests
            .iter()
            .filter(|test| Mode::LOADINGS.contains(&test.mode));
        let has_laterals = |test: &Test| test.points.iter().all(|own| own.lateral.is_some());
        self.volume_change().is_some() && stretched.all(has_laterals)
    }

    /// Numbers the tests that have the same name.
    fn number(&mut self) {
        let names: Vec<String> = self.tests.iter().map(|test| test.name.clone()).collect();
        for (n, test) in self.tests.iter_mut().enumerate() {
            let before = names[..n].iter().filter(|own| **own == names[n]).count();
            if before > 0 {
                test.name = format!("{} {}", names[n], before + 1);
            }
        }
    }
}

/// Shear modulus from the points with the smallest strains; `None` without such points.
fn initial_modulus(test: &Test) -> Option<f64> {
    // Exponents of the strain of the neo-Hookean law, P = mu (lambda - lambda^-n).
    let exponent = match test.mode {
        Mode::Uniaxial => -2,
        Mode::Equibiaxial => -5,
        Mode::Planar => -3,
        Mode::SimpleShear | Mode::Volumetric => return None,
    };
    let strain = |own: &Point| own.stretch - own.stretch.powi(exponent);
    let nearest = test
        .points
        .iter()
        .filter(|own| (0.5..2.0).contains(&own.stretch) && own.stretch != 1.0);
    let mut near: Vec<&Point> = nearest.collect();
    near.sort_by(|a, b| a.stretch.ln().abs().total_cmp(&b.stretch.ln().abs()));
    near.truncate(4);
    let (above, below) = near.iter().fold((0.0, 0.0), |(above, below), own| {
        let strain = strain(own);
        (above + own.stress * strain, below + strain * strain)
    });
    (below > 0.0 && above > 0.0).then(|| above / below)
}

/// Smallest largest strain that may be a percentage, and largest strain in percentages that may be fractions.
const LEAST_PERCENT: f64 = 1.0;
const MOST_FRACTION: f64 = 0.1;
/// Largest relative error of neo-Hooke's law for a reading of the strains that fits, and the least ratio of the error of the other reading.
const FITTING_READING: f64 = 0.03;
/// Largest relative error of neo-Hooke's law for strains that are read as compression.
const FITTING_COMPRESSION: f64 = 0.08;
const OTHER_READING: f64 = 4.0;

/// Root mean square of the relative errors of neo-Hooke's law with its best modulus, if all strains are multiplied by a factor.
fn neo_hooke_error(mode: Mode, rows: &[(usize, Point)], factor: f64) -> f64 {
    let ratios = rows.iter().filter_map(|(_, point)| {
        let stretch = 1.0 + factor * (point.stretch - 1.0);
        let unit = match mode {
            Mode::Equibiaxial => stretch - stretch.powi(-5),
            Mode::Planar => stretch - stretch.powi(-3),
            _ => stretch - stretch.powi(-2),
        };
        (stretch > 0.0 && point.stress != 0.0 && unit != 0.0).then(|| unit / point.stress)
    });
    let ratios: Vec<f64> = ratios.collect();
    if ratios.len() < LEAST_POINTS {
        return f64::INFINITY;
    }
    // The modulus minimizes the sum of (modulus ratio - 1)^2.
    let sum: f64 = ratios.iter().sum();
    let squares: f64 = ratios.iter().map(|own| own * own).sum();
    let modulus = sum / squares;
    let errors = ratios.iter().map(|own| (modulus * own - 1.0).powi(2));
    (errors.sum::<f64>() / ratios.len() as f64).sqrt()
}

/// Row with the largest strain, this strain, and the errors of neo-Hooke's law for strains that are multiplied by a factor and for the strains as given, if
/// the law fits the multiplied strains alone. `None` for other loadings, and for a largest strain outside a range.
fn misread(
    mode: Mode,
    rows: &[(usize, Point)],
    factor: f64,
    range: impl RangeBounds<f64>,
) -> Option<(usize, f64, [f64; 2])> {
    if matches!(mode, Mode::SimpleShear | Mode::Volumetric) {
        return None;
    }
    let (line, point) = rows
        .iter()
        .max_by(|a, b| a.1.stretch.total_cmp(&b.1.stretch))?;
    let strain = point.stretch - 1.0;
    let errors = [factor, 1.0].map(|factor| neo_hooke_error(mode, rows, factor));
    let [multiplied, given] = errors;
    let is_misread = range.contains(&strain)
        && multiplied < FITTING_READING
        && given > OTHER_READING * multiplied.max(FITTING_READING);
    is_misread.then_some((*line, strain, errors))
}

/// First word of a text from a file.
fn brief(text: &str) -> String {
    onset_frames::brief(text)
}

fn is_deck(text: &str) -> bool {
    text.lines().any(|line| {
        let plain: String = line.chars().filter(|own| !own.is_whitespace()).collect();
        plain.to_ascii_uppercase().starts_with('*')
            && plain.to_ascii_uppercase().contains("TESTDATA")
    })
}

/// Returns true if a text has commands of Ansys that add experimental data.
fn is_ansys(text: &str) -> bool {
    text.lines().any(|line| experiment(line).is_some())
}

/// Arguments of a command `TBFT,EADD,material,loading,name,extension,folder`, without the first two.
fn experiment(line: &str) -> Option<Vec<&str>> {
    let command = line.split('!').next().unwrap_or_default();
    let mut words = command.split(',').map(|own| own.trim().trim_matches('\''));
    let is_command = ["TBFT", "EADD"].iter().all(|name| {
        let word = words.next();
        word.is_some_and(|own| own.eq_ignore_ascii_case(name))
    });
    is_command.then(|| words.collect())
}

/// Points with their lines.
type Rows = Vec<(usize, Point)>;

/// Test of a deck, with the name of its material.
type OfMaterial = (Option<String>, Test);

/// Loading named in a text.
pub(super) fn mode_in(text: &str) -> Option<Mode> {
    let plain: String = text
        .to_lowercase()
        .chars()
        .map(|own| if own.is_alphanumeric() { own } else { ' ' })
        .collect();
    let words: Vec<&str> = plain.split_whitespace().collect();
    let has = |word: &str| words.contains(&word);
    if has("simple") && has("shear") || has("simpleshear") {
        Some(Mode::SimpleShear)
    } else if has("equibiaxial") || has("biaxial") || has("equi") {
        Some(Mode::Equibiaxial)
    } else if has("planar") || has("pure") && has("shear") || has("pureshear") {
        Some(Mode::Planar)
    } else if has("volumetric") || has("hydrostatic") {
        Some(Mode::Volumetric)
    } else if has("uniaxial") || has("tension") || has("tensile") || has("compression") {
        Some(Mode::Uniaxial)
    } else {
        None
    }
}

/// Meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    Stretch,
    Strain,
    TrueStrain,
    NominalStress,
    TrueStress,
    Force,
    LateralStretch,
    LateralStrain,
    VolumeRatio,
    Pressure,
    /// Stretches of an array without a column name.
    Array,
}

impl Column {
    /// Column by its name without unit, in small letters with underscores.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "stretch" | "stretch_ratio" | "lambda" | "λ" | "lambda1" => Self::Stretch,
            "strain" | "nominal_strain" | "engineering_strain" | "eng_strain" | "gamma"
            | "shear_strain" | "shear" => Self::Strain,
            "true_strain" | "log_strain" | "logarithmic_strain" | "hencky_strain" => {
                Self::TrueStrain
            }
            "nominal_stress" | "stress" | "engineering_stress" | "eng_stress" | "first_piola"
            | "pk1" | "p" | "p11" | "shear_stress" => Self::NominalStress,
            "true_stress" | "cauchy_stress" | "cauchy" | "sigma" => Self::TrueStress,
            "force" | "load" => Self::Force,
            "lateral_stretch" | "transverse_stretch" | "lateral" | "lambda2" => {
                Self::LateralStretch
            }
            "lateral_strain" | "transverse_strain" => Self::LateralStrain,
            "volume_ratio" | "j" | "jacobian" => Self::VolumeRatio,
            "pressure" => Self::Pressure,
            _ => return None,
        })
    }
}

/// Name of a column without its unit, and the unit in brackets or parentheses.
fn split(header: &str) -> (String, Option<String>) {
    let header = header.trim().trim_matches('"').trim();
    let (name, unit) = match header.split_once(['[', '(']) {
        Some((name, rest)) => (
            name,
            Some(rest.trim_end_matches([']', ')']).trim().to_owned()),
        ),
        None => match header.split_once('/') {
            Some((name, unit)) => (name, Some(unit.trim().to_owned())),
            None => (header, None),
        },
    };
    let plain: String = name
        .trim()
        .to_lowercase()
        .chars()
        .map(|own| if own.is_alphanumeric() { own } else { '_' })
        .collect();
    let unit = unit.filter(|own| !own.is_empty() && own != "-" && own != "1");
    (plain.trim_matches('_').to_owned(), unit)
}

/// Hint for a header without the expected columns.
fn hint_on_names(names: &[String]) -> &'static str {
    let plain: Vec<String> = names.iter().map(|own| split(own).0).collect();
    let has = |words: &[&str]| {
        let parts = plain.iter().flat_map(|own| own.split('_'));
        parts.into_iter().any(|part| words.contains(&part))
    };
    if has(&["displacement", "extension", "elongation"]) {
        "divide the displacement by the gauge length, and name the column strain"
    } else if names.len() < 2 || names.iter().any(|own| own.contains(':')) {
        "begin lines before the header with #"
    } else {
        "rename the columns"
    }
}

/// Columns of programs that write tables without a header.
const ABAQUS: &str = "data lines of Abaqus hold nominal stress and nominal strain";
const ANSYS: &str =
    "files of Ansys hold nominal strain and nominal stress, or volume ratio and pressure";

/// Text of a file, or arrays with an empty text.
struct Table<'a> {
    path: &'a Path,
    row: &'static str,
    /// Lines before the line with the number 0.
    before: usize,
    text: &'a str,
    /// Columns of a table without a header.
    columns: Option<&'static str>,
    reading: &'a Reading,
}

impl Table<'_> {
    fn line(&self, line: usize, message: impl Into<String>, hint: impl Into<String>) -> TableError {
        if line < self.before {
            return self.refused(message, hint);
        }
        TableError::Line {
            path: self.path.to_owned(),
            row: self.row,
            line: line - self.before,
            message: message.into(),
            hint: hint.into(),
        }
    }

    fn refused(&self, message: impl Into<String>, hint: impl Into<String>) -> TableError {
        TableError::File {
            path: self.path.to_owned(),
            message: message.into(),
            hint: hint.into(),
        }
    }

    /// Loading given by the option, by a comment in the file, or by the file name.
    fn mode(&self, given: Option<Mode>) -> Result<Mode, TableError> {
        let comments = self.text.lines().map(str::trim_start).enumerate();
        let mut comments = comments
            .take_while(|(_, line)| line.starts_with('#') || line.is_empty())
            .filter_map(|(n, line)| {
                let text = line.trim_start_matches('#').trim().strip_prefix("mode:");
                Some((n + 1, text?.trim()))
            });
        let comment = match comments.next() {
            Some((line, text)) if given.is_none() && mode_in(text).is_none() => {
                return Err(self.line(
                    line,
                    format!(
                        "the comment names the loading `{}`, which is not known",
                        brief(text)
                    ),
                    "expected uniaxial, equibiaxial, planar, simple shear or volumetric",
                ));
            }
            own => own.and_then(|(_, text)| mode_in(text)),
        };
        let name = self
            .path
            .file_stem()
            .and_then(|stem| mode_in(&stem.to_string_lossy()));
        if let (Some(given), Some(comment)) = (given, comment)
            && given != comment
        {
            return Err(self.refused(
                format!(
                    "the comment gives the loading {}, the option {}",
                    comment.name(),
                    given.name()
                ),
                "correct the comment or the option",
            ));
        }
        if let (None, Some(comment), Some(name)) = (given, comment, name)
            && comment != name
        {
            return Err(self.refused(
                format!(
                    "the comment gives the loading {}, the file name {}",
                    comment.name(),
                    name.name()
                ),
                format!("name the loading, for example --{} FILE", comment.name()),
            ));
        }
        given.or(comment).or(name).ok_or_else(|| {
            self.refused(
                "the loading is not known: neither the file name nor a comment `# mode: planar` gives it",
                "use --uniaxial, --equibiaxial, --planar, --simple-shear or --volumetric FILE",
            )
        })
    }

    /// Test of a table with a header, the unit of its stresses and the meaning of their column.
    fn csv(
        &self,
        given: Option<Mode>,
        notes: &mut Vec<String>,
    ) -> Result<(Test, Option<String>, Column), TableError> {
        if let Some((n, text)) = (self.text.lines().enumerate())
            .find(|(_, text)| text.starts_with('*') && !text.starts_with("**"))
        {
            return Err(self.line(
                n + 1,
                format!("`{}` is a keyword of an input deck, which contains no test data", brief(text)),
                "expected *UNIAXIAL, *BIAXIAL, *PLANAR, *SIMPLE SHEAR or *VOLUMETRIC TEST DATA, or a table with a header",
            ));
        }
        let mode = self.mode(given)?;
        let lines = self
            .text
            .lines()
            .enumerate()
            .map(|(n, line)| (n + 1, line.trim()));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let Some((at, header)) = lines.next() else {
            return Err(self.refused("it has no rows", "expected a header and rows of numbers"));
        };
        let delimiter = [';', '\t', ',']
            .into_iter()
            .find(|own| header.contains(*own));
        let cells = |line: &str| -> Vec<String> {
            match delimiter {
                Some(own) => line.split(own).map(|cell| cell.trim().to_owned()).collect(),
                None => line.split_whitespace().map(str::to_owned).collect(),
            }
        };
        let names = cells(header);
        if names
            .iter()
            .all(|own| own.replace(',', ".").parse::<f64>().is_ok())
        {
            return Err(self.line(
                at,
                "numbers where the names of the columns were expected",
                "add a header, for example stretch,nominal_stress [MPa]",
            ));
        }
        let mut columns: Vec<Option<(Column, Option<String>)>> = Vec::new();
        for name in &names {
            let (plain, unit) = split(name);
            let column = Column::named(&plain);
            if column.is_none() {
                notes.push(format!(
                    "{}: the column `{name}` is ignored",
                    self.path.display()
                ));
            }
            columns.push(column.map(|column| (column, unit)));
        }
        for (n, own) in columns.iter().enumerate() {
            let own = own.as_ref().map(|(column, _)| *column);
            let same = columns[..n]
                .iter()
                .flatten()
                .any(|(column, _)| Some(*column) == own);
            if own.is_some() && same {
                return Err(self.line(
                    at,
                    format!("two columns mean `{}`", onset_frames::cut(&names[n])),
                    "keep one of them",
                ));
            }
        }
        let find = |wanted: &[Column]| {
            wanted.iter().find_map(|wanted| {
                let place = columns
                    .iter()
                    .position(|own| own.as_ref().is_some_and(|(own, _)| own == wanted))?;
                Some((
                    *wanted,
                    place,
                    columns[place].as_ref().and_then(|(_, unit)| unit.clone()),
                ))
            })
        };
        let (along, across, stress) = match mode {
            Mode::Volumetric => (
                find(&[Column::VolumeRatio, Column::Stretch]),
                None,
                find(&[Column::Pressure, Column::NominalStress, Column::TrueStress]),
            ),
            _ => (
                find(&[Column::Stretch, Column::Strain, Column::TrueStrain]),
                find(&[Column::LateralStretch, Column::LateralStrain]),
                find(&[Column::NominalStress, Column::TrueStress, Column::Force]),
            ),
        };
        let expected = match mode {
            Mode::Volumetric => "expected volume_ratio and pressure",
            Mode::SimpleShear => "expected gamma and shear_stress",
            _ => "expected stretch or strain, and nominal_stress, true_stress or force",
        };
        let (Some(along), Some(stress)) = (along, stress) else {
            return Err(self.line(
                at,
                format!(
                    "the header has {} (`{}`); {expected}",
                    counted(names.len(), "column"),
                    names
                        .iter()
                        .map(|own| onset_frames::cut(own))
                        .collect::<Vec<_>>()
                        .join("`, `")
                ),
                hint_on_names(&names),
            ));
        };
        if mode == Mode::SimpleShear && along.0 != Column::Strain {
            return Err(self.line(
                at,
                "a simple shear test needs the amount of shear",
                "name its column gamma",
            ));
        }
        let percent = |unit: &Option<String>| unit.as_deref() == Some("%");
        for (column, place, unit) in [Some(&along), across.as_ref()].into_iter().flatten() {
            let known = matches!(
                unit.as_deref(),
                None | Some("%" | "mm/mm" | "m/m" | "in/in")
            );
            if !known || percent(unit) && matches!(column, Column::Stretch | Column::LateralStretch)
            {
                return Err(self.line(
                    at,
                    format!(
                        "the column `{}` has the unit {}",
                        onset_frames::cut(&names[*place]),
                        brief(unit.as_deref().unwrap_or_default())
                    ),
                    "stretches have no unit; strains have no unit, or %",
                ));
            }
        }
        let mut in_newtons = 1.0;
        if let (Column::Force, Some(unit)) = (stress.0, &stress.2) {
            if stress_unit(unit).is_some() {
                return Err(self.line(
                    at,
                    format!(
                        "the column `{}` has the unit of a stress",
                        onset_frames::cut(&names[stress.1])
                    ),
                    "name it nominal_stress, or correct the unit",
                ));
            }
            let Some(factor) = value_of("force", unit) else {
                return Err(self.line(
                    at,
                    format!("the unit of force `{}` is not known", brief(unit)),
                    format!("expected {}", names_of("force")),
                ));
            };
            if let Some(asked) = self
                .reading
                .unit
                .as_ref()
                .filter(|own| !["MPa", "Pa", "N/mm^2", "N/m^2"].contains(&own.as_str()))
            {
                return Err(self.line(
                    at,
                    format!("forces in {} do not give stresses in {}", brief(unit), brief(asked)),
                    "forces are converted to N: name MPa for an area in mm^2, or Pa for an area in m^2",
                ));
            }
            in_newtons = factor;
            if self.reading.unit.is_none() {
                notes.push(format!(
                    "{}: forces are converted to N, so that the stresses are in N per unit of the area (MPa for mm^2)",
                    self.path.display()
                ));
            }
        }
        notes.extend(self.open_names(mode, &names[along.1], &names[stress.1]));
        if stress.0 == Column::Force && self.reading.area.is_none() {
            return Err(self.line(
                at,
                "forces are given without the area of the cross-section",
                "give the undeformed area of the specimen",
            ));
        }
        if let (false, Some(unit)) = (stress.0 == Column::Force, &stress.2)
            && stress_unit(unit).is_none()
        {
            return Err(self.line(
                at,
                format!("the unit of stress `{}` is not known", brief(unit)),
                format!("expected {}", names_of("stress")),
            ));
        }
        // Redundant columns: the stretch given a second time as strain or true strain.
        let twins: Vec<(Column, usize, Option<String>)> = columns
            .iter()
            .enumerate()
            .filter_map(|(n, own)| {
                let (column, unit) = own.as_ref()?;
                Some((*column, n, unit.clone()))
            })
            .filter(|(column, n, _)| {
                use Column::{Strain, Stretch, TrueStrain};
                let is_length = |own| matches!(own, Stretch | Strain | TrueStrain);
                *n != along.1 && is_length(*column) && is_length(along.0)
            })
            .collect();
        for (own, used) in [(Column::TrueStress, &stress), (Column::Force, &stress)] {
            let is_there = columns.iter().flatten().any(|(column, _)| *column == own);
            if is_there && used.0 != own {
                notes.push(format!(
                    "{}: the stresses are read from the column `{}`",
                    self.path.display(),
                    onset_frames::cut(&names[used.1])
                ));
                break;
            }
        }
        let decimal_comma = delimiter != Some(',');
        let mut rows: Vec<(usize, Point)> = Vec::new();
        for (line, text) in lines {
            let cells = cells(text);
            if cells.len() != names.len() {
                return Err(self.line(
                    line,
                    format!(
                        "the row has {} where the header has {}",
                        counted(cells.len(), "cell"),
                        names.len()
                    ),
                    match delimiter {
                        Some(',') if cells.len() == 2 * names.len() => {
                            "write decimal points, or separate the columns by semicolons"
                        }
                        _ => "each row has a number for every column",
                    },
                ));
            }
            let number = |place: usize| -> Result<f64, TableError> {
                let unquoted = |own: &str| own.trim_matches(['"', '\'']).trim().to_owned();
                let cell = match decimal_comma {
                    true => unquoted(&cells[place]).replace(',', "."),
                    false => unquoted(&cells[place]),
                };
                let value = cell.parse::<f64>().ok().filter(|own| own.is_finite());
                value.ok_or_else(|| {
                    let what = match cell.is_empty() {
                        true => "a cell".to_owned(),
                        false => format!("`{}`", brief(&cell)),
                    };
                    let is_units = line == at + 1 && cell.parse::<f64>().is_err();
                    let fault = match cell.is_empty() {
                        true => "is empty",
                        false => "is not a finite number",
                    };
                    self.line(
                        line,
                        format!(
                            "{what} of the column `{}` {fault}",
                            onset_frames::cut(&names[place])
                        ),
                        match is_units && !cell.is_empty() {
                            true => "write numbers such as 1.25 or 3e-2, and units into the header, for example strain [%]",
                            false => "write numbers such as 1.25 or 3e-2",
                        },
                    )
                })
            };
            let length = |own: &(Column, usize, Option<String>)| -> Result<f64, TableError> {
                let value = number(own.1)? * if percent(&own.2) { 0.01 } else { 1.0 };
                Ok(match own.0 {
                    Column::Strain | Column::LateralStrain if mode != Mode::SimpleShear => {
                        1.0 + value
                    }
                    Column::TrueStrain => value.exp(),
                    _ => value,
                })
            };
            let stretch = length(&along)?;
            for twin in &twins {
                let other = length(twin)?;
                if (other - stretch).abs() > STRETCH_TOLERANCE * stretch.abs().max(1.0) {
                    return Err(self.line(
                        line,
                        format!(
                            "the columns `{}` and `{}` contradict each other",
                            onset_frames::cut(&names[along.1]),
                            onset_frames::cut(&names[twin.1])
                        ),
                        "keep one of them",
                    ));
                }
            }
            let lateral = across.as_ref().map(&length).transpose()?;
            let value = number(stress.1)?;
            self.check_stretch(line, mode, stretch, lateral, along.0)?;
            let value = match stress.0 {
                Column::Force => value * in_newtons / self.reading.area.unwrap_or(1.0),
                // Nominal stress is true stress times the area ratio, the volume ratio over the stretch.
                Column::TrueStress if !matches!(mode, Mode::Volumetric | Mode::SimpleShear) => {
                    let volume = match (mode, lateral) {
                        (_, None) => 1.0,
                        (Mode::Uniaxial, Some(lateral)) => stretch * lateral * lateral,
                        (Mode::Equibiaxial, Some(lateral)) => stretch * stretch * lateral,
                        (_, Some(lateral)) => stretch * lateral,
                    };
                    value * volume / stretch
                }
                _ => value,
            };
            rows.push((
                line,
                Point {
                    stretch,
                    lateral,
                    stress: value,
                },
            ));
        }
        let unit = match stress.0 {
            Column::Force => None,
            _ => stress.2,
        };
        if percent(&along.2) {
            self.check_fractions(mode, &rows)?;
        }
        Ok((self.test(mode, rows, along.0)?, unit, stress.0))
    }

    /// Test given by arrays, whose lengths and numbers are checked.
    fn arrays(&self, own: &Arrays) -> Result<Test, TableError> {
        let lengths = [Some(&own.stress), own.lateral.as_ref()];
        if let Some(other) = lengths
            .into_iter()
            .flatten()
            .find(|other| other.len() != own.stretch.len())
        {
            return Err(self.refused(
                format!(
                    "the arrays have {} and {} numbers",
                    own.stretch.len(),
                    other.len()
                ),
                "give a stretch and a nominal stress for each point",
            ));
        }
        if own.mode == Mode::Volumetric && own.lateral.is_some() {
            return Err(self.refused(
                "a volumetric test has no lateral stretch",
                "give ratios of volumes and pressures",
            ));
        }
        let mut rows = Vec::new();
        for (n, (stretch, stress)) in own.stretch.iter().zip(&own.stress).enumerate() {
            let lateral = own.lateral.as_ref().map(|lateral| lateral[n]);
            let mut all = [Some(*stretch), Some(*stress), lateral]
                .into_iter()
                .flatten();
            if let Some(value) = all.find(|value| !value.is_finite()) {
                return Err(self.line(
                    n,
                    format!("the value {value} is not a finite number"),
                    "omit points that were not measured",
                ));
            }
            self.check_stretch(n, own.mode, *stretch, lateral, Column::Array)?;
            let point = Point {
                stretch: *stretch,
                lateral,
                stress: *stress,
            };
            rows.push((n, point));
        }
        self.test(own.mode, rows, Column::Array)
    }

    /// Test from rows whose signs and order are checked, without the points in the reference configuration.
    fn test(
        &self,
        mode: Mode,
        rows: Vec<(usize, Point)>,
        column: Column,
    ) -> Result<Test, TableError> {
        self.check_rows(mode, &rows, column)?;
        let rest = if mode == Mode::SimpleShear { 0.0 } else { 1.0 };
        let points = rows.into_iter().map(|(_, point)| point);
        Ok(Test {
            name: mode.name().to_owned(),
            mode,
            points: points.filter(|point| point.stretch != rest).collect(),
            weight: 1.0,
        })
    }

    /// Tests of the chosen material, or of the only material.
    fn of_material(
        &self,
        tests: Vec<OfMaterial>,
    ) -> Result<Vec<(Test, Option<String>)>, TableError> {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in &tests {
            let name = name.as_deref().unwrap_or("(without a name)");
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let has_name = |name: &Option<String>, wanted: &str| {
            name.as_ref()
                .is_some_and(|own| own.eq_ignore_ascii_case(wanted))
        };
        let wanted = self.reading.material.as_deref();
        let message = match wanted {
            None if names.len() > 1 => {
                format!(
                    "the deck has tests of {} materials: {}",
                    names.len(),
                    names.join(", ")
                )
            }
            Some(wanted) if !tests.iter().any(|(name, _)| has_name(name, wanted)) => format!(
                "the deck has no tests of the material `{wanted}`; its tests belong to {}",
                names.join(", ")
            ),
            _ => {
                let own = tests
                    .into_iter()
                    .filter(|(name, _)| wanted.is_none_or(|wanted| has_name(name, wanted)));
                return Ok(own.map(|(_, test)| (test, None)).collect());
            }
        };
        Err(self.refused(message, "choose one of them with --material"))
    }

    /// Note on a stress whose column does not name the area, or a strain whose column does not name the length. Errors of fits do not show it.
    fn open_names(&self, mode: Mode, along: &str, stress: &str) -> Option<String> {
        if matches!(mode, Mode::SimpleShear | Mode::Volumetric) {
            return None;
        }
        let (along, stress) = (split(along).0, split(stress).0);
        let read = match (stress.as_str(), along.as_str()) {
            ("stress", _) => {
                "`stress` is read as nominal stress; if it refers to the deformed area, name it true_stress"
            }
            ("sigma", _) => {
                "`sigma` is read as true stress; if it refers to the undeformed area, name it nominal_stress"
            }
            ("true_stress" | "cauchy_stress" | "cauchy", "strain") => {
                "`strain` is read as nominal strain, with a true stress; if it is logarithmic, name it true_strain"
            }
            _ => return None,
        };
        Some(format!("{}: {read}", self.path.display()))
    }

    /// Note on rows with the stretch of the row before, which count twice.
    fn repeated(&self, test: &Test) -> Option<String> {
        let pairs = test.points.windows(2);
        let changes: Vec<f64> = pairs
            .filter(|pair| pair[0].stretch == pair[1].stretch)
            .map(|pair| (pair[1].stress - pair[0].stress).abs())
            .collect();
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let most = largest(&mut changes.iter().copied());
        let scale = largest(&mut test.points.iter().map(|own| own.stress.abs()));
        (!changes.is_empty()).then(|| {
            format!(
                "{}: {} the stretch of the row before, with {}; every row counts",
                self.path.display(),
                match changes.len() {
                    1 => "1 row repeats".to_owned(),
                    count => format!("{count} rows repeat"),
                },
                match most {
                    0.0 => "the same stress".to_owned(),
                    most => format!(
                        "stresses that differ by up to {} % of the largest",
                        told_with(100.0 * most / scale, 2)
                    ),
                }
            )
        })
    }

    /// Note on stresses that decrease with the strain from the first point on.
    fn decreasing(&self, test: &Test) -> Option<String> {
        let rest = if test.mode == Mode::SimpleShear {
            0.0
        } else {
            1.0
        };
        let mut tension: Vec<&Point> = test
            .points
            .iter()
            .filter(|own| own.stretch > rest)
            .collect();
        tension.sort_by(|a, b| a.stretch.total_cmp(&b.stretch));
        let falls = tension
            .windows(2)
            .filter(|pair| pair[1].stress < pair[0].stress);
        let count = falls.count();
        (tension.len() >= LEAST_POINTS && count + 1 == tension.len()).then(|| {
            format!(
                "{}: the stress decreases with the strain from the first point on; check the order of the stresses",
                self.path.display()
            )
        })
    }

    /// Note on strains and stresses of a compression test that are given as positive numbers.
    fn compressed(&self, test: &Test) -> Option<String> {
        if !Mode::LOADINGS.contains(&test.mode)
            || test
                .points
                .iter()
                .any(|own| own.stretch < 1.0 || own.stretch >= 2.0)
        {
            return None;
        }
        let rows: Vec<(usize, Point)> = test.points.iter().map(|own| (0, *own)).collect();
        let [given, compressed] =
            [1.0, -1.0].map(|factor| neo_hooke_error(test.mode, &rows, factor));
        let is_named = self
            .path
            .file_stem()
            .is_some_and(|own| own.to_string_lossy().to_lowercase().contains("compress"));
        let is_misread = compressed < FITTING_COMPRESSION
            && given > OTHER_READING * compressed.max(FITTING_READING);
        (is_named || is_misread).then(|| {
            format!(
                "{}: was the specimen compressed? All strains and stresses are positive, which means tension, and neo-Hooke's law fits them within {} % as compression, and within {} % as given; give strains and stresses of compression as negative numbers",
                self.path.display(),
                told_with(100.0 * compressed, 2),
                told_with(100.0 * given, 2)
            )
        })
    }

    /// Note on stresses that do not vanish without strain, by the line through the points with the smallest strains.
    fn offset(&self, test: &Test) -> Option<String> {
        let rest = match test.mode {
            Mode::Volumetric => return None,
            Mode::SimpleShear => 0.0,
            _ => 1.0,
        };
        let mut near: Vec<(f64, f64)> = test
            .points
            .iter()
            .map(|own| (own.stretch - rest, own.stress))
            .filter(|(strain, _)| (0.0..SMALL_STRAIN).contains(strain))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.dedup_by_key(|own| own.0);
        let [(x, y), (u, v), ..] = near.as_slice() else {
            return None;
        };
        // The slope between the first points falls with the strain, so that the true stress without strain is below this value.
        let slope = (v - y) / (u - x);
        let zero = y - slope * x;
        (slope > 0.0 && zero > OFFSET_PART * y).then(|| {
            format!(
                "{}: the stresses near zero strain lead to {} without strain, {} % of the first stress; check the zero point",
                self.path.display(),
                told_with(zero, 2),
                told_with(100.0 * zero / y, 2)
            )
        })
    }

    fn check_stretch(
        &self,
        line: usize,
        mode: Mode,
        stretch: f64,
        lateral: Option<f64>,
        column: Column,
    ) -> Result<(), TableError> {
        let (what, percents) = match (mode, self.columns) {
            (Mode::SimpleShear, _) => (
                "amount of shear",
                "if they are percentages, name the column gamma [%]".to_owned(),
            ),
            (Mode::Volumetric, _) => (
                "volume ratio",
                "a volume ratio is the deformed volume divided by the undeformed volume, near 1"
                    .to_owned(),
            ),
            (_, Some(columns)) => ("stretch", format!("{columns}, not percentages")),
            (_, None) => (
                "stretch",
                "if the strains are percentages, name the column strain [%]".to_owned(),
            ),
        };
        if mode == Mode::SimpleShear {
            return match stretch.abs() > LARGEST_SHEAR {
                true => Err(self.line(
                    line,
                    format!(
                        "the {what} is {}; the largest accepted value is {LARGEST_SHEAR}",
                        told(stretch)
                    ),
                    percents,
                )),
                false => Ok(()),
            };
        }
        if let Some(own) = [Some(stretch), lateral]
            .into_iter()
            .flatten()
            .find(|own| *own <= 0.0)
        {
            return Err(self.line(
                line,
                format!(
                    "the {what} is {}; it is a ratio and must be positive",
                    told(own)
                ),
                match column {
                    Column::Array => STRETCHES.to_owned(),
                    Column::Stretch => "if the column holds strains, name it strain".to_owned(),
                    _ => percents,
                },
            ));
        }
        if stretch > LARGEST {
            return Err(self.line(
                line,
                format!(
                    "the {what} is {}; the largest accepted value is {LARGEST}",
                    told(stretch)
                ),
                match column {
                    Column::Array => STRETCHES.to_owned(),
                    _ => percents,
                },
            ));
        }
        Ok(())
    }

    /// Checks the signs and the order of the rows.
    fn check_rows(
        &self,
        mode: Mode,
        rows: &[(usize, Point)],
        column: Column,
    ) -> Result<(), TableError> {
        let rest = if mode == Mode::SimpleShear { 0.0 } else { 1.0 };
        let sign = if mode == Mode::Volumetric { -1.0 } else { 1.0 };
        let is_wrong = |own: &&(usize, Point)| sign * (own.1.stretch - rest) * own.1.stress < 0.0;
        let wrong: Vec<&(usize, Point)> = rows.iter().filter(is_wrong).collect();
        if let Some((line, point)) = wrong.first() {
            let (what, hint) = match (mode, column, wrong.len() == rows.len()) {
                (Mode::Volumetric, _, _) => (
                    "pressure and change of volume",
                    "pressures are positive in compression",
                ),
                (_, Column::Array, _) if point.stretch < 1.0 => ("stress and stretch", STRETCHES),
                (_, Column::Stretch, _) if point.stretch < 1.0 => (
                    "stress and stretch",
                    "if the column holds strains, name it strain; stresses are positive in tension",
                ),
                (_, _, true) => (
                    "stress and strain",
                    "stresses and strains are positive in tension",
                ),
                _ => (
                    "stress and strain",
                    "remove the offset of the zero point, so that the stress is 0 without strain",
                ),
            };
            return Err(self.line(
                *line,
                format!(
                    "{what} have different signs: {} at the {} {}",
                    told(point.stress),
                    match mode {
                        Mode::SimpleShear => "amount of shear",
                        Mode::Volumetric => "volume ratio",
                        _ => "stretch",
                    },
                    told(point.stretch)
                ),
                hint,
            ));
        }
        if mode == Mode::Volumetric
            && let Some((line, point)) = rows.first()
            && rows.iter().all(|own| own.1.stretch < LEAST_VOLUME)
        {
            return Err(self.line(
                *line,
                format!("the volume ratio is {}", told(point.stretch)),
                "a volume ratio is near 1; if the column holds relative changes of volume 1 - J, replace them by J",
            ));
        }
        let largest = rows
            .iter()
            .fold(0.0_f64, |most, own| most.max(own.1.stress.abs()));
        let strain = |own: &Point| own.stretch - rest;
        if let Some((line, _)) = rows.iter().find(|(_, own)| {
            strain(own) == 0.0 && own.stress.abs() > 0.05 * largest && mode != Mode::Volumetric
        }) {
            return Err(self.line(
                *line,
                "the stress without strain is more than 5 % of the largest one",
                "remove the offset of the zero point",
            ));
        }
        if let Some((line, _)) = rows.first()
            && !(STRESSES[0]..=STRESSES[1]).contains(&largest)
        {
            return Err(self.line(
                *line,
                format!("the largest stress of the table is {}", told(largest)),
                "expected stresses from 1e-20 to 1e20; choose another unit",
            ));
        }
        let strains = rows.iter().map(|own| strain(&own.1).abs());
        let most = strains.clone().fold(0.0, f64::max);
        if let Some((line, _)) = rows.first()
            && most > 0.0
            && most < LEAST_STRAIN
            && mode != Mode::Volumetric
        {
            return Err(self.line(
                *line,
                format!("the largest strain of the table is {}", told(most)),
                "if the strains are not percentages, remove [%] from the name of the column",
            ));
        }
        if let Some((line, point)) = rows.iter().find(|own| strain(&own.1) != 0.0)
            && column == Column::Strain
            && strains
                .filter(|own| *own > 0.0)
                .fold(f64::INFINITY, f64::min)
                >= 1.0
        {
            return Err(self.line(
                *line,
                format!(
                    "the strains begin with {}, without any below 1",
                    told(strain(point))
                ),
                match (self.columns, mode) {
                    (Some(columns), _) => format!("{columns}, not percentages or stretches"),
                    (_, Mode::SimpleShear) => "if they are percentages, name the column gamma [%]; otherwise add points of small strains".to_owned(),
                    _ => "if they are percentages, name the column strain [%], and if they are stretches, stretch; otherwise give stretches".to_owned(),
                },
            ));
        }
        self.check_percent(mode, rows, column)?;
        if let Some((line, _)) = rows
            .iter()
            .find(|own| own.1.stress == 0.0 && own.1.stretch != rest)
        {
            return Err(self.line(
                *line,
                "the stress is 0 at a nonzero strain",
                "remove the row, or the offset of the zero point",
            ));
        }
        let secants = rows.windows(2).map(|pair| {
            let secant = |own: &(usize, Point)| (own.1.stress / strain(&own.1)).abs();
            (pair[1].0, secant(&pair[1]) / secant(&pair[0]))
        });
        let is_jump = |ratio: f64| !(LARGEST_JUMP.recip()..=LARGEST_JUMP).contains(&ratio);
        if let Some((line, ratio)) = secants
            .filter(|(_, ratio)| ratio.is_finite() && *ratio > 0.0)
            .find(|(_, ratio)| is_jump(*ratio))
        {
            return Err(self.line(
                line,
                format!(
                    "the stress divided by the strain changes by the factor {} from the row before",
                    told(ratio)
                ),
                "check the units of the rows, and remove rows that were not measured correctly",
            ));
        }
        // Tension and compression may follow each other; within each, the strain grows or falls.
        let turns_of = |side: f64| {
            let own: Vec<&(usize, Point)> = rows
                .iter()
                .filter(|own| strain(&own.1) * side >= 0.0)
                .collect();
            let steps = own
                .windows(2)
                .map(|pair| (pair[1].0, pair[1].1.stretch - pair[0].1.stretch));
            let steps: Vec<(usize, f64)> = steps.filter(|(_, step)| *step != 0.0).collect();
            let turns = steps
                .windows(2)
                .filter(|pair| pair[0].1 * pair[1].1 < 0.0)
                .map(|pair| pair[1].0);
            turns.collect::<Vec<_>>()
        };
        let mut turns = turns_of(1.0);
        turns.extend(turns_of(-1.0));
        turns.sort_unstable();
        match turns.as_slice() {
            [] => Ok(()),
            [line] => Err(self.line(
                *line,
                "the stretch reverses: loading is followed by unloading",
                "keep one branch of the test; an elastic law has a single stress for each stretch",
            )),
            [line, ..] => Err(self.line(
                *line,
                format!(
                    "the rows are not sorted by stretch: the stretch reverses {} times",
                    turns.len()
                ),
                "sort the rows; of a cyclic test keep one branch",
            )),
        }
    }

    /// Refuses strains that are percentages: neo-Hooke's law fits their hundredth parts, and not the strains.
    ///
    /// Read as strains, such rows reach at least 100 %, and the stress is nearly linear in them, because the specimen was stretched by a few percent.
    fn check_percent(
        &self,
        mode: Mode,
        rows: &[(usize, Point)],
        column: Column,
    ) -> Result<(), TableError> {
        let is_strain = column == Column::Strain;
        let misread = is_strain.then(|| misread(mode, rows, 0.01, LEAST_PERCENT..));
        match misread.flatten() {
            Some((line, strain, [as_percentages, as_strains])) => Err(self.line(
                line,
                format!(
                    "the strain is {}, but the stresses belong to strains of at most {} %: neo-Hooke's law fits them within {} %, and the strains as given within {} %",
                    told(strain),
                    told(strain),
                    told_with(100.0 * as_percentages, 2),
                    told_with(100.0 * as_strains, 2)
                ),
                match self.columns {
                    Some(columns) => format!("{columns}, not percentages"),
                    None => "if they are percentages, name the column strain [%]; otherwise name it stretch, and give stretches".to_owned(),
                },
            )),
            None => Ok(()),
        }
    }

    /// Refuses fractions in a column of percentages: neo-Hooke's law fits a hundred times the strains, and not the strains.
    fn check_fractions(&self, mode: Mode, rows: &[(usize, Point)]) -> Result<(), TableError> {
        match misread(mode, rows, 100.0, 0.0..MOST_FRACTION) {
            Some((line, strain, [as_fractions, as_given])) => Err(self.line(
                line,
                format!(
                    "the strain is {} %, but the stresses belong to a strain of {}: neo-Hooke's law fits them within {} %, and the percentages within {} %",
                    told(100.0 * strain),
                    told(100.0 * strain),
                    told_with(100.0 * as_fractions, 2),
                    told_with(100.0 * as_given, 2)
                ),
                "if the strains are not percentages, remove [%] from the name of the column",
            )),
            None => Ok(()),
        }
    }

    /// Test data of a deck of Abaqus: nominal stress, nominal strain and lateral strain; pressure and volume ratio.
    fn deck(&self) -> Result<Vec<OfMaterial>, TableError> {
        let mut found: Vec<(Option<String>, Mode, Rows)> = Vec::new();
        let mut is_open = false;
        let mut material = None;
        for (n, text) in self.text.lines().enumerate() {
            let (line, text) = (n + 1, text.trim());
            if text.is_empty() || text.starts_with("**") {
                continue;
            }
            if text.starts_with('*') {
                let mut fields = fields_of_keyword(text);
                let keyword = fields.next().unwrap_or_default();
                let plain: String = keyword.chars().filter(|own| !own.is_whitespace()).collect();
                if plain.eq_ignore_ascii_case("*MATERIAL") {
                    let name = fields.find_map(|own| {
                        let (key, name) = own.split_once('=')?;
                        let name = name.trim().trim_matches('"').to_owned();
                        key.trim().eq_ignore_ascii_case("NAME").then_some(name)
                    });
                    material = name;
                }
                let mode = match plain.to_ascii_uppercase().as_str() {
                    "*UNIAXIALTESTDATA" => Some(Mode::Uniaxial),
                    "*BIAXIALTESTDATA" => Some(Mode::Equibiaxial),
                    "*PLANARTESTDATA" => Some(Mode::Planar),
                    "*SIMPLESHEARTESTDATA" => Some(Mode::SimpleShear),
                    "*VOLUMETRICTESTDATA" => Some(Mode::Volumetric),
                    _ => None,
                };
                is_open = mode.is_some();
                found.extend(mode.map(|mode| (material.clone(), mode, Vec::new())));
                continue;
            }
            let Some((_, mode, rows)) = found.last_mut().filter(|_| is_open) else {
                continue;
            };
            let cells = text.split(',').map(str::trim).filter(|own| !own.is_empty());
            let values: Option<Vec<f64>> = cells
                .map(|own| own.parse::<f64>().ok().filter(|own| own.is_finite()))
                .collect();
            let Some(values) = values.filter(|own| own.len() >= 2) else {
                return Err(self.line(
                    line,
                    format!(
                        "`{}` where a stress and a strain were expected",
                        brief(text)
                    ),
                    "data lines of Abaqus hold nominal stress, nominal strain and lateral strain",
                ));
            };
            let stretch = match mode {
                Mode::SimpleShear | Mode::Volumetric => values[1],
                _ => 1.0 + values[1],
            };
            let lateral = match mode {
                Mode::SimpleShear | Mode::Volumetric => None,
                _ => values.get(2).map(|own| 1.0 + own),
            };
            self.check_stretch(line, *mode, stretch, lateral, Column::Strain)?;
            rows.push((
                line,
                Point {
                    stretch,
                    lateral,
                    stress: values[0],
                },
            ));
        }
        let tests = found
            .into_iter()
            .map(|(material, mode, rows)| Ok((material, self.test(mode, rows, Column::Strain)?)));
        tests.collect()
    }

    /// Experimental data of Ansys: files that `TBFT,EADD` names, with nominal strain and nominal stress, or volume ratio and pressure.
    fn ansys(&self) -> Result<Vec<OfMaterial>, TableError> {
        let mut tests = Vec::new();
        for (n, line) in self.text.lines().enumerate() {
            let Some(words) = experiment(line) else {
                continue;
            };
            let word = |place: usize, default: &str| -> String {
                let own = words.get(place).copied().filter(|own| !own.is_empty());
                own.unwrap_or(default).to_owned()
            };
            let mode = match word(1, "UNIA").to_ascii_uppercase().as_str() {
                "UNIA" => Mode::Uniaxial,
                "BIAX" => Mode::Equibiaxial,
                "SHEA" => Mode::Planar,
                "SSHE" => Mode::SimpleShear,
                "VOLU" => Mode::Volumetric,
                other => {
                    return Err(self.line(
                        n + 1,
                        format!("the loading `{}` is not known", brief(other)),
                        "expected UNIA, BIAX, SHEA, SSHE or VOLU",
                    ));
                }
            };
            let mut name = word(2, "");
            if let Some(extension) = words.get(3).filter(|own| !own.is_empty()) {
                name = format!("{name}.{}", extension.trim_start_matches('.'));
            }
            if name.is_empty() {
                return Err(self.line(
                    n + 1,
                    "the command names no file",
                    "expected TBFT,EADD,material,UNIA,file",
                ));
            }
            // Decks written on Windows have backslashes.
            let local = |text: &str| text.replace('\\', "/");
            let folder = self.path.parent().unwrap_or(Path::new(""));
            let path = folder.join(local(&word(4, ""))).join(local(&name));
            let text = input::text(&path, MOST_TEXT).map_err(|error| {
                self.line(
                    n + 1,
                    format!("the file {} cannot be read: {error}", path.display()),
                    "put the file into the folder of the deck, or correct its name",
                )
            })?;
            let own = Table {
                path: &path,
                row: "line",
                before: 0,
                text: &text,
                columns: Some(ANSYS),
                reading: self.reading,
            };
            tests.push((Some(word(0, "1")), own.experiment(mode)?));
        }
        Ok(tests)
    }

    /// Rows of a file of experimental data of Ansys.
    fn experiment(&self, mode: Mode) -> Result<Test, TableError> {
        let mut rows = Vec::new();
        for (n, text) in self.text.lines().enumerate() {
            let text = text.split('!').next().unwrap_or_default().trim();
            if text.is_empty() {
                continue;
            }
            let cells = text
                .split([',', ';', ' ', '\t'])
                .filter(|own| !own.is_empty());
            let values: Option<Vec<f64>> = cells
                .map(|own| own.parse::<f64>().ok().filter(|own| own.is_finite()))
                .collect();
            let Some([strain, stress]) = values.and_then(|own| <[f64; 2]>::try_from(own).ok())
            else {
                return Err(self.line(
                    n + 1,
                    format!(
                        "`{}` where a strain and a stress were expected",
                        brief(text)
                    ),
                    ANSYS,
                ));
            };
            let stretch = match mode {
                Mode::SimpleShear | Mode::Volumetric => strain,
                _ => 1.0 + strain,
            };
            self.check_stretch(n + 1, mode, stretch, None, Column::Strain)?;
            let point = Point {
                stretch,
                lateral: None,
                stress,
            };
            rows.push((n + 1, point));
        }
        self.test(mode, rows, Column::Strain)
    }
}
