//! Finite strain: multiplicative plasticity in logarithmic principal stretches.

use super::{Branch, DruckerPrager, PlasticityError, RateModuli};
use crate::kinematics::DeformationGradient;
use crate::material::FourthOrder;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Largest number of iterations of the spectral decomposition.
const MAXIMUM_ITERATIONS: usize = 200;

/// State of a material point: `C_p^-1 = F_p^-1 F_p^-T`, which is invariant under rotations of the body, and the slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteState {
    /// Symmetric tensor `C_p^-1` with material indices; the identity before any flow.
    pub inverse_plastic_metric: Matrix3<f64>,
    /// Plastic shear strain `gamma`.
    pub slip: f64,
}

impl Default for FiniteState {
    fn default() -> Self {
        Self {
            inverse_plastic_metric: Matrix3::identity(),
            slip: 0.0,
        }
    }
}

/// Stress and state after a step at finite strain.
#[derive(Clone, Debug, PartialEq)]
pub struct FiniteUpdate {
    /// Deformation gradient at the end of the step.
    pub deformation: DeformationGradient,
    /// State at the end of the step.
    pub state: FiniteState,
    /// Kind of the step: elastic, or flow on the cone or at the apex.
    pub branch: Branch,
    law: DruckerPrager,
    /// Principal directions of stress, as columns.
    frame: Matrix3<f64>,
    trial: Vector3<f64>,
    elastic: Vector3<f64>,
    stress: Vector3<f64>,
    theta: f64,
    /// Derivatives `d tau_i / d trial_j` of the return mapping.
    consistent: Matrix3<f64>,
}

impl DruckerPrager {
    /// Computes the stress at a deformation gradient by an implicit step with exponential return mapping.
    ///
    /// The logarithmic principal strains of `b_trial = F C_p^-1 F^T` are returned to the yield surface exactly as small strains are, with the
    /// Kirchhoff stress in place of the stress (J. C. Simo, *Comput. Methods Appl. Mech. Engrg.* 99 (1992) 61). Without flow this is Hencky's law.
    ///
    /// # Errors
    /// [`PlasticityError`] under the conditions of [`DruckerPrager::update`].
    pub fn finite_update(
        &self,
        deformation: &DeformationGradient,
        state: &FiniteState,
    ) -> Result<FiniteUpdate, PlasticityError> {
        let f = deformation.matrix();
        let trial = f * state.inverse_plastic_metric * f.transpose();
        let spectrum = SymmetricEigen::try_new(trial, f64::EPSILON, MAXIMUM_ITERATIONS)
            .ok_or(PlasticityError::NotFinite)?;
        let strains = spectrum.eigenvalues.map(|value| 0.5 * value.ln());
        let frame = spectrum.eigenvectors;
        let back = self.map_back(&Matrix3::from_diagonal(&strains), state.slip)?;
        let elastic = self.elastic_strain(&back.stress).diagonal();
        let inverse_plastic_metric = match back.branch {
            Branch::Elastic => state.inverse_plastic_metric,
            _ => {
                let inverse = inverse(deformation);
                let stretches = elastic.map(|strain| (2.0 * strain).exp());
                let b = frame * Matrix3::from_diagonal(&stretches) * frame.transpose();
                inverse * b * inverse.transpose()
            }
        };
        Ok(FiniteUpdate {
            deformation: *deformation,
            state: FiniteState {
                inverse_plastic_metric,
                slip: back.slip,
            },
            branch: back.branch,
            law: *self,
            frame,
            trial: strains,
            elastic,
            stress: back.stress.diagonal(),
            theta: back.theta,
            consistent: Matrix3::from_fn(|i, j| back.tangent[(i, i, j, j)]),
        })
    }
}

impl FiniteUpdate {
    /// Kirchhoff stress `tau = J sigma` at the end of the step.
    pub fn kirchhoff(&self) -> Matrix3<f64> {
        self.frame * Matrix3::from_diagonal(&self.stress) * self.frame.transpose()
    }

    /// Cauchy stress `sigma` at the end of the step.
    pub fn cauchy(&self) -> Matrix3<f64> {
        self.kirchhoff() / self.deformation.jacobian()
    }

    /// First Piola-Kirchhoff stress `P = tau F^-T`, first index spatial.
    pub fn first_piola(&self) -> Matrix3<f64> {
        self.kirchhoff() * inverse(&self.deformation).transpose()
    }

    /// Consistent tangent `dP_iJ/dF_kL` of the step. Units of stress.
    pub fn consistent_tangent(&self) -> FourthOrder {
        let moduli = SpatialModuli::new(
            self.consistent,
            &self.stress,
            &self.trial,
            self.theta * self.law.shear_modulus(),
        );
        self.pulled_back(&moduli)
    }

    /// Continuum tangent `dP_iJ/dF_kL` of rates: with flow if the step involves flow, otherwise elastic. Units of stress.
    ///
    /// # Errors
    /// [`PlasticityError::NoDeviator`] at the apex.
    pub fn continuum_tangent(&self) -> Result<FourthOrder, PlasticityError> {
        if self.branch == Branch::Elastic {
            return Ok(self.consistent_tangent());
        }
        let rates = self.rate_moduli()?;
        let mut moduli = SpatialModuli {
            normal: rates.normal,
            shear: rates.shear,
            swap: rates.swap,
        };
        moduli.normal -= rates.flow * rates.loading.transpose() / rates.flow_stiffness();
        Ok(self.pulled_back(&moduli))
    }

    /// Rate moduli that determine localization bands, for continued flow from this state.
    ///
    /// # Errors
    /// [`PlasticityError::NoDeviator`] at the apex.
    pub fn rate_moduli(&self) -> Result<RateModuli, PlasticityError> {
        RateModuli::finite(&self.law, &self.elastic, self.state.slip, self.frame)
    }

    fn pulled_back(&self, moduli: &SpatialModuli) -> FourthOrder {
        moduli.pulled_back(&self.deformation, &self.frame)
    }
}

/// Spatial moduli `a_ijkl` of `(dP/dt F^T)_ij = a_ijkl (dv/dx)_kl` in principal axes: `a_iijj`, `a_ijij` and `a_ijji`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpatialModuli {
    pub(super) normal: Matrix3<f64>,
    pub(super) shear: Matrix3<f64>,
    pub(super) swap: Matrix3<f64>,
}

impl SpatialModuli {
    /// Computes the moduli from `d tau_i / d e_j`, the stresses, the strains `e` and the shear modulus `g` with `tau_i - tau_j = 2 g (e_i - e_j)`.
    ///
    /// They are `a_iijj = d tau_i/d e_j - tau_i delta_ij`, `a_ijij = (tau_i - tau_j) b_j / (b_i - b_j)`, `a_ijji = a_ijij b_i/b_j - tau_i`, where
    /// `b = exp 2e`. With `x = e_i - e_j` the quotient is `g exp(-x) x / sinh x`, which has no singularity.
    pub(super) fn new(
        derivative: Matrix3<f64>,
        stress: &Vector3<f64>,
        strain: &Vector3<f64>,
        shear_modulus: f64,
    ) -> Self {
        let quotient = |x: f64| if x == 0.0 { 1.0 } else { x / x.sinh() };
        let difference = |i: usize, j: usize| strain[i] - strain[j];
        Self {
            normal: derivative - Matrix3::from_diagonal(stress),
            shear: Matrix3::from_fn(|i, j| {
                let x = difference(i, j);
                shear_modulus * (-x).exp() * quotient(x)
            }),
            swap: Matrix3::from_fn(|i, j| {
                let x = difference(i, j);
                shear_modulus * x.exp() * quotient(x) - stress[i]
            }),
        }
    }

    /// Pull-back `A_iJkL = a_ijkl F^-1_Jj F^-1_Ll` from principal directions, the columns of `frame`.
    pub(super) fn pulled_back(
        &self,
        deformation: &DeformationGradient,
        frame: &Matrix3<f64>,
    ) -> FourthOrder {
        let material = inverse(deformation) * frame;
        let mut tangent = FourthOrder::from_fn(|_, _, _, _| 0.0);
        self.for_each(|[a, b, c, d], value| {
            for i in 0..3 {
                for j in 0..3 {
                    for k in 0..3 {
                        for l in 0..3 {
                            tangent[(i, j, k, l)] += value
                                * frame[(i, a)]
                                * material[(j, b)]
                                * frame[(k, c)]
                                * material[(l, d)];
                        }
                    }
                }
            }
        });
        tangent
    }

    /// Calls a function with the indices and value of every component that does not vanish.
    fn for_each(&self, mut call: impl FnMut([usize; 4], f64)) {
        for i in 0..3 {
            for j in 0..3 {
                call([i, i, j, j], self.normal[(i, j)]);
                if i != j {
                    call([i, j, i, j], self.shear[(i, j)]);
                    call([i, j, j, i], self.swap[(i, j)]);
                }
            }
        }
    }
}

pub(super) fn inverse(deformation: &DeformationGradient) -> Matrix3<f64> {
    // The determinant of a checked deformation gradient is positive.
    deformation
        .matrix()
        .try_inverse()
        .unwrap_or_else(Matrix3::zeros)
}
