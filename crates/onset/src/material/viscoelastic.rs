//! Viscoelasticity: a Prony series multiplies the deviatoric and the mean stress of a law.
//!
//! The stress is the sum of the long-term stress and of overstresses that decay. Let `P_d` and `P_m` be the deviatoric and the mean part of the stress of
//! the instantaneous law. The second Piola-Kirchhoff stresses `S = F^-1 P` satisfy (Simo 1987)
//!
//! `S = (1 - sum g_i) S_d + (1 - sum k_i) S_m + sum_i Q_i`, `dQ_i/dt + Q_i/tau_i = g_i dS_d/dt + k_i dS_m/dt`.
//!
//! A state that is reached slowly has no overstress. A small disturbance `exp(s t)` of it has the tangent
//!
//! `A(s) = A_inf + sum_i (g_i B_d + k_i B_m) s tau_i / (1 + s tau_i)`,
//!
//! where `A_inf` is the tangent of the long-term law. The tangents `B_iJkL = F_iM dS_MJ/dF_kL` of the instantaneous law lack the stress that moves with the
//! material, because the overstress is zero and its rotation costs nothing. For hypoelastic laws `B` is their elastic stiffness.

use super::{FourthOrder, Hyperelastic, MaterialError, Response};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use nalgebra::Matrix3;
use std::sync::Arc;

/// Term of a Prony series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PronyTerm {
    /// Fraction `g` of the instantaneous deviatoric stress that relaxes.
    pub shear: f64,
    /// Fraction `k` of the instantaneous mean stress that relaxes.
    pub bulk: f64,
    /// Relaxation time `tau`; time.
    pub time: f64,
}

/// Moduli that the constants of a law describe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moduli {
    /// Moduli after complete relaxation.
    LongTerm,
    /// Moduli before any relaxation.
    Instantaneous,
}

/// Largest difference of mean stresses at equal volume ratios, relative to the largest stress, that is rounding.
const MEAN_STRESS_ROUNDING: f64 = 1e-9;

/// Law with a Prony series.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Moduli, PronyTerm, Viscoelastic, library};
/// use std::sync::Arc;
/// let rubber = library().iter().find(|law| law.name == "neo-hooke").expect("a law");
/// let term = PronyTerm { shear: 0.4, bulk: 0.4, time: 0.1 };
/// let rubber = Viscoelastic::new(Arc::from(rubber.build(&[])?), vec![term], Moduli::Instantaneous)?;
/// let f = DeformationGradient::from_stretches([1.3, 0.9, 0.9])?;
/// let (fast, slow) = (rubber.instantaneous().response(&f)?, rubber.relaxed().response(&f)?);
/// assert!((slow.first_piola[(0, 0)] / fast.first_piola[(0, 0)] - 0.6).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Viscoelastic {
    law: Arc<dyn Hyperelastic>,
    terms: Vec<PronyTerm>,
    /// Ratios of the long-term and of the instantaneous deviatoric and mean stress to the stresses of the law.
    relaxed: [f64; 2],
    instantaneous: [f64; 2],
}

impl Viscoelastic {
    /// Adds a Prony series to a law whose constants are the given moduli.
    ///
    /// # Errors
    /// [`MaterialError::Prony`] for fractions that are negative or add up to one or more, for times that are not positive, and for laws whose mean stress
    /// depends on distortions unless both stresses relax alike.
    pub fn new(
        law: Arc<dyn Hyperelastic>,
        terms: Vec<PronyTerm>,
        constants: Moduli,
    ) -> Result<Self, MaterialError> {
        let wrong = |message: String| Err(MaterialError::Prony { message });
        for term in &terms {
            if !(term.time > 0.0 && term.time.is_finite()) {
                return wrong(format!(
                    "a relaxation time is {:?}; expected a positive number",
                    term.time
                ));
            }
            for (name, part) in [("g", term.shear), ("k", term.bulk)] {
                if !(0.0..1.0).contains(&part) {
                    return wrong(format!(
                        "a fraction {name} is {part:?}; expected a number from 0 to less than 1"
                    ));
                }
            }
        }
        let sums = terms.iter().fold([0.0; 2], |sums, term| {
            [sums[0] + term.shear, sums[1] + term.bulk]
        });
        for (name, sum) in ["g", "k"].into_iter().zip(sums) {
            // A law that relaxes completely is a fluid.
            if sum >= 1.0 {
                return wrong(format!(
                    "the fractions {name} add up to {sum:?}; expected less than 1"
                ));
            }
        }
        if terms.iter().any(|term| term.shear != term.bulk) && !has_own_mean_stress(&*law) {
            return wrong(
                "the mean stress of this law depends on distortions, so that deviatoric and mean stress cannot relax separately; expected g = k in each \
                 term"
                    .to_owned(),
            );
        }
        let remaining = sums.map(|sum| 1.0 - sum);
        let (relaxed, instantaneous) = match constants {
            Moduli::LongTerm => ([1.0; 2], remaining.map(f64::recip)),
            Moduli::Instantaneous => (remaining, [1.0; 2]),
        };
        Ok(Self {
            law,
            terms,
            relaxed,
            instantaneous,
        })
    }

    /// Terms of the series.
    pub fn terms(&self) -> &[PronyTerm] {
        &self.terms
    }

    /// Law with the long-term moduli, for states that are reached slowly.
    pub fn relaxed(&self) -> Arc<dyn Hyperelastic> {
        self.scaled(self.relaxed)
    }

    /// Law with the instantaneous moduli, for states that are reached too fast for relaxation.
    pub fn instantaneous(&self) -> Arc<dyn Hyperelastic> {
        self.scaled(self.instantaneous)
    }

    fn scaled(&self, factors: [f64; 2]) -> Arc<dyn Hyperelastic> {
        match factors {
            [1.0, 1.0] => Arc::clone(&self.law),
            factors => Arc::new(Scaled {
                law: Arc::clone(&self.law),
                factors,
            }),
        }
    }

    /// Law of disturbances of a relaxed state, with the long-term stress and the tangent `A_inf + x B_d + y B_m` for `parts = [x, y]`.
    ///
    /// Disturbances that are faster than all relaxation have `x = sum g_i`, `y = sum k_i`.
    pub fn disturbed(&self, parts: [f64; 2]) -> Arc<dyn Hyperelastic> {
        let [shear, bulk] = [0, 1].map(|n| parts[n] * self.instantaneous[n]);
        Arc::new(Disturbed {
            relaxed: self.relaxed(),
            law: Arc::clone(&self.law),
            viscous: [shear, bulk],
        })
    }

    /// Law of disturbances of a relaxed state that are faster than all relaxation.
    pub fn fast(&self) -> Arc<dyn Hyperelastic> {
        let parts = self.terms.iter().fold([0.0; 2], |sums, term| {
            [sums[0] + term.shear, sums[1] + term.bulk]
        });
        self.disturbed(parts)
    }
}

/// Returns true if the mean stress depends on the volume ratio alone, as for the sum of an isochoric and a volumetric energy, and for laws in rate form.
pub(super) fn has_own_mean_stress(law: &dyn Hyperelastic) -> bool {
    if law.is_path_dependent() {
        return true;
    }
    let mean = |stretches: [f64; 3]| {
        let f = DeformationGradient::from_stretches(stretches).ok()?;
        let cauchy = law.response(&f).ok()?.cauchy();
        Some((cauchy.trace(), cauchy.amax()))
    };
    let distorted = [1.02, 0.99, 1.005];
    let side = distorted.iter().product::<f64>().cbrt();
    let sheared = mean(distorted).zip(mean([side; 3]));
    sheared.is_some_and(|((own, largest), (of_volume, _))| {
        (own - of_volume).abs() <= MEAN_STRESS_ROUNDING * largest
    })
}

/// Part `T_m` of a tensor `T_iJkL` whose first two indices are a mean stress: `F^-1_Ji (F_aB T_aBkL)/3`.
fn mean_rate(tangent: &FourthOrder, f: &Matrix3<f64>, inverse: &Matrix3<f64>) -> FourthOrder {
    let rates = Matrix3::from_fn(|k, l| {
        let entries = (0..3).flat_map(|a| (0..3).map(move |b| (a, b)));
        entries
            .map(|(a, b)| f[(a, b)] * tangent[(a, b, k, l)])
            .sum::<f64>()
            / 3.0
    });
    FourthOrder::from_fn(|i, j, k, l| inverse[(j, i)] * rates[(k, l)])
}

fn inverse_of(f: &DeformationGradient) -> Result<Matrix3<f64>, MaterialError> {
    let jacobian = f.jacobian();
    let inverse = f.matrix().try_inverse();
    inverse.ok_or(MaterialError::NotFinite { jacobian })
}

/// Law whose deviatoric and mean stress are multiplied by two factors.
struct Scaled {
    law: Arc<dyn Hyperelastic>,
    factors: [f64; 2],
}

impl Scaled {
    /// Tensor with a part of the mean stress, multiplied by the factors.
    fn tensor(&self, whole: &FourthOrder, mean: &FourthOrder) -> FourthOrder {
        let [shear, bulk] = self.factors;
        FourthOrder::from_fn(|i, j, k, l| {
            shear * whole[(i, j, k, l)] + (bulk - shear) * mean[(i, j, k, l)]
        })
    }
}

impl Hyperelastic for Scaled {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let whole = self.law.response(f)?;
        let [shear, bulk] = self.factors;
        if shear == bulk {
            return Response {
                energy: shear * whole.energy,
                first_piola: whole.first_piola * shear,
                tangent: self.tensor(&whole.tangent, &whole.tangent),
                ..whole
            }
            .finite();
        }
        let mean = whole.clone().of_mean_stress(3)?;
        let side = f.jacobian().cbrt();
        // The energy of a law in rate form belongs to its path.
        let of_volume = match self.law.is_path_dependent() {
            true => whole.energy,
            false => {
                let dilation = DeformationGradient::from_components(array_of(|i| {
                    array_of(|j| if i == j { side } else { 0.0 })
                }));
                self.law.energy_and_stress(&dilation)?.0
            }
        };
        Response {
            energy: shear * whole.energy + (bulk - shear) * of_volume,
            first_piola: whole.first_piola * shear + mean.first_piola * (bulk - shear),
            tangent: self.tensor(&whole.tangent, &mean.tangent),
            ..whole
        }
        .finite()
    }

    fn is_path_dependent(&self) -> bool {
        self.law.is_path_dependent()
    }

    fn integrated_tangent(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        let Some(integrated) = self.law.integrated_tangent(f)? else {
            return Ok(None);
        };
        let mean = mean_rate(&integrated, &f.matrix(), &inverse_of(f)?);
        Ok(Some(self.tensor(&integrated, &mean)))
    }
}

/// Law of disturbances of a relaxed state: long-term stress, stiffer tangent.
struct Disturbed {
    relaxed: Arc<dyn Hyperelastic>,
    law: Arc<dyn Hyperelastic>,
    /// Factors of the deviatoric and the mean part of the tangent of the law, without the stress that moves with the material.
    viscous: [f64; 2],
}

impl Disturbed {
    /// Sum of the tangents of the overstresses.
    fn overstress(&self, f: &DeformationGradient) -> Result<FourthOrder, MaterialError> {
        let [shear, bulk] = self.viscous;
        let inverse = inverse_of(f)?;
        let (whole, mean) = match self.law.is_path_dependent() {
            // The elastic stiffness, carried forward: J F^-1_Jj F^-1_Ll c_ijkl.
            true => {
                let c = self.law.undeformed()?.tangent;
                let jacobian = f.jacobian();
                let half = FourthOrder::from_fn(|i, j, k, l| {
                    (0..3).map(|a| inverse[(j, a)] * c[(i, a, k, l)]).sum()
                });
                let whole = FourthOrder::from_fn(|i, j, k, l| {
                    let terms = (0..3).map(|a| inverse[(l, a)] * half[(i, j, k, a)]);
                    jacobian * terms.sum::<f64>()
                });
                let mean = mean_rate(&whole, &f.matrix(), &inverse);
                (whole, mean)
            }
            false => {
                let whole = self.law.response(f)?;
                let moving = |response: &Response| {
                    let second = inverse * response.first_piola;
                    let tangent = &response.tangent;
                    FourthOrder::from_fn(|i, j, k, l| {
                        tangent[(i, j, k, l)] - if i == k { second[(l, j)] } else { 0.0 }
                    })
                };
                let mean = whole.clone().of_mean_stress(3)?;
                (moving(&whole), moving(&mean))
            }
        };
        Ok(FourthOrder::from_fn(|i, j, k, l| {
            shear * whole[(i, j, k, l)] + (bulk - shear) * mean[(i, j, k, l)]
        }))
    }
}

impl Hyperelastic for Disturbed {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let relaxed = self.relaxed.response(f)?;
        let overstress = self.overstress(f)?;
        let tangent = FourthOrder::from_fn(|i, j, k, l| {
            relaxed.tangent[(i, j, k, l)] + overstress[(i, j, k, l)]
        });
        Response { tangent, ..relaxed }.finite()
    }

    // Stabilization and measures are scaled by the moduli of the relaxed law.
    fn undeformed(&self) -> Result<Response, MaterialError> {
        self.relaxed.undeformed()
    }

    // The tangent is not the derivative of the stress.
    fn is_path_dependent(&self) -> bool {
        true
    }

    fn integrated_tangent(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        let Some(integrated) = self.relaxed.integrated_tangent(f)? else {
            return Ok(None);
        };
        let overstress = self.overstress(f)?;
        Ok(Some(FourthOrder::from_fn(|i, j, k, l| {
            integrated[(i, j, k, l)] + overstress[(i, j, k, l)]
        })))
    }
}
