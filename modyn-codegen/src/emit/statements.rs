//! The statements of a program as lines of text: what C, CUDA, WGSL and MATLAB have in common.

mod loops;

use std::fmt::Write as _;

use loops::LoopStatements;
pub(super) use loops::{Around, Iterations, RoutineCall};

use super::support::Support;
use crate::program::{
    Addend, Array, Entry, MultiplyAdd, Operand, Operation, Place, Program, RowEquations, Source,
    Value, argument_of,
};

/// The syntax of a language.
pub(super) trait Syntax {
    /// Returns a number.
    fn literal(&self, value: f64) -> String;

    /// Returns the statement that defines a local value.
    fn define(&self, name: &str, value: &str) -> String;

    /// Returns the statements that define the sine and the cosine of an angle.
    fn sin_cos(&self, angle: &str, sine: &str, cosine: &str) -> String;

    /// Returns a product.
    fn multiply(&self, a: &str, b: &str) -> String {
        format!("{a} * {b}")
    }

    /// Returns the reciprocal.
    fn reciprocal(&self, x: &str) -> String {
        format!("{} / {x}", self.literal(1.0))
    }

    /// Returns an entry of an array.
    fn entry(&self, array: &str, place: Place) -> String {
        format!("{array}[{}]", loops::index(place))
    }

    /// Returns a product plus or minus an addend; `text` returns the text of an operand.
    fn multiply_add(&self, fused: &MultiplyAdd, text: &dyn Fn(&Operand) -> String) -> String;

    /// Returns the square root.
    fn square_root(&self, x: &str) -> String;

    /// Returns the absolute value.
    fn absolute(&self, x: &str) -> String;

    /// Returns the second value where the first is at least zero, else the third.
    fn select(&self, x: &str, then: &str, otherwise: &str) -> String;

    /// Returns entry `i` of the function's argument with this index.
    fn argument(&self, argument: usize, i: usize) -> String;

    /// Returns the value of the program's argument `i`, which is no argument of the function: these
    /// arguments come after the function's.
    fn constant_argument(&self, i: usize) -> String {
        unreachable!("a program's argument {i} is an argument of the function")
    }

    /// Returns entry `i` of the values that an earlier chunk passes on.
    fn live_value(&self, chunk: usize, i: usize) -> String;

    /// Returns the name of a function that the language lacks, or has.
    fn function(&self, support: Support) -> &'static str {
        match support {
            Support::SinCos => "modyn_sin_cos",
            Support::Atan2 => "modyn_atan2",
            Support::Logarithm => "modyn_ln",
            Support::Maximum => "modyn_maximum",
        }
    }

    /// Returns the entry of the function's argument with this index, as a routine of loops receives
    /// it.
    fn given(&self, argument: usize, place: Place) -> String {
        self.argument(argument, place.index)
    }

    /// Returns the statement that defines an array of zeros.
    fn zeros(&self, name: &str, shape: Array) -> String;

    /// Returns the lines around the steps of a loop.
    fn iterations(&self, iterations: &Iterations<'_>) -> Around;

    /// Returns the lines around the stores of a routine's results.
    fn call(&self, call: &RoutineCall) -> Around;

    /// Returns result `i` of the routine that was called last.
    fn result(&self, i: usize) -> String {
        format!("results[{i}]")
    }

    /// Returns the lines that define the results of row equations, with this name.
    fn row_equations(&self, _: &str, _: &RowEquations, _: &dyn Fn(&Operand) -> String) -> String {
        unreachable!("the back end has straight-line code for rows of any rank")
    }
}

/// Returns the name of the results of row equations, statement `s`.
fn rows(s: usize) -> String {
    format!("rows{s}")
}

/// The statements of one chunk.
pub(super) struct Body<'a, S> {
    pub syntax: &'a S,
    pub program: &'a Program,
    /// The lengths of the function's arguments.
    pub lengths: &'a [usize],
    /// The index of the chunk's first statement.
    pub first: usize,
}

impl<S: Syntax> Body<'_, S> {
    /// Prints a statement.
    pub fn statement(&self, text: &mut String, s: usize) {
        let t = |operand: &Operand| self.operand(operand);
        let call = |support, operands: &[&Operand]| {
            let operands: Vec<String> = operands.iter().map(|operand| t(operand)).collect();
            format!("{}({})", self.syntax.function(support), operands.join(", "))
        };
        let value = match &self.program.statements[s].operation {
            Operation::Add(a, b) => format!("{} + {}", t(a), t(b)),
            Operation::Subtract(a, b) => format!("{} - {}", t(a), t(b)),
            Operation::Multiply(a, b) => self.syntax.multiply(&t(a), &t(b)),
            Operation::MultiplyAdd(fused) => self.syntax.multiply_add(fused, &t),
            Operation::Reciprocal(a) => self.syntax.reciprocal(&t(a)),
            Operation::SinCos(angles) => {
                for (i, angle) in angles.iter().enumerate() {
                    let sine = self.local(s, 2 * i);
                    let cosine = self.local(s, 2 * i + 1);
                    let _ =
                        writeln!(text, "    {}", self.syntax.sin_cos(&t(angle), &sine, &cosine));
                }
                return;
            }
            Operation::Atan2(a, b) => call(Support::Atan2, &[a, b]),
            Operation::SquareRoot(a) => self.syntax.square_root(&t(a)),
            Operation::Logarithm(a) => call(Support::Logarithm, &[a]),
            Operation::Absolute(a) => self.syntax.absolute(&t(a)),
            Operation::Maximum(a, b) => call(Support::Maximum, &[a, b]),
            Operation::Select(a, b, c) => self.syntax.select(&t(a), &t(b), &t(c)),
            Operation::Loops(loops) => {
                LoopStatements { body: self, statement: s, loops }.print(text);
                return;
            }
            Operation::RowEquations(equations) => {
                *text += &self.syntax.row_equations(&rows(s), equations, &t);
                return;
            }
            Operation::Pack(_) | Operation::Constants(_) | Operation::Unpack(_) => {
                unreachable!("a program on scalars has no lanes")
            }
        };
        let _ = writeln!(text, "    {}", self.syntax.define(&self.local(s, 0), &value));
    }

    /// Returns the text of an operand.
    pub fn operand(&self, operand: &Operand) -> String {
        let text = match operand.source {
            Source::Constant(value) if value.is_sign_negative() => {
                format!("({})", self.syntax.literal(value))
            }
            Source::Constant(value) => self.syntax.literal(value),
            Source::Argument(number) => match argument_of(number, self.lengths.iter().copied()) {
                Ok((argument, i)) => self.syntax.argument(argument, i),
                Err(i) => self.syntax.constant_argument(i),
            },
            Source::Result(value) => self.value(value),
        };
        if operand.negated { format!("(-{text})") } else { text }
    }

    /// Returns the text of a value: a local variable, or an entry of an earlier chunk's array.
    pub fn value(&self, value: Value) -> String {
        if value.statement >= self.first {
            return self.local(value.statement, value.place);
        }
        let place = self.program.place_of(value);
        let (chunk, i) = place.expect("a value that crosses a cut is named there");
        self.syntax.live_value(chunk, i)
    }

    /// Returns the name of an array of loops, statement `s`.
    pub fn array(&self, s: usize, array: usize) -> String {
        format!("array{s}_{array}")
    }

    /// Returns the text of an argument of the program, as a routine of loops receives it.
    pub fn given(&self, place: Place) -> String {
        let argument = argument_of(place.index, self.lengths.iter().copied());
        let (argument, index) = argument.expect("an argument of the function");
        self.syntax.given(argument, Place { index, ..place })
    }

    fn local(&self, s: usize, place: usize) -> String {
        match &self.program.statements[s].operation {
            Operation::SinCos(_) if place.is_multiple_of(2) => format!("s{s}_{}", place / 2),
            Operation::SinCos(_) => format!("c{s}_{}", place / 2),
            Operation::RowEquations(_) => self.syntax.entry(&rows(s), Place::fixed(place)),
            Operation::Loops(loops) => {
                let Entry { array, index } = loops.results[place];
                let shape = loops.arrays[array];
                loops::entry(self.syntax, &self.array(s, array), shape, Place::fixed(index))
            }
            _ => format!("x{s}"),
        }
    }
}

/// Returns a product plus or minus an addend by operators. `product` is the operator of products.
pub(super) fn sum_of_products(
    fused: &MultiplyAdd,
    product: &str,
    text: &dyn Fn(&Operand) -> String,
) -> String {
    let MultiplyAdd { negative_product, factors: [a, b], negative_addend, addend } = fused;
    let product_of = |a, b| format!("({} {product} {})", text(a), text(b));
    let addend = match addend {
        Addend::Value(a) => text(a),
        Addend::Product(a, b) => product_of(a, b),
    };
    let product = product_of(a, b);
    match (negative_product, negative_addend) {
        (false, false) => format!("{product} + {addend}"),
        (false, true) => format!("{product} - {addend}"),
        (true, false) => format!("{addend} - {product}"),
        (true, true) => format!("-{product} - {addend}"),
    }
}
