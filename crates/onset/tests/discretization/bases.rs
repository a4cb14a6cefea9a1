//! Results are independent of the lattice basis and of the units.

use crate::hunt::hunted;
use crate::random::Random;
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector};
use onset::bloch::SpectrumSummary;
use onset::kinematics::DeformationGradient;
use onset::lattice::{Crystal, LatticeKind};
use onset::material::{FourthOrder, Hyperelastic, MaterialError, ModifiedMooneyRivlin, Response};
use onset::method::{Frame, KernelMethodChoices, Method, MethodError, SupportSize};
use onset::quadrature::Quadrature;
use onset::scheme::Discretization;
use onset::scheme::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};
use onset::scheme::sph::{UpdatedSph, UpdatedSphChoices};
use onset::verdict::{Assessment, Survey, Verdict, assess, judge};

/// Integer matrix of determinant one and its inverse: a product of shears.
fn unimodular<const D: usize>(random: &mut Random) -> [SMatrix<f64, D, D>; 2] {
    let mut integer = |bound: f64| (random.number() * (bound + 0.5)).round();
    let (mut product, mut inverse) = (SMatrix::identity(), SMatrix::identity());
    for step in 0..2 * D {
        let (i, j) = (step % D, (step + 1 + step / D % 2) % D);
        if i == j {
            continue;
        }
        let multiple = integer(if step == 0 { 40.0 } else { 4.0 });
        let mut shear = SMatrix::<f64, D, D>::identity();
        shear[(j, i)] = multiple;
        product *= shear;
        shear[(j, i)] = -multiple;
        inverse = shear * inverse;
    }
    [product, inverse]
}

fn close(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 1e-6 * scale.max(a.abs())
}

fn assert_same_spectrum<const D: usize>(
    a: &SpectrumSummary<D>,
    b: &SpectrumSummary<D>,
    context: &str,
) {
    let fastest = a.maximum_omega;
    assert!(close(a.maximum_omega, b.maximum_omega, 0.0), "{context}");
    let lowest = [a, b].map(|s| s.lowest.omega_squared.re);
    assert!(
        close(lowest[0], lowest[1], fastest.powi(2)),
        "{context} {lowest:?}"
    );
    // Squares are compared, because a growth rate is the square root of a number that can be close to rounding.
    let rates = [a, b].map(|s| s.growth_rate().powi(2));
    assert!(
        close(rates[0], rates[1], fastest.powi(2)),
        "{context} {rates:?}"
    );
}

fn assert_same<const D: usize>(a: &Assessment<D>, b: &Assessment<D>, context: &str) {
    assert_eq!(a.verdict, b.verdict, "{context}");
    assert_same_spectrum(&a.spectrum, &b.spectrum, context);
    let softest = [a, b].map(|s| s.spectrum.softest.scaled);
    assert!(close(softest[0], softest[1], 1.0), "{context} {softest:?}");
    let long = [a, b].map(|s| s.spectrum.long_wave.scaled);
    assert!(close(long[0], long[1], 1.0), "{context} {long:?}");
}

fn flattened<const D: usize>(vectors: &SMatrix<f64, D, D>) -> Vec<f64> {
    vectors.iter().copied().collect()
}

fn described<const D: usize>(
    vectors: &SMatrix<f64, D, D>,
    choices: &KernelMethodChoices,
) -> Result<Method<D>, MethodError> {
    Method::new(KernelMethodChoices {
        lattice: if D == 2 {
            LatticeKind::Oblique
        } else {
            LatticeKind::Triclinic
        },
        vectors: flattened(vectors),
        ..choices.clone()
    })
}

#[test]
fn results_do_not_depend_on_the_basis_of_a_planar_lattice() {
    let (seed, cases) = hunted(60);
    let mut random = Random::new(seed);
    let law = ModifiedMooneyRivlin::default();
    let hexagonal = LatticeKind::Hexagonal.lattice::<2>(1.0).expect("a lattice");
    for case in 0..cases {
        let vectors = match case % 3 {
            0 => *hexagonal.vectors(),
            1 => Matrix2::identity(),
            _ => Matrix2::new(1.0, 0.4 * random.number(), 0.0, 1.0 + 0.3 * random.number()),
        };
        let choices = KernelMethodChoices {
            frame: if case % 2 == 0 {
                Frame::Eulerian
            } else {
                Frame::Lagrangian
            },
            quadrature: [
                Quadrature::Nodal,
                Quadrature::StressPoints,
                Quadrature::Gauss,
            ][case / 2 % 3],
            support: 1.9 + 0.4 * random.number(),
            ..KernelMethodChoices::default()
        };
        let [change, _] = unimodular::<2>(&mut random);
        let mut stretch = || 1.0 + 0.15 * random.number();
        let f = DeformationGradient::plane_strain([[stretch(), 0.1], [0.0, stretch()]], 1.0)
            .expect("a state");
        let context = format!("case {case} of seed {seed}: {vectors} {change} {choices:?} {f:?}");
        let answer = |vectors: Matrix2<f64>| assess(&described(&vectors, &choices)?, &law, &f);
        match (answer(vectors), answer(vectors * change)) {
            (Ok(a), Ok(b)) => assert_same(&a, &b, &context),
            (Err(_), Err(_)) => {}
            (a, b) => panic!("{context}: {:?} {:?}", a.err(), b.err()),
        }
    }
}

#[test]
fn results_do_not_depend_on_the_basis_of_a_lattice_in_3d_with_two_particles_per_cell() {
    let mut random = Random::new(4);
    let law = ModifiedMooneyRivlin::default();
    let vectors = Matrix3::new(1.0, 0.2, 0.1, 0.0, 1.1, 0.3, 0.0, 0.0, 0.95);
    let second = SVector::<f64, 3>::new(0.45, 0.55, 0.5);
    let f = DeformationGradient::from_stretches([1.05, 0.97, 1.0]).expect("a state");
    let answer = |change: Matrix3<f64>, inverse: Matrix3<f64>| {
        let choices = KernelMethodChoices {
            lattice: LatticeKind::Triclinic,
            vectors: flattened(&(vectors * change)),
            basis: (inverse * second).iter().copied().collect(),
            ..KernelMethodChoices::default()
        };
        let crystal: Crystal<3> = choices.crystal().expect("a crystal");
        let scheme = KernelScheme::new(
            crystal,
            CrystalQuadrature::Nodal,
            KernelChoices {
                radius: 1.6,
                frame: Frame::Eulerian,
                ..KernelChoices::default()
            },
        );
        let scheme = scheme.expect("a scheme");
        Survey::new(&scheme, &law).and_then(|survey| survey.assess(&f))
    };
    let expected = answer(Matrix3::identity(), Matrix3::identity()).expect("an answer");
    for _ in 0..2 {
        let [change, inverse] = unimodular::<3>(&mut random);
        let found = answer(change, inverse).expect("an answer");
        assert_same(&expected, &found, &format!("{change}"));
    }
}

/// Law of a body that was previously deformed by `given`: `W(F given^-1)`.
struct Before<'a> {
    law: &'a dyn Hyperelastic,
    inverse: Matrix3<f64>,
}

impl Hyperelastic for Before<'_> {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let own = Matrix3::from_fn(|i, j| f.components()[i][j]) * self.inverse;
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| own[(i, j)]));
        let own = DeformationGradient::new(rows).expect("positive");
        let response = self.law.response(&own)?;
        let g = &self.inverse;
        Ok(Response {
            deformation: *f,
            energy: response.energy,
            first_piola: response.first_piola * g.transpose(),
            tangent: FourthOrder::from_fn(|i, j, k, l| {
                (0..9)
                    .map(|n| response.tangent[(i, n / 3, k, n % 3)] * g[(j, n / 3)] * g[(l, n % 3)])
                    .sum()
            }),
        })
    }
}

/// State and law after a shear that maps the square lattice onto itself. The law gives the same response as the original law in the original state.
fn sheared<'a>(
    law: &'a dyn Hyperelastic,
    small: [[f64; 2]; 2],
    shear: f64,
) -> (DeformationGradient, Before<'a>) {
    let [[a, b], [c, d]] = small;
    let f = [[a, a * shear + b], [c, c * shear + d]];
    let f = DeformationGradient::plane_strain(f, 1.0).expect("a state");
    let mut inverse = Matrix3::identity();
    inverse[(0, 1)] = -shear;
    (f, Before { law, inverse })
}

#[test]
fn waves_with_eulerian_kernels_are_invariant_under_shears_that_map_the_lattice_onto_itself() {
    let law = ModifiedMooneyRivlin::default();
    let square = KernelMethodChoices {
        lattice: LatticeKind::Square,
        frame: Frame::Eulerian,
        support: 1.9,
        quadrature: Quadrature::Nodal,
        ..KernelMethodChoices::default()
    };
    let method = Method::<2>::new(square.clone()).expect("a method");
    let sph = UpdatedSph::new(
        square.crystal::<2>().expect("a crystal"),
        UpdatedSphChoices {
            radius: 1.9,
            ..UpdatedSphChoices::default()
        },
    )
    .expect("a scheme");
    for small in [
        [[1.1, 0.0], [0.0, 1.0]],
        [[0.96, 0.05], [0.0, 0.97]],
        [[1.0, 0.0], [0.0, 1.0]],
    ] {
        let f = DeformationGradient::plane_strain(small, 1.0).expect("a state");
        let expected = assess(&method, &law, &f).expect("an answer");
        let of_sph = Survey::new(&sph, &law)
            .and_then(|s| s.assess(&f))
            .expect("an answer");
        for shear in [1.0, 4.0, -37.0, 1000.0] {
            let (f, law) = sheared(&law, small, shear);
            let context = format!("{small:?} {shear}");
            let found = assess(&method, &law, &f).expect("an answer");
            assert_eq!(found.verdict, expected.verdict, "{context}");
            assert_same_spectrum(&expected.spectrum, &found.spectrum, &context);
            let (verdict, stability) = judge(&method, &law, &f).expect("an answer");
            assert_eq!(
                (verdict, stability),
                (found.verdict, found.spectrum.stability()),
                "{context}"
            );
            let found = Survey::new(&sph, &law)
                .and_then(|s| s.assess(&f))
                .expect("an answer");
            // Zero-energy modes are determined in the state F = 1, which is a different state for the sheared law.
            if of_sph.verdict != Verdict::ZeroEnergy {
                assert_eq!(found.verdict, of_sph.verdict, "{context}");
            }
            let [expected, found] = [&of_sph.spectrum, &found.spectrum];
            assert_eq!(expected.stability(), found.stability(), "{context}");
            assert_same_spectrum(expected, found, &context);
        }
    }
}

#[test]
fn shears_beyond_double_precision_are_rejected() {
    let law = ModifiedMooneyRivlin::default();
    for support_size in [SupportSize::Fixed, SupportSize::Scaled] {
        let method = Method::<2>::new(KernelMethodChoices {
            frame: Frame::Eulerian,
            support_size,
            ..KernelMethodChoices::default()
        })
        .expect("a method");
        for shear in [1.5e5, 4e5] {
            let f = DeformationGradient::plane_strain([[1.0, shear], [0.0, 1.0]], 1.0);
            let refused = assess(&method, &law, &f.expect("a state"));
            assert!(
                refused.as_ref().is_err_and(MethodError::is_about_support),
                "{shear}"
            );
        }
    }
}

#[test]
fn long_cells_are_rejected_before_any_computation() {
    for vectors in [
        [6986.29, 1e5, 3.0, 1e100],
        [1e5, -2.0, 2.0, 1.5],
        [1.0, 0.0, 0.0, 40.0],
        [1.0, 0.0, 1e9, 1.0],
    ] {
        let vectors = Matrix2::from_column_slice(&vectors);
        let refused = described(&vectors, &KernelMethodChoices::default());
        assert!(matches!(refused, Err(MethodError::Lattice(_))), "{vectors}");
    }
    let long = KernelMethodChoices {
        lattice: LatticeKind::Rectangular,
        aspect: 31.0,
        ..KernelMethodChoices::default()
    };
    assert!(matches!(
        Method::<2>::new(long),
        Err(MethodError::Lattice(_))
    ));
}

/// Exponents of the units of stress, density and length: powers of four, so that all roots and quotients are exact.
const UNITS: [[i32; 3]; 9] = [
    [200, 0, 0],
    [-200, 0, 0],
    [0, 200, 0],
    [0, -200, 0],
    [0, 0, 40],
    [0, 0, -40],
    [130, -130, 10],
    [-260, -60, -12],
    [256, 256, 2],
];

fn assert_scaled<const D: usize>(
    a: &Assessment<D>,
    b: &Assessment<D>,
    [stress, density, length]: [f64; 3],
    context: &str,
) {
    let frequency = (stress / density).sqrt() / length;
    assert_eq!(a.verdict, b.verdict, "{context}");
    assert_eq!(
        a.spectrum.softest.scaled, b.spectrum.softest.scaled,
        "{context}"
    );
    assert_eq!(
        a.spectrum.long_wave.scaled, b.spectrum.long_wave.scaled,
        "{context}"
    );
    assert_eq!(
        a.spectrum.maximum_omega * frequency,
        b.spectrum.maximum_omega,
        "{context}"
    );
    assert_eq!(
        a.spectrum.growth_rate() * frequency,
        b.spectrum.growth_rate(),
        "{context}"
    );
    assert_eq!(
        a.spectrum.softest.wave_vector / length,
        b.spectrum.softest.wave_vector,
        "{context}"
    );
    let lowest = [a, b].map(|s| s.spectrum.lowest.omega_squared);
    assert_eq!(lowest[0] * frequency * frequency, lowest[1], "{context}");
    let minimum = [a, b].map(|s| s.material.minimum.eigenvalue);
    assert_eq!(minimum[0] * stress, minimum[1], "{context}");
}

/// Law with stresses in another unit.
struct Times<'a>(&'a dyn Hyperelastic, f64);

impl Hyperelastic for Times<'_> {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let response = self.0.response(f)?;
        Ok(Response {
            energy: response.energy * self.1,
            first_piola: response.first_piola * self.1,
            tangent: FourthOrder::from_fn(|i, j, k, l| response.tangent[(i, j, k, l)] * self.1),
            ..response
        })
    }
}

#[test]
fn results_of_kernel_methods_are_bitwise_identical_in_all_units() {
    let law = ModifiedMooneyRivlin::default();
    // Only the response is forwarded, so that all its parts are computed identically in all units.
    let plain = Times(&law, 1.0);
    let f = DeformationGradient::from_stretches([1.15, 0.93, 1.0]).expect("a state");
    let mut choices = Vec::new();
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
            for kind in [LatticeKind::Hexagonal, LatticeKind::Square] {
                choices.push(KernelMethodChoices {
                    frame,
                    quadrature,
                    lattice: kind,
                    ..KernelMethodChoices::default()
                });
            }
        }
    }
    for choices in choices {
        let method = Method::<2>::new(choices.clone()).expect("a method");
        let expected = assess(&method, &plain, &f).expect("an answer");
        for exponents in UNITS {
            let units = exponents.map(|exponent| 4_f64.powi(exponent));
            let context = format!("{exponents:?} {choices:?}");
            let method = Method::<2>::new(KernelMethodChoices {
                density: units[1],
                spacing: units[2],
                ..choices.clone()
            })
            .expect("a method");
            let law = Times(&plain, units[0]);
            let found = assess(&method, &law, &f);
            if (units[0] / units[1]).log10().abs() > 195.0 {
                assert!(found.is_err(), "{context}");
                continue;
            }
            let found = found.expect("an answer");
            assert_scaled(&expected, &found, units, &context);
            let judged = judge(&method, &law, &f).expect("an answer");
            assert_eq!(
                judged,
                judge(
                    &Method::<2>::new(choices.clone()).expect("a method"),
                    &plain,
                    &f
                )
                .expect("an answer"),
                "{context}"
            );
        }
    }
}

#[test]
fn maps_of_lagrangian_kernels_are_bitwise_identical_in_all_units() {
    let surveyed = |[stress, density, length]: [f64; 3], f: &DeformationGradient| {
        let method = Method::<2>::new(KernelMethodChoices {
            density,
            spacing: length,
            ..KernelMethodChoices::default()
        })
        .expect("a method");
        let law = ModifiedMooneyRivlin::default();
        let law: &'static ModifiedMooneyRivlin = Box::leak(Box::new(law));
        let law = Times(law, stress);
        let survey = Survey::new(&method, &law).expect("waves");
        let survey = survey.for_many_states().expect("moments");
        survey.state(f).expect("an answer")
    };
    for stretches in [[1.2, 0.9, 1.0], [3.1, 1.0, 1.0], [0.7, 1.4, 1.0]] {
        let f = DeformationGradient::from_stretches(stretches).expect("a state");
        let expected = surveyed([1.0; 3], &f);
        for exponents in UNITS {
            let units = exponents.map(|exponent| 4_f64.powi(exponent));
            if (units[0] / units[1]).log10().abs() > 195.0 {
                continue;
            }
            let found = surveyed(units, &f);
            let frequency = (units[0] / units[1]).sqrt() / units[2];
            assert_eq!(expected.verdict, found.verdict, "{exponents:?}");
            assert_eq!(
                expected.scaled_minimum, found.scaled_minimum,
                "{exponents:?}"
            );
            assert_eq!(
                expected.maximum_omega * frequency,
                found.maximum_omega,
                "{exponents:?}"
            );
            assert_eq!(
                expected.growth_rate * frequency,
                found.growth_rate,
                "{exponents:?}"
            );
        }
    }
}

#[test]
fn results_of_updated_sph_do_not_depend_on_the_units() {
    let law = ModifiedMooneyRivlin::default();
    let f = DeformationGradient::from_stretches([1.1, 0.95, 1.0]).expect("a state");
    for cells in [1, 2] {
        let answer = |[stress, density, length]: [f64; 3]| {
            let choices = KernelMethodChoices {
                lattice: LatticeKind::Square,
                cells,
                spacing: length,
                ..KernelMethodChoices::default()
            };
            let scheme = UpdatedSph::<2>::new(
                choices.crystal().expect("a crystal"),
                UpdatedSphChoices {
                    density,
                    radius: 1.9 * length,
                    ..UpdatedSphChoices::default()
                },
            );
            let scheme = scheme?;
            assert_eq!(scheme.density(), density);
            let law = Times(&law, stress);
            Survey::new(&scheme, &law).and_then(|survey| survey.assess(&f))
        };
        let expected = answer([1.0; 3]).expect("an answer");
        for exponents in UNITS {
            let units = exponents.map(|exponent| 4_f64.powi(exponent));
            let [stress, density] = [units[0].log10(), units[1].log10()];
            // The cube of the density, or a stress over this cube, can overflow or underflow. Then the result is an error or is correct.
            let is_extreme = density.abs() > 90.0 || (stress - 3.0 * density).abs() > 290.0;
            let found = match answer(units) {
                Ok(found) => found,
                Err(_) if is_extreme => continue,
                Err(error) => panic!("{exponents:?}: {error}"),
            };
            let frequency = (units[0] / units[1]).sqrt() / units[2];
            let context = format!("{cells} {exponents:?}");
            assert_eq!(expected.verdict, found.verdict, "{context}");
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs();
            let [a, b] = [&expected, &found].map(|s| &s.spectrum);
            assert!(close(a.softest.scaled, b.softest.scaled), "{context}");
            assert!(
                close(a.maximum_omega * frequency, b.maximum_omega),
                "{context}"
            );
            assert!(
                close(a.growth_rate() * frequency, b.growth_rate()),
                "{context}"
            );
        }
    }
}
