//! Lowest modes of the body in the actual state of a frame.

use super::course::largest;
use super::neighborhoods::Neighborhoods;
use super::{Run, ScreenError};
use crate::answers::{Problem, ProblemError};
use crate::methods::method;
use crate::number::{counted, told_with};
use crate::vtk::Grid;
use nalgebra::Matrix3;
use onset::analysis::actual_modes;
use onset::kinematics::DeformationGradient;
use onset::motion::{ActualBody, ActualMode, PlacedParticle};
use serde::Serialize;

/// Number of modes in an answer.
const MODES: usize = 6;
/// Smallest `omega^2` that is not a rounding error, relative to the largest entry of the tangent divided by the masses.
const ROUNDING_FRACTION: f64 = 1e-9;
/// Radius of the neighborhoods in which a mode is compared with a linear field, in spacings: nearest neighbors and, on square lattices, those along
/// diagonals.
const RADIUS: f64 = 1.6;
/// Smallest fraction of short waves in a short-wave mode; short waves have wavelengths of up to four spacings.
const SHORT_WAVE_SHARE: f64 = 0.2;
/// Largest deforming fraction of the body in a localized mode, and largest width of the deforming region in spacings.
const LOCALIZED: (f64, f64) = (0.2, 6.0);

/// Kind of a mode of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ModeKind {
    /// Smooth mode: a long wave, a neck or a buckle.
    Structural,
    /// Smooth mode whose strains are confined to a few spacings: a band or a spot.
    Localized,
    /// Displacements that alternate between neighbors: an hourglass mode or another wave of a few spacings.
    ShortWave,
}

/// Mode of the body, `u exp(s t)` with `s^2 = -omega^2`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyModeAnswer {
    /// Squared frequency `omega^2`, real part; zero if it is within rounding of zero. 1/time^2.
    pub omega_squared: f64,
    /// Imaginary part of `omega^2`, zero if forces have a potential; 1/time^2.
    pub omega_squared_imaginary: f64,
    /// Growth rate without viscosity, zero for oscillations; 1/time.
    pub growth: f64,
    /// Kind of the mode.
    pub kind: ModeKind,
    /// Fraction of the squared displacement that is not linear near a particle, from 0 to 1.
    pub short_waves: f64,
    /// Fraction of the particles in the deforming region, `(sum g)^2 / (n sum g^2)` with the squared gradients `g` of the mode.
    pub strained: f64,
    /// Width of the deforming region, `strained` times the longest side of the body; in particle spacings.
    pub width: f64,
    /// Particle with the largest displacement.
    pub particle: usize,
    /// Reference position of the particle with the largest displacement; length.
    pub place: [f64; 3],
    /// Displacements, normalized so that the largest has unit length.
    #[serde(skip)]
    pub displacements: Vec<[f64; 3]>,
}

/// Lowest modes of the body in a frame: `K u = omega^2 M u` with the tangent `K` of the forces on its particles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Actual {
    /// Time given by the user.
    pub asked: f64,
    /// Time of the nearest frame, in which the modes are computed.
    pub time: f64,
    /// Number of the frame in which the modes are computed, from 0.
    pub frame: usize,
    /// Number of unknowns: components of the displacements of all particles that are not held.
    pub unknowns: usize,
    /// Number of rigid motions, which are excluded.
    pub rigid: usize,
    /// Whether the forces have a potential, so that all `omega^2` are real.
    pub is_symmetric: bool,
    /// Modes with the smallest `omega^2`, in ascending order.
    pub modes: Vec<BodyModeAnswer>,
    /// Current positions of the particles.
    #[serde(skip)]
    x: Vec<[f64; 3]>,
    /// Particles in the reference configuration.
    #[serde(skip)]
    run: Run,
    #[serde(skip)]
    dimension: usize,
}

/// Frame nearest to a time.
pub(super) struct Nearest {
    pub(super) time: f64,
    pub(super) frame: usize,
    pub(super) x: Vec<[f64; 3]>,
}

impl Actual {
    /// Finds the lowest modes. `deformations` are the deformation gradients of the particles, for methods whose particles carry them.
    ///
    /// # Errors
    /// [`ScreenError`] if method or law have no tangent at the positions of the frame.
    pub(super) fn new(
        problem: &Problem,
        asked: f64,
        run: &Run,
        nearest: Nearest,
        deformations: &[Option<Matrix3<f64>>],
    ) -> Result<Self, ScreenError> {
        let (dimension, spacing) = (problem.dimension(), problem.analysis.spacing());
        let given = |f: &Option<Matrix3<f64>>| {
            let f = f.as_ref()?;
            let rows = std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)]));
            DeformationGradient::new(rows).ok()
        };
        let deformations: Vec<Option<DeformationGradient>> =
            deformations.iter().map(given).collect();
        let particles = placed(run, spacing.powi(dimension as i32));
        let body = ActualBody {
            particles: &particles,
            positions: &nearest.x,
            deformations: &deformations,
            elements: run.cells.as_deref().unwrap_or_default(),
            held: &run.held,
        };
        let found = actual_modes(&method(&problem.settings), &*problem.material, &body, MODES);
        let found = found.map_err(ProblemError::from)?;
        let near = Neighborhoods::new(&run.reference, dimension, RADIUS * spacing);
        let longest = longest_side(&run.reference) / spacing;
        let rounding = ROUNDING_FRACTION * found.scale;
        let modes = found.modes.into_iter();
        Ok(Self {
            asked,
            time: nearest.time,
            frame: nearest.frame,
            unknowns: found.unknowns,
            rigid: found.rigid,
            is_symmetric: found.is_symmetric,
            modes: modes
                .map(|own| BodyModeAnswer::new(own, run, &near, longest, rounding))
                .collect(),
            x: nearest.x,
            run: run.clone(),
            dimension,
        })
    }

    /// Lines of the printed answer.
    pub(super) fn told(&self) -> Vec<String> {
        let short = |x: f64| told_with(x, 4);
        let frame = match short(self.time) == short(self.asked) {
            true => format!("at t = {}", short(self.time)),
            false => format!(
                "at t = {}, the frame nearest to {}",
                short(self.time),
                short(self.asked)
            ),
        };
        let growing = self.modes.iter().filter(|mode| mode.growth > 0.0).count();
        let rigid = match self.rigid {
            0 => String::new(),
            count => format!(", without {}", counted(count, "rigid motion")),
        };
        let count = self.modes.len();
        let mut lines = vec![match growing {
            0 => format!("{frame}, the {count} lowest modes do not grow{rigid}"),
            _ => format!("{frame}, {growing} of the {count} lowest modes grow{rigid}"),
        }];
        lines.extend(self.modes.iter().map(|mode| mode.told(self.dimension)));
        lines
    }

    /// Positions of the particles with the displacements of the modes, for ParaView.
    pub(super) fn vtu(&self) -> String {
        let names: Vec<String> = (1..=self.modes.len())
            .map(|n| format!("mode_{n}"))
            .collect();
        let held = self.run.held.iter().map(|is| f64::from(u8::from(*is)));
        let held: Vec<f64> = held.collect();
        let modes = names.iter().zip(&self.modes);
        let mut grid = Grid {
            points: &self.x,
            vectors: modes
                .map(|(name, mode)| (name.as_str(), mode.displacements.clone()))
                .collect(),
            scalars: vec![("held", &held)],
            ..Grid::default()
        };
        grid.vectors.push(("reference", self.run.reference.clone()));
        let elements = self.run.cells.as_deref();
        grid.elements = elements.map(|cells| (self.dimension, cells));
        grid.vtu()
    }
}

/// Particles of a run in the reference configuration; `volume` is the default volume of a particle.
pub(super) fn placed(run: &Run, volume: f64) -> Vec<PlacedParticle> {
    let particle = |n: usize| PlacedParticle {
        position: run.reference[n],
        volume: run.volumes.as_ref().map_or(volume, |volumes| volumes[n]),
    };
    (0..run.reference.len()).map(particle).collect()
}

fn longest_side(x: &[[f64; 3]]) -> f64 {
    let side = |i: usize| {
        let along = || x.iter().map(move |x| x[i]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    (0..3).map(side).fold(0.0, f64::max)
}

impl BodyModeAnswer {
    fn new(mode: ActualMode, run: &Run, near: &Neighborhoods, longest: f64, rounding: f64) -> Self {
        let growth = match mode.squared.re < -rounding || mode.squared.im.abs() > rounding {
            true => mode.growth(),
            false => 0.0,
        };
        let exact = |x: f64| if x.abs() > rounding { x } else { 0.0 };
        let u = mode.displacements;
        let squares = |x: &[f64; 3]| -> f64 { x.iter().map(|x| x * x).sum() };
        let all: f64 = u.iter().map(squares).sum();
        let short: f64 = near.short_waves(&u).amplitude.iter().map(|x| x * x).sum();
        let short_waves = (short / all).min(1.0);
        let (mut sum, mut sum_of_squares) = (0.0, 0.0);
        for n in 0..u.len() {
            let gradient = near.gradient(n, &u).norm_squared();
            sum += gradient;
            sum_of_squares += gradient * gradient;
        }
        let strained = match sum_of_squares > 0.0 {
            true => sum * sum / (u.len() as f64 * sum_of_squares),
            false => 1.0,
        };
        // A row of particles has the width of one spacing.
        let width = strained * (longest + 1.0);
        let kind = match () {
            () if short_waves > SHORT_WAVE_SHARE => ModeKind::ShortWave,
            () if strained < LOCALIZED.0 && width < LOCALIZED.1 => ModeKind::Localized,
            () => ModeKind::Structural,
        };
        let sizes = u.iter().map(squares).enumerate();
        let particle = largest(sizes, &run.reference).map_or(0, |(n, _)| n);
        Self {
            omega_squared: exact(mode.squared.re),
            omega_squared_imaginary: exact(mode.squared.im.abs()),
            growth,
            kind,
            short_waves,
            strained,
            width,
            particle,
            place: run.reference[particle],
            displacements: u,
        }
    }

    fn told(&self, dimension: usize) -> String {
        let short = |x: f64| told_with(x, 4);
        let imaginary = match self.omega_squared_imaginary > 0.0 {
            true => format!(" +- {}i", short(self.omega_squared_imaginary)),
            false => String::new(),
        };
        let motion = match (self.growth > 0.0, self.omega_squared == 0.0) {
            (true, _) => format!("grows at the rate {}", short(self.growth)),
            (false, true) => "no force resists it".to_owned(),
            (false, false) => "oscillates".to_owned(),
        };
        let kind = match self.kind {
            ModeKind::Structural => "structural (smooth)".to_owned(),
            ModeKind::Localized => format!(
                "localized in a band or spot {} spacings wide",
                told_with(self.width, 2)
            ),
            ModeKind::ShortWave => format!(
                "short waves ({:.0} % of the squared displacement)",
                100.0 * self.short_waves
            ),
        };
        let place: Vec<String> = self.place[..dimension].iter().map(|x| short(*x)).collect();
        format!(
            "omega^2 = {}{imaginary}: {motion}; {kind}; largest near ({})",
            short(self.omega_squared),
            place.join(", ")
        )
    }
}
