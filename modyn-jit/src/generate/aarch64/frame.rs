//! The frame of a function: the registers that point to memory, entry, calls and return.

use super::encode::{Encoder, SCRATCH, SP, part_of_constant};
use super::opcodes as op;
use crate::generate::architecture::{Address, Architecture as _, Part};
use crate::generate::{Generator, MAX_ARRAYS};
use crate::helper::{Helper, Linkage};

/// The bytes below the memory of the vector registers: the pointers to the table, the results and
/// the constants.
pub(super) const HEADER: u32 = 32;

/// The registers that point to memory: the constants, the results, and the arguments.
const CONSTANTS: u8 = 8;
const RESULTS: u8 = 10;
const ARGUMENTS: [u8; MAX_ARRAYS] = [11, 12, 13, 14, 15, 16, 17, 7];
const FRAME_POINTER: u8 = 29;

/// The pairs of vector registers whose lower halves belong to the caller, by their first registers.
const KEPT: [u8; 4] = [8, 10, 12, 14];

impl Generator<'_, Encoder> {
    /// Returns the base register of an address, and the offset from it.
    pub(super) fn place(&self, Address { part, offset }: Address) -> (u8, u32) {
        match part {
            Part::Constants => (CONSTANTS, offset),
            Part::Argument(array) => (ARGUMENTS[usize::from(array)], offset),
            Part::Results => (RESULTS, offset),
            Part::Saved => (SP, HEADER + offset),
            Part::Slots => (SP, HEADER + self.saved as u32 + offset),
        }
    }

    /// Returns the pairs of registers that the function keeps for its caller.
    fn kept(&self) -> impl DoubleEndedIterator<Item = u8> + use<> {
        let written = self.written;
        KEPT.into_iter().filter(move |register| written >> register & 3 != 0)
    }

    /// Returns the entry of a function, and the position of its distance to the constants.
    pub(super) fn entry(&self, frame: u32) -> (Encoder, usize) {
        let mut entry = Encoder::default();
        // stp x29, x30, [sp, -16]!; mov x29, sp
        entry.word(0xa9bf_7bfd);
        entry.word(0x9100_03fd);
        for register in self.kept() {
            // stp d, d + 1, [sp, -16]!
            entry.two(0x6dbf_0000 | (u32::from(register) + 1) << 10, [register, SP]);
        }
        allocate(&mut entry, frame);
        entry.store_pointer(0, SP, 0);
        entry.store_pointer(1, SP, 1);
        // adr x8, .
        entry.word(0x1000_0000 | u32::from(CONSTANTS));
        let constants_at = entry.position();
        entry.word(part_of_constant(SCRATCH, 0, 0));
        entry.word(part_of_constant(SCRATCH, 0, 1));
        // add x8, x8, x9
        entry.three(0x8b00_0000, [CONSTANTS, CONSTANTS, SCRATCH]);
        entry.store_pointer(CONSTANTS, SP, 2);
        point(&mut entry, self.arrays);
        (entry, constants_at)
    }

    /// Writes a call of a helper, and restores the registers that point to memory.
    pub(super) fn call_helper(&mut self, helper: Helper, pointers: [Address; 3], lanes: u8) {
        for (register, pointer) in (0..).zip(pointers) {
            let (base, offset) = self.place(pointer);
            self.encoder.address(register, base, offset);
        }
        self.encoder.constant(3, lanes.into());
        match self.linkage {
            Linkage::Addresses(helpers) => {
                // All parts, so that the length of code does not depend on addresses.
                for part in 0..4 {
                    let word = part_of_constant(SCRATCH, helpers.address(helper), part);
                    self.encoder.word(word);
                }
                self.encoder.two(op::CALL_REGISTER, [0, SCRATCH]);
            }
            Linkage::Relative => {
                self.calls.push((self.encoder.position(), helper));
                self.encoder.word(op::CALL);
            }
        }
        point(&mut self.encoder, self.arrays);
    }

    /// Writes a call of another function with this one's arguments and results, and returns its
    /// position.
    pub(super) fn call_again(&mut self) -> usize {
        self.encoder.load_pointer(0, SP, 0);
        self.encoder.load_pointer(1, SP, 1);
        self.encoder.word(op::CALL);
        self.encoder.position() - 4
    }

    /// Writes the return.
    pub(super) fn leave(&mut self) {
        // sub sp, x29, 16 for each pair
        let pairs = self.kept().count() as u32;
        self.encoder.two(0xd100_0000 | (16 * pairs) << 10, [SP, FRAME_POINTER]);
        for register in self.kept().rev() {
            // ldp d, d + 1, [sp], 16
            self.encoder.two(0x6cc1_0000 | (u32::from(register) + 1) << 10, [register, SP]);
        }
        // ldp x29, x30, [sp], 16
        self.encoder.word(0xa8c1_7bfd);
        self.encoder.word(op::RETURN);
    }
}

/// Moves the stack pointer down. The code touches each page, so that an overflow is found at the
/// guard page.
fn allocate(entry: &mut Encoder, frame: u32) {
    const PAGE: u32 = 4096;
    let pages = frame / PAGE;
    if pages > 0 {
        entry.constant(SCRATCH, pages.into());
        // sub sp, sp, 4096; str xzr, [sp]; subs x9, x9, 1; b.ne
        for word in [0xd140_07ff, 0xf900_03ff, 0xf100_0529, 0x54ff_ffa1] {
            entry.word(word);
        }
    }
    // sub sp, sp, rest
    entry.two(0xd100_0000 | (frame % PAGE) << 10, [SP, SP]);
}

/// Loads the pointers to the constants, the results and the arguments.
fn point(encoder: &mut Encoder, arrays: usize) {
    encoder.load_pointer(SCRATCH, SP, 0);
    encoder.load_pointer(RESULTS, SP, 1);
    encoder.load_pointer(CONSTANTS, SP, 2);
    for (&register, number) in ARGUMENTS.iter().zip(0..arrays as u32) {
        encoder.load_pointer(register, SCRATCH, number);
    }
}

/// Fills in the distance from the entry to the constants.
pub(super) fn point_to_constants(code: &mut [u8], at: usize, constants: usize) {
    // `adr` is the instruction before.
    let distance = (constants - (at - 4)) as u64;
    for (part, word) in (0..2).zip(code[at..at + 8].chunks_exact_mut(4)) {
        word.copy_from_slice(&part_of_constant(SCRATCH, distance, part).to_le_bytes());
    }
}
