//! Equations of a loading path along its fixed axes, and their integration.

use super::integration::{Stop, integrate};
use super::path::{Bands, Course, End, Loading, PathPoint, Strains};
use super::{Criterion, Flow, FlowLaw, PlasticityError, RateModuli};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Largest elastic strain tried in the search for yield.
const ELASTIC_STRAIN: f64 = 1.0;

/// Relative error of a step of the integration.
const ACCURACY: f64 = 1e-12;

/// Strains, stresses (Kirchhoff at finite strain) along the axes, and internal variables.
pub(super) type Point = SVector<f64, 9>;

/// Loading of a law, as equations along the axes.
pub(super) struct Walk<'a> {
    law: &'a dyn FlowLaw,
    loading: &'a Loading,
    course: Course,
    /// Strain of the confined state, along every axis.
    initial: f64,
}

impl<'a> Walk<'a> {
    pub(super) fn new(law: &'a dyn FlowLaw, loading: &'a Loading) -> Result<Self, PlasticityError> {
        let course = Course::new(loading)?;
        let strength = law.strength();
        // For a smaller strength the elastic strains are lost in the rounding of the strains of the path.
        PlasticityError::require(
            strength >= 1e-10 * law.elasticity().shear,
            "strength",
            strength,
            "at least 1e-10 of the shear modulus",
        )?;
        let mut walk = Self {
            law,
            loading,
            course,
            initial: 0.0,
        };
        walk.initial = walk.confined_strain()?;
        Ok(walk)
    }

    fn is_finite_strain(&self) -> bool {
        self.loading.strains == Strains::Finite
    }

    /// Strain with `3 K e = -p`, at finite strain `3 K e = -p exp(3 e)`.
    fn confined_strain(&self) -> Result<f64, PlasticityError> {
        let (pressure, bulk) = (self.loading.confinement, self.law.elasticity().bulk);
        let mut strain = -pressure / (3.0 * bulk);
        if self.is_finite_strain() {
            // The left-hand side increases faster than the right-hand side decreases, so Newton's method from -p/3K converges monotonically.
            for _ in 0..100 {
                let volume = (3.0 * strain).exp();
                let rest = 3.0 * bulk * strain + pressure * volume;
                strain -= rest / (3.0 * bulk + 3.0 * pressure * volume);
            }
        }
        let stress = Vector3::repeat(3.0 * bulk * strain);
        if strain.is_finite() && self.excess_at_start(&stress) < 0.0 {
            Ok(strain)
        } else {
            Err(PlasticityError::Confinement {
                confinement: pressure,
            })
        }
    }

    fn excess_at_start(&self, stress: &Vector3<f64>) -> f64 {
        self.law.excess(stress, 0.0, &self.law.start(stress).0)
    }

    /// Elastic state at a driving strain.
    fn elastic(&self, driving: f64) -> Point {
        let elasticity = self.law.elasticity();
        let mut strain = self
            .course
            .direction()
            .map(|rate| self.initial + driving * rate);
        let mut stress = elasticity.stress(&strain);
        for _ in 0..if self.is_finite_strain() { 30 } else { 2 } {
            let mut matrix = Matrix3::identity();
            let mut rest = Vector3::zeros();
            let pressure = self.pressure(&strain);
            for i in (0..3).filter(|i| self.course.prescribed[*i].is_none()) {
                rest[i] = stress[i] + pressure;
                for j in 0..3 {
                    let volume = if self.is_finite_strain() {
                        pressure
                    } else {
                        0.0
                    };
                    matrix[(i, j)] = elasticity.normal()[(i, j)] + volume;
                }
            }
            strain -= matrix.lu().solve(&rest).unwrap_or_else(Vector3::zeros);
            stress = elasticity.stress(&strain);
        }
        join(&strain, &stress, &self.law.start(&stress).0)
    }

    /// Pressure of constant lateral stresses: `p`, in Kirchhoff stress `p J`.
    fn pressure(&self, strain: &Vector3<f64>) -> f64 {
        let volume = if self.is_finite_strain() {
            strain.sum().exp()
        } else {
            1.0
        };
        self.loading.confinement * volume
    }

    /// State at first yield.
    pub(super) fn first_yield(&self) -> Result<Point, PlasticityError> {
        let excess = |driving: f64| self.excess_at_start(&split(&self.elastic(driving)).1);
        let mut high = 1e-3 * self.law.strength() / self.law.elasticity().shear;
        let mut low = 0.0;
        while excess(high) < 0.0 {
            (low, high) = (high, 1.5 * high);
            if high > ELASTIC_STRAIN {
                return Err(PlasticityError::NeverYields {
                    strain: ELASTIC_STRAIN,
                });
            }
        }
        Ok(self.elastic(bisect(low, high, |driving| excess(driving) < 0.0)))
    }

    /// Rates per slip of strain, stress and internal variables during flow.
    fn rates(&self, y: &Point, slip: f64) -> Result<Point, End> {
        let (strain, _) = split(y);
        let flow = self.flow(y, slip)?;
        let elasticity = &flow.elasticity;
        let stiffness = flow.hardening + flow.per_slip * flow.relaxation();
        if stiffness.is_nan() || stiffness <= 0.0 {
            return Err(End::TurnsBack);
        }
        let shear = elasticity.shear;
        let loading = elasticity.stress(&flow.normal);
        let relaxation = elasticity.stress(&flow.direction) * flow.per_slip;
        let pressure = if self.is_finite_strain() {
            self.pressure(&strain)
        } else {
            0.0
        };
        // The unknowns are three strain rates and the rate of the driving strain. Q:C:e' = h m + m Q:C:P is the condition of flow.
        let mut matrix = SMatrix::<f64, 4, 4>::zeros();
        let mut right = SVector::<f64, 4>::zeros();
        for i in 0..3 {
            match self.course.prescribed[i] {
                Some(ratio) => {
                    matrix[(i, i)] = shear;
                    matrix[(i, 3)] = -shear * ratio;
                }
                None => {
                    for j in 0..3 {
                        matrix[(i, j)] = elasticity.normal()[(i, j)] + pressure;
                    }
                    right[i] = relaxation[i];
                }
            }
            matrix[(3, i)] = loading[i];
        }
        right[3] = stiffness;
        let solution = matrix.lu().solve(&right).ok_or(End::TurnsBack)?;
        if !(solution[3] > 0.0 && solution.iter().all(|rate| rate.is_finite())) {
            return Err(End::TurnsBack);
        }
        let strain_rate = solution.fixed_rows::<3>(0).into_owned();
        Ok(join(
            &strain_rate,
            &(elasticity.stress(&strain_rate) - relaxation),
            &flow.internal,
        ))
    }

    /// Flow of a state, or the reason why it is undefined.
    pub(super) fn flow(&self, y: &Point, slip: f64) -> Result<Flow, End> {
        let internal = y.fixed_rows::<3>(6).into_owned();
        let flow = self.law.flow(&split(y).1, slip, &internal);
        flow.map_err(|error| match error {
            PlasticityError::Exhausted { .. } => End::Exhausted,
            PlasticityError::Corner => End::Corner,
            _ => End::Apex,
        })
    }

    /// Integrates the path from one slip to another.
    pub(super) fn advance(&self, start: &Point, from: f64, to: f64) -> Result<Point, End> {
        // Errors are scaled by the strain of first yield, the strength, and the magnitudes of the internal variables given by the law.
        let strength = self.law.strength();
        let size = join(
            &Vector3::repeat(strength / self.law.elasticity().shear),
            &Vector3::repeat(strength),
            &self.law.start(&split(start).1).1,
        );
        let rates = |y: &Point, slip: f64| self.rates(y, slip);
        integrate(start, [from, to], |_| size, ACCURACY, rates).map_err(|stopped| {
            match stopped.why {
                Stop::Rates(end) => end,
                Stop::TooManySteps => End::TooStiff,
            }
        })
    }

    /// State of the path with its critical moduli.
    pub(super) fn point(&self, y: &Point, slip: f64) -> Result<PathPoint, End> {
        let (strain, stress) = split(y);
        let flow = self.flow(y, slip)?;
        if flow.modulus() + flow.relaxation() <= 0.0 {
            return Err(End::TurnsBack);
        }
        let told = |error| match error {
            PlasticityError::NoDeviator => End::Apex,
            _ => End::ElasticNotElliptic,
        };
        let bulk = RateModuli::of(&flow, &stress, Matrix3::identity(), self.is_finite_strain());
        let moduli = match self.loading.bands {
            Bands::Bulk => bulk,
            Bands::Sheet => bulk.in_sheet(),
        };
        let volume = if self.is_finite_strain() {
            strain.sum().exp()
        } else {
            1.0
        };
        Ok(PathPoint {
            slip,
            strain: strain.map(|strain| strain - self.initial).into(),
            stress: (stress / volume).into(),
            modulus: flow.modulus(),
            ellipticity: moduli.critical(Criterion::Ellipticity).map_err(told)?,
            strong_ellipticity: moduli
                .critical(Criterion::StrongEllipticity)
                .map_err(told)?,
            moduli,
        })
    }

    /// First state beyond the point between two slips where the modulus falls to the critical modulus.
    pub(super) fn crossing(
        &self,
        y: &Point,
        from: f64,
        to: f64,
        criterion: Criterion,
    ) -> Option<PathPoint> {
        let at = |slip: f64| {
            let reached = self.advance(y, from, slip).ok()?;
            self.point(&reached, slip).ok()
        };
        let holds = |slip: f64| at(slip).is_some_and(|point| point.margin(criterion) > 0.0);
        at(bisect(from, to, holds))
    }
}

fn join(strain: &Vector3<f64>, stress: &Vector3<f64>, internal: &Vector3<f64>) -> Point {
    Point::from_fn(|i, _| [strain, stress, internal][i / 3][i % 3])
}

/// Strains and stresses of a point.
fn split(y: &Point) -> (Vector3<f64>, Vector3<f64>) {
    (
        y.fixed_rows::<3>(0).into_owned(),
        y.fixed_rows::<3>(3).into_owned(),
    )
}

/// Bisects an interval for the end of the initial part in which a predicate holds. Returns the first number beyond it.
pub(super) fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
