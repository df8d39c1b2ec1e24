//! C99, by the compilers of the host, and of aarch64 in an emulator; and the program in C that calls functions of any
//! back end.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::{Builder, Emitted, FloatType, Target};

use super::{Arithmetic, BackEnd, Call, STATES, Subject, command, read_results, write_numbers};

/// A compiler with options, and the program that runs its programs.
pub struct C {
    compiler: &'static [&'static str],
    level: &'static str,
    runner: &'static [&'static str],
    programs: &'static [&'static str],
}

/// C99 without extensions, warnings and contraction.
pub const STRICT: [&str; 6] =
    ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"];

impl C {
    /// Returns GCC.
    #[must_use]
    pub fn gcc() -> Self {
        Self { compiler: &["gcc"], level: "-O1", runner: &[], programs: &[] }
    }

    /// Returns Clang.
    #[must_use]
    pub fn clang() -> Self {
        Self { compiler: &["clang"], level: "-O1", runner: &[], programs: &["clang"] }
    }

    /// Returns the compiler without optimisation, which takes a quarter of the time. GCC and Clang optimise the same text.
    #[must_use]
    pub fn unoptimised(self) -> Self {
        Self { level: "-O0", ..self }
    }

    /// Returns GCC for aarch64, whose programs run in QEMU.
    #[must_use]
    pub fn aarch64() -> Self {
        let programs = &["aarch64-linux-gnu-gcc", "qemu-aarch64"];
        Self {
            compiler: &["aarch64-linux-gnu-gcc", "-static"],
            level: "-O1",
            runner: &["qemu-aarch64"],
            programs,
        }
    }
}

impl BackEnd for C {
    type Robot = Emitted;

    fn name(&self) -> String {
        self.compiler[0].into()
    }

    fn programs(&self) -> &[&'static str] {
        self.programs
    }

    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::Separate
    }

    fn make(&self, builder: &Builder) -> Result<Emitted, Diagnostics> {
        builder.emit(Target::C)
    }

    fn run(&self, subject: &Subject<'_, Emitted>, folder: &Path) -> Vec<Vec<f64>> {
        write(subject.robot, folder);
        write_main(subject, folder, call);
        let (compiler, options) = self.compiler.split_first().expect("a compiler");
        let mut compile = Command::new(compiler);
        compile.args(options).args(STRICT).arg(self.level);
        compile.args(["main.c", "ours.c", "-o", "main", "-lm"]);
        command(compile.current_dir(folder));
        let run = [self.runner, &["./main"]].concat();
        execute(subject, folder, &run)
    }
}

/// Writes the files of a robot. C needs the mathematical library alone.
///
/// # Panics
///
/// If a file cannot be written, or needs another header.
pub fn write(emitted: &Emitted, folder: &Path) {
    for file in &emitted.files {
        for foreign in ["malloc", "stdlib", "string.h", "stdint.h"] {
            assert!(emitted.target != Target::C || !file.text.contains(foreign), "{foreign}");
        }
        std::fs::write(folder.join(&file.name), &file.text).expect("writes");
    }
}

/// Runs the program `main` of a folder on the arguments of all calls, and returns its results. `run` is its command line, whose
/// program is found by its name unless it is `./main`.
///
/// # Panics
///
/// If the program fails.
pub fn execute<R>(subject: &Subject<'_, R>, folder: &Path, run: &[&str]) -> Vec<Vec<f64>> {
    let numbers = subject.calls.iter().flat_map(|call| call.arguments.iter().flatten());
    write_numbers(&folder.join("in"), numbers, subject.float);
    let mut program = match run {
        ["./main"] => Command::new(folder.join("main")),
        _ => Command::new(run[0]),
    };
    command(program.args(&run[1..]).current_dir(folder));
    read_results(&folder.join("out"), &subject.calls, subject.float)
}

/// Returns the statement that calls a function of C: `arguments` are the names of arrays, each followed by a comma.
#[must_use]
pub fn call(call: &Call, arguments: &str) -> String {
    let (name, with) = (&call.function, if call.has_parameters { "_with" } else { "" });
    match call.link {
        // A link that does not exist is refused, and nothing is written.
        Some(link) => format!(
            "if (ours_{name}{with}({arguments}{link}U, x) != 1 || ours_{name}{with}({arguments}4000000000U, x) != 0) return 1;"
        ),
        None => format!("ours_{name}{with}({arguments}x);"),
    }
}

/// Writes the program `main.c` that calls functions of the header `ours.h`: see [`main_of`].
///
/// # Panics
///
/// If the file cannot be written.
pub fn write_main<R>(
    subject: &Subject<'_, R>,
    folder: &Path,
    call: impl Fn(&Call, &str) -> String,
) {
    let text = main_of(subject, "#include \"ours.h\"\n", call);
    std::fs::write(folder.join("main.c"), text).expect("writes");
}

/// Returns the text of a program, in C and C++, that reads the arguments of all calls, and writes the results. Its arrays are not aligned to
/// vectors. `call` returns a statement that calls a function with the pointers of this text, each followed by a comma, and
/// writes its result to `x`.
#[must_use]
pub fn main_of<R>(
    subject: &Subject<'_, R>,
    head: &str,
    call: impl Fn(&Call, &str) -> String,
) -> String {
    let real = if subject.float == FloatType::F64 { "double" } else { "float" };
    let mut text = format!(
        "#include <stdio.h>\ntypedef {real} real;\n{head}static FILE *in, *out;\n\
         static int get(void *x, size_t n) {{ return fread(x, sizeof(real), n, in) == n; }}\n\
         static int put(const void *x, size_t n) {{ return fwrite(x, sizeof(real), n, out) == n; }}\n"
    );
    let mut main = String::new();
    for (number, own) in subject.calls.chunks(STATES).enumerate() {
        let one = &own[0];
        let _ = writeln!(text, "static int f{number}(void)\n{{\n    int s;");
        let (mut names, mut reads) = (String::new(), String::new());
        for (i, argument) in one.arguments.iter().enumerate() {
            let _ = writeln!(
                text,
                "    static real m{i}[{}]; void *const a{i} = m{i} + 1;",
                argument.len() + 1
            );
            let _ = writeln!(reads, "        if (!get(a{i}, {})) return 1;", argument.len());
            let _ = write!(names, "a{i}, ");
        }
        let len = one.expected.len();
        let _ = writeln!(
            text,
            "    static real m[{len} + 1]; void *const x = m + 1;\n    for (s = 0; s < {STATES}; ++s) {{\n{reads}        {}\n        \
             if (!put(x, {len})) return 1;\n    }}\n    return 0;\n}}",
            call(one, &names)
        );
        let _ = writeln!(main, "    if (f{number}()) return 1;");
    }
    // A back end may lack all functions of a robot: then no call reads or writes.
    text += &format!(
        "int main(void)\n{{\n    in = fopen(\"in\", \"rb\");\n    out = fopen(\"out\", \"wb\");\n    \
         if (!in || !out) return 2;\n    (void)get;\n    (void)put;\n{main}    return fclose(out);\n}}\n"
    );
    text
}
