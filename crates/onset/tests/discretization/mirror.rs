//! States with a mirror line: the search over a quarter of the zone, compared with the search over the whole zone and with dense grids.

use crate::choices::{Case, case, config};
use nalgebra::Vector2;
use onset::bloch::{SpectrumSummary, ZoneSearch, dynamical_matrix};
use onset::kinematics::DeformationGradient;
use onset::material::ModifiedMooneyRivlin;
use onset::method::{Background, CurrentLattice, Frame, KernelMethodChoices, Method, MethodError};
use onset::quadrature::Quadrature;
use onset::verdict::{Survey, speed_squared};
use proptest::prelude::*;

fn summary(case: &Case) -> Result<SpectrumSummary<2>, MethodError> {
    let (method, material) = (case.method(), case.material());
    let d = dynamical_matrix(&method, &*material, &case.state)?;
    let speed_squared = speed_squared(&method, &*material)?;
    let search = ZoneSearch::new(&method, &case.state, speed_squared);
    Ok(search.ok_or(MethodError::NotFinite)?.summary(&d))
}

/// State after a rotation of the spatial axes by an angle.
fn turned(state: &DeformationGradient, angle: f64) -> DeformationGradient {
    let (sine, cosine) = angle.sin_cos();
    let f = state.components();
    let turn = [[cosine, -sine], [sine, cosine]];
    let turned = std::array::from_fn(|i| {
        std::array::from_fn(|j| turn[i][0] * f[0][j] + turn[i][1] * f[1][j])
    });
    DeformationGradient::plane_strain(turned, 1.0).expect("a positive volume ratio")
}

fn with_state(case: &Case, state: DeformationGradient) -> Case {
    Case {
        state,
        ..case.clone()
    }
}

proptest! {
    #![proptest_config(config(120))]

    #[test]
    fn a_quarter_of_the_zone_gives_the_extremes_of_the_whole_zone(case in case(), first in 0.8..1.3_f64, second in 0.8..1.3_f64) {
        // Along the axes force constants have a mirror line. After a rotation by an angle without lattice symmetry the whole zone is searched.
        // A regular lattice does not rotate with the state, nor does an interpolated background.
        let discretization = KernelMethodChoices {
            current_lattice: CurrentLattice::Convected,
            background: Background::Imposed,
            ..case.discretization
        };
        let case = Case { discretization, ..case };
        let along = DeformationGradient::from_stretches([first, second, 1.0]).expect("positive");
        let (Ok(mirrored), Ok(whole)) = (
            summary(&with_state(&case, along)),
            summary(&with_state(&case, turned(&along, 0.3))),
        ) else {
            return Ok(());
        };
        let (a, b) = (mirrored.softest.scaled, whole.softest.scaled);
        prop_assert!(a <= b + 1e-9 + 1e-9 * b.abs(), "softest {a} above {b}");
        let (a, b) = (mirrored.lowest.omega_squared.re, whole.lowest.omega_squared.re);
        let largest = whole.maximum_omega.powi(2);
        prop_assert!(a <= b + 1e-9 * largest, "lowest {a} above {b}");
        prop_assert!(mirrored.maximum_omega.powi(2) >= largest * (1.0 - 1e-9));
        let (a, b) = (mirrored.growth_rate(), whole.growth_rate());
        // Pockets with complex branches can be narrower than any grid.
        prop_assert!(a >= b - 1e-3 * largest.sqrt(), "growth {a} below {b}");
    }
}

/// Smallest scaled measure on a grid of 200 by 200 wave vectors.
fn of_dense_grid(method: &Method<2>, state: &DeformationGradient) -> f64 {
    const COUNT: i32 = 200;
    let material = ModifiedMooneyRivlin::default();
    let d = dynamical_matrix(method, &material, state).expect("finite");
    let speed_squared = speed_squared(method, &material).expect("finite");
    let lattice = method.lattice();
    let mut least = f64::INFINITY;
    for i in 0..COUNT {
        for j in 0..=COUNT / 2 {
            if i + j > 0 {
                let fractional = Vector2::new(f64::from(i), f64::from(j)) / f64::from(COUNT);
                let k = lattice.reciprocal() * fractional;
                let scaled = d.omega_squared(&k)[0].re / (speed_squared * lattice.laplacian(&k));
                least = least.min(scaled);
            }
        }
    }
    least
}

#[test]
fn no_point_of_a_dense_grid_is_below_the_minimum_of_a_survey() {
    let eulerian = KernelMethodChoices {
        frame: Frame::Eulerian,
        ..KernelMethodChoices::default()
    };
    let methods = [
        eulerian.clone(),
        KernelMethodChoices {
            lattice: onset::lattice::LatticeKind::Square,
            ..eulerian.clone()
        },
        KernelMethodChoices {
            quadrature: Quadrature::Nodal,
            approximation: onset::approximation::Approximation::Mls,
            ..eulerian
        },
    ];
    // In the first two states several wells lie within one step of the search grid.
    let states = [
        [1.0783474, 1.19850285, 0.0],
        [0.56262775, 1.29314384, 0.0],
        [1.12585803, 1.11790205, 0.0],
        [0.7, 1.6, 0.0],
        [1.3, 0.8, 0.0],
        [0.95, 1.02, 0.0],
        // Small and larger shears, without a mirror line.
        [1.1, 0.9, 1e-6],
        [1.2, 0.8, 0.2],
    ];
    for discretization in methods {
        let method = Method::<2>::new(discretization.clone()).expect("an admissible method");
        let material = ModifiedMooneyRivlin::default();
        let survey = Survey::new(&method, &material).expect("finite");
        for [first, second, shear] in states {
            let f = DeformationGradient::plane_strain([[first, shear], [0.0, second]], 1.0)
                .expect("a positive volume ratio");
            let found = survey.state(&f).expect("enough neighbors").scaled_minimum;
            let grid = of_dense_grid(&method, &f);
            assert!(
                found <= grid + 1e-12 * grid.abs().max(1.0),
                "{found:e} above {grid:e} at {first}, {second}, {shear} of {discretization:?}"
            );
        }
    }
}
