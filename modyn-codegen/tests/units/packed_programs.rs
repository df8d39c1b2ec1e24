//! Programs on scalars in place of invalid packed programs.

use modyn_codegen::graph::{Graph, Node};
use modyn_codegen::plan::Kernels;
use modyn_codegen::program::Execution;

/// x0 (x1 + x2 + x3 + x4) on scalars; and packed, where `mixed` adds a pack of two lanes to one of four.
fn graphs(mixed: bool) -> [Graph; 2] {
    let mut scalar = Graph::default();
    let x = scalar.inputs(0..5);
    let products = |graph: &mut Graph, x: &[u32], number| graph.make(Node::Mul(x[0], number));
    let sum = scalar.pairwise_sum(&x[1..]);
    scalar.outputs = vec![products(&mut scalar, &x, sum)];
    let mut packed = Graph::default();
    let x = packed.inputs(0..5);
    let lanes = packed.pack(&x[1..]);
    let mut lanes = products(&mut packed, &x, lanes);
    if mixed {
        let two = packed.pack(&x[1..3]);
        lanes = packed.make(Node::Add(lanes, two));
    }
    let each: Vec<u32> = (0..4).map(|lane| packed.make(Node::ExtractLane(lanes, lane))).collect();
    packed.outputs = vec![packed.pairwise_sum(&each)];
    [scalar, packed]
}

#[test]
fn an_invalid_packed_program_leaves_the_program_on_scalars() {
    let point = [2.0, 1.0, 3.0, 5.0, 7.0];
    for share in [false, true] {
        let lowered = |[scalar, packed]: [Graph; 2]| {
            Kernels::lowered(&scalar, Some(packed), 5, Execution::Simd, share)
        };
        let (kernels, fault) = lowered(graphs(false));
        assert_eq!(fault, None);
        let Kernels::Straight { scalar, simd } = kernels else { panic!("straight-line code") };
        assert_eq!((simd.is_some(), scalar.routines.is_empty()), (!share, !share));
        assert_eq!(simd.unwrap_or(scalar).evaluate::<f64>(&point), [32.0]);
        let (kernels, fault) = lowered(graphs(true));
        assert_eq!(fault.map(|fault| fault.rule), Some("only scalars are copied to lanes"));
        let Kernels::Straight { scalar, simd: None } = kernels else { panic!("on scalars") };
        assert!(scalar.routines.is_empty() && scalar.execution == Execution::Scalar);
        assert_eq!(scalar.evaluate::<f64>(&point), [32.0]);
    }
}
