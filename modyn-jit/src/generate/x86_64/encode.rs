//! Encodes x86-64 instructions on vector registers: SSE, AVX (VEX) and AVX-512 (EVEX).
//!
//! Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2, chapter 2. Registers
//! have numbers: 0 is rax or xmm0. Operations on general registers are few, and are written out
//! where they are used.

/// An instruction, without its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Opcode {
    /// The map of opcodes: 1 for 0F, 2 for 0F 38, 3 for 0F 3A.
    pub map: u8,
    /// The mandatory prefix: 0 for none, 1 for 66, 2 for F3, 3 for F2.
    pub prefix: u8,
    /// The opcode.
    pub byte: u8,
    /// The bit W of VEX.
    pub vex_w: bool,
    /// The bit W of EVEX.
    pub evex_w: bool,
}

/// The last operand of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A register.
    Register(u8),
    /// Memory: a general register other than rsp, rbp, r12 and r13, and a displacement in bytes.
    Memory(u8, i32),
}

/// The encoding of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// SSE: the first operand is read and overwritten.
    Legacy,
    /// AVX.
    Vex,
    /// AVX-512: 32 registers, vectors of 64 bytes, masks.
    Evex,
}

/// The operands of an instruction besides its last one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Operands {
    /// The bytes of the vectors: 16, 32 or 64. Instructions on scalars have 16.
    pub vector: usize,
    /// The destination register, or the extension of the opcode.
    pub register: u8,
    /// The first source; 0 where there is none.
    pub source: u8,
    /// The last operand.
    pub place: Place,
    /// The size of the last operand in memory, bytes.
    pub memory: usize,
    /// The immediate byte.
    pub immediate: Option<u8>,
}

/// Machine code that is being written.
#[derive(Debug, Default)]
pub(crate) struct Encoder {
    /// The bytes.
    pub code: Vec<u8>,
    /// The number of instructions.
    pub instructions: usize,
}

impl Encoder {
    /// Appends the bytes of one instruction.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.code.extend_from_slice(bytes);
        self.instructions += 1;
    }

    /// Appends an instruction on vector registers.
    pub fn vector(&mut self, encoding: Encoding, opcode: Opcode, operands: &Operands) {
        let Operands { vector, register, source, place, memory, immediate } = *operands;
        let rm = match place {
            Place::Register(register) => register,
            Place::Memory(base, _) => base,
        };
        debug_assert!(encoding == Encoding::Evex || (register | source) < 16 && vector < 64);
        let Opcode { map, prefix, byte, .. } = opcode;
        let not = |register: u8, bit: u8| (!register >> bit) & 1;
        let mut unit = 1;
        match encoding {
            Encoding::Legacy => {
                debug_assert!(source == 0 || source == register, "two operands");
                if prefix > 0 {
                    self.code.push([0x66, 0xf3, 0xf2][usize::from(prefix) - 1]);
                }
                let rex = (register >> 3) << 2 | rm >> 3;
                if rex > 0 {
                    self.code.push(0x40 | rex);
                }
                self.code.extend(match map {
                    1 => &[0x0f][..],
                    2 => &[0x0f, 0x38],
                    _ => &[0x0f, 0x3a],
                });
            }
            Encoding::Vex => {
                let long = u8::from(vector == 32) << 2;
                let last = (!source & 15) << 3 | long | prefix;
                if map == 1 && !opcode.vex_w && rm < 8 {
                    self.code.extend([0xc5, not(register, 3) << 7 | last]);
                } else {
                    let bits = not(register, 3) << 7 | 1 << 6 | not(rm, 3) << 5 | map;
                    self.code.extend([0xc4, bits, u8::from(opcode.vex_w) << 7 | last]);
                }
            }
            Encoding::Evex => {
                // The displacement of one byte counts in units of the operand's size.
                unit = memory.max(1) as i32;
                // If the last operand is a register, X is its fifth bit.
                let x = if matches!(place, Place::Register(_)) { not(rm, 4) } else { 1 };
                let bits = not(register, 3) << 7 | x << 6 | not(rm, 3) << 5 | not(register, 4) << 4;
                let second = u8::from(opcode.evex_w) << 7 | (!source & 15) << 3 | 1 << 2 | prefix;
                let length = (vector / 32) as u8;
                self.code.extend([0x62, bits | map, second, length << 5 | not(source, 4) << 3]);
            }
        }
        self.code.push(byte);
        let register = (register & 7) << 3;
        match place {
            Place::Register(rm) => self.code.push(0xc0 | register | rm & 7),
            Place::Memory(base, distance) => self.memory(register, base, distance, unit),
        }
        self.code.extend(immediate);
        self.instructions += 1;
    }

    /// Appends the bytes of a memory operand.
    fn memory(&mut self, register: u8, base: u8, distance: i32, unit: i32) {
        debug_assert!(base & 7 != 4 && base & 7 != 5, "no plain base");
        let short = (distance % unit == 0).then(|| i8::try_from(distance / unit).ok()).flatten();
        match short {
            Some(0) => self.code.push(register | base & 7),
            Some(short) => self.code.extend([0x40 | register | base & 7, short.cast_unsigned()]),
            None => {
                self.code.push(0x80 | register | base & 7);
                self.code.extend(distance.to_le_bytes());
            }
        }
    }

    /// Appends an instruction on a general register and a memory operand, both of 64 bits: 8B
    /// loads, 89 stores, 8D computes the address.
    pub fn general(&mut self, opcode: u8, register: u8, base: u8, distance: i32) {
        self.code.extend([0x48 | (register >> 3) << 2 | base >> 3, opcode]);
        if base == RSP {
            self.code.extend([0x84 | (register & 7) << 3, 0x24]);
            self.code.extend(distance.to_le_bytes());
        } else {
            self.memory((register & 7) << 3, base, distance, 1);
        }
        self.instructions += 1;
    }
}

/// Writes the distance from the end of an instruction to `target` at `at`, its last four bytes.
pub(super) fn patch(code: &mut [u8], at: usize, target: i64) {
    let offset = target - (at as i64 + 4);
    let distance = i32::try_from(offset).expect("code is shorter than 2 GiB");
    code[at..at + 4].copy_from_slice(&distance.to_le_bytes());
}

/// The stack pointer.
pub(crate) const RSP: u8 = 4;
