//! Operations on registers, and the comparison that finds large angles and dependent rows.

use super::encode::{Encoder, NO_REGISTER, SCRATCH};
use super::opcodes as op;
use crate::generate::Generator;
use crate::generate::architecture::Architecture as _;
use crate::registers::NONE;
use crate::values::{Operation, Value};

impl Generator<'_, Encoder> {
    /// Writes an operation that is no call, and returns the register of its result.
    pub(super) fn operation(&mut self, operation: Operation, value: Value, mut pinned: u32) -> u8 {
        let values = self.values;
        let operands = values.operands(value);
        let mut from = [NONE; 3];
        for (i, operand) in operands.iter().enumerate() {
            from[i] = match operands[..i].iter().position(|earlier| earlier == operand) {
                Some(same) => from[same],
                None => self.force(*operand, &mut pinned),
            };
        }
        let [a, b, c] = from;
        let scalar = self.lanes(value) == 1;
        let size = self.size;
        match operation {
            Operation::MultiplyAdd(negated) if !scalar => {
                let to = self.addend(operands, c, negated.addend, pinned);
                self.encoder.three(op::accumulate(negated.product, size), [to, a, b]);
                return to;
            }
            Operation::Maximum => {
                // The comparison's result selects, and is overwritten.
                let to = self.fresh(pinned);
                self.encoder.three(op::GREATER.of(scalar, size), [to, a, b]);
                self.encoder.three(op::SELECT, [to, a, b]);
                return to;
            }
            _ => {}
        }
        let to = self.destination(operands, from, pinned);
        let encoder = &mut self.encoder;
        match operation {
            Operation::Add => encoder.three(op::ADD.of(scalar, size), [to, a, b]),
            Operation::Subtract => encoder.three(op::SUBTRACT.of(scalar, size), [to, a, b]),
            Operation::Multiply => encoder.three(op::MULTIPLY.of(scalar, size), [to, a, b]),
            Operation::Divide => encoder.three(op::DIVIDE.of(scalar, size), [to, a, b]),
            Operation::MultiplyAdd(negated) => {
                encoder.four(op::multiply_add(negated, size), [to, a, b, c]);
            }
            Operation::SquareRoot => encoder.two(op::SQUARE_ROOT.of(scalar, size), [to, a]),
            Operation::LessOrEqual => {
                encoder.three(op::GREATER_OR_EQUAL.of(scalar, size), [to, b, a]);
            }
            Operation::IsNan => {
                encoder.three(op::EQUAL.of(scalar, size), [to, a, a]);
                encoder.two(op::NOT, [to, to]);
            }
            Operation::And => encoder.three(op::AND, [to, a, b]),
            Operation::AndNot => encoder.three(op::CLEAR, [to, b, a]),
            Operation::Or => encoder.three(op::OR, [to, a, b]),
            Operation::Xor => encoder.three(op::XOR, [to, a, b]),
            Operation::ShiftToSign => encoder.two(op::shift_to_sign(size), [to, a]),
            Operation::Broadcast => encoder.two(op::broadcast(size), [to, a]),
            Operation::Join => {
                let part = usize::from(values.lanes[operands[0] as usize]) * size;
                encoder.three(op::join(part), [to, a, b]);
            }
            Operation::Maximum | Operation::Atan2 | Operation::Logarithm => {
                unreachable!("it is written above, or is a call")
            }
        }
        to
    }

    /// Returns the register of an operand that is read for the last time, or a free one.
    fn destination(&mut self, operands: &[Value], from: [u8; 3], pinned: u32) -> u8 {
        match operands.iter().position(|&operand| self.registers.dies(operand)) {
            Some(last) => from[last],
            None => self.fresh(pinned),
        }
    }

    /// Returns a register with the addend of a fused product of vectors, to which the product can
    /// be added.
    fn addend(&mut self, operands: &[Value], from: u8, negative: bool, pinned: u32) -> u8 {
        let addend = operands[2];
        // The product reads its factors after the addend was negated.
        let overwritten =
            self.registers.dies(addend) && !(negative && operands[..2].contains(&addend));
        let to = if overwritten { from } else { self.fresh(pinned) };
        if negative {
            self.encoder.two(op::NEGATE.of(false, self.size), [to, from]);
        } else if !overwritten {
            self.counts.copies += 1;
            self.encoder.copy(to, from);
        }
        to
    }

    /// Writes a jump that is taken unless all lanes of the first value are less than the lanes of
    /// the second value, and returns its position.
    pub(super) fn jump_unless_less(&mut self, [squares, limit]: [Value; 2]) -> usize {
        let mut pinned = self.registers.pinned(&[squares, limit]);
        let [first, last] = [squares, limit].map(|value| self.force(value, &mut pinned));
        // Conditional jumps reach 1 MiB, others 128 MiB.
        if self.lanes(squares) == 1 {
            self.encoder.three(op::compare_flags(self.size), [0, first, last]);
            self.encoder.word(op::SKIP_IF_LESS);
        } else {
            let is_less = if self.registers.dies(squares) { first } else { self.fresh(pinned) };
            self.encoder.three(op::GREATER.of(false, self.size), [is_less, last, first]);
            self.encoder.two(op::MINIMUM_ACROSS, [is_less, is_less]);
            self.encoder.two(op::TO_GENERAL, [SCRATCH, is_less]);
            self.encoder.two(op::COMPARE_WITH_ALL_BITS, [NO_REGISTER, SCRATCH]);
            self.encoder.word(op::SKIP_IF_EQUAL);
        }
        self.encoder.jump()
    }
}
