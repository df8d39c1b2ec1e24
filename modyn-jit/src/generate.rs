//! Generates machine code from values in one pass over the steps, which assigns registers and writes instructions.
//!
//! A function has two arguments: a pointer to a table of pointers to its arguments (rdi), and a pointer to its results
//! (rsi). It follows System V's calling convention on every system. Registers in its body: rax points into the stack
//! frame, rbx to the constants, rcx to the results, and one register each to the arguments; rbp keeps the stack pointer
//! of the entry; r11 is free.
//!
//! The frame, upwards from rsp, which is a multiple of 64: the two pointers, memory for all vector registers during
//! calls, slots of values.
//!
//! One comparison after the reductions of a statement finds angles that are too large for the fast reduction. Code
//! after the return then saves the registers, reduces these angles by a call, and jumps back.

use crate::encode::{Encoder, Encoding, Opcode, Operands, Place, RSP};
use crate::helper::Helpers;
use crate::level::Level;
use crate::opcodes::{
    self as op, arithmetic, broadcast, mask_to_vector, multiply_add, scalar_double, shift_left,
};
use crate::registers::{Home, NONE, Registers};
use crate::values::{Definition, FarCheck, Operation, Step, Value, Values};

/// Counts of a function's code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CodeSize {
    /// Bytes of instructions.
    pub bytes: usize,
    /// Bytes of constants.
    pub constants: usize,
    /// Bytes of the stack frame.
    pub frame: usize,
    /// Instructions, without those that only run for large angles.
    pub instructions: usize,
    /// Stores of values for which there was no register; they are among the instructions.
    pub spills: usize,
    /// Loads of values into registers, without operands in memory.
    pub loads: usize,
    /// Operands that instructions read from memory.
    pub memory_operands: usize,
    /// Copies between registers.
    pub copies: usize,
}

impl std::ops::AddAssign for CodeSize {
    fn add_assign(&mut self, other: Self) {
        self.bytes += other.bytes;
        self.constants += other.constants;
        self.frame = self.frame.max(other.frame);
        self.instructions += other.instructions;
        self.spills += other.spills;
        self.loads += other.loads;
        self.memory_operands += other.memory_operands;
        self.copies += other.copies;
    }
}

/// A function: instructions, then constants. It can start at any multiple of 64.
pub(crate) struct Generated {
    pub code: Vec<u8>,
    pub size: CodeSize,
}

/// The largest number of arrays of arguments.
pub(crate) const MAX_ARRAYS: usize = BASES.len();

/// The registers that point to the arguments.
const BASES: [u8; 6] = [7, 6, 2, 8, 9, 10];
const RAX: u8 = 0;
const RCX: u8 = 1;
const RDX: u8 = 2;
const RBX: u8 = 3;
const RSI: u8 = 6;
const RDI: u8 = 7;
const R11: u8 = 11;

/// The range of displacements of one byte, on both sides.
const SHORT: i32 = 128;

/// A value in memory that is read again within this number of steps is loaded into a free register.
const SOON: u32 = 40;

/// The predicates of comparisons.
const LESS: u8 = 1;
const LESS_OR_EQUAL: u8 = 2;
const UNORDERED: u8 = 3;

/// Generates the machine code of values. `size` is the size of a number in bytes.
pub(crate) fn generate(
    values: &Values,
    level: Level,
    size: usize,
    arrays: usize,
    helpers: &Helpers,
) -> Generated {
    assert!(arrays <= MAX_ARRAYS, "no function has so many arrays");
    let vector = values.lanes.iter().map(|&lanes| usize::from(lanes) * size).max().unwrap_or(16);
    let calls = values.steps.iter().any(|step| match step {
        Step::Check(_) => true,
        Step::Compute(value) => matches!(
            values.definitions[*value as usize],
            Definition::Result(Operation::Atan2 | Operation::Logarithm, _)
        ),
    });
    let vector = vector.max(16);
    let (runs, single) = stores(values, size);
    let last: Vec<Value> = single
        .iter()
        .map(|&(value, _)| value)
        .filter(|&v| !matches!(values.definitions[v as usize], Definition::Result(..)))
        .collect();
    let (pool, pool_at) = pool(values, size);
    let mut stores: Vec<Vec<u32>> = vec![Vec::new(); values.definitions.len()];
    let mut late = Vec::new();
    for (value, distance) in runs.into_iter().chain(single) {
        match values.definitions[value as usize] {
            Definition::Result(..) => stores[value as usize].push(distance),
            _ => late.push((value, distance)),
        }
    }
    let mut generator = Generator {
        values,
        level,
        size,
        arrays,
        helpers,
        vector,
        saved: if calls { usize::from(level.registers()) * vector } else { 0 },
        registers: Registers::new(values, size, level.registers(), &last),
        encoder: Encoder::default(),
        pool_at,
        stores,
        detours: Vec::new(),
        counts: CodeSize::default(),
    };
    for (position, step) in (0..).zip(&values.steps) {
        generator.registers.advance(position, &values.reads(step));
        match step {
            Step::Compute(value) => generator.compute(*value),
            Step::Check(check) => generator.check(check),
        }
    }
    generator.registers.position = values.steps.len() as u32;
    for (value, distance) in late {
        let register = generator.force(value, &mut 0);
        generator.store_result(value, register, distance);
    }
    generator.finish(&pool)
}

/// Values, each with the offset at which it is stored in the results.
type Stores = Vec<(Value, u32)>;

/// Returns the stores of results: first vectors whose lanes are consecutive results, then all others.
fn stores(values: &Values, size: usize) -> (Stores, Stores) {
    let (mut runs, mut single) = (Vec::new(), Vec::new());
    let mut distance = 0;
    let mut k = 0;
    while k < values.results.len() {
        let result = values.results[k];
        let (stored, count) = match values.definitions[result as usize] {
            Definition::Lane(vector, 0) => {
                let lanes = usize::from(values.lanes[vector as usize]);
                let run = values.results[k..].iter().take(lanes).enumerate();
                let whole = run.clone().count() == lanes
                    && run.clone().all(|(lane, &result)| {
                        values.definitions[result as usize] == Definition::Lane(vector, lane as u8)
                    });
                if whole { (vector, lanes) } else { (result, 1) }
            }
            _ => (result, 1),
        };
        if stored == result { &mut single } else { &mut runs }.push((stored, distance));
        distance += values.results[k..k + count]
            .iter()
            .map(|&result| (usize::from(values.lanes[result as usize]) * size) as u32)
            .sum::<u32>();
        k += count;
    }
    (runs, single)
}

/// Returns the bytes of the constants, and the offset of each. The constants that are used most are first: they have
/// short displacements.
fn pool(values: &Values, size: usize) -> (Vec<u8>, Vec<u32>) {
    let mut uses = vec![0_usize; values.pool.len()];
    let reads = values.steps.iter().flat_map(|step| values.reads(step));
    for value in reads.chain(values.results.iter().copied()) {
        if let Definition::Constant(place) = values.definitions[value as usize] {
            uses[place as usize] += 1;
        }
    }
    let mut order: Vec<usize> = (0..uses.len()).filter(|&place| uses[place] > 0).collect();
    order.sort_by_key(|&place| (std::cmp::Reverse(uses[place]), place));
    let (mut bytes, mut at) = (Vec::new(), vec![0; uses.len()]);
    for place in order {
        let constant = &values.pool[place];
        let length = constant.len() * size;
        bytes.resize(bytes.len().next_multiple_of(length), 0);
        at[place] = bytes.len() as u32;
        for bits in constant {
            bytes.extend_from_slice(&bits.to_le_bytes()[..size]);
        }
    }
    (bytes, at)
}

/// Instructions outside of the straight path.
struct Detour {
    /// The position of the jump's distance.
    from: usize,
    /// The position after it.
    back: usize,
    /// The registers that hold values.
    occupied: u32,
    /// The places of each angle, its reduction and the number with the multiple's lowest bit; and the number of lanes.
    angles: Vec<([Place; 3], u8)>,
}

struct Generator<'a> {
    values: &'a Values,
    level: Level,
    size: usize,
    arrays: usize,
    helpers: &'a Helpers,
    /// The size of the longest vector in bytes.
    vector: usize,
    /// The size of all registers in the frame in bytes.
    saved: usize,
    registers: Registers<'a>,
    encoder: Encoder,
    pool_at: Vec<u32>,
    /// For each value the offsets at which it is a result.
    stores: Vec<Vec<u32>>,
    detours: Vec<Detour>,
    counts: CodeSize,
}

impl Generator<'_> {
    /// Returns the memory operand of a value.
    fn memory(&self, value: Value) -> Place {
        match self.values.definitions[value as usize] {
            Definition::Constant(place) => {
                Place::Memory(RBX, self.pool_at[place as usize] as i32 - SHORT)
            }
            Definition::Argument { array, first } => {
                Place::Memory(BASES[usize::from(array)], (first as usize * self.size) as i32)
            }
            Definition::Lane(vector, lane) => match self.memory(vector) {
                Place::Memory(base, distance) => {
                    Place::Memory(base, distance + i32::from(lane) * self.size as i32)
                }
                Place::Register(_) => unreachable!("memory"),
            },
            Definition::Result(..) => match self.registers.home(value) {
                Home::Slot(slot) => Place::Memory(RAX, slot as i32 - SHORT),
                Home::Result(distance) => Place::Memory(RCX, distance as i32),
                Home::None => unreachable!("a value that is read is somewhere"),
            },
        }
    }

    /// Returns the memory operand of a register during calls.
    fn saved(&self, register: u8) -> Place {
        let below = self.saved as i32 - i32::from(register) * self.vector as i32;
        Place::Memory(RAX, -SHORT - below)
    }

    fn lanes(&self, value: Value) -> u8 {
        self.values.lanes[value as usize]
    }

    /// Writes an instruction on vectors of this number of bytes; the last operand has the same size in memory.
    fn write(
        &mut self,
        opcode: Opcode,
        bytes: usize,
        registers: [u8; 2],
        place: Place,
        immediate: Option<u8>,
    ) {
        self.write_reading(bytes, opcode, bytes, registers, place, immediate);
    }

    /// Writes an instruction on vectors whose last operand has `memory` bytes. The registers are the first operand and
    /// the first source.
    fn write_reading(
        &mut self,
        memory: usize,
        opcode: Opcode,
        bytes: usize,
        [register, source]: [u8; 2],
        place: Place,
        immediate: Option<u8>,
    ) {
        let highest = match place {
            Place::Register(last) => register.max(source).max(last),
            Place::Memory(..) => register.max(source),
        };
        let vector = bytes.max(16);
        let encoding = match self.level {
            Level::Sse2 => Encoding::Legacy,
            _ if highest > 15 || vector > 32 => Encoding::Evex,
            _ => Encoding::Vex,
        };
        let operands = Operands { vector, register, source, place, memory, immediate };
        self.encoder.vector(encoding, opcode, &operands);
    }

    /// Returns the instruction that loads or stores a value of this number of bytes.
    fn moving(&self, byte: u8, bytes: usize) -> Opcode {
        match bytes {
            4 => arithmetic(byte, true, 4),
            8 => scalar_double(byte),
            _ => arithmetic(byte, false, self.size),
        }
    }

    fn load(&mut self, register: u8, value: Value) {
        let (bytes, place) = (self.registers.bytes(value), self.memory(value));
        self.counts.loads += 1;
        self.write(self.moving(op::LOAD, bytes), bytes, [register, 0], place, None);
    }

    fn store(&mut self, register: u8, bytes: usize, place: Place) {
        self.write(self.moving(op::STORE, bytes), bytes, [register, 0], place, None);
    }

    fn copy(&mut self, to: u8, from: u8, bytes: usize) {
        self.counts.copies += 1;
        let opcode = arithmetic(op::COPY, false, self.size);
        self.write(opcode, bytes, [to, 0], Place::Register(from), None);
    }

    fn store_result(&mut self, value: Value, register: u8, distance: u32) {
        let bytes = self.registers.bytes(value);
        self.store(register, bytes, Place::Memory(RCX, distance as i32));
    }

    /// Returns a register that can be overwritten.
    fn fresh(&mut self, pinned: u32) -> u8 {
        if let Some(register) = self.registers.unoccupied(pinned) {
            return register;
        }
        let (register, value) = self.registers.furthest(pinned);
        if self.registers.is_only_in_register(value) {
            self.spill(value, register);
        }
        self.registers.evict(value);
        register
    }

    fn spill(&mut self, value: Value, register: u8) {
        let slot = self.registers.give_slot(value);
        self.counts.spills += 1;
        let bytes = self.registers.bytes(value);
        self.store(register, bytes, Place::Memory(RAX, slot as i32 - SHORT));
    }

    /// Returns the register of a value, which is loaded if it is in none, for this instruction or for longer.
    fn force(&mut self, value: Value, pinned: &mut u32) -> u8 {
        let mut register = self.registers.register(value);
        if register == NONE {
            register = self.fresh(*pinned);
            self.load(register, value);
            if !self.registers.dies(value) {
                self.registers.hold(register, value);
            }
        }
        *pinned |= 1 << register;
        register
    }

    /// Returns whether an instruction can read this operand from memory.
    fn can_fold(&self, value: Value, bitwise: bool) -> bool {
        let scalar = self.lanes(value) == 1;
        let aligned = self.level != Level::Sse2 || scalar && !bitwise;
        match self.values.definitions[value as usize] {
            Definition::Constant(_) if scalar && bitwise => {
                self.values.bits(value).is_some_and(|bits| bits.len() * self.size >= 16)
            }
            Definition::Constant(_) => true,
            _ if scalar && bitwise => false,
            Definition::Result(..) => {
                aligned || matches!(self.registers.home(value), Home::Slot(_))
            }
            Definition::Argument { .. } | Definition::Lane(..) => aligned,
        }
    }

    /// Returns an operand as the last operand of an instruction.
    fn operand(&mut self, value: Value, bitwise: bool, pinned: &mut u32) -> Place {
        let register = self.registers.register(value);
        if register == NONE && self.can_fold(value, bitwise) {
            self.counts.memory_operands += 1;
            return self.memory(value);
        }
        Place::Register(self.force(value, pinned))
    }

    /// Computes a value.
    fn compute(&mut self, value: Value) {
        let Definition::Result(operation, _) = self.values.definitions[value as usize] else {
            return;
        };
        let operands = self.values.operands(value);
        let mut pinned = self.registers.pinned(operands);
        self.prefetch(operation, operands, &mut pinned);
        let register = match operation {
            Operation::MultiplyAdd { negative_product, negative_addend } => {
                let operands = [operands[0], operands[1], operands[2]];
                self.multiply_add(value, operands, (negative_product, negative_addend), pinned)
            }
            Operation::SquareRoot | Operation::Broadcast => {
                self.unary(operation, value, operands[0], pinned)
            }
            Operation::ShiftToSign => self.shift_to_sign(value, operands[0], pinned),
            Operation::Atan2 | Operation::Logarithm => {
                self.call(operation, value, operands, pinned)
            }
            _ => self.binary(operation, value, [operands[0], operands[1]], pinned),
        };
        for (i, &operand) in operands.iter().enumerate() {
            if self.registers.dies(operand) && !operands[..i].contains(&operand) {
                self.registers.drop(operand);
            }
        }
        self.registers.hold(register, value);
        if self.registers.has_lanes(value) {
            self.spill(value, register);
        }
        for distance in std::mem::take(&mut self.stores[value as usize]) {
            self.store_result(value, register, distance);
            self.registers.stored(value, distance);
        }
        if self.registers.dies(value) {
            self.registers.drop(value);
        }
    }

    /// Loads operands that are read again soon, if registers are free.
    fn prefetch(&mut self, operation: Operation, operands: &[Value], pinned: &mut u32) {
        for &operand in operands {
            let soon = self.registers.distance(operand).is_some_and(|distance| distance <= SOON);
            let absent = self.registers.register(operand) == NONE;
            if soon
                && absent
                && operation != Operation::Broadcast
                && let Some(register) = self.registers.unoccupied(*pinned)
            {
                self.load(register, operand);
                self.registers.hold(register, operand);
                *pinned |= 1 << register;
            }
        }
    }

    /// Returns the register of an operand that is read for the last time, or a free one.
    fn destination(&mut self, operands: &[Value], pinned: u32) -> u8 {
        let dying = operands.iter().filter(|&&operand| self.registers.dies(operand));
        let mut held = dying.map(|&operand| self.registers.register(operand));
        match held.find(|&register| register != NONE) {
            Some(register) => register,
            None => self.fresh(pinned),
        }
    }

    /// Writes an operation of two operands.
    fn binary(
        &mut self,
        operation: Operation,
        value: Value,
        [mut a, mut b]: [Value; 2],
        mut pinned: u32,
    ) -> u8 {
        let legacy = self.level == Level::Sse2;
        if operation.commutes() {
            let [in_a, in_b] = [a, b].map(|x| self.registers.register(x));
            // The first operand is in a register. Low registers have shorter encodings as the second operand.
            // Instructions with two operands overwrite the first.
            let swap = match (in_a == NONE, in_b == NONE) {
                (true, false) => true,
                (false, false) if legacy => !self.registers.dies(a) && self.registers.dies(b),
                (false, false) => in_a < 8 && in_b >= 8,
                _ => false,
            };
            if swap {
                std::mem::swap(&mut a, &mut b);
            }
        }
        let bitwise = operation.is_bitwise();
        let (bytes, scalar) = (self.registers.bytes(value), self.lanes(value) == 1);
        let temporary = self.registers.register(a) == NONE && self.registers.dies(a);
        let first = self.force(a, &mut pinned);
        let second = match operation {
            _ if a == b => Place::Register(first),
            Operation::Join if bytes > 16 => self.operand(b, false, &mut pinned),
            // Two numbers of 8 bytes, or halves of them.
            Operation::Join if bytes == 16 && self.registers.register(b) == NONE => {
                self.counts.memory_operands += 1;
                self.memory(b)
            }
            Operation::Join => Place::Register(self.force(b, &mut pinned)),
            _ => self.operand(b, bitwise, &mut pinned),
        };
        let register = if temporary {
            first
        } else {
            self.destination(&[a, b][..if legacy { 1 } else { 2 }], pinned)
        };
        let source = if legacy && register != first {
            self.copy(register, first, bytes);
            register
        } else {
            first
        };
        let (opcode, immediate) = match operation {
            Operation::Join => self.join(bytes, second),
            Operation::LessOrEqual => {
                (arithmetic(op::COMPARE, scalar, self.size), Some(LESS_OR_EQUAL))
            }
            Operation::Unordered => (arithmetic(op::COMPARE, scalar, self.size), Some(UNORDERED)),
            Operation::Add => (arithmetic(op::ADD, scalar, self.size), None),
            Operation::Subtract => (arithmetic(op::SUBTRACT, scalar, self.size), None),
            Operation::Multiply => (arithmetic(op::MULTIPLY, scalar, self.size), None),
            Operation::Divide => (arithmetic(op::DIVIDE, scalar, self.size), None),
            Operation::Maximum => (arithmetic(op::MAXIMUM, scalar, self.size), None),
            Operation::And => (arithmetic(op::AND, false, self.size), None),
            Operation::AndNot => (arithmetic(op::AND_NOT, false, self.size), None),
            Operation::Or => (arithmetic(op::OR, false, self.size), None),
            Operation::Xor => (arithmetic(op::XOR, false, self.size), None),
            _ => unreachable!("an operation of two operands"),
        };
        let memory = match operation {
            Operation::Join => bytes / 2,
            _ if bitwise => bytes.max(16),
            _ => bytes,
        };
        let compares = matches!(operation, Operation::LessOrEqual | Operation::Unordered);
        if compares && self.level == Level::Avx512 {
            self.compare(register, (first, second), opcode, immediate, bytes);
        } else {
            self.write_reading(memory, opcode, bytes, [register, source], second, immediate);
        }
        register
    }

    /// Returns the instruction that joins two halves.
    fn join(&self, bytes: usize, second: Place) -> (Opcode, Option<u8>) {
        match (bytes, second) {
            (8, _) => (arithmetic(op::UNPACK_LOW, false, 4), None),
            (16, Place::Register(_)) => (op::UNPACK_LOW_DOUBLE, None),
            (16, Place::Memory(..)) => (op::LOAD_HIGH, None),
            (32, _) => (op::INSERT_128, Some(1)),
            _ => (op::INSERT_256, Some(1)),
        }
    }

    /// Writes a comparison whose result is a vector. AVX-512 compares into masks; only registers below 16 can be
    /// compared without them.
    fn compare(
        &mut self,
        register: u8,
        (first, second): (u8, Place),
        opcode: Opcode,
        predicate: Option<u8>,
        bytes: usize,
    ) {
        // k1
        let operands = Operands {
            vector: bytes.max(16),
            register: 1,
            source: first,
            place: second,
            memory: bytes,
            immediate: predicate,
        };
        self.encoder.vector(Encoding::Evex, opcode, &operands);
        let operands = Operands {
            register,
            source: 0,
            place: Place::Register(1),
            immediate: None,
            ..operands
        };
        self.encoder.vector(Encoding::Evex, mask_to_vector(self.size), &operands);
    }

    fn unary(&mut self, operation: Operation, value: Value, a: Value, mut pinned: u32) -> u8 {
        let (bytes, scalar) = (self.registers.bytes(value), self.lanes(value) == 1);
        let legacy = self.level == Level::Sse2;
        if operation == Operation::Broadcast && legacy {
            let from = self.force(a, &mut pinned);
            let register = self.destination(&[a], pinned);
            if register != from {
                self.copy(register, from, bytes);
            }
            let (opcode, immediate) = match self.size {
                8 => (op::UNPACK_LOW_DOUBLE, None),
                _ => (op::SHUFFLE_SINGLE, Some(0)),
            };
            let place = Place::Register(register);
            self.write(opcode, 16, [register, register], place, immediate);
            return register;
        }
        // A square root of a scalar keeps the upper part of its first source. Both sources are the same register, so
        // that the instruction waits for no other register.
        let from = if operation == Operation::SquareRoot {
            Place::Register(self.force(a, &mut pinned))
        } else {
            self.operand(a, false, &mut pinned)
        };
        let register = self.destination(&[a], pinned);
        match (operation, from) {
            (Operation::SquareRoot, Place::Register(from)) => {
                let opcode = arithmetic(op::SQUARE_ROOT, scalar, self.size);
                let source = if scalar && !legacy { from } else { 0 };
                self.write(opcode, bytes, [register, source], Place::Register(from), None);
            }
            _ => {
                let opcode = if bytes == 16 && self.size == 8 {
                    op::DUPLICATE
                } else {
                    broadcast(self.size)
                };
                self.write_reading(self.size, opcode, bytes, [register, 0], from, None);
            }
        }
        register
    }

    fn shift_to_sign(&mut self, value: Value, a: Value, mut pinned: u32) -> u8 {
        let bytes = self.registers.bytes(value);
        let from = self.force(a, &mut pinned);
        let register = self.destination(&[a], pinned);
        // The destination is in the field of the first source, and the opcode's extension is in the field of the
        // destination.
        let (count, opcode) = ((8 * self.size - 1) as u8, shift_left(self.size));
        if self.level == Level::Sse2 {
            if register != from {
                self.copy(register, from, bytes);
            }
            self.write(opcode, bytes, [6, 0], Place::Register(register), Some(count));
        } else {
            self.write(opcode, bytes, [6, register], Place::Register(from), Some(count));
        }
        register
    }

    /// Writes a product and a sum in one instruction, which overwrites one of its three operands and can read the last
    /// one from memory.
    fn multiply_add(
        &mut self,
        value: Value,
        operands: [Value; 3],
        signs: (bool, bool),
        mut pinned: u32,
    ) -> u8 {
        let (bytes, scalar) = (self.registers.bytes(value), self.lanes(value) == 1);
        let held = |this: &Self, i: usize| this.registers.register(operands[i]) != NONE;
        let equal = |i: usize, j: usize| i != j && operands[i] == operands[j];
        let has_equal = |i: usize| (0..3).any(|j| equal(i, j));
        // The loads and copies that an order of operands needs.
        let cost = |this: &Self, over: usize, memory: Option<usize>| {
            let of = |i: usize| {
                let spare = this.registers.dies(operands[i]) && !has_equal(i);
                let loaded_before = (0..i).any(|j| Some(j) != memory && equal(i, j));
                match (i == over, held(this, i)) {
                    _ if Some(i) == memory => 0,
                    (true, true) if spare => 0,
                    (true, true) => 2,
                    (true, false) if spare => 2,
                    (true, false) => 4,
                    (false, false) if !loaded_before => 3,
                    (false, _) => 0,
                }
            };
            (0..3).map(of).sum::<u32>()
        };
        let from_memory = (0..3).filter(|&i| !held(self, i)).map(Some).chain([None]);
        let choices = from_memory.flat_map(|memory| (0..3).map(move |over| (over, memory)));
        let choices = choices.filter(|&(over, memory)| Some(over) != memory);
        let (over, memory) = choices
            .min_by_key(|&(over, memory)| {
                (cost(self, over, memory), over, memory.is_none(), memory)
            })
            .expect("there are choices");
        let mut registers = [NONE; 3];
        for i in (0..3).filter(|&i| i != over && Some(i) != memory) {
            registers[i] = self.force(operands[i], &mut pinned);
        }
        let overwritten = operands[over];
        let same = (0..3).find(|&i| equal(i, over) && registers[i] != NONE);
        let register = match (self.registers.register(overwritten), same) {
            (NONE, None) => {
                let register = self.fresh(pinned);
                self.load(register, overwritten);
                register
            }
            (NONE, Some(same)) => {
                let register = self.fresh(pinned);
                self.copy(register, registers[same], bytes);
                register
            }
            (held, _) if self.registers.dies(overwritten) && !has_equal(over) => held,
            (held, _) => {
                let register = self.fresh(pinned | 1 << held);
                self.copy(register, held, bytes);
                register
            }
        };
        let place = |i: usize, this: &mut Self| match memory {
            Some(m) if m == i => {
                this.counts.memory_operands += 1;
                this.memory(operands[i])
            }
            _ => Place::Register(registers[i]),
        };
        // The orders 231: d = a b + d, 213: d = a d + c, 132: d = d b + c.
        let (form, source, last) = match over {
            2 if memory == Some(0) => (0xb0, registers[1], place(0, self)),
            2 => (0xb0, registers[0], place(1, self)),
            _ if memory == Some(1 - over) => (0x90, registers[2], place(1 - over, self)),
            _ => (0xa0, registers[1 - over], place(2, self)),
        };
        let opcode = multiply_add(form, signs, scalar, self.size);
        self.write(opcode, bytes, [register, source], last, None);
        register
    }

    /// Writes the load of an address.
    fn address(&mut self, register: u8, place: Place) {
        if let Place::Memory(base, distance) = place {
            self.encoder.general(0x8d, register, base, distance);
        }
    }

    /// Writes a call of a helper, whose pointers are in registers already, and restores the registers that point to
    /// memory.
    fn call_helper(&mut self, helper: u64, lanes: u8) {
        // mov ecx, lanes
        self.encoder.bytes(&[&[0xb9][..], &u32::from(lanes).to_le_bytes()].concat());
        if self.level != Level::Sse2 {
            // vzeroupper
            self.encoder.bytes(&[0xc5, 0xf8, 0x77]);
        }
        // mov rax, helper; call rax
        self.encoder.bytes(&[&[0x48, 0xb8][..], &helper.to_le_bytes()].concat());
        self.encoder.bytes(&[0xff, 0xd0]);
        let (arrays, frame) = (self.arrays, self.frame_base());
        point(&mut self.encoder, arrays, frame);
    }

    /// Returns the offset from rax.
    fn frame_base(&self) -> i32 {
        64 + self.saved as i32 + SHORT
    }

    fn save(&mut self, registers: u32) {
        for register in (0..32).filter(|register| registers >> register & 1 == 1) {
            let (place, bytes) = (self.saved(register), self.vector);
            self.write(self.moving(op::STORE, bytes), bytes, [register, 0], place, None);
        }
    }

    fn restore(&mut self, registers: u32) {
        for register in (0..32).filter(|register| registers >> register & 1 == 1) {
            let (place, bytes) = (self.saved(register), self.vector);
            self.write(self.moving(op::LOAD, bytes), bytes, [register, 0], place, None);
        }
    }

    /// Writes an operation that is a call of a helper.
    fn call(
        &mut self,
        operation: Operation,
        value: Value,
        operands: &[Value],
        mut pinned: u32,
    ) -> u8 {
        let from: Vec<u8> =
            operands.iter().map(|&operand| self.force(operand, &mut pinned)).collect();
        let register = self.fresh(pinned);
        let read = from.iter().fold(0, |all, register| all | 1 << register);
        let occupied = self.registers.occupied();
        self.save(occupied | read);
        self.address(RDI, self.saved(register));
        self.address(RSI, self.saved(from[0]));
        self.address(RDX, self.saved(*from.last().unwrap_or(&from[0])));
        let helper = match operation {
            Operation::Atan2 => self.helpers.atan2,
            _ => self.helpers.logarithm,
        };
        self.call_helper(helper, self.lanes(value));
        self.restore(occupied | 1 << register);
        register
    }

    /// Compares the angles with the limit, and jumps to the code after the return if one is too large.
    fn check(&mut self, check: &FarCheck) {
        let FarCheck { squares, limit, angles } = check;
        let (bytes, lanes) = (self.registers.bytes(*squares), self.lanes(*squares));
        let mut pinned = self.registers.pinned(&[*squares, *limit]);
        let first = self.force(*squares, &mut pinned);
        if lanes == 1 {
            // The flags say "above" if limit > squares, and not if one is NaN.
            let last = self.force(*limit, &mut pinned);
            let opcode = arithmetic(op::COMPARE_FLAGS, false, self.size);
            self.write(opcode, self.size, [last, 0], Place::Register(first), None);
            // jbe
            self.encoder.bytes(&[0x0f, 0x86, 0, 0, 0, 0]);
        } else {
            let last = self.operand(*limit, false, &mut pinned);
            let opcode = arithmetic(op::COMPARE, false, self.size);
            if self.level == Level::Avx512 {
                let operands = Operands {
                    vector: bytes,
                    register: 1,
                    source: first,
                    place: last,
                    memory: bytes,
                    immediate: Some(LESS),
                };
                self.encoder.vector(Encoding::Evex, opcode, &operands);
                // kmovw r11d, k1
                self.encoder.bytes(&[0xc5, 0x78, 0x93, 0xd9]);
            } else {
                let to = if self.registers.dies(*squares) { first } else { self.fresh(pinned) };
                let legacy = self.level == Level::Sse2 && to != first;
                if legacy {
                    self.copy(to, first, bytes);
                }
                let source = if legacy { to } else { first };
                self.write(opcode, bytes, [to, source], last, Some(LESS));
                let opcode = arithmetic(op::SIGNS, false, self.size);
                self.write(opcode, bytes, [R11, 0], Place::Register(to), None);
            }
            // cmp r11d, all; jne
            let all = (1_u32 << lanes) - 1;
            self.encoder.bytes(&[&[0x41, 0x81, 0xfb][..], &all.to_le_bytes()].concat());
            self.encoder.bytes(&[0x0f, 0x85, 0, 0, 0, 0]);
        }
        let back = self.encoder.code.len();
        for value in [*squares, *limit] {
            if self.registers.dies(value) {
                self.registers.drop(value);
            }
        }
        let places = angles.iter().map(|reduced| {
            let all = [reduced.angle, reduced.results[0], reduced.results[1]];
            let places = all.map(|value| match self.registers.register(value) {
                NONE => self.memory(value),
                register => self.saved(register),
            });
            (places, self.lanes(reduced.angle))
        });
        let angles_in_places = places.collect();
        let occupied = self.registers.occupied();
        self.detours.push(Detour { from: back - 4, back, occupied, angles: angles_in_places });
        for reduced in angles {
            for value in reduced.results {
                // The code after the return changes it in memory.
                if self.registers.register(value) != NONE {
                    self.registers.forget_home(value);
                }
            }
            for value in [reduced.angle, reduced.results[0], reduced.results[1]] {
                if self.registers.dies(value) {
                    self.registers.drop(value);
                }
            }
        }
    }

    /// Writes the code that reduces angles that are too large.
    fn detours(&mut self) {
        for Detour { from, back, occupied, angles } in std::mem::take(&mut self.detours) {
            let start = self.encoder.code.len();
            self.encoder.patch(from, start);
            self.save(occupied);
            for ([angle, reduced, turns], lanes) in angles {
                // The angle is first: it may be an argument, whose base register the following loads overwrite.
                self.address(RDX, angle);
                self.address(RDI, reduced);
                self.address(RSI, turns);
                self.call_helper(self.helpers.reduce, lanes);
            }
            self.restore(occupied);
            self.encoder.bytes(&[0xe9, 0, 0, 0, 0]);
            let end = self.encoder.code.len();
            self.encoder.patch(end - 4, back);
        }
    }

    /// Writes the function: entry, body, return, code for large angles, constants.
    fn finish(mut self, pool: &[u8]) -> Generated {
        if self.level != Level::Sse2 {
            self.encoder.bytes(&[0xc5, 0xf8, 0x77]);
        }
        // mov rsp, rbp; pop rbx; pop rbp; ret
        for bytes in [&[0x48, 0x89, 0xec][..], &[0x5b], &[0x5d], &[0xc3]] {
            self.encoder.bytes(bytes);
        }
        let mut entry = Encoder::default();
        // push rbp; push rbx; mov rbp, rsp; and rsp, -64
        for bytes in [&[0x55][..], &[0x53], &[0x48, 0x89, 0xe5], &[0x48, 0x83, 0xe4, 0xc0]] {
            entry.bytes(bytes);
        }
        let frame = (64 + self.saved as u32 + self.registers.frame).next_multiple_of(64);
        allocate(&mut entry, frame);
        entry.general(0x89, RDI, RSP, 0);
        entry.general(0x89, RSI, RSP, 8);
        // lea rbx, [rip + constants + 128]
        entry.bytes(&[0x48, 0x8d, 0x1d, 0, 0, 0, 0]);
        let constants_at = entry.code.len() - 4;
        point(&mut entry, self.arrays, self.frame_base());
        let instructions = entry.instructions + self.encoder.instructions;
        self.detours();
        let mut code = Encoder { code: [entry.code, self.encoder.code].concat(), instructions };
        let bytes = code.code.len();
        // int3
        code.code.resize(bytes.next_multiple_of(64), 0xcc);
        let start = code.code.len();
        code.patch(constants_at, start + SHORT as usize);
        code.code.extend_from_slice(pool);
        let size = CodeSize {
            bytes,
            constants: pool.len(),
            frame: frame as usize,
            instructions,
            ..self.counts
        };
        Generated { code: code.code, size }
    }
}

/// Moves the stack pointer down. The code touches each page, so that an overflow is found at the guard page.
fn allocate(entry: &mut Encoder, frame: u32) {
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
fn point(encoder: &mut Encoder, arrays: usize, frame_base: i32) {
    encoder.general(0x8b, R11, RSP, 0);
    encoder.general(0x8b, RCX, RSP, 8);
    encoder.general(0x8d, RAX, RSP, frame_base);
    for (&register, k) in BASES.iter().zip(0..arrays as i32) {
        encoder.general(0x8b, register, R11, 8 * k);
    }
}
