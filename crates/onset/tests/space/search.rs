//! The search over the zone in 3D, compared with dense grids.

use crate::{CUBIC, config, deformation, discretization, state};
use nalgebra::{Matrix3, Vector3};
use onset::bloch::{SpectrumSummary, Stability, ZoneSearch, dynamical_matrix, growth_rate};
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{Frame, KernelMethodChoices, Linearization, Method};
use onset::quadrature::{Quadrature, QuadraturePoint};
use onset::verdict::{Survey, speed_squared};
use proptest::prelude::*;

/// Extremes of a spectrum on a dense grid.
struct Sampled {
    scaled: f64,
    lowest: f64,
    highest: f64,
    growth: f64,
}

fn sampled(
    method: &Method<3>,
    law: &dyn Hyperelastic,
    f: &DeformationGradient,
    side: usize,
) -> Sampled {
    let d = dynamical_matrix(method, law, f).expect("finite");
    let speed_squared = speed_squared(method, law).expect("finite");
    let mut seen = Sampled {
        scaled: f64::INFINITY,
        lowest: 0.0,
        highest: 0.0,
        growth: 0.0,
    };
    // Half of the zone, shifted from the search grid.
    for index in 0..side * side * side / 2 {
        let cell = [index % side, index / side % side, index / side / side];
        let fractional = Vector3::from(cell.map(|n| n as f64)) + Vector3::new(0.37, 0.61, 0.23);
        let k = method.lattice().reciprocal() * fractional / side as f64;
        let values = d.omega_squared(&k);
        let laplacian = method.lattice().laplacian(&k);
        seen.scaled = seen.scaled.min(values[0].re / (speed_squared * laplacian));
        seen.lowest = seen.lowest.min(values[0].re);
        seen.highest = seen.highest.max(values[2].re);
        seen.growth = values
            .iter()
            .map(|value| growth_rate(*value))
            .fold(seen.growth, f64::max);
    }
    seen
}

fn search_of(
    method: &Method<3>,
    law: &ModifiedMooneyRivlin,
    f: &DeformationGradient,
) -> ZoneSearch<3> {
    let speed_squared = speed_squared(method, law).expect("a scale");
    ZoneSearch::new(method, f, speed_squared).expect("finite")
}

fn compared(method: &Method<3>, f: &DeformationGradient) -> Result<(), TestCaseError> {
    let law = ModifiedMooneyRivlin::default();
    let d = dynamical_matrix(method, &law, f).expect("finite");
    let search = search_of(method, &law, f);
    let summary = search.summary(&d);
    let seen = sampled(method, &law, f, 18);
    prop_assert!(
        summary.softest.scaled <= seen.scaled + 1e-7,
        "{} above {}",
        summary.softest.scaled,
        seen.scaled
    );
    prop_assert!(
        seen.lowest >= 0.0 || summary.lowest.omega_squared.re <= seen.lowest + 1e-7 * seen.highest,
        "{} above {}",
        summary.lowest.omega_squared.re,
        seen.lowest
    );
    prop_assert!(summary.maximum_omega.powi(2) >= seen.highest * (1.0 - 1e-9));
    prop_assert!(
        summary.growth_rate() >= seen.growth * (1.0 - 1e-5) - 1e-6 * seen.highest.sqrt(),
        "growth {} below {}",
        summary.growth_rate(),
        seen.growth
    );
    // The modes in the summary satisfy D g = omega^2 g.
    for mode in [summary.lowest, summary.fastest_growing, summary.softest] {
        if !mode.is_long_wave {
            let residual = d.at(&mode.wave_vector) * mode.polarization
                - mode.polarization * mode.omega_squared;
            let size = residual.iter().map(|x| x.norm()).fold(0.0, f64::max);
            prop_assert!(size < 1e-7 * seen.highest, "{:e} of {:?}", size, mode);
        }
    }
    let (stability, measure) = search.stability(&d);
    prop_assert_eq!(stability, summary.stability(), "measure {}", measure);
    is_surveyed(method, f, &summary);
    Ok(())
}

/// Checks the growth rate of surveys of maps, which omit flutter that grows more slowly than divergence.
fn is_surveyed(method: &Method<3>, f: &DeformationGradient, summary: &SpectrumSummary<3>) {
    let law = ModifiedMooneyRivlin::default();
    let survey = Survey::new(method, &law).expect("a scale");
    let state = survey.state(f).expect("a state");
    assert_eq!(state.stability, summary.stability());
    let (rate, whole) = (state.growth_rate, summary.growth_rate());
    assert!((rate - whole).abs() <= 1e-9 * whole, "{rate} {whole}");
}

proptest! {
    #![proptest_config(config(16))]

    #[test]
    fn extremes_of_the_search_reach_the_extremes_of_a_dense_grid(
        kind in prop::sample::select(CUBIC.to_vec()),
        frame in prop::sample::select(vec![Frame::Lagrangian, Frame::Eulerian, Frame::Eulerian]),
        f in deformation(),
    ) {
        let choices = discretization(kind, frame, Quadrature::Nodal);
        compared(&Method::new(choices).expect("a method"), &state(&f))?;
    }

    #[test]
    fn extremes_without_an_inversion_center_reach_the_extremes_of_a_dense_grid(f in deformation(), place in prop::array::uniform3(0.1..0.4_f64)) {
        // One stress point off the centers: D is complex, and modes flutter.
        let choices = discretization(LatticeKind::SimpleCubic, Frame::Eulerian, Quadrature::StressPointsOnly);
        let method = Method::<3>::new(choices).expect("a method");
        let volume = method.lattice().cell_volume();
        let points = vec![QuadraturePoint::new(Vector3::from(place), volume)];
        compared(&method.with_quadrature_points(points), &state(&(f * 0.98)))?;
    }
}

#[test]
fn flutter_in_3d_is_found_with_its_mode_and_growth_rate() {
    // Two branches meet: an Eulerian kernel with fixed normalization has no potential.
    let choices = KernelMethodChoices {
        linearization: Linearization::Paper,
        ..discretization(
            LatticeKind::FaceCenteredCubic,
            Frame::Eulerian,
            Quadrature::Nodal,
        )
    };
    let method = Method::<3>::new(choices).expect("a method");
    let law = ModifiedMooneyRivlin::default();
    let mut fluttering = 0;
    for shear in [0.1, 0.3, 0.5] {
        let f = state(&Matrix3::new(
            0.9,
            shear,
            0.0,
            0.0,
            0.92,
            0.5 * shear,
            0.1,
            0.0,
            0.95,
        ));
        let seen = sampled(&method, &law, &f, 24);
        let d = dynamical_matrix(&method, &law, &f).expect("finite");
        let summary = search_of(&method, &law, &f).summary(&d);
        assert!(summary.growth_rate() >= seen.growth * (1.0 - 1e-6));
        is_surveyed(&method, &f, &summary);
        fluttering += usize::from(summary.flutters || summary.stability() == Stability::Flutter);
    }
    assert!(fluttering > 0, "complex branches are met");
}
