//! Critical plastic moduli and the bands that form at them.

use super::search::largest;
use super::{PlasticityError, RateModuli};
use nalgebra::{Matrix3, Vector3};

/// Condition that is lost at a critical modulus.
///
/// For associated flow (`mu = beta`) the acoustic tensor is symmetric and both conditions are lost together. Otherwise strong ellipticity is lost
/// first (D. Bigoni and D. Zaccaria, *Int. J. Solids Struct.* 29 (1992) 2123).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Criterion {
    /// Ellipticity: at its loss `det q(n) = 0` for a direction, and a band of localized deformation can form.
    Ellipticity,
    /// Strong ellipticity: at its loss the symmetric part of `q(n)` is no longer positive definite for all directions.
    StrongEllipticity,
}

/// Kind of a band, by the angle between its normal and the jump of velocity across it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum BandKind {
    /// Opening mode without shear.
    DilationBand,
    /// Shear combined with opening.
    DilatantShearBand,
    /// Shear at constant thickness.
    ShearBand,
    /// Shear combined with closing.
    CompactantShearBand,
    /// Closing mode without shear.
    CompactionBand,
}

/// Localization band. The jump of the velocity gradient is `polarization normal^T`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Unit normal of the band.
    pub normal: Vector3<f64>,
    /// Unit vector along the jump of velocity, oriented so that the material inside continues to flow.
    pub polarization: Vector3<f64>,
    /// Kind of the band: opening, closing or shear.
    pub kind: BandKind,
    /// Angle between the normal and the axis of the largest (most tensile) principal stress, in degrees.
    pub angle_to_major: f64,
    /// Angle between the normal and the axis of the smallest (most compressive) principal stress, in degrees.
    pub angle_to_minor: f64,
}

/// Plastic modulus at which a criterion is first violated, in the most critical direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Critical {
    /// Critical modulus `h_cr`: the criterion holds for `h > h_cr`. Units of stress.
    pub modulus: f64,
    /// Upper bound, to rounding, of the critical moduli of all directions. Units of stress.
    pub bound: f64,
    /// Band in the most critical direction.
    pub band: Band,
}

impl RateModuli {
    /// Returns the plastic modulus at which a criterion is first violated in one spatial direction. Units of stress.
    ///
    /// With `a = A n`, `b = B n` and the elastic acoustic tensor `q_e`, `det q = det q_e (1 - b . q_e^-1 a / (h + Q:C:P))` vanishes at
    /// `h = b . q_e^-1 a - Q:C:P`, and the symmetric part becomes singular at `h = (b . q_e^-1 a + sqrt(a . q_e^-1 a  b . q_e^-1 b)) / 2 - Q:C:P`.
    ///
    /// # Errors
    /// [`PlasticityError::ElasticNotElliptic`] if `q_e` is not positive definite.
    pub fn critical_modulus_along(
        &self,
        direction: &Vector3<f64>,
        criterion: Criterion,
    ) -> Result<f64, PlasticityError> {
        let n = self.frame.transpose() * direction.normalize();
        let elastic = self.principal_acoustic_tensor(&n);
        let factor = elastic
            .cholesky()
            .ok_or(PlasticityError::ElasticNotElliptic)?;
        let (a, b) = self.tractions(&n);
        let (flow, loading) = (factor.solve(&a), factor.solve(&b));
        let mixed = b.dot(&flow);
        Ok(match criterion {
            Criterion::Ellipticity => mixed,
            Criterion::StrongEllipticity => {
                0.5 * (mixed + a.dot(&flow).sqrt() * b.dot(&loading).sqrt())
            }
        } - self.relaxation)
    }

    /// Returns the largest critical modulus over all directions, with its direction and the band that forms.
    ///
    /// The maximum extends over all directions of the sphere (of the sheet for [`RateModuli::in_sheet`]) without sampling. In principal axes
    /// `h_cr(n)` is a quotient of cubics of `n_i^2`. It is bounded on parts of the triangle of these variables, and the best point is refined. At
    /// small strain the maximum lies in the plane of the largest and the smallest principal stress, as the book derives.
    ///
    /// ```
    /// use nalgebra::{Matrix3, Vector3};
    /// use onset::plasticity::{DruckerPrager, Hardening, Criterion};
    /// let strength = Hardening::linear(1.0, 0.0);
    /// let metal = DruckerPrager::von_mises(100.0, 0.3, strength)?;
    /// let shear = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 0.0));
    /// let critical = metal.rate_moduli(&shear, 0.0)?.critical(Criterion::Ellipticity)?;
    /// assert!(critical.modulus.abs() < 1e-12);
    /// assert!((critical.band.angle_to_major - 45.0).abs() < 1e-9);
    /// # Ok::<(), onset::plasticity::PlasticityError>(())
    /// ```
    ///
    /// # Errors
    /// [`PlasticityError::ElasticNotElliptic`] if the elastic part is not strongly elliptic.
    pub fn critical(&self, criterion: Criterion) -> Result<Critical, PlasticityError> {
        let scale = self.normal.amax();
        let found = largest(self, criterion, &self.region(scale), scale)?;
        let n = found.point.map(|x| x.max(0.0).sqrt());
        Ok(Critical {
            modulus: found.value * scale - self.relaxation,
            bound: found.bound * scale - self.relaxation,
            band: self.band(&n, criterion)?,
        })
    }

    /// Returns true if a criterion holds in every direction for continued flow.
    ///
    /// # Errors
    /// [`PlasticityError`] under the conditions of [`RateModuli::critical`].
    pub fn holds(&self, criterion: Criterion) -> Result<bool, PlasticityError> {
        Ok(self.modulus > self.critical(criterion)?.modulus)
    }

    /// Corners of the simplex of `n_i^2` that contains a maximum.
    fn region(&self, scale: f64) -> Vec<Vector3<f64>> {
        let axis = |i: usize| Vector3::ith(i, 1.0);
        if self.sheet {
            return vec![axis(0), axis(1)];
        }
        if self.isotropic {
            let (major, minor) = self.extreme_axes();
            return vec![axis(major), axis(minor)];
        }
        // If two axes are equivalent for the law, one of them suffices.
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let same = |a: f64, b: f64| (a - b).abs() <= 1e-13 * scale;
            if same(self.flow[j], self.flow[k])
                && same(self.loading[j], self.loading[k])
                && same(self.normal[(j, j)], self.normal[(k, k)])
                && same(self.shear[(i, j)], self.shear[(i, k)])
                && same(self.shear[(j, i)], self.shear[(k, i)])
                && same(self.shear[(j, k)], self.shear[(k, j)])
                && same(self.coupling(i, j), self.coupling(i, k))
            {
                return vec![axis(i), axis(j)];
            }
        }
        vec![axis(0), axis(1), axis(2)]
    }

    /// Axes of the largest and of the smallest flow. If the maximum lies in a principal plane, it lies between them.
    fn extreme_axes(&self) -> (usize, usize) {
        (self.flow.imax(), self.flow.imin())
    }

    /// Principal axes of the largest and of the smallest stress; ties are resolved by the flow. In a sheet both lie within the sheet.
    fn stress_axes(&self) -> (usize, usize) {
        let count = if self.sheet { 2 } else { 3 };
        let key = |i: &usize| {
            // Stresses that are equal to rounding are ordered by the flow.
            let size = 1e-12 * self.stress.amax();
            (
                (self.stress[*i] / size.max(f64::MIN_POSITIVE)).round(),
                self.flow[*i],
            )
        };
        let order = |a: &usize, b: &usize| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        (
            (0..count).rev().max_by(order).unwrap_or(0),
            (0..count).min_by(order).unwrap_or(1),
        )
    }

    /// Band with a normal in principal axes, at its critical modulus.
    fn band(&self, n: &Vector3<f64>, criterion: Criterion) -> Result<Band, PlasticityError> {
        let factor = self
            .principal_acoustic_tensor(n)
            .cholesky()
            .ok_or(PlasticityError::ElasticNotElliptic)?;
        let (a, b) = self.tractions(n);
        let (flow, loading) = (factor.solve(&a), factor.solve(&b));
        // The jump g satisfies q g = 0, or (q + q^T) g = 0 for strong ellipticity. Its sign is b . g > 0, because plastic flow continues inside the band.
        let jump = match criterion {
            Criterion::Ellipticity => flow,
            Criterion::StrongEllipticity => {
                flow / a.dot(&flow).sqrt() + loading / b.dot(&loading).sqrt()
            }
        };
        let length = jump.norm();
        let polarization = if length > 0.0 { jump / length } else { *n };
        let degrees = |axis: usize| {
            let across = n - Vector3::ith(axis, n[axis]);
            across.norm().atan2(n[axis].abs()).to_degrees()
        };
        let (major, minor) = self.stress_axes();
        let clean = |v: Vector3<f64>| v.map(|c| if c.abs() < 1e-15 { 0.0 } else { c });
        Ok(Band {
            normal: clean(self.frame * n),
            polarization: clean(self.frame * polarization),
            kind: BandKind::of(n, &polarization),
            angle_to_major: degrees(major),
            angle_to_minor: degrees(minor),
        })
    }

    /// Smallest eigenvalue of the symmetric part of the acoustic tensor in a spatial direction. Units of stress.
    pub fn smallest_symmetric_eigenvalue(&self, direction: &Vector3<f64>) -> f64 {
        let q = self.acoustic_tensor(direction);
        let symmetric: Matrix3<f64> = (q + q.transpose()) * 0.5;
        symmetric.symmetric_eigenvalues().min()
    }
}

impl BandKind {
    /// Largest sine of the angle at which a band counts as free of shear.
    const SHEAR_FREE_SINE: f64 = 1e-6;
    /// Largest cosine of the angle at which a band counts as having constant thickness. Laws with isochoric flow leave an elastic remainder.
    const CONSTANT_THICKNESS_COSINE: f64 = 0.01;

    fn of(normal: &Vector3<f64>, polarization: &Vector3<f64>) -> Self {
        let opening = normal.dot(polarization);
        let shear = (polarization - normal * opening).norm();
        match (shear < Self::SHEAR_FREE_SINE, opening) {
            (true, opening) if opening > 0.0 => Self::DilationBand,
            (true, _) => Self::CompactionBand,
            (false, opening) if opening > Self::CONSTANT_THICKNESS_COSINE => {
                Self::DilatantShearBand
            }
            (false, opening) if opening < -Self::CONSTANT_THICKNESS_COSINE => {
                Self::CompactantShearBand
            }
            _ => Self::ShearBand,
        }
    }

    /// Name of the kind of band for use in sentences, such as "shear band".
    pub fn name(self) -> &'static str {
        match self {
            Self::DilationBand => "dilation band",
            Self::DilatantShearBand => "dilatant shear band",
            Self::ShearBand => "shear band",
            Self::CompactantShearBand => "compactant shear band",
            Self::CompactionBand => "compaction band",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plasticity::{DruckerPrager, Hardening};

    #[test]
    fn the_maximum_lies_in_the_plane_of_the_extreme_stresses() {
        let strength = Hardening::linear(1.0, 0.0);
        for (friction, dilatancy) in [(0.0, 0.0), (0.6, 0.3), (0.9, -0.2), (0.2, 1.1)] {
            let law = DruckerPrager::new(3.0, 0.3, friction, dilatancy, strength).expect("a law");
            for principal in [[1.0, -0.4, -1.1], [0.1, 0.6, -1.0], [-0.9, 0.2, 0.1]] {
                let stress = Matrix3::from_diagonal(&Vector3::from(principal));
                let plane = law.rate_moduli(&stress, 0.0).expect("moduli");
                let whole = RateModuli {
                    isotropic: false,
                    ..plane
                };
                for criterion in [Criterion::Ellipticity, Criterion::StrongEllipticity] {
                    let [plane, whole] =
                        [plane, whole].map(|moduli| moduli.critical(criterion).expect("critical"));
                    assert!((plane.modulus - whole.modulus).abs() < 1e-12);
                    assert!(
                        whole.bound - whole.modulus < 1e-5,
                        "{}",
                        whole.bound - whole.modulus
                    );
                }
            }
        }
    }
}
