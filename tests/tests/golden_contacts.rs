//! Contacts of floating robots against Pinocchio's `constraintDynamics`, `impulseDynamics` and
//! `computeConstraintDynamicsDerivatives`: see the reference data's README for the proximal settings.

use modyn_runtime::equations::constraints::{ConstrainedOutputs, ImpulseOutputs};
use modyn_runtime::equations::{ForwardInput, State};
use modyn_runtime::model::Model;
use modyn_runtime::spatial::{Twist, Wrench};
use modyn_runtime::{ConstrainedDerivatives, ConstraintSettings, ContactTarget, Interpreter};
use modyn_tests::close::assert_close;
use modyn_tests::golden::{CONTACTS, Golden, Quantities};
use nalgebra::DMatrix;

/// Of the reference data's README.
const TOLERANCE: f64 = 1e-9;
const DERIVATIVE_TOLERANCE: f64 = 1e-8;

type Settings = ConstraintSettings<f64, Vec<ContactTarget<f64>>>;

/// Returns settings without stabilization.
fn settings(model: &Model, restitution: f64) -> Settings {
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::EXACT;
    let target = ContactTarget { restitution, ..ContactTarget::<f64>::EXACT };
    let targets = vec![target; model.contacts().len()];
    ConstraintSettings { alpha, beta, tolerance, rounding, targets }
}

fn components(wrenches: &[Wrench<f64>]) -> Vec<f64> {
    wrenches.iter().flat_map(Wrench::components).collect()
}

/// Calls `each` with the model, a state, its active contacts and a description of both.
fn for_all_states(each: impl Fn(&Model, &Quantities, &[bool], &str)) {
    for name in CONTACTS {
        let golden = Golden::load(name);
        assert!(golden.states.len() > 2, "{name}");
        for state in &golden.states {
            let active = state.active(&golden.model);
            assert!(active.contains(&true), "{name}");
            each(&golden.model, state, &active, &format!("{name}, {active:?}"));
        }
    }
}

/// Returns the number of rows of the active contacts, which are independent in all states.
fn active_rows(model: &Model, active: &[bool]) -> f64 {
    let rows = model.contacts().iter().zip(active).filter(|(_, active)| **active);
    let rows: usize = rows.map(|(contact, _)| contact.kind.rows()).sum();
    f64::from(u32::try_from(rows).expect("few rows"))
}

#[test]
fn accelerations_and_wrenches() {
    for_all_states(|model, state, active, what| {
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let count = model.contacts().len();
        let mut qdd = vec![0.0; model.nv()];
        let (mut wrenches, mut residuals) =
            (vec![Wrench::zero(); count], vec![Twist::zero(); count]);
        let called = interpreter.constrained_forward_dynamics(
            ForwardInput { q: &state.q(), qd: &state.vector("v"), tau: &state.vector("tau") },
            active,
            &settings(model, 0.0),
            ConstrainedOutputs {
                qdd: &mut qdd,
                wrenches: &mut wrenches,
                residuals: &mut residuals,
            },
        );
        assert_eq!(called, Ok(active_rows(model, active)), "{what}");
        assert_close(what, &qdd, &state.vector("qdd"), TOLERANCE);
        let expected = components(&state.contact_wrenches(model, "forces"));
        assert_close(what, &components(&wrenches), &expected, TOLERANCE);
    });
}

#[test]
fn impulses_with_and_without_restitution() {
    let names =
        [("before", "after", "impulses", 0.0), ("falling", "bounced", "bounce_impulses", 0.3)];
    for (before, after, impulses, restitution) in names {
        for_all_states(|model, state, active, what| {
            let mut interpreter = Interpreter::<f64>::new(model.clone());
            let mut found = vec![0.0; model.nv()];
            let mut wrenches = vec![Wrench::zero(); model.contacts().len()];
            let called = interpreter.impact_dynamics(
                State { q: &state.q(), qd: &state.vector(before) },
                active,
                &settings(model, restitution),
                ImpulseOutputs { qd: &mut found, impulses: &mut wrenches },
            );
            assert_eq!(called, Ok(active_rows(model, active)), "{what}");
            assert_close(what, &found, &state.vector(after), TOLERANCE);
            let expected = components(&state.contact_wrenches(model, impulses));
            assert_close(what, &components(&wrenches), &expected, TOLERANCE);
        });
    }
}

#[test]
fn derivatives_of_accelerations_and_wrenches() {
    for_all_states(|model, state, active, what| {
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let (n, count) = (model.nv(), model.contacts().len());
        let (mut qdd, mut wrenches) = (vec![0.0; n], vec![Wrench::zero(); count]);
        let mut matrices = [0; 3].map(|_| vec![0.0; n * n]);
        let mut changes = [0; 3].map(|_| vec![Wrench::zero(); n * count]);
        let outputs =
            ConstrainedDerivatives::new(&mut qdd, &mut wrenches, &mut matrices, &mut changes);
        let called = interpreter.constrained_forward_dynamics_derivatives(
            ForwardInput { q: &state.q(), qd: &state.vector("v"), tau: &state.vector("tau") },
            active,
            &settings(model, 0.0),
            outputs,
        );
        assert_eq!(called, Ok(active_rows(model, active)), "{what}");
        for (by, (matrix, change)) in
            ["q", "v", "tau"].into_iter().zip(matrices.iter().zip(&changes))
        {
            let expected: DMatrix<f64> = state.matrix(&format!("dqdd_d{by}"));
            let what = format!("{what}, by {by}");
            assert_close(&what, matrix, expected.as_slice(), DERIVATIVE_TOLERANCE);
            let expected = state.wrench_derivatives(model, &format!("dforces_d{by}"));
            assert_close(&what, &components(change), &components(&expected), DERIVATIVE_TOLERANCE);
        }
    });
}
