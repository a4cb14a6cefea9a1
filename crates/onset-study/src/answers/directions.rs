//! Stiffness of the material for plane waves in each direction.

use super::problem::{Problem, ProblemError, Strain};
use nalgebra::SVector;
use onset::analysis::acoustic_eigenvalues_in;
use onset::method::MethodError;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// Directions of half a circle; the other half has the same eigenvalues.
const CIRCLE_DIRECTIONS: usize = 180;
/// Directions on a sphere: circles of latitude from pole to pole, and points on each circle.
const SPHERE_DIRECTIONS: [usize; 2] = [37, 72];

/// Acoustic tensor `Q_ik(N) = A_iJkL N_J N_L` in the reference directions `N` of the lattice's dimensions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Directions {
    /// Numbers of directions from pole to pole and around; in 2D one and the number for half a circle.
    pub shape: [usize; 2],
    /// Directions, in 2D by increasing angle from the first axis; in 3D circle after circle from the third axis downward.
    pub normals: Vec<Vec<f64>>,
    /// Eigenvalues of `Q(N)` for each direction, smallest first; stress.
    pub eigenvalues: Vec<Vec<f64>>,
}

impl Directions {
    /// Computes the eigenvalues of the acoustic tensor at a state.
    ///
    /// # Errors
    /// [`ProblemError`] when the material cannot be evaluated there.
    pub fn new(problem: &Problem, strain: &Strain) -> Result<Self, ProblemError> {
        let dimension = problem.dimension();
        let (shape, normals) = normals(dimension);
        let eigenvalues =
            acoustic_eigenvalues_in(dimension, &*problem.material, &strain.0, &normals);
        let listed = |normal: &SVector<f64, 3>| normal.iter().take(dimension).copied().collect();
        Ok(Self {
            shape,
            normals: normals.iter().map(listed).collect(),
            eigenvalues: eigenvalues.map_err(MethodError::from)?,
        })
    }
}

/// Directions that cover a line, a plane or space.
fn normals(dimension: usize) -> ([usize; 2], Vec<SVector<f64, 3>>) {
    let in_plane = |angle: f64| SVector::from([angle.cos(), angle.sin(), 0.0]);
    match dimension {
        1 => ([1, 1], vec![in_plane(0.0)]),
        2 => {
            let angles = (0..CIRCLE_DIRECTIONS).map(|n| PI * n as f64 / CIRCLE_DIRECTIONS as f64);
            ([1, CIRCLE_DIRECTIONS], angles.map(in_plane).collect())
        }
        _ => {
            let [circles, around] = SPHERE_DIRECTIONS;
            let place = |n: usize| {
                let theta = PI * (n / around) as f64 / (circles - 1) as f64;
                let phi = TAU * (n % around) as f64 / around as f64;
                let mut normal = in_plane(phi) * theta.sin();
                normal[2] = theta.cos();
                normal
            };
            (
                SPHERE_DIRECTIONS,
                (0..circles * around).map(place).collect(),
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Directions, normals};
    use crate::answers::{Problem, StateAnswer, Strain};
    use crate::settings::Settings;

    #[test]
    fn the_smallest_eigenvalue_over_the_directions_agrees_with_the_search() {
        for (lattice, stretches) in [
            ("chain", "1.3"),
            ("hexagonal", "1.9,0.8"),
            ("simple-cubic", "1.7,1.0,0.9"),
        ] {
            let method = [
                "material.model=blatz-ko".to_owned(),
                format!("discretization.lattice={lattice}"),
                "discretization.method=total-lagrangian-sph".to_owned(),
            ];
            let settings = Settings::from_assignments(&method).expect("settings");
            let problem = Problem::new(settings).expect("a problem");
            let strain = Strain::of_stretches("stretch", stretches, problem.dimension());
            let strain = strain.expect("a state");
            let found = Directions::new(&problem, &strain).expect("directions");
            let least = found.eigenvalues.iter().map(|of| of[0]);
            let least = least.fold(f64::INFINITY, f64::min);
            let answer = StateAnswer::new(&problem, &strain).expect("a state");
            let minimum = answer.material.minimum_acoustic_eigenvalue;
            let size = answer.material.tangent[0][0][0][0].abs();
            // Between two directions of the grid the minimum can be slightly lower.
            assert!(
                least >= minimum - 1e-9 * size && least <= minimum + 5e-3 * size,
                "{lattice}: {least} {minimum}"
            );
        }
    }

    #[test]
    fn directions_have_unit_length() {
        for dimension in 1..=3 {
            let ([circles, around], all) = normals(dimension);
            assert_eq!(all.len(), circles * around);
            assert!(all.iter().all(|n| (n.norm() - 1.0).abs() < 1e-14));
        }
    }
}
