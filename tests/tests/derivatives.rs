//! Derivatives of inverse and forward dynamics: compared with reference data and with tangents of the dynamics; and
//! their operation counts.

use modyn_codegen::graph::{Expr, Graph};
use modyn_codegen::passes::optimize;
use modyn_codegen::plan::COLUMN_LANES;
use modyn_codegen::trace::Tracer;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::{self, ForwardInput, Motion, Workspace, dynamics::inverse_dynamics};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Inertial, Model, ModuleTree};
use modyn_runtime::spatial::Wrench;
use modyn_runtime::{Forces, ForwardDerivatives, Interpreter, Scalar};
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along, along_velocity, constant};
use modyn_tests::floating::floated;
use modyn_tests::golden::{self, FIXED_BASE, FLOATING_BASE, Golden};
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{self, Random, State};

/// The tolerance that the reference data's README gives.
const TOLERANCE: f64 = 1e-9;

/// The derivatives of the torques by q and by qd.
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

#[test]
fn derivatives_are_those_of_other_software() {
    let mut states = 0;
    for name in FIXED_BASE.into_iter().chain(FLOATING_BASE) {
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
    assert_eq!(states, 55, "the states of all robots");
}

#[test]
fn random_trees_agree_with_tangents_of_the_dynamics() {
    let (mut followers, mut types) = (0, Vec::new());
    for seed in 0..200 {
        let links = 1 + usize::try_from(seed % 9).expect("a digit");
        let model = random::mixed_zoo(seed, links);
        followers += model.moving_links().iter().filter(|link| link.joint.mimic.is_some()).count();
        types.extend(model.moving_links().iter().map(|link| link.joint.joint_type.name()));
        let n = model.nv();
        let State { q, qd, qdd, tau } = random::state(seed, &model);
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

/// External wrenches on all links are constant in the links' axes, or in the world's.
#[test]
fn derivatives_under_external_wrenches_agree_with_tangents_of_the_dynamics() {
    let mut followers = 0;
    for seed in 0..100 {
        let model = random::mixed_zoo(seed, 1 + usize::try_from(seed % 9).expect("a digit"));
        followers += model.moving_links().iter().filter(|link| link.joint.mimic.is_some()).count();
        let n = model.nv();
        let State { q, qd, qdd, tau } = random::state(seed, &model);
        let mut random = Random::new(seed);
        let wrench =
            |_: &_| Wrench::from_components(std::array::from_fn(|_| random.between(-9.0, 9.0)));
        let wrenches: Vec<Wrench<f64>> = model.links().iter().map(wrench).collect();
        let duals: Vec<Wrench<Tangent<f64>>> = wrenches
            .iter()
            .map(|wrench| {
                let components = constant(&wrench.components());
                Wrench::from_components(std::array::from_fn(|i| components[i]))
            })
            .collect();
        let mut interpreter = Interpreter::new(model.clone());
        let mut dual = Interpreter::<Tangent<f64>>::new(model.clone());
        for in_world in [false, true] {
            let (forces, dual_forces) = match in_world {
                false => (Forces::InLinkAxes(&wrenches), Forces::InLinkAxes(&duals)),
                true => (Forces::InWorldAxes(&wrenches), Forces::InWorldAxes(&duals)),
            };
            let slopes = |values: Vec<Tangent<f64>>| values.into_iter().map(|value| value.dx);
            let mut expected: [Vec<f64>; 5] = Default::default();
            for k in 0..n {
                let along_q = along_velocity(&model, &q, k);
                let (along_qd, along_tau) = (along(&qd, k), along(&tau, k));
                let (q, qd, qdd, tau) =
                    (constant(&q), constant(&qd), constant(&qdd), constant(&tau));
                expected[0].extend(slopes(dual.tau_under(&along_q, &qd, &qdd, dual_forces)));
                expected[1].extend(slopes(dual.tau_under(&q, &along_qd, &qdd, dual_forces)));
                expected[2].extend(slopes(dual.qdd_under(&along_q, &qd, &tau, dual_forces)));
                expected[3].extend(slopes(dual.qdd_under(&q, &along_qd, &tau, dual_forces)));
                expected[4].extend(slopes(dual.qdd_under(&q, &qd, &along_tau, dual_forces)));
            }
            let mut found = [n, n * n, n * n, n * n, n * n, n * n].map(|size| vec![f64::NAN; size]);
            let [at, dqdd_dq, dqdd_dqd, dqdd_dtau, dtau_dq, dtau_dqd] = &mut found;
            let outputs = ForwardDerivatives { qdd: at, dqdd_dq, dqdd_dqd, dqdd_dtau };
            let derived = interpreter.forward_dynamics_external_derivatives(
                ForwardInput { q: &q, qd: &qd, tau: &tau },
                forces,
                outputs,
            );
            assert_eq!(derived, Ok(()));
            let motion = Motion { q: &q, qd: &qd, qdd: &qdd };
            let derived = interpreter
                .inverse_dynamics_external_derivatives(motion, forces, dtau_dq, dtau_dqd);
            assert_eq!(derived, Ok(()));
            let seed = format!("seed {seed}, in world axes: {in_world}");
            assert_close(&seed, at, &interpreter.qdd_under(&q, &qd, &tau, forces), 1e-9);
            assert_close(&seed, dtau_dq, &expected[0], 1e-11);
            assert_close(&seed, dtau_dqd, &expected[1], 1e-11);
            assert_close(&seed, dqdd_dq, &expected[2], 1e-9);
            assert_close(&seed, dqdd_dqd, &expected[3], 1e-9);
            assert_close(&seed, dqdd_dtau, &expected[4], 1e-9);
        }
    }
    assert!(followers > 5, "{followers}");
}

#[test]
fn traced_derivatives_are_the_interpreters() {
    for seed in 0..20 {
        let model = random::mixed_zoo(seed, 5);
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let State { q, qd, qdd, tau } = random::state(seed, &model);
        let mut interpreter = Interpreter::new(model.clone());
        let evaluate = |graph: Graph, last: &[f64]| -> Vec<f64> {
            optimize(graph).evaluate(&[&*q, &*qd, last].concat())
        };
        let by_inverse = inverse(&mut interpreter, [&q, &qd, &qdd]).concat();
        let by_forward = forward(&mut interpreter, [&q, &qd, &tau]).concat();
        for tracer in [&tracer, &tracer.column_lanes(COLUMN_LANES)] {
            let found = evaluate(tracer.inverse_dynamics_derivatives(), &qdd);
            assert_close("inverse dynamics", &found, &by_inverse, 1e-11);
            for modules in [ModuleTree::links(&model), ModuleTree::chains(&model)] {
                let layout = UduLayout::new(&mechanism, &modules);
                let found = evaluate(tracer.forward_dynamics_derivatives(&layout), &tau);
                assert_close("forward dynamics", &found, &by_forward, 1e-9);
            }
        }
    }
}

/// The operations of the derivatives of inverse dynamics, and of forward dynamics with its accelerations and the
/// inverse of the mass matrix.
#[derive(Debug, PartialEq, Eq)]
struct Counts {
    robot: &'static str,
    floating: bool,
    inverse: usize,
    /// The operations of the derivatives of inverse dynamics by tangents.
    tangents: usize,
    /// The operations with chains as modules, which are at most those with single links as modules.
    forward: usize,
}

const fn frozen(
    robot: &'static str,
    floating: bool,
    [inverse, tangents]: [usize; 2],
    forward: usize,
) -> Counts {
    Counts { robot, floating, inverse, tangents, forward }
}

/// The present counts. Enter a count that falls; a count that rises is a regression.
const FROZEN: [Counts; 6] = [
    frozen("ur5", false, [1201, 1071], 2140),
    frozen("panda", false, [2512, 4843], 4190),
    frozen("solo12", false, [1348, 1332], 2008),
    frozen("solo12", true, [4709, 7274], 15033),
    frozen("g1", false, [15896, 30426], 29166),
    frozen("g1", true, [21912, 47985], 80949),
];

fn robot(name: &str, floating: bool) -> Model {
    let model = golden::model(&golden::urdf(name));
    if floating { floated(&model, Inertial::default()) } else { model }
}

fn counts(&Counts { robot: name, floating, .. }: &Counts) -> Counts {
    let model = robot(name, floating);
    let mechanism = Mechanism::new(&model);
    let tracer = Tracer::new(&mechanism);
    let total = |graph: Graph| optimize(graph).count().total();
    let forward = |modules: &ModuleTree| {
        total(tracer.forward_dynamics_derivatives(&UduLayout::new(&mechanism, modules)))
    };
    let (links, chains) =
        (forward(&ModuleTree::links(&model)), forward(&ModuleTree::chains(&model)));
    assert!(chains <= links, "{name}: {chains} by chains, {links} by links");
    Counts {
        robot: name,
        floating,
        inverse: total(tracer.inverse_dynamics_derivatives()),
        tangents: total(tangents(&model)),
        forward: chains,
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

/// The data file of the page on derivatives has these counts.
#[test]
fn the_pages_data_have_the_frozen_counts() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/data/tangents.tsv");
    let text = std::fs::read_to_string(path).expect("data");
    for counts in FROZEN {
        let name = format!("{}{}\t", counts.robot, if counts.floating { "_ff" } else { "" });
        let row = text.lines().find_map(|line| line.strip_prefix(&name)).expect("a row");
        assert_eq!(row.split('\t').next(), Some(&*counts.tangents.to_string()), "{name}");
    }
}

/// Returns the derivatives of inverse dynamics by tangents, one direction after the other.
fn tangents(model: &Model) -> Graph {
    let mechanism = Mechanism::new(model);
    Graph::trace(|| {
        let (nq, n) = (model.nq(), model.nv());
        let inputs = |start: usize, length: usize| -> Vec<Expr> {
            (start..start + length).map(Expr::input).collect()
        };
        let (q, qd, qdd) = (inputs(0, nq), inputs(nq, n), inputs(nq + n, n));
        let mechanism = mechanism.cast::<Tangent<Expr>>();
        let mut derivatives = Vec::new();
        let mut derive = |q: &[Tangent<Expr>], qd: &[Tangent<Expr>]| {
            let mut tau = vec![Tangent::zero(); n];
            let (workspace, qdd) = (&mut Workspace::new(&mechanism), constant(&qdd));
            inverse_dynamics(
                &mechanism,
                equations::State { q, qd },
                Some(&qdd),
                None,
                workspace,
                &mut tau,
            );
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
