//! Prints a program as a kernel, one line for each statement. Chunks become functions that pass their values on through
//! arrays.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::{Dialect, Kernel, ThreadArray, products};
use crate::emit::statements::{Body, Syntax};
use crate::emit::support::Support;
use crate::program::{Addend, MultiplyAdd, Operand, is_zero};

/// Returns the text of a kernel and its chunks, and adds the functions that it calls to `used`.
pub(super) fn print(
    dialect: &dyn Dialect,
    kernel: &Kernel<'_>,
    used: &mut BTreeSet<Support>,
) -> String {
    let program = kernel.program;
    used.extend(program.statements.iter().filter_map(|s| Support::of(&s.operation)));
    let lengths: Vec<usize> =
        kernel.description.arguments.iter().map(|argument| argument.len).collect();
    let last = program.chunks.len() - 1;
    let matrices: Vec<ThreadArray> = program.products.iter().flat_map(products::arrays).collect();
    let replaced = program.products.as_ref().map(|products| products.replaced(&program.results));
    let replaced = replaced.unwrap_or_default();
    let define = |line: String| format!("    {line}\n");
    let mut calls: String = matrices.iter().map(|array| define(dialect.zeros(array))).collect();
    let mut text = String::new();
    for (k, chunk) in program.chunks.iter().enumerate() {
        let inner = k < last;
        let (syntax, first) = (&Statements { dialect, kernel, inner }, chunk.statements.start);
        let body = Body { syntax, program, lengths: &lengths, first };
        let mut lines = String::new();
        if k == 0 {
            stores(&body, &mut lines, &program.first_stores, &replaced);
        }
        for s in chunk.statements.clone() {
            body.statement(&mut lines, s);
            stores(&body, &mut lines, &program.statements[s].stores, &replaced);
        }
        if inner {
            let values = |k: usize, is_written| ThreadArray {
                name: format!("chunk{k}"),
                len: program.chunks[k].live_out.len().max(1),
                is_written,
            };
            for (i, &value) in chunk.live_out.iter().enumerate() {
                let place = syntax.value_of_chunk(k, i);
                let _ = writeln!(lines, "    {place} = {};", body.value(value));
            }
            let own = values(k, true);
            calls += &define(dialect.unset(&own));
            let live_in = chunk.live_in.iter().map(|&k| values(k, false));
            let arrays: Vec<ThreadArray> =
                live_in.chain([own]).chain(matrices.iter().cloned()).collect();
            text += &dialect.chunk(&kernel.description, k, &arrays, &lines);
            calls += &define(dialect.call(&kernel.description, k, &arrays));
        } else {
            if let Some(products) = &program.products {
                products::print(&mut lines, dialect, kernel, products);
            }
            text += &dialect.kernel(&kernel.description, &kernel.docs, &(calls.clone() + &lines));
        }
    }
    text
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

    fn constant_argument(&self, i: usize) -> String {
        format!("({})", self.dialect.literal(self.kernel.placement_numbers[i]))
    }

    fn live_value(&self, chunk: usize, i: usize) -> String {
        self.value_of_chunk(chunk, i)
    }
}

impl Statements<'_> {
    /// Returns entry `i` of the values that a chunk passes on.
    fn value_of_chunk(&self, chunk: usize, i: usize) -> String {
        self.dialect.entry(&format!("chunk{chunk}"), &i.to_string(), self.inner)
    }
}

/// Prints the statements that store these numbers: entries of products, and results that products do not replace.
fn stores(
    body: &Body<'_, Statements<'_>>,
    text: &mut String,
    numbers: &[usize],
    replaced: &BTreeSet<usize>,
) {
    let Statements { dialect, kernel, inner } = body.syntax;
    let program = kernel.program;
    for &number in numbers {
        let operand = program.stored(number);
        let value = body.operand(operand);
        let line = match program.stored_result(number) {
            Some(result) if replaced.contains(&result) => continue,
            Some(result) => dialect.store(&kernel.description, result, &value, *inner),
            // The arrays are filled with zeros.
            None if is_zero(operand) => continue,
            None => {
                let products = program.products.as_ref();
                let place = products.and_then(|products| products.place(number));
                let Some((matrix, index)) = place else { continue };
                let place = dialect.entry(&matrix.name, &index.to_string(), *inner);
                format!("{place} = {value};")
            }
        };
        let _ = writeln!(text, "    {line}");
    }
}
