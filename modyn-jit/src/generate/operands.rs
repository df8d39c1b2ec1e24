//! Values as operands: in registers, in memory, and on the way between them.

use super::Generator;
use super::frame::{BASES, RAX, RBX, RCX, SHORT};
use crate::encode::{Encoding, Opcode, Operands, Place};
use crate::instruction_set::InstructionSet;
use crate::opcodes::{self as op, arithmetic, scalar_double};
use crate::registers::{Home, NONE};
use crate::values::{Definition, Value};

impl Generator<'_> {
    /// Returns the memory operand of a value.
    pub(super) fn memory(&self, value: Value) -> Place {
        match self.values.definitions[value as usize] {
            Definition::Constant(place) => {
                Place::Memory(RBX, self.pool_at[place as usize] as i32 - SHORT)
            }
            Definition::Argument { array, first } => {
                Place::Memory(BASES[usize::from(array)], (first as usize * self.size) as i32)
            }
            Definition::Lane(vector, lane) => match self.memory(vector) {
                Place::Memory(base, distance) => {
                    Place::Memory(base, distance + i32::from(lane) * self.size as i32)
                }
                Place::Register(_) => unreachable!("memory"),
            },
            Definition::Result(..) => match self.registers.home(value) {
                Home::Slot(slot) => Place::Memory(RAX, slot as i32 - SHORT),
                Home::Result(distance) => Place::Memory(RCX, distance as i32),
                Home::None => unreachable!("a value that is read is somewhere"),
            },
        }
    }

    pub(super) fn lanes(&self, value: Value) -> u8 {
        self.values.lanes[value as usize]
    }

    /// Writes an instruction on vectors of this number of bytes; the last operand has the same size in memory.
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

    /// Writes an instruction on vectors whose last operand has `memory` bytes. The registers are the first operand and
    /// the first source.
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

    pub(super) fn load(&mut self, register: u8, value: Value) {
        let (bytes, place) = (self.registers.bytes(value), self.memory(value));
        self.counts.loads += 1;
        self.write(self.moving(op::LOAD, bytes), bytes, [register, 0], place, None);
    }

    pub(super) fn store(&mut self, register: u8, bytes: usize, place: Place) {
        self.write(self.moving(op::STORE, bytes), bytes, [register, 0], place, None);
    }

    pub(super) fn copy(&mut self, to: u8, from: u8, bytes: usize) {
        self.counts.copies += 1;
        let opcode = arithmetic(op::COPY, false, self.size);
        self.write(opcode, bytes, [to, 0], Place::Register(from), None);
    }

    pub(super) fn store_result(&mut self, value: Value, register: u8, distance: u32) {
        let bytes = self.registers.bytes(value);
        self.store(register, bytes, Place::Memory(RCX, distance as i32));
    }

    /// Returns a register that can be overwritten.
    pub(super) fn fresh(&mut self, pinned: u32) -> u8 {
        if let Some(register) = self.registers.unoccupied(pinned) {
            return register;
        }
        let (register, value) = self.registers.furthest(pinned);
        if self.registers.is_only_in_register(value) {
            self.spill(value, register);
        }
        self.registers.evict(value);
        register
    }

    pub(super) fn spill(&mut self, value: Value, register: u8) {
        let slot = self.registers.give_slot(value);
        self.counts.spills += 1;
        let bytes = self.registers.bytes(value);
        self.store(register, bytes, Place::Memory(RAX, slot as i32 - SHORT));
    }

    /// Returns the register of a value, which is loaded if it is in none, for this instruction or for longer.
    pub(super) fn force(&mut self, value: Value, pinned: &mut u32) -> u8 {
        let mut register = self.registers.register(value);
        if register == NONE {
            register = self.fresh(*pinned);
            self.load(register, value);
            if !self.registers.dies(value) {
                self.registers.hold(register, value);
            }
        }
        *pinned |= 1 << register;
        register
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
            return self.memory(value);
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
