//! Inertias and gravity changed at run time: the interpreter then equals an interpreter made for the changed model.

use std::iter::zip;

use modyn_runtime::model::{Inertial, InertialDefect};
use modyn_runtime::spatial::{Vector3, Wrench};
use modyn_runtime::{Forces, InertialError, Interpreter};
use modyn_tests::cases::{cases, robots};
use modyn_tests::changed::changed;
use modyn_tests::close::assert_close;
use modyn_tests::dense::square;
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{Random, State, state};
use proptest::prelude::*;

/// Asserts that both interpreters have the same dynamics.
fn assert_same(changed: &mut Interpreter<f64>, fresh: &mut Interpreter<f64>, state: &State) {
    let State { q, qd, qdd, tau } = state;
    let close = |what, found: &[f64], expected: &[f64]| assert_close(what, found, expected, 1e-12);
    close("torques", &changed.tau(q, qd, qdd), &fresh.tau(q, qd, qdd));
    close("bias forces", &changed.bias(q, qd), &fresh.bias(q, qd));
    close("gravity", &changed.gravity(q), &fresh.gravity(q));
    close("mass matrix", &changed.dense_mass_matrix(q), &fresh.dense_mass_matrix(q));
    close("T", &[changed.kinetic(q, qd)], &[fresh.kinetic(q, qd)]);
    close("V", &[changed.potential(q)], &[fresh.potential(q)]);
    let [found, expected] = [&mut *changed, &mut *fresh].map(|i| i.denoc(q).expect("lengths"));
    close("masses", &found.mass.entries, &expected.mass.entries);
    let (found, expected) = (changed.qdd(q, qd, tau), fresh.qdd(q, qd, tau));
    let condition = square(&fresh.dense_mass_matrix(q)).amax();
    assert_close("accelerations", &found, &expected, 1e-10 * condition.max(1.0));
    let back = fresh.tau(q, qd, &found);
    let scale = found.iter().fold(condition, |scale: f64, x| scale.max(x.abs() * condition));
    assert_close("torques again", &back, tau, 1e-11 * scale.max(1.0));
    let (found, expected) = (changed.factors(q).solve(tau), fresh.factors(q).solve(tau));
    let (found, expected) = (found.expect("lengths"), expected.expect("lengths"));
    assert_close("solution", &found, &expected, 1e-10 * condition.max(1.0));
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn inertias_one_after_the_other(robot in robots(12)) {
        let mut model = robot.model();
        let made_for = model.clone();
        let state = state(robot.seed(), &model);
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let mut random = Random::new(robot.seed());
        for _ in 0..6 {
            // Frames that are fixed to links or to the world are changed, too.
            let at = random.below(model.links().len());
            let inertial = random.inertial();
            model = changed(&model, at, inertial);
            interpreter.set_inertial(at, &inertial).expect("a body's");
            assert_same(&mut interpreter, &mut Interpreter::new(model.clone()), &state);
        }
        prop_assert_eq!(interpreter.model(), &made_for);
        // The described inertias give the described robot again.
        for (at, frame) in made_for.links().iter().enumerate() {
            interpreter.set_inertial(at, &frame.inertial).expect("a body's");
        }
        assert_same(&mut interpreter, &mut Interpreter::new(made_for), &state);
    }

    #[test]
    fn gravity(robot in robots(12)) {
        let model = robot.model();
        let state = state(robot.seed(), &model);
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        for gravity in [[0.0, 0.0, -1.62], [1.0, -2.0, 3.0], [0.0; 3]] {
            let other = model.clone().with_gravity(gravity).expect("finite");
            interpreter.set_gravity(gravity);
            assert_same(&mut interpreter, &mut Interpreter::new(other), &state);
        }
        // The links' weights, given as external forces, replace gravity.
        let factors = model.gravity_compensation().iter().copied().chain(std::iter::repeat(0.0));
        let weights: Vec<_> = zip(zip(model.links(), factors), interpreter.poses(&state.q))
            .map(|((frame, compensated), pose)| {
                let lever = Vector3(pose.rotate(frame.inertial.center_of_mass));
                let force = Vector3(model.gravity()).scale((1.0 - compensated) * frame.inertial.mass);
                Wrench { moment: lever.cross(force), force }
            })
            .collect();
        let State { q, qd, qdd, .. } = &state;
        let found = interpreter.tau_under(q, qd, qdd, Forces::InWorldAxes(&weights));
        let expected = Interpreter::new(model).tau(q, qd, qdd);
        assert_close("torques", &found, &expected, 1e-10);
    }

    #[test]
    fn nothing_changes_where_a_change_is_refused(robot in robots(8)) {
        let model = robot.model();
        let State { q, qd, qdd, .. } = state(robot.seed(), &model);
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let expected = interpreter.tau(&q, &qd, &qdd);
        let count = model.links().len();
        let good = Random::new(robot.seed()).inertial();
        let refused = |interpreter: &mut Interpreter<f64>, frame, inertial: &Inertial| {
            let error = interpreter.set_inertial(frame, inertial).expect_err("refused");
            assert!(!error.to_string().is_empty());
            error
        };
        let error = refused(&mut interpreter, count, &good);
        prop_assert_eq!(error, InertialError::NoLink { link: count, count });
        for frame in 0..count {
            let error = refused(&mut interpreter, frame, &Inertial { mass: -1.0, ..good });
            prop_assert_eq!(error, InertialError::Defect(InertialDefect::NegativeMass(-1.0)));
            let nowhere = Inertial { center_of_mass: [0.0, f64::NAN, 0.0], ..good };
            prop_assert_eq!(refused(&mut interpreter, frame, &nowhere), InertialError::Defect(InertialDefect::NotFinite));
            let endless = Inertial { mass: f64::INFINITY, ..good };
            prop_assert_eq!(refused(&mut interpreter, frame, &endless), InertialError::Defect(InertialDefect::NotFinite));
        }
        prop_assert_eq!(interpreter.tau(&q, &qd, &qdd), expected);
    }
}
