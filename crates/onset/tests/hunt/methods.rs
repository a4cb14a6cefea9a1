//! Random methods, materials and states.

use crate::random::Random;
use nalgebra::{Rotation3, SMatrix, SVector, Vector3};
use onset::approximation::Approximation;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{Crystal, LatticeKind};
use onset::material::{Hyperelastic, library};
use onset::method::{
    CurrentLattice, Frame, KernelMethodChoices, Linearization, Method, SupportSize,
};
use onset::quadrature::Quadrature;
use onset::scheme::conforming::{ConformingChoices, ConformingIntegration, SmoothingDomain};
use onset::scheme::element::{
    ElementChoices, ElementMass, ElementMesh, FiniteElements, Formulation as Elements,
    HourglassScale, Integration,
};
use onset::scheme::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};
use onset::scheme::sph::{
    DensityEvolution, MomentumForm, ParticleGradient, ShearForces, TotalLagrangianChoices,
    TotalLagrangianSph, UpdatedSph, UpdatedSphChoices,
};
use onset::scheme::stabilization::ArtificialStress;
use onset::scheme::{
    BondForm, BondModel, Calibration, Discretization, Formulation, GridFunctions, GridGradients,
    GridMass, Influence, MaterialPointChoices, MaterialPoints, PartialVolumes, Peridynamics,
    PeridynamicsChoices, PointLayout, Transfer, ZeroEnergyControl,
};

/// Discretization, by the kind of its search.
pub enum Drawn<const D: usize> {
    Kernel(Box<Method<D>>),
    Scheme(Box<dyn Discretization<D>>),
}

/// Method with a name that identifies all of its choices.
pub type Named<const D: usize> = (String, Drawn<D>);

impl Random {
    /// Uniform random number between zero and one.
    pub fn share(&mut self) -> f64 {
        0.5 * (self.number() + 1.0)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    pub fn one_of<T: Clone>(&mut self, all: &[T]) -> T {
        let place = (self.share() * all.len() as f64) as usize;
        all[place.min(all.len() - 1)].clone()
    }

    pub fn happens(&mut self, share: f64) -> bool {
        self.share() < share
    }
}

/// Law of the library with its default constants.
pub fn material(random: &mut Random) -> (&'static str, Box<dyn Hyperelastic>) {
    loop {
        let law = &library()[(random.share() * library().len() as f64) as usize];
        if let Ok(built) = law.build(&[]) {
            return (law.name, built);
        }
    }
}

/// State with moderate stretches along random axes, and occasionally a shear and a rotation.
pub fn state<const D: usize>(random: &mut Random) -> DeformationGradient {
    let mut matrix = SMatrix::<f64, D, D>::identity();
    let size = random.one_of(&[0.02, 0.1, 0.3, 0.45]);
    for i in 0..D {
        matrix[(i, i)] += size * random.number();
    }
    if random.happens(0.4) {
        for i in 0..D {
            for j in 0..D {
                if i != j {
                    matrix[(i, j)] += 0.5 * size * random.number();
                }
            }
        }
    }
    if D > 1 && random.happens(0.3) {
        let rotation = match D {
            2 => *Rotation3::new(Vector3::z() * (3.0 * random.number())).matrix(),
            _ => random.rotation(),
        };
        matrix = SMatrix::from_fn(|i, j| rotation[(i, j)]) * matrix;
    }
    DeformationGradient::identity().with_leading(&matrix)
}

/// Random particles: a lattice, or a cell with several particles at random positions.
fn crystal<const D: usize>(random: &mut Random) -> Option<(String, Crystal<D>)> {
    let known: &[LatticeKind] = match D {
        1 => &[LatticeKind::Chain],
        2 => &[
            LatticeKind::Square,
            LatticeKind::Hexagonal,
            LatticeKind::Honeycomb,
        ],
        _ => &[
            LatticeKind::SimpleCubic,
            LatticeKind::BodyCenteredCubic,
            LatticeKind::FaceCenteredCubic,
            LatticeKind::HexagonalClosePacked,
            LatticeKind::Diamond,
        ],
    };
    let kind = random.one_of(known);
    if random.happens(0.55) {
        let name = format!("{kind:?}");
        return Some((name, Crystal::of(kind, 1.0).ok()?));
    }
    let sites = random.one_of(&[2_usize, 2, 3, 4]);
    let spacing = (sites as f64).powf(1.0 / D as f64);
    let lattice = known[0].lattice::<D>(spacing).ok()?;
    for _ in 0..100 {
        let mut places = vec![SVector::<f64, D>::zeros()];
        while places.len() < sites {
            places.push(SVector::from_fn(|_, _| random.share()));
        }
        let crystal = Crystal::new(lattice, places.clone()).ok()?;
        if crystal.nearest_distance() > 0.7 {
            let name = format!("{:?} cell {spacing} with {places:?}", known[0]);
            return Some((name, crystal));
        }
    }
    None
}

/// Method with random choices; `None` if they are incompatible.
pub fn method<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let (name, drawn) = match (random.share() * 8.0) as usize {
        0 => kernel::<D>(random)?,
        1 => kernels::<D>(random)?,
        2 => total_lagrangian::<D>(random)?,
        3 | 4 => updated::<D>(random)?,
        5 => elements::<D>(random)?,
        6 => match random.happens(0.5) {
            true => conforming::<D>(random)?,
            false => peridynamics::<D>(random)?,
        },
        _ => material_points::<D>(random)?,
    };
    Some((name, drawn))
}

fn approximation(random: &mut Random) -> Approximation {
    random.one_of(&Approximation::ALL)
}

fn weight(random: &mut Random) -> Kernel {
    random.one_of(&[
        Kernel::QuarticSpline,
        Kernel::CubicSpline,
        Kernel::QuinticSpline,
        Kernel::ALL[6],
        Kernel::ALL[7],
    ])
}

fn kernel<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let kind = match D {
        1 => LatticeKind::Chain,
        2 => random.one_of(&[LatticeKind::Square, LatticeKind::Hexagonal]),
        _ => random.one_of(&[LatticeKind::SimpleCubic, LatticeKind::FaceCenteredCubic]),
    };
    let choices = KernelMethodChoices {
        lattice: kind,
        kernel: weight(random),
        support: random.between(1.3, 2.6),
        approximation: approximation(random),
        quadrature: random.one_of(&[
            Quadrature::Nodal,
            Quadrature::StressPoints,
            Quadrature::StressPointsOnly,
        ]),
        frame: random.one_of(&[Frame::Lagrangian, Frame::Eulerian, Frame::Eulerian]),
        current_lattice: random.one_of(&[CurrentLattice::Convected, CurrentLattice::Regular]),
        linearization: random.one_of(&[Linearization::Exact, Linearization::Paper]),
        support_size: random.one_of(&[SupportSize::Fixed, SupportSize::Scaled]),
        ..KernelMethodChoices::default()
    };
    let name = format!("{choices:?}");
    let method = Method::<D>::new(choices).ok()?;
    Some((name, Drawn::Kernel(Box::new(method))))
}

fn kernels<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let (place, crystal) = crystal::<D>(random)?;
    let quadrature = if random.happens(0.5) {
        CrystalQuadrature::Nodal
    } else {
        let count = random.one_of(&[2_usize, 3]);
        let volume = crystal.lattice().cell_volume() / count as f64;
        let point = |_| (SVector::from_fn(|_, _| random.share()), volume);
        CrystalQuadrature::Points((0..count).map(point).collect())
    };
    let choices = KernelChoices {
        kernel: weight(random),
        radius: random.between(1.6, 2.6),
        approximation: approximation(random),
        frame: random.one_of(&[Frame::Lagrangian, Frame::Eulerian]),
        support_size: random.one_of(&[SupportSize::Fixed, SupportSize::Scaled]),
        ..KernelChoices::default()
    };
    let name = format!("{place}, {quadrature:?}, {choices:?}");
    let scheme = KernelScheme::new(crystal, quadrature, choices).ok()?;
    Some((name, Drawn::Scheme(Box::new(scheme))))
}

fn total_lagrangian<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let (place, crystal) = crystal::<D>(random)?;
    let choices = TotalLagrangianChoices {
        kernel: weight(random),
        radius: random.between(1.4, 2.6),
        corrected: random.happens(0.7),
        penalty: random.one_of(&[0.0, 0.1, 0.5]),
        velocity_smoothing: random.one_of(&[0.0, 0.0, 0.5]),
        shear: random.one_of(&[
            ShearForces::Stress,
            ShearForces::Stress,
            ShearForces::Pairs { coefficient: 1.07 },
        ]),
        gradient: random.one_of(&[
            ParticleGradient::Kernel,
            ParticleGradient::Kernel,
            ParticleGradient::Bonds,
        ]),
        ..TotalLagrangianChoices::default()
    };
    let name = format!("{place}, {choices:?}");
    let scheme = TotalLagrangianSph::new(crystal, choices).ok()?;
    Some((name, Drawn::Scheme(Box::new(scheme))))
}

fn updated<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let (place, crystal) = crystal::<D>(random)?;
    let choices = UpdatedSphChoices {
        kernel: weight(random),
        radius: random.between(1.4, 2.6),
        support_size: random.one_of(&[SupportSize::Fixed, SupportSize::Scaled]),
        momentum: random.one_of(&[
            MomentumForm::Symmetric,
            MomentumForm::Mean,
            MomentumForm::Difference,
        ]),
        density_evolution: random
            .one_of(&[DensityEvolution::Summation, DensityEvolution::Continuity]),
        corrected: random.happens(0.4),
        artificial_stress: random.happens(0.2).then(ArtificialStress::default),
        velocity_smoothing: random.one_of(&[0.0, 0.0, 0.5]),
        penalty: random.one_of(&[0.0, 0.0, 2.0, 4.0]),
        shear: random.one_of(&[
            ShearForces::Stress,
            ShearForces::Stress,
            ShearForces::Pairs { coefficient: 3.5 },
        ]),
        ..UpdatedSphChoices::default()
    };
    let name = format!("{place}, {choices:?}");
    let scheme = UpdatedSph::new(crystal, choices).ok()?;
    Some((name, Drawn::Scheme(Box::new(scheme))))
}

fn elements<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let of_dimension: &[ElementMesh] = match D {
        1 => &ElementMesh::ALL[..1],
        2 => &ElementMesh::ALL[1..6],
        _ => &ElementMesh::ALL[6..],
    };
    let is_one_point = random.happens(0.4);
    let choices = ElementChoices {
        mesh: random.one_of(of_dimension),
        formulation: Elements {
            integration: if is_one_point {
                Integration::OnePoint
            } else {
                Integration::Full
            },
            hourglass_stiffness: if is_one_point {
                random.one_of(&[0.0, 0.05, 0.2])
            } else {
                0.0
            },
            hourglass_viscosity: 0.0,
            hourglass_scale: HourglassScale::Gradients,
            mass: random.one_of(&[ElementMass::Lumped, ElementMass::Consistent]),
        },
        ..ElementChoices::default()
    };
    let scheme = FiniteElements::<D>::new(&choices).ok()?;
    Some((format!("{choices:?}"), Drawn::Scheme(Box::new(scheme))))
}

fn conforming<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let (place, crystal) = crystal::<D>(random)?;
    let choices = ConformingChoices {
        radius: random.between(1.4, 2.4),
        approximation: approximation(random),
        domain: random.one_of(&[SmoothingDomain::Voronoi, SmoothingDomain::Boxes]),
        modification: random.one_of(&[0.0, 0.3]),
        ..ConformingChoices::default()
    };
    let name = format!("{place}, {choices:?}");
    let scheme = ConformingIntegration::new(crystal, &choices).ok()?;
    Some((name, Drawn::Scheme(Box::new(scheme))))
}

fn peridynamics<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let (place, crystal) = crystal::<D>(random)?;
    let coefficient = random.one_of(&[0.1, 0.5]);
    let control = random.one_of(&[
        ZeroEnergyControl::None,
        ZeroEnergyControl::Penalty { coefficient },
        ZeroEnergyControl::Hourglass { coefficient },
        ZeroEnergyControl::StiffnessTensor { coefficient },
    ]);
    let choices = PeridynamicsChoices {
        horizon: random.between(1.2, if D == 3 { 2.0 } else { 3.1 }),
        influence: random.one_of(&[
            Influence::Constant,
            Influence::Inverse,
            Influence::Conical,
            Influence::Gaussian,
        ]),
        partial_volumes: random.one_of(&[PartialVolumes::Whole, PartialVolumes::Tapered]),
        model: random.one_of(&[
            BondModel::BondBased {
                calibration: Calibration::Continuum,
            },
            BondModel::Ordinary,
            BondModel::Correspondence { control },
            BondModel::Correspondence { control },
            BondModel::BondAssociated {
                form: BondForm::One,
            },
            BondModel::BondAssociated {
                form: BondForm::Two,
            },
            BondModel::BondAveraged,
        ]),
        ..PeridynamicsChoices::default()
    };
    let name = format!("{place}, {choices:?}");
    let scheme = Peridynamics::new(crystal, choices).ok()?;
    Some((name, Drawn::Scheme(Box::new(scheme))))
}

fn material_points<const D: usize>(random: &mut Random) -> Option<Named<D>> {
    let mass = random.one_of(&[GridMass::Lumped, GridMass::Lumped, GridMass::Consistent]);
    let grid = random.one_of(&[CurrentLattice::Convected, CurrentLattice::Regular]);
    let offset = random.one_of(&[0.0, 0.0, 0.08, 0.3]);
    let choices = MaterialPointChoices {
        per_side: random.one_of(&[1, 2, 2]),
        layout: random.one_of(&[PointLayout::Uniform, PointLayout::Gauss]),
        offset: std::array::from_fn(|_| offset * random.number()),
        functions: random.one_of(&[
            GridFunctions::Linear,
            GridFunctions::Gimp,
            GridFunctions::QuadraticSpline,
            GridFunctions::CubicSpline,
        ]),
        formulation: random.one_of(&[
            Formulation::TotalLagrangian { mass },
            Formulation::Updated { mass, grid },
            Formulation::Particles {
                grid,
                transfer: Transfer::Continuous,
            },
        ]),
        gradients: random.one_of(&[GridGradients::Functions, GridGradients::Moments]),
        ..MaterialPointChoices::default()
    };
    let name = format!("{choices:?}");
    let scheme = MaterialPoints::<D>::new(choices).ok()?;
    Some((name, Drawn::Scheme(Box::new(scheme))))
}
