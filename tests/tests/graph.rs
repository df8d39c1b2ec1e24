//! Compiled is interpreted: a traced graph on numbers gives what the interpreter gives.

use modyn_codegen::expr::Graph;
use modyn_codegen::trace::Tracer;
use modyn_runtime::Interpreter;
use modyn_runtime::equations::Partition;
use modyn_runtime::model::ModuleTree;
use modyn_runtime::model::prepare::Prepared;
use modyn_tests::cases::cases;
use modyn_tests::close::assert_close;
use modyn_tests::quantities::{Quantities, numbers};
use modyn_tests::random::{State, modules, state, tree};
use proptest::prelude::*;

/// The two differ where constants are folded and signs normalised, and in nothing else.
const TOLERANCE: f64 = 1e-11;

fn evaluate(graph: &Graph, groups: &[&[f64]]) -> Vec<f64> {
    graph.evaluate(&groups.concat())
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn every_quantity(seed: u64, links in 1..=20usize) {
        let model = tree(seed, links);
        let prepared = Prepared::new(&model);
        let tracer = Tracer::new(&prepared);
        let State { q, qd, qdd, tau } = &state(seed, &model);
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let check = |what, graph: &Graph, groups: &[&[f64]], expected: &[f64]| {
            assert_close(what, &evaluate(graph, groups), expected, TOLERANCE);
        };
        let expected = interpreter.tau(q, qd, qdd);
        check("inverse dynamics", &tracer.inverse_dynamics(), &[q, qd, qdd], &expected);
        let expected = interpreter.bias(q, qd);
        check("bias forces", &tracer.bias_forces(), &[q, qd], &expected);
        let expected = interpreter.gravity(q);
        check("gravity torques", &tracer.gravity_torques(), &[q], &expected);
        let expected = interpreter.gim(q);
        check("mass matrix", &tracer.mass_matrix(), &[q], &expected);
        let expected = interpreter.kinetic(q, qd);
        check("kinetic energy", &tracer.kinetic_energy(), &[q, qd], &[expected]);
        let expected = interpreter.potential(q);
        check("potential energy", &tracer.potential_energy(), &[q], &[expected]);
        let expected: Vec<f64> = interpreter.poses(q).iter().flat_map(numbers).collect();
        check("link poses", &tracer.link_poses(), &[q], &expected);

        let trees =
            [ModuleTree::links(&model), ModuleTree::chains(&model), modules(seed, &model)];
        for modules in trees {
            let graph = tracer.forward_dynamics(&Partition::from(&modules));
            interpreter = interpreter.eliminating_by(&modules).expect("its own modules");
            let expected = interpreter.qdd(q, qd, tau);
            let found = evaluate(&graph, &[q, qd, tau]);
            assert_close("forward dynamics", &found, &expected, TOLERANCE);
        }
    }
}
