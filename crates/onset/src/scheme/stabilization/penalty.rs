//! Penalty against the zero-energy modes of total-Lagrangian SPH.

use super::super::products::{displacement_gradient, times_vector};
use super::super::{Interaction, Motion, PointResponse};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::{Hyperelastic, MaterialError};
use crate::real::Real;
use nalgebra::{Matrix6, Vector6};

/// Form of the penalty against zero-energy modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PenaltyForm {
    /// Published form of Ganzenmueller, with the coefficient `alpha`.
    Published,
    /// Form of LAMMPS' SMD, whose coefficient is the hourglass amplitude `hg`.
    ///
    /// `alpha(r) = hg/2 R^2/(R^2 + 0.01 h^2) r/(r + 0.1 h) r/(r + 0.01 h)` for bonds of reference length `R` and current length `r` with the support
    /// radius `h`.
    /// These denominators cannot vanish. They weaken the penalty, by more than half for nearest neighbors.
    Smd,
}

/// Offsets of the bond lengths in the denominators of the penalty, one for the squared reference length and one for each factor of the squared
/// current length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Offsets {
    reference_squared: f64,
    current: [f64; 2],
}

impl Offsets {
    /// Squared reference length of a bond plus its offset.
    pub(in super::super) fn denominator(&self, squared: f64) -> f64 {
        squared + self.reference_squared
    }

    /// Offsets of the current length in the two factors of its square; length.
    pub(in super::super) fn current(&self) -> [f64; 2] {
        self.current
    }
}

impl PenaltyForm {
    /// Returns `alpha` for a given coefficient, apart from the denominators.
    pub(in super::super) fn coefficient(self, given: f64) -> f64 {
        match self {
            Self::Published => given,
            Self::Smd => 0.5 * given,
        }
    }

    /// Offsets of the denominators for a support radius.
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

/// Forces along the bonds of a particle, proportional to the difference between a bond and its image under the deformation gradient.
///
/// `f_J = -f_I = c_J delta_J x_IJ / |x_IJ|`, `delta_J = (F_I X_IJ - x_IJ) . x_IJ / |x_IJ|`, `c_J = alpha/2 E V_I V_J W_IJ / |X_IJ|^2`
/// with Young's modulus `E` along the bond. Each end of a bond adds half of its force.
///
/// Source: Ganzenmueller, Comput. Methods Appl. Mech. Engrg. 286 (2015) 87.
pub(in super::super) struct BondPenalty<'a, const D: usize> {
    particles: Vec<Particle<D>>,
    /// Reference vectors `X_IJ`, starting with the particle itself.
    vectors: Vec<[f64; D]>,
    /// Gradients of the deformation gradient; 1/length.
    gradients: Vec<[f64; D]>,
    /// Stiffness `c_J` of each bond; force/length.
    stiffness: Vec<f64>,
    offsets: Offsets,
    response: &'a PointResponse<'a, D>,
}

impl<'a, const D: usize> BondPenalty<'a, D> {
    /// Builds the forces from the reference vectors to the neighbors, the gradients of the deformation gradient, and the weights
    /// `alpha/2 E V_I V_J W_IJ`.
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
            // F_I X_IJ - x_IJ, without the homogeneous part, which cancels.
            let error: [R; D] = array_of(|i| missed[i] - relative[i]);
            // `|x|^2` with an offset in each factor.
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

/// Compliance of the material in the reference state, `S = C^-1` with six strains and six stresses; for a sheet or bar, with the components within
/// its dimensions.
pub(in super::super) struct Compliance(Matrix6<f64>);

/// Pairs of indices in Voigt order.
const VOIGT: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

impl Compliance {
    /// Computes the compliance of a material.
    pub(in super::super) fn of(material: &dyn Hyperelastic) -> Result<Self, MaterialError> {
        let tangent = material.response(&DeformationGradient::identity())?.tangent;
        let is_strained = |(i, j): (usize, usize)| i.max(j) < material.dimension();
        // For a stressed reference state, whose tangent includes rotations, this is the part that acts on strains.
        let stiffness = Matrix6::from_fn(|row, column| {
            let ((i, j), (k, l)) = (VOIGT[row], VOIGT[column]);
            if !(is_strained((i, j)) && is_strained((k, l))) {
                // The remaining entries are not used.
                return f64::from(u8::from(row == column));
            }
            let entries = [(i, j, k, l), (j, i, k, l), (i, j, l, k), (j, i, l, k)];
            entries.iter().map(|entry| tangent[*entry]).sum::<f64>() / 4.0
        });
        let inverse = stiffness.try_inverse();
        let regular = inverse.filter(|compliance| compliance.iter().all(|x| x.is_finite()));
        Ok(Self(regular.ok_or(MaterialError::NoYoungsModulus)?))
    }

    /// Young's modulus along a vector of any length with lateral faces free of stress: `1 / (s : S : s)` with `s = n (x) n`; stress.
    pub(in super::super) fn young_modulus<const D: usize>(&self, along: &[f64; D]) -> f64 {
        let component = |i: usize| along.get(i).copied().unwrap_or(0.0);
        let stress = Vector6::from_fn(|row, _| component(VOIGT[row].0) * component(VOIGT[row].1));
        let squared: f64 = along.iter().map(|x| x * x).sum();
        squared * squared / stress.dot(&(self.0 * stress))
    }
}
