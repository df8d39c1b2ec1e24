//! The critical path of balanced sums.

use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::internals::ready_times;
use modyn_codegen::passes::{balance, optimize};
use modyn_codegen::trace::Tracer;
use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::ModuleTree;

/// The latencies of the pass, in cycles.
const FUSED: u32 = 4;
const SUM: u32 = 3;

/// Returns the balanced graph, after checking that its outputs and its operations are unchanged.
fn same(graph: &Graph) -> Graph {
    let balanced = balance(graph);
    let inputs: Vec<f64> = (0..20).map(|i| libm::sin(f64::from(i) + 0.5)).collect();
    for (a, b) in graph.evaluate(&inputs).iter().zip(balanced.evaluate(&inputs)) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
    assert!(balanced.count().total() <= graph.count().total());
    balanced
}

fn critical_path(graph: &Graph) -> u32 {
    let ready_at = ready_times(graph, &graph.uses());
    graph.outputs.iter().map(|&id| ready_at[id as usize]).max().expect("outputs")
}

#[test]
fn late_terms_are_added_last_and_the_others_in_pairs() {
    let graph = Graph::trace(|| {
        let x: Vec<Expr> = (0..9).map(Expr::input).collect();
        let late = (x[0] * x[1] + x[2]) * x[3] + x[4];
        vec![late + x[5] - x[6] - x[7] + x[8]]
    });
    // Two fused products, followed by one sum.
    assert_eq!(critical_path(&graph), 2 * FUSED + 4 * SUM);
    assert_eq!(critical_path(&same(&graph)), 2 * FUSED + SUM);
}

#[test]
fn signs_and_products_stay() {
    same(&Graph::trace(|| {
        let x: Vec<Expr> = (0..12).map(Expr::input).collect();
        let products = x[0] * x[1] - x[2] * x[3] - x[4] * x[5] + x[6] * x[7];
        let negative = -(x[0] * x[2]) - x[8] - x[9] - (x[10] + x[11] - products);
        vec![negative, products * products, -x[3] - x[4] - x[5]]
    }));
}

/// Forward dynamics of robots with modules of one link: the critical path in cycles and the operations, as traced and
/// with balanced sums.
#[test]
fn forward_dynamics_waits_less() {
    let frozen = [
        ("arm6.urdf", [260, 459], [232, 456]),
        ("arm7.urdf", [355, 1118], [315, 1114]),
        ("quadruped.urdf", [129, 684], [118, 676]),
    ];
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots");
    for (robot, before, after) in frozen {
        let text = std::fs::read_to_string(format!("{robots}/{robot}")).expect("a robot");
        let model = modyn_codegen::read_urdf(&text, robot, &modyn_codegen::ReadOptions::default())
            .expect("good")
            .model;
        let mechanism = Mechanism::new(&model);
        let links =
            Elimination::Recursive(ModulePartition::new(&mechanism, &ModuleTree::links(&model)));
        let graph = optimize(Tracer::new(&mechanism).forward_dynamics(&links));
        let costs = |graph: &Graph| [critical_path(graph) as usize, graph.count().total()];
        assert_eq!((costs(&graph), costs(&balance(&graph))), (before, after), "{robot}");
    }
}
