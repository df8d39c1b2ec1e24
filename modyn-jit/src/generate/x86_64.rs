//! x86-64: SSE2, AVX2 and AVX-512.
//!
//! A function has two arguments: a pointer to a table of pointers to its arguments (rdi), and a
//! pointer to its results (rsi). It follows System V's calling convention on every system.
//! Registers in its body: rax points into the stack frame, rbx to the constants, rcx to the
//! results, and one register each to the arguments (r14 and r15, which belong to the caller, to the
//! seventh and the eighth); rbp is the frame pointer, as profilers know it: it points to the
//! caller's; r11 is free.
//!
//! The frame, upwards from rsp, which is a multiple of 64: the two pointers, memory for all vector
//! registers during calls, slots of values.
//!
//! Instructions read their last operand from memory where they can. Those of SSE2 overwrite their
//! first operand, and fused products overwrite one of three.

mod arithmetic;
mod calls;
mod encode;
mod far_angles;
mod frame;
pub(crate) mod opcodes;
mod operands;

use super::Generator;
use super::architecture::{Address, Architecture};
use crate::helper::Helper;
use crate::values::{Operation, Value};
use frame::{HEADER, SHORT};
use opcodes as op;

pub(crate) use encode::Encoder;
#[cfg(test)]
pub(crate) use encode::{Encoding, Opcode, Operands, Place};
#[cfg(feature = "object")]
pub(crate) use frame::{KEEP_BASES, PROLOGUE, allocate, keeps_bases};

impl Architecture for Encoder {
    const HEADER: usize = HEADER;
    const ALIGNMENT: usize = 64;

    fn position(&self) -> usize {
        self.code.len()
    }

    fn instructions(&self) -> usize {
        self.instructions
    }

    fn finish(self) -> Vec<u8> {
        self.code
    }

    fn load(generator: &mut Generator<'_, Self>, register: u8, bytes: usize, from: Address) {
        let place = generator.place(from);
        let opcode = generator.moving(op::LOAD, bytes);
        generator.write(opcode, bytes, [register, 0], place, None);
    }

    fn store(generator: &mut Generator<'_, Self>, register: u8, bytes: usize, to: Address) {
        let place = generator.place(to);
        let opcode = generator.moving(op::STORE, bytes);
        generator.write(opcode, bytes, [register, 0], place, None);
    }

    fn operation(
        generator: &mut Generator<'_, Self>,
        operation: Operation,
        value: Value,
        pinned: u32,
    ) -> u8 {
        generator.operation(operation, value, pinned)
    }

    fn jump_unless_less(generator: &mut Generator<'_, Self>, values: [Value; 2]) -> usize {
        generator.jump_unless_less(values)
    }

    fn jump(&mut self) -> usize {
        self.bytes(&[0xe9, 0, 0, 0, 0]);
        self.code.len() - 4
    }

    fn patch(&mut self, at: usize, target: usize) {
        encode::patch(&mut self.code, at, target as i64);
    }

    fn call(
        generator: &mut Generator<'_, Self>,
        helper: Helper,
        pointers: [Address; 3],
        lanes: u8,
    ) {
        generator.call_helper(helper, pointers, lanes);
    }

    fn call_again(generator: &mut Generator<'_, Self>) -> usize {
        generator.call_again()
    }

    fn point_call(code: &mut [u8], at: usize, target: i64) {
        encode::patch(code, at, target);
    }

    fn entry(generator: &Generator<'_, Self>, frame: u32) -> (Self, usize) {
        generator.entry(frame)
    }

    fn leave(generator: &mut Generator<'_, Self>) {
        generator.leave();
    }

    fn point_to_constants(code: &mut [u8], at: usize, constants: usize) {
        encode::patch(code, at, constants as i64 + i64::from(SHORT));
    }
}
