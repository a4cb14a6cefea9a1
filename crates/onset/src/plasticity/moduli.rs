//! Rate moduli in principal axes of stress, which determine localization bands.

use super::finite::SpatialModuli;
use super::{DruckerPrager, Flow, FlowLaw, PlasticityError};
use crate::algebra::Each;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Rate moduli of a flowing state in its principal axes, `L = a - A B^T / (h + Q:C:P)`, `A = C:P`, `B = Q:C`.
///
/// Only the elastic part `a` depends on stress and elastic strain (at finite strain). The rank-one part is the same at small and at finite strain.
/// The acoustic tensor in the direction `n` is `q(n) = q_e(n) - (A n)(B n)^T / (h + Q:C:P)`. All are in units of stress; at finite strain per unit of
/// reference volume (Kirchhoff stress).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateModuli {
    /// Normal moduli `a_iijj` in principal axes.
    pub(super) normal: Matrix3<f64>,
    /// Shear moduli `a_ijij`, the stiffness of a shear wave along `j` with polarization `i`.
    pub(super) shear: Matrix3<f64>,
    /// Cross moduli `a_ijji` in principal axes.
    pub(super) swap: Matrix3<f64>,
    /// Vector `A` of flow.
    pub(super) flow: Vector3<f64>,
    /// Vector `B` of loading.
    pub(super) loading: Vector3<f64>,
    /// Plastic modulus `h` of the state.
    pub(super) modulus: f64,
    /// Relaxation `Q:C:P` by flow.
    pub(super) relaxation: f64,
    /// Principal directions, as columns.
    pub(super) frame: Matrix3<f64>,
    /// Principal stresses of the state.
    pub(super) stress: Vector3<f64>,
    /// Whether the maximum over directions lies in the plane of the extreme flows: the elastic part is isotropic (small strain), and the deviators of
    /// `P` and `Q` are parallel.
    pub(super) isotropic: bool,
    /// Whether only directions within the plane of the first two axes are admitted.
    pub(super) sheet: bool,
}

impl DruckerPrager {
    /// Computes the rate moduli of a flowing state at small strain.
    ///
    /// # Errors
    /// [`PlasticityError::NoDeviator`] at the apex, [`PlasticityError::NotFinite`] if a number over- or underflows.
    pub fn rate_moduli(
        &self,
        stress: &Matrix3<f64>,
        slip: f64,
    ) -> Result<RateModuli, PlasticityError> {
        let spectrum = SymmetricEigen::try_new(*stress, f64::EPSILON, 200)
            .ok_or(PlasticityError::NotFinite)?;
        RateModuli::small(self, &spectrum.eigenvalues, slip, spectrum.eigenvectors)
    }
}

impl RateModuli {
    /// Moduli at small strain, from principal stresses.
    pub(super) fn small(
        law: &DruckerPrager,
        stress: &Vector3<f64>,
        slip: f64,
        frame: Matrix3<f64>,
    ) -> Result<Self, PlasticityError> {
        Ok(Self::of(
            &law.flow_unlimited(stress, slip)?,
            stress,
            frame,
            false,
        ))
    }

    /// Moduli at finite strain, from elastic logarithmic strains.
    pub(super) fn finite(
        law: &DruckerPrager,
        strain: &Vector3<f64>,
        slip: f64,
        frame: Matrix3<f64>,
    ) -> Result<Self, PlasticityError> {
        let stress = FlowLaw::elasticity(law).stress(strain);
        Ok(Self::of(
            &law.flow_unlimited(&stress, slip)?,
            &stress,
            frame,
            true,
        ))
    }

    /// Computes the moduli of a flow in principal axes, the columns of `frame`, at small or at finite strain. The stresses are in the measure of the
    /// flow.
    pub fn of(flow: &Flow, stress: &Vector3<f64>, frame: Matrix3<f64>, is_finite: bool) -> Self {
        let elasticity = &flow.elasticity;
        let moduli = match is_finite {
            // Only differences of strains matter, and the deviators have the same differences.
            true => SpatialModuli::new(
                elasticity.normal(),
                stress,
                &elasticity.strain(stress),
                elasticity.shear,
            ),
            false => SpatialModuli {
                normal: elasticity.normal(),
                shear: Matrix3::repeat(elasticity.shear),
                swap: Matrix3::repeat(elasticity.shear),
            },
        };
        Self {
            normal: moduli.normal,
            shear: moduli.shear,
            swap: moduli.swap,
            flow: elasticity.stress(&flow.direction),
            loading: elasticity.stress(&flow.normal),
            modulus: flow.modulus(),
            relaxation: flow.relaxation(),
            frame,
            stress: *stress,
            isotropic: !is_finite && are_parallel(&flow.direction, &flow.normal),
            sheet: false,
        }
    }

    /// Moduli of a sheet normal to the third principal axis, whose surfaces remain stress-free while the thickness adapts.
    ///
    /// They determine bands across the whole sheet (localized necks). Only directions within the sheet are admitted.
    pub fn in_sheet(&self) -> Self {
        let stiffness = self.normal[(2, 2)];
        let column = self.normal.column(2) / stiffness;
        let mut sheet = *self;
        sheet.normal -= column * self.normal.row(2);
        sheet.flow -= column * self.flow[2];
        sheet.loading -= self.normal.row(2).transpose() * (self.loading[2] / stiffness);
        sheet.relaxation -= self.loading[2] * self.flow[2] / stiffness;
        sheet.sheet = true;
        sheet
    }

    /// Plastic modulus `h` of the state. Units of stress.
    pub fn modulus(&self) -> f64 {
        self.modulus
    }

    /// Returns the moduli with another plastic modulus.
    pub fn with_modulus(&self, modulus: f64) -> Self {
        Self { modulus, ..*self }
    }

    /// Denominator `h + Q:C:P`, positive. Units of stress.
    pub fn flow_stiffness(&self) -> f64 {
        self.modulus + self.relaxation
    }

    /// Acoustic tensor of the elastic part in a spatial direction. Shape 3 x 3, units of stress.
    pub fn elastic_acoustic_tensor(&self, direction: &Vector3<f64>) -> Matrix3<f64> {
        let n = self.frame.transpose() * direction;
        self.frame * self.principal_acoustic_tensor(&n) * self.frame.transpose()
    }

    /// Acoustic tensor `q(n) = q_e(n) - (A n)(B n)^T / (h + Q:C:P)` of a flowing state in a spatial direction.
    ///
    /// Shape 3 x 3, not symmetric if `mu != beta`, units of stress.
    pub fn acoustic_tensor(&self, direction: &Vector3<f64>) -> Matrix3<f64> {
        let n = self.frame.transpose() * direction;
        let (a, b) = self.tractions(&n);
        let q = self.principal_acoustic_tensor(&n) - a * b.transpose() / self.flow_stiffness();
        self.frame * q * self.frame.transpose()
    }

    /// Elastic acoustic tensor `q_e(n)` in principal axes: `q_ii = a_ijij n_j^2`, `q_ik = (a_iikk + a_ikki) n_i n_k`.
    pub(super) fn principal_acoustic_tensor(&self, n: &Vector3<f64>) -> Matrix3<f64> {
        Matrix3::from_fn(|i, k| {
            if i == k {
                (0..3)
                    .map(|j| self.wave_stiffness(i, j) * n[j] * n[j])
                    .sum()
            } else {
                self.coupling(i, k) * n[i] * n[k]
            }
        })
    }

    /// Tractions `A n` and `B n` in principal axes.
    pub(super) fn tractions(&self, n: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        (self.flow.component_mul(n), self.loading.component_mul(n))
    }

    /// Wave stiffness `a_ijij`, including `i = j`.
    pub(super) fn wave_stiffness(&self, i: usize, j: usize) -> f64 {
        if i == j {
            self.normal[(i, i)]
        } else {
            self.shear[(i, j)]
        }
    }

    /// Coupling `a_iikk + a_ikki` of two axes.
    pub(super) fn coupling(&self, i: usize, k: usize) -> f64 {
        self.normal[(i, k)] + self.swap[(i, k)]
    }
}

/// Returns true if the deviators of two diagonal tensors are parallel to rounding.
fn are_parallel(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    let [a, b] = [a, b].each(|v| v.add_scalar(-v.sum() / 3.0));
    a.cross(&b).norm() <= 1e-12 * a.norm() * b.norm() && a.dot(&b) > 0.0
}
