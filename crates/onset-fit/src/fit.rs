//! Least-squares fit of a law: first without constraints, then subject to stability.

use crate::family::Family;
use crate::moduli::Criterion;
use crate::proof::{Proof, prove};
use crate::range::{
    Limit, Mode, Numbers, Patch, Range, Sampling, Worst, fence, limits, locked, low_states,
    low_states_of, worst_states,
};
use crate::solve::{Cut, Limits, Problem, Solution, is_empty};
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
    /// Relative errors in the same way, divided by the number of points of the test, so that all tests have the same weight.
    ByTest(f64),
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
    /// No constants satisfy the stability constraint: the constraints at a few states contradict each other.
    #[error("no constants of {law} are stable at all states of the range")]
    NotStable {
        /// Name of the law.
        law: String,
    },
    /// No search from a number of first guesses ended at constants that satisfy the stability constraint.
    #[error(
        "no stable constants of {law} were found from {starts} first guesses; this does not prove that none exist"
    )]
    NotFound {
        /// Name of the law.
        law: String,
        /// Number of first guesses.
        starts: usize,
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
    /// Names of the free constants whose deviation exceeds their magnitude.
    pub undetermined: Vec<String>,
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
    /// Number of different measured conditions.
    pub conditions: usize,
    /// Norm of the weighted measured values.
    pub norm: f64,
    /// Sum of the weights of all squared errors.
    pub weight: f64,
    /// Other constants whose sum of squares is within 5 % of the best, as values and sum.
    pub others: Vec<(Vec<f64>, f64)>,
    /// Limits of the principal stretches of the range; `None` without a range.
    pub stretches: Option<[f64; 2]>,
    /// Lower bound of the sum of squares of all stable constants, if the search of a law that is linear in its constants ended before the optimum.
    pub bound: Option<f64>,
    /// Number of first guesses of the search for stable constants, and the number of those whose search was given up.
    pub searched: [usize; 2],
}

impl Fit {
    /// The stable constants, or the free constants if they are stable or there is no range.
    pub fn result(&self) -> &Fitted {
        self.stable.as_ref().unwrap_or(&self.free)
    }

    /// Akaike's information criterion with the correction for few points (AICc, Hurvich and Tsai, Biometrika 76 (1989) 297) of the result:
    /// `n ln(S/n) + 2 k + 2 k (k + 1)/(n - k - 1)` with `n` measured conditions, the sum of squares `S`, and `k - 1` free constants. Infinite without
    /// enough points.
    pub fn criterion(&self) -> f64 {
        let conditions = self.conditions as f64;
        let unknown = (self.conditions - self.spare + 1) as f64;
        let left = conditions - unknown - 1.0;
        if left <= 0.0 {
            return f64::INFINITY;
        }
        // Smaller sums of squares are due to rounding.
        let least = (ROUNDING_SHARE * self.norm).powi(2);
        let loss = self.result().loss.max(least).max(f64::MIN_POSITIVE);
        conditions * (loss / conditions).ln()
            + 2.0 * unknown
            + 2.0 * unknown * (unknown + 1.0) / left
    }

    /// Returns true if the optimum is global, because the energy is linear in all constants and the search reached the optimum.
    pub fn is_global(&self) -> bool {
        self.family.is_linear() && self.bound.is_none()
    }
}

/// Largest number of rounds in which states are added: for laws that are linear in their constants, and for each first guess of other laws.
const ROUNDS: usize = 60;
const ROUNDS_OF_START: usize = 15;
/// Largest number of steps of one solve with the stability constraint.
const CONSTRAINED_STEPS: usize = 40;
/// Steps of all solves with the stability constraint after which first guesses that were not searched are given up.
const ALL_STEPS: usize = 1000;
/// First guesses are improved by this number of steps, until a step lowers the sum of squares by less than the fraction; only the best are improved
/// further.
const GUESS_LIMITS: Limits = Limits {
    steps: 40,
    gain: 1e-9,
};
const IMPROVED: usize = 12;
/// Largest ratio of the sum of squares at some of the points to the lowest for which an optimum is improved at all points.
const IMPROVED_RATIO: f64 = 2.0;
/// Number of optima that are improved in any case.
const LEAST_IMPROVED: usize = 3;
/// Largest number of points of each test at which first guesses are improved.
const GUESS_POINTS: usize = 40;
/// Largest number of optima at some of the points that are improved at all points.
const POLISHED: usize = 3;
/// First guesses in each set of bounds with convex terms.
const CONVEX_STARTS: usize = 4;
/// Exponents of a term that is added to a law with one term less.
const ADDED_EXPONENTS: [f64; 2] = [2.0, -2.0];
/// Rounds after which constraints are also added on the segment from a stable point to the solution.
const PLAIN_ROUNDS: usize = 12;
/// Bisections of this segment.
const BISECTIONS: usize = 8;
/// Relative difference of sums of squares that counts as equal.
const OPTIMUM_TOLERANCE: f64 = 1e-4;
/// Largest number of states missed by the samples and found by the proof.
const MISSED: usize = 6;
/// States added in one round.
const ADDED: usize = 6;
/// Fraction of the margin that the worst state must reach.
const LEAST_MARGIN_SHARE: f64 = 0.5;
/// Optima within this fraction of the best are listed.
const SIMILAR: f64 = 0.05;
/// Errors below this fraction of the measured values are rounding errors.
const ROUNDING_SHARE: f64 = 1e-10;
/// Constants this close to a bound, relative to it, are at the bound.
const BOUND_TOLERANCE: f64 = 1e-6;
/// Optima whose constants differ by less than this fraction count as one.
const CONSTANT_TOLERANCE: f64 = 1e-3;
/// Number of free optima that are starting points of a fit with the stability constraint.
const STARTS_WITH_DEMANDS: usize = 4;
/// Number of first guesses of a law with one term less.
const STARTS_OF_SMALLER_LAW: usize = 24;

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

/// Stable constants, the best first, and the limits of the search.
struct Found {
    optima: Vec<Solution>,
    bound: Option<f64>,
    searched: [usize; 2],
}

/// End of a search for stable constants from one first guess.
enum End {
    Stable(Solution),
    /// The sum of squares exceeds the sum of known stable constants.
    Worse,
    /// The search was given up.
    Open,
}

impl Search<'_> {
    fn run(&self) -> Result<Fit, FitError> {
        let free = self.free();
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
            conditions: self.equations.len(),
            norm: self.equations.norm(),
            weight: self.equations.weight,
            others: self.others(&free),
            stretches: None,
            bound: None,
            searched: [0; 2],
        };
        let Some(range) = self.options.range else {
            return Ok(result);
        };
        result.stretches = Some(range.stretches(self.tests, self.family.is_compressible()));
        let is_enough = |worst: &Worst| worst.value >= self.least();
        if result.free.worst.as_ref().is_none_or(is_enough) {
            match prove(&self.numbers(&best.constants), &self.patches) {
                Proof::Refuted { .. } => {}
                proof => {
                    result.proof = Some(proof);
                    return Ok(result);
                }
            }
        }
        let found = match self.family.is_linear() {
            true => self.convex(&result.free)?,
            false => self.several(&free)?,
        };
        result.bound = found.bound;
        result.searched = found.searched;
        // The best optimum without an unstable state.
        for n in 0..found.optima.len() {
            if let Some((best, proof)) = self.proved(found.optima[n].clone()) {
                result.others = self.others(&found.optima[n..]);
                result.proof = Some(proof);
                result.stable = Some(self.fitted(&best));
                return Ok(result);
            }
        }
        Err(FitError::NotConverged {
            law: self.family.name().to_owned(),
        })
    }

    /// Smallest value of a criterion at the worst state.
    fn least(&self) -> f64 {
        LEAST_MARGIN_SHARE * self.options.margin
    }

    /// Optima without the stability constraint. First guesses are improved at some of the points, and the best at all points.
    fn free(&self) -> Vec<Solution> {
        let guesses = self.guesses(self.bounds, self.options.starts.max(1));
        let problem = self.problem();
        if self.family.is_linear() {
            return self.optima(&guesses[..1], &problem);
        }
        let coarse = self.equations.coarse(GUESS_POINTS);
        let first = Problem {
            equations: match coarse.len() >= self.is_free.iter().filter(|own| **own).count() {
                true => &coarse,
                false => self.equations,
            },
            limits: GUESS_LIMITS,
            ..problem
        };
        let starts = self.optima(&guesses, &first);
        let least = starts.first().map_or(0.0, |own| own.loss);
        let best = starts.into_iter().take(IMPROVED).enumerate();
        let best =
            best.filter(|(n, own)| *n < LEAST_IMPROVED || own.loss <= IMPROVED_RATIO * least);
        let best: Vec<Vec<f64>> = best.map(|(_, own)| own.constants).collect();
        self.optima(&best, &problem)
    }

    /// Proof of stable constants. A state that the samples missed is added as a constraint; `None` if the law stays unstable.
    fn proved(&self, mut best: Solution) -> Option<(Solution, Proof)> {
        let mut missed = Vec::new();
        loop {
            match prove(&self.numbers(&best.constants), &self.patches) {
                Proof::Refuted { worst } if missed.len() < MISSED => missed.push(Cut::from(worst)),
                Proof::Refuted { .. } => return None,
                proof => return Some((best, proof)),
            }
            if self.family.is_linear() {
                best = self.cutting(missed.clone()).ok()?.0;
                continue;
            }
            let mut cuts = missed.clone();
            let mut steps = 0;
            let start = &best.constants;
            match self.demanded(start, &mut cuts, f64::INFINITY, &mut steps) {
                End::Stable(found) => best = found,
                End::Worse | End::Open => return None,
            }
        }
    }

    /// Optimum of a law that is linear in its constants, which is a convex problem.
    fn convex(&self, free: &Fitted) -> Result<Found, FitError> {
        let (best, bound) = self.cutting(Vec::new())?;
        let bound = bound.map(|own| own.max(free.loss));
        Ok(Found {
            optima: vec![best],
            bound,
            searched: [1, 0],
        })
    }

    /// Gradient of the shear modulus of a linear law with respect to the constants.
    fn shear_gradient(&self) -> DVector<f64> {
        let mut gradient = DVector::zeros(self.bounds.len());
        let unit = vec![1.0; self.bounds.len()];
        for term in self.family.terms() {
            let own = Family::moduli_of(term, &unit, [0.0; 3]).shear_modulus();
            gradient[term.modulus] += own.value;
        }
        gradient
    }

    /// Best constants of a linear law that are stable at all states, by cutting planes, and a lower bound of the sum of squares if the search ended
    /// before the optimum.
    fn cutting(&self, mut cuts: Vec<Cut>) -> Result<(Solution, Option<f64>), FitError> {
        let law = self.family.name().to_owned();
        let equations = self.equations.reduced(self.family);
        let problem = Problem {
            equations: &equations,
            ..self.problem()
        };
        // Constraints at a coarse grid keep the first constants close to the stable optimum.
        let compressible = self.family.is_compressible();
        cuts.extend(fence(&self.patches, &self.options.criteria, compressible));
        let mut gradients = self.gradients(&cuts);
        let stable = self.convex_terms(&equations);
        let start = vec![0.0; self.bounds.len()];
        let mut last: Option<Solution> = None;
        let mut inside: Option<Solution> = None;
        for round in 0..ROUNDS {
            checkpoint();
            let solved = Problem {
                cuts: &cuts,
                gradients: &gradients,
                ..problem
            }
            .solve(&start);
            if (round == 0 || solved.is_none()) && is_empty(&self.shear_gradient(), &gradients) {
                return Err(FitError::NotStable { law });
            }
            let Some(found) = solved else { break };
            let numbers = self.numbers(&found.constants);
            // Constraints are cheap: many are added in each round, so that fewer rounds are needed.
            let mut added = low_states(&numbers, &self.patches, self.least());
            if added.iter().all(|own| own.value >= self.least()) {
                return Ok((found, None));
            }
            if let (Some(stable), true) = (&stable, round >= PLAIN_ROUNDS) {
                // Constraints where the segment from stable constants leaves the stable set cut deeper.
                let from = inside.as_ref().unwrap_or(stable);
                let (own, beyond) = self.last_stable(&equations, from, &found);
                added.extend(beyond);
                let is_better = |other: &Solution| own.loss < other.loss;
                if inside.as_ref().is_none_or(is_better) {
                    inside = Some(own);
                }
                let gap = |own: &Solution| own.loss <= found.loss * (1.0 + OPTIMUM_TOLERANCE);
                if let Some(own) = inside.take_if(|own| gap(own)) {
                    return Ok((self.active(own, &cuts, &gradients), None));
                }
            }
            let more: Vec<Cut> = added.into_iter().map(Cut::from).collect();
            gradients.extend(self.gradients(&more));
            cuts.extend(more);
            last = Some(found);
        }
        let bound = last.as_ref().map(|own| own.loss);
        if inside.is_none()
            && let (Some(last), Some(stable)) = (&last, &stable)
        {
            inside = Some(self.last_stable(&equations, stable, last).0);
        }
        match inside.or(stable) {
            Some(own) => Ok((self.active(own, &cuts, &gradients), bound.or(Some(0.0)))),
            None => Err(FitError::NotFound { law, starts: 1 }),
        }
    }

    fn gradients(&self, cuts: &[Cut]) -> Vec<DVector<f64>> {
        Problem {
            cuts,
            ..self.problem()
        }
        .gradients()
    }

    /// Solution with its active constraints.
    fn active(&self, mut own: Solution, cuts: &[Cut], gradients: &[DVector<f64>]) -> Solution {
        own.active = Problem {
            cuts,
            gradients,
            ..self.problem()
        }
        .active(&own.constants);
        own
    }

    /// Best constants of a linear law with convex terms only; `None` if they are not stable or not admissible.
    fn convex_terms(&self, equations: &Equations) -> Option<Solution> {
        let bounds = self.within(self.family.convex_bounds().first()?)?;
        let found = Problem {
            equations,
            bounds: &bounds,
            ..self.problem()
        }
        .solve(&vec![0.0; bounds.len()])?;
        self.is_stable(&found.constants).then_some(found)
    }

    fn is_stable(&self, constants: &[f64]) -> bool {
        let law = self.numbers(constants);
        let worst = worst_states(&law, &self.patches);
        law.shear_modulus() > 0.0 && worst.iter().all(|own| own.value >= self.least())
    }

    /// Last stable point of the segment from stable to unstable constants of a linear law, and the states that limit it.
    fn last_stable(
        &self,
        equations: &Equations,
        stable: &Solution,
        unstable: &Solution,
    ) -> (Solution, Vec<Worst>) {
        let at = |t: f64| -> Vec<f64> {
            let pairs = stable.constants.iter().zip(&unstable.constants);
            pairs.map(|(a, b)| a + t * (b - a)).collect()
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            checkpoint();
            let middle = 0.5 * (low + high);
            match self.is_stable(&at(middle)) {
                true => low = middle,
                false => high = middle,
            }
        }
        let beyond = at(high);
        let mut states = worst_states(&self.numbers(&beyond), &self.patches);
        states.truncate(ADDED);
        let constants = at(low);
        let own = Solution {
            loss: equations.errors(self.family, &constants).0.norm_squared(),
            constants,
            active: Vec::new(),
            steps: 0,
        };
        (own, states)
    }

    /// Bounds within the bounds of the user; `None` if no values satisfy both.
    fn within(&self, bounds: &[[f64; 2]]) -> Option<Vec<[f64; 2]>> {
        let pairs = bounds.iter().zip(self.bounds);
        let both = pairs.map(|([a, b], [low, high])| [a.max(*low), b.min(*high)]);
        let both: Vec<[f64; 2]> = both.collect();
        both.iter().all(|[low, high]| low <= high).then_some(both)
    }

    /// Stable constants of laws that are not linear in their constants. The search uses some of many points, and the best optima all points.
    fn several(&self, free: &[Solution]) -> Result<Found, FitError> {
        let coarse = self.equations.coarse(GUESS_POINTS);
        let unknown = self.is_free.iter().filter(|own| **own).count();
        let part = coarse.len();
        if part == self.equations.len() || part <= unknown {
            return self.searched(free);
        }
        let mut found = Search {
            equations: &coarse,
            patches: self.patches.clone(),
            ..*self
        }
        .searched(free)?;
        let mut polished = Vec::new();
        for own in found.optima.iter().take(POLISHED) {
            let mut steps = 0;
            let mut cuts = Vec::new();
            let end = self.demanded(&own.constants, &mut cuts, f64::INFINITY, &mut steps);
            if let End::Stable(own) = end {
                polished.push(own);
            }
        }
        found.optima = self.distinct(polished);
        match found.optima.is_empty() {
            true => self.searched(free),
            false => Ok(found),
        }
    }

    /// Stable constants from several first guesses.
    fn searched(&self, free: &[Solution]) -> Result<Found, FitError> {
        let mut steps = 0;
        let mut cuts: Vec<Cut> = Vec::new();
        let mut found: Vec<Solution> = Vec::new();
        let mut given_up = 0;
        let starts = self.starts_with_constraint(free);
        // Stable first guesses are results if no search improves them.
        let stable = starts.iter().filter(|own| self.is_stable(own));
        found.extend(stable.filter_map(|start| {
            let problem = self.problem();
            let loss = self.equations.errors(self.family, start).0.norm_squared();
            let is_admissible = problem
                .bounds
                .iter()
                .zip(start)
                .all(|([low, high], own)| (low..=high).contains(&own));
            (is_admissible && loss.is_finite()).then(|| Solution {
                constants: start.clone(),
                loss,
                active: Vec::new(),
                steps: 0,
            })
        }));
        for start in &starts {
            let least = found.iter().map(|own| own.loss);
            let limit = (1.0 + SIMILAR) * least.fold(f64::INFINITY, f64::min);
            let mut own = cuts.clone();
            match self.demanded(start, &mut own, limit, &mut steps) {
                End::Stable(solution) => {
                    // Constraints that are active at an optimum are likely to be active at others.
                    let law = self.numbers(&solution.constants);
                    cuts.extend(
                        worst_states(&law, &self.patches)
                            .into_iter()
                            .take(ADDED)
                            .map(Cut::from),
                    );
                    found.push(solution);
                }
                End::Worse => {}
                End::Open => given_up += 1,
            }
        }
        let optima = self.distinct(found);
        if optima.is_empty() {
            return Err(FitError::NotFound {
                law: self.family.name().to_owned(),
                starts: starts.len(),
            });
        }
        Ok(Found {
            optima,
            bound: None,
            searched: [starts.len(), given_up],
        })
    }

    /// First guesses of the search for stable constants: optima with convex terms only, stable constants of the law with one term less, free optima and
    /// general first guesses.
    fn starts_with_constraint(&self, free: &[Solution]) -> Vec<Vec<f64>> {
        let mut starts = Vec::new();
        for bounds in self.family.convex_bounds() {
            let Some(bounds) = self.within(&bounds) else {
                continue;
            };
            let problem = Problem {
                bounds: &bounds,
                ..self.problem()
            };
            let own = self.optima(&self.guesses(&bounds, CONVEX_STARTS), &problem);
            starts.extend(own.into_iter().take(1));
        }
        starts.sort_by(|a, b| a.loss.total_cmp(&b.loss));
        let mut starts: Vec<Vec<f64>> = starts.into_iter().map(|own| own.constants).collect();
        if let Some(smaller) = self.family.smaller() {
            let has = |name: &str| smaller.constants().iter().any(|own| own.name == name);
            let mut options = self.options.clone();
            options.fixed.retain(|(name, _)| has(name));
            options.bounds.retain(|(name, _)| has(name));
            options.starts = options.starts.min(STARTS_OF_SMALLER_LAW);
            if let Ok(own) = fit(self.tests, &smaller, &options) {
                let known = &own.result().constants;
                let rest = self.bounds.len() - known.len();
                for exponent in ADDED_EXPONENTS {
                    let mut start = known.clone();
                    let added = [0.0, exponent, 0.5];
                    start.extend(added.into_iter().take(rest));
                    starts.push(start);
                }
            }
        }
        let optima = free.iter().take(STARTS_WITH_DEMANDS);
        starts.extend(optima.map(|own| own.constants.clone()));
        // The search is cheap for few constants, and at exponents near 1 and -1 strong ellipticity is often just satisfied.
        let count = STARTS_WITH_DEMANDS.max(STARTS_OF_SMALLER_LAW / self.bounds.len());
        starts.extend(self.guesses(self.bounds, count));
        for sign in [1.0, -1.0] {
            let mut own = starts[starts.len() - 1].clone();
            let mut sign = sign;
            for term in self.family.terms() {
                if let Some(n) = term.shapes.first().filter(|n| self.family.is_exponent(**n)) {
                    own[*n] = sign;
                    sign = -1.0 - sign * 0.1;
                }
            }
            starts.push(own);
        }
        starts
    }

    fn problem(&self) -> Problem<'_> {
        Problem {
            family: self.family,
            equations: self.equations,
            cuts: &[],
            margin: self.options.margin,
            bounds: self.bounds,
            gradients: &[],
            limits: Limits::default(),
        }
    }

    fn numbers<'b>(&'b self, constants: &'b [f64]) -> Numbers<'b> {
        Numbers {
            family: self.family,
            constants,
            criteria: &self.options.criteria,
        }
    }

    /// First guesses: points of Halton's sequence in the ranges of guesses, within bounds.
    fn guesses(&self, bounds: &[[f64; 2]], count: usize) -> Vec<Vec<f64>> {
        const BASES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
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
            let constants = self.family.constants().iter().zip(bounds).enumerate();
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

    /// Distinct optima of a problem from several starts, the best first.
    fn optima(&self, starts: &[Vec<f64>], problem: &Problem<'_>) -> Vec<Solution> {
        let scope = Scope::current();
        let all = starts
            .par_iter()
            .filter_map(|start| scope.run(|| problem.solve(start)));
        self.distinct(all.collect())
    }

    /// Distinct solutions, the best first.
    fn distinct(&self, mut all: Vec<Solution>) -> Vec<Solution> {
        all.retain(|own| own.loss.is_finite());
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

    /// Search for constants that satisfy the stability constraint in the whole range: states are added until it holds everywhere. Ends if the sum of
    /// squares exceeds a limit; `steps` counts the steps of all searches.
    fn demanded(&self, start: &[f64], cuts: &mut Vec<Cut>, limit: f64, steps: &mut usize) -> End {
        let mut constants = start.to_vec();
        for _ in 0..ROUNDS_OF_START {
            checkpoint();
            if *steps > ALL_STEPS {
                return End::Open;
            }
            let problem = Problem {
                cuts,
                limits: Limits {
                    steps: CONSTRAINED_STEPS,
                    ..Limits::default()
                },
                ..self.problem()
            };
            let Some(found) = problem.solve(&constants) else {
                return End::Open;
            };
            *steps += found.steps;
            if found.loss > limit {
                return End::Worse;
            }
            let law = self.numbers(&found.constants);
            let lowest = |sampling| {
                let mut worst = low_states_of(&law, &self.patches, f64::NEG_INFINITY, sampling);
                worst.retain(|own| own.value < self.least());
                worst
            };
            let mut worst = lowest(Sampling::QUARTER);
            if worst.is_empty() {
                worst = lowest(Sampling::ALL_POINTS);
            }
            if worst.is_empty() {
                return End::Stable(found);
            }
            worst.truncate(ADDED);
            cuts.extend(worst.into_iter().map(Cut::from));
            constants = found.constants;
        }
        End::Open
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
        let uncertainty = Uncertainty::new(
            self.family,
            self.equations,
            &solution.constants,
            &varies,
            &solution.active,
        );
        let is_exact = solution.loss.sqrt() <= ROUNDING_SHARE * self.equations.norm();
        let is_open = |n: &usize| {
            let deviation = uncertainty.deviations[*n];
            let magnitude = solution.constants[*n].abs();
            varies[*n] && !is_exact && (deviation.is_nan() || deviation > magnitude)
        };
        let has_spare = self.equations.len() > varies.iter().filter(|own| **own).count();
        let open = (0..varies.len()).filter(|n| has_spare && is_open(n));
        let name = |n: usize| self.family.constants()[n].name.clone();
        let undetermined = open.map(name).collect();
        Fitted {
            undetermined,
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
            uncertainty,
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
