//! C99 that `CasADi` loads by `casadi.external`: one source file that needs `<math.h>` only.
//!
//! A function has the signature of `CasADi`'s own generated C: pointers to the nonzeros of all
//! inputs and results, of which each may be null, and arrays for work. Further functions describe
//! it: names, sparsities, sizes. The programs are printed as in [C](super::c).

use std::collections::BTreeMap;
use std::fmt::Write as _;

use modyn_runtime::model::{Model, ModuleTree};

use super::c::{Array, Printer};
use super::{Backend, EmitOptions, File, FloatType, PlannedRobot, Refused};
use crate::plan::{CasadiFunction, CasadiMatrix, Choices, Function, Plan, TooLong};
use crate::program::Execution;

/// The back end.
pub(super) struct Casadi;

impl Backend for Casadi {
    fn execution(&self, _: &EmitOptions) -> Execution {
        Execution::Scalar
    }

    fn print(&self, robot: &PlannedRobot<'_>) -> Vec<File> {
        vec![File::new(format!("{}.c", robot.stem), print(robot))]
    }

    fn with_origin(&self, text: &str, origin: &str) -> String {
        format!("/* {origin} */\n{text}")
    }

    fn plan(
        &self,
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        _: &EmitOptions,
    ) -> Result<Plan, TooLong> {
        Plan::for_casadi(model, modules, choices)
    }

    fn refused(&self) -> &'static [Refused] {
        &[
            Refused {
                option: "scalar",
                message: "`CasADi` computes in double precision",
                help: "remove the option `scalar`",
            },
            Refused {
                option: "fused",
                message: "`CasADi` has no fused functions",
                help: "select the functions of the fused function by `functions`",
            },
            Refused {
                option: "function",
                message: "`CasADi` has no functions of users",
                help: "write the function in CasADi, of the functions that modyn generates",
            },
        ]
    }

    fn lacks(&self, function: Function) -> Option<&'static str> {
        let row = function.row();
        let help = match row.has_solver {
            true => {
                "CasADi cannot differentiate a loop whose end depends on values: simulate by the target \
                 `c`, and let contact forces be variables of `forward_dynamics_external`"
            }
            false => "differentiate the functions in CasADi, by `jacobian` or `gradient`",
        };
        (!row.casadi).then_some(help)
    }
}

/// The types, and the visibility of functions.
const HEAD: &str = "\
#ifndef casadi_real
#define casadi_real double
#endif

/* acados takes functions over int: -Dcasadi_int=int. */
#ifndef casadi_int
#define casadi_int long long int
#endif

#ifndef CASADI_SYMBOL_EXPORT
#if defined(_WIN32) || defined(__CYGWIN__)
#define CASADI_SYMBOL_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define CASADI_SYMBOL_EXPORT __attribute__((visibility(\"default\")))
#else
#define CASADI_SYMBOL_EXPORT
#endif
#endif

typedef char modyn_casadi_real_is_double[(sizeof(casadi_real) == sizeof(double)) ? 1 : -1];

";

/// The functions that depend on nothing: reference counts, and memory of calls. There is no memory.
const MEMORY: &str = "\
CASADI_SYMBOL_EXPORT void NAME_incref(void) {}
CASADI_SYMBOL_EXPORT void NAME_decref(void) {}
CASADI_SYMBOL_EXPORT int NAME_alloc_mem(void) { return 0; }
CASADI_SYMBOL_EXPORT int NAME_init_mem(int mem) { (void)mem; return 0; }
CASADI_SYMBOL_EXPORT void NAME_free_mem(int mem) { (void)mem; }
CASADI_SYMBOL_EXPORT int NAME_checkout(void) { return 0; }
CASADI_SYMBOL_EXPORT void NAME_release(int mem) { (void)mem; }
CASADI_SYMBOL_EXPORT casadi_real NAME_default_in(casadi_int i) { (void)i; return 0; }
";

/// Returns the text of all functions.
fn print(robot: &PlannedRobot<'_>) -> String {
    let functions = &robot.plan.casadi.functions;
    let prefix = robot.prefix();
    let inputs = functions.iter().flat_map(|function| &function.inputs);
    let zeros = inputs.map(CasadiMatrix::len).max().unwrap_or(0).max(1);
    let mut printer = Printer::new(&prefix, FloatType::F64);
    let mut patterns = Patterns::default();
    for function in functions {
        print_function(&mut printer, &mut patterns, &function.full_name(&prefix), function);
    }
    format!(
        "/* Dynamics of a robot, compiled by modyn for CasADi. SI units, radians; gravity {:?} \
         m/s^2 in world axes.\n   \
         Vectors are in the order of the description's joints, depth first. Quaternions of any \
         length but 0 are scaled to\n   \
         length 1; one of length 0 is the identity, without derivatives. Results must not overlap inputs. */\n\
         #include <math.h>\n\n{HEAD}{}{}\
         /* The inputs that are null. */\nstatic const double modyn_zeros[{zeros}] = {{ 0 }};\n\n{}",
        robot.model.gravity(),
        printer.support(),
        patterns.text,
        printer.source
    )
}

/// The table of patterns, each once.
#[derive(Default)]
struct Patterns {
    numbers_of: BTreeMap<Vec<usize>, usize>,
    text: String,
}

impl Patterns {
    /// Returns the name of the array of a matrix's pattern.
    fn name(&mut self, matrix: &CasadiMatrix) -> String {
        let numbers = matrix.compressed_columns();
        let next = self.numbers_of.len();
        let number = *self.numbers_of.entry(numbers.clone()).or_insert(next);
        if number == next {
            let list: Vec<String> = numbers.iter().map(usize::to_string).collect();
            let _ = writeln!(
                self.text,
                "static const casadi_int modyn_pattern{number}[{}] = {{ {} }};\n",
                numbers.len(),
                list.join(", ")
            );
        }
        format!("modyn_pattern{number}")
    }
}

/// Prints a function and the functions that describe it.
fn print_function(
    printer: &mut Printer,
    patterns: &mut Patterns,
    name: &str,
    function: &CasadiFunction,
) {
    let CasadiFunction { docs, inputs, outputs, program, .. } = function;
    let nonempty = inputs.iter().filter(|input| !input.is_empty());
    let given: Vec<Array> =
        nonempty.map(|input| Array { name: input.name.clone(), len: input.len() }).collect();
    let results: usize = outputs.iter().map(CasadiMatrix::len).sum();
    if results > 0 {
        printer.function("static ", &format!("{name}_values"), &given, results, program);
    }

    let text = &mut printer.source;
    if let Some(docs) = docs {
        let _ = writeln!(text, "/* {} */", docs.replace('\n', "\n   "));
    }
    let _ = writeln!(
        text,
        "CASADI_SYMBOL_EXPORT int {name}(const casadi_real** arg, casadi_real** res, casadi_int* \
         iw, casadi_real* w, int mem)\n{{"
    );
    *text += &body(name, inputs, outputs);
    *text += "}\n\n";

    for (end, matrices) in [("in", inputs), ("out", outputs)] {
        let count = matrices.len();
        let _ = writeln!(
            text,
            "CASADI_SYMBOL_EXPORT casadi_int {name}_n_{end}(void) {{ return {count}; }}\n"
        );
        let case = |(i, value): (usize, String)| format!("    case {i}: return {value};\n");
        let quoted = matrices.iter().map(|matrix| format!("\"{}\"", matrix.name));
        let names: String = quoted.enumerate().map(case).collect();
        let patterns_of_matrices = matrices.iter().map(|matrix| patterns.name(matrix));
        let sparsities: String = patterns_of_matrices.enumerate().map(case).collect();
        for (what, kind, cases) in
            [("name", "const char*", names), ("sparsity", "const casadi_int*", sparsities)]
        {
            let _ = writeln!(
                text,
                "CASADI_SYMBOL_EXPORT {kind} {name}_{what}_{end}(casadi_int i)\n{{\n    switch (i) \
                 {{\n{cases}    default: return 0;\n    }}\n}}\n"
            );
        }
    }
    let sizes = [
        ("arg", inputs.len(), "const casadi_real*"),
        ("res", outputs.len(), "casadi_real*"),
        ("iw", 0, "casadi_int"),
        ("w", work(outputs), "casadi_real"),
    ];
    for in_bytes in [false, true] {
        let end = if in_bytes { "_bytes" } else { "" };
        let _ = writeln!(
            text,
            "CASADI_SYMBOL_EXPORT int {name}_work{end}(casadi_int* sz_arg, casadi_int* sz_res, \
             casadi_int* sz_iw, casadi_int* sz_w)\n{{"
        );
        for (array, size, kind) in sizes {
            let factor =
                if in_bytes { format!(" * (casadi_int)sizeof({kind})") } else { String::new() };
            let _ = writeln!(text, "    if (sz_{array} != 0) {{ *sz_{array} = {size}{factor}; }}");
        }
        *text += "    return 0;\n}\n\n";
    }
    *text += &MEMORY.replace("NAME", name);
    *text += "\n";
}

/// Returns the number of work numbers: several results are computed there and copied.
fn work(outputs: &[CasadiMatrix]) -> usize {
    match nonempty(outputs).count() {
        0 | 1 => 0,
        _ => outputs.iter().map(CasadiMatrix::len).sum(),
    }
}

fn nonempty(matrices: &[CasadiMatrix]) -> impl Iterator<Item = (usize, &CasadiMatrix)> {
    matrices.iter().enumerate().filter(|(_, matrix)| !matrix.is_empty())
}

/// Returns the body of a function: a call on the inputs, and copies of the results that are wanted.
fn body(name: &str, inputs: &[CasadiMatrix], outputs: &[CasadiMatrix]) -> String {
    let mut text = String::from("    (void)iw;\n    (void)mem;\n");
    let pointers =
        nonempty(inputs).map(|(i, _)| format!("(arg[{i}] != 0) ? arg[{i}] : modyn_zeros, "));
    let given: String = pointers.collect();
    let results: Vec<(usize, &CasadiMatrix)> = nonempty(outputs).collect();
    if given.is_empty() || results.is_empty() {
        text += "    (void)arg;\n";
    }
    if let [] | [_] = &*results {
        text += "    (void)w;\n";
    }
    match &*results {
        [] => text += "    (void)res;\n",
        [(k, _)] => {
            let _ = writeln!(
                text,
                "    if (res[{k}] != 0) {{\n        {name}_values({given}res[{k}]);\n    }}"
            );
        }
        several => {
            let null_checks = several.iter().map(|(k, _)| format!("(res[{k}] == 0)"));
            let none = null_checks.collect::<Vec<_>>().join(" && ");
            let _ = writeln!(
                text,
                "    int i;\n    if ({none}) {{\n        return 0;\n    }}\n    {name}_values({given}w);"
            );
            let mut first = 0;
            for (k, matrix) in several {
                let len = matrix.len();
                let _ = writeln!(
                    text,
                    "    if (res[{k}] != 0) {{\n        for (i = 0; i < {len}; i++) {{ res[{k}][i] \
                     = w[{first} + i]; }}\n    }}"
                );
                first += len;
            }
        }
    }
    text + "    return 0;\n"
}
