//! Angles that are too large for the fast reduction: the comparison that finds them, and the code after the return that
//! reduces them.

use super::Generator;
use super::frame::{R11, RDI, RDX, RSI};
use crate::encode::{Encoding, Operands, Place};
use crate::helper::Helper;
use crate::instruction_set::InstructionSet;
use crate::opcodes::{self as op, arithmetic};
use crate::registers::NONE;
use crate::values::FarCheck;

/// The predicate of the comparison.
const LESS: u8 = 1;

/// Instructions outside of the straight path.
pub(super) struct SlowPath {
    /// The position of the jump's distance.
    from: usize,
    /// The position after it.
    back: usize,
    /// The registers that hold values.
    occupied: u32,
    /// The places of each angle, its reduction and the number with the multiple's lowest bit; and the number of lanes.
    angles: Vec<([Place; 3], u8)>,
}

impl Generator<'_> {
    /// Compares the angles with the limit, and jumps to the code after the return if one is too large.
    pub(super) fn check(&mut self, check: &FarCheck) {
        let FarCheck { squares, limit, angles } = check;
        let (bytes, lanes) = (self.registers.bytes(*squares), self.lanes(*squares));
        let mut pinned = self.registers.pinned(&[*squares, *limit]);
        let first = self.force(*squares, &mut pinned);
        if lanes == 1 {
            // The flags say "above" if limit > squares, and not if one is NaN.
            let last = self.force(*limit, &mut pinned);
            let opcode = arithmetic(op::COMPARE_FLAGS, false, self.size);
            self.write(opcode, self.size, [last, 0], Place::Register(first), None);
            // jbe
            self.encoder.bytes(&[0x0f, 0x86, 0, 0, 0, 0]);
        } else {
            let last = self.operand(*limit, false, &mut pinned);
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
                let to = if self.registers.dies(*squares) { first } else { self.fresh(pinned) };
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
        let back = self.encoder.code.len();
        for value in [*squares, *limit] {
            if self.registers.dies(value) {
                self.registers.drop(value);
            }
        }
        let places = angles.iter().map(|reduced| {
            let all = [reduced.angle, reduced.results[0], reduced.results[1]];
            let places = all.map(|value| match self.registers.register(value) {
                NONE => self.memory(value),
                register => self.saved(register),
            });
            (places, self.lanes(reduced.angle))
        });
        let angles_in_places = places.collect();
        let occupied = self.registers.occupied();
        self.slow_paths.push(SlowPath { from: back - 4, back, occupied, angles: angles_in_places });
        for reduced in angles {
            for value in reduced.results {
                // The code after the return changes it in memory.
                if self.registers.register(value) != NONE {
                    self.registers.forget_home(value);
                }
            }
            for value in [reduced.angle, reduced.results[0], reduced.results[1]] {
                if self.registers.dies(value) {
                    self.registers.drop(value);
                }
            }
        }
    }

    /// Writes the code that reduces angles that are too large.
    pub(super) fn slow_paths(&mut self) {
        for SlowPath { from, back, occupied, angles } in std::mem::take(&mut self.slow_paths) {
            let start = self.encoder.code.len();
            self.encoder.patch(from, start);
            self.save(occupied);
            for ([angle, reduced, multiple], lanes) in angles {
                // The angle is first: it may be an argument, whose base register the following loads overwrite.
                self.address(RDX, angle);
                self.address(RDI, reduced);
                self.address(RSI, multiple);
                self.call_helper(Helper::Reduce, lanes);
            }
            self.restore(occupied);
            self.encoder.bytes(&[0xe9, 0, 0, 0, 0]);
            let end = self.encoder.code.len();
            self.encoder.patch(end - 4, back);
        }
    }
}
