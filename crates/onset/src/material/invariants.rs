//! Isotropic energies as functions of the principal invariants.
//!
//! With `W_1`, `W_2`, `W_J` the derivatives of `W(I1, I2, J)`,
//!
//! `P = 2 W_1 F + 2 W_2 (I1 F - F C) + W_J cof F`, `cof F = J F^-T`:
//!
//! three derivatives instead of nine.

use super::{LaneStress, MaterialError};
use crate::kinematics::{DeformationGradient, Invariants};
use crate::real::{Dual, LANES, Lanes, Real, Work};

/// An energy in the principal invariants of `C` alone; what is needed to make it a [`StrainEnergy`](super::StrainEnergy) is written by
/// `given_by_invariants`.
pub(crate) trait InvariantEnergy {
    /// `W(I1, I2, J)` per reference volume; units of stress. Written with operations of [`Real`] only.
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R;

    /// Whether the law is defined at a state, and has a stress there; at all with `J > 0`, unless it says otherwise.
    ///
    /// # Errors
    /// [`MaterialError::OutsideDomain`] with the quantity that is out of bounds.
    fn admits_invariants(&self, _i: &Invariants<f64>) -> Result<(), MaterialError> {
        Ok(())
    }
}

/// Makes laws of energies in the invariants.
macro_rules! given_by_invariants {
    ($($law:ty),+ $(,)?) => {$(
        impl crate::material::StrainEnergy for $law {
            fn energy<R: crate::real::Real>(&self, f: &crate::kinematics::DeformationGradient<R>) -> R {
                crate::material::InvariantEnergy::of_invariants(self, &f.invariants())
            }

            fn admits(
                &self,
                f: &crate::kinematics::DeformationGradient,
            ) -> Result<(), crate::material::MaterialError> {
                crate::material::InvariantEnergy::admits_invariants(self, &f.invariants())
            }

            fn lane_stress(
                &self,
                states: &crate::kinematics::DeformationGradient<crate::real::Lanes>,
                _dimension: usize,
            ) -> crate::material::LaneStress {
                crate::material::LaneStress::of_invariants(self, states)
            }
        }
    )+};
}
pub(crate) use given_by_invariants;

/// The invariants of several states.
struct Measured<'a>(&'a DeformationGradient<Lanes>);

impl Work for Measured<'_> {
    type Output = Invariants<Lanes>;

    #[inline(always)]
    fn done(self) -> Invariants<Lanes> {
        self.0.invariants()
    }
}

/// The stress of several states with their first invariant, by the derivatives of the energy.
struct Stressed<'a> {
    f: &'a [[Lanes; 3]; 3],
    first: Lanes,
    slopes: &'a [Lanes; 3],
}

impl Work for Stressed<'_> {
    type Output = [[Lanes; 3]; 3];

    // Closures would not be compiled for the vectors of the machine here: loops it is.
    #[inline(always)]
    fn done(self) -> [[Lanes; 3]; 3] {
        let f = self.f;
        let [first, second, volume] = self.slopes;
        let mut left = [[Lanes([0.0; LANES]); 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                left[i][j] = f[i][0] * f[j][0] + f[i][1] * f[j][1] + f[i][2] * f[j][2];
            }
        }
        let along = (*first + *second * self.first) * 2.0;
        let turned = *second * -2.0;
        let mut stress = left;
        for i in 0..3 {
            let (k, l) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (m, n) = ((j + 1) % 3, (j + 2) % 3);
                // F C = F F^T F.
                let squared = left[i][0] * f[0][j] + left[i][1] * f[1][j] + left[i][2] * f[2][j];
                let cofactor = f[k][m] * f[l][n] - f[k][n] * f[l][m];
                stress[i][j] = f[i][j] * along + squared * turned + cofactor * *volume;
            }
        }
        stress
    }
}

impl LaneStress {
    /// That of a law in the invariants.
    pub(crate) fn of_invariants(
        law: &impl InvariantEnergy,
        states: &DeformationGradient<Lanes>,
    ) -> Self {
        let own = Lanes::vectorized(Measured(states));
        let [first, second, jacobian] =
            Dual::<3, Lanes>::variables([own.first, own.second, own.jacobian]);
        let energy = law.of_invariants(&Invariants {
            first,
            second,
            third: jacobian * jacobian,
            jacobian,
        });
        let first_piola = Lanes::vectorized(Stressed {
            f: states.components(),
            first: own.first,
            slopes: &energy.gradient,
        });
        let mut all = Self {
            energy: energy.value,
            first_piola,
        };
        all.keep(|lane| {
            let state = Invariants {
                first: own.first.0[lane],
                second: own.second.0[lane],
                third: own.third.0[lane],
                jacobian: own.jacobian.0[lane],
            };
            state.jacobian > 0.0 && law.admits_invariants(&state).is_ok()
        });
        all
    }
}
