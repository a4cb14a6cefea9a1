//! Measures of discretizations, compared with closed forms, brute force, and other computations of the same numbers.

mod fidelity;
mod frequencies;
mod growing_states;
mod onsets;
mod spurious;
mod zero_energy;

#[path = "../shared/hunt.rs"]
mod hunt;

use onset::approximation::Approximation;
use onset::lattice::LatticeKind;
use onset::method::{KernelMethodChoices, Method};
use onset::quadrature::Quadrature;
use onset::scheme::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};

/// Lagrangian kernel method with nodal quadrature.
fn nodal(kind: LatticeKind) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: kind,
        quadrature: Quadrature::Nodal,
        ..KernelMethodChoices::default()
    }
}

fn method<const D: usize>(discretization: KernelMethodChoices) -> Method<D> {
    Method::new(discretization).expect("a method")
}

/// Kernel method with nodal quadrature and several particles in a cell.
fn on_crystal<const D: usize>(discretization: &KernelMethodChoices) -> KernelScheme<D> {
    let crystal = discretization.crystal::<D>().expect("a crystal");
    let choices = KernelChoices {
        density: discretization.density,
        kernel: discretization.kernel,
        radius: discretization.support * discretization.spacing,
        approximation: discretization.approximation,
        frame: discretization.frame,
        support_size: discretization.support_size,
    };
    KernelScheme::new(crystal, CrystalQuadrature::Nodal, choices).expect("a scheme")
}

/// Moving least squares with stress points.
fn linear_complete(kind: LatticeKind) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: kind,
        approximation: Approximation::Mls,
        ..KernelMethodChoices::default()
    }
}
