//! The evaluation of a program on numbers: the reference for printers and back ends.

use modyn_runtime::Scalar;

use super::{Addend, MultiplyAdd, Operand, Operation, Program, Source};

impl Program {
    /// Returns the results for these arguments, by the operations of [`Scalar`].
    ///
    /// # Panics
    ///
    /// If an argument that is read is missing.
    #[must_use]
    pub fn evaluate<S: Scalar>(&self, arguments: &[S]) -> Vec<S> {
        let mut values = Values::with_capacity(self.statements.len());
        // The lanes of the results of a statement, one result after the other.
        let mut results: Vec<S> = Vec::new();
        for statement in &self.statements {
            let lanes = 0..usize::from(statement.lanes);
            let at = |operand: &Operand, lane: usize| values.lane(operand, lane, arguments);
            let mut each = |number: &dyn Fn(usize) -> S| results.extend(lanes.clone().map(number));
            match &statement.operation {
                Operation::Add(a, b) => each(&|lane| at(a, lane) + at(b, lane)),
                Operation::Subtract(a, b) => each(&|lane| at(a, lane) - at(b, lane)),
                Operation::Multiply(a, b) => each(&|lane| at(a, lane) * at(b, lane)),
                Operation::MultiplyAdd(fused) => each(&|lane| {
                    let MultiplyAdd { negative_product, factors: [a, b], .. } = fused;
                    let signed = |negative: bool, x: S| if negative { -x } else { x };
                    let addend = match &fused.addend {
                        Addend::Value(c) => signed(fused.negative_addend, at(c, lane)),
                        Addend::Product(c, d) => {
                            signed(fused.negative_addend, at(c, lane)) * at(d, lane)
                        }
                    };
                    signed(*negative_product, at(a, lane)).mul_add(at(b, lane), addend)
                }),
                Operation::Reciprocal(a) => each(&|lane| at(a, lane).recip()),
                Operation::SinCos(angles) => {
                    for angle in angles {
                        let both: Vec<(S, S)> =
                            lanes.clone().map(|lane| at(angle, lane).sin_cos()).collect();
                        results.extend(both.iter().map(|x| x.0));
                        results.extend(both.iter().map(|x| x.1));
                    }
                }
                Operation::Atan2(a, b) => each(&|lane| at(a, lane).atan2(at(b, lane))),
                Operation::SquareRoot(a) => each(&|lane| at(a, lane).sqrt()),
                Operation::Logarithm(a) => each(&|lane| at(a, lane).ln()),
                Operation::Absolute(a) => each(&|lane| at(a, lane).abs()),
                Operation::Maximum(a, b) => each(&|lane| at(a, lane).max(at(b, lane))),
                Operation::Select(a, b, c) => {
                    each(&|lane| at(a, lane).select_nonnegative(at(b, lane), at(c, lane)))
                }
                Operation::Pack(packed) => each(&|lane| at(&packed[lane], 0)),
                Operation::Constants(packed) => each(&|lane| S::from_f64(packed[lane])),
                Operation::Unpack(vector) => {
                    results.extend((0..usize::from(vector.lanes)).map(|lane| at(vector, lane)));
                }
                Operation::RowEquations(equations) => {
                    results.extend(equations.evaluate(|operand| at(operand, 0)));
                }
                Operation::Loops(loops) => {
                    let number = |operand: &Operand| at(operand, 0);
                    results.extend(loops.evaluate(self, arguments, number));
                }
            }
            let width = match &statement.operation {
                // Each result is a scalar.
                Operation::Unpack(_) | Operation::Loops(_) | Operation::RowEquations(_) => 1,
                _ => usize::from(statement.lanes),
            };
            values.push(width, &mut results);
        }
        let value = |operand: &Operand| values.lane(operand, 0, arguments);
        let mut results: Vec<S> = self.results.iter().map(value).collect();
        if let Some(products) = &self.products {
            products.apply(&self.results, &mut results, value);
        }
        results
    }
}

/// The results of the statements so far, one after the other.
struct Values<S> {
    numbers: Vec<S>,
    /// For each statement the index of its first number, and the lanes of each of its results.
    statements: Vec<(usize, usize)>,
}

impl<S: Scalar> Values<S> {
    fn with_capacity(statements: usize) -> Self {
        let numbers = Vec::with_capacity(statements);
        Self { numbers, statements: Vec::with_capacity(statements) }
    }

    /// Adds the results of a statement, each with `width` lanes, and leaves `results` empty.
    fn push(&mut self, width: usize, results: &mut Vec<S>) {
        self.statements.push((self.numbers.len(), width));
        self.numbers.append(results);
    }

    /// Returns one lane of an operand; a scalar is the same in all lanes.
    fn lane(&self, operand: &Operand, lane: usize, arguments: &[S]) -> S {
        let value = match operand.source {
            Source::Constant(value) => S::from_f64(value),
            Source::Argument(number) => arguments[number],
            Source::Result(value) => {
                let (start, width) = self.statements[value.statement];
                self.numbers[start + value.place * width + if width == 1 { 0 } else { lane }]
            }
        };
        if operand.negated { -value } else { value }
    }
}
