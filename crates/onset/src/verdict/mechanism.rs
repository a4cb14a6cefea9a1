//! Mechanisms of numerical instability.

use super::{Assessment, Verdict};
use crate::bloch::Stability;

/// Mechanism of a numerical instability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Mechanism {
    /// Divergence (`Re omega^2 < 0`) of waves of finite length only, at zero or tensile mean stress (Swegle, Hicks and Attaway, J. Comput. Phys. 116
    /// (1995) 123).
    Tensile,
    /// Divergence of waves of finite length only, at compressive mean stress.
    Compressive,
    /// Growing oscillations: some `omega^2` are complex, and no real part is negative. Only non-Hermitian operators flutter.
    Flutter,
    /// Divergence (`Re omega^2 < 0`) with long-wavelength moduli that are not strongly elliptic, although the moduli of the material are. The fastest
    /// growing wave can have any length.
    LongWave,
}

impl Mechanism {
    /// All mechanisms of numerical instability, in the order of their numbers in arrays.
    pub const ALL: [Self; 4] = [
        Self::Tensile,
        Self::Compressive,
        Self::Flutter,
        Self::LongWave,
    ];

    /// Mechanism of an instability, from its kind (divergence or flutter), the growth of long waves and the mean Cauchy stress, positive in tension.
    pub fn of(stability: Stability, long_waves_grow: bool, mean_stress: f64) -> Self {
        if stability == Stability::Flutter {
            Self::Flutter
        } else if long_waves_grow {
            Self::LongWave
        } else if mean_stress >= 0.0 {
            Self::Tensile
        } else {
            Self::Compressive
        }
    }

    /// Name of the mechanism in output documents.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tensile => "tensile",
            Self::Compressive => "compressive",
            Self::Flutter => "flutter",
            Self::LongWave => "long-wave",
        }
    }
}

impl<const D: usize> Assessment<D> {
    /// Mechanism of the instability; `None` unless the verdict is [`Verdict::Numerical`].
    ///
    /// ```
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::ModifiedMooneyRivlin;
    /// use onset::method::{Frame, KernelMethodChoices, Method};
    /// use onset::verdict::{Mechanism, assess};
    ///
    /// let sph = KernelMethodChoices { frame: Frame::Eulerian, ..KernelMethodChoices::default() };
    /// let method = Method::<2>::new(sph)?;
    /// let state = DeformationGradient::from_stretches([1.2, 1.0, 1.0])?;
    /// let found = assess(&method, &ModifiedMooneyRivlin::default(), &state)?;
    /// assert_eq!(found.mechanism(), Some(Mechanism::Tensile));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mechanism(&self) -> Option<Mechanism> {
        // If waves of the material and long waves of the discretization both grow, the verdict is physical.
        let long_waves_grow = self.spectrum.long_waves_grow(&self.material.minimum);
        let stability = self.spectrum.stability();
        let mechanism = || Mechanism::of(stability, long_waves_grow, self.material.mean_stress);
        (self.verdict == Verdict::Numerical).then(mechanism)
    }
}
