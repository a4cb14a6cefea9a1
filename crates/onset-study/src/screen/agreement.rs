//! Comparison of deformation gradients in the files with the positions, and of stresses in the files with the law.

use crate::answers::Problem;
use crate::number::{counted, told, told_with};
use crate::settings::Family;
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;

/// Gradients or stresses of one state disagree if their median relative difference exceeds this value.
const DISAGREEMENT: f64 = 0.05;
/// Smallest norm of `F - 1` for which gradients are compared.
const COMPARABLE_STRAIN: f64 = 1e-3;
/// Largest number of points whose stresses are compared in a frame.
const SAMPLES: usize = 500;
/// Number of frames at the beginning of the run whose gradients and stresses are compared.
const FRAMES: usize = 5;

/// Differences of gradients and stresses in the files.
#[derive(Clone, Debug, Default)]
pub(super) struct Agreement {
    /// Smallest difference of gradients in the frames at the beginning, and the text on this difference; no text for gradients that agree.
    gradient: Option<(f64, Option<String>)>,
    /// Text on the first frame with gradients that are not numbers.
    broken: Option<String>,
    /// Number of frames with compared gradients.
    gradient_frames: usize,
    /// Relative differences of stresses, and ratios between them, in the frames at the beginning.
    stress: Vec<(f64, f64)>,
    /// Number of frames with compared stresses.
    frames: usize,
}

/// Interpretation of a gradient in a file.
type Reading<'r> = &'r dyn Fn(&Matrix3<f64>) -> Option<Matrix3<f64>>;

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Cauchy stress of the law at a deformation gradient; `None` where the law is not defined. A law in rate form has the stress of a proportional path.
pub(crate) fn cauchy_stress(problem: &Problem, f: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let rotation = rotation(f)?;
    let u = rotation.transpose() * f;
    let u = std::array::from_fn(|i| std::array::from_fn(|j| u[(i, j)]));
    let response = problem
        .material
        .response(&DeformationGradient::new(u).ok()?);
    let stress = response.ok()?.cauchy();
    Some(rotation * stress * rotation.transpose())
}

/// Relative difference in words: percent, or a factor for large differences.
fn share(difference: f64) -> String {
    match difference {
        ..10.0 => format!("{:.0} %", 100.0 * difference),
        ..1e4 => format!("a factor of {}", told_with(difference, 2)),
        _ => format!("a factor of {difference:.1e}"),
    }
}

fn rotation(f: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let u = super::states::without_rotation(f)?;
    Some(f * u.try_inverse()?)
}

impl Agreement {
    /// Compares gradients in a file with the gradients `found` from positions, in the first frames after the start.
    pub(super) fn compare_gradients(
        &mut self,
        dimension: usize,
        time: f64,
        given: &[[f64; 9]],
        found: &[Option<Matrix3<f64>>],
    ) {
        if self.gradient_frames >= FRAMES {
            return;
        }
        let in_plane = |f: &Matrix3<f64>| {
            let mut f = *f;
            for i in 0..3 {
                for j in 0..3 {
                    if i.max(j) >= dimension {
                        f[(i, j)] = if i == j { 1.0 } else { 0.0 };
                    }
                }
            }
            f
        };
        let deformed = |f: &Matrix3<f64>| (f - Matrix3::identity()).norm() > COMPARABLE_STRAIN;
        let pairs: Vec<(Matrix3<f64>, Matrix3<f64>)> = given
            .iter()
            .zip(found)
            .filter_map(|(given, found)| {
                Some((in_plane(&Matrix3::from_row_slice(given)), found.as_ref()?))
            })
            .filter(|(_, found)| deformed(found))
            .map(|(given, found)| (given, *found))
            .collect();
        let is_number = |f: &Matrix3<f64>| f.iter().all(|x| x.is_finite());
        let all = pairs.len();
        let pairs: Vec<_> = pairs
            .into_iter()
            .filter(|(given, _)| is_number(given))
            .collect();
        if pairs.len() < all && self.broken.is_none() {
            self.broken = Some(format!(
                "deformation gradients in the files are not numbers in {} of {} at t = {}; gradients of the positions are used instead",
                all - pairs.len(),
                counted(all, "point"),
                told(time)
            ));
        }
        if pairs.is_empty() {
            return;
        }
        let difference = |of: Reading<'_>| {
            let each = pairs.iter().filter_map(|(given, found)| {
                let strain = (found - Matrix3::identity()).norm();
                Some((given - of(found)?).norm() / strain)
            });
            median(each.collect()).unwrap_or(f64::INFINITY)
        };
        let own = difference(&|f| Some(*f));
        let readings: [(&str, Reading<'_>); 4] = [
            ("the identity", &|_| Some(Matrix3::identity())),
            ("their transposes", &|f| Some(f.transpose())),
            (
                "their stretches U, without rotation",
                &super::states::without_rotation,
            ),
            ("their inverses", &|f| f.try_inverse()),
        ];
        let other = readings
            .into_iter()
            .map(|(name, reading)| (name, difference(reading)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        self.gradient_frames += 1;
        // Gradients of the right form agree in some frame; a front of a wave can spoil others.
        if self
            .gradient
            .as_ref()
            .is_some_and(|(least, _)| *least <= own)
        {
            return;
        }
        let text = match other {
            _ if own <= DISAGREEMENT => None,
            Some((name, rest)) if rest <= DISAGREEMENT => Some(format!(
                "deformation gradients in the files are {name} and do not fit the positions; gradients of the positions are used instead"
            )),
            _ => Some(format!(
                "deformation gradients in the files do not fit the positions (median difference {} at t = {}); gradients of the positions are used instead",
                share(own),
                told(time)
            )),
        };
        self.gradient = Some((own, text));
    }

    /// Compares stresses in a file with the law, in the first frames after the start.
    pub(super) fn compare_stresses(
        &mut self,
        problem: &Problem,
        given: &[[f64; 6]],
        is_given: &[bool; 6],
        found: &[Option<Matrix3<f64>>],
    ) {
        if self.frames >= FRAMES {
            return;
        }
        let every = found.len().div_ceil(SAMPLES).max(1);
        let components = |stress: &Matrix3<f64>| {
            [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| stress[at])
        };
        let of_law = |f: &Matrix3<f64>| Some(components(&cauchy_stress(problem, f)?));
        let pairs: Vec<([f64; 6], [f64; 6])> = given
            .iter()
            .zip(found)
            .step_by(every)
            .filter_map(|(given, f)| Some((*given, of_law(f.as_ref()?)?)))
            .collect();
        let dot = |a: &[f64; 6], b: &[f64; 6]| -> f64 {
            let own = (0..6).filter(|n| is_given[*n]);
            own.map(|n| a[n] * b[n]).sum()
        };
        let (mut mixed, mut square) = (0.0, 0.0);
        for (given, law) in &pairs {
            mixed += dot(given, law);
            square += dot(law, law);
        }
        // While a first wave runs through the body most stresses are small.
        let usual = square / pairs.len().max(1) as f64;
        let each = pairs.iter().map(|(given, law)| {
            let rest: [f64; 6] = std::array::from_fn(|n| given[n] - law[n]);
            (dot(&rest, &rest) / usual).sqrt()
        });
        if let Some(difference) = median(each.collect()).filter(|_| square > 0.0) {
            self.stress.push((difference, mixed / square));
            self.frames += 1;
        }
    }

    /// Clauses about the differences, for the user.
    pub(super) fn notes(&self, problem: &Problem) -> Vec<String> {
        let texts = self.gradient.iter().filter_map(|(_, text)| text.clone());
        let mut notes: Vec<String> = self.broken.iter().cloned().chain(texts).collect();
        let difference = median(self.stress.iter().map(|own| own.0).collect());
        let factor = median(self.stress.iter().map(|own| own.1).collect());
        let (Some(difference), Some(factor)) = (difference, factor) else {
            return notes;
        };
        if difference <= DISAGREEMENT {
            return notes;
        }
        let method = &problem.settings.method;
        let reason = match factor {
            _ if (factor + 1.0).abs() < DISAGREEMENT => {
                "they have the opposite sign: pressure is positive in the files".to_owned()
            }
            _ if !(0.5..2.0).contains(&factor) => format!(
                "the law gives 1/{} of them: check units and moduli",
                told(factor)
            ),
            _ if method.method == Family::UpdatedSph && !method.corrected => {
                "uncorrected SPH gradients differ from the gradients of the positions".to_owned()
            }
            _ => "check the law, its parameters, and whether the run is in plane strain".to_owned(),
        };
        notes.push(format!(
            "stresses in the files differ from the law by {} (median) at the beginning; {reason}",
            share(difference)
        ));
        notes
    }
}
