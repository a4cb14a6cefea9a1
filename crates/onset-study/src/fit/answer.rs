//! Answer of a fit: errors, cost of the stability constraint, constants, and ranking of laws.

use super::{FittingError, Tests, assignments, volumetric_misfit};
use crate::brief::{Brief, Short};
use crate::csv::Table;
use crate::json;
use crate::number::{counted, told, told_with};
use crate::output::{Files, picture, text};
use crate::settings::{Program, Units, WriteError, law_written};
use crate::shell::quoted;
use onset_fit::{Criterion, Fit, Misfit, Mode, Model, Options, Point, Proof, Range, Test, Weights};
use serde::Serialize;
use std::fmt::{self, Write};

/// Test with the extent of its data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TestAnswer {
    /// Name of the test.
    pub name: String,
    /// Loading of the specimen.
    pub mode: Mode,
    /// Number of measured points.
    pub points: usize,
    /// Smallest and largest stretch; in simple shear the amount of shear, in volumetric tests the volume ratio.
    pub stretches: [f64; 2],
    /// Weight of the squared errors.
    pub weight: f64,
}

/// Fitted constant with its deviation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConstantAnswer {
    /// Name of the constant in settings.
    pub name: String,
    /// Fitted value of the constant.
    pub value: f64,
    /// Standard deviation; `None` if the tests do not determine it, or the constant is fixed or at its bound.
    pub deviation: Option<f64>,
    /// Whether the constant has a given value.
    pub is_fixed: bool,
    /// Whether the constant is at its bound.
    pub is_at_bound: bool,
    /// Unit: `stress`, or `1`.
    pub unit: &'static str,
}

/// First violation of a criterion along a loading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LossAnswer {
    /// Loading of the specimen.
    pub mode: Mode,
    /// Criterion that is violated.
    pub criterion: Criterion,
    /// Imposed stretch at the loss.
    pub stretch: f64,
    /// Whether the state is within the range of the tests.
    pub inside_of_data: bool,
    /// Test that reaches the state, with its range of stretches.
    #[serde(skip)]
    data: Option<String>,
}

/// State at which the chains of a law are fully extended.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LockAnswer {
    /// Loading of the specimen.
    pub mode: Mode,
    /// Stretch that the test imposes.
    pub stretch: f64,
}

/// Fitted law with errors and limits.
#[derive(Clone, Debug, Serialize)]
pub struct LawAnswer {
    /// Name of the law.
    pub law: String,
    /// Constants in the order of the law.
    pub constants: Vec<ConstantAnswer>,
    /// Bulk modulus of the settings; stress. `None` for laws without a bulk modulus.
    pub kappa: Option<f64>,
    /// Shear modulus at small strains; stress.
    pub shear_modulus: f64,
    /// Root mean square of the errors relative to the measured stresses.
    pub error: f64,
    /// Root mean square of the errors as they are weighted in the minimized sum: relative, or in units of stress with absolute weights.
    pub minimized: f64,
    /// Minimized sum of squares.
    pub loss: f64,
    /// Errors of each test.
    pub tests: Vec<Misfit>,
    /// Error of the best fit without the stability constraint.
    pub free_error: f64,
    /// Root mean square of the weighted errors of the best fit without the stability constraint.
    pub free_minimized: f64,
    /// Sum of squares of the best fit without the stability constraint.
    pub free_loss: f64,
    /// Smallest stretches up to 10 at which the best fit without the stability constraint violates a criterion in tension.
    pub free_losses: Vec<LossAnswer>,
    /// Stretches between the same limits, outside the range, at which the result violates a criterion.
    pub losses: Vec<LossAnswer>,
    /// Whether the best fit without the stability constraint is stable in the range.
    pub needs_no_demand: bool,
    /// Proof of the stability of the result; `null` without a range.
    pub proof: Option<Proof>,
    /// Whether no other constants have a smaller sum of squares.
    pub is_global: bool,
    /// Pairs of strongly correlated constants.
    pub correlated: Vec<(String, String, f64)>,
    /// Number of other optima whose sum of squares is within 5 % of the best.
    pub other_optima: usize,
    /// Number of different measured conditions beyond the number of free constants; with 0, the error is not a measure of the fit.
    pub spare_points: usize,
    /// Names of the free constants at their bounds.
    pub at_bounds: Vec<String>,
    /// Names of the free constants that the tests do not determine: their deviation exceeds their magnitude.
    pub undetermined: Vec<String>,
    /// Akaike's information criterion with the correction for few points (AICc), the order of the laws; `null` without enough points.
    pub aicc: Option<f64>,
    /// Lower bound of the sum of squares of all stable constants if the search ended before the optimum; else `null`.
    pub bound: Option<f64>,
    /// Number of first guesses of the search for stable constants, and the number of those whose search was given up.
    pub searched: [usize; 2],
    /// First state in the range at which the chains of the law are fully extended; `null` if the range has no such state.
    pub locks: Option<LockAnswer>,
    /// Settings of the law.
    pub settings: Vec<String>,
    #[serde(skip)]
    pub(super) fit: Fit,
}

/// Fitted laws with the tests, the range of the stability constraint, and remarks.
#[derive(Clone, Debug, Serialize)]
pub struct FitAnswer {
    /// Tests with the extent of their data.
    pub tests: Vec<TestAnswer>,
    /// Unit of stress of the tables; `null` if they state no unit.
    pub unit: Option<String>,
    /// Weights of the points.
    pub weights: Weights,
    /// Range of the stability constraint; `null` for free fits.
    pub range: Option<Range>,
    /// Limits of the principal stretches of the range; `null` for free fits.
    pub stretches: Option<[f64; 2]>,
    /// Criteria of the stability constraint.
    pub criteria: Vec<Criterion>,
    /// Fitted laws, by increasing AICc; laws with undetermined constants follow all others.
    pub laws: Vec<LawAnswer>,
    /// Laws that could not be fitted, with the reasons.
    pub refused: Vec<(String, String)>,
    /// Questions on stresses that contradict the other tests.
    pub questions: Vec<String>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    #[serde(skip)]
    pub(super) data: Vec<Test>,
}

/// Significant digits of stretches and constants in sentences.
const DIGITS: usize = 4;
/// Errors below this value are rounding errors.
const NEGLIGIBLE: f64 = 1e-9;

fn percent(part: f64) -> String {
    match part < NEGLIGIBLE {
        true => "0 %".to_owned(),
        false => format!("{} %", told_with(100.0 * part, 3)),
    }
}

fn short(value: f64) -> String {
    told_with(value, DIGITS)
}

impl FitAnswer {
    pub(super) fn new(
        tables: Tests,
        fits: Vec<Fit>,
        refused: Vec<(String, String)>,
        options: &Options,
        bulk: Option<f64>,
    ) -> Result<Self, FittingError> {
        let tests: Vec<TestAnswer> = tables
            .tests
            .iter()
            .map(|test| {
                let stretches = test.points.iter().map(|point| point.stretch);
                TestAnswer {
                    name: test.name.clone(),
                    mode: test.mode,
                    points: test.points.len(),
                    stretches: [
                        stretches.clone().fold(f64::INFINITY, f64::min),
                        stretches.fold(0.0, f64::max),
                    ],
                    weight: test.weight,
                }
            })
            .collect();
        let mut notes = tables.notes;
        let untested: Vec<&str> = Mode::LOADINGS
            .into_iter()
            .filter(|mode| tests.iter().all(|test| test.mode != *mode))
            .map(Mode::name)
            .collect();
        if !untested.is_empty() {
            notes.push(format!(
                "no test covers {} loading: there the fitted laws are predictions",
                match untested.as_slice() {
                    [first, second, third] => format!("{first}, {second} or {third}"),
                    own => own.join(" or "),
                }
            ));
        }
        let has_volume = tests.iter().any(|test| test.mode == Mode::Volumetric);
        let is_incompressible = fits.iter().any(|fit| !fit.family.is_compressible());
        if bulk.is_none() && !has_volume && is_incompressible {
            notes.push(format!(
                "without a volumetric test or a given bulk modulus, the bulk modulus is {} shear moduli",
                super::BULK_RATIO
            ));
        }
        if !refused.is_empty() {
            let names: Vec<&str> = refused.iter().map(|(law, _)| law.as_str()).collect();
            notes.push(format!(
                "not fitted: {}; the full answer has the reasons",
                names.join(", ")
            ));
        }
        let stretches = fits.first().and_then(|fit| fit.stretches);
        let fixed: Vec<String> = options.fixed.iter().map(|(name, _)| name.clone()).collect();
        let laws = fits
            .into_iter()
            .map(|fit| LawAnswer::new(fit, &tables.tests, &tests, bulk, &fixed));
        let laws: Vec<LawAnswer> = laws.collect::<Result<_, _>>()?;
        if let Some(note) = beyond_range(options.range, &tables.tests, &laws[0]) {
            notes.insert(0, note);
        }
        notes.extend(remarks(&laws));
        notes.extend(outliers(&laws[0], &tables.tests));
        notes.extend(contradicted(&laws[0], &tables.tests, bulk)?);
        Ok(Self {
            unit: tables.unit,
            weights: options.weights,
            range: options.range,
            stretches,
            criteria: options.criteria.clone(),
            laws,
            refused,
            questions: tables.questions,
            notes,
            tests,
            data: tables.tests,
        })
    }

    /// Law with the smallest AICc; laws with undetermined constants come last.
    pub fn best(&self) -> &LawAnswer {
        &self.laws[0]
    }

    /// Description of the range of stability.
    fn range_in_words(&self) -> String {
        let Some([low, high]) = self.stretches else {
            return String::new();
        };
        match self.range {
            Some(Range::Data(_)) => format!("at all states up to stretch {}", short(high)),
            Some(Range::Box(..)) => format!(
                "at all states with stretches from {} to {}",
                short(low),
                short(high)
            ),
            Some(Range::Loadings(..)) => format!(
                "in uniaxial, equibiaxial and planar loading between stretches {} and {}",
                short(low),
                short(high)
            ),
            None => String::new(),
        }
    }

    /// Minimized error, with the unit of stress for absolute weights.
    fn measured(&self, minimized: f64) -> String {
        match (self.weights, &self.unit) {
            (Weights::Absolute, Some(unit)) => format!("{} {unit}", told_with(minimized, 3)),
            (Weights::Absolute, None) => told_with(minimized, 3),
            _ => percent(minimized),
        }
    }

    /// Name of the minimized error.
    fn measure(&self) -> String {
        let is_weighted = matches!(self.weights, Weights::ByTest(_))
            || matches!(self.weights, Weights::Relative(floor) if floor > 0.0)
            || self.tests.iter().any(|test| test.weight != 1.0);
        format!(
            "root mean square of {}{}errors{}",
            if is_weighted { "weighted " } else { "" },
            match self.weights {
                Weights::Absolute => "",
                _ => "relative ",
            },
            match self.best().fit.family.is_compressible() {
                true => " along and across the load",
                false => "",
            }
        )
    }

    /// First sentence: the error, and the range in which the best law is stable.
    fn result(&self) -> String {
        let best = self.best();
        let mut text = format!(
            "{} fits the {} within {} ({})",
            best.law,
            match self.tests.len() {
                1 => "test".to_owned(),
                count => counted(count, "test"),
            },
            self.measured(best.minimized),
            self.measure()
        );
        match &best.proof {
            Some(Proof::Proved { .. }) => {
                let _ = write!(text, " and is stable {} (proved).", self.range_in_words());
            }
            Some(_) => {
                let _ = write!(text, " and is stable {} (sampled).", self.range_in_words());
            }
            None => text.push_str("; stability was not required."),
        }
        text
    }

    fn sentence(&self) -> String {
        let best = self.best();
        let mut text = format!("{} {}", self.result(), self.demand());
        if let [_, others @ ..] = self.laws.as_slice()
            && let Some(simple) = others
                .iter()
                .filter(|own| {
                    own.minimized < SIMILAR * best.minimized && own.unknown() < best.unknown()
                })
                .min_by_key(|own| own.unknown())
        {
            let _ = write!(
                text,
                " With {} instead of {}, {} fits within {}.",
                counted(simple.unknown(), "constant"),
                best.unknown(),
                simple.law,
                self.measured(simple.minimized)
            );
        }
        text
    }

    fn table(&self) -> Vec<String> {
        let width = self
            .laws
            .iter()
            .map(|own| own.law.len())
            .max()
            .unwrap_or(0)
            .max(3);
        let errors: Vec<String> = self
            .laws
            .iter()
            .map(|own| self.measured(own.minimized))
            .collect();
        let wide = errors.iter().map(String::len).max().unwrap_or(0).max(6);
        let mut lines = vec![format!(
            "{:width$}  constants  {:>wide$}  worst test             in the range  without the constraint",
            "law", "error"
        )];
        for (own, error) in self.laws.iter().zip(&errors) {
            let worst = own.tests.iter().filter(|test| test.relative.is_finite());
            let worst = worst.max_by(|a, b| self.of_test(a).total_cmp(&self.of_test(b)));
            let worst = worst.map_or(String::new(), |test| {
                format!("{} {}", test.test, self.measured(self.of_test(test)))
            });
            let stable = match &own.proof {
                Some(Proof::Proved { .. }) => "proved",
                Some(_) => "sampled",
                None => "not asked",
            };
            let free = match (own.needs_no_demand, own.free_losses.first()) {
                (true, _) => "the same".to_owned(),
                (false, None) => self.measured(own.free_minimized),
                (false, Some(loss)) => {
                    format!("{}, {}", self.measured(own.free_minimized), loss.brief())
                }
            };
            lines.push(format!(
                "{:width$}  {:>9}  {error:>wide$}  {worst:21}  {stable:12}  {free}",
                own.law,
                own.unknown(),
            ));
        }
        lines
    }

    /// Error of a test: relative, or in units of stress with absolute weights.
    fn of_test(&self, test: &Misfit) -> f64 {
        match self.weights {
            Weights::Absolute => test.absolute,
            _ => test.relative,
        }
    }

    /// Errors of the tests of a law in one line, with the ranges of their stretches if requested.
    fn errors_in_words(&self, law: &LawAnswer, has_stretches: bool) -> String {
        let tests = law.tests.iter().zip(&self.tests);
        let tests = tests.filter(|(own, _)| own.relative.is_finite());
        let tests = tests.map(|(own, test)| {
            let error = self.measured(self.of_test(own));
            let [low, high] = test.stretches.map(short);
            match has_stretches {
                true => format!("{} {error} at {low} to {high}", own.test),
                false => format!("{} {error}", own.test),
            }
        });
        tests.collect::<Vec<_>>().join(", ")
    }

    /// Sentence on the cost of the stability constraint.
    fn demand(&self) -> String {
        let best = self.best();
        if best.proof.is_none() {
            return match best.free_losses.first() {
                None => "It violates no criterion in uniaxial, equibiaxial and planar tension up to stretch 10; other states are not examined.".to_owned(),
                Some(_) => format!("It violates {}.", in_words(&best.free_losses)),
            };
        }
        if best.needs_no_demand {
            return "The best fit is stable without the constraint, which therefore costs nothing."
                .to_owned();
        }
        let mut text = format!(
            "Without the stability constraint it would fit within {}",
            self.measured(best.free_minimized)
        );
        let _ = match best.free_losses.is_empty() {
            true => write!(
                text,
                ", and lose stability within the range, though not in these tests"
            ),
            false => write!(text, ", and lose {}", in_words(&best.free_losses)),
        };
        text + "."
    }

    /// Sentence on the programs for which [`FitAnswer::files`] has no block, or `None` if all programs have one.
    pub fn missing_blocks(&self) -> Option<String> {
        let missing = BLOCKS.into_iter();
        let missing =
            missing.filter_map(|(program, _)| Some((program.title(), self.block(program).err()?)));
        let (names, reasons): (Vec<&str>, Vec<WriteError>) = missing.unzip();
        let law = &self.best().law;
        let reason = match reasons.first()? {
            WriteError::Law { .. } => format!("{law} is written for no other program"),
            WriteError::Lacks { .. } => format!("without the law {law}"),
            other => other.to_string(),
        };
        Some(format!("no block for {}: {reason}", names.join(", ")))
    }

    /// Command that evaluates the stability criteria of the best law.
    fn next(&self) -> String {
        let sets = self.best().settings.iter();
        let sets = sets.map(|set| format!(" --set {}", quoted(set.as_ref())));
        let response = match self.best().fit.family.is_compressible() {
            true => "",
            false => " --incompressible",
        };
        format!("onset criteria{response}{}", sets.collect::<String>())
    }

    /// Measured and fitted stresses of all laws as a table.
    pub fn csv(&self) -> String {
        let mut points = Vec::new();
        for law in &self.laws {
            let free = &law.fit.free.misfits;
            for ((test, misfit), free) in self.data.iter().zip(&law.tests).zip(free) {
                let stresses = misfit.stresses.iter().zip(&free.stresses);
                let own = test.points.iter().zip(stresses);
                points
                    .extend(own.map(|(point, (fitted, free))| (law, test, point, *fitted, *free)));
            }
        }
        // The tables of the tests name the unit.
        let stress = |name: &str| match &self.unit {
            Some(unit) => format!("{name} [{unit}]"),
            None => name.to_owned(),
        };
        Table::new(&points, Units::Own)
            .with("law", "1", |own| own.0.law.as_str())
            .with("test", "1", |own| own.1.name.as_str())
            .with("mode", "1", |own| own.1.mode.name())
            .with("stretch", "1", |own| own.2.stretch)
            .with(stress("measured"), "1", |own| own.2.stress)
            .with(stress("fitted"), "1", |own| own.3)
            .with(stress("free"), "1", |own| own.4)
            .to_string()
    }

    /// Names of the files of [`FitAnswer::files`], without the figure.
    pub fn names() -> Vec<&'static str> {
        let own = ["fit.toml", "fit.json", "fit.csv"];
        own.into_iter()
            .chain(BLOCKS.map(|(_, name)| name))
            .collect()
    }

    /// Settings, table, figure, and input blocks of the best law for the programs that support it.
    ///
    /// # Errors
    /// [`FittingError::Json`] if the answer cannot be written as JSON.
    pub fn files(&self) -> Result<Files, FittingError> {
        let mut files = vec![
            text("fit.toml", self.study()),
            text("fit.json", json::document(self)?),
            text("fit.csv", self.csv()),
            picture("fit", self.figure()),
        ];
        for (program, name) in BLOCKS {
            if let Ok(block) = self.block(program) {
                files.push(text(name, block));
            }
        }
        Ok(files)
    }

    /// Block of the best law for another program, or the reason why the program has no block.
    fn block(&self, program: Program) -> Result<String, WriteError> {
        let best = self.best();
        let law = match best.fit.family.model() {
            Model::Library(name) => name,
            Model::Formula(_) => "polynomial",
        };
        let constants = best
            .constants
            .iter()
            .map(|own| (own.name.as_str(), own.value));
        let parameters: Vec<(&str, f64)> = constants
            .chain(best.kappa.map(|own| ("kappa", own)))
            .collect();
        law_written(program, law, &parameters).map(|own| own.text)
    }

    /// Study with the best law, for other commands.
    fn study(&self) -> String {
        let mut study = format!("# {}\n", self.sentence().replace('\n', " "));
        if let Some(unit) = &self.unit {
            let _ = writeln!(study, "# Stresses are in {unit}.");
        }
        study.push_str("[material]\n");
        for set in &self.best().settings {
            if let Some((key, value)) = set.trim_start_matches("material.").split_once('=') {
                let _ = match value.parse::<f64>() {
                    Ok(number) => writeln!(study, "{key} = {number:?}"),
                    Err(_) => writeln!(study, "{key} = {value:?}"),
                };
            }
        }
        study
    }
}

/// Note on measured points beyond the range of the stability constraint, if the user gave its limits.
fn beyond_range(range: Option<Range>, data: &[Test], best: &LawAnswer) -> Option<String> {
    let (limits, is_path) = match range? {
        Range::Box(low, high) => ([low.ln(), high.ln()], false),
        Range::Loadings(low, high) => ([low.ln(), high.ln()], true),
        Range::Data(_) => return None,
    };
    let is_compressible = best.fit.family.is_compressible();
    let logs_of = |test: &Test, own: &Point| match own.lateral.filter(|_| is_compressible) {
        Some(lateral) => {
            let width = match test.mode {
                Mode::Uniaxial => lateral,
                Mode::Equibiaxial => own.stretch,
                _ => 1.0,
            };
            [own.stretch, width, lateral].map(f64::ln)
        }
        None => test.mode.logs(own.stretch),
    };
    let is_inside = |logs: [f64; 3]| {
        let used = if is_path { &logs[..1] } else { &logs[..] };
        used.iter()
            .all(|log| (limits[0] - SLACK..=limits[1] + SLACK).contains(log))
    };
    let tests = data.iter().filter_map(|test| {
        if test.mode == Mode::Volumetric {
            return None;
        }
        let (inside, beyond): (Vec<&Point>, Vec<&Point>) = test
            .points
            .iter()
            .partition(|own| is_inside(logs_of(test, own)));
        let rest = if test.mode == Mode::SimpleShear {
            0.0
        } else {
            1.0
        };
        let strain = |own: &&Point| (own.stretch - rest).abs();
        let last = beyond
            .iter()
            .max_by(|a, b| strain(a).total_cmp(&strain(b)))?;
        let side = |own: &&&Point| (own.stretch > rest) == (last.stretch > rest);
        let within = inside.iter().filter(side).map(|own| own.stretch);
        let within = match last.stretch > rest {
            true => within.fold(rest, f64::max),
            false => within.fold(rest, f64::min),
        };
        Some(format!(
            "{} {} (the data reach {})",
            test.name,
            short(within),
            short(last.stretch)
        ))
    });
    let tests: Vec<String> = tests.collect();
    let lost: Vec<&LossAnswer> = best
        .losses
        .iter()
        .filter(|own| own.inside_of_data)
        .collect();
    (!tests.is_empty()).then(|| {
        format!(
            "the data reach beyond the range of the stability constraint, whose last points are {}; beyond, {}",
            tests.join(", "),
            match lost.first() {
                Some(loss) => format!("{} is {}", best.law, loss.brief()),
                None => format!("{} may be unstable", best.law),
            }
        )
    })
}

/// Difference of logarithms of stretches that is a rounding error.
const SLACK: f64 = 1e-9;

/// Smallest errors of an outlier: relative to the median error of its test, and relative to the stress.
const OUTLIER: f64 = 8.0;
const LEAST_OUTLIER: f64 = 0.1;
/// Smallest scale of these errors, as a fraction of the largest stress of the test.
const OUTLIER_FLOOR: f64 = 0.2;

/// Notes on points that the best law does not fit, though it fits the others.
fn outliers(best: &LawAnswer, tests: &[Test]) -> Vec<String> {
    let mut notes = Vec::new();
    for (test, misfit) in tests.iter().zip(&best.tests) {
        let largest = test.points.iter().map(|own| own.stress.abs());
        let largest = largest.fold(0.0, f64::max);
        let pairs = test.points.iter().zip(&misfit.stresses);
        let errors = pairs.filter(|(point, stress)| stress.is_finite() && point.stress != 0.0);
        let errors = errors.map(|(point, stress)| {
            // Errors are relative to the larger stress, which treats high and low outliers alike.
            let scale = point
                .stress
                .abs()
                .max(stress.abs())
                .max(OUTLIER_FLOOR * largest);
            ((stress - point.stress).abs() / scale, point)
        });
        let mut errors: Vec<(f64, &onset_fit::Point)> = errors.collect();
        errors.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some((median, _)) = errors.get(errors.len() / 2).copied() else {
            continue;
        };
        if let Some((error, point)) = errors.last()
            && *error > LEAST_OUTLIER
            && *error > OUTLIER * median
        {
            notes.push(format!(
                "{}: the point at {} with the stress {} is {} % from {}, the median error of the test is {} %; check it",
                test.name,
                short(point.stretch),
                short(point.stress),
                told_with(100.0 * error, 2),
                best.law,
                told_with(100.0 * median, 2)
            ));
        }
    }
    notes
}

/// Largest ratio of a given bulk modulus to the bulk modulus of a volumetric test without a note.
const BULK_DISAGREEMENT: f64 = 1.5;

/// Note on a given bulk modulus that a volumetric test contradicts.
fn contradicted(
    best: &LawAnswer,
    tests: &[Test],
    bulk: Option<f64>,
) -> Result<Option<String>, FittingError> {
    let has_volume = tests.iter().any(|test| test.mode == Mode::Volumetric);
    let Some(bulk) = bulk.filter(|_| has_volume) else {
        return Ok(None);
    };
    let (_, measured) = assignments(&best.fit.family, best.fit.result(), tests, None)?;
    let measured = measured.filter(|own| {
        let ratio = own / bulk;
        !(BULK_DISAGREEMENT.recip()..=BULK_DISAGREEMENT).contains(&ratio)
    });
    Ok(measured.map(|own| {
        format!(
            "the given bulk modulus is {}, the volumetric test gives {}",
            short(bulk),
            short(own)
        )
    }))
}

/// Remarks on laws whose constants or errors are less meaningful than they appear.
fn remarks(laws: &[LawAnswer]) -> Vec<String> {
    let mut notes = Vec::new();
    let all = |holds: &dyn Fn(&LawAnswer) -> bool| {
        let own = laws.iter().filter(|own| holds(own));
        own.map(|own| own.law.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let exact = all(&|own| own.spare_points == 0);
    if !exact.is_empty() {
        notes.push(format!(
            "{exact}: the number of points equals the number of constants, so that the error does not measure the fit; add points, or choose laws with fewer constants"
        ));
    }
    if laws.len() > 1 {
        notes.push("laws are ranked by AICc (Akaike's criterion: error and number of constants); laws with constants that the tests do not determine follow all others".to_owned());
    }
    let open = all(&|own| !own.undetermined.is_empty());
    if !open.is_empty() {
        notes.push(format!(
            "{open}: the tests do not determine all constants (deviations larger than the constants); choose a law with fewer constants, or fix some"
        ));
    }
    for own in laws {
        if let Some(bound) = own.bound {
            notes.push(format!(
                "{}: the search for the best stable constants ended before the optimum; no stable constants have a sum of squares below {} (found: {})",
                own.law,
                told(bound),
                told(own.loss)
            ));
        }
        if own.searched[1] > 0 {
            notes.push(format!(
                "{}: {} of {} searches for stable constants were given up",
                own.law, own.searched[1], own.searched[0]
            ));
        }
        if let [name] = own.at_bounds.as_slice() {
            notes.push(format!("{}: {name} is at its bound", own.law));
        } else if !own.at_bounds.is_empty() {
            notes.push(format!(
                "{}: {} are at their bounds",
                own.law,
                own.at_bounds.join(", ")
            ));
        }
        if let Some(lock) = &own.locks {
            notes.push(format!(
                "{}: inside the range, its chains are fully extended from stretch {} in {} tension on; {}",
                own.law,
                short(lock.stretch),
                lock.mode.name(),
                match own.fit.family.ends_at_locking() {
                    true => "its energy is undefined beyond, and only the states before are called stable",
                    false => "beyond, its series continues without a limit",
                }
            ));
        }
    }
    notes
}

/// Largest difference between the stresses of printed and fitted constants, as a part of the error, and the least admitted difference.
const PRINTED_PART: f64 = 0.01;
const PRINTED_LEAST: f64 = 1e-6;
/// Digits of printed constants of compressible laws.
const COMPRESSIBLE_DIGITS: usize = 8;

/// Lines of a ranking that notes do not displace: the head, three laws and the number of the others.
const RANKING_LINES: usize = 5;
/// Largest number of characters of the constants in a ranking.
const RANKING_CONSTANTS: usize = 170;

/// Largest ratio of the errors of two laws that fit about as well.
const SIMILAR: f64 = 1.25;

/// Programs with the names of files for their blocks.
const BLOCKS: [(Program, &str); 7] = [
    (Program::Abaqus, "abaqus.inp"),
    (Program::Ansys, "ansys.dat"),
    (Program::Calculix, "calculix.inp"),
    (Program::Febio, "febio.feb"),
    (Program::Felupe, "felupe.py"),
    (Program::LsDyna, "lsdyna.k"),
    (Program::Radioss, "radioss.rad"),
];

impl LossAnswer {
    fn brief(&self) -> String {
        format!("lost at {} {}", short(self.stretch), self.mode.name())
    }
}

impl LawAnswer {
    fn new(
        fit: Fit,
        data: &[Test],
        tests: &[TestAnswer],
        bulk: Option<f64>,
        fixed: &[String],
    ) -> Result<Self, FittingError> {
        let result = fit.result().clone();
        let (settings, kappa) = assignments(&fit.family, &result, data, bulk)?;
        let mut fit = fit;
        let mut misfits = result.misfits.clone();
        for (n, test) in data.iter().enumerate() {
            if kappa.is_some() && test.mode == Mode::Volumetric {
                // The volumetric response depends on the bulk modulus only, with or without the stability constraint.
                let own = volumetric_misfit(test, &settings)?;
                misfits[n] = own.clone();
                fit.free.misfits[n] = own;
            }
        }
        let weight = fit.weight;
        let root_mean = |loss: f64| (loss / weight).sqrt();
        let deviations = &result.uncertainty.deviations;
        let constants = fit
            .family
            .constants()
            .iter()
            .zip(&result.constants)
            .zip(deviations);
        let losses = |own: &onset_fit::Fitted| {
            let all = own.limits.iter().map(|limit| {
                // Compression passes through the states of another loading in tension.
                let [uniaxial, equibiaxial, planar] = match limit.mode {
                    Mode::Equibiaxial => [limit.stretch.powi(-2), limit.stretch, 1.0],
                    Mode::Uniaxial => [limit.stretch, limit.stretch.powf(-0.5), 1.0],
                    _ => [1.0, 1.0, limit.stretch],
                };
                let is_reached = |test: &&TestAnswer| {
                    let [low, high] = test.stretches;
                    let within = |stretch: f64| stretch != 1.0 && (low..=high).contains(&stretch);
                    match test.mode {
                        Mode::Uniaxial => within(uniaxial),
                        Mode::Equibiaxial => within(equibiaxial),
                        Mode::Planar => within(planar) || within(planar.recip()),
                        _ => false,
                    }
                };
                let reached = tests.iter().find(is_reached);
                LossAnswer {
                    mode: limit.mode,
                    criterion: limit.criterion,
                    stretch: limit.stretch,
                    inside_of_data: reached.is_some(),
                    data: reached.map(|test| {
                        let [low, high] = test.stretches.map(short);
                        format!("{} data, {low} to {high}", test.name)
                    }),
                }
            });
            all.collect()
        };
        Ok(Self {
            law: fit.family.name().to_owned(),
            constants: constants
                .map(|((own, value), deviation)| ConstantAnswer {
                    name: own.name.clone(),
                    value: *value,
                    deviation: deviation.is_finite().then_some(*deviation),
                    unit: if own.is_modulus { "stress" } else { "1" },
                    is_fixed: fixed.contains(&own.name),
                    is_at_bound: result.at_bounds.contains(&own.name),
                })
                .collect(),
            kappa,
            shear_modulus: result.shear_modulus,
            error: result.relative,
            minimized: root_mean(result.loss),
            loss: result.loss,
            tests: misfits,
            free_error: fit.free.relative,
            free_minimized: root_mean(fit.free.loss),
            free_loss: fit.free.loss,
            free_losses: losses(&fit.free),
            losses: losses(&result),
            needs_no_demand: fit.stable.is_none(),
            proof: fit.proof.clone(),
            is_global: fit.is_global(),
            correlated: result.uncertainty.correlated.clone(),
            other_optima: fit.others.len(),
            spare_points: fit.spare,
            at_bounds: result.at_bounds.clone(),
            undetermined: result.undetermined.clone(),
            aicc: Some(fit.criterion()).filter(|own| own.is_finite()),
            bound: fit.bound,
            searched: fit.searched,
            locks: result
                .locked
                .map(|(mode, stretch)| LockAnswer { mode, stretch }),
            settings,
            fit,
        })
    }

    /// Number of constants that are not fixed.
    fn unknown(&self) -> usize {
        self.constants.iter().filter(|own| !own.is_fixed).count()
    }

    /// Constants with enough digits for the printed law to have the stresses of the fitted law.
    ///
    /// Moduli of correlated terms nearly cancel, so that all of their digits matter.
    fn rounded(&self, data: &[Test]) -> Vec<f64> {
        let values: Vec<f64> = self.constants.iter().map(|own| own.value).collect();
        let at = |digits: usize| -> Vec<f64> {
            let own = values.iter().map(|value| {
                let text = format!("{value:.*e}", digits - 1);
                text.parse().unwrap_or(*value)
            });
            own.collect()
        };
        let family = &self.fit.family;
        if family.is_compressible() {
            return at(COMPRESSIBLE_DIGITS);
        }
        let tolerance = (PRINTED_PART * self.error).max(PRINTED_LEAST);
        let is_same = |rounded: &[f64]| {
            let points = data.iter().flat_map(|test| {
                let own = test.points.iter().map(|point| (test.mode, point.stretch));
                own.filter(|_| test.mode != Mode::Volumetric)
            });
            points.into_iter().all(|(mode, stretch)| {
                let stress = |constants: &[f64]| family.stress(constants, mode, stretch);
                match (stress(&values), stress(rounded)) {
                    (Some(a), Some(b)) => (a - b).abs() <= tolerance * a.abs(),
                    _ => true,
                }
            })
        };
        let digits = (DIGITS..17).find(|digits| is_same(&at(*digits)));
        digits.map_or(values.clone(), at)
    }

    /// Constants in one line, with or without their deviations.
    fn constants_in_words(&self, data: &[Test], unit: Option<&str>, deviations: bool) -> String {
        let told = self.constants.iter().zip(self.rounded(data));
        let told = told.map(|(own, value)| {
            let after = match (own.is_fixed, own.is_at_bound, own.deviation) {
                (true, _, _) => " (fixed)".to_owned(),
                (_, true, _) => " (at its bound)".to_owned(),
                (_, _, Some(0.0)) => " (set by the stability constraint)".to_owned(),
                (_, _, Some(deviation)) if deviations => {
                    format!(" ± {}", told_with(deviation, 2))
                }
                _ => String::new(),
            };
            let unit = match (own.unit, unit) {
                ("stress", Some(unit)) => format!(" {unit}"),
                _ => String::new(),
            };
            format!("{} {}{after}{unit}", own.name, told_with(value, 17))
        });
        told.collect::<Vec<_>>().join(", ")
    }

    /// Strongly correlated constants in one line.
    fn correlated_in_words(&self) -> String {
        let pairs = self.correlated.iter();
        let pairs = pairs.map(|(a, b, own)| format!("{a} and {b} ({})", told_with(*own, 3)));
        pairs.collect::<Vec<_>>().join(", ")
    }

    /// Constants that the tests do not determine, in one line.
    fn undetermined_in_words(&self) -> String {
        match self.undetermined.is_empty() {
            true => String::new(),
            false => format!(
                "{} (deviation larger than the constant)",
                self.undetermined.join(", ")
            ),
        }
    }

    fn others_in_words(&self) -> String {
        match self.other_optima {
            0 => String::new(),
            1 => "1 other optimum has a sum of squares within 5 %".to_owned(),
            count => format!("{count} other optima have sums of squares within 5 %"),
        }
    }
}

/// Sentence on the first violation of each criterion.
fn in_words(losses: &[LossAnswer]) -> String {
    let mut told: Vec<&LossAnswer> = Vec::new();
    for loss in losses {
        if told.iter().all(|own| own.criterion != loss.criterion) {
            told.push(loss);
        }
    }
    let told = told.iter().map(|loss| {
        format!(
            "{} at stretch {} in {} tension{}",
            loss.criterion.of_library().title(),
            short(loss.stretch),
            loss.mode.name(),
            loss.data
                .as_ref()
                .map_or(String::new(), |data| format!(" (inside the {data})"))
        )
    });
    told.collect::<Vec<_>>().join(" and ")
}

impl Brief for FitAnswer {
    fn brief(&self) -> Short {
        let best = self.best();
        let is_ranking = self.laws.len() > 1;
        let mut short = match is_ranking {
            true => Short::new(self.result())
                .table(self.table())
                .table_lines(RANKING_LINES),
            false => {
                Short::new(self.sentence()).row(1, "by test", self.errors_in_words(best, true))
            }
        };
        for question in &self.questions {
            short = short.row(0, "question", question);
        }
        let unit = self.unit.as_deref();
        let mut constants = best.constants_in_words(&self.data, unit, true);
        if is_ranking && constants.chars().count() > RANKING_CONSTANTS {
            constants = best.constants_in_words(&self.data, unit, false);
        }
        short = short.row(0, "constants", constants);
        // A ranking has no room for these.
        let rank = if is_ranking { 3 } else { 0 };
        for (rank, name, text) in [
            (rank, "uncertain", best.undetermined_in_words()),
            (rank, "correlated", best.correlated_in_words()),
            (2, "not unique", best.others_in_words()),
        ] {
            if !text.is_empty() {
                short = short.row(rank, name, text);
            }
        }
        short.row(4, "next", self.next()).notes(&self.notes)
    }
}

impl fmt::Display for FitAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "{}\n", self.sentence())?;
        for line in self.table() {
            writeln!(formatter, "{line}")?;
        }
        let unit = self.unit.as_deref().unwrap_or("the unit of the tables");
        writeln!(formatter)?;
        for question in &self.questions {
            writeln!(formatter, "question    {question}")?;
        }
        for own in &self.tests {
            writeln!(
                formatter,
                "test        {}: {} at {} from {} to {}{}",
                own.name,
                counted(own.points, "point"),
                own.mode.measures(),
                short(own.stretches[0]),
                short(own.stretches[1]),
                match own.weight {
                    1.0 => String::new(),
                    weight => format!(", weight {}", told(weight)),
                }
            )?;
        }
        if let Some(Range::Data(factor)) = self.range {
            writeln!(
                formatter,
                "range       stable {}, in every loading: {} times the largest stretch of all tests",
                self.range_in_words(),
                told(factor)
            )?;
        }
        writeln!(formatter, "\nconstants   (stresses in {unit})")?;
        for own in &self.laws {
            let constants = own.constants_in_words(&self.data, self.unit.as_deref(), true);
            writeln!(formatter, "{}: {constants}", own.law)?;
            for (name, text) in [
                ("uncertain", own.undetermined_in_words()),
                ("correlated", own.correlated_in_words()),
                ("by test", self.errors_in_words(own, false)),
                ("not unique", own.others_in_words()),
            ] {
                if !text.is_empty() {
                    writeln!(formatter, "  {name}: {text}")?;
                }
            }
            let optimum = match (own.is_global, own.bound) {
                (true, _) => "the global minimum for this law".to_owned(),
                (_, Some(bound)) => format!("no stable constants have less than {}", told(bound)),
                _ => "the lowest of many local minima".to_owned(),
            };
            writeln!(
                formatter,
                "  sum of squares {}, {optimum}; without the stability constraint {}{}",
                told(own.loss),
                told(own.free_loss),
                own.aicc
                    .map_or(String::new(), |own| format!("; AICc {}", told_with(own, 4)))
            )?;
        }
        for (law, reason) in &self.refused {
            writeln!(
                formatter,
                "not fitted  {law}: {}",
                reason.replace("\n  hint:", ";")
            )?;
        }
        writeln!(formatter, "\nnext        {}", self.next())?;
        for note in &self.notes {
            write!(formatter, "\nnote: {note}")?;
        }
        Ok(())
    }
}
