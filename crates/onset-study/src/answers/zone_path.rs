//! Paths through the Brillouin zone of a deformed state: the points of high symmetry that it distinguishes, and paths typed by the user.

use super::problem::{ProblemError, numbers};
use nalgebra::{Matrix3, Vector3};
use onset::algebra::Complex;
use onset::analysis::Analysis;
use onset::lattice::LatticeKind;

/// The name of `k = 0`.
const GAMMA: &str = "Γ";
/// The name of the critical wave vector.
pub(super) const CRITICAL: &str = "k*";
/// Name of the point on the zone boundary beyond the critical wave vector.
const EDGE: &str = "∂";
/// Wave vectors without symmetry, in units of the reciprocal vectors.
const ASYMMETRIC_WAVE_VECTORS: [[f64; 3]; 3] = [
    [0.237_068_1, 0.396_871_4, 0.141_592_7],
    [0.414_213_6, 0.118_033_9, 0.302_775_6],
    [0.087_298_3, 0.267_949_2, 0.449_489_7],
];
/// Relative tolerance of squared frequencies that are considered equal.
const FREQUENCY_TOLERANCE: f64 = 1e-8;
/// Tolerance of coordinates that are considered equal, in units of the reciprocal vectors.
const COORDINATE_TOLERANCE: f64 = 1e-7;

/// Wave vector with a name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stop {
    /// Name of the point, as in a diagram.
    pub(super) name: String,
    /// Wave vector in the reference configuration.
    pub(super) wave_vector: Vector3<f64>,
}

/// Pieces of a path, each a chain of wave vectors; between pieces the path jumps.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ZonePath(pub(super) Vec<Vec<Stop>>);

impl ZonePath {
    /// Appends a chain. If it starts at the end of the last chain, the two are joined.
    fn add(&mut self, chain: Vec<Stop>) {
        let follows = |last: &Vec<Stop>| {
            let ends = last.last().zip(chain.first());
            ends.is_some_and(|(end, start)| end.wave_vector == start.wave_vector)
        };
        match self.0.last_mut().filter(|last| follows(last)) {
            Some(last) => last.extend(chain.into_iter().skip(1)),
            None => self.0.push(chain),
        }
    }

    /// Adds the line from zero through a wave vector to the zone boundary, which is `reach` times as distant.
    pub(super) fn through(&mut self, k: &Vector3<f64>, reach: f64) {
        let mut chain = vec![Stop::new(GAMMA, Vector3::zeros()), Stop::new(CRITICAL, *k)];
        if reach.is_finite() && reach > 1.0 + COORDINATE_TOLERANCE {
            chain.push(Stop::new(EDGE, k * reach));
        }
        self.add(chain);
    }
}

impl Stop {
    fn new(name: impl Into<String>, wave_vector: Vector3<f64>) -> Self {
        Self {
            name: name.into(),
            wave_vector,
        }
    }
}

/// Points of high symmetry of a lattice that a state distinguishes.
///
/// A rotation or reflection of the reference lattice is a symmetry of the state if waves without symmetry keep their frequencies under it. Anything
/// that breaks the symmetry changes these frequencies: the deformation, fibers of the material, one family of stress points, or the background grid.
/// Points that are mapped to each other, or to opposite points, have the same waves, so that one of them suffices.
pub(super) struct SymmetryPoints<'a> {
    analysis: &'a dyn Analysis,
    holohedry: Vec<Matrix3<f64>>,
    /// Maps of the holohedry that are symmetries of the state.
    of_state: Vec<Matrix3<f64>>,
    /// Usual path, which provides the names.
    route: Vec<(&'static str, Vector3<f64>)>,
    /// The points, beginning with `k = 0`; images of one name are `M`, `M′`, `M″`.
    points: Vec<Stop>,
}

impl<'a> SymmetryPoints<'a> {
    /// Finds the points for the lattice of a discretization, its usual path through the reference zone, and the squared frequencies of the waves at a
    /// state.
    pub(super) fn new(
        analysis: &'a dyn Analysis,
        zone: Option<LatticeKind>,
        omega_squared: impl Fn(&Vector3<f64>) -> Vec<Complex>,
    ) -> Self {
        let holohedry = analysis.holohedry();
        let generic = ASYMMETRIC_WAVE_VECTORS.map(|place| wave_vector(analysis, &place));
        let own = generic.map(|k| omega_squared(&k));
        let keeps = |map: &&Matrix3<f64>| {
            let mut waves = generic.iter().zip(&own);
            waves.all(|(k, own)| is_same_spectrum(own, &omega_squared(&(*map * k))))
        };
        let of_state = holohedry.iter().filter(keeps).copied().collect();
        let route = analysis.zone_path(zone).into_iter();
        let in_3d = |k: Vec<f64>| Vector3::from_fn(|i, _| k.get(i).copied().unwrap_or(0.0));
        let mut symmetry = Self {
            analysis,
            holohedry,
            of_state,
            route: route.map(|(name, k)| (name, in_3d(k))).collect(),
            points: vec![Stop::new(GAMMA, Vector3::zeros())],
        };
        symmetry.name_points();
        symmetry
    }

    fn name_points(&mut self) {
        for (name, k) in self.route.clone() {
            for map in self.holohedry.clone() {
                let image = map * k;
                if self.known(&image).is_none() {
                    let images = self.points.iter().filter(|p| p.name.starts_with(name));
                    let primes = "′".repeat(images.count());
                    self.points
                        .push(Stop::new(format!("{name}{primes}"), image));
                }
            }
        }
    }

    /// Index of the point that is equivalent to a wave vector by symmetry.
    fn known(&self, k: &Vector3<f64>) -> Option<usize> {
        let is_lattice_vector = |difference: Vector3<f64>| {
            let place = self.analysis.fractional(&difference);
            place
                .iter()
                .all(|x| (x - x.round()).abs() < COORDINATE_TOLERANCE)
        };
        self.points.iter().position(|point| {
            self.of_state.iter().any(|map| {
                let image = map * point.wave_vector;
                is_lattice_vector(image - k) || is_lattice_vector(image + k)
            })
        })
    }

    /// Returns the name of a wave vector if it is a point of high symmetry.
    pub(super) fn name(&self, k: &Vector3<f64>) -> Option<&str> {
        self.known(k)
            .map(|number| self.points[number].name.as_str())
    }

    /// The usual path, with loops from `k = 0` through those images of its points that the state distinguishes.
    pub(super) fn path(&self) -> ZonePath {
        let mut path = ZonePath::default();
        let mut visited = vec![false; self.points.len()];
        let stop = |k: Vector3<f64>| Stop::new(self.name(&k).unwrap_or_default(), k);
        for (_, k) in &self.route {
            if let Some(number) = self.known(k) {
                visited[number] = true;
            }
        }
        path.add(self.route.iter().map(|(_, k)| stop(*k)).collect());
        loop {
            // Points that the image of the path adds, in the order of the image.
            let added = |map: &Matrix3<f64>| {
                let mut numbers: Vec<(usize, Vector3<f64>)> = Vec::new();
                for (_, k) in &self.route {
                    let image = map * k;
                    let new = self.known(&image).filter(|number| !visited[*number]);
                    let is_new = |number: &usize| numbers.iter().all(|(known, _)| known != number);
                    if let Some(number) = new.filter(is_new) {
                        numbers.push((number, image));
                    }
                }
                numbers
            };
            // Among images with equal numbers of new points, the first is chosen.
            let most = self.holohedry.iter().map(added).reduce(|best, other| {
                if other.len() > best.len() {
                    other
                } else {
                    best
                }
            });
            let Some(loop_points) = most.filter(|points| !points.is_empty()) else {
                return path;
            };
            for (number, _) in &loop_points {
                visited[*number] = true;
            }
            let zero = || std::iter::once(stop(Vector3::zeros()));
            let points = loop_points.into_iter().map(|(_, k)| stop(k));
            path.add(zero().chain(points).chain(zero()).collect());
        }
    }

    /// Reads a typed path: labels joined by hyphens (`G-M-K-G`), or points in units of the reciprocal vectors and labels, separated by semicolons
    /// (`0,0; 0.5,0; K`); a bar (`G-X|K-G`) is a jump.
    ///
    /// # Errors
    /// [`ProblemError`] when a label is unknown, a point has another dimension, or a chain has fewer than two points.
    pub(super) fn typed(&self, text: &str) -> Result<ZonePath, ProblemError> {
        let mut path = ZonePath::default();
        for chain in text.split('|') {
            let separators: &[char] = match chain.contains([',', ';']) {
                true => &[';'],
                false => &['-', '–', '—', '→'],
            };
            let stops: Vec<Stop> = chain
                .split(separators)
                .map(|word| self.typed_stop(word.trim()))
                .collect::<Result<_, _>>()?;
            if stops.len() < 2 {
                return Err(ProblemError::Numbers {
                    what: "--path",
                    hint: String::new(),
                    given: stops.len(),
                    expected: "at least two points, for example G-M-K-G".to_owned(),
                });
            }
            path.add(stops);
        }
        Ok(path)
    }

    fn typed_stop(&self, word: &str) -> Result<Stop, ProblemError> {
        let label = match word {
            "G" | "g" | "Gamma" | "gamma" | "γ" => GAMMA.to_owned(),
            _ => word.replace('\'', "′"),
        };
        if let Some(point) = self.points.iter().find(|point| point.name == label) {
            return Ok(point.clone());
        }
        // A word that begins like a number, or has several parts, is a point.
        let starts = word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let dimension = self.analysis.dimension();
        if !(starts || dimension > 1 && word.contains(',')) {
            return Err(ProblemError::ZonePoint {
                label: word.to_owned(),
                known: self.points.iter().map(|point| point.name.clone()).collect(),
            });
        }
        let place = numbers("--path", word)?;
        if place.len() != dimension {
            return Err(ProblemError::Numbers {
                what: "a point of --path",
                hint: String::new(),
                given: place.len(),
                expected: dimension.to_string(),
            });
        }
        let k = wave_vector(self.analysis, &place);
        let name = self
            .name(&k)
            .map_or_else(|| format!("({word})"), str::to_owned);
        Ok(Stop::new(name, k))
    }
}

/// Wave vector with the given coordinates in units of the reciprocal vectors.
fn wave_vector(analysis: &dyn Analysis, place: &[f64]) -> Vector3<f64> {
    let reciprocal = analysis.reciprocal();
    reciprocal.iter().zip(place).map(|(b, x)| b * *x).sum()
}

/// Returns true if two sets of squared frequencies agree to rounding, in any order.
fn is_same_spectrum(a: &[Complex], b: &[Complex]) -> bool {
    let size = a
        .iter()
        .chain(b)
        .map(|value| value.norm())
        .fold(0.0, f64::max);
    let mut left: Vec<&Complex> = b.iter().collect();
    a.len() == b.len()
        && a.iter().all(|value| {
            // The opposite wave has the complex conjugate.
            let is_same = |other: &&Complex| {
                let distance = (value - *other).norm().min((value - other.conj()).norm());
                distance <= FREQUENCY_TOLERANCE * size
            };
            let place = left.iter().position(is_same);
            place.map(|place| left.swap_remove(place)).is_some()
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answers::Problem;
    use crate::settings::Settings;
    use nalgebra::DMatrix;

    fn problem(kind: LatticeKind) -> Problem {
        let assignments = [format!("discretization.lattice={}", kind.name())];
        let settings = Settings::from_assignments(&assignments).expect("settings");
        Problem::new(settings).expect("a problem")
    }

    /// Waves of springs between a particle and its neighbors in a state with the given stretches along the axes.
    fn springs(
        analysis: &dyn Analysis,
        stretches: [f64; 3],
    ) -> impl Fn(&Vector3<f64>) -> Vec<Complex> {
        // The neighbors of the lattice are dual to the reciprocal vectors.
        let reciprocal = analysis.reciprocal();
        let basis = DMatrix::from_fn(reciprocal.len(), reciprocal.len(), |i, j| reciprocal[j][i]);
        let dual = basis.try_inverse().expect("a basis").transpose() * std::f64::consts::TAU;
        let first = Vector3::from_fn(|i, _| dual.get((i, 0)).copied().unwrap_or(0.0));
        let short: Vec<Vector3<f64>> = analysis.holohedry().iter().map(|map| map * first).collect();
        move |k| {
            let spring = |a: &Vector3<f64>| {
                let deformed = Vector3::from_fn(|i, _| stretches[i] * a[i]);
                (1.0 - k.dot(a).cos()) / deformed.norm_squared()
            };
            vec![Complex::new(short.iter().map(spring).sum(), 0.0)]
        }
    }

    fn names(kind: LatticeKind, stretches: [f64; 3]) -> Vec<String> {
        let problem = problem(kind);
        let analysis = &*problem.analysis;
        let waves = springs(analysis, stretches);
        let symmetry = SymmetryPoints::new(analysis, None, waves);
        let path = symmetry.path();
        let visited = |name: &str| path.0.iter().flatten().any(|stop| stop.name == name);
        assert!(symmetry.points.iter().all(|point| visited(&point.name)));
        symmetry
            .points
            .into_iter()
            .map(|point| point.name)
            .collect()
    }

    #[test]
    fn symmetry_points_are_distinguished_if_the_state_breaks_the_symmetry() {
        assert_eq!(names(LatticeKind::Square, [1.0; 3]), ["Γ", "X", "M"]);
        assert_eq!(
            names(LatticeKind::Square, [1.2, 1.0, 1.0]),
            ["Γ", "X", "X′", "M"]
        );
        assert_eq!(names(LatticeKind::Hexagonal, [1.0; 3]), ["Γ", "M", "K"]);
        let hexagonal = names(LatticeKind::Hexagonal, [1.2, 1.0, 1.0]);
        // Two of the three midpoints of edges are mirror images; all corners are opposite or equal up to reciprocal vectors.
        assert_eq!(hexagonal, ["Γ", "M", "M′", "K"]);
        assert_eq!(
            names(LatticeKind::SimpleCubic, [1.0; 3]),
            ["Γ", "X", "M", "R"]
        );
        let orthorhombic = names(LatticeKind::SimpleCubic, [1.1, 1.0, 0.9]);
        assert_eq!(orthorhombic, ["Γ", "X", "X′", "X′′", "M", "M′", "M′′", "R"]);
        assert_eq!(names(LatticeKind::Chain, [1.3; 3]), ["Γ", "X"]);
    }

    #[test]
    fn typed_paths_have_labels_points_and_jumps() {
        let problem = problem(LatticeKind::Hexagonal);
        let analysis = &*problem.analysis;
        let waves = springs(analysis, [1.0; 3]);
        let symmetry = SymmetryPoints::new(analysis, None, waves);
        let told = |text: &str| -> Vec<Vec<String>> {
            let path = symmetry.typed(text).unwrap();
            let names = |chain: &Vec<Stop>| chain.iter().map(|s| s.name.clone()).collect();
            path.0.iter().map(names).collect()
        };
        assert_eq!(told("G-M-K-G"), [["Γ", "M", "K", "Γ"]]);
        assert_eq!(told("Γ–M|K-G"), [["Γ", "M"], ["K", "Γ"]]);
        assert_eq!(
            told("0,0; 0.5,0; 0.1,0.2; K"),
            [["Γ", "M", "(0.1,0.2)", "K"]]
        );
        for wrong in [
            "G",
            "",
            "G-Q",
            "0,0;1",
            "0,0,0;1,1,1",
            "study.toml",
            "0,0;x,1",
        ] {
            assert!(symmetry.typed(wrong).is_err(), "{wrong}");
        }
    }
}
