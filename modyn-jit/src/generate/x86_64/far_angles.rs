//! The comparison that finds large angles and dependent rows.

use super::Encoder;
use super::encode::{Encoding, Operands, Place};
use super::frame::R11;
use super::opcodes::{self as op, arithmetic};
use crate::generate::Generator;
use crate::instruction_set::InstructionSet;
use crate::values::Value;

/// The predicate of the comparison.
const LESS: u8 = 1;

impl Generator<'_, Encoder> {
    /// Writes a jump that is taken unless all lanes of the first value are less than the lanes of
    /// the second value, and returns the position of its distance.
    pub(super) fn jump_unless_less(&mut self, [squares, limit]: [Value; 2]) -> usize {
        let bytes = self.registers.bytes(squares);
        let lanes = self.lanes(squares);
        let mut pinned = self.registers.pinned(&[squares, limit]);
        let first = self.force(squares, &mut pinned);
        if lanes == 1 {
            // The flags say "above" if limit > squares, and not if one is NaN.
            let last = self.force(limit, &mut pinned);
            let opcode = arithmetic(op::COMPARE_FLAGS, false, self.size);
            self.write(opcode, self.size, [last, 0], Place::Register(first), None);
            // jbe
            self.encoder.bytes(&[0x0f, 0x86, 0, 0, 0, 0]);
        } else {
            let last = self.operand(limit, false, &mut pinned);
            let opcode = arithmetic(op::COMPARE, false, self.size);
            if self.instruction_set == InstructionSet::Avx512 {
                let operands = Operands {
                    vector: bytes,
                    register: 1,
                    source: first,
                    place: last,
                    memory: bytes,
                    immediate: Some(LESS),
                };
                self.encoder.vector(Encoding::Evex, opcode, &operands);
                // kmovw r11d, k1
                self.encoder.bytes(&[0xc5, 0x78, 0x93, 0xd9]);
            } else {
                let to = if self.registers.dies(squares) { first } else { self.fresh(pinned) };
                let legacy = self.instruction_set == InstructionSet::Sse2 && to != first;
                if legacy {
                    self.copy(to, first, bytes);
                }
                let source = if legacy { to } else { first };
                self.write(opcode, bytes, [to, source], last, Some(LESS));
                let opcode = arithmetic(op::SIGNS, false, self.size);
                self.write(opcode, bytes, [R11, 0], Place::Register(to), None);
            }
            // cmp r11d, all; jne
            let all = (1_u32 << lanes) - 1;
            self.encoder.bytes(&[&[0x41, 0x81, 0xfb][..], &all.to_le_bytes()].concat());
            self.encoder.bytes(&[0x0f, 0x85, 0, 0, 0, 0]);
        }
        self.encoder.code.len() - 4
    }
}
