//! Instructions of one, two and three operands.

use super::Encoder;
use super::encode::{Encoding, Opcode, Operands, Place};
use super::opcodes::{self as op, arithmetic, broadcast, mask_to_vector, multiply_add, shift_left};
use crate::generate::Generator;
use crate::instruction_set::InstructionSet;
use crate::registers::NONE;
use crate::values::{Negated, Operation, Value};

/// A value in memory that is read again within this number of steps is loaded into a free register.
const RELOAD_DISTANCE: u32 = 40;

/// The predicates of comparisons.
const LESS_OR_EQUAL: u8 = 2;
const UNORDERED: u8 = 3;

impl Generator<'_, Encoder> {
    /// Writes an operation that is no call, and returns the register of its result.
    pub(super) fn operation(&mut self, operation: Operation, value: Value, mut pinned: u32) -> u8 {
        let values = self.values;
        let operands = values.operands(value);
        if operation != Operation::Broadcast {
            self.prefetch(operands, &mut pinned);
        }
        match (operation, operands) {
            (Operation::MultiplyAdd(negated), &[a, b, c]) => {
                self.multiply_add(value, [a, b, c], negated, pinned)
            }
            (Operation::SquareRoot | Operation::Broadcast, &[a]) => {
                self.unary(operation, value, a, pinned)
            }
            (Operation::ShiftToSign, &[a]) => self.shift_to_sign(value, a, pinned),
            // The instruction compares two operands.
            (Operation::IsNan, &[a]) => self.binary(operation, value, [a, a], pinned),
            (_, &[a, b]) => self.binary(operation, value, [a, b], pinned),
            _ => unreachable!("operations have their operands"),
        }
    }

    /// Loads operands that are read again soon, if registers are free.
    fn prefetch(&mut self, operands: &[Value], pinned: &mut u32) {
        for &operand in operands {
            let soon = self
                .registers
                .distance(operand)
                .is_some_and(|distance| distance <= RELOAD_DISTANCE);
            let absent = self.registers.register(operand) == NONE;
            if soon
                && absent
                && let Some(register) = self.registers.unoccupied(*pinned)
            {
                self.load(register, operand);
                self.registers.hold(register, operand);
                *pinned |= 1 << register;
            }
        }
    }

    /// Writes an operation of two operands.
    fn binary(
        &mut self,
        operation: Operation,
        value: Value,
        [mut a, mut b]: [Value; 2],
        mut pinned: u32,
    ) -> u8 {
        let legacy = self.instruction_set == InstructionSet::Sse2;
        if operation.commutes() {
            let [in_a, in_b] = [a, b].map(|x| self.registers.register(x));
            // The first operand is in a register. Low registers have shorter encodings as the
            // second operand. Instructions with two operands overwrite the first.
            let swap = match (in_a == NONE, in_b == NONE) {
                (true, false) => true,
                (false, false) if legacy => !self.registers.dies(a) && self.registers.dies(b),
                (false, false) => in_a < 8 && in_b >= 8,
                _ => false,
            };
            if swap {
                std::mem::swap(&mut a, &mut b);
            }
        }
        let bitwise = operation.is_bitwise();
        let bytes = self.registers.bytes(value);
        let scalar = self.lanes(value) == 1;
        let temporary = self.registers.register(a) == NONE && self.registers.dies(a);
        let first = self.force(a, &mut pinned);
        let second = match operation {
            _ if a == b => Place::Register(first),
            Operation::Join if bytes > 16 => self.operand(b, false, &mut pinned),
            // Two numbers of 8 bytes, or halves of them.
            Operation::Join if bytes == 16 && self.registers.register(b) == NONE => {
                self.counts.memory_operands += 1;
                self.place(self.memory(b))
            }
            Operation::Join => Place::Register(self.force(b, &mut pinned)),
            _ => self.operand(b, bitwise, &mut pinned),
        };
        let register = if temporary {
            first
        } else {
            self.destination(&[a, b][..if legacy { 1 } else { 2 }], pinned)
        };
        let source = if legacy && register != first {
            self.copy(register, first, bytes);
            register
        } else {
            first
        };
        let (opcode, immediate) = match operation {
            Operation::Join => self.join(bytes, second),
            Operation::LessOrEqual => {
                (arithmetic(op::COMPARE, scalar, self.size), Some(LESS_OR_EQUAL))
            }
            Operation::IsNan => (arithmetic(op::COMPARE, scalar, self.size), Some(UNORDERED)),
            Operation::Add => (arithmetic(op::ADD, scalar, self.size), None),
            Operation::Subtract => (arithmetic(op::SUBTRACT, scalar, self.size), None),
            Operation::Multiply => (arithmetic(op::MULTIPLY, scalar, self.size), None),
            Operation::Divide => (arithmetic(op::DIVIDE, scalar, self.size), None),
            Operation::Maximum => (arithmetic(op::MAXIMUM, scalar, self.size), None),
            Operation::And => (arithmetic(op::AND, false, self.size), None),
            Operation::AndNot => (arithmetic(op::AND_NOT, false, self.size), None),
            Operation::Or => (arithmetic(op::OR, false, self.size), None),
            Operation::Xor => (arithmetic(op::XOR, false, self.size), None),
            _ => unreachable!("an operation of two operands"),
        };
        let memory = match operation {
            Operation::Join => bytes / 2,
            _ if bitwise => bytes.max(16),
            _ => bytes,
        };
        let compares = matches!(operation, Operation::LessOrEqual | Operation::IsNan);
        if compares && self.instruction_set == InstructionSet::Avx512 {
            let operands = Operands {
                vector: bytes.max(16),
                register,
                source: first,
                place: second,
                memory: bytes,
                immediate,
            };
            self.compare_into_vector(opcode, operands);
        } else {
            self.write_reading(memory, opcode, bytes, [register, source], second, immediate);
        }
        register
    }

    /// Returns the instruction that joins two halves.
    fn join(&self, bytes: usize, second: Place) -> (Opcode, Option<u8>) {
        match (bytes, second) {
            (8, _) => (arithmetic(op::UNPACK_LOW, false, 4), None),
            (16, Place::Register(_)) => (op::UNPACK_LOW_DOUBLE, None),
            (16, Place::Memory(..)) => (op::LOAD_HIGH, None),
            (32, _) => (op::INSERT_128, Some(1)),
            _ => (op::INSERT_256, Some(1)),
        }
    }

    /// Writes a comparison whose result is a vector. AVX-512 compares into masks; only registers
    /// below 16 can be compared without them.
    fn compare_into_vector(&mut self, opcode: Opcode, operands: Operands) {
        // k1
        let into_mask = Operands { register: 1, ..operands };
        self.encoder.vector(Encoding::Evex, opcode, &into_mask);
        let from_mask =
            Operands { source: 0, place: Place::Register(1), immediate: None, ..operands };
        self.encoder.vector(Encoding::Evex, mask_to_vector(self.size), &from_mask);
    }

    fn unary(&mut self, operation: Operation, value: Value, a: Value, mut pinned: u32) -> u8 {
        let bytes = self.registers.bytes(value);
        let scalar = self.lanes(value) == 1;
        let legacy = self.instruction_set == InstructionSet::Sse2;
        if operation == Operation::Broadcast && legacy {
            let from = self.force(a, &mut pinned);
            let register = self.destination(&[a], pinned);
            if register != from {
                self.copy(register, from, bytes);
            }
            let (opcode, immediate) = match self.size {
                8 => (op::UNPACK_LOW_DOUBLE, None),
                _ => (op::SHUFFLE_SINGLE, Some(0)),
            };
            let place = Place::Register(register);
            self.write(opcode, 16, [register, register], place, immediate);
            return register;
        }
        // A square root of a scalar keeps the upper part of its first source. Both sources are the
        // same register, so that the instruction waits for no other register.
        let from = if operation == Operation::SquareRoot {
            Place::Register(self.force(a, &mut pinned))
        } else {
            self.operand(a, false, &mut pinned)
        };
        let register = self.destination(&[a], pinned);
        match (operation, from) {
            (Operation::SquareRoot, Place::Register(from)) => {
                let opcode = arithmetic(op::SQUARE_ROOT, scalar, self.size);
                let source = if scalar && !legacy { from } else { 0 };
                self.write(opcode, bytes, [register, source], Place::Register(from), None);
            }
            _ => {
                let opcode = if bytes == 16 && self.size == 8 {
                    op::DUPLICATE
                } else {
                    broadcast(self.size)
                };
                self.write_reading(self.size, opcode, bytes, [register, 0], from, None);
            }
        }
        register
    }

    fn shift_to_sign(&mut self, value: Value, a: Value, mut pinned: u32) -> u8 {
        let bytes = self.registers.bytes(value);
        let from = self.force(a, &mut pinned);
        let register = self.destination(&[a], pinned);
        // The destination is in the field of the first source, and the opcode's extension is in the
        // field of the destination.
        let count = (8 * self.size - 1) as u8;
        let opcode = shift_left(self.size);
        if self.instruction_set == InstructionSet::Sse2 {
            if register != from {
                self.copy(register, from, bytes);
            }
            self.write(opcode, bytes, [6, 0], Place::Register(register), Some(count));
        } else {
            self.write(opcode, bytes, [6, register], Place::Register(from), Some(count));
        }
        register
    }

    /// Writes a product and a sum in one instruction, which overwrites one of its three operands
    /// and can read the last one from memory.
    fn multiply_add(
        &mut self,
        value: Value,
        operands: [Value; 3],
        negated: Negated,
        mut pinned: u32,
    ) -> u8 {
        let bytes = self.registers.bytes(value);
        let scalar = self.lanes(value) == 1;
        let in_register = |this: &Self, i: usize| this.registers.register(operands[i]) != NONE;
        let equal = |i: usize, j: usize| i != j && operands[i] == operands[j];
        let has_equal = |i: usize| (0..3).any(|j| equal(i, j));
        // The loads and copies that an order of operands needs.
        let cost = |this: &Self, over: usize, memory: Option<usize>| {
            let can_overwrite = |i: usize| {
                let spare = this.registers.dies(operands[i]) && !has_equal(i);
                let loaded_before = (0..i).any(|j| Some(j) != memory && equal(i, j));
                match (i == over, in_register(this, i)) {
                    _ if Some(i) == memory => 0,
                    (true, true) if spare => 0,
                    (true, true) => 2,
                    (true, false) if spare => 2,
                    (true, false) => 4,
                    (false, false) if !loaded_before => 3,
                    (false, _) => 0,
                }
            };
            (0..3).map(can_overwrite).sum::<u32>()
        };
        let from_memory = (0..3).filter(|&i| !in_register(self, i)).map(Some).chain([None]);
        let all = from_memory.flat_map(|memory| (0..3).map(move |over| (over, memory)));
        let choices = all.filter(|&(over, memory)| Some(over) != memory);
        let (over, memory) = choices
            .min_by_key(|&(over, memory)| {
                (cost(self, over, memory), over, memory.is_none(), memory)
            })
            .expect("there are choices");
        let mut registers = [NONE; 3];
        for i in (0..3).filter(|&i| i != over && Some(i) != memory) {
            registers[i] = self.force(operands[i], &mut pinned);
        }
        let overwritten = operands[over];
        let same = (0..3).find(|&i| equal(i, over) && registers[i] != NONE);
        let register = match (self.registers.register(overwritten), same) {
            (NONE, None) => {
                let register = self.fresh(pinned);
                self.load(register, overwritten);
                register
            }
            (NONE, Some(same)) => {
                let register = self.fresh(pinned);
                self.copy(register, registers[same], bytes);
                register
            }
            (current, _) if self.registers.dies(overwritten) && !has_equal(over) => current,
            (current, _) => {
                let register = self.fresh(pinned | 1 << current);
                self.copy(register, current, bytes);
                register
            }
        };
        let place = |i: usize, this: &mut Self| match memory {
            Some(m) if m == i => {
                this.counts.memory_operands += 1;
                this.place(this.memory(operands[i]))
            }
            _ => Place::Register(registers[i]),
        };
        // The orders 231: d = a b + d, 213: d = a d + c, 132: d = d b + c.
        let (form, source, last) = match over {
            2 if memory == Some(0) => (0xb0, registers[1], place(0, self)),
            2 => (0xb0, registers[0], place(1, self)),
            _ if memory == Some(1 - over) => (0x90, registers[2], place(1 - over, self)),
            _ => (0xa0, registers[1 - over], place(2, self)),
        };
        let opcode = multiply_add(form, negated, scalar, self.size);
        self.write(opcode, bytes, [register, source], last, None);
        register
    }
}
