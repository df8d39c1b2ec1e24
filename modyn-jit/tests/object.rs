//! Object files: C programs link them, in executables, static executables and shared libraries, and compute the bits of the
//! same functions in memory.

#![cfg(all(feature = "object", target_arch = "x86_64", target_os = "linux"))]

use crate::common;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::{Fuse, instruction_sets, is_same, numbers, robot, split};
use modyn_codegen::{Builder, Bundle, FloatType, Function};
use modyn_jit::object::{Object, ObjectBuilder, ObjectFormat, ObjectOptions};
use modyn_jit::{Call, Compiled, InstructionSet, Options};

/// The states that each function is called with.
const STATES: usize = 5;

fn run(command: &mut Command) -> Vec<u8> {
    let output = command.output().expect("the command runs");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}\n{message}");
    output.stdout
}

/// Returns the C compilers of this machine: one at least.
fn compilers() -> Vec<&'static str> {
    let works = |compiler: &&str| {
        let mut command = Command::new(compiler);
        command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    let compilers: Vec<&str> = ["gcc", "clang", "cc"].into_iter().filter(works).collect();
    assert!(!compilers.is_empty(), "a C compiler");
    compilers.into_iter().take(2).collect()
}

fn options(instruction_set: InstructionSet) -> ObjectOptions {
    let mut options = ObjectOptions::default();
    (options.instruction_set, options.format) = (instruction_set, ObjectFormat::Elf);
    options.prefix = Some("robot".into());
    options
}

/// Writes the object, its library, its header and a program that calls all functions.
fn write(folder: &Path, object: &Object, program: &str) {
    let files: [(&str, &[u8]); 4] = [
        ("robot.o", &object.bytes),
        ("librobot.a", &object.static_library().expect("a library")),
        ("robot.h", object.header.as_bytes()),
        ("main.c", program.as_bytes()),
    ];
    for (name, bytes) in files {
        std::fs::write(folder.join(name), bytes).expect("writable");
    }
}

/// A way to make a program of the object.
#[derive(Clone, Copy, Debug)]
enum Link {
    Executable,
    Static,
    Shared,
}

fn link(folder: &Path, compiler: &str, how: Link) -> PathBuf {
    let program = folder.join(format!("{compiler}-{how:?}"));
    // Code that had to be changed when it is loaded, or a stack with code, would be errors.
    let strict = ["-Wl,-z,text", "-Wl,-z,defs", "-Wl,--fatal-warnings"];
    let mut command = Command::new(compiler);
    command.current_dir(folder).args(["-Wall", "-Wextra", "-Werror", "-std=c99", "-pedantic"]);
    match how {
        Link::Executable => {
            command.args(["-fPIE", "-pie", "main.c", "robot.o"]).args(strict);
        }
        Link::Static => {
            command.args(["-static", "main.c", "-L.", "-lrobot"]);
        }
        Link::Shared => {
            let library = format!("librobot-{compiler}.so");
            let mut shared = Command::new(compiler);
            shared.current_dir(folder).args(["-shared", "robot.o", "-o", &library]).args(strict);
            run(&mut shared);
            let path = format!("-Wl,-rpath,{}", folder.display());
            command.args(["-fPIE", "-pie", "main.c", &library, &path]);
        }
    }
    run(command.arg("-o").arg(&program));
    program
}

/// Returns the arguments of a call, in the order of its states, for each link of a function of one link.
fn states<F: Fuse>(call: &Call<'_, F>, seed: u64) -> Vec<Vec<F>> {
    let count = call.arguments().iter().map(|(_, shape)| shape.len()).sum();
    // Small angles, some beyond the fast reduction, and infinities.
    let scales = [1.0, 3.0, 3e5, 1e20];
    let mut states: Vec<Vec<F>> =
        (seed..).zip(scales).map(|(seed, scale)| numbers(seed, count, scale)).collect();
    let mut last: Vec<F> = numbers(seed + 9, count, 2.0);
    if let Some(number) = last.first_mut() {
        *number = F::from_f64(f64::INFINITY);
    }
    states.push(last);
    states
}

/// A function that the C program calls.
struct Called {
    name: String,
    /// The lengths of its arrays.
    arrays: Vec<usize>,
    results: usize,
    by_link: bool,
}

/// Returns a C program that reads the arguments of all calls and writes their results. Its arrays are not aligned to vectors.
fn program(functions: &[Called], links: usize, real: &str) -> String {
    let mut text = format!(
        "#include <stdio.h>\n#include \"robot.h\"\n\
         static {real} memory[8][200000];\n\
         static int get({real} *to, size_t n) {{ return fread(to, sizeof({real}), n, stdin) == n; }}\n\
         static int put(const {real} *from, size_t n) {{ return fwrite(from, sizeof({real}), n, stdout) == n; }}\n\
         int main(void) {{\n    unsigned int link;\n    int state;\n    {real} *out = memory[7] + 1;\n    \
         if (!robot_is_supported()) {{ return 3; }}\n"
    );
    for Called { name, arrays, results, by_link } in functions {
        let _ = writeln!(text, "    for (state = 0; state < {STATES}; state++) {{");
        let mut arguments = String::new();
        for (k, length) in arrays.iter().enumerate().filter(|(_, length)| **length > 0) {
            let _ = writeln!(text, "        if (!get(memory[{k}] + 1, {length})) {{ return 1; }}");
            let _ = write!(arguments, "memory[{k}] + 1, ");
        }
        let _ = if *by_link {
            writeln!(
                text,
                "        for (link = 0; link < {links}U; link++) {{\n            \
                 if (robot_{name}({arguments}link, out) != 1 || !put(out, {results})) {{ return 1; }}\n        }}\n        \
                 if (robot_{name}({arguments}{links}U, out) != 0 || robot_{name}({arguments}4000000000U, out) != 0) \
                 {{ return 4; }}"
            )
        } else {
            writeln!(
                text,
                "        robot_{name}({arguments}out);\n        if (!put(out, {results})) {{ return 1; }}"
            )
        };
        text.push_str("    }\n");
    }
    text + "    (void)link;\n    return 0;\n}\n"
}

/// Runs a program on numbers, and returns the numbers that it writes.
fn numbers_of<F: Fuse>(program: &Path, numbers: &[F]) -> Vec<F> {
    let size = size_of::<F>();
    let bytes: Vec<u8> =
        numbers.iter().flat_map(|x| x.bits().to_le_bytes()[..size].to_vec()).collect();
    let input = program.with_extension("in");
    std::fs::write(&input, bytes).expect("writable");
    let input = std::fs::File::open(&input).expect("readable");
    let output = run(Command::new(program).stdin(input));
    let number = |bytes: &[u8]| {
        let mut all = [0; 8];
        all[..size].copy_from_slice(bytes);
        F::of_bits(u64::from_le_bytes(all))
    };
    output.chunks_exact(size).map(number).collect()
}

/// Compares all functions of a robot.
fn compare<F: Fuse>(builder: &Builder, instruction_set: InstructionSet, links: &[Link]) -> usize {
    let object = builder.generate_object(&options(instruction_set)).expect("an object");
    let mut of_memory = Options::default();
    of_memory.instruction_set = Some(instruction_set);
    let compiled = Compiled::<F>::build(builder, of_memory).expect("code");
    let functions = compiled.functions().filter(|&function| function != Function::Brge);
    let functions: Vec<Call<'_, F>> = functions
        .map(|function| compiled.function(function).expect("compiled"))
        .chain(compiled.bundles().map(|name| compiled.bundle(name).expect("compiled")))
        .collect();
    let frames = compiled.model().frames().len();
    let (mut called, mut given, mut expected) = (Vec::new(), Vec::new(), Vec::new());
    let names = compiled.functions().filter(|&function| function != Function::Brge);
    let names = names.map(Function::name).chain(compiled.bundles());
    for ((call, name), seed) in functions.iter().zip(names).zip((0..).step_by(10)) {
        let arrays: Vec<usize> = call.arguments().iter().map(|(_, shape)| shape.len()).collect();
        let results = call.result().len();
        let mut by_link = false;
        for state in states(call, seed) {
            let arguments = split(&state, &arrays);
            let mut result = vec![F::from_f64(f64::NAN); results];
            if call.one(&arguments, &mut result).is_ok() {
                expected.extend(result);
            } else {
                by_link = true;
                for link in 0..frames {
                    call.link(link, &arguments, &mut result).expect("of a link");
                    expected.extend(&result);
                }
            }
            given.extend(state);
        }
        called.push(Called { name: name.into(), arrays, results, by_link });
    }
    let real = if size_of::<F>() == 8 { "double" } else { "float" };
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), &object, &program(&called, frames, real));
    for compiler in compilers() {
        for &how in links {
            let found = numbers_of(&link(folder.path(), compiler, how), &given);
            assert_eq!(found.len(), expected.len());
            for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
                assert!(is_same(*a, *b), "{compiler} {how:?} {instruction_set:?} {i}: {a:?} {b:?}");
            }
        }
    }
    expected.len()
}

fn all(name: &str) -> Builder {
    Builder::new().model(robot(name)).functions(Function::ALL.iter().copied())
}

#[test]
fn an_arm_in_executables_and_libraries() {
    for instruction_set in instruction_sets() {
        let links = [Link::Executable, Link::Static, Link::Shared];
        let count = compare::<f64>(&all("arm6"), instruction_set, &links);
        assert!(count > 5000, "{count}");
    }
}

#[test]
fn single_precision() {
    for instruction_set in instruction_sets() {
        let builder = all("arm6").scalar(FloatType::F32);
        let count = compare::<f32>(&builder, instruction_set, &[Link::Executable]);
        assert!(count > 5000, "{count}");
    }
}

/// Loops, quaternions, packed limbs and bundles; with run-time parameters as in the description.
#[test]
fn other_robots() {
    let bundle =
        Bundle::new("control").function(Function::MassMatrix).function(Function::LinkPoses);
    let quadruped = Builder::new().model(robot("quadruped"));
    let functions =
        [Function::ForwardDynamics, Function::LinkPose, Function::LinkPoses, Function::Difference];
    for instruction_set in instruction_sets() {
        let mut count = 0;
        for builder in [
            all("four_bar"),
            Builder::new().model(robot("joint_zoo")).runtime_gravity(),
            quadruped.clone().functions(functions).bundles([bundle.clone()]),
        ] {
            count += compare::<f64>(&builder, instruction_set, &[Link::Executable]);
        }
        assert!(count > 3000, "{count}");
    }
}

/// A program that runs a function one instruction at a time. At each instruction, the descriptions of stack frames lead to the
/// caller, with the registers that it had.
const STEPS: &str = r#"
#define _GNU_SOURCE
#include <signal.h>
#include <stdio.h>
#include <ucontext.h>
#include <unwind.h>
#include "robot.h"

static volatile int seen, wrong;
static volatile long steps;
static unsigned long rbx, rbp;
static double q[ROBOT_NQ], qd[ROBOT_NV], tau[ROBOT_NV], qdd[ROBOT_NV];

__attribute__((noinline)) static void caller(void)
{
    __asm__ volatile("pushfq; orq $0x100, (%rsp); popfq");
    robot_forward_dynamics(q, qd, tau, qdd);
    __asm__ volatile("pushfq; andq $~0x100, (%rsp); popfq");
}

static _Unwind_Reason_Code visit(struct _Unwind_Context *context, void *found)
{
    void *function = _Unwind_FindEnclosingFunction((void *)(_Unwind_GetIP(context) - 1));
    if (function != (void *)caller) { return _URC_NO_REASON; }
    *(int *)found = 1;
    if (_Unwind_GetGR(context, 3) != rbx || _Unwind_GetGR(context, 6) != rbp) { wrong++; }
    return _URC_END_OF_STACK;
}

static void step(int number, siginfo_t *information, void *data)
{
    const greg_t *registers = ((ucontext_t *)data)->uc_mcontext.gregs;
    int found = 0;
    (void)number; (void)information;
    if ((unsigned long)registers[REG_RIP] == (unsigned long)robot_forward_dynamics) {
        rbx = (unsigned long)registers[REG_RBX];
        rbp = (unsigned long)registers[REG_RBP];
        seen = 1;
    }
    if (!seen || _Unwind_FindEnclosingFunction((void *)registers[REG_RIP]) == (void *)caller) { return; }
    steps++;
    _Unwind_Backtrace(visit, &found);
    if (!found) { wrong++; }
}

int main(void)
{
    struct sigaction action = { 0 };
    int i;
    if (!robot_is_supported()) { return 3; }
    for (i = 0; i < ROBOT_NQ; i++) { q[i] = 1e9 * (i + 1); }
    action.sa_sigaction = step;
    action.sa_flags = SA_SIGINFO;
    sigaction(SIGTRAP, &action, NULL);
    caller();
    printf("%ld %d\n", steps, wrong);
    return 0;
}
"#;

#[test]
fn debuggers_find_the_caller_at_each_instruction() {
    for instruction_set in instruction_sets() {
        let object = all("arm6").generate_object(&options(instruction_set)).expect("an object");
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), &object, STEPS);
        let mut command = Command::new(compilers()[0]);
        command.current_dir(folder.path());
        command.args([
            "-O0",
            "-mno-red-zone",
            "-fno-omit-frame-pointer",
            "main.c",
            "robot.o",
            "-o",
            "main",
        ]);
        run(&mut command);
        let found =
            String::from_utf8(run(&mut Command::new(folder.path().join("main")))).expect("text");
        let (steps, wrong) = found.trim().split_once(' ').expect("two numbers");
        // The angles are large, so the code is longer than that of small ones.
        assert!(steps.parse::<u32>().expect("a number") > 1000, "{found}");
        assert_eq!(wrong, "0", "{found}");
    }
}
