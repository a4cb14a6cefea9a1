//! Stability criteria compared with closed forms and independent computations.

mod boxes;
mod flow;
mod forms;
mod incompressible;
mod jumps;
mod kinks;
mod known;
mod loadings;
mod polyconvexity;

use onset::criteria::{Criterion, Lateral, Loading, LoadingPath, Mode, Range, Track, follow};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, StrainEnergy};
use onset::real::Real;

/// Neo-Hookean energy `W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2`.
struct NeoHooke {
    mu: f64,
    lambda: f64,
}

impl StrainEnergy for NeoHooke {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let i = f.invariants();
        let log = i.jacobian.ln();
        (i.first - 3.0) * (0.5 * self.mu) - log * self.mu + log * log * (0.5 * self.lambda)
    }
}

fn path<'a>(law: &'a dyn Hyperelastic, mode: Mode, lateral: Lateral) -> LoadingPath<'a> {
    let loading = Loading { mode, lateral };
    LoadingPath::new(law, true, loading, &Range::default())
        .expect("a state in the reference configuration")
}

fn track(path: &LoadingPath<'_>, criterion: Criterion, tension: bool) -> Track {
    follow(path, criterion, tension).expect("the criterion is defined")
}

/// Stretch at which a criterion is violated, in tension or in compression.
fn limit(path: &LoadingPath<'_>, criterion: Criterion, tension: bool) -> Option<f64> {
    track(path, criterion, tension).limit()
}

#[track_caller]
fn assert_close(computed: f64, expected: f64, tolerance: f64) {
    assert!(
        (computed - expected).abs() <= tolerance * expected.abs().max(1.0),
        "{computed} is not {expected}"
    );
}

/// Zero of a monotonic function, by bisection.
fn zero(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let rising = function(low) < 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (function(middle) < 0.0) == rising {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
