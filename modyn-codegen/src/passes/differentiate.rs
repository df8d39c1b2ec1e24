//! Differentiation of graphs: Jacobian times vector (forward mode), and vector times Jacobian
//! (reverse mode).
//!
//! Both modes use one table of partial derivatives. A selection, an absolute value or a maximum has
//! the derivative of the branch that is taken. Graphs may have packs of lanes: a scalar operand of
//! an operation on packs is in all lanes, so its gradient is a sum over lanes.
//!
//! Rotations about an axis are most of the operations of a robot. With x' = c x - s y and y' = s
//! x + c y, the derivatives of x' and y' by the angle are -y' and x', which the graph has. The
//! chain rule by way of the sine and the cosine would take two products for each of them.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::graph::{Graph, Id, Node};

/// The partial derivative of a node with respect to an operand: a linear map of numbers.
#[derive(Clone, Copy)]
pub(super) enum Partial {
    /// Multiplication by 1.
    Identity,
    /// Multiplication by -1.
    Negation,
    /// Multiplication by a node.
    Factor(Id),
    /// Multiplication by 1 if this node is at least 0, else by 0.
    IfNonnegative(Id),
    /// Multiplication by 0 if this node is at least 0, else by 1.
    IfNegative(Id),
    /// Multiplication by 1 if this node is at least 0, else by -1.
    Sign(Id),
}

impl Partial {
    /// Returns the image of `x`.
    pub(super) fn apply(self, graph: &mut Graph, x: Id) -> Id {
        match self {
            Self::Identity => x,
            Self::Negation => graph.make(Node::Neg(x)),
            Self::Factor(factor) => graph.make(Node::Mul(factor, x)),
            Self::IfNonnegative(sign) => {
                let zero = graph.constant(0.0);
                graph.make(Node::Select(sign, x, zero))
            }
            Self::IfNegative(sign) => {
                let zero = graph.constant(0.0);
                graph.make(Node::Select(sign, zero, x))
            }
            Self::Sign(sign) => {
                let negative = graph.make(Node::Neg(x));
                graph.make(Node::Select(sign, x, negative))
            }
        }
    }
}

/// Returns the factors of the product `id`, the sine or cosine of an angle first; `None` for any
/// other node.
fn trigonometric_product(graph: &Graph, id: Id) -> Option<(Id, Id)> {
    let Node::Mul(a, b) = graph.node(id) else { return None };
    let is_trigonometric = |id| matches!(graph.node(id), Node::Sin(_) | Node::Cos(_));
    match (is_trigonometric(a), is_trigonometric(b)) {
        (true, false) => Some((a, b)),
        (false, true) => Some((b, a)),
        _ => None,
    }
}

/// Returns the partial derivatives of a component of a rotated vector with respect to the
/// components before and to the angle. `None` for other nodes, and if the graph does not have the
/// other component.
fn rotation(graph: &mut Graph, id: Id) -> Option<Vec<(Id, Partial)>> {
    let (first, second, subtracts) = match graph.node(id) {
        Node::Add(a, b) => (a, b, false),
        Node::Sub(a, b) => (a, b, true),
        _ => return None,
    };
    let (f, x) = trigonometric_product(graph, first)?;
    let (g, y) = trigonometric_product(graph, second)?;
    // The derivatives of f and g by the angle, without the sign of the sine's.
    let (by_f, by_g, angle) = match (graph.node(f), graph.node(g)) {
        (Node::Cos(a), Node::Sin(b)) | (Node::Sin(a), Node::Cos(b)) if a == b => (g, f, a),
        _ => return None,
    };
    let nodes = graph.nodes().len();
    let a = graph.make(Node::Mul(by_f, x));
    let b = graph.make(Node::Mul(by_g, y));
    // Of f x + g y and f x - g y, the derivative is b - a and -(a + b) if f is the cosine, else a -
    // b and a + b.
    let of_cosine = matches!(graph.node(f), Node::Cos(_));
    let derivative = match (of_cosine, subtracts) {
        (_, true) => graph.make(Node::Add(a, b)),
        (true, false) => graph.make(Node::Sub(b, a)),
        (false, false) => graph.make(Node::Sub(a, b)),
    };
    if graph.nodes().len() > nodes {
        return None;
    }
    let derivative =
        if of_cosine && subtracts { graph.make(Node::Neg(derivative)) } else { derivative };
    let by_second = if subtracts { graph.make(Node::Neg(g)) } else { g };
    Some(vec![
        (x, Partial::Factor(f)),
        (y, Partial::Factor(by_second)),
        (angle, Partial::Factor(derivative)),
    ])
}

/// Returns the operands of a node, or of its operands, with the partial derivatives with respect to
/// them.
pub(super) fn partials(graph: &mut Graph, id: Id) -> Vec<(Id, Partial)> {
    if let Some(rotation) = rotation(graph, id) {
        return rotation;
    }
    let node = graph.node(id);
    let mut times = |a, b| graph.make(Node::Mul(a, b));
    match node {
        Node::Constant(_) | Node::Input(_) => Vec::new(),
        Node::Neg(a) => vec![(a, Partial::Negation)],
        Node::Add(a, b) => vec![(a, Partial::Identity), (b, Partial::Identity)],
        Node::Sub(a, b) => vec![(a, Partial::Identity), (b, Partial::Negation)],
        Node::Mul(a, b) => vec![(a, Partial::Factor(b)), (b, Partial::Factor(a))],
        Node::Recip(a) => {
            let square = times(id, id);
            let factor = graph.make(Node::Neg(square));
            vec![(a, Partial::Factor(factor))]
        }
        Node::Sin(a) => {
            let cosine = graph.make(Node::Cos(a));
            vec![(a, Partial::Factor(cosine))]
        }
        Node::Cos(a) => {
            let sine = graph.make(Node::Sin(a));
            let factor = graph.make(Node::Neg(sine));
            vec![(a, Partial::Factor(factor))]
        }
        Node::Atan2(y, x) => {
            let xx = times(x, x);
            let yy = times(y, y);
            let square = graph.make(Node::Add(xx, yy));
            let inverse = graph.make(Node::Recip(square));
            let by_y = graph.make(Node::Mul(x, inverse));
            let quotient = graph.make(Node::Mul(y, inverse));
            let by_x = graph.make(Node::Neg(quotient));
            vec![(y, Partial::Factor(by_y)), (x, Partial::Factor(by_x))]
        }
        Node::Sqrt(a) => {
            let half = graph.constant(0.5);
            let inverse = graph.make(Node::Recip(id));
            let factor = graph.make(Node::Mul(half, inverse));
            vec![(a, Partial::Factor(factor))]
        }
        Node::Ln(a) => {
            let factor = graph.make(Node::Recip(a));
            vec![(a, Partial::Factor(factor))]
        }
        Node::Abs(a) => vec![(a, Partial::Sign(a))],
        Node::Max(a, b) => {
            let sign = graph.make(Node::Sub(a, b));
            vec![(a, Partial::IfNonnegative(sign)), (b, Partial::IfNegative(sign))]
        }
        Node::Select(sign, a, b) => {
            vec![(a, Partial::IfNonnegative(sign)), (b, Partial::IfNegative(sign))]
        }
        Node::Pack(..) | Node::ExtractLane(..) => {
            unreachable!("lanes are moved, which is no operation")
        }
    }
}

/// Adds `change` to `sum`, which starts at zero.
fn add(graph: &mut Graph, sum: &mut Option<Id>, change: Id) {
    *sum = Some(match *sum {
        None => change,
        Some(sum) => graph.make(Node::Add(sum, change)),
    });
}

/// Returns the graph of the changes of the outputs of `graph` under changes of the inputs `wrt`.
///
/// The changes are further inputs, after the `inputs` inputs of `graph`. The graph has the partial
/// derivatives of nodes that `wrt` reach, so inputs on which the outputs depend linearly give a
/// linear graph.
#[must_use]
pub fn jvp(graph: &Graph, inputs: usize, wrt: Range<usize>) -> Graph {
    let live = graph.live();
    let nodes = graph.nodes().len();
    let mut result = graph.clone();
    let mut changes: Vec<Option<Id>> = vec![None; nodes];
    for at in (0..nodes).filter(|&at| live[at]) {
        let id = Id::try_from(at).expect("a graph's node");
        if let Node::Input(number) = graph.node(id) {
            if wrt.contains(&(number as usize)) {
                let change = inputs + number as usize - wrt.start;
                changes[at] = Some(result.input(change));
            }
            continue;
        }
        if graph.node(id).operands().all(|operand| changes[operand as usize].is_none()) {
            continue;
        }
        let mut sum = None;
        match graph.node(id) {
            Node::Pack(a, b, _) => {
                let zero = result.constant(0.0);
                let halves = [a, b].map(|half| (half, changes[half as usize].unwrap_or(zero)));
                let halves_of_lanes = (0..graph.width(id)).map(|lane| {
                    let (half, lane) = half_of(graph, halves, lane, graph.width(id));
                    result.make(Node::ExtractLane(half, lane))
                });
                let lanes: Vec<Id> = halves_of_lanes.collect();
                changes[at] = Some(result.pack(&lanes));
                continue;
            }
            Node::ExtractLane(pack, lane) => {
                let change = changes[pack as usize];
                changes[at] = change.map(|x| result.make(Node::ExtractLane(x, lane)));
                continue;
            }
            _ => {}
        }
        for (operand, partial) in partials(&mut result, id) {
            if let Some(change) = changes[operand as usize] {
                let change = partial.apply(&mut result, change);
                add(&mut result, &mut sum, change);
            }
        }
        changes[at] = sum;
    }
    let zero = result.constant(0.0);
    let outputs = graph.outputs.iter().map(|&id| changes[id as usize].unwrap_or(zero));
    result.outputs = outputs.collect();
    result
}

/// Returns the change of the half of a pack that has this lane, and the lane there. `halves` are
/// the halves with their changes.
fn half_of(graph: &Graph, halves: [(Id, Id); 2], lane: u8, width: u8) -> (Id, u8) {
    let (half, change) = halves[usize::from(lane / (width / 2))];
    // A scalar half is in all of its lanes.
    (change, if graph.width(half) == 1 { 0 } else { lane % (width / 2) })
}

/// The gradient of a node, as far as its users have been visited.
#[derive(Clone, Default)]
struct Gradient {
    /// The part with the lanes of the node.
    sum: Option<Id>,
    /// The parts of a scalar in users on packs, by the number of their lanes. Each is to be summed
    /// over its lanes.
    over_lanes: BTreeMap<u8, Id>,
    /// The parts of single lanes of a pack.
    lanes: Vec<Option<Id>>,
}

impl Gradient {
    /// Adds the part of one lane of a node with `width` lanes.
    fn add_to_lane(&mut self, graph: &mut Graph, lane: u8, width: u8, change: Id) {
        if width == 1 {
            return add(graph, &mut self.sum, change);
        }
        self.lanes.resize(width.into(), None);
        add(graph, &mut self.lanes[usize::from(lane)], change);
    }

    /// Returns the gradient; `None` if the node has no effect.
    fn total(&self, graph: &mut Graph) -> Option<Id> {
        let mut sum = self.sum;
        if !self.lanes.is_empty() {
            let zero = graph.constant(0.0);
            let lanes: Vec<Id> = self.lanes.iter().map(|lane| lane.unwrap_or(zero)).collect();
            let pack = graph.pack(&lanes);
            add(graph, &mut sum, pack);
        }
        for (&width, &wide) in &self.over_lanes {
            let extracted = (0..width).map(|lane| graph.make(Node::ExtractLane(wide, lane)));
            let lanes: Vec<Id> = extracted.collect();
            let over_lanes = graph.pairwise_sum(&lanes);
            add(graph, &mut sum, over_lanes);
        }
        sum
    }
}

/// Returns the graph of the gradient of w^T f with respect to the inputs `wrt`; f are the outputs
/// of `graph`, scalars.
///
/// The weights w are further inputs, after the `inputs` inputs of `graph`.
#[must_use]
pub fn vjp(graph: &Graph, inputs: usize, wrt: Range<usize>) -> Graph {
    let nodes = graph.nodes().len();
    let mut reached = vec![false; nodes];
    for (at, node) in graph.nodes().iter().enumerate() {
        reached[at] = match node {
            Node::Input(number) => wrt.contains(&(*number as usize)),
            node => node.operands().any(|operand| reached[operand as usize]),
        };
    }
    let mut result = graph.clone();
    let mut gradients: Vec<Gradient> = vec![Gradient::default(); nodes];
    for (k, &output) in graph.outputs.iter().enumerate() {
        if reached[output as usize] {
            let weight = result.input(inputs + k);
            add(&mut result, &mut gradients[output as usize].sum, weight);
        }
    }
    let mut totals: Vec<Option<Id>> = vec![None; nodes];
    for at in (0..nodes).rev() {
        let Some(gradient) = gradients[at].total(&mut result) else { continue };
        totals[at] = Some(gradient);
        let id = Id::try_from(at).expect("a graph's node");
        let width = graph.width(id);
        match graph.node(id) {
            Node::Pack(a, b, _) => {
                for lane in 0..width {
                    let half = if lane < width / 2 { a } else { b };
                    if reached[half as usize] {
                        let change = result.make(Node::ExtractLane(gradient, lane));
                        let place = lane % (width / 2);
                        let half_width = graph.width(half);
                        gradients[half as usize].add_to_lane(
                            &mut result,
                            place,
                            half_width,
                            change,
                        );
                    }
                }
                continue;
            }
            Node::ExtractLane(pack, lane) => {
                let width = graph.width(pack);
                gradients[pack as usize].add_to_lane(&mut result, lane, width, gradient);
                continue;
            }
            _ => {}
        }
        for (operand, partial) in partials(&mut result, id) {
            if !reached[operand as usize] {
                continue;
            }
            let change = partial.apply(&mut result, gradient);
            let gradient = &mut gradients[operand as usize];
            if graph.width(operand) == width {
                add(&mut result, &mut gradient.sum, change);
            } else if result.width(change) > 1 {
                let sum = match gradient.over_lanes.get(&width) {
                    Some(&sum) => result.make(Node::Add(sum, change)),
                    None => change,
                };
                gradient.over_lanes.insert(width, sum);
            } else {
                let count = result.constant(f64::from(width));
                let change = result.make(Node::Mul(count, change));
                add(&mut result, &mut gradient.sum, change);
            }
        }
    }
    let zero = result.constant(0.0);
    let gradient = |number: usize| {
        let id = graph.find(Node::input(number));
        id.and_then(|id| totals[id as usize]).unwrap_or(zero)
    };
    result.outputs = wrt.map(gradient).collect();
    result
}
