//! Forward mode along several directions at a time, one in each lane, in graphs whose equal limbs
//! are lanes.
//!
//! Direction k displaces limb k. A pack of the limbs' numbers then has a change in lane k along
//! direction k, and none in the other lanes, so its changes along all directions are one pack. The
//! change of a scalar is a sum of such packs, of each of which some lanes count: it has a part from
//! each limb.
//!
//! This holds as long as no limb depends on a number that another limb changes.

use std::collections::BTreeMap;

use super::differentiate::partials;
use crate::graph::{Graph, Id, Node};

/// The change of an input along a direction.
pub struct Displacement {
    /// The number of the input.
    pub input: usize,
    /// The direction, less than 8.
    pub direction: u8,
    /// The node of the change.
    pub change: Id,
}

/// The changes of a node.
#[derive(Clone)]
enum Change {
    /// The change of a pack of limbs: lane k is the change of lane k along direction k.
    OfLimbs(Id),
    /// The changes of a scalar: along direction k, the sum of lane k of all packs whose set of
    /// lanes has k.
    OfScalar(Vec<Term>),
    /// The change of a pack with lanes that other directions change. The pack is half of another
    /// one, whose scalars have their changes; no other operation reads the change of this pack.
    Crossed,
}

#[derive(Clone, Copy)]
struct Term {
    pack: Id,
    /// The lanes that count: a bit for each.
    lanes: u8,
}

/// Adds a term. Terms of one pack become one term, and so do terms with the same lanes of packs of
/// one width.
fn add(graph: &mut Graph, terms: &mut Vec<Term>, mut term: Term) {
    loop {
        let add_up = |other: &Term| {
            let widths = [graph.width(other.pack), graph.width(term.pack)];
            other.lanes == term.lanes && (widths.contains(&1) || widths[0] == widths[1])
        };
        let similar = terms.iter().position(|other| {
            add_up(other) || (other.pack == term.pack && other.lanes & term.lanes == 0)
        });
        let Some(match_index) = similar else { break };
        let other = terms.remove(match_index);
        term = if other.lanes == term.lanes {
            Term { pack: graph.make(Node::Add(other.pack, term.pack)), lanes: term.lanes }
        } else {
            Term { pack: term.pack, lanes: term.lanes | other.lanes }
        };
    }
    terms.push(term);
}

/// The changes of the outputs of a graph.
pub struct Directional {
    /// The graph of all changes.
    pub graph: Graph,
    /// For each output of the differentiated graph: the outputs of `graph` whose sum is the change,
    /// each with the lanes that count, a bit for each. An output has the change along direction k
    /// in its lane k.
    pub changes: Vec<Vec<(usize, u8)>>,
}

/// Returns the changes of the outputs of `graph` along directions. `graph` has the nodes of the
/// displacements.
///
/// Returns `None` if a direction changes more than one limb.
#[must_use]
pub fn along_directions(graph: &Graph, displacements: &[Displacement]) -> Option<Directional> {
    let live = graph.live();
    let nodes = graph.nodes().len();
    let mut result = graph.clone();
    let mut changes: Vec<Option<Change>> = vec![None; nodes];
    for at in (0..nodes).filter(|&at| live[at]) {
        let id = Id::try_from(at).expect("a graph's node");
        changes[at] = match graph.node(id) {
            Node::Input(number) => {
                let mut terms = Vec::new();
                for displacement in displacements
                    .iter()
                    .filter(|displacement| displacement.input == number as usize)
                {
                    add(
                        &mut result,
                        &mut terms,
                        Term { pack: displacement.change, lanes: 1 << displacement.direction },
                    );
                }
                (!terms.is_empty()).then_some(Change::OfScalar(terms))
            }
            Node::ExtractLane(pack, lane) => match changes[pack as usize] {
                Some(Change::OfLimbs(pack)) => {
                    Some(Change::OfScalar(vec![Term { pack, lanes: 1 << lane }]))
                }
                Some(Change::Crossed) => return None,
                _ => None,
            },
            Node::Pack(..) => pack_of_limbs(graph, &mut result, &changes, id),
            _ => operation(graph, &mut result, &changes, id)?,
        };
    }
    let mut outputs: BTreeMap<Id, usize> = BTreeMap::new();
    let mut output = |pack: Id| {
        let next = outputs.len();
        *outputs.entry(pack).or_insert(next)
    };
    let of_outputs = graph.outputs.iter().map(|&id| match &changes[id as usize] {
        Some(Change::OfScalar(terms)) => {
            terms.iter().map(|term| (output(term.pack), term.lanes)).collect()
        }
        _ => Vec::new(),
    });
    let changes = of_outputs.collect();
    result.outputs = vec![0; outputs.len()];
    for (id, place) in outputs {
        result.outputs[place] = id;
    }
    Some(Directional { graph: result, changes })
}

/// Returns the change of a pack, if it has one.
fn pack_of_limbs(
    graph: &Graph,
    result: &mut Graph,
    changes: &[Option<Change>],
    id: Id,
) -> Option<Change> {
    let mut lanes = Vec::new();
    let mut changed = false;
    let mut of_copy = None;
    let numbers: Vec<Id> = (0..graph.width(id)).map(|lane| graph.packed_at(id, lane)).collect();
    for (lane, &number) in numbers.iter().enumerate() {
        // The last lanes of fewer limbs are copies of an input, and count nowhere.
        let is_copy = lane > 0 && numbers[lane - 1] == number;
        if is_copy && matches!(graph.node(number), Node::Input(_)) {
            lanes.extend(of_copy);
            continue;
        }
        let change = match &changes[number as usize] {
            None => result.constant(0.0),
            Some(Change::OfLimbs(_) | Change::Crossed) => return Some(Change::Crossed),
            Some(Change::OfScalar(terms)) => {
                if terms.iter().any(|term| term.lanes != 1 << lane) {
                    return Some(Change::Crossed);
                }
                changed = true;
                let lane = u8::try_from(lane).expect("few lanes");
                let lanes_of_terms =
                    terms.iter().map(|term| result.make(Node::ExtractLane(term.pack, lane)));
                let changes: Vec<Id> = lanes_of_terms.collect();
                result.pairwise_sum(&changes)
            }
        };
        of_copy = Some(change);
        lanes.push(change);
    }
    changed.then(|| Change::OfLimbs(result.pack(&lanes)))
}

/// Returns the change of an operation, if it has one; `None` if a scalar that limbs change takes
/// part in one on limbs.
fn operation(
    graph: &Graph,
    result: &mut Graph,
    changes: &[Option<Change>],
    id: Id,
) -> Option<Option<Change>> {
    if graph.node(id).operands().all(|operand| changes[operand as usize].is_none()) {
        return Some(None);
    }
    let of_limbs = graph.width(id) > 1;
    let mut pack: Option<Id> = None;
    let mut terms: Vec<Term> = Vec::new();
    for (operand, partial) in partials(result, id) {
        match &changes[operand as usize] {
            None => {}
            Some(Change::Crossed) => return None,
            Some(Change::OfLimbs(change)) => {
                let change = partial.apply(result, *change);
                pack = Some(match pack {
                    None => change,
                    Some(sum) => result.make(Node::Add(sum, change)),
                });
            }
            Some(Change::OfScalar(_)) if of_limbs => return None,
            Some(Change::OfScalar(scalar_terms)) => {
                for &Term { pack, lanes } in scalar_terms {
                    let pack = partial.apply(result, pack);
                    add(result, &mut terms, Term { pack, lanes });
                }
            }
        }
    }
    Some(if of_limbs { pack.map(Change::OfLimbs) } else { Some(Change::OfScalar(terms)) })
}
