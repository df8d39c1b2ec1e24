//! Rust: the type of a robot, its functions and its other items.
//!
//! Public items are documented. Private functions are generic over the scalar. The type's own
//! functions are concrete: type inference stays simple, and the code is compiled in the robot's
//! crate. The text uses `core` and the crate `modyn` only. The same input gives the same text in
//! every process: nothing depends on an address or on the order of a hash map.
//!
//! The printer writes text, not tokens: a macro runs unoptimised, where rustc's lexer is faster
//! than building tokens one by one, and build scripts get a readable file. So the compiler needs
//! neither `syn` nor `quote`.

mod batch;
mod c_functions;
mod constants;
mod contacts;
mod dispatch;
mod docs;
pub(crate) mod embedded;
mod embedded_model;
mod factorization;
mod frames;
pub(crate) mod function;
mod header;
pub(crate) mod layout;
mod machine_code;
mod methods;
mod missing;
mod parameter;
mod parameters;
mod quantity;
mod robot_trait;
mod shape;
mod types;

use std::fmt::Write as _;

use modyn_runtime::model::{Model, ModuleTree};

use super::{Backend, EmitOptions, File, FloatType, MachineCode, PlannedRobot};
use crate::names;
use crate::plan::{Constants, Kernels, Plan, Planned};
use crate::program::{Execution, Program};
use function::function;
use quantity::Quantity;

/// The back end.
pub(super) struct Rust;

impl Backend for Rust {
    /// Self-contained files have neither vectors nor batches, which need the runtime.
    fn execution(&self, options: &EmitOptions) -> Execution {
        if options.self_contained { Execution::Scalar } else { Execution::Simd }
    }

    fn print(&self, robot: &PlannedRobot<'_>) -> Vec<File> {
        let (text, c_header) = print(robot);
        let header = c_header.map(|header| File::new(format!("{}.h", robot.stem), header));
        [File::new(format!("{}.rs", robot.stem), text)].into_iter().chain(header).collect()
    }

    fn with_origin(&self, text: &str, origin: &str) -> String {
        format!("// {origin}\n{text}")
    }
}

/// Returns the items of a robot, and the header of its functions for C if the options request them.
fn print(robot: &PlannedRobot<'_>) -> (String, Option<String>) {
    let PlannedRobot { model, modules, plan, .. } = *robot;
    let name = &*robot.options.type_name(model);
    let constants = &Constants::new(model, &plan.choices);
    let mut options = robot.options.clone();
    if options.self_contained {
        options.crate_path = format!("self::{}", embedded::MODULE);
    }
    let options = &options;
    let robot = Robot { model, modules, options, plan, constants, name, code: None };
    let quantity = |planned| Quantity::new(planned, name);
    let quantities: Vec<Quantity<'_>> = plan.functions.iter().map(quantity).collect();
    let mut text = robot.beginning(&quantities);
    if !options.self_contained {
        robot.robot_trait(&mut text, &quantities);
        let generated = plan.functions.iter().chain(&plan.batches).filter_map(|p| p.function);
        robot.availability(&mut text, &generated.collect::<Vec<_>>());
    }
    if options.embed_model {
        robot.embedded_model(&mut text);
    }
    if robot.factorizes() {
        robot.factorization(&mut text);
    }
    robot.enums(&mut text);
    robot.contact_functions(&mut text);
    robot.parameters(&mut text);
    let of_links = |p: &Planned| matches!(p.kernels, Kernels::ByLink(_) | Kernels::Poses { .. });
    if plan.functions.iter().any(of_links) && plan.frames.any_shared() {
        robot.placements(&mut text);
    }
    for quantity in &quantities {
        robot.private_functions(&mut text, quantity);
    }
    for planned in &plan.batches {
        robot.batches(&mut text, &quantity(planned));
    }
    text += "};\n";
    let c_header = options.c_prefix.as_ref().map(|prefix| {
        robot.c_functions(&mut text, prefix, &quantities);
        robot.c_header(prefix, &quantities)
    });
    if options.self_contained {
        text = layout::indented(&embedded::in_any_edition(&text));
        text += &embedded::module(&text);
    }
    (text, c_header)
}

/// Returns the items of a robot whose functions are in an object file.
pub(super) fn print_for_object(robot: &PlannedRobot<'_>, code: &MachineCode) -> String {
    let PlannedRobot { model, modules, plan, options, .. } = *robot;
    let name = &*options.type_name(model);
    let constants = &Constants::new(model, &plan.choices);
    let robot = Robot { model, modules, options, plan, constants, name, code: Some(code) };
    let quantities: Vec<Quantity<'_>> =
        plan.functions.iter().map(|planned| Quantity::new(planned, name)).collect();
    let mut text = robot.beginning(&quantities);
    robot.enums(&mut text);
    robot.contact_functions(&mut text);
    robot.parameters(&mut text);
    robot.machine_functions(&mut text, &quantities, code);
    text += "};\n";
    text
}

/// The inputs of all parts of the text.
struct Robot<'a> {
    model: &'a Model,
    modules: &'a ModuleTree,
    options: &'a EmitOptions,
    plan: &'a Plan,
    constants: &'a Constants,
    name: &'a str,
    /// The machine code that the functions call; `None` if their programs are printed.
    code: Option<&'a MachineCode>,
}

impl Robot<'_> {
    /// Returns the types, and the beginning of the block of items with the type's own functions and
    /// constants.
    fn beginning(&self, quantities: &[Quantity<'_>]) -> String {
        let per_call = |p: &Planned| (p.name, p.operations_per_call());
        let operations: Vec<_> = self.plan.functions.iter().map(per_call).collect();
        let mut text = String::new();
        docs::robot(&mut text, self, &operations);
        self.types(&mut text, quantities);
        let path = &self.options.crate_path;
        let _ = writeln!(
            text,
            "#[allow(clippy::all, clippy::pedantic, clippy::nursery, dead_code, unused_imports, \
             unused_variables, non_snake_case)]\n\
             const _: () = {{\n\
             use {path} as __modyn;\n"
        );
        // Rustdoc shows methods before constants if they come first.
        self.own_functions(&mut text, quantities);
        self.constants(&mut text, &operations);
        text
    }

    /// Returns whether the robot has a factorization type.
    fn factorizes(&self) -> bool {
        !self.plan.factorization.is_empty()
    }

    fn joint_names(&self) -> Vec<&str> {
        self.model.moving_links().iter().map(|link| link.joint.name.as_str()).collect()
    }

    fn link_names(&self) -> Vec<&str> {
        self.model.links().iter().map(|link| link.name.as_str()).collect()
    }

    fn link_variants(&self) -> Vec<String> {
        names::variants(&self.link_names())
    }

    /// Prints the private functions that compute, generic over the scalar.
    fn private_functions(&self, text: &mut String, quantity: &Quantity<'_>) {
        let name = quantity.name;
        let parameters = quantity.all_parameters();
        let function = |name: &str, program: &Program| {
            function(name, &parameters, &quantity.shape, program, self.options.scalar)
        };
        match quantity.kernels {
            Kernels::Straight { scalar, simd: None } => *text += &function(name, scalar),
            Kernels::Straight { scalar, simd: Some(simd) } => {
                self.dispatched(text, quantity, &parameters, scalar, simd);
            }
            Kernels::ByLink(programs) => self.link_functions(text, quantity, programs),
            Kernels::Poses { bodies, placed, .. } => {
                self.poses_function(text, quantity, bodies, placed);
            }
        }
    }
}
