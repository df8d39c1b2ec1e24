//! Code in loops over bodies: the values of straight-line code and of the interpreter, and an amount of code that does not
//! depend on the number of bodies.

use modyn::{EmbeddedModel, Robot};
use modyn_codegen::plan::{Choices, Kernels, Plan};
use modyn_codegen::program::{Execution, Program};
use modyn_codegen::{CodeForm, Function};
use modyn_runtime::Interpreter;
use modyn_runtime::joint::JointType;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_tests::close::assert_close;
use modyn_tests::floating::floated;
use modyn_tests::random::{self, Random, State};

const FUNCTIONS: [Function; 2] = [Function::ForwardDynamics, Function::InverseDynamics];

/// Returns the plan of forward and inverse dynamics.
fn plan(model: &Model, code: CodeForm, runtime_gravity: bool) -> Plan {
    let choices =
        Choices { functions: FUNCTIONS.into(), code, runtime_gravity, ..Choices::default() };
    Plan::new(model, &ModuleTree::links(model), &choices, Execution::Scalar).expect("short")
}

/// Returns the loops of both functions; `None` if they are straight-line code.
fn looped(plan: &Plan) -> Option<[&Program; 2]> {
    let program = |function| {
        let mut all = plan.functions.iter();
        match &all.find(|planned| planned.function == Some(function))?.kernels {
            Kernels::Straight { scalar, .. } if !scalar.tables.is_empty() => Some(scalar),
            _ => None,
        }
    };
    let [forward, inverse] = FUNCTIONS.map(program);
    assert_eq!(forward.is_some(), inverse.is_some());
    Some([forward?, inverse?])
}

/// Compares loops with the interpreter, at a state.
fn compare(what: &str, model: &Model, state: &State) {
    let State { q, qd, qdd, tau } = state;
    for runtime_gravity in [false, true] {
        let plan = plan(model, CodeForm::Looped, runtime_gravity);
        let [forward, inverse] = looped(&plan).expect("loops");
        let gravity = plan.parameters.described(model.gravity());
        let mut interpreter = Interpreter::new(model.clone());
        let mut expected = vec![0.0; model.nv()];
        interpreter.forward_dynamics(q, qd, tau, &mut expected).expect("lengths");
        let found = forward.evaluate::<f64>(&[q, qd, tau, &*gravity].concat());
        assert_close(&format!("{what}: accelerations"), &found, &expected, 1e-9);
        interpreter.inverse_dynamics(q, qd, qdd, &mut expected).expect("lengths");
        let found = inverse.evaluate::<f64>(&[q, qd, qdd, &*gravity].concat());
        assert_close(&format!("{what}: forces"), &found, &expected, 1e-11);
    }
}

#[test]
fn loops_have_the_values_of_the_interpreter() {
    let (mut compared, mut straight) = (0, 0);
    for seed in 0..60 {
        let links = 1 + usize::try_from(seed).expect("small") % 14;
        let model = random::mixed_zoo(seed, links);
        let floating = floated(&model, Random::new(seed).inertial());
        for (what, model) in [("on the ground", &model), ("floating", &floating)] {
            let mimics = model.moving_links().iter().any(|link| link.joint.mimic.is_some());
            if mimics || Mechanism::new(model).compensates_gravity() {
                assert!(looped(&plan(model, CodeForm::Looped, false)).is_none());
                straight += 1;
                continue;
            }
            compare(&format!("{seed}, {what}"), model, &random::state(seed, model));
            compared += 1;
        }
    }
    assert!(compared > 40 && straight > 5, "{compared} {straight}");
}

/// Returns a serial chain of revolute joints in general position.
fn chain(links: usize) -> Model {
    let model = random::chain(7, links);
    let revolute = model.moving_links().iter().cloned().map(|mut link| {
        link.joint.joint_type = JointType::Revolute;
        link
    });
    let frames = model.links().to_vec();
    Model::new("chain", model.gravity(), revolute.collect(), frames).expect("a robot")
}

/// The operations in the text for a chain of any length, and those of a call for each further joint: of forward and inverse
/// dynamics. Enter a count that falls; a count that rises is a regression.
const FROZEN: [[usize; 2]; 2] = [[840, 322], [437, 161]];

#[test]
fn the_amount_of_code_does_not_depend_on_the_number_of_bodies() {
    let counts = |links| {
        let plan = plan(&chain(links), CodeForm::Looped, false);
        let loops = looped(&plan).expect("loops");
        let in_the_text = loops.map(|program| program.static_operations().total());
        (in_the_text, loops.map(|program| program.operations_per_call().total()))
    };
    let (_, least) = counts(14);
    for links in [28, 112] {
        let (in_the_text, per_call) = counts(links);
        let for_each = [0, 1].map(|k| (per_call[k] - least[k]) / (links - 14));
        assert_eq!([in_the_text, for_each], FROZEN, "{links}");
    }
}

#[test]
fn long_chains_are_loops_unless_speed_is_chosen() {
    let is_looped = |links, code| looped(&plan(&chain(links), code, false)).is_some();
    assert!(is_looped(7, CodeForm::Looped) && !is_looped(7, CodeForm::Auto));
    assert!(is_looped(140, CodeForm::Auto) && !is_looped(140, CodeForm::Unrolled));
}

macro_rules! robots {
    ($($Robot:ident = $file:literal $(, $key:ident = $choice:tt)*;)*) => {$(
        modyn::modyn! {
            $Robot = $file,
            functions = [forward_dynamics, inverse_dynamics, random_configuration]
            $(, $key = $choice)*
        }
    )*};
}

robots! {
    Arm = "../../../robots/arm7.urdf", joint_friction = coulomb, code = looped;
    StraightArm = "../../../robots/arm7.urdf", joint_friction = coulomb, code = unrolled;
    Moon = "../../../robots/arm7.urdf", joint_friction = none, runtime_gravity = true, code = looped;
    StraightMoon = "../../../robots/arm7.urdf", joint_friction = none, runtime_gravity = true, code = unrolled;
    Zoo = "../../../robots/joint_zoo.urdf", joint_friction = viscous, code = looped;
    StraightZoo = "../../../robots/joint_zoo.urdf", joint_friction = viscous, code = unrolled;
    Flying = "../../../robots/quadruped.urdf", base = floating, code = looped;
    StraightFlying = "../../../robots/quadruped.urdf", base = floating, code = unrolled;
    Single = "../../../robots/quadruped.urdf", base = floating, scalar = f32, code = looped;
    StraightSingle = "../../../robots/quadruped.urdf", base = floating, scalar = f32, code = unrolled;
}

/// Compares a compiled robot with loops with the same robot in straight-line code.
macro_rules! compared {
    ($Looped:ident, $Straight:ident, $T:ty, $tolerance:expr) => {{
        let mut random = Random::new(5);
        for _ in 0..20 {
            let q = $Looped::random_configuration(|| random.between(0.0, 1.0) as $T);
            let [qd, tau]: [[$T; $Looped::NV]; 2] =
                std::array::from_fn(|_| std::array::from_fn(|_| random.between(-2.0, 2.0) as $T));
            let numbers = |x: [$T; $Looped::NV]| x.map(f64::from);
            let what = stringify!($Looped);
            let found = numbers($Looped::forward_dynamics(&q, &qd, &tau));
            let expected = numbers($Straight::forward_dynamics(&q, &qd, &tau));
            assert_close(what, &found, &expected, $tolerance);
            let found = numbers($Looped::inverse_dynamics(&q, &qd, &tau));
            let expected = numbers($Straight::inverse_dynamics(&q, &qd, &tau));
            assert_close(what, &found, &expected, $tolerance);
        }
    }};
}

modyn::modyn! {
    Legged = "../../../robots/quadruped.urdf", base = floating, code = looped, embed_model = true,
    functions = [forward_dynamics_derivatives, random_configuration]
}

/// Products of matrices in loops, on vectors where the processor has them, of numbers in both precisions.
#[test]
fn compiled_products_have_the_values_of_the_interpreter() {
    let mut random = Random::new(8);
    let mut interpreter = Interpreter::new(<Legged as EmbeddedModel>::model());
    for _ in 0..20 {
        let q = Legged::random_configuration(|| random.between(0.0, 1.0));
        let [qd, tau]: [[f64; Legged::NV]; 2] =
            std::array::from_fn(|_| std::array::from_fn(|_| random.between(-2.0, 2.0)));
        let mut expected = vec![0.0; Legged::NV * (1 + 3 * Legged::NV)];
        let arguments = [&q[..], &qd, &tau];
        interpreter
            .evaluate(Function::ForwardDynamicsDerivatives, &arguments, 0, &mut expected)
            .expect("lengths");
        let found = Legged::forward_dynamics_derivatives(&q, &qd, &tau);
        let matrices = [found.dqdd_dq, found.dqdd_dqd, found.dqdd_dtau];
        let found = [&found.qdd[..], matrices.as_flattened().as_flattened()].concat();
        assert_close("f64", &found, &expected, 1e-11);
        let single = |x: &[f64]| x.iter().map(|&x| x as f32).collect::<Vec<_>>();
        let [q, qd, tau] = arguments.map(single);
        let found = <Legged as Robot>::forward_dynamics_derivatives(
            &q.try_into().expect("length"),
            &qd.try_into().expect("length"),
            &tau.try_into().expect("length"),
        );
        let matrices = [found.dqdd_dq, found.dqdd_dqd, found.dqdd_dtau];
        let found = [&found.qdd[..], matrices.as_flattened().as_flattened()].concat();
        let found: Vec<f64> = found.into_iter().map(f64::from).collect();
        assert_close("f32", &found, &expected, 2e-3);
    }
}

#[test]
fn compiled_loops_have_the_values_of_straight_line_code() {
    compared!(Arm, StraightArm, f64, 1e-11);
    compared!(Moon, StraightMoon, f64, 1e-11);
    compared!(Zoo, StraightZoo, f64, 1e-11);
    compared!(Flying, StraightFlying, f64, 1e-11);
    compared!(Single, StraightSingle, f32, 2e-3);
}
