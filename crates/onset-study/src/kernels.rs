//! Figure of all kernels: weight and slope as functions of the distance in smoothing lengths.

use crate::figure::{Axis, Color, Dash, Figure, Line, Panel, Rule, palette};
use onset::kernel::Kernel;

/// Number of points of a curve.
const POINTS: usize = 240;
/// Largest distance in smoothing lengths that is drawn.
const LARGEST_DISTANCE: f64 = 3.0;

/// Draws the weight and its slope for every named kernel.
///
/// ```
/// let figure = onset_study::kernels::gallery();
/// assert_eq!(figure.legend_entries().len(), onset::kernel::Kernel::ALL.len());
/// ```
pub fn gallery() -> Figure {
    let label = "distance r/h (−)";
    let axis = || Axis::linear(label, (0.0, LARGEST_DISTANCE));
    let mut weights = Panel::new("", axis(), Axis::linear("weight W/W(0) (−)", (0.0, 1.05)));
    let steepest = Kernel::ALL.into_iter().flat_map(|kernel| curves(kernel).1);
    let vertical = Axis::linear("slope h W′/W(0) (−)", (-1.0, 0.0))
        .covering(steepest.map(|(_, slope)| slope).chain([0.0]));
    let mut slopes = Panel::new("", axis(), vertical).with(Rule::horizontal(0.0));
    for kernel in Kernel::ALL {
        let (color, dash) = look(kernel);
        let styled = |points: Vec<(f64, f64)>| {
            Line::new(points)
                .color(color)
                .dash(dash)
                .named(kernel.name())
        };
        let (weight, slope) = curves(kernel);
        weights = weights.with(styled(weight));
        // At the particle the slope of every kernel is zero by symmetry, also at a cusp.
        slopes = slopes.with(styled(slope[1..].to_vec()));
    }
    Figure::new("Kernels")
        .columns(2)
        .with(weights)
        .with(slopes)
        .caption(
            "h: smoothing length as papers and codes define it for each kernel. Wendland's functions of two and three dimensions.",
        )
}

/// Color of the family of a kernel, and dash pattern of the kernel in it. The colors differ in lightness, for greyscale prints.
fn look(kernel: Kernel) -> (Color, Dash) {
    match kernel {
        Kernel::CubicSpline => (palette::BLACK, Dash::Solid),
        Kernel::QuarticSpline => (palette::BLACK, Dash::Dashed),
        Kernel::QuarticBSpline => (palette::BLACK, Dash::Dashdot),
        Kernel::QuinticSpline => (palette::BLACK, Dash::Dotted),
        Kernel::WendlandC2 => (palette::BLUE, Dash::Solid),
        Kernel::WendlandC4 => (palette::BLUE, Dash::Dashed),
        Kernel::WendlandC6 => (palette::BLUE, Dash::Dotted),
        Kernel::Gaussian => (palette::ORANGE, Dash::Solid),
        Kernel::Hyperbolic => (palette::ORANGE, Dash::Dashed),
        Kernel::LaguerreGauss => (palette::ORANGE, Dash::Dotted),
        _ => (palette::SKY, Dash::Dashdot),
    }
}

/// Vertices of a curve.
type Curve = Vec<(f64, f64)>;

/// Weight and slope of a kernel as functions of the distance in smoothing lengths.
fn curves(kernel: Kernel) -> (Curve, Curve) {
    let rim = 1.0 / kernel.nominal_smoothing_length(1.0);
    let origin = kernel.profile::<3, f64>(0.0).value;
    let at = |n: usize| {
        // The profile is defined within the support.
        let q = n as f64 / POINTS as f64;
        let profile = kernel.profile::<3, f64>(q);
        let weight = profile.value / origin;
        let slope = profile.slope_over_q * q / origin / rim;
        ((q * rim, weight), (q * rim, slope))
    };
    (0..=POINTS).map(at).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_differ_in_dashes_or_in_lightness() {
        for a in Kernel::ALL {
            for b in Kernel::ALL.into_iter().filter(|b| b.name() != a.name()) {
                let [(first, dash), (second, other)] = [look(a), look(b)];
                let [first, second] = [first, second].map(palette::lightness);
                let differ = dash != other || (first - second).abs() > 20.0;
                assert!(differ, "{} and {}", a.name(), b.name());
            }
        }
    }

    #[test]
    fn slopes_are_the_derivatives_of_the_weights() {
        for kernel in Kernel::ALL {
            let (weight, slope) = curves(kernel);
            assert_eq!(weight[0], (0.0, 1.0), "{}", kernel.name());
            for n in 2..weight.len() {
                let (before, after) = (weight[n - 2], weight[n]);
                let difference = (after.1 - before.1) / (after.0 - before.0);
                let error = (difference - slope[n - 1].1).abs();
                assert!(error < 2e-3, "{} at {}", kernel.name(), weight[n - 1].0);
            }
        }
    }
}
