//! Metals as materials of a discretization: stress and tangent of continued flow at the end of a proportional path.
//!
//! `F = F_e F_p` with Hencky's law for `F_e`. With the Mandel stress `M` (symmetric, in the material axes of the metal, which flow does not rotate),
//! `E_e = 1/2 ln F_e^T F_e` and `M = 2 mu dev E_e + kappa tr E_e`, Hill's yield stress (R. Hill, *Proc. R. Soc. A* 193 (1948) 281)
//!
//! `phi^2 = f (M22 - M33)^2 + g (M33 - M11)^2 + h (M11 - M22)^2 + 3 (M23^2 + M13^2) + 2 n M12^2`
//!
//! reaches the flow stress `sigma_y(e)`, and `dF_p/dt F_p^-1 = N de/dt` with the normal `N = dphi/dM`, without plastic spin. With equal strain ratios
//! `phi` is the von Mises stress, and the law is J2.
//!
//! A state `F = R U` is reached along `R U^t`, `0 <= t <= 1`, which is also the path used for Abaqus user materials. For J2 the strains keep their
//! direction, and the flow follows from one step in closed form. For other strain ratios the rates are integrated.
//!
//! **Tangent.** Let `w(F, e) = W(F F_p^-1 exp(-e N))` be the elastic energy at a flow `e` that follows the state. Then `P = dw/dF`, and the work
//! dissipated by the flow is `-dw/de = M : N = phi`. Continued flow keeps `phi = sigma_y`, so `e` is eliminated from the rates like an internal
//! variable from an energy:
//!
//! `A = w_FF - w_Fe (x) w_Fe / (w_ee + dsigma_y/de)`,
//!
//! which is symmetric. It is the tangent of R. Hill's linear comparison solid (*J. Mech. Phys. Solids* 6 (1958) 236). A perturbation that unloads
//! meets a stiffer material, so a state that is stable for this tangent is stable. A loss of stability requires perturbations for which loading
//! continues everywhere, as for growing waves under a growing load.

use super::coaxial::elasticity;
use super::integration::{Stop, Stopped, integrate};
use super::spectral::Spectral;
use super::walk::bisect;
use super::{DruckerPrager, FlowStress, Hardening, HillOrthotropic, PlasticityError};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::material::{
    Admitted, FourthOrder, Hyperelastic, Law, Made, MaterialError, Parameter, Response, Symmetry,
    hooke,
};
use nalgebra::{Matrix3, SVector, Vector3};

/// Relative error of the elastic strains along an integrated path.
const ACCURACY: f64 = 1e-10;

const MU: Parameter = Parameter::new("mu", "stress", 80.0, Admitted::Positive, "shear modulus");
const KAPPA: Parameter =
    Parameter::new("kappa", "stress", 170.0, Admitted::Positive, "bulk modulus");
pub(super) const YIELD: Parameter = Parameter::new(
    "yield-stress",
    "stress",
    0.4,
    Admitted::Positive,
    "flow stress at first yield, in tension along the first material axis",
);
pub(super) const MODULUS: Parameter = Parameter::new(
    "hardening-modulus",
    "stress",
    0.2,
    Admitted::Any,
    "slope of the flow stress at large plastic strain, negative for softening",
);
pub(super) const SATURATION: Parameter = Parameter::new(
    "saturation-stress",
    "stress",
    0.2,
    Admitted::Any,
    "increase of the flow stress by saturation, in addition to the slope",
);
pub(super) const RATE: Parameter = Parameter::new(
    "saturation-rate",
    "1",
    15.0,
    Admitted::NotNegative,
    "reciprocal of the plastic strain after which 1/e of the saturation stress is left",
);
pub(super) const EXPONENT: Parameter = Parameter::new(
    "exponent",
    "1",
    0.0,
    Admitted::Within(-100.0, 1.0),
    "exponent of a power law of the flow stress: 0 for none, negative for softening",
);
pub(super) const REFERENCE: Parameter = Parameter::new(
    "reference-strain",
    "1",
    0.01,
    Admitted::Positive,
    "reference strain of the power law",
);

/// Flow stress of the parameters `yield-stress`, `hardening-modulus`, `saturation-stress`, `saturation-rate`, `exponent` and `reference-strain`.
fn flow_stress(p: &[f64]) -> FlowStress {
    FlowStress {
        initial: p[0],
        modulus: p[1],
        saturation: p[2],
        rate: p[3],
        exponent: p[4],
        reference: p[5],
    }
}

/// Strength in shear of the same parameters.
pub(super) fn strength(p: &[f64]) -> Hardening {
    Hardening::Metal(flow_stress(p).in_shear())
}

pub(super) const J2: Law = Law {
    name: "j2",
    formula: "Hencky's law with mu, kappa; sqrt(3/2) |dev M| = yield-stress (1 + e/reference-strain)^exponent + hardening-modulus e + saturation-stress (1 - exp(-saturation-rate e))",
    parameters: &[
        MU, KAPPA, YIELD, MODULUS, SATURATION, RATE, EXPONENT, REFERENCE,
    ],
    domain: "all J > 0; metals on monotonic, proportional paths; tangent of continued flow",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "von Mises, Nachr. Ges. Wiss. Goettingen (1913) 582; flow stress of Simo and Hughes, Computational Inelasticity (1998), and Swift, J. Mech. Phys. Solids 1 (1952) 1; defaults: typical \
             of a mild steel, GPa",
    stiffness: |p| hooke(p[0], p[1]),
    make: |p| metal(p, [1.0; 3], 0.0),
};

/// J2 from its parameters, as a law that flows along the axes of a path.
pub(super) fn j2(p: &[f64]) -> Result<DruckerPrager, PlasticityError> {
    DruckerPrager::von_mises(p[0], elasticity(p).poisson_ratio(), strength(&p[2..]))
}

pub(super) const HILL: Law = Law {
    name: "hill-1948",
    formula: "as j2 with phi^2 = f (M22 - M33)^2 + g (M33 - M11)^2 + h (M11 - M22)^2 + 3 (M23^2 + M13^2) + 2 n M12^2 = sigma_y^2, \
              g = 1/(1 + r0), h = r0 g, f = r0 g/r90, n = (r0 + r90)(1 + 2 r45) g/(2 r90)",
    parameters: &[
        MU,
        KAPPA,
        YIELD,
        MODULUS,
        SATURATION,
        RATE,
        EXPONENT,
        REFERENCE,
        ratio("r0", 1.8),
        ratio("r45", 1.3),
        ratio("r90", 2.1),
        Parameter::new(
            "angle",
            "deg",
            0.0,
            Admitted::Any,
            "angle from axis 1 to the first material axis, in the plane",
        ),
    ],
    domain: "all J > 0; rolled sheet, axis 3 across it, on monotonic, proportional paths; tangent of continued flow",
    symmetry: Symmetry::Orthotropic,
    source: "Hill, Proc. R. Soc. A 193 (1948) 281; defaults: typical of a deep-drawing steel, GPa",
    make: |p| metal(p, [p[8], p[9], p[10]], p[11]),
    ..J2
};

/// Hill's law from its parameters, as a law that flows along the axes of a path.
pub(super) fn hill(p: &[f64]) -> Result<HillOrthotropic, PlasticityError> {
    PlasticityError::require(
        p[11] == 0.0,
        "angle",
        p[11],
        "0: the axes of the material are the axes of the path",
    )?;
    HillOrthotropic::new(elasticity(p), p[8], p[10], strength(&p[2..]))
}

const fn ratio(name: &'static str, default: f64) -> Parameter {
    Parameter::new(
        name,
        "1",
        default,
        Admitted::Positive,
        "Lankford's ratio of width to thickness strain in tension at the angle in its name (degrees) to the first material axis",
    )
}

/// Hill's quadratic yield function.
#[derive(Clone, Copy, Debug)]
struct Hill {
    f: f64,
    g: f64,
    h: f64,
    n: f64,
}

impl Hill {
    fn of_ratios([r0, r45, r90]: [f64; 3]) -> Self {
        let g = 1.0 / (1.0 + r0);
        Self {
            f: r0 * g / r90,
            g,
            h: r0 * g,
            n: (r0 + r90) * (1.0 + 2.0 * r45) * g / (2.0 * r90),
        }
    }

    /// Yield stress `phi` and its normal `dphi/dM`; the normal is undefined without a deviator.
    fn yield_stress(&self, m: &Matrix3<f64>) -> (f64, Matrix3<f64>) {
        let [a, b, c] = [
            self.f * (m[(1, 1)] - m[(2, 2)]),
            self.g * (m[(2, 2)] - m[(0, 0)]),
            self.h * (m[(0, 0)] - m[(1, 1)]),
        ];
        let shear = [1.5 * m[(1, 2)], 1.5 * m[(0, 2)], self.n * m[(0, 1)]];
        let half = Matrix3::new(
            c - b,
            shear[2],
            shear[1],
            shear[2],
            a - c,
            shear[0],
            shear[1],
            shear[0],
            b - a,
        );
        let phi = half.dot(m).max(0.0).sqrt();
        (phi, if phi > 0.0 { half / phi } else { half })
    }
}

/// Flow at an elastic deformation.
struct Flow {
    normal: Matrix3<f64>,
    /// Dual normal `Y` with `N : dM = Y : dC_e`.
    dual: Matrix3<f64>,
    /// Second derivative `w_ee` of the energy.
    stiffness: f64,
}

/// Elastic-plastic law with its parameters.
struct Metal {
    elastic: Box<dyn Hyperelastic>,
    mu: f64,
    kappa: f64,
    flow_stress: FlowStress,
    hill: Hill,
    is_isotropic: bool,
    /// Returns true if the principal axes of a symmetric tensor are the fixed axes, to the last digit.
    frame: Matrix3<f64>,
}

/// Creates the law from the parameters of J2, Lankford's ratios and the angle of the material axes.
fn metal(p: &[f64], ratios: [f64; 3], degrees: f64) -> Made {
    let elastic = Law::named("hencky").ok_or_else(|| MaterialError::UnknownParameter {
        law: "j2",
        name: "hencky".to_owned(),
    })?;
    let flow_stress = flow_stress(&p[2..]);
    let hill = Hill::of_ratios(ratios);
    // The elastic response to flow is at least 2 mu |N|^2, where |N|^2 is 3/2 for J2 and its lower bound follows from the ratios.
    let least = -2.0 * p[0] * hill.smallest_normal();
    if flow_stress.lowest_slope() <= least {
        return Err(MaterialError::Parameter {
            name: "hardening-modulus",
            value: flow_stress.lowest_slope(),
            expected: format!(
                "a slope of the flow stress above {least:?}; for smaller slopes a strain does not determine the stress"
            ),
        });
    }
    let (sine, cosine) = degrees.to_radians().sin_cos();
    Ok(Box::new(Metal {
        elastic: elastic.build(&[("mu", p[0]), ("kappa", p[1])])?,
        mu: p[0],
        kappa: p[1],
        flow_stress,
        hill,
        is_isotropic: ratios == [1.0; 3],
        frame: Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0),
    }))
}

/// Material axes, as columns.
fn is_diagonal(tensor: &Matrix3<f64>) -> bool {
    [(0, 1), (0, 2), (1, 2)]
        .into_iter()
        .all(|at| tensor[at] == 0.0)
}

/// Error for a state that a metal cannot reach.
fn no_path<const N: usize>(stopped: Stopped<N, ()>) -> MaterialError {
    MaterialError::OutsideDomain {
        what: "the fraction of the path that must be followed",
        value: 1.0,
        expected: match stopped.why {
            Stop::Rates(()) => {
                "along it the metal must keep flowing with a positive flow stress".to_owned()
            }
            Stop::TooManySteps => {
                "too many short steps are needed; try a smaller strain or less softening".to_owned()
            }
        },
    }
}

impl Hill {
    /// Lower bound of `|N|^2` over all stresses: `N = A M/phi` with `phi^2 = M : A M`, so `|N|^2` is at least the smallest eigenvalue of `A` on
    /// deviators.
    fn smallest_normal(&self) -> f64 {
        let Self { f, g, h, n } = *self;
        // Normal components: (f + g + h) -+ a square root, from the trace and the sum of the minors of A.
        let (sum, minors) = (f + g + h, 3.0 * (f * g + g * h + h * f));
        let normal = sum - (sum * sum - minors).max(0.0).sqrt();
        normal.min(1.5).min(n)
    }
}

impl Metal {
    /// Mandel stress `2 mu dev T + kappa tr T 1` of an elastic strain `T`.
    fn stiff(&self, tensor: &Matrix3<f64>) -> Matrix3<f64> {
        let trace = tensor.trace();
        tensor * (2.0 * self.mu) + Matrix3::identity() * ((self.kappa - self.mu / 1.5) * trace)
    }

    /// Flow at an elastic deformation; `None` if it is undefined.
    fn flow(&self, elastic: &Matrix3<f64>) -> Option<Flow> {
        let metric = elastic.transpose() * elastic;
        let spectrum = Spectral::positive(&metric)?;
        let strain = spectrum.map(|square| 0.5 * square.ln());
        let (_, normal) = self.hill.yield_stress(&self.stiff(&strain));
        let dual = spectrum.dual_of_logarithm(&self.stiff(&normal));
        let stiffness = 2.0 * dual.dot(&(metric * normal));
        Some(Flow {
            normal,
            dual,
            stiffness,
        })
    }

    /// Plastic `F_p^-1` and slip at the end of the path to a symmetric stretch, given by its logarithm; `None` if the path is elastic.
    fn flowed(&self, logarithm: &Spectral) -> Result<Option<(Matrix3<f64>, f64)>, MaterialError> {
        let strain = logarithm.map(|value| value);
        let (trial, normal) = self.hill.yield_stress(&self.stiff(&strain));
        if trial <= self.flow_stress.initial {
            return Ok(None);
        }
        if self.is_isotropic {
            let slip = self.slip_of_trial(trial)?;
            let inverse = Spectral::of(&(normal * -slip)).map(f64::exp);
            return Ok(Some((inverse, slip)));
        }
        let first = self.flow_stress.initial / trial;
        let end = match is_diagonal(&strain) {
            true => self.coaxial(&strain.diagonal(), first)?,
            false => self.integrated(logarithm, first)?,
        };
        Ok(Some(end))
    }

    /// Solution `e` of `trial - 3 mu e = sigma_y(e)`, whose left side decreases faster.
    fn slip_of_trial(&self, trial: f64) -> Result<f64, MaterialError> {
        let excess = |slip: f64| trial - 3.0 * self.mu * slip - self.flow_stress.at(slip);
        let slip = bisect(0.0, trial / (3.0 * self.mu), |slip| excess(slip) > 0.0);
        self.has_strength(slip)?;
        Ok(slip)
    }

    fn has_strength(&self, slip: f64) -> Result<(), MaterialError> {
        let value = self.flow_stress.at(slip);
        if value > 0.0 {
            return Ok(());
        }
        Err(MaterialError::OutsideDomain {
            what: "the flow stress",
            value,
            expected: format!(
                "softening has reduced it to zero before the plastic strain {slip:?}"
            ),
        })
    }

    /// Integrates the flow along `U^t` from first yield to the end if the principal axes of `U` are the material axes. All tensors are diagonal, and
    /// the logarithms of the elastic and the plastic stretches add up.
    fn coaxial(
        &self,
        logarithm: &Vector3<f64>,
        first: f64,
    ) -> Result<(Matrix3<f64>, f64), MaterialError> {
        let rates = |y: &SVector<f64, 4>, t: f64| {
            let elastic = logarithm * t - y.fixed_rows::<3>(0);
            let mandel = self.stiff(&Matrix3::from_diagonal(&elastic));
            let normal = self.hill.yield_stress(&mandel).1.diagonal();
            // The normal is a deviator, so the bulk modulus does not contribute.
            let driving = 2.0 * self.mu * normal.dot(logarithm);
            let stiffness = 2.0 * self.mu * normal.norm_squared();
            let rate = driving / (stiffness + self.flow_stress.slope(y[3]));
            if !(rate >= 0.0 && rate.is_finite()) || self.flow_stress.at(y[3]) <= 0.0 {
                return Err(());
            }
            Ok((normal * rate).push(rate))
        };
        let size = SVector::repeat(self.flow_stress.initial / self.mu);
        let start = SVector::zeros();
        let end = integrate(&start, [first, 1.0], |_| size, ACCURACY, rates).map_err(no_path)?;
        self.has_strength(end[3])?;
        let inverse = end.fixed_rows::<3>(0).map(|plastic| (-plastic).exp());
        Ok((Matrix3::from_diagonal(&inverse), end[3]))
    }

    /// Integrates the flow along `U^t` from first yield to the end.
    fn integrated(
        &self,
        logarithm: &Spectral,
        first: f64,
    ) -> Result<(Matrix3<f64>, f64), MaterialError> {
        let speed = logarithm.map(|value| value);
        let rates = |y: &SVector<f64, 10>, t: f64| {
            let inverse = Matrix3::from_column_slice(&y.as_slice()[..9]);
            let stretch = logarithm.map(|value| (t * value).exp());
            let elastic = stretch * inverse;
            let flow = self.flow(&elastic).ok_or(())?;
            let driving = 2.0
                * flow
                    .dual
                    .dot(&(elastic.transpose() * speed * stretch * inverse));
            let rate = driving / (flow.stiffness + self.flow_stress.slope(y[9]));
            if !(rate >= 0.0 && rate.is_finite()) || self.flow_stress.at(y[9]) <= 0.0 {
                return Err(());
            }
            let change = inverse * flow.normal * -rate;
            let mut out = SVector::<f64, 10>::zeros();
            out.as_mut_slice()[..9].copy_from_slice(change.as_slice());
            out[9] = rate;
            Ok(out)
        };
        let mut start = SVector::<f64, 10>::zeros();
        start.as_mut_slice()[..9].copy_from_slice(Matrix3::<f64>::identity().as_slice());
        let size = SVector::repeat(self.flow_stress.initial / self.mu);
        let end = integrate(&start, [first, 1.0], |_| size, ACCURACY, rates).map_err(no_path)?;
        self.has_strength(end[9])?;
        Ok((Matrix3::from_column_slice(&end.as_slice()[..9]), end[9]))
    }

    /// Stress and tangents of unloading and of continued flow at given elastic and plastic deformations.
    fn flowing(
        &self,
        f: &DeformationGradient,
        inverse: &Matrix3<f64>,
        slip: f64,
    ) -> Result<[Response; 2], MaterialError> {
        let elastic = f.matrix() * inverse;
        let not_finite = || MaterialError::NotFinite {
            jacobian: f.jacobian(),
        };
        let components = array_of(|i| array_of(|j| elastic[(i, j)]));
        let state = DeformationGradient::new(components).map_err(|_| not_finite())?;
        let own = self.elastic.response(&state)?;
        let flow = self.flow(&elastic).ok_or_else(not_finite)?;
        // Second derivatives: w_Fe = -Q, and w_FF by the chain rule.
        let q = elastic * flow.dual * inverse.transpose() * 2.0;
        let stiffness = flow.stiffness + self.flow_stress.slope(slip);
        let unloading = Response {
            deformation: *f,
            energy: own.energy,
            first_piola: own.first_piola * inverse.transpose(),
            tangent: own.tangent.with_material_indices(inverse),
        };
        let continued = FourthOrder::from_fn(|i, j, k, l| {
            unloading.tangent[(i, j, k, l)] - q[(i, j)] * q[(k, l)] / stiffness
        });
        let continued = Response {
            tangent: continued,
            ..unloading.clone()
        };
        Ok([unloading.finite()?, continued.finite()?])
    }

    /// Responses of a state whose material axes are the fixed axes: to unloading, and to continued flow if the state flows.
    fn along_axes(
        &self,
        f: &DeformationGradient,
    ) -> Result<(Response, Option<Response>), MaterialError> {
        let matrix = f.matrix();
        let logarithm =
            Spectral::half_logarithm(&(matrix.transpose() * matrix)).ok_or_else(|| {
                MaterialError::NotFinite {
                    jacobian: f.jacobian(),
                }
            })?;
        Ok(match self.flowed(&logarithm)? {
            None => (self.elastic.response(f)?, None),
            Some((inverse, slip)) => {
                let [unloading, continued] = self.flowing(f, &inverse, slip)?;
                (unloading, Some(continued))
            }
        })
    }

    /// Responses of a state: to unloading, and to continued flow if the state flows.
    fn responses(
        &self,
        f: &DeformationGradient,
    ) -> Result<(Response, Option<Response>), MaterialError> {
        if self.frame == Matrix3::identity() {
            return self.along_axes(f);
        }
        let turned = f.matrix() * self.frame;
        let components = array_of(|i| array_of(|j| turned[(i, j)]));
        let state = DeformationGradient::new(components).map_err(|_| MaterialError::NotFinite {
            jacobian: f.jacobian(),
        })?;
        let back = |own: Response| Response {
            deformation: *f,
            energy: own.energy,
            first_piola: own.first_piola * self.frame.transpose(),
            tangent: own.tangent.with_material_indices(&self.frame),
        };
        let (unloading, continued) = self.along_axes(&state)?;
        Ok((back(unloading), continued.map(back)))
    }
}

impl Hyperelastic for Metal {
    fn is_path_dependent(&self) -> bool {
        true
    }

    /// Response of the law. Its energy is the stored elastic energy; stress and tangent of a flowing metal have no potential.
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let (unloading, continued) = self.responses(f)?;
        Ok(continued.unwrap_or(unloading))
    }

    fn unloading_tangent(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        let (unloading, continued) = self.responses(f)?;
        Ok(continued.map(|_| unloading.tangent))
    }
}
