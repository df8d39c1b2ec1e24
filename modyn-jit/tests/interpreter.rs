//! Machine code of random trees gives the interpreter's results: every function, for each link, for one state and many.

use modyn_codegen::diagnostics::Code;
use modyn_codegen::plan::{Choices, GraphSource, Lowering, Packing, Plan};
use modyn_codegen::program::Execution;
use modyn_codegen::{Base, Builder, CodeForm, Function, ReadOptions};
use modyn_jit::{Call, Compiled, InstructionSet, Options};
use modyn_runtime::Interpreter;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_tests::arguments::{arguments, interpreted};
use modyn_tests::conformance::robot;
use modyn_tests::random;

fn computed(call: &Call<'_, f64>, arguments: &[&[f64]], links: usize) -> Vec<f64> {
    let one = call.result().len();
    let mut result = vec![f64::NAN; one];
    if call.one(arguments, &mut result).is_ok() {
        let states = 11;
        let repeated: Vec<Vec<f64>> = arguments.iter().map(|x| x.repeat(states)).collect();
        let repeated: Vec<&[f64]> = repeated.iter().map(Vec::as_slice).collect();
        let mut many = vec![f64::NAN; one * states];
        call.many(&repeated, &mut many).expect("fits");
        for state in many.chunks(one.max(1)) {
            close("many", state, &result);
        }
        return result;
    }
    let of_link = |link| {
        let (mut result, mut many) = (vec![f64::NAN; one], vec![f64::NAN; one]);
        call.link(link, arguments, &mut result).expect("a link");
        call.many_link(link, arguments, &mut many).expect("a link");
        close("many", &many, &result);
        result
    };
    (0..links).flat_map(of_link).collect()
}

fn close(name: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{name}");
    let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-9 * size, "{name}: {found} {expected}");
    }
}

/// All functions of one state of a tree.
fn functions() -> Vec<Function> {
    let all = Function::ALL.iter().copied();
    all.filter(|f| f.batched().is_none() && f.row().is_general()).collect()
}

fn agrees(model: &Model, seed: u64, functions: &[Function]) {
    let builder = Builder::new().model(model.clone());
    let planning = match builder.functions(functions.iter().copied()).plan() {
        Ok(planning) => planning,
        // A few of many seeds: a Runge-Kutta derivative of such a robot would be too long.
        Err(errors) if errors.iter().all(|error| error.code == Code::TooLarge) => return,
        Err(errors) => panic!("{errors}"),
    };
    let state = random::state(seed, model);
    let mut interpreter = Interpreter::new(model.clone());
    for instruction_set in InstructionSet::available() {
        let mut options = Options::default();
        (options.instruction_set, options.batches) = (Some(instruction_set), true);
        let compiled = Compiled::<f64>::from_plan(&planning, options).expect("code");
        assert_eq!(compiled.functions().count(), functions.len());
        for function in compiled.functions() {
            let call = compiled.function(function).expect("compiled");
            let arguments = arguments(function, model, &state);
            let slices: Vec<&[f64]> = arguments.iter().map(Vec::as_slice).collect();
            let found = computed(&call, &slices, model.links().len());
            let expected = interpreted(&mut interpreter, function, &arguments);
            close(function.name(), &found, &expected);
        }
    }
}

#[test]
fn every_function_of_trees() {
    for seed in random::seeds(2) {
        agrees(&random::mixed_zoo(seed, 5), seed, &functions());
    }
}

/// Returns the plan of functions for vectors, or with a routine for equal limbs.
fn plan(model: &Model, functions: &[Function], execution: Execution) -> Plan {
    let choices = Choices {
        functions: functions.to_vec(),
        share_limbs: execution == Execution::Scalar,
        code: CodeForm::Unrolled,
        ..Choices::default()
    };
    Plan::new(model, &ModuleTree::chains(model), &choices, execution).expect("short")
}

/// Equal and similar limbs in lanes, and in routines: programs give the interpreter's results. Each robot has some of the
/// functions, above all of those that can be packed; derivatives of a Runge-Kutta step have too many operations.
#[test]
fn random_limbs() {
    let (seeds, mut compared) = (random::seeds(10), [0; 3]);
    for seed in seeds.clone() {
        let model = random::limbs(seed, 4 + 3 * (seed % 4) as usize);
        let mut random = random::Random::new(seed);
        let mut functions = functions();
        functions.retain(|&one| {
            let Lowering { packing, source, .. } = Lowering::of(one);
            let part = if packing == Packing::Never { 0.1 } else { 0.3 };
            let has_one_graph = !one.row().by_link && !matches!(source, GraphSource::Poses);
            has_one_graph && one != Function::StepRk4Derivatives && random.chance(part)
        });
        let state = random::state(seed, &model);
        let mut interpreter = Interpreter::new(model.clone());
        for execution in [Execution::Simd, Execution::Scalar] {
            let plan = plan(&model, &functions, execution);
            assert_eq!(plan.faults().next(), None, "{}", model.name());
            for planned in &plan.functions {
                let function = planned.function.expect("of the table");
                let arguments = arguments(function, &model, &state);
                let expected = interpreted(&mut interpreter, function, &arguments);
                let arguments = arguments.concat();
                let (scalar, simd) = planned.kernels.straight().expect("straight-line code");
                let kind = match scalar.routines.is_empty() {
                    true => usize::from(simd.execution == Execution::Simd),
                    false => 2,
                };
                let name = format!("{} of {}", function.name(), model.name());
                for program in [scalar, simd] {
                    close(&name, &program.evaluate(&arguments), &expected);
                }
                compared[kind] += 1;
            }
        }
    }
    let [scalar, lanes, routines] = compared;
    println!("{seeds:?}: {scalar} programs on scalars, {lanes} in lanes, {routines} in routines");
    let few = usize::try_from(seeds.end - seeds.start).expect("few seeds") / 4;
    assert!(lanes >= few && routines >= few, "{compared:?}");
}

/// Equal limbs on a floating base, whose derivatives couple all limbs. Derivatives of a Runge-Kutta step have 200,000
/// operations.
#[test]
#[ignore = "slow: long programs"]
fn a_floating_quadruped() {
    let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
    let text = include_str!("../../robots/quadruped.urdf");
    let model = modyn_codegen::read(text, "quadruped.urdf", &options).expect("good").model;
    let mut functions = functions();
    functions.retain(|&function| function != Function::StepRk4Derivatives);
    agrees(&model, 5, &functions);
}

/// More than eight links on one body share code, whose further argument is the link's placement.
#[test]
fn links_that_share_code() {
    use std::fmt::Write as _;
    let mut urdf = String::from(
        "<robot name='mast'><link name='ground'/>\
         <joint name='turn' type='revolute'><parent link='ground'/><child link='mast'/>\
         <origin xyz='0.1 0.2 0.3' rpy='0.3 -0.2 0.5'/><axis xyz='0.6 0 0.8'/>\
         <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
         <link name='mast'><inertial><origin xyz='0.1 0.3 -0.2'/><mass value='2'/>\
         <inertia ixx='0.3' iyy='0.4' izz='0.5' ixy='0.01' ixz='0.02' iyz='0.03'/></inertial></link>",
    );
    for i in 0..12 {
        let _ = write!(
            urdf,
            "<link name='lamp{i}'/><joint name='lamp{i}' type='fixed'><parent link='mast'/>\
             <child link='lamp{i}'/><origin xyz='0.{i} 0.2 -0.1' rpy='0.{i} 0.4 -0.3'/></joint>"
        );
    }
    let reading =
        modyn_codegen::read(&(urdf + "</robot>"), "mast.urdf", &Default::default()).expect("good");
    agrees(&reading.model, 3, &functions());
}

/// Machine code keeps no state: threads share a robot.
#[test]
fn threads_share_a_robot() {
    let planning = robot("arm7").functions([Function::ForwardDynamics]).plan().expect("good");
    let model = &planning.model;
    let compiled = Compiled::<f64>::from_plan(&planning, Options::default()).expect("code");
    let one = |seed: u64| {
        let random::State { q, qd, tau, .. } = random::state(seed, model);
        let mut qdd = vec![f64::NAN; model.nv()];
        compiled.forward_dynamics(&q, &qd, &tau, &mut qdd).expect("fits");
        qdd
    };
    let alone: Vec<Vec<f64>> = (0..8).map(one).collect();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|_| scope.spawn(|| (0..100).map(|i| one(i % 8)).collect::<Vec<_>>()))
            .collect();
        for thread in threads {
            let found = thread.join().expect("no panic");
            assert!(found.iter().zip(alone.iter().cycle()).all(|(a, b)| a == b));
        }
    });
}

#[test]
fn a_level_above_the_processor_is_refused() {
    let builder = robot("double_pendulum").functions([Function::ForwardDynamics]);
    let planning = builder.plan().expect("good");
    let best = InstructionSet::detect().expect("a processor with machine code");
    for instruction_set in InstructionSet::ALL.into_iter().filter(|set| !set.is_available()) {
        let mut options = Options::default();
        options.instruction_set = Some(instruction_set);
        let error = Compiled::<f64>::from_plan(&planning, options).expect_err("too high");
        assert!(error.to_string().contains(&format!("{best:?}")), "{error}");
    }
}
