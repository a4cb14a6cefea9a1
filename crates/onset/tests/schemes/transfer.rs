//! Velocity transfers of the material point method: steps of linear waves, compared with an independent code that performs these steps.

use crate::battery::assert_scheme;
use nalgebra::{Complex, SMatrix, SVector};
use onset::analysis::analysis;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{CurrentLattice, KernelMethodChoices, MethodError};
use onset::motion::{PatchMotion, Stepper};
use onset::scheme::{
    Discretization, Formulation, GridFunctions, GridGradients, GridMass, MaterialPointChoices,
    MaterialPoints, MethodChoices, PointDilatation, PointLayout, Transfer,
};
use onset::time_step::{Integrator, TransferredWaves};
use onset::verdict::Survey;
use std::f64::consts::TAU;
use std::sync::Arc;

const FLIP: Transfer = Transfer::Blended { flip: 1.0 };
const PIC: Transfer = Transfer::Blended { flip: 0.0 };
const MOSTLY_FLIP: Transfer = Transfer::Blended { flip: 0.95 };
const BOTH: [GridGradients; 2] = [GridGradients::Functions, GridGradients::Moments];
const ALL: [Transfer; 7] = [
    FLIP,
    MOSTLY_FLIP,
    PIC,
    Transfer::Affine,
    Transfer::Extended { order: 2 },
    Transfer::FullMass { order: 2 },
    Transfer::FullMass { order: 5 },
];

fn choices(transfer: Transfer, functions: GridFunctions) -> MaterialPointChoices {
    MaterialPointChoices {
        spacing: 0.8,
        density: 1.7,
        per_side: 2,
        layout: PointLayout::Uniform,
        offset: [0.11, 0.07, -0.13],
        functions,
        gradients: GridGradients::Functions,
        dilatation: PointDilatation::Point,
        formulation: Formulation::Particles {
            grid: CurrentLattice::Convected,
            transfer,
        },
    }
}

fn points<const D: usize>(choices: MaterialPointChoices) -> MaterialPoints<D> {
    MaterialPoints::new(choices).expect("a method")
}

fn state<const D: usize>() -> DeformationGradient {
    match D {
        1 => DeformationGradient::from_stretches([1.15, 1.0, 1.0]),
        _ => DeformationGradient::plane_strain([[1.1, 0.15], [-0.05, 0.92]], 1.03),
    }
    .expect("a state")
}

fn stepped<const D: usize>(
    points: &MaterialPoints<D>,
    f: &DeformationGradient,
) -> TransferredWaves<D> {
    let waves = points.transferred(&ModifiedMooneyRivlin::default(), f);
    waves.expect("an evaluable state").expect("a step")
}

#[test]
fn every_transfer_passes_the_scheme_checks_with_the_gradients_of_functions_and_with_moments() {
    let material = ModifiedMooneyRivlin::default();
    for (gradients, transfer) in BOTH.into_iter().flat_map(|own| ALL.map(|t| (own, t))) {
        for functions in [GridFunctions::Gimp, GridFunctions::CubicSpline] {
            let own = MaterialPointChoices {
                gradients,
                ..choices(transfer, functions)
            };
            assert_scheme(&points::<1>(own), &material, &state::<1>());
        }
        let own = MaterialPointChoices {
            gradients,
            per_side: 1,
            ..choices(transfer, GridFunctions::QuadraticSpline)
        };
        assert_scheme(&points::<2>(own), &material, &state::<2>());
    }
}

#[test]
fn translations_are_neutral_for_every_transfer() {
    for transfer in ALL {
        for functions in [GridFunctions::QuadraticSpline, GridFunctions::CubicSpline] {
            let waves = stepped(&points::<2>(choices(transfer, functions)), &state::<2>());
            for pair in waves.factors(&SVector::zeros(), 0.1) {
                for z in pair {
                    assert!((z - 1.0).norm() < 1e-12, "{transfer:?} {functions:?}: {z}");
                }
            }
        }
    }
}

#[test]
fn only_affine_transfers_preserve_affine_fields() {
    // With affine fields the loss of a long wave is of fourth order in k; without affine fields it is D_p k^2.
    let spacing = 0.8;
    for (functions, moment) in [
        (GridFunctions::QuadraticSpline, 0.25),
        (GridFunctions::CubicSpline, 1.0 / 3.0),
    ] {
        let lost = |transfer: Transfer, size: f64| {
            let waves = stepped(&points::<2>(choices(transfer, functions)), &state::<2>());
            waves.lost(&SVector::from([0.6 * size, -0.8 * size]))
        };
        let affine = [0.02, 0.01].map(|size| lost(Transfer::Affine, size));
        assert!((affine[0] / affine[1] - 16.0).abs() < 0.01, "{affine:?}");
        let constant = lost(PIC, 0.01) / 1e-4;
        let expected = moment * spacing * spacing;
        assert!((constant / expected - 1.0).abs() < 1e-3, "{constant}");
    }
}

#[test]
fn the_preserved_fraction_is_between_zero_and_one_and_larger_with_affine_fields() {
    for functions in [
        GridFunctions::Linear,
        GridFunctions::Gimp,
        GridFunctions::QuadraticSpline,
        GridFunctions::CubicSpline,
    ] {
        let [pic, apic] = [PIC, Transfer::Affine]
            .map(|transfer| stepped(&points::<2>(choices(transfer, functions)), &state::<2>()));
        for n in 0..64 {
            let k = SVector::from([f64::from(n % 8), f64::from(n / 8)]) * (TAU / 0.8 / 8.0);
            let (without, with) = (pic.lost(&k), apic.lost(&k));
            assert!((0.0..=1.0).contains(&without) && with >= 0.0);
            assert!(with <= without + 1e-14, "{functions:?} {k:?}");
        }
    }
}

#[test]
fn growing_waves_are_found_if_they_are_long_or_in_narrow_wells() {
    // Eigenvalues of the matrix of a complete step of all points of a wave, with a dense search over the zone.
    let blatz_ko = onset::material::library()
        .iter()
        .find(|law| law.name == "blatz-ko");
    let material = blatz_ko.expect("a law").build(&[]).expect("defaults");
    let long = DeformationGradient::from_stretches([1.04, 1.0, 1.0]).expect("a state");
    let sheared = DeformationGradient::plane_strain(
        [
            [1.058_060_674_642_809_8, -0.274_204_461_057_231_8],
            [0.0, 1.147_150_949_619_226_7],
        ],
        1.0,
    );
    let sheared = sheared.expect("a state");
    for (f, transfer, per_side, offset, growth, at) in [
        (long, FLIP, 1, -0.04, 4.4961e-3, [0.324, 0.0]),
        (
            sheared,
            Transfer::Affine,
            2,
            0.019_440_107_918_570_572,
            2.5243e-4,
            [-0.0562, 0.1898],
        ),
    ] {
        let method = points::<2>(MaterialPointChoices {
            spacing: 1.0,
            density: 1.0,
            per_side,
            offset: [offset; 3],
            ..choices(transfer, GridFunctions::QuadraticSpline)
        });
        let waves = method
            .transferred(&*material, &f)
            .expect("waves")
            .expect("a step");
        let (rate, k) = waves.fastest(0.5 * waves.critical_time_step());
        assert!((rate.re / growth - 1.0).abs() < 1e-4, "{rate} at {k:?}");
        let at = SVector::from(at);
        let apart = (k - at).amax().min((k + at).amax());
        assert!(apart < 2e-3, "{k:?}");
    }
}

#[test]
fn short_steps_of_flip_converge_to_the_rates_in_continuous_time() {
    let functions = GridFunctions::QuadraticSpline;
    let continuous = points::<2>(choices(Transfer::Continuous, functions));
    let material = ModifiedMooneyRivlin::default();
    let system = continuous.waves(&material, &state::<2>()).expect("waves");
    let waves = stepped(&points::<2>(choices(FLIP, functions)), &state::<2>());
    let k = SVector::from([1.9, -0.7]);
    let expected = system.omega_squared(&k);
    let error = |step: f64| {
        let rates = waves.rates(&k, step);
        let apart = |square: &Complex<f64>| {
            let exact = (-square).sqrt();
            let near = rates
                .iter()
                .map(|s| (s - exact).norm().min((s + exact).norm()));
            near.fold(f64::INFINITY, f64::min)
        };
        // Waves that vanish on the grid have zero frequency.
        let seen = expected.iter().filter(|square| square.norm() > 1e-9);
        seen.map(apart).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(1e-3), error(1e-4));
    // The difference is the damping of a step, (1 - T) omega^2 dt/2.
    assert!(fine < 1e-3, "{fine}");
    assert!((coarse / fine - 10.0).abs() < 0.5, "{coarse} {fine}");
}

#[test]
fn long_waves_agree_with_the_material_and_have_the_damping_of_the_transfer() {
    let material = ModifiedMooneyRivlin::default();
    let f = DeformationGradient::from_stretches([1.1, 0.95, 1.0]).expect("a state");
    let response = material.response(&f).expect("a response");
    let k = SVector::from([0.01, 0.0]);
    let speed = |i: usize| (response.tangent[(i, 0, i, 0)] / 1.7).sqrt();
    let dt = 0.01;
    for (transfer, viscosity) in [
        (Transfer::Affine, 0.0),
        (PIC, 0.25 * 0.64 / dt),
        (FLIP, 0.0),
    ] {
        let choices = choices(transfer, GridFunctions::QuadraticSpline);
        let waves = stepped(&points::<2>(choices), &f);
        let rates = waves.rates(&k, dt);
        for axis in 0..2 {
            let omega = speed(axis) * 0.01;
            let decay = 0.5 * viscosity * 1e-4;
            let exact = Complex::new(-decay, (omega * omega - decay * decay).sqrt());
            let near = rates.iter().map(|s| (s - exact).norm()).fold(1.0, f64::min);
            assert!(
                near < 2e-3 * exact.norm(),
                "{transfer:?}: {rates:?} {exact}"
            );
        }
    }
}

#[test]
fn no_spectral_radius_exceeds_one_below_the_largest_step_of_a_survey() {
    let material = ModifiedMooneyRivlin::default();
    // There is no stress, so that no wave grows.
    let f = DeformationGradient::identity();
    for transfer in ALL {
        let method = points::<2>(choices(transfer, GridFunctions::QuadraticSpline));
        let survey = Survey::new(&method, &material).expect("a survey");
        let own = survey.critical_time_step(&f, Integrator::KickDriftKick);
        let own = own.expect("a step");
        let waves = stepped(&method, &f);
        let radius = |step: f64| {
            let of = |n: u32| {
                let place = SVector::from([f64::from(n % 40), f64::from(n / 40)]);
                let pairs = waves.factors(&(place * (TAU / 0.8 / 40.0)), step);
                pairs.iter().map(|pair| pair[0].norm()).fold(0.0, f64::max)
            };
            (0..1600).map(of).fold(0.0, f64::max)
        };
        for share in [0.1, 0.4, 0.7, 0.9999] {
            let found = radius(share * own);
            assert!(found < 1.0 + 1e-9, "{transfer:?} {share}: {found}");
        }
        assert!(radius(1.02 * own) > 1.0 + 1e-4, "{transfer:?}");
    }
}

#[test]
fn unstable_waves_grow_with_every_filter_and_more_slowly_with_shorter_steps() {
    // Two points per cell in tension: u'' = -omega^2 u has a negative omega^2 at pi/h.
    let f = DeformationGradient::from_stretches([2.2, 1.0, 1.0]).expect("a state");
    for transfer in ALL {
        let own = MaterialPointChoices {
            offset: [0.0; 3],
            ..choices(transfer, GridFunctions::QuadraticSpline)
        };
        let waves = stepped(&points::<1>(own), &f);
        let long = waves.critical_time_step();
        let growth = |share: f64| waves.fastest(share * long).0.re;
        assert!(growth(0.5) > 0.0, "{transfer:?}");
        if transfer == PIC {
            assert!(growth(0.05) < 0.3 * growth(0.5));
        }
        if transfer == FLIP {
            assert!((growth(0.01) / growth(0.005) - 1.0).abs() < 0.05);
        }
    }
}

#[test]
fn points_on_faces_with_linear_functions_and_invalid_shares_and_orders_are_rejected() {
    let refused = |choices| match MaterialPoints::<2>::new(choices) {
        Err(MethodError::Setting { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    let on_face = MaterialPointChoices {
        offset: [0.25, 0.0, 0.0],
        ..choices(Transfer::Affine, GridFunctions::Linear)
    };
    assert_eq!(refused(on_face), "offset");
    let too_much = Transfer::Blended { flip: 1.2 };
    assert_eq!(
        refused(choices(too_much, GridFunctions::Linear)),
        "flip-share"
    );
    for order in [0, 101] {
        for transfer in [Transfer::Extended { order }, Transfer::FullMass { order }] {
            let own = choices(transfer, GridFunctions::QuadraticSpline);
            assert_eq!(refused(own), "transfer-order");
        }
    }
}

/// Explicit nonlinear code for a periodic patch of the grid with material points. It shares only the law with the library.
struct Code<'a, const D: usize> {
    material: &'a dyn Hyperelastic,
    transfer: Transfer,
    is_moments: bool,
    spacing: f64,
    /// Number of nodes along each side.
    cells: usize,
    x: Vec<SVector<f64, D>>,
    v: Vec<SVector<f64, D>>,
    c: Vec<SMatrix<f64, D, D>>,
    f: Vec<SMatrix<f64, D, D>>,
    /// Stretches of the fixed dimensions.
    rest: DeformationGradient,
    volume: f64,
    mass: f64,
}

/// Node near a point: number, vector from the point, weight and gradient.
type Seen<const D: usize> = (usize, SVector<f64, D>, f64, SVector<f64, D>);

impl<const D: usize> Code<'_, D> {
    /// Quadratic B-splines on the three nearest nodes along each axis, as in MLS-MPM codes.
    fn seen(&self, x: &SVector<f64, D>) -> Vec<Seen<D>> {
        let place = x / self.spacing;
        let base = place.map(|own| (own - 0.5).floor());
        let fx = place - base;
        let weights = fx.map(|fx| {
            let ends = [0.5 * (1.5 - fx).powi(2), 0.5 * (fx - 0.5).powi(2)];
            [ends[0], 0.75 - (fx - 1.0).powi(2), ends[1]]
        });
        let slopes = fx.map(|fx| [fx - 1.5, 2.0 - 2.0 * fx, fx - 0.5]);
        let node = |n: usize| {
            let along: [usize; D] = std::array::from_fn(|i| n / 3_usize.pow(i as u32) % 3);
            let weight: f64 = (0..D).map(|i| weights[i][along[i]]).product();
            let distance: SVector<f64, D> =
                SVector::from_fn(|i, _| (along[i] as f64 - fx[i]) * self.spacing);
            let gradient = SVector::from_fn(|i, _| {
                let part = |j: usize| match i == j {
                    true => slopes[j][along[j]] / self.spacing,
                    false => weights[j][along[j]],
                };
                (0..D).map(part).product()
            });
            let gradient = match self.is_moments {
                true => distance * (weight * 4.0 / self.spacing.powi(2)),
                false => gradient,
            };
            let number = (0..D).rev().fold(0, |sum, i| {
                let own = (base[i] as i64 + along[i] as i64).rem_euclid(self.cells as i64);
                sum * self.cells + own as usize
            });
            (number, distance, weight, gradient)
        };
        (0..3_usize.pow(D as u32)).map(node).collect()
    }

    /// Kirchhoff stress `P F^T`.
    fn kirchhoff(&self, f: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
        let whole = self.rest.with_leading(f);
        let response = self.material.response(&whole).expect("a stress");
        SMatrix::from_fn(|i, j| {
            (0..3)
                .map(|m| response.first_piola[(i, m)] * whole.components()[j][m])
                .sum()
        })
    }

    fn step(&mut self, dt: f64) {
        let nodes = self.cells.pow(D as u32);
        let mut masses = vec![0.0; nodes];
        let mut before = vec![SVector::<f64, D>::zeros(); nodes];
        let mut forces = vec![SVector::<f64, D>::zeros(); nodes];
        let seen: Vec<Vec<Seen<D>>> = self.x.iter().map(|x| self.seen(x)).collect();
        for (p, seen) in seen.iter().enumerate() {
            let stress = self.kirchhoff(&self.f[p]) * self.volume;
            for (node, distance, weight, gradient) in seen {
                masses[*node] += weight * self.mass;
                before[*node] += (self.v[p] + self.c[p] * distance) * (weight * self.mass);
                forces[*node] -= stress * gradient;
            }
        }
        for (velocity, mass) in before.iter_mut().zip(&masses) {
            *velocity /= *mass;
        }
        let after: Vec<_> = before
            .iter()
            .zip(forces.iter().zip(&masses))
            .map(|(velocity, (force, mass))| velocity + force * (dt / mass))
            .collect();
        // Sum of (-1)^(l+1) binomial(k, l) (S+ S)^(l-1) v, with the transfer S+ S to the points and back.
        let with_full_mass = |velocities: &[SVector<f64, D>], order: u32| {
            let mut power = velocities.to_vec();
            let mut binomial = f64::from(order);
            let mut sum: Vec<_> = power.iter().map(|own| own * binomial).collect();
            for l in 1..order {
                let mut back = vec![SVector::<f64, D>::zeros(); nodes];
                for seen in &seen {
                    let own: SVector<f64, D> = seen.iter().map(|near| power[near.0] * near.2).sum();
                    for (node, _, weight, _) in seen {
                        back[*node] += own * (weight * self.mass / masses[*node]);
                    }
                }
                power = back;
                binomial *= -f64::from(order - l) / f64::from(l + 1);
                sum.iter_mut()
                    .zip(&power)
                    .for_each(|(sum, own)| *sum += own * binomial);
            }
            sum
        };
        let (moving, taken) = match self.transfer {
            Transfer::FullMass { order } => {
                let all = with_full_mass(&after, order);
                (all.clone(), all)
            }
            Transfer::Extended { order } => {
                let smooth = with_full_mass(&before, order);
                let taken = (0..nodes).map(|n| smooth[n] + after[n] - before[n]);
                let taken = taken.collect();
                (after, taken)
            }
            _ => (after.clone(), after),
        };
        for (p, seen) in seen.iter().enumerate() {
            let (mut new, mut old) = (SVector::<f64, D>::zeros(), SVector::<f64, D>::zeros());
            let (mut affine, mut gradients) = (SMatrix::zeros(), SMatrix::<f64, D, D>::zeros());
            let mut own = SVector::<f64, D>::zeros();
            for (node, distance, weight, gradient) in seen {
                let velocity = moving[*node];
                own += taken[*node] * *weight;
                new += velocity * *weight;
                old += before[*node] * *weight;
                affine += velocity * distance.transpose() * (weight * 4.0 / self.spacing.powi(2));
                gradients += velocity * gradient.transpose();
            }
            match self.transfer {
                Transfer::Affine => (self.v[p], self.c[p]) = (new, affine),
                Transfer::Blended { flip } => self.v[p] = new + (self.v[p] - old) * flip,
                Transfer::Extended { .. } | Transfer::FullMass { .. } => self.v[p] = own,
                Transfer::Continuous => panic!("no step"),
            }
            self.x[p] += new * dt;
            self.f[p] = (SMatrix::identity() + gradients * dt) * self.f[p];
        }
    }
}

/// Wave of nodes with its amplification factor.
struct Mode<const D: usize> {
    k: SVector<f64, D>,
    u: SVector<Complex<f64>, D>,
    factor: Complex<f64>,
    /// Ratio of the velocities of points to the displacements of nodes.
    speed: Complex<f64>,
}

impl<const D: usize> Mode<D> {
    fn new(
        waves: &TransferredWaves<D>,
        transfer: Transfer,
        k: SVector<f64, D>,
        branch: usize,
        dt: f64,
    ) -> Self {
        let (omega_squared, mode) = waves.system().modes(&k).swap_remove(branch);
        let factor = waves.factors(&k, dt)[branch][0];
        // Grid velocities: w = (z - 1) u / dt after the forces, s = w + dt omega^2 u before the forces. Then z v_p = flip v_p + N (w - flip s). With XPIC
        // z v_p = N (w - s + (1 - L^k)/(1 - L) s).
        let after = (factor - 1.0) / dt;
        let before = after + omega_squared * dt;
        let lost = waves.lost(&k);
        let speed = match transfer {
            Transfer::Blended { flip } => (after - before * flip) / (factor - flip),
            Transfer::Extended { order } => {
                let smooth = (1.0 - lost.powf(f64::from(order))) / (1.0 - lost);
                (after - before + before * smooth) / factor
            }
            _ => after / factor,
        };
        Self {
            k,
            u: SVector::from_fn(|i, _| mode[i]),
            factor,
            speed,
        }
    }

    /// Interpolation of a wave of the nodes, times a number, to a point: field, gradient, and first moment times `D_p^-1`.
    fn at(
        &self,
        code: &Code<'_, D>,
        x: &SVector<f64, D>,
        times: Complex<f64>,
    ) -> (SVector<f64, D>, SMatrix<f64, D, D>, SMatrix<f64, D, D>) {
        let mut sums = (SVector::zeros(), SMatrix::zeros(), SMatrix::zeros());
        for (_, distance, weight, gradient) in code.seen(x) {
            let phase = Complex::new(0.0, self.k.dot(&(x + distance))).exp();
            let own = self.u.map(|u| (u * phase * times).re);
            sums.0 += own * weight;
            sums.1 += own * gradient.transpose();
            sums.2 += own * distance.transpose() * (weight * 4.0 / code.spacing.powi(2));
        }
        sums
    }
}

impl<'a, const D: usize> Code<'a, D> {
    /// Points of a method in a homogeneous state.
    fn new(
        method: &MaterialPoints<D>,
        material: &'a dyn Hyperelastic,
        f: &DeformationGradient,
        cells: usize,
    ) -> Self {
        let choices = method.choices();
        let Formulation::Particles { transfer, .. } = choices.formulation else {
            panic!("no points");
        };
        let spacing = choices.spacing;
        let of_cell = |n: usize| {
            let cell: SVector<f64, D> =
                SVector::from_fn(|i, _| (n / cells.pow(i as u32) % cells) as f64);
            let places = method.points().iter();
            places
                .map(move |(place, _)| (cell + place) * spacing)
                .collect::<Vec<_>>()
        };
        let x: Vec<SVector<f64, D>> = (0..cells.pow(D as u32)).flat_map(of_cell).collect();
        let volume = (spacing / choices.per_side as f64).powi(D as i32);
        Self {
            material,
            transfer,
            is_moments: choices.gradients == GridGradients::Moments,
            spacing,
            cells,
            v: vec![SVector::zeros(); x.len()],
            c: vec![SMatrix::zeros(); x.len()],
            f: vec![f.leading::<D>(); x.len()],
            x,
            rest: *f,
            volume,
            mass: choices.density * volume,
        }
    }

    /// Sets the points to a wave of the nodes.
    fn put(&mut self, mode: &Mode<D>, amplitude: f64) {
        for p in 0..self.x.len() {
            let x = self.x[p];
            let (u, gradients, _) = mode.at(self, &x, Complex::new(amplitude, 0.0));
            let (v, _, affine) = mode.at(self, &x, mode.speed * amplitude);
            self.x[p] += u;
            self.f[p] = (SMatrix::identity() + gradients) * self.f[p];
            self.v[p] = v;
            if self.transfer == Transfer::Affine {
                self.c[p] = affine;
            }
        }
    }
}

/// Number of cells along each side of the patch.
const CELLS: usize = 6;
/// Initial displacement of a node. Contributions of even order cancel between a run and the run with the opposite wave.
const AMPLITUDE: f64 = 1e-5;

/// Runs a code from a single wave and returns the largest difference of the displacements from the linear prediction, relative to the prediction.
fn difference<const D: usize>(
    method: &MaterialPoints<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    mode: &Mode<D>,
    dt: f64,
) -> f64 {
    let steps = 6;
    let start = Code::new(method, material, f, CELLS);
    let displaced = |sign: f64| -> Vec<SVector<f64, D>> {
        let mut code = Code::new(method, material, f, CELLS);
        code.put(mode, sign * AMPLITUDE);
        (0..steps).for_each(|_| code.step(dt));
        code.x
            .iter()
            .zip(&start.x)
            .map(|(x, base)| (x - base) * sign)
            .collect()
    };
    let (plus, minus) = (displaced(1.0), displaced(-1.0));
    let grown = mode.factor.powi(steps) * AMPLITUDE;
    let apart = |p: usize| {
        let (u, _, _) = mode.at(&start, &start.x[p], grown);
        ((plus[p] + minus[p]) * 0.5 - u).amax()
    };
    (0..start.x.len()).map(apart).fold(0.0, f64::max) / grown.norm()
}

fn seeded(transfer: Transfer, gradients: GridGradients) -> MaterialPointChoices {
    MaterialPointChoices {
        gradients,
        formulation: Formulation::Particles {
            grid: CurrentLattice::Regular,
            transfer,
        },
        ..choices(transfer, GridFunctions::QuadraticSpline)
    }
}

/// Checks that the code, with steps that are a fraction of the largest stable step, agrees with the prediction to one part in a million.
fn assert_predicted<const D: usize>(
    transfer: Transfer,
    gradients: GridGradients,
    f: &DeformationGradient,
    turns: [f64; D],
    share: f64,
) {
    let material = ModifiedMooneyRivlin::default();
    let method = points::<D>(seeded(transfer, gradients));
    let waves = stepped(&method, f);
    let dt = share * waves.critical_time_step();
    let k = SVector::from(turns) * (TAU / (method.choices().spacing * CELLS as f64));
    for branch in 0..D {
        let mode = Mode::new(&waves, transfer, k, branch, dt);
        let apart = difference(&method, &material, f, &mode, dt);
        let factor = mode.factor;
        assert!(
            apart < 1e-6,
            "{transfer:?} {gradients:?} {turns:?} {share}: {apart}, a factor of {factor}"
        );
    }
}

#[test]
fn an_independent_code_is_stable_up_to_the_predicted_step_in_one_dimension() {
    for (gradients, transfer) in BOTH.into_iter().flat_map(|own| ALL.map(|t| (own, t))) {
        // In the reference state, compressed, and stretched beyond the onset of the tensile instability; with a stable step and with a step that is
        // too long.
        for (stretch, turns, share) in [
            (1.0, 1.0, 0.5),
            (0.8, 2.0, 0.9),
            (2.2, 3.0, 0.4),
            (1.0, 3.0, 1.05),
        ] {
            let f = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
            assert_predicted::<1>(transfer, gradients, &f, [turns], share);
        }
    }
}

#[test]
fn an_independent_code_is_stable_up_to_the_predicted_step_in_two_dimensions_under_shear() {
    for (gradients, transfer) in BOTH.into_iter().flat_map(|own| ALL.map(|t| (own, t))) {
        for (turns, share) in [([1.0, 2.0], 0.5), ([3.0, 1.0], 0.8)] {
            assert_predicted::<2>(transfer, gradients, &state::<2>(), turns, share);
        }
    }
}

/// Compares a step of the library with a step of the code, for motions that are not small.
fn assert_same_steps<const D: usize>(
    transfer: Transfer,
    gradients: GridGradients,
    f: &DeformationGradient,
) {
    let choices = seeded(transfer, gradients);
    let material = ModifiedMooneyRivlin::default();
    let method = points::<D>(choices.clone());
    let law: Arc<dyn Hyperelastic> = Arc::new(material);
    let lattice = [LatticeKind::Chain, LatticeKind::Square][D - 1];
    let particles = KernelMethodChoices {
        lattice,
        ..KernelMethodChoices::default()
    };
    let own = MethodChoices::MaterialPoints(Box::new(particles), choices);
    let analysis = analysis(&own, law).expect("a method");
    let mut code = Code::new(&method, &material, f, CELLS);
    let start = Code::new(&method, &material, f, CELLS);
    let mut checked = 0;
    let mut beside = |patch: &mut dyn PatchMotion| {
        let dt = 0.4 * patch.critical_time_step(Stepper::KICK_DRIFT_KICK);
        let wave = patch.waves().iter().find(|wave| wave.turns.contains(&1));
        let wave = patch.stepped(wave.expect("a wave"), Stepper::KICK_DRIFT_KICK, dt);
        let mut state = patch.seed(&wave.expect("a wave"), 0.02);
        // Affine fields are added that no wave contains.
        let count = code.x.len();
        if transfer == Transfer::Affine {
            for (n, own) in state.deformations[count * D * D..].iter_mut().enumerate() {
                *own += 0.01 * (n as f64).sin();
            }
        }
        patch.put(&state);
        let tensors: Vec<SMatrix<f64, D, D>> = state
            .deformations
            .chunks_exact(D * D)
            .map(SMatrix::from_column_slice)
            .collect();
        for p in 0..count {
            let of = |flat: &[f64]| SVector::<f64, D>::from_column_slice(&flat[D * p..D * (p + 1)]);
            code.x[p] += of(&state.displacements);
            code.v[p] = of(&state.velocities);
            code.f[p] = (SMatrix::identity() + tensors[p]) * code.f[p];
            code.c[p] = tensors[count + p] / code.spacing;
        }
        for _ in 0..8 {
            patch.advance(Stepper::KICK_DRIFT_KICK, dt).expect("a step");
            code.step(dt);
        }
        let state = patch.state();
        for p in 0..count {
            for i in 0..D {
                let expected = [code.x[p][i] - start.x[p][i], code.v[p][i]];
                let own = [&state.displacements, &state.velocities].map(|own| own[D * p + i]);
                for (own, expected) in own.into_iter().zip(expected) {
                    assert!((own - expected).abs() < 1e-12, "{own} {expected}");
                    checked += usize::from(expected.abs() > 1e-4);
                }
            }
        }
    };
    analysis
        .with_motion(f, &[CELLS; D], &mut beside)
        .expect("a motion");
    assert!(checked > 10, "{transfer:?}: {checked}");
}

#[test]
fn a_patch_of_the_library_moves_like_an_independent_code() {
    for (gradients, transfer) in BOTH.into_iter().flat_map(|own| ALL.map(|t| (own, t))) {
        assert_same_steps::<1>(transfer, gradients, &state::<1>());
        assert_same_steps::<2>(transfer, gradients, &state::<2>());
    }
}

#[test]
fn an_isolated_point_is_stable_up_to_its_critical_step() {
    let material = ModifiedMooneyRivlin::default();
    let rest = DeformationGradient::identity();
    for (gradients, transfer) in BOTH.into_iter().flat_map(|own| ALL.map(|t| (own, t))) {
        let own = MaterialPointChoices {
            per_side: 1,
            ..seeded(transfer, gradients)
        };
        let method = points::<2>(own);
        let alone = stepped(&method, &rest).isolated_point().expect("no stress");
        let strained = |share: f64| {
            let mut code = Code::new(&method, &material, &rest, CELLS);
            code.x.truncate(1);
            code.f[0] *= 1.0 + 1e-9;
            // Largest displacement over all steps; the run ends when the motion is large.
            let mut largest: f64 = 0.0;
            for _ in 0..400 {
                code.step(share * alone);
                largest = largest.max((code.f[0] - SMatrix::identity()).amax());
                if largest > 1e-4 {
                    break;
                }
            }
            largest
        };
        assert!(strained(0.98) < 1e-7, "{transfer:?} {gradients:?}");
        assert!(strained(1.02) > 1e-4, "{transfer:?} {gradients:?}");
    }
}

#[test]
fn the_step_of_an_isolated_point_follows_from_its_change_of_volume() {
    // In the plane l = 1 has the stress A_1111 + A_1122, and D_p = h^2/4 gives dt = h sqrt(rho / (A_1111 + A_1122)) with affine fields.
    let material = ModifiedMooneyRivlin::default();
    let rest = DeformationGradient::identity();
    let response = material.response(&rest).expect("a response");
    let [a, b] = [
        response.tangent[(0, 0, 0, 0)],
        response.tangent[(0, 0, 1, 1)],
    ];
    let own = seeded(Transfer::Affine, GridGradients::Moments);
    let alone = stepped(&points::<2>(own), &rest).isolated_point();
    let expected = 0.8 * (1.7 / (a + b)).sqrt();
    assert!((alone.expect("no stress") / expected - 1.0).abs() < 1e-12);
}

/// Amplification factors of all waves in a time step, at some wave vectors of the plane.
fn factors(waves: &TransferredWaves<2>, step: f64) -> Vec<Complex<f64>> {
    let each = (0..25).flat_map(|n| {
        let place = SVector::from([f64::from(n % 5), f64::from(n / 5)]);
        waves.factors(&(place * (TAU / 0.8 / 9.0)), step)
    });
    each.flatten().collect()
}

#[test]
fn xpic_and_fmpm_of_the_first_order_are_pic() {
    let of = |transfer| {
        let method = points::<2>(choices(transfer, GridFunctions::QuadraticSpline));
        stepped(&method, &state::<2>())
    };
    let pic = of(PIC);
    let step = 0.6 * pic.critical_time_step();
    for transfer in [
        Transfer::Extended { order: 1 },
        Transfer::FullMass { order: 1 },
    ] {
        let own = of(transfer);
        for (a, b) in factors(&own, step).iter().zip(factors(&pic, step)) {
            assert!((a - b).norm() < 1e-14, "{transfer:?}: {a} {b}");
        }
        assert_eq!(own.isolated_point(), pic.isolated_point());
    }
}

#[test]
fn xpic_of_high_order_is_flip_without_the_velocities_that_the_grid_does_not_resolve() {
    let of = |transfer| points::<2>(choices(transfer, GridFunctions::QuadraticSpline));
    let method = of(Transfer::Extended { order: 100 });
    // One node in a cell of four points: velocities in the null space of the grid vanish in one step.
    assert_eq!(method.crystal().sites().len(), 1);
    assert_eq!(of(FLIP).crystal().sites().len(), 4);
    let [own, flip] = [&method, &of(FLIP)].map(|method| stepped(method, &state::<2>()));
    let step = 0.6 * flip.critical_time_step();
    for n in 0..25 {
        let k = SVector::from([f64::from(n % 5), f64::from(n / 5)]) * (TAU / 0.8 / 9.0);
        // Waves with small velocities at the points need more terms.
        let left = own.lost(&k).powi(100);
        let [own, flip] = [&own, &flip].map(|waves| waves.factors(&k, step).concat());
        for (a, b) in own.iter().zip(flip) {
            assert!((a - b).norm() < 1e-9 + 10.0 * left, "{k:?}: {a} {b}");
        }
    }
}

#[test]
fn fmpm_of_high_order_has_the_waves_of_the_consistent_mass_matrix() {
    let material = ModifiedMooneyRivlin::default();
    let (functions, f) = (
        GridFunctions::QuadraticSpline,
        DeformationGradient::identity(),
    );
    let consistent = points::<2>(MaterialPointChoices {
        formulation: Formulation::Updated {
            mass: GridMass::Consistent,
            grid: CurrentLattice::Convected,
        },
        ..choices(PIC, functions)
    });
    let consistent = consistent.waves(&material, &f).expect("waves");
    let waves = stepped(
        &points::<2>(choices(Transfer::FullMass { order: 100 }, functions)),
        &f,
    );
    let step = 0.5 * waves.critical_time_step();
    for place in [[0.3, 0.1], [1.2, -0.8], [2.0, 1.7]] {
        let k = SVector::from(place);
        let own = waves.factors(&k, step);
        for (pair, square) in own.iter().zip(consistent.omega_squared(&k)) {
            // Leapfrog: the factors exp(+-i a), cos a = 1 - omega^2 dt^2 / 2.
            let cosine = 1.0 - 0.5 * square.re * step * step;
            assert!(
                (pair[0].re - cosine).abs() < 1e-6,
                "{k:?}: {pair:?} {cosine}"
            );
            assert!((pair[0].norm() - 1.0).abs() < 1e-6, "{k:?}: {pair:?}");
        }
    }
}

/// Largest stable step of unstressed points on a chain, in units of the grid spacing divided by the sound speed.
fn largest_step_of_a_chain(per_side: usize, functions: GridFunctions, transfer: Transfer) -> f64 {
    let material = ModifiedMooneyRivlin::default();
    let rest = DeformationGradient::identity();
    let response = material.response(&rest).expect("a response");
    let own = MaterialPointChoices {
        per_side,
        offset: [0.0; 3],
        ..choices(transfer, functions)
    };
    let waves = stepped(&points::<1>(own), &rest);
    waves.critical_time_step() * (response.tangent[(0, 0, 0, 0)] / 1.7).sqrt() / 0.8
}

/// Order, and largest stable steps of FMPM and XPIC with two points per cell of a chain and quadratic splines.
const REFERENCE_STEPS: [(u32, f64, f64); 7] = [
    (1, 1.419_684_754, 1.419_684_754),
    (2, 1.149_839_998, 1.390_410_517),
    (3, 1.025_004_564, 1.374_686_079),
    (4, 0.948_658_338, 1.365_682_857),
    (8, 0.825_588_285, 1.353_069_647),
    (16, 0.767_988_252, 1.350_133_163),
    (100, 0.750_000_049, 1.349_985_937),
];

#[test]
fn the_largest_step_of_fmpm_falls_with_the_order_to_the_step_of_the_consistent_mass_matrix() {
    // Minimum over 200,000 wave vectors of the closed form, which agrees with the eigenvalues of the matrix of a step of a patch of eight cells in NumPy
    // to 1e-13.
    let spline = GridFunctions::QuadraticSpline;
    for (order, fmpm, xpic) in REFERENCE_STEPS {
        for (expected, transfer) in [
            (fmpm, Transfer::FullMass { order }),
            (xpic, Transfer::Extended { order }),
        ] {
            let found = largest_step_of_a_chain(2, spline, transfer);
            assert!((found - expected).abs() < 1e-6, "{transfer:?}: {found}");
        }
    }
}

#[test]
fn the_critical_step_of_fmpm_falls_with_the_root_of_the_order_for_a_wave_that_vanishes_at_the_points()
 {
    // The wave of length 2 h strains a point at the center of its cell without moving it: omega = 2 c/h, and the inverse mass of FMPM(k) is k times the
    // inverse lumped mass.
    for order in [1, 2, 4, 8, 50] {
        for functions in [GridFunctions::Linear, GridFunctions::QuadraticSpline] {
            let found = largest_step_of_a_chain(1, functions, Transfer::FullMass { order });
            let expected = (0.5 / f64::from(order)).sqrt();
            assert!((found / expected - 1.0).abs() < 1e-9, "{order}: {found}");
        }
    }
}
