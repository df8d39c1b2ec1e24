//! Counts the instructions and measures the stack of a call, and writes lines of text without formatting.

use core::ffi::CStr;

use crate::machine;

pub use machine::prepare;

/// The number of repetitions of a call: the clock's tick is longer than an instruction.
const CALLS: u32 = 200;

/// The depth below the caller to which the stack is painted, bytes.
const DEPTH: usize = 32 * 1024;

/// The stack that the painting function itself may use, bytes; a measured depth is at least this.
const MARGIN: usize = 48;

const PAINT: u32 = 0x5afe_c0de;

/// Measures a call of a robot's function and prints the line that `inspect` reads. `state` follows the function's name.
pub fn report(robot: &str, function: &str, state: &str, function_call: &mut dyn FnMut()) {
    let (instructions, stack) = call(function_call);
    let mut line = Line::default();
    line.text("measured ").text(robot).text("::").text(function).text(state);
    line.text(" ").number(instructions).text(" ").number(stack);
    line.print();
}

/// Returns the instructions of one call (rounded to the nearest), and the depth of its stack, bytes. Both include the
/// call itself.
#[inline(never)]
fn call(call: &mut dyn FnMut()) -> (u32, u32) {
    let stack = stack(call);
    let empty = repeated(&mut || {});
    let full = repeated(call);
    ((full.saturating_sub(empty) + CALLS / 2) / CALLS, stack)
}

#[inline(never)]
fn repeated(call: &mut dyn FnMut()) -> u32 {
    let start = machine::instructions();
    for _ in 0..CALLS {
        call();
    }
    machine::since(start)
}

#[inline(never)]
fn stack(call: &mut dyn FnMut()) -> u32 {
    let top = machine::stack_pointer() & !3;
    let (bottom, end) = (top - DEPTH, top - MARGIN);
    paint(bottom, end);
    call();
    (top - lowest(bottom, end)) as u32
}

#[inline(never)]
fn paint(bottom: usize, end: usize) {
    let mut at = bottom;
    while at < end {
        // SAFETY: the words from `bottom` to `end` are RAM that nothing owns: they lie below the
        // stack pointer of this function's caller by more than this function's own frame, above all
        // data (memory.x: megabytes of RAM, a few kilobytes used), and no interrupt is enabled.
        unsafe { (at as *mut u32).write_volatile(PAINT) };
        at += 4;
    }
}

/// Returns the first changed word, from below.
#[inline(never)]
fn lowest(bottom: usize, end: usize) -> usize {
    let mut at = bottom;
    // SAFETY: as in `paint`; any bits are a `u32`.
    while at < end && unsafe { (at as *const u32).read_volatile() } == PAINT {
        at += 4;
    }
    at
}

/// A line of text.
pub struct Line {
    bytes: [u8; 96],
    length: usize,
}

impl Default for Line {
    fn default() -> Self {
        Self { bytes: [0; 96], length: 0 }
    }
}

impl Line {
    fn byte(&mut self, byte: u8) {
        // The last byte stays zero.
        if self.length < 95
            && let Some(place) = self.bytes.get_mut(self.length)
        {
            *place = byte;
            self.length += 1;
        }
    }

    pub fn text(&mut self, text: &str) -> &mut Self {
        text.bytes().for_each(|byte| self.byte(byte));
        self
    }

    pub fn number(&mut self, number: u32) -> &mut Self {
        let mut power = 1_000_000_000;
        while power > 0 {
            if number >= power || power == 1 {
                self.byte(b'0' + (number / power % 10) as u8);
            }
            power /= 10;
        }
        self
    }

    pub fn print(&mut self) {
        self.byte(b'\n');
        if let Ok(text) = CStr::from_bytes_until_nul(&self.bytes) {
            semihosting::sys::arm_compat::sys_write0(text);
        }
    }
}
