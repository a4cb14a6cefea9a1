//! Dissipation of an acoustic Riemann solver between pairs of particles.

use super::super::moduli::Moduli;
use super::super::products::{displacement_gradient, times_vector};
use super::super::{Interaction, LagrangianPoint, Motion};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::{Hyperelastic, MaterialError};
use crate::real::Real;
use nalgebra::{SMatrix, SVector};

/// Velocities whose jump between two particles an acoustic Riemann solver dissipates.
///
/// The solver gives a pair the traction `(t_I + t_J)/2 + Z [v]/2`, with the impedance `Z = rho (c_p n (x) n + c_s (1 - n (x) n))` of pressure and shear
/// waves. The second term acts over the area `|A_IJ|` of the pair, `A_IJ = V_I g_IJ - V_J g_JI` with the gradients `g` of the method, in the direction
/// `n` of `F^-T A_IJ`. This is its linear form about a homogeneous state, with the direction `n` of the state and the wave speeds `c_p`, `c_s` of the
/// reference state. It needs no coefficient. Each particle contributes its end of the pair, with the area `V_I g_IJ`, its direction and the velocity
/// gradient of this particle; in a Bravais lattice both ends are equal.
///
/// Source: Lee, Gil, Ghavamian, Bonet, Comput. Methods Appl. Mech. Engrg. 344 (2019) 209.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Upwinding {
    /// The method has no dissipation of this kind.
    None,
    /// Velocities are constant around each particle: `[v] = v_J - v_I`, of first order in the spacing.
    Constant,
    /// Velocities are linear around each particle: `[v] = v_J - v_I - (L_I + L_J) X_IJ / 2` with the velocity gradients `L` in material coordinates. Only
    /// nonuniform gradients are dissipated.
    Linear,
}

/// Half of the dissipation of all pairs of a particle, which belongs to its end of each pair.
pub(in super::super) struct RiemannPairs<'a, const D: usize> {
    point: &'a LagrangianPoint<D>,
    /// Gradients of the particle, for its velocity gradient.
    gradients: Vec<[f64; D]>,
    /// Reference vectors to the neighbors; length.
    vectors: &'a [[f64; D]],
    /// Factors of the jumps, `|A| Z / 2` with the half of the area of this end; mass/time. The particle itself has zero.
    factors: Vec<SMatrix<f64, D, D>>,
    is_linear: bool,
}

impl<'a, const D: usize> RiemannPairs<'a, D> {
    /// Builds the pairs of a particle; `None` without upwinding.
    ///
    /// # Errors
    /// [`MaterialError`] if the material cannot be evaluated in the reference state.
    pub(in super::super) fn new(
        upwinding: Upwinding,
        point: &'a LagrangianPoint<D>,
        vectors: &'a [[f64; D]],
        density: f64,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<Self>, MaterialError> {
        if upwinding == Upwinding::None {
            return Ok(None);
        }
        let moduli = Moduli::of::<D>(material)?;
        let pressure = moduli.bulk + 2.0 * (1.0 - 1.0 / D as f64) * moduli.shear;
        let speed = |modulus: f64| (modulus.max(0.0) / density).sqrt();
        let [pressure, shear] = [pressure, moduli.shear].map(speed);
        let cofactor = f.leading::<D>().try_inverse().map(|own| own.transpose());
        let cofactor = cofactor.unwrap_or_else(SMatrix::identity);
        let factor = |(number, gradient): (usize, &SVector<f64, D>)| {
            let area = gradient * point.volume();
            let normal = (cofactor * area).try_normalize(0.0);
            match normal.filter(|_| number > 0) {
                Some(n) => {
                    let along = n * n.transpose();
                    let impedance = along * pressure + (SMatrix::identity() - along) * shear;
                    impedance * (0.5 * density * area.norm())
                }
                None => SMatrix::zeros(),
            }
        };
        Ok(Some(Self {
            gradients: point.gradients().iter().map(|g| (*g).into()).collect(),
            factors: point.gradients().iter().enumerate().map(factor).collect(),
            is_linear: upwinding == Upwinding::Linear,
            point,
            vectors,
        }))
    }
}

impl<const D: usize> Interaction<D> for RiemannPairs<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        self.point.particles()
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let v = motion.velocities;
        let rate = displacement_gradient(v, &self.gradients);
        let mut forces = vec![[R::constant(0.0); D]; v.len()];
        for j in 1..v.len() {
            let mut jump: [R; D] = array_of(|i| v[j][i] - v[0][i]);
            if self.is_linear {
                let uniform = times_vector(&rate, &self.vectors[j].map(R::constant));
                jump = array_of(|i| jump[i] - uniform[i]);
            }
            for i in 0..D {
                let factor = self.factors[j].row(i);
                let force = (0..D).fold(R::constant(0.0), |sum, k| sum + jump[k] * factor[k]);
                forces[0][i] = forces[0][i] + force;
                forces[j][i] = forces[j][i] - force;
            }
        }
        forces
    }

    fn is_viscous(&self) -> bool {
        true
    }
}
