//! The arena of nodes, and the rewrites that are made while it grows.

use std::ops::Range;

use super::dense::DenseParts;
use super::limit;
use super::node::{Id, Node};
use super::table::Table;

/// Expressions over numbered inputs, with some of them as outputs.
///
/// A node is a scalar or a pack of lanes. An operation acts on each lane. A scalar operand of an
/// operation on packs is broadcast to all lanes.
#[derive(Clone, Debug)]
pub struct Graph {
    nodes: Vec<Node>,
    /// The number of lanes of each node; 1 for a scalar.
    widths: Vec<u8>,
    table: Table,
    /// Whether any node has several lanes.
    has_lanes: bool,
    /// The largest number of nodes.
    limit: usize,
    /// The nodes of the results.
    pub outputs: Vec<Id>,
    /// The dense parts that are left to loops.
    pub dense: DenseParts,
}

impl Default for Graph {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            widths: Vec::new(),
            table: Table::default(),
            has_lanes: false,
            limit: limit::of_new_graph(),
            outputs: Vec::new(),
            dense: DenseParts::default(),
        }
    }
}

impl Graph {
    /// Returns a graph without operations: all of its outputs, of this number, are zero.
    pub(super) fn of_zeros(outputs: usize) -> Self {
        let mut graph = Self::default();
        let zero = graph.insert(Node::Constant(0.0_f64.to_bits()));
        graph.outputs = vec![zero; outputs];
        graph
    }

    /// Returns all nodes, operands before users.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Returns the node `id`.
    #[must_use]
    pub fn node(&self, id: Id) -> Node {
        self.nodes[id as usize]
    }

    /// Returns the number of lanes of a node; 1 for a scalar.
    #[must_use]
    pub fn width(&self, id: Id) -> u8 {
        self.widths[id as usize]
    }

    /// Returns, for each node, whether the outputs need it.
    #[must_use]
    pub fn live(&self) -> Vec<bool> {
        self.live_from(&self.outputs)
    }

    /// Returns, for each node, whether one of these nodes depends on it.
    pub(crate) fn live_from(&self, outputs: &[Id]) -> Vec<bool> {
        let mut live = vec![false; self.nodes.len()];
        for &output in outputs {
            live[output as usize] = true;
        }
        for (i, node) in self.nodes.iter().enumerate().rev() {
            if live[i] {
                node.operands().for_each(|operand| live[operand as usize] = true);
            }
        }
        live
    }

    /// Returns, for each node, the number of uses by live nodes and outputs.
    #[must_use]
    pub fn uses(&self) -> Vec<u32> {
        let live = self.live();
        let mut uses = vec![0; self.nodes.len()];
        for (node, live) in self.nodes.iter().zip(live) {
            if live {
                node.operands().for_each(|operand| uses[operand as usize] += 1);
            }
        }
        self.outputs.iter().for_each(|&output| uses[output as usize] += 1);
        uses
    }

    /// Returns the value of a constant node; `None` for other nodes.
    #[must_use]
    pub fn value(&self, id: Id) -> Option<f64> {
        match self.node(id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Returns the node's index, if the graph has it.
    #[must_use]
    pub fn find(&self, node: Node) -> Option<Id> {
        self.table.find(node, &self.nodes)
    }

    fn contains(&self, node: Node) -> bool {
        self.find(node).is_some()
    }

    fn insert(&mut self, mut node: Node) -> Id {
        if self.nodes.len() >= self.limit {
            node = match self.beyond_limit(node) {
                Ok(known) => return known,
                Err(shared) => shared,
            };
        }
        if let Some(id) = self.table.find_or_insert(node, &self.nodes) {
            return id;
        }
        let width = match node {
            Node::Pack(_, _, width) => width,
            Node::ExtractLane(..) => 1,
            _ if self.has_lanes => self.widest_operand(node),
            _ => 1,
        };
        self.has_lanes |= width > 1;
        self.nodes.push(node);
        self.widths.push(width);
        (self.nodes.len() - 1) as Id
    }

    /// Returns a node of the same width in place of an operation beyond the limit: an operand, or
    /// the lanes of one pack of zeros for each width. The error is a node that the graph may have
    /// beyond the limit: a constant, an input or such a pack.
    #[cold]
    fn beyond_limit(&mut self, node: Node) -> Result<Id, Node> {
        assert!(self.nodes.len() < limit::UNLIMITED, "a graph has fewer than 2^32 nodes");
        if matches!(node, Node::Constant(_) | Node::Input(_)) {
            return Err(node);
        }
        limit::exceed();
        let zero = Node::Constant(0.0_f64.to_bits());
        match node {
            Node::ExtractLane(..) => Ok(self.insert(zero)),
            Node::Pack(_, _, width) => {
                let zero = self.insert(zero);
                Err(Node::Pack(zero, zero, width))
            }
            _ => node.operands().max_by_key(|&operand| self.width(operand)).ok_or(node),
        }
    }

    /// Returns the largest number of lanes of an operand; 1 without operands.
    fn widest_operand(&self, node: Node) -> u8 {
        node.operands().map(|operand| self.width(operand)).max().unwrap_or(1)
    }

    /// Returns the index of `node`, whose operands are nodes of this graph; creates it unless the
    /// graph has an equal node.
    pub fn make(&mut self, node: Node) -> Id {
        // Beyond the limit, no rewrite looks for other nodes: equations may have a hundred times as
        // many operations as the limit.
        if self.nodes.len() >= self.limit
            && let Ok(known) = self.beyond_limit(node)
        {
            return known;
        }
        if let Some(folded) = self.fold_lanes(node) {
            return folded;
        }
        match node {
            Node::Constant(bits) => self.constant(f64::from_bits(bits)),
            Node::Input(_) => self.insert(node),
            Node::Neg(a) => self.neg(a),
            Node::Add(a, b) => self.add(a, b),
            Node::Sub(a, b) => self.sub(a, b),
            Node::Mul(a, b) => self.mul(a, b),
            Node::Recip(a) => self.recip(a),
            Node::Sin(a) => self.sin(a),
            Node::Cos(a) => self.cos(a),
            Node::Atan2(a, b) => self.atan2(a, b),
            Node::Sqrt(a) => self.fold(a, libm::sqrt, Node::Sqrt),
            Node::Ln(a) => self.fold(a, libm::log, Node::Ln),
            Node::Abs(a) => self.fold(a, f64::abs, Node::Abs),
            Node::Max(a, b) => self.max(a, b),
            Node::Select(a, b, c) => self.select(a, b, c),
            Node::Pack(a, b, width) => self.pack_halves(a, b, width),
            Node::ExtractLane(a, lane) => self.extract_lane(a, lane),
        }
    }

    /// Returns an operation on constants, folded lane by lane, if some operands are packs of
    /// constants.
    fn fold_lanes(&mut self, node: Node) -> Option<Id> {
        if !self.has_lanes
            || matches!(
                node,
                Node::Constant(_) | Node::Input(_) | Node::Pack(..) | Node::ExtractLane(..)
            )
        {
            return None;
        }
        let width = self.widest_operand(node);
        if width == 1 || !node.operands().all(|a| self.is_constant(a)) {
            return None;
        }
        let lanes: Vec<Id> = (0..width)
            .map(|lane| {
                let mut operands =
                    node.operands().map(|a| self.extract_lane(a, lane)).collect::<Vec<_>>();
                operands.reverse();
                let remaining = std::cell::RefCell::new(operands);
                self.make(node.map(|_| remaining.borrow_mut().pop().expect("one an operand")))
            })
            .collect();
        Some(self.pack_all(&lanes))
    }

    /// Returns whether the node is a constant or a pack of constants.
    #[must_use]
    pub fn is_constant(&self, id: Id) -> bool {
        match self.node(id) {
            Node::Constant(_) => true,
            Node::Pack(a, b, _) => self.is_constant(a) && self.is_constant(b),
            _ => false,
        }
    }

    /// Returns the node that was packed into a lane; the node itself if it is no pack.
    #[must_use]
    pub fn packed_at(&self, id: Id, lane: u8) -> Id {
        match self.node(id) {
            Node::Pack(first, _, width) if lane < width / 2 => self.packed_at(first, lane),
            Node::Pack(_, second, width) => self.packed_at(second, lane - width / 2),
            _ => id,
        }
    }

    /// Returns the pack of these scalars, whose number is a power of two. All lanes of a pack, in
    /// their order, are that pack.
    pub fn pack(&mut self, numbers: &[Id]) -> Id {
        if let &[first, ..] = numbers
            && let Node::ExtractLane(whole, _) = self.node(first)
            && usize::from(self.width(whole)) == numbers.len()
            && (0..).zip(numbers).all(|(k, &lane)| self.node(lane) == Node::ExtractLane(whole, k))
        {
            return whole;
        }
        self.pack_all(numbers)
    }

    /// Returns the pack of these nodes, whose number is a power of two.
    fn pack_all(&mut self, numbers: &[Id]) -> Id {
        let [number] = numbers else {
            let (a, b) = numbers.split_at(numbers.len() / 2);
            let a = self.pack_all(a);
            let b = self.pack_all(b);
            return self.pack_halves(a, b, u8::try_from(numbers.len()).expect("few lanes"));
        };
        *number
    }

    fn pack_halves(&mut self, a: Id, b: Id, width: u8) -> Id {
        if a == b && self.width(a) == 1 { a } else { self.insert(Node::Pack(a, b, width)) }
    }

    fn extract_lane(&mut self, a: Id, lane: u8) -> Id {
        match self.node(a) {
            _ if self.width(a) == 1 => a,
            Node::Pack(..) => self.packed_at(a, lane),
            Node::Neg(inner) => {
                let inner = self.extract_lane(inner, lane);
                self.neg(inner)
            }
            _ => self.insert(Node::ExtractLane(a, lane)),
        }
    }

    /// Returns the graph with zeros for the outputs that are zero in another one.
    #[must_use]
    pub fn with_zeros_of(mut self, other: &Self) -> Self {
        let zero = self.constant(0.0);
        for (output, &id) in self.outputs.iter_mut().zip(&other.outputs) {
            if other.value(id) == Some(0.0) {
                *output = zero;
            }
        }
        self
    }

    /// Returns the node of a constant; the two zeros are the same node.
    pub fn constant(&mut self, value: f64) -> Id {
        self.insert(Node::Constant((value + 0.0).to_bits()))
    }

    /// Returns the node of the input with this number.
    pub fn input(&mut self, number: usize) -> Id {
        self.insert(Node::input(number))
    }

    /// Returns the nodes of the inputs with these numbers.
    pub fn inputs(&mut self, numbers: Range<usize>) -> Vec<Id> {
        numbers.map(|number| self.input(number)).collect()
    }

    fn fold(&mut self, a: Id, f: impl Fn(f64) -> f64, node: impl Fn(Id) -> Node) -> Id {
        match self.value(a) {
            Some(a) => self.constant(f(a)),
            None => self.insert(node(a)),
        }
    }

    fn neg(&mut self, a: Id) -> Id {
        match self.node(a) {
            Node::Constant(bits) => self.constant(-f64::from_bits(bits)),
            Node::Neg(inner) => inner,
            Node::Sub(x, y) if self.contains(Node::Sub(y, x)) => self.insert(Node::Sub(y, x)),
            _ => self.insert(Node::Neg(a)),
        }
    }

    fn add(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x + y),
            (Some(0.0), _) => return b,
            (_, Some(0.0)) => return a,
            (Some(x), _) if x < 0.0 => {
                let x = self.constant(-x);
                return self.sub(b, x);
            }
            (_, Some(y)) if y < 0.0 => {
                let y = self.constant(-y);
                return self.sub(a, y);
            }
            _ => {}
        }
        match (self.node(a), self.node(b)) {
            (_, Node::Neg(inner)) => self.sub(a, inner),
            (Node::Neg(inner), _) => self.sub(b, inner),
            // (x - b) + b and a + (x - a)
            (Node::Sub(x, y), _) if y == b => x,
            (_, Node::Sub(x, y)) if y == a => x,
            _ if a == b => {
                let two = self.constant(2.0);
                self.mul(two, a)
            }
            _ => self.insert(Node::Add(a.min(b), a.max(b))),
        }
    }

    fn sub(&mut self, a: Id, b: Id) -> Id {
        if a == b {
            return self.constant(0.0);
        }
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x - y),
            (_, Some(0.0)) => return a,
            (Some(0.0), _) => return self.neg(b),
            (_, Some(y)) if y < 0.0 => {
                let y = self.constant(-y);
                return self.add(a, y);
            }
            _ => {}
        }
        match (self.node(a), self.node(b)) {
            (_, Node::Neg(inner)) => self.add(a, inner),
            (Node::Neg(inner), _) => {
                let sum = self.add(inner, b);
                self.neg(sum)
            }
            // a - (a - y)
            (_, Node::Sub(x, y)) if x == a => y,
            // 2 b - b
            (Node::Mul(two, x), _) if x == b && self.value(two) == Some(2.0) => b,
            _ if self.contains(Node::Sub(b, a)) => {
                let difference = self.insert(Node::Sub(b, a));
                self.insert(Node::Neg(difference))
            }
            _ => self.insert(Node::Sub(a, b)),
        }
    }

    fn mul(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = if self.value(b).is_some() { (b, a) } else { (a, b) };
        if let Some(x) = self.value(a) {
            if let Some(y) = self.value(b) {
                return self.constant(x * y);
            }
            if x == 0.0 {
                return a;
            }
            if x == 1.0 {
                return b;
            }
            if x < 0.0 {
                let x = self.constant(-x);
                let product = self.mul(x, b);
                return self.neg(product);
            }
            match self.node(b) {
                Node::Neg(inner) => {
                    let product = self.mul(a, inner);
                    return self.neg(product);
                }
                Node::Mul(c, y) if self.value(c).is_some() => {
                    let c = self.mul(a, c);
                    return self.mul(c, y);
                }
                _ => return self.insert(Node::Mul(a, b)),
            }
        }
        match (self.node(a), self.node(b)) {
            (Node::Neg(a), Node::Neg(b)) => self.mul(a, b),
            (Node::Neg(a), _) => {
                let product = self.mul(a, b);
                self.neg(product)
            }
            (_, Node::Neg(b)) => {
                let product = self.mul(a, b);
                self.neg(product)
            }
            _ => self.insert(Node::Mul(a.min(b), a.max(b))),
        }
    }

    fn recip(&mut self, a: Id) -> Id {
        match self.node(a) {
            Node::Neg(inner) => {
                let inner = self.recip(inner);
                self.neg(inner)
            }
            _ => self.fold(a, |x| 1.0 / x, Node::Recip),
        }
    }

    fn sin(&mut self, a: Id) -> Id {
        match self.node(a) {
            Node::Neg(inner) => {
                let inner = self.sin(inner);
                self.neg(inner)
            }
            _ => self.fold(a, libm::sin, Node::Sin),
        }
    }

    fn cos(&mut self, a: Id) -> Id {
        match self.node(a) {
            Node::Neg(inner) => self.cos(inner),
            _ => self.fold(a, libm::cos, Node::Cos),
        }
    }

    fn atan2(&mut self, y: Id, x: Id) -> Id {
        match (self.value(y), self.value(x)) {
            (Some(y), Some(x)) => self.constant(libm::atan2(y, x)),
            _ => self.insert(Node::Atan2(y, x)),
        }
    }

    fn max(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(x.max(y)),
            _ if a == b => a,
            _ => self.insert(Node::Max(a, b)),
        }
    }

    fn select(&mut self, condition: Id, then: Id, otherwise: Id) -> Id {
        match self.value(condition) {
            _ if then == otherwise => then,
            Some(x) if x >= 0.0 => then,
            Some(_) => otherwise,
            None => self.insert(Node::Select(condition, then, otherwise)),
        }
    }
}
