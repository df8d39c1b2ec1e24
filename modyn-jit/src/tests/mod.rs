//! Tests of instructions and of whole functions. The instructions are decoded by a disassembler that shares no code
//! with the encoder; the functions are emulated.

#[path = "../../tests/common/mod.rs"]
pub(crate) mod common;
mod emulated;
mod emulator;
mod encoding;
mod page;
