//! Prints a program as a kernel, one line for each statement. Chunks become functions that pass their values on through
//! arrays.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::{Dialect, Kernel};
use crate::emit::support::Support;
use crate::program::{Addend, MultiplyAdd, Operand, Operation, Source, Value, argument_of};

/// Returns the text of a kernel and its chunks, and adds the functions that it calls to `used`.
pub(super) fn print(
    dialect: &dyn Dialect,
    kernel: &Kernel<'_>,
    used: &mut BTreeSet<Support>,
) -> String {
    let program = kernel.program;
    used.extend(program.statements.iter().filter_map(|s| Support::of(&s.operation)));
    let values: Vec<usize> = program.chunks.iter().map(|chunk| chunk.live_out.len()).collect();
    let last = program.chunks.len() - 1;
    let (mut text, mut calls) = (String::new(), String::new());
    for (k, chunk) in program.chunks.iter().enumerate() {
        let inner = k < last;
        let body = Body { dialect, kernel, first: chunk.statements.start, inner };
        let mut lines = String::new();
        if k == 0 {
            body.stores(&mut lines, &program.first_stores);
        }
        for s in chunk.statements.clone() {
            body.statement(&mut lines, s);
            body.stores(&mut lines, &program.statements[s].stores);
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

/// The context in which a chunk's statements are printed.
struct Body<'a> {
    dialect: &'a dyn Dialect,
    kernel: &'a Kernel<'a>,
    /// The first statement of the chunk.
    first: usize,
    /// Whether the chunk is a function that the kernel calls.
    inner: bool,
}

impl Body<'_> {
    /// Returns the statements that store these results.
    fn stores(&self, text: &mut String, results: &[usize]) {
        for &result in results {
            let value = self.operand(&self.kernel.program.results[result]);
            let _ = writeln!(
                text,
                "    {}",
                self.dialect.store(&self.kernel.description, result, &value, self.inner)
            );
        }
    }

    fn statement(&self, text: &mut String, s: usize) {
        let dialect = self.dialect;
        let t = |operand: &Operand| self.operand(operand);
        let call = |name: &str, operands: &[&Operand]| {
            let operands: Vec<String> = operands.iter().map(|operand| t(operand)).collect();
            format!("modyn_{name}({})", operands.join(", "))
        };
        let value = match &self.kernel.program.statements[s].operation {
            Operation::Add(a, b) => format!("{} + {}", t(a), t(b)),
            Operation::Subtract(a, b) => format!("{} - {}", t(a), t(b)),
            Operation::Multiply(a, b) => format!("{} * {}", t(a), t(b)),
            Operation::MultiplyAdd(fused) => self.multiply_add(fused),
            Operation::Reciprocal(a) => format!("{} / {}", dialect.literal(1.0), t(a)),
            Operation::SinCos(angles) => {
                for (i, angle) in angles.iter().enumerate() {
                    let (sine, cosine) = (self.local(s, 2 * i), self.local(s, 2 * i + 1));
                    let _ = writeln!(text, "    {}", dialect.sin_cos(&t(angle), &sine, &cosine));
                }
                return;
            }
            Operation::Atan2(a, b) => call("atan2", &[a, b]),
            Operation::SquareRoot(a) => dialect.square_root(&t(a)),
            Operation::Logarithm(a) => call("ln", &[a]),
            Operation::Absolute(a) => dialect.absolute(&t(a)),
            Operation::Maximum(a, b) => call("maximum", &[a, b]),
            Operation::Select(a, b, c) => dialect.select(&t(a), &t(b), &t(c)),
            Operation::Pack(_)
            | Operation::Constants(_)
            | Operation::Unpack(_)
            | Operation::Call(_) => {
                unreachable!("the program of a thread has neither lanes nor routines")
            }
        };
        let _ = writeln!(text, "    {}", dialect.define(&self.local(s, 0), &value));
    }

    fn multiply_add(&self, fused: &MultiplyAdd) -> String {
        let MultiplyAdd { negative_product, factors: [a, b], negative_addend, addend } = fused;
        let a = Operand { negated: a.negated ^ negative_product, ..*a };
        let addend = match addend {
            Addend::Value(c) => {
                self.operand(&Operand { negated: c.negated ^ negative_addend, ..*c })
            }
            Addend::Product(c, d) => {
                let c = Operand { negated: c.negated ^ negative_addend, ..*c };
                format!("{} * {}", self.operand(&c), self.operand(d))
            }
        };
        self.dialect.multiply_add(&self.operand(&a), &self.operand(b), &addend)
    }

    fn operand(&self, operand: &Operand) -> String {
        let text = match operand.source {
            Source::Constant(value) if value.is_sign_negative() => {
                format!("({})", self.dialect.literal(value))
            }
            Source::Constant(value) => self.dialect.literal(value),
            Source::Argument(number) => self.argument(number),
            Source::Result(value) => self.value(value),
        };
        if operand.negated { format!("(-{text})") } else { text }
    }

    /// Returns the scalar argument with this number: an argument of the kernel, or a constant.
    fn argument(&self, number: usize) -> String {
        let kernel = &self.kernel.description;
        match argument_of(number, kernel.arguments.iter().map(|argument| argument.len)) {
            Ok((argument, i)) => self.dialect.argument(kernel, &kernel.arguments[argument], i),
            Err(i) => format!("({})", self.dialect.literal(self.kernel.known[i])),
        }
    }

    /// Returns a value: a local variable, or an entry of an earlier chunk's array.
    fn value(&self, value: Value) -> String {
        if value.statement >= self.first {
            return self.local(value.statement, value.place);
        }
        let place = self.kernel.program.place_of(value);
        let (chunk, i) = place.expect("a value that crosses a cut is named there");
        self.dialect.live_value(chunk, i, self.inner)
    }

    fn local(&self, s: usize, place: usize) -> String {
        match &self.kernel.program.statements[s].operation {
            Operation::SinCos(_) if place.is_multiple_of(2) => format!("s{s}_{}", place / 2),
            Operation::SinCos(_) => format!("c{s}_{}", place / 2),
            _ => format!("x{s}"),
        }
    }
}
