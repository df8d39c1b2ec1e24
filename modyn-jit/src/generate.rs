//! Generates machine code from values in one pass over the steps, which assigns registers and
//! writes instructions.
//!
//! The pass is the same for all architectures: it knows where values are, and frees the register
//! whose value has the most distant next use. An architecture (`architecture.rs`) writes the
//! instructions; it decides which operands they read from memory and which they overwrite.
//!
//! A function has two arguments: a pointer to a table of pointers to its arguments, and a pointer
//! to its results. Constants follow the instructions.
//!
//! One comparison after the reductions of a statement finds angles that are too large for the fast
//! reduction. Code after the return then saves the registers, reduces these angles by a call, and
//! jumps back.
//!
//! A function that computes independent constraint rows alone has a guard. It calls the function
//! for rows of any rank with the same arguments and results, and returns, if a row is not known to
//! be independent.

pub(crate) mod aarch64;
mod architecture;
mod calls;
mod data;
mod far_angles;
mod operands;
pub(crate) mod x86_64;

use crate::code_size::CodeSize;
use crate::helper::{Helper, Linkage};
use crate::instruction_set::InstructionSet;
use crate::registers::Registers;
use crate::values::{Definition, Operation, Step, Value, Values};
use architecture::Architecture;
use data::{pool, stores};
use far_angles::SlowPath;

/// The largest number of arrays of arguments.
pub(crate) const MAX_ARRAYS: usize = 8;

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

/// The byte between functions and constants, which is never run: `int3` on x86-64.
pub(crate) const PADDING: u8 = 0xcc;

/// Generates the machine code of values. `size` is the size of a number in bytes. `any_rank` is the
/// distance from the start of the function to the start of the function which its guards call.
pub(crate) fn generate(
    values: &Values,
    instruction_set: InstructionSet,
    size: usize,
    arrays: usize,
    linkage: &Linkage,
    any_rank: Option<i64>,
) -> Generated {
    let generate = match instruction_set {
        InstructionSet::Sse2 | InstructionSet::Avx2 | InstructionSet::Avx512 => {
            Generator::<x86_64::Encoder>::generate
        }
        InstructionSet::Neon => Generator::<aarch64::Encoder>::generate,
    };
    generate(values, instruction_set, size, arrays, linkage, any_rank)
}

struct Generator<'a, A> {
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
    /// The registers that are written, as bits.
    written: u32,
    encoder: A,
    pool_at: Vec<u32>,
    /// For each value the offsets at which it is a result.
    stores: Vec<Vec<u32>>,
    slow_paths: Vec<SlowPath>,
    /// The positions of the guards' jumps.
    guards: Vec<usize>,
    /// The calls of helpers whose distances are still to be filled in.
    calls: Vec<(usize, Helper)>,
    #[cfg(test)]
    steps: Vec<usize>,
    counts: CodeSize,
}

impl<'a, A: Architecture> Generator<'a, A> {
    fn generate(
        values: &'a Values,
        instruction_set: InstructionSet,
        size: usize,
        arrays: usize,
        linkage: &'a Linkage,
        any_rank: Option<i64>,
    ) -> Generated {
        assert!(arrays <= MAX_ARRAYS, "no function has so many arrays");
        let vector =
            values.lanes.iter().map(|&lanes| usize::from(lanes) * size).max().unwrap_or(16);
        let calls = values.steps.iter().any(|step| match step {
            Step::Check(_) => true,
            Step::Guard(_) => false,
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
            saved: if calls { instruction_set.registers().len() * vector } else { 0 },
            registers: Registers::new(values, size, instruction_set.registers(), &last),
            written: 0,
            encoder: A::default(),
            pool_at,
            stores,
            slow_paths: Vec::new(),
            guards: Vec::new(),
            calls: Vec::new(),
            #[cfg(test)]
            steps: Vec::new(),
            counts: CodeSize::default(),
        };
        for (position, step) in (0..).zip(&values.steps) {
            #[cfg(test)]
            generator.steps.push(generator.encoder.position());
            generator.registers.advance(position, &values.reads(step));
            match step {
                Step::Compute(value) => generator.compute(*value),
                Step::Check(check) => generator.check(check),
                Step::Guard(values) => generator.guard(*values),
            }
        }
        #[cfg(test)]
        generator.steps.push(generator.encoder.position());
        generator.registers.position = values.steps.len() as u32;
        for (value, distance) in late {
            let register = generator.force(value, &mut 0);
            generator.store_result(value, register, distance);
        }
        generator.finish(&pool, any_rank)
    }

    /// Computes a value.
    fn compute(&mut self, value: Value) {
        let Definition::Result(operation, _) = self.values.definitions[value as usize] else {
            return;
        };
        let operands = self.values.operands(value);
        let pinned = self.registers.pinned(operands);
        let register = match operation {
            Operation::Atan2 | Operation::Logarithm => {
                self.call(operation, value, operands, pinned)
            }
            _ => A::operation(self, operation, value, pinned),
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

    /// Writes a guard: the first value is less than the second.
    fn guard(&mut self, values: [Value; 2]) {
        let from = A::jump_unless_less(self, values);
        self.guards.push(from);
        self.registers.drop_dead(&values);
    }

    /// Writes the function: entry, body, return, code for large angles and for dependent rows,
    /// constants.
    fn finish(mut self, pool: &[u8], any_rank: Option<i64>) -> Generated {
        let leave = self.encoder.position();
        A::leave(&mut self);
        let end = self.encoder.position();
        let unaligned = A::HEADER + self.saved + self.registers.frame as usize;
        let frame = unaligned.next_multiple_of(A::ALIGNMENT);
        let (entry, constants_at) = A::entry(&self, frame as u32);
        let instructions = entry.instructions() + self.encoder.instructions();
        self.slow_paths();
        assert_eq!(self.guards.is_empty(), any_rank.is_none(), "guards call a function");
        let guarded = self.encoder.position();
        for from in std::mem::take(&mut self.guards) {
            self.encoder.patch(from, guarded);
        }
        let call = any_rank.map(|distance| {
            let at = A::call_again(&mut self);
            let jump = self.encoder.jump();
            self.encoder.patch(jump, leave);
            (at, distance)
        });
        let mut code = entry.finish();
        let body = code.len();
        code.extend(self.encoder.finish());
        if let Some((at, distance)) = call {
            A::point_call(&mut code, body + at, distance);
        }
        let bytes = code.len();
        code.resize(bytes.next_multiple_of(64), PADDING);
        let constants = code.len();
        A::point_to_constants(&mut code, constants_at, constants);
        code.extend_from_slice(pool);
        let size = CodeSize { bytes, constants: pool.len(), frame, instructions, ..self.counts };
        Generated {
            code,
            size,
            end: body + end,
            calls: self.calls.iter().map(|&(at, helper)| (body + at, helper)).collect(),
            #[cfg(test)]
            steps: self.steps.iter().map(|at| body + at).collect(),
        }
    }
}
