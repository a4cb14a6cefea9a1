//! The zero-energy-mode penalty of total-Lagrangian SPH.

use super::super::products::{displacement_gradient, times_vector};
use super::super::{Interaction, Motion, PointResponse};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::{Hyperelastic, MaterialError};
use crate::real::Real;
use nalgebra::{Matrix6, Vector6};

/// How the zero-energy-mode penalty is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PenaltyForm {
    /// As Ganzenmueller published it, with the coefficient `alpha`.
    Published,
    /// As LAMMPS' SMD computes it: the coefficient is its hourglass amplitude `hg`, with which
    /// `alpha(r) = hg/2 R^2/(R^2 + 0.01 h^2) r/(r + 0.1 h) r/(r + 0.01 h)` for bonds of reference length `R` and current length `r` and the
    /// support radius `h`: denominators that cannot vanish weaken it, by more than half for nearest neighbors.
    Smd,
}

/// Lengths that are added to those of bonds in the denominators of the penalty: squared to the reference length, and to the current
/// length in either factor of its square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Offsets {
    reference_squared: f64,
    current: [f64; 2],
}

impl Offsets {
    /// The squared reference length of a bond with what is added to it.
    pub(in super::super) fn denominator(&self, squared: f64) -> f64 {
        squared + self.reference_squared
    }

    /// What is added to its current length in either factor of its square.
    pub(in super::super) fn current(&self) -> [f64; 2] {
        self.current
    }
}

impl PenaltyForm {
    /// The `alpha` of a coefficient, denominators apart.
    pub(in super::super) fn coefficient(self, given: f64) -> f64 {
        match self {
            Self::Published => given,
            Self::Smd => 0.5 * given,
        }
    }

    /// What is added in the denominators with a support radius.
    pub(in super::super) fn offsets(self, radius: f64) -> Offsets {
        match self {
            Self::Published => Offsets {
                reference_squared: 0.0,
                current: [0.0; 2],
            },
            Self::Smd => Offsets {
                reference_squared: 0.01 * radius * radius,
                current: [0.1 * radius, 0.01 * radius],
            },
        }
    }
}

/// The forces along the bonds of a particle by which its deformation gradient misses them:
///
/// `f_J = -f_I = c_J delta_J x_IJ / |x_IJ|`, `delta_J = (F_I X_IJ - x_IJ) . x_IJ / |x_IJ|`, `c_J = alpha/2 E V_I V_J W_IJ / |X_IJ|^2`
/// with Young's modulus `E` along the bond; the neighbors add their own half of each bond.
///
/// Source: Ganzenmueller, Comput. Methods Appl. Mech. Engrg. 286 (2015) 87.
pub(in super::super) struct BondPenalty<'a, const D: usize> {
    particles: Vec<Particle<D>>,
    /// `X_IJ`, the particle itself first.
    vectors: Vec<[f64; D]>,
    /// Those of the deformation gradient.
    gradients: Vec<[f64; D]>,
    /// `c_J`; force/length.
    stiffness: Vec<f64>,
    offsets: Offsets,
    response: &'a PointResponse<'a, D>,
}

impl<'a, const D: usize> BondPenalty<'a, D> {
    /// From reference vectors to the neighbors, the gradients of the deformation gradient, and `alpha/2 E V_I V_J W_IJ`.
    pub(in super::super) fn new(
        particles: Vec<Particle<D>>,
        vectors: Vec<[f64; D]>,
        gradients: Vec<[f64; D]>,
        weights: Vec<f64>,
        offsets: Offsets,
        response: &'a PointResponse<'a, D>,
    ) -> Self {
        let squared = |x: &[f64; D]| x.iter().map(|component| component * component).sum::<f64>();
        let both = weights.iter().zip(&vectors);
        Self {
            stiffness: both
                .map(|(weight, x)| weight / offsets.denominator(squared(x)))
                .collect(),
            offsets,
            particles,
            vectors,
            gradients,
            response,
        }
    }
}

impl<const D: usize> Interaction<D> for BondPenalty<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let u = motion.displacements;
        let change = displacement_gradient(u, &self.gradients);
        let base = self.response.leading::<R>();
        let mut forces = vec![[R::constant(0.0); D]; u.len()];
        for j in 1..u.len() {
            let reference = self.vectors[j].map(R::constant);
            let homogeneous = times_vector(&base, &reference);
            let missed = times_vector(&change, &reference);
            let relative: [R; D] = array_of(|i| u[j][i] - u[0][i]);
            let x: [R; D] = array_of(|i| homogeneous[i] + relative[i]);
            let dot =
                |a: &[R; D], b: &[R; D]| (0..D).fold(R::constant(0.0), |sum, i| sum + a[i] * b[i]);
            // F_I X_IJ - x_IJ, without the homogeneous part that both have.
            let error: [R; D] = array_of(|i| missed[i] - relative[i]);
            // |x|^2, each factor with its offset.
            let length = dot(&x, &x).sqrt();
            let [first, second] = self.offsets.current;
            let squared = (length + first) * (length + second);
            let along = dot(&error, &x) / squared * self.stiffness[j];
            for i in 0..D {
                let force = x[i] * along;
                forces[j][i] = forces[j][i] + force;
                forces[0][i] = forces[0][i] - force;
            }
        }
        forces
    }
}

/// The compliance of the material in the reference state, `S = C^-1` with six strains and six stresses; of a sheet or bar with those within its
/// dimensions.
pub(in super::super) struct Compliance(Matrix6<f64>);

/// Pairs of indices in the order of Voigt.
const VOIGT: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

impl Compliance {
    /// That of a material.
    pub(in super::super) fn of(material: &dyn Hyperelastic) -> Result<Self, MaterialError> {
        let tangent = material.response(&DeformationGradient::identity())?.tangent;
        let is_strained = |(i, j): (usize, usize)| i.max(j) < material.dimension();
        // Of a stressed reference state, whose tangent turns with it, the part that strains see.
        let stiffness = Matrix6::from_fn(|row, column| {
            let ((i, j), (k, l)) = (VOIGT[row], VOIGT[column]);
            if !(is_strained((i, j)) && is_strained((k, l))) {
                // Beyond, nothing is asked of it.
                return f64::from(u8::from(row == column));
            }
            let entries = [(i, j, k, l), (j, i, k, l), (i, j, l, k), (j, i, l, k)];
            entries.iter().map(|entry| tangent[*entry]).sum::<f64>() / 4.0
        });
        let inverse = stiffness.try_inverse();
        let regular = inverse.filter(|compliance| compliance.iter().all(|x| x.is_finite()));
        Ok(Self(regular.ok_or(MaterialError::NoYoungsModulus)?))
    }

    /// Young's modulus along a vector of any length, sideways free of stress: `1 / (s : S : s)` with `s = n (x) n`; stress.
    pub(in super::super) fn young_modulus<const D: usize>(&self, along: &[f64; D]) -> f64 {
        let component = |i: usize| along.get(i).copied().unwrap_or(0.0);
        let stress = Vector6::from_fn(|row, _| component(VOIGT[row].0) * component(VOIGT[row].1));
        let squared: f64 = along.iter().map(|x| x * x).sum();
        squared * squared / stress.dot(&(self.0 * stress))
    }
}
