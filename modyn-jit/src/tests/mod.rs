//! Tests of the instructions, with a disassembler that shares nothing with the encoder: of single ones, and of whole
//! functions, which are emulated.

#[path = "../../tests/common/mod.rs"]
mod common;
mod emulated;
mod emulator;
mod encoding;
