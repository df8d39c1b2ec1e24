//! CUDA text, compiled for the host: threads run one after another.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use crate::conformance::{
    Arithmetic, BackEnd, Call, Case, STATES, Subject, command, conforms, read_results, robot,
    write_numbers,
};
use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::{Base, Builder, Emitted, FloatType, Function, Target};

/// CUDA's keywords and variables for a compiler of the host.
const SHIM: &str = concat!(
    "#include <cmath>\n#include <cstdio>\n#include <cstdlib>\n",
    include_str!("../cuda_shim.h"),
    "using namespace std;\n#include \"ours.cu\"\n"
);

pub struct Cuda;

impl BackEnd for Cuda {
    type Robot = Emitted;

    fn name(&self) -> String {
        "cuda".into()
    }

    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::Fused
    }

    fn make(&self, builder: &Builder) -> Result<Emitted, Diagnostics> {
        builder.emit(Target::Cuda)
    }

    fn run(&self, subject: &Subject<'_, Emitted>, folder: &Path) -> Vec<Vec<f64>> {
        std::fs::write(folder.join("ours.cu"), subject.robot.text()).expect("writes");
        let (mut text, mut main) = (SHIM.to_string(), String::new());
        let (mut numbers, mut order) = (Vec::new(), Vec::new());
        for kernel in &subject.robot.kernels {
            let own = |call: &Call| call.function == kernel.function && call.link == kernel.link;
            let first = subject.calls.iter().position(own).expect("calls of the kernel");
            let calls = &subject.calls[first..first + STATES];
            order.push(first);
            // Run-time parameters are common to all states: each state runs by itself then.
            let common = kernel.arguments.iter().any(|argument| argument.common);
            let (launches, states) = if common { (STATES, 1) } else { (1, STATES) };
            let (name, result) = (&kernel.name, kernel.result);
            let (mut arrays, mut reads) = (String::new(), String::new());
            for (a, argument) in kernel.arguments.iter().enumerate() {
                let len = argument.len * states;
                let _ = writeln!(text, "static double {name}_a{a}[{len}];");
                let _ = write!(arrays, "{name}_a{a}, ");
                let _ = write!(reads, "get({name}_a{a}, {len}); ");
            }
            for launch in 0..launches {
                let of_launch = &calls[launch * states..][..states];
                for (a, argument) in kernel.arguments.iter().enumerate() {
                    let column = (0..argument.len)
                        .flat_map(|j| of_launch.iter().map(move |call| call.arguments[a][j]));
                    numbers.extend(column);
                }
            }
            let _ = writeln!(text, "static double {name}_x[{}];", result * states);
            let _ = writeln!(
                main,
                "for (int k = 0; k < {launches}; ++k) {{ {reads}\nfor (unsigned i = 0; i < 12; ++i) {{ \
                 blockIdx.x = i / 4; threadIdx.x = i % 4; {name}({arrays}{name}_x, {states}); }}\n\
                 for (int i = 0; i < {states}; ++i) for (int j = 0; j < {result}; ++j) \
                 fwrite(&{name}_x[j * {states} + i], sizeof(double), 1, out); }}"
            );
        }
        let text = format!(
            "static void get(double *x, unsigned long n);\n{text}static FILE *in, *out;\n\
             static void get(double *x, unsigned long n) {{ if (fread(x, sizeof *x, n, in) != n) exit(1); }}\n\
             int main() {{\nblockDim.x = 4;\nin = fopen(\"in\", \"rb\");\nout = fopen(\"out\", \"wb\");\n{main}return fclose(out);\n}}\n"
        );
        std::fs::write(folder.join("main.cpp"), text).expect("writes");
        write_numbers(&folder.join("in"), &numbers, subject.float);
        let mut compile = Command::new("g++");
        // NVIDIA's compilers optimise the same text in `tests/cuda/run`.
        compile.args(["-std=c++17", "-O0", "-ffp-contract=off", "-Wall", "-Wno-unused-function"]);
        compile.args(["-Wno-unused-variable", "main.cpp", "-lm", "-o", "main"]);
        command(compile.current_dir(folder));
        command(Command::new(folder.join("main")).current_dir(folder));
        assert_eq!(order.len() * STATES, subject.calls.len(), "each function is a kernel");
        assert!(order.is_sorted(), "kernels have the order of functions");
        read_results(&folder.join("out"), &subject.calls, subject.float)
    }
}

/// Derivatives of floating bases are cut into functions, whose values go through memory.
#[test]
#[ignore = "slow: g++ compiles a robot"]
fn long_functions_are_cut() {
    let functions = [Function::ForwardDynamicsDerivatives, Function::Jacobian];
    let builder = robot("quadruped").functions(functions).base(Base::Floating);
    let emitted = builder.emit(Target::Cuda).expect("good");
    assert!(emitted.text().contains("__noinline__"), "no function was cut");
    assert!(emitted.kernels.iter().any(|kernel| kernel.statements > 5000));
    conforms(&Cuda, &Case { name: "cut", builder }, FloatType::F64);
}
