//! Descriptions of stack frames, with which debuggers, profilers and exceptions find the caller of
//! a function: `.eh_frame` for ELF (DWARF 5, section 6.4) and `.pdata` with `.xdata` for COFF ("x64
//! exception handling", Microsoft). In Mach-O files there are none: tools follow rbp there, which
//! every function with a frame keeps as the frame pointer.

use super::convention::{KEPT, KEPT_VECTORS};
use crate::generate::x86_64::{KEEP_BASES, PROLOGUE};

/// A function with a frame, by offsets in the code.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub start: usize,
    /// The offset after its return.
    pub end: usize,
    /// The offset after its last instruction.
    pub last: usize,
    pub kind: FrameKind,
}

/// The registers that a function keeps for its caller.
#[derive(Clone, Copy, Debug)]
pub(super) enum FrameKind {
    /// A program: [`PROLOGUE`], so rbp and rbx, and after [`KEEP_BASES`] r14 and r15.
    Program { keeps_bases: bool },
    /// A helper: none, and it does not move rsp.
    Leaf,
    /// An entry: rbp; on Windows also the registers of `entry.rs`, after this number of bytes.
    Entry { prologue: usize },
}

/// The bytes of `push rbp`, and of `push rbp; mov rbp, rsp`.
const PUSHED: u8 = PROLOGUE[0].len() as u8;
const SET: u8 = PUSHED + PROLOGUE[1].len() as u8;
/// The bytes of a program's prologue.
const SAVED: u8 = SET + PROLOGUE[2].len() as u8;
/// The bytes of a program's prologue with r14, and with r14 and r15.
const SAVED_14: u8 = SAVED + KEEP_BASES[0].len() as u8;
const SAVED_15: u8 = SAVED_14 + KEEP_BASES[1].len() as u8;

/// The numbers of registers in DWARF.
mod dwarf {
    pub const RBX: u8 = 3;
    pub const RBP: u8 = 6;
    pub const RSP: u8 = 7;
    pub const R14: u8 = 14;
    pub const R15: u8 = 15;
    pub const RETURN: u8 = 16;
}

/// Returns the contents of `.eh_frame`, and for each frame the offset at which the distance of its
/// start belongs.
pub(super) fn eh_frame(frames: &[Frame]) -> (Vec<u8>, Vec<usize>) {
    let mut bytes = Vec::new();
    let mut starts = Vec::new();
    // A common entry: version 1, pointers are distances of 4 bytes; code counts in bytes, data in
    // -8 bytes. At the start of a function the frame's address is rsp + 8, and the return address
    // is 8 below it.
    let common = [
        &[0; 4][..],
        &[1, b'z', b'R', 0, 1, 0x78, dwarf::RETURN, 1, 0x1b],
        &[DEFINE, dwarf::RSP, 8, OFFSET | dwarf::RETURN, 1],
    ];
    record(&mut bytes, &common.concat());
    for frame in frames {
        starts.push(bytes.len() + 8);
        // The distance of the common entry, of the start, the length, and no further data.
        let mut entry = (bytes.len() as u32 + 4).to_le_bytes().to_vec();
        entry.extend([0; 4]);
        entry.extend(((frame.last - frame.start) as u32).to_le_bytes());
        entry.push(0);
        entry.extend(instructions(frame));
        record(&mut bytes, &entry);
    }
    (bytes, starts)
}

// The instructions of DWARF.
const ADVANCE: u8 = 0x40;
const ADVANCE_4: u8 = 0x04;
const OFFSET: u8 = 0x80;
const RESTORE: u8 = 0xc0;
const REMEMBER: u8 = 0x0a;
const RESTORE_STATE: u8 = 0x0b;
const DEFINE: u8 = 0x0c;
const DEFINE_REGISTER: u8 = 0x0d;
const DEFINE_OFFSET: u8 = 0x0e;

/// Returns the rules of a frame, from its start on.
fn instructions(frame: &Frame) -> Vec<u8> {
    if let FrameKind::Leaf = frame.kind {
        return Vec::new();
    }
    let mut code = vec![ADVANCE | PUSHED, DEFINE_OFFSET, 16, OFFSET | dwarf::RBP, 2];
    code.extend([ADVANCE | (SET - PUSHED), DEFINE_REGISTER, dwarf::RBP]);
    let mut at = usize::from(SET);
    let mut advance = |code: &mut Vec<u8>, to: usize| {
        code.push(ADVANCE_4);
        code.extend(((to - at) as u32).to_le_bytes());
        at = to;
    };
    let end = frame.end - frame.start;
    match frame.kind {
        FrameKind::Program { keeps_bases } => {
            advance(&mut code, SAVED.into());
            code.extend([OFFSET | dwarf::RBX, 3]);
            if keeps_bases {
                advance(&mut code, SAVED_15.into());
                code.extend([OFFSET | dwarf::R14, 4, OFFSET | dwarf::R15, 5]);
            }
            // After `pop rbx`, which `pop rbp` and `ret` follow. Registers that were popped before
            // have their places still.
            advance(&mut code, end - 2);
            code.extend([REMEMBER, RESTORE | dwarf::RBX]);
            if keeps_bases {
                code.extend([RESTORE | dwarf::R14, RESTORE | dwarf::R15]);
            }
            code.push(ADVANCE | 1);
        }
        FrameKind::Entry { .. } | FrameKind::Leaf => {
            advance(&mut code, end - 1);
            code.push(REMEMBER);
        }
    }
    code.extend([RESTORE | dwarf::RBP, DEFINE, dwarf::RSP, 8, ADVANCE | 1, RESTORE_STATE]);
    code
}

/// Appends a record with its length, at a multiple of 8.
fn record(bytes: &mut Vec<u8>, content: &[u8]) {
    let length = (content.len() + 4).next_multiple_of(8);
    bytes.extend((length as u32 - 4).to_le_bytes());
    bytes.extend(content);
    // Nothing is done.
    bytes.resize(bytes.len() + length - 4 - content.len(), 0);
}

/// Unwind codes number the registers as instructions do.
mod windows {
    pub const RBX: u8 = 3;
    pub const RBP: u8 = 5;
    pub const RSI: u8 = 6;
    pub const RDI: u8 = 7;
    pub const R14: u8 = 14;
    pub const R15: u8 = 15;
}

// The operations of unwind codes.
const PUSH: u8 = 0;
const ALLOCATE_LARGE: u8 = 1;
const ALLOCATE_SMALL: u8 = 2;
const SET_FRAME_POINTER: u8 = 3;
const SAVE: u8 = 4;
const SAVE_VECTOR: u8 = 8;

/// Returns the unwind information of a frame for `.xdata`; none for a leaf, which needs none.
///
/// Saved registers have places relative to rbp minus a multiple of 16. So the function is described
/// as if it had allocated the memory of these registers before it set rbp, which gives the same
/// places.
pub(super) fn unwind_information(frame: &Frame) -> Option<Vec<u8>> {
    let (prologue, below) = match frame.kind {
        FrameKind::Program { keeps_bases: false } => (usize::from(SAVED), 16),
        FrameKind::Program { keeps_bases: true } => (usize::from(SAVED_15), 32),
        FrameKind::Entry { prologue } => (prologue, KEPT),
        FrameKind::Leaf => return None,
    };
    let prologue = u8::try_from(prologue).expect("prologues are short");
    // The last action of the prologue is first. Each code: the offset after the action, the
    // operation and its operand.
    let mut codes: Vec<[u8; 2]> = Vec::new();
    let mut code = |after: u8, operation: u8, operand: u8, more: Option<i32>| {
        codes.push([after, operation | operand << 4]);
        codes.extend(more.map(|more| (more as u16).to_le_bytes()));
    };
    match frame.kind {
        FrameKind::Program { keeps_bases } => {
            if keeps_bases {
                code(SAVED_15, SAVE, windows::R15, Some((below - 24) / 8));
                code(SAVED_14, SAVE, windows::R14, Some((below - 16) / 8));
            }
            code(SAVED, SAVE, windows::RBX, Some((below - 8) / 8));
        }
        FrameKind::Leaf => {}
        FrameKind::Entry { .. } => {
            for register in KEPT_VECTORS.rev() {
                let place = i32::from(register - KEPT_VECTORS.start);
                code(prologue, SAVE_VECTOR, register, Some(place));
            }
            code(SET + 2, SAVE, windows::RSI, Some((below - 16) / 8));
            code(SET + 1, SAVE, windows::RDI, Some((below - 8) / 8));
        }
    }
    code(SET, SET_FRAME_POINTER, 0, None);
    if below <= 128 {
        code(SET, ALLOCATE_SMALL, (below / 8 - 1) as u8, None);
    } else {
        code(SET, ALLOCATE_LARGE, 0, Some(below / 8));
    }
    code(PUSHED, PUSH, windows::RBP, None);
    let frame_pointer = windows::RBP | ((below / 16) as u8) << 4;
    let mut bytes = vec![1, prologue, codes.len() as u8, frame_pointer];
    bytes.extend(codes.as_flattened());
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    Some(bytes)
}
