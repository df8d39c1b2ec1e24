//! C99: a source file and a header that need `<math.h>` only.
//!
//! They contain every function of one state, over arrays of fixed sizes. Structured arguments and
//! results are flat arrays of their scalars. The code has no heap, no mutable `static` and no
//! recursion. Without contraction (`-ffp-contract=off`) the results equal the results of the
//! scalar Rust functions, bit for bit.

mod eigen;
mod function;
mod loops;
mod products;
mod rollout;
mod support;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use modyn_runtime::model::Model;

use super::c_types::{CType, CTypes, value};
use super::indices::{in_header, indices, name_tables};
use super::support::Support;
use super::{Backend, EmitOptions, File, FloatType, MachineCode, PlannedRobot, coordinates_in_c};
use crate::plan::{Argument, ArgumentKind, Frames, Function, Kernels, LinkProgram, Plan, Shape};
use crate::program::{Execution, Program};
pub(super) use eigen::Cpp;
pub(super) use support::{Qualifiers, text as support};

/// The back end.
pub(super) struct C;

impl Backend for C {
    fn execution(&self, _: &EmitOptions) -> Execution {
        Execution::Scalar
    }

    fn print(&self, robot: &PlannedRobot<'_>) -> Vec<File> {
        let source = format!("{}.c", robot.stem);
        let header = format!("{}.h", robot.stem);
        let printer = Printer::new(&robot.prefix(), robot.options.scalar);
        let (source_text, header_text) = printer.print(robot.plan, robot.model, &header);
        vec![File::new(source, source_text), File::new(header, header_text)]
    }

    fn with_origin(&self, text: &str, origin: &str) -> String {
        format!("/* {origin} */\n{text}")
    }
}

/// What the numbers of all functions for C mean.
pub(super) const CONVENTIONS: &str = "SI units, radians. Vectors are in the order of the description's joints, \
depth first. Matrices are arrays of\n   \
columns, unless rows are named; `rotation[i][j]` of a pose is in row i and column j. Quaternions are\n   \
x, y, z, w. Twists and the velocity of a floating joint are linear, then angular; wrenches are the\n   \
force, then the moment. The velocity of a floating joint is in the axes of its link. Sets of contacts\n   \
are numbers: 1 for an active contact, else 0. A struct has only numbers, and can be read as an array\n   \
of them. Results must not overlap arguments.";

/// An array of numbers.
#[derive(Clone)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) len: usize,
}

/// An argument of a function.
struct Parameter {
    array: Array,
    shape: Shape,
    /// The meaning of its numbers; `None` for run-time parameters.
    kind: Option<ArgumentKind>,
}

/// A function of the plan or of its factorization.
struct Item<'a> {
    name: String,
    docs: &'static str,
    parameters: Vec<Parameter>,
    result: &'a Shape,
    programs: Programs<'a>,
    /// Whether run-time parameters are the function's last argument.
    with_parameters: bool,
    /// The name of the function that calls this function, a time step, in a loop.
    rollout: Option<String>,
}

impl Item<'_> {
    /// Returns the name of the function of arrays of numbers that computes: the others call it.
    fn own_name(&self) -> String {
        let with = if self.with_parameters { "_with" } else { "" };
        let numbers = if self.has_structs() { "_numbers" } else { "" };
        format!("{}{with}{numbers}", self.name)
    }

    /// Returns the arguments as arrays of numbers.
    fn arrays(&self) -> Vec<Array> {
        self.parameters.iter().map(|parameter| parameter.array.clone()).collect()
    }

    /// Returns whether an argument or the result is a struct.
    fn has_structs(&self) -> bool {
        let shapes = self.parameters.iter().map(|parameter| &parameter.shape);
        shapes.chain([self.result]).any(|shape| CType::new(shape).is_struct())
    }
}

/// The programs of a function.
#[derive(Clone, Copy)]
enum Programs<'a> {
    /// One program.
    One(&'a Program),
    /// The programs of a function of one link: see [`Kernels::ByLink`].
    ByLink(&'a [Program]),
    /// The programs of the poses of all links: see [`Kernels::Poses`].
    Poses { bodies: &'a Program, placed: &'a Program },
}

impl Programs<'_> {
    /// Returns whether they are one function in C.
    fn are_one(&self) -> bool {
        matches!(self, Self::One(_))
    }
}

pub(super) struct Printer {
    prefix: String,
    float: FloatType,
    header: String,
    pub(super) source: String,
    support: BTreeSet<Support>,
    types: CTypes,
}

/// Returns the header of functions that are machine code in an object file.
pub(super) fn print_object_header(robot: &PlannedRobot<'_>, code: &MachineCode) -> String {
    let PlannedRobot { model, plan, .. } = *robot;
    let prefix = &code.prefix;
    let mut printer = Printer::new(prefix, robot.options.scalar);
    printer.constants(plan, model, &prefix.to_uppercase());
    let needs = if code.needs.is_empty() { "those of every x86-64 processor" } else { code.needs };
    let _ = writeln!(
        printer.header,
        "/* Returns 1 if this processor has the instructions of the functions ({needs}), else 0. */\n\
         int {prefix}_is_supported(void);\n"
    );
    for item in items(plan, prefix) {
        printer.declarations(&item);
    }
    let notes = match code.needs {
        "" => format!("The functions are machine code for\n   {}. ", code.target.words),
        needs => format!(
            "The functions are machine code for\n   {}. Processors need {needs}: without them the functions\n   \
             crash; ask {prefix}_is_supported() first. ",
            code.target.words
        ),
    };
    printer.header_file(model, &notes)
}

impl Printer {
    pub(super) fn new(prefix: &str, float: FloatType) -> Self {
        let header = String::new();
        let source = String::new();
        let types = CTypes::new(prefix, float.in_c());
        Self { prefix: prefix.into(), float, header, source, support: BTreeSet::new(), types }
    }

    /// Returns the text of the support functions that the printed functions call.
    pub(super) fn support(&self) -> String {
        support(&self.support, self.float, &Qualifiers::C)
    }

    /// Returns the texts of the source file and of the header, which the source includes as `file`.
    fn print(mut self, plan: &Plan, model: &Model, file: &str) -> (String, String) {
        let upper = self.prefix.to_uppercase();
        let prefix = self.prefix.clone();
        self.constants(plan, model, &upper);
        self.tables(plan, model);
        let items = items(plan, &prefix);
        if items.iter().any(|item| !item.programs.are_one()) {
            self.placements(&plan.frames);
        }
        for item in items {
            self.item(&item, &plan.frames);
            if let Some(name) = &item.rollout {
                self.rollout(name, &item, [plan.sizes.nq, plan.sizes.nv]);
            }
        }
        let header = self.header_file(model, "");
        let source = format!(
            "/* Generated by modyn; see the header. */\n#include <math.h>\n\n#include \"{file}\"\n\n{}{}",
            self.support(),
            self.source
        );
        (source, header)
    }

    /// Returns the header file: the declarations so far, after `notes`.
    fn header_file(&self, model: &Model, notes: &str) -> String {
        let upper = self.prefix.to_uppercase();
        format!(
            "/* Dynamics of a robot, compiled by modyn. Gravity is by default {:?} m/s^2 in world axes.\n   \
             {CONVENTIONS} {notes}*/\n\
             #ifndef {upper}_H\n#define {upper}_H\n\n\
             #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n{}\
             #ifdef __cplusplus\n}}\n#endif\n\n#endif\n",
            model.gravity(),
            self.header
        )
    }

    /// Prints the sizes, the links by name, and the default run-time parameters.
    fn constants(&mut self, plan: &Plan, model: &Model, upper: &str) {
        for (name, value, docs) in [
            ("NQ", plan.sizes.nq, coordinates_in_c(model)),
            (
                "NV",
                plan.sizes.nv,
                "The length of the velocity vector: the number of degrees of freedom.",
            ),
            ("LINKS", plan.sizes.links, "The number of links."),
        ] {
            let _ = writeln!(self.header, "/* {docs} */\n#define {upper}_{name} {value}");
        }
        self.header += &indices(model, &self.prefix);
        if plan.parameters.is_empty() {
            return;
        }
        let numbers = plan.parameters.described(model.gravity());
        let real = self.real();
        let count = numbers.len();
        let numbers: Vec<String> = numbers.iter().map(|&x| literal(x, self.float)).collect();
        let _ = writeln!(
            self.header,
            "/* The parameters that functions `.._with` take, by default as in the description: \
             the acceleration of free\n   \
             fall if that is one; then for each link with a run-time inertia its mass, centre of \
             mass, and inertia Ixx, Ixy,\n   \
             Ixz, Iyy, Iyz, Izz about that in the link's axes; then the same of each payload, by \
             default none. Nothing\n   \
             checks them. */\n\
             #define {upper}_PARAMETERS {count}\nextern const {real} {}_default_parameters[{count}];\n",
            self.prefix
        );
        let _ = writeln!(
            self.source,
            "const {real} {}_default_parameters[{count}] = {{ {} }};\n",
            self.prefix,
            numbers.join(", ")
        );
    }

    /// Prints the names of the description, and the settings by default.
    fn tables(&mut self, plan: &Plan, model: &Model) {
        let tables = name_tables(model, &self.prefix);
        self.header += &tables.declarations;
        self.source += &tables.definitions;
        for kind in [ArgumentKind::Settings, ArgumentKind::StepSettings] {
            let mut arguments = plan.functions.iter().flat_map(|planned| &planned.arguments);
            if let Some((_, shape)) = arguments.find(|(argument, _)| argument.kind == kind) {
                self.default_settings(kind, shape, model);
            }
        }
    }

    /// Prints the settings by the description.
    fn default_settings(&mut self, kind: ArgumentKind, shape: &Shape, model: &Model) {
        self.header += &self.types.definitions(shape);
        let name = if kind == ArgumentKind::Settings { "constraint" } else { "step" };
        let numbers = self.float.default_settings(kind, model).unwrap_or_default();
        let mut numbers = numbers.into_iter().map(|x| literal(x, self.float));
        let variable = format!("{}_default_{name}_settings", self.prefix);
        let settings = self.types.variable(&variable, shape);
        let _ = writeln!(
            self.header,
            "/* The settings of {name}s by default, for the ground of the description. */\nextern const {settings};\n"
        );
        let _ = writeln!(self.source, "const {settings} = {};\n", value(shape, &mut numbers));
    }

    fn real(&self) -> &'static str {
        self.float.in_c()
    }

    /// Returns the name of a function of the mathematical library in this precision.
    fn library(&self, name: &str) -> String {
        match self.float {
            FloatType::F64 => name.into(),
            FloatType::F32 => format!("{name}f"),
        }
    }

    /// Prints the table of placements: the pose on its body of each link with a shared program.
    fn placements(&mut self, frames: &Frames) {
        if !frames.any_shared() {
            return;
        }
        let row = |numbers: [f64; Frames::PLACEMENT]| {
            let numbers = numbers.map(|x| literal(x, self.float));
            format!("    {{ {} }}", numbers.join(", "))
        };
        let rows: Vec<String> = frames.placements().map(row).collect();
        let _ = writeln!(
            self.source,
            "static const {} {}_placements[{}][{}] = {{\n{}\n}};\n",
            self.real(),
            self.prefix,
            frames.rows(),
            Frames::PLACEMENT,
            rows.join(",\n")
        );
    }

    /// Prints the functions that an item calls.
    fn kernels(&mut self, item: &Item<'_>, frames: &Frames) {
        let Item { name, result, .. } = item;
        let arguments = &item.arrays();
        let placement = Array { name: "placement".into(), len: Frames::PLACEMENT };
        match item.programs {
            Programs::One(program) => {
                let linkage = if item.has_structs() { "static " } else { "" };
                self.function(linkage, &item.own_name(), arguments, result.len(), program);
            }
            Programs::ByLink(programs) => {
                let (known, shared) = programs.split_at(frames.links_with_own_program().count());
                for (link, program) in frames.links_with_own_program().zip(known) {
                    let name = format!("{name}_{link}");
                    self.function("static ", &name, arguments, result.len(), program);
                }
                let arguments: Vec<Array> = arguments.iter().cloned().chain([placement]).collect();
                for (body, program) in shared.iter().enumerate() {
                    let name = format!("{name}_on_{body}");
                    self.function("static ", &name, &arguments, result.len(), program);
                }
            }
            Programs::Poses { bodies, placed } => {
                let poses = frames.poses_of_bodies().len();
                self.function("static ", &format!("{name}_of_bodies"), arguments, poses, bodies);
                let pose = Shape::pose().len();
                let arguments = [Array { name: "body".into(), len: pose }, placement];
                self.function("static ", &format!("{name}_placed"), &arguments, pose, placed);
            }
        }
    }

    /// Returns the body of a function that only calls others with these arguments.
    fn calls(&self, item: &Item<'_>, names: &str, frames: &Frames) -> String {
        let name = &item.name;
        let out = if CType::new(item.result).is_struct() { "numbers" } else { "out" };
        let table = format!("{}_placements", self.prefix);
        match item.programs {
            Programs::One(_) => {
                format!("    {}({names}, {out});\n", item.own_name())
            }
            Programs::ByLink(_) => {
                let known_count = frames.links_with_own_program().count();
                let case = |(i, link): (usize, &LinkProgram)| match link.placement {
                    None => format!("    case {i}U: {name}_{i}({names}, {out}); return 1;\n"),
                    Some(row) => format!(
                        "    case {i}U: {name}_on_{}({names}, {table}[{row}], {out}); return 1;\n",
                        link.program - known_count
                    ),
                };
                let cases: String = frames.programs().iter().enumerate().map(case).collect();
                format!("    switch (link) {{\n{cases}    default: return 0;\n    }}\n")
            }
            Programs::Poses { .. } => {
                let pose = Shape::pose().len();
                let mut text = format!(
                    "    {} bodies[{}];\n    int i;\n    {name}_of_bodies({names}, bodies);\n",
                    self.real(),
                    frames.poses_of_bodies().len()
                );
                for (link, LinkProgram { program, placement }) in
                    frames.programs().iter().enumerate()
                {
                    let to = pose * link;
                    let from = pose * program;
                    let _ = match placement {
                        None => writeln!(
                            text,
                            "    for (i = 0; i < {pose}; i++) {{ {out}[{to} + i] = bodies[{from} + i]; }}"
                        ),
                        Some(row) => writeln!(
                            text,
                            "    {name}_placed(&bodies[{from}], {table}[{row}], &{out}[{to}]);"
                        ),
                    };
                }
                text
            }
        }
    }

    /// Prints a function's declarations. Returns for each form its head and the number of its
    /// parameters: the form for the described parameters, and the one for run-time parameters.
    fn declarations(&mut self, item: &Item<'_>) -> Vec<(String, usize)> {
        let Item { name, parameters, result, .. } = item;
        for shape in parameters.iter().map(|parameter| &parameter.shape).chain([*result]) {
            self.header += &self.types.definitions(shape);
        }
        let by_link = matches!(item.programs, Programs::ByLink(_));
        let docs = in_header(item.docs, &self.prefix).replace('\n', "\n   ");
        let layout = match CType::new(result).is_struct() {
            true => String::new(),
            false => format!("\n   `out`: {}.", result.in_words()),
        };
        let link = if by_link {
            "\n   Returns 0 and writes nothing if there is no such link."
        } else {
            ""
        };
        let docs = format!("/* {docs}{layout}{link} */\n");
        let all = parameters.len();
        let without_parameters = all - usize::from(item.with_parameters);
        let out = self.parameter("out", result);
        let (returned, link) = if by_link { ("int", "unsigned int link, ") } else { ("void", "") };
        let mut forms = vec![(name.clone(), without_parameters)];
        if item.with_parameters {
            forms.push((format!("{name}_with"), all));
        }
        let head = |(form, count): (String, usize)| {
            let parameters: String = parameters[..count].iter().map(|p| self.read(p)).collect();
            (format!("{returned} {form}({parameters}{link}{out})"), count)
        };
        let heads: Vec<(String, usize)> = forms.into_iter().map(head).collect();
        for (head, _) in &heads {
            let _ = writeln!(self.header, "{docs}{head};\n");
        }
        heads
    }

    /// Prints a function's declarations and definitions.
    fn item(&mut self, item: &Item<'_>, frames: &Frames) {
        self.kernels(item, frames);
        let parameters = &item.parameters;
        let real = self.real();
        for (head, count) in self.declarations(item) {
            if item.programs.are_one() && count == parameters.len() && !item.has_structs() {
                continue;
            }
            let defaults = format!("{}_default_parameters", self.prefix);
            let passed = |(i, parameter): (usize, &Parameter)| {
                if i < count { self.numbers_of(parameter) } else { defaults.clone() }
            };
            let names: Vec<String> = parameters.iter().enumerate().map(passed).collect();
            let numbers = match CType::new(item.result).is_struct() {
                true => format!("    {real} *const numbers = ({real} *)out;\n"),
                false => String::new(),
            };
            let body = self.calls(item, &names.join(", "), frames);
            let _ = writeln!(self.source, "{head}\n{{\n{numbers}{body}}}\n");
        }
    }

    /// Returns the declaration of a parameter that is read, followed by a comma.
    fn read(&self, parameter: &Parameter) -> String {
        format!("const {}, ", self.parameter(&parameter.array.name, &parameter.shape))
    }

    /// Returns a parameter as an array of numbers.
    fn numbers_of(&self, parameter: &Parameter) -> String {
        let name = &parameter.array.name;
        match CType::new(&parameter.shape).is_struct() {
            true => format!("(const {} *){name}", self.real()),
            false => name.clone(),
        }
    }

    /// Returns the declaration of a parameter: structs, or an array of numbers.
    fn parameter(&self, name: &str, shape: &Shape) -> String {
        self.types.parameter(name, shape, array_size)
    }

    /// Returns the parameters for arrays that are read, each followed by a comma.
    fn parameters(&self, arrays: &[Array]) -> String {
        let array = |array: &Array| format!("const {}, ", self.array(&array.name, array.len));
        arrays.iter().map(array).collect()
    }

    fn array(&self, name: &str, len: usize) -> String {
        format!("{} {name}[{}]", self.real(), array_size(len))
    }
}

/// Returns the length of an array: C has no arrays of length 0.
fn array_size(len: usize) -> String {
    if len == 0 { String::new() } else { len.to_string() }
}

/// Returns all functions.
fn items<'a>(plan: &'a Plan, prefix: &str) -> Vec<Item<'a>> {
    let parameters = |arguments: &[(Argument, Shape)]| -> Vec<Parameter> {
        let parameter = |(argument, shape): &(Argument, Shape)| Parameter {
            array: Array { name: argument.name.into(), len: shape.len() },
            shape: shape.clone(),
            kind: Some(argument.kind),
        };
        // C has no array of no numbers.
        arguments.iter().filter(|(_, shape)| !shape.is_empty()).map(parameter).collect()
    };
    let mut items = Vec::new();
    for planned in &plan.functions {
        let programs = match &planned.kernels {
            Kernels::Straight { scalar, .. } => Programs::One(scalar),
            Kernels::ByLink(programs) => Programs::ByLink(programs),
            Kernels::Poses { bodies, placed, .. } => Programs::Poses { bodies, placed },
        };
        let with_parameters = planned.parameters > 0;
        let mut all = parameters(&planned.arguments);
        all.extend(with_parameters.then(|| Parameter {
            array: Array { name: "params".into(), len: planned.parameters },
            shape: Shape::vector(planned.parameters),
            kind: None,
        }));
        items.push(Item {
            name: format!("{prefix}_{}", planned.name),
            docs: planned.docs,
            parameters: all,
            result: &planned.result,
            programs,
            with_parameters,
            rollout: planned.rollout().map(|name| format!("{prefix}_{name}")),
        });
    }
    for function in &plan.factorization {
        items.push(Item {
            name: format!("{prefix}_{}_{}", Function::Brge.name(), function.name),
            docs: function.docs,
            parameters: parameters(&function.arguments),
            result: &function.result,
            programs: Programs::One(&function.program),
            with_parameters: false,
            rollout: None,
        });
    }
    items
}

/// Returns a number as a literal of the type.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn literal(value: f64, float: FloatType) -> String {
    let finite = match float {
        FloatType::F64 => value.is_finite(),
        FloatType::F32 => (value as f32).is_finite(),
    };
    let cast = float.in_c();
    match float {
        _ if value.is_nan() => format!("(({cast})NAN)"),
        _ if !finite && value < 0.0 => format!("(-({cast})INFINITY)"),
        _ if !finite => format!("(({cast})INFINITY)"),
        FloatType::F64 => format!("{value:?}"),
        FloatType::F32 => format!("{:?}f", value as f32),
    }
}
