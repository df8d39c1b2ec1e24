//! C99, by the compilers of the host, and of aarch64 in an emulator.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use crate::suite::{
    Arithmetic, BackEnd, Call, STATES, Subject, command, read_results, write_numbers,
};
use modyn_codegen::{FloatType, Target};

/// A compiler with options, and the program that runs its programs.
pub struct C {
    compiler: &'static [&'static str],
    runner: &'static [&'static str],
    programs: &'static [&'static str],
}

/// C99 without extensions, warnings and contraction.
const STRICT: [&str; 7] =
    ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "-O1"];

impl C {
    pub fn gcc() -> Self {
        Self { compiler: &["gcc"], runner: &[], programs: &[] }
    }

    pub fn clang() -> Self {
        Self { compiler: &["clang"], runner: &[], programs: &["clang"] }
    }

    pub fn aarch64() -> Self {
        let programs = &["aarch64-linux-gnu-gcc", "qemu-aarch64"];
        Self {
            compiler: &["aarch64-linux-gnu-gcc", "-static"],
            runner: &["qemu-aarch64"],
            programs,
        }
    }
}

impl BackEnd for C {
    const TARGET: Target = Target::C;
    const ARITHMETIC: Arithmetic = Arithmetic::Separate;

    fn name(&self) -> String {
        self.compiler[0].into()
    }

    fn programs(&self) -> &[&'static str] {
        self.programs
    }

    fn run(&self, subject: &Subject, folder: &Path) -> Vec<Vec<f64>> {
        for file in &subject.emitted.files {
            for foreign in ["malloc", "stdlib", "string.h", "stdint.h"] {
                assert!(!file.text.contains(foreign), "{foreign}");
            }
            std::fs::write(folder.join(&file.name), &file.text).expect("writes");
        }
        let head = "#include \"ours.h\"\n";
        std::fs::write(folder.join("main.c"), driver(subject, head, c_call)).expect("writes");
        let (compiler, options) = self.compiler.split_first().expect("a compiler");
        let mut compile = Command::new(compiler);
        compile.args(options).args(STRICT).args(["main.c", "ours.c", "-o", "main", "-lm"]);
        command(compile.current_dir(folder));
        let run = [self.runner, &["./main"]].concat();
        execute(subject, folder, &run)
    }
}

/// Runs a driver on the arguments of all calls, and returns its results.
pub fn execute(subject: &Subject, folder: &Path, run: &[&str]) -> Vec<Vec<f64>> {
    let numbers = subject.calls.iter().flat_map(|call| call.arguments.iter().flatten());
    write_numbers(&folder.join("in"), numbers, subject.float);
    let main = folder.join("main");
    let mut program = match run {
        [one] if *one == "./main" => Command::new(main),
        _ => Command::new(run[0]),
    };
    command(program.args(&run[1..]).current_dir(folder));
    read_results(&folder.join("out"), &subject.calls, subject.float)
}

/// Returns the statement that calls a function of C: `arguments` are the names of arrays, each followed by a comma.
fn c_call(call: &Call, arguments: &str) -> String {
    let with = if call.has_parameters { "_with" } else { "" };
    match call.link {
        Some(link) => {
            format!("if (ours_{}{with}({arguments}{link}U, x) != 1) return 1;", call.function)
        }
        None => format!("ours_{}{with}({arguments}x);", call.function),
    }
}

/// Returns a program that reads the arguments of all calls, and writes the results.
pub fn driver(subject: &Subject, head: &str, call: impl Fn(&Call, &str) -> String) -> String {
    let real = if subject.float == FloatType::F64 { "double" } else { "float" };
    let mut text = format!(
        "#include <stdio.h>\n{head}typedef {real} real;\nstatic FILE *in, *out;\n\
         static int get(real *x, size_t n) {{ return fread(x, sizeof *x, n, in) == n; }}\n\
         static int put(const real *x, size_t n) {{ return fwrite(x, sizeof *x, n, out) == n; }}\n"
    );
    let mut main = String::new();
    for (number, own) in subject.calls.chunks(STATES).enumerate() {
        let one = &own[0];
        let _ = writeln!(text, "static int f{number}(void)\n{{\n    int s;");
        let (mut names, mut reads) = (String::new(), String::new());
        for (i, argument) in one.arguments.iter().enumerate() {
            let _ = writeln!(text, "    static real a{i}[{}];", argument.len());
            let _ = writeln!(reads, "        if (!get(a{i}, {})) return 1;", argument.len());
            let _ = write!(names, "a{i}, ");
        }
        let len = one.expected.len();
        let _ = writeln!(
            text,
            "    static real x[{len}];\n    for (s = 0; s < {STATES}; ++s) {{\n{reads}        {}\n        \
             if (!put(x, {len})) return 1;\n    }}\n    return 0;\n}}",
            call(one, &names)
        );
        let _ = writeln!(main, "    if (f{number}()) return 1;");
    }
    text + &format!(
        "int main(void)\n{{\n    in = fopen(\"in\", \"rb\");\n    out = fopen(\"out\", \"wb\");\n    \
         if (!in || !out) return 2;\n{main}    return fclose(out);\n}}\n"
    )
}
