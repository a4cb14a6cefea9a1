//! Least-squares fit of a law: first without constraints, then subject to stability.

use crate::family::Family;
use crate::moduli::Criterion;
use crate::proof::{Proof, prove};
use crate::range::{
    Limit, Mode, Numbers, Patch, Range, Worst, fence, limits, locked, low_states, worst_states,
};
use crate::solve::{Cut, Problem, Solution};
use crate::tests_of_specimens::{Equations, Misfit, Test};
use crate::uncertainty::Uncertainty;
use nalgebra::DVector;
use onset::cancel::{Scope, checkpoint};
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

/// Weights of the measured points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weights {
    /// Errors relative to the measured stress, or to this fraction of the largest stress of the test if that is larger.
    Relative(f64),
    /// Errors in units of stress.
    Absolute,
}

/// Choices of a fit: weights, range, criteria and constraints.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Weights of the measured points.
    pub weights: Weights,
    /// States at which the law must be stable; `None` for a free fit.
    pub range: Option<Range>,
    /// Criteria that must hold at all states of the range.
    pub criteria: Vec<Criterion>,
    /// Lowest value of a criterion, relative to its value in the reference configuration.
    pub margin: f64,
    /// Number of first guesses for constants in which the energy is not linear.
    pub starts: usize,
    /// Constants with fixed values.
    pub fixed: Vec<(String, f64)>,
    /// Bounds of constants by their names.
    pub bounds: Vec<(String, [f64; 2])>,
}

impl Default for Options {
    /// Relative errors, with Drucker's inequality and strong ellipticity up to 1.25 times the largest stretch of the tests.
    fn default() -> Self {
        Self {
            weights: Weights::Relative(0.0),
            range: Some(Range::Data(1.25)),
            criteria: vec![Criterion::Drucker, Criterion::StrongEllipticity],
            margin: 1e-6,
            starts: 64,
            fixed: Vec::new(),
            bounds: Vec::new(),
        }
    }
}

/// Reason why a law cannot be fitted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FitError {
    /// Fewer measured points than constants.
    #[error("{law} has {constants} unknown constants; the tests have {points} points")]
    TooFewPoints {
        /// Name of the law.
        law: String,
        /// Number of constants that are not fixed.
        constants: usize,
        /// Number of measured conditions.
        points: usize,
    },
    /// Several values of the constants fit the tests equally well.
    #[error("the tests do not determine the constants of {law}; {hint}")]
    Undetermined {
        /// Name of the law.
        law: String,
        /// Advice for the user.
        hint: &'static str,
    },
    /// A compressible law needs lateral stretches.
    #[error("{law} needs lateral stretches, which the {test} test lacks")]
    NoLateralStretch {
        /// Name of the law.
        law: String,
        /// Name of the test.
        test: String,
    },
    /// A constant that the law does not have.
    #[error("{law} has no constant `{name}`; it has {known}")]
    UnknownConstant {
        /// Name of the law.
        law: String,
        /// Name that was given.
        name: String,
        /// Constants of the law.
        known: String,
    },
    /// Values or bounds of a constant that contradict each other or the law.
    #[error(
        "no value of {name} of {law} satisfies all that is fixed or bounded; expected {expected}"
    )]
    Bounds {
        /// Name of the law.
        law: String,
        /// Name of the constant.
        name: String,
        /// Description of the admissible values.
        expected: String,
    },
    /// The stability constraint could not be satisfied at all states within the largest number of rounds.
    #[error("the fit of {law} with the stability constraint did not converge")]
    NotConverged {
        /// Name of the law.
        law: String,
    },
    /// No constants satisfy the stability constraint.
    #[error("no constants of {law} are stable at all states of the range")]
    NotStable {
        /// Name of the law.
        law: String,
    },
}

/// Constants of a law, with their errors and limits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fitted {
    /// Values in the order of [`Family::constants`].
    pub constants: Vec<f64>,
    /// Shear modulus at small strains; units of stress.
    pub shear_modulus: f64,
    /// Sum of the squared errors.
    pub loss: f64,
    /// Root mean square of the errors relative to the measured stresses, over all points.
    pub relative: f64,
    /// Errors of each test.
    pub misfits: Vec<Misfit>,
    /// Smallest stretches up to 10 at which each criterion is violated in tension; for incompressible response.
    pub limits: Vec<Limit>,
    /// State of the range at which a stability criterion has its smallest value; `None` without a range.
    pub worst: Option<Worst>,
    /// Standard deviations and correlations of the constants.
    pub uncertainty: Uncertainty,
    /// Names of the free constants that are at their bounds.
    pub at_bounds: Vec<String>,
    /// Loading and smallest stretch of the range at which the chains of the law are fully extended; `None` if this does not occur in the range.
    pub locked: Option<(Mode, f64)>,
}

/// Best constants of a law, with and without the stability constraint.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// Law that was fitted.
    #[serde(skip)]
    pub family: Family,
    /// Best constants without the stability constraint.
    pub free: Fitted,
    /// Best constants that are stable in the range; `None` if they are the free constants, or without a range.
    pub stable: Option<Fitted>,
    /// Whether the stability of the result is proved; `None` without a range.
    pub proof: Option<Proof>,
    /// Number of different measured conditions beyond the number of free constants.
    pub spare: usize,
    /// Other constants whose sum of squares is within 5 % of the best, as values and sum.
    pub others: Vec<(Vec<f64>, f64)>,
    /// Limits of the principal stretches of the range; `None` without a range.
    pub stretches: Option<[f64; 2]>,
}

impl Fit {
    /// The stable constants, or the free constants if they are stable or there is no range.
    pub fn result(&self) -> &Fitted {
        self.stable.as_ref().unwrap_or(&self.free)
    }

    /// Returns true if the optimum is global, because the energy is linear in all constants.
    pub fn is_global(&self) -> bool {
        self.family.is_linear()
    }
}

/// Largest number of rounds in which states are added.
const ROUNDS: usize = 80;
/// Largest number of states missed by the samples and found by the proof.
const MISSED: usize = 6;
/// States added in one round.
const ADDED: usize = 6;
/// Fraction of the margin that the worst state must reach.
const LEAST_MARGIN_SHARE: f64 = 0.5;
/// Optima within this fraction of the best are listed.
const SIMILAR: f64 = 0.05;
/// Constants this close to a bound, relative to it, are at the bound.
const BOUND_TOLERANCE: f64 = 1e-6;
/// Optima whose constants differ by less than this fraction count as one.
const CONSTANT_TOLERANCE: f64 = 1e-3;
/// Number of free optima that are starting points of a fit with the stability constraint.
const STARTS_WITH_DEMANDS: usize = 6;

/// Fits a law to tests.
///
/// Laws that do not change volume are fitted to their incompressible response: `P = (w_1 - w_3)/lambda_1` with `w_i = dW/dln(lambda_i)` and the free
/// face 3. The sum of squares contains the errors at all points, with the weights of their tests.
///
/// # Errors
/// [`FitError`] if the tests do not determine the constants, or no constants are stable.
pub fn fit(tests: &[Test], family: &Family, options: &Options) -> Result<Fit, FitError> {
    let compressible = family.is_compressible();
    if compressible {
        let lacks = |test: &&Test| {
            !matches!(test.mode, Mode::SimpleShear | Mode::Volumetric)
                && test.points.iter().any(|point| point.lateral.is_none())
        };
        if let Some(test) = tests.iter().find(lacks) {
            return Err(FitError::NoLateralStretch {
                law: family.name().to_owned(),
                test: test.name.clone(),
            });
        }
    }
    let bounds = bounds_of(family, options)?;
    let equations = Equations::new(tests, compressible, options.weights);
    let is_free: Vec<bool> = bounds.iter().map(|[low, high]| low < high).collect();
    let unknown = is_free.iter().filter(|own| **own).count();
    if equations.len() < unknown {
        return Err(FitError::TooFewPoints {
            law: family.name().to_owned(),
            constants: unknown,
            points: equations.len(),
        });
    }
    let search = Search {
        tests,
        family,
        equations: &equations,
        options,
        bounds: &bounds,
        is_free: &is_free,
        patches: options
            .range
            .map_or(Vec::new(), |range| range.patches(tests, compressible)),
    };
    search.run()
}

/// Bounds of the constants; both bounds are equal for a fixed constant.
fn bounds_of(family: &Family, options: &Options) -> Result<Vec<[f64; 2]>, FitError> {
    let mut bounds: Vec<[f64; 2]> = family.constants().iter().map(|own| own.bounds).collect();
    let fixed = options
        .fixed
        .iter()
        .map(|(name, value)| (name, [*value; 2]));
    for (name, given) in fixed.chain(options.bounds.iter().map(|(name, own)| (name, *own))) {
        let Some(n) = family.constants().iter().position(|own| own.name == *name) else {
            let names = family.constants().iter().map(|own| own.name.as_str());
            return Err(FitError::UnknownConstant {
                law: family.name().to_owned(),
                name: name.clone(),
                known: names.collect::<Vec<_>>().join(", "),
            });
        };
        let [low, high] = bounds[n];
        let both = [given[0].max(low), given[1].min(high)];
        let is_exponent_zero = family.is_exponent(n) && both == [0.0; 2];
        if both[0] > both[1] || is_exponent_zero {
            return Err(FitError::Bounds {
                law: family.name().to_owned(),
                name: name.clone(),
                expected: match is_exponent_zero {
                    true => "an exponent other than 0".to_owned(),
                    false => format!("values from {low} to {high}"),
                },
            });
        }
        bounds[n] = both;
    }
    Ok(bounds)
}

struct Search<'a> {
    tests: &'a [Test],
    family: &'a Family,
    equations: &'a Equations,
    options: &'a Options,
    bounds: &'a [[f64; 2]],
    is_free: &'a [bool],
    patches: Vec<Patch>,
}

impl Search<'_> {
    fn run(&self) -> Result<Fit, FitError> {
        let free = self.optima(&self.guesses(), &|problem, start| problem.solve(start));
        let Some(best) = free.first() else {
            let is_shear = |mode| matches!(mode, Mode::Planar | Mode::SimpleShear);
            return Err(FitError::Undetermined {
                law: self.family.name().to_owned(),
                hint: match self.tests.iter().all(|test| is_shear(test.mode)) {
                    true => {
                        "in planar tension and in simple shear both invariants are equal: add another test, or choose a law with fewer constants"
                    }
                    false => "add another kind of test, or choose a law with fewer constants",
                },
            });
        };
        let mut result = Fit {
            family: self.family.clone(),
            free: self.fitted(best),
            stable: None,
            proof: None,
            spare: self.equations.len() - self.is_free.iter().filter(|own| **own).count(),
            others: self.others(&free),
            stretches: None,
        };
        let Some(range) = self.options.range else {
            return Ok(result);
        };
        result.stretches = Some(range.stretches(self.tests, self.family.is_compressible()));
        let is_enough = |worst: &Worst| worst.value >= LEAST_MARGIN_SHARE * self.options.margin;
        if result.free.worst.as_ref().is_none_or(is_enough) {
            match prove(&self.numbers(&best.constants), &self.patches) {
                Proof::Refuted { .. } => {}
                proof => {
                    result.proof = Some(proof);
                    return Ok(result);
                }
            }
        }
        let mut starts: Vec<Vec<f64>> = free.iter().map(|own| own.constants.clone()).collect();
        starts.truncate(STARTS_WITH_DEMANDS);
        if !self.family.is_linear() {
            starts.extend(self.guesses().into_iter().take(STARTS_WITH_DEMANDS));
        }
        let found = self.optima(&starts, &|problem, start| {
            self.demanded(problem, start, Vec::new())
        });
        let law = self.family.name().to_owned();
        let none = || match self.family.has_neo_hooke() {
            true => FitError::NotConverged { law: law.clone() },
            false => FitError::NotStable { law: law.clone() },
        };
        let mut best = found.first().cloned().ok_or_else(none)?;
        result.others = self.others(&found);
        // A state that the samples missed is added, too.
        let mut missed = Vec::new();
        let proof = loop {
            match prove(&self.numbers(&best.constants), &self.patches) {
                Proof::Refuted { worst } if missed.len() < MISSED => missed.push(Cut::from(worst)),
                Proof::Refuted { .. } => return Err(FitError::NotConverged { law: law.clone() }),
                proof => break proof,
            }
            let again = self.demanded(&self.problem(), &best.constants, missed.clone());
            best = again.ok_or_else(none)?;
        };
        result.proof = Some(proof);
        result.stable = Some(self.fitted(&best));
        Ok(result)
    }

    fn problem(&self) -> Problem<'_> {
        Problem {
            family: self.family,
            equations: self.equations,
            cuts: &[],
            margin: self.options.margin,
            bounds: self.bounds,
        }
    }

    fn numbers<'b>(&'b self, constants: &'b [f64]) -> Numbers<'b> {
        Numbers {
            family: self.family,
            constants,
            criteria: &self.options.criteria,
        }
    }

    /// First guesses: points of Halton's sequence in the ranges of guesses, within the bounds.
    fn guesses(&self) -> Vec<Vec<f64>> {
        const BASES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
        let count = match self.family.is_linear() {
            true => 1,
            false => self.options.starts.max(1),
        };
        let part = |mut n: usize, base: usize| {
            let (mut sum, mut unit) = (0.0, 1.0);
            while n > 0 {
                unit /= base as f64;
                sum += unit * (n % base) as f64;
                n /= base;
            }
            sum
        };
        let guess = |n: usize| {
            let constants = self.family.constants().iter().zip(self.bounds).enumerate();
            constants
                .map(|(c, (own, bounds))| {
                    let [low, high] = own.guesses.map(|end| end.clamp(bounds[0], bounds[1]));
                    let t = part(n + 1, BASES[c % BASES.len()]);
                    match own.is_modulus {
                        true => low.max(0.0),
                        // A constant that cannot change its sign may vary by orders of magnitude.
                        false if low > 0.0 => low * (high / low).powf(t),
                        false => low + (high - low) * t,
                    }
                })
                .collect()
        };
        (0..count).map(guess).collect()
    }

    /// Distinct optima from several starts, the best first.
    fn optima(
        &self,
        starts: &[Vec<f64>],
        solve: &(dyn Fn(&Problem<'_>, &[f64]) -> Option<Solution> + Sync),
    ) -> Vec<Solution> {
        let problem = self.problem();
        let scope = Scope::current();
        let mut all: Vec<Solution> = starts
            .par_iter()
            .filter_map(|start| scope.run(|| solve(&problem, start)))
            .filter(|own| own.loss.is_finite())
            .collect();
        all.sort_by(|a, b| a.loss.total_cmp(&b.loss));
        let mut distinct: Vec<Solution> = Vec::new();
        for mut own in all {
            self.sort(&mut own);
            let is_same = |other: &Solution| {
                let pairs = own.constants.iter().zip(&other.constants);
                pairs
                    .into_iter()
                    .all(|(a, b)| (a - b).abs() <= CONSTANT_TOLERANCE * a.abs().max(b.abs()))
            };
            if !distinct.iter().any(is_same) {
                distinct.push(own);
            }
        }
        distinct
    }

    /// Sorts terms of the same form by their exponents, the largest first, unless they have different bounds.
    fn sort(&self, own: &mut Solution) {
        let terms = self.family.terms();
        if terms.len() < 2 || terms[0].shapes.is_empty() || self.is_free.contains(&false) {
            return;
        }
        let width = 1 + terms[0].shapes.len();
        if self
            .bounds
            .chunks(width)
            .any(|own| own != &self.bounds[..width])
        {
            return;
        }
        let mut order: Vec<usize> = (0..own.constants.len() / width).collect();
        order.sort_by(|a, b| own.constants[b * width + 1].total_cmp(&own.constants[a * width + 1]));
        let sorted = |values: &[f64]| -> Vec<f64> {
            let blocks = order.iter().map(|n| &values[n * width..(n + 1) * width]);
            blocks.flatten().copied().collect()
        };
        own.constants = sorted(&own.constants);
        for gradient in &mut own.active {
            *gradient = DVector::from_vec(sorted(gradient.as_slice()));
        }
    }

    /// Solution that satisfies the stability constraint in the whole range: states are added until it holds everywhere.
    fn demanded(
        &self,
        problem: &Problem<'_>,
        start: &[f64],
        mut cuts: Vec<Cut>,
    ) -> Option<Solution> {
        let mut constants = start.to_vec();
        if self.family.is_linear() {
            // Constraints at a coarse grid keep the first constants close to the stable optimum.
            let compressible = self.family.is_compressible();
            cuts.extend(fence(&self.patches, &self.options.criteria, compressible));
        }
        for _ in 0..ROUNDS {
            checkpoint();
            let found = Problem {
                cuts: &cuts,
                ..*problem
            }
            .solve(&constants)?;
            let law = self.numbers(&found.constants);
            let least = LEAST_MARGIN_SHARE * self.options.margin;
            // For a linear law constraints are cheap: many are added in each iteration, so that fewer iterations are needed.
            let mut worst = match self.family.is_linear() {
                true => low_states(&law, &self.patches, least),
                false => worst_states(&law, &self.patches),
            };
            if worst.iter().all(|own| own.value >= least) {
                return Some(found);
            }
            if !self.family.is_linear() {
                worst.retain(|own| own.value < least);
                worst.truncate(ADDED);
            }
            cuts.extend(worst.into_iter().map(Cut::from));
            constants = found.constants;
        }
        None
    }

    fn others(&self, optima: &[Solution]) -> Vec<(Vec<f64>, f64)> {
        let Some(best) = optima.first() else {
            return Vec::new();
        };
        let similar = optima[1..]
            .iter()
            .filter(|own| own.loss <= best.loss * (1.0 + SIMILAR));
        similar
            .map(|own| (own.constants.clone(), own.loss))
            .collect()
    }

    fn fitted(&self, solution: &Solution) -> Fitted {
        let misfits = self
            .equations
            .misfits(self.tests, self.family, &solution.constants);
        let pairs = self.tests.iter().zip(&misfits).flat_map(|(test, own)| {
            let points = test.points.iter().zip(&own.stresses);
            points.filter(|(point, stress)| stress.is_finite() && point.stress != 0.0)
        });
        let squares: Vec<f64> = pairs
            .map(|(point, stress)| ((stress - point.stress) / point.stress).powi(2))
            .collect();
        let law = self.numbers(&solution.constants);
        let at_bounds = self.at_bounds(&solution.constants);
        let constants = self.family.constants().iter().zip(self.is_free);
        let varies: Vec<bool> = constants
            .map(|(own, is_free)| *is_free && !at_bounds.contains(&own.name))
            .collect();
        Fitted {
            constants: solution.constants.clone(),
            shear_modulus: law.shear_modulus(),
            loss: solution.loss,
            relative: (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt(),
            misfits,
            limits: match self.family.is_compressible() {
                true => Vec::new(),
                false => limits(self.family, &solution.constants, &self.options.criteria),
            },
            worst: worst_states(&law, &self.patches).into_iter().next(),
            uncertainty: Uncertainty::new(
                self.family,
                self.equations,
                &solution.constants,
                &varies,
                &solution.active,
            ),
            at_bounds,
            locked: locked(self.family, &solution.constants, &self.patches),
        }
    }

    fn at_bounds(&self, constants: &[f64]) -> Vec<String> {
        let is_at = |n: usize| {
            let value = constants[n];
            let is_near =
                |end: f64| end.is_finite() && (value - end).abs() <= BOUND_TOLERANCE * end.abs();
            let smallest = self.family.smallest(n, value, self.bounds[n]);
            let is_smallest = smallest > 0.0 && is_near(smallest.copysign(value));
            self.is_free[n] && (is_smallest || self.bounds[n].into_iter().any(is_near))
        };
        let names = self.family.constants().iter().map(|own| own.name.clone());
        let all = names.enumerate().filter(|(n, _)| is_at(*n));
        all.map(|(_, name)| name).collect()
    }
}
