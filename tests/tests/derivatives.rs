//! Derivatives of inverse and forward dynamics: against figures from other software, against
//! tangents of the dynamics themselves, and what they cost.

use std::fs;

use modyn_codegen::expr::{Expr, Graph};
use modyn_codegen::passes::optimize;
use modyn_codegen::trace::Tracer;
use modyn_runtime::equations::brge::Layout;
use modyn_runtime::equations::{Workspace, inverse_dynamics};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::prepare::Prepared;
use modyn_runtime::model::{Drive, Friction, Inertial, Mimic, Model, ModuleTree};
use modyn_runtime::{ForwardDerivatives, Interpreter, Scalar};
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along, along_velocity, constant};
use modyn_tests::floating::floated;
use modyn_tests::golden::{self, FIXED_BASE, Golden};
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{self, Random};
use serde_json::Value;

/// Of the reference data's README.
const TOLERANCE: f64 = 1e-9;

/// The torques' derivatives by q and by qd.
fn inverse(interpreter: &mut Interpreter, [q, qd, qdd]: [&[f64]; 3]) -> [Vec<f64>; 2] {
    let square = interpreter.model().nv().pow(2);
    let (mut dq, mut dqd) = (vec![0.0; square], vec![0.0; square]);
    let found = interpreter.inverse_dynamics_derivatives(q, qd, qdd, &mut dq, &mut dqd);
    found.expect("the lengths are right");
    [dq, dqd]
}

/// The accelerations and their derivatives by q, qd and tau.
fn forward(interpreter: &mut Interpreter, [q, qd, tau]: [&[f64]; 3]) -> [Vec<f64>; 4] {
    let n = interpreter.model().nv();
    let mut found = [n, n * n, n * n, n * n].map(|length| vec![f64::NAN; length]);
    let [qdd, dqdd_dq, dqdd_dqd, dqdd_dtau] = &mut found;
    let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
    interpreter.forward_dynamics_derivatives(q, qd, tau, outputs).expect("the lengths are right");
    found
}

/// The robots of the reference data that also float.
const FLOATING_BASE: [&str; 2] = ["solo12", "g1"];

/// A robot on a floating base: its model, its states, and where these have the model's velocities.
fn floating(name: &str) -> (Model, Vec<Value>, Vec<usize>) {
    let fixed = golden::urdf(name);
    let model = floated(&golden::model(&fixed), Inertial::default());
    let text = fs::read_to_string(fixed.with_file_name(format!("{name}_ff.json")));
    let mut data: Value =
        serde_json::from_str(&text.expect("reference data")).expect("reference data is JSON");
    let joints: Vec<&str> =
        data["joint_order"].as_array().expect("joints").iter().filter_map(Value::as_str).collect();
    let joints: Vec<&str> = joints
        .into_iter()
        .filter(|joint| model.links()[1..].iter().any(|link| link.joint.name == *joint))
        .collect();
    let find = |joint: &str| joints.iter().position(|other| *other == joint).expect("its joint");
    let order = model.links()[1..].iter().map(|link| 6 + find(&link.joint.name));
    let order = (0..6).chain(order).collect();
    let Value::Array(states) = data["states"].take() else { panic!("{name}: states") };
    (model, states, order)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[test]
fn reference_data_on_a_fixed_base() {
    let mut states = 0;
    for name in FIXED_BASE {
        let golden = Golden::load(name);
        let mut interpreter = Interpreter::new(golden.model.clone());
        for state in &golden.states {
            let close = |found: &[f64], expected: &str| {
                let reference = state.matrix(expected);
                assert_close(&format!("{name} {expected}"), found, reference.as_slice(), TOLERANCE);
            };
            let (q, qd) = (state.q(), state.vector("v"));
            let [dq, dqd] = inverse(&mut interpreter, [&q, &qd, &state.vector("a")]);
            close(&dq, "dtau_dq");
            close(&dqd, "dtau_dv");
            let [qdd, dq, dqd, dtau] = forward(&mut interpreter, [&q, &qd, &state.vector("tau")]);
            assert_close(name, &qdd, &state.vector("qdd"), TOLERANCE);
            close(&dq, "dqdd_dq");
            close(&dqd, "dqdd_dv");
            close(&dtau, "dqdd_dtau");
            states += 1;
        }
    }
    assert_eq!(states, 47, "the states of all robots");
}

#[test]
fn reference_data_on_a_floating_base() {
    for name in FLOATING_BASE {
        let (model, states, order) = floating(name);
        assert!(!states.is_empty(), "{name}");
        let mut interpreter = Interpreter::new(model);
        for state in states {
            let vector = |what: &str| -> Vec<f64> {
                let all = numbers(&state[what]);
                order.iter().map(|&k| all[k]).collect()
            };
            let close = |found: &[f64], expected: &str| {
                let rows: Vec<Vec<f64>> =
                    state[expected].as_array().expect("rows").iter().map(numbers).collect();
                let columns: Vec<f64> = order
                    .iter()
                    .flat_map(|&column| order.iter().map(move |&row| (row, column)))
                    .map(|(row, column)| rows[row][column])
                    .collect();
                assert_close(&format!("{name} {expected}"), found, &columns, TOLERANCE);
            };
            let angles = numbers(&state["q_angle"]);
            let mut q = numbers(&state["q"])[..7].to_vec();
            q.extend(order[6..].iter().map(|&k| angles[k - 6]));
            let qd = vector("v");
            let [dq, dqd] = inverse(&mut interpreter, [&q, &qd, &vector("a")]);
            close(&dq, "dtau_dq");
            close(&dqd, "dtau_dv");
            let [qdd, dq, dqd, dtau] = forward(&mut interpreter, [&q, &qd, &vector("tau")]);
            assert_close(name, &qdd, &vector("qdd"), TOLERANCE);
            close(&dq, "dqdd_dq");
            close(&dqd, "dqdd_dv");
            close(&dtau, "dqdd_dtau");
        }
    }
}

/// A random tree with joints of all types (one in three floats or so at its base), rotors and
/// friction, and, if asked for, joints that follow others.
fn tree(seed: u64, links: usize, mimics: bool) -> Model {
    let plain = random::tree(seed, links);
    let mut random = Random::new(seed ^ 0x6465_7269_7665);
    let mut links = plain.links().to_vec();
    let single = [JointType::Revolute, JointType::Continuous, JointType::Prismatic];
    let several =
        [JointType::Universal, JointType::Planar, JointType::Spherical, JointType::Floating];
    for i in 0..links.len() {
        let leader = random.below(i.max(1));
        let leads = i > 0 && single.contains(&links[leader].joint.joint_type);
        let joint = &mut links[i].joint;
        if i == 0 && random.chance(0.3) {
            joint.joint_type = JointType::Floating;
        } else if random.chance(0.4) {
            joint.joint_type = several[random.below(4)];
        } else if mimics && leads && random.chance(0.4) {
            let multiplier = random.between(-2.0, 2.0);
            joint.mimic = Some(Mimic { leader, multiplier, offset: random.between(-1.0, 1.0) });
        }
        if !single.contains(&joint.joint_type) {
            joint.limits = None;
        }
        if joint.joint_type == JointType::Universal {
            // Across the first axis.
            let [x, y, z] = joint.axis;
            let across = if z.abs() < 0.9 { [-y, x, 0.0] } else { [z, 0.0, -x] };
            let length = across.iter().map(|x| x * x).sum::<f64>().sqrt();
            joint.second_axis = across.map(|x| x / length);
        }
        if random.chance(0.5) {
            let mut figure = || random.between(0.1, 0.5);
            joint.drive = Drive { armature: figure(), damping: figure(), friction: figure() };
        }
    }
    Model::new(plain.name(), plain.gravity(), links, plain.frames().to_vec())
        .and_then(|model| model.with_friction(Friction::Smooth(0.3)))
        .unwrap_or_else(|errors| panic!("seed {seed}: {errors:?}"))
}

/// Coordinates, velocities, accelerations and torques.
fn state(seed: u64, model: &Model) -> [Vec<f64>; 4] {
    let mut random = Random::new(!seed);
    let mut q: Vec<f64> = (0..model.nq()).map(|_| random.between(-2.0, 2.0)).collect();
    for (i, link) in model.links().iter().enumerate() {
        let at = match link.joint.joint_type {
            JointType::Spherical => model.q_range(i).start,
            JointType::Floating => model.q_range(i).start + 3,
            _ => continue,
        };
        let length = q[at..at + 4].iter().map(|x| x * x).sum::<f64>().sqrt();
        q[at..at + 4].iter_mut().for_each(|x| *x /= length);
    }
    let mut vector = |size: f64| (0..model.nv()).map(|_| random.between(-size, size)).collect();
    [q, vector(1.5), vector(3.0), vector(10.0)]
}

#[test]
fn random_trees_agree_with_tangents_of_the_dynamics() {
    let (mut followers, mut types) = (0, Vec::new());
    for seed in 0..200 {
        let links = 1 + usize::try_from(seed % 9).expect("a digit");
        let model = tree(seed, links, seed % 3 == 0);
        followers += model.links().iter().filter(|link| link.joint.mimic.is_some()).count();
        types.extend(model.links().iter().map(|link| link.joint.joint_type.name()));
        let n = model.nv();
        let [q, qd, qdd, tau] = state(seed, &model);
        let mut interpreter = Interpreter::new(model.clone());
        let mut dual = Interpreter::<Tangent<f64>>::new(model.clone());
        let slopes = |values: Vec<Tangent<f64>>| values.into_iter().map(|value| value.dx);
        let mut expected: [Vec<f64>; 5] = Default::default();
        let directions = |k: usize| (along_velocity(&model, &q, k), along(&qd, k), along(&tau, k));
        for k in 0..n {
            let (along_q, along_qd, along_tau) = directions(k);
            let (q, qd, qdd, tau) = (constant(&q), constant(&qd), constant(&qdd), constant(&tau));
            expected[0].extend(slopes(dual.tau(&along_q, &qd, &qdd)));
            expected[1].extend(slopes(dual.tau(&q, &along_qd, &qdd)));
            expected[2].extend(slopes(dual.qdd(&along_q, &qd, &tau)));
            expected[3].extend(slopes(dual.qdd(&q, &along_qd, &tau)));
            expected[4].extend(slopes(dual.qdd(&q, &qd, &along_tau)));
        }
        let [dtau_dq, dtau_dqd] = inverse(&mut interpreter, [&q, &qd, &qdd]);
        let [found, dqdd_dq, dqdd_dqd, dqdd_dtau] = forward(&mut interpreter, [&q, &qd, &tau]);
        let seed = format!("seed {seed}");
        assert_close(&seed, &dtau_dq, &expected[0], 1e-11);
        assert_close(&seed, &dtau_dqd, &expected[1], 1e-11);
        assert_close(&seed, &found, &interpreter.qdd(&q, &qd, &tau), 1e-9);
        assert_close(&seed, &dqdd_dq, &expected[2], 1e-9);
        assert_close(&seed, &dqdd_dqd, &expected[3], 1e-9);
        assert_close(&seed, &dqdd_dtau, &expected[4], 1e-9);
        for i in 0..n {
            for j in 0..i {
                assert_eq!(dqdd_dtau[i * n + j], dqdd_dtau[j * n + i], "{seed}: symmetric");
            }
        }
    }
    types.sort_unstable();
    types.dedup();
    assert_eq!(types.len(), 7, "all types occur: {types:?}");
    assert!(followers > 15, "{followers}");
}

#[test]
fn traced_derivatives_are_the_interpreters() {
    for seed in 0..20 {
        let model = tree(seed, 5, seed % 2 == 0);
        let prepared = Prepared::new(&model);
        let tracer = Tracer::new(&prepared);
        let [q, qd, qdd, tau] = state(seed, &model);
        let mut interpreter = Interpreter::new(model.clone());
        let evaluate = |graph: Graph, last: &[f64]| -> Vec<f64> {
            optimize(graph).evaluate(&[&*q, &*qd, last].concat())
        };
        let expected = inverse(&mut interpreter, [&q, &qd, &qdd]).concat();
        let found = evaluate(tracer.inverse_dynamics_derivatives(), &qdd);
        assert_close("inverse dynamics", &found, &expected, 1e-11);
        let expected = forward(&mut interpreter, [&q, &qd, &tau]).concat();
        for modules in [ModuleTree::links(&model), ModuleTree::chains(&model)] {
            let layout = Layout::new(&prepared, &modules);
            let found = evaluate(tracer.forward_dynamics_derivatives(&layout), &tau);
            assert_close("forward dynamics", &found, &expected, 1e-9);
        }
    }
}

/// Operations of the derivatives of inverse dynamics, and of forward dynamics with its
/// accelerations and the inverse of the GIM.
#[derive(Debug, PartialEq, Eq)]
struct Counts {
    robot: &'static str,
    floating: bool,
    inverse: usize,
    /// By links or by chains, whichever is less.
    forward: usize,
}

const fn frozen(robot: &'static str, floating: bool, inverse: usize, forward: usize) -> Counts {
    Counts { robot, floating, inverse, forward }
}

/// What they take at present. A count that falls is to be entered here; one that rises is a
/// regression.
const FROZEN: [Counts; 5] = [
    frozen("panda", false, 2549, 4231),
    frozen("solo12", false, 1348, 2016),
    frozen("solo12", true, 4739, 15035),
    frozen("g1", false, 15935, 29173),
    frozen("g1", true, 21967, 80951),
];

fn robot(name: &str, floating: bool) -> Model {
    let model = golden::model(&golden::urdf(name));
    if floating { floated(&model, Inertial::default()) } else { model }
}

fn counts(&Counts { robot: name, floating, .. }: &Counts) -> Counts {
    let model = robot(name, floating);
    let prepared = Prepared::new(&model);
    let tracer = Tracer::new(&prepared);
    let total = |graph: Graph| optimize(graph).count().total();
    let forward = |modules: &ModuleTree| {
        total(tracer.forward_dynamics_derivatives(&Layout::new(&prepared, modules)))
    };
    Counts {
        robot: name,
        floating,
        inverse: total(tracer.inverse_dynamics_derivatives()),
        forward: forward(&ModuleTree::links(&model)).min(forward(&ModuleTree::chains(&model))),
    }
}

#[test]
fn counts_are_as_frozen() {
    let found = FROZEN.each_ref().map(counts);
    assert_eq!(
        found, FROZEN,
        "\nA count that falls is to be entered; one that rises is a regression."
    );
}

/// The derivatives of inverse dynamics by tangents, one direction after the other.
fn tangents(model: &Model) -> Graph {
    let prepared = Prepared::new(model);
    Graph::trace(|| {
        let (nq, n) = (model.nq(), model.nv());
        let inputs = |start: usize, length: usize| -> Vec<Expr> {
            (start..start + length).map(Expr::input).collect()
        };
        let (q, qd, qdd) = (inputs(0, nq), inputs(nq, n), inputs(nq + n, n));
        let prepared = prepared.cast::<Tangent<Expr>>();
        let mut derivatives = Vec::new();
        let mut derive = |q: &[Tangent<Expr>], qd: &[Tangent<Expr>]| {
            let mut tau = vec![Tangent::zero(); n];
            let (workspace, qdd) = (&mut Workspace::new(&prepared), constant(&qdd));
            let motion = (q, qd, Some(&*qdd));
            inverse_dynamics::inverse_dynamics(&prepared, motion, None, workspace, &mut tau);
            derivatives.extend(tau.into_iter().map(|tau| tau.dx));
        };
        for k in 0..n {
            derive(&along_velocity(model, &q, k), &constant(&qd));
        }
        for k in 0..n {
            derive(&constant(&q), &along(&qd, k));
        }
        derivatives
    })
}

#[test]
fn closed_form_is_cheaper_than_tangents() {
    for counts in &FROZEN {
        let model = robot(counts.robot, counts.floating);
        let tangents = optimize(tangents(&model)).count().total();
        let ours = counts.inverse;
        assert!(ours < tangents, "{counts:?}: {ours}, by tangents {tangents}");
    }
}
