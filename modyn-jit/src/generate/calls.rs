//! Calls of helpers, which save and restore the vector registers.

use super::Generator;
use super::frame::{RAX, RDI, RDX, RSI, SHORT, point};
use crate::encode::Place;
use crate::helper::{Helper, Linkage};
use crate::instruction_set::InstructionSet;
use crate::opcodes as op;
use crate::values::{Operation, Value};

impl Generator<'_> {
    /// Returns the memory operand of a register during calls.
    pub(super) fn saved(&self, register: u8) -> Place {
        let below = self.saved as i32 - i32::from(register) * self.vector as i32;
        Place::Memory(RAX, -SHORT - below)
    }

    /// Writes the load of an address.
    pub(super) fn address(&mut self, register: u8, place: Place) {
        if let Place::Memory(base, distance) = place {
            self.encoder.general(0x8d, register, base, distance);
        }
    }

    /// Writes a call of a helper, whose pointers are in registers already, and restores the registers that point to
    /// memory.
    pub(super) fn call_helper(&mut self, helper: Helper, lanes: u8) {
        // mov ecx, lanes
        self.encoder.bytes(&[&[0xb9][..], &u32::from(lanes).to_le_bytes()].concat());
        if self.instruction_set != InstructionSet::Sse2 {
            // vzeroupper
            self.encoder.bytes(&[0xc5, 0xf8, 0x77]);
        }
        match self.linkage {
            Linkage::Addresses(helpers) => {
                // mov rax, helper; call rax
                let address = helpers.address(helper);
                self.encoder.bytes(&[&[0x48, 0xb8][..], &address.to_le_bytes()].concat());
                self.encoder.bytes(&[0xff, 0xd0]);
            }
            Linkage::Relative => {
                // call helper
                self.encoder.bytes(&[0xe8, 0, 0, 0, 0]);
                self.calls.push((self.encoder.code.len() - 4, helper));
            }
        }
        let (arrays, frame) = (self.arrays, self.frame_base());
        point(&mut self.encoder, arrays, frame);
    }

    pub(super) fn save(&mut self, registers: u32) {
        for register in (0..32).filter(|register| registers >> register & 1 == 1) {
            let (place, bytes) = (self.saved(register), self.vector);
            self.write(self.moving(op::STORE, bytes), bytes, [register, 0], place, None);
        }
    }

    pub(super) fn restore(&mut self, registers: u32) {
        for register in (0..32).filter(|register| registers >> register & 1 == 1) {
            let (place, bytes) = (self.saved(register), self.vector);
            self.write(self.moving(op::LOAD, bytes), bytes, [register, 0], place, None);
        }
    }

    /// Writes an operation that is a call of a helper.
    pub(super) fn call(
        &mut self,
        operation: Operation,
        value: Value,
        operands: &[Value],
        mut pinned: u32,
    ) -> u8 {
        let from: Vec<u8> =
            operands.iter().map(|&operand| self.force(operand, &mut pinned)).collect();
        let register = self.fresh(pinned);
        let read = from.iter().fold(0, |all, register| all | 1 << register);
        let occupied = self.registers.occupied();
        self.save(occupied | read);
        self.address(RDI, self.saved(register));
        self.address(RSI, self.saved(from[0]));
        self.address(RDX, self.saved(*from.last().unwrap_or(&from[0])));
        let helper = match operation {
            Operation::Atan2 => Helper::Atan2,
            _ => Helper::Logarithm,
        };
        self.call_helper(helper, self.lanes(value));
        self.restore(occupied | 1 << register);
        register
    }
}
