//! The loops of a program in an entry: the code that `LoopedCode::call` runs for one state.
//!
//! The numbers of the call are in the frame of the entry, upwards from [`BODIES`]: the counter of
//! each loop around the present step, the memory of `looped.rs`, and the results of a routine.

use super::assembler::{
    ADDRESS, Assembler, Condition, IMMEDIATE_SUBTRACT, LOAD, LOAD_VECTOR, Label, Opcode, Operand,
    R11, RAX, RCX, RDI, RSI, RSP, STORE, STORE_VECTOR, TEST, XOR_VECTOR,
};
use super::convention::{BODIES, RESULTS};
use crate::looped::{Copied, LoopPlan, PlannedStep};
use Operand::{Memory, Register};

/// The largest number of bytes that are copied by instructions of their own.
const MAX_UNROLLED: usize = 256;

/// A program with loops, as the code of an entry.
pub(super) struct LoopedBody<'a> {
    pub before: Label,
    pub after: Label,
    /// The code of each routine.
    pub routines: Vec<Label>,
    /// The number of scalars of each pointer of the entry's table.
    pub arguments: Vec<usize>,
    pub plan: &'a LoopPlan,
    /// The largest number of results of a routine.
    pub routine_results: usize,
    /// The bytes of a number.
    pub number: usize,
}

/// Memory in the frame or behind a pointer: a register and a distance in bytes.
#[derive(Clone, Copy)]
struct Place(u8, i32);

impl LoopedBody<'_> {
    /// Returns the bytes of the frame.
    pub fn size(&self) -> usize {
        self.memory() + (self.plan.layout.length + self.routine_results) * self.number
    }

    /// Returns the bytes of the counters, and so the start of the memory.
    fn memory(&self) -> usize {
        (8 * depth(&self.plan.steps)).next_multiple_of(16)
    }

    /// Returns the place of a number of the memory; the results of a routine follow the memory.
    fn place(&self, number: usize) -> Place {
        Place(RSP, BODIES + (self.memory() + number * self.number) as i32)
    }

    /// Appends the code. The table has the pointers to the arguments, and rsi the pointer to the
    /// results.
    pub fn append(&self, a: &mut Assembler) {
        let LoopPlan { layout, stored, steps } = self.plan;
        a.instruction(STORE, true, RSI, Memory(RSP, RESULTS));
        let mut given = 0;
        for (k, &count) in self.arguments.iter().enumerate().filter(|(_, count)| **count > 0) {
            a.instruction(LOAD, true, R11, Memory(RSP, 8 * k as i32));
            self.copy(a, Place(R11, 0), self.place(given), count);
            given += count;
        }
        self.call(a, self.before, layout.before);
        let zeros = (layout.length - layout.arrays) * self.number;
        if zeros > 0 {
            self.address(a, RDI, self.place(layout.arrays));
            a.constant(RCX, zeros as u64);
            a.constant(RAX, 0);
            a.fill_bytes();
        }
        for &Copied { from, to, count } in stored {
            self.copy(a, self.place(from), self.place(to), count);
        }
        self.steps(a, steps, 0);
        self.point(a);
        a.instruction(LOAD, true, RSI, Memory(RSP, RESULTS));
        a.call(self.after);
    }

    /// Appends calls and loops within so many loops.
    fn steps(&self, a: &mut Assembler, steps: &[PlannedStep], depth: i32) {
        for step in steps {
            match step {
                PlannedStep::Call { routine, writes } => {
                    let results = self.plan.layout.length;
                    self.call(a, self.routines[*routine], results);
                    for &Copied { from, to, count } in writes {
                        self.copy(a, self.place(results + from), self.place(to), count);
                    }
                }
                PlannedStep::Loop { count, end, steps } => {
                    let counter = Memory(RSP, BODIES + 8 * depth);
                    a.constant(RAX, *count as u64);
                    a.instruction(STORE, true, RAX, counter);
                    let [again, done] = [(); 2].map(|()| a.label());
                    a.bind(again);
                    a.instruction(LOAD, true, RAX, counter);
                    a.instruction(TEST, true, RAX, Register(RAX));
                    a.jump_if(Condition::Equal, done);
                    a.immediate(IMMEDIATE_SUBTRACT, true, RAX, 1);
                    a.instruction(STORE, true, RAX, counter);
                    if let Some(end) = *end {
                        self.jump_if_nonnegative(a, end, done);
                    }
                    self.steps(a, steps, depth + 1);
                    a.jump(again);
                    a.bind(done);
                }
            }
        }
    }

    /// Appends a jump to `label` if a number of the memory is at least zero, which NaN is not.
    fn jump_if_nonnegative(&self, a: &mut Assembler, number: usize, label: Label) {
        // movsd or movss, and comisd or comiss
        let (load, compare) = match self.number {
            8 => (Opcode(Some(0xf2), &[0x0f, 0x10]), Opcode(Some(0x66), &[0x0f, 0x2f])),
            _ => (Opcode(Some(0xf3), &[0x0f, 0x10]), Opcode(None, &[0x0f, 0x2f])),
        };
        let Place(base, distance) = self.place(number);
        a.instruction(load, false, 0, Memory(base, distance));
        a.instruction(XOR_VECTOR, false, 1, Register(1));
        a.instruction(compare, false, 0, Register(1));
        a.jump_if(Condition::AboveOrEqual, label);
    }

    /// Appends the call of a program whose results begin at this number of the memory.
    fn call(&self, a: &mut Assembler, program: Label, results: usize) {
        self.point(a);
        self.address(a, RSI, self.place(results));
        a.call(program);
    }

    /// Appends the pointer to the memory as the table of pointers, whose address is the argument of a
    /// program.
    fn point(&self, a: &mut Assembler) {
        self.address(a, RAX, self.place(0));
        a.instruction(STORE, true, RAX, Memory(RSP, 0));
        a.copy(RDI, RSP);
    }

    fn address(&self, a: &mut Assembler, register: u8, Place(base, distance): Place) {
        a.instruction(ADDRESS, true, register, Memory(base, distance));
    }

    /// Appends the copy of numbers.
    fn copy(&self, a: &mut Assembler, from: Place, to: Place, count: usize) {
        let bytes = count * self.number;
        if bytes > MAX_UNROLLED {
            self.address(a, RSI, from);
            self.address(a, RDI, to);
            a.constant(RCX, bytes as u64);
            a.copy_bytes();
            return;
        }
        let mut done = 0;
        while done < bytes {
            let [from, to] =
                [from, to].map(|Place(base, distance)| Memory(base, distance + done as i32));
            if bytes - done >= 16 {
                a.instruction(LOAD_VECTOR, false, 0, from);
                a.instruction(STORE_VECTOR, false, 0, to);
                done += 16;
            } else {
                let is_wide = bytes - done >= 8;
                a.instruction(LOAD, is_wide, RAX, from);
                a.instruction(STORE, is_wide, RAX, to);
                done += if is_wide { 8 } else { 4 };
            }
        }
    }
}

/// Returns the largest number of loops within each other.
fn depth(steps: &[PlannedStep]) -> usize {
    let of_step = |step: &PlannedStep| match step {
        PlannedStep::Call { .. } => 0,
        PlannedStep::Loop { steps, .. } => 1 + depth(steps),
    };
    steps.iter().map(of_step).max().unwrap_or(0)
}
