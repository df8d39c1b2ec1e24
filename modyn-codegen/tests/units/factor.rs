//! Factoring of known sums.

use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::internals::factor;

/// Returns the operations after the pass, after checking that the outputs are unchanged.
fn operations(graph: &Graph) -> usize {
    let factored = factor(graph);
    let inputs: Vec<f64> = (0..8).map(|i| libm::sin(f64::from(i) + 0.5)).collect();
    for (a, b) in graph.evaluate(&inputs).iter().zip(factored.evaluate(&inputs)) {
        assert!((a - b).abs() < 1e-14, "{a} {b}");
    }
    factored.count().total()
}

#[test]
fn a_rotated_multiple_is_a_multiple_of_the_rotated_vector() {
    let rotated = |[x, y]: [Expr; 2], [c, s]: [Expr; 2]| [c * x + s * y, c * y - s * x];
    let graph = |scaled: bool| {
        Graph::trace(move || {
            let x: Vec<Expr> = (0..5).map(Expr::input).collect();
            let (v, rotation) = ([x[0], x[1]], [x[2], x[3]]);
            let multiple = v.map(|v| x[4] * v);
            let after = rotated(v, rotation);
            let other = match scaled {
                true => rotated(multiple, rotation),
                false => after.map(|v| x[4] * v),
            };
            [after, other].concat()
        })
    };
    assert_eq!(operations(&graph(true)), graph(false).count().total());
}

#[test]
fn without_the_known_sum_nothing_changes() {
    let graph = Graph::trace(|| {
        let x: Vec<Expr> = (0..5).map(Expr::input).collect();
        vec![x[2] * (x[4] * x[0]) + x[3] * (x[4] * x[1]), x[4] * x[0], x[4] * x[1]]
    });
    assert_eq!(operations(&graph), graph.count().total());
}
