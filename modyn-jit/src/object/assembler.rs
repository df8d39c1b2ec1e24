//! Encodes the instructions around generated code: on general registers, and on scalars in vector
//! registers.
//!
//! Intel 64 and IA-32 Architectures Software Developer's Manual, volume 2. Registers have their
//! numbers there. All distances have 4 bytes.

pub(super) const RAX: u8 = 0;
pub(super) const RCX: u8 = 1;
pub(super) const RDX: u8 = 2;
pub(super) const RBX: u8 = 3;
pub(super) const RSP: u8 = 4;
pub(super) const RBP: u8 = 5;
pub(super) const RSI: u8 = 6;
pub(super) const RDI: u8 = 7;
pub(super) const R8: u8 = 8;
pub(super) const R9: u8 = 9;
pub(super) const R10: u8 = 10;
pub(super) const R11: u8 = 11;

/// A position in the code, which may come later.
#[derive(Clone, Copy, Debug)]
pub(super) struct Label(usize);

/// The last operand of an instruction.
#[derive(Clone, Copy, Debug)]
pub(super) enum Operand {
    /// A register.
    Register(u8),
    /// Memory: a general register and a displacement in bytes.
    Memory(u8, i32),
    /// The code or data at a label, and a displacement in bytes.
    Code(Label, i32),
}

/// An instruction: its mandatory prefix, if there is one, and its opcode.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opcode(pub Option<u8>, pub &'static [u8]);

const fn plain(bytes: &'static [u8]) -> Opcode {
    Opcode(None, bytes)
}

// The first operand is overwritten, and read by arithmetic.
pub(super) const LOAD: Opcode = plain(&[0x8b]);
/// The first operand is stored in the second one.
pub(super) const STORE: Opcode = plain(&[0x89]);
pub(super) const ADDRESS: Opcode = plain(&[0x8d]);
pub(super) const LOAD_SIGNED: Opcode = plain(&[0x63]);
pub(super) const ADD: Opcode = plain(&[0x03]);
pub(super) const SUBTRACT: Opcode = plain(&[0x2b]);
pub(super) const OR: Opcode = plain(&[0x0b]);
pub(super) const XOR: Opcode = plain(&[0x33]);
pub(super) const COMPARE: Opcode = plain(&[0x3b]);
pub(super) const TEST: Opcode = plain(&[0x85]);
pub(super) const MULTIPLY: Opcode = plain(&[0x0f, 0xaf]);
/// The number of the highest bit that is set.
pub(super) const HIGHEST_BIT: Opcode = plain(&[0x0f, 0xbd]);
pub(super) const MOVE_IF_BELOW: Opcode = plain(&[0x0f, 0x42]);
/// Shifts the second operand to the left by cl, and fills it from the first.
pub(super) const SHIFT_IN_BY_CL: Opcode = plain(&[0x0f, 0xa5]);

/// Extensions of the opcode of arithmetic on one operand.
pub(super) const MULTIPLY_WIDE: u8 = 4;
pub(super) const NEGATE: u8 = 3;

// Extensions of the opcodes with an immediate.
pub(super) const IMMEDIATE_ADD: u8 = 0;
pub(super) const IMMEDIATE_ADD_CARRY: u8 = 2;
pub(super) const IMMEDIATE_AND: u8 = 4;
pub(super) const IMMEDIATE_SUBTRACT: u8 = 5;
pub(super) const IMMEDIATE_XOR: u8 = 6;
pub(super) const IMMEDIATE_COMPARE: u8 = 7;
pub(super) const SHIFT_LEFT: u8 = 4;
pub(super) const SHIFT_RIGHT: u8 = 5;
pub(super) const SHIFT_RIGHT_SIGNED: u8 = 7;

/// 16 bytes of a vector register from memory, at any address.
pub(super) const LOAD_VECTOR: Opcode = plain(&[0x0f, 0x10]);
/// 16 bytes of a vector register to memory, at any address.
pub(super) const STORE_VECTOR: Opcode = plain(&[0x0f, 0x11]);
/// A general register to the lowest part of a vector register.
pub(super) const TO_VECTOR: Opcode = Opcode(Some(0x66), &[0x0f, 0x6e]);
/// The lowest part of a vector register, the first operand, to a general register.
pub(super) const FROM_VECTOR: Opcode = Opcode(Some(0x66), &[0x0f, 0x7e]);

/// 16 bytes of zeros in a vector register, of itself.
pub(super) const XOR_VECTOR: Opcode = plain(&[0x0f, 0x57]);

/// The conditions of jumps.
#[derive(Clone, Copy, Debug)]
pub(super) enum Condition {
    Below = 2,
    AboveOrEqual = 3,
    Equal = 4,
    NotEqual = 5,
    BelowOrEqual = 6,
    NotNegative = 9,
    /// After a comparison of numbers: one is NaN.
    Unordered = 10,
}

/// Code that is being written, with labels.
#[derive(Debug)]
pub(super) struct Assembler {
    /// The bytes.
    pub code: Vec<u8>,
    /// The position of each label; `None` until it is bound.
    labels: Vec<Option<usize>>,
    /// The positions of distances to labels, with displacements.
    distances: Vec<(usize, Label, i32)>,
}

impl Assembler {
    /// Returns an assembler that appends to this code.
    pub fn new(code: Vec<u8>) -> Self {
        Self { code, labels: Vec::new(), distances: Vec::new() }
    }

    /// Returns a label without a position.
    pub fn label(&mut self) -> Label {
        self.labels.push(None);
        Label(self.labels.len() - 1)
    }

    /// Returns a label at this position.
    pub fn label_at(&mut self, position: usize) -> Label {
        self.labels.push(Some(position));
        Label(self.labels.len() - 1)
    }

    /// Puts a label here.
    pub fn bind(&mut self, label: Label) {
        self.labels[label.0] = Some(self.code.len());
    }

    /// Fills up to a multiple of `alignment`.
    pub fn align(&mut self, alignment: usize) {
        // int3
        self.code.resize(self.code.len().next_multiple_of(alignment), 0xcc);
    }

    pub fn bytes(&mut self, bytes: &[u8]) {
        self.code.extend_from_slice(bytes);
    }

    /// Appends an instruction. `wide` are 64 bits of general registers instead of 32.
    pub fn instruction(&mut self, opcode: Opcode, wide: bool, register: u8, operand: Operand) {
        let Opcode(prefix, bytes) = opcode;
        self.code.extend(prefix);
        let base = match operand {
            Operand::Register(rm) | Operand::Memory(rm, _) => rm,
            Operand::Code(..) => 0,
        };
        let rex = u8::from(wide) << 3 | (register >> 3) << 2 | base >> 3;
        if rex > 0 {
            self.code.push(0x40 | rex);
        }
        self.bytes(bytes);
        let register = (register & 7) << 3;
        match operand {
            Operand::Register(rm) => self.code.push(0xc0 | register | rm & 7),
            Operand::Memory(base, displacement) => {
                self.code.push(0x80 | register | base & 7);
                if base & 7 == RSP {
                    self.code.push(0x24);
                }
                self.bytes(&displacement.to_le_bytes());
            }
            Operand::Code(label, displacement) => {
                self.code.push(register | 5);
                self.distance(label, displacement);
            }
        }
    }

    /// Appends the distance from its own end to a label.
    fn distance(&mut self, label: Label, displacement: i32) {
        self.distances.push((self.code.len(), label, displacement));
        self.bytes(&[0; 4]);
    }

    /// Appends arithmetic on one operand.
    pub fn unary(&mut self, extension: u8, wide: bool, register: u8) {
        self.instruction(plain(&[0xf7]), wide, extension, Operand::Register(register));
    }

    /// Appends the copy of rcx bytes from rsi to rdi.
    pub fn copy_bytes(&mut self) {
        // rep movsb
        self.bytes(&[0xf3, 0xa4]);
    }

    /// Appends the fill of rcx bytes from rdi on with the byte al.
    pub fn fill_bytes(&mut self) {
        // rep stosb
        self.bytes(&[0xf3, 0xaa]);
    }

    /// Appends an operation with an immediate.
    pub fn immediate(&mut self, extension: u8, wide: bool, register: u8, immediate: i32) {
        self.instruction(plain(&[0x81]), wide, extension, Operand::Register(register));
        self.bytes(&immediate.to_le_bytes());
    }

    /// Appends a shift.
    pub fn shift(&mut self, extension: u8, wide: bool, register: u8, count: u8) {
        self.instruction(plain(&[0xc1]), wide, extension, Operand::Register(register));
        self.bytes(&[count]);
    }

    /// Appends a shift of `register` to the left by one bit, which comes from `from`.
    pub fn shift_in_one(&mut self, register: u8, from: u8) {
        self.instruction(plain(&[0x0f, 0xa4]), true, from, Operand::Register(register));
        self.bytes(&[1]);
    }

    /// Appends an instruction that sets a bit.
    pub fn set_bit(&mut self, wide: bool, register: u8, bit: u8) {
        self.instruction(plain(&[0x0f, 0xba]), wide, 5, Operand::Register(register));
        self.bytes(&[bit]);
    }

    /// Appends the load of a constant.
    pub fn constant(&mut self, register: u8, value: u64) {
        match u32::try_from(value) {
            Ok(value) => {
                let rex = (register > 7).then_some(0x41);
                self.code.extend(rex);
                self.code.push(0xb8 | register & 7);
                self.bytes(&value.to_le_bytes());
            }
            Err(_) => {
                self.bytes(&[0x48 | register >> 3, 0xb8 | register & 7]);
                self.bytes(&value.to_le_bytes());
            }
        }
    }

    pub fn copy(&mut self, to: u8, from: u8) {
        self.instruction(LOAD, true, to, Operand::Register(from));
    }

    pub fn jump_if(&mut self, condition: Condition, label: Label) {
        self.bytes(&[0x0f, 0x80 | condition as u8]);
        self.distance(label, 0);
    }

    pub fn jump(&mut self, label: Label) {
        self.bytes(&[0xe9]);
        self.distance(label, 0);
    }

    pub fn call(&mut self, label: Label) {
        self.bytes(&[0xe8]);
        self.distance(label, 0);
    }

    /// Appends the distance of a label from another one, 4 bytes of data.
    pub fn offset(&mut self, from: Label, to: Label) {
        let [from, to] = [from, to].map(|label| self.position(label) as i64);
        let offset = i32::try_from(to - from).expect("code is shorter than 2 GiB");
        self.bytes(&offset.to_le_bytes());
    }

    pub fn position(&self, label: Label) -> usize {
        self.labels[label.0].expect("the label has a position")
    }

    /// Fills in all distances, and returns the code.
    pub fn finish(mut self) -> Vec<u8> {
        for (at, label, displacement) in std::mem::take(&mut self.distances) {
            let target = self.position(label) as i64 + i64::from(displacement);
            let offset = i32::try_from(target - (at as i64 + 4));
            let distance = offset.expect("code is shorter than 2 GiB");
            self.code[at..at + 4].copy_from_slice(&distance.to_le_bytes());
        }
        self.code
    }

    /// Fills in the distance at this position of earlier code.
    pub fn refer(&mut self, at: usize, label: Label) {
        self.distances.push((at, label, 0));
    }
}
