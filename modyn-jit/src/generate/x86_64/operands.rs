//! Operands in registers and in memory, and the instructions that move them.

use super::Encoder;
use super::encode::{Encoding, Opcode, Operands, Place};
use super::frame::{BASES, RAX, RBX, RCX, SHORT};
use super::opcodes::{self as op, arithmetic, scalar_double};
use crate::generate::Generator;
use crate::generate::architecture::{Address, Part};
use crate::instruction_set::InstructionSet;
use crate::registers::{Home, NONE};
use crate::values::{Definition, Value};

impl Generator<'_, Encoder> {
    /// Returns the memory operand of an address.
    pub(super) fn place(&self, Address { part, offset }: Address) -> Place {
        let offset = offset as i32;
        match part {
            Part::Constants => Place::Memory(RBX, offset - SHORT),
            Part::Argument(array) => Place::Memory(BASES[usize::from(array)], offset),
            Part::Results => Place::Memory(RCX, offset),
            Part::Slots => Place::Memory(RAX, offset - SHORT),
            Part::Saved => Place::Memory(RAX, offset - SHORT - self.saved as i32),
        }
    }

    /// Writes an instruction on vectors of this number of bytes; the last operand has the same size
    /// in memory.
    pub(super) fn write(
        &mut self,
        opcode: Opcode,
        bytes: usize,
        registers: [u8; 2],
        place: Place,
        immediate: Option<u8>,
    ) {
        self.write_reading(bytes, opcode, bytes, registers, place, immediate);
    }

    /// Writes an instruction on vectors whose last operand has `memory` bytes. The registers are
    /// the first operand and the first source.
    pub(super) fn write_reading(
        &mut self,
        memory: usize,
        opcode: Opcode,
        bytes: usize,
        [register, source]: [u8; 2],
        place: Place,
        immediate: Option<u8>,
    ) {
        let highest = match place {
            Place::Register(last) => register.max(source).max(last),
            Place::Memory(..) => register.max(source),
        };
        let vector = bytes.max(16);
        let encoding = match self.instruction_set {
            InstructionSet::Sse2 => Encoding::Legacy,
            _ if highest > 15 || vector > 32 => Encoding::Evex,
            _ => Encoding::Vex,
        };
        let operands = Operands { vector, register, source, place, memory, immediate };
        self.encoder.vector(encoding, opcode, &operands);
    }

    /// Returns the instruction that loads or stores a value of this number of bytes.
    pub(super) fn moving(&self, byte: u8, bytes: usize) -> Opcode {
        match bytes {
            4 => arithmetic(byte, true, 4),
            8 => scalar_double(byte),
            _ => arithmetic(byte, false, self.size),
        }
    }

    pub(super) fn copy(&mut self, to: u8, from: u8, bytes: usize) {
        self.counts.copies += 1;
        let opcode = arithmetic(op::COPY, false, self.size);
        self.write(opcode, bytes, [to, 0], Place::Register(from), None);
    }

    /// Returns whether an instruction can read this operand from memory.
    pub(super) fn can_fold(&self, value: Value, bitwise: bool) -> bool {
        let scalar = self.lanes(value) == 1;
        let aligned = self.instruction_set != InstructionSet::Sse2 || scalar && !bitwise;
        match self.values.definitions[value as usize] {
            Definition::Constant(_) if scalar && bitwise => {
                self.values.bits(value).is_some_and(|bits| bits.len() * self.size >= 16)
            }
            Definition::Constant(_) => true,
            _ if scalar && bitwise => false,
            Definition::Result(..) => {
                aligned || matches!(self.registers.home(value), Home::Slot(_))
            }
            Definition::Argument { .. } | Definition::Lane(..) => aligned,
        }
    }

    /// Returns an operand as the last operand of an instruction.
    pub(super) fn operand(&mut self, value: Value, bitwise: bool, pinned: &mut u32) -> Place {
        let register = self.registers.register(value);
        if register == NONE && self.can_fold(value, bitwise) {
            self.counts.memory_operands += 1;
            return self.place(self.memory(value));
        }
        Place::Register(self.force(value, pinned))
    }

    /// Returns the register of an operand that is read for the last time, or a free one.
    pub(super) fn destination(&mut self, operands: &[Value], pinned: u32) -> u8 {
        let dying = operands.iter().filter(|&&operand| self.registers.dies(operand));
        let mut registers = dying.map(|&operand| self.registers.register(operand));
        match registers.find(|&register| register != NONE) {
            Some(register) => register,
            None => self.fresh(pinned),
        }
    }
}
