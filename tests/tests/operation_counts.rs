//! The operation counts of the compiled robots.

use modyn_codegen::graph::Graph;
use modyn_codegen::plan::partition;
use modyn_codegen::trace::Tracer;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::ModuleTree;
use modyn_tests::golden;

/// A robot's operations: multiplications, additions and divisions together.
#[derive(Debug, PartialEq, Eq)]
struct Counts {
    robot: &'static str,
    /// The smaller count of single links and of chains as modules.
    forward_dynamics: usize,
    /// The count with the modules that the search finds.
    searched: usize,
    inverse_dynamics: usize,
    mass_matrix: usize,
}

/// The present counts. Enter a count that falls; a count that rises is a regression.
const FROZEN: [Counts; 7] = [
    frozen("double_pendulum", 35, 35, 31, 11),
    frozen("double_pendulum_continuous", 38, 38, 34, 14),
    frozen("ur5", 486, 444, 275, 134),
    frozen("panda", 1089, 1049, 565, 315),
    frozen("panda_fingers", 1262, 1255, 638, 405),
    frozen("solo12", 732, 732, 556, 136),
    frozen("g1", 6265, 5952, 2827, 2382),
];

const fn frozen(
    robot: &'static str,
    forward_dynamics: usize,
    searched: usize,
    inverse_dynamics: usize,
    mass_matrix: usize,
) -> Counts {
    Counts { robot, forward_dynamics, searched, inverse_dynamics, mass_matrix }
}

/// The design's bounds for forward dynamics.
const LIMITS: [(&str, usize); 4] = [("ur5", 555), ("panda", 1139), ("solo12", 912), ("g1", 7683)];

fn counts(robot: &'static str) -> Counts {
    let model = golden::model(&golden::urdf(robot));
    let mechanism = Mechanism::new(&model);
    let tracer = Tracer::new(&mechanism);
    let total = |graph: Graph| graph.count().total();
    let forward = |modules: &ModuleTree| {
        total(tracer.forward_dynamics(&Elimination::new(&mechanism, modules)))
    };
    Counts {
        robot,
        forward_dynamics: forward(&ModuleTree::links(&model))
            .min(forward(&ModuleTree::chains(&model))),
        searched: partition::choose(&model, &mechanism, &tracer).candidates[0].1,
        inverse_dynamics: total(tracer.inverse_dynamics()),
        mass_matrix: total(tracer.mass_matrix()),
    }
}

#[test]
fn counts_are_as_frozen() {
    let found: Vec<Counts> = golden::FIXED_BASE.into_iter().map(counts).collect();
    assert_eq!(
        found, FROZEN,
        "\nA count that falls is to be entered; one that rises is a regression."
    );
}

#[test]
fn frozen_counts_keep_the_limits() {
    for (robot, limit) in LIMITS {
        let found = FROZEN.iter().find(|counts| counts.robot == robot);
        let found = found.unwrap_or_else(|| panic!("{robot} is not frozen")).forward_dynamics;
        assert!(found <= limit, "{robot}: {found} operations, more than {limit}");
    }
}
