//! Values as operands: in registers, in memory, and on the way between them.

use super::Generator;
use super::architecture::{Address, Architecture, Part};
use crate::registers::{Home, NONE};
use crate::values::{Definition, Value};

impl<A: Architecture> Generator<'_, A> {
    /// Returns the address of a value.
    pub(super) fn memory(&self, value: Value) -> Address {
        match self.values.definitions[value as usize] {
            Definition::Constant(place) => {
                Address { part: Part::Constants, offset: self.pool_at[place as usize] }
            }
            Definition::Argument { array, first } => {
                Address { part: Part::Argument(array), offset: first * self.size as u32 }
            }
            Definition::Lane(vector, lane) => {
                let Address { part, offset } = self.memory(vector);
                Address { part, offset: offset + u32::from(lane) * self.size as u32 }
            }
            Definition::Result(..) => match self.registers.home(value) {
                Home::Slot(offset) => Address { part: Part::Slots, offset },
                Home::Result(offset) => Address { part: Part::Results, offset },
                Home::None => unreachable!("a value that is read is somewhere"),
            },
        }
    }

    /// Returns the address of a register during calls.
    pub(super) fn saved(&self, register: u8) -> Address {
        Address { part: Part::Saved, offset: u32::from(register) * self.vector as u32 }
    }

    pub(super) fn lanes(&self, value: Value) -> u8 {
        self.values.lanes[value as usize]
    }

    pub(super) fn load(&mut self, register: u8, value: Value) {
        self.counts.loads += 1;
        let bytes = self.registers.bytes(value);
        let from = self.memory(value);
        A::load(self, register, bytes, from);
    }

    pub(super) fn store_result(&mut self, value: Value, register: u8, offset: u32) {
        let bytes = self.registers.bytes(value);
        A::store(self, register, bytes, Address { part: Part::Results, offset });
    }

    /// Returns a register that can be overwritten.
    pub(super) fn fresh(&mut self, pinned: u32) -> u8 {
        let register = self.registers.unoccupied(pinned).unwrap_or_else(|| {
            let (register, value) = self.registers.furthest(pinned);
            if self.registers.is_only_in_register(value) {
                self.spill(value, register);
            }
            self.registers.evict(value);
            register
        });
        self.written |= 1 << register;
        register
    }

    pub(super) fn spill(&mut self, value: Value, register: u8) {
        let offset = self.registers.give_slot(value);
        self.counts.spills += 1;
        let bytes = self.registers.bytes(value);
        A::store(self, register, bytes, Address { part: Part::Slots, offset });
    }

    /// Returns the register of a value, which is loaded if it is in none, for this instruction or
    /// for longer.
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
}
