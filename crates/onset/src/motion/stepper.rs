//! Integrators, and compositions of several of their steps.

use crate::algebra::Complex;
use crate::time_step::{Amplification, Integrator};
use nalgebra::{DMatrix, Matrix2};

/// First five of the nine steps of Kahan and Li's symmetric composition of order six, `s9odr6a`; the other four steps mirror them.
///
/// Source: Kahan, Li, Math. Comp. 66 (1997) 1089.
const SIXTH: [f64; 5] = [
    0.392_161_444_007_314_1,
    0.332_599_136_789_359_44,
    -0.706_246_172_557_639_4,
    0.082_213_596_293_550_8,
    0.798_543_990_934_829_9,
];

/// Time stepping method: an [`Integrator`], or a composition of several of its steps.
///
/// ```
/// use onset::motion::Stepper;
/// assert_eq!(Stepper::named("velocity-verlet"), Some(Stepper::KICK_DRIFT_KICK));
/// assert!((Stepper::KICK_DRIFT_KICK.bound() - 2.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stepper {
    integrator: Integrator,
    is_composed: bool,
}

impl Stepper {
    /// Velocity Verlet scheme, kick-drift-kick.
    pub const KICK_DRIFT_KICK: Self = Self::of(Integrator::KickDriftKick);
    /// Nine steps of velocity Verlet, some of them backward in time, with an error of order six in the step. For undamped systems only, because
    /// damping amplifies in backward steps.
    pub const SIXTH_ORDER: Self = Self {
        integrator: Integrator::KickDriftKick,
        is_composed: true,
    };
    /// Returns the stepper of a single integrator.
    pub const fn of(integrator: Integrator) -> Self {
        Self {
            integrator,
            is_composed: false,
        }
    }

    /// Returns the stepper with the given name, or `None`. Integrators may have a second common name.
    pub fn named(name: &str) -> Option<Self> {
        match name == Self::SIXTH_ORDER.name() {
            true => Some(Self::SIXTH_ORDER),
            false => Integrator::named(name).map(Self::of),
        }
    }

    /// Names of all steppers.
    pub fn names() -> Vec<&'static str> {
        let integrators = Integrator::NAMES.into_iter();
        integrators.chain([Self::SIXTH_ORDER.name()]).collect()
    }

    /// Name in study files and on the command line.
    pub fn name(self) -> &'static str {
        match self.is_composed {
            true => "sixth-order",
            false => self.integrator.name(),
        }
    }

    /// Integrator used for each step.
    pub fn integrator(self) -> Integrator {
        self.integrator
    }

    /// Returns true if some substeps go backward in time. Such an integrator amplifies damped motions and accepts only forces without damping.
    pub fn goes_back(self) -> bool {
        self.is_composed
    }

    /// Returns the lengths of the substeps as fractions of the step. They sum to one; some may be negative.
    pub fn parts(self) -> impl Iterator<Item = f64> {
        let all: &'static [f64] = match self.is_composed {
            true => &SIXTH,
            false => &[1.0],
        };
        all.iter().chain(all[..all.len() - 1].iter().rev()).copied()
    }

    /// Returns the amplification matrix `G(dt)` of a wave, `(u, v)' = G (u, v)`; shape `2 n x 2 n`.
    pub fn matrix(self, wave: &Amplification, step: f64) -> DMatrix<Complex> {
        let mut parts = self.parts();
        let first = wave.matrix(self.integrator, parts.next().unwrap_or(1.0) * step);
        parts.fold(first, |done, part| {
            wave.matrix(self.integrator, part * step) * done
        })
    }

    /// Largest `omega dt` at which an undamped oscillation stays bounded.
    pub fn bound(self) -> f64 {
        if !self.is_composed {
            return self.integrator.undamped_reach();
        }
        // For u'' = -u, half the trace of a step is the cosine of its phase change.
        let half_trace = |step: f64| {
            let part = |part: f64| {
                let (dt, half) = (part * step, 0.5 * part * step);
                let kick = Matrix2::new(1.0, 0.0, -half, 1.0);
                kick * Matrix2::new(1.0, dt, 0.0, 1.0) * kick
            };
            let one = Matrix2::identity();
            0.5 * self
                .parts()
                .map(part)
                .fold(one, |all, own| own * all)
                .trace()
        };
        let is_stable = |step: f64| half_trace(step).abs() <= 1.0 + 1e-12;
        let (mut low, mut high) = (0.0, 0.0);
        while is_stable(high) {
            low = high;
            high += 1e-3;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match is_stable(middle) {
                true => low = middle,
                false => high = middle,
            }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::Stepper;

    #[test]
    fn the_sixth_order_composition_satisfies_the_order_conditions() {
        // Sums of odd powers; Yoshida, Phys. Lett. A 150 (1990) 262.
        let parts: Vec<f64> = Stepper::SIXTH_ORDER.parts().collect();
        assert_eq!(parts.len(), 9);
        let power = |n: i32| parts.iter().map(|part| part.powi(n)).sum::<f64>();
        assert!((power(1) - 1.0).abs() < 1e-14);
        assert!(power(3).abs() < 1e-14, "{}", power(3));
        assert!(power(5).abs() < 1e-14, "{}", power(5));
    }

    #[test]
    fn the_error_of_the_sixth_order_composition_scales_with_the_sixth_power_of_the_step() {
        // Nonlinear pendulum u'' = -sin u, for about one period.
        let run = |steps: u32| {
            let dt = 6.0 / f64::from(steps);
            let (mut u, mut v) = (1.0_f64, 0.0_f64);
            for _ in 0..steps {
                for part in Stepper::SIXTH_ORDER.parts() {
                    let (h, half) = (part * dt, 0.5 * part * dt);
                    v -= half * u.sin();
                    u += h * v;
                    v -= half * u.sin();
                }
            }
            u
        };
        let exact = run(960);
        let (coarse, fine) = ((run(20) - exact).abs(), (run(40) - exact).abs());
        let order = (coarse / fine).log2();
        assert!(
            (5.6..6.6).contains(&order),
            "order {order}: {coarse} {fine}"
        );
    }
}
