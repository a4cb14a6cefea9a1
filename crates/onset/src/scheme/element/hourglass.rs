//! Control of the hourglass modes of one-point elements, after Flanagan and Belytschko, Int. J. Numer. Meth. Engng. 17 (1981) 679.

use super::HourglassScale;
use super::shape::sign;
use crate::algebra::{Each, array_of};
use crate::lattice::Particle;
use crate::real::Real;
use crate::scheme::{Interaction, Motion, SeenForm, StrainOperator};
use nalgebra::SVector;

/// Hourglass mode of an element, `q = sum_a gamma_a u_a`, which is zero for every linear field.
#[derive(Clone, Debug)]
pub(super) struct HourglassMode<const D: usize> {
    nodes: Vec<Particle<D>>,
    /// Components of the hourglass vector, `gamma_a = (Gamma_a - b_a . sum_c Gamma_c X_c) / 2^D`.
    gamma: Vec<f64>,
    /// Stiffness for unit modulus and unit coefficient; length^(D-2).
    pub(super) stiffness: f64,
    /// Viscosity for unit impedance and unit coefficient; length^(D-1).
    pub(super) viscosity: f64,
}

impl<const D: usize> HourglassMode<D> {
    /// Adds the components of `q` to the strain operator.
    pub(super) fn seen_by(&self, strain: &mut StrainOperator<D>) {
        let component = |i: usize| {
            let along = |weight: &f64| SVector::from_fn(|j, _| if i == j { *weight } else { 0.0 });
            SeenForm::Control(self.gamma.iter().map(along).collect())
        };
        strain.add(self.nodes.clone(), (0..D).map(component).collect());
    }
}

impl HourglassScale {
    /// Returns stiffness and viscosity for unit modulus, impedance and coefficients, with `gamma` as below.
    fn of<const D: usize>(self, volume: f64, gradients: &[SVector<f64, D>]) -> [f64; 2] {
        let squares: f64 = gradients.iter().map(SVector::norm_squared).sum();
        // The codes do not divide gamma by the number of nodes.
        let codes = (gradients.len() * gradients.len()) as f64;
        match (self, D) {
            (Self::Gradients, _) => [volume * squares, volume * squares.sqrt()],
            (Self::Radioss, 3) => {
                [0.038 * volume.cbrt(), 0.25 * volume.cbrt().powi(2)].each(|x| codes * x)
            }
            (Self::Radioss, _) => [0.0, 0.5 * codes * volume.sqrt()],
        }
    }
}

/// Hourglass modes of a multilinear element: products of two or more reference coordinates at the nodes. Quadrilaterals have one mode, bricks four,
/// bars none. `gradients` are the mean gradients of the shape functions of the element, and `volume` is its volume.
pub(super) fn hourglass_modes<const D: usize>(
    nodes: &[Particle<D>],
    positions: &[SVector<f64, D>],
    gradients: &[SVector<f64, D>],
    volume: f64,
    scale: HourglassScale,
) -> Vec<HourglassMode<D>> {
    let [stiffness, viscosity] = scale.of(volume, gradients);
    let mode = |axes: usize| {
        let product = |n: usize| -> f64 {
            let along = (0..D).filter(|i| axes >> i & 1 == 1);
            along.map(|i| sign(n, i)).product()
        };
        let moment: SVector<f64, D> = positions
            .iter()
            .enumerate()
            .map(|(n, x)| x * product(n))
            .sum();
        let gamma = |(n, b): (usize, &SVector<f64, D>)| {
            (product(n) - b.dot(&moment)) / gradients.len() as f64
        };
        HourglassMode {
            nodes: nodes.to_vec(),
            gamma: gradients.iter().enumerate().map(gamma).collect(),
            stiffness,
            viscosity,
        }
    };
    let modes = (0..1_usize << D).filter(|axes| axes.count_ones() >= 2);
    modes.map(mode).collect()
}

/// Hourglass mode with a spring and a dashpot.
pub(super) struct Resisted<'a, const D: usize> {
    pub(super) mode: &'a HourglassMode<D>,
    /// Spring constant; force/length.
    pub(super) stiffness: f64,
    /// Dashpot constant; force/velocity.
    pub(super) viscosity: f64,
}

impl<const D: usize> Interaction<D> for Resisted<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.mode.nodes
    }

    /// Returns the nodal forces `f_a = -gamma_a (k q + c dq/dt)`.
    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let gamma = &self.mode.gamma;
        let resistance: [R; D] = array_of(|i| {
            let mut sum = R::constant(0.0);
            for (a, weight) in gamma.iter().enumerate() {
                let (u, v) = (motion.displacements[a][i], motion.velocities[a][i]);
                sum = sum + (u * self.stiffness + v * self.viscosity) * *weight;
            }
            sum
        });
        gamma
            .iter()
            .map(|weight| resistance.each(|component| component * -*weight))
            .collect()
    }

    fn is_viscous(&self) -> bool {
        self.viscosity != 0.0
    }
}
