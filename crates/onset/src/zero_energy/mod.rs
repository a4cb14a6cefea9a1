//! Zero-energy modes of a method: the wave vectors at which the strain operator has a kernel. They depend neither on the material nor on the state.
//!
//! The zone is divided into parts. A part needs no further division if bounds on the strain operator exclude such a wave vector, or if it lies in the
//! neighborhood of a root of Newton's method that is provably the only one there. Lines of zero-energy modes are traced from one of their wave
//! vectors. Next to lines and surfaces the division ends at a small size.

mod places;
mod root;

use crate::algebra::{Complex, Each, array_of, sort_by_value};
use crate::lattice::{BrillouinZone, Crystal, WAVE_VECTOR_ERROR, shorter_first};
use crate::scheme::{Singular, StrainOperator, StrainRows};
use nalgebra::{DMatrix, SVector};
use places::Places;
use root::Root;
use std::collections::VecDeque;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Sizes of parts of the zone, in units of the reciprocal vectors: of the first parts, of parts in which Newton's method starts, of parts in which
/// lines and surfaces need no further search, and of the smallest parts.
const FIRST_PART: f64 = 0.25;
const NEWTON_PART: f64 = 0.13;
const LINE_PARTS: [f64; 3] = [1.0 / 256.0, 1.0 / 128.0, 1.0 / 64.0];
const SMALLEST_PART: f64 = 1e-9;
/// Distance within which roots are identified with a nearby root with vanishing slopes, in units of the shortest reciprocal vector.
const MULTIPLE_ROOT_DISTANCE: f64 = 0.02;
/// Distance, in units of the reciprocal vectors, within which roots are rounded to a wave vector with coordinates that are multiples of
/// `ROUNDING_FRACTION`. Multiple roots are known only to the square root of the rounding error.
const ROUNDING_DISTANCE: f64 = 1e-4;
const ROUNDING_FRACTION: f64 = 1.0 / 24.0;
/// Distance at which the continuation of a root is tested, in units of the shortest reciprocal vector.
const CONTINUATION_DISTANCE: f64 = 0.02;
/// Length of the steps along a line, in units of the smallest parts next to it, and largest correction of a step, relative to its length.
const STRIDE: f64 = 2.0;
const LARGEST_CORRECTION: f64 = 0.45;
/// Fraction of the reciprocal vectors whose multiples are the wave vectors of high symmetry, where lines often meet.
const SYMMETRIC: f64 = 0.25;
/// Sine of the smallest angle between directions that count as different.
const LEAST_SINE: f64 = 0.1;
/// Distance within which a wave vector is identified with a zero-energy mode, in units of the reciprocal vectors.
const POINT_DISTANCE: f64 = 1e-3;
/// Largest strain of a zero-energy mode, relative to its amplitude, if the wave vector is known to the square root of rounding.
const ZERO_STRAIN: f64 = 1e-4;
/// Largest cost of the division, in units of one evaluation of the sums; a few seconds.
const BUDGET: f64 = 2e8;
/// Fraction of the budget that remains for roots in the last parts.
const LAST_PARTS_BUDGET: f64 = 0.1;
/// Cost of Newton's method and of evaluating the root, in units of one matrix.
const NEWTON_COST: f64 = 6.0;
/// Largest distance between wave vectors of a line or surface that count as neighbors, in units of the smallest parts next to it.
const NEIGHBORS: f64 = 6.0;
/// Number of descents to the shortest wave of a line or surface. They start at the shortest known roots.
const SHORTEST_STARTS: usize = 12;
/// Number of directions tested on a half circle around a root of a surface. Lines that cross do not pass through all of them.
const PLANE_DIRECTIONS: usize = 8;
/// Wave vectors without symmetry, in units of the reciprocal vectors.
const GENERIC_WAVE_VECTORS: [[f64; 3]; 3] = [
    [0.237_068_1, 0.396_871_4, 0.141_592_7],
    [0.414_213_6, 0.118_033_9, 0.302_775_6],
    [0.087_298_3, 0.267_949_2, 0.449_489_7],
];

/// Extent of a connected set of zero-energy modes in the zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Extent {
    /// The set is a single wave vector.
    Point,
    /// The set is a line of wave vectors, or several lines that meet.
    Line,
    /// The set is a surface in the zone of a three-dimensional body.
    Surface,
    /// The set contains every wave vector.
    Zone,
}

impl Extent {
    /// Name of the extent in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Line => "line",
            Self::Surface => "surface",
            Self::Zone => "zone",
        }
    }
}

/// Displacements of the particles of a cell in a mode.
pub(crate) type Displacements<const D: usize> = Vec<SVector<Complex, D>>;

/// Wave vector with zero-energy modes.
#[derive(Clone, Debug)]
pub(crate) struct ZeroMode<const D: usize> {
    pub(crate) wave_vector: SVector<f64, D>,
    pub(crate) extent: Extent,
    pub(crate) nullity: usize,
    /// Displacements of the particles of a cell in a basis of the zero-energy modes of this wave vector.
    pub(crate) span: Vec<Displacements<D>>,
}

/// All zero-energy modes, one of each pair `k` and `-k`: single wave vectors, and the shortest one of each line or surface.
#[derive(Clone, Debug)]
pub(crate) struct ZeroModes<const D: usize> {
    pub(crate) modes: Vec<ZeroMode<D>>,
    pub(crate) is_complete: bool,
}

/// Strains of plane waves at the quadrature points in the reference configuration.
#[derive(Clone, Debug)]
pub(crate) struct Strains<const D: usize> {
    crystal: Crystal<D>,
    pub(crate) rows: StrainRows<D>,
    /// Wave vectors of strain-free modes in which neighbors alternate, within a cell or between cells; 1/length.
    pub(crate) alternating: Vec<SVector<f64, D>>,
    modes: OnceLock<ZeroModes<D>>,
}

impl<const D: usize> Strains<D> {
    pub(crate) fn new(crystal: &Crystal<D>, strain: &StrainOperator<D>) -> Self {
        let rows = StrainRows::new(crystal, strain);
        let alternating = crystal.lattice().alternating().chain([SVector::zeros()]);
        Self {
            alternating: alternating.filter(|k| rows.has_zero_mode_at(k)).collect(),
            crystal: crystal.clone(),
            rows,
            modes: OnceLock::new(),
        }
    }

    /// All zero-energy modes. The first call searches the zone, which takes seconds for large cells.
    pub(crate) fn modes(&self) -> &ZeroModes<D> {
        self.modes
            .get_or_init(|| ZeroModes::new(&self.crystal, &self.rows))
    }

    /// Wave vectors that represent the zero-energy modes, if a wave is one of them; otherwise none.
    ///
    /// If the search of the zone is incomplete, the wave itself is included.
    pub(crate) fn modes_if_unstrained(&self, k: &SVector<f64, D>) -> Vec<SVector<f64, D>> {
        let rows = &self.rows;
        let own = match k.norm() > 0.0 {
            true => rows.zero_mode_near(k),
            false => rows.has_zero_mode_at(k).then_some(*k),
        };
        let Some(own) = own else {
            return Vec::new();
        };
        let ZeroModes { modes, is_complete } = self.modes();
        let known = modes.iter().map(|mode| mode.wave_vector);
        known.chain((!is_complete).then_some(own)).collect()
    }

    fn misses(&self, k: &SVector<f64, D>) -> bool {
        match k.norm() * self.rows.spacing < ZERO_STRAIN {
            true => self.rows.has_zero_mode_at(&SVector::zeros()),
            false => self.rows.misses(k, ZERO_STRAIN),
        }
    }

    /// Returns true if a wave vector of the first zone, known to the square root of rounding, has a zero-energy mode.
    ///
    /// The wave vector is then near a single wave vector with zero-energy modes, or its strain is small and lines, surfaces or an incomplete search
    /// allow a zero-energy mode. Other waves with small strain are weakly controlled.
    pub(crate) fn has_mode_at(
        &self,
        k: &SVector<f64, D>,
        distance: impl Fn(&SVector<f64, D>) -> f64,
    ) -> bool {
        let is_near = |mode: &ZeroMode<D>| match mode.extent {
            Extent::Point => distance(&mode.wave_vector) <= POINT_DISTANCE,
            _ => self.misses(k),
        };
        let ZeroModes { modes, is_complete } = self.modes();
        modes.iter().any(is_near) || !is_complete && self.misses(k)
    }
}

impl<const D: usize> ZeroModes<D> {
    fn new(crystal: &Crystal<D>, rows: &StrainRows<D>) -> Self {
        let zone = BrillouinZone::new(*crystal.lattice());
        let folded = |k: &SVector<f64, D>| zone.folded(k);
        let mut search = Search::new(crystal, rows);
        let (mut modes, mut is_complete) = (Vec::new(), true);
        match search.everywhere() {
            Some(mode) => modes.push(mode),
            None => {
                is_complete = search.divide();
                modes.extend(search.modes(&folded));
            }
        }
        Self { modes, is_complete }
    }

    /// Largest extent of the zero-energy modes; `None` if there are no such modes.
    pub(crate) fn extent(&self) -> Option<Extent> {
        self.modes.iter().map(|mode| mode.extent).max()
    }
}

/// Wave vector of a line or surface.
#[derive(Clone, Copy)]
struct Place<const D: usize> {
    wave_vector: SVector<f64, D>,
    extent: Extent,
}

/// Box of the zone, in units of the reciprocal vectors.
#[derive(Clone, Copy)]
struct Part<const D: usize> {
    center: SVector<f64, D>,
    half: SVector<f64, D>,
}

struct Search<'a, const D: usize> {
    crystal: &'a Crystal<D>,
    rows: &'a StrainRows<D>,
    /// Length of the shortest reciprocal vector.
    shortest: f64,
    isolated: Vec<Root<D>>,
    continued: Vec<Place<D>>,
    continued_places: Places<D>,
    surface_places: Places<D>,
    spent: f64,
}

impl<'a, const D: usize> Search<'a, D> {
    fn new(crystal: &'a Crystal<D>, rows: &'a StrainRows<D>) -> Self {
        let reciprocal = crystal.lattice().reciprocal().column_iter();
        Self {
            crystal,
            rows,
            shortest: reciprocal.map(|b| b.norm()).fold(f64::INFINITY, f64::min),
            isolated: Vec::new(),
            continued: Vec::new(),
            continued_places: Places::new(crystal.lattice()),
            surface_places: Places::new(crystal.lattice()),
            spent: 0.0,
        }
    }

    fn wave_vector(&self, fractional: &SVector<f64, D>) -> SVector<f64, D> {
        self.crystal.lattice().reciprocal() * fractional
    }

    /// Shortest difference of two wave vectors, up to their signs and reciprocal vectors.
    fn way(&self, from: &SVector<f64, D>, to: &SVector<f64, D>) -> SVector<f64, D> {
        let nearest = |difference: SVector<f64, D>| {
            let x = self.crystal.lattice().fractional(&difference);
            self.wave_vector(&x.map(|x| x - x.round()))
        };
        let [ahead, opposite] = [nearest(to - from), nearest(-to - from)];
        if opposite.norm() < ahead.norm() {
            opposite
        } else {
            ahead
        }
    }

    fn distance(&self, a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
        self.way(a, b).norm()
    }

    /// Zero-energy mode that exists at all wave vectors. Since `R` is analytic, three generic wave vectors decide.
    fn everywhere(&self) -> Option<ZeroMode<D>> {
        let at = |place: &[f64; 3]| {
            let k = self.wave_vector(&SVector::from_fn(|i, _| place[i]));
            self.rows.root(&k)
        };
        let roots: Vec<Root<D>> = GENERIC_WAVE_VECTORS.iter().map(at).collect::<Option<_>>()?;
        let nullity = roots.iter().map(|root| root.kernel.ncols()).min()?;
        let k = self.wave_vector(&SVector::repeat(0.5));
        let shown = self.rows.root(&k)?;
        Some(ZeroMode {
            wave_vector: k,
            extent: Extent::Zone,
            nullity: nullity * self.rows.modes_per_column(),
            span: self.span(&shown),
        })
    }

    /// Divides half of the zone until every part is decided. Returns true if this succeeds within the budget.
    fn divide(&mut self) -> bool {
        self.add_symmetric();
        let mut parts: VecDeque<Part<D>> = self.first().into();
        let mut is_complete = true;
        // Once the budget is spent, roots are searched for in every n-th part, all over the zone.
        let (mut every, mut turn) = (None, 0_usize);
        while let Some(part) = parts.pop_front() {
            if self.is_known(&part) {
                continue;
            }
            let center = self.wave_vector(&part.center);
            let edges = self.edges(&part);
            self.spent += self.rows.cost();
            if self.rows.is_regular(&center, &edges) {
                continue;
            }
            let is_last = self.spent > BUDGET;
            let radius: f64 = edges.iter().map(|edge| edge.norm()).sum();
            let is_small = part.half.amax() <= LINE_PARTS[D - 1];
            // Next to a line or surface only small parts can be decided.
            let is_followed = self.continued_places.has_within(radius, &center);
            if is_followed && is_small {
                continue;
            }
            let is_in_turn = !is_last || {
                let every = *every.get_or_insert_with(|| self.sought_of(parts.len()));
                turn += 1;
                turn % every == 0
            };
            if !is_followed && is_in_turn && (part.half.amax() <= NEWTON_PART || is_last) {
                let continues = self.sought(&center, 3.0 * radius);
                if continues && is_small {
                    continue;
                }
            }
            if is_last || part.half.amax() < SMALLEST_PART {
                is_complete &= self.is_known(&part);
                continue;
            }
            parts.extend(self.halves(&part, &edges));
        }
        is_complete
    }

    /// Adds the roots at wave vectors of high symmetry.
    fn add_symmetric(&mut self) {
        let n = SYMMETRIC.recip().round() as usize;
        for index in 0..(n / 2 + 1) * n.pow(D as u32 - 1) {
            let mut rest = index;
            let mut place = SVector::zeros();
            for i in (0..D).rev() {
                place[i] = (rest % n) as f64 * SYMMETRIC;
                rest /= n;
            }
            let k = self.wave_vector(&place);
            self.spent += self.rows.cost();
            let is_known =
                |root: &Root<D>| self.distance(&root.wave_vector, &k) < 1e-6 * self.shortest;
            if !self.isolated.iter().any(is_known)
                && let Some(root) = self.rows.root(&k)
            {
                self.add(root);
            }
        }
    }

    /// Interval between searched parts at which the search of the remaining parts is affordable.
    fn sought_of(&self, parts: usize) -> usize {
        let affordable = LAST_PARTS_BUDGET * BUDGET / (NEWTON_COST * self.rows.cost());
        (parts as f64 / affordable.max(1.0)).ceil().max(1.0) as usize
    }

    /// Parts of the half of the zone with a first coordinate from 0 to 1/2.
    fn first(&self) -> Vec<Part<D>> {
        let n = FIRST_PART.recip().round() as usize;
        let half = 0.5 * FIRST_PART;
        let count = n.pow(D as u32) / 2;
        let part = |index: usize| {
            let mut rest = index;
            let mut center = SVector::zeros();
            for i in (0..D).rev() {
                center[i] = (rest % n) as f64 * FIRST_PART + half;
                rest /= n;
            }
            Part {
                center,
                half: SVector::repeat(half),
            }
        };
        (0..count).map(part).collect()
    }

    fn edges(&self, part: &Part<D>) -> [SVector<f64, D>; D] {
        let reciprocal = self.crystal.lattice().reciprocal();
        array_of(|i| reciprocal.column(i) * part.half[i])
    }

    /// Halves of a part, cut across the longest edge.
    fn halves(&self, part: &Part<D>, edges: &[SVector<f64, D>; D]) -> [Part<D>; 2] {
        let length = |i: &usize| edges[*i].norm();
        let longest = (0..D).max_by(|a, b| length(a).total_cmp(&length(b)));
        let axis = longest.unwrap_or(0);
        [-0.5, 0.5].each(|side| {
            let mut half = *part;
            half.center[axis] += side * part.half[axis];
            half.half[axis] *= 0.5;
            half
        })
    }

    /// Returns true if a part lies in the neighborhood of a root without other roots.
    fn is_known(&self, part: &Part<D>) -> bool {
        let radius: f64 = self.edges(part).iter().map(|edge| edge.norm()).sum();
        let center = self.wave_vector(&part.center);
        self.isolated.iter().any(|root| {
            root.alone_within > radius
                && self.distance(&root.wave_vector, &center) <= root.alone_within - radius
        })
    }

    /// Searches for a root near a wave vector. Returns true for a new root of a line or surface.
    fn sought(&mut self, start: &SVector<f64, D>, reach: f64) -> bool {
        self.spent += NEWTON_COST * self.rows.cost();
        let polished = self.rows.polished(start, reach);
        let Some(root) = polished.and_then(|k| self.rows.root(&self.rounded(k))) else {
            return false;
        };
        let is_known = self.isolated.iter().any(|known| {
            let near = known.alone_within.max(1e-6 * self.shortest);
            self.distance(&known.wave_vector, &root.wave_vector) < near
        });
        !is_known && self.add(root)
    }

    /// Rounds a wave vector to a multiple of `ROUNDING_FRACTION` if the strain there is no larger.
    fn rounded(&self, k: SVector<f64, D>) -> SVector<f64, D> {
        let place = self.crystal.lattice().fractional(&k);
        let simple = place.map(|x| (x / ROUNDING_FRACTION).round() * ROUNDING_FRACTION);
        let tried = self.wave_vector(&simple);
        let is_root = (place - simple).amax() < ROUNDING_DISTANCE
            && self.rows.smallest(&tried) <= self.rows.smallest(&k).max(1e-14);
        if is_root { tried } else { k }
    }

    /// Adds a root, with the lines through it. Returns true for a root of a line or surface, and false for isolated roots and crossings of lines.
    fn add(&mut self, mut root: Root<D>) -> bool {
        let k = root.wave_vector;
        let ways = root.flat.iter().flat_map(|way| [*way, -way]);
        let ways: Vec<SVector<f64, D>> = ways.filter(|way| self.goes_on(&k, way)).collect();
        if !ways.is_empty() && self.is_on_surface(&root) {
            self.surface_places.add(&k);
            self.add_place(k, Extent::Surface);
            return true;
        }
        // At a crossing of lines, slopes also vanish in directions without a line.
        let is_on_line = !ways.is_empty() && pairs_of(&root.flat).next().is_none();
        if is_on_line {
            self.add_place(k, Extent::Line);
        } else {
            if !root.flat.is_empty() {
                root.alone_within = MULTIPLE_ROOT_DISTANCE * self.shortest;
            }
            self.isolated.push(root);
        }
        for way in ways {
            self.follow(k, way);
        }
        is_on_line
    }

    fn add_place(&mut self, wave_vector: SVector<f64, D>, extent: Extent) {
        self.continued_places.add(&wave_vector);
        self.continued.push(Place {
            wave_vector,
            extent,
        });
    }

    /// Follows a line from a root along a direction, up to known roots.
    fn follow(&mut self, mut k: SVector<f64, D>, mut way: SVector<f64, D>) {
        let longest = STRIDE * LINE_PARTS[D - 1] * self.shortest;
        while self.spent <= BUDGET {
            let sizes = [1.0, 0.5, 0.25].map(|share| share * longest);
            self.spent += NEWTON_COST * self.rows.cost();
            let step = sizes.into_iter().find_map(|size| {
                let next = self
                    .rows
                    .polished(&(k + way * size), LARGEST_CORRECTION * size)?;
                Some((next, size))
            });
            let Some((next, _)) = step.filter(|(next, size)| {
                !self
                    .continued_places
                    .has_within(LARGEST_CORRECTION * size, next)
            }) else {
                return;
            };
            way = (next - k).normalize();
            k = next;
            self.add_place(k, Extent::Line);
        }
    }

    /// Returns true if further roots exist close to a root along a direction.
    fn goes_on(&self, k: &SVector<f64, D>, way: &SVector<f64, D>) -> bool {
        let far = CONTINUATION_DISTANCE * self.shortest;
        self.rows.polished(&(k + way * far), 0.5 * far).is_some()
    }

    /// Returns true if a root is part of a surface: there are roots along every direction of a plane. Crossing lines have roots along some directions only.
    fn is_on_surface(&self, root: &Root<D>) -> bool {
        let near = NEIGHBORS * LINE_PARTS[D - 1] * self.shortest;
        let k = &root.wave_vector;
        let mut pairs = pairs_of(&root.flat);
        D == 3
            && pairs
                .any(|(a, b)| self.surface_places.has_within(near, k) || self.has_plane(k, &a, &b))
    }

    /// Returns true if roots exist in all directions around a root in the plane of two directions.
    fn has_plane(&self, k: &SVector<f64, D>, a: &SVector<f64, D>, b: &SVector<f64, D>) -> bool {
        let across = (b - a * a.dot(b)).normalize();
        let far = CONTINUATION_DISTANCE * self.shortest;
        (0..PLANE_DIRECTIONS).all(|n| {
            let (sine, cosine) = (PI * n as f64 / PLANE_DIRECTIONS as f64).sin_cos();
            let beside = k + (a * cosine + across * sine) * far;
            self.rows.polished(&beside, 0.15 * far).is_some()
        })
    }

    /// Returns true if a root with vanishing slopes belongs to a line or surface: more roots lie between it and the nearest root of a line.
    ///
    /// At a crossing of lines, slopes also vanish in directions without a line.
    fn is_on_line(&self, root: &Root<D>) -> bool {
        let others = self.continued.iter();
        let ways = others.map(|other| self.way(&root.wave_vector, &other.wave_vector));
        let nearest = ways.min_by(|a, b| a.norm().total_cmp(&b.norm()));
        let is_between = |way: &SVector<f64, D>| {
            let halfway = root.wave_vector + way * 0.5;
            self.rows.polished(&halfway, 0.25 * way.norm()).is_some()
        };
        !root.flat.is_empty() && nearest.as_ref().is_some_and(is_between)
    }

    /// Zero-energy mode of a root, excluding rigid translations at `k = 0`; `None` if no mode remains.
    fn mode(&self, root: &Root<D>, extent: Extent) -> Option<ZeroMode<D>> {
        let at_rest = root.wave_vector.norm() == 0.0;
        let translations = if at_rest { D } else { 0 };
        let free = root.kernel.ncols() * self.rows.modes_per_column();
        let nullity = free.checked_sub(translations).filter(|free| *free > 0)?;
        let span = if at_rest {
            self.without_translations(root)
        } else {
            self.span(root)
        };
        Some(ZeroMode {
            wave_vector: root.wave_vector,
            extent,
            nullity,
            span,
        })
    }

    /// Isolated modes, and the shortest wave of each connected line or surface; points first, then by wavelength.
    fn modes(&self, folded: &impl Fn(&SVector<f64, D>) -> SVector<f64, D>) -> Vec<ZeroMode<D>> {
        let isolated = self.isolated.iter();
        let (crossings, alone): (Vec<_>, Vec<_>) = isolated.partition(|root| self.is_on_line(root));
        let alone = alone.into_iter();
        let alone = alone.filter_map(|root| self.mode(root, Extent::Point));
        let mut modes: Vec<ZeroMode<D>> = alone.collect();
        let crossings = crossings.into_iter().map(|root| Place {
            wave_vector: root.wave_vector,
            extent: Extent::Line,
        });
        for set in connected(
            self.crystal,
            self.continued.iter().copied().chain(crossings),
        ) {
            modes.extend(self.shortest(&set, folded));
        }
        let length = |mode: &ZeroMode<D>| folded(&mode.wave_vector).norm();
        modes.sort_by(|a, b| {
            let order = a.extent.cmp(&b.extent);
            order.then(length(a).total_cmp(&length(b)))
        });
        modes
    }

    /// Shortest wave vector of a connected line or surface, by descents from its shortest known roots.
    fn shortest(
        &self,
        set: &[Place<D>],
        folded: &impl Fn(&SVector<f64, D>) -> SVector<f64, D>,
    ) -> Option<ZeroMode<D>> {
        let extent = set.iter().map(|place| place.extent).max()?;
        let mut places: Vec<SVector<f64, D>> = set.iter().map(|place| place.wave_vector).collect();
        sort_by_value(&mut places, |k| folded(k).norm());
        let found = places.into_iter().take(SHORTEST_STARTS).filter_map(|k| {
            let root = self.rows.root(&self.rounded(k))?;
            let bottom = self.descended(root, folded);
            Some((folded(&bottom.wave_vector), self.mode(&bottom, extent)?))
        });
        let rounding = |k: &SVector<f64, D>| WAVE_VECTOR_ERROR * k.norm();
        let first = found.min_by(|a, b| shorter_first(&a.0, &b.0, rounding(&a.0)));
        first.map(|(_, mode)| mode)
    }

    /// Root with the locally shortest wave vector, by descent along the line or surface of a root.
    fn descended(
        &self,
        mut best: Root<D>,
        folded: &impl Fn(&SVector<f64, D>) -> SVector<f64, D>,
    ) -> Root<D> {
        let mut size = CONTINUATION_DISTANCE * self.shortest;
        while size > 1e-9 * self.shortest {
            let k = folded(&best.wave_vector);
            let parts = best
                .flat
                .iter()
                .map(|direction| direction * direction.dot(&k));
            let way = -parts.sum::<SVector<f64, D>>();
            let length = way.norm();
            if length <= 1e-12 * self.shortest {
                break;
            }
            let step = way * (size.min(length) / length);
            let next = self.rows.polished(&(k + step), step.norm());
            let next = next.and_then(|next| self.rows.root(&self.rounded(next)));
            match next.filter(|next| folded(&next.wave_vector).norm() < k.norm() * (1.0 - 1e-14)) {
                Some(next) => best = next,
                None => size *= 0.5,
            }
        }
        best
    }

    /// Modes at `k = 0` that are orthogonal to the translations.
    fn without_translations(&self, root: &Root<D>) -> Vec<Displacements<D>> {
        let mut rest = root.kernel.clone();
        for mut column in rest.column_iter_mut() {
            for i in 0..D {
                let own = (i..column.len()).step_by(D);
                let count = Complex::from(own.len() as f64);
                let mean = own.clone().map(|row| column[row]).sum::<Complex>() / count;
                own.for_each(|row| column[row] -= mean);
            }
        }
        // The basis is orthonormal: singular values are zero or one.
        let Some(singular) = Singular::of(rest) else {
            return Vec::new();
        };
        let count = singular.values.iter().filter(|value| **value > 0.5).count();
        let basis = singular.range(singular.values.len() - count).into_owned();
        (0..count).map(|n| self.of_particles(&basis, n)).collect()
    }

    /// Displacements of the particles of a cell in a basis of the modes of a root.
    fn span(&self, root: &Root<D>) -> Vec<Displacements<D>> {
        if self.rows.columns() == 1 {
            // A single particle can have any displacement.
            let entry = |is_axis: bool| Complex::new(f64::from(u8::from(is_axis)), 0.0);
            let along = |axis: usize| vec![SVector::from_fn(|i, _| entry(i == axis))];
            return (0..D).map(along).collect();
        }
        let columns = 0..root.kernel.ncols();
        columns
            .map(|column| self.of_particles(&root.kernel, column))
            .collect()
    }

    fn of_particles(&self, kernel: &DMatrix<Complex>, column: usize) -> Vec<SVector<Complex, D>> {
        let sites = self.crystal.sites().len();
        let entry = |site: usize, i: usize| {
            let row = D * site + i;
            kernel.get((row, column)).copied().unwrap_or_default()
        };
        (0..sites)
            .map(|site| SVector::from_fn(|i, _| entry(site, i)))
            .collect()
    }
}

/// Pairs of different directions.
fn pairs_of<const D: usize>(
    ways: &[SVector<f64, D>],
) -> impl Iterator<Item = (SVector<f64, D>, SVector<f64, D>)> {
    let pairs = (0..ways.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let pairs = pairs.map(|(i, j)| (ways[i], ways[j]));
    pairs.filter(|(a, b)| (b - a * a.dot(b)).norm() > LEAST_SINE)
}

/// Connected sets of the wave vectors of lines and surfaces.
fn connected<const D: usize>(
    crystal: &Crystal<D>,
    places: impl Iterator<Item = Place<D>>,
) -> Vec<Vec<Place<D>>> {
    let beside = |a: &Place<D>, b: &Place<D>| {
        let is_near = |difference: SVector<f64, D>| {
            let x = crystal.lattice().fractional(&difference);
            x.map(|x| x - x.round()).amax() <= NEIGHBORS * LINE_PARTS[D - 1]
        };
        is_near(a.wave_vector - b.wave_vector) || is_near(a.wave_vector + b.wave_vector)
    };
    let mut left: Vec<Place<D>> = places.collect();
    let mut sets = Vec::new();
    while let Some(first) = left.pop() {
        let mut set = vec![first];
        let mut next = 0;
        while next < set.len() {
            let own = set[next];
            let (joined, others) = left.into_iter().partition(|other| beside(&own, other));
            set.extend::<Vec<Place<D>>>(joined);
            left = others;
            next += 1;
        }
        sets.push(set);
    }
    sets
}
