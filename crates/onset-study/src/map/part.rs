//! Parts of a map, computed by several processes.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Selection of the tiles of a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// Range of tiles such as `0..64`, whose end is exclusive.
    Range(Range<usize>),
    /// One of `of` shares, counted from 1, as in `2/8`.
    ///
    /// Its tiles are spread evenly over the map, so that shares take about the same time even if some states are more expensive than others.
    Share {
        /// Number of the share, from 1.
        number: usize,
        /// Number of shares in the map.
        of: usize,
    },
}

impl Part {
    /// Returns the indices of the selected tiles, from 0, in a map of `all` tiles.
    pub fn tiles(&self, all: usize) -> Vec<usize> {
        match self {
            Self::Range(range) => (range.start..range.end.min(all)).collect(),
            Self::Share { number, of } => (number - 1..all).step_by(*of).collect(),
        }
    }
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        let two = |between: &str| {
            let (first, second) = text.split_once(between)?;
            Some((number(first)?, number(second)?))
        };
        match (two(".."), two("/")) {
            (Some((start, end)), _) if start < end => Ok(Self::Range(start..end)),
            (_, Some((number, of))) if (1..=of).contains(&number) => {
                Ok(Self::Share { number, of })
            }
            _ => Err(
                "expected a range of tiles that excludes its last number, for example 0..64, or a share and the number of shares, for example 1/8"
                    .to_owned(),
            ),
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(range) => write!(f, "{}..{}", range.start, range.end),
            Self::Share { number, of } => write!(f, "{number}/{of}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Part;

    #[test]
    fn shares_are_disjoint_and_cover_all_tiles() {
        for (of, all) in [(1, 25), (2, 25), (8, 25), (30, 25)] {
            let mut together: Vec<usize> = (1..=of)
                .flat_map(|number| Part::Share { number, of }.tiles(all))
                .collect();
            together.sort_unstable();
            assert_eq!(together, (0..all).collect::<Vec<_>>());
        }
    }

    #[test]
    fn parts_are_printed_as_they_are_parsed() {
        for text in ["0..64", "3..4", "1/8", "8/8"] {
            let part: Part = text.parse().expect("a part");
            assert_eq!(part.to_string(), text);
        }
        for text in [
            "0/8", "9/8", "1/0", "4..4", "1/2/3", "1", "", "-1/2", "0..1/2",
        ] {
            assert!(text.parse::<Part>().is_err(), "{text}");
        }
    }
}
