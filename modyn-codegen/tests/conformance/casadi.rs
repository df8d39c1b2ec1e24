//! C for CasADi: each function with its derivatives, over the nonzeros of matrices. `tests/casadi` loads it in CasADi itself.

use std::fmt::Write as _;
use std::process::Command;

use crate::conformance::c::{execute, write, write_main};
use crate::conformance::{Call, STATES, Subject, command, compare, folder, kinds, robot};
use crate::random::Random;
use modyn_codegen::plan::{CasadiFunction, CasadiMatrix, Shape};
use modyn_codegen::{Builder, FloatType, Function, Target};

/// Returns the calls of a function, with numbers for the nonzeros of its inputs.
fn calls(function: &CasadiFunction, random: &mut Random) -> Vec<Call> {
    let call = |_| {
        let mut numbers = |input: &CasadiMatrix| -> Vec<f64> {
            (0..input.len()).map(|_| random.between(-1.0, 1.0)).collect()
        };
        let arguments: Vec<Vec<f64>> = function.inputs.iter().map(&mut numbers).collect();
        let expected = function.program.evaluate(&arguments.concat());
        Call {
            function: function.full_name("ours"),
            link: None,
            has_parameters: false,
            arguments,
            shape: Shape::vector(expected.len()),
            expected,
            tolerance: None,
        }
    };
    (0..STATES).map(call).collect()
}

/// Compares all functions of a text with the evaluation of their programs, bit for bit. Returns the number of functions.
fn conforms(name: &str, builder: &Builder) -> usize {
    let emitted = builder.clone().type_name("Ours").emit(Target::Casadi).expect("good");
    let functions = &emitted.plan.casadi.functions;
    let mut random = Random::new(3);
    let calls = functions.iter().flat_map(|function| calls(function, &mut random)).collect();
    let subject = Subject { robot: &emitted, float: FloatType::F64, calls };
    let folder = folder(&format!("casadi_{name}"));
    write(&emitted, &folder);
    let mut header = String::from("#include <stddef.h>\n");
    for function in functions {
        let name = function.full_name("ours");
        let _ =
            writeln!(header, "int {name}(const double **, double **, long long *, double *, int);");
    }
    std::fs::write(folder.join("ours.h"), header).expect("writes");
    write_main(&subject, &folder, |call, arguments| {
        let mut all = functions.iter();
        let function =
            all.find(|one| one.full_name("ours") == call.function).expect("its function");
        let mut at = 0;
        let results = function.outputs.iter().map(|output| {
            at += output.len();
            format!("(double *)x + {}", at - output.len())
        });
        format!(
            "{{ const double *arg[] = {{ {arguments} }}; double *res[] = {{ {} }}, w[{}];\n        \
             if ({}(arg, res, 0, w, 0)) return 1; }}",
            results.collect::<Vec<String>>().join(", "),
            at.max(1),
            call.function
        )
    });
    let mut gcc = Command::new("gcc");
    gcc.args(["-std=c99", "-Wall", "-ffp-contract=off", "main.c", "ours.c", "-o", "main", "-lm"]);
    command(gcc.current_dir(&folder));
    compare(name, &subject.calls, &execute(&subject, &folder, &["./main"]));
    functions.len()
}

const FUNCTIONS: [Function; 6] = [
    Function::ForwardDynamics,
    Function::MassMatrix,
    Function::StepSemiImplicit,
    Function::LinkPose,
    Function::Difference,
    Function::Actuate,
];

#[test]
fn robots_of_every_kind() {
    let names = ["mimic_gripper", "parameters", "actuators", "motors"];
    let of_kinds = kinds().into_iter().filter(|case| names.contains(&case.name));
    let functions: usize =
        of_kinds.map(|case| conforms(case.name, &case.builder.functions(FUNCTIONS))).sum();
    assert!(functions > 50, "{functions}");
}

#[test]
fn all_functions_of_a_small_robot() {
    let builder = robot("double_pendulum").functions(Function::ALL.iter().copied());
    assert!(conforms("all", &builder) > 100);
}
