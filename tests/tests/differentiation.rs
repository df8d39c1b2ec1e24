//! Products with derivatives: the passes against dual numbers on random graphs, the functions against the matrices of the
//! interpreter on random robots.

use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::passes::{jvp, optimize, vjp};
use modyn_codegen::trace::{Parameters, Tracer};
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::equations::{ForwardInput, Motion};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Inertial, Model, ModuleTree};
use modyn_runtime::{Interpreter, Scalar};
use modyn_tests::close::assert_close;
use modyn_tests::dual::Tangent;
use modyn_tests::floating::floated;
use modyn_tests::golden;
use modyn_tests::random::{self, Random, State};

const INPUTS: usize = 5;
/// The inputs by which graphs are differentiated.
const WRT: std::ops::Range<usize> = 1..4;

/// Runs a program of random operations of every kind, which is the same for each scalar.
fn program<S: Scalar>(seed: u64, inputs: &[S]) -> Vec<S> {
    let random = &mut Random::new(seed);
    let mut values: Vec<S> = inputs.to_vec();
    values.extend([0.0, 1.0, 2.0, -0.5].map(S::from_f64));
    for _ in 0..40 {
        let mut pick = |count: usize| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let picked = random.between(0.0, 1e6) as usize;
            picked % count
        };
        let (a, b) = (values[pick(values.len())], values[pick(values.len())]);
        let positive = a * a + S::from_f64(0.3);
        let (sin, cos) = a.sin_cos();
        let value = match pick(15) {
            0 => a + b,
            1 => a - b,
            2..=4 => a * b,
            5 => -a,
            6 => a.sin_cos().0 * b + b.sin_cos().1,
            7 => positive.recip(),
            8 => a.atan2(b * b + S::from_f64(0.2)),
            9 => positive.sqrt(),
            10 => positive.ln(),
            11 => a.abs().max(b),
            // Both components of a rotated vector.
            12 => {
                values.push(cos * b - sin * positive);
                sin * b + cos * positive
            }
            13 => {
                values.push(sin * b + cos * positive);
                sin * positive - cos * b
            }
            _ => a.select_nonnegative(b, a * b),
        };
        // Bounded, so that rounding errors stay small.
        values.push(value.sin_cos().0);
    }
    values.split_off(values.len() - 6)
}

#[test]
fn products_of_random_graphs_are_those_of_dual_numbers() {
    let mut nonzero = 0;
    for seed in 0..500 {
        let graph = Graph::trace(|| {
            let inputs: Vec<Expr> = (0..INPUTS).map(Expr::input).collect();
            program(seed, &inputs)
        });
        let random = &mut Random::new(seed + 1000);
        let mut numbers =
            |count: usize| (0..count).map(|_| random.between(-1.5, 1.5)).collect::<Vec<f64>>();
        let (point, change, weights) = (numbers(INPUTS), numbers(WRT.len()), numbers(6));
        let dual: Vec<Tangent<f64>> = (0..INPUTS)
            .map(|k| Tangent {
                x: point[k],
                dx: if WRT.contains(&k) { change[k - 1] } else { 0.0 },
            })
            .collect();
        let expected: Vec<f64> = program(seed, &dual).into_iter().map(|x| x.dx).collect();
        let forward = optimize(jvp(&graph, INPUTS, WRT));
        let found = forward.evaluate::<f64>(&[&*point, &change].concat());
        assert_close(&format!("changes, seed {seed}"), &found, &expected, 1e-11);
        let backward = optimize(vjp(&graph, INPUTS, WRT));
        let gradient = backward.evaluate::<f64>(&[&*point, &weights].concat());
        let product: f64 = gradient.iter().zip(&change).map(|(g, dx)| g * dx).sum();
        let weighted: f64 = weights.iter().zip(&expected).map(|(w, dy)| w * dy).sum();
        assert_close(&format!("gradient, seed {seed}"), &[product], &[weighted], 1e-11);
        nonzero += usize::from(weighted != 0.0);
    }
    assert!(nonzero > 400, "{nonzero} programs depend on these inputs");
}

/// Returns a joint vector.
fn vector(random: &mut Random, n: usize) -> Vec<f64> {
    (0..n).map(|_| random.between(-1.0, 1.0)).collect()
}

/// Compares the graphs of all products with the interpreter, which multiplies matrices.
fn compare(name: &str, model: &Model, seed: u64) {
    let n = model.nv();
    let State { q, qd, qdd, tau } = random::state(seed, model);
    let random = &mut Random::new(seed);
    let [cotangent, dq, dqd, du] = [0, 1, 2, 3].map(|_| vector(random, n));
    let mut interpreter = Interpreter::new(model.clone());
    let mechanism = Mechanism::new(model);
    // Run-time gravity is an input after all others.
    let tracer = Tracer::with_parameters(&mechanism, Parameters::new(model, true, &[], &[]));
    let forward = optimize(
        tracer.forward_dynamics(&Elimination::new(&mechanism, &ModuleTree::chains(model))),
    );
    let evaluate = |graph: Graph, groups: &[&[f64]]| {
        optimize(graph).evaluate::<f64>(&[&groups.concat()[..], &model.gravity()].concat())
    };
    let (mut value, mut change) = (vec![0.0; n], vec![0.0; n]);
    let mut gradients = [0, 1, 2].map(|_| vec![0.0; n]);
    let into = gradients.each_mut().map(Vec::as_mut_slice);
    interpreter
        .inverse_dynamics_vjp(Motion { q: &q, qd: &qd, qdd: &qdd }, &cotangent, &mut value, into)
        .expect("fits");
    let found = evaluate(tracer.inverse_dynamics_vjp(), &[&q, &qd, &qdd, &cotangent]);
    let expected = [&value[..], &gradients.concat()].concat();
    assert_close(&format!("{name}: inverse_dynamics_vjp"), &found, &expected, 1e-9);
    let into = gradients.each_mut().map(Vec::as_mut_slice);
    interpreter
        .forward_dynamics_vjp(
            ForwardInput { q: &q, qd: &qd, tau: &tau },
            &cotangent,
            &mut value,
            into,
        )
        .expect("fits");
    let found = evaluate(tracer.forward_dynamics_vjp(&forward), &[&q, &qd, &tau, &cotangent]);
    let expected = [&value[..], &gradients.concat()].concat();
    assert_close(&format!("{name}: forward_dynamics_vjp"), &found, &expected, 1e-8);
    let changes = [&*dq, &*dqd, &*du];
    interpreter
        .inverse_dynamics_jvp(
            Motion { q: &q, qd: &qd, qdd: &qdd },
            changes,
            &mut value,
            &mut change,
        )
        .expect("fits");
    let found = evaluate(tracer.inverse_dynamics_jvp(), &[&q, &qd, &qdd, &dq, &dqd, &du]);
    let expected = [&*value, &change].concat();
    assert_close(&format!("{name}: inverse_dynamics_jvp"), &found, &expected, 1e-9);
    interpreter
        .forward_dynamics_jvp(
            ForwardInput { q: &q, qd: &qd, tau: &tau },
            changes,
            &mut value,
            &mut change,
        )
        .expect("fits");
    let found = evaluate(tracer.forward_dynamics_jvp(&forward), &[&q, &qd, &tau, &dq, &dqd, &du]);
    let expected = [&*value, &change].concat();
    assert_close(&format!("{name}: forward_dynamics_jvp"), &found, &expected, 1e-8);
}

#[test]
fn products_of_random_robots_are_those_of_the_matrices() {
    let models = (0..60)
        .map(|seed| random::mixed_zoo(seed, 1 + usize::try_from(seed % 8).expect("a digit")));
    random::for_all_kinds(models, |seed, model| compare(&format!("seed {seed}"), model, seed));
}

#[test]
fn products_of_floating_robots_are_those_of_the_matrices() {
    let model = golden::model(&golden::urdf("solo12"));
    compare("solo12, floating", &floated(&model, Inertial::default()), 3);
}
