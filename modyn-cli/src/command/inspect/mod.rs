//! `modyn inspect`: describes a robot, and the cost of its functions.

mod actuators;
mod advice;
mod json;
mod size;
mod text;

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use modyn_codegen::Reading;
use modyn_codegen::diagnostics::{Code, Diagnostic, Diagnostics};
use modyn_codegen::{Builder, Function, ModuleChoice, condition_number, joints_without_inertia};
use modyn_runtime::OperationCount;
use modyn_runtime::model::{Model, ModuleTree};

use crate::command::choices::module_tree;
use crate::command::diagnostics;
use crate::command::options::{Functions, functions, modules};
use crate::command::outcome::{Failure, to_file, to_stdout};
use crate::command::progress::Progress;
use crate::command::robot::Robot;
use crate::escape;
use crate::picture::{self, Sparsity};
use advice::Advice;

/// Show a robot: joints, masses, modules, suspicious properties; with `--functions`, the cost of
/// functions
///
/// The exit code is 0 if the description is valid, 1 if it is rejected.
#[derive(Args)]
pub struct Arguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Draw the module tree and the sparsity of the mass matrix and its factors U and D
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Show the operations and the code size of these functions: names separated by commas,
    /// `default`, `all`
    #[arg(long, value_name = "NAMES", value_parser = functions)]
    functions: Option<Functions>,
    /// The kinematic modules: `chains`, `links`, or a list such as [["a", "b"], ["c"]]
    #[arg(long, value_name = "MODULES", value_parser = modules)]
    modules: Option<ModuleChoice>,
    #[command(flatten)]
    robot: Robot,
}

/// The contents of the output.
struct Inspection {
    model: Model,
    modules: ModuleTree,
    warnings: Vec<Diagnostic>,
    advice: Vec<Advice>,
    /// The condition number of the scaled mass matrix; `None` if the robot is too large to compute
    /// it, or has no dynamics.
    condition: Option<f64>,
    /// Whether all joints move inertia.
    has_dynamics: bool,
    /// The cost of each function, or the reason why the robot is too large to compile; `None`
    /// without `--functions`.
    costs: Option<Result<Vec<Cost>, Diagnostics>>,
}

/// The cost of a function.
struct Cost {
    name: &'static str,
    /// The operations of a call.
    operations: OperationCount,
    /// The estimated bytes of machine code; `None` for batches, which have code for each
    /// instruction set.
    bytes: Option<f64>,
    /// The loops in place of straight-line code, and why; `None` for straight-line code.
    loops: Option<String>,
}

/// Prints the inspection.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let description = arguments.robot.open()?;
    let read = description.read(&arguments.robot.options.read_options());
    let reading = match read {
        Err(diagnostics) if arguments.json => {
            let refused = serde_json::json!({
                "usable": false,
                "diagnostics": diagnostics::to_json(diagnostics.as_slice()),
            });
            to_stdout(&escape::json(&refused))?;
            return Err(Failure::Reported);
        }
        reading => reading.map_err(|diagnostics| description.failure(diagnostics))?,
    };
    let mut progress = Progress::start("counting operations");
    let inputs = description.inputs(Some(&reading));
    let Reading { model, warnings, .. } = reading;
    let has_dynamics = joints_without_inertia(&model).is_empty();
    let costs = if arguments.json || arguments.functions.is_some() {
        let builder = arguments.robot.builder(&description);
        let costs = costs(builder, arguments, has_dynamics);
        Some(costs.map_err(|diagnostics| description.failure(arguments.robot.named(diagnostics)))?)
    } else {
        None
    };
    let inspection = Inspection {
        modules: module_tree(&model, arguments.modules.as_ref())?,
        advice: advice::about(&model),
        condition: condition_number(&model),
        has_dynamics,
        costs,
        model,
        warnings,
    };
    progress.stop();
    if let Some(path) = &arguments.svg {
        let sparsity = Sparsity::of(&inspection.model, &inspection.modules)
            .map_err(|why| Failure::usage(format!("error: {why}")))?;
        let picture = picture::draw(&inspection.model, &inspection.modules, &sparsity);
        to_file(path, &picture, &inputs)?;
    }
    if arguments.json {
        return to_stdout(&json::of(&inspection));
    }
    let warnings = diagnostics::render(&inspection.warnings, Some(&description));
    to_stdout(&(text::page(&inspection) + &warnings))
}

/// The longest functions, which JSON has on request only: with them, the text of a humanoid would
/// exceed the limit.
const LONGEST: [Function; 4] = [
    Function::InverseDynamicsHessian,
    Function::ForwardDynamicsHessian,
    Function::StepSemiImplicitHessian,
    Function::StepRk4Derivatives,
];

/// Returns the cost of each function, or the reason why the robot cannot be compiled. JSON has all
/// functions except batches and the longest ones by default, as far as the robot has them.
fn costs(
    builder: Builder,
    arguments: &Arguments,
    has_dynamics: bool,
) -> Result<Result<Vec<Cost>, Diagnostics>, Diagnostics> {
    let mut builder = builder.functions(match &arguments.functions {
        Some(Functions(functions)) => functions.clone(),
        None => {
            let functions = Function::ALL.iter().copied();
            let all = functions.filter(|one| has_dynamics || !one.row().needs_inertia);
            all.filter(|one| one.batched().is_none() && !LONGEST.contains(one)).collect()
        }
    });
    if let Some(choice) = &arguments.modules {
        builder = builder.modules(choice.clone());
    }
    match builder.generate() {
        Ok(generated) => {
            let static_operations: BTreeMap<_, _> =
                generated.static_operations.into_iter().collect();
            let mut loops: BTreeMap<_, _> = generated.loops.into_iter().collect();
            let cost = |(name, operations)| {
                let bytes = static_operations.get(name).map(size::bytes);
                Cost { name, operations, bytes, loops: loops.remove(name) }
            };
            Ok(Ok(generated.operations.into_iter().map(cost).collect()))
        }
        Err(diagnostics) if diagnostics.iter().all(|one| one.code == Code::TooLarge) => {
            Ok(Err(diagnostics))
        }
        Err(diagnostics) => Err(diagnostics),
    }
}
