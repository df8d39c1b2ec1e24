//! MATLAB: a package with a file for each function, which GNU Octave runs as well.
//!
//! Arguments and results have a column for each state, so a call computes one state or many.
//! Operations act on rows: entry `i` of an argument is `q(i, :)`. Matrices and lists of a result
//! have the states as their last dimension. Results with several parts are structs.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use modyn_runtime::model::{Model, ModuleTree};

use super::statements::{Around, Body, Iterations, RoutineCall, Syntax, sum_of_products};
use super::support::Support;
use super::{Backend, EmitOptions, File, PlannedRobot, Refused};
use crate::names;
use crate::plan::{
    Choices, CodeForm, Elements, FactorFunction, Frames, Function, Kernels, LinkProgram, Plan,
    Planned, Shape, TooLong,
};
use crate::program::{Array, Execution, MultiplyAdd, Operand, Operation, Place, Program};

/// The back end.
pub(super) struct Matlab;

impl Backend for Matlab {
    fn execution(&self, _: &EmitOptions) -> Execution {
        Execution::Scalar
    }

    fn print(&self, robot: &PlannedRobot<'_>) -> Vec<File> {
        let package = names::snake(robot.stem);
        let links: Vec<&str> = robot.model.links().iter().map(|link| link.name.as_str()).collect();
        let printer = Printer {
            package: &package,
            frames: &robot.plan.frames,
            links: names::fields(&links, &[]),
        };
        let functions = robot.plan.functions.iter().map(|planned| printer.function(planned));
        let factors = robot.plan.factorization.iter().map(|function| printer.factors(function));
        let mut files: Vec<File> = functions.chain(factors).collect();
        if !robot.plan.parameters.is_empty() {
            let numbers = robot.plan.parameters.described(robot.model.gravity());
            files.push(printer.default_parameters(&numbers));
        }
        files
    }

    /// The origin is at the end: `help` prints the first comment.
    fn with_origin(&self, text: &str, origin: &str) -> String {
        format!("{text}\n% {origin}\n")
    }

    /// Straight-line code: a loop or a call of a routine takes the interpreter longer.
    fn plan(
        &self,
        model: &Model,
        modules: &ModuleTree,
        choices: &Choices,
        options: &EmitOptions,
    ) -> Result<Plan, TooLong> {
        let choices = Choices { share_limbs: false, code: CodeForm::Unrolled, ..choices.clone() };
        Plan::new(model, modules, &choices, self.execution(options))
    }

    fn refused(&self) -> &'static [Refused] {
        &[Refused {
            option: "scalar",
            message: "MATLAB's functions compute in the class of their arguments",
            help: "remove the option `scalar`, and pass arrays of the class `single`",
        }]
    }
}

/// Names of local variables that are no values, and keywords of the language that are no keywords
/// of Rust.
const RESERVED: [&str; 15] = [
    "case",
    "catch",
    "classdef",
    "elseif",
    "end",
    "function",
    "global",
    "link",
    "otherwise",
    "out",
    "parfor",
    "persistent",
    "spmd",
    "states",
    "switch",
];

/// An argument of a function.
struct Argument {
    name: String,
    len: usize,
    /// Whether it is a matrix or a list, which users may pass as an array of more dimensions.
    is_array: bool,
}

impl Argument {
    fn new(name: &str, shape: &Shape) -> Self {
        let is_value = |first: char, name: &str| {
            name.strip_prefix(first)
                .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        };
        let taken = RESERVED.contains(&name)
            || name.starts_with("chunk")
            || ['x', 's', 'c'].iter().any(|first| is_value(*first, name));
        let name = if taken { format!("{name}_") } else { name.into() };
        Self { name, len: shape.len(), is_array: !shape.is_vector() && *shape != Shape::Scalar }
    }
}

struct Printer<'a> {
    package: &'a str,
    frames: &'a Frames,
    /// The names of the links.
    links: Vec<String>,
}

impl Printer<'_> {
    /// Returns the file of a function.
    fn function(&self, planned: &Planned) -> File {
        let of_plan =
            planned.arguments.iter().map(|(argument, shape)| Argument::new(argument.name, shape));
        let given: Vec<Argument> = of_plan.filter(|argument| argument.len > 0).collect();
        let names: Vec<&str> = given.iter().map(|argument| argument.name.as_str()).collect();
        let mut parameters = names.clone();
        parameters.extend(planned.is_by_link().then_some("link"));
        let mut text = String::new();
        let mut locals = Locals::default();
        let mut arguments: Vec<(String, usize)> =
            given.iter().map(|argument| (argument.name.clone(), argument.len)).collect();
        if planned.parameters > 0 {
            arguments.push(("params".into(), planned.parameters));
            parameters.push("params");
            let _ = writeln!(
                text,
                "    if nargin < {}, params = {}.default_parameters(); end",
                parameters.len(),
                self.package
            );
        }
        for argument in given.iter().filter(|argument| argument.is_array) {
            let Argument { name, len, .. } = argument;
            let _ = writeln!(text, "    {name} = reshape({name}, {len}, []);");
        }
        let names: Vec<&str> = arguments.iter().map(|(name, _)| name.as_str()).collect();
        let passed = names.join(", ");
        match &planned.kernels {
            Kernels::Straight { scalar, .. } => {
                locals.program("compute", &arguments, scalar);
                let _ = writeln!(text, "    out = compute({passed});");
            }
            Kernels::ByLink(programs) => {
                let known_count = self.frames.links_with_own_program().count();
                for (k, program) in programs.iter().enumerate() {
                    let mut arguments = arguments.clone();
                    arguments.extend(
                        (k >= known_count).then(|| ("placement".into(), Frames::PLACEMENT)),
                    );
                    locals.program(&format!("compute{k}"), &arguments, program);
                }
                text += "    switch link\n";
                for (name, LinkProgram { program, placement }) in
                    self.links.iter().zip(self.frames.programs())
                {
                    let placement = self.placement(*placement);
                    let _ = writeln!(
                        text,
                        "        case '{name}', out = compute{program}({passed}{placement});"
                    );
                }
                text += "        otherwise, error('there is no link `%s`', link);\n    end\n";
            }
            Kernels::Poses { bodies, placed, .. } => {
                locals.program("compute", &arguments, bodies);
                let pose = Shape::pose().len();
                let body = [("body".into(), pose), ("placement".into(), Frames::PLACEMENT)];
                locals.program("placed", &body, placed);
                let _ = writeln!(
                    text,
                    "    poses = compute({passed});\n    out = zeros({}, size(poses, 2), class(poses));",
                    planned.result.len()
                );
                for (link, LinkProgram { program, placement }) in
                    self.frames.programs().iter().enumerate()
                {
                    let rows = |k: usize| format!("{}:{}", pose * k + 1, pose * (k + 1));
                    let rows_of_pose = format!("poses({}, :)", rows(*program));
                    let value = match placement {
                        None => rows_of_pose,
                        Some(_) => format!("placed({rows_of_pose}{})", self.placement(*placement)),
                    };
                    let _ = writeln!(text, "    out({}, :) = {value};", rows(link));
                }
            }
        }
        self.file(planned.name, planned.docs, &parameters, &planned.result, &text, &locals)
    }

    /// Returns the file of a function of the mass matrix's factors.
    fn factors(&self, function: &FactorFunction) -> File {
        let declared = function.arguments.iter();
        let given: Vec<Argument> =
            declared.map(|(argument, shape)| Argument::new(argument.name, shape)).collect();
        let arguments: Vec<(String, usize)> =
            given.iter().map(|argument| (argument.name.clone(), argument.len)).collect();
        let names: Vec<&str> = given.iter().map(|argument| argument.name.as_str()).collect();
        let mut locals = Locals::default();
        locals.program("compute", &arguments, &function.program);
        let text = format!("    out = compute({});\n", names.join(", "));
        let name = format!("{}_{}", Function::Brge.name(), function.name);
        self.file(&name, function.docs, &names, &function.result, &text, &locals)
    }

    /// Returns the file of a function with this body, which computes the numbers of its result.
    fn file(
        &self,
        name: &str,
        docs: &str,
        parameters: &[&str],
        result: &Shape,
        body: &str,
        locals: &Locals,
    ) -> File {
        let mut docs = docs.replace('\n', "\n%   ");
        if parameters.contains(&"link") {
            docs += "\n%   `link` is the name of a link.";
        }
        let value = match value(result, 0, true) {
            same if same == "out" => String::new(),
            value => format!("    out = {value};\n"),
        };
        let text = format!(
            "function out = {name}({})\n%{} {docs}\n%   Numbers of the result: {}. Arguments and \
             results have a column for each state.\n\
             {body}{value}end\n{}{}",
            parameters.join(", "),
            name.to_uppercase(),
            result.in_words(),
            locals.text,
            locals.support()
        );
        File::new(format!("+{}/{name}.m", self.package), text)
    }

    /// Returns the file of the default run-time parameters.
    fn default_parameters(&self, numbers: &[f64]) -> File {
        let numbers: Vec<String> = numbers.iter().map(|&x| literal(x)).collect();
        let text = format!(
            "function params = default_parameters()\n%DEFAULT_PARAMETERS Returns the run-time \
             parameters of the description.\n    \
             params = [{}];\nend\n",
            numbers.join("; ")
        );
        File::new(format!("+{}/default_parameters.m", self.package), text)
    }

    /// Returns the placement of a link as a further argument.
    fn placement(&self, row: Option<usize>) -> String {
        let numbers = row.and_then(|row| self.frames.placements().nth(row));
        numbers.map_or(String::new(), |numbers| {
            let numbers = numbers.map(literal);
            format!(", [{}]", numbers.join("; "))
        })
    }
}

/// Returns the value of a result with this layout, whose numbers are rows of `out` from row `first`
/// on; `whole` if they are all rows.
fn value(shape: &Shape, first: usize, whole: bool) -> String {
    let rows = match whole {
        true => "out".into(),
        false => format!("out({}:{}, :)", first + 1, first + shape.len()),
    };
    match shape {
        Shape::Scalar => rows,
        Shape::Array(element, _, _) if **element == Shape::Scalar => rows,
        Shape::Array(element, n, Elements::Rows) => {
            format!("permute(reshape({rows}, {}, {n}, []), [2 1 3])", element.len())
        }
        Shape::Array(element, n, _) => format!("reshape({rows}, {}, {n}, [])", element.len()),
        Shape::Record(record, _) if record.result_type().is_none() => rows,
        Shape::Record(_, fields) => {
            let mut first = first;
            let fields = fields.iter().map(|(name, shape)| {
                let value = value(shape, first, false);
                first += shape.len();
                format!("'{name}', {value}")
            });
            format!("struct({})", fields.collect::<Vec<String>>().join(", "))
        }
    }
}

/// The functions inside of a file.
#[derive(Default)]
struct Locals {
    text: String,
    used: BTreeSet<Helper>,
}

/// Functions of real numbers, which the language's own are not where their results would be complex
/// or choose by rows.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Helper {
    Root,
    Logarithm,
    Select,
}

impl Locals {
    /// Adds the function of a program over arrays of these names and lengths.
    fn program(&mut self, name: &str, given: &[(String, usize)], program: &Program) {
        let lengths: Vec<usize> = given.iter().map(|(_, len)| *len).collect();
        let names: Vec<&str> = given.iter().map(|(name, _)| name.as_str()).collect();
        let last = program.chunks.len() - 1;
        // Run-time parameters may be one column for all states.
        let states = names.first().map_or("1".into(), |name| format!("size({name}, 2)"));
        let class = names.first().map_or("'double'".into(), |name| format!("class({name})"));
        let syntax = Statements { name, given, states: &states, class: &class };
        for (number, routine) in program.routines.iter().enumerate() {
            let read = [("read".into(), routine.program.arguments)];
            self.program(&format!("{name}_routine{number}"), &read, &routine.program);
        }
        for (k, chunk) in program.chunks.iter().enumerate() {
            let syntax = &syntax;
            let first = chunk.statements.start;
            let body = Body { syntax, program, lengths: &lengths, first };
            let with = |chunks: &[usize]| {
                let chunks = chunks.iter().map(|k| format!("chunk{k}"));
                names.iter().map(|name| (*name).into()).chain(chunks).collect::<Vec<String>>()
            };
            let (head, mut text, stored) = if k == last {
                let calls = (0..last).map(|k| {
                    let arguments = with(&program.chunks[k].live_in).join(", ");
                    format!("    chunk{k} = {name}_chunk{k}({arguments});\n")
                });
                let results = program.results.iter().map(|result| body.operand(result));
                (format!("{name}({})", names.join(", ")), calls.collect(), results.collect())
            } else {
                let arguments = with(&chunk.live_in).join(", ");
                let live = chunk.live_out.iter().map(|&value| body.value(value));
                (format!("{name}_chunk{k}({arguments})"), String::new(), live.collect::<Vec<_>>())
            };
            let mut operations = chunk.statements.clone().map(|s| &program.statements[s].operation);
            if operations.any(|operation| matches!(operation, Operation::Loops(_))) {
                text += &syntax.states();
            }
            for s in chunk.statements.clone() {
                body.statement(&mut text, s);
            }
            let _ = writeln!(text, "    out = zeros({}, {states}, {class});", stored.len());
            for (i, value) in stored.iter().enumerate() {
                let _ = writeln!(text, "    out({}, :) = {value};", i + 1);
            }
            let _ = write!(self.text, "\nfunction out = {head}\n{text}end\n");
        }
        self.used.extend(program.statements.iter().filter_map(|s| match s.operation {
            Operation::SquareRoot(_) => Some(Helper::Root),
            Operation::Logarithm(_) => Some(Helper::Logarithm),
            Operation::Select(..) => Some(Helper::Select),
            _ => None,
        }));
    }

    /// Returns the functions that the programs call.
    fn support(&self) -> String {
        let text = |helper: &Helper| match helper {
            Helper::Root => {
                "\nfunction y = modyn_sqrt(x)\n    x(x < 0) = NaN;\n    y = sqrt(x);\nend\n"
            }
            Helper::Logarithm => {
                "\nfunction y = modyn_ln(x)\n    x(x < 0) = NaN;\n    y = log(x);\nend\n"
            }
            Helper::Select => {
                "\n% Returns `a` where `x` is at least zero, else `b`.\n\
                 function y = modyn_select(x, a, b)\n    \
                 all = zeros(1, max([numel(x), numel(a), numel(b)]), class(x + a + b));\n    \
                 y = all + b;\n    a = all + a;\n    chosen = (all + x) >= 0;\n    \
                 y(chosen) = a(chosen);\nend\n"
            }
        };
        self.used.iter().map(text).collect()
    }
}

/// The syntax of statements.
///
/// Loops run for all states together. `active` are the columns of the states whose loops have not
/// ended: arrays are read and written in these columns only.
struct Statements<'a> {
    /// The name of the function.
    name: &'a str,
    /// The names and lengths of the arguments.
    given: &'a [(String, usize)],
    /// The number of states.
    states: &'a str,
    /// The class of the results.
    class: &'a str,
}

impl Statements<'_> {
    /// Returns the lines before statements with loops: all states are active, and each has a column
    /// of run-time parameters.
    fn states(&self) -> String {
        let states = self.states;
        let parameters = self.given.iter().find(|(name, _)| name == "params").map(|(name, _)| {
            format!("    if size({name}, 2) == 1, {name} = repmat({name}, 1, {states}); end\n")
        });
        format!("    active = 1:{states};\n{}", parameters.unwrap_or_default())
    }
}

impl Syntax for Statements<'_> {
    fn literal(&self, value: f64) -> String {
        literal(value)
    }

    fn define(&self, name: &str, value: &str) -> String {
        format!("{name} = {value};")
    }

    fn sin_cos(&self, angle: &str, sine: &str, cosine: &str) -> String {
        format!("{sine} = sin({angle}); {cosine} = cos({angle});")
    }

    fn multiply(&self, a: &str, b: &str) -> String {
        format!("{a} .* {b}")
    }

    fn reciprocal(&self, x: &str) -> String {
        format!("1 ./ {x}")
    }

    fn multiply_add(&self, fused: &MultiplyAdd, text: &dyn Fn(&Operand) -> String) -> String {
        sum_of_products(fused, ".*", text)
    }

    fn square_root(&self, x: &str) -> String {
        format!("modyn_sqrt({x})")
    }

    fn absolute(&self, x: &str) -> String {
        format!("abs({x})")
    }

    fn select(&self, x: &str, then: &str, otherwise: &str) -> String {
        format!("modyn_select({x}, {then}, {otherwise})")
    }

    fn argument(&self, argument: usize, i: usize) -> String {
        format!("{}({}, :)", self.given[argument].0, i + 1)
    }

    fn live_value(&self, chunk: usize, i: usize) -> String {
        format!("chunk{chunk}({}, :)", i + 1)
    }

    fn entry(&self, array: &str, place: Place) -> String {
        format!("{array}({}, active)", place.index + 1)
    }

    fn given(&self, argument: usize, place: Place) -> String {
        self.entry(&self.given[argument].0, place)
    }

    fn zeros(&self, name: &str, shape: Array) -> String {
        format!("{name} = zeros({}, {}, {});", shape.len(), self.states, self.class)
    }

    fn iterations(&self, iterations: &Iterations<'_>) -> Around {
        let Iterations { depth, table, end, .. } = iterations;
        let mut before = vec![
            format!("outer{depth} = active;"),
            format!("for i{depth} = 1:{}", table.rows.len()),
        ];
        if let Some(end) = end {
            before.push(format!("    active = active(~({end} >= 0));"));
            before.push("    if isempty(active), break; end".into());
        }
        Around { before, after: vec!["end".into(), format!("active = outer{depth};")] }
    }

    fn call(&self, call: &RoutineCall) -> Around {
        let RoutineCall { routine, reads, .. } = call;
        let before = vec![
            format!("read = [{}];", reads.join("; ")),
            format!("results = {}_routine{routine}(read);", self.name),
        ];
        Around { before, after: Vec::new() }
    }

    fn result(&self, i: usize) -> String {
        format!("results({}, :)", i + 1)
    }

    fn function(&self, support: Support) -> &'static str {
        match support {
            Support::SinCos => "sin",
            Support::Atan2 => "atan2",
            Support::Logarithm => "modyn_ln",
            Support::Maximum => "max",
        }
    }
}

/// Returns a number.
fn literal(value: f64) -> String {
    match value {
        _ if value.is_nan() => "NaN".into(),
        _ if value.is_infinite() => if value > 0.0 { "Inf" } else { "-Inf" }.into(),
        _ => format!("{value:?}"),
    }
}
