//! The order of the bodies: each after its parent, and bodies of one kind together where the tree
//! allows it.

use std::collections::BTreeSet;

use super::{PlacedBody, Run};
use crate::graph::bodies::{BodyGraphs, LoopedBody};

/// Returns the bodies in an order with few runs, each body after its parent.
pub(super) fn runs(graphs: &BodyGraphs) -> Vec<Run> {
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); graphs.bodies.len()];
    // The bodies whose parent has a place, by kind.
    let mut ready: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); graphs.kinds.len()];
    for (i, body) in graphs.bodies.iter().enumerate() {
        match body.parent {
            Some(parent) => children[parent].push(i),
            None => _ = ready[body.kind].insert(i),
        }
    }
    let mut records = vec![0; graphs.bodies.len()];
    let mut runs: Vec<Run> = Vec::new();
    let mut next = 1;
    while let Some(kind) = (0..ready.len()).max_by_key(|&kind| ready[kind].len()) {
        if ready[kind].is_empty() {
            break;
        }
        let mut run = Run { kind, bodies: Vec::new() };
        while let Some(i) = ready[kind].pop_first() {
            let LoopedBody { row, parent, starts: [q, v], .. } = graphs.bodies[i];
            records[i] = next;
            run.bodies.push(PlacedBody {
                constants: graphs.kinds[kind].table[row].clone(),
                record: next,
                parent: parent.map_or(0, |parent| records[parent]),
                q,
                v,
            });
            next += 1;
            for &child in &children[i] {
                ready[graphs.bodies[child].kind].insert(child);
            }
        }
        runs.push(run);
    }
    runs
}
