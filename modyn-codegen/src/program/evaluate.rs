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
        // For each statement and each of its results, the lanes.
        let mut values: Vec<Vec<Vec<S>>> = Vec::with_capacity(self.statements.len());
        for statement in &self.statements {
            let lanes = 0..usize::from(statement.lanes);
            let at = |operand: &Operand, lane: usize| lane_of(operand, lane, &values, arguments);
            let each = |of: &dyn Fn(usize) -> S| vec![lanes.clone().map(of).collect::<Vec<S>>()];
            let results = match &statement.operation {
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
                Operation::SinCos(angles) => angles
                    .iter()
                    .flat_map(|angle| {
                        let both: Vec<(S, S)> =
                            lanes.clone().map(|lane| at(angle, lane).sin_cos()).collect();
                        [both.iter().map(|x| x.0).collect(), both.iter().map(|x| x.1).collect()]
                    })
                    .collect(),
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
                    (0..usize::from(vector.lanes)).map(|lane| vec![at(vector, lane)]).collect()
                }
                Operation::Call(call) => {
                    let routine = &self.routines[call.routine];
                    let constants = routine.tables[call.repetition].iter();
                    let operands = call.own.iter().chain(&call.common);
                    let all = constants.map(|&x| S::from_f64(x));
                    let all: Vec<S> = all.chain(operands.map(|operand| at(operand, 0))).collect();
                    routine.program.evaluate(&all).into_iter().map(|x| vec![x]).collect()
                }
            };
            values.push(results);
        }
        self.results.iter().map(|result| lane_of(result, 0, &values, arguments)).collect()
    }
}

/// Returns one lane of an operand.
fn lane_of<S: Scalar>(
    operand: &Operand,
    lane: usize,
    values: &[Vec<Vec<S>>],
    arguments: &[S],
) -> S {
    let value = match operand.source {
        Source::Constant(value) => S::from_f64(value),
        Source::Argument(number) => arguments[number],
        Source::Result(value) => match &*values[value.statement][value.place] {
            [scalar] => *scalar,
            lanes => lanes[lane],
        },
    };
    if operand.negated { -value } else { value }
}
