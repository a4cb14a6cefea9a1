//! Waves of methods whose velocities go through a grid once a step.

use super::zone::least_over_zone;
use crate::algebra::Complex;
use crate::bloch::{BlochSum, IsEnded, WaveSystem};
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

    /// The largest stable step: the least over the zone. Of a state that is unstable itself it is that of the waves that do not grow
    /// with any step. Infinite where nothing oscillates. Time. Given up as soon as nobody waits for it any more.
    pub fn critical_time_step_unless(&self, is_ended: IsEnded<'_>) -> f64 {
        let reciprocal = self.system.crystal().lattice().reciprocal();
        let at = |place: &SVector<f64, D>| self.critical_time_step_at(&(reciprocal * place));
        least_over_zone(at, is_ended).0
    }

    /// The same.
    pub fn critical_time_step(&self) -> f64 {
        self.critical_time_step_unless(&|| false)
    }

    /// The rate with the largest real part over the zone with its wave vector; of stable waves, which include translations, it is zero. 1/time, 1/length.
    pub fn fastest_unless(&self, step: f64, is_ended: IsEnded<'_>) -> (Complex, SVector<f64, D>) {
        let reciprocal = self.system.crystal().lattice().reciprocal();
        let growth = |k: &SVector<f64, D>| {
            let rates = self.rates(k, step).into_iter();
            rates.max_by(|a, b| a.re.total_cmp(&b.re))
        };
        let at = |place: &SVector<f64, D>| {
            let rate = growth(&(reciprocal * place));
            rate.map_or(0.0, |rate| -rate.re)
        };
        let (_, place) = least_over_zone(at, is_ended);
        let k = reciprocal * place;
        let rate = growth(&k).filter(|rate| rate.re > OUTSIDE * rate.norm());
        match rate {
            Some(rate) => (rate, k),
            None => (Complex::new(0.0, 0.0), SVector::zeros()),
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
    use super::{TransferredWaves, logarithm};
    use crate::algebra::Complex;
    use crate::bloch::{BlochBlocks, Mass, WaveSystem};
    use crate::lattice::{Crystal, LatticeKind, Particle};
    use nalgebra::{Matrix2, SMatrix, SVector};
    use std::f64::consts::PI;

    /// A chain of unit masses and springs whose velocities are averaged with those of the neighbors.
    fn chain(share: f64, flip: f64) -> TransferredWaves<1> {
        let lattice = LatticeKind::Chain.lattice::<1>(1.0).expect("a lattice");
        let crystal = Crystal::of_lattice(lattice);
        let home = Particle::home(0);
        let number = SMatrix::<f64, 1, 1>::from_element;
        let (mut stiffness, mut kept) = (BlochBlocks::new(), BlochBlocks::new());
        for (cell, spring, part) in [
            (0, 2.0, 1.0 - 2.0 * share),
            (1, -1.0, share),
            (-1, -1.0, share),
        ] {
            stiffness.add(&home, &home.moved(&[cell]), &number(spring));
            kept.add(&home, &home.moved(&[cell]), &number(part));
        }
        let kept = kept.sum(&crystal);
        let stiffness = stiffness.sum(&crystal);
        let system = WaveSystem::new(crystal, stiffness, Mass::Lumped(vec![1.0]));
        TransferredWaves::new(system, &kept, flip)
    }

    #[test]
    fn factors_are_the_eigenvalues_of_a_step_written_out() {
        for (share, flip, k, dt) in [
            (0.1, 0.0, 1.1, 0.4),
            (0.2, 1.0, 2.9, 0.7),
            (0.15, 0.95, PI, 1.3),
        ] {
            let waves = chain(share, flip);
            let square = 2.0 - 2.0 * f64::cos(k);
            let t = 1.0 - 2.0 * share * (1.0 - f64::cos(k));
            let r = flip * (1.0 - t);
            // (u, s)' from u' = u + dt w, s' = T w + R s, w = s - dt omega^2 u.
            let [w_u, w_s] = [-dt * square, 1.0];
            let step = Matrix2::new(1.0 + dt * w_u, dt * w_s, t * w_u, t * w_s + r);
            let expected = step.complex_eigenvalues();
            let found = waves.factors(&SVector::from([k]), dt)[0];
            for z in expected.iter() {
                let apart = |own: &Complex| (own - z).norm();
                assert!(found.iter().map(apart).fold(1.0, f64::min) < 1e-13);
            }
        }
    }

    #[test]
    fn a_wave_at_rest_neither_grows_nor_decays_and_a_translation_is_neutral() {
        for flip in [0.0, 0.5, 1.0] {
            let waves = chain(0.2, flip);
            let factors = waves.factors(&SVector::zeros(), 0.3);
            assert_eq!(factors[0].map(|z| (z.re, z.im)), [(1.0, 0.0); 2]);
        }
    }

    #[test]
    fn the_largest_stable_step_is_where_the_spectral_radius_leaves_one() {
        for (share, flip) in [(0.2, 0.0), (0.2, 1.0), (0.24, 0.9), (0.05, 0.0)] {
            let waves = chain(share, flip);
            let step = waves.critical_time_step();
            let radius = |step: f64| {
                let of = |n: u32| {
                    let k = SVector::from([PI * f64::from(n) / 200.0]);
                    waves.factors(&k, step)[0][0].norm()
                };
                (0..=200).map(of).fold(0.0, f64::max)
            };
            assert!(radius(step * (1.0 - 1e-6)) < 1.0 + 1e-12);
            assert!(radius(step * (1.0 + 1e-4)) > 1.0 + 1e-6);
            // Scanned from below nothing is lost before.
            for n in 1..50 {
                assert!(radius(step * f64::from(n) / 50.0) < 1.0 + 1e-12);
            }
            assert_eq!(waves.fastest(0.9 * step).0, Complex::new(0.0, 0.0));
            assert!(waves.fastest(1.1 * step).0.re > 0.0);
        }
    }

    #[test]
    fn growth_is_told_of_short_and_of_long_steps() {
        // A spring that pushes: omega^2 = -4 at the edge of the zone, where half of the velocities is kept.
        let mut waves = chain(0.125, 1.0);
        let home = Particle::home(0);
        let mut stiffness = BlochBlocks::new();
        for (cell, spring) in [(0, -2.0), (1, 1.0), (-1, 1.0)] {
            let spring = SMatrix::<f64, 1, 1>::from_element(spring);
            stiffness.add(&home, &home.moved(&[cell]), &spring);
        }
        let crystal = waves.system.crystal().clone();
        let stiffness = stiffness.sum(&crystal);
        waves.system = WaveSystem::new(crystal, stiffness, Mass::Lumped(vec![1.0]));
        // With all of their own velocities points move by a share T of those of the grid: T |omega^2| is left in short steps.
        for step in [1e-14, 1e-10, 1e-6] {
            let growth = waves.fastest(step).0.re;
            assert!((growth - 2.0_f64.sqrt()).abs() < 1e-5, "{step}: {growth}");
        }
        for step in [1e10, 1e30, 1e100] {
            // z = omega^2 dt^2 (1 - R/z ...): the larger factor alone grows.
            let growth = waves.fastest(step).0.re * step;
            let expected = 2.0 * (2.0 * step).ln();
            assert!(
                (growth / expected - 1.0).abs() < 1e-2,
                "{step}: {growth} {expected}"
            );
        }
    }

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
