//! The functions that C calls: they take pointers by the calling convention of the target, put them
//! into the table that programs take, and call programs.
//!
//! The frame of an entry, downwards from rbp: on Windows the registers rdi, rsi and xmm6 to xmm15,
//! which belong to the caller there; then, upwards from rsp, the table of pointers, the pointer to
//! the results, and the poses of bodies or the numbers of a program with loops (`looped.rs`).

use super::assembler::{
    ADD, ADDRESS, Assembler, Condition, IMMEDIATE_COMPARE, LOAD, LOAD_SIGNED, LOAD_VECTOR, Label,
    Operand, R8, R9, R10, R11, RAX, RBP, RCX, RDI, RDX, RSI, RSP, SHIFT_LEFT, STORE, STORE_VECTOR,
};
use super::convention::{BODIES, Convention, KEPT, KEPT_GENERAL, KEPT_VECTORS, RESULTS};
use super::looped::LoopedBody;
use super::unwind::{Frame, FrameKind};
use crate::generate::x86_64::{Encoder, allocate};
use Operand::{Code, Memory, Register};

/// The source of a pointer in the table.
#[derive(Clone, Copy, Debug)]
pub(super) enum Pointer {
    /// The argument of this number.
    Argument(usize),
    /// Data in the object.
    Data(Label),
    /// No numbers: never read.
    Nothing,
}

/// An entry's code.
pub(super) struct Call<'a> {
    /// The pointers of the table.
    pub table: &'a [Pointer],
    /// The number of the link's argument, for a function of one link.
    pub link: Option<usize>,
    /// The number of the results' argument.
    pub results: usize,
    pub body: Body<'a>,
}

/// The calls of an entry.
#[derive(Clone, Copy)]
pub(super) enum Body<'a> {
    /// One program.
    One(Label),
    /// The program of a link, by a table of programs and placements.
    Link {
        /// The table, and the number of its rows.
        rows: (Label, usize),
    },
    /// The poses of bodies, then the pose of each link.
    Poses {
        bodies: Label,
        placed: Label,
        /// The size of a pose, and of all poses of bodies, bytes.
        sizes: (usize, usize),
        /// For each link the number of its pose or of its body's, and the placement on the body.
        links: &'a [(usize, Option<Label>)],
    },
    /// A program with loops.
    Looped(&'a LoopedBody<'a>),
}

/// Appends an entry, and returns its frame.
pub(super) fn entry(a: &mut Assembler, convention: Convention, call: &Call<'_>) -> Frame {
    a.align(16);
    let start = a.code.len();
    // push rbp; mov rbp, rsp
    a.bytes(&[0x55, 0x48, 0x89, 0xe5]);
    let bodies = match call.body {
        Body::Poses { sizes: (_, all), .. } => all,
        Body::Looped(looped) => looped.size(),
        Body::One(_) | Body::Link { .. } => 0,
    };
    let windows = convention == Convention::Windows;
    if windows {
        // push rdi; push rsi
        a.bytes(&[0x57, 0x56]);
    }
    let kept = if windows { KEPT - KEPT_GENERAL } else { 0 };
    let size = (kept + BODIES + bodies as i32).cast_unsigned().next_multiple_of(16);
    let mut allocation = Encoder::default();
    allocate(&mut allocation, size);
    a.bytes(&allocation.code);
    if windows {
        vectors(a, STORE_VECTOR);
    }
    let prologue = a.code.len();
    for (k, pointer) in call.table.iter().enumerate() {
        let register = match *pointer {
            Pointer::Nothing => continue,
            Pointer::Argument(number) => argument(a, convention, number, RAX),
            Pointer::Data(label) => {
                a.instruction(ADDRESS, true, RAX, Code(label, 0));
                RAX
            }
        };
        a.instruction(STORE, true, register, Memory(RSP, 8 * k as i32));
    }
    // The link's number goes to rax before its register is overwritten.
    if let Some(number) = call.link {
        let register = argument(a, convention, number, RAX);
        a.instruction(LOAD, false, RAX, Register(register));
    }
    let results = argument(a, convention, call.results, RSI);
    a.copy(RSI, results);
    a.copy(RDI, RSP);
    let end = a.label();
    let fail = a.label();
    match call.body {
        Body::One(program) => a.call(program),
        Body::Link { rows: (rows, count) } => {
            a.immediate(IMMEDIATE_COMPARE, false, RAX, count as i32);
            a.jump_if(Condition::AboveOrEqual, fail);
            a.shift(SHIFT_LEFT, true, RAX, 3);
            a.instruction(ADDRESS, true, R11, Code(rows, 0));
            a.instruction(ADD, true, RAX, Register(R11));
            // A row has the distances of the program and of the placement from the table.
            a.instruction(LOAD_SIGNED, true, R10, Memory(RAX, 4));
            a.instruction(ADD, true, R10, Register(R11));
            a.instruction(STORE, true, R10, Memory(RSP, 8 * call.table.len() as i32));
            a.instruction(LOAD_SIGNED, true, RAX, Memory(RAX, 0));
            a.instruction(ADD, true, RAX, Register(R11));
            // call rax
            a.bytes(&[0xff, 0xd0]);
            a.constant(RAX, 1);
            a.jump(end);
            a.bind(fail);
            a.constant(RAX, 0);
        }
        Body::Poses { bodies, placed, sizes: (pose, _), links } => {
            a.instruction(STORE, true, RSI, Memory(RSP, RESULTS));
            a.instruction(ADDRESS, true, RSI, Memory(RSP, BODIES));
            a.call(bodies);
            for (link, &(body, placement)) in links.iter().enumerate() {
                let from = BODIES + (body * pose) as i32;
                let to = (link * pose) as i32;
                a.instruction(LOAD, true, RSI, Memory(RSP, RESULTS));
                let Some(placement) = placement else {
                    for part in (0..pose as i32).step_by(16) {
                        a.instruction(LOAD_VECTOR, false, 0, Memory(RSP, from + part));
                        a.instruction(STORE_VECTOR, false, 0, Memory(RSI, to + part));
                    }
                    continue;
                };
                a.instruction(ADDRESS, true, RSI, Memory(RSI, to));
                a.instruction(ADDRESS, true, RAX, Memory(RSP, from));
                a.instruction(STORE, true, RAX, Memory(RSP, 0));
                a.instruction(ADDRESS, true, RAX, Code(placement, 0));
                a.instruction(STORE, true, RAX, Memory(RSP, 8));
                a.copy(RDI, RSP);
                a.call(placed);
            }
        }
        Body::Looped(looped) => looped.append(a),
    }
    a.bind(end);
    if windows {
        vectors(a, LOAD_VECTOR);
        // lea rsp, [rbp - 16]; pop rsi; pop rdi; pop rbp; ret
        a.bytes(&[0x48, 0x8d, 0x65, 0xf0, 0x5e, 0x5f, 0x5d, 0xc3]);
    } else {
        // leave; ret
        a.bytes(&[0xc9, 0xc3]);
    }
    let end = a.code.len();
    Frame { start, end, last: end, kind: FrameKind::Entry { prologue: prologue - start } }
}

/// Stores or loads the vector registers that belong to the caller on Windows.
fn vectors(a: &mut Assembler, opcode: super::assembler::Opcode) {
    for register in KEPT_VECTORS {
        let place = -KEPT + 16 * i32::from(register - KEPT_VECTORS.start);
        a.instruction(opcode, false, register, Memory(RBP, place));
    }
}

/// Returns the register of an argument; one on the stack is loaded into `register`.
fn argument(a: &mut Assembler, convention: Convention, number: usize, register: u8) -> u8 {
    // Above rbp: the caller's rbp and the return address; on Windows room for four arguments, too.
    let (registers, above): (&[u8], usize) = match convention {
        Convention::SystemV => (&[RDI, RSI, RDX, RCX, R8, R9], 16),
        Convention::Windows => (&[RCX, RDX, R8, R9], 16),
    };
    if let Some(&register) = registers.get(number) {
        return register;
    }
    let skipped = if convention == Convention::Windows { 0 } else { registers.len() };
    let place = above + 8 * (number - skipped);
    a.instruction(LOAD, true, register, Memory(RBP, place as i32));
    register
}
