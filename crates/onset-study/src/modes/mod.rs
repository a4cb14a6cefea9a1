//! Spurious modes of a method: listed, drawn on the lattice, animated, and exported as initial conditions of a simulation.

mod animation;
mod export;
mod figure;
mod fit;
mod view;

pub(crate) use animation::{STYLE, moving_particles};
pub use fit::Fit;

use crate::answers::{Evidence, Problem, ProblemError, notes};
use crate::brief::{Brief, Short};
use crate::methods::reduced;
use crate::number::{counted, told};
use crate::settings::{Effective, Settings};
use nalgebra::SVector;
use onset::algebra::Complex;
use onset::analysis::{Analysis, PatchParticle, ReducedCell};
use onset::measures::{Extent, SpuriousMode};
use onset::verdict::WEAK_WAVE_RATIO;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// Maximum number of particles of a patch.
const MAX_PARTICLES: f64 = 40_000.0;

/// Relative rounding error of the spacing of a cell.
const SPACING_ROUNDING: f64 = 1e-12;

/// Options for the list and the export of modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModesQuestion {
    /// Largest frequency of weak modes, relative to the slowest wave of the material.
    pub weak: f64,
    /// Number of cells of the patch along each primitive vector.
    pub cells: usize,
    /// The largest displacement of the exported fields, in particle spacings.
    pub amplitude: f64,
    /// Whether displacement fields are exported; if so, notes name the waves that do not fit the patch.
    pub is_exported: bool,
}

impl Default for ModesQuestion {
    fn default() -> Self {
        Self {
            weak: WEAK_WAVE_RATIO,
            cells: 8,
            amplitude: 0.2,
            is_exported: false,
        }
    }
}

/// Spurious modes of a method in the reference configuration.
#[derive(Clone, Debug, Serialize)]
pub struct ModesAnswer {
    /// Number of space dimensions.
    pub dimension: usize,
    /// The particle spacing; length.
    pub spacing: f64,
    /// Largest set formed by zero-energy modes (point, line, surface or zone); `None` without such modes.
    pub zero_extent: Option<Extent>,
    /// Whether all zero-energy modes have been found.
    pub complete: bool,
    /// Evidence that the list of zero-energy modes is complete: `bounded` if bounds on the strain decide every part of the zone, `searched` if parts
    /// are undecided.
    pub evidence: Evidence,
    /// Lowest relative frequency over the zone; `None` if the slowest waves of the material have zero frequency, like the shear waves of a fluid.
    pub weakest: Option<f64>,
    /// Modes, zero-energy modes first.
    pub modes: Vec<ShownMode>,
    /// Largest relative frequency of modes that are listed as weak.
    pub weak: f64,
    /// Number of cells of the patch along each primitive vector.
    pub cells: usize,
    /// Numbers of particles of the cell in the settings and of its smaller primitive cell; `null` if the cell is primitive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reduced_cell: Option<ReducedCell>,
    #[serde(skip)]
    is_exported: bool,
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// All settings in effect.
    pub settings: Effective,
}

/// Mode on a patch of particles.
#[derive(Clone, Debug, Serialize)]
pub struct ShownMode {
    /// The wave vector; 1/length.
    pub wave_vector: Vec<f64>,
    /// Wave vector in units of the reciprocal vectors.
    pub fractional: Vec<f64>,
    /// Wave vector of the material wave that the mode approximates. For a cell with several particles it differs from `wave_vector` by a reciprocal
    /// vector; 1/length.
    pub wave: Vec<f64>,
    /// `wave` in units of the reciprocal vectors; `None` if it equals `fractional`.
    #[serde(skip)]
    pub unfolded: Option<Vec<f64>>,
    /// Frequency relative to the slowest wave of the material.
    pub relative_frequency: f64,
    /// Number of independent zero-energy modes at this wave vector.
    pub nullity: usize,
    /// Set of zero-energy modes that contains the mode: point, line, surface or zone.
    pub extent: Extent,
    /// Whether the wave fits into the patch. If not, its displacement field jumps at the periodic boundary.
    pub fits: bool,
    /// Smallest patch that the wave fits into; for an incommensurate wave a small patch with the closest wave.
    pub fit: Fit,
    /// Positions of the particles of a patch, three coordinates each; length.
    #[serde(skip)]
    pub positions: Vec<[f64; 3]>,
    /// Displacements of the particles at the time of the largest displacement; length.
    #[serde(skip)]
    pub displacements: Vec<[f64; 3]>,
    /// Displacements of the particles a quarter of a period later; length.
    #[serde(skip)]
    pub quarter: Vec<[f64; 3]>,
}

impl ModesAnswer {
    /// Computes the spurious modes of the discretization in the reference configuration.
    ///
    /// # Errors
    /// [`ProblemError`] when material or method are invalid, or the patch is too large.
    pub fn new(settings: &Settings, question: &ModesQuestion) -> Result<Self, ProblemError> {
        let Problem {
            settings,
            material,
            analysis,
        } = Problem::new(settings.clone())?;
        let dimension = analysis.dimension();
        let particles = (question.cells as f64).powi(dimension as i32) * analysis.sites() as f64;
        if particles > MAX_PARTICLES {
            return Err(ProblemError::Patch {
                particles,
                admitted: MAX_PARTICLES,
            });
        }
        let found = analysis.spurious_modes(question.weak)?;
        let patch = analysis.patch(question.cells);
        Ok(Self {
            dimension,
            spacing: spacing(&*analysis, &settings),
            zero_extent: found.zero_extent,
            complete: found.is_complete,
            evidence: Evidence::of(false, found.is_complete),
            weakest: found.weakest,
            modes: found
                .modes
                .iter()
                .map(|mode| ShownMode::new(mode, &*analysis, &patch, question))
                .collect(),
            weak: question.weak,
            cells: question.cells,
            reduced_cell: reduced(&settings),
            is_exported: question.is_exported,
            notes: notes(&settings, &*material),
            settings: settings.effective(),
        })
    }
}

/// Particle spacing as it was set, unless the spacing of the cell differs by more than rounding.
fn spacing(analysis: &dyn Analysis, settings: &Settings) -> f64 {
    let (own, given) = (analysis.spacing(), settings.discretization.spacing);
    match (own - given).abs() <= SPACING_ROUNDING * given {
        true => given,
        false => own,
    }
}

impl ShownMode {
    fn new(
        mode: &SpuriousMode<3>,
        analysis: &dyn Analysis,
        patch: &[PatchParticle],
        question: &ModesQuestion,
    ) -> Self {
        let k = mode.wave_vector;
        let fractional = analysis.fractional(&k);
        let apart = (mode.wave - k).norm().min((mode.wave + k).norm());
        let is_folded = analysis.sites() > 1 && apart > 1e-6 * mode.wave.norm();
        // Phase at which the particle with the largest amplitude g is farthest out: g is rotated until g.g is real and positive.
        let square = |own: &SVector<Complex, 3>| own.iter().map(|z| z * z).sum::<Complex>();
        let most = mode
            .displacements
            .iter()
            .max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let time = most.map_or(0.0, |own| 0.5 * square(own).arg());
        // Real and imaginary part of g exp(i k.X): the mode at this time and a quarter of a period later.
        let turned = |particle: &PatchParticle| {
            let phase = k.dot(&particle.position) - time;
            mode.displacements[particle.site] * Complex::new(phase.cos(), phase.sin())
        };
        let largest = patch
            .iter()
            .map(|particle| turned(particle).map(|z| z.re).norm())
            .fold(f64::MIN_POSITIVE, f64::max);
        let scale = question.amplitude * analysis.spacing() / largest;
        let at = |is_quarter: bool| {
            let displaced = |particle| {
                let own = turned(particle);
                own.map(|z| scale * if is_quarter { z.im } else { z.re })
                    .into()
            };
            patch.iter().map(displaced).collect()
        };
        Self {
            wave_vector: k.iter().take(analysis.dimension()).copied().collect(),
            fits: Fit::is_whole(&fractional, question.cells),
            fit: Fit::smallest(&fractional),
            fractional,
            wave: mode
                .wave
                .iter()
                .take(analysis.dimension())
                .copied()
                .collect(),
            unfolded: is_folded.then(|| analysis.fractional(&mode.wave)),
            relative_frequency: mode.relative_frequency,
            nullity: mode.nullity,
            extent: mode.extent,
            positions: patch
                .iter()
                .map(|particle| particle.position.into())
                .collect(),
            displacements: at(false),
            quarter: at(true),
        }
    }

    /// Wave vector in units of the reciprocal vectors, as fractions if possible. Equivalent wave vectors are printed with 1/2 instead of -1/2.
    pub fn place(&self) -> String {
        self.told(&self.fractional)
    }

    /// Another wave vector, in the representation chosen for the mode.
    fn told(&self, near: &[f64]) -> String {
        let is_half = |x: f64| (x.abs() - 0.5).abs() < 1e-6;
        let first = self
            .fractional
            .iter()
            .find(|x| x.abs() > 1e-6 && !is_half(**x));
        // Choose k or -k so that the first component is positive.
        let sign = first.map_or(1.0, |x| x.signum());
        let normal = |x: &f64| fraction(&if is_half(*x) { 0.5 } else { sign * x });
        let parts: Vec<String> = near.iter().map(normal).collect();
        format!("({})", parts.join(", "))
    }

    /// Kind of the mode.
    pub fn kind(&self) -> &'static str {
        match self.nullity {
            0 => "weakly controlled",
            _ => "zero energy",
        }
    }

    /// Kind of the mode with its frequency relative to the material or its number of modes, which have a name, and its extent.
    pub(super) fn title(&self, modes: &str) -> String {
        let kind = self.kind();
        let of_zero = match self.nullity {
            0 => return format!("{kind}, {:.1} %", 100.0 * self.relative_frequency),
            1 => kind.to_owned(),
            count => format!("{kind}, {count} {modes}"),
        };
        match self.extent {
            Extent::Point => of_zero,
            Extent::Line => format!("{of_zero}, along a whole line"),
            Extent::Surface => format!("{of_zero}, over a whole surface"),
            Extent::Zone => format!("{of_zero}, at every wave vector"),
        }
    }

    /// Description of the mode: its title, and the meaning of the frequency.
    pub fn description(&self) -> String {
        let title = self.title("independent modes");
        if self.nullity > 0 {
            return title;
        }
        let weak = format!("{title} of the material's frequency");
        match &self.unfolded {
            None => weak,
            Some(wave) => {
                let parts: Vec<String> = wave.iter().map(fraction).collect();
                format!("{weak}, as the wave ({})", parts.join(", "))
            }
        }
    }
}

/// A number written as a fraction if it equals a fraction with a small denominator.
fn fraction(x: &f64) -> String {
    for denominator in 1..=16_u32 {
        let numerator = x * f64::from(denominator);
        if (numerator - numerator.round()).abs() < 1e-6 {
            return match (numerator.round() as i64, denominator) {
                (n, 1) => n.to_string(),
                (n, d) => format!("{n}/{d}"),
            };
        }
    }
    format!("{x:.4}")
}

impl fmt::Display for ModesAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "{}", self.sentence())?;
        if !self.modes.is_empty() {
            writeln!(formatter, "\n{}", self.list().join("\n"))?;
        }
        for caution in self.cautions() {
            writeln!(formatter, "\n{caution}")?;
        }
        for note in &self.notes {
            writeln!(formatter, "\nnote: {note}")?;
        }
        write!(
            formatter,
            "\n{}\n{}",
            self.evidence,
            self.settings.in_continuous_time()
        )
    }
}

impl Brief for ModesAnswer {
    fn brief(&self) -> Short {
        let (law, law_defaults) = crate::caption::law(&self.settings);
        let (method, method_defaults) = self.settings.discretization();
        let notes = [self.cautions(), self.notes.clone()].concat();
        Short::new(self.sentence())
            .table(self.list())
            .row(0, "evidence", self.evidence.words())
            .row(1, "material", law)
            .row(1, "method", method)
            .notes(&notes)
            .settings("material", law_defaults)
            .settings("method", method_defaults)
    }
}

impl ModesAnswer {
    fn sentence(&self) -> String {
        if !self.modes.is_empty() {
            return format!(
                "{} of the reference configuration, with at most {:.0} % of the frequency of the material's slowest wave with the same wave vector. \
                 Wave vectors are in units of the reciprocal vectors; k and -k count once.",
                counted(self.modes.len(), "spurious mode"),
                100.0 * self.weak
            );
        }
        match self.weakest {
            Some(weakest) => format!(
                "No spurious modes: every wave of the reference configuration has at least {:.1} % of the frequency of the material's slowest wave.",
                100.0 * weakest
            ),
            None => "No zero-energy modes. Weak modes are undefined, because the frequency of the material's slowest waves is zero.".to_owned(),
        }
    }

    /// List of the modes, one line for each.
    fn list(&self) -> Vec<String> {
        let modes = self.modes.iter().enumerate();
        let line = |(n, mode): (usize, &ShownMode)| {
            format!(
                "  {:>2}  k = {:<24} {}",
                n + 1,
                mode.place(),
                mode.description()
            )
        };
        modes.map(line).collect()
    }

    /// Notes on modes that may be missing from the list, and on the modes that do not fit the exported patch.
    fn cautions(&self) -> Vec<String> {
        let unsure =
            "not all of the zone could be searched for zero-energy modes: there may be others";
        let mut cautions = Vec::new();
        cautions.extend((!self.complete).then(|| unsure.to_owned()));
        let modes = self.modes.iter().enumerate().filter(|_| self.is_exported);
        let mut fitting: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut near = Vec::new();
        for (n, mode) in modes.filter(|(_, mode)| !mode.fits) {
            let Fit {
                cells,
                fractional,
                error,
            } = &mode.fit;
            match *error {
                0.0 => fitting.entry(*cells).or_default().push(n + 1),
                error => near.push(format!(
                    "mode {} nearly fits {cells} cells, as {} with an error of {}",
                    n + 1,
                    mode.told(fractional),
                    told(error)
                )),
            }
        }
        let fitting = fitting.iter().map(|(cells, modes)| {
            let list: Vec<String> = modes.iter().map(usize::to_string).collect();
            let (plural, verb) = if modes.len() == 1 {
                ("", "fits")
            } else {
                ("s", "fit")
            };
            let cells = counted(*cells, "cell");
            format!("mode{plural} {} {verb} {cells}", list.join(", "))
        });
        let misfits: Vec<String> = fitting.chain(near).collect();
        cautions.extend((!misfits.is_empty()).then(|| {
            format!(
                "fields that do not fit {} jump at the periodic boundary: {}",
                counted(self.cells, "cell"),
                misfits.join("; ")
            )
        }));
        cautions
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equivalent_wave_vectors_are_printed_identically() {
        let place = |fractional: &[f64]| {
            let mode = ShownMode {
                wave_vector: Vec::new(),
                fractional: fractional.to_vec(),
                wave: Vec::new(),
                unfolded: None,
                relative_frequency: 0.0,
                nullity: 1,
                extent: Extent::Point,
                fits: true,
                fit: Fit::smallest(fractional),
                positions: Vec::new(),
                displacements: Vec::new(),
                quarter: Vec::new(),
            };
            mode.place()
        };
        assert_eq!(place(&[-0.5, 0.0]), "(1/2, 0)");
        assert_eq!(place(&[-0.5, -0.5]), "(1/2, 1/2)");
        assert_eq!(place(&[1.0 / 3.0, -1.0 / 3.0]), "(1/3, -1/3)");
        // `k` and `-k` have the same name.
        assert_eq!(place(&[-0.2, 0.3]), place(&[0.2, -0.3]));
        assert_eq!(place(&[-0.5, -0.28044]), "(1/2, 0.2804)");
        assert_eq!(place(&[0.0, 0.0]), "(0, 0)");
    }
}
