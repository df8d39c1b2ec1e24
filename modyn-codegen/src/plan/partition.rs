//! The search for the modules of forward dynamics.
//!
//! The accelerations do not depend on the partition, but the cost does. Candidates are traced,
//! their operations are counted, and the cheapest is taken. The uniform candidates are modules of
//! one link, and one module for each chain. From the cheaper of the two the search varies one group
//! of chains at a time. Chains with the same sequence of joint types (legs, arms) are cut alike.
//!
//! With one link in each module, the elimination is the articulated-body algorithm.

use std::collections::BTreeMap;
use std::ops::Range;

use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::joint::JointType;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};

use crate::graph::Graph;
use crate::passes::optimize;
use crate::trace::Tracer;

/// Forward dynamics by the cheapest partition.
pub struct ChosenPartition {
    /// The chosen modules.
    pub modules: ModuleTree,
    /// The graph after all passes.
    pub graph: Graph,
    /// The operations of the uniform candidates and of the chosen one, before the passes; the
    /// chosen one is first.
    pub candidates: Vec<(&'static str, usize)>,
}

/// The longest chain that is considered as one module.
const MAX_MODULE: usize = 70;

/// The largest number of operations that the search traces: a tenth of a second in a macro, which
/// runs unoptimised.
const MAX_TRACED: usize = 80_000;

/// Returns the partition with a module for each chain, or with modules of one link if a chain is
/// too long.
///
/// The pivot block of a long chain takes operations cubic in its length, and is never the cheapest.
/// For the columns of derivatives, chains cost the same as links or less: the test `derivatives` of
/// `modyn-tests` counts both.
#[must_use]
pub fn whole_chains(model: &Model) -> ModuleTree {
    let chains = ModuleTree::chains(model);
    let longest = chains.modules().iter().map(|module| module.links.len()).max();
    if longest <= Some(MAX_MODULE) { chains } else { ModuleTree::links(model) }
}

/// Returns the cheapest partition, after tracing and counting the candidates.
#[must_use]
pub fn choose(model: &Model, mechanism: &Mechanism<f64>, tracer: &Tracer<'_>) -> ChosenPartition {
    let trace =
        |modules: &ModuleTree| tracer.forward_dynamics(&Elimination::new(mechanism, modules));
    let mut search = Search::new(model);
    let mut best: Option<(usize, Graph, ModuleTree)> = None;
    let mut traced = 0;
    // Returns the cost of a candidate, and records it if it is the cheapest so far.
    let mut consider = |modules: ModuleTree| {
        let graph = trace(&modules);
        let cost = graph.count().total();
        traced += cost;
        let better = best.as_ref().is_none_or(|(least, ..)| cost < *least);
        if better {
            best = Some((cost, graph, modules));
        }
        (better, cost, traced > MAX_TRACED)
    };
    let (_, by_links, _) = consider(ModuleTree::links(model));
    let mut candidates = vec![("one module for each link", by_links)];
    if whole_chains(model) != ModuleTree::links(model) {
        let (better, by_chains, mut over_budget) = consider(whole_chains(model));
        candidates.push(("one module for each chain", by_chains));
        search.start(!better);
        for (group, cut) in search.alternatives() {
            if over_budget {
                break;
            }
            let Some(modules) = search.modules(model, group, &cut) else { continue };
            let better;
            (better, _, over_budget) = consider(modules);
            if better {
                search.cuts[group] = cut;
            }
        }
    }
    let (cost, graph, modules) = best.expect("one candidate at least");
    if candidates.iter().all(|(_, other)| cost < *other) {
        candidates.push(("the modules found by the search", cost));
    }
    candidates.sort_by_key(|(_, cost)| *cost);
    ChosenPartition { modules, graph: optimize(graph), candidates }
}

/// The chains of a robot, in groups with the same joint types, and the cut of each group.
struct Search {
    /// The links of the chains, for each group.
    groups: Vec<Vec<Range<usize>>>,
    /// The lengths of the modules, for each group.
    cuts: Vec<Vec<usize>>,
}

impl Search {
    fn new(model: &Model) -> Self {
        let mut groups: BTreeMap<Vec<JointType>, Vec<Range<usize>>> = BTreeMap::new();
        for module in ModuleTree::chains(model).modules() {
            let links = &model.moving_links()[module.links.clone()];
            let types = links.iter().map(|link| link.joint.joint_type).collect();
            groups.entry(types).or_default().push(module.links.clone());
        }
        let mut groups: Vec<_> = groups.into_values().collect();
        // The group with the most links comes first.
        groups.sort_by_key(|chains| {
            (core::cmp::Reverse(chains.len() * chains[0].len()), chains[0].start)
        });
        Self { cuts: groups.iter().map(|chains| vec![1; chains[0].len()]).collect(), groups }
    }

    /// Starts with modules of one link, or with a module for each chain.
    fn start(&mut self, by_links: bool) {
        for (cut, chains) in self.cuts.iter_mut().zip(&self.groups) {
            let length = chains[0].len();
            *cut = if by_links { vec![1; length] } else { vec![length] };
        }
    }

    /// Returns the cuts to try, each of one group: first the uniform cuts of every group, then a
    /// module at the root followed by single links, then two modules.
    fn alternatives(&self) -> Vec<(usize, Vec<usize>)> {
        let lengths: Vec<usize> = self.groups.iter().map(|chains| chains[0].len()).collect();
        let each = |cuts: &dyn Fn(usize) -> Vec<Vec<usize>>| {
            let of_group = |(group, &length): (usize, &usize)| {
                cuts(length).into_iter().map(move |cut| (group, cut)).collect::<Vec<_>>()
            };
            lengths.iter().enumerate().flat_map(of_group).collect::<Vec<_>>()
        };
        let uniform = each(&|length| vec![vec![length], vec![1; length]]);
        let head = |length: usize, head: usize| [vec![head], vec![1; length - head]].concat();
        let heads = each(&|length| (2..length).rev().map(|h| head(length, h)).collect());
        let halves = each(&|length| (1..length).map(|h| vec![h, length - h]).collect());
        let all = [uniform, heads, halves].concat();
        all.into_iter().filter(|(group, _)| (2..=MAX_MODULE).contains(&lengths[*group])).collect()
    }

    /// Returns the modules with this cut of `group`; `None` if that is the current cut.
    fn modules(&self, model: &Model, group: usize, cut: &[usize]) -> Option<ModuleTree> {
        if self.cuts[group] == cut {
            return None;
        }
        let mut starts = Vec::new();
        for (g, chains) in self.groups.iter().enumerate() {
            let cut = if g == group { cut } else { &self.cuts[g] };
            for chain in chains {
                let mut at = chain.start;
                for piece in cut {
                    starts.push(at);
                    at += piece;
                }
            }
        }
        starts.sort_unstable();
        let ends = starts.iter().skip(1).copied().chain([model.moving_links().len()]);
        let name = |i: usize| model.moving_links()[i].name.as_str();
        let list: Vec<Vec<&str>> =
            starts.iter().zip(ends).map(|(&start, end)| (start..end).map(name).collect()).collect();
        ModuleTree::from_names(model, &list).ok()
    }
}
