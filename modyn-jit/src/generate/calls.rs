//! Calls of helpers, which save and restore the vector registers.

use super::Generator;
use super::architecture::Architecture;
use crate::helper::Helper;
use crate::values::{Operation, Value};

impl<A: Architecture> Generator<'_, A> {
    pub(super) fn save(&mut self, registers: u32) {
        for register in (0..32).filter(|register| registers >> register & 1 == 1) {
            let to = self.saved(register);
            A::store(self, register, self.vector, to);
        }
    }

    pub(super) fn restore(&mut self, registers: u32) {
        for register in (0..32).filter(|register| registers >> register & 1 == 1) {
            let from = self.saved(register);
            A::load(self, register, self.vector, from);
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
        let helper = match operation {
            Operation::Atan2 => Helper::Atan2,
            _ => Helper::Logarithm,
        };
        let last = *from.last().unwrap_or(&from[0]);
        let pointers = [register, from[0], last].map(|register| self.saved(register));
        A::call(self, helper, pointers, self.lanes(value));
        self.restore(occupied | 1 << register);
        register
    }
}
