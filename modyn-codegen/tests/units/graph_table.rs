//! The table that finds equal nodes.

use modyn_codegen::graph::{Id, Node};
use modyn_codegen::internals::{Table, hash};

/// Nodes of all kinds, on small and large operands, are found at their index and nowhere else.
#[test]
fn every_node_is_found_by_itself_alone() {
    let mut nodes = Vec::new();
    for a in [0, 1, 2, 3, 1 << 20, u32::MAX - 1] {
        nodes.extend([Node::Constant(a as u64), Node::Constant((a as u64) << 32), Node::Input(a)]);
        nodes.extend([Node::Neg(a), Node::Recip(a), Node::Sin(a), Node::Cos(a), Node::Sqrt(a)]);
        nodes.extend([Node::Ln(a), Node::Abs(a), Node::ExtractLane(a, 0), Node::ExtractLane(a, 3)]);
        for b in [0, 5, 1 << 29, u32::MAX] {
            nodes.extend([Node::Add(a, b), Node::Sub(a, b), Node::Mul(a, b), Node::Max(a, b)]);
            nodes.extend([Node::Atan2(a, b), Node::Pack(a, b, 2), Node::Pack(a, b, 4)]);
            nodes.extend([Node::Select(a, b, 0), Node::Select(a, b, 7)]);
        }
    }
    // The constant with bits 0 was listed twice.
    nodes.dedup();
    let mut table = Table::default();
    for known in 0..nodes.len() {
        assert_eq!(table.find(nodes[known], &nodes[..known]), None, "{:?}", nodes[known]);
        assert_eq!(table.find_or_insert(nodes[known], &nodes[..known]), None);
        assert_eq!(table.find_or_insert(nodes[known], &nodes[..=known]), Some(known as Id));
    }
    for (id, &node) in nodes.iter().enumerate() {
        assert_eq!(table.find(node, &nodes), Some(id as Id), "{node:?}");
    }
    assert_eq!(table.find(Node::Neg(77), &nodes), None);
}

/// Consecutive operands, as in a graph, are spread over the table.
#[test]
fn neighbours_are_spread() {
    let count = 1 << 12;
    let mut places = std::collections::BTreeSet::new();
    for a in 0..64 {
        places.extend((0..64).map(|b| hash(Node::Mul(a, 1000 + b)) as usize & (2 * count - 1)));
    }
    // With random places a fifth of them would coincide with an earlier one.
    assert!(places.len() > count * 3 / 4, "{}", places.len());
}
