//! Kinks of the stress along a loading: where the tangent jumps, limits depend on which side is asked.

use super::LoadingPath;
use crate::algebra::{Each, sort_by_value};
use crate::material::FourthOrder;

/// A stretch at which the tangent jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kink {
    /// The imposed stretch.
    pub stretch: f64,
    /// The size of the jump by that of the tangent, in the norm of all components.
    pub jump: f64,
}

/// Jumps of the tangent smaller than this, relative, are not told.
const SMALLEST: f64 = 1e-6;
/// A smooth tangent changes in the half of an interval in which it changes more by less than this part, as soon as the interval is short.
const PART: f64 = 0.75;
/// How far the interval around a kink is narrowed, in `ln lambda`.
const WIDTH: f64 = 1e-12;

/// The kinks of the stress along a loading, nearest to the reference first.
///
/// Between neighboring states of the path the half in which the tangent `dP/dF` changes more is followed: the change in it becomes half with
/// every step where the tangent is smooth, and stays where it jumps. A jump that is small beside the change of the tangent between two states of the path is
/// overlooked. Laws of which a fiber bears tension only, typed laws with conditions and tables with corners have kinks; there a law has one-sided
/// wave speeds, and Newton's method can fail.
///
/// ```
/// use onset::criteria::{Lateral, Loading, LoadingPath, Mode, Range, kinks};
/// use onset::material::BlatzKo;
/// let law = BlatzKo::default();
/// let loading = Loading { mode: Mode::Uniaxial, lateral: Lateral::Free };
/// assert!(kinks(&LoadingPath::new(&law, true, loading, &Range::default())?).is_empty());
/// # Ok::<(), onset::criteria::LoadingError>(())
/// ```
pub fn kinks(path: &LoadingPath<'_>) -> Vec<Kink> {
    let compression = path.compression.iter().skip(1).rev();
    let states: Vec<_> = compression.chain(&path.tension).collect();
    let mut found: Vec<Kink> = states
        .windows(3)
        .filter_map(|three| {
            // A kink at a state itself lies between its neighbors.
            let of = |n: usize| (three[n].parameter, &three[n].response.tangent);
            narrowed(path, of(0), of(2), of(1))
        })
        .collect();
    sort_by_value(&mut found, |kink| kink.stretch);
    found.dedup_by(|a, b| (a.stretch.ln() - b.stretch.ln()).abs() < 1e-9);
    sort_by_value(&mut found, |kink| kink.stretch.ln().abs());
    found
}

/// The kink between two states, with a state between them.
fn narrowed(
    path: &LoadingPath<'_>,
    low: (f64, &FourthOrder),
    high: (f64, &FourthOrder),
    middle: (f64, &FourthOrder),
) -> Option<Kink> {
    let mut ends = [(low.0, low.1.clone()), (high.0, high.1.clone())];
    let mut between = (middle.0, middle.1.clone());
    let mut whole = distance(&ends[0].1, &ends[1].1);
    while ends[1].0 - ends[0].0 > WIDTH {
        let halves = [0, 1].each(|side: usize| distance(&ends[side].1, &between.1));
        let side = usize::from(halves[1] > halves[0]);
        if halves[side] < PART * whole || halves[side] <= SMALLEST * size(&between.1) {
            return None;
        }
        whole = halves[side];
        ends[1 - side] = between;
        let s = 0.5 * (ends[0].0 + ends[1].0);
        if s <= ends[0].0 || s >= ends[1].0 {
            break;
        }
        between = (s, path.at(s)?.response.tangent);
    }
    let parameter = 0.5 * (ends[0].0 + ends[1].0);
    let parameter = if parameter.abs() < WIDTH {
        0.0
    } else {
        parameter
    };
    // States near the end of a path lie closer than the width from the start.
    let jump = whole / size(&ends[0].1).max(size(&ends[1].1));
    (jump > SMALLEST).then(|| Kink {
        stretch: parameter.exp(),
        jump,
    })
}

fn components() -> impl Iterator<Item = (usize, usize, usize, usize)> {
    (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
}

fn distance(a: &FourthOrder, b: &FourthOrder) -> f64 {
    components()
        .map(|at| (a[at] - b[at]).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn size(a: &FourthOrder) -> f64 {
    components().map(|at| a[at].powi(2)).sum::<f64>().sqrt()
}
