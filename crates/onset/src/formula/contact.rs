//! Smoothness of a formula where the two sides of a branch meet, derived from its form alone.

use super::graph::{Function, Graph, Id, Node};

/// Order that counts as infinitely smooth.
const INFINITE_ORDER: u32 = 64;

/// Lower bounds of the smoothness of a node where a test is zero.
#[derive(Clone, Copy)]
struct Contact {
    /// Order of the zero of the node in the test, on both sides.
    order: u32,
    /// Order of agreement of the two sides of the node.
    agreement: u32,
}

/// Returns true if value and first derivatives of a result certainly agree on both sides of a test where the test is zero.
///
/// If a node that vanishes to order `m` multiplies a node whose sides agree to order `n`, the sides of the product agree to order `m + n`: `<x>^2` is
/// smooth although `<x>` is not. Smoothness that this rule does not detect is assumed to be missing.
pub(super) fn is_smooth_across(graph: &Graph, needed: &[bool], test: Id, result: Id) -> bool {
    if is_piecewise_constant(graph, test) {
        // The test changes only where another test does.
        return true;
    }
    let mut contacts: Vec<Contact> = Vec::with_capacity(result + 1);
    for id in 0..=result {
        let contact = if needed[id] {
            across(graph, &contacts, test, id)
        } else {
            Contact {
                order: 0,
                agreement: 0,
            }
        };
        contacts.push(contact);
    }
    contacts[result].agreement >= 2
}

fn across(graph: &Graph, contacts: &[Contact], test: Id, id: Id) -> Contact {
    let of = |id: Id| contacts[id];
    let limited = |order: u32, agreement: u32| Contact {
        order: order.min(INFINITE_ORDER),
        agreement: agreement.min(INFINITE_ORDER),
    };
    let smooth = |order: u32| limited(order, INFINITE_ORDER);
    let mut contact = match graph.nodes()[id] {
        Node::Constant(bits) if bits.value() == 0.0 => smooth(INFINITE_ORDER),
        Node::Constant(_) | Node::Parameter(_) | Node::Leaf(_) => smooth(0),
        Node::Apply(function, a) => {
            let vanishes_with = matches!(
                function,
                Function::Sine | Function::HyperbolicSine | Function::HyperbolicTangent
            );
            let order = if vanishes_with { of(a).order } else { 0 };
            limited(order, of(a).agreement)
        }
        Node::Negate(a) => of(a),
        Node::Add(a, b) | Node::Subtract(a, b) => limited(
            of(a).order.min(of(b).order),
            of(a).agreement.min(of(b).agreement),
        ),
        Node::Multiply(a, b) => {
            let (a, b) = (of(a), of(b));
            let agreement = (a.order + b.agreement).min(b.order + a.agreement);
            limited(a.order + b.order, agreement)
        }
        Node::Divide(a, b) => {
            let (a, b) = (of(a), of(b));
            limited(a.order, a.agreement.min(a.order + b.agreement))
        }
        Node::Power(a, b) => match graph.value(b) {
            Some(exponent) if exponent >= 1.0 && exponent.fract() == 0.0 => {
                let count = exponent.min(f64::from(INFINITE_ORDER)) as u32;
                let a = of(a);
                limited(count * a.order, (count - 1) * a.order + a.agreement)
            }
            // For a base that may vanish no smoothness is guaranteed.
            _ if of(a).order > 0 => limited(0, 0),
            _ => limited(0, of(a).agreement.min(of(b).agreement)),
        },
        Node::Select(own, below, above) => {
            let (below, above) = (of(below), of(above));
            let order = below.order.min(above.order);
            let within = below.agreement.min(above.agreement);
            // The selected side changes with the test, or because the inner test changes.
            let changes = graph.multiple(own, test).is_some() || of(own).agreement < INFINITE_ORDER;
            limited(order, if changes { within.min(order) } else { within })
        }
    };
    if graph.multiple(id, test).is_some() {
        contact.order = contact.order.max(1);
    }
    contact
}

/// Returns true if a node has discrete values and jumps between them where tests change, like a condition used as a number.
fn is_piecewise_constant(graph: &Graph, id: Id) -> bool {
    let mut known = Vec::with_capacity(id + 1);
    for node in &graph.nodes()[..=id] {
        known.push(match *node {
            Node::Constant(_) => true,
            Node::Select(_, below, above) => known[below] && known[above],
            Node::Add(a, b) | Node::Subtract(a, b) => known[a] && known[b],
            _ => false,
        });
    }
    known[id]
}
