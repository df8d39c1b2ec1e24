//! Contracted Hessians: the functions and the interpreter against num-dual's numbers through inverse and forward dynamics,
//! against differences along `integrate`.

use modyn_codegen::graph::Graph;
use modyn_codegen::passes::optimize;
use modyn_codegen::plan::COLUMN_LANES;
use modyn_codegen::trace::{Parameters, Tracer};
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::{ForwardInput, Motion};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Inertial, Model, ModuleTree};
use modyn_runtime::num_dual::HyperDual64;
use modyn_runtime::{HessianOutputs, Interpreter};
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along, along_velocity, constant, hessian_blocks};
use modyn_tests::floating::floated;
use modyn_tests::golden;
use modyn_tests::random::{self, Random, State};
use serde_json::Value;

/// A number with two directions.
type Twice = Tangent<Tangent<f64>>;

/// Inverse or forward dynamics.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Dynamics {
    Inverse,
    Forward,
}
use Dynamics::{Forward, Inverse};

/// Returns the value, the gradients and the blocks of the Hessian of w^T f: all numbers of the generated function.
fn interpreted(model: &Model, dynamics: Dynamics, [q, qd, x, w]: [&[f64]; 4]) -> Vec<f64> {
    let n = model.nv();
    let mut vectors = [0; 4].map(|_| vec![0.0; n]);
    let mut matrices = [0; 4].map(|_| vec![0.0; n * n]);
    let [value, dq, dqd, dx] = vectors.each_mut().map(Vec::as_mut_slice);
    let hessian = matrices.each_mut().map(Vec::as_mut_slice);
    let outputs = HessianOutputs { value, gradients: [dq, dqd, dx], hessian };
    let mut interpreter = Interpreter::new(model.clone());
    match dynamics {
        Inverse => interpreter.inverse_dynamics_hessian(Motion { q, qd, qdd: x }, w, outputs),
        Forward => interpreter.forward_dynamics_hessian(ForwardInput { q, qd, tau: x }, w, outputs),
    }
    .expect("fits");
    [vectors.concat(), matrices.concat()].concat()
}

/// Returns the generated function's graph on scalars, or with displacements and columns in lanes. Run-time gravity is an
/// input after all others.
fn graph(model: &Model, dynamics: Dynamics, lanes: bool, gravity: bool) -> Graph {
    let mechanism = Mechanism::new(model);
    let tracer = Tracer::with_parameters(&mechanism, Parameters::new(model, gravity, &[], &[]));
    let tracer = if lanes { tracer.column_lanes(COLUMN_LANES) } else { tracer };
    optimize(match dynamics {
        Inverse => tracer.inverse_dynamics_hessian(),
        Forward => {
            let chains = UduLayout::new(&mechanism, &ModuleTree::chains(model));
            tracer.forward_dynamics_hessian(&chains)
        }
    })
}

/// Returns the same numbers of the generated function's graph.
fn compiled(model: &Model, dynamics: Dynamics, inputs: [&[f64]; 4], lanes: bool) -> Vec<f64> {
    let inputs = [&inputs.concat()[..], &model.gravity()].concat();
    graph(model, dynamics, lanes, true).evaluate::<f64>(&inputs)
}

/// Returns the second derivative of w^T f along entry `a`, then along entry `b`, of q, qd and x.
fn second(
    interpreter: &mut Interpreter<HyperDual64>,
    dynamics: Dynamics,
    [q, qd, x, w]: [&[f64]; 4],
    [a, b]: [usize; 2],
) -> f64 {
    let model = interpreter.model();
    let n = model.nv();
    // The state with derivatives along an entry of the vector `k` (q, qd or x).
    fn moved<S: modyn_runtime::Scalar>(
        model: &Model,
        [q, qd, x]: &[Vec<S>; 3],
        (k, entry): (usize, usize),
    ) -> [Vec<Tangent<S>>; 3] {
        [
            if k == 0 { along_velocity(model, q, entry) } else { constant(q) },
            if k == 1 { along(qd, entry) } else { constant(qd) },
            if k == 2 { along(x, entry) } else { constant(x) },
        ]
    }
    let once = moved(model, &[q.to_vec(), qd.to_vec(), x.to_vec()], (a / n, a % n));
    let twice: [Vec<Twice>; 3] = moved(model, &once, (b / n, b % n));
    let [q, qd, x] = twice.map(|vector| {
        let number = |t: Twice| HyperDual64::new(t.x.x, t.x.dx, t.dx.x, t.dx.dx);
        vector.into_iter().map(number).collect::<Vec<_>>()
    });
    let mut value = vec![HyperDual64::from(0.0); n];
    match dynamics {
        Inverse => interpreter.inverse_dynamics(&q, &qd, &x, &mut value),
        Forward => interpreter.forward_dynamics(&q, &qd, &x, &mut value),
    }
    .expect("fits");
    value.iter().zip(w).map(|(value, w)| value.eps1eps2 * w).sum()
}

/// Returns the blocks of the Hessian by num-dual's numbers; the blocks that are not stored must be zero.
fn expected(model: &Model, dynamics: Dynamics, inputs: [&[f64]; 4]) -> Vec<f64> {
    let n = model.nv();
    let mut interpreter = Interpreter::new(model.clone());
    let entry = |a, b| second(&mut interpreter, dynamics, inputs, [a, b]);
    hessian_blocks(n, entry, 1e-9)
}

/// Returns a joint vector.
fn vector(random: &mut Random, n: usize) -> Vec<f64> {
    (0..n).map(|_| random.between(-1.0, 1.0)).collect()
}

/// Compares the graphs and the interpreter with num-dual's numbers.
fn compare(name: &str, model: &Model, seed: u64) {
    let n = model.nv();
    let State { q, qd, qdd, tau } = random::state(seed, model);
    let w = vector(&mut Random::new(seed), n);
    for (dynamics, x) in [(Inverse, &qdd), (Forward, &tau)] {
        let inputs = [&q[..], &qd, x, &w];
        let expected = expected(model, dynamics, inputs);
        let interpreted = interpreted(model, dynamics, inputs);
        let in_lanes = compiled(model, dynamics, inputs, true);
        let compiled = compiled(model, dynamics, inputs, false);
        let name = format!("{name}, {dynamics:?}");
        assert_close(&format!("{name}: interpreter"), &interpreted[4 * n..], &expected, 1e-8);
        assert_close(&format!("{name}: compiler"), &compiled[4 * n..], &expected, 1e-8);
        assert_close(&format!("{name}: in lanes"), &in_lanes, &compiled, 1e-9);
        // Values and gradients.
        for (k, (own, other)) in compiled[..4 * n].chunks(n).zip(interpreted.chunks(n)).enumerate()
        {
            assert_close(&format!("{name}: vector {k}"), own, other, 1e-8);
        }
    }
}

#[test]
fn hessians_of_random_robots_are_those_of_dual_numbers() {
    let models = (0..24)
        .map(|seed| random::mixed_zoo(seed, 1 + usize::try_from(seed % 5).expect("a digit")));
    random::for_all_kinds(models, |seed, model| compare(&format!("seed {seed}"), model, seed));
}

#[test]
fn hessians_of_floating_robots_are_those_of_dual_numbers() {
    for seed in 0..6 {
        let links = 1 + usize::try_from(seed).expect("a digit");
        let model = floated(&random::mixed_tree(seed, links), Random::new(seed).inertial());
        compare(&format!("floating, seed {seed}"), &model, seed);
    }
    let model = golden::model(&golden::urdf("solo12"));
    compare("solo12, floating", &floated(&model, Inertial::default()), 3);
}

/// The Hessian by q is that of w^T f at coordinates that `integrate` displaces: second differences along displacements.
#[test]
fn hessians_are_those_of_displaced_coordinates() {
    for seed in 0..30 {
        let model = random::general_zoo(seed, 1 + usize::try_from(seed % 5).expect("a digit"));
        let n = model.nv();
        let State { q, qd, tau, .. } = random::state(seed, &model);
        let random = &mut Random::new(seed);
        let [w, displacement] = [0, 1].map(|_| vector(random, n));
        let found = interpreted(&model, Forward, [&q, &qd, &tau, &w]);
        let block = &found[4 * n..][..n * n];
        let product = block.chunks(n).zip(&displacement).flat_map(|(column, x)| {
            column.iter().zip(&displacement).map(move |(entry, y)| entry * x * y)
        });
        let mut interpreter = Interpreter::<f64>::new(model);
        let mut at = |step: f64| -> f64 {
            let v: Vec<f64> = displacement.iter().map(|x| x * step).collect();
            let (mut moved, mut qdd) = (q.clone(), vec![0.0; n]);
            interpreter.integrate(&q, &v, &mut moved).expect("fits");
            interpreter.forward_dynamics(&moved, &qd, &tau, &mut qdd).expect("fits");
            qdd.iter().zip(&w).map(|(x, w)| x * w).sum()
        };
        // Of fourth order.
        let h = 2e-3;
        let difference = (16.0 * (at(h) + at(-h)) - at(2.0 * h) - at(-2.0 * h) - 30.0 * at(0.0))
            / (12.0 * h * h);
        let size = block.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        let product: f64 = product.sum();
        assert!((product - difference).abs() < 1e-4 * size, "{seed}: {product} {difference}");
    }
}

/// Returns the part with this name of a record of the reference data.
fn numbers(record: &Value, name: &str) -> Vec<f64> {
    let numbers = record[name].as_array().unwrap_or_else(|| panic!("no {name}"));
    numbers.iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// The reference data are `CasADi`'s exact Hessians of other equations.
#[test]
fn hessians_are_those_of_the_reference_data() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/hessians.json");
    let text = std::fs::read_to_string(path).expect("the file");
    let data: Value = serde_json::from_str(&text).expect("JSON");
    let model = golden::model(&golden::urdf("hessians"));
    let states = data["states"].as_array().expect("states");
    assert_eq!(states.len(), 3);
    for state in states {
        let [q, v, a, tau, w] = ["q", "v", "a", "tau", "w"].map(|name| numbers(state, name));
        for (dynamics, name, x) in [(Inverse, "inverse", &a), (Forward, "forward", &tau)] {
            let n = v.len();
            let inputs = [&q[..], &v, x, &w];
            let parts = ["value", "gradient", "dq_dq", "dq_dqd", "dqd_dqd", "dq_dx"];
            let expected = parts.map(|part| numbers(&state[name], part)).concat();
            for (who, found) in [
                ("interpreter", interpreted(&model, dynamics, inputs)),
                ("compiler", compiled(&model, dynamics, inputs, false)),
                ("compiler, in lanes", compiled(&model, dynamics, inputs, true)),
            ] {
                assert_close(&format!("{name}: {who}"), &found[..n], &expected[..n], 1e-9);
                assert_close(&format!("{name}: {who}"), &found, &expected, 1e-9);
            }
        }
    }
}
