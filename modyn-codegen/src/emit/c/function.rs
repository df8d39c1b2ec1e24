//! Prints a program as C functions, one statement a line. Chunks become `static` functions
//! (`name_chunk0` and so on) that write the values that later chunks read into an array.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::{Array, Printer, literal, products};
use crate::emit::statements::{Around, Body, Iterations, RoutineCall, Syntax, sum_of_products};
use crate::emit::support::Support;
use crate::program::{
    Array as LoopArray, Chunk, MultiplyAdd, Operand, Operation, Place, Program, RowEquations,
    Source, argument_of, is_zero,
};

impl Printer {
    /// Prints the function of one program: its routines, its chunks, and the function itself.
    pub(in crate::emit) fn function(
        &mut self,
        linkage: &str,
        name: &str,
        given: &[Array],
        results: usize,
        program: &Program,
    ) {
        self.routines_and_tables(name, program);
        let operations = program.statements.iter().map(|statement| &statement.operation);
        for operation in operations {
            let Operation::RowEquations(equations) = operation else { continue };
            let arrays = [Array { name: "of".into(), len: equations.numbers().len() }];
            let solve = equations.program();
            self.function("static ", &format!("{name}_rows"), &arrays, equations.results(), &solve);
        }
        let last = program.chunks.len() - 1;
        let lengths: Vec<usize> = given.iter().map(|array| array.len).collect();
        for (k, chunk) in program.chunks.iter().enumerate() {
            let live_out = |k: usize| Array {
                name: format!("chunk{k}"),
                len: program.chunks[k].live_out.len(),
            };
            let syntax = &C { printer: &*self, name, given };
            let first = chunk.statements.start;
            let body = Body { syntax, program, lengths: &lengths, first };
            let mut text = String::new();
            let matrices: Vec<Array> = program.products.iter().flat_map(products::arrays).collect();
            let (linkage, name, arrays, written) = if k == last {
                for array in &matrices {
                    let zero = literal(0.0, self.float);
                    let _ = writeln!(
                        text,
                        "    {} = {{ {zero} }};",
                        self.array(&array.name, array.len)
                    );
                }
                stores(&body, &mut text, &program.first_stores);
                for k in 0..last {
                    let live_in = program.chunks[k].live_in.iter().map(|&k| live_out(k));
                    let written = matrices.iter().cloned().chain([live_out(k)]);
                    let arrays: Vec<Array> =
                        given.iter().cloned().chain(live_in).chain(written).collect();
                    let names: Vec<&str> = arrays.iter().map(|array| array.name.as_str()).collect();
                    let real = self.real();
                    let len = live_out(k).len.max(1);
                    let _ = writeln!(text, "    {real} chunk{k}[{len}];");
                    let _ = writeln!(text, "    {name}_chunk{k}({});", names.join(", "));
                }
                let out = Array { name: "out".into(), len: results };
                (linkage, name.to_string(), given.to_vec(), vec![out])
            } else {
                let live_in = chunk.live_in.iter().map(|&k| live_out(k));
                let arrays = given.iter().cloned().chain(live_in).collect();
                let out = Array { name: "out".into(), len: chunk.live_out.len() };
                let written = matrices.into_iter().chain([out]).collect();
                ("static ", format!("{name}_chunk{k}"), arrays, written)
            };
            for s in chunk.statements.clone() {
                body.statement(&mut text, s);
                stores(&body, &mut text, &program.statements[s].stores);
            }
            let products = program.products.as_ref().filter(|_| k == last);
            let stored: Vec<String> = if k == last {
                let before = products.map(|products| products.before(&program.results));
                let results = before.as_ref().unwrap_or(&program.results).iter();
                results.map(|result| body.operand(result)).collect()
            } else {
                chunk.live_out.iter().map(|&value| body.value(value)).collect()
            };
            let in_array = program.results_in_array().filter(|_| k == last && products.is_none());
            if let Some((statement, first)) = in_array {
                let array = body.array(statement, first.array);
                let count = stored.len();
                let _ = writeln!(
                    text,
                    "    for (int i = 0; i < {count}; ++i) {{ out[i] = {array}[i + {}]; }}",
                    first.index
                );
            } else {
                for (i, value) in stored.iter().enumerate() {
                    let _ = writeln!(text, "    out[{i}] = {value};");
                }
            }
            if let Some(products) = products {
                let operand = |operand: &Operand| body.operand(operand);
                products::print(&mut text, products, &program.results, self, &operand);
            }
            let mut unread = String::new();
            let calls = k == last && last > 0;
            let first = program.first_stores.iter().map(|&i| program.stored(i));
            let outputs = program.read_last().chain(first).filter(|_| k == last).copied();
            let arguments = arguments_read(program, chunk, outputs, &lengths);
            let read = |name: &str| {
                arguments.iter().any(|&i| given[i].name == name)
                    || calls
                    || name.starts_with("chunk")
            };
            for array in arrays.iter().filter(|array| !read(&array.name)) {
                let _ = writeln!(unread, "    (void){};", array.name);
            }
            let entries = chunk.statements.clone().flat_map(|s| &program.statements[s].stores);
            let stores: BTreeSet<String> =
                entries.filter_map(|&i| Some(place(program, i)?.0)).collect();
            for Array { name, .. } in &written {
                let is_written =
                    if name == "out" { !stored.is_empty() } else { stores.contains(name) };
                if !is_written {
                    let _ = writeln!(unread, "    (void){name};");
                }
            }
            let written: Vec<String> =
                written.iter().map(|array| self.array(&array.name, array.len)).collect();
            let read = self.parameters(&arrays);
            let written = written.join(", ");
            let head = format!("{linkage}void {name}({read}{written})");
            let _ = writeln!(self.source, "{head}\n{{\n{unread}{text}}}\n");
            let statements = program.statements[chunk.statements.clone()].iter();
            self.support.extend(statements.filter_map(|s| Support::of(&s.operation)));
        }
    }
}

/// The syntax of C in one function.
pub(super) struct C<'a> {
    pub(super) printer: &'a Printer,
    pub(super) name: &'a str,
    given: &'a [Array],
}

impl Syntax for C<'_> {
    fn literal(&self, value: f64) -> String {
        literal(value, self.printer.float)
    }

    fn define(&self, name: &str, value: &str) -> String {
        format!("const {} {name} = {value};", self.printer.real())
    }

    fn sin_cos(&self, angle: &str, sine: &str, cosine: &str) -> String {
        let real = self.printer.real();
        format!(
            "{real} {sine};\n    {real} {cosine};\n    modyn_sin_cos({angle}, &{sine}, &{cosine});"
        )
    }

    fn multiply_add(&self, fused: &MultiplyAdd, text: &dyn Fn(&Operand) -> String) -> String {
        sum_of_products(fused, "*", text)
    }

    fn square_root(&self, x: &str) -> String {
        format!("{}({x})", self.printer.library("sqrt"))
    }

    fn absolute(&self, x: &str) -> String {
        format!("{}({x})", self.printer.library("fabs"))
    }

    fn select(&self, x: &str, then: &str, otherwise: &str) -> String {
        format!("({x} >= {}) ? {then} : {otherwise}", self.literal(0.0))
    }

    fn argument(&self, argument: usize, i: usize) -> String {
        format!("{}[{i}]", self.given[argument].name)
    }

    fn live_value(&self, chunk: usize, i: usize) -> String {
        format!("chunk{chunk}[{i}]")
    }

    fn given(&self, argument: usize, place: Place) -> String {
        self.entry(&self.given[argument].name, place)
    }

    fn zeros(&self, name: &str, shape: LoopArray) -> String {
        self.array_of_zeros(name, shape)
    }

    fn iterations(&self, iterations: &Iterations<'_>) -> Around {
        self.around_steps(iterations)
    }

    fn call(&self, call: &RoutineCall) -> Around {
        self.around_stores(call)
    }

    fn row_equations(
        &self,
        results: &str,
        equations: &RowEquations,
        t: &dyn Fn(&Operand) -> String,
    ) -> String {
        let real = self.printer.real();
        let name = self.name;
        let numbers: Vec<String> = equations.numbers().iter().map(t).collect();
        let zero = self.literal(0.0);
        let margin = t(equations.margin());
        format!(
            "    {real} {results}[{}] = {{ {zero} }};\n    \
             if (!({margin} >= {zero})) {{\n        \
             const {real} of[{}] = {{ {} }};\n        \
             {name}_rows(of, {results});\n    }}\n",
            equations.results(),
            numbers.len(),
            numbers.join(", "),
        )
    }
}

/// Prints the statements that store these entries of a program's products.
fn stores(body: &Body<'_, C<'_>>, text: &mut String, numbers: &[usize]) {
    for &i in numbers {
        if let Some((name, index)) = place(body.program, i) {
            let value = body.operand(body.program.stored(i));
            let _ = writeln!(text, "    {name}[{index}] = {value};");
        }
    }
}

/// Returns the array into which an entry of a program's products is stored, and the index there;
/// `None` for zeros, which fill the arrays.
fn place(program: &Program, number: usize) -> Option<(String, usize)> {
    let (matrix, index) = program.products.as_ref()?.place(number)?;
    (!is_zero(program.stored(number))).then_some((matrix.name, index))
}

/// Returns the indices of the arguments, of these lengths, that the statements of a chunk or the
/// `stored` operands read.
fn arguments_read(
    program: &Program,
    chunk: &Chunk,
    stored: impl Iterator<Item = Operand>,
    lengths: &[usize],
) -> BTreeSet<usize> {
    let statements = program.statements[chunk.statements.clone()].iter();
    let operands = statements.clone().flat_map(|statement| statement.operation.operands());
    let number = |operand: Operand| match operand.source {
        Source::Argument(number) => Some(number),
        _ => None,
    };
    let in_loops = statements.flat_map(|statement| match &statement.operation {
        Operation::Loops(loops) => loops.arguments(),
        _ => Vec::new(),
    });
    let numbers = operands.chain(stored).filter_map(number).chain(in_loops);
    numbers.filter_map(|i| Some(argument_of(i, lengths.iter().copied()).ok()?.0)).collect()
}
