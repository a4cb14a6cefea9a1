//! Waves of methods whose velocities go through a grid once a step.

use crate::algebra::Complex;
use crate::bloch::{BlochSum, IsEnded, WaveSystem, ZoneSearch};
use crate::lattice::Particle;
use nalgebra::SVector;

/// `omega^2` below so many times its rounding is zero.
const ROUNDING: f64 = 64.0;
/// Factors of a step below this are zero: what does not outlast a step has no rate.
const VANISHED: f64 = 1e-12;
/// A wave grows when its rate does so by more than this share of its frequency: beyond the rounding of `ln(z)`.
const OUTSIDE: f64 = 1e-10;
/// `|omega^2 dt^2|` beyond which the larger factor is `-omega^2 dt^2` to all digits, and squares leave the range of numbers.
const LONG: f64 = 1e40;

/// The waves of a state in discrete time, of a method that carries velocities on points and accelerates them on a grid.
///
/// Displacements `u` of the nodes and the velocities `s` that points have brought to them obey, step by step,
///
/// `w = s - dt M^-1 K u`, `u' = u + dt w`, `s' = T w + R s`,
///
/// with the velocities `w` after the forces, what the way to the points and back keeps of them, `0 <= T(k) <= 1`, and what points keep of
/// their own velocities, `R = flip (1 - T)`. `T` is a number at each wave vector, 1 at zero. So each `omega^2` of `M^-1 K` has the factors `z` of
///
/// `z^2 - (1 + T + R - omega^2 dt^2) z + T + R - R omega^2 dt^2 = 0`.
///
/// There is no such equation in continuous time: at the same physical time shorter steps filter more often, and as `dt -> 0` a wave with `T + R < 1`
/// comes to rest. Waves with `omega^2 < 0` grow with any step and any filter; those with `omega^2 > 0` stay bounded up to `omega^2 dt^2 = 2 (1 + T + R) / (1 + R)`. What
/// the grid does not see of the velocities of points is multiplied with `flip`, and what it does not see of positions and deformations stays: neither grows.
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
/// // A point in the middle sees the two nodes beside it alike: T = cos(k h/2)^2.
/// let lost = waves.map(|waves| waves.lost(&Vector1::new(1.0)));
/// assert!(lost.is_some_and(|lost| (lost - 0.5_f64.sin().powi(2)).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TransferredWaves<const D: usize> {
    /// The equations on the grid, without filter.
    system: WaveSystem<D>,
    /// `T(k) = sum c cos(k.X)`: vectors between nodes with `c`, which add up to one.
    kept: Vec<(SVector<f64, D>, f64)>,
    flip: f64,
    isolated_point: Option<f64>,
}

impl<const D: usize> TransferredWaves<D> {
    /// Waves of a grid with one node in a cell: the equations of motion of nodes that keep their velocities, `T` between nodes as multiples of
    /// the identity, and the share of its own velocity that a point keeps.
    pub fn new(system: WaveSystem<D>, kept: &BlochSum<D>, flip: f64) -> Self {
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
            flip,
            isolated_point: None,
        }
    }

    /// The same with the largest stable step of a point that has no neighbors.
    #[must_use]
    pub fn with_isolated_point(mut self, step: Option<f64>) -> Self {
        self.isolated_point = step;
        self
    }

    /// The largest stable step of an isolated, unstressed material point: such a point, as at the rim of a body or among few others, may bound the
    /// step more than all waves do. `None` of laws with stress in the reference state. Time.
    pub fn isolated_point(&self) -> Option<f64> {
        self.isolated_point
    }

    /// The equations of motion on the grid, `M dv/dt = -K u`, without filter.
    pub fn system(&self) -> &WaveSystem<D> {
        &self.system
    }

    /// The share of its own velocity that a point keeps in a step.
    pub fn flip(&self) -> f64 {
        self.flip
    }

    /// What a step takes of the velocities of a wave on the way to the points and back, `1 - T(k)`; dimensionless.
    pub fn lost(&self, k: &SVector<f64, D>) -> f64 {
        let term = |(vector, share): &(SVector<f64, D>, f64)| {
            let sine = (0.5 * k.dot(vector)).sin();
            2.0 * share * sine * sine
        };
        self.kept.iter().map(term).sum::<f64>().clamp(0.0, 1.0)
    }

    /// `1 - T - R` and `R`.
    fn filter(&self, k: &SVector<f64, D>) -> (f64, f64) {
        let lost = self.lost(k);
        ((1.0 - self.flip) * lost, self.flip * lost)
    }

    /// All `omega^2` of a wave vector without filter; those that are rounding are zero. 1/time^2.
    fn omega_squared(&self, k: &SVector<f64, D>) -> Vec<Complex> {
        let noise = ROUNDING * self.system.noise();
        let values = self.system.omega_squared(k).into_iter();
        let told = |value: Complex| match value.norm() <= noise {
            true => Complex::new(0.0, 0.0),
            false => value,
        };
        values.map(told).collect()
    }

    /// What a step multiplies the two solutions of each wave with, less one, by increasing real part of `omega^2`; the larger factor first.
    fn changes(&self, k: &SVector<f64, D>, step: f64) -> Vec<[Complex; 2]> {
        let (damped, own) = self.filter(k);
        let of = |omega_squared: Complex| {
            // With z = 1 + c: c^2 + (1 - T - R + y^2) c + y^2 (1 - R) = 0.
            let square = omega_squared * (step * step);
            let half = (square + damped) * 0.5;
            let product = square * (1.0 - own);
            let root = match square.norm() > LONG {
                true => half,
                false => (half * half - product).sqrt(),
            };
            // The larger one has no cancellation; the other follows from the product.
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

    /// What a step multiplies the two solutions of each wave with, by increasing real part of `omega^2`; the larger factor first.
    pub fn factors(&self, k: &SVector<f64, D>, step: f64) -> Vec<[Complex; 2]> {
        let changes = self.changes(k, step).into_iter();
        changes
            .map(|pair| pair.map(|change| change + 1.0))
            .collect()
    }

    /// The rates `s = ln(z)/dt` of all solutions `exp(s t)` at whole steps, by increasing real part of `omega^2`; the imaginary part is the frequency, the
    /// real one the growth. Solutions that vanish after one step are left out. 1/time.
    pub fn rates(&self, k: &SVector<f64, D>, step: f64) -> Vec<Complex> {
        let changes = self.changes(k, step).into_iter().flatten();
        let lasting = changes.filter(|change| (change + 1.0).norm() > VANISHED);
        lasting.map(|change| logarithm(change) / step).collect()
    }

    /// The largest stable step for the waves with one wave vector, `sqrt(2 (1 + T + R) / (1 + R)) / omega` of the fastest. Those that grow with any step
    /// bound none; of a complex `omega^2`, which grows unless the filter holds it, the real part counts. Infinite where nothing oscillates. Time.
    pub fn critical_time_step_at(&self, k: &SVector<f64, D>) -> f64 {
        let (damped, own) = self.filter(k);
        let squares = self.omega_squared(k).into_iter().map(|z| z.re);
        let fastest = squares.fold(0.0, f64::max);
        (2.0 * (2.0 - damped) / ((1.0 + own) * fastest)).sqrt()
    }

    /// The search over the zone of the nodes.
    fn search(&self) -> ZoneSearch<D> {
        ZoneSearch::of_lattice(*self.system.crystal().lattice(), 1.0)
    }

    /// The largest stable step: the least over the zone. Of a state that is unstable itself it is that of the waves that do not grow
    /// with any step. Infinite where nothing oscillates. Time. Given up as soon as nobody waits for it any more.
    pub fn critical_time_step_unless(&self, is_ended: IsEnded<'_>) -> f64 {
        let at = |k: &SVector<f64, D>| self.critical_time_step_at(k);
        self.search().least_of(&self.system, &at, is_ended).0
    }

    /// The same.
    pub fn critical_time_step(&self) -> f64 {
        self.critical_time_step_unless(&|| false)
    }

    /// The rate with the largest real part at a wave vector; growth that rounding of `omega^2` can make is none.
    fn fastest_at(&self, k: &SVector<f64, D>, step: f64) -> Complex {
        let noise = ROUNDING * self.system.noise();
        let told = |rate: Complex| {
            // `d omega^2 = 2 s ds` of short steps, `ds = d omega^2 / (omega^2 dt)` of long ones, whose factor is `omega^2 dt^2`.
            let change = ((rate * step).exp() - 1.0).norm() / step;
            let rounding = OUTSIDE * rate.norm() + noise / rate.norm().max(change);
            match rate.re > 0.0 && rate.re <= rounding {
                true => Complex::new(0.0, rate.im),
                false => rate,
            }
        };
        let rates = self.rates(k, step).into_iter().map(told);
        let fastest = rates.max_by(|a, b| a.re.total_cmp(&b.re));
        fastest.unwrap_or_default()
    }

    /// The rate with the largest real part over the zone with its wave vector; of stable waves, which include translations, it is zero. 1/time, 1/length.
    pub fn fastest_unless(&self, step: f64, is_ended: IsEnded<'_>) -> (Complex, SVector<f64, D>) {
        let at = |k: &SVector<f64, D>| -self.fastest_at(k, step).re;
        let (value, k) = self.search().least_of(&self.system, &at, is_ended);
        match value < 0.0 {
            true => (self.fastest_at(&k, step), k),
            false => (Complex::new(0.0, 0.0), SVector::zeros()),
        }
    }

    /// The same.
    pub fn fastest(&self, step: f64) -> (Complex, SVector<f64, D>) {
        self.fastest_unless(step, &|| false)
    }
}

/// `ln(1 + c)` without cancellation.
fn logarithm(change: Complex) -> Complex {
    let modulus = match change.norm() > LONG {
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
        // ln(1 + c) = c - c^2/2 + ...
        let expected = change - change * change * 0.5;
        assert!((found - expected).norm() < 1e-24);
        let far = Complex::new(-1.7, 0.4);
        assert!((logarithm(far) - (far + 1.0).ln()).norm() < 1e-14);
    }
}
