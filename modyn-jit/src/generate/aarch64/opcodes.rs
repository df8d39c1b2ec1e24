//! The instructions: words with zeros for the operands.
//!
//! Arm Architecture Reference Manual for A-profile architecture, chapters C6 and C7.

use crate::values::Negated;

/// An instruction on numbers, by its words for single precision: on scalars, and on vectors of 16
/// bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arithmetic {
    scalar: u32,
    vector: u32,
}

impl Arithmetic {
    /// Returns the instruction on scalars or vectors of numbers with this size in bytes.
    pub const fn of(self, scalar: bool, size: usize) -> u32 {
        let word = if scalar { self.scalar } else { self.vector };
        word | ((size == 8) as u32) << 22
    }
}

pub(crate) const ADD: Arithmetic = Arithmetic { scalar: 0x1e20_2800, vector: 0x4e20_d400 };
pub(crate) const SUBTRACT: Arithmetic = Arithmetic { scalar: 0x1e20_3800, vector: 0x4ea0_d400 };
pub(crate) const MULTIPLY: Arithmetic = Arithmetic { scalar: 0x1e20_0800, vector: 0x6e20_dc00 };
pub(crate) const DIVIDE: Arithmetic = Arithmetic { scalar: 0x1e20_1800, vector: 0x6e20_fc00 };
pub(crate) const SQUARE_ROOT: Arithmetic = Arithmetic { scalar: 0x1e21_c000, vector: 0x6ea1_f800 };
pub(crate) const NEGATE: Arithmetic = Arithmetic { scalar: 0x1e21_4000, vector: 0x6ea0_f800 };

/// Comparisons, whose results have all bits or none.
pub(crate) const EQUAL: Arithmetic = Arithmetic { scalar: 0x5e20_e400, vector: 0x4e20_e400 };
pub(crate) const GREATER_OR_EQUAL: Arithmetic =
    Arithmetic { scalar: 0x7e20_e400, vector: 0x6e20_e400 };
pub(crate) const GREATER: Arithmetic = Arithmetic { scalar: 0x7ea0_e400, vector: 0x6ea0_e400 };

/// Returns the comparison of scalars that sets flags.
pub(crate) const fn compare_flags(size: usize) -> u32 {
    0x1e20_2000 | ((size == 8) as u32) << 22
}

/// Returns the fused product of scalars with a fourth operand: (-) n m (+ or -) a.
pub(crate) const fn multiply_add(negated: Negated, size: usize) -> u32 {
    let word = match (negated.product, negated.addend) {
        (false, false) => 0x1f00_0000,
        (true, false) => 0x1f00_8000,
        (true, true) => 0x1f20_0000,
        (false, true) => 0x1f20_8000,
    };
    word | ((size == 8) as u32) << 22
}

/// Returns the fused product of vectors that is added to the destination, or subtracted from it.
pub(crate) const fn accumulate(negative: bool, size: usize) -> u32 {
    (if negative { 0x4ea0_cc00 } else { 0x4e20_cc00 }) | ((size == 8) as u32) << 22
}

/// Operations on 16 bytes.
pub(crate) const AND: u32 = 0x4e20_1c00;
/// The bits of the first source that are not in the second.
pub(crate) const CLEAR: u32 = 0x4e60_1c00;
pub(crate) const OR: u32 = 0x4ea0_1c00;
pub(crate) const XOR: u32 = 0x6e20_1c00;
pub(crate) const NOT: u32 = 0x6e20_5800;
/// The bits of the first source where the destination has bits, else the bits of the second source.
pub(crate) const SELECT: u32 = 0x6e60_1c00;

/// Returns the shift of the lowest bit to the sign.
pub(crate) const fn shift_to_sign(size: usize) -> u32 {
    0x4f00_5400 | (16 * size as u32 - 1) << 16
}

/// Returns the first number in all lanes.
pub(crate) const fn broadcast(size: usize) -> u32 {
    0x4e00_0400 | (size as u32) << 16
}

/// Returns the first parts of two vectors, which have this number of bytes, one after the other.
pub(crate) const fn join(part: usize) -> u32 {
    if part == 8 { 0x4ec0_3800 } else { 0x4e80_3800 }
}

/// The smallest of four unsigned numbers of 4 bytes.
pub(crate) const MINIMUM_ACROSS: u32 = 0x6eb1_a800;
/// A copy of 4 bytes from a vector register to a general register.
pub(crate) const TO_GENERAL: u32 = 0x1e26_0000;
/// A comparison of 4 bytes of a general register with -1 that sets flags.
pub(crate) const COMPARE_WITH_ALL_BITS: u32 = 0x3100_0400;

pub(crate) const JUMP: u32 = 0x1400_0000;
/// A jump over one instruction if the flags say "equal", or "less" for numbers.
pub(crate) const SKIP_IF_EQUAL: u32 = 0x5400_0040;
pub(crate) const SKIP_IF_LESS: u32 = 0x5400_0044;
pub(crate) const CALL: u32 = 0x9400_0000;
pub(crate) const CALL_REGISTER: u32 = 0xd63f_0000;
pub(crate) const RETURN: u32 = 0xd65f_03c0;
