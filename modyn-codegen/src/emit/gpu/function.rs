//! Prints a program as a kernel, one line for each statement. Chunks become functions that pass
//! their values on through arrays.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::{Dialect, GpuArgument, GpuKernel, Kernel};
use crate::emit::statements::{Around, Body, Iterations, RoutineCall, Syntax};
use crate::emit::support::Support;
use crate::program::{Addend, Array, MultiplyAdd, Operand, Program, Routine};

/// Returns the text of a kernel and its chunks, and adds the functions that it calls to `used`.
pub(super) fn print(
    dialect: &dyn Dialect,
    kernel: &Kernel<'_>,
    used: &mut BTreeSet<Support>,
) -> String {
    let program = kernel.program;
    used.extend(program.statements.iter().filter_map(|s| Support::of(&s.operation)));
    let values: Vec<usize> = program.chunks.iter().map(|chunk| chunk.live_out.len()).collect();
    let lengths: Vec<usize> =
        kernel.description.arguments.iter().map(|argument| argument.len).collect();
    let last = program.chunks.len() - 1;
    let mut text = routines(dialect, kernel, used);
    let mut calls = String::new();
    for (k, chunk) in program.chunks.iter().enumerate() {
        let inner = k < last;
        let syntax = &Statements { dialect, kernel, inner };
        let first = chunk.statements.start;
        let body = Body { syntax, program, lengths: &lengths, first };
        let mut lines = String::new();
        if k == 0 {
            stores(&body, &mut lines, &program.first_stores);
        }
        for s in chunk.statements.clone() {
            body.statement(&mut lines, s);
            stores(&body, &mut lines, &program.statements[s].stores);
        }
        if inner {
            for (i, &value) in chunk.live_out.iter().enumerate() {
                let place = dialect.live_value(k, i, true);
                let _ = writeln!(lines, "    {place} = {};", body.value(value));
            }
            text += &dialect.chunk(&kernel.description, k, &chunk.live_in, &values, &lines);
            calls += &dialect.call(&kernel.description, k, &chunk.live_in, &values);
        } else {
            text += &dialect.kernel(&kernel.description, &kernel.docs, &(calls.clone() + &lines));
        }
    }
    text
}

/// Returns the functions of the routines that a kernel's loops call.
fn routines(dialect: &dyn Dialect, kernel: &Kernel<'_>, used: &mut BTreeSet<Support>) -> String {
    let routine = |(number, routine): (usize, &Routine)| {
        let Program { arguments, results, statements, .. } = &routine.program;
        let read = GpuArgument { name: "read".into(), len: *arguments, common: false };
        let description = GpuKernel {
            name: format!("{}_routine{number}", kernel.description.name),
            function: kernel.description.function,
            link: None,
            arguments: [read].into_iter().filter(|argument| argument.len > 0).collect(),
            result: results.len(),
            statements: statements.len(),
        };
        let function = Kernel {
            description,
            docs: String::new(),
            program: &routine.program,
            placement_numbers: Vec::new(),
        };
        print(&*dialect.of_routines(), &function, used)
    };
    kernel.program.routines.iter().enumerate().map(routine).collect()
}

/// The syntax of a chunk's statements.
struct Statements<'a> {
    dialect: &'a dyn Dialect,
    kernel: &'a Kernel<'a>,
    /// Whether the chunk is a function that the kernel calls.
    inner: bool,
}

impl Syntax for Statements<'_> {
    fn literal(&self, value: f64) -> String {
        self.dialect.literal(value)
    }

    fn define(&self, name: &str, value: &str) -> String {
        self.dialect.define(name, value)
    }

    fn sin_cos(&self, angle: &str, sine: &str, cosine: &str) -> String {
        self.dialect.sin_cos(angle, sine, cosine)
    }

    fn multiply_add(&self, fused: &MultiplyAdd, text: &dyn Fn(&Operand) -> String) -> String {
        let MultiplyAdd { negative_product, factors: [a, b], negative_addend, addend } = fused;
        let signed =
            |x: &Operand, negative: &bool| text(&Operand { negated: x.negated ^ negative, ..*x });
        let addend = match addend {
            Addend::Value(c) => signed(c, negative_addend),
            Addend::Product(c, d) => format!("{} * {}", signed(c, negative_addend), text(d)),
        };
        self.dialect.multiply_add(&signed(a, negative_product), &text(b), &addend)
    }

    fn square_root(&self, x: &str) -> String {
        self.dialect.square_root(x)
    }

    fn absolute(&self, x: &str) -> String {
        self.dialect.absolute(x)
    }

    fn select(&self, x: &str, then: &str, otherwise: &str) -> String {
        self.dialect.select(x, then, otherwise)
    }

    fn argument(&self, argument: usize, i: usize) -> String {
        let kernel = &self.kernel.description;
        self.dialect.argument(kernel, &kernel.arguments[argument], i)
    }

    fn zeros(&self, name: &str, shape: Array) -> String {
        self.dialect.zeros(name, shape.len())
    }

    fn iterations(&self, iterations: &Iterations<'_>) -> Around {
        let Iterations { depth, table, end, .. } = iterations;
        let count = format!("{}u", table.rows.len());
        let zero = self.dialect.literal(0.0);
        let end = end.iter().map(|end| format!("    if ({end} >= {zero}) {{ break; }}"));
        let head = self.dialect.counting(&format!("i{depth}"), &count);
        Around { before: [head].into_iter().chain(end).collect(), after: vec!["}".into()] }
    }

    fn call(&self, call: &RoutineCall) -> Around {
        let RoutineCall { routine, reads, results, .. } = call;
        let name = format!("{}_routine{routine}", self.kernel.description.name);
        let read = (!reads.is_empty()).then(|| self.dialect.array("read", reads));
        let arguments: Vec<String> = read.iter().map(|_| "read".into()).collect();
        let call = self.dialect.call_into("results", *results, &name, &arguments);
        let lines = read.into_iter().chain([call]).map(|line| format!("    {line}"));
        Around { before: ["{".into()].into_iter().chain(lines).collect(), after: vec!["}".into()] }
    }

    fn constant_argument(&self, i: usize) -> String {
        format!("({})", self.dialect.literal(self.kernel.placement_numbers[i]))
    }

    fn live_value(&self, chunk: usize, i: usize) -> String {
        self.dialect.live_value(chunk, i, self.inner)
    }
}

/// Prints the statements that store these results.
fn stores(body: &Body<'_, Statements<'_>>, text: &mut String, results: &[usize]) {
    let Statements { dialect, kernel, inner } = body.syntax;
    for &result in results {
        let value = body.operand(&kernel.program.results[result]);
        let _ =
            writeln!(text, "    {}", dialect.store(&kernel.description, result, &value, *inner));
    }
}
