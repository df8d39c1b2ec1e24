//! Fig. 6: the operations of forward dynamics and the interpreter's time, by the number of joints.
//!
//! Operations are counted on the traced equations (multiplications, additions and divisions, without sines and
//! cosines), of chains and trees in general position: no angle, offset or inertia is special.

use std::time::Instant;

use modyn_codegen::graph::Graph;
use modyn_codegen::plan::partition;
use modyn_codegen::trace::Tracer;
use modyn_runtime::Interpreter;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};

use crate::plot::{Axis, Chart, Line};
use crate::report::{Failure, Report, Table, power};
use crate::robots;

/// The operations of one robot's forward dynamics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// The number of joints.
    pub n: usize,
    /// The recursion, every link a module.
    pub by_links: usize,
    /// The recursion, every chain a module.
    pub by_chains: usize,
    /// Mass matrix from composite inertias and bias forces, eliminated as one matrix.
    pub by_matrix: usize,
    /// The recursion by the modules that the compiler's search finds.
    pub searched: usize,
}

/// Counts the operations.
#[must_use]
pub fn counts(model: &Model) -> Counts {
    let mechanism = Mechanism::new(model);
    let tracer = Tracer::new(&mechanism);
    let total = |graph: &Graph| graph.count().total();
    let by = |elimination: &Elimination| total(&tracer.forward_dynamics(elimination));
    let chains = ModuleTree::chains(model);
    Counts {
        n: model.nv(),
        by_links: by(&Elimination::new(&mechanism, &ModuleTree::links(model))),
        by_chains: by(&Elimination::new(&mechanism, &chains)),
        by_matrix: by(&Elimination::Matrix(UduLayout::new(&mechanism, &chains))),
        searched: partition::choose(model, &mechanism, &tracer)
            .candidates
            .first()
            .map_or(0, |&(_, cost)| cost),
    }
}

/// A published count: multiplications and additions for n revolute joints in a serial chain on a fixed base. All but
/// the last are from Featherstone (2008, "Rigid Body Dynamics Algorithms", Table 10.1).
pub type Published = (&'static str, fn(f64) -> f64);

/// Published counts of forward dynamics, multiplications and additions together.
pub const PUBLISHED: [Published; 3] = [
    ("articulated body (published)", |n| (224.0 * n - 259.0) + (205.0 * n - 248.0)),
    ("RNEA, CRBA, solve (published)", |n| {
        let rnea = (93.0 * n - 108.0) + (81.0 * n - 100.0);
        let crba = (10.0 * n * n + 22.0 * n - 32.0) + (6.0 * n * n + 37.0 * n - 43.0);
        let cube = n * n * n / 6.0;
        let solve = (cube + 1.5 * n * n - 2.0 * n / 3.0) + (cube + n * n - 7.0 * n / 6.0);
        rnea + crba + solve
    }),
    ("RGE (as quoted)", |n| (191.0 * n - 284.0) + (187.0 * n - 325.0)),
];

/// Returns the interpreter's time for forward dynamics of a chain, s: the minimum of several calls.
///
/// # Panics
///
/// Never: the lengths are those of the chain.
#[must_use]
pub fn seconds(links: usize) -> f64 {
    let mut interpreter = Interpreter::<f64>::new(robots::chain(links));
    let numbers: Vec<f64> = robots::spread(links).take(2 * links).collect();
    let (q, qd) = numbers.split_at(links);
    let (tau, mut qdd) = (vec![0.0; links], vec![0.0; links]);
    let mut call = || {
        let start = Instant::now();
        interpreter.forward_dynamics(q, qd, &tau, &mut qdd).expect("lengths");
        start.elapsed().as_secs_f64()
    };
    let calls = (200_000 / links).clamp(5, 2000);
    (0..calls).map(|_| call()).fold(f64::INFINITY, f64::min)
}

/// One of the counts.
type Column = fn(&Counts) -> usize;

/// The counts that are compared with that of the modules found.
const COMPARED: [(&str, Column); 3] = [
    ("BRGE by links", |c| c.by_links),
    ("BRGE by chains", |c| c.by_chains),
    ("composite inertias, elimination", |c| c.by_matrix),
];

/// Returns a line of quotients: a method's operations over those of the modules found.
fn line(name: &str, counts: &[Counts], operations: impl Fn(&Counts) -> f64) -> Line {
    Line::new(name, counts.iter().map(|c| (c.n as f64, operations(c) / c.searched as f64)))
}

/// Returns a line for each of the methods.
fn lines(counts: &[Counts], methods: &[(&str, Column)]) -> Vec<Line> {
    methods.iter().map(|(name, count)| line(name, counts, |c| count(c) as f64)).collect()
}

/// The lengths of the chains.
const CHAINS: [usize; 14] = [2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 30, 40, 60];

fn table_of(counts: &[Counts]) -> Table {
    let head =
        ["n", "by links", "chain as one module", "composite and elimination", "modules found"];
    let head = [&head[..], &PUBLISHED.map(|(name, _)| name)].concat();
    let row = |c: &Counts| {
        let own = [c.n, c.by_links, c.by_chains, c.by_matrix, c.searched].map(|x| x.to_string());
        own.into_iter().chain(PUBLISHED.map(|(_, f)| format!("{:.0}", f(c.n as f64)))).collect()
    };
    Table::new(&head, counts.iter().map(row).collect())
}

/// Returns the counts of chains of some of the lengths, with the published ones.
#[must_use]
pub fn table() -> Table {
    table_of(&[4, 6, 8, 10, 20, 60].map(|n| counts(&robots::chain(n))))
}

/// Writes the section of the page.
///
/// # Errors
///
/// If a plot cannot be written.
pub fn report(report: &mut Report) -> Result<(), Failure> {
    report.heading("Complexity: Fig. 6");
    report.text(
        "Operations of forward dynamics: multiplications, additions and divisions of the traced equations, of \
         revolute chains and trees in general position. Published counts have no divisions: articulated body \
         after McMillan, RNEA after Balafoutis and Patel, CRBA, factoring and solving as in Featherstone 2008, \
         Table 10.1; reverse Gaussian elimination after Saha, as others quote it. A chain as one module is composite \
         inertias and elimination, so both have the same count. The paper prints its Fig. 6 as a plot without numbers. \
         The search for modules stops after 80,000 traced operations, its budget.",
    );
    let counts = CHAINS.map(|n| counts(&robots::chain(n)));
    report.table(table_of(&counts));
    // A chain as one module has the counts of composite inertias.
    let mut of_chains = lines(&counts, &COMPARED[..2]);
    let published = PUBLISHED.map(|(name, count)| line(name, &counts, |c| count(c.n as f64)));
    of_chains.extend(published);
    let of_trees =
        |models: &[Model]| lines(&models.iter().map(self::counts).collect::<Vec<_>>(), &COMPARED);
    let palms = of_trees(&[1, 2, 3, 4, 6, 8].map(|length| robots::palm(5, length)));
    let trees = of_trees(&[1, 2, 3, 4].map(|length| robots::binary(4, length)));
    for (file, title, lines) in [
        ("fig6-chains.svg", "Fig. 6, chains: operations of forward dynamics", of_chains),
        ("fig6-palms.svg", "A first link with five equal branches: forward dynamics", palms),
        ("fig6-trees.svg", "Binary trees of 15 chains: operations of forward dynamics", trees),
    ] {
        let x = Axis::logarithmic("joints n");
        let y = Axis::logarithmic("operations, divided by those of the modules found");
        report.plot(file, &Chart { title, x, y, lines })?;
    }
    let lengths = [10, 100, 1000, 10_000, 100_000];
    let times = lengths.map(|n| (n as f64, seconds(n)));
    let rows = times
        .iter()
        .map(|&(n, time)| vec![n.to_string(), power(time), format!("{:.0}", time / n * 1e9)]);
    report.text(
        "Time of the interpreter's forward dynamics by links, one core (least of several calls):",
    );
    report.table(Table::new(&["links", "s", "ns a link"], rows.collect()));
    let title = "Time of the interpreter's forward dynamics";
    let (x, y) = (Axis::logarithmic("links of a chain"), Axis::logarithmic("time (s)"));
    let proportional = times.map(|(n, _)| (n, times[1].1 * n / 100.0));
    let lines = vec![Line::new("by links", times), Line::new("proportional", proportional)];
    report.plot("interpreter-time.svg", &Chart { title, x, y, lines })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{PUBLISHED, counts};
    use crate::robots;

    #[test]
    fn operations_are_linear_by_links_and_cubic_by_chains() {
        let [a, b, c] = [10, 20, 30].map(|n| counts(&robots::chain(n)));
        let (near, far) = (b.by_links - a.by_links, c.by_links - b.by_links);
        assert!(near.abs_diff(far) < near / 50, "linear: {near}, {far}");
        // The increment for ten more links grows.
        assert!(c.by_chains - b.by_chains > 3 * (b.by_chains - a.by_chains) / 2);
        assert!(c.by_matrix - b.by_matrix > 3 * (b.by_matrix - a.by_matrix) / 2);
        for c in [a, b, c] {
            assert!(c.searched <= c.by_links.min(c.by_chains));
        }
    }

    #[test]
    fn counts_are_below_the_published_ones() {
        for n in [4, 8, 12] {
            let counts = counts(&robots::chain(n));
            for (name, published) in &PUBLISHED[..2] {
                assert!((counts.searched as f64) < published(n as f64), "{name}, {n}: {counts:?}");
            }
        }
    }

    #[test]
    fn trees_have_the_joints_they_should() {
        assert_eq!(robots::palm(5, 3).nv(), 16);
        assert_eq!(robots::binary(4, 2).nv(), 30);
        let counts = counts(&robots::palm(3, 2));
        assert!(counts.searched <= counts.by_links.min(counts.by_chains));
    }
}
