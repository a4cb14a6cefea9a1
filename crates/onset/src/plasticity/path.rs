//! Loading paths: where a material that yields, hardens and softens first localizes.

use super::law::{equivalent_shear, mean};
use super::{Critical, DruckerPrager, Notion, PlasticityError, RateModuli};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// How strain is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Strains {
    /// Small strain: no difference between the stress measures, no stress terms in the acoustic tensor.
    #[default]
    Small,
    /// Finite strain, logarithmic; yield in Kirchhoff stress.
    Finite,
}

/// What a loading path prescribes along the fixed axes 1, 2, 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum LoadingPath {
    /// Strain along 1, constant lateral stresses.
    UniaxialStress,
    /// Strain along 1, no lateral strain.
    UniaxialStrain,
    /// Strain along 1, none along 3, constant stress along 2.
    #[default]
    PlaneStrain,
    /// Opposite strains along 1 and 2, none along 3.
    PureShear,
    /// Compression along 1, constant confinement along 2 and 3.
    TriaxialCompression,
}

/// The sense of the strain along 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Load {
    /// Lengthening.
    Tension,
    /// Shortening.
    #[default]
    Compression,
}

/// Which bands are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Bands {
    /// Planar bands of any orientation in the bulk.
    #[default]
    Bulk,
    /// Necks across a sheet normal to axis 3 with stress-free surfaces.
    Sheet,
}

/// A loading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// What is prescribed.
    pub path: LoadingPath,
    /// Its sense.
    pub load: Load,
    /// Small or finite strain.
    pub strains: Strains,
    /// Which bands are looked for.
    pub bands: Bands,
    /// Initial hydrostatic pressure, and the (Cauchy) pressure that constant lateral stresses keep. Units of stress.
    pub confinement: f64,
    /// Plastic shear strain up to which the path is followed.
    pub slip: f64,
}

/// A state of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Plastic shear strain.
    pub slip: f64,
    /// Strains along the axes since the confined state; logarithmic at finite strain.
    pub strain: [f64; 3],
    /// Cauchy stresses along the axes.
    pub stress: [f64; 3],
    /// The plastic modulus `h`.
    pub modulus: f64,
    /// Critical modulus and band of localization.
    pub ellipticity: Critical,
    /// Critical modulus of strong ellipticity.
    pub strong_ellipticity: Critical,
    /// The moduli that decide.
    pub moduli: RateModuli,
}

/// Why a path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum End {
    /// At the slip asked for.
    Slip,
    /// The strength is used up.
    Exhausted,
    /// The prescribed strain would have to turn back (snap-back): under control of strain nothing homogeneous goes on.
    TurnsBack,
    /// The stress deviator vanishes.
    Apex,
    /// The elastic strains have become too large for the elastic part of the law.
    ElasticNotElliptic,
    /// The stress turns so fast per slip that the integration would take too many steps.
    TooStiff,
}

/// What a path shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Localization {
    /// States from first yield on.
    pub points: Vec<PathPoint>,
    /// The first state at which ellipticity is lost, `h <= h_cr`.
    pub onset: Option<PathPoint>,
    /// The first state at which strong ellipticity is lost.
    pub strong_ellipticity_lost: Option<PathPoint>,
    /// Why the path ends.
    pub end: End,
}

/// Points at which a path is looked at; closer near first yield.
const POINTS: usize = 200;

/// Largest elastic strain that is tried to reach yield.
const ELASTIC_STRAIN: f64 = 1.0;

/// Relative error admitted to a step of the integration.
const ACCURACY: f64 = 1e-12;

/// Steps admitted to the integration from one point to the next.
const MOST_STEPS: usize = 20_000;

/// Strains and stresses (Kirchhoff at finite strain) along the axes.
type Point = SVector<f64, 6>;

/// Follows a loading from the confined state through first yield and finds where it localizes.
///
/// Between the points the rate equations `sigma' = C : (e' - P)` are integrated per slip with controlled error; the result is
/// that of infinitely small steps of the return mapping. A crossing of `h` and `h_cr` is refined to rounding; one that is
/// undone between two neighboring points is overlooked.
///
/// ```
/// use onset::plasticity::*;
/// // Hardening that fades: J2 in plane strain localizes where the plastic modulus vanishes.
/// let strength = Hardening::Peak { initial: 1.0, residual: 0.5, modulus: 100.0, reference: 0.02 };
/// let metal = DruckerPrager::von_mises(400.0, 0.3, strength)?;
/// let loading = Loading {
///     path: LoadingPath::PureShear, load: Load::Tension, strains: Strains::Small, bands: Bands::Bulk,
///     confinement: 0.0, slip: 0.1,
/// };
/// let onset = follow(&metal, &loading)?.onset.expect("softening localizes");
/// assert!((onset.slip - 0.015).abs() < 1e-12);
/// # Ok::<(), PlasticityError>(())
/// ```
///
/// # Errors
/// [`PlasticityError::Confinement`], [`PlasticityError::NeverYields`], [`PlasticityError::NotASheet`],
/// [`PlasticityError::Parameter`].
pub fn follow(law: &DruckerPrager, loading: &Loading) -> Result<Localization, PlasticityError> {
    let walk = Walk::new(law, loading)?;
    let mut y = walk.first_yield()?;
    let mut found = Localization {
        points: Vec::with_capacity(POINTS + 1),
        onset: None,
        strong_ellipticity_lost: None,
        end: End::Slip,
    };
    let mut slip = 0.0;
    for count in 0..=POINTS {
        let fraction = count as f64 / POINTS as f64;
        let next = loading.slip * fraction * fraction;
        let reached = walk
            .advance(&y, slip, next)
            .and_then(|reached| Ok((reached, walk.point(&reached, next)?)));
        let (reached, point) = match reached {
            Ok(reached) => reached,
            Err(end) if count > 0 => {
                found.end = end;
                break;
            }
            Err(End::ElasticNotElliptic) => return Err(PlasticityError::ElasticNotElliptic),
            Err(_) => return Err(PlasticityError::NoDeviator),
        };
        for notion in [Notion::Ellipticity, Notion::StrongEllipticity] {
            let lost = match notion {
                Notion::Ellipticity => &mut found.onset,
                Notion::StrongEllipticity => &mut found.strong_ellipticity_lost,
            };
            if lost.is_none() && point.margin(notion) <= 0.0 {
                *lost = Some(if count == 0 {
                    point
                } else {
                    walk.crossing(&y, slip, next, notion).unwrap_or(point)
                });
            }
        }
        found.points.push(point);
        (y, slip) = (reached, next);
    }
    Ok(found)
}

impl PathPoint {
    /// The critical state of a notion.
    pub fn critical(&self, notion: Notion) -> &Critical {
        match notion {
            Notion::Ellipticity => &self.ellipticity,
            Notion::StrongEllipticity => &self.strong_ellipticity,
        }
    }

    /// `h - h_cr`.
    fn margin(&self, notion: Notion) -> f64 {
        self.modulus - self.critical(notion).modulus
    }
}

/// A loading of a law, as equations along the axes.
struct Walk<'a> {
    law: &'a DruckerPrager,
    loading: &'a Loading,
    /// Rate of strain by that of the driving strain where strain is prescribed, nothing where stress is.
    prescribed: [Option<f64>; 3],
    /// The strain of the confined state, along every axis.
    initial: f64,
}

impl<'a> Walk<'a> {
    fn new(law: &'a DruckerPrager, loading: &'a Loading) -> Result<Self, PlasticityError> {
        let require = PlasticityError::require;
        let (confinement, slip) = (loading.confinement, loading.slip);
        require(
            confinement >= 0.0,
            "confinement",
            confinement,
            "zero or a positive pressure",
        )?;
        require(slip > 0.0, "slip", slip, "a positive plastic shear strain")?;
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
    fn first_yield(&self) -> Result<Point, PlasticityError> {
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

    /// Integrates from one slip to another (J. R. Dormand and P. J. Prince, *J. Comput. Appl. Math.* 6 (1980) 19).
    fn advance(&self, start: &Point, from: f64, to: f64) -> Result<Point, End> {
        let (mut y, mut slip) = (*start, from);
        if slip >= to {
            return Ok(y);
        }
        // Errors count against the strain of first yield and the strength.
        let strength = self.law.hardening().strength(0.0);
        let size = Point::from_fn(|i, _| {
            if i < 3 {
                strength / self.law.shear_modulus()
            } else {
                strength
            }
        });
        let mut step = to - from;
        for _ in 0..MOST_STEPS {
            let last = slip + step >= to;
            let length = if last { to - slip } else { step };
            let (next, difference) = self.dormand_prince(&y, slip, length)?;
            let error = difference.component_div(&size).amax();
            let factor = 0.9 * (ACCURACY / error.max(1e-30)).powf(0.2);
            let too_short = length <= 1e-13 * to;
            if error <= ACCURACY || too_short {
                y = next;
                slip = if last { to } else { slip + length };
            }
            if slip >= to {
                return Ok(y);
            }
            step = length * factor.clamp(0.1, 4.0);
        }
        Err(End::TooStiff)
    }

    /// One step, and an estimate of its error.
    fn dormand_prince(&self, y: &Point, slip: f64, step: f64) -> Result<(Point, Point), End> {
        const NODES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
        const WEIGHTS: [&[f64]; 7] = [
            &[],
            &[0.2],
            &[3.0 / 40.0, 9.0 / 40.0],
            &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
            &[
                19372.0 / 6561.0,
                -25360.0 / 2187.0,
                64448.0 / 6561.0,
                -212.0 / 729.0,
            ],
            &[
                9017.0 / 3168.0,
                -355.0 / 33.0,
                46732.0 / 5247.0,
                49.0 / 176.0,
                -5103.0 / 18656.0,
            ],
            &[
                35.0 / 384.0,
                0.0,
                500.0 / 1113.0,
                125.0 / 192.0,
                -2187.0 / 6784.0,
                11.0 / 84.0,
            ],
        ];
        // Fifth less fourth order.
        const ERROR: [f64; 7] = [
            71.0 / 57600.0,
            0.0,
            -71.0 / 16695.0,
            71.0 / 1920.0,
            -17253.0 / 339200.0,
            22.0 / 525.0,
            -1.0 / 40.0,
        ];
        let mut stages = [Point::zeros(); 7];
        let mut next = *y;
        for stage in 0..7 {
            next = *y;
            for (weight, rate) in WEIGHTS[stage].iter().zip(&stages) {
                next += rate * (weight * step);
            }
            stages[stage] = self.rates(&next, slip + NODES[stage] * step)?;
        }
        let error = ERROR
            .iter()
            .zip(&stages)
            .map(|(weight, rate)| rate * (weight * step))
            .sum();
        Ok((next, error))
    }

    /// The state with its critical moduli.
    fn point(&self, y: &Point, slip: f64) -> Result<PathPoint, End> {
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
            ellipticity: moduli.critical(Notion::Ellipticity).map_err(told)?,
            strong_ellipticity: moduli.critical(Notion::StrongEllipticity).map_err(told)?,
            moduli,
        })
    }

    /// The first state behind the crossing of the modulus and the critical one between two slips.
    fn crossing(&self, y: &Point, from: f64, to: f64, notion: Notion) -> Option<PathPoint> {
        let at = |slip: f64| {
            let reached = self.advance(y, from, slip).ok()?;
            self.point(&reached, slip).ok()
        };
        let holds = |slip: f64| at(slip).is_some_and(|point| point.margin(notion) > 0.0);
        at(bisect(from, to, holds))
    }
}

impl PathPoint {
    /// `sqrt(s:s/2)` of the Cauchy stress.
    pub fn equivalent_shear(&self) -> f64 {
        let stress = Matrix3::from_diagonal(&Vector3::from(self.stress));
        equivalent_shear(&super::law::deviator(&stress))
    }

    /// The mean Cauchy stress, positive in tension.
    pub fn mean_stress(&self) -> f64 {
        mean(&Matrix3::from_diagonal(&Vector3::from(self.stress)))
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
