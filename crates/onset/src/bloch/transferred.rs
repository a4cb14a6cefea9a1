//! Waves of methods that transfer velocities through a grid once per step.

use super::{BlochSum, WaveSystem, ZoneSearch};
use crate::algebra::Complex;
use crate::lattice::Particle;
use nalgebra::SVector;

/// Values of `omega^2` count as zero below this multiple of its rounding error.
pub(crate) const ZERO_FREQUENCY_NOISE_FACTOR: f64 = 64.0;
/// Smallest amplification factor that does not count as zero. A solution that vanishes within a step has no rate.
const SMALLEST_FACTOR: f64 = 1e-12;
/// Growth rate relative to the frequency that exceeds the rounding error of `ln(z)`.
const GROWTH_TOLERANCE: f64 = 1e-10;
/// Largest `|omega^2 dt^2|` for the general formula: beyond it the larger factor equals `-omega^2 dt^2` to all digits, and squares may overflow.
const LARGEST_STEP_SQUARE: f64 = 1e40;

/// Velocities that points receive from the grid in a step.
///
/// `L = 1 - T` is the fraction of the velocities of a wave that is lost in the transfer to the points and back, and `s` the velocity of a wave on the
/// grid before the forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VelocityFilter {
    /// Points keep a fraction of the velocity that the grid does not resolve: `s' = T w + flip L s`.
    Blended {
        /// Fraction of its previous velocity that a point keeps.
        flip: f64,
    },
    /// Points keep the part of their velocity that an approximation of the full mass matrix of order `k` resolves: `s' = T w + (L - L^k) s`.
    Extended {
        /// Order `k` of the approximation, from 1.
        order: u32,
    },
    /// The lumped masses of the nodes are replaced by this approximation, with the inverse `(1 + L + ... + L^(k-1)) / m`: `s' = (1 - L^k) w` for
    /// velocities `s` with this mass.
    FullMass {
        /// Order `k` of the approximation, from 1.
        order: u32,
    },
}

/// Coefficients of a [`VelocityFilter`] at a wave vector.
struct Filtered {
    /// Fraction `1 - T - R` of the velocity that a step removes.
    damped: f64,
    /// Fraction `R` of its previous velocity that a point keeps.
    own: f64,
    /// Ratio of the inverse mass of the nodes to the inverse lumped mass.
    mobility: f64,
}

impl VelocityFilter {
    /// Coefficients for waves that lose the fraction `L` of their velocity.
    fn at(self, lost: f64) -> Filtered {
        let kept = |order: u32| lost.powi(order.try_into().unwrap_or(i32::MAX));
        match self {
            Self::Blended { flip } => Filtered {
                damped: (1.0 - flip) * lost,
                own: flip * lost,
                mobility: 1.0,
            },
            Self::Extended { order } => Filtered {
                damped: kept(order),
                own: lost - kept(order),
                mobility: 1.0,
            },
            Self::FullMass { order } => Filtered {
                damped: kept(order),
                own: 0.0,
                mobility: geometric(lost, order),
            },
        }
    }
}

/// Sum of the geometric series `1 + x + ... + x^(n-1)`.
fn geometric(x: f64, n: u32) -> f64 {
    (0..n).fold(0.0, |sum, _| 1.0 + x * sum)
}

/// Waves of a state in discrete time, for a method that stores velocities at points and accelerates them on a grid.
///
/// The displacements `u` of the nodes and the velocities `s` transferred to them from the points satisfy, step by step,
///
/// `w = s - dt q M^-1 K u`, `u' = u + dt w`, `s' = T w + R s`.
///
/// Here `w` are the velocities after the forces, `T`, `0 <= T(k) <= 1`, is the transfer to the points and back, and `R` is the part of their previous
/// velocities that points keep, `R = flip (1 - T)` or as given by another [`VelocityFilter`]. The factor `q` is 1 for lumped masses `M`. All three
/// are numbers at each wave vector, `T` is 1 at zero. Each `omega^2` of `M^-1 K` therefore has the factors `z` of
///
/// `z^2 - (1 + T + R - q omega^2 dt^2) z + T + R - R q omega^2 dt^2 = 0`.
///
/// There is no such equation in continuous time: over a given physical time shorter steps filter more often, and for `dt -> 0` a wave with
/// `T + R < 1` stops moving. Waves with `omega^2 < 0` grow for any step and any filter. Waves with `omega^2 > 0` stay bounded up to
/// `q omega^2 dt^2 = 2 (1 + T + R) / (1 + R)`. Velocities of points without effect on the grid are multiplied by `flip` or vanish, and positions and
/// deformations without effect on the grid persist, so neither grows.
///
/// Units: `K` force/length, `M` mass, rates 1/time.
///
/// ```
/// use nalgebra::Vector1;
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::method::CurrentLattice;
/// use onset::scheme::{
///     Discretization, Formulation, GridFunctions, MaterialPointChoices, MaterialPoints, Transfer,
/// };
/// let points = MaterialPoints::<1>::new(MaterialPointChoices {
///     functions: GridFunctions::QuadraticSpline,
///     formulation: Formulation::Particles {
///         grid: CurrentLattice::Convected,
///         transfer: Transfer::Blended { flip: 0.0 },
///     },
///     ..MaterialPointChoices::default()
/// })?;
/// let rest = DeformationGradient::identity();
/// let waves = points.transferred(&ModifiedMooneyRivlin::default(), &rest)?;
/// // A point in the middle averages its two nodes: T = cos(k h/2)^2.
/// let lost = waves.map(|waves| waves.lost(&Vector1::new(1.0)));
/// assert!(lost.is_some_and(|lost| (lost - 0.5_f64.sin().powi(2)).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TransferredWaves<const D: usize> {
    /// Equations of motion on the grid, without filter.
    system: WaveSystem<D>,
    /// Transfer `T(k) = sum c cos(k.X)`: vectors between nodes with coefficients `c` that add up to one.
    kept: Vec<(SVector<f64, D>, f64)>,
    filter: VelocityFilter,
    isolated_point: Option<f64>,
}

impl<const D: usize> TransferredWaves<D> {
    /// Creates the waves of a grid with one node per cell.
    ///
    /// The arguments are the equations of motion of nodes that keep their velocities, the transfer `T` between nodes as multiples of the identity,
    /// and the velocities that points receive from the grid.
    pub fn new(system: WaveSystem<D>, kept: &BlochSum<D>, filter: VelocityFilter) -> Self {
        let position = |node: &Particle<D>| system.crystal().position(node);
        let term = |(site, to, block): (usize, &Particle<D>, &nalgebra::SMatrix<f64, D, D>)| {
            (
                position(to) - position(&Particle::home(site)),
                block[(0, 0)],
            )
        };
        Self {
            kept: kept.blocks().map(term).collect(),
            system,
            filter,
            isolated_point: None,
        }
    }

    /// Adds the largest stable step of a point without neighbors.
    #[must_use]
    pub fn with_isolated_point(mut self, step: Option<f64>) -> Self {
        self.isolated_point = step;
        self
    }

    /// Largest stable step of an isolated, unstressed material point; `None` for laws with stress in the reference state. Time.
    ///
    /// Such a point, for example at the edge of a body or among few others, may restrict the step more than all waves do.
    pub fn isolated_point(&self) -> Option<f64> {
        self.isolated_point
    }

    /// Equations of motion on the grid, `M dv/dt = -K u`, without filter.
    pub fn system(&self) -> &WaveSystem<D> {
        &self.system
    }

    /// Ratio of the inverse mass of the nodes in a wave to the inverse of the lumped mass; dimensionless.
    pub fn mobility(&self, k: &SVector<f64, D>) -> f64 {
        self.filter(k).mobility
    }

    /// Ratio of the velocities of the points to the interpolated displacements of the nodes, for the amplification factor `z`; 1/time.
    ///
    /// With `w = (z - 1) u / dt` after the forces and `s = w + dt omega^2 u` before, both for lumped masses, `z v = flip v + w - flip s` for a blend,
    /// `z v = w + (q - 1) s` for XPIC and `z v = w` for FMPM.
    pub fn speed(
        &self,
        k: &SVector<f64, D>,
        omega_squared: Complex,
        z: Complex,
        step: f64,
    ) -> Complex {
        let after = (z - 1.0) / step;
        let before = after + omega_squared * step;
        match self.filter {
            VelocityFilter::Blended { flip } => (after - before * flip) / (z - flip),
            VelocityFilter::Extended { order } => {
                (after + before * (geometric(self.lost(k), order) - 1.0)) / z
            }
            VelocityFilter::FullMass { .. } => after / z,
        }
    }

    /// Fraction `1 - T(k)` of the velocities of a wave that the transfer to the points and back removes in a step; dimensionless.
    pub fn lost(&self, k: &SVector<f64, D>) -> f64 {
        let term = |(vector, share): &(SVector<f64, D>, f64)| {
            let sine = (0.5 * k.dot(vector)).sin();
            2.0 * share * sine * sine
        };
        self.kept.iter().map(term).sum::<f64>().clamp(0.0, 1.0)
    }

    fn filter(&self, k: &SVector<f64, D>) -> Filtered {
        self.filter.at(self.lost(k))
    }

    /// All `omega^2` of a wave vector without filter; values within rounding are set to zero. 1/time^2.
    fn omega_squared(&self, k: &SVector<f64, D>) -> Vec<Complex> {
        let noise = ZERO_FREQUENCY_NOISE_FACTOR * self.system.noise();
        let values = self.system.omega_squared(k).into_iter();
        let told = |value: Complex| match value.norm() <= noise {
            true => Complex::new(0.0, 0.0),
            false => value,
        };
        values.map(told).collect()
    }

    /// Factors of the two solutions of each wave per step, minus one, sorted by the real part of `omega^2`; the larger factor first.
    fn changes(&self, k: &SVector<f64, D>, step: f64) -> Vec<[Complex; 2]> {
        let Filtered {
            damped,
            own,
            mobility,
        } = self.filter(k);
        let of = |omega_squared: Complex| {
            // With z = 1 + c and y^2 = q omega^2 dt^2: c^2 + (1 - T - R + y^2) c + y^2 (1 - R) = 0.
            let square = omega_squared * (mobility * step * step);
            let half = (square + damped) * 0.5;
            let product = square * (1.0 - own);
            let root = match square.norm() > LARGEST_STEP_SQUARE {
                true => half,
                false => (half * half - product).sqrt(),
            };
            // The larger solution has no cancellation, and the other follows from the product.
            let far = match (half.conj() * root).re < 0.0 {
                true => root - half,
                false => -half - root,
            };
            let near = match far.norm() > 0.0 {
                true => product / far,
                false => far,
            };
            let is_first = (near + 1.0).norm() >= (far + 1.0).norm();
            if is_first { [near, far] } else { [far, near] }
        };
        self.omega_squared(k).into_iter().map(of).collect()
    }

    /// Factors of the two solutions of each wave per step, sorted by the real part of `omega^2`; the larger factor first.
    pub fn factors(&self, k: &SVector<f64, D>, step: f64) -> Vec<[Complex; 2]> {
        let changes = self.changes(k, step).into_iter();
        changes
            .map(|pair| pair.map(|change| change + 1.0))
            .collect()
    }

    /// Rates `s = ln(z)/dt` of all solutions `exp(s t)` at whole steps, sorted by the real part of `omega^2`. 1/time.
    ///
    /// The imaginary part is the frequency and the real part the growth rate. Solutions that vanish after one step are omitted.
    pub fn rates(&self, k: &SVector<f64, D>, step: f64) -> Vec<Complex> {
        let changes = self.changes(k, step).into_iter().flatten();
        let lasting = changes.filter(|change| (change + 1.0).norm() > SMALLEST_FACTOR);
        lasting.map(|change| logarithm(change) / step).collect()
    }

    /// Largest stable step for the waves with one wave vector, `sqrt(2 (1 + T + R) / (q (1 + R))) / omega` of the fastest wave. Time.
    ///
    /// Waves that grow for any step are ignored. For a complex `omega^2`, which grows unless the filter damps it, the real part is used. The result
    /// is infinite if nothing oscillates.
    pub fn critical_time_step_at(&self, k: &SVector<f64, D>) -> f64 {
        let filtered = self.filter(k);
        let squares = self.omega_squared(k).into_iter().map(|z| z.re);
        let fastest = filtered.mobility * squares.fold(0.0, f64::max);
        (2.0 * (2.0 - filtered.damped) / ((1.0 + filtered.own) * fastest)).sqrt()
    }

    /// Search over the zone of the nodes.
    fn search(&self) -> ZoneSearch<D> {
        ZoneSearch::of_lattice(*self.system.crystal().lattice(), 1.0)
    }

    /// Largest stable step: the minimum over the zone. Time.
    ///
    /// In an unstable state only the waves that do not grow for every step are considered. The result is infinite if nothing oscillates.
    pub fn critical_time_step(&self) -> f64 {
        let at = |k: &SVector<f64, D>| self.critical_time_step_at(k);
        self.search().least_of(&self.system, &at).0
    }

    /// Rate with the largest real part at a wave vector. Growth within the rounding of `omega^2` is set to zero.
    fn fastest_at(&self, k: &SVector<f64, D>, step: f64) -> Complex {
        let noise = ZERO_FREQUENCY_NOISE_FACTOR * self.system.noise() * self.mobility(k);
        let told = |rate: Complex| {
            // Short steps: `d omega^2 = 2 s ds`. Long steps, whose factor is `omega^2 dt^2`: `ds = d omega^2 / (omega^2 dt)`.
            let change = ((rate * step).exp() - 1.0).norm() / step;
            let rounding = GROWTH_TOLERANCE * rate.norm() + noise / rate.norm().max(change);
            match rate.re > 0.0 && rate.re <= rounding {
                true => Complex::new(0.0, rate.im),
                false => rate,
            }
        };
        let rates = self.rates(k, step).into_iter().map(told);
        let fastest = rates.max_by(|a, b| a.re.total_cmp(&b.re));
        fastest.unwrap_or_default()
    }

    /// Rate with the largest real part over the zone, with its wave vector; zero for stable waves, which include translations. 1/time, 1/length.
    pub fn fastest(&self, step: f64) -> (Complex, SVector<f64, D>) {
        let at = |k: &SVector<f64, D>| -self.fastest_at(k, step).re;
        let (value, k) = self.search().least_of(&self.system, &at);
        match value < 0.0 {
            true => (self.fastest_at(&k, step), k),
            false => (Complex::new(0.0, 0.0), SVector::zeros()),
        }
    }
}

/// Logarithm `ln(1 + c)` without cancellation.
fn logarithm(change: Complex) -> Complex {
    let modulus = match change.norm() > LARGEST_STEP_SQUARE {
        true => change.norm().ln(),
        false => 0.5 * (2.0 * change.re + change.norm_sqr()).ln_1p(),
    };
    Complex::new(modulus, change.im.atan2(1.0 + change.re))
}

#[cfg(test)]
mod tests {
    use super::logarithm;
    use crate::algebra::Complex;

    #[test]
    fn logarithms_of_factors_near_one_keep_their_digits() {
        let change = Complex::new(-1e-12, 3e-9);
        let found = logarithm(change);
        // The expected rate follows from ln(1 + c) = c - c^2/2 + ...
        let expected = change - change * change * 0.5;
        assert!((found - expected).norm() < 1e-24);
        let far = Complex::new(-1.7, 0.4);
        assert!((logarithm(far) - (far + 1.0).ln()).norm() < 1e-14);
    }
}
