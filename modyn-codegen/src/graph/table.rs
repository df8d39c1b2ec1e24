//! The lookup of nodes in a graph: a hash table with open addressing.
//!
//! The compiler runs unoptimised in macros and build scripts. There the standard library's hash
//! table takes several times as long as this one without generics, and dominated the time of
//! tracing.

use super::node::{Id, Node};

/// The nodes of a graph by their content. The graph stores the nodes themselves.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// A power of two of slots, at most half of them full: the upper half of a node's hash, then
    /// its index plus one.
    places: Vec<u64>,
    full: usize,
}

const INDEX: u64 = u32::MAX as u64;

impl Table {
    /// Returns the index of `node`, if it is among `nodes`, all of which were inserted.
    pub fn find(&self, node: Node, nodes: &[Node]) -> Option<Id> {
        if self.places.is_empty() {
            return None;
        }
        self.search(node, hash(node), nodes).ok()
    }

    /// Returns the index of `node`, if it is among `nodes`, all of which were inserted. Else
    /// inserts it as the next one.
    pub fn find_or_insert(&mut self, node: Node, nodes: &[Node]) -> Option<Id> {
        if 2 * (self.full + 1) > self.places.len() {
            self.grow(nodes);
        }
        let hash = hash(node);
        match self.search(node, hash, nodes) {
            Ok(id) => Some(id),
            Err(free) => {
                self.places[free] = (hash & !INDEX) | (nodes.len() as u64 + 1);
                self.full = nodes.len() + 1;
                None
            }
        }
    }

    /// Returns the index of `node`, or else the place for it.
    fn search(&self, node: Node, hash: u64, nodes: &[Node]) -> Result<Id, usize> {
        let mask = self.places.len() - 1;
        let mut at = hash as usize & mask;
        loop {
            let place = self.places[at];
            if place == 0 {
                return Err(at);
            }
            if (place ^ hash) & !INDEX == 0 {
                let id = (place & INDEX) as usize - 1;
                if nodes[id] == node {
                    return Ok(id as Id);
                }
            }
            at = (at + 1) & mask;
        }
    }

    /// Makes room for as many nodes again, and for some at the beginning: most graphs have
    /// thousands.
    fn grow(&mut self, nodes: &[Node]) {
        self.places = vec![0; (4 * (self.full + 1)).next_power_of_two().max(1024)];
        let mask = self.places.len() - 1;
        let mut id = 0;
        while id < nodes.len() {
            let hash = hash(nodes[id]);
            let mut at = hash as usize & mask;
            while self.places[at] != 0 {
                at = (at + 1) & mask;
            }
            self.places[at] = (hash & !INDEX) | (id as u64 + 1);
            id += 1;
        }
    }
}

/// Returns a hash whose lower and upper bits are well distributed.
pub fn hash(node: Node) -> u64 {
    let (kind, a, b) = match node {
        Node::Constant(bits) => (1, bits, 0),
        Node::Input(number) => (2, number as u64, 0),
        Node::Neg(a) => (3, a as u64, 0),
        Node::Add(a, b) => (4, a as u64, b as u64),
        Node::Sub(a, b) => (5, a as u64, b as u64),
        Node::Mul(a, b) => (6, a as u64, b as u64),
        Node::Recip(a) => (7, a as u64, 0),
        Node::Sin(a) => (8, a as u64, 0),
        Node::Cos(a) => (9, a as u64, 0),
        Node::Atan2(a, b) => (10, a as u64, b as u64),
        Node::Sqrt(a) => (11, a as u64, 0),
        Node::Ln(a) => (12, a as u64, 0),
        Node::Abs(a) => (13, a as u64, 0),
        Node::Max(a, b) => (14, a as u64, b as u64),
        Node::Select(a, b, c) => (15, a as u64 | (b as u64) << 32, c as u64),
        Node::Pack(a, b, width) => (16, a as u64 | (b as u64) << 32, width as u64),
        Node::ExtractLane(a, lane) => (17, a as u64, lane as u64),
    };
    let first_round =
        (a ^ (b << 29) ^ (b >> 35) ^ (kind << 58)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (first_round ^ (first_round >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    mixed ^ (mixed >> 32)
}
