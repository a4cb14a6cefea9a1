//! How a discretization loses stability where its material does not.

use super::{Assessment, Verdict};
use crate::bloch::Stability;

/// The mechanism of a numerical instability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Mechanism {
    /// Divergence, `Re omega^2 < 0`, of waves of finite length alone at a mean stress that is not negative (Swegle, Hicks and Attaway, J. Comput.
    /// Phys. 116 (1995) 123).
    Tensile,
    /// The same at a negative mean stress.
    Compressive,
    /// Growing oscillations: `omega^2` is complex, its real part nowhere negative. Only operators that are not Hermitian flutter.
    Flutter,
    /// Divergence, `Re omega^2 < 0`, where the long-wavelength moduli of the discretization are not strongly elliptic and those of the material
    /// are, whichever wave grows fastest.
    LongWave,
}

impl Mechanism {
    /// The mechanism of an instability, by how it develops, whether long waves grow, and the mean Cauchy stress; stress
    /// positive in tension.
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

    /// The word used in documents.
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
    /// The mechanism of the instability; `None` unless the verdict is [`Verdict::Numerical`].
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
        // The verdict is not numerical where long waves of the material grow as well.
        let long_waves_grow = self.spectrum.long_waves_grow(&self.material.minimum);
        let stability = self.spectrum.stability();
        let mechanism = || Mechanism::of(stability, long_waves_grow, self.material.mean_stress);
        (self.verdict == Verdict::Numerical).then(mechanism)
    }
}
