//! How smoothly the two sides of a branch meet, by the form of a formula alone.

use super::graph::{Function, Graph, Id, Node};

/// As smooth as one likes.
const ENDLESS: u32 = 64;

/// What is known of a node where a test is zero: both are lower bounds.
#[derive(Clone, Copy)]
struct Contact {
    /// To which order in the test it vanishes there, on both sides.
    order: u32,
    /// To which order its two sides agree.
    agreement: u32,
}

/// Whether value and first derivatives of a result certainly agree on both sides of a test, where that is zero.
///
/// A node that vanishes to order `m`, times one whose sides agree to order `n`, has sides that agree to order `m + n`: `<x>^2` is smooth
/// though `<x>` is not. What this does not see counts as rough.
pub(super) fn is_smooth_across(graph: &Graph, needed: &[bool], test: Id, result: Id) -> bool {
    if is_piecewise_constant(graph, test) {
        // It changes only where another test does.
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
        order: order.min(ENDLESS),
        agreement: agreement.min(ENDLESS),
    };
    let smooth = |order: u32| limited(order, ENDLESS);
    let mut contact = match graph.nodes()[id] {
        Node::Constant(bits) if bits.value() == 0.0 => smooth(ENDLESS),
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
                let count = exponent.min(f64::from(ENDLESS)) as u32;
                let a = of(a);
                limited(count * a.order, (count - 1) * a.order + a.agreement)
            }
            // Of a base that may vanish nothing is known.
            _ if of(a).order > 0 => limited(0, 0),
            _ => limited(0, of(a).agreement.min(of(b).agreement)),
        },
        Node::Select(own, below, above) => {
            let (below, above) = (of(below), of(above));
            let order = below.order.min(above.order);
            let within = below.agreement.min(above.agreement);
            // The side changes with the test, or because its own test does.
            let changes = graph.multiple(own, test).is_some() || of(own).agreement < ENDLESS;
            limited(order, if changes { within.min(order) } else { within })
        }
    };
    if graph.multiple(id, test).is_some() {
        contact.order = contact.order.max(1);
    }
    contact
}

/// Whether a node takes some values only, and jumps between them where tests change: a condition as a number.
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
