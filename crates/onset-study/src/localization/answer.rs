//! Answer of `onset localize`: the first state of a path at which the material localizes.

use super::{LocalizationError, PlasticLaw, PlasticSettings};
use crate::brief::{Brief, Short};
use crate::csv::Table;
use crate::number::{told as number, told_of, vector};
use crate::settings::{Units, Value};
use nalgebra::Vector3;
use onset::plasticity::{BandKind, Bands, Criterion, End, PathPoint, follow, follow_increments};
use serde::Serialize;

/// Onset of localization along a path, with the states that lead to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LocalizationAnswer {
    /// Sentence of the answer.
    pub sentence: String,
    /// Parameters that have an effect.
    pub settings: serde_json::Map<String, serde_json::Value>,
    /// Units of all numbers with dimensions: the units of the parameters, or SI.
    pub units: Units,
    /// Parameters of the law, formatted for printing.
    #[serde(skip)]
    pub told: String,
    /// State at first yield.
    pub first_yield: PointAnswer,
    /// State at which strong ellipticity is lost: the symmetric part of the acoustic tensor becomes singular. `null` if it is not lost on the path.
    pub strong_ellipticity_lost: Option<PointAnswer>,
    /// State at which ellipticity is lost and a band can form; `null` if it is not lost on the path.
    pub localization: Option<PointAnswer>,
    /// State with the smallest `h - h_cr`, which is the onset if localization occurs.
    pub closest: PointAnswer,
    /// Reason why the path ends.
    pub end: End,
    /// Critical moduli by direction at the state closest to localization, in the plane of the largest and the smallest principal stress.
    pub directions: Vec<DirectionAnswer>,
    /// States of the path.
    pub path: Vec<PointAnswer>,
    /// Onset with half the number of increments, as a measure of convergence; `null` for laws that are not incremental.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with_half_the_increments: Option<HalfAnswer>,
    /// Message of an incremental law whose failure ends the path; `null` for other ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refusal: Option<String>,
    /// Elastic shear stiffness, the scale for moduli.
    #[serde(skip)]
    stiffness: f64,
}

/// Onset of localization with half the number of increments; `None` in each field without localization.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HalfAnswer {
    /// Plastic shear strain at the onset; `null` if the path does not localize.
    pub localization_slip: Option<f64>,
    /// Strain along axis 1 at the onset; `null` if the path does not localize.
    pub localization_strain: Option<f64>,
}

/// State of the path, in the axes of the path. Stresses are Cauchy stresses, tension positive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointAnswer {
    /// Accumulated plastic shear strain.
    pub slip: f64,
    /// Strains along the axes relative to the confined state; logarithmic at finite strain.
    pub strain: [f64; 3],
    /// Cauchy stresses along the axes, tension positive. Units of stress.
    pub stress: [f64; 3],
    /// Equivalent shear stress `sqrt(s:s/2)`. Units of stress.
    pub equivalent_shear: f64,
    /// Mean stress, tension positive. Units of stress.
    pub mean_stress: f64,
    /// Plastic modulus `h`. Units of stress.
    pub plastic_modulus: f64,
    /// Critical modulus of localization `h_cr`, the maximum over all normals. Units of stress.
    pub critical_modulus: f64,
    /// Upper bound of the critical modulus `h_cr` over all normals. Units of stress.
    pub critical_modulus_bound: f64,
    /// Critical modulus of strong ellipticity, the maximum over all normals. Units of stress.
    pub strong_critical_modulus: f64,
    /// Band at the critical modulus of localization.
    pub band: BandAnswer,
}

/// Localization band at a state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BandAnswer {
    /// Kind of the band.
    pub kind: BandKind,
    /// Unit normal of the band.
    pub normal: [f64; 3],
    /// Unit vector along the velocity jump across the band.
    pub polarization: [f64; 3],
    /// Angle in degrees between the normal and the axis of the largest (most tensile) principal stress.
    pub angle_to_major: f64,
    /// Angle in degrees between the normal and the axis of the smallest (most compressive) principal stress.
    pub angle_to_minor: f64,
}

/// Critical moduli of one direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DirectionAnswer {
    /// Angle in degrees of the normal from the axis of the smallest principal stress, toward the axis of the largest.
    pub angle: f64,
    /// Critical modulus of ellipticity. Units of stress.
    pub critical_modulus: f64,
    /// Critical modulus of strong ellipticity. Units of stress.
    pub strong_critical_modulus: f64,
}

impl From<&PathPoint> for PointAnswer {
    fn from(point: &PathPoint) -> Self {
        let band = point.ellipticity.band;
        Self {
            slip: point.slip,
            strain: point.strain,
            stress: point.stress,
            equivalent_shear: point.equivalent_shear(),
            mean_stress: point.mean_stress(),
            plastic_modulus: point.modulus,
            critical_modulus: point.ellipticity.modulus,
            critical_modulus_bound: point.ellipticity.bound,
            strong_critical_modulus: point.strong_ellipticity.modulus,
            band: BandAnswer {
                kind: band.kind,
                normal: band.normal.into(),
                polarization: band.polarization.into(),
                angle_to_major: band.angle_to_major,
                angle_to_minor: band.angle_to_minor,
            },
        }
    }
}

impl LocalizationAnswer {
    /// Follows the path to its end.
    ///
    /// # Errors
    /// [`LocalizationError`] when the law has invalid parameters or cannot follow the path.
    pub fn new(settings: &PlasticSettings) -> Result<Self, LocalizationError> {
        let loading = settings.loading();
        let (found, coarser) = match settings.law()? {
            PlasticLaw::Flow(law) => (follow(law.as_ref(), &loading)?, None),
            PlasticLaw::Increments(law, count) => (
                follow_increments(law.as_ref(), &loading, count)?,
                Some(follow_increments(law.as_ref(), &loading, count / 2)?),
            ),
        };
        let margin = |point: &PathPoint| point.modulus - point.ellipticity.modulus;
        let closest = found.onset.as_ref().unwrap_or_else(|| {
            found
                .points
                .iter()
                .min_by(|a, b| margin(a).total_cmp(&margin(b)))
                .unwrap_or(&found.points[0])
        });
        let answer = |point: &PathPoint| PointAnswer::from(point);
        let elastic = found.points[0].moduli;
        let elastic = elastic.elastic_acoustic_tensor(&Vector3::x());
        let mut told = Self {
            sentence: String::new(),
            settings: settings
                .entries()
                .map(|(name, value)| (name, json(&value)))
                .collect(),
            units: settings.units(),
            told: settings.told(),
            first_yield: answer(&found.points[0]),
            strong_ellipticity_lost: found.strong_ellipticity_lost.as_ref().map(answer),
            localization: found.onset.as_ref().map(answer),
            closest: answer(closest),
            end: found.end,
            directions: directions(closest, loading.bands)?,
            path: found.points.iter().map(answer).collect(),
            with_half_the_increments: coarser.as_ref().map(|coarser| HalfAnswer {
                localization_slip: coarser.onset.as_ref().map(|point| point.slip),
                localization_strain: coarser.onset.as_ref().map(|point| point.strain[0]),
            }),
            refusal: found.refusal.as_ref().map(ToString::to_string),
            stiffness: elastic.symmetric_eigenvalues().min(),
        };
        told.sentence = told.tell(loading.slip);
        Ok(told)
    }

    /// Table of the path as CSV.
    pub fn csv(&self) -> String {
        Table::new(&self.path, self.units)
            .with("plastic_shear_strain", "1", |own| own.slip)
            .each("strain", 3, "1", |own, n| own.strain[n])
            .each("stress", 3, "stress", |own, n| own.stress[n])
            .with("plastic_modulus", "stress", |own| own.plastic_modulus)
            .with("critical_modulus", "stress", |own| own.critical_modulus)
            .with("strong_critical_modulus", "stress", |own| {
                own.strong_critical_modulus
            })
            .with("angle_to_major", "deg", |own| own.band.angle_to_major)
            .with("angle_to_minor", "deg", |own| own.band.angle_to_minor)
            .to_string()
    }

    /// Table of critical moduli by direction as CSV.
    pub fn directions_csv(&self) -> String {
        Table::new(&self.directions, self.units)
            .with("angle_to_minor", "deg", |own| own.angle)
            .with("critical_modulus", "stress", |own| own.critical_modulus)
            .with("strong_critical_modulus", "stress", |own| {
                own.strong_critical_modulus
            })
            .to_string()
    }

    /// Name of the band. In a sheet it is a neck, and the kind of band determines the change of thickness.
    fn band_name(&self, point: &PointAnswer) -> &'static str {
        match self
            .settings
            .get("plasticity.bands")
            .and_then(serde_json::Value::as_str)
        {
            Some("sheet") => "localized neck",
            _ => point.band.kind.name(),
        }
    }

    /// Composes the sentence of the answer.
    fn tell(&self, slip: f64) -> String {
        let mut sentence = match &self.localization {
            Some(onset) => {
                let when = if onset.slip == 0.0 {
                    "at first yield".to_owned()
                } else {
                    format!("at the plastic shear strain {}", number(onset.slip))
                };
                // A modulus within rounding error is neither hardening nor softening.
                let scale = 1e-9 * self.first_yield.plastic_modulus.abs();
                let hardening = if onset.plastic_modulus > scale {
                    "while it still hardens"
                } else if onset.plastic_modulus < -scale {
                    "while it softens"
                } else {
                    "where hardening ends"
                };
                format!(
                    "The material localizes {when} (strain along axis 1 {}), {hardening}: a {} forms with its normal at {:.2} \
                     degrees to the {} principal stress.",
                    number(onset.strain[0]),
                    self.band_name(onset),
                    onset.band.angle_to_minor,
                    if onset.stress.iter().all(|stress| *stress >= 0.0) {
                        "smallest"
                    } else {
                        "most compressive"
                    }
                )
            }
            None => format!(
                "The material does not localize up to the plastic shear strain {}: its plastic modulus stays above the critical \
                 one, by {} at the least.",
                number(self.path.last().map_or(slip, |point| point.slip)),
                self.units.of(
                    told_of(
                        self.closest.plastic_modulus - self.closest.critical_modulus,
                        self.stiffness
                    ),
                    "Pa"
                )
            ),
        };
        if let Some(strong) = &self.strong_ellipticity_lost
            && self
                .localization
                .as_ref()
                .is_none_or(|onset| onset.slip - strong.slip > 1e-9 * slip)
        {
            let place = if strong.slip == 0.0 {
                "at first yield".to_owned()
            } else {
                format!("at {}", number(strong.slip))
            };
            let order = if self.localization.is_some() {
                "before"
            } else {
                "all the same"
            };
            sentence.push_str(&format!(" Strong ellipticity is lost {order}, {place}."));
        }
        match self.end {
            End::Slip => {}
            End::Exhausted => sentence.push_str(" The path ends where the strength is exhausted."),
            End::TurnsBack => sentence.push_str(
                " The path ends where the prescribed strain would have to decrease: homogeneous deformation cannot continue \
                 under strain control.",
            ),
            End::Corner => sentence.push_str(
                " The path ends where the intermediate principal stress equals the largest or smallest and a second face of the yield surface would flow.",
            ),
            End::Apex => sentence.push_str(" The path ends where the stress deviator vanishes."),
            End::ElasticNotElliptic => sentence.push_str(
                " The path ends where the elastic part of the law itself loses strong ellipticity.",
            ),
            End::TooStiff => sentence.push_str(
                " The path ends early: the strength is too small relative to the stiffness for this slip.",
            ),
            End::Law => {
                let refusal = self.refusal.as_deref().unwrap_or("its numbers are not finite");
                sentence.push_str(&format!(
                    " The path ends where the law fails: {}.",
                    refusal.lines().next().unwrap_or_default()
                ));
            }
            End::NoBalance => sentence.push_str(
                " The path ends where no lateral strains were found that keep the lateral stresses constant.",
            ),
            End::Unloads => sentence.push_str(
                " The path ends where loading and unloading have the same tangent: the material flows no further.",
            ),
            End::SeveralMechanisms => sentence.push_str(
                " The path ends where several mechanisms flow together.",
            ),
        }
        sentence.push_str(&self.tell_increments());
        sentence
    }

    /// Sentence on the influence of the number of increments.
    fn tell_increments(&self) -> String {
        let Some(half) = self.with_half_the_increments else {
            return String::new();
        };
        match (&self.localization, half.localization_slip) {
            (Some(_), Some(slip)) => format!(
                " With half the number of increments it would localize at {}.",
                number(slip)
            ),
            (None, None) => String::new(),
            _ => " With half the number of increments the answer differs: set material.increments higher.".to_owned(),
        }
    }
}

/// Critical moduli over a quarter turn from the axis of the smallest to the axis of the largest principal stress.
fn directions(point: &PathPoint, bands: Bands) -> Result<Vec<DirectionAnswer>, LocalizationError> {
    let axes = match bands {
        Bands::Bulk => 3,
        Bands::Sheet => 2,
    };
    let stress = |axis: &usize| point.stress[*axis];
    let by_stress = |a: &usize, b: &usize| stress(a).total_cmp(&stress(b));
    let major = (0..axes).max_by(by_stress).unwrap_or(0);
    // For equal stresses choose the first and the last axis, so that the two differ.
    let minor = (0..axes).min_by(by_stress).unwrap_or(1);
    let mut told = Vec::with_capacity(181);
    for half_degrees in 0..=180 {
        let angle = 0.5 * f64::from(half_degrees);
        let (sine, cosine) = angle.to_radians().sin_cos();
        let n = Vector3::ith(minor, cosine) + Vector3::ith(major, sine);
        told.push(DirectionAnswer {
            angle,
            critical_modulus: point
                .moduli
                .critical_modulus_along(&n, Criterion::Ellipticity)?,
            strong_critical_modulus: point
                .moduli
                .critical_modulus_along(&n, Criterion::StrongEllipticity)?,
        });
    }
    Ok(told)
}

fn json(value: &Value) -> serde_json::Value {
    serde_json::to_value(value).unwrap_or_default()
}

impl Brief for LocalizationAnswer {
    fn brief(&self) -> Short {
        let stress = |modulus: f64| self.units.of(told_of(modulus, self.stiffness), "Pa");
        let point = |point: &PointAnswer| {
            format!(
                "plastic shear strain {}, strain {}, h {}, critical h {}",
                number(point.slip),
                vector(&point.strain),
                stress(point.plastic_modulus),
                stress(point.critical_modulus),
            )
        };
        let mut short = Short::new(&self.sentence).row(2, "first yield", point(&self.first_yield));
        if let Some(strong) = &self.strong_ellipticity_lost {
            short = short.row(
                1,
                "ellipticity",
                format!("lost in the strong sense at {}", point(strong)),
            );
        }
        let (name, last) = match &self.localization {
            Some(onset) => ("localizes", onset),
            None => ("closest", &self.closest),
        };
        let band = format!(
            "{}, normal {}, {} degrees from the axis of the largest stress",
            self.band_name(last),
            vector(&last.band.normal),
            number(last.band.angle_to_major)
        );
        short
            .row(0, name, point(last))
            .row(0, "band", band)
            .settings("settings", &self.told)
    }
}

impl std::fmt::Display for LocalizationAnswer {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(formatter, "{}\n", self.sentence)?;
        let stiffness = self.stiffness;
        let stress = |modulus: f64| self.units.of(told_of(modulus, stiffness), "Pa");
        let mut point = |name: &str, point: &PointAnswer| {
            writeln!(formatter, "{name}")?;
            writeln!(
                formatter,
                "  plastic shear strain    {}",
                number(point.slip)
            )?;
            writeln!(
                formatter,
                "  strain                  {}",
                vector(&point.strain)
            )?;
            writeln!(
                formatter,
                "  stress                  {}",
                self.units.of(vector(&point.stress), "Pa")
            )?;
            writeln!(
                formatter,
                "  shear, mean stress      {}, {}",
                stress(point.equivalent_shear),
                stress(point.mean_stress)
            )?;
            writeln!(
                formatter,
                "  plastic modulus h       {}",
                stress(point.plastic_modulus)
            )?;
            writeln!(
                formatter,
                "  critical modulus        {} (for loss of strong ellipticity: {})",
                stress(point.critical_modulus),
                stress(point.strong_critical_modulus)
            )?;
            writeln!(
                formatter,
                "  band                    {}, normal {}, polarization {}",
                self.band_name(point),
                vector(&point.band.normal),
                vector(&point.band.polarization)
            )?;
            writeln!(
                formatter,
                "  normal to axis of       largest stress {} degrees, smallest stress {} degrees",
                number(point.band.angle_to_major),
                number(point.band.angle_to_minor)
            )
        };
        point("first yield", &self.first_yield)?;
        if let Some(strong) = &self.strong_ellipticity_lost {
            point("strong ellipticity lost", strong)?;
        }
        match &self.localization {
            Some(onset) => point("localization", onset)?,
            None => point("closest to localization", &self.closest)?,
        }
        let (low, high) =
            self.path
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| {
                    (
                        low.min(point.critical_modulus),
                        high.max(point.critical_modulus),
                    )
                });
        writeln!(
            formatter,
            "critical modulus over the path  {} to {}",
            stress(low),
            stress(high)
        )?;
        writeln!(formatter, "\nsettings                  {}", self.told)
    }
}
