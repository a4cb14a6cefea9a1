//! The equations of a loading path along its fixed axes, and their integration.

use super::integration::{Stop, integrate};
use super::path::{Bands, End, Load, Loading, LoadingPath, PathPoint, Strains};
use super::{Criterion, DruckerPrager, PlasticityError, RateModuli};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Largest elastic strain that is tried to reach yield.
const ELASTIC_STRAIN: f64 = 1.0;

/// Relative error admitted to a step of the integration.
const ACCURACY: f64 = 1e-12;

/// Strains and stresses (Kirchhoff at finite strain) along the axes.
type Point = SVector<f64, 6>;

/// A loading of a law, as equations along the axes.
pub(super) struct Walk<'a> {
    law: &'a DruckerPrager,
    loading: &'a Loading,
    /// Rate of strain by that of the driving strain where strain is prescribed, nothing where stress is.
    prescribed: [Option<f64>; 3],
    /// The strain of the confined state, along every axis.
    initial: f64,
}

impl<'a> Walk<'a> {
    pub(super) fn new(
        law: &'a DruckerPrager,
        loading: &'a Loading,
    ) -> Result<Self, PlasticityError> {
        let require = PlasticityError::require;
        let (confinement, slip) = (loading.confinement, loading.slip);
        require(
            confinement >= 0.0,
            "confinement",
            confinement,
            "zero or a positive pressure",
        )?;
        require(slip > 0.0, "slip", slip, "a positive plastic shear strain")?;
        let strength = law.hardening().strength(0.0);
        // Below this, elastic strains are lost to rounding beside those of the path.
        require(
            strength >= 1e-10 * law.shear_modulus(),
            "strength",
            strength,
            "at least 1e-10 of the shear modulus",
        )?;
        let sense = match (loading.path, loading.load) {
            (LoadingPath::TriaxialCompression, _) | (_, Load::Compression) => -1.0,
            (_, Load::Tension) => 1.0,
        };
        let prescribed = match loading.path {
            LoadingPath::UniaxialStress | LoadingPath::TriaxialCompression => {
                [Some(sense), None, None]
            }
            LoadingPath::UniaxialStrain => [Some(sense), Some(0.0), Some(0.0)],
            LoadingPath::PlaneStrain => [Some(sense), None, Some(0.0)],
            LoadingPath::PureShear => [Some(sense), Some(-sense), Some(0.0)],
        };
        if loading.bands == Bands::Sheet && (prescribed[2].is_some() || confinement > 0.0) {
            return Err(PlasticityError::NotASheet);
        }
        let mut walk = Self {
            law,
            loading,
            prescribed,
            initial: 0.0,
        };
        walk.initial = walk.confined_strain()?;
        Ok(walk)
    }

    fn is_finite_strain(&self) -> bool {
        self.loading.strains == Strains::Finite
    }

    /// The strain with `3 K e = -p`, at finite strain `3 K e = -p exp(3 e)`.
    fn confined_strain(&self) -> Result<f64, PlasticityError> {
        let (pressure, bulk) = (self.loading.confinement, self.law.bulk_modulus());
        let mut strain = -pressure / (3.0 * bulk);
        if self.is_finite_strain() {
            // The left-hand side rises faster than the right-hand side falls short; Newton's method from -p/3K is monotone.
            for _ in 0..100 {
                let volume = (3.0 * strain).exp();
                let rest = 3.0 * bulk * strain + pressure * volume;
                strain -= rest / (3.0 * bulk + 3.0 * pressure * volume);
            }
        }
        let stress = Vector3::repeat(3.0 * bulk * strain);
        if strain.is_finite() && self.excess(&stress, 0.0) < 0.0 {
            Ok(strain)
        } else {
            Err(PlasticityError::Confinement {
                confinement: pressure,
            })
        }
    }

    fn excess(&self, stress: &Vector3<f64>, slip: f64) -> f64 {
        self.law
            .yield_function(&Matrix3::from_diagonal(stress), slip)
    }

    fn elastic_stress(&self, strain: &Vector3<f64>) -> Vector3<f64> {
        self.law
            .elastic_stress(&Matrix3::from_diagonal(strain))
            .diagonal()
    }

    /// The elastic state at a driving strain.
    fn elastic(&self, driving: f64) -> Point {
        let (shear, bulk) = (self.law.shear_modulus(), self.law.bulk_modulus());
        let mut strain =
            Vector3::from_fn(|i, _| self.initial + driving * self.prescribed[i].unwrap_or(0.0));
        let mut stress = self.elastic_stress(&strain);
        for _ in 0..if self.is_finite_strain() { 30 } else { 2 } {
            let mut matrix = Matrix3::identity();
            let mut rest = Vector3::zeros();
            let pressure = self.pressure(&strain);
            for i in (0..3).filter(|i| self.prescribed[*i].is_none()) {
                rest[i] = stress[i] + pressure;
                for j in 0..3 {
                    let own = if i == j { 2.0 * shear } else { 0.0 };
                    let volume = if self.is_finite_strain() {
                        pressure
                    } else {
                        0.0
                    };
                    matrix[(i, j)] = bulk - 2.0 / 3.0 * shear + own + volume;
                }
            }
            strain -= matrix.lu().solve(&rest).unwrap_or_else(Vector3::zeros);
            stress = self.elastic_stress(&strain);
        }
        join(&strain, &stress)
    }

    /// The pressure that constant lateral stresses keep: `p`, in Kirchhoff stress `p J`.
    fn pressure(&self, strain: &Vector3<f64>) -> f64 {
        let volume = if self.is_finite_strain() {
            strain.sum().exp()
        } else {
            1.0
        };
        self.loading.confinement * volume
    }

    /// The state of first yield.
    pub(super) fn first_yield(&self) -> Result<Point, PlasticityError> {
        let excess = |driving: f64| self.excess(&split(&self.elastic(driving)).1, 0.0);
        let mut high = 1e-3 * self.law.hardening().strength(0.0) / self.law.shear_modulus();
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

    /// Rates per slip of strain and stress while the material flows.
    fn rates(&self, y: &Point, slip: f64) -> Result<Point, End> {
        let (strain, stress) = split(y);
        if self.law.hardening().strength(slip) <= 0.0 {
            return Err(End::Exhausted);
        }
        let (flow, normal) = self
            .law
            .directions(&Matrix3::from_diagonal(&stress))
            .map_err(|_| End::Apex)?;
        let stiffness = self.law.hardening().modulus(slip) + self.law.flow_stiffness();
        let (shear, bulk) = (self.law.shear_modulus(), self.law.bulk_modulus());
        let loading = self.law.elastic_stress(&normal).diagonal();
        let relaxation = self.law.elastic_stress(&flow).diagonal();
        let pressure = if self.is_finite_strain() {
            self.pressure(&strain)
        } else {
            0.0
        };
        // Unknown are three strain rates and that of the driving strain; Q:C:e' = h + Q:C:P says that the material flows.
        let mut matrix = SMatrix::<f64, 4, 4>::zeros();
        let mut right = SVector::<f64, 4>::zeros();
        for i in 0..3 {
            match self.prescribed[i] {
                Some(ratio) => {
                    matrix[(i, i)] = shear;
                    matrix[(i, 3)] = -shear * ratio;
                }
                None => {
                    for j in 0..3 {
                        let own = if i == j { 2.0 * shear } else { 0.0 };
                        matrix[(i, j)] = bulk - 2.0 / 3.0 * shear + own + pressure;
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
            &(self.elastic_stress(&strain_rate) - relaxation),
        ))
    }

    /// Integrates from one slip to another.
    pub(super) fn advance(&self, start: &Point, from: f64, to: f64) -> Result<Point, End> {
        // Errors count against the strain of first yield and the strength.
        let strength = self.law.hardening().strength(0.0);
        let size = Point::from_fn(|i, _| {
            if i < 3 {
                strength / self.law.shear_modulus()
            } else {
                strength
            }
        });
        let rates = |y: &Point, slip: f64| self.rates(y, slip);
        integrate(start, [from, to], &size, ACCURACY, rates).map_err(|stop| match stop {
            Stop::Rates(end) => end,
            Stop::TooManySteps => End::TooStiff,
        })
    }

    /// The state with its critical moduli.
    pub(super) fn point(&self, y: &Point, slip: f64) -> Result<PathPoint, End> {
        let (strain, stress) = split(y);
        if self.law.hardening().strength(slip) <= 0.0 {
            return Err(End::Exhausted);
        }
        let frame = Matrix3::identity();
        let told = |error| match error {
            PlasticityError::NoDeviator => End::Apex,
            _ => End::ElasticNotElliptic,
        };
        let bulk = if self.is_finite_strain() {
            let tensor = Matrix3::from_diagonal(&stress);
            let elastic = self.law.elastic_strain(&tensor).diagonal();
            RateModuli::finite(self.law, &elastic, slip, frame)
        } else {
            RateModuli::small(self.law, &stress, slip, frame)
        }
        .map_err(told)?;
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
            modulus: self.law.hardening().modulus(slip),
            ellipticity: moduli.critical(Criterion::Ellipticity).map_err(told)?,
            strong_ellipticity: moduli
                .critical(Criterion::StrongEllipticity)
                .map_err(told)?,
            moduli,
        })
    }

    /// The first state behind the crossing of the modulus and the critical one between two slips.
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

fn join(strain: &Vector3<f64>, stress: &Vector3<f64>) -> Point {
    Point::from_fn(|i, _| if i < 3 { strain[i] } else { stress[i - 3] })
}

fn split(y: &Point) -> (Vector3<f64>, Vector3<f64>) {
    (
        y.fixed_rows::<3>(0).into_owned(),
        y.fixed_rows::<3>(3).into_owned(),
    )
}

/// The end of the part of an interval, from its start, in which a predicate holds; the last number behind it.
fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
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
