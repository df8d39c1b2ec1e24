//! The interpreter allocates memory when it is made, and not in calls. The memory for derivatives, closed loops and
//! changed inertias is allocated by the first call that needs it.

use modyn_runtime::equations::{ForwardInput, Motion};
use modyn_runtime::model::{Inertial, Model, ModuleTree};
use modyn_runtime::spatial::{Pose, Wrench};
use modyn_runtime::{Forces, ForwardDerivatives, Interpreter, ShapeError};
use modyn_tests::counting::measure;
use modyn_tests::random::{State, state, tree, zoo};

/// Returns random robots with all joint types, with and without mimic joints.
fn robots() -> impl Iterator<Item = (u64, Model)> {
    (0..20).flat_map(|seed: u64| {
        let links = 1 + usize::try_from(seed).expect("small");
        [(seed, tree(seed, links)), (seed, zoo(seed, links.div_ceil(2)))]
    })
}

#[test]
fn calls_allocate_nothing() {
    for (seed, model) in robots() {
        let n = model.nv();
        let State { q, qd, tau, .. } = state(seed, &model);
        let wrenches = vec![Wrench::zero(); model.links().len()];
        for modules in [ModuleTree::links(&model), ModuleTree::chains(&model)] {
            let mut interpreter = Interpreter::<f64>::new(model.clone())
                .eliminating_by(&modules)
                .expect("its own modules");
            let mut poses = vec![Pose::identity(); model.links().len()];
            let (mut a, mut b, mut columns) = (vec![0.0; n], vec![0.0; n], vec![0.0; n * n]);
            let own = model.links()[1].inertial;
            let heavier = Inertial { mass: 2.0 * own.mass, ..own };
            interpreter.set_inertial(1, &own).expect("the description's");
            let (result, allocated) = measure(|| {
                interpreter.forward_dynamics(&q, &qd, &tau, &mut a)?;
                interpreter.inverse_dynamics(&q, &qd, &a, &mut b)?;
                interpreter.bias_forces(&q, &qd, &mut b)?;
                interpreter.gravity_torques(&q, &mut b)?;
                interpreter.mass_matrix(&q, &mut columns)?;
                interpreter.kinetic_energy(&q, &qd)?;
                interpreter.potential_energy(&q)?;
                interpreter.link_poses(&q, &mut poses)?;
                for forces in [Forces::InLinkAxes(&wrenches), Forces::InWorldAxes(&wrenches)] {
                    interpreter.forward_dynamics_external(&q, &qd, &tau, forces, &mut a)?;
                    interpreter.inverse_dynamics_external(&q, &qd, &a, forces, &mut b)?;
                }
                interpreter.set_gravity([0.0, 0.0, -1.62]);
                interpreter.set_inertial(1, &heavier).expect("a body's");
                interpreter.set_payload(1, &own).expect("a body's");
                interpreter.gravity_torques(&[], &mut b).expect_err("wrong length");
                Ok::<_, ShapeError>(())
            });
            assert_eq!(result, Ok(()));
            assert_eq!((allocated.calls, allocated.peak), (0, 0), "seed {seed}");
        }
    }
}

#[test]
fn derivatives_allocate_at_their_first_call_alone() {
    for seed in 0..20 {
        let model = tree(seed, 1 + usize::try_from(seed).expect("small"));
        let square = model.nv() * model.nv();
        let State { q, qd, tau, mut qdd } = state(seed, &model);
        let [mut dq, mut dqd, mut dtau] = [(); 3].map(|()| vec![0.0; square]);
        let wrenches = vec![Wrench::zero(); model.links().len()];
        let mut interpreter = Interpreter::<f64>::new(model);
        let mut derive = || {
            interpreter.inverse_dynamics_derivatives(&q, &qd, &tau, &mut dq, &mut dqd)?;
            let outputs = ForwardDerivatives {
                qdd: &mut qdd,
                dqdd_dq: &mut dq,
                dqdd_dqd: &mut dqd,
                dqdd_dtau: &mut dtau,
            };
            interpreter.forward_dynamics_derivatives(&q, &qd, &tau, outputs)?;
            let forces = Forces::InWorldAxes(&wrenches);
            let motion = Motion { q: &q, qd: &qd, qdd: &tau };
            let input = ForwardInput { q: &q, qd: &qd, tau: &tau };
            interpreter.inverse_dynamics_external_derivatives(motion, forces, &mut dq, &mut dqd)?;
            let outputs = ForwardDerivatives {
                qdd: &mut qdd,
                dqdd_dq: &mut dq,
                dqdd_dqd: &mut dqd,
                dqdd_dtau: &mut dtau,
            };
            interpreter.forward_dynamics_external_derivatives(input, forces, outputs)
        };
        assert_eq!(derive(), Ok(()));
        let (result, allocated) = measure(derive);
        assert_eq!((result, allocated.calls), (Ok(()), 0), "seed {seed}");
    }
}

#[test]
fn the_counter_counts() {
    let (kept, allocated) = measure(|| {
        drop(vec![0u8; 100]);
        vec![0u8; 10]
    });
    assert_eq!(kept.len(), 10);
    assert_eq!((allocated.calls, allocated.kept, allocated.peak), (2, 10, 100));
}

#[test]
fn updating_a_factorization_allocates_nothing() {
    for (_, model) in robots() {
        for modules in [ModuleTree::links(&model), ModuleTree::chains(&model)] {
            let interpreter =
                Interpreter::<f64>::with_modules(model.clone(), modules).expect("its own modules");
            let mut brge = interpreter.brge(&state(1, &model).q).expect("the length is right");
            let q = state(2, &model).q;
            let (result, allocated) = measure(|| brge.update(&interpreter, &q));
            assert_eq!((result, allocated.calls), (Ok(()), 0));
        }
    }
}
