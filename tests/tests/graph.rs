//! A traced graph, evaluated on numbers, gives the interpreter's results.

use modyn_codegen::graph::Graph;
use modyn_codegen::trace::Tracer;
use modyn_runtime::Interpreter;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{JointFriction, Model, ModuleTree};
use modyn_tests::cases::{Robot, cases, robots, zoos};
use modyn_tests::close::assert_close;
use modyn_tests::quantities::{Quantities, numbers};
use modyn_tests::random::{State, modules, state};
use proptest::prelude::*;

/// The tolerance. Constant folding and the normalization of signs change the rounding; nothing else differs.
const TOLERANCE: f64 = 1e-11;

/// Returns partitions into single links, into chains, and a random partition.
fn partitions(robot: Robot, model: &Model) -> [ModuleTree; 3] {
    [ModuleTree::links(model), ModuleTree::chains(model), modules(robot.seed(), model)]
}

fn evaluate(graph: &Graph, groups: &[&[f64]]) -> Vec<f64> {
    graph.evaluate(&groups.concat())
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn every_quantity(robot in robots(20)) {
        let model = robot.model();
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let State { q, qd, qdd, tau } = &state(robot.seed(), &model);
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
        let expected = interpreter.dense_mass_matrix(q);
        check("mass matrix", &tracer.mass_matrix(), &[q], &expected);
        let expected: Vec<f64> = interpreter.poses(q).iter().flat_map(numbers).collect();
        check("link poses", &tracer.link_poses(), &[q], &expected);

        for modules in partitions(robot, &model) {
            let graph = tracer.forward_dynamics(&Elimination::new(&mechanism, &modules));
            interpreter = interpreter.eliminating_by(&modules).expect("its own modules");
            let expected = interpreter.qdd(q, qd, tau);
            check("forward dynamics", &graph, &[q, qd, tau], &expected);
        }
    }

    #[test]
    fn coulomb_friction(robot in zoos(10)) {
        let model = robot.model().with_joint_friction(JointFriction::Coulomb).expect("sound");
        let State { q, mut qd, .. } = state(robot.seed(), &model);
        qd[0] = 0.0;
        let expected = Interpreter::<f64>::new(model.clone()).bias(&q, &qd);
        let graph = Tracer::new(&Mechanism::new(&model)).bias_forces();
        assert_close("bias forces", &evaluate(&graph, &[&q, &qd]), &expected, TOLERANCE);
    }

    #[test]
    fn every_quantity_of_the_factorization(robot in robots(20)) {
        let model = robot.model();
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let State { q, tau, .. } = &state(robot.seed(), &model);
        for modules in partitions(robot, &model) {
            let layout = &UduLayout::new(&mechanism, &modules);
            let interpreter =
                Interpreter::with_modules(model.clone(), modules).expect("its own modules");
            let expected = interpreter.factors(q);
            let factors = evaluate(&tracer.brge(layout), &[q]);
            let check = |what, graph: &Graph, expected: &[f64]| {
                let scale = expected.iter().fold(1.0, |scale: f64, x| scale.max(x.abs()));
                assert_close(what, &evaluate(graph, &[&factors]), expected, TOLERANCE * scale);
            };
            check("U", &tracer.u(layout), &expected.u());
            check("D", &tracer.d(layout), &expected.d());
            check("U^-1", &tracer.u_inverse(layout), &expected.u_inverse());
            check("D^-1", &tracer.d_inverse(layout), &expected.d_inverse());
            check("inverse", &tracer.inverse(layout), &expected.inverse());
            let logarithm = expected.log_determinant();
            check("log-determinant", &tracer.log_determinant(layout), &[logarithm]);
            let solution = expected.solve(tau).expect("the length is right");
            let scale = solution.iter().fold(1.0, |scale: f64, x| scale.max(x.abs()));
            let found = evaluate(&tracer.solve(layout), &[&factors, tau]);
            assert_close("solve", &found, &solution, TOLERANCE * scale);
        }
    }
}
