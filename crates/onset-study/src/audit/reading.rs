//! Identification of a tangent: every convention, correct or with the usual mistakes, compared with the delivered tangent.

use super::convention::{Convention, StressChange};
use nalgebra::Matrix6;
use onset::material::FourthOrder;
use onset_umat::voigt_of_tensor;
use serde::Serialize;

/// Tangent as delivered by the material.
#[derive(Clone, Debug)]
pub enum Delivery {
    /// Matrix between stresses and engineering strains, like `DDSDDE`.
    Matrix(Box<Matrix6<f64>>),
    /// Fourth-order tensor with all 81 components.
    Tensor(Box<FourthOrder>),
}

/// Measure of shear strain in the columns of shear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shear {
    /// Engineering shear strain, which is correct.
    Engineering,
    /// Tensor component of the shear strain: columns twice too large.
    Tensor,
    /// Columns of shear with half of the correct value.
    Halved,
}

/// Possible errors by a factor `J`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Volume {
    /// The factor is correct.
    Right,
    /// Too large by the factor `J`: the division by `J` is missing.
    TimesJacobian,
    /// Too small by the factor `J`: divided by `J` once too often.
    OverJacobian,
}

/// Order of the shear components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// 12, 13, 23, as in Abaqus/Standard.
    Standard,
    /// 12, 23, 13, as in Abaqus/Explicit.
    Explicit,
    /// 23, 13, 12, as in Voigt notation.
    Voigt,
}

impl Order {
    /// Positions of the standard components in this order.
    fn places(self) -> [usize; 6] {
        match self {
            Self::Standard => [0, 1, 2, 3, 4, 5],
            Self::Explicit => [0, 1, 2, 3, 5, 4],
            Self::Voigt => [0, 1, 2, 5, 4, 3],
        }
    }
}

/// A convention, correct or with mistakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Reading {
    /// Convention of the tangent.
    pub convention: Convention,
    /// Whether rows and columns are exchanged.
    pub transposed: bool,
    /// Measure of shear strain.
    pub shear: Shear,
    /// Error by a factor `J`.
    pub volume: Volume,
    /// Order of the shear components.
    pub order: Order,
}

impl Reading {
    /// The convention without mistakes.
    pub fn plain(convention: Convention) -> Self {
        Self {
            convention,
            transposed: false,
            shear: Shear::Engineering,
            volume: Volume::Right,
            order: Order::Standard,
        }
    }

    /// All readings that are tried, those without mistakes first.
    fn all(is_matrix: bool) -> Vec<Self> {
        let (shears, orders): (&[Shear], &[Order]) = match is_matrix {
            true => (
                &[Shear::Engineering, Shear::Tensor, Shear::Halved],
                &[Order::Standard, Order::Explicit, Order::Voigt],
            ),
            false => (&[Shear::Engineering], &[Order::Standard]),
        };
        let mut readings = Vec::new();
        for convention in Convention::ALL {
            for transposed in [false, true] {
                for &shear in shears {
                    for volume in [Volume::Right, Volume::TimesJacobian, Volume::OverJacobian] {
                        for &order in orders {
                            readings.push(Self {
                                convention,
                                transposed,
                                shear,
                                volume,
                                order,
                            });
                        }
                    }
                }
            }
        }
        readings.sort_by_key(|reading| reading.slips().len());
        readings
    }

    /// Description of the mistakes in addition to the convention.
    pub fn slips(&self) -> Vec<&'static str> {
        let slips = [
            (self.transposed, "transposed"),
            (
                self.shear == Shear::Tensor,
                "per tensor shear strain: columns of shear twice too large",
            ),
            (
                self.shear == Shear::Halved,
                "columns of shear half of the correct value",
            ),
            (
                self.volume == Volume::TimesJacobian,
                "not divided by J: too large by the factor J",
            ),
            (
                self.volume == Volume::OverJacobian,
                "divided by J twice: too small by the factor J",
            ),
            (
                self.order == Order::Explicit,
                "shear in the order 12, 23, 13",
            ),
            (self.order == Order::Voigt, "shear in the order 23, 13, 12"),
        ];
        slips
            .into_iter()
            .filter_map(|(is_made, words)| is_made.then_some(words))
            .collect()
    }

    /// Sentence on the convention and the mistakes.
    pub fn sentence(&self) -> String {
        let slips = self.slips();
        match slips.is_empty() {
            true => self.convention.meaning().to_owned(),
            false => format!("{}, {}", self.convention.meaning(), slips.join(", ")),
        }
    }

    /// Components that a material with this reading delivers; `tangent` is the tangent of the convention.
    fn expected(&self, tangent: &FourthOrder, jacobian: f64, is_matrix: bool) -> Vec<f64> {
        let scale = match self.volume {
            Volume::Right => 1.0,
            Volume::TimesJacobian => jacobian,
            Volume::OverJacobian => 1.0 / jacobian,
        };
        if !is_matrix {
            return indices()
                .map(|(i, j, k, l)| match self.transposed {
                    true => scale * tangent[(k, l, i, j)],
                    false => scale * tangent[(i, j, k, l)],
                })
                .collect();
        }
        let mut matrix = voigt_of_tensor(tangent) * scale;
        if self.transposed {
            matrix.transpose_mut();
        }
        let factor = match self.shear {
            Shear::Engineering => 1.0,
            Shear::Tensor => 2.0,
            Shear::Halved => 0.5,
        };
        let places = self.order.places();
        let mut expected = vec![0.0; 36];
        for a in 0..6 {
            for b in 0..6 {
                let factor = if b < 3 { 1.0 } else { factor };
                expected[6 * places[a] + places[b]] = factor * matrix[(a, b)];
            }
        }
        expected
    }
}

fn indices() -> impl Iterator<Item = (usize, usize, usize, usize)> {
    (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
}

impl Delivery {
    fn is_matrix(&self) -> bool {
        matches!(self, Self::Matrix(_))
    }

    fn components(&self) -> Vec<f64> {
        match self {
            Self::Matrix(matrix) => (0..36).map(|n| matrix[(n / 6, n % 6)]).collect(),
            Self::Tensor(tensor) => indices().map(|at| tensor[at]).collect(),
        }
    }

    /// Largest difference between a component and its mirror image across the diagonal, relative to the norm of all components.
    pub fn asymmetry(&self) -> f64 {
        match self {
            Self::Matrix(matrix) => relative(matrix.transpose().as_slice(), matrix.as_slice()),
            Self::Tensor(tensor) => {
                let mirrored = FourthOrder::from_fn(|i, j, k, l| tensor[(k, l, i, j)]);
                relative(
                    &self.components(),
                    &Self::Tensor(Box::new(mirrored)).components(),
                )
            }
        }
    }
}

/// `|a - b| / |b|`; one if only `b` is zero, infinite if any value is not finite.
pub fn relative(a: &[f64], b: &[f64]) -> f64 {
    relative_to(a, b, 0.0)
}

/// Difference `|a - b|` relative to the larger of `|b|` and `least`.
pub fn relative_to(a: &[f64], b: &[f64], least: f64) -> f64 {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let difference = norm(&mut a.iter().zip(b).map(|(a, b)| a - b));
    if difference == 0.0 {
        return 0.0;
    }
    let error = ratio(difference, norm(&mut b.iter().copied()).max(least));
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Ratio `size / scale`; one if only `scale` is zero, zero if both are.
pub fn ratio(size: f64, scale: f64) -> f64 {
    match (size == 0.0, scale == 0.0) {
        (true, _) => 0.0,
        (false, true) => 1.0,
        (false, false) => size / scale,
    }
}

/// Reading with its error against the delivered tangent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Match {
    /// Convention that the tangent follows, with the mistakes in it.
    #[serde(flatten)]
    pub reading: Reading,
    /// Sentence on the convention and the mistakes.
    pub sentence: String,
    /// Largest relative error over the states, in the Frobenius norm.
    pub error: f64,
    /// Relative error at each state.
    #[serde(skip)]
    pub errors: Vec<f64>,
}

/// Computes the error of every reading; readings with fewer mistakes come first.
pub fn matches(
    changes: &[StressChange],
    deliveries: &[Delivery],
    reference: &FourthOrder,
) -> Vec<Match> {
    let is_matrix = deliveries.iter().any(Delivery::is_matrix);
    let tangents: Vec<Vec<FourthOrder>> = Convention::ALL
        .into_iter()
        .map(|convention| {
            changes
                .iter()
                .map(|change| convention.tangent(change, reference))
                .collect()
        })
        .collect();
    let delivered: Vec<Vec<f64>> = deliveries.iter().map(Delivery::components).collect();
    Reading::all(is_matrix)
        .into_iter()
        .map(|reading| {
            let of_convention = Convention::ALL
                .into_iter()
                .zip(&tangents)
                .find(|(convention, _)| *convention == reading.convention)
                .map_or(&[][..], |(_, tangents)| tangents);
            let errors: Vec<f64> = of_convention
                .iter()
                .zip(changes)
                .zip(&delivered)
                .map(|((tangent, change), delivered)| {
                    let jacobian = change.deformation.jacobian();
                    relative(delivered, &reading.expected(tangent, jacobian, is_matrix))
                })
                .collect();
            Match {
                reading,
                sentence: reading.sentence(),
                error: errors.iter().copied().fold(0.0, f64::max),
                errors,
            }
        })
        .collect()
}
