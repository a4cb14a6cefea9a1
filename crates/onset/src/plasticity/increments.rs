//! Localization of laws known only by their response to increments, such as user subroutines, along a loading path.
//!
//! Neither yield surface nor flow rule of such a law is known. The quantities that [`follow`](super::follow) obtains from a
//! [`FlowLaw`](super::FlowLaw) are computed here from two tangents of a state: for the next small increment along the path, and for the reversed
//! increment, which unloads. Their difference is the reduction by flow,
//!
//! `C_e - C_p = (C_e:P)(Q:C_e) / (h + Q:C_e:P)`,
//!
//! of rank one. Its factors give `P` and `Q`, whose deviators are normalized as in the Drucker-Prager law, `sqrt(P':P') = 1/sqrt(2)`, and its
//! magnitude gives the plastic modulus `h`. A return mapping provides the tangent of its increment. As the increments shrink, this tangent approaches
//! the tangent of continued flow linearly, so the limit is extrapolated from two increment sizes.

use super::path::{Bands, Course, End, Loading, Localization, PathPoint, Strains};
use super::{Criterion, PlasticityError, RateModuli};
use crate::kinematics::DeformationGradient;
use crate::material::{FourthOrder, MaterialError, Response};
use nalgebra::{Matrix3, Vector3};

/// Law that responds to histories of strain.
pub trait IncrementalLaw {
    /// Returns stress and tangent of the last increment after a history of deformation from the unstressed reference state.
    ///
    /// The history has one deformation gradient for the end of each increment.
    ///
    /// # Errors
    /// [`MaterialError`] if the law fails.
    fn after(&self, history: &[DeformationGradient]) -> Result<Response, MaterialError>;
}

/// Smallest driving strain in the search for yield.
const SMALLEST_STRAIN: f64 = 1e-7;
/// Largest driving strain in the search for yield.
const LARGEST_STRAIN: f64 = 1.0;
/// Growth factor of trial strains before first yield.
const TRIAL_GROWTH_FACTOR: f64 = 1.5;
/// Smallest relative reduction of the elastic tangent that counts as flow.
const FLOW_THRESHOLD: f64 = 1e-3;
/// Size of the probing increments, in units of the strain of first yield.
const PROBE_SIZE: f64 = 1e-4;
/// Relative size of tangent components that count as zero: components that violate orthotropy along the axes, and flow by a second mechanism.
const ZERO_COMPONENT_FRACTION: f64 = 1e-4;
/// Largest number of Newton iterations for the lateral strains.
const ITERATIONS: usize = 40;
/// Largest correction of the strains, in units of the strain of first yield, at which the iteration has converged.
const STRAIN_TOLERANCE: f64 = 1e-11;
/// Largest admissible lateral stresses, in units of the elastic moduli times the strain of first yield, if the corrections do not converge.
const STRESS_TOLERANCE: f64 = 1e-6;
/// Number of halvings of the increment in which a criterion is first violated.
const HALVINGS: usize = 36;

/// Follows a loading of an incremental law, from the confined state through first yield, and finds where it localizes.
///
/// About `increments` increments are computed up to the plastic shear strain of the loading, with shorter increments near first yield. The path is
/// known only through the response to them, so its error decreases with their number. The plastic shear strain is computed from the flow that the
/// tangents imply.
///
/// # Errors
/// The errors of [`follow`](super::follow), [`PlasticityError::Law`] if the law fails before it flows, and [`PlasticityError::NotAlongAxes`] or
/// [`PlasticityError::SeveralMechanisms`] if its tangent does not correspond to one mechanism of flow along the axes.
pub fn follow_increments(
    law: &dyn IncrementalLaw,
    loading: &Loading,
    increments: usize,
) -> Result<Localization, PlasticityError> {
    let mut walk = Increments::new(law, loading)?;
    walk.yield_first()?;
    let mut found = Localization::new(increments);
    let (mut here, mut flow) = walk.point(0.0)?;
    found.notice(&here, |_| None);
    for count in 1..=increments {
        let fraction = count as f64 / increments as f64;
        let target = loading.slip * fraction * fraction;
        if target <= here.slip {
            continue;
        }
        let step = (target - here.slip) * flow.strain_per_slip;
        let reached = walk.advanced(step).and_then(|next| {
            let (point, flow) = next.point_after(&here, &flow, step)?;
            Ok((next, point, flow))
        });
        let (next, point, rates) = match reached {
            Ok(reached) => reached,
            Err(error) => {
                found.end = End::of(&error);
                if let PlasticityError::Law(refusal) = error {
                    found.refusal = Some(refusal);
                }
                break;
            }
        };
        found.notice(&point, |criterion| {
            walk.crossing(&here, &flow, step, criterion)
        });
        (walk, here, flow) = (next, point, rates);
    }
    Ok(found)
}

/// Rates of continued flow from a state.
#[derive(Clone, Copy)]
struct Rates {
    /// Coefficients of `dgamma = slip . de` in the strains along the axes.
    slip: Vector3<f64>,
    /// Driving strain per unit of slip along the path.
    strain_per_slip: f64,
}

/// Tangent of continued flow, with the direction of strain of the flow.
struct Continued {
    direction: Vector3<f64>,
    /// Tangent in the measures of [`Answer`].
    normal: Matrix3<f64>,
    shear: Matrix3<f64>,
    swap: Matrix3<f64>,
}

/// Stress and moduli of an increment along the axes.
struct Answer {
    /// Cauchy stress along the axes.
    stress: Vector3<f64>,
    /// Derivatives `d sigma_i / d e_j` of the stress.
    slope: Matrix3<f64>,
    /// Derivatives `d tau_i / d e_j` in the strain measure of the loading.
    normal: Matrix3<f64>,
    /// Moduli `a_iijj`, `a_ijij` and `a_ijji`.
    moduli: [Matrix3<f64>; 3],
    /// Stress in the measure of the loading.
    driving: Vector3<f64>,
}

/// State reached by a sequence of increments.
#[derive(Clone)]
struct Increments<'a> {
    law: &'a dyn IncrementalLaw,
    loading: &'a Loading,
    course: Course,
    /// Logarithmic strains at the ends of the increments.
    history: Vec<Vector3<f64>>,
    /// Strain per unit of driving strain in the last increment.
    direction: Vector3<f64>,
    /// Strain of the confined state, along every axis.
    initial: f64,
    /// Driving strain at first yield.
    scale: f64,
}

impl<'a> Increments<'a> {
    fn new(law: &'a dyn IncrementalLaw, loading: &'a Loading) -> Result<Self, PlasticityError> {
        let course = Course::new(loading)?;
        let mut walk = Self {
            law,
            loading,
            course,
            history: Vec::new(),
            direction: course.direction(),
            initial: 0.0,
            scale: SMALLEST_STRAIN,
        };
        walk.confine()?;
        Ok(walk)
    }

    /// Computes the state under the pressure alone, in one increment.
    fn confine(&mut self) -> Result<(), PlasticityError> {
        let pressure = self.loading.confinement;
        if pressure == 0.0 {
            return Ok(());
        }
        let mut strain = 0.0;
        for _ in 0..ITERATIONS {
            let answer = self.answer(&[Vector3::repeat(strain)])?;
            let bulk = answer.slope.sum() / 9.0;
            let change = -(answer.stress.mean() + pressure) / (3.0 * bulk);
            strain += change;
            if change.abs() <= 1e-12 * strain.abs() {
                self.initial = strain;
                self.history = vec![Vector3::repeat(strain)];
                return Ok(());
            }
        }
        Err(PlasticityError::Confinement {
            confinement: pressure,
        })
    }

    /// Response of the law after additional increments.
    fn answer(&self, more: &[Vector3<f64>]) -> Result<Answer, PlasticityError> {
        let history = self.history.iter().chain(more);
        let states = history.map(|strain| {
            DeformationGradient::from_stretches(strain.map(f64::exp).into())
                .map_err(|_| PlasticityError::NotFinite)
        });
        let states = states.collect::<Result<Vec<_>, _>>()?;
        let response = self.law.after(&states)?;
        Answer::of(&response, self.loading.strains)
    }

    fn strain(&self) -> Vector3<f64> {
        self.history.last().copied().unwrap_or_default()
    }

    /// Strains after an increment of the driving strain, with lateral strains that keep the lateral stresses constant.
    fn balanced(&self, driving: f64) -> Result<Vector3<f64>, PlasticityError> {
        let start = self.strain();
        let mut strain = start + self.direction * driving;
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let answer = self.answer(&[strain])?;
            let mut matrix = Matrix3::identity();
            let mut rest = Vector3::zeros();
            for i in (0..3).filter(|i| self.course.prescribed[*i].is_none()) {
                rest[i] = answer.stress[i] + self.loading.confinement;
                matrix.set_row(i, &answer.slope.row(i));
            }
            let correction = matrix.lu().solve(&rest);
            let correction = correction.filter(|found| found.iter().all(|x| x.is_finite()));
            let correction = correction.ok_or(PlasticityError::NoBalance)?;
            let size = correction.amax();
            let scale = self.scale.max(driving.abs());
            let small = rest.amax() <= STRESS_TOLERANCE * answer.normal.amax() * scale;
            if size <= STRAIN_TOLERANCE * scale || (size >= 0.5 * last && small) {
                return Ok(strain);
            }
            last = size;
            strain -= correction;
        }
        Err(PlasticityError::NoBalance)
    }

    /// State after an additional increment.
    fn advanced(&self, driving: f64) -> Result<Self, PlasticityError> {
        let strain = self.balanced(driving)?;
        let mut next = self.clone();
        next.direction = (strain - self.strain()) / driving;
        next.history.push(strain);
        Ok(next)
    }

    /// Elastic tangent of a state, from a small increment backward.
    fn unloading(&self) -> Result<Answer, PlasticityError> {
        self.answer(&[self.strain() - self.direction * (PROBE_SIZE * self.scale)])
    }

    /// Advances to first yield in one increment, whose length is bisected until the shortest increment with flow is known to rounding.
    fn yield_first(&mut self) -> Result<(), PlasticityError> {
        let at = |driving: f64| {
            let mut trial = self.clone();
            trial.scale = driving;
            let trial = trial.advanced(driving)?;
            let own = trial.answer(&[])?.normal;
            let elastic = trial.unloading()?.normal;
            let flows = (elastic - own).amax() > FLOW_THRESHOLD * elastic.amax();
            Ok::<_, PlasticityError>((trial, flows))
        };
        let (mut low, mut high) = (0.0, SMALLEST_STRAIN);
        let mut yielded = loop {
            let (trial, flows) = at(high)?;
            if flows {
                break trial;
            }
            (low, high) = (high, TRIAL_GROWTH_FACTOR * high);
            if high > LARGEST_STRAIN {
                return Err(PlasticityError::NeverYields {
                    strain: LARGEST_STRAIN,
                });
            }
        };
        if low == 0.0 {
            return Err(PlasticityError::NoElasticRange);
        }
        while high - low > 1e-13 * high {
            let middle = 0.5 * (low + high);
            let (trial, flows) = at(middle)?;
            if flows {
                (high, yielded) = (middle, trial);
            } else {
                low = middle;
            }
        }
        *self = yielded;
        Ok(())
    }

    /// Tangent of continued flow: the limit of small increments along the path.
    fn flowing(&self) -> Result<Continued, PlasticityError> {
        let size = PROBE_SIZE * self.scale;
        // The direction of the path changes abruptly when flow begins.
        let mut ahead = self.clone();
        let strain = ahead.balanced(2.0 * size)?;
        ahead.direction = (strain - self.strain()) / (2.0 * size);
        let near = self.answer(&[self.strain() + ahead.direction * size])?;
        let far = self.answer(&[strain])?;
        let limit = |near: Matrix3<f64>, far: Matrix3<f64>| near * 2.0 - far;
        let [_, near_shear, near_swap] = near.moduli;
        let [_, far_shear, far_swap] = far.moduli;
        Ok(Continued {
            direction: ahead.direction,
            normal: limit(near.normal, far.normal),
            shear: limit(near_shear, far_shear),
            swap: limit(near_swap, far_swap),
        })
    }

    /// State of the path at a plastic shear strain with its critical moduli, and the rates of continued flow.
    fn point(&self, slip: f64) -> Result<(PathPoint, Rates), PlasticityError> {
        let elastic = self.unloading()?;
        let own = self.answer(&[])?;
        let Continued {
            direction,
            normal,
            shear,
            swap,
        } = self.flowing()?;
        let taken = Taken::of(&elastic.normal, &normal, &direction)?;
        let per_strain = taken.loading / taken.stiffness;
        let rates = Rates {
            slip: per_strain,
            strain_per_slip: per_strain.dot(&direction).recip(),
        };
        let bulk = RateModuli {
            normal: elastic.moduli[0],
            shear,
            swap,
            flow: taken.flow,
            loading: taken.loading,
            modulus: taken.stiffness - taken.relaxation,
            relaxation: taken.relaxation,
            frame: Matrix3::identity(),
            stress: own.driving,
            isotropic: false,
            sheet: false,
        };
        let moduli = match self.loading.bands {
            Bands::Bulk => bulk,
            Bands::Sheet => bulk.in_sheet(),
        };
        let point = PathPoint {
            slip,
            strain: (self.strain().add_scalar(-self.initial)).into(),
            stress: own.stress.into(),
            modulus: moduli.modulus(),
            ellipticity: moduli.critical(Criterion::Ellipticity)?,
            strong_ellipticity: moduli.critical(Criterion::StrongEllipticity)?,
            moduli,
        };
        Ok((point, rates))
    }

    /// State of the path after an increment. The slip uses the mean of its rates at both ends.
    fn point_after(
        &self,
        before: &PathPoint,
        rates: &Rates,
        driving: f64,
    ) -> Result<(PathPoint, Rates), PlasticityError> {
        let (mut point, own) = self.point(before.slip)?;
        let increment = self.direction * driving;
        point.slip += 0.5 * (rates.slip + own.slip).dot(&increment);
        Ok((point, own))
    }

    /// First state beyond the point in an increment where the modulus falls to the critical modulus.
    fn crossing(
        &self,
        before: &PathPoint,
        rates: &Rates,
        driving: f64,
        criterion: Criterion,
    ) -> Option<PathPoint> {
        let at = |part: f64| {
            let reached = self.advanced(part * driving).ok()?;
            let point = reached.point_after(before, rates, part * driving).ok()?.0;
            Some(point)
        };
        let (mut low, mut high, mut found) = (0.0, 1.0, None);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let point = at(middle)?;
            if point.margin(criterion) > 0.0 {
                low = middle;
            } else {
                (high, found) = (middle, Some(point));
            }
        }
        found
    }
}

impl Answer {
    fn of(response: &Response, strains: Strains) -> Result<Self, PlasticityError> {
        let tangent = &response.tangent;
        is_along_axes(tangent)?;
        let f = Vector3::from_fn(|i, _| response.deformation.components()[i][i]);
        let volume = f.product();
        let tau = response.first_piola.diagonal().component_mul(&f);
        let stress = tau / volume;
        let normal = Matrix3::from_fn(|i, j| f[i] * tangent[(i, i, j, j)] * f[j]);
        let shear = Matrix3::from_fn(|i, j| tangent[(i, j, i, j)] * f[j] * f[j]);
        let swap = Matrix3::from_fn(|i, j| tangent[(i, j, j, i)] * f[j] * f[i]);
        // Kirchhoff stress in terms of logarithmic strains, and Cauchy stress.
        let kirchhoff = normal + Matrix3::from_diagonal(&tau);
        let slope = kirchhoff / volume - stress * Vector3::repeat(1.0).transpose();
        Ok(match strains {
            Strains::Finite => Self {
                stress,
                slope,
                normal: kirchhoff,
                moduli: [normal, shear, swap],
                driving: tau,
            },
            // At small strain the stress rates have no stress terms: the shear moduli belong to the Jaumann rate.
            Strains::Small => {
                let plain = Matrix3::from_fn(|i, j| match i == j {
                    true => 0.0,
                    false => shear[(i, j)] / volume + 0.5 * (stress[i] - stress[j]),
                });
                let normal = kirchhoff / volume;
                Self {
                    stress,
                    slope,
                    normal,
                    moduli: [normal, plain, plain],
                    driving: stress,
                }
            }
        })
    }
}

/// Checks that a tangent couples neither shears with normal strains nor different shears with each other.
fn is_along_axes(tangent: &FourthOrder) -> Result<(), PlasticityError> {
    let (mut largest, mut other) = (0.0_f64, 0.0_f64);
    for n in 0..81 {
        let at @ (i, j, k, l) = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
        let size = tangent[at].abs();
        let belongs = (i == j && k == l) || (i == k && j == l) || (i == l && j == k);
        match belongs {
            true => largest = largest.max(size),
            false => other = other.max(size),
        }
    }
    match other <= ZERO_COMPONENT_FRACTION * largest {
        true => Ok(()),
        false => Err(PlasticityError::NotAlongAxes),
    }
}

/// Reduction of the elastic tangent by flow.
struct Taken {
    /// Direction of the stress relaxed by flow, `C:P`.
    flow: Vector3<f64>,
    /// Vector `Q:C` that multiplies the strain.
    loading: Vector3<f64>,
    /// Denominator `h + Q:C:P` of the reduction.
    stiffness: f64,
    /// Relaxation `Q:C:P` by flow.
    relaxation: f64,
}

impl Taken {
    /// Computes the reduction from the elastic tangent and the tangent of continued flow in a direction of strain.
    fn of(
        elastic: &Matrix3<f64>,
        flowing: &Matrix3<f64>,
        direction: &Vector3<f64>,
    ) -> Result<Self, PlasticityError> {
        let difference = elastic - flowing;
        let parts = difference.svd(true, true);
        let (Some(left), Some(right)) = (parts.u, parts.v_t) else {
            return Err(PlasticityError::NotFinite);
        };
        let order = parts.singular_values;
        let first = order.imax();
        let size = order[first];
        let rest = (0..3).filter(|n| *n != first).map(|n| order[n]);
        if size <= FLOW_THRESHOLD * elastic.amax() {
            return Err(PlasticityError::Unloads);
        }
        if rest.fold(0.0, f64::max) > ZERO_COMPONENT_FRACTION.sqrt() * size {
            return Err(PlasticityError::SeveralMechanisms);
        }
        let (mut a, mut b) = (
            left.column(first).into_owned(),
            right.row(first).transpose(),
        );
        // Orient the factors so that flow continues along the path.
        if b.dot(direction) < 0.0 {
            (a, b) = (-a, -b);
        }
        let not_elliptic = PlasticityError::ElasticNotElliptic;
        let plastic = elastic.lu().solve(&a).ok_or(not_elliptic.clone())?;
        let normal = elastic.transpose().lu().solve(&b).ok_or(not_elliptic)?;
        let (of_flow, of_normal) = (unit(&plastic), unit(&normal));
        let stiffness = 1.0 / (size * of_flow * of_normal);
        Ok(Self {
            flow: a / of_flow,
            loading: b / of_normal,
            stiffness,
            relaxation: b.dot(&plastic) / (of_flow * of_normal),
        })
    }
}

/// Norm of a direction of flow: the norm of the deviator times `sqrt(2)`, or the norm of the direction itself if its deviator vanishes.
fn unit(direction: &Vector3<f64>) -> f64 {
    let deviator = direction.add_scalar(-direction.mean());
    let size = std::f64::consts::SQRT_2 * deviator.norm();
    match size > 1e-6 * direction.norm() {
        true => size,
        false => direction.norm(),
    }
}
