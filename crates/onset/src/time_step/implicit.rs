//! Implicit integrators: steps with a positive definite matrix of Newton's method, and long steps that mask growth.

use crate::algebra::{Complex, any_eigenvalues, array_of};
use nalgebra::DMatrix;

/// Implicit integrators, each with one choice of its parameters.
///
/// Newmark's and the two alpha methods belong to the generalized-alpha family (Chung, Hulbert, J. Appl. Mech. 60 (1993) 371):
/// `(1 - alpha_m) a' + alpha_m a + omega^2 ((1 - alpha_f) u' + alpha_f u) = 0` with Newmark's `u' = u + dt v + dt^2 ((1/2 - beta) a + beta a')` and
/// `v' = v + dt ((1 - gamma) a + gamma a')`.
///
/// ```
/// use onset::time_step::ImplicitIntegrator;
/// // Newton's matrix K + 4 M/dt^2 of the trapezoidal rule, at a state with omega^2 = -1.
/// assert_eq!(ImplicitIntegrator::Newmark.largest_definite_step(-1.0), 2.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImplicitIntegrator {
    /// Newmark's method with `beta = 1/4`, `gamma = 1/2` (trapezoidal rule, average acceleration).
    Newmark,
    /// Method of Hilber, Hughes and Taylor with `alpha = -0.05`, the transient fidelity of Abaqus.
    HhtAlpha,
    /// Generalized-alpha method with the spectral radius 1/2 for infinitely fast oscillations.
    GeneralizedAlpha,
    /// Backward Euler: `u' = u + dt v'`, `v' = v - dt omega^2 u'`.
    BackwardEuler,
}

/// Parameters of the generalized-alpha family.
struct Parameters {
    alpha_m: f64,
    alpha_f: f64,
    beta: f64,
    gamma: f64,
}

impl Parameters {
    /// Parameters with second order and the largest numerical damping of fast oscillations for these two.
    fn of_second_order(alpha_m: f64, alpha_f: f64) -> Self {
        let gamma = 0.5 - alpha_m + alpha_f;
        Self {
            alpha_m,
            alpha_f,
            beta: 0.25 * (0.5 + gamma).powi(2),
            gamma,
        }
    }
}

impl ImplicitIntegrator {
    /// All implicit integrators, in the order of tables.
    pub const ALL: [Self; 4] = [
        Self::Newmark,
        Self::HhtAlpha,
        Self::GeneralizedAlpha,
        Self::BackwardEuler,
    ];

    /// Names of the integrators, in the order of [`ImplicitIntegrator::ALL`].
    pub const NAMES: [&str; 4] = [
        "newmark",
        "hht-alpha",
        "generalized-alpha",
        "backward-euler",
    ];

    /// Returns the implicit integrator with the given name, or `None`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.name() == name)
    }

    /// Name of the integrator in text and JSON.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Parameters of the generalized-alpha family; `None` for backward Euler.
    fn parameters(self) -> Option<Parameters> {
        match self {
            Self::Newmark => Some(Parameters::of_second_order(0.0, 0.0)),
            Self::HhtAlpha => Some(Parameters::of_second_order(0.0, 0.05)),
            Self::GeneralizedAlpha => Some(Parameters::of_second_order(0.0, 1.0 / 3.0)),
            Self::BackwardEuler => None,
        }
    }

    /// Number `c` of Newton's matrix `K + c M/dt^2`, up to a factor.
    fn inertia(self) -> f64 {
        self.parameters().map_or(1.0, |own| {
            (1.0 - own.alpha_m) / (own.beta * (1.0 - own.alpha_f))
        })
    }

    /// Amplification factors `z` of a step for an undamped oscillation with `omega dt = phase`; two or three.
    pub fn factors(self, phase: f64) -> Vec<Complex> {
        let w = phase * phase;
        // The state is (u, dt v, dt^2 a).
        let matrix = match self.parameters() {
            None => {
                let share = (1.0 + w).recip();
                DMatrix::from_row_slice(2, 2, &[share, share, -w * share, share])
            }
            Some(own) => {
                let elastic = w * (1.0 - own.alpha_f);
                let inverse = (1.0 - own.alpha_m + elastic * own.beta).recip();
                let later = [
                    -w * inverse,
                    -elastic * inverse,
                    -(own.alpha_m + elastic * (0.5 - own.beta)) * inverse,
                ];
                let row = |first: [f64; 3], share: f64| array_of(|i| first[i] + share * later[i]);
                let rows: [[f64; 3]; 3] = [
                    row([1.0, 1.0, 0.5 - own.beta], own.beta),
                    row([0.0, 1.0, 1.0 - own.gamma], own.gamma),
                    later,
                ];
                DMatrix::from_row_slice(3, 3, &rows.concat())
            }
        };
        let factors = any_eigenvalues(&matrix.map(Complex::from));
        factors.map_or_else(Vec::new, |own| own.to_vec())
    }

    /// Spectral radius of a step for an undamped oscillation with `omega dt = phase`; the oscillation is damped numerically if it is below 1.
    ///
    /// ```
    /// use onset::time_step::ImplicitIntegrator;
    /// assert!((ImplicitIntegrator::Newmark.spectral_radius(3.0) - 1.0).abs() < 1e-12);
    /// assert!((ImplicitIntegrator::GeneralizedAlpha.spectral_radius(1e4) - 0.5).abs() < 1e-2);
    /// ```
    pub fn spectral_radius(self, phase: f64) -> f64 {
        let sizes = self.factors(phase).into_iter().map(|z| z.norm());
        sizes.fold(0.0, f64::max)
    }

    /// Spectral radius for oscillations that are infinitely fast compared with the step, `max(alpha_f / (1 - alpha_f), |1 - (gamma + 1/2) / (2 beta)|)`.
    ///
    /// ```
    /// use onset::time_step::ImplicitIntegrator;
    /// assert!((ImplicitIntegrator::GeneralizedAlpha.spectral_radius_at_infinity() - 0.5).abs() < 1e-12);
    /// ```
    pub fn spectral_radius_at_infinity(self) -> f64 {
        self.parameters().map_or(0.0, |own| {
            let of_displacements = own.alpha_f / (1.0 - own.alpha_f);
            of_displacements.max((1.0 - (own.gamma + 0.5) / (2.0 * own.beta)).abs())
        })
    }

    /// Relative error of the period of an undamped oscillation with `omega dt = phase`, positive if the period is too long.
    ///
    /// ```
    /// use onset::time_step::ImplicitIntegrator;
    /// // The trapezoidal rule advances the phase by 2 atan(omega dt / 2).
    /// let error = ImplicitIntegrator::Newmark.period_error(0.3);
    /// assert!((error - (0.3 / (2.0 * 0.15_f64.atan()) - 1.0)).abs() < 1e-12);
    /// ```
    pub fn period_error(self, phase: f64) -> f64 {
        // The oscillation is the complex pair; a third factor is real up to rounding.
        let factors = self.factors(phase).into_iter();
        let pair = factors.max_by(|a, b| a.im.total_cmp(&b.im));
        phase / pair.map_or(0.0, |z| z.arg()) - 1.0
    }

    /// Largest step for which Newton's matrix of a state with a given lowest `omega^2` (1/time^2) is positive definite, `sqrt(c / -omega^2)`. Time.
    ///
    /// It is infinite if no `omega^2` is negative. Static solvers have no mass term, so that their matrix is positive definite only in this case.
    pub fn largest_definite_step(self, lowest_omega_squared: f64) -> f64 {
        match lowest_omega_squared < 0.0 {
            true => (self.inertia() / -lowest_omega_squared).sqrt(),
            false => f64::INFINITY,
        }
    }

    /// Largest step for which a solution that grows at a rate `s` (1/time) also grows in discrete time. Time; infinite if it grows for every step.
    ///
    /// At this step the amplification factor is -1. For backward Euler, `(1 - s dt)^-1`, it is `2/s`.
    pub fn largest_growing_step(self, growth_rate: f64) -> f64 {
        let squared = self.parameters().map_or(4.0, |own| {
            let damping = own.gamma - 0.5;
            // Equals the condition u' = -u, v' = -v, a' = -a, with gamma - 2 beta = -(gamma - 1/2)^2 / 2.
            4.0 * (1.0 - 2.0 * own.alpha_m) / ((1.0 - 2.0 * own.alpha_f) * damping * damping)
        });
        match growth_rate > 0.0 {
            true => squared.sqrt() / growth_rate,
            false => f64::INFINITY,
        }
    }
}
