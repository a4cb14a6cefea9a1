//! Kernels given by the user as a formula of `q`.

use super::error::KernelError;
use super::moments::Pieces;
use super::profile::{Profile, cusped, switch};
use super::smoothness::{Smoothness, jumps, orders_at};
use crate::algebra::Each;
use crate::formula::FunctionOfOne;
use crate::real::{Interval, Jet, Real};
use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Largest distance in support radii at which `W'/q` is computed from higher derivatives, because the quotient would lose more digits.
const QUOTIENT_DISTANCE: f64 = 1e-6;
/// Rounding error of a zero at the rim and at the origin, relative to the value at the origin.
const ZERO_TOLERANCE: f64 = 1e-10;
/// Number of cells of the midpoint rule that encloses an integral.
const CELLS: u32 = 4096;

/// Kernel given by a formula of `q = |x| / R0`. Formulas are cached, so that each text is compiled once.
#[derive(Clone, Copy, Debug)]
pub struct FormulaKernel(&'static Compiled);

#[derive(Debug)]
struct Compiled {
    text: String,
    function: FunctionOfOne,
    /// Reciprocal of the value at the origin.
    scale: f64,
    /// Whether the slope at the origin is nonzero.
    is_cusped: bool,
    smoothness: Smoothness,
    breaks: Vec<f64>,
    integrals: [f64; 3],
    enclosures: [OnceLock<Interval>; 3],
}

/// Converts a number to the independent variable of a jet.
fn variable<R: Real>(q: R) -> Jet<1, R> {
    let [variable] = Jet::variables([q]);
    variable
}

impl PartialEq for FormulaKernel {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for FormulaKernel {}

impl FormulaKernel {
    /// Parses a formula of `q`. The kernel is the formula divided by its value at the origin.
    ///
    /// # Errors
    /// [`KernelError`] if the text is not a formula of `q`, or if the profile is not finite, jumps within `0 <= q <= 1` or does not vanish at `q = 1`.
    /// Value at the origin and integral over space must be positive.
    ///
    /// ```
    /// use onset::kernel::{FormulaKernel, Kernel};
    /// let own = Kernel::Formula(FormulaKernel::parse("(1 - q)^3*(1 + 3*q)")?);
    /// let (own, built_in) = (own.profile::<2, f64>(0.3), Kernel::QuarticSpline.profile::<2, f64>(0.3));
    /// assert!((own.curvature_over_q - built_in.curvature_over_q).abs() < 1e-12);
    /// # Ok::<(), onset::kernel::KernelError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, KernelError> {
        static PARSED_KERNELS: Mutex<BTreeMap<String, FormulaKernel>> = Mutex::new(BTreeMap::new());
        let text = text.trim();
        let known = || {
            PARSED_KERNELS
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        if let Some(kernel) = known().get(text) {
            return Ok(*kernel);
        }
        let compiled = Compiled::new(text)?;
        let mut kernels = known();
        // Another thread may have inserted the kernel in the meantime.
        Ok(*kernels
            .entry(text.to_owned())
            .or_insert_with(|| Self(Box::leak(Box::new(compiled)))))
    }

    /// Formula as entered by the user.
    pub fn text(self) -> &'static str {
        &self.0.text
    }

    pub(super) fn profile<R: Real>(self, q: R) -> Profile<R> {
        self.0.profile(q)
    }

    pub(super) fn smoothness(self) -> Smoothness {
        self.0.smoothness
    }

    /// Distances at which derivatives up to the fourth jump within the support.
    pub(super) fn breaks(self) -> &'static [f64] {
        &self.0.breaks
    }

    /// Returns the radial integral `int_0^1 W q^(D-1) dq`.
    pub(super) fn radial_integral<const D: usize>(self) -> f64 {
        self.0.integrals[D.clamp(1, 3) - 1]
    }

    /// Bounds of the radial integral `int_0^1 W q^(D-1) dq`.
    pub(super) fn radial_enclosure<const D: usize>(self) -> Interval {
        *self.0.enclosures[D.clamp(1, 3) - 1].get_or_init(|| self.0.enclosed_integral::<D>())
    }
}

impl Compiled {
    fn new(text: &str) -> Result<Self, KernelError> {
        let function = FunctionOfOne::parse(text, "q").map_err(KernelError::Formula)?;
        let peak = function.at(0.0);
        for n in 0..=64 {
            let q = f64::from(n) / 64.0;
            if !function.at(q).is_finite() {
                return Err(KernelError::NotFinite { q });
            }
        }
        if peak <= 0.0 {
            return Err(KernelError::NotPositive { value: peak });
        }
        let end = function.at(1.0);
        if end.abs() > ZERO_TOLERANCE * peak {
            return Err(KernelError::NotZeroAtRim { value: end });
        }
        let scaled = |q: Jet<1, Jet<1>>| function.at(q) * (1.0 / peak);
        let breaks = match function.has_branch() {
            true => jumps(scaled).map_err(|q| KernelError::Jump { q })?,
            false => Vec::new(),
        };
        let [origin, rim] = [0.0, 1.0].each(|q| orders_at(scaled, q));
        let smoothness = Smoothness::measured(origin, &breaks, rim);
        let slope = function.at(variable(0.0)).gradient[0];
        // A NaN slope does not vanish either.
        let is_cusped = slope.is_nan() || slope.abs() > ZERO_TOLERANCE * peak;
        let mut compiled = Self {
            text: text.to_owned(),
            function,
            scale: 1.0 / peak,
            is_cusped,
            smoothness,
            breaks: breaks.into_iter().map(|(q, _)| q).collect(),
            integrals: [0.0; 3],
            enclosures: [const { OnceLock::new() }; 3],
        };
        let pieces = Pieces::new(&compiled.breaks, 32);
        for dimension in 1..=3 {
            let power = dimension as i32 - 1;
            let value = pieces.integral(|q| compiled.profile(q).value * q.powi(power));
            if !(value > 0.0 && value.is_finite()) {
                return Err(KernelError::IntegralNotPositive { dimension, value });
            }
            compiled.integrals[dimension - 1] = value;
        }
        Ok(compiled)
    }

    fn value<R: Real>(&self, q: R) -> R {
        self.function.at(q) * self.scale
    }

    /// Value, slope and curvature at `q`.
    fn derivatives<R: Real>(&self, q: R) -> [R; 3] {
        let jet = self.value(variable(q));
        [jet.value, jet.gradient[0], jet.hessian[0][0]]
    }

    fn profile<R: Real>(&self, q: R) -> Profile<R> {
        if self.is_cusped {
            return cusped(q, R::constant(1.0), || self.derivatives(q));
        }
        let away = || Profile::from_derivatives(q, self.derivatives(q));
        switch!(q, QUOTIENT_DISTANCE => self.near_origin(q), away())
    }

    /// Profile near the origin, where `W'/q` is a quotient of two small numbers.
    ///
    /// By the mean value theorem, `W'(q)/q` and `S'` are values of `W''` and of half to all of `W'''` between the origin and `q`. Intervals are
    /// extended to the origin and contain both.
    fn near_origin<R: Real>(&self, q: R) -> Profile<R> {
        let inner = q.hull(R::constant(0.0));
        let jet = self.value(variable(variable(inner)));
        let second = jet.hessian[0][0].value;
        let third = jet.hessian[0][0].gradient[0];
        Profile {
            value: self.value(q),
            // W'(q)/q = W''(0) + W''' q/2 = W''(q) - W''' q/2 to third order.
            slope_over_q: (second - third * q * 0.5).hull(second),
            curvature_over_q: (third * 0.5).hull(third).hull(R::constant(0.0)),
        }
    }

    /// Bounds of `int_0^1 W q^(D-1) dq` by the midpoint rule with its remainder, `h^3 g''/24` per cell.
    fn enclosed_integral<const D: usize>(&self) -> Interval {
        let width = Interval::point(1.0) / f64::from(CELLS);
        let integrand = |q: Jet<1, Interval>| self.value(q) * q.powi(D as i32 - 1);
        (0..CELLS).fold(Interval::ZERO, |sum, cell| {
            let (low, high) = (f64::from(cell), f64::from(cell + 1));
            let whole = Interval::new(low, high) * width;
            let middle = Interval::point(0.5 * (low + high)) * width;
            let [at_middle, over_cell] = [middle, whole].each(|q| integrand(variable(q)));
            let rest = over_cell.hessian[0][0] * width.powi(2) / 24.0;
            sum + (at_middle.value + rest) * width
        })
    }
}
