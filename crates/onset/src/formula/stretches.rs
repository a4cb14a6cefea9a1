//! Part of a formula that depends on the principal stretches.

use super::Trouble;
use super::domain;
use super::error::Problem;
use super::graph::{Graph, Id, Leaf, Node};
use super::tape::Tape;
use crate::algebra::Each;
use crate::material::PrincipalEnergy;
use crate::real::{Interval, Jet, Real};
use std::ops::Range;

/// Symmetric function of the principal stretches; `J` is their product.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StretchTape(Tape);

/// Stretches at which the symmetry is tested.
const PROBE_STRETCHES: [[f64; 3]; 3] = [[0.9, 1.05, 1.2], [1.3, 0.7, 1.1], [0.8, 1.02, 1.6]];

/// Permutations of three other than the identity.
const ORDERS: [[usize; 3]; 5] = [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// Relative difference of values that counts as rounding.
const SYMMETRY_TOLERANCE: f64 = 1e-9;

impl StretchTape {
    /// Compiles the terms of a graph that need stretches. Returns a problem and its position if they are not admissible.
    pub(super) fn new(graph: &Graph, result: Id) -> Result<Self, (Range<usize>, Problem)> {
        let needed = graph.needed_by(result);
        for (id, node) in graph.nodes().iter().enumerate() {
            let problem = match node {
                // The derivatives along an exchange of two stretches would jump.
                Node::Select(..) => Problem::StretchesBranch,
                Node::Leaf(Leaf::Component(..) | Leaf::CauchyGreen(..)) => Problem::StretchesMixed,
                _ => continue,
            };
            if needed[id] {
                return Err((graph.range_of(id), problem));
            }
        }
        let tape = Self(Tape::new(graph, result));
        let largest = PROBE_STRETCHES.each(|at| tape.of_stretches(at).abs());
        let scale = largest.into_iter().fold(0.0, f64::max);
        for stretches in PROBE_STRETCHES {
            let value = tape.of_stretches(stretches);
            for order in ORDERS {
                let exchanged = tape.of_stretches(order.each(|n| stretches[n]));
                if (exchanged - value).abs() > SYMMETRY_TOLERANCE * scale {
                    let problem = Problem::NotSymmetric {
                        stretches,
                        value,
                        exchanged,
                    };
                    return Err((graph.range_of(result), problem));
                }
            }
        }
        Ok(tape)
    }

    /// Part that is undefined at some stretches, with the reason.
    pub(super) fn trouble(&self, stretches: [Interval; 3]) -> Option<(Trouble, Range<usize>)> {
        let Self(tape) = self;
        if tape.is_plain() {
            return None;
        }
        // Without a condition the two sides cannot differ.
        domain::trouble(
            tape,
            |part| leaf(stretches, part),
            |_| Jet::constant(f64::NAN),
        )
    }
}

fn leaf<R: Real>(stretches: [R; 3], leaf: Leaf) -> R {
    match leaf {
        Leaf::Stretch(n) => stretches[n],
        Leaf::Jacobian => stretches[0] * stretches[1] * stretches[2],
        Leaf::Component(..) | Leaf::CauchyGreen(..) | Leaf::Argument => R::constant(f64::NAN),
    }
}

impl PrincipalEnergy for StretchTape {
    fn of_stretches<R: Real>(&self, stretches: [R; 3]) -> R {
        self.0.evaluate(|part| leaf(stretches, part))
    }

    fn is_defined(&self, stretches: [Interval; 3]) -> bool {
        self.trouble(stretches).is_none()
    }
}
