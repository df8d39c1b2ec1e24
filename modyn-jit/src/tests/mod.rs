//! Tests of instructions and of whole functions. The instructions are decoded by disassemblers that share no code
//! with the encoders; the functions are emulated, or run.

#[cfg(target_arch = "aarch64")]
mod calls_aarch64;
#[path = "../../tests/common/mod.rs"]
pub(crate) mod common;
mod emulated;
mod emulator;
mod encoding;
mod encoding_aarch64;
mod page;
