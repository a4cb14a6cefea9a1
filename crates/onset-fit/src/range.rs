//! States at which a law must be stable, and the worst of them.

use crate::family::Family;
use crate::moduli::{COARSE_STEP, Criterion, LEAST_STEP, PAIRS, Perturbation, isochoric_basis};
use crate::solve::Cut;
use crate::tests_of_specimens::Test;
use rayon::prelude::*;
use serde::Serialize;

/// Loading of a specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// Tension or compression along one axis.
    Uniaxial,
    /// Equal tension or compression along two axes.
    Equibiaxial,
    /// Tension or compression of a wide sheet whose width is held (pure shear).
    Planar,
    /// Simple shear of a block.
    SimpleShear,
    /// Pure change of volume.
    Volumetric,
}

impl Mode {
    /// All loadings of specimens, in the order of answers.
    pub const ALL: [Self; 5] = [
        Self::Uniaxial,
        Self::Equibiaxial,
        Self::Planar,
        Self::SimpleShear,
        Self::Volumetric,
    ];

    /// Loadings with a free face whose states are known for every incompressible specimen.
    pub const LOADINGS: [Self; 3] = [Self::Uniaxial, Self::Equibiaxial, Self::Planar];

    /// Name of the loading in files and answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Equibiaxial => "equibiaxial",
            Self::Planar => "planar",
            Self::SimpleShear => "simple-shear",
            Self::Volumetric => "volumetric",
        }
    }

    /// Quantity that the tests of this loading measure: stretches, amounts of shear or volume ratios.
    pub fn measures(self) -> &'static str {
        match self {
            Self::SimpleShear => "amounts of shear",
            Self::Volumetric => "volume ratios",
            _ => "stretches",
        }
    }

    /// Returns the loading with the given name, or `None`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.name() == name)
    }

    /// Logarithms of the principal stretches of an incompressible specimen, for `ln lambda = 1`.
    pub(crate) fn direction(self) -> [f64; 3] {
        match self {
            Self::Uniaxial => [1.0, -0.5, -0.5],
            Self::Equibiaxial => [1.0, 1.0, -2.0],
            Self::Planar | Self::SimpleShear => [1.0, 0.0, -1.0],
            Self::Volumetric => [1.0 / 3.0; 3],
        }
    }

    /// Logarithms of the principal stretches of an incompressible specimen; `stretch` is the amount of shear `gamma` in simple shear.
    pub fn logs(self, stretch: f64) -> [f64; 3] {
        let h = match self {
            Self::SimpleShear => (0.5 * stretch).asinh(),
            _ => stretch.ln(),
        };
        self.direction().map(|part| part * h)
    }

    /// Nominal stress per difference of the Kirchhoff stresses along the axes 1 and 3: `1/lambda`, and `1/sqrt(4 + gamma^2)` in simple shear.
    pub(crate) fn nominal(self, stretch: f64) -> f64 {
        match self {
            Self::SimpleShear => (4.0 + stretch * stretch).sqrt().recip(),
            _ => stretch.recip(),
        }
    }
}

/// States at which a fitted law must be stable.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Range {
    /// All states whose principal stretches are between the smallest and the largest stretch of the tests, widened by a factor; for incompressible
    /// response no stretch exceeds the largest stretch of the tests.
    Data(f64),
    /// All states with principal stretches between two limits.
    Box(f64, f64),
    /// Uniaxial, equibiaxial and planar loadings between two stretches, as Abaqus checks them.
    Loadings(f64, f64),
}

/// Part of a range: states `sum_a t_a axes[a]` of the logarithmic strains with `low_a < t_a < high_a`.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    pub axes: Vec<[f64; 3]>,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// Whether only states with stretches in descending order belong to the patch; all other states are permutations of these.
    pub ordered: bool,
}

impl Patch {
    /// Logarithmic strains of a state.
    pub fn logs(&self, at: &[f64]) -> [f64; 3] {
        std::array::from_fn(|i| self.axes.iter().zip(at).map(|(axis, t)| axis[i] * t).sum())
    }

    /// Parameters of a grid point, with `count` points along each axis.
    fn place(&self, n: usize, count: usize) -> Vec<f64> {
        let at = |a: usize| {
            let t = (n / count.pow(a as u32) % count) as f64 / (count - 1) as f64;
            self.low[a] + (self.high[a] - self.low[a]) * t
        };
        (0..self.axes.len()).map(at).collect()
    }

    /// Returns true if a state at constant volume with descending stretches belongs to the patch.
    fn reaches(&self, logs: [f64; 3]) -> bool {
        // Parameters of the state: for a line the coordinate along its axis, for a plane the largest strain and the negative of the smallest strain.
        let at = match self.axes.as_slice() {
            [axis] => vec![logs[0] / axis[0]],
            _ => vec![logs[0], -logs[2]],
        };
        let own = self.logs(&at);
        let is_same = logs.iter().zip(own).all(|(a, b)| (a - b).abs() < 1e-9);
        let mut ends = at.iter().zip(self.low.iter().zip(&self.high));
        is_same && ends.all(|(t, (low, high))| (low..=high).contains(&t))
    }

    fn contains(&self, at: &[f64]) -> bool {
        let [a, b, c] = self.logs(at);
        let slack = 1e-12;
        !self.ordered || (a >= b - slack && b >= c - slack)
    }
}

impl Range {
    /// Limits of the principal stretches for given tests.
    pub fn stretches(&self, tests: &[Test], compressible: bool) -> [f64; 2] {
        match *self {
            Self::Box(low, high) | Self::Loadings(low, high) => [low, high],
            Self::Data(factor) => {
                let mut ends = [1.0_f64; 2];
                for test in tests.iter().filter(|test| test.mode != Mode::Volumetric) {
                    for point in &test.points {
                        let stretches = match (test.mode, point.lateral) {
                            (Mode::SimpleShear, _) | (_, None) => {
                                test.mode.logs(point.stretch).map(f64::exp)
                            }
                            (_, Some(lateral)) => [point.stretch, lateral, 1.0],
                        };
                        for stretch in stretches {
                            ends = [ends[0].min(stretch), ends[1].max(stretch)];
                        }
                    }
                }
                let high = ends[1] * factor;
                match compressible {
                    true => [ends[0] / factor, high],
                    false => [high.powi(-2), high],
                }
            }
        }
    }

    /// Parts of the range.
    pub(crate) fn patches(&self, tests: &[Test], compressible: bool) -> Vec<Patch> {
        let [low, high] = self.stretches(tests, compressible).map(f64::ln);
        if let Self::Loadings(..) = self {
            let line = |mode: Mode| Patch {
                axes: vec![mode.direction()],
                low: vec![low],
                high: vec![high],
                ordered: false,
            };
            return Mode::LOADINGS.into_iter().map(line).collect();
        }
        if compressible {
            return vec![Patch {
                axes: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                low: vec![low; 3],
                high: vec![high; 3],
                ordered: true,
            }];
        }
        // Largest strain and the negative of the smallest strain; the third follows.
        vec![Patch {
            axes: vec![[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]],
            low: vec![0.0; 2],
            high: vec![high.min(-2.0 * low), (-low).min(2.0 * high)],
            ordered: true,
        }]
    }
}

/// State of a range at which a criterion has its lowest value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// Criterion with the lowest value.
    pub criterion: Criterion,
    /// Lowest value, relative to the value in the reference configuration.
    pub value: f64,
    /// Principal stretches of the state.
    pub stretches: [f64; 3],
    #[serde(skip)]
    pub(crate) logs: [f64; 3],
    #[serde(skip)]
    pub(crate) perturbation: Perturbation,
}

/// Law with numerical values of its constants.
#[derive(Clone, Copy)]
pub(crate) struct Numbers<'a> {
    pub family: &'a Family,
    pub constants: &'a [f64],
    pub criteria: &'a [Criterion],
}

impl Numbers<'_> {
    /// Shear modulus in the reference configuration.
    pub fn shear_modulus(&self) -> f64 {
        self.family.moduli(self.constants, [0.0; 3]).shear_modulus()
    }

    /// Lowest relative value of the criteria at a state. States beyond the locking of chains, at which the
    /// law has no energy, have an infinite value.
    pub fn worst_at(&self, logs: [f64; 3], shear: f64) -> Worst {
        self.worst_within(logs, shear, LEAST_STEP)
    }

    /// Like [`Self::worst_at`]; directions of waves are found within a smallest step.
    fn worst_within(&self, logs: [f64; 3], shear: f64, least_step: f64) -> Worst {
        let moduli = self.family.moduli(self.constants, logs);
        let compressible = self.family.is_compressible();
        let mut worst: Option<Worst> = None;
        for criterion in self.criteria {
            let (value, perturbation) = moduli.lowest(*criterion, compressible, least_step);
            let value = match value.is_nan() {
                true => f64::INFINITY,
                false => value / criterion.reference(shear.abs()),
            };
            if worst.as_ref().is_none_or(|own| value < own.value) {
                worst = Some(Worst {
                    criterion: *criterion,
                    value,
                    stretches: logs.map(f64::exp),
                    logs,
                    perturbation,
                });
            }
        }
        worst.unwrap_or(Worst {
            criterion: Criterion::Drucker,
            value: f64::INFINITY,
            stretches: [1.0; 3],
            logs,
            perturbation: Perturbation::Strain([0.0; 3]),
        })
    }
}

impl Criterion {
    /// Value in the reference configuration for a shear modulus.
    pub(crate) fn reference(self, shear: f64) -> f64 {
        match self {
            Self::Drucker => 2.0 * shear,
            Self::StrongEllipticity => shear,
        }
    }
}

/// Grid points of the initial constraints along an edge of a patch, and directions in each principal plane.
const FENCE_POINTS: usize = 9;
const FENCE_DIRECTIONS: usize = 6;

/// Constraints at a coarse grid of states and perturbations of a range.
pub(crate) fn fence(patches: &[Patch], criteria: &[Criterion], compressible: bool) -> Vec<Cut> {
    let mut cuts = Vec::new();
    for patch in patches {
        let dimension = patch.axes.len();
        for n in 0..FENCE_POINTS.pow(dimension as u32) {
            let place = patch.place(n, FENCE_POINTS);
            if !patch.contains(&place) {
                continue;
            }
            let logs = patch.logs(&place);
            for criterion in criteria {
                let perturbations = match criterion {
                    Criterion::Drucker => strains(compressible),
                    Criterion::StrongEllipticity => waves(logs),
                };
                cuts.extend(perturbations.into_iter().map(|perturbation| Cut {
                    criterion: *criterion,
                    logs,
                    perturbation,
                }));
            }
        }
    }
    cuts
}

/// Strain increments, without change of volume for incompressible response.
fn strains(compressible: bool) -> Vec<Perturbation> {
    let [a, b] = isochoric_basis();
    let angle = |n: usize| std::f64::consts::PI * n as f64 / FENCE_DIRECTIONS as f64;
    let turned = |n: usize| {
        let (sine, cosine) = angle(n).sin_cos();
        Perturbation::Strain(std::array::from_fn(|i| cosine * a[i] + sine * b[i]))
    };
    let dilation = compressible.then(|| Perturbation::Strain([3.0_f64.sqrt().recip(); 3]));
    (0..FENCE_DIRECTIONS).map(turned).chain(dilation).collect()
}

/// Transverse waves with normals in the principal planes, polarized in the plane and normal to it.
fn waves(logs: [f64; 3]) -> Vec<Perturbation> {
    let mut all = Vec::new();
    for (i, j) in PAIRS {
        for n in 0..FENCE_DIRECTIONS {
            let angle = std::f64::consts::FRAC_PI_2 * (n as f64 + 0.5) / FENCE_DIRECTIONS as f64;
            let mut normal = [0.0; 3];
            (normal[i], normal[j]) = (angle.cos(), angle.sin());
            for sign in [1.0, -1.0] {
                normal[j] = sign * angle.sin();
                // Polarization normal to F^-T N.
                let mut inside = [0.0; 3];
                (inside[i], inside[j]) = (-normal[j] / logs[j].exp(), normal[i] / logs[i].exp());
                let size = inside[i].hypot(inside[j]);
                inside.iter_mut().for_each(|own| *own /= size);
                all.push(Perturbation::Wave(normal, inside));
            }
            let mut across = [0.0; 3];
            across[3 - i - j] = 1.0;
            all.push(Perturbation::Wave(normal, across));
        }
    }
    all
}

/// Grid points along the edge of a patch with one, two and three parameters.
const POINTS: [usize; 3] = [301, 41, 9];
/// Number of local minima of a grid that are refined.
const IMPROVED: usize = 8;

/// Distances from a minimum to the states around it, as fractions of the grid spacing.
const AROUND: [f64; 3] = [0.5, 0.125, 0.03];

/// Local minima of the criteria over parts of a range, the lowest first.
pub(crate) fn worst_states(law: &Numbers<'_>, patches: &[Patch]) -> Vec<Worst> {
    low_states(law, patches, f64::NEG_INFINITY)
}

/// Local minima of the criteria over parts of a range, the lowest first, with the grid points and the states around minima that are below a value.
pub(crate) fn low_states(law: &Numbers<'_>, patches: &[Patch], below: f64) -> Vec<Worst> {
    low_states_of(law, patches, below, Sampling::ALL_POINTS)
}

/// Density of the samples of a range.
#[derive(Clone, Copy)]
pub(crate) struct Sampling {
    /// Every n-th grid point is used.
    part: usize,
    /// Number of local minima of the grid that are refined.
    improved: usize,
    /// Smallest step of the refinement, as a fraction of the grid spacing.
    smallest: f64,
}

impl Sampling {
    /// All grid points, for the final search.
    pub const ALL_POINTS: Self = Self {
        part: 1,
        improved: IMPROVED,
        smallest: 1e-4,
    };
    /// A quarter of the grid points, enough to find large unstable regions.
    pub const QUARTER: Self = Self {
        part: 2,
        improved: 3,
        smallest: 0.02,
    };
}

/// Like [`low_states`], for a given density of the samples.
pub(crate) fn low_states_of(
    law: &Numbers<'_>,
    patches: &[Patch],
    below: f64,
    sampling: Sampling,
) -> Vec<Worst> {
    let shear = law.shear_modulus();
    let mut found: Vec<Worst> = Vec::new();
    for patch in patches {
        let dimension = patch.axes.len();
        let count = (POINTS[dimension - 1] - 1) / sampling.part + 1;
        let place = |n: usize| patch.place(n, count);
        let total = count.pow(dimension as u32);
        let values: Vec<Option<Worst>> = (0..total)
            .into_par_iter()
            .map(|n| {
                let at = place(n);
                patch
                    .contains(&at)
                    .then(|| law.worst_within(patch.logs(&at), shear, COARSE_STEP))
            })
            .collect();
        let low = values.iter().flatten().filter(|own| own.value < below);
        let low: Vec<[f64; 3]> = low.map(|own| own.logs).collect();
        let exact = low.into_par_iter().map(|logs| law.worst_at(logs, shear));
        found.par_extend(exact);
        let value = |n: usize| values[n].as_ref().map_or(f64::INFINITY, |own| own.value);
        let is_low = |n: usize| {
            (0..dimension).all(|a| {
                let stride = count.pow(a as u32);
                let digit = n / stride % count;
                let below = digit == 0 || value(n - stride) >= value(n);
                let above = digit + 1 == count || value(n + stride) >= value(n);
                below && above
            })
        };
        let mut lows: Vec<usize> = (0..total)
            .filter(|n| values[*n].is_some() && is_low(*n))
            .collect();
        lows.sort_by(|a, b| value(*a).total_cmp(&value(*b)));
        for n in lows.into_iter().take(sampling.improved) {
            let steps: Vec<f64> = (0..dimension)
                .map(|a| 0.5 * (patch.high[a] - patch.low[a]) / (count - 1) as f64)
                .collect();
            let start = law.worst_at(patch.logs(&place(n)), shear);
            let (worst, middle) =
                improved(law, patch, shear, place(n), steps.clone(), start, sampling);
            if worst.value < below {
                for (a, part) in (0..dimension).flat_map(|a| AROUND.map(|part| (a, part))) {
                    for sign in [1.0, -1.0] {
                        let mut at = middle.clone();
                        let moved = at[a] + 2.0 * sign * part * steps[a];
                        at[a] = moved.clamp(patch.low[a], patch.high[a]);
                        if patch.contains(&at) {
                            found.push(law.worst_at(patch.logs(&at), shear));
                        }
                    }
                }
            }
            found.push(worst);
        }
    }
    found.sort_by(|a, b| a.value.total_cmp(&b.value));
    found
}

/// Local minimum near a state, with its parameters, by a search along the axes of a patch.
fn improved(
    law: &Numbers<'_>,
    patch: &Patch,
    shear: f64,
    mut place: Vec<f64>,
    mut steps: Vec<f64>,
    mut best: Worst,
    sampling: Sampling,
) -> (Worst, Vec<f64>) {
    let dimension = place.len();
    let smallest = steps.iter().fold(0.0_f64, |a, b| a.max(*b)) * sampling.smallest;
    while steps.iter().any(|step| *step > smallest) {
        let mut moved = false;
        for n in 1..3_usize.pow(dimension as u32) {
            let trial: Vec<f64> = (0..dimension)
                .map(|a| {
                    let sign = [0.0, 1.0, -1.0][n / 3_usize.pow(a as u32) % 3];
                    (place[a] + sign * steps[a]).clamp(patch.low[a], patch.high[a])
                })
                .collect();
            if !patch.contains(&trial) {
                continue;
            }
            let found = law.worst_at(patch.logs(&trial), shear);
            if found.value < best.value {
                (best, place, moved) = (found, trial, true);
            }
        }
        if !moved {
            steps.iter_mut().for_each(|step| *step *= 0.5);
        }
    }
    (best, place)
}

/// End of the stable stretches along a loading of an incompressible specimen in tension. Compression passes through the states of another
/// loading in tension.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// Loading of the specimen.
    pub mode: Mode,
    /// Criterion that is violated.
    pub criterion: Criterion,
    /// Stretch at which the criterion is violated.
    pub stretch: f64,
}

/// Largest stretch of the loadings, as in the check of Abaqus.
const LARGEST_STRETCH: f64 = 10.0;
/// Number of states along a loading.
const ALONG: usize = 400;

/// Smallest stretches at which each criterion is violated in uniaxial, equibiaxial and planar tension up to stretch 10, by increasing stretch.
pub fn limits(family: &Family, constants: &[f64], criteria: &[Criterion]) -> Vec<Limit> {
    let mut all = Vec::new();
    for mode in Mode::LOADINGS {
        for criterion in criteria {
            let law = Numbers {
                family,
                constants,
                criteria: std::slice::from_ref(criterion),
            };
            let shear = law.shear_modulus();
            let at = |s: f64| {
                law.worst_at(mode.direction().map(|part| part * s), shear)
                    .value
            };
            let end = LARGEST_STRETCH.ln();
            let lost = (1..=ALONG)
                .map(|n| end * n as f64 / ALONG as f64)
                .find(|s| at(*s) <= 0.0);
            let Some(beyond) = lost else { continue };
            let (mut inside, mut outside) = (beyond - end / ALONG as f64, beyond);
            while outside - inside > 1e-12 {
                let middle = 0.5 * (inside + outside);
                match at(middle) <= 0.0 {
                    true => outside = middle,
                    false => inside = middle,
                }
            }
            all.push(Limit {
                mode,
                criterion: *criterion,
                stretch: outside.exp(),
            });
        }
    }
    all.sort_by(|a, b| a.stretch.total_cmp(&b.stretch));
    all
}

/// First state of a range in tension at which the chains of a law are fully extended; the stretch is the smallest of all loadings.
pub(crate) fn locked(family: &Family, constants: &[f64], range: &[Patch]) -> Option<(Mode, f64)> {
    let first = family.locking(constants)?;
    let invariant = |logs: [f64; 3]| logs.iter().map(|log| (2.0 * log).exp()).sum::<f64>() - 3.0;
    let at = |mode: Mode| {
        let logs = |h: f64| mode.direction().map(|part| part * h);
        let (mut inside, mut outside) = (0.0, LARGEST_STRETCH.ln());
        while invariant(logs(outside)) < first {
            (inside, outside) = (outside, 2.0 * outside);
        }
        while outside - inside > 1e-12 * outside {
            let middle = 0.5 * (inside + outside);
            match invariant(logs(middle)) < first {
                true => inside = middle,
                false => outside = middle,
            }
        }
        let is_inside = range.iter().any(|patch| patch.reaches(logs(inside)));
        is_inside.then(|| (mode, inside.exp()))
    };
    let all = Mode::LOADINGS.into_iter().filter_map(at);
    all.min_by(|a, b| a.1.total_cmp(&b.1))
}

impl Family {
    /// Nominal stress of an incompressible specimen along the load; `None` for compressible laws and volumetric loading. Units of stress.
    pub fn stress(&self, constants: &[f64], mode: Mode, stretch: f64) -> Option<f64> {
        if self.is_compressible() || mode == Mode::Volumetric {
            return None;
        }
        let stresses = self.stresses(constants, mode.logs(stretch));
        Some(mode.nominal(stretch) * (stresses[0] - stresses[2]))
    }

    /// Returns true if the given criteria hold at a state of a loading.
    pub fn is_stable(
        &self,
        constants: &[f64],
        criteria: &[Criterion],
        mode: Mode,
        stretch: f64,
    ) -> bool {
        self.is_stable_at(constants, criteria, mode.logs(stretch))
    }

    /// Returns true if the given criteria hold at a state, described by the logarithms of its principal stretches.
    pub fn is_stable_at(&self, constants: &[f64], criteria: &[Criterion], logs: [f64; 3]) -> bool {
        let law = Numbers {
            family: self,
            constants,
            criteria,
        };
        law.worst_at(logs, law.shear_modulus()).value > 0.0
    }
}
