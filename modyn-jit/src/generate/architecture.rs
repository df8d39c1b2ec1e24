//! The part of code generation that each architecture writes: its instructions, registers that
//! point to memory, entry and return.

use super::Generator;
use crate::helper::Helper;
use crate::values::{Operation, Value};

/// A part of the memory that a function reads or writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// The constants.
    Constants,
    /// The argument with this number.
    Argument(u8),
    /// The results.
    Results,
    /// The slots of values in the stack frame.
    Slots,
    /// The memory of all vector registers in the stack frame, for calls.
    Saved,
}

/// An address: a part, and the offset in bytes from its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Address {
    pub part: Part,
    pub offset: u32,
}

/// The writer of one architecture's instructions. Positions and targets are offsets in its code.
pub(super) trait Architecture: Default {
    /// The bytes of the stack frame below the memory of the vector registers.
    const HEADER: usize;
    /// The frame's size is a multiple of this.
    const ALIGNMENT: usize;

    /// Returns the length of the code.
    fn position(&self) -> usize;

    /// Returns the number of instructions.
    fn instructions(&self) -> usize;

    /// Returns the code.
    fn finish(self) -> Vec<u8>;

    /// Writes a load of this number of bytes.
    fn load(generator: &mut Generator<'_, Self>, register: u8, bytes: usize, from: Address);

    /// Writes a store of this number of bytes.
    fn store(generator: &mut Generator<'_, Self>, register: u8, bytes: usize, to: Address);

    /// Writes an operation that is no call, and returns the register of its result. Operands that
    /// are read for the last time may be overwritten; pinned registers otherwise keep their values.
    fn operation(
        generator: &mut Generator<'_, Self>,
        operation: Operation,
        value: Value,
        pinned: u32,
    ) -> u8;

    /// Writes a jump that is taken unless all lanes of the first value are less than the lanes of
    /// the second value. Returns the position to [`patch`](Self::patch).
    fn jump_unless_less(generator: &mut Generator<'_, Self>, values: [Value; 2]) -> usize;

    /// Writes a jump, and returns the position to [`patch`](Self::patch).
    fn jump(&mut self) -> usize;

    /// Fills in the target of a jump.
    fn patch(&mut self, at: usize, target: usize);

    /// Writes a call of a helper with pointers to its results and arguments, and restores the
    /// registers that point to memory.
    fn call(generator: &mut Generator<'_, Self>, helper: Helper, pointers: [Address; 3], lanes: u8);

    /// Writes a call of another function with this one's arguments and results, and returns its
    /// position.
    fn call_again(generator: &mut Generator<'_, Self>) -> usize;

    /// Fills in the target of the call at this position of a function's code: the distance from the
    /// function's start.
    fn point_call(code: &mut [u8], at: usize, target: i64);

    /// Returns the entry of a function with a stack frame of this size, and the position of its
    /// distance to the constants.
    fn entry(generator: &Generator<'_, Self>, frame: u32) -> (Self, usize);

    /// Writes the return.
    fn leave(generator: &mut Generator<'_, Self>);

    /// Fills in the distance from the entry to the constants at this position of a function's code.
    fn point_to_constants(code: &mut [u8], at: usize, constants: usize);
}
