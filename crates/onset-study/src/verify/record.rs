//! Amplitude of the wave at each time, read from the output of a run.

use super::{Case, VerifyError};
use std::path::{Path, PathBuf};

/// Largest displacement of a small perturbation, in particle spacings. Larger displacements also indicate that the lattice has changed.
const MAX_DISPLACEMENT_SPACINGS: f64 = 0.1;

/// Amplitudes of a wave over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Path of the output.
    pub path: PathBuf,
    /// Times and amplitudes, `sum (u.g) cos(k.X) / sum cos^2(k.X)`; length.
    pub samples: Vec<(f64, f64)>,
    /// Whether the file ends within a frame.
    pub is_cut: bool,
}

/// Projection of the particles of a run on the wave of a case, frame by frame.
pub struct Projector<'a> {
    case: &'a Case,
    path: PathBuf,
    seen: Vec<bool>,
    count: usize,
    sum: f64,
    /// `sum cos^2` over all measured particles.
    norm: f64,
    samples: Vec<(f64, f64)>,
}

impl<'a> Projector<'a> {
    /// Projector for an output of a case.
    pub fn new(case: &'a Case, path: &Path) -> Self {
        let all = 0..case.block.particles();
        let measured = all.filter(|index| case.block.is_measured(*index));
        Self {
            path: path.to_owned(),
            seen: vec![false; case.block.particles()],
            count: 0,
            sum: 0.0,
            norm: measured.map(|index| case.phase(index).powi(2)).sum(),
            samples: Vec::new(),
            case,
        }
    }

    /// Case of the output.
    pub fn case(&self) -> &Case {
        self.case
    }

    /// Error for an output that does not belong to the case.
    pub fn wrong(&self, line: usize, what: impl Into<String>, hint: &'static str) -> VerifyError {
        VerifyError::Output {
            path: self.path.clone(),
            line,
            what: what.into(),
            hint,
        }
    }

    /// Checks that the identifier in an output is the identifier of this case.
    ///
    /// # Errors
    /// [`VerifyError::Output`] if it differs or is missing.
    pub fn require_mark(&self, line: usize, mark: Option<&str>) -> Result<(), VerifyError> {
        match mark {
            Some(mark) if mark == self.case.id => Ok(()),
            Some(_) => Err(self.wrong(
                line,
                format!(
                    "this is the output of another case; the case in its folder is {}",
                    self.case.id
                ),
                "name the case.json of its deck with --case FILE",
            )),
            None => Err(self.wrong(
                line,
                format!(
                    "the output does not contain the mark of case {}",
                    self.case.id
                ),
                "run the deck as it was written; the page `verify` of the book describes the formats",
            )),
        }
    }

    /// Adds a particle of the frame, by its number counted from 1. Particles that are not measured are skipped.
    ///
    /// # Errors
    /// [`VerifyError::Output`] for a particle that is not in the case, occurs twice, or is far from its position.
    pub fn particle(
        &mut self,
        line: usize,
        number: f64,
        position: [f64; 3],
    ) -> Result<(), VerifyError> {
        let block = &self.case.block;
        let is_number = number >= 1.0 && number <= block.particles() as f64;
        if !is_number || number.fract() != 0.0 {
            return Err(self.wrong(
                line,
                format!(
                    "there is no particle {number}; the case has {}",
                    block.particles()
                ),
                "give particles the numbers of the deck",
            ));
        }
        let index = number as usize - 1;
        let dimension = block.dimension();
        if let Some(wrong) = position[..dimension].iter().find(|x| !x.is_finite()) {
            return Err(self.wrong(
                line,
                format!("particle {number} is at {wrong}: the run has failed"),
                "a step above the critical one? run the deck as it was written",
            ));
        }
        if !block.is_measured(index) {
            return Ok(());
        }
        if std::mem::replace(&mut self.seen[index], true) {
            return Err(self.wrong(
                line,
                format!("particle {number} occurs twice in one frame"),
                "write each particle once",
            ));
        }
        let displacement = self.case.displacement(index, &position);
        let largest = displacement
            .iter()
            .fold(0.0_f64, |most, u| most.max(u.abs()));
        if largest > MAX_DISPLACEMENT_SPACINGS * self.case.spacing() {
            return Err(self.wrong(
                line,
                format!(
                    "particle {number} is {largest:.3e} away from its place in the homogeneous state, the spacing being {:e}",
                    self.case.spacing()
                ),
                "check that the output is of this deck; for growing waves choose fewer --steps, so that the run stays near the state",
            ));
        }
        let projection = self.case.prediction.projection.iter();
        let along: f64 = projection.zip(displacement).map(|(l, u)| l * u).sum();
        self.sum += along * self.case.phase(index);
        self.count += 1;
        Ok(())
    }

    /// Ends a frame and returns the number of missing particles.
    pub fn end_frame(&mut self, time: f64) -> usize {
        let missing = self.case.block.measured_particles() - self.count;
        if missing == 0 {
            self.samples.push((time, self.sum / self.norm));
        }
        self.seen.fill(false);
        (self.count, self.sum) = (0, 0.0);
        missing
    }

    /// Finishes the record. The last frame may be incomplete if the file ends within it.
    pub fn finish(self, is_cut: bool) -> Record {
        Record {
            path: self.path,
            samples: self.samples,
            is_cut,
        }
    }
}
