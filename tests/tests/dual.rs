//! Exact derivatives by the interpreter on num-dual's numbers.

use modyn_runtime::Interpreter;
use modyn_runtime::num_dual::{Dual64, DualSVec64};
use modyn_tests::close::assert_close;
use modyn_tests::golden::Golden;

/// Derivatives of inverse dynamics by each coordinate equal the reference data and central differences.
#[test]
fn inverse_dynamics_by_coordinates() {
    for name in ["ur5", "panda_fingers", "solo12"] {
        let golden = Golden::load(name);
        let n = golden.model.nv();
        let mut plain = Interpreter::<f64>::new(golden.model.clone());
        let mut dual = Interpreter::<Dual64>::new(golden.model.clone());
        for state in &golden.states {
            let [q, qd, qdd] = [state.q(), state.vector("v"), state.vector("a")];
            let numbers = |x: &[f64]| x.iter().copied().map(Dual64::from_re).collect::<Vec<_>>();
            let [constant, moving, speeding] = [&q, &qd, &qdd].map(|x| numbers(x));
            for i in 0..n {
                let mut varied = constant.clone();
                varied[i] = varied[i].derivative();
                let mut tau = vec![Dual64::from_re(0.0); n];
                dual.inverse_dynamics(&varied, &moving, &speeding, &mut tau).expect("lengths");
                let found: Vec<f64> = tau.iter().map(|x| x.eps).collect();
                let expected = state.matrix("dtau_dq").column(i).as_slice().to_vec();
                assert_close(name, &found, &expected, 1e-9);

                let mut at = |h: f64| {
                    let mut q = q.clone();
                    q[i] += h;
                    let mut tau = vec![0.0; n];
                    plain.inverse_dynamics(&q, &qd, &qdd, &mut tau).expect("lengths");
                    tau
                };
                let h = 1e-5;
                let differences: Vec<f64> = std::iter::zip(at(h), at(-h))
                    .map(|(above, below)| (above - below) / (2.0 * h))
                    .collect();
                assert_close(name, &found, &differences, 1e-6);
            }
        }
    }
}

/// All columns at once, by numbers with a gradient.
#[test]
fn forward_dynamics_by_torques_is_the_inverse_inertia() {
    const N: usize = 6;
    let golden = Golden::load("ur5");
    let mut interpreter = Interpreter::<DualSVec64<N>>::new(golden.model.clone());
    for state in &golden.states {
        let numbers = |x: Vec<f64>| x.into_iter().map(DualSVec64::from_re).collect::<Vec<_>>();
        let [q, qd, tau] = [state.q(), state.vector("v"), state.vector("tau")].map(numbers);
        let tau: Vec<_> = tau.into_iter().enumerate().map(|(i, x)| x.derivative(i)).collect();
        let mut qdd = vec![DualSVec64::from_re(0.0); N];
        interpreter.forward_dynamics(&q, &qd, &tau, &mut qdd).expect("lengths");
        let expected = state.matrix("dqdd_dtau");
        for (i, x) in qdd.into_iter().enumerate() {
            let row: [f64; N] = x.eps.0.expect("derivatives").into();
            let expected: Vec<f64> = expected.row(i).iter().copied().collect();
            assert_close("dqdd/dtau", &row, &expected, 1e-9);
        }
    }
}
