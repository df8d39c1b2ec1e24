//! Encodes instructions: words of four bytes. Registers have numbers: 0 is x0 or v0.

use super::opcodes::OR;

/// The stack pointer, as a base.
pub(super) const SP: u8 = 31;
/// The destination of instructions that only set flags.
pub(super) const NO_REGISTER: u8 = 31;
/// The general register that addresses and constants are computed in.
pub(super) const SCRATCH: u8 = 9;

/// The direction of an access to memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Load,
    Store,
}

/// Machine code that is being written.
#[derive(Debug, Default)]
pub(crate) struct Encoder {
    pub words: Vec<u32>,
}

impl Encoder {
    /// Appends an instruction.
    pub fn word(&mut self, word: u32) {
        self.words.push(word);
    }

    /// Appends an instruction with a destination and a source.
    pub fn two(&mut self, opcode: u32, [to, n]: [u8; 2]) {
        self.word(opcode | u32::from(n) << 5 | u32::from(to));
    }

    /// Appends an instruction with a destination and two sources.
    pub fn three(&mut self, opcode: u32, [to, n, m]: [u8; 3]) {
        self.two(opcode | u32::from(m) << 16, [to, n]);
    }

    /// Appends an instruction with a destination and three sources, of which the last is added.
    pub fn four(&mut self, opcode: u32, [to, n, m, a]: [u8; 4]) {
        self.three(opcode | u32::from(a) << 10, [to, n, m]);
    }

    /// Appends a copy of a vector register.
    pub fn copy(&mut self, to: u8, from: u8) {
        self.three(OR, [to, from, from]);
    }

    /// Appends a load or store of 4, 8 or 16 bytes of a vector register.
    pub fn memory(&mut self, access: Access, bytes: usize, register: u8, base: u8, offset: u32) {
        let store_opcode = match bytes {
            4 => 0xbd00_0000,
            8 => 0xfd00_0000,
            _ => 0x3d80_0000,
        };
        let opcode = store_opcode | u32::from(access == Access::Load) << 22;
        let unscaled = opcode - (1 << 24);
        let units = offset / bytes as u32;
        if offset.is_multiple_of(bytes as u32) && units < 1 << 12 {
            self.two(opcode | units << 10, [register, base]);
        } else if offset < 1 << 8 {
            self.two(unscaled | offset << 12, [register, base]);
        } else {
            self.constant(SCRATCH, offset.into());
            self.three(unscaled | 0x0020_6800, [register, base, SCRATCH]);
        }
    }

    /// Appends the computation of an address.
    pub fn address(&mut self, register: u8, base: u8, offset: u32) {
        if offset < 1 << 12 {
            self.two(0x9100_0000 | offset << 10, [register, base]);
        } else {
            self.constant(SCRATCH, offset.into());
            self.three(0x8b20_6000, [register, base, SCRATCH]);
        }
    }

    /// Appends the load of a constant into a general register.
    pub fn constant(&mut self, register: u8, value: u64) {
        self.word(part_of_constant(register, value, 0));
        for part in (1..4).filter(|part| value >> (16 * part) & 0xffff != 0) {
            self.word(part_of_constant(register, value, part));
        }
    }

    /// Appends the load of a general register from 8 bytes at this multiple of 8.
    pub fn load_pointer(&mut self, register: u8, base: u8, number: u32) {
        self.two(0xf940_0000 | number << 10, [register, base]);
    }

    /// Appends the store of a general register to 8 bytes at this multiple of 8.
    pub fn store_pointer(&mut self, register: u8, base: u8, number: u32) {
        self.two(0xf900_0000 | number << 10, [register, base]);
    }
}

/// Returns the instruction that sets 16 bits of a general register. The first part, 0, also clears
/// the others.
pub(super) fn part_of_constant(register: u8, value: u64, part: u32) -> u32 {
    let opcode = if part == 0 { 0xd280_0000 } else { 0xf280_0000 };
    let bits = (value >> (16 * part)) as u32 & 0xffff;
    opcode | part << 21 | bits << 5 | u32::from(register)
}

/// Returns a jump or a call at one position to another one.
pub(super) fn jump(opcode: u32, at: usize, target: i64) -> u32 {
    let words = (target - at as i64) / 4;
    assert!(words.unsigned_abs() < 1 << 25, "code is shorter than 128 MiB");
    opcode | words as u32 & 0x03ff_ffff
}
