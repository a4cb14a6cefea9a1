//! The search over the zone against dense grids.

use crate::choices::{Case, case, config};
use nalgebra::Vector2;
use onset::bloch::{dynamical_matrix, growth_rate};
use onset::lattice::BrillouinZone;
use onset::verdict::zone_search;
use proptest::prelude::*;
use std::cell::Cell;

const GRID: i32 = 60;

/// All reference wave vectors of a grid over the zone, but zero.
fn grid(case: &Case) -> Vec<Vector2<f64>> {
    let method = case.method();
    let home = method.home_map(&case.state);
    let zone = BrillouinZone::new(method.lattice().mapped(&home).expect("a lattice"));
    let mut waves = Vec::new();
    for i in 0..GRID {
        for j in 0..GRID {
            // Shifted from the search's own grid, whose points need not be seen here again.
            let fractional = Vector2::new(f64::from(i) + 0.37, f64::from(j) + 0.61) / f64::from(GRID);
            waves.push(home.transpose() * zone.folded(&zone.wave_vector(&fractional)));
        }
    }
    waves
}

proptest! {
    #![proptest_config(config(150))]
    #[test]
    fn no_wave_of_a_dense_grid_is_beyond_the_summary(case in case()) {
        let (method, material) = (case.method(), case.material());
        let d = dynamical_matrix(&method, &*material, &case.state).expect("finite");
        let search = zone_search(&method, &*material, &case.state).expect("finite");
        let summary = search.summary(&d);
        let speed_squared = onset::verdict::speed_squared(&method, &*material).expect("finite");
        let (mut scaled, mut lowest, mut highest, mut growth) = (f64::INFINITY, 0.0_f64, 0.0_f64, 0.0_f64);
        for k in grid(&case) {
            let [first, second] = d.omega_squared(&k);
            scaled = scaled.min(first.re / (speed_squared * method.lattice().laplacian(&k)));
            lowest = lowest.min(first.re);
            highest = highest.max(second.re);
            growth = growth.max(growth_rate(first)).max(growth_rate(second));
        }
        let margin = 1e-9;
        prop_assert!(summary.softest.scaled <= scaled + margin * scaled.abs().max(1.0),
            "scaled {} above {}", summary.softest.scaled, scaled);
        // Where none is below zero, the translation stands for the lowest mode.
        prop_assert!(lowest >= -margin * highest || summary.lowest.omega_squared.re <= lowest + margin * highest,
            "omega^2 {} above {}", summary.lowest.omega_squared.re, lowest);
        prop_assert!(summary.maximum_omega.powi(2) >= highest * (1.0 - margin),
            "maximum {} below {}", summary.maximum_omega.powi(2), highest);
        let (stability, measure) = search.stability(&d);
        prop_assert_eq!(stability, summary.stability(), "both answers agree: measure {}", measure);
        if growth * growth > 1e-6 * highest {
            prop_assert!(!summary.is_stable(), "a wave grows at the rate {growth}");
        }
        prop_assert!(summary.growth_rate() >= growth * (1.0 - 1e-6) - 1e-3 * highest.sqrt(),
            "growth rate {} below {}", summary.growth_rate(), growth);
        // What it names is a mode: D g = omega^2 g, with the measure that it states.
        for mode in [summary.lowest, summary.fastest_growing].iter().chain(
            std::iter::once(&summary.softest).filter(|mode| !mode.is_long_wave),
        ) {
            let residual = d.at(&mode.wave_vector) * mode.polarization - mode.polarization * mode.omega_squared;
            let size = residual.iter().map(|x| x.norm()).fold(0.0, f64::max);
            prop_assert!(size < 1e-7 * highest, "residual {size:e} of {mode:?}");
        }
    }
}

#[test]
fn the_summary_is_reached_and_not_only_bounded() {
    // A summary below every grid would be no witness: the softest wave has the measure that it states.
    let seen = Cell::new(0);
    let mut runner = proptest::test_runner::TestRunner::new(config(40));
    runner
        .run(&case(), |case| {
            let (method, material) = (case.method(), case.material());
            let d = dynamical_matrix(&method, &*material, &case.state).expect("finite");
            let softest = zone_search(&method, &*material, &case.state).expect("finite").summary(&d).softest;
            let speed_squared = onset::verdict::speed_squared(&method, &*material).expect("finite");
            let (k, length) =
                if softest.is_long_wave { (softest.wave_vector * 1e-4, 1e-4) } else { (softest.wave_vector, 1.0) };
            let scaled = d.omega_squared(&k)[0].re / (speed_squared * method.lattice().laplacian(&k));
            prop_assert!((scaled - softest.scaled).abs() < 1e-6 * softest.scaled.abs().max(1.0) + 1e-3 * (1.0 - length));
            seen.set(seen.get() + usize::from(!softest.is_long_wave));
            Ok(())
        })
        .expect("all cases pass");
    assert!(seen.get() > 5, "waves of finite length are among the softest");
}
