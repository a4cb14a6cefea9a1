//! Conversion of settings to the choices of a method of any family.

use crate::settings::{Bonds, Control, Family, Settings, Shear, Unknowns, Velocities};
use onset::analysis::{ReducedCell, reduced_cell};
use onset::lattice::LatticeError;
use onset::material::MaterialError;
use onset::method::KernelMethodChoices;
use onset::method::MethodError;
use onset::scheme::conforming::ConformingChoices;
use onset::scheme::element::{ElementChoices, Formulation as ElementFormulation};
use onset::scheme::sph::{ShearForces, TotalLagrangianChoices, UpdatedSphChoices};
use onset::scheme::stabilization::{ArtificialStress, ArtificialViscosity};
use onset::scheme::{
    BondForm, BondModel, Formulation, MaterialPointChoices, MethodChoices, PeridynamicsChoices,
    Transfer, ZeroEnergyControl,
};

/// Returns the method that settings describe.
pub fn method(settings: &Settings) -> MethodChoices {
    let particles = || Box::new(settings.discretization.clone());
    match settings.method.method {
        Family::Kernel => MethodChoices::Kernel(particles()),
        Family::TotalLagrangianSph => {
            MethodChoices::TotalLagrangianSph(particles(), total_lagrangian(settings))
        }
        Family::UpdatedSph => MethodChoices::UpdatedSph(particles(), updated(settings)),
        Family::FiniteElements => MethodChoices::FiniteElements(elements(settings)),
        Family::Conforming => MethodChoices::Conforming(particles(), conforming(settings)),
        Family::Peridynamics => MethodChoices::Peridynamics(particles(), peridynamics(settings)),
        Family::MaterialPoints => {
            MethodChoices::MaterialPoints(particles(), material_points(settings))
        }
    }
}

/// Numbers of particles of the cell in the settings and of its primitive cell, if that is smaller.
pub(crate) fn reduced(settings: &Settings) -> Option<ReducedCell> {
    reduced_cell(&method(settings))
}

/// Hint for a method that cannot be evaluated, to be appended to the message; empty if the message suffices.
pub fn hint(error: &MethodError) -> &'static str {
    match error {
        MethodError::SupportTooSmall { .. } | MethodError::SingularMoment { .. } => {
            "\n  hint: enlarge discretization.support; the support of an Eulerian kernel can also follow the particles, \
             discretization.support-size=scaled or convected"
        }
        MethodError::SupportTooLarge { .. } => {
            "\n  hint: reduce discretization.support (1.2 to 4 spacings are usual); the support of an Eulerian kernel can \
             also follow the particles, discretization.support-size=scaled or convected"
        }
        MethodError::HorizonTooSmall { .. } => "\n  hint: enlarge discretization.horizon",
        MethodError::HorizonTooLarge { .. } => {
            "\n  hint: reduce discretization.horizon (3 spacings are usual)"
        }
        MethodError::NotPlanar { .. } => {
            "\n  hint: give in-plane components only, or choose a three-dimensional lattice, for example \
             discretization.lattice=face-centered-cubic"
        }
        MethodError::Lattice(LatticeError::Vectors { .. }) => {
            "\n  hint: set discretization.vectors, for example to 1,0,0.3,1.1 for an oblique lattice"
        }
        MethodError::Lattice(LatticeError::Sheared { .. }) => {
            "\n  hint: choose primitive vectors of similar lengths, or a smaller shear: where double precision resolves the positions of \
             neighbors"
        }
        MethodError::Lattice(LatticeError::Elongated { .. }) => {
            "\n  hint: choose discretization.vectors of similar lengths, or a discretization.aspect nearer to 1"
        }
        MethodError::Lattice(LatticeError::Dependent { .. }) => {
            "\n  hint: give discretization.vectors that are linearly independent"
        }
        MethodError::Material(MaterialError::NoYoungsModulus) => {
            "\n  hint: omit discretization.penalty, or give the law a shear modulus (material.mu)"
        }
        MethodError::Material(MaterialError::NoShearModulus) => {
            "\n  hint: omit discretization.penalty and discretization.shear-forces, or give the law a shear modulus (material.mu)"
        }
        MethodError::Material(MaterialError::NoPlaneStress { .. }) => {
            "\n  hint: set material.plane=strain; plane stress is for chains and lattices of the plane, and for laws with stiffness against all strains"
        }
        MethodError::Material(MaterialError::PlaneStressEnds { .. }) => {
            "\n  hint: choose a smaller deformation, or a law that stays stiff at large deformation, such as neo-hooke"
        }
        MethodError::Material(MaterialError::NotFinite { .. }) | MethodError::NotFinite => {
            "\n  hint: choose a less extreme deformation, or units in which the material's constants, spacing and \
             density are not that large or small"
        }
        _ => "",
    }
}

fn viscosity(settings: &Settings) -> Option<ArtificialViscosity> {
    (settings.method.viscosity != 0.0).then(|| ArtificialViscosity {
        alpha: settings.method.viscosity,
        switch: settings.method.viscosity_switch,
        ..ArtificialViscosity::default()
    })
}

fn total_lagrangian(settings: &Settings) -> TotalLagrangianChoices {
    let choices = &settings.discretization;
    TotalLagrangianChoices {
        density: choices.density,
        kernel: choices.kernel,
        radius: radius(choices),
        corrected: settings.method.corrected,
        gradient: settings.method.gradient,
        penalty: settings.method.penalty,
        penalty_form: settings.method.penalty_form,
        viscosity: viscosity(settings),
        upwinding: settings.method.upwinding,
        velocity_smoothing: settings.method.velocity_smoothing,
        shear: shear(
            settings,
            TotalLagrangianChoices::PUBLISHED_SHEAR_COEFFICIENT,
        ),
    }
}

/// Shear forces, with the published coefficient by default.
fn shear(settings: &Settings, published: f64) -> ShearForces {
    match settings.method.shear_forces {
        Shear::Stress => ShearForces::Stress,
        Shear::Pairs => ShearForces::Pairs {
            coefficient: settings.method.shear_coefficient.unwrap_or(published),
        },
    }
}

fn radius(choices: &KernelMethodChoices) -> f64 {
    choices.support * choices.spacing
}

fn updated(settings: &Settings) -> UpdatedSphChoices {
    let (choices, method) = (&settings.discretization, &settings.method);
    let artificial_stress = (method.artificial_stress != 0.0).then_some(ArtificialStress {
        epsilon: method.artificial_stress,
        exponent: method.artificial_stress_exponent,
        ..ArtificialStress::default()
    });
    UpdatedSphChoices {
        density: choices.density,
        kernel: choices.kernel,
        radius: radius(choices),
        support_size: choices.support_size,
        momentum: method.momentum,
        density_evolution: method.density_evolution,
        corrected: method.corrected,
        corrected_forces: method.corrected_forces,
        penalty: method.penalty,
        shear: shear(
            settings,
            UpdatedSphChoices::published_shear_coefficient(settings.dimension()),
        ),
        artificial_stress,
        viscosity: viscosity(settings),
        velocity_smoothing: method.velocity_smoothing,
        smoothed_motion: method.smoothed_motion,
    }
}

fn elements(settings: &Settings) -> ElementChoices {
    let method = &settings.method;
    ElementChoices {
        mesh: method.mesh,
        order: method.element_order,
        spacing: settings.discretization.spacing,
        vectors: settings.discretization.vectors.clone(),
        cells: settings.discretization.cells,
        perturbation: settings.discretization.perturbation,
        seed: settings.discretization.seed,
        density: settings.discretization.density,
        formulation: ElementFormulation {
            integration: method.integration,
            hourglass_stiffness: method.hourglass_stiffness,
            hourglass_viscosity: method.hourglass_viscosity,
            hourglass_scale: method.hourglass_scale,
            mass: method.mass,
        },
    }
}

fn conforming(settings: &Settings) -> ConformingChoices {
    let choices = &settings.discretization;
    ConformingChoices {
        density: choices.density,
        kernel: choices.kernel,
        radius: radius(choices),
        approximation: choices.approximation,
        domain: settings.method.smoothing_domain,
        modification: settings.method.modification,
        ..ConformingChoices::default()
    }
}

fn peridynamics(settings: &Settings) -> PeridynamicsChoices {
    let method = &settings.method;
    let coefficient = method.control_coefficient;
    let control = match method.control {
        Control::None => ZeroEnergyControl::None,
        Control::Penalty => ZeroEnergyControl::Penalty { coefficient },
        Control::Hourglass => ZeroEnergyControl::Hourglass { coefficient },
        Control::StiffnessTensor => ZeroEnergyControl::StiffnessTensor { coefficient },
    };
    PeridynamicsChoices {
        density: settings.discretization.density,
        horizon: method.horizon,
        influence: method.influence,
        partial_volumes: method.partial_volumes,
        model: match method.bonds {
            Bonds::BondBased => BondModel::BondBased {
                calibration: method.calibration,
            },
            Bonds::Ordinary => BondModel::Ordinary,
            Bonds::Correspondence => BondModel::Correspondence { control },
            Bonds::BondAssociatedFormI => BondModel::BondAssociated {
                form: BondForm::One,
            },
            Bonds::BondAssociatedFormII => BondModel::BondAssociated {
                form: BondForm::Two,
            },
            Bonds::BondAveraged => BondModel::BondAveraged,
        },
        weighted_forces: method.weighted_forces,
    }
}

fn material_points(settings: &Settings) -> MaterialPointChoices {
    let (choices, method) = (&settings.discretization, &settings.method);
    let mass = method.grid_mass;
    MaterialPointChoices {
        spacing: choices.spacing,
        density: choices.density,
        per_side: method.points_per_side as usize,
        layout: method.layout,
        offset: [method.offset; 3],
        functions: method.grid_functions,
        gradients: method.grid_gradients,
        dilatation: method.dilatation,
        formulation: match method.unknowns {
            Unknowns::TotalLagrangian => Formulation::TotalLagrangian { mass },
            Unknowns::Updated => Formulation::Updated {
                mass,
                grid: method.grid,
            },
            Unknowns::Particles => Formulation::Particles {
                grid: method.grid,
                transfer: match method.transfer {
                    Velocities::Continuous => Transfer::Continuous,
                    Velocities::Flip => Transfer::Blended {
                        flip: method.flip_share,
                    },
                    Velocities::Pic => Transfer::Blended { flip: 0.0 },
                    Velocities::Apic => Transfer::Affine,
                    Velocities::Xpic => Transfer::Extended {
                        order: method.transfer_order,
                    },
                    Velocities::Fmpm => Transfer::FullMass {
                        order: method.transfer_order,
                    },
                },
            },
        },
    }
}
