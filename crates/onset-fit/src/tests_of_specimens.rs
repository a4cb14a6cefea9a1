//! Measured data: stretches and nominal stresses of homogeneous specimens.

use crate::fit::Weights;
use crate::range::Mode;
use nalgebra::{DMatrix, DVector};
use onset::real::{Dual, Real};
use serde::Serialize;

use crate::family::Family;

/// Measured point of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Stretch along the load; the amount of shear `gamma` in simple shear, the volume ratio `J` in a volumetric test.
    pub stretch: f64,
    /// Lateral stretch along axis 2 (and 3, if they are equal), for compressible laws. In equibiaxial and planar tests it is the stretch through the
    /// thickness. `None` if it was not measured.
    pub lateral: Option<f64>,
    /// Nominal stress along the load, or pressure in a volumetric test; units of stress.
    pub stress: f64,
}

/// Measured points of a specimen in one loading.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// Name of the test in answers.
    pub name: String,
    /// Loading of the specimen.
    pub mode: Mode,
    /// Measured points in any order.
    pub points: Vec<Point>,
    /// Weight of the squared errors of this test.
    pub weight: f64,
}

/// Errors of a fitted law at the points of a test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Misfit {
    /// Name of the test.
    pub test: String,
    /// Root mean square of the errors relative to the measured stress.
    pub relative: f64,
    /// Root mean square of the errors; units of stress.
    pub absolute: f64,
    /// Computed stresses in the order of the points; units of stress.
    pub stresses: Vec<f64>,
}

/// Condition on a law from a measured point: a combination of the principal Kirchhoff stresses `2 e_i dW/de_i`.
#[derive(Clone, Copy, Debug)]
struct Equation {
    /// Index of the test and of the point.
    place: (usize, usize),
    logs: [f64; 3],
    factors: [f64; 3],
    measured: f64,
    /// Factor of the error in the sum of squares.
    scale: f64,
}

/// All conditions of all tests.
#[derive(Clone, Debug)]
pub(crate) struct Equations {
    all: Vec<Equation>,
    /// Sum of the weights of all squared errors.
    pub weight: f64,
    /// For a law that is linear in its constants: upper triangular matrix `R` and vector `d` with the sum of squares `|R c - d|^2`, which replace the
    /// conditions.
    reduced: Option<(DMatrix<f64>, DVector<f64>)>,
}

impl Equations {
    /// Conditions of tests on a law. Points in the reference configuration carry no information and are skipped.
    pub fn new(tests: &[Test], compressible: bool, weights: Weights) -> Self {
        let mut all = Vec::new();
        let mut weight = 0.0;
        let used = tests.iter().filter(|test| test.mode != Mode::Volumetric);
        let points: usize = used.clone().map(|test| test.points.len()).sum();
        let mean = points as f64 / used.count().max(1) as f64;
        for (t, test) in tests.iter().enumerate() {
            let magnitudes = test.points.iter().map(|point| point.stress.abs());
            let largest = magnitudes.fold(0.0, f64::max);
            let part = match weights {
                Weights::ByTest(_) => test.weight * mean / test.points.len() as f64,
                Weights::Relative(_) | Weights::Absolute => test.weight,
            };
            for (p, point) in test.points.iter().enumerate() {
                let unit = match weights {
                    Weights::Relative(floor) | Weights::ByTest(floor) => {
                        point.stress.abs().max(floor * largest)
                    }
                    Weights::Absolute => 1.0,
                };
                let scale = part.sqrt() / unit;
                let at = |logs: [f64; 3], factors: [f64; 3], measured| Equation {
                    place: (t, p),
                    logs,
                    factors,
                    measured,
                    scale,
                };
                let h = point.stretch.ln();
                let inverse = point.stretch.recip();
                let across = point.lateral.map_or(0.0, f64::ln);
                let first = match (test.mode, compressible) {
                    (Mode::Volumetric, _) => continue,
                    (Mode::SimpleShear, _) | (_, false) => {
                        let slope = test.mode.nominal(point.stretch);
                        let logs = test.mode.logs(point.stretch);
                        at(logs, [slope, 0.0, -slope], point.stress)
                    }
                    (Mode::Uniaxial, true) => {
                        at([h, across, across], [inverse, 0.0, 0.0], point.stress)
                    }
                    (Mode::Equibiaxial, true) => {
                        at([h, h, across], [inverse, 0.0, 0.0], point.stress)
                    }
                    (Mode::Planar, true) => at([h, 0.0, across], [inverse, 0.0, 0.0], point.stress),
                };
                all.push(first);
                weight += part;
                if compressible && test.mode != Mode::SimpleShear {
                    let factors = [0.0, 0.0, (-across).exp()];
                    all.push(Equation {
                        factors,
                        measured: 0.0,
                        ..first
                    });
                    weight += part;
                }
            }
        }
        Self {
            all,
            weight,
            reduced: None,
        }
    }

    /// Conditions with the same sum of squares for a law that is linear in its constants; their number exceeds the number of constants by one at most.
    pub fn reduced(&self, family: &Family) -> Self {
        let count = family.constants().len();
        if !family.is_linear() || self.all.len() <= count + 1 {
            return self.clone();
        }
        let (errors, jacobian) = self.errors(family, &vec![0.0; count]);
        let rows = errors.len();
        // The last column of the triangle contains the errors at zero.
        let matrix = DMatrix::from_fn(rows, count + 1, |i, j| match j < count {
            true => jacobian[(i, j)],
            false => -errors[i],
        });
        let upper = matrix.qr().r();
        Self {
            all: Vec::new(),
            weight: self.weight,
            reduced: Some((
                upper.columns(0, count).into_owned(),
                upper.column(count).into_owned(),
            )),
        }
    }

    /// Conditions at `count` points of each test at most, evenly distributed, whose sum of squares approximates the sum of all conditions.
    pub fn coarse(&self, count: usize) -> Self {
        let tests = self.all.iter().map(|own| own.place.0 + 1).max();
        let mut points = vec![0; tests.unwrap_or(0)];
        for own in &self.all {
            points[own.place.0] = points[own.place.0].max(own.place.1 + 1);
        }
        let kept = self.all.iter().filter_map(|own| {
            let part = points[own.place.0].div_ceil(count);
            (own.place.1 % part == part / 2).then(|| Equation {
                scale: own.scale * (part as f64).sqrt(),
                ..*own
            })
        });
        Self {
            all: kept.collect(),
            weight: self.weight,
            reduced: None,
        }
    }

    /// Number of distinct conditions of all tests; several points of one state count once.
    pub fn len(&self) -> usize {
        let bits = |own: &Equation| {
            let [a, b, c] = own.logs.map(f64::to_bits);
            let [d, e, f] = own.factors.map(f64::to_bits);
            [a, b, c, d, e, f]
        };
        let mut all: Vec<_> = self.all.iter().map(bits).collect();
        all.sort_unstable();
        all.dedup();
        all.len()
    }

    /// Norm of the scaled measured values.
    pub fn norm(&self) -> f64 {
        let squares = self
            .all
            .iter()
            .map(|own| (own.scale * own.measured).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// Scaled errors of a law whose moduli are zero.
    pub fn at_rest(&self) -> DVector<f64> {
        match &self.reduced {
            Some((_, right)) => -right,
            None => DVector::from_fn(self.all.len(), |n, _| {
                -self.all[n].scale * self.all[n].measured
            }),
        }
    }

    /// Scaled stresses of the terms of a law for a unit modulus, each followed by its derivatives with respect to the further constants of the term, as
    /// columns. They do not depend on the moduli.
    pub fn terms(&self, family: &Family, constants: &[f64]) -> DMatrix<f64> {
        let columns: usize = family.terms().iter().map(|own| 1 + own.shapes.len()).sum();
        let mut terms = DMatrix::zeros(self.all.len(), columns);
        let mut column = 0;
        for term in family.terms() {
            let shapes = Family::variable_shapes(term, constants);
            for (row, own) in self.all.iter().enumerate() {
                let stresses = Family::stresses_of(term, shapes, own.logs);
                let stress = (0..3).fold(Dual::constant(0.0), |sum, i| {
                    sum + stresses[i] * own.factors[i]
                });
                terms[(row, column)] = own.scale * stress.value;
                for n in 0..term.shapes.len() {
                    terms[(row, column + 1 + n)] = own.scale * stress.gradient[n];
                }
            }
            column += 1 + term.shapes.len();
        }
        terms
    }

    /// Scaled errors of a law, and their derivatives with respect to its constants, from the stresses of its [`terms`](Self::terms).
    pub fn errors_of(
        &self,
        family: &Family,
        terms: &DMatrix<f64>,
        constants: &[f64],
    ) -> (DVector<f64>, DMatrix<f64>) {
        let mut errors = self.at_rest();
        let mut jacobian = DMatrix::zeros(errors.len(), constants.len());
        let mut column = 0;
        for term in family.terms() {
            let modulus = constants[term.modulus];
            let stress = terms.column(column);
            errors.axpy(modulus, &stress, 1.0);
            let mut slope = jacobian.column_mut(term.modulus);
            slope += stress;
            for (n, index) in term.shapes.iter().enumerate() {
                let mut slope = jacobian.column_mut(*index);
                slope.axpy(modulus, &terms.column(column + 1 + n), 1.0);
            }
            column += 1 + term.shapes.len();
        }
        (errors, jacobian)
    }

    /// Scaled errors of a law, and their derivatives with respect to its constants.
    pub fn errors(&self, family: &Family, constants: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        match &self.reduced {
            Some((upper, right)) => {
                let errors = upper * DVector::from_column_slice(constants) - right;
                (errors, upper.clone())
            }
            None => self.errors_of(family, &self.terms(family, constants), constants),
        }
    }

    /// Errors of a law by test.
    pub fn misfits(&self, tests: &[Test], family: &Family, constants: &[f64]) -> Vec<Misfit> {
        let (errors, _) = self.errors(family, constants);
        let of = |(t, test): (usize, &Test)| {
            let mut stresses = vec![f64::NAN; test.points.len()];
            let own = self.all.iter().zip(errors.iter());
            for (equation, error) in own.filter(|(own, _)| own.place.0 == t) {
                let stress = &mut stresses[equation.place.1];
                if stress.is_nan() {
                    *stress = equation.measured + error / equation.scale;
                }
            }
            let pairs: Vec<(f64, f64)> = test
                .points
                .iter()
                .zip(&stresses)
                .filter(|(_, own)| own.is_finite())
                .map(|(point, own)| (own - point.stress, point.stress))
                .collect();
            let mean = |of: &dyn Fn(f64, f64) -> f64| {
                let sum: f64 = pairs
                    .iter()
                    .map(|(error, stress)| of(*error, *stress).powi(2))
                    .sum();
                (sum / pairs.len().max(1) as f64).sqrt()
            };
            Misfit {
                test: test.name.clone(),
                relative: mean(&|error, stress| error / stress),
                absolute: mean(&|error, _| error),
                stresses,
            }
        };
        tests.iter().enumerate().map(of).collect()
    }
}
