//! Dissipation of an acoustic Riemann solver between the pairs of total-Lagrangian SPH.

use crate::battery::assert_scheme;
use crate::random::Random;
use crate::sph::{crystal, stretched};
use crate::states::saint_venant_kirchhoff;
use nalgebra::{SMatrix, SVector};
use onset::algebra::Complex;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::Hyperelastic;
use onset::scheme::Discretization;
use onset::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
use onset::scheme::stabilization::Upwinding;

const LAMBDA: f64 = 1.7;
const MU: f64 = 0.8;
const RHO: f64 = 1.3;
const RADIUS: f64 = 2.3;

fn solid() -> Box<dyn Hyperelastic> {
    saint_venant_kirchhoff(LAMBDA, MU)
}

fn upwinded<const D: usize>(
    kind: LatticeKind,
    upwinding: Upwinding,
    corrected: bool,
) -> TotalLagrangianSph<D> {
    let choices = TotalLagrangianChoices {
        density: RHO,
        kernel: Kernel::QuarticSpline,
        radius: RADIUS,
        corrected,
        upwinding,
        ..TotalLagrangianChoices::default()
    };
    TotalLagrangianSph::new(crystal(kind), choices).expect("a scheme")
}

/// Damping `C(k)` of a Bravais lattice by sums over the pairs of a particle, whose gradients are computed here; `primitive` has the primitive vectors as
/// columns.
fn summed<const D: usize>(
    primitive: &SMatrix<f64, D, D>,
    volume: f64,
    f: &SMatrix<f64, D, D>,
    k: &SVector<f64, D>,
    is_linear: bool,
    corrected: bool,
) -> SMatrix<Complex, D, D> {
    let kernel = Kernel::QuarticSpline;
    let integral = kernel.integral::<D>(RADIUS);
    let digits = (0..9_usize.pow(D as u32))
        .map(|n| SVector::<f64, D>::from_fn(|i, _| (n / 9_usize.pow(i as u32) % 9) as f64 - 4.0));
    let bonds = digits.map(|n| primitive * n).filter(|x| x.norm() > 0.0);
    let mut pairs: Vec<(SVector<f64, D>, SVector<f64, D>)> = bonds
        .filter_map(|x| {
            let weight = kernel.weight(&x, RADIUS, &SMatrix::identity())?;
            Some((x, -weight.gradient / integral * volume))
        })
        .collect();
    if corrected {
        let moment: SMatrix<f64, D, D> = pairs.iter().map(|(x, g)| x * g.transpose()).sum();
        let inverse = moment.try_inverse().expect("neighbors in all directions");
        for (_, g) in &mut pairs {
            *g = inverse.transpose() * *g;
        }
    }
    let turn = |x: &SVector<f64, D>| Complex::new(k.dot(x).cos(), k.dot(x).sin());
    let one = Complex::new(1.0, 0.0);
    // A velocity v exp(i k.X) has the gradient v (x) gradient at the origin.
    let gradient: SVector<Complex, D> = pairs
        .iter()
        .map(|(x, g)| g.map(Complex::from) * (turn(x) - one))
        .sum();
    let (pressure, shear) = (((LAMBDA + 2.0 * MU) / RHO).sqrt(), (MU / RHO).sqrt());
    let cofactor = f.try_inverse().expect("a regular state").transpose();
    let of_pair = |(x, g): &(SVector<f64, D>, SVector<f64, D>)| {
        let n = (cofactor * g).normalize();
        let along = n * n.transpose();
        let impedance = along * pressure + (SMatrix::identity() - along) * shear;
        let uniform: Complex = (0..D).map(|i| gradient[i] * x[i]).sum();
        let mut jump = turn(x) - one;
        if is_linear {
            jump -= uniform * (one + turn(x)) * 0.5;
        }
        (impedance * (RHO * volume * g.norm())).map(|entry| -jump * entry)
    };
    pairs.iter().map(of_pair).sum()
}

/// Compares the damping at random states and waves, and checks that it takes energy from every wave.
fn compared<const D: usize>(kind: LatticeKind) {
    let mut random = Random::new(7);
    let own = crystal::<D>(kind);
    let primitive = *own.lattice().vectors();
    let material = solid();
    for (upwinding, corrected) in [
        (Upwinding::Constant, false),
        (Upwinding::Constant, true),
        (Upwinding::Linear, false),
        (Upwinding::Linear, true),
    ] {
        let scheme = upwinded::<D>(kind, upwinding, corrected);
        for _ in 0..4 {
            let mut whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            for i in 0..D {
                for j in 0..D {
                    whole[i][j] += 0.3 * random.number();
                }
            }
            let f = DeformationGradient::new(whole).expect("a deformation");
            let waves = scheme.waves(&*material, &f).expect("an evaluable state");
            let k = SVector::<f64, D>::from_fn(|_, _| 3.0 * random.number());
            let damping = waves.damping().expect("a damping").at(&k);
            let is_linear = upwinding == Upwinding::Linear;
            let state = f.leading::<D>();
            let volume = own.volumes()[0];
            let expected = summed(&primitive, volume, &state, &k, is_linear, corrected);
            let error = (0..D * D).map(|n| (damping[(n % D, n / D)] - expected[n]).norm());
            let scale = expected.norm();
            assert!(
                error.fold(0.0, f64::max) < 1e-12 * scale,
                "{upwinding:?}, corrected: {corrected}: {damping} {expected}"
            );
            let hermitian = (&damping + damping.adjoint()).map(|entry| entry * 0.5);
            let lowest = hermitian.symmetric_eigenvalues().min();
            assert!(lowest > 1e-3 * scale, "{upwinding:?}: {lowest} {scale}");
        }
    }
}

#[test]
fn upwinding_damps_waves_by_the_sum_over_the_pairs() {
    compared::<1>(LatticeKind::Chain);
    compared::<2>(LatticeKind::Square);
    compared::<2>(LatticeKind::Hexagonal);
    compared::<3>(LatticeKind::FaceCenteredCubic);
}

#[test]
fn upwinding_changes_no_stiffness_and_its_linear_form_spares_long_waves() {
    let (material, f) = (solid(), stretched([1.1, 0.95, 1.0]));
    let damping = |upwinding: Upwinding, k: f64| {
        let scheme = upwinded::<2>(LatticeKind::Square, upwinding, true);
        let waves = scheme.waves(&*material, &f).expect("an evaluable state");
        let at = SVector::from([k, 0.6 * k]);
        let plain = upwinded::<2>(LatticeKind::Square, Upwinding::None, true);
        let plain = plain.waves(&*material, &f).expect("an evaluable state");
        let change = waves.stiffness().at(&at) - plain.stiffness().at(&at);
        assert!(change.norm() < 1e-14 * plain.stiffness().magnitude());
        waves.damping().expect("a damping").at(&at).norm()
    };
    for (upwinding, order) in [(Upwinding::Constant, 2.0), (Upwinding::Linear, 4.0)] {
        let found = (damping(upwinding, 2e-2) / damping(upwinding, 1e-2)).log2();
        assert!((found - order).abs() < 1e-2, "{upwinding:?}: {found}");
    }
}

#[test]
fn upwinding_damps_waves_like_the_forces_of_a_patch() {
    let material = solid();
    for upwinding in [Upwinding::Constant, Upwinding::Linear] {
        let f = stretched([1.1, 0.95, 1.0]);
        assert_scheme(
            &upwinded::<1>(LatticeKind::Chain, upwinding, true),
            &*material,
            &f,
        );
        assert_scheme(
            &upwinded::<2>(LatticeKind::Honeycomb, upwinding, true),
            &*material,
            &f,
        );
    }
}
