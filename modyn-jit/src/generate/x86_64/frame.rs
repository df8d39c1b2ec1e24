//! The frame of a function: the registers that point to memory, entry and return.

use super::Encoder;
use super::encode::RSP;
use crate::generate::{Generator, MAX_ARRAYS};
use crate::instruction_set::InstructionSet;

/// The registers that point to the arguments; the last two belong to the caller.
pub(super) const BASES: [u8; MAX_ARRAYS] = [7, 6, 2, 8, 9, 10, 14, 15];
pub(super) const RAX: u8 = 0;
pub(super) const RCX: u8 = 1;
pub(super) const RDX: u8 = 2;
pub(super) const RBX: u8 = 3;
pub(super) const RSI: u8 = 6;
pub(super) const RDI: u8 = 7;
pub(super) const R11: u8 = 11;

/// The instructions that keep the registers of the caller: push rbp; mov rbp, rsp; push rbx.
/// Descriptions of the frame for debuggers (`object/unwind.rs`) follow them.
pub(crate) const PROLOGUE: [&[u8]; 3] = [&[0x55], &[0x48, 0x89, 0xe5], &[0x53]];

/// The instructions after [`PROLOGUE`] of a function that [uses the last bases](keeps_bases): push
/// r14; push r15.
pub(crate) const KEEP_BASES: [&[u8]; 2] = [&[0x41, 0x56], &[0x41, 0x57]];

/// The bytes below the memory of the vector registers: the two pointers.
pub(super) const HEADER: usize = 64;

/// The range of displacements of one byte, on both sides.
pub(super) const SHORT: i32 = 128;

/// Returns whether a function with this number of arrays of arguments keeps r14 and r15 for its
/// caller.
pub(crate) const fn keeps_bases(arrays: usize) -> bool {
    arrays > MAX_ARRAYS - KEEP_BASES.len()
}

impl Generator<'_, Encoder> {
    /// Returns the offset from rax.
    pub(super) fn frame_base(&self) -> i32 {
        HEADER as i32 + self.saved as i32 + SHORT
    }

    /// Returns the entry of a function, and the position of its distance to the constants.
    pub(super) fn entry(&self, frame: u32) -> (Encoder, usize) {
        let mut entry = Encoder::default();
        let kept = if keeps_bases(self.arrays) { &KEEP_BASES[..] } else { &[] };
        for bytes in PROLOGUE.iter().chain(kept) {
            entry.bytes(bytes);
        }
        // and rsp, -64
        entry.bytes(&[0x48, 0x83, 0xe4, 0xc0]);
        allocate(&mut entry, frame);
        entry.general(0x89, RDI, RSP, 0);
        entry.general(0x89, RSI, RSP, 8);
        // lea rbx, [rip + constants + 128]
        entry.bytes(&[0x48, 0x8d, 0x1d, 0, 0, 0, 0]);
        let constants_at = entry.code.len() - 4;
        point(&mut entry, self.arrays, self.frame_base());
        (entry, constants_at)
    }

    /// Writes the return.
    pub(super) fn leave(&mut self) {
        if self.instruction_set != InstructionSet::Sse2 {
            // vzeroupper
            self.encoder.bytes(&[0xc5, 0xf8, 0x77]);
        }
        // lea rsp, [rbp - 8]; pop rbx; pop rbp; ret. With r14 and r15: lea rsp, [rbp - 24]; pop
        // r15; pop r14; pop rbx; ...
        let restore: &[&[u8]] = match keeps_bases(self.arrays) {
            false => &[&[0x48, 0x8d, 0x65, 0xf8]],
            true => &[&[0x48, 0x8d, 0x65, 0xe8], &[0x41, 0x5f], &[0x41, 0x5e]],
        };
        for bytes in restore.iter().chain(&[&[0x5b][..], &[0x5d], &[0xc3]]) {
            self.encoder.bytes(bytes);
        }
    }
}

/// Moves the stack pointer down. The code touches each page, so that an overflow is found at the
/// guard page.
pub(crate) fn allocate(entry: &mut Encoder, frame: u32) {
    const PAGE: u32 = 4096;
    let pages = frame / PAGE;
    if pages > 0 {
        // mov r11d, pages
        entry.bytes(&[&[0x41, 0xbb][..], &pages.to_le_bytes()].concat());
        let start = entry.code.len();
        // sub rsp, 4096; or dword [rsp], 0; dec r11d; jne
        entry.bytes(&[0x48, 0x81, 0xec, 0, 0x10, 0, 0]);
        entry.bytes(&[0x83, 0x0c, 0x24, 0]);
        entry.bytes(&[0x41, 0xff, 0xcb]);
        let distance = start as i64 - (entry.code.len() as i64 + 2);
        entry.bytes(&[0x75, (distance as i8).cast_unsigned()]);
    }
    // sub rsp, rest
    entry.bytes(&[&[0x48, 0x81, 0xec][..], &(frame % PAGE).to_le_bytes()].concat());
}

/// Loads the pointers to the frame, the results and the arguments.
pub(super) fn point(encoder: &mut Encoder, arrays: usize, frame_base: i32) {
    encoder.general(0x8b, R11, RSP, 0);
    encoder.general(0x8b, RCX, RSP, 8);
    encoder.general(0x8d, RAX, RSP, frame_base);
    for (&register, k) in BASES.iter().zip(0..arrays as i32) {
        encoder.general(0x8b, register, R11, 8 * k);
    }
}
