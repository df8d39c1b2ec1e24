//! The times from the text of a description to a result.

use std::process::Command;
use std::time::Instant;

use modyn::Interpreter;
use modyn_codegen::{Builder, Function, ReadOptions, read};
use modyn_jit::{Compiled, Options};

use crate::calls;
use crate::robots::{self, Robot};

/// The processes of a row, of which the median counts: a process makes machine code once, as a tool does at its start.
const PROCESSES: usize = 11;
/// The functions of the table.
const FUNCTIONS: [&str; 4] = [
    "forward_dynamics",
    "forward_dynamics_derivatives",
    "constrained_forward_dynamics",
    "constrained_forward_dynamics_derivatives",
];
/// The numbers that a process prints: times in ms, memory in MB, code in kB.
const TITLES: [&str; 6] = [
    "text to model, ms",
    "model to programs, ms",
    "programs to code, ms",
    "text to first result, ms",
    "memory, MB",
    "code and constants, kB",
];

/// Returns a number of kB that the kernel knows about this process, in MB; 0 where it does not tell.
fn memory(name: &str) -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix(name));
    let number = line.and_then(|line| line.split_whitespace().nth(1)).map(str::parse::<f64>);
    number.and_then(Result::ok).unwrap_or_default() / 1e3
}

/// Reads the robot, makes machine code of one function, calls it once, and prints the numbers of [`TITLES`]. Memory is the
/// largest resident memory less that at the beginning.
pub fn one(robot: &Robot, quantity: &str) {
    let text = std::fs::read_to_string(&robot.description).expect("a description");
    let function = Function::from_name(quantity).expect("a function");
    let before = memory("VmRSS");
    let start = Instant::now();
    let mut times = Vec::new();
    let mut stage = |begun: Instant| times.push(begun.elapsed().as_secs_f64() * 1e3);

    let mut options = ReadOptions::default();
    options.base = robot.base;
    options.contacts.clone_from(&robot.contacts);
    let model = read(&text, "robot.urdf", &options).expect("a robot").model;
    stage(start);
    let begun = Instant::now();
    let planning = Builder::new().model(model).functions([function]).plan().expect("programs");
    stage(begun);
    let begun = Instant::now();
    let compiled = Compiled::<f64>::from_plan(&planning, Options::default()).expect("machine code");
    stage(begun);
    let call = compiled.function(function).expect("compiled");
    let mut neutral = vec![0.0; compiled.model().nq()];
    Interpreter::<f64>::new(compiled.model().clone()).neutral(&mut neutral).expect("sizes");
    let contacts = robot.contacts.len();
    let arguments: Vec<Vec<f64>> = call
        .arguments()
        .iter()
        .map(|(name, shape)| match *name {
            "q" => neutral.clone(),
            "active" | "settings" => calls::constant(name, contacts),
            _ => vec![0.1; shape.len()],
        })
        .collect();
    let arguments: Vec<&[f64]> = arguments.iter().map(Vec::as_slice).collect();
    let mut result = vec![f64::NAN; call.result().len()];
    call.one(&arguments, &mut result).expect("sizes");
    stage(start);
    assert!(result.iter().all(|number| number.is_finite()), "a result");
    let size = call.size();
    let memory = memory("VmHWM") - before;
    let code = (size.bytes + size.constants) as f64 / 1e3;
    let numbers: Vec<String> =
        times.into_iter().chain([memory, code]).map(|number| number.to_string()).collect();
    println!("{}", numbers.join(" "));
}

/// Returns the median of each number over several processes.
fn row(robot: &str, quantity: &str) -> [f64; TITLES.len()] {
    let program = std::env::current_exe().expect("this program");
    let runs: Vec<Vec<f64>> = (0..PROCESSES)
        .map(|_| {
            let done = Command::new(&program).args(["times-of", robot, quantity]).output();
            let done = done.expect("a process");
            assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
            let text = String::from_utf8(done.stdout).expect("text");
            text.split_whitespace().map(|word| word.parse().expect("a number")).collect()
        })
        .collect();
    std::array::from_fn(|k| {
        let mut numbers: Vec<f64> = runs.iter().map(|run| run[k]).collect();
        numbers.sort_by(f64::total_cmp);
        numbers[PROCESSES / 2]
    })
}

/// Prints the table as Markdown, for `lab/record`.
pub fn table() {
    println!("| robot | function | {} |", TITLES.join(" | "));
    println!("|{}", "---|".repeat(TITLES.len() + 2));
    for robot in robots::all() {
        for quantity in robot.quantities.iter().filter(|name| FUNCTIONS.contains(name)) {
            let numbers = row(&robot.name, quantity).map(|number| {
                if number >= 100.0 { format!("{number:.0}") } else { format!("{number:.3}") }
            });
            println!("| {} | `{quantity}` | {} |", robot.name, numbers.join(" | "));
        }
    }
}
