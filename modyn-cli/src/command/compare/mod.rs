//! `modyn compare`: compiles a robot, to machine code or with rustc, and compares it with the
//! interpreter.

mod harness;
mod machine_code;
mod mujoco;
mod quantities;
mod timing;

use std::hint::black_box;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_codegen::{Function, ModuleChoice, condition_number, joints_without_inertia};
use modyn_runtime::model::Model;
use modyn_runtime::{Interpreter, LinkError, Scalar};
use serde_json::{Value, json};

use crate::command::choices::module_tree;
use crate::command::options::{Functions, functions, modules};
use crate::command::outcome::{Failure, to_stderr, to_stdout};
use crate::command::progress::Progress;
use crate::command::robot::Robot;
use crate::command::table::Table;
use crate::escape;
use crate::random::Random;
use harness::{Harness, Measured};
use machine_code::MachineCode;
use quantities::{Quantity, State, quantities};

/// Compile a robot and compare it with the interpreter on random states, or compare an MJCF with
/// MuJoCo
///
/// The robot is compiled to machine code in milliseconds, or with --rustc as the Rust text that
/// `modyn generate` writes. With --mujoco, steps of an MJCF are compared with MuJoCo's, from random
/// states near its first keyframe. The exit code is 0 if they agree, 1 if they differ or the
/// description is rejected, 2 if it cannot be compiled, or MuJoCo cannot be run, on this machine.
#[derive(Args)]
pub struct Arguments {
    /// The number of random states
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    states: u32,
    /// The seed of the random states
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// The largest allowed difference, relative to the largest number of a result. For functions
    /// that divide by the mass matrix it is multiplied by the mass matrix's condition number; after
    /// 50 steps it is multiplied by 100 [default: 1e-10, and 1e-8 with --mujoco]
    #[arg(long, value_name = "X")]
    tolerance: Option<f64>,
    /// The functions to compare, separated by commas [default: all that can be compared]
    #[arg(long, value_name = "NAMES", value_parser = functions)]
    functions: Option<Functions>,
    /// The kinematic modules: `chains`, `links`, or a list such as [["a", "b"], ["c"]]
    #[arg(long, value_name = "MODULES", value_parser = modules)]
    modules: Option<ModuleChoice>,
    /// Compile the generated Rust with rustc, instead of machine code
    #[arg(long)]
    rustc: bool,
    /// Let rustc compile for the processor of this machine, as machine code always is
    #[arg(long, requires = "rustc")]
    native: bool,
    /// Keep the sources and the program of rustc in this folder
    #[arg(long, value_name = "FOLDER", requires = "rustc")]
    keep: Option<PathBuf>,
    /// Compare one step and 50 steps of this MJCF with MuJoCo's, which runs in Python
    #[arg(
        long,
        conflicts_with_all = ["rustc", "functions", "modules", "actuators", "contacts", "ground"],
    )]
    mujoco: bool,
    /// The Python that has the package `mujoco` [default: python3]
    #[arg(long, value_name = "PATH", requires = "mujoco")]
    python: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    robot: Robot,
}

/// The allowed difference between compiled code and the interpreter.
const TOLERANCE: f64 = 1e-10;

/// The comparison of a function.
struct Row {
    name: &'static str,
    difference: f64,
    bound: f64,
    /// The time of a call, in nanoseconds.
    interpreted: f64,
    compiled: f64,
}

impl Row {
    fn agrees(&self) -> bool {
        // NaN agrees with nothing.
        self.difference <= self.bound
    }
}

/// What the compiled robot computes, and how it was compiled.
struct Outcome {
    model: Model,
    states: Vec<State>,
    measured: Vec<Measured>,
    compiler: String,
    compiled_in: Duration,
}

/// Compares, and prints the result.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.mujoco {
        return mujoco::run(arguments);
    }
    let tolerance = arguments.tolerance.unwrap_or(TOLERANCE);
    let rustc = arguments.rustc.then(harness::rustc).transpose()?;
    let description = arguments.robot.open()?;
    let read = description.read(&arguments.robot.options.read_options());
    let reading =
        read.map_err(|diagnostics| description.failure(arguments.robot.named(diagnostics)))?;
    let quantities = arguments.quantities(joints_without_inertia(&reading.model).is_empty())?;
    let mut builder = arguments.robot.builder(&description);
    builder = builder.functions(quantities.iter().map(|quantity| quantity.function));
    if let Some(choice) = &arguments.modules {
        builder = builder.modules(choice.clone());
    }
    let mut progress = Progress::start("compiling");
    let failure = |diagnostics| description.failure(arguments.robot.named(diagnostics));
    let warn = |warnings| description.warn(arguments.robot.named(Diagnostics::new(warnings)));
    let outcome = if let Some(rustc) = &rustc {
        let generated = builder.self_contained().generate().map_err(failure)?;
        warn(generated.warnings);
        let states = arguments.states(&arguments.interpreter(&generated.model)?)?;
        progress.show("compiling with rustc");
        let start = Instant::now();
        let harness = Harness {
            rustc,
            robot: &generated.text,
            type_name: &generated.type_name,
            quantities: &quantities,
            native: arguments.native,
            keep: arguments.keep.as_deref(),
        };
        let program = harness.compile(&generated.model)?;
        let compiled_in = start.elapsed();
        progress.show("comparing");
        let measured = program.run(&states)?;
        let compiler = rustc.version.clone();
        Outcome { model: generated.model, states, measured, compiler, compiled_in }
    } else {
        let planning = builder.plan().map_err(failure)?;
        warn(planning.warnings.clone());
        let states = arguments.states(&arguments.interpreter(&planning.model)?)?;
        let start = Instant::now();
        let code = MachineCode::compile(&planning)?;
        let compiled_in = start.elapsed();
        progress.show("comparing");
        let measured = code.run(&quantities, &states)?;
        let compiler = code.name();
        Outcome { model: planning.model, states, measured, compiler, compiled_in }
    };
    let mut interpreter = arguments.interpreter(&outcome.model)?;
    let mut single = arguments.interpreter::<f32>(&outcome.model)?;
    // An unknown or infinite condition number does not excuse larger differences.
    let condition = condition_number(&outcome.model).unwrap_or(1e6).clamp(1.0, 1e6);
    let mut rows = Vec::new();
    for (quantity, (results, compiled)) in quantities.iter().zip(&outcome.measured) {
        let (expected, interpreted) = interpret(&mut interpreter, quantity, &outcome.states)?;
        let relative = tolerance * ZERO;
        let zero = relative * cancelled(&mut single, quantity, &outcome.states, &expected)?;
        let difference = largest_difference(results, &expected, zero);
        let factor = if quantity.solves { condition } else { 1.0 };
        let bound = tolerance * factor;
        let name = quantity.function.name();
        rows.push(Row { name, difference, bound, interpreted, compiled: *compiled });
    }
    progress.stop();
    to_stdout(&if arguments.json {
        as_json(&outcome, &rows)
    } else {
        as_text(&outcome, &rows, arguments)
    })?;
    if let Some(folder) = &arguments.keep {
        to_stderr(&format!("kept in {}\n", sanitize_for_display(&folder.display().to_string())));
    }
    if rows.iter().all(Row::agrees) { Ok(()) } else { Err(Failure::Reported) }
}

impl Arguments {
    /// Returns the functions to compare; without dynamics those that need no inertia, unless others
    /// are named.
    fn quantities(&self, has_dynamics: bool) -> Result<Vec<Quantity>, Failure> {
        let chosen = |function: Function| {
            self.functions.as_ref().is_none_or(|Functions(list)| list.contains(&function))
        };
        let has = |one: &Quantity| {
            has_dynamics || self.functions.is_some() || !one.function.row().needs_inertia
        };
        let possible = || quantities().filter(|one| self.rustc || !one.needs_rustc()).filter(has);
        let quantities: Vec<_> = possible().filter(|one| chosen(one.function)).collect();
        if quantities.is_empty() {
            let names: Vec<&str> = possible().map(|one| one.function.name()).collect();
            return Err(Failure::usage(format!("error: compared can be: {}", names.join(", "))));
        }
        let Some(Functions(named)) = &self.functions else { return Ok(quantities) };
        let is_compared = |function| quantities.iter().any(|one| one.function == function);
        let left_out = named.iter().filter(|&&function| !is_compared(function));
        let names: Vec<&str> = left_out.map(|function| function.name()).collect();
        if !names.is_empty() {
            let help = if self.rustc { "" } else { "; `--rustc` also compares `brge`" };
            to_stderr(&format!("warning: not compared: {}{help}\n", names.join(", ")));
        }
        Ok(quantities)
    }

    fn interpreter<S: Scalar + PartialOrd>(
        &self,
        model: &Model,
    ) -> Result<Interpreter<S>, Failure> {
        let modules = module_tree(model, self.modules.as_ref())?;
        Interpreter::with_modules(model.clone(), modules)
            .map_err(|error| Failure::usage(format!("error: {error}")))
    }

    /// Returns coordinates within the limits, velocities up to 2, and forces or accelerations up
    /// to 10.
    fn states(&self, interpreter: &Interpreter<f64>) -> Result<Vec<State>, Failure> {
        let mut random = Random::new(self.seed);
        let nq = interpreter.model().nq();
        let nv = interpreter.model().nv();
        (0..self.states)
            .map(|_| {
                let mut q = vec![0.0; nq];
                interpreter.random_configuration(|| random.uniform(), &mut q).map_err(shape)?;
                let qd = (0..nv).map(|_| random.symmetric(2.0)).collect();
                let u = (0..nv).map(|_| random.symmetric(10.0)).collect();
                Ok(State { q, qd, u })
            })
            .collect()
    }
}

fn shape(error: impl Into<LinkError>) -> Failure {
    let error = error.into();
    Failure::usage(format!("error: {error}"))
}

/// Returns the results of all states, and the time of a call in nanoseconds.
fn interpret(
    interpreter: &mut Interpreter<f64>,
    quantity: &Quantity,
    states: &[State],
) -> Result<(Vec<Vec<f64>>, f64), Failure> {
    let interpreted: Result<Vec<Vec<f64>>, _> =
        states.iter().map(|state| quantity.interpret(interpreter, state)).collect();
    let results = interpreted.map_err(shape)?;
    let some = &states[..states.len().min(100)];
    let nanoseconds = timing::nanoseconds(some.len(), || {
        for state in some {
            let _ = black_box(quantity.interpret(interpreter, black_box(state)));
        }
    });
    Ok((results, nanoseconds))
}

/// The part of the tolerance at which a difference counts as zero, relative to terms that cancel.
const ZERO: f64 = 1e-3;

/// Returns an estimate of the size of the terms that cancel in the results of a function: the
/// largest error of single precision, divided by the unit of single precision. A result that is
/// zero by cancellation has no size of its own.
fn cancelled(
    interpreter: &mut Interpreter<f32>,
    quantity: &Quantity,
    states: &[State],
    expected: &[Vec<f64>],
) -> Result<f64, Failure> {
    let mut most = 0.0_f64;
    for (state, expected) in states.iter().zip(expected) {
        let rounded = quantity.interpret(interpreter, &state.rounded()).map_err(shape)?;
        for (&rounded, expected) in rounded.iter().zip(expected) {
            let error = (f64::from(rounded) - expected).abs();
            // Beyond the range of single precision there is no estimate.
            most = if error.is_finite() { most.max(error) } else { most };
        }
    }
    Ok(most / f64::from(f32::EPSILON))
}

/// Returns the largest difference over all states, relative to the largest number of each state's
/// result. Differences up to `zero` count as none.
fn largest_difference(results: &[Vec<f64>], expected: &[Vec<f64>], zero: f64) -> f64 {
    let mut worst = 0.0_f64;
    for (result, expected) in results.iter().zip(expected) {
        let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let size = if largest > 0.0 { largest } else { 1.0 };
        if result.len() != expected.len() {
            return f64::INFINITY;
        }
        for (x, expected) in result.iter().zip(expected) {
            let distance = (x - expected).abs();
            let difference = if distance <= zero { 0.0 } else { distance / size };
            // NaN counts as an infinite difference.
            worst = if difference.is_nan() { f64::INFINITY } else { worst.max(difference) };
        }
    }
    worst
}

fn as_text(outcome: &Outcome, rows: &[Row], arguments: &Arguments) -> String {
    let head = [
        "function",
        "largest difference",
        "allowed",
        "interpreter, ns",
        "compiled, ns",
        "times as fast",
        "",
    ];
    let mut table = Table::new(&head);
    for row in rows {
        table.row([
            row.name.into(),
            format!("{:.1e}", row.difference),
            format!("{:.1e}", row.bound),
            format!("{:.0}", row.interpreted),
            format!("{:.0}", row.compiled),
            format!("{:.0}", row.interpreted / row.compiled.max(1e-3)),
            if row.agrees() { "" } else { "DIFFERS" }.into(),
        ]);
    }
    let differing = rows.iter().filter(|row| !row.agrees()).count();
    let verdict = match differing {
        0 => "all agree".into(),
        count => format!("{count} of {} differ", rows.len()),
    };
    let note = if cfg!(debug_assertions) {
        "\n(this `modyn` is a debug build: the interpreter is many times slower in it)"
    } else {
        ""
    };
    format!(
        "{}: {} states (seed {}), {}, compiled in {:.3} s{note}\n\n{}\n{verdict}\n",
        sanitize_for_display(outcome.model.name()),
        arguments.states,
        arguments.seed,
        outcome.compiler,
        outcome.compiled_in.as_secs_f64(),
        table.right_aligned_from(1).text(),
    )
}

fn as_json(outcome: &Outcome, rows: &[Row]) -> String {
    let row = |row: &Row| {
        json!({
            "name": row.name,
            // JSON has no infinity.
            "difference": row.difference.is_finite().then_some(row.difference),
            "allowed": row.bound,
            "agrees": row.agrees(),
            "interpreter_ns": row.interpreted,
            "compiled_ns": row.compiled,
        })
    };
    let all = json!({
        "robot": outcome.model.name(),
        "compiler": outcome.compiler,
        "agrees": rows.iter().all(Row::agrees),
        "compiled_in_s": outcome.compiled_in.as_secs_f64(),
        "functions": rows.iter().map(row).collect::<Value>(),
    });
    escape::json(&all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_found() {
        let differ = |a: &[f64], b: &[f64]| largest_difference(&[a.to_vec()], &[b.to_vec()], 0.0);
        assert!((differ(&[1.0, 10.5], &[1.0, 10.0]) - 0.05).abs() < 1e-15);
        assert!((differ(&[0.1], &[0.0]) - 0.1).abs() < 1e-15);
        assert!(differ(&[f64::NAN, 1.0], &[1.0, 1.0]).is_infinite());
        assert!(differ(&[1.0], &[1.0, 1.0]).is_infinite());
        // Two zeros, with other rounding.
        let zeros = |zero: f64| largest_difference(&[vec![-4.7e-18]], &[vec![-3.5e-18]], zero);
        assert!(zeros(0.0) > 0.1 && zeros(1e-17) <= 0.0 && zeros(1e-19) > 0.1);
        let row =
            Row { name: "", difference: f64::NAN, bound: 1.0, interpreted: 1.0, compiled: 1.0 };
        assert!(!row.agrees());
    }
}
