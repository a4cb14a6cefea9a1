//! Deformation gradients and stresses of particles in output files.

use crate::answers::Problem;
use crate::screen::{Neighborhoods, cauchy_stress, neighborhood_radius};
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Value of a state that does not exist, as at an inverted particle.
const UNDEFINED: [f64; 9] = [f64::NAN; 9];

fn flat(matrix: &Matrix3<f64>) -> [f64; 9] {
    std::array::from_fn(|n| matrix[(n / 3, n % 3)])
}

/// Cauchy stresses of the law at deformation gradients, row by row; NaN where the law is not defined.
pub(super) fn stresses(problem: &Problem, gradients: &[[f64; 9]]) -> Vec<[f64; 9]> {
    let of = |f: &[f64; 9]| {
        let stress = cauchy_stress(problem, &Matrix3::from_row_slice(f));
        stress.map_or(UNDEFINED, |stress| flat(&stress))
    };
    gradients.par_iter().map(of).collect()
}

/// Neighborhoods of the particles of a periodic patch.
pub(super) struct PatchNeighborhoods {
    nodes: Neighborhoods,
    /// Particle of each periodic image, and the vector from it to its image in the reference configuration.
    images: Vec<(usize, [f64; 3])>,
}

impl PatchNeighborhoods {
    /// Finds the neighbors of particles at reference positions. `cells` is the number of cells along each primitive vector.
    pub(super) fn new(problem: &Problem, reference: &[[f64; 3]], cells: &[usize]) -> Self {
        let dimension = problem.dimension();
        let radius = neighborhood_radius(problem);
        let reciprocal = problem.analysis.reciprocal();
        let mut rows = Matrix3::identity();
        for (axis, b) in reciprocal.iter().enumerate() {
            (0..3).for_each(|i| rows[(axis, i)] = b[i] / TAU);
        }
        let vectors = rows.try_inverse().unwrap_or_else(Matrix3::identity);
        // Lattice coordinates, and their ranges with a margin of one radius.
        let coordinate =
            |x: &[f64; 3], axis: usize| (0..3).map(|i| rows[(axis, i)] * x[i]).sum::<f64>();
        let ranges: [(f64, f64); 3] = std::array::from_fn(|axis| {
            let margin = radius * rows.row(axis).norm();
            let all = reference.iter().map(|x| coordinate(x, axis));
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| {
                (low.min(s), high.max(s))
            });
            (low - margin, high + margin)
        });
        let mut all = reference.to_vec();
        let mut images = Vec::new();
        for (n, x) in reference.iter().enumerate() {
            let periods = |axis: usize| {
                let Some(count) = cells.get(axis).filter(|_| axis < dimension) else {
                    return 0..=0;
                };
                let (count, s) = (*count as f64, coordinate(x, axis));
                let (low, high) = ranges[axis];
                ((low - s) / count).ceil() as i64..=((high - s) / count).floor() as i64
            };
            for a in periods(0) {
                for b in periods(1) {
                    for c in periods(2) {
                        if [a, b, c] == [0; 3] {
                            continue;
                        }
                        let mut shift = [0.0; 3];
                        for (axis, periods) in [a, b, c].into_iter().enumerate() {
                            let count = cells.get(axis).copied().unwrap_or(0);
                            let factor = periods as f64 * count as f64;
                            (0..3).for_each(|i| shift[i] += factor * vectors[(i, axis)]);
                        }
                        all.push(std::array::from_fn(|i| x[i] + shift[i]));
                        images.push((n, shift));
                    }
                }
            }
        }
        Self {
            nodes: Neighborhoods::of_first(reference.len(), &all, dimension, radius),
            images,
        }
    }

    /// Deformation gradients of the particles at their positions, row by row, as `onset screen` finds them in positions. `f` is the mean deformation
    /// gradient, which also has the stretches beyond the dimensions.
    pub(super) fn gradients(
        &self,
        positions: &[[f64; 3]],
        f: &DeformationGradient,
    ) -> Vec<[f64; 9]> {
        let (f, dimension) = (f.components(), self.nodes.dimension());
        let mut all = positions.to_vec();
        for (n, shift) in &self.images {
            all.push(std::array::from_fn(|i| match i < dimension {
                true => positions[*n][i] + (0..dimension).map(|j| f[i][j] * shift[j]).sum::<f64>(),
                false => positions[*n][i],
            }));
        }
        let of = |n: usize| {
            let Some(mut own) = self.nodes.deformation(n, &all) else {
                return UNDEFINED;
            };
            for i in 0..3 {
                for j in 0..3 {
                    if i.max(j) >= dimension {
                        own[(i, j)] = f[i][j];
                    }
                }
            }
            flat(&own)
        };
        (0..positions.len()).into_par_iter().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{PatchNeighborhoods, stresses};
    use crate::answers::Problem;
    use crate::settings::Settings;
    use onset::kinematics::DeformationGradient;

    fn problem(lattice: &str) -> Problem {
        let text = format!(
            "[material]\nmodel = 'neo-hooke'\n[discretization]\nmethod = 'total-lagrangian-sph'\nlattice = '{lattice}'\n"
        );
        let settings = Settings::of_file::<&str>("patch.toml", &text, &[], &[]);
        Problem::new(settings.expect("settings")).expect("a problem")
    }

    #[test]
    fn particles_of_a_homogeneous_patch_have_its_gradient_and_stress() {
        let components = [[1.2, 0.1, 0.0], [0.05, 0.9, 0.0], [0.0, 0.0, 1.1]];
        let f = DeformationGradient::new(components).expect("a state");
        for (lattice, cells) in [
            ("square", vec![3, 5]),
            ("hexagonal", vec![4, 2]),
            ("face-centered-cubic", vec![3, 2, 4]),
        ] {
            let problem = problem(lattice);
            let mut reference = Vec::new();
            let patch = problem.analysis.with_motion(&f, &cells, &mut |patch| {
                reference = patch.positions();
            });
            patch.expect("a patch");
            let moved = |x: &[f64; 3]| {
                std::array::from_fn(|i| (0..3).map(|j| components[i][j] * x[j]).sum::<f64>())
            };
            let positions: Vec<[f64; 3]> = reference.iter().map(moved).collect();
            let near = PatchNeighborhoods::new(&problem, &reference, &cells);
            let gradients = near.gradients(&positions, &f);
            let response = problem.material.response(&f).expect("a response");
            let cauchy = response.cauchy();
            let stresses = stresses(&problem, &gradients);
            for (own, stress) in gradients.iter().zip(&stresses) {
                for (n, (f, sigma)) in own.iter().zip(stress).enumerate() {
                    let (i, j) = (n / 3, n % 3);
                    assert!((f - components[i][j]).abs() < 1e-12, "{lattice}: {own:?}");
                    assert!(
                        (sigma - cauchy[(i, j)]).abs() < 1e-12,
                        "{lattice}: {stress:?}"
                    );
                }
            }
            assert_eq!(gradients.len(), reference.len());
        }
    }
}
