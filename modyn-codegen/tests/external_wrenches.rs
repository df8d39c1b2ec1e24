//! The graphs of dynamics under external wrenches give the interpreter's results.

use modyn_codegen::passes::optimize;
use modyn_codegen::trace::Tracer;
use modyn_codegen::{Base, ReadOptions, read_urdf};
use modyn_runtime::equations::Forces;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::kinematics::Axes;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::ModuleTree;
use modyn_runtime::spatial::Wrench;
use modyn_runtime::{Interpreter, Scalar};

fn assert_close(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (found, expected) in found.iter().zip(expected) {
        let error = (found - expected).abs() / expected.abs().max(1.0);
        assert!(error < 1e-9, "{what}: {found} instead of {expected}");
    }
}

#[test]
fn wrenches_on_all_links_act_as_in_the_interpreter() {
    for (name, text, base) in [
        ("arm7", include_str!("../../robots/arm7.urdf"), Base::Fixed),
        ("joint_zoo", include_str!("../../robots/joint_zoo.urdf"), Base::Fixed),
        ("quadruped", include_str!("../../robots/quadruped.urdf"), Base::Floating),
        ("mimic_gripper", include_str!("../../robots/mimic_gripper.urdf"), Base::Fixed),
    ] {
        let options = ReadOptions { base, ..ReadOptions::default() };
        let model = read_urdf(text, name, &options).expect("a good robot").model;
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let elimination = Elimination::new(&mechanism, &ModuleTree::chains(&model));
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let number = |i: usize| Scalar::sin_cos(0.3 + 0.7 * i as f64).0;
        let mut q = vec![0.0; model.nq()];
        let mut next = 0.0;
        let uniform = || {
            next = (next + 0.618_033_988_749_895) % 1.0;
            next
        };
        interpreter.random(uniform, &mut q).expect("the size");
        let qd: Vec<f64> = (0..model.nv()).map(number).collect();
        let x: Vec<f64> = (0..model.nv()).map(|i| number(i + 50)).collect();
        let wrenches: Vec<Wrench<f64>> = (0..model.frames().len())
            .map(|i| Wrench::from_components(std::array::from_fn(|k| number(100 + 6 * i + k))))
            .collect();
        let numbers = wrenches.iter().flat_map(Wrench::components);
        let inputs: Vec<f64> = q.iter().chain(&qd).chain(&x).copied().chain(numbers).collect();
        for axes in [Axes::Link, Axes::World] {
            let forces = match axes {
                Axes::Link => Forces::InLinkAxes(&wrenches),
                Axes::World => Forces::InWorldAxes(&wrenches),
            };
            let (mut qdd, mut tau) = (x.clone(), x.clone());
            interpreter.forward_dynamics_external(&q, &qd, &x, forces, &mut qdd).expect("sizes");
            let found = optimize(tracer.forward_dynamics_external(&elimination, axes));
            assert_close(&found.evaluate(&inputs), &qdd, &format!("{name}: accelerations"));
            interpreter.inverse_dynamics_external(&q, &qd, &x, forces, &mut tau).expect("sizes");
            let found = optimize(tracer.inverse_dynamics_external(axes));
            assert_close(&found.evaluate(&inputs), &tau, &format!("{name}: joint forces"));
        }
    }
}
