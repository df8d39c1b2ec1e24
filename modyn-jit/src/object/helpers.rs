//! The functions that machine code calls, as machine code: the reduction of large angles,
//! arctangents and logarithms; and the function that asks the processor for its instructions.
//!
//! They do the operations of the runtime's functions (`scalar/trig.rs` and `float/elementary.rs`)
//! in the same order, so they have the same bits, which `tests/object.rs` compares. Each takes
//! pointers to its results and arguments, and a number of lanes; see `helper.rs`. They use SSE2
//! only, no stack, and none of the registers that belong to their caller.
//!
//! The reduction of large angles exists in Rust, C, WGSL and here: it needs wide integers, which a
//! `Program` does not have, and an object file must not need a C compiler.

use modyn_runtime::{
    ELEMENTARY_F32, ELEMENTARY_F64, ElementaryNumbers, FRAC_1_PI_BITS, PI_BITS, trig_steps,
};

use super::assembler::{
    ADD, ADDRESS, Assembler, COMPARE, Condition, FROM_VECTOR, HIGHEST_BIT, IMMEDIATE_ADD,
    IMMEDIATE_ADD_CARRY, IMMEDIATE_AND, IMMEDIATE_COMPARE, IMMEDIATE_SUBTRACT, IMMEDIATE_XOR, LOAD,
    Label, MOVE_IF_BELOW, MULTIPLY, MULTIPLY_WIDE, NEGATE, OR, Opcode, Operand, R8, R9, R10, R11,
    RAX, RBX, RCX, RDI, RDX, RSI, SHIFT_IN_BY_CL, SHIFT_LEFT, SHIFT_RIGHT, SHIFT_RIGHT_SIGNED,
    STORE, SUBTRACT, TEST, TO_VECTOR, XOR,
};
use crate::helper::Helper;
use crate::instruction_set::InstructionSet;
use crate::real::Real;
use Operand::{Memory, Register};

/// Operations on the scalars of vector registers, by their opcodes.
const FLOAT_LOAD: u8 = 0x10;
const FLOAT_ADD: u8 = 0x58;
const FLOAT_MULTIPLY: u8 = 0x59;
const FLOAT_SUBTRACT: u8 = 0x5c;
const FLOAT_MINIMUM: u8 = 0x5d;
const FLOAT_DIVIDE: u8 = 0x5e;
const FLOAT_MAXIMUM: u8 = 0x5f;
/// A signed integer in a general register as a floating-point number.
const FLOAT_FROM_INTEGER: u8 = 0x2a;

/// Appends a helper, and returns its label.
pub(super) fn helper<S: Real>(assembler: &mut Assembler, helper: Helper) -> Label {
    assembler.align(16);
    let start = assembler.label_at(assembler.code.len());
    let mut function = Function::<S>::new(assembler);
    match helper {
        Helper::Reduce => function.reduce(),
        Helper::Atan2 if function.wide => function.atan2(&ELEMENTARY_F64),
        Helper::Atan2 => function.atan2(&ELEMENTARY_F32),
        Helper::Logarithm if function.wide => function.logarithm(&ELEMENTARY_F64),
        Helper::Logarithm => function.logarithm(&ELEMENTARY_F32),
    }
    function.finish();
    start
}

/// A function that is being written, with its constants.
struct Function<'a, S> {
    a: &'a mut Assembler,
    /// Whether numbers have 64 bits.
    wide: bool,
    /// The bits of the mantissa without its first one, and the number of bits.
    mantissa: u8,
    bits: u8,
    pool: Label,
    constants: Vec<S>,
}

impl<'a, S: Real> Function<'a, S> {
    fn new(a: &'a mut Assembler) -> Self {
        let wide = size_of::<S>() == 8;
        let (mantissa, bits) = if wide { (52, 64) } else { (23, 32) };
        let pool = a.label();
        Self { a, wide, mantissa, bits, pool, constants: Vec::new() }
    }

    /// Appends the constants.
    fn finish(self) {
        self.a.align(8);
        self.a.bind(self.pool);
        for constant in self.constants {
            let bits = constant.bits().to_le_bytes();
            self.a.bytes(&bits[..size_of::<S>()]);
        }
    }

    /// Returns a constant in memory.
    fn constant(&mut self, value: S) -> Operand {
        self.constants.push(value);
        let offset = (self.constants.len() - 1) * size_of::<S>();
        Operand::Code(self.pool, offset as i32)
    }

    fn number(&mut self, value: f64) -> Operand {
        self.constant(S::from_f64(value))
    }

    /// Appends an operation on scalars.
    fn float(&mut self, opcode: u8, register: u8, operand: Operand) {
        let prefix = if self.wide { 0xf2 } else { 0xf3 };
        let bytes: &[u8] = match opcode {
            FLOAT_LOAD => &[0x0f, FLOAT_LOAD],
            FLOAT_ADD => &[0x0f, FLOAT_ADD],
            FLOAT_MULTIPLY => &[0x0f, FLOAT_MULTIPLY],
            FLOAT_SUBTRACT => &[0x0f, FLOAT_SUBTRACT],
            FLOAT_MINIMUM => &[0x0f, FLOAT_MINIMUM],
            FLOAT_DIVIDE => &[0x0f, FLOAT_DIVIDE],
            FLOAT_MAXIMUM => &[0x0f, FLOAT_MAXIMUM],
            _ => unreachable!("no operation on scalars"),
        };
        self.a.instruction(Opcode(Some(prefix), bytes), false, register, operand);
    }

    /// Appends a copy between vector registers.
    fn float_copy(&mut self, to: u8, from: u8) {
        self.a.instruction(Opcode(None, &[0x0f, 0x28]), false, to, Register(from));
    }

    /// Appends a comparison of scalars that sets flags as one of unsigned integers does.
    fn float_compare(&mut self, register: u8, operand: Operand) {
        let prefix = self.wide.then_some(0x66);
        self.a.instruction(Opcode(prefix, &[0x0f, 0x2e]), false, register, operand);
    }

    /// Appends the conversion of a signed integer.
    fn integer_as_number(&mut self, register: u8, from: u8, wide: bool) {
        let prefix = if self.wide { 0xf2 } else { 0xf3 };
        let opcode = Opcode(Some(prefix), &[0x0f, FLOAT_FROM_INTEGER]);
        self.a.instruction(opcode, wide, register, Register(from));
    }

    /// Appends a move of a number's bits to a general register.
    fn bits_of(&mut self, to: u8, vector: u8) {
        self.a.instruction(FROM_VECTOR, self.wide, vector, Register(to));
    }

    /// Appends a move of a number's bits to a vector register.
    fn number_of(&mut self, vector: u8, from: u8) {
        self.a.instruction(TO_VECTOR, self.wide, vector, Register(from));
    }

    /// Appends the removal of a number's highest bits.
    fn remove_highest(&mut self, register: u8, count: u8) {
        self.a.shift(SHIFT_LEFT, self.wide, register, count);
        self.a.shift(SHIFT_RIGHT, self.wide, register, count);
    }

    /// Returns the two parts of a constant in memory.
    fn sum(&mut self, parts: (f64, f64)) -> [Operand; 2] {
        <[f64; 2]>::from(parts).map(|part| self.number(part))
    }

    /// Appends c0 + z (c1 + z (...)) to `register`. A coefficient is a numerator and a denominator.
    fn series(&mut self, register: u8, z: u8, coefficients: &[(f64, f64)]) {
        for (i, &(over, under)) in coefficients.iter().rev().enumerate() {
            let coefficient = self.constant(S::from_f64(over) / S::from_f64(under));
            if i == 0 {
                self.float(FLOAT_LOAD, register, coefficient);
            } else {
                self.float(FLOAT_MULTIPLY, register, Register(z));
                self.float(FLOAT_ADD, register, coefficient);
            }
        }
    }

    /// Appends the end of a loop over lanes, whose pointers are in these registers, and the return.
    fn next_lane(&mut self, pointers: &[u8], start: Label) {
        let size = size_of::<S>() as i32;
        for &pointer in pointers {
            self.a.immediate(IMMEDIATE_ADD, true, pointer, size);
        }
        self.a.immediate(IMMEDIATE_SUBTRACT, false, RCX, 1);
        self.a.jump_if(Condition::NotEqual, start);
        // ret
        self.a.bytes(&[0xc3]);
    }

    /// The reduction of large angles (rdi: reduced angles, rsi: numbers with the lowest bits of the
    /// multiples, rdx: angles, ecx: lanes). General registers are few: the pointers wait in xmm2,
    /// xmm3 and xmm4, the lanes in xmm5.
    fn reduce(&mut self) {
        let wide = self.wide;
        let mantissa = self.mantissa;
        let bits = self.bits;
        let exponents: u64 = (1 << (bits - 1 - mantissa)) - 1;
        let bias = exponents >> 1;
        let [top, next, store, infinite, positive, small, scaled, words] =
            std::array::from_fn(|_| self.a.label());
        for (vector, register) in [(2, RDI), (3, RSI), (4, RDX), (5, RCX)] {
            self.a.instruction(TO_VECTOR, true, vector, Register(register));
        }
        self.a.bind(top);
        self.a.instruction(FROM_VECTOR, true, 4, Register(RDX));
        self.a.instruction(LOAD, wide, RAX, Memory(RDX, 0));
        self.a.copy(R10, RAX);
        self.remove_highest(RAX, 1);
        // Positive numbers and NaN are in the order of their bits.
        self.a.constant(RCX, trig_steps::limit::<S>().bits());
        self.a.instruction(COMPARE, true, RAX, Register(RCX));
        self.a.jump_if(Condition::Below, next);
        self.a.copy(RCX, RAX);
        self.a.shift(SHIFT_RIGHT, true, RCX, mantissa);
        self.a.immediate(IMMEDIATE_COMPARE, false, RCX, exponents as i32);
        self.a.jump_if(Condition::Equal, infinite);
        // The angle is m 2^e; rax = m, rcx = e + 63: the first bit of 1 / pi that counts.
        self.remove_highest(RAX, bits - mantissa);
        self.a.set_bit(wide, RAX, mantissa);
        let first = bias as i32 + i32::from(mantissa) - 63;
        self.a.immediate(IMMEDIATE_SUBTRACT, false, RCX, first);
        self.a.instruction(LOAD, false, RDX, Register(RCX));
        self.a.shift(SHIFT_RIGHT, false, RDX, 6);
        self.a.shift(SHIFT_LEFT, false, RDX, 3);
        self.a.instruction(ADDRESS, true, R11, Operand::Code(words, 0));
        self.a.instruction(ADD, true, R11, Register(RDX));
        // The product of m with 192 bits of 1 / pi.
        self.a.copy(R9, RAX);
        self.word(RAX, 2);
        self.a.unary(MULTIPLY_WIDE, true, R9);
        self.a.copy(RDI, RAX);
        self.a.copy(RSI, RDX);
        self.word(RAX, 1);
        self.a.unary(MULTIPLY_WIDE, true, R9);
        self.a.instruction(ADD, true, RAX, Register(RSI));
        self.a.immediate(IMMEDIATE_ADD_CARRY, true, RDX, 0);
        self.a.copy(RSI, RAX);
        self.a.copy(R8, RDX);
        self.word(RAX, 0);
        self.a.instruction(MULTIPLY, true, RAX, Register(R9));
        self.a.instruction(ADD, true, RAX, Register(R8));
        // r8 = whether the multiple is odd; rax, rsi = the fraction.
        self.a.copy(R8, RAX);
        self.a.shift(SHIFT_RIGHT, true, R8, 63);
        self.a.shift_in_one(RAX, RSI);
        self.a.shift_in_one(RSI, RDI);
        // A fraction of at least 1/2 is the next multiple minus a remainder; r9 = whether it is.
        self.a.copy(R9, RAX);
        self.a.shift(SHIFT_RIGHT, true, R9, 63);
        self.a.instruction(XOR, true, R8, Register(R9));
        self.a.instruction(TEST, true, R9, Register(R9));
        self.a.jump_if(Condition::Equal, positive);
        self.a.unary(NEGATE, true, RSI);
        self.a.immediate(IMMEDIATE_ADD_CARRY, true, RAX, 0);
        self.a.unary(NEGATE, true, RAX);
        self.a.bind(positive);
        // rcx = the number of leading zeros, at most 62.
        self.a.constant(RCX, 62);
        self.a.instruction(HIGHEST_BIT, true, R11, Register(RAX));
        self.a.jump_if(Condition::Equal, small);
        self.a.immediate(IMMEDIATE_XOR, false, R11, 63);
        self.a.instruction(COMPARE, false, R11, Register(RCX));
        self.a.instruction(MOVE_IF_BELOW, false, RCX, Register(R11));
        self.a.bind(small);
        self.a.instruction(SHIFT_IN_BY_CL, true, RSI, Register(RAX));
        self.a.constant(R11, PI_BITS);
        self.a.unary(MULTIPLY_WIDE, true, R11);
        // rdx = the angle 2^(62 + zeros), unsigned.
        let scale = if wide {
            let small = self.a.label();
            self.a.instruction(TEST, true, RDX, Register(RDX));
            self.a.jump_if(Condition::NotNegative, small);
            // The integer is too large: half of it, with a bit for what is lost.
            self.a.instruction(LOAD, true, RAX, Register(RDX));
            self.a.shift(SHIFT_RIGHT, true, RDX, 1);
            self.a.immediate(IMMEDIATE_AND, false, RAX, 1);
            self.a.instruction(OR, true, RDX, Register(RAX));
            self.integer_as_number(0, RDX, true);
            self.float(FLOAT_ADD, 0, Register(0));
            self.a.jump(scaled);
            self.a.bind(small);
            self.integer_as_number(0, RDX, true);
            bias - 62
        } else {
            // The upper half has more bits than the result.
            self.a.shift(SHIFT_RIGHT, true, RDX, 32);
            self.integer_as_number(0, RDX, true);
            bias - 30
        };
        self.a.bind(scaled);
        self.a.constant(RAX, scale);
        self.a.instruction(SUBTRACT, false, RAX, Register(RCX));
        self.a.shift(SHIFT_LEFT, wide, RAX, mantissa);
        self.number_of(1, RAX);
        self.float(FLOAT_MULTIPLY, 0, Register(1));
        // The sign is the angle's sign, or the opposite.
        self.a.shift(SHIFT_RIGHT, wide, R10, bits - 1);
        self.a.instruction(XOR, true, R10, Register(R9));
        self.a.shift(SHIFT_LEFT, wide, R10, bits - 1);
        self.bits_of(RAX, 0);
        self.a.instruction(XOR, true, RAX, Register(R10));
        self.a.bind(store);
        self.a.instruction(FROM_VECTOR, true, 2, Register(RDI));
        self.a.instruction(FROM_VECTOR, true, 3, Register(RSI));
        self.a.instruction(STORE, wide, RAX, Memory(RDI, 0));
        self.a.instruction(STORE, wide, R8, Memory(RSI, 0));
        self.a.bind(next);
        for vector in [2, 3, 4] {
            self.a.instruction(FROM_VECTOR, true, vector, Register(RAX));
            self.a.immediate(IMMEDIATE_ADD, true, RAX, size_of::<S>() as i32);
            self.a.instruction(TO_VECTOR, true, vector, Register(RAX));
        }
        self.a.instruction(FROM_VECTOR, true, 5, Register(RCX));
        self.a.immediate(IMMEDIATE_SUBTRACT, false, RCX, 1);
        self.a.instruction(TO_VECTOR, true, 5, Register(RCX));
        self.a.jump_if(Condition::NotEqual, top);
        self.a.bytes(&[0xc3]);
        self.a.bind(infinite);
        self.a.constant(RAX, S::from_f64(f64::NAN).bits());
        self.a.instruction(XOR, false, R8, Register(R8));
        self.a.jump(store);
        self.a.align(8);
        self.a.bind(words);
        for word in FRAC_1_PI_BITS {
            self.a.bytes(&word.to_le_bytes());
        }
    }

    /// Appends the load of 64 bits of 1 / pi: `number` words after r11, shifted to the left by the
    /// lowest six bits of cl.
    fn word(&mut self, register: u8, number: i32) {
        self.a.instruction(LOAD, true, register, Memory(R11, 8 * number));
        self.a.instruction(LOAD, true, RDX, Memory(R11, 8 * number + 8));
        self.a.instruction(SHIFT_IN_BY_CL, true, RDX, Register(register));
    }

    /// The angle from the x axis (rdi: results, rsi: y, rdx: x, ecx: lanes).
    fn atan2<const L: usize, const A: usize>(&mut self, numbers: &ElementaryNumbers<L, A>) {
        let wide = self.wide;
        let bits = self.bits;
        let [top, divided, one, near, far, flat, steep, unsigned, nan, store] =
            std::array::from_fn(|_| self.a.label());
        self.a.bind(top);
        self.float(FLOAT_LOAD, 0, Memory(RDX, 0));
        self.float(FLOAT_LOAD, 1, Memory(RSI, 0));
        self.float_compare(0, Register(1));
        self.a.jump_if(Condition::Unordered, nan);
        // r8, r9 = x and y; r10, r11 = their absolute values.
        for (register, absolute, vector, from) in [(R8, R10, 0, RDX), (R9, R11, 1, RSI)] {
            self.a.instruction(LOAD, wide, register, Memory(from, 0));
            self.a.copy(absolute, register);
            self.remove_highest(absolute, 1);
            self.number_of(vector, absolute);
        }
        // xmm2 = t, the smaller absolute value divided by the larger.
        self.float_copy(2, 0);
        self.float(FLOAT_MINIMUM, 2, Register(1));
        self.float_copy(3, 0);
        self.float(FLOAT_MAXIMUM, 3, Register(1));
        let infinity = self.number(f64::INFINITY);
        self.float_compare(2, infinity);
        self.a.jump_if(Condition::Equal, one);
        let zero = self.number(0.0);
        self.float_compare(3, zero);
        self.a.jump_if(Condition::Equal, divided);
        self.float(FLOAT_DIVIDE, 2, Register(3));
        self.a.jump(divided);
        self.a.bind(one);
        let number = self.number(1.0);
        self.float(FLOAT_LOAD, 2, number);
        self.a.bind(divided);
        // xmm4 = u
        let tangent = self.number(numbers.tan_15);
        self.float_copy(4, 2);
        self.float_compare(2, tangent);
        self.a.jump_if(Condition::BelowOrEqual, near);
        let root = self.number(numbers.root_3);
        self.float(FLOAT_MULTIPLY, 4, root);
        let number = self.number(1.0);
        self.float(FLOAT_SUBTRACT, 4, number);
        self.float_copy(5, 2);
        self.float(FLOAT_ADD, 5, root);
        self.float(FLOAT_DIVIDE, 4, Register(5));
        self.a.bind(near);
        // xmm1 = the terms of the series after the first.
        self.float_copy(5, 4);
        self.float(FLOAT_MULTIPLY, 5, Register(4));
        self.series(0, 5, &numbers.arctangent);
        self.float_copy(1, 4);
        self.float(FLOAT_MULTIPLY, 1, Register(5));
        self.float(FLOAT_MULTIPLY, 1, Register(0));
        self.float_compare(2, tangent);
        self.a.jump_if(Condition::BelowOrEqual, far);
        let [pi_6, rest] = self.sum(numbers.sixth_pi);
        self.float(FLOAT_ADD, 1, rest);
        self.float(FLOAT_ADD, 1, Register(4));
        self.float(FLOAT_LOAD, 4, pi_6);
        self.a.bind(far);
        // xmm4 = the angle in the first octant or quadrant.
        self.a.instruction(COMPARE, true, R11, Register(R10));
        self.a.jump_if(Condition::BelowOrEqual, flat);
        let [pi_2, rest] = self.sum(numbers.half_pi);
        self.float(FLOAT_LOAD, 0, rest);
        self.float(FLOAT_SUBTRACT, 0, Register(1));
        self.float(FLOAT_SUBTRACT, 4, Register(0));
        self.float(FLOAT_LOAD, 0, pi_2);
        self.float(FLOAT_SUBTRACT, 0, Register(4));
        self.float_copy(4, 0);
        self.a.jump(steep);
        self.a.bind(flat);
        self.float(FLOAT_ADD, 4, Register(1));
        self.a.bind(steep);
        self.a.instruction(TEST, wide, R8, Register(R8));
        self.a.jump_if(Condition::NotNegative, unsigned);
        let [pi, rest] = self.sum(numbers.pi);
        self.float(FLOAT_SUBTRACT, 4, rest);
        self.float(FLOAT_LOAD, 0, pi);
        self.float(FLOAT_SUBTRACT, 0, Register(4));
        self.float_copy(4, 0);
        self.a.bind(unsigned);
        self.bits_of(RAX, 4);
        self.a.shift(SHIFT_RIGHT, wide, R9, bits - 1);
        self.a.shift(SHIFT_LEFT, wide, R9, bits - 1);
        self.a.instruction(XOR, true, RAX, Register(R9));
        self.a.bind(store);
        self.a.instruction(STORE, wide, RAX, Memory(RDI, 0));
        self.next_lane(&[RDI, RSI, RDX], top);
        self.a.bind(nan);
        self.a.constant(RAX, S::from_f64(f64::NAN).bits());
        self.a.jump(store);
    }

    /// The natural logarithm (rdi: results, rsi: numbers, ecx: lanes).
    fn logarithm<const L: usize, const A: usize>(&mut self, numbers: &ElementaryNumbers<L, A>) {
        let wide = self.wide;
        let mantissa = self.mantissa;
        let bits = self.bits;
        let [top, normal, nan, infinite, store] = std::array::from_fn(|_| self.a.label());
        self.a.bind(top);
        self.a.instruction(LOAD, wide, RAX, Memory(RSI, 0));
        self.float(FLOAT_LOAD, 0, Memory(RSI, 0));
        let zero = self.number(0.0);
        self.float_compare(0, zero);
        self.a.jump_if(Condition::Unordered, nan);
        self.a.jump_if(Condition::Equal, infinite);
        self.a.jump_if(Condition::Below, nan);
        self.a.constant(RDX, S::from_f64(f64::INFINITY).bits());
        self.a.instruction(COMPARE, true, RAX, Register(RDX));
        self.a.jump_if(Condition::Equal, store);
        // r8 = the power of two that subnormal numbers are multiplied by.
        self.a.instruction(XOR, false, R8, Register(R8));
        self.a.constant(RDX, 1 << mantissa);
        self.a.instruction(COMPARE, true, RAX, Register(RDX));
        self.a.jump_if(Condition::AboveOrEqual, normal);
        let two_up = self.number(numbers.two_up);
        self.float(FLOAT_MULTIPLY, 0, two_up);
        self.bits_of(RAX, 0);
        self.a.constant(R8, u64::from(mantissa) + 1);
        self.a.bind(normal);
        // x = m 2^k: xmm1 = k, xmm0 = m - 1
        self.a.constant(R9, numbers.root_half_bits);
        self.a.instruction(SUBTRACT, wide, RAX, Register(R9));
        self.a.copy(R10, RAX);
        self.a.shift(SHIFT_RIGHT_SIGNED, wide, R10, mantissa);
        self.a.instruction(SUBTRACT, false, R10, Register(R8));
        self.integer_as_number(1, R10, false);
        self.remove_highest(RAX, bits - mantissa);
        self.a.instruction(ADD, true, RAX, Register(R9));
        self.number_of(0, RAX);
        let [one, two, half] = [1.0, 2.0, 0.5].map(|x| self.number(x));
        self.float(FLOAT_SUBTRACT, 0, one);
        // xmm3 = s, xmm2 = s^2
        self.float(FLOAT_LOAD, 2, two);
        self.float(FLOAT_ADD, 2, Register(0));
        self.float_copy(3, 0);
        self.float(FLOAT_DIVIDE, 3, Register(2));
        self.float_copy(2, 3);
        self.float(FLOAT_MULTIPLY, 2, Register(3));
        self.series(4, 2, &numbers.logarithm);
        self.float(FLOAT_MULTIPLY, 4, Register(2));
        self.float(FLOAT_LOAD, 5, half);
        self.float(FLOAT_MULTIPLY, 5, Register(0));
        self.float(FLOAT_MULTIPLY, 5, Register(0));
        self.float(FLOAT_ADD, 4, Register(5));
        self.float(FLOAT_MULTIPLY, 4, Register(3));
        let [ln_2, rest] = self.sum(numbers.ln_2);
        self.float_copy(2, 1);
        self.float(FLOAT_MULTIPLY, 2, rest);
        self.float(FLOAT_ADD, 4, Register(2));
        self.float(FLOAT_SUBTRACT, 4, Register(5));
        self.float(FLOAT_ADD, 4, Register(0));
        self.float(FLOAT_MULTIPLY, 1, ln_2);
        self.float(FLOAT_ADD, 4, Register(1));
        self.bits_of(RAX, 4);
        self.a.bind(store);
        self.a.instruction(STORE, wide, RAX, Memory(RDI, 0));
        self.next_lane(&[RDI, RSI], top);
        self.a.bind(nan);
        self.a.constant(RAX, S::from_f64(f64::NAN).bits());
        self.a.jump(store);
        self.a.bind(infinite);
        self.a.constant(RAX, S::from_f64(f64::NEG_INFINITY).bits());
        self.a.jump(store);
    }
}

/// A bit of the answer of CPUID: the leaf, the register, and the bits that must be set.
type Feature = (u32, u8, u32);

/// Appends the function that returns whether the processor has the instructions and the system
/// keeps their registers: 1, or else 0. Returns its label.
pub(super) fn is_supported(a: &mut Assembler, instruction_set: InstructionSet) -> Label {
    a.align(16);
    let start = a.label_at(a.code.len());
    // FMA, OSXSAVE and AVX; AVX2; F, DQ and VL of AVX-512.
    const AVX: Feature = (1, RCX, 1 << 12 | 1 << 27 | 1 << 28);
    const AVX2: Feature = (7, RBX, 1 << 5);
    const AVX512: Feature = (7, RBX, 1 << 5 | 1 << 16 | 1 << 17 | 1 << 31);
    let (features, registers): (&[Feature], i32) = match instruction_set {
        InstructionSet::Sse2 => (&[], 0),
        InstructionSet::Avx2 => (&[AVX, AVX2], 0x6),
        InstructionSet::Avx512 => (&[AVX, AVX512], 0xe6),
        InstructionSet::Neon => unreachable!("objects are made for x86-64"),
    };
    let [no, end] = std::array::from_fn(|_| a.label());
    // CPUID overwrites rbx, which belongs to the caller.
    a.copy(R8, RBX);
    if let Some((highest, ..)) = features.last() {
        a.constant(RAX, 0);
        a.bytes(&[0x0f, 0xa2]);
        a.immediate(IMMEDIATE_COMPARE, false, RAX, *highest as i32);
        a.jump_if(Condition::Below, no);
    }
    for &(leaf, register, bits) in features {
        a.constant(RAX, leaf.into());
        a.constant(RCX, 0);
        a.bytes(&[0x0f, 0xa2]);
        a.immediate(IMMEDIATE_AND, false, register, bits.cast_signed());
        a.immediate(IMMEDIATE_COMPARE, false, register, bits.cast_signed());
        a.jump_if(Condition::NotEqual, no);
        if leaf == 1 {
            // xgetbv
            a.constant(RCX, 0);
            a.bytes(&[0x0f, 0x01, 0xd0]);
            a.immediate(IMMEDIATE_AND, false, RAX, registers);
            a.immediate(IMMEDIATE_COMPARE, false, RAX, registers);
            a.jump_if(Condition::NotEqual, no);
        }
    }
    a.constant(RAX, 1);
    a.jump(end);
    a.bind(no);
    a.constant(RAX, 0);
    a.bind(end);
    a.copy(RBX, R8);
    a.bytes(&[0xc3]);
    start
}
