//! Strong ellipticity over all directions in three dimensions.
//!
//! Proofs hold for all stiffnesses whose components lie in the given intervals. Null Lagrangians are tried first (one 9 x 9 matrix is shown to be
//! positive definite); otherwise triangles cover the sphere. Strong ellipticity is refuted by one direction and one polarization whose energy is
//! certainly negative.

use super::{Certainty, Reason, Witness, lower_root};
use crate::algebra::{Each, is_positive_definite};
use crate::continuum::Stiffness;
use crate::continuum::spherical::{
    Cover, Form, Wave, bound, cover, dot, exceeds, octants, symmetric_minimum,
};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError, ResponseEnclosure};
use crate::real::Interval;
use nalgebra::Vector3;

/// Fractions of the smallest eigenvalue found that are tried as its lower bound.
const SHARES: [f64; 5] = [0.999, 0.9, 0.5, 0.1, 1e-3];
/// Largest number of triangles of the sphere per fraction.
const BUDGET: usize = 20_000;

/// Proved statement on the smallest acoustic eigenvalue over all directions in three dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceCertificate {
    /// Result of the proof. Measures are acoustic eigenvalues in units of a given scale, witnesses are directions `N`.
    pub certainty: Certainty<3>,
    /// Polarization `g` (of any length) that confirms the witness: `g . Q(N) g < 0`. `None` without a witness.
    pub polarization: Option<Vector3<f64>>,
}

/// Proves or refutes that a state of a material is strongly elliptic in three dimensions.
///
/// Measures are in units of the largest acoustic eigenvalue of the material in the reference state. An undecided measure within `tolerance` of zero
/// is reported as such.
///
/// ```
/// use onset::certificate::{Certainty, certify_3d};
/// use onset::kinematics::DeformationGradient;
/// use onset::material::BlatzKo;
/// // Elliptic in the plane, where both stretches are the same; not in three dimensions, where their ratio to the third is 4 > 2 + sqrt 3.
/// let material = BlatzKo::new(1.0)?;
/// let f = DeformationGradient::from_stretches([0.25, 0.25, 1.0])?;
/// let proof = certify_3d(&material, &f, 1e-6)?;
/// assert!(matches!(proof.certainty, Certainty::Unstable { witness } if witness.measure.high < 0.0));
/// let f = DeformationGradient::from_stretches([0.27, 0.27, 1.0])?;
/// let proof = certify_3d(&material, &f, 1e-6)?;
/// assert!(matches!(proof.certainty, Certainty::Stable { bound } if bound > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MaterialError`] if the material cannot be evaluated in the reference state.
pub fn certify_3d(
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    tolerance: f64,
) -> Result<SpaceCertificate, MaterialError> {
    let reference = material.undeformed()?;
    let scale = Stiffness::<3>::of(&reference).maximum_eigenvalue();
    let exact =
        DeformationGradient::from_components(f.components().each(|row| row.map(Interval::point)));
    Ok(SpaceCertificate::of(
        &material.enclosure(&exact),
        scale,
        tolerance,
    ))
}

impl SpaceCertificate {
    /// Proves or refutes strong ellipticity for all states of an enclosure together. Measures are in units of `scale`.
    pub fn of(enclosure: &ResponseEnclosure, scale: f64, tolerance: f64) -> Self {
        let form = Form::from_fn(|i, j, k, l| enclosure.tangent[i][j][k][l]);
        let largest = form.components().map(Interval::magnitude);
        let largest = largest.fold(0.0, f64::max);
        let is_finite = form.components().all(Interval::is_finite);
        if !is_finite || !largest.is_normal() || scale.is_nan() || scale <= 0.0 {
            return Self::without_polarization(Certainty::Undecided {
                measure: f64::NAN,
                reason: Reason::NotFinite,
            });
        }
        // Normalize the components by a power of two.
        let unit = 2.0_f64.powi(-(largest.log2().round().clamp(-1000.0, 1000.0) as i32));
        let form = form.map(|component| component * unit);
        let in_units = |value: Interval| value / Interval::point(unit) / Interval::point(scale);
        let middle = form.map(Interval::midpoint);
        let (wave, _) = symmetric_minimum(&middle, f64::INFINITY);
        if wave.eigenvalue < 0.0 {
            let energy = energy(&form, &wave);
            if energy.high < 0.0 {
                return Self::refuted(&form, &wave, energy, in_units);
            }
        }
        let proved = SHARES
            .into_iter()
            .map(|share| share * wave.eigenvalue)
            .find(|&level| level > 0.0 && is_above(&form, &middle, wave.eigenvalue, level));
        Self::without_polarization(match proved {
            Some(level) => Certainty::Stable {
                bound: in_units(Interval::point(level)).low,
            },
            None => {
                let measure = in_units(Interval::point(wave.eigenvalue)).midpoint();
                Certainty::undecided(measure, tolerance, false)
            }
        })
    }

    fn without_polarization(certainty: Certainty<3>) -> Self {
        Self {
            certainty,
            polarization: None,
        }
    }

    fn refuted(
        form: &Form<Interval>,
        wave: &Wave,
        energy: Interval,
        in_units: impl Fn(Interval) -> Interval,
    ) -> Self {
        // The eigenvalue does not exceed the energy, and exceeds any level that the acoustic tensor exceeds.
        let point = [wave.direction; 3];
        let below = [1e-14, 1e-12, 1e-9, 1e-6, 1e-3].each(|distance| energy.low - distance);
        let exceeded = below
            .into_iter()
            .find(|&level| matches!(exceeds(form, level, &point), Cover::Above));
        let measure = in_units(Interval {
            low: exceeded.unwrap_or(f64::NEG_INFINITY),
            high: energy.high,
        });
        let direction = Vector3::from(wave.direction);
        Self {
            certainty: Certainty::Unstable {
                witness: Witness {
                    wave_vector: direction,
                    phases: direction,
                    measure,
                    growth_rate: lower_root(-measure.high),
                },
            },
            polarization: Some(Vector3::from(wave.polarization)),
        }
    }
}

/// Normalized value `g . Q(N) g / (|g|^2 |N|^2)` of the form.
fn energy(form: &Form<Interval>, wave: &Wave) -> Interval {
    let n = wave.direction.map(Interval::point);
    let g = wave.polarization.map(Interval::point);
    let q = form.acoustic(&n, &n);
    let force = q.each(|row| dot(&row, &g));
    let squared = |v: [Interval; 3]| v[0].square() + v[1].square() + v[2].square();
    dot(&force, &g) / (squared(g) * squared(n))
}

/// Returns true if all eigenvalues of all forms in the intervals exceed a level; `found` is the smallest eigenvalue of the middle form.
fn is_above(form: &Form<Interval>, middle: &Form<f64>, found: f64, level: f64) -> bool {
    let at_once = bound(middle, 0.5 * (level + found));
    if is_positive_definite(&form.lowered(level, &at_once.factors)) {
        return true;
    }
    let octants = octants(form.is_orthotropic());
    let covered = cover(octants, BUDGET, |triangle| exceeds(form, level, triangle));
    matches!(covered, Cover::Above)
}
