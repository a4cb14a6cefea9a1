//! From settings to a discretization of any kind.

use crate::settings::{Bonds, Control, Family, Settings, Unknowns};
use nalgebra::SVector;
use onset::approximation::Approximation;
use onset::kinematics::{DeformationGradient, StraightPath};
use onset::lattice::{BravaisLattice, Crystal};
use onset::material::Hyperelastic;
use onset::method::{
    Background, CurrentLattice, Discretization, Frame, Linearization, Method, MethodError,
};
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
use onset::time_step::Integrator;
use onset::verdict::{
    Assessment, PathError, PathScan, SchemeSurvey, scan_discretization, scan_scheme,
};
use std::ops::RangeInclusive;

/// A discretization, with the fast ways of kernel methods where it is one.
pub enum Discretized<const D: usize> {
    /// A kernel method with one particle in a cell.
    Kernel(Box<Method<D>>),
    /// Any other one.
    Scheme(Box<dyn Scheme<D>>),
}

impl<const D: usize> Discretized<D> {
    /// The discretization that settings describe.
    ///
    /// # Errors
    /// [`MethodError`] when a setting is out of range, or the number of dimensions is not `D`.
    pub fn new(settings: &Settings) -> Result<Self, MethodError> {
        require_moderate_units(settings)?;
        let scheme: Box<dyn Scheme<D>> = match settings.method.method {
            Family::Kernel => return kernel(&settings.discretization),
            Family::TotalLagrangianSph => total_lagrangian(settings)?,
            Family::UpdatedSph => updated(settings)?,
            Family::FiniteElements => elements(settings)?,
            Family::Conforming => conforming(settings)?,
            Family::Peridynamics => peridynamics(settings)?,
            Family::MaterialPoints => material_points(settings)?,
        };
        Ok(Self::Scheme(scheme))
    }

    /// The verdict on a state with its evidence.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    pub fn assess(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Assessment<D>, MethodError> {
        match self {
            Self::Kernel(method) => onset::verdict::assess(method, material, f),
            Self::Scheme(scheme) => SchemeSurvey::new(&**scheme, material)?.assess(f),
        }
    }

    /// All changes of stability along a path.
    ///
    /// # Errors
    /// [`PathError`] when a state cannot be evaluated for another reason than its support.
    pub fn scan(
        &self,
        material: &dyn Hyperelastic,
        path: &StraightPath,
    ) -> Result<PathScan, PathError> {
        match self {
            Self::Kernel(method) => scan_discretization(method, material, path),
            Self::Scheme(scheme) => {
                let survey =
                    SchemeSurvey::new(&**scheme, material).map_err(|source| PathError::Method {
                        parameter: 0.0,
                        source,
                    })?;
                scan_scheme(&survey, path)
            }
        }
    }

    /// The largest stable time steps of the integrators at a state, where damping makes them differ; none otherwise.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    pub fn damped_time_steps(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Vec<(Integrator, f64)>, MethodError> {
        let Self::Scheme(scheme) = self else {
            return Ok(Vec::new());
        };
        let survey = SchemeSurvey::new(&**scheme, material)?;
        if !survey.is_damped() {
            return Ok(Vec::new());
        }
        let step = |integrator| Ok((integrator, survey.critical_time_step(f, integrator)?));
        Integrator::ALL.into_iter().map(step).collect()
    }

    /// The lattice of the cells in the reference state.
    pub fn lattice(&self) -> &BravaisLattice<D> {
        match self {
            Self::Kernel(method) => method.lattice(),
            Self::Scheme(scheme) => scheme.crystal().lattice(),
        }
    }

    /// The kernel method, where it is one.
    pub fn kernel(&self) -> Option<&Method<D>> {
        match self {
            Self::Kernel(method) => Some(method),
            Self::Scheme(_) => None,
        }
    }

    /// A reference wave vector in the deformed lattice, `F^-T k`; on a regular arrangement, where particles that have not moved
    /// stand for deformed ones, `k` itself.
    pub fn spatial(&self, f: &DeformationGradient, k: &SVector<f64, D>) -> SVector<f64, D> {
        let choices = self.kernel().map(Method::discretization);
        let is_regular = choices.is_some_and(|choices| {
            choices.frame == Frame::Eulerian && choices.lattice == CurrentLattice::Regular
        });
        if is_regular {
            return *k;
        }
        let map = f.leading::<D>();
        let solved = nalgebra::DMatrix::from_fn(D, D, |i, j| map[(j, i)])
            .lu()
            .solve(&nalgebra::DVector::from_fn(D, |i, _| k[i]));
        solved.map_or(*k, |solved| SVector::from_fn(|i, _| solved[i]))
    }
}

/// The discretization that settings describe.
///
/// # Errors
/// [`MethodError`] when a setting is out of range, or the number of dimensions is not `D`.
pub fn scheme<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, MethodError> {
    Ok(match Discretized::new(settings)? {
        Discretized::Kernel(method) => method,
        Discretized::Scheme(scheme) => scheme,
    })
}

fn kernel<const D: usize>(choices: &Discretization) -> Result<Discretized<D>, MethodError> {
    let crystal = choices.crystal::<D>()?;
    if crystal.sites().len() == 1 {
        let method = Method::new(choices.clone())?;
        return Ok(Discretized::Kernel(Box::new(method)));
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
    let scheme = KernelScheme::new(crystal, quadrature, kernel)?;
    Ok(Discretized::Scheme(Box::new(scheme)))
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
                ..choices.cell_rule::<D>()?
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

/// Within these bounds powers of a number, such as the cube of the density in the forces of SPH, are numbers too, whatever the moduli.
const MODERATE: RangeInclusive<f64> = 1e-30..=1e30;

/// Refuses lengths and, where forces are divided by powers of it, densities that only another unit makes moderate.
fn require_moderate_units(settings: &Settings) -> Result<(), MethodError> {
    let spacing = (
        "spacing",
        settings.discretization.spacing,
        "a number from 1e-30 to 1e30: choose another unit of length",
    );
    let density = (
        "density",
        settings.discretization.density,
        "a number from 1e-30 to 1e30: choose another unit of mass",
    );
    let is_divided = settings.method.method == Family::UpdatedSph;
    for (name, value, expected) in std::iter::once(spacing).chain(is_divided.then_some(density)) {
        // What is not positive is refused by the method.
        if value > 0.0 && !MODERATE.contains(&value) {
            return Err(MethodError::Setting {
                name,
                value,
                expected,
            });
        }
    }
    Ok(())
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
    let crystal = choices.crystal::<D>()?;
    let artificial_stress = (method.artificial_stress != 0.0).then_some(ArtificialStress {
        epsilon: method.artificial_stress,
        exponent: method.artificial_stress_exponent,
        spacing: crystal.spacing(),
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
        smoothed_motion: method.smoothed_motion,
    };
    Ok(Box::new(UpdatedSph::new(crystal, own)?))
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
            hourglass_scale: method.hourglass_scale,
            mass: method.mass,
        },
    };
    Ok(Box::new(FiniteElements::<D>::new(&choices)?))
}

fn conforming<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, MethodError> {
    let choices = &settings.discretization;
    if matches!(
        choices.approximation,
        Approximation::RandlesLibersky | Approximation::KrongauzBelytschko
    ) {
        return Err(MethodError::Incompatible {
            choice: "an approximation that corrects gradients alone",
            other: "conforming integration, which takes its gradients from functions",
            hint: "choose \"shepard\", whose functions these approximations have, or \"mls\"",
        });
    }
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
