//! Generates machine code from values in one pass over the steps, which assigns registers and writes instructions.
//!
//! A function has two arguments: a pointer to a table of pointers to its arguments (rdi), and a pointer to its results
//! (rsi). It follows System V's calling convention on every system. Registers in its body: rax points into the stack
//! frame, rbx to the constants, rcx to the results, and one register each to the arguments (r14 and r15, which belong to
//! the caller, to the seventh and the eighth); rbp is the frame pointer, as
//! profilers know it: it points to the caller's; r11 is free.
//!
//! The frame, upwards from rsp, which is a multiple of 64: the two pointers, memory for all vector registers during
//! calls, slots of values.
//!
//! One comparison after the reductions of a statement finds angles that are too large for the fast reduction. Code
//! after the return then saves the registers, reduces these angles by a call, and jumps back.

mod arithmetic;
mod calls;
mod data;
mod far_angles;
mod frame;
mod operands;

use crate::code_size::CodeSize;
use crate::encode::Encoder;
use crate::helper::{Helper, Linkage};
use crate::instruction_set::InstructionSet;
use crate::registers::{NONE, Registers};
use crate::values::{Definition, Operation, Step, Value, Values};
use data::{pool, stores};
use far_angles::SlowPath;

#[cfg(feature = "object")]
pub(crate) use frame::allocate;
#[cfg(feature = "object")]
pub(crate) use frame::{KEEP_BASES, PROLOGUE};
pub(crate) use frame::{MAX_ARRAYS, keeps_bases};

/// A function: instructions, then constants. It can start at any multiple of 64.
pub(crate) struct Generated {
    pub code: Vec<u8>,
    pub size: CodeSize,
    /// The offset after its return.
    pub end: usize,
    /// The calls of helpers with [`Linkage::Relative`]: the offset of each call's distance.
    pub calls: Vec<(usize, Helper)>,
    /// The offset of each step's first instruction, and of the first one after all steps.
    #[cfg(test)]
    pub steps: Vec<usize>,
}

/// A value in memory that is read again within this number of steps is loaded into a free register.
const RELOAD_DISTANCE: u32 = 40;

/// Generates the machine code of values. `size` is the size of a number in bytes.
pub(crate) fn generate(
    values: &Values,
    instruction_set: InstructionSet,
    size: usize,
    arrays: usize,
    linkage: &Linkage,
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
        instruction_set,
        size,
        arrays,
        linkage,
        vector,
        saved: if calls { usize::from(instruction_set.registers()) * vector } else { 0 },
        registers: Registers::new(values, size, instruction_set.registers(), &last),
        encoder: Encoder::default(),
        pool_at,
        stores,
        slow_paths: Vec::new(),
        calls: Vec::new(),
        #[cfg(test)]
        steps: Vec::new(),
        counts: CodeSize::default(),
    };
    for (position, step) in (0..).zip(&values.steps) {
        #[cfg(test)]
        generator.steps.push(generator.encoder.code.len());
        generator.registers.advance(position, &values.reads(step));
        match step {
            Step::Compute(value) => generator.compute(*value),
            Step::Check(check) => generator.check(check),
        }
    }
    #[cfg(test)]
    generator.steps.push(generator.encoder.code.len());
    generator.registers.position = values.steps.len() as u32;
    for (value, distance) in late {
        let register = generator.force(value, &mut 0);
        generator.store_result(value, register, distance);
    }
    generator.finish(&pool)
}

struct Generator<'a> {
    values: &'a Values,
    instruction_set: InstructionSet,
    size: usize,
    arrays: usize,
    linkage: &'a Linkage,
    /// The size of the longest vector in bytes.
    vector: usize,
    /// The size of all registers in the frame in bytes.
    saved: usize,
    registers: Registers<'a>,
    encoder: Encoder,
    pool_at: Vec<u32>,
    /// For each value the offsets at which it is a result.
    stores: Vec<Vec<u32>>,
    slow_paths: Vec<SlowPath>,
    /// The calls of helpers whose distances are still to be filled in.
    calls: Vec<(usize, Helper)>,
    #[cfg(test)]
    steps: Vec<usize>,
    counts: CodeSize,
}

impl Generator<'_> {
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
            let soon = self
                .registers
                .distance(operand)
                .is_some_and(|distance| distance <= RELOAD_DISTANCE);
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
}
