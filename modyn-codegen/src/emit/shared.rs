//! Functions in which equal limbs run through one function, with a table of constants for each limb.
//!
//! The graph in which limbs stand side by side falls into pieces: numbers, then limbs that need them,
//! then numbers that need those, and so on. Each piece becomes a graph of its own over what it is given,
//! a limb's with one lane in place of all; a limb's function is called once for each lane.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use modyn_runtime::OperationCount;

use super::function::{self, Parameter, function};
use super::quantities::Quantity;
use super::shape::Shape;
use super::{FloatType, Robot};
use crate::expr::{Graph, Id, Node};

/// What a piece is given from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Given {
    /// Constants, one a lane.
    Table(Id),
    /// A number of each lane.
    Own(Id),
    /// A number that is the same for all lanes.
    Common(Id),
}

/// Nodes that are computed by one function.
struct Piece {
    /// How many lanes they have; 1 for numbers.
    width: u8,
    /// How often it is called: the lanes that are used.
    calls: u8,
    given: Vec<Given>,
    /// The nodes that others need.
    outputs: Vec<Id>,
    graph: Graph,
}

impl Robot<'_> {
    /// A private function by pieces of `graph`, in which equal limbs stand side by side.
    pub(super) fn shared(
        &self,
        text: &mut String,
        quantity: &Quantity,
        parameters: &[Parameter],
        graph: &Graph,
    ) {
        let name = quantity.function.name();
        let pieces = pieces(graph);
        let mut body = String::new();
        for (p, piece) in pieces.iter().enumerate() {
            let named = format!("{name}_piece{p}");
            self.piece(text, &named, piece, graph);
            let value = |id, lane| value(graph, &pieces, parameters, id, lane);
            body += &piece.calls(&named, p, value);
        }
        let shape = &quantity.shape;
        let outputs = graph.outputs.iter().map(|&id| value(graph, &pieces, parameters, id, 0));
        let unpacked: String =
            parameters.iter().map(|p| format!("    {}\n", function::unpacked(p))).collect();
        let typed: Vec<String> = parameters.iter().map(|p| p.typed("T")).collect();
        let _ = writeln!(
            text,
            "fn {name}<T: __modyn::Scalar>({}) -> {} {{\n    let k = T::from_f64;\n{unpacked}{body}    {}\n}}\n",
            typed.join(", "),
            shape.type_of("T"),
            shape.value(&outputs.collect::<Vec<_>>())
        );
    }

    /// A piece's function, and its constants for each lane.
    fn piece(&self, text: &mut String, name: &str, piece: &Piece, graph: &Graph) {
        let (float, precision) = (self.options.float.name(), self.options.float);
        let [table, own, common] = piece.kinds();
        let mut takes = Vec::new();
        if !table.is_empty() {
            for lane in 0..piece.calls {
                let row = table.iter().map(|&id| {
                    let number = graph.value(graph.beside_at(id, lane));
                    figure(number.expect("a constant"), precision)
                });
                let (row, size) = (row.collect::<Vec<_>>().join(", "), table.len());
                let table = table_name(name, lane);
                let _ = writeln!(text, "static {table}: [{float}; {size}] = [{row}];\n");
            }
            takes.push(Parameter::constants("table", Shape::vector(table.len()), float));
        }
        for (name, given) in [("own", &own), ("common", &common)] {
            if !given.is_empty() {
                takes.push(Parameter::new(name, Shape::vector(given.len())));
            }
        }
        if piece.calls > 1 {
            *text += "#[inline(never)]\n";
        }
        *text += &function(name, &takes, &Shape::vector(piece.outputs.len()), &piece.graph);
    }
}

/// What the constants of a lane are called.
fn table_name(piece: &str, lane: u8) -> String {
    format!("{}_TABLE_{lane}", piece.to_uppercase())
}

/// The operations of a function by pieces, all their calls together.
pub(super) fn count(graph: &Graph) -> OperationCount {
    let counts = pieces(graph).into_iter();
    counts.flat_map(|piece| std::iter::repeat_n(piece.graph.count(), piece.calls.into())).sum()
}

/// The operations in the text of its pieces, each once.
pub(super) fn written(graph: &Graph) -> OperationCount {
    pieces(graph).iter().map(|piece| piece.graph.count()).sum()
}

/// The text of one lane of what a piece computed, or of what is known from the beginning.
fn value(graph: &Graph, pieces: &[Piece], parameters: &[Parameter], id: Id, lane: u8) -> String {
    match graph.node(id) {
        Node::Constant(bits) => function::constant(f64::from_bits(bits), 1),
        Node::Input(number) => function::input(parameters, number as usize).0,
        Node::Lane(lanes, lane) => value(graph, pieces, parameters, lanes, lane),
        Node::Beside(..) => value(graph, pieces, parameters, graph.beside_at(id, lane), 0),
        _ => {
            let found = pieces.iter().enumerate().find_map(|(p, piece)| {
                let place = piece.outputs.iter().position(|&output| output == id)?;
                Some((p, place, if piece.width == 1 { 0 } else { lane }))
            });
            let (p, place, lane) = found.expect("what others need is an output of a piece");
            format!("p{p}_{lane}_{place}")
        }
    }
}

/// A constant in a table, in the table's precision.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn figure(value: f64, float: FloatType) -> String {
    let single = value as f32;
    match float {
        FloatType::F64 if value.is_finite() => format!("{value:?}"),
        FloatType::F64 => format!("f64::from_bits({})", value.to_bits()),
        // A literal that is beyond the type would not compile.
        FloatType::F32 if single.is_finite() => format!("{single:?}"),
        FloatType::F32 => format!("f32::from_bits({})", single.to_bits()),
    }
}

/// Whether a node is taken from where it stands: inputs, constants, and numbers put side by side or
/// taken from there.
fn is_known(node: Node) -> bool {
    matches!(node, Node::Constant(_) | Node::Input(_) | Node::Beside(..) | Node::Lane(..))
}

/// The pieces of a graph, in an order in which each needs earlier ones only.
fn pieces(graph: &Graph) -> Vec<Piece> {
    let (nodes, live) = (graph.nodes(), graph.live());
    let mut members: BTreeMap<(usize, u8), Vec<Id>> = BTreeMap::new();
    let mut class = vec![None; nodes.len()];
    for (i, level) in levels(graph).into_iter().enumerate() {
        if live[i] && !is_known(nodes[i]) {
            let id = Id::try_from(i).expect("an index of a node");
            class[i] = Some((level, graph.width(id)));
            members.entry((level, graph.width(id))).or_default().push(id);
        }
    }
    // What is needed outside of its piece.
    let mut needed = vec![false; nodes.len()];
    for (i, node) in nodes.iter().enumerate().filter(|(i, _)| live[*i]) {
        for operand in node.operands().map(|id| id as usize) {
            needed[operand] |= class[operand].is_some() && class[operand] != class[i];
        }
    }
    graph.outputs.iter().for_each(|&id| needed[id as usize] = true);
    let lanes = |width: u8| {
        let lanes = nodes.iter().zip(&live).filter_map(|(node, live)| match *node {
            Node::Lane(of, lane) if *live && graph.width(of) == width => Some(lane + 1),
            _ => None,
        });
        lanes.max().unwrap_or(1)
    };
    let piece = |((_, width), ids): (&(usize, u8), &Vec<Id>)| {
        let outputs = ids.iter().copied().filter(|&id| needed[id as usize]).collect();
        Piece::new(graph, (*width, lanes(*width)), ids, outputs)
    };
    members.iter().map(piece).collect()
}

/// By node: how often it changes from numbers to lanes and back on the way there. Even for numbers, odd
/// for lanes.
fn levels(graph: &Graph) -> Vec<usize> {
    let mut levels: Vec<usize> = Vec::with_capacity(graph.nodes().len());
    for (i, node) in graph.nodes().iter().enumerate() {
        let wide = graph.width(i as Id) > 1;
        let below = node.operands().map(|operand| {
            let change = (graph.width(operand) > 1) != wide;
            levels[operand as usize] + usize::from(change)
        });
        levels.push(below.max().unwrap_or(0));
    }
    levels
}

impl Piece {
    fn new(graph: &Graph, (width, calls): (u8, u8), ids: &[Id], outputs: Vec<Id>) -> Self {
        let own: BTreeSet<Id> = ids.iter().copied().collect();
        let given = |id: Id| match graph.node(id) {
            _ if own.contains(&id) => None,
            Node::Constant(_) => None,
            _ if graph.width(id) == 1 => Some(Given::Common(id)),
            _ if graph.is_constant(id) => Some(Given::Table(id)),
            _ => Some(Given::Own(id)),
        };
        let operands = ids.iter().flat_map(|&id| graph.node(id).operands());
        let all: BTreeSet<Given> = operands.filter_map(given).collect();
        let all: Vec<Given> = all.into_iter().collect();
        let mut made = Graph::default();
        let mut ids_made: BTreeMap<Id, Id> = BTreeMap::new();
        for (place, given) in all.iter().enumerate() {
            let input = Node::Input(u32::try_from(place).expect("fewer than 2^32"));
            ids_made.insert(given.id(), made.make(input));
        }
        for &id in ids {
            for operand in graph.node(id).operands() {
                if let Node::Constant(_) = graph.node(operand) {
                    let constant = made.make(graph.node(operand));
                    ids_made.insert(operand, constant);
                }
            }
            let node = graph.node(id).map(|operand| ids_made[&operand]);
            let same = made.make(node);
            ids_made.insert(id, same);
        }
        made.outputs = outputs.iter().map(|id| ids_made[id]).collect();
        Self { width, calls, given: all, outputs, graph: made }
    }

    /// The calls of its function `name`, as piece `p`, for each lane; `value` is the text of a number.
    fn calls(&self, name: &str, p: usize, value: impl Fn(Id, u8) -> String) -> String {
        let [table, own, common] = self.kinds();
        let list = |given: &[Id], lane: u8| {
            let values: Vec<String> = given.iter().map(|&id| value(id, lane)).collect();
            format!("&[{}]", values.join(", "))
        };
        let mut text = String::new();
        if !common.is_empty() {
            let _ = writeln!(text, "    let common = {};", list(&common, 0));
        }
        for lane in 0..self.calls {
            let table = (!table.is_empty()).then(|| format!("&{}", table_name(name, lane)));
            let own = (!own.is_empty()).then(|| list(&own, lane));
            let common = (!common.is_empty()).then(|| "common".into());
            let arguments: Vec<String> = [table, own, common].into_iter().flatten().collect();
            let results = (0..self.outputs.len()).map(|place| format!("p{p}_{lane}_{place}"));
            let (arguments, results) =
                (arguments.join(", "), results.collect::<Vec<_>>().join(", "));
            let _ = writeln!(text, "    let [{results}] = {name}({arguments});");
        }
        text
    }

    /// What it is given: constants, numbers of each lane, numbers that are the same for all.
    fn kinds(&self) -> [Vec<Id>; 3] {
        [Given::Table, Given::Own, Given::Common].map(|kind| self.given(kind))
    }

    /// What it is given of one kind.
    fn given(&self, kind: fn(Id) -> Given) -> Vec<Id> {
        self.given
            .iter()
            .map(|given| given.id())
            .filter(|&id| self.given.contains(&kind(id)))
            .collect()
    }
}

impl Given {
    fn id(self) -> Id {
        let (Self::Table(id) | Self::Own(id) | Self::Common(id)) = self;
        id
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_literals_of_their_type() {
        assert_eq!(figure(0.1, FloatType::F64), "0.1");
        assert_eq!(figure(0.1, FloatType::F32), "0.1");
        assert_eq!(figure(-1e50, FloatType::F64), "-1e50");
        assert_eq!(figure(-1e50, FloatType::F32), "f32::from_bits(4286578688)");
        assert_eq!(figure(f64::INFINITY, FloatType::F64), "f64::from_bits(9218868437227405312)");
    }
}
