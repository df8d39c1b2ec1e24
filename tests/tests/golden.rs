//! The interpreter compared with reference data of other software, on fixed and floating bases.

use modyn_runtime::model::{Model, ModuleTree, PARAMETERS_PER_LINK};
use modyn_runtime::spatial::{Momentum, Twist, Vector3};
use modyn_runtime::{Forces, ForwardDerivatives, Interpreter};
use modyn_tests::close::assert_close;
use modyn_tests::golden::{
    FIXED_BASE, FLOATING_BASE, GENERAL_TREES, Golden, Quantities as Expected,
};
use modyn_tests::quantities::{Quantities, numbers};

/// The tolerance that the reference data's README gives.
const TOLERANCE: f64 = 1e-9;

/// Runs `check` at every state of every robot.
fn everywhere(check: impl Fn(&str, &Model, &Expected)) {
    let mut states = 0;
    for name in FIXED_BASE.into_iter().chain(FLOATING_BASE).chain(GENERAL_TREES) {
        let golden = Golden::load(name);
        for state in &golden.states {
            check(name, &golden.model, state);
            states += 1;
        }
    }
    assert_eq!(states, 47 + 8 + 6, "the states of all robots");
}

fn moving(state: &Expected) -> (Vec<f64>, Vec<f64>) {
    (state.q(), state.vector("v"))
}

#[test]
fn forward_dynamics_by_any_modules() {
    everywhere(|name, model, state| {
        let (q, qd) = moving(state);
        for modules in [ModuleTree::links(model), ModuleTree::chains(model)] {
            let mut interpreter =
                Interpreter::new(model.clone()).eliminating_by(&modules).expect("its own modules");
            let qdd = interpreter.qdd(&q, &qd, &state.vector("tau"));
            assert_close(name, &qdd, &state.vector("qdd"), TOLERANCE);
        }
    });
}

#[test]
fn inverse_dynamics() {
    everywhere(|name, model, state| {
        let (q, qd) = moving(state);
        let tau = Interpreter::new(model.clone()).tau(&q, &qd, &state.vector("a"));
        assert_close(name, &tau, &state.vector("tau_rnea"), TOLERANCE);
    });
}

#[test]
fn bias_forces_and_gravity_torques() {
    everywhere(|name, model, state| {
        let (q, qd) = moving(state);
        let mut interpreter = Interpreter::new(model.clone());
        assert_close(name, &interpreter.bias(&q, &qd), &state.vector("nle"), TOLERANCE);
        assert_close(name, &interpreter.gravity(&q), &state.vector("gravity_tau"), TOLERANCE);
    });
}

#[test]
fn mass_matrix() {
    everywhere(|name, model, state| {
        let mass_matrix = Interpreter::new(model.clone()).dense_mass_matrix(&state.q());
        assert_close(name, &mass_matrix, state.matrix("M").as_slice(), TOLERANCE);
    });
}

#[test]
fn energies() {
    everywhere(|name, model, state| {
        let (q, qd) = moving(state);
        let mut interpreter = Interpreter::new(model.clone());
        let found = [interpreter.kinetic(&q, &qd), interpreter.potential(&q)];
        let expected = [state.number("kinetic_energy"), state.number("potential_energy")];
        assert_close(name, &found[..1], &expected[..1], TOLERANCE);
        assert_close(name, &found[1..], &expected[1..], TOLERANCE);
    });
}

#[test]
fn frame_placements() {
    everywhere(|name, model, state| {
        let poses = Interpreter::new(model.clone()).poses(&state.q());
        let frames = state.frames();
        assert!(!frames.is_empty(), "{name}");
        for expected in frames {
            let at = model.links().iter().position(|link| link.name == expected.name);
            let at = at.unwrap_or_else(|| panic!("{name}: no frame `{}`", expected.name));
            assert_close(&expected.name, &numbers(&poses[at]), &expected.numbers, TOLERANCE);
        }
    });
}

#[test]
fn factorization_solves_and_inverts() {
    everywhere(|name, model, state| {
        let expected = state.matrix("dqdd_dtau");
        for modules in [ModuleTree::links(model), ModuleTree::chains(model)] {
            let interpreter =
                Interpreter::with_modules(model.clone(), modules).expect("its own modules");
            let brge = interpreter.factors(&state.q());
            assert_close(name, &brge.inverse(), expected.as_slice(), TOLERANCE);
            let excess: Vec<f64> = std::iter::zip(state.vector("tau"), state.vector("nle"))
                .map(|(tau, bias)| tau - bias)
                .collect();
            let qdd = brge.solve(&excess).expect("the length is right");
            assert_close(name, &qdd, &state.vector("qdd"), TOLERANCE);
        }
    });
}

#[test]
fn single_precision_is_as_good_as_it_can_be() {
    everywhere(|name, model, state| {
        #[allow(clippy::cast_possible_truncation)]
        let single = |x: Vec<f64>| -> Vec<f32> { x.into_iter().map(|x| x as f32).collect() };
        let double = |x: Vec<f32>| -> Vec<f64> { x.into_iter().map(f64::from).collect() };
        let mut interpreter = Interpreter::<f32>::new(model.clone());
        let (q, qd) = (single(state.q()), single(state.vector("v")));
        let tau = interpreter.tau(&q, &qd, &single(state.vector("a")));
        assert_close(name, &double(tau), &state.vector("tau_rnea"), 1e-5);
        let mass_matrix = double(interpreter.dense_mass_matrix(&q));
        assert_close(name, &mass_matrix, state.matrix("M").as_slice(), 1e-5);
    });
}

#[test]
fn external_forces() {
    everywhere(|name, model, state| {
        let (q, qd) = moving(state);
        let wrenches = state.wrenches(model);
        assert!(wrenches.iter().any(|wrench| wrench.components() != [0.0; 6]), "{name}: no force");
        let forces = Forces::InLinkAxes(&wrenches);
        let mut interpreter = Interpreter::new(model.clone());
        let qdd = interpreter.qdd_under(&q, &qd, &state.vector("tau"), forces);
        assert_close(name, &qdd, &state.vector("qdd_ext"), TOLERANCE);
        let tau = interpreter.tau_under(&q, &qd, &state.vector("a"), forces);
        assert_close(name, &tau, &state.vector("tau_ext"), TOLERANCE);
    });
}

#[test]
fn center_of_mass_and_its_jacobian() {
    everywhere(|name, model, state| {
        let q = state.q();
        let mut interpreter = Interpreter::new(model.clone());
        let found = interpreter.center_of_mass(&q).expect("the length is right");
        assert_close(name, &found, &state.position("com"), TOLERANCE);
        let mut columns = vec![Vector3::zero(); model.nv()];
        interpreter.center_of_mass_jacobian(&q, &mut columns).expect("the lengths are right");
        let found: Vec<f64> = columns.iter().flat_map(|column| column.0).collect();
        let mass: f64 = model.moving_links().iter().map(|link| link.inertial.mass).sum();
        let expected = state.centroidal_momentum_matrix().rows(0, 3) / mass;
        assert_close(name, &found, expected.as_slice(), TOLERANCE);
    });
}

#[test]
fn centroidal_momentum_and_its_matrix() {
    everywhere(|name, model, state| {
        let (q, qd) = moving(state);
        let mut interpreter = Interpreter::new(model.clone());
        let found = interpreter.centroidal_momentum(&q, &qd).expect("the lengths are right");
        assert_close(name, &found.components(), &state.centroidal_momentum(), TOLERANCE);
        let mut columns = vec![Momentum::zero(); model.nv()];
        interpreter.centroidal_momentum_matrix(&q, &mut columns).expect("the lengths are right");
        let found: Vec<f64> = columns.iter().flat_map(|column| column.components()).collect();
        let expected = state.centroidal_momentum_matrix();
        assert_close(name, &found, expected.as_slice(), TOLERANCE);
    });
}

#[test]
fn regressors() {
    let compared = std::cell::Cell::new(0);
    everywhere(|name, model, state| {
        let Some(expected) = state.regressor() else { return };
        let (q, qd) = moving(state);
        let mut found = vec![0.0; model.nv() * PARAMETERS_PER_LINK * model.moving_links().len()];
        let mut interpreter = Interpreter::new(model.clone());
        let called = interpreter.regressor(&q, &qd, &state.vector("a"), &mut found);
        called.expect("the lengths are right");
        assert_close(name, &found, expected.as_slice(), TOLERANCE);
        compared.set(compared.get() + 1);
    });
    assert_eq!(compared.get(), 5 + 3, "short robots and the trees");
}

#[test]
fn derivatives() {
    everywhere(|name, model, state| {
        let (q, qd) = moving(state);
        let n = model.nv();
        let mut interpreter = Interpreter::new(model.clone());
        let [mut by_q, mut by_qd] = [vec![0.0; n * n], vec![0.0; n * n]];
        let called = interpreter.inverse_dynamics_derivatives(
            &q,
            &qd,
            &state.vector("a"),
            &mut by_q,
            &mut by_qd,
        );
        called.expect("the lengths are right");
        assert_close(name, &by_q, state.matrix("dtau_dq").as_slice(), TOLERANCE);
        assert_close(name, &by_qd, state.matrix("dtau_dv").as_slice(), TOLERANCE);
        let mut qdd = vec![0.0; n];
        let [mut by_q, mut by_qd, mut by_tau] = [(); 3].map(|()| vec![0.0; n * n]);
        let outputs = ForwardDerivatives {
            qdd: &mut qdd,
            dqdd_dq: &mut by_q,
            dqdd_dqd: &mut by_qd,
            dqdd_dtau: &mut by_tau,
        };
        let called =
            interpreter.forward_dynamics_derivatives(&q, &qd, &state.vector("tau"), outputs);
        called.expect("the lengths are right");
        assert_close(name, &qdd, &state.vector("qdd"), TOLERANCE);
        assert_close(name, &by_q, state.matrix("dqdd_dq").as_slice(), TOLERANCE);
        assert_close(name, &by_qd, state.matrix("dqdd_dv").as_slice(), TOLERANCE);
        assert_close(name, &by_tau, state.matrix("dqdd_dtau").as_slice(), TOLERANCE);
    });
}

#[test]
fn jacobians() {
    everywhere(|name, model, state| {
        let mut interpreter = Interpreter::new(model.clone());
        for expected in state.frames() {
            let at = model.links().iter().position(|link| link.name == expected.name);
            let at = at.unwrap_or_else(|| panic!("{name}: no frame `{}`", expected.name));
            let mut columns = vec![Twist::zero(); model.nv()];
            interpreter.jacobian(&state.q(), at, &mut columns).expect("the lengths are right");
            let found: Vec<f64> = columns.iter().flat_map(Twist::components).collect();
            assert_close(&expected.name, &found, expected.jacobian.as_slice(), TOLERANCE);
        }
    });
}
