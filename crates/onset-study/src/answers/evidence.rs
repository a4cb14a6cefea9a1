//! Evidence for a verdict.

use serde::Serialize;
use std::fmt;

/// Evidence for the verdict of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Evidence {
    /// Certificate in interval arithmetic over the continuous zone.
    Proved,
    /// Lower bound in floating point over the continuous zone.
    Bounded,
    /// Grid search and descent from its smallest values, without a bound.
    Searched,
}

impl Evidence {
    /// Evidence for a verdict with or without a deciding certificate and a bound.
    pub(crate) fn of(is_certified: bool, is_bounded: bool) -> Self {
        match (is_certified, is_bounded) {
            (true, _) => Self::Proved,
            (false, true) => Self::Bounded,
            (false, false) => Self::Searched,
        }
    }

    /// Word in files and answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Bounded => "bounded",
            Self::Searched => "searched",
        }
    }
}

impl Evidence {
    /// Describes how the evidence was computed.
    pub(crate) fn words(self) -> String {
        let how = match self {
            Self::Proved => "in interval arithmetic over the continuous zone",
            Self::Bounded => "from below in floating point over the continuous zone",
            Self::Searched => "on a grid and by descent, without a bound",
        };
        format!("{} {how}", self.name())
    }
}

impl fmt::Display for Evidence {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:<24}{}", "evidence", self.words())
    }
}
