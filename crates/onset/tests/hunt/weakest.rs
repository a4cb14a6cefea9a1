//! Weakest wave, compared with a dense search over the closed zone.

use crate::dense::Waves;
use crate::hunt::seeds;
use crate::methods::{Drawn, material, method};
use crate::random::Random;
use nalgebra::{DMatrix, SMatrix, SVector};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::lattice::BravaisLattice;
use onset::scheme::Discretization;
use onset::verdict::Survey;

/// Number of grid points along a reciprocal vector, and number of the deepest points from which descents start.
const POINTS: [usize; 3] = [400, 72, 16];
const STARTS: usize = 8;
/// Largest difference of relative frequencies that count as equal.
const DIFFERENCE: f64 = 1e-5;
/// Largest length of the wave vector of a long wave, in units of the reciprocal vectors.
const LONG: f64 = 2e-3;

/// Seeds of methods with a narrow well near the minimum of a kink.
const MENDED: &[u64] = &[50_000_131, 50_001_072];

#[test]
fn no_wave_of_any_method_is_weaker_than_the_reported_weakest_wave() {
    let seeds = seeds(24, MENDED);
    let (mut compared, mut wrong) = (0, Vec::new());
    for seed in &seeds {
        let mut random = Random::new(*seed);
        let complaint = match random.one_of(&[1, 2, 2, 2, 3]) {
            1 => checked::<1>(&mut random),
            2 => checked::<2>(&mut random),
            _ => checked::<3>(&mut random),
        };
        let Some(complaint) = complaint else { continue };
        compared += 1;
        if !complaint.is_empty() {
            eprintln!("seed {seed}: {complaint}");
            wrong.push(complaint);
        }
    }
    eprintln!(
        "{compared} of {} compared, {} complaints",
        seeds.len(),
        wrong.len()
    );
    assert!(wrong.is_empty(), "{} complaints", wrong.len());
    assert!(5 * compared > seeds.len(), "{compared} of {}", seeds.len());
}

/// Relative frequency from the spectrum of the particles and the acoustic tensor.
struct Relative<'a, const D: usize> {
    waves: &'a Waves<D>,
    stiffness: Stiffness<D>,
    density: f64,
    images: Vec<SVector<f64, D>>,
}

impl<const D: usize> Relative<'_, D> {
    /// Shortest equivalent wave vectors: one of them, and all others of equal length.
    fn shortest(&self, k: &SVector<f64, D>) -> Vec<SVector<f64, D>> {
        let all: Vec<SVector<f64, D>> = self.images.iter().map(|g| k + g).collect();
        let least = all.iter().map(|k| k.norm()).fold(f64::INFINITY, f64::min);
        let is_as_long = |k: &SVector<f64, D>| k.norm() <= least * (1.0 + 1e-7);
        all.into_iter().filter(is_as_long).collect()
    }

    fn material(&self, k: &SVector<f64, D>) -> f64 {
        let tensor = self.stiffness.acoustic_tensor(k) / self.density;
        let values = DMatrix::from_fn(D, D, |i, j| tensor[(i, j)]).symmetric_eigenvalues();
        let (least, most) = (values.min(), values.max());
        if least > 1e-12 * most { least } else { 0.0 }
    }

    fn at(&self, k: &SVector<f64, D>) -> f64 {
        let exact = self.shortest(k).into_iter().map(|k| self.material(&k));
        let exact = exact.fold(0.0, f64::max);
        let found = self.waves.omega_squared(k).into_iter().map(|z| z.re);
        let found = found.fold(f64::INFINITY, f64::min);
        match exact > 0.0 && found.is_finite() {
            true => (found / exact).clamp(0.0, 1.0).sqrt(),
            false => f64::INFINITY,
        }
    }

    /// Lowest relative frequency on a grid, from descents, and at the middles of reciprocal vectors.
    fn least(&self) -> (f64, SVector<f64, D>) {
        let lattice = self.waves.lattice;
        let points = POINTS[D - 1];
        let is_long = |k: &SVector<f64, D>| {
            let x = lattice.vectors().transpose() * k / std::f64::consts::TAU;
            x.map(|x| x - x.round()).amax() < LONG
        };
        let at = |k: &SVector<f64, D>| match is_long(k) {
            true => f64::INFINITY,
            false => self.at(k),
        };
        let place = |mut index: usize, count: usize, shift: f64| {
            let fractional = SVector::<f64, D>::from_fn(|_, _| {
                let n = index % count;
                index /= count;
                (n as f64 + shift) / count as f64
            });
            lattice.reciprocal() * fractional
        };
        let grid = (0..points.pow(D as u32)).map(|n| place(n, points, 0.37));
        let middles = (1..2_usize.pow(D as u32)).map(|n| place(n, 2, 0.0));
        let mut all: Vec<(f64, SVector<f64, D>)> =
            grid.chain(middles).map(|k| (at(&k), k)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let steps = lattice.reciprocal() / points as f64;
        let ends = all
            .iter()
            .take(STARTS)
            .map(|start| descended(&at, *start, &steps));
        ends.fold((f64::INFINITY, SVector::zeros()), |best, end| {
            if end.0 < best.0 { end } else { best }
        })
    }
}

/// Descent along the reciprocal vectors and their diagonals with shrinking steps.
fn descended<const D: usize>(
    at: &impl Fn(&SVector<f64, D>) -> f64,
    (mut value, mut k): (f64, SVector<f64, D>),
    steps: &SMatrix<f64, D, D>,
) -> (f64, SVector<f64, D>) {
    let mut size = 1.0;
    while size > 1e-5 {
        let around = (0..3_usize.pow(D as u32)).map(|mut number| {
            let weights = SVector::<f64, D>::from_fn(|_, _| {
                let digit = number % 3;
                number /= 3;
                digit as f64 - 1.0
            });
            k + steps * weights * size
        });
        let best = around
            .map(|k| (at(&k), k))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match best.filter(|best| best.0 < value) {
            Some(best) => (value, k) = best,
            None => size *= 0.5,
        }
    }
    (value, k)
}

fn reciprocals<const D: usize>(lattice: &BravaisLattice<D>) -> Vec<SVector<f64, D>> {
    let all = (0..5_usize.pow(D as u32)).map(|mut number| {
        SVector::<f64, D>::from_fn(|_, _| {
            let digit = number % 5;
            number /= 5;
            digit as f64 - 2.0
        })
    });
    all.map(|x| lattice.reciprocal() * x).collect()
}

/// Failure of the weakest wave of a random method; `None` if there is no failure or nothing is compared.
fn checked<const D: usize>(random: &mut Random) -> Option<String> {
    let (law, material) = material(random);
    let (name, drawn) = method::<D>(random)?;
    let scheme: &dyn Discretization<D> = match &drawn {
        Drawn::Kernel(method) => &**method,
        Drawn::Scheme(scheme) => &**scheme,
    };
    if scheme.crystal().sites().len() > 1 {
        return None;
    }
    let survey = Survey::new(scheme, &*material).ok()?;
    let waves = Waves::of_system(survey.reference().ok()?);
    let relative = Relative {
        stiffness: Stiffness::at(&*material, &DeformationGradient::identity()).ok()?,
        density: scheme.density(),
        images: reciprocals(&waves.lattice),
        waves: &waves,
    };
    let (least, lowest) = relative.least();
    let Some(weakest) = survey.weakest() else {
        return Some(match least < 1.0 - DIFFERENCE {
            true => format!("no weakest wave, but one with {least} at {lowest:?}: {law}: {name}"),
            false => String::new(),
        });
    };
    let told = weakest.relative_frequency();
    let there = relative.at(&weakest.wave_vector);
    Some(if told > least + DIFFERENCE {
        format!(
            "weakest {told} at {:?}, but one has {least} at {lowest:?}: {law}: {name}",
            weakest.wave_vector
        )
    } else if (told - there).abs() > DIFFERENCE && told > DIFFERENCE && there.is_finite() {
        format!(
            "weakest {told} has {there} at {:?}: {law}: {name}",
            weakest.wave_vector
        )
    } else {
        String::new()
    })
}
