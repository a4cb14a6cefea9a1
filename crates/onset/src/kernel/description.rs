//! Names, formulas and sources of kernels.

use super::{FormulaKernel, Kernel, KernelError};
use std::fmt::{Display, Formatter};
use std::str::FromStr;

impl Kernel {
    /// Returns the name of the kernel; for a formula, the text as entered.
    pub fn name(self) -> &'static str {
        match self {
            Self::QuarticSpline => "quartic-spline",
            Self::CubicSpline => "cubic-spline",
            Self::QuarticBSpline => "quartic-b-spline",
            Self::QuinticSpline => "quintic-spline",
            Self::WendlandC2 => "wendland-c2",
            Self::WendlandC4 => "wendland-c4",
            Self::WendlandC6 => "wendland-c6",
            Self::Gaussian => "gaussian",
            Self::Hyperbolic => "hyperbolic",
            Self::LaguerreGauss => "laguerre-gauss",
            Self::Formula(formula) => formula.text(),
        }
    }

    /// Returns the formula of the kernel, with `q = r / R0 < 1` and `(x)+` the positive part.
    pub fn formula(self) -> &'static str {
        match self {
            Self::QuarticSpline => "W = 1 - 6 q^2 + 8 q^3 - 3 q^4, q = r / R0 < 1",
            Self::CubicSpline => "W = 2 ((1 - q)^3 - 4 (1/2 - q)+^3), the B-spline M4",
            Self::QuarticBSpline => {
                "W = 125/46 ((1 - q)^4 - 5 (3/5 - q)+^4 + 10 (1/5 - q)+^4), the B-spline M5"
            }
            Self::QuinticSpline => {
                "W = 81/22 ((1 - q)^5 - 6 (2/3 - q)+^5 + 15 (1/3 - q)+^5), the B-spline M6"
            }
            Self::WendlandC2 => "W = (1 - q)^4 (1 + 4 q); 1D (1 - q)^3 (1 + 3 q)",
            Self::WendlandC4 => {
                "W = (1 - q)^6 (1 + 6 q + 35/3 q^2); 1D (1 - q)^5 (1 + 5 q + 8 q^2)"
            }
            Self::WendlandC6 => {
                "W = (1 - q)^8 (1 + 8 q + 25 q^2 + 32 q^3); 1D (1 - q)^7 (1 + 7 q + 19 q^2 + 21 q^3)"
            }
            Self::Gaussian => {
                "W ~ exp(-s^2), s = 3 q, less its Taylor polynomial of order 2 in s^2 about the rim"
            }
            Self::Hyperbolic => "W = (s^3 - 6 s + 6)/6 for s = 2 q < 1, (2 - s)^3/6 for s < 2",
            Self::LaguerreGauss => {
                "W ~ (1 - s^2/2 + s^4/6) exp(-s^2), s = 3 q, less its Taylor polynomial as for the Gaussian"
            }
            Self::Formula(formula) => formula.text(),
        }
    }

    /// Returns the source of the kernel in the literature.
    pub fn source(self) -> &'static str {
        match self {
            Self::QuarticSpline => "equation (35) of the paper",
            Self::CubicSpline => "Schoenberg 1946; Monaghan and Lattanzio 1985, with R0 = 2 h",
            Self::QuarticBSpline => "Schoenberg 1946; with R0 = 5/2 h in SPH",
            Self::QuinticSpline => "Schoenberg 1946; with R0 = 3 h in SPH",
            Self::WendlandC2 | Self::WendlandC4 | Self::WendlandC6 => {
                "Wendland 1995; Dehnen and Aly 2012, table 1"
            }
            Self::Gaussian => "Gingold and Monaghan 1977; smoothed at the rim by onset",
            Self::Hyperbolic => "Yang, Peng and Liu 2014, with R0 = 2 h",
            Self::LaguerreGauss => {
                "Wang, Zhang, Haidn and Hu 2024, cut off at 2 h there; smoothed at 3 h by onset"
            }
            Self::Formula(_) => "typed",
        }
    }
}

impl Display for Kernel {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for Kernel {
    type Err = KernelError;

    /// Parses the name of a kernel or a formula of `q`.
    fn from_str(text: &str) -> Result<Self, KernelError> {
        let text = text.trim();
        if let Some(kernel) = Self::ALL.into_iter().find(|kernel| kernel.name() == text) {
            return Ok(kernel);
        }
        let is_word = text != "q"
            && text.starts_with(|c: char| c.is_ascii_alphabetic())
            && text
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_'));
        if is_word || text.parse::<f64>().is_ok() {
            return Err(KernelError::UnknownName {
                name: text.to_owned(),
            });
        }
        FormulaKernel::parse(text).map(Self::Formula)
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Kernel {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Kernel {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}
