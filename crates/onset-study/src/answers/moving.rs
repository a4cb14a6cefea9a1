//! Motion of the particles in the mode that an answer reports.

use super::mode::critical_mode;
use super::problem::{Problem, ProblemError, Strain};
use super::state::ComplexNumber;
use nalgebra::{DMatrix, DVector, SVector};
use onset::algebra::Complex;
use onset::bloch::Mode;
use onset::verdict::Assessment;
use serde::Serialize;
use std::f64::consts::TAU;

/// Number of cells of the patch along each primitive vector, by dimension; fewer if cells hold several particles.
const CELLS: [usize; 3] = [24, 10, 5];
/// Maximum number of particles of the patch.
const MAX_PARTICLES: usize = 700;
/// Number of inverse iterations; each iteration nearly eliminates the components of other modes.
const INVERSE_ITERATIONS: usize = 4;

/// Critical mode, or softest mode of a stable state, on a patch of particles.
///
/// At phase `p` a particle is displaced from its `place` by a multiple of `Re(u exp(-i p))`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MovingMode {
    /// Whether no mode grows.
    pub stable: bool,
    /// Whether the mode is the limit of long waves, which is drawn with the patch as wavelength.
    pub is_long_wave: bool,
    /// Reference wave vector of the drawn wave; 1/length.
    pub wave_vector: Vec<f64>,
    /// `omega^2` of the mode; zero in the limit of long waves. 1/time^2.
    pub omega_squared: ComplexNumber,
    /// Particle spacing in the reference configuration; length.
    pub spacing: f64,
    /// Particles of the patch.
    pub particles: Vec<MovingParticle>,
}

/// Particle in a mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MovingParticle {
    /// Number of the particle in its cell.
    pub site: usize,
    /// Position in the deformed state; length.
    pub place: [f64; 3],
    /// Displacement, real part, divided by the largest amplitude of all particles.
    pub re: [f64; 3],
    /// Displacement, imaginary part, divided by the largest amplitude of all particles.
    pub im: [f64; 3],
}

impl MovingMode {
    /// Computes the mode that `onset state` reports.
    ///
    /// # Errors
    /// [`ProblemError`] when the method or the material cannot be evaluated there.
    pub fn new(problem: &Problem, strain: &Strain) -> Result<Self, ProblemError> {
        let assessment = problem.analysis.assess(&strain.0)?;
        Self::of(problem, strain, &assessment)
    }

    /// Computes the mode of an assessed state.
    ///
    /// # Errors
    /// Fails like [`MovingMode::new`].
    pub fn of(
        problem: &Problem,
        strain: &Strain,
        assessment: &Assessment<3>,
    ) -> Result<Self, ProblemError> {
        let (analysis, f) = (&*problem.analysis, &strain.0);
        let (dimension, sites) = (analysis.dimension(), analysis.sites());
        let mode = critical_mode(assessment);
        let cells = cells(dimension, sites);
        let k = match mode.is_long_wave {
            true => mode.wave_vector * (TAU / (cells as f64 * analysis.spacing())),
            false => mode.wave_vector,
        };
        let of_sites = match (sites, mode.is_long_wave) {
            (1, _) | (_, true) => vec![mode.polarization; sites],
            _ => {
                let matrix = analysis.waves(f)?.dynamical_matrix_at(k.as_slice());
                displacements(&matrix, mode, dimension, sites)
            }
        };
        let deformation = f.components();
        let largest = of_sites.iter().map(SVector::norm).fold(0.0, f64::max);
        let particles = analysis.patch(cells).into_iter().map(|particle| {
            let x = &particle.position;
            let phase = k.dot(x);
            let turned = of_sites[particle.site]
                * Complex::new(phase.cos() / largest, phase.sin() / largest);
            MovingParticle {
                site: particle.site,
                place: std::array::from_fn(|i| {
                    (0..3).map(|j| deformation[i][j] * x[j]).sum::<f64>()
                }),
                re: std::array::from_fn(|i| turned[i].re),
                im: std::array::from_fn(|i| turned[i].im),
            }
        });
        Ok(Self {
            stable: assessment.spectrum.is_stable(),
            is_long_wave: mode.is_long_wave,
            wave_vector: k.iter().take(dimension).map(|x| x + 0.0).collect(),
            omega_squared: mode.omega_squared.into(),
            spacing: analysis.spacing(),
            particles: particles.collect(),
        })
    }
}

/// Number of cells along an edge that respects the limit on particles.
fn cells(dimension: usize, sites: usize) -> usize {
    let usual = CELLS[dimension - 1];
    let is_small = |cells: &usize| cells.pow(dimension as u32) * sites <= MAX_PARTICLES;
    (1..=usual).rev().find(is_small).unwrap_or(1)
}

/// Displacements of the particles of a cell in a mode with known `omega^2`. The eigenvector of `D(k)` follows by inverse iteration from the known
/// displacement of the particle that moves most.
fn displacements(
    matrix: &DMatrix<Complex>,
    mode: &Mode<3>,
    dimension: usize,
    sites: usize,
) -> Vec<SVector<Complex, 3>> {
    let size = matrix.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
    // Slightly off the eigenvalue, so that the matrix is not singular.
    let near = mode.omega_squared + Complex::new(1e-9 * size, 0.0);
    let shifted = matrix - DMatrix::identity(matrix.nrows(), matrix.ncols()) * near;
    let solver = shifted.lu();
    let mut found = DVector::from_fn(dimension * sites, |n, _| {
        // The initial vector has no symmetry of the cell, which might differ from the symmetry of the mode.
        mode.polarization[n % dimension] * (1.0 + 0.1 * (n / dimension) as f64)
    });
    for _ in 0..INVERSE_ITERATIONS {
        match solver.solve(&found) {
            Some(next) if next.norm().is_finite() && next.norm() > 0.0 => {
                found = next.unscale(next.norm());
            }
            _ => break,
        }
    }
    let of_site = |site: usize| {
        SVector::from_fn(|i, _| match i < dimension {
            true => found[dimension * site + i],
            false => Complex::new(0.0, 0.0),
        })
    };
    (0..sites).map(of_site).collect()
}

#[cfg(test)]
mod tests {
    use super::{MovingMode, displacements};
    use crate::answers::mode::critical_mode;
    use crate::answers::{Problem, Strain};
    use crate::settings::Settings;
    use nalgebra::{DVector, SVector};
    use onset::algebra::Complex;

    fn problem(own: &[&str]) -> Problem {
        let all: Vec<String> = own
            .iter()
            .map(|own| format!("discretization.{own}"))
            .collect();
        let settings = Settings::from_assignments(&all).expect("settings");
        Problem::new(settings).expect("a problem")
    }

    #[test]
    fn a_mode_of_several_particles_in_a_cell_is_an_eigenvector_of_the_dynamical_matrix() {
        for own in [
            &["method=updated-sph", "lattice=honeycomb", "support=3"][..],
            &["method=updated-sph", "cells=2", "perturbation=0.05"],
            &[
                "method=total-lagrangian-sph",
                "cells=2",
                "perturbation=0.05",
            ],
        ] {
            let problem = problem(own);
            let strain = Strain::of_stretches("stretch", "1.15,1", 2).expect("a state");
            let analysis = &*problem.analysis;
            let assessment = analysis.assess(&strain.0).expect("an assessment");
            let mode = critical_mode(&assessment);
            assert!(!mode.is_long_wave, "{own:?}");
            let waves = analysis.waves(&strain.0).expect("waves");
            let matrix = waves.dynamical_matrix_at(mode.wave_vector.as_slice());
            let of_sites = displacements(&matrix, mode, 2, analysis.sites());
            let g = DVector::from_iterator(
                matrix.nrows(),
                of_sites.iter().flat_map(|own| [own[0], own[1]]),
            );
            let size = matrix.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
            let rest = &matrix * &g - &g * mode.omega_squared;
            assert!(
                rest.norm() < 1e-6 * size * g.norm(),
                "{own:?}: {}",
                rest.norm()
            );
            // The particle with the largest displacement has the reported polarization; if two displacements are equal, one of them.
            let most = of_sites.iter().map(|own| own.norm()).fold(0.0, f64::max);
            let is_shown = of_sites.iter().any(|own| {
                let along: Complex = (0..3).map(|i| own[i] * mode.polarization[i].conj()).sum();
                own.norm() > (1.0 - 1e-6) * most && along.norm() > 0.999 * most
            });
            assert!(is_shown, "{own:?}");
        }
    }

    #[test]
    fn particles_in_a_wave_differ_only_in_phase() {
        let problem = problem(&["method=updated-sph"]);
        let strain = Strain::of_stretches("stretch", "1.1,1", 2).expect("a state");
        let moving = MovingMode::new(&problem, &strain).expect("a mode");
        assert!(!moving.stable && moving.particles.len() == 100);
        let displacement = |n: usize| {
            let own = &moving.particles[n];
            SVector::<Complex, 3>::from_fn(|i, _| Complex::new(own.re[i], own.im[i]))
        };
        let most = (0..100).map(|n| displacement(n).norm()).fold(0.0, f64::max);
        assert!((most - 1.0).abs() < 1e-12);
        let patch = problem.analysis.patch(10);
        for n in 0..100 {
            let apart = patch[n].position - patch[0].position;
            let phase = moving.wave_vector[0] * apart[0] + moving.wave_vector[1] * apart[1];
            let expected = displacement(0) * Complex::new(phase.cos(), phase.sin());
            assert!((displacement(n) - expected).norm() < 1e-12);
            // The patch is stretched by 1.1 along the first axis.
            let x = patch[n].position;
            let place = moving.particles[n].place;
            assert!((place[0] - 1.1 * x[0]).abs() < 1e-12 && (place[1] - x[1]).abs() < 1e-12);
        }
    }
}
