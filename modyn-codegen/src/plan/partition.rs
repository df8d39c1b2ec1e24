//! Which modules the forward recursion of a robot is eliminated by.
//!
//! The result does not depend on it, the cost does; so candidates are traced, their operations are
//! counted, and the cheapest is taken. Every link its own module and every chain one module are
//! the uniform choices; from the better one the search goes chain by chain, trying other pieces.
//! Chains of one architecture (the same joint types in a row: legs, arms) are cut alike.

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
pub struct Choice {
    /// The modules chosen.
    pub modules: ModuleTree,
    /// The graph, after all passes.
    pub graph: Graph,
    /// What the uniform choices and what was chosen cost, before the passes; the chosen one first.
    pub candidates: Vec<(&'static str, usize)>,
}

/// The longest chain that is considered as one module.
const MAX_MODULE: usize = 70;

/// Most operations that are traced to search: a tenth of a second in a macro, which runs
/// unoptimised.
const MAX_TRACED: usize = 80_000;

/// Every chain a module, or every link if one of them is too long.
///
/// The pivot block of a long chain takes the cube of its length to write out, only to lose. Solving
/// for the columns of derivatives costs the same by links and by chains, or less by chains: the test
/// `derivatives` of `modyn-tests` counts both.
#[must_use]
pub fn whole_chains(model: &Model) -> ModuleTree {
    let chains = ModuleTree::chains(model);
    let longest = chains.modules().iter().map(|module| module.links.len()).max();
    if longest <= Some(MAX_MODULE) { chains } else { ModuleTree::links(model) }
}

/// Traces and counts candidates, and takes the cheapest.
#[must_use]
pub fn choose(model: &Model, mechanism: &Mechanism<f64>, tracer: &Tracer<'_>) -> Choice {
    let trace =
        |modules: &ModuleTree| tracer.forward_dynamics(&Elimination::new(mechanism, modules));
    let mut search = Search::new(model);
    let mut best: Option<(usize, Graph, ModuleTree)> = None;
    let mut traced = 0;
    // Whether the candidate is the cheapest so far, and its cost.
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
    let mut candidates = vec![("every link its own module", by_links)];
    if whole_chains(model) != ModuleTree::links(model) {
        let (better, by_chains, mut over_budget) = consider(whole_chains(model));
        candidates.push(("every chain one module", by_chains));
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
        candidates.push(("the modules that were found", cost));
    }
    candidates.sort_by_key(|(_, cost)| *cost);
    Choice { modules, graph: optimize(graph), candidates }
}

/// The chains of a robot, in groups of one architecture, and how each group is cut.
struct Search {
    /// The links of the chains, group by group.
    groups: Vec<Vec<Range<usize>>>,
    /// For each group the lengths of the pieces.
    cuts: Vec<Vec<usize>>,
}

impl Search {
    fn new(model: &Model) -> Self {
        let mut groups: BTreeMap<Vec<JointType>, Vec<Range<usize>>> = BTreeMap::new();
        for module in ModuleTree::chains(model).modules() {
            let links = &model.links()[module.links.clone()];
            let types = links.iter().map(|link| link.joint.joint_type).collect();
            groups.entry(types).or_default().push(module.links.clone());
        }
        let mut groups: Vec<_> = groups.into_values().collect();
        // Those first of which there is most.
        groups.sort_by_key(|chains| {
            (core::cmp::Reverse(chains.len() * chains[0].len()), chains[0].start)
        });
        Self { cuts: groups.iter().map(|chains| vec![1; chains[0].len()]).collect(), groups }
    }

    /// Begins with every link its own module, or with every chain one.
    fn start(&mut self, by_links: bool) {
        for (cut, chains) in self.cuts.iter_mut().zip(&self.groups) {
            let length = chains[0].len();
            *cut = if by_links { vec![1; length] } else { vec![length] };
        }
    }

    /// Cuts to try, of one group each: first the uniform ones of every group, then a module at the
    /// root with single links behind it, then two modules.
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

    /// The modules with `group` cut so, and the others as they are; `None` if it is cut so now.
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
        let ends = starts.iter().skip(1).copied().chain([model.links().len()]);
        let name = |i: usize| model.links()[i].name.as_str();
        let list: Vec<Vec<&str>> =
            starts.iter().zip(ends).map(|(&start, end)| (start..end).map(name).collect()).collect();
        ModuleTree::from_names(model, &list).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_finds_what_no_uniform_choice_has() {
        let text = include_str!("../../../robots/arm6.urdf");
        let model = crate::read_urdf(text, "arm6.urdf", &crate::ReadOptions::default())
            .expect("good")
            .model;
        let mechanism = Mechanism::new(&model);
        let Choice { modules, graph, candidates } =
            choose(&model, &mechanism, &Tracer::new(&mechanism));
        assert_eq!(candidates[0].0, "the modules that were found");
        assert!(candidates.iter().all(|(_, cost)| *cost >= candidates[0].1));
        assert!(graph.count().total() <= candidates[0].1);
        assert!(modules.fits(&model) && modules.modules().len() > 1);
    }
}
