//! The instructions for both precisions.

use super::encode::Opcode;
use crate::values::Negated;

const fn both(map: u8, prefix: u8, byte: u8, evex_w: bool) -> Opcode {
    Opcode { map, prefix, byte, vex_w: false, evex_w }
}

/// Returns an instruction on scalars (ss, sd) or on vectors (ps, pd) of numbers with this size in
/// bytes; they differ only in the mandatory prefix.
pub(crate) const fn arithmetic(byte: u8, scalar: bool, size: usize) -> Opcode {
    let prefix = match (scalar, size) {
        (true, 8) => 3,
        (true, _) => 2,
        (false, 8) => 1,
        (false, _) => 0,
    };
    both(1, prefix, byte, size == 8)
}

pub(crate) const ADD: u8 = 0x58;
pub(crate) const MULTIPLY: u8 = 0x59;
pub(crate) const SUBTRACT: u8 = 0x5c;
pub(crate) const DIVIDE: u8 = 0x5e;
pub(crate) const MAXIMUM: u8 = 0x5f;
pub(crate) const SQUARE_ROOT: u8 = 0x51;
pub(crate) const AND: u8 = 0x54;
pub(crate) const AND_NOT: u8 = 0x55;
pub(crate) const OR: u8 = 0x56;
pub(crate) const XOR: u8 = 0x57;
pub(crate) const COMPARE: u8 = 0xc2;
pub(crate) const LOAD: u8 = 0x10;
pub(crate) const STORE: u8 = 0x11;
/// A copy between registers.
pub(crate) const COPY: u8 = 0x28;
/// The lower numbers of two vectors, interleaved.
pub(crate) const UNPACK_LOW: u8 = 0x14;
/// The signs of a vector as bits of a general register.
pub(crate) const SIGNS: u8 = 0x50;
/// An ordered comparison of two scalars that sets flags.
pub(crate) const COMPARE_FLAGS: u8 = 0x2f;

/// A fused multiply-add; `form` is 0x90, 0xA0 or 0xB0 for the orders 132, 213 and 231.
pub(crate) const fn multiply_add(form: u8, negated: Negated, scalar: bool, size: usize) -> Opcode {
    let kind = match (negated.product, negated.addend) {
        (false, false) => 8,
        (false, true) => 0xa,
        (true, false) => 0xc,
        (true, true) => 0xe,
    };
    let wide = size == 8;
    Opcode { map: 2, prefix: 1, byte: form + kind + scalar as u8, vex_w: wide, evex_w: wide }
}

/// A shift to the left by an immediate; the opcode's extension is 6.
pub(crate) const fn shift_left(size: usize) -> Opcode {
    both(1, 1, if size == 8 { 0x73 } else { 0x72 }, size == 8)
}

/// The first number of a vector in both halves of 16 bytes.
pub(crate) const DUPLICATE: Opcode = both(1, 3, 0x12, true);

/// The first number of a vector in all lanes, AVX2.
pub(crate) const fn broadcast(size: usize) -> Opcode {
    both(2, 1, if size == 8 { 0x19 } else { 0x18 }, size == 8)
}

/// The lanes of two vectors by an immediate, numbers of 4 bytes.
pub(crate) const SHUFFLE_SINGLE: Opcode = both(1, 0, 0xc6, false);

/// The lower 8 bytes of two vectors of 16.
pub(crate) const UNPACK_LOW_DOUBLE: Opcode = both(1, 1, UNPACK_LOW, true);

/// A scalar of 8 bytes from memory as the upper half of 16.
pub(crate) const LOAD_HIGH: Opcode = both(1, 1, 0x16, true);

/// A load or store of 8 bytes; the rest of the register becomes zero.
pub(crate) const fn scalar_double(byte: u8) -> Opcode {
    both(1, 3, byte, true)
}

/// 16 bytes as the upper half of 32.
pub(crate) const INSERT_128: Opcode = both(3, 1, 0x18, false);

/// 32 bytes as the upper half of 64.
pub(crate) const INSERT_256: Opcode = both(3, 1, 0x1a, true);

/// A comparison's mask as a vector, AVX512DQ.
pub(crate) const fn mask_to_vector(size: usize) -> Opcode {
    both(2, 2, 0x38, size == 8)
}
