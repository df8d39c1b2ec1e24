//! aarch64 with NEON.
//!
//! A function has two arguments: a pointer to a table of pointers to its arguments (x0), and a
//! pointer to its results (x1). It follows the procedure call standard for the Arm 64-bit
//! architecture (AAPCS64). Registers in its body: x8 points to the constants, x10 to the results,
//! x11 to x17 and x7 to the arguments, sp to the stack frame; x9 is free; x29 is the frame pointer,
//! as profilers know it: it points to the caller's. x18, which belongs to some systems, is not
//! used.
//!
//! The frame, upwards from sp, which is a multiple of 16: the pointers to the table, the results
//! and the constants, memory for all vector registers during calls, slots of values. Above it are
//! the lower halves of v8 to v15, which belong to the caller, as far as the function writes these
//! registers.
//!
//! Operands are in registers: instructions read no memory. They overwrite none of their operands,
//! except the fused products of vectors, which add to their destination.

mod arithmetic;
mod encode;
mod frame;
pub(crate) mod opcodes;

use super::Generator;
use super::architecture::{Address, Architecture};
use crate::helper::Helper;
use crate::values::{Operation, Value};
use frame::HEADER;

pub(crate) use encode::{Access, Encoder};

impl Architecture for Encoder {
    const HEADER: usize = HEADER as usize;
    const ALIGNMENT: usize = 16;

    fn position(&self) -> usize {
        4 * self.words.len()
    }

    fn instructions(&self) -> usize {
        self.words.len()
    }

    fn finish(self) -> Vec<u8> {
        self.words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    fn load(generator: &mut Generator<'_, Self>, register: u8, bytes: usize, from: Address) {
        let (base, offset) = generator.place(from);
        generator.encoder.memory(Access::Load, bytes, register, base, offset);
    }

    fn store(generator: &mut Generator<'_, Self>, register: u8, bytes: usize, to: Address) {
        let (base, offset) = generator.place(to);
        generator.encoder.memory(Access::Store, bytes, register, base, offset);
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
        let at = self.position();
        self.word(opcodes::JUMP);
        at
    }

    fn patch(&mut self, at: usize, target: usize) {
        self.words[at / 4] = encode::jump(opcodes::JUMP, at, target as i64);
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
        let call = encode::jump(opcodes::CALL, at, target);
        code[at..at + 4].copy_from_slice(&call.to_le_bytes());
    }

    fn entry(generator: &Generator<'_, Self>, frame: u32) -> (Self, usize) {
        generator.entry(frame)
    }

    fn leave(generator: &mut Generator<'_, Self>) {
        generator.leave();
    }

    fn point_to_constants(code: &mut [u8], at: usize, constants: usize) {
        frame::point_to_constants(code, at, constants);
    }
}
