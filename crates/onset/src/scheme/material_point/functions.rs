//! Grid functions of the material point method: products of piecewise polynomials of one coordinate.

use crate::algebra::{Each, array_of};
use crate::lattice::cells_between;
use crate::real::{Dual, Real};
use crate::scheme::inverse;

/// Largest distance from a knot, in units of the grid spacing, of positions that count as on the knot.
const KNOT: f64 = 1e-9;
/// Second moments below this value occur only at points on a node. Linear functions have no second moment there, and slopes replace the first moments
/// divided by it.
pub(super) const MINIMUM_SECOND_MOMENT: f64 = 1e-8;

/// Grid functions of the material point method. All are partitions of unity and reproduce linear fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum GridFunctions {
    /// Linear hat functions, `1 - |x|`: the original method (Sulsky, Chen and Schreyer 1994).
    Linear,
    /// Hat functions averaged over a particle of constant size (uniform generalized interpolation, GIMP; Bardenhagen and Kober 2004).
    Gimp,
    /// Hat functions at the corners of a particle that deforms with its point (convected particle domain interpolation, CPDI; Sadeghirad and others,
    /// Int. J. Numer. Methods Eng. 86 (2011) 1435).
    Cpdi,
    /// Quadratic B-splines centered at the nodes.
    QuadraticSpline,
    /// Cubic B-splines centered at the nodes.
    CubicSpline,
}

/// Gradients of the grid functions in forces and velocity gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum GridGradients {
    /// The gradients of the functions, `grad N_i`.
    #[default]
    Functions,
    /// First moments, `D_p^-1 N_i (x_i - x_p)` with `D_p = sum_j N_j (x_j - x_p) (x) (x_j - x_p)`: moving least squares (MLS-MPM; Hu et al. 2018).
    ///
    /// The affine field of a point is then its velocity gradient. These gradients are as smooth as the functions, not as their slopes. For linear
    /// functions they are the gradients.
    Moments,
}

/// Polynomial of `r = |x|` from `from` to `to`, in units of the grid spacing.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    from: f64,
    to: f64,
    coefficients: [f64; 4],
}

/// Even piecewise polynomial of one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Profile {
    pieces: Vec<Piece>,
    /// Pieces whose slopes are the gradients: the pieces of the function itself except for convected domains.
    sloping: Vec<Piece>,
    /// Half-size, in units of the grid spacing, of a particle whose corners interpolate; `None` for functions of the position of the point alone.
    domain: Option<f64>,
    gradients: GridGradients,
}

/// Deformation of a particle since the homogeneous state, in lattice coordinates of the grid.
pub(super) type Stretch<R, const D: usize> = [[R; D]; D];

/// Value of the function of a node at a position, with derivatives with respect to the lattice coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape<R, const D: usize> {
    pub(super) value: R,
    pub(super) slope: [R; D],
}

impl GridFunctions {
    /// Returns the function of one coordinate for particles with the half-size `l <= 1/2`.
    pub(super) fn profile(self, l: f64, gradients: GridGradients) -> Profile {
        // The mean gradient of convected domains in their initial shape is the gradient of GIMP.
        let sloping = match self {
            Self::Cpdi => Self::Gimp.pieces(l),
            own => own.pieces(l),
        };
        Profile {
            pieces: self.pieces(l),
            sloping,
            domain: (self == Self::Cpdi).then_some(l),
            gradients,
        }
    }

    fn pieces(self, l: f64) -> Vec<Piece> {
        let pieces: Vec<(f64, [f64; 4])> = match self {
            Self::Linear => vec![(1.0, [1.0, -1.0, 0.0, 0.0])],
            Self::Cpdi => vec![
                (l, [1.0 - l, 0.0, 0.0, 0.0]),
                (1.0 - l, [1.0, -1.0, 0.0, 0.0]),
                (1.0 + l, [0.5 * (1.0 + l), -0.5, 0.0, 0.0]),
            ],
            Self::Gimp => {
                let outer = 0.25 / l;
                let end = 1.0 + l;
                let last = [outer * end * end, -2.0 * outer * end, outer, 0.0];
                vec![
                    (l, [1.0 - 0.5 * l, 0.0, -0.5 / l, 0.0]),
                    (1.0 - l, [1.0, -1.0, 0.0, 0.0]),
                    (end, last),
                ]
            }
            Self::QuadraticSpline => vec![
                (0.5, [0.75, 0.0, -1.0, 0.0]),
                (1.5, [1.125, -1.5, 0.5, 0.0]),
            ],
            Self::CubicSpline => vec![
                (1.0, [2.0 / 3.0, 0.0, -1.0, 0.5]),
                (2.0, [4.0 / 3.0, -2.0, 1.0, -1.0 / 6.0]),
            ],
        };
        let mut from = 0.0;
        let mut profile = Vec::new();
        for (to, coefficients) in pieces {
            // With one particle per cell the generalized hat function has no straight piece.
            if to > from + KNOT {
                profile.push(Piece {
                    from,
                    to,
                    coefficients,
                });
                from = to;
            }
        }
        profile
    }
}

impl Piece {
    fn value<R: Real>(&self, r: R) -> R {
        let [a, b, c, d] = self.coefficients;
        ((r * d + c) * r + b) * r + a
    }

    fn slope<R: Real>(&self, r: R) -> R {
        let [_, b, c, d] = self.coefficients;
        (r * (3.0 * d) + 2.0 * c) * r + b
    }
}

impl Profile {
    /// Distance at which the function ends.
    pub(super) fn reach(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.to)
    }

    /// Returns the function and its slope. On a knot the slope and its derivatives are the means of both sides.
    fn at<R: Real>(&self, x: R) -> (R, R) {
        let sign = if x.value() < 0.0 { -1.0 } else { 1.0 };
        let r = x * sign;
        let distance = r.value();
        let sum = |pieces: &[Piece], of: &dyn Fn(&Piece) -> R| {
            let mut sum = R::constant(0.0);
            for piece in pieces {
                let is_within = distance >= piece.from - KNOT && distance <= piece.to + KNOT;
                let is_on_knot = (piece.from > 0.0 && distance <= piece.from + KNOT)
                    || distance >= piece.to - KNOT;
                if is_within {
                    sum = sum + of(piece) * if is_on_knot { 0.5 } else { 1.0 };
                }
            }
            sum
        };
        (
            sum(&self.pieces, &|piece| piece.value(r)),
            sum(&self.sloping, &|piece| piece.slope(r)) * sign,
        )
    }

    /// Second moment `D_p` along an axis, `sum_j N_j (x_j - x_p)^2`, at the position `x` relative to a node; in units of the squared grid spacing.
    ///
    /// It is 1/4 for quadratic and 1/3 for cubic splines at any position. For linear functions it is `x (1 - x)`.
    pub(super) fn second_moment<R: Real>(&self, x: R) -> R {
        let beyond = self.reach().ceil() as i32 + 1;
        let nearest = x - x.value().round();
        (-beyond..=beyond).fold(R::constant(0.0), |sum, node| {
            let distance = nearest - f64::from(node);
            sum + self.at(distance).0 * distance * distance
        })
    }

    /// Sum `sum_j g_j^2 / N_j` along an axis with the gradients in use, at the position `x` relative to a node; per squared grid spacing.
    ///
    /// Where a function ends with zero slope the term is its limit, twice the curvature. On a knot it is the mean of both sides.
    pub(super) fn squared_gradients(&self, x: f64) -> f64 {
        let beyond = self.reach().ceil() as i32 + 1;
        let nearest = x - x.round();
        let of_node = |node: i32| {
            let [distance] = Dual::<1>::variables([nearest - f64::from(node)]);
            let (value, gradient) = self.along(distance);
            match value.value > KNOT {
                true => gradient.value * gradient.value / value.value,
                // The gradient of a convected domain vanishes with the function.
                false if self.domain.is_some() => 0.0,
                false => 2.0 * gradient.gradient[0],
            }
        };
        (-beyond..=beyond).map(of_node).sum()
    }

    /// Returns the function and, in place of its slope, the gradient chosen by [`GridGradients`].
    fn along<R: Real>(&self, x: R) -> (R, R) {
        let (value, slope) = self.at(x);
        match self.gradients {
            GridGradients::Functions => (value, slope),
            GridGradients::Moments => match self.second_moment(x) {
                moment if moment.value() > MINIMUM_SECOND_MOMENT => (value, -(value * x) / moment),
                _ => (value, slope),
            },
        }
    }

    /// Nodes whose functions may be nonzero at a position, by their lattice coordinates.
    pub(super) fn nodes<const D: usize>(&self, place: &[f64; D]) -> Vec<[i32; D]> {
        let reach = self.reach() + KNOT;
        let low = place.each(|x| (x - reach).ceil() as i32);
        let high = place.each(|x| (x + reach).floor() as i32);
        cells_between(&low, &high)
    }

    /// Nodes whose functions may be nonzero at the position of a particle that has deformed.
    pub(super) fn nodes_around<const D: usize>(
        &self,
        place: &[f64; D],
        stretch: &Stretch<f64, D>,
    ) -> Vec<[i32; D]> {
        let Some(l) = self.domain else {
            return self.nodes(place);
        };
        let reach = |i: usize| 1.0 + KNOT + l * stretch[i].iter().map(|x| x.abs()).sum::<f64>();
        let low = array_of(|i| (place[i] - reach(i)).ceil() as i32);
        let high = array_of(|i| (place[i] + reach(i)).floor() as i32);
        cells_between(&low, &high)
    }

    /// Returns the function of a node at the position of a particle that has deformed, all in lattice coordinates.
    ///
    /// The corners of a convected domain are at `x_c = x + l M s_c` with the deformation `M` and signs `s_c`. With the hat function `N` of the node, the
    /// mean of the values interpolated between the corners is `sum_c N(x_c) / 2^d`, and the mean of their gradient is
    /// `M^-T sum_c s_c N(x_c) / (2^d l)`.
    pub(super) fn shape_of<R: Real, const D: usize>(
        &self,
        place: &[R; D],
        node: &[i32; D],
        stretch: &Stretch<R, D>,
    ) -> Shape<R, D> {
        let Some(l) = self.domain else {
            return self.shape(place, node);
        };
        let zero = R::constant(0.0);
        let (mut value, mut along) = (zero, [zero; D]);
        for corner in 0..1_usize << D {
            let sign = |k: usize| if corner >> k & 1 == 1 { 1.0 } else { -1.0 };
            let hat = (0..D).fold(R::constant(1.0), |product, i| {
                let start = place[i] - f64::from(node[i]);
                let x = (0..D).fold(start, |sum, k| sum + stretch[i][k] * (l * sign(k)));
                product * hat(x)
            });
            value = value + hat;
            along = array_of(|k| along[k] + hat * sign(k));
        }
        let share = 0.5_f64.powi(D as i32);
        let inverse = inverse(stretch);
        let slope =
            |i: usize| (0..D).fold(zero, |sum, k| sum + inverse[k][i] * along[k]) * (share / l);
        Shape {
            value: value * share,
            slope: array_of(slope),
        }
    }

    /// Returns the function of a node at a position, both in lattice coordinates.
    pub(super) fn shape<R: Real, const D: usize>(
        &self,
        place: &[R; D],
        node: &[i32; D],
    ) -> Shape<R, D> {
        let along: [(R, R); D] = array_of(|i| self.along(place[i] - f64::from(node[i])));
        let one = R::constant(1.0);
        let product = |derived: Option<usize>| {
            (0..D).fold(one, |product, i| {
                let (value, slope) = along[i];
                product * if derived == Some(i) { slope } else { value }
            })
        };
        Shape {
            value: product(None),
            slope: array_of(|i| product(Some(i))),
        }
    }
}

/// Hat function `1 - |x|`. On a knot its derivative is the mean of both sides.
fn hat<R: Real>(x: R) -> R {
    let value = x.value();
    let (left, right) = (x + 1.0, -x + 1.0);
    match value.abs() {
        distance if distance < KNOT => (left + right) * 0.5,
        distance if distance > 1.0 + KNOT => R::constant(0.0),
        distance if distance > 1.0 - KNOT => (if value < 0.0 { left } else { right }) * 0.5,
        _ if value < 0.0 => left,
        _ => right,
    }
}

#[cfg(test)]
mod tests {
    use super::{GridFunctions, GridGradients};
    use crate::real::{Dual, Real};

    const ALL: [GridFunctions; 5] = [
        GridFunctions::Linear,
        GridFunctions::Gimp,
        GridFunctions::Cpdi,
        GridFunctions::QuadraticSpline,
        GridFunctions::CubicSpline,
    ];

    #[test]
    fn grid_functions_are_partitions_of_unity_that_reproduce_linear_fields() {
        let both = [GridGradients::Functions, GridGradients::Moments];
        for (functions, gradients) in ALL.into_iter().flat_map(|own| both.map(|g| (own, g))) {
            for l in [0.5, 0.25, 1.0 / 6.0] {
                let profile = functions.profile(l, gradients);
                for place in [[0.13, 0.5], [0.25, 0.75], [0.99, 0.34], [0.5, 0.5]] {
                    let (mut one, mut position) = (0.0, [0.0; 2]);
                    let (mut zero, mut unit) = ([0.0; 2], [[0.0; 2]; 2]);
                    for node in profile.nodes(&place) {
                        let shape = profile.shape(&place, &node);
                        one += shape.value;
                        for i in 0..2 {
                            position[i] += shape.value * f64::from(node[i]);
                            zero[i] += shape.slope[i];
                            for j in 0..2 {
                                unit[i][j] += f64::from(node[i]) * shape.slope[j];
                            }
                        }
                    }
                    assert!((one - 1.0).abs() < 1e-14, "{functions:?} {place:?}");
                    for i in 0..2 {
                        assert!((position[i] - place[i]).abs() < 1e-14);
                        assert!(zero[i].abs() < 1e-14);
                        for j in 0..2 {
                            let expected = f64::from(u8::from(i == j));
                            assert!((unit[i][j] - expected).abs() < 1e-14);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn slopes_are_derivatives_and_at_knots_the_mean_of_both_sides() {
        for functions in ALL.into_iter().filter(|own| *own != GridFunctions::Cpdi) {
            let profile = functions.profile(0.25, GridGradients::Functions);
            for x in [-1.6, -0.75, -0.5, 0.1, 0.3, 0.5, 1.1, 1.25, 1.5] {
                let [dual] = Dual::<1>::variables([x]);
                let (value, slope) = profile.at(dual);
                let h = 1e-6;
                let (plus, minus) = (profile.at(x + h), profile.at(x - h));
                let slopes = (value.gradient[0], (plus.0 - minus.0) / (2.0 * h));
                assert!((slopes.0 - slope.value()).abs() < 1e-14);
                // Where the curvature jumps, the difference quotient is accurate to first order.
                assert!((slopes.0 - slopes.1).abs() < 2e-6, "{functions:?} {x}");
                let curvature = (plus.1 - minus.1) / (2.0 * h);
                assert!(
                    (slope.gradient[0] - curvature).abs() < 1e-6,
                    "{functions:?} {x}"
                );
            }
        }
    }

    #[test]
    fn the_gimp_function_is_the_mean_of_the_hat_function_over_the_particle() {
        let l = 0.3;
        let (tent, mean) = (
            GridFunctions::Linear.profile(l, GridGradients::Functions),
            GridFunctions::Gimp.profile(l, GridGradients::Functions),
        );
        for x in [0.0, 0.2, 0.5, 0.9, 1.2] {
            let n = 20_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    tent.at(x + l * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0))
                        .0
                })
                .sum();
            assert!((sum / f64::from(n) - mean.at(x).0).abs() < 1e-7);
        }
    }

    #[test]
    fn squared_gradients_at_the_end_of_a_function_are_the_mean_of_both_sides() {
        for functions in [
            GridFunctions::Gimp,
            GridFunctions::QuadraticSpline,
            GridFunctions::CubicSpline,
        ] {
            for gradients in [GridGradients::Functions, GridGradients::Moments] {
                let profile = functions.profile(0.25, gradients);
                for knot in [0.25, 0.5, 0.75, 1.0] {
                    let of = |x: f64| profile.squared_gradients(x);
                    let mean = 0.5 * (of(knot + 1e-4) + of(knot - 1e-4));
                    let difference = (of(knot) - mean).abs();
                    // The slopes of the other functions have kinks there.
                    assert!(difference < 5e-3, "{functions:?} {gradients:?} {knot}");
                }
            }
        }
        // Halfway between two nodes, these two contribute 1/(1/2) each. The function that ends there contributes 2, as does the function that begins
        // beyond.
        let profile = GridFunctions::QuadraticSpline.profile(0.25, GridGradients::Functions);
        for x in [0.5 - 1e-6, 0.5, 0.5 + 1e-6] {
            assert!((profile.squared_gradients(x) - 6.0).abs() < 1e-4, "{x}");
        }
    }

    #[test]
    fn second_moments_are_one_quarter_for_quadratic_and_one_third_for_cubic_splines() {
        // Jiang et al. 2015, The affine particle-in-cell method: D_p = h^2/4 and h^2/3.
        for x in [-0.4, 0.0, 0.2, 0.5, 0.77, 1.3] {
            let of = |functions: GridFunctions| {
                let profile = functions.profile(0.25, GridGradients::Functions);
                profile.second_moment(x)
            };
            assert!((of(GridFunctions::QuadraticSpline) - 0.25).abs() < 1e-15);
            assert!((of(GridFunctions::CubicSpline) - 1.0 / 3.0).abs() < 1e-15);
            let inside = x - f64::floor(x);
            let expected = inside * (1.0 - inside);
            assert!((of(GridFunctions::Linear) - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn first_moments_of_linear_functions_are_their_gradients() {
        let [of_functions, of_moments] = [GridGradients::Functions, GridGradients::Moments]
            .map(|gradients| GridFunctions::Linear.profile(0.5, gradients));
        let place = [0.3, 0.85, 0.1];
        for node in of_functions.nodes(&place) {
            let [exact, moment] =
                [&of_functions, &of_moments].map(|profile| profile.shape(&place, &node).slope);
            for (a, b) in exact.into_iter().zip(moment) {
                assert!((a - b).abs() < 1e-15);
            }
        }
    }
}
