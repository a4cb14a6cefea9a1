//! Loading paths: where a material that yields, hardens and softens first localizes.

use super::law::{deviator, equivalent_shear, mean};
use super::walk::Walk;
use super::{Criterion, Critical, FlowLaw, PlasticityError, RateModuli};
use crate::material::MaterialError;
use nalgebra::{Matrix3, Vector3};

/// Strain measure of a loading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Strains {
    /// Small strain: all stress measures coincide, and the acoustic tensor has no stress terms.
    #[default]
    Small,
    /// Finite logarithmic strain; yield in Kirchhoff stress.
    Finite,
}

/// Prescribed strains and stresses of a loading path along the fixed axes 1, 2, 3.
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
    /// Strains along 1 and 2 in a constant ratio, no stress along 3: the stretching of a sheet.
    SheetStretch,
}

/// Sign of the strain along axis 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Load {
    /// Extension along axis 1.
    Tension,
    /// Contraction along axis 1.
    #[default]
    Compression,
}

/// Kind of localization bands in the search.
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

/// Loading of a plastic law along fixed axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// Prescribed strains and stresses.
    pub path: LoadingPath,
    /// Sign of the strain along axis 1.
    pub load: Load,
    /// Small or finite strain.
    pub strains: Strains,
    /// Kind of localization bands in the search.
    pub bands: Bands,
    /// Initial hydrostatic pressure, and the (Cauchy) pressure of constant lateral stresses. Units of stress.
    pub confinement: f64,
    /// Ratio of the strain along axis 2 to the strain along axis 1 for [`LoadingPath::SheetStretch`].
    pub strain_ratio: f64,
    /// Final plastic shear strain of the path.
    pub slip: f64,
}

/// State of a loading path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Plastic shear strain of the state.
    pub slip: f64,
    /// Strains along the axes since the confined state; logarithmic at finite strain.
    pub strain: [f64; 3],
    /// Cauchy stresses along the axes. Units of stress.
    pub stress: [f64; 3],
    /// Plastic modulus `h`. Units of stress.
    pub modulus: f64,
    /// Critical modulus `h_cr` of localization, in units of stress, and its band.
    pub ellipticity: Critical,
    /// Critical modulus of strong ellipticity, in units of stress, and its band.
    pub strong_ellipticity: Critical,
    /// Rate moduli of the state. Units of stress.
    pub moduli: RateModuli,
}

/// Reason why a path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum End {
    /// The requested slip is reached.
    Slip,
    /// The strength is exhausted.
    Exhausted,
    /// The prescribed strain would have to decrease (snap-back); under strain control no homogeneous state follows.
    TurnsBack,
    /// The stress deviator vanishes.
    Apex,
    /// The intermediate principal stress becomes equal to the largest or the smallest one, and another face of the yield surface would flow.
    Corner,
    /// The elastic strains have become too large for the elastic part of the law.
    ElasticNotElliptic,
    /// The stress rotates so fast per slip that the integration would take too many steps.
    TooStiff,
    /// The incremental law fails at the next increment.
    Law,
    /// No lateral strains were found that keep the lateral stresses constant.
    NoBalance,
    /// The incremental law stops flowing: loading and unloading have the same tangent.
    Unloads,
    /// The reduction of the elastic tangent by flow is not of rank one.
    SeveralMechanisms,
}

impl End {
    /// Classifies the end of a path by the error of its law or of its equations.
    pub(super) fn of(error: &PlasticityError) -> Self {
        match error {
            PlasticityError::Exhausted { .. } => Self::Exhausted,
            PlasticityError::Corner => Self::Corner,
            PlasticityError::ElasticNotElliptic => Self::ElasticNotElliptic,
            PlasticityError::Law(_) | PlasticityError::NotFinite => Self::Law,
            PlasticityError::NoBalance => Self::NoBalance,
            PlasticityError::Unloads => Self::Unloads,
            PlasticityError::SeveralMechanisms | PlasticityError::NotAlongAxes => {
                Self::SeveralMechanisms
            }
            _ => Self::Apex,
        }
    }
}

/// Result of following a loading path.
#[derive(Clone, Debug, PartialEq)]
pub struct Localization {
    /// States of the path, starting at first yield.
    pub points: Vec<PathPoint>,
    /// First state at which ellipticity is lost, `h <= h_cr`. `None` if it is kept.
    pub onset: Option<PathPoint>,
    /// First state at which strong ellipticity is lost; `None` if it is kept.
    pub strong_ellipticity_lost: Option<PathPoint>,
    /// Reason why the path ends.
    pub end: End,
    /// Error of an incremental law, if it fails at the next increment.
    pub refusal: Option<MaterialError>,
}

impl Localization {
    pub(super) fn new(points: usize) -> Self {
        Self {
            points: Vec::with_capacity(points + 1),
            onset: None,
            strong_ellipticity_lost: None,
            end: End::Slip,
            refusal: None,
        }
    }

    /// Records a state. The first violation of a criterion is refined to the preceding crossing, or to the state itself if there is no crossing.
    pub(super) fn notice(
        &mut self,
        point: &PathPoint,
        crossing: impl Fn(Criterion) -> Option<PathPoint>,
    ) {
        for criterion in [Criterion::Ellipticity, Criterion::StrongEllipticity] {
            let lost = match criterion {
                Criterion::Ellipticity => &mut self.onset,
                Criterion::StrongEllipticity => &mut self.strong_ellipticity_lost,
            };
            if lost.is_none() && point.margin(criterion) <= 0.0 {
                *lost = Some(crossing(criterion).unwrap_or(*point));
            }
        }
        self.points.push(*point);
    }
}

/// Prescribed quantities of a loading along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    /// Rate of a prescribed strain relative to the driving strain; `None` for an axis with prescribed stress.
    pub(super) prescribed: [Option<f64>; 3],
}

impl Course {
    pub(super) fn new(loading: &Loading) -> Result<Self, PlasticityError> {
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
            LoadingPath::SheetStretch => {
                let ratio = loading.strain_ratio;
                require(
                    ratio > -1.0 && ratio <= 1.0,
                    "strain-ratio",
                    ratio,
                    "a number above -1 and at most 1",
                )?;
                [Some(sense), Some(sense * ratio), None]
            }
        };
        if loading.bands == Bands::Sheet && (prescribed[2].is_some() || confinement > 0.0) {
            return Err(PlasticityError::NotASheet);
        }
        Ok(Self { prescribed })
    }

    /// Rates of the prescribed strains, zero for the others.
    pub(super) fn direction(&self) -> Vector3<f64> {
        Vector3::from(self.prescribed.map(Option::unwrap_or_default))
    }
}

/// Number of points along a path; closer together near first yield.
const POINTS: usize = 200;

/// Follows a loading from the confined state through first yield and finds where it localizes.
///
/// Between the points the rate equations `sigma' = C : (e' - P)` are integrated per slip with controlled error, which corresponds to infinitely small
/// steps of the return mapping. A crossing of `h` and `h_cr` is refined to rounding. A crossing that is reversed between two neighboring points is
/// overlooked.
///
/// ```
/// use onset::plasticity::*;
/// // Hardening that fades: J2 in plane strain localizes where the plastic modulus vanishes.
/// let strength = Hardening::Peak { initial: 1.0, residual: 0.5, modulus: 100.0, reference: 0.02 };
/// let metal = DruckerPrager::von_mises(400.0, 0.3, strength)?;
/// let loading = Loading {
///     path: LoadingPath::PureShear, load: Load::Tension, strains: Strains::Small, bands: Bands::Bulk,
///     confinement: 0.0, strain_ratio: 0.0, slip: 0.1,
/// };
/// let onset = follow(&metal, &loading)?.onset.expect("softening localizes");
/// assert!((onset.slip - 0.015).abs() < 1e-12);
/// # Ok::<(), PlasticityError>(())
/// ```
///
/// # Errors
/// [`PlasticityError::Confinement`], [`PlasticityError::NeverYields`], [`PlasticityError::NotASheet`], [`PlasticityError::Parameter`].
pub fn follow(law: &dyn FlowLaw, loading: &Loading) -> Result<Localization, PlasticityError> {
    let walk = Walk::new(law, loading)?;
    let mut y = walk.first_yield()?;
    let mut found = Localization::new(POINTS);
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
            Err(End::TurnsBack) => {
                let flow = walk
                    .flow(&y, 0.0)
                    .map_err(|_| PlasticityError::NoDeviator)?;
                return Err(PlasticityError::SnapBack {
                    modulus: flow.modulus(),
                    least: -flow.relaxation(),
                });
            }
            Err(_) => return Err(PlasticityError::NoDeviator),
        };
        found.notice(&point, |criterion| match count {
            0 => None,
            _ => walk.crossing(&y, slip, next, criterion),
        });
        (y, slip) = (reached, next);
    }
    Ok(found)
}

impl PathPoint {
    /// Critical modulus of a criterion, with its band.
    pub fn critical(&self, criterion: Criterion) -> &Critical {
        match criterion {
            Criterion::Ellipticity => &self.ellipticity,
            Criterion::StrongEllipticity => &self.strong_ellipticity,
        }
    }

    /// Margin `h - h_cr` of a criterion.
    pub(super) fn margin(&self, criterion: Criterion) -> f64 {
        self.modulus - self.critical(criterion).modulus
    }
}

impl PathPoint {
    /// Equivalent shear `sqrt(s:s/2)` of the Cauchy stress. Units of stress.
    pub fn equivalent_shear(&self) -> f64 {
        let stress = Matrix3::from_diagonal(&Vector3::from(self.stress));
        equivalent_shear(&deviator(&stress))
    }

    /// Mean Cauchy stress, positive in tension.
    pub fn mean_stress(&self) -> f64 {
        mean(&Matrix3::from_diagonal(&Vector3::from(self.stress)))
    }
}
