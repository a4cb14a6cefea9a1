//! From settings to a discretization of any kind.

use crate::answers::ProblemError;
use crate::settings::{Bonds, Control, Family, Settings, Unknowns};
use onset::lattice::Crystal;
use onset::method::{Background, Discretization, Frame, Linearization, Method, MethodError};
use onset::quadrature::{CellRule, Quadrature};
use onset::scheme::conforming::{ConformingChoices, ConformingIntegration};
use onset::scheme::element::{ElementChoices, FiniteElements, Formulation as ElementFormulation};
use onset::scheme::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};
use onset::scheme::sph::{
    TotalLagrangianChoices, TotalLagrangianSph, UpdatedSph, UpdatedSphChoices,
};
use onset::scheme::stabilization::{ArtificialStress, ArtificialViscosity};
use onset::scheme::{
    BondModel, Formulation, MaterialPointChoices, MaterialPoints, Peridynamics,
    PeridynamicsChoices, Scheme, ZeroEnergyControl,
};

/// The discretization that settings describe.
///
/// # Errors
/// [`ProblemError`] when a setting is out of range, or the number of dimensions is not `D`.
pub fn scheme<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, ProblemError> {
    let found: Result<Box<dyn Scheme<D>>, MethodError> = match settings.method.method {
        Family::Kernel => kernel(&settings.discretization),
        Family::TotalLagrangianSph => total_lagrangian(settings),
        Family::UpdatedSph => updated(settings),
        Family::FiniteElements => elements(settings),
        Family::Conforming => conforming(settings),
        Family::Peridynamics => peridynamics(settings),
        Family::MaterialPoints => material_points(settings),
    };
    Ok(found?)
}

fn kernel<const D: usize>(choices: &Discretization) -> Result<Box<dyn Scheme<D>>, MethodError> {
    let crystal = choices.crystal::<D>()?;
    if crystal.sites().len() == 1 {
        return Ok(Box::new(Method::<D>::new(choices.clone())?));
    }
    let refused = |choice, hint| MethodError::Incompatible {
        choice,
        other: "several particles in a cell",
        hint,
    };
    if choices.background != Background::Imposed {
        return Err(refused("the interpolated background", "choose \"imposed\""));
    }
    if choices.frame == Frame::Eulerian && choices.linearization != Linearization::Exact {
        return Err(MethodError::NotOfForces {
            linearization: choices.linearization.name(),
        });
    }
    let quadrature = quadrature(choices, &crystal)?;
    let kernel = KernelChoices {
        density: choices.density,
        kernel: choices.kernel,
        radius: choices.support * choices.spacing,
        approximation: choices.approximation,
        frame: choices.frame,
        support_size: choices.support_size,
    };
    Ok(Box::new(KernelScheme::new(crystal, quadrature, kernel)?))
}

/// The quadrature points of a cell with several particles: at the particles, and in the centers of the Delaunay cells.
fn quadrature<const D: usize>(
    choices: &Discretization,
    crystal: &Crystal<D>,
) -> Result<CrystalQuadrature<D>, MethodError> {
    let lattice = crystal.lattice();
    let centers = || onset::lattice::delaunay_centers(lattice, crystal.sites());
    let places = match choices.quadrature {
        Quadrature::Nodal => return Ok(CrystalQuadrature::Nodal),
        Quadrature::StressPoints if choices.stress_point_weight.is_none() => {
            crystal.sites().iter().copied().chain(centers()?).collect()
        }
        Quadrature::StressPointsOnly => centers()?,
        Quadrature::Gauss | Quadrature::Points => {
            let rule = CellRule {
                stress_point_weight: None,
                gauss_points: choices.gauss_points,
                points: choices.points.clone(),
            };
            let points = choices.quadrature.points(lattice, &rule)?;
            let points = points.iter().map(|point| (point.place, point.volume));
            return Ok(CrystalQuadrature::Points(points.collect()));
        }
        Quadrature::StressPoints | Quadrature::NodalStabilized => {
            return Err(MethodError::Incompatible {
                choice: "this quadrature (nodal-stabilized, or a stress-point-weight)",
                other: "several particles in a cell",
                hint: "choose nodal, stress-points, stress-points-only, gauss or points",
            });
        }
    };
    let volumes = onset::lattice::voronoi_volumes(lattice, &places)?;
    Ok(CrystalQuadrature::Points(
        places.into_iter().zip(volumes).collect(),
    ))
}

fn viscosity(settings: &Settings) -> Option<ArtificialViscosity> {
    (settings.method.viscosity != 0.0).then(|| ArtificialViscosity {
        alpha: settings.method.viscosity,
        switch: settings.method.viscosity_switch,
        ..ArtificialViscosity::default()
    })
}

fn total_lagrangian<const D: usize>(
    settings: &Settings,
) -> Result<Box<dyn Scheme<D>>, MethodError> {
    let choices = &settings.discretization;
    let own = TotalLagrangianChoices {
        density: choices.density,
        kernel: choices.kernel,
        radius: choices.support * choices.spacing,
        corrected: settings.method.corrected,
        penalty: settings.method.penalty,
        viscosity: viscosity(settings),
        velocity_smoothing: settings.method.velocity_smoothing,
    };
    Ok(Box::new(TotalLagrangianSph::new(
        choices.crystal::<D>()?,
        own,
    )?))
}

fn updated<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, MethodError> {
    let (choices, method) = (&settings.discretization, &settings.method);
    let artificial_stress = (method.artificial_stress != 0.0).then_some(ArtificialStress {
        epsilon: method.artificial_stress,
        exponent: method.artificial_stress_exponent,
        spacing: choices.spacing,
    });
    let own = UpdatedSphChoices {
        density: choices.density,
        kernel: choices.kernel,
        radius: choices.support * choices.spacing,
        support_size: choices.support_size,
        momentum: method.momentum,
        density_evolution: method.density_evolution,
        corrected: method.corrected,
        artificial_stress,
        viscosity: viscosity(settings),
        velocity_smoothing: method.velocity_smoothing,
    };
    Ok(Box::new(UpdatedSph::new(choices.crystal::<D>()?, own)?))
}

fn elements<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, MethodError> {
    let method = &settings.method;
    let choices = ElementChoices {
        mesh: method.mesh,
        spacing: settings.discretization.spacing,
        density: settings.discretization.density,
        formulation: ElementFormulation {
            integration: method.integration,
            hourglass_stiffness: method.hourglass_stiffness,
            hourglass_viscosity: method.hourglass_viscosity,
            mass: method.mass,
        },
    };
    Ok(Box::new(FiniteElements::<D>::new(&choices)?))
}

fn conforming<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, MethodError> {
    let choices = &settings.discretization;
    let own = ConformingChoices {
        density: choices.density,
        kernel: choices.kernel,
        radius: choices.support * choices.spacing,
        approximation: choices.approximation,
        domain: settings.method.smoothing_domain,
        modification: settings.method.modification,
        ..ConformingChoices::default()
    };
    let crystal = choices.crystal::<D>()?;
    Ok(Box::new(ConformingIntegration::new(crystal, &own)?))
}

fn peridynamics<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, MethodError> {
    let method = &settings.method;
    let coefficient = method.control_coefficient;
    let control = match method.control {
        Control::None => ZeroEnergyControl::None,
        Control::Penalty => ZeroEnergyControl::Penalty { coefficient },
        Control::Hourglass => ZeroEnergyControl::Hourglass { coefficient },
    };
    let choices = PeridynamicsChoices {
        density: settings.discretization.density,
        horizon: method.horizon,
        influence: method.influence,
        partial_volumes: method.partial_volumes,
        model: match method.bonds {
            Bonds::BondBased => BondModel::BondBased {
                calibration: method.calibration,
            },
            Bonds::Correspondence => BondModel::Correspondence { control },
        },
    };
    let crystal = settings.discretization.crystal::<D>()?;
    Ok(Box::new(Peridynamics::new(crystal, choices)?))
}

fn material_points<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, MethodError> {
    let (choices, method) = (&settings.discretization, &settings.method);
    let mass = method.grid_mass;
    let own = MaterialPointChoices {
        spacing: choices.spacing,
        density: choices.density,
        per_side: method.points_per_side as usize,
        layout: method.layout,
        offset: [method.offset; 3],
        functions: method.grid_functions,
        formulation: match method.unknowns {
            Unknowns::TotalLagrangian => Formulation::TotalLagrangian { mass },
            Unknowns::Updated => Formulation::Updated {
                mass,
                grid: method.grid,
            },
            Unknowns::Particles => Formulation::Particles { grid: method.grid },
        },
    };
    Ok(Box::new(MaterialPoints::<D>::new(own)?))
}
