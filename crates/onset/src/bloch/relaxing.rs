//! Plane waves of a state whose material relaxes.

use super::{WaveSystem, ZoneSearch};
use crate::algebra::{Complex, any_eigenvalues, hermitian_eigenvalues};
use crate::material::PronyTerm;
use nalgebra::{DMatrix, SVector};

/// Relative accuracy of growth rates.
const RATE_ACCURACY: f64 = 1e-12;
/// Number of decades below the growth rate of the relaxed state in which the rate is searched for; slower growth counts as zero.
const DECADES: i32 = 24;
/// Number of halvings of an interval of rates.
const HALVINGS: usize = 60;

/// Waves of a relaxed state, `u_K = g exp(i k.X_K + s t)` with
///
/// `(s^2 M + s C + K + sum_i (g_i K_d + k_i K_m) s tau_i / (1 + s tau_i)) g = 0`.
///
/// `K` is the stiffness with the tangent of the long-term law; `K_d` and `K_m` are the contributions of the tangents of overstress
/// ([`Viscoelastic`](crate::material::Viscoelastic)). Units: `K` force/length, `M` mass, `C` force/velocity, rates 1/time.
pub struct RelaxingWaves<const D: usize> {
    relaxed: WaveSystem<D>,
    /// Equations with the relaxed stress and the tangents `A + B_d` and `A + B_m`.
    stiffened: [WaveSystem<D>; 2],
    terms: Vec<PronyTerm>,
}

/// Matrices of one wave vector.
struct Parts {
    mass: DMatrix<Complex>,
    damping: Option<DMatrix<Complex>>,
    relaxed: DMatrix<Complex>,
    /// Stiffness of each term.
    terms: Vec<DMatrix<Complex>>,
}

impl<const D: usize> RelaxingWaves<D> {
    /// Creates the waves from the equations with the relaxed tangent, and with the tangents of all deviatoric and all mean overstress added.
    pub fn new(
        relaxed: WaveSystem<D>,
        stiffened: [WaveSystem<D>; 2],
        terms: Vec<PronyTerm>,
    ) -> Self {
        Self {
            relaxed,
            stiffened,
            terms,
        }
    }

    fn is_hermitian(&self) -> bool {
        let mut all = std::iter::once(&self.relaxed).chain(&self.stiffened);
        let damping = self.relaxed.damping();
        all.all(WaveSystem::is_hermitian) && damping.is_none_or(|own| own.is_hermitian())
    }

    fn parts(&self, k: &SVector<f64, D>) -> Parts {
        let relaxed = self.relaxed.moved_stiffness_at(k);
        let own = self
            .stiffened
            .each_ref()
            .map(|system| system.moved_stiffness_at(k) - &relaxed);
        let term = |term: &PronyTerm| {
            &own[0] * Complex::from(term.shear) + &own[1] * Complex::from(term.bulk)
        };
        Parts {
            mass: self.relaxed.mass_at(k),
            damping: self.relaxed.damping().map(|damping| damping.at(k)),
            terms: self.terms.iter().map(term).collect(),
            relaxed,
        }
    }

    /// All rates `s` of a wave vector, largest real part first. 1/time.
    ///
    /// The imaginary part is the frequency, the real part the growth rate. With `N` terms there are `2 + N` rates for each degree of freedom; the
    /// rates of overstress that a wave does not excite are `-1/tau`.
    pub fn rates(&self, k: &SVector<f64, D>) -> Vec<Complex> {
        let parts = self.parts(k);
        let (n, count) = (parts.relaxed.nrows(), self.terms.len());
        let nan = || DMatrix::repeat(n, n, Complex::new(f64::NAN, f64::NAN));
        let inverse = parts.mass.try_inverse().unwrap_or_else(nan);
        let sizes = std::iter::once(&parts.relaxed).chain(&parts.terms);
        let own: Vec<DMatrix<Complex>> = sizes.map(|stiffness| &inverse * stiffness).collect();
        let entries = own.iter().flat_map(|matrix| matrix.iter());
        let norm = entries.map(|z| z.norm()).fold(0.0, f64::max);
        let unit = if norm > 0.0 { norm.sqrt() } else { 1.0 };
        // `u' = v`, `v' = -D u - C v - sum D_i w_i`, `w_i' = v - w_i / tau_i`, with velocities in units of a typical frequency. If velocities
        // are smoothed, `u` is the integral of the velocities before smoothing.
        let mut matrix = DMatrix::zeros((2 + count) * n, (2 + count) * n);
        let one = DMatrix::<Complex>::identity(n, n);
        let mut put = |row: usize, column: usize, block: DMatrix<Complex>| {
            matrix
                .view_mut((row * n, column * n), (n, n))
                .copy_from(&block);
        };
        put(0, 1, one.clone());
        put(1, 0, &own[0] * Complex::from(-1.0 / (unit * unit)));
        if let Some(damping) = &parts.damping {
            put(1, 1, &inverse * damping * Complex::from(-1.0 / unit));
        }
        for (i, (term, stiffness)) in self.terms.iter().zip(&own[1..]).enumerate() {
            put(1, 2 + i, stiffness * Complex::from(-1.0 / (unit * unit)));
            put(2 + i, 1, one.clone());
            put(
                2 + i,
                2 + i,
                &one * Complex::from(-1.0 / (term.time * unit)),
            );
        }
        let values = any_eigenvalues(&matrix).unwrap_or_default().into_iter();
        let mut values: Vec<Complex> = values.map(|value| value * unit).collect();
        values.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
        values
    }

    /// Largest growth rate of a wave vector; zero if no wave grows. 1/time.
    ///
    /// If the forces derive from an energy, the smallest eigenvalue of the matrix of the waves is followed in `s`, which is accurate for relaxation that is
    /// many orders slower than the waves.
    pub fn growth_at(&self, k: &SVector<f64, D>) -> f64 {
        if !self.is_hermitian() || self.relaxed.drift().is_some() {
            let noise = self.relaxed.noise().sqrt();
            let fastest = self.rates(k).first().map_or(0.0, |rate| rate.re);
            return if fastest > noise { fastest } else { 0.0 };
        }
        let parts = self.parts(k);
        let least = |s: f64| {
            let mut matrix = parts.relaxed.clone();
            for (term, stiffness) in self.terms.iter().zip(&parts.terms) {
                let lag = s * term.time;
                matrix += stiffness * Complex::from(lag / (1.0 + lag));
            }
            if let Some(damping) = &parts.damping {
                matrix += damping * Complex::from(s);
            }
            matrix += &parts.mass * Complex::from(s * s);
            let values = hermitian_eigenvalues(matrix);
            values.iter().map(|z| z.re).fold(f64::INFINITY, f64::min)
        };
        let at_rest = least(0.0);
        let rounding = f64::EPSILON * self.relaxed.stiffness().magnitude();
        if at_rest >= -rounding || at_rest.is_nan() {
            return 0.0;
        }
        let masses = hermitian_eigenvalues(parts.mass.clone());
        let lightest = masses.iter().map(|z| z.re).fold(f64::INFINITY, f64::min);
        let mut high = (-at_rest / lightest).sqrt();
        // Overstress can have a negative stiffness.
        while least(high) < 0.0 && high.is_finite() {
            high *= 2.0;
        }
        let decades = (1..=DECADES).map(|n| high * 0.1_f64.powi(n));
        let Some(mut low) = decades.into_iter().find(|s| least(*s) < 0.0) else {
            return 0.0;
        };
        high = high.min(10.0 * low);
        for _ in 0..HALVINGS {
            if high - low <= RATE_ACCURACY * high {
                break;
            }
            let middle = 0.5 * (low + high);
            match least(middle) < 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        low
    }

    /// Largest growth rate over the zone with its wave vector; zero if no wave grows. 1/time, 1/length.
    pub fn fastest(&self) -> (f64, SVector<f64, D>) {
        let search = ZoneSearch::of_lattice(*self.relaxed.crystal().lattice(), 1.0);
        let at = |k: &SVector<f64, D>| -self.growth_at(k);
        let (value, k) = search.least_of(&self.relaxed, &at);
        match value < 0.0 {
            true => (-value, k),
            false => (0.0, SVector::zeros()),
        }
    }
}
