//! The functions that JavaScript calls.
//!
//! A request is written into the memory that `input` returns, and `run` answers it. Only the
//! attribute `no_mangle` is unsafe: two libraries that export one name would not be one program.
//! This module is never linked with another one. All code is safe: JavaScript writes to the memory
//! between two calls, when Rust has no reference to it.

#![allow(unsafe_code)]

use std::cell::RefCell;

use crate::Session;

#[derive(Default)]
struct State {
    input: Vec<u8>,
    answer: String,
    session: Session,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
    /// The message of a panic, after which nothing but this is read.
    static FAULT: RefCell<String> = RefCell::default();
}

/// Returns the memory for a request of this many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn input(length: usize) -> *mut u8 {
    std::panic::set_hook(Box::new(|panic| {
        FAULT.with(|fault| *fault.borrow_mut() = panic.to_string());
    }));
    STATE.with_borrow_mut(|state| {
        state.input.clear();
        state.input.resize(length, 0);
        state.input.as_mut_ptr()
    })
}

/// Answers the request, whose JSON has this many bytes and is followed by the bytes of a file.
/// Returns the length of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn run(json: usize) -> usize {
    STATE.with_borrow_mut(|State { input, answer, session }| {
        let (json, bytes) = input.split_at(json.min(input.len()));
        *answer = session.answer(&String::from_utf8_lossy(json), bytes);
        answer.len()
    })
}

/// Returns the place of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    STATE.with_borrow(|state| state.answer.as_ptr())
}

/// Returns the length of the message of a panic.
#[unsafe(no_mangle)]
pub extern "C" fn fault_length() -> usize {
    FAULT.with(|fault| fault.borrow().len())
}

/// Returns the place of the message of a panic.
#[unsafe(no_mangle)]
pub extern "C" fn fault() -> *const u8 {
    FAULT.with(|fault| fault.borrow().as_ptr())
}
