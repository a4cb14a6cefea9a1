//! The material point method: its equivalence to elements, the waves that vanish at its points, and its instabilities.

use crate::battery::{
    assert_long_waves_are_those_of_the_material, assert_scheme, assert_translations_are_free,
};
use nalgebra::{Complex, DMatrix, SMatrix, SVector};
use onset::bloch::{WaveSystem, ZoneSearch, growth_rate};
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{CurrentLattice, MethodError};
use onset::scheme::{
    Discretization, Formulation, GridFunctions, GridMass, MaterialPointChoices, MaterialPoints,
    PointDilatation, PointLayout, Transfer, element,
};
use std::f64::consts::PI;

const FUNCTIONS: [GridFunctions; 5] = [
    GridFunctions::Linear,
    GridFunctions::Gimp,
    GridFunctions::Cpdi,
    GridFunctions::QuadraticSpline,
    GridFunctions::CubicSpline,
];
const LUMPED: GridMass = GridMass::Lumped;
const FIXED: Formulation = Formulation::TotalLagrangian { mass: LUMPED };
const CONVECTED: CurrentLattice = CurrentLattice::Convected;
const UPDATED: Formulation = Formulation::Updated {
    mass: LUMPED,
    grid: CONVECTED,
};
const PARTICLES: Formulation = Formulation::Particles {
    grid: CONVECTED,
    transfer: Transfer::Continuous,
};

fn choices(formulation: Formulation, per_side: usize) -> MaterialPointChoices {
    MaterialPointChoices {
        formulation,
        per_side,
        ..MaterialPointChoices::default()
    }
}

fn points<const D: usize>(choices: MaterialPointChoices) -> MaterialPoints<D> {
    MaterialPoints::new(choices).expect("a method")
}

fn state<const D: usize>() -> DeformationGradient {
    match D {
        1 => DeformationGradient::from_stretches([1.15, 1.0, 1.0]),
        2 => DeformationGradient::plane_strain([[1.1, 0.15], [-0.05, 0.92]], 1.03),
        _ => DeformationGradient::new([[1.1, 0.1, 0.0], [-0.05, 0.95, 0.1], [0.02, 0.0, 1.04]]),
    }
    .expect("a state")
}

fn waves<const D: usize>(points: &MaterialPoints<D>, f: &DeformationGradient) -> WaveSystem<D> {
    points
        .waves(&ModifiedMooneyRivlin::default(), f)
        .expect("an evaluable state")
}

fn rest() -> DeformationGradient {
    DeformationGradient::identity()
}

/// Lame constants of the material in the reference state.
fn lame() -> (f64, f64) {
    let response = ModifiedMooneyRivlin::default()
        .response(&rest())
        .expect("a response");
    (
        response.tangent[(0, 0, 1, 1)],
        response.tangent[(0, 1, 0, 1)],
    )
}

#[test]
fn every_formulation_passes_the_scheme_checks_with_every_function_in_every_dimension() {
    fn checked<const D: usize>(per_side: &[usize], functions: &[GridFunctions]) {
        for per_side in per_side {
            for functions in functions.iter().copied() {
                let regular = CurrentLattice::Regular;
                for formulation in [
                    FIXED,
                    UPDATED,
                    Formulation::Updated {
                        mass: LUMPED,
                        grid: regular,
                    },
                    PARTICLES,
                    Formulation::Particles {
                        grid: regular,
                        transfer: Transfer::Continuous,
                    },
                ] {
                    let choices = MaterialPointChoices {
                        spacing: 0.8,
                        density: 1.7,
                        offset: [0.11, 0.07, -0.13],
                        functions,
                        ..choices(formulation, *per_side)
                    };
                    let material = ModifiedMooneyRivlin::default();
                    assert_scheme(&points::<D>(choices), &material, &state::<D>());
                }
            }
        }
    }
    checked::<1>(&[1, 2, 3], &FUNCTIONS);
    checked::<2>(&[1], &FUNCTIONS[1..]);
    checked::<2>(&[2], &FUNCTIONS[..1]);
    checked::<3>(&[1], &FUNCTIONS[..1]);
}

/// Forces on the nodes of a plane by the equations of Sadeghirad, Brannon and Burghardt (2011), with `r_1` and `r_2` of parallelogram-shaped particles,
/// compared with the stiffness of waves.
#[test]
fn convected_particle_domains_have_the_published_weights() {
    let f = state::<2>();
    let (spacing, density, offset) = (0.8, 1.7, [0.11, 0.07]);
    let method = points::<2>(MaterialPointChoices {
        spacing,
        density,
        offset: [offset[0], offset[1], 0.0],
        functions: GridFunctions::Cpdi,
        ..choices(UPDATED, 2)
    });
    let material = ModifiedMooneyRivlin::default();
    let hat = |x: f64| (1.0 - x.abs()).max(0.0);
    let base = SMatrix::<f64, 2, 2>::from_fn(|i, j| f.components()[i][j]);
    let to_grid = base.try_inverse().expect("regular") / spacing;
    type Vector = SVector<f64, 2>;
    let function = |x: &Vector, node: [i32; 2]| {
        let at = to_grid * x;
        hat(at[0] - f64::from(node[0])) * hat(at[1] - f64::from(node[1]))
    };
    // Weights of the function and of its gradient for the particle at `x` with the half-edges `r1` and `r2`.
    let weights = |x: &Vector, [r1, r2]: [Vector; 2], node: [i32; 2]| {
        let corners = [x - r1 - r2, x + r1 - r2, x + r1 + r2, x - r1 + r2];
        let n = corners.map(|corner| function(&corner, node));
        let area = 4.0 * (r1[0] * r2[1] - r1[1] * r2[0]).abs();
        let gradient = (Vector::new(r1[1] - r2[1], r2[0] - r1[0]) * (n[0] - n[2])
            + Vector::new(r1[1] + r2[1], -r1[0] - r2[0]) * (n[1] - n[3]))
            / area;
        (n.iter().sum::<f64>() / 4.0, gradient)
    };
    let place = |i: i32, j: i32, cell: [i32; 2]| {
        let along = |n: i32, axis: usize| {
            (0.25 + 0.5 * f64::from(n) + offset[axis]).rem_euclid(1.0) + f64::from(cell[axis])
        };
        base * Vector::new(along(i, 0), along(j, 1)) * spacing
    };
    let edges = [0, 1].map(|k| base.column(k) * (0.25 * spacing));
    let nodes = |cell: [i32; 2]| {
        (-1..=2).flat_map(move |i| (-1..=2).map(move |j| [cell[0] + i, cell[1] + j]))
    };
    // Force on the node at the origin for given displacements of the nodes.
    let force = |displacement: &dyn Fn([i32; 2]) -> Vector| {
        let mut force = Vector::zeros();
        for cell in (-3..=2).flat_map(|i| (-3..=2).map(move |j| [i, j])) {
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let x = place(i, j, cell);
                let (mut moved, mut l) = (x, SMatrix::<f64, 2, 2>::zeros());
                for node in nodes(cell) {
                    let (value, gradient) = weights(&x, edges, node);
                    moved += displacement(node) * value;
                    l += displacement(node) * gradient.transpose();
                }
                let turned = SMatrix::identity() + l;
                let own = turned * base;
                let mut components = *f.components();
                for (n, row) in components.iter_mut().enumerate().take(2) {
                    (row[0], row[1]) = (own[(n, 0)], own[(n, 1)]);
                }
                let own = DeformationGradient::new(components).expect("a state");
                let cauchy = material.response(&own).expect("a stress").cauchy();
                let (_, gradient) = weights(&moved, edges.map(|edge| turned * edge), [0, 0]);
                let volume = 0.25 * spacing * spacing * own.jacobian();
                force -= cauchy.fixed_view::<2, 2>(0, 0) * gradient * volume;
            }
        }
        force
    };
    let k = SVector::from([1.3, -0.6]);
    let found = waves(&method, &f).stiffness().at(&k);
    let step = 1e-6;
    for column in 0..2 {
        let axis = Vector::from_fn(|i, _| f64::from(u8::from(i == column)));
        // The real and the imaginary part of the wave, by central differences.
        let part = |shape: fn(f64) -> f64| {
            let at = |side: f64| {
                let displacement = |node: [i32; 2]| {
                    let phase = spacing * (k[0] * f64::from(node[0]) + k[1] * f64::from(node[1]));
                    axis * (side * step * shape(phase))
                };
                force(&displacement)
            };
            (at(1.0) - at(-1.0)) / (-2.0 * step)
        };
        let (real, imaginary) = (part(f64::cos), part(f64::sin));
        for row in 0..2 {
            let expected = Complex::new(real[row], imaginary[row]);
            let difference = (found[(row, column)] - expected).norm();
            assert!(
                difference < 1e-6 * found.camax(),
                "{} {expected}",
                found[(row, column)]
            );
        }
    }
}

/// Forces of the mean dilatation of a cell, for points that share nodes only in part, compared with the motion of a patch; and the stiffness of elements with
/// a mean dilatation.
#[test]
fn points_with_the_mean_dilatation_of_their_cell_have_the_stiffness_of_elements() {
    for (functions, formulation, per_side) in [
        (GridFunctions::Linear, FIXED, 2),
        (GridFunctions::Linear, UPDATED, 2),
        (GridFunctions::Gimp, UPDATED, 3),
        (GridFunctions::QuadraticSpline, PARTICLES, 2),
    ] {
        let choices = MaterialPointChoices {
            spacing: 0.8,
            density: 1.7,
            offset: [0.11, 0.07, -0.13],
            functions,
            dilatation: PointDilatation::Cell,
            ..choices(formulation, per_side)
        };
        let material = ModifiedMooneyRivlin::default();
        assert_scheme(&points::<2>(choices), &material, &state::<2>());
    }
    let points = points::<2>(MaterialPointChoices {
        layout: PointLayout::Gauss,
        dilatation: PointDilatation::Cell,
        ..choices(FIXED, 2)
    });
    let elements = element::FiniteElements::<2>::new(&element::ElementChoices {
        formulation: element::Formulation {
            integration: element::Integration::MeanDilatation,
            ..element::Formulation::default()
        },
        ..element::ElementChoices::default()
    });
    let material = ModifiedMooneyRivlin::default();
    let elements = elements
        .expect("elements")
        .waves(&material, &rest())
        .expect("waves");
    let found = waves(&points, &rest());
    for k in [[0.4, 0.1], [2.0, -1.3], [PI, PI]] {
        let k = SVector::from(k);
        let [own, expected] = [&found, &elements].map(|system| system.stiffness().at(&k));
        assert!((own - &expected).camax() < 1e-11 * expected.camax());
    }
}

#[test]
fn the_stiffness_at_a_knot_is_the_mean_of_both_sides() {
    for (functions, per_side) in [
        (GridFunctions::Gimp, 2),
        (GridFunctions::QuadraticSpline, 1),
    ] {
        let at = |shift: f64| {
            let choices = MaterialPointChoices {
                functions,
                offset: [shift, 0.03, 0.0],
                ..choices(UPDATED, per_side)
            };
            let points = points::<2>(choices);
            assert_translations_are_free(&points, &ModifiedMooneyRivlin::default(), &state::<2>());
            let system = waves(&points, &state::<2>());
            system.stiffness().at(&SVector::from([2.0, 0.7]))
        };
        let (left, knot, right) = (at(-1e-7), at(0.0), at(1e-7));
        let half = Complex::new(0.5, 0.0);
        let scale = knot.camax();
        assert!(((&left + &right) * half - &knot).camax() < 1e-6 * scale);
        assert!((left - right).camax() > 1e-3 * scale);
    }
}

#[test]
fn a_bar_with_one_point_per_cell_equals_bar_elements_for_any_point_position() {
    let (lambda, mu) = lame();
    let (h, density) = (0.5, 3.0);
    let consistent = Formulation::TotalLagrangian {
        mass: GridMass::Consistent,
    };
    for offset in [0.0, 0.2, -0.37] {
        let of = |formulation| {
            waves(
                &points::<1>(MaterialPointChoices {
                    spacing: h,
                    density,
                    offset: [offset; 3],
                    ..choices(formulation, 1)
                }),
                &rest(),
            )
        };
        for k in [0.3, 1.0, 2.0, 2.9] {
            let at = SVector::from_element(k / h);
            let scale = (lambda + 2.0 * mu) / (density * h * h);
            let lumped = 4.0 * (0.5 * k).sin().powi(2);
            let found = of(FIXED).omega_squared(&at)[0].re / scale;
            assert!((found - lumped).abs() < 1e-12 * lumped);
            // Mass that a point contributes to its two nodes: 1 - 2 a (1 - a) (1 - cos k), with its position a.
            let a = 0.5 + offset;
            let mass = 1.0 - 2.0 * a * (1.0 - a) * (1.0 - k.cos());
            let found = of(consistent).omega_squared(&at)[0].re / scale;
            assert!((found - lumped / mass).abs() < 1e-10 * lumped / mass);
        }
    }
}

#[test]
fn one_central_point_gives_one_point_elements_with_their_zero_energy_modes() {
    let (lambda, mu) = lame();
    let system = waves(&points::<2>(choices(FIXED, 1)), &rest());
    let corner = system.omega_squared(&SVector::repeat(PI));
    assert!(corner.iter().all(|z| z.norm() < 1e-12));
    // The largest frequency is at (pi, 0): 4 (lambda + 2 mu) / (rho h^2).
    let side = system.omega_squared(&SVector::from([PI, 0.0]));
    assert!((side[0].re - 4.0 * mu).abs() < 1e-10);
    assert!((side[1].re - 4.0 * (lambda + 2.0 * mu)).abs() < 1e-10);
    // Away from the center the zero-energy modes strain the point.
    let shifted = MaterialPointChoices {
        offset: [0.2, 0.0, 0.0],
        ..choices(FIXED, 1)
    };
    let corner = waves(&points::<2>(shifted), &rest()).omega_squared(&SVector::repeat(PI));
    assert!(corner[0].re > 0.1 * mu, "{}", corner[0]);
}

/// Tensor products of the symbols of linear elements, integrated exactly.
fn bilinear(k: [f64; 2], lambda: f64, mu: f64) -> SMatrix<f64, 2, 2> {
    let stiff = k.map(|k| 2.0 * (1.0 - k.cos()));
    let mass = k.map(|k| (2.0 + k.cos()) / 3.0);
    let (longitudinal, transverse) = (stiff[0] * mass[1], mass[0] * stiff[1]);
    let coupling = (lambda + mu) * k[0].sin() * k[1].sin();
    SMatrix::<f64, 2, 2>::new(
        (lambda + 2.0 * mu) * longitudinal + mu * transverse,
        coupling,
        coupling,
        (lambda + 2.0 * mu) * transverse + mu * longitudinal,
    )
}

#[test]
fn two_gauss_points_per_side_give_fully_integrated_elements() {
    let (lambda, mu) = lame();
    let gauss = MaterialPointChoices {
        layout: PointLayout::Gauss,
        ..choices(FIXED, 2)
    };
    let system = waves(&points::<2>(gauss), &rest());
    for k in [[0.4, 1.3], [PI, PI], [PI, 0.0], [2.0, -0.7]] {
        let found = system.stiffness().at(&SVector::from(k));
        let expected = bilinear(k, lambda, mu);
        for i in 0..2 {
            for j in 0..2 {
                let difference = found[(i, j)] - expected[(i, j)];
                assert!(difference.norm() < 1e-11 * lambda, "{k:?} {difference}");
            }
        }
    }
}

#[test]
fn long_waves_agree_with_the_material_if_the_functions_have_continuous_slopes() {
    fn checked<const D: usize>(per_side: usize) {
        let material = ModifiedMooneyRivlin::default();
        for functions in FUNCTIONS {
            let of = |formulation| {
                points::<D>(MaterialPointChoices {
                    functions,
                    ..choices(formulation, per_side)
                })
            };
            let f = state::<D>();
            assert_long_waves_are_those_of_the_material(&of(FIXED), &material, &f, 1e-9);
            if functions != GridFunctions::Linear {
                for formulation in [UPDATED, PARTICLES] {
                    assert_long_waves_are_those_of_the_material(
                        &of(formulation),
                        &material,
                        &f,
                        1e-9,
                    );
                }
            }
        }
    }
    checked::<1>(1);
    checked::<1>(3);
    checked::<2>(2);
    checked::<3>(1);
}

#[test]
fn linear_functions_of_an_updated_grid_stiffen_long_waves_by_the_stress() {
    // The slopes of the functions jump at the faces, where no point lies. The motion of the functions, which should cancel the stress, has an effect only when
    // points cross a face. In one dimension omega^2 = (A + P/F) k^2 / rho.
    for stretch in [0.8, 0.95, 1.1, 1.5] {
        let f = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
        let response = ModifiedMooneyRivlin::default()
            .response(&f)
            .expect("a response");
        let expected = response.tangent[(0, 0, 0, 0)] + response.first_piola[(0, 0)] / stretch;
        for per_side in [1, 2, 3] {
            let limit = waves(&points::<1>(choices(UPDATED, per_side)), &f).long_wave_stiffness();
            let found = limit.acoustic_tensor(&SVector::from_element(1.0))[(0, 0)];
            assert!(
                (found / expected - 1.0).abs() < 1e-10,
                "{stretch}: {found} {expected}"
            );
        }
    }
}

#[test]
fn the_dimension_of_the_null_space_is_the_excess_of_particles_over_nodes() {
    fn checked<const D: usize>(per_side: usize) {
        for functions in FUNCTIONS {
            let choices = MaterialPointChoices {
                functions,
                ..choices(PARTICLES, per_side)
            };
            let points = points::<D>(choices);
            let system = waves(&points, &state::<D>());
            let k = SVector::from_fn(|i, _| 0.7 + 0.4 * i as f64);
            let spectrum = system.omega_squared(&k);
            let scale = spectrum.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let silent = spectrum.iter().filter(|z| z.norm() < 1e-7 * scale).count();
            assert_eq!(
                silent,
                D * (per_side.pow(D as u32) - 1),
                "{functions:?} {per_side}"
            );
        }
    }
    checked::<1>(2);
    checked::<1>(4);
    checked::<2>(2);
    checked::<3>(2);
}

#[test]
fn velocities_outside_the_null_space_obey_the_grid_equations_with_the_ratio_of_consistent_to_lumped_mass()
 {
    // u_i = sum m_q N_iq U_q / m_i obeys m u'' = -(M/m) K u with the consistent mass matrix M.
    let of = |formulation| {
        let choices = MaterialPointChoices {
            density: 2.5,
            functions: GridFunctions::QuadraticSpline,
            offset: [0.1, 0.05, 0.0],
            ..choices(formulation, 2)
        };
        waves(&points::<2>(choices), &state::<2>())
    };
    let consistent = Formulation::Updated {
        mass: GridMass::Consistent,
        grid: CONVECTED,
    };
    let (particles, grid) = (of(PARTICLES), of(consistent));
    for k in [[0.3, 0.8], [PI, 1.0], [2.0, -2.5]].map(SVector::from) {
        let matrix: DMatrix<Complex<f64>> = grid.mass_at(&k) * grid.stiffness().at(&k);
        let matrix = matrix / Complex::new(grid.cell_mass().powi(2), 0.0);
        let (trace, determinant) = (matrix.trace(), matrix.determinant());
        let found = particles.omega_squared(&k);
        for z in &found[found.len() - 2..] {
            let characteristic = z * z - trace * z + determinant;
            assert!(
                characteristic.norm() < 1e-9 * trace.norm_sqr(),
                "{z} {found:?}"
            );
        }
    }
}

#[test]
fn quadratic_splines_with_two_points_are_unstable_in_tension_for_a_stable_bar() {
    // At k = pi, with points at quarters: |B| = 1, interpolant 3/8, its curvature -4, so that the scaled stiffness is
    // (C + S - 3/2 S)/4 with C = A F^2, S = P F. Without the motion of the functions there would be no instability.
    let two = points::<1>(MaterialPointChoices {
        functions: GridFunctions::QuadraticSpline,
        ..choices(UPDATED, 2)
    });
    // The interpolant vanishes at a single point in the middle: C + S, as with linear functions at any position.
    let one = points::<1>(MaterialPointChoices {
        functions: GridFunctions::QuadraticSpline,
        ..choices(UPDATED, 1)
    });
    let linear = points::<1>(choices(UPDATED, 2));
    let corner = SVector::from_element(PI);
    let mut unstable = Vec::new();
    for stretch in [0.6, 0.9, 1.2, 1.6, 1.9773, 1.9774, 2.2, 2.6] {
        let f = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
        let response = ModifiedMooneyRivlin::default()
            .response(&f)
            .expect("a response");
        let tangent = response.tangent[(0, 0, 0, 0)];
        let ratio = response.first_piola[(0, 0)] / (stretch * tangent);
        let scaled = |points: &MaterialPoints<1>| {
            waves(points, &f).omega_squared(&corner)[0].re / (4.0 * tangent)
        };
        assert!((scaled(&two) - 0.25 * (1.0 - 0.5 * ratio)).abs() < 1e-12 * (1.0 + ratio.abs()));
        assert!((scaled(&one) - (1.0 + ratio)).abs() < 1e-12 * (1.0 + ratio.abs()));
        assert!((scaled(&linear) - (1.0 + ratio)).abs() < 1e-12 * (1.0 + ratio.abs()));
        assert!(tangent > 0.0, "the bar is unstable at {stretch}");
        if scaled(&two) < 0.0 {
            unstable.push(stretch);
        }
    }
    assert_eq!(unstable, [1.9774, 2.2, 2.6]);
}

/// Independent simulation of a bar of particles on a periodic grid in one dimension: quadratic splines, velocities updated by the accelerations of
/// the grid.
struct Bar {
    cells: i32,
    /// Current distance of the nodes.
    spacing: f64,
    /// Position in units of the spacing, velocity and stretch of each particle.
    particles: Vec<[f64; 3]>,
    volume: f64,
}

impl Bar {
    fn spline(x: f64) -> (f64, f64) {
        match x.abs() {
            r if r < 0.5 => (0.75 - r * r, -2.0 * x),
            r if r < 1.5 => (0.5 * (1.5 - r).powi(2), (r - 1.5) * x.signum()),
            _ => (0.0, 0.0),
        }
    }

    fn seen(&self, place: f64) -> impl Iterator<Item = (usize, f64, f64)> + use<> {
        let (cells, spacing, middle) = (self.cells, self.spacing, place.round() as i32);
        (middle - 1..=middle + 1).map(move |node| {
            let (value, slope) = Self::spline(place - f64::from(node));
            (node.rem_euclid(cells) as usize, value, slope / spacing)
        })
    }

    fn step(&mut self, time: f64, law: &impl Fn(f64) -> f64) {
        let nodes = self.cells as usize;
        let (mut mass, mut momentum, mut force) =
            (vec![0.0; nodes], vec![0.0; nodes], vec![0.0; nodes]);
        for [place, velocity, stretch] in &self.particles {
            for (node, value, slope) in self.seen(*place) {
                mass[node] += self.volume * value;
                momentum[node] += self.volume * value * velocity;
                force[node] -= self.volume * law(*stretch) * stretch * slope;
            }
        }
        for n in 0..self.particles.len() {
            let [place, mut velocity, stretch] = self.particles[n];
            let (mut carried, mut gradient) = (0.0, 0.0);
            for (node, value, slope) in self.seen(place) {
                let moved = (momentum[node] + time * force[node]) / mass[node];
                velocity += time * value * force[node] / mass[node];
                carried += value * moved;
                gradient += slope * moved;
            }
            self.particles[n] = [
                place + time * carried / self.spacing,
                velocity,
                stretch * (1.0 + time * gradient),
            ];
        }
    }

    /// Component of the velocities that alternates from node to node.
    fn alternating(&self) -> f64 {
        let heard = |[place, velocity, _]: &[f64; 3]| {
            let sum: f64 = (-1..=1)
                .map(|offset| {
                    let node = place.round() + f64::from(offset);
                    (PI * node).cos() * Self::spline(place - node).0
                })
                .sum();
            sum * velocity
        };
        self.particles.iter().map(heard).sum()
    }
}

#[test]
fn modes_of_a_simulated_bar_grow_or_oscillate_at_the_predicted_rates() {
    let material = ModifiedMooneyRivlin::default();
    let at =
        |stretch: f64| DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
    let law = |stretch: f64| {
        let response = material.plane_response(&at(stretch));
        response.expect("a response").first_piola[0]
    };
    let method = points::<1>(MaterialPointChoices {
        functions: GridFunctions::QuadraticSpline,
        ..choices(PARTICLES, 2)
    });
    for (stretch, grows) in [(2.3, true), (1.3, false)] {
        let spectrum = waves(&method, &at(stretch)).omega_squared(&SVector::from_element(PI));
        // One of the two modes vanishes on the grid.
        let heard = if grows {
            spectrum[0].re
        } else {
            spectrum[1].re
        };
        assert_eq!(heard < 0.0, grows);
        let rate = heard.abs().sqrt();
        let start = 1e-7;
        let mut bar = Bar {
            cells: 2,
            spacing: stretch,
            particles: (0..4)
                .map(|n| {
                    let place = 0.25 + 0.5 * f64::from(n);
                    let sign = (PI * place).cos().signum();
                    [place, start * sign, stretch]
                })
                .collect(),
            volume: 0.5,
        };
        let before = bar.alternating();
        // The velocities that move the particles are half a step of unsmoothed acceleration ahead: an error of first order.
        let steps = 8000;
        let time = 4.0 / rate / f64::from(steps);
        (0..steps).for_each(|_| bar.step(time, &law));
        // The initial state has a velocity and no displacement.
        let expected = if grows { 4.0_f64.cosh() } else { 4.0_f64.cos() };
        let found = bar.alternating() / before;
        assert!(
            (found - expected).abs() < 0.01 * expected.abs(),
            "{found} {expected}"
        );
    }
}

#[test]
fn rotating_the_state_rotates_the_stiffness_and_preserves_frequencies() {
    let turn = SMatrix::<f64, 2, 2>::new(0.8, -0.6, 0.6, 0.8);
    let f = state::<2>();
    let turned = f.with_leading(&(turn * f.leading::<2>()));
    for formulation in [FIXED, UPDATED, PARTICLES] {
        for functions in FUNCTIONS {
            let method = points::<2>(MaterialPointChoices {
                functions,
                offset: [0.1, 0.2, 0.0],
                ..choices(formulation, 2)
            });
            let k = SVector::from([1.3, -0.4]);
            let of = |f: &DeformationGradient| {
                let system = waves(&method, f);
                (system.omega_squared(&k), system.stiffness().magnitude())
            };
            let ((before, scale), (after, _)) = (of(&f), of(&turned));
            for (a, b) in before.iter().zip(&after) {
                assert!(
                    (a - b).norm() < 1e-7 * scale,
                    "{formulation:?} {functions:?} {a} {b}"
                );
            }
        }
    }
}

#[test]
fn the_search_reports_no_growth_for_velocities_in_the_null_space() {
    for functions in FUNCTIONS {
        let choices = MaterialPointChoices {
            functions,
            ..choices(PARTICLES, 2)
        };
        let (lambda, mu) = lame();
        let system = waves(&points::<2>(choices), &rest());
        let search = ZoneSearch::of_lattice(*system.crystal().lattice(), lambda + 2.0 * mu);
        let summary = search.summary_of(&system);
        assert!(summary.is_stable(), "{functions:?} {:?}", summary.softest);
        assert!(summary.softest.scaled.abs() < summary.tolerance);
        assert!((summary.long_wave.scaled - mu / (lambda + 2.0 * mu)).abs() < 1e-9);
        assert!(summary.maximum_omega > 0.0 && summary.maximum_omega < 2.0 * (lambda + 2.0 * mu));
    }
}

#[test]
fn grid_velocities_have_all_frequencies_of_the_particles_except_the_zero_frequencies() {
    fn checked<const D: usize>() {
        for functions in FUNCTIONS {
            let choices = MaterialPointChoices {
                density: 1.7,
                functions,
                offset: [0.11, 0.07, -0.13],
                ..choices(PARTICLES, 2)
            };
            let system = waves(&points::<D>(choices), &state::<D>());
            let reduced = system.reduced().expect("fewer nodes than points");
            let k = SVector::from_fn(|i, _| 2.1 - 0.9 * i as f64);
            let mut all = system.omega_squared(&k);
            all.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
            for value in reduced.omega_squared(&k) {
                let nearest = all[..D].iter().map(|own| (own - value).norm());
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-9 * all[0].norm(), "{functions:?}: {value}");
            }
        }
    }
    checked::<1>();
    checked::<2>();
    checked::<3>();
}

/// Flutter between the points of the coarsest admissible grid for cells with eight particles in 3D.
#[test]
fn flutter_of_material_points_in_3d_is_found() {
    let choices = MaterialPointChoices {
        functions: GridFunctions::Gimp,
        ..choices(PARTICLES, 2)
    };
    let f = DeformationGradient::new([
        [0.7512691303334724, 0.14999996763611798, 0.13537455804471887],
        [
            -0.007162286727300193,
            1.1510744309838516,
            0.023768523360589267,
        ],
        [
            -0.14983155808838405,
            0.12399591979825965,
            1.2461661419853323,
        ],
    ])
    .expect("a state");
    let system = points::<3>(choices)
        .waves(&BlatzKo::default(), &f)
        .expect("an evaluable state");
    let k = SVector::from([0.8329708521518078, 1.7249587662960577, 3.582313222993391]);
    let growth = |values: &[Complex<f64>]| {
        let rates = values.iter().map(|value| growth_rate(*value));
        rates.fold(0.0, f64::max)
    };
    let dense = growth(&system.omega_squared(&k));
    assert!(dense > 0.028, "{dense}");
    let search = ZoneSearch::of_lattice(*system.crystal().lattice(), 96.0);
    let summary = search.summary_of(&system);
    assert!(summary.flutters && summary.growth_rate() > dense * (1.0 - 1e-9));
    // The reported mode is a mode of the particles.
    let mode = summary.fastest_growing;
    let nearest = system.modes(&mode.wave_vector).into_iter();
    let nearest = nearest.map(|(value, _)| (value - mode.omega_squared).norm());
    assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-9 * summary.maximum_omega.powi(2));
}

#[test]
fn invalid_settings_are_rejected_with_the_expected_values() {
    let refused =
        |choices: MaterialPointChoices| MaterialPoints::<2>::new(choices).expect_err("no method");
    let on_face = MaterialPointChoices {
        offset: [0.0, 0.5, 0.0],
        ..choices(UPDATED, 1)
    };
    let error = refused(on_face.clone());
    assert!(
        matches!(error, MethodError::Setting { name: "offset", .. }),
        "{error}"
    );
    let smooth = MaterialPointChoices {
        functions: GridFunctions::CubicSpline,
        ..on_face
    };
    assert_eq!(points::<2>(smooth).neighbors(), 12.0);
    for (layout, per_side) in [
        (PointLayout::Uniform, 0),
        (PointLayout::Uniform, 9),
        (PointLayout::Gauss, 4),
    ] {
        let error = refused(MaterialPointChoices {
            layout,
            ..choices(FIXED, per_side)
        });
        assert!(
            matches!(
                error,
                MethodError::Setting {
                    name: "points-per-side",
                    ..
                }
            ),
            "{error}"
        );
    }
    let error = refused(MaterialPointChoices {
        spacing: -1.0,
        ..choices(FIXED, 1)
    });
    assert!(
        matches!(
            error,
            MethodError::Setting {
                name: "spacing",
                ..
            }
        ),
        "{error}"
    );
    let error = refused(MaterialPointChoices {
        offset: [f64::NAN; 3],
        ..choices(FIXED, 1)
    });
    assert!(
        matches!(error, MethodError::Setting { name: "offset", .. }),
        "{error}"
    );
}
