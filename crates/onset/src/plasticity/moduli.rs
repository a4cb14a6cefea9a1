//! What decides on bands: the moduli of rates in principal axes of stress.

use super::finite::SpatialModuli;
use super::{DruckerPrager, PlasticityError};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// The rate moduli of a flowing state in its principal axes,
///
/// `L = a - A B^T / (h + Q:C:P)`, `A = C:P`, `B = Q:C`,
///
/// where only the elastic part `a` depends on stress and elastic strain (at finite strain); the rank-one part is the same
/// at small and at finite strain. Its acoustic tensor in the direction `n` is
/// `q(n) = q_e(n) - (A n)(B n)^T / (h + Q:C:P)`. All in units of stress; at finite strain per unit of reference volume
/// (Kirchhoff stress).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateModuli {
    /// `a_iijj`.
    pub(super) normal: Matrix3<f64>,
    /// `a_ijij`, the stiffness of a shear wave along `j` with polarization `i`.
    pub(super) shear: Matrix3<f64>,
    /// `a_ijji`.
    pub(super) swap: Matrix3<f64>,
    /// `A`.
    pub(super) flow: Vector3<f64>,
    /// `B`.
    pub(super) loading: Vector3<f64>,
    /// `h`.
    pub(super) modulus: f64,
    /// `Q:C:P`.
    pub(super) relaxation: f64,
    /// Principal directions, as columns.
    pub(super) frame: Matrix3<f64>,
    /// The elastic part is isotropic (small strain).
    pub(super) isotropic: bool,
    /// Only directions within the plane of the first two axes are admitted.
    pub(super) sheet: bool,
}

impl DruckerPrager {
    /// The rate moduli of a flowing state at small strain.
    ///
    /// # Errors
    /// [`PlasticityError::NoDeviator`] at the apex, [`PlasticityError::NotFinite`].
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
    /// At small strain, with principal stresses.
    pub(super) fn small(
        law: &DruckerPrager,
        stress: &Vector3<f64>,
        slip: f64,
        frame: Matrix3<f64>,
    ) -> Result<Self, PlasticityError> {
        let shear = law.shear_modulus();
        let moduli = SpatialModuli {
            normal: hooke(law),
            shear: Matrix3::repeat(shear),
            swap: Matrix3::repeat(shear),
        };
        Self::new(law, stress, slip, frame, moduli, true)
    }

    /// At finite strain, with elastic logarithmic strains.
    pub(super) fn finite(
        law: &DruckerPrager,
        strain: &Vector3<f64>,
        slip: f64,
        frame: Matrix3<f64>,
    ) -> Result<Self, PlasticityError> {
        let stress = law
            .elastic_stress(&Matrix3::from_diagonal(strain))
            .diagonal();
        let moduli = SpatialModuli::new(hooke(law), &stress, strain, law.shear_modulus());
        Self::new(law, &stress, slip, frame, moduli, false)
    }

    fn new(
        law: &DruckerPrager,
        stress: &Vector3<f64>,
        slip: f64,
        frame: Matrix3<f64>,
        moduli: SpatialModuli,
        isotropic: bool,
    ) -> Result<Self, PlasticityError> {
        let (flow, normal) = law.directions(&Matrix3::from_diagonal(stress))?;
        Ok(Self {
            normal: moduli.normal,
            shear: moduli.shear,
            swap: moduli.swap,
            flow: law.elastic_stress(&flow).diagonal(),
            loading: law.elastic_stress(&normal).diagonal(),
            modulus: law.hardening().modulus(slip),
            relaxation: law.flow_stiffness(),
            frame,
            isotropic,
            sheet: false,
        })
    }

    /// The moduli of a sheet normal to the third principal axis, whose surfaces stay free of stress: the thickness adapts.
    ///
    /// Bands that cross the whole sheet (localized necks) are told by it; its directions are those within the sheet.
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

    /// The plastic modulus `h` of the state. Units of stress.
    pub fn modulus(&self) -> f64 {
        self.modulus
    }

    /// The same state with another plastic modulus.
    pub fn with_modulus(&self, modulus: f64) -> Self {
        Self { modulus, ..*self }
    }

    /// `h + Q:C:P`, positive. Units of stress.
    pub fn flow_stiffness(&self) -> f64 {
        self.modulus + self.relaxation
    }

    /// The acoustic tensor of the elastic part in a spatial direction. Shape 3 x 3, units of stress.
    pub fn elastic_acoustic_tensor(&self, direction: &Vector3<f64>) -> Matrix3<f64> {
        let n = self.frame.transpose() * direction;
        self.frame * self.principal_acoustic_tensor(&n) * self.frame.transpose()
    }

    /// The acoustic tensor `q(n) = q_e(n) - (A n)(B n)^T / (h + Q:C:P)` of a flowing state in a spatial direction.
    /// Shape 3 x 3, not symmetric if `mu != beta`, units of stress.
    pub fn acoustic_tensor(&self, direction: &Vector3<f64>) -> Matrix3<f64> {
        let n = self.frame.transpose() * direction;
        let (a, b) = self.tractions(&n);
        let q = self.principal_acoustic_tensor(&n) - a * b.transpose() / self.flow_stiffness();
        self.frame * q * self.frame.transpose()
    }

    /// `q_e(n)` in principal axes: `q_ii = a_ijij n_j^2`, `q_ik = (a_iikk + a_ikki) n_i n_k`.
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

    /// `A n` and `B n` in principal axes.
    pub(super) fn tractions(&self, n: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        (self.flow.component_mul(n), self.loading.component_mul(n))
    }

    /// `a_ijij`, also for `i = j`.
    pub(super) fn wave_stiffness(&self, i: usize, j: usize) -> f64 {
        if i == j {
            self.normal[(i, i)]
        } else {
            self.shear[(i, j)]
        }
    }

    /// `a_iikk + a_ikki`.
    pub(super) fn coupling(&self, i: usize, k: usize) -> f64 {
        self.normal[(i, k)] + self.swap[(i, k)]
    }
}

/// Hooke's law in principal axes, `K + 4G/3` and `K - 2G/3`.
fn hooke(law: &DruckerPrager) -> Matrix3<f64> {
    let (shear, bulk) = (law.shear_modulus(), law.bulk_modulus());
    Matrix3::repeat(bulk - 2.0 / 3.0 * shear) + Matrix3::identity() * (2.0 * shear)
}
