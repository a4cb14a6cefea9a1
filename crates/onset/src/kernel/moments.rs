//! Integrals of kernels over space: normalization, moments, Fourier transform, smoothing length.

use super::Kernel;
use super::exponential::{GAUSSIAN, LAGUERRE_GAUSS};
use crate::algebra::array_of;
use crate::real::Interval;
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// Number of points of the Gauss-Legendre rule of a panel.
const POINTS: usize = 20;

/// Largest phase of a wave across one panel; radians.
const RADIANS: f64 = 6.0;

/// Points and weights of the Gauss-Legendre rule on `(0, 1)`.
static RULE: LazyLock<[(f64, f64); POINTS]> = LazyLock::new(|| {
    array_of(|i| {
        let n = POINTS as f64;
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        // Newton's method doubles the number of correct digits: six steps from two digits exceed double precision.
        for _ in 0..6 {
            let (mut last, mut value) = (1.0, x);
            for k in 2..=POINTS {
                let k = k as f64;
                (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
            }
            slope = n * (x * value - last) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
});

/// Support `0 <= q <= 1`, divided into panels at the breaks of a profile.
pub(super) struct Pieces(Vec<(f64, f64)>);

impl Pieces {
    /// Divides each piece into `panels` panels per unit of length, and into at least one panel.
    pub(super) fn new(breaks: &[f64], panels: usize) -> Self {
        let mut ends: Vec<f64> = breaks.to_vec();
        ends.push(1.0);
        let mut cut = Vec::new();
        let mut start = 0.0;
        for end in ends {
            let count = ((end - start) * panels as f64).ceil().max(1.0);
            let width = (end - start) / count;
            cut.extend((0..count as usize).map(|n| (start + n as f64 * width, width)));
            start = end;
        }
        Self(cut)
    }

    /// Integral of a function over `0 <= q <= 1`.
    pub(super) fn integral(&self, function: impl Fn(f64) -> f64) -> f64 {
        let panel = |(start, width): &(f64, f64)| -> f64 {
            RULE.iter()
                .map(|(place, weight)| weight * width * function(start + width * place))
                .sum()
        };
        self.0.iter().map(panel).sum()
    }
}

/// Surface of the unit sphere in `D` dimensions: 2, `2 pi`, `4 pi`.
fn sphere<const D: usize>() -> f64 {
    match D {
        1 => 2.0,
        2 => TAU,
        _ => 2.0 * TAU,
    }
}

/// Mean of `cos(k . x)` over all directions for `|k| |x| = x`: cosine, Bessel function `J0`, sinc.
fn wave<const D: usize>(x: f64) -> f64 {
    match D {
        1 => x.cos(),
        2 => bessel(x),
        _ if x == 0.0 => 1.0,
        _ => x.sin() / x,
    }
}

/// Bessel function `J0(x)` as the mean of `cos(x sin t)` over `n` directions of a half turn. The error `2 J_2n(x)` is negligible for `2 n` well
/// beyond `x`.
fn bessel(x: f64) -> f64 {
    let n = (0.5 * x + 5.0 * x.cbrt() + 16.0).ceil();
    let directions = (0..n as usize).map(|i| (x * (PI * i as f64 / n).sin()).cos());
    directions.sum::<f64>() / n
}

impl Kernel {
    /// Distances at which the pieces of the profile meet.
    fn breaks(self) -> &'static [f64] {
        match self {
            Self::CubicSpline | Self::Hyperbolic => &[0.5],
            Self::QuarticBSpline => &[0.2, 0.6],
            Self::QuinticSpline => &[1.0 / 3.0, 2.0 / 3.0],
            Self::Formula(formula) => formula.breaks(),
            Self::QuarticSpline
            | Self::WendlandC2
            | Self::WendlandC4
            | Self::WendlandC6
            | Self::Gaussian
            | Self::LaguerreGauss => &[],
        }
    }

    /// Integral of `W(|x| / radius)` over space; length^D.
    ///
    /// ```
    /// use onset::kernel::Kernel;
    /// // Dehnen and Aly (2012), table 1: the cubic spline has 16/pi in three dimensions, and 1/2 at the origin.
    /// let norm = 0.5 * 16.0 / std::f64::consts::PI;
    /// assert!((Kernel::CubicSpline.integral::<3>(1.0) * norm - 1.0).abs() < 1e-15);
    /// ```
    pub fn integral<const D: usize>(self, radius: f64) -> f64 {
        let unit = match (self, D) {
            (Self::QuarticSpline | Self::WendlandC2, 1) => 4.0 / 5.0,
            (Self::QuarticSpline, 2) => PI / 5.0,
            (Self::QuarticSpline, _) => 16.0 * PI / 105.0,
            (Self::CubicSpline, 1) => 3.0 / 4.0,
            (Self::CubicSpline, 2) => 7.0 * PI / 40.0,
            (Self::CubicSpline, _) => PI / 8.0,
            (Self::QuarticBSpline, 1) => 384.0 / 575.0,
            (Self::QuarticBSpline, 2) => 1199.0 * PI / 8625.0,
            (Self::QuarticBSpline, _) => 256.0 * PI / 2875.0,
            (Self::QuinticSpline, 1) => 20.0 / 33.0,
            (Self::QuinticSpline, 2) => 239.0 * PI / 2079.0,
            (Self::QuinticSpline, _) => 20.0 * PI / 297.0,
            (Self::WendlandC2, 2) => PI / 7.0,
            (Self::WendlandC2, _) => 2.0 * PI / 21.0,
            (Self::WendlandC4, 1) => 2.0 / 3.0,
            (Self::WendlandC4, 2) => PI / 9.0,
            (Self::WendlandC4, _) => 32.0 * PI / 495.0,
            (Self::WendlandC6, 1) => 32.0 / 55.0,
            (Self::WendlandC6, 2) => 7.0 * PI / 78.0,
            (Self::WendlandC6, _) => 64.0 * PI / 1365.0,
            (Self::Hyperbolic, 1) => 7.0 / 12.0,
            (Self::Hyperbolic, 2) => PI / 8.0,
            (Self::Hyperbolic, _) => 31.0 * PI / 360.0,
            (Self::Gaussian, _) => sphere::<D>() * GAUSSIAN.radial_integral::<D>(),
            (Self::LaguerreGauss, _) => sphere::<D>() * LAGUERRE_GAUSS.radial_integral::<D>(),
            (Self::Formula(formula), _) => sphere::<D>() * formula.radial_integral::<D>(),
        };
        unit * radius.powi(D as i32)
    }

    /// Bounds of the integral over space for a support radius of one.
    pub(crate) fn enclosed_integral<const D: usize>(self) -> Interval {
        match self {
            Self::Formula(formula) => {
                Interval::around(sphere::<D>(), 1) * formula.radial_enclosure::<D>()
            }
            // The integral is a sum of a few terms of order one, which cancel to a few hundredths.
            Self::Gaussian | Self::LaguerreGauss => Interval::around(self.integral::<D>(1.0), 512),
            _ => Interval::around(self.integral::<D>(1.0), 4),
        }
    }

    /// Factor that normalizes the integral over space to one; length^-D.
    pub fn normalization<const D: usize>(self, radius: f64) -> f64 {
        1.0 / self.integral::<D>(radius)
    }

    /// Radial moment `int |x|^n W(|x| / radius) dx` over space, by quadrature; length^(D+n).
    pub fn moment<const D: usize>(self, radius: f64, order: u32) -> f64 {
        let power = (D as u32 - 1 + order) as i32;
        let integrand = |q: f64| self.profile::<D, f64>(q).value * q.powi(power);
        let unit = sphere::<D>() * Pieces::new(self.breaks(), 8).integral(integrand);
        unit * radius.powi((D as u32 + order) as i32)
    }

    /// Standard deviation along one direction, `sigma^2 = int x_1^2 W dx / int W dx`; length.
    pub fn standard_deviation<const D: usize>(self, radius: f64) -> f64 {
        let second = self.moment::<D>(radius, 2) / D as f64;
        (second / self.integral::<D>(radius)).sqrt()
    }

    /// Support radius in units of the smoothing length `h = 2 sigma` of Dehnen and Aly (2012), a measure of resolution that makes kernels of
    /// different shape comparable.
    ///
    /// ```
    /// use onset::kernel::Kernel;
    /// let ratio = Kernel::CubicSpline.support_over_smoothing_length::<3>();
    /// assert!((ratio - 1.825742).abs() < 1e-6);
    /// ```
    pub fn support_over_smoothing_length<const D: usize>(self) -> f64 {
        0.5 / self.standard_deviation::<D>(1.0)
    }

    /// Support radius of this kernel for the smoothing length `h = 2 sigma`; length.
    pub fn radius_of<const D: usize>(self, smoothing_length: f64) -> f64 {
        smoothing_length * self.support_over_smoothing_length::<D>()
    }

    /// Smoothing length `h` for a support radius, in the convention of the papers and codes that use the kernel; length.
    ///
    /// It is `R0 / 3` for the quintic B-spline and for functions of `exp(-x^2 / h^2)`, `2/5 R0` for the quartic B-spline, and `R0 / 2` for all
    /// others.
    ///
    /// It is a convention, not a measure of resolution such as [`Kernel::support_over_smoothing_length`].
    ///
    /// ```
    /// use onset::kernel::Kernel;
    /// assert_eq!(Kernel::CubicSpline.nominal_smoothing_length(2.6), 1.3);
    /// assert_eq!(Kernel::QuinticSpline.nominal_smoothing_length(3.0), 1.0);
    /// ```
    pub fn nominal_smoothing_length(self, radius: f64) -> f64 {
        let radii = match self {
            Self::QuinticSpline | Self::Gaussian | Self::LaguerreGauss => 3.0,
            Self::QuarticBSpline => 2.5,
            Self::QuarticSpline
            | Self::CubicSpline
            | Self::WendlandC2
            | Self::WendlandC4
            | Self::WendlandC6
            | Self::Hyperbolic
            | Self::Formula(_) => 2.0,
        };
        radius / radii
    }

    /// Fourier transform `int W(|x| / radius) exp(i k . x) dx`, which is real and depends only on `|k|`; length^D.
    ///
    /// Where it is negative, density estimates favor the pairing of particles (Dehnen and Aly 2012). The quadrature is accurate to about `1e-14` of
    /// the long-wave value.
    ///
    /// ```
    /// use onset::kernel::Kernel;
    /// // The cubic B-spline is four boxes convolved: in one dimension the fourth power of a sinc.
    /// let (k, box_wave) = (6.0_f64, (1.5_f64).sin() / 1.5);
    /// let transform = Kernel::CubicSpline.fourier_transform::<1>(1.0, k);
    /// assert!((transform - 0.75 * box_wave.powi(4)).abs() < 1e-14);
    /// ```
    pub fn fourier_transform<const D: usize>(self, radius: f64, wave_number: f64) -> f64 {
        let turns = (wave_number * radius).abs();
        let panels = 8.0 + (turns / RADIANS).ceil();
        let integrand =
            |q: f64| self.profile::<D, f64>(q).value * q.powi(D as i32 - 1) * wave::<D>(turns * q);
        let unit = Pieces::new(self.breaks(), panels as usize).integral(integrand);
        sphere::<D>() * unit * radius.powi(D as i32)
    }
}
