//! C for CasADi: each function with its derivatives, over the nonzeros of matrices. `tests/casadi` loads it in CasADi itself.

use std::fmt::Write as _;
use std::process::Command;

use crate::conformance::{command, folder, kinds, numbers::is_same, robot};
use crate::random::Random;
use modyn_codegen::plan::CasadiMatrix;
use modyn_codegen::{Function, Target};

/// Compares all functions of a text with the evaluation of their programs, bit for bit.
fn conforms(name: &str, builder: &modyn_codegen::Builder) -> usize {
    let emitted = builder.clone().type_name("Ours").emit(Target::Casadi).expect("good");
    let folder = folder(&format!("casadi_{name}"));
    std::fs::write(folder.join("ours.c"), emitted.text()).expect("writes");
    let (mut text, mut main, mut random) = (String::new(), String::new(), Random::new(3));
    let (mut input, mut expected) = (Vec::new(), Vec::new());
    for function in &emitted.plan.casadi.functions {
        let name = function.full_name("ours");
        let given: usize = function.inputs.iter().map(CasadiMatrix::len).sum();
        let results: usize = function.outputs.iter().map(CasadiMatrix::len).sum();
        let numbers: Vec<f64> = (0..given).map(|_| random.between(-1.0, 1.0)).collect();
        expected.extend(function.program.evaluate(&numbers));
        input.extend(numbers);
        let pointers = |array: &str, matrices: &[CasadiMatrix]| {
            let mut at = 0;
            let places = matrices.iter().map(|matrix| {
                at += matrix.len();
                format!("{array} + {}", at - matrix.len())
            });
            places.collect::<Vec<String>>().join(", ")
        };
        let _ =
            writeln!(text, "int {name}(const double **, double **, long long *, double *, int);");
        let _ = writeln!(
            main,
            "    {{ static double a[{}], x[{}], w[{}];\n    const double *arg[] = {{ {} }};\n    double *res[] = {{ {} }};\n    \
             if (fread(a, 8, {given}, in) != {given} || {name}(arg, res, 0, w, 0)) return 1;\n    fwrite(x, 8, {results}, out); }}",
            given.max(1),
            results.max(1),
            results.max(1),
            pointers("a", &function.inputs),
            pointers("x", &function.outputs),
        );
    }
    let text = format!(
        "#include <stdio.h>\n{text}int main(void)\n{{\n    FILE *in = fopen(\"in\", \"rb\"), *out = fopen(\"out\", \"wb\");\n\
         {main}    return fclose(out);\n}}\n"
    );
    std::fs::write(folder.join("main.c"), text).expect("writes");
    std::fs::write(
        folder.join("in"),
        input.iter().flat_map(|x| x.to_ne_bytes()).collect::<Vec<u8>>(),
    )
    .expect("writes");
    let mut gcc = Command::new("gcc");
    gcc.args(["-std=c99", "-Wall", "-ffp-contract=off", "main.c", "ours.c", "-o", "main", "-lm"]);
    command(gcc.current_dir(&folder));
    command(Command::new(folder.join("main")).current_dir(&folder));
    let bytes = std::fs::read(folder.join("out")).expect("results");
    let found: Vec<f64> = bytes.as_chunks().0.iter().map(|x| f64::from_ne_bytes(*x)).collect();
    assert_eq!(found.len(), expected.len(), "{name}");
    for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
        assert!(is_same(*a, *b), "{name}, {i}: {a:e} {b:e}");
    }
    emitted.plan.casadi.functions.len()
}

const FUNCTIONS: [Function; 5] = [
    Function::ForwardDynamics,
    Function::MassMatrix,
    Function::StepSemiImplicit,
    Function::LinkPose,
    Function::Difference,
];

#[test]
fn robots_of_every_kind() {
    let of_kinds =
        kinds().into_iter().filter(|case| ["mimic_gripper", "parameters"].contains(&case.name));
    let functions: usize =
        of_kinds.map(|case| conforms(case.name, &case.builder.functions(FUNCTIONS))).sum();
    assert!(functions > 50, "{functions}");
}

#[test]
fn all_functions_of_a_small_robot() {
    let builder = robot("double_pendulum").functions(Function::ALL.iter().copied());
    assert!(conforms("all", &builder) > 100);
}
