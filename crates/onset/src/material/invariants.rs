//! Isotropic energies as functions of the principal invariants.
//!
//! With `W_1`, `W_2`, `W_J` the derivatives of `W(I1, I2, J)`,
//!
//! `P = 2 W_1 F + 2 W_2 (I1 F - F C) + W_J cof F`, `cof F = J F^-T`,
//!
//! which needs three derivatives instead of nine. Within the plane, with `c = F_iJ F_iJ` and `j = det F` there,
//!
//! `A_iJkL = 2 W_c d_ik d_JL + 4 W_cc F_iJ F_kL + 2 W_cj (F_iJ G_kL + G_iJ F_kL) + W_jj G_iJ G_kL + W_j dG_iJ/dF_kL`, `G = cof F`,
//!
//! which needs five derivatives instead of fourteen.

use super::{LaneStress, MaterialError, StrainEnergy};
use crate::kinematics::{DeformationGradient, Invariants};
use crate::real::{Dual, Jet, LANES, Lanes, Real, Work};

/// Energy that depends on the principal invariants of `C` alone. The macro `given_by_invariants` implements [`StrainEnergy`](super::StrainEnergy) for
/// it.
pub(crate) trait InvariantEnergy {
    /// Energy `W(I1, I2, J)` per reference volume; units of stress. It must use operations of [`Real`] only.
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R;

    /// Checks that the law is defined at a state and has a stress there. By default it is defined for all `J > 0`.
    ///
    /// # Errors
    /// [`MaterialError::OutsideDomain`] with the quantity that is out of bounds.
    fn admits_invariants(&self, _i: &Invariants<f64>) -> Result<(), MaterialError> {
        Ok(())
    }
}

/// Implements `StrainEnergy` for energies in the invariants.
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

            fn plane_jet<R: crate::real::Real>(&self, f: &[[R; 3]; 3]) -> crate::real::Jet<4, R> {
                crate::material::jet_of_invariants(self, f)
            }

            fn plane_hessian<R: crate::real::Real>(&self, f: &[[R; 3]; 3], _is_diagonal: bool) -> [[R; 4]; 4] {
                crate::material::StrainEnergy::plane_jet(self, f).hessian
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

/// Energy of a law in the invariants with its derivatives with respect to the components of `F` within the plane.
pub(crate) fn jet_of_invariants<R: Real>(
    law: &(impl InvariantEnergy + StrainEnergy),
    f: &[[R; 3]; 3],
) -> Jet<4, R> {
    let across = [f[0][2], f[1][2], f[2][0], f[2][1]];
    if across.iter().any(|own| own.value() != 0.0) {
        return law.energy(&super::plane_jets(f));
    }
    let [f11, f12, f21, f22] = [f[0][0], f[0][1], f[1][0], f[1][1]];
    let [square, volume] = Jet::<2, R>::variables([
        f11 * f11 + f12 * f12 + f21 * f21 + f22 * f22,
        f11 * f22 - f12 * f21,
    ]);
    let thickness = Jet::fixed(f[2][2]);
    let thickness_squared = Jet::fixed(f[2][2] * f[2][2]);
    let jacobian = volume * thickness;
    let energy = law.of_invariants(&Invariants {
        first: square + thickness_squared,
        second: volume * volume + square * thickness_squared,
        third: jacobian * jacobian,
        jacobian,
    });
    R::vectorized(InPlane {
        f: &[f11, f12, f21, f22],
        energy: &energy,
    })
}

/// Conversion of derivatives with respect to `c = F_iJ F_iJ` and `j = det F` within the plane to derivatives with respect to `F_11`, `F_12`, `F_21`,
/// `F_22`.
struct InPlane<'a, R> {
    f: &'a [R; 4],
    energy: &'a Jet<2, R>,
}

impl<R: Real> Work for InPlane<'_, R> {
    type Output = Jet<4, R>;

    #[inline(always)]
    fn done(self) -> Jet<4, R> {
        let f = self.f;
        let g = [f[3], -f[2], -f[1], f[0]];
        let Jet {
            value,
            gradient: [by_c, by_j],
            hessian: [[cc, cj], [_, jj]],
        } = *self.energy;
        let (by_c, cc, cj) = (by_c * 2.0, cc * 4.0, cj * 2.0);
        let mut jet = Jet {
            value,
            gradient: *f,
            hessian: [*f; 4],
        };
        for p in 0..4 {
            jet.gradient[p] = by_c * f[p] + by_j * g[p];
            let (along, across) = (cc * f[p] + cj * g[p], cj * f[p] + jj * g[p]);
            for q in 0..=p {
                let mut second = along * f[q] + across * g[q];
                if p == q {
                    second = second + by_c;
                } else if p + q == 3 {
                    second = if p == 3 { second + by_j } else { second - by_j };
                }
                jet.hessian[p][q] = second;
                jet.hessian[q][p] = second;
            }
        }
        jet
    }
}

/// Invariants of several states.
struct Measured<'a>(&'a DeformationGradient<Lanes>);

impl Work for Measured<'_> {
    type Output = Invariants<Lanes>;

    #[inline(always)]
    fn done(self) -> Invariants<Lanes> {
        self.0.invariants()
    }
}

/// Stress of several states from their first invariant and the derivatives of the energy.
struct Stressed<'a> {
    f: &'a [[Lanes; 3]; 3],
    first: Lanes,
    slopes: &'a [Lanes; 3],
}

impl Work for Stressed<'_> {
    type Output = [[Lanes; 3]; 3];

    // Loops, because closures would not be compiled for the vector instructions of the machine here.
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
                // Component of F C = F F^T F.
                let squared = left[i][0] * f[0][j] + left[i][1] * f[1][j] + left[i][2] * f[2][j];
                let cofactor = f[k][m] * f[l][n] - f[k][n] * f[l][m];
                stress[i][j] = f[i][j] * along + squared * turned + cofactor * *volume;
            }
        }
        stress
    }
}

impl LaneStress {
    /// Energy and stress of a law in the invariants.
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
        for lane in 0..LANES {
            let state = Invariants {
                first: own.first.0[lane],
                second: own.second.0[lane],
                third: own.third.0[lane],
                jacobian: own.jacobian.0[lane],
            };
            let is_defined = state.jacobian > 0.0 && law.admits_invariants(&state).is_ok();
            if !is_defined {
                all.energy.0[lane] = f64::NAN;
            }
        }
        all
    }
}
