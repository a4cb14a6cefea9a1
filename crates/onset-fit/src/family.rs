//! Laws that can be fitted: energies as functions of the squares of the principal stretches and of the constants.
//!
//! The library of laws has its constants as numbers. Here they are variables, so that derivatives with respect to them are exact. Each energy is a sum
//! of terms, each a modulus times a function of at most two further constants; a test compares each family with the law of the library.

use crate::moduli::{Criterion, Moduli};
use crate::sums::{Enclosed, State, Sum};
use onset::real::{Dual, Jet, Real};
use std::fmt::Write;

/// Constant of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Name of the constant in settings, such as `c10` or `alpha1`.
    pub name: String,
    /// Whether the energy is linear in the constant. Such constants have the unit of stress, and all others have no unit.
    pub is_modulus: bool,
    /// Smallest and largest admissible value.
    pub bounds: [f64; 2],
    /// Range in which first guesses are drawn.
    pub guesses: [f64; 2],
}

/// Form of a fitted law in settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Model {
    /// Name of a law of the library, with the constants of the family.
    Library(&'static str),
    /// Energy as a formula of the constants, with the bulk modulus `kappa`.
    Formula(String),
}

/// Function of the stretches that a modulus multiplies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// Product of powers of the invariants: `(I1 - 3)^i (I2 - 3)^j`.
    Powers(i32, i32),
    /// Term of Ogden's law: `(l1^alpha + l2^alpha + l3^alpha - 3) / alpha`.
    Ogden,
    /// Gent's law: `-jm/2 ln(1 - (I1 - 3)/jm)`.
    Gent,
    /// Series of Arruda and Boyce: `sum a_i / locking^(2i-2) (I1^i - 3^i)`.
    ArrudaBoyce,
    /// Fung's isotropic law: `(exp(b (I1 - 3)) - 1) / (2 b)`.
    Fung,
    /// Hencky's law: `|dev h|^2`.
    Hencky,
    /// Exponentiated Hencky law: `(exp(k |dev h|^2) - 1) / k`.
    ExponentiatedHencky,
    /// Term of a foam: `2/alpha^2 (lambda_1^alpha + lambda_2^alpha + lambda_3^alpha - 3 + (J^(-alpha beta) - 1)/beta)`.
    Foam,
}

/// Coefficients of the series of the inverse Langevin function, as in Arruda and Boyce, J. Mech. Phys. Solids 41 (1993) 389.
const CHAINS: [f64; 5] = [
    1.0 / 2.0,
    1.0 / 20.0,
    11.0 / 1050.0,
    19.0 / 7000.0,
    519.0 / 673_750.0,
];

/// Term of an energy.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Term {
    part: Part,
    factor: f64,
    /// Index of the modulus among the constants.
    pub modulus: usize,
    /// Indices of the other constants.
    pub shapes: Vec<usize>,
}

/// Largest number of constants of a term in addition to the modulus.
pub(crate) const SHAPES: usize = 2;

impl Term {
    /// Sums over the stretches that determine the energy.
    fn sums<R: Enclosed>(&self, [shape, _]: [R; SHAPES]) -> [Sum<R>; 2] {
        match self.part {
            Part::Powers(..) | Part::Gent | Part::ArrudaBoyce | Part::Fung => {
                [Sum::First, Sum::Second]
            }
            Part::Ogden | Part::Foam => [Sum::Powers(shape), Sum::Volume],
            Part::Hencky | Part::ExponentiatedHencky => [Sum::Squares, Sum::Volume],
        }
    }

    /// Returns true if two terms are functions of the same sums.
    fn shares_sums(&self, other: &Self) -> bool {
        let is_of_invariants = |own: &Self| matches!(own.sums([1.0; SHAPES]), [Sum::First, _]);
        is_of_invariants(self) && is_of_invariants(other)
    }

    /// Energy of the term for a unit modulus as a function of its sums.
    fn energy<R: Real>(&self, [shape, other]: [R; SHAPES], [x, y]: [R; 2]) -> R {
        let value = match self.part {
            Part::Powers(i, 0) => x.powi(i),
            Part::Powers(0, j) => y.powi(j),
            Part::Powers(i, j) => x.powi(i) * y.powi(j),
            Part::Ogden => x / shape,
            Part::Gent => -(shape * 0.5) * (-(x / shape) + 1.0).ln(),
            Part::ArrudaBoyce => {
                let links = (shape * shape).recip();
                let chains = |x: R| {
                    let horner = |sum: R, a: &f64| sum * x * links + *a;
                    x * CHAINS.iter().rev().fold(R::constant(0.0), horner)
                };
                chains(x + 3.0) - chains(R::constant(3.0))
            }
            Part::Fung => ((x * shape).exp() - 1.0) / (shape * 2.0),
            Part::Hencky => x,
            Part::ExponentiatedHencky => ((x * shape).exp() - 1.0) / shape,
            Part::Foam => {
                let volumetric = ((-(y * shape * other)).exp() - 1.0) / other;
                (x + volumetric) * 2.0 / (shape * shape)
            }
        };
        value * self.factor
    }

    /// Returns true if the energy is strictly convex at all states of constant volume: in the logarithms of the stretches for Drucker's inequality,
    /// and along all lines `F + t m N` of constant volume for strong ellipticity. `None` if the theorem does not decide.
    ///
    /// Both `tr C` and `tr C^-1` are convex in either sense, and increasing convex functions of convex functions are convex. On those lines the
    /// cofactor of `F` is linear in `t`, so that `sum lambda^alpha` is convex if `|alpha| >= 1`, as in Ball, Arch. Rational Mech. Anal. 63 (1977) 337.
    fn is_strictly_convex(&self, criterion: Criterion, constants: &[f64]) -> Option<bool> {
        let [shape, _] = Family::shapes::<f64>(self, constants);
        let modulus = constants[self.modulus];
        let in_logarithms = criterion == Criterion::Drucker;
        if modulus == 0.0 {
            return Some(false);
        }
        let (holds, is_strict) = match self.part {
            Part::Powers(i, j) => (modulus > 0.0 && i.min(j) == 0, i + j == 1),
            Part::Ogden => (
                modulus * shape > 0.0 && (in_logarithms || shape.abs() >= 1.0),
                true,
            ),
            Part::Gent | Part::ArrudaBoyce | Part::Fung => (modulus > 0.0 && shape > 0.0, true),
            Part::Hencky => (modulus > 0.0 && in_logarithms, true),
            Part::ExponentiatedHencky => (modulus > 0.0 && shape > 0.0 && in_logarithms, true),
            Part::Foam => (false, false),
        };
        holds.then_some(is_strict)
    }
}

/// Law that can be fitted, with constants as unknowns.
///
/// ```
/// let yeoh = onset_fit::Family::named("yeoh").ok_or("no such law")?;
/// let names: Vec<&str> = yeoh.constants().iter().map(|own| own.name.as_str()).collect();
/// assert_eq!(names, ["c10", "c20", "c30"]);
/// assert!(yeoh.is_linear());
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    name: String,
    model: Model,
    constants: Vec<Constant>,
    terms: Vec<Term>,
    is_compressible: bool,
}

/// Names of the families of [`Family::all`], from few constants to many.
const NAMES: [&str; 18] = [
    "neo-hooke-isochoric",
    "hencky",
    "gent",
    "arruda-boyce",
    "fung-isotropic",
    "exponentiated-hencky",
    "mooney-rivlin-isochoric",
    "isihara",
    "yeoh",
    "biderman",
    "james-green-simpson",
    "polynomial-2",
    "polynomial-3",
    "ogden-1",
    "ogden-2",
    "ogden-3",
    "ogden-4",
    "hyperfoam-2",
];

/// Largest number of terms of Ogden's law and of the law of foams in the library.
const OGDEN_TERMS: usize = 6;
const FOAM_TERMS: usize = 3;
/// Exponents of smaller magnitude are not tried, because two terms with such exponents approach one term with a logarithm.
pub(crate) const SMALLEST_EXPONENT: f64 = 0.05;

impl Family {
    /// Names of the families that `all` selects.
    pub fn all() -> impl Iterator<Item = &'static str> {
        NAMES.into_iter()
    }

    /// Returns the family with the given name, or `None` if no family has it.
    ///
    /// Names are the names of [`Family::all`], of laws of the library that can be fitted, `ogden-N` with N up to 6, and `hyperfoam-N` with N up to 3.
    pub fn named(name: &str) -> Option<Self> {
        let polynomial = |powers: &[(i32, i32)]| Self::polynomial(name, powers);
        Some(match name {
            "neo-hooke-isochoric" | "neo-hooke" => {
                Self::single("neo-hooke-isochoric", Part::Powers(1, 0), 0.5, &[])
            }
            "hencky" => Self::single(name, Part::Hencky, 1.0, &[]),
            "gent" => Self::single(name, Part::Gent, 1.0, &[("jm", [1e-3, 1e6], [3.0, 300.0])]),
            "arruda-boyce" => {
                let locking = ("locking", [1.0, 1e3], [1.2, 10.0]);
                Self::single(name, Part::ArrudaBoyce, 1.0, &[locking])
            }
            "fung-isotropic" => {
                Self::single(name, Part::Fung, 1.0, &[("b", [1e-6, 1e3], [1e-3, 3.0])])
            }
            "exponentiated-hencky" => Self::single(
                name,
                Part::ExponentiatedHencky,
                1.0,
                &[("k", [1e-6, 1e3], [0.01, 3.0])],
            ),
            "mooney-rivlin-isochoric" | "mooney-rivlin" | "polynomial-1" => {
                Self::polynomial("mooney-rivlin-isochoric", &[(1, 0), (0, 1)])
            }
            "yeoh" => polynomial(&[(1, 0), (2, 0), (3, 0)]),
            "isihara" => polynomial(&[(1, 0), (0, 1), (2, 0)]),
            "biderman" => polynomial(&[(1, 0), (0, 1), (2, 0), (3, 0)]),
            "james-green-simpson" => polynomial(&[(1, 0), (0, 1), (1, 1), (2, 0), (3, 0)]),
            "polynomial-2" | "polynomial-3" => {
                let order = if name.ends_with('2') { 2 } else { 3 };
                let powers = (1..=order).flat_map(|n| (0..=n).map(move |j| (n - j, j)));
                polynomial(&powers.collect::<Vec<_>>())
            }
            "ogden" => Self::ogden(3),
            "hyperfoam" => Self::foam(2),
            _ => {
                let (law, terms) = name.rsplit_once('-')?;
                let terms: usize = terms.parse().ok()?;
                match law {
                    "ogden" if (1..=OGDEN_TERMS).contains(&terms) => Self::ogden(terms),
                    "hyperfoam" if (1..=FOAM_TERMS).contains(&terms) => Self::foam(terms),
                    _ => return None,
                }
            }
        })
    }

    /// Law of one term.
    fn single(name: &str, part: Part, factor: f64, shapes: &[(&str, [f64; 2], [f64; 2])]) -> Self {
        let shape = |(name, bounds, guesses): &(&str, [f64; 2], [f64; 2])| Constant {
            name: (*name).to_owned(),
            is_modulus: false,
            bounds: *bounds,
            guesses: *guesses,
        };
        let mut constants = vec![Constant::modulus("mu", [0.0, f64::INFINITY])];
        constants.extend(shapes.iter().map(shape));
        Self {
            name: name.to_owned(),
            model: Model::Library(onset::material::Law::named(name).map_or("", |law| law.name)),
            terms: vec![Term {
                part,
                factor,
                modulus: 0,
                shapes: (1..constants.len()).collect(),
            }],
            constants,
            is_compressible: false,
        }
    }

    /// Polynomial law in the invariants.
    fn polynomial(name: &str, powers: &[(i32, i32)]) -> Self {
        let library = onset::material::Law::named(name);
        let mut energy = "let x = I1bar - 3; let y = I2bar - 3; ".to_owned();
        for (i, j) in powers {
            let _ = write!(energy, "c{i}{j}");
            for (variable, power) in [("x", i), ("y", j)] {
                let _ = match power {
                    0 => Ok(()),
                    1 => write!(energy, "*{variable}"),
                    _ => write!(energy, "*{variable}^{power}"),
                };
            }
            energy.push_str(" + ");
        }
        energy.push_str("kappa/2*(J - 1)^2");
        if powers.iter().all(|(_, j)| *j == 0) {
            energy = energy.replace("let y = I2bar - 3; ", "");
        }
        let name_of = |(i, j): &(i32, i32)| format!("c{i}{j}");
        Self {
            name: name.to_owned(),
            model: library.map_or(Model::Formula(energy), |law| Model::Library(law.name)),
            constants: powers
                .iter()
                .map(|own| Constant::modulus(&name_of(own), [f64::NEG_INFINITY, f64::INFINITY]))
                .collect(),
            terms: powers
                .iter()
                .enumerate()
                .map(|(n, (i, j))| Term {
                    part: Part::Powers(*i, *j),
                    factor: 1.0,
                    modulus: n,
                    shapes: Vec::new(),
                })
                .collect(),
            is_compressible: false,
        }
    }

    fn ogden(terms: usize) -> Self {
        Self::of_terms(
            format!("ogden-{terms}"),
            Model::Library("ogden"),
            Part::Ogden,
            terms,
            &[("alpha", [-60.0, 60.0], [-6.0, 10.0])],
        )
    }

    fn foam(terms: usize) -> Self {
        let shapes = [
            ("alpha", [-60.0, 60.0], [-6.0, 20.0]),
            ("beta", [-0.33, 20.0], [-0.2, 1.0]),
        ];
        let mut foam = Self::of_terms(
            format!("hyperfoam-{terms}"),
            Model::Library("hyperfoam"),
            Part::Foam,
            terms,
            &shapes,
        );
        foam.is_compressible = true;
        foam
    }

    /// Law of several terms of one form, with the moduli `mu1`, `mu2`, ...
    fn of_terms(
        name: String,
        model: Model,
        part: Part,
        count: usize,
        shapes: &[(&str, [f64; 2], [f64; 2])],
    ) -> Self {
        let mut constants = Vec::new();
        let mut terms = Vec::new();
        for n in 1..=count {
            let modulus = constants.len();
            let any = [f64::NEG_INFINITY, f64::INFINITY];
            constants.push(Constant::modulus(&format!("mu{n}"), any));
            for (shape, bounds, guesses) in shapes {
                constants.push(Constant {
                    name: format!("{shape}{n}"),
                    is_modulus: false,
                    bounds: *bounds,
                    guesses: *guesses,
                });
            }
            terms.push(Term {
                part,
                factor: 1.0,
                modulus,
                shapes: (modulus + 1..constants.len()).collect(),
            });
        }
        Self {
            name,
            model,
            constants,
            terms,
            is_compressible: false,
        }
    }

    /// Name of the family.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Form of a fitted law of the family in settings.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Constants of the law in their fixed order.
    pub fn constants(&self) -> &[Constant] {
        &self.constants
    }

    /// Settings that remove the unused terms of the law of the library, such as `mu3 = 0` for `ogden` with two terms.
    pub fn unused(&self) -> Vec<(String, f64)> {
        let Model::Library(name) = self.model else {
            return Vec::new();
        };
        let law = onset::material::Law::named(name);
        let parameters = law.map_or(&[][..], |law| law.parameters);
        let is_spare = |name: &str| {
            name.strip_prefix("mu")
                .and_then(|number| number.parse().ok())
                .is_some_and(|number: usize| number > self.terms.len())
        };
        let spare = parameters.iter().filter(|own| is_spare(own.name));
        let nonzero = spare.filter(|own| own.default != 0.0);
        nonzero.map(|own| (own.name.to_owned(), 0.0)).collect()
    }

    /// Returns true if the energy is linear in all constants, so that the optimum of a fit is the global one.
    pub fn is_linear(&self) -> bool {
        self.constants.iter().all(|own| own.is_modulus)
    }

    /// Returns true if volumes change in tests, so that lateral stretches are needed. Other laws are fitted to their incompressible response.
    pub fn is_compressible(&self) -> bool {
        self.is_compressible
    }

    /// Law of the same form with one term less, whose constants are the first ones; `None` for laws of one term and for polynomials.
    pub(crate) fn smaller(&self) -> Option<Self> {
        let terms = self.terms.len() - 1;
        match self.terms.first()?.part {
            Part::Ogden if terms > 0 => Some(Self::ogden(terms)),
            Part::Foam if terms > 0 => Some(Self::foam(terms)),
            _ => None,
        }
    }

    /// Bounds of the constants for which each term is convex, so that an incompressible law is stable at all states: one set for each choice of
    /// the signs of the exponents. Empty if no bounds are known.
    pub(crate) fn convex_bounds(&self) -> Vec<Vec<[f64; 2]>> {
        let own: Vec<[f64; 2]> = self.constants.iter().map(|own| own.bounds).collect();
        let patterns = match self.terms.first().map(|own| own.part) {
            Some(Part::Ogden | Part::Foam) => 0..=self.terms.len(),
            Some(Part::Hencky | Part::ExponentiatedHencky) => return Vec::new(),
            _ => 0..=0,
        };
        let of_pattern = |negative: usize| {
            let mut bounds = own.clone();
            for (n, term) in self.terms.iter().enumerate() {
                let is_negative = n + negative >= self.terms.len();
                let shape = term.shapes.first().copied();
                let modulus = match term.part {
                    Part::Powers(i, j) if i.min(j) > 0 => [0.0; 2],
                    Part::Ogden if is_negative => [f64::NEG_INFINITY, 0.0],
                    _ => [0.0, f64::INFINITY],
                };
                bounds[term.modulus] = modulus;
                if let (Part::Ogden | Part::Foam, Some(shape)) = (term.part, shape) {
                    let [low, high] = own[shape];
                    bounds[shape] = match is_negative {
                        true => [low, -1.0],
                        false => [1.0, high],
                    };
                }
            }
            bounds
        };
        patterns.map(of_pattern).collect()
    }

    pub(crate) fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// Values of the further constants of a term, as constants of the number type.
    pub(crate) fn shapes<R: Real>(term: &Term, constants: &[f64]) -> [R; SHAPES] {
        let mut shapes = [R::constant(1.0); SHAPES];
        for (own, index) in shapes.iter_mut().zip(&term.shapes) {
            *own = R::constant(constants[*index]);
        }
        shapes
    }

    /// Derivatives of the energy with respect to the logarithms of the principal stretches, at these logarithms.
    ///
    /// Incompressible laws are extended to all stretches and equal the law at `J = 1`.
    pub(crate) fn moduli<R: Enclosed>(&self, constants: &[f64], logs: [R; 3]) -> Moduli<R> {
        let state = State::new(logs);
        let mut moduli = Moduli::zero(&state);
        let mut rest = self.terms.as_slice();
        while let Some((term, others)) = rest.split_first() {
            // Terms of the same sums form a single function of these sums.
            let same = others.iter().take_while(|own| own.shares_sums(term));
            let (own, others) = rest.split_at(1 + same.count());
            let shapes = |own: &Term| Self::shapes(own, constants);
            Self::add(&mut moduli, &state, own, shapes, |own| {
                constants[own.modulus]
            });
            rest = others;
        }
        moduli
    }

    /// Moduli of a term for a unit modulus, with derivatives with respect to its further constants.
    pub(crate) fn moduli_of(
        term: &Term,
        constants: &[f64],
        logs: [f64; 3],
    ) -> Moduli<Dual<SHAPES>> {
        let state = State::new(logs.map(Dual::constant));
        let mut moduli = Moduli::zero(&state);
        let shapes = |own: &Term| Self::variable_shapes(own, constants);
        Self::add(
            &mut moduli,
            &state,
            std::slice::from_ref(term),
            shapes,
            |_| 1.0,
        );
        moduli
    }

    /// Adds the moduli of terms with the same sums.
    fn add<R: Enclosed>(
        moduli: &mut Moduli<R>,
        state: &State<R>,
        terms: &[Term],
        shapes: impl Fn(&Term) -> [R; SHAPES],
        modulus: impl Fn(&Term) -> f64,
    ) {
        let Some(first) = terms.first() else {
            return;
        };
        let sums = first.sums(shapes(first));
        let slopes = [sums[0].slopes(state), sums[1].slopes(state)];
        let curvatures = [sums[0].curvatures(state), sums[1].curvatures(state)];
        let variables = Jet::variables([slopes[0].0, slopes[1].0]);
        let fixed = |value: R| {
            let mut jet = Jet::constant(0.0);
            jet.value = value;
            jet
        };
        let energy = terms.iter().fold(Jet::constant(0.0), |sum, own| {
            sum + own.energy(shapes(own).map(fixed), variables) * modulus(own)
        });
        moduli.add(&energy, [&slopes[0].1, &slopes[1].1], &curvatures);
    }

    /// Principal Kirchhoff stresses, the derivatives of the energy with respect to the logarithms of the principal stretches.
    pub(crate) fn stresses(&self, constants: &[f64], logs: [f64; 3]) -> [f64; 3] {
        let mut all = [0.0; 3];
        for term in &self.terms {
            let stresses = Self::stresses_of::<f64>(term, Self::shapes(term, constants), logs);
            for (sum, own) in all.iter_mut().zip(stresses) {
                *sum += constants[term.modulus] * own;
            }
        }
        all
    }

    /// Principal Kirchhoff stresses of a term for a unit modulus, with derivatives with respect to its further constants.
    pub(crate) fn stresses_of<R: Enclosed>(
        term: &Term,
        shapes: [R; SHAPES],
        logs: [f64; 3],
    ) -> [R; 3] {
        let state = State::new(logs.map(R::constant));
        let sums = term.sums(shapes).map(|sum| sum.slopes(&state));
        let fixed = shapes.map(|value| Dual {
            value,
            gradient: [R::constant(0.0); 2],
        });
        let energy = term.energy(fixed, Dual::variables(sums.map(|own| own.0)));
        let [x, y] = energy.gradient;
        std::array::from_fn(|i| x * sums[0].1[i] + y * sums[1].1[i])
    }

    /// Further constants of a term as variables.
    pub(crate) fn variable_shapes(term: &Term, constants: &[f64]) -> [Dual<SHAPES>; SHAPES] {
        let mut shapes = [Dual::constant(1.0); SHAPES];
        for (n, (own, index)) in shapes.iter_mut().zip(&term.shapes).enumerate() {
            *own = Dual::variable(constants[*index], n);
        }
        shapes
    }

    /// Returns true if a criterion holds at all states at constant volume at which the energy is defined, because each term is convex.
    pub(crate) fn is_convex(&self, criterion: Criterion, constants: &[f64]) -> bool {
        let terms = self.terms.iter();
        let convex = terms.map(|term| term.is_strictly_convex(criterion, constants));
        let strict: Option<Vec<bool>> = convex.collect();
        strict.is_some_and(|own| own.contains(&true))
    }

    /// Value of `I_1 - 3` at which the chains of a law are fully extended; `None` for laws without chains.
    pub(crate) fn locking(&self, constants: &[f64]) -> Option<f64> {
        self.terms.iter().find_map(|term| {
            let [shape, _] = Self::shapes::<f64>(term, constants);
            match term.part {
                Part::Gent => Some(shape),
                Part::ArrudaBoyce => Some(3.0 * (shape * shape - 1.0)),
                _ => None,
            }
        })
    }

    /// Returns true if the energy is not defined at stretches beyond the locking of chains.
    pub fn ends_at_locking(&self) -> bool {
        self.terms.iter().any(|term| term.part == Part::Gent)
    }

    /// Returns true if a constant is an exponent, which is not 0.
    pub(crate) fn is_exponent(&self, n: usize) -> bool {
        let name = &self.constants[n].name;
        name.starts_with("alpha") || name.starts_with("beta")
    }

    /// Smallest magnitude of a constant near a value; zero unless it is an exponent. Bounds of the user closer to zero count instead.
    pub(crate) fn smallest(&self, n: usize, value: f64, [low, high]: [f64; 2]) -> f64 {
        if !self.is_exponent(n) {
            return 0.0;
        }
        let nearest = if value < 0.0 { -high } else { low };
        match nearest > 0.0 {
            true => nearest.min(SMALLEST_EXPONENT),
            false => SMALLEST_EXPONENT,
        }
    }

    /// Ensures that no exponent is too close to zero.
    pub(crate) fn admissible(&self, constants: &mut [f64], bounds: &[[f64; 2]]) {
        for (n, (own, value)) in self.constants.iter().zip(constants).enumerate() {
            *value = value.clamp(own.bounds[0], own.bounds[1]);
            let smallest = self.smallest(n, *value, bounds[n]);
            if value.abs() < smallest {
                *value = smallest.copysign(*value);
            }
        }
    }
}

impl Constant {
    fn modulus(name: &str, bounds: [f64; 2]) -> Self {
        Self {
            name: name.to_owned(),
            is_modulus: true,
            bounds,
            guesses: [0.0, 1.0],
        }
    }
}
