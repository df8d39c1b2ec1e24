//! Which modules the forward recursion of a robot is eliminated by.
//!
//! The result does not depend on it, the cost does; so candidates are traced, counted and the
//! cheapest is taken. The candidates are the two uniform choices; a search over partitions
//! branch by branch would add its own here.

use modyn_runtime::equations::Partition;
use modyn_runtime::model::{Model, ModuleTree};

use crate::expr::Graph;
use crate::passes::optimize;
use crate::trace::Tracer;

/// Forward dynamics by the cheapest partition.
pub struct Choice {
    /// The modules chosen.
    pub modules: ModuleTree,
    /// The graph, after all passes.
    pub graph: Graph,
    /// What each candidate costs, and what it is called; the chosen one first.
    pub candidates: Vec<(&'static str, usize)>,
}

/// The longest chain that is considered as one module.
const LONGEST: usize = 70;

/// Traces and counts all candidates.
#[must_use]
pub fn choose(model: &Model, tracer: &Tracer<'_>) -> Choice {
    let links = ModuleTree::links(model);
    let chains = ModuleTree::chains(model);
    let mut candidates = vec![("every link its own module", links)];
    // The pivot block of a long chain takes the cube of its length to write out, only to lose.
    let longest = chains.modules().iter().map(|module| module.links.len()).max();
    if candidates[0].1 != chains && longest <= Some(LONGEST) {
        candidates.push(("every chain one module", chains));
    }
    let mut traced: Vec<(&'static str, ModuleTree, Graph)> = candidates
        .into_iter()
        .map(|(name, modules)| {
            let graph = optimize(tracer.forward_dynamics(&Partition::from(&modules)));
            (name, modules, graph)
        })
        .collect();
    // Stable: of equals, the earlier one.
    traced.sort_by_key(|(_, _, graph)| graph.count().total());
    let costs = traced.iter().map(|(name, _, graph)| (*name, graph.count().total())).collect();
    let (_, modules, graph) = traced.swap_remove(0);
    Choice { modules, graph, candidates: costs }
}
