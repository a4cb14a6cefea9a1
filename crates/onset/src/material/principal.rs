//! Isotropic energies as functions of the principal stretches.
//!
//! With `e_i = lambda_i^2` the eigenvalues of `C`, `g_i = dW/de_i` and `h_ij = d^2 W / de_i de_j`, in the principal axes,
//!
//! `W(C + D) = W + sum_i g_i D_ii + 1/2 sum_ij h_ij D_ii D_jj + sum_(i<j) theta_ij D_ij^2 + ...`, `theta_ij = (g_i - g_j) / (e_i - e_j)`.
//!
//! If the stiffness against changes of volume is much larger than all others, the energy is differentiated with respect to `y_0 = ln J` and two
//! coordinates `y_1`, `y_2` of the isochoric part, `h_i = ln lambda_i = y_0/3 + b_1i y_1 + b_2i y_2`. The stiffness against changes of volume,
//! `d^2 W/dy_0^2`, is then a separate number. It may exceed all others by any factor, and its rounding does not affect volume-preserving
//! strains. With `w_i = dW/dh_i`, `g_i = w_i / (2 e_i)` and
//!
//! `theta_ij = (w_i - w_j) / (e_i - e_j) (1/e_i + 1/e_j) / 4 - (w_i + w_j) / (4 e_i e_j)`.
//!
//! The quotient is 0/0 where two stretches coincide. Since `W` is invariant under permutations of the stretches, `w_j` is `w_i` with the two
//! exchanged, and along the segment from `(h_i, h_j)` to `(h_j, h_i)`
//!
//! `(w_i - w_j) / (h_i - h_j) = integral over 0 < t < 1 of 1/2 (W_ii + W_jj - 2 W_ij)`, `W_ij = d^2 W / dh_i dh_j`,
//!
//! which has no quotient. It is evaluated by Gauss-Legendre quadrature where the two stretches are close. Elsewhere, and where the integrand varies too
//! much for the quadrature, as with exponents of a hundred, the quotient is used.

use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::real::{Interval, Jet, Real};

/// Isotropic energy as a function of the principal stretches.
pub trait PrincipalEnergy {
    /// Energy `W(lambda_1, lambda_2, lambda_3)` per reference volume, invariant under permutations of the stretches; units of stress. It must use
    /// operations of [`Real`] only, without branches on its arguments.
    fn of_stretches<R: Real>(&self, stretches: [R; 3]) -> R;

    /// Returns true if the function is known to be defined at all stretches of some intervals. Undefined terms that cancel do not appear in the
    /// bounds of their sum.
    fn is_defined(&self, _stretches: [Interval; 3]) -> bool {
        true
    }
}

/// Largest relative difference of eigenvalues of `C` that count as close. At this difference the quotient has lost less than two digits, and the
/// error of the five-point quadrature is less than `1e-15` for exponents of the stretches up to ten.
const RELATIVE_EIGENVALUE_DISTANCE: f64 = 0.05;

/// Points of the Gauss-Legendre rule of order 10 on `(0, 1)` from its midpoint on, with weights. The rule and the integrand are symmetric about the
/// midpoint.
const RULE: [(f64, f64); 3] = [
    (0.5, 64.0 / 225.0),
    (0.769_234_655_052_841_5, 0.478_628_670_499_366_47),
    (0.953_089_922_969_332, 0.236_926_885_056_189_08),
];

/// Energy at a state as a function of the principal stretches. Units of stress.
///
/// For jets over floating-point numbers it is exact to second order: stresses and tangents are accurate to rounding even if stretches coincide. For
/// intervals the result encloses the energy and its derivatives. Value and first derivatives are tight. Second derivatives are tight if principal
/// axes and stretches are known closely; otherwise only their largest magnitude is used. If an eigenvalue may be zero, the result is
/// [`Interval::ENTIRE`](crate::real::Interval::ENTIRE).
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{PrincipalEnergy, StrainEnergy, energy_of_stretches, Hyperelastic};
/// use onset::real::Real;
/// /// W = sum (lambda_i^4 - 1) / 4 = (tr C^2 - 3) / 4, hence P = F C
/// struct Quartic;
/// impl PrincipalEnergy for Quartic {
///     fn of_stretches<R: Real>(&self, [a, b, c]: [R; 3]) -> R {
///         (a.powi(4) + b.powi(4) + c.powi(4) - 3.0) * 0.25
///     }
/// }
/// impl StrainEnergy for Quartic {
///     fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
///         energy_of_stretches(self, f)
///     }
/// }
/// let f = DeformationGradient::new([[1.1, 0.3, 0.0], [-0.2, 0.9, 0.1], [0.0, 0.4, 1.2]])?;
/// let m = f.matrix();
/// let error = Quartic.response(&f)?.first_piola - m * m.transpose() * m;
/// assert!(error.amax() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn energy_of_stretches<R: Real>(
    energy: &impl PrincipalEnergy,
    f: &DeformationGradient<R>,
) -> R {
    let c = f.right_cauchy_green();
    if let Some(bounds) = bounds(&c) {
        return enclosed(energy, &c, &bounds).unwrap_or_else(|| nothing_known(&c));
    }
    let expansion = Expansion::of(energy, c.each(|row| row.map(R::number)));
    expansion.at(&c)
}

/// Derivatives of an isotropic energy with respect to `C` at one state, in the principal axes.
struct Expansion {
    /// Principal axes `n_i` in column `i`.
    axes: [[f64; 3]; 3],
    /// Eigenvalues `e_i` of `C`.
    eigenvalues: [f64; 3],
    value: f64,
    /// First derivatives `g_i` with respect to the eigenvalues.
    first: [f64; 3],
    /// Second derivatives `h_ij`, without the part [`Local::volumetric`] divided by `4 e_i e_j`.
    second: [[f64; 3]; 3],
    /// Volumetric stiffness, from [`Local::volumetric`].
    volumetric: f64,
    /// Shear coefficients `theta_12`, `theta_13`, `theta_23`.
    shear: [f64; 3],
}

/// Pairs of axes, in the order of [`Expansion::shear`].
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

impl Expansion {
    /// Computes the expansion; all entries are NaN if a component of the tensor is not a number.
    fn of(energy: &impl PrincipalEnergy, c: [[Option<f64>; 3]; 3]) -> Self {
        let c = c.each(|row| row.each(|component| component.unwrap_or(f64::NAN)));
        let (eigenvalues, axes) = eigen(c);
        let local = Local::of(energy, eigenvalues);
        let [w, e] = [local.slopes(), eigenvalues];
        let shear = PAIRS.each(|(i, j)| {
            let is_close = (e[i] - e[j]).abs() <= RELATIVE_EIGENVALUE_DISTANCE * (e[i] + e[j]);
            let curvature = is_close.then(|| mean_curvature(energy, eigenvalues, (i, j)));
            let quotient = match curvature.flatten() {
                Some(mean) => mean * logarithmic(e[i], e[j]),
                None => local.difference((i, j)) / (e[i] - e[j]),
            };
            0.25 * (quotient * (1.0 / e[i] + 1.0 / e[j]) - (w[i] + w[j]) / (e[i] * e[j]))
        });
        let second = array_of(|i| {
            array_of(|j| {
                let of_axes = if i == j { 2.0 * w[i] } else { 0.0 };
                (local.curvature(i, j) - of_axes) / (4.0 * e[i] * e[j])
            })
        });
        Self {
            axes,
            eigenvalues,
            value: local.value(),
            first: array_of(|i| 0.5 * w[i] / e[i]),
            second,
            volumetric: local.volumetric(),
            shear,
        }
    }

    /// Evaluates the expansion at the state itself, with derivatives.
    fn at<R: Real>(&self, c: &[[R; 3]; 3]) -> R {
        let n = &self.axes;
        // C n_j, then n_i . C n_j.
        let product =
            |i: usize, j: usize| c[i][0] * n[0][j] + c[i][1] * n[1][j] + c[i][2] * n[2][j];
        let pushed: [[R; 3]; 3] = array_of(|i| array_of(|j| product(i, j)));
        let component = |i: usize, j: usize| {
            pushed[0][j] * n[0][i] + pushed[1][j] * n[1][i] + pushed[2][j] * n[2][i]
        };
        // Subtract the value itself: rounding of the difference would be a change of volume.
        let d: [R; 3] = array_of(|i| {
            let own = component(i, i);
            own - own.value()
        });
        let e = &self.eigenvalues;
        let volume = d[0] * (0.5 / e[0]) + d[1] * (0.5 / e[1]) + d[2] * (0.5 / e[2]);
        let volume = volume * volume * (0.5 * self.volumetric);
        let along = |i: usize| {
            let h = &self.second[i];
            d[i] * ((d[0] * h[0] + d[1] * h[1] + d[2] * h[2]) * 0.5 + self.first[i])
        };
        let across = |p: usize| {
            let (i, j) = PAIRS[p];
            let shear = component(i, j);
            shear * shear * self.shear[p]
        };
        along(0) + along(1) + along(2) + across(0) + across(1) + across(2) + volume + self.value
    }
}

/// Components of a tensor as intervals; `None` for floating-point numbers.
fn bounds<R: Real>(c: &[[R; 3]; 3]) -> Option<[[Interval; 3]; 3]> {
    let mut all = [[Interval::ENTIRE; 3]; 3];
    for (row, components) in all.iter_mut().zip(c) {
        for (bound, component) in row.iter_mut().zip(components) {
            *bound = component.bounds()?;
        }
    }
    Some(all)
}

/// Interval as a constant.
fn within<R: Real>(interval: Interval) -> R {
    R::constant(interval.low).hull(R::constant(interval.high))
}

/// Interval of all numbers up to a given magnitude.
fn up_to<R: Real>(size: f64) -> R {
    within(Interval::new(-size, size))
}

/// Unbounded number with two unbounded derivatives with respect to the components of a tensor.
fn nothing_known<R: Real>(c: &[[R; 3]; 3]) -> R {
    let all = PAIRS
        .into_iter()
        .fold(c[0][0] + c[1][1] + c[2][2], |sum, (i, j)| sum + c[i][j]);
    let unknown = R::constant(f64::NAN);
    all * unknown + all * all * unknown
}

/// Energy in interval arithmetic.
///
/// In axes close to the principal axes `C = D + E` with `D` diagonal and `E` small. The eigenvalues of `D + t E` lie in Gershgorin's discs, where
/// overlapping discs are merged, and `w` with its derivatives is enclosed there. With a bound `M` of the second derivative of the energy with
/// respect to `C` for all eigenvalues in the discs, the first derivative differs from `diag(g_i)` by at most `M |E|`, and no component of the second
/// derivative exceeds `M`. If the discs are further apart than `|E|`, the principal axes are known, and the second derivative follows
/// from the eigenvalues in the discs up to the tilt of the axes. The result is `None` if a disc reaches zero, or if a part is undefined.
fn enclosed<R: Real>(
    energy: &impl PrincipalEnergy,
    c: &[[R; 3]; 3],
    bounds: &[[Interval; 3]; 3],
) -> Option<R> {
    let b = in_axes(c, bounds)?;
    let own = |i: usize, j: usize| b[i][j].bounds().unwrap_or(Interval::ENTIRE);
    let radius = |i: usize| own(i, (i + 1) % 3).magnitude() + own(i, (i + 2) % 3).magnitude();
    let discs = merged([0, 1, 2].each(|i| {
        let radius = radius(i).next_up();
        own(i, i) + Interval::new(-radius, radius)
    }));
    if discs
        .iter()
        .any(|disc| !(disc.low > 0.0 && disc.is_finite()))
    {
        return None;
    }
    if !energy.is_defined(discs.map(Real::sqrt)) {
        return None;
    }
    let w = energy.of_stretches(Jet::<3, Interval>::variables(discs).map(Real::sqrt));
    let mut normal = w.hessian;
    let mut shear = PAIRS.each(|(i, j)| {
        if discs[i] == discs[j] {
            (w.hessian[i][i] + w.hessian[j][j]) * 0.5 - w.hessian[i][j]
        } else {
            (w.gradient[i] - w.gradient[j]) / (discs[i] - discs[j])
        }
    });
    let components = normal.iter().flatten().chain(&shear);
    let largest = components.map(|own| own.magnitude()).fold(0.0, f64::max);
    let curvature = 4.0 * largest * (1.0 + 1e-12);
    let beside = PAIRS.each(|(i, j)| own(i, j).magnitude().powi(2));
    let size = (2.0 * beside.iter().sum::<f64>()).sqrt() * (1.0 + 1e-12);
    let turned = curvature * size;
    let spread = mixed(&discs, &mut normal, &mut shear);
    let tilted = tilt(&discs, size).map_or(f64::INFINITY, |tilt| {
        ((1.0 + 6.0 * tilt).powi(4) - 1.0) * largest
    });
    // If the principal axes are not known, only the magnitude of the curvature is used.
    let is_known = tilted + spread < curvature;
    let open = if is_known {
        (tilted + spread) * (1.0 + 1e-12)
    } else {
        curvature
    };
    let change = |i: usize, j: usize| b[i][j] - own(i, j).midpoint();
    let mut sum: R = within(w.value);
    let mut all: R = R::constant(0.0);
    for (i, slope) in w.gradient.into_iter().enumerate() {
        sum = sum + change(i, i) * within::<R>(slope + Interval::new(-turned, turned));
        all = all + change(i, i) * up_to::<R>(1.0);
    }
    for (p, (i, j)) in PAIRS.into_iter().enumerate() {
        sum = sum + change(i, j) * up_to::<R>(2.0 * turned);
        all = all + change(i, j) * up_to::<R>(2.0);
        if is_known {
            let product = change(i, i) * change(j, j);
            sum = sum + product * within::<R>(normal[i][j]);
            sum = sum + change(i, j) * change(i, j) * within::<R>(shear[p]);
        }
    }
    if is_known {
        for (i, row) in normal.iter().enumerate() {
            sum = sum + change(i, i) * change(i, i) * within::<R>(row[i] * 0.5);
        }
    }
    Some(sum + all * all * up_to::<R>(0.5 * open))
}

/// Bound of the tilt `|n_i . e_k|` of the principal axes relative to axes with eigenvalues in separate discs, if the off-diagonal part does not
/// exceed a given size: `(D_kk - e_i) n_i . e_k = -(E n_i)_k`.
fn tilt(discs: &[Interval; 3], size: f64) -> Option<f64> {
    let apart = PAIRS.into_iter().filter(|(i, j)| discs[*i] != discs[*j]);
    let gaps = apart.map(|(i, j)| (discs[i].low - discs[j].high).max(discs[j].low - discs[i].high));
    let least = gaps.fold(f64::INFINITY, f64::min);
    (least > 0.0).then(|| (size / least).next_up())
}

/// Makes second derivatives independent of the axes where eigenvalues share a disc. Returns a bound of the norm of the change: nine times its largest
/// component.
fn mixed(discs: &[Interval; 3], normal: &mut [[Interval; 3]; 3], shear: &mut [Interval; 3]) -> f64 {
    let is_mixed = |i: usize, j: usize| i != j && discs[i] == discs[j];
    let mut deviation: f64 = 0.0;
    let mut settle = |own: &mut Interval, value: f64| {
        deviation = deviation.max((*own - value).magnitude());
        *own = Interval::point(value);
    };
    let count = PAIRS.into_iter().filter(|(i, j)| is_mixed(*i, *j)).count();
    if count == 3 {
        let (own, other) = (normal[0][0].midpoint(), normal[0][1].midpoint());
        for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
            settle(&mut normal[i][j], if i == j { own } else { other });
        }
        for own_shear in shear.iter_mut() {
            settle(own_shear, own - other);
        }
    }
    let pair = PAIRS
        .into_iter()
        .enumerate()
        .find(|(_, (i, j))| is_mixed(*i, *j));
    if let (1, Some((p, (i, j)))) = (count, pair) {
        let k = 3 - i - j;
        let (own, other) = (normal[i][i].midpoint(), normal[i][j].midpoint());
        let beside = normal[i][k].midpoint();
        for (a, b, value) in [(i, i, own), (j, j, own), (i, j, other), (j, i, other)] {
            settle(&mut normal[a][b], value);
        }
        for (a, b) in [(i, k), (k, i), (j, k), (k, j)] {
            settle(&mut normal[a][b], beside);
        }
        settle(&mut shear[p], own - other);
        let others: [usize; 2] = [(p + 1) % 3, (p + 2) % 3];
        let middle = shear[others[0]].midpoint();
        others
            .into_iter()
            .for_each(|n| settle(&mut shear[n], middle));
    }
    9.0 * deviation
}

/// Tensor `C` in orthonormal axes close to the principal axes: `T V^T C V T` with computed axes `V = Q (1 + S)`, `Q` orthogonal and `T = (1 + S)^-1`
/// enclosed by the size of `V^T V - 1`.
fn in_axes<R: Real>(c: &[[R; 3]; 3], bounds: &[[Interval; 3]; 3]) -> Option<[[R; 3]; 3]> {
    let (_, v) = eigen(bounds.each(|row| row.map(Interval::midpoint)));
    let point = |i: usize, j: usize| Interval::point(v[i][j]);
    let mut square = 0.0;
    for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
        let product =
            point(0, i) * point(0, j) + point(1, i) * point(1, j) + point(2, i) * point(2, j);
        square += (product - f64::from(u8::from(i == j))).magnitude().powi(2);
    }
    // |S| does not exceed |V^T V - 1|, and |T - 1| does not exceed |S| / (1 - |S|).
    let defect = 1.2 * square.sqrt();
    if defect.is_nan() || defect >= 0.1 {
        return None;
    }
    let t = |i: usize, j: usize| -> R {
        let one = f64::from(u8::from(i == j));
        within(
            Interval::new(one - defect, one + defect) + Interval::new(-f64::EPSILON, f64::EPSILON),
        )
    };
    let triple = |m: &[[R; 3]; 3], a: &dyn Fn(R, usize, usize) -> R| -> [[R; 3]; 3] {
        let row = |i: usize, j: usize| a(m[i][0], 0, j) + a(m[i][1], 1, j) + a(m[i][2], 2, j);
        let right: [[R; 3]; 3] = array_of(|i| array_of(|j| row(i, j)));
        let column =
            |i: usize, j: usize| a(right[0][j], 0, i) + a(right[1][j], 1, i) + a(right[2][j], 2, i);
        array_of(|i| array_of(|j| column(i, j)))
    };
    let turned = triple(c, &|x, i, j| x * v[i][j]);
    Some(triple(&turned, &|x, i, j| x * t(i, j)))
}

/// Merges intervals that overlap or lie close together. With the relative width `w` and the relative gap `g`, the quotient of differences that gives
/// a shear stiffness has the error `w / g`, and the mean over both intervals has an error of order `g`.
fn merged(mut discs: [Interval; 3]) -> [Interval; 3] {
    for _ in 0..3 {
        for (i, j) in PAIRS {
            let gap = (discs[i].low - discs[j].high).max(discs[j].low - discs[i].high);
            let width = discs[i].width() + discs[j].width();
            let size = discs[i].high.max(discs[j].high);
            if gap <= 0.0 || gap * gap <= 0.1 * width * size {
                let both = discs[i].hull(discs[j]);
                (discs[i], discs[j]) = (both, both);
            }
        }
    }
    discs
}

/// Derivatives `dh_i/dy_a`: a third for the volume, and two orthonormal vectors of the shape.
const BY_SHAPE: [[f64; 3]; 3] = {
    let (a, b) = (std::f64::consts::FRAC_1_SQRT_2, 0.408_248_290_463_863);
    let third = 1.0 / 3.0;
    [[third, a, b], [third, -a, b], [third, 0.0, -2.0 * b]]
};

/// Smallest ratio of the volumetric to the shape stiffness at which the volumetric stiffness is separated. Below it derivatives with respect to each
/// stretch keep more digits if the stretches differ much.
const STIFF_RATIO: f64 = 1e6;

/// Energy with its derivatives in one of two sets of variables.
enum Local {
    /// Derivatives with respect to the logarithmic stretches `h_i`.
    Stretches(Jet<3>),
    /// Derivatives with respect to `y_0`, `y_1` and `y_2`.
    VolumeAndShape(Jet<3>),
}

impl Local {
    fn of(energy: &impl PrincipalEnergy, eigenvalues: [f64; 3]) -> Self {
        let by = |coordinates: &[[f64; 3]; 3]| {
            let stretch = |i: usize| {
                let (value, c) = (eigenvalues[i].sqrt(), &coordinates[i]);
                Jet {
                    value,
                    gradient: array_of(|a| value * c[a]),
                    hessian: array_of(|a| array_of(|b| value * c[a] * c[b])),
                }
            };
            energy.of_stretches(array_of(stretch))
        };
        let own = by(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let (w, h) = (&own.gradient, &own.hessian);
        let volume: f64 = h.as_flattened().iter().sum::<f64>() / 9.0;
        let shape = PAIRS.map(|(i, j)| {
            let curvature = 0.5 * (h[i][i] + h[j][j]) - h[i][j];
            curvature.abs().max((w[i] - w[j]).abs())
        });
        match volume.abs() > STIFF_RATIO * shape.into_iter().fold(0.0, f64::max) {
            true => Self::VolumeAndShape(by(&BY_SHAPE)),
            false => Self::Stretches(own),
        }
    }

    fn value(&self) -> f64 {
        let (Self::Stretches(w) | Self::VolumeAndShape(w)) = self;
        w.value
    }

    /// Derivatives `w_i = dW/dh_i`, using `dy_0/dh_i = 1` and `dy_a/dh_i = b_ai`.
    fn slopes(&self) -> [f64; 3] {
        match self {
            Self::Stretches(w) => w.gradient,
            Self::VolumeAndShape(w) => {
                let g = &w.gradient;
                array_of(|i| g[0] + BY_SHAPE[i][1] * g[1] + BY_SHAPE[i][2] * g[2])
            }
        }
    }

    /// Difference `w_i - w_j` without cancellation of the volumetric part.
    fn difference(&self, (i, j): (usize, usize)) -> f64 {
        match self {
            Self::Stretches(w) => w.gradient[i] - w.gradient[j],
            Self::VolumeAndShape(w) => {
                let part = |a: usize| (BY_SHAPE[i][a] - BY_SHAPE[j][a]) * w.gradient[a];
                part(1) + part(2)
            }
        }
    }

    /// Separated volumetric stiffness `d^2 W/dy_0^2`, which is part of `d^2 W/dh_i dh_j`.
    fn volumetric(&self) -> f64 {
        match self {
            Self::Stretches(_) => 0.0,
            Self::VolumeAndShape(w) => w.hessian[0][0],
        }
    }

    /// Second derivative `d^2 W/dh_i dh_j` without [`Local::volumetric`].
    fn curvature(&self, i: usize, j: usize) -> f64 {
        let w = match self {
            Self::Stretches(w) => return w.hessian[i][j],
            Self::VolumeAndShape(w) => w,
        };
        let h = &w.hessian;
        let (b, c) = (&BY_SHAPE[i], &BY_SHAPE[j]);
        let mut sum = 0.0;
        for a in 1..3 {
            sum += h[0][a] * (b[a] + c[a]) + h[a][1] * b[a] * c[1] + h[a][2] * b[a] * c[2];
        }
        sum
    }
}

/// Quotient `(h_i - h_j) / (e_i - e_j)` from the eigenvalues.
fn logarithmic(a: f64, b: f64) -> f64 {
    let x = (a - b) / b;
    let ratio = if x == 0.0 { 1.0 } else { x.ln_1p() / x };
    0.5 * ratio / b
}

/// Largest contribution of fourth degree to the integrand of [`mean_curvature`], relative to the whole. For `cosh(k u)`, the integrand of a power of
/// the stretches, it is reached at `k = 0.8`, where the error of the quadrature is `1e-14`.
const QUARTIC: f64 = 1e-3;

/// Mean of `1/2 (W_ii + W_jj - 2 W_ij)` over the segment that exchanges two logarithmic stretches; `None` if the quadrature does not resolve it.
fn mean_curvature(
    energy: &impl PrincipalEnergy,
    eigenvalues: [f64; 3],
    (i, j): (usize, usize),
) -> Option<f64> {
    let (a, b) = (eigenvalues[i], eigenvalues[j]);
    let at = |t: f64| {
        let mut between = eigenvalues;
        between[i] = a * (b / a).powf(t);
        between[j] = b * (a / b).powf(t);
        let local = Local::of(energy, between);
        0.5 * (local.curvature(i, i) + local.curvature(j, j)) - local.curvature(i, j)
    };
    if a == b {
        return Some(at(0.0));
    }
    let values = RULE.each(|(t, _)| at(t));
    let squares = RULE.each(|(t, _)| (t - 0.5) * (t - 0.5));
    let slope = |n: usize| (values[n] - values[0]) / squares[n];
    let quartic = (slope(2) - slope(1)) / (squares[2] - squares[1]) * 0.5_f64.powi(4);
    let largest = values
        .iter()
        .fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let parts = RULE.iter().zip(values);
    (quartic.abs() <= QUARTIC * largest)
        .then(|| parts.map(|((_, weight), value)| weight * value).sum())
}

/// Eigenvalues and eigenvectors (in columns) of a symmetric matrix by Jacobi rotations, with small relative errors of small eigenvalues of positive
/// matrices; NaN for a matrix that is not finite.
fn eigen(mut c: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Convergence is quadratic; at most five sweeps occur in practice.
    for _ in 0..12 {
        let mut is_done = true;
        for (p, q) in PAIRS {
            let small = f64::EPSILON * 0.25 * (c[p][p] * c[q][q]).abs().sqrt();
            if c[p][q] == 0.0 || c[p][q].abs() <= small {
                continue;
            }
            is_done = false;
            let tau = (c[q][q] - c[p][p]) / (2.0 * c[p][q]);
            let tangent = tau.signum() / (tau.abs() + tau.hypot(1.0));
            let cosine = tangent.hypot(1.0).recip();
            let sine = tangent * cosine;
            let r = 3 - p - q;
            let (cpr, cqr) = (c[p][r], c[q][r]);
            c[p][p] -= tangent * c[p][q];
            c[q][q] += tangent * c[p][q];
            (c[p][q], c[q][p]) = (0.0, 0.0);
            (c[p][r], c[q][r]) = (cosine * cpr - sine * cqr, sine * cpr + cosine * cqr);
            (c[r][p], c[r][q]) = (c[p][r], c[q][r]);
            for row in &mut axes {
                (row[p], row[q]) = (
                    cosine * row[p] - sine * row[q],
                    sine * row[p] + cosine * row[q],
                );
            }
        }
        if is_done {
            break;
        }
    }
    ([c[0][0], c[1][1], c[2][2]], axes)
}
