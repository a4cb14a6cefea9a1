//! All zero-energy modes, compared with dense Newton searches in a separate implementation, and with the stiffness of three laws.

use crate::hunt::hunted;
use crate::method;
use nalgebra::{DMatrix, SMatrix, SVector};
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind};
use onset::material::{Hyperelastic, Law};
use onset::measures::{Extent, SpuriousModes, spurious_modes};
use onset::scheme::element::{
    ElementChoices, ElementMesh, FiniteElements, Formulation, Integration,
};
use onset::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
use onset::scheme::{
    BondModel, Discretization, Influence, MaterialPointChoices, MaterialPoints, Peridynamics,
    PeridynamicsChoices, ZeroEnergyControl,
};
use onset::verdict::{Survey, Verdict};
use std::f64::consts::TAU;

/// Three laws with stress-free reference states: two with very different Lame constants, and an anisotropic law.
fn laws() -> Vec<Box<dyn Hyperelastic>> {
    let law = |name: &str, parameters: &[(&str, f64)]| {
        let law = Law::named(name).expect("a law of the library");
        law.build(parameters).expect("admissible parameters")
    };
    vec![
        law("saint-venant-kirchhoff", &[("lambda", 1.0), ("mu", 1.0)]),
        law("saint-venant-kirchhoff", &[("lambda", 300.0), ("mu", 0.7)]),
        law("saint-venant-orthotropic", &[]),
    ]
}

/// Shear waves of a fluid have frequency zero; the strains of a discretization show its additional zero-energy modes.
#[test]
fn a_fluid_is_not_stable_where_its_discretization_has_zero_energy_modes() {
    let tait = Law::named("tait").expect("a law of the library");
    let states = [[1.0, 1.0, 1.0], [0.97, 0.99, 1.0]];
    let states = states.map(DeformationGradient::from_stretches);
    let verdicts = |scheme: &dyn Discretization<2>, mu: f64| {
        let law = tait.build(&[("mu", mu)]).expect("admissible parameters");
        let survey = Survey::new(scheme, &*law).expect("a survey");
        states.clone().map(|f| {
            let f = f.expect("a state");
            let searched = survey.state(&f).expect("a verdict").verdict;
            assert_eq!(survey.judge(&f).expect("a verdict").0, searched);
            assert_eq!(survey.assess(&f).expect("a verdict").verdict, searched);
            let survey = Survey::new(scheme, &*law).expect("a survey");
            let many = survey.for_many_states().expect("a survey");
            let [of_map] = many.states(&[f]).try_into().expect("one");
            assert_eq!(of_map.expect("a verdict").verdict, searched);
            searched
        })
    };
    let square = Crystal::of(LatticeKind::Square, 1.0).expect("a crystal");
    let nodal = TotalLagrangianSph::<2>::new(square, TotalLagrangianChoices::default());
    let nodal = nodal.expect("a scheme");
    let whole = FiniteElements::<2>::new(&ElementChoices::default()).expect("elements");
    let kernel = method::<2>(crate::nodal(LatticeKind::Square));
    for mu in [0.0, 1e-9, 0.2] {
        assert_eq!(verdicts(&kernel, mu), [Verdict::ZeroEnergy; 2], "{mu}");
        assert_eq!(verdicts(&nodal, mu), [Verdict::ZeroEnergy; 2], "{mu}");
        assert_eq!(verdicts(&whole, mu), [Verdict::Stable; 2], "{mu}");
    }
}

/// Alternating neighbors lie in one cell if it has an even number of particles along an axis: the wave of the cells is then infinitely long.
#[test]
fn the_verdict_does_not_depend_on_the_number_of_particles_in_a_cell() {
    let tait = Law::named("tait").expect("a law of the library");
    let fluid = tait.build(&[("mu", 0.0)]).expect("admissible parameters");
    let solid = laws().remove(0);
    let scheme = |crystal: Crystal<2>, penalty: f64| {
        let choices = TotalLagrangianChoices {
            penalty,
            ..TotalLagrangianChoices::default()
        };
        TotalLagrangianSph::new(crystal, choices).expect("a method")
    };
    let square = Crystal::of(LatticeKind::Square, 1.0).expect("a crystal");
    for cells in [[1, 1], [2, 1], [2, 2], [3, 1], [4, 1]] {
        let crystal = square.supercell(cells).expect("a supercell");
        for (law, penalty, expected) in [
            (&solid, 0.0, Verdict::ZeroEnergy),
            (&solid, 0.1, Verdict::Stable),
            (&fluid, 0.0, Verdict::ZeroEnergy),
        ] {
            let scheme = scheme(crystal.clone(), penalty);
            let survey = Survey::new(&scheme, &**law).expect("a survey");
            for stretches in [[1.0, 1.0, 1.0], [1.02, 0.99, 1.0]] {
                let f = DeformationGradient::from_stretches(stretches).expect("a state");
                let name = format!("{cells:?} {penalty} {expected:?}");
                assert_eq!(
                    survey.state(&f).expect("a verdict").verdict,
                    expected,
                    "{name}"
                );
                assert_eq!(survey.judge(&f).expect("a verdict").0, expected, "{name}");
                assert_eq!(
                    survey.assess(&f).expect("a verdict").verdict,
                    expected,
                    "{name}"
                );
            }
        }
    }
    // A small strain is not zero, even for a law that is stiff against volume changes.
    let stiff = Law::named("saint-venant-kirchhoff").expect("a law of the library");
    let stiff = stiff.build(&[("lambda", 1e6), ("mu", 1.0)]);
    let stiff = stiff.expect("admissible parameters");
    let disordered = square
        .supercell([2, 2])
        .and_then(|cell| cell.perturbed(0.01, 1));
    let disordered = scheme(disordered.expect("a crystal"), 0.0);
    let survey = Survey::new(&disordered, &*stiff).expect("a survey");
    let rest = DeformationGradient::identity();
    assert_eq!(survey.judge(&rest).expect("a verdict").0, Verdict::Stable);
    for (penalty, expected) in [(0.0, Verdict::ZeroEnergy), (0.003, Verdict::Stable)] {
        let controlled = scheme(square.clone(), penalty);
        let survey = Survey::new(&controlled, &*stiff).expect("a survey");
        assert_eq!(
            survey.judge(&rest).expect("a verdict").0,
            expected,
            "{penalty}"
        );
    }
    // The two particles of a honeycomb cell can move freely relative to each other.
    let honeycomb = Crystal::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
    let scheme = scheme(honeycomb, 0.0);
    let survey = Survey::new(&scheme, &*solid).expect("a survey");
    assert_eq!(
        survey.judge(&rest).expect("a verdict").0,
        Verdict::ZeroEnergy
    );
}

fn found<const D: usize>(
    scheme: &dyn Discretization<D>,
    law: &dyn Hyperelastic,
) -> SpuriousModes<D> {
    let survey = Survey::new(scheme, law).expect("a survey");
    spurious_modes(&survey, 0.1).expect("modes")
}

fn correspondence<const D: usize>(
    lattice: BravaisLattice<D>,
    horizon: f64,
    influence: Influence,
) -> Peridynamics<D> {
    let choices = PeridynamicsChoices {
        horizon,
        influence,
        model: BondModel::Correspondence {
            control: ZeroEnergyControl::None,
        },
        ..PeridynamicsChoices::default()
    };
    Peridynamics::new(Crystal::of_lattice(lattice), choices).expect("peridynamics")
}

fn total_lagrangian<const D: usize>(crystal: Crystal<D>, radius: f64) -> TotalLagrangianSph<D> {
    let choices = TotalLagrangianChoices {
        kernel: Kernel::QuarticSpline,
        radius,
        ..TotalLagrangianChoices::default()
    };
    TotalLagrangianSph::new(crystal, choices).expect("a method")
}

fn lattice<const D: usize>(kind: LatticeKind) -> BravaisLattice<D> {
    kind.lattice(1.0).expect("a lattice")
}

/// Sum `sum_X w(|X|) X sin(k.X)` over half of the neighbors within a radius: the discrete gradient of a particle on a lattice, up to a regular
/// matrix.
struct Gradient<const D: usize> {
    vectors: SMatrix<f64, D, D>,
    terms: Vec<([i32; D], SVector<f64, D>)>,
}

impl<const D: usize> Gradient<D> {
    fn new(vectors: SMatrix<f64, D, D>, radius: f64, weight: impl Fn(f64) -> f64) -> Self {
        let reach = 6_i32;
        let side = (2 * reach + 1) as usize;
        let mut terms = Vec::new();
        for index in 0..side.pow(D as u32) / 2 {
            let mut rest = index;
            let cell: [i32; D] = std::array::from_fn(|_| {
                let n = (rest % side) as i32 - reach;
                rest /= side;
                n
            });
            let x = vectors * SVector::from(cell.map(f64::from));
            if x.norm() <= radius * (1.0 + 1e-9) {
                terms.push((cell, x * weight(x.norm() / radius)));
            }
        }
        Self { vectors, terms }
    }

    fn at(&self, place: &SVector<f64, D>) -> (SVector<f64, D>, SMatrix<f64, D, D>) {
        let (mut value, mut slope) = (SVector::zeros(), SMatrix::zeros());
        for (cell, b) in &self.terms {
            let cell = SVector::<f64, D>::from(cell.map(f64::from));
            let (sine, cosine) = (TAU * cell.dot(place)).sin_cos();
            value += b * sine;
            slope += b * cell.transpose() * (TAU * cosine);
        }
        (value, slope)
    }

    /// Newton's method from one starting point; `None` if it does not converge to a simple root other than zero.
    fn root_from(&self, start: SVector<f64, D>) -> Option<SVector<f64, D>> {
        let scale = self.terms.iter().map(|(_, b)| b.norm()).sum::<f64>();
        let mut place = start;
        for _ in 0..60 {
            let (value, slope) = self.at(&place);
            let slope = DMatrix::from_fn(D, D, |i, j| slope[(i, j)]);
            if value.norm() < 1e-13 * scale {
                let is_simple = slope.singular_values().min() > 1e-4 * scale;
                let is_zero = place.iter().all(|x| (x - x.round()).abs() < 1e-7);
                return (is_simple && !is_zero).then_some(place);
            }
            let step = slope.lu().solve(&DMatrix::from_fn(D, 1, |i, _| value[i]))?;
            let bounded = 0.08 / step.amax().max(0.08);
            place -= SVector::<f64, D>::from_fn(|i, _| step[i] * bounded);
        }
        None
    }

    /// All simple roots reached from a dense grid of starting points, one of each opposite pair.
    fn roots(&self, starts: usize) -> Vec<SVector<f64, D>> {
        let mut roots: Vec<SVector<f64, D>> = Vec::new();
        for index in 0..starts.pow(D as u32) {
            let mut rest = index;
            let start = SVector::from_fn(|i, _| {
                let n = (rest % starts) as f64;
                rest /= starts;
                (n + 0.3 + 0.1 * i as f64) / starts as f64
            });
            if let Some(root) = self.root_from(start)
                && !roots.iter().any(|known| is_same(known, &root))
            {
                roots.push(root);
            }
        }
        roots
    }
}

fn is_same<const D: usize>(a: &SVector<f64, D>, b: &SVector<f64, D>) -> bool {
    let is_zero = |x: SVector<f64, D>| x.iter().all(|x| (x - x.round()).abs() < 1e-6);
    is_zero(a - b) || is_zero(a + b)
}

/// Checks that every root of a dense search is listed exactly once, and nothing else.
fn assert_all<const D: usize>(
    scheme: &dyn Discretization<D>,
    gradient: &Gradient<D>,
    starts: usize,
    name: &str,
) -> usize {
    let law = laws().remove(0);
    let modes = found(scheme, &*law);
    assert!(modes.is_complete, "{name}");
    let listed: Vec<(SVector<f64, D>, Extent)> = modes
        .modes
        .iter()
        .filter(|mode| mode.is_zero())
        .map(|mode| {
            assert_eq!(mode.nullity, D, "{name}");
            let place = gradient.vectors.transpose() * mode.wave_vector / TAU;
            (place, mode.extent)
        })
        .collect();
    let scale = gradient.terms.iter().map(|(_, b)| b.norm()).sum::<f64>();
    for (n, (place, _)) in listed.iter().enumerate() {
        let (value, _) = gradient.at(place);
        assert!(value.norm() < 1e-9 * scale, "{name}: no root at {place:?}");
        let again = listed[..n].iter().any(|(other, _)| is_same(other, place));
        assert!(!again, "{name}: {place:?} is listed twice");
    }
    for root in gradient.roots(starts) {
        let known = listed.iter().any(|(place, _)| is_same(place, &root));
        // A simple root is isolated, and not a point of a line.
        assert!(known, "{name}: {root:?} is missing of {}", listed.len());
    }
    listed.len()
}

/// Quotient `W'(q)/q` of the quartic spline.
fn quartic(q: f64) -> f64 {
    (1.0 - q) * (1.0 - q)
}

#[test]
fn correspondence_families_have_every_zero_energy_mode_of_a_dense_search() {
    for (kind, horizon, expected) in [
        (LatticeKind::Hexagonal, 3.0, 22),
        (LatticeKind::Hexagonal, 2.0, 13),
        (LatticeKind::Square, 3.0, 21),
    ] {
        let lattice = lattice::<2>(kind);
        let gradient = Gradient::new(*lattice.vectors(), horizon, |_| 1.0);
        let scheme = correspondence(lattice, horizon, Influence::Constant);
        let name = format!("{kind:?} {horizon}");
        let count = assert_all(&scheme, &gradient, 40, &name);
        assert_eq!(count, expected, "{name}");
    }
    let lattice = lattice::<3>(LatticeKind::SimpleCubic);
    let gradient = Gradient::new(*lattice.vectors(), 2.0, |_| 1.0);
    let scheme = correspondence(lattice, 2.0, Influence::Constant);
    // The gradient vanishes where sin x (1 + 4 a + 2 b + 2 c + 4 b c) = 0 and its cyclic permutations hold, with the cosines a, b, c. With all sines
    // zero there are 7 wave vectors. With two sines zero there are 9, at a = 3/4 (b c = -1) and a = -1/4 (b = c = -1). With one sine zero
    // there are 12, at a = b = -3/10 (c = 1) and a = b = 1/2 (c = -1). With no sine zero there are 4, at a = b = c = (sqrt(3) - 2)/2.
    // Different a and b require c = 1/2, and the third equation then gives 1/2 and -1 for a and b: no further wave vectors, but these six
    // are triple zeros.
    let count = assert_all(&scheme, &gradient, 18, "simple cubic 2");
    assert_eq!(count, 32);
    let third = lattice.reciprocal() * SVector::from([1.0 / 6.0, 1.0 / 6.0, 0.5]);
    let listed = zeros(&scheme, &*laws()[0]);
    let triple = listed.iter().map(|(k, _)| (k.abs() - third).norm());
    assert!(triple.fold(f64::INFINITY, f64::min) < 1e-9);
}

#[test]
fn total_lagrangian_particles_have_every_zero_energy_mode_of_a_dense_search() {
    for (kind, radius, expected) in [
        (LatticeKind::FaceCenteredCubic, 1.6, 16),
        (LatticeKind::BodyCenteredCubic, 1.6, 12),
        (LatticeKind::SimpleCubic, 1.9, 17),
    ] {
        let lattice = lattice::<3>(kind);
        let gradient = Gradient::new(*lattice.vectors(), radius, quartic);
        let scheme = total_lagrangian(Crystal::of_lattice(lattice), radius);
        let name = format!("{kind:?} {radius}");
        let count = assert_all(&scheme, &gradient, 14, &name);
        assert_eq!(count, expected, "{name}");
    }
}

/// Random numbers between 0 and 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Lattice of cells that are not too flat, with a smallest distance of one.
    fn lattice<const D: usize>(&mut self) -> BravaisLattice<D> {
        loop {
            let vectors = SMatrix::<f64, D, D>::from_fn(|i, j| {
                f64::from(u8::from(i == j)) + 0.6 * (self.next() - 0.5)
            });
            let Some(lattice) = BravaisLattice::new(vectors) else {
                continue;
            };
            let nearest = Crystal::of_lattice(lattice).nearest_distance();
            let volume = lattice.cell_volume() / nearest.powi(D as i32);
            if (0.6..1.5).contains(&volume)
                && let Some(lattice) = BravaisLattice::new(vectors / nearest)
            {
                return lattice;
            }
        }
    }
}

fn a_random_lattice<const D: usize>(random: &mut Random, starts: usize, name: &str) {
    let lattice = random.lattice::<D>();
    let vectors = *lattice.vectors();
    let most = [4.5, 3.2, 2.1][D - 1];
    let radius = 1.5 + (most - 1.5) * random.next();
    let kind = (3.0 * random.next()) as usize;
    let name = format!("{name}: kind {kind}, radius {radius}, {vectors:?}");
    let gradient = |weight: &dyn Fn(f64) -> f64| Gradient::new(vectors, radius, weight);
    // Families of too few particles are refused.
    match kind {
        0 => {
            let gradient = gradient(&|_| 1.0);
            let scheme = correspondence(lattice, radius, Influence::Constant);
            assert_all(&scheme, &gradient, starts, &name);
        }
        1 => {
            let gradient = gradient(&|q| (-4.0 * q * q).exp());
            let scheme = correspondence(lattice, radius, Influence::Gaussian);
            assert_all(&scheme, &gradient, starts, &name);
        }
        _ => {
            let gradient = gradient(&quartic);
            let scheme = total_lagrangian(Crystal::of_lattice(lattice), radius);
            assert_all(&scheme, &gradient, starts, &name);
        }
    }
}

#[test]
fn exactly_the_zero_energy_modes_of_random_lattices_are_listed() {
    let (seed, cases) = hunted(12);
    for case in 0..cases {
        let mut random = Random(seed.wrapping_mul(1_000_003).wrapping_add(case as u64));
        (0..8).for_each(|_| _ = random.next());
        let name = format!("seed {seed}, case {case}");
        match case % 6 {
            0 => a_random_lattice::<1>(&mut random, 60, &name),
            5 => a_random_lattice::<3>(&mut random, 12, &name),
            _ => a_random_lattice::<2>(&mut random, 30, &name),
        }
    }
}

/// All wave vectors of the zone that have zero-energy modes, including the translations at `k = 0`, for a lattice of single particles.
fn all_of_a_lattice<const D: usize>(scheme: &dyn Discretization<D>) -> Vec<SVector<f64, D>> {
    let vectors = *scheme.crystal().lattice().vectors();
    let is_equivalent = |a: &SVector<f64, D>, b: &SVector<f64, D>| {
        let x = vectors.transpose() * (a - b) / TAU;
        x.iter().all(|x| (x - x.round()).abs() < 1e-6)
    };
    let modes = found(scheme, &*laws()[0]);
    assert!(modes.is_complete);
    let mut all = vec![SVector::zeros()];
    for mode in modes.modes.iter().filter(|mode| mode.is_zero()) {
        assert_eq!((mode.nullity, mode.extent), (D, Extent::Point));
        let k = mode.wave_vector;
        all.push(k);
        if !is_equivalent(&k, &-k) {
            all.push(-k);
        }
    }
    all
}

/// Checks that a supercell has the zero-energy modes of the lattice that it repeats, at the wave vectors of its zone.
fn assert_folded<const D: usize>(kind: LatticeKind, radius: f64, cells: [usize; D]) {
    let name = format!("{kind:?} {radius} {cells:?}");
    let single = Crystal::<D>::of(kind, 1.0).expect("a crystal");
    let crystal = single.supercell(cells).expect("a supercell");
    let vectors = *crystal.lattice().vectors();
    let expected = all_of_a_lattice(&total_lagrangian(single, radius));
    let scheme = total_lagrangian(crystal, radius);
    let modes = found(&scheme, &*laws()[0]);
    assert!(modes.is_complete, "{name}");
    let place = |k: &SVector<f64, D>| vectors.transpose() * k / TAU;
    let is_there = |k: &SVector<f64, D>, root: &SVector<f64, D>| {
        let difference = place(&(k - root));
        difference.iter().all(|x| (x - x.round()).abs() < 1e-6)
    };
    let listed: Vec<_> = modes.modes.iter().filter(|mode| mode.is_zero()).collect();
    for mode in &listed {
        let k = &mode.wave_vector;
        let there = expected.iter().filter(|root| is_there(k, root)).count();
        // The translations are not zero-energy modes.
        let translations = if k.norm() == 0.0 { D } else { 0 };
        assert_eq!(mode.nullity, D * there - translations, "{name}: {k:?}");
        let own = |other: &&_| is_there(k, other) || is_there(&-k, other);
        let times = listed.iter().map(|mode| &mode.wave_vector).filter(own);
        assert_eq!(times.count(), 1, "{name}: {k:?}");
    }
    for root in &expected[1..] {
        let is_listed = listed
            .iter()
            .any(|mode| is_there(&mode.wave_vector, root) || is_there(&-mode.wave_vector, root));
        assert!(is_listed, "{name}: {root:?}");
    }
}

#[test]
fn supercells_have_every_zero_energy_mode_of_their_lattice() {
    assert_folded::<1>(LatticeKind::Chain, 3.3, [4]);
    assert_folded(LatticeKind::Square, 2.0, [2, 2]);
    assert_folded(LatticeKind::Square, 2.0, [3, 2]);
    assert_folded(LatticeKind::Hexagonal, 2.0, [2, 2]);
    assert_folded(LatticeKind::Square, 2.6, [3, 3]);
    assert_folded(LatticeKind::Hexagonal, 2.2, [2, 1]);
}

/// Every wave of disordered particles has strain, and the search proves this in the whole zone.
#[test]
fn disordered_particles_have_no_zero_energy_modes() {
    fn assert_none<const D: usize>(
        kind: LatticeKind,
        radius: f64,
        cells: [usize; D],
        amplitude: f64,
    ) {
        let crystal = Crystal::<D>::of(kind, 1.0).and_then(|one| one.supercell(cells));
        let crystal = crystal.and_then(|cell| cell.perturbed(amplitude, 1));
        let scheme = total_lagrangian(crystal.expect("a crystal"), radius);
        let modes = found(&scheme, &*laws()[0]);
        assert!(modes.is_complete, "{kind:?} {radius} {amplitude}");
        assert!(modes.modes.iter().all(|mode| !mode.is_zero()));
    }
    assert_none(LatticeKind::Square, 2.0, [3, 3], 0.2);
    assert_none(LatticeKind::Square, 2.6, [2, 2], 0.02);
    assert_none(LatticeKind::Hexagonal, 2.0, [3, 3], 0.05);
    assert_none(LatticeKind::SimpleCubic, 1.9, [2, 2, 1], 0.1);
}

/// Wave vectors and nullities, in the order of the list.
fn zeros<const D: usize>(
    scheme: &dyn Discretization<D>,
    law: &dyn Hyperelastic,
) -> Vec<(SVector<f64, D>, usize)> {
    let modes = found(scheme, law).modes.into_iter();
    let zeros = modes.filter(|mode| mode.is_zero());
    zeros.map(|mode| (mode.wave_vector, mode.nullity)).collect()
}

fn assert_geometry<const D: usize>(scheme: &dyn Discretization<D>, name: &str) {
    let laws = laws();
    let first = zeros(scheme, &*laws[0]);
    for law in &laws {
        assert_eq!(zeros(scheme, &**law), first, "{name}");
        // The number of zero eigenvalues of the stiffness equals the number of listed modes.
        let waves = scheme
            .waves(&**law, &DeformationGradient::identity())
            .expect("waves");
        let free = |k: &SVector<f64, D>| {
            let values = waves.omega_squared(k);
            let scale = values.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let all = (0..12).map(|n| {
                let place = SVector::repeat(0.1 + 0.07 * f64::from(n));
                waves
                    .omega_squared(&place)
                    .iter()
                    .map(|z| z.norm())
                    .fold(scale, f64::max)
            });
            let scale = all.fold(scale, f64::max);
            values.iter().filter(|z| z.norm() < 1e-10 * scale).count()
        };
        for (k, nullity) in &first {
            let translations = if k.norm() == 0.0 { D } else { 0 };
            assert_eq!(free(k), nullity + translations, "{name} at {k:?}");
        }
        let beside = SVector::<f64, D>::from_fn(|i, _| 1.234 + 0.777 * i as f64);
        assert_eq!(free(&beside), 0, "{name}");
    }
}

#[test]
fn zero_energy_modes_do_not_depend_on_the_law() {
    let square = lattice::<2>(LatticeKind::Square);
    let family = correspondence(square, 3.0, Influence::Constant);
    assert_geometry(&family, "correspondence on squares");
    let cubic = lattice::<3>(LatticeKind::SimpleCubic);
    assert_geometry(
        &total_lagrangian(Crystal::of_lattice(cubic), 1.9),
        "total-Lagrangian particles on cubes",
    );
    let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
    let choices = TotalLagrangianChoices {
        radius: 1.9,
        ..TotalLagrangianChoices::default()
    };
    let honeycomb = TotalLagrangianSph::new(honeycomb, choices).expect("a method");
    assert_geometry(&honeycomb, "honeycomb");
}

fn one_point<const D: usize>(mesh: ElementMesh, hourglass_stiffness: f64) -> FiniteElements<D> {
    let formulation = Formulation {
        integration: Integration::OnePoint,
        hourglass_stiffness,
        ..Formulation::default()
    };
    let choices = ElementChoices {
        mesh,
        formulation,
        ..ElementChoices::default()
    };
    FiniteElements::new(&choices).expect("elements")
}

#[test]
fn points_lines_and_the_whole_zone_are_distinguished() {
    let law = laws().remove(0);
    // Squares with one point have the hourglass mode: B = (s_x c_y, c_x s_y) with the sines s and cosines c of half the phases.
    let squares = found(&one_point::<2>(ElementMesh::Quadrilaterals, 0.0), &*law);
    assert_eq!(squares.zero_extent, Some(Extent::Point));
    assert_eq!(squares.modes.iter().filter(|m| m.is_zero()).count(), 1);
    // For bricks B = (s_x c_y c_z, ...) vanishes where two cosines vanish: along the edges of the cube, which are connected.
    let bricks = found(&one_point::<3>(ElementMesh::Bricks, 0.0), &*law);
    assert_eq!(bricks.zero_extent, Some(Extent::Line));
    assert!(bricks.is_complete);
    let zeros: Vec<_> = bricks.modes.iter().filter(|m| m.is_zero()).collect();
    assert_eq!(zeros.len(), 1, "{zeros:?}");
    assert_eq!((zeros[0].extent, zeros[0].nullity), (Extent::Line, 3));
    // The reported wave vector, the shortest on these lines, is the midpoint of an edge of the zone.
    let mut place = zeros[0].wave_vector.map(|k| k.abs() / TAU);
    place.as_mut_slice().sort_by(f64::total_cmp);
    assert!(
        (place - SVector::from([0.0, 0.5, 0.5])).amax() < 1e-9,
        "{place}"
    );
    // The two velocities of a node cannot follow all motions of four points in a cell: most of these do not move the grid, at every wave vector.
    let choices = MaterialPointChoices {
        per_side: 2,
        formulation: onset::scheme::Formulation::Particles {
            grid: onset::method::CurrentLattice::Convected,
            transfer: onset::scheme::Transfer::Continuous,
        },
        ..MaterialPointChoices::default()
    };
    let points = MaterialPoints::<2>::new(choices).expect("points");
    let points = found(&points, &*law);
    assert_eq!(points.zero_extent, Some(Extent::Zone));
    assert_eq!(points.modes[0].nullity, 6);
    assert_eq!(points.weakest, Some(0.0));
}

#[test]
fn controls_leave_no_zero_energy_modes() {
    let law = laws().remove(0);
    for stiffness in [1e-9, 1.0] {
        let bricks = found(&one_point::<3>(ElementMesh::Bricks, stiffness), &*law);
        assert_eq!(bricks.zero_extent, None);
        assert!(bricks.modes.iter().all(|mode| !mode.is_zero()));
        assert!(bricks.weakest > Some(0.0));
    }
    let hexagonal = Crystal::of_lattice(lattice::<2>(LatticeKind::Hexagonal));
    for control in [
        ZeroEnergyControl::Penalty { coefficient: 0.01 },
        ZeroEnergyControl::Hourglass { coefficient: 0.01 },
    ] {
        let choices = PeridynamicsChoices {
            model: BondModel::Correspondence { control },
            ..PeridynamicsChoices::default()
        };
        let scheme = Peridynamics::new(hexagonal.clone(), choices).expect("peridynamics");
        let modes = found(&scheme, &*law);
        assert_eq!(modes.zero_extent, None, "{control:?}");
        assert!(modes.is_complete);
    }
}

/// Checks the zero-energy modes of a lattice whose strains vanish on crossing lines, with the length of their shortest wave in units of `TAU` divided
/// by the edge of the cube.
fn assert_crossing_lines(scheme: &dyn Discretization<3>, edge: f64, points: usize, shortest: f64) {
    let zeros = found(scheme, &*laws().remove(0)).modes;
    let zeros: Vec<_> = zeros.iter().filter(|mode| mode.is_zero()).collect();
    let of = |extent| zeros.iter().filter(move |mode| mode.extent == extent);
    assert_eq!(of(Extent::Point).count(), points, "{zeros:?}");
    assert_eq!(of(Extent::Line).count(), 1, "{zeros:?}");
    assert_eq!(zeros.len(), points + 1, "{zeros:?}");
    for line in of(Extent::Line) {
        let length = line.wave.norm() * edge / TAU;
        assert!((length - shortest).abs() < 1e-8, "{length}");
    }
}

/// Nearest neighbors of face-centered cubes satisfy `s_x (c_y + c_z) = 0` and cyclic permutations, with `s` and `c` of half the phases. In addition
/// to L the solutions are the lines X-W-X, with the shortest wave at X.
#[test]
fn crossing_lines_are_one_connected_set_and_not_a_surface() {
    let edge = 2.0_f64.sqrt();
    let faces = Crystal::of(LatticeKind::FaceCenteredCubic, 1.0).expect("a crystal");
    assert_crossing_lines(&total_lagrangian(faces, 1.2), edge, 4, 1.0);
    // Body-centered cubes: `s_x (c_y c_z + c_x) = 0` and cyclic. In addition to P these are the lines H-N-H, which all meet at H.
    let bodies = lattice::<3>(LatticeKind::BodyCenteredCubic);
    let edge = 2.0 / 3.0_f64.sqrt();
    let family = correspondence(bodies, 1.2, Influence::Constant);
    assert_crossing_lines(&family, edge, 1, 0.5_f64.sqrt());
}

/// The half vectors of two by two by two face-centered cells with nearest neighbors are seven wave vectors with three modes each. Translations are
/// not zero-energy modes.
#[test]
fn translations_are_not_zero_energy_modes_where_lines_cross_in_the_reference_configuration() {
    let faces = Crystal::<3>::of(LatticeKind::FaceCenteredCubic, 1.0).expect("a crystal");
    let half = faces.lattice().reciprocal() * 0.5;
    let eight = faces.supercell([2; 3]).expect("a supercell");
    let modes = found(&total_lagrangian(eight, 1.2), &*laws().remove(0)).modes;
    let at_rest: Vec<_> = modes
        .iter()
        .filter(|mode| mode.wave_vector.norm() == 0.0)
        .collect();
    assert_eq!(at_rest.len(), 1, "{at_rest:?}");
    assert_eq!(at_rest[0].nullity, 21);
    // The shortest of the seven are L, half the shortest reciprocal vectors.
    let shortest = half
        .column_iter()
        .map(|k| k.norm())
        .fold(f64::INFINITY, f64::min);
    assert!((at_rest[0].wave.norm() - shortest).abs() < 1e-9);
}
