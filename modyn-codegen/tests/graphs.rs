//! A graph keeps the values of the traced program: through the rewrites at insertion, and through each pass.

use std::f64::consts::PI;

use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::passes::PASSES;
use modyn_runtime::Scalar;

const INPUTS: usize = 4;

/// Runs a program of random operations, which is the same for each scalar. Its constants trigger the rewrites about 0,
/// 1, -1 and 2. Few values are in use, so equal and opposite operands are common.
fn program<S: Scalar>(seed: u64, inputs: &[S]) -> Vec<S> {
    let mut state = seed;
    let mut pick = |count: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        usize::try_from(state >> 33).expect("31 bits") % count
    };
    let mut values: Vec<S> = inputs.to_vec();
    values.extend([0.0, 1.0, -1.0, 2.0, -0.5, 3.0].map(S::from_f64));
    for _ in 0..60 {
        let (a, b) = (values[pick(values.len())], values[pick(values.len())]);
        // Every result is bounded, so that rounding errors stay small.
        let value = match pick(14) {
            0..=2 => a + b,
            3..=5 => a - b,
            6..=8 => a * b,
            9 => -a,
            10 => {
                let (sin, cos) = a.sin_cos();
                sin * b + cos
            }
            11 => (a * a + S::one()).recip(),
            12 => a.atan2(b * b + S::one()),
            _ => a.select_nonnegative(b, a.abs().max(b)),
        };
        let (sin, _) = value.sin_cos();
        values.push(if pick(4) == 0 { sin } else { value });
        if values.len() > 24 {
            values.drain(INPUTS + 6..INPUTS + 10);
        }
    }
    values.split_off(INPUTS + 6)
}

fn traced(seed: u64) -> Graph {
    Graph::trace(|| {
        let inputs: Vec<Expr> = (0..INPUTS).map(Expr::input).collect();
        program(seed, &inputs)
    })
}

const POINT: [f64; INPUTS] = [0.7, -0.3, 0.11, 1.3];

fn assert_close(seed: u64, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let scale = expected.abs().max(1.0);
        let close = (found - expected).abs() <= 1e-9 * scale;
        // Products of products may overflow or lose all digits; then both sides do.
        let lost = !expected.is_finite() || scale > 1e6;
        assert!(close || lost, "seed {seed}: {found} instead of {expected}");
    }
}

#[test]
fn a_traced_graph_evaluates_to_the_programs_results() {
    let mut nodes = 0;
    for seed in 0..2000 {
        let graph = traced(seed);
        nodes += graph.nodes().len();
        assert_close(seed, &graph.evaluate(&POINT), &program(seed, &POINT));
    }
    assert!(nodes > 50_000, "the programs should not fold away: {nodes} nodes");
}

#[test]
fn each_pass_keeps_the_outputs() {
    for (name, pass) in PASSES {
        let mut saved = 0;
        for seed in 0..2000 {
            let before = traced(seed);
            let after = pass(&before);
            assert_close(seed, &after.evaluate(&POINT), &before.evaluate(&POINT));
            let (before, after) = (before.count().total(), after.count().total());
            assert!(after <= before, "{name} made {before} operations {after}, seed {seed}");
            saved += before - after;
        }
        assert!(saved > 0, "{name} never saved anything");
    }
}

#[test]
fn equal_operations_are_one_node_whatever_their_signs() {
    let graph = Graph::trace(|| {
        let [a, b, c] = [0, 1, 2].map(Expr::input);
        let difference = a - b;
        vec![difference * c, (b - a) * c, -(c * (a - b)), (-a) * b, a * (-b), (a + b) - (b + a)]
    });
    let count = graph.count();
    assert_eq!((count.additions, count.multiplications), (1, 2));
    assert_eq!(graph.evaluate(&[3.0, 1.0, 5.0]), [10.0, -10.0, -10.0, -3.0, -3.0, 0.0]);
}

#[test]
fn constants_fold() {
    let graph = Graph::trace(|| {
        let x = Expr::input(0);
        let [zero, one, two, half] = [0.0, 1.0, 2.0, 0.5].map(Expr::from_f64);
        let (sin, cos) = zero.sin_cos();
        vec![
            x * one + zero,
            two * (half * x),
            x * zero + sin,
            x * cos,
            x - (x - two),
            (x - two) + two,
            (x + x) - x,
            zero.select_nonnegative(one, x),
            (-two).select_nonnegative(one, two.abs().max(half)),
            zero.atan2(two) + (-half).atan2(half) * Expr::from_f64(4.0 / PI),
        ]
    });
    assert_eq!(graph.count().total(), 0);
    assert_eq!(graph.evaluate(&[7.0]), [7.0, 7.0, 0.0, 7.0, 2.0, 7.0, 7.0, 1.0, 2.0, -1.0]);
}

#[test]
fn a_trace_inside_a_trace_does_not_disturb_it() {
    let graph = Graph::trace(|| {
        let x = Expr::input(0);
        let inner = Graph::trace(|| vec![Expr::input(0) * Expr::from_f64(3.0)]);
        assert_eq!(inner.evaluate(&[2.0]), [6.0]);
        vec![x + x]
    });
    assert_eq!(graph.evaluate(&[5.0]), [10.0]);
}

/// An expression of another trace has an index that means another node here. The trace reports an error and no graph.
#[test]
fn expressions_belong_to_their_trace() {
    let mut kept = None;
    let first = Graph::try_trace(|| {
        kept = Some(Expr::input(0) * Expr::input(1));
        vec![Expr::input(0)]
    });
    assert!(first.is_ok());
    let kept = kept.expect("made");
    let uses: [fn(Expr) -> Expr; 6] = [
        |x| x,
        |x| x + Expr::input(0),
        |x| Expr::input(0).atan2(x),
        |x| x.sin_cos().1,
        |x| Expr::pack(&[Expr::input(0), x]).extract_lane(1),
        |x| Expr::input(0).select_nonnegative(Expr::one(), x),
    ];
    for (i, of) in uses.iter().enumerate() {
        assert!(Graph::try_trace(|| vec![of(kept)]).is_err(), "{i}");
        // The error is also reported if the result is unused, and from an outer trace.
        let dropped = Graph::try_trace(|| {
            let outer = Expr::input(0);
            let inner = Graph::try_trace(|| vec![of(outer)]);
            assert!(inner.is_err(), "{i}");
            let _ = of(kept);
            vec![outer]
        });
        // An expression that is only passed through is no operand of any operation.
        assert_eq!(dropped.is_err(), i > 0, "{i}");
    }
    assert!(
        Graph::try_trace(|| vec![Expr::input(0) + Expr::one()]).is_ok(),
        "the next one is sound"
    );
    assert!(std::panic::catch_unwind(|| Graph::trace(|| vec![kept])).is_err());
}
