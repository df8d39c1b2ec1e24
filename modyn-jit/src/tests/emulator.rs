//! An emulator of the instructions in generated functions, with all instruction sets, also those
//! that the host lacks. Memory is a few regions with gaps between them, so that an access outside
//! of a function's memory fails the test.

use iced_x86::{Decoder, DecoderOptions, Instruction, OpKind, Register};
use modyn_runtime::trig_steps;

use super::Fuse;

/// Numbers that are no valid address; they stand for helpers.
pub(super) const REDUCE: u64 = 0x11;
pub(super) const ATAN2: u64 = 0x22;
pub(super) const LOGARITHM: u64 = 0x33;

const CODE: u64 = 0x100_0000;
const STACK: u64 = 0x200_0000;
const STACK_BYTES: usize = 1 << 20;
const TABLE: u64 = 0x300_0000;
const RESULTS: u64 = 0x400_0000;
const ARGUMENTS: u64 = 0x500_0000;
const RETURN: u64 = 0x7777;

struct Region {
    start: u64,
    bytes: Vec<u8>,
    writable: bool,
}

pub(super) struct Emulator {
    regions: Vec<Region>,
    vectors: [[u8; 64]; 32],
    general: [u64; 16],
    mask: u64,
    zero: bool,
    carry: bool,
    /// The number of executed instructions.
    pub count: usize,
}

/// The bits of a number as a floating-point operation reads them.
fn number(operation: &str, size: usize, x: &[u64]) -> u64 {
    macro_rules! in_precision {
        ($float:ident, $bits:ty) => {{
            let of = |i: usize| <$float>::from_bits(x[i] as $bits);
            let (a, b) = (of(0), if x.len() > 1 { of(1) } else { 0.0 });
            let all = |holds: bool| if holds { <$bits>::MAX } else { 0 };
            let bits = match operation {
                "add" => (a + b).to_bits(),
                "sub" => (a - b).to_bits(),
                "mul" => (a * b).to_bits(),
                "div" => (a / b).to_bits(),
                "max" => if a > b { a } else { b }.to_bits(),
                "sqrt" => a.sqrt().to_bits(),
                "fmadd" => a.mul_add(b, of(2)).to_bits(),
                "fmsub" => a.mul_add(b, -of(2)).to_bits(),
                "fnmadd" => (-a).mul_add(b, of(2)).to_bits(),
                "fnmsub" => (-a).mul_add(b, -of(2)).to_bits(),
                "less" => all(a < b),
                "less or equal" => all(a <= b),
                "unordered" => all(a.is_nan() || b.is_nan()),
                _ => panic!("{operation}"),
            };
            u64::from(bits)
        }};
    }
    if size == 8 { in_precision!(f64, u64) } else { in_precision!(f32, u32) }
}

fn lane(bytes: &[u8], size: usize, lane: usize) -> u64 {
    let mut number = [0; 8];
    number[..size].copy_from_slice(&bytes[lane * size..][..size]);
    u64::from_le_bytes(number)
}

fn put(bytes: &mut [u8], size: usize, lane: usize, number: u64) {
    bytes[lane * size..][..size].copy_from_slice(&number.to_le_bytes()[..size]);
}

impl Emulator {
    /// Runs the function at `entry` of the code on arguments, and returns this number of results.
    pub fn run<F: Fuse>(
        &mut self,
        code: &[u8],
        entry: usize,
        arguments: &[&[F]],
        results: usize,
    ) -> Vec<F> {
        let size = size_of::<F>();
        let bytes = |numbers: &[F]| -> Vec<u8> {
            numbers.iter().flat_map(|x| x.bits().to_le_bytes()[..size].to_vec()).collect()
        };
        let region = |start, bytes, writable| Region { start, bytes, writable };
        self.regions = vec![
            region(CODE, code.to_vec(), false),
            region(STACK, vec![0xee; STACK_BYTES], true),
            region(RESULTS, vec![0xee; results * size], true),
        ];
        let mut table = Vec::new();
        for (i, argument) in (0..).zip(arguments) {
            let start = ARGUMENTS + 0x10_0000 * i;
            table.extend_from_slice(&start.to_le_bytes());
            self.regions.push(region(start, bytes(argument), false));
        }
        self.regions.push(region(TABLE, table, false));
        // An address that is 8 more than a multiple of 16, as after a call.
        let top = STACK + STACK_BYTES as u64 - 8;
        self.general = std::array::from_fn(|i| 0xabcd_0000 + i as u64);
        (self.general[7], self.general[6], self.general[4]) = (TABLE, RESULTS, top);
        self.write(top, &RETURN.to_le_bytes());
        let kept = |general: &[u64; 16]| [3, 5, 12, 13, 14, 15].map(|number| general[number]);
        let before = kept(&self.general);
        let mut at = CODE + entry as u64;
        while at != RETURN {
            let offset = (at - CODE) as usize;
            let mut decoder = Decoder::with_ip(64, &code[offset..], at, DecoderOptions::NONE);
            let instruction = decoder.decode();
            at = self.step::<F>(&instruction);
            self.count += 1;
        }
        assert_eq!(
            (kept(&self.general), self.general[4]),
            (before, top + 8),
            "registers that the callee must preserve"
        );
        let memory = self.read(RESULTS, results * size);
        let bits = (0..results).map(|i| lane(&memory, size, i));
        bits.map(|bits| F::of_bits(bits)).collect()
    }

    fn region(&mut self, address: u64, length: usize) -> (&mut Region, usize) {
        let holds = |region: &&mut Region| {
            let end = region.start + region.bytes.len() as u64;
            region.start <= address && address + length as u64 <= end
        };
        let holder = self.regions.iter_mut().find(holds);
        let region = holder.unwrap_or_else(|| panic!("{length} bytes at {address:x}"));
        let offset = (address - region.start) as usize;
        (region, offset)
    }

    fn read(&mut self, address: u64, length: usize) -> Vec<u8> {
        let (region, offset) = self.region(address, length);
        region.bytes[offset..offset + length].to_vec()
    }

    fn write(&mut self, address: u64, bytes: &[u8]) {
        let stack = self.general[4];
        let (region, offset) = self.region(address, bytes.len());
        assert!(region.writable, "{address:x} is read only");
        assert!(region.start != STACK || address >= stack, "below the stack pointer");
        region.bytes[offset..offset + bytes.len()].copy_from_slice(bytes);
    }

    fn address(&self, instruction: &Instruction) -> u64 {
        let distance = instruction.memory_displacement64();
        match instruction.memory_base() {
            // The disassembler gives the absolute address.
            Register::RIP | Register::None => distance,
            base => self.general[base.number()].wrapping_add(distance),
        }
    }

    /// Returns the bytes of an operand: of a register, or of memory.
    fn source(&mut self, instruction: &Instruction, operand: u32, length: usize) -> Vec<u8> {
        if instruction.op_kind(operand) == OpKind::Memory {
            let address = self.address(instruction);
            let legacy = !format!("{:?}", instruction.mnemonic()).starts_with('V');
            assert!(!legacy || length < 16 || address.is_multiple_of(16) || is_move(instruction));
            return self.read(address, length);
        }
        let register = instruction.op_register(operand);
        self.vectors[register.number()][..length].to_vec()
    }

    fn general_source(&mut self, instruction: &Instruction, operand: u32) -> u64 {
        match instruction.op_kind(operand) {
            OpKind::Register => self.general[instruction.op_register(operand).number()],
            OpKind::Memory => {
                let address = self.address(instruction);
                let bytes = self.read(address, 8);
                lane(&bytes, 8, 0)
            }
            _ => instruction.immediate(operand),
        }
    }

    /// Runs one instruction; returns the address of the next one.
    fn step<F: Fuse>(&mut self, instruction: &Instruction) -> u64 {
        let name = format!("{:?}", instruction.mnemonic()).to_lowercase();
        let next = instruction.next_ip();
        let target = instruction.near_branch_target();
        match name.as_str() {
            "push" => {
                let value = self.general_source(instruction, 0);
                self.general[4] -= 8;
                self.write(self.general[4], &value.to_le_bytes());
            }
            "pop" | "ret" => {
                let bytes = self.read(self.general[4], 8);
                self.general[4] += 8;
                if name == "ret" {
                    return lane(&bytes, 8, 0);
                }
                self.general[instruction.op_register(0).number()] = lane(&bytes, 8, 0);
            }
            "mov" if instruction.op_kind(0) == OpKind::Memory => {
                let address = self.address(instruction);
                let value = self.general_source(instruction, 1);
                self.write(address, &value.to_le_bytes());
            }
            "mov" => {
                let value = self.general_source(instruction, 1);
                self.general[instruction.op_register(0).number()] = value;
            }
            "lea" => {
                self.general[instruction.op_register(0).number()] = self.address(instruction);
            }
            "and" | "sub" | "dec" | "cmp" => {
                let register = instruction.op_register(0);
                let a = self.general[register.number()];
                let result = match name.as_str() {
                    "and" => a & instruction.immediate(1),
                    "dec" => a - 1,
                    _ => a.wrapping_sub(instruction.immediate(1)),
                };
                self.zero = if register.size() == 4 { result as u32 == 0 } else { result == 0 };
                if name != "cmp" {
                    self.general[register.number()] = result;
                }
            }
            // Touches a page.
            "or" => {
                let address = self.address(instruction);
                self.read(address, 4);
            }
            "jne" if !self.zero => return target,
            "jbe" if self.zero || self.carry => return target,
            "jmp" => return target,
            "jne" | "jbe" => {}
            "vzeroupper" => {
                for vector in &mut self.vectors[..16] {
                    vector[16..].fill(0);
                }
            }
            "call" if instruction.op0_kind() == OpKind::NearBranch64 => {
                assert!(self.general[4].is_multiple_of(16), "an aligned stack");
                self.general[4] -= 8;
                self.write(self.general[4], &next.to_le_bytes());
                return target;
            }
            "call" => {
                assert!(self.general[4].is_multiple_of(16), "an aligned stack");
                self.helper::<F>();
            }
            _ => self.vector(instruction, &name),
        }
        next
    }

    /// Calls a helper, and overwrites the registers that a call may change.
    fn helper<F: Fuse>(&mut self) {
        let size = size_of::<F>();
        let [helper, lanes, third, second, first] =
            [0, 1, 2, 6, 7].map(|register| self.general[register]);
        for k in 0..lanes & 0xffff_ffff {
            let [first, second, third] = [first, second, third].map(|at| at + k * size as u64);
            let mut at = |address| F::of_bits(lane(&self.read(address, size), size, 0));
            let written = match helper {
                REDUCE if at(third).abs() < trig_steps::limit() => continue,
                REDUCE => {
                    let [reduced, turns] = trig_steps::reduce_far(at(third));
                    self.write(second, &turns.bits().to_le_bytes()[..size]);
                    reduced
                }
                ATAN2 => at(second).atan2(at(third)),
                LOGARITHM => at(second).ln(),
                _ => panic!("{helper:x}"),
            };
            self.write(first, &written.bits().to_le_bytes()[..size]);
        }
        for register in [0, 1, 2, 6, 7, 8, 9, 10, 11] {
            self.general[register] = 0xdead_dead;
        }
        self.vectors = [[0xdd; 64]; 32];
        self.mask = 0xdddd;
    }

    /// Runs an instruction on vector registers.
    fn vector(&mut self, instruction: &Instruction, name: &str) {
        let avx = name.starts_with('v') || name.starts_with('k');
        let name = name.strip_prefix('v').unwrap_or(name);
        let operands = instruction.op_count();
        let is_vector = |operand: u32| {
            instruction.op_kind(operand) == OpKind::Register
                && instruction.op_register(operand).is_vector_register()
        };
        let length = (0..operands).filter(|&operand| is_vector(operand));
        let longest = length.map(|operand| instruction.op_register(operand).size()).max();
        let length = longest.unwrap_or(16);
        let (base, suffix) = name.split_at(name.len() - 2);
        let size = if suffix.ends_with('d') && suffix != "ld" || suffix == "lq" { 8 } else { 4 };
        let scalar = suffix.starts_with('s');
        let lanes = if scalar { 1 } else { length / size };
        let width = if scalar { size } else { length };
        // The first source: with two operands it is the destination.
        let first = if avx { 1 } else { 0 };
        let last = if avx { 2 } else { 1 };
        let written = instruction.op0_register().number();
        match (base, name) {
            ("add" | "sub" | "mul" | "div" | "max" | "sqrt", _) => {
                let unary = base == "sqrt";
                let last = operands - 1;
                let mut result = match (unary, scalar) {
                    (true, false) => vec![0; length],
                    (true, true) if !avx => self.vectors[written][..16].to_vec(),
                    _ => self.source(instruction, first, length),
                };
                let second = self.source(instruction, last, width);
                for k in 0..lanes {
                    let both = [lane(&result, size, k), lane(&second, size, k)];
                    let numbers = if unary { &both[1..] } else { &both };
                    put(&mut result, size, k, number(base, size, numbers));
                }
                self.put(written, &result, avx);
            }
            ("and" | "andn" | "or" | "xor", _) => {
                let a = self.source(instruction, first, length);
                let b = self.source(instruction, last, length);
                let bits = |(a, b): (&u8, &u8)| match base {
                    "and" => a & b,
                    "andn" => !a & b,
                    "or" => a | b,
                    _ => a ^ b,
                };
                let result: Vec<u8> = a.iter().zip(&b).map(bits).collect();
                self.put(written, &result, avx);
            }
            ("cmp", _) => {
                let a = self.source(instruction, first, length);
                let b = self.source(instruction, last, width);
                let predicate = match instruction.immediate8() {
                    1 => "less",
                    2 => "less or equal",
                    3 => "unordered",
                    other => panic!("{other}"),
                };
                let masks = (0..lanes)
                    .map(|k| number(predicate, size, &[lane(&a, size, k), lane(&b, size, k)]));
                if instruction.op_register(0) == Register::K1 {
                    let bits = masks.enumerate().map(|(k, mask)| (mask & 1) << k);
                    self.mask = bits.fold(0, |all, bit| all | bit);
                } else {
                    let mut result = a.clone();
                    masks.enumerate().for_each(|(k, mask)| put(&mut result, size, k, mask));
                    self.put(written, &result, avx);
                }
            }
            (_, "pmovm2q" | "pmovm2d") => {
                let size = if name == "pmovm2q" { 8 } else { 4 };
                let mut result = vec![0; length];
                for k in 0..length / size {
                    let bit = self.mask >> k & 1;
                    put(&mut result, size, k, bit.wrapping_neg());
                }
                self.put(written, &result, avx);
            }
            (_, "kmovw") => self.general[written] = self.mask & 0xffff,
            ("movmsk", _) => {
                let a = self.source(instruction, 1, length);
                let sign = |k| lane(&a, size, k) >> (8 * size - 1) << k;
                self.general[written] = (0..lanes).map(sign).fold(0, |all, bit| all | bit);
            }
            ("comi", _) => {
                let a = lane(&self.source(instruction, 0, 16), size, 0);
                let b = lane(&self.source(instruction, 1, size), size, 0);
                let unordered = number("unordered", size, &[a, b]) != 0;
                let above = number("less", size, &[b, a]) != 0;
                self.carry = unordered || number("less", size, &[a, b]) != 0;
                self.zero = unordered || !above && !self.carry;
            }
            ("psl", "psllq" | "pslld") => {
                let size = if name == "psllq" { 8 } else { 4 };
                let operand = u32::from(avx);
                let mut result = self.source(instruction, operand, length);
                for k in 0..length / size {
                    let shifted = lane(&result, size, k) << instruction.immediate8();
                    put(&mut result, size, k, shifted);
                }
                self.put(written, &result, avx);
            }
            ("unpckl", _) => {
                assert_eq!(length, 16);
                let a = self.source(instruction, first, 16);
                let b = self.source(instruction, last, 16);
                let mut result = vec![0; 16];
                for k in 0..16 / size {
                    put(&mut result, size, k, lane(if k % 2 == 0 { &a } else { &b }, size, k / 2));
                }
                self.put(written, &result, avx);
            }
            ("movh", _) => {
                let mut result = self.source(instruction, if avx { 1 } else { 0 }, 16);
                let upper = self.source(instruction, last, 8);
                result[8..].copy_from_slice(&upper);
                self.put(written, &result, avx);
            }
            ("shuf", _) => {
                assert_eq!((size, instruction.immediate8()), (4, 0));
                let a = self.source(instruction, 0, 16);
                let b = self.source(instruction, 1, 16);
                self.put(written, &[&a[..4], &a[..4], &b[..4], &b[..4]].concat(), avx);
            }
            (_, "movddup" | "broadcastsd" | "broadcastss") => {
                let size = if name == "broadcastss" { 4 } else { 8 };
                let length = instruction.op0_register().size();
                let one = self.source(instruction, 1, size);
                self.put(written, &one.repeat(length / size), avx);
            }
            (_, "insertf128" | "insertf32x4" | "insertf64x4") => {
                assert_eq!(instruction.immediate8(), 1);
                let mut result = self.source(instruction, 1, length);
                let upper = self.source(instruction, 2, length / 2);
                result[length / 2..].copy_from_slice(&upper);
                self.put(written, &result, avx);
            }
            _ if base.starts_with('f') => {
                let (operation, form) = base.split_at(base.len() - 3);
                let written_vector = self.vectors[written][..length].to_vec();
                let second = self.source(instruction, 1, length);
                let third = self.source(instruction, 2, width);
                let mut result = written_vector.clone();
                for k in 0..lanes {
                    let [a, b, c] = [&written_vector, &second, &third].map(|x| lane(x, size, k));
                    let numbers = match form {
                        "132" => [a, c, b],
                        "213" => [b, a, c],
                        _ => [b, c, a],
                    };
                    put(&mut result, size, k, number(operation, size, &numbers));
                }
                self.put(written, &result, avx);
            }
            ("movu" | "mova" | "mov", _) => {
                if instruction.op_kind(0) == OpKind::Memory {
                    let address = self.address(instruction);
                    let bytes = self.source(instruction, 1, width);
                    self.write(address, &bytes);
                } else {
                    assert!(!scalar || instruction.op_kind(1) == OpKind::Memory);
                    let mut bytes = self.source(instruction, 1, width);
                    bytes.resize(length, 0);
                    self.put(written, &bytes, avx);
                }
            }
            _ => panic!("{instruction:?}"),
        }
    }

    /// Writes a register; AVX clears the upper part.
    fn put(&mut self, register: usize, bytes: &[u8], avx: bool) {
        let vector = &mut self.vectors[register];
        vector[..bytes.len()].copy_from_slice(bytes);
        if avx {
            vector[bytes.len().max(16)..].fill(0);
        }
    }
}

/// Moves need no alignment; other SSE instructions do.
fn is_move(instruction: &Instruction) -> bool {
    format!("{:?}", instruction.mnemonic()).starts_with("Movu")
}

impl Default for Emulator {
    fn default() -> Self {
        Self {
            regions: Vec::new(),
            vectors: [[0xcc; 64]; 32],
            general: [0; 16],
            mask: 0,
            zero: false,
            carry: false,
            count: 0,
        }
    }
}
