//! Interval arithmetic with outward rounding.

use super::{Real, Side};
use std::f64::consts::FRAC_1_PI;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Widening, in units in the last place, of the results of `exp`, `ln`, `sin`, `cos`, `sinh`, `cosh`, `tanh` and `powf`. The mathematical
/// libraries in use (glibc, musl, the Rust port of musl, the libraries of Apple and Microsoft) state errors of at most two units.
const LIBRARY_ULPS: u32 = 4;

/// Interval that contains an unknown number: `low <= x <= high`.
///
/// The result of an operation contains every result of the operation on members of its operands. Bounds may be infinite, but never NaN. If an
/// operation is not defined on all members (a division by an interval that contains zero, or the logarithm of an interval with negative members), the
/// result is [`Interval::ENTIRE`]. Sums, differences, products, quotients and square roots are correctly rounded by IEEE 754 and widened by one unit
/// in the last place on either side. The elementary functions are widened by four, which assumes that the functions of the platform are accurate to
/// four units.
///
/// ```
/// use onset::real::{Interval, Real};
/// let third = Interval::point(1.0) / Interval::point(3.0);
/// assert!(third.low < third.high && third.width() < 1e-15);
/// assert!((third * 3.0).contains(1.0));
/// assert_eq!(third / Interval::new(-1.0, 1.0), Interval::ENTIRE);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower bound of the interval.
    pub low: f64,
    /// Upper bound of the interval.
    pub high: f64,
}

impl Interval {
    /// Interval of all real numbers.
    pub const ENTIRE: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    /// Interval that contains only zero.
    pub const ZERO: Self = Self {
        low: 0.0,
        high: 0.0,
    };

    /// Interval between two bounds, in either order; all numbers if a bound is NaN.
    pub fn new(a: f64, b: f64) -> Self {
        if a <= b {
            Self { low: a, high: b }
        } else if b < a {
            Self { low: b, high: a }
        } else {
            Self::ENTIRE
        }
    }

    /// Interval that contains a single number. Infinity represents all numbers beyond the largest, NaN all numbers.
    pub fn point(x: f64) -> Self {
        if x.is_finite() {
            Self { low: x, high: x }
        } else if x > 0.0 {
            Self {
                low: f64::MAX,
                high: x,
            }
        } else if x < 0.0 {
            Self {
                low: x,
                high: f64::MIN,
            }
        } else {
            Self::ENTIRE
        }
    }

    /// Interval around a number with an error of some units in its last place. Zero is exact.
    pub fn around(x: f64, ulps: u32) -> Self {
        if x == 0.0 {
            Self::ZERO
        } else {
            Self::widened(x, x, ulps)
        }
    }

    /// Moves the bounds outward by some units in the last place.
    #[inline]
    fn widened(mut low: f64, mut high: f64, ulps: u32) -> Self {
        for _ in 0..ulps {
            low = low.next_down();
            high = high.next_up();
        }
        if low <= high {
            Self { low, high }
        } else {
            Self::ENTIRE
        }
    }

    /// Widens bounds from correctly rounded operations.
    #[inline]
    fn rounded(low: f64, high: f64) -> Self {
        Self::widened(low, high, 1)
    }

    /// Widens bounds from functions of the platform.
    fn library(low: f64, high: f64) -> Self {
        Self::widened(low, high, LIBRARY_ULPS)
    }

    /// Returns true if a number is a member.
    pub fn contains(self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }

    /// Distance of the bounds, rounded up.
    pub fn width(self) -> f64 {
        if self.low == self.high {
            0.0
        } else {
            (self.high - self.low).next_up()
        }
    }

    /// Number in the middle of the interval; zero for the entire line.
    pub fn midpoint(self) -> f64 {
        if self.low == self.high {
            return self.low;
        }
        let middle = 0.5 * self.low + 0.5 * self.high;
        if middle.is_finite() {
            middle
        } else if self == Self::ENTIRE {
            0.0
        } else if self.low.is_finite() {
            f64::MAX
        } else {
            f64::MIN
        }
    }

    /// Largest distance of a point of the interval from [`Interval::midpoint`], rounded up.
    pub fn radius(self) -> f64 {
        if self.low == self.high {
            return 0.0;
        }
        let middle = self.midpoint();
        (self.high - middle).max(middle - self.low).next_up()
    }

    /// Largest absolute value in the interval.
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// Returns true if both bounds are finite.
    pub fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// Absolute values of the members.
    pub fn abs(self) -> Self {
        if self.low >= 0.0 {
            self
        } else if self.high <= 0.0 {
            -self
        } else {
            Self {
                low: 0.0,
                high: self.magnitude(),
            }
        }
    }

    /// Square of the interval. Unlike a product with itself it is never negative.
    pub fn square(self) -> Self {
        self.powi(2)
    }

    /// Returns true if the interval is exactly zero.
    #[inline]
    fn is_zero(self) -> bool {
        self.low == 0.0 && self.high == 0.0
    }

    /// Power of a nonnegative interval.
    fn positive_power(self, exponent: u32) -> Self {
        let (mut result, mut base, mut rest) = (Self::point(1.0), self, exponent);
        let mut is_one = true;
        while rest > 0 {
            if rest % 2 == 1 {
                result = if is_one { base } else { result * base };
                is_one = false;
            }
            rest /= 2;
            if rest > 0 {
                base = base * base;
            }
        }
        result
    }

    /// Cosine of `pi (x + shift)` for all members: its extremes are at the integers.
    fn wave(self, shift: f64, function: impl Fn(f64) -> f64) -> Self {
        let all = Self {
            low: -1.0,
            high: 1.0,
        };
        // For larger arguments an interval of one unit in the last place can cover a significant part of a period.
        if self.magnitude() >= 1e15 {
            return all;
        }
        let turns = self * Self::around(FRAC_1_PI, 1) + shift;
        let (first, last) = (turns.low.ceil(), turns.high.floor());
        if last - first >= 1.0 {
            return all;
        }
        let (a, b) = (function(self.low), function(self.high));
        let mut range = Self::library(a.min(b), a.max(b));
        if first <= last {
            let extreme = if first.rem_euclid(2.0) == 0.0 {
                1.0
            } else {
                -1.0
            };
            range = range.hull(Self::point(extreme));
        }
        Self {
            low: range.low.max(-1.0),
            high: range.high.min(1.0),
        }
    }
}

/// Product of bounds, where infinity is a bound that is not attained.
#[inline]
fn product(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

impl Add for Interval {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        if self.is_zero() {
            return other;
        }
        if other.is_zero() {
            return self;
        }
        let mut sum = Self::rounded(self.low + other.low, self.high + other.high);
        if self.low >= 0.0 && other.low >= 0.0 {
            sum.low = sum.low.max(0.0);
        }
        sum
    }
}

impl Sub for Interval {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::ZERO;
        }
        let (a, b, c, d) = (self.low, self.high, other.low, other.high);
        if a >= 0.0 && c >= 0.0 {
            let mut result = Self::rounded(product(a, c), product(b, d));
            result.low = result.low.max(0.0);
            return result;
        }
        let (ac, ad, bc, bd) = (product(a, c), product(a, d), product(b, c), product(b, d));
        Self::rounded(ac.min(ad).min(bc.min(bd)), ac.max(ad).max(bc.max(bd)))
    }
}

#[allow(
    clippy::suspicious_arithmetic_impl,
    reason = "the extremes of a quotient are quotients of the bounds"
)]
impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if other.low <= 0.0 && other.high >= 0.0 {
            return Self::ENTIRE;
        }
        if self.is_zero() {
            return Self::ZERO;
        }
        if !(self.is_finite() && other.is_finite()) {
            return self * other.recip();
        }
        let (a, b, c, d) = (self.low, self.high, other.low, other.high);
        let (ac, ad, bc, bd) = (a / c, a / d, b / c, b / d);
        Self::rounded(ac.min(ad).min(bc.min(bd)), ac.max(ad).max(bc.max(bd)))
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            low: -self.high,
            high: -self.low,
        }
    }
}

impl Add<f64> for Interval {
    type Output = Self;
    fn add(self, constant: f64) -> Self {
        self + Self::point(constant)
    }
}

impl Sub<f64> for Interval {
    type Output = Self;
    fn sub(self, constant: f64) -> Self {
        self - Self::point(constant)
    }
}

impl Mul<f64> for Interval {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self * Self::point(factor)
    }
}

impl Div<f64> for Interval {
    type Output = Self;
    fn div(self, divisor: f64) -> Self {
        self / Self::point(divisor)
    }
}

impl Real for Interval {
    fn constant(value: f64) -> Self {
        Self::point(value)
    }
    /// Midpoint of the interval. A law must branch with [`Real::switch`], which evaluates both branches if the interval does not decide.
    fn value(self) -> f64 {
        self.midpoint()
    }
    fn number(self) -> Option<f64> {
        None
    }
    fn bounds(self) -> Option<Interval> {
        Some(self)
    }
    fn side(self, threshold: f64) -> Option<Side> {
        if self.high < threshold {
            Some(Side::Below)
        } else if self.low >= threshold {
            Some(Side::Above)
        } else {
            None
        }
    }
    fn hull(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
    fn blended(self, _threshold: f64, below: Self, above: Self) -> Self {
        below.hull(above)
    }
    fn recip(self) -> Self {
        if self.low <= 0.0 && self.high >= 0.0 {
            return Self::ENTIRE;
        }
        let mut result = Self::rounded(self.high.recip(), self.low.recip());
        if self.low > 0.0 {
            result.low = result.low.max(0.0);
        } else {
            result.high = result.high.min(0.0);
        }
        result
    }
    fn sqrt(self) -> Self {
        if self.low < 0.0 {
            return Self::ENTIRE;
        }
        if self.is_zero() {
            return self;
        }
        let root = Self::rounded(self.low.sqrt(), self.high.sqrt());
        Self {
            low: root.low.max(0.0),
            high: root.high,
        }
    }
    fn exp(self) -> Self {
        let power = Self::library(self.low.exp(), self.high.exp());
        Self {
            low: power.low.max(0.0),
            high: power.high,
        }
    }
    fn ln(self) -> Self {
        if self.low < 0.0 || self.high == 0.0 {
            return Self::ENTIRE;
        }
        Self::library(self.low.ln(), self.high.ln())
    }
    fn sin(self) -> Self {
        // sin x = cos(x - pi/2): extremes where x / pi - 1/2 is an integer.
        self.wave(-0.5, f64::sin)
    }
    fn cos(self) -> Self {
        self.wave(0.0, f64::cos)
    }
    fn sinh(self) -> Self {
        Self::library(self.low.sinh(), self.high.sinh())
    }
    fn cosh(self) -> Self {
        let size = self.abs();
        let range = Self::library(size.low.cosh(), size.high.cosh());
        Self {
            low: range.low.max(1.0),
            high: range.high,
        }
    }
    fn tanh(self) -> Self {
        let range = Self::library(self.low.tanh(), self.high.tanh());
        Self {
            low: range.low.max(-1.0),
            high: range.high.min(1.0),
        }
    }
    fn powi(self, exponent: i32) -> Self {
        if exponent == 0 {
            return Self::point(1.0);
        }
        let count = exponent.unsigned_abs();
        let power = if self.low >= 0.0 {
            self.positive_power(count)
        } else if count.is_multiple_of(2) {
            self.abs().positive_power(count)
        } else if self.high <= 0.0 {
            -(-self).positive_power(count)
        } else {
            let below = Self::new(0.0, -self.low).positive_power(count);
            let above = Self::new(0.0, self.high).positive_power(count);
            (-below).hull(above)
        };
        if exponent < 0 { power.recip() } else { power }
    }
    fn powf(self, exponent: f64) -> Self {
        if self.low < 0.0 || !exponent.is_finite() {
            return Self::ENTIRE;
        }
        if exponent == 0.0 {
            return Self::point(1.0);
        }
        if self.high == 0.0 && exponent < 0.0 {
            return Self::ENTIRE;
        }
        let (a, b) = (self.low.powf(exponent), self.high.powf(exponent));
        let power = Self::library(a.min(b), a.max(b));
        Self {
            low: power.low.max(0.0),
            high: power.high,
        }
    }
}
